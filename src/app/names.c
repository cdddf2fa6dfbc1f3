/* names.c: names of outputs, and of the bodies of a time series; see app.h. */
#include <string.h>

#include "app/app.h"
#include "base/text.h"
#include "model/model.h"

char *app_default_name(const char *deck, const char *ending) {
  const char *slash = strrchr(deck, '/'), *name = slash ? slash + 1 : deck;
  if (strcmp(deck, "-") == 0) name = "stdin";
  const char *dot = strrchr(name, '.');
  size_t length = dot && dot > name ? (size_t)(dot - name) : strlen(name);
  return format_text("%.*s.%s", (int)length, name, ending);
}

sd_status frames_source_open(const frames *f, size_t k, h5_file **out, sd_messages *messages) {
  const char *path = f->sources[k].path;
  *out = f->base;
  return strcmp(path, f->path) == 0 ? SD_OK : h5_open_again(path, out, messages);
}

void frames_source_close(const frames *f, h5_file *file) {
  if (file != f->base) h5_close(file, NULL);
}

uint32_t stored_body(const sd_model *m, const h5_file *file, const observable *o, size_t k) {
  bool watched = o->width == OBSERVABLE_WATCHED, chosen = o->width == OBSERVABLE_CHOSEN;
  uint32_t body = UINT32_MAX;
  if (o->width == OBSERVABLE_WALLS) return (uint32_t)(m->n_disks + k);
  if (!watched && !chosen) return body;
  const char *path = watched ? "/observables/watched_disks" : "/observables/contact_disks";
  if (file && h5_exists(file, path)) {
    h5_get_values(file, path, SD_U32, k, 1, 1, &body, NULL);
    return body;
  }
  if (watched && k < m->n_rotations) body = m->rotations[k];
  if (chosen && k < m->n_contact_disks) body = m->contact_disks[k];
  return body;
}

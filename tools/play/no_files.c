/* no_files.c: stands for src/io/store where there are neither files nor HDF5. Files that a deck
 * names are texts that the page has given; results of runs cannot be read. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "io/store/h5.h"

#define EXPORT(name) __attribute__((export_name(#name)))

/* --- texts in place of files ------------------------------------------------------------------ */

typedef struct given {
  char *name, *text;
} given;

static given *all;
static size_t n_all;

static const given *find(const char *path) {
  for (size_t k = 0; k < n_all; k++)
    if (strcmp(all[k].name, path) == 0) return &all[k];
  return NULL;
}

/* Forgets all texts. */
EXPORT(play_no_files) void play_no_files(void) {
  for (size_t k = 0; k < n_all; k++) {
    free(all[k].name);
    free(all[k].text);
  }
  n_all = 0;
}

/* Gives the text of a file. */
EXPORT(play_file) void play_file(const char *name, const char *text) {
  all = memory_grow(all, n_all + 1, sizeof *all);
  all[n_all++] = (given){memory_text(name), memory_text(text)};
}

bool file_exists(const char *path) { return find(path) != NULL; }
bool file_is_folder(const char *path) { return (void)path, false; }
bool file_is_within(const char *path, const char *folder) { return (void)path, (void)folder, true; }
char *file_hint(const char *path) { return (void)path, memory_text(""); }
const char *file_error_text(int error) { return (void)error, "the page has not given this file"; }

sd_status file_text(const char *path, uint64_t most, char **text, char trouble[FILE_TROUBLE]) {
  const given *g = find(path);
  const bool fits = g && strlen(g->text) <= most;
  *text = fits ? memory_text(g->text) : NULL;
  if (!fits) strcpy(trouble, g ? "it is too large" : file_error_text(ENOENT));
  return fits ? SD_OK : SD_ERROR_USER;
}

/* The descriptor of a text is its index. */
int file_open_quiet(const char *path, uint64_t *size) {
  const given *g = find(path);
  *size = g ? strlen(g->text) : 0;
  errno = ENOENT;
  return g ? (int)(g - all) : -1;
}

bool file_read_at(int fd, uint64_t at, void *bytes, size_t n, size_t *have) {
  const size_t size = strlen(all[fd].text), first = at < size ? (size_t)at : size;
  *have = n < size - first ? n : size - first;
  memcpy(bytes, all[fd].text + first, *have);
  return true;
}

/* --- HDF5, which is not there ----------------------------------------------------------------- */

/* A file cannot be opened, so that the functions that read one are never called. */

static sd_status absent(const char *path, sd_messages *messages) {
  return sd_fail(messages, SD_ERROR_IO, "%s: this build of slipdisk reads no HDF5 files", path);
}

bool h5_is_file(const char *path) { return (void)path, false; }
char *h5_only_particles(const char *path) { return (void)path, NULL; }

sd_status h5_open(const char *path, h5_file **out, sd_messages *messages) {
  *out = NULL;
  return absent(path, messages);
}

sd_status h5_open_whole(const char *path, h5_file **out, sd_messages *messages) {
  return h5_open(path, out, messages);
}

sd_status h5_open_again(const char *path, h5_file **out, sd_messages *messages) {
  return h5_open(path, out, messages);
}

sd_status h5_verify(const char *path, bool *sealed, uint64_t *sum, sd_messages *messages) {
  *sealed = false;
  *sum = 0;
  return absent(path, messages);
}

sd_status h5_read_table(const char *file, const char *dataset, size_t n_columns,
                        const char *const *columns, double **values, h5_range *rows,
                        sd_messages *messages) {
  (void)dataset, (void)n_columns, (void)columns, (void)rows;
  *values = NULL;
  return absent(file, messages);
}

sd_status h5_close(h5_file *file, sd_messages *messages) {
  return (void)file, (void)messages, SD_OK;
}

bool h5_exists(const h5_file *file, const char *path) { return (void)file, (void)path, false; }

sd_status h5_check(const h5_file *file, const char *path, size_t n, sd_messages *messages) {
  return (void)file, (void)n, absent(path, messages);
}

sd_status h5_shape(const h5_file *file, const char *path, int *rank, size_t *dims,
                   sd_messages *messages) {
  (void)file, (void)rank, (void)dims;
  return absent(path, messages);
}

sd_status h5_get(const h5_file *file, const char *path, sd_type type, size_t n, void *data,
                 sd_messages *messages) {
  (void)file, (void)type, (void)n, (void)data;
  return absent(path, messages);
}

sd_status h5_get_values(const h5_file *file, const char *path, sd_type type, size_t first, size_t n,
                        size_t width, void *data, sd_messages *messages) {
  (void)file, (void)type, (void)first, (void)n, (void)width, (void)data;
  return absent(path, messages);
}

void *h5_column(const h5_file *file, const char *path, sd_type type, size_t n, sd_status *status,
                sd_messages *messages) {
  (void)file, (void)type, (void)n;
  *status = absent(path, messages);
  return NULL;
}

char *h5_get_text(const h5_file *file, const char *path) { return (void)file, (void)path, NULL; }

char *h5_get_attr_text(const h5_file *file, const char *path, const char *name) {
  return (void)file, (void)path, (void)name, NULL;
}

double h5_get_attr_f64(const h5_file *file, const char *path, const char *name, double otherwise) {
  return (void)file, (void)path, (void)name, otherwise;
}

int64_t h5_get_attr_i64(const h5_file *file, const char *path, const char *name,
                        int64_t otherwise) {
  return (void)file, (void)path, (void)name, otherwise;
}

sd_status h5_particles_box(const h5_file *file, bool *found, h5_box *box, sd_messages *messages) {
  (void)file, (void)box, (void)messages;
  *found = false;
  return SD_OK;
}

/* view_deck.c: writes the page that shows how the run of a deck would begin: one frame, with all
 * pairs that overlap. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "app/json.h"
#include "app/view/view.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/deck/deck.h"
#include "model/overlaps.h"

/* Largest number of overlaps recorded for one disk: n disks at the same position would give
 * n^2/2. */
enum { MOST_OF_A_DISK = 32 };
/* Overlaps smaller than this fraction of the radius of the smaller disk are ignored: rounding
 * errors cause them between touching disks of a lattice. */
static const double ROUNDING = 1e-9;

/* Search for overlaps at the start. It runs twice: first to count the overlaps, then to record
 * them. */
typedef struct start {
  const sd_model *m;
  frame_data *f;
  bool counting;
  size_t n, too_deep;
  /* Disk a of the last overlap found; of_last: number of overlaps found of this disk so far */
  uint32_t last;
  int of_last;
  overlap worst;
  double relative; /* Depth of the worst overlap divided by the radius of the smaller disk */
} start;

static bool is_driven(const sd_model *m, uint32_t body) {
  return body >= m->n_disks || m->disks[body].driven;
}

static bool waits(const sd_model *m, uint32_t body) {
  return body < m->n_disks && m->disks[body].waiting;
}

static void note(start *s, const overlap *o) {
  const sd_model *m = s->m;
  double relative = o->depth / m->disks[o->a].radius;
  s->f->a[s->n] = o->a;
  s->f->b[s->n] = o->b;
  s->f->overlap[s->n] = o->depth;
  s->f->force[s->n] = overlap_force(m, o);
  s->too_deep += relative > m->max_overlap;
  if (relative <= s->relative) return;
  s->relative = relative;
  s->worst = *o;
}

static bool see(void *user, const overlap *o) {
  start *s = user;
  bool still = is_driven(s->m, o->a) && is_driven(s->m, o->b);
  if (o->depth <= ROUNDING * s->m->disks[o->a].radius) return false;
  if ((still && !o->coincident) || waits(s->m, o->a) || waits(s->m, o->b)) return false;
  s->of_last = o->a == s->last ? s->of_last + 1 : 1;
  s->last = o->a;
  if (!s->counting) note(s, o);
  s->n++;
  return s->of_last >= MOST_OF_A_DISK;
}

static sd_status find_overlaps(start *s, sd_messages *messages) {
  s->n = 0;
  s->last = UINT32_MAX;
  sd_status status = overlaps_of_disks(s->m, see, s);
  s->last = UINT32_MAX;
  if (status == SD_OK) overlaps_with_walls(s->m, see, s);
  return status == SD_OK ? SD_OK : sd_fail(messages, SD_ERROR_IO, "no memory to look for overlaps");
}

static double in_box(const sd_model *m, double x, int c) {
  double length = m->upper[c] - m->lower[c];
  return m->periodic[c] && length > 0 ? x - floor((x - m->lower[c]) / length) * length : x;
}

/* Fills a frame with the positions and velocities that the deck gives. */
static void place_bodies(const sd_model *m, frame_data *f) {
  for (size_t k = 0; k < m->n_disks; k++) {
    const sd_disk *d = &m->disks[k];
    for (int c = 0; c < 2; c++) {
      f->position[k][c] = in_box(m, d->position[c], c);
      f->velocity[k][c] = d->velocity[c];
    }
    f->angle[k] = d->position[SD_THETA];
    f->spin[k] = d->velocity[SD_THETA];
    f->activity[k] = d->waiting ? SD_WAITING : SD_IN_PLAY;
  }
  for (size_t w = 0; w < m->n_walls; w++)
    for (int c = 0; c < 2; c++) f->position[m->n_disks + w][c] = m->walls[w].pivot[c];
}

static sd_status make_frame(start *s, frame_data *f, sd_messages *messages) {
  sd_status status = frame_data_new(f, s->m->n_disks, s->m->n_walls, messages);
  if (status != SD_OK) return status;
  place_bodies(s->m, f);
  s->f = f;
  s->counting = true;
  status = find_overlaps(s, messages);
  if (status == SD_OK) status = frame_data_contacts(f, s->n, messages);
  s->counting = false;
  return status == SD_OK ? find_overlaps(s, messages) : status;
}

/* --- page ------------------------------------------------------------------------------------- */

static void tell(json_t *meta, const char *level, const char *text, json_t *disks) {
  json_array_append_new(
      json_object_get(meta, "messages"),
      json_pack("{s:s, s:o, s:o}", "level", level, "text", json_text(text), "disks", disks));
}

static void tell_overlaps(json_t *meta, const start *s) {
  char one[96], two[96];
  if (s->n == 0) return;
  char *text = format_text(
      "%zu pair%s overlap%s, %zu too deep (more than max_overlap = %g of the radius); the "
      "deepest: %s and %s by %.3g, "
      "%.3g of the radius",
      s->n, s->n == 1 ? "" : "s", s->n == 1 ? "s" : "", s->too_deep, s->m->max_overlap,
      sd_model_body_name(s->m, s->worst.a, one, sizeof one),
      sd_model_body_name(s->m, s->worst.b, two, sizeof two), s->worst.depth, s->relative);
  json_t *disks = json_pack("[I]", (json_int_t)s->worst.a);
  if (s->worst.b < s->m->n_disks) json_array_append_new(disks, json_integer(s->worst.b));
  tell(meta, s->too_deep > 0 ? "error" : "note", text, disks);
  free(text);
}

/* Returns a text about disks that rain has not released yet; the caller frees it. NULL: there are
 * none. */
static char *waiting_text(const sd_model *m) {
  size_t n = 0;
  for (size_t k = 0; k < m->n_disks; k++) n += m->disks[k].waiting;
  return n > 0
             ? format_text("%zu disk%s and fall in while it runs", n, n == 1 ? " waits" : "s wait")
             : NULL;
}

static json_t *describe(const sd_model *m, const start *s, const char *source,
                        const sd_messages *found) {
  json_t *meta = view_meta(m, "deck", m->title, source);
  view_meta_phases(meta, m);
  for (size_t k = 0; k < sd_messages_count(found); k++)
    tell(meta, sd_messages_kind(found, k) == SD_OK ? "warning" : "error",
         sd_messages_text(found, k), json_array());
  tell_overlaps(meta, s);
  char *waiting = waiting_text(m);
  if (waiting) tell(meta, "note", waiting, json_array());
  free(waiting);
  json_object_set_new(meta, "max_overlap", json_number(m->max_overlap));
  json_object_set_new(meta, "frames", json_integer(1));
  json_object_set_new(meta, "stored_frames", json_integer(1));
  return meta;
}

static sd_status write_page(const char *path, const sd_model *m, frame_data *f, const json_t *meta,
                            sd_messages *messages) {
  view_page page;
  view_chunk c;
  sd_status status = view_page_open(&page, path, meta, messages);
  if (status == SD_OK) {
    view_static(&c, m, NULL, NULL, true);
    status = view_page_add(&page, "static", &c, messages);
  }
  if (status == SD_OK) {
    view_turns(f, m, NULL);
    view_frame(&c, m, f, true);
    status = view_page_add(&page, "frame", &c, messages);
  }
  return view_page_close(&page, status, messages);
}

static void say(const sd_model *m, size_t overlaps) {
  char *waiting = waiting_text(m);
  printf("%zu disk%s, %zu wall%s, %zu pair%s overlap%s%s%s\n", m->n_disks,
         m->n_disks == 1 ? "" : "s", m->n_walls, m->n_walls == 1 ? "" : "s", overlaps,
         overlaps == 1 ? "" : "s", overlaps == 1 ? "s" : "", waiting ? "; " : "",
         waiting ? waiting : "");
  free(waiting);
}

static sd_status show(const view_options *o, const sd_model *m, const char *path,
                      sd_messages *messages) {
  frame_data f = {0};
  start s = {.m = m};
  sd_status status = make_frame(&s, &f, messages);
  json_t *meta = status == SD_OK ? describe(m, &s, o->name, messages) : NULL;
  if (status == SD_OK) status = write_page(path, m, &f, meta, messages);
  if (status == SD_OK) say(m, s.n);
  json_decref(meta);
  frame_data_free(&f);
  return status;
}

sd_status view_deck(const view_options *o, char **path, bool *made, sd_messages *messages) {
  sd_model *m = NULL;
  sd_status loaded = deck_look(o->name, o->overrides.n, o->overrides.item, &m, messages);
  if (!m) return loaded;
  *path = o->output ? memory_text(o->output) : app_default_name(o->name, "start.html");
  if (loaded == SD_OK) sd_model_advise(m, messages);
  const sd_status status = show(o, m, *path, messages);
  *made = status == SD_OK;
  sd_model_free(m);
  return status == SD_OK ? loaded : status;
}

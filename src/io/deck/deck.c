/* deck.c: builds a finished model from a deck (input file); see slipdisk/deck.h and deck_tree.h. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/message.h"
#include "base/text.h"
#include "io/deck/deck.h"
#include "io/deck/deck_expression.h"
#include "io/deck/deck_read.h"
#include "io/deck/deck_result.h"
#include "model/advice.h"
#include "model/motions.h"
#include "slipdisk/deck.h"

/* --- keys of the deck itself ------------------------------------------------------------------ */

static void read_gravity(deck *d) {
  deck_group g;
  if (!deck_enter_one(d, &deck_gravity, &g)) return;
  double strength = deck_number(&g, "g"), tilt = deck_number(&g, "tilt");
  const deck_node *written = deck_get(&g, "tilt");
  if (written->type == DECK_FLOAT) deck_warn_tilt(d, tilt, written->place, d->messages);
  double sine, cosine;
  math_sine_cosine(tilt, &sine, &cosine);
  d->model->gravity[0] = -strength * sine;
  d->model->gravity[1] = -strength * cosine;
  /* Avoid -0 from the lines above */
  if (strength == 0) d->model->gravity[0] = d->model->gravity[1] = 0;
}

static void read_limits(deck *d) {
  deck_group g;
  /* Without the group, the limits set by sd_model_new stay */
  if (!deck_child(d->root, "limits")) return;
  if (deck_enter_one(d, &deck_limits, &g)) deck_fill(&g, &d->model->limits);
}

/* Checks the group `sweep`, counts its points (sets of parameter values), and removes the group
 * from the tree, since the model is built from the deck's own values. point: the deck is read for
 * one point, so the group is removed without the check. */
static void read_sweep(deck *d, bool point) {
  if (!point) d->model->deck->sweep_points = deck_sweep_count(d);
  deck_remove(d->root, deck_child(d->root, "sweep"));
}

/* Reads all groups. The order matters: motions refer to bodies, and phases to motions. */
static void read_all(deck *d, bool point) {
  deck_group top;
  /* Number of errors reported so far, by the scanner and in -D settings; the scanner has put 1 or
   * "" in place of each wrong value */
  size_t scanned = d->reported;
  deck_read_constants(d);
  if (deck_enter(d, d->root, &deck_top, &top)) {
    deck_fill(&top, d->model);
    d->model->deck->checkpoint_seconds = deck_number(&top, "checkpoint");
  }
  read_gravity(d);
  deck_read_box(d);
  deck_read_materials(d);
  deck_read_container(d);
  deck_read_disks(d);
  deck_read_walls(d);
  deck_container_bodies(d);
  deck_read_packings(d);
  deck_agree_on_errors(d);
  deck_read_memories(d);
  deck_agree_on_errors(d);
  deck_read_forces(d);
  deck_read_locks(d);
  deck_read_clumps(d);
  deck_read_motions(d);
  deck_read_fields(d);
  deck_read_holds(d);
  if (model_find_driven(d->model) != SD_OK) longjmp(d->out_of_memory, 1);
  deck_read_bounds(d);
  deck_read_phases(d);
  deck_check_motions(d);
  deck_read_measure(d);
  deck_read_until(d);
  read_limits(d);
  read_sweep(d, point);
  deck_check_laws(d);
  if (d->reported == 0) deck_check_constants(d);
  d->readable = d->reported == 0;
  if (scanned == 0) deck_check_overlaps(d);
}

/* --- loading ---------------------------------------------------------------------------------- */

static char *join_settings(size_t n, const deck_setting *settings) {
  char *text = memory_text("");
  for (size_t k = 0; k < n; k++) text = append_text(text, "%s\n", settings[k].text);
  return text;
}

/* Checks and finishes the model, and stores the full deck (with all defaults) in it. suits: an
 * additional check of the finished model; NULL: none. */
static sd_status finish(deck *d, deck_suits *suits) {
  deck_agree_on_errors(d);
  if (d->reported > 0 || d->wrong) return SD_ERROR_USER;
  d->found = sd_messages_new();
  sd_status status = sd_model_finish(d->model, d->found);
  if (status == SD_OK && suits) status = suits(d->model, d->found);
  deck_report_model_messages(d, d->found);
  if (status != SD_OK) return status;
  char *unstable = advice_unstable(d->model);
  if (unstable) deck_fail_child(d, d->root, "dt", "%s", unstable);
  free(unstable);
  if (d->reported > 0) return SD_ERROR_USER;
  deck_echo_files(d);
  d->model->deck->full = deck_echo(d);
  return SD_OK;
}

typedef struct model_task {
  size_t n_settings;
  const deck_setting *settings;
  /* point: the deck is loaded for one point of its sweep. unfinished: return the model even if the
   * final checks fail */
  bool point, unfinished;
  bool endless; /* the deck need not say how long the run is (deck.endless) */
  /* Communicator of the ranks that read the deck together; NULL: a single process */
  const comm *comm;
  /* whole: receives the reason if the disks must be on every rank and the deck must be read again;
   * why: that reason, during the second reading */
  const char **whole, *why;
  deck_suits *suits;
  sd_model *model;
} model_task;

static sd_status make_model(deck *d, void *user) {
  model_task *t = user;
  d->comm = t->comm;
  d->endless = t->endless;
  d->whole = t->whole;
  d->why = t->why;
  d->model = sd_model_new();
  d->model->comm = d->comm;
  sd_deck *own = d->model->deck = memory_new(1, sizeof *own);
  own->path = memory_text(d->path);
  own->text = memory_text(d->text);
  own->overrides = join_settings(t->n_settings, t->settings);
  read_all(d, t->point);
  sd_status status = finish(d, t->suits);
  bool given = status == SD_OK || (t->unfinished && d->readable);
  t->model = given ? d->model : NULL;
  if (given) d->model = NULL;
  return status;
}

sd_status deck_load(const char *text, const char *path, size_t n_settings,
                    const deck_setting *settings, bool point, sd_model **out,
                    sd_messages *messages) {
  model_task t = {.n_settings = n_settings, .settings = settings, .point = point};
  sd_status status = deck_open(text, path, n_settings, settings, make_model, &t, messages);
  *out = t.model;
  return status;
}

/* Loads a deck from its text. how: options of the loading; its members n_settings and settings are
 * filled in here. */
static sd_status load_text(const char *text, const char *path, size_t n_overrides,
                           const char *const *overrides, model_task how, sd_model **out,
                           sd_messages *messages) {
  deck_setting *settings = memory_new(n_overrides, sizeof *settings);
  *out = NULL;
  for (size_t k = 0; k < n_overrides; k++) settings[k].text = overrides[k];
  how.n_settings = n_overrides;
  how.settings = settings;
  sd_status status = deck_open(text, path, n_overrides, settings, make_model, &how, messages);
  *out = how.model;
  free(settings);
  return status;
}

static sd_status load(const char *path, size_t n_overrides, const char *const *overrides,
                      model_task how, sd_model **out, sd_messages *messages) {
  sd_status status;
  char *text = deck_file_text(path, messages, &status);
  *out = NULL;
  if (text) status = load_text(text, deck_source(path), n_overrides, overrides, how, out, messages);
  free(text);
  return status;
}

/* Arguments of sd_deck_load and sd_deck_load_text, and their result. */
typedef struct load_task {
  const char *text, *path; /* text: NULL: that of the file */
  size_t n_overrides;
  const char *const *overrides;
  sd_model **out;
  sd_messages *messages;
  sd_status status;
} load_task;

static void load_deck(void *task) {
  load_task *t = task;
  const model_task how = {.endless = true};
  t->status =
      t->text ? load_text(t->text, t->path, t->n_overrides, t->overrides, how, t->out, t->messages)
              : load(t->path, t->n_overrides, t->overrides, how, t->out, t->messages);
}

static sd_status try_load(load_task t) {
  *t.out = NULL;
  return memory_try(load_deck, &t) ? t.status : fail_memory(t.messages);
}

sd_status sd_deck_load_text(const char *text, const char *path, size_t n_overrides,
                            const char *const *overrides, sd_model **out, sd_messages *messages) {
  return try_load((load_task){text, path, n_overrides, overrides, out, messages, SD_OK});
}

sd_status sd_deck_load(const char *path, size_t n_overrides, const char *const *overrides,
                       sd_model **out, sd_messages *messages) {
  return try_load((load_task){NULL, path, n_overrides, overrides, out, messages, SD_OK});
}

sd_status deck_load_run(const char *path, size_t n_overrides, const char *const *overrides,
                        sd_model **out, sd_messages *messages) {
  return load(path, n_overrides, overrides, (model_task){0}, out, messages);
}

sd_status deck_look(const char *path, size_t n_overrides, const char *const *overrides,
                    sd_model **out, sd_messages *messages) {
  return load(path, n_overrides, overrides, (model_task){.unfinished = true}, out, messages);
}

/* Warns that every rank makes all tiles of a packing, or reads a file of disks as a whole, for the
 * reason `why`. For a file it warns only if the file is so large that memory matters. */
static void warn_of_whole(const sd_tiles *t, const char *why, sd_messages *messages) {
  enum { LARGE = 1000000 };
  if (t->of_file && t->count >= LARGE)
    sd_warn(messages, "disk_files[%zu].file: every rank reads all, since %s", t->entry, why);
  if (t->n > 0 && !t->of_file)
    sd_warn(messages, "packings[%zu].tiles: every rank makes all, since %s", t->entry, why);
}

sd_status deck_load_for_ranks(const comm *c, const char *text, const char *path, size_t n_overrides,
                              const char *const *overrides, deck_suits *suits, sd_model **out,
                              sd_messages *messages) {
  const char *why = NULL;
  sd_messages *own = sd_messages_new();
  model_task how = {.comm = c, .suits = suits, .whole = &why};
  sd_status status = load_text(text, path, n_overrides, overrides, how, out, own);
  if (why) {
    sd_messages_clear(own);
    how.whole = NULL;
    how.why = why;
    status = load_text(text, path, n_overrides, overrides, how, out, own);
    if (*out) warn_of_whole(&(*out)->tiles, why, own);
  }
  for (size_t k = 0; k < sd_messages_count(own); k++)
    sd_fail(messages, sd_messages_kind(own, k), "%s", sd_messages_text(own, k));
  sd_messages_free(own);
  status = comm_agree(c, status);
  if (status == SD_OK) return status;
  sd_model_free(*out);
  *out = NULL;
  return status;
}

/* --- sweeps ----------------------------------------------------------------------------------- */

typedef struct reading {
  deck_sweep *out;
  sd_messages *messages; /* Receives the warnings if the sweep has no errors */
} reading;

static sd_status read_sweep_deck(deck *d, void *user) {
  const reading *r = user;
  r->out->deck_text = memory_text(d->text);
  return deck_sweep_read(d, r->out, r->messages) ? SD_OK : SD_ERROR_USER;
}

static sd_status load_sweep(const char *text, deck_sweep *s, sd_messages *messages) {
  deck_setting *settings = memory_new(s->n_overrides, sizeof *settings);
  for (size_t k = 0; k < s->n_overrides; k++) settings[k].text = s->overrides[k];
  sd_messages *mine = sd_messages_new();
  reading r = {s, messages};
  sd_status status =
      deck_open(text, s->deck_path, s->n_overrides, settings, read_sweep_deck, &r, mine);
  if (status != SD_OK) {
    /* The deck with its own values has the same errors, and perhaps more: load it to report all at
     * once */
    sd_model *model;
    sd_status again =
        deck_load(text, s->deck_path, s->n_overrides, settings, false, &model, messages);
    sd_model_free(model);
    /* If the deck can be loaded, the sweep failed because memory ran out; it still has no points */
    status =
        again != SD_OK ? again : sd_fail(messages, SD_ERROR_IO, "%s: out of memory", s->deck_path);
  }
  sd_messages_free(mine);
  free(settings);
  return status;
}

sd_status deck_sweep_load(const char *path, size_t n_overrides, const char *const *overrides,
                          deck_sweep *out, sd_messages *messages) {
  *out = (deck_sweep){.deck_path = memory_text(deck_source(path))};
  out->overrides = memory_new(n_overrides, sizeof *out->overrides);
  sd_status status;
  char *text = deck_file_text(path, messages, &status);
  if (!text) return status;
  for (size_t k = 0; k < n_overrides; k++)
    out->overrides[out->n_overrides++] = memory_text(overrides[k]);
  status = load_sweep(text, out, messages);
  free(text);
  return status;
}

sd_status deck_sweep_model(const deck_sweep *s, size_t point, sd_model **out,
                           sd_messages *messages) {
  const sweep_point *p = &s->points[point];
  size_t n = s->n_overrides + p->n_overrides;
  deck_setting *all = memory_new(n, sizeof *all);
  *out = NULL;
  for (size_t k = 0; k < s->n_overrides; k++) all[k].text = s->overrides[k];
  for (size_t k = 0; k < p->n_overrides; k++)
    all[s->n_overrides + k] =
        (deck_setting){p->overrides[k], {p->places[k].file, p->places[k].line}};
  sd_status status = deck_load(s->deck_text, s->deck_path, n, all, true, out, messages);
  free(all);
  return status;
}

/* deck.c: from a deck to a finished model; see slipdisk/deck.h and deck_tree.h. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/deck/deck_expression.h"
#include "io/deck/deck_parts.h"
#include "io/deck/deck_read.h"
#include "io/deck/deck_result.h"
#include "io/deck/deck.h"
#include "io/store/file.h"
#include "model/advice.h"
#include "model/motions.h"
#include "model/rows.h"
#include "slipdisk/deck.h"

/* --- the keys of the deck itself --------------------------------------------------------------------------- */

void deck_warn_tilt(const deck *d, double tilt, deck_place place, sd_messages *messages) {
  if (!(fabs(tilt) > M_PI / 2)) return;
  char line[24] = "";
  if (place.line > 0) snprintf(line, sizeof line, ":%d", place.line);
  sd_warn(
      messages,
      "%s%s: gravity.tilt = %.10g: more than a right angle; angles are in radians, degrees are \"%.10g deg\"",
      place.file ? place.file : d->path, line, tilt, tilt);
}

static void read_gravity(deck *d) {
  deck_group g;
  if (!deck_enter_one(d, &deck_gravity, &g)) return;
  double strength = deck_number(&g, "g"), tilt = deck_number(&g, "tilt");
  const deck_node *written = deck_get(&g, "tilt");
  if (written->type == DECK_FLOAT) deck_warn_tilt(d, tilt, written->place, d->messages);
  d->model->gravity[0] = -strength * sin(tilt);
  d->model->gravity[1] = -strength * cos(tilt);
  if (strength == 0) d->model->gravity[0] = d->model->gravity[1] = 0; /* and not -0 */
}

static void read_limits(deck *d) {
  deck_group g;
  if (!deck_child(d->root, "limits")) return; /* those of sd_model_new */
  if (deck_enter_one(d, &deck_limits, &g)) deck_fill(&g, &d->model->limits);
}

/* Edges from the file that the key `file` names, which is read when they are first asked for. */
typedef struct file_edges {
  bool tried, found;
  double lower[2], upper[2];
} file_edges;

static bool file_edge(deck_group *g, file_edges *from, int c, double edge[2]) {
  const char *name = deck_text_of(g, "file"), *key = c ? "y" : "x";
  const deck_node *file = deck_get(g, "file");
  if (!file) deck_fail_key(g, key, "missing: expected (lower, upper), since the box is periodic in %s", key);
  if (!file || !name) return false;
  if (!from->tried)
    from->found = deck_file_format(g->d, name) == DECK_HDF5
                      ? deck_result_box(g->d, file, from->lower, from->upper)
                      : deck_lammps_box(g->d, file, from->lower, from->upper);
  from->tried = true;
  if (!from->found) return false;
  edge[0] = from->lower[c];
  edge[1] = from->upper[c];
  if (edge[1] > edge[0]) {
    deck_default_pair(g, key, edge);
    return true;
  }
  deck_fail(g->d, file, "the box of this file is not periodic in %s", key);
  return false;
}

void deck_read_box(deck *d) {
  sd_model *m = d->model;
  deck_group g;
  if (!deck_enter_one(d, &deck_box, &g)) return;
  int periodic = deck_choice(&g, "periodic");
  for (int c = 0; c < 2; c++) m->periodic[c] = periodic > 0 && periodic >> c & 1;
  file_edges from = {0};
  for (int c = 0; c < 2; c++) {
    const char *key = c ? "y" : "x";
    double edge[2];
    bool given = deck_pair(&g, key, edge);
    if (!given && m->periodic[c] && !deck_get(&g, key)) given = file_edge(&g, &from, c, edge);
    if (!given) continue;
    if (!(edge[1] > edge[0])) deck_fail_key(&g, key, "expected (lower, upper) with lower < upper");
    m->lower[c] = m->region_lower[c] = edge[0];
    m->upper[c] = m->region_upper[c] = edge[1];
  }
}

/* Checked and counted; the model is that of the deck as it stands. */
static void read_sweep(deck *d, bool point) {
  if (!point) d->model->deck->sweep_points = deck_sweep_count(d);
  deck_remove(d->root, deck_child(d->root, "sweep"));
}

/* The order matters: motions speak of bodies, phases of motions. */
static void read_all(deck *d, bool point) {
  deck_group top;
  size_t scanned = d->reported; /* what was wrong in the text itself stands as 1 or "" in the tree */
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
  deck_meet(d);
  deck_read_memories(d);
  deck_meet(d);
  deck_read_forces(d);
  deck_read_locks(d);
  deck_read_clumps(d);
  deck_read_motions(d);
  deck_read_fields(d);
  if (model_find_driven(d->model) != SD_OK) longjmp(d->out_of_memory, 1);
  deck_read_bounds(d);
  deck_read_phases(d);
  deck_check_motions(d);
  deck_read_measure(d);
  deck_read_until(d);
  read_limits(d);
  read_sweep(d, point);
  deck_check_laws(d);
  d->readable = d->reported == 0;
  if (scanned == 0) deck_check_overlaps(d);
}

/* --- loading ------------------------------------------------------------------------------------------------ */

static char *join_settings(size_t n, const deck_setting *settings) {
  char *text = memory_text("");
  for (size_t k = 0; k < n; k++) text = append_text(text, "%s\n", settings[k].text);
  return text;
}

/* suits: what else is asked of the model; NULL: nothing. */
static sd_status finish(deck *d, deck_suits *suits) {
  deck_meet(d);
  if (d->reported > 0 || d->wrong) return SD_ERROR_USER;
  d->found = sd_messages_new();
  sd_status status = sd_model_finish(d->model, d->found);
  if (status == SD_OK && suits) status = suits(d->model, d->found);
  deck_tell(d, d->found);
  if (status != SD_OK) return status;
  char *unstable = advice_unstable(d->model);
  if (unstable) deck_fail_child(d, d->root, "dt", "%s", unstable);
  free(unstable);
  if (d->reported > 0) return SD_ERROR_USER;
  deck_echo_files(d);
  d->model->deck->full = deck_echo(d);
  return SD_OK;
}

/* What deck_open was given, and what to do with it. */
typedef struct task {
  const char *text;
  size_t n_settings;
  const deck_setting *settings;
  deck_use *use;
  void *user;
} task;

static sd_status open_and_use(deck *d, const task *t) {
  deck_text scanned = deck_scan(d, t->text, (deck_place){d->path, 1}, false);
  if (!scanned.broken) d->root = deck_parse(d, &scanned);
  if (!d->root) return SD_ERROR_USER;
  d->text = scanned.raw ? scanned.raw : t->text;
  for (size_t k = 0; k < t->n_settings; k++) deck_override(d, &t->settings[k]);
  return t->use(d, t->user);
}

static sd_status no_memory(const deck *d, sd_messages *messages) {
  if (d->comm) comm_fail(d->comm, "out of memory for the deck"); /* the others would wait */
  return sd_fail(messages, SD_ERROR_IO, "%s: out of memory", d->path);
}

sd_status deck_open(const char *text, const char *path, size_t n_settings, const deck_setting *settings,
                    deck_use *use, void *user, sd_messages *messages) {
  deck *d = memory_new(1, sizeof *d);
  d->path = path;
  d->messages = messages;
  task t = {text, n_settings, settings, use, user};
  sd_status status;
  if (setjmp(d->out_of_memory) == 0)
    status = open_and_use(d, &t);
  else
    status = d->whole && *d->whole ? SD_ERROR_USER : d->lacks_told ? SD_ERROR_IO : no_memory(d, messages);
  deck_report_rest(d);
  if (status != SD_OK) sd_model_free(d->model);
  deck_parse_free(d);
  deck_memory_free(d);
  sd_messages_free(d->found);
  free(d);
  return status;
}

typedef struct model_task {
  size_t n_settings;
  const deck_setting *settings;
  bool point, unfinished;   /* wanted even so */
  const comm *comm;         /* of ranks that read it together; NULL: one alone */
  const char **whole, *why; /* see deck */
  deck_suits *suits;
  sd_model *model;
} model_task;

static sd_status make_model(deck *d, void *user) {
  model_task *t = user;
  d->comm = t->comm;
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

sd_status deck_load(const char *text, const char *path, size_t n_settings, const deck_setting *settings,
                    bool point, sd_model **out, sd_messages *messages) {
  model_task t = {.n_settings = n_settings, .settings = settings, .point = point};
  sd_status status = deck_open(text, path, n_settings, settings, make_model, &t, messages);
  *out = t.model;
  return status;
}

/* how: what else is wanted. */
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

sd_status sd_deck_load_text(const char *text, const char *path, size_t n_overrides,
                            const char *const *overrides, sd_model **out, sd_messages *messages) {
  return load_text(text, path, n_overrides, overrides, (model_task){0}, out, messages);
}

/* Reads one byte more than `most` at most, and puts a zero behind. */
static void read_input(size_t most, char **all, size_t *n) {
  size_t capacity = 0;
  for (int c = 0; c != EOF && *n <= most;) {
    if (*n + 1 >= capacity) *all = memory_grow(*all, capacity = 2 * capacity + LIMIT_LINE, 1);
    if ((c = getchar()) != EOF) (*all)[(*n)++] = (char)c;
    (*all)[*n] = 0;
  }
}

/* Read once: a command may load its deck several times. */
static char *standard_input(char trouble[FILE_TROUBLE]) {
  static char *all;
  static size_t n;
  const size_t most = (size_t)LIMIT_DECK * LIMIT_MIB;
  if (!all) read_input(most, &all, &n);
  if (n > most)
    snprintf(trouble, FILE_TROUBLE, "it has more than %d MiB", LIMIT_DECK);
  else if (strlen(all) < n)
    snprintf(trouble, FILE_TROUBLE, "not a text (it holds a zero byte)");
  return n <= most && strlen(all) == n ? memory_text(all) : NULL;
}

char *deck_file_text(const char *path, sd_messages *messages, sd_status *status) {
  char *text, trouble[FILE_TROUBLE] = "no memory";
  if (strcmp(path, "-") == 0) {
    text = standard_input(trouble);
    *status = text ? SD_OK : SD_ERROR_USER;
    if (!text) sd_fail(messages, *status, "the standard input cannot be read: %s", trouble);
    return text;
  }
  *status = file_text(path, (uint64_t)LIMIT_DECK * LIMIT_MIB, &text, trouble);
  if (!text) sd_fail(messages, *status, "%s: cannot be read: %s", path, trouble);
  return text;
}

const char *deck_source(const char *path) { return strcmp(path, "-") == 0 ? "stdin" : path; }

static sd_status load(const char *path, size_t n_overrides, const char *const *overrides, model_task how,
                      sd_model **out, sd_messages *messages) {
  sd_status status;
  char *text = deck_file_text(path, messages, &status);
  *out = NULL;
  if (text) status = load_text(text, deck_source(path), n_overrides, overrides, how, out, messages);
  free(text);
  return status;
}

sd_status sd_deck_load(const char *path, size_t n_overrides, const char *const *overrides, sd_model **out,
                       sd_messages *messages) {
  return load(path, n_overrides, overrides, (model_task){0}, out, messages);
}

sd_status deck_look(const char *path, size_t n_overrides, const char *const *overrides, sd_model **out,
                    sd_messages *messages) {
  return load(path, n_overrides, overrides, (model_task){.unfinished = true}, out, messages);
}

/* Warns of tiles that were asked for; of a file where it is so large that memory matters. */
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
    if (sd_messages_kind(own, k) == SD_OK)
      sd_warn(messages, "%s", sd_messages_text(own, k));
    else
      sd_fail(messages, sd_messages_kind(own, k), "%s", sd_messages_text(own, k));
  sd_messages_free(own);
  status = comm_agree(c, status);
  if (status == SD_OK) return status;
  sd_model_free(*out);
  *out = NULL;
  return status;
}

/* deck_parts.c: a large file of disks, part by part (sd_tiles in model.h, deck_make_part). See deck_parts.h.
 *
 * A part is read by the deck itself: opened anew, with nothing but what a row of the file needs, and these rows.
 */
#include "io/deck/deck_parts.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "io/deck/deck_expression.h"
#include "io/deck/deck_result.h"
#include "io/deck/deck.h"
#include "io/store/file.h"
#include "model/image.h"
#include "model/tiles.h"
#include "slipdisk/deck.h"

/* Files of fewer disks are read as a whole; disks of the sample; of a part, at most; parts at least. */
enum { LEAST = 20000, SAMPLE = 4096, MOST = 1 << 16, FEWEST = 8, MOST_KINDS = 64 };

/* --- rows ------------------------------------------------------------------------------------------------------ */

typedef struct rows {
  size_t n, all;
  sd_disk *disks;   /* without names of their own */
  uint32_t *number; /* their places in the file */
} rows;

/* Reads rows of an entry of disk_files, and hands them to `take`. */
typedef struct rows_task {
  deck_rows_asked asked;
  size_t entry, n_groups;
  char *const *groups; /* known */
  void (*take)(void *user, const sd_model *m, const rows *r);
  sd_status (*use)(void *user, deck *d, const deck_node *file); /* in place of `take` */
  void *user;
} rows_task;

static deck_node *file_node(const deck *d, size_t entry) {
  const deck_node *list = deck_child(d->root, "disk_files");
  return list && entry < list->n ? deck_child(list->child[entry], "file") : NULL;
}

static sd_status read_file(deck *d, void *user) {
  const rows_task *t = user;
  const deck_node *file = file_node(d, t->entry);
  d->asked = t->asked;
  return file && file->type == DECK_STRING ? t->use(t->user, d, file) : SD_ERROR_USER;
}

static sd_status read_rows(deck *d, void *user) {
  const rows_task *t = user;
  deck_group top;
  d->model = sd_model_new();
  for (size_t k = 0; k < t->n_groups; k++) deck_group_number(d, t->groups[k]);
  deck_read_constants(d);
  if (deck_enter(d, d->root, &deck_top, &top)) deck_fill(&top, d->model);
  deck_read_box(d);
  deck_read_materials(d);
  deck_node *list = deck_groups(d, d->root, "disk_files");
  if (!list || t->entry >= list->n) return SD_ERROR_USER;
  d->asked = t->asked;
  const deck_columns c = deck_read_table(d, list->child[t->entry], &deck_disk_files);
  deck_check_overlaps(d);
  if (d->reported > 0) return SD_ERROR_USER;
  const sd_model *m = d->model;
  rows r = {m->n_disks, c.all, m->disks, c.disk ? c.disk : deck_alloc(d, m->n_disks, sizeof *r.number)};
  for (size_t k = 0; k < r.n && !c.disk; k++) r.number[k] = (uint32_t)(t->asked.first + k);
  t->take(t->user, m, &r);
  sd_model_free(d->model);
  d->model = NULL;
  return SD_OK;
}

/* The deck of the model, with the settings that it was read with. messages: errors alone; NULL: none. */
static sd_status open_rows(const sd_deck *from, rows_task *task, sd_messages *messages) {
  char *lines = memory_text(from->overrides);
  size_t n = 0, most = 1;
  for (const char *c = from->overrides; *c; c++) most += *c == '\n';
  deck_setting *settings = memory_new(most, sizeof *settings);
  sd_messages *own = sd_messages_new();
  for (char *rest = NULL, *line = strtok_r(lines, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest))
    settings[n++].text = line;
  const sd_status status =
      deck_open(from->text, from->path, n, settings, task->use ? read_file : read_rows, task, own);
  for (size_t k = 0; status != SD_OK && k < sd_messages_count(own); k++)
    if (sd_messages_kind(own, k) != SD_OK) sd_fail(messages, status, "%s", sd_messages_text(own, k));
  sd_messages_free(own);
  free(settings);
  free(lines);
  return status;
}

/* --- what a file says of its disks ----------------------------------------------------------------------------- */

static const char *group_of(const sd_model *m, const sd_disk *d) {
  return d->group >= 0 ? m->groups[d->group] : "";
}

/* Sums add up in any order: each has the number of the disk in it. */
static uint64_t sum_disk(const sd_model *m, const sd_disk *d, uint32_t number) {
  const double real[] = {d->radius,      d->mass,        d->inertia,     d->force[0],
                         d->force[1],    d->force[2],    d->position[0], d->position[1],
                         d->position[2], d->velocity[0], d->velocity[1], d->velocity[2]};
  const int32_t whole[] = {d->material, d->locked[0], d->locked[1], d->locked[2], d->driven};
  const char *group = group_of(m, d);
  uint64_t sum = file_sum(FILE_SUM, &number, sizeof number);
  sum = file_sum(file_sum(sum, real, sizeof real), whole, sizeof whole);
  return file_sum(sum, group, strlen(group));
}

static void add_input(int64_t *sum, const sd_model *m, const sd_disk *d, uint32_t number) {
  *sum = (int64_t)((uint64_t)*sum + sum_disk(m, d, number));
}

static void add_disk(sd_tiles *t, const sd_model *m, const sd_disk *d, uint32_t number) {
  add_input(&t->inputs, m, d, number);
  t->least = fmin(t->least, d->radius);
  t->most = fmax(t->most, d->radius);
  for (int c = 0; c < 2; c++) {
    t->lower[c] = fmin(t->lower[c], d->position[c] - d->radius);
    t->upper[c] = fmax(t->upper[c], d->position[c] + d->radius);
  }
}

static sd_tiles begin_tiles(const sd_model *m, size_t entry, size_t all) {
  const size_t parts = (all + MOST - 1) / MOST;
  return (sd_tiles){.n = parts > FEWEST ? parts : FEWEST,
                    .first = m->n_disks,
                    .count = all,
                    .of_file = true,
                    .entry = entry,
                    .group = -1,
                    .lower = {HUGE_VAL, HUGE_VAL},
                    .upper = {-HUGE_VAL, -HUGE_VAL},
                    .least = HUGE_VAL};
}

/* The last disks of the deck, in an HDF5 file; no contacts come from others. */
static bool is_large(const deck *d, size_t entry, const deck_columns *t) {
  bool others = false;
  for (size_t k = 0; k < entry; k++) others = others || d->file_tables[k].contacts;
  return t->all >= LEAST && !others && !deck_child(d->root, "packings");
}

void deck_parts_note(deck *d, size_t entry, const deck_columns *t) {
  sd_model *m = d->model;
  if (!is_large(d, entry, t) || t->n_rows != t->all || m->n_disks != t->first + t->all) return;
  sd_tiles tiles = begin_tiles(m, entry, t->all);
  tiles.first = t->first;
  for (size_t k = 0; k < t->all; k++) add_disk(&tiles, m, &m->disks[t->first + k], (uint32_t)k);
  m->tiles = tiles;
}

/* --- the survey of a run that ranks share ------------------------------------------------------------------------ */

/* Material and group, in the first disk that has them. */
typedef struct kind {
  sd_disk disk;
  const char *group;
  uint32_t number;
} kind;

typedef struct survey {
  deck *d;
  size_t at; /* rows read */
  sd_tiles tiles;
  bool special;     /* some disk is named, held or driven, or there are too many kinds */
  uint64_t numbers; /* their sum */
  size_t n_kinds, n_groups;
  kind kinds[MOST_KINDS];
  uint32_t number[MOST_KINDS]; /* of groups: the first disk that is in it */
  char *groups[MOST_KINDS];    /* in the arena of d */
} survey;

static void note_group(survey *s, const char *group, uint32_t number) {
  size_t k = 0;
  if (!*group) return;
  while (k < s->n_groups && strcmp(s->groups[k], group) != 0) k++;
  if (k == MOST_KINDS) {
    s->special = true;
    return;
  }
  if (k == s->n_groups) {
    s->groups[s->n_groups++] = deck_copy(s->d, group, strlen(group));
    s->number[k] = number;
  }
  if (number < s->number[k]) s->number[k] = number;
}

/* Those in the first rows are in the sample. */
static void note_kind(survey *s, const sd_disk *d, const char *group, size_t row, uint32_t number) {
  size_t k = 0;
  while (k < s->n_kinds &&
         (s->kinds[k].disk.material != d->material || strcmp(s->kinds[k].group, group) != 0))
    k++;
  if (k < s->n_kinds) return;
  s->special = s->special || k == MOST_KINDS;
  if (s->special) return;
  const char *name = "";
  for (size_t n = 0; n < s->n_groups; n++)
    if (strcmp(s->groups[n], group) == 0) name = s->groups[n];
  s->kinds[s->n_kinds++] = (kind){*d, name, row < SAMPLE ? UINT32_MAX : number};
}

static void survey_rows(void *user, const sd_model *m, const rows *r) {
  survey *s = user;
  if (s->at == 0) s->tiles = begin_tiles(s->d->model, s->tiles.entry, r->all);
  const size_t left = s->tiles.count - s->at;
  s->special = s->special || r->all != s->tiles.count || r->n != (left < MOST ? left : MOST);
  for (size_t k = 0; k < r->n && !s->special; k++) {
    const sd_disk *d = &r->disks[k];
    s->special = image_is_special(d);
    s->numbers += r->number[k];
    add_disk(&s->tiles, m, d, r->number[k]);
    note_group(s, group_of(m, d), r->number[k]);
    note_kind(s, d, group_of(m, d), s->at + k, r->number[k]);
  }
  s->at += r->n;
}

/* Groups get the numbers that they have where all disks are read, by number. */
static void name_groups(survey *s) {
  for (size_t n = 0; n < s->n_groups; n++) {
    size_t first = 0;
    for (size_t k = 1; k < s->n_groups; k++)
      if (s->number[k] < s->number[first]) first = k;
    deck_group_number(s->d, s->groups[first]);
    s->number[first] = UINT32_MAX;
  }
}

/* Mistakes in a file are told when it is read as a whole. */
static bool survey_file(survey *s) {
  const sd_deck *own = s->d->model->deck;
  do {
    rows_task t = {.asked = {.part = true, .again = s->at > 0, .first = s->at, .n = MOST},
                   .entry = s->tiles.entry,
                   .take = survey_rows,
                   .user = s};
    if (open_rows(own, &t, NULL) != SD_OK || s->special || s->tiles.count < LEAST) return false;
  } while (s->at < s->tiles.count);
  return s->numbers == (uint64_t)s->at * (s->at - 1) / 2;
}

bool deck_parts_begin(deck *d, size_t entry) {
  const deck_node *node = deck_child(d->root, "disk_files")->child[entry];
  const deck_node *file = deck_child(node, "file"), *format = deck_child(node, "format");
  if (!d->leave_tiles || deck_child(d->root, "packings") || !file || file->type != DECK_STRING) return false;
  if (format ? format->type != DECK_STRING || strcmp(format->value.text, "hdf5") != 0
             : deck_file_format(d, file->value.text) != DECK_HDF5)
    return false;
  for (size_t k = 0; k < entry; k++)
    if (d->file_tables[k].contacts) return false;
  survey *s = deck_alloc(d, 1, sizeof *s);
  s->d = d;
  s->tiles.entry = entry;
  if (!survey_file(s)) return false;
  name_groups(s);
  d->asked = (deck_rows_asked){.part = true, .again = true, .n = SAMPLE};
  deck_columns t = deck_read_table(d, deck_child(d->root, "disk_files")->child[entry], &deck_disk_files);
  d->asked = (deck_rows_asked){0};
  d->file_tables[entry] = t;
  for (size_t k = 0; k < s->n_kinds; k++) {
    const kind *q = &s->kinds[k];
    if (q->number != UINT32_MAX) deck_push_disk(d, &q->disk, NULL, *q->group ? q->group : NULL, node->place);
  }
  d->model->tiles = s->tiles;
  d->model->tiles.sample = d->model->n_disks - s->tiles.first;
  d->model->tiles.away = true;
  return true;
}

/* --- contacts --------------------------------------------------------------------------------------------------- */

static void add_contact(int64_t *sum, const sd_contact_memory *c) {
  const uint32_t whole[] = {c->a, c->b, c->part, (uint32_t)c->slide};
  uint64_t one = file_sum(file_sum(FILE_SUM, whole, sizeof whole), &c->side, sizeof c->side);
  one = file_sum(one, &c->record, sizeof c->record);
  *sum = (int64_t)((uint64_t)*sum + one);
}

void deck_parts_note_contacts(deck *d, const deck_result *r) {
  sd_tiles *t = &d->model->tiles;
  t->n_contacts = r->n_contacts;
  for (size_t k = 0; k < r->n_contacts; k++) {
    const sd_contact_memory c = deck_result_contact(r, k);
    add_contact(&t->contact_inputs, &c);
  }
}

typedef struct contacts_task {
  const sd_tiles *tiles;
  size_t n;
  sd_contact_memory *contacts;
  int64_t inputs;
} contacts_task;

static sd_status use_contacts(void *user, deck *d, const deck_node *file) {
  contacts_task *t = user;
  const deck_result *r = deck_result_read(d, file, deck_resolve(d, d->path, file->value.text), true);
  if (!r || r->n_contacts != t->n || r->n_disks != t->tiles->count ||
      r->n_bodies - r->n_disks != t->tiles->n_walls)
    return SD_ERROR_USER;
  for (size_t k = 0; k < t->n; k++) {
    t->contacts[k] = deck_result_contact(r, k);
    add_contact(&t->inputs, &t->contacts[k]);
  }
  return SD_OK;
}

static sd_status has_changed(const sd_model *m, sd_messages *messages) {
  return sd_fail(messages, SD_ERROR_IO, "disk_files[%zu].file has changed while it was read", m->tiles.entry);
}

sd_status deck_make_contacts(const sd_model *m, size_t first, size_t n, sd_contact_memory *contacts,
                             int64_t *inputs, sd_messages *messages) {
  contacts_task c = {&m->tiles, n, contacts, 0};
  rows_task t = {.asked = {.part = true, .contacts = true, .again = true, .first = first, .n = n},
                 .entry = m->tiles.entry,
                 .use = use_contacts,
                 .user = &c};
  const sd_status status = open_rows(m->deck, &t, messages);
  *inputs = c.inputs;
  return status == SD_ERROR_USER ? has_changed(m, messages) : status;
}

bool deck_parts_contacts(deck *d, size_t *lost, uint32_t *first) {
  sd_tiles *t = &d->model->tiles;
  sd_contact_memory *list = deck_alloc(d, MOST, sizeof *list);
  *lost = 0;
  for (size_t at = 0; at < t->n_contacts; at += MOST) {
    const size_t n = t->n_contacts - at < MOST ? t->n_contacts - at : MOST;
    int64_t inputs;
    if (deck_make_contacts(d->model, at, n, list, &inputs, NULL) != SD_OK) return false;
    t->contact_inputs = (int64_t)((uint64_t)t->contact_inputs + (uint64_t)inputs);
    for (size_t k = 0; k < n; k++) {
      const sd_contact_memory *c = &list[k];
      if (deck_contact_is_kept(c, c->b < t->count ? NULL : &t->walls[c->b - t->count])) continue;
      if ((*lost)++ == 0) *first = c->b;
    }
  }
  return true;
}

typedef struct turned_task {
  size_t n, all;
  uint32_t *number;
  deck_turned *turned;
} turned_task;

static sd_status use_turned(void *user, deck *d, const deck_node *file) {
  const turned_task *t = user;
  const deck_result *r = deck_result_read(d, file, deck_resolve(d, d->path, file->value.text), false);
  if (!r || r->n_rows != t->n || r->n_disks != t->all) return SD_ERROR_USER;
  for (size_t k = 0; k < t->n; k++) {
    t->number[k] = r->number[k];
    t->turned[k] = (deck_turned){r->radius[k], deck_result_shift(r, k)};
  }
  return SD_OK;
}

sd_status deck_make_turned(const sd_model *m, size_t part, uint32_t *number, deck_turned *turned,
                           sd_messages *messages) {
  const size_t first = model_tile_begin(&m->tiles, part), n = model_tile_begin(&m->tiles, part + 1) - first;
  turned_task w = {n, m->tiles.count, number, turned};
  rows_task t = {.asked = {.part = true, .again = true, .first = first, .n = n},
                 .entry = m->tiles.entry,
                 .use = use_turned,
                 .user = &w};
  const sd_status status = open_rows(m->deck, &t, messages);
  return status == SD_ERROR_USER ? has_changed(m, messages) : status;
}

/* --- parts ------------------------------------------------------------------------------------------------------- */

typedef struct part {
  size_t n;
  sd_disk *disks;
  uint32_t *number;
  int64_t inputs;
  bool good;
} part;

static void take_part(void *user, const sd_model *m, const rows *r) {
  part *p = user;
  p->good = r->n == p->n;
  for (size_t k = 0; p->good && k < r->n; k++) {
    p->disks[k] = r->disks[k];
    p->number[k] = r->number[k];
    add_input(&p->inputs, m, &r->disks[k], r->number[k]);
    if (p->disks[k].inertia == 0.0)
      p->disks[k].inertia = 0.5 * p->disks[k].mass * p->disks[k].radius * p->disks[k].radius;
    p->good = p->good && !image_is_special(&p->disks[k]) && p->disks[k].group < (int)m->n_groups;
  }
}

sd_status deck_make_part(const sd_model *m, size_t number, sd_disk *disks, uint32_t *numbers, int64_t *inputs,
                         sd_messages *messages) {
  const size_t first = model_tile_begin(&m->tiles, number),
               n = model_tile_begin(&m->tiles, number + 1) - first;
  part p = {.n = n, .disks = disks, .number = numbers};
  rows_task t = {.asked = {.part = true, .again = true, .first = first, .n = n},
                 .entry = m->tiles.entry,
                 .n_groups = m->n_groups,
                 .groups = m->groups,
                 .take = take_part,
                 .user = &p};
  const sd_status status = open_rows(m->deck, &t, messages);
  *inputs = p.inputs;
  return status != SD_OK || p.good ? status : has_changed(m, messages);
}

bool deck_parts_bear(sd_model *m, sd_step_limit *limit) {
  const size_t most = model_tile_begin(&m->tiles, 1);
  sd_disk *disks = NULL;
  uint32_t *number = NULL;
  bool good =
      memory_resize(2, (memory_column[]){{&disks, most, sizeof *disks}, {&number, most, sizeof *number}});
  for (size_t k = 0; k < m->tiles.n && good; k++) {
    const size_t n = model_tile_begin(&m->tiles, k + 1) - model_tile_begin(&m->tiles, k);
    int64_t inputs;
    good = deck_make_part(m, k, disks, number, &inputs, NULL) == SD_OK;
    for (size_t at = 0; at < n && good; at += SAMPLE)
      good = model_bears(m, n - at < SAMPLE ? n - at : SAMPLE, disks + at, limit);
  }
  free(number);
  free(disks);
  return good;
}

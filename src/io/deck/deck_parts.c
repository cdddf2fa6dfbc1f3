/* deck_parts.c: reads a large file of disks in parts, some on each rank (sd_tiles in model.h).
 * See deck_rows.h.
 *
 * For each part the deck reader opens the deck again; from the deck it then reads only the
 * groups that the rows refer to (such as materials), and from the file of disks only the rows of
 * this part. */
#include "io/deck/deck_rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
#include "base/math.h"
#include "base/memory.h"
#include "io/deck/deck.h"
#include "io/deck/deck_expression.h"
#include "io/deck/deck_result.h"
#include "model/rows.h"
#include "slipdisk/deck.h"

/* LEAST: files with fewer disks are read as a whole by every rank. MOST: largest number of disks in
 * a part. FEWEST: smallest number of parts. MOST_GROUPS: largest number of groups in a file. */
enum { LEAST = 20000, MOST = 1 << 16, FEWEST = 8, MOST_GROUPS = 64 };

/* --- rows ------------------------------------------------------------------------------------- */

/* Task that reads rows of an entry of disk_files, either disks (`take` is set) or contacts (`use`
 * is set). */
typedef struct rows_task {
  deck_rows_asked asked;
  size_t entry;
  /* Receives the disks that were read; m: a model with only these disks */
  void (*take)(void *user, const sd_model *m, const deck_columns *t);
  /* Reads the contacts that d->asked selects from the file */
  sd_status (*use)(void *user, deck *d, const deck_node *file);
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
  deck_read_constants(d);
  if (deck_enter(d, d->root, &deck_top, &top)) deck_fill(&top, d->model);
  deck_read_box(d);
  deck_read_materials(d);
  deck_node *list = deck_groups(d, d->root, "disk_files");
  if (!list || t->entry >= list->n) return SD_ERROR_USER;
  d->asked = t->asked;
  const deck_columns c = deck_read_table(d, list->child[t->entry], &deck_disk_files);
  if (d->reported > 0) return SD_ERROR_USER;
  t->take(t->user, d->model, &c);
  sd_model_free(d->model);
  d->model = NULL;
  return SD_OK;
}

/* Opens the model's deck again with its -D settings, and runs the task. messages: receives the
 * errors, but no warnings. */
static sd_status open_rows(const sd_deck *from, rows_task *task, sd_messages *messages) {
  char *lines = memory_text(from->overrides);
  size_t n = 0, most = 1;
  for (const char *c = from->overrides; *c; c++) most += *c == '\n';
  deck_setting *settings = memory_new(most, sizeof *settings);
  sd_messages *own = sd_messages_new();
  for (char *rest = NULL, *line = strtok_r(lines, "\n", &rest); line;
       line = strtok_r(NULL, "\n", &rest))
    settings[n++].text = line;
  const sd_status status =
      deck_open(from->text, from->path, n, settings, task->use ? read_file : read_rows, task, own);
  for (size_t k = 0; status != SD_OK && k < sd_messages_count(own); k++)
    if (sd_messages_kind(own, k) != SD_OK)
      sd_fail(messages, status, "%s", sd_messages_text(own, k));
  sd_messages_free(own);
  free(settings);
  free(lines);
  return status;
}

/* --- checksum and bounds of the disks of a file ----------------------------------------------- */

static const char *group_of(const sd_model *m, const sd_disk *d) {
  return d->group >= 0 ? m->groups[d->group] : "";
}

/* Returns a hash of one disk and its number. The sum of the hashes of all disks does not depend on
 * their order. */
static uint64_t sum_disk(const sd_model *m, const sd_disk *d, uint32_t number) {
  const double real[] = {d->radius,      d->mass,        d->inertia,     d->force[0],
                         d->force[1],    d->force[2],    d->position[0], d->position[1],
                         d->position[2], d->velocity[0], d->velocity[1], d->velocity[2]};
  const int32_t whole[] = {d->material, d->locked[0], d->locked[1], d->locked[2], d->driven};
  const char *group = group_of(m, d);
  uint64_t sum = hash_words(HASH_WORDS, &number, sizeof number);
  sum = hash_words(hash_words(sum, real, sizeof real), whole, sizeof whole);
  return hash_words(sum, group, strlen(group));
}

static void add_input(int64_t *sum, const sd_model *m, const sd_disk *d, uint32_t number) {
  *sum = (int64_t)((uint64_t)*sum + sum_disk(m, d, number));
}

static void add_disk(sd_tiles *t, const sd_model *m, const sd_disk *d, uint32_t number) {
  add_input(&t->inputs, m, d, number);
  t->most = math_max(t->most, d->radius);
  for (int c = 0; c < 2; c++) {
    t->lower[c] = math_min(t->lower[c], d->position[c] - d->radius);
    t->upper[c] = math_max(t->upper[c], d->position[c] + d->radius);
  }
}

static sd_tiles begin_tiles(const sd_model *m, size_t entry, size_t all) {
  const size_t parts = (all + MOST - 1) / MOST;
  return (sd_tiles){.n = parts > FEWEST ? parts : FEWEST,
                    .first = m->n_disks,
                    .count = all,
                    .of_file = true,
                    .entry = entry,
                    .lower = {HUGE_VAL, HUGE_VAL},
                    .upper = {-HUGE_VAL, -HUGE_VAL}};
}

/* Returns true if the deck has no packings, which would add disks after this file, and takes no
 * contacts from earlier files. */
static bool is_last(const deck *d, size_t entry) {
  bool others = deck_child(d->root, "packings") != NULL;
  for (size_t k = 0; k < entry; k++) others = others || d->file_tables[k].contacts;
  return !others;
}

void deck_parts_note(deck *d, size_t entry, const deck_columns *t) {
  sd_model *m = d->model;
  if (t->all < LEAST || !is_last(d, entry) || t->n_rows != t->all ||
      m->n_disks != t->first + t->all)
    return;
  sd_tiles tiles = begin_tiles(m, entry, t->all);
  tiles.first = t->first;
  for (size_t k = 0; k < t->all; k++) add_disk(&tiles, m, &m->disks[t->first + k], (uint32_t)k);
  m->tiles = tiles;
}

/* --- parts that ranks read -------------------------------------------------------------------- */

/* A group that occurs in the file: lowest number and name of its disks. */
typedef struct file_group {
  uint32_t disk;
  char *name; /* Name of the group, in the arena */
} file_group;

typedef struct survey {
  deck *d;
  sd_tiles tiles;
  size_t all;
  size_t first, n; /* First row of the part that is being read, and its number of rows */
  /* True if the file cannot be read in parts: a disk is named, locked, driven or out of play, so
   * that all ranks must know it */
  bool special;
  uint64_t numbers; /* Sum of the disk numbers; it shows whether each number occurs once */
  size_t n_groups;
  file_group groups[MOST_GROUPS];
} survey;

/* Returns the index of a group in s->groups, adding it if new; -1 if the disk has no group, or if
 * there are too many groups (s->special is then true). */
static int note_group(survey *s, const char *name, uint32_t disk) {
  size_t k = 0;
  if (!*name) return -1;
  while (k < s->n_groups && strcmp(s->groups[k].name, name) != 0) k++;
  s->special = s->special || k == MOST_GROUPS;
  if (s->special) return -1;
  if (k == s->n_groups)
    s->groups[s->n_groups++] = (file_group){disk, deck_copy(s->d, name, strlen(name))};
  if (disk < s->groups[k].disk) s->groups[k].disk = disk;
  return (int)k;
}

/* Adds the disks of a part to the rows of this rank. Until name_groups is called, their groups are
 * indices into s->groups. */
static void take_rows(void *user, const sd_model *m, const deck_columns *t) {
  survey *s = user;
  sd_model *own = s->d->model;
  sd_rows *mine = own->mine;
  for (size_t k = 0; k < m->n_disks && !s->special; k++) {
    const uint32_t number = t->disk ? t->disk[k] : (uint32_t)(s->first + k);
    sd_disk d = m->disks[k];
    s->special = rows_special(&d) || number >= s->all;
    s->numbers += number;
    add_disk(&s->tiles, m, &d, number);
    d.group = note_group(s, group_of(m, &d), number);
    if (mine->shift) mine->shift[mine->n] = deck_result_shift(t->result, k);
    rows_add(own, &d, (uint32_t)s->tiles.first + number);
  }
  s->special = s->special || t->all != s->all || t->n_rows != s->n;
}

/* Reads this rank's parts of the file. Errors are reported in d->messages. */
static sd_status read_own(survey *s) {
  sd_status status = SD_OK;
  const size_t ranks = (size_t)comm_size(s->d->comm);
  for (size_t part = (size_t)comm_rank(s->d->comm);
       part < s->tiles.n && status == SD_OK && !s->special; part += ranks) {
    s->first = model_tile_begin(&s->tiles, part);
    s->n = model_tile_size(&s->tiles, part);
    rows_task t = {.asked = {.part = true, .again = true, .first = s->first, .n = s->n},
                   .entry = s->tiles.entry,
                   .take = take_rows,
                   .user = s};
    status = open_rows(s->d->model->deck, &t, s->d->messages);
  }
  return status;
}

/* Exchanges the groups of the file between the ranks, so that each rank has the list of all groups
 * and the lowest disk number in each. Collective. */
static void share_groups(survey *s) {
  const comm *c = s->d->comm;
  deck_buffer text = {0};
  int *counts = memory_new((size_t)comm_size(c), sizeof *counts);
  size_t bytes = 0;
  for (size_t k = 0; k < s->n_groups; k++) {
    const char *line = deck_format(s->d, "%u %s\n", s->groups[k].disk, s->groups[k].name);
    deck_put(s->d, &text, line, strlen(line));
  }
  comm_gather_counts(c, (int)text.n, counts);
  for (int q = 0; q < comm_size(c); q++) bytes += (size_t)counts[q];
  char *all = deck_alloc(s->d, bytes + 1, 1);
  comm_gather(c, text.bytes, all, counts, 1);
  free(counts);
  for (char *rest, *line = strtok_r(all, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) {
    char *name;
    const uint32_t disk = (uint32_t)strtoul(line, &name, 10);
    note_group(s, name + 1, disk);
  }
}

static void name_groups(survey *s) {
  deck *d = s->d;
  int number[MOST_GROUPS];
  bool named[MOST_GROUPS] = {false};
  for (size_t n = 0; n < s->n_groups; n++) {
    size_t first = 0;
    while (named[first]) first++;
    for (size_t k = first; k < s->n_groups; k++)
      if (!named[k] && s->groups[k].disk < s->groups[first].disk) first = k;
    number[first] = deck_group_number(d, s->groups[first].name);
    named[first] = true;
  }
  for (size_t k = 0; k < s->n_groups; k++) deck_note_away(d, number[k]);
  for (size_t k = 0; k < d->model->mine->n; k++) {
    int *group = &d->model->mine->disk[k].group;
    if (*group >= 0) *group = number[*group];
  }
}

/* Combines the checksums, radii and bounds that the ranks have found for their disks.
 * Collective. */
static void share_survey(survey *s) {
  const comm *c = s->d->comm;
  sd_tiles *t = &s->tiles;
  int64_t sums[] = {t->inputs, (int64_t)s->numbers};
  comm_add(c, sums, 2);
  t->inputs = sums[0];
  s->numbers = (uint64_t)sums[1];
  const sd_rows *mine = s->d->model->mine;
  t->material = (int)comm_largest(c, mine->n > 0 ? mine->disk[0].material : -1);
  t->most = comm_largest(c, t->most);
  for (int k = 0; k < 2; k++) {
    t->lower[k] = -comm_largest(c, -t->lower[k]);
    t->upper[k] = comm_largest(c, t->upper[k]);
  }
}

/* Returns true if this file may be read in parts: a run on several ranks, an HDF5 file, and no
 * disks after it. Columns and keys are checked when the file is read. */
static bool may_begin(deck *d, size_t entry) {
  const deck_node *node = deck_child(d->root, "disk_files")->child[entry];
  const deck_node *file = deck_child(node, "file"), *format = deck_child(node, "format");
  if (!d->comm || !d->whole || !is_last(d, entry) || !file || file->type != DECK_STRING)
    return false;
  if (format) return format->type == DECK_STRING && strcmp(format->value.text, "hdf5") == 0;
  return deck_file_format(d, file->value.text) == DECK_HDF5;
}

/* Reads only the columns of the file and its number of disks. */
static void read_head(survey *s, deck_columns *table) {
  deck *d = s->d;
  d->asked = (deck_rows_asked){.part = true, .head = true, .again = comm_rank(d->comm) > 0, .n = 1};
  *table = deck_read_table(d, deck_child(d->root, "disk_files")->child[s->tiles.entry],
                           &deck_disk_files);
  d->asked = (deck_rows_asked){0};
  s->all = table->all;
  /* Other ranks wait here until rank 0 has checked the whole file */
  comm_wait(d->comm, SD_OK);
}

/* Returns true if this or another rank has found a mistake. Collective. */
static bool has_failed(deck *d) {
  deck_agree_on_errors(d);
  d->disks_missing = d->disks_missing || !d->comm;
  return !d->comm;
}

bool deck_parts_begin(deck *d, size_t entry) {
  if (!may_begin(d, entry)) return false;
  survey *s = deck_alloc(d, 1, sizeof *s);
  deck_columns *table = &d->file_tables[entry];
  s->d = d;
  s->tiles.entry = entry;
  read_head(s, table);
  if (has_failed(d)) return true;
  if (s->all < LEAST) return false;
  sd_model *m = d->model;
  s->tiles = m->tiles = begin_tiles(m, entry, s->all);
  const size_t n = rows_of_tiles(m);
  if (!rows_reserve(m, n) ||
      (table->contacts && !memory_resize_row(&m->mine->shift, n, sizeof(double))))
    longjmp(d->out_of_memory, 1);
  if (read_own(s) != SD_OK) d->reported++;
  if (has_failed(d)) return true;
  if (comm_or(d->comm, s->special))
    deck_restart_with_all_disks(d, "some of its disks are fixed, named or out of play");
  share_survey(s);
  share_groups(s);
  if (s->special || s->numbers != (uint64_t)s->all * (s->all - 1) / 2)
    deck_restart_with_all_disks(d, "its disks have no numbers of their own, or too many groups");
  name_groups(s);
  d->away_place = (deck_place){deck_resolve(d, d->path, file_node(d, entry)->value.text),
                               table->result ? PLACE_DISK : -1};
  m->tiles = s->tiles;
  m->tiles.away = true;
  m->n_disks += s->all;
  return true;
}

/* --- contacts --------------------------------------------------------------------------------- */

static void add_contact(int64_t *sum, const sd_contact_memory *c) {
  const uint32_t whole[] = {c->a, c->b, c->part, (uint32_t)c->slide};
  uint64_t one = hash_words(hash_words(HASH_WORDS, whole, sizeof whole), &c->side, sizeof c->side);
  one = hash_words(one, &c->record, sizeof c->record);
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
  sd_model *model;
  int64_t inputs;
  size_t lost;
  /* Index in the file of the first contact that is lost (its partner is not in the model);
   * infinite: none */
  double first;
  uint32_t wall;
} contacts_task;

/* Stores the contacts whose partners are bodies of the model, and counts the others as lost. */
static sd_status use_contacts(void *user, deck *d, const deck_node *file) {
  contacts_task *t = user;
  const sd_tiles *tiles = &t->model->tiles;
  sd_rows *mine = t->model->mine;
  const deck_result *r =
      deck_result_read(d, file, deck_resolve(d, d->path, file->value.text), true);
  if (!r || r->n_contacts != d->asked.n || r->n_disks != tiles->count ||
      r->n_bodies - r->n_disks != tiles->n_walls)
    return SD_ERROR_USER;
  for (size_t k = 0; k < r->n_contacts; k++) {
    const sd_contact_memory c = deck_result_contact(r, k);
    add_contact(&t->inputs, &c);
    if (deck_contact_is_kept(&c, c.b < tiles->count ? NULL : &tiles->walls[c.b - tiles->count])) {
      mine->contacts[mine->n_contacts++] = c;
      continue;
    }
    if (t->lost++ > 0) continue;
    t->first = (double)(d->asked.first + k);
    t->wall = c.b;
  }
  return SD_OK;
}

bool deck_parts_contacts(deck *d, size_t *lost, uint32_t *first) {
  sd_model *m = d->model;
  sd_tiles *t = &m->tiles;
  const size_t size = (size_t)comm_size(d->comm), rank = (size_t)comm_rank(d->comm);
  const size_t begin = t->n_contacts * rank / size, end = t->n_contacts * (rank + 1) / size;
  contacts_task c = {.model = m, .first = HUGE_VAL};
  if (!memory_resize_row(&m->mine->contacts, end - begin, sizeof *m->mine->contacts))
    longjmp(d->out_of_memory, 1);
  sd_status status = SD_OK;
  for (size_t at = begin; at < end && status == SD_OK; at += MOST) {
    const size_t n = end - at < MOST ? end - at : MOST;
    rows_task rows = {.asked = {.part = true, .contacts = true, .again = true, .first = at, .n = n},
                      .entry = t->entry,
                      .use = use_contacts,
                      .user = &c};
    status = open_rows(m->deck, &rows, d->messages);
  }
  if (!comm_all_well(d->comm, status)) return false;
  int64_t sums[] = {c.inputs, (int64_t)c.lost};
  comm_add(d->comm, sums, 2);
  t->contact_inputs = sums[0];
  *lost = (size_t)sums[1];
  const double before = -comm_largest(d->comm, -c.first);
  *first = (uint32_t)comm_largest(d->comm, before == c.first && *lost > 0 ? c.wall : 0.0);
  return true;
}

/* --- all disks of the deck -------------------------------------------------------------------- */

void deck_read_disks(deck *d) {
  deck_read_single_disks(d);
  deck_node *list = deck_groups(d, d->root, "disk_rows");
  for (size_t k = 0; list && k < list->n; k++) deck_read_table(d, list->child[k], &deck_disk_rows);
  list = deck_groups(d, d->root, "disk_files");
  d->n_file_tables = list ? list->n : 0;
  d->file_tables = deck_alloc(d, d->n_file_tables, sizeof(deck_columns));
  for (size_t k = 0; list && k < list->n; k++) {
    const bool last = k + 1 == list->n;
    if (last) deck_agree_on_errors(d);
    if (last && deck_parts_begin(d, k)) break;
    d->file_tables[k] = deck_read_table(d, list->child[k], &deck_disk_files);
    if (last) deck_parts_note(d, k, &d->file_tables[k]);
  }
  /* A `disks` that is not a list was reported as an error before */
  bool tried = deck_child(d->root, "disks") && deck_child(d->root, "disks")->type != DECK_LIST;
  if (d->model->n_disks == 0 && !tried && !deck_child(d->root, "disk_files") &&
      !deck_child(d->root, "packings"))
    deck_fail_child(
        d, d->root, "disks",
        "missing: expected at least one disk, in disks, disk_rows, disk_files or packings");
}

/* deck_disks.c: makes disks from the lists `disks`, `disk_rows` and `disk_files` of a deck, in this
 * order; reads the lists `forces` and `locks`. See deck_tree.h.
 *
 * All three kinds of disks end in add_disk. An entry of `disks` is treated as a row without
 * columns: all values of its disk are those of its group. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/deck/deck_rows.h"

/* Disk files with at most so many disks in all are printed as rows in the full deck, which then
 * does not need the files. */
enum { MOST_ECHOED = 1000 };

/* Values that a group of the deck gives to all its disks; columns of its table override them. */
typedef struct values {
  double number[COLUMN_NUMBERS]; /* Index: column (COLUMN_*); NAN: not given */
  const char *name, *group;
  int material;
  unsigned locked;
  double force[3];
  /* Node of the group, for messages; NULL for a disk from a row of a table */
  const deck_node *node;
  deck_place place;
  deck_index *unknown; /* Names in the column `material` that are none and were reported */
  bool broken;         /* True if these common values have errors; the rows are then not checked */
} values;

/* --- one disk --------------------------------------------------------------------------------- */

static void fail_value(deck *d, const values *v, const char *key, const char *text) {
  if (v->node)
    deck_fail_child(d, v->node, key, "%s", text);
  else
    deck_fail_place(d, v->place, "%s: %s", key, text);
}

/* Checks the values of one disk, or those that all rows of a table have (check_table). */
static void check_values(deck *d, const values *v) {
  const double *x = v->number;
  bool mass = !isnan(x[COLUMN_MASS]), density = !isnan(x[COLUMN_DENSITY]);
  /* The columns of a table are checked by check_table */
  const bool single = v->node && v->node->table == &deck_disks;
  bool tried = single && (deck_child(v->node, "mass") || deck_child(v->node, "density"));
  if (single && !mass && !density && !tried)
    fail_value(d, v, "mass", "missing: expected mass or density > 0");
  if (mass && density)
    fail_value(d, v, "density", "given together with mass; expected one of them");
  /* NAN, an error that was reported before, counts as no motion */
  bool moving = fabs(x[COLUMN_VX]) > 0 || fabs(x[COLUMN_VY]) > 0 || fabs(x[COLUMN_OMEGA]) > 0;
  if (x[COLUMN_FIXED] != 0 && moving)
    fail_value(d, v, "fixed",
               "a fixed disk cannot have a velocity; a motion of type \"velocity\" moves it");
  for (int c = 0; c < 3; c++)
    if ((v->locked >> c & 1) && fabs(x[COLUMN_VX + c]) > 0)
      fail_value(d, v, "locked", "a locked coordinate cannot have a velocity");
}

static void add_disk(deck *d, const values *v) {
  if (!v->broken) check_values(d, v);
  const double *x = v->number;
  double radius = x[COLUMN_RADIUS];
  sd_disk disk = {.position = {x[COLUMN_X], x[COLUMN_Y], x[COLUMN_THETA]},
                  .velocity = {x[COLUMN_VX], x[COLUMN_VY], x[COLUMN_OMEGA]},
                  .radius = radius,
                  .mass = isnan(x[COLUMN_MASS])
                              ? x[COLUMN_DENSITY] * 3.14159265358979323846 * radius * radius
                              : x[COLUMN_MASS],
                  .inertia = x[COLUMN_INERTIA],
                  .force = {v->force[0], v->force[1], v->force[2]},
                  .material = v->material,
                  .group = deck_group_number(d, v->group),
                  .driven = x[COLUMN_FIXED] != 0};
  if (isnan(x[COLUMN_MASS]) && disk.mass >= 0 && !deck_in_range(DECK_POSITIVE, disk.mass))
    fail_value(d, v, "density",
               deck_format(d, "the mass is %g; expected a number %s", disk.mass,
                           deck_expected(DECK_POSITIVE, disk.mass)));
  for (int c = 0; c < 3; c++) disk.locked[c] = v->locked >> c & 1;
  deck_push_disk(d, &disk, v->name, v->place);
}

/* --- common values of a group ----------------------------------------------------------------- */

/* Returns true if the table has no such column, so that the group gives the value for all rows;
 * reports a value that is given both ways. */
static bool common(deck_group *g, const deck_columns *t, int column) {
  if (!deck_columns_have(t, column)) return true;
  if (deck_given(g, deck_column_names[column]))
    deck_fail_key(g, deck_column_names[column], "given here and as a column; expected one of them");
  return false;
}

static values read_common(deck_group *g, const deck_columns *t) {
  values v = {.material = -1, .node = g->node, .place = g->node->place};
  for (int k = 0; k < COLUMN_NUMBERS; k++) v.number[k] = k == COLUMN_FIXED ? 0 : NAN;
  for (int k = 0; k < COLUMN_FIXED; k++)
    if (common(g, t, k)) v.number[k] = deck_number(g, deck_column_names[k]);
  if (common(g, t, COLUMN_FIXED)) v.number[COLUMN_FIXED] = deck_bool(g, "fixed");
  if (g->table == &deck_disks) v.name = deck_text_of(g, "name");
  if (common(g, t, COLUMN_MATERIAL)) v.material = deck_material(g);
  if (common(g, t, COLUMN_GROUP)) v.group = deck_text_of(g, "group");
  v.locked = deck_coordinates(g, "locked");
  deck_pair(g, "force", v.force);
  v.force[2] = deck_number(g, "torque");
  return v;
}

static void check_cell(deck *d, const values *v, int column) {
  const deck_key *key = deck_key_find(&deck_disks, deck_column_names[column]);
  double x = v->number[column];
  if (isnan(x) || deck_in_range(key->range, x)) return;
  if (deck_error_limit_reached(d)) {
    d->reported++;
    return;
  }
  fail_value(d, v, key->name,
             deck_format(d, "%g: expected a number %s", x, deck_expected(key->range, x)));
}

/* Reports a value that neither a column of the table nor a key of its group gives to the disks. */
static void check_given(deck_group *g, const values *v, int column, const char *expected) {
  if (!isnan(v->number[column])) return;
  deck_fail_key(g, deck_column_names[column],
                "missing for all its disks: expected %s here, or in a column (key columns)",
                expected);
}

/* Reports a column in which all rows of the table are out of range: once, not row by row, for which
 * its values become NAN, a value whose error was reported. */
static void check_column(deck *d, deck_columns *t, size_t c) {
  const char *name = deck_column_names[t->column[c]];
  const deck_key *key = deck_key_find(&deck_disks, name);
  size_t r = 0;
  if (t->column[c] >= COLUMN_FIXED) return;
  while (r < t->n_rows && !deck_in_range(key->range, t->number[r * t->n_columns + c])) r++;
  if (r < t->n_rows || r < 2) return;
  const double x = t->number[c];
  deck_fail_place(d, t->place[0],
                  "%s = %g: expected a number %s; none of the %zu rows has one, so leave out this "
                  "column and give %s in the deck",
                  name, x, deck_expected(key->range, x), t->n_rows,
                  t->column[c] == COLUMN_MASS || t->column[c] == COLUMN_DENSITY ? "mass or density"
                                                                                : name);
  for (r = 0; r < t->n_rows; r++) t->number[r * t->n_columns + c] = NAN;
}

/* Checks what holds for all rows of a table, so that it is reported once. v: values of the group.
 * Returns false after an error. */
static bool check_table(deck_group *g, deck_columns *t, values v) {
  const size_t before = g->d->reported;
  for (size_t c = 0; c < t->n_columns; c++) {
    if (t->column[c] < COLUMN_NUMBERS) v.number[t->column[c]] = 0.0;
    check_column(g->d, t, c);
  }
  check_given(g, &v, COLUMN_X, "x");
  check_given(g, &v, COLUMN_Y, "y");
  check_given(g, &v, COLUMN_RADIUS, "radius");
  if (isnan(v.number[COLUMN_MASS])) check_given(g, &v, COLUMN_DENSITY, "density (or mass)");
  check_values(g->d, &v);
  return g->d->reported == before;
}

/* Adds the disk of row r of a table. v: common values of the group, overridden by the columns. */
static void add_row_disk(deck *d, const deck_columns *t, size_t r, values v) {
  v.node = NULL;
  v.place = t->place[r];
  for (size_t c = 0; c < t->n_columns; c++) {
    int column = t->column[c];
    const char *text = t->text ? t->text[r * t->n_columns + c] : NULL;
    if (column < COLUMN_NUMBERS) {
      v.number[column] = t->number[r * t->n_columns + c];
      /* A velocity from a result file is ignored at a locked coordinate; in a deck it would be an
       * error */
      if (t->result && column >= COLUMN_VX && column <= COLUMN_OMEGA &&
          v.locked >> (column - COLUMN_VX) & 1)
        v.number[column] = 0.0;
      check_cell(d, &v, column);
    } else if (text && !text_printable(text)) {
      fail_value(d, &v, deck_column_names[column],
                 "expected a text in UTF-8 without control characters");
    } else if (column == COLUMN_NAME) {
      v.name = text;
    } else if (column == COLUMN_GROUP) {
      v.group = text;
    } else {
      uint32_t material;
      v.material = text && deck_index_find(&d->materials, text, &material) ? (int)material : -1;
      /* A name is reported once, not for each of its disks */
      if (v.material < 0 && deck_index_add(d, v.unknown, text ? text : "", 0))
        fail_value(d, &v, "material",
                   deck_format(d, "no material is called \"%s\"",
                               text ? deck_quote(d, text, strlen(text)) : ""));
    }
  }
  add_disk(d, &v);
}

/* Reads a table and adds its disks to the model. The caller must keep the table of a file until it
 * calls deck_echo_files. */
deck_columns deck_read_table(deck *d, deck_node *node, const deck_table *table) {
  deck_columns t = {0};
  deck_group g;
  if (!deck_enter(d, node, table, &g)) return t;
  size_t before = d->reported;
  deck_columns_read(&g, &t);
  if (table == &deck_disk_rows)
    deck_columns_from_rows(&g, &t);
  else
    deck_columns_from_file(&g, &t);
  d->disks_missing |= d->reported > before;
  deck_index unknown = {0};
  values v = read_common(&g, &t);
  v.unknown = &unknown;
  v.broken = d->reported > before || !check_table(&g, &t, v);
  t.first = d->model->n_disks;
  deck_need(d, node, table == &deck_disk_rows ? "rows" : "file", (double)(t.first + t.n_rows),
            deck_disk_bytes(false), "disks");
  for (size_t r = 0; r < t.n_rows && !d->asked.head; r++) add_row_disk(d, &t, r, v);
  return t;
}

void deck_read_single_disks(deck *d) {
  static const deck_columns none;
  deck_group g;
  for (size_t k = 0; deck_next(d, &deck_disks, &k, &g);) {
    values v = read_common(&g, &none);
    add_disk(d, &v);
  }
}

/* --- echo of short files ---------------------------------------------------------------------- */

static void file_to_rows(deck *d, deck_node *file, const deck_columns *t, deck_node *rows_list) {
  deck_node *group = deck_node_new(d, rows_list, NULL, DECK_GROUP, file->place);
  group->table = &deck_disk_rows;
  deck_node *names = deck_node_new(d, group, "columns", DECK_LIST, file->place);
  for (size_t c = 0; c < t->n_columns; c++)
    deck_node_new(d, names, NULL, DECK_STRING, file->place)->value.text =
        deck_column_names[t->column[c]];
  deck_node *rows = deck_node_new(d, group, "rows", DECK_LIST, file->place);
  for (size_t r = 0; r < t->n_rows; r++) {
    deck_node *row = deck_node_new(d, rows, NULL, DECK_LIST, t->place[r]);
    for (size_t c = 0; c < t->n_columns; c++) {
      const char *text = t->text ? t->text[r * t->n_columns + c] : NULL;
      bool number = t->column[c] < COLUMN_NUMBERS;
      deck_node *cell = deck_node_new(d, row, NULL, number ? DECK_FLOAT : DECK_STRING, t->place[r]);
      if (number)
        cell->value.number = t->number[r * t->n_columns + c];
      else
        cell->value.text = text ? text : "";
    }
  }
  for (size_t k = 0; k < file->n; k++) {
    deck_node *key = file->child[k], *copy;
    if (!strcmp(key->name, "columns") || !deck_key_find(&deck_disk_rows, key->name)) continue;
    copy = deck_node_new(d, group, key->name, key->type, key->place);
    deck_node *parent = copy->parent;
    *copy = *key;
    copy->parent = parent;
  }
}

/* Replaces the first entries of `disk_files` in the tree by entries of `disk_rows`, as long as they
 * have few disks in all. Files are read after rows, so the order of the disks does not change. A
 * file whose contacts are used remains a file, since rows have no contacts. */
void deck_echo_files(deck *d) {
  deck_node *files = deck_child(d->root, "disk_files"), *rows = deck_child(d->root, "disk_rows");
  size_t total = 0;
  while (files && files->n) {
    const deck_columns *t = &d->file_tables[0];
    bool empty_text = false;
    for (size_t k = 0; k < t->n_rows * t->n_columns; k++)
      empty_text |= t->column[k % t->n_columns] >= COLUMN_NUMBERS && !(t->text && t->text[k]);
    const bool away = files->n == 1 && d->model->tiles.away && d->model->tiles.of_file;
    total += t->n_rows;
    if (total > MOST_ECHOED || empty_text || t->contacts || away) return;
    if (!rows) rows = deck_node_new(d, d->root, "disk_rows", DECK_LIST, files->place);
    file_to_rows(d, files->child[0], t, rows);
    deck_remove(files, files->child[0]);
    d->file_tables++;
  }
  if (files) deck_remove(d->root, files);
}

/* --- forces and locks ------------------------------------------------------------------------- */

void deck_read_forces(deck *d) {
  deck_group g;
  for (size_t k = 0; deck_next(d, &deck_forces, &k, &g);) {
    deck_bodies bodies = deck_select(&g, false);
    sd_disk added = {0};
    deck_fill(&g, &added);
    for (size_t b = 0; b < bodies.n; b++)
      for (int c = 0; c < SD_COORDINATES; c++)
        d->model->disks[bodies.body[b]].force[c] += added.force[c];
  }
}

/* Locks the coordinates of a disk that a mask has, which a group of `locks` gives. */
static void lock_disk(deck_group *g, uint32_t body, unsigned mask) {
  sd_disk *disk = &g->d->model->disks[body];
  for (int c = 0; c < SD_COORDINATES; c++) {
    if (!(mask >> c & 1)) continue;
    disk->locked[c] = true;
    deck_forget_velocity(g->d, body, c);
    if (disk->velocity[c] != 0)
      deck_fail_key(g, "coordinates", "%s has a velocity there", deck_body_name(g->d, body));
  }
}

void deck_read_locks(deck *d) {
  deck_group g;
  for (size_t k = 0; deck_next(d, &deck_locks, &k, &g);) {
    const deck_bodies bodies = deck_select(&g, false), kept = deck_disks_named(&g, "except");
    const unsigned mask = deck_coordinates(&g, "coordinates");
    enum { APART, LOCKED, KEPT };
    unsigned char *is = memory_new(d->model->n_disks, sizeof *is);
    for (size_t b = 0; b < bodies.n; b++) is[bodies.body[b]] = LOCKED;
    for (size_t b = 0; b < kept.n; b++)
      if (is[kept.body[b]] == APART)
        deck_fail_key(&g, "except", "%s is not among the disks that are locked",
                      deck_body_name(d, kept.body[b]));
      else
        is[kept.body[b]] = KEPT;
    for (size_t b = 0; b < bodies.n; b++)
      if (is[bodies.body[b]] == LOCKED) lock_disk(&g, bodies.body[b], mask);
    free(is);
  }
}

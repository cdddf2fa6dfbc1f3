/* deck_bodies.c: finds disks, groups and walls by name or number, lists the bodies that a group of
 * the deck selects, and reads clumps (`clumps`, and grains of a packing) and body forces
 * (`fields`). See deck_tree.h and deck_values.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "io/deck/deck_read.h"
#include "io/deck/deck_rows.h"
#include "io/deck/deck_values.h"
#include "model/field_kinds.h"

/* --- one body --------------------------------------------------------------------------------- */

/* Returns text to append to the message that a disk is not found: it may be one of the disks that
 * could not be read because of an earlier error; "" if all were read. */
static const char *remark(const deck *d) {
  return d->disks_missing ? " (not all disks could be read, see above)" : "";
}

/* Finds the body with the name or number in `node`. disks, walls: true if the body may be a disk,
 * or a wall. Returns false after an error, which is reported. */
static bool find_body(deck *d, const deck_node *node, bool disks, bool walls, uint32_t *body) {
  const sd_model *m = d->model;
  const char *what = disks && walls ? "disk or wall" : disks ? "disk" : "wall";
  if (node->type == DECK_INT) {
    size_t n = disks ? m->n_disks : m->n_walls;
    if (disks && node->value.integer >= (int64_t)model_held(m) && (uint64_t)node->value.integer < n)
      deck_restart_with_all_disks(d, "the deck speaks of single disks of it");
    if (node->value.integer >= 0 && (uint64_t)node->value.integer < n) {
      *body = (uint32_t)node->value.integer + (disks ? 0 : (uint32_t)m->n_disks);
      return true;
    }
    deck_fail(d, node, "no %s has this number; expected %s%s", disks ? "disk" : "wall",
              n ? deck_format(d, "0 to %zu", n - 1) : "none", disks ? remark(d) : "");
    return false;
  }
  if (node->type != DECK_STRING) {
    deck_fail(d, node, "expected the name or the number of a %s", what);
    return false;
  }
  const char *name = node->value.text;
  if (disks && deck_index_find(&d->disks, name, body)) return true;
  bool wall = walls && (disks ? deck_index_find(&d->walls, name, body)
                              : deck_index_look_up(d, &d->walls, what, node, "", body));
  if (wall) *body += (uint32_t)m->n_disks;
  if (wall || !disks) return wall;
  deck_fail(d, node, "no %s is called that%s", what,
            deck_index_instead(d, &d->disks, walls ? &d->walls : NULL, name, remark(d)));
  return false;
}

bool deck_find_body(deck *d, const deck_node *node, bool walls, uint32_t *body) {
  return find_body(d, node, true, walls, body);
}

static bool find_clump(deck *d, const deck_node *node, uint32_t *body) {
  const sd_model *m = d->model;
  uint32_t k = 0;
  if (node->type == DECK_INT && node->value.integer >= 0 &&
      (uint64_t)node->value.integer < m->n_clumps)
    k = (uint32_t)node->value.integer;
  else if (node->type == DECK_INT)
    deck_fail(d, node, "no clump has this number; expected %s",
              m->n_clumps ? deck_format(d, "0 to %zu", m->n_clumps - 1) : "none");
  else if (!deck_index_look_up(d, &d->clumps, "clump", node, "", &k))
    return false;
  *body = (uint32_t)(m->n_disks + m->n_walls + k);
  return k < m->n_clumps;
}

/* --- many bodies ------------------------------------------------------------------------------ */

static void add(deck *d, deck_bodies *list, uint32_t body) {
  list->body = deck_extend(d, list->body, list->n, &list->capacity, sizeof *list->body);
  list->body[list->n++] = body;
}

static size_t group_of(const void *with, size_t disk) {
  return (size_t)((const sd_model *)with)->disks[disk].group;
}

/* Sorts the numbers of all disks by group. This is done only once, so that the cost is linear in
 * the number of disks even with many groups. */
static void sort_by_group(deck *d) {
  const sd_model *m = d->model;
  const size_t n = model_held(m);
  if (d->grouped.start && d->n_grouped == n) return;
  d->n_grouped = n;
  if (!buckets_new(&d->grouped, n, m->n_groups, group_of, m)) longjmp(d->out_of_memory, 1);
  deck_own(d, d->grouped.start);
  deck_own(d, d->grouped.item);
}

static void add_group(deck *d, const deck_node *node, deck_bodies *list) {
  uint32_t k;
  if (!deck_index_look_up(d, &d->groups, "group of disks", node, remark(d), &k)) return;
  if (k < d->n_away_groups && d->away_group[k])
    deck_restart_with_all_disks(d, "the deck speaks of single disks of it");
  list->group = (int)k;
  sort_by_group(d);
  for (size_t i = d->grouped.start[k]; i < d->grouped.start[k + 1]; i++)
    add(d, list, d->grouped.item[i]);
}

static int by_number(const void *a, const void *b) {
  uint32_t p = *(const uint32_t *)a, q = *(const uint32_t *)b;
  return p < q ? -1 : p > q;
}

deck_bodies deck_disks_named(deck_group *g, const char *key) {
  deck *d = g->d;
  deck_bodies list = {.group = -1};
  deck_node *names = deck_get(g, key);
  for (size_t k = 0; k < deck_each_count(names); k++) {
    const deck_node *node = deck_each(names, k);
    uint32_t found;
    const char *name = node->type == DECK_STRING ? node->value.text : NULL;
    if (name && deck_index_find(&d->groups, name, &found)) {
      add_group(d, node, &list);
    } else if (!name || deck_index_find(&d->disks, name, &found)) {
      if (name || find_body(d, node, true, false, &found)) add(d, &list, found);
    } else {
      deck_fail(d, node, "no disk and no group of disks is called that%s",
                deck_index_instead(d, &d->disks, &d->groups, name, remark(d)));
    }
  }
  return list;
}

deck_bodies deck_select(deck_group *g, bool walls) {
  deck *d = g->d;
  deck_bodies list = {.group = -1};
  deck_node *disk = deck_get(g, "disk"), *group = deck_get(g, "group"),
            *wall = walls ? deck_get(g, "wall") : NULL,
            *clump = walls ? deck_get(g, "clump") : NULL;
  uint32_t body;
  for (size_t k = 0; k < deck_each_count(disk); k++)
    if (find_body(d, deck_each(disk, k), true, false, &body)) add(d, &list, body);
  for (size_t k = 0; k < deck_each_count(group); k++) add_group(d, deck_each(group, k), &list);
  for (size_t k = 0; k < deck_each_count(wall); k++)
    if (find_body(d, deck_each(wall, k), false, true, &body)) add(d, &list, body);
  for (size_t k = 0; k < deck_each_count(clump); k++)
    if (find_clump(d, deck_each(clump, k), &body)) add(d, &list, body);
  list.given = disk || group || wall || clump;
  list.shared = group != NULL;
  if (disk || wall || clump || deck_each_count(group) != 1) list.group = -1;
  size_t named = deck_each_count(disk) + deck_each_count(group) + deck_each_count(wall) +
                 deck_each_count(clump);
  if (named == 0)
    deck_fail_key(g, "disk", "missing: it names no disk; expected disk, group%s",
                  walls ? ", wall or clump" : " or both");
  /* Report bodies that are named twice, since they would get a force, or a motion, twice */
  if (list.n) qsort(list.body, list.n, sizeof *list.body, by_number);
  size_t kept = 0;
  for (size_t k = 0; k < list.n; k++) {
    if (kept && list.body[kept - 1] == list.body[k]) {
      char name[80];
      deck_fail(d, g->node, "%s is named twice",
                sd_model_body_name(d->model, list.body[k], name, sizeof name));
      continue;
    }
    list.body[kept++] = list.body[k];
  }
  list.n = kept;
  return list;
}

/* --- disks ------------------------------------------------------------------------------------ */

int deck_group_number(deck *d, const char *name) {
  sd_model *m = d->model;
  if (!name) return -1;
  uint32_t found;
  if (deck_index_find(&d->groups, name, &found)) return (int)found;
  if ((m->n_groups & (m->n_groups - 1)) == 0)
    m->groups = memory_grow(m->groups, 2 * m->n_groups + 1, sizeof *m->groups);
  m->groups[m->n_groups] = memory_text(name);
  deck_index_add(d, &d->groups, deck_copy(d, name, strlen(name)), (uint32_t)m->n_groups);
  return (int)m->n_groups++;
}

void deck_note_away(deck *d, int group) {
  if (group < 0) return;
  const size_t n = (size_t)group + 1;
  if (n > d->n_away_groups)
    d->away_group = deck_array_grow(d, d->away_group, d->n_away_groups, n, sizeof(bool));
  if (n > d->n_away_groups) d->n_away_groups = n;
  d->away_group[group] = true;
}

void deck_push_disk(deck *d, const sd_disk *disk, const char *name, deck_place place) {
  sd_model *m = d->model;
  size_t capacity = d->disk_capacity;
  d->disk_place = deck_extend(d, d->disk_place, m->n_disks, &d->disk_capacity, sizeof place);
  if (d->disk_capacity > capacity)
    m->disks = deck_grow(d, m->disks, d->disk_capacity, sizeof *m->disks);
  d->disk_place[m->n_disks] = place;
  sd_disk *own = &m->disks[m->n_disks++];
  *own = *disk;
  own->name = memory_text(name);
  if (name && !deck_index_add(d, &d->disks, own->name, (uint32_t)(m->n_disks - 1)))
    deck_fail_place(d, place, "name = \"%s\": two disks have this name", name);
}

static void drop_motion(sd_model *m, uint32_t disk, int c) {
  m->disks[disk].velocity[c] = 0.0;
  for (size_t k = 0; disk < m->n_derivatives && k < SD_DERIVATIVES; k++)
    if (k / 3 == (size_t)c) m->derivatives[disk][k] = 0.0;
}

void deck_forget_velocity(deck *d, uint32_t disk, int c) {
  static const int columns[] = {COLUMN_VX, COLUMN_VY, COLUMN_OMEGA};
  for (size_t k = 0; k < d->n_file_tables; k++) {
    const deck_columns *t = &d->file_tables[k];
    if (t->result && disk >= t->first && disk - t->first < t->n_rows &&
        deck_columns_have(t, columns[c]))
      drop_motion(d->model, disk, c);
  }
}

/* --- adding a clump to the model -------------------------------------------------------------- */

static sd_clump *push(deck *d) {
  sd_model *m = d->model;
  if ((m->n_clumps & (m->n_clumps - 1)) == 0)
    m->clumps = deck_grow(d, m->clumps, 2 * m->n_clumps + 1, sizeof *m->clumps);
  sd_clump *c = &m->clumps[m->n_clumps++];
  *c = (sd_clump){0};
  return c;
}

/* --- clumps by name --------------------------------------------------------------------------- */

static void check_disk(deck *d, const deck_group *g, uint32_t body) {
  const sd_disk *disk = &d->model->disks[body];
  const bool moves =
      disk->velocity[SD_X] != 0 || disk->velocity[SD_Y] != 0 || disk->velocity[SD_THETA] != 0;
  const bool held =
      disk->driven || disk->locked[SD_X] || disk->locked[SD_Y] || disk->locked[SD_THETA];
  const char *what = disk->clump > 0 ? "belongs to another clump already"
                     : held          ? "is fixed or locked; expected `locked` of the clump"
                     : moves         ? "has a velocity of its own; expected velocity of the clump"
                                     : NULL;
  if (what) deck_fail(d, g->node, "%s %s", deck_body_name(d, body), what);
}

static void read_clump(deck_group *g, uint32_t number) {
  deck *d = g->d;
  const size_t before = d->reported;
  const char *name = deck_text_of(g, "name");
  const deck_bodies bodies = deck_select(g, false);
  for (size_t b = 0; b < bodies.n; b++) check_disk(d, g, bodies.body[b]);
  sd_clump c = {0};
  deck_fill(g, &c);
  const unsigned locked = deck_coordinates(g, "locked");
  for (int q = 0; q < SD_COORDINATES; q++) {
    c.locked[q] = locked >> q & 1;
    if (c.locked[q] && fabs(c.velocity[q]) > 0)
      deck_fail_key(g, "locked", "a locked coordinate cannot have a velocity");
  }
  if (d->reported > before) return;
  sd_clump *own = push(d);
  *own = c;
  for (size_t b = 0; b < bodies.n; b++)
    d->model->disks[bodies.body[b]].clump = (int)d->model->n_clumps;
  own->name = memory_text(name);
  if (name && !deck_index_add(d, &d->clumps, deck_copy(d, name, strlen(name)), number))
    deck_fail_key(g, "name", "two clumps have this name");
}

/* Puts the clumps of the deck's list `clumps` in front of the first `packed` clumps, which packings
 * made. Packings are read first because entries of the list may use their disks. */
static void order_clumps(deck *d, size_t packed) {
  sd_model *m = d->model;
  const size_t listed = m->n_clumps - packed;
  if (packed == 0 || listed == 0) return;
  sd_clump *copy = deck_array_grow(d, m->clumps, m->n_clumps, m->n_clumps, sizeof *copy);
  memcpy(m->clumps, copy + packed, listed * sizeof *copy);
  memcpy(m->clumps + listed, copy, packed * sizeof *copy);
  for (size_t i = 0; i < m->n_disks; i++) {
    int *clump = &m->disks[i].clump;
    if (*clump > 0) *clump += (size_t)*clump > packed ? -(int)packed : (int)listed;
  }
}

void deck_read_clumps(deck *d) {
  deck_group g;
  const size_t packed = d->model->n_clumps;
  for (size_t k = 0; deck_next(d, &deck_clumps, &k, &g);) read_clump(&g, (uint32_t)k - 1);
  order_clumps(d, packed);
}

/* --- grains of a packing ---------------------------------------------------------------------- */

/* Shifts the disks of a grain so that its centre of mass, for equal density, is the origin. Sets
 * grain->reach, the radius of the enclosing circle, and grain->area. */
static void centre(deck_grain *grain) {
  double weight = 0, x = 0, y = 0;
  for (size_t k = 0; k < grain->n; k++) {
    const double w = grain->radius[k] * grain->radius[k];
    weight += w;
    x += w * grain->at[k][0];
    y += w * grain->at[k][1];
  }
  for (size_t k = 0; k < grain->n; k++) {
    grain->at[k][0] -= x / weight;
    grain->at[k][1] -= y / weight;
    grain->reach =
        math_max(grain->reach, math_hypot(grain->at[k][0], grain->at[k][1]) + grain->radius[k]);
    grain->area += grain->radius[k] * grain->radius[k];
  }
}

static bool read_pair(deck *d, const deck_node *node, double pair[2]) {
  if (node->type == DECK_LIST && node->n == 2)
    return deck_value_number(d, node->child[0], false, &pair[0]) &&
           deck_value_number(d, node->child[1], false, &pair[1]);
  deck_fail(d, node, "expected two numbers (x, y)");
  return false;
}

bool deck_read_grain(deck_group *packing, deck_grain *grain) {
  deck *d = packing->d;
  deck_node *node = deck_get(packing, "clump");
  deck_group g;
  *grain = (deck_grain){.n = 1, .reach = 1, .area = 1};
  if (!node || !deck_enter(d, node, &deck_packing_clump, &g)) return false;
  const size_t before = d->reported;
  deck_node *at = deck_get(&g, "at"), *radii = deck_get(&g, "radii");
  const size_t n = deck_each_count(at), n_radii = deck_each_count(radii);
  if (n < 1) deck_fail_key(&g, "at", "missing: expected the centres of its disks ([x, y], ...)");
  if (radii && n_radii != 1 && n_radii != n)
    deck_fail(d, radii, "%zu radii for %zu disks; expected one for each, or one for all", n_radii,
              n);
  if (d->reported > before) return false;
  *grain = (deck_grain){.n = n,
                        .radius = deck_alloc(d, n, sizeof(double)),
                        .at = deck_alloc(d, n, sizeof *grain->at)};
  for (size_t k = 0; k < n; k++) {
    read_pair(d, deck_each(at, k), grain->at[k]);
    grain->radius[k] = 1;
    deck_node *radius = radii ? deck_each(radii, n_radii == 1 ? 0 : k) : NULL;
    if (radius && deck_value_number(d, radius, false, &grain->radius[k]) && !(grain->radius[k] > 0))
      deck_fail(d, radius, "expected a number > 0");
  }
  if (d->reported > before) return false;
  centre(grain);
  return true;
}

void deck_push_grain(deck *d, const deck_grain *grain, const sd_disk *like, double radius,
                     double angle, deck_place place) {
  const sd_model *m = d->model;
  double c, s;
  math_sine_cosine(angle, &s, &c);
  push(d);
  for (size_t k = 0; k < grain->n; k++) {
    sd_disk disk = *like;
    disk.radius = radius * grain->radius[k];
    disk.mass = like->mass * grain->radius[k] * grain->radius[k] / grain->area;
    disk.clump = (int)m->n_clumps;
    const double away[] = {radius * (c * grain->at[k][0] - s * grain->at[k][1]),
                           radius * (s * grain->at[k][0] + c * grain->at[k][1])};
    for (int q = 0; q < 2; q++) {
      const double length = m->upper[q] - m->lower[q];
      disk.position[q] += away[q];
      if (m->periodic[q])
        disk.position[q] -= length * floor((disk.position[q] - m->lower[q]) / length);
    }
    deck_push_disk(d, &disk, NULL, place);
  }
}

/* --- body forces ------------------------------------------------------------------------------ */

static void read_field(deck *d, deck_node *node, sd_body_force *field) {
  deck_group g;
  if (!deck_enter(d, node, &deck_fields, &g)) return;
  if (deck_given(&g, "alpha") && !deck_given(&g, "alpha_rotation"))
    deck_default_number(&g, "alpha_rotation", deck_number(&g, "alpha"));
  if (!deck_fill(&g, field)) return;
  if (field->alpha >= 1 || field->alpha_rotation >= 1)
    deck_fail_key(
        &g, field->alpha >= 1 ? "alpha" : "alpha_rotation",
        "it would hold every disk where it is; expected a number below 1, usually 0.1 to 0.8");
  if (field->power < -FIELD_MOST_POWER || field->power > FIELD_MOST_POWER)
    deck_fail_key(&g, "power", "expected a whole number from %d to %d", -FIELD_MOST_POWER,
                  FIELD_MOST_POWER);
  if (!deck_given(&g, "disk") && !deck_given(&g, "group")) return;
  const size_t before = d->reported;
  const deck_bodies on = deck_select(&g, false);
  if (on.n == 0 && d->reported == before)
    deck_fail(d, node, "it acts on no disk: the group is empty");
  field->n_disks = on.n;
  field->disks = deck_keep(d, on.n, sizeof *field->disks);
  if (on.n) memcpy(field->disks, on.body, on.n * sizeof *field->disks);
}

void deck_read_fields(deck *d) {
  sd_model *m = d->model;
  deck_node *list = deck_groups(d, d->root, "fields");
  m->fields = memory_new(list ? list->n : 0, sizeof *m->fields);
  for (size_t k = 0; list && k < list->n; k++) {
    m->n_fields = k + 1;
    read_field(d, list->child[k], &m->fields[k]);
    if (m->fields[k].name && !deck_index_add(d, &d->fields, m->fields[k].name, (uint32_t)k))
      deck_fail_child(d, list->child[k], "name", "two fields have this name");
  }
}

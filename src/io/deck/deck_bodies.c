/* deck_bodies.c: finds disks, groups and walls by name or number, and lists the bodies that a
 * group of the deck selects. See deck_tree.h. */
#include <stdlib.h>

#include "base/memory.h"
#include "io/deck/deck_read.h"
#include "io/deck/deck_rows.h"

/* --- one body --------------------------------------------------------------------------------- */

/* Returns a remark for messages that a name or number is not found: an earlier mistake may have
 * kept out the disk that has it. */
static const char *remark(const deck *d) {
  return d->disks_missing ? " (not all disks could be read, see above)" : "";
}

/* Finds the body of a name or number. disks, walls: whether it may be a disk, or a wall. */
static bool find_body(deck *d, const deck_node *node, bool disks, bool walls, uint32_t *body) {
  const sd_model *m = d->model;
  const char *what = disks && walls ? "disk or wall" : disks ? "disk" : "wall";
  if (node->type == DECK_INT) {
    size_t n = disks ? m->n_disks : m->n_walls;
    if (disks && node->value.integer >= (int64_t)model_held(m) && (uint64_t)node->value.integer < n)
      deck_leave(d, "the deck speaks of single disks of it");
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
  guess near = guess_start(name);
  deck_index_guess(d, &d->disks, &near);
  if (walls) deck_index_guess(d, &d->walls, &near);
  deck_fail(d, node, "no %s is called that%s%s", what,
            near.best ? deck_hint(d, &near) : deck_index_list(d, &d->disks),
            near.best ? "" : remark(d));
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

/* Sorts all disks by group, only once, so that the cost with many groups is linear in the number
 * of disks. */
static void sort_by_group(deck *d) {
  const sd_model *m = d->model;
  const size_t n = model_held(m);
  if (d->group_start && d->n_grouped == n) return;
  d->n_grouped = n;
  d->grouped = deck_alloc(d, n, sizeof *d->grouped);
  d->group_start = deck_alloc(d, m->n_groups + 2, sizeof *d->group_start);
  /* While filling: index at which the next disk of group k goes */
  size_t *end = d->group_start + 1;
  for (size_t i = 0; i < n; i++)
    if (m->disks[i].group >= 0) end[m->disks[i].group + 1]++;
  for (size_t k = 1; k <= m->n_groups; k++) end[k] += end[k - 1];
  for (size_t i = 0; i < n; i++)
    if (m->disks[i].group >= 0) d->grouped[end[m->disks[i].group]++] = (uint32_t)i;
}

static void add_group(deck *d, const deck_node *node, deck_bodies *list) {
  uint32_t k;
  if (!deck_index_look_up(d, &d->groups, "group of disks", node, remark(d), &k)) return;
  if (k < d->n_away_groups && d->away_group[k])
    deck_leave(d, "the deck speaks of single disks of it");
  list->group = (int)k;
  sort_by_group(d);
  for (size_t i = d->group_start[k]; i < d->group_start[k + 1]; i++) add(d, list, d->grouped[i]);
}

static int by_number(const void *a, const void *b) {
  uint32_t p = *(const uint32_t *)a, q = *(const uint32_t *)b;
  return p < q ? -1 : p > q;
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
  /* A body that is named twice would get a force, or a motion, twice */
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
    d->away_group = deck_more(d, d->away_group, d->n_away_groups, n, sizeof(bool));
  if (n > d->n_away_groups) d->n_away_groups = n;
  d->away_group[group] = true;
}

void deck_push_disk(deck *d, const sd_disk *disk, const char *name, const char *group,
                    deck_place place) {
  sd_model *m = d->model;
  size_t capacity = d->disk_capacity;
  d->disk_place = deck_extend(d, d->disk_place, m->n_disks, &d->disk_capacity, sizeof place);
  if (d->disk_capacity > capacity)
    m->disks = deck_grow(d, m->disks, d->disk_capacity, sizeof *m->disks);
  d->disk_place[m->n_disks] = place;
  sd_disk *own = &m->disks[m->n_disks++];
  *own = *disk;
  own->name = memory_text(name);
  own->group = deck_group_number(d, group);
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

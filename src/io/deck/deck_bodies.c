/* deck_bodies.c: names of disks, groups and walls, and which bodies a group of the deck speaks of. See deck.h. */
#include <stdlib.h>
#include <string.h>

#include "io/deck/deck_read.h"

/* Beyond so many names no nearest one is looked for. */
enum { MOST_GUESSES = 10000 };

bool deck_is_driven(const deck *d, size_t disk) {
  const sd_disk *q = &d->model->disks[disk];
  unsigned held = d->held ? d->held[disk] : 0;
  for (int c = 0; c < 3; c++)
    if (q->locked[c]) held |= 1u << c;
  return q->driven || held == 7;
}

static int by_name(const void *a, const void *b) {
  const deck_name *p = a, *q = b;
  int order = strcmp(p->name, q->name);
  return order ? order : p->index < q->index ? -1 : 1;
}

void deck_index_names(deck *d) {
  const sd_model *m = d->model;
  d->disk_names = deck_alloc(d, m->n_disks, sizeof *d->disk_names);
  for (size_t i = 0; i < m->n_disks; i++)
    if (m->disks[i].name) d->disk_names[d->n_disk_names++] = (deck_name){m->disks[i].name, (uint32_t)i};
  if (d->n_disk_names) qsort(d->disk_names, d->n_disk_names, sizeof *d->disk_names, by_name);
  for (size_t k = 1; k < d->n_disk_names; k++)
    if (strcmp(d->disk_names[k].name, d->disk_names[k - 1].name) == 0)
      deck_fail_place(d, d->disk_place[d->disk_names[k].index], "name = \"%s\": two disks have this name",
                      d->disk_names[k].name);
}

/* --- one body --------------------------------------------------------------------------------------------- */

static const char *maybe(deck *d, deck_guess guess) {
  return guess.best ? deck_format(d, "; did you mean \"%s\"?", guess.best) : "";
}

/* A name or a number that is not found may be that of a disk which a mistake further up has kept out. */
static const char *remark(const deck *d) {
  return d->disks_missing ? " (not all disks could be read, see above)" : "";
}

bool deck_disk_called(const deck *d, const char *name, uint32_t *body) {
  size_t low = 0, high = d->n_disk_names;
  while (low < high) {
    size_t middle = (low + high) / 2;
    int order = strcmp(d->disk_names[middle].name, name);
    if (order == 0) {
      *body = d->disk_names[middle].index;
      return true;
    }
    if (order < 0)
      low = middle + 1;
    else
      high = middle;
  }
  return false;
}

static bool wall_by_name(const deck *d, const char *name, uint32_t *body) {
  if (!deck_index_find(&d->walls, name, body)) return false;
  *body += (uint32_t)d->model->n_disks;
  return true;
}

/* disks, walls: which of the two the name may stand for. */
static bool find_body(deck *d, const deck_node *node, bool disks, bool walls, uint32_t *body) {
  const sd_model *m = d->model;
  const char *what = disks && walls ? "disk or wall" : disks ? "disk" : "wall";
  if (node->type == DECK_INT) {
    size_t n = disks ? m->n_disks : m->n_walls;
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
  if (disks && deck_disk_called(d, name, body)) return true;
  if (walls && wall_by_name(d, name, body)) return true;
  deck_guess guess = deck_guess_start(name);
  bool told = deck_told(d);
  for (size_t k = 0; disks && !told && k < d->n_disk_names && k < MOST_GUESSES; k++)
    deck_guess_add(&guess, d->disk_names[k].name);
  for (size_t w = 0; walls && !told && w < m->n_walls && w < MOST_GUESSES; w++)
    deck_guess_add(&guess, m->walls[w].name);
  deck_fail(d, node, "no %s is called that%s%s", what, maybe(d, guess),
            disks && !guess.best ? remark(d) : "");
  return false;
}

bool deck_find_body(deck *d, const deck_node *node, bool walls, uint32_t *body) {
  return find_body(d, node, true, walls, body);
}

/* --- many bodies ------------------------------------------------------------------------------------------ */

static void add(deck *d, deck_bodies *list, uint32_t body) {
  if (list->n == list->capacity) {
    size_t capacity = 2 * list->capacity + 16;
    uint32_t *bodies = deck_alloc(d, capacity, sizeof *bodies);
    if (list->n) memcpy(bodies, list->body, list->n * sizeof *bodies);
    list->body = bodies;
    list->capacity = capacity;
  }
  list->body[list->n++] = body;
}

/* All disks, sorted by group once: many groups cost no more than their disks. */
static void sort_by_group(deck *d) {
  const sd_model *m = d->model;
  if (d->group_start && d->n_grouped == m->n_disks) return;
  d->n_grouped = m->n_disks;
  d->grouped = deck_alloc(d, m->n_disks, sizeof *d->grouped);
  d->group_start = deck_alloc(d, m->n_groups + 2, sizeof *d->group_start);
  size_t *end = d->group_start + 1; /* while they are filled: where group k goes on */
  for (size_t i = 0; i < m->n_disks; i++)
    if (m->disks[i].group >= 0) end[m->disks[i].group + 1]++;
  for (size_t k = 1; k <= m->n_groups; k++) end[k] += end[k - 1];
  for (size_t i = 0; i < m->n_disks; i++)
    if (m->disks[i].group >= 0) d->grouped[end[m->disks[i].group]++] = (uint32_t)i;
}

static void add_group(deck *d, const deck_node *node, deck_bodies *list) {
  const sd_model *m = d->model;
  const char *name = node->type == DECK_STRING ? node->value.text : "";
  uint32_t k;
  if (deck_index_find(&d->groups, name, &k)) {
    list->group = (int)k;
    sort_by_group(d);
    for (size_t i = d->group_start[k]; i < d->group_start[k + 1]; i++) add(d, list, d->grouped[i]);
    return;
  }
  deck_guess guess = deck_guess_start(name);
  for (k = 0; k < m->n_groups && k < MOST_GUESSES && !deck_told(d); k++) deck_guess_add(&guess, m->groups[k]);
  deck_fail(d, node, "no group of disks is called that%s%s", maybe(d, guess), guess.best ? "" : remark(d));
}

static int by_number(const void *a, const void *b) {
  uint32_t p = *(const uint32_t *)a, q = *(const uint32_t *)b;
  return p < q ? -1 : p > q;
}

deck_bodies deck_select(deck *d, deck_group *g, bool walls) {
  deck_bodies list = {.group = -1};
  deck_node *disk = deck_get(g, "disk"), *group = deck_get(g, "group"),
            *wall = walls ? deck_get(g, "wall") : NULL;
  uint32_t body;
  for (size_t k = 0; k < deck_each_count(disk); k++)
    if (find_body(d, deck_each(disk, k), true, false, &body)) add(d, &list, body);
  for (size_t k = 0; k < deck_each_count(group); k++) add_group(d, deck_each(group, k), &list);
  for (size_t k = 0; k < deck_each_count(wall); k++)
    if (find_body(d, deck_each(wall, k), false, true, &body)) add(d, &list, body);
  list.given = disk || group || wall;
  list.shared = group != NULL;
  if (disk || wall || deck_each_count(group) != 1) list.group = -1;
  size_t named = deck_each_count(disk) + deck_each_count(group) + deck_each_count(wall);
  if (named == 0)
    deck_fail_key(d, g->node, "disk", "missing: it names no disk; expected disk, group%s",
                  walls ? " or wall" : " or both");
  /* a body that is named twice would feel a force, or move, twice */
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

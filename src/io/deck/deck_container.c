/* deck_container.c: the group `container`: walls around the disks, by the rows of
 * model/containers.h. See deck_tree.h.
 *
 * The geometry of the container (region, periodic box, interior) is read before disks; the walls
 * and floor disks of the container are added after the bodies that the deck lists, so that the
 * latter keep their numbers. */
#include <math.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "io/deck/deck_read.h"
#include "io/deck/deck_result.h"
#include "model/containers.h"
#include "model/walls.h"

static const char floor_group[] = "floor";

/* --- box -------------------------------------------------------------------------------------- */

/* Edges of the box in the file that the key `file` names; the file is read when the first edge is
 * needed. */
typedef struct file_edges {
  bool tried, found;
  double lower[2], upper[2];
} file_edges;

static bool file_edge(deck_group *g, file_edges *from, int c, double edge[2]) {
  const char *name = deck_text_of(g, "file"), *key = c ? "y" : "x";
  const deck_node *file = deck_get(g, "file");
  if (!file)
    deck_fail_key(g, key, "missing: expected (lower, upper), since the box is periodic in %s", key);
  if (!file || !name) return false;
  if (!from->tried)
    from->found =
        deck_file_format(g->d, name) == DECK_HDF5
            ? deck_result_box(g->d, file, from->lower, from->upper)
            : deck_lammps_box(g->d, file,
                              deck_given(g, "timestep") ? deck_integer(g, "timestep") : -1,
                              from->lower, from->upper);
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

/* --- geometry --------------------------------------------------------------------------------- */

/* Reports the keys of the group `box` that contradict the container. */
static void check_box(deck *d, const deck_shape *shape) {
  static const char *const keys[] = {"x", "y"}, *const directions[] = {"no direction", "x", "y",
                                                                       "x and y"};
  deck_node *box = deck_child(d->root, "box");
  for (int c = 0; c < 2; c++)
    if (deck_child(box, keys[c]))
      deck_fail_child(d, box, keys[c],
                      "given together with container \"%s\", which has its own edges", shape->name);
  const deck_node *periodic = deck_child(box, "periodic");
  if (periodic && periodic->type == DECK_STRING && strcmp(periodic->value.text, "none") != 0)
    deck_fail(d, periodic, "given together with container \"%s\", which is periodic in %s",
              shape->name, directions[container_kind_of(shape->kind)->periodic]);
}

static void set_region(sd_model *m, const container *c) {
  double lower[2], upper[2];
  container_bounds(&c->outline, lower, upper);
  for (int i = 0; i < 2; i++) {
    m->region_lower[i] = c->origin[i] + lower[i];
    m->region_upper[i] = c->origin[i] + upper[i];
    if (!(container_kind_of(c->kind)->periodic >> i & 1)) continue;
    m->periodic[i] = true;
    m->lower[i] = m->region_lower[i];
    m->upper[i] = m->region_upper[i];
  }
}

void deck_read_container(deck *d) {
  deck_node *node = deck_child(d->root, "container");
  deck_group g;
  container *c = d->container = deck_alloc(d, 1, sizeof *c);
  c->open = true;
  if (!node || !deck_enter(d, node, &container_table, &g)) return;
  size_t before = d->reported;
  if (!deck_fill(&g, c)) return;
  if (d->reported == before) container_shape(c);
  if (c->key) deck_fail_key(&g, c->key, "%s", c->expected);
  if (d->reported > before) return;
  d->model->container = (int)c->kind;
  set_region(d->model, c);
  check_box(d, deck_shape_of(&g, "type"));
  const container_kind *kind = container_kind_of(c->kind);
  bool has_bodies = kind->walls[0].name || kind->disk_floor;
  if (has_bodies || deck_get(&g, "material") || d->model->n_materials == 1)
    d->container_material = deck_material(&g);
}

/* --- walls ------------------------------------------------------------------------------------ */

static sd_wall *add_wall(deck *d, const char *name, sd_wall_kind kind) {
  sd_model *m = d->model;
  uint32_t disk;
  if (!deck_index_add(d, &d->walls, name, (uint32_t)m->n_walls) ||
      deck_index_find(&d->disks, name, &disk))
    deck_fail_child(d, deck_child(d->root, "container"), "type",
                    "it has a wall \"%s\", but a wall or a disk of the deck is called so", name);
  m->walls = memory_grow(m->walls, m->n_walls + 1, sizeof *m->walls);
  sd_wall *wall = &m->walls[m->n_walls++];
  *wall = (sd_wall){.material = d->container_material, .kind = kind};
  wall->name = memory_text(name);
  return wall;
}

static void add_along(deck *d, const container_wall *row) {
  const container *c = d->container;
  const container_outline *o = &c->outline;
  sd_wall *wall = add_wall(d, row->name, row->kind);
  wall->n_points = row->n > 0 ? (size_t)row->n : o->n;
  wall->closed = row->n == 0 && o->n > 0;
  if (wall->n_points > 0) wall->points = memory_new(wall->n_points, sizeof *wall->points);
  for (size_t k = 0; k < wall->n_points; k++)
    for (int i = 0; i < 2; i++)
      wall->points[k][i] = c->origin[i] + o->corner[row->n > 0 ? (size_t)row->corner[k] : k][i];
  if (o->n > 0) wall_set_pivot(wall);
  if (row->n > 0) return;
  memcpy(wall->pivot, c->origin, sizeof wall->pivot);
  wall->radius = o->radius;
  wall->inside = o->n == 0;
}

/* Adds the floor of a bed: a row of fixed disks whose tops touch the lower edge of the region. */
static void add_bed(deck *d) {
  const sd_model *m = d->model;
  deck_group g = {d, deck_child(d->root, "container"), &container_table, NULL};
  uint32_t group;
  if (deck_index_find(&d->groups, floor_group, &group))
    deck_fail_key(&g, "type", "its floor is the group \"%s\", but the deck has disks in this group",
                  floor_group);
  double radius = d->container->radius, left = m->region_lower[0],
         width = m->region_upper[0] - left;
  deck_default_number(&g, "spacing", 2 * radius);
  double n = math_max(1, rint(width / deck_number(&g, "spacing")));
  if (n > 1e6) {
    deck_fail_key(&g, "spacing", "the floor would have %g disks; expected 1e6 at most", n);
    return;
  }
  for (size_t k = 0; k < (size_t)n; k++) {
    sd_disk disk = {
        .position = {left + ((double)k + 0.5) * (width / n), m->region_lower[1] - radius},
        .radius = radius,
        /* Any mass will do, since the disk is fixed */
        .mass = 3.14159265358979323846 * radius * radius,
        .material = d->container_material,
        .group = deck_group_number(d, floor_group),
        .driven = true};
    deck_push_disk(d, &disk, NULL, g.node->place);
  }
}

void deck_container_bodies(deck *d) {
  const container_kind *kind = container_kind_of(d->model->container);
  if (kind->disk_floor) add_bed(d);
  for (const container_wall *wall = kind->walls; wall->name; wall++) {
    bool lid = kind->sides[3] && strcmp(wall->name, kind->sides[3]) == 0;
    if (!lid || !d->container->open) add_along(d, wall);
  }
}

/* deck_container.c: the group `container`: a box, a bed, a hopper or a drum, made of walls. See
 * deck_tree.h.
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

static void read_hopper(deck_group *g, const deck_container_values *v, place_interior *in) {
  deck *d = g->d;
  size_t before = d->reported;
  if (!(v->angle >= 0 && v->angle < 1.5))
    deck_fail_key(g, "angle", "expected an inclination from 0 to 1.5, less than a right angle");
  if (v->outlet >= v->width)
    deck_fail_key(g, "outlet", "expected less than the width, %g", v->width);
  in->bottom = v->outlet / 2;
  in->top = v->width / 2;
  in->rise = (v->width - v->outlet) / 2 * math_tan(v->angle);
  if (d->reported == before && in->rise >= v->height * (1 - 1e-9))
    deck_fail_key(g, "height", "the inclined walls alone are %g high; expected more", in->rise);
}

/* Returns the directions in which a kind of container is periodic, as bits: 1 is x, 2 is y. */
static unsigned repeats(int kind) {
  if (kind == SD_CONTAINER_PERIODIC) return 3;
  return kind == SD_CONTAINER_CHANNEL || kind == SD_CONTAINER_BED ? 1 : 0;
}

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
              shape->name, directions[repeats(shape->kind)]);
}

/* Sets the region of the model. The container's origin is the centre of a drum, the lower left
 * corner of a periodic box, and the middle of the lower edge of all other containers. */
static void set_region(sd_model *m, const deck_container_values *v) {
  bool drum = v->kind == SD_CONTAINER_DRUM;
  double size[2] = {drum ? 2 * v->radius : v->width, drum ? 2 * v->radius : v->height};
  double left = v->kind == SD_CONTAINER_PERIODIC ? 0 : size[0] / 2, below = drum ? v->radius : 0;
  const double lower[2] = {v->origin[0] - left, v->origin[1] - below};
  const double upper[2] = {v->origin[0] + (left > 0 ? left : size[0]),
                           v->origin[1] + (drum ? below : size[1])};
  for (int c = 0; c < 2; c++) {
    m->region_lower[c] = lower[c];
    m->region_upper[c] = upper[c];
    if (!(repeats((int)v->kind) >> c & 1)) continue;
    m->periodic[c] = true;
    m->lower[c] = lower[c];
    m->upper[c] = upper[c];
  }
}

void deck_read_container(deck *d) {
  deck_node *node = deck_child(d->root, "container");
  deck_group g;
  deck_container_values *v = d->container = deck_alloc(d, 1, sizeof *v);
  if (!node || !deck_enter(d, node, &deck_container, &g)) return;
  size_t before = d->reported;
  if (!deck_fill(&g, v)) return;
  v->interior =
      (place_interior){.kind = v->kind, .x = v->origin[0], .y = v->origin[1], .radius = v->radius};
  if (v->kind == SD_CONTAINER_HOPPER && d->reported == before) read_hopper(&g, v, &v->interior);
  if (d->reported > before) return;
  d->model->container = v->kind;
  set_region(d->model, v);
  check_box(d, deck_shape_of(&g, "type"));
  if (v->kind != SD_CONTAINER_PERIODIC || deck_get(&g, "material") || d->model->n_materials == 1)
    v->material = deck_material(&g);
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
  *wall = (sd_wall){.material = d->container->material, .kind = kind};
  wall->name = memory_text(name);
  return wall;
}

static void add_straight(deck *d, const char *name, sd_wall_kind kind, size_t n,
                         const double (*points)[2]) {
  sd_wall *wall = add_wall(d, name, kind);
  wall->points = memory_new(n, sizeof *wall->points);
  wall->n_points = n;
  memcpy(wall->points, points, n * sizeof *points);
  wall_set_pivot(wall);
}

static void add_line(deck *d, const char *name, double x0, double y0, double x1, double y1) {
  add_straight(d, name, SD_WALL_LINE, 2, (const double[2][2]){{x0, y0}, {x1, y1}});
}

/* Adds the two side walls of a hopper, each from the top down to the outlet. */
static void add_hopper(deck *d, double top) {
  const place_interior *in = &d->container->interior;
  for (int side = -1; side <= 1; side += 2) {
    const double points[3][2] = {{in->x + side * in->top, top},
                                 {in->x + side * in->top, in->y + in->rise},
                                 {in->x + side * in->bottom, in->y}};
    add_straight(d, side < 0 ? "left" : "right", SD_WALL_POLYLINE, 3, points);
  }
}

static void add_drum(deck *d) {
  sd_wall *drum = add_wall(d, "drum", SD_WALL_CIRCLE);
  drum->inside = true;
  drum->radius = d->container->radius;
  memcpy(drum->pivot, d->container->origin, sizeof drum->pivot);
}

/* Adds the floor of a bed: a row of fixed disks whose tops touch the lower edge of the region. */
static void add_bed(deck *d) {
  const sd_model *m = d->model;
  deck_group g = {d, deck_child(d->root, "container"), &deck_container, NULL};
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
        .material = d->container->material,
        .group = deck_group_number(d, floor_group),
        .driven = true};
    deck_push_disk(d, &disk, NULL, g.node->place);
  }
}

void deck_container_bodies(deck *d) {
  const sd_model *m = d->model;
  const double *low = m->region_lower, *high = m->region_upper;
  switch (m->container) {
    case SD_CONTAINER_NONE:
    case SD_CONTAINER_PERIODIC: break;
    case SD_CONTAINER_BED: add_bed(d); break;
    case SD_CONTAINER_HOPPER: add_hopper(d, high[1]); break;
    case SD_CONTAINER_DRUM: add_drum(d); break;
    case SD_CONTAINER_BOX:
    case SD_CONTAINER_CHANNEL:
      add_line(d, "floor", low[0], low[1], high[0], low[1]);
      if (m->container == SD_CONTAINER_CHANNEL) break;
      add_line(d, "left", low[0], high[1], low[0], low[1]);
      add_line(d, "right", high[0], low[1], high[0], high[1]);
      if (!d->container->open) add_line(d, "lid", high[0], high[1], low[0], high[1]);
      break;
  }
}

/* deck_container.c: the group `container`: a box, a bed, a hopper or a drum, made of walls. See deck.h.
 *
 * What it says about space (region, periodic box, interior) is needed before disks are read; its walls and the
 * disks of its floor come after those of the deck, so that these keep their numbers.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/deck/deck_read.h"
#include "pack/place.h"

static const char floor_group[] = "floor";

static void set_region(sd_model *m, double x0, double x1, double y0, double y1, bool periodic_x,
                       bool periodic_y) {
  const double lower[2] = {x0, y0}, upper[2] = {x1, y1};
  for (int c = 0; c < 2; c++) {
    m->region_lower[c] = lower[c];
    m->region_upper[c] = upper[c];
    if (!(c == SD_X ? periodic_x : periodic_y)) continue;
    m->periodic[c] = true;
    m->lower[c] = lower[c];
    m->upper[c] = upper[c];
  }
}

static void read_hopper(deck_group *g, double width, double height, place_interior *in) {
  deck *d = g->d;
  size_t before = d->reported;
  double outlet = deck_number(g, "outlet"), angle = deck_number(g, "angle");
  if (!(angle >= 0 && angle < 1.5))
    deck_fail_key(d, g->node, "angle", "expected an inclination from 0 to 1.5, less than a right angle");
  if (outlet >= width) deck_fail_key(d, g->node, "outlet", "expected less than the width, %g", width);
  in->bottom = outlet / 2;
  in->top = width / 2;
  in->rise = (width - outlet) / 2 * tan(angle);
  if (d->reported == before && in->rise >= height * (1 - 1e-9))
    deck_fail_key(d, g->node, "height", "the inclined walls alone are %g high; expected more", in->rise);
}

static const char *periodic_in(int kind) {
  return kind == SD_CONTAINER_PERIODIC                              ? "x and y"
         : kind == SD_CONTAINER_CHANNEL || kind == SD_CONTAINER_BED ? "x"
                                                                    : "no direction";
}

/* The container says what the box would say. */
static void check_box(deck *d, const deck_shape *shape) {
  static const char *const keys[] = {"x", "y"};
  deck_node *box = deck_child(d->root, "box");
  for (int c = 0; c < 2; c++)
    if (deck_child(box, keys[c]))
      deck_fail_key(d, box, keys[c], "given together with container \"%s\", which has its own edges",
                    shape->name);
  const deck_node *periodic = deck_child(box, "periodic");
  if (periodic && periodic->type == DECK_STRING && strcmp(periodic->value.text, "none") != 0)
    deck_fail(d, periodic, "given together with container \"%s\", which is periodic in %s", shape->name,
              periodic_in(shape->kind));
}

void deck_read_container(deck *d) {
  sd_model *m = d->model;
  deck_node *node = deck_child(d->root, "container");
  deck_group g;
  place_interior *in = d->interior = deck_alloc(d, 1, sizeof *in);
  if (!node || !deck_enter(d, node, &deck_container, &g)) return;
  size_t before = d->reported;
  int choice = deck_choice(&g, "type");
  if (choice < 0) return;
  deck_check_shape(&g, &deck_container_kinds[choice], deck_container_kinds, deck_container_kind_count);
  sd_container_kind kind = (sd_container_kind)deck_container_kinds[choice].kind;
  double origin[2], width = 0, height = 0, radius = 0;
  deck_pair(&g, "origin", origin);
  if (kind == SD_CONTAINER_DRUM || kind == SD_CONTAINER_BED) radius = deck_number(&g, "radius");
  if (kind != SD_CONTAINER_DRUM) {
    width = deck_number(&g, "width");
    height = deck_number(&g, "height");
  }
  if (kind == SD_CONTAINER_BOX) deck_bool(&g, "open");
  *in = (place_interior){.kind = kind, .x = origin[0], .y = origin[1], .radius = radius};
  if (kind == SD_CONTAINER_HOPPER) read_hopper(&g, width, height, in);
  if (m->n_materials == 1) deck_default_text(&g, "material", m->materials[0].name);
  if (kind != SD_CONTAINER_PERIODIC && !deck_get(&g, "material"))
    deck_fail_key(d, node, "material", "missing: expected the name of a material");
  if (d->reported > before) return;
  m->container = kind;
  double x = origin[0], y = origin[1], half = width / 2;
  bool wraps = kind == SD_CONTAINER_CHANNEL || kind == SD_CONTAINER_BED;
  if (kind == SD_CONTAINER_DRUM)
    set_region(m, x - radius, x + radius, y - radius, y + radius, false, false);
  else if (kind == SD_CONTAINER_PERIODIC)
    set_region(m, x, x + width, y, y + height, true, true);
  else
    set_region(m, x - half, x + half, y, y + height, wraps, false);
  check_box(d, &deck_container_kinds[choice]);
}

/* --- walls ---------------------------------------------------------------------------------------------- */

static sd_wall *new_wall(deck_group *g, const char *name, int material) {
  deck *d = g->d;
  sd_model *m = d->model;
  uint32_t disk;
  if (!deck_index_add(d, &d->walls, name, (uint32_t)m->n_walls) || deck_disk_called(d, name, &disk))
    deck_fail_key(d, g->node, "type", "it has a wall \"%s\", but a wall or a disk of the deck is called so",
                  name);
  m->walls = deck_grow(d, m->walls, m->n_walls + 1, sizeof *m->walls);
  sd_wall *wall = &m->walls[m->n_walls++];
  *wall = (sd_wall){.material = material};
  wall->name = deck_keep_text(d, name);
  return wall;
}

static void straight(deck_group *g, const char *name, int material, sd_wall_kind kind, size_t n,
                     const double (*points)[2]) {
  sd_wall *wall = new_wall(g, name, material);
  wall->kind = kind;
  wall->points = deck_keep(g->d, n, sizeof *wall->points);
  wall->n_points = n;
  memcpy(wall->points, points, n * sizeof *points);
  for (size_t k = 0; k < n; k++)
    for (int c = 0; c < 2; c++) wall->pivot[c] += points[k][c] / (double)n;
}

static void line(deck_group *g, const char *name, int material, double x0, double y0, double x1, double y1) {
  straight(g, name, material, SD_WALL_LINE, 2, (const double[2][2]){{x0, y0}, {x1, y1}});
}

static void add_box(deck_group *g, int material, const double *low, const double *high) {
  line(g, "floor", material, low[0], low[1], high[0], low[1]);
  line(g, "left", material, low[0], high[1], low[0], low[1]);
  line(g, "right", material, high[0], low[1], high[0], high[1]);
  if (!deck_bool(g, "open")) line(g, "lid", material, high[0], high[1], low[0], high[1]);
}

/* From the top down to the edge of the outlet. */
static void add_hopper(deck_group *g, int material, double top) {
  const place_interior *in = g->d->interior;
  for (int side = -1; side <= 1; side += 2) {
    const double points[3][2] = {{in->x + side * in->top, top},
                                 {in->x + side * in->top, in->y + in->rise},
                                 {in->x + side * in->bottom, in->y}};
    straight(g, side < 0 ? "left" : "right", material, SD_WALL_POLYLINE, 3, points);
  }
}

/* A row of fixed disks, whose tops are the floor. */
static void add_bed(deck_group *g, int material) {
  deck *d = g->d;
  const sd_model *m = d->model;
  for (size_t k = 0; k < m->n_groups; k++)
    if (strcmp(m->groups[k], floor_group) == 0)
      deck_fail_key(d, g->node, "type", "its floor is the group \"%s\", but the deck has disks in this group",
                    floor_group);
  double radius = deck_number(g, "radius"), left = m->region_lower[0], width = m->region_upper[0] - left;
  deck_default_number(g, "spacing", 2 * radius);
  double n = fmax(1, rint(width / deck_number(g, "spacing")));
  if (n > 1e6) {
    deck_fail_key(d, g->node, "spacing", "the floor would have %g disks; expected 1e6 at most", n);
    return;
  }
  for (size_t k = 0; k < (size_t)n; k++) {
    sd_disk disk = {.position = {left + ((double)k + 0.5) * (width / n), m->region_lower[1] - radius},
                    .radius = radius,
                    .mass = 3.14159265358979323846 * radius * radius, /* never felt */
                    .material = material,
                    .driven = true};
    deck_push_disk(d, &disk, NULL, floor_group, g->node->place);
  }
}

void deck_container_bodies(deck *d) {
  sd_model *m = d->model;
  deck_group g = {d, deck_child(d->root, "container"), &deck_container};
  if (m->container == SD_CONTAINER_NONE || m->container == SD_CONTAINER_PERIODIC) return;
  const char *name = deck_text_of(&g, "material");
  int material = name ? deck_material(d, deck_get(&g, "material"), name) : -1;
  const double *low = m->region_lower, *high = m->region_upper;
  switch (m->container) {
    case SD_CONTAINER_BOX: add_box(&g, material, low, high); break;
    case SD_CONTAINER_CHANNEL: line(&g, "floor", material, low[0], low[1], high[0], low[1]); break;
    case SD_CONTAINER_BED: add_bed(&g, material); break;
    case SD_CONTAINER_HOPPER: add_hopper(&g, material, high[1]); break;
    case SD_CONTAINER_DRUM: {
      sd_wall *drum = new_wall(&g, "drum", material);
      drum->kind = SD_WALL_CIRCLE;
      drum->inside = true;
      drum->radius = d->interior->radius;
      for (int c = 0; c < 2; c++) drum->pivot[c] = c ? d->interior->y : d->interior->x;
      break;
    }
    default: break;
  }
}

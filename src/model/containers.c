/* containers.c: kinds of containers, their corners, walls and keys (see containers.h). */
#include "model/containers.h"

#include <math.h>
#include <stdio.h>

#include "base/math.h"
#include "base/quadrature.h"
#include "model/keys.h"

/* --- shapes ----------------------------------------------------------------------------------- */

static void corners(container *c, size_t n, const double (*at)[2]) {
  c->outline.n = n;
  for (size_t k = 0; k < n; k++)
    for (int i = 0; i < 2; i++) c->outline.corner[k][i] = at[k][i];
}

static void rectangle(container *c) {
  double half = c->width / 2, top = c->height;
  corners(c, 4, (const double[4][2]){{-half, 0}, {half, 0}, {half, top}, {-half, top}});
}

static void periodic_box(container *c) {
  double wide = c->width, top = c->height;
  corners(c, 4, (const double[4][2]){{0, 0}, {wide, 0}, {wide, top}, {0, top}});
}

static void hopper(container *c) {
  double low = c->outlet / 2, half = c->width / 2, top = c->height;
  double rise = (c->width - c->outlet) / 2 * math_tan(c->angle);
  if (!(c->angle >= 0 && c->angle < 1.5)) {
    c->key = "angle";
    snprintf(c->expected, sizeof c->expected,
             "expected an inclination from 0 to 1.5, less than a right angle");
  } else if (c->outlet >= c->width) {
    c->key = "outlet";
    snprintf(c->expected, sizeof c->expected, "expected less than the width, %g", c->width);
  } else if (rise >= c->height * (1 - 1e-9)) {
    c->key = "height";
    snprintf(c->expected, sizeof c->expected, "the inclined walls alone are %g high; expected more",
             rise);
  }
  corners(c, 6,
          (const double[6][2]){
              {-low, 0}, {low, 0}, {half, rise}, {half, top}, {-half, top}, {-half, rise}});
}

static void drum(container *c) {
  c->open = false;
  c->outline.radius = c->radius;
}

/* Corners on the circle of the given radius; one side is level, at the bottom, unless `angle`
 * turns it. */
static void polygon(container *c) {
  c->open = false;
  if (c->sides < 3 || c->sides > CONTAINER_CORNERS) {
    c->key = "sides";
    snprintf(c->expected, sizeof c->expected, "expected from 3 to %d", CONTAINER_CORNERS);
    return;
  }
  c->outline.n = (size_t)c->sides;
  for (size_t k = 0; k < c->outline.n; k++) {
    double turn = (2 * (double)k - 1) * M_PI / (double)c->sides - M_PI / 2 + c->angle, sine, cosine;
    math_sine_cosine(turn, &sine, &cosine);
    c->outline.corner[k][0] = c->radius * cosine;
    c->outline.corner[k][1] = c->radius * sine;
  }
}

/* --- kinds ------------------------------------------------------------------------------------ */

static const deck_shape words[] = {
    {"box", SD_CONTAINER_BOX, "width* height* open",
     "walls `floor`, `left`, `right`, and `lid` unless open; straight lines"},
    {"channel", SD_CONTAINER_CHANNEL, "width* height*", "periodic in x over a flat wall `floor`"},
    {"bed", SD_CONTAINER_BED, "width* height* radius* spacing",
     "periodic in x over fixed disks, group `floor`"},
    {"hopper", SD_CONTAINER_HOPPER, "width* height* outlet* angle*",
     "walls `left` and `right`, inclined towards the outlet at the origin"},
    {"drum", SD_CONTAINER_DRUM, "radius*", "round wall `drum`, disks inside"},
    {"polygon", SD_CONTAINER_POLYGON, "radius* sides* angle",
     "regular polygon, wall `polygon`, disks inside; a level side below"},
    {"periodic", SD_CONTAINER_PERIODIC, "width* height*", "periodic in x and y, no walls"},
    LAST_WORD,
};

#define FLOOR                                                                                      \
  {                                                                                                \
    "floor", SD_WALL_LINE, 2, { 0, 1 }                                                             \
  }

static const container_kind kinds[] = {
    [SD_CONTAINER_BOX] = {.rectangle = true,
                          .shape = rectangle,
                          .walls = {FLOOR,
                                    {"left", SD_WALL_LINE, 2, {3, 0}},
                                    {"right", SD_WALL_LINE, 2, {1, 2}},
                                    {"lid", SD_WALL_LINE, 2, {2, 3}}},
                          .sides = {"left", "right", "floor", "lid"}},
    [SD_CONTAINER_CHANNEL] = {.rectangle = true,
                              .periodic = 1,
                              .shape = rectangle,
                              .walls = {FLOOR},
                              .sides = {NULL, NULL, "floor", NULL}},
    [SD_CONTAINER_BED] = {.rectangle = true, .periodic = 1, .disk_floor = true, .shape = rectangle},
    [SD_CONTAINER_HOPPER] = {.outlet = true,
                             .shape = hopper,
                             .walls = {{"left", SD_WALL_POLYLINE, 3, {4, 5, 0}},
                                       {"right", SD_WALL_POLYLINE, 3, {3, 2, 1}}},
                             .sides = {"left", "right", "left", NULL}},
    [SD_CONTAINER_DRUM] = {.shape = drum,
                           .walls = {{"drum", SD_WALL_CIRCLE, 0, {0}}},
                           .sides = {"drum", "drum", "drum", "drum"}},
    [SD_CONTAINER_PERIODIC] = {.rectangle = true, .periodic = 3, .shape = periodic_box},
    [SD_CONTAINER_POLYGON] = {.shape = polygon,
                              .walls = {{"polygon", SD_WALL_POLYLINE, 0, {0}}},
                              .sides = {"polygon", "polygon", "polygon", "polygon"}},
};

const container_kind *container_kind_of(int kind) {
  static const container_kind none = {.rectangle = true};
  bool known = kind > SD_CONTAINER_NONE && (size_t)kind < COUNT(kinds);
  return known ? &kinds[kind] : &none;
}

static const deck_key keys[] = {
    {"type", CHOICE, "required", words, "see below", SETS(container, kind)},
    {"width", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "inner width", SETS(container, width)},
    {"height", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "inner height", SETS(container, height)},
    {"radius", NUMBER(DECK_POSITIVE, "length"), "-", NULL,
     "of a drum; from centre to corner of a polygon; of the floor disks of a bed",
     SETS(container, radius)},
    {"sides", INTEGER(DECK_AT_LEAST_1, "-"), "-", NULL, "polygon: number of sides, 3 to 64",
     SETS(container, sides)},
    {"spacing", NUMBER(DECK_POSITIVE, "length"), "(twice the radius)", NULL,
     "bed: distance of floor disks, fitted to the width"},
    {"outlet", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "hopper: width of its opening",
     SETS(container, outlet)},
    {"angle", ANGLE("rad"), "-", NULL,
     "hopper: inclination of its lower walls, 0: a flat bottom; polygon: turned by, 0 if absent",
     SETS(container, angle)},
    {"origin", NUMBERS(DECK_ANY, "length"), "(0.0, 0.0)", NULL,
     "middle of floor or outlet; centre of a drum or polygon; lower left corner of a periodic box",
     SETS(container, origin)},
    {"open", BOOL, "true", NULL, "box: without a lid", SETS(container, open)},
    {"material", TEXT, "(the only one)", NULL, "material of its walls"},
};
TABLE(container_table, "container", true,
      "Walls around the disks; also the region of `packings` and `bounds`.", keys);

/* --- geometry --------------------------------------------------------------------------------- */

void container_shape(container *c) {
  if (container_kind_of(c->kind)->shape) container_kind_of(c->kind)->shape(c);
}

void container_bounds(const container_outline *o, double lower[2], double upper[2]) {
  for (int i = 0; i < 2; i++) {
    lower[i] = o->n > 0 ? HUGE_VAL : o->centre[i] - o->radius;
    upper[i] = o->n > 0 ? -HUGE_VAL : o->centre[i] + o->radius;
    for (size_t k = 0; k < o->n; k++) {
      lower[i] = math_min(lower[i], o->corner[k][i]);
      upper[i] = math_max(upper[i], o->corner[k][i]);
    }
  }
}

/* Returns x on the straight line from the lower to the upper of two corners. */
static double x_at(const double lower[2], const double upper[2], double y) {
  return lower[0] + (upper[0] - lower[0]) * ((y - lower[1]) / (upper[1] - lower[1]));
}

bool container_span(const container *c, double y, double span[2]) {
  const container_outline *o = &c->outline;
  double at = y - c->origin[1], lower[2], upper[2];
  span[0] = -HUGE_VAL;
  span[1] = HUGE_VAL;
  if (container_kind_of(c->kind)->rectangle) return true;
  if (o->n == 0) {
    double square = o->radius * o->radius - at * at;
    span[1] = sqrt(math_max(square, 0));
    span[0] = -span[1];
    return square >= 0;
  }
  container_bounds(o, lower, upper);
  if (c->open) at = math_min(at, upper[1]);
  span[0] = HUGE_VAL;
  span[1] = -HUGE_VAL;
  for (size_t k = 0; k < o->n; k++) {
    const double *p = o->corner[k], *q = o->corner[k + 1 < o->n ? k + 1 : 0];
    if (p[1] > q[1]) {
      const double *higher = p;
      p = q;
      q = higher;
    }
    if (!(p[1] <= at && at <= q[1] && p[1] < q[1])) continue;
    span[0] = math_min(span[0], x_at(p, q, at));
    span[1] = math_max(span[1], x_at(p, q, at));
  }
  return span[0] <= span[1];
}

bool container_holds(const container *c, const double lower[2], const double upper[2]) {
  for (int side = 0; side < 2; side++) {
    double span[2], slack = 1e-12 * (upper[0] - lower[0]);
    if (!container_span(c, side ? upper[1] : lower[1], span) ||
        lower[0] - c->origin[0] < span[0] - slack || upper[0] - c->origin[0] > span[1] + slack)
      return false;
  }
  return true;
}

double container_wide_from(const container *c, double half) {
  const container_outline *o = &c->outline;
  if (container_kind_of(c->kind)->rectangle) return -HUGE_VAL;
  for (size_t k = 0; k + 1 < o->n; k++) {
    const double *p = o->corner[k], *q = o->corner[k + 1];
    if (!(q[0] > p[0] && q[1] >= p[1] && q[0] > 0)) continue;
    if (half <= q[0] || o->corner[k + 2 < o->n ? k + 2 : 0][0] <= q[0])
      return c->origin[1] + p[1] + (q[1] - p[1]) * math_min(1, (half - p[0]) / (q[0] - p[0]));
  }
  return -HUGE_VAL;
}

typedef struct strip {
  const container *inside;
  double lower, upper;
} strip;

static double width_at(double y, void *user) {
  const strip *s = user;
  double span[2], x = s->inside->origin[0];
  if (!container_span(s->inside, y, span)) return 0;
  return math_max(0, math_min(s->upper, x + span[1]) - math_max(s->lower, x + span[0]));
}

double container_area(const container *c, const double lower[2], const double upper[2]) {
  if (container_kind_of(c->kind)->rectangle) return (upper[0] - lower[0]) * (upper[1] - lower[1]);
  strip s = {c, lower[0], upper[0]};
  return quadrature(width_at, &s, lower[1], upper[1]);
}

/* deck_motion.c: reads the list `motions`. See deck_tree.h.
 *
 * One entry of the deck becomes one motion of the model for each coordinate; random motions with
 * independent signals become one for each body and coordinate. Each random motion
 * has its own stream of random numbers. The number of the stream encodes what the motion drives,
 *   index (24 bits) | ordinal (4) | coordinate (2) | kind of driven thing (2),
 * so that it does not change when other motions are added or removed. Driven things are disks,
 * walls, groups and lists of bodies; the ordinal counts the random motions that add up on the same
 * coordinate of the same thing. */
#include <math.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "io/deck/deck_rows.h"
#include "model/motions.h"

/* Largest number of rows of a motion's table that the full deck shows in place of the file's
 * name. */
enum { MOST_ECHOED = 1000 };

/* Number of random motions so far on each coordinate of each driven body, group or list of
 * bodies. */
typedef struct streams {
  /* [kind of driven thing]: array with index SD_MOVED * (number of the thing) + coordinate */
  unsigned char *used[STREAM_THINGS];
} streams;

static const double pi = 3.14159265358979323846;

static void read_omega(deck_group *g, sd_motion *motion) {
  if (deck_given(g, "frequency"))
    motion->omega = 2 * pi * deck_number(g, "frequency");
  else if (deck_get(g, "omega") && motion->omega <= 0)
    deck_fail_key(g, "omega", "expected an angular frequency > 0");
}

/* Sets the amplitude that follows from the key `acceleration`, the largest acceleration in units
 * of g (motion_kind.amplitude). */
static void read_acceleration(deck_group *g, sd_motion *motion, unsigned mask) {
  const motion_kind *kind = &motion_kinds[motion->kind];
  /* If this kind of motion has no key `acceleration`, deck_fill has reported it */
  if (!deck_given(g, "acceleration") || !kind->amplitude) return;
  const double *gravity = g->d->model->gravity;
  double strength = math_hypot(gravity[0], gravity[1]), w = motion->omega;
  if (mask >> SD_THETA & 1)
    deck_fail_key(g, "acceleration", "theta has none in units of g; expected amplitude");
  if (!(strength > 0))
    deck_fail_key(g, "acceleration", "in units of g, but there is no gravity; expected amplitude");
  motion->amplitude = kind->amplitude(motion, deck_number(g, "acceleration") * strength / (w * w));
}

/* --- tables ----------------------------------------------------------------------------------- */

static size_t read_list(deck *d, deck_node *list, double **out) {
  if (!list || list->type != DECK_LIST) {
    if (list) deck_fail(d, list, "expected a list of numbers (0.0, 0.5, ...)");
    return 0;
  }
  *out = deck_alloc(d, list->n, sizeof(double));
  for (size_t k = 0; k < list->n; k++) deck_value_number(d, list->child[k], false, &(*out)[k]);
  return list->n;
}

/* Replaces the name of a file in the tree by lists of the numbers in it, for the full deck. */
static void table_to_lists(deck_group *g, size_t n, const double *time, const double *value) {
  static const char *const file_keys[] = {"file", "columns"}, *const list_keys[] = {"times",
                                                                                    "values"};
  for (int k = 0; k < 2; k++) deck_remove(g->node, deck_get(g, file_keys[k]));
  for (int k = 0; k < 2; k++) {
    deck_node *list = deck_default_list(g, list_keys[k]);
    list->defaulted = false;
    for (size_t r = 0; r < n; r++)
      deck_node_new(g->d, list, NULL, DECK_FLOAT, list->place)->value.number =
          k ? value[r] : time[r];
  }
}

static size_t read_table_file(deck_group *g, double **time, double **value) {
  deck *d = g->d;
  const char *names[2] = {"time", "value"};
  deck_node *file = deck_get(g, "file"), *columns = deck_get(g, "columns");
  if (!deck_text_of(g, "file")) return 0;
  if (columns && (deck_each_count(columns) != 2 || columns->type != DECK_LIST)) {
    deck_fail(d, columns, "expected the names of two columns (\"time\", \"value\")");
    return 0;
  }
  for (size_t k = 0; columns && k < 2; k++) {
    if (columns->child[k]->type != DECK_STRING) {
      deck_fail(d, columns->child[k], "expected the name of a column in quotes");
      return 0;
    }
    names[k] = columns->child[k]->value.text;
  }
  size_t before = d->reported, n = deck_csv_pair(d, file, names, time, value);
  return d->reported > before ? 0 : n;
}

static void read_table(deck_group *g, sd_motion *motion) {
  deck *d = g->d;
  double *time = NULL, *value = NULL;
  size_t n, before = d->reported;
  bool from_file = deck_given(g, "file");
  deck_node *at = deck_get(g, from_file ? "file" : "times");
  if (from_file) {
    if (deck_given(g, "values"))
      deck_fail_key(g, "values", "given together with file; expected one of them");
    n = read_table_file(g, &time, &value);
  } else {
    n = read_list(d, at, &time);
    if (!deck_get(g, "values"))
      deck_fail_key(g, "values", "missing: expected a value for each of times");
    if (read_list(d, deck_get(g, "values"), &value) != n && d->reported == before)
      deck_fail_key(g, "values", "expected as many values as times (%zu)", n);
  }
  if (d->reported > before || !at) return;
  if (n < 3) deck_fail(d, at, "expected a table of at least 3 rows, it has %zu", n);
  for (size_t r = 1; r < n; r++)
    if (!(time[r] > time[r - 1])) {
      deck_fail(d, at, "times must increase, but row %zu has %g after %g", r, time[r], time[r - 1]);
      break;
    }
  if (motion->periodic && n && value[0] != value[n - 1])
    deck_fail_key(g, "periodic", "the last value (%g) must equal the first (%g)", value[n - 1],
                  value[0]);
  if (d->reported > before) return;
  motion->n_table = n;
  /* The arrays are in the arena of the deck; each motion of the model gets its own copy */
  motion->table_time = time;
  motion->table_value = value;
  if (from_file && n <= MOST_ECHOED) table_to_lists(g, n, time, value);
}

/* --- into the model --------------------------------------------------------------------------- */

static void push(deck *d, const sd_motion *like, size_t entry, int coordinate, size_t n,
                 const uint32_t *bodies) {
  sd_model *m = d->model;
  const size_t capacity = d->motion_capacity;
  d->motion_entry =
      deck_extend(d, d->motion_entry, m->n_motions, &d->motion_capacity, sizeof entry);
  if (d->motion_capacity > capacity)
    m->motions = memory_grow(m->motions, d->motion_capacity, sizeof *m->motions);
  sd_motion *motion = &m->motions[m->n_motions];
  *motion = *like;
  motion->name = memory_text(like->name);
  motion->bodies = NULL;
  motion->table_time = motion->table_value = NULL;
  d->motion_entry[m->n_motions++] = entry;
  motion->coordinate = coordinate;
  motion->n_bodies = n;
  motion->bodies = deck_keep(d, n, sizeof *bodies);
  memcpy(motion->bodies, bodies, n * sizeof *bodies);
  if (like->n_table) {
    motion->table_time = deck_keep(d, like->n_table, sizeof(double));
    motion->table_value = deck_keep(d, like->n_table, sizeof(double));
    memcpy(motion->table_time, like->table_time, like->n_table * sizeof(double));
    memcpy(motion->table_value, like->table_value, like->n_table * sizeof(double));
  }
}

static uint32_t stream_of(deck *d, const deck_node *node, streams *s, int thing, size_t index,
                          int coordinate) {
  if (index >= STREAM_INDICES) {
    deck_fail(d, node, "random motions reach disks and walls up to number %d only",
              STREAM_INDICES - 1);
    return 0;
  }
  unsigned char *used = &s->used[thing][SD_MOVED * index + (size_t)coordinate];
  if (*used == STREAM_ORDINALS) {
    deck_fail(d, node, "more than %d random motions on one coordinate of one body",
              STREAM_ORDINALS);
    return 0;
  }
  unsigned ordinal = (*used)++;
  return stream_number(thing, (uint32_t)index, ordinal, coordinate);
}

static void push_random(deck *d, deck_group *g, sd_motion *motion, size_t entry,
                        const deck_bodies *bodies, unsigned mask, streams *s) {
  size_t n_disks = d->model->n_disks;
  deck_default_bool(g, "independent", !bodies->shared);
  bool independent = deck_bool(g, "independent");
  for (int c = 0; c < SD_MOVED; c++) {
    if (!(mask >> c & 1)) continue;
    if (!independent) {
      int thing = bodies->group >= 0 ? STREAM_GROUP : STREAM_LIST;
      size_t index = bodies->group >= 0 ? (size_t)bodies->group : bodies->body[0];
      motion->stream = stream_of(d, g->node, s, thing, index, c);
      push(d, motion, entry, c, bodies->n, bodies->body);
      continue;
    }
    for (size_t b = 0; b < bodies->n; b++) {
      uint32_t body = bodies->body[b];
      bool disk = body < n_disks;
      motion->stream = stream_of(d, g->node, s, disk ? STREAM_DISK : STREAM_WALL,
                                 disk ? body : body - n_disks, c);
      push(d, motion, entry, c, 1, &body);
    }
  }
}

static void check_held(deck *d, deck_group *g, const deck_bodies *bodies, unsigned mask) {
  const sd_model *m = d->model;
  const size_t walls = m->n_disks + m->n_walls;
  for (size_t b = 0; b < bodies->n; b++) {
    const uint32_t body = bodies->body[b];
    if (body >= m->n_disks && body < walls) continue;
    const bool *locked = body < walls ? m->disks[body].locked : m->clumps[body - walls].locked;
    for (int c = 0; body < walls && c < 3; c++)
      if (mask >> c & 1) deck_forget_velocity(d, body, c);
    const double *velocity =
        body < walls ? m->disks[body].velocity : m->clumps[body - walls].velocity;
    for (int c = 0; c < 3; c++) {
      if (!(mask >> c & 1) || !(locked[c] || fabs(velocity[c]) > 0)) continue;
      char name[80];
      deck_fail_key(g, "coordinate", "%s of %s is %s, and cannot be moved too",
                    c == 0   ? "x"
                    : c == 1 ? "y"
                             : "theta",
                    sd_model_body_name(d->model, bodies->body[b], name, sizeof name),
                    locked[c] ? "locked" : "given a velocity of its own");
    }
  }
}

static void check_surface(deck *d, deck_group *g, const deck_bodies *bodies, unsigned mask) {
  for (size_t b = 0; mask >> SD_SURFACE & 1 && b < bodies->n; b++) {
    const uint32_t body = bodies->body[b];
    if (body >= d->model->n_disks && body < d->model->n_disks + d->model->n_walls) continue;
    deck_fail_key(g, "coordinate", "\"surface\" of %s: only walls have one; others turn, \"theta\"",
                  deck_body_name(d, body));
    return;
  }
}

static void check_clumped(deck *d, deck_group *g, const deck_bodies *bodies) {
  const sd_model *m = d->model;
  for (size_t b = 0; b < bodies->n; b++) {
    const uint32_t body = bodies->body[b];
    if (body >= m->n_disks || m->disks[body].clump == 0) continue;
    const uint32_t whole = (uint32_t)sd_model_bodies(m) + (uint32_t)m->disks[body].clump - 1;
    deck_fail_key(g, deck_given(g, "disk") ? "disk" : "group",
                  "%s belongs to %s; expected `clump`, which moves the whole",
                  deck_body_name(d, body), deck_body_name(d, whole));
    return;
  }
}

/* --- walls moved by contact forces ------------------------------------------------------------ */

static uint32_t wall_called(const sd_model *m, const char *name) {
  for (size_t w = 0; w < m->n_walls; w++)
    if (m->walls[w].name && !strcmp(m->walls[w].name, name)) return (uint32_t)(m->n_disks + w);
  return 0;
}

/* Sets motion->length, the length on which a pressure acts: the key `length`, the length of a
 * segment, or, for an infinite line, the period of the box along it or the distance of the two
 * adjacent walls of the container (motion->beside), which may move. */
static void read_length(deck_group *g, sd_motion *motion, const sd_wall *wall, int coordinate) {
  const sd_model *m = g->d->model;
  int across = coordinate == SD_X ? SD_Y : SD_X;
  const container_kind *kind = container_kind_of(m->container);
  const char *const *beside = &kind->sides[2 * across];
  if (deck_given(g, "length")) return;
  if (wall->kind == SD_WALL_SEGMENT && wall->n_points == 2) {
    motion->length = math_hypot(wall->points[1][0] - wall->points[0][0],
                                wall->points[1][1] - wall->points[0][1]);
  } else if (wall->kind == SD_WALL_LINE && m->periodic[across]) {
    motion->length = m->upper[across] - m->lower[across];
  } else if (wall->kind == SD_WALL_LINE && kind->rectangle && beside[0] && beside[1]) {
    motion->length = m->region_upper[across] - m->region_lower[across];
    for (int k = 0; k < 2; k++) motion->beside[k] = wall_called(m, beside[k]);
  } else {
    deck_fail_key(g, "length",
                  "missing: expected the length of the wall that the pressure acts on");
  }
}

static void read_servo(deck_group *g, sd_motion *motion, uint32_t body, int coordinate) {
  const sd_model *m = g->d->model;
  if (deck_given(g, "force")) {
    if (motion->force == 0) deck_fail_key(g, "force", "expected a force other than 0");
    if (deck_given(g, "length")) deck_fail_key(g, "length", "expected with pressure only");
  } else if (deck_given(g, "pressure")) {
    int side = sd_model_side(m, body, coordinate);
    motion->pressure *= side;
    if (side == 0)
      deck_fail_key(g, "pressure", "this wall does not press along %s; expected force",
                    coordinate == SD_X ? "x" : "y");
    read_length(g, motion, &m->walls[body - m->n_disks], coordinate);
  }
}

/* Reads a motion of the kind load or servo. Each wall gets a separate motion, since the walls move
 * independently. */
static void read_feedback(deck_group *g, sd_motion *motion, size_t entry, const deck_bodies *bodies,
                          unsigned mask) {
  deck *d = g->d;
  size_t before = d->reported;
  const char *what = motion_kinds[motion->kind].name;
  static const char *const keys[] = {"disk", "group", "clump"};
  for (size_t k = 0; k < COUNT(keys); k++) {
    const char *const key = keys[k];
    if (deck_given(g, key)) deck_fail_key(g, key, "a %s moves walls only; expected wall", what);
  }
  int coordinate = mask == 1u << SD_X ? SD_X : SD_Y;
  if (mask && mask != 1u << SD_X && mask != 1u << SD_Y)
    deck_fail_key(g, "coordinate",
                  "a %s moves its wall along one direction; expected \"x\" or \"y\"", what);
  if (motion->kind == SD_MOTION_LOAD) {
    deck_default_number(g, "force", 0);
    motion->force += motion->mass * d->model->gravity[coordinate];
  }
  for (size_t b = 0; d->reported == before && b < bodies->n; b++) {
    sd_motion own = *motion;
    if (motion->kind == SD_MOTION_SERVO) read_servo(g, &own, bodies->body[b], coordinate);
    push(d, &own, entry, coordinate, 1, &bodies->body[b]);
  }
}

/* --- signals ---------------------------------------------------------------------------------- */

/* Completes the signal of a motion, most of whose numbers deck_fill has read. */
static void read_signal(deck_group *g, unsigned mask, sd_motion *motion) {
  const signal_source source = motion_source(motion);
  if (source == SIGNAL_TABLE) read_table(g, motion);
  if (source != SIGNAL_WAVE && source != SIGNAL_RANDOM) return;
  read_omega(g, motion);
  read_acceleration(g, motion, mask);
  if (source == SIGNAL_RANDOM && motion->amplitude < 0)
    deck_fail_key(g, "amplitude", "expected an rms displacement >= 0");
}

/* --- the list --------------------------------------------------------------------------------- */

static void read_motion(deck_group *g, size_t entry, streams *s) {
  deck *d = g->d;
  size_t before = d->reported;
  sd_motion motion = {.name = deck_text_of(g, "name"), .interval = 1};
  deck_bodies bodies = deck_select(g, true);
  unsigned mask = deck_coordinates(g, "coordinate");
  if (!deck_fill(g, &motion)) return;
  if (motion_is_feedback(&motion)) {
    read_feedback(g, &motion, entry, &bodies, mask);
    return;
  }
  read_signal(g, mask, &motion);
  check_held(d, g, &bodies, mask);
  check_surface(d, g, &bodies, mask);
  check_clumped(d, g, &bodies);
  if (bodies.n == 0) return;
  if (motion.kind == SD_MOTION_RANDOM) {
    push_random(d, g, &motion, entry, &bodies, mask, s);
    return;
  }
  if (d->reported > before) motion.n_table = 0;
  for (int c = 0; c < SD_MOVED; c++)
    if (mask >> c & 1) push(d, &motion, entry, c, bodies.n, bodies.body);
}

void deck_check_motions(deck *d) {
  const sd_model *m = d->model;
  const deck_node *list = deck_child(d->root, "motions");
  size_t q[2];
  for (size_t k = 0; k < m->n_phases; k++) {
    if (!sd_model_clash(m, k, q)) continue;
    const deck_node *other = list->child[d->motion_entry[q[1]]];
    deck_fail(
        d, list->child[d->motion_entry[q[0]]],
        "in phase %zu, %s moves the same coordinate of this wall; a load or a servo expects to be "
        "alone there",
        k, deck_node_path(d, other));
    return;
  }
}

void deck_read_motions(deck *d) {
  sd_model *m = d->model;
  deck_group g;
  /* Number of driven things (disks, walls, groups, lists) of each kind STREAM_*; clumps are
   * numbered after the walls */
  size_t things[STREAM_THINGS] = {m->n_disks, m->n_walls + m->n_clumps, m->n_groups,
                                  model_movables(m)};
  streams s;
  for (int k = 0; k < STREAM_THINGS; k++) s.used[k] = deck_alloc(d, SD_MOVED * things[k] + 1, 1);
  for (size_t k = 0; deck_next(d, &deck_motions, &k, &g);) {
    read_motion(&g, k - 1, &s);
    const deck_node *name = deck_get(&g, "name");
    if (name && name->type == DECK_STRING &&
        !deck_index_add(d, &d->motions, name->value.text, (uint32_t)k - 1))
      deck_fail(d, name, "two motions have this name");
  }
}

/* deck_packings.c: makes disks with the generators of packings. See deck_tree.h.
 *
 * Each entry of `packings` is read and checked, then its disks are made and added to the model, so
 * that the next entry leaves their places free. Memory of a generator is freed before the arena is
 * used again, because deck_alloc may leave by longjmp. */
#include <assert.h>
#include <math.h>

#include "base/limits.h"
#include "base/math.h"
#include "base/memory.h"
#include "io/deck/deck_values.h"
#include "model/rows.h"
#include "pack/place.h"
#include "pack/rain.h"
#include "pack/sizes.h"
#include "pack/tiles.h"

/* Packing fraction of the densest packing of equal disks, pi/sqrt(12). */
static const double DENSEST = 0.90689968211710892;

typedef struct packing {
  deck_group g;
  bool last; /* True for the last entry of the list `packings` */
  packing_spec spec;
  double mean_area;
  double lower[2], upper[2]; /* Lower left and upper right corner of the region to fill */
  /* Area of the region inside the container; NAN: the container has errors */
  double area;
  const char *group; /* Group that the disks join; NULL: none */
  deck_grain grain;  /* Shape of the grains; generators place the circles that enclose the grains */
} packing;

/* --- region ----------------------------------------------------------------------------------- */

static void check_edges(packing *p, int c) {
  deck *d = p->g.d;
  const sd_model *m = d->model;
  const char *key = c ? "y" : "x";
  if (!(p->lower[c] < p->upper[c])) {
    deck_fail_key(&p->g, key, "expected (lower, upper) with lower < upper");
    return;
  }
  if (m->periodic[c] && (p->lower[c] < m->lower[c] || p->upper[c] > m->upper[c])) {
    deck_fail_key(&p->g, key, "reaches beyond the periodic box, from %g to %g", m->lower[c],
                  m->upper[c]);
    return;
  }
  if (m->container == SD_CONTAINER_NONE || m->periodic[c]) return;
  bool open = c == SD_Y && d->container->open;
  double slack = 1e-12 * (m->region_upper[c] - m->region_lower[c]);
  if (p->lower[c] < m->region_lower[c] - slack ||
      (p->upper[c] > m->region_upper[c] + slack && !open))
    deck_fail_key(&p->g, key, "reaches beyond the container, from %g to %g", m->region_lower[c],
                  m->region_upper[c]);
}

static void read_region(packing *p) {
  deck *d = p->g.d;
  const sd_model *m = d->model;
  size_t before = d->reported;
  bool broken = m->container == SD_CONTAINER_NONE && deck_child(d->root, "container");
  if (broken) p->area = NAN;
  for (int c = 0; c < 2 && !broken; c++) {
    const char *key = c ? "y" : "x";
    if (!deck_get(&p->g, key)) {
      if (!(m->region_upper[c] > m->region_lower[c])) {
        deck_fail_key(
            &p->g, key,
            "missing: expected (lower, upper), since no container and no box gives edges in %s",
            key);
        continue;
      }
      deck_default_pair(&p->g, key, (double[2]){m->region_lower[c], m->region_upper[c]});
    }
    double edge[2];
    if (!deck_pair(&p->g, key, edge)) continue;
    p->lower[c] = edge[0];
    p->upper[c] = edge[1];
    check_edges(p, c);
  }
  if (broken || d->reported > before) return;
  p->area = container_area(d->container, p->lower, p->upper);
  if (!(p->area > 0)) deck_fail(d, p->g.node, "its region lies outside the container");
}

/* --- checks before disks are made ------------------------------------------------------------- */

/* Checks that the largest disk fits into a region of this width and height. */
static void check_room(packing *p, double width, double height) {
  deck *d = p->g.d;
  const sd_model *m = d->model;
  double largest = p->spec.sizes.upper, extent[2] = {width, height};
  for (int c = 0; c < 2; c++) {
    bool wraps = m->periodic[c] && extent[c] >= m->upper[c] - m->lower[c];
    if (2 * largest > extent[c] * (1 + 1e-12) && !wraps)
      deck_fail(d, p->g.node, "a disk of radius %g does not fit into a region that is %g %s",
                largest, extent[c], c ? "high" : "wide");
  }
}

static void check_area(packing *p, double count, double area) {
  deck *d = p->g.d;
  if (p->spec.fraction > 0 && p->spec.fraction > DENSEST)
    deck_fail_key(&p->g, "fraction",
                  "more than the densest packing of equal disks has; expected at most 0.9069");
  else if (count > LIMIT_DISKS)
    deck_fail(d, p->g.node, "%g disks; expected at most %d", count, LIMIT_DISKS);
  else if (count * p->mean_area > DENSEST * area * (1 + 1e-9))
    deck_fail(d, p->g.node,
              "%g disks of area %g in all in a region of area %g: a packing fraction of %.4g; "
              "expected at most 0.9069",
              count, count * p->mean_area, area, count * p->mean_area / area);
}

/* --- disks ------------------------------------------------------------------------------------ */

/* Returns n random angles for clumps (rad), from a random stream that is used for nothing else. */
static double *draw_angles(packing *p, size_t n) {
  deck *d = p->g.d;
  double *angle = deck_alloc(d, n, sizeof *angle);
  gsl_rng *rng = sizes_random(d->model->seed, p->spec.number + LIMIT_ENTRIES);
  for (size_t k = 0; k < n; k++) angle[k] = 2 * M_PI * gsl_rng_uniform(rng);
  gsl_rng_free(rng);
  return angle;
}

static bool mass_is_good(const packing *p, double mass) {
  const bool good =
      /* A mass that is NAN or negative was reported when its key was read */
      !(mass >= 0) || deck_in_range(DECK_POSITIVE, mass);
  if (!good)
    deck_fail_key(&p->g, "density", "the mass of a disk is %g; expected a number %s", mass,
                  deck_expected(DECK_POSITIVE, mass));
  return good;
}

static void push_disks(const packing *p, size_t n, const sd_disk *disks) {
  for (size_t k = 0; k < n && mass_is_good(p, disks[k].mass); k++)
    deck_push_disk(p->g.d, &disks[k], NULL, p->g.node->place);
}

static void push(packing *p, size_t n, const double *circle, double (*position)[2]) {
  const deck_grain *grain = &p->grain;
  const double *angle = grain->at ? draw_angles(p, n) : NULL;
  p->spec.group = deck_group_number(p->g.d, p->group);
  for (size_t k = 0; k < n; k++) {
    sd_disk disk = packing_disk(&p->spec, circle[k] / grain->reach, position[k]);
    if (p->spec.mass == 0) disk.mass *= grain->area;
    if (!mass_is_good(p, disk.mass)) return;
    if (angle)
      deck_push_grain(p->g.d, grain, &disk, disk.radius, angle[k], p->g.node->place);
    else
      deck_push_disk(p->g.d, &disk, NULL, p->g.node->place);
  }
}

/* Draws random radii until the areas of the disks add up to `area` as nearly as possible. If all
 * radii are equal or from a list, their number is rint(area/mean_area). Returns the number of
 * radii, at most `capacity`. */
static size_t draw_area(const packing *p, gsl_rng *rng, double area, size_t capacity,
                        double *radius) {
  double sum = 0;
  size_t n = (size_t)math_max(1, math_min(rint(area / p->mean_area), (double)capacity));
  sizes_draw(&p->spec.sizes, rng, n, radius);
  if (p->spec.sizes.kind == SD_SIZES_MONO || p->spec.sizes.kind == SD_SIZES_LIST) return n;
  for (size_t k = 0; k < n; k++) sum += M_PI * radius[k] * radius[k];
  for (; n < capacity; n++) {
    sizes_draw(&p->spec.sizes, rng, 1, &radius[n]);
    double more = M_PI * radius[n] * radius[n];
    if (sum + more / 2 > area) break;
    sum += more;
  }
  while (n > 1) {
    double last = M_PI * radius[n - 1] * radius[n - 1];
    if (sum - last / 2 <= area) break;
    sum -= last;
    n--;
  }
  return n;
}

static double fraction_of(const packing *p, size_t n, const double *radius) {
  double sum = 0;
  for (size_t k = 0; k < n; k++) sum += M_PI * radius[k] * radius[k];
  return sum / p->area;
}

/* --- generators ------------------------------------------------------------------------------- */

/* Memory of a generator of packings. Between open_bench and close_bench nothing may be allocated in
 * the arena, since failure there would jump past close_bench. */
typedef struct bench {
  size_t n, capacity;
  double *radius, (*position)[2]; /* [capacity]: radii and centres of the disks, in the arena */
  place_space space;
  gsl_rng *rng;
  sd_status status;
} bench;

enum { BENCH_BYTES = sizeof(double[3]) }; /* Memory that a generator needs per disk, in bytes */

static bench open_bench(const packing *p, double capacity) {
  deck *d = p->g.d;
  bench b = {.capacity = (size_t)capacity};
  b.radius = deck_alloc(d, b.capacity, sizeof *b.radius);
  b.position = deck_alloc(d, b.capacity, sizeof *b.position);
  b.status = place_begin(&b.space, d->model, d->model->n_disks, d->container, p->lower, p->upper,
                         b.capacity);
  b.rng = sizes_random(d->model->seed, p->spec.number);
  return b;
}

static void close_bench(const packing *p, bench *b) {
  gsl_rng_free(b->rng);
  place_end(&b->space);
  if (b->status != SD_OK) longjmp(p->g.d->out_of_memory, 1);
}

static void check_lattice(packing *p) {
  deck_group *g = &p->g;
  const double largest = 2 * p->spec.sizes.upper;
  deck_default_number(g, "spacing", largest);
  if (p->spec.spacing < largest)
    deck_fail_key(g, "spacing", "expected at least the largest diameter, %g", largest);
  if (p->spec.jitter > 1)
    deck_fail_key(g, "jitter", "expected at most 1; beyond it disks could overlap");
}

static void make_lattice(packing *p) {
  deck *d = p->g.d;
  deck_group *g = &p->g;
  const double spacing = p->spec.spacing;
  double sites = ((p->upper[0] - p->lower[0]) / spacing + 1) *
                 ((p->upper[1] - p->lower[1]) / (spacing * sqrt(0.75)) + 1);
  if (sites > LIMIT_DISKS) {
    deck_fail_key(g, "spacing", "the lattice has about %g sites; expected at most %d", sites,
                  LIMIT_DISKS);
    return;
  }
  if (p->spec.count == 0) deck_need(d, g->node, "spacing", rint(sites), BENCH_BYTES, "sites");
  bench b = open_bench(p, p->spec.count > 0 ? math_min((double)p->spec.count, sites) : sites);
  if (b.status == SD_OK)
    b.status = tiles_place(&b.space, b.rng, &p->spec, b.capacity, b.radius, b.position, &b.n);
  close_bench(p, &b);
  if (b.n == 0)
    deck_fail(d, g->node, "the lattice has no free site in the region");
  else if ((int64_t)b.n < p->spec.count)
    deck_fail_key(g, "count", "the lattice has %zu free sites only", b.n);
  else
    push(p, b.n, b.radius, b.position);
}

static void make_random(packing *p) {
  bool by_count = p->spec.fraction == 0;
  double target = by_count ? (double)p->spec.count * p->mean_area : p->spec.fraction * p->area;
  bench b = open_bench(p, by_count ? (double)p->spec.count : 2 * target / p->mean_area + 100);
  size_t placed = 0;
  b.n = b.capacity;
  if (b.status == SD_OK && by_count)
    b.status = tiles_place(&b.space, b.rng, &p->spec, b.n, b.radius, b.position, &placed);
  if (b.status == SD_OK && !by_count) b.n = draw_area(p, b.rng, target, b.capacity, b.radius);
  if (b.status == SD_OK && !by_count)
    b.status = place_random(&b.space, b.rng, b.n, b.radius, b.position, &placed);
  close_bench(p, &b);
  if (placed == b.n) {
    push(p, b.n, b.radius, b.position);
    return;
  }
  double all = fraction_of(p, b.n, b.radius);
  for (size_t k = 0; k < b.n; k++)
    if (isnan(b.position[k][0])) b.radius[k] = 0;
  deck_fail_key(&p->g, by_count ? "count" : "fraction",
                "random placement found no room for more than %zu of %zu disks, a fraction of %.3f "
                "of the region "
                "where %.3f was asked for; expected less, or type \"front\"",
                placed, b.n, fraction_of(p, b.n, b.radius), all);
}

/* Fills the region by the advancing-front method. Without the key `count`, more disks are generated
 * than can fit. */
static void make_front(packing *p) {
  deck *d = p->g.d;
  double target = 1.05 * p->area + p->mean_area, most = 2 * target / p->mean_area + 100;
  if (p->spec.count == 0) deck_need(d, p->g.node, "type", rint(most), BENCH_BYTES, "disks");
  bench b = open_bench(p, p->spec.count > 0 ? (double)p->spec.count : most);
  size_t placed = 0;
  b.n = b.capacity;
  if (p->spec.count > 0)
    sizes_draw(&p->spec.sizes, b.rng, b.n, b.radius);
  else
    b.n = draw_area(p, b.rng, target, b.capacity, b.radius);
  if (b.status == SD_OK) b.status = front_fill(&b.space, b.n, b.radius, b.position, &placed);
  close_bench(p, &b);
  if (placed == 0)
    deck_fail(d, p->g.node, "the front found no place for a disk in the region");
  else if ((int64_t)placed < p->spec.count)
    deck_fail_key(&p->g, "count",
                  "the front has filled the region with %zu disks, a fraction of %.3f", placed,
                  fraction_of(p, placed, b.radius));
  else
    push(p, placed, b.radius, b.position);
}

/* --- tiles ------------------------------------------------------------------------------------ */

/* For rain in tiles: sets the region where its disks wait before they fall, from `height` upwards,
 * high enough for disks of any size. */
static void wait_above(sd_tiles *t, double height, double spacing) {
  const double across = math_max(1, floor((t->upper[0] - t->lower[0]) / spacing));
  t->lower[1] = height - spacing;
  t->upper[1] = height + (floor((double)t->count / across) + 1) * spacing;
}

static void check_tiles(packing *p) {
  deck_group *g = &p->g;
  const double wide = (p->upper[0] - p->lower[0]) / (double)p->spec.tiles;
  if (p->spec.count == 0)
    deck_fail_key(g, "count", "missing: expected the number of disks, which tiles share");
  else if (p->spec.tiles > p->spec.count)
    deck_fail_key(g, "tiles", "expected at most one for each of the %lld disks",
                  (long long)p->spec.count);
  const bool rain = p->spec.kind == SD_PACKING_RAIN;
  if (!(2 * p->spec.sizes.upper <= wide) && !rain)
    deck_fail_key(
        g, "tiles",
        "each is %g wide; expected fewer, so that a disk of radius %g fits between their edges",
        wide, p->spec.sizes.upper);
  if (p->grain.at) deck_fail_key(g, "tiles", "clumps are not made in tiles");
  if (!rain && !container_kind_of(p->g.d->model->container)->rectangle)
    deck_fail_key(g, "tiles", "expected a container that is a rectangle");
}

/* Makes the disks of one tile and returns `disks`; NULL after an error, which is reported. */
static const sd_disk *make_tile(packing *p, size_t tile, sd_disk *disks) {
  const sd_tiles *t = &p->g.d->model->tiles;
  const size_t n = model_tile_size(t, tile);
  size_t placed;
  assert(disks && n > 0);
  if (tiles_make(p->g.d->model, &p->spec, tile, disks, &placed) != SD_OK)
    longjmp(p->g.d->out_of_memory, 1);
  if (placed < n) {
    deck_fail_key(&p->g, "count", TILES_FULL, tile, t->n, placed, n);
    return NULL;
  }
  for (size_t k = 0; k < n; k++)
    if (!mass_is_good(p, disks[k].mass)) return NULL;
  return disks;
}

/* Makes the tiles of this rank: rank r of n ranks makes the tiles r, r + n, r + 2 n, ... */
static void make_own_tiles(packing *p, sd_disk *disks) {
  deck *d = p->g.d;
  sd_model *m = d->model;
  const size_t before = d->reported, ranks = (size_t)comm_size(d->comm);
  if (!rows_reserve(m, rows_of_tiles(m))) longjmp(d->out_of_memory, 1);
  for (size_t k = (size_t)comm_rank(d->comm); k < m->tiles.n && d->reported == before; k += ranks) {
    const size_t first = m->tiles.first + model_tile_begin(&m->tiles, k);
    const sd_disk *tile = make_tile(p, k, disks);
    for (size_t i = 0; tile && i < model_tile_size(&m->tiles, k); i++)
      rows_add(m, &tile[i], (uint32_t)(first + i));
  }
  d->away_place = p->g.node->place;
  deck_note_away(d, p->spec.group);
  m->n_disks += m->tiles.count;
}

/* Smallest number of disks in a packing whose tiles are distributed over the ranks. In smaller
 * packings every rank makes all tiles, since a run then keeps the order of the deck. */
enum { FEWEST_AWAY = 1000 };

/* Makes a packing in tiles. height: for rain, the height of the lowest row of waiting disks; not
 * used for other kinds. */
static void make_tiled(packing *p, double height) {
  deck *d = p->g.d;
  sd_model *m = d->model;
  const packing_spec *s = &p->spec;
  size_t before = d->reported;
  check_tiles(p);
  if (d->reported > before) return;
  const bool apart = d->comm && d->whole && s->tiles > 1;
  if (apart && !p->last)
    sd_warn(d->messages,
            "packings[%zu].tiles: every rank makes all, since the packing is not the last",
            s->number);
  m->tiles = (sd_tiles){.n = (size_t)s->tiles,
                        .first = m->n_disks,
                        .count = (size_t)s->count,
                        .away = apart && p->last && s->count >= FEWEST_AWAY,
                        .entry = s->number,
                        .lower = {p->lower[0], p->lower[1]},
                        .upper = {p->upper[0], p->upper[1]},
                        .most = s->sizes.upper};
  if (s->kind == SD_PACKING_RAIN) wait_above(&m->tiles, height, s->spacing);
  p->spec.group = deck_group_number(d, p->group);
  sd_disk *disks = deck_alloc(d, model_tile_begin(&m->tiles, 1), sizeof *disks);
  if (m->tiles.away) {
    make_own_tiles(p, disks);
    return;
  }
  for (size_t k = 0; k < m->tiles.n && d->reported == before; k++) {
    const sd_disk *tile = make_tile(p, k, disks);
    if (tile) push_disks(p, model_tile_size(&m->tiles, k), tile);
  }
}

/* --- rain ------------------------------------------------------------------------------------- */

/* Returns the time in which the disks that rain drops at once fall by `height`, the height of their
 * rows; NAN: they do not fall. speed: initial speed downwards. */
static double fall_time(const sd_model *m, double height, double speed) {
  double g = math_max(0, -m->gravity[SD_Y]), end = sqrt(speed * speed + 2 * g * height);
  return speed + end > 0 ? 2 * height / (speed + end) : NAN;
}

/* Returns the lowest height at which the container is as wide as the rain that falls into it. */
static double rain_floor(packing *p) {
  deck *d = p->g.d;
  const container *in = d->container;
  double x = in->origin[0], half = math_max(x - p->lower[0], p->upper[0] - x);
  if (in->open) return math_max(p->lower[1], container_wide_from(in, half));
  if (!container_holds(in, p->lower, p->upper))
    deck_fail(d, p->g.node, "rain needs x and y, a rectangle that lies inside the container");
  return p->lower[1];
}

static void check_rain(packing *p, double height) {
  deck *d = p->g.d;
  const sd_model *m = d->model;
  if (m->periodic[SD_Y]) deck_fail(d, p->g.node, "rain cannot fall in a box that is periodic in y");
  if (!d->container->open && height > p->upper[1] - p->lower[1])
    deck_fail_key(&p->g, "rows", "a batch is %g high, the region only %g", height,
                  p->upper[1] - p->lower[1]);
  if (m->container != SD_CONTAINER_NONE)
    check_area(p, (double)p->spec.count,
               container_area(d->container, m->region_lower, m->region_upper));
}

/* Returns a height above the region and above all disks made so far, including those that wait to
 * fall. */
static double waiting_height(const packing *p, double spacing) {
  const sd_model *m = p->g.d->model;
  double top = p->upper[1];
  for (size_t i = 0; i < m->n_disks; i++)
    top = math_max(top, m->disks[i].position[1] + m->disks[i].radius);
  return top + spacing;
}

static void make_waiting(packing *p) {
  const double spacing = p->spec.spacing = 2.1 * p->spec.sizes.upper,
               height = waiting_height(p, spacing);
  if (p->spec.tiles > 0) {
    make_tiled(p, height);
    return;
  }
  bench b = open_bench(p, (double)p->spec.count);
  b.n = b.capacity;
  sizes_draw(&p->spec.sizes, b.rng, b.n, b.radius);
  close_bench(p, &b);
  place_waiting(p->lower[0], p->upper[0], height, spacing, 0, b.n, b.position);
  push(p, b.n, b.radius, b.position);
}

/* Sets r->batch, the number of disks that the rain drops at once. If the disks are distributed over
 * the ranks, rank 0, which made the first tile, counts them and broadcasts the number. */
static void count_batch(packing *p) {
  deck *d = p->g.d;
  const sd_model *m = d->model;
  sd_rain *r = &p->spec.rain;
  const bool away = m->tiles.away;
  const size_t known = away ? model_tile_begin(&m->tiles, 1) : r->count;
  double *radius = away ? deck_alloc(d, known, sizeof *radius) : NULL;
  if (comm_rank(d->comm) == 0 || !away) {
    for (size_t k = 0; away && k < known; k++) radius[k] = m->mine->disk[k].radius;
    const rain_sizes first = {.model = m, .radius = radius, .first = r->first};
    for (int64_t row = 0; row < p->spec.rows && r->batch < known; row++)
      r->batch += rain_row(&first, r->first + r->batch, r->first + known, r->upper - r->lower);
  }
  if (!away) return;
  comm_broadcast(d->comm, &r->batch, sizeof r->batch);
  if (r->batch >= known)
    deck_restart_with_all_disks(d, "tiles have fewer disks than a batch of rain");
}

static void make_rain(packing *p) {
  deck *d = p->g.d;
  deck_group *g = &p->g;
  sd_model *m = d->model;
  sd_rain *rain = &p->spec.rain;
  size_t before = d->reported;
  double largest = p->spec.sizes.upper, height = 2 * largest * (double)p->spec.rows;
  deck_default_number(g, "gap", largest);
  rain->first = m->n_disks;
  rain->count = (size_t)p->spec.count * p->grain.n;
  rain->lower = p->lower[0];
  rain->upper = p->upper[0];
  rain->floor = rain_floor(p);
  double interval = fall_time(m, height, rain->speed);
  if (isnan(interval))
    deck_fail(d, g->node,
              "nothing falls; expected gravity that points down (g > 0), or a speed > 0");
  else
    deck_default_number(g, "interval", interval);
  check_rain(p, height);
  if (d->reported > before) return;
  rain->interval = (int64_t)math_min(math_max(1, ceil(p->spec.interval / m->dt)), 1e18);
  make_waiting(p);
  deck_agree_on_errors(d);
  if (d->reported > before || d->wrong) return;
  count_batch(p);
  m->rains = memory_grow(m->rains, m->n_rains + 1, sizeof *m->rains);
  m->rains[m->n_rains++] = *rain;
}

/* --- a packing -------------------------------------------------------------------------------- */

static void make_packing(packing *p) {
  static void (*const make[])(packing *) = {[SD_PACKING_TRIANGULAR] = make_lattice,
                                            [SD_PACKING_SQUARE] = make_lattice,
                                            [SD_PACKING_RANDOM] = make_random,
                                            [SD_PACKING_FRONT] = make_front,
                                            [SD_PACKING_RAIN] = make_rain};
  deck *d = p->g.d;
  size_t before = d->reported;
  bool rain = p->spec.kind == SD_PACKING_RAIN;
  const bool lattice = p->spec.kind == SD_PACKING_TRIANGULAR || p->spec.kind == SD_PACKING_SQUARE;
  p->mean_area = sizes_mean_area(&p->spec.sizes);
  check_room(p, p->upper[0] - p->lower[0], rain ? HUGE_VAL : p->upper[1] - p->lower[1]);
  double count = p->spec.count > 0       ? (double)p->spec.count
                 : p->spec.fraction == 0 ? 0
                                         : rint(p->spec.fraction * p->area / p->mean_area);
  if (d->reported == before) check_area(p, count, rain ? HUGE_VAL : p->area);
  if (p->spec.fraction > 0 && count < 1)
    deck_fail_key(&p->g, "fraction", "less than one disk in a region of area %g", p->area);
  if (d->reported > before) return;
  const bool away = d->comm && d->whole && p->last && p->spec.tiles > 1;
  if (!away)
    deck_need(d, p->g.node, p->spec.count > 0 ? "count" : "fraction",
              (double)d->model->n_disks + count, deck_disk_bytes(true), "disks");
  if (lattice) check_lattice(p);
  if (d->reported > before) return;
  if (p->spec.tiles == 0 || rain)
    make[p->spec.kind](p);
  else
    make_tiled(p, NAN);
}

/* Multiplies the radii of a distribution by `by`, so that they become radii of the circles that
 * enclose the grains. */
static void enlarge(deck *d, sizes *s, double by) {
  double *radii = deck_alloc(d, s->n, sizeof *radii);
  for (size_t k = 0; k < s->n; k++) radii[k] = by * s->radii[k];
  s->radii = radii;
  s->radius *= by;
  s->lower *= by;
  s->upper *= by;
  if (s->kind != SD_SIZES_LOGNORMAL) s->deviation *= by;
}

static void read_packing(deck *d, deck_node *node, size_t number, bool last) {
  packing p = {.spec.number = number, .last = last};
  d->model->tiles = (sd_tiles){0};
  if (last) deck_agree_on_errors(d);
  if (!deck_enter(d, node, &deck_packings, &p.g)) return;
  size_t before = d->reported;
  bool known = deck_fill(&p.g, &p.spec);
  p.spec.material = deck_material(&p.g);
  p.group = deck_text_of(&p.g, "group");
  deck_one_of(&p.g, "mass or density > 0");
  if (known && d->reported == before) deck_finish_sizes(&p.g, &p.spec.sizes);
  if (deck_read_grain(&p.g, &p.grain)) enlarge(d, &p.spec.sizes, p.grain.reach);
  read_region(&p);
  if (d->reported == before && !isnan(p.area)) make_packing(&p);
  d->disks_missing |= d->reported > before || isnan(p.area);
}

void deck_read_packings(deck *d) {
  deck_node *list = deck_groups(d, d->root, "packings");
  for (size_t k = 0; list && k < list->n; k++) read_packing(d, list->child[k], k, k + 1 == list->n);
}

/* --- size distribution of the disks of a packing ---------------------------------------------- */

/* Smallest fraction of a distribution that must lie between its limits; less is reported as an
 * error. */
static const double LEAST_KEPT = 1e-6;

static const double *read_numbers(deck_group *g, const char *key, size_t *n) {
  deck *d = g->d;
  deck_node *list = deck_get(g, key);
  const deck_range range = deck_key_find(g->table, key)->range;
  *n = deck_each_count(list);
  if (*n == 0) deck_fail_key(g, key, "expected a list of numbers %s", deck_range_text(range));
  double *x = deck_alloc(d, *n, sizeof *x);
  for (size_t k = 0; k < *n; k++) {
    deck_node *value = deck_each(list, k);
    if (deck_value_number(d, value, false, &x[k]) && !deck_in_range(range, x[k]))
      deck_fail(d, value, "expected a number %s", deck_range_text(range));
  }
  return x;
}

static void read_list(deck_group *g, sizes *s) {
  size_t n_weights;
  s->radii = read_numbers(g, "radii", &s->n);
  if (s->n == 0) return;
  if (!deck_get(g, "weights")) {
    deck_node *list = deck_default_list(g, "weights");
    for (size_t k = 0; k < s->n; k++)
      deck_node_new(g->d, list, NULL, DECK_FLOAT, list->place)->value.number = 1;
  }
  s->weights = read_numbers(g, "weights", &n_weights);
  if (n_weights != s->n) {
    deck_fail_key(g, "weights", "%zu weights for %zu radii; expected one for each", n_weights,
                  s->n);
    return;
  }
  s->lower = HUGE_VAL;
  for (size_t k = 0; k < s->n; k++)
    if (s->weights[k] > 0) {
      s->lower = math_min(s->lower, s->radii[k]);
      s->upper = math_max(s->upper, s->radii[k]);
    }
  if (!(s->upper > 0)) deck_fail_key(g, "weights", "all are 0");
}

/* Sets the default limits of a gaussian or lognormal distribution: 3 standard deviations
 * (lognormal: of the logarithm) below and above the centre. */
static void cut_normal(deck_group *g, const sizes *s) {
  bool logarithm = s->kind == SD_SIZES_LOGNORMAL;
  double lower = logarithm ? s->radius * math_exp(-3 * s->deviation) : s->radius - 3 * s->deviation;
  double upper = logarithm ? s->radius * math_exp(3 * s->deviation) : s->radius + 3 * s->deviation;
  if (!deck_get(g, "lower") && !(lower > 0)) {
    deck_fail_key(g, "lower", "missing: 3 deviations below the mean is %g; expected a radius > 0",
                  lower);
    return;
  }
  deck_default_number(g, "lower", lower);
  deck_default_number(g, "upper", upper);
}

void deck_finish_sizes(deck_group *g, sizes *s) {
  deck *d = g->d;
  size_t before = d->reported;
  if (s->kind == SD_SIZES_MONO) {
    s->lower = s->upper = s->radius;
    return;
  }
  if (s->kind == SD_SIZES_LIST) {
    read_list(g, s);
    return;
  }
  if (s->kind == SD_SIZES_GAUSSIAN || s->kind == SD_SIZES_LOGNORMAL) cut_normal(g, s);
  if (d->reported > before) return;
  if (s->lower >= s->upper && deck_given(g, "upper"))
    deck_fail_key(g, "upper", "expected more than lower, %g", s->lower);
  else if (s->lower >= s->upper)
    deck_fail_key(g, "lower", "expected less than upper, %g", s->upper);
  if (d->reported == before && sizes_kept(s) < LEAST_KEPT)
    deck_fail_key(g, "lower", "only %g of the distribution lies between lower and upper",
                  sizes_kept(s));
}

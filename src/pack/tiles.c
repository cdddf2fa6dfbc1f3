/* tiles.c: generates packings tile by tile (see tiles.h). */
#include "pack/tiles.h"

#include <stdlib.h>

#include "base/limits.h"
#include "base/memory.h"
#include "model/rows.h"
#include "pack/place.h"

sd_status tiles_place(place_space *s, gsl_rng *rng, const tiles_fill *how, size_t n, double *radius,
                      double (*position)[2], size_t *placed) {
  const bool lattice = how->kind == SD_PACKING_TRIANGULAR || how->kind == SD_PACKING_SQUARE;
  if (lattice) n = lattice_sites(s, how->kind, how->spacing, n, position);
  *placed = 0;
  sizes_draw(how->sizes, rng, n, radius);
  if (how->kind == SD_PACKING_FRONT) return front_fill(s, n, radius, position, placed);
  if (!lattice) return place_random(s, rng, n, radius, position, placed);
  lattice_jitter(s, rng, how->spacing, how->jitter, n, radius, position);
  *placed = n;
  return SD_OK;
}

/* Returns the number of the random stream of a tile, the argument `packing` of sizes_random. Tile 0
 * has the number of the packing itself; later tiles have numbers above those of all packings (below
 * LIMIT_ENTRIES) and of the angles of their clumps (below 2 LIMIT_ENTRIES). */
static size_t stream_of(const sd_tiles *t, size_t tile) {
  return tile == 0 ? t->entry : t->entry + LIMIT_ENTRIES * (1 + tile);
}

static double edge_of(const sd_tiles *t, size_t tile) {
  if (tile == t->n) return t->upper[0];
  return t->lower[0] + (t->upper[0] - t->lower[0]) * ((double)tile / (double)t->n);
}

static sd_status fill_slab(const sd_model *m, size_t tile, gsl_rng *rng, const tiles_fill *how,
                           size_t n, double *radius, double (*position)[2], size_t *placed) {
  const sd_tiles *t = &m->tiles;
  const place_interior rectangle = {0};
  const double lower[2] = {edge_of(t, tile), t->lower[1]},
               upper[2] = {edge_of(t, tile + 1), t->upper[1]};
  place_space space;
  sd_status status = place_begin(&space, m, t->first, &rectangle, lower, upper, n);
  if (status == SD_OK) status = tiles_place(&space, rng, how, n, radius, position, placed);
  place_end(&space);
  return status;
}

/* Generates the waiting disks of one tile of a rain; the first row is `spacing` above the lower
 * edge. */
static void make_waiting(const sd_tiles *t, size_t tile, gsl_rng *rng, const tiles_fill *how,
                         size_t n, double *radius, double (*position)[2], size_t *placed) {
  place_waiting(t->lower[0], t->upper[0], t->lower[1] + t->spacing, t->spacing,
                model_tile_begin(t, tile), n, position);
  *placed = n;
  sizes_draw(how->sizes, rng, n, radius);
}

static sd_status make_disks(const sd_model *m, size_t tile, size_t n, double *radius,
                            double (*position)[2], size_t *placed) {
  const sd_tiles *t = &m->tiles;
  const sizes drawn = {.kind = t->sizes,
                       .radius = t->radius,
                       .deviation = t->deviation,
                       .exponent = t->exponent,
                       .lower = t->least,
                       .upper = t->most,
                       .n = t->n_radii,
                       .radii = t->radii,
                       .weights = t->weights};
  const tiles_fill how = {t->kind, &drawn, t->spacing, t->jitter};
  gsl_rng *rng = sizes_random(m->seed, stream_of(t, tile));
  *placed = 0;
  sd_status status = SD_OK;
  if (t->kind == SD_PACKING_RAIN)
    make_waiting(t, tile, rng, &how, n, radius, position, placed);
  else
    status = fill_slab(m, tile, rng, &how, n, radius, position, placed);
  gsl_rng_free(rng);
  return status;
}

sd_status tiles_make(const sd_model *m, size_t tile, sd_disk *disks, size_t *placed) {
  const size_t n = model_tile_size(&m->tiles, tile);
  double *radius, (*position)[2];
  *placed = 0;
  if (!memory_rows(
          2, (memory_column[]){{&radius, n, sizeof *radius}, {&position, n, sizeof *position}}))
    return SD_ERROR_IO;
  const sd_status status = make_disks(m, tile, n, radius, position, placed);
  for (size_t k = 0; status == SD_OK && *placed == n && k < n; k++)
    disks[k] = model_tile_disk(&m->tiles, radius[k], position[k]);
  free(radius);
  free(position);
  return status;
}

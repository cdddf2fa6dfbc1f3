/* tiles.c: generates packings tile by tile (see tiles.h). */
#include "pack/tiles.h"

#include <stdlib.h>

#include "base/limits.h"
#include "base/memory.h"
#include "model/rows.h"
#include "pack/place.h"

sd_status tiles_place(place_space *s, gsl_rng *rng, const packing_spec *how, size_t n,
                      double *radius, double (*position)[2], size_t *placed) {
  const bool lattice = how->kind == SD_PACKING_TRIANGULAR || how->kind == SD_PACKING_SQUARE;
  if (lattice) n = lattice_sites(s, how->kind, how->spacing, n, position);
  *placed = 0;
  sizes_draw(&how->sizes, rng, n, radius);
  if (how->kind == SD_PACKING_FRONT) return front_fill(s, n, radius, position, placed);
  if (!lattice) return place_random(s, rng, n, radius, position, placed);
  lattice_jitter(s, rng, how->spacing, how->jitter, n, radius, position);
  *placed = n;
  return SD_OK;
}

/* Returns the number of the random stream of a tile, the argument `packing` of sizes_random. Tile 0
 * has the number of the packing itself; later tiles have numbers above those of all packings (below
 * LIMIT_ENTRIES) and of the angles of their clumps (below 2 LIMIT_ENTRIES). */
static size_t stream_of(const packing_spec *p, size_t tile) {
  return tile == 0 ? p->number : p->number + LIMIT_ENTRIES * (1 + tile);
}

static double edge_of(const sd_tiles *t, size_t tile) {
  if (tile == t->n) return t->upper[0];
  return t->lower[0] + (t->upper[0] - t->lower[0]) * ((double)tile / (double)t->n);
}

static sd_status fill_slab(const sd_model *m, size_t tile, gsl_rng *rng, const packing_spec *how,
                           size_t n, double *radius, double (*position)[2], size_t *placed) {
  const sd_tiles *t = &m->tiles;
  const container rectangle = {0};
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
static void make_waiting(const sd_tiles *t, size_t tile, gsl_rng *rng, const packing_spec *how,
                         size_t n, double *radius, double (*position)[2], size_t *placed) {
  place_waiting(t->lower[0], t->upper[0], t->lower[1] + how->spacing, how->spacing,
                model_tile_begin(t, tile), n, position);
  *placed = n;
  sizes_draw(&how->sizes, rng, n, radius);
}

sd_disk packing_disk(const packing_spec *of, double radius, const double position[2]) {
  return (sd_disk){.position = {position[0], position[1]},
                   .radius = radius,
                   .mass = of->mass == 0.0 ? of->density * 3.14159265358979323846 * radius * radius
                                           : of->mass,
                   .material = of->material,
                   .group = of->group,
                   .waiting = of->kind == SD_PACKING_RAIN};
}

sd_status tiles_make(const sd_model *m, const packing_spec *how, size_t tile, sd_disk *disks,
                     size_t *placed) {
  const size_t n = model_tile_size(&m->tiles, tile);
  double *radius, (*position)[2];
  *placed = 0;
  if (!memory_rows(
          2, (memory_column[]){{&radius, n, sizeof *radius}, {&position, n, sizeof *position}}))
    return SD_ERROR_IO;
  gsl_rng *rng = sizes_random(m->seed, stream_of(how, tile));
  sd_status status = SD_OK;
  if (how->kind == SD_PACKING_RAIN)
    make_waiting(&m->tiles, tile, rng, how, n, radius, position, placed);
  else
    status = fill_slab(m, tile, rng, how, n, radius, position, placed);
  gsl_rng_free(rng);
  for (size_t k = 0; status == SD_OK && *placed == n && k < n; k++)
    disks[k] = packing_disk(how, radius[k], position[k]);
  free(radius);
  free(position);
  return status;
}

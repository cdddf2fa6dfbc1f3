/* rows.h: access to the disks of a model that may be distributed over MPI ranks; the data of one
 * disk are called a row.
 *
 * All ranks read an input deck together and build the same model. Its last disks may be distributed
 * (`away` in sd_tiles): each rank then stores some of them, in model->mine, and all ranks store the
 * first model_held ones. Checks and warnings loop over the rows of a rank and combine the results
 * of all ranks. In one process, without a communicator, the rows are all disks.
 *
 * Before its run begins a rank keeps the rows that all ranks must know, and its own part of the
 * others (model_part in model.h).
 */
#ifndef SLIPDISK_MODEL_ROWS_H
#define SLIPDISK_MODEL_ROWS_H

#include "base/comm.h"
#include "model/model.h"

/* --- rows while a model is built -------------------------------------------------------------- */

/* Number of disks that all ranks store: disks [0, model_held) are in model->disks. */
static inline size_t model_held(const sd_model *m) {
  return m->tiles.away ? m->tiles.first : m->n_disks;
}

/* Number of disks whose data this rank stores: those that all ranks store, then those of its
 * own. */
static inline size_t rows_count(const sd_model *m) {
  return model_held(m) + (m->mine ? m->mine->n : 0);
}
/* First row (disk of this rank) to include in a sum over ranks: ranks other than 0 skip the
 * disks that all ranks store. */
static inline size_t rows_first(const sd_model *m) {
  return comm_rank(m->comm) == 0 ? 0 : model_held(m);
}

/* Returns the disk in row `row` of this rank. */
static inline const sd_disk *rows_disk(const sd_model *m, size_t row) {
  const size_t held = model_held(m);
  return row < held ? &m->disks[row] : &m->mine->disk[row - held];
}

/* Returns the number in the model of the disk in row `row`. */
static inline uint32_t rows_number(const sd_model *m, size_t row) {
  const size_t held = model_held(m);
  return row < held ? (uint32_t)row : m->mine->number[row - held];
}

/* Collective. Returns the largest value of all ranks. */
double rows_largest(const sd_model *m, double value);
/* Collective. Returns the smallest value of all ranks. */
double rows_least(const sd_model *m, double value);
/* Collective. Returns the sum of the values of all ranks. */
double rows_sum(const sd_model *m, double value);
/* Collective. True if `here` is true on any rank. */
bool rows_any(const sd_model *m, bool here);
/* Collective. Returns the largest value of all ranks, and in *disk the number of the disk that
 * has it; if several have it, the lowest number. */
double rows_extreme(const sd_model *m, double value, uint32_t *disk);

/* Allocates memory for n disks that are stored on this rank only (model->mine), which rows_add
 * then appends. False: out of memory. */
bool rows_reserve(sd_model *m, size_t n);
void rows_add(sd_model *m, const sd_disk *disk, uint32_t number);
/* Frees the arrays of `rows` (may be NULL), but not the struct itself. */
void rows_free(sd_rows *rows);

/* Returns the index of a part's first disk among all disks that are generated or read in parts. */
size_t model_tile_begin(const sd_tiles *tiles, size_t part);
/* Returns the number of disks in a part. */
static inline size_t model_tile_size(const sd_tiles *t, size_t part) {
  return model_tile_begin(t, part + 1) - model_tile_begin(t, part);
}
/* Number of disks in the parts (tiles of a packing, rows of a file) that this rank stores: rank
 * q has the parts q, q + ranks, ... */
size_t rows_of_tiles(const sd_model *m);

/* --- rows during a run ------------------------------------------------------------------------ */

/* True if all ranks must know the disk, because it is driven, named, locked, in a clump, or has
 * a force: data beyond number, position, velocity, angle, size, mass, material and group. */
bool rows_special(const sd_disk *disk);

/* Collective. Distributes the disks of a finished model: model->disks keeps the disks that all
 * ranks must know (rows_special), the others become zeros in memory pages that are never
 * written; this rank's part of the free disks moves to model->mine. Below `few` free disks, rank
 * 0 keeps them all. False: out of memory. */
bool rows_part(sd_model *m, size_t few);

/* Number of disks that have data in model->disks of this rank; in one process these are all
 * disks. */
static inline size_t model_known(const sd_model *m) { return m->parted ? m->n_known : m->n_disks; }
/* Returns the number of the k-th disk that has data in model->disks of this rank. */
static inline uint32_t model_known_disk(const sd_model *m, size_t k) {
  return m->parted ? m->known[k] : (uint32_t)k;
}
/* True if this disk has data in model->disks of this rank. */
bool model_knows(const sd_model *m, uint32_t disk);

#endif

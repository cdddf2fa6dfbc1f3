/* rows.h: the disks of a model where ranks share them.
 *
 * All ranks read a deck together and have the same model. Its last disks may be away (sd_tiles):
 * each rank then has some of them, in model->mine, and the first ones, model_held of them, are here
 * on all ranks. Checks and warnings go over the rows of a rank, and put together what they have
 * found. In one process, and without a communicator, these are all disks.
 *
 * Before its run begins a rank keeps the rows that all must know, and its own part of the others
 * (model_part in finish.h).
 */
#ifndef SLIPDISK_MODEL_ROWS_H
#define SLIPDISK_MODEL_ROWS_H

#include "base/comm.h"
#include "model/model.h"

/* --- while a model is made -------------------------------------------------------------------- */

/* Disks [0, model_held) have their rows in model->disks, on all ranks. */
static inline size_t model_held(const sd_model *m) {
  return m->tiles.away ? m->tiles.first : m->n_disks;
}

/* The rows of this rank: those that are held, then its own. */
static inline size_t rows_count(const sd_model *m) {
  return model_held(m) + (m->mine ? m->mine->n : 0);
}
/* The first row that only this rank counts: ranks add up what they have from here on. */
static inline size_t rows_first(const sd_model *m) {
  return comm_rank(m->comm) == 0 ? 0 : model_held(m);
}

static inline const sd_disk *rows_disk(const sd_model *m, size_t row) {
  const size_t held = model_held(m);
  return row < held ? &m->disks[row] : &m->mine->disk[row - held];
}

static inline uint32_t rows_number(const sd_model *m, size_t row) {
  const size_t held = model_held(m);
  return row < held ? (uint32_t)row : m->mine->number[row - held];
}

/* Collective. Largest and least value of all ranks, and sums. */
double rows_largest(const sd_model *m, double value);
double rows_least(const sd_model *m, double value);
double rows_sum(const sd_model *m, double value);
bool rows_any(const sd_model *m, bool here);
/* Collective. The largest value of all ranks, and the disk that has it, of several the first. */
double rows_extreme(const sd_model *m, double value, uint32_t *disk);

/* Room for n disks that this rank alone has. False: no memory. */
bool rows_reserve(sd_model *m, size_t n);
void rows_add(sd_model *m, const sd_disk *disk, uint32_t number);
void rows_free(sd_rows *rows);

/* The first disk of a part among those that are made in parts; of part n: how many there are. */
size_t model_tile_begin(const sd_tiles *tiles, size_t part);
static inline size_t model_tile_size(const sd_tiles *t, size_t part) {
  return model_tile_begin(t, part + 1) - model_tile_begin(t, part);
}
/* How many disks this rank has where ranks have parts in turn: rank q those of parts q, q + ranks,
 * ... */
size_t rows_of_tiles(const sd_model *m);
/* A disk of a packing. */
sd_disk model_tile_disk(const sd_tiles *tiles, double radius, const double position[2]);

/* --- while it runs ---------------------------------------------------------------------------- */

/* Has the disk more than its number, place, size, mass, material and group? Then all ranks must
 * know it. */
bool rows_special(const sd_disk *disk);

/* Collective, of a finished model: leaves the rows that all ranks know in model->disks, those of the
 * others being zeros that nothing is written to, and a part of the free disks in model->mine; of
 * fewer than `few` the first rank has all. False: no memory. */
bool rows_part(sd_model *m, size_t few);

/* Rows that are here: all in one process. */
static inline size_t model_known(const sd_model *m) { return m->parted ? m->n_known : m->n_disks; }
static inline uint32_t model_known_disk(const sd_model *m, size_t k) {
  return m->parted ? m->known[k] : (uint32_t)k;
}
bool model_knows(const sd_model *m, uint32_t disk);

#endif

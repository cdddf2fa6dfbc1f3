/* h5_chunks.c: copies chunks from file to file as they are stored, and compares them by checksums
 * of the stored bytes: nothing is unpacked. Only for datasets whose rows are longer than a chunk,
 * as frames of many disks: then a chunk lies in one row, whatever the number of rows. */
#include <stdlib.h>

#include "base/memory.h"
#include "io/store/file.h"
#include "io/store/h5_private.h"

/* Chunks of an open dataset, `each` per row. */
typedef struct chunk_grid {
  hid_t set;
  int rank;
  hsize_t dims[H5_MAX_RANK], chunk[H5_MAX_RANK];
  size_t each;
} chunk_grid;

/* A chunk as it is stored; `mask` has a bit for each filter that was not applied. */
typedef struct stored_chunk {
  unsigned char *bytes; /* [capacity] of which `size` are used */
  hsize_t size;
  size_t capacity;
  uint32_t mask;
} stored_chunk;

/* Returns false if chunks are other than parts of one row with all later indices (choose_chunk). */
static bool grid_of(hid_t set, chunk_grid *g) {
  hid_t space = H5Dget_space(set), create = H5Dget_create_plist(set);
  *g = (chunk_grid){.set = set, .rank = H5Sget_simple_extent_ndims(space)};
  bool good = g->rank >= 2 && g->rank <= H5_MAX_RANK && H5Pget_layout(create) == H5D_CHUNKED &&
              H5Sget_simple_extent_dims(space, g->dims, NULL) == g->rank &&
              H5Pget_chunk(create, g->rank, g->chunk) == g->rank && g->chunk[0] == 1;
  for (int k = 2; k < g->rank; k++) good = good && g->chunk[k] == g->dims[k];
  if (good) g->each = (size_t)((g->dims[1] + g->chunk[1] - 1) / g->chunk[1]);
  H5Pclose(create);
  H5Sclose(space);
  return good;
}

static int count_filters(hid_t create, H5Z_filter_t filters[H5Z_MAX_NFILTERS]) {
  const int n = H5Pget_nfilters(create);
  for (int k = 0; k < n && k < H5Z_MAX_NFILTERS; k++) {
    unsigned flags, config;
    size_t none = 0;
    filters[k] = H5Pget_filter2(create, (unsigned)k, &flags, &none, NULL, 0, NULL, &config);
  }
  return n;
}

/* Returns true if a stored chunk of one dataset means the same in the other: types, lengths of rows
 * and of chunks, and filters are the same. */
static bool is_alike(const chunk_grid *a, const chunk_grid *b) {
  bool alike = a->rank == b->rank;
  for (int k = 1; alike && k < a->rank; k++)
    alike = a->dims[k] == b->dims[k] && a->chunk[k] == b->chunk[k];
  hid_t one = H5Dget_create_plist(a->set), other = H5Dget_create_plist(b->set);
  hid_t type = H5Dget_type(a->set), type_of_other = H5Dget_type(b->set);
  H5Z_filter_t filters[H5Z_MAX_NFILTERS], others[H5Z_MAX_NFILTERS];
  const int n = count_filters(one, filters);
  alike = alike && n == count_filters(other, others) && H5Tequal(type, type_of_other) > 0;
  for (int k = 0; alike && k < n && k < H5Z_MAX_NFILTERS; k++) alike = filters[k] == others[k];
  H5Tclose(type);
  H5Tclose(type_of_other);
  H5Pclose(one);
  H5Pclose(other);
  return alike;
}

/* Reads chunk k of a row; returns false if it cannot be read. */
static bool read_chunk(const chunk_grid *g, size_t row, size_t k, stored_chunk *c) {
  const hsize_t at[H5_MAX_RANK] = {row, k * g->chunk[1]};
  if (H5Dget_chunk_storage_size(g->set, at, &c->size) < 0 || c->size == 0) return false;
  if (c->size > c->capacity) {
    if (!memory_resize_row(&c->bytes, (size_t)c->size, 1)) return false;
    c->capacity = (size_t)c->size;
  }
  return H5Dread_chunk(g->set, H5P_DEFAULT, at, &c->mask, c->bytes) >= 0;
}

/* Returns the checksum of a stored chunk, in which its place in the dataset enters. */
static uint64_t sum_of(const chunk_grid *g, size_t row, size_t k, const stored_chunk *c) {
  const uint64_t words[] = {(uint64_t)row * g->each + k, c->mask,
                            file_sum(c->bytes, (size_t)c->size)};
  return file_sum(words, sizeof words);
}

bool h5_sum_chunks(hid_t set, size_t first, size_t n, uint64_t *sum) {
  chunk_grid g;
  stored_chunk c = {0};
  bool good = grid_of(set, &g);
  for (size_t row = first; good && row < first + n; row++)
    for (size_t k = 0; good && k < g.each; k++) {
      good = read_chunk(&g, row, k, &c);
      if (good) *sum += sum_of(&g, row, k, &c);
    }
  free(c.bytes);
  return good;
}

bool h5_chunks_alike(hid_t from, hid_t to) {
  chunk_grid source, target;
  return grid_of(from, &source) && grid_of(to, &target) && is_alike(&source, &target);
}

bool h5_copy_chunks(hid_t from, size_t row, hid_t to, size_t to_row, bool *written, uint64_t *sum) {
  chunk_grid source, target;
  stored_chunk c = {0};
  bool good = grid_of(from, &source) && grid_of(to, &target);
  *written = true;
  for (size_t k = 0; good && *written && k < source.each; k++) {
    const hsize_t at[H5_MAX_RANK] = {to_row, k * target.chunk[1]};
    good = read_chunk(&source, row, k, &c);
    if (!good) break;
    *sum += sum_of(&target, to_row, k, &c);
    *written = H5Dwrite_chunk(to, H5P_DEFAULT, c.mask, at, (size_t)c.size, c.bytes) >= 0;
  }
  free(c.bytes);
  return good;
}

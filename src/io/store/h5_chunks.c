/* h5_chunks.c: rows that go into the chunks of a compressed dataset.
 *
 * Rows come one after the other. They are gathered until a chunk is full, and each chunk is written once. A chunk
 * that deflate would not make smaller by a quarter is stored as it is, past the filters (the chunk says so
 * itself, and every reader of HDF5 knows): of most coordinates, velocities and forces all but the leading bytes are
 * noise, on which deflate spends forty times as long as the disk. Integers and what repeats go through the filters.
 * The last filter is HDF5's checksum (Fletcher 32); a chunk that is stored as it is gets its own from here, so that every
 * reader notices when it was altered.
 */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "io/store/h5_private.h"

/* H5Dwrite_chunk came with 1.10.3. */
#define HAS_WRITE_CHUNK H5_VERSION_GE(1, 10, 3)

/* Elements of a chunk that are looked at. */
enum { LOOKS = 4096 };
static const double WORTH =
    0.75; /* estimated size over plain size below which deflate is worth its time */

/* --- what deflate would make of it ------------------------------------------------------------------------ */

static double entropy(const uint32_t count[256], size_t n) {
  double sum = 0.0;
  for (int k = 0; k < 256; k++)
    if (count[k] > 0) sum += (double)count[k] * log2((double)n / (double)count[k]);
  return sum / (double)n; /* bits */
}

/* The filters see byte 0 of all elements, then byte 1 of all, ... A byte costs its entropy there, or, where the rows of a
 * chunk are much alike, what is left of it when the row before is known. */
static bool is_noise(const unsigned char *data, size_t n, size_t element, size_t row) {
  size_t step = (n / LOOKS) | 1, looks = 0;
  double bits = 0.0;
  for (size_t b = 0; b < element; b++) {
    uint32_t plain[256] = {0}, change[256] = {0};
    looks = 0;
    for (size_t k = row; k < n; k += step, looks++) {
      unsigned char here = data[k * element + b];
      plain[here]++;
      change[here ^ data[(k - row) * element + b]]++;
    }
    if (looks == 0) return false;
    double own = entropy(plain, looks);
    bits += row > 0 ? fmin(own, entropy(change, looks)) : own;
  }
  return bits > WORTH * 8.0 * (double)element;
}

/* --- chunks ------------------------------------------------------------------------------------------------- */

static bool write_slab(hid_t set, hid_t type, int rank, const hsize_t *start, const hsize_t *count,
                       const void *data) {
  hid_t space = H5Dget_space(set), memory = H5Screate_simple(rank, count, NULL);
  bool good = space >= 0 && memory >= 0 &&
              H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
              H5Dwrite(set, type, memory, space, H5P_DEFAULT, data) >= 0;
  if (!good) return false; /* any further call would clear the library's reason */
  H5Sclose(memory);
  H5Sclose(space);
  return true;
}

/* A whole chunk, or all of it that lies in the dataset. The library cannot add to a chunk that went past its filters
 * (1.10.8 inflates it). */
static bool is_whole(const h5_rows *w, const hsize_t *start, const hsize_t *count) {
  bool whole = true;
  for (int k = 0; k < w->rank; k++)
    whole = whole && start[k] % w->chunk[k] == 0 &&
            (count[k] == w->chunk[k] || start[k] + count[k] == w->dims[k]);
  return whole;
}

/* Fletcher's sums over the big-endian 16-bit words, as HDF5's filter has them: modulo 65535, where a multiple of it that is
 * not 0 stands as 65535. Chunks are far below the 2^24 words at which the sums would overflow. */
static uint32_t fletcher32(const unsigned char *data, size_t n) {
  uint64_t first = 0, second = 0;
  for (size_t k = 0; k + 1 < n; k += 2) {
    first += (uint64_t)data[k] << 8 | data[k + 1];
    second += first;
  }
  if (n % 2) {
    first += (uint64_t)data[n - 1] << 8;
    second += first;
  }
  uint32_t low = first ? (uint32_t)((first - 1) % 65535) + 1 : 0;
  uint32_t high = second ? (uint32_t)((second - 1) % 65535) + 1 : 0;
  return high << 16 | low;
}

/* Stores a chunk past the filters that make it smaller; n of `full` elements are given, the rest is 0. */
static bool store_chunk(h5_rows *w, const hsize_t *start, size_t n, size_t full,
                        const unsigned char *data) {
  size_t bytes = full * w->element, given = n * w->element;
  if (!w->padded) w->padded = memory_grow(NULL, bytes + sizeof(uint32_t), 1);
  memcpy(w->padded, data, given);
  memset(w->padded + given, 0, bytes - given);
  uint32_t past = UINT32_MAX >> (32 - w->filters); /* a bit per filter that is left out */
  if (w->checksum) {
    past >>= 1;
    uint32_t sum = fletcher32(w->padded, bytes);
    for (int k = 0; k < 4; k++) w->padded[bytes++] = (unsigned char)(sum >> 8 * k);
  }
  return H5Dwrite_chunk(w->set, H5P_DEFAULT, past, start, bytes, w->padded) >= 0;
}

/* Rows, or a part of one, that belong to one chunk. */
static bool write_chunk(h5_rows *w, const hsize_t *start, const hsize_t *count,
                        const unsigned char *data) {
#if HAS_WRITE_CHUNK
  size_t n = 1, full = 1;
  for (int k = 0; k < w->rank; k++) n *= (size_t)count[k], full *= (size_t)w->chunk[k];
  size_t row = count[0] > 1 ? n / (size_t)count[0] : 0; /* else there is no row before */
  /* without a filter that makes chunks smaller there is nothing to leave out */
  if (w->filters > w->checksum && is_whole(w, start, count) && is_noise(data, n, w->element, row))
    return store_chunk(w, start, n, full, data);
#endif
  return write_slab(w->set, w->type, w->rank, start, count, data);
}

/* Rows first ... first + n - 1, all of one row of chunks. */
static bool write_band(h5_rows *w, size_t first, size_t n, const unsigned char *data) {
  hsize_t start[H5_MAX_RANK] = {first}, count[H5_MAX_RANK] = {n};
  for (int k = 1; k < w->rank; k++) count[k] = w->dims[k];
  if (w->rank < 2 || w->chunk[1] == w->dims[1]) return write_chunk(w, start, count, data);
  /* a row is longer than a chunk: what follows the second index is whole */
  size_t bytes = w->element;
  for (int k = 2; k < w->rank; k++) bytes *= (size_t)w->dims[k];
  for (hsize_t at = 0; at < w->dims[1]; at += w->chunk[1]) {
    start[1] = at;
    count[1] = w->dims[1] - at < w->chunk[1] ? w->dims[1] - at : w->chunk[1];
    if (!write_chunk(w, start, count, data + (size_t)at * bytes)) return false;
  }
  return true;
}

/* --- rows --------------------------------------------------------------------------------------------------- */

/* Is the last filter the checksum? */
static bool has_checksum(hid_t create, int filters) {
  size_t none = 0;
  unsigned flags, config;
  return filters > 0 && H5Pget_filter2(create, (unsigned)filters - 1, &flags, &none, NULL, 0, NULL,
                                       &config) == H5Z_FILTER_FLETCHER32;
}

bool h5_rows_open(h5_rows *w, hid_t set, sd_type type) {
  *w = (h5_rows){.set = set, .type = h5_native(type), .element = sd_type_size(type)};
  hid_t space = H5Dget_space(set), create = H5Dget_create_plist(set), stored = H5Dget_type(set);
  w->rank = H5Sget_simple_extent_dims(space, w->dims, NULL);
  w->row = w->element;
  for (int k = 1; k < w->rank; k++) w->row *= (size_t)w->dims[k];
  /* chunks as choose_chunk makes them: of whole rows, or parts of one row with all of the later indices */
  if (H5Pget_layout(create) == H5D_CHUNKED && H5Tequal(stored, w->type) > 0 &&
      H5Pget_chunk(create, w->rank, w->chunk) == w->rank) {
    w->chunked = w->chunk[0] == 1 || w->rank < 2 || w->chunk[1] == w->dims[1];
    for (int k = 2; k < w->rank; k++) w->chunked = w->chunked && w->chunk[k] == w->dims[k];
    w->filters = H5Pget_nfilters(create);
    w->checksum = has_checksum(create, w->filters);
  }
  H5Tclose(stored);
  H5Pclose(create);
  H5Sclose(space);
  return w->rank > 0 && w->rank <= H5_MAX_RANK;
}

bool h5_rows_flush(h5_rows *w) {
  size_t n = w->held, first = w->first;
  w->held = 0;
  w->first += n;
  return n == 0 || write_band(w, first, n, w->buffer);
}

/* Takes rows into the buffer, up to the end of their chunk; returns how many. */
static size_t hold(h5_rows *w, size_t n, const unsigned char *data) {
  assert(w->held < (size_t)w->chunk[0]);
  size_t most = (size_t)w->chunk[0] - w->held;
  if (!w->buffer) w->buffer = memory_grow(NULL, (size_t)w->chunk[0], w->row);
  if (n > most) n = most;
  memcpy(w->buffer + w->held * w->row, data, n * w->row);
  w->held += n;
  return n;
}

bool h5_rows_put(h5_rows *w, size_t first, size_t n, const void *data) {
  const unsigned char *at = data;
  hsize_t start[H5_MAX_RANK] = {first}, count[H5_MAX_RANK] = {n};
  for (int k = 1; k < w->rank; k++) count[k] = w->dims[k];
  if (!w->chunked) return write_slab(w->set, w->type, w->rank, start, count, data);
  assert(first == w->first + w->held && first + n <= w->dims[0]);
  size_t rows = (size_t)w->chunk[0];
  while (n > 0) {
    bool good;
    size_t done;
    if (w->held == 0 && n >= rows) { /* whole chunks need no buffer */
      done = rows;
      good = write_band(w, w->first, rows, at);
      w->first += rows;
    } else {
      done = hold(w, n, at);
      good = w->held < rows || h5_rows_flush(w);
    }
    if (!good) return false;
    n -= done;
    at += done * w->row;
  }
  return true;
}

void h5_rows_close(h5_rows *w) {
  free(w->buffer);
  free(w->padded);
  *w = (h5_rows){.set = w->set};
}

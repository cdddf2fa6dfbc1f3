/* h5_file.c: the record of an open HDF5 file, its opening and closing, errors of the library, and
 * writing of rows into chunks; see h5.h. */
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"
#include "io/store/h5_private.h"

/* --- Library ---------------------------------------------------------------------------------- */

/* Called for an entry of the library's error stack: notes a lack of memory, since the failed call
 * would otherwise look as if its object did not exist. */
static herr_t look_for_shortage(unsigned n, const H5E_error2_t *error, void *user) {
  (void)n, (void)user;
  if (error->maj_num == H5E_RESOURCE) shortage_note();
  return 0;
}

/* Called by the library when one of its functions has failed: looks through the error stack for a
 * lack of memory. */
static herr_t look_at_error(hid_t stack, void *user) {
  H5Ewalk2(stack, H5E_WALK_UPWARD, look_for_shortage, user);
  return 0;
}

void h5_quiet(void) {
  static bool asked;
  /* must precede all other calls of the library: at exit it would write to files that have
   * failed */
  if (!__atomic_exchange_n(&asked, true, __ATOMIC_RELAXED)) H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, look_at_error, NULL);
}

/* Called for each entry of the library's error stack; keeps the first description in *user. */
static herr_t first_reason(unsigned n, const H5E_error2_t *error, void *user) {
  const char **reason = user;
  (void)n;
  if (error->desc && !*reason) *reason = error->desc;
  return 0;
}

const char *h5_reason(char *text, size_t size) {
  const char *reason = NULL;
  /* upward: the innermost entry, the actual cause, comes first */
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, first_reason, &reason);
  snprintf(text, size, "%s", reason ? reason : "unknown reason");
  return text;
}

const char *h5_version(char *text, size_t size) {
  unsigned major = 0, minor = 0, release = 0;
  h5_quiet();
  H5get_libversion(&major, &minor, &release);
  snprintf(text, size, "%u.%u.%u", major, minor, release);
  return text;
}

bool h5_is_file(const char *path) {
  uint64_t size;
  const int fd = file_open_quiet(path, &size);
  char *again = fd < 0 ? NULL : file_reopen_path(fd, path);
  h5_quiet();
  const bool found = again && H5Fis_hdf5(again) > 0;
  free(again);
  if (fd >= 0) close(fd);
  return found;
}

/* --- Record of a file ------------------------------------------------------------------------- */

static void free_journal(h5_file *file) {
  for (size_t k = 0; k < file->n_entries; k++) {
    free(file->journal[k].path);
    free(file->journal[k].attr);
    free(file->journal[k].direct);
  }
  free(file->journal);
}

void h5_shares_free(h5_shares *s) {
  if (!s) return;
  for (size_t k = 0; k < s->n_sets; k++) {
    free(s->set[k].path);
    free(s->set[k].own);
  }
  for (size_t g = 0; g < H5_SHARED_GROUPS; g++) {
    for (size_t k = 0; s->group[g].place && k < s->n; k++) free(s->group[g].place[k]);
    free(s->group[g].place);
    free(s->group[g].rows);
  }
  for (size_t k = 0; s->file && k < s->n; k++) h5_close(s->file[k], NULL);
  free(s->file);
  free(s->set);
  free(s);
}

h5_file *h5_allocate(const char *path) {
  h5_quiet();
  h5_file *file = memory_new(1, sizeof *file);
  file->path = memory_text(path);
  return file;
}

void h5_release(h5_file *file) {
  if (!file) return;
  free(file->path);
  free(file->trouble);
  for (size_t k = 0; k < file->n_sets; k++) {
    h5_rows_close(&file->sets[k].rows);
    free(file->sets[k].path);
  }
  free(file->sets);
  free(file->loans);
  h5_shares_free(file->shares);
  free_journal(file);
  free(file);
}

/* --- Opening and closing ---------------------------------------------------------------------- */

sd_status h5_open_descriptor(int fd, const char *path, h5_file **out, sd_messages *messages) {
  *out = h5_allocate(path);
  char *again = file_reopen_path(fd, path), reason[200];
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);
#if H5_VERSION_GE(1, 10, 7)
  /* no lock is needed, since files were renamed into place whole, and some file systems cannot
   * lock */
  H5Pset_file_locking(access, false, true);
#endif
  (*out)->id = H5Fopen(again, H5F_ACC_RDONLY, access);
  h5_reason(reason, sizeof reason); /* reads the reason before any other call clears it */
  H5Pclose(access);
  if ((*out)->id >= 0) {
    free(again);
    return SD_OK;
  }
  if (H5Fis_hdf5(again) == 0)
    sd_fail(messages, SD_ERROR_IO, "%s is not an HDF5 file", path);
  else
    sd_fail(messages, SD_ERROR_IO, "%s is not a readable HDF5 file: %s", path, reason);
  free(again);
  h5_release(*out);
  *out = NULL;
  return SD_ERROR_IO;
}

/* Records a failed operation on the object at path, unless `good` is true; only the first failure
 * is kept. */
void h5_require(h5_file *file, bool good, const char *path) {
  if (good || file->failed) return;
  char reason[200];
  file->failed = true;
  file->trouble = format_text("%s: %s", path, h5_reason(reason, sizeof reason));
}

void h5_flush_sets(h5_file *file) {
  for (size_t k = 0; k < file->n_sets && !file->failed; k++) {
    h5_rows *rows = &file->sets[k].rows;
    h5_require(file, h5_rows_flush(rows) && H5Dclose(rows->set) >= 0, file->sets[k].path);
  }
}

/* Flushes and closes the file and reports the first failure of a write. The caller must still call
 * h5_release. */
sd_status h5_flush_and_close(h5_file *file, sd_messages *messages) {
  char reason[200];
  h5_flush_sets(file);
  /* After a failed write the library keeps buffers that it cannot release, and closing may crash:
   * such a file stays open until the process ends. */
  if (!file->failed &&
      ((file->writing && H5Fflush(file->id, H5F_SCOPE_GLOBAL) < 0) || H5Fclose(file->id) < 0)) {
    file->failed = true;
    file->trouble = memory_text(h5_reason(reason, sizeof reason));
  }
  if (!file->failed) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "cannot write %s: %s", file->path, file->trouble);
}

sd_status h5_close(h5_file *file, sd_messages *messages) {
  if (!file) return SD_OK;
  sd_status status = h5_flush_and_close(file, messages);
  h5_release(file);
  return status;
}

bool h5_failed(const h5_file *file) { return file->failed; }

/* Writing of rows into the chunks of a compressed dataset.
 *
 * Rows come in order. They are gathered until a chunk is full, and each chunk is written once. A
 * chunk that deflate would not make smaller by a quarter is stored without the compressing filters;
 * HDF5 marks such a chunk, and every reader knows the mark. In most coordinates, velocities and
 * forces all but the leading bytes are noise, on which deflate spends forty times as long as the
 * disk. Integers and repeating values go through the filters. The last filter is HDF5's checksum
 * (Fletcher 32); a chunk that is stored directly gets its checksum here, so that every reader
 * notices when it was altered.
 */

/* H5Dwrite_chunk exists since HDF5 1.10.3 */
#define HAS_WRITE_CHUNK H5_VERSION_GE(1, 10, 3)

/* Number of elements of a chunk that are sampled to estimate its size after deflate */
enum { LOOKS = 4096 };
static const double WORTH =
    0.75; /* estimated size divided by plain size below which deflate is worth its time */

/* --- Estimate of compression ------------------------------------------------------------------ */

/* Returns the entropy of n bytes, of which count[k] have the value k, in bits per byte. */
static double entropy(const uint32_t count[256], size_t n) {
  double sum = 0.0;
  for (int k = 0; k < 256; k++)
    if (count[k] > 0) sum += (double)count[k] * log2((double)n / (double)count[k]);
  return sum / (double)n;
}

/* Returns true if deflate would save less than a quarter, by an estimate. The shuffle filter puts
 * byte 0 of all elements first, then byte 1 of all, and so on. Each byte is estimated to cost its
 * entropy within its group or, if the rows of a chunk are similar, the entropy of its change from
 * the row before. */
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

/* --- Chunks ----------------------------------------------------------------------------------- */

/* Writes count[k] elements from start[k] on along each dimension k. Returns false if that
 * failed. */
static bool write_slab(hid_t set, hid_t type, int rank, const hsize_t *start, const hsize_t *count,
                       const void *data) {
  hid_t space = H5Dget_space(set), memory = H5Screate_simple(rank, count, NULL);
  bool good = space >= 0 && memory >= 0 &&
              H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
              H5Dwrite(set, type, memory, space, H5P_DEFAULT, data) >= 0;
  /* return before any other call of the library clears the reason of the failure */
  if (!good) return false;
  H5Sclose(memory);
  H5Sclose(space);
  return true;
}

/* Returns true if the elements are a whole chunk, or all of a chunk that lies inside the dataset.
 * The library cannot add to a chunk that was stored without its filters (1.10.8 inflates it). */
static bool is_whole(const h5_rows *w, const hsize_t *start, const hsize_t *count) {
  bool whole = true;
  for (int k = 0; k < w->rank; k++)
    whole = whole && start[k] % w->chunk[k] == 0 &&
            (count[k] == w->chunk[k] || start[k] + count[k] == w->dims[k]);
  return whole;
}

/* Returns the Fletcher checksum over big-endian 16-bit words as HDF5's filter computes it: sums
 * modulo 65535, with 65535 for multiples of it other than 0. Chunks are far below the 2^24 words at
 * which the sums would overflow. */
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

/* Stores a chunk without the compressing filters. The first n of its `full` elements are given, the
 * others become 0. */
static bool store_chunk(h5_rows *w, const hsize_t *start, size_t n, size_t full,
                        const unsigned char *data) {
  size_t bytes = full * w->element, given = n * w->element;
  if (!w->padded) w->padded = memory_grow(NULL, bytes + sizeof(uint32_t), 1);
  memcpy(w->padded, data, given);
  memset(w->padded + given, 0, bytes - given);
  /* mask with a bit for each filter that is not applied */
  uint32_t past = UINT32_MAX >> (32 - w->filters);
  if (w->checksum) {
    past >>= 1;
    uint32_t sum = fletcher32(w->padded, bytes);
    for (int k = 0; k < 4; k++) w->padded[bytes++] = (unsigned char)(sum >> 8 * k);
  }
  return H5Dwrite_chunk(w->set, H5P_DEFAULT, past, start, bytes, w->padded) >= 0;
}

/* Writes rows, or a part of one row, that all lie in one chunk. */
static bool write_chunk(h5_rows *w, const hsize_t *start, const hsize_t *count,
                        const unsigned char *data) {
#if HAS_WRITE_CHUNK
  size_t n = 1, full = 1;
  for (int k = 0; k < w->rank; k++) n *= (size_t)count[k], full *= (size_t)w->chunk[k];
  /* elements of a row, for comparison with the row before; 0: there is one row only */
  size_t row = count[0] > 1 ? n / (size_t)count[0] : 0;
  /* without a compressing filter there is nothing to skip */
  if (w->filters > w->checksum && is_whole(w, start, count) && is_noise(data, n, w->element, row))
    return store_chunk(w, start, n, full, data);
#endif
  return write_slab(w->set, w->type, w->rank, start, count, data);
}

/* Writes rows first ... first + n - 1, which all lie in chunks with the same first index. */
static bool write_band(h5_rows *w, size_t first, size_t n, const unsigned char *data) {
  hsize_t start[H5_MAX_RANK] = {first}, count[H5_MAX_RANK] = {n};
  for (int k = 1; k < w->rank; k++) count[k] = w->dims[k];
  if (w->rank < 2 || w->chunk[1] == w->dims[1]) return write_chunk(w, start, count, data);
  /* a row is longer than a chunk: chunks divide the second index and hold all later indices */
  size_t bytes = w->element;
  for (int k = 2; k < w->rank; k++) bytes *= (size_t)w->dims[k];
  for (hsize_t at = 0; at < w->dims[1]; at += w->chunk[1]) {
    start[1] = at;
    count[1] = w->dims[1] - at < w->chunk[1] ? w->dims[1] - at : w->chunk[1];
    if (!write_chunk(w, start, count, data + (size_t)at * bytes)) return false;
  }
  return true;
}

/* --- Rows ------------------------------------------------------------------------------------- */

/* Returns true if the last filter of a dataset is the Fletcher checksum. create: creation
 * properties of the dataset; filters: number of its filters. */
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
  /* rows are gathered only if chunks are like those of choose_chunk: of whole rows, or of parts of
   * one row with all later indices */
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

/* Copies rows into the buffer, up to the end of their chunk; returns the number of rows copied. */
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

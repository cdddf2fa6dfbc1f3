/* h5_journal.c: keeps checksums of all that is written to a file and compares them with what can be
 * read from it.
 *
 * A write may fail in many places: in a cache of the library that is emptied late, in a block of
 * the file system. So the merge of a run's files, after which these are removed, does not rely on
 * return codes alone.
 */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "io/store/h5_private.h"

/* Largest number of bytes of a dataset that are read back at a time */
enum { PIECE_BYTES = 8 << 20 };

/* Computes the checksum that h5_sum returns. Callers pass `element` as a constant, so that the
 * compiler knows the size of the copy. */
static inline uint64_t sum_words(const unsigned char *at, size_t n, size_t element,
                                 uint64_t first) {
  uint64_t sum = 0;
  for (size_t k = 0; k < n; k++, at += element) {
    uint64_t word = 0;
    memcpy(&word, at, element);
    word += (first + k + 1) * UINT64_C(0x9E3779B97F4A7C15);
    word = (word ^ (word >> 32)) * UINT64_C(0xD6E8FEB86659FD93);
    sum += word ^ (word >> 29);
  }
  return sum;
}

uint64_t h5_sum(const void *data, size_t n, size_t element, uint64_t first) {
  return element == 8   ? sum_words(data, n, 8, first)
         : element == 4 ? sum_words(data, n, 4, first)
         : element == 1 ? sum_words(data, n, 1, first)
                        : sum_words(data, n, element, first);
}

/* Returns true if a journal entry (checksum of what was written) is that of this dataset (attr
 * NULL) or attribute. */
static bool is_of(const h5_entry *e, const char *path, const char *attr) {
  if (!e->attr != !attr || (attr && strcmp(e->attr, attr) != 0)) return false;
  return strcmp(e->path, path) == 0;
}

/* Finds the journal entry of a dataset (attr NULL) or an attribute; NULL: there is none. The search
 * begins with the newest, since rows are mostly written to recent datasets. */
static h5_entry *find(const h5_file *file, const char *path, const char *attr) {
  for (size_t k = file->n_entries; k-- > 0;)
    if (is_of(&file->journal[k], path, attr)) return &file->journal[k];
  return NULL;
}

void h5_expect(h5_file *file, const char *path, const char *attr, uint64_t elements) {
  if (!file->on_disk) return;
  if (file->n_entries == file->most_entries) {
    file->most_entries = 2 * file->most_entries + 64;
    file->journal = memory_grow(file->journal, file->most_entries, sizeof *file->journal);
  }
  file->journal[file->n_entries++] =
      (h5_entry){.path = memory_text(path), .attr = memory_text(attr), .expected = elements};
}

void h5_note(h5_file *file, const char *path, const char *attr, const void *data, size_t n,
             size_t element, uint64_t first) {
  h5_entry *e = file->on_disk ? find(file, path, attr) : NULL;
  if (!e) return;
  e->put += n;
  e->sum += h5_sum(data, n, element, first);
}

void h5_note_chunks(h5_file *file, const char *path, size_t row, size_t n_rows, size_t elements,
                    uint64_t sum) {
  h5_entry *e = file->on_disk ? find(file, path, NULL) : NULL;
  if (!e) return;
  if (!e->direct) e->direct = memory_new(n_rows, sizeof *e->direct);
  e->direct[row] = true;
  e->put += elements;
  e->sum += sum;
}

/* --- Reading back ----------------------------------------------------------------------------- */

/* Returns the size in bytes of the elements over which checksums run; *each receives the number of
 * such elements per value of this type: texts are summed byte by byte. */
static size_t element_of(hid_t type, size_t *each) {
  size_t size = H5Tget_size(type);
  bool text = H5Tget_class(type) == H5T_STRING;
  *each = text ? size : 1;
  return text ? 1 : size;
}

/* Reads rows first ... first + n - 1 of a dataset in its stored type. */
static bool read_rows(hid_t set, hid_t type, int rank, const hsize_t *dims, hsize_t first,
                      hsize_t n, void *data) {
  if (rank == 0) return H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0;
  hsize_t start[H5S_MAX_RANK] = {first}, count[H5S_MAX_RANK] = {n};
  for (int k = 1; k < rank; k++) count[k] = dims[k];
  return h5_read_slab(set, type, start, count, data);
}

/* Computes the number of elements of a dataset and their checksum; returns false if it cannot be
 * read. direct: rows of which the stored chunks enter, may be NULL. */
static bool sum_set(hid_t set, const bool *direct, uint64_t *elements, uint64_t *sum) {
  hid_t type = H5Dget_type(set), space = H5Dget_space(set);
  hsize_t dims[H5S_MAX_RANK] = {1};
  int rank = H5Sget_simple_extent_dims(space, dims, NULL);
  size_t each, element = element_of(type, &each), row = each;
  for (int k = 1; k < rank; k++) row *= (size_t)dims[k];
  hsize_t rows = rank == 0 ? 1 : dims[0], piece = PIECE_BYTES / (row * element + 1) + 1;
  unsigned char *data = NULL;
  const size_t most = (size_t)(piece < rows ? piece : rows);
  bool good = rank >= 0 && element <= 8 && memory_resize_row(&data, most, row * element);
  *elements = *sum = 0;
  for (hsize_t at = 0, n; good && row > 0 && at < rows; at += n) {
    for (n = 1; n < piece && at + n < rows && (!direct || direct[at + n] == direct[at]);) n++;
    if (direct && direct[at]) {
      good = h5_sum_chunks(set, (size_t)at, (size_t)n, sum);
    } else {
      good = read_rows(set, type, rank, dims, at, n, data);
      if (good) *sum += h5_sum(data, (size_t)n * row, element, *elements);
    }
    *elements += n * row;
  }
  free(data);
  H5Sclose(space);
  H5Tclose(type);
  return good;
}

/* Computes the number of elements of an attribute and their checksum. An attribute that has not the
 * expected number of elements is damaged and is not read. */
static bool sum_attr(hid_t attr, uint64_t expected, uint64_t *elements, uint64_t *sum) {
  hid_t type = H5Aget_type(attr), space = H5Aget_space(attr);
  size_t each, element = element_of(type, &each);
  hssize_t n = H5Sget_simple_extent_npoints(space);
  const bool whole = n >= 0 && element <= 8 && (uint64_t)n * each == expected;
  unsigned char *data = whole ? memory_new((size_t)n * each, element) : NULL;
  bool good = data && H5Aread(attr, type, data) >= 0;
  *elements = good ? (uint64_t)n * each : 0;
  *sum = good ? h5_sum(data, (size_t)*elements, element, 0) : 0;
  free(data);
  H5Sclose(space);
  H5Tclose(type);
  return good;
}

/* Returns true if the dataset or attribute of a journal entry reads back as it was written. */
static bool is_there(const h5_file *file, const h5_entry *e) {
  uint64_t elements = 0, sum = 0;
  hid_t id = e->attr ? H5Aopen_by_name(file->id, e->path, e->attr, H5P_DEFAULT, H5P_DEFAULT)
                     : H5Dopen2(file->id, e->path, H5P_DEFAULT);
  if (id < 0) return false;
  bool good = e->attr ? sum_attr(id, e->expected, &elements, &sum)
                      : sum_set(id, e->direct, &elements, &sum);
  if (e->attr)
    H5Aclose(id);
  else
    H5Dclose(id);
  return good && elements == e->expected && e->put == e->expected && sum == e->sum;
}

sd_status h5_compare(const h5_file *file, const h5_file *written, sd_messages *messages) {
  for (size_t k = 0; k < written->n_entries; k++) {
    const h5_entry *e = &written->journal[k];
    if (!is_there(file, e))
      return sd_fail(messages, SD_ERROR_IO,
                     "cannot write %s: %s%s%s does not read back as it was written", written->path,
                     e->path, e->attr ? ", attribute " : "", e->attr ? e->attr : "");
  }
  return SD_OK;
}

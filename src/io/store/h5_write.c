/* h5_write.c: makes HDF5 files and writes to them; see h5.h. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"
#include "io/store/h5_private.h"

/* Approximate size of a chunk in bytes, far less than the library's chunk cache of 1 MiB, so that
 * rows that come in pieces do not make it compress a chunk again and again. */
enum { CHUNK_BYTES = 256 * 1024 };

sd_status h5_create(const file_draft *draft, uint64_t bytes, h5_file **out, sd_messages *messages) {
  h5_file *file = *out = h5_allocate(draft->path);
  file->writing = file->on_disk = true;
  sd_status status = file_reserve(draft->fd, draft->path, bytes, messages);
  if (status == SD_OK) {
    char *again = file_reopen_path(draft->fd, draft->path), reason[200];
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    /* without its sieve buffer the library writes at once, and the call that writes returns the
     * failure */
    H5Pset_sieve_buf_size(access, 0);
    file->id = H5Fcreate(again, H5F_ACC_TRUNC, H5P_DEFAULT, access);
    h5_reason(reason, sizeof reason);
    H5Pclose(access);
    if (file->id < 0)
      status = sd_fail(messages, SD_ERROR_IO, "cannot create %s: %s", draft->path, reason);
    free(again);
  }
  if (status == SD_OK) return SD_OK;
  h5_release(file);
  *out = NULL;
  return status;
}

sd_status h5_finish(h5_file *file, const file_draft *draft, sd_messages *messages) {
  h5_file *back = NULL;
  uint64_t small = 0;
  int64_t one = 1;
  h5_attr(file, "/", "sealed", SD_I64, 0, &one);
  sd_status status = h5_flush_and_close(file, messages);
  if (status == SD_OK) status = h5_open_descriptor(draft->fd, draft->path, &back, messages);
  if (status == SD_OK) status = h5_compare(back, file, messages);
  if (status == SD_OK) status = h5_small_sum(back, &small, messages);
  h5_close(back, NULL);
  if (status == SD_OK) status = h5_put_seal(draft->fd, draft->path, small, messages);
  h5_release(file);
  return status;
}

/* --- Writing ---------------------------------------------------------------------------------- */

void h5_no_memory(h5_file *file, const char *path) {
  if (file->failed) return;
  file->failed = true;
  file->trouble = format_text("no memory for %s", path);
}

/* Returns properties of new links: missing groups on the path are made, and names are UTF-8. */
static hid_t with_parents(void) {
  hid_t list = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(list, 1);
  H5Pset_char_encoding(list, H5T_CSET_UTF8);
  return list;
}

/* Returns the type of UTF-8 strings of this length, padded with zeros. */
static hid_t text_type(size_t length) {
  hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, length ? length : 1);
  H5Tset_cset(type, H5T_CSET_UTF8);
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  return type;
}

void h5_group(h5_file *file, const char *path) {
  if (file->failed || h5_exists(file, path)) return;
  hid_t link = with_parents();
  hid_t group = H5Gcreate2(file->id, path, link, H5P_DEFAULT, H5P_DEFAULT);
  h5_require(file, group >= 0, path);
  if (group >= 0) H5Gclose(group);
  H5Pclose(link);
}

/* Returns the smallest size of pieces that cover `length` with no more pieces than pieces of size
 * `most` need. The last piece, which is stored at full size, is then nearly as long as the
 * others. */
static size_t even_pieces(size_t length, size_t most) {
  size_t pieces = (length + most - 1) / most;
  return pieces > 0 ? (length + pieces - 1) / pieces : 1;
}

/* Chooses chunks of whole rows if a row fits into CHUNK_BYTES, else of parts of one row. */
static void choose_chunk(int rank, const size_t *dims, size_t element, hsize_t *chunk) {
  size_t row = element;
  for (int k = 1; k < rank; k++) {
    chunk[k] = dims[k] ? dims[k] : 1;
    row *= (size_t)chunk[k];
  }
  size_t rows = CHUNK_BYTES / row;
  chunk[0] = rows ? even_pieces(dims[0], rows) : 1;
  for (int k = 1; k < rank && row > CHUNK_BYTES; k++) {
    size_t rest = row / (size_t)chunk[k];
    size_t keep = CHUNK_BYTES / rest;
    chunk[k] = keep ? even_pieces(dims[k], keep) : 1;
    row = rest * (size_t)chunk[k];
  }
}

/* Storage of a dataset. LENT: the values stay in the caller's memory; space is allocated in the
 * file at once, but the library writes nothing there. */
typedef enum layout { PLAIN, COMPRESSED, LENT } layout;

/* Makes a dataset and its journal entry (checksum of what is written). Returns a negative value,
 * and records the failure in the file, if that fails. */
static hid_t make(h5_file *file, const char *path, hid_t type, int rank, const size_t *dims,
                  layout how) {
  hsize_t extent[H5_MAX_RANK] = {0}, chunk[H5_MAX_RANK] = {0};
  for (int k = 0; k < rank; k++) extent[k] = dims[k];
  hid_t link = with_parents();
  hid_t create = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_obj_track_times(create, false);
  if (how == LENT) {
    H5Pset_alloc_time(create, H5D_ALLOC_TIME_EARLY);
    H5Pset_fill_time(create, H5D_FILL_TIME_NEVER);
  }
  if (how == COMPRESSED && rank > 0) {
    choose_chunk(rank, dims, H5Tget_size(type), chunk);
    H5Pset_chunk(create, rank, chunk);
    if (H5Zfilter_avail(H5Z_FILTER_DEFLATE) > 0) {
      H5Pset_shuffle(create);
      H5Pset_deflate(create, 1);
    }
    if (H5Zfilter_avail(H5Z_FILTER_FLETCHER32) > 0) H5Pset_fletcher32(create);
  }
  hid_t space = rank == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(rank, extent, NULL);
  hid_t set = H5Dcreate2(file->id, path, type, space, link, create, H5P_DEFAULT);
  h5_require(file, set >= 0, path);
  uint64_t elements = H5Tget_class(type) == H5T_STRING ? H5Tget_size(type) : 1;
  for (int k = 0; k < rank; k++) elements *= dims[k];
  if (set >= 0) h5_expect(file, path, NULL, elements);
  H5Sclose(space);
  H5Pclose(create);
  H5Pclose(link);
  return set;
}

/* Closes a dataset; this writes what the library still holds in its caches. */
static void close_set(h5_file *file, hid_t set, const char *path) {
  if (!file->failed) h5_require(file, H5Dclose(set) >= 0, path);
}

void h5_put(h5_file *file, const char *path, sd_type type, int rank, const size_t *dims,
            const void *data, bool compress) {
  if (file->failed) return;
  size_t n = 1;
  for (int k = 0; k < rank; k++) n *= dims[k];
  /* for small datasets a filter costs more than it saves */
  bool large = compress && n * sd_type_size(type) > 4096;
  hid_t set = make(file, path, h5_native(type), rank, dims, large ? COMPRESSED : PLAIN);
  if (set < 0) return;
  if (n > 0 && large) {
    h5_rows rows;
    bool good = h5_rows_open(&rows, set, type) && h5_rows_put(&rows, 0, dims[0], data) &&
                h5_rows_flush(&rows);
    h5_require(file, good, path);
    h5_rows_close(&rows);
  } else if (n > 0) {
    h5_require(file, H5Dwrite(set, h5_native(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0,
               path);
  }
  h5_note(file, path, NULL, data, n, sd_type_size(type), 0);
  close_set(file, set, path);
}

void h5_lend(h5_file *file, const char *path, sd_type type, int rank, const size_t *dims,
             const void *data) {
  size_t bytes = sd_type_size(type);
  for (int k = 0; k < rank; k++) bytes *= dims[k];
  if (!file->borrows || bytes < H5_LOAN_LEAST) {
    h5_put(file, path, type, rank, dims, data, false);
    return;
  }
  if (file->failed) return;
  h5_loan *loans = file->loans = memory_grow(file->loans, file->n_loans + 1, sizeof *loans);
  hid_t set = make(file, path, h5_native(type), rank, dims, LENT);
  if (set < 0) return;
  const haddr_t at = H5Dget_offset(set);
  h5_require(file, at != HADDR_UNDEF, path);
  size_t k = file->n_loans++;
  for (; k > 0 && loans[k - 1].at > at; k--) loans[k] = loans[k - 1];
  loans[k] = (h5_loan){at, data, bytes};
  close_set(file, set, path);
}

void h5_put_text(h5_file *file, const char *path, const char *text) {
  if (file->failed) return;
  if (!text) text = "";
  hid_t type = text_type(strlen(text));
  hid_t set = make(file, path, type, 0, NULL, PLAIN);
  if (set >= 0) {
    h5_require(file, H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) >= 0, path);
    h5_note(file, path, NULL, text, H5Tget_size(type), 1, 0);
    close_set(file, set, path);
  }
  H5Tclose(type);
}

/* Joins n texts, each filled up with zeros to the length of the longest; to be freed. */
static char *dense_texts(size_t n, const char *const *texts, size_t *longest) {
  *longest = 1;
  for (size_t k = 0; k < n; k++)
    if (texts[k] && strlen(texts[k]) > *longest) *longest = strlen(texts[k]);
  char *all = memory_new(n, *longest);
  for (size_t k = 0; k < n; k++)
    if (texts[k]) memcpy(all + k * *longest, texts[k], strlen(texts[k]));
  return all;
}

void h5_put_texts(h5_file *file, const char *path, size_t n, const char *const *texts) {
  if (file->failed) return;
  size_t longest;
  char *all = dense_texts(n, texts, &longest);
  hid_t type = text_type(longest), set = make(file, path, type, 1, &n, PLAIN);
  if (set >= 0) {
    if (n > 0) h5_require(file, H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, all) >= 0, path);
    h5_note(file, path, NULL, all, n * longest, 1, 0);
    close_set(file, set, path);
  }
  H5Tclose(type);
  free(all);
}

/* Writes an attribute and makes its journal entry (checksum of what is written). */
static void write_attr(h5_file *file, const char *path, const char *name, hid_t type, hid_t space,
                       const void *data) {
  hid_t object = H5Oopen(file->id, path, H5P_DEFAULT);
  hid_t attr = object < 0 ? H5I_INVALID_HID
                          : H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  h5_require(file, attr >= 0 && H5Awrite(attr, type, data) >= 0, path);
  bool text = H5Tget_class(type) == H5T_STRING;
  size_t size = H5Tget_size(type),
         n = (size_t)H5Sget_simple_extent_npoints(space) * (text ? size : 1);
  h5_expect(file, path, name, n);
  h5_note(file, path, name, data, n, text ? 1 : size, 0);
  if (file->failed) return;
  h5_require(file, H5Aclose(attr) >= 0 && H5Oclose(object) >= 0, path);
}

void h5_attr(h5_file *file, const char *path, const char *name, sd_type type, size_t n,
             const void *data) {
  if (file->failed) return;
  hsize_t extent = n;
  hid_t space = n == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &extent, NULL);
  write_attr(file, path, name, h5_native(type), space, data);
  H5Sclose(space);
}

void h5_attr_text(h5_file *file, const char *path, const char *name, const char *text) {
  if (file->failed) return;
  if (!text) text = "";
  hid_t type = text_type(strlen(text)), space = H5Screate(H5S_SCALAR);
  write_attr(file, path, name, type, space, text);
  H5Sclose(space);
  H5Tclose(type);
}

void h5_attr_texts(h5_file *file, const char *path, const char *name, size_t n,
                   const char *const *texts) {
  if (file->failed || n == 0) return;
  size_t longest;
  char *all = dense_texts(n, texts, &longest);
  hsize_t extent = n;
  hid_t type = text_type(longest), space = H5Screate_simple(1, &extent, NULL);
  write_attr(file, path, name, type, space, all);
  H5Sclose(space);
  H5Tclose(type);
  free(all);
}

void h5_attr_f64(h5_file *file, const char *path, const char *name, double value) {
  h5_attr(file, path, name, SD_F64, 0, &value);
}

void h5_attr_i64(h5_file *file, const char *path, const char *name, int64_t value) {
  h5_attr(file, path, name, SD_I64, 0, &value);
}

void h5_link(h5_file *file, const char *target, const char *path) {
  if (file->failed) return;
  hid_t link = with_parents();
  h5_require(file, H5Lcreate_hard(file->id, target, file->id, path, link, H5P_DEFAULT) >= 0, path);
  H5Pclose(link);
}

void h5_make(h5_file *file, const char *path, sd_type type, int rank, const size_t *dims,
             bool compress) {
  if (file->failed) return;
  hid_t set = make(file, path, h5_native(type), rank, dims, compress ? COMPRESSED : PLAIN);
  if (set >= 0) close_set(file, set, path);
}

/* Returns the record through which rows of a dataset are written, and opens the dataset at the
 * first call; NULL: that failed. */
static h5_rows *set_of(h5_file *file, const char *path, sd_type type) {
  for (size_t k = 0; k < file->n_sets; k++)
    if (strcmp(file->sets[k].path, path) == 0) return &file->sets[k].rows;
  h5_open_set set = {0};
  hid_t id = H5Dopen2(file->id, path, H5P_DEFAULT);
  if (id >= 0 && h5_rows_open(&set.rows, id, type)) {
    set.path = memory_text(path);
    file->sets = memory_grow(file->sets, file->n_sets + 1, sizeof set);
    file->sets[file->n_sets++] = set;
    return &file->sets[file->n_sets - 1].rows;
  }
  if (id >= 0) H5Dclose(id);
  return NULL;
}

void h5_put_rows(h5_file *file, const char *path, sd_type type, size_t first, size_t n,
                 const void *data) {
  if (file->failed || n == 0) return;
  h5_rows *rows = set_of(file, path, type);
  h5_require(file, rows && h5_rows_put(rows, first, n, data), path);
  if (!rows) return;
  size_t each = rows->row / rows->element;
  h5_note(file, path, NULL, data, n * each, rows->element, (uint64_t)first * each);
}

size_t h5_copy_rows(const h5_file *from, h5_file *out, const char *path, sd_type type, size_t first,
                    size_t n) {
  if (out->failed || n == 0 || h5_shared_set_of(from, path)) return 0;
  h5_rows *rows = set_of(out, path, type);
  hid_t set = rows && rows->chunked ? H5Dopen2(from->id, path, H5P_DEFAULT) : H5I_INVALID_HID;
  if (set < 0) return 0;
  size_t done = 0;
  bool good = h5_chunks_alike(set, rows->set), written = true;
  while (good && done < n) {
    uint64_t sum = 0;
    good = h5_copy_chunks(set, done, rows->set, first + done, &written, &sum);
    h5_require(out, written, path); /* before another call clears the reason */
    good = good && written;
    if (!good) break;
    h5_note_chunks(out, path, first + done, (size_t)rows->dims[0], rows->row / rows->element, sum);
    done++;
  }
  rows->first += done;
  H5Dclose(set);
  return done;
}

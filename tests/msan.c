/* msan.c: what clang's memory sanitizer (SLIPDISK_SANITIZE=memory) cannot see for itself. GSL, HDF5, libconfig, jansson and zlib are
 * not compiled with it, so what they write keeps the state that the memory had before.
 *
 * Linked with --wrap, the functions below stand for those that our objects call; the libraries go on calling theirs. So memory that
 * our objects allocate begins as uninitialised, that of the libraries does not; what a library has written for us counts as
 * initialised; and all that HDF5 is given to write must be.
 */
#include <hdf5.h>
#include <gsl/gsl_histogram.h>
#include <gsl/gsl_linalg.h>
#include <malloc.h>
#include <sanitizer/msan_interface.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "model/model.h"

/* Each wrapper is declared, since our flags ask for it. */
#define WRAP(result, name, ...)                                                                    \
  extern result __real_##name(__VA_ARGS__);                                                        \
  extern result __wrap_##name(__VA_ARGS__);                                                        \
  result __wrap_##name(__VA_ARGS__)

const char *__msan_default_options(void);
const char *__msan_default_options(void) {
  return "poison_in_malloc=0:poison_in_free=0:allocator_may_return_null=1";
}

/* --- memory of our objects ------------------------------------------------------------------------ */

static void *uninitialised(void *made, size_t bytes) {
  if (made) __msan_poison(made, bytes);
  return made;
}

WRAP(void *, malloc, size_t bytes) { return uninitialised(__real_malloc(bytes), bytes); }

WRAP(void *, aligned_alloc, size_t line, size_t bytes) {
  return uninitialised(__real_aligned_alloc(line, bytes), bytes);
}

WRAP(void, free, void *old) {
  if (old) __msan_unpoison(old, malloc_usable_size(old));
  __real_free(old);
}

WRAP(void *, realloc, void *old, size_t bytes) {
  void *made = __wrap_malloc(bytes);
  if (!made || !old) return made;
  const size_t kept = malloc_usable_size(old);
  memcpy(made, old, kept < bytes ? kept : bytes);
  __wrap_free(old);
  return made;
}

/* --- what is written to files --------------------------------------------------------------------- */

WRAP(ssize_t, write, int fd, const void *data, size_t bytes) {
  __msan_check_mem_is_initialized(data, bytes);
  return __real_write(fd, data, bytes);
}

WRAP(ssize_t, pwrite, int fd, const void *data, size_t bytes, off_t at) {
  __msan_check_mem_is_initialized(data, bytes);
  return __real_pwrite(fd, data, bytes, at);
}

/* HDF5 gives functions of the C library what lies on its stack, where others have lain before. These check nothing any more in a
 * thread that has called HDF5. */
static void hdf5_begins(void) {
  static _Thread_local bool begun;
  if (!begun) __msan_scoped_disable_interceptor_checks();
  begun = true;
}

WRAP(herr_t, H5Eset_auto2, hid_t stack, H5E_auto2_t call, void *user) {
  hdf5_begins();
  return __real_H5Eset_auto2(stack, call, user);
}

WRAP(hid_t, H5Fcreate, const char *path, unsigned flags, hid_t create, hid_t access) {
  hdf5_begins();
  return __real_H5Fcreate(path, flags, create, access);
}

WRAP(hid_t, H5Fopen, const char *path, unsigned flags, hid_t access) {
  hdf5_begins();
  return __real_H5Fopen(path, flags, access);
}

static herr_t (*write_pages)(H5FD_t *, H5FD_mem_t, hid_t, haddr_t, size_t, const void *);

static herr_t written_pages(H5FD_t *file, H5FD_mem_t type, hid_t transfer, haddr_t at, size_t bytes,
                            const void *data) {
  __msan_unpoison(data, bytes);
  return write_pages(file, type, transfer, at, bytes, data);
}

/* The driver for files in memory: what HDF5 writes there */
WRAP(hid_t, H5FDregister, const H5FD_class_t *driver) {
  H5FD_class_t own = *driver;
  write_pages = own.write;
  own.write = written_pages;
  return __real_H5FDregister(&own);
}

/* --- what libraries write ------------------------------------------------------------------------- */

#define WRITTEN(at, bytes) ((at) ? __msan_unpoison(at, bytes) : (void)0)

WRAP(void, gsl_sort_index, size_t *order, const double *x, size_t stride, size_t n) {
  __real_gsl_sort_index(order, x, stride, n);
  WRITTEN(order, n * sizeof *order);
}

WRAP(void, gsl_stats_minmax, double *least, double *most, const double *x, size_t stride,
     size_t n) {
  __real_gsl_stats_minmax(least, most, x, stride, n);
  WRITTEN(least, sizeof *least);
  WRITTEN(most, sizeof *most);
}

WRAP(int, gsl_histogram_get_range, const gsl_histogram *h, size_t bin, double *low, double *high) {
  const int status = __real_gsl_histogram_get_range(h, bin, low, high);
  WRITTEN(low, sizeof *low);
  WRITTEN(high, sizeof *high);
  return status;
}

WRAP(int, gsl_linalg_LU_solve, const gsl_matrix *lu, const gsl_permutation *order,
     const gsl_vector *right, gsl_vector *x) {
  const int status = __real_gsl_linalg_LU_solve(lu, order, right, x);
  WRITTEN(x, sizeof *x); /* a view, which GSL has made */
  WRITTEN(x->data, x->size * sizeof *x->data);
  return status;
}

static size_t bytes_in(hid_t object, hid_t type, hid_t space, bool attribute) {
  const hid_t own = space > 0   ? H5Scopy(space)
                    : attribute ? H5Aget_space(object)
                                : H5Dget_space(object);
  const hssize_t n = space > 0 ? H5Sget_select_npoints(own) : H5Sget_simple_extent_npoints(own);
  H5Sclose(own);
  return n > 0 ? (size_t)n * H5Tget_size(type) : 0;
}

WRAP(herr_t, H5Dread, hid_t set, hid_t type, hid_t memory, hid_t space, hid_t plist, void *data) {
  const herr_t status = __real_H5Dread(set, type, memory, space, plist, data);
  if (status >= 0) WRITTEN(data, bytes_in(set, type, memory, false));
  return status;
}

WRAP(herr_t, H5Aread, hid_t attribute, hid_t type, void *data) {
  const herr_t status = __real_H5Aread(attribute, type, data);
  if (status >= 0) WRITTEN(data, bytes_in(attribute, type, H5S_ALL, true));
  return status;
}

WRAP(herr_t, H5Dwrite, hid_t set, hid_t type, hid_t memory, hid_t space, hid_t plist,
     const void *data) {
  __msan_check_mem_is_initialized(data, bytes_in(set, type, memory, false));
  return __real_H5Dwrite(set, type, memory, space, plist, data);
}

WRAP(herr_t, H5Awrite, hid_t attribute, hid_t type, const void *data) {
  __msan_check_mem_is_initialized(data, bytes_in(attribute, type, H5S_ALL, true));
  return __real_H5Awrite(attribute, type, data);
}

WRAP(herr_t, H5Dwrite_chunk, hid_t set, hid_t plist, uint32_t filters, const hsize_t *start,
     size_t bytes, const void *data) {
  __msan_check_mem_is_initialized(data, bytes);
  return __real_H5Dwrite_chunk(set, plist, filters, start, bytes, data);
}

WRAP(ssize_t, H5Fget_file_image, hid_t file, void *data, size_t bytes) {
  const ssize_t n = __real_H5Fget_file_image(file, data, bytes);
  if (n > 0) WRITTEN(data, (size_t)n < bytes ? (size_t)n : bytes);
  return n;
}

WRAP(int, H5Sget_simple_extent_dims, hid_t space, hsize_t *dims, hsize_t *most) {
  const int rank = __real_H5Sget_simple_extent_dims(space, dims, most);
  if (rank > 0) WRITTEN(dims, (size_t)rank * sizeof *dims);
  if (rank > 0) WRITTEN(most, (size_t)rank * sizeof *most);
  return rank;
}

WRAP(int, H5Pget_chunk, hid_t plist, int n, hsize_t *chunk) {
  const int rank = __real_H5Pget_chunk(plist, n, chunk);
  if (rank > 0) WRITTEN(chunk, (size_t)(rank < n ? rank : n) * sizeof *chunk);
  return rank;
}

WRAP(herr_t, H5Lget_info, hid_t place, const char *name, H5L_info_t *info, hid_t plist) {
  const herr_t status = __real_H5Lget_info(place, name, info, plist);
  if (status >= 0) WRITTEN(info, sizeof *info);
  return status;
}

WRAP(herr_t, H5Pfill_value_defined, hid_t plist, H5D_fill_value_t *kind) {
  const herr_t status = __real_H5Pfill_value_defined(plist, kind);
  if (status >= 0) WRITTEN(kind, sizeof *kind);
  return status;
}

WRAP(herr_t, H5Pget_fill_value, hid_t plist, hid_t type, void *value) {
  const herr_t status = __real_H5Pget_fill_value(plist, type, value);
  if (status >= 0) WRITTEN(value, H5Tget_size(type));
  return status;
}

/* The bytes of a file in memory, too: their address is where the handle points. */
WRAP(herr_t, H5Fget_vfd_handle, hid_t file, hid_t plist, void **handle) {
  const herr_t status = __real_H5Fget_vfd_handle(file, plist, handle);
  if (status < 0) return status;
  WRITTEN(handle, sizeof *handle);
  const ssize_t bytes = __real_H5Fget_file_image(file, NULL, 0);
  if (*handle && bytes > 0) __msan_unpoison(*(void **)*handle, (size_t)bytes);
  return status;
}

WRAP(herr_t, H5get_libversion, unsigned *major, unsigned *minor, unsigned *release) {
  const herr_t status = __real_H5get_libversion(major, minor, release);
  WRITTEN(major, sizeof *major);
  WRITTEN(minor, sizeof *minor);
  WRITTEN(release, sizeof *release);
  return status;
}

WRAP(herr_t, H5Tconvert, hid_t from, hid_t to, size_t n, void *values, void *background,
     hid_t plist) {
  const herr_t status = __real_H5Tconvert(from, to, n, values, background, plist);
  if (status >= 0) WRITTEN(values, n * H5Tget_size(to));
  return status;
}

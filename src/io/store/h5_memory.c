/* h5_memory.c: files that are built, or read, in memory; see h5.h. Datasets that are lent (their
 * values stay in the caller's memory) are gaps in the file, which is saved piece by piece: own
 * bytes, lent data, own bytes, ... */
#include <assert.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "base/memory.h"
#include "io/store/file.h"
#include "io/store/h5_private.h"

/* Number of bytes by which a file in memory grows at a time */
static const size_t GROWTH = (size_t)1 << 20;
/* Address space in bytes for the data of a file that are copied into it, not lent by the caller;
 * its pages take memory only when they are first written */
static const size_t BESIDES = (size_t)256 << 20;

/* Writes a name that no other file in memory has, since the library takes two such files of one
 * name for the same file. */
void h5_memory_name(char *name, size_t size) {
  static unsigned count;
  snprintf(name, size, "memory-%u", __atomic_add_fetch(&count, 1u, __ATOMIC_RELAXED));
}

sd_status h5_new(h5_file **out, sd_messages *messages) {
  char name[40];
  h5_memory_name(name, sizeof name);
  *out = h5_allocate(name);
  (*out)->memory = (*out)->writing = true;
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_core(access, GROWTH, false);
  /* The default (earliest) format is used on purpose: h5_save copies the bytes of the open file,
   * and later formats mark an open file as being written. */
  (*out)->id = H5Fcreate(name, H5F_ACC_TRUNC, H5P_DEFAULT, access);
  H5Pclose(access);
  if ((*out)->id >= 0) return SD_OK;
  h5_release(*out);
  *out = NULL;
  return sd_fail(messages, SD_ERROR_IO, "no memory for an HDF5 file");
}

sd_status h5_new_borrowing(uint64_t bytes, h5_file **out, sd_messages *messages) {
  char name[40];
  h5_memory_name(name, sizeof name);
  h5_file *file = *out = h5_allocate(name);
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_alignment(access, H5_LOAN_LEAST, H5_LOAN_ALIGNED);
  file->id = h5_set_pages(access, (size_t)(2 * bytes) + BESIDES)
                 ? H5Fcreate(name, H5F_ACC_TRUNC, H5P_DEFAULT, access)
                 : H5I_INVALID_HID;
  H5Pclose(access);
  file->memory = file->writing = file->borrows = true;
  if (file->id >= 0) return SD_OK;
  h5_release(file);
  return h5_new(out, messages);
}

/* Returns the bytes of a file in memory, without copying them; they are valid while the file is
 * open. NULL: the library failed. */
static const void *image_of(hid_t id, size_t *size) {
  void *handle = NULL;
  if (H5Fflush(id, H5F_SCOPE_GLOBAL) < 0) return NULL;
  ssize_t n = H5Fget_file_image(id, NULL, 0);
  if (n <= 0 || H5Fget_vfd_handle(id, H5P_DEFAULT, &handle) < 0 || !handle) return NULL;
  *size = (size_t)n;
  return *(void **)handle; /* the handle of a file in memory is the address of its bytes */
}

/* A finished file as a list of pieces of memory, which are valid while the file is open. */
typedef struct image {
  size_t size; /* number of bytes of all pieces */
  size_t n;
  file_piece *pieces; /* [n] pieces in the order of the file; the caller frees the array */
} image;

/* Ends the writing of a file and lists the pieces of memory of which it consists. */
static sd_status whole_image(h5_file *file, const char *path, image *m, sd_messages *messages) {
  int64_t one = 1;
  *m = (image){0};
  h5_attr(file, "/", "sealed", SD_I64, 0, &one);
  h5_flush_sets(file);
  const unsigned char *bytes = file->failed ? NULL : image_of(file->id, &m->size);
  if (!bytes)
    return sd_fail(messages, SD_ERROR_IO, "cannot build %s: %s", path,
                   file->trouble ? file->trouble : "no memory");
  m->pieces = memory_new(2 * file->n_loans + 1, sizeof *m->pieces);
  size_t at = 0;
  for (size_t k = 0; k < file->n_loans; k++) {
    const h5_loan *loan = &file->loans[k];
    assert(loan->at >= at && loan->at + loan->bytes <= m->size);
    m->pieces[m->n++] = (file_piece){bytes + at, (size_t)loan->at - at};
    m->pieces[m->n++] = (file_piece){loan->data, loan->bytes};
    at = (size_t)loan->at + loan->bytes;
  }
  m->pieces[m->n++] = (file_piece){bytes + at, m->size - at};
  return SD_OK;
}

sd_status h5_save(h5_file *file, int folder, const char *path, uint64_t *sum,
                  sd_messages *messages) {
  image m;
  file_draft draft = {.folder = -1, .fd = -1};
  unsigned char seal[H5_SEAL_BYTES];
  sd_status status = whole_image(file, path, &m, messages);
  if (status == SD_OK) status = file_draft_new(folder, path, &draft, messages);
  uint64_t found = 0;
  bool good = status == SD_OK && file_write_pieces(draft.fd, m.n, m.pieces, &found);
  if (sum) *sum = found;
  h5_make_seal(m.size, found, seal);
  good = good && file_write_all(draft.fd, seal, sizeof seal);
  if (status == SD_OK && !good)
    status = sd_fail(messages, SD_ERROR_IO, "cannot write %s: %s", path, strerror(errno));
  if (status == SD_OK)
    status = file_draft_publish(&draft, folder, path, FILE_REPLACE, messages);
  else
    file_draft_drop(&draft);
  free(m.pieces);
  H5Fclose(file->id);
  h5_release(file);
  return status;
}

sd_status h5_save_memory(h5_file *file, void **data, size_t *size, sd_messages *messages) {
  image m;
  *data = NULL;
  sd_status status = whole_image(file, "the file in memory", &m, messages);
  if (status == SD_OK) {
    *size = m.size + H5_SEAL_BYTES;
    unsigned char *copy = NULL;
    if (memory_resize_row(&copy, *size, 1)) {
      for (size_t k = 0, at = 0; k < m.n; at += m.pieces[k++].size)
        memcpy(copy + at, m.pieces[k].bytes, m.pieces[k].size);
      h5_make_seal(m.size, file_sum(copy, m.size), copy + m.size);
      *data = copy;
    } else {
      status = sd_fail(messages, SD_ERROR_IO, "no memory for a copy of %zu bytes", *size);
    }
  }
  free(m.pieces);
  H5Fclose(file->id);
  h5_release(file);
  return status;
}

hid_t h5_open_image(const char *name, const void *bytes, size_t size, unsigned flags) {
  hid_t id = H5I_INVALID_HID, access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_core(access, GROWTH, false);
  if (H5Pset_file_image(access, (void *)(uintptr_t)bytes, size) >= 0)
    id = H5Fopen(name, flags, access);
  H5Pclose(access);
  return id;
}

sd_status h5_open_memory(const void *data, size_t size, h5_file **out, sd_messages *messages) {
  *out = NULL;
  if (!h5_seal_fits(data, size))
    return sd_fail(messages, SD_ERROR_IO,
                   "the saved bytes are damaged: their checksum does not fit");
  char name[40];
  h5_memory_name(name, sizeof name);
  *out = h5_allocate(name);
  (*out)->id = h5_open_image(name, data, size - H5_SEAL_BYTES, H5F_ACC_RDONLY);
  if ((*out)->id >= 0) return SD_OK;
  h5_release(*out);
  *out = NULL;
  return sd_fail(messages, SD_ERROR_IO, "the saved bytes are no HDF5 file, or there is no memory");
}

/* An HDF5 driver for files in memory that may have gaps: space that is allocated for a dataset but
 * never written takes no memory. (HDF5's own driver for files in memory fills the whole file.) */

#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

/* An open file of this driver. */
typedef struct pages {
  H5FD_t base;          /* the library's part of a file, which must come first */
  unsigned char *bytes; /* [room] contents of the file, mapped memory */
  size_t room;          /* size of the mapping, bytes; a file cannot be larger */
  /* allocated: end of the space allocated to objects; end: end of the bytes written */
  haddr_t allocated, end;
} pages;

static H5FD_t *pages_open(const char *name, unsigned flags, hid_t access, haddr_t most) {
  (void)name, (void)most;
  const size_t *room = H5Pget_driver_info(access);
  if (!room || !(flags & H5F_ACC_CREAT)) return NULL;
  void *held = memory_hold(); /* HDF5 calls this */
  pages *p = memory_new(1, sizeof *p);
  memory_release(held);
  p->room = *room;
  p->bytes = mmap(NULL, p->room, PROT_READ | PROT_WRITE,
                  MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (p->bytes != MAP_FAILED) return &p->base;
  free(p);
  return NULL;
}

static herr_t pages_close(H5FD_t *file) {
  pages *p = (pages *)file;
  munmap(p->bytes, p->room);
  free(p);
  return 0;
}

static herr_t pages_query(const H5FD_t *file, unsigned long *flags) {
  (void)file;
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

static haddr_t pages_allocated(const H5FD_t *file, H5FD_mem_t type) {
  (void)type;
  return ((const pages *)file)->allocated;
}

static herr_t pages_allocate(H5FD_t *file, H5FD_mem_t type, haddr_t to) {
  (void)type;
  pages *p = (pages *)file;
  if (to > p->room) return -1;
  p->allocated = to;
  return 0;
}

static haddr_t pages_end(const H5FD_t *file, H5FD_mem_t type) {
  (void)type;
  return ((const pages *)file)->end;
}

static herr_t pages_handle(H5FD_t *file, hid_t access, void **handle) {
  (void)access;
  *handle = &((pages *)file)->bytes;
  return 0;
}

/* Returns true if n bytes from offset `at` on are within the file's mapping. */
static bool is_inside(const pages *p, haddr_t at, size_t n) {
  return at <= p->room && n <= p->room - at;
}

/* Reads bytes of the file; pages that were never written read as zeros. */
static herr_t pages_read(H5FD_t *file, H5FD_mem_t type, hid_t transfer, haddr_t at, size_t n,
                         void *data) {
  (void)type, (void)transfer;
  const pages *p = (const pages *)file;
  if (!is_inside(p, at, n)) return -1;
  memcpy(data, p->bytes + at, n);
  return 0;
}

static herr_t pages_write(H5FD_t *file, H5FD_mem_t type, hid_t transfer, haddr_t at, size_t n,
                          const void *data) {
  (void)type, (void)transfer;
  pages *p = (pages *)file;
  if (!is_inside(p, at, n)) return -1;
  memcpy(p->bytes + at, data, n);
  if (at + n > p->end) p->end = at + n;
  return 0;
}

static herr_t pages_truncate(H5FD_t *file, hid_t transfer, hbool_t closing) {
  (void)transfer, (void)closing;
  pages *p = (pages *)file;
  p->end = p->allocated;
  return 0;
}

bool h5_set_pages(hid_t access, size_t room) {
  static const H5FD_class_t driver = {
#if H5_VERSION_GE(1, 13, 0)
    .version = H5FD_CLASS_VERSION,
    .value = (H5FD_class_value_t)512,
#endif
    .name = "pages",
    .maxaddr = INT64_MAX,
    .fc_degree = H5F_CLOSE_WEAK,
    .fapl_size = sizeof room,
    .open = pages_open,
    .close = pages_close,
    .query = pages_query,
    .get_eoa = pages_allocated,
    .set_eoa = pages_allocate,
    .get_eof = pages_end,
    .get_handle = pages_handle,
    .read = pages_read,
    .write = pages_write,
    .truncate = pages_truncate,
    .fl_map = H5FD_FLMAP_DICHOTOMY,
  };
  hid_t id = H5FDregister(&driver);
  /* the property list holds a reference to the driver from here on */
  bool good = id >= 0 && H5Pset_driver(access, id, &room) >= 0;
  if (id >= 0) H5FDunregister(id);
  return good;
}

/* h5_pages.c: a driver of HDF5 for files that stand in pages of memory and have holes: room that the library has given to a
 * dataset and nothing was written to takes no memory. (Its own driver for files in memory fills the whole file.)
 */
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "base/memory.h"
#include "io/store/h5_private.h"
#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>
#endif

typedef struct pages {
  H5FD_t base; /* the library's */
  unsigned char *bytes;
  size_t room;
  haddr_t allocated, end; /* given to objects; written */
} pages;

static H5FD_t *pages_open(const char *name, unsigned flags, hid_t access, haddr_t most) {
  (void)name, (void)most;
  const size_t *room = H5Pget_driver_info(access);
  if (!room || !(flags & H5F_ACC_CREAT)) return NULL;
  pages *p = memory_new(1, sizeof *p);
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

static bool is_inside(const pages *p, haddr_t at, size_t n) {
  return at <= p->room && n <= p->room - at;
}

/* Pages that were never written read as zeros. */
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
  bool good = id >= 0 && H5Pset_driver(access, id, &room) >= 0; /* which keeps it */
  if (id >= 0) H5FDunregister(id);
  return good;
}

/* file_pieces.c: files that are written in one go, from pieces of memory.
 *
 * Long ones go past the kernel's cache of pages (O_DIRECT), where there is such a way: into the cache a copy of 1.7 GB took 3.5 s of
 * processor time and the disk began late. Pieces are gathered in two buffers; while one is on its way to the disk the other is
 * filled and summed.
 */
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/team.h"
#include "io/store/file.h"

enum { BUFFER = 8 << 20, PAGE = 4096, LONG = 4 * BUFFER };

typedef struct gathering {
  const file_piece *pieces;
  size_t n, k, at; /* piece, and byte in it */
} gathering;

static size_t gather(gathering *g, unsigned char *to) {
  size_t have = 0;
  while (g->k < g->n && have < BUFFER) {
    const file_piece *p = &g->pieces[g->k];
    size_t n = p->size - g->at < BUFFER - have ? p->size - g->at : BUFFER - have;
    if (n > 0) memcpy(to + have, (const unsigned char *)p->bytes + g->at, n);
    have += n;
    g->at += n;
    if (g->at < p->size) continue;
    g->k++;
    g->at = 0;
  }
  return have;
}

/* Switches the way past the cache; false: there is none. */
static bool set_direct(int fd, bool on) {
#ifdef O_DIRECT
  int flags = fcntl(fd, F_GETFL);
  return flags >= 0 && fcntl(fd, F_SETFL, on ? flags | O_DIRECT : flags & ~O_DIRECT) == 0;
#else
  (void)fd;
  return !on;
#endif
}

/* Past the cache, or through it where that fails, which also tells errors by their names. Returns 0 or errno. */
static int write_buffer(int fd, const unsigned char *bytes, size_t n, bool *direct) {
  off_t start = lseek(fd, 0, SEEK_CUR);
  if (*direct && n % PAGE == 0 && file_write_all(fd, bytes, n)) return 0;
  if (*direct) {
    *direct = false;
    if (!set_direct(fd, false) || lseek(fd, start, SEEK_SET) != start) return errno;
  }
  return file_write_all(fd, bytes, n) ? 0 : errno;
}

/* One buffer to the disk, the next one from memory. */
typedef struct turn {
  int fd, error;
  bool direct;
  gathering *g;
  unsigned char *full, *empty;
  size_t have, next;
  uint64_t *sum;
} turn;

static void turn_together(const team *t, void *with) {
  turn *f = with;
  if (t->rank == 0) f->error = write_buffer(f->fd, f->full, f->have, &f->direct);
  if (t->rank != t->size - 1) return;
  f->next = gather(f->g, f->empty);
  *f->sum = file_sum(*f->sum, f->empty, f->next);
}

static bool write_long(int fd, gathering *g, unsigned char *buffers, uint64_t *sum) {
  turn f = {.fd = fd,
            .direct = set_direct(fd, true),
            .g = g,
            .full = buffers,
            .empty = buffers + BUFFER,
            .sum = sum};
  pool *two = pool_new(2);
  f.have = gather(g, f.full);
  *sum = file_sum(*sum, f.full, f.have);
  while (f.have > 0 && f.error == 0) {
    pool_run(two, turn_together, &f);
    unsigned char *full = f.empty;
    f.empty = f.full;
    f.full = full;
    f.have = f.next;
  }
  pool_free(two);
  if (f.direct && !set_direct(fd, false) && f.error == 0) f.error = errno;
  errno = f.error;
  return f.error == 0;
}

bool file_write_pieces(int fd, size_t n, const file_piece *pieces, uint64_t *sum) {
  size_t total = 0;
  for (size_t k = 0; k < n; k++) total += pieces[k].size;
  unsigned char *buffers = total >= LONG ? aligned_alloc(PAGE, 2 * (size_t)BUFFER) : NULL;
  bool good = true;
  *sum = FILE_SUM;
  if (buffers) good = write_long(fd, &(gathering){.pieces = pieces, .n = n}, buffers, sum);
  for (size_t k = 0; !buffers && good && k < n; k++) {
    *sum = file_sum(*sum, pieces[k].bytes, pieces[k].size);
    good = file_write_all(fd, pieces[k].bytes, pieces[k].size);
  }
  int error = errno;
  free(buffers);
  errno = error;
  return good;
}

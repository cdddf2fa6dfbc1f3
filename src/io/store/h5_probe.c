/* h5_probe.c: reads files without a checksum in another process first.
 *
 * The HDF5 library crashes with some damaged files. The program slipdisk, started by posix_spawn,
 * opens such a file and reads its contents; only if it says how that ended does this process open
 * the file, too. There is no fork: this process may have threads and ranks.
 */
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <malloc.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/limits.h"
#include "base/memory.h"
#include "base/team.h"
#include "base/text.h"
#include "io/store/file.h"
#include "io/store/h5_private.h"
#include "slipdisk/deck.h"

/* Verdicts of the child process: all can be read; some values cannot be read; some names or shapes
 * cannot be read; the attributes and small datasets have another checksum. CRASHED, SLOW: the child
 * ended without a verdict, or had to be killed. */
enum { GOOD, UNREADABLE, BROKEN, OTHER_SUM, CRASHED, SLOW };

/* PIECE: bytes of a dataset that are read at once. SECONDS: limit of the child's processor time.
 * PATIENCE: of its wall time, both without the time for a long file. MOST: bytes read in all, after
 * which only one box (block of elements) of each dataset is read. */
enum { PIECE = 8 << 20, SECONDS = 60, PATIENCE = 600 };
static const uint64_t MOST = UINT64_C(256) << 20;

/* Progress of the child process that reads the file. */
typedef struct reading {
  bool whole;          /* true if all boxes of all datasets are to be read */
  uint64_t bytes;      /* bytes read so far */
  size_t listed;       /* number of links visited */
  int depth;           /* number of groups above the present one */
  bool failed, broken; /* failed: values cannot be read; broken: names or shapes cannot be read */
} reading;

/* --- Child ------------------------------------------------------------------------------------ */

/* Reads an attribute. Values of variable length are allocated by the library and freed here
 * again. */
static void read_attr(reading *r, hid_t attr) {
  hid_t type = H5Aget_type(attr), space = H5Aget_space(attr);
  const hssize_t n = H5Sget_simple_extent_npoints(space);
  const size_t size = H5Tget_size(type);
  if (n > 0 && size > 0 && (uint64_t)n <= PIECE / size) {
    unsigned char *data = memory_new((size_t)n, size);
    if (H5Aread(attr, type, data) >= 0)
      H5Dvlen_reclaim(type, space, H5P_DEFAULT, data);
    else
      r->failed = true;
    free(data);
  }
  H5Sclose(space);
  H5Tclose(type);
}

/* Called for every attribute of an object: reads it. */
static herr_t take_attr(hid_t object, const char *name, const H5A_info_t *info, void *user) {
  (void)info;
  reading *r = user;
  hid_t attr = H5Aopen(object, name, H5P_DEFAULT);
  r->broken |= attr < 0;
  if (attr < 0) return 0;
  read_attr(r, attr);
  H5Aclose(attr);
  return 0;
}

/* Chooses the sides of the boxes (blocks of elements) in which a dataset is read: its chunks, or
 * pieces of about PIECE bytes. Returns the bytes of a box. */
static size_t choose_box(hid_t set, size_t size, int rank, const hsize_t *dims, hsize_t *box) {
  hid_t made = H5Dget_create_plist(set);
  const bool chunked = H5Pget_layout(made) == H5D_CHUNKED;
  double bytes = (double)size;
  if (chunked) H5Pget_chunk(made, rank, box);
  for (int k = 0; k < rank; k++) {
    if (!chunked || box[k] > dims[k]) box[k] = dims[k];
    bytes *= (double)box[k];
  }
  for (int k = 0; k < rank && !chunked && bytes > PIECE; k++) {
    const double others = bytes / (double)box[k];
    box[k] = others < PIECE ? (hsize_t)(PIECE / others) : 1;
    bytes = others * (double)box[k];
  }
  H5Pclose(made);
  return (size_t)bytes;
}

/* Reads count[k] elements from start[k] on along each dimension k of a dataset; returns false if
 * that fails. */
static bool read_box(hid_t set, hid_t type, hid_t space, int rank, const hsize_t *start,
                     const hsize_t *count, unsigned char *data) {
  hid_t memory = H5Screate_simple(rank, count, NULL);
  const bool good = H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
                    H5Dread(set, type, memory, space, H5P_DEFAULT, data) >= 0;
  if (good) H5Dvlen_reclaim(type, memory, H5P_DEFAULT, data);
  H5Sclose(memory);
  return good;
}

/* Reads a dataset box by box; returns false if that fails. A box smaller than a page of memory
 * counts as a page in r->bytes, since each call takes time. */
static bool read_boxes(reading *r, hid_t set, hid_t type, hid_t space, int rank,
                       const hsize_t *dims, const hsize_t *box, size_t bytes, unsigned char *data) {
  enum { PAGE = 4096 };
  hsize_t at[H5S_MAX_RANK] = {0}, count[H5S_MAX_RANK];
  for (int k = 0; k >= 0;) {
    for (int c = 0; c < rank; c++) count[c] = dims[c] - at[c] < box[c] ? dims[c] - at[c] : box[c];
    if (!read_box(set, type, space, rank, at, count, data)) return false;
    r->bytes += bytes > PAGE ? bytes : PAGE;
    if (!r->whole && r->bytes > MOST) return true;
    for (k = rank - 1; k >= 0 && (at[k] += box[k]) >= dims[k]; k--) at[k] = 0;
  }
  return true;
}

/* Reads the values of a dataset; sets r->failed if that fails. */
static void read_set(reading *r, hid_t set) {
  hid_t type = H5Dget_type(set), space = H5Dget_space(set);
  hsize_t dims[H5S_MAX_RANK] = {0}, box[H5S_MAX_RANK] = {0};
  const int rank = H5Sget_simple_extent_dims(space, dims, NULL);
  const size_t size = H5Tget_size(type),
               bytes = rank > 0 ? choose_box(set, size, rank, dims, box) : size;
  unsigned char *data = NULL;
  if (rank >= 0 && bytes > 0 && bytes <= (size_t)LIMIT_CHUNK * LIMIT_MIB)
    (void)memory_row(&data, bytes, 1); /* without memory the values are not read */
  bool good = true;
  if (data && rank == 0) {
    good = H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0;
    if (good) H5Dvlen_reclaim(type, space, H5P_DEFAULT, data);
  } else if (data && H5Dget_storage_size(set) > 0) {
    good = read_boxes(r, set, type, space, rank, dims, box, bytes, data);
  }
  r->failed |= !good;
  free(data);
  H5Sclose(space);
  H5Tclose(type);
}

/* Called for every link of a group: reads attributes and values of the object. */
static herr_t take_link(hid_t group, const char *name, const H5L_info_t *info, void *user) {
  reading *r = user;
  if (info->type != H5L_TYPE_HARD) return 0;
  if (++r->listed > LIMIT_LINKS || r->depth > LIMIT_GROUPS)
    return 1; /* h5_visit has the same limits of number and depth */
  hid_t object = H5Oopen(group, name, H5P_DEFAULT);
  r->broken |= object < 0;
  if (object < 0) return 0;
  r->broken |= H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, NULL, take_attr, r) < 0;
  r->depth++;
  herr_t result = 0;
  if (H5Iget_type(object) == H5I_GROUP)
    result = H5Literate(object, H5_INDEX_NAME, H5_ITER_INC, NULL, take_link, r);
  else if (H5Iget_type(object) == H5I_DATASET && !h5_set_trouble(object))
    read_set(r, object);
  r->depth--;
  H5Oclose(object);
  return result;
}

/* Reads all attributes and the values of all datasets, or only a limited number of bytes unless
 * `whole` is true; returns one of the verdicts above. */
static int read_all(int fd, const char *path, bool whole) {
  h5_file *file;
  reading r = {.whole = whole};
  if (h5_open_descriptor(fd, path, &file, NULL) != SD_OK) return UNREADABLE;
  r.broken |= H5Aiterate2(file->id, H5_INDEX_NAME, H5_ITER_INC, NULL, take_attr, &r) < 0;
  r.broken |= H5Literate(file->id, H5_INDEX_NAME, H5_ITER_INC, NULL, take_link, &r) < 0;
  h5_close(file, NULL);
  return r.broken ? BROKEN : r.failed ? UNREADABLE : GOOD;
}

/* Compares the checksum of the attributes and small datasets with `small`; returns one of the
 * verdicts above. */
static int compare_small(int fd, const char *path, uint64_t small) {
  h5_file *file;
  uint64_t sum = 0;
  if (h5_open_descriptor(fd, path, &file, NULL) != SD_OK) return UNREADABLE;
  const sd_status status = h5_small_sum(file, &sum, NULL);
  h5_close(file, NULL);
  return status != SD_OK ? UNREADABLE : sum == small ? GOOD : OTHER_SUM;
}

/* Tells the parent and ends the child. */
static int told = -1; /* the child's end of the pipe */
static void leave(int verdict) {
  const char text = (char)('0' + verdict);
  _exit(write(told, &text, 1) == 1 ? SD_OK : SD_ERROR_IO);
}

/* Ends the child if it lacks memory; the parent, which will lack it too, reports that. */
static void leave_without_memory(size_t bytes) {
  (void)bytes;
  leave(UNREADABLE);
}

/* Makes the child silent, without core dump and with a limit of processor time. Allocated memory is
 * filled with bytes other than zero, so that a library that uses memory it has not written crashes
 * here, not later by chance. */
static void be_quiet(uint64_t bytes) {
  told = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  sd_on_no_memory(leave_without_memory);
  mallopt(M_PERTURB, 0xa5);
  const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
  if (nothing >= 0) {
    dup2(nothing, STDOUT_FILENO);
    dup2(nothing, STDERR_FILENO);
  }
  setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
  const rlim_t most = SECONDS + bytes / PIECE;
  setrlimit(RLIMIT_CPU, &(struct rlimit){most, most});
}

void h5_probe_serve(const char *how, const char *small) {
  const char path[] = "the file"; /* no message leaves this process */
  struct stat facts = {0};
  if (fstat(STDIN_FILENO, &facts) != 0 || !S_ISREG(facts.st_mode)) return;
  be_quiet((uint64_t)facts.st_size);
  leave(atoi(how) == H5_PROBE_SMALL ? compare_small(STDIN_FILENO, path, strtoull(small, NULL, 16))
                                    : read_all(STDIN_FILENO, path, atoi(how) == H5_PROBE_WHOLE));
}

/* --- Parent ----------------------------------------------------------------------------------- */

/* Path of the program slipdisk; NULL: no process is started. patience: most seconds that a child
 * may take, without the time for a long file. */
static char *program;
static double patience = PATIENCE;

void sd_set_program(const char *path) {
  free(program);
  program = path ? memory_text(path) : NULL;
}

void h5_probe_patience(double seconds) { patience = seconds; }
bool h5_probes(void) { return program; }

/* Starts the program with the file as its standard input, and the end `out` of a pipe as its
 * standard output. Returns its process id; negative, with errno: that failed. Signals that stop
 * this process do not end the child, which would seem to have crashed. */
static pid_t start(int file, int out, h5_probing how, uint64_t small) {
  char way[8], sum[24];
  snprintf(way, sizeof way, "%d", (int)how);
  snprintf(sum, sizeof sum, "%" PRIx64, small);
  char word[] = H5_PROBE_COMMAND, *words[] = {program, word, way, sum, NULL};
  pid_t child = -1;
  sigset_t all;
  posix_spawn_file_actions_t files;
  posix_spawnattr_t how_to;
  sigfillset(&all);
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, file, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&files, out, STDOUT_FILENO);
  posix_spawnattr_init(&how_to);
  posix_spawnattr_setsigmask(&how_to, &all);
  posix_spawnattr_setflags(&how_to, POSIX_SPAWN_SETSIGMASK);
  errno = posix_spawn(&child, program, &files, &how_to, words, environ);
  posix_spawnattr_destroy(&how_to);
  posix_spawn_file_actions_destroy(&files);
  return errno == 0 ? child : -1;
}

/* Waits for the verdict of a child at the other end of a pipe, at most this long. */
static int listen_to(int pipe, double seconds) {
  const double end = clock_seconds() + seconds;
  struct pollfd one = {.fd = pipe, .events = POLLIN};
  int ready;
  char text = 0;
  do ready = poll(&one, 1, (int)fmin(1000 * fmax(end - clock_seconds(), 0) + 1, 1e9));
  while ((ready < 0 && errno == EINTR) || (ready == 0 && clock_seconds() < end));
  if (ready == 0) return SLOW;
  ssize_t n;
  do n = read(pipe, &text, 1);
  while (n < 0 && errno == EINTR);
  return n == 1 && text >= '0' && text <= '0' + OTHER_SUM ? text - '0' : CRASHED;
}

/* Lets the program read an open file and returns its verdict; negative, with errno: it could not be
 * started. The verdict comes through a pipe, since a host may ignore SIGCHLD or wait for all its
 * children itself. */
static int ask(int fd, h5_probing how, uint64_t small, double seconds) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return -1;
  /* above the numbers that the child gets */
  const int file = fcntl(fd, F_DUPFD_CLOEXEC, STDERR_FILENO + 1),
            out = fcntl(ends[1], F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  const pid_t child = file < 0 || out < 0 ? -1 : start(file, out, how, small);
  int error = errno, how_ended = 0;
  close(ends[1]);
  if (file >= 0) close(file);
  if (out >= 0) close(out);
  int verdict = child < 0 ? -1 : listen_to(ends[0], seconds);
  close(ends[0]);
  if (verdict == SLOW) kill(child, SIGKILL);
  while (child > 0 && waitpid(child, &how_ended, 0) < 0 && errno == EINTR) continue;
  if (verdict == CRASHED && WIFEXITED(how_ended) && WEXITSTATUS(how_ended) != SD_OK) {
    verdict = -1; /* another program, or another version */
    error = ENOEXEC;
  }
  errno = error;
  return verdict;
}

/* Returns true if two results of fstat are of the same file, unchanged. */
static bool is_same(const struct stat *a, const struct stat *b) {
  return a->st_ino == b->st_ino && a->st_dev == b->st_dev && a->st_size == b->st_size &&
         a->st_mtim.tv_sec == b->st_mtim.tv_sec && a->st_mtim.tv_nsec == b->st_mtim.tv_nsec;
}

static sd_status fail(const char *path, const char *what, sd_messages *messages) {
  return sd_fail(messages, SD_ERROR_IO, "%s is damaged%s", path, what);
}

sd_status h5_probe(int fd, const char *path, h5_probing how, uint64_t small,
                   sd_messages *messages) {
  static _Thread_local struct stat sound; /* facts of the last file that was found to be readable */
  struct stat facts;
  if (!program) return SD_OK;
  if (fstat(fd, &facts) != 0) return file_fail(messages, "read", path);
  if (how == H5_PROBE_QUICK && is_same(&facts, &sound)) return SD_OK;
  const double seconds = patience + (double)facts.st_size / PIECE;
  const int verdict = ask(fd, how, small, seconds);
  if (how == H5_PROBE_QUICK && (verdict == GOOD || verdict == UNREADABLE)) {
    sound = facts; /* a value that cannot be read is reported when it is needed */
    return SD_OK;
  }
  switch (verdict) {
    case GOOD: return SD_OK;
    case BROKEN: return fail(path, ": its structure cannot be read", messages);
    case UNREADABLE:
      return fail(path,
                  how == H5_PROBE_SMALL ? ": its small data cannot be read"
                                        : ": its data cannot be read",
                  messages);
    case OTHER_SUM:
      return fail(path,
                  ", or was changed by another program: the sum of its small data does not fit",
                  messages);
    case CRASHED: return fail(path, ": the HDF5 library ends when it reads it", messages);
    case SLOW:
      return sd_fail(messages, SD_ERROR_IO, "%s could not be read within %.0f s", path, seconds);
    default:
      shortage_note();
      return sd_fail(messages, SD_ERROR_IO,
                     "%s has no checksum, and %s, which reads such files first, does not start: %s",
                     path, program, strerror(errno));
  }
}

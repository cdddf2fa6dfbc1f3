/* calls.c: a library to preload (LD_PRELOAD) that lets calls of the C library on files below a folder go wrong.
 *
 *   INJECT_BELOW=FOLDER   files below this absolute path are concerned, no others
 *   INJECT_NAME=PATTERN   of these, only paths like this one (fnmatch, with @(A|B))
 *   INJECT_CALL=KIND,...  which calls are counted: of `any`, below; or writing, or any
 *   INJECT_FROM=program   calls from the program itself, not from its libraries; `library`: the others
 *   INJECT_WHEN=N         the N-th call, in each process, goes wrong,
 *   INJECT_TIMES=K        and those after it, K in all (1); 0: for ever
 *   INJECT_DO=NUMBER      it fails with this errno; or
 *             short       it reads or writes half of what it was asked to; or
 *             kill        the process is killed before it; or
 *             torn        it writes half of what it was asked to, then the process is killed; or
 *             wait        it notes a line in the file INJECT_GATE, and waits until that is gone or a signal was handled
 *   INJECT_BYTES=N        a full disk: what is written beyond N bytes fails with ENOSPC
 *   INJECT_CLOCK=SEED     the program's monotonic clock leaps by up to a second, on each rank at other times: a busy machine
 *   INJECT_LOG=FILE       one line per counted call, "KIND PATH"; with "! " before it when it went wrong
 *
 * A call that closes does close before it fails, as Linux does. Allocations: memory.c. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#undef _FORTIFY_SOURCE /* would define some of these functions itself */
#undef _FILE_OFFSET_BITS
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <fnmatch.h>
#include <limits.h>
#include <link.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#define EXPORT __attribute__((visibility("default")))

/* Kinds of calls; of these `writing` change something on the disk. */
static const char any[] =
    "open,read,pread,write,pwrite,fsync,truncate,allocate,rename,link,unlink,stat,close,mkdir,"
    "rmdir,readdir,lock,mmap";
static const char writing[] =
    "open,write,pwrite,fsync,truncate,allocate,rename,link,unlink,close,mkdir,rmdir,lock";

/* Ends of a call, besides failing with an errno. */
enum { GO_ON = 0, SHORT = -1, TORN = -2, KILL = -3, WAIT = -4 };

static bool ready;
static const char *below, *pattern, *gate, *counted = "";
static long when, times = 1, calls;
static int what;
static long long budget = -1;
static int log_file = -1;
static uint64_t chance; /* of a leap of the clock; 0: none */
static uintptr_t program_begin, program_end;
static bool not_program, not_library;
static _Thread_local const void *caller; /* of the function that is at work */

static int note_program(struct dl_phdr_info *info, size_t size, void *user) {
  (void)size, (void)user;
  for (int k = 0; k < info->dlpi_phnum; k++) {
    const ElfW(Phdr) *p = &info->dlpi_phdr[k];
    if (p->p_type != PT_LOAD || !(p->p_flags & PF_X)) continue;
    program_begin = info->dlpi_addr + p->p_vaddr;
    program_end = program_begin + p->p_memsz;
  }
  return 1; /* the program comes first */
}

static long number(const char *name, long otherwise) {
  const char *text = getenv(name);
  return text ? atol(text) : otherwise;
}

__attribute__((constructor)) static void begin(void) {
  const char *kind = getenv("INJECT_CALL"), *doing = getenv("INJECT_DO"),
             *log = getenv("INJECT_LOG");
  const char *from = getenv("INJECT_FROM");
  not_program = from && strcmp(from, "library") == 0;
  not_library = from && strcmp(from, "program") == 0;
  below = getenv("INJECT_BELOW");
  pattern = getenv("INJECT_NAME");
  gate = getenv("INJECT_GATE");
  const long seed = number("INJECT_CLOCK", 0);
  if (seed > 0) chance = 1000 * (uint64_t)seed + (uint64_t)number("OMPI_COMM_WORLD_RANK", 0) + 1;
  if (kind)
    counted = strcmp(kind, "writing") == 0 ? writing : strcmp(kind, "any") == 0 ? any : kind;
  when = number("INJECT_WHEN", 0);
  times = number("INJECT_TIMES", 1);
  budget = number("INJECT_BYTES", -1);
  if (doing)
    what = strcmp(doing, "short") == 0  ? SHORT
           : strcmp(doing, "torn") == 0 ? TORN
           : strcmp(doing, "kill") == 0 ? KILL
           : strcmp(doing, "wait") == 0 ? WAIT
                                        : atoi(doing);
  if (log)
    log_file =
        (int)syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  dl_iterate_phdr(note_program, NULL);
  ready = below != NULL;
}

static void tell(const char *kind, const char *path, bool wrong) {
  if (log_file < 0) return;
  char line[PATH_MAX + 40];
  int n = snprintf(line, sizeof line, "%s%s %s\n", wrong ? "! " : "", kind, path);
  (void)!syscall(SYS_write, log_file, line, (size_t)n);
}

static void die(void) {
  syscall(SYS_kill, getpid(), SIGKILL);
  for (;;) pause();
}

/* Signals are let in only while it sleeps, so that none is missed. */
static void wait_at_gate(void) {
  const int note =
      gate ? (int)syscall(SYS_openat, AT_FDCWD, gate, O_WRONLY | O_APPEND | O_CLOEXEC) : -1;
  if (note < 0) return;
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  (void)!syscall(SYS_write, note, "\n", 1);
  syscall(SYS_close, note);
  const struct timespec moment = {0, 2000000};
  while (syscall(SYS_faccessat, AT_FDCWD, gate, F_OK) == 0 && ppoll(NULL, 0, &moment, &before) == 0)
    continue;
  pthread_sigmask(SIG_SETMASK, &before, NULL);
}

static bool concerns(const char *path) {
  size_t n = strlen(below);
  if (strncmp(path, below, n) != 0 || (path[n] && path[n] != '/')) return false;
  return !pattern || fnmatch(pattern, path, FNM_EXTMATCH) == 0;
}

static bool is_program(void) {
  return (uintptr_t)caller >= program_begin && (uintptr_t)caller < program_end;
}

/* Is it one of the words between the commas? */
static bool is_among(const char *word, const char *list) {
  size_t n = strlen(word);
  for (const char *at = list; (at = strstr(at, word)); at += n)
    if ((at == list || at[-1] == ',') && (at[n] == ',' || !at[n])) return true;
  return false;
}

/* Counts a call on a file and says what is to become of it. */
static int verdict(const char *kind, const char *path) {
  if (!is_among(kind, counted) || (is_program() ? not_program : not_library)) return GO_ON;
  long n = __atomic_add_fetch(&calls, 1, __ATOMIC_RELAXED);
  bool wrong = when > 0 && what != GO_ON && n >= when && (times == 0 || n < when + times);
  tell(kind, path, wrong);
  if (!wrong) return GO_ON;
  bool writes = is_among(kind, "write,pwrite");
  if (what == WAIT) {
    wait_at_gate();
    return GO_ON;
  }
  if (what == KILL || (what == TORN && !writes)) die();
  if (what == SHORT && !writes && !is_among(kind, "read,pread")) return GO_ON;
  return what;
}

/* The path that a name stands for, beside an open folder. */
static void resolve(int at, const char *name, char *path) {
  char link[64];
  ssize_t n = 0;
  path[0] = 0;
  if (!name) return;
  if (name[0] == '/') {
    snprintf(path, PATH_MAX, "%s", name);
    return;
  }
  if (at == AT_FDCWD)
    snprintf(link, sizeof link, "/proc/self/cwd");
  else
    snprintf(link, sizeof link, "/proc/self/fd/%d", at);
  n = syscall(SYS_readlinkat, AT_FDCWD, link, path, PATH_MAX - 2);
  if (n < 0) n = 0;
  if (name[0]) path[n++] = '/';
  snprintf(path + n, (size_t)(PATH_MAX - n), "%s", name);
}

static int on_path(const char *kind, int at, const char *name) {
  if (!ready) return GO_ON;
  char path[PATH_MAX];
  int before = errno;
  resolve(at, name, path);
  int result = concerns(path) ? verdict(kind, path) : GO_ON;
  errno = before;
  return result;
}

static int on_fd(const char *kind, int fd) { return fd < 0 ? GO_ON : on_path(kind, fd, ""); }

#define REAL(type, name, ...)                                                                      \
  static type (*real)(__VA_ARGS__);                                                                \
  caller = __builtin_return_address(0);                                                            \
  if (!real) *(void **)&real = dlsym(RTLD_NEXT, name)
#define FAIL_ON(decision, failed)                                                                  \
  do {                                                                                             \
    int sd_error = (decision);                                                                     \
    if (sd_error > 0) {                                                                            \
      errno = sd_error;                                                                            \
      return failed;                                                                               \
    }                                                                                              \
  } while (0)

#define MODE_OF(flags)                                                                             \
  mode_t mode = 0;                                                                                 \
  if ((flags) & (O_CREAT | O_TMPFILE)) {                                                           \
    va_list args;                                                                                  \
    va_start(args, flags);                                                                         \
    mode = (mode_t)va_arg(args, int);                                                              \
    va_end(args);                                                                                  \
  }
#define OPENS(name)                                                                                \
  EXPORT int name(const char *path, int flags, ...) {                                              \
    REAL(int, #name, const char *, int, ...);                                                      \
    MODE_OF(flags)                                                                                 \
    FAIL_ON(on_path("open", AT_FDCWD, path), -1);                                                  \
    return real(path, flags, mode);                                                                \
  }
#define OPENS_AT(name)                                                                             \
  EXPORT int name(int at, const char *path, int flags, ...) {                                      \
    REAL(int, #name, int, const char *, int, ...);                                                 \
    MODE_OF(flags)                                                                                 \
    FAIL_ON(on_path("open", at, path), -1);                                                        \
    return real(at, path, flags, mode);                                                            \
  }
#define OPENS_TEMPLATE(name, declared, given)                                                      \
  EXPORT int name declared {                                                                       \
    REAL(int, #name, char *, int, int);                                                            \
    FAIL_ON(on_path("open", AT_FDCWD, path), -1);                                                  \
    return real given;                                                                             \
  }
#define OPENS_STREAM(name)                                                                         \
  EXPORT FILE *name(const char *path, const char *mode) {                                          \
    REAL(FILE *, #name, const char *, const char *);                                               \
    FAIL_ON(on_path("open", AT_FDCWD, path), NULL);                                                \
    return real(path, mode);                                                                       \
  }
OPENS(open)
OPENS(open64)
OPENS_AT(openat)
OPENS_AT(openat64)
OPENS_TEMPLATE(mkstemp, (char *path), (path, 0, 0))
OPENS_TEMPLATE(mkostemp, (char *path, int flags), (path, flags, 0))
OPENS_STREAM(fopen)
OPENS_STREAM(fopen64)

/* Names that a hardened program calls instead. */
int __open_2(const char *path, int flags);
int __openat_2(int at, const char *path, int flags);
EXPORT int __open_2(const char *path, int flags) { return open(path, flags, 0); }
EXPORT int __openat_2(int at, const char *path, int flags) { return openat(at, path, flags, 0); }

EXPORT DIR *opendir(const char *path) {
  REAL(DIR *, "opendir", const char *);
  FAIL_ON(on_path("open", AT_FDCWD, path), NULL);
  return real(path);
}

EXPORT int close(int fd) {
  REAL(int, "close", int);
  int error = on_fd("close", fd), result = real(fd);
  FAIL_ON(error, -1);
  return result;
}

/* How much of it, by the verdict and by what is left of the disk; -1 with errno set: nothing. */
static ssize_t share(const char *kind, int fd, size_t n, bool *dies) {
  int decision = on_fd(kind, fd);
  FAIL_ON(decision, -1);
  *dies = decision == TORN;
  if (decision < 0 && n > 1) n /= 2;
  char path[PATH_MAX];
  if (budget < 0 || !is_among(kind, "write,pwrite")) return (ssize_t)n;
  resolve(fd, "", path);
  if (!concerns(path)) return (ssize_t)n;
  long long left = __atomic_load_n(&budget, __ATOMIC_RELAXED);
  if (left <= 0 && n > 0) {
    errno = ENOSPC;
    return -1;
  }
  if ((long long)n > left) n = (size_t)left;
  __atomic_sub_fetch(&budget, (long long)n, __ATOMIC_RELAXED);
  return (ssize_t)n;
}

#define MOVES(kind, name, call, data)                                                              \
  EXPORT ssize_t name(int fd, data *bytes, size_t n) {                                             \
    REAL(ssize_t, call, int, data *, size_t);                                                      \
    bool dies = false;                                                                             \
    ssize_t m = share(kind, fd, n, &dies);                                                         \
    if (m < 0) return -1;                                                                          \
    ssize_t result = real(fd, bytes, (size_t)m);                                                   \
    if (dies) die();                                                                               \
    return result;                                                                                 \
  }
#define MOVES_AT(kind, name, call, data, offset)                                                   \
  EXPORT ssize_t name(int fd, data *bytes, size_t n, offset at) {                                  \
    REAL(ssize_t, call, int, data *, size_t, offset);                                              \
    bool dies = false;                                                                             \
    ssize_t m = share(kind, fd, n, &dies);                                                         \
    if (m < 0) return -1;                                                                          \
    ssize_t result = real(fd, bytes, (size_t)m, at);                                               \
    if (dies) die();                                                                               \
    return result;                                                                                 \
  }
MOVES("read", read, "read", void)
MOVES("write", write, "write", const void)
MOVES_AT("pread", pread, "pread", void, off_t)
MOVES_AT("pread", pread64, "pread64", void, off64_t)
MOVES_AT("pwrite", pwrite, "pwrite", const void, off_t)
MOVES_AT("pwrite", pwrite64, "pwrite64", const void, off64_t)

ssize_t __read_chk(int fd, void *bytes, size_t n, size_t size);
ssize_t __pread_chk(int fd, void *bytes, size_t n, off_t at, size_t size);
EXPORT ssize_t __read_chk(int fd, void *bytes, size_t n, size_t size) {
  if (n > size) abort();
  return read(fd, bytes, n);
}

EXPORT ssize_t __pread_chk(int fd, void *bytes, size_t n, off_t at, size_t size) {
  if (n > size) abort();
  return pread(fd, bytes, n, at);
}

#define ON_FD(kind, type, name, declared, given, ...)                                              \
  EXPORT type name declared {                                                                      \
    REAL(type, #name, __VA_ARGS__);                                                                \
    FAIL_ON(on_fd(kind, fd), (type)-1);                                                            \
    return real given;                                                                             \
  }
#define ON_PATH(kind, name, declared, given, ...)                                                  \
  EXPORT int name declared {                                                                       \
    REAL(int, #name, __VA_ARGS__);                                                                 \
    FAIL_ON(on_path(kind, AT_FDCWD, path), -1);                                                    \
    return real given;                                                                             \
  }
#define ON_PATH_AT(kind, name, declared, given, ...)                                               \
  EXPORT int name declared {                                                                       \
    REAL(int, #name, __VA_ARGS__);                                                                 \
    FAIL_ON(on_path(kind, at, path), -1);                                                          \
    return real given;                                                                             \
  }
ON_FD("fsync", int, fsync, (int fd), (fd), int)
ON_FD("fsync", int, fdatasync, (int fd), (fd), int)
ON_FD("truncate", int, ftruncate, (int fd, off_t size), (fd, size), int, off_t)
ON_FD("truncate", int, ftruncate64, (int fd, off64_t size), (fd, size), int, off64_t)
ON_FD("allocate", int, fallocate, (int fd, int mode, off_t at, off_t n), (fd, mode, at, n), int,
      int, off_t, off_t)
ON_FD("allocate", int, fallocate64, (int fd, int mode, off64_t at, off64_t n), (fd, mode, at, n),
      int, int, off64_t, off64_t)
ON_FD("lock", int, flock, (int fd, int operation), (fd, operation), int, int)
ON_FD("mmap", void *, mmap, (void *place, size_t n, int protection, int flags, int fd, off_t at),
      (place, n, protection, flags, fd, at), void *, size_t, int, int, int, off_t)
ON_PATH("unlink", unlink, (const char *path), (path), const char *)
ON_PATH_AT("unlink", unlinkat, (int at, const char *path, int flags), (at, path, flags), int,
           const char *, int)
ON_PATH("mkdir", mkdir, (const char *path, mode_t mode), (path, mode), const char *, mode_t)
ON_PATH_AT("mkdir", mkdirat, (int at, const char *path, mode_t mode), (at, path, mode), int,
           const char *, mode_t)
ON_PATH("rmdir", rmdir, (const char *path), (path), const char *)
ON_PATH("stat", access, (const char *path, int mode), (path, mode), const char *, int)
ON_PATH("stat", stat, (const char *path, struct stat *facts), (path, facts), const char *,
        struct stat *)
ON_PATH("stat", lstat, (const char *path, struct stat *facts), (path, facts), const char *,
        struct stat *)
ON_PATH("stat", stat64, (const char *path, struct stat64 *facts), (path, facts), const char *,
        struct stat64 *)
ON_PATH("stat", lstat64, (const char *path, struct stat64 *facts), (path, facts), const char *,
        struct stat64 *)
ON_FD("stat", int, fstat, (int fd, struct stat *facts), (fd, facts), int, struct stat *)
ON_FD("stat", int, fstat64, (int fd, struct stat64 *facts), (fd, facts), int, struct stat64 *)
ON_PATH_AT("stat", fstatat, (int at, const char *path, struct stat *facts, int flags),
           (at, path, facts, flags), int, const char *, struct stat *, int)
ON_PATH_AT("stat", fstatat64, (int at, const char *path, struct stat64 *facts, int flags),
           (at, path, facts, flags), int, const char *, struct stat64 *, int)
ON_PATH_AT("stat", statx, (int at, const char *path, int flags, unsigned mask, struct statx *facts),
           (at, path, flags, mask, facts), int, const char *, int, unsigned, struct statx *)

#define TO_PATH(kind, name, declared, given, folder, ...)                                          \
  EXPORT int name declared {                                                                       \
    REAL(int, #name, __VA_ARGS__);                                                                 \
    FAIL_ON(on_path(kind, folder, path), -1);                                                      \
    return real given;                                                                             \
  }
TO_PATH("rename", rename, (const char *from, const char *path), (from, path), AT_FDCWD,
        const char *, const char *)
TO_PATH("rename", renameat, (int old, const char *from, int at, const char *path),
        (old, from, at, path), at, int, const char *, int, const char *)
TO_PATH("rename", renameat2, (int old, const char *from, int at, const char *path, unsigned flags),
        (old, from, at, path, flags), at, int, const char *, int, const char *, unsigned)
TO_PATH("link", link, (const char *from, const char *path), (from, path), AT_FDCWD, const char *,
        const char *)
TO_PATH("link", linkat, (int old, const char *from, int at, const char *path, int flags),
        (old, from, at, path, flags), at, int, const char *, int, const char *, int)

static double uniform(void) {
  chance = chance * 6364136223846793005u + 1442695040888963407u;
  return (double)(chance >> 11) * 0x1p-53;
}

EXPORT int clock_gettime(clockid_t clock, struct timespec *t) {
  static double late;
  REAL(int, "clock_gettime", clockid_t, struct timespec *);
  const int result = real(clock, t);
  if (chance == 0 || clock != CLOCK_MONOTONIC || !is_program()) return result;
  if (uniform() < 5e-4) late += uniform();
  const double nanoseconds = (double)t->tv_nsec + 1e9 * late;
  t->tv_sec += (time_t)(nanoseconds / 1e9);
  t->tv_nsec = (long)(nanoseconds - 1e9 * (double)(time_t)(nanoseconds / 1e9));
  return result;
}

#define READS_FOLDER(name, entry)                                                                  \
  EXPORT struct entry *name(DIR *folder) {                                                         \
    REAL(struct entry *, #name, DIR *);                                                            \
    FAIL_ON(on_fd("readdir", dirfd(folder)), NULL);                                                \
    return real(folder);                                                                           \
  }
READS_FOLDER(readdir, dirent)
READS_FOLDER(readdir64, dirent64)

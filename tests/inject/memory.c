/* memory.c: a library for LD_PRELOAD that makes allocations of a program fail.
 *
 * Calls of malloc, calloc, realloc, aligned_alloc, memalign, posix_memalign and of mmap without a file are counted from the beginning
 * of main on, in whatever library they are made. SLIPDISK_FAIL_ALLOCATION = n: the n-th fails; with
 * SLIPDISK_FAIL_ALLOCATIONS_ON = 1 all later ones do, too. With SLIPDISK_FAIL_OWN = 1 only
 * calls are counted that the program's own code makes. SLIPDISK_ALLOCATION_LOG = FILE: at the failure FILE gets the place of the
 * call, as LIBRARY+OFFSET for addr2line, else, at the end, the number of calls.
 *
 * A process that has loaded a library calls inject_begin and inject_end around what it tries; then
 * the calls of that library alone are counted.
 */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <link.h>
#include <malloc.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

/* The allocator of glibc, which can be called before anything is looked up. */
extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t n, size_t size);
extern void *__libc_realloc(void *old, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);

static bool counting, keep_failing, own;
static uintptr_t first, last; /* addresses of the program */
static long fail_at;
static const char *log_name;
static atomic_long calls;

static void note(const char *text) {
  int file = log_name ? open(log_name, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666) : -1;
  if (file < 0) return;
  if (write(file, text, strlen(text)) < 0) errno = EIO;
  close(file);
}

static bool fails(const void *caller) {
  if (!counting || (own && ((uintptr_t)caller < first || (uintptr_t)caller >= last))) return false;
  long n = atomic_fetch_add(&calls, 1) + 1;
  if (n == fail_at) {
    counting = false; /* finding the name may allocate */
    Dl_info where = {0};
    char text[4096] = "unknown";
    if (dladdr(caller, &where) && where.dli_fname)
      snprintf(text, sizeof text, "%s+0x%zx", where.dli_fname,
               (size_t)((const char *)caller - (const char *)where.dli_fbase));
    note(text);
    counting = true;
  }
  if (fail_at > 0 && (n == fail_at || (keep_failing && n > fail_at))) {
    errno = ENOMEM;
    return true;
  }
  return false;
}

void *malloc(size_t size) {
  return fails(__builtin_return_address(0)) ? NULL : __libc_malloc(size);
}

void *calloc(size_t n, size_t size) {
  return fails(__builtin_return_address(0)) ? NULL : __libc_calloc(n, size);
}

void *realloc(void *old, size_t size) {
  return fails(__builtin_return_address(0)) ? NULL : __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size) {
  return fails(__builtin_return_address(0)) ? NULL : __libc_memalign(alignment, size);
}

void *memalign(size_t alignment, size_t size) {
  return fails(__builtin_return_address(0)) ? NULL : __libc_memalign(alignment, size);
}

int posix_memalign(void **out, size_t alignment, size_t size) {
  if (fails(__builtin_return_address(0))) return ENOMEM;
  void *memory = __libc_memalign(alignment, size);
  if (!memory) return ENOMEM;
  *out = memory;
  return 0;
}

void *mmap(void *address, size_t length, int protection, int flags, int file, off_t offset) {
  if ((flags & MAP_ANONYMOUS) && fails(__builtin_return_address(0))) return MAP_FAILED;
  return (void *)syscall(SYS_mmap, address, length, protection, flags, file, offset);
}

static void tell_calls(void) {
  char text[32];
  counting = false;
  if (fail_at > 0 && atomic_load(&calls) >= fail_at) return;
  snprintf(text, sizeof text, "%ld", atomic_load(&calls));
  note(text);
}

/* Finds the program, which comes first in the list, or the library with the address `inside`. */
static int find_program(struct dl_phdr_info *info, size_t size, void *inside) {
  (void)size;
  first = UINTPTR_MAX;
  last = 0;
  for (int k = 0; k < info->dlpi_phnum; k++) {
    if (info->dlpi_phdr[k].p_type != PT_LOAD) continue;
    uintptr_t begin = info->dlpi_addr + info->dlpi_phdr[k].p_vaddr,
              end = begin + info->dlpi_phdr[k].p_memsz;
    first = begin < first ? begin : first;
    last = end > last ? end : last;
  }
  return !inside || ((uintptr_t)inside >= first && (uintptr_t)inside < last);
}

void inject_begin(void *inside, long at, int on);
long inject_end(void);

/* Lets the call number `at` fail, of those that the library with the address `inside` makes from now
 * on; on: all later ones, too. */
void inject_begin(void *inside, long at, int on) {
  counting = false;
  dl_iterate_phdr(find_program, inside);
  fail_at = at;
  keep_failing = on;
  own = true;
  atomic_store(&calls, 0);
  counting = true;
}

/* Returns how many calls were made since inject_begin. */
long inject_end(void) {
  counting = false;
  return atomic_load(&calls);
}

static int (*program_main)(int, char **, char **);

static int counted_main(int argc, char **argv, char **environment) {
  const char *at = getenv("SLIPDISK_FAIL_ALLOCATION");
  fail_at = at ? strtol(at, NULL, 10) : 0;
  keep_failing = getenv("SLIPDISK_FAIL_ALLOCATIONS_ON");
  log_name = getenv("SLIPDISK_ALLOCATION_LOG");
  own = getenv("SLIPDISK_FAIL_OWN");
  dl_iterate_phdr(find_program, NULL);
  atexit(tell_calls);
  counting = true;
  return program_main(argc, argv, environment);
}

int __libc_start_main(int (*main)(int, char **, char **), int argc, char **argv, void (*init)(void),
                      void (*fini)(void), void (*loader_fini)(void), void *stack);

/* The loader's and the libraries' own beginnings are over when this is called. */
int __libc_start_main(int (*main)(int, char **, char **), int argc, char **argv, void (*init)(void),
                      void (*fini)(void), void (*loader_fini)(void), void *stack) {
  int (*real)(int (*)(int, char **, char **), int, char **, void (*)(void), void (*)(void),
              void (*)(void), void *);
  *(void **)&real = dlsym(RTLD_NEXT, "__libc_start_main");
  program_main = main;
  return real(counted_main, argc, argv, init, fini, loader_fini, stack);
}

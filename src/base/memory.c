/* memory.c: implements memory.h. */
#include "base/memory.h"

#include <assert.h>
#include <limits.h>
#include <math.h>
#include <setjmp.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/sysinfo.h>
#endif

#include "base/math.h"
#include "slipdisk/status.h"

/* Size in bytes from which an allocation is compared with the available memory. */
static const double LARGE = 1 << 26;

static _Atomic(sd_memory_handler *) handler;
static atomic_flag called = ATOMIC_FLAG_INIT;

void sd_on_no_memory(sd_memory_handler *call) { atomic_store(&handler, call); }

static _Thread_local jmp_buf *escape; /* of the innermost memory_try of this thread; NULL: none */

bool memory_try(void (*make)(void *task), void *task) {
  jmp_buf here, *outer = escape;
  escape = &here;
  if (setjmp(here) == 0) {
    make(task);
    escape = outer;
    return true;
  }
  escape = outer;
  return false;
}

void *memory_hold(void) {
  jmp_buf *held = escape;
  escape = NULL;
  return held;
}

void memory_release(void *held) { escape = held; }

/* Leaves memory_try, or calls the out-of-memory handler, or prints a message, and ends the process.
 * Other threads that run out of memory meanwhile wait here until the process ends. */
_Noreturn void memory_lacks(size_t bytes) {
  if (escape) longjmp(*escape, 1);
  while (atomic_flag_test_and_set(&called)) pause();
  sd_memory_handler *call = atomic_load(&handler);
  if (call) call(bytes);
  static const char text[] = "slipdisk: no memory\n";
  ssize_t told = write(STDERR_FILENO, text, sizeof text - 1);
  (void)told; /* If write() fails too, there is no way left to report it. */
  abort();
}

/* Reallocates `old` to n elements, at least one byte. Returns NULL if memory runs out or the size
 * exceeds PTRDIFF_MAX. */
static void *resized(void *old, size_t n, size_t size) {
  if (n > PTRDIFF_MAX / (size > 0 ? size : 1)) return NULL;
  return realloc(old, n * size > 0 ? n * size : 1);
}

void *memory_new(size_t n, size_t size) {
  void *made = calloc(n > 0 ? n : 1, size > 0 ? size : 1);
  if (!made) memory_lacks(n * size);
  return made;
}

void *memory_lines(size_t bytes) {
  const size_t line = 64, whole = (bytes + line - 1) / line * line;
  void *made = aligned_alloc(line, whole > 0 ? whole : line);
  if (!made) memory_lacks(bytes);
  return memset(made, 0, whole);
}

void *memory_grow(void *old, size_t n, size_t size) {
  void *made = resized(old, n, size);
  if (!made) memory_lacks(n * size);
  return made;
}

void *memory_copy(const void *from, size_t bytes) {
  if (!from) return NULL;
  void *made = malloc(bytes > 0 ? bytes : 1);
  if (!made) memory_lacks(bytes);
  return memcpy(made, from, bytes);
}

char *memory_text(const char *text) { return memory_copy(text, text ? strlen(text) + 1 : 0); }

/* --- limits of the machine and of control groups ---------------------------------------------- */

/* Returns the number in a file of a Linux control group; HUGE_VAL if there is no such file or it
 * holds "max". */
static double group_number(const char *root, const char *folder, const char *name) {
  char path[PATH_MAX + 80];
  double number = HUGE_VAL;
  snprintf(path, sizeof path, "%s%s/%s", root, folder, name);
  FILE *file = fopen(path, "r");
  if (!file) return HUGE_VAL;
  if (fscanf(file, "%lf", &number) != 1) number = HUGE_VAL;
  fclose(file);
  return number;
}

/* Returns how many bytes of memory and swap space together one Linux control group may use. Version
 * 1 of control groups also limits the sum of both. */
static double group_limit(bool first_version, const char *folder, double swap) {
  static const char root[] = "/sys/fs/cgroup", old_root[] = "/sys/fs/cgroup/memory";
  if (!first_version)
    return group_number(root, folder, "memory.max") +
           math_min(swap, group_number(root, folder, "memory.swap.max"));
  return math_min(group_number(old_root, folder, "memory.limit_in_bytes") + swap,
                  group_number(old_root, folder, "memory.memsw.limit_in_bytes"));
}

/* Returns the smallest memory limit of a control group and of all groups above it. In a container
 * the paths may not exist; then only the limit at the root counts, which is the container's own. */
static double groups_limit(bool first_version, char *folder, double swap) {
  double least = HUGE_VAL;
  for (;;) {
    least = math_min(least, group_limit(first_version, folder, swap));
    char *slash = strrchr(folder, '/');
    if (!slash) return least;
    *slash = 0;
  }
}

/* Returns the smallest memory limit of all control groups of this process. Lines of
 * /proc/self/cgroup are "number:controllers:path", in version 2 "0::path". */
static double control_groups_limit(double swap) {
  char line[PATH_MAX];
  double least = HUGE_VAL;
  FILE *file = fopen("/proc/self/cgroup", "r");
  while (file && fgets(line, sizeof line, file)) {
    char *controllers = strchr(line, ':'),
         *path = controllers ? strchr(controllers + 1, ':') : NULL;
    if (!path) continue;
    *path++ = 0;
    path[strcspn(path, "\n")] = 0;
    const bool second = strcmp(line, "0:") == 0, first = strstr(controllers, ":memory") != NULL;
    if (first || second) least = math_min(least, groups_limit(first, path, swap));
  }
  if (file) fclose(file);
  return least;
}

static double resource_limit(int resource) {
  struct rlimit most;
  return getrlimit(resource, &most) == 0 && most.rlim_cur != RLIM_INFINITY ? (double)most.rlim_cur
                                                                           : HUGE_VAL;
}

double memory_limit(size_t processes) {
  double shared = (double)PTRDIFF_MAX, swap = 0;
#ifdef __linux__
  struct sysinfo machine;
  if (sysinfo(&machine) == 0) {
    swap = (double)machine.totalswap * machine.mem_unit;
    shared = (double)machine.totalram * machine.mem_unit + swap;
  }
#endif
  shared = math_min(shared, control_groups_limit(swap));
  return math_min(shared / (double)processes,
                  math_min(resource_limit(RLIMIT_AS), resource_limit(RLIMIT_DATA)));
}

/* True if this many bytes fit into memory. The check is needed because Linux overcommits: it grants
 * memory that it does not have, and kills the process that writes to it. */
bool memory_fits(double bytes) { return bytes < LARGE || bytes <= memory_limit(1); }

/* --- arrays with a row per element ------------------------------------------------------------ */

static double bytes_of(size_t n_columns, const memory_column *columns) {
  double bytes = 0;
  for (size_t k = 0; k < n_columns; k++) bytes += (double)columns[k].n * (double)columns[k].size;
  return bytes;
}

bool memory_rows(size_t n_columns, const memory_column *columns) {
  bool enough = memory_fits(bytes_of(n_columns, columns));
  for (size_t k = 0; k < n_columns; k++) {
    const memory_column *c = &columns[k];
    void *made = enough ? calloc(c->n > 0 ? c->n : 1, c->size) : NULL;
    enough = made != NULL;
    memcpy(c->at, &made, sizeof made);
  }
  for (size_t k = 0; k < n_columns && !enough; k++) {
    void *made;
    memcpy(&made, columns[k].at, sizeof made);
    free(made);
    memcpy(columns[k].at, &(void *){NULL}, sizeof made);
  }
  return enough;
}

bool memory_resize(size_t n_columns, const memory_column *columns) {
  /* Half the size is checked: a caller that doubles an array may need only half of the new size. */
  if (!memory_fits(bytes_of(n_columns, columns) / 2)) return false;
  for (size_t k = 0; k < n_columns; k++) {
    void *old;
    memcpy(&old, columns[k].at, sizeof old);
    void *made = resized(old, columns[k].n, columns[k].size);
    if (!made) return false;
    memcpy(columns[k].at, &made, sizeof made);
  }
  return true;
}

bool memory_row(void *at, size_t n, size_t size) {
  return memory_rows(1, &(memory_column){at, n, size});
}

bool memory_resize_row(void *at, size_t n, size_t size) {
  return memory_resize(1, &(memory_column){at, n, size});
}

static atomic_bool seen;

void shortage_note(void) { atomic_store_explicit(&seen, true, memory_order_relaxed); }
bool shortage_seen(void) { return atomic_load_explicit(&seen, memory_order_relaxed); }

enum {
  LINE = 64,
  PAGE = 4096,
  APART = 3 * LINE,
  LARGE_PAGE = 1 << 21,
  LARGE_ARENA = 2 * LARGE_PAGE
};

/* Header in the cache line just before an arena. The arena itself begins at a multiple of 64
 * bytes. */
typedef struct header {
  void *memory;
  /* size of the mapping, needed for munmap; 0: the arena was allocated with aligned_alloc */
  size_t bytes;
} header;

size_t arena_column(arena_plan *plan, size_t bytes) {
  size_t at = (plan->end + LINE - 1) / LINE * LINE, apart = plan->columns++ * APART % PAGE;
  /* Columns smaller than a page are not shifted, since they fit into the cache together. */
  if (bytes >= PAGE) at += (apart + PAGE - at % PAGE) % PAGE;
  assert(at % LINE == 0 && at >= plan->end);
  plan->end = at + bytes + LINE;
  return at;
}

static void *new_large(size_t bytes) {
  bytes += LINE + LARGE_PAGE;
  char *memory = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return NULL;
  char *room = memory + LINE + (LARGE_PAGE - ((uintptr_t)memory + LINE) % LARGE_PAGE) % LARGE_PAGE;
  /* madvise is only a hint; without huge pages it has no effect. */
  madvise(room, bytes - (size_t)(room - memory), MADV_HUGEPAGE);
  assert(room - memory >= LINE && (uintptr_t)room % LINE == 0);
  ((header *)(void *)(room - LINE))[0] = (header){memory, bytes};
  return room;
}

void *arena_new(const arena_plan *plan) {
  if (plan->end >= LARGE_ARENA) return new_large(plan->end);
  size_t bytes = (plan->end + 2 * LINE - 1) / LINE * LINE;
  char *memory = aligned_alloc(LINE, bytes);
  if (!memory) return NULL;
  memset(memory, 0, bytes);
  ((header *)(void *)memory)[0] = (header){memory, 0};
  return memory + LINE;
}

void arena_free(void *room) {
  if (!room) return;
  const header h = ((header *)(void *)((char *)room - LINE))[0];
  if (h.bytes)
    munmap(h.memory, h.bytes);
  else
    free(h.memory);
}

void *arena_for(size_t n, size_t size) {
  arena_plan plan = {0};
  if (!memory_fits((double)n * (double)size)) return NULL;
  arena_column(&plan, n * size);
  return arena_new(&plan);
}

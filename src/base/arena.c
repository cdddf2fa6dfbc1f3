/* arena.c: see arena.h. */
#include "base/arena.h"

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "base/memory.h"

enum { LINE = 64, PAGE = 4096, APART = 3 * LINE, LARGE_PAGE = 1 << 21, LARGE = 2 * LARGE_PAGE };

/* Stands before the room, whose start is on a line. */
typedef struct header {
  void *memory;
  size_t bytes; /* 0: not mapped */
} header;

size_t arena_column(arena_plan *plan, size_t bytes) {
  size_t at = (plan->end + LINE - 1) / LINE * LINE, apart = plan->columns++ * APART % PAGE;
  /* small ones fit into the cache together */
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
  madvise(room, bytes - (size_t)(room - memory), MADV_HUGEPAGE); /* if there are any */
  assert(room - memory >= LINE && (uintptr_t)room % LINE == 0);
  ((header *)(void *)(room - LINE))[0] = (header){memory, bytes};
  return room;
}

void *arena_new(const arena_plan *plan) {
  if (plan->end >= LARGE) return new_large(plan->end);
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

/* arena.h: memory for columns of numbers that loops read side by side.
 *
 * Columns of one room stand apart by other than whole pages: else the same row of all of them competes for the same few
 * places of the cache. Large rooms ask for large pages, and are zero without having been written, so that each page comes
 * to stand near the thread that writes it first.
 */
#ifndef BASE_ARENA_H
#define BASE_ARENA_H

#include <stddef.h>

/* Begin with {0}. */
typedef struct arena_plan {
  size_t end;
  size_t columns;
} arena_plan;

/* Where in the room another column of so many bytes stands: at a multiple of 64, with 64 bytes to spare. */
size_t arena_column(arena_plan *plan, size_t bytes);
/* Zeroed; NULL without memory. */
void *arena_new(const arena_plan *plan);
void arena_free(void *room);
/* A room for one column, which begins at its start; NULL without memory. */
void *arena_for(size_t n, size_t size);

#endif

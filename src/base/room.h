/* room.h: memory for columns of numbers that loops read side by side.
 *
 * Columns of one room stand apart by other than whole pages: else the same row of all of them competes for the same few
 * places of the cache. Large rooms ask for large pages, and are zero without having been written, so that each page comes
 * to stand near the thread that writes it first.
 */
#ifndef BASE_ROOM_H
#define BASE_ROOM_H

#include <stddef.h>

/* Begin with {0}. */
typedef struct room_plan {
  size_t end;
  size_t columns;
} room_plan;

/* Where in the room another column of so many bytes stands: at a multiple of 64, with 64 bytes to spare. */
size_t room_column(room_plan *plan, size_t bytes);
/* Zeroed; NULL without memory. */
void *room_new(const room_plan *plan);
void room_free(void *room);
/* A room for one column, which begins at its start; NULL without memory. */
void *room_for(size_t n, size_t size);

#endif

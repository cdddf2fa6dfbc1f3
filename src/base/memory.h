/* memory.h: small things, for which there is always memory; rows, for which there may be none; arenas
 * for columns.
 *
 * Texts, structs, lists of messages, tables with a row per law, motion, key or rank are small:
 * memory_new and its like never return NULL. Without memory they call the handler that
 * sd_on_no_memory has set, once, and do not return.
 *
 * Arrays with a row per disk, contact, pair, or row of output follow the size of the system.
 * memory_rows and memory_resize say whether there is memory, and their callers return
 * SD_ERROR_IO.
 */
#ifndef SLIPDISK_BASE_MEMORY_H
#define SLIPDISK_BASE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

/* n elements of so many bytes, all zero. Never NULL, also with n = 0. Free with free(). */
void *memory_new(size_t n, size_t size);
/* The block `old` (or NULL) with room for n elements; what is new is not set. Never NULL. Free
 * with free(). */
void *memory_grow(void *old, size_t n, size_t size);
/* So many bytes, all zero, that begin at a multiple of 64: a cache line. Never NULL. Free with
 * free(). */
void *memory_lines(size_t bytes);
/* Copies of so many bytes, and of a text; a copy of NULL is NULL. Free with free(). */
void *memory_copy(const void *from, size_t bytes);
char *memory_text(const char *text);
/* Calls the handler: for functions of libraries that return NULL without memory. */
_Noreturn void memory_lacks(size_t bytes);

/* One array: the pointer that is set, the number of its elements, the bytes of one. */
typedef struct memory_column {
  void *at; /* the address of the pointer */
  size_t n, size;
} memory_column;

/* Bytes that each of so many processes side by side can have at all, whatever others use: its
 * share of the machine's memory and swap space, or of what control groups allow (versions 1 and
 * 2, all levels), and no more than the limits of its address space and data (ulimit -v, -d). */
double memory_limit(size_t processes);
/* False: more bytes than one process can have. Less than 64 MiB are not compared. */
bool memory_fits(double bytes);

/* Sets the pointers of n_columns arrays to zeroed memory; none is NULL then, also with n = 0.
 * False: there is not enough memory, or together they do not fit (memory_fits), and all of
 * them are NULL. Free each with free(). */
bool memory_rows(size_t n_columns, const memory_column *columns);
/* Changes the arrays to n elements each and keeps the elements that both have; what is new is not
 * set. False: there is not enough memory; each pointer still has at least the elements that it
 * had, if n is not below. The half of it is compared with memory_fits. */
bool memory_resize(size_t n_columns, const memory_column *columns);
/* The same for one array; at: the address of the pointer. */
bool memory_row(void *at, size_t n, size_t size);
bool memory_resize_row(void *at, size_t n, size_t size);

/* Has an allocation failed where no caller could be told?
 *
 * Functions that return numbers or texts have no status: without memory they return NAN, NULL, or what stands for "not
 * there". Libraries do likewise. They note it here, and who reports or decides by what they returned asks.
 */

void shortage_note(void);
bool shortage_seen(void); /* since the process began */

/* Memory for columns of numbers that loops read side by side.
 *
 * Columns of one room stand apart by other than whole pages: else the same row of all of them competes for the same few
 * places of the cache. Large rooms ask for large pages, and are zero without having been written, so that each page comes
 * to stand near the thread that writes it first.
 */

/* Begin with {0}. */
typedef struct arena_plan {
  size_t end;
  size_t columns;
} arena_plan;

/* Offset in the arena of another column of so many bytes: a multiple of 64, with 64 bytes to
 * spare. */
size_t arena_column(arena_plan *plan, size_t bytes);
/* Zeroed; NULL without memory. */
void *arena_new(const arena_plan *plan);
void arena_free(void *room);
/* A room for one column, which begins at its start; NULL without memory. */
void *arena_for(size_t n, size_t size);

#endif

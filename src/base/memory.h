/* memory.h: allocation of small objects, which never fails; of arrays with many rows, which may
 * fail; and of arenas, blocks of several columns.
 *
 * Texts, structs, lists of messages, and tables with a row per law, motion, key or rank are small:
 * memory_new and its like never return NULL. If memory runs out they call, once, the handler that
 * sd_on_no_memory has set, and do not return; within memory_try they leave it.
 *
 * Arrays with a row per disk, contact, pair, or row of output grow with the size of the system.
 * memory_rows and memory_resize return whether there is enough memory; their callers return
 * SD_ERROR_IO if there is not.
 */
#ifndef SLIPDISK_BASE_MEMORY_H
#define SLIPDISK_BASE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

/* Returns n elements of `size` bytes each, all zero. Never NULL, not even for n = 0. Free with
 * free(). */
void *memory_new(size_t n, size_t size);
/* Resizes the block `old` (or NULL) to n elements; new elements are not initialised. Never NULL.
 * Free with free(). */
void *memory_grow(void *old, size_t n, size_t size);
/* Returns `bytes` bytes, all zero, at a multiple of 64 (a cache line). Never NULL. Free with
 * free(). */
void *memory_lines(size_t bytes);
/* memory_copy returns a copy of `bytes` bytes, memory_text a copy of a text; the copy of NULL is
 * NULL. Free with free(). */
void *memory_copy(const void *from, size_t bytes);
char *memory_text(const char *text);
/* Calls the out-of-memory handler and does not return. To be called where a library function
 * returns NULL because memory ran out. bytes: size of the failed allocation. */
_Noreturn void memory_lacks(size_t bytes);

/* Calls make(task) and returns true. If memory for a small object runs out in it, in this thread,
 * no handler is called: make is left by longjmp, what it had made is lost but not freed, and false
 * is returned. For functions that only make something new, change nothing that exists, and call no
 * function of the user. */
bool memory_try(void (*make)(void *task), void *task);
/* memory_hold lets this thread call the handler also within memory_try, until memory_release gets
 * its result: for functions that another library calls back, which longjmp must not leave. */
void *memory_hold(void);
void memory_release(void *held);

/* Description of one array to be allocated: its pointer, the number of its elements, and the bytes
 * of one element. */
typedef struct memory_column {
  void *at; /* address of the pointer variable that is set */
  size_t n, size;
} memory_column;

/* Returns how many bytes each of `processes` concurrent processes can have at most, whatever other
 * programs use: its equal part of the machine's memory and swap space, or of what Linux control
 * groups allow (versions 1 and 2, all levels), and no more than the process's own limits of address
 * space and data (ulimit -v, -d). */
double memory_limit(size_t processes);
/* Returns false if `bytes` is more memory than this process alone can have. Sizes below 64 MiB are
 * not checked. */
bool memory_fits(double bytes);

/* Allocates n_columns arrays, zeroed, and sets the pointers to them; no pointer is NULL then, not
 * even for n = 0. Returns false if memory runs out or all arrays together do not fit (memory_fits);
 * all pointers are NULL then. Free each array with free(). */
bool memory_rows(size_t n_columns, const memory_column *columns);
/* Resizes each array to its new number of elements n and keeps the old elements; new ones are not
 * initialised. Returns false if memory runs out; each array then still has its old elements, unless
 * n is smaller. Checks half of the total size with memory_fits. */
bool memory_resize(size_t n_columns, const memory_column *columns);
/* memory_row and memory_resize_row do for one array what memory_rows and memory_resize do for
 * several. at: address of the pointer to the array. */
bool memory_row(void *at, size_t n, size_t size);
bool memory_resize_row(void *at, size_t n, size_t size);

/* Record that memory ran out in a function without a status.
 *
 * Functions that return numbers or texts cannot report a status: if memory runs out they return
 * NAN, NULL, or the value that stands for "not there", as library functions do, and call
 * shortage_note. Callers that report such results, or decide by them, ask shortage_seen.
 */

void shortage_note(void);
/* Returns true if shortage_note has been called since the process began. */
bool shortage_seen(void);

/* Arenas: single blocks of memory for several columns of numbers that loops read side by side.
 *
 * Columns of one arena do not start at equal offsets within a page; otherwise the same row of all
 * columns would compete for the same few lines of the cache. Large arenas ask for huge pages, and
 * rely on the operating system for zeroed memory instead of writing zeros, so that each page is
 * placed near the thread that writes it first.
 */

/* Layout of an arena that is being planned. Initialise it with {0}. */
typedef struct arena_plan {
  size_t end;
  size_t columns;
} arena_plan;

/* Adds a column of `bytes` bytes to the plan of an arena. Returns its offset in the arena, a
 * multiple of 64; at least 64 more bytes follow the column. */
size_t arena_column(arena_plan *plan, size_t bytes);
/* Allocates an arena as planned, zeroed; returns NULL if memory runs out. Free it with
 * arena_free. */
void *arena_new(const arena_plan *plan);
void arena_free(void *room);
/* Allocates a zeroed arena with a single column of n elements of `size` bytes, which starts at the
 * returned address; returns NULL if memory runs out. Free it with arena_free. */
void *arena_for(size_t n, size_t size);

#endif

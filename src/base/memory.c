/* memory.c: see memory.h. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include "base/memory.h"

#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "slipdisk/status.h"

static _Atomic(sd_memory_handler *) handler;
static atomic_flag called = ATOMIC_FLAG_INIT;

void sd_on_no_memory(sd_memory_handler *call) { atomic_store(&handler, call); }

/* Threads that lack memory while another one is in the handler wait for the end of the process. */
_Noreturn void memory_lacks(size_t bytes) {
  while (atomic_flag_test_and_set(&called)) pause();
  sd_memory_handler *call = atomic_load(&handler);
  if (call) call(bytes);
  static const char text[] = "slipdisk: no memory\n";
  ssize_t told = write(STDERR_FILENO, text, sizeof text - 1);
  (void)told; /* there is no other way to tell it */
  abort();
}

/* Room for n elements, at least one byte; NULL: there is none, or more bytes than an address can
 * count. */
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

bool memory_rows(size_t n_columns, const memory_column *columns) {
  bool enough = true;
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
  for (size_t k = 0; k < n_columns; k++) {
    void *old;
    memcpy(&old, columns[k].at, sizeof old);
    void *made = resized(old, columns[k].n, columns[k].size);
    if (!made) return false;
    memcpy(columns[k].at, &made, sizeof made);
  }
  return true;
}

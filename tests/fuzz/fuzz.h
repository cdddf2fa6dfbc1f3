/* fuzz.h: what the harnesses share. Each is a libFuzzer program:
 *   cmake --preset fuzz && cmake --build --preset fuzz
 *   build/fuzz/tests/fuzz/fuzz_deck tests/fuzz/corpus/deck
 * tools/soak/fuzz.py runs all of them. A crash, a leak, a time or a memory beyond the limits is a finding.
 */
#ifndef TESTS_FUZZ_H
#define TESTS_FUZZ_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <assert.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "slipdisk/deck.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* libconfig 1.5 loses the text that it was reading at a syntax error. */
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libconfig\n"; }

/* A file in the current folder with these bytes; its name. */
static inline const char *fuzz_file(const void *data, size_t size) {
  static char path[40];
  snprintf(path, sizeof path, "fuzz-%ld.tmp", (long)getpid());
  FILE *out = fopen(path, "wb");
  bool good = out && fwrite(data, 1, size, out) == size && fclose(out) == 0;
  assert(good);
  return path;
}

/* Reads a deck; a model exactly where nothing was wrong. */
static inline sd_model *fuzz_load(const char *text, size_t n, const char *const *overrides) {
  sd_messages *messages = sd_messages_new();
  sd_model *m = NULL;
  sd_status status = sd_deck_load_text(text, "fuzz.cfg", n, overrides, &m, messages);
  assert((status == SD_OK) == (m != NULL));
  assert((status == SD_OK) == (sd_messages_errors(messages) == 0));
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    for (const char *c = sd_messages_text(messages, k); *c; c++)
      assert((unsigned char)*c >= 0x20 && *c != 0x7f);
  sd_messages_free(messages);
  return m;
}

static inline char *fuzz_text(const uint8_t *data, size_t size) {
  char *text = malloc(size + 1);
  assert(text);
  memcpy(text, data, size);
  text[size] = 0;
  return text;
}

#endif

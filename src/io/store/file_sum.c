/* file_sum.c: checksums of files, as `xxhsum -H3` computes them; see file.h. The library's header
 * alone is compiled in. */
#include <stdlib.h>

#define XXH_INLINE_ALL
#include <xxhash.h>
#if XXH_VERSION_NUMBER < 800
#error "XXH3 needs xxhash 0.8 or newer"
#endif

#include "base/memory.h"
#include "io/store/file.h"

struct file_digest {
  XXH3_state_t state;
};

uint64_t file_sum(const void *bytes, size_t n) { return XXH3_64bits(bytes, n); }

file_digest *file_digest_new(void) {
  file_digest *d = memory_lines(sizeof *d); /* aligned as the library demands it */
  XXH3_64bits_reset(&d->state);
  return d;
}

void file_digest_add(file_digest *d, const void *bytes, size_t n) {
  XXH3_64bits_update(&d->state, bytes, n);
}

uint64_t file_digest_sum(const file_digest *d) { return XXH3_64bits_digest(&d->state); }

void file_digest_free(file_digest *d) { free(d); }

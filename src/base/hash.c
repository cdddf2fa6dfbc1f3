#include "base/hash.h"

#include <string.h>

uint64_t hash_words(uint64_t hash, const void *bytes, size_t n) {
  const unsigned char *b = bytes;
  const uint64_t prime = UINT64_C(1099511628211);
  for (; n >= 8; b += 8, n -= 8) {
    uint64_t word;
    memcpy(&word, b, 8);
    /* the shift lets high bits change low ones, which a multiplication alone never does */
    hash = (hash ^ word) * prime;
    hash ^= hash >> 32;
  }
  for (; n > 0; b++, n--) hash = (hash ^ *b) * prime;
  return hash;
}

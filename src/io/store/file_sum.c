/* file_sum.c: the checksum of bytes; see file.h. It opens no file, so that builds without files
 * have it, too. */
#include <string.h>

#include "io/store/file.h"

uint64_t file_sum(uint64_t sum, const void *bytes, size_t n) {
  const unsigned char *b = bytes;
  const uint64_t prime = UINT64_C(1099511628211);
  for (; n >= 8; b += 8, n -= 8) {
    uint64_t word;
    memcpy(&word, b, 8);
    /* the shift lets high bits change low ones, which a multiplication alone never does */
    sum = (sum ^ word) * prime;
    sum ^= sum >> 32;
  }
  for (; n > 0; b++, n--) sum = (sum ^ *b) * prime;
  return sum;
}

/* hash.h: a hash that tells sets of numbers and texts apart: inputs, states, names of points.
 * Checksums of files are others (io/store/file.h). */
#ifndef SLIPDISK_BASE_HASH_H
#define SLIPDISK_BASE_HASH_H

#include <stddef.h>
#include <stdint.h>

/* Initial value of the argument `hash` of hash_words. */
#define HASH_WORDS UINT64_C(14695981039346656037)
/* Returns a hash that depends on the order of the bytes: FNV-1a over 64-bit words and the bytes
 * that remain, continued from `hash`. Names of points and files of all versions depend on it. */
uint64_t hash_words(uint64_t hash, const void *bytes, size_t n);

#endif

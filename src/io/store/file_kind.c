/* file_kind.c: the kind of a file by its name, and the checksum of bytes; see h5.h and file.h. It
 * opens no file itself and needs no HDF5, so that builds without both have it. */
#include <string.h>

#include "base/text.h"
#include "io/store/file.h"
#include "io/store/h5.h"

file_kind h5_kind_of(const char *path) {
  static const struct {
    const char *ending;
    file_kind kind;
  } endings[] = {{".cfg", FILE_DECK},         {".inc", FILE_DECK},      {".h5", FILE_HDF5},
                 {".hdf5", FILE_HDF5},        {".h5md", FILE_H5MD},     {".data", FILE_LAMMPS},
                 {".lmp", FILE_LAMMPS},       {".lammps", FILE_LAMMPS}, {".dump", FILE_LAMMPS},
                 {".lammpstrj", FILE_LAMMPS}, {".csv", FILE_TABLE},     {".txt", FILE_TABLE}};
  for (size_t k = 0; k < sizeof endings / sizeof *endings; k++)
    if (text_ends(path, endings[k].ending)) return endings[k].kind;
  return h5_is_file(path) ? FILE_HDF5 : FILE_OTHER;
}

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

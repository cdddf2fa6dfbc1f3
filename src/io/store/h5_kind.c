/* h5_kind.c: the kind of a file that a user names, by its ending; see h5.h. Builds without HDF5
 * have it, too. */
#include "base/text.h"
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

/* fuzz_lammps.c: LAMMPS data files, as disks and as a box. */
#include "fuzz.h"
#include "model/model.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const char form[] =
      "dt = 1e-4; steps = 1; max_overlap = 1; materials = ( { name = \"a\"; k_n = 1; } );\n"
      "box = { periodic = \"xy\"; file = \"%s\"; };\n"
      "disk_files = ( { file = \"%s\"; format = \"lammps\"; density = 1; },\n"
      "  { file = \"%s\"; format = \"lammps\"; columns = (\"x\", \"y\", \"radius\", \"mass\", "
      "\"name = id\", \"group = type\"); } );";
  char text[700];
  const char *path = fuzz_file(data, size);
  snprintf(text, sizeof text, form, path, path, path);
  sd_model_free(fuzz_load(text, 0, NULL));
  return 0;
}

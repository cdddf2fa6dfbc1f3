/* fuzz_csv.c: CSV files of disks and of motions. */
#include "fuzz.h"
#include "model/model.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const char *const forms[] = {"disk_files = ( { file = \"%s\"; format = \"csv\"; density "
                                      "= 1; material = \"a\"; } ); max_overlap = 1;",
                                      "disk_files = ( { file = \"%s\"; format = \"csv\"; columns "
                                      "= (\"x\", \"y = z\", \"radius\"); mass = 1; } );",
                                      "disks = ( { x = 0; y = 0; radius = 1; mass = 1; fixed = "
                                      "true; } ); motions = ( { disk = 0; coordinate "
                                      "= \"x\"; type = \"table\"; file = \"%s\"; } );"};
  char text[800], form[600];
  const char *path = fuzz_file(data, size);
  for (size_t k = 0; k < sizeof forms / sizeof *forms; k++) {
    snprintf(form, sizeof form,
             "dt = 1e-4; steps = 1; materials = ( { name = \"a\"; k_n = 1; } );\n%s", forms[k]);
    snprintf(text, sizeof text, form, path);
    sd_model_free(fuzz_load(text, 0, NULL));
  }
  return 0;
}

/* fuzz_override.c: what stands behind -D, a line each, over a deck that has most groups. */
#include "fuzz.h"
#include "model/model.h"

enum { MOST = 16 };

static const char deck[] =
    "title = \"fuzz\"; dt = 1e-4; seed = 3; gravity = { g = 9.81; tilt = 0.1; };\n"
    "materials = ( { name = \"a\"; k_n = 1e5; k_t = 1e4; gamma_n = 3; mu = 0.5; }, { name = "
    "\"b\"; k_n = 1e5; } );\n"
    "material_pairs = ( { materials = (\"a\", \"b\"); k_n = 1e5; } );\n"
    "container = { type = \"box\"; width = 20; height = 20; material = \"b\"; };\n"
    "disks = ( { name = \"one\"; x = -3; y = 3; radius = 1; mass = 1; material = \"a\"; group = "
    "\"g\"; },\n"
    "  { name = \"two\"; x = 3; y = 3; radius = 1; mass = 1; material = \"a\"; fixed = true; } "
    ");\n"
    "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); rows = ( (0, 8, 1), (3, 8, 1) ); "
    "density = 2;\n"
    "  material = \"a\"; } );\n"
    "packings = ( { type = \"triangular\"; count = 4; radius = 0.5; mass = 1; material = \"a\"; "
    "x = (-9, 9);\n"
    "  y = (12, 19); } );\n"
    "walls = ( { name = \"w\"; type = \"segment\"; points = ( (-2, 0.5), (2, 0.5) ); material = "
    "\"b\"; } );\n"
    "motions = ( { name = \"m\"; disk = \"two\"; coordinate = \"theta\"; type = \"random\"; "
    "amplitude = 0.1;\n"
    "  frequency = 2; }, { name = \"t\"; wall = \"w\"; coordinate = \"y\"; type = \"table\"; "
    "times = (0, 1, 2);\n"
    "  values = (0, 0, 0); } );\n"
    "forces = ( { group = \"g\"; force = (1, 0); } ); locks = ( { disk = 0; coordinates = "
    "\"theta\"; } );\n"
    "phases = ( { name = \"p\"; time = 1; settle = { kinetic = 1e-6; }; }, { steps = 100; } );\n"
    "output = { series = 10; frames = 20; contacts = 20; }; measure = { rotation = (\"one\"); "
    "disks = true; };\n"
    "until = { error = 0.1; max_time = 10; };\n"
    "sweep = ( { parameters = ( { path = \"gravity.tilt\"; linspace = (0, 1, 3); } ); replicas = "
    "2; } );\n";

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  char *text = fuzz_text(data, size), *rest = NULL;
  const char *overrides[MOST];
  size_t n = 0;
  for (char *line = strtok_r(text, "\n", &rest); line && n < MOST;
       line = strtok_r(NULL, "\n", &rest))
    overrides[n++] = line;
  sd_model_free(fuzz_load(deck, n, overrides));
  free(text);
  return 0;
}

/* test_deck_mistakes.c: mistakes that few make and spellings that few use, each with what the reader says or takes.
 * The cases were found with tools/soak.sh coverage.
 */
#include <unistd.h>

#include "unit.h"
#include "model/state.h"
#include "slipdisk/deck.h"

#define START "dt = 1e-3; steps = 10; materials = ( { name = \"m\"; k_n = 10; } );\n"
#define TWO                                                                                        \
  "dt = 1e-3; steps = 10; materials = ( { name = \"m\"; k_n = 10; }, { name = \"n\"; k_n = 20; } " \
  ");\n"                                                                                           \
  "disks = ( { x = 0; y = 0; radius = 1; mass = 1; material = \"m\"; } );\n"
#define DISK "disks = ( { name = \"a\"; x = 0; y = 0; radius = 1; mass = 2; group = \"g\"; } );\n"
#define BEAM "walls = ( { name = \"w\"; type = \"segment\"; points = ((0, -2), (4, -2)); } );\n"
#define ARCH                                                                                       \
  "walls = ( { name = \"w\"; type = \"circle\"; center = (0, 0); radius = 9; inside = true; } "    \
  ");\n"

typedef struct corner {
  const char *deck, *says; /* words of the message; NULL: the deck is read */
} corner;

/* Is it so? */
static bool holds(const corner *c) {
  sd_model *m = NULL;
  sd_messages *messages = sd_messages_new();
  assert_non_null(messages);
  sd_status status = sd_deck_load_text(c->deck, "corner.cfg", 0, NULL, &m, messages);
  bool said = !c->says;
  for (size_t k = 0; k < sd_messages_count(messages) && c->says; k++)
    said = said || strstr(sd_messages_text(messages, k), c->says);
  bool right = said && status == (c->says ? SD_ERROR_USER : SD_OK);
  if (!right) {
    print_error("%s\nexpected: %s\n", c->deck, c->says ? c->says : "no mistake");
    sd_messages_print(messages, stderr);
  }
  sd_model_free(m);
  sd_messages_free(messages);
  return right;
}

static void try_all(const corner *list, size_t n) {
  size_t wrong = 0;
  for (size_t k = 0; k < n; k++) wrong += !holds(&list[k]);
  assert_int_equal(wrong, 0);
}

#define TRY(list) try_all(list, sizeof(list) / sizeof *(list))

static void materials_and_walls(void **unused) {
  static const corner list[] = {
      {TWO "material_pairs = ( { materials = (\"m\"); k_n = 1; } );", "the names of two materials"},
      {TWO "material_pairs = ( { materials = \"m\"; k_n = 1; } );", "the names of two materials"},
      {TWO "material_pairs = ( { k_n = 1; } );", "the names of two materials"},
      {TWO "material_pairs = ( { materials = (\"m\", 1); k_n = 1; } );", "the name of a material"},
      {TWO "material_pairs = ( { materials = (\"m\", \"m\"); k_n = 1; } );",
       "itself stands in materials"},
      {TWO "material_pairs = ( { materials = (\"m\", \"n\"); k_n = 1; }, { materials = (\"n\", "
           "\"m\"); k_n = 1; } );",
       "given twice"},
      {TWO "material_pairs = ( 3 );", "material_pairs"},
      {"dt = 1; steps = 1; materials = ();" DISK, "materials"},
      {"dt = 1; steps = 1; materials = ( { name = \"\"; k_n = 1; } );" DISK,
       "a name that is not empty"},
      {"dt = 1; steps = 1; materials = ( 7 );" DISK, "materials[0]"},
      {START DISK "walls = ( { type = \"line\"; points = 3; } );", "expected two points"},
      {START DISK "walls = ( { type = \"line\"; points = ((0, 0)); } );", "expected two points"},
      {START DISK "walls = ( { type = \"line\"; points = ((0, 0), (1, 0), (2, 0)); } );",
       "expected two points"},
      {START DISK "walls = ( { type = \"polyline\"; points = ((0, 0)); } );", "two or more points"},
      {START DISK "walls = ( { type = \"line\"; points = ((0, 0), 1); } );",
       "expected a point (x, y)"},
      {START DISK "walls = ( { type = \"line\"; points = ((0, 0), (1, 2, 3)); } );",
       "expected a point (x, y)"},
      {START DISK "walls = ( { type = \"line\"; points = ((0, 0), (0, 0)); } );",
       "the same as the point before"},
      {START DISK
       "walls = ( { type = \"polyline\"; closed = true; points = ((0, -4), (1, -4)); } );",
       "three points or more"},
      {START DISK "walls = ( { type = \"polyline\"; closed = true; points = ((0, -4), (1, -4), (1, "
                  "-5), (0, -4)); } );",
       "the same as the first point"},
      {START DISK "walls = ( 1 );", "walls[0]"},
      {START DISK "walls = ( { name = \"a\"; type = \"line\"; points = ((0, -4), (1, -4)); } );",
       "a disk has this name too"},
  };
  TRY(list);
}

/* What no other test says: names that are there twice, coordinates that are held and move, clumps, fields, lists. */
static void bodies_that_cannot_be(void **unused) {
#define CLUMP(more)                                                                                \
  START                                                                                            \
  "disks = ( { x = 0; y = 0; radius = 1; density = 1; }, { x = 4; y = 0; radius = 1; density = "   \
  "1; } ); "                                                                                       \
  "clumps = ( { name = \"c\"; disk = 0; " more " } );"
#define PACKED(more)                                                                               \
  START "box = { x = (0, 20); y = (0, 20); periodic = \"xy\"; }; packings = ( { type = "           \
        "\"random\"; count = "                                                                     \
        "2; "                                                                                      \
        "density = 1; radius = 1; clump = { " more " }; } );"
#define FIELD(more)                                                                                \
  START DISK "fields = ( { name = \"f\"; type = \"drag\"; gamma = 1; } , { " more " } );"
  static const corner list[] = {
      {START DISK "walls = ( { name = \"w\"; type = \"circle\"; center = (3.5, 0); radius = 3; "
                  "side = \"inside\"; } );",
       "disk \"a\" sits 1.5 deep in wall \"w\""},
      {START DISK "walls = ( { name = \"w\"; type = \"circle\"; center = (1.2, 0); radius = 1; "
                  "side = \"outside\"; } );",
       "disk \"a\" sits 0.8 deep in wall \"w\""},
      {START DISK
       "walls = ( { name = \"w\"; type = \"line\"; points = ((0, -4), (1, -4)); }, { name = "
       "\"w\"; type = \"line\"; points = ((0, -5), (1, -5)); } );",
       "two walls have this name"},
      {START "disks = ( { x = 0; y = 0; radius = 1; mass = 1; fixed = true; vx = 1; } );",
       "a fixed disk cannot have a velocity"},
      {START "disks = ( { x = 0; y = 0; radius = 1; mass = 1; locked = \"x\"; vx = 1; } );",
       "a locked coordinate cannot have a velocity"},
      {START "disk_rows = ( { columns = (\"x\", \"y\", \"radius\", \"vx\"); fixed = true; "
             "density = 1; rows = ( (0, 0, 1, 2) ); } );",
       "a fixed disk cannot have a velocity"},
      {START "disk_rows = ( { rows = ( (0, 0, 1) ); density = 1; } );",
       "columns: missing: expected"},
      {START "disk_rows = ( { columns = (3); rows = ( (0) ); density = 1; } );",
       "the name of a column in quotes"},
      {START "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 1; rows = 3; } );",
       "expected a list of rows ( (1.0, 2.0, 0.5), ... )"},
      {START
       "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); density = 1; rows = ( (0, 0) ); } );",
       "expected 3 values in ( ), one per column"},
      {START "disk_rows = ( { columns = (\"x\", \"y\", \"radius\", \"group\"); density = 1; rows "
             "= ( (0, 0, 1, 3) ); } );",
       "expected a text in quotes"},
      {CLUMP("locked = \"x\"; velocity = (1, 0);"), "a locked coordinate cannot have a velocity"},
      {CLUMP("}, { name = \"c\"; disk = 1;"), "two clumps have this name"},
      {PACKED("at = (3, 4);"), "expected two numbers (x, y)"},
      {PACKED("at = ((0, 0), (1, 0)); radii = (1, 1, 1);"), "3 radii for 2 disks"},
      {PACKED("at = ((0, 0), (1, 0)); radii = (1, -1);"), "a number > 0"},
      {PACKED(""), "the centres of its disks"},
      {FIELD("name = \"f\"; type = \"drag\"; gamma = 2;"), "two fields have this name"},
      {FIELD("type = \"damping\"; alpha = 1;"), "it would hold every disk where it is"},
      {FIELD("type = \"central\"; centre = (0, 0); strength = 1; power = 99;"),
       "expected a whole number from"},
      {FIELD("type = \"drag\"; gamma = 1; group = 3;"),
       "no group of disks is called that; there is \"g\""},
      {START DISK BEAM "motions = ( { wall = (\"w\", \"w\"); coordinate = \"x\"; type = "
                       "\"velocity\"; velocity = 1; } );",
       "is named twice"},
      {START DISK ARCH "motions = ( { wall = \"w\"; coordinate = \"theta\"; type = \"harmonic\"; "
                       "acceleration = 1; frequency = 1; } );",
       "theta has none in units of g"},
      {START DISK "phases = ( { steps = 10; settle = { every = 3; }; } );", "it has no criterion"},
      {START DISK "measure = { rotation = (\"a\", \"a\"); };", "named twice"},
  };
  TRY(list);
}

static void tables(void **unused) {
#define TABLE(more)                                                                                \
  START DISK BEAM "motions = ( { wall = \"w\"; coordinate = \"x\"; type = \"table\"; " more " } "  \
                  ");"
  static const corner list[] = {
      {TABLE("times = 3; values = (0, 1, 2);"), "expected a list of numbers"},
      {TABLE("times = (0, 1, 2);"), "a value for each of times"},
      {TABLE("times = (0, 1, 2); values = (0, 1);"), "as many values as times (3)"},
      {TABLE("times = (0, 1); values = (0, 1);"), "at least 3 rows, it has 2"},
      {TABLE("times = (0, 2, 1); values = (0, 1, 2);"),
       "times must increase, but row 2 has 1 after 2"},
      {TABLE("times = (0, 1, 2); values = (0, 1, 2); periodic = true;"),
       "the last value (2) must equal the first (0)"},
      {TABLE("times = (0, 1, 2); values = (0, 1, \"x\");"), "values"},
      {TABLE("file = 3;"), "file"},
      {TABLE("file = \"none.csv\"; columns = \"time\";"), "the names of two columns"},
      {TABLE("file = \"none.csv\"; columns = (\"time\");"), "the names of two columns"},
      {TABLE("file = \"none.csv\"; columns = (\"time\", 1);"), "the name of a column in quotes"},
      {TABLE("file = \"none.csv\"; values = (1, 2, 3);"), "given together with file"},
      {TABLE("times = (0, 1, 2); values = (0, 1, 2);"), NULL},
  };
  TRY(list);
}

static void motions(void **unused) {
#define MOTION(what) START DISK BEAM "motions = ( { " what " } );"
#define SURFACE(wall)                                                                              \
  "dt = 1e-3; steps = 10; materials = ( { name = \"m\"; k_n = 10; k_r = 1; mu_r = 0.1; } "         \
  ");\n" DISK "walls = ( { name = \"w\"; type = \"circle\"; center = (0, 0); radius = 9; side = "  \
  "\"inside\"; },\n"                                                                               \
  "          { name = \"v\"; type = \"segment\"; points = ((0, -2), (4, -2)); } );\n"              \
  "motions = ( { wall = \"" wall                                                                   \
  "\"; coordinate = \"surface\"; type = \"velocity\"; velocity = 1; } );"
#define SERVO(more) "type = \"servo\"; speed = 1; " more
  static const corner list[] = {
      {MOTION("wall = \"w\"; coordinate = \"x\"; type = \"harmonic\"; amplitude = 1; omega = 0;"),
       "omega"},
      {MOTION("wall = \"w\"; coordinate = \"x\"; type = \"random\"; amplitude = -1; omega = 1;"),
       "amplitude"},
      {MOTION("disk = \"a\"; coordinate = \"y\"; type = \"load\"; mass = 1;"),
       "a load moves walls only"},
      {MOTION("group = \"g\"; coordinate = \"y\"; " SERVO("force = 1;")),
       "a servo moves walls only"},
      {MOTION("wall = \"w\"; coordinate = \"theta\"; type = \"load\"; mass = 1;"),
       "expected \"x\" or \"y\""},
      {MOTION("wall = \"w\"; coordinate = [\"x\", \"y\"]; type = \"load\"; mass = 1;"),
       "expected \"x\" or \"y\""},
      {MOTION("wall = \"w\"; coordinate = \"y\"; " SERVO("force = 0;")), "a force other than 0"},
      {MOTION("wall = \"w\"; coordinate = \"y\"; " SERVO("force = 1; length = 2;")),
       "with pressure only"},
      {MOTION("wall = \"w\"; coordinate = \"x\"; " SERVO("pressure = 1;")),
       "does not press along x; expected force"},
      {MOTION("wall = \"w\"; coordinate = \"y\"; " SERVO("force = 1;")), NULL},
      {MOTION("wall = \"w\"; coordinate = \"y\"; type = \"load\"; mass = 1;"), NULL},
      {START DISK "motions = ( 1 );", "motions"},
      {SURFACE("w"), "the surface of a round wall with rolling resistance (k_r)"},
      {SURFACE("v"), NULL},
      {START DISK BEAM
       "locks = ( { disk = \"a\"; coordinates = \"x\"; } );"
       "motions = ( { disk = \"a\"; coordinate = \"x\"; type = \"velocity\"; velocity = 1; } );",
       "is locked, and cannot be moved too"},
      {START
       "disks = ( { name = \"a\"; x = 0; y = 0; vy = 1; radius = 1; mass = 2; } );"
       "motions = ( { disk = \"a\"; coordinate = \"y\"; type = \"velocity\"; velocity = 1; } );",
       "y of disk \"a\" is given a velocity of its own"},
      {START "disks = ( { name = \"a\"; x = 0; y = 0; omega = 1; radius = 1; mass = 2; } );"
             "motions = ( { disk = \"a\"; coordinate = \"theta\"; type = \"velocity\"; velocity = "
             "1; } );",
       "theta of disk \"a\" is given a velocity of its own"},
  };
  TRY(list);
}

static void what_ends_a_run(void **unused) {
#define UNTIL(more) START DISK "measure = { rotation = [\"a\"]; }; until = { " more " };"
  static const corner list[] = {
      {UNTIL("error = 1; relative = 0.1; max_time = 1;"), "given together with error"},
      {UNTIL("max_time = 1;"), "the standard error to be reached"},
      {UNTIL("error = 1; max_time = 1e-3;"), "at least the length of the last phase"},
      {UNTIL("error = 1; max_time = 1e17;"), "more than 9e18 time steps"},
      {UNTIL("error = 1; max_time = \"x\";"), "max_time"},
      {UNTIL("error = 1; max_time = 1; observable = \"a.omga\";"), "did you mean \"omega\""},
      {UNTIL("error = 1; max_time = 1; observable = \"a\";"), "NAME that of a watched disk"},
      {UNTIL("error = 1; max_time = 1; observable = \"b.omega\";"), "observable"},
      {UNTIL("error = 1; max_time = 1; observable = \"a.scaled\";"),
       "does not exist without gravity"},
      {UNTIL("error = 1; max_time = 1; observable = \"0.omega\";"), NULL},
      {UNTIL("error = 1; max_time = 1; observable = 3;"), "observable"},
      {UNTIL("relative = 0.1; max_time = 1; observable = \"a.omega\";"), NULL},
      {START DISK "measure = { rotation = (); }; until = { error = 1; max_time = 1; };",
       "no disk is watched"},
      {START DISK "until = 3;", "until"},
      {"dt = 1e-3; materials = ( { name = \"m\"; k_n = 10; } );" DISK
       "phases = ( { steps = 5; measure = false; } ); until = { error = 1; max_time = 1; };",
       "the last phase does not measure"},
  };
  TRY(list);
}

static void phases_and_measures(void **unused) {
#define PHASES(what) "dt = 1e-3; materials = ( { name = \"m\"; k_n = 10; } );" DISK what
#define SLIDING(what) START DISK BEAM "measure = { sliding = ( { " what " } ); };"
  static const corner list[] = {
      {PHASES("phases = ( { time = 1e-4; } );"), "shorter than half a time step"},
      {PHASES("phases = ( { time = 1e17; } );"), "more than 9e18 time steps"},
      {PHASES("phases = ();"), "phases"},
      {PHASES("phases = ( 3 );"), "phases[0]"},
      {PHASES("steps = 1; phases = ( { steps = 1; } );"), "steps"},
      {PHASES("time = 1; phases = ( { steps = 1; } );"), "time"},
      {PHASES("phases = ( { steps = 1; motions = (0); } );"), "motions"},
      {PHASES("phases = ( { steps = 1; motions = (-1); } );"), "motions"},
      {PHASES("phases = ( { steps = 1; motions = (1.5); } );"), "motions"},
      {PHASES("phases = ( { steps = 1; settle = 3; } );"), "settle"},
      {PHASES("phases = ( { steps = 1; compress = 3; } );"), "compress"},
      {PHASES("steps = 1; output = 3;"), "output"},
      {PHASES("steps = 1; measure = 3;"), "measure"},
      {SLIDING("partners = [\"w\", \"a\"];"), "the name or the number of a disk"},
      {SLIDING("disk = \"a\"; partners = \"w\";"), "partners"},
      {SLIDING("disk = \"a\"; partners = [\"w\"];"), "partners"},
      {SLIDING("disk = \"a\";"), "partners"},
      {SLIDING("disk = \"z\"; partners = [\"w\", \"a\"];"), "sliding"},
      {SLIDING("disk = \"a\"; partners = [\"w\", \"w\"];"), "expected two different ones"},
      {SLIDING("disk = \"a\"; partners = [\"w\", \"a\"];"), "partners"},
      {START DISK "measure = { sliding = ( 1 ); };", "sliding"},
      {START DISK BEAM "motions = ( { disk = \"a\"; coordinate = \"x\"; type = \"fixed\"; } );\n"
                       "measure = { sliding = ( { disk = \"a\"; partners = [\"w\", 0]; } ); };",
       "sliding"},
  };
  TRY(list);
}

static void numbers_and_names(void **unused) {
#define ANGLE(text) START "disks = ( { x = 0; y = 0; theta = " text "; radius = 1; mass = 2; } );"
  static const corner list[] = {
      {ANGLE("\"-pi\""), NULL},
      {ANGLE("\"+pi/2\""), NULL},
      {ANGLE("\"2*pi\""), NULL},
      {ANGLE("\"2 * pi\""), NULL},
      {ANGLE("\"3 rad\""), NULL},
      {ANGLE("\"90 deg\""), NULL},
      {ANGLE("\"pi/0\""), "theta"},
      {ANGLE("\"pi/\""), "theta"},
      {ANGLE("\"deg\""), "theta"},
      {ANGLE("\"rad\""), "theta"},
      {ANGLE("\"\""), "theta"},
      {ANGLE("\"1e999 pi\""), "theta"},
      {ANGLE("\"2 pi pi\""), "theta"},
      {ANGLE("true"), "theta"},
      {ANGLE("(1, 2)"), "theta"},
      {START DISK "seed = 1.5;", "seed"},
      {START DISK "seed = \"x\";", "seed"},
      {START DISK "seed = true;", "seed"},
      {START DISK "gravity = 3;", "gravity"},
      {START DISK "gravity = { g = 1; direction = (1, 2, 3); };", "gravity"},
      {START DISK "box = 3;", "box"},
      {START DISK "bounds = 3;", "bounds"},
      {START DISK "bounds = { x = (1, 0); };", "bounds"},
      {START DISK "bounds = { outside = \"remove\"; };", NULL},
      {START DISK "box = { periodic = \"xy\"; x = (-9, 9); y = (-9, 9); }; bounds = { outside = "
                  "\"remove\"; };",
       "nothing to leave"},
      {START DISK "container = 3;", "container"},
      {START DISK "forces = ( 3 );", "forces[0]"},
      {START DISK "locks = ( 3 );", "locks[0]"},
      {START DISK "disk_files = ( 3 );", "disk_files[0]"},
      {START DISK "packings = ( 3 );", "packings[0]"},
      {START "disks = ( 3 );", "disks[0]"},
      {START DISK "forces = ( { disk = 7; force = (1, 1); } );", "no disk has this number"},
      {START DISK "forces = ( { disk = -1; force = (1, 1); } );", "disk"},
      {START DISK "forces = ( { disk = true; force = (1, 1); } );", "disk"},
      {START DISK "forces = ( { group = \"h\"; force = (1, 1); } );",
       "no group of disks is called that"},
      {START DISK "forces = ( { force = (1, 1); } );", "it names no disk"},
      {START DISK "locks = ( { disk = \"a\"; coordinates = (\"x\", \"x\"); } );", "named twice"},
      {START DISK "locks = ( { disk = \"a\"; coordinates = (\"x\", 1); } );", "coordinates"},
      {START "disks = ( { x = 0; y = 0; radius = 1; mass = 1; group = \"grains\"; } );\n"
             "locks = ( { group = \"grains\"; except = \"grain\"; coordinates = \"x\"; } );",
       "no disk and no group of disks is called that; did you mean \"grains\"?"},
      {START DISK "locks = ( { group = \"g\"; except = 2; coordinates = \"x\"; } );",
       "locks[0].except = 2: no disk has this number"},
      {START "disks = ( { x = 0; y = 0; radius = 1; mass = 1; group = \"g\"; }, "
             "{ x = 3; y = 0; radius = 1; mass = 1; } );\n"
             "locks = ( { group = \"g\"; except = 1; coordinates = \"x\"; } );",
       "disk 1 is not among the disks that are locked"},
      {START DISK "title = \"a text that is longer than what a message shows of it, as it would "
                  "be too much\"; gravity = \"another text that is longer than what a message "
                  "shows of it, it would be too much\";",
       "gravity"},
      {START DISK "dt = true;", "dt"},
      {START DISK "walls = ( { type = \"lines\"; } );", "did you mean \"line\""},
      {START DISK "walls = ( { type = 3; } );", "type"},
      {START DISK ARCH "walls = ();", "given twice"},
  };
  TRY(list);
}

/* Numbers from a file, for a table of a motion and for rows of disks. */
static size_t wrong_files;

static void with_ending(const char *ending, const char *text, const char *before, const char *after,
                        const char *says) {
  char path[64], whole[2048];
  snprintf(path, sizeof path, "/tmp/slipdisk-corners-XXXXXX%s", ending);
  int file = mkstemps(path, (int)strlen(ending));
  assert_true(file >= 0);
  assert_int_equal(write(file, text, strlen(text)), (ssize_t)strlen(text));
  close(file);
  snprintf(whole, sizeof whole, "%s\"%s\"%s", before, path, after);
  wrong_files += !holds(&(corner){whole, says});
  unlink(path);
}

static void with_file(const char *text, const char *before, const char *after, const char *says) {
  with_ending(".csv", text, before, after, says);
}

static void files_of_numbers(void **unused) {
  const char *table =
      START DISK BEAM "motions = ( { wall = \"w\"; coordinate = \"x\"; type = \"table\"; file = ",
             *end = "; } );";
  with_file("time,value\n0,0\n1,1\n2,0\n", table, end, NULL);
  with_file("# a comment\n\n time , value \r\n0, 0\r\n1, 1\r\n2, 0", table, end, NULL);
  with_file("", table, end, "the file is empty");
  with_file("# nothing\n\n", table, end, "the file is empty");
  with_file("tim,value\n0,0\n", table, end, "did you mean \"tim\"");
  with_file("b,c,d,e,f,g,h,i,j,k\n0,0\n", table, end,
            "found \"b\", \"c\", \"d\", \"e\", \"f\", \"g\", \"h\", \"i\", ...");
  with_file("b,c\n0,0\n", table, end, "found \"b\", \"c\"");
  with_file("time,value\n0,0\n1\n2,0\n", table, end, "1 values; expected 2");
  with_file("time,value\n0,0\n1,x\n2,0\n", table, end, "value = x: expected a number");
  with_file("time,value\n0,0\n1,\n2,0\n", table, end, "value = (empty): expected a number");
  with_file("time,value\n0,0\n1,inf\n2,0\n", table, end, "value = inf: expected a number");
  with_file("time,value\n0,0\n1,1\n", table, end, "at least 3 rows");
  const char *disks = START "disk_files = ( { file = ", *more = "; mass = 1.0; } );";
  with_file("x,y,radius\n0,0,1\n5,0,1\n", disks, more, NULL);
  with_file("x,x,radius\n0,0,1\n", disks, more, "there twice");
  with_file("x,radius\n0,1\n", disks, more, "y: missing");
  with_file("x,y,radius\n0,0\n", disks, more, "2 values; expected 3");
  with_file("x,y,radius,fixed\n0,0,1,true\n5,0,1,false\n9,0,1,2\n", disks, more,
            "fixed = true: expected a number");
  with_file("x,y,radius,material\n0,0,1,m\n5,0,1,glass\n", disks, more, "glass");
  with_file("x,y,radius,weight\n0,0,1,3\n", disks, more, "weight");
  assert_int_equal(wrong_files, 0);
}

static void with_atoms(const char *text, const char *says) {
  with_ending(".data", text, START "disk_files = ( { file = ", "; mass = 1.0; } );", says);
}

static void with_dump(const char *text, const char *says) {
  with_ending(".dump", text, START "disk_files = ( { file = ", "; } );", says);
}

#define FRAME(step, n, box, names)                                                                 \
  "ITEM: TIMESTEP\n" step "\nITEM: NUMBER OF ATOMS\n" n "\nITEM: BOX BOUNDS " box                  \
  "\nITEM: ATOMS " names "\n"
#define UPRIGHT "pp ff pp\n-1 1\n-1 1\n-1 1"
#define NAMES "id type x y radius mass"
#define ONE FRAME("7", "1", UPRIGHT, NAMES)

static void dumps_of_lammps(void **unused) {
  wrong_files = 0;
  with_dump(ONE "1 1 0 0 0.5 1\n", NULL);
  with_dump(ONE "1 C 0 0 0.5 1\n" FRAME("8", "1", UPRIGHT, NAMES) "1 1 0 0 0.5 1", NULL);
  with_dump("ITEM: UNITS\nlj\nITEM: TIME\n0.5\n" ONE "1 1 0 0 0.5 1\n", NULL);
  with_dump(FRAME("7", "1", "xy xz yz pp pp pp\n-1 1 0\n-1 1 0\n-1 1 0", NAMES) "1 1 0 0 0.5 1\n",
            NULL);
  with_dump(FRAME("7", "1", "xy xz yz pp pp pp\n-1 1 0.1\n-1 1 0\n-1 1 0", NAMES) "1 1 0 0 0.5 1\n",
            ":5: the box of this frame is tilted");
  with_dump(
      FRAME("7", "1", "abc origin pp pp pp\n1 0 0 0\n0 1 0 0\n0 0 1 0", NAMES) "1 1 0 0 1 1\n",
      "tilted");
  with_dump("ITEM: TIMESTEP\n", "the file ends before the timestep");
  with_dump("ITEM: TIMESTEP\n7\n", "the file ends in the head of a frame");
  with_dump("ITEM: TIMESTEP\n7a\n", ":2: timestep = 7a: expected a whole number");
  with_dump("ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\nx\n", ":4: number of atoms = x");
  with_dump("ITEM: TIMESTEP\n7\nITEM: ENTRIES c_1\n", ":3: ITEM: ENTRIES: expected ITEM: TIMESTEP");
  with_dump("ITEM: TIMESTEP\n7\nITEM: ATOMS id\n", "no ITEM: NUMBER OF ATOMS before its atoms");
  with_dump("ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n0\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 z\n",
            ":7: yhi = z: expected a number");
  with_dump("ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n0\nITEM: BOX BOUNDS pp pp pp\n0\n",
            "expected xlo and xhi of the box");
  with_dump(ONE "1 1 0 0 0.5\n", ":10: 5 values; expected 6, one per name in line 9");
  with_dump(ONE "1 1 0 0 0.5 1\n1 1 0 0 0.5 1\n", ":11: 1 1: expected ITEM: TIMESTEP");
  with_dump(ONE "", ":9: the frame of timestep 7 has 0 of 1 atoms");
  with_dump(ONE "1 1 0 0 0.5 1\n" FRAME("8", "2", UPRIGHT, NAMES) "1 1 0 0 0.5 1",
            "the frame of timestep 8 has 1 of 2 atoms; timestep = 7 is the last whole one");
  with_dump(ONE "1 1 0 a 0.5 1\n", ":10: y = a: expected a number");
  with_dump(ONE "b 1 0 0 0.5 1\n", ":10: id = b: expected a whole number");
  with_dump(FRAME("7", "2", UPRIGHT, NAMES) "1 1 0 0 0.5 1\n1 1 2 0 0.5 1\n", "two atoms have it");
  with_dump(FRAME("7", "1", UPRIGHT, "id x y mass") "1 0 0 1\n", "radius: missing");
  with_dump(FRAME("7", "1", UPRIGHT, "id x radius mass") "1 0 1 1\n", "y: missing");
  with_dump(ONE "1 1 0 0 -0.5 1\n", "radius");
  with_dump(
      "ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n-1\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\n"
      "ITEM: ATOMS id x y radius mass\n",
      "before its atoms");
  assert_int_equal(wrong_files, 0);
}

#define HEAD "LAMMPS data file\n\n1 atoms\n-1 1 xlo xhi\n-1 1 ylo yhi\n\n"

static void files_of_lammps(void **unused) {
  wrong_files = 0;
  with_atoms(HEAD "Atoms # sphere\n\n1 1 0.5 1 0 0 0\n", NULL);
  with_atoms(HEAD "Atoms # sphere  \n\n1 1 0.5 1 0 0 0 0 0 0", NULL);
  with_atoms(HEAD "Atoms # sphere\n\n1 1 0.5 1 0 0 0\n\nVelocities\n\n1 1 2 0 0 0 3\n", NULL);
  with_atoms(HEAD "Masses\n\n1 1\n\nAtoms # sphere\n\n1 1 0.5 1 0 0 0\n", NULL);
  with_atoms("LAMMPS\n", "no LAMMPS data file or dump");
  with_atoms("LAMMPS\n\nAtoms # sphere\n\n1 1 0.5 1 0 0 0\n", "no LAMMPS data file");
  with_atoms("LAMMPS\n\n1x atoms\n\nAtoms # sphere\n", "atoms = 1x: expected a whole number");
  with_atoms("LAMMPS\n\n1 atoms\n1z 1 xlo xhi\n\nAtoms # sphere\n", "xlo = 1z: expected a number");
  with_atoms("LAMMPS\n\n1 atoms\n-1 1z ylo yhi\n\nAtoms # sphere\n", "yhi = 1z: expected a number");
  with_atoms("LAMMPS\n\n1 atoms\n0.5 0 0 xy xz yz\n\nAtoms # sphere\n", "is tilted");
  with_atoms("LAMMPS\n\n1 atoms\n1 0 0 avec\n\nAtoms # sphere\n", "is tilted");
  with_atoms("LAMMPS\n\n1 atoms\n0 0 0 xy xz yz\n\nAtoms # sphere\n\n1 1 0.5 1 0 0 0\n", NULL);
  with_atoms(HEAD "Atoms\n\n1 1 0.5 1 0 0 0\n", "not given in a comment");
  with_atoms(HEAD "Atoms # hybrid\n\n1 1 0.5 1 0 0 0\n", "which styles it is made of");
  with_atoms(HEAD "Atoms # atomic\n\n1 1 0 0 0\n", "Atoms # atomic: ");
  with_atoms(HEAD "Atoms # sphere\n\n1 1 0.5 1 0 0\n", "6 values; expected 7");
  with_atoms(HEAD "Atoms # sphere\n\n1a 1 0.5 1 0 0 0\n", "id = 1a: expected a whole number");
  with_atoms(HEAD "Atoms # sphere\n\n1 1 a 1 0 0 0\n", "diameter = a: expected a number");
  with_atoms(HEAD "Atoms # sphere\n\n1 1 0.5 a 0 0 0\n", "density = a: expected a number");
  with_atoms(HEAD "Atoms # sphere\n\n1 1 0.5 1 a 0 0\n", "x = a: expected a number");
  with_atoms(HEAD "Atoms # sphere\n\n1 1 0.5 1 0 inf 0\n", "y = inf: expected a number");
  with_atoms(HEAD "Atoms # sphere\n\n1 1 0.5 1 0 0 0\n1 1 0.5 1 5 0 0\n", "two atoms have it");
  with_atoms(HEAD "Atoms # sphere\n\n1 1 0.5 1 0 0 0\n\nVelocities\n\n1 1 2\n",
             "3 values; expected 7");
  with_atoms(HEAD "Atoms # sphere\n\n1 1 0.5 1 0 0 0\n\nVelocities\n\n1b 1 2 0 0 0 3\n", "id = 1b");
  with_atoms(HEAD "Atoms # sphere\n\n1 1 0.5 1 0 0 0\n\nVelocities\n\n2 1 2 0 0 0 3\n",
             "no atom has it");
  with_atoms(HEAD "Atoms # sphere\n\n1 1 0.5 1 0 0 0\n\nVelocities\n\n1 1 b 0 0 0 3\n", "vy = b");
  with_atoms(HEAD "Velocities\n\n1 1 2 0 0 0 3\n", "Velocities");
  with_atoms(HEAD "Masses\n\n1 1\n", "Atoms");
  assert_int_equal(wrong_files, 0);
}

static void words_of_others(void **unused) {
#define OTHER_MOTION(type)                                                                         \
  START DISK "motions = ( { disk = 0; coordinate = \"x\"; type = \"" type                          \
             "\"; amplitude = 1; frequency = 1; } );"
#define OTHER_PACKING(keys)                                                                        \
  START                                                                                            \
  "container = { type = \"box\"; width = 9; height = 9; }; packings = ( { density = 1; count "     \
  "= 2; " keys " } );"
#define OTHER_LAW(keys)                                                                            \
  "dt = 1e-3; steps = 10; materials = ( { name = \"m\"; k_n = 10; " keys " } );\n" DISK
  static const corner list[] = {
      {OTHER_MOTION("sine"), "expected one of \"fixed\","},
      {OTHER_MOTION("sine"), "; did you mean \"harmonic\"?"},
      {OTHER_MOTION("Sinusoidal"), "; did you mean \"harmonic\"?"},
      {OTHER_MOTION("wiggle"), "; did you mean \"harmonic\"?"},
      {OTHER_MOTION("sawtooth"), "; did you mean \"triangle\"?"},
      {OTHER_MOTION("constant"), "; did you mean \"velocity\"?"},
      {OTHER_PACKING("radius = 1; type = \"pour\";"), "; did you mean \"rain\"?"},
      {OTHER_PACKING("radius = 1; type = \"insert\";"), "; did you mean \"rain\"?"},
      {OTHER_PACKING("radius = 1; type = \"hcp\";"), "; did you mean \"triangular\"?"},
      {OTHER_PACKING("type = \"random\"; sizes = \"gaussian\"; radius = 1; spread = 0.1;"),
       "; did you mean \"deviation\"?"},
      {OTHER_PACKING("type = \"random\"; sizes = \"gaussian\"; radius = 1; sigma = 0.1;"),
       "; did you mean \"deviation\"?"},
      {OTHER_PACKING("type = \"random\"; sizes = \"poly\"; radius = 1;"),
       "; did you mean \"uniform\"?"},
      {OTHER_PACKING("type = \"random\"; sizes = \"constant\"; radius = 1;"),
       "; did you mean \"mono\"?"},
      {OTHER_LAW("law = \"hooke\";"), "; did you mean \"linear\"?"},
      {OTHER_LAW("law = \"hertz_mindlin\";"), "; did you mean \"hertz\"?"},
      {START DISK "walls = ( { type = \"plane\"; } );", "; did you mean \"line\"?"},
      {START DISK "walls = ( { type = \"poly\"; } );", "; did you mean \"polyline\"?"},
      {START DISK "container = { type = \"cylinder\"; radius = 9; };", "; did you mean \"drum\"?"},
      {START DISK "fields = ( { type = \"viscous\"; } );", "; did you mean \"drag\"?"},
      {START DISK "integrator = \"leapfrog\";", "; did you mean \"verlet\"?"},
      {START DISK "box = { periodic = \"both\"; x = (0, 9); y = (0, 9); };",
       "; did you mean \"xy\"?"},
  };
  TRY(list);
}

static void settings(void **unused) {
  static const struct {
    const char *setting, *says;
  } list[] = {
      {"gravity.g=3", NULL},
      {"gravity.g = 3 ", NULL},
      {"disks[0].x=1", NULL},
      {"disks.a.x=1", NULL},
      {"disks[*].x=1", NULL},
      {"disks.[*].x=1", NULL},
      {"title=a word", NULL},
      {"title=\"a word\"", NULL},
      {"title=", NULL},
      {"gravity", "expected path=value"},
      {"=3", "expected path=value"},
      {"gravity..g=3", "expected path=value"},
      {"disks[].x=1", "expected a number in [ ]"},
      {"disks[-1].x=1", "expected a number in [ ]"},
      {"disks[0.x=1", "expected a number in [ ]"},
      {"disks[3].x=1", "entries [0] to [0] only"},
      {"[0]=1", "the deck has no entries [ ]"},
      {"dt[0]=1", "no entries [ ]"},
      {"dt.x=1", "is a value and has no keys"},
      {"dt[*]=1", "is no list"},
      {"disks[0]x=1", "expected . or [ after ]"},
      {"disks.z.x=1", "disks"},
      {"dt=1e999", "out of range"},
      {"dt=(1", "cannot be read"},
      {"dt=1.2.3", "dt"},
      {"gravity={ g = 1; }", NULL},
      {"gravity={ g = ; }", "cannot be read"},
  };
  size_t wrong = 0;
  for (size_t k = 0; k < sizeof list / sizeof *list; k++) {
    sd_model *m = NULL;
    sd_messages *messages = sd_messages_new();
    bool said = !list[k].says;
    sd_status status =
        sd_deck_load_text(START DISK, "corner.cfg", 1, &list[k].setting, &m, messages);
    for (size_t j = 0; j < sd_messages_count(messages) && list[k].says; j++)
      said = said || strstr(sd_messages_text(messages, j), list[k].says);
    if (!said || status != (list[k].says ? SD_ERROR_USER : SD_OK)) {
      print_error("-D %s\nexpected: %s\n", list[k].setting,
                  list[k].says ? list[k].says : "no mistake");
      sd_messages_print(messages, stderr);
      wrong++;
    }
    sd_model_free(m);
    sd_messages_free(messages);
  }
  assert_int_equal(wrong, 0);
}

RUN_TESTS(TEST(materials_and_walls), TEST(bodies_that_cannot_be), TEST(tables), TEST(motions),
          TEST(what_ends_a_run), TEST(phases_and_measures), TEST(numbers_and_names),
          TEST(files_of_numbers), TEST(files_of_lammps), TEST(words_of_others),
          TEST(dumps_of_lammps), TEST(settings))

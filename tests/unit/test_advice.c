/* test_advice.c: set-ups that may be meant and seldom are (model/advice.c): each is told once, and its usual neighbour not. */
#include "deck_runs.h"
#include "model/advice.h"
#include "model/overlaps.h"

#define VERLET "integrator = \"verlet\"; dt = 1e-3;\n"
#define LAW "materials = ( { name = \"m\"; k_n = 1e4; k_t = 5e3; gamma_n = 2.0; mu = 0.5; } );\n"
#define GRAVITY "gravity = { g = 10.0; };\n"
#define FLOOR                                                                                      \
  "walls = ( { name = \"floor\"; type = \"line\"; points = ((0.0, 0.0), (1.0, 0.0)); } );\n"
#define DISK "disks = ( { name = \"a\"; x = 0.0; y = 0.999; radius = 1.0; mass = 1.0; } );\n"
#define PHASE(what) "phases = ( { name = \"p\"; time = 100; " what " } );\n"
#define DROP VERLET LAW GRAVITY FLOOR DISK

/* The warnings of a deck, each with this word; NULL: there are none. */
static void advised(const char *deck, const char *word) {
  sd_model *m = model_of(deck);
  sd_messages *messages = sd_messages_new();
  sd_model_advise(m, messages);
  if (!word && sd_messages_count(messages) > 0) print_error("%s", sd_messages_text(messages, 0));
  if (word && sd_messages_count(messages) != 1)
    print_error("%zu: %s", sd_messages_count(messages), word);
  assert_int_equal(sd_messages_count(messages), word ? 1 : 0);
  assert_int_equal(sd_messages_errors(messages), 0);
  if (word && !strstr(sd_messages_text(messages, 0), word)) {
    print_error("%s: %s", word, sd_messages_text(messages, 0));
    fail();
  }
  sd_messages_free(messages);
  sd_model_free(m);
}

static void friction_needs_a_spring(void **unused) {
#define WITH(law)                                                                                  \
  VERLET "materials = ( { name = \"m\"; k_n = 1e4; gamma_n = 2.0; " law                            \
         " } );\n" GRAVITY FLOOR DISK "steps = 9;"
  advised(WITH("mu = 0.5;"), "materials.m: mu = 0.5 without k_t is no friction at all");
  advised(WITH("k_t = 500.0;"), "materials.m: k_t = 500 without mu has no effect");
  advised(WITH(""), NULL);
  advised(WITH("k_t = 500.0; mu = 0.1;"), NULL);
  advised(WITH("tangential = \"mindlin\";"), "materials.m: tangential = \"mindlin\" without k_t");
  advised(WITH("tangential = \"mindlin\"; k_t = 500.0; mu = 0.1;"), NULL);
#undef WITH
  /* of a pair, and not of materials that do not touch themselves */
#define MIXED(law)                                                                                 \
  VERLET GRAVITY                                                                                   \
      "materials = ( { name = \"m\"; k_n = 1e4; mu = 0.3; }, { name = \"w\"; k_n = 1e4; k_t = "    \
      "1.0; } );\n"                                                                                \
      "material_pairs = ( { materials = (\"m\", \"w\"); k_n = 1e4; " law " } );\n"                 \
      "disks = ( { x = 0.0; y = 1.0; radius = 1.0; mass = 1.0; material = \"m\"; } );\n"           \
      "walls = ( { type = \"line\"; points = ((0.0, 0.0), (1.0, 0.0)); material = \"w\"; } ); "    \
      "steps = 9;"
  advised(MIXED("mu = 0.5;"), "material_pairs (\"m\", \"w\"): mu = 0.5 without k_t");
  advised(MIXED("mu = 0.5; k_t = 10.0;"), NULL);
#undef MIXED
}

static void viscosity_bounds_the_step(void **unused) {
#define GEAR(gamma)                                                                                \
  "integrator = \"gear5\"; dt = 1e-3; steps = 9; materials = ( { name = \"m\"; k_n = 100; "        \
  "gamma_n = " gamma "; } );\n" FLOOR DISK
  /* 444 steps per period: unstable from gamma_n = 81.7 on */
  advised(GEAR("10.0"), NULL);
  advised(GEAR("40.0"),
          "more than 1/2.5 of the limit of stability 0.00204 (gear5, viscosity gamma_n)");
  advised(GEAR("40.0"), "or integrator = \"verlet\", whose limit is 0.0124");
#undef GEAR
}

static void the_relaxer_wants_verlet(void **unused) {
  advised("dt = 1e-3;\n" LAW GRAVITY FLOOR DISK PHASE("relax = true;"),
          "phases.p: relax = true with integrator = \"gear5\"");
  advised(DROP PHASE("relax = true;"), NULL);
}

static void goals_can_be_out_of_reach(void **unused) {
#define FRICTIONLESS VERLET "materials = ( { name = \"m\"; k_n = 1e4; } );\n" GRAVITY FLOOR DISK
#define SETTLE "settle = { kinetic = 1e-9; };"
#define SHAKE(more)                                                                                \
  "motions = ( { name = \"s\"; wall = \"floor\"; coordinate = \"y\"; type = \"harmonic\"; omega "  \
  "= "                                                                                             \
  "1.0; " more " } );\n"
  advised(
      FRICTIONLESS PHASE(SETTLE),
      "nothing takes energy out (gamma_n, restitution, mu with k_t, drag, damping): relax = true");
  advised(FRICTIONLESS PHASE("relax = true; " SETTLE), NULL);
  advised(DROP PHASE(SETTLE), NULL);
  advised(DROP SHAKE("amplitude = 0.1;") PHASE(SETTLE),
          "a motion shakes all the time: switch it off with motions = ()");
  advised(DROP SHAKE("amplitude = 0.1;") PHASE("motions = (); " SETTLE), NULL);
  advised(DROP SHAKE("amplitude = 0.0;") PHASE(SETTLE), NULL);
  advised(DROP PHASE("settle = { unbalanced = 1e-16; };"),
          "settle.unbalanced = 1e-16 is below 1.1e-13, the rounding");
  advised(DROP PHASE("settle = { unbalanced = 1e-9; };"), NULL);
}

static void compression_ends_with_settle(void **unused) {
#define BOX                                                                                        \
  VERLET LAW "box = { x = (0.0, 10.0); y = (0.0, 10.0); periodic = \"xy\"; };\n"                   \
             "packings = ( { type = \"random\"; count = 12; radius = 1.0; density = 1.0; } );\n"
  /* from 0.377 to 0.5: ln(1.326)/2 = 0.141 over the rate */
  advised(BOX PHASE("compress = { fraction = 0.5; rate = 0.01; };"),
          "phases.p: compress reaches its packing fraction after about 14.1 of 100, and the "
          "phase goes on to its end");
  advised(BOX PHASE("compress = { fraction = 0.5; rate = 0.01; }; settle = { kinetic = 1e-9; };"),
          NULL);
  advised(BOX PHASE("compress = { fraction = 0.5; rate = 0.004; };"), NULL);
  advised(BOX PHASE("compress = { pressure = 1.0; rate = 0.1; };"),
          "compress holds its pressure to the end of the phase");
  advised(BOX PHASE("compress = { pressure = 1.0; rate = 0.01; };"), NULL);
  sd_model *m =
      model_of(BOX "phases = ( { time = 1; compress = { fraction = 0.5; rate = 0.01; }; },"
                   "{ time = 1; compress = { pressure = 1.0; rate = 0.01; }; },"
                   "{ time = 1; compress = { fraction = 0.5; rate = 0.01; }; } );");
  between(sd_model_compress_time(m, 0), 14.1, 14.2, "time of compression");
  assert_true(isnan(sd_model_compress_time(m, 1)) && isnan(sd_model_compress_time(m, 2)));
  sd_model_free(m);
}

static void boxes_deform_as_they_are_told(void **unused) {
#define SHEARED(law, more, cell)                                                                   \
  VERLET "materials = ( { name = \"m\"; k_n = 1e4; " law " } );\n"                                 \
         "box = { x = (0.0, 20.0); y = (0.0, 20.0); periodic = \"xy\"; };\n"                       \
         "disks = ( { x = 3.0; y = 3.0; radius = 1.0; mass = 1.0; } );\n" more PHASE(              \
             "cell = { " cell " };")
  advised(SHEARED("", "", "rate_xy = 0.01;"), NULL);
  advised(SHEARED("", "", ""), "phases.p: cell has neither a rate nor a stress");
  advised(SHEARED("", "", "rate_xy = 0.01; max_rate = 1.0;"), "cell.max_rate has no effect");
  advised(SHEARED("", "", "rate_xy = 0.01; response = 1.0;"), "cell.response has no effect");
  advised(SHEARED("", "", "stress_yy = 1.0; max_rate = 1.0; response = 1.0;"), NULL);
  advised(SHEARED("", "", "stress_yy = -1.0;"),
          "cell.stress_yy = -1: compression is positive here");
  advised(SHEARED("cohesion = \"constant\"; pull_off = 1.0; range = 0.1;", "", "stress_yy = -1.0;"),
          NULL);
  advised(SHEARED("", "", "stress_xy = -1.0;"), NULL);
#define DRAG(more) "fields = ( { name = \"air\"; type = \"drag\"; gamma = 1.0; " more " } );\n"
#define DAMPING "fields = ( { name = \"d\"; type = \"damping\"; alpha = 0.1; } );\n"
  advised(SHEARED("", DRAG(""), "rate_xy = 0.01;"),
          "fields.air: the fluid does not shear while the box does");
  advised(SHEARED("", DRAG("shear_rate = 0.01;"), "rate_xy = 0.01;"), NULL);
  advised(SHEARED("", DRAG(""), "rate_yy = -0.001;"), NULL);
  advised(SHEARED("", DAMPING, "stress_xy = -1.0;"),
          "fields.d: damping acts against velocities in the laboratory");
  advised(SHEARED("", DAMPING, "stress_yy = 1.0;"), NULL);
}

static void deep_overlaps_throw_disks_apart(void **unused) {
#define TWO(y, more)                                                                               \
  VERLET LAW GRAVITY FLOOR                                                                         \
      "disks = ( { name = \"a\"; x = 0.0; y = 0.9999; radius = 1.0; mass = 1.0; },"                \
      "{ name = \"b\"; x = 0.0; y = " y "; radius = 1.0; mass = 0.5; } );\n" more
  advised(TWO("2.9359", "steps = 9;"), "disk \"a\" and disk \"b\" overlap by 0.064 at the start, "
                                       "0.064 of the radius: a force of 640, "
                                       "128 times the weight throws them apart");
  advised(TWO("2.995", "steps = 9;"), NULL);
  advised(TWO("2.9359", PHASE("relax = true;")), NULL);
  /* what is fixed stays, whatever the overlap */
  advised(VERLET LAW "disks = ( { x = 0.0; y = 0.0; radius = 1.0; mass = 1.0; fixed = true; },"
                     "{ x = 1.0; y = 0.0; radius = 1.0; mass = 1.0; fixed = true; } ); steps = 9;",
          NULL);
  advised(VERLET LAW GRAVITY FLOOR
          "disks = ( { x = 0.0; y = 0.95; radius = 1.0; mass = 1.0; } ); steps = 9;",
          "disk 0 and wall \"floor\" overlap by 0.05 at the start");
  /* Hertz: k_n delta^(3/2), through the edge of a periodic box */
  sd_model *m =
      model_of("integrator = \"verlet\"; dt = 1e-3; steps = 9;" GRAVITY
               "materials = ( { name = \"m\"; law = \"hertz\"; k_n = 1e4; } );"
               "box = { x = (0.0, 10.0); periodic = \"x\"; };"
               "disks = ( { x = 0.5; y = 0.0; radius = 1.0; mass = 1.0; }, { x = 8.54; y = 0.0; "
               "radius = 1.0; mass = 2.0; } );");
  first_overlap worst;
  assert_int_equal(advice_overlap(m, &worst), SD_OK);
  between(worst.depth, 0.04 - 1e-12, 0.04 + 1e-12, "overlap");
  between(worst.force, 80 - 1e-9, 80 + 1e-9, "force");
  between(worst.weight, 10, 10, "weight");
  sd_model_free(m);
}

static void watched_contacts_touch(void **unused) {
#define WATCH(x)                                                                                   \
  VERLET LAW GRAVITY FLOOR                                                                         \
      "disks = ( { name = \"a\"; x = 0.0; y = 1.0; radius = 1.0; mass = 1.0; },"                   \
      "{ name = \"b\"; x = " x "; y = 1.0; radius = 1.0; mass = 0.5; } );\n"                       \
      "steps = 9; "                                                                                \
      "measure = { sliding = ( { disk = \"a\"; partners = (\"floor\", \"b\"); } ); };"
  advised(WATCH("2.05"), NULL);
  advised(WATCH("3.5"),
          "measure.sliding: disk \"a\" and disk \"b\" do not touch at the start: there are 1.5 "
          "between them, 1.5 radii");
  advised(VERLET LAW GRAVITY FLOOR DISK "steps = 9; measure = { configurations = true; };",
          "measure.configurations = true without measure.sliding has no effect");
}

/* Walls that are twice in one point. Where the same motions move two whose ends meet they are one wall there. */
static void walls_are_touched_once(void **unused) {
#define WALLS(a, b, x, y)                                                                          \
  VERLET LAW "walls = ( { name = \"a\"; " a " }, { name = \"b\"; " b " } );"                       \
             "disks = ( { x = " x "; y = " y "; radius = 0.1; mass = 1.0; } ); steps = 9;"
#define PIECE(from, to) "type = \"segment\"; points = (" from ", " to ");"
#define MOVE(walls, along)                                                                         \
  "motions = ( { wall = " walls "; coordinate = \"" along                                          \
  "\"; type = \"velocity\"; velocity = 0.1; } );"
#define LEFT PIECE("(-1.0, 0.0)", "(0.0, 0.0)")
#define RIGHT PIECE("(0.0, 0.0)", "(1.0, 0.0)")
#define UP PIECE("(0.0, 1.0)", "(0.0, 0.0)")
#define MEETS "wall \"a\" meets wall \"b\" at (0, 0): they move apart"
  advised(WALLS(LEFT, RIGHT, "0.5", "0.5"), NULL);
  advised(WALLS(LEFT, RIGHT, "0.5", "0.5") MOVE("(\"a\", \"b\")", "y"), NULL);
  advised(WALLS(LEFT, RIGHT, "0.5", "0.5") MOVE("\"a\"", "y"), MEETS);
  advised(WALLS(RIGHT, UP, "0.5", "0.5") MOVE("\"b\"", "y"), NULL);
  advised(WALLS(RIGHT, UP, "-0.5", "0.5") MOVE("\"b\"", "y"), MEETS);
  advised(WALLS(RIGHT, UP, "-0.5", "0.5"), NULL);
  advised(WALLS(LEFT, RIGHT, "0.5", "0.5") MOVE("\"a\"", "surface"),
          NULL); /* a belt runs, its wall stays */
  /* a post on a floor, and one under it */
#define POST(to) PIECE("(0.2, 0.0)", to)
#define FLAT "type = \"line\"; points = ((-1.0, 0.0), (1.0, 0.0));"
#define BENT "type = \"polyline\"; points = ((-1.0, 0.0), (0.2, 0.0), (1.0, -1.0));"
#define ROUND "type = \"circle\"; center = (0.2, 1.0); radius = 1.0; side = \"inside\";"
#define BOWL "type = \"arc\"; center = (0.2, 1.0); radius = 1.0; from = -2.0; to = -1.0;"
#define ENDS "wall \"a\" ends on wall \"b\" at (0.2, 0): a disk on its other side"
  advised(WALLS(POST("(0.2, 1.0)"), FLAT, "0.5", "0.5"), NULL);
  advised(WALLS(POST("(0.2, -1.0)"), FLAT, "0.5", "0.5"), ENDS);
  advised(WALLS(POST("(0.9, 0.0)"), FLAT, "0.5", "0.5"),
          "\"b\" at (0.2, 0) (and 1 more): a disk on its");
  advised(WALLS(POST("(0.2, -1.0)"), BENT, "0.5", "0.5"), ENDS);
  advised(WALLS(POST("(0.2, -1.0)"), ROUND, "0.5", "0.9"), ENDS);
  advised(WALLS(POST("(0.2, -1.0)"), BOWL, "0.5", "0.9"), ENDS);
  advised(WALLS(POST("(0.2, 0.4)"), BOWL, "0.5", "0.9"), NULL);
  advised(WALLS(POST("(0.2, -1.0)"), PIECE("(0.2, 0.0)", "(1.0, 0.0)"), "0.5", "0.5"), NULL);
#undef WALLS
#undef MOVE
#undef LEFT
#undef RIGHT
}

/* Motions that begin with a jump, go far in a step, or are too fast for it; u(0) = 0, a ramp, and surfaces are the usual. */
static void motions_suit_the_step(void **unused) {
#define MOVED(what)                                                                                \
  VERLET LAW GRAVITY FLOOR DISK "steps = 9; motions = ( { name = \"m\"; wall = \"floor\"; " what   \
                                " } );"
#define WAVE(type, more)                                                                           \
  "coordinate = \"y\"; type = \"" type "\"; amplitude = 0.05; omega = 6.0; " more
#define JUMPS "motion \"m\" begins with a jump by 0.05 radii of the smallest disk"
  advised(MOVED(WAVE("harmonic", "")), NULL);
  advised(MOVED(WAVE("harmonic", "phase = \"pi\";")), NULL);
  advised(MOVED(WAVE("harmonic", "phase = \"0.5 pi\";")), JUMPS);
  advised(MOVED(WAVE("harmonic", "phase = \"0.5 pi\"; ramp = 1.0;")), NULL);
  advised(MOVED(WAVE("parabolic", "phase = \"0.5 pi\";")), JUMPS);
  advised(MOVED(WAVE("triangle", "phase = \"-0.5 pi\";")), JUMPS);
  advised(MOVED(WAVE("square", "rise = 0.1; phase = \"0.5 pi\";")), JUMPS);
  advised(MOVED(WAVE("square", "rise = 0.1;")), NULL);
  advised(MOVED(WAVE("random", "")), "begins with a jump by up to 0.15 radii");
  advised(MOVED(WAVE("random", "ramp = 1.0;")), NULL);
  advised(MOVED("coordinate = \"surface\"; type = \"harmonic\"; amplitude = 0.05; omega = 6.0; "
                "phase = \"0.5 pi\";"),
          NULL);
#define TABLE(times, values)                                                                       \
  "coordinate = \"y\"; type = \"table\"; times = (" times "); values = (" values ");"
  advised(MOVED(TABLE("0.0, 1.0, 2.0", "0.0, 0.05, 0.0")), NULL);
  advised(MOVED(TABLE("0.0, 1.0, 2.0", "0.05, 0.0, 0.0")), JUMPS);
  advised(MOVED(TABLE("-1.0, 1.0, 2.0", "0.1, 0.0, 0.0")), JUMPS);
  advised(MOVED(TABLE("1.0, 1.0001, 2.0", "0.0, 0.5, 0.5")),
          "moves by up to 0.5 radii of the smallest disk in a step");
  advised(MOVED("coordinate = \"y\"; type = \"velocity\"; velocity = 90.0;"), NULL);
  advised(MOVED("coordinate = \"y\"; type = \"velocity\"; velocity = -4000.0;"),
          "motion \"m\": wall \"floor\" moves by up to 4 radii of the smallest disk in a step");
#undef MOVED
#define MOVED(what)                                                                                \
  VERLET LAW GRAVITY FLOOR DISK "steps = 9; limits = { displacement = 0; }; motions = ( { name = " \
                                "\"m\"; wall = \"floor\"; " what " } );"
  advised(MOVED("coordinate = \"y\"; type = \"velocity\"; velocity = -4000.0;"), NULL);
#undef MOVED
#define MOVED(what)                                                                                \
  VERLET LAW GRAVITY FLOOR DISK "steps = 9; motions = ( { name = \"m\"; wall = \"floor\"; " what   \
                                " } );"
  advised(MOVED("coordinate = \"y\"; type = \"servo\"; force = 1.0; speed = 200.0;"),
          "moves by up to 0.2 radii");
  advised(MOVED("coordinate = \"theta\"; type = \"velocity\"; velocity = 500.0;"),
          "moves by up to 0.25 radii");
  advised(MOVED("coordinate = \"surface\"; type = \"velocity\"; velocity = 500.0;"), NULL);
  advised(MOVED("coordinate = \"y\"; type = \"harmonic\"; amplitude = 1e-3; frequency = 100.0;"),
          "a cycle takes 10 steps");
#undef MOVED
}

/* Prescribed bodies that run into one another beside a free disk; alone they feel each other (test_prescribed). */
static void prescribed_bodies_pass_each_other(void **unused) {
#define BESIDE(x, more)                                                                            \
  VERLET LAW                                                                                       \
      "disks = ( { name = \"a\"; x = 0.0; y = 0.0; radius = 0.5; mass = 1.0; fixed = true; },"     \
      "{ name = \"b\"; x = " x "; y = 0.0; radius = 0.5; mass = 1.0; fixed = true; },"             \
      "{ x = 9.0; y = 9.0; radius = 0.5; mass = 1.0; } ); steps = 1000; " more
#define LEADS(body, what) "motions = ( { disk = " body "; coordinate = \"x\"; type = " what " } );"
#define BOTH "disk \"a\" and disk \"b\" are both prescribed, and motions bring them to overlap by"
  advised(BESIDE("1.1", LEADS("\"b\"", "\"velocity\"; velocity = -0.2;")), BOTH);
  advised(BESIDE("1.1", LEADS("\"b\"", "\"velocity\"; velocity = 0.2;")), NULL);
  advised(BESIDE("1.1", LEADS("(\"a\", \"b\")", "\"velocity\"; velocity = -0.2;")), NULL);
  advised(BESIDE("1.1", LEADS("\"b\"", "\"harmonic\"; amplitude = 0.2; omega = 20.0;")), BOTH);
  advised(BESIDE("1.0", LEADS("\"b\"", "\"harmonic\"; amplitude = 1e-3; omega = 20.0;")), NULL);
  advised(BESIDE("0.6", LEADS("\"a\"", "\"harmonic\"; amplitude = 1e-3; omega = 20.0;")),
          NULL); /* a rough floor */
  advised(BESIDE("0.6", ""), NULL);
  advised(
      BESIDE("2.0",
             "walls = ( { name = \"w\"; type = \"line\"; points = ((0.0, -0.6), (1.0, -0.6)); } );"
             "motions = ( { wall = \"w\"; coordinate = \"y\"; type = \"velocity\"; velocity = 0.2; "
             "} );"),
      "disk \"a\" and wall \"w\" are both prescribed");
#undef BESIDE
#undef LEADS
#undef BOTH
}

/* Gravity along a periodic axis, and what holds disks there. */
static void falls_come_to_an_end(void **unused) {
#define CHUTE(periodic, gravity, disk, more)                                                       \
  VERLET LAW "box = { x = (0.0, 9.0); y = (0.0, 9.0); periodic = \"" periodic "\"; }; " gravity    \
             "disks = ( { x = 4.0; y = 4.0; radius = 0.5; mass = 1.0; " disk                       \
             " } ); steps = 9; " more
#define DOWN "gravity = { g = 10.0; };"
#define TILTED "gravity = { g = 10.0; tilt = 0.3; };"
#define WALL(points) "walls = ( { type = \"line\"; points = " points "; } );"
#define FALLS                                                                                      \
  "gravity: the box repeats along y, and nothing there holds the disks: they fall for ever"
  advised(CHUTE("xy", DOWN, "", ""), FALLS);
  advised(CHUTE("y", DOWN, "", ""), FALLS);
  advised(CHUTE("x", DOWN, "", ""), NULL);
  advised(CHUTE("xy", "", "", ""), NULL);
  advised(CHUTE("x", TILTED, "", ""), "gravity: the box repeats along x");
  advised(CHUTE("x", TILTED, "", WALL("((0.0, 0.5), (9.0, 0.5))")),
          NULL); /* flow down an incline */
  advised(CHUTE("y", DOWN, "", WALL("((0.5, 0.0), (0.5, 9.0))")),
          NULL); /* rough walls of a chute */
  advised(CHUTE("xy", DOWN, "force = (0.0, 10.0);", ""), NULL);
  advised(CHUTE("xy", "", "force = (3.0, 0.0);", ""), "force: the box repeats along x");
  advised(CHUTE("xy", DOWN, "locked = \"y\";", ""), NULL);
  advised(CHUTE("xy", DOWN, "", "fields = ( { type = \"drag\"; gamma = 1.0; } );"), NULL);
  advised(CHUTE("xy", DOWN, "", "fields = ( { type = \"damping\"; alpha = 0.5; } );"), FALLS);
#undef LAW
#define LAW "materials = ( { name = \"m\"; k_n = 1e4; } );\n"
  advised(CHUTE("y", DOWN, "", WALL("((0.5, 0.0), (0.5, 9.0))")), FALLS);
  advised(CHUTE("x", TILTED, "", WALL("((0.0, 0.5), (9.0, 0.5))")),
          "gravity: the box repeats along x");
#undef CHUTE
#undef LAW
#define LAW "materials = ( { name = \"m\"; k_n = 1e4; k_t = 5e3; gamma_n = 2.0; mu = 0.5; } );\n"
}

/* Walls of all shapes, moved and turned. */
static void gaps_are_those_between_surfaces(void **unused) {
  sd_model *m =
      model_of(VERLET LAW
               "steps = 9; disks = ( { x = 0.0; y = 3.0; radius = 1.0; mass = 1.0; } );"
               "walls = ( { type = \"line\"; points = ((5.0, 0.0), (6.0, 0.0)); },"
               "{ type = \"segment\"; points = ((3.0, 3.0), (4.0, 3.0)); },"
               "{ type = \"circle\"; center = (0.0, 2.0); radius = 5.0; side = \"inside\"; },"
               "{ type = \"circle\"; center = (0.0, 10.0); radius = 2.0; side = \"outside\"; } );");
  static const double gaps[] = {2, 2, 3, 4};
  for (uint32_t w = 0; w < 4; w++)
    between(overlaps_first_gap(m, 0, 1 + w), gaps[w] - 1e-12, gaps[w] + 1e-12, "gap");
  const double x[2] = {0, 3}, turned[3] = {3.5, 3, M_PI / 2}, moved[3] = {5.5, 1, 0};
  between(overlaps_gap(m, 0, x, 1, moved), 1 - 1e-12, 1 + 1e-12, "gap to a line that has moved");
  between(overlaps_gap(m, 0, x, 2, turned), 2.5 - 1e-12, 2.5 + 1e-12,
          "gap to a segment that has turned");
  sd_model_free(m);
}

RUN_TESTS(TEST(friction_needs_a_spring), TEST(viscosity_bounds_the_step),
          TEST(the_relaxer_wants_verlet), TEST(goals_can_be_out_of_reach),
          TEST(compression_ends_with_settle), TEST(boxes_deform_as_they_are_told),
          TEST(deep_overlaps_throw_disks_apart), TEST(watched_contacts_touch),
          TEST(walls_are_touched_once), TEST(gaps_are_those_between_surfaces),
          TEST(motions_suit_the_step), TEST(prescribed_bodies_pass_each_other),
          TEST(falls_come_to_an_end))

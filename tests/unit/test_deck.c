/* test_deck.c: what decks say arrives in the model, the echo gives the same model again, -D does what it says. */
#include <unistd.h>

#include <glob.h>

#include "unit.h"
#include "model/keys.h"
#include "model/model.h"
#include "io/store/h5.h"
#include "model/state.h"
#include "slipdisk/deck.h"

static sd_messages *messages;

static sd_model *load(const char *text, size_t n, const char *const *overrides) {
  sd_model *m = NULL;
  sd_messages_free(messages);
  messages = sd_messages_new();
  sd_status status = sd_deck_load_text(text, "test.cfg", n, overrides, &m, messages);
  assert_true((status == SD_OK) == (m != NULL));
  assert_true((status == SD_OK) == (sd_messages_errors(messages) == 0));
  return m;
}

static sd_model *good(const char *text) {
  sd_model *m = load(text, 0, NULL);
  if (!m) sd_messages_print(messages, stderr);
  assert_non_null(m);
  return m;
}

/* The deck must fail, with a message that holds these words. */
static void bad(const char *text, const char *words) {
  assert_null(load(text, 0, NULL));
  for (size_t k = 0; k < sd_messages_count(messages); k++)
    if (strstr(sd_messages_text(messages, k), words)) return;
  print_error("expected a message with: %s\n", words);
  sd_messages_print(messages, stderr);
  fail();
}

#define HEAD "dt = 1e-3; steps = 10; materials = ( { name = \"m\"; k_n = 10; } );\n"
#define DISK "disks = ( { name = \"a\"; x = 0; y = 0; radius = 1; mass = 2; } );\n"

static const char *const three =
    "dt = 1e-3; time = 2;\n"
    "gravity = { g = 10; tilt = \"30 deg\"; };\n"
    "materials = ( { name = \"m\"; k_n = 10; k_t = 5; gamma_n = 1; mu = 0.25; } );\n"
    "disks = ( { name = \"a\"; x = 0; y = 0; radius = 1; mass = 2; group = \"g\"; },\n"
    "  { name = \"b\"; x = 3; y = 0; theta = \"pi/2\"; radius = 1; density = 1; group = \"g\"; "
    "fixed = true; },\n"
    "  { x = 6; y = 1; omega = \"2 pi\"; radius = 0.5; mass = 1; locked = [\"x\"]; force = (1, "
    "2); torque = 3; } );\n"
    "walls = ( { name = \"w\"; type = \"segment\"; points = ( (0, -2), (4, -2) ); } );\n"
    "forces = ( { disk = [\"a\", 2]; force = (1, 1); } );\n"
    "locks = ( { group = \"g\"; coordinates = \"theta\"; } );\n"
    "motions = ( { name = \"r\"; disk = [\"b\", \"a\"]; coordinate = [\"x\", \"y\"]; type = "
    "\"random\"; amplitude = 0.1;\n"
    "              omega = \"20 pi\"; },\n"
    "  { group = \"g\"; coordinate = \"x\"; type = \"random\"; amplitude = 0.1; frequency = 2; "
    "},\n"
    "  { wall = \"w\"; coordinate = \"theta\"; type = \"table\"; times = (0, 1, 2); values = (0, "
    "0.5, 0); periodic = true; } );\n"
    "measure = { sliding = ( { disk = 2; partners = [\"a\", \"w\"]; } ); };\n";

static void test_values(void **state) {
  sd_model *m = good(three);
  assert_int_equal(m->n_phases, 1);
  assert_int_equal(m->phases[0].steps, 2000);
  assert_true(m->phases[0].measure);
  assert_int_equal(m->phases[0].series_every, 2);
  assert_true(fabs(m->gravity[0] + 5) < 1e-14 && fabs(m->gravity[1] + 10 * cos(M_PI / 6)) < 1e-14);
  assert_int_equal(m->n_disks, 3);
  assert_int_equal(m->n_free, 1); /* a is locked in theta and moved in x and y */
  assert_true(m->disks[1].driven && m->disks[1].position[2] == M_PI / 2);
  assert_true(m->disks[1].mass == M_PI && m->disks[0].inertia == 1.0);
  assert_true(m->disks[2].velocity[2] == 2 * M_PI && m->disks[2].locked[SD_X] &&
              !m->disks[2].locked[SD_Y]);
  assert_true(m->disks[2].force[0] == 2 && m->disks[2].force[1] == 3 && m->disks[2].force[2] == 3);
  assert_true(m->disks[0].locked[SD_THETA] && m->disks[0].group == 0 && m->disks[2].group == -1);
  assert_true(m->walls[0].pivot[0] == 2 && m->walls[0].pivot[1] == -2);
  assert_true(m->laws[0].gamma_n == 1 && m->laws[0].mu == 0.25);
  /* a and b, x and y; the group as one; the wall */
  assert_int_equal(m->n_motions, 6);
  for (size_t k = 0; k < 5; k++)
    for (size_t j = 0; j < k; j++) assert_int_not_equal(m->motions[k].stream, m->motions[j].stream);
  assert_int_equal(m->motions[4].n_bodies, 2);
  assert_true(m->motions[0].omega == 20 * M_PI && m->motions[0].damping == 0.5);
  assert_int_equal(m->motions[5].bodies[0], 3);
  assert_int_equal(m->n_rotations, 1);
  assert_int_equal(m->slides[0].partner[1], 3);
  sd_model_free(m);
}

/* locks = ( { except = ...; } ): named disks and groups keep moving. */
static void test_locks_except(void **state) {
  static const struct {
    const char *except;
    unsigned turning; /* bit i: disk i may turn */
  } cases[] = {{"()", 0},
               {"2", 4},
               {"(0, 3)", 9},
               {"\"b\"", 2},
               {"(\"few\", \"b\", 1)", 14},
               {"(\"all\", \"few\")", 15}};
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    char text[900];
    snprintf(text, sizeof text,
             HEAD
             "disk_rows = ( { columns = (\"x\", \"y\", \"radius\", \"name\", \"group\"); mass = 1; "
             "rows = (\n"
             "(0, 0, 1, \"a\", \"all\"), (3, 0, 1, \"b\", \"all\"), (6, 0, 1, \"c\", \"few\"), "
             "(9, 0, 1, \"d\", \"few\") ); } );\n"
             "locks = ( { group = (\"all\", \"few\"); except = %s; coordinates = \"theta\"; } );",
             cases[k].except);
    sd_model *m = good(text);
    for (unsigned i = 0; i < 4; i++) {
      assert_int_equal(m->disks[i].locked[SD_THETA], !(cases[k].turning >> i & 1));
      assert_false(m->disks[i].locked[SD_X] || m->disks[i].locked[SD_Y]);
    }
    sd_model_free(m);
  }
}

/* The stream of a motion does not depend on what else the deck moves. */
static void test_streams(void **state) {
  const char *one = HEAD DISK "motions = ( { disk = \"a\"; coordinate = \"y\"; type = \"random\"; "
                              "amplitude = 1; frequency = 1; } );";
  const char *two = HEAD DISK
      "motions = ( { disk = \"a\"; coordinate = \"x\"; type = \"random\"; amplitude = 1; frequency "
      "= 1; },"
      "{ disk = \"a\"; coordinate = \"y\"; type = \"random\"; amplitude = 1; frequency = 1; },"
      "{ disk = \"a\"; coordinate = \"y\"; type = \"random\"; amplitude = 1; frequency = 1; } );";
  sd_model *a = good(one), *b = good(two);
  assert_int_equal(a->motions[0].stream, b->motions[1].stream);
  assert_int_not_equal(b->motions[1].stream, b->motions[2].stream);
  sd_model_free(a);
  sd_model_free(b);
}

/* What libconfig lets through or cuts. */
static void test_numbers(void **state) {
  sd_model *m =
      good("dt = 1; integrator = \"verlet\"; steps = 5e8; seed = 5000000000; box = { x = [0, "
           "10.5]; y = [0, 0x10]; };"
           "materials = ( { name = \"m\"; k_n = .01; } );" DISK);
  assert_true(m->seed == 5000000000u && m->phases[0].steps == 500000000 && m->dt == 1.0);
  assert_true(m->upper[0] == 10.5 && m->upper[1] == 16.0);
  sd_model_free(m);
  m = good("dt = .5; steps = 9223372036854775807L; materials = ( { name = \"m\"; k_n = +1.e1; } "
           ");" DISK);
  assert_true(m->phases[0].steps == INT64_MAX && m->laws[0].k_n == 10);
  sd_model_free(m);
  bad(HEAD DISK "skin = 1e400;", "test.cfg:3: skin = 1e400: number too large");
  bad(HEAD DISK "seed = 99999999999999999999;", "integer beyond 64 bits");
  bad(HEAD DISK "seed = 2.5;", "seed = 2.5: expected a whole number");
  bad(HEAD DISK "skin = 1e-400;", "too small");
  bad(HEAD DISK "skin = 1.2.3;", "a comma or an operator is missing before \".3\"");
  bad(HEAD DISK "skin = 10kg;", "\"kg\": units are not written");
  bad(HEAD DISK "skin = nan;", "expected a number, or quotes around a constant");
}

static void test_form(void **state) {
  bad(HEAD "/* never closed\n\n" DISK, "test.cfg:2: the comment that begins here");
  bad(HEAD "title = \"open;\n" DISK, "test.cfg:2: title = the text \"open; is not closed");
  assert_int_equal(sd_messages_errors(messages), 1);
  bad("disks = ( { name = \"a; x = 0; },\n { name = \"b\"; } );\n", "is not closed");
  assert_int_equal(sd_messages_errors(messages), 1);
  bad(HEAD DISK "gravity = { g = 1;", "test.cfg:3: the { of this line is never closed");
  bad(HEAD DISK "gravity = { g = 1; );", "where the { of line 3");
  bad(HEAD DISK "skin = 1;\nskin = 2;\nskin = 3;",
      "test.cfg:5: skin: key given twice; first on line 3");
  assert_int_equal(sd_messages_errors(messages), 2);
  bad(HEAD DISK "gravty = { g = 1; };", "did you mean \"gravity\"?");
  bad(HEAD DISK "gravity = { G = 1; };", "did you mean \"g\"?");
  bad(HEAD DISK "gravity = { strength = 1; };", "unknown key of gravity; expected g or tilt");
  bad(HEAD DISK "@include \"nothing.cfg\"\n", "nothing.cfg");
  bad(HEAD DISK "skin = ;", "test.cfg:3:");
  bad("", "missing");
  bad(HEAD DISK "title = harmless;", "a text needs quotes: \"harmless\"");
}

static void test_overlaps(void **state) {
  const char *same =
      HEAD "disk_rows = ( { columns = [\"x\", \"y\"]; radius = 1; mass = 1; rows = (\n(0, 0), "
           "(5, 5),\n(0, 0)); } );";
  bad(same, "test.cfg:4: disk 2 and disk 0 have the same centre");
  const char *deep =
      HEAD "disk_rows = ( { columns = [\"x\", \"y\", \"radius\"]; mass = 1; rows = ((0, 0, "
           "10), (0, 10.2, 1)); } );";
  bad(deep, "overlap by 0.8");
  bad(HEAD DISK "walls = ( { name = \"w\"; type = \"line\"; points = ((0, 0.2), (1, 0.2)); } );",
      "disk \"a\" sits 0.8 deep in wall \"w\"");
  bad(HEAD "box = { x = (0, 20); periodic = \"x\"; };"
           "disk_rows = ( { columns = [\"x\", \"y\"]; radius = 1; mass = 1; rows = ((0.1, 0), "
           "(19.9, 0)); } );",
      "overlap by 1.8");
  bad(HEAD
      "box = { x = (0, 20); periodic = \"x\"; };" DISK
      "disk_rows = ( { columns = [\"x\"]; y = 9; radius = 1; mass = 1; rows = ((-1), (25)); } );",
      "outside the periodic box");
  bad(HEAD "box = { x = (0, 4); periodic = \"x\"; }; disk_rows = ( { columns = [\"x\"]; y = 0; "
           "radius = 0.1; "
           "mass = 1; rows = ((5), (6), (7), (8), (9), (10), (11), (12), (13), (14), (15)); } );",
      "3 more coordinates lie outside the periodic box");
  /* a file that cannot be read is one mistake, not one per disk that it should have given */
  bad(HEAD "disk_files = ( { file = \"nothing.csv\"; mass = 1; } ); measure = { rotation = 3; };",
      "rotation = 3: no disk has this number; expected none (not all disks could be read, see "
      "above)");
  /* two fixed ones may overlap */
  sd_model_free(
      good(HEAD "disk_rows = ( { columns = [\"x\"]; y = 0; radius = 1; mass = 1; fixed = true; "
                "rows = ((0), (0.1)); } );"));
}

static void test_laws(void **state) {
  bad("dt = 1e-3; steps = 1; materials = ( { name = \"a\"; k_n = 1; }, { name = \"b\"; k_n = 1; "
      "} );"
      "disks = ( { x = 0; y = 0; radius = 1; mass = 1; material = \"a\"; }, { x = 5; y = 0; "
      "radius = 1; mass = 1; material = \"b\"; } );",
      "materials \"a\" and \"b\" can touch");
}

static void test_overrides(void **state) {
  const char *const overrides[] = {"gravity.tilt=0.02 pi",
                                   "motions[*].ramp=0.5",
                                   "motions.r.amplitude=7",
                                   "steps=5e9",
                                   "disks.[1].mass=4",
                                   "integrator=verlet",
                                   "seed = 12"};
  sd_model *m = load(three, sizeof overrides / sizeof *overrides, overrides);
  if (!m) sd_messages_print(messages, stderr);
  assert_non_null(m);
  assert_true(fabs(m->gravity[0] + 10 * sin(0.02 * M_PI)) < 1e-15);
  assert_true(m->motions[0].ramp == 0.5 && m->motions[5].ramp == 0.5 &&
              m->motions[0].amplitude == 7);
  assert_true(m->phases[0].steps == 5000000000 && m->disks[1].mass == 4);
  assert_int_equal(m->integrator, SD_VERLET);
  assert_string_equal(sd_model_deck(m)->text, three);
  assert_non_null(strstr(sd_model_deck(m)->overrides, "motions[*].ramp=0.5\n"));
  sd_model_free(m);
  const char *const wrong[] = {"gravty.tilt=1", "motions[9].ramp=1", "dt=1e400", "nonsense"};
  assert_null(load(three, 4, wrong));
  assert_int_equal(sd_messages_errors(messages), 4);
}

static char folder[] = "/tmp/slipdisk-deck-XXXXXX";

static const char *write_file(const char *name, const char *text) {
  static char path[256];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  FILE *out = fopen(path, "w");
  assert_non_null(out);
  fputs(text, out);
  fclose(out);
  return path;
}

static void test_files(void **state) {
  write_file("disks.csv", "# comment\nid, r, x, y, name\n\n1, 0.5, 1, 2, p\n2, 0.25, 4, 5e0, q\n");
  write_file("wave.csv", "value,time\n0,0\n1,1\n0,2\n");
  write_file("part.cfg", "# a part\nskin = 0.5;\ngravity = { g = nine; };\n");
  double xyr[2][3] = {{10, 0, 0.5}, {12, 0, 0.75}};
  h5_file *file;
  char path[256];
  const char *const columns[] = {"x", "y", "radius"};
  snprintf(path, sizeof path, "%s/disks.h5", folder);
  assert_int_equal(h5_new(&file, NULL), SD_OK);
  h5_put(file, "/grains", SD_F64, 2, (size_t[]){2, 3}, xyr, false);
  h5_attr_texts(file, "/grains", "columns", 3, columns);
  assert_int_equal(h5_save(file, -1, path, NULL, NULL), SD_OK);
  const char *deck = write_file(
      "deck.cfg", HEAD "disk_files = ( { file = \"disks.csv\"; mass = 1; columns = [\"x\", \"y\", "
                       "\"radius = r\", \"name\"]; },\n"
                       "  { file = \"disks.h5\"; dataset = \"/grains\"; density = 1; } );\n"
                       "motions = ( { disk = \"q\"; coordinate = \"x\"; type = \"table\"; file = "
                       "\"wave.csv\"; factor = 2; } );\n");
  sd_messages_free(messages);
  messages = sd_messages_new();
  sd_model *m, *again;
  sd_status status = sd_deck_load(deck, 0, NULL, &m, messages);
  sd_messages_print(messages, stderr);
  assert_int_equal(status, SD_OK);
  assert_int_equal(m->n_disks, 4);
  assert_true(m->disks[1].radius == 0.25 && m->disks[1].position[1] == 5 &&
              m->disks[3].position[0] == 12);
  assert_string_equal(m->disks[1].name, "q");
  assert_true(m->motions[0].n_table == 3 && m->motions[0].table_value[1] == 1 &&
              m->motions[0].amplitude == 2);
  /* the echo needs no files */
  assert_int_equal(
      sd_deck_load_text(sd_model_deck(m)->full, "elsewhere/deck.cfg", 0, NULL, &again, messages),
      SD_OK);
  assert_true(again->n_disks == 4 && again->disks[3].mass == m->disks[3].mass &&
              again->motions[0].n_table == 3);
  sd_model_free(again);
  sd_model_free(m);
  /* messages name the included file, and the lines after it are still right */
  deck = write_file("with.cfg", HEAD "@include \"part.cfg\"\ndisks = ();\nsede = 1;\n");
  assert_int_equal(sd_deck_load(deck, 0, NULL, &m, messages), SD_ERROR_USER);
  bool part = false, rest = false;
  for (size_t k = 0; k < sd_messages_count(messages); k++) {
    part |= strstr(sd_messages_text(messages, k), "part.cfg:3: gravity.g = nine") != NULL;
    rest |= strstr(sd_messages_text(messages, k), "with.cfg:4: sede = 1") != NULL;
  }
  assert_true(part && rest);
  /* the deck as it is kept in results holds what was included */
  sd_messages_free(messages);
  messages = sd_messages_new();
  write_file("part.cfg", "skin = 0.5;");
  deck = write_file("with.cfg", HEAD "  @include \"part.cfg\" # why\n" DISK);
  assert_int_equal(sd_deck_load(deck, 0, NULL, &m, messages), SD_OK);
  assert_int_equal(
      sd_deck_load_text(sd_model_deck(m)->text, "elsewhere/with.cfg", 0, NULL, &again, messages),
      SD_OK);
  assert_true(m->skin == 0.5 && again->skin == 0.5);
  assert_string_equal(sd_model_deck(m)->text, sd_model_deck(again)->text);
  sd_model_free(again);
  sd_model_free(m);
}

static void without_marks(char *text) {
  for (char *mark; (mark = strstr(text, "  # default"));)
    memmove(mark, mark + 11, strlen(mark + 11) + 1);
}

static void same_motions(const sd_model *a, const sd_model *b) {
  assert_int_equal(a->n_motions, b->n_motions);
  for (size_t k = 0; k < a->n_motions; k++) {
    const sd_motion *p = &a->motions[k], *q = &b->motions[k];
    assert_true(p->kind == q->kind && p->coordinate == q->coordinate && p->stream == q->stream &&
                p->n_bodies == q->n_bodies);
    assert_memory_equal(p->bodies, q->bodies, p->n_bodies * sizeof *p->bodies);
    assert_true(p->amplitude == q->amplitude && p->omega == q->omega && p->phase == q->phase &&
                p->velocity == q->velocity);
    assert_true(p->damping == q->damping && p->interval == q->interval && p->ramp == q->ramp);
  }
}

static void same_model(const sd_model *a, const sd_model *b) {
  assert_true(a->seed == b->seed && a->dt == b->dt && a->skin == b->skin &&
              a->max_overlap == b->max_overlap);
  assert_memory_equal(a->gravity, b->gravity, sizeof a->gravity);
  assert_int_equal(a->n_materials, b->n_materials);
  assert_memory_equal(a->laws, b->laws, a->n_materials * a->n_materials * sizeof *a->laws);
  assert_int_equal(a->n_disks, b->n_disks);
  for (size_t k = 0; k < a->n_disks; k++) {
    sd_disk p = a->disks[k], q = b->disks[k];
    assert_memory_equal(p.position, q.position, sizeof p.position);
    assert_memory_equal(p.velocity, q.velocity, sizeof p.velocity);
    assert_memory_equal(p.force, q.force, sizeof p.force);
    assert_true(p.radius == q.radius && p.mass == q.mass && p.inertia == q.inertia &&
                p.driven == q.driven);
    assert_true(p.material == q.material && p.group == q.group &&
                !memcmp(p.locked, q.locked, sizeof p.locked));
  }
  assert_int_equal(a->n_walls, b->n_walls);
  assert_int_equal(a->n_segments, b->n_segments);
  if (a->n_segments)
    assert_memory_equal(a->segments, b->segments, a->n_segments * sizeof *a->segments);
  same_motions(a, b);
  assert_int_equal(a->n_phases, b->n_phases);
  for (size_t k = 0; k < a->n_phases; k++) {
    const sd_phase *p = &a->phases[k], *q = &b->phases[k];
    assert_true(p->steps == q->steps && p->measure == q->measure &&
                p->series_every == q->series_every);
    assert_true(p->frames_every == q->frames_every && p->contacts_every == q->contacts_every);
    if (a->n_motions) assert_memory_equal(p->active, q->active, a->n_motions * sizeof *p->active);
  }
  assert_true(a->n_rotations == b->n_rotations && a->n_slides == b->n_slides);
}

static void round_trip(const char *path) {
  /* thousands of disks over two decades take longer to place, twice, than all other decks */
  static const char *const fewer[] = {"packings[0].count=600"};
  const size_t n = strstr(path, "/decades.cfg") ? 1 : 0;
  sd_model *a = NULL, *b = NULL;
  sd_messages_free(messages);
  messages = sd_messages_new();
  sd_status status = sd_deck_load(path, n, fewer, &a, messages);
  sd_messages_print(messages, stderr);
  assert_int_equal(status, SD_OK);
  assert_int_equal(sd_messages_count(messages), 0);
  status = sd_deck_load_text(sd_model_deck(a)->full, path, 0, NULL, &b, messages);
  sd_messages_print(messages, stderr);
  assert_int_equal(status, SD_OK);
  same_model(a, b);
  without_marks(sd_model_deck(a)->full);
  without_marks(sd_model_deck(b)->full);
  assert_string_equal(sd_model_deck(a)->full, sd_model_deck(b)->full);
  /* short enough against the fastest contact */
  assert_true(a->dt < sd_model_shortest_period(a, NULL) / 20);
  sd_model_free(a);
  sd_model_free(b);
}

static void test_shipped(void **state) {
  glob_t found;
  assert_int_equal(glob(SLIPDISK_SOURCE_DIR "/inputs/*/*.cfg", 0, NULL, &found), 0);
  assert_true(found.gl_pathc >= 13);
  /* those that begin with what other runs make cannot be read before that is there; test_cookbook runs the cookbook's */
  for (size_t k = 0; k < found.gl_pathc; k++)
    if (!strstr(found.gl_pathv[k], "/shake_1e") && !strstr(found.gl_pathv[k], "/cage_") &&
        !strstr(found.gl_pathv[k], "/cookbook/"))
      round_trip(found.gl_pathv[k]);
  globfree(&found);
}

static void test_round_trip(void **state) { round_trip(write_file("three.cfg", three)); }

/* Those of the list before those of packings; each keeps its disks. */
static void test_clump_numbers(void **state) {
#define CLUMPS(clump)                                                                              \
  HEAD "disks = ( { name = \"a\"; x = 50; y = 50; radius = 1; mass = 2; }, { name = \"b\"; x = "   \
       "52; y = 50; "                                                                              \
       "radius = 1; mass = 2; },\n  { name = \"c\"; x = 60; y = 50; radius = 1; mass = 7; } );\n"  \
       "container = { type = \"box\"; width = 40; height = 20; };\n"                               \
       "packings = ( { type = \"square\"; count = 2; spacing = 8; radius = 1; density = 1; clump " \
       "= { at = ("                                                                                \
       "(-1, 0), (1, 0), (0, 1)); }; } );\n"                                                       \
       "clumps = ( { name = \"pair\"; disk = (\"a\", \"b\"); }, { name = \"one\"; disk = \"c\"; "  \
       "} );\n"                                                                                    \
       "motions = ( { clump = " clump                                                              \
       "; coordinate = \"x\"; type = \"velocity\"; velocity = 1; } );"
  static const char *const decks[] = {CLUMPS("0"), CLUMPS("\"pair\""), CLUMPS("\"one\""),
                                      CLUMPS("1"), CLUMPS("3")};
  static const uint32_t number[] = {0, 0, 1, 1, 3};
  for (size_t k = 0; k < 5; k++) {
    sd_model *m = good(decks[k]);
    assert_int_equal(m->n_clumps, 4);
    assert_int_equal(m->motions[0].bodies[0], sd_model_bodies(m) + number[k]);
    assert_string_equal(m->clumps[0].name, "pair");
    assert_string_equal(m->clumps[1].name, "one");
    assert_null(m->clumps[2].name);
    assert_true(m->clumps[0].n_disks == 2 && m->clumps[1].n_disks == 1 && m->clumps[1].mass == 7);
    assert_true(m->clumps[2].n_disks == 3 && m->clumps[3].n_disks == 3);
    assert_true(m->disks[0].clump == 1 && m->disks[1].clump == 1 && m->disks[2].clump == 2);
    assert_true(m->disks[3].clump == 3 && m->disks[8].clump == 4);
    sd_model_free(m);
  }
  bad(CLUMPS("4"), "test.cfg:7: motions[0].clump = 4: no clump has this number; expected 0 to 3");
}

/* What the checks of the model find has a line too. */
static void test_places(void **state) {
#define PAIR                                                                                       \
  "disks = ( { name = \"a\"; x = 2; y = 2; radius = 1; mass = 2; },\n  { x = 4; y = 2; radius = "  \
  "1; mass = "                                                                                     \
  "2; } );\n"
#define WITHIN HEAD PAIR "box = { x = (0, 6); y = (0, 20); periodic = \"xy\"; };\n"
  bad(WITHIN "clumps = (\n  { disk = (0, 1); mass = 1; inertia = 1; },\n  { name = \"long\"; disk "
             "= 0; } );",
      "test.cfg:7: clumps[1]: disk \"a\" belongs to another clump");
  bad(HEAD PAIR "box = { x = (0, 3.9); y = (0, 20); periodic = \"xy\"; };",
      "disk 1: x = 4 lies outside");
  bad(HEAD PAIR "box = {\n  x = (0, 4.7);\n  periodic = \"x\"; };",
      "test.cfg:5: box.x: length 4.7: expected more than 4.8");
  bad(HEAD PAIR
      "container = { type = \"bed\"; origin = (2, 0);\n  width = 4.7; height = 9; radius = 1; };",
      "test.cfg:5: container.width: length 4.7");
  bad(HEAD PAIR "motions = (\n  { name = \"m\"; clump = 0; coordinate = \"x\"; type = "
                "\"velocity\"; velocity = 1; } );",
      "test.cfg:5: motions[0].clump = 0: no clump has this number; expected none");
  bad(HEAD "disks = ( { x = 1; y = 2; radius = 1; mass = 2; },\n  { x = 3; y = 2; radius = 1; mass "
           "= 2; },\n "
           " { x = 5; y = 2; "
           "radius = 1; mass = 2; } );\n"
           "box = { x = (0, 6); y = (0, 20); periodic = \"xy\"; };\n"
           "clumps = (\n  { name = \"long\"; disk = (0, 1, 2); } );",
      "test.cfg:7: clump \"long\": it is longer than the periodic box in x: expected locked");
}

static int set_up(void **state) { return mkdtemp(folder) ? 0 : 1; }

static int tear_down(void **state) {
  static const char *const names[] = {"disks.csv", "wave.csv", "part.cfg", "disks.h5",
                                      "deck.cfg",  "with.cfg", "three.cfg"};
  for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, names[k]);
    remove(path);
  }
  sd_messages_free(messages);
  return rmdir(folder);
}

/* A default that is a word sets the value of that word, also of one that begins another. */
static void words_are_defaults(void **unused) {
  typedef struct choices {
    sd_integrator a, b;
  } choices;
  static const deck_shape words[] = {WORD("on", 2), WORD("one", 1), LAST_WORD};
  static const deck_key keys[] = {{"a", CHOICE, "\"one\"", words, "-", SETS(choices, a)},
                                  {"b", CHOICE, "\"on\"", words, "-", SETS(choices, b)}};
  static TABLE(table, "table", true, "-", keys);
  choices c = {0};
  deck_key_defaults(&table, &c);
  assert_int_equal(c.a, 1);
  assert_int_equal(c.b, 2);
}

RUN_TESTS_BETWEEN(set_up, tear_down, TEST(test_values), TEST(test_locks_except), TEST(test_streams),
                  TEST(test_numbers), TEST(test_form), TEST(test_overlaps), TEST(test_laws),
                  TEST(test_overrides), TEST(test_files), TEST(test_round_trip), TEST(test_shipped),
                  TEST(test_places), TEST(test_clump_numbers), TEST(words_are_defaults))

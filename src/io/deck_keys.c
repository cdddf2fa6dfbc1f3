/* deck_keys.c: the tables of all keys, and the search for the nearest valid name. See deck_keys.h. */
#include <ctype.h>
#include <string.h>

#include "io/deck_keys.h"

#define COUNT(a) (sizeof(a) / sizeof *(a))
#define BOOL DECK_KEY_BOOL, DECK_ANY, "-"
#define TEXT DECK_KEY_TEXT, DECK_ANY, "-"
#define NAMES DECK_KEY_NAMES, DECK_ANY, "-"
#define BODIES DECK_KEY_BODIES, DECK_ANY, "-"
#define COORDINATES DECK_KEY_COORDINATES, DECK_ANY, "-"
#define CHOICE DECK_KEY_CHOICE, DECK_ANY, "-"
#define GROUP DECK_KEY_GROUP, DECK_ANY, "-"
#define GROUPS DECK_KEY_GROUPS, DECK_ANY, "-"
#define NUMBER(range, unit) DECK_KEY_NUMBER, range, unit
#define ANGLE(unit) DECK_KEY_ANGLE, DECK_ANY, unit
#define INTEGER(range, unit) DECK_KEY_INTEGER, range, unit
#define TABLE(id, name, one, meaning, keys) const deck_table id = {name, meaning, one, COUNT(keys), keys}

static const deck_key top_keys[] = {
    {"title", TEXT, "\"\"", NULL, "one line about this run"},
    {"seed", INTEGER(DECK_NOT_NEGATIVE, "-"), "1", NULL, "seed of all random streams"},
    {"integrator", CHOICE, "\"gear5\"", "gear5 verlet",
     "Gear predictor-corrector of fifth order, or velocity Verlet"},
    {"dt", NUMBER(DECK_POSITIVE, "time"), "required", NULL, "time step"},
    {"contact_variant", CHOICE, "\"paper\"", "paper conservative",
     "tangential force on the centres: tau (paper), or tau (R_a+R_b)/r, which conserves energy"},
    {"skin", NUMBER(DECK_NOT_NEGATIVE, "length"), "0.0", NULL,
     "margin of the neighbour list; 0: chosen from the radii"},
    {"max_overlap", NUMBER(DECK_UP_TO_1, "-"), "0.5", NULL,
     "a run stops when an overlap exceeds this fraction of the smaller radius"},
    {"checkpoint", NUMBER(DECK_POSITIVE, "s"), "60.0", NULL, "wall time between checkpoints"},
    {"steps", INTEGER(DECK_AT_LEAST_1, "steps"), "-", NULL, "length of the run when there are no phases"},
    {"time", NUMBER(DECK_POSITIVE, "time"), "-", NULL, "the same as a time, rounded to whole steps"},
    {"gravity", GROUP, "-", NULL, "strength and direction of gravity"},
    {"box", GROUP, "-", NULL, "periodic directions"},
    {"materials", GROUPS, "required", NULL, "contact law of each material with itself"},
    {"material_pairs", GROUPS, "-", NULL, "contact law between two different materials"},
    {"disks", GROUPS, "-", NULL, "disks, one by one"},
    {"disk_rows", GROUPS, "-", NULL, "disks, a row each"},
    {"disk_files", GROUPS, "-", NULL, "disks, from files"},
    {"forces", GROUPS, "-", NULL, "constant forces and torques"},
    {"locks", GROUPS, "-", NULL, "coordinates that never change"},
    {"walls", GROUPS, "-", NULL, "walls"},
    {"motions", GROUPS, "-", NULL, "prescribed motions of disks and walls"},
    {"phases", GROUPS, "-", NULL, "parts of the run, one after the other"},
    {"output", GROUP, "-", NULL, "how often results are stored"},
    {"measure", GROUP, "-", NULL, "what is measured"},
    {"until", GROUP, "-", NULL, "error bar at which the last phase ends"},
    {"sweep", GROUPS, "-", NULL, "points that `slipdisk sweep` runs: this deck with some keys set"},
};
TABLE(deck_top, "deck", true, "Keys of the deck itself, outside any group.", top_keys);

static const deck_key gravity_keys[] = {
    {"g", NUMBER(DECK_NOT_NEGATIVE, "length/time^2"), "0.0", NULL, "strength"},
    {"tilt", ANGLE("rad"), "0.0", NULL, "the acceleration is -g (sin tilt, cos tilt)"},
};
TABLE(deck_gravity, "gravity", true, "Gravity; without this group there is none.", gravity_keys);

static const deck_key box_keys[] = {
    {"x", DECK_KEY_NUMBERS, DECK_ANY, "length", "-", NULL,
     "[lower, upper] edge; required when periodic in x"},
    {"y", DECK_KEY_NUMBERS, DECK_ANY, "length", "-", NULL,
     "[lower, upper] edge; required when periodic in y"},
    {"periodic", CHOICE, "\"none\"", "none x y xy",
     "directions in which the box repeats; its edges are no walls"},
};
TABLE(deck_box, "box", true, "The periodic box; without this group space is open.", box_keys);

#define LAW                                                                                                  \
  {"k_n", NUMBER(DECK_POSITIVE, "force/length"), "required", NULL, "normal stiffness"},                      \
      {"k_t", NUMBER(DECK_NOT_NEGATIVE, "force/length"), "0.0", NULL, "stiffness of the skin"},              \
      {"gamma_n", NUMBER(DECK_NOT_NEGATIVE, "force time/length"), "0.0", NULL, "normal viscosity"},          \
      {"mu", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.0", NULL, "coefficient of friction (Amonton)"},

static const deck_key material_keys[] = {
    {"name", TEXT, "required", NULL, "name by which disks and walls refer to it"}, LAW};
TABLE(deck_materials, "materials", false, "A material, with the law of its contacts with itself.",
      material_keys);

static const deck_key pair_keys[] = {{"materials", NAMES, "required", NULL, "the names of the two materials"},
                                     LAW};
TABLE(deck_pairs, "material_pairs", false, "The law of contacts between two different materials.", pair_keys);

/* place, radius: "required" for a single disk, "-" where columns give them */
#define DISK(place)                                                                                          \
  {"x", NUMBER(DECK_ANY, "length"), place, NULL, "centre at the start"},                                     \
      {"y", NUMBER(DECK_ANY, "length"), place, NULL, "centre at the start"},                                 \
      {"theta", ANGLE("rad"), "0.0", NULL, "angle at the start"},                                            \
      {"vx", NUMBER(DECK_ANY, "length/time"), "0.0", NULL, "velocity at the start"},                         \
      {"vy", NUMBER(DECK_ANY, "length/time"), "0.0", NULL, "velocity at the start"},                         \
      {"omega", ANGLE("rad/time"), "0.0", NULL, "angular velocity at the start"},                            \
      {"radius", NUMBER(DECK_POSITIVE, "length"), place, NULL, "radius"},                                    \
      {"mass", NUMBER(DECK_POSITIVE, "mass"), "-", NULL, "mass; either this or density"},                    \
      {"density", NUMBER(DECK_POSITIVE, "mass/length^2"), "-", NULL,                                         \
       "mass per area: mass = density pi R^2"},                                                              \
      {"inertia", NUMBER(DECK_NOT_NEGATIVE, "mass length^2"), "0.0", NULL, "moment of inertia; 0: m R^2/2"}, \
      {"material", TEXT, "(the only one)", NULL,                                                             \
       "name of the material; may be left out when there is one only"},                                      \
      {"group", TEXT, "-", NULL, "name of a group of disks, made by being used"},                            \
      {"fixed", BOOL, "false", NULL, "held still, or moved by motions only, whatever pushes"},               \
      {"locked", COORDINATES, "()", NULL, "coordinates that never change"},                                  \
      {"force",                                                                                              \
       DECK_KEY_NUMBERS,                                                                                     \
       DECK_ANY,                                                                                             \
       "force",                                                                                              \
       "(0.0, 0.0)",                                                                                         \
       NULL,                                                                                                 \
       "constant force (f_x, f_y) on the centre"},                                                           \
      {"torque", NUMBER(DECK_ANY, "force length"), "0.0", NULL, "constant torque"},

static const deck_key disk_keys[] = {{"name", TEXT, "-", NULL, "name by which other groups refer to it"},
                                     DISK("required")};
TABLE(deck_disks, "disks", false, "One disk.", disk_keys);

static const deck_key row_keys[] = {
    {"columns", NAMES, "required", NULL,
     "keys of `disks` that the rows give, in order (not locked, force or torque)"},
    {"rows", DECK_KEY_ROWS, DECK_ANY, "-", "required", NULL,
     "a list of values for each disk, in the order of the columns"},
    DISK("-")};
TABLE(deck_disk_rows, "disk_rows", false,
      "Many disks, a row each; keys of `disks` that are not columns hold for all rows.", row_keys);

static const deck_key file_keys[] = {
    {"file", TEXT, "required", NULL, "file, seen from the deck's folder"},
    {"format", CHOICE, "(by the file's name)", "csv hdf5", "CSV with a line of names at the top, or HDF5"},
    {"dataset", TEXT, "-", NULL, "HDF5: the dataset"},
    {"columns", NAMES, "(all of a CSV file; x, y, radius of HDF5)", NULL,
     "columns to take: \"radius\", or \"radius = name in the file\""},
    DISK("-")};
TABLE(deck_disk_files, "disk_files", false,
      "Many disks from a file; keys of `disks` that are not columns hold for all rows.", file_keys);

static const deck_key force_keys[] = {
    {"disk", BODIES, "-", NULL, "disks, by name or number"},
    {"group", NAMES, "-", NULL, "groups of disks"},
    {"force", DECK_KEY_NUMBERS, DECK_ANY, "force", "(0.0, 0.0)", NULL,
     "constant force (f_x, f_y), added on each disk"},
    {"torque", NUMBER(DECK_ANY, "force length"), "0.0", NULL, "constant torque, added on each disk"},
};
TABLE(deck_forces, "forces", false, "A constant force on disks, besides gravity.", force_keys);

static const deck_key lock_keys[] = {
    {"disk", BODIES, "-", NULL, "disks, by name or number"},
    {"group", NAMES, "-", NULL, "groups of disks"},
    {"coordinates", COORDINATES, "required", NULL, "what never changes"},
};
TABLE(deck_locks, "locks", false, "Coordinates of disks that never change, whatever pushes.", lock_keys);

static const deck_key wall_keys[] = {
    {"name", TEXT, "-", NULL, "name by which other groups refer to it"},
    {"type", CHOICE, "required", "line segment polyline circle", "shape, see below"},
    {"material", TEXT, "(the only one)", NULL,
     "name of the material; may be left out when there is one only"},
    {"points", DECK_KEY_POINTS, DECK_ANY, "length", "-", NULL, "list of (x, y)"},
    {"pivot", DECK_KEY_NUMBERS, DECK_ANY, "length", "(mean of the points)", NULL,
     "(x, y) about which it turns"},
    {"closed", BOOL, "false", NULL, "polyline: join the last point to the first"},
    {"center", DECK_KEY_NUMBERS, DECK_ANY, "length", "-", NULL, "circle: (x, y)"},
    {"radius", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "circle: radius"},
    {"side", CHOICE, "-", "inside outside", "circle: where the disks are"},
};
TABLE(deck_walls, "walls", false, "A wall. It stands still unless motions move it.", wall_keys);

const deck_shape deck_wall_kinds[] = {
    {"line", SD_WALL_LINE, "points* pivot", "infinite straight line through two points"},
    {"segment", SD_WALL_SEGMENT, "points* pivot", "straight piece between two points; its ends push too"},
    {"polyline", SD_WALL_POLYLINE, "points* pivot closed", "straight pieces through two or more points"},
    {"circle", SD_WALL_CIRCLE, "center* radius* side*", "round container, or round obstacle"},
};
const size_t deck_wall_kind_count = COUNT(deck_wall_kinds);

static const deck_key motion_keys[] = {
    {"name", TEXT, "-", NULL, "name by which phases refer to it"},
    {"disk", BODIES, "-", NULL, "disks, by name or number"},
    {"group", NAMES, "-", NULL, "groups of disks"},
    {"wall", BODIES, "-", NULL, "walls, by name or number"},
    {"coordinate", COORDINATES, "required", NULL,
     "what moves; theta of a group turns each disk about its own centre"},
    {"type", CHOICE, "required", "fixed velocity harmonic parabolic random table",
     "kind of motion, see below"},
    {"amplitude", ANGLE("length or rad"), "-", NULL, "amplitude; random: rms displacement"},
    {"frequency", NUMBER(DECK_POSITIVE, "1/time"), "-", NULL, "cycles per time; either this or omega"},
    {"omega", ANGLE("rad/time"), "-", NULL, "angular frequency, > 0"},
    {"phase", ANGLE("rad"), "0.0", NULL, "phase phi in sin(w t + phi)"},
    {"velocity", ANGLE("length/time or rad/time"), "-", NULL, "constant velocity"},
    {"damping", NUMBER(DECK_POSITIVE, "-"), "0.5", NULL, "random: damping ratio c"},
    {"interval", INTEGER(DECK_AT_LEAST_1, "steps"), "1", NULL, "random: steps between draws of the noise"},
    {"independent", BOOL, "(false with `group`, else true)", NULL,
     "random: each body has its own signal, or all share one"},
    {"ramp", NUMBER(DECK_NOT_NEGATIVE, "time"), "0.0", NULL, "time over which the motion is faded in"},
    {"file", TEXT, "-", NULL, "table: CSV file, seen from the deck's folder"},
    {"columns", NAMES, "(\"time\", \"value\")", NULL, "table: the two columns of the file"},
    {"times", DECK_KEY_NUMBERS, DECK_ANY, "time", "-", NULL, "table: times, in place of a file"},
    {"values", DECK_KEY_NUMBERS, DECK_ANY, "length or rad", "-", NULL, "table: displacements at these times"},
    {"factor", NUMBER(DECK_ANY, "-"), "1.0", NULL, "table: the values are multiplied by this"},
    {"periodic", BOOL, "false", NULL, "table: repeat it; the last value must equal the first"},
};
TABLE(deck_motions, "motions", false,
      "A prescribed displacement u(t), added to one or more coordinates of each body it names. Several "
      "motions on "
      "the same coordinate add up. t counts from the moment the motion is switched on.",
      motion_keys);

const deck_shape deck_motion_kinds[] = {
    {"fixed", DECK_MOTION_FIXED, "", "u = 0: the coordinate is held"},
    {"velocity", SD_MOTION_VELOCITY, "velocity* ramp", "u = v t"},
    {"harmonic", SD_MOTION_HARMONIC, "amplitude* frequency/omega* phase ramp",
     "u = A sin(w t + phi) (eq. 20)"},
    {"parabolic", SD_MOTION_PARABOLIC, "amplitude* frequency/omega* phase ramp",
     "the same, each half wave replaced by a parabola (eq. 21)"},
    {"random", SD_MOTION_RANDOM, "amplitude* frequency/omega* damping interval independent ramp",
     "u'' + 2 c w u' + w^2 u = white noise, of rms displacement A (eq. 52)"},
    {"table", SD_MOTION_TABLE, "file/times* columns values factor periodic ramp",
     "natural cubic spline through a table"},
};
const size_t deck_motion_kind_count = COUNT(deck_motion_kinds);

#define CADENCE(series, frames, contacts)                                                                    \
  {"series", INTEGER(DECK_NOT_NEGATIVE, "steps"), series, NULL,                                              \
   "steps between rows of the time series; 0: none"},                                                        \
      {"frames", INTEGER(DECK_NOT_NEGATIVE, "steps"), frames, NULL,                                          \
       "steps between stored frames of all bodies; 0: none"},                                                \
      {"contacts", INTEGER(DECK_NOT_NEGATIVE, "steps"), contacts, NULL,                                      \
       "steps between stored contact tables; 0: none"},

static const deck_key phase_keys[] = {
    {"name", TEXT, "-", NULL, "name in messages and results"},
    {"steps", INTEGER(DECK_AT_LEAST_1, "steps"), "-", NULL, "length; either this or time"},
    {"time", NUMBER(DECK_POSITIVE, "time"), "-", NULL, "length as a time, rounded to whole steps"},
    {"motions", BODIES, "(all)", NULL, "motions that are on, by name or number; () for none"},
    {"measure", BOOL, "(true in the last phase)", NULL, "statistics are gathered"},
    CADENCE("(as in output)", "(as in output)", "(as in output)")};
TABLE(deck_phases, "phases", false, "A part of the run.", phase_keys);

static const deck_key output_keys[] = {CADENCE("(a thousandth of each phase)", "0", "0")};
TABLE(deck_output, "output", true, "How often results are stored, where a phase does not say otherwise.",
      output_keys);

static const deck_key measure_keys[] = {
    {"rotation", BODIES, "(all free disks when at most 16, else none)", NULL,
     "disks whose mean angular velocity is measured; () for none"},
    {"sliding", GROUPS, "-", NULL, "pairs of contacts whose sliding configurations are counted"},
};
TABLE(deck_measure, "measure", true, "What is measured, in the phases that measure.", measure_keys);

static const deck_key sliding_keys[] = {
    {"disk", BODIES, "required", NULL, "the disk, by name or number"},
    {"partners", BODIES, "required", NULL,
     "the two disks or walls that it touches, first and second sign of S++"},
};
TABLE(deck_sliding, "measure.sliding", false, "A disk and the two partners whose contacts are watched.",
      sliding_keys);

static const deck_key until_keys[] = {
    {"observable", TEXT, "(omega of the first watched disk)", NULL,
     "\"NAME.omega\" or \"NAME.scaled\": Omega or t_g Omega of a watched disk, by name or number"},
    {"error", NUMBER(DECK_POSITIVE, "rad/time or rad"), "-", NULL,
     "standard error to be reached; either this or relative"},
    {"relative", NUMBER(DECK_POSITIVE, "-"), "-", NULL,
     "standard error as a fraction of the size of the mean"},
    {"max_time", NUMBER(DECK_POSITIVE, "time"), "required", NULL,
     "the last phase ends after this time at the latest, goal reached or not"},
};
TABLE(deck_until, "until", true,
      "The last phase goes on beyond its own length until an error bar is small enough.", until_keys);

static const deck_key sweep_keys[] = {
    {"parameters", GROUPS, "-", NULL, "what is varied"},
    {"replicas", INTEGER(DECK_AT_LEAST_1, "-"), "1", NULL,
     "runs of each set of values, with different seeds"},
    {"collect", NAMES, "(all)", NULL, "columns of the table of results; * stands for any letters"},
};
TABLE(
    deck_sweeps, "sweep", false,
    "A grid of points. `sweep = { ... }` without a list is one grid; of several, equal points are run once.",
    sweep_keys);

static const deck_key sweep_parameter_keys[] = {
    {"path", NAMES, "required", NULL, "the key that is set, as after -D; several are set to the same value"},
    {"name", TEXT, "(last word of the path)", NULL, "name in the table and in file names"},
    {"values", DECK_KEY_VALUES, DECK_ANY, "-", "-", NULL, "list of values"},
    {"linspace", DECK_KEY_NUMBERS, DECK_ANY, "-", "-", NULL, "(first, last, count): evenly spaced"},
    {"logspace", DECK_KEY_NUMBERS, DECK_ANY, "-", "-", NULL,
     "(first, last, count): evenly spaced logarithms"},
    {"zip", TEXT, "-", NULL, "parameters with the same word here advance together; all others are crossed"},
};
TABLE(deck_sweep_parameters, "sweep.parameters", false, "A parameter and its values.", sweep_parameter_keys);

const deck_table *const deck_tables[] = {
    &deck_top,     &deck_gravity,   &deck_box,        &deck_materials,        &deck_pairs,
    &deck_disks,   &deck_disk_rows, &deck_disk_files, &deck_forces,           &deck_locks,
    &deck_walls,   &deck_motions,   &deck_phases,     &deck_output,           &deck_measure,
    &deck_sliding, &deck_until,     &deck_sweeps,     &deck_sweep_parameters,
};
const size_t deck_table_count = COUNT(deck_tables);

/* --- look-up -------------------------------------------------------------------------------------------- */

const deck_key *deck_key_find(const deck_table *table, const char *name) {
  for (size_t k = 0; k < table->n; k++)
    if (strcmp(table->key[k].name, name) == 0) return &table->key[k];
  return NULL;
}

const char *deck_kind_text(deck_kind kind) {
  static const char *const text[] = {"true or false", "integer", "number", "angle",   "text",
                                     "choice",        "numbers", "points", "name(s)", "name(s) or number(s)",
                                     "coordinate(s)", "rows",    "values", "group",   "list of groups"};
  return text[kind];
}

const char *deck_range_text(deck_range range) {
  static const char *const text[] = {"", "> 0", ">= 0", ">= 1", "> 0 and <= 1"};
  return text[range];
}

bool deck_in_range(deck_range range, double x) {
  switch (range) {
    case DECK_ANY: return true;
    case DECK_POSITIVE: return x > 0;
    case DECK_NOT_NEGATIVE: return x >= 0;
    case DECK_AT_LEAST_1: return x >= 1;
    case DECK_UP_TO_1: return x > 0 && x <= 1;
  }
  return true;
}

/* --- nearest name --------------------------------------------------------------------------------------- */

enum { LONGEST_WORD = 63 };

static size_t least(size_t a, size_t b) { return a < b ? a : b; }

/* Insertions, deletions, replacements and swaps of neighbours. */
static size_t edit_distance(const char *a, const char *b) {
  size_t m = strlen(a), n = strlen(b), row[3][LONGEST_WORD + 1];
  if (m > LONGEST_WORD || n > LONGEST_WORD) return SIZE_MAX;
  for (size_t j = 0; j <= n; j++) row[0][j] = j;
  for (size_t i = 1; i <= m; i++) {
    size_t *now = row[i % 3], *up = row[(i + 2) % 3], *up2 = row[(i + 1) % 3];
    now[0] = i;
    for (size_t j = 1; j <= n; j++) {
      size_t same = tolower((unsigned char)a[i - 1]) == tolower((unsigned char)b[j - 1]) ? 0 : 1;
      now[j] = least(least(up[j] + 1, now[j - 1] + 1), up[j - 1] + same);
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = least(now[j], up2[j - 2] + 1);
    }
  }
  return row[m % 3][n];
}

deck_guess deck_guess_start(const char *word) { return (deck_guess){word, NULL, SIZE_MAX}; }

void deck_guess_add(deck_guess *guess, const char *candidate) {
  if (!candidate) return;
  size_t distance = edit_distance(guess->word, candidate), n = strlen(guess->word);
  /* "centre" for "center", "kn" for "k_n"; but not any word for any other */
  size_t allowed = n <= 2 ? 1 : n <= 5 ? 2 : 3;
  if (distance >= strlen(candidate) || distance > allowed || distance >= guess->distance) return;
  guess->distance = distance;
  guess->best = candidate;
}

/* --- documentation -------------------------------------------------------------------------------------- */

static void print_shapes(FILE *out, const char *heading, const deck_shape *shape, size_t n) {
  fprintf(out, "| %s | keys | meaning |\n|---|---|---|\n", heading);
  for (size_t k = 0; k < n; k++)
    fprintf(out, "| `\"%s\"` | %s | %s |\n", shape[k].name, *shape[k].keys ? shape[k].keys : "-",
            shape[k].meaning);
  fprintf(out, "\n");
}

void deck_keys_print(FILE *out) {
  for (size_t t = 0; t < deck_table_count; t++) {
    const deck_table *table = deck_tables[t];
    fprintf(out,
            "### %s\n\n%s\n\n| key | type | range | unit | default | meaning |\n|---|---|---|---|---|---|\n",
            table->name, table->meaning);
    for (size_t k = 0; k < table->n; k++) {
      const deck_key *key = &table->key[k];
      const char *range = key->kind == DECK_KEY_CHOICE ? key->choices : deck_range_text(key->range);
      fprintf(out, "| `%s` | %s | %s | %s | %s | %s |\n", key->name, deck_kind_text(key->kind),
              *range ? range : "-", key->unit, key->initial, key->meaning);
    }
    fprintf(out, "\n");
    if (table == &deck_walls) print_shapes(out, "wall type", deck_wall_kinds, deck_wall_kind_count);
    if (table == &deck_motions) print_shapes(out, "motion type", deck_motion_kinds, deck_motion_kind_count);
  }
}

/* deck_keys.c: tables of all keys of a deck, and of other programs' words for them. See
 * deck_read.h. */

#include <string.h>
#include <strings.h>

#include "io/deck/deck.h"
#include "io/deck/deck_read.h"
#include "io/deck/deck_rows.h"
#include "io/deck/deck_values.h"
#include "model/containers.h"
#include "model/field_kinds.h"
#include "model/laws.h"
#include "model/motions.h"

static const deck_key material_keys[] = {
    {"name", TEXT, "required", NULL, "name for disks and walls"},
};
TABLE_WITH(deck_materials, "materials", false, "A material and its contact law with itself.",
           material_keys, law_table);

static const deck_key pair_keys[] = {
    {"materials", NAMES, "required", NULL, "the two materials"},
};
TABLE_WITH(deck_pairs, "material_pairs", false, "The contact law between two different materials.",
           pair_keys, law_table);

/* Keys of a disk. place: text in the table for the default of x, y and radius: "required" for a
 * single disk, "-" if columns may give them. */
#define DISK(place)                                                                                \
  {"x", NUMBER(DECK_ANY, "length"), place, NULL, "centre at the start"},                           \
      {"y", NUMBER(DECK_ANY, "length"), place, NULL, "centre at the start"},                       \
      {"theta", ANGLE("rad"), "0.0", NULL, "angle at the start"},                                  \
      {"vx", NUMBER(DECK_ANY, "length/time"), "0.0", NULL, "velocity at the start"},               \
      {"vy", NUMBER(DECK_ANY, "length/time"), "0.0", NULL, "velocity at the start"},               \
      {"omega", ANGLE("rad/time"), "0.0", NULL, "angular velocity at the start"},                  \
      {"radius", NUMBER(DECK_POSITIVE, "length"), place, NULL, "radius"},                          \
      {"mass", NUMBER(DECK_POSITIVE, "mass"), "-", NULL, "mass; either this or density"},          \
      {"density", NUMBER(DECK_POSITIVE, "mass/length^2"), "-", NULL,                               \
       "mass per area: mass = density pi R^2"},                                                    \
      {"inertia", NUMBER(DECK_NOT_NEGATIVE, "mass length^2"), "0.0", NULL,                         \
       "moment of inertia; 0: m R^2/2"},                                                           \
      {"material", TEXT, "(the only one)", NULL, "its material"},                                  \
      {"group", TEXT, "-", NULL, "group of disks that it joins"},                                  \
      {"fixed", BOOL, "false", NULL, "moved by motions only, not by forces"},                      \
      {"locked", COORDINATES, "()", NULL, "coordinates that never change"},                        \
      {"force", NUMBERS(DECK_ANY, "force"), "(0.0, 0.0)", NULL,                                    \
       "constant force (f_x, f_y) on the centre"},                                                 \
      {"torque", NUMBER(DECK_ANY, "force length"), "0.0", NULL, "constant torque"},

static const deck_key disk_keys[] = {{"name", TEXT, "-", NULL, "name for other groups"},
                                     DISK("required")};
TABLE_EITHER(deck_disks, "disks", false, "One disk.", disk_keys, "mass/density");

static const deck_key row_keys[] = {
    {"columns", NAMES, "required", NULL,
     "keys that the rows give, in order (not locked, force, torque)"},
    {"rows", ROWS, "required", NULL, "one list of values per disk, in that order"},
    DISK("-")};
TABLE_EITHER(deck_disk_rows, "disk_rows", false,
             "Many disks, one per row; other keys of `disks` hold for all rows.", row_keys,
             "mass/density");

static const deck_shape formats[] = {WORD("csv", DECK_CSV), WORD("hdf5", DECK_HDF5),
                                     WORD("lammps", DECK_LAMMPS), LAST_WORD};

static const deck_key file_keys[] = {
    {"file", TEXT, "required", NULL, "path from the deck's folder"},
    {"format", CHOICE, "(by the file)", formats,
     "CSV with a line of names, HDF5, LAMMPS data or dump"},
    {"timestep", INTEGER(DECK_NOT_NEGATIVE, "steps"), "(the last)", NULL, "LAMMPS dump: the frame"},
    {"dataset", TEXT, "(/particles/disks of a result, the only group of H5MD)", NULL,
     "HDF5: the dataset"},
    {"columns", NAMES, "(all of CSV, LAMMPS and a result; else x, y, radius)", NULL,
     "columns to take: \"radius\", \"radius = name in the file\" or \"radius = 0.5 * name\""},
    {"contacts", BOOL, "false", NULL,
     "also take the contacts of a result or checkpoint, so that the packing is unchanged"},
    DISK("-")};
TABLE_EITHER(deck_disk_files, "disk_files", false,
             "Many disks from a file; other keys of `disks` hold for all rows.", file_keys,
             "mass/density");

static const deck_key force_keys[] = {
    {"disk", BODIES, "-", NULL, "disks"},
    {"group", NAMES, "-", NULL, "groups of disks"},
    {"force", NUMBERS(DECK_ANY, "force"), "(0.0, 0.0)", NULL, "(f_x, f_y), added on each disk",
     SETS(sd_disk, force)},
    {"torque", NUMBER(DECK_ANY, "force length"), "0.0", NULL, "added on each disk",
     SETS(sd_disk, force[SD_THETA])},
};
TABLE(deck_forces, "forces", false, "A constant force on disks, besides gravity.", force_keys);

static const deck_key lock_keys[] = {
    {"disk", BODIES, "-", NULL, "disks"},
    {"group", NAMES, "-", NULL, "groups of disks"},
    {"except", BODIES, "()", NULL, "disks and groups of these that keep moving"},
    {"coordinates", COORDINATES, "required", NULL, "what never changes"},
};
TABLE(deck_locks, "locks", false, "Coordinates of disks that never change.", lock_keys);

static const deck_key clump_keys[] = {
    {"name", TEXT, "-", NULL, "name for motions"},
    {"disk", BODIES, "-", NULL, "its disks"},
    {"group", NAMES, "-", NULL, "groups of its disks"},
    {"mass", NUMBER(DECK_POSITIVE, "mass"), "(of its disks)", NULL, "its mass",
     SETS(sd_clump, mass)},
    {"inertia", NUMBER(DECK_POSITIVE, "mass length^2"), "(of its disks)", NULL,
     "about the centre of mass; of its disks: sum of I + m d^2, times mass over the sum of m",
     SETS(sd_clump, inertia)},
    {"velocity", NUMBERS(DECK_ANY, "length/time"), "(0.0, 0.0)", NULL, "of the centre at the start",
     SETS(sd_clump, velocity)},
    {"omega", ANGLE("rad/time"), "0.0", NULL, "angular velocity at the start",
     SETS(sd_clump, velocity[SD_THETA])},
    {"force", NUMBERS(DECK_ANY, "force"), "(0.0, 0.0)", NULL,
     "constant force (f_x, f_y) on the centre", SETS(sd_clump, force)},
    {"torque", NUMBER(DECK_ANY, "force length"), "0.0", NULL, "constant torque",
     SETS(sd_clump, force[SD_THETA])},
    {"locked", COORDINATES, "()", NULL, "coordinates of the clump that never change"},
};
TABLE(deck_clumps, "clumps", false,
      "Disks that move as one rigid body; they may overlap one another.", clump_keys);

static const deck_shape sides[] = {WORD("inside", true), WORD("outside", false), LAST_WORD};

static const deck_shape wall_kinds[] = {
    {"line", SD_WALL_LINE, "points* pivot", "infinite straight line through two points"},
    {"segment", SD_WALL_SEGMENT, "points* pivot",
     "straight piece between two points; its ends push too"},
    {"polyline", SD_WALL_POLYLINE, "points* pivot closed",
     "straight pieces through two or more points"},
    {"circle", SD_WALL_CIRCLE, "center* radius* side*", "round container, or round obstacle"},
    {"arc", SD_WALL_ARC, "center* radius* from* to* pivot",
     "part of a circle; both sides and its ends push"},
    LAST_WORD,
};

static const deck_key wall_keys[] = {
    {"name", TEXT, "-", NULL, "name for other groups", SETS(sd_wall, name)},
    {"type", CHOICE, "required", wall_kinds, "see below", SETS(sd_wall, kind)},
    {"material", TEXT, "(the only one)", NULL, "its material"},
    {"points", POINTS, "-", NULL, "list of (x, y)"},
    {"pivot", NUMBERS(DECK_ANY, "length"), "(mean of the points; arc: its centre)", NULL,
     "(x, y) about which it turns", SETS(sd_wall, pivot)},
    {"closed", BOOL, "false", NULL, "polyline: join the last point to the first",
     SETS(sd_wall, closed)},
    {"center", NUMBERS(DECK_ANY, "length"), "-", NULL, "circle, arc: (x, y)",
     SETS(sd_wall, center)},
    {"radius", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "circle, arc: radius",
     SETS(sd_wall, radius)},
    {"from", ANGLE("rad"), "-", NULL, "arc: angle at which it begins, counter-clockwise from x",
     SETS(sd_wall, from)},
    {"to", ANGLE("rad"), "-", NULL, "arc: angle at which it ends, > from; at most a whole turn",
     SETS(sd_wall, to)},
    {"side", CHOICE, "-", sides, "circle: where the disks are", SETS(sd_wall, inside)},
};
TABLE(deck_walls, "walls", false, "A wall stands still unless motions move it.", wall_keys);

static const deck_shape packing_kinds[] = {
    {"triangular", SD_PACKING_TRIANGULAR, "count spacing jitter tiles",
     "triangular lattice from below; without count fills the region"},
    {"square", SD_PACKING_SQUARE, "count spacing jitter tiles", "square lattice, likewise"},
    {"random", SD_PACKING_RANDOM, "count/fraction* tiles",
     "at random, up to a fraction of about 0.5"},
    {"front", SD_PACKING_FRONT, "count tiles",
     "advancing front: dense, each disk touches two; without count fills the region"},
    {"rain", SD_PACKING_RAIN, "count* rows interval gap speed tiles",
     "disks wait and fall in batches from just above the others"},
    LAST_WORD,
};

static const deck_shape size_kinds[] = {
    {"mono", SD_SIZES_MONO, "radius*", "all equal"},
    {"list", SD_SIZES_LIST, "radii* weights",
     "given radii in proportion to their weights, in random order"},
    {"uniform", SD_SIZES_UNIFORM, "lower* upper*", "evenly between two radii"},
    {"gaussian", SD_SIZES_GAUSSIAN, "radius* deviation* lower upper",
     "normal distribution, cut at lower and upper (3 deviations unless given)"},
    {"lognormal", SD_SIZES_LOGNORMAL, "radius* deviation* lower upper",
     "normal distribution of ln R, cut likewise"},
    {"powerlaw", SD_SIZES_POWERLAW, "exponent* lower* upper*",
     "p(R) ~ R^-exponent between two radii"},
    LAST_WORD,
};

static const deck_key packing_keys[] = {
    {"type", CHOICE, "required", packing_kinds, "see below", SETS(packing_spec, kind)},
    {"count", INTEGER(DECK_AT_LEAST_1, "disks"), "-", NULL, "number of disks",
     SETS(packing_spec, count)},
    {"fraction", NUMBER(DECK_UP_TO_1, "-"), "-", NULL, "area of the disks over that of the region",
     SETS(packing_spec, fraction)},
    {"x", NUMBERS(DECK_ANY, "length"), "(of the container)", NULL,
     "[lower, upper] edge of its region"},
    {"y", NUMBERS(DECK_ANY, "length"), "(of the container)", NULL,
     "[lower, upper] edge of its region"},
    {"spacing", NUMBER(DECK_POSITIVE, "length"), "(largest diameter)", NULL,
     "lattices: distance of neighbouring sites", SETS(packing_spec, spacing)},
    {"jitter", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.0", NULL,
     "lattices: largest random displacement over the free distance; 1: disks may touch",
     SETS(packing_spec, jitter)},
    {"tiles", INTEGER(DECK_AT_LEAST_1, "-"), "-", NULL,
     "independent slabs along x (rain: runs of disks) with their share of count; each MPI rank "
     "makes its own",
     SETS(packing_spec, tiles)},
    {"rows", INTEGER(DECK_AT_LEAST_1, "-"), "4", NULL, "rain: rows of disks in a batch",
     SETS(packing_spec, rows)},
    {"interval", NUMBER(DECK_POSITIVE, "time"), "(the fall through a batch's height)", NULL,
     "rain: time between batches", SETS(packing_spec, interval)},
    {"gap", NUMBER(DECK_NOT_NEGATIVE, "length"), "(largest radius)", NULL,
     "rain: distance of a new batch from the highest disk", SETS(packing_spec, rain.gap)},
    {"speed", NUMBER(DECK_NOT_NEGATIVE, "length/time"), "0.0", NULL,
     "rain: initial speed downwards", SETS(packing_spec, rain.speed)},
    {"sizes", CHOICE, "\"mono\"", size_kinds, "radii, see below", SETS(packing_spec, sizes.kind)},
    {"radius", NUMBER(DECK_POSITIVE, "length"), "-", NULL,
     "radius; gaussian: mean; lognormal: median", SETS(packing_spec, sizes.radius)},
    {"radii", NUMBERS(DECK_POSITIVE, "length"), "-", NULL, "list: the radii"},
    {"weights", NUMBERS(DECK_NOT_NEGATIVE, "-"), "(all equal)", NULL,
     "list: frequency of each radius"},
    {"deviation", NUMBER(DECK_POSITIVE, "length or -"), "-", NULL,
     "gaussian: standard deviation; lognormal: that of ln(radius)",
     SETS(packing_spec, sizes.deviation)},
    {"lower", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "smallest radius",
     SETS(packing_spec, sizes.lower)},
    {"upper", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "largest radius",
     SETS(packing_spec, sizes.upper)},
    {"exponent", NUMBER(DECK_ANY, "-"), "-", NULL, "powerlaw: a in p(R) ~ R^-a",
     SETS(packing_spec, sizes.exponent)},
    {"density", NUMBER(DECK_POSITIVE, "mass/length^2"), "-", NULL,
     "mass per area; either this or mass", SETS(packing_spec, density)},
    {"mass", NUMBER(DECK_POSITIVE, "mass"), "-", NULL, "mass of every disk or clump",
     SETS(packing_spec, mass)},
    {"clump", GROUP, "-", NULL,
     "clumps instead of disks: count is of clumps, fraction of the circles around them, radius of "
     "the template"},
    {"material", TEXT, "(the only one)", NULL, "its material"},
    {"group", TEXT, "-", NULL, "group of disks that it joins"},
};
static const deck_key packing_clump_keys[] = {
    {"at", POINTS, "required", NULL, "centres of its disks over the drawn radius"},
    {"radii", NUMBERS(DECK_POSITIVE, "radius"), "1.0", NULL,
     "their radii over the drawn one, or one for all"},
};
TABLE(deck_packing_clump, "packings.clump", true,
      "Each grain of the packing is this rigid body of disks, at a random angle.",
      packing_clump_keys);

TABLE_EITHER(
    deck_packings, "packings", false,
    "Generated disks; random numbers follow from `seed` and the packing's number in the deck.",
    packing_keys, "mass/density");

#define SHAPE(kind, word, source, amplitude, check, keys, meaning) {#word, kind, keys, meaning},
static const deck_shape motion_shapes[] = {
    {"fixed", SD_MOTION_VELOCITY, "", "u = 0: the coordinate is held"},
    MOTION_KINDS(SHAPE) LAST_WORD};

#define KEY(member, type, range, unit, initial, meaning)                                           \
  {#member, KEY_TYPE(type, range, unit), initial, NULL, meaning, SETS(sd_motion, member)},
static const deck_key motion_keys[] = {
    {"name", TEXT, "-", NULL, "name for phases"},
    {"disk", BODIES, "-", NULL, "disks"},
    {"group", NAMES, "-", NULL, "groups of disks"},
    {"wall", BODIES, "-", NULL, "walls"},
    {"clump", BODIES, "-", NULL, "clumps"},
    {"coordinate", COORDINATES, "required", NULL,
     "theta of a group turns each disk about its own centre; surface: a wall's surface runs along "
     "it, the wall stays"},
    {"type", CHOICE, "required", motion_shapes, "see below", SETS(sd_motion, kind)},
    {"amplitude", ANGLE("length or rad"), "-", NULL, "amplitude; random: rms displacement",
     SETS(sd_motion, amplitude)},
    {"acceleration", NUMBER(DECK_POSITIVE, "g"), "-", NULL,
     "instead of amplitude: peak acceleration; random: omega^2 times the rms displacement"},
    {"frequency", NUMBER(DECK_POSITIVE, "1/time"), "-", NULL,
     "cycles per time; either this or omega"},
    {"omega", ANGLE("rad/time"), "-", NULL, "angular frequency, > 0", SETS(sd_motion, omega)},
    WAVE_KEYS(KEY){"velocity", ANGLE("length/time or rad/time"), "-", NULL, "constant velocity",
                   SETS(sd_motion, velocity)},
    {"damping", NUMBER(DECK_POSITIVE, "-"), "0.5", NULL, "random: damping ratio c",
     SETS(sd_motion, damping)},
    {"interval", INTEGER(DECK_AT_LEAST_1, "steps"), "1", NULL,
     "random: steps between draws of the noise", SETS(sd_motion, interval)},
    {"independent", BOOL, "(false with `group`, else true)", NULL,
     "random: one signal per body, not one for all"},
    {"ramp", NUMBER(DECK_NOT_NEGATIVE, "time"), "0.0", NULL, "time over which the motion fades in",
     SETS(sd_motion, ramp)},
    {"file", TEXT, "-", NULL, "table: CSV file, path from the deck's folder"},
    {"columns", NAMES, "(\"time\", \"value\")", NULL, "table: two columns of the file"},
    {"times", NUMBERS(DECK_ANY, "time"), "-", NULL, "table: times, instead of a file"},
    {"values", NUMBERS(DECK_ANY, "length or rad"), "-", NULL,
     "table: displacements at these times"},
    {"factor", NUMBER(DECK_ANY, "-"), "1.0", NULL, "table: multiplies the values",
     SETS(sd_motion, amplitude)},
    {"periodic", BOOL, "false", NULL, "table: repeat it; the last value must equal the first",
     SETS(sd_motion, periodic)},
    {"mass", NUMBER(DECK_POSITIVE, "mass"), "-", NULL, "load: mass of the wall, with weight",
     SETS(sd_motion, mass)},
    {"force", NUMBER(DECK_ANY, "force"), "(0.0 of a load)", NULL,
     "along the coordinate: on a load besides its weight; of a servo on the disks",
     SETS(sd_motion, force)},
    {"pressure", NUMBER(DECK_POSITIVE, "force/length"), "-", NULL,
     "servo: force over the length of the wall, > 0 when it presses", SETS(sd_motion, pressure)},
    {"length", NUMBER(DECK_POSITIVE, "length"), "(of the segment, box or container)", NULL,
     "servo: length that the pressure acts on", SETS(sd_motion, length)},
    {"speed", NUMBER(DECK_POSITIVE, "length/time"), "-", NULL, "servo: largest speed",
     SETS(sd_motion, velocity)},
};
TABLE(deck_motions, "motions", false,
      "A displacement u(t), added to coordinates of the named bodies. Motions on one coordinate "
      "add up. t counts from when the motion is switched on.",
      motion_keys);

static const deck_key sweep_keys[] = {
    {"parameters", GROUPS, "-", NULL, "what is varied"},
    {"replicas", INTEGER(DECK_AT_LEAST_1, "-"), "1", NULL,
     "runs of each set of values, with different seeds"},
    {"collect", NAMES, "(all)", NULL, "columns of the table of results; * stands for any letters"},
};
TABLE(deck_sweeps, "sweep", false,
      "A grid of points, or a list of grids, whose equal points are run once.", sweep_keys);

static const deck_key sweep_parameter_keys[] = {
    {"path", NAMES, "required", NULL, "the key to set, as after -D; several get the same value"},
    {"name", TEXT, "(last words of the path)", NULL, "name in the table and in file names"},
    {"values", VALUES, "-", NULL, "list of values"},
    {"linspace", NUMBERS(DECK_ANY, "-"), "-", NULL, "(first, last, count): evenly spaced"},
    {"logspace", NUMBERS(DECK_ANY, "-"), "-", NULL,
     "(first, last, count): evenly spaced logarithms"},
    {"zip", TEXT, "-", NULL, "parameters with the same word advance together; others are crossed"},
};
TABLE_EITHER(deck_sweep_parameters, "sweep.parameters", false, "A parameter and its values.",
             sweep_parameter_keys, "values/linspace/logspace");

const deck_table *const deck_tables[] = {
    &deck_top,           &deck_gravity, &deck_box,       &deck_materials,  &deck_pairs,
    &container_table,    &deck_disks,   &deck_disk_rows, &deck_disk_files, &deck_packings,
    &deck_packing_clump, &deck_clumps,  &deck_bounds,    &deck_forces,     &deck_locks,
    &deck_walls,         &deck_motions, &deck_fields,    &deck_phases,     &deck_settle,
    &deck_compress,      &deck_cell,    &deck_bond,      &deck_output,     &deck_measure,
    &deck_sliding,       &deck_until,   &deck_limits,    &deck_sweeps,     &deck_sweep_parameters,
};
const size_t deck_table_count = COUNT(deck_tables);

/* --- lists of words --------------------------------------------------------------------------- */

const char *deck_kind_text(deck_kind kind) {
  static const char *const text[] = {
      "true or false", "integer", "number", "angle",   "text",
      "choice",        "numbers", "points", "name(s)", "name(s) or number(s)",
      "coordinate(s)", "rows",    "values", "group",   "list of groups"};
  return text[kind];
}

/* Returns true if the list contains the word; a list looks like "points* pivot" or
 * "mass/density". */
bool deck_listed(const char *list, const char *word) {
  size_t n = strlen(word);
  for (const char *p = list; p && (p = strstr(p, word)); p += n)
    if ((p == list || strchr(" /", p[-1])) && (!p[n] || strchr(" /*", p[n]))) return true;
  return false;
}

/* Returns true if both words are alternatives of each other in the list, as in "a/b/c". */
static bool joined(const char *list, const char *a, const char *b) {
  while (list && *list) {
    size_t n = strcspn(list, " ");
    char run[96];
    snprintf(run, sizeof run, "%.*s", (int)n, list);
    if (deck_listed(run, a) && deck_listed(run, b)) return true;
    list += n + strspn(list + n, " ");
  }
  return false;
}

bool deck_keys_exclude(const char *a, const char *b) {
  for (size_t t = 0; t < deck_table_count; t++) {
    const deck_table *table = deck_tables[t];
    if (joined(table->either, a, b)) return true;
    const deck_key *key;
    for (size_t k = 0; (key = deck_key_at(table, k)); k++)
      for (const deck_shape *word = key->words; word && word->name; word++)
        if (joined(word->keys, a, b)) return true;
  }
  return false;
}

static bool is_kind(deck_kind kind, bool flag) {
  return flag ? kind == DECK_KEY_BOOL
              : kind == DECK_KEY_INTEGER || kind == DECK_KEY_NUMBER || kind == DECK_KEY_ANGLE ||
                    kind == DECK_KEY_NUMBERS || kind == DECK_KEY_POINTS;
}

bool deck_names_kind(const char *name, bool flag) {
  bool found = false;
  for (size_t t = 0; t < deck_table_count; t++) {
    const deck_key *key = deck_key_find(deck_tables[t], name);
    if (key && !is_kind(key->kind, flag)) return false;
    found = found || key;
  }
  return found;
}

/* --- documentation ---------------------------------------------------------------------------- */

/* Prints a table of the words that a key accepts; for kinds (of wall, packing, motion, ...) also
 * the keys that each kind reads. */
static void print_shapes(FILE *out, const char *heading, const deck_shape *shape) {
  fprintf(out, "|%s|keys|meaning|\n|---|---|---|\n", heading);
  for (; shape->name; shape++)
    fprintf(out, "|`\"%s\"`|%s|%s|\n", shape->name, *shape->keys ? shape->keys : "-",
            shape->meaning);
  fprintf(out, "\n");
}

/* Returns true if a table of the key's words follows. */
static bool has_shapes(const deck_key *key) { return key->words && key->words[0].keys; }

/* Columns that are left out of tables in which no key fills them. */
enum { COLUMN_RANGE, COLUMN_UNIT, COLUMN_DEFAULT, COLUMN_COUNT };

static const char *const columns[COLUMN_COUNT] = {"range", "unit", "default"};

/* Returns true if the key has something in the column. */
static bool fills(const deck_key *key, int column) {
  if (column == COLUMN_UNIT) return strcmp(key->unit, "-") != 0;
  if (column == COLUMN_DEFAULT) return strcmp(key->initial, "-") != 0;
  return *deck_range_text(key->range) || (key->words && !has_shapes(key));
}

static void print_key(FILE *out, const deck_key *key, const bool *shown) {
  fprintf(out, "|`%s`|%s|", key->name, deck_kind_text(key->kind));
  if (shown[COLUMN_RANGE]) {
    fprintf(out, "%s", fills(key, COLUMN_RANGE) ? deck_range_text(key->range) : "-");
    for (const deck_shape *word = key->words; word && word->name && !has_shapes(key); word++)
      fprintf(out, "%s%s", word == key->words ? "" : " ", word->name);
    fprintf(out, "|");
  }
  if (shown[COLUMN_UNIT]) fprintf(out, "%s|", key->unit);
  if (shown[COLUMN_DEFAULT]) fprintf(out, "%s|", key->initial);
  fprintf(out, "%s|\n", key->meaning);
}

/* Returns the table whose keys are repeated in this table; NULL: none. */
static const deck_table *base_of(const deck_table *table) {
  if (table == &deck_pairs) return &deck_materials;
  return table == &deck_disk_rows || table == &deck_disk_files ? &deck_disks : NULL;
}

static bool repeats(const deck_table *base, const deck_key *key) {
  const deck_key *other = base ? deck_key_find(base, key->name) : NULL;
  return other && other->kind == key->kind && strcmp(other->meaning, key->meaning) == 0;
}

/* Prints one row that lists all keys repeated from the base table. shown: the columns that this
 * table has. */
static void print_repeated(FILE *out, const deck_table *table, const deck_table *base,
                           const bool *shown) {
  const deck_key *key;
  fprintf(out, "|the same as in [`%s`](#%s)||", base->name, base->name);
  for (int k = 0; k < COLUMN_COUNT; k++)
    if (shown[k]) fprintf(out, "|");
  const char *space = "";
  for (size_t k = 0; (key = deck_key_at(table, k)); k++) {
    if (!repeats(base, key)) continue;
    fprintf(out, "%s`%s`", space, key->name);
    space = " ";
  }
  fprintf(out, "|\n");
}

/* Prints the keys of a table, without columns that none of them fills. */
static void print_keys(FILE *out, const deck_table *table) {
  const deck_table *base = base_of(table);
  const deck_key *key;
  bool shown[COLUMN_COUNT] = {false};
  for (size_t k = 0; (key = deck_key_at(table, k)); k++)
    for (int column = 0; column < COLUMN_COUNT && !repeats(base, key); column++)
      shown[column] = shown[column] || fills(key, column);
  fprintf(out, "|key|type|");
  for (int k = 0; k < COLUMN_COUNT; k++)
    if (shown[k]) fprintf(out, "%s|", columns[k]);
  fprintf(out, "meaning|\n|---|---|");
  for (int k = 0; k < COLUMN_COUNT; k++)
    if (shown[k]) fprintf(out, "---|");
  fprintf(out, "---|\n");
  for (size_t k = 0; (key = deck_key_at(table, k)); k++)
    if (!repeats(base, key)) print_key(out, key, shown);
  if (base) print_repeated(out, table, base, shown);
  fprintf(out, "\n");
}

void deck_keys_print(FILE *out) {
  for (size_t t = 0; t < deck_table_count; t++) {
    const deck_table *table = deck_tables[t];
    fprintf(out, "### %s\n\n%s\n\n", table->name, table->meaning);
    print_keys(out, table);
    const deck_key *key;
    for (size_t k = 0; (key = deck_key_at(table, k)); k++) {
      if (!has_shapes(key) || repeats(base_of(table), key)) continue;
      char heading[96];
      /* Without the plural s: "walls" becomes "wall type" */
      size_t n = strlen(table->name) - !table->one;
      snprintf(heading, sizeof heading, "%.*s type", (int)n, table->name);
      print_shapes(out, strcmp(key->name, "type") == 0 ? heading : key->name, key->words);
    }
  }
}

/* Prints the path of a table, "measure.sliding[0].", of its first n characters. */
static void print_prefix(FILE *out, const char *name, size_t n) {
  for (size_t t = 0; t < deck_table_count; t++) {
    const deck_table *table = deck_tables[t];
    if (table == &deck_top || strlen(table->name) != n || strncmp(table->name, name, n) != 0)
      continue;
    const char *dot = memrchr(name, '.', n);
    if (dot) print_prefix(out, name, (size_t)(dot - name));
    const char *own = dot ? dot + 1 : name;
    fprintf(out, "%.*s%s.", (int)(name + n - own), own, table->one ? "" : "[0]");
  }
}

void deck_paths_print(FILE *out) {
  for (size_t t = 0; t < deck_table_count; t++) {
    const deck_key *key;
    for (size_t k = 0; (key = deck_key_at(deck_tables[t], k)); k++) {
      if (key->kind == DECK_KEY_GROUP || key->kind == DECK_KEY_GROUPS) continue;
      print_prefix(out, deck_tables[t]->name, strlen(deck_tables[t]->name));
      fprintf(out, "%s\n", key->name);
    }
  }
}

/* --- words of other programs and of textbooks, with the keys and values that mean the same ---- */

/* Words of other programs for keys and for values of choices. A word is looked up only in tables
 * that have the key `ours`, and in choices that accept the value `ours`. hint: text that follows
 * "did you mean"; NULL: `ours` itself. */
#define MODULUS "E_star, of two bodies of one material E/(2 (1 - nu^2))"
static const struct word {
  const char *word, *ours, *hint;
} words[] = {
    {"friction", "mu", NULL},
    {"friction_coefficient", "mu", NULL},
    {"coefficient_of_friction", "mu", NULL},
    {"mu_s", "mu", NULL},
    {"xmu", "mu", NULL},
    {"mu_d", "mu_kinetic", NULL},
    {"rolling_friction", "mu_r", NULL},
    {"mu_rolling", "mu_r", NULL},
    {"e", "restitution", NULL},
    {"e_n", "restitution", NULL},
    {"en", "restitution", NULL},
    {"cor", "restitution", NULL},
    {"coefficient_of_restitution", "restitution", NULL},
    {"stiffness", "k_n", NULL},
    {"kn", "k_n", NULL},
    {"kt", "k_t", NULL},
    {"ks", "k_t", NULL},
    {"k_s", "k_t", NULL},
    {"viscosity", "gamma_n", NULL},
    {"damping", "gamma_n", "gamma_n or restitution"},
    {"young", "E_star", MODULUS},
    {"youngs_modulus", "E_star", MODULUS},
    {"young_modulus", "E_star", MODULUS},
    {"youngsModulus", "E_star", MODULUS},
    {"E", "E_star", MODULUS},
    {"E_eff", "E_star", NULL},
    {"Estar", "E_star", NULL},
    {"poisson_ratio", "poisson", NULL},
    {"poissons_ratio", "poisson", NULL},
    {"poissonsRatio", "poisson", NULL},
    {"nu", "poisson", NULL},
    {"adhesion", "cohesion", NULL},
    {"spread", "deviation", NULL},
    {"sigma", "deviation", NULL},
    {"std", "deviation", NULL},
    {"stddev", "deviation", NULL},
    {"standard_deviation", "deviation", NULL},
    {"shear_rate", "rate_xy", NULL},
    {"strain_rate", "rate_xy", "rate_xx, rate_yy or rate_xy"},
    {"pressure", "stress_xx", "stress_xx and stress_yy"},
    {"p", "stress_xx", "stress_xx and stress_yy"},
    {"stress", "stress_xx", "stress_xx, stress_yy or stress_xy"},
    {"diameter", "radius", "radius, half of it"},
    {"r", "radius", NULL},
    {"position", "vx", "x and y"},
    {"pos", "vx", "x and y"},
    {"velocity", "vx", "vx and vy"},
    {"angle", "theta", NULL},
    {"timestep", "dt", NULL},
    {"time_step", "dt", NULL},
    {"duration", "time", NULL},
    {"t_end", "time", NULL},
    /* Values */
    {"sine", "harmonic", NULL},
    {"sin", "harmonic", NULL},
    {"sinusoidal", "harmonic", NULL},
    {"cosine", "harmonic", NULL},
    {"cos", "harmonic", NULL},
    {"wiggle", "harmonic", NULL},
    {"oscillate", "harmonic", NULL},
    {"sawtooth", "triangle", NULL},
    {"noise", "random", NULL},
    {"constant", "velocity", NULL},
    {"pour", "rain", NULL},
    {"insert", "rain", NULL},
    {"deposit", "rain", NULL},
    {"deposition", "rain", NULL},
    {"gravity_deposit", "rain", NULL},
    {"hexagonal", "triangular", NULL},
    {"hex", "triangular", NULL},
    {"hcp", "triangular", NULL},
    {"cubic", "square", NULL},
    {"sc", "square", NULL},
    {"monodisperse", "mono", NULL},
    {"equal", "mono", NULL},
    {"constant", "mono", NULL},
    {"bidisperse", "list", NULL},
    {"discrete", "list", NULL},
    {"polydisperse", "uniform", NULL},
    {"poly", "uniform", NULL},
    {"poly", "polyline", NULL},
    {"normal", "gaussian", NULL},
    {"hooke", "linear", NULL},
    {"hookean", "linear", NULL},
    {"lsd", "linear", NULL},
    {"spring_dashpot", "linear", NULL},
    {"hertz_mindlin", "hertz", NULL},
    {"plane", "line", NULL},
    {"cylinder", "circle", NULL},
    {"cylinder", "drum", NULL},
    {"rectangle", "box", NULL},
    {"both", "xy", NULL},
    {"leapfrog", "verlet", NULL},
    {"velocity_verlet", "verlet", NULL},
    {"viscous", "drag", NULL},
    {"cundall", "damping", NULL},
    {"local", "damping", NULL},
    {"coriolis", "rotation", NULL},
    {"centrifugal", "rotation", NULL},
    {"capillary", "bridge", NULL},
    {"liquid_bridge", "bridge", NULL},
    {"delete", "remove", NULL},
    {"h5", "hdf5", NULL},
    {"data", "lammps", NULL},
};

static bool accepts(const deck_key *choice, const char *value) {
  const deck_shape *word = choice->words;
  while (word->name && strcmp(word->name, value) != 0) word++;
  return word->name;
}

/* Returns the hint of a word that stands for a key of the table, or for a value of the choice if
 * the table is NULL; NULL: no hint. */
static const char *other_word(deck *d, const deck_table *table, const deck_key *choice,
                              const char *word) {
  for (size_t k = 0; k < sizeof words / sizeof *words; k++) {
    const struct word *w = &words[k];
    /* Single letters are compared with their case: "E" is not "e" */
    const bool same =
        word[0] && word[1] ? strcasecmp(word, w->word) == 0 : strcmp(word, w->word) == 0;
    if (!same || !(table ? deck_key_find(table, w->ours) != NULL : accepts(choice, w->ours)))
      continue;
    return w->hint ? deck_format(d, "; did you mean %s?", w->hint)
                   : deck_format(d, "; did you mean \"%s\"?", w->ours);
  }
  return NULL;
}

const char *deck_other_word(deck *d, const deck_table *table, const char *word) {
  return other_word(d, table, NULL, word);
}

const char *deck_other_value(deck *d, const deck_key *choice, const char *word) {
  return other_word(d, NULL, choice, word);
}

/* keys.c: table of the keys of an input deck that set members of the model, except keys of
 * contact laws (laws.c). See keys.h. */
#include "model/keys.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "model/model.h"

static const deck_shape integrators[] = {WORD("gear5", SD_GEAR5), WORD("verlet", SD_VERLET),
                                         LAST_WORD};
static const deck_shape variants[] = {WORD("paper", SD_PAPER),
                                      WORD("conservative", SD_CONSERVATIVE), LAST_WORD};
static const deck_shape outside_words[] = {WORD("report", SD_OUTSIDE_REPORT),
                                           WORD("stop", SD_OUTSIDE_STOP),
                                           WORD("remove", SD_OUTSIDE_REMOVE), LAST_WORD};
/* Periodic directions; bit c of a value is set if the box is periodic along coordinate c. */
static const deck_shape periodic_directions[] = {WORD("none", 0), WORD("x", 1), WORD("y", 2),
                                                 WORD("xy", 3), LAST_WORD};

static const deck_key top_keys[] = {
    {"title", TEXT, "\"\"", NULL, "one line about this run", SETS(sd_model, title)},
    {"seed", INTEGER(DECK_NOT_NEGATIVE, "-"), "1", NULL, "seed of all random streams",
     SETS(sd_model, seed)},
    {"integrator", CHOICE, "\"gear5\"", integrators,
     "fifth-order Gear predictor-corrector, or velocity Verlet", SETS(sd_model, integrator)},
    {"dt", NUMBER(DECK_POSITIVE, "time"), "required", NULL, "time step", SETS(sd_model, dt)},
    {"contact_variant", CHOICE, "\"paper\"", variants,
     "tangential force on the centres: tau (paper), tau (R_a+R_b)/r (conservative)",
     SETS(sd_model, variant)},
    {"skin", NUMBER(DECK_NOT_NEGATIVE, "length"), "0.0", NULL,
     "margin of the neighbour list; 0: automatic", SETS(sd_model, skin)},
    {"max_overlap", NUMBER(DECK_UP_TO_1, "-"), "0.5", NULL,
     "largest overlap over the smaller radius; else the run stops", SETS(sd_model, max_overlap)},
    {"checkpoint", NUMBER(DECK_POSITIVE, "s"), "60.0", NULL, "wall time between checkpoints"},
    {"steps", INTEGER(DECK_AT_LEAST_1, "steps"), "-", NULL, "length of a run without phases"},
    {"time", NUMBER(DECK_POSITIVE, "time"), "-", NULL, "the same in time, rounded to whole steps"},
    {"constants", GROUP, "-", NULL, "named numbers for arithmetic"},
    {"gravity", GROUP, "-", NULL, "strength and direction"},
    {"box", GROUP, "-", NULL, "periodic directions"},
    {"materials", GROUPS, "required", NULL, "contact laws"},
    {"material_pairs", GROUPS, "-", NULL, "contact laws of different materials"},
    {"container", GROUP, "-", NULL, "box, hopper, drum and others, made of walls"},
    {"disks", GROUPS, "-", NULL, "disks, one by one"},
    {"disk_rows", GROUPS, "-", NULL, "disks, a row each"},
    {"disk_files", GROUPS, "-", NULL, "disks, from files"},
    {"packings", GROUPS, "-", NULL, "disks, placed by a generator"},
    {"bounds", GROUP, "-", NULL, "region of the disks"},
    {"forces", GROUPS, "-", NULL, "constant forces and torques"},
    {"locks", GROUPS, "-", NULL, "coordinates that never change"},
    {"clumps", GROUPS, "-", NULL, "rigid bodies of several disks"},
    {"walls", GROUPS, "-", NULL, "walls"},
    {"motions", GROUPS, "-", NULL, "prescribed motions"},
    {"fields", GROUPS, "-", NULL, "drag, damping, forces by position and velocity"},
    {"phases", GROUPS, "-", NULL, "parts of the run"},
    {"output", GROUP, "-", NULL, "how often results are stored"},
    {"measure", GROUP, "-", NULL, "what is measured"},
    {"until", GROUP, "-", NULL, "error bar that ends the last phase"},
    {"limits", GROUP, "-", NULL, "limits beyond which a run is in doubt"},
    {"sweep", GROUPS, "-", NULL, "variations of this deck for `slipdisk sweep`"},
};
TABLE_EITHER(deck_top, "deck", true, "Keys of the deck itself, outside any group.", top_keys,
             "steps/time");

static const deck_key gravity_keys[] = {
    {"g", NUMBER(DECK_NOT_NEGATIVE, "length/time^2"), "0.0", NULL, "strength"},
    {"tilt", ANGLE("rad"), "0.0", NULL, "the acceleration is -g (sin tilt, cos tilt)"},
};
TABLE(deck_gravity, "gravity", true, "Without this group there is no gravity.", gravity_keys);

static const deck_key box_keys[] = {
    {"x", NUMBERS(DECK_ANY, "length"), "-", NULL,
     "[lower, upper] edge; required when periodic in x"},
    {"y", NUMBERS(DECK_ANY, "length"), "-", NULL,
     "[lower, upper] edge; required when periodic in y"},
    {"periodic", CHOICE, "\"none\"", periodic_directions, "periodic directions"},
    {"file", TEXT, "-", NULL,
     "result, H5MD, LAMMPS data or dump whose last frame gives the periodic edges missing here"},
    {"timestep", INTEGER(DECK_NOT_NEGATIVE, "steps"), "(the last)", NULL, "LAMMPS dump: the frame"},
};
TABLE(deck_box, "box", true, "Without this group space is open.", box_keys);

static const deck_key bounds_keys[] = {
    {"x", NUMBERS(DECK_ANY, "length"), "(of the container, else far out)", NULL,
     "[lower, upper] limit of the centres"},
    {"y", NUMBERS(DECK_ANY, "length"), "(of the container, else far out)", NULL,
     "[lower, upper] limit of the centres"},
    {"outside", CHOICE, "\"report\"", outside_words,
     "when a disk leaves: warn, end the run, or warn and remove it", SETS(sd_bounds, outside)},
};
TABLE(
    deck_bounds, "bounds", true,
    "The region of the disks. Those that leave it are counted and reported with position and step.",
    bounds_keys);

static const deck_key limits_keys[] = {
    {"residual", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.01", NULL,
     "residual of the energy budget over its scale; 0: no limit", SETS(sd_limits, residual)},
    {"open", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.99", NULL,
     "fraction of the measured time in which a watched contact is open; 0: no limit",
     SETS(sd_limits, open)},
    {"displacement", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.1", NULL,
     "displacement of a disk or wall in one step, over the radius; 0: no limit",
     SETS(sd_limits, displacement)},
    {"unstable_step", BOOL, "(false)", NULL,
     "allow dt beyond the limit of stability (`slipdisk check` prints it)",
     SETS(sd_limits, unstable_step)},
};
TABLE(deck_limits, "limits", true,
      "A finished run beyond a limit is in doubt: it warns, with exit status 5.", limits_keys);

static const deck_key phase_keys[] = {
    {"name", TEXT, "-", NULL, "name in messages and results", SETS(sd_phase, name)},
    {"steps", INTEGER(DECK_AT_LEAST_1, "steps"), "-", NULL, "length; either this or time"},
    {"time", NUMBER(DECK_POSITIVE, "time"), "-", NULL, "the same in time, rounded to whole steps"},
    {"motions", BODIES, "(all)", NULL, "active motions; () for none"},
    {"fields", BODIES, "(all)", NULL, "active fields; () for none"},
    {"hold", BODIES, "-", NULL, "disks (or groups) held in their place from here on"},
    {"release", BODIES, "-", NULL,
     "disks (or groups) free from here on: fixed ones, and those that motions move"},
    {"measure", BOOL, "(true in the last phase)", NULL, "gather statistics",
     SETS(sd_phase, measure)},
    {"settle", GROUP, "-", NULL, "criterion that ends the phase early"},
    {"relax", BOOL, "false", NULL, "seek equilibrium by FIRE, which is no dynamics",
     SETS(sd_phase, relax)},
    {"compress", GROUP, "-", NULL, "shrink the periodic box or container with its contents"},
    {"cell", GROUP, "-", NULL, "shear or stretch the periodic box at given rates or stresses"},
    {"bond", GROUP, "-", NULL, "bond surfaces that are near each other"},
    {"series", INTEGER(DECK_NOT_NEGATIVE, "steps"), "(as in output)", NULL,
     "steps between rows of the series; 0: none", SETS(sd_phase, series_every)},
    {"frames", INTEGER(DECK_NOT_NEGATIVE, "steps"), "(as in output)", NULL,
     "steps between stored frames; 0: none", SETS(sd_phase, frames_every)},
    {"contacts", INTEGER(DECK_NOT_NEGATIVE, "steps"), "(as in output)", NULL,
     "steps between contact tables; 0: none", SETS(sd_phase, contacts_every)},
};
TABLE_EITHER(deck_phases, "phases", false, "A part of the run.", phase_keys, "steps/time");

static const deck_key settle_keys[] = {
    {"kinetic", NUMBER(DECK_POSITIVE, "energy"), "-", NULL, "largest kinetic energy per free disk",
     SETS(sd_settle, kinetic)},
    {"unbalanced", NUMBER(DECK_POSITIVE, "-"), "-", NULL,
     "largest mean resultant force on a disk over mean contact force", SETS(sd_settle, unbalanced)},
    {"every", INTEGER(DECK_AT_LEAST_1, "steps"), "1000", NULL, "steps between checks",
     SETS(sd_settle, every)},
};
TABLE(deck_settle, "phases.settle", true,
      "The phase ends at the first check at which all given conditions hold, at the latest after "
      "its full length.",
      settle_keys);

static const deck_key compress_keys[] = {
    {"pressure", NUMBER(DECK_POSITIVE, "force/length"), "-", NULL,
     "target pressure; either this or fraction", SETS(sd_compress, pressure)},
    {"fraction", NUMBER(DECK_UP_TO_1, "-"), "-", NULL, "target packing fraction",
     SETS(sd_compress, fraction)},
    {"rate", NUMBER(DECK_POSITIVE, "1/time"), "required", NULL,
     "largest relative change of the lengths per time", SETS(sd_compress, rate)},
    {"tolerance", NUMBER(DECK_POSITIVE, "-"), "1e-3", NULL,
     "accepted relative distance from the target", SETS(sd_compress, tolerance)},
};
TABLE_EITHER(deck_compress, "phases.compress", true,
             "The box or container and all positions change by the same factor. With `settle` the "
             "phase ends once the target is reached and `settle` holds.",
             compress_keys, "pressure/fraction");

#define CELL_RATE(name, component, meaning)                                                        \
  { name, NUMBER(DECK_ANY, "1/time"), "-", NULL, meaning, SETS(sd_cell, rate[component]) }
#define CELL_STRESS(name, component, meaning)                                                      \
  { name, NUMBER(DECK_ANY, "force/length"), "-", NULL, meaning, SETS(sd_cell, stress[component]) }
static const deck_key cell_keys[] = {
    CELL_RATE("rate_xx", SD_CELL_XX, "rate of elongation in x over the length; without it 0"),
    CELL_RATE("rate_yy", SD_CELL_YY, "the same in y"),
    CELL_RATE("rate_xy", SD_CELL_XY, "shear rate dvx/dy (Lees-Edwards)"),
    CELL_STRESS("stress_xx", SD_CELL_XX,
                "stress that the length in x is controlled to, compression positive"),
    CELL_STRESS("stress_yy", SD_CELL_YY, "the same in y"),
    CELL_STRESS("stress_xy", SD_CELL_XY,
                "shear stress that the shear is controlled to; a positive rate makes it negative"),
    {"response", NUMBER(DECK_POSITIVE, "time"), "-", NULL,
     "response time of controlled stresses; without it 4 sqrt(mean mass/largest stress)",
     SETS(sd_cell, response)},
    {"max_rate", NUMBER(DECK_NOT_NEGATIVE, "1/time"), "0", NULL,
     "largest rate of controlled components; 0: no limit", SETS(sd_cell, max_rate)},
    {"boundary", BOOL, "false", NULL,
     "true: a change of the rates moves the periodic images only; false: all disks at once",
     SETS(sd_cell, boundary)},
};
TABLE(deck_cell, "phases.cell", true,
      "The periodic box deforms with its contents. Give the rate or the stress of a component; "
      "without either it does not change.",
      cell_keys);

static const deck_key bond_keys[] = {
    {"disk", BODIES, "-", NULL, "disks between which bonds are made; nothing named: all bodies"},
    {"group", NAMES, "-", NULL, "groups of disks"},
    {"wall", BODIES, "-", NULL, "walls"},
    {"file", TEXT, "-", NULL,
     "CSV file with the columns a and b: numbers of two disks per row, in place of the keys above"},
    {"sinter", BOOL, "false", NULL, "bond each contact that begins in the phase, too",
     SETS(sd_bonding, sinter)},
    {"begin", BOOL, "true", NULL, "bond pairs at the beginning of the phase",
     SETS_OFF(sd_bonding, later)},
};
TABLE(deck_bond, "phases.bond", true,
      "Bonds all pairs of surfaces whose gap is at most `bond_gap` of their law, see "
      "[bonds](laws.md#bonds).",
      bond_keys);

static const deck_key output_keys[] = {
    {"series", INTEGER(DECK_NOT_NEGATIVE, "steps"), "(a thousandth of each phase)", NULL,
     "steps between rows of the series; 0: none"},
    {"frames", INTEGER(DECK_NOT_NEGATIVE, "steps"), "0", NULL,
     "steps between stored frames; 0: none"},
    {"contacts", INTEGER(DECK_NOT_NEGATIVE, "steps"), "0", NULL,
     "steps between contact tables; 0: none"},
};
TABLE(deck_output, "output", true, "How often results are stored, unless a phase says otherwise.",
      output_keys);

static const deck_key measure_keys[] = {
    {"rotation", BODIES, "(all free disks when at most 16, else none)", NULL,
     "disks with a mean angular velocity; () for none"},
    {"sliding", GROUPS, "-", NULL, "pairs of watched contacts"},
    {"configurations", BOOL, "false", NULL,
     "sliding: also torque, normal forces and duration of visits of each configuration",
     SETS(sd_model, measure_configurations)},
    {"disks", BOOL, "false", NULL,
     "means of each free disk and of all: rotation, position, contacts, powers",
     SETS(sd_model, measure_disks)},
    {"averages", GROUP, "-", NULL,
     "means with error bars of the series: name = \"column, sum or ratio of sums\""},
    {"every", INTEGER(DECK_AT_LEAST_1, "steps"), "1", NULL,
     "disks: steps between samples of the contacts", SETS(sd_model, measure_every)},
    {"walls", BOOL, "-", NULL, "series: force and torque on each wall, its contacts",
     SETS(sd_model, measure_walls)},
    {"groups", BOOL, "-", NULL, "series: the same for each group of disks",
     SETS(sd_model, measure_groups)},
    {"contacts", BODIES, "-", NULL, "series: the same for these disks"},
    {"box", BOOL, "-", NULL, "series: width and height of the region", SETS(sd_model, measure_box)},
    {"stress", BOOL, "-", NULL, "series: contact and kinetic stress of the region",
     SETS(sd_model, measure_stress)},
    {"rattlers", BOOL, "-", NULL, "series: rattlers, and coordination of the other disks",
     SETS(sd_model, measure_rattlers)},
    {"fragments", BOOL, "-", NULL, "series: number and largest mass of bodies of bonded disks",
     SETS(sd_model, measure_fragments)},
};
TABLE(deck_measure, "measure", true,
      "Means are taken in phases that measure, series in all phases.", measure_keys);

static const deck_key sliding_keys[] = {
    {"disk", BODIES, "required", NULL, "the disk"},
    {"partners", BODIES, "required", NULL,
     "its two partners, disks or walls: first and second sign of S++"},
};
TABLE(deck_sliding, "measure.sliding", false, "A disk with two watched contacts.", sliding_keys);

static const deck_key until_keys[] = {
    {"observable", TEXT, "(omega of the first watched disk)", NULL,
     "\"NAME.omega\" or \"NAME.scaled\": Omega or t_g Omega of a watched disk (name or number)"},
    {"error", NUMBER(DECK_POSITIVE, "rad/time or rad"), "-", NULL,
     "target standard error; either this or relative", SETS(sd_until, error)},
    {"relative", NUMBER(DECK_POSITIVE, "-"), "-", NULL,
     "target standard error over the size of the mean", SETS(sd_until, relative)},
    {"max_time", NUMBER(DECK_POSITIVE, "time"), "required", NULL,
     "longest duration of the last phase"},
};
TABLE_EITHER(deck_until, "until", true,
             "The last phase is extended until an error bar is small enough.", until_keys,
             "error/relative");

const deck_key *deck_key_at(const deck_table *table, size_t k) {
  if (k < table->n) return &table->key[k];
  return table->more ? deck_key_at(table->more, k - table->n) : NULL;
}

const deck_key *deck_key_find(const deck_table *table, const char *name) {
  const deck_key *key;
  for (size_t k = 0; (key = deck_key_at(table, k)); k++)
    if (strcmp(key->name, name) == 0) return key;
  return NULL;
}

/* --- ranges ----------------------------------------------------------------------------------- */

const char *deck_range_text(deck_range range) {
  static const char *const text[] = {"", "> 0", ">= 0", ">= 1", "> 0 and <= 1"};
  return text[range];
}

/* True if 1/LIMIT_NUMBER <= |x| <= LIMIT_NUMBER, so that 1/x and products of three such numbers
 * are finite and not subnormal. */
static bool has_size(double x) { return fabs(x) >= 1 / LIMIT_NUMBER && fabs(x) <= LIMIT_NUMBER; }

bool deck_in_range(deck_range range, double x) {
  switch (range) {
    case DECK_ANY: return fabs(x) <= LIMIT_NUMBER;
    case DECK_POSITIVE: return x > 0 && has_size(x);
    case DECK_NOT_NEGATIVE: return x == 0 || (x > 0 && has_size(x));
    case DECK_AT_LEAST_1: return x >= 1 && has_size(x);
    case DECK_UP_TO_1: return x > 0 && x <= 1 && has_size(x);
  }
  return true;
}

const char *deck_expected(deck_range range, double x) {
  static const char *const sized[] = {"from -1e100 to 1e100", "> 0, from 1e-100 to 1e100",
                                      "0 or from 1e-100 to 1e100", "from 1 to 1e100",
                                      "from 1e-100 to 1"};
  bool wrong_size = fabs(x) > LIMIT_NUMBER || (x != 0 && fabs(x) < 1 / LIMIT_NUMBER);
  return wrong_size ? sized[range] : deck_range_text(range);
}

/* --- members ---------------------------------------------------------------------------------- */

/* Returns the enum value of the word in a default like "\"verlet\"", with quotation marks; 0 if
 * the list has no such word. */
static int word_value(const deck_shape *word, const char *quoted) {
  for (; word->name; word++)
    if (strncmp(quoted + 1, word->name, strlen(word->name)) == 0 &&
        quoted[1 + strlen(word->name)] == '"')
      return word->kind;
  return 0;
}

void deck_key_defaults(const deck_table *table, void *members) {
  const deck_key *key;
  for (size_t k = 0; (key = deck_key_at(table, k)); k++) {
    const char *text = key->initial;
    if (text[0] == '(' || strcmp(text, "-") == 0 || strcmp(text, "required") == 0) continue;
    deck_key_store(key, members,
                   key->kind == DECK_KEY_BOOL ? (text[0] == 't') != (key->target == DECK_SETS_OFF)
                   : key->words               ? word_value(key->words, text)
                                              : strtod(text, NULL));
  }
}

/* True if x has the sign that the range requires. Its magnitude is not checked, since a program
 * may set a value far beyond a limit to switch it off. */
static bool has_sign(deck_range range, double x) {
  switch (range) {
    case DECK_ANY: return true;
    case DECK_NOT_NEGATIVE: return x >= 0;
    case DECK_AT_LEAST_1: return x >= 1;
    case DECK_POSITIVE:
    case DECK_UP_TO_1: return x > 0;
  }
  return true;
}

double deck_key_value(const deck_key *key, const void *members) {
  const void *member = (const char *)members + key->offset;
  switch (key->target) {
    case DECK_SETS_NUMBER: return *(const double *)member;
    case DECK_SETS_INTEGER: return (double)*(const int64_t *)member;
    case DECK_SETS_UNSIGNED: return (double)*(const uint64_t *)member;
    case DECK_SETS_BOOL:
    case DECK_SETS_OFF: return *(const bool *)member;
    case DECK_SETS_ENUM: return *(const int *)member;
    case DECK_SETS_NOTHING:
    case DECK_SETS_PAIR:
    case DECK_SETS_TEXT: break;
  }
  assert(false);
  return NAN;
}

bool deck_key_store(const deck_key *key, void *members, double value) {
  void *member = (char *)members + key->offset;
  switch (key->target) {
    case DECK_SETS_NUMBER: *(double *)member = value; return true;
    case DECK_SETS_INTEGER:
    case DECK_SETS_UNSIGNED:
      if (value != nearbyint(value) || !(fabs(value) < 0x1p53) ||
          (value < 0 && key->target == DECK_SETS_UNSIGNED))
        return false;
      *(int64_t *)member = (int64_t)value;
      return true;
    case DECK_SETS_BOOL:
    case DECK_SETS_OFF: *(bool *)member = value != 0.0; return true;
    case DECK_SETS_ENUM:
      for (const deck_shape *word = key->words; word && word->name; word++)
        if (word->kind == value) {
          *(int *)member = word->kind;
          return true;
        }
      return false;
    case DECK_SETS_NOTHING:
    case DECK_SETS_PAIR:
    case DECK_SETS_TEXT: break;
  }
  return false;
}

void deck_key_check(const deck_table *table, const void *members, const char *place,
                    sd_messages *messages) {
  const deck_key *key;
  for (size_t k = 0; (key = deck_key_at(table, k)); k++) {
    if (key->target != DECK_SETS_NUMBER && key->target != DECK_SETS_INTEGER) continue;
    double x = deck_key_value(key, members);
    bool absent = x == 0 && strchr("-(", key->initial[0]);
    if (!absent && !has_sign(key->range, x))
      fail_about(messages,
                 about_value(about_path("%s%s%s", place, *place ? "." : "", key->name), "%g", x),
                 "expected a number %s",
                 deck_range_text(key->range == DECK_UP_TO_1 ? DECK_POSITIVE : key->range));
  }
}

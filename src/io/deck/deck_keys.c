/* deck_keys.c: the tables of all keys, and the search for the nearest valid name. See deck_keys.h. */
#include <ctype.h>
#include <math.h>
#include <string.h>

#include "base/limits.h"
#include "io/deck/deck_keys.h"
#include "model/motion_kinds.h"

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
     "margin of the neighbour list; 0: chosen as the run goes"},
    {"max_overlap", NUMBER(DECK_UP_TO_1, "-"), "0.5", NULL,
     "a run stops when an overlap exceeds this fraction of the smaller radius"},
    {"checkpoint", NUMBER(DECK_POSITIVE, "s"), "60.0", NULL, "wall time between checkpoints"},
    {"steps", INTEGER(DECK_AT_LEAST_1, "steps"), "-", NULL, "length of the run when there are no phases"},
    {"time", NUMBER(DECK_POSITIVE, "time"), "-", NULL, "the same as a time, rounded to whole steps"},
    {"gravity", GROUP, "-", NULL, "strength and direction of gravity"},
    {"box", GROUP, "-", NULL, "periodic directions"},
    {"materials", GROUPS, "required", NULL, "contact law of each material with itself"},
    {"material_pairs", GROUPS, "-", NULL, "contact law between two different materials"},
    {"container", GROUP, "-", NULL, "a box, a bed, a hopper or a drum, made of walls"},
    {"disks", GROUPS, "-", NULL, "disks, one by one"},
    {"disk_rows", GROUPS, "-", NULL, "disks, a row each"},
    {"disk_files", GROUPS, "-", NULL, "disks, from files"},
    {"packings", GROUPS, "-", NULL, "disks, placed by a generator"},
    {"bounds", GROUP, "-", NULL, "where the disks belong; what leaves is reported"},
    {"forces", GROUPS, "-", NULL, "constant forces and torques"},
    {"locks", GROUPS, "-", NULL, "coordinates that never change"},
    {"walls", GROUPS, "-", NULL, "walls"},
    {"motions", GROUPS, "-", NULL, "prescribed motions of disks and walls"},
    {"phases", GROUPS, "-", NULL, "parts of the run, one after the other"},
    {"output", GROUP, "-", NULL, "how often results are stored"},
    {"measure", GROUP, "-", NULL, "what is measured"},
    {"until", GROUP, "-", NULL, "error bar at which the last phase ends"},
    {"limits", GROUP, "-", NULL, "beyond which a finished run is in doubt"},
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
    {"file", TEXT, "-", NULL,
     "result of a run, or LAMMPS data file, that gives the periodic edges not given here; of the last frame"},
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
    {"format", CHOICE, "(by the file's name)", "csv hdf5 lammps",
     "CSV with a line of names at the top, HDF5, or a LAMMPS data file"},
    {"dataset", TEXT, "(/particles/disks of a result)", NULL, "HDF5: the dataset"},
    {"columns", NAMES, "(all of CSV, LAMMPS and a result; else x, y, radius)", NULL,
     "columns to take: \"radius\", or \"radius = name in the file\""},
    {"contacts", BOOL, "false", NULL,
     "result or checkpoint of a run: take its contacts over too, so that the packing stays exactly as it "
     "was"},
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

static const deck_key container_keys[] = {
    {"type", CHOICE, "required", "box channel bed hopper drum periodic", "kind of container, see below"},
    {"width", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "inner width"},
    {"height", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "inner height"},
    {"radius", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "drum: its own; bed: of the disks of the floor"},
    {"spacing", NUMBER(DECK_POSITIVE, "length"), "(twice the radius)", NULL,
     "bed: distance of the disks of the floor, fitted to the width"},
    {"outlet", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "hopper: width of its opening"},
    {"angle", ANGLE("rad"), "-", NULL, "hopper: inclination of its lower walls, 0: a flat bottom"},
    {"origin", DECK_KEY_NUMBERS, DECK_ANY, "length", "(0.0, 0.0)", NULL,
     "middle of the floor or of the outlet; centre of a drum; lower left corner of a periodic box"},
    {"open", BOOL, "true", NULL, "box: without a lid"},
    {"material", TEXT, "(the only one)", NULL, "name of the material of its walls"},
};
TABLE(
    deck_container, "container", true,
    "Walls that hold the disks, with names that motions can use; the region that packings fill and in which "
    "disks belong.",
    container_keys);

const deck_shape deck_container_kinds[] = {
    {"box", SD_CONTAINER_BOX, "width* height* open",
     "walls `floor`, `left`, `right`, and `lid` unless open; straight lines"},
    {"channel", SD_CONTAINER_CHANNEL, "width* height*", "periodic in x over a flat wall `floor`"},
    {"bed", SD_CONTAINER_BED, "width* height* radius* spacing",
     "periodic in x over fixed disks, group `floor`"},
    {"hopper", SD_CONTAINER_HOPPER, "width* height* outlet* angle*",
     "walls `left` and `right`, inclined towards the outlet at the origin"},
    {"drum", SD_CONTAINER_DRUM, "radius*", "round wall `drum`, disks inside"},
    {"periodic", SD_CONTAINER_PERIODIC, "width* height*", "periodic in x and y, no walls"},
};
const size_t deck_container_kind_count = COUNT(deck_container_kinds);

static const deck_key packing_keys[] = {
    {"type", CHOICE, "required", "triangular square random front rain", "generator, see below"},
    {"count", INTEGER(DECK_AT_LEAST_1, "disks"), "-", NULL, "number of disks"},
    {"fraction", NUMBER(DECK_UP_TO_1, "-"), "-", NULL, "area of the disks over that of the region"},
    {"x", DECK_KEY_NUMBERS, DECK_ANY, "length", "(of the container)", NULL,
     "[lower, upper] edge of the region"},
    {"y", DECK_KEY_NUMBERS, DECK_ANY, "length", "(of the container)", NULL,
     "[lower, upper] edge of the region"},
    {"spacing", NUMBER(DECK_POSITIVE, "length"), "(largest diameter)", NULL,
     "lattices: distance of neighbouring sites"},
    {"jitter", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.0", NULL,
     "lattices: largest random displacement over the room that a disk has; 1: they may touch"},
    {"rows", INTEGER(DECK_AT_LEAST_1, "-"), "4", NULL, "rain: rows of disks in a batch"},
    {"interval", NUMBER(DECK_POSITIVE, "time"), "(the fall through a batch's height)", NULL,
     "rain: time between batches"},
    {"gap", NUMBER(DECK_NOT_NEGATIVE, "length"), "(largest radius)", NULL,
     "rain: from the highest disk so far to a new batch"},
    {"speed", NUMBER(DECK_NOT_NEGATIVE, "length/time"), "0.0", NULL,
     "rain: with which they set out downwards"},
    {"sizes", CHOICE, "\"mono\"", "mono list uniform gaussian lognormal powerlaw",
     "distribution of the radii, see below"},
    {"radius", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "radius; gaussian: mean; lognormal: median"},
    {"radii", DECK_KEY_NUMBERS, DECK_POSITIVE, "length", "-", NULL, "list: the radii"},
    {"weights", DECK_KEY_NUMBERS, DECK_NOT_NEGATIVE, "-", "(all equal)", NULL,
     "list: how frequent each radius is"},
    {"deviation", NUMBER(DECK_POSITIVE, "length or -"), "-", NULL,
     "gaussian: standard deviation; lognormal: that of ln(radius)"},
    {"lower", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "smallest radius"},
    {"upper", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "largest radius"},
    {"exponent", NUMBER(DECK_ANY, "-"), "-", NULL, "powerlaw: a in p(R) ~ R^-a"},
    {"density", NUMBER(DECK_POSITIVE, "mass/length^2"), "-", NULL, "mass per area; either this or mass"},
    {"mass", NUMBER(DECK_POSITIVE, "mass"), "-", NULL, "mass of every disk"},
    {"material", TEXT, "(the only one)", NULL,
     "name of the material; may be left out when there is one only"},
    {"group", TEXT, "-", NULL, "name of a group of disks, made by being used"},
};
TABLE(deck_packings, "packings", false,
      "Disks that a generator places; random numbers follow from the deck's seed and the packing's place in "
      "the "
      "deck.",
      packing_keys);

const deck_shape deck_packing_kinds[] = {
    {"triangular", SD_PACKING_TRIANGULAR, "count spacing jitter",
     "triangular lattice, from below; fills the region unless count is given"},
    {"square", SD_PACKING_SQUARE, "count spacing jitter", "square lattice, likewise"},
    {"random", SD_PACKING_RANDOM, "count/fraction*",
     "at random, without overlap; up to a fraction of about 0.5"},
    {"front", SD_PACKING_FRONT, "count",
     "advancing front: each disk touches two, dense and without overlap; fills the region unless count is "
     "given"},
    {"rain", SD_PACKING_RAIN, "count* rows interval gap speed",
     "disks wait and fall in batches from just above those that are there"},
};
const size_t deck_packing_kind_count = COUNT(deck_packing_kinds);

const deck_shape deck_size_kinds[] = {
    {"mono", SD_SIZES_MONO, "radius*", "all equal"},
    {"list", SD_SIZES_LIST, "radii* weights",
     "some radii, each as often as its weight says, in random order"},
    {"uniform", SD_SIZES_UNIFORM, "lower* upper*", "evenly between two radii"},
    {"gaussian", SD_SIZES_GAUSSIAN, "radius* deviation* lower upper",
     "normal distribution, cut at lower and upper (3 deviations unless given)"},
    {"lognormal", SD_SIZES_LOGNORMAL, "radius* deviation* lower upper",
     "normal distribution of ln R, cut likewise"},
    {"powerlaw", SD_SIZES_POWERLAW, "exponent* lower* upper*", "p(R) ~ R^-exponent between two radii"},
};
const size_t deck_size_kind_count = COUNT(deck_size_kinds);

static const deck_key bounds_keys[] = {
    {"x", DECK_KEY_NUMBERS, DECK_ANY, "length", "(of the container, else far out)", NULL,
     "[lower, upper] limit of the centres"},
    {"y", DECK_KEY_NUMBERS, DECK_ANY, "length", "(of the container, else far out)", NULL,
     "[lower, upper] limit of the centres"},
    {"outside", CHOICE, "\"report\"", "report stop remove",
     "a disk that leaves: tell and go on, end the run, or tell and take it out"},
};
TABLE(deck_bounds, "bounds", true,
      "Where the disks belong. Disks that leave are counted, and named with place and step.", bounds_keys);

#define WORD(kind, word, ...) " " #word
#define KEY(member, kind, range, unit, initial, meaning) {#member, kind, range, unit, initial, NULL, meaning},
static const deck_key motion_keys[] = {
    {"name", TEXT, "-", NULL, "name by which phases refer to it"},
    {"disk", BODIES, "-", NULL, "disks, by name or number"},
    {"group", NAMES, "-", NULL, "groups of disks"},
    {"wall", BODIES, "-", NULL, "walls, by name or number"},
    {"coordinate", COORDINATES, "required", NULL,
     "what moves; theta of a group turns each disk about its own centre"},
    {"type", CHOICE, "required", "fixed" MOTION_KINDS(WORD), "kind of motion, see below"},
    {"amplitude", ANGLE("length or rad"), "-", NULL, "amplitude; random: rms displacement"},
    {"acceleration", NUMBER(DECK_POSITIVE, "g"), "-", NULL,
     "in place of amplitude: peak acceleration in units of g; random: omega^2 times the rms displacement"},
    {"frequency", NUMBER(DECK_POSITIVE, "1/time"), "-", NULL, "cycles per time; either this or omega"},
    {"omega", ANGLE("rad/time"), "-", NULL, "angular frequency, > 0"},
    WAVE_KEYS(KEY){"velocity", ANGLE("length/time or rad/time"), "-", NULL, "constant velocity"},
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
    {"mass", NUMBER(DECK_POSITIVE, "mass"), "-", NULL, "load: mass of the wall, which gravity pulls too"},
    {"force", NUMBER(DECK_ANY, "force"), "(0.0 of a load)", NULL,
     "along the coordinate: on a load, besides its weight; by a servo on the disks"},
    {"pressure", NUMBER(DECK_POSITIVE, "force/length"), "-", NULL,
     "servo: force over the length of the wall, > 0 when it presses"},
    {"length", NUMBER(DECK_POSITIVE, "length"), "(of the segment, box or container)", NULL,
     "servo: length of the wall that the pressure acts on"},
    {"speed", NUMBER(DECK_POSITIVE, "length/time"), "-", NULL, "servo: largest speed"},
};
TABLE(deck_motions, "motions", false,
      "A prescribed displacement u(t), added to one or more coordinates of each body it names. Several "
      "motions on "
      "the same coordinate add up. t counts from the moment the motion is switched on.",
      motion_keys);

#define SHAPE(kind, word, source, amplitude, check, keys, meaning) {#word, kind, keys, meaning},
const deck_shape deck_motion_kinds[] = {{"fixed", DECK_MOTION_FIXED, "", "u = 0: the coordinate is held"},
                                        MOTION_KINDS(SHAPE)};
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
    {"settle", GROUP, "-", NULL, "criterion at which the phase ends before its length"},
    {"relax", BOOL, "false", NULL, "seek equilibrium: not dynamics, but velocities steered downhill (FIRE)"},
    {"compress", GROUP, "-", NULL, "shrink the periodic box, or the container, with all that is in it"},
    CADENCE("(as in output)", "(as in output)", "(as in output)")};
TABLE(deck_phases, "phases", false, "A part of the run.", phase_keys);

static const deck_key settle_keys[] = {
    {"kinetic", NUMBER(DECK_POSITIVE, "energy"), "-", NULL, "kinetic energy per free disk at most this"},
    {"unbalanced", NUMBER(DECK_POSITIVE, "-"), "-", NULL,
     "mean resultant force on a disk over mean contact force at most this"},
    {"every", INTEGER(DECK_AT_LEAST_1, "steps"), "1000", NULL, "steps from one look to the next"},
};
TABLE(deck_settle, "phases.settle", true,
      "The phase ends at the first look at which all that is given here holds; its length is the most it may "
      "take.",
      settle_keys);

static const deck_key compress_keys[] = {
    {"pressure", NUMBER(DECK_POSITIVE, "force/length"), "-", NULL, "to be reached; either this or fraction"},
    {"fraction", NUMBER(DECK_UP_TO_1, "-"), "-", NULL, "packing fraction to be reached"},
    {"rate", NUMBER(DECK_POSITIVE, "1/time"), "required", NULL,
     "largest relative change of the lengths per time"},
    {"tolerance", NUMBER(DECK_POSITIVE, "-"), "1e-3", NULL,
     "relative distance from the target that is near enough"},
};
TABLE(deck_compress, "phases.compress", true,
      "Lengths of the box or container and all positions change by the same factor. With `settle` the phase "
      "ends "
      "when the target is reached, too.",
      compress_keys);

static const deck_key output_keys[] = {CADENCE("(a thousandth of each phase)", "0", "0")};
TABLE(deck_output, "output", true, "How often results are stored, where a phase does not say otherwise.",
      output_keys);

static const deck_key measure_keys[] = {
    {"rotation", BODIES, "(all free disks when at most 16, else none)", NULL,
     "disks whose mean angular velocity is measured; () for none"},
    {"sliding", GROUPS, "-", NULL, "pairs of contacts whose sliding configurations are counted"},
    {"disks", BOOL, "false", NULL,
     "means of every free disk, and of all: rotation, position, contacts, powers"},
    {"every", INTEGER(DECK_AT_LEAST_1, "steps"), "1", NULL, "disks: steps between looks at the contacts"},
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

static const deck_key limits_keys[] = {
    {"residual", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.01", NULL,
     "of the residual of the energy budget, over its scale; 0: none"},
    {"open", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.99", NULL,
     "of the fraction of the measured time in which a watched contact is open; 0: none"},
    {"displacement", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.1", NULL,
     "of the displacement of a free disk in one step, over its radius; 0: none"},
};
TABLE(deck_limits, "limits", true,
      "Limits beyond which a finished run is in doubt: it is told, and the exit status is 5.", limits_keys);

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
    {"name", TEXT, "(last words of the path)", NULL, "name in the table and in file names"},
    {"values", DECK_KEY_VALUES, DECK_ANY, "-", "-", NULL, "list of values"},
    {"linspace", DECK_KEY_NUMBERS, DECK_ANY, "-", "-", NULL, "(first, last, count): evenly spaced"},
    {"logspace", DECK_KEY_NUMBERS, DECK_ANY, "-", "-", NULL,
     "(first, last, count): evenly spaced logarithms"},
    {"zip", TEXT, "-", NULL, "parameters with the same word here advance together; all others are crossed"},
};
TABLE(deck_sweep_parameters, "sweep.parameters", false, "A parameter and its values.", sweep_parameter_keys);

const deck_table *const deck_tables[] = {
    &deck_top,       &deck_gravity, &deck_box,       &deck_materials,  &deck_pairs,
    &deck_container, &deck_disks,   &deck_disk_rows, &deck_disk_files, &deck_packings,
    &deck_bounds,    &deck_forces,  &deck_locks,     &deck_walls,      &deck_motions,
    &deck_phases,    &deck_settle,  &deck_compress,  &deck_output,     &deck_measure,
    &deck_sliding,   &deck_until,   &deck_limits,    &deck_sweeps,     &deck_sweep_parameters,
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

/* 1/x and products of three stay finite, and above the subnormal numbers. */
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
                                      "0 or from 1e-100 to 1e100", "from 1 to 1e100", "from 1e-100 to 1"};
  bool wrong_size = fabs(x) > LIMIT_NUMBER || (x != 0 && fabs(x) < 1 / LIMIT_NUMBER);
  return wrong_size ? sized[range] : deck_range_text(range);
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
    if (table == &deck_container)
      print_shapes(out, "container type", deck_container_kinds, deck_container_kind_count);
    if (table == &deck_packings) {
      print_shapes(out, "packing type", deck_packing_kinds, deck_packing_kind_count);
      print_shapes(out, "sizes", deck_size_kinds, deck_size_kind_count);
    }
  }
}

/* deck_lammps.c: reads disks from a LAMMPS data file, as write_data makes it, or from a frame of
 * a text dump, as dump custom makes it. See deck_rows.h.
 *
 * Data files.  * Supported are atom styles with a diameter: sphere, bpm/sphere, and hybrid with
 * sphere first; the style is read from the comment behind "Atoms". z is ignored; x and y are
 * positions in the box, whatever the image flags. The density in the file is mass per volume of
 * a sphere, also in two dimensions, so the mass that LAMMPS used is density 4/3 pi R^3; it is
 * the column `mass` here. Format: https://docs.lammps.org/read_data.html
 *
 * Dumps. The line ITEM: ATOMS names the columns. Scaled coordinates (xs) are multiplied by the
 * edges of the box, unwrapped ones (xu) brought back into a periodic box. Format:
 * https://docs.lammps.org/dump.html */
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "io/deck/deck_rows.h"

enum { MOST_WORDS = 64, NO_COLUMN = -1 };

/* Index of each value in a line of the section Atoms, and number n of values in a line; three image
 * flags may follow. */
typedef struct atom_style {
  const char *name;
  /* True if the name is only the first part of the style, so that more values may follow in a
   * line */
  bool prefix;
  size_t type, diameter, density, x, n;
} atom_style;

static const atom_style styles[] = {
    {"sphere", false, 1, 2, 3, 4, 7},
    {"bpm/sphere", false, 2, 3, 4, 5, 8},
    {"hybrid sphere", true, 1, 5, 6, 2, 7},
};
enum { STYLES = sizeof styles / sizeof *styles };

/* Values of an atom that a column of disks can take: first numbers, then words. */
typedef enum source {
  X,
  Y,
  RADIUS,
  DIAMETER,
  MASS,
  VX,
  VY,
  OMEGA,
  ANGLE,
  NUMBERS,
  TYPE = NUMBERS,
  ID,
  SOURCES
} source;
static const char *const source_names[SOURCES] = {"x",  "y",     "radius", "diameter", "mass", "vx",
                                                  "vy", "omega", "angle",  "type",     "id"};

typedef struct atom {
  long long id;
  const char *type;
  double value[NUMBERS];
  deck_place place;
} atom;

/* How the position of an atom is written in a dump. */
typedef enum position { PLAIN, SCALED, UNWRAPPED, SCALED_UNWRAPPED, POSITIONS } position;

/* A frame of a dump. */
typedef struct dump_frame {
  long long step, announced; /* announced: number of atoms in the head of the frame */
  double edge[2][2];
  bool periodic[2];
  char *rows;       /* Text of the first atom */
  deck_place place; /* Line ITEM: ATOMS; atoms follow it */
  size_t n_columns;
  int column[SOURCES]; /* Column of each source; -1: none */
  position written[2]; /* Form of x and y */
} dump_frame;

typedef struct lammps {
  deck *d;
  char *p; /* Text that is still to be read */
  deck_place here;
  size_t n_words;
  char *word[MOST_WORDS]; /* Words of the current line, without its comment */
  const char *comment;    /* Comment of the current line, "" if there is none */

  long long announced; /* Number of atoms according to the header; -1: missing */
  double edge[2][2];
  bool bounded[2], tilted;

  const atom_style *style;
  size_t n_atoms, capacity;
  atom *atoms;
  bool has[SOURCES]; /* Sources that the file has */
  bool sorted, crowded;

  bool dump;
  dump_frame frame; /* The chosen frame of a dump */
} lammps;

/* --- lines ------------------------------------------------------------------------------------ */

/* Reads the next line that holds more than a comment, and splits it into words; false at the end of
 * the file. The first line of a data file, a title, is skipped. */
static bool next_line(lammps *in) {
  while (*in->p) {
    char *line = in->p, *end = strchr(line, '\n'), *rest = NULL;
    in->p = end ? end + 1 : line + strlen(line);
    if (end) *end = 0;
    in->here.line++;
    if (in->here.line == 1 && !in->dump) continue;
    char *hash = strchr(line, '#');
    in->comment = "";
    if (hash) {
      *hash = 0;
      for (hash++; isspace((unsigned char)*hash); hash++) continue;
      for (size_t n = strlen(hash); n && isspace((unsigned char)hash[n - 1]);) hash[--n] = 0;
      in->comment = hash;
    }
    in->n_words = 0;
    for (char *w = strtok_r(line, " \t\r", &rest); w && in->n_words < MOST_WORDS;
         w = strtok_r(NULL, " \t\r", &rest))
      in->word[in->n_words++] = w;
    if (in->n_words) return true;
  }
  return false;
}

static bool is_keyword(const lammps *in) { return isalpha((unsigned char)in->word[0][0]); }

static bool number(const lammps *in, size_t k, const char *what, double *x) {
  char *end;
  *x = strtod(in->word[k], &end);
  if (end != in->word[k] && !*end && isfinite(*x)) return true;
  deck_fail_place(in->d, in->here, "%s = %s: expected a number", what,
                  deck_quote(in->d, in->word[k], strlen(in->word[k])));
  *x = NAN;
  return false;
}

static bool whole(const lammps *in, size_t k, const char *what, long long *n) {
  char *end;
  *n = strtoll(in->word[k], &end, 10);
  if (end != in->word[k] && !*end) return true;
  deck_fail_place(in->d, in->here, "%s = %s: expected a whole number", what,
                  deck_quote(in->d, in->word[k], strlen(in->word[k])));
  return false;
}

/* --- header ----------------------------------------------------------------------------------- */

static void header_line(lammps *in) {
  static const char *const edges[2][2] = {{"xlo", "xhi"}, {"ylo", "yhi"}};
  size_t n = in->n_words;
  char **w = in->word;
  if (n == 2 && strcmp(w[1], "atoms") == 0) whole(in, 0, "atoms", &in->announced);
  for (int c = 0; c < 2; c++)
    if (n == 4 && strcmp(w[2], edges[c][0]) == 0 && strcmp(w[3], edges[c][1]) == 0)
      in->bounded[c] = number(in, 0, edges[c][0], &in->edge[c][0]) &&
                       number(in, 1, edges[c][1], &in->edge[c][1]);
  double tilt = 0;
  if (n == 6 && strcmp(w[3], "xy") == 0 && number(in, 0, "xy", &tilt)) in->tilted |= tilt != 0;
  if (n == 4 && strcmp(w[3], "avec") == 0) in->tilted = true;
}

static bool find_frame(lammps *in, const deck_node *file, long long step);

/* Reads the header of a data file up to the keyword of the first section, which becomes the current
 * line, or finds the frame of a dump at this step (-1: the last frame). Returns false after an
 * error, which is reported. */
static bool open_file(lammps *in, deck *d, const deck_node *file, long long step) {
  const char *path = deck_resolve(d, d->path, file->value.text);
  *in = (lammps){.d = d, .here = {path, 0}, .announced = -1};
  in->p = deck_read_file(d, path, (uint64_t)LIMIT_TABLE * LIMIT_MIB, file->place, "file");
  if (!in->p) return false;
  in->dump = strncmp(in->p, "ITEM:", 5) == 0;
  if (in->dump) return find_frame(in, file, step);
  if (step >= 0) {
    deck_fail(d, file, "a data file has no timesteps; the key timestep is for dumps of LAMMPS");
    return false;
  }
  bool more;
  while ((more = next_line(in)) && !is_keyword(in)) header_line(in);
  if (in->tilted) {
    deck_fail(d, file, "the box of this LAMMPS file is tilted; expected a rectangular one");
    return false;
  }
  if (!more || in->announced < 0) {
    const deck_node *format = deck_child(file->parent, "format");
    deck_fail(
        d, file,
        "this is no LAMMPS data file or dump%s: expected a header with the number of atoms and "
        "sections, or ITEM: TIMESTEP",
        format && format->defaulted
            ? ", which its name stands for (a table with a line of names needs "
              "format = \"csv\")"
            : "");
    return false;
  }
  return true;
}

bool deck_lammps_box(deck *d, const deck_node *file, int64_t step, double lower[2],
                     double upper[2]) {
  lammps in;
  if (!open_file(&in, d, file, step)) return false;
  if (in.dump) {
    d->box_path = in.here.file;
    d->box_step = in.frame.step;
  }
  for (int c = 0; c < 2; c++) {
    if (in.dump) {
      lower[c] = in.frame.edge[c][0];
      upper[c] = in.frame.periodic[c] ? in.frame.edge[c][1] : lower[c];
      continue;
    }
    if (!in.bounded[c] || !(in.edge[c][0] < in.edge[c][1])) {
      deck_fail(d, file, "the header of this LAMMPS file has no bounds %clo < %chi", "xy"[c],
                "xy"[c]);
      return false;
    }
    lower[c] = in.edge[c][0];
    upper[c] = in.edge[c][1];
  }
  return true;
}

/* --- sections --------------------------------------------------------------------------------- */

static bool choose_style(lammps *in) {
  for (int k = 0; k < STYLES && !in->style; k++) {
    size_t n = strlen(styles[k].name);
    if (strncmp(in->comment, styles[k].name, n) == 0 &&
        (!in->comment[n] || (styles[k].prefix && isspace((unsigned char)in->comment[n]))))
      in->style = &styles[k];
  }
  if (in->style) return true;
  const char *expected =
      "expected # sphere, # bpm/sphere or # hybrid sphere ..., styles with a diameter";
  if (!*in->comment)
    deck_fail_place(in->d, in->here, "Atoms: the atom style is not given in a comment; %s",
                    expected);
  else if (strcmp(in->comment, "hybrid") == 0)
    deck_fail_place(in->d, in->here,
                    "Atoms # hybrid: which styles it is made of is not said (older LAMMPS); %s",
                    expected);
  else
    deck_fail_place(in->d, in->here, "Atoms # %s: %s",
                    deck_quote(in->d, in->comment, strlen(in->comment)), expected);
  return false;
}

/* Returns memory for the atom of the current line; NULL if there are too many, which is reported.
 * The caller counts it. */
static atom *new_atom(lammps *in) {
  if (in->n_atoms == LIMIT_DISKS) {
    if (!in->crowded) deck_fail_place(in->d, in->here, "more than %d disks", LIMIT_DISKS);
    in->crowded = true;
    return NULL;
  }
  in->atoms = deck_extend(in->d, in->atoms, in->n_atoms, &in->capacity, sizeof *in->atoms);
  atom *a = &in->atoms[in->n_atoms];
  *a = (atom){.place = in->here};
  return a;
}

static void add_atom(lammps *in) {
  const atom_style *s = in->style;
  if (s->prefix ? in->n_words < s->n : in->n_words != s->n && in->n_words != s->n + 3) {
    deck_fail_place(in->d, in->here, "%zu values; expected %s%zu of an atom of style %s%s",
                    in->n_words, s->prefix ? "at least " : "", s->n, s->name,
                    s->prefix ? "" : ", or 3 more with image flags");
    return;
  }
  atom *a = new_atom(in);
  if (!a) return;
  a->type = in->word[s->type];
  double diameter, density;
  /* All values are read even after an error, so that every wrong one is reported */
  bool good = whole(in, 0, "id", &a->id);
  good = number(in, s->diameter, "diameter", &diameter) && good;
  good = number(in, s->density, "density", &density) && good;
  good = number(in, s->x, "x", &a->value[X]) && good;
  good = number(in, s->x + 1, "y", &a->value[Y]) && good;
  const double r = a->value[RADIUS] = 0.5 * diameter;
  a->value[DIAMETER] = diameter;
  a->value[MASS] = density * (4.0 / 3.0) * 3.14159265358979323846 * r * r * r;
  in->n_atoms += good;
}

static int by_id(const void *a, const void *b) {
  long long p = ((const atom *)a)->id, q = ((const atom *)b)->id;
  return p < q ? -1 : p > q;
}

/* Sorts the atoms by id, since write_data writes them in the order of the processors' lists;
 * reports repeated ids. */
static void sort_atoms(lammps *in) {
  if (in->n_atoms) qsort(in->atoms, in->n_atoms, sizeof *in->atoms, by_id);
  for (size_t k = 1; k < in->n_atoms; k++)
    if (in->atoms[k].id == in->atoms[k - 1].id)
      deck_fail_place(in->d, in->atoms[k].place, "id = %lld: two atoms have it", in->atoms[k].id);
  in->sorted = true;
}

static void add_velocity(lammps *in) {
  atom key = {0};
  if (in->n_words < 7) {
    deck_fail_place(in->d, in->here, "%zu values; expected 7, id, velocity and angular velocity",
                    in->n_words);
    return;
  }
  if (!whole(in, 0, "id", &key.id)) return;
  atom *a = in->n_atoms ? bsearch(&key, in->atoms, in->n_atoms, sizeof key, by_id) : NULL;
  if (!a) {
    deck_fail_place(in->d, in->here, "id = %lld: no atom has it", key.id);
    return;
  }
  number(in, 1, "vx", &a->value[VX]);
  number(in, 2, "vy", &a->value[VY]);
  number(in, 6, "wz", &a->value[OMEGA]);
  in->has[VX] = in->has[VY] = in->has[OMEGA] = true;
}

static bool at_section(const lammps *in, const char *name) {
  return in->n_words == 1 && strcmp(in->word[0], name) == 0;
}

/* Reads all sections; the current line must be the keyword of the first one. Returns false after an
 * error that ends the reading (reported). */
static bool read_sections(lammps *in) {
  enum { OTHER, ATOMS, VELOCITIES } section = OTHER;
  bool more = true, found = false;
  for (; more; more = next_line(in)) {
    if (is_keyword(in)) {
      if (section == ATOMS) sort_atoms(in);
      section = at_section(in, "Atoms") ? ATOMS : at_section(in, "Velocities") ? VELOCITIES : OTHER;
      found |= section == ATOMS;
      if (section == ATOMS && !choose_style(in)) return false;
      if (section == VELOCITIES && !in->sorted) {
        deck_fail_place(in->d, in->here, "Velocities: expected after Atoms");
        return false;
      }
    } else if (section == ATOMS) {
      add_atom(in);
    } else if (section == VELOCITIES) {
      add_velocity(in);
    }
  }
  if (section == ATOMS) sort_atoms(in);
  static const source always[] = {X, Y, RADIUS, DIAMETER, MASS, TYPE, ID};
  for (size_t k = 0; k < sizeof always / sizeof *always; k++) in->has[always[k]] = true;
  if (!found) deck_fail_place(in->d, (deck_place){in->here.file, 0}, "there is no section Atoms");
  return found;
}

/* --- dumps ------------------------------------------------------------------------------------ */

static bool item(const lammps *in, const char *first, const char *second) {
  return in->n_words >= (second ? 3 : 2) && strcmp(in->word[0], "ITEM:") == 0 &&
         strcmp(in->word[1], first) == 0 && (!second || strcmp(in->word[2], second) == 0);
}

/* Reads the whole number in the line after an ITEM. */
static bool item_number(lammps *in, const char *what, long long *n) {
  if (next_line(in)) return whole(in, 0, what, n);
  deck_fail_place(in->d, in->here, "the file ends before the %s", what);
  return false;
}

/* Reads the lines of BOX BOUNDS. Returns false after an error, which is reported. */
static bool item_box(lammps *in, dump_frame *f) {
  const deck_place begin = in->here;
  size_t words = in->n_words;
  bool tilted = words > 3 && strcmp(in->word[3], "xy") == 0, upright = words <= 6 || tilted;
  for (size_t c = 0; c < 2 && words >= 6; c++)
    f->periodic[c] = strcmp(in->word[words - 3 + c], "pp") == 0;
  for (int c = 0; c < 3; c++) {
    const char *names[] = {"xlo", "ylo", "zlo"}, *upper[] = {"xhi", "yhi", "zhi"};
    double edge[2], tilt = 0;
    if (!next_line(in) || in->n_words < 2 || (tilted && in->n_words < 3)) {
      deck_fail_place(in->d, in->here, "expected %s and %s of the box", names[c], upper[c]);
      return false;
    }
    if (!number(in, 0, names[c], &edge[0]) || !number(in, 1, upper[c], &edge[1]) ||
        (tilted && !number(in, 2, "tilt", &tilt)))
      return false;
    upright &= tilt == 0;
    for (int k = 0; k < 2 && c < 2; k++) f->edge[c][k] = edge[k];
  }
  if (!upright)
    deck_fail_place(in->d, begin, "the box of this frame is tilted; expected a rectangular one");
  return upright;
}

/* Finds the columns of the sources in the line ITEM: ATOMS. */
static void item_columns(lammps *in, dump_frame *f) {
  static const struct {
    const char *name;
    source is;
    position written;
  } names[] = {{"x", X, PLAIN},
               {"y", Y, PLAIN},
               {"xs", X, SCALED},
               {"ys", Y, SCALED},
               {"xu", X, UNWRAPPED},
               {"yu", Y, UNWRAPPED},
               {"xsu", X, SCALED_UNWRAPPED},
               {"ysu", Y, SCALED_UNWRAPPED},
               {"radius", RADIUS, PLAIN},
               {"diameter", DIAMETER, PLAIN},
               {"mass", MASS, PLAIN},
               {"vx", VX, PLAIN},
               {"vy", VY, PLAIN},
               {"omegaz", OMEGA, PLAIN},
               {"angle", ANGLE, PLAIN},
               {"type", TYPE, PLAIN},
               {"id", ID, PLAIN}};
  for (int s = 0; s < SOURCES; s++) f->column[s] = -1;
  f->n_columns = in->n_words - 2;
  for (size_t k = 0; k < sizeof names / sizeof *names; k++)
    for (size_t c = 0; c < f->n_columns && f->column[names[k].is] < 0; c++) {
      if (strcmp(in->word[c + 2], names[k].name) != 0) continue;
      f->column[names[k].is] = (int)c;
      if (names[k].is <= Y) f->written[names[k].is] = names[k].written;
    }
}

/* Reads the head of a frame; the current line is its first ITEM. Returns false after an error,
 * which is reported. */
static bool read_head(lammps *in, dump_frame *f) {
  *f = (dump_frame){.step = -1, .announced = -1};
  bool bounded = false;
  for (bool more = true; more; more = next_line(in)) {
    if (item(in, "ATOMS", NULL)) {
      f->place = in->here;
      f->rows = in->p;
      item_columns(in, f);
      if (f->step >= 0 && f->announced >= 0 && bounded) return true;
      deck_fail_place(in->d, in->here, "the frame has no %s before its atoms",
                      f->step < 0        ? "ITEM: TIMESTEP"
                      : f->announced < 0 ? "ITEM: NUMBER OF ATOMS"
                                         : "ITEM: BOX BOUNDS");
      return false;
    }
    if (item(in, "TIMESTEP", NULL)) {
      if (!item_number(in, "timestep", &f->step)) return false;
    } else if (item(in, "NUMBER", "OF")) {
      if (!item_number(in, "number of atoms", &f->announced)) return false;
    } else if (item(in, "BOX", "BOUNDS")) {
      if (!(bounded = item_box(in, f))) return false;
    } else if (item(in, "UNITS", NULL) || item(in, "TIME", NULL)) {
      if (!next_line(in)) break;
    } else {
      deck_fail_place(in->d, in->here,
                      "%s %s: expected ITEM: TIMESTEP, NUMBER OF ATOMS, BOX BOUNDS or ATOMS",
                      deck_quote(in->d, in->word[0], strlen(in->word[0])),
                      in->n_words > 1 ? deck_quote(in->d, in->word[1], strlen(in->word[1])) : "");
      return false;
    }
  }
  deck_fail_place(in->d, in->here, "the file ends in the head of a frame");
  return false;
}

/* Skips the lines of the atoms of a frame. Returns how many of them there are. */
static long long skip_rows(lammps *in, const dump_frame *f) {
  long long n = 0;
  while (n < f->announced && *in->p && strncmp(in->p, "ITEM:", 5) != 0) {
    char *end = strchr(in->p, '\n');
    in->p = end ? end + 1 : in->p + strlen(in->p);
    in->here.line++;
    n++;
  }
  return n;
}

static bool find_frame(lammps *in, const deck_node *file, long long step) {
  long long first = -1, last = -1;
  bool found = false;
  while ((step < 0 || !found) && next_line(in)) {
    dump_frame f;
    if (!read_head(in, &f)) return false;
    const long long n = skip_rows(in, &f);
    if (n < f.announced) {
      deck_fail_place(
          in->d, f.place, "the frame of timestep %lld has %lld of %lld atoms%s", f.step, n,
          f.announced,
          last >= 0 ? deck_format(in->d, "; timestep = %lld is the last whole one", last) : "");
      return false;
    }
    if (first < 0) first = f.step;
    last = f.step;
    if (step >= 0 && step != f.step) continue;
    in->frame = f;
    found = true;
  }
  if (!found)
    deck_fail(in->d, file, "the dump has no timestep %lld; expected one from %lld to %lld", step,
              first, last);
  return found;
}

/* Converts a coordinate of a dump to a position in the box. */
static double in_box(const dump_frame *f, int c, double x) {
  const double lower = f->edge[c][0], length = f->edge[c][1] - lower;
  const position written = f->written[c];
  if (written == SCALED || written == SCALED_UNWRAPPED) x = lower + x * length;
  if ((written == UNWRAPPED || written == SCALED_UNWRAPPED) && f->periodic[c] && length > 0)
    x -= length * floor((x - lower) / length);
  return x;
}

static void add_dump_atom(lammps *in) {
  const dump_frame *f = &in->frame;
  if (in->n_words != f->n_columns) {
    deck_fail_place(in->d, in->here, "%zu values; expected %zu, one per name in line %d",
                    in->n_words, f->n_columns, f->place.line);
    return;
  }
  atom *a = new_atom(in);
  if (!a) return;
  bool good = true;
  for (int s = 0; s < NUMBERS; s++)
    if (f->column[s] >= 0)
      good = number(in, (size_t)f->column[s], source_names[s], &a->value[s]) && good;
  if (f->column[RADIUS] < 0) a->value[RADIUS] = 0.5 * a->value[DIAMETER];
  for (int c = 0; c < 2 && good; c++) a->value[c] = in_box(f, c, a->value[c]);
  a->id = (long long)in->n_atoms + 1;
  if (in->has[ID]) good = whole(in, (size_t)f->column[ID], "id", &a->id) && good;
  if (in->has[TYPE]) a->type = in->word[f->column[TYPE]];
  in->n_atoms += good;
}

/* Reads the atoms of the chosen frame. */
static void read_frame(lammps *in) {
  const dump_frame *f = &in->frame;
  for (int s = 0; s < SOURCES; s++) in->has[s] = f->column[s] >= 0;
  in->has[RADIUS] |= in->has[DIAMETER];
  in->p = f->rows;
  in->here = f->place;
  while (in->here.line - f->place.line < f->announced && next_line(in)) add_dump_atom(in);
  sort_atoms(in);
}

/* --- columns ---------------------------------------------------------------------------------- */

/* Returns which value of an atom (enum source) column c of the table takes; NO_COLUMN after an
 * error, which is reported. */
static int find_source(const deck_group *g, const lammps *in, const deck_columns *t, size_t c) {
  const char *column = deck_column_names[t->column[c]];
  int s = 0;
  while (s < SOURCES && strcmp(source_names[s], t->source[c]) != 0) s++;
  if (s == SOURCES) {
    bool density = strcmp(t->source[c], "density") == 0;
    deck_fail_key(g, "columns", "column \"%s\": %s", t->source[c],
                  density ? "that of LAMMPS is mass over the volume of a sphere; take \"mass\""
                          : "expected x, y, radius, diameter, mass, vx, vy, omega, angle, type or "
                            "id of a LAMMPS file");
    return NO_COLUMN;
  }
  if (!in->has[s]) {
    deck_fail_key(g, "columns", "column \"%s\": %s has none", t->source[c],
                  in->dump ? deck_format(g->d, "line %d of the dump", in->frame.place.line)
                           : "the data file");
    return NO_COLUMN;
  }
  if ((s >= NUMBERS) == (t->column[c] >= COLUMN_NUMBERS)) return s;
  deck_fail_key(g, "columns", "column \"%s\": \"%s\" is %s", column, t->source[c],
                s >= NUMBERS ? "a word, for name, material or group" : "a number");
  return NO_COLUMN;
}

/* For a group without the key `columns`: adds the columns that the file has and the group does not
 * give itself. The mass of a data file is left to the user, as its density is that of spheres. */
static void usual_columns(const deck_group *g, const lammps *in, const deck_node *file,
                          deck_columns *t) {
  static const source usual[] = {X, Y, RADIUS, MASS, VX, VY, OMEGA, ANGLE};
  for (size_t k = 0; k < sizeof usual / sizeof *usual; k++) {
    const source s = usual[k];
    const char *name = s == ANGLE ? "theta" : source_names[s];
    if (!in->has[s] || deck_given(g, name)) continue;
    if (s == MASS && (!in->dump || deck_given(g, "density"))) continue;
    deck_columns_add(g->d, t, s == ANGLE ? "theta = angle" : name, file, file->place);
  }
}

/* Reports an error if the disks and the box come from one dump but from different steps. */
static void check_moment(deck *d, const lammps *in, const deck_node *file) {
  if (in->dump && d->box_path && strcmp(d->box_path, in->here.file) == 0 &&
      d->box_step != in->frame.step)
    deck_fail(d, file,
              "its disks are read at timestep %lld, its box at timestep %lld; expected one moment",
              in->frame.step, (long long)d->box_step);
}

static bool is_source(void *file, const char *name) {
  (void)file;
  int s = 0;
  while (s < SOURCES && strcmp(source_names[s], name) != 0) s++;
  return s < SOURCES;
}

void deck_lammps_read(deck_group *g, deck_node *file, deck_columns *t) {
  deck *d = g->d;
  lammps in;
  size_t before = d->reported;
  int from[COLUMN_KINDS] = {0};
  const long long step = deck_given(g, "timestep") ? deck_integer(g, "timestep") : -1;
  if (!open_file(&in, d, file, step)) return;
  if (in.dump)
    read_frame(&in);
  else if (!read_sections(&in))
    return;
  check_moment(d, &in, file);
  if (d->reported == before && !in.dump && in.announced != (long long)in.n_atoms)
    deck_fail(d, file, "%zu atoms in section Atoms; the header says %lld", in.n_atoms,
              in.announced);
  if (!deck_given(g, "columns")) usual_columns(g, &in, file, t);
  deck_columns_resolve(g, t, is_source, NULL);
  for (size_t c = 0; c < t->n_columns; c++) from[c] = find_source(g, &in, t, c);
  if (d->reported > before) return;
  for (size_t k = 0; k < in.n_atoms; k++) {
    const atom *a = &in.atoms[k];
    if (!deck_columns_add_row(d, t, a->place)) return;
    for (size_t c = 0; c < t->n_columns; c++) {
      size_t at = k * t->n_columns + c;
      t->number[at] =
          from[c] < NUMBERS ? deck_columns_value(d, t, c, a->value[from[c]], a->place) : NAN;
      if (from[c] == TYPE) t->text[at] = a->type;
      if (from[c] == ID) t->text[at] = deck_format(d, "%lld", a->id);
    }
  }
}

/* deck_lammps.c: reads disks from a LAMMPS data file, as write_data makes it. See deck_rows.h.
 *
 * Supported are atom styles with a diameter: sphere, bpm/sphere, and hybrid with sphere first; the
 * style is read from the comment behind "Atoms". z is ignored; x and y are positions in the box,
 * whatever the image flags. The density in the file is mass per volume of a sphere, also in two
 * dimensions, so the mass that LAMMPS used is density 4/3 pi R^3; it is the column `mass` here.
 * Format: https://docs.lammps.org/read_data.html */
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

typedef struct atom {
  long long id;
  const char *type;
  double x, y, diameter, density, v[3]; /* v: velocity vx, vy and angular velocity omega */
  deck_place place;
} atom;

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
  bool sorted, velocities, crowded;
} lammps;

/* --- lines ------------------------------------------------------------------------------------ */

/* Reads the next line that holds more than a comment, and splits it into words; false at the end of
 * the file. The first line of the file, a title, is skipped. */
static bool next_line(lammps *in) {
  while (*in->p) {
    char *line = in->p, *end = strchr(line, '\n'), *rest = NULL;
    in->p = end ? end + 1 : line + strlen(line);
    if (end) *end = 0;
    in->here.line++;
    if (in->here.line == 1) continue;
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

/* Reads the header up to the keyword of the first section, which becomes the current line. Returns
 * false after an error, which is reported. */
static bool open_file(lammps *in, deck *d, const deck_node *file) {
  const char *path = deck_resolve(d, d->path, file->value.text);
  *in = (lammps){.d = d, .here = {path, 0}, .announced = -1};
  in->p = deck_read_file(d, path, (uint64_t)LIMIT_TABLE * LIMIT_MIB, file->place, "file");
  if (!in->p) return false;
  bool more;
  while ((more = next_line(in)) && !is_keyword(in)) header_line(in);
  if (in->tilted) {
    deck_fail(d, file, "the box of this LAMMPS file is tilted; expected a rectangular one");
    return false;
  }
  if (!more || in->announced < 0) {
    deck_fail(
        d, file,
        "this is no LAMMPS data file: expected a header with the number of atoms, and sections");
    return false;
  }
  return true;
}

bool deck_lammps_box(deck *d, const deck_node *file, double lower[2], double upper[2]) {
  lammps in;
  if (!open_file(&in, d, file)) return false;
  for (int c = 0; c < 2; c++) {
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

static void add_atom(lammps *in) {
  const atom_style *s = in->style;
  if (s->prefix ? in->n_words < s->n : in->n_words != s->n && in->n_words != s->n + 3) {
    deck_fail_place(in->d, in->here, "%zu values; expected %s%zu of an atom of style %s%s",
                    in->n_words, s->prefix ? "at least " : "", s->n, s->name,
                    s->prefix ? "" : ", or 3 more with image flags");
    return;
  }
  if (in->n_atoms == LIMIT_DISKS) {
    if (!in->crowded) deck_fail_place(in->d, in->here, "more than %d disks", LIMIT_DISKS);
    in->crowded = true;
    return;
  }
  in->atoms = deck_extend(in->d, in->atoms, in->n_atoms, &in->capacity, sizeof *in->atoms);
  atom *a = &in->atoms[in->n_atoms];
  *a = (atom){.type = in->word[s->type], .place = in->here};
  /* All values are read even after an error, so that every wrong one is reported */
  bool good = whole(in, 0, "id", &a->id);
  good = number(in, s->diameter, "diameter", &a->diameter) && good;
  good = number(in, s->density, "density", &a->density) && good;
  good = number(in, s->x, "x", &a->x) && good;
  good = number(in, s->x + 1, "y", &a->y) && good;
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
  number(in, 1, "vx", &a->v[0]);
  number(in, 2, "vy", &a->v[1]);
  number(in, 6, "wz", &a->v[2]);
  in->velocities = true;
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
  if (!found) deck_fail_place(in->d, (deck_place){in->here.file, 0}, "there is no section Atoms");
  return found;
}

/* --- columns ---------------------------------------------------------------------------------- */

typedef enum source { X, Y, RADIUS, MASS, VX, VY, OMEGA, TYPE, ID, SOURCES } source;
static const char *const source_names[SOURCES] = {"x",  "y",     "radius", "mass", "vx",
                                                  "vy", "omega", "type",   "id"};

static double value(const atom *a, source s) {
  double r = 0.5 * a->diameter;
  switch (s) {
    case X: return a->x;
    case Y: return a->y;
    case RADIUS: return r;
    case MASS: return a->density * (4.0 / 3.0) * 3.14159265358979323846 * r * r * r;
    case VX: return a->v[0];
    case VY: return a->v[1];
    case OMEGA: return a->v[2];
    default: return NAN;
  }
}

/* Returns which value of an atom (enum source) column c of the table takes; NO_COLUMN after an
 * error, which is reported. */
static int find_source(const deck_group *g, const deck_columns *t, size_t c) {
  const char *column = deck_column_names[t->column[c]];
  int s = 0;
  while (s < SOURCES && strcmp(source_names[s], t->source[c]) != 0) s++;
  if (s == SOURCES) {
    bool density = strcmp(t->source[c], "density") == 0;
    deck_fail_key(g, "columns", "column \"%s\": %s", t->source[c],
                  density
                      ? "that of LAMMPS is mass over the volume of a sphere; take \"mass\""
                      : "expected x, y, radius, mass, vx, vy, omega, type or id of a LAMMPS file");
    return NO_COLUMN;
  }
  if ((s >= TYPE) == (t->column[c] >= COLUMN_NUMBERS)) return s;
  deck_fail_key(g, "columns", "column \"%s\": \"%s\" is %s", column, t->source[c],
                s >= TYPE ? "a word, for name, material or group" : "a number");
  return NO_COLUMN;
}

/* For a group without the key `columns`: adds the columns that the file has and the group does not
 * give itself. */
static void usual_columns(const deck_group *g, const lammps *in, const deck_node *file,
                          deck_columns *t) {
  static const source usual[] = {X, Y, RADIUS, VX, VY, OMEGA};
  for (size_t k = 0; k < sizeof usual / sizeof *usual; k++) {
    const char *name = source_names[usual[k]];
    if (!deck_given(g, name) && (usual[k] < VX || in->velocities))
      deck_columns_add(g->d, t, name, file, file->place);
  }
}

void deck_lammps_read(deck_group *g, deck_node *file, deck_columns *t) {
  deck *d = g->d;
  lammps in;
  size_t before = d->reported;
  int from[COLUMN_KINDS] = {0};
  if (!open_file(&in, d, file) || !read_sections(&in)) return;
  if (d->reported == before && in.announced != (long long)in.n_atoms)
    deck_fail(d, file, "%zu atoms in section Atoms; the header says %lld", in.n_atoms,
              in.announced);
  if (!deck_given(g, "columns")) usual_columns(g, &in, file, t);
  for (size_t c = 0; c < t->n_columns; c++) from[c] = find_source(g, t, c);
  if (d->reported > before) return;
  for (size_t k = 0; k < in.n_atoms; k++) {
    const atom *a = &in.atoms[k];
    if (!deck_columns_add_row(d, t, a->place)) return;
    for (size_t c = 0; c < t->n_columns; c++) {
      size_t at = k * t->n_columns + c;
      t->number[at] = value(a, (source)from[c]);
      if (from[c] == TYPE) t->text[at] = a->type;
      if (from[c] == ID) t->text[at] = deck_format(d, "%lld", a->id);
    }
  }
}

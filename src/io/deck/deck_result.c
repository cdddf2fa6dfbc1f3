/* deck_result.c: reads the last state of a result or a checkpoint as disks of a deck. See
 * deck_result.h.
 *
 * The numbers of the state are in /state of the file. Names, shapes of walls and the box, which
 * only the deck of that run knew, are in the text /parameters/deck_bodies. Its lines are words
 * separated by tabs,
 *   box   periodic_x periodic_y lower_x upper_x lower_y upper_y
 *   material NAME     group NAME     disk NUMBER NAME
 *   wall NAME  PIECES ANGLE SCALE  kind, closed, inside, radius, pivot, points */
#include "base/limits.h"
#include "io/deck/deck.h"
#include "io/deck/deck_result.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "io/results/checkpoint.h"
#include "io/results/constants.h"
#include "io/store/file.h"
#include "model/cell.h"
#include "model/model.h"
#include "model/walls.h"

/* Largest number of walls that are read from a file: those of a deck and of its container. */
enum { MOST_WALLS = LIMIT_ENTRIES + 16 };

/* --- text /parameters/deck_bodies ------------------------------------------------------------- */

static void put(deck *d, deck_buffer *out, const char *text) {
  deck_put(d, out, text, strlen(text));
}

/* Returns the name; "" for a name with tabs or line breaks, which separate the words and lines of
 * the text. */
static const char *clean(const char *name) { return name && !strpbrk(name, "\t\n") ? name : ""; }

result_wall *deck_result_walls(deck *d) {
  const sd_model *m = d->model;
  result_wall *walls = deck_alloc(d, m->n_walls, sizeof *walls);
  for (size_t k = 0; k < m->n_walls; k++) {
    const sd_wall *w = &m->walls[k];
    deck_buffer out = {0};
    put(d, &out,
        deck_format(d, "%d %d %d %.17g %.17g %.17g", (int)w->kind, w->closed, w->inside, w->radius,
                    w->pivot[0], w->pivot[1]));
    for (size_t n = 0; n < w->n_points; n++)
      put(d, &out, deck_format(d, " %.17g %.17g", w->points[n][0], w->points[n][1]));
    walls[k] = (result_wall){clean(w->name), out.bytes, wall_pieces(m, w), 0, 1};
  }
  return walls;
}

char *deck_result_text(deck *d, const result_wall *walls) {
  const sd_model *m = d->model;
  deck_buffer out = {0};
  put(d, &out,
      deck_format(d, "box\t%d %d %.17g %.17g %.17g %.17g\n", m->periodic[0], m->periodic[1],
                  m->lower[0], m->upper[0], m->lower[1], m->upper[1]));
  for (size_t k = 0; k < m->n_materials; k++)
    put(d, &out, deck_format(d, "material\t%s\n", clean(m->materials[k].name)));
  for (size_t k = 0; k < m->n_groups; k++)
    put(d, &out, deck_format(d, "group\t%s\n", clean(m->groups[k])));
  for (size_t k = 0; k < model_held(m); k++)
    if (*clean(m->disks[k].name))
      put(d, &out, deck_format(d, "disk\t%zu\t%s\n", k, m->disks[k].name));
  for (size_t k = 0; k < m->n_walls; k++)
    put(d, &out,
        deck_format(d, "wall\t%s\t%zu %.17g %.17g\t%s\n", walls[k].name, walls[k].segments,
                    walls[k].angle, walls[k].scale, walls[k].text));
  return memory_text(out.bytes);
}

static void add_name(deck *d, result_names *list, size_t at, const char *name) {
  if (at >= list->n) {
    size_t n = at + 1 + list->n;
    list->name = deck_array_grow(d, list->name, list->n, n, sizeof *list->name);
    list->n = n;
  }
  list->name[at] = name;
}

static void add_wall(deck *d, deck_result *r, char *line) {
  char *count = strchr(line, '\t'), *text = count ? strchr(count + 1, '\t') : NULL;
  if (!text) return;
  *count++ = *text++ = 0;
  result_wall wall = {.name = line, .text = text};
  if (sscanf(count, "%zu %lf %lf", &wall.segments, &wall.angle, &wall.scale) != 3) return;
  if (r->n_walls == MOST_WALLS) return;
  r->walls = deck_extend(d, r->walls, r->n_walls, &r->wall_capacity, sizeof *r->walls);
  r->walls[r->n_walls++] = wall;
}

static void parse_text(deck *d, deck_result *r, char *text) {
  size_t materials = 0, groups = 0;
  for (char *rest = NULL, *line = strtok_r(text, "\n", &rest); line;
       line = strtok_r(NULL, "\n", &rest)) {
    char *value = strchr(line, '\t');
    if (!value) continue;
    *value++ = 0;
    if (strcmp(line, "material") == 0) add_name(d, &r->materials, materials++, value);
    if (strcmp(line, "group") == 0) add_name(d, &r->groups, groups++, value);
    if (strcmp(line, "wall") == 0) add_wall(d, r, value);
    if (strcmp(line, "box") == 0) {
      int px, py;
      r->boxed = sscanf(value, "%d %d %lf %lf %lf %lf", &px, &py, &r->lower[0], &r->upper[0],
                        &r->lower[1], &r->upper[1]) == 6;
      r->periodic[0] = r->boxed && px;
      r->periodic[1] = r->boxed && py;
    }
    if (strcmp(line, "disk") == 0) {
      char *name;
      size_t at = (size_t)strtoul(value, &name, 10);
      if (*name == '\t' && at < r->n_disks) add_name(d, &r->disk_names, at, name + 1);
    }
  }
}

/* --- state ------------------------------------------------------------------------------------ */

bool deck_result_has_state(const char *path) {
  h5_file *file;
  bool sealed = false;
  uint64_t sum;
  if (h5_open(path, &file, NULL) != SD_OK) {
    /* A file with a checksum at its end counts even if it is damaged; the damage is reported when
     * the file is read */
    if (file_exists(path)) h5_verify(path, &sealed, &sum, NULL);
    return sealed;
  }
  bool there = h5_get_attr_i64(file, "/state", "format", -1) >= 0;
  h5_close(file, NULL);
  return there;
}

const char *deck_result_maker(deck *d, const char *path) {
  size_t n = strlen(path);
  if (n < 3 || strcmp(path + n - 3, ".h5") != 0 || file_exists(path)) return "";
  if (file_is_folder(deck_format(d, "%s.parts", path)))
    return deck_format(d, "; the run is not finished: `slipdisk resume %s` goes on with it", path);
  const char *other = deck_format(d, "%.*s.cfg", (int)(n - 3), path);
  if (!file_exists(other) || strcmp(other, d->path) == 0) return "";
  return deck_format(d, "; `slipdisk run %s -o %s` makes it", other, path);
}

typedef struct reader {
  deck *d;
  h5_file *file;
  bool failed;
} reader;

/* Reads the values `first` to `first` + `rows` - 1 of a column of /state that has n values. The
 * length of the column is checked before memory is allocated. Returns NULL after an error, which is
 * reported. */
static void *part_of(reader *in, const char *name, sd_type type, size_t n, size_t first,
                     size_t rows) {
  const char *path = deck_format(in->d, "/state/%s", checkpoint_column(in->file, name));
  if (in->failed || h5_check(in->file, path, n, in->d->messages) != SD_OK) {
    in->failed = true;
    return NULL;
  }
  void *data = deck_alloc(in->d, rows, sd_type_size(type));
  in->failed =
      n && (rows < n ? h5_get_values(in->file, path, type, first, rows, 1, data, in->d->messages)
                     : h5_get(in->file, path, type, n, data, in->d->messages)) != SD_OK;
  return data;
}

static void *column(reader *in, const char *name, sd_type type, size_t n) {
  return part_of(in, name, type, n, 0, n);
}

/* Reads a column with values of n bodies, and sorts it by body number; the file has another order.
 * If only some rows are read, they keep the order of the file. */
static void *by_body(reader *in, const char *name, sd_type type, const deck_result *r,
                     const uint32_t *id, size_t n) {
  size_t size = sd_type_size(type);
  if (in->d->asked.part) {
    const size_t left = n > r->first ? n - r->first : 0;
    return part_of(in, name, type, n, r->first, r->n_rows < left ? r->n_rows : left);
  }
  char *from = column(in, name, type, n);
  char *to = in->failed ? NULL : deck_alloc(in->d, r->n_bodies, size);
  for (size_t slot = 0; slot < n && !in->failed; slot++)
    memcpy(to + id[slot] * size, from + slot * size, size);
  return to;
}

typedef struct rows_of_file {
  size_t first, n;
} rows_of_file;

static rows_of_file rows_asked(const deck *d, size_t all) {
  if (!d->asked.part) return (rows_of_file){0, all};
  const size_t first = d->asked.first < all ? d->asked.first : all;
  return (rows_of_file){first, d->asked.n < all - first ? d->asked.n : all - first};
}

/* Reads the contact laws of the file. Checkpoints contain none; n_materials then stays 0. */
static void read_laws(reader *in, deck_result *r) {
  const size_t walls = r->n_bodies - r->n_disks;
  r->wall_material = part_of(in, "material", SD_I32, r->n_bodies, r->n_disks, walls);
  sd_model *m = in->failed ? NULL : constants_laws_model(in->file);
  if (!m) return;
  const size_t n = m->n_materials;
  r->laws = deck_alloc(in->d, n * n + 1, sizeof *r->laws);
  memcpy(r->laws, m->laws, n * n * sizeof *r->laws);
  r->n_materials = n;
  r->rolls = r->rolls && (laws_features(m) & LAW_ROLLING) != 0;
  r->dt = m->integrator == SD_GEAR5 ? m->dt : 0.0;
  sd_model_free(m);
}

static void read_contacts(reader *in, deck_result *r) {
  const size_t all = r->all_contacts;
  const rows_of_file rows = rows_asked(in->d, all);
  const size_t begin = rows.first, n = r->n_contacts = rows.n;
  r->a = part_of(in, "contact_a", SD_U32, all, begin, n);
  r->b = part_of(in, "contact_b", SD_U32, all, begin, n);
  r->part = part_of(in, "contact_part", SD_U32, all, begin, n);
  r->side = part_of(in, "contact_side", SD_F64, all, begin, n);
  r->slide = part_of(in, "contact_slide", SD_I32, all, begin, n);
#define NAME(name, ...) "contact_" #name,
  static const char *const names[] = {SD_CONTACT_RECORD(NAME) SD_CONTACT_MORE(NAME)};
#undef NAME
  for (size_t k = 0; k < SD_CONTACT_ALL && !in->failed; k++) {
    const char *path = deck_format(in->d, "/state/%s", names[k]);
    /* A column that only some contact laws need may be missing or empty: the other run had no such
     * law */
    const bool absent = k >= SD_CONTACT_COLUMNS &&
                        (!h5_exists(in->file, path) || h5_check(in->file, path, 0, NULL) == SD_OK);
    if (strcmp(names[k], "contact_rho_ref") == 0) r->rolls = !absent;
    r->record[k] = absent ? deck_alloc(in->d, n, sizeof(double))
                          : part_of(in, names[k], SD_F64, all, begin, n);
  }
  read_laws(in, r);
  for (size_t k = 0; k < n && !in->failed; k++)
    in->failed |= r->a[k] >= r->n_disks || r->b[k] >= r->n_bodies || r->a[k] == r->b[k];
}

/* Reads the body numbers of the disks, or for a whole file of all bodies, in the order of the file.
 * Checks their range and, for a whole file, that each occurs once. Returns NULL if they are wrong
 * or cannot be read. */
static uint32_t *read_numbers(reader *in, const deck_result *r) {
  const bool part = in->d->asked.part;
  const size_t n = part ? r->n_rows : r->n_bodies, most = part ? r->n_disks : r->n_bodies;
  uint32_t *id = part_of(in, "id", SD_U32, r->n_bodies, part ? r->first : 0, n);
  if (in->failed) return NULL;
  bool *seen = part ? NULL : deck_alloc(in->d, most, sizeof *seen);
  for (size_t slot = 0; slot < n && !in->failed; slot++) {
    in->failed |= id[slot] >= most || (seen && seen[id[slot]]);
    if (seen && !in->failed) seen[id[slot]] = true;
  }
  return in->failed ? NULL : id;
}

/* Finds out for each row that is read whether its disk is driven, or out of play (removed, or
 * waiting for rain). */
static void read_kinds(reader *in, deck_result *r, const uint32_t *id) {
  const int32_t *activity = by_body(in, "activity", SD_I32, r, id, r->n_free);
  if (in->failed) return;
  r->driven = deck_alloc(in->d, r->n_rows, sizeof *r->driven);
  r->gone = deck_alloc(in->d, r->n_rows, sizeof *r->gone);
  r->number = deck_alloc(in->d, r->n_rows, sizeof *r->number);
  for (size_t k = 0; k < r->n_rows; k++) {
    const size_t slot = r->first + k, row = in->d->asked.part ? k : id[slot];
    /* A damaged file: this slot holds a wall, so that n_disks is wrong */
    if (row >= r->n_rows) continue;
    r->number[row] = id[k];
    r->driven[row] = slot >= r->n_free;
  }
  for (size_t k = 0; k < r->n_rows; k++) r->driven[k] = r->driven[k] || activity[k] == SD_HELD;
  for (size_t k = 0; k < r->n_rows; k++)
    r->gone[k] = !r->driven[k] && (activity[k] == SD_WAITING || activity[k] == SD_REMOVED);
}

static void read_bodies(reader *in, deck_result *r) {
  const uint32_t *id = read_numbers(in, r);
  if (in->failed) return;
  const struct {
    double **to;
    const char *name;
  } reals[] = {{&r->x, "x"},         {&r->y, "y"},
               {&r->theta, "theta"}, {&r->turn, "turn"},
               {&r->vx, "vx"},       {&r->vy, "vy"},
               {&r->omega, "omega"}, {&r->radius, "radius"},
               {&r->mass, "mass"},   {&r->inertia, "inertia"}};
  for (size_t k = 0; k < sizeof reals / sizeof *reals; k++)
    *reals[k].to = by_body(in, reals[k].name, SD_F64, r, id, r->n_bodies);
  r->material = by_body(in, "material", SD_I32, r, id, r->n_bodies);
  r->group = by_body(in, "group", SD_I32, r, id, r->n_bodies);
  read_kinds(in, r, id);
}

static void read_surfaces(reader *in, deck_result *r) {
  r->n_surfaces = (size_t)h5_get_attr_i64(in->file, "/state", "n_surfaces", 0);
  in->failed |= r->n_surfaces > r->n_bodies - r->n_disks;
  if (!in->failed && r->n_surfaces) r->surface = column(in, "surface", SD_F64, r->n_surfaces);
}

/* Reads the derivatives of order 3 to 5 for Gear's integrator, if both this run and the other use
 * it. */
static void read_derivatives(reader *in, deck_result *r) {
  static const char *const names[SD_DERIVATIVES] = {"x3", "x4",     "x5",     "y3",    "y4",
                                                    "y5", "theta3", "theta4", "theta5"};
  if (in->failed || in->d->asked.part || !(r->dt > 0.0) || in->d->model->integrator != SD_GEAR5)
    return;
  const uint32_t *id = read_numbers(in, r);
  for (size_t k = 0; k < SD_DERIVATIVES; k++)
    r->derivatives[k] = by_body(in, names[k], SD_F64, r, id, r->n_free);
}

/* Reads the walls of the file; their body numbers follow those of the disks. */
static void read_walls(reader *in, deck_result *r) {
  const size_t n = r->n_bodies - r->n_disks;
  const uint32_t *id = part_of(in, "id", SD_U32, r->n_bodies, r->n_disks, n);
  const struct {
    double **to;
    const char *name;
  } reals[] = {
      {&r->x, "x"}, {&r->y, "y"}, {&r->theta, "theta"}, {&r->turn, "turn"}, {&r->radius, "radius"}};
  for (size_t k = 0; k < sizeof reals / sizeof *reals; k++)
    *reals[k].to = part_of(in, reals[k].name, SD_F64, r->n_bodies, r->n_disks, n);
  for (size_t k = 0; k < n && !in->failed; k++) in->failed |= id[k] != r->n_disks + k;
  r->first_body = r->n_disks;
  if (!in->failed) read_surfaces(in, r);
}

deck_result *deck_result_read(deck *d, const deck_node *node, const char *path, bool contacts) {
  size_t before = sd_messages_errors(d->messages);
  deck_result *r = deck_alloc(d, 1, sizeof *r);
  reader in = {.d = d};
  r->path = path;
  if ((d->asked.again ? h5_open_again : h5_open_whole)(path, &in.file, d->messages) != SD_OK) {
    d->reported += sd_messages_errors(d->messages) - before;
    return NULL;
  }
  int64_t format = h5_get_attr_i64(in.file, "/state", "format", -1);
  if (format < CHECKPOINT_OF_PACKING || format > CHECKPOINT_FORMAT) {
    h5_close(in.file, NULL);
    deck_fail(d, node, "its state has format %lld, this program reads %d to %d", (long long)format,
              CHECKPOINT_OF_PACKING, CHECKPOINT_FORMAT);
    return NULL;
  }
  const struct {
    size_t *n;
    const char *name;
  } extents[] = {{&r->n_disks, "n_disks"},
                 {&r->n_bodies, "n_bodies"},
                 {&r->n_free, "n_free"},
                 {&r->all_contacts, "n_contacts"}};
  for (size_t k = 0; k < sizeof extents / sizeof *extents; k++) {
    int64_t n = h5_get_attr_i64(in.file, "/state", extents[k].name, -1);
    in.failed |= n < 0 || n > 8 * (int64_t)LIMIT_DISKS;
    *extents[k].n = in.failed ? 0 : (size_t)n;
  }
  const int64_t clumps = h5_get_attr_i64(in.file, "/state", "n_clumps", 0);
  if (clumps > 0) {
    h5_close(in.file, NULL);
    deck_fail(d, node,
              "it has %lld clumps, which are not read: their disks would come apart; expected a "
              "result without "
              "clumps, or single disks: columns = (\"x\", \"y\", \"radius\", \"mass\"), dataset = "
              "\"" RESULT_DISKS "\"",
              (long long)clumps);
    return NULL;
  }
  in.failed |= r->n_disks > r->n_bodies || r->n_free > r->n_disks;
  const rows_of_file rows = rows_asked(d, r->n_disks);
  r->first = rows.first;
  r->n_rows = rows.n;
  if (!in.failed && !memory_fits((double)r->n_rows * (double)deck_disk_bytes(false))) {
    h5_close(in.file, NULL);
    deck_need(d, node->parent, node->name, (double)r->n_rows, deck_disk_bytes(false), "disks");
  }
  const double *scale = column(&in, "box_scale", SD_F64, 1);
  if (!in.failed && d->asked.contacts)
    read_walls(&in, r);
  else if (!in.failed)
    read_bodies(&in, r);
  if (!in.failed && !d->asked.part) read_surfaces(&in, r);
  if (!in.failed && contacts) read_contacts(&in, r);
  if (!in.failed && contacts) read_derivatives(&in, r);
  r->box_scale = in.failed ? 1.0 : *scale;
  char *text = h5_get_text(in.file, "/parameters/deck_bodies");
  if (text) parse_text(d, r, deck_copy(d, text, strlen(text)));
  free(text);
  h5_close(in.file, NULL);
  d->reported += sd_messages_errors(d->messages) - before;
  if (in.failed) deck_fail(d, node, "the state in this file is damaged");
  return in.failed ? NULL : r;
}

/* --- table of disks --------------------------------------------------------------------------- */

static const char *name_at(const result_names *list, int64_t k) {
  return k >= 0 && (size_t)k < list->n && list->name[k] && *list->name[k] ? list->name[k] : NULL;
}

static double number_of(const deck_result *r, int column, size_t k) {
  bool still = r->driven[k];
  switch (column) {
    case COLUMN_X: return r->x[k];
    case COLUMN_Y: return r->y[k];
    case COLUMN_THETA: return r->turn[k] + r->theta[k];
    /* A driven disk is moved by motions and not by its velocity */
    case COLUMN_VX: return still ? 0.0 : r->vx[k];
    case COLUMN_VY: return still ? 0.0 : r->vy[k];
    case COLUMN_OMEGA: return still ? 0.0 : r->omega[k];
    case COLUMN_RADIUS: return r->radius[k];
    case COLUMN_MASS: return r->mass[k];
    case COLUMN_INERTIA: return r->inertia[k];
    case COLUMN_FIXED: return still;
    default: return NAN;
  }
}

static const char *text_of(const deck_result *r, int column, size_t k) {
  if (column == COLUMN_NAME) return name_at(&r->disk_names, r->number[k]);
  return column == COLUMN_GROUP ? name_at(&r->groups, r->group[k])
                                : name_at(&r->materials, r->material[k]);
}

static bool any_text(const deck_result *r, int column) {
  for (size_t k = 0; k < r->n_rows; k++)
    if (!r->gone[k] && text_of(r, column, k)) return true;
  return false;
}

/* Returns true if the column is taken from the file. Positions and radii come from the file if
 * contacts do, since they must agree; other values come from the deck if it gives them. */
static bool takes(const deck_group *g, const deck_result *r, const deck_columns *t, int column) {
  bool given = deck_given(g, deck_column_names[column]);
  bool mass = deck_given(g, "mass") || deck_given(g, "density");
  switch (column) {
    case COLUMN_X:
    case COLUMN_Y:
    case COLUMN_THETA:
    case COLUMN_RADIUS: return t->contacts || !given;
    case COLUMN_DENSITY: return false;
    case COLUMN_MASS: return !mass;
    case COLUMN_INERTIA: return !given && !mass && !deck_given(g, "radius");
    case COLUMN_MATERIAL: return !given && g->d->model->n_materials > 1 && any_text(r, column);
    case COLUMN_NAME:
    case COLUMN_GROUP: return !given && any_text(r, column);
    default: return !given;
  }
}

void deck_result_rows(deck_group *g, deck_node *file, const char *path, deck_columns *t) {
  deck *d = g->d;
  deck_result *r = deck_result_read(d, file, path, t->contacts && !d->asked.part);
  /* Act as if the file named the materials, so that they are not reported as missing too */
  if (!r) {
    if (!deck_given(g, "material")) deck_columns_add(d, t, "material", file, file->place);
    return;
  }
  for (int column = 0; column < COLUMN_KINDS; column++)
    if (takes(g, r, t, column))
      deck_columns_add(d, t, deck_column_names[column], file, file->place);
  t->result = r;
  t->file = file;
  t->all = r->n_disks;
  t->disk = deck_alloc(d, r->n_rows, sizeof *t->disk);
  deck_columns_reserve(d, t, r->n_rows);
  for (size_t k = 0; k < r->n_rows; k++) {
    if (r->gone[k]) continue;
    t->disk[t->n_rows] = r->number[k];
    if (!deck_columns_add_row(d, t, (deck_place){path, PLACE_DISK - (int)r->number[k]})) return;
    for (size_t c = 0; c < t->n_columns; c++) {
      size_t at = (t->n_rows - 1) * t->n_columns + c;
      t->number[at] = number_of(r, t->column[c], k);
      if (t->column[c] >= COLUMN_NUMBERS) t->text[at] = text_of(r, t->column[c], k);
    }
  }
}

/* --- the box ---------------------------------------------------------------------------------- */

/* Reads the deformation of the box: its lengths divided by the original ones, and the shift between
 * neighbouring rows of periodic images. If the file has no such dataset: 1, 1, 0. */
static void cell_of(const h5_file *file, double cell[CELL_COLUMNS]) {
  size_t dims[H5_MAX_RANK] = {0};
  int rank = 0;
  cell[CELL_X] = cell[CELL_Y] = 1.0;
  cell[CELL_OFFSET] = 0.0;
  if (h5_exists(file, "/state/cell") && h5_shape(file, "/state/cell", &rank, dims, NULL) == SD_OK &&
      dims[0] == CELL_COLUMNS)
    h5_get(file, "/state/cell", SD_F64, CELL_COLUMNS, cell, NULL);
}

/* Computes the box of a result as the engine does: from the edges in the text deck_bodies, the
 * scale of the box and its deformation. Returns false if the file has no such text. */
static bool box_of_text(deck *d, const h5_file *file, double lower[2], double upper[2]) {
  deck_result r = {0};
  double scale = 1.0, cell[CELL_COLUMNS];
  char *text = h5_get_text(file, "/parameters/deck_bodies");
  cell_of(file, cell);
  if (text) parse_text(d, &r, text);
  if (r.boxed && h5_get(file, "/state/box_scale", SD_F64, 1, &scale, NULL) != SD_OK)
    r.boxed = false;
  for (int c = 0; c < 2; c++) {
    lower[c] = r.lower[c];
    const double f = scale * cell[c];
    upper[c] = f != 1.0 ? r.lower[c] + f * (r.upper[c] - r.lower[c]) : r.upper[c];
    if (!r.periodic[c]) upper[c] = lower[c];
  }
  free(text);
  return r.boxed;
}

/* Reads the box of an H5MD file of another program, and stores path and step of the file in d:
 * disks that are read later from this file must be of the same step. */
static bool box_of_others(deck *d, const h5_file *file, const char *path, double lower[2],
                          double upper[2]) {
  h5_box box;
  bool found;
  if (h5_particles_box(file, &found, &box, d->messages) != SD_OK || !found) return false;
  memcpy(lower, box.lower, sizeof box.lower);
  memcpy(upper, box.upper, sizeof box.upper);
  d->box_path = path;
  d->box_step = box.step;
  return true;
}

bool deck_result_box(deck *d, const deck_node *node, double lower[2], double upper[2]) {
  const char *path = deck_resolve(d, d->path, node->value.text);
  size_t before = sd_messages_errors(d->messages);
  h5_file *file;
  if (h5_open(path, &file, d->messages) != SD_OK) {
    d->reported += sd_messages_errors(d->messages) - before;
    deck_fail(d, node, "cannot be read%s", deck_result_maker(d, path));
    return false;
  }
  const bool ours = box_of_text(d, file, lower, upper);
  const bool found = ours || box_of_others(d, file, path, lower, upper);
  const size_t wrong = sd_messages_errors(d->messages) - before;
  if (wrong > 0) {
    d->reported += wrong;
    deck_fail(d, node, "its box cannot be read");
  }
  double cell[CELL_COLUMNS];
  cell_of(file, cell);
  if (fabs(cell[CELL_OFFSET]) > 1e-9 * cell[CELL_X])
    deck_fail(d, node,
              "the box of this file is sheared, its rows of images are shifted by %g of its width; "
              "expected one "
              "that is not, or was sheared by a whole width",
              cell[CELL_OFFSET] / cell[CELL_X]);
  h5_close(file, NULL);
  if (!found && wrong == 0)
    deck_fail(d, node, "this file has no edges in the box of a group of /particles");
  return found;
}

/* --- contacts of a result --------------------------------------------------------------------- */

double deck_result_shift(const deck_result *r, size_t row) {
  double total = r->turn[row] + r->theta[row];
  return (total - 8.0 * nearbyint(total / 8.0)) - r->theta[row];
}

sd_contact_memory deck_result_contact(const deck_result *r, size_t k) {
  double record[SD_CONTACT_ALL];
  sd_contact_memory c = {
      .a = r->a[k], .b = r->b[k], .part = r->part[k], .slide = r->slide[k], .side = r->side[k]};
  for (size_t n = 0; n < SD_CONTACT_ALL; n++) record[n] = r->record[n][k];
  memcpy(&c.record, record, sizeof record);
  /* The other run had no rolling spring: NAN lets it begin relaxed */
  if (!r->rolls) c.record.rho_ref = NAN;
  return c;
}

bool deck_contact_is_kept(const sd_contact_memory *c, const sd_tile_wall *wall) {
  return !wall || (wall->known && (wall->pieces == 0 || c->part - wall->first < wall->pieces));
}

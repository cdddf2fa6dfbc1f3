/* constants.c: writes the constants of a model to a result and rebuilds a model from them; see
 * constants.h. */
#include "io/results/constants.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/results/provenance.h"
#include "io/results/trajectory.h"
#include "io/store/members.h"
#include "model/laws.h"
#include "model/rows.h"

#define MODEL "/parameters/model"
#define DISKS "/particles/disks"
#define WALLS "/particles/walls"
#define CLUMPS "/particles/clumps"

/* File that is being read, and the first error that occurred. */
typedef struct reader {
  const h5_file *file;
  sd_status status;
  sd_messages *messages;
} reader;

/* --- Contact laws ----------------------------------------------------------------------------- */

/* Members of sd_contact_law in the datasets laws and normal_laws. Later members of the struct are
 * in general_laws, whose description lists them. */
#define LAW_MEMBERS "k_n, k_t, gamma_n, mu"
#define NORMAL_MEMBERS "normal, restitution"

/* Returns the names of the members in general_laws: flags and kinds, then numbers. */
static char *general_members(void) {
  char *list = memory_text("");
  const deck_key *key;
  for (int numbers = 0; numbers < 2; numbers++)
    for (size_t k = 0; (key = deck_key_at(&law_table, k)); k++)
      if (key->offset > offsetof(sd_contact_law, restitution) &&
          (key->target == DECK_SETS_NUMBER) == numbers)
        list = append_text(list, "%s%s", *list ? ", " : "", key->member);
  return list;
}

static size_t count_members(const char *list) {
  size_t n = 1;
  for (; (list = strchr(list, ',')); list++) n++;
  return n;
}

/* Returns the key that sets the first member in the list, and moves the list on to the next one;
 * NULL: laws have no member of this name. */
static const deck_key *next_member(const char **list) {
  const size_t n = strcspn(*list, ",");
  const deck_key *key;
  for (size_t k = 0; (key = deck_key_at(&law_table, k)); k++)
    if (strncmp(key->member, *list, n) == 0 && !key->member[n]) break;
  *list += n + strspn(*list + n, ", ");
  return key;
}

/* Writes the listed members for each of the n x n pairs of materials; if all are 0, only the
 * dataset `laws` is written. */
static void put_laws(h5_file *file, const sd_model *m, const char *name, const char *list,
                     const char *unit, const char *meaning) {
  const size_t n = m->n_materials, width = count_members(list), dims[3] = {n, n, width};
  double *values = memory_new(n * n * width, sizeof *values);
  bool used = strcmp(name, "laws") == 0;
  for (size_t c = 0; c < width; c++) {
    const deck_key *key = next_member(&list);
    for (size_t k = 0; k < n * n; k++) {
      values[k * width + c] = deck_key_value(key, &m->laws[k]);
      used = used || values[k * width + c] != 0.0;
    }
  }
  if (used) members_put(file, MODEL, name, SD_F64, 3, dims, values, false, unit, meaning);
  free(values);
}

static void write_laws(h5_file *file, const sd_model *m) {
  char *general = general_members();
  put_laws(file, m, "laws", LAW_MEMBERS, "force/length, force/length, force time/length, 1",
           LAW_MEMBERS
           " of each pair of materials; k_n = 0: not given; with E_star in general_laws k_n, with "
           "poisson also k_t, times sqrt(R_eff) of the contact");
  put_laws(
      file, m, "normal_laws", NORMAL_MEMBERS, "1",
      "normal law (0 linear, 1 Hertz) and coefficient of restitution of each pair of materials");
  put_laws(file, m, "general_laws", general, "mixed", general);
  free(general);
}

/* Reads the listed members of all laws, if the file has the dataset. */
static void get_laws(reader *r, sd_model *m, const char *path, const char *list) {
  if (r->status != SD_OK || !h5_exists(r->file, path)) return;
  const size_t n = m->n_materials, width = count_members(list);
  double *values = h5_column(r->file, path, SD_F64, n * n * width, &r->status, r->messages);
  for (size_t c = 0; values && c < width; c++) {
    const deck_key *key = next_member(&list);
    for (size_t k = 0; k < n * n && r->status == SD_OK; k++)
      if (!key || !deck_key_store(key, &m->laws[k], values[k * width + c]))
        r->status = sd_fail(r->messages, SD_ERROR_IO, "the laws of the contacts are damaged");
  }
  free(values);
}

/* Reads the materials, without their names, and the contact laws. */
static void read_laws(reader *r, sd_model *m) {
  int rank = 0;
  size_t dims[H5_MAX_RANK] = {0};
  r->status = h5_shape(r->file, MODEL "/laws", &rank, dims, r->messages);
  const size_t n = r->status == SD_OK && rank > 0 ? dims[0] : 0;
  if (n > LIMIT_MATERIALS)
    r->status = sd_fail(r->messages, SD_ERROR_IO, "%zu materials: the laws are damaged", n);
  if (r->status != SD_OK) return;
  m->materials = memory_new(n, sizeof *m->materials);
  m->laws = memory_new(n * n, sizeof *m->laws);
  m->n_materials = n;
  char *general = h5_get_attr_text(r->file, MODEL "/general_laws", "description");
  get_laws(r, m, MODEL "/laws", LAW_MEMBERS);
  get_laws(r, m, MODEL "/normal_laws", NORMAL_MEMBERS);
  get_laws(r, m, MODEL "/general_laws", general ? general : "");
  free(general);
}

sd_model *constants_laws_model(const h5_file *file) {
  reader r = {.file = file};
  sd_model *m = h5_exists(file, MODEL "/laws") ? sd_model_new() : NULL;
  if (m) read_laws(&r, m);
  if (!m || r.status != SD_OK) {
    sd_model_free(m);
    return NULL;
  }
  m->integrator = (sd_integrator)h5_get_attr_i64(file, MODEL, "integrator", SD_VERLET);
  m->dt = h5_get_attr_f64(file, MODEL, "dt", 0.0);
  return m;
}

/* --- Write constants -------------------------------------------------------------------------- */

#define CONSTANT(name, structure, field, type, width, unit, meaning)                               \
  { name, unit, meaning, type, width, offsetof(structure, field), NULL, NULL, NULL, NULL }
#define DISK(name, field, type, unit, meaning)                                                     \
  CONSTANT(name, sd_disk, field, type, 1, unit, meaning)
#define WALL(name, field, type, width, unit, meaning)                                              \
  CONSTANT(name, sd_wall, field, type, width, unit, meaning)

static const observable disk_rows[] = {
    DISK("radius", radius, OBSERVABLE_F64, "length", "radius"),
    DISK("mass", mass, OBSERVABLE_F64, "mass", "mass"),
    DISK("inertia", inertia, OBSERVABLE_F64, "mass length^2", "moment of inertia"),
    DISK("species", material, OBSERVABLE_I32, "1", "index of the material"),
    DISK("group", group, OBSERVABLE_I32, "1", "index of the group, -1: none"),
    DISK("driven", driven, OBSERVABLE_FLAG, "1", "1: prescribed, 0: free"),
};
static const observable_list disk_constants = OBSERVABLES("disks", "of disks", disk_rows);

static const observable force_rows[] = {CONSTANT("constant_force", sd_disk, force, OBSERVABLE_F64,
                                                 2, "force", "constant force on the centre")};
static const observable_list disk_forces =
    OBSERVABLES("disks", "of disks, where there are any", force_rows);

static const observable in_clump_rows[] = {
    DISK("clump", clump, OBSERVABLE_I32, "1", "1 + number of its clump, 0: none")};
static const observable_list in_clump_constants =
    OBSERVABLES("disks", "of disks, where there are clumps", in_clump_rows);

static const observable clump_rows[] = {
    CONSTANT("mass", sd_clump, mass, OBSERVABLE_F64, 1, "mass", "mass"),
    CONSTANT("inertia", sd_clump, inertia, OBSERVABLE_F64, 1, "mass length^2",
             "moment of inertia about its centre"),
    CONSTANT("disks", sd_clump, n_disks, OBSERVABLE_SIZE, 1, "1", "how many disks it has"),
};
static const observable_list clump_constants = OBSERVABLES("clumps", "of clumps", clump_rows);

static const observable clump_force_rows[] = {
    CONSTANT("constant_force", sd_clump, force, OBSERVABLE_F64, 2, "force",
             "constant force on the centre, beside those on disks")};
static const observable_list clump_forces =
    OBSERVABLES("clumps", "of clumps, where there are any", clump_force_rows);

static const observable wall_rows[] = {
    WALL("species", material, OBSERVABLE_I32, 1, "1", "index of the material"),
    WALL("shape/kind", kind, OBSERVABLE_I32, 1, "1",
         "0 line, 1 segment, 2 polyline, 3 circle, 4 arc: many points along it"),
    WALL("shape/radius", radius, OBSERVABLE_F64, 1, "length", "radius of a circle or arc, else 0"),
    WALL("shape/count", n_points, OBSERVABLE_SIZE, 1, "1",
         "points of each wall, one wall after the other"),
    WALL("shape/pivot", pivot, OBSERVABLE_F64, 2, "length", "where the pivot stood in the deck"),
    WALL("shape/closed", closed, OBSERVABLE_FLAG, 1, "1", "1: a polyline whose ends are joined"),
    WALL("shape/inside", inside, OBSERVABLE_FLAG, 1, "1", "1: a circle with the disks inside"),
};
static const observable_list wall_constants = OBSERVABLES("walls", "of walls", wall_rows);

static const observable arc_rows[] = {
    WALL("shape/center", center, OBSERVABLE_F64, 2, "length", "centre of an arc"),
    WALL("shape/from", from, OBSERVABLE_F64, 1, "rad", "angle at which an arc begins"),
    WALL("shape/to", to, OBSERVABLE_F64, 1, "rad", "angle at which it ends"),
};
static const observable_list arc_constants =
    OBSERVABLES("walls", "of walls, where there are arcs", arc_rows);
_Static_assert(sizeof(sd_wall_kind) == sizeof(int32_t) && sizeof(int) == sizeof(int32_t),
               "stored as 32 bits");

static void put(h5_file *file, const char *name, sd_type type, int rank, const size_t *dims,
                const void *data, const char *unit, const char *meaning) {
  members_put(file, MODEL, name, type, rank, dims, data, false, unit, meaning);
}

/* Returns the name of a body in the deck; NULL: it has none. */
static const char *name_of(const sd_model *m, size_t body) {
  const size_t bodies = m->n_disks + m->n_walls;
  return body < m->n_disks ? m->disks[body].name
         : body < bodies   ? m->walls[body - m->n_disks].name
                           : m->clumps[body - bodies].name;
}

/* Writes the dataset `id`, with body numbers first ... first + n - 1, and, if the deck names any of
 * these bodies, the dataset `name`. */
static void put_bodies(h5_file *file, const char *group, const sd_model *m, size_t first, size_t n,
                       const char *meaning) {
  char *path = format_text("%s/name", group), **names;
  uint32_t *id;
  bool named = false;
  const memory_column rows[] = {{&names, n, sizeof *names}, {&id, n, sizeof *id}};
  const bool room = memory_rows(sizeof rows / sizeof *rows, rows);
  for (size_t k = 0; room && k < n; k++) {
    size_t body = first + k;
    id[k] = (uint32_t)body;
    const char *name = name_of(m, body);
    /* The pointer of a body without a name is not written, since it is NULL already: memory pages
     * that are not written take no memory. */
    if (name) names[k] = (char *)(uintptr_t)name;
    named = named || name;
  }
  members_put(file, group, "id", SD_U32, 1, &n, id, true, "1", meaning);
  if (h5_check_memory(file, room, group) && named) {
    members_write_lines(file, path, n, names);
    h5_attr_text(file, path, "description", "names, one per line, in the order of id");
  }
  free(id);
  free(names);
  free(path);
}

/* Writes the periodic box for a group of bodies in the file, as the H5MD standard asks for. */
static void put_box(h5_file *file, const char *group, const sd_model *m) {
  char *box = format_text("%s/box", group);
  double lengths[2], lower[2];
  const char *boundary[2];
  const size_t two = 2;
  trajectory_edges(m, 1.0, lengths);
  for (int k = 0; k < 2; k++) {
    boundary[k] = m->periodic[k] ? "periodic" : "none";
    lower[k] = m->periodic[k] ? m->lower[k] : 0;
  }
  h5_group(file, box);
  h5_attr_i64(file, box, "dimension", 2);
  h5_attr_texts(file, box, "boundary", 2, boundary);
  if (!series_compresses(m))
    members_put(file, box, "edges", SD_F64, 1, &two, lengths, false, "length",
                "lengths of the periodic box, 0 where it is open");
  h5_attr(file, box, "lower", SD_F64, 2, lower);
  free(box);
}

/* Returns column `name` of the state, with n rows in the order of slots. If it is read from a
 * checkpoint, *own is set to it and the caller frees it. Returns NULL if it cannot be read; *status
 * gives the error. */
static const void *state_column(const constants_source *from, const char *name, size_t n,
                                void **own, sd_status *status, sd_messages *messages) {
  size_t k = 0;
  while (strcmp(sd_fields[k].name, name) != 0) k++;
  *own = NULL;
  if (from->state) return sd_field_data(from->state, &sd_fields[k]);
  char path[64];
  snprintf(path, sizeof path, "/state/%s", name);
  return *own = h5_column(from->checkpoint, path, sd_fields[k].type, n, status, messages);
}

/* Writes the constants of disks in runs where no rank holds those of all disks: they are read from
 * columns of the state, one column at a time, and sorted by body number. */
static sd_status put_made(h5_file *file, const sd_model *m, const constants_source *from,
                          sd_messages *messages) {
  static const char *const columns[] = {"radius", "mass", "inertia", "material", "group", NULL};
  const size_t n = m->n_disks, bodies = sd_model_bodies(m);
  sd_status status = SD_OK;
  void *own_id;
  const uint32_t *id = state_column(from, "id", bodies, &own_id, &status, messages);
  h5_group(file, DISKS);
  for (size_t k = 0; k < disk_constants.n && status == SD_OK; k++) {
    const observable *o = &disk_constants.rows[k];
    const sd_type type = observable_stored(o);
    const size_t size = sd_type_size(type);
    char *dense = NULL;
    void *own = NULL;
    const char *rows =
        columns[k] ? state_column(from, columns[k], bodies, &own, &status, messages) : NULL;
    if (status == SD_OK && !memory_row(&dense, n, size))
      status = sd_fail(messages, SD_ERROR_IO, "no memory for the result");
    for (size_t slot = 0; id && dense && slot < bodies; slot++) {
      const int32_t driven = slot >= m->n_free;
      if (id[slot] < n)
        memcpy(dense + id[slot] * size, rows ? rows + slot * size : (const char *)&driven, size);
    }
    if (dense) members_put(file, DISKS, o->name, type, 1, &n, dense, true, o->unit, o->meaning);
    free(own);
    free(dense);
  }
  free(own_id);
  return status;
}

static sd_status put_disks(h5_file *file, const sd_model *m, const constants_source *from,
                           sd_messages *messages) {
  bool pushed = false;
  put_box(file, DISKS, m);
  put_bodies(file, DISKS, m, 0, m->n_disks, "permanent number, as in the deck");
  sd_status status = SD_OK;
  if (m->parted)
    status = put_made(file, m, from, messages);
  else
    members_write(file, DISKS, &disk_constants, m->disks, sizeof *m->disks, m->n_disks);
  for (size_t k = 0; k < model_known(m); k++) {
    const double *force = m->disks[model_known_disk(m, k)].force;
    pushed = pushed || force[0] != 0.0 || force[1] != 0.0;
  }
  if (pushed) members_write(file, DISKS, &disk_forces, m->disks, sizeof *m->disks, m->n_disks);
  if (m->n_clumps > 0)
    members_write(file, DISKS, &in_clump_constants, m->disks, sizeof *m->disks, m->n_disks);
  return status;
}

static void put_clumps(h5_file *file, const sd_model *m) {
  put_box(file, CLUMPS, m);
  put_bodies(file, CLUMPS, m, m->n_disks + m->n_walls, m->n_clumps, "body number");
  members_write(file, CLUMPS, &clump_constants, m->clumps, sizeof *m->clumps, m->n_clumps);
  bool pushed = false;
  for (size_t k = 0; k < m->n_clumps; k++)
    pushed = pushed || m->clumps[k].force[0] != 0.0 || m->clumps[k].force[1] != 0.0;
  if (pushed) members_write(file, CLUMPS, &clump_forces, m->clumps, sizeof *m->clumps, m->n_clumps);
}

static void put_walls(h5_file *file, const sd_model *m) {
  size_t dims[2] = {0, 2};
  put_box(file, WALLS, m);
  put_bodies(file, WALLS, m, m->n_disks, m->n_walls, "body number");
  members_write(file, WALLS, &wall_constants, m->walls, sizeof *m->walls, m->n_walls);
  bool arcs = false;
  for (size_t k = 0; k < m->n_walls; k++) arcs = arcs || m->walls[k].kind == SD_WALL_ARC;
  if (arcs) members_write(file, WALLS, &arc_constants, m->walls, sizeof *m->walls, m->n_walls);
  for (size_t k = 0; k < m->n_walls; k++) dims[0] += m->walls[k].n_points;
  double(*points)[2] = memory_new(dims[0], sizeof *points), (*at)[2] = points;
  for (size_t k = 0; k < m->n_walls; k++) {
    size_t n = m->walls[k].n_points;
    if (n > 0) memcpy(at, m->walls[k].points, n * sizeof *at);
    at += n;
  }
  members_put(file, WALLS "/shape", "points", SD_F64, 2, dims, points, true, "length",
              "where the points stood in the deck");
  free(points);
}

sd_status constants_write(h5_file *file, const sd_model *m, const constants_source *from,
                          sd_messages *messages) {
  sd_status status = SD_OK;
  static const size_t two = 2, square[2] = {2, 2};
  const double box[2][2] = {{m->lower[0], m->lower[1]}, {m->upper[0], m->upper[1]}};
  const double area[2][2] = {{m->region_lower[0], m->region_lower[1]},
                             {m->region_upper[0], m->region_upper[1]}};
  const int32_t periodic[2] = {m->periodic[0], m->periodic[1]};
  h5_group(file, MODEL);
  h5_attr_text(file, MODEL, "description",
               "of the deck as it was run: what measuring needs beside the frames");
  h5_attr_i64(file, MODEL, "container", (int64_t)m->container);
  h5_attr_i64(file, MODEL, "variant", (int64_t)m->variant);
  h5_attr_i64(file, MODEL, "integrator", (int64_t)m->integrator);
  h5_attr(file, MODEL, "dt", SD_F64, 1, &m->dt);
  put(file, "gravity", SD_F64, 1, &two, m->gravity, "length/time^2", "acceleration");
  put(file, "periodic", SD_I32, 1, &two, periodic, "1", "1: the box repeats along x, y");
  put(file, "box", SD_F64, 2, square, box, "length", "lower, upper corner at the start");
  put(file, "region", SD_F64, 2, square, area, "length",
      "lower, upper corner at the start of what is called full; equal: there is none");
  write_laws(file, m);
  if (m->n_disks > 0) status = put_disks(file, m, from, messages);
  if (m->n_walls > 0) put_walls(file, m);
  if (m->n_clumps > 0) put_clumps(file, m);
  return status;
}

/* --- Read constants --------------------------------------------------------------------------- */

/* Allocates n rows, where n is read from the file: a damaged file may ask for more memory than
 * there is. what: name of the rows in the error message. */
static void *rows_new(reader *r, size_t n, size_t size, const char *what) {
  void *rows = NULL;
  if (r->status == SD_OK && !memory_row(&rows, n, size))
    r->status = sd_fail(r->messages, SD_ERROR_IO, "no memory for %zu %s", n, what);
  return rows;
}

/* Returns the number of rows of a dataset; 0 if it cannot be read. */
static size_t count(reader *r, const char *path) {
  int rank = 0;
  size_t dims[H5_MAX_RANK] = {0};
  if (r->status == SD_OK) r->status = h5_shape(r->file, path, &rank, dims, r->messages);
  return r->status == SD_OK && rank > 0 ? dims[0] : 0;
}

/* Reads gravity, periodic box, region and container of the model. */
static void read_space(reader *r, sd_model *m) {
  double box[4], area[4];
  int32_t periodic[2];
  const struct {
    const char *path;
    sd_type type;
    size_t n;
    void *data;
  } sets[] = {{MODEL "/gravity", SD_F64, 2, m->gravity},
              {MODEL "/box", SD_F64, 4, box},
              {MODEL "/region", SD_F64, 4, area},
              {MODEL "/periodic", SD_I32, 2, periodic}};
  for (size_t k = 0; r->status == SD_OK && k < sizeof sets / sizeof *sets; k++)
    r->status = h5_get(r->file, sets[k].path, sets[k].type, sets[k].n, sets[k].data, r->messages);
  for (int c = 0; r->status == SD_OK && c < 2; c++) {
    m->periodic[c] = periodic[c] != 0;
    m->lower[c] = box[c];
    m->upper[c] = box[2 + c];
    m->region_lower[c] = area[c];
    m->region_upper[c] = area[2 + c];
  }
  m->container = (int)h5_get_attr_i64(r->file, MODEL, "container", 0);
  m->variant = (sd_variant)h5_get_attr_i64(r->file, MODEL, "variant", SD_PAPER);
}

static void check_species(reader *r, const sd_model *m, int species) {
  if (species < 0 || (size_t)species >= m->n_materials)
    r->status = sd_fail(r->messages, SD_ERROR_IO, "the materials of the bodies are damaged");
}

/* Reads the names of n bodies; bodies without a name get NULL. The caller frees the list and its
 * texts. Returns NULL if no body has a name. */
static char **read_names(reader *r, const char *path, size_t n) {
  if (r->status != SD_OK || !h5_exists(r->file, path)) return NULL;
  char **names = rows_new(r, n, sizeof *names, "names");
  if (names) members_read_lines(r->file, path, n, names);
  for (size_t k = 0; names && k < n; k++) {
    if (!names[k] || *names[k]) continue;
    free(names[k]);
    names[k] = NULL;
  }
  return names;
}

static void read_disks(reader *r, sd_model *m) {
  size_t n = count(r, DISKS "/radius");
  if (n > LIMIT_DISKS)
    r->status = sd_fail(r->messages, SD_ERROR_IO, "%zu disks: the file is damaged", n);
  if (r->status == SD_OK) r->status = h5_check(r->file, DISKS "/radius", n, r->messages);
  if (r->status != SD_OK) return;
  m->disks = rows_new(r, n, sizeof *m->disks, "disks");
  if (r->status == SD_OK)
    r->status =
        members_read(r->file, DISKS, &disk_constants, m->disks, sizeof *m->disks, n, r->messages);
  if (r->status == SD_OK && h5_exists(r->file, DISKS "/constant_force"))
    r->status =
        members_read(r->file, DISKS, &disk_forces, m->disks, sizeof *m->disks, n, r->messages);
  if (r->status == SD_OK && h5_exists(r->file, DISKS "/clump"))
    r->status = members_read(r->file, DISKS, &in_clump_constants, m->disks, sizeof *m->disks, n,
                             r->messages);
  for (size_t k = 0; m->disks && r->status == SD_OK && k < n; k++)
    check_species(r, m, m->disks[k].material);
  if (r->status == SD_OK) m->n_disks = n;
  char **names = read_names(r, DISKS "/name", n);
  for (size_t k = 0; m->disks && names && k < n; k++) m->disks[k].name = names[k];
  free(names);
}

/* Reads the clumps without lists of their disks, which are not stored: each disk stores the number
 * of its clump. */
static void read_clumps(reader *r, sd_model *m) {
  if (r->status != SD_OK || !h5_exists(r->file, CLUMPS "/mass")) return;
  const size_t n = count(r, CLUMPS "/mass");
  if (n > m->n_disks)
    r->status = sd_fail(r->messages, SD_ERROR_IO, "%zu clumps: the file is damaged", n);
  m->clumps = rows_new(r, n, sizeof *m->clumps, "clumps");
  if (r->status == SD_OK)
    r->status = members_read(r->file, CLUMPS, &clump_constants, m->clumps, sizeof *m->clumps, n,
                             r->messages);
  if (r->status == SD_OK && h5_exists(r->file, CLUMPS "/constant_force"))
    r->status =
        members_read(r->file, CLUMPS, &clump_forces, m->clumps, sizeof *m->clumps, n, r->messages);
  for (size_t k = 0; m->clumps && k < n; k++) m->clumps[k].n_disks = 0;
  if (r->status == SD_OK) m->n_clumps = n;
}

/* Gives each wall its points: the list has the n_points points of the first wall, then those of the
 * next one. Returns false if the list has too few points. */
static bool share_points(sd_model *m, size_t total, const double *points) {
  for (size_t k = 0, at = 0; k < m->n_walls; k++) {
    sd_wall *w = &m->walls[k];
    size_t n = w->n_points;
    w->n_points = 0;
    if (n > total - at) return false;
    w->points = memory_new(n, sizeof *w->points);
    w->n_points = n;
    memcpy(w->points, points + 2 * at, n * sizeof *w->points);
    at += n;
  }
  return true;
}

static void read_walls(reader *r, sd_model *m) {
  if (!h5_exists(r->file, WALLS "/shape/kind")) return;
  size_t n = count(r, WALLS "/shape/kind"), total = count(r, WALLS "/shape/points");
  double *points =
      h5_column(r->file, WALLS "/shape/points", SD_F64, 2 * total, &r->status, r->messages);
  if (r->status == SD_OK) r->status = h5_check(r->file, WALLS "/shape/kind", n, r->messages);
  m->walls = rows_new(r, n, sizeof *m->walls, "walls");
  if (r->status == SD_OK)
    r->status =
        members_read(r->file, WALLS, &wall_constants, m->walls, sizeof *m->walls, n, r->messages);
  if (r->status == SD_OK && h5_exists(r->file, WALLS "/shape/center"))
    r->status =
        members_read(r->file, WALLS, &arc_constants, m->walls, sizeof *m->walls, n, r->messages);
  for (size_t k = 0; m->walls && r->status == SD_OK && k < n; k++)
    check_species(r, m, m->walls[k].material);
  if (r->status == SD_OK) m->n_walls = n;
  if (m->walls && r->status == SD_OK && !share_points(m, total, points))
    r->status = sd_fail(r->messages, SD_ERROR_IO, WALLS "/shape: the points cannot be read");
  for (size_t k = 0; m->walls && k < n; k++)
    if (!m->walls[k].points) m->walls[k].n_points = 0;
  char **names = read_names(r, WALLS "/name", n);
  for (size_t k = 0; m->walls && names && k < n; k++) m->walls[k].name = names[k];
  free(names);
  free(points);
}

/* Reads the names of materials and groups from the text deck_bodies, which io/deck/deck_result.c
 * writes; older files have none. */
static void read_words(reader *r, sd_model *m) {
  char *text = r->status == SD_OK ? h5_get_text(r->file, "/parameters/deck_bodies") : NULL,
       *rest = NULL;
  size_t materials = 0;
  for (char *line = text ? strtok_r(text, "\n", &rest) : NULL; line;
       line = strtok_r(NULL, "\n", &rest)) {
    char *name = strchr(line, '\t');
    if (!name) continue;
    *name++ = 0;
    if (strcmp(line, "material") == 0 && materials < m->n_materials)
      m->materials[materials++].name = memory_text(name);
    if (strcmp(line, "group") != 0 || m->n_groups == LIMIT_ENTRIES) continue;
    m->groups = memory_grow(m->groups, m->n_groups + 1, sizeof *m->groups);
    m->groups[m->n_groups++] = memory_text(name);
  }
  free(text);
}

static sd_status read_file(const h5_file *file, sd_model *m, sd_messages *messages) {
  reader r = {file, SD_OK, messages};
  read_space(&r, m);
  if (r.status == SD_OK) read_laws(&r, m);
  if (r.status == SD_OK) read_disks(&r, m);
  if (r.status == SD_OK) read_walls(&r, m);
  read_clumps(&r, m);
  read_words(&r, m);
  return r.status;
}

/* Rebuilds the model from the completed deck (with all defaults filled in) that is stored in the
 * file. */
static sd_status from_deck(const h5_file *file, const char *path, constants_deck_reader *read_deck,
                           sd_model **out, sd_messages *messages) {
  char *full = h5_get_text(file, "/parameters/deck_full");
  if (!full)
    return sd_fail(messages, SD_ERROR_USER,
                   "%s is not a result of slipdisk: there is no /parameters/deck_full", path);
  char *deck = h5_get_attr_text(file, "/parameters", "deck_path");
  char *directory = h5_get_attr_text(file, "/parameters", "directory");
  char *name = provenance_deck(deck && *deck ? deck : "deck", directory);
  sd_status status = read_deck(full, name, 0, NULL, out, messages);
  if (status != SD_OK)
    sd_fail(messages, status,
            "%s: the run's deck, as it is stored, cannot be read again, so box, walls and laws are "
            "not known",
            path);
  free(full);
  free(deck);
  free(directory);
  free(name);
  return status;
}

sd_status constants_read(const h5_file *file, const char *path, constants_deck_reader *read_deck,
                         sd_model **out, sd_messages *messages) {
  *out = NULL;
  if (!h5_exists(file, MODEL "/laws")) return from_deck(file, path, read_deck, out, messages);
  sd_model *m = sd_model_new();
  const sd_status status = read_file(file, m, messages);
  if (status == SD_OK)
    *out = m;
  else
    sd_model_free(m);
  return status;
}

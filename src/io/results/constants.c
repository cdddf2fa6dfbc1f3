/* constants.c: see constants.h. */
#include "io/results/constants.h"

#include <stdlib.h>

#include "base/text.h"
#include "base/limits.h"
#include "io/store/file.h"
#include "slipdisk/deck.h"

#define MODEL "/parameters/model"
#define DISKS "/particles/disks"
#define WALLS "/particles/walls"

enum { LAW = 4 }; /* numbers in one */

/* --- write -------------------------------------------------------------------------------------------- */

static void put(h5_file *file, const char *path, sd_type type, int rank, const size_t *dims, const void *data,
                const char *unit, const char *meaning) {
  h5_put(file, path, type, rank, dims, data, false);
  h5_attr_text(file, path, "unit", unit);
  h5_attr_text(file, path, "description", meaning);
}

static void put_laws(h5_file *file, const sd_model *m) {
  size_t n = m->n_materials, dims[3] = {n, n, LAW};
  double(*laws)[LAW] = calloc(n * n + 1, sizeof *laws);
  for (size_t k = 0; laws && k < n * n; k++) {
    const sd_contact_law *law = &m->laws[k];
    const double value[LAW] = {law->k_n, law->k_t, law->gamma_n, law->mu};
    for (int c = 0; c < LAW; c++) laws[k][c] = value[c];
  }
  if (h5_have(file, laws, MODEL "/laws"))
    put(file, MODEL "/laws", SD_F64, 3, dims, laws, "force/length, force/length, force time/length, 1",
        "k_n, k_t, gamma_n, mu of each pair of materials; k_n = 0: not given");
  free(laws);
}

/* Where not all laws are linear. */
static void put_normal_laws(h5_file *file, const sd_model *m) {
  size_t n = m->n_materials, dims[3] = {n, n, 2};
  bool linear = true;
  for (size_t k = 0; k < n * n; k++) linear = linear && m->laws[k].normal == SD_NORMAL_LINEAR;
  if (linear) return;
  double(*laws)[2] = calloc(n * n + 1, sizeof *laws);
  for (size_t k = 0; laws && k < n * n; k++) {
    laws[k][0] = m->laws[k].normal;
    laws[k][1] = m->laws[k].restitution;
  }
  if (h5_have(file, laws, MODEL "/normal_laws"))
    put(file, MODEL "/normal_laws", SD_F64, 3, dims, laws, "1",
        "normal law (0 linear, 1 Hertz) and coefficient of restitution of each pair of materials");
  free(laws);
}

static void put_walls(h5_file *file, const sd_model *m) {
  size_t n = m->n_walls, dims[2] = {n, 2};
  double(*pivot)[2] = calloc(n + 1, sizeof *pivot);
  int32_t *closed = calloc(n + 1, sizeof *closed), *inside = calloc(n + 1, sizeof *inside);
  for (size_t k = 0; pivot && closed && inside && k < n; k++) {
    pivot[k][0] = m->walls[k].pivot[0];
    pivot[k][1] = m->walls[k].pivot[1];
    closed[k] = m->walls[k].closed;
    inside[k] = m->walls[k].inside;
  }
  if (h5_have(file, pivot && closed && inside, WALLS "/shape")) {
    put(file, WALLS "/shape/pivot", SD_F64, 2, dims, pivot, "length", "where the pivot stood in the deck");
    put(file, WALLS "/shape/closed", SD_I32, 1, &n, closed, "1", "1: a polyline whose ends are joined");
    put(file, WALLS "/shape/inside", SD_I32, 1, &n, inside, "1", "1: a circle with the disks inside");
  }
  free(pivot);
  free(closed);
  free(inside);
}

static void put_forces(h5_file *file, const sd_model *m) {
  size_t dims[2] = {m->n_disks, 2};
  double(*force)[2] = calloc(m->n_disks + 1, sizeof *force);
  bool any = false;
  for (size_t k = 0; force && k < m->n_disks; k++)
    for (int c = 0; c < 2; c++) {
      force[k][c] = m->disks[k].force[c];
      any = any || force[k][c] != 0.0;
    }
  if (h5_have(file, force, DISKS "/constant_force") && any)
    put(file, DISKS "/constant_force", SD_F64, 2, dims, force, "force", "constant force on the centre");
  free(force);
}

void constants_write(h5_file *file, const sd_model *m) {
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
  put(file, MODEL "/gravity", SD_F64, 1, &two, m->gravity, "length/time^2", "acceleration");
  put(file, MODEL "/periodic", SD_I32, 1, &two, periodic, "1", "1: the box repeats along x, y");
  put(file, MODEL "/box", SD_F64, 2, square, box, "length", "lower, upper corner at the start");
  put(file, MODEL "/region", SD_F64, 2, square, area, "length",
      "lower, upper corner at the start of what is called full; equal: there is none");
  put_laws(file, m);
  put_normal_laws(file, m);
  if (m->n_walls > 0) put_walls(file, m);
  if (m->n_disks > 0) put_forces(file, m);
}

/* --- read --------------------------------------------------------------------------------------------- */

typedef struct reader {
  const h5_file *file;
  sd_status status;
  sd_messages *messages;
} reader;

static size_t count(reader *r, const char *path) {
  int rank = 0;
  size_t dims[H5_MAX_RANK] = {0};
  if (r->status == SD_OK) r->status = h5_shape(r->file, path, &rank, dims, r->messages);
  return r->status == SD_OK && rank > 0 ? dims[0] : 0;
}

/* To be freed; NULL when something went wrong, also before. */
static void *column(reader *r, const char *path, sd_type type, size_t n) {
  if (r->status == SD_OK) r->status = h5_check(r->file, path, n, r->messages);
  if (r->status != SD_OK) return NULL;
  void *data = calloc(n + 1, sd_type_size(type));
  r->status = data ? h5_get(r->file, path, type, n, data, r->messages)
                   : sd_fail(r->messages, SD_ERROR_IO, "no memory to read %s", path);
  if (r->status == SD_OK) return data;
  free(data);
  return NULL;
}

static void read_space(reader *r, sd_model *m) {
  double *gravity = column(r, MODEL "/gravity", SD_F64, 2), *box = column(r, MODEL "/box", SD_F64, 4);
  double *area = column(r, MODEL "/region", SD_F64, 4);
  int32_t *periodic = column(r, MODEL "/periodic", SD_I32, 2);
  for (int c = 0; r->status == SD_OK && c < 2; c++) {
    m->gravity[c] = gravity[c];
    m->periodic[c] = periodic[c] != 0;
    m->lower[c] = box[c];
    m->upper[c] = box[2 + c];
    m->region_lower[c] = area[c];
    m->region_upper[c] = area[2 + c];
  }
  m->container = (sd_container_kind)h5_get_attr_i64(r->file, MODEL, "container", SD_CONTAINER_NONE);
  m->variant = (sd_variant)h5_get_attr_i64(r->file, MODEL, "variant", SD_PAPER);
  free(gravity);
  free(box);
  free(area);
  free(periodic);
}

static void read_normal_laws(reader *r, sd_model *m) {
  if (!h5_exists(r->file, MODEL "/normal_laws")) return;
  size_t n = m->n_materials;
  double *laws = column(r, MODEL "/normal_laws", SD_F64, n * n * 2);
  for (size_t k = 0; laws && r->status == SD_OK && k < n * n; k++) {
    if (!(laws[2 * k] >= 0.0 && laws[2 * k] < SD_NORMAL_LAWS))
      r->status = sd_fail(r->messages, SD_ERROR_IO, "the laws of the contacts are damaged");
    else
      m->laws[k].normal = (sd_normal_law)laws[2 * k];
    m->laws[k].restitution = laws[2 * k + 1];
  }
  free(laws);
}

static void read_laws(reader *r, sd_model *m) {
  size_t n = count(r, MODEL "/laws");
  if (n > LIMIT_MATERIALS)
    r->status = sd_fail(r->messages, SD_ERROR_IO, "%zu materials: the laws are damaged", n);
  if (r->status != SD_OK) return;
  double *laws = column(r, MODEL "/laws", SD_F64, n * n * LAW);
  m->materials = calloc(n + 1, sizeof *m->materials);
  m->laws = calloc(n * n + 1, sizeof *m->laws);
  if (laws && m->materials && m->laws) {
    m->n_materials = n;
    for (size_t k = 0; k < n * n; k++)
      m->laws[k] = (sd_contact_law){.k_n = laws[LAW * k],
                                    .k_t = laws[LAW * k + 1],
                                    .gamma_n = laws[LAW * k + 2],
                                    .mu = laws[LAW * k + 3]};
    read_normal_laws(r, m);
  } else if (r->status == SD_OK) {
    r->status = sd_fail(r->messages, SD_ERROR_IO, "no memory for the laws");
  }
  free(laws);
}

static void check_species(reader *r, const sd_model *m, size_t n, const int32_t *species) {
  for (size_t k = 0; r->status == SD_OK && k < n; k++)
    if (species[k] < 0 || (size_t)species[k] >= m->n_materials)
      r->status = sd_fail(r->messages, SD_ERROR_IO, "the materials of the bodies are damaged");
}

static void read_disks(reader *r, sd_model *m) {
  size_t n = count(r, DISKS "/radius");
  if (n > LIMIT_DISKS) r->status = sd_fail(r->messages, SD_ERROR_IO, "%zu disks: the file is damaged", n);
  if (r->status != SD_OK) return;
  double *radius = column(r, DISKS "/radius", SD_F64, n), *mass = column(r, DISKS "/mass", SD_F64, n);
  double *inertia = column(r, DISKS "/inertia", SD_F64, n), *force = NULL;
  int32_t *species = column(r, DISKS "/species", SD_I32, n), *group = column(r, DISKS "/group", SD_I32, n);
  int32_t *driven = column(r, DISKS "/driven", SD_I32, n);
  if (h5_exists(r->file, DISKS "/constant_force")) force = column(r, DISKS "/constant_force", SD_F64, 2 * n);
  m->disks = r->status == SD_OK ? calloc(n + 1, sizeof *m->disks) : NULL;
  if (r->status == SD_OK && !m->disks)
    r->status = sd_fail(r->messages, SD_ERROR_IO, "no memory for %zu disks", n);
  check_species(r, m, n, species);
  if (r->status == SD_OK) m->n_disks = n;
  for (size_t k = 0; k < m->n_disks; k++)
    m->disks[k] = (sd_disk){.radius = radius[k],
                            .mass = mass[k],
                            .inertia = inertia[k],
                            .material = species[k],
                            .group = group[k],
                            .driven = driven[k] != 0,
                            .force = {force ? force[2 * k] : 0.0, force ? force[2 * k + 1] : 0.0, 0.0}};
  void *all[] = {radius, mass, inertia, species, group, driven, force};
  for (size_t k = 0; k < sizeof all / sizeof *all; k++) free(all[k]);
}

/* Points of all walls stand in one list, counts say whose. */
static sd_status share_points(sd_model *m, const int64_t *counts, size_t total, const double *points) {
  size_t at = 0;
  for (size_t k = 0; k < m->n_walls; k++) {
    sd_wall *w = &m->walls[k];
    size_t n = counts[k] > 0 ? (size_t)counts[k] : 0;
    if (n > total - at) return SD_ERROR_USER;
    w->points = calloc(n + 1, sizeof *w->points);
    if (!w->points) return SD_ERROR_IO;
    w->n_points = n;
    for (size_t p = 0; p < n; p++, at++)
      w->points[p][0] = points[2 * at], w->points[p][1] = points[2 * at + 1];
  }
  return SD_OK;
}

static void read_walls(reader *r, sd_model *m) {
  if (!h5_exists(r->file, WALLS "/shape/kind")) return;
  size_t n = count(r, WALLS "/shape/kind"), total = count(r, WALLS "/shape/points");
  int32_t *kind = column(r, WALLS "/shape/kind", SD_I32, n),
          *species = column(r, WALLS "/species", SD_I32, n);
  int32_t *closed = column(r, WALLS "/shape/closed", SD_I32, n);
  int32_t *inside = column(r, WALLS "/shape/inside", SD_I32, n);
  double *radius = column(r, WALLS "/shape/radius", SD_F64, n);
  double *pivot = column(r, WALLS "/shape/pivot", SD_F64, 2 * n);
  double *points = column(r, WALLS "/shape/points", SD_F64, 2 * total);
  int64_t *counts = column(r, WALLS "/shape/count", SD_I64, n);
  m->walls = r->status == SD_OK ? calloc(n + 1, sizeof *m->walls) : NULL;
  if (r->status == SD_OK && !m->walls)
    r->status = sd_fail(r->messages, SD_ERROR_IO, "no memory for %zu walls", n);
  check_species(r, m, n, species);
  if (r->status == SD_OK) m->n_walls = n;
  for (size_t k = 0; k < m->n_walls; k++)
    m->walls[k] = (sd_wall){.kind = (sd_wall_kind)kind[k],
                            .material = species[k],
                            .pivot = {pivot[2 * k], pivot[2 * k + 1]},
                            .closed = closed[k] != 0,
                            .radius = radius[k],
                            .inside = inside[k] != 0};
  if (r->status == SD_OK && share_points(m, counts, total, points) != SD_OK)
    r->status = sd_fail(r->messages, SD_ERROR_IO, WALLS "/shape: the points cannot be read");
  void *all[] = {kind, species, closed, inside, radius, pivot, points, counts};
  for (size_t k = 0; k < sizeof all / sizeof *all; k++) free(all[k]);
}

static sd_status read_file(const h5_file *file, sd_model *m, sd_messages *messages) {
  reader r = {file, SD_OK, messages};
  read_space(&r, m);
  if (r.status == SD_OK) read_laws(&r, m);
  if (r.status == SD_OK) read_disks(&r, m);
  if (r.status == SD_OK) read_walls(&r, m);
  return r.status;
}

/* The deck's path is that of the run, or from the folder in which that was started. */
static sd_status read_deck(const h5_file *file, const char *path, sd_model **out, sd_messages *messages) {
  char *full = h5_get_text(file, "/parameters/deck_full");
  if (!full)
    return sd_fail(messages, SD_ERROR_USER,
                   "%s is not a result of slipdisk: there is no /parameters/deck_full", path);
  char *deck = h5_get_attr_text(file, "/parameters", "deck_path");
  char *directory = h5_get_attr_text(file, "/parameters", "directory");
  char *there = deck && directory ? format_text("%s/%s", directory, deck) : NULL;
  const char *name = deck && *deck ? deck : "deck";
  if (there && *name != '/' && !file_exists(name) && file_exists(there)) name = there;
  sd_status status = sd_deck_load_text(full, name, 0, NULL, out, messages);
  if (status != SD_OK)
    sd_fail(messages, status,
            "%s: the run's deck, as it is stored, cannot be read again, so box, walls and laws are not known",
            path);
  free(full);
  free(deck);
  free(directory);
  free(there);
  return status;
}

sd_status constants_read(const h5_file *file, const char *path, sd_model **out, sd_messages *messages) {
  *out = NULL;
  if (!h5_exists(file, MODEL "/laws")) return read_deck(file, path, out, messages);
  sd_model *m = sd_model_new();
  sd_status status = m ? read_file(file, m, messages) : sd_fail(messages, SD_ERROR_IO, "no memory");
  if (status == SD_OK)
    *out = m;
  else
    sd_model_free(m);
  return status;
}

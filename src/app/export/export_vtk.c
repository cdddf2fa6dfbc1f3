/* export_vtk.c: writes disks, contacts and walls as polygonal data of VTK: for each frame one .vtp
 * file for each of the three, and a .pvd file that lists the .vtp files with their times. Arrays
 * follow the XML as raw bytes in native byte order. See export.h. */
#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/export/export.h"
#include "base/memory.h"
#include "io/store/file.h"

typedef enum place { OF_POINT, OF_CELL, POINTS, VERTS, LINES } place;

typedef struct array {
  const char *name;
  size_t width, n; /* Shape of the array: n rows of `width` numbers */
  bool whole;      /* True: the numbers are int64_t; false: double */
  place place;
  void *data;
} array;

enum { MOST_ARRAYS = 20 };
typedef struct piece {
  size_t points, verts, lines, n;
  array arrays[MOST_ARRAYS];
  bool failed; /* True: out of memory for an array */
} piece;

/* Adds an array to the piece (a .vtp file), which frees it. Returns the data of the array; NULL:
 * out of memory, and p->failed is set. */
static void *add(piece *p, place where, const char *name, bool whole, size_t width, size_t n) {
  void *data;
  assert(p->n < MOST_ARRAYS);
  p->failed = p->failed || !memory_row(&data, n * width, 8);
  if (p->failed) return NULL;
  p->arrays[p->n++] = (array){name, width, n, whole, where, data};
  return data;
}

static void piece_free(piece *p) {
  for (size_t k = 0; k < p->n; k++) free(p->arrays[k].data);
  *p = (piece){0};
}

/* --- files ------------------------------------------------------------------------------------ */

static void put_section(const piece *p, const char *name, place where, FILE *out) {
  uint64_t offset = 0;
  fprintf(out, "<%s>\n", name);
  for (size_t k = 0; k < p->n; k++) {
    const array *a = &p->arrays[k];
    if (a->place == where)
      fprintf(out,
              "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%zu\" format=\"appended\" "
              "offset=\"%" PRIu64 "\"/>\n",
              a->whole ? "Int64" : "Float64", a->name, a->width, offset);
    offset += sizeof(uint64_t) + 8 * a->n * a->width;
  }
  fprintf(out, "</%s>\n", name);
}

static void put_piece(const piece *p, double time, FILE *out) {
  static const uint16_t one = 1;
  bool little = *(const unsigned char *)&one == 1;
  fprintf(
      out,
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"%sEndian\" "
      "header_type=\"UInt64\">\n<PolyData>\n<FieldData>\n<DataArray type=\"Float64\" "
      "Name=\"TimeValue\" "
      "NumberOfTuples=\"1\" format=\"ascii\">%.17g</DataArray>\n</FieldData>\n",
      little ? "Little" : "Big", time);
  fprintf(out, "<Piece NumberOfPoints=\"%zu\" NumberOfVerts=\"%zu\" NumberOfLines=\"%zu\">\n",
          p->points, p->verts, p->lines);
  put_section(p, "PointData", OF_POINT, out);
  put_section(p, "CellData", OF_CELL, out);
  put_section(p, "Points", POINTS, out);
  put_section(p, "Verts", VERTS, out);
  put_section(p, "Lines", LINES, out);
  fprintf(out, "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_");
  for (size_t k = 0; k < p->n; k++) {
    const array *a = &p->arrays[k];
    uint64_t bytes = 8 * a->n * a->width;
    fwrite(&bytes, sizeof bytes, 1, out);
    fwrite(a->data, 1, bytes, out);
  }
  fprintf(out, "\n</AppendedData>\n</VTKFile>\n");
}

/* --- disks ------------------------------------------------------------------------------------ */

static void fill_disks(const export_job *job, const frame_data *f, piece *p) {
  const sd_model *m = job->m;
  size_t n = export_count(job, f), k = 0;
  double(*at)[3] = add(p, POINTS, "Points", false, 3, n),
  *radius = add(p, OF_POINT, "radius", false, 1, n);
  double *mass = add(p, OF_POINT, "mass", false, 1, n),
         *angle = add(p, OF_POINT, "angle", false, 1, n);
  double *spin = add(p, OF_POINT, "spin", false, 1, n),
         (*v)[3] = add(p, OF_POINT, "velocity", false, 3, n);
  int64_t *id = add(p, OF_POINT, "id", true, 1, n), *group = add(p, OF_POINT, "group", true, 1, n);
  int64_t *material = add(p, OF_POINT, "material", true, 1, n),
          *fixed = add(p, OF_POINT, "fixed", true, 1, n);
  int64_t *vertex = add(p, VERTS, "connectivity", true, 1, n),
          *end = add(p, VERTS, "offsets", true, 1, n);
  p->points = p->verts = n;
  for (size_t i = 0; !p->failed && i < m->n_disks; i++) {
    const sd_disk *d = &m->disks[i];
    if (!export_has(job, f, i)) continue;
    memcpy(at[k], f->position[i], sizeof f->position[i]);
    memcpy(v[k], f->velocity[i], sizeof f->velocity[i]);
    radius[k] = d->radius, mass[k] = d->mass, angle[k] = f->angle[i], spin[k] = f->spin[i];
    id[k] = (int64_t)i, group[k] = d->group, material[k] = d->material, fixed[k] = d->driven;
    vertex[k] = (int64_t)k, end[k] = (int64_t)k + 1;
    k++;
  }
}

/* --- contacts --------------------------------------------------------------------------------- */

/* Makes a line for each contact of bodies a and b: from the centre of a to the centre of b, or to
 * the surface of b if b is a wall or a prescribed disk. */
static sd_status fill_contacts(const export_job *job, const frame_data *f, piece *p) {
  configuration c = {0};
  sd_status status = configuration_new(&c, job->m, f, job->messages);
  size_t n = status == SD_OK ? c.n_contacts : 0;
  double(*at)[3] = add(p, POINTS, "Points", false, 3, 2 * n),
  *force = add(p, OF_CELL, "force", false, 1, n);
  double *tau = add(p, OF_CELL, "tau", false, 1, n),
         *overlap = add(p, OF_CELL, "overlap", false, 1, n);
  double(*on_b)[3] = add(p, OF_CELL, "force_on_b", false, 3, n);
  int64_t *a = add(p, OF_CELL, "a", true, 1, n), *b = add(p, OF_CELL, "b", true, 1, n);
  int64_t *sliding = add(p, OF_CELL, "sliding", true, 1, n);
  int64_t *ends = add(p, LINES, "connectivity", true, 1, 2 * n),
          *end = add(p, LINES, "offsets", true, 1, n);
  p->points = 2 * n, p->lines = n;
  for (size_t k = 0; !p->failed && k < n; k++) {
    const config_contact *q = &c.contacts[k];
    const double *from = c.model->disks[q->a].position;
    at[2 * k][0] = from[0], at[2 * k][1] = from[1];
    at[2 * k + 1][0] = from[0] + q->lx, at[2 * k + 1][1] = from[1] + q->ly;
    force[k] = q->force, tau[k] = q->tau, overlap[k] = q->overlap, sliding[k] = q->slide;
    on_b[k][0] = q->fx, on_b[k][1] = q->fy;
    a[k] = c.number[q->a];
    b[k] =
        q->b < c.model->n_disks ? c.number[q->b] : (int64_t)(c.n_deck + (q->b - c.model->n_disks));
    ends[2 * k] = (int64_t)(2 * k), ends[2 * k + 1] = (int64_t)(2 * k + 1),
             end[k] = (int64_t)(2 * k + 2);
  }
  configuration_free(&c);
  return status;
}

/* --- walls ------------------------------------------------------------------------------------ */

enum { ARCS = 128 };

static size_t wall_points(const sd_wall *w) {
  return w->kind == SD_WALL_CIRCLE ? ARCS + 1
                                   : w->n_points + (w->kind == SD_WALL_POLYLINE && w->closed);
}

/* Extends an infinite line through the points at[0] and at[1] to the length of the box: moves both
 * points. */
static void stretch(const export_space *s, double (*at)[3]) {
  double x = at[0][0], y = at[0][1], tx = at[1][0] - x, ty = at[1][1] - y,
         square = tx * tx + ty * ty;
  double first = 0.0, last = 1.0;
  for (int k = 0; k < 4; k++) {
    double t = ((k & 1 ? s->upper[0] : s->lower[0]) - x) * tx +
               ((k & 2 ? s->upper[1] : s->lower[1]) - y) * ty;
    first = fmin(first, t / square);
    last = fmax(last, t / square);
  }
  at[0][0] = x + first * tx, at[0][1] = y + first * ty;
  at[1][0] = x + last * tx, at[1][1] = y + last * ty;
}

static void fill_walls(const export_job *job, const frame_data *f, piece *p) {
  const sd_model *m = job->m;
  export_space s = export_space_of(job, f);
  size_t n = 0, k = 0;
  for (size_t w = 0; w < m->n_walls; w++) n += wall_points(&m->walls[w]);
  double(*at)[3] = add(p, POINTS, "Points", false, 3, n);
  int64_t *wall = add(p, OF_CELL, "wall", true, 1, m->n_walls);
  int64_t *point = add(p, LINES, "connectivity", true, 1, n),
          *end = add(p, LINES, "offsets", true, 1, m->n_walls);
  p->points = n, p->lines = m->n_walls;
  for (size_t w = 0; !p->failed && w < m->n_walls; w++) {
    const sd_wall *from = &m->walls[w];
    size_t body = m->n_disks + w, first = k;
    for (size_t j = 0; j < wall_points(from); j++, k++) {
      double turn = 2.0 * M_PI * (double)(j % ARCS) / ARCS;
      at[k][0] = f->position[body][0] + from->radius * cos(turn);
      at[k][1] = f->position[body][1] + from->radius * sin(turn);
      if (from->kind != SD_WALL_CIRCLE)
        configuration_wall_point(from, f, body, j % from->n_points, at[k]);
      point[k] = (int64_t)k;
    }
    if (from->kind == SD_WALL_LINE && from->n_points == 2) stretch(&s, at + first);
    wall[w] = (int64_t)w;
    end[w] = (int64_t)k;
  }
}

/* --- files of all frames ---------------------------------------------------------------------- */

enum { DISKS, CONTACTS, WALLS, KINDS };
static const char *const kinds[KINDS] = {"disks", "contacts", "walls"};

static sd_status write_piece(const export_job *job, const file_folder *folder, int kind, size_t k,
                             const frame_data *f) {
  piece p = {0};
  sd_status status = SD_OK;
  char name[40];
  snprintf(name, sizeof name, "%s_%06zu.vtp", kinds[kind], k);
  if (kind == DISKS) fill_disks(job, f, &p);
  if (kind == CONTACTS) status = fill_contacts(job, f, &p);
  if (kind == WALLS) fill_walls(job, f, &p);
  if (status == SD_OK && p.failed)
    status = sd_fail(job->messages, SD_ERROR_IO, "no memory to export");
  FILE *out = status == SD_OK ? file_folder_new(folder, name, job->messages) : NULL;
  if (status == SD_OK && !out) status = SD_ERROR_IO;
  if (out) put_piece(&p, f->time, out);
  piece_free(&p);
  return file_folder_end(folder, out, status, job->messages);
}

static FILE *list_open(const file_folder *folder, const char *kind, sd_messages *messages) {
  char name[24];
  snprintf(name, sizeof name, "%s.pvd", kind);
  FILE *out = file_folder_new(folder, name, messages);
  if (out)
    fprintf(
        out,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n");
  return out;
}

sd_status export_vtk(const export_job *job) {
  file_folder folder;
  FILE *list[KINDS] = {NULL};
  sd_status status = file_folder_open(job->out, &folder, job->messages);
  for (int kind = 0; status == SD_OK && kind < KINDS; kind++) {
    if (kind == WALLS && job->m->n_walls == 0) continue;
    list[kind] = list_open(&folder, kinds[kind], job->messages);
    if (!list[kind]) status = SD_ERROR_IO;
  }
  for (size_t k = 0; status == SD_OK && k < job->range.n; k++) {
    frame_data frame;
    status = export_frame(job, k, &frame);
    for (int kind = 0; status == SD_OK && kind < KINDS; kind++) {
      if (!list[kind]) continue;
      status = write_piece(job, &folder, kind, k, &frame);
      fprintf(list[kind], "<DataSet timestep=\"%.17g\" part=\"0\" file=\"%s_%06zu.vtp\"/>\n",
              frame.time, kinds[kind], k);
    }
    frame_data_free(&frame);
  }
  for (int kind = 0; kind < KINDS; kind++) {
    if (list[kind]) fprintf(list[kind], "</Collection>\n</VTKFile>\n");
    status = file_folder_end(&folder, list[kind], status, job->messages);
  }
  return file_folder_close(&folder, status, job->messages);
}

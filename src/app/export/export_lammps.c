/* export_lammps.c: writes dump files and data files of LAMMPS as text, and extended XYZ files. See
 * export.h. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "app/export/export.h"
#include "io/store/file.h"
#include "version.h"

static const double SPHERE = 4.0 / 3.0 * 3.14159265358979323846;

/* --- dump ------------------------------------------------------------------------------------- */

/* True if the model has clumps. The columns "mol" and "molecule" then hold 1 + index of the clump,
 * without clumps 1 + index of the group; 0: no clump or group. */
static bool has_clumps(const sd_model *m) {
  for (size_t i = 0; i < m->n_disks; i++)
    if (m->disks[i].clump > 0) return true;
  return false;
}

static void dump_frame(const export_job *job, const frame_data *f, FILE *out) {
  const sd_model *m = job->m;
  const bool clumps = has_clumps(m);
  export_space s = export_space_of(job, f);
  const bool tilted = s.offset != 0.0;
  fprintf(out,
          "ITEM: TIMESTEP\n%" PRId64 "\nITEM: NUMBER OF ATOMS\n%zu\nITEM: BOX BOUNDS %s%s %s pp\n",
          f->step, export_count(job, f), tilted ? "xy xz yz " : "", m->periodic[0] ? "pp" : "ff",
          m->periodic[1] ? "pp" : "ff");
  /* For a tilted box, LAMMPS wants the bounds of the rectangle around the box */
  for (int c = 0; c < 3; c++) {
    const double low = c == 0 ? fmin(s.offset, 0.0) : 0.0,
                 high = c == 0 ? fmax(s.offset, 0.0) : 0.0;
    fprintf(out, "%.17g %.17g", s.lower[c] + low, s.upper[c] + high);
    if (tilted) fprintf(out, " %.17g", c == 0 ? s.offset : 0.0);
    fputc('\n', out);
  }
  fprintf(out, "ITEM: ATOMS id type mol x y z ix iy iz vx vy vz omegaz angle radius mass\n");
  for (size_t i = 0; i < m->n_disks; i++) {
    const sd_disk *d = &m->disks[i];
    if (!export_has(job, f, i)) continue;
    fprintf(out, "%zu %u %d %.17g %.17g 0 %d %d 0 %.17g %.17g 0 %.17g %.17g %.17g %.17g\n", i + 1,
            job->type_of[i] + 1, clumps ? d->clump : d->group + 1, f->position[i][0],
            f->position[i][1], f->image[i][0], f->image[i][1], f->velocity[i][0], f->velocity[i][1],
            f->spin[i], f->angle[i], d->radius, d->mass);
  }
}

/* --- extended XYZ ----------------------------------------------------------------------------- */

/* Writes a frame as extended XYZ with the property names of OVITO. The species is "X", which ASE
 * accepts as an element; the type is called "kind", since OVITO would read a property "type" as the
 * species. */
static void xyz_frame(const export_job *job, const frame_data *f, FILE *out) {
  const sd_model *m = job->m;
  const bool clumps = has_clumps(m);
  export_space s = export_space_of(job, f);
  fprintf(out,
          "%zu\nLattice=\"%.17g 0 0 %.17g %.17g 0 0 0 %.17g\" Origin=\"%.17g %.17g %.17g\" "
          "pbc=\"%c %c F\" ",
          export_count(job, f), s.upper[0] - s.lower[0], s.offset, s.upper[1] - s.lower[1],
          s.upper[2] - s.lower[2], s.lower[0], s.lower[1], s.lower[2], m->periodic[0] ? 'T' : 'F',
          m->periodic[1] ? 'T' : 'F');
  fprintf(out,
          "Time=%.17g Step=%" PRId64
          " Properties=species:S:1:pos:R:3:id:I:1:kind:I:1:molecule:I:1:radius:R:1:"
          "mass:R:1:velo:R:3:angle:R:1:omega:R:3:map_shift:I:3\n",
          f->time, f->step);
  for (size_t i = 0; i < m->n_disks; i++) {
    const sd_disk *d = &m->disks[i];
    if (!export_has(job, f, i)) continue;
    fprintf(out, "X %.17g %.17g 0 %zu %u %d %.17g %.17g %.17g %.17g 0 %.17g 0 0 %.17g %d %d 0\n",
            f->position[i][0], f->position[i][1], i + 1, job->type_of[i] + 1,
            clumps ? d->clump : d->group + 1, d->radius, d->mass, f->velocity[i][0],
            f->velocity[i][1], f->angle[i], f->spin[i], f->image[i][0], f->image[i][1]);
  }
}

static sd_status write_text(const export_job *job,
                            void (*put)(const export_job *, const frame_data *, FILE *)) {
  file_stream stream = {0};
  sd_status status = file_stream_open(job->out, &stream, job->messages);
  for (size_t k = 0; status == SD_OK && k < job->range.n && !ferror(stream.out); k++) {
    frame_data frame;
    status = export_frame(job, k, &frame);
    if (status == SD_OK) put(job, &frame, stream.out);
    frame_data_free(&frame);
  }
  return file_stream_close(&stream, status, job->messages);
}

sd_status export_dump(const export_job *job) { return write_text(job, dump_frame); }

sd_status export_xyz(const export_job *job) { return write_text(job, xyz_frame); }

/* --- data ------------------------------------------------------------------------------------- */

/* Writes walls and groups as comments, which LAMMPS skips: a data file cannot hold walls, and
 * groups belong to the input script. */
static void data_walls(const export_job *job, const frame_data *f, FILE *out) {
  static const char *const kinds[] = {"line", "segment", "polyline", "circle", "arc"};
  const sd_model *m = job->m;
  enum { MOST_POINTS = 1000 };
  for (size_t w = 0; w < m->n_walls; w++) {
    const sd_wall *wall = &m->walls[w];
    size_t body = m->n_disks + w;
    fprintf(out, "# wall %zu%s%s: %s", w, wall->name ? " " : "", wall->name ? wall->name : "",
            kinds[wall->kind]);
    if (wall->kind == SD_WALL_CIRCLE)
      fprintf(out, ", disks %s, centre %.17g %.17g, radius %.17g",
              wall->inside ? "inside" : "outside", f->position[body][0], f->position[body][1],
              wall->radius);
    /* Write each corner of a wall on a line of its own, since a line may have 255 bytes at most. */
    for (size_t k = 0; wall->kind != SD_WALL_CIRCLE && k < wall->n_points && k < MOST_POINTS; k++) {
      double at[2];
      configuration_wall_point(wall, f, body, k, at);
      fprintf(out, "\n#   %.17g %.17g", at[0], at[1]);
    }
    fputc('\n', out);
  }
}

static void data_head(const export_job *job, const frame_data *f, FILE *out) {
  const sd_model *m = job->m;
  static const char *const names[] = {"x", "y", "z"};
  export_space s = export_space_of(job, f);
  fprintf(out,
          "slipdisk %s, step %" PRId64
          ", time %.17g, units of the deck\n\n%zu atoms\n%zu atom types\n\n",
          SD_VERSION, f->step, f->time, export_count(job, f), job->n_types ? job->n_types : 1);
  for (int c = 0; c < 3; c++)
    fprintf(out, "%.17g %.17g %slo %shi\n", s.lower[c], s.upper[c], names[c], names[c]);
  if (s.offset != 0.0) fprintf(out, "%.17g 0 0 xy xz yz\n", s.offset);
  fprintf(out,
          "\n# dimension 2; boundary %c %c p; atom_style sphere; the density below gives the mass "
          "of a disk\n",
          m->periodic[0] ? 'p' : 'f', m->periodic[1] ? 'p' : 'f');
  for (size_t t = 0; t < job->n_types; t++) {
    char *text = export_type_text(job, t);
    fprintf(out, "# type %zu: %.200s\n", t + 1, text);
    free(text);
  }
  for (int driven = 0; driven < 2; driven++) {
    bool any = false;
    for (size_t t = 0; t < job->n_types; t++) {
      if (job->types[t].driven != driven) continue;
      if (!any || t % 20 == 0)
        fprintf(out, "%s# group %s type", any ? "\n" : "", driven ? "fixed" : "moving");
      fprintf(out, " %zu", t + 1);
      any = true;
    }
    if (any) fputc('\n', out);
  }
  data_walls(job, f, out);
}

static void data_atoms(const export_job *job, const frame_data *f, FILE *out) {
  const sd_model *m = job->m;
  fprintf(out, "\nAtoms # sphere\n\n");
  for (size_t i = 0; i < m->n_disks; i++) {
    double r = m->disks[i].radius;
    if (!export_has(job, f, i)) continue;
    fprintf(out, "%zu %u %.17g %.17g %.17g %.17g 0 %d %d 0\n", i + 1, job->type_of[i] + 1, 2.0 * r,
            m->disks[i].mass / (SPHERE * r * r * r), f->position[i][0], f->position[i][1],
            f->image[i][0], f->image[i][1]);
  }
  fprintf(out, "\nVelocities\n\n");
  for (size_t i = 0; i < m->n_disks; i++)
    if (export_has(job, f, i))
      fprintf(out, "%zu %.17g %.17g 0 0 0 %.17g\n", i + 1, f->velocity[i][0], f->velocity[i][1],
              f->spin[i]);
}

static void data_frame(const export_job *job, const frame_data *f, FILE *out) {
  data_head(job, f, out);
  data_atoms(job, f, out);
}

sd_status export_data(const export_job *job) { return write_text(job, data_frame); }

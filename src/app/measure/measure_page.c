/* measure_page.c: prints the results of `slipdisk measure` as text, JSON and CSV. Names and
 * definitions of the quantities: docs/measure.md. */
#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "app/json.h"
#include "app/measure/measure.h"
#include "base/limits.h"
#include "base/text.h"
#include "io/store/file.h"
#include "model/model.h"

static const double DEGREES = 180.0 / M_PI;

/* Names of the sides of the region, in the order of the bits of measurement.open */
static const char *const sides[] = {"left", "right", "bottom", "top"};

static double ratio(double a, double b) { return b != 0.0 ? a / b : NAN; }

/* --- text output ------------------------------------------------------------------------------ */

/* Formats a value; "-" if it is not finite. */
static const char *shown(double value, int digits, char text[32]) {
  if (isfinite(value))
    snprintf(text, 32, "%.*g", digits, value);
  else
    snprintf(text, 32, "-");
  return text;
}

/* Prints a line with name, value and unit (or a remark); the value is "-" if it is not finite. */
static void line(FILE *out, const char *name, double value, const char *format, ...)
    SD_PRINTF(4, 5);
static void line(FILE *out, const char *name, double value, const char *format, ...) {
  char text[32] = "-";
  if (isfinite(value)) snprintf(text, sizeof text, "%.6g", value);
  fprintf(out, "  %-26s %12s", name, text);
  if (*format) fputs("  ", out);
  va_list args;
  va_start(args, format);
  vfprintf(out, format, args);
  va_end(args);
  fputc('\n', out);
}

static const char *body_word(const stress *s) { return s->clumps > 0 ? "body" : "disk"; }

/* Prints packing fractions. If the region is open, it may contain empty space beyond the packing;
 * then the packing fraction of the closed Voronoi cells tells how dense the packing is. */
static void page_packing(FILE *out, const measurement *m) {
  const cells *t = &m->cells;
  char local[3][32];
  fprintf(out, "\npacking\n");
  if (!m->open) line(out, "packing fraction", m->s.fraction, "of the region");
  if (m->has_cells) {
    line(out, m->open ? "packing fraction" : "inside", t->inside,
         "of %zu closed cells (%zu are open: at a surface or edge)", t->n_closed, t->n_open);
    line(out, "local", t->mean, "+- %s from disk to disk, %s to %s",
         shown(t->deviation, 4, local[0]), shown(t->least, 4, local[1]),
         shown(t->most, 4, local[2]));
  }
  if (m->open) line(out, "of the region", m->s.fraction, "which is open: empty space counts");
}

static void page_disks(FILE *out, const measurement *m) {
  const stress *s = &m->s;
  char text[32];
  fprintf(out, "\ndisks\n");
  line(out, "free", (double)s->free, "in the region");
  if (s->clumps > 0) line(out, "clumps", (double)s->clumps, "rigid bodies that they make");
  if (s->fixed > 0) line(out, "prescribed", (double)s->fixed, "in the region");
  if (s->outside > 0) line(out, "free elsewhere", (double)s->outside, "left out below");
  if (m->c.n_waiting > 0) line(out, "waiting", (double)m->c.n_waiting, "to be released");
  if (m->c.n_removed > 0) line(out, "removed", (double)m->c.n_removed, "beyond the bounds");
  line(out, "rattlers", (double)s->rattlers, "%s %%: fewer than %d load-bearing contacts",
       shown(100.0 * ratio((double)s->rattlers, (double)s->free), 3, text),
       m->c.frictionless ? 3 : 2);
  page_packing(out, m);
}

static void page_contacts(FILE *out, const measurement *m) {
  const stress *s = &m->s;
  const correlation *g = &m->pairs;
  char text[2][32];
  fprintf(out, "\ncontacts\n");
  if (s->n_contacts == 0)
    fprintf(out, "  %-26s %12d\n", "closed", 0);
  else
    line(out, "closed", (double)s->n_contacts, "%zu with walls or prescribed disks, %zu bear load",
         s->n_wall, s->n_bearing);
  if (s->n_bonds > 0)
    line(out, "bonds", (double)s->n_bonds, "%zu bodies of bonded disks, mass of the heaviest %s",
         s->fragments, shown(s->largest_fragment, 6, text[0]));
  if (s->n_contacts == 0) return;
  line(out, "per disk", s->z, "%s load-bearing, %s without rattlers",
       shown(s->z_bearing, 6, text[0]), shown(s->z_backbone, 6, text[1]));
  double sliding = 100.0 * ratio((double)s->n_sliding, (double)s->n_contacts);
  if (m->c.frictionless)
    line(out, "sliding", NAN, "there is no friction");
  else if (m->c.recomputed)
    line(out, "sliding", NAN, "not stored with this frame");
  else
    line(out, "sliding", (double)s->n_sliding, "%s %%", shown(sliding, 3, text[0]));
  line(out, "mobilised friction", g->mobilised.mean, "mean of |tau|/(mu F_n)");
  line(out, "normal force", s->mean_force, "force, mean; spread %s, largest %s times that",
       shown(g->normal.deviation, 4, text[0]),
       shown(ratio(g->normal.most, s->mean_force), 4, text[1]));
  line(out, "tangential force", g->tangential.mean, "force, mean of |tau|");
  line(out, "overlap", s->overlap_mean, "length, mean");
  const sd_model *model = m->c.model;
  bool disk = s->overlap_b < model->n_disks;
  line(out, "largest overlap", s->overlap_max, "length, disk %u and %s %u",
       m->c.number[s->overlap_a], disk ? "disk" : "wall",
       disk ? m->c.number[s->overlap_b] : s->overlap_b - (uint32_t)model->n_disks);
  line(out, "unbalanced force", s->unbalanced, "mean resultant on a %s over mean normal force",
       body_word(s));
  line(out, "anisotropy", s->anisotropy,
       "of the directions of load-bearing contacts, most at %s deg",
       shown(s->fabric_angle * DEGREES, 4, text[0]));
}

static void page_stress(FILE *out, const measurement *m) {
  const stress *s = &m->s;
  const principal *p = &s->contact_principal;
  const correlation *g = &m->pairs;
  const double *k = s->kinetic;
  char text[2][32];
  fprintf(out, "\nstress (compression positive)\n");
  line(out, "pressure", p->mean, "force/length");
  line(out, "deviator", p->deviator, "force/length, %s of the pressure; largest stress at %s deg",
       shown(ratio(p->deviator, p->mean), 4, text[0]), shown(p->angle * DEGREES, 4, text[1]));
  fprintf(out, "  %-26s %12.6g %12.6g\n  %-26s %12.6g %12.6g\n", "xx xy", s->contact[STRESS_XX],
          s->contact[STRESS_XY], "yx yy", s->contact[STRESS_YX], s->contact[STRESS_YY]);
  line(out, "kinetic pressure", 0.5 * (k[STRESS_XX] + k[STRESS_YY]), "force/length");
  double energy = s->energy_translation + s->energy_rotation;
  line(out, "kinetic energy", energy, "energy per %s, %s %% in rotation", body_word(s),
       shown(100.0 * ratio(s->energy_rotation, energy), 3, text[0]));
  if (!g->pairs) return;
  fprintf(out, "\npairs\n");
  line(out, "g(r) highest", g->peak, "at r = %.6g, %.4g mean diameters", g->peak_r,
       g->peak_r / (2.0 * configuration_radius(&m->c)));
}

void measure_page(FILE *out, const measurement *m) {
  const region *g = &m->region;
  char *name = text_escaped(m->file, LIMIT_LINE);
  fprintf(out, "%s: ", name);
  free(name);
  if (m->frame >= 0)
    fprintf(out, "frame %" PRId64, m->frame);
  else
    fprintf(out, "last state");
  fprintf(out, ", step %" PRId64 ", time %.6g\n", m->c.step, m->c.time);
  if (region_is_round(g))
    fprintf(out, "region: the drum of radius %.6g about (%.6g, %.6g), area %.6g\n",
            g->outline.radius, g->outline.centre[0], g->outline.centre[1], m->s.area);
  else
    fprintf(out, "region: x %.6g to %.6g%s, y %.6g to %.6g%s,%s area %.6g\n", g->lower[0],
            g->upper[0], g->whole[0] ? " (periodic)" : "", g->lower[1], g->upper[1],
            g->whole[1] ? " (periodic)" : "", g->outline.n > 0 ? " inside the walls," : "",
            m->s.area);
  if (m->open) {
    bool given = m->c.model->region_upper[0] > m->c.model->region_lower[0];
    fputs(given ? "open at the" : "the deck gives no region, this one is about the disks", out);
    for (int k = 0, n = 0; given && k < 4; k++)
      if (m->open >> k & 1) fprintf(out, "%s %s", n++ ? "," : "", sides[k]);
    fprintf(out, ": fraction of the region, stress and pressure are means over empty space, too\n");
  }
  if (m->c.recomputed)
    fprintf(
        out,
        "contacts were not stored with this frame: found again from positions and velocities%s\n",
        m->c.frictionless ? "" : ", without what friction remembers");
  page_disks(out, m);
  page_contacts(out, m);
  page_stress(out, m);
}

void measure_rows_head(FILE *out) {
  fprintf(out, "%7s %12s %10s %7s %8s %8s %8s %8s %9s %9s %8s %8s %10s %8s %10s\n", "frame", "step",
          "time", "disks", "rattlers", "contacts", "z", "z back", "width", "height", "fraction",
          "inside", "pressure", "q/p", "unbalanced");
}

void measure_row(FILE *out, const measurement *m) {
  const stress *s = &m->s;
  char text[9][32], frame[32] = "state";
  if (m->frame >= 0) snprintf(frame, sizeof frame, "%" PRId64, m->frame);
  fprintf(out, "%7s %12" PRId64 " %10.5g %7zu %8zu %8zu %8s %8s %9s %9s %8s %8s %10s %8s %10s%s\n",
          frame, m->c.step, m->c.time, s->free, s->rattlers, s->n_contacts, shown(s->z, 4, text[0]),
          shown(s->z_backbone, 4, text[1]), shown(m->width, 5, text[6]),
          shown(m->height, 5, text[7]), shown(m->open ? NAN : s->fraction, 5, text[2]),
          shown(m->cells.inside, 5, text[8]), shown(s->contact_principal.mean, 5, text[3]),
          shown(ratio(s->contact_principal.deviator, s->contact_principal.mean), 3, text[4]),
          shown(s->unbalanced, 3, text[5]), m->c.recomputed ? " *" : "");
}

/* --- JSON output ------------------------------------------------------------------------------ */

/* Returns the elements xx, xy, yx, yy of a tensor as two rows. */
static json_t *tensor(const observable *o, const measurement *m) {
  return json_pack("[[o, o], [o, o]]", json_observable(o, m, 0), json_observable(o, m, 1),
                   json_observable(o, m, 2), json_observable(o, m, 3));
}

/* Removes members that a distribution without values does not have. */
static void drop_histogram(json_t *object, const distribution *d) {
  static const char *const names[] = {"least", "most", "edges", "density"};
  for (size_t k = 0; !d->histogram && k < sizeof names / sizeof *names; k++)
    json_object_del(object, names[k]);
}

/* Returns one measurement as JSON: all of measurement_observables. */
json_t *measure_json(const measurement *m) {
  json_t *frame = json_pack("{s:o}", "frame", m->frame >= 0 ? json_integer(m->frame) : json_null());
  const observable_list *list = &measurement_observables;
  for (const observable *o = list->rows; o < list->rows + list->n; o++) {
    const char *name = o->json ? o->json : o->name;
    if (*name)
      json_put(frame, name,
               o->width == 1 ? json_observable(o, m, 0)
               : o->width == MEASUREMENT_TENSOR
                   ? tensor(o, m)
                   : json_elements(o, m, measurement_width(o, m->bins)));
  }
  json_t *open = json_array();
  for (int k = 0; k < 4; k++)
    if (m->open >> k & 1) json_array_append_new(open, json_string(sides[k]));
  json_put(frame, "region.open", open);
  if (!region_is_round(&m->region)) json_object_del(json_object_get(frame, "region"), "radius");
  if (!m->has_cells) json_object_set_new(frame, "cells", json_null());
  if (!m->pairs.pairs) json_object_set_new(frame, "pairs", json_null());
  drop_histogram(json_object_get(frame, "normal_force"), &m->pairs.normal);
  drop_histogram(json_object_get(frame, "tangential_force"), &m->pairs.tangential);
  drop_histogram(json_object_get(frame, "mobilised_friction"), &m->pairs.mobilised);
  return frame;
}

/* --- JSON of all frames, one after the other: memory does not grow with their number ---------- */

sd_status measure_list_open(measure_list *l, const char *name, size_t stored, const char *path,
                            sd_messages *messages) {
  char *shown = text_clean(format_text("%s", name));
  json_t *text = json_string(shown);
  free(shown);
  *l = (measure_list){.out = stdout, .stored = stored, .name = json_dumps(text, JSON_ENCODE_ANY)};
  json_decref(text);
  if (!path) return SD_OK;
  /* Refuse a device or a pipe as the output now, rather than after everything is measured. */
  if (file_is_special(path))
    return sd_fail(messages, SD_ERROR_IO, "cannot write %s: it is a device or a pipe", path);
  sd_status status = file_stream_open(path, &l->file, messages);
  l->out = l->file.out;
  return status;
}

/* Writes the beginning of the JSON output. It is called with the first frame, so that an error
 * before that leaves no output. */
static void put_head(const measure_list *l) {
  fprintf(l->out, "{\n  \"file\": %s,\n  \"stored\": %zu,\n  \"frames\": [", l->name, l->stored);
}

void measure_list_add(measure_list *l, const measurement *m) {
  json_t *frame = measure_json(m);
  char *text = json_dumps(frame, JSON_INDENT(2));
  json_decref(frame);
  if (l->n == 0) put_head(l);
  fputs(l->n++ > 0 ? "," : "", l->out);
  for (const char *at = text; *at;) {
    size_t length = strcspn(at, "\n");
    fprintf(l->out, "\n    %.*s", (int)length, at);
    at += length + (at[length] == '\n');
  }
  free(text);
}

sd_status measure_list_close(measure_list *l, sd_status status, sd_messages *messages) {
  if (status == SD_OK) {
    if (l->n == 0) put_head(l);
    fputs(l->n > 0 ? "\n  ]\n}\n" : "]\n}\n", l->out);
  }
  status = file_stream_close(&l->file, status, messages);
  free(l->name);
  *l = (measure_list){0};
  return status;
}

/* --- CSV tables; columns: docs/measure.md ----------------------------------------------------- */

static const struct table {
  const char *name, *head;
} tables[MEASURE_TABLES] = {
    [MEASURE_FRAMES] = {"frames.csv", NULL}, /* The columns are those of measurement_observables */
    [MEASURE_DISKS] =
        {"disks.csv",
         "step,disk,x,y,radius,prescribed,rattler,contacts,bearing,pressure,cell,closed,"
         "fraction,resultant_x,resultant_y"},
    [MEASURE_CONTACTS] = {"contacts.csv", MEASURE_CONTACT_COLUMNS},
    [MEASURE_PAIRS] = {"gr.csv", "step,r,g"},
    [MEASURE_FORCES] = {"forces.csv",
                        "step,low,high,normal,tangential,mobilised_low,mobilised_high,mobilised"},
};

sd_status measure_tables_open(measure_tables *t, const char *folder, const bool *wanted,
                              sd_messages *messages) {
  *t = (measure_tables){.wanted = wanted};
  sd_status status = file_make_folder(folder, messages);
  for (int k = 0; status == SD_OK && k < MEASURE_TABLES; k++) {
    char *path = format_text("%s/%s", folder, tables[k].name);
    status = file_stream_open(path, &t->file[k], messages);
    t->out[k] = t->file[k].out;
    if (t->out[k] && tables[k].head) fprintf(t->out[k], "%s\n", tables[k].head);
    free(path);
  }
  const char *comma = "";
  for (size_t k = 0; status == SD_OK && k < measurement_observables.n; k++) {
    const char *column = measurement_observables.rows[k].column;
    if (column) fprintf(t->out[MEASURE_FRAMES], "%s%s", comma, column);
    if (column) comma = ",";
  }
  if (status == SD_OK) fputc('\n', t->out[MEASURE_FRAMES]);
  return status;
}

sd_status measure_tables_close(measure_tables *t, sd_status status, sd_messages *messages) {
  for (int k = 0; k < MEASURE_TABLES; k++)
    status = file_stream_close(&t->file[k], status, messages);
  *t = (measure_tables){0};
  return status;
}

/* --- rows ------------------------------------------------------------------------------------- */

/* Writes a CSV cell; the cell is empty if the value is not finite. */
static void number(FILE *out, double value) {
  if (isfinite(value))
    fprintf(out, ",%.17g", value);
  else
    fputc(',', out);
}

static void add_frame(FILE *out, const measurement *m) {
  fprintf(out, "%" PRId64, m->c.step);
  /* Skip observable 0, the step, which begins the row */
  for (size_t k = 1; k < measurement_observables.n; k++) {
    const observable *o = &measurement_observables.rows[k];
    if (o->column) number(out, observable_value(o, m, 0));
  }
  fputc('\n', out);
}

static void add_disks(FILE *out, const measurement *m, const bool *wanted) {
  const sd_model *model = m->c.model;
  const stress *s = &m->s;
  for (size_t i = 0; i < model->n_disks; i++) {
    if (wanted && !wanted[m->c.number[i]]) continue;
    const sd_disk *d = &model->disks[i];
    bool closed = m->has_cells && m->cells.closed[i];
    double area = m->has_cells ? m->cells.area[i] : NAN;
    fprintf(out, "%" PRId64 ",%u,%.17g,%.17g,%.17g,%d,%d,%d,%d", m->c.step, m->c.number[i],
            d->position[0], d->position[1], d->radius, d->driven, s->rattler[i],
            (int)s->contacts[i], (int)s->bearing[i]);
    number(out, measurement_pressure(m, i));
    number(out, area);
    fprintf(out, ",%d", closed);
    number(out, m->has_cells ? cells_fraction(&m->cells, &m->c, i) : NAN);
    number(out, m->c.recomputed && !m->c.frictionless ? NAN : s->resultant[i][0]);
    number(out, m->c.recomputed && !m->c.frictionless ? NAN : s->resultant[i][1]);
    fputc('\n', out);
  }
}

static uint32_t deck_number(const configuration *c, uint32_t body) {
  size_t n = c->model->n_disks;
  return body < n ? c->number[body] : (uint32_t)(c->n_deck + (body - n));
}

void measure_contacts(FILE *out, const configuration *c, const bool *wanted) {
  for (size_t k = 0; k < c->n_contacts; k++) {
    const config_contact *q = &c->contacts[k];
    uint32_t a = deck_number(c, q->a), b = deck_number(c, q->b);
    if (wanted && !wanted[a] && !wanted[b]) continue;
    fprintf(out, "%" PRId64 ",%u,%u,%u,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g", c->step, a, b, q->part,
            q->x, q->y, q->nx, q->ny, q->overlap, q->force);
    bool known = isfinite(q->tau);
    number(out, q->tau);
    number(out, known && q->mu > 0.0 && q->push > 0.0 ? fabs(q->tau) / (q->mu * q->push) : NAN);
    if (c->recomputed)
      fputc(',', out);
    else
      fprintf(out, ",%d", q->slide);
    number(out, known ? q->fx : NAN);
    number(out, known ? q->fy : NAN);
    number(out, known && q->k_t > 0.0 ? 0.0 - q->tau / q->k_t : NAN);
    fputc('\n', out);
  }
}

static void add_pairs(FILE *out, const measurement *m) {
  const gsl_histogram *h = m->pairs.pairs;
  for (size_t k = 0; h && k < h->n; k++)
    fprintf(out, "%" PRId64 ",%.17g,%.17g\n", m->c.step, 0.5 * (h->range[k] + h->range[k + 1]),
            h->bin[k]);
}

static void add_forces(FILE *out, const measurement *m) {
  const distribution *n = &m->pairs.normal, *t = &m->pairs.tangential, *f = &m->pairs.mobilised;
  for (size_t k = 0; n->histogram && k < n->histogram->n; k++) {
    fprintf(out, "%" PRId64 ",%.17g,%.17g", m->c.step, n->histogram->range[k],
            n->histogram->range[k + 1]);
    number(out, distribution_density(n, k));
    number(out, t->histogram ? distribution_density(t, k) : NAN);
    number(out, f->histogram ? f->histogram->range[k] : NAN);
    number(out, f->histogram ? f->histogram->range[k + 1] : NAN);
    number(out, f->histogram ? distribution_density(f, k) : NAN);
    fputc('\n', out);
  }
}

void measure_tables_add(const measure_tables *t, const measurement *m) {
  add_frame(t->out[MEASURE_FRAMES], m);
  add_disks(t->out[MEASURE_DISKS], m, t->wanted);
  measure_contacts(t->out[MEASURE_CONTACTS], &m->c, t->wanted);
  add_pairs(t->out[MEASURE_PAIRS], m);
  add_forces(t->out[MEASURE_FORCES], m);
}

/* --- means of the run ------------------------------------------------------------------------- */

/* Writes a CSV file with a row for each of the n structs at `first`, which are `stride` bytes
 * apart. Columns are the observables of `list`; the first of them must be the number of the disk.
 * names: [n] names for a second column; NULL: no such column. */
static sd_status write_means(const char *folder, const char *file, size_t n_disks,
                             const bool *wanted, const observable_list *list, const void *first,
                             size_t stride, size_t n, char *const *names, sd_messages *messages) {
  file_stream stream = {0};
  char *path = format_text("%s/%s", folder, file);
  sd_status status = file_stream_open(path, &stream, messages);
  FILE *out = stream.out;
  for (size_t k = 0; out && k < list->n; k++)
    fprintf(out, "%s%s%s", k ? "," : "", list->rows[k].name, k == 0 && names ? ",name" : "");
  if (out) fputc('\n', out);
  for (size_t i = 0; out && i < n; i++) {
    const char *row = (const char *)first + i * stride;
    uint32_t disk = (uint32_t)observable_value(&list->rows[0], row, 0);
    if (wanted && (disk >= n_disks || !wanted[disk])) continue;
    fprintf(out, "%u", disk);
    if (names) {
      fputc(',', out);
      text_cell(out, names[i]);
    }
    for (size_t k = 1; k < list->n; k++) number(out, observable_value(&list->rows[k], row, 0));
    fputc('\n', out);
  }
  free(path);
  return file_stream_close(&stream, status, messages);
}

sd_status measure_tables_means(const char *folder, size_t n_disks, const bool *wanted,
                               const summary *s, sd_messages *messages) {
  sd_status status = SD_OK;
  if (s->n_rotations > 0)
    status =
        write_means(folder, "rotation.csv", n_disks, wanted, &rotation_observables, s->rotations,
                    sizeof *s->rotations, s->n_rotations, s->rotation_names, messages);
  if (status == SD_OK && s->packing.n > 0)
    status = write_means(folder, "means.csv", n_disks, wanted, &disk_observables, s->packing.disks,
                         sizeof *s->packing.disks, s->packing.n, NULL, messages);
  return status;
}

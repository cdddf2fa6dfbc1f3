/* measure_tables.c: CSV of slipdisk measure; columns: docs/measure.md. */
#include <inttypes.h>
#include <stdlib.h>

#include "base/text.h"
#include "app/measure/measure.h"
#include "io/store/file.h"

static const struct table {
  const char *name, *head;
} tables[MEASURE_TABLES] = {
    [MEASURE_FRAMES] = {"frames.csv", NULL}, /* measurement_observables */
    [MEASURE_DISKS] = {"disks.csv",
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
  for (int k = 0; k < MEASURE_TABLES; k++) status = file_stream_close(&t->file[k], status, messages);
  *t = (measure_tables){0};
  return status;
}

/* --- rows --------------------------------------------------------------------------------------------- */

/* Unknown values are empty cells. */
static void number(FILE *out, double value) {
  if (isfinite(value))
    fprintf(out, ",%.15g", value);
  else
    fputc(',', out);
}

static void add_frame(FILE *out, const measurement *m) {
  fprintf(out, "%" PRId64, m->c.step);
  for (size_t k = 1; k < measurement_observables.n; k++) { /* the first is the step */
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
    fprintf(out, "%" PRId64 ",%u,%.15g,%.15g,%.15g,%d,%d,%d,%d", m->c.step, m->c.number[i], d->position[0],
            d->position[1], d->radius, d->driven, s->rattler[i], (int)s->contacts[i], (int)s->bearing[i]);
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
    fprintf(out, "%" PRId64 ",%u,%u,%u,%.15g,%.15g,%.15g,%.15g,%.15g,%.15g", c->step, a, b, q->part, q->x,
            q->y, q->nx, q->ny, q->overlap, q->force);
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
    fprintf(out, "%" PRId64 ",%.15g,%.15g\n", m->c.step, 0.5 * (h->range[k] + h->range[k + 1]), h->bin[k]);
}

static void add_forces(FILE *out, const measurement *m) {
  const distribution *n = &m->pairs.normal, *t = &m->pairs.tangential, *f = &m->pairs.mobilised;
  for (size_t k = 0; n->histogram && k < n->histogram->n; k++) {
    fprintf(out, "%" PRId64 ",%.15g,%.15g", m->c.step, n->histogram->range[k], n->histogram->range[k + 1]);
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

/* --- means of the run --------------------------------------------------------------------------------- */

/* names (may be NULL): a column of them behind the number of the disk, the first row of the list. */
static sd_status write_means(const char *folder, const char *file, size_t n_disks, const bool *wanted,
                             const observable_list *list, const void *first, size_t stride, size_t n,
                             char *const *names, sd_messages *messages) {
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

sd_status measure_tables_means(const char *folder, size_t n_disks, const bool *wanted, const summary *s,
                               sd_messages *messages) {
  sd_status status = SD_OK;
  if (s->n_rotations > 0)
    status = write_means(folder, "rotation.csv", n_disks, wanted, &rotation_observables, s->rotations,
                         sizeof *s->rotations, s->n_rotations, s->rotation_names, messages);
  if (status == SD_OK && s->packing.n > 0)
    status = write_means(folder, "means.csv", n_disks, wanted, &disk_observables, s->packing.disks,
                         sizeof *s->packing.disks, s->packing.n, NULL, messages);
  return status;
}

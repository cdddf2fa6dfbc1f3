/* sweep_table.c: the table of a sweep's results, and the means over replicas. See sweep.h; docs/sweep.md lists the
 * columns. Only finished points have numbers: what an unfinished one has found so far is for `--status`. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/text.h"
#include "io/store/file.h"
#include "io/store/folder.h"
#include "run/sheet.h"
#include "run/sweep.h"

/* --- a row per point --------------------------------------------------------------------------------------- */

static void put_point(sheet *t, const sweep *s, size_t k, const sweep_result *r) {
  const sweep_point *p = &s->deck.points[k];
  sheet_integer(t, k, "point", "number of the point, as for --point", (int64_t)k);
  sheet_text(t, k, "name", "the result is points/NAME.h5", p->name);
  sheet_text(t, k, "status", "done, or why there are no numbers", sweep_status_names[r->status]);
  sheet_integer(t, k, "set", "points of the same set differ in the replica only", (int64_t)p->set);
  sheet_integer(t, k, "replica", "number of the replica", p->replica);
  sheet_integer(t, k, "seed", "seed of the random streams", p->seed);
  for (size_t j = 0; j < s->deck.n_parameters; j++) {
    const sweep_parameter *a = &s->deck.parameters[j];
    if (a->text)
      sheet_text(t, k, a->name, "varied", p->texts[j]);
    else
      sheet_number(t, k, a->name, "", "varied; an angle in rad", p->values[j]);
  }
  sheet_text(t, k, "message", "why the point failed, or its result is in doubt", r->message);
}

/* One cell of a disk, or of a contact when there is a partner. */
typedef struct owner {
  sheet *t;
  size_t row;
  const char *disk, *partner;
} owner;

static void cell(const owner *o, const char *quantity, const char *unit, const char *meaning, double x) {
  char *name = o->partner ? format_text("%s.%s.%s", o->disk, o->partner, quantity)
                          : format_text("%s.%s", o->disk, quantity);
  if (name)
    sheet_number(o->t, o->row, name, unit, meaning, x);
  else
    o->t->failed = true;
  free(name);
}

static void put_rotation(sheet *t, size_t row, const char *disk, const sd_rotation *r) {
  owner o = {t, row, disk, NULL};
  cell(&o, "omega", "rad/time", "mean angular velocity", r->omega);
  cell(&o, "omega_error", "rad/time", "one standard error", r->error);
  cell(&o, "scaled", "rad", "t_g Omega, t_g = sqrt(2 R/g)", r->scaled);
  cell(&o, "scaled_error", "rad", "one standard error", r->scaled_error);
  cell(&o, "transient", "time", "measured time that was discarded", r->transient);
  cell(&o, "measured", "time", "measured time, with the transient", r->measured);
  cell(&o, "converged", "1", "1: the error bar is reliable", r->converged ? 1 : 0);
}

static void put_slide(sheet *t, size_t row, char *const names[3], const sd_slide *s) {
  owner o = {t, row, names[0], NULL};
  cell(&o, "pp", "1", "fraction of time in S++", s->pp);
  cell(&o, "pm", "1", "fraction of time in S+-", s->pm);
  cell(&o, "mp", "1", "fraction of time in S-+", s->mp);
  cell(&o, "mm", "1", "fraction of time in S--", s->mm);
  cell(&o, "stick", "1", "fraction: at least one contact stuck, none open", s->stick);
  cell(&o, "open", "1", "fraction: at least one contact open", s->open);
  for (int c = 0; c < 2; c++) {
    o.partner = names[1 + c];
    cell(&o, "sliding", "1", "fraction of time in which the contact slides",
         s->contact_positive[c] + s->contact_negative[c]);
    cell(&o, "force_min", "force", "smallest normal force", s->force_min[c]);
    cell(&o, "openings", "1", "times the contact opened", (double)s->openings[c]);
  }
}

static void put_result(sheet *t, size_t row, const sweep_result *r) {
  const summary *f = &r->found;
  sheet_integer(t, row, "steps", "steps done, of all phases", f->step);
  sheet_number(t, row, "time", "time", "time of the model", (double)f->step * f->dt);
  for (size_t k = 0; k < f->n_rotations; k++) put_rotation(t, row, f->rotation_names[k], &f->rotations[k]);
  for (size_t k = 0; k < f->n_slides; k++) put_slide(t, row, &f->slide_names[3 * k], &f->slides[k]);
  for (size_t k = 0; f->packing.n > 0 && k < summary_total_count; k++) {
    const summary_total *one = &summary_totals[k];
    sheet_number(t, row, one->name, one->unit, one->meaning, summary_total_value(&f->packing.totals, k));
  }
  if (f->has_until)
    sheet_number(t, row, "goal", "1", "1: ended with the goal of `until`; 0: at its max_time",
                 f->until_step >= 0 ? 1 : 0);
  sheet_number(t, row, "residual", "1", "residual of the energy budget, over its scale", r->residual);
  sheet_number(t, row, "work", "energy", "work done by prescribed motions", f->energy.work);
  sheet_number(t, row, "kinetic_translation", "energy", "at the end", f->energy.kinetic_translation);
  sheet_number(t, row, "kinetic_rotation", "energy", "at the end", f->energy.kinetic_rotation);
  sheet_number(t, row, "viscous", "energy", "lost in the normal dampers", f->energy.viscous);
  sheet_number(t, row, "friction", "energy", "lost by sliding", f->energy.friction);
  sheet_number(t, row, "ns_per_step", "ns", "wall time per step", f->step_nanoseconds);
}

/* --- a row per set ----------------------------------------------------------------------------------------- */

/* Over the finished replicas of a set. */
typedef struct pool {
  double n, sum;
  double squares, errors; /* of the distances from the mean; of the error bars */
} pool;

static void fill_pools(pool *p, const sweep *s, const sheet_column *c, const sheet_column *error) {
  for (size_t pass = 0; pass < 2; pass++)
    for (size_t k = 0; k < s->deck.n_points; k++) {
      pool *one = &p[s->deck.points[k].set];
      if (!isfinite(c->number[k])) continue;
      if (pass == 0) {
        one->n++;
        one->sum += c->number[k];
        one->errors += error ? error->number[k] * error->number[k] : 0;
      } else {
        double off = c->number[k] - one->sum / one->n;
        one->squares += off * off;
      }
    }
}

/* Mean, the error that the error bars give, and the one that the scatter gives. */
static void put_means(sheet *m, const sweep *s, const sheet *t, const sheet_column *c) {
  char *error_name = format_text("%s_error", c->name), *scatter_name = format_text("%s_scatter", c->name);
  pool *pools = calloc(m->n_rows + 1, sizeof *pools);
  const sheet_column *error = error_name ? sheet_find(t, error_name) : NULL;
  if (error_name && scatter_name && pools)
    fill_pools(pools, s, c, error);
  else
    m->failed = true;
  for (size_t set = 0; set < m->n_rows && !m->failed; set++) {
    const pool *p = &pools[set];
    sheet_number(m, set, c->name, c->unit, c->meaning, p->n > 0 ? p->sum / p->n : NAN);
    if (!error) continue;
    sheet_number(m, set, error_name, c->unit, "one standard error, from the error bars of the replicas",
                 p->n > 0 ? sqrt(p->errors) / p->n : NAN);
    sheet_number(m, set, scatter_name, c->unit, "one standard error, from the scatter of the replicas",
                 p->n > 1 ? sqrt(p->squares / (p->n * (p->n - 1))) : NAN);
  }
  free(pools);
  free(error_name);
  free(scatter_name);
}

static void fill_means(sheet *m, const sweep *s, const sheet *t) {
  for (size_t k = s->deck.n_points; k-- > 0;) {
    const sweep_point *p = &s->deck.points[k];
    sheet_integer(m, p->set, "set", "number of the set", (int64_t)p->set);
    for (size_t j = 0; j < s->deck.n_parameters; j++) {
      const sweep_parameter *a = &s->deck.parameters[j];
      if (a->text)
        sheet_text(m, p->set, a->name, "varied", p->texts[j]);
      else
        sheet_number(m, p->set, a->name, "", "varied; an angle in rad", p->values[j]);
    }
  }
  const sheet_column *status = sheet_find(t, "status");
  for (size_t set = 0; set < m->n_rows; set++) sheet_integer(m, set, "replicas", "finished replicas", 0);
  sheet_column *replicas = sheet_find(m, "replicas");
  for (size_t k = 0; k < t->n_rows && status && replicas; k++)
    if (status->text[k] && strcmp(status->text[k], sweep_status_names[SWEEP_DONE]) == 0)
      replicas->integer[s->deck.points[k].set]++;
  for (size_t c = 0; c < t->n_columns; c++) {
    const sheet_column *from = &t->columns[c];
    bool wanted = !from->always && from->kind == SHEET_NUMBER && !text_ends(from->name, "_error") &&
                  strcmp(from->name, "ns_per_step") != 0;
    if (wanted) put_means(m, s, t, from);
  }
}

/* --- writing ----------------------------------------------------------------------------------------------- */

static sd_status write_h5(const sweep *s, const sheet *t, const sheet *m, const char *path,
                          sd_messages *messages) {
  h5_file *file;
  sd_status status = h5_new(&file, messages);
  if (status != SD_OK) return status;
  if (!sheet_write_h5(t, file, "/points") || !sheet_write_h5(m, file, "/means")) {
    h5_close(file, NULL);
    return sd_fail(messages, SD_ERROR_IO, "no memory for the table");
  }
  h5_put_text(file, "/parameters/deck_text", s->deck.deck_text);
  char *lines = format_text("%s", "");
  for (size_t k = 0; k < s->deck.n_overrides; k++) lines = append_text(lines, "%s\n", s->deck.overrides[k]);
  h5_put_text(file, "/parameters/deck_overrides", lines);
  h5_attr_text(file, "/parameters", "deck_path", s->deck.deck_path);
  for (size_t j = 0; j < s->deck.n_parameters; j++)
    h5_attr_text(file, "/parameters", s->deck.parameters[j].name, s->deck.parameters[j].path);
  free(lines);
  return h5_save(file, -1, path, NULL, messages);
}

static sd_status write_all(const sweep *s, const sheet *t, const sheet *m, sd_messages *messages) {
  char *csv = format_text("%s/table.csv", s->folder), *h5 = format_text("%s/table.h5", s->folder),
       *means = format_text("%s/means.csv", s->folder);
  sd_status status = csv && h5 && means && !t->failed && !m->failed
                         ? SD_OK
                         : sd_fail(messages, SD_ERROR_IO, "no memory for the table");
  if (status == SD_OK) status = sheet_write_csv(t, csv, messages);
  if (status == SD_OK) status = sheet_write_csv(m, means, messages);
  if (status == SD_OK) status = write_h5(s, t, m, h5, messages);
  free(csv);
  free(h5);
  free(means);
  return status;
}

static sd_status make_tables(const sweep *s, bool mix, sd_messages *messages) {
  sheet t = {.n_rows = s->deck.n_points}, m = {.n_rows = s->deck.n_sets};
  sweep_tally others = {0};
  sd_status status = SD_OK;
  sweep_result *results = calloc(s->deck.n_points + 1, sizeof *results);
  if (!results) return sd_fail(messages, SD_ERROR_IO, "no memory for the table");
  for (size_t k = 0; k < s->deck.n_points && status == SD_OK; k++) {
    status = sweep_look(s, k, &results[k], messages);
    put_point(&t, s, k, &results[k]);
    if (!mix) sweep_tally_add(&others, &results[k]);
  }
  if (status == SD_OK) status = sweep_refuse_others(s, &others, "no table is written", messages);
  sweep_tally_free(&others);
  sheet_keep_all(&t);
  for (size_t k = 0; k < s->deck.n_points; k++) {
    if (results[k].status == SWEEP_DONE && results[k].has_found) put_result(&t, k, &results[k]);
    sweep_result_free(&results[k]);
  }
  free(results);
  if (status == SD_OK) {
    sheet_collect(&t, s->deck.n_collect, (const char *const *)s->deck.collect, messages);
    fill_means(&m, s, &t);
    status = write_all(s, &t, &m, messages);
  }
  sheet_free(&t);
  sheet_free(&m);
  return status;
}

/* Of several processes one writes after the other, so that what stays is what the last one saw. */
sd_status sweep_write_tables(const sweep *s, double patience, bool mix, sd_messages *messages) {
  const double pause = 0.05;
  folder lock = {.at = -1, .lock = -1};
  sd_status status = SD_ERROR_USER;
  for (; (status = folder_open(s->folder, true, &lock, NULL)) == SD_ERROR_USER && patience > 0;
       patience -= pause)
    nanosleep(&(struct timespec){.tv_nsec = (long)(pause * 1e9)}, NULL);
  if (status != SD_OK) status = folder_open(s->folder, true, &lock, messages); /* and tell why */
  if (status != SD_OK) return status;
  /* drafts that a kill has left */
  static const char *const tables[] = {"table.csv", "table.h5", "means.csv"};
  for (size_t k = 0; k < sizeof tables / sizeof *tables; k++) file_remove_drafts(s->folder, tables[k], NULL);
  status = make_tables(s, mix, messages);
  folder_close(&lock);
  return status;
}

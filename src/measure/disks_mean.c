/* disks_mean.c: computes time averages of each free disk, and statistics of these over all disks,
 * from the sums in a state (see slipdisk/measure.h). */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "base/gsl.h"
#include "base/math.h"
#include "base/memory.h"
#include "measure/error_bar.h"
#include "measure/observable.h"
#include "measure/statistics.h"
#include "model/model.h"
#include "model/state.h"

/* --- one disk --------------------------------------------------------------------------------- */

/* Returns the mean of `count` bins from index `first` on, multiplied by per_bin; NAN for count = 0.
 * per_bin: 1/(duration of a bin), which turns angles into rates. */
static double part_of(const double *bin, size_t first, size_t count, double per_bin) {
  return count > 0 ? sums_mean(bin + first, count) * per_bin : NAN;
}

static void fill_rotation(sd_disk_mean *d, const sd_model *model, const sd_state *state, size_t i) {
  const double *bin = state->mean_bin + i * SD_MEAN_BINS;
  double length = (double)state->mean_bin_steps * model->dt, period = mean_period(model) / length;
  size_t bins = (size_t)state->mean_bins, half = bins / 2;
  /* A ripple with a period shorter than a bin only adds noise at the edges of the bins: ignore
   * it. */
  sd_mean mean = mean_of_record(bin, bins, period >= 1 ? period : 0);
  d->omega = mean.mean / length;
  d->error = mean.error / length;
  d->significance = d->omega == 0 && d->error == 0 ? 0 : d->omega / d->error;
  d->converged = mean.converged;
  d->first = part_of(bin, 0, half, 1 / length);
  d->second = part_of(bin, bins - half, half, 1 / length);
  d->turned = state->mean_last[i] - state->mean_angle[i];
}

/* Returns the current length of the box along a coordinate, 0 if it is not periodic. */
static double period_along(const sd_model *model, const sd_state *state, int c) {
  return model->periodic[c] ? state->box_scale * (model->upper[c] - model->lower[c]) : 0;
}

static void fill_position(sd_disk_mean *d, const sd_model *model, const sd_state *state, size_t i) {
  double looks = (double)state->mean_samples, dx = state->sum_x[i] / looks,
         dy = state->sum_y[i] / looks;
  double spread = (state->sum_xx[i] + state->sum_yy[i]) / looks - (dx * dx + dy * dy);
  double x = state->x[i] + state->image_x[i] * period_along(model, state, SD_X);
  double y = state->y[i] + state->image_y[i] * period_along(model, state, SD_Y);
  d->x = state->mean_x0[i] + dx;
  d->y = state->mean_y0[i] + dy;
  d->rms = spread < 0 ? 0 : sqrt(spread);
  d->displacement = math_hypot(x - state->mean_x0[i], y - state->mean_y0[i]);
}

static void fill_rates(sd_disk_mean *d, const sd_model *model, const sd_state *state, size_t i) {
  double looks = (double)state->mean_samples, time = (double)state->measured * model->dt;
  bool running = state->phase < (int64_t)model->n_phases && model->phases[state->phase].measure;
  /* The sums include the losses of a measured phase only after its end. While the phase runs, add
   * the losses so far, which are in the state. */
  double now = running ? 1 : 0;
  d->coordination = state->sum_contacts[i] / looks;
  d->sliding = state->sum_sliding[i] / state->sum_contacts[i];
  d->force = state->sum_force[i] / state->sum_contacts[i];
  d->openings = (double)state->sum_openings[i] / time;
  d->injected = state->sum_injected[i] / looks;
  d->viscous = (state->sum_viscous[i] + now * state->loss_viscous[i]) / time;
  d->friction = (state->sum_friction[i] + now * state->loss_friction[i]) / time;
  d->opening = (state->sum_opening[i] + now * state->loss_opening[i]) / time;
  d->translation = state->sum_kinetic[i] / looks;
  d->rotation = state->sum_spin[i] / looks;
}

sd_disk_mean sd_disk_mean_of(const sd_model *model, const sd_state *state, size_t slot) {
  sd_disk_mean d = {.disk = state->id[slot]};
  for (size_t k = 0; k < disk_observables.n; k++)
    if (disk_observables.rows[k].type == OBSERVABLE_F64)
      observable_set(&disk_observables.rows[k], &d, 0, NAN);
  bool there = state->activity[slot] != SD_WAITING && state->activity[slot] != SD_REMOVED;
  if (!there || isnan(state->mean_x0[slot]) || state->measured == 0) return d;
  fill_rotation(&d, model, state, slot);
  fill_position(&d, model, state, slot);
  fill_rates(&d, model, state, slot);
  return d;
}

/* --- all disks -------------------------------------------------------------------------------- */

/* Disks whose mean angular velocity is known, with scratch arrays. */
typedef struct sample {
  size_t n;
  const sd_disk_mean **disk;
  double *x, *y; /* scratch arrays [n] */
  size_t *order; /* scratch [n] */
  size_t *slot;  /* scratch: [n_bodies] index in the state of each body */
} sample;

/* Copies one member of sd_disk_mean, given by its offset in the struct, from all disks into
 * q->x. */
static void take(const sample *q, size_t offset) {
  for (size_t k = 0; k < q->n; k++)
    q->x[k] = *(const double *)(const void *)((const char *)q->disk[k] + offset);
}

static double sum_of(const sample *q, size_t offset) {
  take(q, offset);
  double sum = 0;
  for (size_t k = 0; k < q->n; k++) sum += q->x[k];
  return sum;
}

static double mean_square(const sample *q, size_t offset) {
  take(q, offset);
  double sum = 0;
  for (size_t k = 0; k < q->n; k++) sum += q->x[k] * q->x[k];
  return sum / (double)q->n;
}

#define MEMBER(name) offsetof(sd_disk_mean, name)

/* Mean of q->x, its error as that of independent numbers, and their standard deviation; NAN for one
 * number. */
static double mean_and_error(const sample *q, double *error, double *deviation) {
  const double n = (double)q->n, mean = statistics_mean(q->x, q->n);
  *deviation = q->n > 1 ? statistics_deviation(q->x, q->n, mean, n - 1) : NAN;
  *error = *deviation / sqrt(n);
  return mean;
}

static void fill_omega(sd_disk_totals *t, const sample *q) {
  double n = (double)q->n;
  take(q, MEMBER(omega));
  double deviation;
  t->omega_mean = mean_and_error(q, &t->omega_mean_error, &deviation);
  t->skewness = q->n > 2 ? statistics_moment(q->x, q->n, t->omega_mean, deviation, 3) : NAN;

  /* The error of a root mean square is the error of the mean square divided by twice the root. */
  for (size_t k = 0; k < q->n; k++) q->x[k] *= q->x[k];
  double error;
  t->omega_rms = sqrt(mean_and_error(q, &error, &deviation));
  t->omega_rms_error = t->omega_rms > 0 ? error / (2 * t->omega_rms) : NAN;

  /* Error of the median: for any distribution, the number of values below the median has the
   * standard deviation sqrt(n)/2. The error is therefore half the distance between the quantiles
   * 1/2 - 1/(2 sqrt(n)) and 1/2 + 1/(2 sqrt(n)). */
  for (size_t k = 0; k < q->n; k++) q->x[k] = sqrt(q->x[k]);
  gsl_sort(q->x, 1, q->n);
  double off = 0.5 / sqrt(n);
  t->omega_median = statistics_median(q->x, q->n);
  t->omega_median_error = q->n > 1 ? (statistics_quantile(q->x, q->n, 0.5 + off) -
                                      statistics_quantile(q->x, q->n, 0.5 - off)) /
                                         2
                                   : NAN;
}

static void fill_significance(sd_disk_totals *t, const sample *q) {
  double known = 0, squares = 0, significant = 0, reliable = 0;
  for (size_t k = 0; k < q->n; k++) {
    const sd_disk_mean *d = q->disk[k];
    reliable += d->converged;
    /* the error is NAN if the record is too short after the transient */
    if (isnan(d->error)) continue;
    known++;
    squares += d->error * d->error;
    significant += fabs(d->significance) > 3;
  }
  t->reliable = reliable / (double)q->n;
  if (known > 0) t->omega_noise = sqrt(squares / known);
  if (known > 0) t->significant = significant / known;

  double *second = q->y;
  take(q, MEMBER(second));
  for (size_t k = 0; k < q->n; k++) second[k] = q->x[k];
  take(q, MEMBER(first));
  if (q->n < 3) return;
  t->persistence = statistics_correlation(q->x, second, q->n);
  statistics_ranks(q->x, q->n, q->order);
  statistics_ranks(second, q->n, q->order);
  t->persistence_rank = statistics_correlation(q->x, second, q->n);
}

/* Computes the mean of omega_i omega_j over pairs i, j of free disks now in contact, divided by the
 * mean square of omega. slot: scratch array with one number per body. */
static void fill_neighbours(sd_disk_totals *t, const sd_state *state, const sd_disk_mean *means,
                            size_t *slot) {
  double sum = 0, pairs = 0;
  for (size_t k = 0; k < state->n_bodies; k++) slot[state->id[k]] = k;
  for (size_t c = 0; c < state->n_contacts; c++) {
    size_t a = slot[state->contact_a[c]], b = slot[state->contact_b[c]];
    double both = a < state->n_means && b < state->n_means ? means[a].omega * means[b].omega : NAN;
    if (isnan(both)) continue;
    sum += both;
    pairs++;
  }
  if (pairs > 0 && t->omega_rms > 0) t->neighbours = sum / pairs / (t->omega_rms * t->omega_rms);
}

static void fill_contacts(sd_disk_totals *t, const sd_state *state, const sd_disk_mean *means,
                          const sample *q) {
  double n = (double)q->n;
  double contacts = 0, sliding = 0, force = 0, diameter = 0;
  for (size_t k = 0; k < q->n; k++) {
    const sd_disk_mean *d = q->disk[k];
    diameter += 2 * state->radius[d - means] / n;
    contacts += d->coordination;
    /* d->sliding and d->force are NAN for a disk that never had a contact. */
    sliding += d->coordination > 0 ? d->sliding * d->coordination : 0;
    force += d->coordination > 0 ? d->force * d->coordination : 0;
  }
  t->coordination = contacts / n;
  t->sliding = sliding / contacts;
  t->force = force / contacts;
  t->openings = sum_of(q, MEMBER(openings)) / contacts;
  t->position_rms = sqrt(mean_square(q, MEMBER(rms))) / diameter;
  t->displacement_rms = sqrt(mean_square(q, MEMBER(displacement))) / diameter;
}

static void fill_powers(sd_disk_totals *t, const sample *q) {
  double n = (double)q->n;
  t->power_injected = sum_of(q, MEMBER(injected));
  t->power_viscous = sum_of(q, MEMBER(viscous));
  t->power_friction = sum_of(q, MEMBER(friction));
  t->power_opening = sum_of(q, MEMBER(opening));
  t->mean_translation = sum_of(q, MEMBER(translation)) / n;
  t->mean_rotation = sum_of(q, MEMBER(rotation)) / n;
}

sd_disk_totals sd_disk_totals_of(const sd_model *model, const sd_state *state,
                                 const sd_disk_mean *means) {
  (void)model;
  sd_disk_totals t;
  for (size_t k = 0; k < sizeof t / sizeof(double); k++) ((double *)&t)[k] = NAN;
  size_t most = state->n_means;
  sample q = {.n = 0};
  const memory_column rows[] = {{&q.disk, most, sizeof *q.disk},
                                {&q.x, most, sizeof *q.x},
                                {&q.y, most, sizeof *q.y},
                                {&q.order, most, sizeof *q.order},
                                {&q.slot, state->n_bodies, sizeof *q.slot}};
  if (!memory_rows(sizeof rows / sizeof *rows, rows)) {
    shortage_note();
    return t;
  }
  for (size_t k = 0; k < most; k++)
    if (!isnan(means[k].omega)) q.disk[q.n++] = &means[k];
  t.disks = (double)q.n;
  if (q.n > 0) {
    fill_omega(&t, &q);
    fill_significance(&t, &q);
    fill_neighbours(&t, state, means, q.slot);
    fill_contacts(&t, state, means, &q);
    fill_powers(&t, &q);
  }
  free(q.disk);
  free(q.x);
  free(q.y);
  free(q.order);
  free(q.slot);
  return t;
}

/* --- tables ----------------------------------------------------------------------------------- */

#define MEAN(name, field, unit, meaning)                                                           \
  { name, unit, meaning, OBSERVABLE_F64, 1, offsetof(sd_disk_mean, field), NULL, NULL, NULL, NULL }

static const observable means[] = {
    OBSERVABLE_FIELD("id", "1", "number of the disk", U32, sd_disk_mean, disk, NULL, NULL),
    MEAN("omega", omega, "rad/time", "mean angular velocity Omega"),
    MEAN("error", error, "rad/time", "one standard error of omega, correlations included"),
    MEAN("significance", significance, "1", "omega over error"),
    MEAN("omega_first", first, "rad/time", "mean angular velocity in the first half of the record"),
    MEAN("omega_second", second, "rad/time",
         "mean angular velocity in the second half of the record"),
    MEAN("turned", turned, "rad", "angle turned over the measured time"),
    MEAN("x", x, "length", "mean x, images of a periodic box included"),
    MEAN("y", y, "length", "mean y, images of a periodic box included"),
    MEAN("rms", rms, "length", "root mean square distance from the mean position"),
    MEAN("displacement", displacement, "length", "distance from where it was when measuring began"),
    MEAN("coordination", coordination, "1", "mean number of closed contacts"),
    MEAN("sliding", sliding, "1", "fraction of the closed contacts that slide"),
    MEAN("force", force, "force", "mean normal force per closed contact"),
    MEAN("openings", openings, "1/time", "contacts that opened per time"),
    MEAN("injected", injected, "power", "mean power of prescribed bodies on the disk"),
    MEAN("viscous", viscous, "power", "lost to viscosity in the disk's contacts, its share"),
    MEAN("friction", friction, "power", "lost to sliding, its share"),
    MEAN("opening", opening, "power", "left in contacts that opened, its share"),
    MEAN("translation", translation, "energy", "mean kinetic energy of translation"),
    MEAN("rotation", rotation, "energy", "mean kinetic energy of rotation"),
    OBSERVABLE_FIELD("converged", "1", "1: the error is reliable", FLAG, sd_disk_mean, converged,
                     NULL, NULL),
};
const observable_list disk_observables = OBSERVABLES(
    "disks", "of each free disk with `measure = { disks = true; }`, in /summary/disks", means);

#define TOTAL(field, unit, meaning)                                                                \
  {                                                                                                \
#field, unit, meaning, OBSERVABLE_F64, 1, offsetof(sd_disk_totals, field), NULL, #field, NULL, \
        NULL                                                                                       \
  }

static const observable totals[] = {
    TOTAL(disks, "1", "disks that were in play all the time"),
    TOTAL(omega_mean, "rad/time", "mean of Omega over disks"),
    TOTAL(omega_mean_error, "rad/time", "one standard error, from the scatter of the disks"),
    TOTAL(omega_rms, "rad/time", "root mean square of Omega over disks"),
    TOTAL(omega_rms_error, "rad/time", "one standard error, from the scatter of the disks"),
    TOTAL(omega_median, "rad/time", "median of |Omega| over disks"),
    TOTAL(omega_median_error, "rad/time", "one standard error, from the scatter of the disks"),
    TOTAL(omega_noise, "rad/time", "root mean square of the disks' errors of Omega"),
    TOTAL(significant, "1", "fraction of the disks with |Omega| > 3 errors"),
    TOTAL(reliable, "1", "fraction of the disks whose error is reliable"),
    TOTAL(persistence, "1", "Pearson's correlation of Omega in the first and the second half"),
    TOTAL(persistence_rank, "1",
          "Spearman's correlation of Omega in the first and the second half"),
    TOTAL(skewness, "1", "skewness of the distribution of Omega"),
    TOTAL(neighbours, "1",
          "mean Omega_i Omega_j of disks in contact at the end, over the mean Omega^2"),
    TOTAL(coordination, "1", "mean closed contacts per disk"),
    TOTAL(sliding, "1", "fraction of the closed contacts that slide"),
    TOTAL(force, "force", "mean normal force per closed contact"),
    TOTAL(openings, "1/time", "openings per closed contact and time"),
    TOTAL(position_rms, "1", "rms distance from the mean positions, over the mean diameter"),
    TOTAL(displacement_rms, "1", "rms displacement since measuring began, over the mean diameter"),
    TOTAL(power_injected, "power", "mean power of prescribed bodies on all disks"),
    TOTAL(power_viscous, "power", "lost to viscosity by all disks"),
    TOTAL(power_friction, "power", "lost to sliding by all disks"),
    TOTAL(power_opening, "power", "left in contacts that opened, of all disks"),
    TOTAL(mean_translation, "energy", "mean kinetic energy of translation per disk"),
    TOTAL(mean_rotation, "energy", "mean kinetic energy of rotation per disk"),
};
const observable_list total_observables =
    OBSERVABLES("totals", "over all these disks: attributes of /summary/disks", totals);

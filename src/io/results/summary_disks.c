/* summary_disks.c: see summary_disks.h. */
#include "io/results/summary_disks.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "base/shortage.h"
#include "io/store/file.h"
#include "io/store/members.h"

static const char group[] = "/summary/disks", fastest_group[] = "/summary/fastest";

#define MEAN(name, member, unit, meaning)                                                                    \
  { name, offsetof(sd_disk_mean, member), unit, meaning }

const summary_total summary_means[] = {
    MEAN("omega", omega, "rad/time", "mean angular velocity Omega"),
    MEAN("error", error, "rad/time", "one standard error of omega (blocking)"),
    MEAN("significance", significance, "1", "omega over error"),
    MEAN("omega_first", first, "rad/time", "mean angular velocity in the first half of the record"),
    MEAN("omega_second", second, "rad/time", "mean angular velocity in the second half of the record"),
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
};
const size_t summary_mean_count = sizeof summary_means / sizeof *summary_means;

#define TOTAL(name, unit, meaning)                                                                           \
  { #name, offsetof(sd_disk_totals, name), unit, meaning }

const summary_total summary_totals[] = {
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
    TOTAL(persistence_rank, "1", "Spearman's correlation of Omega in the first and the second half"),
    TOTAL(skewness, "1", "skewness of the distribution of Omega"),
    TOTAL(neighbours, "1", "mean Omega_i Omega_j of disks in contact at the end, over the mean Omega^2"),
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
const size_t summary_total_count = sizeof summary_totals / sizeof *summary_totals;

static sd_status allocate(summary_disks *s, sd_messages *messages) {
  s->disks = calloc(s->n + 1, sizeof *s->disks);
  return s->disks ? SD_OK : sd_fail(messages, SD_ERROR_IO, "no memory for the means of disks");
}

static double speed_of(const sd_disk_mean *d) { return isnan(d->omega) ? -1 : fabs(d->omega); }

static void find_fastest(summary_disks *s) {
  sd_disk_mean *list = s->fastest;
  size_t n = 0;
  for (size_t k = 0; k < s->n; k++) {
    const sd_disk_mean *d = &s->disks[k];
    if (!(speed_of(d) > 0) || (n == SUMMARY_FASTEST && speed_of(d) <= speed_of(&list[n - 1]))) continue;
    size_t at = n < SUMMARY_FASTEST ? n++ : n - 1;
    for (; at > 0 && speed_of(&list[at - 1]) < speed_of(d); at--) list[at] = list[at - 1];
    list[at] = *d;
  }
  s->n_fastest = n;
}

/* Of the deck, not of the slots. */
static int by_number(const void *one, const void *two) {
  const sd_disk_mean *a = one, *b = two;
  return a->disk < b->disk ? -1 : a->disk > b->disk;
}

sd_status summary_disks_collect(summary_disks *s, const sd_model *model, const sd_state *state,
                                sd_messages *messages) {
  *s = (summary_disks){.n = state->n_means};
  if (s->n == 0) return SD_OK;
  if (allocate(s, messages) != SD_OK) return SD_ERROR_IO;
  for (size_t k = 0; k < s->n; k++) s->disks[k] = sd_disk_mean_of(model, state, k);
  s->totals = sd_disk_totals_of(model, state, s->disks);
  if (shortage_seen()) return sd_fail(messages, SD_ERROR_IO, "no memory for the means of disks");
  qsort(s->disks, s->n, sizeof *s->disks, by_number);
  find_fastest(s);
  s->looks = state->mean_looks;
  s->bins = state->mean_bins;
  s->measured = (double)state->measured * model->dt;
  return SD_OK;
}

void summary_disks_free(summary_disks *s) {
  free(s->disks);
  *s = (summary_disks){0};
}

/* The datasets, id first; returns how many. */
enum { MOST_MEMBERS = 32 };
static size_t list_members(member *list) {
  static const member id = {"id", SD_U32, offsetof(sd_disk_mean, disk), 1, "1", "number of the disk"};
  size_t n = 0;
  list[n++] = id;
  for (size_t k = 0; k < summary_mean_count; k++) {
    const summary_total *m = &summary_means[k];
    list[n++] = (member){m->name, SD_F64, m->offset, 1, m->unit, m->meaning};
  }
  return n;
}
_Static_assert(sizeof summary_means / sizeof *summary_means < MOST_MEMBERS, "room for the id");

static void write_rows(h5_file *file, const char *path, sd_disk_mean *disks, size_t n_disks) {
  member list[MOST_MEMBERS];
  size_t n = list_members(list);
  members_write(file, path, list, n, disks, sizeof *disks, n_disks);
  int32_t *converged = calloc(n_disks + 1, sizeof *converged);
  char *name = format_text("%s/converged", path);
  for (size_t k = 0; converged && k < n_disks; k++) converged[k] = disks[k].converged;
  if (h5_have(file, converged && name, path)) {
    h5_put(file, name, SD_I32, 1, &n_disks, converged, true);
    h5_attr_text(file, name, "unit", "1");
    h5_attr_text(file, name, "description", "1: the error is reliable");
  }
  free(converged);
  free(name);
}

static sd_status read_rows(const h5_file *file, const char *path, sd_disk_mean *disks, size_t n_disks,
                           sd_messages *messages) {
  member list[MOST_MEMBERS];
  size_t n = list_members(list);
  sd_status status = members_read(file, path, list, n, disks, sizeof *disks, n_disks, messages);
  int32_t *converged = calloc(n_disks + 1, sizeof *converged);
  char *name = format_text("%s/converged", path);
  if (status == SD_OK && !(converged && name))
    status = sd_fail(messages, SD_ERROR_IO, "no memory for the means of disks");
  if (status == SD_OK) status = h5_get(file, name, SD_I32, n_disks, converged, messages);
  for (size_t k = 0; converged && status == SD_OK && k < n_disks; k++) disks[k].converged = converged[k] != 0;
  free(converged);
  free(name);
  return status;
}

void summary_disks_write(const summary_disks *s, h5_file *file) {
  if (s->n == 0) return;
  write_rows(file, group, s->disks, s->n);
  write_rows(file, fastest_group, (sd_disk_mean *)s->fastest, s->n_fastest);
  h5_attr_i64(file, group, "count", (int64_t)s->n);
  h5_attr_i64(file, group, "looks", s->looks);
  h5_attr_i64(file, group, "bins", s->bins);
  h5_attr_f64(file, group, "measured", s->measured);
  for (size_t k = 0; k < summary_total_count; k++)
    h5_attr_f64(file, group, summary_totals[k].name, summary_total_value(&s->totals, k));
}

sd_status summary_disks_read(summary_disks *s, const h5_file *file, sd_messages *messages) {
  *s = (summary_disks){0};
  if (!h5_exists(file, group)) return SD_OK;
  int64_t count = h5_get_attr_i64(file, group, "count", 0);
  if (count < 0 || count > UINT32_MAX) return sd_fail(messages, SD_ERROR_IO, "the summary is damaged");
  s->n = (size_t)count;
  s->looks = h5_get_attr_i64(file, group, "looks", 0);
  s->bins = h5_get_attr_i64(file, group, "bins", 0);
  s->measured = h5_get_attr_f64(file, group, "measured", NAN);
  for (size_t k = 0; k < summary_total_count; k++) {
    double value = h5_get_attr_f64(file, group, summary_totals[k].name, NAN);
    memcpy((char *)&s->totals + summary_totals[k].offset, &value, sizeof value);
  }
  /* older files have no such list */
  if (!h5_exists(file, fastest_group)) {
    sd_status status = summary_disks_read_all(s, file, messages);
    if (status == SD_OK) find_fastest(s);
    return status;
  }
  int rank;
  size_t dims[H5_MAX_RANK] = {0};
  sd_status status = h5_shape(file, "/summary/fastest/id", &rank, dims, messages);
  if (status == SD_OK && dims[0] > SUMMARY_FASTEST)
    status = sd_fail(messages, SD_ERROR_IO, "the summary is damaged");
  s->n_fastest = status == SD_OK ? dims[0] : 0;
  return status == SD_OK ? read_rows(file, fastest_group, s->fastest, s->n_fastest, messages) : status;
}

sd_status summary_disks_read_all(summary_disks *s, const h5_file *file, sd_messages *messages) {
  if (s->n == 0 || s->disks) return SD_OK;
  sd_status status = h5_check(file, "/summary/disks/id", s->n, messages);
  if (status == SD_OK) status = allocate(s, messages);
  return status == SD_OK ? read_rows(file, group, s->disks, s->n, messages) : status;
}

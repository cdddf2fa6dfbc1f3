/* summary_disks.c: see summary_disks.h. */
#include "io/results/summary_disks.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#include "base/memory.h"
#include "base/team.h"
#include "io/store/members.h"

static const char group[] = "/summary/disks", fastest_group[] = "/summary/fastest";

static sd_status no_memory(sd_messages *messages) {
  return sd_fail(messages, SD_ERROR_IO, "no memory for the means of disks");
}

static double speed_of(const sd_disk_mean *d) { return isnan(d->omega) ? -1 : fabs(d->omega); }

static void find_fastest(summary_disks *s) {
  sd_disk_mean *list = s->fastest;
  size_t n = 0;
  for (size_t k = 0; k < s->n; k++) {
    const sd_disk_mean *d = &s->disks[k];
    if (!(speed_of(d) > 0) || (n == SUMMARY_FASTEST && speed_of(d) <= speed_of(&list[n - 1])))
      continue;
    size_t at = n < SUMMARY_FASTEST ? n++ : n - 1;
    for (; at > 0 && speed_of(&list[at - 1]) < speed_of(d); at--) list[at] = list[at - 1];
    list[at] = *d;
  }
  s->n_fastest = n;
}

/* Rows go from the order of slots to that of the deck. place has a zero for each disk of the
 * deck. */
static void sort_by_number(const sd_disk_mean *means, size_t n, size_t n_disks, uint32_t *place,
                           sd_disk_mean *sorted) {
  for (size_t k = 0; k < n; k++) place[means[k].disk] = 1; /* those that are there */
  uint32_t before = 0;
  for (size_t i = 0; i < n_disks; i++) {
    const uint32_t there = place[i];
    place[i] = before;
    before += there;
  }
  for (size_t k = 0; k < n; k++) sorted[place[means[k].disk]] = means[k];
}

typedef struct means_task {
  sd_disk_mean *means;
  size_t n;
  const sd_model *model;
  const sd_state *state;
} means_task;

/* Each disk by itself: threads change nothing. */
static void means_together(const team *t, void *with) {
  const means_task *f = with;
  size_t begin, end;
  team_share(t, f->n, &begin, &end);
  for (size_t k = begin; k < end; k++) f->means[k] = sd_disk_mean_of(f->model, f->state, k);
}

void summary_disks_means(sd_disk_mean *means, size_t n, const sd_model *model,
                         const sd_state *state, int threads) {
  enum { FEW = 1024 }; /* disks, not worth a thread */
  pool *c = threads > 1 && n > FEW ? pool_new(threads) : NULL;
  pool_run(c, means_together, &(means_task){means, n, model, state});
  pool_free(c);
}

void summary_disks_announce(summary_disks *s, const sd_model *model, const sd_state *state) {
  *s = (summary_disks){.n = model->measure_disks ? model->n_free : 0,
                       .looks = state->mean_samples,
                       .bins = state->mean_bins,
                       .measured = (double)state->measured * model->dt};
}

sd_status summary_disks_take(summary_disks *s, const sd_model *model, const sd_state *state,
                             const sd_disk_mean *means, sd_messages *messages) {
  uint32_t *place;
  const memory_column rows[] = {{&s->disks, s->n, sizeof *s->disks},
                                {&place, model->n_disks, sizeof *place}};
  if (!memory_rows(sizeof rows / sizeof *rows, rows)) return no_memory(messages);
  s->totals = sd_disk_totals_of(model, state, means);
  sort_by_number(means, s->n, model->n_disks, place, s->disks);
  free(place);
  if (shortage_seen()) return no_memory(messages);
  find_fastest(s);
  return SD_OK;
}

sd_status summary_disks_collect(summary_disks *s, const sd_model *model, const sd_state *state,
                                int threads, sd_messages *messages) {
  summary_disks_announce(s, model, state);
  if (s->n == 0) return SD_OK;
  sd_disk_mean *means;
  if (!memory_row(&means, s->n, sizeof *means)) return no_memory(messages);
  summary_disks_means(means, s->n, model, state, threads);
  const sd_status status = summary_disks_take(s, model, state, means, messages);
  free(means);
  return status;
}

void summary_disks_free(summary_disks *s) {
  free(s->disks);
  *s = (summary_disks){0};
}

void summary_disks_write(const summary_disks *s, h5_file *file) {
  if (s->n == 0) return;
  h5_group(file, group);
  h5_attr_i64(file, group, "count", (int64_t)s->n);
  h5_attr_i64(file, group, "looks", s->looks);
  h5_attr_i64(file, group, "bins", s->bins);
  h5_attr_f64(file, group, "measured", s->measured);
  if (!s->disks) return;
  members_write(file, group, &disk_observables, s->disks, sizeof *s->disks, s->n);
  members_write(file, fastest_group, &disk_observables, s->fastest, sizeof *s->fastest,
                s->n_fastest);
  members_write_attrs(file, group, &total_observables, &s->totals);
}

sd_status summary_disks_read(summary_disks *s, const h5_file *file, sd_messages *messages) {
  *s = (summary_disks){0};
  if (!h5_exists(file, group)) return SD_OK;
  int64_t count = h5_get_attr_i64(file, group, "count", 0);
  if (count < 0 || count > UINT32_MAX)
    return sd_fail(messages, SD_ERROR_IO, "the summary is damaged");
  s->n = (size_t)count;
  s->looks = h5_get_attr_i64(file, group, "looks", 0);
  s->bins = h5_get_attr_i64(file, group, "bins", 0);
  s->measured = h5_get_attr_f64(file, group, "measured", NAN);
  s->later = !h5_exists(file, "/summary/disks/id");
  if (s->later) return SD_OK;
  members_read_attrs(file, group, &total_observables, &s->totals);
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
  if (status != SD_OK) return status;
  return members_read(file, fastest_group, &disk_observables, s->fastest, sizeof *s->fastest,
                      s->n_fastest, messages);
}

sd_status summary_disks_read_all(summary_disks *s, const h5_file *file, sd_messages *messages) {
  if (s->n == 0 || s->disks || s->later) return SD_OK;
  sd_status status = h5_check(file, "/summary/disks/id", s->n, messages);
  if (status != SD_OK) return status;
  if (!memory_row(&s->disks, s->n, sizeof *s->disks)) return no_memory(messages);
  return members_read(file, group, &disk_observables, s->disks, sizeof *s->disks, s->n, messages);
}

/* ranks_phase.c: how the parts of a run begin and end phases, and let rain fall; see ranks_private.h. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/comm_data.h"
#include "base/memory.h"
#include "pack/rain.h"
#include "physics/contact/energy.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/order.h"
#include "physics/step/access.h"
#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/step/outside.h"
#include "physics/step/step.h"
#include "physics/system/bodies.h"
#include "physics/system/halo.h"
#include "run/phase.h"
#include "run/ranks_move.h"
#include "run/ranks_order.h"
#include "run/ranks_private.h"
#include "run/ranks_share.h"

/* --- sums ------------------------------------------------------------------------------------------------------ */

sd_energy ranks_add_energies(ranks *r) {
  energy_sums sum;
  halo_refresh(&r->part, NULL);
  energy_add_up(&r->part, &sum);
  comm_total_exact(sum.of, ENERGY_SUMS);
  return energy_of_sums(r->part.state, &sum);
}

settle_measure ranks_rest_of(ranks *r, sd_state *whole) {
  const settle_measure now = ranks_add_rest(&r->part);
  move_common(&r->part, whole);
  return now;
}

/* --- rain ------------------------------------------------------------------------------------------------------ */

/* Of disks that wait on any rank, on all: bits of each are there once. */
static void share_radii(const engine *e, const sd_rain *r, size_t n, double *radius, int64_t *bits) {
  rain_radii(e, r, radius);
  memcpy(bits, radius, n * sizeof *bits);
  comm_add(bits, n);
  memcpy(radius, bits, n * sizeof *bits);
}

static sd_status set_out(engine *e, const sd_rain *r, sd_messages *messages) {
  const size_t n = rain_count(e, r);
  const double top = comm_largest(rain_top(e, r));
  rain_drop *drops;
  double *radius;
  int64_t *bits;
  const memory_column arrays[] = {
      {&drops, n, sizeof *drops}, {&radius, n, sizeof *radius}, {&bits, n, sizeof *bits}};
  sd_status status = memory_rows(sizeof arrays / sizeof *arrays, arrays) ? SD_OK : SD_ERROR_IO;
  if (status == SD_OK) share_radii(e, r, n, radius, bits);
  if (status != SD_OK) comm_fail("no memory for a batch of rain");
  if (status == SD_OK && comm_rank() == 0) status = rain_plan(e, r, top, radius, drops, messages);
  const bool failed = comm_or(status != SD_OK);
  if (!failed) comm_share(drops, n * sizeof *drops);
  if (!failed) rain_set_out(e, r, drops);
  free(bits);
  free(radius);
  free(drops);
  return status;
}

/* Collective: disks of this part that are due set out; its lists are to be made anew. */
static sd_status set_out_all(engine *e, sd_messages *messages) {
  const sd_model *m = e->model;
  sd_status status = SD_OK;
  engine_pose_walls(e);
  for (size_t k = 0; k < m->n_rains; k++) {
    if (rain_due(e, &m->rains[k])) status = set_out(e, &m->rains[k], messages);
    if (comm_or(status != SD_OK)) return status;
  }
  bodies_fill_constants(e);
  for (size_t k = 0; k < m->n_rains; k++)
    if (rain_due(e, &m->rains[k])) rain_accelerate(e, &m->rains[k]);
  return SD_OK;
}

/* New lists of disks that have set out or are gone; the energy that they bring or take along is booked. */
static sd_status renew(ranks *r, sd_status status, const sd_energy *before) {
  if (ranks_all_well(status)) status = ranks_store_part(r);
  if (ranks_all_well(status)) status = ranks_take_part(r, &r->part);
  if (!ranks_all_well(status)) return status;
  const sd_energy after = ranks_add_energies(r);
  r->part.state->energy_start += energy_total(&after) - energy_total(before);
  return SD_OK;
}

sd_status ranks_release_rain(ranks *r) {
  const sd_energy before = ranks_add_energies(r);
  return renew(r, set_out_all(&r->part, r->messages), &before);
}

/* --- bounds ---------------------------------------------------------------------------------------------------- */

static int by_order(const void *one, const void *two) {
  const outside_left *p = one, *q = two;
  return p->order < q->order ? -1 : p->order > q->order;
}

/* Those of all ranks on every rank, in their order; to be freed. */
static outside_left *gather_left(const outside_left *mine, size_t n, size_t *all) {
  int *counts = memory_new((size_t)comm_size(), sizeof *counts);
  comm_gather_counts((int)n, counts);
  *all = 0;
  for (int q = 0; q < comm_size(); q++) *all += (size_t)counts[q];
  outside_left *list;
  if (!memory_rows(1, (memory_column[]){{&list, *all, sizeof *list}})) comm_fail("no memory");
  comm_gather(mine, list, counts, sizeof *list);
  free(counts);
  if (list && *all > 1) qsort(list, *all, sizeof *list, by_order);
  return list;
}

/* Contacts of disks that are taken out, here and as ghosts. */
static sd_status end_contacts(engine *e, const outside_left *list, size_t n) {
  const size_t slots = e->state->n_free + e->state->n_ghosts;
  bool *gone;
  if (!memory_rows(1, (memory_column[]){{&gone, slots, sizeof *gone}})) return SD_ERROR_IO;
  for (size_t k = 0; k < n; k++) {
    const size_t slot = engine_slot(e, list[k].disk);
    if (slot < slots && e->state->id[slot] == list[k].disk) gone[slot] = true;
  }
  const sd_status status = contacts_end(e, gone);
  free(gone);
  return status;
}

static sd_status take_out(ranks *r, const outside_left *mine, size_t n, const outside_left *all,
                          size_t n_all) {
  const sd_energy before = ranks_add_energies(r);
  sd_status status = end_contacts(&r->part, all, n_all);
  if (status != SD_OK) sd_fail(r->messages, status, "out of memory for contacts of disks that are taken out");
  outside_mark(&r->part, mine, n);
  return renew(r, status, &before);
}

sd_status ranks_look_outside(ranks *r, sd_messages *messages) {
  engine *e = &r->part;
  outside_left *mine;
  size_t n, n_all = 0;
  sd_status status = outside_find(e, &mine, &n);
  if (status != SD_OK) comm_fail("no memory for disks that have left the bounds");
  outside_left *all = comm_or(n > 0) ? gather_left(mine, n, &n_all) : NULL;
  if (n_all > 0) status = outside_tell(e, all, n_all, messages);
  if (n_all > 0 && e->model->bounds.outside == SD_OUTSIDE_REMOVE)
    status = take_out(r, mine, n, all, n_all);
  else
    outside_mark(e, mine, n);
  free(all);
  free(mine);
  return status;
}

/* --- phases ---------------------------------------------------------------------------------------------------- */

/* Of equal ones, as they are found from both sides of a border, that of the first rank. */
static void share_deepest(ranks *r, const first_overlap *mine) {
  const size_t n = (size_t)comm_size();
  int *counts = memory_new(n, sizeof *counts);
  first_overlap *all = memory_new(n, sizeof *all);
  for (size_t k = 0; k < n; k++) counts[k] = 1;
  comm_gather(mine, all, counts, sizeof *mine);
  for (size_t k = 0; k < n; k++)
    if (all[k].relative > r->deepest.relative) r->deepest = all[k];
  free(counts);
  free(all);
}

sd_status ranks_start_part(ranks *r, bool measure, double *kept) {
  engine *e = &r->part;
  size_t mine = 0;
  /* parts of a file were looked at one by one */
  if (r->model->tiles.away && r->model->tiles.of_file) {
    first_overlap deepest;
    const sd_status apart = contacts_check_start(e, &deepest, r->messages);
    if (!ranks_all_well(apart)) return apart;
    share_deepest(r, &deepest);
  }
  sd_status status = rain_next(e, -1) == 0 ? ranks_release_rain(r) : SD_OK;
  if (ranks_all_well(status)) status = engine_start_part(e, &mine, r->messages);
  if (!ranks_all_well(status)) return status;
  step_agree(e, false);
  *kept = comm_total((double)mine);
  const sd_energy now = ranks_add_energies(r);
  e->state->energy_start = energy_total(&now);
  motion_begin_run(e);
  if (measure) phase_measure_begin(e);
  return engine_status(e);
}

/* On every rank: its disks in the order that a phase begins with. */
static sd_status order_again(ranks *r) {
  engine *e = &r->part;
  sd_status status = ranks_store_part(r);
  if (!ranks_all_well(status) || r->model->n_free < ORDER_LEAST) return status;
  status = ranks_order(r->model, e->state, e->halo->order);
  engine_find_slots(e);
  return status == SD_OK ? ranks_take_part(r, e) : status;
}

sd_status ranks_end_part(ranks *r, int64_t phase_step) {
  engine *e = &r->part;
  assert(ranks_are_spread(r));
  const bool settles = r->model->phases[e->state->phase].settle.asked;
  const settle_measure now = settles ? ranks_rest_of(r, NULL) : (settle_measure){0};
  e->state->phase_step = phase_step;
  phase_end(e, settles ? &now : NULL);
  if (e->state->phase == (int64_t)r->model->n_phases) return SD_OK;
  sd_status status = order_again(r);
  if (ranks_all_well(status) && motion_begin_phase(e) != SD_OK)
    status = sd_fail(r->messages, SD_ERROR_IO, "out of memory for the motions");
  if (ranks_all_well(status) && phase_measures(e)) phase_measure_begin(e);
  engine_end(e, status);
  return status;
}

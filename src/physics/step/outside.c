/* outside.c: disks that leave the bounds of the run; implements outside.h. */
#include "physics/system/bodies.h"
#include "physics/step/outside.h"

#include <assert.h>
#include <stdlib.h>

#include "base/memory.h"
#include "model/model.h"
#include "physics/contact/energy.h"
#include "physics/step/access.h"
#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/system/halo.h"
#include "physics/system/list.h"

/* Disk that has left the bounds. order: its global slot, which it would have in a run on one rank;
 * disk: number of the body; slot: its slot on the rank that owns it; x, y: its position. */
typedef struct outside_left {
  uint32_t order, disk, slot;
  double x, y;
} outside_left;

/* Returns true if free disk i is outside the bounds. For a disk of a clump the position of the
 * clump's centre counts. Bounds are scaled with the box; infinite ones stay infinite. */
static bool beyond(const engine *e, size_t i) {
  const sd_bounds *b = &e->model->bounds;
  const sd_state *s = e->state;
  const bool member = engine_in_clump(e, i);
  const int32_t k = member ? e->work.clumps.of[i] : 0;
  const double at[2] = {member ? s->clump_x[k] : s->x[i], member ? s->clump_y[k] : s->y[i]};
  double scale = e->state->box_scale;
  for (int c = 0; c < 2; c++) {
    double corner = box_corner(e->model, c);
    if (at[c] < corner + scale * (b->lower[c] - corner) ||
        at[c] > corner + scale * (b->upper[c] - corner))
      return true;
  }
  return false;
}

static void take_out(engine *e, size_t i) {
  sd_state *s = e->state;
  assert(i < s->n_free && s->activity[i] == SD_OUTSIDE);
  s->activity[i] = SD_REMOVED;
  for (int c = 0; c < SD_COORDINATES; c++) {
    const columns *q = &e->work.columns[c];
    q->v[i] = q->q2[i] = q->q3[i] = q->q4[i] = q->q5[i] = 0.0;
  }
  for (int c = 0; engine_in_clump(e, i) && c < SD_COORDINATES; c++) {
    const columns *q = engine_clump_columns(e, c);
    const int32_t k = e->work.clumps.of[i];
    q->v[k] = q->q2[k] = q->q3[k] = q->q4[k] = q->q5[k] = 0.0;
  }
}

/* Sets disks that have come back into the bounds to SD_IN_PLAY. Lists the disks that have left
 * since the last check in *list, which the caller frees. Returns SD_ERROR_IO if memory runs out. */
static sd_status find_left(engine *e, outside_left **list, size_t *n) {
  sd_state *s = e->state;
  size_t capacity = 0;
  *list = NULL;
  *n = 0;
  for (size_t i = 0; i < s->n_free; i++) {
    if (!body_in_play(s, i) || s->activity[i] == SD_HELD) continue;
    const bool out = beyond(e, i);
    if (!out) s->activity[i] = SD_IN_PLAY;
    if (!out || s->activity[i] == SD_OUTSIDE) continue;
    if (!list_room(list, *n, &capacity, sizeof **list)) {
      free(*list);
      *list = NULL;
      return SD_ERROR_IO;
    }
    const uint32_t order = e->halo ? e->halo->order[i] : (uint32_t)i;
    (*list)[(*n)++] = (outside_left){order, s->id[i], (uint32_t)i, s->x[i], s->y[i]};
  }
  return SD_OK;
}

/* Counts the disks of all ranks that have left, and warns of them, in the order of their global
 * slots. Returns SD_ERROR_NUMERIC if such disks are to stop the run. */
static sd_status tell_left(engine *e, const outside_left *list, size_t n, sd_messages *messages) {
  sd_state *s = e->state;
  const sd_outside how = e->model->bounds.outside;
  const long long step = (long long)s->step;
  /* If disks that leave are to be removed, warn only once; the end of the run reports their number,
   * and the first ones. */
  const int64_t told = how == SD_OUTSIDE_REMOVE ? 1 : OUTSIDE_TOLD;
  assert(e->model->bounds.given);
  for (const outside_left *d = list; d < list + n; d++) {
    char name[96];
    s->outside++;
    if (how != SD_OUTSIDE_STOP && s->outside > told + 1) continue;
    sd_model_body_name(e->model, d->disk, name, sizeof name);
    if (how == SD_OUTSIDE_STOP)
      return sd_fail(messages, SD_ERROR_NUMERIC, "step %lld: %s left the bounds, it is at (%g, %g)",
                     step, name, d->x, d->y);
    if (s->outside <= told)
      sd_warn(messages, "step %lld: %s left the bounds, it is at (%g, %g)%s", step, name, d->x,
              d->y, how == SD_OUTSIDE_REMOVE ? " and is taken out" : "");
    else
      sd_warn(messages,
              "step %lld: more disks leave the bounds; they are only counted from here on", step);
  }
  return SD_OK;
}

/* Marks the disks of this rank in the list, which have left, as SD_OUTSIDE, or removes them from
 * the simulation if the model says so. */
static void mark_left(engine *e, const outside_left *list, size_t n) {
  for (size_t k = 0; k < n; k++) {
    e->state->activity[list[k].slot] = SD_OUTSIDE;
    if (e->model->bounds.outside == SD_OUTSIDE_REMOVE) take_out(e, list[k].slot);
  }
}

static int by_order(const void *one, const void *two) {
  const outside_left *p = one, *q = two;
  return p->order < q->order ? -1 : p->order > q->order;
}

/* Gathers the lists of all ranks in *list on every rank, sorted by global slots; the caller frees
 * *list. *all: number of disks in it. */
static sd_status gather_left(const comm *c, const outside_left *mine, size_t n, outside_left **list,
                             size_t *all) {
  int *counts = memory_new((size_t)comm_size(c), sizeof *counts);
  comm_gather_counts(c, (int)n, counts);
  *all = 0;
  for (int q = 0; q < comm_size(c); q++) *all += (size_t)counts[q];
  const bool there = memory_row(list, *all, sizeof **list);
  const sd_status status = comm_agree(c, there ? SD_OK : SD_ERROR_IO);
  if (status == SD_OK) comm_gather(c, mine, *list, counts, sizeof *mine);
  if (status == SD_OK && *all > 1) qsort(*list, *all, sizeof **list, by_order);
  free(counts);
  return status;
}

/* Ends the contacts of all disks that are removed; they may be disks of this rank or ghosts. */
static sd_status end_contacts(engine *e, const outside_left *list, size_t n) {
  const size_t slots = e->state->n_free + e->state->n_ghosts;
  bool *gone;
  if (!memory_row(&gone, slots, sizeof *gone)) return SD_ERROR_IO;
  for (size_t k = 0; k < n; k++) {
    const size_t slot = engine_slot(e, list[k].disk);
    if (slot < slots) gone[slot] = true;
  }
  const sd_status status = contacts_end(e, gone);
  free(gone);
  return status;
}

/* Removes the disks from the simulation and rebuilds the neighbour lists. The change of energy is
 * added to state->energy_start, so that the energy balance stays as it was. mine: disks of this
 * rank; all: disks of all ranks. */
static sd_status remove_left(engine *e, const outside_left *mine, size_t n, const outside_left *all,
                             size_t n_all, sd_messages *messages) {
  const sd_energy before = energy_of(e);
  sd_status status = end_contacts(e, all, n_all);
  if (status != SD_OK)
    sd_fail(messages, status, "out of memory for contacts of disks that are taken out");
  status = comm_agree(e->comm, status);
  if (status != SD_OK) return status;
  mark_left(e, mine, n);
  bodies_fill_constants(e);
  status = engine_renew(e, messages);
  if (status != SD_OK) return status;
  const sd_energy after = energy_of(e);
  e->state->energy_start += energy_total(&after) - energy_total(&before);
  return SD_OK;
}

sd_status outside_check(engine *e, sd_messages *messages) {
  outside_left *mine, *all = NULL;
  size_t n, n_all = 0;
  sd_status status = comm_agree(e->comm, find_left(e, &mine, &n));
  if (status == SD_OK) status = gather_left(e->comm, mine, n, &all, &n_all);
  if (status != SD_OK)
    sd_fail(messages, status, "out of memory for disks that have left the bounds");
  if (status == SD_OK && n_all > 0) status = tell_left(e, all, n_all, messages);
  if (status == SD_OK && n_all > 0 && e->model->bounds.outside == SD_OUTSIDE_REMOVE)
    status = remove_left(e, mine, n, all, n_all, messages);
  else if (status == SD_OK)
    mark_left(e, mine, n);
  free(all);
  free(mine);
  return status;
}

int64_t outside_count(const sd_state *s) {
  int64_t n = 0;
  for (size_t i = 0; i < s->n_free; i++)
    n += s->activity[i] == SD_REMOVED || s->activity[i] == SD_OUTSIDE;
  return n;
}

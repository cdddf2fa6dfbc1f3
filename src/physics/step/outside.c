/* outside.c: see outside.h. */
#include "physics/system/bodies.h"
#include "physics/step/outside.h"

#include <assert.h>
#include <stdlib.h>

#include "base/memory.h"
#include "physics/contact/energy.h"
#include "physics/step/access.h"
#include "physics/step/engine.h"
#include "physics/neighbours/neighbours.h"
#include "physics/system/halo.h"

/* Infinite limits stay infinite. Of a clump its centre counts, for all of its disks. */
static bool beyond(const engine *e, size_t i) {
  const sd_bounds *b = &e->model->bounds;
  const sd_state *s = e->state;
  const bool member = engine_in_clump(e, i);
  const int32_t k = member ? e->work.clumps.of[i] : 0;
  const double at[2] = {member ? s->clump_x[k] : s->x[i], member ? s->clump_y[k] : s->y[i]};
  double scale = e->state->box_scale;
  for (int c = 0; c < 2; c++) {
    double corner = box_corner(e->model, c);
    if (at[c] < corner + scale * (b->lower[c] - corner) || at[c] > corner + scale * (b->upper[c] - corner))
      return true;
  }
  return false;
}

bool outside_is_due(const engine *e) {
  const sd_state *s = e->state;
  for (size_t i = 0; i < s->n_free; i++)
    if (body_in_play(s, i) && beyond(e, i) != (s->activity[i] == SD_OUTSIDE)) return true;
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

sd_status outside_find(engine *e, outside_left **list, size_t *n) {
  sd_state *s = e->state;
  size_t capacity = 0;
  *list = NULL;
  *n = 0;
  for (size_t i = 0; i < s->n_free; i++) {
    if (!body_in_play(s, i)) continue;
    const bool out = beyond(e, i);
    if (!out) s->activity[i] = SD_IN_PLAY;
    if (!out || s->activity[i] == SD_OUTSIDE) continue;
    if (*n == capacity) {
      capacity = 2 * capacity + 16;
      if (!memory_resize(1, &(memory_column){list, capacity, sizeof **list})) {
        free(*list);
        *list = NULL;
        return SD_ERROR_IO;
      }
    }
    const uint32_t order = e->halo ? e->halo->order[i] : (uint32_t)i;
    (*list)[(*n)++] = (outside_left){order, s->id[i], (uint32_t)i, s->x[i], s->y[i]};
  }
  return SD_OK;
}

sd_status outside_tell(engine *e, const outside_left *list, size_t n, sd_messages *messages) {
  sd_state *s = e->state;
  const sd_outside how = e->model->bounds.outside;
  const long long step = (long long)s->step;
  /* what is meant to leave is told of once; the end of the run says how many, and which */
  const int64_t told = how == SD_OUTSIDE_REMOVE ? 1 : OUTSIDE_TOLD;
  assert(e->model->bounds.given);
  for (const outside_left *d = list; d < list + n; d++) {
    char name[96];
    s->outside++;
    if (how != SD_OUTSIDE_STOP && s->outside > told + 1) continue;
    sd_model_body_name(e->model, d->disk, name, sizeof name);
    if (how == SD_OUTSIDE_STOP)
      return sd_fail(messages, SD_ERROR_NUMERIC, "step %lld: %s left the bounds, it is at (%g, %g)", step,
                     name, d->x, d->y);
    if (s->outside <= told)
      sd_warn(messages, "step %lld: %s left the bounds, it is at (%g, %g)%s", step, name, d->x, d->y,
              how == SD_OUTSIDE_REMOVE ? " and is taken out" : "");
    else
      sd_warn(messages, "step %lld: more disks leave the bounds; they are only counted from here on", step);
  }
  return SD_OK;
}

void outside_mark(engine *e, const outside_left *list, size_t n) {
  for (size_t k = 0; k < n; k++) {
    e->state->activity[list[k].slot] = SD_OUTSIDE;
    if (e->model->bounds.outside == SD_OUTSIDE_REMOVE) take_out(e, list[k].slot);
  }
}

sd_status outside_look(engine *e, sd_messages *messages) {
  const bool removes = e->model->bounds.outside == SD_OUTSIDE_REMOVE;
  outside_left *list;
  size_t n;
  sd_status status = outside_find(e, &list, &n);
  if (status != SD_OK) return sd_fail(messages, status, "out of memory for disks that have left the bounds");
  const sd_energy before = n > 0 && removes ? energy_of(e) : (sd_energy){0};
  if (n > 0) status = outside_tell(e, list, n, messages);
  if (status == SD_OK) outside_mark(e, list, n);
  free(list);
  if (status != SD_OK || n == 0 || !removes) return status;
  bodies_fill_constants(e);
  status = neighbours_build(e, messages);
  const sd_energy after = energy_of(e);
  e->state->energy_start += energy_total(&after) - energy_total(&before);
  return status;
}

int64_t outside_count(const sd_state *s) {
  int64_t n = 0;
  for (size_t i = 0; i < s->n_free; i++) n += s->activity[i] == SD_REMOVED || s->activity[i] == SD_OUTSIDE;
  return n;
}

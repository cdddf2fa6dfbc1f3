/* outside.c: see outside.h. */
#include "physics/system/bodies.h"
#include "physics/step/outside.h"

#include <assert.h>

#include "physics/contact/energy.h"
#include "physics/step/access.h"
#include "physics/step/engine.h"
#include "physics/neighbours/neighbours.h"

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

/* The disk in slot i has just left. */
static sd_status treat(engine *e, size_t i, sd_messages *messages) {
  sd_state *s = e->state;
  const sd_outside how = e->model->bounds.outside;
  char name[96];
  assert(body_in_play(s, i) && e->model->bounds.given);
  sd_model_body_name(e->model, s->id[i], name, sizeof name);
  s->outside++;
  if (how == SD_OUTSIDE_STOP)
    return sd_fail(messages, SD_ERROR_NUMERIC, "step %lld: %s left the bounds, it is at (%g, %g)",
                   (long long)s->step, name, s->x[i], s->y[i]);
  /* what is meant to leave is told of once; the end of the run says how many, and which */
  int64_t told = how == SD_OUTSIDE_REMOVE ? 1 : OUTSIDE_TOLD;
  if (s->outside <= told)
    sd_warn(messages, "step %lld: %s left the bounds, it is at (%g, %g)%s", (long long)s->step, name, s->x[i],
            s->y[i], how == SD_OUTSIDE_REMOVE ? " and is taken out" : "");
  if (s->outside == told + 1)
    sd_warn(messages, "step %lld: more disks leave the bounds; they are only counted from here on",
            (long long)s->step);
  s->activity[i] = SD_OUTSIDE;
  if (how == SD_OUTSIDE_REMOVE) take_out(e, i);
  return SD_OK;
}

sd_status outside_look(engine *e, sd_messages *messages) {
  sd_state *s = e->state;
  bool removes = e->model->bounds.outside == SD_OUTSIDE_REMOVE, removed = false;
  sd_energy before = {0};
  for (size_t i = 0; i < s->n_free; i++) {
    if (!body_in_play(s, i)) continue;
    bool out = beyond(e, i);
    if (!out) s->activity[i] = SD_IN_PLAY;
    if (!out || s->activity[i] == SD_OUTSIDE) continue;
    if (removes && !removed) before = energy_of(e);
    if (treat(e, i, messages) != SD_OK) return SD_ERROR_NUMERIC;
    removed = removes;
  }
  if (!removed) return SD_OK;
  bodies_fill_constants(e);
  sd_status status = neighbours_build(e, messages);
  sd_energy after = energy_of(e);
  s->energy_start += energy_total(&after) - energy_total(&before);
  return status;
}

int64_t outside_count(const sd_state *s) {
  int64_t n = 0;
  for (size_t i = 0; i < s->n_free; i++) n += s->activity[i] == SD_REMOVED || s->activity[i] == SD_OUTSIDE;
  return n;
}

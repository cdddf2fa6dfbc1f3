/* ensemble.c: advances several simulations (members) together; see ensemble.h.
 *
 * Members at the same step of the same phase advance side by side in the lanes of SIMD vectors, up
 * to the next step at which one of them has work between steps. Then they are grouped again; the
 * vectors are rebuilt only if the group has changed. */
#include "run/ensemble.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/subnormal.h"
#include "model/model.h"
#include "physics/neighbours/neighbours.h"
#include "physics/small/lanes.h"
#include "physics/step/access.h"
#include "run/loop.h"
#include "run/simulation_private.h"
#include "run/steps.h"

struct ensemble {
  size_t n, in_lanes;
  sd_simulation **members;
  /* SIMD lanes, and the engines that are in them; NULL: none yet */
  lanes *lanes;
  size_t n_together;
  engine *together[LANES_MOST];
  int64_t rebuilt; /* sum over these of how often they were rebuilt before */
};

size_t ensemble_width(void) { return kernels_choose()->lane_width; }
bool ensemble_takes(const sd_model *model) { return lanes_suit(model); }
bool ensemble_alike(const sd_model *a, const sd_model *b) { return lanes_alike(a, b); }
size_t ensemble_in_lanes(const ensemble *e) { return e->in_lanes; }

ensemble *ensemble_new(size_t n, sd_simulation *const *members) {
  ensemble *e = memory_new(1, sizeof *e);
  e->n = n;
  e->members = memory_copy(members, n * sizeof(sd_simulation *));
  return e;
}

void ensemble_free(ensemble *e) {
  if (!e) return;
  lanes_free(e->lanes);
  free(e->members);
  free(e);
}

/* Work that is left for a member of the ensemble in this call. */
typedef struct share {
  /* engine of the member; NULL: it has taken all steps, has failed or is finished */
  engine *engine;
  int64_t left; /* number of steps left in this call */
} share;

/* Finds the members that can share SIMD lanes with member `first`. who: receives their indices;
 * steps: receives the number of steps that all of them can take together. Returns the number of
 * members found. */
static size_t find_together(const ensemble *e, const share *shares, size_t first, size_t *who,
                            int64_t *steps) {
  size_t n = 0, most = engine_kernels(shares[first].engine)->lane_width;
  const engine *leader = shares[first].engine;
  *steps = INT64_MAX;
  for (size_t k = first; k < e->n && n < most; k++) {
    const share *s = &shares[k];
    if (!s->engine || !engine_lanes(s->engine) ||
        engine_kernels(s->engine) != engine_kernels(leader))
      continue;
    if (k != first &&
        (!lanes_alike(leader->model, s->engine->model) || !lanes_in_step(leader, s->engine)))
      continue;
    who[n++] = k;
    int64_t room = loop_steps_left(s->engine), now = s->left < room ? s->left : room;
    if (now < *steps) *steps = now;
  }
  assert(n <= LANES_MOST && (n == 0 || *steps > 0));
  return n;
}

/* Returns SIMD lanes with these systems; makes new ones unless the present ones have the same
 * systems, with the same constants. */
static lanes *lanes_for(ensemble *e, size_t n, engine *const *systems) {
  int64_t rebuilt = 0;
  for (size_t k = 0; k < n; k++) rebuilt += systems[k]->rebuilt;
  if (e->lanes && e->n_together == n && e->rebuilt == rebuilt &&
      memcmp(e->together, systems, n * sizeof(engine *)) == 0)
    return e->lanes;
  lanes_free(e->lanes);
  e->rebuilt = rebuilt;
  e->n_together = n;
  memcpy(e->together, systems, n * sizeof(engine *));
  e->lanes = lanes_new(false, n, systems);
  return e->lanes;
}

static void go_together(ensemble *e, size_t n, engine *const *systems, int64_t steps) {
  const sd_state *s = systems[0]->state;
  bool measure = systems[0]->model->phases[s->phase].measure;
  lanes *l = lanes_for(e, n, systems);
  /* store the motions of systems that were advanced without lanes before */
  for (size_t k = 0; k < n; k++) motion_store(systems[k]);
  uint64_t mode = subnormal_off();
  lanes_loop(l, steps, measure);
  subnormal_restore(mode);
  if (n > e->in_lanes) e->in_lanes = n;
}

/* Advances member `first`, together with all members that can share SIMD lanes with it, up to the
 * next work between steps of any of them; advances it alone if there is no such member. */
static void advance_some(ensemble *e, share *shares, size_t first, sd_status *status,
                         sd_messages *const *messages) {
  size_t who[LANES_MOST];
  engine *systems[LANES_MOST];
  int64_t steps = 0, from[LANES_MOST];
  size_t n = engine_lanes(shares[first].engine) ? find_together(e, shares, first, who, &steps) : 0;
  for (size_t k = 0; k < n; k++) {
    systems[k] = shares[who[k]].engine;
    from[k] = systems[k]->state->step;
  }
  if (n < 2) {
    share *alone = &shares[first];
    status[first] = sd_simulation_advance(e->members[first], alone->left, messages[first]);
    alone->engine = NULL;
    return;
  }
  go_together(e, n, systems, steps);
  for (size_t k = 0; k < n; k++) {
    share *s = &shares[who[k]];
    assert(systems[k]->state->step - from[k] <= s->left);
    s->left -= systems[k]->state->step - from[k];
    status[who[k]] = loop_pause(systems[k], from[k], messages[who[k]]);
    bool over = s->left == 0 || sd_simulation_finished(e->members[who[k]]);
    if (status[who[k]] == SD_OK && !over) continue;
    if (status[who[k]] == SD_OK)
      status[who[k]] =
          neighbours_check_finite(systems[k], systems[k]->state->step, messages[who[k]]);
    s->engine = NULL;
  }
}

void ensemble_advance(ensemble *e, int64_t n, sd_status *status, sd_messages *const *messages) {
  e->in_lanes = 0;
  share *shares = memory_new(e->n, sizeof *shares);
  for (size_t k = 0; k < e->n; k++) {
    if (status[k] != SD_OK || sd_simulation_finished(e->members[k]) || n <= 0) continue;
    shares[k] = (share){simulation_engine(e->members[k]), n};
    engine_ready(shares[k].engine, messages[k]);
  }
  for (size_t k = 0; k < e->n; k++)
    while (shares[k].engine) advance_some(e, shares, k, status, messages);
  free(shares);
}

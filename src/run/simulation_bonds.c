/* simulation_bonds.c: bonds that a program makes between two steps; see slipdisk/simulation.h. */
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "model/law_features.h"
#include "model/model.h"
#include "physics/contact/evaluate.h"
#include "physics/neighbours/neighbours.h"
#include "physics/step/access.h"
#include "physics/step/bonds.h"
#include "physics/step/engine.h"
#include "run/loop.h"
#include "run/simulation_private.h"

/* Returns the number of a body given as a number or SD_WALL(w); UINT32_MAX: there is none. */
static uint32_t body_of(const sd_model *m, uint32_t body) {
  const bool wall = body >= SD_WALL(0) && body - SD_WALL(0) < m->n_walls;
  const uint32_t number = wall ? body - SD_WALL(0) + (uint32_t)m->n_disks : body;
  return number < sd_model_bodies(m) ? number : UINT32_MAX;
}

/* Finds the candidate pair of two bodies whose surfaces are nearest; SIZE_MAX: there is none. */
static size_t nearest_pair(const engine *e, uint32_t a, uint32_t b) {
  const uint32_t slot = engine_slot(e, a), other = engine_slot(e, b);
  size_t found = SIZE_MAX;
  double least = HUGE_VAL;
  for (size_t at = engine_first(e, slot); at < engine_first(e, slot + 1); at++) {
    const size_t k = engine_candidate(e, at);
    if (engine_partner(e, at) != other || !bonds_can(e, k)) continue;
    const double gap = -contact_geometry_of(e, k).overlap;
    if (!(gap < least)) continue;
    least = gap;
    found = k;
  }
  return found;
}

/* Finds the pair that can be bonded; reports why there is none. */
static sd_status find_pair(const engine *e, const uint32_t bodies[2], size_t *k,
                           sd_messages *messages) {
  const sd_model *m = e->model;
  const uint32_t one = body_of(m, bodies[0]), two = body_of(m, bodies[1]);
  char a[96], b[96];
  for (int n = 0; n < 2; n++)
    if (body_of(m, bodies[n]) == UINT32_MAX)
      return sd_fail(messages, SD_ERROR_USER, "bond: no disk or wall has the number %u", bodies[n]);
  sd_model_body_name(m, one, a, sizeof a);
  sd_model_body_name(m, two, b, sizeof b);
  if (one == two) return sd_fail(messages, SD_ERROR_USER, "bond: %s with itself", a);
  const uint32_t slot[2] = {engine_slot(e, one), engine_slot(e, two)};
  const size_t n_free = e->state->n_free;
  if (slot[0] >= n_free && slot[1] >= n_free)
    return sd_fail(messages, SD_ERROR_USER, "bond: neither %s nor %s moves freely", a, b);
  const sd_contact_law *law =
      sd_model_law(m, e->state->material[slot[0]], e->state->material[slot[1]]);
  if (!law_bonds(law))
    return sd_fail(messages, SD_ERROR_USER,
                   "bond: the law of %s and %s has no bonds; expected bond_k_n, or bond_E and "
                   "bond_width, in the deck",
                   a, b);
  const bool first = slot[0] < n_free;
  *k = nearest_pair(e, first ? one : two, first ? two : one);
  if (*k == SIZE_MAX)
    return sd_fail(messages, SD_ERROR_USER,
                   "bond: %s and %s are farther apart than bond_gap = %g, or not in play", a, b,
                   law->bond_gap);
  return SD_OK;
}

static sd_status bond(sd_simulation *sim, size_t n, const uint32_t (*joined)[2],
                      sd_messages *messages) {
  engine *e = &sim->engine;
  size_t *found;
  sd_status status = SD_OK;
  if (n > 0 && !joined)
    return sd_fail(messages, SD_ERROR_USER, "bond: expected %zu pairs, not NULL", n);
  if (loop_finished(e))
    return sd_fail(messages, SD_ERROR_USER,
                   "bond: the last phase is over; no step is left to make");
  if (!memory_row(&found, n, sizeof *found))
    return sd_fail(messages, SD_ERROR_IO, "out of memory for %zu bonds", n);
  engine_ready(e, messages);
  for (size_t k = 0; k < n && status == SD_OK; k++)
    status = find_pair(e, joined[k], &found[k], messages);
  for (size_t k = 0; k < n && status == SD_OK; k++) bonds_make(e, found[k]);
  free(found);
  return status;
}

sd_status sd_simulation_bond(sd_simulation *sim, size_t n, const uint32_t (*joined)[2],
                             sd_messages *messages) {
  bool outer;
  if (!simulation_enter(sim, NEED_CHANGE, "sd_simulation_bond", &outer, messages))
    return SD_ERROR_USER;
  const sd_status status = bond(sim, n, joined, messages);
  simulation_leave(sim, outer);
  return status;
}

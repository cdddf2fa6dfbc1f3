/* step.c: the step, one page.
 *
 * predict free disks -> place prescribed bodies at t + dt -> (stale? rebuild neighbours, carrying contacts)
 * -> one force per contact -> gather per body in fixed order, correct -> commit lambda*, book losses.
 *
 * Every loop writes only its own indices; each wait makes what was written visible to the whole team.
 */
#include "physics/step.h"

#include "physics/contacts.h"
#include "physics/kernels.h"
#include "physics/motion.h"
#include "physics/neighbours.h"
#include "physics/pairs.h"
#include "physics/walls.h"

static bool any_stale(const work *w) {
  bool stale = false;
  for (int k = 0; k < w->n_threads; k++) stale |= w->threads[k].stale;
  return stale;
}

/* Shares are those of n_threads; a team may be smaller. */
static void pass_pairs(engine *e, const team *t, int pass) {
  work *w = &e->work;
  for (int k = t->rank; k < w->n_threads; k += t->size)
    w->kernels->pairs(e, &w->threads[k], w->pair_share[k], w->pair_share[k + 1], pass);
}

void step_begin(engine *e) { e->work.kernels->seat(e, e->state->n_free, e->state->n_bodies); }

void step_once(engine *e, const team *t) {
  work *w = &e->work;
  const kernels *k = w->kernels;
  thread_work *mine = &w->threads[t->rank];
  const bool first = t->rank == 0, one_pass = e->model->integrator == SD_VERLET;
  const size_t n_free = e->state->n_free;
  size_t disk, disks_end, body, bodies_end;
  team_share(t, n_free, &disk, &disks_end);
  team_share(t, e->state->n_bodies - n_free, &body, &bodies_end);

  /* trial coordinates at t + dt, and the exact ones of what is prescribed */
  k->predict[e->model->integrator](e, mine, disk, disks_end);
  team_wait(t);
  if (first) {
    motion_place(e, mine);
    if (motion_moves_walls(e)) walls_place(e);
    pairs_clear_sums(e);
  }
  team_wait(t);

  /* candidates; the contacts' memory moves along */
  if (any_stale(w)) {
    team_wait(t);
    if (first) w->status = neighbours_build(e, w->messages);
    team_wait(t);
    if (w->status != SD_OK) return;
  }

  /* forces at the trial coordinates: the skin is not moved. With velocity Verlet these positions are final,
   * so lambda* is committed at once. */
  pass_pairs(e, t, one_pass ? PASS_FORCE | PASS_COMMIT : PASS_FORCE);
  team_wait(t);
  k->gather(e, n_free + body, n_free + bodies_end);
  k->correct[e->model->integrator](e, mine, disk, disks_end);
  team_wait(t);
  if (first) motion_work(e);

  /* history is written once a step, from the corrected coordinates */
  if (!one_pass) {
    team_wait(t);
    pass_pairs(e, t, PASS_COMMIT);
    team_wait(t);
  }
  if (first) {
    if (contacts_any_event(w)) w->status = contacts_events(e, w->messages);
    e->state->step++;
  }
}

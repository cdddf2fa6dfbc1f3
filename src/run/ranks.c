/* ranks.c: one simulation over several ranks; see ranks.h. ranks_move.c moves disks between
 * ranks. */
#include "run/ranks.h"

#include <math.h>
#include <stdlib.h>

#include "base/comm_cuts.h"
#include "base/memory.h"
#include "io/results/checkpoint.h"
#include "io/results/record.h"
#include "model/advice.h"
#include "model/rows.h"
#include "physics/step/access.h"
#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/step/step.h"
#include "physics/system/halo.h"
#include "run/loop.h"
#include "run/ranks_move.h"
#include "run/ranks_share.h"
#include "run/steps.h"

/* Collective: takes up to n steps and does the work between them; stops earlier if a rank fails or
 * was asked to stop. */
static sd_status advance(ranks *r, int64_t n) {
  engine *e = r->part;
  sd_status status = SD_OK;
  engine_ready(e, r->messages);
  r->bits = 0;
  while (status == SD_OK && n > 0 && !loop_finished(e) && !(r->bits & HALO_STOP)) {
    const int64_t from = e->state->step, room = loop_steps_left(e);
    status = loop_advance(e, n < room ? n : room, r->messages);
    n -= e->state->step - from;
  }
  return status;
}

/* Ends a collective operation: all ranks get the same status, and rank 0 gets the messages of
 * all. */
static sd_status tell(ranks *r, sd_status status, sd_messages *messages) {
  return ranks_report(r->comm, comm_agree(r->comm, status), r->messages,
                      comm_rank(r->comm) == 0 ? messages : NULL);
}

/* --- Beginning and advancing ------------------------------------------------------------------ */

/* Cuts the plane into a domain for each rank and moves the disks to the ranks of their domains. */
static sd_status spread(ranks *r, sd_state *state, uint32_t *order, int threads) {
  halo unconnected = {.comm = r->comm, .n_own = state->n_free, .order = order};
  const engine first = {.comm = r->comm, .model = r->model, .state = state, .halo = &unconnected};
  int32_t of_each[1] = {threads};
  comm_broadcast(r->comm, of_each, sizeof of_each);
  r->threads = of_each[0];
  r->skin = engine_first_skin(r->model);
  r->cut_step = state->step;
  r->cuts = comm_cuts_new(r->comm);
  sd_status status = comm_agree(r->comm, r->cuts ? SD_OK : SD_ERROR_IO);
  if (status == SD_OK) status = comm_agree(r->comm, move_first_cut(r->cuts, state));
  r->balance.cuts++;
  if (r->threads > 1) r->pool = pool_new(r->threads);
  if (status == SD_OK) status = comm_agree(r->comm, ranks_take_part(r, &first, true));
  if (status != SD_OK && sd_messages_count(r->messages) == 0)
    sd_fail(r->messages, status, "cannot spread the disks over the ranks");
  return status;
}

sd_status ranks_spread(ranks *r, sd_state *state, uint32_t *order, int threads,
                       sd_messages *messages) {
  rows_free(r->model->mine); /* the disks of the checkpoint replace those of the deck */
  const sd_status status = tell(r, spread(r, state, order, threads), messages);
  sd_state_free(state);
  free(order);
  return status;
}

/* First body that was faster than the displacement limit per step, as stored in the state. */
typedef struct fast {
  int64_t step, disk;
  double displacement;
  /* slot of a free disk in the sorted order of the disks of all ranks; prescribed bodies come after
   * all free disks */
  uint32_t order;
} fast;

static fast fast_of(const engine *e) {
  const sd_state *s = e->state;
  const uint32_t slot = s->fast_step < 0 ? SLOT_NONE : engine_slot(e, (uint32_t)s->fast_disk);
  return (fast){s->fast_step, s->fast_disk, s->fast_displacement,
                slot < s->n_free ? e->halo->order[slot] : UINT32_MAX};
}

/* Returns true if a was first: at an earlier step, or at the same step with the larger
 * displacement, or at equal displacement with the lower slot. */
static bool is_before(const fast *a, const fast *b) {
  if (a->step < 0 || b->step < 0) return a->step >= 0 && b->step < 0;
  if (a->step != b->step) return a->step < b->step;
  return a->displacement != b->displacement ? a->displacement > b->displacement
                                            : a->order < b->order;
}

/* Finds the first body of all ranks that was too fast, and stores it on every rank, so that no rank
 * searches for one any more. */
static void share_fast(engine *e) {
  const fast mine = fast_of(e);
  fast *all = memory_new((size_t)comm_size(e->comm), sizeof *all);
  comm_gather_one(e->comm, &mine, all, sizeof mine);
  fast first = all[0];
  for (int q = 1; q < comm_size(e->comm); q++)
    if (is_before(&all[q], &first)) first = all[q];
  free(all);
  e->state->fast_step = first.step;
  e->state->fast_disk = first.disk;
  e->state->fast_displacement = first.displacement;
  speed_begin(e);
}

/* Begins the first phase, and does the work that comes once at step 0. */
static sd_status start_part(ranks *r) {
  engine *e = r->part;
  /* If each rank has read some of the disks of a file, overlaps are checked only now: before, no
   * rank had all neighbours of its disks. */
  if (r->model->tiles.away && r->model->tiles.of_file) {
    first_overlap deepest;
    const sd_status apart = comm_agree(r->comm, contacts_check_start(e, &deepest, r->messages));
    if (apart != SD_OK) return apart;
    advice_share_overlap(r->comm, &deepest);
    advice_tell_overlap(r->model, &deepest, r->messages);
  }
  sd_status status = loop_begin_phase(e, r->messages);
  if (status == SD_OK) status = loop_start(e, r->messages);
  share_fast(e);
  return status;
}

sd_status ranks_start(ranks *r, int threads, sd_messages *messages) {
  sd_state *state;
  uint32_t *order;
  sd_status status = comm_agree(r->comm, ranks_first_new(r->comm, r->model, &state, &order));
  if (status == SD_OK) status = spread(r, state, order, threads);
  sd_state_free(state);
  free(order);
  if (status == SD_OK) status = start_part(r);
  return tell(r, status, messages);
}

sd_status ranks_advance(ranks *r, int64_t n, sd_messages *messages) {
  const sd_status status = tell(r, advance(r, n), messages);
  share_fast(r->part);
  if (r->bits & HALO_STOP && r->stop) *r->stop = 1;
  return status;
}

/* --- Results ---------------------------------------------------------------------------------- */

sd_status ranks_store(ranks *r, bool rows, sd_messages *messages) {
  return tell(r, ranks_store_part(r, rows), messages);
}

const resultants *ranks_resultants(ranks *r, sd_messages *messages) {
  const sd_status status = resultants_compute(&r->sums, r->model, r->part->state,
                                              engine_slots(r->part), r->comm, r->messages);
  return tell(r, status, messages) == SD_OK ? &r->sums : NULL;
}

/* Collective: each rank writes a file with its own disks: a share (file of one rank) of a
 * checkpoint or, if `rows` is true, of a part file of the result. */
static sd_status write_share(ranks *r, bool rows, const char *path, int64_t *seals,
                             sd_messages *messages) {
  int64_t sum = 0;
  char *head = comm_text(r->comm, path), *share = h5_share_path(head, (size_t)comm_rank(r->comm));
  const sd_status status =
      comm_agree(r->comm, rows ? record_seal_share(&r->rows, share, &sum, r->messages)
                               : ranks_write_share(r->part, share, &sum, r->messages));
  if (status == SD_OK)
    ranks_gather_sums(r->comm, sum, seals);
  else
    checkpoint_remove_share(-1, head, (size_t)comm_rank(r->comm));
  free(share);
  free(head);
  return tell(r, status, messages);
}

sd_status ranks_write(ranks *r, const char *path, int64_t *seals, sd_messages *messages) {
  return write_share(r, false, path, seals, messages);
}

sd_status ranks_seal(ranks *r, const char *path, int64_t *seals, sd_messages *messages) {
  return write_share(r, true, path, seals, messages);
}

sd_status ranks_sample(ranks *r, unsigned what, int64_t frame, int64_t moment_number,
                       size_t *n_contacts, size_t *bytes, sd_messages *messages) {
  int64_t at[2] = {frame, moment_number};
  comm_broadcast(r->comm, at, sizeof at);
  const sd_status status =
      tell(r, ranks_sample_share(r->part, what, at[0], at[1], &r->rows, r->messages), messages);
  if (status != SD_OK) return status;
  *n_contacts = ranks_count_contacts(r->part);
  *bytes = (size_t)comm_total(r->comm, (double)record_bytes(&r->rows));
  return SD_OK;
}

/* ranks.c: see ranks.h. How disks move is in ranks_move.c. */
#include "run/ranks.h"

#include <math.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/comm_cuts.h"
#include "base/memory.h"
#include "io/results/checkpoint.h"
#include "io/results/record_share.h"
#include "model/advice.h"
#include "model/rows.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/neighbours/order.h"
#include "physics/step/access.h"
#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/step/speed.h"
#include "physics/system/halo.h"
#include "run/loop.h"
#include "run/ranks_first.h"
#include "run/ranks_failure.h"
#include "run/ranks_move.h"
#include "run/ranks_order.h"
#include "run/ranks_share.h"

struct ranks {
  const comm *comm;
  const sd_model *model;
  int threads;
  pool *pool;
  volatile sig_atomic_t *stop;
  comm_cuts *cuts;
  engine *part; /* of this rank; state NULL: not spread */
  double skin;
  unsigned bits;         /* of all ranks, after the last step */
  sd_messages *messages; /* of this rank */
  record_share rows;     /* of this rank, since the last part */
  resultants sums;       /* of all ranks, for a row of the series */
  double busy;           /* seconds of work since the last cut */
  int64_t cut_step;
  ranks_balance balance;
};

/* Cut anew when the busiest rank works by so much more than the mean, but not more often. */
static const double IMBALANCE = 0.1;
enum { CUT_LEAST = 200 }; /* steps */

ranks *ranks_new(const comm *c, engine *part, volatile sig_atomic_t *stop) {
  ranks *r = memory_new(1, sizeof *r);
  *r = (ranks){.comm = c,
               .model = part->model,
               .part = part,
               .stop = stop,
               .messages = sd_messages_new(),
               .balance.excess = NAN};
  record_share_new(&r->rows, r->model);
  resultants_new(&r->sums, r->model);
  return r;
}

static void drop_part(ranks *r) {
  engine *e = r->part;
  halo *h = e->halo;
  if (e->state) engine_free(e);
  halo_free(h);
  sd_state_free(e->state);
  *e = (engine){.model = r->model};
}

void ranks_free(ranks *r) {
  if (!r) return;
  drop_part(r);
  pool_free(r->pool);
  record_share_free(&r->rows);
  resultants_free(&r->sums);
  comm_cuts_free(r->cuts);
  sd_messages_free(r->messages);
  free(r);
}

ranks_balance ranks_balance_of(const ranks *r) { return r->balance; }

/* --- parts --------------------------------------------------------------------------------------------------- */

static sd_status renew_part(engine *e, sd_messages *messages);

/* first: see move_parts. */
static sd_status take_part(ranks *r, const engine *from, bool first) {
  engine next = {.comm = r->comm, .renew = renew_part, .ranks = r, .model = r->model, .pool = r->pool};
  sd_status status = move_parts(r->cuts, from, first, r->skin, &next.state, &next.halo);
  drop_part(r);
  *r->part = next;
  if (status == SD_OK) status = engine_build(r->part, r->threads, r->messages);
  /* together, or not at all: the others would wait */
  if (comm_all_well(r->comm, status) && halo_list_prescribed(r->part) != SD_OK) status = SD_ERROR_IO;
  if (status != SD_OK && sd_messages_errors(r->messages) == 0)
    sd_fail(r->messages, status, "no memory for the disks of this rank");
  engine_ready(r->part, r->messages);
  engine_end(r->part, status);
  return status;
}

/* The part as a state that can be sent; or for rows of results alone. */
static sd_status store_part(ranks *r, bool rows) {
  engine *e = r->part;
  halo_refresh(e, NULL);
  motion_store(e);
  const sd_status status = rows ? contacts_store_rows(e) : contacts_store(e);
  return status == SD_OK ? SD_OK : sd_fail(r->messages, SD_ERROR_IO, "out of memory for the contacts");
}

/* engine_renew of a part. */
static sd_status renew_part(engine *e, sd_messages *messages) {
  ranks *r = e->ranks;
  (void)messages; /* this rank has a list of its own */
  const sd_status status = comm_agree(r->comm, store_part(r, false));
  return status == SD_OK ? comm_agree(r->comm, take_part(r, e, false)) : status;
}

/* On every rank: its disks in the order that a phase begins with. */
sd_status ranks_order_again(engine *e) {
  ranks *r = e->ranks;
  sd_status status = comm_agree(r->comm, store_part(r, false));
  if (status != SD_OK || r->model->n_free < ORDER_LEAST) return status;
  status = ranks_order(r->comm, r->model, e->state, e->halo->order);
  engine_find_slots(e);
  return comm_agree(r->comm, status == SD_OK ? take_part(r, e, false) : status);
}

/* Collective. */
static void note_balance(ranks *r) {
  const double mean = comm_total(r->comm, r->busy) / comm_size(r->comm),
               disks = (double)r->part->state->n_free;
  r->balance.excess = mean > 0.0 ? comm_largest(r->comm, r->busy) / mean - 1.0 : 0.0;
  r->balance.most = (int64_t)comm_largest(r->comm, disks);
  r->balance.least = (int64_t)-comm_largest(r->comm, -disks);
}

/* New lists, disks that have left the rectangle to their new ranks, new ghosts. */
static sd_status renew(ranks *r) {
  engine *e = r->part;
  const int64_t step = e->state->step;
  sd_status status = neighbours_check_finite(e, step, r->messages);
  if (!comm_all_well(r->comm, status)) return status;
  neighbours_tune(e);
  r->skin = r->model->skin > 0.0 ? r->model->skin : engine_skin(e); /* not what one step has asked for */
  if (step - r->cut_step >= CUT_LEAST) {
    note_balance(r);
    if (r->balance.excess > IMBALANCE) {
      status = move_cut_again(r->cuts, r->part, r->busy);
      r->balance.cuts++;
    }
    r->cut_step = step;
    r->busy = 0.0;
    if (!comm_all_well(r->comm, status)) return sd_fail(r->messages, SD_ERROR_IO, "cannot balance the ranks");
  }
  /* wider, until no disk or wall outruns the lists in one step; what is not finite outruns any */
  for (;;) {
    status = store_part(r, false);
    if (comm_all_well(r->comm, status)) status = take_part(r, r->part, false);
    if (!comm_all_well(r->comm, status)) return status;
    if (!comm_or(r->comm, engine_outruns(r->part))) return SD_OK;
    status = neighbours_check_next(r->part, r->messages);
    if (!comm_all_well(r->comm, status)) return status;
    if (!isfinite(r->skin))
      return sd_fail(r->messages, SD_ERROR_NUMERIC, "step %lld: a wall is not finite", (long long)step + 1);
    r->skin = fmax(1.5 * r->skin, comm_largest(r->comm, engine_outrun_skin(r->part)));
  }
}

/* --- steps ----------------------------------------------------------------------------------------------------- */

void ranks_steps(engine *e, int64_t n) {
  ranks *r = e->ranks;
  int64_t until = e->state->step + n;
  do {
    const double began = clock_seconds();
    e->halo->waited = 0.0;
    loop_steps(e, r->pool, until, r->stop, &r->bits);
    r->busy += clock_seconds() - began - e->halo->waited;
    if (r->bits & HALO_STALE && !(r->bits & HALO_FAILED)) {
      /* lists are for steps: at the end those of one rank alone are not made anew either */
      const int64_t step = e->state->step;
      const sd_status status = step < until ? renew(r) : neighbours_check_finite(e, step, r->messages);
      engine_end(e, status);
      if (!comm_all_well(r->comm, status)) r->bits |= HALO_FAILED;
    }
    const int64_t next = e->state->step + 1;
    if (r->bits & HALO_STOP && next < until) until = next;
  } while (!(r->bits & HALO_FAILED) && e->state->step < until);
}

/* On every rank: n steps, or fewer when one fails or is to stop, and what is done between them. */
static sd_status advance(ranks *r, int64_t n) {
  engine *e = r->part;
  sd_status status = SD_OK;
  engine_ready(e, r->messages);
  r->bits = 0;
  while (status == SD_OK && n > 0 && !loop_finished(e) && !(r->bits & HALO_STOP)) {
    const int64_t from = e->state->step, room = loop_room(e);
    status = loop_advance(e, n < room ? n : room, r->messages);
    n -= e->state->step - from;
  }
  return status;
}

/* Ends work of every rank: all agree on its status, and rank 0 hears what was said. */
static sd_status tell(ranks *r, sd_status status, sd_messages *messages) {
  return ranks_tell(r->comm, comm_agree(r->comm, status), r->messages,
                    comm_rank(r->comm) == 0 ? messages : NULL);
}

/* --- begin, advance --------------------------------------------------------------------------- */

static sd_status spread(ranks *r, sd_state *state, uint32_t *order, int threads) {
  halo unconnected = {.comm = r->comm, .n_own = state->n_free, .order = order};
  const engine first = {.comm = r->comm, .model = r->model, .state = state, .halo = &unconnected};
  int32_t of_each[1] = {threads};
  comm_share(r->comm, of_each, sizeof of_each);
  r->threads = of_each[0];
  r->skin = engine_first_skin(r->model);
  r->cut_step = state->step;
  r->cuts = comm_cuts_new(r->comm);
  sd_status status = comm_agree(r->comm, r->cuts ? SD_OK : SD_ERROR_IO);
  if (status == SD_OK) status = comm_agree(r->comm, move_first_cut(r->cuts, state));
  r->balance.cuts++;
  if (r->threads > 1) r->pool = pool_new(r->threads);
  if (status == SD_OK) status = comm_agree(r->comm, take_part(r, &first, true));
  if (status != SD_OK && sd_messages_count(r->messages) == 0)
    sd_fail(r->messages, status, "cannot spread the disks over the ranks");
  return status;
}

sd_status ranks_spread(ranks *r, sd_state *state, uint32_t *order, int threads, sd_messages *messages) {
  rows_free(r->model->mine); /* those of a checkpoint stand for them */
  const sd_status status = tell(r, spread(r, state, order, threads), messages);
  sd_state_free(state);
  free(order);
  return status;
}

/* A body that was too fast. */
typedef struct fast {
  int64_t step, disk;
  double displacement;
  uint32_t order; /* of a free disk in the whole; prescribed bodies behind them */
} fast;

static fast fast_of(const engine *e) {
  const sd_state *s = e->state;
  const uint32_t slot = s->fast_step < 0 ? SLOT_NONE : engine_slot(e, (uint32_t)s->fast_disk);
  return (fast){s->fast_step, s->fast_disk, s->fast_displacement,
                slot < s->n_free ? e->halo->order[slot] : UINT32_MAX};
}

static bool is_before(const fast *a, const fast *b) {
  if (a->step < 0 || b->step < 0) return a->step >= 0 && b->step < 0;
  if (a->step != b->step) return a->step < b->step;
  return a->displacement != b->displacement ? a->displacement > b->displacement : a->order < b->order;
}

/* The first of all ranks, of one step the fastest, on each of them; none is looked for any more
 * then. */
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

static sd_status start_part(ranks *r) {
  engine *e = r->part;
  /* no rank had all disks of a file */
  if (r->model->tiles.away && r->model->tiles.of_file) {
    first_overlap deepest;
    const sd_status apart = comm_agree(r->comm, contacts_check_start(e, &deepest, r->messages));
    if (apart != SD_OK) return apart;
    advice_share_overlap(r->comm, &deepest);
    advice_tell_overlap(r->model, &deepest, r->messages);
  }
  loop_begin_phase(e);
  const sd_status status = loop_start(e, r->messages);
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

/* --- results ---------------------------------------------------------------------------------- */

sd_status ranks_store(ranks *r, bool rows, sd_messages *messages) {
  return tell(r, store_part(r, rows), messages);
}

const resultants *ranks_resultants(ranks *r, sd_messages *messages) {
  const sd_status status =
      resultants_take(&r->sums, r->model, r->part->state, engine_slots(r->part), r->comm, r->messages);
  return tell(r, status, messages) == SD_OK ? &r->sums : NULL;
}

/* Each rank writes its share of a checkpoint, or (rows) of a part. */
static sd_status write_share(ranks *r, bool rows, const char *path, int64_t *seals, sd_messages *messages) {
  int64_t sum = 0;
  char *head = comm_text(r->comm, path), *share = h5_share_path(head, (size_t)comm_rank(r->comm));
  const sd_status status = comm_agree(r->comm, rows ? record_share_seal(&r->rows, share, &sum, r->messages)
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

sd_status ranks_sample(ranks *r, unsigned what, int64_t frame, int64_t moment_number, size_t *n_contacts,
                       size_t *bytes, sd_messages *messages) {
  int64_t at[2] = {frame, moment_number};
  comm_share(r->comm, at, sizeof at);
  const sd_status status =
      tell(r, ranks_sample_share(r->part, what, at[0], at[1], &r->rows, r->messages), messages);
  if (status != SD_OK) return status;
  *n_contacts = ranks_count_contacts(r->part);
  *bytes = (size_t)comm_total(r->comm, (double)record_share_bytes(&r->rows));
  return SD_OK;
}

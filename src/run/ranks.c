/* ranks.c: see ranks.h. How disks move is in ranks_move.c. */
#include "run/ranks.h"

#include <assert.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/comm_cuts.h"
#include "base/memory.h"
#include "io/results/checkpoint.h"
#include "io/results/record_share.h"
#include "model/advice.h"
#include "physics/contact/energy.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/neighbours/order.h"
#include "physics/step/access.h"
#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/system/halo.h"
#include "run/loop.h"
#include "run/ranks_contacts.h"
#include "run/ranks_failure.h"
#include "run/ranks_move.h"
#include "run/ranks_order.h"
#include "run/ranks_share.h"
#include "run/ranks_tiles.h"

struct ranks {
  const comm *comm;
  const sd_model *model;
  int threads;
  pool *pool;
  volatile sig_atomic_t *stop;
  comm_cuts *cuts;
  engine part; /* of this rank; state NULL: not spread */
  double skin;
  unsigned bits;         /* of all ranks, after the last step */
  sd_messages *messages; /* of this rank */
  record_share rows;     /* of this rank, since the last part */
  resultants sums;       /* of all ranks, for a row of the series */
  int64_t collected;     /* step of the whole state */
  double busy;           /* seconds of work since the last cut */
  int64_t cut_step;
  ranks_balance balance;
  first_overlap
      deepest; /* at the start, of all ranks, where the deck's check did not see all pairs; relative 0: none */
};

/* Cut anew when the busiest rank works by so much more than the mean, but not more often. */
static const double IMBALANCE = 0.1;
enum { CUT_LEAST = 200 }; /* steps */

/* The word of rank 0. */
typedef enum word {
  SPREAD,
  START,
  REST,
  ADVANCE,
  COLLECT,
  ENERGY,
  SERIES,
  WRITE,
  SAMPLE,
  SEAL,
  DISMISS
} word;
typedef struct order {
  int64_t word, n, tiles;
} order;

/* The same call on rank 0 and on those who serve. */
static void pass(const comm *c, void *data, size_t bytes) { comm_share(c, data, bytes); }

static void say(const comm *c, word w, int64_t n, bool tiles) {
  order o = {w, n, tiles};
  assert(comm_rank(c) == 0);
  pass(c, &o, sizeof o);
}

ranks *ranks_new(const comm *c, const sd_model *model, volatile sig_atomic_t *stop) {
  ranks *r = memory_new(1, sizeof *r);
  *r = (ranks){.comm = c,
               .model = model,
               .stop = stop,
               .messages = sd_messages_new(),
               .collected = -1,
               .balance.excess = NAN};
  record_share_new(&r->rows, model);
  resultants_new(&r->sums, model);
  return r;
}

static void drop_part(ranks *r) {
  if (!r->part.state) return;
  halo *h = r->part.halo;
  engine_free(&r->part);
  halo_free(h);
  sd_state_free(r->part.state);
  r->part = (engine){0};
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

static ranks *ranks_of(engine *part) { return (ranks *)(void *)((char *)part - offsetof(ranks, part)); }

/* --- parts --------------------------------------------------------------------------------------------------- */

static sd_status renew_part(engine *e, sd_messages *messages);

/* made: disks of tiles at the start, whose contacts may be in a file. */
static sd_status take_part(ranks *r, const engine *from, bool made) {
  engine next = {.comm = r->comm, .renew = renew_part, .model = r->model, .pool = r->pool};
  sd_status status = move_parts(r->model, r->cuts, from, r->skin, &next.state, &next.halo);
  if (made && r->model->tiles.n_contacts > 0 && comm_all_well(r->comm, status))
    status = ranks_contacts_take(r->comm, r->model, next.state, r->messages);
  if (status == SD_OK && from && !from->halo) state_release_rows(from->state);
  drop_part(r);
  r->part = next;
  if (status == SD_OK) status = engine_build(&r->part, r->threads, r->messages);
  /* together, or not at all: the others would wait */
  if (comm_all_well(r->comm, status) && halo_list_prescribed(&r->part) != SD_OK) status = SD_ERROR_IO;
  engine_ready(&r->part, r->messages);
  engine_end(&r->part, status);
  return status;
}

static sd_status tell_stored(ranks *r, sd_status status) {
  return status == SD_OK ? SD_OK : sd_fail(r->messages, SD_ERROR_IO, "out of memory for the contacts");
}

/* The part as a state that can be sent. */
static sd_status store_part(ranks *r) {
  halo_refresh(&r->part, NULL);
  motion_store(&r->part);
  return tell_stored(r, contacts_store(&r->part));
}

/* The same, for rows of results. */
static sd_status store_rows(ranks *r) {
  halo_refresh(&r->part, NULL);
  motion_store(&r->part);
  return tell_stored(r, contacts_store_rows(&r->part));
}

/* engine_renew of a part. */
static sd_status renew_part(engine *e, sd_messages *messages) {
  ranks *r = ranks_of(e);
  (void)messages; /* this rank has a list of its own */
  const sd_status status = comm_agree(r->comm, store_part(r));
  return status == SD_OK ? comm_agree(r->comm, take_part(r, e, false)) : status;
}

/* On every rank: its disks in the order that a phase begins with. */
sd_status ranks_order_again(engine *e) {
  ranks *r = ranks_of(e);
  sd_status status = comm_agree(r->comm, store_part(r));
  if (status != SD_OK || r->model->n_free < ORDER_LEAST) return status;
  status = ranks_order(r->comm, r->model, e->state, e->halo->order);
  engine_find_slots(e);
  return comm_agree(r->comm, status == SD_OK ? take_part(r, e, false) : status);
}

/* Collective. */
static void note_balance(ranks *r) {
  const double mean = comm_total(r->comm, r->busy) / comm_size(r->comm),
               disks = (double)r->part.state->n_free;
  r->balance.excess = mean > 0.0 ? comm_largest(r->comm, r->busy) / mean - 1.0 : 0.0;
  r->balance.most = (int64_t)comm_largest(r->comm, disks);
  r->balance.least = (int64_t)-comm_largest(r->comm, -disks);
}

/* New lists, disks that have left the rectangle to their new ranks, new ghosts. */
static sd_status renew(ranks *r) {
  engine *e = &r->part;
  const int64_t step = e->state->step;
  sd_status status = neighbours_check_finite(e, step, r->messages);
  if (!comm_all_well(r->comm, status)) return status;
  neighbours_tune(e);
  r->skin = r->model->skin > 0.0 ? r->model->skin : engine_skin(e); /* not what one step has asked for */
  if (step - r->cut_step >= CUT_LEAST) {
    note_balance(r);
    if (r->balance.excess > IMBALANCE) {
      status = move_cut_again(r->cuts, &r->part, r->busy);
      r->balance.cuts++;
    }
    r->cut_step = step;
    r->busy = 0.0;
    if (!comm_all_well(r->comm, status)) return sd_fail(r->messages, SD_ERROR_IO, "cannot balance the ranks");
  }
  /* wider, until no disk or wall outruns the lists in one step; what is not finite outruns any */
  for (;;) {
    status = store_part(r);
    if (comm_all_well(r->comm, status)) status = take_part(r, &r->part, false);
    if (!comm_all_well(r->comm, status)) return status;
    if (!comm_or(r->comm, engine_outruns(&r->part))) return SD_OK;
    status = neighbours_check_next(&r->part, r->messages);
    if (!comm_all_well(r->comm, status)) return status;
    if (!isfinite(r->skin))
      return sd_fail(r->messages, SD_ERROR_NUMERIC, "step %lld: a wall is not finite", (long long)step + 1);
    r->skin = fmax(1.5 * r->skin, comm_largest(r->comm, engine_outrun_skin(&r->part)));
  }
}

/* --- steps ----------------------------------------------------------------------------------------------------- */

void ranks_steps(engine *e, int64_t n) {
  ranks *r = ranks_of(e);
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
  engine *e = &r->part;
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
  return ranks_tell(r->comm, comm_agree(r->comm, status), r->messages, messages);
}

/* --- rank 0 ------------------------------------------------------------------------------------------------------ */

/* tiles: each rank makes its own. */
static sd_status spread(ranks *r, const engine *whole, bool tiles) {
  engine made = {0};
  const engine *from = tiles ? &made : whole;
  double skin[1] = {whole ? engine_skin(whole) : 0.0};
  int64_t step[1] = {whole ? whole->state->step : 0};
  comm_share(r->comm, skin, sizeof skin);
  comm_share(r->comm, step, sizeof step);
  r->skin = skin[0];
  r->cut_step = step[0];
  r->busy = 0.0;
  if (!r->cuts) r->cuts = comm_cuts_new(r->comm); /* all ranks at once: rank 0 may have finished without */
  sd_status status = r->cuts ? SD_OK : SD_ERROR_IO;
  if (comm_all_well(r->comm, status) && tiles)
    status = ranks_tiles_new(r->comm, r->model, whole, &made, r->messages);
  if (comm_all_well(r->comm, status)) status = move_first_cut(r->model, r->cuts, from);
  r->balance.cuts++;
  if (r->threads > 1 && !r->pool) r->pool = pool_new(r->threads);
  if (comm_all_well(r->comm, status))
    status = take_part(r, from, tiles);
  else if (status != SD_OK && sd_messages_count(r->messages) == 0)
    sd_fail(r->messages, SD_ERROR_IO, "cannot spread the disks over the ranks");
  ranks_tiles_free(&made);
  if (whole && tiles) state_release_rows(whole->state);
  return status;
}

static sd_status spread_whole(ranks *r, engine *whole, bool tiles, sd_messages *messages) {
  motion_store(whole);
  r->threads = engine_threads(whole);
  say(r->comm, SPREAD, r->threads, tiles);
  const sd_status status = spread(r, whole, tiles);
  return tell(r, status, messages);
}

sd_status ranks_spread(ranks *r, engine *whole, sd_messages *messages) {
  return spread_whole(r, whole, false, messages);
}

/* The same; the whole (NULL on the other ranks) learns what is no disk's and no contact's. */
static sd_status end_work(ranks *r, engine *whole, sd_status status, sd_messages *messages) {
  status = tell(r, status, messages);
  r->collected = -1;
  move_common(&r->part, whole ? whole->state : NULL);
  return status;
}

settle_measure ranks_rest(ranks *r) {
  say(r->comm, REST, 0, false);
  return settle_look(&r->part);
}

/* Of equal ones, as they are found from both sides of a border, that of the first rank. */
static void share_deepest(ranks *r, const first_overlap *mine) {
  const size_t n = (size_t)comm_size(r->comm);
  int *counts = memory_new(n, sizeof *counts);
  first_overlap *all = memory_new(n, sizeof *all);
  for (size_t k = 0; k < n; k++) counts[k] = 1;
  comm_gather(r->comm, mine, all, counts, sizeof *mine);
  for (size_t k = 0; k < n; k++)
    if (all[k].relative > r->deepest.relative) r->deepest = all[k];
  free(counts);
  free(all);
}

/* On every rank. */
static sd_status start_part(ranks *r) {
  engine *e = &r->part;
  /* parts of a file were looked at one by one */
  if (r->model->tiles.away && r->model->tiles.of_file) {
    first_overlap deepest;
    const sd_status apart = comm_agree(r->comm, contacts_check_start(e, &deepest, r->messages));
    if (apart != SD_OK) return apart;
    share_deepest(r, &deepest);
  }
  return loop_start(e, r->messages);
}

sd_status ranks_start(ranks *r, engine *whole, sd_messages *messages) {
  sd_status status = spread_whole(r, whole, r->model->tiles.away, messages);
  if (status != SD_OK) return status;
  say(r->comm, START, 0, false);
  status = end_work(r, whole, start_part(r), messages);
  if (status == SD_OK) advice_tell_overlap(r->model, &r->deepest, messages);
  return status;
}

sd_status ranks_advance(ranks *r, engine *whole, int64_t n, sd_messages *messages) {
  if (r->collected >= 0) state_release_rows(whole->state);
  say(r->comm, ADVANCE, n, false);
  const sd_status status = end_work(r, whole, advance(r, n), messages);
  if (r->bits & HALO_STOP && r->stop) *r->stop = 1;
  engine_end(whole, status);
  return status;
}

/* On every rank. */
static sd_status collect(ranks *r, sd_state *whole) {
  const sd_status status = comm_agree(r->comm, store_part(r));
  return status == SD_OK ? move_together(&r->part, whole) : status;
}

sd_status ranks_collect(ranks *r, engine *whole) {
  if (r->collected == whole->state->step) return SD_OK;
  say(r->comm, COLLECT, 0, false);
  const sd_status status = collect(r, whole->state);
  if (status != SD_OK) return status;
  engine_find_slots(whole);
  r->collected = whole->state->step;
  return SD_OK;
}

sd_energy ranks_energy(ranks *r) {
  say(r->comm, ENERGY, 0, false);
  return energy_of(&r->part);
}

/* On every rank. */
static sd_status add_resultants(ranks *r, sd_messages *messages) {
  const sd_status status = comm_agree(r->comm, store_rows(r));
  if (status == SD_OK)
    resultants_take(&r->sums, r->model, r->part.state, engine_slots(&r->part), r->comm, r->messages);
  return tell(r, status, messages);
}

const resultants *ranks_resultants(ranks *r, sd_messages *messages) {
  say(r->comm, SERIES, 0, false);
  return add_resultants(r, messages) == SD_OK ? &r->sums : NULL;
}

/* On every rank: writes its share of a checkpoint, or (rows) of a part. */
static sd_status write_share(ranks *r, bool rows, const char *whole, int64_t *seals, sd_messages *messages) {
  int64_t sum = 0;
  char *path = h5_share_path(whole, (size_t)comm_rank(r->comm));
  sd_status status = rows ? SD_OK : store_part(r);
  if (comm_all_well(r->comm, status))
    status = rows ? record_share_seal(&r->rows, path, &sum, r->messages)
                  : ranks_write_share(&r->part, path, &sum, r->messages);
  free(path);
  status = comm_agree(r->comm, status);
  if (status == SD_OK)
    ranks_gather_sums(r->comm, sum, seals);
  else
    checkpoint_remove_share(-1, whole, (size_t)comm_rank(r->comm));
  return tell(r, status, messages);
}

static void say_path(const comm *c, word w, const char *path) {
  const size_t length = strlen(path) + 1;
  say(c, w, (int64_t)length, false);
  pass(c, (char *)(uintptr_t)path, length);
}

sd_status ranks_write(ranks *r, engine *whole, const char *path, int64_t *seals, summary_contacts *contacts,
                      summary_lost *lost, sd_messages *messages) {
  say_path(r->comm, WRITE, path);
  const sd_status status = write_share(r, false, path, seals, messages);
  if (status == SD_OK) *contacts = ranks_add_contacts(&r->part);
  if (status == SD_OK) *lost = ranks_add_lost(&r->part);
  if (status == SD_OK) move_common(&r->part, whole->state);
  return status;
}

sd_status ranks_seal(ranks *r, const char *path, int64_t *seals, sd_messages *messages) {
  say_path(r->comm, SEAL, path);
  return write_share(r, true, path, seals, messages);
}

/* Of the order SAMPLE: frame and columns, and the size of the rows that it made. */
typedef struct sampling {
  int64_t what, frame, moment_number;
  size_t contacts, bytes;
} sampling;

/* On every rank. */
static sd_status sample(ranks *r, sampling *s, sd_messages *messages) {
  sd_status status = store_rows(r);
  if (comm_all_well(r->comm, status))
    status =
        ranks_sample_share(&r->part, (unsigned)s->what, s->frame, s->moment_number, &r->rows, r->messages);
  status = tell(r, status, messages);
  if (status != SD_OK) return status;
  s->contacts = ranks_count_contacts(&r->part);
  s->bytes = (size_t)comm_total(r->comm, (double)record_share_bytes(&r->rows));
  return SD_OK;
}

sd_status ranks_sample(ranks *r, engine *whole, unsigned what, int64_t frame, int64_t moment_number,
                       size_t *n_contacts, size_t *bytes, sd_messages *messages) {
  sampling s = {.what = what, .frame = frame, .moment_number = moment_number};
  say(r->comm, SAMPLE, 0, false);
  pass(r->comm, &s, sizeof s);
  const sd_status status = sample(r, &s, messages);
  *n_contacts = s.contacts;
  *bytes = s.bytes;
  if (status == SD_OK) move_common(&r->part, whole->state);
  return status;
}

void ranks_dismiss(const comm *c, int status) {
  if (c) say(c, DISMISS, status, false);
}

/* --- the others -------------------------------------------------------------------------------------------------- */

static void serve_write(ranks *r, bool rows, size_t length) {
  char *path = memory_new(length, 1);
  pass(r->comm, path, length);
  if (write_share(r, rows, path, NULL, NULL) == SD_OK && !rows) {
    ranks_add_contacts(&r->part);
    ranks_add_lost(&r->part);
    move_common(&r->part, NULL);
  }
  free(path);
}

static void serve_sample(ranks *r) {
  sampling s = {0};
  pass(r->comm, &s, sizeof s);
  if (sample(r, &s, NULL) == SD_OK) move_common(&r->part, NULL);
}

int ranks_serve(ranks *r) {
  for (;;) {
    order o = {0};
    pass(r->comm, &o, sizeof o);
    switch ((word)o.word) {
      case SPREAD:
        r->threads = (int)o.n;
        tell(r, spread(r, NULL, o.tiles != 0), NULL);
        break;
      case START: end_work(r, NULL, start_part(r), NULL); break;
      case REST: settle_look(&r->part); break;
      case ADVANCE: end_work(r, NULL, advance(r, o.n), NULL); break;
      case COLLECT: collect(r, NULL); break;
      case ENERGY: energy_of(&r->part); break;
      case SERIES: add_resultants(r, NULL); break;
      case WRITE:
      case SEAL: serve_write(r, o.word == SEAL, (size_t)o.n); break;
      case SAMPLE: serve_sample(r); break;
      case DISMISS: return (int)o.n;
    }
  }
}

/* ranks.c: see ranks.h. How disks move is in ranks_move.c. */
#include "run/ranks_private.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "base/comm.h"
#include "base/comm_cuts.h"
#include "base/comm_data.h"
#include "base/memory.h"
#include "base/subnormal.h"
#include "io/results/checkpoint.h"
#include "measure/disks.h"
#include "measure/sample.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/step/access.h"
#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/step/outside.h"
#include "physics/step/step.h"
#include "physics/system/halo.h"
#include "run/phase.h"
#include "run/ranks_contacts.h"
#include "run/ranks_failure.h"
#include "run/ranks_move.h"
#include "run/ranks_share.h"
#include "run/ranks_tiles.h"

/* Cut anew when the busiest rank works by so much more than the mean, but not more often. */
static const double IMBALANCE = 0.1;
enum { CUT_LEAST = 200 }; /* steps */

/* The word of rank 0. */
typedef enum word {
  SPREAD,
  START,
  SETTLE,
  RAIN,
  LOOK,
  OUTSIDE,
  END,
  ADVANCE,
  COLLECT,
  ENERGY,
  SERIES,
  WRITE,
  SAMPLE,
  SEAL,
  DROP,
  DISMISS
} word;
typedef struct order {
  int64_t word, n, measure;
} order;

static void say(word w, int64_t n, bool measure) {
  order o = {w, n, measure};
  assert(comm_rank() == 0);
  comm_share(&o, sizeof o);
}

ranks *ranks_new(const sd_model *model, volatile sig_atomic_t *stop) {
  ranks *r = memory_new(1, sizeof *r);
  *r = (ranks){
      .model = model, .stop = stop, .messages = sd_messages_new(), .collected = -1, .balance.excess = NAN};
  if (record_share_new(&r->rows, model, r->messages) == SD_OK &&
      resultants_new(&r->sums, model, r->messages) == SD_OK)
    return r;
  ranks_free(r);
  return NULL;
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

bool ranks_are_spread(const ranks *r) { return r->part.state != NULL; }

/* --- parts --------------------------------------------------------------------------------------------------- */

/* Collective. False: some rank could not. */
bool ranks_all_well(sd_status status) { return comm_or(status != SD_OK) == 0; }

/* made: disks of tiles at the start, whose contacts may be in a file. */
static sd_status take_part(ranks *r, const engine *from, bool made) {
  engine next = {.model = r->model, .pool = r->pool};
  sd_status status = move_parts(r->model, r->cuts, from, r->skin, &next.state, &next.halo);
  if (made && r->model->tiles.n_contacts > 0 && ranks_all_well(status))
    status = ranks_contacts_take(r->model, next.state, r->messages);
  if (status == SD_OK && from && !from->halo) state_release_rows(from->state);
  drop_part(r);
  r->part = next;
  if (status == SD_OK) status = engine_build(&r->part, r->threads, r->messages);
  /* together, or not at all: the others would wait */
  if (ranks_all_well(status) && halo_list_prescribed(&r->part) != SD_OK) status = SD_ERROR_IO;
  engine_ready(&r->part, r->messages);
  engine_end(&r->part, status);
  return status;
}

/* This rank's part of what `from` has (NULL: nothing). */
sd_status ranks_take_part(ranks *r, const engine *from) { return take_part(r, from, false); }

static sd_status tell_stored(ranks *r, sd_status status) {
  return status == SD_OK ? SD_OK : sd_fail(r->messages, SD_ERROR_IO, "out of memory for the contacts");
}

/* The part as a state that can be sent. */
sd_status ranks_store_part(ranks *r) {
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

/* Collective. */
static void note_balance(ranks *r) {
  const double mean = comm_total(r->busy) / comm_size(), disks = (double)r->part.state->n_free;
  r->balance.excess = mean > 0.0 ? comm_largest(r->busy) / mean - 1.0 : 0.0;
  r->balance.most = (int64_t)comm_largest(disks);
  r->balance.least = (int64_t)-comm_largest(-disks);
}

/* New lists, disks that have left the rectangle to their new ranks, new ghosts. */
static sd_status renew(ranks *r) {
  engine *e = &r->part;
  const int64_t step = e->state->step;
  sd_status status = neighbours_check_finite(e, step, r->messages);
  if (!ranks_all_well(status)) return status;
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
    if (!ranks_all_well(status)) return sd_fail(r->messages, SD_ERROR_IO, "cannot balance the ranks");
  }
  /* wider, until no disk or wall outruns the lists in one step; what is not finite outruns any */
  for (;;) {
    status = ranks_store_part(r);
    if (ranks_all_well(status)) status = ranks_take_part(r, &r->part);
    if (!ranks_all_well(status)) return status;
    if (!comm_or(engine_outruns(&r->part))) return SD_OK;
    status = neighbours_check_next(&r->part, r->messages);
    if (!ranks_all_well(status)) return status;
    if (!isfinite(r->skin))
      return sd_fail(r->messages, SD_ERROR_NUMERIC, "step %lld: a wall is not finite", (long long)step + 1);
    r->skin = fmax(1.5 * r->skin, comm_largest(engine_outrun_skin(&r->part)));
  }
}

/* --- steps ----------------------------------------------------------------------------------------------------- */

typedef struct advance_task {
  ranks *r;
  int64_t until;
  bool measure;
} advance_task;

/* A stop comes after one more step, which shows the forces, and whose rows are not there yet. */
static void advance_steps(const advance_task *a, const team *t) {
  ranks *r = a->r;
  engine *e = &r->part;
  const int64_t measured = e->state->measured, from = e->state->step;
  for (;;) {
    if (t->rank == 0) r->bits = step_agree(e, r->stop && *r->stop);
    team_wait(t);
    const int64_t step = e->state->step;
    if (r->bits & (HALO_STALE | HALO_FAILED) || step == a->until) return;
    if (r->bits & HALO_STOP && step + 1 < a->until) return;
    step_once(e, t);
    team_wait(t);
    if (!a->measure || engine_status(e) != SD_OK) continue;
    disks_step(e, t, measured + (step - from) + 1);
    if (t->rank == 0) sample_step(e);
    team_wait(t);
  }
}

static void advance_member(const team *t, void *with) {
  unsigned mode = subnormal_off();
  advance_steps(with, t);
  subnormal_restore(mode);
}

/* On every rank, n steps unless one fails or is to stop. */
static void advance(ranks *r, int64_t n, bool measure) {
  assert(ranks_are_spread(r));
  int64_t until = r->part.state->step + n;
  do {
    engine *e = &r->part;
    const double began = clock_seconds();
    e->halo->waited = 0.0;
    if (until > e->state->step) step_begin(e, until - e->state->step);
    pool_run(r->pool, advance_member, &(advance_task){r, until, measure});
    r->busy += clock_seconds() - began - e->halo->waited;
    if (r->bits & HALO_STALE && !(r->bits & HALO_FAILED)) {
      /* lists are for steps: at the end those of one rank alone are not made anew either */
      const int64_t step = r->part.state->step;
      const sd_status status = step < until ? renew(r) : neighbours_check_finite(&r->part, step, r->messages);
      engine_end(&r->part, status);
      if (!ranks_all_well(status)) r->bits |= HALO_FAILED;
    }
    const int64_t next = r->part.state->step + 1;
    if (r->bits & HALO_STOP && next < until) until = next;
  } while (!(r->bits & HALO_FAILED) && r->part.state->step < until);
}

static sd_status tell_failure(const ranks *r, sd_messages *messages) {
  return ranks_tell_failure(engine_status(&r->part), r->messages, messages);
}

/* --- rank 0 ------------------------------------------------------------------------------------------------------ */

/* tiles: each rank makes its own. */
static sd_status spread(ranks *r, const engine *whole, bool tiles) {
  engine made = {0};
  const engine *from = tiles ? &made : whole;
  double skin[1] = {whole ? engine_skin(whole) : 0.0};
  int64_t step[1] = {whole ? whole->state->step : 0};
  comm_share(skin, sizeof skin);
  comm_share(step, sizeof step);
  r->skin = skin[0];
  r->cut_step = step[0];
  r->busy = 0.0;
  if (!r->cuts) r->cuts = comm_cuts_new(); /* all ranks at once: rank 0 may have finished without */
  sd_status status = r->cuts ? SD_OK : SD_ERROR_IO;
  if (ranks_all_well(status) && tiles) status = ranks_tiles_new(r->model, whole, &made, r->messages);
  if (ranks_all_well(status)) status = move_first_cut(r->model, r->cuts, from);
  r->balance.cuts++;
  if (r->threads > 1 && !r->pool) r->pool = pool_new(r->threads);
  if (r->threads > 1 && !r->pool) status = SD_ERROR_IO;
  if (ranks_all_well(status))
    status = take_part(r, from, tiles);
  else if (status != SD_OK && sd_messages_count(r->messages) == 0)
    sd_fail(r->messages, SD_ERROR_IO, "cannot spread the disks over the ranks");
  ranks_tiles_free(&made);
  if (whole && tiles) state_release_rows(whole->state);
  if (!ranks_all_well(status)) r->bits = HALO_FAILED;
  engine_end(&r->part, status);
  return status;
}

static sd_status spread_whole(ranks *r, engine *whole, bool tiles, sd_messages *messages) {
  motion_store(whole);
  if (engine_has_lists(whole) && contacts_store(whole) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the contacts");
  r->threads = engine_threads(whole);
  say(SPREAD, r->threads, tiles);
  engine_drop_lists(whole);
  const sd_status status = spread(r, whole, tiles);
  return comm_or(status != SD_OK) ? tell_failure(r, messages) : SD_OK;
}

sd_status ranks_spread(ranks *r, engine *whole, sd_messages *messages) {
  return spread_whole(r, whole, false, messages);
}

/* Ends work that every rank has done, with its status. The whole (NULL on the other ranks) learns
 * what is no disk's and no contact's, or rank 0 why the work failed. */
static sd_status end_work(ranks *r, engine *whole, sd_status status, sd_messages *messages) {
  engine_end(&r->part, status);
  if (!ranks_all_well(status)) return tell_failure(r, messages);
  move_common(&r->part, whole ? whole->state : NULL);
  return SD_OK;
}

settle_measure ranks_rest(ranks *r, engine *whole) {
  say(SETTLE, 0, false);
  return ranks_rest_of(r, whole->state);
}

sd_status ranks_rain(ranks *r, engine *whole, sd_messages *messages) {
  say(RAIN, 0, false);
  return end_work(r, whole, ranks_release_rain(r), messages);
}

sd_status ranks_outside(ranks *r, engine *whole, sd_messages *messages) {
  say(OUTSIDE, 0, false);
  return end_work(r, whole, ranks_look_outside(r, messages), messages);
}

bool ranks_outside_is_due(ranks *r) {
  say(LOOK, 0, false);
  return comm_or(outside_is_due(&r->part)) != 0;
}

sd_status ranks_end_phase(ranks *r, engine *whole, sd_messages *messages) {
  say(END, whole->state->phase_step, false);
  if (!ranks_all_well(ranks_end_part(r, whole->state->phase_step))) return tell_failure(r, messages);
  whole->state->phase = r->part.state->phase;
  whole->state->phase_step = 0;
  r->collected = -1;
  move_common(&r->part, whole->state);
  return SD_OK;
}

sd_status ranks_start(ranks *r, engine *whole, bool measure, sd_messages *messages) {
  sd_status status = spread_whole(r, whole, r->model->tiles.away, messages);
  if (status != SD_OK) return status;
  double kept = 0.0;
  say(START, 0, measure);
  status = ranks_start_part(r, measure, &kept);
  engine_end(&r->part, status);
  if (!ranks_all_well(status)) return tell_failure(r, messages);
  advice_tell_overlap(r->model, &r->deepest, messages);
  engine_warn_of_dropped(r->model, (size_t)kept, messages);
  move_common(&r->part, whole->state);
  return SD_OK;
}

sd_status ranks_advance(ranks *r, engine *whole, int64_t n, bool measure, sd_messages *messages) {
  if (!ranks_are_spread(r)) {
    const sd_status status = ranks_spread(r, whole, messages);
    if (status != SD_OK) return status;
  }
  if (r->collected >= 0) state_release_rows(whole->state);
  r->collected = -1;
  say(ADVANCE, n, measure);
  advance(r, n, measure);
  whole->state->step = r->part.state->step;
  if (r->bits & HALO_STOP && r->stop) *r->stop = 1;
  if (!(r->bits & HALO_FAILED)) return SD_OK;
  engine_end(whole, tell_failure(r, messages));
  return engine_status(whole);
}

sd_status ranks_collect(ranks *r, engine *whole) {
  if (!ranks_are_spread(r) || r->collected == whole->state->step) return SD_OK;
  say(COLLECT, 0, false);
  sd_status status = ranks_store_part(r);
  if (!ranks_all_well(status)) return SD_ERROR_IO;
  status = move_together(&r->part, whole->state);
  if (status != SD_OK) return status;
  engine_find_slots(whole);
  r->collected = whole->state->step;
  return SD_OK;
}

sd_status ranks_center(ranks *r, engine *whole, sd_messages *messages) {
  if (!ranks_are_spread(r)) return SD_OK;
  if (ranks_collect(r, whole) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the whole state");
  const double skin = engine_skin(&r->part);
  engine_tell(whole, messages);
  say(DROP, 0, false);
  drop_part(r);
  r->collected = -1;
  if (r->model->tiles.away) return ranks_tiles_bring(whole, messages);
  engine_use_skin(whole, skin);
  return engine_make_lists(whole, messages);
}

sd_energy ranks_energy(ranks *r) {
  say(ENERGY, 0, false);
  return ranks_add_energies(r);
}

/* On every rank. */
static sd_status add_resultants(ranks *r, sd_messages *messages) {
  sd_status status = store_rows(r);
  if (ranks_all_well(status)) {
    resultants_take(&r->sums, r->model, r->part.state, engine_slots(&r->part), true, r->messages);
    return SD_OK;
  }
  engine_end(&r->part, status);
  return tell_failure(r, messages);
}

const resultants *ranks_resultants(ranks *r, sd_messages *messages) {
  say(SERIES, 0, false);
  return add_resultants(r, messages) == SD_OK ? &r->sums : NULL;
}

/* On every rank: writes its share of a checkpoint, or (rows) of a part. */
static sd_status write_share(ranks *r, bool rows, const char *whole, int64_t *seals, sd_messages *messages) {
  int64_t sum = 0;
  char *path = h5_share_path(whole, (size_t)comm_rank());
  sd_status status = rows ? SD_OK : ranks_store_part(r);
  if (ranks_all_well(status))
    status = rows ? record_share_seal(&r->rows, path, &sum, r->messages)
                  : ranks_write_share(&r->part, path, &sum, r->messages);
  free(path);
  if (ranks_all_well(status)) {
    ranks_gather_sums(sum, seals);
    return SD_OK;
  }
  checkpoint_remove_share(-1, whole, (size_t)comm_rank());
  engine_end(&r->part, status);
  return tell_failure(r, messages);
}

static void say_path(word w, const char *path) {
  const size_t length = strlen(path) + 1;
  say(w, (int64_t)length, false);
  comm_share((char *)(uintptr_t)path, length);
}

sd_status ranks_write(ranks *r, engine *whole, const char *path, int64_t *seals, summary_contacts *contacts,
                      summary_lost *lost, sd_messages *messages) {
  say_path(WRITE, path);
  const sd_status status = write_share(r, false, path, seals, messages);
  if (status == SD_OK) *contacts = ranks_add_contacts(&r->part);
  if (status == SD_OK) *lost = ranks_add_lost(&r->part);
  if (status == SD_OK) move_common(&r->part, whole->state);
  return status;
}

sd_status ranks_seal(ranks *r, const char *path, int64_t *seals, sd_messages *messages) {
  say_path(SEAL, path);
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
  if (ranks_all_well(status))
    status =
        ranks_sample_share(&r->part, (unsigned)s->what, s->frame, s->moment_number, &r->rows, r->messages);
  if (!ranks_all_well(status)) {
    engine_end(&r->part, status);
    return tell_failure(r, messages);
  }
  s->contacts = ranks_count_contacts(&r->part);
  s->bytes = (size_t)comm_total((double)record_share_bytes(&r->rows));
  return SD_OK;
}

sd_status ranks_sample(ranks *r, engine *whole, unsigned what, int64_t frame, int64_t moment_number,
                       size_t *n_contacts, size_t *bytes, sd_messages *messages) {
  sampling s = {.what = what, .frame = frame, .moment_number = moment_number};
  say(SAMPLE, 0, false);
  comm_share(&s, sizeof s);
  const sd_status status = sample(r, &s, messages);
  *n_contacts = s.contacts;
  *bytes = s.bytes;
  if (status == SD_OK) move_common(&r->part, whole->state);
  return status;
}

void ranks_dismiss(int status) {
  if (comm_size() > 1) say(DISMISS, status, false);
}

/* --- the others -------------------------------------------------------------------------------------------------- */

static void serve_write(ranks *r, bool rows, size_t length) {
  char *path = memory_new(length, 1);
  comm_share(path, length);
  if (write_share(r, rows, path, NULL, NULL) == SD_OK && !rows) {
    ranks_add_contacts(&r->part);
    ranks_add_lost(&r->part);
    move_common(&r->part, NULL);
  }
  free(path);
}

static void serve_sample(ranks *r) {
  sampling s = {0};
  comm_share(&s, sizeof s);
  if (sample(r, &s, NULL) == SD_OK) move_common(&r->part, NULL);
}

int ranks_serve(ranks *r) {
  for (;;) {
    order o = {0};
    comm_share(&o, sizeof o);
    switch ((word)o.word) {
      case SPREAD: {
        r->threads = (int)o.n;
        const sd_status status = spread(r, NULL, o.measure != 0);
        if (comm_or(status != SD_OK)) tell_failure(r, NULL);
        break;
      }
      case START: {
        double kept;
        end_work(r, NULL, ranks_start_part(r, o.measure != 0, &kept), NULL);
        break;
      }
      case SETTLE: ranks_rest_of(r, NULL); break;
      case RAIN: end_work(r, NULL, ranks_release_rain(r), NULL); break;
      case OUTSIDE: end_work(r, NULL, ranks_look_outside(r, NULL), NULL); break;
      case LOOK: comm_or(outside_is_due(&r->part)); break;
      case END:
        if (ranks_all_well(ranks_end_part(r, o.n)))
          move_common(&r->part, NULL);
        else
          tell_failure(r, NULL);
        break;
      case ADVANCE:
        advance(r, o.n, o.measure != 0);
        if (r->bits & HALO_FAILED) tell_failure(r, NULL);
        break;
      case COLLECT:
        if (ranks_all_well(ranks_store_part(r))) move_together(&r->part, NULL);
        break;
      case ENERGY: ranks_add_energies(r); break;
      case SERIES: add_resultants(r, NULL); break;
      case WRITE:
      case SEAL: serve_write(r, o.word == SEAL, (size_t)o.n); break;
      case SAMPLE: serve_sample(r); break;
      case DROP: drop_part(r); break;
      case DISMISS: return (int)o.n;
    }
  }
}

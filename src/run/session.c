/* session.c: the work of a session (a run with its files) between steps: sampling rows, writing
 * checkpoints, reporting progress, ending the run; see session.h. session_begin.c opens a session,
 * session_group.c has the loop over steps. */
#include "base/text.h"
#include "run/session.h"

#include <assert.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

#include "base/math.h"
#include "base/team.h"
#include "base/comm.h"
#include "base/memory.h"
#include "io/results/merge.h"
#include "io/store/file.h"
#include "measure/average.h"
#include "model/model.h"
#include "pack/rain.h"
#include "pack/settle.h"
#include "run/ranks_share.h"
#include "run/session_private.h"
#include "run/simulation_private.h"
#include "slipdisk/deck.h"

/* Limits of the wall time between two progress reports, s: at least PROGRESS_SECONDS, and at least
 * PROGRESS_COST times the duration of the last report (which goes over all disks), unless that is
 * more than PROGRESS_LATEST. */
static const double PROGRESS_SECONDS = 0.2, PROGRESS_COST = 50, PROGRESS_LATEST = 2;

/* --- Cadence ---------------------------------------------------------------------------------- */

/* Returns true if a row is due at step `offset` of the phase, as rows are sampled every `every`
 * steps; every = 0: never. */
static bool hits(int64_t every, int64_t offset) { return every > 0 && offset % every == 0; }

static unsigned phase_due(const sd_phase *phase, int64_t offset) {
  return (hits(phase->series_every, offset) ? RECORD_SERIES : 0u) |
         (hits(phase->frames_every, offset) ? RECORD_FRAMES : 0u) |
         (hits(phase->contacts_every, offset) ? RECORD_CONTACTS : 0u);
}

static bool is_over(const sd_model *model, sd_stage now) {
  return now.phase >= (int64_t)model->n_phases;
}

unsigned session_due(const sd_model *model, sd_stage now) {
  /* At the first and the last step of a run all rows are sampled. */
  if (now.step == 0 || is_over(model, now)) return RECORD_ALL;
  unsigned due = phase_due(&model->phases[now.phase], now.phase_step);
  /* The last step of a phase is also step 0 of the next phase: sample the rows that either phase
   * wants. */
  if (now.phase_step == 0 && now.phase > 0)
    due |= phase_due(&model->phases[now.phase - 1], now.before);
  return due;
}

/* Returns true if a row of the series ends an interval of a phase that measures. */
static bool ends_interval(const sd_model *model, sd_stage now) {
  const bool inside = now.phase_step > 0;
  const int64_t k = inside ? now.phase : now.phase - 1;
  return k >= 0 && model->phases[k].measure &&
         hits(model->phases[k].series_every, inside ? now.phase_step : now.before);
}

/* Returns the next multiple of `every` after `offset` if it is less than `best`, else `best`. */
static int64_t next_of(int64_t every, int64_t offset, int64_t best) {
  if (every <= 0) return best;
  int64_t next = (offset / every + 1) * every;
  return next < best ? next : best;
}

/* Returns true if the deck has a goal for its error bar (`until`) and the last phase is running. */
static bool has_goal(const sd_model *model, sd_stage now) {
  return model->until.asked && now.phase + 1 == (int64_t)model->n_phases;
}

int64_t session_next(const sd_model *model, sd_stage now) {
  assert(now.phase >= 0 && (size_t)now.phase < model->n_phases);
  const sd_phase *phase = &model->phases[now.phase];
  int64_t offset = now.phase_step;
  /* Stop at the steps at which the phase may end, since rows may be due there. */
  int64_t next = has_goal(model, now) ? sd_goal_look(model, offset) : phase->steps;
  if (phase->settle.asked) next = next_of(phase->settle.every, offset, next);
  next = next_of(phase->series_every, offset, next);
  next = next_of(phase->frames_every, offset, next);
  next = next_of(phase->contacts_every, offset, next);
  assert(next > offset);
  return now.step - offset + next;
}

/* Returns the step at which the run will end if no phase ends early. */
static int64_t most_steps(const sd_model *model, sd_stage now) {
  int64_t most = now.step - now.phase_step;
  for (size_t k = (size_t)now.phase; k < model->n_phases; k++) most += model->phases[k].steps;
  return most;
}

/* --- Writing parts and checkpoints ------------------------------------------------------------ */

bool session_leads(const session *s) { return comm_rank(s->options.comm) == 0; }

/* Ends a section in which only rank 0 works with files: returns the status of rank 0 on all
 * ranks. */
static sd_status agree(const session *s, sd_status status) {
  return comm_wait(s->options.comm, status);
}

static void remove_shares(const session *s, const char *path, size_t n) {
  for (size_t k = 0; k < n; k++) checkpoint_remove_share(s->parts_folder.at, path, k);
}

/* Writes rows from memory to the next part file of the run. rows: rows of rank 0. shared: true if
 * also each rank writes its rows to a file of its own (share of the part file). */
static sd_status seal_rows(session *s, record *rows, bool shared, const char *path,
                           sd_messages *messages) {
  const record_link link = {
      .run_id = s->origin.run_id, .number = s->parts + 1, .after = s->last_part};
  const size_t n = shared ? (size_t)comm_size(s->options.comm) : 0;
  int64_t *seals = memory_new(n, sizeof *seals);
  sd_status status = SD_OK;
  if (n > 0) status = ranks_seal(s->simulation->ranks, path, seals, messages);
  if (status == SD_OK && session_leads(s)) {
    status = record_seal(rows, s->parts_folder.at, path, &link, n, seals, &s->last_part, messages);
    if (status != SD_OK) remove_shares(s, path, n);
  }
  free(seals);
  return agree(s, status);
}

/* Returns the rows of rank 0 that are not yet written to a part file; NULL: there are none. */
static record *full_rows(session *s) {
  if (!record_empty(&s->shared) && !record_has_shares(&s->shared))
    record_take_series(&s->rows, &s->shared);
  return !record_empty(&s->shared) ? &s->shared : !record_empty(&s->rows) ? &s->rows : NULL;
}

/* Collective: writes the rows that are in memory to a part file, if there are any. */
static sd_status seal(session *s, sd_messages *messages) {
  record *rows = session_leads(s) ? full_rows(s) : NULL;
  /* broadcast from rank 0, so that all ranks write a part file or none */
  int32_t what[2] = {rows != NULL, rows == &s->shared};
  comm_broadcast(s->options.comm, what, sizeof what);
  if (!what[0]) return SD_OK;
  char *path = session_leads(s) ? folder_part(s->parts_folder.path, s->parts + 1) : NULL;
  sd_status status = agree(s, session_leads(s) ? folder_check(&s->parts_folder, messages) : SD_OK);
  if (status == SD_OK) status = seal_rows(s, rows, what[1] != 0, path, messages);
  if (status == SD_OK) s->parts++;
  if (status == SD_OK) s->shared_bytes = 0;
  free(path);
  return status;
}

static const sd_state *state_of(const session *s) {
  return simulation_engine(s->simulation)->state;
}

static sd_status collect_disks(session *s, sd_messages *messages) {
  return summary_disks_collect(&s->found.packing, s->model, state_of(s),
                               sd_simulation_threads(s->simulation), messages);
}

/* Updates summary and provenance of the run; the state must have been stored. Means of every disk
 * are computed only for few disks in one process; in other runs this is left until the result is
 * written. */
static sd_status describe(session *s, sd_messages *messages) {
  const sd_energy energy = sd_simulation_energy(s->simulation);
  const summary_sums all = ranks_summary_sums(simulation_engine(s->simulation));
  sd_status status = SD_OK;
  if (session_leads(s)) {
    const sd_state *state = state_of(s);
    double now = clock_seconds();
    s->origin.wall_seconds += now - s->wall_mark;
    s->wall_mark = now;
    double per_step = state->step > 0 ? 1e9 * s->origin.step_seconds / (double)state->step : NAN;
    summary_free(&s->found);
    summary_collect(&s->found, s->model, state, &all, &energy, per_step);
    if (!simulation_is_spread(s->simulation) && state->n_means < SUMMARY_LATER)
      status = collect_disks(s, messages);
    provenance_refresh(&s->origin, comm_size(s->options.comm), sd_simulation_threads(s->simulation),
                       sd_simulation_path(s->simulation));
  }
  status = agree(s, status);
  s->has_found = status == SD_OK;
  return status;
}

/* Writes the checkpoint file; in a run over several ranks the head, which names the files of the
 * ranks (shares). seals: [ranks] checksums of these files; NULL: there are none. */
static sd_status write_head(session *s, int64_t *seals, const char *path, sd_messages *messages) {
  const checkpoint_parts parts = {s->parts, s->last_part, s->replaces};
  const checkpoint_shares shares = {s->model, (size_t)comm_size(s->options.comm), seals,
                                    (size_t)s->found.contacts};
  const sd_status status = folder_check(&s->parts_folder, messages);
  if (status != SD_OK) return status;
  return checkpoint_write(s->parts_folder.at, path, state_of(s), &parts, seals ? &shares : NULL,
                          &s->origin, &s->found, messages);
}

/* Writes the stored state to a file in the folder of the run: in one process a single file; in a
 * run over several ranks first a file for each rank with its disks and contacts, then a head with
 * the rest. */
static sd_status write_state(session *s, const char *path, sd_messages *messages) {
  const bool leads = session_leads(s), shared = simulation_is_spread(s->simulation);
  const size_t n = shared ? (size_t)comm_size(s->options.comm) : 0;
  int64_t *seals = shared ? memory_new(n, sizeof *seals) : NULL;
  sd_status status = agree(s, leads ? folder_check(&s->parts_folder, messages) : SD_OK);
  if (status == SD_OK && shared) status = ranks_write(s->simulation->ranks, path, seals, messages);
  if (status == SD_OK) status = describe(s, messages);
  if (status == SD_OK) status = agree(s, leads ? write_head(s, seals, path, messages) : SD_OK);
  if (status != SD_OK && leads) remove_shares(s, path, n);
  free(seals);
  return status;
}

/* The part file is written before the checkpoint that counts it, and older checkpoints are removed
 * last: so the newest checkpoint on disk always has its part files. */
sd_status session_checkpoint(session *s, sd_messages *messages) {
  const bool leads = session_leads(s);
  const int64_t step = sd_simulation_step(s->simulation);
  sd_status status = simulation_store(s->simulation, false, messages);
  if (status != SD_OK) return status;
  char *path = leads ? folder_checkpoint(s->parts_folder.path, step) : NULL;
  status = seal(s, messages);
  if (status == SD_OK) status = write_state(s, path, messages);
  if (status == SD_OK) {
    s->saved_step = step;
    s->saved_at = clock_seconds();
    status = agree(s, leads ? folder_prune(&s->parts_folder, 2, messages) : SD_OK);
  }
  free(path);
  return status;
}

/* Removes the emergency file of an earlier attempt, and the files of its ranks, which may have been
 * more than now. */
static void drop_emergency(const session *s, const char *path) {
  bool there = true;
  file_remove(s->parts_folder.at, path);
  for (size_t k = 0; there; k++) {
    char *share = h5_share_path(path, k);
    there = file_exists(share);
    if (there) file_remove(s->parts_folder.at, share);
    free(share);
  }
}

/* Writes the state after a numerical error to an emergency file, for inspection; the good
 * checkpoints are not touched. */
static void keep_emergency(session *s, sd_messages *messages) {
  if (simulation_store(s->simulation, false, messages) != SD_OK) return;
  const int64_t step = sd_simulation_step(s->simulation);
  char *path = session_leads(s) ? folder_emergency(s->parts_folder.path, step) : NULL;
  if (path) drop_emergency(s, path);
  if (write_state(s, path, messages) == SD_OK && path)
    sd_warn(messages,
            "the state at step %" PRId64 " is kept as %s; the last good one is step %" PRId64, step,
            path, s->saved_step);
  free(path);
}

/* Adds the disks and contacts of each rank to the rows that this rank will write. */
static sd_status sample_shares(session *s, unsigned rows, sd_messages *messages) {
  record *r = &s->shared;
  return ranks_sample(s->simulation->ranks, rows, (int64_t)r->disks.n_rows,
                      (int64_t)r->contact_index.n_rows, &r->n_contacts, &s->shared_bytes, messages);
}

sd_status session_sample(session *s, unsigned what, sd_messages *messages) {
  if (what == 0) return SD_OK;
  const bool spread = simulation_is_spread(s->simulation);
  const unsigned rows = what & (RECORD_FRAMES | RECORD_CONTACTS);
  record_sums now = {0};
  sd_status status = simulation_store(s->simulation, true, messages);
  if (status == SD_OK && spread && rows) status = sample_shares(s, rows, messages);
  if (status != SD_OK) return status;
  if (what & RECORD_SERIES) {
    now.energy = sd_simulation_energy(s->simulation);
    if (spread && !(now.others = ranks_resultants(s->simulation->ranks, messages)))
      return SD_ERROR_IO;
  }
  record *r = spread ? &s->shared : &s->rows;
  if (session_leads(s))
    status = record_sample(r, what, state_of(s), simulation_slots(s->simulation), &now, messages);
  if (session_leads(s) && what & RECORD_SERIES && status == SD_OK) {
    sd_state *state = simulation_engine(s->simulation)->state;
    const moment row = {s->model, state, &now.energy, simulation_slots(s->simulation),
                        now.others ? now.others : &r->sums};
    average_sample(state, &row, ends_interval(s->model, sd_simulation_stage(s->simulation)));
  }
  return agree(s, status);
}

/* --- Progress --------------------------------------------------------------------------------- */

/* Predicts the step at which the run ends: the error bar falls as 1/sqrt(measured time), and the
 * goal for it is checked only at certain steps. */
static int64_t expected_end(const session *s, sd_stage now, const sd_goal *goal) {
  const sd_model *m = s->model;
  int64_t most = most_steps(m, now);
  if (!goal && m->until.asked && !is_over(m, now))
    return most - m->phases[m->n_phases - 1].steps + m->until.least;
  if (!goal || is_over(m, now)) return most;
  double ratio = goal->error / goal->goal;
  double more = goal->measured / m->dt * (ratio * ratio - 1);
  int64_t look = s->step - now.phase_step + sd_goal_look(m, now.phase_step);
  if (!(more < (double)(most - s->step))) return most; /* this is also the case if `more` is NAN */
  return s->step + (int64_t)more > look ? s->step + (int64_t)more : look;
}

/* Returns true if the running phase or a later one may end early, because it has settle
 * criteria. */
static bool may_settle(const sd_model *m, sd_stage now) {
  bool may = false;
  for (size_t k = (size_t)now.phase; k < m->n_phases; k++) may |= m->phases[k].settle.asked;
  return may;
}

static session_rest rest_of(const session *s, const sd_settle *asked) {
  settle_measure now = simulation_rest(s->simulation);
  return (session_rest){now.kinetic, asked->kinetic, now.unbalanced, asked->unbalanced};
}

void session_report(session *s, bool always) {
  double now = clock_seconds(), passed = now - s->told_at;
  sd_stage stage = sd_simulation_stage(s->simulation);
  bool finished = is_over(s->model, stage);
  bool new_phase = !finished && stage.phase != s->told_phase;
  int32_t tells = s->options.progress &&
                  (always || new_phase || passed >= math_max(PROGRESS_SECONDS, s->tell_every));
  comm_broadcast(s->options.comm, &tells, sizeof tells);
  if (!tells) return;

  /* the rate is averaged over about the last 3 seconds */
  if (passed > 0 && s->step > s->told_step) {
    double rate = (double)(s->step - s->told_step) / passed, weight = passed < 3 ? passed / 3 : 1;
    s->rate = s->rate > 0 ? s->rate + weight * (rate - s->rate) : rate;
  }
  sd_energy energy = sd_simulation_energy(s->simulation);
  const char *name = finished ? NULL : s->model->phases[stage.phase].name;
  bool asked = has_goal(s->model, stage) || (finished && s->model->until.asked);
  sd_goal goal = asked ? sd_simulation_goal(s->simulation) : (sd_goal){0};
  int64_t expected = expected_end(s, stage, asked ? &goal : NULL);
  const sd_settle *settle = finished ? NULL : &s->model->phases[stage.phase].settle;
  session_rest rest = settle && settle->asked ? rest_of(s, settle) : (session_rest){0};
  session_progress progress = {.step = s->step,
                               .steps = finished ? s->steps : most_steps(s->model, stage),
                               .expected = expected,
                               .time = (double)s->step * s->model->dt,
                               .phase = name ? name : "",
                               .new_phase = new_phase,
                               .rate = s->rate,
                               .seconds_left =
                                   s->rate > 0 ? (double)(expected - s->step) / s->rate : NAN,
                               .at_most = !finished && may_settle(s->model, stage),
                               .waiting = finished ? 0 : rain_waiting(s->model, state_of(s)),
                               .energy = &energy,
                               .goal = asked ? &goal : NULL,
                               .rest = settle && settle->asked ? &rest : NULL};
  if (s->options.progress) s->options.progress(s->options.user, &progress);
  s->told_at = now;
  s->tell_every = math_min(PROGRESS_COST * (clock_seconds() - now), PROGRESS_LATEST);
  s->told_step = s->step;
  if (!finished) s->told_phase = stage.phase;
}

/* --- Signals and clock ------------------------------------------------------------------------ */

bool session_is_stopped(const session *s) { return s->options.stop && *s->options.stop; }

void session_poll(session *s, int64_t chunk) {
  s->world = (session_signals){.chunk = chunk, .stopped = session_is_stopped(s)};
  if (session_leads(s))
    s->world.save = clock_seconds() - s->saved_at >= sd_model_deck(s->model)->checkpoint_seconds;
  comm_broadcast(s->options.comm, &s->world, sizeof s->world);
}

/* --- After a chunk of steps ------------------------------------------------------------------- */

sd_status session_stop(session *s, sd_messages *messages) {
  sd_status status = s->saved_step == s->step ? SD_OK : session_checkpoint(s, messages);
  return status == SD_OK ? SD_INTERRUPTED : status;
}

/* Collective: returns true if the rows in memory of all ranks together take more than
 * most_bytes. */
static bool is_full(session *s, size_t most_bytes) {
  int32_t full = session_leads(s) &&
                 record_bytes(&s->rows) + record_bytes(&s->shared) + s->shared_bytes > most_bytes;
  comm_broadcast(s->options.comm, &full, sizeof full);
  return full != 0;
}

sd_status session_step(session *s, sd_status status, size_t most_bytes, sd_messages *messages) {
  const unsigned due =
      status == SD_OK ? session_due(s->model, sd_simulation_stage(s->simulation)) : 0;
  if (status == SD_ERROR_NUMERIC) keep_emergency(s, messages);
  if (status == SD_OK) status = session_sample(s, due, messages);
  if (status == SD_OK && due && is_full(s, most_bytes)) status = seal(s, messages);
  if (status == SD_OK) session_report(s, false);
  if (status == SD_OK && s->options.look) s->options.look(s->options.user, s->simulation);
  return status;
}

/* Returns the run_id stored in a file, which the caller frees; NULL: it is no finished result, or
 * cannot be read. */
static char *finished_id(const char *result) {
  h5_file *file;
  if (h5_open(result, &file, NULL) != SD_OK) return NULL;
  char *id =
      checkpoint_get_parts(file) < 0 ? h5_get_attr_text(file, "/parameters", "run_id") : NULL;
  h5_close(file, NULL);
  return id;
}

sd_status session_identity(const session *s, char **id, sd_messages *messages) {
  struct stat facts;
  *id = NULL;
  if (lstat(s->result, &facts) != 0) {
    if (errno != ENOENT)
      return sd_fail(messages, SD_ERROR_IO, "cannot look at %s: %s", s->result, strerror(errno));
    *id = memory_text("");
    return SD_OK;
  }
  if (S_ISREG(facts.st_mode)) *id = finished_id(s->result);
  if (S_ISREG(facts.st_mode) && !*id) {
    /* A sound result may stand there, which only the disk keeps from being read. */
    if (file_read_through(s->result, messages) != SD_OK) return SD_ERROR_IO;
    if (shortage_seen()) return sd_fail(messages, SD_ERROR_IO, "no memory to read %s", s->result);
    *id = finished_id(s->result);
  }
  if (!*id)
    *id = format_text("%lld bytes of %lld.%09ld", (long long)facts.st_size,
                      (long long)facts.st_mtim.tv_sec, facts.st_mtim.tv_nsec);
  return SD_OK;
}

sd_status session_may_publish(const session *s, sd_status kind, sd_messages *messages) {
  char *there;
  if (session_identity(s, &there, messages) != SD_OK) return SD_ERROR_IO;
  assert(there);
  bool may = !*there || strcmp(there, s->replaces) == 0;
  free(there);
  if (may) return SD_OK;
  return sd_fail(messages, kind,
                 "%s has appeared, or was changed, since this run was started: it is not "
                 "overwritten. Move it away, "
                 "and the same command goes on; or start over with --force",
                 s->result);
}

static sd_status merge_from(session *s, const sd_state *state, const h5_file *checkpoint,
                            sd_messages *messages) {
  const merge_job job = {.result = s->options.result,
                         .how = *s->replaces ? FILE_REPLACE : FILE_KEEP,
                         .folder = &s->parts_folder,
                         .parts = s->parts,
                         .layout = &s->rows,
                         .model = s->model,
                         .state = state,
                         .checkpoint = checkpoint,
                         .origin = &s->origin,
                         .found = &s->found,
                         .stop = s->options.stop};
  return merge_parts(&job, messages);
}

/* Merges the part files of a run over several ranks into the result. The final state is read from
 * the last checkpoint, since no rank has it in memory. */
static sd_status merge_spread(session *s, sd_messages *messages) {
  char *path = folder_checkpoint(s->parts_folder.path, s->saved_step);
  h5_file *file = NULL;
  sd_status status = h5_open_sealed(s->parts_folder.at, path, &file, NULL, messages);
  if (status == SD_OK && s->found.packing.n > 0)
    status = checkpoint_collect_disks(file, s->model, &s->found.packing,
                                      sd_simulation_threads(s->simulation), messages);
  if (status == SD_OK) status = merge_from(s, NULL, file, messages);
  h5_close(file, NULL);
  free(path);
  return status;
}

/* Merges the part files of a run in one process into the result. The final state is in memory. */
static sd_status merge_here(session *s, sd_messages *messages) {
  sd_status status = SD_OK;
  if (s->found.packing.n > 0 && !s->found.packing.disks) status = collect_disks(s, messages);
  return status == SD_OK ? merge_from(s, state_of(s), NULL, messages) : status;
}

/* Collective: merges the part files into the result. The last checkpoint has the final state, so
 * that after an interruption only the merge has to be repeated. */
static sd_status merge(session *s, sd_messages *messages) {
  /* Never write a second checkpoint of the same step: the files of its ranks would replace those
   * that the first one names. */
  sd_status status = s->saved_step == s->step ? SD_OK : session_checkpoint(s, messages);
  if (status == SD_OK)
    status = agree(s, session_leads(s) ? session_may_publish(s, SD_ERROR_IO, messages) : SD_OK);
  if (status == SD_OK) status = simulation_store(s->simulation, false, messages);
  /* If the session was opened after the last step, its summary is not computed yet. */
  if (status == SD_OK && !s->has_found) status = describe(s, messages);
  if (status == SD_OK && session_leads(s))
    status =
        simulation_is_spread(s->simulation) ? merge_spread(s, messages) : merge_here(s, messages);
  status = agree(s, status);
  if (status == SD_OK)
    status = agree(s, session_leads(s) ? folder_remove(&s->parts_folder, messages) : SD_OK);
  return status;
}

/* Warns if a run has ended without reaching the goal for its error bar (`until`); the result is
 * complete all the same. */
static void warn_of_goal(const session *s, sd_messages *messages) {
  const summary *f = &s->found;
  if (!f->has_until || f->until_step >= 0) return;
  if (!isfinite(f->goal.error))
    sd_warn(
        messages,
        "max_time came before the goal of until: the record of %s is too short for an error bar",
        f->observable);
  else
    sd_warn(
        messages,
        "max_time came before the goal of until: the error bar of %s is %.3g%s, asked for is %.3g",
        f->observable, f->goal.error, f->goal.converged ? "" : " and not reliable", f->goal.goal);
}

/* Appends a text such as "; kinetic energy per disk 1e-3, asked for is 1e-6" if there is a goal
 * that was not reached. Returns the length of the text. */
static int tell_goal(char *text, size_t size, const char *what, double value, double goal,
                     bool missed) {
  if (!(goal > 0.0) || !missed) return 0;
  return snprintf(text, size, "; %s %.3g, asked for is %.3g", what, value, goal);
}

/* Warns of phases that ended without reaching their goals, and of disks that rain has not
 * released. */
static void warn_of_phases(const session *s, sd_messages *messages) {
  const summary *f = &s->found;
  for (size_t k = 0; k < f->n_stages; k++) {
    const summary_phase *p = &f->stages[k];
    if (!p->asked || p->reached) continue;
    char text[400] = "";
    size_t n = 0;
    n += (size_t)tell_goal(text + n, sizeof text - n, "kinetic energy per disk", p->kinetic,
                           p->kinetic_goal, p->kinetic > p->kinetic_goal);
    n += (size_t)tell_goal(text + n, sizeof text - n, "unbalanced force", p->unbalanced,
                           p->unbalanced_goal, p->unbalanced > p->unbalanced_goal);
    const sd_compress *c = &s->model->phases[k].compress;
    tell_goal(text + n, sizeof text - n, c->pressure > 0.0 ? "pressure" : "packing fraction",
              p->target, p->target_goal,
              fabs(p->target - p->target_goal) > c->tolerance * p->target_goal);
    sd_warn(messages, "phase \"%s\" has ended after %s%" PRId64 " steps and is not %s%s%s",
            f->stage_names[k], p->steps == p->most ? "all its " : "", p->steps,
            p->asked & SUMMARY_SETTLE ? "at rest" : "at its target", text,
            p->asked & SUMMARY_SETTLE && !s->model->phases[k].relax
                ? "; a longer phase is needed, or one more with relax = true"
                : "");
  }
  if (f->waiting > 0)
    sd_warn(messages, "the run is over and %" PRId64 " disks still wait for their rain",
            f->waiting);
}

sd_status session_finish(session *s, sd_messages *messages) {
  session_report(s, true);
  sd_status status = merge(s, messages);
  if (status != SD_OK || !session_leads(s)) return status;
  warn_of_goal(s, messages);
  warn_of_phases(s, messages);
  return SD_OK;
}

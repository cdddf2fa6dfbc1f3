/* session_group.c: the loop over steps of one session (run with its files), or of several side by
 * side; see session.h. */
#include "run/session.h"

#include <assert.h>
#include <inttypes.h>
#include <stdlib.h>

#include "base/team.h"
#include "base/memory.h"
#include "run/ensemble.h"
#include "run/session_private.h"

/* Approximate wall time in s of the chunks of steps between which signals are checked and progress
 * is reported. */
static const double CHUNK_SECONDS = 0.05;

/* Sessions that run side by side; arrays have an element for each session that still runs. */
typedef struct group {
  session_member *members; /* members as given by the caller */
  size_t n;                /* number of members that still run */
  size_t *which;           /* [n] index into `members` of each member that still runs */
  sd_simulation **simulations;
  sd_messages **messages;
  sd_status *status;
  bool *waits;     /* [n] true if the member waits until others have caught up */
  ensemble *lanes; /* SIMD lanes for the systems; NULL: they are advanced one by one */
  int64_t chunk;
  size_t most_bytes; /* largest number of bytes of rows that each member may have in memory */
  session_left *left;
  void *user;
} group;

static session *session_of(const group *g, size_t k) { return g->members[g->which[k]].session; }

/* Returns true if running member number k has failed, is finished or is to stop. */
static bool is_leaving(const group *g, size_t k) {
  const session *s = session_of(g, k);
  return g->status[k] != SD_OK || sd_simulation_finished(s->simulation) || s->world.stopped;
}

/* Ends a member: merges the part files of a finished run, or stops the run at a checkpoint; does
 * neither if it has failed. */
static void leave(group *g, size_t member, sd_status status) {
  session_member *m = &g->members[member];
  session *s = m->session;
  if (status == SD_OK && !s->was_finished)
    status = sd_simulation_finished(s->simulation) ? session_finish(s, m->messages)
                                                   : session_stop(s, m->messages);
  if (status == SD_ERROR_IO && session_leads(s) && s->saved_step >= 0 &&
      folder_check(&s->parts_folder, NULL) == SD_OK)
    sd_fail(m->messages, SD_ERROR_IO,
            "files that were written before are left as they were: with them the run can continue "
            "from step "
            "%" PRId64,
            s->saved_step);
  m->status = status;
  if (g->left) g->left(g->user, member);
}

static void put_in_lanes(group *g) {
  if (g->n > 1) g->lanes = ensemble_new(g->n, g->simulations);
}

/* Ends the members that have failed, finished or are to stop, and makes new SIMD lanes for the
 * others. */
static void sort_out(group *g) {
  size_t first = 0, kept = 0;
  while (first < g->n && !is_leaving(g, first)) first++;
  if (first == g->n) return;
  ensemble_free(g->lanes);
  g->lanes = NULL;
  for (size_t k = 0; k < g->n; k++) {
    if (is_leaving(g, k)) {
      leave(g, g->which[k], g->status[k]);
      continue;
    }
    g->which[kept] = g->which[k];
    g->simulations[kept] = g->simulations[k];
    g->messages[kept] = g->messages[k];
    g->status[kept++] = SD_OK;
  }
  g->n = kept;
  put_in_lanes(g);
}

/* Returns true if stage a comes before stage b. */
static bool is_behind(sd_stage a, sd_stage b) {
  return a.phase < b.phase || (a.phase == b.phase && a.phase_step < b.phase_step);
}

static sd_stage stage_of(const group *g, size_t k) {
  return sd_simulation_stage(g->simulations[k]);
}

/* Chooses the members that take the next chunk of steps: those that are furthest behind. The others
 * wait, since systems must be at the same step of the same phase to share SIMD lanes, and a few
 * systems in lanes take as long as many. Returns the number of members that go; steps: receives the
 * number of steps until rows may be due for one of them, or until they catch up with another
 * member. */
static size_t find_going(group *g, int64_t *steps) {
  sd_stage last = stage_of(g, 0);
  size_t going = 0;
  for (size_t k = 1; k < g->n; k++)
    if (is_behind(stage_of(g, k), last)) last = stage_of(g, k);
  *steps = g->chunk;
  for (size_t k = 0; k < g->n; k++) {
    const session *s = session_of(g, k);
    sd_stage now = stage_of(g, k);
    g->waits[k] = is_behind(last, now);
    int64_t next =
        g->waits[k] ? now.phase_step - last.phase_step : session_next(s->model, now) - s->step;
    if (now.phase == last.phase && next < *steps) *steps = next;
    going += !g->waits[k];
  }
  return going;
}

/* Advances by one chunk of steps, and adapts the length of the next chunk to the measured speed. */
static void advance(group *g) {
  int64_t n;
  size_t going = find_going(g, &n);
  /* ensemble_advance skips members whose status is not SD_OK */
  for (size_t k = 0; k < g->n; k++)
    if (g->waits[k]) g->status[k] = SD_INTERRUPTED;
  assert(n > 0 && going > 0);
  double start = clock_seconds();
  if (g->lanes)
    ensemble_advance(g->lanes, n, g->status, g->messages);
  else
    for (size_t k = 0; k < g->n; k++)
      if (!g->waits[k]) g->status[k] = sd_simulation_advance(g->simulations[k], n, g->messages[k]);
  double took = clock_seconds() - start;
  for (size_t k = 0; k < g->n; k++) {
    session *s = session_of(g, k);
    if (g->waits[k]) {
      g->status[k] = SD_OK;
      continue;
    }
    s->origin.step_seconds += took / (double)going;
    if (g->status[k] == SD_OK) s->step = sd_simulation_step(s->simulation);
    g->status[k] = session_step(s, g->status[k], g->most_bytes, g->messages[k]);
  }
  if (took > 2 * CHUNK_SECONDS && g->chunk > 1)
    g->chunk = g->chunk / 2;
  else if (took < CHUNK_SECONDS / 2 && n == g->chunk && g->chunk < INT64_MAX / 4)
    g->chunk *= 2;
}

static bool can_be_saved(const group *g, size_t k) {
  const session *s = session_of(g, k);
  return g->status[k] == SD_OK && s->saved_step != s->step &&
         !sd_simulation_finished(s->simulation);
}

/* Writes checkpoints of all members as soon as one of them is due, so that after a kill all
 * continue from the same step. */
static void save(group *g) {
  bool due = false;
  for (size_t k = 0; k < g->n; k++)
    due = due || (can_be_saved(g, k) && session_of(g, k)->world.save);
  if (!due) return;
  for (size_t k = 0; k < g->n; k++)
    if (can_be_saved(g, k)) g->status[k] = session_checkpoint(session_of(g, k), g->messages[k]);
  /* The time taken by these checkpoints does not count towards the interval until the next ones. */
  for (size_t k = 0; k < g->n; k++) session_of(g, k)->saved_at = clock_seconds();
}

/* Checks signals and the clock on rank 0, and broadcasts the outcome. */
static void look(group *g) {
  for (size_t k = 0; k < g->n; k++) {
    session_poll(session_of(g, k), g->chunk);
    if (session_of(g, k)->options.comm) g->chunk = session_of(g, k)->world.chunk;
  }
}

/* Adds a session to the group; if it has no work left, ends it at once. */
static void enter(group *g, size_t member) {
  session_member *m = &g->members[member];
  session *s = m->session;
  if (s->was_finished) {
    leave(g, member, SD_OK);
    return;
  }
  s->told_at = clock_seconds();
  session_report(s, true);
  g->which[g->n] = member;
  g->simulations[g->n] = s->simulation;
  g->messages[g->n] = m->messages;
  g->status[g->n++] = SD_OK;
}

static void run_group(group *g, size_t n) {
  for (size_t k = 0; k < n; k++) enter(g, k);
  put_in_lanes(g);
  while (look(g), sort_out(g), g->n > 0) {
    advance(g);
    save(g);
  }
}

void session_group_run(size_t n, session_member *members, session_left *left, void *user) {
  group g = {.members = members,
             .which = memory_new(n, sizeof *g.which),
             .simulations = memory_new(n, sizeof *g.simulations),
             .messages = memory_new(n, sizeof *g.messages),
             .status = memory_new(n, sizeof *g.status),
             .waits = memory_new(n, sizeof *g.waits),
             .chunk = 1,
             .most_bytes = SESSION_ROWS_BYTES / (n > 0 ? n : 1),
             .left = left,
             .user = user};
  run_group(&g, n);
  ensemble_free(g.lanes);
  free(g.which);
  free(g.simulations);
  free(g.messages);
  free(g.status);
  free(g.waits);
}

sd_status session_run(session *s, sd_messages *messages) {
  session_member alone = {.session = s, .messages = messages};
  session_group_run(1, &alone, NULL, NULL);
  return alone.status;
}

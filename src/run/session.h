/* session.h: a run in one process, or the part of one rank in a run of several: from a deck, or
 * from the last checkpoint, to the finished result.
 *
 * A run that was stopped or killed continues from its last checkpoint. The result does not
 * depend on how often that happened, because rows are sampled at steps that the deck fixes, and
 * because sampling, sealing and checkpoints only read the state. A session prints nothing: it
 * reports progress to a function of the caller. */
#ifndef SLIPDISK_RUN_SESSION_H
#define SLIPDISK_RUN_SESSION_H

#include <signal.h>

#include "base/comm.h"
#include "io/results/provenance.h"
#include "io/results/summary.h"
#include "slipdisk/simulation.h"

typedef struct session session;
struct ranks; /* see run/ranks.h */

/* Distance of a phase from rest: the measured values, and their goals; 0: no goal. */
typedef struct session_rest {
  double kinetic, kinetic_goal, unbalanced, unbalanced_goal;
} session_rest;

/* Progress of a run at one time. */
typedef struct session_progress {
  /* steps done, and the largest number of steps: phases may end early by settle and until */
  int64_t step, steps;
  int64_t expected;    /* predicted number of steps at the end of the run */
  double time;         /* simulated time */
  const char *phase;   /* name of the running phase; "": it has none, or the run is finished */
  bool new_phase;      /* true in the first report of this phase */
  double rate;         /* recent number of steps per second of wall time; 0: not known yet */
  double seconds_left; /* remaining wall time, s; NAN: not known */
  /* true if a phase may settle early, so that percentages and times are upper bounds */
  bool at_most;
  int64_t waiting; /* disks that rain has not released; until then steps are cheaper than later */
  const sd_energy *energy;
  const sd_goal *goal;      /* goal of `until`; NULL: none, or the last phase has not begun */
  const session_rest *rest; /* rest of the running phase; NULL: the phase has no settle criteria */
} session_progress;

/* Rows are sealed into a part once they take more bytes than this, so that memory is bounded for
 * any cadence. */
enum { SESSION_ROWS_BYTES = 64 << 20 };

typedef struct session_options {
  const char *result; /* path of the result file */
  int threads;        /* number of threads; 0: chosen from the size of the system */
  /* true: start over and discard an unfinished run; an old result stays until the new one replaces
   * it */
  bool force;
  /* the run stops at a checkpoint once this is nonzero on any rank; may be NULL */
  volatile sig_atomic_t *stop;
  /* ranks that share the disks and all run this session; NULL: one process has all disks */
  const comm *comm;
  /* called about 5 times a second; may be NULL */
  void (*progress)(void *user, const session_progress *progress);
  /* called between chunks of steps; may only read the simulation; may be NULL */
  void (*look)(void *user, sd_simulation *simulation);
  void *user;
} session_options;

/* Opens the run: checks for an existing result or checkpoint, locks its folder, and makes the
 * simulation. The model must outlive the session. SD_ERROR_USER: the result is finished already,
 * belongs to another deck (the message lists the lines that differ), or is being written by another
 * process. SD_INTERRUPTED: stopped before its first checkpoint; no file is left. */
sd_status session_open(const sd_model *model, const session_options *options, session **out,
                       sd_messages *messages);
/* Runs to the end and merges the parts; warns if the goal of `until` was not met. SD_INTERRUPTED:
 * stopped at a checkpoint. SD_ERROR_NUMERIC: the state is kept as emergency-<step>.h5. SD_ERROR_IO:
 * the last checkpoint is still good. In all three cases a new session continues the run. For
 * several sessions at once see session_group_run. */
sd_status session_run(session *s, sd_messages *messages);
void session_close(session *s);

/* Returns the step at which this session began. */
int64_t session_began(const session *s);
/* Returns the step of its last checkpoint; negative: none. */
int64_t session_saved(const session *s);
/* Returns true if the run was finished before and only its parts were left: session_run has nothing
 * to do. */
bool session_was_finished(const session *s);
/* Returns the summary of the last checkpoint; NULL before the first. */
const summary *session_summary(const session *s);
const provenance *session_provenance(const session *s);
/* Returns the ranks that share the steps; NULL: one process takes them all. */
const struct ranks *session_ranks(const session *s);

/* --- Groups: sessions that run side by side in one process ------------------------------------ */

/* Member of a group. The systems of a group go in lanes where possible (ensemble.h).
 *
 * Each session has its own lock, parts, checkpoints, progress and end, and makes the same
 * result, bit for bit, as it would alone: its due steps depend only on its own steps. So the
 * sessions of a group that was stopped or killed may continue alone or in other groups, and vice
 * versa.
 *
 * Members that are behind in the same phases go first, until all can go side by side;
 * checkpoints of all members are written together.
 *
 * Time: the wall time of steps is divided equally among the sessions that took them. That is the
 * step_seconds of each, so the sum over sessions is the cost of their steps. */
typedef struct session_member {
  session *session;      /* session; with one thread if the group has several members */
  sd_messages *messages; /* messages of this session */
  sd_status status;      /* status as session_run returns it, set when the session has ended */
} session_member;

/* Called when a member has ended, for any reason; it may close the member's session. */
typedef void session_left(void *user, size_t member);

/* Runs all members to their ends, each as session_run does. A member that finishes is merged at
 * once, one that fails leaves the group; the others continue. left: may be NULL. */
void session_group_run(size_t n, session_member *members, session_left *left, void *user);

#endif

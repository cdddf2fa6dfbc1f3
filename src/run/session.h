/* session.h: a run with its files, from a deck or from the last checkpoint to the finished result;
 * in one process, or on each of several ranks.
 *
 * A run that was stopped or killed continues from its last checkpoint. The result does not depend
 * on how often that happened, because rows are sampled at steps that the deck determines, and
 * because sampling and writing files only read the state. A session prints nothing: it reports
 * progress to a function of the caller. */
#ifndef SLIPDISK_RUN_SESSION_H
#define SLIPDISK_RUN_SESSION_H

#include <signal.h>

#include "base/comm.h"
#include "io/results/provenance.h"
#include "io/results/summary.h"
#include "slipdisk/simulation.h"

typedef struct session session;
struct ranks; /* ranks that share a simulation, see run/ranks.h */

/* Distance of a phase from rest: the measured values, and the goals for them; goal 0: no goal. */
typedef struct session_rest {
  double kinetic, kinetic_goal, unbalanced, unbalanced_goal;
} session_rest;

/* Progress of a run, for a report. */
typedef struct session_progress {
  /* number of steps done; largest number of steps of the run, as phases may end early by `settle`
   * and `until` */
  int64_t step, steps;
  int64_t expected; /* predicted number of steps at the end of the run */
  double time;      /* simulated time */
  /* name of the running phase; "": the phase has no name, or the run is finished */
  const char *phase;
  bool new_phase;      /* true in the first report of this phase */
  double rate;         /* recent number of steps per second of wall time; 0: not known yet */
  double seconds_left; /* remaining wall time, s; NAN: not known */
  /* true: a phase may settle early, so that percentages and times are upper bounds */
  bool at_most;
  /* number of disks that rain has not released yet; steps take longer with every released disk */
  int64_t waiting;
  const sd_energy *energy;
  /* goal for the error bar (`until`); NULL: none, or the last phase has not begun */
  const sd_goal *goal;
  /* distance of the running phase from rest; NULL: the phase has no settle criteria */
  const session_rest *rest;
} session_progress;

/* Bytes of rows in memory above which they are written to a part file. It bounds the memory however
 * often rows are sampled. */
enum { SESSION_ROWS_BYTES = 64 << 20 };

typedef struct session_options {
  const char *result; /* path of the result file */
  int threads;        /* number of threads; 0: chosen from the size of the system */
  /* true: start the run again and discard an unfinished one; an old result stays until the new one
   * replaces it */
  bool force;
  /* the run stops at a checkpoint once this is nonzero on any rank; NULL: it is never stopped */
  volatile sig_atomic_t *stop;
  /* ranks that share the disks, each of which runs this session; NULL: one process has all disks */
  const comm *comm;
  /* called about 5 times a second with the progress; may be NULL */
  void (*progress)(void *user, const session_progress *progress);
  /* called every few steps; may only read the simulation; may be NULL */
  void (*look)(void *user, sd_simulation *simulation);
  void *user;
} session_options;

/* Opens a run: checks for an existing result or checkpoint, locks the folder of the run, and makes
 * the simulation. The model must outlive the session. SD_ERROR_USER: the result is finished
 * already, belongs to another deck (the message lists the lines that differ), or is being written
 * by another process. SD_INTERRUPTED: stopped before the first checkpoint; no file is left. */
sd_status session_open(const sd_model *model, const session_options *options, session **out,
                       sd_messages *messages);
/* Runs to the end and merges the part files into the result; warns if the goal for the error bar
 * (`until`) was not reached. SD_INTERRUPTED: stopped at a checkpoint. SD_ERROR_NUMERIC: the state
 * is kept in emergency-<step>.h5. SD_ERROR_IO: the last checkpoint is still good. In these three
 * cases a new session continues the run. To run several sessions at once see session_group_run. */
sd_status session_run(session *s, sd_messages *messages);
void session_close(session *s);

/* Returns the step at which this session began, 0 or that of a checkpoint. */
int64_t session_began(const session *s);
/* Returns the step of the session's last checkpoint; negative: none. */
int64_t session_saved(const session *s);
/* Returns true if the run was finished before and only its folder of part files was left:
 * session_run then has no work to do. */
bool session_was_finished(const session *s);
/* Returns the summary of the run at its last checkpoint; NULL before the first. */
const summary *session_summary(const session *s);
const provenance *session_provenance(const session *s);
/* Returns the ranks that share the simulation; NULL: one process has all disks. */
const struct ranks *session_ranks(const session *s);

/* --- Groups: sessions that run side by side in one process ------------------------------------ */

/* Member of a group of sessions (runs). The systems of a group share SIMD lanes where possible
 * (ensemble.h).
 *
 * Each session has its own lock, part files, checkpoints, progress and end, and makes the same
 * result, bit for bit, as it would alone, since the steps at which rows are due depend only on its
 * own steps. So the sessions of a group that was stopped or killed may continue alone or in other
 * groups, and vice versa.
 *
 * Members that are behind in the same phases go first, until all can go side by side; checkpoints
 * of all members are written at the same time.
 *
 * The wall time of steps is divided equally among the sessions that took them, as step_seconds of
 * each, so that the sum over sessions is the cost of their steps. */
typedef struct session_member {
  /* session of the member; it must have one thread if the group has several members */
  session *session;
  sd_messages *messages; /* messages of this session */
  /* status of the member as session_run would return it, set when its session has ended */
  sd_status status;
} session_member;

/* Called when a member has ended, for any reason; it may close the member's session. */
typedef void session_left(void *user, size_t member);

/* Runs all members to their ends, each in the way of session_run. A member that finishes is merged
 * at once, and a member that fails leaves the group; the others continue. left: may be NULL. */
void session_group_run(size_t n, session_member *members, session_left *left, void *user);

#endif

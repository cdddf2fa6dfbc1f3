/* session.h: one process's share in a run: from a deck, or from the last checkpoint, to the finished result.
 *
 * A run that was stopped or killed continues where its last checkpoint stands; what comes out does not depend
 * on how often that happened, because rows are taken at steps that the deck fixes, and because sampling,
 * sealing and checkpoints only read the state. Nothing is printed: progress goes to a function of the caller's.
 */
#ifndef SLIPDISK_RUN_SESSION_H
#define SLIPDISK_RUN_SESSION_H

#include <signal.h>

#include "base/comm.h"
#include "io/results/provenance.h"
#include "io/results/summary.h"
#include "slipdisk/simulation.h"

typedef struct session session;
struct ranks; /* run/ranks.h */

/* How near a phase is to the rest that it asks for; goals are 0 where nothing is asked. */
typedef struct session_rest {
  double kinetic, kinetic_goal, unbalanced, unbalanced_goal;
} session_rest;

typedef struct session_progress {
  int64_t step,
      steps;        /* done, and the most that there can be: phases end early by settle and until */
  int64_t expected; /* steps at which the run will probably end */
  double time;      /* of the model */
  const char *phase;   /* name; "" when finished */
  bool new_phase;      /* first report of this phase */
  double rate;         /* steps per second of wall time, lately; 0: not known yet */
  double seconds_left; /* of wall time; NAN: not known */
  bool at_most; /* a phase from here on may settle earlier: percentages and times are bounds */
  int64_t
      waiting; /* disks that have not begun to fall; steps are still cheaper than they will be */
  const sd_energy *energy;
  const sd_goal *goal;      /* of `until`; NULL: none, or the last phase has not begun */
  const session_rest *rest; /* of the present phase; NULL: it does not settle */
} session_progress;

/* Rows beyond these bytes are sealed at once: memory stays bounded whatever the cadence. */
enum { SESSION_ROWS_BYTES = 64 << 20 };

typedef struct session_options {
  const char *result; /* path of the file to be made */
  int threads;        /* 0: chosen from the system's size */
  bool force; /* start over, whatever is there; an old result stays until the new one replaces it */
  /* may be NULL; when it becomes true, on any rank, the run stops at a checkpoint */
  volatile sig_atomic_t *stop;
  /* its ranks share the disks, and all run this session; NULL: one process has them */
  const comm *comm;
  void (*progress)(void *user,
                   const session_progress *progress); /* may be NULL; about 5 times a second */
  void (*look)(void *user,
               sd_simulation *simulation); /* may be NULL; between pieces of steps; reads only */
  void *user;
} session_options;

/* Finds out what is there, locks it, and gets ready to run. The model must outlive the session.
 * SD_ERROR_USER: the result is finished already, belongs to another deck (the message lists the lines that
 * differ), or is being written by another process. SD_INTERRUPTED: stopped before its first checkpoint, nothing is left. */
sd_status session_open(const sd_model *model, const session_options *options, session **out,
                       sd_messages *messages);
/* Runs to the end and merges; warns when `until` had to be given up. SD_INTERRUPTED: stopped at a checkpoint;
 * SD_ERROR_NUMERIC: the state is kept as emergency-<step>.h5; SD_ERROR_IO: the last checkpoint is still good. In all
 * three a new session continues. Several at once: session_group.c. */
sd_status session_run(session *s, sd_messages *messages);
void session_close(session *s);

int64_t session_began(const session *s); /* step at which this session began */
int64_t session_saved(const session *s); /* step of its last checkpoint; negative: there is none */
bool session_was_finished(
    const session *s); /* only left-overs were there: session_run has nothing to do */
const summary *
session_summary(const session *s); /* as of the last checkpoint; NULL before the first */
const provenance *session_provenance(const session *s);
/* How the ranks of the job shared the steps; NULL: one process made them. */
const struct ranks *session_ranks(const session *s);

/* Sessions that run side by side in one process, their systems in lanes where they can be
 * (ensemble.h).
 *
 * Each is a session like any other, with its own lock, parts, checkpoints, progress and end, and makes the result that
 * it would make alone, bit for bit: what is due of a session depends on its own steps only. So sessions of a
 * group that was stopped or killed may go on alone, or in other groups, and the other way round.
 *
 * Those who are behind in the same phases go first, until all can go side by side; checkpoints are written of all
 * together.
 *
 * Time: the wall time of steps is shared equally among those who took them. That is the step_seconds of each, so
 * the sum over sessions is what their steps have cost.
 */

typedef struct session_member {
  session *session;      /* of one thread, when there are several */
  sd_messages *messages; /* its own */
  sd_status status;      /* as of session_run, when it has left */
} session_member;

/* Told when a member has come to its end, for whatever reason; it may close its session then. */
typedef void session_left(void *user, size_t member);

/* Runs all to their ends, each as session_run does. One that finishes is merged at once, one that fails leaves; the others go
 * on. left may be NULL. */
void session_group_run(size_t n, session_member *members, session_left *left, void *user);

#endif

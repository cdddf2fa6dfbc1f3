/* session_group.h: sessions that run side by side in one process, their systems in lanes where they can be
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
#ifndef SLIPDISK_RUN_SESSION_GROUP_H
#define SLIPDISK_RUN_SESSION_GROUP_H

#include "run/session.h"

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

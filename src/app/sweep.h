/* sweep.h: what the files of the subcommand sweep, and check, share. */
#ifndef SLIPDISK_APP_SWEEP_H
#define SLIPDISK_APP_SWEEP_H

#include "run/sweep.h"

typedef struct sweep_command {
  const char *deck, *output;
  size_t n_overrides;
  const char **overrides;
  long workers;     /* 0: not given: this process, or the ranks of an MPI job */
  long point, last; /* from, to; -1: all */
  int threads;
  bool force, quiet, status, list, table, count, no_lanes;
} sweep_command;

/* Some of the points, not all? */
static inline bool sweep_is_part(const sweep_command *c) { return c->point >= 0; }

/* "upper: Omega = -3.5e-04 +- 1.7e-05"; "" when nothing is watched. In text[size]. */
const char *sweep_finding(const sweep_result *r, char *text, size_t size);

/* Checks all points before any of them runs: mistakes, and a warning when time steps are too large. steps[n_points]:
 * their lengths (with `until` the longest), 0 for those with mistakes; kinds[n_points]: points of the same kind
 * can share lanes, those that are SWEEP_ALONE cannot (ensemble.h); usable: sets of values without mistakes. */
enum { SWEEP_ALONE = -1 };
sd_status sweep_survey(const sweep *s, int64_t *steps, int *kinds, size_t *usable, sd_messages *messages);

/* Runs what is not done yet: here or in the ranks of an MPI job, or (workers > 0) in processes of its own. */
int sweep_run_all(const sweep *s, const sweep_command *c);

#endif

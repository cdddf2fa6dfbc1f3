/* sweep.h: what the files of the subcommand sweep, and check, share. */
#ifndef SLIPDISK_APP_SWEEP_H
#define SLIPDISK_APP_SWEEP_H

#include <stdio.h>

#include "app/options.h"
#include "run/sweep.h"

typedef struct sweep_command {
  const char *deck, *output;
  option_list overrides;
  long workers;      /* 0: not given: this process, or the ranks of an MPI job */
  const char *range; /* after --point; NULL: all */
  long point, last;  /* from, to; -1: all */
  long threads;
  bool force, quiet, status, list, table, count, no_lanes, json;
  bool mix;  /* in a folder with results of other decks, other sweeps */
  bool skip; /* points with mistakes do not keep the others from being run */
} sweep_command;

/* Some of the points, not all? */
static inline bool sweep_is_part(const sweep_command *c) { return c->point >= 0; }

/* "upper: Omega = -3.5e-04 +- 1.7e-05"; "" when nothing is watched. In text[size]. */
const char *sweep_finding(const sweep_result *r, char *text, size_t size);

/* May this sweep work in its folder? A folder with results of other sweeps only is refused, and one in which points are of another deck:
 * a few of those that are there are looked at, but none of [first, end), which the caller looks at. */
sd_status sweep_guard(const sweep *s, const sweep_command *c, size_t first, size_t end,
                      sd_messages *messages);
/* A line about what lies in the folder and is none of this sweep's, if there is anything. */
void sweep_show_strangers(FILE *out, const sweep *s);
/* Adds 1 for each doubt; lines that count finished points with each of them, none when there are none. */
void sweep_count_doubts(unsigned doubts, size_t count[DOUBT_KINDS]);
void sweep_show_doubts(FILE *out, const size_t count[DOUBT_KINDS]);

/* All points of the folder, as JSON. */
sd_status sweep_print_json(const sweep *s);

/* Checks all points before any of them runs: mistakes, and a warning when time steps are too
 * large. steps[n_points]: their lengths (with `until` the longest), 0 for those with mistakes;
 * kinds[n_points]: points of the same kind can share lanes, those that are SWEEP_ALONE cannot
 * (ensemble.h); usable: sets of values without mistakes. SD_ERROR_IO: a point needs more memory
 * than there is, or so many workers side by side do. */
enum { SWEEP_ALONE = -1 };
sd_status sweep_precheck(const sweep *s, size_t workers, int64_t *steps, int *kinds, size_t *usable,
                         sd_messages *messages);

/* Runs what is not done yet: here or in the ranks of an MPI job, or (workers > 0) in processes of its own. */
int sweep_run_all(const sweep *s, const sweep_command *c);

#endif

/* sweep.h: declarations shared by the source files of the subcommand `sweep`, and used by
 * `check`. */
#ifndef SLIPDISK_APP_SWEEP_H
#define SLIPDISK_APP_SWEEP_H

#include <stdatomic.h>
#include <stdio.h>
#include <sys/types.h>

#include "app/app.h"
#include "base/comm_queue.h"
#include "run/sweep.h"

typedef struct sweep_command {
  const char *deck, *output;
  option_list overrides;
  /* Number of worker processes (-j); 0: not given, and this process or the ranks of an MPI job run
   * the points */
  long workers;
  const char *range; /* Value of the option --point; NULL: all points */
  long point, last;  /* First and last point of the option --point; point = -1: all points */
  long threads;
  bool force, quiet, status, list, table, count, no_lanes, json;
  bool mix;     /* True: the folder may also hold results of other decks or other sweeps */
  bool skip;    /* True: points without mistakes are run even if others have mistakes */
  bool no_wait; /* True: points that other processes run are left to them */
} sweep_command;

/* True if the option --point selects some of the points. */
static inline bool sweep_is_part(const sweep_command *c) { return c->point >= 0; }

/* Writes the first average of the series, as "mu = 0.29 +- 0.0046", without one the mean angular
 * velocity of the first watched disk, as "upper: Omega = -3.5e-04 +- 1.7e-05", into text[size] and
 * returns it; "" if there is neither. */
const char *sweep_finding(const sweep_result *r, char *text, size_t size);

/* Checks that this sweep may write to its folder. SD_ERROR_USER: the folder has results of other
 * sweeps but none of this one, or a sample of the existing results contains some made with another
 * deck. The sample leaves out the points [first, end), which the caller checks. With --mix
 * everything is allowed. */
sd_status sweep_guard(const sweep *s, const sweep_command *c, size_t first, size_t end,
                      sd_messages *messages);
/* Prints a line about files in the folder that belong to no point of this sweep; prints nothing if
 * there are none. */
void sweep_show_strangers(FILE *out, const sweep *s);
/* sweep_count_doubts adds bit k of `doubts` (kinds of doubt about a result) to count[k].
 * sweep_show_doubts prints, for each kind of doubt, how many finished points have it; it prints
 * nothing if no point has a doubt. */
void sweep_count_doubts(unsigned doubts, size_t count[DOUBT_KINDS]);
void sweep_show_doubts(FILE *out, const size_t count[DOUBT_KINDS]);

/* Prints the state of all points of the sweep as JSON. */
sd_status sweep_print_json(const sweep *s);

/* Checks all points of the sweep before any of them runs: reports mistakes, and gives warnings, for
 * example of too long a time step. steps[n_points]: number of steps of each point (with `until` the
 * largest possible), 0 for points with mistakes. kinds[n_points]: points of equal kind can share
 * SIMD lanes (ensemble.h); points of kind SWEEP_ALONE cannot. *usable: number of sets of parameter
 * values without mistakes. SD_ERROR_IO: a point needs more memory than there is, or `workers`
 * points side by side do. */
enum { SWEEP_ALONE = -1 };
sd_status sweep_precheck(const sweep *s, size_t workers, int64_t *steps, int *kinds, size_t *usable,
                         sd_messages *messages);

/* Runs the points that are not finished yet, and returns the exit status. With the option -j each
 * group of points runs in a process of its own; else this process or the ranks of an MPI job run
 * all groups. */
int sweep_run_all(const sweep *s, const sweep_command *c);

/* --- scheduler of a sweep that runs: points, workers, display --------------------------------- */

/* Progress and outcome of a point, in memory shared with the worker processes. */
typedef struct cell {
  volatile double fraction; /* Fraction of the point's steps that are done */
  /* The same fraction at the first report of this run; negative: no report yet */
  volatile double began;
  /* 1 + status of the point's run, set after `text` when it has ended; 0: it has not ended */
  atomic_int left;
  char text[1000]; /* Messages of the point's run, one per line */
} cell;

typedef struct worker {
  pid_t pid; /* Process id of the worker; 0: the worker is idle */
  /* Number of points of this worker whose process could not be started yet */
  size_t waiting;
  size_t n;
  size_t *points; /* [n] numbers of the points that this worker runs */
  bool *told;     /* [n]: true if the outcome of the point is already counted and shown */
  cell *cells;    /* [n] progress and outcome of the points, in shared memory */
  double started;
} worker;

/* Group of points that run side by side: entries first ... first + n - 1 of sweep_groups.order. */
typedef struct sweep_group {
  size_t first, n;
  /* True: the group was moved to the end, because another process was running one of its points */
  bool late;
} sweep_group;

typedef struct sweep_groups {
  size_t *order;     /* Numbers of the points, ordered by group */
  sweep_group *list; /* Groups in the order in which they run */
  size_t n, next, capacity;
} sweep_groups;

/* Outcome of a point in this call of the program. UNTRIED: not begun. SKIPPED: another process was
 * running the point. CRASHED: the process of its group died, so that the point must be run again
 * alone. TRIED: it was run here, or is finished. */
typedef enum attempt { UNTRIED, SKIPPED, CRASHED, TRIED } attempt;

typedef struct scheduler {
  const sweep *s;
  const sweep_command *c;
  size_t first, end; /* Points first ... end - 1 are run by this call of the program */
  int64_t *steps;    /* [n_points] number of steps of each point */
  /* [n_points]: points of equal kind can share SIMD lanes; SWEEP_ALONE: the point runs alone */
  int *kinds;
  unsigned char *tried; /* [n_points] outcome in this call, a value of `attempt` */
  /* [n_points]: 1 + status of the point when its files were last read; 0: not read yet */
  unsigned char *seen;
  /* [n_points]: bit mask of doubts about the result of a finished point */
  unsigned char *doubts;
  size_t width; /* Largest number of points in a group */
  size_t done, failed, other, damaged, unreadable, elsewhere, left;
  size_t doubted[DOUBT_KINDS]; /* Number of finished points with each kind of doubt */
  bool in_doubt;               /* True if any finished point has a doubt */
  int worst;                   /* Exit status: the worst of all points so far */
  double began, tabled, table_cost, drawn;
  /* Number of steps of all points that this call runs; number of these steps that are done */
  double steps_total, steps_done;
  /* no_table: true if the last attempt to write the tables failed */
  bool terminal, line_open, stars, no_table;
  size_t n_workers;
  worker *workers;
  /* Arrays of n_workers * width elements; each worker uses `width` of them */
  size_t *points;
  bool *told;
  cell *cells;
  /* Number of the present round: each round makes and runs groups of the points still to be run */
  int round;
  sweep_groups groups;
  comm_queue queue;
} scheduler;

/* Order of the sections below: functions of a section call only functions of sections above it. */

/* --- sweep_display.c -------------------------------------------------------------------------- */
void sweep_clear_line(scheduler *w);
/* Prints a line about a point whose run has ended. text: messages of the process that ran the
 * point; seconds: wall time of the run. */
void sweep_show(scheduler *w, size_t point, const sweep_result *r, const char *text,
                double seconds);
/* Redraws the progress line at the bottom of the terminal. */
void sweep_draw(scheduler *w);
void sweep_show_start(const scheduler *w);
/* Prints the points for which this process waits: held[n], which other processes run. */
void sweep_show_held(scheduler *w, size_t n, const size_t *held);
void sweep_show_end(scheduler *w);

/* --- sweep_workers.c: groups ------------------------------------------------------------------ */
/* Puts n points into groups for `workers` workers. Overwrites *g without freeing it. */
void sweep_groups_make(sweep_groups *g, const scheduler *w, const size_t *points, size_t n,
                       size_t workers);
/* Appends a group to the end of the list and marks it as late, so that it is not moved again. */
void sweep_groups_put_off(sweep_groups *g, sweep_group one);
void sweep_groups_free(sweep_groups *g);

/* --- sweep_workers.c: order of the points ----------------------------------------------------- */
void sweep_worsen(scheduler *w, int status);
/* Writes the tables of the sweep. last false: only if enough time has passed since they were last
 * written; true: in any case. */
void sweep_make_tables(scheduler *w, bool last);
/* Counts a point by its status r->status, as read from the folder, and stores its doubts. */
void sweep_remember(scheduler *w, size_t point, const sweep_result *r);
/* Looks in the folder of the sweep how the run of a point ended, adds the point to the counts
 * (done, stopped, failed) and prints a line about it. status, text: status and messages of the
 * process that ran the point; ran: progress and outcome of the run; seconds: wall time. */
void sweep_account(scheduler *w, size_t point, sd_status status, const char *text, const cell *ran,
                   double seconds);
/* Takes the next group from the list. Fills points[] with its points, without those that other
 * processes run or have finished, and returns their number; 0: no group is left. */
size_t sweep_next(scheduler *w, size_t *points);
/* Fills points[] with the points of the group that are still to be run, and returns their
 * number. */
size_t sweep_sift(scheduler *w, sweep_group one, size_t *points);
/* sweep_tell writes the progress of a point into its cell, sweep_tell_left its outcome. */
void sweep_tell(cell *mine, const session_progress *p);
void sweep_tell_left(cell *mine, const sweep_end *end);
/* Prepares a worker to run its points 0 ... n - 1: resets their cells (progress, outcome) and the
 * clock. */
void sweep_assign(worker *one, size_t n);

/* --- sweep_workers.c: processes --------------------------------------------------------------- */
/* Runs all groups, each in a process of its own, until none is left. */
void sweep_run_workers(scheduler *w);

#endif

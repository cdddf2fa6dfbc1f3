/* sweep.h: declarations shared by the files of the subcommand `sweep`, and by `check`. */
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
  /* Number of worker processes (-j); 0: not given, this process or the ranks of an MPI job run
   * the points */
  long workers;
  const char *range; /* Text of --point; NULL: all points */
  long point, last;  /* First and last point of --point; point -1: all points */
  long threads;
  bool force, quiet, status, list, table, count, no_lanes, json;
  bool mix;  /* True: the folder may hold results of other decks or sweeps */
  bool skip; /* True: mistakes in some points do not keep the others from being run */
} sweep_command;

/* True if --point selects some of the points. */
static inline bool sweep_is_part(const sweep_command *c) { return c->point >= 0; }

/* Writes the mean rotation of the first watched disk, "upper: Omega = -3.5e-04 +- 1.7e-05", into
 * text[size] and returns it; "" if no disk is watched. */
const char *sweep_finding(const sweep_result *r, char *text, size_t size);

/* Checks that this sweep may use its folder. SD_ERROR_USER: the folder has only results of other
 * sweeps, or sampled points belong to another deck. The sample leaves out the points [first,
 * end), which the caller checks. Refuses nothing with --mix. */
sd_status sweep_guard(const sweep *s, const sweep_command *c, size_t first, size_t end,
                      sd_messages *messages);
/* Prints a line about files in the folder that belong to no point of this sweep, if there are
 * any. */
void sweep_show_strangers(FILE *out, const sweep *s);
/* sweep_count_doubts adds bit k of `doubts` to count[k]. sweep_show_doubts prints, for each kind
 * of doubt, how many finished points have it; nothing if none has. */
void sweep_count_doubts(unsigned doubts, size_t count[DOUBT_KINDS]);
void sweep_show_doubts(FILE *out, const size_t count[DOUBT_KINDS]);

/* Prints all points of the folder as JSON. */
sd_status sweep_print_json(const sweep *s);

/* Checks all points before any of them runs: reports mistakes, and warns of time steps that are
 * too long and the like. steps[n_points]: lengths of the points in steps (with `until` the
 * largest), 0 for points with mistakes. kinds[n_points]: points of equal kind can share lanes
 * (ensemble.h), those with SWEEP_ALONE cannot. *usable: number of sets of values without
 * mistakes. SD_ERROR_IO: a point needs more memory than there is, or so many workers side by side
 * do. */
enum { SWEEP_ALONE = -1 };
sd_status sweep_precheck(const sweep *s, size_t workers, int64_t *steps, int *kinds, size_t *usable,
                         sd_messages *messages);

/* Runs the points that are not done yet, and returns the exit status. workers > 0: each group in
 * a process of its own; else in this process or in the ranks of an MPI job. */
int sweep_run_all(const sweep *s, const sweep_command *c);

/* --- scheduler of a sweep that runs: points, workers, display --------------------------------- */

/* Progress and outcome of a point, in shared memory for worker processes. */
typedef struct cell {
  volatile double fraction; /* Fraction of its steps that are done */
  volatile double began;    /* Fraction at its first report; negative: no report yet */
  /* 1 + status, set after `text` when the point has ended; 0: it has not */
  atomic_int left;
  char text[1000]; /* Messages of the point, a line each */
} cell;

typedef struct worker {
  pid_t pid; /* Process id; 0: idle */
  /* Number of points for which no process could be started yet */
  size_t waiting;
  size_t n;
  size_t *points; /* [n] numbers of the points */
  bool *told;     /* [n]: true if the outcome of the point is accounted for */
  cell *cells;    /* [n] progress and outcome, in shared memory */
  double started;
} worker;

/* Points that run side by side: entries first ... first + n - 1 of sweep_groups.order. */
typedef struct sweep_group {
  size_t first, n;
  /* True: put off, since another process was running one of its points */
  bool late;
} sweep_group;

typedef struct sweep_groups {
  size_t *order;     /* Numbers of the points, group by group */
  sweep_group *list; /* Groups in the order in which they run */
  size_t n, next, capacity;
} sweep_groups;

/* Outcome of a point in this call. SKIPPED: another process was running it at its turn. CRASHED:
 * the process of its group died, so the point is to be run again by itself. */
typedef enum attempt { UNTRIED, SKIPPED, CRASHED, TRIED } attempt;

typedef struct scheduler {
  const sweep *s;
  const sweep_command *c;
  size_t first, end; /* Range [first, end) of the points of this call */
  int64_t *steps;    /* [n_points] numbers of steps */
  /* [n_points]: points of one kind share lanes; SWEEP_ALONE: it runs alone */
  int *kinds;
  unsigned char *tried; /* [n_points], values of `attempt` */
  /* [n_points]: 1 + status of the point when it was last read; 0: not read */
  unsigned char *seen;
  /* [n_points]: bit mask of doubts of a finished point that was read */
  unsigned char *doubts;
  size_t width; /* Most points in a group */
  size_t done, failed, other, damaged, elsewhere, left;
  size_t doubted[DOUBT_KINDS]; /* Number of finished points with each kind of doubt */
  bool in_doubt;               /* True if any finished point has a doubt */
  int worst;                   /* Exit status: the worst so far */
  double began, tabled, table_cost, drawn;
  /* Steps of the points that this call runs: in all, done */
  double steps_total, steps_done;
  /* no_table: the last tables could not be written */
  bool terminal, line_open, stars, no_table;
  size_t n_workers;
  worker *workers;
  /* Arrays that the workers share out, [n_workers * width] each */
  size_t *points;
  bool *told;
  cell *cells;
  int round; /* Number of the present round of groups */
  sweep_groups groups;
  comm_queue queue;
} scheduler;

/* Functions of a section call only functions of sections above it. */

/* --- sweep_display.c -------------------------------------------------------------------------- */
void sweep_clear_line(scheduler *w);
/* Prints a line about a point that has ended. text: messages of the process that ran it; seconds:
 * wall time. */
void sweep_show(scheduler *w, size_t point, const sweep_result *r, const char *text,
                double seconds);
/* Redraws the line at the bottom of a terminal. */
void sweep_draw(scheduler *w);
void sweep_show_start(const scheduler *w);
void sweep_show_end(scheduler *w);

/* --- sweep_workers.c: groups ------------------------------------------------------------------ */
/* Puts n points into groups for so many workers. Overwrites *g. */
void sweep_groups_make(sweep_groups *g, const scheduler *w, const size_t *points, size_t n,
                       size_t workers);
/* Appends a group to the end of the list, marked as late. */
void sweep_groups_put_off(sweep_groups *g, sweep_group one);
void sweep_groups_free(sweep_groups *g);

/* --- sweep_workers.c: order of the points ----------------------------------------------------- */
void sweep_worsen(scheduler *w, int status);
/* Writes the tables of the sweep: between points if enough time has passed since the last ones;
 * with `last` in any case. */
void sweep_make_tables(scheduler *w, bool last);
/* Counts a point by its status as read from the folder, and keeps its doubts. */
void sweep_remember(scheduler *w, size_t point, const sweep_result *r);
/* Accounts for a point that has been left: reads its state from the folder, counts and shows it.
 * status, text: those of the process or call that ran it; ran: its cell; seconds: wall time. */
void sweep_account(scheduler *w, size_t point, sd_status status, const char *text, const cell *ran,
                   double seconds);
/* Takes the next group, without points that other processes run or have finished. Fills points[]
 * and returns their number; 0: no group is left. */
size_t sweep_next(scheduler *w, size_t *points);
/* Fills points[] with those points of a group that are still to be run, and returns their
 * number. */
size_t sweep_sift(scheduler *w, sweep_group one, size_t *points);
/* Write progress and outcome of a point into its cell. */
void sweep_tell(cell *mine, const session_progress *p);
void sweep_tell_left(cell *mine, const sweep_end *end);
/* Starts work on points [0, n) of a worker: resets their cells and the clock. */
void sweep_assign(worker *one, size_t n);

/* --- sweep_workers.c: processes --------------------------------------------------------------- */
/* Runs all groups, each in a process of its own. */
void sweep_run_workers(scheduler *w);

#endif

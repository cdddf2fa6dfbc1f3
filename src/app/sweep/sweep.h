/* sweep.h: what the files of the subcommand sweep, and check, share. */
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

/* What the files that run a sweep share: the list of points, who works on which, what the user sees. */

/* Progress and outcome of a point, in shared memory where another process runs it. */
typedef struct cell {
  volatile double fraction; /* of its steps */
  volatile double began;    /* fraction at its first report; negative: none yet */
  atomic_int left;          /* 0: not yet; else 1 + its status, after text */
  char text[1000];          /* its messages, a line each */
} cell;

typedef struct worker {
  pid_t pid;      /* 0: idle */
  size_t waiting; /* points for which no process could be started yet */
  size_t n;
  size_t *points; /* [n] */
  bool *told;     /* [n]: accounted for */
  cell *cells;    /* [n], shared */
  double started;
} worker;

/* Points that are run side by side: entries first, ... of `order`. */
typedef struct sweep_group {
  size_t first, n;
  bool late; /* was put off, since another process was at work on it */
} sweep_group;

typedef struct sweep_groups {
  size_t *order;     /* points */
  sweep_group *list; /* in the order in which they are run */
  size_t n, next, capacity;
} sweep_groups;

/* Outcome of a point in this call. SKIPPED: another process was running it when its turn came. CRASHED: the process
 * of its group was, it is to be run by itself. */
typedef enum attempt { UNTRIED, SKIPPED, CRASHED, TRIED } attempt;

typedef struct scheduler {
  const sweep *s;
  const sweep_command *c;
  size_t first, end;    /* the points of this call */
  int64_t *steps;       /* [n_points] */
  int *kinds;           /* [n_points]: points of one kind go in lanes together; SWEEP_ALONE: none */
  unsigned char *tried; /* [n_points], an attempt */
  unsigned char *seen;  /* [n_points]: 1 + its status when it was last looked at; 0: it was not */
  unsigned char *doubts; /* [n_points], of finished ones that were looked at */
  size_t width;          /* most points of a group */
  size_t done, failed, other, damaged, elsewhere, left;
  size_t doubted[DOUBT_KINDS]; /* finished ones with each doubt */
  bool in_doubt;               /* any of them */
  int worst;                   /* exit status */
  double began, tabled, table_cost, drawn;
  double steps_total, steps_done;            /* of the points that this call runs */
  bool terminal, line_open, stars, no_table; /* no_table: the last ones could not be written */
  size_t n_workers;
  worker *workers;
  size_t *points; /* of the workers: [n_workers * width]; likewise below */
  bool *told;
  cell *cells;
  int round; /* of groups */
  sweep_groups groups;
  comm_queue queue;
} scheduler;

/* Each part calls those above it. */

/* --- sweep_display.c ---------------------------------------------------------------------------------- */
void sweep_clear_line(scheduler *w);
/* A line that stays. text: what was said by the one that ran the point. */
void sweep_show(scheduler *w, size_t point, const sweep_result *r, const char *text,
                double seconds);
/* The line at the bottom of a terminal. */
void sweep_draw(scheduler *w);
void sweep_show_start(const scheduler *w);
void sweep_show_end(scheduler *w);

/* --- sweep_workers.c: groups ------------------------------------------------------------------ */
/* Puts n points into groups for so many workers; *g holds nothing yet. */
void sweep_groups_make(sweep_groups *g, const scheduler *w, const size_t *points, size_t n,
                       size_t workers);
/* Puts one at the end of the list. */
void sweep_groups_put_off(sweep_groups *g, sweep_group one);
void sweep_groups_free(sweep_groups *g);

/* --- sweep_workers.c: order of the points ----------------------------------------------------- */
void sweep_worsen(scheduler *w, int status);
/* Tables between points, when it is time again, or the last ones. */
void sweep_make_tables(scheduler *w, bool last);
/* Counts what was seen of a point. */
void sweep_remember(scheduler *w, size_t point, const sweep_result *r);
/* A point has been left: what does the folder say? status, text: of the process or call that ran it. */
void sweep_account(scheduler *w, size_t point, sd_status status, const char *text, const cell *ran,
                   double seconds);
/* The next group, without points that others run or have finished; how many points, 0: all are under way. */
size_t sweep_next(scheduler *w, size_t *points);
/* The points of a group that are still to be run. */
size_t sweep_sift(scheduler *w, sweep_group one, size_t *points);
/* Writes progress and outcome into the cell of a point. */
void sweep_tell(cell *mine, const session_progress *p);
void sweep_tell_left(cell *mine, const sweep_end *end);
/* Its points [0, n) are to be run now. */
void sweep_assign(worker *one, size_t n);

/* --- sweep_workers.c --------------------------------------------------------------------------------- */
/* Runs all groups, each in a process of its own. */
void sweep_run_workers(scheduler *w);

#endif

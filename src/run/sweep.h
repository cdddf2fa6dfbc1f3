/* sweep.h: runs the points of a deck's sweep in a folder, lists what is there, and writes the
 * tables of results.
 *
 *   FOLDER/points/NAME.h5        result of a point; NAME.h5.parts while it is not finished
 *   FOLDER/points/NAME.failed    reason why a point failed; removed when the point is run again
 *   FOLDER/table.csv, table.h5   a row per point, finished or not
 *   FOLDER/means.csv             a row per set of values: means over its replicas
 *
 * Processes share only the folder: any number of them, on any number of machines, may run points
 * of the same sweep at the same time, since a point is locked while it is run. This code prints
 * nothing and starts no processes. */
#ifndef SLIPDISK_RUN_SWEEP_H
#define SLIPDISK_RUN_SWEEP_H

#include "io/deck/deck.h"
#include "run/session.h"

typedef struct sweep {
  deck_sweep deck;
  char *folder; /* folder of the sweep; NULL: none yet */
} sweep;

/* Reads the deck's sweep; the folder need not exist. Call sweep_close also after a failure. */
sd_status sweep_open(sweep *s, const char *deck, size_t n_overrides, const char *const *overrides,
                     const char *folder, sd_messages *messages);
void sweep_close(sweep *s);
/* Loads the model of the first point of each set of values and passes it to visit (may be NULL),
 * which returns true if it takes over the model. SD_ERROR_USER: some set has mistakes, which are
 * reported once each, with the points that make them. *usable: number of sets without mistakes. */
typedef bool sweep_visitor(void *user, size_t point, sd_model *model);
sd_status sweep_check(const sweep *s, sweep_visitor *visit, void *user, size_t *usable,
                      sd_messages *messages);
/* Makes the folder of the sweep and its folder of points. */
sd_status sweep_prepare(const sweep *s, sd_messages *messages);

typedef enum sweep_status {
  SWEEP_WAITING, /* the point was not begun */
  SWEEP_RUNNING, /* a process holds its lock */
  SWEEP_STOPPED, /* begun, but no process runs it; an older result may exist */
  SWEEP_DONE,
  SWEEP_FAILED,
  SWEEP_DAMAGED, /* the result cannot be read */
  SWEEP_OTHER,   /* the result or checkpoint is of a deck that differs */
  SWEEP_STATUSES
} sweep_status;
extern const char *const sweep_status_names[SWEEP_STATUSES];

/* Key whose value in the deck of a result differs from that in this deck; NULL: the deck does not
 * have the key. If both are NULL, path is a sentence. */
typedef struct sweep_difference {
  char *path, *there, *here;
} sweep_difference;

/* State and results of a point, read from the folder. */
typedef struct sweep_result {
  sweep_status status;
  unsigned doubts; /* doubts about a finished result, bits 1 << doubt_kind */
  bool has_found;  /* true if `found` is set */
  summary found;   /* summary at the end of a finished point, else at the last checkpoint */
  /* explanation if failed, damaged or of another deck, lines joined by "; "; doubts if done; else
   * "" */
  char *message;
  size_t n_differences; /* number of differences, if status is SWEEP_OTHER */
  sweep_difference *differences;
} sweep_result;
/* Reads state and results of a point. A result that cannot be read is no failure but a status of
 * the point. */
void sweep_look(const sweep *s, size_t point, sweep_result *result);
void sweep_result_free(sweep_result *result);
/* Returns the status without reading results: any result counts as done. */
sweep_status sweep_peek(const sweep *s, size_t point);

/* Difference between this deck and the decks of several results. */
typedef struct sweep_tally_line {
  sweep_difference first;
  bool varies;   /* true if other results have other values */
  size_t points; /* number of points with this difference */
} sweep_tally_line;
typedef struct sweep_tally {
  /* number of points, of lines in `list`, and of further lines, which are not kept */
  size_t points, n, more;
  bool sampled;           /* true if only some of the points were checked */
  sweep_tally_line *list; /* [n] differences */
} sweep_tally;
/* Adds the differences of a point of another deck, and takes them over. */
void sweep_tally_add(sweep_tally *t, sweep_result *r);
/* Returns a text such as "gravity.tilt: 0.1 there, 0.2 here (48 points)"; the caller frees it. */
char *sweep_tally_text(const sweep_tally *t, size_t k);
void sweep_tally_free(sweep_tally *t);

/* Contents of the folder of points, known from the names of files alone. */
enum { SWEEP_HAS_RESULT = 1, SWEEP_HAS_PARTS = 2 };
typedef struct sweep_contents {
  unsigned char *has; /* [n_points] bits SWEEP_HAS_RESULT, SWEEP_HAS_PARTS */
  size_t known;       /* number of points of this sweep with a result or parts */
  /* files of points that do not belong to this sweep: .h5, .h5.parts, .failed */
  size_t results, parts, failures;
  char *example; /* name of a point that is not of this sweep; NULL: none */
} sweep_contents;
/* Finds which results and runs the folder of points has. */
void sweep_list(const sweep *s, sweep_contents *out);
/* Returns a text such as "FOLDER has 9 results and 1 unfinished run of points that this sweep does
 * not have, such as tilt=0"; the caller frees it; NULL: there are none. */
char *sweep_strangers_text(const sweep *s, const sweep_contents *c);
void sweep_contents_free(sweep_contents *c);
/* Returns SD_ERROR_USER if the folder has results of other points but none of this sweep. instead:
 * what will not be done because of it, such as "nothing is run". */
sd_status sweep_refuse_strangers(const sweep *s, const sweep_contents *c, const char *instead,
                                 sd_messages *messages);
/* Returns SD_ERROR_USER if the tally counts points that were run with another deck. */
sd_status sweep_refuse_others(const sweep *s, const sweep_tally *t, const char *instead,
                              sd_messages *messages);

/* Outcome of a point that was given to sweep_run. */
typedef struct sweep_end {
  size_t point;
  sd_status ran; /* status of the run; SD_INTERRUPTED: stopped at a checkpoint */
  /* status of the point afterwards; SWEEP_RUNNING: left to another process that runs it */
  sweep_status status;
  const sd_messages *messages; /* valid until the call returns */
} sweep_end;

/* Options of sweep_run. In its callbacks, k is the index into the points given to sweep_run. */
typedef struct sweep_options {
  int threads; /* number of threads if there is one point; several points have one thread each */
  bool force;  /* true: run finished points again */
  /* points stop at a checkpoint once this is nonzero */
  volatile sig_atomic_t *stop;
  /* reports the progress of point k; may be NULL */
  void (*progress)(void *user, size_t k, const session_progress *progress);
  /* called once for each point when it has ended */
  void (*left)(void *user, size_t k, const sweep_end *end);
  void *user;
} sweep_options;

/* Runs points, or continues them, side by side (session.h). A point that is finished, or that
 * another process runs, is skipped (SD_OK); a damaged result or one of another deck is
 * SD_ERROR_USER. Each point ends independently: the messages of a run that fails are also kept in
 * NAME.failed, and the others continue. */
void sweep_run(const sweep *s, size_t n, const size_t *points, const sweep_options *options);
/* Loads the model of a point and returns the path of its result (the caller frees both), for
 * callers that run the point themselves. */
sd_status sweep_load(const sweep *s, size_t point, sd_model **model, char **result,
                     sd_messages *messages);
/* Writes the reason why a point failed to NAME.failed. text NULL: it did not fail, and the file is
 * removed. */
void sweep_note(const sweep *s, size_t point, const char *text);
void sweep_note_messages(const sweep *s, size_t point, const sd_messages *messages);

/* Sets collected[p] to true if pattern p of `collect` matches a column that a finished point with
 * this model has; other elements are not changed. */
void sweep_columns(const sweep *s, size_t point, const sd_model *model, bool *collected);
/* Writes table.csv, table.h5 and means.csv from the contents of the folder (sweep_table.c). One
 * process at a time does so. SD_ERROR_USER: another process still writes after `patience` seconds;
 * or, unless mix is true, there are points of another deck. */
sd_status sweep_write_tables(const sweep *s, double patience, bool mix, sd_messages *messages);

#endif

/* sweep.h: runs the points (single runs) of a deck's sweep, reads their state and results from the
 * sweep's folder, and writes the tables of results.
 *
 *   FOLDER/points/NAME.h5        result of a point; NAME.h5.parts while it is not finished
 *   FOLDER/points/NAME.failed    reason why a point failed; removed when the point is run again
 *   FOLDER/table.csv, table.h5   a row per point, finished or not
 *   FOLDER/means.csv             a row per set of parameter values: means over its replicas
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
  char *folder; /* folder of the sweep; NULL: not chosen yet */
} sweep;

/* Reads the group `sweep` of a deck; the folder of the sweep need not exist. Call sweep_close also
 * after a failure. */
sd_status sweep_open(sweep *s, const char *deck, size_t n_overrides, const char *const *overrides,
                     const char *folder, sd_messages *messages);
void sweep_close(sweep *s);
/* Loads the model of the first point of each set of parameter values and passes it to visit (may be
 * NULL), which returns true if it takes over the model. SD_ERROR_USER: some set has mistakes; each
 * mistake is reported once, with the points that have it. *usable: receives the number of sets
 * without mistakes. */
typedef bool sweep_visitor(void *user, size_t point, sd_model *model);
sd_status sweep_check(const sweep *s, sweep_visitor *visit, void *user, size_t *usable,
                      sd_messages *messages);
/* Makes the folder of the sweep, and in it the folder of points. */
sd_status sweep_prepare(const sweep *s, sd_messages *messages);

typedef enum sweep_status {
  SWEEP_WAITING, /* the point was never begun */
  SWEEP_RUNNING, /* a process is running the point: it has the lock of the point's folder */
  SWEEP_STOPPED, /* begun, but no process is running it; an older result may exist */
  SWEEP_DONE,
  SWEEP_FAILED,
  SWEEP_DAMAGED,    /* the result of the point is damaged, or none */
  SWEEP_UNREADABLE, /* the disk or a permission keeps the result of the point from being read */
  SWEEP_OTHER,      /* the result or checkpoint was made with another deck */
  SWEEP_STATUSES
} sweep_status;
extern const char *const sweep_status_names[SWEEP_STATUSES];

/* Difference between the decks of an existing result and of this sweep: key (path), its value there
 * and here; NULL: that deck does not have the key. If both values are NULL, path is a sentence
 * about the difference. */
typedef struct sweep_difference {
  char *path, *there, *here;
} sweep_difference;

/* State and results of a point, as read from its files. */
typedef struct sweep_result {
  sweep_status status;
  unsigned doubts; /* doubts about a finished result, as bits 1 << doubt_kind; 0: none */
  bool has_found;  /* true: `found` is set */
  summary found;   /* summary at the end if the point is finished, else at the last checkpoint */
  /* explanation if the point failed, is damaged, unreadable or was made with another deck, lines
   * joined by semicolons; doubts if it is finished; else "" */
  char *message;
  size_t n_differences; /* number of differences between the decks, if status is SWEEP_OTHER */
  sweep_difference *differences;
} sweep_result;
/* Reads state and results of a point from its files. If a result cannot be read, that is not a
 * failure of this function but the status SWEEP_DAMAGED or SWEEP_UNREADABLE of the point. */
void sweep_look(const sweep *s, size_t point, sweep_result *result);
void sweep_result_free(sweep_result *result);
/* Returns the status of a point without opening its result: any result counts as finished. */
sweep_status sweep_peek(const sweep *s, size_t point);

/* Difference between the deck of this sweep and the decks of several existing results. */
typedef struct sweep_tally_line {
  sweep_difference first;
  /* true: the results have several other values for this key, `first` has one of them */
  bool varies;
  size_t points; /* number of points with this difference */
} sweep_tally_line;
typedef struct sweep_tally {
  /* number of points counted, number of lines in `list`, number of further lines, which are not
   * stored */
  size_t points, n, more;
  bool sampled;           /* true: only a sample of the points was compared */
  sweep_tally_line *list; /* [n] differences, each with the number of its points */
} sweep_tally;
/* Adds the differences of a point that was run with another deck to the tally, which takes over
 * their strings. */
void sweep_tally_add(sweep_tally *t, sweep_result *r);
/* Returns line k of the tally as text, such as "gravity.tilt: 0.1 there, 0.2 here (48 points)"; the
 * caller frees it. */
char *sweep_tally_text(const sweep_tally *t, size_t k);
void sweep_tally_free(sweep_tally *t);

/* Contents of the folder of points, as far as the names of files tell. */
enum { SWEEP_HAS_RESULT = 1, SWEEP_HAS_PARTS = 2 };
typedef struct sweep_contents {
  unsigned char *has; /* [n_points] for each point bits SWEEP_HAS_RESULT, SWEEP_HAS_PARTS */
  /* number of points of this sweep that have a result or a folder of part files */
  size_t known;
  /* numbers of files .h5, of folders .h5.parts and of files .failed of points that this sweep does
   * not have */
  size_t results, parts, failures;
  char *example; /* name of a point that this sweep does not have but the folder has; NULL: none */
} sweep_contents;
/* Lists the results and unfinished runs in the folder of points. */
void sweep_list(const sweep *s, sweep_contents *out);
/* Returns a text such as "FOLDER has 9 results and 1 unfinished run of points that this sweep does
 * not have, such as tilt=0"; the caller frees it; NULL: there are none. */
char *sweep_strangers_text(const sweep *s, const sweep_contents *c);
void sweep_contents_free(sweep_contents *c);
/* Returns SD_ERROR_USER if the folder has results of other points but none of this sweep. instead:
 * text for the message that says what is not done therefore, such as "nothing is run". */
sd_status sweep_refuse_unknown_points(const sweep *s, const sweep_contents *c, const char *instead,
                                      sd_messages *messages);
/* Returns SD_ERROR_USER if the tally has points that were run with another deck. instead: as for
 * sweep_refuse_unknown_points. */
sd_status sweep_refuse_other_decks(const sweep *s, const sweep_tally *t, const char *instead,
                                   sd_messages *messages);

/* Outcome of a point that was given to sweep_run. */
typedef struct sweep_end {
  size_t point;
  sd_status ran; /* status of the run; SD_INTERRUPTED: stopped at a checkpoint */
  /* status of the point afterwards; SWEEP_RUNNING: not run here, because another process runs it */
  sweep_status status;
  const sd_messages *messages; /* messages of the run, valid until the callback returns */
} sweep_end;

/* Options of sweep_run. In its callbacks, k is the index into the points given to sweep_run. */
typedef struct sweep_options {
  /* number of threads if only one point is run; several points are run with one thread each */
  int threads;
  bool force; /* true: run finished points again */
  /* the runs of all points stop at a checkpoint once this is nonzero */
  volatile sig_atomic_t *stop;
  /* called with the progress of point k; may be NULL */
  void (*progress)(void *user, size_t k, const session_progress *progress);
  /* called once for each point when it has ended */
  void (*left)(void *user, size_t k, const sweep_end *end);
  void *user;
} sweep_options;

/* Runs n points, or continues them, side by side (session.h). A point that is finished, or that
 * another process runs, is skipped (SD_OK); it is SD_ERROR_USER if its result is damaged or was
 * made with another deck, SD_ERROR_IO if it cannot be read. Each point ends independently: if one
 * fails, its messages are also written to NAME.failed, and the other points continue. */
void sweep_run(const sweep *s, size_t n, const size_t *points, const sweep_options *options);
/* Loads the model of a point and makes the path of its result, both freed by the caller, for
 * callers that run the point themselves. */
sd_status sweep_load(const sweep *s, size_t point, sd_model **model, char **result,
                     sd_messages *messages);
/* Writes the reason why a point failed to the file NAME.failed. text NULL: the point did not fail,
 * and the file is removed. */
void sweep_note(const sweep *s, size_t point, const char *text);
void sweep_note_messages(const sweep *s, size_t point, const sd_messages *messages);

/* Sets collected[p] to true if pattern p of the key `collect` matches the name of a table column
 * that a finished point with this model has; does not change other elements. */
void sweep_columns(const sweep *s, size_t point, const sd_model *model, bool *collected);
/* Writes table.csv, table.h5 and means.csv from the contents of the folder (sweep_table.c). Only
 * one process at a time can do so. SD_ERROR_USER: another process is still writing them after
 * `patience` seconds; or there are points of another deck, and mix is false. SD_ERROR_IO: a result
 * cannot be read, and tables that are there stay as they are. count: the number of
 * points of each status is added. */
sd_status sweep_write_tables(const sweep *s, double patience, bool mix,
                             size_t count[SWEEP_STATUSES], sd_messages *messages);

#endif

/* sweep.h: the points of a deck's sweep in a folder: what is there, running them, and the table of results.
 *
 *   FOLDER/points/NAME.h5        result of a point, as of `run` (NAME.h5.parts while it is not finished)
 *   FOLDER/points/NAME.failed    why a point failed; goes away when it is run again
 *   FOLDER/table.csv, table.h5   a row per point, finished or not
 *   FOLDER/means.csv             a row per set of values: means over its replicas
 *
 * The folder is all that processes share: any number of them, on any number of machines, may run points of the same
 * sweep at the same time, since a point is locked while it is run. Nothing here prints or starts processes.
 */
#ifndef SLIPDISK_RUN_SWEEP_H
#define SLIPDISK_RUN_SWEEP_H

#include "io/deck/deck.h"
#include "run/session.h"

typedef struct sweep {
  deck_sweep deck;
  char *folder; /* NULL: none yet */
} sweep;

/* Reads the deck's sweep; the folder need not exist. sweep_close also when it fails. */
sd_status sweep_open(sweep *s, const char *deck, size_t n_overrides, const char *const *overrides,
                     const char *folder, sd_messages *messages);
void sweep_close(sweep *s);
/* Loads the model of the first point of each set and shows it to visit (may be NULL), which returns true when it
 * takes the model over. SD_ERROR_USER with the mistakes, each once and with the points that make it, when any has
 * one; *usable counts the sets without. */
typedef bool sweep_visitor(void *user, size_t point, sd_model *model);
sd_status sweep_check(const sweep *s, sweep_visitor *visit, void *user, size_t *usable,
                      sd_messages *messages);
/* Makes the folders. */
sd_status sweep_prepare(const sweep *s, sd_messages *messages);

typedef enum sweep_status {
  SWEEP_WAITING, /* nothing there */
  SWEEP_RUNNING, /* some process holds its lock */
  SWEEP_STOPPED, /* begun, and no process runs it; an older result may be there, too */
  SWEEP_DONE,
  SWEEP_FAILED,
  SWEEP_DAMAGED, /* a result is there that cannot be read */
  SWEEP_OTHER,   /* a result is there, finished or begun, of a deck that says something else */
  SWEEP_STATUSES
} sweep_status;
extern const char *const sweep_status_names[SWEEP_STATUSES];

/* A key that the deck of a result says otherwise; NULL: it does not have it. Neither there nor here: path is a sentence. */
typedef struct sweep_difference {
  char *path, *there, *here;
} sweep_difference;

/* State and findings of a point, read from the folder. */
typedef struct sweep_result {
  sweep_status status;
  unsigned doubts; /* of a finished one; bits 1 << doubt_kind */
  bool has_found;
  summary found; /* finished: at the end; else as of the last checkpoint */
  char *
      message; /* failed, damaged, other deck: why, lines joined by "; "; done: its doubts. "" else */
  size_t n_differences; /* of another deck */
  sweep_difference *differences;
} sweep_result;
/* A result that cannot be read is a state of the point. */
void sweep_look(const sweep *s, size_t point, sweep_result *result);
void sweep_result_free(sweep_result *result);
/* The status only, without reading results: whatever result is there counts as done. */
sweep_status sweep_peek(const sweep *s, size_t point);

/* In what the decks of many results differ from this one. */
typedef struct sweep_tally_line {
  sweep_difference first;
  bool varies; /* it is another value for others */
  size_t points;
} sweep_tally_line;
typedef struct sweep_tally {
  size_t points, n, more; /* more: lines that are not kept */
  bool sampled;           /* not all points were looked at */
  sweep_tally_line *list; /* [n] */
} sweep_tally;
/* Counts the differences of a point of another deck, and takes them over. */
void sweep_tally_add(sweep_tally *t, sweep_result *r);
/* "gravity.tilt: 0.1 there, 0.2 here (48 points)", to be freed. */
char *sweep_tally_text(const sweep_tally *t, size_t k);
void sweep_tally_free(sweep_tally *t);

/* Contents of the folder, by the names of files. */
enum { SWEEP_HAS_RESULT = 1, SWEEP_HAS_PARTS = 2 };
typedef struct sweep_contents {
  unsigned char *has; /* [n_points], bits */
  size_t known;       /* points that have any */
  size_t results, parts,
      failures;  /* of points that this sweep does not have: .h5, .h5.parts, .failed */
  char *example; /* name of such a point; NULL: there are none */
} sweep_contents;
void sweep_list(const sweep *s, sweep_contents *out);
/* "FOLDER has 9 results and 1 unfinished run of points that this sweep does not have, such as tilt=0", to be freed; NULL:
 * it has not. */
char *sweep_strangers_text(const sweep *s, const sweep_contents *c);
void sweep_contents_free(sweep_contents *c);
/* SD_ERROR_USER: results of points that this sweep does not have are there, and none of its own. instead: what is therefore not
 * done, "nothing is run". */
sd_status sweep_refuse_strangers(const sweep *s, const sweep_contents *c, const char *instead,
                                 sd_messages *messages);
/* SD_ERROR_USER: points that were counted have been run with another deck. */
sd_status sweep_refuse_others(const sweep *s, const sweep_tally *t, const char *instead,
                              sd_messages *messages);

/* Outcome of a point that sweep_run was given. */
typedef struct sweep_end {
  size_t point;
  sd_status ran; /* SD_INTERRUPTED: stopped at a checkpoint */
  sweep_status
      status; /* of the point after that; SWEEP_RUNNING: left to the process that runs it */
  const sd_messages *messages; /* till the call returns */
} sweep_end;

/* k counts the points given to sweep_run. */
typedef struct sweep_options {
  int threads; /* of a point alone; several together have one each */
  bool force;  /* run finished points again */
  volatile sig_atomic_t *stop;
  void (*progress)(void *user, size_t k, const session_progress *progress); /* may be NULL */
  void (*left)(void *user, size_t k,
               const sweep_end *end); /* of each point, once, when its time has come */
  void *user;
} sweep_options;

/* Runs points, or continues them, side by side (session.h). A finished one, and one that another process runs, are
 * left alone (SD_OK); the result of another deck, or a damaged one, is SD_ERROR_USER. Each point ends by itself:
 * when a run fails its messages are kept in NAME.failed, too, and the others go on. */
void sweep_run(const sweep *s, size_t n, const size_t *points, const sweep_options *options);
/* The model of a point and where its result goes (to be freed), for those who run it themselves. */
sd_status sweep_load(const sweep *s, size_t point, sd_model **model, char **result,
                     sd_messages *messages);
/* Keeps in NAME.failed why a point did not come to its end; NULL: it did, and the file goes. */
void sweep_note(const sweep *s, size_t point, const char *text);
void sweep_note_messages(const sweep *s, size_t point, const sd_messages *messages);

/* Which patterns of `collect` are columns of the table, when a point with this model is done; true ones stay. */
void sweep_columns(const sweep *s, size_t point, const sd_model *model, bool *collected);
/* Writes table.csv, table.h5 and means.csv from what the folder knows: sweep_table.c. One process does so at a time:
 * waits for another for so many seconds at most, after which it is SD_ERROR_USER. mix: also when there are points of
 * another deck, which else is SD_ERROR_USER, too. */
sd_status sweep_write_tables(const sweep *s, double patience, bool mix, sd_messages *messages);

#endif

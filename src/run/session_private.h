/* session_private.h: declarations shared by the source files of a session. */
#ifndef SLIPDISK_RUN_SESSION_PRIVATE_H
#define SLIPDISK_RUN_SESSION_PRIVATE_H

#include "io/results/checkpoint.h"
#include "io/store/folder.h"
#include "io/results/record.h"
#include "run/session.h"

/* Decisions that rank 0 makes and broadcasts before each chunk of steps. */
typedef struct session_signals {
  int64_t chunk; /* length of the next chunk, in steps */
  /* stopped: 1 if a signal asks to stop, else 0; save: 1 if a checkpoint is due, else 0 */
  int32_t stopped, save;
} session_signals;

struct session {
  const sd_model *model;
  session_options options; /* copy of the caller's options, with copies of the strings */
  char *result;
  sd_simulation *simulation;
  folder parts_folder; /* folder of the run's part files and checkpoints; lock < 0: not open */
  /* rows in memory that are not yet written: `rows` from a run in one process, `shared` while disks
   * are distributed over ranks; one of them is empty */
  record rows, shared;
  size_t shared_bytes; /* bytes of the rows that all ranks have in memory in addition to `shared` */
  provenance origin;
  summary found;
  bool has_found; /* true: `found` is set */
  bool was_finished;
  bool fresh;         /* true: the session began at step 0, not from a checkpoint */
  int64_t parts;      /* number of part files written */
  uint64_t last_part; /* checksum of the last part file */
  /* identity (session_identity) of the existing result that may be replaced; "": none */
  char *replaces;
  /* step at which the session began, present step, largest number of steps; step of the last
   * checkpoint, -1: none yet */
  int64_t began, step, steps, saved_step;
  /* clock readings, s: at the last checkpoint, at the last update of origin.wall_seconds */
  double saved_at, wall_mark;
  /* clock reading at the last progress report, s; recent number of steps per second */
  double told_at, rate;
  /* shortest time until the next progress report, s (session_report) */
  double tell_every;
  int64_t told_step, told_phase;
  session_signals world;
};

/* Returns true on rank 0, and in a run in one process: there, all files are written.
 *
 * Functions below that return a status are collective, except session_identity and
 * session_may_publish; session_poll and session_report are collective, too. */
bool session_leads(const session *s);
/* session_due returns bits (RECORD_SERIES ...) that tell which rows are to be sampled at this stage
 * of the run; session_next returns the next step at which rows may be due, and must not be called
 * when the run is over. */
unsigned session_due(const sd_model *model, sd_stage now);
int64_t session_next(const sd_model *model, sd_stage now);
/* Samples rows of the present state for the tables selected by the bits of `what`. */
sd_status session_sample(session *s, unsigned what, sd_messages *messages);
/* Writes the rows in memory to a part file, writes a checkpoint, and removes older checkpoints. */
sd_status session_checkpoint(session *s, sd_messages *messages);
/* Identifies the file at the path of the result: *id is the run_id if it is a result, else a text
 * with its size and time; "": no file. The caller frees *id. */
sd_status session_identity(const session *s, char **id, sd_messages *messages);
/* Checks that the result may be written: there is no file at its path, or it is the one that may be
 * replaced. kind: status that is returned if not. */
sd_status session_may_publish(const session *s, sd_status kind, sd_messages *messages);
/* Returns true if this rank has received a signal that asks to stop. */
bool session_is_stopped(const session *s);
/* Sets s->world on all ranks to the values of rank 0: whether a signal asks to stop, whether a
 * checkpoint is due, and the length of the next chunk of steps. */
void session_poll(session *s, int64_t chunk);
/* Reports progress if the time for the next report has come, or if `always` is true. */
void session_report(session *s, bool always);

/* Does what is due after a chunk of steps that ended with `status`: samples rows, writes a part
 * file if the rows in memory take more than most_bytes, reports progress. If `status` is
 * SD_ERROR_NUMERIC, writes the state to an emergency file. */
sd_status session_step(session *s, sd_status status, size_t most_bytes, sd_messages *messages);
/* Writes a checkpoint unless the last one is of the present step, and returns SD_INTERRUPTED. */
sd_status session_stop(session *s, sd_messages *messages);
/* Merges the part files of a run that is over into the result, and warns of goals that were not
 * reached. */
sd_status session_finish(session *s, sd_messages *messages);

#endif

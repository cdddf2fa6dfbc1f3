/* session_private.h: declarations shared by the source files of a session. */
#ifndef SLIPDISK_RUN_SESSION_PRIVATE_H
#define SLIPDISK_RUN_SESSION_PRIVATE_H

#include "io/results/checkpoint.h"
#include "io/store/folder.h"
#include "io/results/record.h"
#include "run/session.h"

/* Facts that only rank 0 finds out; it broadcasts them before each chunk of steps. */
typedef struct session_world {
  int64_t chunk; /* length of the next chunk, steps */
  /* 1: a signal asks to stop; 1: a checkpoint is due */
  int32_t stopped, save;
} session_world;

struct session {
  const sd_model *model;
  session_options options; /* options of the caller; strings point to copies */
  char *result;
  sd_simulation *simulation;
  folder parts_folder; /* open folder of the parts; lock < 0: not open */
  /* rows sampled in one process, and rows sampled while the disks are distributed over ranks; one
   * of them is empty */
  record rows, shared;
  size_t shared_bytes; /* bytes of the rows of all ranks that belong to `shared` */
  provenance origin;
  summary found;
  bool has_found; /* true if `found` is set */
  bool was_finished;
  bool fresh;         /* true if no checkpoint to continue was found */
  int64_t parts;      /* number of sealed parts */
  uint64_t last_part; /* checksum in the seal of the last part */
  /* identity (session_identity) of the result that may be replaced; "": none */
  char *replaces;
  /* first step of the session, current step, largest number of steps; step of the last checkpoint,
   * -1: none yet */
  int64_t began, step, steps, saved_step;
  /* wall times of the last checkpoint and of the last update of wall_seconds, s */
  double saved_at, wall_mark;
  double told_at, rate; /* wall time of the last report, s; steps per second */
  /* shortest time between two reports, s (session_report) */
  double tell_every;
  int64_t told_step, told_phase;
  session_world world;
};

/* Returns true on rank 0, or if the process is alone: only it writes files. The functions below
 * that return a status are collective, except session_identity and session_may_publish; so are
 * session_look and session_report. */
bool session_leads(const session *s);
/* session_due returns the bits of the rows (RECORD_SERIES ...) to be sampled at this stage;
 * session_next the next step at which some may be due, of a run that is not over. */
unsigned session_due(const sd_model *model, sd_stage now);
int64_t session_next(const sd_model *model, sd_stage now);
/* Samples the present state into the tables that the bits of `what` select. */
sd_status session_sample(session *s, unsigned what, sd_messages *messages);
/* Seals the rows into a part, writes a checkpoint and removes older ones. */
sd_status session_checkpoint(session *s, sd_messages *messages);
/* Identifies the file at the path of the result: run_id of a result, else size and time; "": no
 * file. The caller frees *id. */
sd_status session_identity(const session *s, char **id, sd_messages *messages);
/* Checks that the result may get its name: there is no file of this name, or it is the one that may
 * be replaced. kind: status of a refusal. */
sd_status session_may_publish(const session *s, sd_status kind, sd_messages *messages);
/* Returns true if this rank was asked to stop by a signal. */
bool session_is_stopped(const session *s);
/* Sets s->world on all ranks as on rank 0: whether a signal came, whether a checkpoint is due, and
 * the length of the next chunk of steps. */
void session_look(session *s, int64_t chunk);
/* Reports progress if the time for the next report has come, or if `always` is true. */
void session_report(session *s, bool always);

/* Does what is due after a chunk of steps that ended with `status`: samples, seals a part if its
 * rows take more than most_bytes, reports progress. SD_ERROR_NUMERIC: the state is kept in an
 * emergency file. */
sd_status session_step(session *s, sd_status status, size_t most_bytes, sd_messages *messages);
/* Writes a checkpoint if the last one is older than the current step, and returns
 * SD_INTERRUPTED. */
sd_status session_stop(session *s, sd_messages *messages);
/* Merges the parts of a run that is over, and warns of goals that were not met. */
sd_status session_finish(session *s, sd_messages *messages);

#endif

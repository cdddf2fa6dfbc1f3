/* session_private.h: what the files of a session share. */
#ifndef SLIPDISK_RUN_SESSION_PRIVATE_H
#define SLIPDISK_RUN_SESSION_PRIVATE_H

#include "io/results/checkpoint.h"
#include "io/store/folder.h"
#include "io/results/record.h"
#include "run/session.h"

/* Facts of the world, which rank 0 tells the others once before each chunk of steps. */
typedef struct session_world {
  int64_t chunk; /* steps */
  int32_t stopped, save;
} session_world;

struct session {
  const sd_model *model;
  session_options options; /* its strings are ours */
  char *result;
  sd_simulation *simulation;
  folder parts_folder; /* lock < 0: not open */
  record rows,
      shared; /* shared: sampled while the disks are spread over ranks; one of them is empty */
  size_t shared_bytes; /* of the ranks' rows of shared */
  provenance origin;
  summary found;
  bool has_found;
  bool was_finished;
  bool fresh;         /* nothing to continue was found */
  int64_t parts;      /* sealed */
  uint64_t last_part; /* sum in the seal of the last of them */
  char *replaces;     /* identity of the result that may be replaced; "": none */
  int64_t began, step, steps, saved_step; /* saved_step -1: no checkpoint yet */
  double saved_at, wall_mark;
  double told_at, rate; /* progress */
  double tell_every;    /* s, see session_report */
  int64_t told_step, told_phase;
  session_world world;
};

/* This is rank 0, or alone: it has the files. Functions below that return a status are collective
 * but for session_identity and session_may_publish; so are session_look and session_report. */
bool session_leads(const session *s);
/* Rows to be recorded now, and the next step at which some may be due; the run is not over. */
unsigned session_due(const sd_model *model, sd_stage now);
int64_t session_next(const sd_model *model, sd_stage now);
sd_status session_sample(session *s, unsigned what, sd_messages *messages);
sd_status session_checkpoint(session *s, sd_messages *messages);
/* Which file lies at the result's name: run_id of a result, else size and time; "": none. To be freed. */
sd_status session_identity(const session *s, char **id, sd_messages *messages);
/* May the result get its name? Not when another file has appeared there than the one that is to be replaced. `kind` is the
 * status of a refusal. */
sd_status session_may_publish(const session *s, sd_status kind, sd_messages *messages);
/* A signal has come to this rank. */
bool session_is_stopped(const session *s);
/* Fills s->world, with this chunk. */
void session_look(session *s, int64_t chunk);
/* Tells how far it is, when it is time again, or always. */
void session_report(session *s, bool always);

/* After steps were taken, with what the simulation has said of them: samples, seals a part when its rows take more than
 * so many bytes, reports. SD_ERROR_NUMERIC: the state is kept. */
sd_status session_step(session *s, sd_status status, size_t most_bytes, sd_messages *messages);
/* Stops at a checkpoint: SD_INTERRUPTED. */
sd_status session_stop(session *s, sd_messages *messages);
/* The run is over: merges, and warns of goals that were not reached. */
sd_status session_finish(session *s, sd_messages *messages);

#endif

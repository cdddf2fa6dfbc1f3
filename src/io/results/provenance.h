/* provenance.h: records the origin of a result: deck, versions, machine, time taken. It is
 * stored in /parameters of every checkpoint and of the finished file. */
#ifndef SLIPDISK_IO_PROVENANCE_H
#define SLIPDISK_IO_PROVENANCE_H

#include "io/store/h5.h"
#include "measure/observable.h"

typedef struct provenance {
  char *run_id; /* unique identifier of the run, 32 hexadecimal digits */
  /* deck: path as given, text, overrides, completed deck, list of bodies */
  char *deck_path, *deck_text, *deck_overrides, *deck_full, *deck_bodies;
  char *directory; /* working directory when the run was started: deck_path may be relative to it */
  char *title;
  /* author, host name, times of start and end (UTC, ISO 8601) */
  char *author, *host, *started, *ended;
  char *version, *revision, *compiler, *hdf5, *gsl, *libconfig, *cpu_path;
  int64_t seed;
  int64_t inputs; /* checksum of the model's input files (provenance_inputs); 0: not known */
  int64_t threads, ranks; /* threads per rank; MPI ranks */
  int64_t sessions;       /* number of times that the run was started or continued */
  double wall_seconds;    /* wall time of all sessions up to their last checkpoint, s */
  double step_seconds;    /* part of wall_seconds spent on advancing the simulation, s */
} provenance;

/* Returns a checksum of the model data that may come from input files and are not spelled out in
 * the completed deck: constants of disks, tables of motions, contacts of a packing, and walls that
 * came with it. Never 0. */
int64_t provenance_inputs(const sd_model *model);
/* Fills p for a run that starts now, with a new run_id. The texts are p's own (provenance_free). */
void provenance_new(provenance *p, const sd_model *model);
/* Updates host, versions, end time, ranks and threads to those of this process. cpu_path:
 * instruction set, as sd_simulation_path returns it. */
void provenance_refresh(provenance *p, int ranks, int threads, const char *cpu_path);
void provenance_free(provenance *p);
/* Writes the groups /h5md and /parameters. */
void provenance_write(const provenance *p, h5_file *file);
/* Reads p from /parameters; missing texts become "", missing numbers 0 or NAN. */
void provenance_read(provenance *p, const h5_file *file);

/* Returns the path of the deck: as given, or, if it is relative and exists only there, below the
 * directory in which the run was started. The caller frees it; never NULL. */
char *provenance_deck(const char *deck, const char *directory);

/* Text members that are stored as attributes of /parameters; `info` prints them. */
typedef struct provenance_text {
  const char *name;
  size_t offset; /* offset of the char * in provenance */
} provenance_text;
extern const provenance_text provenance_texts[];
extern const size_t provenance_text_count;
/* numbers of provenance that are stored as attributes of /parameters, besides seed and inputs */
extern const observable_list provenance_observables;
/* Returns text k of provenance_texts; "" if it is not set. */
const char *provenance_get(const provenance *p, size_t k);

#endif

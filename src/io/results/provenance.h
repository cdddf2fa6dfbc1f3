/* provenance.h: where a result comes from: deck, versions, machine, time taken. Stored in /parameters of
 * every checkpoint and of the finished file. */
#ifndef SLIPDISK_IO_PROVENANCE_H
#define SLIPDISK_IO_PROVENANCE_H

#include "io/store/h5.h"
#include "measure/observable.h"

typedef struct provenance {
  char *run_id; /* tells runs apart; 32 hexadecimal digits */
  char *deck_path, *deck_text, *deck_overrides, *deck_full, *deck_bodies;
  char *directory; /* in which the run was started: deck_path may be relative to it */
  char *title;
  char *author, *host, *started, *ended; /* times are UTC, ISO 8601 */
  char *version, *revision, *compiler, *hdf5, *gsl, *libconfig, *cpu_path;
  int64_t seed;
  int64_t inputs; /* provenance_inputs of the model; 0: not known */
  int64_t threads, ranks;
  int64_t sessions;    /* times the run was started or continued */
  double wall_seconds; /* of all sessions, as far as they reached a checkpoint */
  double step_seconds; /* of these, spent advancing */
} provenance;

/* A number that stands for what a model may have from files and the full deck does not spell out: constants
 * of the disks, tables of the motions, contacts of a packing and the walls that came with them. Never 0. */
int64_t provenance_inputs(const sd_model *model);
/* Describes a run that starts now. */
void provenance_new(provenance *p, const sd_model *model);
/* Brings machine, versions, ranks and threads up to this process; cpu_path as sd_simulation_path
 * says. */
void provenance_refresh(provenance *p, int ranks, int threads, const char *cpu_path);
void provenance_free(provenance *p);
void provenance_write(const provenance *p, h5_file *file);
/* Absent texts are "". */
void provenance_read(provenance *p, const h5_file *file);

/* The deck's path as it was given, or from the folder in which the run was started when that is
 * another; to be freed, never NULL. */
char *provenance_deck(const char *deck, const char *directory);

/* The texts that are attributes of /parameters, for info. */
typedef struct provenance_text {
  const char *name;
  size_t offset; /* of the char * in provenance */
} provenance_text;
extern const provenance_text provenance_texts[];
extern const size_t provenance_text_count;
extern const observable_list
    provenance_observables; /* the numbers that are; of provenance, beside seed and inputs */
const char *provenance_get(const provenance *p, size_t k);

#endif

/* provenance.h: records the origin of a result: deck, versions, machine, run time. It is stored in
 * /parameters of every checkpoint and of the finished result. */
#ifndef SLIPDISK_IO_PROVENANCE_H
#define SLIPDISK_IO_PROVENANCE_H

#include "io/store/h5.h"
#include "measure/observable.h"

typedef struct provenance {
  char *run_id; /* unique identifier of the run, 32 hexadecimal digits */
  /* deck: path as given, text, overrides, completed deck, list of bodies */
  char *deck_path, *deck_text, *deck_overrides, *deck_full, *deck_bodies;
  char *directory; /* working directory at the start of the run: deck_path may be relative to it */
  char *title;
  /* author, host name, times of start and end of the run (UTC, ISO 8601) */
  char *author, *host, *started, *ended;
  char *version, *revision, *compiler, *hdf5, *gsl, *libconfig, *cpu_path;
  int64_t seed;
  int64_t inputs; /* checksum of the model's input files (provenance_inputs); 0: not known */
  int64_t threads, ranks; /* number of threads per rank; number of MPI ranks */
  int64_t sessions;       /* number of times that the run was started or continued */
  double wall_seconds;    /* wall time of all starts of the run up to their last checkpoint, s */
  double step_seconds;    /* part of wall_seconds spent on advancing the simulation, s */
} provenance;

/* Returns a checksum of those data of the model that may come from input files and are not written
 * out in the completed deck: constants of disks, tables of motions, contacts of a packing, and
 * walls of that packing. It is never 0. */
int64_t provenance_inputs(const sd_model *model);
/* Fills p for a run that starts now, with a new run_id. p owns the texts (provenance_free). */
void provenance_new(provenance *p, const sd_model *model);
/* Updates host, versions, end time, ranks and threads to those of this process. cpu_path: name of
 * the instruction set, as sd_simulation_path returns it. */
void provenance_refresh(provenance *p, int ranks, int threads, const char *cpu_path);
void provenance_free(provenance *p);
/* Writes p to the groups /h5md and /parameters of a file. */
void provenance_write(const provenance *p, h5_file *file);
/* Reads p from the group /parameters of a file; missing texts become "", missing numbers 0 or
 * NAN. */
void provenance_read(provenance *p, const h5_file *file);

/* Returns the path of the deck: `deck` itself, or, if it is relative and exists only there, `deck`
 * below the directory in which the run was started. The caller frees the path; it is never NULL. */
char *provenance_deck(const char *deck, const char *directory);

/* Description of a text member of provenance that is stored as an attribute of /parameters; the
 * command `info` prints these texts. */
typedef struct provenance_text {
  const char *name;
  size_t offset; /* offset of the text (char *) in struct provenance */
} provenance_text;
extern const provenance_text provenance_texts[];
extern const size_t provenance_text_count;
/* descriptions of the numbers in struct provenance that are stored as attributes of /parameters;
 * seed and inputs are stored, too */
extern const observable_list provenance_observables;
/* Returns text number k of provenance_texts; "" if it is not set. */
const char *provenance_get(const provenance *p, size_t k);

#endif

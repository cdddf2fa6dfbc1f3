/* summary.h: what a run has found so far: means with errors, sliding fractions, energy budget, cost.
 * Computed with every checkpoint and stored in it and in the finished file, as /summary, so that `info`
 * reads a few numbers whatever the size of the file. */
#ifndef SLIPDISK_IO_SUMMARY_H
#define SLIPDISK_IO_SUMMARY_H

#include "io/h5.h"
#include "slipdisk/measure.h"
#include "slipdisk/simulation.h"

typedef struct summary {
  int64_t step, steps; /* done, of all phases; with `until` steps is the most */
  double dt;
  int64_t phase, phases; /* index, number */
  char *phase_name;      /* "" when finished */
  int64_t measured;      /* steps measured */
  int64_t disks, walls, contacts;
  double step_nanoseconds; /* wall time per step; NAN before the first */
  sd_energy energy;
  size_t n_rotations, n_slides;
  sd_rotation *rotations;
  sd_slide *slides;
  char **rotation_names; /* [n_rotations] */
  char **slide_names;    /* [3 n_slides]: disk, first and second partner */
  bool has_until;        /* the deck has `until`, and what follows */
  char *observable;      /* "upper.omega" */
  double relative;       /* the goal as a fraction of the mean; NAN: it was given as it stands in `goal` */
  sd_goal goal;
  int64_t until_step; /* at which the run ended because its goal was reached; -1: it was not, or not yet */
} summary;

/* summary_free also when it fails. */
sd_status summary_collect(summary *s, const sd_model *model, const sd_state *state, const sd_energy *energy,
                          double step_nanoseconds, sd_messages *messages);
void summary_free(summary *s);
void summary_write(const summary *s, h5_file *file);
sd_status summary_read(summary *s, const h5_file *file, sd_messages *messages);

#endif

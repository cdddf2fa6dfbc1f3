/* summary.h: what a run has found so far: means with errors, sliding fractions, energy budget, cost.
 * Computed with every checkpoint and stored in it and in the finished file, as /summary, so that `info`
 * reads a few numbers whatever the size of the file. */
#ifndef SLIPDISK_IO_SUMMARY_H
#define SLIPDISK_IO_SUMMARY_H

#include "base/exact_sum.h"
#include "io/store/h5.h"
#include "io/results/summary_disks.h"
#include "io/results/summary_doubts.h"
#include "measure/observable.h"
#include "slipdisk/measure.h"
#include "slipdisk/simulation.h"

/* A phase that is over, or is not yet (steps 0). Values are those at its end, 0 where nothing was asked. */
typedef struct summary_phase {
  int64_t steps, most; /* taken, and its length */
  int32_t asked;       /* bit 0: to settle, bit 1: to compress */
  int32_t reached;     /* what was asked for was there */
  double kinetic, kinetic_goal, unbalanced, unbalanced_goal; /* 0: no goal */
  double target, target_goal;                                /* pressure or packing fraction */
} summary_phase;
enum { SUMMARY_SETTLE = 1, SUMMARY_COMPRESS = 2 };

struct summary {
  int64_t step,
      steps; /* done, of all phases; the most that there can be, as phases may end early */
  double dt;
  int64_t phase, phases; /* index, number */
  char *phase_name;      /* "" when finished */
  int64_t measured;      /* steps measured */
  int64_t disks, walls, contacts;
  int64_t waiting, outside,
      left;   /* disks: not yet released, beyond the bounds or taken out; times one left */
  char *lost; /* the first of those outside: "disk 3 at (1, -5), ..."; "" for none */
  double step_nanoseconds; /* wall time per step; NAN before the first */
  sd_energy energy;
  size_t n_rotations, n_slides, n_configurations, n_stages;
  summary_phase *stages;
  char **stage_names; /* [n_stages] */
  sd_rotation *rotations;
  sd_slide *slides;
  sd_configuration *configurations; /* SD_CONFIGURATIONS of each slide, or none */
  char **rotation_names;            /* [n_rotations] */
  char **slide_names;               /* [3 n_slides]: disk, first and second partner */
  char **configuration_names;       /* [n_configurations]: "upper.pp" */
  summary_disks packing;            /* means of every free disk; n = 0: not asked for */
  bool has_until;                   /* the deck has `until`, and what follows */
  char *observable;                 /* "upper.omega" */
  double
      relative; /* the goal as a fraction of the mean; NAN: it was given as it stands in `goal` */
  sd_goal goal;
  int64_t
      until_step; /* at which the run ended because its goal was reached; -1: it was not, or not yet */
  summary_doubt doubts[DOUBT_KINDS];
};

/* In names of columns: "pp", "pm", "mp", "mm", "stick", "open". */
extern const char *const summary_configurations[];

extern const observable_list fact_observables;    /* of summary */
extern const observable_list outcome_observables; /* of summary */
extern const observable_list until_observables;   /* of summary */
extern const observable_list phase_observables;   /* of summary_phase */

/* Sizes and names, from the model alone; no values. */
void summary_new(summary *s, const sd_model *model);
enum { SUMMARY_LOST = 8 }; /* told one by one */
/* Disks that are beyond the bounds or taken out: how many, and the first of them in the order of
 * slots. */
typedef struct summary_lost {
  int64_t n;
  size_t told;
  struct summary_lost_disk {
    uint32_t disk, order;
    double x, y;
  } first[SUMMARY_LOST];
} summary_lost;

/* Sums over all disks and contacts, which may be on several ranks. */
typedef struct summary_sums {
  size_t contacts;     /* closed */
  exact_sum overlap;   /* theirs */
  double farthest;     /* |x| + |y| + radius of a disk */
  unsigned not_finite; /* bits of the columns that have such a number (summary_doubts.c) */
  summary_lost lost;
} summary_sums;
summary_sums summary_sums_of(const sd_state *state);

/* All but the means of every disk: summary_disks_collect. Of the state the rest is taken: of
 * prescribed bodies, motions, the run. sums NULL: the state has all disks. */
void summary_collect(summary *s, const sd_model *model, const sd_state *state,
                     const summary_sums *sums, const sd_energy *energy, double step_nanoseconds);
void summary_free(summary *s);
/* Is this a column of the tables of sweeps: of a point, or (of_body) behind the name of a watched disk or contact? */
bool summary_is_column(const char *name, bool of_body);
void summary_write(const summary *s, h5_file *file);
/* summary_free also when it fails. */
sd_status summary_read(summary *s, const h5_file *file, sd_messages *messages);
/* Means and error bars of watched disks as this program takes them from the bins in the file's state, whichever version
 * ran it. Without such bins nothing changes. */
void summary_renew(summary *s, const sd_model *model, const h5_file *file);

#endif

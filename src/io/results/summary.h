/* summary.h: what a run has found so far: means with errors, sliding fractions, energy budget, cost.
 * Computed with every checkpoint and stored in it and in the finished file, as /summary, so that `info`
 * reads a few numbers whatever the size of the file. */
#ifndef SLIPDISK_IO_SUMMARY_H
#define SLIPDISK_IO_SUMMARY_H

#include "base/exact_sum.h"
#include "io/store/h5.h"
#include "measure/observable.h"
#include "model/model.h"
#include "model/state.h"
#include "slipdisk/measure.h"
#include "slipdisk/simulation.h"

/* --- Means of every free disk of a packing: /summary/disks -------------------------------------- */

/* The fastest disks are kept apart, so that a report needs to read no more than these. */
enum { SUMMARY_FASTEST = 10 };

typedef struct summary_disks {
  size_t n;            /* disks; 0: the deck does not ask for their means */
  sd_disk_mean *disks; /* NULL: they have not been read, see summary_disks_read_all */
  bool later; /* the file has only the state from which they follow, see checkpoint_complete */
  size_t n_fastest;
  sd_disk_mean fastest[SUMMARY_FASTEST]; /* those with the largest |Omega|, which is not 0 */
  sd_disk_totals totals;
  int64_t looks, bins; /* at the contacts; of the angle records */
  double measured;     /* time */
} summary_disks;

/* A record of fewer bins has no error bars. */
enum { SUMMARY_FEWEST_BINS = 16 };

/* Checkpoints of so many disks or more, and over ranks, leave the means to those that read them:
 * they follow from the state, and take longer than writing it. */
enum { SUMMARY_LATER = 16384 };

/* Of how many disks and what length the means will be. */
void summary_disks_announce(summary_disks *s, const sd_model *model, const sd_state *state);
/* summary_disks_free also when it fails. */
sd_status summary_disks_collect(summary_disks *s, const sd_model *model, const sd_state *state,
                                int threads, sd_messages *messages);
/* The same in two steps: means of the first n slots of a state with some disks; and from those of
 * all, in the order of slots, with id, radius and contacts of the whole state. */
void summary_disks_means(sd_disk_mean *means, size_t n, const sd_model *model,
                         const sd_state *state, int threads);
sd_status summary_disks_take(summary_disks *s, const sd_model *model, const sd_state *state,
                             const sd_disk_mean *means, sd_messages *messages);
void summary_disks_free(summary_disks *s);
/* Writes nothing when there are no disks, and how many when no more is known. */
void summary_disks_write(const summary_disks *s, h5_file *file);
/* All but the means of each disk. */
sd_status summary_disks_read(summary_disks *s, const h5_file *file, sd_messages *messages);
/* These as well, unless they come later. */
sd_status summary_disks_read_all(summary_disks *s, const h5_file *file, sd_messages *messages);

/* --- Doubts -------------------------------------------------------------------------------------- */

/* Reasons to doubt a result that came to its end: beyond a limit of the deck (sd_limits), or not finite.
 * Judged in one place, when the summary is collected, and stored with it: run, info and sweep tell the same. */

typedef enum doubt_kind {
  DOUBT_RESIDUAL,     /* the energy budget does not close */
  DOUBT_OPEN,         /* watched contacts were open nearly all the time */
  DOUBT_DISPLACEMENT, /* a disk or a prescribed body moved too far in one step */
  DOUBT_FINITE,       /* a number that should be there is none */
  DOUBT_UNSTABLE,     /* dt is beyond the limit of stability */
  DOUBT_KINDS
} doubt_kind;
/* Name, what value and limit are, and what is said of many points of a sweep: "3 points WHOSE". */
extern const struct doubt_row { const char *name, *meaning, *whose; } doubt_kinds[DOUBT_KINDS];

typedef struct summary_doubt {
  char *text; /* one line; NULL: no such doubt */
  double value, limit;
} summary_doubt;

/* --- The summary ---------------------------------------------------------------------------------- */

/* A phase that is over, or is not yet (steps 0). Values are those at its end, 0 where nothing was asked. */
typedef struct summary_phase {
  int64_t steps, most; /* taken, and its length */
  int32_t asked;       /* bit 0: to settle, bit 1: to compress */
  int32_t reached;     /* what was asked for was there */
  double kinetic, kinetic_goal, unbalanced, unbalanced_goal; /* 0: no goal */
  double target, target_goal;                                /* pressure or packing fraction */
} summary_phase;
enum { SUMMARY_SETTLE = 1, SUMMARY_COMPRESS = 2 };

typedef struct summary {
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
} summary;

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

/* Compares the summary with these limits; model, state, sums: of the run, NULL where only the
 * summary is known. */
void summary_judge(summary *s, const sd_limits *limits, const sd_model *model,
                   const sd_state *state, const summary_sums *sums);
/* Members farthest and not_finite of summary_sums, from one state. */
double summary_farthest(const sd_state *state);
unsigned summary_not_finite(const sd_state *state);
/* How many; and their texts, joined by "; ", to be freed, never NULL. */
size_t summary_doubts(const summary *s);
char *summary_doubts_text(const summary *s);

void summary_doubts_free(summary *s);
void summary_doubts_write(const summary *s, h5_file *file);
/* Files of older versions have none: these are judged by the limits that held then. */
sd_status summary_doubts_read(summary *s, const h5_file *file, sd_messages *messages);

#endif

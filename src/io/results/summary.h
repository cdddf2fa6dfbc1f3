/* summary.h: summary of the results of a run so far: means with errors, sliding fractions, energy
 * budget, cost. It is computed with every checkpoint and stored as /summary, there and in the
 * finished file, so that `info` reads a few numbers whatever the size of the file. */
#ifndef SLIPDISK_IO_SUMMARY_H
#define SLIPDISK_IO_SUMMARY_H

#include "base/exact_sum.h"
#include "io/store/h5.h"
#include "measure/observable.h"
#include "model/model.h"
#include "model/state.h"
#include "slipdisk/measure.h"
#include "slipdisk/simulation.h"

/* --- Means of every free disk of a packing: /summary/disks ------------------------------------ */

/* Number of fastest disks that are stored separately, so that a report reads only these. */
enum { SUMMARY_FASTEST = 10 };

/* Means of every free disk, with the fastest disks and totals over all disks. */
typedef struct summary_disks {
  size_t n; /* number of disks; 0: the deck does not ask for their means */
  /* [n] means of each disk, by body number; NULL: not read (see summary_disks_read_all) */
  sd_disk_mean *disks;
  /* true if the file stores only the state from which the means follow (checkpoint_complete) */
  bool later;
  size_t n_fastest;
  /* disks of largest |Omega|, in descending order; disks with Omega = 0 or unknown are left out */
  sd_disk_mean fastest[SUMMARY_FASTEST];
  sd_disk_totals totals;
  int64_t looks, bins; /* number of samples of the contacts; full bins of the angle records */
  double measured;     /* measured time */
} summary_disks;

/* Smallest number of bins of an angle record from which an error bar is computed. */
enum { SUMMARY_FEWEST_BINS = 16 };

/* From this number of disks on, and in runs over several ranks, checkpoints do not store the means:
 * readers compute them from the state, since this takes longer than writing it. */
enum { SUMMARY_LATER = 16384 };

/* Sets the number of disks, samples and bins and the measured time; computes no means. */
void summary_disks_announce(summary_disks *s, const sd_model *model, const sd_state *state);
/* Computes the means of every disk, the fastest disks and the totals. Call summary_disks_free also
 * after a failure. */
sd_status summary_disks_collect(summary_disks *s, const sd_model *model, const sd_state *state,
                                int threads, sd_messages *messages);
/* Do the same in two steps. summary_disks_means computes the means of the disks in slots [0, n) of
 * a state, which may hold only some of the disks. summary_disks_take takes the means of all disks,
 * in the order of slots, sorts them by body number and adds the fastest disks and totals; it needs
 * id, radius and contacts of the whole state. */
void summary_disks_means(sd_disk_mean *means, size_t n, const sd_model *model,
                         const sd_state *state, int threads);
sd_status summary_disks_take(summary_disks *s, const sd_model *model, const sd_state *state,
                             const sd_disk_mean *means, sd_messages *messages);
void summary_disks_free(summary_disks *s);
/* Writes the group /summary/disks; nothing if n = 0, only the counts if disks is NULL. */
void summary_disks_write(const summary_disks *s, h5_file *file);
/* Reads everything except the means of each disk. */
sd_status summary_disks_read(summary_disks *s, const h5_file *file, sd_messages *messages);
/* Reads the means of each disk, unless they have to be computed from the state (later). */
sd_status summary_disks_read_all(summary_disks *s, const h5_file *file, sd_messages *messages);

/* --- Doubts about a result -------------------------------------------------------------------- */

/* Reasons to doubt the result of a finished run: a number exceeds a limit of the deck (sd_limits)
 * or is not finite. They are judged once, when the summary is collected, and stored with it, so
 * that run, info and sweep report the same. */

typedef enum doubt_kind {
  DOUBT_RESIDUAL,     /* the energy budget does not close */
  DOUBT_OPEN,         /* watched contacts were open nearly all of the measured time */
  DOUBT_DISPLACEMENT, /* a disk or a prescribed body moved too far in one step */
  DOUBT_FINITE,       /* a number of the result is not finite */
  DOUBT_UNSTABLE,     /* dt exceeds the limit of stability */
  DOUBT_KINDS
} doubt_kind;
/* Texts for each kind of doubt: name; meaning of value and limit; end of a sentence about points of
 * a sweep, "3 points WHOSE". */
extern const struct doubt_row { const char *name, *meaning, *whose; } doubt_kinds[DOUBT_KINDS];

typedef struct summary_doubt {
  char *text; /* warning, one line; NULL: no doubt of this kind */
  double value, limit;
} summary_doubt;

/* --- The summary ------------------------------------------------------------------------------ */

/* Outcome of one phase. The values are those at its end; 0: not asked for, or phase not over. */
typedef struct summary_phase {
  int64_t steps, most; /* steps taken, 0: not over; largest number of steps that it may take */
  int32_t asked;       /* goals of the phase: SUMMARY_SETTLE, SUMMARY_COMPRESS, or both (bits) */
  int32_t reached;     /* 1: the phase ended because its goals were met */
  /* kinetic energy per disk; mean unbalanced force on a disk over mean contact force (0: no
   * goal) */
  double kinetic, kinetic_goal, unbalanced, unbalanced_goal;
  double target, target_goal; /* pressure or packing fraction, with its goal; 0: no goal */
} summary_phase;
enum { SUMMARY_SETTLE = 1, SUMMARY_COMPRESS = 2 };

/* Results of a run so far. */
typedef struct summary {
  /* steps done in all phases; largest number of steps, since phases may end early */
  int64_t step, steps;
  double dt;
  /* index of the running phase, `phases` at the end of the run; number of phases */
  int64_t phase, phases;
  char *phase_name; /* name of the running phase; "": it has none, or the run is finished */
  int64_t measured; /* number of measured steps */
  int64_t disks, walls, contacts; /* numbers of disks, walls, closed contacts */
  /* number of disks not yet released; of disks beyond the bounds or removed; number of times that a
   * disk left the bounds */
  int64_t waiting, outside, left;
  char *lost;              /* first disks beyond the bounds: "disk 3 at (1, -5), ..."; "": none */
  double step_nanoseconds; /* wall time per step, ns; NAN before the first step */
  sd_energy energy;
  /* lengths of the arrays below */
  size_t n_rotations, n_slides, n_configurations, n_stages;
  summary_phase *stages; /* [n_stages] outcome of each phase */
  char **stage_names;    /* [n_stages] names of the phases */
  /* [n_rotations] watched disks, [n_slides] watched pairs of contacts */
  sd_rotation *rotations;
  sd_slide *slides;
  /* [n_configurations] SD_CONFIGURATIONS of each slide; none unless the deck asks for them */
  sd_configuration *configurations;
  char **rotation_names;      /* [n_rotations] names of the watched disks */
  char **slide_names;         /* [3 n_slides] names of disk, first partner, second partner */
  char **configuration_names; /* [n_configurations] names of configurations, such as "upper.pp" */
  summary_disks packing;      /* means of every free disk; n = 0: the deck does not ask for them */
  bool has_until;   /* true if the deck has `until`; the members below are valid only then */
  char *observable; /* name of the observable, such as "upper.omega" */
  /* goal as a fraction of the mean; NAN: the deck gives the error bar itself (goal.goal) */
  double relative;
  sd_goal goal;
  int64_t until_step; /* step at which the run ended because its goal was met; -1: not met so far */
  summary_doubt doubts[DOUBT_KINDS]; /* indexed by doubt_kind; text NULL: no such doubt */
} summary;

/* Names of the sliding configurations in names of columns: "pp", "pm", "mp", "mm", "stick",
 * "open". */
extern const char *const summary_configurations[];

extern const observable_list fact_observables;    /* rows describe a summary */
extern const observable_list outcome_observables; /* rows describe a summary */
extern const observable_list until_observables;   /* rows describe a summary */
extern const observable_list phase_observables;   /* rows describe a summary_phase */

/* Allocates the summary of a model and sets its sizes and names; values are 0. */
void summary_new(summary *s, const sd_model *model);
enum { SUMMARY_LOST = 8 }; /* number of lost disks that are listed in full */
/* Disks that are beyond the bounds or removed: their number, and the first few in the order of
 * slots. */
typedef struct summary_lost {
  int64_t n;   /* > number of disks beyond the bounds or removed */
  size_t told; /* number of disks listed in `first` */
  struct summary_lost_disk {
    uint32_t disk, order;
    double x, y;
  } first[SUMMARY_LOST];
} summary_lost;

/* Sums over all disks and contacts of a run, which may be on several ranks. */
typedef struct summary_sums {
  size_t contacts;   /* number of closed contacts */
  exact_sum overlap; /* sum of the overlaps of the closed contacts, length */
  double farthest;   /* largest |x| + |y| + radius of a disk */
  /* bits of the columns that hold a number that is not finite (summary_doubts.c) */
  unsigned not_finite;
  summary_lost lost;
} summary_sums;
/* Computes the sums over one state. */
summary_sums summary_sums_of(const sd_state *state);

/* Fills the summary, except for the means of every disk (summary_disks_collect). sums: sums over
 * all disks; NULL: `state` holds all disks and they are computed from it. The rest is read from
 * `state`: prescribed bodies, motions, numbers of the run. step_nanoseconds: wall time per step. */
void summary_collect(summary *s, const sd_model *model, const sd_state *state,
                     const summary_sums *sums, const sd_energy *energy, double step_nanoseconds);
void summary_free(summary *s);
/* Returns true if sweep tables have a column of this name: a column of the point, or, if of_body is
 * true, a suffix to the name of a watched disk or contact. */
bool summary_is_column(const char *name, bool of_body);
void summary_write(const summary *s, h5_file *file);
/* Reads the group /summary. Call summary_free also after a failure. */
sd_status summary_read(summary *s, const h5_file *file, sd_messages *messages);
/* Recomputes the means and error bars of watched disks from the angle bins in the file's state, so
 * that results of any version are evaluated as by this version. Does nothing if the file has no
 * such bins. */
void summary_renew(summary *s, const sd_model *model, const h5_file *file);

/* Sets the doubts: compares the summary with these limits. model, state, sums: those of the run;
 * NULL where only the summary is known. */
void summary_judge(summary *s, const sd_limits *limits, const sd_model *model,
                   const sd_state *state, const summary_sums *sums);
/* Compute members farthest and not_finite of summary_sums from one state. */
double summary_farthest(const sd_state *state);
unsigned summary_not_finite(const sd_state *state);
/* summary_doubts returns the number of doubts; summary_doubts_text their texts, joined by "; ",
 * which the caller frees; never NULL. */
size_t summary_doubts(const summary *s);
char *summary_doubts_text(const summary *s);

void summary_doubts_free(summary *s);
void summary_doubts_write(const summary *s, h5_file *file);
/* Reads the doubts. A file of an older version has none: its summary is judged by the limits of
 * that version. */
sd_status summary_doubts_read(summary *s, const h5_file *file, sd_messages *messages);

#endif

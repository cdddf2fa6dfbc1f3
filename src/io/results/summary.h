/* summary.h: summary of the results of a run so far: time averages with error bars, sliding
 * fractions, energy budget, run time. It is computed with every checkpoint and stored as /summary,
 * there and in the finished file, so that the command `info` reads a few numbers whatever the size
 * of the file. */
#ifndef SLIPDISK_IO_SUMMARY_H
#define SLIPDISK_IO_SUMMARY_H

#include "base/exact_sum.h"
#include "io/store/h5.h"
#include "measure/average.h"
#include "slipdisk/model.h"
#include "model/state.h"
#include "slipdisk/measure.h"
#include "slipdisk/simulation.h"

/* --- Means of every free disk of a packing: /summary/disks ------------------------------------ */

/* Number of disks of largest |Omega| that are stored separately, so that a report reads only
 * these. */
enum { SUMMARY_FASTEST = 10 };

/* Time averages of every free disk, the fastest disks, and totals over all disks. */
typedef struct summary_disks {
  size_t n; /* number of disks; 0: the deck does not ask for time averages of disks */
  /* [n] time averages of each disk, by body number; NULL: not read (see summary_disks_read_all) */
  sd_disk_mean *disks;
  /* true if the file stores no time averages but the state from which they follow
   * (checkpoint_complete) */
  bool later;
  size_t n_fastest;
  /* disks of largest |Omega| (mean angular velocity), in descending order; disks with Omega = 0 or
   * unknown are left out */
  sd_disk_mean fastest[SUMMARY_FASTEST];
  sd_disk_totals totals;
  /* number of times that the contacts were sampled; number of full time bins for the error bars of
   * Omega */
  int64_t looks, bins;
  double measured; /* time in which quantities were averaged */
} summary_disks;

/* Smallest number of time bins of a disk's angle from which an error bar is computed. */
enum { SUMMARY_FEWEST_BINS = 16 };

/* Checkpoints of runs with at least this number of disks, or over several ranks, do not store the
 * time averages of disks: readers compute them from the state, since computing takes longer than
 * writing the state. */
enum { SUMMARY_LATER = 16384 };

/* Sets the numbers of disks, of samples and of bins, and the averaging time; computes no time
 * averages. */
void summary_disks_announce(summary_disks *s, const sd_model *model, const sd_state *state);
/* Computes the time averages of every disk, the fastest disks and the totals. Call
 * summary_disks_free also after a failure. */
sd_status summary_disks_collect(summary_disks *s, const sd_model *model, const sd_state *state,
                                int threads, sd_messages *messages);
/* summary_disks_means and summary_disks_fill do the work of summary_disks_collect in two steps.
 * summary_disks_means computes the time averages of the disks in slots [0, n) of a state, which may
 * hold only some of the disks. summary_disks_fill gets the time averages of all disks, in the order
 * of slots, sorts them by body number and adds the fastest disks and the totals; it needs id,
 * radius and contacts of all bodies in the state. */
void summary_disks_means(sd_disk_mean *means, size_t n, const sd_model *model,
                         const sd_state *state, int threads);
sd_status summary_disks_fill(summary_disks *s, const sd_model *model, const sd_state *state,
                             const sd_disk_mean *means, sd_messages *messages);
void summary_disks_free(summary_disks *s);
/* Writes the group /summary/disks: nothing if n = 0, only the counts if s->disks is NULL. */
void summary_disks_write(const summary_disks *s, h5_file *file);
/* Reads everything in /summary/disks except the time averages of each disk. */
sd_status summary_disks_read(summary_disks *s, const h5_file *file, sd_messages *messages);
/* Reads the time averages of each disk, unless they have to be computed from the state
 * (s->later). */
sd_status summary_disks_read_all(summary_disks *s, const h5_file *file, sd_messages *messages);

/* --- Doubts about a result -------------------------------------------------------------------- */

/* Doubts are warnings about the result of a finished run: a number exceeds a limit of the deck
 * (sd_limits) or is not finite. They are determined once, when the summary is computed, and stored
 * with it, so that the commands run, info and sweep report the same. */

typedef enum doubt_kind {
  DOUBT_RESIDUAL, /* the energy budget does not close */
  DOUBT_OPEN, /* watched contacts were open (not touching) for nearly all of the measured time */
  DOUBT_DISPLACEMENT, /* a disk or a prescribed body moved too far in one step */
  DOUBT_FINITE,       /* a number of the result is not finite */
  DOUBT_UNSTABLE,     /* the time step dt exceeds the limit of stability */
  DOUBT_BONDS,        /* all bonds broke in one step */
  DOUBT_KINDS
} doubt_kind;
/* Texts for each kind of warning: name; meaning of value and limit; end of a sentence about runs of
 * a sweep, such as "3 points whose energy budget does not close". */
extern const struct doubt_row { const char *name, *meaning, *whose; } doubt_kinds[DOUBT_KINDS];

typedef struct summary_doubt {
  char *text; /* text of the warning, one line; NULL: there is no warning of this kind */
  double value, limit;
} summary_doubt;

/* --- The summary ------------------------------------------------------------------------------ */

/* Outcome of one phase of the run. The values are those at its end; 0 if the phase has no such goal
 * or is not over. */
typedef struct summary_phase {
  /* steps: number of steps made, 0 if the phase is not over; most: largest number of steps that it
   * may take */
  int64_t steps, most;
  int32_t asked;   /* goals of the phase: SUMMARY_SETTLE, SUMMARY_COMPRESS, or both (bits) */
  int32_t reached; /* 1: the phase ended because its goals were met */
  /* kinetic energy per disk; ratio of the mean unbalanced force on a disk to the mean contact
   * force; each with its goal (0: no goal) */
  double kinetic, kinetic_goal, unbalanced, unbalanced_goal;
  /* pressure or packing fraction at the end, and its goal; 0: no goal */
  double target, target_goal;
} summary_phase;
enum { SUMMARY_SETTLE = 1, SUMMARY_COMPRESS = 2 };

/* Results of a run so far. */
typedef struct summary {
  /* number of steps made in all phases; largest possible number of steps (phases may end early) */
  int64_t step, steps;
  double dt;
  /* index of the running phase, equal to `phases` at the end of the run; number of phases */
  int64_t phase, phases;
  char *phase_name; /* name of the running phase; "": it has none, or the run is finished */
  int64_t measured; /* number of steps in which quantities were averaged */
  int64_t disks, walls, contacts; /* numbers of disks, walls, closed contacts */
  /* waiting: number of disks not yet inserted; outside: number of disks that are beyond the bounds
   * or were removed; left: number of times that a disk left the bounds */
  int64_t waiting, outside, left;
  /* text that lists the first disks beyond the bounds, such as "disk 3 at (1, -5), ..."; "":
   * none */
  char *lost;
  double step_nanoseconds; /* wall time per step, ns; NAN before the first step */
  sd_energy energy;
  /* lengths of the arrays below */
  size_t n_rotations, n_slides, n_configurations, n_averages, n_stages;
  summary_phase *stages; /* [n_stages] outcome of each phase */
  char **stage_names;    /* [n_stages] names of the phases */
  /* results of the [n_rotations] disks and of the [n_slides] pairs of contacts that the deck
   * watches */
  sd_rotation *rotations;
  sd_slide *slides;
  /* [n_configurations] results for each sliding configuration, SD_CONFIGURATIONS per entry of
   * `slides`; none unless the deck asks for them */
  sd_configuration *configurations;
  char **rotation_names; /* [n_rotations] names of the watched disks */
  /* [3 n_slides] for each entry of `slides`, names of the disk, its first partner and its second
   * partner */
  char **slide_names;
  sd_average *averages; /* [n_averages] averages of the series */
  char **average_names; /* [3 n_averages] for each of them its name, its expression and its unit */
  char **configuration_names; /* [n_configurations] names of configurations, such as "upper.pp" */
  /* time averages of every free disk; n = 0: the deck does not ask for them */
  summary_disks packing;
  /* true if the deck has the group `until` (the run ends when an error bar is small enough); the
   * members below are valid only then */
  bool has_until;
  char *observable; /* name of the observable whose error bar is the goal, such as "upper.omega" */
  /* goal for the error bar as a fraction of the mean; NAN: the deck gives the error bar itself
   * (goal.goal) */
  double relative;
  sd_goal goal;
  int64_t until_step; /* step at which the run ended because its goal was met; -1: not met so far */
  /* warnings, indexed by doubt_kind; member text NULL: no warning of this kind */
  summary_doubt doubts[DOUBT_KINDS];
} summary;

/* Names of the sliding configurations of two contacts, as parts of column names: "pp", "pm", "mp",
 * "mm", "stick", "open". */
extern const char *const summary_configurations[];

/* descriptions of members of struct summary: step, time, numbers of bodies and others */
extern const observable_list fact_observables;
/* descriptions of members of struct summary: relative residual and wall time per step */
extern const observable_list outcome_observables;
/* members of struct summary that belong to the goal `until` */
extern const observable_list until_observables;
/* descriptions of the members of struct summary_phase */
extern const observable_list phase_observables;

/* Allocates the summary of a model and sets its sizes and names; values are 0. */
void summary_new(summary *s, const sd_model *model);
enum { SUMMARY_LOST = 8 }; /* largest number of disks beyond the bounds that are listed by name */
/* Disks that are beyond the bounds or were removed: their number, and the first few of them in the
 * order of slots. */
typedef struct summary_lost {
  int64_t n;   /* number of disks beyond the bounds or removed */
  size_t told; /* number of disks listed in `first` */
  struct summary_lost_disk {
    uint32_t disk, order;
    double x, y;
  } first[SUMMARY_LOST];
} summary_lost;

/* Sums over all disks and contacts of a run, also when they are distributed over several ranks. */
typedef struct summary_sums {
  size_t contacts;   /* number of closed contacts */
  int64_t bonds;     /* of these, bonds */
  exact_sum overlap; /* sum of the overlaps of the closed contacts, length */
  double farthest;   /* largest |x| + |y| + radius over all disks */
  /* one bit per column (velocities, forces) that has a number that is not finite; see
   * summary_doubts.c */
  unsigned not_finite;
  summary_lost lost;
} summary_sums;
/* Computes the sums over the disks and contacts of one state. */
summary_sums summary_sums_of(const sd_state *state);

/* Fills the summary, except for the time averages of every disk (summary_disks_collect). sums: sums
 * over all disks; NULL: `state` holds all disks and the sums are computed from it. Everything else
 * is read from `state`: prescribed bodies, motions, numbers of the run. step_nanoseconds: wall time
 * per step. */
void summary_collect(summary *s, const sd_model *model, const sd_state *state,
                     const summary_sums *sums, const sd_energy *energy, double step_nanoseconds);
void summary_free(summary *s);
/* Returns true if the table of a parameter sweep has a column of this name: a column with one
 * number per run, or, if of_body is true, a column whose name ends with `name` after the name of a
 * watched disk or contact. */
bool summary_is_column(const char *name, bool of_body);
void summary_write(const summary *s, h5_file *file);
/* Reads the group /summary. Call summary_free also after a failure. */
sd_status summary_read(summary *s, const h5_file *file, sd_messages *messages);
/* Recomputes means and error bars of watched disks, and averages of the series, from the bins in
 * the file's state, so that results of any version are evaluated as by this version. Does nothing
 * if the file has no such bins. */
void summary_renew(summary *s, const sd_model *model, const h5_file *file);

typedef struct sd_limits sd_limits; /* defined in model/model.h */

/* Sets the warnings (doubts) of the summary by comparing it with these limits. model, state, sums:
 * those of the run; NULL where only the summary is known. */
void summary_judge(summary *s, const sd_limits *limits, const sd_model *model,
                   const sd_state *state, const summary_sums *sums);
/* summary_farthest and summary_not_finite compute the members farthest and not_finite of struct
 * summary_sums from one state. */
double summary_farthest(const sd_state *state);
unsigned summary_not_finite(const sd_state *state);
/* summary_doubts returns the number of warnings (doubts). summary_doubts_text returns their texts,
 * joined by "; "; the caller frees the text, which is never NULL. */
size_t summary_doubts(const summary *s);
char *summary_doubts_text(const summary *s);

void summary_doubts_free(summary *s);
void summary_doubts_write(const summary *s, h5_file *file);
/* Reads the warnings (doubts) of a summary. A file of an older version has none: its summary is
 * then compared with the limits of that version. */
sd_status summary_doubts_read(summary *s, const h5_file *file, sd_messages *messages);

#endif

/* measure.h: means with error bars, from the statistics that a state carries.
 *
 * Error bars account for autocorrelation (spectral density at frequency zero of an autoregressive model: Heidelberger &
 * Welch, Commun. ACM 24, 233 (1981); measure/error_bar.c); the transient is found by a test, not a constant
 * (MSER: White, Simulation 69, 323 (1997)).
 */
#ifndef SLIPDISK_MEASURE_H
#define SLIPDISK_MEASURE_H

#include "slipdisk/model.h"
#include "slipdisk/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Mean of a correlated, evenly spaced record. */
typedef struct sd_mean {
  double mean;
  double error;       /* one standard error; NAN when the record is too short to tell */
  double correlation; /* integrated correlation time, in samples (0.5 for independent ones) */
  size_t used;        /* samples used */
  size_t discarded;   /* samples discarded at the start as transient */
  bool converged;     /* the record is long enough, and no drift is left: docs/physics.md 9 */
} sd_mean;

/* n samples x[0..n). transient: look for one and discard it. */
SD_API sd_mean sd_mean_of(const double *x, size_t n, bool transient);

typedef struct sd_rotation {
  uint32_t disk;
  double omega, error;         /* mean angular velocity over what was kept, rad/time */
  double scaled, scaled_error; /* times t_g = sqrt(2 R/g); NAN without gravity */
  double transient, measured;  /* discarded and total measured time */
  double turned;               /* angle turned over the whole measured time, rad */
  bool converged;
} sd_rotation;

/* k-th watched disk. Before the first full bin, omega and error are NAN; without a k-th one all is, and disk UINT32_MAX. */
SD_API sd_rotation sd_rotation_of(const sd_model *model, const sd_state *state, size_t k);

/* How far a record is from the error bar that the deck's `until` asks for. */
typedef struct sd_goal {
  double value,
      error;       /* of the observable: rad/time, or rad when it is scaled; NAN: not known yet */
  double goal;     /* the error bar asked for; a relative one follows |value| */
  double measured; /* time */
  bool converged;  /* of sd_rotation */
  bool reached;    /* error <= goal and converged: the last phase ends when it is looked at now */
} sd_goal;

/* The goal of model->until (which must be asked) in a state: a function of these two alone, so that a run ends
 * at the same step however often it was stopped and whatever the number of threads. */
SD_API sd_goal sd_goal_of(const sd_model *model, const sd_state *state);
/* The next step of the last phase, after `step` of its steps, at which it is looked at: the first look is at
 * until.least, each further one about 5 % later (physics.md 9), the last at the phase's end. */
SD_API int64_t sd_goal_look(const sd_model *model, int64_t step);

typedef struct sd_slide {
  uint32_t disk, partner[2];
  double pp, pm, mp, mm; /* S++, S+-, S-+, S--: fractions of the measured steps */
  double stick, open;    /* at least one stuck and none open; at least one open */
  double contact_positive[2], contact_negative[2], contact_stuck[2], contact_open[2];
  double force_min[2];
  int64_t openings[2];
} sd_slide;

/* k-th watch; without one fractions are NAN, disk and partners UINT32_MAX. */
SD_API sd_slide sd_slide_of(const sd_model *model, const sd_state *state, size_t k);

/* Two watched contacts in one of their sliding configurations; NAN: it was never met. */
typedef struct sd_configuration {
  uint32_t disk;
  int32_t configuration; /* S++ 0, S+- 1, S-+ 2, S-- 3, stick 4, open 5 */
  int64_t steps;         /* measured steps in it */
  double torque,
      torque_sd; /* of the two contacts on the disk: mean and standard deviation over these steps */
  double force[2], force_sd[2]; /* normal forces, likewise */
  int64_t visits; /* unbroken runs of such steps that began and ended within a measured phase */
  double dwell, dwell_sd; /* their duration: mean and standard deviation over visits */
  double age_torque
      [SD_AGES]; /* mean torque by age of the visit in steps: below 32, below 64, ..., the rest */
  int64_t age_steps
      [SD_AGES]; /* steps of such ages; without visits that were under way when measuring began */
} sd_configuration;

/* Configuration k % SD_CONFIGURATIONS of watch k / SD_CONFIGURATIONS of a model that measures them ("measure.configurations");
 * without one numbers are NAN, disk UINT32_MAX. */
SD_API sd_configuration sd_configuration_of(const sd_model *model, const sd_state *state, size_t k);

/* --- every free disk of a packing (measure_disks of the model) ------------------------------------ */

/* Means of one free disk over the measured time (physics.md 9). NAN: not known yet, and everything but the id
 * of a disk that was not in play during all of it (it waited, or was taken out). */
typedef struct sd_disk_mean {
  uint32_t disk;       /* body number */
  double omega, error; /* mean angular velocity and one standard error, rad/time */
  double significance; /* omega/error; 0 for a disk that never turned */
  double first,
      second;          /* mean angular velocity of the first and of the second half of the record */
  double turned;       /* angle turned, rad */
  double x, y;         /* mean position; absolute, images of a periodic box included */
  double rms;          /* root mean square distance from there */
  double displacement; /* distance between where it is now and where it was when measuring began */
  double coordination; /* closed contacts */
  double sliding;      /* fraction of them that slide */
  double force;        /* normal force per closed contact */
  double openings;     /* contacts that opened, per time */
  double injected;     /* power of prescribed bodies on it */
  double viscous, friction,
      opening;                  /* power lost; of what two free disks lose between them, half */
  double translation, rotation; /* kinetic energies */
  bool converged;               /* the error is reliable */
} sd_disk_mean;

/* The free disk in `slot`; the state must have means (n_means > 0). */
SD_API sd_disk_mean sd_disk_mean_of(const sd_model *model, const sd_state *state, size_t slot);

/* Over the disks whose omega is known. Errors are one standard error over disks; NAN: too few disks. */
typedef struct sd_disk_totals {
  double disks;                            /* how many */
  double omega_mean, omega_mean_error;     /* of Omega, rad/time */
  double omega_rms, omega_rms_error;       /* root mean square of Omega */
  double omega_median, omega_median_error; /* of |Omega| */
  double omega_noise;                      /* root mean square of the disks' own errors */
  double significant;                      /* fraction with |Omega| > 3 errors */
  double reliable;                         /* fraction whose error is reliable */
  double persistence,
      persistence_rank; /* correlation of first and second half: Pearson's, Spearman's */
  double skewness;      /* of the distribution of Omega */
  double neighbours;    /* mean Omega_i Omega_j over pairs in contact now over mean Omega^2 */
  double coordination, sliding,
      force;       /* contacts per disk; of all: fraction that slides, normal force */
  double openings; /* per contact and time */
  double position_rms,
      displacement_rms; /* root mean square of rms, displacement, over the mean diameter */
  double power_injected, power_viscous, power_friction, power_opening; /* sums over disks */
  double mean_translation, mean_rotation; /* kinetic energies per disk */
} sd_disk_totals;

/* means: sd_disk_mean_of all n_means slots; contacts of the state are those of now. Without memory all is NAN. */
SD_API sd_disk_totals sd_disk_totals_of(const sd_model *model, const sd_state *state,
                                        const sd_disk_mean *means);

#ifdef __cplusplus
}
#endif

#endif

/* measure.h: means with error bars, computed from the statistics that a state has gathered.
 *
 * Error bars account for autocorrelation (spectral density at frequency zero of an autoregressive
 * model: Heidelberger & Welch, Commun. ACM 24, 233 (1981); measure/error_bar.c). The length of the
 * transient is found by a statistical test (MSER: White, Simulation 69, 323 (1997)), not fixed in
 * advance. docs/physics.md 9 has the details.
 */
#ifndef SLIPDISK_MEASURE_H
#define SLIPDISK_MEASURE_H

#include "slipdisk/model.h"
#include "slipdisk/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Mean of a correlated record of evenly spaced samples, with its error bar. */
typedef struct sd_mean {
  double mean;        /* mean of the samples that were kept; NAN: there are none */
  double error;       /* one standard error of the mean; NAN: the record is too short to tell */
  double correlation; /* integrated correlation time in samples; 0.5: independent samples */
  size_t used;        /* number of samples that were kept */
  size_t discarded;   /* number of samples discarded at the start as transient */
  bool converged;     /* the record is long enough and has no drift left (docs/physics.md 9) */
} sd_mean;

/* Returns the mean of the n samples x[0..n) and its error bar. transient: a transient at the start
 * is sought and left out. */
SD_API sd_mean sd_mean_of(const double *x, size_t n, bool transient);

/* Mean angular velocity of a watched disk over the measured time without its transient. */
typedef struct sd_rotation {
  uint32_t disk;               /* body number */
  double omega, error;         /* mean angular velocity and one standard error of it, rad/time */
  double scaled, scaled_error; /* omega, error times t_g = sqrt(2 R/g); NAN without gravity */
  double transient, measured;  /* measured time discarded as transient; all of the measured time */
  double turned;               /* angle turned in all of the measured time, rad */
  bool converged;              /* the error bar can be trusted (docs/physics.md 9) */
} sd_rotation;

/* Returns the mean rotation of the k-th watched disk. Before the first bin is full, omega and error
 * are NAN. If k is out of range all numbers are NAN and disk is UINT32_MAX. */
SD_API sd_rotation sd_rotation_of(const sd_model *model, const sd_state *state, size_t k);

/* Error bar reached so far, beside the one at which the key `until` of the deck ends the run. */
typedef struct sd_goal {
  double value, error; /* observable, its standard error, rad/time; rad if scaled; NAN: unknown */
  double goal;         /* error bar asked for; if it is relative, that fraction of |value| */
  double measured;     /* measured time so far */
  bool converged;      /* the error bar can be trusted: converged of sd_rotation */
  bool reached;        /* error <= goal and converged: the last phase ends if it is checked now */
} sd_goal;

/* Returns the progress towards the goal of model->until, which must be set. It depends on model and
 * state alone, so that a run ends at the same step however often it was interrupted and with any
 * number of threads. */
SD_API sd_goal sd_goal_of(const sd_model *model, const sd_state *state);
/* Returns the next step after `step` at which the goal is checked, both counted from the start of
 * the last phase. The first check is at until.least, each further one about 5 % later (physics.md
 * 9), the last at the end of the phase. */
SD_API int64_t sd_goal_look(const sd_model *model, int64_t step);

/* Fractions of the measured steps that two watched contacts of a disk spent sliding, stuck and
 * open. Index 0, 1: contact with partner[0], partner[1]. A sign is that of the torque of the
 * sliding contact on the disk. */
typedef struct sd_slide {
  uint32_t disk, partner[2]; /* body numbers of the disk and of its two partners */
  double pp, pm, mp, mm; /* fraction of steps in S++, S+-, S-+, S--: signs of contacts 0 and 1 */
  double stick, open;    /* fraction of steps: one contact stuck, none open; at least one open */
  /* Fractions of steps in which each contact slides with torque > 0, slides with torque < 0, is
   * stuck, is open. */
  double contact_positive[2], contact_negative[2], contact_stuck[2], contact_open[2];
  double force_min[2]; /* smallest normal force of the contact in measured steps, force */
  int64_t openings[2]; /* number of times that the contact opened in measured steps */
} sd_slide;

/* Returns the statistics of the k-th watch of sliding. If k is out of range numbers are NAN, disk
 * and partners UINT32_MAX. */
SD_API sd_slide sd_slide_of(const sd_model *model, const sd_state *state, size_t k);

/* Statistics of two watched contacts of a disk while they are in one of their sliding
 * configurations. A mean is NAN if the configuration never occurred. */
typedef struct sd_configuration {
  uint32_t disk;                /* body number of the disk; UINT32_MAX: no such watch */
  int32_t configuration;        /* S++ 0, S+- 1, S-+ 2, S-- 3, stick 4, open 5 */
  int64_t steps;                /* number of measured steps in this configuration */
  double torque, torque_sd;     /* torque of both contacts on the disk: mean, standard deviation */
  double force[2], force_sd[2]; /* mean normal force of each contact, and its standard deviation */
  int64_t visits; /* unbroken runs of such steps that began and ended within a measured phase */
  double dwell, dwell_sd; /* mean duration of these visits, and its standard deviation, time */
  /* Mean torque by age of the visit in steps: below 32, below 64, ..., the rest */
  double age_torque[SD_AGES];
  /* Measured steps by age of the visit. Visits that had begun before measuring did are not
   * counted. */
  int64_t age_steps[SD_AGES];
} sd_configuration;

/* Returns the statistics of configuration k % SD_CONFIGURATIONS of watch k / SD_CONFIGURATIONS, if
 * the model measures them ("measure.configurations"). If there is no such watch numbers are NAN and
 * disk is UINT32_MAX. */
SD_API sd_configuration sd_configuration_of(const sd_model *model, const sd_state *state, size_t k);

/* --- means of every free disk (key "measure.disks") ------------------------------------------- */

/* Means of one free disk over the measured time (physics.md 9). A member is NAN while it is not
 * known yet. If the disk was not in play all the time, since it waited or was removed, everything
 * but its number is NAN. Each of two free disks takes half of the power lost in their contact. */
typedef struct sd_disk_mean {
  uint32_t disk;        /* body number */
  double omega, error;  /* mean angular velocity and one standard error of it, rad/time */
  double significance;  /* omega/error; 0 for a disk that never turned */
  double first, second; /* mean angular velocity in each half of the record, rad/time */
  double turned;        /* angle turned, rad */
  double x, y;          /* mean position, length; absolute: not wrapped into a periodic box */
  double rms;           /* root mean square distance from the mean position, length */
  double displacement; /* distance of the present position from that when measuring began, length */
  double coordination; /* mean number of closed contacts */
  double sliding;      /* fraction of the closed contacts that slide */
  double force;        /* mean normal force per closed contact */
  double openings;     /* number of contacts that opened, per time */
  double injected;     /* mean power of prescribed bodies on the disk */
  double viscous, friction, opening; /* power lost to viscosity, to sliding, as contacts open */
  double translation, rotation;      /* mean kinetic energy of translation, and of rotation */
  bool converged;                    /* the error bar of omega can be trusted */
} sd_disk_mean;

/* Returns the means of the free disk in a slot of the state, which must have means of disks
 * (n_means > 0). */
SD_API sd_disk_mean sd_disk_mean_of(const sd_model *model, const sd_state *state, size_t slot);

/* Statistics over all disks whose mean angular velocity Omega (omega of sd_disk_mean) is known.
 * Each error is one standard error from the scatter of the disks; NAN: too few disks. Persistence
 * is the correlation of `first` and `second`, position_rms the root mean square over the disks of
 * `rms`, displacement_rms that of `displacement`, power_viscous the sum of `viscous`, and so on. */
typedef struct sd_disk_totals {
  double disks;                            /* number of disks whose Omega is known */
  double omega_mean, omega_mean_error;     /* mean of Omega and its error, rad/time */
  double omega_rms, omega_rms_error;       /* root mean square of Omega and its error, rad/time */
  double omega_median, omega_median_error; /* median of |Omega| and its error, rad/time */
  double omega_noise; /* root mean square of the error bars of the disks, rad/time */
  double significant; /* fraction of disks with |Omega| > 3 error bars */
  double reliable;    /* fraction of disks whose error bar can be trusted */
  double persistence, persistence_rank; /* correlation of `first` and `second`: Pearson, Spearman */
  double skewness;                      /* skewness of the distribution of Omega */
  /* Mean of Omega_i Omega_j over pairs in contact now, over the mean of Omega^2 */
  double neighbours;
  double coordination, sliding, force; /* contacts per disk; of these: fraction sliding, mean F_n */
  double openings;                     /* number of openings per closed contact and time */
  double position_rms, displacement_rms; /* root mean square distances over the mean diameter */
  double power_injected, power_viscous, power_friction, power_opening; /* sums over disks */
  double mean_translation, mean_rotation; /* mean kinetic energy per disk: translation, rotation */
} sd_disk_totals;

/* Returns the statistics over all disks. means: sd_disk_mean_of for each of the n_means slots, by
 * slot. `neighbours` is taken over the closed contacts that the state has now. If there is no
 * memory all members are NAN. */
SD_API sd_disk_totals sd_disk_totals_of(const sd_model *model, const sd_state *state,
                                        const sd_disk_mean *means);

#ifdef __cplusplus
}
#endif

#endif

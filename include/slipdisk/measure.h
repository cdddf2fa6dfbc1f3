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
  double correlation; /* integrated correlation time, number of samples; 0.5: independent samples */
  size_t used;        /* number of samples that were kept */
  size_t discarded;   /* number of samples discarded at the start as transient */
  /* true: the record is long enough and has no drift left (docs/physics.md 9) */
  bool converged;
} sd_mean;

/* Returns the mean of the n samples x[0..n) and its error bar. transient: true to search for a
 * transient at the start and leave it out. */
SD_API sd_mean sd_mean_of(const double *x, size_t n, bool transient);
/* Returns the mean of over[0..n) divided by that of under[0..n), with the error bar of the ratio r:
 * that of the record r + (over - r under)/(mean of under). transient: as above. NAN: there are no
 * samples, or no memory. */
SD_API sd_mean sd_ratio_of(const double *over, const double *under, size_t n, bool transient);

/* Mean angular velocity of one disk; the transient at the beginning of the measured time is left
 * out. */
typedef struct sd_rotation {
  uint32_t disk;       /* body number of the disk */
  double omega, error; /* mean angular velocity and one standard error of it, rad/time */
  /* omega and error multiplied by t_g = sqrt(2 R/g); NAN without gravity */
  double scaled, scaled_error;
  double transient, measured; /* measured time discarded as transient; total measured time */
  double turned;              /* angle turned in the total measured time, rad */
  bool converged;             /* true: the error bar can be trusted (docs/physics.md 9) */
} sd_rotation;

/* Returns the mean rotation of the k-th disk whose rotation is measured. Before the first bin of
 * its angle record is full, omega and error are NAN. If k is out of range all numbers are NAN
 * and disk is UINT32_MAX. */
SD_API sd_rotation sd_rotation_of(const sd_model *model, const sd_state *state, size_t k);

/* Progress of a run towards the error bar at which the key `until` of its deck ends it. */
typedef struct sd_goal {
  /* measured mean and its standard error, rad/time (rad if scaled); NAN: unknown */
  double value, error;
  /* error bar to be reached, in the same unit; if given as relative, that fraction of |value| */
  double goal;
  double measured; /* time in which statistics were gathered so far */
  bool converged;  /* true: the error bar can be trusted (converged of sd_rotation) */
  /* true if error <= goal and converged: the last phase ends if the goal is checked now */
  bool reached;
} sd_goal;

/* Returns the progress towards the error bar model->until, which must be set. The result depends
 * on model and state alone, so that a run ends at the same step however often it was interrupted
 * and with any number of threads. */
SD_API sd_goal sd_goal_of(const sd_model *model, const sd_state *state);
/* Returns the next step after `step` at which the error bar is checked, both steps counted from
 * the start of the last phase. The first check is at until.least, each further one about 5 %
 * later (physics.md 9), the last at the end of the phase. */
SD_API int64_t sd_goal_look(const sd_model *model, int64_t step);

/* Fractions of the measured steps that two watched contacts of a disk spent sliding, stuck and
 * open. Contact 0 is that with partner[0], contact 1 that with partner[1]. The sign of a sliding
 * contact is that of its torque on the disk. */
typedef struct sd_slide {
  uint32_t disk, partner[2]; /* body numbers of the disk and of its two partners */
  double pp, pm, mp, mm; /* fractions of steps in S++, S+-, S-+, S--: signs of contact 0 and 1 */
  /* fraction of steps with one contact stuck and none open; with at least one open */
  double stick, open;
  /* Fractions of steps in which contact [0] or [1] slides with torque > 0, slides with torque <
   * 0, is stuck, is open. */
  double contact_positive[2], contact_negative[2], contact_stuck[2], contact_open[2];
  double force_min[2]; /* smallest normal force of contact [0] and [1] in measured steps */
  int64_t openings[2]; /* number of times that contact [0] and [1] opened in measured steps */
} sd_slide;

/* Returns the statistics of the k-th watched pair of contacts. If k is out of range numbers are
 * NAN, disk and partners UINT32_MAX. */
SD_API sd_slide sd_slide_of(const sd_model *model, const sd_state *state, size_t k);

/* Statistics of two watched contacts of a disk over the steps that they spend in one of their
 * sliding configurations. A mean is NAN if the configuration never occurred. */
typedef struct sd_configuration {
  /* body number of the disk; UINT32_MAX: there is no such pair of contacts */
  uint32_t disk;
  int32_t configuration; /* configuration: 0 is S++, 1 S+-, 2 S-+, 3 S--, 4 stick, 5 open */
  int64_t steps;         /* number of measured steps in this configuration */
  /* torque of both contacts together on the disk: mean, standard deviation */
  double torque, torque_sd;
  double force[2], force_sd[2]; /* normal force of contact [0] and [1]: mean, standard deviation */
  /* Number of visits: unbroken runs of such steps that began and ended within a measured phase */
  int64_t visits;
  double dwell, dwell_sd; /* duration of these visits, time: mean, standard deviation */
  /* Mean torque in classes of the age of the visit in steps: below 32, below 64, ..., the rest */
  double age_torque[SD_AGES];
  /* Number of measured steps in the same classes of the age of the visit. Visits that had begun
   * before measuring did are not counted. */
  int64_t age_steps[SD_AGES];
} sd_configuration;

/* Returns the statistics of configuration k % SD_CONFIGURATIONS of the watched pair of contacts
 * k / SD_CONFIGURATIONS, if the model measures them ("measure.configurations"). If there is no
 * such pair numbers are NAN and disk is UINT32_MAX. */
SD_API sd_configuration sd_configuration_of(const sd_model *model, const sd_state *state, size_t k);

/* --- means of every free disk (key "measure.disks") ------------------------------------------- */

/* Means of one free disk over the measured time (physics.md 9). A member is NAN while it is not
 * known yet. If the disk took part in only a part of that time, since it waited for its release
 * or was removed, everything but its number is NAN. Each of two free disks takes half of the
 * power lost in their contact. */
typedef struct sd_disk_mean {
  uint32_t disk;       /* body number of the disk */
  double omega, error; /* mean angular velocity and one standard error of it, rad/time */
  /* mean angular velocity divided by its standard error; 0 for a disk that never turned */
  double significance;
  /* mean angular velocity in the first and second half of the record, rad/time */
  double first, second;
  double turned; /* angle turned in the measured time, rad */
  double x, y;   /* mean position, length; absolute: not wrapped into a periodic box */
  double rms;    /* root mean square distance of the disk from its mean position, length */
  /* distance of the present position from the position when measuring began, length */
  double displacement;
  double coordination; /* mean number of closed contacts of the disk */
  double sliding;      /* fraction of the closed contacts of the disk that slide */
  double force;        /* mean normal force per closed contact of the disk */
  double openings;     /* number of times per unit of time that a contact of the disk opened */
  double injected;     /* mean power that prescribed bodies transfer to the disk */
  /* mean power lost to viscosity, to sliding, and as contacts open */
  double viscous, friction, opening;
  double translation, rotation; /* mean kinetic energy of translation, and of rotation */
  bool converged;               /* true: the error bar of omega can be trusted */
} sd_disk_mean;

/* Returns the means of the free disk in this slot (row) of the state, which must have means of
 * disks (n_means > 0). */
SD_API sd_disk_mean sd_disk_mean_of(const sd_model *model, const sd_state *state, size_t slot);

/* Statistics over all disks whose mean angular velocity Omega (omega of sd_disk_mean) is known.
 * Each error is one standard error from the scatter of the disks; NAN: too few disks. Other
 * names refer to sd_disk_mean: persistence is the correlation of its members `first` and
 * `second`, position_rms the root mean square over the disks of its `rms`, displacement_rms that
 * of `displacement`, power_viscous the sum of `viscous`, and so on. */
typedef struct sd_disk_totals {
  double disks;                            /* number of disks whose Omega is known */
  double omega_mean, omega_mean_error;     /* mean of Omega and its error, rad/time */
  double omega_rms, omega_rms_error;       /* root mean square of Omega and its error, rad/time */
  double omega_median, omega_median_error; /* median of |Omega| and its error, rad/time */
  double omega_noise; /* root mean square of the error bars of the disks, rad/time */
  double significant; /* fraction of disks with |Omega| > 3 standard errors */
  double reliable;    /* fraction of disks whose error bar can be trusted */
  /* correlation of the members `first` and `second` of sd_disk_mean: Pearson, Spearman */
  double persistence, persistence_rank;
  double skewness; /* skewness of the distribution of Omega */
  /* Mean of Omega_i Omega_j over pairs in contact now, divided by the mean of Omega^2 */
  double neighbours;
  /* mean number of contacts per disk; fraction of them that slide; their mean normal force */
  double coordination, sliding, force;
  double openings; /* number of openings per closed contact and time */
  /* rms distance from the mean position, rms displacement since measuring began; both divided by
   * the mean diameter */
  double position_rms, displacement_rms;
  /* power from prescribed bodies, power lost to viscosity, to sliding, as contacts open; summed
   * over disks */
  double power_injected, power_viscous, power_friction, power_opening;
  /* mean kinetic energy per disk of translation, and of rotation */
  double mean_translation, mean_rotation;
} sd_disk_totals;

/* Returns the statistics over all disks. means: result of sd_disk_mean_of for each slot from 0
 * to n_means - 1. `neighbours` is computed from the closed contacts that the state has now. If
 * there is no memory all members are NAN. */
SD_API sd_disk_totals sd_disk_totals_of(const sd_model *model, const sd_state *state,
                                        const sd_disk_mean *means);

#ifdef __cplusplus
}
#endif

#endif

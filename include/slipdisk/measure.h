/* measure.h: means with error bars, from the statistics that a state carries.
 *
 * Error bars account for autocorrelation (blocking: Flyvbjerg & Petersen, J. Chem. Phys. 91, 461 (1989),
 * with the stopping rule named in measure/blocking.c); the transient is found by a test, not a constant
 * (MSER: White, Simulation 69, 323 (1997)).
 */
#ifndef SLIPDISK_MEASURE_H
#define SLIPDISK_MEASURE_H

#include "slipdisk/model.h"
#include "slipdisk/state.h"

/* Mean of a correlated, evenly spaced record. */
typedef struct sd_mean {
  double mean;
  double error;       /* one standard error; NAN when the record is too short to tell */
  double correlation; /* integrated correlation time, in samples (0.5 for independent ones) */
  size_t used;        /* samples used */
  size_t discarded;   /* samples discarded at the start as transient */
  bool converged;     /* the blocking curve has a plateau, and no drift is left: docs/physics.md 9 */
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

/* k-th watched disk. Before the first full bin, omega and error are NAN. */
SD_API sd_rotation sd_rotation_of(const sd_model *model, const sd_state *state, size_t k);

/* How far a record is from the error bar that the deck's `until` asks for. */
typedef struct sd_goal {
  double value, error; /* of the observable: rad/time, or rad when it is scaled; NAN: not known yet */
  double goal;         /* the error bar asked for; a relative one follows |value| */
  double measured;     /* time */
  bool converged;      /* of sd_rotation */
  bool reached;        /* error <= goal and converged: the last phase ends when it is looked at now */
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

SD_API sd_slide sd_slide_of(const sd_model *model, const sd_state *state, size_t k);

#endif

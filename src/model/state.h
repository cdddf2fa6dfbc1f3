/* state.h: the struct behind slipdisk/state.h: a member for each row of sd_fields. */
#ifndef MODEL_STATE_H
#define MODEL_STATE_H

#include "model/model.h"
#include "slipdisk/state.h"

struct sd_state {
  /* per run */
  int64_t step;                      /* completed since the start */
  int64_t phase;                     /* index of the running phase; n_phases when finished */
  int64_t phase_step;                /* completed in this phase */
  double work_driven;                /* by prescribed bodies and coordinates on the rest, since step 0 */
  double energy_start;               /* kinetic + elastic + external at step 0 */
  int64_t measured;                  /* steps measured so far */
  int64_t bin_steps;                 /* steps per bin of the angle record */
  int64_t bins;                      /* full bins in the angle record */
  double box_scale;                  /* lengths of the region over those of the model; 1 unless compressed */
  double field_power;                /* of force fields at the end of the last step */
  double relaxed;                    /* energy taken out by the relaxer since step 0 */
  double relax_alpha;                /* how far velocities are steered; set when a phase begins */
  int64_t relax_steps;               /* steps downhill since they were last stopped */
  int64_t released;                  /* disks that rain has let go */
  int64_t outside;                   /* times that a disk left the bounds */
  int64_t mean_samples;              /* looks at the contacts for the means */
  int64_t mean_bin_steps, mean_bins; /* like bin_steps and bins */
  int64_t fast_step;        /* first step after which a free disk was beyond limits.displacement; -1 */
  int64_t fast_disk;        /* its body number */
  double fast_displacement; /* its speed times dt, in radii */

  void *columns; /* what the columns but those of contacts stand in */

  /* extents */
  size_t n_free, n_disks, n_bodies;
  size_t n_contacts, contact_capacity;
  size_t n_motions, n_phases, n_rotations, n_slides, n_means, n_visits;

  /* per body */
  uint32_t *id; /* body number of model.h */
  double *x, *y, *theta, *turn;
  double *vx, *vy, *omega;
  int32_t *image_x, *image_y;
  double *radius, *mass, *inertia;
  int32_t *material, *group;
  double *base_x, *base_y, *base_theta; /* prescribed coordinates: pose without the running motions */
  double *force_x, *force_y, *torque;   /* from contacts at the last step */
  double *loss_viscous;  /* energy lost in this body's contacts since step 0: half of each contact's, */
  double *loss_friction; /* the whole where the other side is a wall or prescribed */
  double *loss_opening;  /* left in contacts when they opened */
  double *nonconservative_work; /* put in by the paper's tangential force, which is not that of a potential */
  double *past_viscous, *past_friction,
      *past_nonconservative_work; /* of loss_viscous, loss_friction, nonconservative_work: in contacts that
                                                       have ended */

  /* per free disk: Nordsieck column k is dt^k/k! times the k-th derivative */
  int32_t *activity; /* SD_IN_PLAY ... */
  double *x2, *y2, *theta2;
  double *x3, *y3, *theta3, *x4, *y4, *theta4, *x5, *y5, *theta5;

  /* per closed contact, ordered by (lower slot, partner) */
  uint32_t *contact_a;    /* body number of the disk */
  uint32_t *contact_b;    /* body number of the partner disk or wall */
  uint32_t *contact_part; /* straight piece of the wall (feature number), 0 for round bodies */
  double *contact_side;   /* +1, -1: side of a straight wall; 0: round */
  int32_t *contact_slide; /* 0 stuck, +1/-1 sliding with that sign of torque */
#define SD_CONTACT_POINTER(name, unit, meaning) double *contact_##name;
  SD_CONTACT_RECORD(SD_CONTACT_POINTER) /* contact.h */
#undef SD_CONTACT_POINTER

  /* per motion */
  int64_t *motion_start;                                 /* step at which it was switched on, -1: off */
  double *motion_u0, *motion_v0, *motion_u1, *motion_v1; /* random: oscillator at the last and next draw;
                                                            load: displacement, velocity; servo: these and
                                                            the smoothed force */

  /* per phase, when it ended */
  int64_t *phase_steps;                     /* that it took; 0: not over */
  int32_t *phase_reached;                   /* 1: what settle and compress asked for was there */
  double *phase_kinetic, *phase_unbalanced; /* settle: as then measured */
  double *phase_target;                     /* compress: pressure or packing fraction */

  /* statistics of the measured phases */
  double *rotation_start;  /* angle when measuring began */
  double *rotation_bin;    /* angle turned in each full bin */
  double *rotation_last;   /* angle at the last bin's end */
  double *rotation_stop;   /* angle when a measured phase ended: what is turned until the next is left out */
  int64_t *slide_count;    /* steps in configuration 4 * (first contact) + (second contact) */
  double *slide_force_min; /* smallest normal force, 0 when the contact opened */
  int64_t *slide_openings; /* times the contact opened */
  int32_t *slide_was_open; /* at the last step */

  /* visits of watched pairs to their sliding configurations: visits.h */
  int32_t *visit_class;     /* of the visit under way, -1: none */
  int64_t *visit_since;     /* measured steps when it began, -1: before */
  int64_t *visit_from;      /* measured steps when the part of it under way began */
  double *visit_reference;  /* normal forces that are subtracted in the sums */
  double *visit_part;       /* sums of the part under way: VISIT_TORQUE ... */
  double *visit_sum;        /* sums of each class, by ended parts */
  int64_t *visit_count;     /* visits that began and ended while measured, ... */
  int64_t *visit_steps;     /* ... their steps, */
  double *visit_steps2;     /* and the squares of them */
  double *visit_age_torque; /* sum of the torque by class and octave of the age, by ended parts */
  int64_t *visit_age_steps; /* steps of it */

  /* means of the free disks, by slot; sums over looks unless said otherwise */
  double *mean_angle, *mean_last, *mean_stop;       /* angles as rotation_start, _last, _stop */
  double *mean_bin;                                 /* angle turned in each full bin */
  double *mean_x0, *mean_y0;                        /* absolute position at the start; NAN: was not in play */
  double *sum_x, *sum_y, *sum_xx, *sum_yy;          /* displacement from there, and its squares */
  double *sum_contacts, *sum_sliding;               /* closed contacts, and those that slide */
  double *sum_force;                                /* normal forces */
  double *sum_injected;                             /* power of prescribed bodies on this disk */
  double *sum_kinetic, *sum_spin;                   /* kinetic energies of translation and rotation */
  double *sum_viscous, *sum_friction, *sum_opening; /* losses in measured phases; while one goes on, less
                                                          what had been lost (loss_*) when it began */
  int64_t *sum_openings;                            /* contacts that opened in measured steps */
};

/* A state with every column zero and sized for the model, no contacts. NULL: no memory. */
sd_state *sd_state_new(const sd_model *model);
/* Room for n contacts; their old contents are kept as far as they fit. */
sd_status sd_state_reserve_contacts(sd_state *state, size_t n);
/* Record of stored contact c. */
sd_contact_record sd_state_record(const sd_state *state, size_t c);
void sd_state_set_record(sd_state *state, size_t c, const sd_contact_record *record);

#endif

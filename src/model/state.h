/* state.h: the struct behind slipdisk/state.h: a member for each row of sd_fields. */
#ifndef MODEL_STATE_H
#define MODEL_STATE_H

#include "base/team.h"
#include "model/model.h"
#include "slipdisk/state.h"

/* contact_slide is larger by this, until step 0, if the contact is force_carried
 * (sd_contact_memory) */
enum { SD_FORCE_CARRIED = 4 };

struct sd_state {
  /* per run */
  int64_t step;         /* completed since the start */
  int64_t phase;        /* index of the running phase; n_phases when finished */
  int64_t phase_step;   /* completed in this phase */
  double work_driven;   /* by prescribed bodies and coordinates on the rest, since step 0 */
  double energy_start;  /* kinetic + elastic + external at step 0 */
  int64_t measured;     /* steps measured so far */
  int64_t bin_steps;    /* steps per bin of the angle record */
  int64_t bins;         /* full bins in the angle record */
  double box_scale;     /* lengths of the region over those of the model; 1 unless compressed */
  double field_power;   /* of force fields at the end of the last step */
  double relaxed;       /* energy taken out by the relaxer since step 0 */
  double relax_alpha;   /* how far velocities are steered; set when a phase begins */
  int64_t relax_steps;  /* steps downhill since they were last stopped */
  int64_t released;     /* disks that rain has let go */
  int64_t outside;      /* times that a disk left the bounds */
  int64_t mean_samples; /* looks at the contacts for the means */
  int64_t mean_bin_steps, mean_bins; /* like bin_steps and bins */
  int64_t fast_step; /* first step after which a free disk was beyond limits.displacement; -1 */
  int64_t fast_disk; /* its body number */
  double fast_displacement; /* its speed times dt, in radii */

  void *columns; /* what the columns but those of contacts stand in */

  /* extents */
  size_t n_free, n_disks, n_bodies;
  size_t n_ghosts; /* disks of other processes, in the slots from n_free on; they count as disks */
  size_t n_contacts, contact_capacity;
  size_t n_motions, n_phases, n_rotations, n_slides, n_means, n_visits, n_fielded, n_clumps;
  size_t n_cell, n_cell_disks;
  size_t n_surfaces;  /* walls, where motions move the surface of any; else 0 */
  size_t law_columns; /* 1: there are those of SD_CONTACT_MORE, 0: none */

  /* per body */
  uint32_t *id; /* body number of model.h */
  double *x, *y, *theta, *turn;
  double *vx, *vy, *omega;
  int32_t *image_x, *image_y;
  double *radius, *mass, *inertia;
  int32_t *material, *group;
  double *base_x, *base_y,
      *base_theta;                    /* prescribed coordinates: pose without the running motions */
  double *force_x, *force_y, *torque; /* from contacts at the last step */
  double
      *loss_viscous; /* energy lost in this body's contacts since step 0: half of each contact's, */
  double *loss_friction; /* the whole where the other side is a wall or prescribed */
  double *loss_opening;  /* left in contacts when they opened */
  double *
      nonconservative_work; /* put in by the paper's tangential force, which is not that of a potential */
  double *past_viscous, *past_friction,
      *past_nonconservative_work; /* of loss_viscous, loss_friction, nonconservative_work: in contacts that
                                                       have ended */

  /* per wall whose surface may move: how far its surface is along it, beyond `surface_turn`; speed, force of the
   * contacts on it, and as base_x */
  double *surface, *surface_turn, *surface_speed, *surface_force, *base_surface;

  /* per free disk: Nordsieck column k is dt^k/k! times the k-th derivative */
  int32_t *activity; /* SD_IN_PLAY ... */
  double *
      past_rolling; /* energy lost to rolling in contacts that have ended, by disk as loss_viscous; law_columns */
  double *loss_bridge; /* of capillary bridges when they formed; law_columns */
  double *x2, *y2, *theta2;
  double *x3, *y3, *theta3, *x4, *y4, *theta4, *x5, *y5, *theta5;

  /* per free disk of a model with fields (physics.md 15): forces of the last step, their powers, and what these add up to */
  double *field_x, *field_y, *field_torque;
  double *power_work, *power_drag, *power_damping;
  double *field_work, *loss_drag, *loss_damping;

  /* per closed contact, ordered by (lower slot, partner) */
  uint32_t *contact_a;    /* body number of the disk */
  uint32_t *contact_b;    /* body number of the partner disk or wall */
  uint32_t *contact_part; /* straight piece of the wall (feature number), 0 for round bodies */
  double *contact_side;   /* +1, -1: side of a straight wall; 0: round */
  int32_t *contact_slide; /* 0 stuck, +1/-1 sliding with that sign of torque; SD_FORCE_CARRIED */
#define SD_CONTACT_POINTER(name, unit, meaning) double *contact_##name;
  SD_CONTACT_RECORD(SD_CONTACT_POINTER) /* contact.h */
  SD_CONTACT_MORE(SD_CONTACT_POINTER)   /* law_columns */
#undef SD_CONTACT_POINTER

  /* per motion */
  int64_t *motion_start; /* step at which it was switched on, -1: off */
  double *motion_u0, *motion_v0, *motion_u1,
      *motion_v1; /* random: oscillator at the last and next draw;
                                                            load: displacement, velocity; servo: these and
                                                            the smoothed force */

  /* the periodic box, over its lengths before it deformed: CELL_X ... of cell.h */
  double *cell;
  double *cell_start; /* at step cell_from; from there on they change at cell_speed */
  int64_t *cell_from;
  double *cell_speed;
  double *cell_force; /* sum of f (x) n over contacts with images n cells away: xx, xy, yx, yy */
  double *cell_mean;  /* running means of the rates that follow stresses: xx, yy, xy */
  double *cell_u, *cell_v; /* where disks are in the box, over its edges, when last looked at */
  double *nonaffine_x,
      *nonaffine_y; /* displacement since the phase began, without that of the box */

  /* per phase, when it ended */
  int64_t *phase_steps;                     /* that it took; 0: not over */
  int32_t *phase_reached;                   /* 1: what settle and compress asked for was there */
  double *phase_kinetic, *phase_unbalanced; /* settle: as then measured */
  double *phase_target;                     /* compress: pressure or packing fraction */

  /* statistics of the measured phases */
  double *rotation_start; /* angle when measuring began */
  double *rotation_bin;   /* angle turned in each full bin */
  double *rotation_last;  /* angle at the last bin's end */
  double *
      rotation_stop; /* angle when a measured phase ended: what is turned until the next is left out */
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
  double *mean_angle, *mean_last, *mean_stop; /* angles as rotation_start, _last, _stop */
  double *mean_bin;                           /* angle turned in each full bin */
  double *mean_x0, *mean_y0; /* absolute position at the start; NAN: was not in play */
  double *sum_x, *sum_y, *sum_xx, *sum_yy; /* displacement from there, and its squares */
  double *sum_contacts, *sum_sliding;      /* closed contacts, and those that slide */
  double *sum_force;                       /* normal forces */
  double *sum_injected;                    /* power of prescribed bodies on this disk */
  double *sum_kinetic, *sum_spin;          /* kinetic energies of translation and rotation */
  double *sum_viscous, *sum_friction,
      *sum_opening;      /* losses in measured phases; while one goes on, less
                                                          what had been lost (loss_*) when it began */
  int64_t *sum_openings; /* contacts that opened in measured steps */

  /* per clump: its centre of mass as a free body */
  double *clump_x, *clump_y, *clump_theta, *clump_turn;
  double *clump_vx, *clump_vy, *clump_omega;
  int32_t *clump_image_x, *clump_image_y;
  double *clump_base_x, *clump_base_y, *clump_base_theta;
  double *clump_force_x, *clump_force_y,
      *clump_torque; /* of the contacts of its disks at the last step */
  double *clump_x2, *clump_y2, *clump_theta2, *clump_x3, *clump_y3, *clump_theta3;
  double *clump_x4, *clump_y4, *clump_theta4, *clump_x5, *clump_y5, *clump_theta5;
};

/* Has the column rows of free disks, and of nothing else? */
static inline bool state_of_free(sd_extent extent) {
  return extent == SD_PER_FREE || extent == SD_PER_MEAN || extent == SD_PER_MEAN_BIN ||
         extent == SD_PER_FIELDED || extent == SD_PER_LAW_FREE || extent == SD_PER_CELL_DISK;
}
/* ... of closed contacts? */
static inline bool state_of_contacts(sd_extent extent) {
  return extent == SD_PER_CONTACT || extent == SD_PER_LAW_CONTACT;
}

/* A state with every column zero and sized for the model, no contacts. NULL: no memory. */
sd_state *sd_state_new(const sd_model *model);
/* Its extents alone, of all disks of the model. */
sd_state state_sizes(const sd_model *model);
/* Bytes of its columns with so many contacts. */
double state_bytes(const sd_model *model, size_t contacts);
/* No simulation in one process takes fewer bytes: the model's disks, and columns without
 * contacts. Columns that stay 0, of derivatives or losses, need no memory, but lists and forces,
 * which are not counted, need more than these. */
double state_least_bytes(const sd_model *model);
/* So much of it is a single disk's, whatever the model. */
size_t state_disk_bytes(bool free);
/* SD_ERROR_IO, with a message: these do not fit (memory_fits). */
sd_status state_refuse(const sd_model *model, sd_messages *messages);
/* As sd_state_new for a part of the free disks, with places for ghosts; prescribed bodies are those of the model. */
sd_state *state_new_part(const sd_model *model, size_t n_free, size_t n_ghosts);
/* Columns of bodies move to pages that the threads have touched first, each its share, so that they stand near it. Without
 * memory they stay. */
void state_spread(sd_state *state, pool *c);
/* sd_state_hash is that of the columns one after the other, from this start. */
#define STATE_HASH UINT64_C(14695981039346656037)
uint64_t state_hash_bytes(uint64_t hash, const void *data, size_t bytes);
/* Room for n contacts; their old contents are kept as far as they fit. */
sd_status sd_state_reserve_contacts(sd_state *state, size_t n);
/* Record of stored contact c. */
sd_contact_record sd_state_record(const sd_state *state, size_t c);
void sd_state_set_record(sd_state *state, size_t c, const sd_contact_record *record);

#endif

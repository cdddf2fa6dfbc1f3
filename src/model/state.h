/* state.h: the struct behind slipdisk/state.h. Each row of sd_fields describes one member. */
#ifndef MODEL_STATE_H
#define MODEL_STATE_H

#include <math.h>

#include "base/team.h"
#include "model/model.h"
#include "slipdisk/state.h"

/* Offset added to contact_slide, until step 0, if the contact's stored force is valid
 * (force_carried of sd_contact_memory). */
enum { SD_FORCE_CARRIED = 4 };

struct sd_state {
  /* The following members have one value per run. */
  int64_t step;       /* steps completed since the start */
  int64_t phase;      /* index of the current phase; n_phases: the run is over */
  int64_t phase_step; /* steps completed in the current phase */
  /* Work done by prescribed bodies and coordinates, and by the program's force fields, since
   * step 0. */
  double work_driven;
  double energy_start;  /* kinetic + elastic + external energy at step 0 */
  int64_t measured;     /* number of measured steps */
  int64_t bin_steps;    /* steps per bin of the angle record, a power of two */
  int64_t bins;         /* completed bins of the angle record */
  double box_scale;     /* lengths of the region over those of the model; 1: not compressed */
  double field_power;   /* power of the program's force fields at the end of the last step */
  double relaxed;       /* energy removed by the relaxer (FIRE) since step 0 */
  double relax_alpha;   /* FIRE's mixing parameter alpha; set when a phase begins */
  int64_t relax_steps;  /* FIRE: steps with positive power since velocities were last set to 0 */
  int64_t released;     /* number of disks released by rain */
  int64_t outside;      /* number of times that a disk has left the bounds */
  int64_t mean_samples; /* samples of the contacts taken for the means of disks */
  /* bin_steps and bins of the angle records of all disks (mean_bin) */
  int64_t mean_bin_steps, mean_bins;
  /* First step after which a free disk or a moved body exceeded limits.displacement; -1: none. */
  int64_t fast_step;
  /* body number of the disk or wall that was too fast at fast_step; -1: none */
  int64_t fast_disk;
  /* Displacement of fast_disk in that step over its radius; for a prescribed body over the
   * smallest radius of a free disk. */
  double fast_displacement;

  void *columns; /* Memory block that holds all columns except those of contacts; owned. */

  /* Numbers of rows of the columns. */
  size_t n_free, n_disks, n_bodies;
  /* Ghosts: copies of disks that other ranks own, in the slots from n_free on; counted in
   * n_disks. */
  size_t n_ghosts;
  size_t n_contacts, contact_capacity;
  size_t n_motions, n_phases, n_rotations, n_slides, n_means, n_visits, n_fielded, n_clumps;
  /* Rows of the cell_* columns, and of cell_u ... nonaffine_y; 0 unless a phase deforms the box. */
  size_t n_cell, n_cell_disks;
  size_t n_surfaces;  /* number of walls if a motion moves the surface of any, else 0 */
  size_t law_columns; /* 1: the state has the columns of SD_CONTACT_MORE; 0: these are empty */

  /* The following columns have one row per body, by slot. */
  uint32_t *id; /* body number in the model */
  /* Position in the box, and angle: the angle is turn + theta, theta within [-4, 4] rad, turn a
   * multiple of 8 rad. */
  double *x, *y, *theta, *turn;
  double *vx, *vy, *omega;
  /* periods crossed along x and y: absolute position = x + image_x * box length */
  int32_t *image_x, *image_y;
  double *radius, *mass, *inertia;
  int32_t *material, *group;
  /* Prescribed coordinates: position and angle without the displacement of the running motions. */
  double *base_x, *base_y, *base_theta;
  double *force_x, *force_y, *torque; /* contact forces and torque at the last step */
  /* Energy dissipated by viscosity in this body's contacts since step 0: half of each contact's
   * loss, all of it if the partner is a wall or a driven disk. */
  double *loss_viscous;
  double *loss_friction; /* energy dissipated by sliding, shared as loss_viscous */
  /* energy still stored in contacts when they opened, shared as loss_viscous */
  double *loss_opening;
  /* Work of the paper's tangential force beyond what derives from the tangential energy
   * (SD_PAPER), shared as loss_viscous. */
  double *nonconservative_work;
  /* Parts of loss_viscous, loss_friction and nonconservative_work that belong to contacts that
   * have ended. */
  double *past_viscous, *past_friction, *past_nonconservative_work;

  /* The following columns have one row per wall if a motion moves the surface of any wall, else
   * none. The displacement of the surface along the wall is surface + surface_turn; then its
   * velocity, the force of the contacts on it, and its prescribed displacement without the
   * running motions. */
  double *surface, *surface_turn, *surface_speed, *surface_force, *base_surface;

  /* The following columns have one row per free disk. Column k of the Nordsieck vector (x2 ...)
   * is dt^k/k! times the k-th derivative. */
  int32_t *activity; /* SD_IN_PLAY, SD_WAITING, SD_REMOVED or SD_OUTSIDE */
  /* Energy lost to rolling in contacts that have ended, shared as loss_viscous; only with
   * law_columns. */
  double *past_rolling;
  double *loss_bridge; /* energy lost when capillary bridges formed; only with law_columns */
  double *x2, *y2, *theta2;
  double *x3, *y3, *theta3, *x4, *y4, *theta4, *x5, *y5, *theta5;

  /* The following columns have one row per free disk if the model has fields (physics.md 15):
   * forces and torque of the fields at the last step, the powers of their work, drag and
   * damping, and the time integrals of these powers since step 0. */
  double *field_x, *field_y, *field_torque;
  double *power_work, *power_drag, *power_damping;
  double *field_work, *loss_drag, *loss_damping;

  /* The following columns have one row per closed contact, ordered by (lower slot, partner). */
  uint32_t *contact_a;    /* body number of the disk */
  uint32_t *contact_b;    /* body number of the partner disk or wall */
  uint32_t *contact_part; /* index of the wall segment; 0 for round bodies */
  double *contact_side;   /* +1, -1: side of a straight wall on which the disk is; 0: round body */
  /* 0: stuck; +1, -1: sliding with that sign of the torque; plus SD_FORCE_CARRIED before step 0 */
  int32_t *contact_slide;
#define SD_CONTACT_POINTER(name, unit, meaning) double *contact_##name;
  SD_CONTACT_RECORD(SD_CONTACT_POINTER) /* columns of contact.h */
  /* columns of contact.h that only some laws need; empty unless law_columns is 1 */
  SD_CONTACT_MORE(SD_CONTACT_POINTER)
#undef SD_CONTACT_POINTER

  /* The following columns have one row per motion. */
  int64_t *motion_start; /* step at which the motion was switched on; -1: off */
  /* Random motion: displacement and velocity of the oscillator at the last draw (0) and at the
   * next one (1). Load, servo: u0 and v0 are displacement and velocity; servo: u1 is the
   * smoothed force on the disks. */
  double *motion_u0, *motion_v0, *motion_u1, *motion_v1;

  /* Shape of the periodic box, CELL_X ... of cell.h, relative to its lengths before it deformed. */
  double *cell;
  double *cell_start; /* shape at step cell_from; since then it changes at the rate cell_speed */
  int64_t *cell_from;
  double *cell_speed;
  /* Sum of f_i n_j over contacts with an image n cells away, f the force: xx, xy, yx, yy. */
  double *cell_force;
  double *cell_mean; /* running means of the stress-controlled rates: xx, yy, xy */
  /* Position in the box relative to its edges, when the nonaffine displacement was last updated. */
  double *cell_u, *cell_v;
  /* Displacement since the phase began, minus that of the deforming box. */
  double *nonaffine_x, *nonaffine_y;

  /* The following columns have one row per phase, filled in when the phase ends. */
  int64_t *phase_steps;   /* steps that the phase took; 0: not over */
  int32_t *phase_reached; /* 1 if the goals of settle and compress were met */
  /* settle: kinetic energy per disk, unbalanced force */
  double *phase_kinetic, *phase_unbalanced;
  double *phase_target; /* compress: pressure or packing fraction that was reached */

  /* The following columns hold statistics of the measured phases: rotation_* by disk in
   * rotations, slide_* by entry of slides. */
  /* Angle when measuring began, plus what the disk has since turned while not measured. */
  double *rotation_start;
  double *rotation_bin;  /* angle turned in each completed bin */
  double *rotation_last; /* angle at the end of the last completed bin */
  /* Angle when measuring last paused; the angle turned until it resumes is left out. */
  double *rotation_stop;
  /* number of steps in configuration 4 * (first contact) + (second contact) */
  int64_t *slide_count;
  double *slide_force_min; /* smallest normal force of a contact; 0 if it was open */
  int64_t *slide_openings; /* number of times the contact opened */
  int32_t *slide_was_open; /* 1 if the contact was open at the last step */

  /* The following columns describe the visits of watched pairs of contacts to their sliding
   * configurations (sd_visit sums below). */
  int32_t *visit_class; /* class of the current visit; -1: none */
  /* number of measured steps when the visit began; -1: it began before measuring did */
  int64_t *visit_since;
  int64_t *visit_from; /* number of measured steps when the visit's current part began */
  /* reference normal forces, subtracted from the force sums to keep them small */
  double *visit_reference;
  double *visit_part;   /* sums over the current part of the visit: VISIT_TORQUE ... */
  double *visit_sum;    /* sums per class over completed parts of visits */
  int64_t *visit_count; /* number of visits that began and ended while measured */
  int64_t *visit_steps; /* number of steps of these visits */
  double *visit_steps2; /* sum of the squared numbers of steps of these visits */
  /* Sum of the torque, and number of steps, per class and octave of the visit's age, over
   * completed parts. */
  double *visit_age_torque;
  int64_t *visit_age_steps;

  /* The following columns hold sums for time averages of the free disks, by slot. sum_* are sums
   * over samples unless stated otherwise. */
  /* angles defined as rotation_start, rotation_last, rotation_stop */
  double *mean_angle, *mean_last, *mean_stop;
  double *mean_bin; /* angle turned in each completed bin */
  /* absolute position when measuring began; NAN: the disk was not in play */
  double *mean_x0, *mean_y0;
  /* sums of the displacement from (mean_x0, mean_y0), and of its square */
  double *sum_x, *sum_y, *sum_xx, *sum_yy;
  double *sum_contacts, *sum_sliding; /* sums of the numbers of closed and of sliding contacts */
  double *sum_force;                  /* sum of the normal forces of the disk's contacts */
  double *sum_injected;               /* sum of the power of prescribed bodies on this disk */
  /* sums of the kinetic energies of translation and of rotation */
  double *sum_kinetic, *sum_spin;
  /* Losses in measured phases; during a measured phase minus the value of loss_* at its begin. */
  double *sum_viscous, *sum_friction, *sum_opening;
  int64_t *sum_openings; /* number of contacts that opened in measured steps */

  /* The following columns have one row per clump: motion of its centre of mass, with the same
   * columns as a body. */
  double *clump_x, *clump_y, *clump_theta, *clump_turn;
  double *clump_vx, *clump_vy, *clump_omega;
  int32_t *clump_image_x, *clump_image_y;
  double *clump_base_x, *clump_base_y, *clump_base_theta;
  /* Contact forces on the clump's disks at the last step: their sum, and their torque about the
   * centre. */
  double *clump_force_x, *clump_force_y, *clump_torque;
  double *clump_x2, *clump_y2, *clump_theta2, *clump_x3, *clump_y3, *clump_theta3;
  double *clump_x4, *clump_y4, *clump_theta4, *clump_x5, *clump_y5, *clump_theta5;
};

/* True if the column has one row (or a block) per free disk and no other rows. */
static inline bool state_of_free(sd_extent extent) {
  return extent == SD_PER_FREE || extent == SD_PER_MEAN || extent == SD_PER_MEAN_BIN ||
         extent == SD_PER_FIELDED || extent == SD_PER_LAW_FREE || extent == SD_PER_CELL_DISK;
}
/* True if the column has one row per closed contact. */
static inline bool state_of_contacts(sd_extent extent) {
  return extent == SD_PER_CONTACT || extent == SD_PER_LAW_CONTACT;
}

/* Returns a state without contacts, sized for the model: columns are 0, except bin_steps,
 * mean_bin_steps, box_scale and the box lengths of `cell`, which are 1, and fast_step and
 * fast_disk, which are -1. The caller frees it with sd_state_free. NULL: out of memory. */
sd_state *sd_state_new(const sd_model *model);
/* Returns a state that has only the row counts for all disks of the model; it has no columns. */
sd_state state_sizes(const sd_model *model);
/* Bytes of the columns of a state of the model with this many contacts. */
double state_bytes(const sd_model *model, size_t contacts);
/* Returns a lower estimate, in bytes, of the memory of a simulation in one process: the model's
 * disks and the state's columns without contacts. Columns that stay 0 (derivatives, losses) may
 * take no memory, but neighbour lists and forces, which are not counted, take more than these
 * save. */
double state_least_bytes(const sd_model *model);
/* Bytes that each disk adds to state_least_bytes, at least, whatever the model; free: for a free
 * disk. */
size_t state_disk_bytes(bool free);
/* Reports an error and returns SD_ERROR_IO if state_least_bytes exceed the available memory
 * (memory_fits). */
sd_status state_refuse(const sd_model *model, sd_messages *messages);
/* Does what sd_state_new does for a state with n_free of the free disks, slots for n_ghosts
 * ghosts, and all prescribed bodies of the model. */
sd_state *state_new_part(const sd_model *model, size_t n_free, size_t n_ghosts);
/* Moves the columns, except those of contacts, to new memory that each thread touches first for
 * its range, so that the pages are local to it (NUMA). They stay in place without threads (c
 * NULL) or without memory. */
void state_spread(sd_state *state, pool *c);
/* Initial value of FNV-1a, and the hash of further bytes: sd_state_hash applies it to the
 * columns one after the other. */
#define STATE_HASH UINT64_C(14695981039346656037)
uint64_t state_hash_bytes(uint64_t hash, const void *data, size_t bytes);
/* Makes the contact columns hold at least n rows and keeps the existing ones. SD_ERROR_IO: out
 * of memory. */
sd_status sd_state_reserve_contacts(sd_state *state, size_t n);
/* Returns the history of stored contact c; columns that the state does not have are 0. */
sd_contact_record sd_state_record(const sd_state *state, size_t c);
/* Sets the history of stored contact c. */
void sd_state_set_record(sd_state *state, size_t c, const sd_contact_record *record);

/* Finds the slot of a body in a state from the body's number.
 *
 * The table is an array if the state has all bodies. A rank with some of them uses a hash table
 * (open addressing), so that its memory does not grow with the whole system. The numbers on a
 * rank form runs, such as rows of a packing: blocks of 8 numbers stay together in the table, and
 * blocks are spread by multiplication with an odd number (Knuth's multiplicative hashing).
 */

#define SLOT_NONE UINT32_MAX

typedef struct slot_table {
  uint32_t *slot; /* array: slot of each body; hash table: slot of each entry */
  /* Body number of each entry, SLOT_NONE: empty. NULL: the table is the array slot[body]. */
  uint32_t *body;
  uint32_t mask;   /* hash table: number of entries, a power of two, minus 1 */
  int shift;       /* hash table: 32 minus the number of bits of a block's index */
  size_t n_bodies; /* number of bodies in the model; clumps have the numbers that follow */
} slot_table;

/* Makes the table for the bodies and clumps of `state`; n_bodies: number of bodies in the model,
 * which clump numbers follow. False: out of memory. */
bool slot_table_new(slot_table *t, const sd_state *state, size_t n_bodies);
void slot_table_free(slot_table *t);
/* Updates the table after the same bodies have changed their slots. */
void slot_table_fill(slot_table *t, const sd_state *state);

/* Entry at which the search for a body begins. */
static inline uint32_t slot_table_home(const slot_table *t, uint32_t body) {
  return (body / 8 * UINT32_C(2654435769) >> t->shift) * 8 + body % 8;
}

/* Returns the slot of a body; SLOT_NONE: the state does not have it. */
static inline uint32_t slot_of(const slot_table *t, uint32_t body) {
  if (!t->body) return t->slot[body];
  uint32_t k = slot_table_home(t, body);
  while (t->body[k] != body && t->body[k] != SLOT_NONE) k = (k + 1) & t->mask;
  return t->body[k] == body ? t->slot[k] : SLOT_NONE;
}

/* Statistics of the visits of a watched pair of contacts to each of its sliding
 * configurations: torque, normal forces and duration.
 *
 * A visit is an unbroken run of measured steps in one of six classes. Each step adds to the sums
 * of the current part of the visit, which are added to the sums of the class when the part ends:
 * when the class changes, or when the age of the visit reaches the next octave. So a step costs
 * a few additions, and short sums lose no digits.
 */

/* Classes: S++, S+-, S-+ and S-- are 2 * (first contact) + (second contact); stick: at least one
 * contact stuck, none open; open: at least one contact open. */
enum { VISIT_STICK = 4, VISIT_OPEN = 5, VISIT_CLASSES = SD_CONFIGURATIONS, VISIT_NONE = -1 };
/* Sums of a part: torque and its square; then per contact the normal force minus its reference,
 * and the square of this. */
enum { VISIT_TORQUE, VISIT_TORQUE2, VISIT_FORCE, VISIT_FORCE2, VISIT_SUMS = VISIT_FORCE + 4 };
/* Bins of a visit's age: below VISIT_YOUNG steps, then octaves; the last bin is unbounded. */
enum { VISIT_YOUNG = 32, VISIT_AGES = SD_AGES };

/* Class of a pair of contacts in the states first and second (SD_SLIDE_POSITIVE ... SD_OPEN). */
static inline int visits_class(int first, int second) {
  int more = first > second ? first : second;
  return more >= SD_STUCK ? more + 2 : 2 * first + second;
}

/* Bin of an age >= 0, in steps. */
static inline int visits_octave(int64_t age) {
  int b = 63 - __builtin_clzll((unsigned long long)age | (VISIT_YOUNG / 2)) - 4;
  return b < VISIT_AGES - 1 ? b : VISIT_AGES - 1;
}
/* Number of measured steps from `now` until the current part ends because of its age; HUGE_VAL:
 * it does not. */
double visits_left(const sd_state *s, size_t k, int64_t now);
/* Ends the current part of pair k after `now` measured steps; the next step is in `class`. The
 * part's sums are part[q * stride]; the caller sets them to 0 afterwards. */
void visits_next(sd_state *s, size_t k, int class, const double *part, size_t stride, int64_t now);
/* Ends the current visit of pair k when measuring pauses or begins; its duration stays unknown. */
void visits_cut(sd_state *s, size_t k);

#endif

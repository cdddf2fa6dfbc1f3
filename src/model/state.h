/* state.h: the struct behind slipdisk/state.h. Each row of sd_fields describes one member. */
#ifndef MODEL_STATE_H
#define MODEL_STATE_H

#include <math.h>

#include "base/team.h"
#include "slipdisk/contact.h"
#include "slipdisk/state.h"

typedef struct sd_model sd_model; /* defined in model.h */

/* Offset added to the column contact_slide, until step 0, if the stored force of the contact is
 * valid (force_carried of sd_contact_memory). */
enum { SD_FORCE_CARRIED = 4 };

struct sd_state {
  /* The following members have one value per run. */
  int64_t step;       /* number of steps completed since the start */
  int64_t phase;      /* index of the current phase of the run; n_phases: the run is over */
  int64_t phase_step; /* number of steps completed in the current phase */
  /* Work done by prescribed bodies and coordinates, and by the program's force fields, since
   * step 0. */
  double work_driven;
  double energy_start; /* kinetic + elastic + external energy at step 0 */
  int64_t measured;    /* number of steps in which statistics were gathered */
  int64_t bin_steps;   /* number of steps per bin of the angle record, a power of two */
  int64_t bins;        /* number of completed bins of the angle record */
  double box_scale;    /* lengths of the region divided by those of the model; 1: not compressed */
  double field_power;  /* power of the program's force fields at the end of the last step */
  double relaxed;      /* energy removed by the relaxer (FIRE) since step 0 */
  double relax_alpha;  /* FIRE's mixing parameter alpha; set when a phase begins */
  /* FIRE: number of steps with positive power since velocities were last set to 0 */
  int64_t relax_steps;
  int64_t released; /* number of disks released by rain */
  /* number of times that a disk has left the bounds, the rectangle in which disks should stay */
  int64_t outside;
  int64_t mean_samples; /* number of samples of the contacts that the means of each disk include */
  /* Number of steps per bin, and number of completed bins, of the angle records of all free
   * disks (mean_bin). */
  int64_t mean_bin_steps, mean_bins;
  /* First step after which a free disk or a moved body had moved farther in one step than
   * limits.displacement allows; -1: none. */
  int64_t fast_step;
  /* body number of the disk or wall that was too fast at fast_step; -1: none */
  int64_t fast_disk;
  /* Displacement of fast_disk in that step divided by its radius; for a prescribed body divided
   * by the smallest radius of a free disk. */
  double fast_displacement;

  void *columns; /* Memory block that holds all columns except those of contacts; owned. */

  /* Number of free disks; of all disks, ghosts included; of all disks and walls. */
  size_t n_free, n_disks, n_bodies;
  /* Number of ghosts, which are copies of disks that other ranks own, in the slots from n_free
   * on; n_disks includes them. */
  size_t n_ghosts;
  size_t n_contacts, contact_capacity;
  size_t n_breaks, break_capacity; /* bonds that have broken; over ranks all ranks list all */
  size_t n_motions, n_phases, n_rotations, n_slides, n_means, n_visits, n_fielded, n_clumps,
      n_averages;
  /* Number of rows of the columns cell ... cell_mean, and of cell_u ... nonaffine_y; 0 unless a
   * phase deforms the box. */
  size_t n_cell, n_cell_disks;
  size_t n_surfaces; /* number of walls if a motion moves the surface of any, else 0 */
  /* 1: the state has the columns of SD_CONTACT_MORE, which some contact laws need; 0: these are
   * empty */
  size_t law_columns;

  /* The following columns have one row per body, in the order of slots: free disks, other disks,
   * walls. */
  uint32_t *id; /* body number in the model */
  /* Position in the periodic box, and angle turn + theta with theta within [-4, 4] rad and turn
   * a multiple of 8 rad. */
  double *x, *y, *theta, *turn;
  double *vx, *vy, *omega;
  /* number of box lengths crossed along x and y: absolute position = x + image_x * box length */
  int32_t *image_x, *image_y;
  double *radius, *mass, *inertia;
  int32_t *material, *group;
  /* Position and angle without the displacement by the running motions, for coordinates that
   * motions prescribe. */
  double *base_x, *base_y, *base_theta;
  /* sum of the contact forces on the body, and of their torques, at the last step */
  double *force_x, *force_y, *torque;
  /* Energy dissipated by viscosity in this body's contacts since step 0. Each of two bodies
   * takes half of the loss in their contact; a body takes all of it if its partner is a wall or
   * a driven disk. */
  double *loss_viscous;
  /* energy dissipated by sliding, divided between two bodies like loss_viscous */
  double *loss_friction;
  /* energy still stored in contacts when they opened, divided between two bodies like
   * loss_viscous */
  double *loss_opening;
  /* Work done by the part of the paper's tangential force that does not derive from the
   * tangential energy (SD_PAPER), divided between two bodies like loss_viscous. */
  double *nonconservative_work;
  /* Parts of loss_viscous, loss_friction and nonconservative_work that belong to contacts that
   * have ended. */
  double *past_viscous, *past_friction, *past_nonconservative_work;

  /* The following columns have one row per wall if a motion moves the surface of any wall, else
   * none: displacement of the surface along the wall, which is surface + surface_turn; velocity
   * of the surface; force of the contacts on it; its prescribed displacement without the running
   * motions. */
  double *surface, *surface_turn, *surface_speed, *surface_force, *base_surface;

  /* The following columns have one row per free disk. Columns x2 ... x5 (and y, theta) of the
   * integrator hold dt^k/k! times the k-th derivative, k = 2 ... 5. */
  int32_t *activity; /* SD_IN_PLAY, SD_WAITING, SD_REMOVED, SD_OUTSIDE or SD_HELD */
  /* Energy lost to rolling in contacts that have ended, divided between two bodies like
   * loss_viscous; only if law_columns is 1. */
  double *past_rolling;
  double *loss_bridge; /* energy lost when capillary bridges formed; only if law_columns is 1 */
  /* energy of bonds that broke by tension, shear and bending, divided between two bodies like
   * loss_viscous; only if law_columns is 1 */
  double *broken_tension, *broken_shear, *broken_bending;
  double *x2, *y2, *theta2;
  double *x3, *y3, *theta3, *x4, *y4, *theta4, *x5, *y5, *theta5;

  /* The following columns have one row per free disk if the model has force fields
   * (docs/physics.md 15): forces and torque of the fields at the last step; power of their work,
   * of drag and of damping; and the time integrals of these powers since step 0. */
  double *field_x, *field_y, *field_torque;
  double *power_work, *power_drag, *power_damping;
  double *field_work, *loss_drag, *loss_damping;

  /* The following columns have one row per closed contact, ordered by the lower slot of its two
   * bodies, then by its partner. */
  uint32_t *contact_a;    /* body number of the disk */
  uint32_t *contact_b;    /* body number of the partner disk or wall */
  uint32_t *contact_part; /* index of the wall segment that is touched; 0 for round bodies */
  double *contact_side;   /* +1, -1: side of a straight wall on which the disk is; 0: round body */
  /* 0: contact sticks; +1, -1: slides with that sign of the torque; plus SD_FORCE_CARRIED before
   * step 0 */
  int32_t *contact_slide;
#define SD_CONTACT_POINTER(name, ...) double *contact_##name;
  SD_CONTACT_RECORD(SD_CONTACT_POINTER) /* columns in the first table of contact.h */
  /* columns in the second table of contact.h, which some laws need; empty unless law_columns is
   * 1 */
  SD_CONTACT_MORE(SD_CONTACT_POINTER)
#undef SD_CONTACT_POINTER

  /* The following columns have one row per bond that has broken, in the order of steps, then of the
   * two bodies. break_mode: 1 tension, 2 shear, 3 bending (contact/law_bond.h). */
  int64_t *break_step;
  uint32_t *break_a, *break_b;
  int32_t *break_mode;
  double *break_x, *break_y, *break_energy;

  /* The following columns have one row per motion. */
  int64_t *motion_start; /* step at which the motion was switched on; -1: off */
  /* Random motion: displacement and velocity of the oscillator when random numbers were last
   * drawn (u0, v0), and when the next ones are due (u1, v1). Load, servo: u0 and v0 are
   * displacement and velocity of the wall; servo: u1 is the smoothed force on the disks. */
  double *motion_u0, *motion_v0, *motion_u1, *motion_v1;

  /* Shape of the periodic box (CELL_X ... of cell.h), relative to the box lengths before it
   * deformed. */
  double *cell;
  /* shape of the box at step cell_from; since then it changes at the rate cell_speed */
  double *cell_start;
  int64_t *cell_from;
  double *cell_speed;
  /* [4] Sum of f_i n_j (xx, xy, yx, yy) over contacts with a periodic image that is displaced by
   * n boxes; f is the contact force. */
  double *cell_force;
  double *cell_mean; /* [3] running means of the stress-controlled rates of the box: xx, yy, xy */
  /* Position in the box relative to the box edges, when the nonaffine displacement was last
   * updated. */
  double *cell_u, *cell_v;
  /* Displacement of each disk since the phase began, minus that of the deforming box. */
  double *nonaffine_x, *nonaffine_y;

  /* The following columns have one row per phase of the run, filled in when the phase ends. */
  int64_t *phase_steps; /* number of steps that the phase took; 0: it is not over */
  /* 1 if the goals at which the phase may end (settle, compress) were met */
  int32_t *phase_reached;
  /* phase that may end by settle: kinetic energy per disk and unbalanced force ratio at its end */
  double *phase_kinetic, *phase_unbalanced;
  double *phase_target; /* phase that compresses: pressure or packing fraction that was reached */

  /* The following columns hold statistics of the measured phases: rotation_* with a row per disk
   * in model->rotations, slide_* with a row per watched pair of contacts in model->slides. */
  /* Angle of the disk when measuring began, plus the angle that it has turned since in phases
   * that are not measured. */
  double *rotation_start;
  double *rotation_bin;  /* angle turned by the disk in each completed bin of time */
  double *rotation_last; /* angle of the disk at the end of the last completed bin */
  /* Angle of the disk when measuring last paused; the angle turned until it resumes is not
   * counted. */
  double *rotation_stop;
  /* Number of steps for each joint state of the two contacts, at index 4 * (state of the first)
   * + (state of the second). */
  int64_t *slide_count;
  /* smallest normal force of each watched contact; 0 if the contact was open */
  double *slide_force_min;
  int64_t *slide_openings; /* number of times that each watched contact opened */
  int32_t *slide_was_open; /* 1 if the watched contact was open at the last step */

  /* The following columns have one row (or block) per watched pair of contacts if their
   * configurations are measured. A visit is an unbroken run of steps in one sliding
   * configuration, called class; details are at the end of this file. */
  int32_t *visit_class; /* sliding configuration (class) of the current visit; -1: none */
  /* number of measured steps when the current visit began; -1: it began before measuring did */
  int64_t *visit_since;
  int64_t *visit_from; /* number of measured steps when the current part of the visit began */
  /* Reference normal force of each contact, subtracted from the summed forces to keep sums
   * small. */
  double *visit_reference;
  double *visit_part; /* [VISIT_SUMS] sums over the current part of the visit */
  /* sums over all completed parts of visits, per class (sliding configuration) */
  double *visit_sum;
  int64_t *visit_count; /* number of visits that began and ended in measured steps, per class */
  int64_t *visit_steps; /* number of steps of these completed visits, per class */
  /* sum of the squared durations of these completed visits, per class, steps^2 */
  double *visit_steps2;
  /* Sum of the torque, and number of steps, per class and age of the visit (bins of a factor of
   * two), over completed parts. */
  double *visit_age_torque;
  int64_t *visit_age_steps;

  /* The following columns hold sums for time averages, with one row per free disk, in the order
   * of slots. sum_* are sums over samples unless stated otherwise. */
  /* angles of each free disk, defined like rotation_start, rotation_last and rotation_stop */
  double *mean_angle, *mean_last, *mean_stop;
  double *mean_bin; /* angle turned by the disk in each completed bin of time */
  /* absolute position of the disk when measuring began; NAN: it did not take part then */
  double *mean_x0, *mean_y0;
  /* sums of the displacement of the disk from (mean_x0, mean_y0), and of its square */
  double *sum_x, *sum_y, *sum_xx, *sum_yy;
  /* sums of the numbers of closed and of sliding contacts of the disk */
  double *sum_contacts, *sum_sliding;
  double *sum_force; /* sum of the normal forces of the disk's contacts, over samples */
  /* sum of the power that prescribed bodies transfer to this disk */
  double *sum_injected;
  /* sums of the disk's kinetic energies of translation and of rotation */
  double *sum_kinetic, *sum_spin;
  /* Energy lost in measured phases. During a measured phase, the value of the column loss_* at
   * its begin is subtracted already, and that at its end is not added yet. */
  double *sum_viscous, *sum_friction, *sum_opening;
  int64_t *sum_openings; /* number of contacts of the disk that opened in measured steps */

  /* The following columns have one row per clump: motion of its centre of mass, in columns like
   * those of a body. */
  double *clump_x, *clump_y, *clump_theta, *clump_turn;
  double *clump_vx, *clump_vy, *clump_omega;
  int32_t *clump_image_x, *clump_image_y;
  double *clump_base_x, *clump_base_y, *clump_base_theta;
  /* Contact forces on the clump's disks at the last step: their sum, and their torque about the
   * centre. */
  double *clump_force_x, *clump_force_y, *clump_torque;
  double *clump_x2, *clump_y2, *clump_theta2, *clump_x3, *clump_y3, *clump_theta3;
  double *clump_x4, *clump_y4, *clump_theta4, *clump_x5, *clump_y5, *clump_theta5;

  /* The following columns belong to the averages of the series. */
  int64_t *average_rows;    /* number of measured rows in the bins */
  int64_t *average_missing; /* number of measured rows left out since a value was not finite */
  /* sum of the columns in rate() in the last row, for numerator and denominator */
  double *average_last;
  double *average_bin; /* sum over the rows of each bin, for numerator and denominator */
};

/* True if columns with this extent (meaning of rows) have one row or block per free disk, and no
 * other rows. */
static inline bool state_of_free(sd_extent extent) {
  return extent == SD_PER_FREE || extent == SD_PER_MEAN || extent == SD_PER_MEAN_BIN ||
         extent == SD_PER_FIELDED || extent == SD_PER_LAW_FREE || extent == SD_PER_CELL_DISK;
}
/* True if columns with this extent (meaning of rows) have one row per closed contact. */
static inline bool state_of_contacts(sd_extent extent) {
  return extent == SD_PER_CONTACT || extent == SD_PER_LAW_CONTACT;
}

/* Returns a state without contacts, sized for the model: columns are 0, except bin_steps,
 * mean_bin_steps, box_scale and the box lengths of `cell`, which are 1, and fast_step and
 * fast_disk, which are -1. The caller frees it with sd_state_free. NULL: out of memory. */
sd_state *sd_state_new(const sd_model *model);
/* Returns a state that has only the row counts for all disks of the model; it has no columns. */
sd_state state_sizes(const sd_model *model);
/* Returns the number of bytes in the columns of a state of this model with this many contacts. */
double state_bytes(const sd_model *model, size_t contacts);
/* Returns a lower estimate, in bytes, of the memory of a simulation in one process: the model's
 * disks and the state's columns without contacts. Columns that stay 0 (derivatives, losses) may
 * take no memory, but neighbour lists and forces, which are not counted, take more than these
 * save. */
double state_least_bytes(const sd_model *model);
/* Returns the smallest number of bytes that each further disk adds to state_least_bytes,
 * whatever the model; free: for a free disk. */
size_t state_disk_bytes(bool free);
/* Reports an error and returns SD_ERROR_IO if a simulation needs more memory (state_least_bytes)
 * than is available. */
sd_status state_refuse(const sd_model *model, sd_messages *messages);
/* Returns the state of one rank, made like sd_state_new, with n_free of the free disks, slots
 * for n_ghosts ghosts (copies of disks of other ranks), and all prescribed bodies of the model.
 * NULL: out of memory. */
sd_state *state_new_part(const sd_model *model, size_t n_free, size_t n_ghosts);
/* Moves the columns, except those of contacts, to new memory in which each thread first touches
 * its own range of rows, so that the pages are local to it (NUMA). Columns stay in place if
 * there are no threads (c is NULL) or no memory. */
void state_spread(sd_state *state, pool *c);
/* True if two phases act alike in one respect. */
typedef struct sd_phase sd_phase;
typedef bool phase_alike(const sd_phase *one, const sd_phase *next);
/* Returns the number of steps of the present phase and of the phases directly before it that are
 * alike, so that a phase cut in two keeps its schedule. */
int64_t state_steps_alike(const sd_model *m, const sd_state *s, phase_alike *alike);
/* True if the phase directly before the present one is alike. */
bool state_goes_on(const sd_model *m, const sd_state *s, phase_alike *alike);
/* Initial value of the hash FNV-1a. state_hash_bytes continues a hash with further bytes;
 * sd_state_hash applies it to the columns one after the other. */
#define STATE_HASH UINT64_C(14695981039346656037)
uint64_t state_hash_bytes(uint64_t hash, const void *data, size_t bytes);
/* Makes the contact columns hold at least n rows and keeps the existing ones. SD_ERROR_IO: out
 * of memory. */
sd_status sd_state_reserve_contacts(sd_state *state, size_t n);
/* Makes the columns of broken bonds hold at least n rows and keeps the existing ones. SD_ERROR_IO:
 * out of memory. */
sd_status state_reserve_breaks(sd_state *state, size_t n);
/* Gives the state as many rows of contacts and of broken bonds as another one has, without their
 * values. SD_ERROR_IO: out of memory. */
sd_status state_size_like(sd_state *state, const sd_state *other);
/* Returns the history of stored contact c; columns that the state does not have are 0. */
sd_contact_record sd_state_record(const sd_state *state, size_t c);
/* Sets the history of stored contact c. */
void sd_state_set_record(sd_state *state, size_t c, const sd_contact_record *record);

/* A table that gives the slot of a body in a state from the body's number.
 *
 * The table is an array if the state has all bodies. A rank with some of them uses a hash table
 * (open addressing), so that its memory does not grow with the whole system. The body numbers on a
 * rank form runs, such as rows of a packing: blocks of 8 numbers stay together in the hash table,
 * and blocks are spread by multiplication with an odd number (Knuth's multiplicative hashing).
 */

#define SLOT_NONE UINT32_MAX

typedef struct slot_table {
  uint32_t *slot; /* array: slot of each body; hash table: slot of the body in each entry */
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

/* Returns the entry of the hash table at which the search for a body begins. */
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

/* Statistics of the visits of a watched pair of contacts to each of its sliding configurations:
 * torque, normal forces and duration.
 *
 * A visit is an unbroken run of measured steps in one of six classes. Each step adds to the sums of
 * the current part of the visit, which are added to the sums of the class when the part ends: when
 * the class changes, or when the age of the visit reaches the next power of two. So a step costs a
 * few additions, and short sums lose no digits.
 */

/* Classes of a visit: S++, S+-, S-+ and S-- have the number 2 * (first contact) + (second
 * contact); stick: at least one contact stuck, none open; open: at least one contact open. */
enum { VISIT_STICK = 4, VISIT_OPEN = 5, VISIT_CLASSES = SD_CONFIGURATIONS, VISIT_NONE = -1 };
/* Indices of the sums over a part of a visit: torque and its square; then per contact the normal
 * force minus its reference, and the square of this. */
enum { VISIT_TORQUE, VISIT_TORQUE2, VISIT_FORCE, VISIT_FORCE2, VISIT_SUMS = VISIT_FORCE + 4 };
/* Bins of a visit's age: the first is below VISIT_YOUNG steps, each further one is a factor of
 * two in age; the last bin is unbounded. */
enum { VISIT_YOUNG = 32, VISIT_AGES = SD_AGES };

/* Returns the class of a pair of contacts in the states `first` and `second` (SD_SLIDE_POSITIVE
 * ... SD_OPEN). */
static inline int visits_class(int first, int second) {
  int more = first > second ? first : second;
  return more >= SD_STUCK ? more + 2 : 2 * first + second;
}

/* Returns the bin for the age of a visit, in steps, >= 0. */
static inline int visits_octave(int64_t age) {
  int b = 63 - __builtin_clzll((unsigned long long)age | (VISIT_YOUNG / 2)) - 4;
  return b < VISIT_AGES - 1 ? b : VISIT_AGES - 1;
}
/* Returns the number of measured steps from `now` until the current part of pair k's visit ends
 * because of its age; HUGE_VAL: it does not. */
double visits_left(const sd_state *s, size_t k, int64_t now);
/* Ends the current part of pair k's visit after `now` measured steps, and begins a new visit if
 * `class`, that of the next step, differs. The sums of the part are part[q * stride]; the caller
 * sets them to 0 afterwards. */
void visits_next(sd_state *s, size_t k, int class, const double *part, size_t stride, int64_t now);
/* Ends the current visit of pair k when measuring pauses or begins; its duration stays unknown. */
void visits_cut(sd_state *s, size_t k);

#endif

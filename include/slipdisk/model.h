/* model.h: the model of a simulation: bodies, contact laws, motions, phases. It is constant once
 * finished.
 *
 * A model is read from a deck (deck.h) or built by calls: sd_model_new, then sd_model_add_... and
 * sd_model_set_..., then sd_model_finish, which checks everything and reports all mistakes at once,
 * those of earlier calls included. Every function copies its arguments, so that strings and arrays
 * may be freed when it returns. Pointers must not be NULL unless a comment says that they may be.
 *
 * Units are any consistent set. Angles are in radians, counter-clockwise positive.
 *
 * Bodies have numbers: disk i has number i, in the order in which disks were added; wall w has
 * number n_disks + w. While disks are still to be added, a wall is meant by SD_WALL(w), which
 * sd_model_add_wall returns. Motions also accept clumps, by the number n_disks + n_walls + k or by
 * SD_CLUMP(k).
 *
 * Structs that are passed to functions may grow at their end in later versions. Set members by name
 * ((sd_disk){.radius = 1, .mass = 1}): members that are not named are 0, which is their default.
 */
#ifndef SLIPDISK_MODEL_H
#define SLIPDISK_MODEL_H

#include <stdbool.h>
#include <stdint.h>

#include "slipdisk/contact.h"
#include "slipdisk/law.h"
#include "slipdisk/state.h"
#include "slipdisk/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A model, opaque; sd_model_free frees it. */
typedef struct sd_model sd_model;

/* A disk as it is at the start. */
typedef struct sd_disk {
  const char *name;             /* name of the disk in messages and results; NULL: none */
  double position[3];           /* position of the centre and angle: x, y, theta */
  double velocity[3];           /* velocity of the centre and angular velocity: vx, vy, omega */
  double radius, mass, inertia; /* inertia: moment of inertia about the centre; 0: m R^2/2 */
  double force[3];              /* constant body force (x, y) and torque, besides gravity */
  int material;                 /* number of the disk's material */
  int group; /* number of the disk's group, -1: none; set by sd_model_add_group */
  /* true: coordinate x, y or theta never changes, whatever acts on it; its velocity must be 0 */
  bool locked[3];
  /* true: all coordinates are prescribed; the disk rests, or follows motions that name it */
  bool driven;
  /* true: the disk waits at `position` and touches nothing until a rain releases it */
  bool waiting;
  /* 1 + number of the clump to which the disk belongs, 0: none; set by sd_model_add_clump */
  int clump;
  /* true: the disk is held from the start: only motions move it, until it is released (sd_phase,
   * sd_simulation_set). A fixed disk, or one that a motion moves, is held if a phase names it. */
  bool held;
  /* coordinates that are held while the disk is; filled in by sd_model_finish for disks that can be
   * released: those that motions prescribe, or all if the disk is fixed or no motion moves it */
  bool holds[3];
} sd_disk;

/* A rigid body made of disks, which may overlap one another; it moves about its centre of mass.
 * Unless they are given, its mass is the sum of the masses m of its disks, and its moment of
 * inertia about the centre the sum of I + m d^2, with d the distance of a disk from the centre.
 * A given mass is distributed over the disks in proportion to their masses. */
typedef struct sd_clump {
  const char *name; /* name of the clump in messages and results; NULL: none */
  size_t n_disks;   /* number of disks in the clump */
  /* [n_disks] numbers of free disks that have neither velocities nor locks of their own */
  const uint32_t *disks;
  /* mass, and moment of inertia about the centre; 0: computed from the disks */
  double mass, inertia;
  double velocity[3]; /* vx and vy of the centre of mass, angular velocity */
  /* Constant body force on the centre, and torque, besides gravity and the forces of the clump's
   * disks */
  double force[3];
  bool locked[3]; /* true: coordinate x, y or theta of the clump never changes */
  /* centre of mass at the start, and the angle 0; filled in by sd_model_finish */
  double position[3];
} sd_clump;

/* Shape of a wall; the comment of sd_wall says how each is given. */
typedef enum sd_wall_kind {
  SD_WALL_LINE,
  SD_WALL_SEGMENT,
  SD_WALL_POLYLINE,
  SD_WALL_CIRCLE,
  SD_WALL_ARC,
  SD_WALL_KINDS
} sd_wall_kind;

/* A wall: a body with a pose (pivot, angle) and a shape, which is given in absolute coordinates at
 * the start. Line: infinite, through points[0] and points[1]. Segment: between points[0] and
 * points[1]. Polyline: through its points, closed or not. Circle: about the pivot. Arc: part of a
 * circle about `center`, counter-clockwise from the angle `from` to the angle `to`; its points are
 * filled in, close together, for pictures. Lines, segments and arcs push disks on both sides.
 *
 * A motion of the surface (SD_SURFACE) runs like a belt around the wall: on the left side of the
 * way from the first point to the last it moves along this way, on the right side it moves back.
 * The way of an arc is counter-clockwise; the surface of a circle turns counter-clockwise. */
typedef struct sd_wall {
  const char *name;    /* name of the wall in messages and results; NULL: none */
  sd_wall_kind kind;   /* shape */
  int material;        /* number of the wall's material */
  double pivot[2];     /* point about which the wall turns; motions along x and y displace it */
  size_t n_points;     /* number of points of the wall; line, segment: 2 */
  double (*points)[2]; /* [n_points] absolute coordinates at the start; line, segment, polyline */
  bool closed;         /* polyline: true if its last vertex is joined to the first */
  double radius;       /* radius of a circle or arc, > 0 */
  bool inside;         /* circle: true if disks are inside of it, as in a drum; false: outside */
  double center[2];    /* centre of the circle of an arc */
  double from, to;     /* first and last angle of an arc, rad, from < to <= from + 2 pi */
} sd_wall;

/* Kind of motion, which is the form of its signal u(t). A, w, phi, v are members of sd_motion:
 * amplitude, omega, phase, velocity. Equations are those of the paper. */
typedef enum sd_motion_kind {
  SD_MOTION_VELOCITY,  /* u = v t */
  SD_MOTION_HARMONIC,  /* u = A sin(w t + phi), eq. 20 of the paper */
  SD_MOTION_PARABOLIC, /* parabolic half waves, eq. 21 of the paper with w t + phi for w t */
  SD_MOTION_RANDOM,    /* random vibration of a damped oscillator, eq. 52 of the paper */
  SD_MOTION_TABLE,     /* natural cubic spline through a table of times and values */
  /* Wall of mass `mass` that moves freely along x or y under the force `force` and its contacts */
  SD_MOTION_LOAD,
  /* Wall moved along x or y, at most at the speed `velocity`, until it exerts the force `force`
   * on the disks */
  SD_MOTION_SERVO,
  /* Square wave: rest at -A and A in turn; each change of sides takes the time `rise` pi/w */
  SD_MOTION_SQUARE,
  SD_MOTION_TRIANGLE, /* triangle wave: motion to and fro between -A and A at constant speed */
  SD_MOTION_KINDS     /* number of kinds of motion */
} sd_motion_kind;

/* A prescribed signal u(t), which is added to one coordinate of every body that it names. The time
 * t counts from the moment at which the motion is switched on. Several motions of one coordinate
 * add up. */
typedef struct sd_motion {
  const char *name;    /* name of the motion in messages and results; NULL: none */
  sd_motion_kind kind; /* kind of motion, which is the form of the signal */
  /* coordinate that is moved: SD_X, SD_Y or SD_THETA; SD_SURFACE for the surface of walls */
  int coordinate;
  size_t n_bodies; /* number of bodies moved */
  /* [n_bodies] body numbers of disks, walls (SD_WALL(w)) or clumps (SD_CLUMP(k)) */
  uint32_t *bodies;
  /* wave: amplitude A; random motion: rms displacement; table: factor of the values */
  double amplitude;
  double omega; /* periodic wave, random motion: angular frequency w, rad/time */
  double phase; /* periodic wave: phase phi, rad */
  /* square wave: fraction of half a period that a change of sides takes, 0 < rise <= 1 */
  double rise;
  double velocity; /* motion at constant velocity: v; servo-controlled wall: largest speed */
  double mass;     /* wall that moves as a load: its mass, > 0 */
  /* Force along the coordinate. Load: external force on the wall, which includes the weight of
   * the wall but not its contacts; servo: force that the wall shall exert on the disks */
  double force;
  /* servo-controlled wall: pressure (force/length) to be exerted on the disks along the
   * coordinate; 0: `force` is used */
  double pressure;
  double length; /* servo-controlled wall: its length at the start, on which the pressure acts */
  /* servo-controlled wall: body numbers of the two walls at its lower and upper end, whose
   * distance is the present length; 0: none */
  uint32_t beside[2];
  double damping; /* random motion: damping ratio c of the oscillator */
  /* random motion: number of steps until new random numbers are drawn, >= 1 (h = interval dt) */
  int64_t interval;
  double ramp; /* time in which the motion is faded in from 0 to full size; 0: full size at once */
  /* random motion: number of the random stream, different for independent signals; 0: a new one
   * is chosen */
  uint32_t stream;
  size_t n_table; /* number of rows of the table */
  /* [n_table] increasing times, and the values at these times; values stay constant beyond both
   * ends */
  double *table_time, *table_value;
  /* true: the table is repeated periodically; it must have table_value[0] == table_value[n_table
   * - 1] */
  bool periodic;
} sd_motion;

/* Kind of a force field; sd_body_force has the formulas. */
typedef enum sd_field_kind {
  SD_FIELD_DRAG,     /* viscous drag by a flowing fluid */
  SD_FIELD_DAMPING,  /* Cundall's non-viscous damping */
  SD_FIELD_CENTRAL,  /* force towards a point, proportional to a power of the distance */
  SD_FIELD_ROTATION, /* centrifugal and Coriolis force of a rotating frame */
  SD_FIELD_GRAVITY,  /* gravity whose direction turns with time */
  SD_FIELD_KINDS     /* number of kinds of force field */
} sd_field_kind;

/* Property of a disk to which a drag or central force is proportional: none, the radius, or the
 * mass. */
typedef enum sd_field_per {
  SD_FIELD_PER_DISK,
  SD_FIELD_PER_RADIUS,
  SD_FIELD_PER_MASS
} sd_field_per;

/* A force on free disks that depends on their position and velocity v (physics.md 15).
 * With r = (x, y) - centre:
 *
 *   drag      force f (u - v), torque f_r (w - omega), with f = gamma times 1, R, m for the values
 *             of `per`, f_r = gamma_rotation times 1, R^3, I, the velocity of the fluid
 *             u = flow + (shear_rate r_y - swirl r_y, swirl r_x), w = swirl - shear_rate/2
 *   damping   -alpha |F| sgn(v) of each coordinate, F the sum of all other forces; the torque
 *             likewise, with alpha_rotation
 *   central   -strength r s^(power - 1), s^2 = r^2 + softening^2, times 1, R, m
 *   rotation  m omega^2 r + 2 m omega (v_y, -v_x)
 *   gravity   -m g (sin phi, cos phi), with phi = tilt + omega t, t the time since the start */
typedef struct sd_body_force {
  const char *name;   /* name of the field in messages and results; NULL: none */
  sd_field_kind kind; /* kind of field; the formulas are above */
  size_t n_disks;     /* number of disks on which the field acts; 0: it acts on all free disks */
  uint32_t *disks;    /* [n_disks] numbers of the disks on which the field acts */
  /* Drag and central force: property of a disk to which the force is proportional */
  sd_field_per per;
  /* drag, central force and rotation: origin of r in the formulas */
  double centre[2];
  /* drag: coefficient of the force, coefficient of the torque, >= 0 */
  double gamma, gamma_rotation;
  /* drag: uniform velocity of the fluid, length/time; shear rate, 1/time; rotation, rad/time */
  double flow[2], shear_rate, swirl;
  /* damping: fraction of the force, fraction of the torque that is taken away, 0 <= alpha < 1 */
  double alpha, alpha_rotation;
  /* central force: strength, > 0 attracts; softening length, >= 0 */
  double strength, softening;
  int64_t power; /* central force: power of the distance, -8 ... 8; 1: a spring */
  /* rotation, gravity: angular velocity of the rotating frame, of the direction; rad/time */
  double omega;
  double g, tilt; /* gravity: strength, length/time^2; angle of the direction at the start, rad */
} sd_body_force;

/* Criteria at which a phase of the run ends before its full length: at the first check at which
 * all criteria > 0 hold and no disk waits for its release any more. */
typedef struct sd_settle {
  bool asked;     /* true: the phase may end early by these criteria */
  double kinetic; /* largest kinetic energy per free disk that takes part; 0: not a criterion */
  /* Largest ratio of the mean resultant force on a disk to the mean normal force of a contact;
   * 0: not a criterion */
  double unbalanced;
  int64_t every; /* number of steps between checks, >= 1 */
} sd_settle;

/* Compression: lengths of the region and all positions in it change by a common factor until the
 * target is reached. */
typedef struct sd_compress {
  bool asked; /* true: this phase of the run compresses the system */
  /* target pressure, force/length; target packing fraction; one of them > 0 */
  double pressure, fraction;
  double rate;      /* largest relative change of the lengths per unit of time, > 0 */
  double tolerance; /* accepted relative difference between the quantity and its target */
} sd_compress;

/* Components of the velocity gradient of a deforming box, as indices of arrays, and their
 * number. */
enum { SD_CELL_XX, SD_CELL_YY, SD_CELL_XY, SD_CELL_COMPONENTS };
/* Deformation of the periodic box in a phase of the run. Images are shifted by h n, with h =
 * ((Lx, offset), (0, Ly)) and integers n, and dh/dt = L h with the velocity gradient L = ((xx,
 * xy), (0, yy)). Each component of L is given, or controlled by a stress. */
typedef struct sd_cell {
  bool asked;                      /* true: the box deforms in this phase of the run */
  double rate[SD_CELL_COMPONENTS]; /* components of L, 1/time; xy: d vx/dy */
  /* true: this component of L follows from the stress, not from `rate` */
  bool controlled[SD_CELL_COMPONENTS];
  /* Target stress of controlled components, force/length, compression positive */
  double stress[SD_CELL_COMPONENTS];
  /* time in which a controlled stress reaches its target; 0: chosen by the program */
  double response;
  double max_rate; /* largest rate of controlled components, 1/time; 0: no limit */
  /* true: a change of the rates moves periodic images only; false: the velocities of all disks
   * follow the change at once. */
  bool boundary;
} sd_cell;

/* Bonds that a phase makes between surfaces whose gap is at most bond_gap of their law. */
typedef struct sd_bonding {
  bool asked;  /* true: bonds are made at the beginning of the phase */
  bool sinter; /* true: at each contact that begins in the phase, too */
  bool later;  /* true: only at these */
  /* numbers of the bodies between which bonds are made (SD_WALL(w) for walls); none: all */
  size_t n_between;
  const uint32_t *between;
  /* pairs of bodies to be bonded when the phase begins; none: all pairs of the bodies above */
  size_t n_pairs;
  const uint32_t (*pairs)[2];
} sd_bonding;

/* A phase of a run: a number of steps with the same motions, fields and outputs. */
typedef struct sd_phase {
  const char *name; /* name of the phase in messages and results; NULL: none */
  /* number of steps; largest number if the phase may end early (settle); 0: no end */
  int64_t steps;
  /* [motions of the model] true: this motion is on in the phase; NULL: all are on */
  bool *active;
  /* [fields of the model] true: this field is on in the phase; NULL: all are on */
  bool *fields;
  bool measure; /* true: statistics are gathered in this phase */
  /* number of steps between rows of the time series; 0: there is no time series */
  int64_t series_every;
  int64_t frames_every;   /* number of steps between stored frames of all bodies; 0: no frames */
  int64_t contacts_every; /* number of steps between stored contact tables; 0: no tables */
  /* criteria at which the phase ends before its full length; off unless settle.asked */
  sd_settle settle;
  /* true: velocities are steered towards equilibrium (FIRE), so that the motion is not dynamics */
  bool relax;
  /* compression to a pressure or packing fraction; off unless compress.asked */
  sd_compress compress;
  sd_cell cell; /* deformation of the periodic box; off unless cell.asked */
  /* Numbers of disks that are held from the start of this phase on, and of disks that are released
   * then. A disk that is held loses its velocity; one that is released keeps it. */
  size_t n_hold, n_release;
  const uint32_t *hold, *release; /* [n_hold], [n_release] */
  sd_bonding bond;
} sd_phase;

/* Action if the centre of a free disk leaves the bounds of the model: report it, end the run, or
 * remove the disk. */
typedef enum sd_outside { SD_OUTSIDE_REPORT, SD_OUTSIDE_STOP, SD_OUTSIDE_REMOVE } sd_outside;

/* Error bar at which the last phase ends. After `least` steps or more, the phase ends at the
 * first check at which the error bar of a mean angular velocity is small enough (sd_goal_of,
 * sd_goal_look in measure.h). It ends after all its steps in any case. */
typedef struct sd_until {
  bool asked; /* true: the last phase may end early; false: it takes all its steps */
  /* number of steps of the last phase before the first check, from 1 to all its steps */
  int64_t least;
  size_t rotation; /* index of the measured rotation: k of sd_rotation_of */
  /* true: the mean is that of t_g Omega instead of Omega, with t_g = sqrt(2 R/g) */
  bool scaled;
  /* Error bar to be reached, in the unit of the mean; 0: `relative` is used */
  double error;
  double relative; /* error bar to be reached, as a fraction of |mean| */
} sd_until;

/* A disk and two partners. The sliding configuration of the disk's contacts with them is counted in
 * every measured step: each contact slides with positive or negative torque on the disk, sticks, or
 * is open. */
typedef struct sd_slide_watch {
  uint32_t disk;       /* number of the disk */
  uint32_t partner[2]; /* body numbers of the two partners */
} sd_slide_watch;

/* --- building --------------------------------------------------------------------------------- */

/* Returns an empty model, never NULL, with the defaults of docs/deck.md: Gear's integrator of fifth
 * order, the paper's tangential force, open space. The caller frees it with sd_model_free. The
 * calls below note mistakes in the model; sd_model_finish reports them. */
SD_API sd_model *sd_model_new(void);
/* Frees a model; NULL is allowed. */
SD_API void sd_model_free(sd_model *model);

/* Sets a key of docs/deck.md that is a number, an integer, or true (1) or false (0): "dt", "seed",
 * "skin", "max_overlap", "limits.residual", "measure.disks", ... */
SD_API void sd_model_set(sd_model *model, const char *key, double value);
/* Sets a key of docs/deck.md that is a word or a text: "integrator" ("gear5", "verlet"),
 * "contact_variant", "title", "bounds.outside", ... */
SD_API void sd_model_set_text(sd_model *model, const char *key, const char *value);
/* Sets the acceleration of gravity, length/time^2; without this call gravity is (0, 0). */
SD_API void sd_model_set_gravity(sd_model *model, double x, double y);
/* Makes space periodic along SD_X or SD_Y, with a box from lower to upper. Without this call
 * space is open. */
SD_API void sd_model_set_periodic(sd_model *model, int coordinate, double lower, double upper);
/* Sets the rectangle to whose area the packing fraction refers and which compression shrinks; in a
 * periodic box it is the box. */
SD_API void sd_model_set_region(sd_model *model, const double lower[2], const double upper[2]);
/* Sets a rectangle that the centres of free disks should not leave. The key "bounds.outside"
 * says what happens to a disk that leaves it: it is reported, is removed, or ends the run. */
SD_API void sd_model_set_bounds(sd_model *model, const double lower[2], const double upper[2]);

/* Adds a material and returns its number. law: contact law between two bodies of this material;
 * NULL: there is none, and no two such bodies may touch. */
SD_API int sd_model_add_material(sd_model *model, const char *name, const sd_contact_law *law);
/* Sets the contact law between bodies of material_a and bodies of material_b, in either order. With
 * E_star the law of the model has the k_n, and with poisson the k_t, that follow for R_eff = 1. */
SD_API void sd_model_set_law(sd_model *model, int material_a, int material_b,
                             const sd_contact_law *law);
/* Adds a disk and returns its number. */
SD_API uint32_t sd_model_add_disk(sd_model *model, const sd_disk *disk);
/* Adds n disks and returns the number of the first. If there is no memory none is added. */
SD_API uint32_t sd_model_add_disks(sd_model *model, size_t n, const sd_disk *disks);
/* Replaces a disk that was added before. */
SD_API void sd_model_set_disk(sd_model *model, uint32_t number, const sd_disk *disk);
/* Adds a group, a name for n disks, and returns its number. A disk is in one group at most, the
 * last that names it. */
SD_API int sd_model_add_group(sd_model *model, const char *name, size_t n, const uint32_t *disks);
/* Wall w as a body number that stays valid while disks are added. */
#define SD_WALL(w) (0x80000000u | (uint32_t)(w))
/* Adds a wall and returns SD_WALL(w), with w counted from 0. */
SD_API uint32_t sd_model_add_wall(sd_model *model, const sd_wall *wall);
/* Clump k as a body number for motions. */
#define SD_CLUMP(k) (0x40000000u | (uint32_t)(k))
/* Makes a rigid body of disks that were added before. Returns SD_CLUMP(k), with k counted from 0,
 * for use in motions. */
SD_API uint32_t sd_model_add_clump(sd_model *model, const sd_clump *clump);
/* Adds a motion and returns its number. It is on in phases with `active` NULL, and off in phases
 * with an array `active` that were added before it. */
SD_API int sd_model_add_motion(sd_model *model, const sd_motion *motion);
/* Adds a force field and returns its number. It is on in phases with `fields` NULL, and off in
 * phases with an array `fields` that were added before it. */
SD_API int sd_model_add_field(sd_model *model, const sd_body_force *field);
/* Adds a phase and returns its number. Arrays `active` and `fields` have an entry per motion and
 * field added so far. If no phase is added there is one without an end, in which all motions are
 * on. */
SD_API int sd_model_add_phase(sd_model *model, const sd_phase *phase);
/* Adds n disks to those whose mean angular velocity is measured (sd_rotation_of in measure.h). */
SD_API void sd_model_measure_rotation(sd_model *model, size_t n, const uint32_t *disks);
/* Adds a disk with two partners whose sliding configuration is counted (sd_slide_of in
 * measure.h). */
SD_API void sd_model_measure_sliding(sd_model *model, const sd_slide_watch *watch);
/* Lets the last phase end when an error bar is small enough, as `until` says. */
SD_API void sd_model_set_until(sd_model *model, const sd_until *until);

/* Checks ranges and references and fills in inertias, flags and derived tables. It is called once,
 * after the last change: simulations refuse a model that was changed since. A motion prescribes one
 * coordinate of a disk that it names and leaves the others as they are; the disk becomes `driven`
 * if it is fixed, or if all three are prescribed or locked. Returns SD_ERROR_USER, with a message
 * per mistake, if there is any. */
SD_API sd_status sd_model_finish(sd_model *model, sd_messages *messages);
/* Returns a copy of a model, to be freed by the caller, without its deck. The copy is finished if
 * the model is, and has the mistakes that were noted so far. NULL: no memory. */
SD_API sd_model *sd_model_clone(const sd_model *model);

/* --- reading ---------------------------------------------------------------------------------- */

/* Returns the number of disks, driven and waiting ones included. */
SD_API size_t sd_model_disks(const sd_model *model);
/* Returns the number of walls. */
SD_API size_t sd_model_walls(const sd_model *model);
/* Returns the number of bodies: disks and walls, without clumps. */
SD_API size_t sd_model_bodies(const sd_model *model);
/* Returns the time step. */
SD_API double sd_model_dt(const sd_model *model);
/* Returns the number of the disk, wall or clump with this name; UINT32_MAX: there is none. */
SD_API uint32_t sd_model_find(const sd_model *model, const char *name);
/* Returns a disk as it was given, with its moment of inertia filled in; NULL: there is no such
 * disk. The pointer is valid as long as the model. */
SD_API const sd_disk *sd_model_disk(const sd_model *model, uint32_t number);
/* Returns the number of clumps. */
SD_API size_t sd_model_clumps(const sd_model *model);
/* Returns clump k as it was given, with disks, mass, moment of inertia and position filled in;
 * NULL: there is no such clump. The pointer is valid as long as the model. */
SD_API const sd_clump *sd_model_clump(const sd_model *model, size_t k);
/* Returns the contact law between two materials; NULL: there are no such materials. The pointer
 * is valid as long as the model. */
SD_API const sd_contact_law *sd_model_law(const sd_model *model, int material_a, int material_b);
/* Returns the name of a body for messages: its own, or one like "disk 17" or "wall 3", which is
 * written into text[size]. */
SD_API const char *sd_model_body_name(const sd_model *model, uint32_t body, char *text,
                                      size_t size);
/* Returns the number of steps of all phases; phases that may end early count in full. */
SD_API int64_t sd_model_steps(const sd_model *model);
/* Returns the side of a wall, along SD_X or SD_Y, on which the disks are at the start: +1 or -1.
 * The mean position of the free disks that do not wait for their release decides; if there are
 * none, the centre of the region. Returns 0 if the wall surrounds the disks or is parallel to
 * the coordinate, if the coordinate is periodic, or if wall_body is no wall. */
SD_API int sd_model_side(const sd_model *model, uint32_t wall_body, int coordinate);
/* Finds two motions that, in this phase, move the same coordinate of one wall, the first of them
 * a load or a servo, and writes their numbers; false: there are none. */
SD_API bool sd_model_clash(const sd_model *model, size_t phase, size_t motion[2]);
/* Returns the shortest period 2 pi/omega of a free disk between two bodies, over all disks and
 * materials with a contact law: vibration on the normal springs, or on the tangential springs with
 * rotation. HUGE_VAL: there is none. Writes the number of the disk unless `disk` is NULL. */
SD_API double sd_model_shortest_period(const sd_model *model, uint32_t *disk);

/* Part of the model that limits the time step: normal spring, tangential spring, viscosity, or a
 * force field. */
typedef enum sd_bound {
  SD_BOUND_NORMAL,
  SD_BOUND_TANGENTIAL,
  SD_BOUND_VISCOSITY,
  SD_BOUND_FIELD
} sd_bound;
/* Stability limit of the time step. */
typedef struct sd_step_limit {
  double dt;      /* smallest time step at which the integrator is unstable; HUGE_VAL: no limit */
  uint32_t disk;  /* number of the disk that sets the limit */
  sd_bound bound; /* part of the model that sets the limit */
} sd_step_limit;
/* Returns the time step from which on the model's integrator is unstable for a disk held between
 * two others (docs/physics.md 5); dt is HUGE_VAL if no disk is free to move. In a packing the
 * limit is up to three times shorter. */
SD_API sd_step_limit sd_model_step_limit(const sd_model *model);

/* Returns the time that a phase needs to compress the system to its packing fraction at the
 * phase's largest rate; NAN: not known. */
SD_API double sd_model_compress_time(const sd_model *model, size_t phase);

/* Adds warnings about settings of a finished model that are allowed but seldom intended: time
 * step, friction without a spring, goals that cannot be reached, overlaps at the start and the
 * like. */
SD_API void sd_model_advise(const sd_model *model, sd_messages *messages);

#ifdef __cplusplus
}
#endif

#endif

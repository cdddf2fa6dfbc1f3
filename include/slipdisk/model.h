/* model.h: what is simulated: bodies, contact laws, motions, phases. Const once it is finished.
 *
 * A model comes from a deck (deck.h), or is built: sd_model_new, then sd_model_add_... and sd_model_set_..., then
 * sd_model_finish, which checks everything and reports all mistakes at once, those of the calls before it included. Every
 * function copies what it is given: strings and arrays can go when it returns. Pointers are not NULL where nothing says that
 * they may be.
 *
 * Units are any consistent set; angles are radians, counter-clockwise positive.
 *
 * Bodies have numbers: disk i has number i, in the order in which they were added; wall w has number n_disks + w. Where a
 * wall is meant before all disks are there, sd_model_add_wall's own value, SD_WALL(w), does as well. Motions also take the
 * number of a clump: n_disks + n_walls + k, or SD_CLUMP(k).
 *
 * Structs that are passed to functions may grow at their end in later versions: set members by name
 * ((sd_disk){.radius = 1, .mass = 1}); what is not named is 0, and 0 is a default.
 */
#ifndef SLIPDISK_MODEL_H
#define SLIPDISK_MODEL_H

#include <stdbool.h>
#include <stdint.h>

#include "slipdisk/contact.h"
#include "slipdisk/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sd_model sd_model;

enum { SD_X = 0, SD_Y = 1, SD_THETA = 2, SD_COORDINATES = 3 };
/* Things that a motion can move: a coordinate, or the surface of a wall, which runs along it while the wall stays (a belt). */
enum { SD_SURFACE = 3, SD_MOVED = 4 };

typedef enum sd_integrator { SD_GEAR5, SD_VERLET } sd_integrator;
/* Tangential force on the centres: the paper's tau, or tau (R_a+R_b)/r which derives from the tangential energy. */
typedef enum sd_variant { SD_PAPER, SD_CONSERVATIVE } sd_variant;

/* Elastic normal force of the overlap: k_n delta, k_n delta^(3/2). */
typedef enum sd_normal_law { SD_NORMAL_LINEAR, SD_NORMAL_HERTZ, SD_NORMAL_LAWS } sd_normal_law;
/* Tangential stiffness: k_t, or k_t sqrt(delta). */
typedef enum sd_tangential_law { SD_TANGENTIAL_SPRING, SD_TANGENTIAL_MINDLIN } sd_tangential_law;
/* Attraction: none; pull_off at contact, falling to 0 at gap `range`; a capillary bridge from touch to gap `rupture`. */
typedef enum sd_cohesion_law {
  SD_COHESION_NONE,
  SD_COHESION_CONSTANT,
  SD_COHESION_BRIDGE
} sd_cohesion_law;

/* Constants of the contact law for one pair of materials (eq. 2, tau, 36; docs/physics.md 2). */
typedef struct sd_contact_law {
  double k_n;     /* normal stiffness > 0, force/length; Hertz: force/length^(3/2) */
  double k_t;     /* tangential stiffness, force/length, >= 0; Mindlin: force/length^(3/2) */
  double gamma_n; /* normal viscosity, force time/length, >= 0 */
  double mu;      /* Amonton's coefficient, >= 0 */
  sd_normal_law normal;
  double
      restitution; /* damping by a coefficient of restitution < 1, besides gamma_n; 0 or 1: none */
  bool damping_pulls; /* key limit_damping = false: the damping may pull while disks overlap */
  double mu_kinetic;  /* <= mu, while a contact slides; 0: mu */
  sd_tangential_law tangential;
  double gamma_t;      /* tangential viscosity, force time/length, >= 0 */
  double k_r, gamma_r; /* rolling stiffness, force/length, and viscosity, force time/length; >= 0 */
  double mu_r;         /* coefficient of rolling friction, >= 0 */
  sd_cohesion_law cohesion;
  double pull_off; /* largest attraction, force */
  double range;    /* constant: gap where it ends, >= 0; bridge: decay length, > 0 */
  double rupture;  /* bridge: gap at which it breaks, > 0 */
} sd_contact_law;

typedef struct sd_disk {
  const char *name;             /* may be NULL */
  double position[3];           /* x, y, theta at the start */
  double velocity[3];           /* vx, vy, omega */
  double radius, mass, inertia; /* inertia 0 means m R^2/2 */
  double force[3];              /* constant body force and torque, gravity not included */
  int material;                 /* index into materials */
  int group;                    /* index into groups, -1: none; set by sd_model_add_group */
  bool locked[3]; /* this coordinate never changes, whatever pushes (velocity must be 0) */
  bool driven;    /* all three coordinates are prescribed: fixed, or by the motions that name it */
  bool waiting;   /* out of play until its rain releases it; position is then where it waits */
  int clump; /* 1 + number of the clump that it belongs to, 0: none; set by sd_model_add_clump */
} sd_disk;

/* Disks that move as one rigid body about its centre of mass; they may overlap one another. Its mass, and the moment of inertia
 * about the centre, are those of its disks (sum of m, of I + m d^2) unless given; a given mass is shared out among the disks, as theirs are. */
typedef struct sd_clump {
  const char *name; /* may be NULL */
  size_t n_disks;
  const uint32_t *disks; /* free disks without velocities and locks of their own */
  double mass, inertia;  /* 0: those of its disks */
  double velocity[3];    /* of the centre; angular velocity */
  double force
      [3]; /* constant body force on the centre, and torque; besides gravity and those of its disks */
  bool locked[3];     /* this coordinate of the clump never changes */
  double position[3]; /* filled in: the centre of mass at the start, angle 0 */
} sd_clump;

typedef enum sd_wall_kind {
  SD_WALL_LINE,
  SD_WALL_SEGMENT,
  SD_WALL_POLYLINE,
  SD_WALL_CIRCLE,
  SD_WALL_ARC,
  SD_WALL_KINDS
} sd_wall_kind;

/* A wall is a body with a pose (pivot, angle) and a shape given in space at the start.
 * Line: points[0] and points[1] lie on it. Segment: its ends. Polyline: its vertices, closed or not.
 * Circle: the pivot is its centre. Arc: of a circle about `center`, counter-clockwise from the angle `from` to `to`; its
 * points are filled in, close together, for pictures. Both sides of a line, segment or arc push.
 *
 * A motion of the surface (SD_SURFACE) runs along the wall from its first point on the left of this way, and back on the
 * right, like a belt around it; an arc's way is counter-clockwise; a circle's surface turns counter-clockwise. */
typedef struct sd_wall {
  const char *name;
  sd_wall_kind kind;
  int material;
  double pivot[2]; /* the point about which it turns, and whose x, y a motion moves */
  size_t n_points;
  double (*points)[2]; /* absolute coordinates at the start */
  bool closed;         /* polyline: the last vertex is joined to the first */
  double radius;       /* circle, arc: > 0 */
  bool inside;         /* circle: disks live inside (a drum) */
  double center[2];    /* arc */
  double from, to;     /* arc: angles, from < to <= from + 2 pi */
} sd_wall;

typedef enum sd_motion_kind {
  SD_MOTION_VELOCITY,  /* u = v t */
  SD_MOTION_HARMONIC,  /* u = A sin(w t + phi), eq. 20 */
  SD_MOTION_PARABOLIC, /* eq. 21 with w t + phi for w t */
  SD_MOTION_RANDOM,    /* eq. 52 */
  SD_MOTION_TABLE,     /* natural cubic spline through a table */
  SD_MOTION_LOAD, /* a wall, x or y: free along the coordinate, of mass `mass`, under `force` */
  SD_MOTION_SERVO, /* a wall, x or y: moves at most at `velocity` until the disks feel `force` from it */
  SD_MOTION_SQUARE,   /* rests at -A and A in turn; changes sides in `rise` pi/w */
  SD_MOTION_TRIANGLE, /* to and fro between -A and A at constant speed */
  SD_MOTION_KINDS
} sd_motion_kind;

/* One prescribed signal u(t), added to one coordinate of every body it names; t counts from the moment
 * the motion is switched on. Several motions on the same coordinate add up. */
typedef struct sd_motion {
  const char *name;
  sd_motion_kind kind;
  int coordinate; /* SD_X, SD_Y, SD_THETA; walls also SD_SURFACE */
  size_t n_bodies;
  uint32_t *bodies; /* body numbers, or SD_WALL(w) */
  double amplitude; /* waves: A; random: rms displacement; table: factor */
  double omega;     /* rad/time: w */
  double phase;     /* rad: phi */
  double rise;      /* square: 0 < rise <= 1 */
  double velocity;  /* constant velocity: v; servo: largest speed */
  double mass;      /* load: of the wall, > 0 */
  double
      force; /* load: on the wall, its weight included; servo: on the disks; along the coordinate */
  double pressure; /* servo: force/length on the disks, along the coordinate; 0: `force` counts */
  double length;   /* servo: of the wall at the start, on which the pressure acts */
  uint32_t beside[2]; /* servo: walls at its lower and upper end that the length follows; 0: none */
  double damping;     /* random: c */
  int64_t interval;   /* random: steps between draws, >= 1 (h = interval dt) */
  double ramp;        /* time over which the motion is faded in, 0: at once */
  uint32_t
      stream; /* random: stream number, unique per independent signal; added with 0: one of its own */
  size_t n_table;
  double *table_time, *table_value; /* table: time increasing; held constant beyond its ends ... */
  bool periodic;                    /* ... or repeated: value[0] == value[n-1] */
} sd_motion;

typedef enum sd_field_kind {
  SD_FIELD_DRAG,     /* viscous drag by a fluid that flows */
  SD_FIELD_DAMPING,  /* Cundall's non-viscous damping */
  SD_FIELD_CENTRAL,  /* towards a point, by distance */
  SD_FIELD_ROTATION, /* a frame that turns: centrifugal and Coriolis force */
  SD_FIELD_KINDS
} sd_field_kind;

/* How the force grows from disk to disk. */
typedef enum sd_field_per {
  SD_FIELD_PER_DISK,
  SD_FIELD_PER_RADIUS,
  SD_FIELD_PER_MASS
} sd_field_per;

/* A force on free disks that follows from their place and velocity (physics.md 15). With r = (x, y) - centre:
 *   drag      f (u - v), torque f_r (w - omega); fluid: u = flow + (shear_rate r_y - swirl r_y, swirl r_x),
 *             w = swirl - shear_rate/2. f = gamma, gamma R, gamma m; f_r = gamma_rotation times 1, R^3, I
 *   damping   -alpha |F| sgn(v) of each coordinate, F the sum of all other forces; torque: alpha_rotation
 *   central   -strength r s^(power - 1), s^2 = r^2 + softening^2; times 1, R, m
 *   rotation  m omega^2 r + 2 m omega (v_y, -v_x) */
typedef struct sd_body_force {
  const char *name; /* may be NULL */
  sd_field_kind kind;
  size_t n_disks; /* 0: it acts on all */
  uint32_t *disks;
  sd_field_per per;                  /* drag, central */
  double centre[2];                  /* all but damping */
  double gamma, gamma_rotation;      /* >= 0 */
  double flow[2], shear_rate, swirl; /* length/time, 1/time, rad/time */
  double alpha, alpha_rotation;      /* 0 <= alpha < 1 */
  double strength, softening;        /* strength > 0: attracts; softening >= 0 */
  int64_t power;                     /* -8 ... 8; 1: a spring */
  double omega;                      /* of the frame, rad/time */
} sd_body_force;

/* A phase ends at the first look at which all criteria that are > 0 hold, and no disk waits any more. */
typedef struct sd_settle {
  bool asked;
  double kinetic;    /* kinetic energy per free disk in play */
  double unbalanced; /* mean resultant force on a disk over the mean normal force of a contact */
  int64_t every;     /* steps between looks, >= 1 */
} sd_settle;

/* Lengths of the region and all positions in it change by a common factor until the target is reached. */
typedef struct sd_compress {
  bool asked;
  double pressure, fraction; /* target: one of them > 0 */
  double rate;               /* largest relative change of the lengths per time, > 0 */
  double tolerance;          /* relative */
} sd_compress;

/* How the periodic box deforms in a phase: positions of images are h n with h = ((Lx, offset), (0, Ly)), and h' = L h with
 * L = ((xx, xy), (0, yy)), the velocity gradient. Each component of L is given, or follows the stress. */
enum { SD_CELL_XX, SD_CELL_YY, SD_CELL_XY, SD_CELL_COMPONENTS };
typedef struct sd_cell {
  bool asked;
  double rate[SD_CELL_COMPONENTS];     /* velocity gradient, 1/time; xy: of vx along y */
  bool controlled[SD_CELL_COMPONENTS]; /* the rate follows the stress */
  double stress[SD_CELL_COMPONENTS];   /* then wanted, force/length, compression positive */
  double response; /* of the control: time in which stress comes to its value; 0: chosen */
  double max_rate; /* of controlled components, 0: any */
  bool boundary;   /* a change of the rates moves images only; else all disks take it up at once */
} sd_cell;

typedef struct sd_phase {
  const char *name;
  int64_t steps;          /* the most, when it may settle before; 0: it has no end */
  bool *active;           /* of each motion; NULL: all are on */
  bool *fields;           /* of each field; NULL: all are on */
  bool measure;           /* statistics are gathered in this phase */
  int64_t series_every;   /* steps between rows of the time series, 0: none */
  int64_t frames_every;   /* steps between stored frames of all bodies, 0: none */
  int64_t contacts_every; /* steps between stored contact tables, 0: none */
  sd_settle settle;
  bool relax; /* velocities are steered towards equilibrium (FIRE) */
  sd_compress compress;
  sd_cell cell;
} sd_phase;

typedef enum sd_outside { SD_OUTSIDE_REPORT, SD_OUTSIDE_STOP, SD_OUTSIDE_REMOVE } sd_outside;

/* When the last phase ends: not before `least` of its steps, then at the first look at which the error bar of
 * a mean angular velocity is small enough (sd_goal_of, sd_goal_look in measure.h), after all its steps in any
 * case. */
typedef struct sd_until {
  bool asked;      /* false: the last phase has all its steps */
  int64_t least;   /* 1 ... steps of the last phase */
  size_t rotation; /* which of the model's rotations */
  bool scaled;     /* t_g Omega instead of Omega */
  double error;    /* error bar to be reached, in the unit of the observable; 0: given as */
  double relative; /* a fraction of |mean| */
} sd_until;

/* A disk and two partners: the configuration of sliding of its two contacts is counted every step. */
typedef struct sd_slide_watch {
  uint32_t disk;
  uint32_t partner[2]; /* body numbers */
} sd_slide_watch;

/* --- building -------------------------------------------------------------------------------------- */

/* An empty model with the defaults of docs/deck.md: Gear 5, paper variant, open space. It is
 * never NULL. */
SD_API sd_model *sd_model_new(void);
SD_API void sd_model_free(sd_model *model); /* NULL is allowed */

/* Sets a key of docs/deck.md that is a number, a whole number, or true (1) and false (0): "dt", "seed", "skin", "max_overlap",
 * "limits.residual", "measure.disks", ... */
SD_API void sd_model_set(sd_model *model, const char *key, double value);
/* Sets a key that is a word or a text: "integrator" ("gear5", "verlet"), "contact_variant", "title", "bounds.outside". */
SD_API void sd_model_set_text(sd_model *model, const char *key, const char *value);
/* Acceleration, length/time^2; (0, 0) to begin with. */
SD_API void sd_model_set_gravity(sd_model *model, double x, double y);
/* Makes coordinate SD_X or SD_Y repeat from lower to upper. Without it space is open. */
SD_API void sd_model_set_periodic(sd_model *model, int coordinate, double lower, double upper);
/* The rectangle whose area the packing fraction refers to, and that compression shrinks; of a periodic box it is the box. */
SD_API void sd_model_set_region(sd_model *model, const double lower[2], const double upper[2]);
/* A rectangle in which the centres of free disks belong; what leaves is reported, taken out, or ends the run
 * (key "bounds.outside"). */
SD_API void sd_model_set_bounds(sd_model *model, const double lower[2], const double upper[2]);

/* Each returns the number of what it added. A mistake is kept for sd_model_finish. */
/* law: of the material with itself; NULL: none, where no two bodies of this material can touch. */
SD_API int sd_model_add_material(sd_model *model, const char *name, const sd_contact_law *law);
/* Law between two materials, both ways. */
SD_API void sd_model_set_law(sd_model *model, int material_a, int material_b,
                             const sd_contact_law *law);
SD_API uint32_t sd_model_add_disk(sd_model *model, const sd_disk *disk);
/* n disks; returns the number of the first. Without memory none is added. */
SD_API uint32_t sd_model_add_disks(sd_model *model, size_t n, const sd_disk *disks);
/* Sets a disk that was added before. */
SD_API void sd_model_set_disk(sd_model *model, uint32_t number, const sd_disk *disk);
/* A name for some disks; a disk belongs to one group at most, the last that names it. */
SD_API int sd_model_add_group(sd_model *model, const char *name, size_t n, const uint32_t *disks);
#define SD_WALL(w) (0x80000000u | (uint32_t)(w))
SD_API uint32_t sd_model_add_wall(sd_model *model, const sd_wall *wall); /* returns SD_WALL(w) */
#define SD_CLUMP(k) (0x40000000u | (uint32_t)(k))
/* Makes one rigid body of disks that were added before; returns SD_CLUMP(k), by which motions mean it. */
SD_API uint32_t sd_model_add_clump(sd_model *model, const sd_clump *clump);
/* A motion is on in phases without `active`, and off in those with it that were added before. */
SD_API int sd_model_add_motion(sd_model *model, const sd_motion *motion);
/* A field is on and off in phases like a motion (`fields`). */
SD_API int sd_model_add_field(sd_model *model, const sd_body_force *field);
/* `active` and `fields`: of the motions and fields added so far. Without any phase there is one that has no end and has all motions on. */
SD_API int sd_model_add_phase(sd_model *model, const sd_phase *phase);
/* Disks whose mean angular velocity is measured (sd_rotation_of in measure.h). */
SD_API void sd_model_measure_rotation(sd_model *model, size_t n, const uint32_t *disks);
/* A disk whose sliding configuration with two partners is counted (sd_slide_of in measure.h). */
SD_API void sd_model_measure_sliding(sd_model *model, const sd_slide_watch *watch);
/* The last phase ends when an error bar is small enough. */
SD_API void sd_model_set_until(sd_model *model, const sd_until *until);

/* Checks ranges and references, fills inertias, flags and derived tables; call once, after the last change.
 * A disk that is named by a motion on a coordinate keeps its other coordinates as they are: it is `driven`
 * when it is fixed or all three are prescribed or locked. Errors: SD_ERROR_USER with one message each. No simulation begins
 * with a model that was changed since. */
SD_API sd_status sd_model_finish(sd_model *model, sd_messages *messages);
/* A copy, finished when the model is, with the mistakes made so far; without the deck that it came from. NULL: no memory. */
SD_API sd_model *sd_model_clone(const sd_model *model);

/* --- reading --------------------------------------------------------------------------------------- */

SD_API size_t sd_model_disks(const sd_model *model);
SD_API size_t sd_model_walls(const sd_model *model);
SD_API size_t sd_model_bodies(const sd_model *model); /* disks + walls */
SD_API double sd_model_dt(const sd_model *model);     /* time step */
/* A body by its name; UINT32_MAX: there is none. */
SD_API uint32_t sd_model_find(const sd_model *model, const char *name);
/* As given, inertia filled in; NULL: there is none. Valid as long as the model. */
SD_API const sd_disk *sd_model_disk(const sd_model *model, uint32_t number);
SD_API size_t sd_model_clumps(const sd_model *model);
/* Clump k as given, its disks, mass, inertia and position filled in; NULL: there is none. Valid as long as the model. */
SD_API const sd_clump *sd_model_clump(const sd_model *model, size_t k);
/* NULL: no such materials. */
SD_API const sd_contact_law *sd_model_law(const sd_model *model, int material_a, int material_b);
/* Name for messages: the body's own, else "disk 17", "wall 3"; written into text[size]. */
SD_API const char *sd_model_body_name(const sd_model *model, uint32_t body, char *text,
                                      size_t size);
/* Steps of all phases; with `until` it is the most that there can be. */
SD_API int64_t sd_model_steps(const sd_model *model);
/* On which side of a wall along x or y the disks are at the start: +1, -1; 0 where the wall surrounds them or
 * moves along itself, or is none, and along a periodic direction. The middle of the free disks in play decides, that of the
 * region where there are none. */
SD_API int sd_model_side(const sd_model *model, uint32_t wall_body, int coordinate);
/* Two motions of one phase, the first a load or a servo, on the same coordinate of one wall; false: none. */
SD_API bool sd_model_clash(const sd_model *model, size_t phase, size_t motion[2]);
/* The least of 2 pi/omega over pairs of touching materials: normal spring, tangential spring with rotation, per disk.
 * Writes which disk it is (may be NULL). */
SD_API double sd_model_shortest_period(const sd_model *model, uint32_t *disk);

/* The time step from which on the model's integrator blows up when a disk is held between two others (physics.md 5), and
 * what sets it; HUGE_VAL: no disk is free to move. In a packing the limit is up to three times shorter. */
typedef enum sd_bound {
  SD_BOUND_NORMAL,
  SD_BOUND_TANGENTIAL,
  SD_BOUND_VISCOSITY,
  SD_BOUND_FIELD
} sd_bound;
typedef struct sd_step_limit {
  double dt;
  uint32_t disk;
  sd_bound bound;
} sd_step_limit;
SD_API sd_step_limit sd_model_step_limit(const sd_model *model);

/* Time after which the compression of a phase comes to its packing fraction, at its largest rate; NAN: not known. */
SD_API double sd_model_compress_time(const sd_model *model, size_t phase);

/* Warns of what a finished model may say and its author seldom means: time step, friction without a spring, goals out of
 * reach, overlaps at the start and the like. */
SD_API void sd_model_advise(const sd_model *model, sd_messages *messages);

#ifdef __cplusplus
}
#endif

#endif

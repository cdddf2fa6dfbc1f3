/* model.h: what the deck says, const after loading.
 *
 * A model is filled by the deck loader (or by hand), then closed with sd_model_finish, which checks it
 * and derives the tables that the engine reads. Units are whatever consistent set the deck uses; angles
 * are radians, counter-clockwise positive.
 *
 * Bodies are numbered once and for all: disk i has body number i (its place in the deck, its permanent
 * id), wall w has body number n_disks + w.
 */
#ifndef SLIPDISK_MODEL_H
#define SLIPDISK_MODEL_H

#include <stdbool.h>
#include <stdint.h>

#include "slipdisk/contact.h"
#include "slipdisk/status.h"

enum { SD_X = 0, SD_Y = 1, SD_THETA = 2, SD_COORDINATES = 3 };

typedef enum sd_integrator { SD_GEAR5, SD_VERLET } sd_integrator;
/* Tangential force on the centres: the paper's tau, or tau (R_a+R_b)/r which derives from the tangential energy. */
typedef enum sd_variant { SD_PAPER, SD_CONSERVATIVE } sd_variant;

/* Constants of the contact law for one pair of materials (eq. 2, tau, 36). */
/* F_el of the overlap; model/normal_laws.h. */
typedef enum sd_normal_law { SD_NORMAL_LINEAR, SD_NORMAL_HERTZ, SD_NORMAL_LAWS } sd_normal_law;

typedef struct sd_contact_law {
  double k_n;     /* normal stiffness > 0, force/length; Hertz: force/length^(3/2) */
  double k_t;     /* tangential stiffness, force/length, >= 0 */
  double gamma_n; /* normal viscosity, force time/length, >= 0 */
  double mu;      /* Amonton's coefficient, >= 0 */
  sd_normal_law normal;
  double restitution; /* Hertz: damping by a coefficient of restitution < 1, besides gamma_n; 0 or 1: none */
} sd_contact_law;

typedef struct sd_material {
  char *name;
} sd_material;

typedef struct sd_disk {
  char *name;                   /* may be NULL */
  double position[3];           /* x, y, theta at the start */
  double velocity[3];           /* vx, vy, omega */
  double radius, mass, inertia; /* inertia 0 means m R^2/2 */
  double force[3];              /* constant body force and torque, gravity not included */
  int material;                 /* index into materials */
  int group;                    /* index into groups, -1: none */
  bool locked[3];               /* this coordinate never changes, whatever pushes (velocity must be 0) */
  bool driven;  /* all three coordinates are prescribed: fixed, or by the motions that name it */
  bool waiting; /* out of play until its rain releases it; position is then where it waits */
} sd_disk;

typedef enum sd_wall_kind { SD_WALL_LINE, SD_WALL_SEGMENT, SD_WALL_POLYLINE, SD_WALL_CIRCLE } sd_wall_kind;

/* A wall is a body with a pose (pivot, angle) and a shape given in space at the start.
 * Line: points[0] and points[1] lie on it. Segment: its ends. Polyline: its vertices, closed or not.
 * Circle: the pivot is its centre. Both sides of a line or segment push. */
typedef struct sd_wall {
  char *name;
  sd_wall_kind kind;
  int material;
  double pivot[2]; /* the point about which it turns, and whose x, y a motion moves */
  size_t n_points;
  double (*points)[2]; /* absolute coordinates at the start */
  bool closed;         /* polyline: the last vertex is joined to the first */
  double radius;       /* circle: > 0 */
  bool inside;         /* circle: disks live inside (a drum) */
} sd_wall;

typedef enum sd_motion_kind {
  SD_MOTION_VELOCITY,  /* u = v t */
  SD_MOTION_HARMONIC,  /* u = A sin(w t + phi), eq. 20 */
  SD_MOTION_PARABOLIC, /* eq. 21 with w t + phi for w t */
  SD_MOTION_RANDOM,    /* eq. 52 */
  SD_MOTION_TABLE,     /* natural cubic spline through a table */
  SD_MOTION_LOAD,      /* a wall, x or y: free along the coordinate, of mass `mass`, under `force` */
  SD_MOTION_SERVO,     /* a wall, x or y: moves at most at `velocity` until the disks feel `force` from it */
  SD_MOTION_SQUARE,    /* rests at -A and A in turn; changes sides in `rise` pi/w */
  SD_MOTION_TRIANGLE,  /* to and fro between -A and A at constant speed */
  SD_MOTION_KINDS
} sd_motion_kind;

/* One prescribed signal u(t), added to one coordinate of every body it names; t counts from the moment
 * the motion is switched on. Several motions on the same coordinate add up. */
typedef struct sd_motion {
  char *name;
  sd_motion_kind kind;
  int coordinate; /* SD_X, SD_Y, SD_THETA */
  size_t n_bodies;
  uint32_t *bodies;   /* body numbers */
  double amplitude;   /* waves: A; random: rms displacement; table: factor */
  double omega;       /* rad/time: w */
  double phase;       /* rad: phi */
  double rise;        /* square: 0 < rise <= 1 */
  double velocity;    /* constant velocity: v; servo: largest speed */
  double mass;        /* load: of the wall, > 0 */
  double force;       /* load: on the wall, its weight included; servo: on the disks; along the coordinate */
  double pressure;    /* servo: force/length on the disks, along the coordinate; 0: `force` counts */
  double length;      /* servo: of the wall at the start, on which the pressure acts */
  uint32_t beside[2]; /* servo: walls at its lower and upper end that the length follows; 0: none */
  double damping;     /* random: c */
  int64_t interval;   /* random: steps between draws, >= 1 (h = interval dt) */
  double ramp;        /* time over which the motion is faded in, 0: at once */
  uint32_t stream;    /* random: stream number, unique per independent signal */
  size_t n_table;
  double *table_time, *table_value; /* table: time increasing; held constant beyond its ends ... */
  bool periodic;                    /* ... or repeated: value[0] == value[n-1] */
} sd_motion;

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

typedef struct sd_phase {
  char *name;
  int64_t steps;          /* >= 1; the most, when it may settle before */
  bool *active;           /* [n_motions] */
  bool measure;           /* statistics are gathered in this phase */
  int64_t series_every;   /* steps between rows of the time series, 0: none */
  int64_t frames_every;   /* steps between stored frames of all bodies, 0: none */
  int64_t contacts_every; /* steps between stored contact tables, 0: none */
  sd_settle settle;
  bool relax; /* velocities are steered towards equilibrium (FIRE) */
  sd_compress compress;
} sd_phase;

typedef enum sd_container_kind {
  SD_CONTAINER_NONE,
  SD_CONTAINER_BOX,
  SD_CONTAINER_CHANNEL,
  SD_CONTAINER_BED,
  SD_CONTAINER_HOPPER,
  SD_CONTAINER_DRUM,
  SD_CONTAINER_PERIODIC
} sd_container_kind;

typedef enum sd_packing_kind {
  SD_PACKING_TRIANGULAR,
  SD_PACKING_SQUARE,
  SD_PACKING_RANDOM,
  SD_PACKING_FRONT,
  SD_PACKING_RAIN
} sd_packing_kind;

typedef enum sd_size_kind {
  SD_SIZES_MONO,
  SD_SIZES_LIST,
  SD_SIZES_UNIFORM,
  SD_SIZES_GAUSSIAN,
  SD_SIZES_LOGNORMAL,
  SD_SIZES_POWERLAW
} sd_size_kind;

/* Disks first ... first + count - 1 wait, and fall in batches, lowest numbers first. Batch k is released
 * k * interval steps after the start: rows of disks, from `lower` to `upper` in x, the lowest row `gap` above
 * the highest disk that is in play there. */
typedef struct sd_rain {
  size_t first, count, batch; /* disks, disks in a batch */
  int64_t interval;           /* steps */
  double lower, upper;        /* x */
  double floor;               /* y below which no batch begins */
  double gap, speed;
} sd_rain;

typedef enum sd_outside { SD_OUTSIDE_REPORT, SD_OUTSIDE_STOP, SD_OUTSIDE_REMOVE } sd_outside;

/* A rectangle in which the centres of the free disks belong; infinite where there is no limit. */
typedef struct sd_bounds {
  bool given; /* by the deck or its container; else nothing is looked at */
  double lower[2], upper[2];
  sd_outside outside;
} sd_bounds;

/* Memory of a contact with which a run begins (columns contact_* of state.h). */
typedef struct sd_contact_memory {
  uint32_t a, b, part; /* body numbers of this model */
  int32_t slide;
  double side;
  sd_contact_record record;
} sd_contact_memory;

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

/* --- derived by sd_model_finish ------------------------------------------------------------------- */

/* A straight piece of a wall in the wall's own frame (origin at the pivot, angle 0 at the start). */
typedef struct sd_segment {
  uint32_t body;
  double start[2];    /* one end; for a line any point */
  double tangent[2];  /* unit vector from the start to the other end */
  double length;      /* HUGE_VAL for a line (then it also extends backwards) */
  double previous[2]; /* tangent of the piece before; -tangent at a free end: bounds the start's own region */
  bool end_cap;       /* the far end is free and pushes as a point */
  double arc;         /* arc length of the start along a polyline */
  int64_t next;       /* feature number of the piece that follows, -1: none */
} sd_segment;

/* Beyond these a finished run is in doubt (exit status 5); 0: not looked at. */
typedef struct sd_limits {
  double residual;     /* of the energy budget, over its scale */
  double open;         /* fraction of the measured time in which a watched contact is open */
  double displacement; /* of a free disk in one step, over its radius */
} sd_limits;

typedef struct sd_model {
  char *title;
  uint64_t seed;
  sd_integrator integrator;
  sd_variant variant;
  double dt;
  double skin;        /* Verlet-list skin, length; 0: chosen as the run goes */
  double max_overlap; /* a run stops when an overlap exceeds this fraction of the smaller radius */
  sd_limits limits;
  double gravity[2];         /* acceleration vector: -g (sin tilt, cos tilt) */
  double lower[2], upper[2]; /* box; only read along periodic directions */
  bool periodic[2];
  sd_container_kind container;
  double region_lower[2], region_upper[2]; /* of the container or box: what is called full; equal: none */
  sd_bounds bounds;

  size_t n_materials;
  sd_material *materials;
  sd_contact_law *laws; /* [n_materials * n_materials], symmetric; k_n = 0: pair not given */
  size_t n_groups;
  char **groups;
  size_t n_disks;
  sd_disk *disks;
  size_t n_walls;
  sd_wall *walls;
  size_t n_motions;
  sd_motion *motions;
  size_t n_phases;
  sd_phase *phases;

  size_t n_rains;
  sd_rain *rains;
  size_t n_memories; /* contacts of the packing that the run begins with, in any order */
  sd_contact_memory *memories;

  size_t n_rotations; /* disks whose mean angular velocity is measured */
  uint32_t *rotations;
  size_t n_slides;
  sd_slide_watch *slides;
  sd_until until;
  bool measure_disks;    /* means of every free disk */
  int64_t measure_every; /* steps between looks at its contacts, >= 1 */

  struct sd_deck
      *deck; /* that it was read from (sd_model_deck in deck.h), freed with it; NULL: built by hand */

  /* derived */
  size_t n_segments;
  sd_segment *segments;
  size_t n_free; /* disks that are not driven */
} sd_model;

/* An empty model with defaults (Gear 5, paper variant, open box). */
SD_API sd_model *sd_model_new(void);
SD_API void sd_model_free(sd_model *model);

/* Checks ranges and references, fills inertias, flags and derived tables; call once, after the last change.
 * A disk that is named by a motion on a coordinate keeps its other coordinates as they are: it is `driven`
 * when it is fixed or all three are prescribed or locked. Errors: SD_ERROR_USER with one message each. */
SD_API sd_status sd_model_finish(sd_model *model, sd_messages *messages);

SD_API size_t sd_model_bodies(const sd_model *model); /* n_disks + n_walls */
/* On which side of a wall along x or y the disks are at the start: +1, -1; 0 where the wall surrounds them or
 * moves along itself. The middle of the free disks in play decides, that of the region where there are none. */
SD_API int sd_model_side(const sd_model *model, uint32_t wall_body, int coordinate);
/* Two motions of one phase, the first a load or a servo, on the same coordinate of one wall; false: none. */
SD_API bool sd_model_clash(const sd_model *model, size_t phase, size_t motion[2]);
SD_API const sd_contact_law *sd_model_law(const sd_model *model, int material_a, int material_b);
/* Name for messages: the body's own, else "disk 17", "wall 3"; written into text[size]. */
SD_API const char *sd_model_body_name(const sd_model *model, uint32_t body, char *text, size_t size);
/* Of all phases; with `until` it is the most that there can be. */
SD_API int64_t sd_model_steps(const sd_model *model);

/* The least of 2 pi/omega over pairs of touching materials: normal spring, tangential spring with rotation, per disk.
 * sd_model_shortest_period writes which disk it is (may be NULL). */
SD_API double sd_model_shortest_period(const sd_model *model, uint32_t *disk);

#endif

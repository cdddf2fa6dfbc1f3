/* model.h: the struct behind slipdisk/model.h, const after sd_model_finish. Programs that use the library build it by functions. */
#ifndef MODEL_MODEL_H
#define MODEL_MODEL_H

#include "slipdisk/contact.h"
#include "slipdisk/model.h"

typedef struct sd_material {
  char *name;
} sd_material;

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

enum { SD_TILE_RADII = 16 };

/* A wall of a file whose contacts come along, and what it is here. */
typedef struct sd_tile_wall {
  bool known;              /* the model has it */
  uint32_t wall;           /* of the model */
  size_t pieces;           /* straight ones; 0: it is round */
  size_t first, own_first; /* of all pieces of walls, there and here */
  double radius, theta, surface;
  double arc; /* radius of an arc, 0: it is none; a ring has no ends */
  bool ring;
} sd_tile_wall;

/* The last disks of a model, where each part of them can be had by itself: the last packing, in slabs side by side along x, tile after
 * tile (pack/tiles.h), or a large file, in rows (io/deck/deck_parts.c). */
typedef struct sd_tiles {
  size_t n;            /* 0: there are none */
  size_t first, count; /* disks */
  bool away;           /* each rank has some of them (rows.h) */
  bool of_file;
  size_t entry; /* of the deck's list of packings, or of files */
  int64_t inputs,
      contact_inputs;  /* of a file: sums of what it says of disks and contacts, in any order */
  size_t n_contacts;   /* of a file: that come along */
  size_t n_walls;      /* where it is away, and contacts come along */
  bool forces_carried; /* forces of those contacts hold at step 0 */
  sd_tile_wall *walls;
  sd_packing_kind kind;
  double lower[2], upper[2], spacing,
      jitter;           /* rain: where its disks wait, `spacing` inside of the edges in y */
  double mass, density; /* one is 0 */
  int material, group;
  sd_size_kind sizes; /* the rest as in sizes.h */
  double radius, deviation, exponent, least, most;
  size_t n_radii;
  double radii[SD_TILE_RADII], weights[SD_TILE_RADII];
} sd_tiles;

/* A rectangle in which the centres of the free disks belong; infinite where there is no limit. */
typedef struct sd_bounds {
  bool given; /* by the deck or its container; else nothing is looked at */
  double lower[2], upper[2];
  sd_outside outside;
} sd_bounds;

enum { SD_DERIVATIVES = 9 };

/* Memory of a contact with which a run begins (columns contact_* of state.h). */
typedef struct sd_contact_memory {
  uint32_t a, b, part; /* body numbers of this model */
  int16_t slide;
  int16_t force_carried; /* 1: same law as in the run before, whose force holds at step 0 */
  double side;
  sd_contact_record record;
} sd_contact_memory;

/* Disks that one rank has (rows.h). */
typedef struct sd_rows {
  size_t n;
  sd_disk *disk;
  uint32_t *number; /* disks of the model */
  double *shift;    /* of a file whose contacts come along (deck_result_shift); else NULL */
  double (*derivatives)[SD_DERIVATIVES]; /* NULL: none */
  size_t n_memories;
  sd_contact_memory *memories; /* contacts of the model that this rank begins with */
  size_t n_contacts;
  sd_contact_memory *contacts; /* of the file that is away, as it has them */
} sd_rows;

/* --- derived by sd_model_finish ------------------------------------------------------------------- */

/* Pieces of walls: straight ones, parts of a circle, and the ends of an arc. */
typedef enum sd_piece {
  SD_PIECE_STRAIGHT,
  SD_PIECE_CURVE,
  SD_PIECE_FIRST_END,
  SD_PIECE_LAST_END
} sd_piece;

/* A piece of a wall in the wall's own frame (origin at the pivot, angle 0 at the start). */
typedef struct sd_segment {
  uint32_t body;
  sd_piece piece;
  double start[2];   /* one end; for a line any point; of an arc: the centre of the circle */
  double tangent[2]; /* unit vector from the start to the other end */
  double length;     /* HUGE_VAL for a line (then it also extends backwards) */
  double previous
      [2]; /* tangent of the piece before; -tangent at a free end: bounds the start's own region */
  bool end_cap;  /* the far end is free and pushes as a point */
  double arc;    /* arc length of the start along a polyline */
  int64_t next;  /* feature number of the piece that follows, -1: none */
  double radius; /* of an arc; its directions from the centre: of the ends, and between them */
  double first[2], last[2], middle[2];
  bool wide; /* an arc of more than half a turn */
  /* of its start and end: number of the vertex, which pieces that meet there share, 0: none; ends of other walls are there */
  uint32_t vertex[2];
  bool meets[2];
  /* In a periodic box: directions in which it has images; its middle, from the start; how many periods away the piece that follows
   * starts, where the wall goes on in its own image. */
  bool image[2];
  double center[2];
  int cells[2];
} sd_segment;

/* Beyond these a finished run is in doubt (exit status 5); 0: not looked at. */
typedef struct sd_limits {
  double residual;     /* of the energy budget, over its scale */
  double open;         /* fraction of the measured time in which a watched contact is open */
  double displacement; /* of a free disk in one step, over its radius */
  bool unstable_step;  /* dt may be beyond the limit of stability (sd_model_step_limit) */
} sd_limits;

struct sd_model {
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
  double region_lower[2],
      region_upper[2]; /* of the container or box: what is called full; equal: none */
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
  size_t n_clumps;
  sd_clump *clumps;
  size_t n_motions;
  sd_motion *motions;
  size_t n_fields;
  sd_body_force *fields;
  size_t n_phases;
  sd_phase *phases;

  sd_tiles tiles;
  size_t n_rains;
  sd_rain *rains;
  size_t n_memories; /* contacts of the packing that the run begins with, in any order */
  sd_contact_memory *memories;
  size_t all_memories;  /* with those that are away; derived */
  bool forces_carried;  /* the forces of some contacts hold at step 0 */
  size_t n_derivatives; /* disks; 0: the file has none, or not for Gear */
  /* Gear's columns 3 to 5 of x, of y, of theta (state.h), from the file of each disk */
  double (*derivatives)[SD_DERIVATIVES];

  size_t n_rotations; /* disks whose mean angular velocity is measured */
  uint32_t *rotations;
  size_t n_slides;
  sd_slide_watch *slides;
  sd_until until;
  size_t n_contact_disks; /* disks whose contacts are a series */
  uint32_t *contact_disks;
  bool measure_walls, measure_groups; /* series of the forces on each of them */
  bool measure_box, measure_stress;   /* series of width and height of the region, of its stress */
  bool measure_disks;                 /* means of every free disk */
  bool measure_configurations; /* torque, forces and duration of the configurations in slides */
  int64_t measure_every;       /* steps between looks at its contacts, >= 1 */

  struct sd_deck *
      deck; /* that it was read from (sd_model_deck in deck.h), freed with it; NULL: built by hand */

  sd_messages *mistakes; /* of the calls that built it, for sd_model_finish; NULL: none */

  /* A run over ranks uses these (rows.h). */
  const struct comm *comm; /* of the ranks that read the deck now; NULL: one alone */
  sd_rows *mine;           /* that this rank alone has, until its run begins; NULL: none */
  bool parted;             /* by rows_part; then: */
  size_t n_known;          /* disks whose rows are here, ascending */
  uint32_t *known;
  sd_step_limit limit;  /* of the time step, */
  sd_messages *advised; /* warnings, */
  int64_t inputs;       /* and the sum over what files say (provenance_inputs), of all disks */

  /* derived */
  bool finished;
  size_t n_segments;
  sd_segment *segments;
  size_t n_free;          /* disks that are not driven */
  double mean_radius;     /* harmonic mean of all disks */
  double largest_radius;  /* of a free disk */
  double smallest_radius; /* of a free disk; infinite without any */
  double shortest_period; /* as sd_model_shortest_period; where there are servos */
  uint32_t *
      clump_disks; /* of all clumps, one after the other, by number: what sd_clump.disks points to */
  double (*clump_offsets)[2]; /* of each of these from its clump's centre, at the start */
};

/* Bodies that a motion can name: disks, walls, clumps. */
static inline size_t model_movables(const sd_model *m) {
  return m->n_disks + m->n_walls + m->n_clumps;
}

/* "motion "shake"", or "motion 3" of one without a name; in text[size]. */
const char *model_motion_name(const sd_model *model, size_t number, char *text, size_t size);

/* Completes a model that was built by functions: default phase, numbers of walls, random streams. */
void model_complete(sd_model *model);
sd_status model_tell_mistakes(sd_model *model, sd_messages *messages);
void model_copy_mistakes(sd_model *to, const sd_model *from);

#endif

/* model.h: the struct behind slipdisk/model.h. A model is const once sd_model_finish has
 * succeeded. The deck reader fills the members directly; programs that use the library call the
 * sd_model_... functions. */
#ifndef MODEL_MODEL_H
#define MODEL_MODEL_H

#include "base/message.h"
#include "model/law_features.h"
#include "model/segments.h"
#include "model/start.h"
#include "slipdisk/contact.h"
#include "slipdisk/model.h"

typedef struct sd_material {
  char *name;
} sd_material;

/* A rain releases the disks first ... first + count - 1 into the system in batches, lowest
 * numbers first; until its release a disk waits and touches nothing. Batch k is released k *
 * interval steps after the start: its disks are placed in rows between x = `lower` and `upper`,
 * the lowest row `gap` above the highest disk in that range that does not wait. */
typedef struct sd_rain {
  /* number of the first disk; number of disks; number of disks per batch */
  size_t first, count, batch;
  int64_t interval;    /* number of steps between batches */
  double lower, upper; /* smallest and largest x at which disks are placed */
  double floor;        /* smallest y at which the lowest row is placed */
  /* height of the lowest row above the disks, downward speed at release */
  double gap, speed;
} sd_rain;

/* A wall of the result file from which contacts are restored, and the wall of the model that
 * corresponds to it. */
typedef struct sd_tile_wall {
  bool known;    /* true if the model has a wall that corresponds to it */
  uint32_t wall; /* number of the wall in the model */
  size_t pieces; /* number of segments of the wall; 0: a circle */
  /* Index of the wall's first segment among all wall segments of the file, and of the model. */
  size_t first, own_first;
  /* radius, angle and surface displacement of the wall in the file */
  double radius, theta, surface;
  double arc; /* radius if the wall is an arc, else 0 */
  bool ring;  /* True for an arc that is a full circle and has no ends. */
} sd_tile_wall;

/* The last disks of a model, if they can be generated or read in independent parts: the last
 * packing, in tiles, which are slabs side by side along x (pack/tiles.h), or the rows of a large
 * file (io/deck/deck_parts.c). */
typedef struct sd_tiles {
  size_t n;            /* number of parts; 0: no disks are generated or read in parts */
  size_t first, count; /* number of the first disk that comes in parts; number of such disks */
  /* True if the disks that come in parts are distributed over ranks: each is stored on one rank
   * only (rows.h). */
  bool away;
  bool of_file; /* True: the parts are rows of a file; false: tiles of a packing. */
  /* index of the packing or file in the list `packings` or `disk_files` of the deck */
  size_t entry;
  /* File: order-independent checksum of its disks, and of its contacts. */
  int64_t inputs, contact_inputs;
  size_t n_contacts; /* file: number of contacts that it contains */
  /* Number of walls of the file, if its disks are distributed over ranks and its contacts are
   * restored, else 0. */
  size_t n_walls;
  bool forces_carried; /* true: forces stored with the file's contacts are still valid at step 0 */
  sd_tile_wall *walls; /* [n_walls] the walls of the file from which contacts are restored */
  /* Rectangle that the packing fills, x and y, or in which the disks of a rain wait; file:
   * rectangle around its disks. */
  double lower[2], upper[2];
  double most;  /* largest possible radius */
  int material; /* file: index of the material of its disks */
} sd_tiles;

/* Rectangle in which the centres of the free disks must stay; infinite where there is no limit. */
typedef struct sd_bounds {
  /* True if the deck, its container or the program has set this rectangle; false: positions are
   * not checked. */
  bool given;
  double lower[2], upper[2];
  sd_outside outside; /* action on a disk that leaves the rectangle */
} sd_bounds;

/* Disks and contacts that are stored on this rank only (rows.h). */
typedef struct sd_rows {
  size_t n;
  sd_disk *disk;    /* [n] disks that are stored on this rank only */
  uint32_t *number; /* [n] numbers in the model of the disks in `disk` */
  /* [n] Angle (rad) to be added to theta in the file to get theta in this run, for restored
   * contacts (deck_result_shift); NULL: no contacts. */
  double *shift;
  /* [n] higher time derivatives of each disk's coordinates, for Gear's integrator; NULL: none */
  double (*derivatives)[SD_DERIVATIVES];
  size_t n_memories;
  sd_contact_memory *memories; /* [n_memories] contacts that are closed when the run starts */
  size_t n_contacts;
  /* [n_contacts] contacts of a file whose disks are distributed, with the body numbers of the
   * file */
  sd_contact_memory *contacts;
} sd_rows;

/* --- derived by sd_model_finish --------------------------------------------------------------- */

/* Column of the series in a sum, times a factor. The columns are those of energy_observables,
 * followed by those of series_observables (measure/observable.h), counted from 0, whether the model
 * has them or not. */
typedef struct sd_average_term {
  uint32_t column, element; /* number of the column; index of the watched disk, wall, ... in it */
  bool rate;                /* true: the change of the column per time; false: its value */
  double factor;
} sd_average_term;

enum { SD_AVERAGE_TERMS = 8 }; /* largest number of columns in a sum */

typedef struct sd_average_sum {
  double constant; /* added to the terms */
  size_t n;        /* number of terms */
  sd_average_term term[SD_AVERAGE_TERMS];
} sd_average_sum;

/* An average of the series, the mean of a sum of columns over the mean of another. */
typedef struct sd_average_watch {
  char *name, *text;    /* its name, and its expression as the deck has it */
  sd_average_sum of[2]; /* numerator and denominator; the latter is 1 unless the deck has one */
} sd_average_watch;

/* Limits beyond which the result of a run is marked doubtful (exit status 5); 0: not checked. */
typedef struct sd_limits {
  double residual;     /* residual of the energy budget divided by sd_energy.scale */
  double open;         /* largest fraction of the measured time that a watched contact is open */
  double displacement; /* largest displacement of a body in one step, divided by its radius */
  bool unstable_step;  /* True: allows dt above the stability limit (sd_model_step_limit). */
} sd_limits;

struct sd_model {
  char *title;
  uint64_t seed;
  sd_integrator integrator;
  sd_variant variant;
  double dt;
  double skin; /* margin of the Verlet lists, length; 0: chosen at run time */
  /* largest overlap divided by the smaller radius, beyond which the run stops; 0: none */
  double max_overlap;
  sd_limits limits;
  double gravity[2];         /* acceleration, -g (sin tilt, cos tilt) */
  double lower[2], upper[2]; /* edges of the box; valid along periodic directions only */
  bool periodic[2];
  int container; /* its kind (model/containers.h); 0: none */
  /* Rectangle of the container or box; its area is that in the packing fraction. Equal edges:
   * none. */
  double region_lower[2], region_upper[2];
  sd_bounds bounds;

  size_t n_materials;
  sd_material *materials;
  /* [n_materials * n_materials] contact law of each pair of materials, symmetric; k_n = 0: no
   * law given for the pair. */
  sd_contact_law *laws;
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
  size_t n_memories; /* number of `memories`, contacts that are closed when the run starts */
  sd_contact_memory *memories;
  /* Number of contacts that are closed when the run starts, on all ranks, including those in
   * `mine`; derived. */
  size_t all_memories;
  bool forces_carried; /* true if the stored forces of some contacts are valid at step 0 */
  /* Number of rows of `derivatives`: n_disks, or 0 if no file gives them or the integrator is
   * not Gear. */
  size_t n_derivatives;
  /* Higher derivatives of x, y, theta in Gear's form (columns x3 ... theta5 of state.h), read
   * from the file that gives the disk. */
  double (*derivatives)[SD_DERIVATIVES];

  size_t n_rotations; /* number of disks whose mean angular velocity is measured */
  uint32_t *rotations;
  size_t n_slides;
  sd_slide_watch *slides;
  sd_until until;
  size_t n_averages; /* number of averages of the series that are measured */
  sd_average_watch *averages;
  size_t n_contact_disks; /* number of disks whose contact forces are recorded as a time series */
  uint32_t *contact_disks;
  /* True: record time series of the forces on each wall, and on each group of disks. */
  bool measure_walls, measure_groups;
  /* True: record time series of the region's width and height, its stress, its rattlers. */
  bool measure_box, measure_stress, measure_rattlers, measure_fragments;
  bool measure_disks; /* true: compute time averages for every free disk */
  /* True: record torque, normal forces and duration of each sliding configuration (combination
   * of the contact states) of the pairs of contacts in `slides`. */
  bool measure_configurations;
  /* number of steps between samples of the contacts for measure_disks, >= 1 */
  int64_t measure_every;

  /* Deck that the model was read from (sd_model_deck in deck.h); owned by the model; NULL: built
   * by functions. */
  struct sd_deck *deck;

  /* Errors of the functions that built the model, reported by sd_model_finish; owned; NULL:
   * none. */
  sd_messages *mistakes;

  /* The following members belong to runs on several ranks (rows.h). */
  /* Communicator of the ranks that read the deck together, not owned; NULL: one process. */
  const struct comm *comm;
  /* Disks and contacts stored on this rank only, until its run begins; owned; NULL: none. */
  sd_rows *mine;
  /* True after rows_part has distributed the model over ranks: `disks` then has data only for
   * the disks listed in `known`, and `limit`, `advised` and `inputs` hold results for all disks. */
  bool parted;
  size_t n_known; /* number of disks that have data in `disks` */
  /* [n_known] numbers of the disks that have data in `disks`, ascending; owned */
  uint32_t *known;
  sd_step_limit limit;  /* stability limit of the time step over all disks */
  sd_messages *advised; /* warnings of sd_model_advise; owned; NULL: not collected yet */
  int64_t inputs;       /* checksum of the input files (provenance_inputs) */

  /* The following members are derived by sd_model_finish. */
  bool finished;
  size_t n_segments;
  sd_segment *segments;
  size_t n_free;          /* number of disks whose motion is not prescribed (`driven`) */
  double mean_radius;     /* harmonic mean radius of all disks */
  double largest_radius;  /* largest radius of a free disk */
  double smallest_radius; /* smallest radius of a free disk; infinite without free disks */
  /* shortest contact period (sd_model_shortest_period) if there are servos, else 0 */
  double shortest_period;
  /* Disk numbers of all clumps, one clump after the other; sd_clump.disks points into this
   * array. */
  uint32_t *clump_disks;
  /* Offset of each disk in clump_disks from its clump's centre of mass, at the start. */
  double (*clump_offsets)[2];
};

/* Number of bodies that a motion can name: disks, walls and clumps. */
static inline size_t model_movables(const sd_model *m) {
  return m->n_disks + m->n_walls + m->n_clumps;
}

/* True if the disk can be held and released. */
static inline bool disk_holds(const sd_disk *d) {
  return d->holds[0] || d->holds[1] || d->holds[2];
}
/* True if a phase of the model holds or releases disks. */
static inline bool model_holds(const sd_model *m) {
  for (size_t k = 0; k < m->n_phases; k++)
    if (m->phases[k].n_hold + m->phases[k].n_release > 0) return true;
  return false;
}

/* Writes the name of a motion for messages to text[size]: `motion "shake"`, or `motion 3` if it
 * has no name. Returns text. */
const char *model_motion_name(const sd_model *model, size_t number, char *text, size_t size);
/* Return the subject (base/message.h) of a message about a body, a wall or a motion, by number. */
subject about_body(const sd_model *model, size_t body);
subject about_wall(const sd_model *model, size_t wall);
subject about_motion(const sd_model *model, size_t motion);

/* Completes a model that was built by functions: adds a phase if there is none, turns SD_WALL(w)
 * and SD_CLUMP(k) into body numbers, and gives each random motion the number of a random
 * stream. */
void model_complete(sd_model *model);
/* Reports the errors that the building functions have collected, and returns their status;
 * SD_OK: none. */
sd_status model_tell_mistakes(sd_model *model, sd_messages *messages);
/* Adds the collected errors of one model to those of another. */
void model_copy_mistakes(sd_model *to, const sd_model *from);

/* --- checks of a complete model and its derived tables, after which the model is const -------- */

/* Does what sd_model_finish does, checks and derived tables, for a model whose warnings were
 * reported before: it reports errors only. */
sd_status model_finish_again(sd_model *model, sd_messages *messages);
/* model_check_constants: checks a finished model in which only constants of laws and motions were
 * changed; before: the laws until then. model_derive_period: renews what follows from them. */
void model_derive_period(sd_model *model);
sd_status model_check_constants(sd_model *model, const sd_contact_law *before,
                                sd_messages *messages);

/* Collective. Distributes a finished model over ranks. First it stores the results that need all
 * disks: warnings, and the limit of the time step. Then each rank keeps the disks that all ranks
 * must know, and its own part of the others (rows_part); with fewer than `few` free disks rank 0
 * has them all. SD_ERROR_IO: out of memory. */
sd_status model_part(sd_model *m, size_t few);

/* Checks motions of the kinds load and servo: their ranges, the bodies that they move, and that
 * no other motion moves the same coordinate. Warns of a wall that is pushed away from all disks. */
void loads_check(const sd_model *model, sd_messages *messages);
/* Warns if the time step is too long for a wall that moves as a load: the wall oscillates on the
 * disks that carry it, at most as many as fit side by side along it. The contact laws and n_free
 * must be known. */
void loads_check_steps(const sd_model *model, sd_messages *messages);

/* A model serialized to bytes, from which the same program restores it; used for clones
 * and saved simulations. */

/* Returns the model as *size bytes, followed by a 32-bit zero; the caller frees them. NULL: out
 * of memory. Equal models give equal bytes. The model must not be distributed over ranks. */
void *model_serialize(const sd_model *model, size_t *size);
/* Restores a model in *out, finished if the original was; the caller frees it with
 * sd_model_free. SD_ERROR_USER: the bytes are those of another version; SD_ERROR_IO: damaged, or
 * out of memory; *out is then NULL. */
sd_status image_read(const void *bytes, size_t size, sd_model **out, sd_messages *messages);

/* --- circular arcs ---------------------------------------------------------------------------- */

/* Number of points that trace an arc, evenly spaced from end to end. ARC_RING: largest angle of
 * an arc, 2 pi plus a margin for rounding. */
enum { ARC_POINTS = 129 };
#define ARC_RING 6.283185307179588

/* True if the arc is a full circle, which has no ends. */
bool arc_is_ring(const sd_wall *arc);
/* Fills in arc->points with ARC_POINTS points that trace the arc. */
void arc_trace(sd_wall *arc);
/* Makes the three segments of an arc: first end, curve, last end, or the three thirds of a full
 * circle. number: index of the first of them among the model's segments. */
void arc_segments(const sd_wall *arc, uint32_t body, sd_segment piece[3], int64_t number);
/* Distance from the point `at` to the arc, >= 0. */
double arc_distance(const sd_wall *arc, const double at[2]);

/* Returns the flags LAW_... (law_features.h) of the parts that any contact law of the model has. */
unsigned laws_features(const sd_model *model);
/* Orders of numbers, and of pairs of numbers, for qsort and bsearch; those of sd_bonding are
 * sorted so in a finished model. */
int model_by_number(const void *one, const void *two);
int model_by_pair(const void *one, const void *two);
/* True if no pair of materials has friction: k_t > 0 and mu > 0. */
bool laws_frictionless(const sd_model *model);

#endif

/* work.h: data that can be recomputed from model and state.
 *
 * Rule: discarding the work and rebuilding it must not change any bit of the results. During a run
 * the records of contacts are kept with the candidate pairs (struct pairs); contacts_store copies
 * the records of closed contacts to the state's columns, contacts_load copies them back.
 */
#ifndef PHYSICS_WORK_H
#define PHYSICS_WORK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/comm.h"
#include "base/team.h"
#include "slipdisk/contact.h"
#include "model/law_constants.h"
#include "model/model.h"
#include "model/state.h"

/* Contact constants of one pair of materials, in the form that the contact law uses. */
#define LAW_MEMBER(features, name, value) double name;
typedef struct law_row {
  double k_n, k_t, gamma_n, cap; /* cap: mu/k_t; 0 without k_t (frictionless) */
  double normal, tsuji;          /* number of the normal law; factor law_tsuji of its damping */
  LAW_CONSTANTS(LAW_MEMBER)      /* only read if laws are general (LAW_GENERAL) */
} law_row;
#undef LAW_MEMBER
/* Number of members of law_row from `pulls` on; LAW_PLACE: index of a member among these. */
enum { LAW_MORE = (sizeof(law_row) - offsetof(law_row, pulls)) / sizeof(double) };
#define LAW_PLACE(member) ((offsetof(law_row, member) - offsetof(law_row, pulls)) / sizeof(double))

/* Block of eight pairs. Each column of doubles is one cache line, so a pass over pairs reads one
 * stream of memory. The record (slipdisk/contact.h) is saved in checkpoints, and carried over when
 * the list is rebuilt; the other columns are written by the functions named beside them. */
enum { PAIR_BLOCK = 8 };
#define PAIR_COLUMN(name, unit, meaning) double name[PAIR_BLOCK];
typedef struct pair_block {
  /* Offsets of the bodies in work.packed, in doubles; pairs_list. */
  _Alignas(64) int32_t packed_a[PAIR_BLOCK], packed_b[PAIR_BLOCK];
  /* offsets in sums.row of their forces; pairs_list */
  int32_t sum_a[PAIR_BLOCK], sum_b[PAIR_BLOCK];
  union {
    struct {
      SD_CONTACT_RECORD(PAIR_COLUMN)
    };
    double record[SD_CONTACT_COLUMNS][PAIR_BLOCK];
  };
  int32_t law[PAIR_BLOCK]; /* index in work.laws; neighbours_build */
} pair_block;

/* Further columns of the record of the same eight pairs, for models with general laws. */
typedef struct pair_more {
  union {
    struct {
      _Alignas(64) SD_CONTACT_MORE(PAIR_COLUMN)
    };
    double record[SD_CONTACT_EXTRA][PAIR_BLOCK];
  };
} pair_more;
#undef PAIR_COLUMN

/* Value of pair k in a column of pair_block (PAIR) or pair_more (MORE). */
#define PAIR(pairs, k, column)                                                                     \
  ((pairs)->block[(size_t)(k) / PAIR_BLOCK].column[(size_t)(k) % PAIR_BLOCK])
#define MORE(pairs, k, column)                                                                     \
  ((pairs)->more[(size_t)(k) / PAIR_BLOCK].column[(size_t)(k) % PAIR_BLOCK])

/* Flags of the contacts of a block, one bit each (for a wall segment, bit 0 only): closed at the
 * last evaluation; sliding there with positive or negative torque on both disks. Like the record,
 * they are carried over when the list is rebuilt. */
typedef struct pair_flags {
  uint8_t closed, slides_positive, slides_negative;
} pair_flags;

/* Candidate pairs: round pairs in [0, n_round), pairs with ghosts (halo.h) in [first_ghost,
 * end_ghost), wall segments in [first_segment, count). Each of these lists is ordered by (slot of
 * a, slot of b, segment), and begins with a whole block. Padding after each list has a = b = -1 and
 * is never in contact. */
typedef struct pairs {
  size_t count, n_round, first_ghost, end_ghost, first_segment, capacity;
  int32_t *a, *b;    /* slots of the two bodies; neighbours_build */
  int32_t *part;     /* index of the wall segment; neighbours_build */
  double *side;      /* nearest_point.side of closed contacts with segments; else 0 */
  pair_block *block; /* columns of the pairs, PAIR_BLOCK of them in each */
  pair_more *more;   /* columns that only general laws use; NULL: there are none */
  bool wants_more;   /* true if the laws need `more` */
  pair_flags *flags; /* one per block of round pairs, then one per wall segment */
} pairs;

/* Contacts of each body, in the order of the pairs; neighbours_build. */
typedef struct incidence {
  size_t *start;   /* [n_bodies + 1] first entry of each body */
  uint32_t *entry; /* 2 * pair, + 1 if the body is b of this pair */
  size_t capacity;
} incidence;

/* Force sums of the bodies, by contacts. A row has the force (x, y), the torque (over the radius
 * for round bodies; for straight walls the torque itself, about the pivot), and a fourth number: on
 * disks the couple of rolling resistance, a torque of opposite sign on the two (for walls it is
 * part of the torque); on straight walls the force along the surface.
 *
 * Pairs add to the row of a body one after the other. If the pairs of a body are not all evaluated
 * by one thread, or if each force is needed (prescribed bodies), each contact has a row of its own,
 * and `gather` adds these rows up in the order of the pairs. So the order of summation is always
 * the same. */
enum { SUM_X, SUM_TURN, SUM_Y, SUM_COUPLE, SUM_ROW, SUM_SURFACE = SUM_COUPLE };
/* add4 in base/lane.h adds numbers at odd indices with the same sign to both bodies */
_Static_assert(SUM_X % 2 == 0 && SUM_Y % 2 == 0 && SUM_TURN % 2 == 1, "add4");
typedef struct sums {
  /* [rows][SUM_ROW] rows of bodies, then one row per contact of each listed body */
  double *row;
  size_t end;       /* number of rows */
  uint32_t *listed; /* slots of the bodies with one row per contact, ascending */
  size_t n_listed;
  size_t *single; /* [n_listed + 1] first row of each listed body */
  size_t capacity, listed_capacity;
} sums;

enum { WORK_MAX_THREADS = 64 };

/* Chunks of free disks with consecutive slots; chunks.h. */
typedef struct chunks {
  size_t size, count, capacity; /* size: largest number of disks in a chunk */
  int n_threads;
  size_t *begin;      /* [count + 1] slot of the first disk of each chunk */
  uint32_t *of_disks; /* chunk of each group of CHUNK_STEP disks */
  /* [count + 1] first round pair and first wall segment pair of each chunk */
  size_t *pair, *segment;
  /* need_start: [count + 1] first entry of each chunk in `need` */
  size_t *need_start, need_capacity;
  uint32_t *need; /* chunks whose disks the pairs of each chunk read, itself included */
  size_t share[WORK_MAX_THREADS + 1]; /* first chunk of each thread */
  /* boundary_first: pairs of other threads or ranks read its disks; boundary_last: pairs of other
   * threads add forces to its disks. */
  bool *boundary_first, *boundary_last;
  bool any_boundary_first; /* true if boundary_first is true for some chunk */
  bool shares;             /* true if later chunks reuse rows of earlier ones */
  /* row of each chunk's first disk in work.packed and sums; number of these rows */
  size_t *row, rows;
  int64_t *predicted; /* step of each chunk's predicted coordinates; see step.c */
  int64_t *packed;    /* step of each chunk's packed bodies; see step.c */
} chunks;

/* Packed body: the numbers that a pass over pairs reads of a body, one cache line. Written together
 * with the pose by the predictor and by motion_pose. Free disks have a row here and in sums only
 * while pairs need it (chunks_plan_rows). PACKED_ARC: R theta. */
enum {
  PACKED_X,
  PACKED_ARC,
  PACKED_Y,
  PACKED_RADIUS,
  PACKED_VX,
  PACKED_VY,
  PACKED_INVERSE_MASS, /* 1/mass, 0 for prescribed bodies; only set with LAW_NORMAL */
  PACKED_SPIN,         /* R omega; only set with LAW_DASHPOT or LAW_ROLLING */
  PACKED_ROW = 8
};
/* across4 in base/lane.h takes differences b - a at even indices, and sums at odd ones */
_Static_assert(PACKED_X % 2 == 0 && PACKED_Y % 2 == 0 && PACKED_ARC % 2 == 1 &&
                   PACKED_RADIUS % 2 == 1,
               "across4");
_Static_assert(PACKED_VY == PACKED_VX + 1, "across2");

/* Wall segment in space: straight, an arc, or an end point of an arc; walls_pose. */
typedef struct placed_segment {
  /* Start (for an arc: centre of the circle), unit tangent, length, tangent of the segment
   * before. */
  double x, y, tx, ty, length, px, py;
  double end_x, end_y; /* start of the next segment; only if `joined` */
  double backwards;    /* least coordinate along the tangent: -HUGE_VAL for a line, else 0 */
  double arc;          /* arc length along the wall at the start, for an arc at its middle */
  /* end_cap: the far end is free and is touched as a point; joined: a segment follows; wide: an arc
   * of more than half a turn. */
  bool end_cap, joined, wide;
  bool shared, meets; /* another segment shares one of its ends; one of another wall does */
  bool image[2];      /* true along directions in which it has periodic images */
  int cells[2];       /* number of periods from (end_x, end_y) to the start of the next segment */
  double middle_x, middle_y; /* vector from (x, y) to the middle of the segment */
  double shift_x, shift_y;   /* displacement of an image from the original; 0 for the original */
  sd_piece piece;            /* straight, arc, or first or last end point of an arc */
  double c, i;               /* cosine and sine of the wall's angle; both 0: not placed yet */
  /* Only for arcs: radius, and unit vectors from the centre to the first end, last end and
   * middle. */
  double radius, fx, fy, lx, ly, mx, my;
} placed_segment;

/* Rare event, handled serially after the pass: a contact that ended (with the energy that it
 * dropped), began, turned far from its reference direction, or overlaps by more than the limit; or
 * a disk whose angle or position must be wrapped. */
typedef struct event {
  uint32_t index;  /* index of the pair, or slot of the disk */
  uint64_t at;     /* key by which events are sorted; contacts_events */
  double dropped;  /* energy left in a contact that opened, or lost in a bridge that formed */
  bool was_closed; /* true if the contact was closed before the pass */
  bool unbooked;   /* true for a contact of a packing that is open at step 0: no loss is booked */
} event;

typedef struct event_list {
  event *item;
  size_t count, capacity;
  bool failed; /* true: memory ran out, and items are missing */
} event_list;

/* Columns of one coordinate (x, y or theta) of all free disks, by slot. q: coordinate; v: its
 * velocity; qn: its n-th derivative times dt^n/n!; force: force (or torque) by contacts; constant:
 * force that does not come from contacts; inverse: inverse mass or inertia, 0 if locked or
 * prescribed. */
typedef struct columns {
  double *q, *v, *q2, *q3, *q4, *q5;
  double *force;
  const double *constant, *inverse;
} columns;

/* Clumps: rigid bodies of several free disks; system/clumps.c. */
typedef struct clumps {
  size_t count;     /* number of clumps; 0: all members below are unset */
  bool pushed;      /* true if constant forces act on single disks of a clump */
  size_t *start;    /* [count + 1] first disk of each clump in the columns from member to arm_y */
  uint32_t *member; /* slots of the disks of each clump, in the order of their body numbers */
  /* Position and angle of each disk relative to the centre, in the frame of the clump. */
  double *offset_x, *offset_y, *offset_theta;
  /* offset_x, offset_y turned to space, as of when the disks were last placed */
  double *arm_x, *arm_y;
  int32_t *of;          /* [n_free] clump of the disk in each slot; -1: none */
  double *clumped;      /* [n_free] 1 for disks in clumps, 0 for others */
  double *contact_mass; /* [n_free] mass of the disk, or of its clump; enters m_eff of contacts */
  /* [count] coefficients of non-viscous damping of the whole clump */
  double *alpha, *alpha_rotation;
  /* columns of the clumps' coordinates, like those of free disks */
  columns columns[SD_COORDINATES];
} clumps;

/* Contact of a disk a with a periodic image of body b. */
typedef struct crossing {
  double fx, fy, nx, ny; /* force on b; number of cells from the image to b, along x and y */
} crossing;

typedef struct crossing_list {
  crossing *item;
  size_t count, capacity;
  bool failed; /* true: memory ran out, and items are missing */
} crossing_list;

/* Deforming periodic box; cell.h. */
typedef struct work_cell {
  bool on;           /* true in phases in which periodic images are shifted or move */
  double speed[3];   /* rates of change of the two lengths and the offset, length/time */
  double list[3];    /* lengths and offset when the neighbour list was built */
  int64_t step;      /* step for which work has the shape of the box */
  int64_t list_step; /* step whose shape the neighbour list was built for */
  double drift[2];   /* mean velocity of disks relative to the box when the list was built */
  /* Affine map of positions from when the list was built to the end of the coming step, minus the
   * identity: xx, yy, xy. */
  double map[3];
  double shift[2]; /* displacement by `drift` in the same time */
} work_cell;

/* Data of one thread, in cache lines of its own. */
typedef struct thread_work {
  /* true: a body has moved or will move too far for the neighbour list, or its position is not a
   * number; set by the correct kernels and by motions. */
  _Alignas(64) bool stale;
  bool fast;               /* a body is beyond the displacement limit; set like `stale` */
  event_list events;       /* events of pairs, noted by the pairs kernels */
  crossing_list crossings; /* contacts across the edge of a deforming box, by the pairs kernels */
  /* bodies whose angle or position must be wrapped; by the correct kernels */
  event_list returns;
} thread_work;

typedef struct body_forces body_forces; /* defined in fields.h */
typedef struct fields fields;           /* defined in fields.h */
typedef struct motions motions;         /* defined in motion.c */
typedef struct lanes lanes;             /* defined in lanes.h */
typedef struct engine engine;
typedef struct halo halo;       /* defined in halo.h */
typedef struct kernels kernels; /* defined in kernels.h */

typedef struct work {
  /* Constants of the model in the form that the loops use; engine_new. */
  double dt, per_dt, half_dt2; /* time step, 1/dt, dt^2/2 */
  /* Limit of (speed/radius)^2 above which a disk exceeds the displacement limit; infinite: not
   * checked; speed_begin. */
  double speed_limit2;
  bool compare_motions; /* true: prescribed bodies are checked for the displacement limit, too */
  bool conservative, periodic[2]; /* conservative: false for the paper's tangential force */
  /* Periodic box; along open directions lengths are 0 and bounds infinite. */
  double lower[2], upper[2], length[2], inverse_length[2];
  double offset; /* shift of each row of periodic cells against the row below, along x */
  work_cell cell;
  law_row *laws; /* [n_materials^2] law of materials i, j in row i n_materials + j */
  bool one_law;  /* true if all rows of `laws` are the same */
  /* LAW_ bits of all laws (model.h); 0: k_n, gamma_n, k_t and mu suffice */
  unsigned features;
  bool stale;        /* true: the neighbour list must be rebuilt for the coming step; step_once */
  int64_t show_from; /* first step whose forces on free disks are stored in the state; step_begin */
  bool predict_all;  /* true: a step predicts all disks before it evaluates forces; step_begin */
  /* [n_free] inverse masses and moments of inertia; 0 for locked or prescribed coordinates. */
  double *inverse_mass_x, *inverse_mass_y, *inverse_inertia;
  double *constant_x, *constant_y, *constant_torque; /* [n_free] gravity plus constant force */
  bool nothing_constant[SD_COORDINATES]; /* true if columns[].constant is 0 for all disks */
  columns columns[SD_COORDINATES];
  clumps clumps;
  void *arena;      /* memory of the columns above, and of the poses x0, y0, theta0 */
  slot_table slots; /* slots by body number; clump k has the number (count of bodies) + k */
  const kernels *kernels;
  int n_threads;

  /* Neighbour list, and data that follow from it; neighbours_build. */
  pairs pairs, spare; /* spare: memory for the next list */
  incidence incidence;
  sums sums;
  chunks chunks;
  int32_t *row; /* [n_bodies + 1] row of each body in `packed` and sums; last: the row of padding */
  double *packed;            /* [rows][PACKED_ROW] packed bodies */
  size_t packed_capacity;    /* number of rows that `packed` has room for */
  double least_limit;        /* largest overlap that is allowed for the smallest body */
  double margin;             /* largest gap at which a contact begins or ends (cohesion) */
  double skin, moved_limit2; /* Verlet margin; squared displacement at which the list is stale */
  double list_scale;         /* state->box_scale when the list was built */
  /* [n_bodies] poses when the list was built, rescaled with the box since */
  double *x0, *y0, *theta0;
  /* [n_walls] distance from the pivot to the farthest wall point in reach of disks */
  double *reach;
  int64_t builds, built_at; /* number of list builds; step of the last one */
  double mean_radius;       /* harmonic mean radius of the disks: most pairs are of small disks */
  double surface_unit;      /* smallest power of two that is at least mean_radius */
  placed_segment *segments; /* [n_segments] wall segments in space; walls_pose */
  uint32_t *pieces;         /* indices of the segments in the list of pairs, ascending */
  size_t n_pieces;
  int64_t *watched; /* [2 n_slides] pair of each watched contact; -1: not in the list */

  motions *motions;
  body_forces *body_forces; /* NULL: the model has no force fields */
  /* stepper for small systems, holding this system only; NULL: only the general step is used */
  lanes *lanes;
  thread_work *threads; /* [n_threads] data of each thread */
  /* status of the present step; set by one thread, read by all after a wait */
  sd_status status;
  sd_messages *messages;
} work;

/* One system: model, state, and work. All code below run/ operates on this. */
struct engine {
  const sd_model *model;
  sd_state *state;
  fields *fields;   /* force fields of the calling program; NULL: none */
  halo *halo;       /* exchange of ghosts with other ranks; NULL: this process has all disks */
  const comm *comm; /* communicator of the ranks that share the disks; NULL: one process */
  /* Function that rebuilds the lists on several ranks, and their data; both NULL in one process. */
  sd_status (*renew)(engine *e, sd_messages *messages);
  struct ranks *ranks;
  pool *pool; /* threads, at most work.n_threads, not owned; NULL: one thread does all the work */
  work work;
};

/* Returns the threads that build lists; NULL below WORK_TOGETHER free disks, where one is as
 * fast. */
enum { WORK_TOGETHER = 1000 };
static inline pool *work_pool(const engine *e) {
  return e->state->n_free < WORK_TOGETHER ? NULL : e->pool;
}

#endif

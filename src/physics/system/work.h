/* work.h: data of an engine that can be recomputed from model and state.
 *
 * Rule: discarding the work and rebuilding it must not change any bit of the results. During a run
 * the records of contacts (their history) are kept with the candidate pairs (struct pairs);
 * contacts_store copies the records of closed contacts to the state's columns, contacts_load copies
 * them back.
 */
#ifndef PHYSICS_WORK_H
#define PHYSICS_WORK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/comm.h"
#include "base/team.h"
#include "model/law_constants.h"
#include "model/segments.h"
#include "model/state.h"
#include "slipdisk/contact.h"

/* Constants of the contact law for one pair of materials, in the form that the pair loop uses. */
#define LAW_MEMBER(features, name, value) double name;
typedef struct law_row {
  /* stiffnesses and normal damping; cap: mu/k_t, 0 if k_t is 0 (frictionless) */
  double k_n, k_t, gamma_n, cap;
  /* normal: number of the normal force law; tsuji: factor of its damping by restitution
   * (law_tsuji) */
  double normal, tsuji;
  /* The other members are only read if some law needs them (LAW_GENERAL in law_features.h). */
  LAW_CONSTANTS(LAW_MEMBER)
} law_row;
#undef LAW_MEMBER
/* LAW_MORE: number of members of law_row from `pulls` on; LAW_PLACE: index of a member among
 * these. */
enum { LAW_MORE = (sizeof(law_row) - offsetof(law_row, pulls)) / sizeof(double) };
#define LAW_PLACE(member) ((offsetof(law_row, member) - offsetof(law_row, pulls)) / sizeof(double))

/* Data of eight candidate pairs. Each column of doubles is one cache line, so a loop over pairs
 * reads one stream of memory. The record (contact history, slipdisk/contact.h) is saved in
 * checkpoints, and carried over when the neighbour list is rebuilt; the other columns are written
 * by the functions named beside them. */
enum { PAIR_BLOCK = 8 };
#define PAIR_COLUMN(name, ...) double name[PAIR_BLOCK];
typedef struct pair_block {
  /* Offsets, in doubles, of bodies a and b in work.packed; set by pairs_list. */
  _Alignas(64) int32_t packed_a[PAIR_BLOCK], packed_b[PAIR_BLOCK];
  /* offsets, in doubles, of bodies a and b in the force sums (sums.row); set by pairs_list */
  int32_t sum_a[PAIR_BLOCK], sum_b[PAIR_BLOCK];
  union {
    struct {
      SD_CONTACT_RECORD(PAIR_COLUMN)
    };
    double record[SD_CONTACT_COLUMNS][PAIR_BLOCK];
  };
  int32_t law[PAIR_BLOCK]; /* index of the contact law in work.laws; set by neighbours_build */
} pair_block;

/* Further columns of the contact history of the same eight pairs; only for models that need them
 * (LAW_GENERAL). */
typedef struct pair_more {
  union {
    struct {
      _Alignas(64) SD_CONTACT_MORE(PAIR_COLUMN)
    };
    double record[SD_CONTACT_EXTRA][PAIR_BLOCK];
  };
} pair_more;
#undef PAIR_COLUMN

/* PAIR and MORE give the value of pair k in a column: of pair_block, of pair_more. */
#define PAIR(pairs, k, column)                                                                     \
  ((pairs)->block[(size_t)(k) / PAIR_BLOCK].column[(size_t)(k) % PAIR_BLOCK])
#define MORE(pairs, k, column)                                                                     \
  ((pairs)->more[(size_t)(k) / PAIR_BLOCK].column[(size_t)(k) % PAIR_BLOCK])

/* Flags of the contacts in a block of pairs, one bit each (for a wall segment, bit 0 only): closed
 * at the last evaluation; sliding at the last evaluation with positive or negative torque on both
 * disks. Like the contact history, the flags are carried over when the list is rebuilt. */
typedef struct pair_flags {
  uint8_t closed, slides_positive, slides_negative;
} pair_flags;

/* Candidate pairs: pairs of round bodies in [0, n_round), pairs with ghosts (halo.h) in
 * [first_ghost, end_ghost), pairs with wall segments in [first_segment, count). Each of these lists
 * is ordered by (slot of a, slot of b, segment), and begins with a new block. Padding after each
 * list has a = b = -1 and is never in contact. */
typedef struct pairs {
  size_t count, n_round, first_ghost, end_ghost, first_segment, capacity;
  int32_t *a, *b; /* slots of the two bodies of each pair; set by neighbours_build */
  int32_t *part;  /* index of the wall segment of each pair; set by neighbours_build */
  /* for closed contacts with a wall segment: side of the wall on which the contact began, +1 left
   * of the tangent, -1 right; else 0 */
  double *side;
  pair_block *block; /* columns of the pairs; each block has PAIR_BLOCK pairs */
  /* columns that only some contact laws need (LAW_GENERAL); NULL: the laws of this model do not */
  pair_more *more;
  bool wants_more; /* true if the contact laws need the columns `more` */
  /* flags: one entry per block of pairs of round bodies, then one per pair with a wall segment */
  pair_flags *flags;
} pairs;

/* Candidate contacts of each body, in the order of the pairs; set by neighbours_build. */
typedef struct incidence {
  size_t *start;   /* [n_bodies + 1] index in `entry` of the first contact of each body */
  uint32_t *entry; /* contacts of all bodies: 2 * pair, plus 1 if the body is b of this pair */
  size_t capacity;
} incidence;

/* Force sums of the bodies, by contacts. A row has the force (x, y), the torque (divided by the
 * radius for round bodies; for straight walls the torque itself, about the pivot), and a fourth
 * number: on disks the couple of rolling resistance, a torque of opposite sign on the two bodies
 * (for walls it is part of the torque); on straight walls the force along the surface.
 *
 * Normally each body has one row, and pairs add to it one after the other. If the pairs of a body
 * are not all evaluated by one thread, or if each contact force is needed (prescribed bodies), each
 * contact of the body has a row of its own, and `gather` adds these rows up in the order of the
 * pairs. So the order of summation is always the same.
 */
enum { SUM_X, SUM_TORQUE, SUM_Y, SUM_COUPLE, SUM_ROW, SUM_SURFACE = SUM_COUPLE };
/* add4 in base/lane.h adds a row to one body and subtracts it from the other, except numbers at odd
 * indices (SUM_TORQUE), which it adds to both. */
_Static_assert(SUM_X % 2 == 0 && SUM_Y % 2 == 0 && SUM_TORQUE % 2 == 1, "add4");
typedef struct sums {
  /* [end][SUM_ROW] one row per body, then one row per contact of each listed body */
  double *row;
  size_t end;       /* number of rows in `row` */
  uint32_t *listed; /* slots of the bodies that have one row per contact, ascending */
  size_t n_listed;
  size_t *single; /* [n_listed + 1] number of the first such row of each listed body */
  size_t capacity, listed_capacity;
} sums;

enum { WORK_MAX_THREADS = 64 };
/* largest number of prescribed coordinates for which steps are taken in windows, and of values
 * kept of each */
enum { WINDOW_PRESCRIBED = 16, WINDOW_KEPT = 7 };

/* Chunks: groups of free disks with consecutive slots, which threads work on as a whole;
 * chunks.h. */
typedef struct chunks {
  /* size: largest number of disks in a chunk; count: number of chunks */
  size_t size, count, capacity;
  int n_threads;
  size_t *begin;      /* [count + 1] slot of the first disk of each chunk */
  uint32_t *of_disks; /* chunk that each group of CHUNK_STEP consecutive disks belongs to */
  /* [count + 1] first pair of round bodies, and first pair with a wall segment, of each chunk */
  size_t *pair, *segment;
  /* need_start: [count + 1] index in `need` of the first entry of each chunk */
  size_t *need_start, need_capacity;
  /* for each chunk, numbers of the chunks whose disks its pairs read, itself included */
  uint32_t *need;
  size_t share[WORK_MAX_THREADS + 1]; /* first chunk of each thread's range of chunks */
  /* boundary_first: pairs of other threads or ranks read disks of this chunk; boundary_last: pairs
   * of other threads add forces to disks of this chunk. */
  bool *boundary_first, *boundary_last;
  bool any_boundary_first; /* true if boundary_first is true for some chunk */
  /* true if chunks that are computed later reuse the rows of earlier chunks in work.packed and
   * sums */
  bool shares;
  /* row: first row of each chunk in work.packed and sums; rows: number of all these rows */
  size_t *row, rows;
  /* reach: largest distance of two chunks with a common pair; window: most steps that window.c
   * takes at once, 1: one by one */
  size_t reach;
  int64_t window;
  int64_t *predicted; /* step that each chunk's disks were last predicted for; see step.c */
  int64_t *packed;    /* step that each chunk's packed bodies were last written for; see step.c */
} chunks;

/* Packed body: all numbers that the pair loop reads of a body, in one cache line. The predictor and
 * motion_pose write it together with the pose. Free disks have a row here and in sums only while
 * pairs need it (chunks_plan_rows). PACKED_ARC: R theta. */
enum {
  PACKED_X,
  PACKED_ARC,
  PACKED_Y,
  PACKED_RADIUS,
  PACKED_VX,
  PACKED_VY,
  PACKED_INVERSE_MASS, /* 1/mass, 0 for prescribed bodies; only set if laws need it (LAW_NORMAL) */
  /* R omega; for free disks only set if laws need it (LAW_DASHPOT or LAW_ROLLING) */
  PACKED_SPIN,
  PACKED_ROW = 8
};
/* across4 in base/lane.h computes differences b - a of columns with even index, and sums b + a of
 * columns with odd index. */
_Static_assert(PACKED_X % 2 == 0 && PACKED_Y % 2 == 0 && PACKED_ARC % 2 == 1 &&
                   PACKED_RADIUS % 2 == 1,
               "across4");
_Static_assert(PACKED_VY == PACKED_VX + 1, "across2");

/* Wall segment at its present position in space: straight, an arc, or an end point of an arc; set
 * by walls_pose. */
typedef struct placed_segment {
  /* Start point (for an arc: centre of the circle), unit tangent (tx, ty), length, and unit tangent
   * (px, py) of the segment before. */
  double x, y, tx, ty, length, px, py;
  double end_x, end_y; /* start point of the next segment; only set if `joined` */
  /* smallest coordinate along the tangent: -HUGE_VAL for an infinite line, else 0 */
  double backwards;
  double arc; /* arc length along the wall at the start of the segment, for an arc at its middle */
  /* end_cap: the far end is free and is touched as a point; joined: another segment begins at the
   * far end; wide: an arc of more than half a turn. */
  bool end_cap, joined, wide;
  /* shared: another segment has one end in common with it; meets: a segment of another wall has */
  bool shared, meets;
  bool image[2]; /* [x, y] true along directions in which the segment has periodic images */
  int cells[2];  /* [x, y] number of periods from (end_x, end_y) to the start of the next segment */
  double middle_x, middle_y; /* vector from (x, y) to the middle of the segment */
  /* displacement of a periodic image from the original segment; 0 for the original */
  double shift_x, shift_y;
  sd_piece piece; /* kind: straight, arc, or first or last end point of an arc */
  double c, i;    /* cosine and sine of the wall's angle; both 0: not placed yet */
  /* Only for arcs: radius, and unit vectors from the centre to the first end (fx, fy), to the last
   * end (lx, ly) and to the middle (mx, my). */
  double radius, fx, fy, lx, ly, mx, my;
} placed_segment;

/* Rare event, handled by one thread after the pair loop or the corrector: a contact that ended,
 * began, turned far from its reference direction, or overlaps by more than the limit; or a disk
 * whose angle or position must be wrapped. */
typedef struct event {
  uint32_t index; /* index of the pair, or slot of the disk */
  uint64_t at;    /* key by which events are sorted; see contacts_events */
  /* energy left in the springs of a contact that opened, or lost when a capillary bridge formed */
  double dropped;
  double broken;   /* energy of a bond that broke */
  double place[2]; /* of its middle */
  int mode;        /* how it broke (contact/law_bond.h); 0: it did not */
  bool was_closed; /* true if the contact was closed before this evaluation */
  /* true for a contact of a packing that is open at step 0: its energy is not counted as a loss */
  bool unbooked;
} event;

typedef struct event_list {
  event *item;
  size_t count, capacity;
  bool failed; /* true: memory ran out, and items are missing */
} event_list;

/* Pointers to the columns of one coordinate (x, y or theta) of all free disks, by slot. q:
 * coordinate; v: velocity; q2 ... q5: n-th time derivative times dt^n/n!; force: contact force (or
 * torque); constant: force that does not come from contacts; inverse: inverse mass or moment of
 * inertia, 0 if locked or prescribed. */
typedef struct columns {
  double *q, *v, *q2, *q3, *q4, *q5;
  double *force;
  const double *constant, *inverse;
} columns;

/* Clumps, rigid bodies of several free disks; filled by system/clumps.c. */
typedef struct clumps {
  size_t count; /* number of clumps; 0: all members below are unset */
  bool pushed;  /* true if constant forces act on single disks of some clump */
  /* [count + 1] index of the first disk of each clump in the columns `member` to `arm_y` */
  size_t *start;
  uint32_t *member; /* slots of the disks of each clump, in the order of their body numbers */
  /* Position and angle of each disk relative to its clump's centre, in the body frame of the
   * clump. */
  double *offset_x, *offset_y, *offset_theta;
  /* (offset_x, offset_y) rotated to the space frame, as of when the disks were last placed */
  double *arm_x, *arm_y;
  int32_t *of;     /* [n_free] index of the clump of the disk in each slot; -1: none */
  double *clumped; /* [n_free] 1 for disks in clumps, 0 for others */
  /* [n_free] mass of the disk, or of its clump; used in the effective mass m_eff of contacts */
  double *contact_mass;
  /* [count] coefficients of Cundall's non-viscous damping of each clump, for translation and
   * rotation */
  double *alpha, *alpha_rotation;
  /* columns of the clumps' coordinates x, y and theta, like those of free disks */
  columns columns[SD_COORDINATES];
} clumps;

/* Contact of a disk (a) with a periodic image of a body (b). */
typedef struct crossing {
  double fx, fy, nx, ny; /* force on b; numbers of periods from the image to b, along x and y */
} crossing;

typedef struct crossing_list {
  crossing *item;
  size_t count, capacity;
  bool failed; /* true: memory ran out, and items are missing */
} crossing_list;

/* Deforming periodic box; see cell.h. */
typedef struct work_cell {
  bool on; /* true in phases in which rows of periodic images are shifted or the box deforms */
  double speed[3];   /* rates of change of the two lengths and of the offset, in length/time */
  double list[3];    /* the two lengths and the offset when the neighbour list was built */
  int64_t step;      /* step whose box shape the other members of work have */
  int64_t list_step; /* step whose box shape the neighbour list was built for */
  /* mean velocity (x, y) of the disks relative to the box when the list was built */
  double drift[2];
  /* Affine map of positions from the time at which the list was built to the end of the coming
   * step, minus the identity: components xx, yy, xy. */
  double map[3];
  double shift[2]; /* displacement (x, y) by `drift` in the same time */
} work_cell;

/* Data of one thread, on cache lines that no other thread writes. */
typedef struct thread_work {
  /* true: a body has moved or will move too far for the neighbour list, or its position is not a
   * number; set by the corrector and by prescribed motions. */
  _Alignas(64) bool stale;
  bool fast;         /* true: a body moved by more than the displacement limit; set like `stale` */
  event_list events; /* events of contacts, noted by the pair loop */
  crossing_list crossings; /* contacts across the edge of a deforming box, noted by the pair loop */
  /* bodies whose angle or position must be wrapped, noted by the corrector and by motions */
  event_list returns;
} thread_work;

/* Pair with a wall segment as it was before a window. */
typedef struct window_piece {
  sd_contact_record record;
  double side;
  pair_flags flags;
} window_piece;

typedef struct window_block {
  double record[SD_CONTACT_COLUMNS][PAIR_BLOCK];
} window_block;

typedef struct window_rare window_rare; /* defined in window.c */
typedef struct window_wave window_wave; /* defined in window.c */

/* Times of single steps and of windows, by which one of both is chosen (step/window.c). */
typedef struct window_trial {
  int way;              /* 0: single steps are timed, 1: windows, 2: the cheaper of both goes on */
  double began;         /* when this way began, s of the monotonic clock */
  int64_t step, builds; /* step and number of lists then */
  double cost[2];       /* s per step of single steps and of windows */
} window_trial;

/* Several steps taken chunk by chunk (step/window.c). */
typedef struct window {
  /* Copies of what the steps change, to undo them: columns of disks, contact records, columns that
   * only events change (in the order of the events), prescribed coordinates. */
  double *disks;
  window_block *blocks;
  pair_flags *flags;
  pair_more *more;
  window_piece *pieces;
  window_rare *rare;
  size_t n_rare, rare_capacity;
  double prescribed[WINDOW_PRESCRIBED][WINDOW_KEPT];
  size_t fixed; /* index of the first prescribed body in sums.listed; n: number of them */
  size_t n_fixed;
  double *sums;          /* [steps][n_fixed][SUM_ROW] forces on prescribed bodies in each step */
  size_t *reached;       /* [steps][n_fixed] contacts that are in these sums */
  window_wave *wave;     /* steps that are under way */
  int64_t steps;         /* number of steps that there is room for */
  int64_t builds;        /* list (work.builds) that there is room for */
  int64_t taken, undone; /* numbers of windows so far */
  int64_t most;          /* number of steps that the next window may have */
  bool failed;           /* something came up that only single steps can handle */
  bool lost;             /* there was no memory for a copy */
  sd_messages *messages;
  int64_t plain_until; /* steps before this one are taken one by one */
  window_trial trial;
} window;

typedef struct body_forces body_forces; /* defined in fields.h */
typedef struct fields fields;           /* defined in fields.h */
typedef struct motions motions;         /* defined in motion.c */
typedef struct lanes lanes;             /* defined in lanes.h */
typedef struct engine engine;
typedef struct halo halo;       /* defined in halo.h */
typedef struct kernels kernels; /* defined in kernels.h */

typedef struct work {
  /* Constants of the model in the form that the loops use; set by engine_new. */
  double dt, per_dt, half_dt2; /* time step, 1/dt, dt^2/2 */
  /* Limit of (speed/radius)^2 above which a disk exceeds the displacement limit; infinite: not
   * checked; set by speed_begin. */
  double speed_limit2;
  bool compare_motions; /* true: the displacement limit also applies to prescribed bodies */
  /* conservative: false for the tangential force of the paper; periodic: [x, y] */
  bool conservative, periodic[2];
  /* Periodic box, [x, y]; along open directions lengths are 0 and bounds infinite. */
  double lower[2], upper[2], length[2], inverse_length[2];
  /* Lees-Edwards offset: shift along x of each row of periodic cells against the row below */
  double offset;
  work_cell cell;
  law_row *laws; /* [n_materials^2] contact law of materials i and j, at index i n_materials + j */
  bool one_law;  /* true if all rows of `laws` are the same */
  /* LAW_ bits of all contact laws together (law_features.h); 0: k_n, gamma_n, k_t and mu suffice */
  unsigned features;
  bool stale; /* true: the neighbour list must be rebuilt for the coming step; set by step_once */
  /* first step for which contact forces on free disks are stored in the state; set by step_begin */
  int64_t show_from;
  /* true: a step predicts all disks before it evaluates forces; set by step_begin */
  bool predict_all;
  /* [n_free] inverse masses (for motion along x and y) and inverse moments of inertia; 0 for locked
   * or prescribed coordinates. */
  double *inverse_mass_x, *inverse_mass_y, *inverse_inertia;
  /* [n_free] gravity plus constant forces given by the deck, and constant torque */
  double *constant_x, *constant_y, *constant_torque;
  /* true for a coordinate if its columns[].constant is 0 for all disks */
  bool nothing_constant[SD_COORDINATES];
  columns columns[SD_COORDINATES];
  clumps clumps;
  void *arena;      /* memory of the columns above, and of the poses x0, y0, theta0 */
  slot_table slots; /* slots by body number; clump k has the number (count of bodies) + k */
  const kernels *kernels;
  int n_threads;

  /* Neighbour list, and data that follow from it; set by neighbours_build. */
  pairs pairs, spare; /* spare: memory for the next list */
  incidence incidence;
  sums sums;
  chunks chunks;
  /* [n_bodies + 1] row of each body in `packed` and in the force sums; the last entry is the row
   * that padding uses */
  int32_t *row;
  double *packed;         /* [rows][PACKED_ROW] packed bodies */
  size_t packed_capacity; /* number of rows that `packed` has memory for */
  double max_overlap;     /* largest overlap over the smaller radius (sd_model) */
  double least_limit;     /* overlap limit of the smallest body */
  int32_t n_disks;        /* bodies in slots below are disks, the others walls */
  double margin;          /* largest gap at which a contact begins or ends (cohesion, bonds) */
  /* skin: Verlet margin; moved_limit2: squared displacement at which the list is stale */
  double skin, moved_limit2;
  double list_scale; /* scale of the box (state->box_scale) when the list was built */
  /* [n_bodies] poses when the list was built; positions are rescaled when the box is */
  double *x0, *y0, *theta0;
  /* [n_walls] distance from a wall's pivot to its farthest point that disks can touch */
  double *reach;
  int64_t builds, built_at; /* number of list builds; step of the last one */
  /* harmonic mean of the disks' radii; it gives weight to small disks, which most pairs belong
   * to */
  double mean_radius;
  /* smallest power of two (a length) that is at least mean_radius; unit of body_surface_turn */
  double surface_unit;
  /* [n_segments] wall segments at their present positions; set by walls_pose */
  placed_segment *segments;
  uint32_t *pieces; /* indices of the wall segments that occur in the list of pairs, ascending */
  size_t n_pieces;
  /* [2 n_slides] index of the pair of each contact that the deck watches; -1: not in the list */
  int64_t *watched;

  motions *motions;
  body_forces *body_forces; /* force fields of the deck; NULL: there are none */
  /* fast step for small systems, holding this system only; NULL: only the general step is used */
  lanes *lanes;
  thread_work *threads; /* [n_threads] data of each thread */
  window window;
  /* status of the present step; one thread sets it, all read it after a barrier */
  sd_status status;
  sd_messages *messages;
} work;

/* One system: model, state, and work (recomputable data). All code below run/ operates on this. */
struct engine {
  const sd_model *model;
  sd_state *state;
  fields *fields;   /* force fields of the calling program; NULL: none */
  halo *halo;       /* exchange of ghosts with other ranks; NULL: this process owns all disks */
  const comm *comm; /* communicator of the ranks that share the disks; NULL: one process */
  /* Function that rebuilds neighbour lists and ghosts in a run on several ranks, and its data; both
   * NULL in one process. */
  sd_status (*renew)(engine *e, sd_messages *messages);
  struct ranks *ranks;
  /* pool of at most work.n_threads threads, not owned; NULL: one thread does all the work */
  pool *pool;
  int64_t rebuilt; /* number of times that `work` was made anew, as after a change of constants */
  work work;
};

/* Returns the pool of threads for building lists; NULL if there are fewer than WORK_TOGETHER free
 * disks, for which one thread is as fast. */
enum { WORK_TOGETHER = 1000 };
static inline pool *work_pool(const engine *e) {
  return e->state->n_free < WORK_TOGETHER ? NULL : e->pool;
}

#endif

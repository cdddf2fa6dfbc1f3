/* work.h: what can be recomputed from model and state.
 *
 * Rule: throwing work away and rebuilding it changes not one bit of what follows. The live contact memory
 * stands beside the candidate pairs (struct pairs) while a run goes on; contacts_store brings the closed
 * ones into the state's columns, contacts_load takes them from there.
 */
#ifndef PHYSICS_WORK_H
#define PHYSICS_WORK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/comm.h"
#include "base/team.h"
#include "slipdisk/contact.h"
#include "model/model.h"
#include "model/slot_table.h"
#include "model/state.h"

/* Contact constants of one pair of materials, ready for the law. */
typedef struct law_row {
  double k_n, k_t, gamma_n, cap; /* cap: mu/k_t, 0 where frictionless */
  double normal, tsuji;          /* number of the normal law; law_tsuji */
  /* where laws are general (model/laws.h) */
  double pulls;                     /* 1: damping may pull */
  double cap_kinetic, mindlin, lag; /* mu_kinetic/k_t; 1: Mindlin's stiffness; gamma_t/k_t */
  double k_r, cap_r, lag_r;         /* mu_r/k_r, gamma_r/k_r; 0 without k_r */
  double bridge, pull_off, range, per_range; /* 1: a bridge; 1/range */
  double broken, begins, ends; /* exp(-rupture/range); gaps at which a contact begins and ends */
} law_row;
enum {
  LAW_MORE = (sizeof(law_row) - offsetof(law_row, pulls)) / sizeof(double)
}; /* numbers from `pulls` on */
#define LAW_PLACE(member) ((offsetof(law_row, member) - offsetof(law_row, pulls)) / sizeof(double))

/* Eight pairs, each column one cache line, so that a pass reads one stream. The record (slipdisk/contact.h) goes through
 * the state at checkpoints and is carried over rebuilds; other columns are written by the function named. */
enum { PAIR_BLOCK = 8 };
#define PAIR_COLUMN(name, unit, meaning) double name[PAIR_BLOCK];
typedef struct pair_block {
  _Alignas(64) int32_t packed_a[PAIR_BLOCK],
      packed_b[PAIR_BLOCK];                     /* where the packed bodies begin; rows_list */
  int32_t sum_a[PAIR_BLOCK], sum_b[PAIR_BLOCK]; /* where forces on them are added; rows_list */
  union {
    struct {
      SD_CONTACT_RECORD(PAIR_COLUMN)
    };
    double record[SD_CONTACT_COLUMNS][PAIR_BLOCK];
  };
  int32_t law[PAIR_BLOCK]; /* row of the law table; neighbours_build */
} pair_block;

/* The columns of laws that need more, of the same pairs. */
typedef struct pair_more {
  union {
    struct {
      _Alignas(64) SD_CONTACT_MORE(PAIR_COLUMN)
    };
    double record[SD_CONTACT_EXTRA][PAIR_BLOCK];
  };
} pair_more;
#undef PAIR_COLUMN

/* Column of pair k. */
#define PAIR(pairs, k, column)                                                                     \
  ((pairs)->block[(size_t)(k) / PAIR_BLOCK].column[(size_t)(k) % PAIR_BLOCK])
#define MORE(pairs, k, column)                                                                     \
  ((pairs)->more[(size_t)(k) / PAIR_BLOCK].column[(size_t)(k) % PAIR_BLOCK])

/* Bits of the contacts of a block, or bit 0 for one wall segment: it touched in the last evaluation; it slid there with
 * positive or negative torque. They go with the record. */
typedef struct pair_flags {
  uint8_t closed, slides_positive, slides_negative;
} pair_flags;

/* Candidate pairs: round ones at [0, n_round), those with ghosts (halo.h) at [first_ghost, end_ghost), wall segments at
 * [first_segment, count); each list is ordered by (slot of a, slot of b, segment), and begins with a whole block.
 * Padding between them and beyond the last has a = b = -1 and touches nothing. */
typedef struct pairs {
  size_t count, n_round, first_ghost, end_ghost, first_segment, capacity;
  int32_t *a, *b; /* slots; neighbours_build */
  int32_t *part;  /* segment; neighbours_build */
  double *side;   /* of segments, goes with the record */
  pair_block *block;
  pair_more *more; /* NULL: no law needs it */
  bool wants_more;
  pair_flags *flags; /* of blocks of round pairs, then of single segments */
} pairs;

/* The contacts of each body in order of the pairs: entry = 2 * pair + (1 if the body is b); neighbours_build. */
typedef struct incidence {
  size_t *start; /* [n_bodies + 1] */
  uint32_t *entry;
  size_t capacity;
} incidence;

/* What contacts do to bodies: force (x, y), and torque over the radius, about a straight wall's pivot the torque
 * itself. The fourth number is, on disks, the couple of rolling, a torque of opposite sign on the two (on walls it is part of what
 * turns); on straight walls the force along the surface. Pairs add to the row of a body, one after the other. Where the pairs of
 * a body are not all in the same share of a thread, or each force is wanted (prescribed bodies), each has a row of its
 * own, and gather adds them up: the order is the same, that of the pairs. */
enum { SUM_X, SUM_TURN, SUM_Y, SUM_COUPLE, SUM_ROW, SUM_SURFACE = SUM_COUPLE };
/* what has the same sign on both bodies is odd: add4 in base/lane.h */
_Static_assert(SUM_X % 2 == 0 && SUM_Y % 2 == 0 && SUM_TURN % 2 == 1, "add4");
typedef struct sums {
  double *row;      /* [rows of bodies + entries of listed bodies][SUM_ROW] */
  size_t end;       /* rows */
  uint32_t *listed; /* slots, ascending */
  size_t n_listed;
  size_t *single; /* [n_listed + 1] first row of each */
  size_t capacity, listed_capacity;
} sums;

enum { WORK_MAX_THREADS = 64 };

/* Chunks of free disks; chunks.h. Lists of chunks by chunk: those of k stand at [start[k], start[k + 1]). */
typedef struct chunks {
  size_t size, count, capacity; /* disks in each, at most */
  int n_threads;
  size_t *begin;          /* [count + 1] first disk */
  uint32_t *of_disks;     /* chunk of each CHUNK_STEP disks */
  size_t *pair, *segment; /* [count + 1] where its round pairs and its pieces begin */
  size_t *need_start, need_capacity;
  uint32_t *need;                     /* chunks that its pairs see */
  size_t share[WORK_MAX_THREADS + 1]; /* of each thread: the first chunk */
  bool *boundary_first,
      *boundary_last; /* wanted by another thread's pairs; pushed by another thread's pairs */
  bool any_boundary_first;
  bool shares;        /* others take over rows of earlier ones */
  size_t *row, rows;  /* of its first disk, in packed bodies and sums; how many there are */
  int64_t *predicted; /* the step whose predicted coordinates its disks have; step */
  int64_t *packed;    /* and whose its packed bodies show; step */
} chunks;

/* What a pass over pairs reads of a body, one cache line each. Predictor and motion_pose write it with the pose. Free
 * disks have a row here and in sums only while pairs want them (chunks_plan_rows). arc: R theta. */
enum {
  PACKED_X,
  PACKED_ARC,
  PACKED_Y,
  PACKED_RADIUS,
  PACKED_VX,
  PACKED_VY,
  PACKED_INVERSE_MASS, /* 0 of prescribed bodies; where laws are not all plain */
  PACKED_SPIN,         /* R omega, likewise */
  PACKED_ROW = 8
};
/* of two bodies the differences of even numbers are wanted, and the sums of odd ones: across4 in base/lane.h */
_Static_assert(PACKED_X % 2 == 0 && PACKED_Y % 2 == 0 && PACKED_ARC % 2 == 1 &&
                   PACKED_RADIUS % 2 == 1,
               "across4");
_Static_assert(PACKED_VY == PACKED_VX + 1, "across2");

/* A piece of a wall in space; walls_pose. Of an arc: x, y are the centre, fx ... my its directions. */
typedef struct placed_segment {
  double x, y, tx, ty, length, px, py; /* start, tangent, length, tangent of the piece before */
  double end_x, end_y;                 /* start of the piece that follows; joined */
  double backwards; /* -length of what extends before the start: -HUGE_VAL for a line, else 0 */
  double arc;
  bool end_cap, joined, wide;
  bool shared, meets;        /* one of its ends is another piece's, too; one of another wall */
  bool image[2];             /* along these directions it has periodic images */
  int cells[2];              /* the piece that follows starts so many periods from (end_x, end_y) */
  double middle_x, middle_y; /* of the piece, from (x, y) */
  double shift_x, shift_y;   /* of an image, from the piece itself */
  sd_piece piece;
  double c, i; /* cosine and sine of the wall's angle; 0, 0: not placed yet */
  double radius, fx, fy, lx, ly, mx,
      my; /* arc: of its first and last end, and of the middle between */
} placed_segment;

/* Pairs that need rare, serial treatment after the pass: contacts that ended (with the energy they dropped), began,
 * turned far from their reference direction, or overlap beyond the limit. Or a disk that must return into its range. */
typedef struct event {
  uint32_t index;  /* of the pair, or the disk's slot */
  uint64_t at;     /* place in the order of events; contacts_events */
  double dropped;  /* energy left in a contact that opened, or lost in a bridge that formed */
  bool was_closed; /* before the pass */
  bool unbooked;   /* ended, but never touched here */
} event;

typedef struct event_list {
  event *item;
  size_t count, capacity;
  bool failed; /* no memory */
} event_list;

/* Where one coordinate of the free disks stands in the state, and what pushes it; engine_build. */
typedef struct columns {
  double *q, *v, *q2, *q3, *q4, *q5;
  double *force;
  const double *constant, *inverse;
} columns;

/* Rigid bodies of several free disks; system/clumps.c. */
typedef struct clumps {
  size_t count;     /* 0: there are none, and nothing below */
  bool pushed;      /* constant forces or fields act on single disks */
  size_t *start;    /* [count + 1] the disks of each, by their numbers, in what follows */
  uint32_t *member; /* slots */
  double *offset_x, *offset_y,
      *offset_theta;               /* from the centre, in the frame of the clump; of the angle */
  double *arm_x, *arm_y;           /* the same in space, when the disks were last placed */
  int32_t *of;                     /* [n_free] clump of the disk in each slot, -1: none */
  double *clumped;                 /* [n_free] 1 of their disks, 0 of others */
  double *contact_mass;            /* [n_free] of a disk, or of its clump */
  double *alpha, *alpha_rotation;  /* of non-viscous damping, on the clump as a whole */
  columns columns[SD_COORDINATES]; /* as those of the free disks */
} clumps;

/* A contact with an image, and its force on the body b. */
typedef struct crossing {
  double fx, fy, nx, ny; /* cells that b is away */
} crossing;

typedef struct crossing_list {
  crossing *item;
  size_t count, capacity;
  bool failed; /* no memory */
} crossing_list;

/* A box that deforms: cell.h. */
typedef struct work_cell {
  bool on;           /* images are shifted or move, in this phase */
  double speed[3];   /* of the lengths and the offset, length/time */
  double list[3];    /* lengths and offset when the lists were built */
  int64_t step;      /* of which work has the box, ... */
  int64_t list_step; /* and of that of the lists */
  double drift[2];   /* mean velocity beside that of the box when the lists were built */
  double map[3];     /* of positions since then, less 1, xx, yy, xy; after the coming step */
  double shift[2];   /* and what the drift adds */
} work_cell;

/* Per thread, cache lines of its own. */
typedef struct thread_work {
  _Alignas(
      64) bool stale; /* a body will have moved too far since the lists were built, or nowhere; correct kernels */
  bool fast;               /* a disk is beyond the displacement limit; correct kernels */
  event_list events;       /* pairs kernels, commit pass */
  crossing_list crossings; /* pairs kernels, of a box that deforms */
  event_list returns; /* disks whose theta or position must return into range; correct kernels */
} thread_work;

typedef struct body_forces body_forces; /* fields.h */
typedef struct fields fields;           /* fields.h */
typedef struct motions motions;         /* motion.h */
typedef struct lanes lanes;             /* lanes.h */
typedef struct engine engine;
typedef struct halo halo;       /* halo.h */
typedef struct kernels kernels; /* kernels.h */

typedef struct work {
  /* constants of the model in the form the loops want; engine_new */
  double dt, per_dt, half_dt2;
  double
      speed_limit2; /* squared speed over squared radius beyond which a disk is noted; speed_begin */
  bool compare_motions; /* prescribed bodies may be beyond the limit of displacement; speed_begin */
  bool conservative, periodic[2];
  double lower[2], upper[2], length[2],
      inverse_length[2]; /* box; lengths 0, bounds infinite where open */
  double offset;         /* of a row of cells against the one below */
  work_cell cell;
  law_row *laws;
  bool one_law;
  unsigned features; /* of all laws (model/laws.h), 0: plain */
  bool stale;        /* the lists, for the coming step; step_once */
  int64_t
      show_from; /* from this step on the forces on free disks are wanted in the state; step_begin */
  bool predict_all; /* all disks are predicted before anything else is done; step_begin */
  double *inverse_mass_x, *inverse_mass_y,
      *inverse_inertia;                              /* [n_free], 0 where held or prescribed */
  double *constant_x, *constant_y, *constant_torque; /* [n_free] gravity and body force */
  bool nothing_constant[SD_COORDINATES];             /* the same is 0 for all */
  columns columns[SD_COORDINATES];
  clumps clumps;
  void *arena;      /* columns of these, and poses when the lists were built */
  slot_table slots; /* by body number; of clump k: bodies + k */
  const kernels *kernels;
  int n_threads;

  /* lists; neighbours_build */
  pairs pairs, spare; /* spare: room for the next build */
  incidence incidence;
  sums sums;
  chunks chunks;
  int32_t *row;   /* [n_bodies + 1] of each body in packed and sums; the last is that of padding */
  double *packed; /* [rows of bodies][PACKED_ROW] */
  size_t packed_capacity;    /* rows */
  double least_limit;        /* of the overlap, of the smallest body */
  double margin;             /* largest gap at which a contact begins or ends */
  double skin, moved_limit2; /* squared displacement that makes the lists stale */
  double list_scale;         /* state->box_scale when the lists were built */
  double *x0, *y0, *theta0;  /* [n_bodies] poses when the lists were built, in today's lengths */
  double *reach; /* [n_walls] largest distance from the pivot that matters when the wall turns */
  int64_t builds, built_at; /* how often; step of the last */
  double mean_radius;  /* harmonic mean of the disks: most pairs are of small ones; engine_build */
  double surface_unit; /* a power of two no less; engine_build */
  placed_segment *segments; /* walls_pose */
  uint32_t *pieces; /* of walls that are in the list of pairs, ascending; neighbours_build */
  size_t n_pieces;
  int64_t *watched; /* [2 n_slides] pair of each watched contact, -1: not even a candidate */

  motions *motions;
  body_forces *body_forces; /* NULL: the model has no fields */
  lanes *lanes;             /* of this system alone; NULL: the general step only */
  thread_work *threads;     /* [n_threads] */
  sd_status
      status; /* of the step that is being done; set by one thread, read by all after a wait */
  sd_messages *messages;
} work;

/* One system. The physics below run/ works on this. */
struct engine {
  const sd_model *model;
  sd_state *state;
  fields *fields;   /* NULL: none */
  halo *halo;       /* NULL: this process has all disks */
  const comm *comm; /* whose ranks have the other disks; NULL: a rank alone */
  /* engine_renew of one of several ranks, and what these know of the run; NULL: of one alone */
  sd_status (*renew)(engine *e, sd_messages *messages);
  struct ranks *ranks;
  pool *pool; /* of work.n_threads or fewer, of the owner; NULL: one thread does it all */
  work work;
};

/* The threads that make lists; NULL with few disks, where one is as fast. */
enum { WORK_TOGETHER = 1000 };
static inline pool *work_pool(const engine *e) {
  return e->state->n_free < WORK_TOGETHER ? NULL : e->pool;
}

#endif

/* lanes.h: small systems in SIMD lanes: a few free disks among prescribed bodies, either one
 * system, or several alike ones side by side in the lanes of vectors.
 *
 * The step is one function over rows of `width` numbers, one number per system (lanes_pass.h); a
 * system that runs alone fills both lanes of the narrowest vector. The code of contacts, predictor
 * and corrector is that of the general step, sums run in the same order, and lanes do not mix:
 * results have the same bits as the general step (tests compare them).
 *
 * Every pair of a free disk and another body is always a candidate: for so few bodies this is
 * cheaper than maintaining lists, and no lane can invalidate what the lanes share. While lanes run,
 * the variables that a step changes are in the rows; lanes_store writes them to the states and the
 * contact records of each system, lanes_load reads them back.
 */
#ifndef PHYSICS_LANES_H
#define PHYSICS_LANES_H

#include "model/state.h"
#include "physics/motion/motion.h"
#include "physics/system/work.h"

enum { LANES_MOST = 8, LANES_FREE = 2, LANES_BODIES = 8, LANES_PAIRS = 8, LANES_SLIDES = 2 };

/* Rows of a free disk: six columns of each coordinate (q, v, q2 ... q5), then those named here. */
enum {
  DISK_COLUMNS = 6,
  /* dt^2/2 over the mass or inertia, for each coordinate */
  DISK_GAIN = DISK_COLUMNS * SD_COORDINATES,
  /* dt^2/2 over the mass or inertia, times the constant force */
  DISK_PUSH = DISK_GAIN + SD_COORDINATES,
  DISK_ROWS = DISK_PUSH + SD_COORDINATES
};

/* Rows of a pair. */
#define PAIR_ROW(name, unit, meaning) PAIR_##name,
enum {
  /* the columns of the contact record (slipdisk/contact.h) */
  SD_CONTACT_RECORD(PAIR_ROW)
  /* more columns of the record; then 1 if the contact is closed, else 0 */
  SD_CONTACT_MORE(PAIR_ROW) PAIR_CLOSED,
  PAIR_SLIP, /* slip in the last step, a length; its sign is opposite to that of tau */
  PAIR_KN,
  PAIR_KT,
  PAIR_GAMMA,
  PAIR_CAP,
  PAIR_NORMAL, /* number of the normal force law */
  PAIR_TSUJI,  /* Tsuji damping: alpha sqrt(m_eff k_n), see law_tsuji */
  PAIR_LAW,    /* first of the rows for the members of law_row from `pulls` on */
  PAIR_LAW_LAST = PAIR_LAW + LAW_MORE - 1,
  PAIR_LIMIT, /* largest overlap that is allowed */
  PAIR_SUM,   /* R_a + R_b */
  PAIR_RA,
  PAIR_RB,
  PAIR_FX, /* force on b in the last step */
  PAIR_FY,
  PAIR_TAU,
  PAIR_COUPLE,
  PAIR_WAS_CLOSED, /* for rare events: 1 if the contact was closed before the step */
  PAIR_DROPPED,    /* for rare events: energy left in a contact that opened */
  PAIR_ROWS
};
#undef PAIR_ROW

/* Additional rows of a pair with a straight wall. */
enum {
  STRAIGHT_SIDE, /* side of the wall on which the disk is, +1 or -1; 0: the contact is open */
  /* start of the wall relative to its pivot; then tangent, length, and minus its extent before the
   * start */
  STRAIGHT_START_X,
  STRAIGHT_START_Y,
  STRAIGHT_TX,
  STRAIGHT_TY,
  STRAIGHT_LENGTH,
  STRAIGHT_BACK,
  STRAIGHT_TURN, /* torque about the wall's pivot in the last step */
  STRAIGHT_ROWS
};

/* Rows of a prescribed coordinate: its value, its velocity, and the contact force along it, in the
 * last step. */
enum { PLACE_LAST, PLACE_SPEED, PLACE_FORCE, PLACE_ROWS };

/* Rows of the visits of a watched pair of contacts; a visit is a time in one configuration
 * (model/state.h). */
enum {
  VISIT_ROW_CLASS = VISIT_SUMS, /* class of the visit under way; the rows of its sums come before */
  VISIT_ROW_LEFT,               /* steps until this part of the visit ends by age */
  VISIT_ROW_REFERENCE,
  VISIT_ROWS = VISIT_ROW_REFERENCE + 2
};

/* Index of the first row of each kind in lanes.memory. */
enum {
  ROWS_DISK,
  ROWS_PAIR = ROWS_DISK + DISK_ROWS * LANES_FREE,
  ROWS_PLACE = ROWS_PAIR + PAIR_ROWS * LANES_PAIRS,
  /* radius of the body in each slot */
  ROWS_RADIUS = ROWS_PLACE + PLACE_ROWS * SD_COORDINATES * LANES_BODIES,
  ROWS_DT = ROWS_RADIUS + LANES_BODIES,
  ROWS_PER_DT,
  ROWS_WORK,
  ROWS_LEAST, /* smallest force of each watched contact */
  /* squared speed beyond which each free disk is too fast */
  ROWS_FAST = ROWS_LEAST + 2 * LANES_SLIDES,
  ROWS_VISIT = ROWS_FAST + LANES_FREE,
  ROWS_STRAIGHT = ROWS_VISIT + VISIT_ROWS * LANES_SLIDES,
  ROWS_ALL = ROWS_STRAIGHT + STRAIGHT_ROWS * LANES_PAIRS
};

typedef struct lanes {
  size_t width, count; /* number of lanes, and of systems; lanes beyond `count` repeat system 0 */
  engine *system[LANES_MOST];
  unsigned dead; /* bit k: lane k had an error, and its state is stored */
  /* NULL: a single system uses its own motions, whose poses are not interleaved */
  pose_batch *motion;

  /* properties that all systems share */
  bool gear, conservative;
  unsigned features; /* features of all laws together (model/model.h) */
  size_t n_free, n_disks, n_bodies, n_pairs, n_slides;
  uint32_t a[LANES_PAIRS], b[LANES_PAIRS]; /* slots of each pair's bodies */
  size_t touching[LANES_BODIES];           /* number of pairs of each body */
  /* pairs of each body, in the order of the partners' slots: 2 * pair + (1 if the body is b) */
  uint8_t entry[LANES_BODIES][LANES_PAIRS];
  /* true: the partner is a straight wall, a line or a segment */
  bool straight[LANES_PAIRS], any_straight;
  bool placed[LANES_BODIES][SD_COORDINATES];
  uint8_t watched[2 * LANES_SLIDES]; /* pair of each watched contact */
  uint8_t watching[LANES_SLIDES];    /* slot of each watched disk */
  bool visits; /* true: sums over visits to configurations are measured (model/state.h) */

  /* pointers to the rows in `memory` */
  double *memory;
  /* rows of each kind; place: of each prescribed coordinate, in order */
  double *disk[LANES_FREE], *pair[LANES_PAIRS], *of_straight[LANES_PAIRS], *place;
  double *radius;                     /* radius of the body in each slot */
  double *dt, *per_dt, *work, *least; /* least: smallest force of each watched contact */
  const double *poses; /* poses of prescribed bodies, pose_batch_poses; NULL for a single system */
  /* Single system: poses of each prescribed body over a batch; they point to the values of a motion
   * or, for coordinates that do not move, to `still`. */
  const double *pose[LANES_BODIES][POSES];
  double still[LANES_BODIES][POSES][MOTION_BATCH];
  /* number of measured steps in each configuration of a watched disk, since the last store */
  int64_t count_of[LANES_SLIDES][16][LANES_MOST];

  /* variables of the present call of the kernel */
  int64_t from[LANES_MOST]; /* step of each system at the start of the call */
  int64_t at;               /* index of the last completed step in the batch of poses */
  int64_t done;             /* steps completed in this call */
  bool measure, dead_now;
  bool stepped; /* steps were taken since the rows were loaded; false: nothing to store */
  /* bit k: a rare event happened in lane k */
  unsigned rare[LANES_PAIRS], returns[LANES_FREE], fast;
} lanes;

/* Returns true if systems of this model can run in lanes: few bodies, walls that are round or
 * straight and do not turn if straight, an open box, and no rain, force fields, clumps, relaxation,
 * compression, loads, servos, removal of disks or means per disk. */
bool lanes_suit(const sd_model *m);
/* Returns true if two such models differ only in numbers, so that their systems can share a
 * vector. */
bool lanes_alike(const sd_model *a, const sd_model *b);
/* Returns true if two such systems are at the same point of their phases and motions. */
bool lanes_in_step(const engine *a, const engine *b);

/* Creates the rows for `count` systems of one thread each, which are alike and in step. alone: one
 * system with its own motions; else up to lane_width of the kernels. The rows are not loaded
 * yet. */
lanes *lanes_new(bool alone, size_t count, engine *const *system);
void lanes_free(lanes *l);
/* lanes_load fills the rows from the states and contact records of the systems, lanes_store writes
 * them back, except lanes with an error, whose states were stored when it happened. */
void lanes_load(lanes *l);
void lanes_store(lanes *l);

/* Computes prescribed coordinates ahead if necessary. Returns for how many steps they are known; 0:
 * the next step needs the general code. */
int64_t lanes_ready(lanes *l);
/* Takes n <= lanes_ready steps within a phase, or fewer if an error occurs in a lane: its
 * work.status is then set, and its state is that of the step in which it happened. Counts steps and
 * measured steps in the states. Rows must be loaded before, and stored after. Returns the number of
 * steps taken. */
int64_t lanes_take(lanes *l, int64_t n, bool measure);
/* Copies the angles to the states. */
void lanes_show_angles(const lanes *l);

/* Handles the rare events of the step that was just completed; the kernels call it. The rows are as
 * the step left them. */
void lanes_events(lanes *l);
/* Ends a part of the visit of watched pair w, in the lanes with bits set; the part ended before the
 * step just completed. The kernels call it. */
void lanes_visits(lanes *l, size_t w, unsigned bits);

#endif

/* lanes.h: small systems in lanes: few free disks among prescribed bodies, one system, or several alike ones side by
 * side in the lanes of vectors.
 *
 * The step is one function over rows of `width` numbers, one of each system (lanes_pass.h); a system that is alone
 * stands in both lanes of the narrowest vector. The text of contacts, predictor and corrector is that of the
 * general step, the sums run in the same order, and lanes do not mix: every bit is that of the general step (tests
 * compare).
 *
 * Every pair of a free disk and another body is a candidate all the time: for so few bodies that is cheaper than
 * looking after lists, and no lane can leave what they share. While lanes run, what a step changes lives in the rows;
 * lanes_store brings it to the states and to the contact memory of each system, lanes_load takes it back.
 */
#ifndef PHYSICS_LANES_H
#define PHYSICS_LANES_H

#include "model/visits.h"
#include "physics/motion/motion.h"
#include "physics/system/work.h"

enum { LANES_MOST = 8, LANES_FREE = 2, LANES_BODIES = 8, LANES_PAIRS = 8, LANES_SLIDES = 2 };

/* Rows of a free disk: six columns of each coordinate (q, v, q2 ... q5), then these. */
enum {
  DISK_COLUMNS = 6,
  DISK_GAIN = DISK_COLUMNS * SD_COORDINATES, /* dt^2/2 over the mass, by coordinate */
  DISK_PUSH = DISK_GAIN + SD_COORDINATES,    /* the same times the constant force */
  DISK_ROWS = DISK_PUSH + SD_COORDINATES
};

/* Rows of a pair. */
#define PAIR_ROW(name, unit, meaning) PAIR_##name,
enum {
  SD_CONTACT_RECORD(PAIR_ROW)            /* slipdisk/contact.h */
  SD_CONTACT_MORE(PAIR_ROW) PAIR_CLOSED, /* 1 or 0 */
  PAIR_SLIP,                             /* of the last step; its sign is opposite to tau's */
  PAIR_KN,
  PAIR_KT,
  PAIR_GAMMA,
  PAIR_CAP,
  PAIR_NORMAL, /* number of the law */
  PAIR_TSUJI,  /* alpha sqrt(m_eff k_n), law_tsuji */
  PAIR_LAW,    /* the numbers of law_row from `pulls` on */
  PAIR_LAW_LAST = PAIR_LAW + LAW_MORE - 1,
  PAIR_LIMIT, /* largest overlap */
  PAIR_SUM,   /* R_a + R_b */
  PAIR_RA,
  PAIR_RB,
  PAIR_FX, /* force of the last step */
  PAIR_FY,
  PAIR_TAU,
  PAIR_COUPLE,
  PAIR_WAS_CLOSED, /* rare events: before the step, */
  PAIR_DROPPED,    /* energy left in a contact that opened */
  PAIR_ROWS
};
#undef PAIR_ROW

/* Rows of a pair with a straight wall, besides. */
enum {
  STRAIGHT_SIDE, /* where the disk is, 0: open */
  STRAIGHT_START_X, /* its start from its pivot, tangent, length; how far it extends before the start, negative */
  STRAIGHT_START_Y,
  STRAIGHT_TX,
  STRAIGHT_TY,
  STRAIGHT_LENGTH,
  STRAIGHT_BACK,
  STRAIGHT_TURN, /* torque of the last step about the wall's pivot */
  STRAIGHT_ROWS
};

/* Rows of a prescribed coordinate. */
enum { PLACE_LAST, PLACE_SPEED, PLACE_FORCE, PLACE_ROWS };

/* Rows of the visits of a watched pair (model/visits.h). */
enum {
  VISIT_ROW_CLASS = VISIT_SUMS, /* of the visit under way; the sums of its part come first */
  VISIT_ROW_LEFT,               /* steps until the part ends by age */
  VISIT_ROW_REFERENCE,
  VISIT_ROWS = VISIT_ROW_REFERENCE + 2
};

/* Where rows stand. */
enum {
  ROWS_DISK,
  ROWS_PAIR = ROWS_DISK + DISK_ROWS * LANES_FREE,
  ROWS_PLACE = ROWS_PAIR + PAIR_ROWS * LANES_PAIRS,
  ROWS_RADIUS = ROWS_PLACE + PLACE_ROWS * SD_COORDINATES * LANES_BODIES, /* of each slot */
  ROWS_DT = ROWS_RADIUS + LANES_BODIES,
  ROWS_PER_DT,
  ROWS_WORK,
  ROWS_LEAST, /* force of each watched contact */
  ROWS_FAST =
      ROWS_LEAST + 2 * LANES_SLIDES, /* squared speed beyond which a free disk is too fast */
  ROWS_VISIT = ROWS_FAST + LANES_FREE,
  ROWS_STRAIGHT = ROWS_VISIT + VISIT_ROWS * LANES_SLIDES,
  ROWS_ALL = ROWS_STRAIGHT + STRAIGHT_ROWS * LANES_PAIRS
};

typedef struct lanes {
  size_t width, count; /* lanes, systems; lanes beyond repeat the first system */
  engine *system[LANES_MOST];
  unsigned dead;      /* bits: lanes that went wrong, whose states are stored */
  pose_batch *motion; /* NULL: those of the one system, poses standing one by one */

  /* what the systems share */
  bool gear, conservative;
  unsigned features; /* of all laws (model/laws.h) */
  size_t n_free, n_disks, n_bodies, n_pairs, n_slides;
  uint32_t a[LANES_PAIRS], b[LANES_PAIRS]; /* slots */
  size_t touching[LANES_BODIES]; /* pairs of each body, in order of the partners' keys: ... */
  uint8_t entry[LANES_BODIES][LANES_PAIRS]; /* ... 2 * pair + (1 if the body is b) */
  bool straight[LANES_PAIRS], any_straight; /* pairs with a line or segment */
  bool placed[LANES_BODIES][SD_COORDINATES];
  uint8_t watched[2 * LANES_SLIDES]; /* pairs */
  uint8_t watching[LANES_SLIDES];    /* slots of the watched disks */
  bool visits;                       /* to configurations are measured */

  /* rows */
  double *memory;
  double *disk[LANES_FREE], *pair[LANES_PAIRS], *of_straight[LANES_PAIRS],
      *place;                         /* place: of each that is placed, in order */
  double *radius;                     /* of each slot */
  double *dt, *per_dt, *work, *least; /* least: force of each watched contact */
  const double *poses;                /* pose_batch_poses */
  /* alone: values of the batch, or of a coordinate that does not move as often */
  const double *pose[LANES_BODIES][POSES];
  double still[LANES_BODIES][POSES][MOTION_BATCH];
  int64_t count_of[LANES_SLIDES][16]
                  [LANES_MOST]; /* measured steps by configuration, since the last store */

  /* of the present call of the kernel */
  int64_t from[LANES_MOST]; /* step of each system when it began */
  int64_t at;               /* the last completed step in the batch of poses */
  int64_t done;             /* steps completed */
  bool measure, dead_now;
  bool stepped; /* since the rows were loaded: else there is nothing to store */
  unsigned rare[LANES_PAIRS], returns[LANES_FREE],
      fast; /* bits: lanes in which something rare happened */
} lanes;

/* Can systems of this model go in lanes: few bodies, of straight walls lines and segments that do not turn, open box, neither rain nor relaxer,
 * compression, loads, servos, disks that are taken out or whose means are asked for? */
bool lanes_suit(const sd_model *m);
/* Do two such models differ in numbers only? */
bool lanes_alike(const sd_model *a, const sd_model *b);
/* Do two such systems stand at the same place of their phases and motions? */
bool lanes_in_step(const engine *a, const engine *b);

/* alone: one system, with its own motions; else up to the kernels' lane_width of them. Systems of one thread, alike and
 * in step; the rows are not loaded. */
lanes *lanes_new(bool alone, size_t count, engine *const *system);
void lanes_free(lanes *l);
/* Rows from the states and the contact memory of the systems, and back. What went wrong stays as it is. */
void lanes_load(lanes *l);
void lanes_store(lanes *l);

/* Is every prescribed coordinate computed ahead? Returns for how many steps; 0: the next one needs the general step. */
int64_t lanes_ready(lanes *l);
/* Takes n <= lanes_ready steps within a phase, or fewer when a lane goes wrong: then its work.status says so, and its
 * state is that of the step in which it happened. Steps and measured steps of the states are counted on. Rows must be
 * loaded, and are to be stored. Returns the steps that were taken. */
int64_t lanes_take(lanes *l, int64_t n, bool measure);
/* Brings the angles to the states. */
void lanes_show_angles(const lanes *l);

/* From within the kernels: rare events of the step that was completed. The rows are as it left them. */
void lanes_events(lanes *l);
/* In the lanes of these bits a part of the visit of watched pair w ended before the step that was completed. */
void lanes_visits(lanes *l, size_t w, unsigned bits);

#endif

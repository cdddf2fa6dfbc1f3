/* lanes.h: runs small systems in SIMD lanes. A small system has a few free disks among prescribed
 * bodies; one system runs alone, or several similar ones run side by side, one in each lane of the
 * vectors.
 *
 * All variables are rows of `width` numbers, one number per system, and the whole step is one
 * function (lanes_pass.h). A single system fills both lanes of a vector of two. The code of
 * contacts, predictor and corrector is that of the general step, sums are formed in the same order,
 * and lanes never exchange numbers. So results have the same bits as those of the general step
 * (tests compare them).
 *
 * Every pair of a free disk and another body is a candidate at all times: for so few bodies this is
 * cheaper than neighbour lists, and no lane can make a list stale that others use, too. While
 * systems run in lanes, the variables that a step changes are in the rows; lanes_store copies them
 * to the state and contact records of each system, lanes_load copies them back.
 */
#ifndef PHYSICS_LANES_H
#define PHYSICS_LANES_H

#include "model/state.h"
#include "physics/motion/motion.h"
#include "physics/system/work.h"

enum { LANES_MOST = 8, LANES_FREE = 2, LANES_BODIES = 8, LANES_PAIRS = 8, LANES_SLIDES = 2 };

/* Rows of each free disk: six columns for each coordinate (q, v, q2 ... q5), then the rows named
 * here. */
enum {
  DISK_COLUMNS = 6,
  /* dt^2/2 divided by the mass or moment of inertia, for each coordinate */
  DISK_GAIN = DISK_COLUMNS * SD_COORDINATES,
  /* dt^2/2 divided by the mass or moment of inertia, times the constant force (or torque), for each
   * coordinate */
  DISK_PUSH = DISK_GAIN + SD_COORDINATES,
  DISK_ROWS = DISK_PUSH + SD_COORDINATES
};

/* Rows of each pair. The names of rows of the contact record are made from those of its columns. */
#define PAIR_ROW(name, ...) PAIR_##name,
enum {
  /* rows for the columns of the contact record (slipdisk/contact.h) */
  SD_CONTACT_RECORD(PAIR_ROW)
  /* further columns of the record, for general contact laws; PAIR_CLOSED: 1 if the contact is
   * closed, else 0 */
  SD_CONTACT_MORE(PAIR_ROW) PAIR_CLOSED,
  PAIR_SLIP, /* tangential slip in the last step, a length; its sign is opposite to that of tau */
  PAIR_KN,
  PAIR_KT,
  PAIR_GAMMA,
  PAIR_CAP,
  PAIR_NORMAL, /* number of the normal force law (model/normal_laws.h) */
  PAIR_TSUJI,  /* damping coefficient of Tsuji's law: alpha sqrt(m_eff k_n); see law_tsuji */
  /* first of LAW_MORE rows: members of law_row from `pulls` on, the constants of general contact
   * laws */
  PAIR_LAW,
  PAIR_LAW_LAST = PAIR_LAW + LAW_MORE - 1,
  PAIR_LIMIT, /* largest overlap that the model allows for this pair */
  PAIR_SUM,   /* R_a + R_b */
  PAIR_RA,
  PAIR_RB,
  PAIR_FX, /* force on body b in the last step, x component */
  PAIR_FY,
  PAIR_TAU,
  PAIR_COUPLE,
  /* for handling rare events: 1 if the contact was closed before the step, else 0 */
  PAIR_WAS_CLOSED,
  PAIR_DROPPED, /* for handling rare events: elastic energy left in a contact that opened */
  PAIR_ROWS
};
#undef PAIR_ROW

/* Further rows of each pair with a straight wall. */
enum {
  /* side of the wall on which the disk is: +1 left of its tangent, -1 right; 0 if the contact is
   * open */
  STRAIGHT_SIDE,
  /* start of the wall relative to its pivot; the rows below: its unit tangent, its length, and the
   * least coordinate along the tangent (0, or -infinity for an infinite line) */
  STRAIGHT_START_X,
  STRAIGHT_START_Y,
  STRAIGHT_TX,
  STRAIGHT_TY,
  STRAIGHT_LENGTH,
  STRAIGHT_BACK,
  STRAIGHT_TURN, /* torque on the wall about its pivot, in the last step */
  STRAIGHT_ROWS
};

/* Rows of each prescribed coordinate, as of the last step: its value, its velocity, and the contact
 * force along it. */
enum { PLACE_LAST, PLACE_SPEED, PLACE_FORCE, PLACE_ROWS };

/* Rows of each watched pair of contacts, for statistics of visits. A visit is a period of
 * consecutive steps in which the two contacts stay in the same configuration (stuck, sliding or
 * open; model/state.h). */
enum {
  /* class of the present visit, a number (visits_class); the first VISIT_SUMS rows are sums over
   * the visit */
  VISIT_ROW_CLASS = VISIT_SUMS,
  /* number of steps until this part of the visit ends because of its age */
  VISIT_ROW_LEFT,
  VISIT_ROW_REFERENCE,
  VISIT_ROWS = VISIT_ROW_REFERENCE + 2
};

/* Index in lanes.memory of the first row of each kind. */
enum {
  ROWS_DISK,
  ROWS_PAIR = ROWS_DISK + DISK_ROWS * LANES_FREE,
  ROWS_PLACE = ROWS_PAIR + PAIR_ROWS * LANES_PAIRS,
  /* radius of the body in each slot, one row per body */
  ROWS_RADIUS = ROWS_PLACE + PLACE_ROWS * SD_COORDINATES * LANES_BODIES,
  ROWS_DT = ROWS_RADIUS + LANES_BODIES,
  ROWS_PER_DT,
  ROWS_WORK,
  ROWS_LEAST, /* smallest normal force so far in each watched contact */
  /* squared speed above which each free disk exceeds the displacement limit */
  ROWS_FAST = ROWS_LEAST + 2 * LANES_SLIDES,
  ROWS_VISIT = ROWS_FAST + LANES_FREE,
  ROWS_STRAIGHT = ROWS_VISIT + VISIT_ROWS * LANES_SLIDES,
  ROWS_ALL = ROWS_STRAIGHT + STRAIGHT_ROWS * LANES_PAIRS
};

typedef struct lanes {
  /* number of lanes; number of systems: lanes from `count` on repeat system 0 */
  size_t width, count;
  engine *system[LANES_MOST];
  /* bit k is set if lane k has had an error; the state of its system is then already stored */
  unsigned dead;
  /* poses of all systems, computed together; NULL for a single system, which uses its own
   * motions */
  pose_batch *motion;

  /* The following properties are the same for all systems. */
  bool gear, conservative;
  unsigned features; /* LAW_ bits of all contact laws (model/law_features.h) */
  size_t n_free, n_disks, n_bodies, n_pairs, n_slides;
  uint32_t a[LANES_PAIRS], b[LANES_PAIRS]; /* slots of the two bodies of each pair */
  size_t touching[LANES_BODIES];           /* number of pairs of each body, by slot */
  /* pairs of each body, in the order of the partners' slots: 2 * pair, + 1 if the body is b of this
   * pair */
  uint8_t entry[LANES_BODIES][LANES_PAIRS];
  /* straight: true for pairs with a straight wall (a line or segment); any_straight: true if there
   * is one */
  bool straight[LANES_PAIRS], any_straight;
  bool placed[LANES_BODIES][SD_COORDINATES];
  /* index of the pair of each watched contact (one whose statistics the model asks for); two per
   * watched disk */
  uint8_t watched[2 * LANES_SLIDES];
  uint8_t watching[LANES_SLIDES]; /* slot of each watched disk (one with two watched contacts) */
  bool visits;                    /* true: visits to configurations are measured (model/state.h) */

  /* all rows; the pointers below point into it */
  double *memory;
  /* rows of each free disk, of each pair, of each pair with a straight wall, and of the prescribed
   * coordinates (by slot, then coordinate) */
  double *disk[LANES_FREE], *pair[LANES_PAIRS], *of_straight[LANES_PAIRS], *place;
  double *radius; /* radius of the body in each slot, one row per body */
  /* rows of the time step and its inverse, of the work of prescribed motions, and of the smallest
   * normal force of each watched contact */
  double *dt, *per_dt, *work, *least;
  /* poses of prescribed bodies in all systems (pose_batch_poses); NULL for a single system */
  const double *poses;
  /* For a single system: poses of each prescribed body, for MOTION_BATCH steps ahead. The pointers
   * lead to the values that a motion computed or, for coordinates that do not move, to `still`. */
  const double *pose[LANES_BODIES][POSES];
  double still[LANES_BODIES][POSES][MOTION_BATCH];
  /* number of measured steps since the last lanes_store: [watched disk][configuration of its
   * contacts][lane] */
  int64_t count_of[LANES_SLIDES][16][LANES_MOST];

  /* The following variables belong to the present call of the kernel. */
  int64_t from[LANES_MOST]; /* number of completed steps of each system when the call began */
  int64_t at;               /* index in the batch of poses of the last completed step */
  int64_t done;             /* number of steps completed in this call */
  bool measure, dead_now;
  /* true: steps were taken since the rows were loaded; false: there is nothing to store */
  bool stepped;
  /* bit k of each: in lane k the contact had a rare event (rare), the disk's angle must be wrapped
   * (returns), a disk is too fast (fast) */
  unsigned rare[LANES_PAIRS], returns[LANES_FREE], fast;
} lanes;

/* Returns true if systems of this model can run in lanes. They need few bodies, an open box, and
 * only round walls and straight walls that do not turn. They must have no rain, force fields,
 * clumps, relaxation, compression, loads, servos, removal of disks or means per disk. */
bool lanes_suit(const sd_model *m);
/* Returns true if two such models have the same bodies, motions and phases and differ only in the
 * values of parameters, so that their systems can share a vector. */
bool lanes_alike(const sd_model *a, const sd_model *b);
/* Returns true if two such systems are in the same phase, at the same step of all their motions. */
bool lanes_in_step(const engine *a, const engine *b);

/* Creates the rows for `count` systems of one thread each, for which lanes_alike and lanes_in_step
 * hold. alone: true for one system with its own motions; false for up to lane_width (of the
 * kernels) systems. The rows are not filled yet. */
lanes *lanes_new(bool alone, size_t count, engine *const *system);
void lanes_free(lanes *l);
/* lanes_load fills the rows from the states and contact records of the systems; lanes_store copies
 * the rows back. Systems with an error are not stored again: their states were stored when it
 * happened. */
void lanes_load(lanes *l);
void lanes_store(lanes *l);

/* Computes prescribed coordinates ahead, if none are left. Returns for how many further steps they
 * are known; 0: the next step must be taken by the general code. */
int64_t lanes_ready(lanes *l);
/* Takes n steps within one phase, n <= lanes_ready(). Ends earlier if there is an error in a lane:
 * work.status of that system is then set, and its state is that of the step with the error. Adds
 * the steps to the step counters in the states. Call lanes_load before, and lanes_store after.
 * Returns the number of steps taken. */
int64_t lanes_take(lanes *l, int64_t n, bool measure);
/* Copies the present angles of all bodies to the states of their systems, and nothing else. */
void lanes_show_angles(const lanes *l);

/* Handles the rare events of the step that was just completed (contacts that began or ended, angles
 * to be wrapped, disks that are too fast). The kernels call it, after they have stored their
 * registers in the rows. */
void lanes_events(lanes *l);
/* Ends the present part of the visit of watched pair w, in the lanes whose bit is set; the part
 * ends before the step that was just completed. The kernels call it. */
void lanes_visits(lanes *l, size_t w, unsigned bits);

#endif

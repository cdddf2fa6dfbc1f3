/* theory.h: the 3-disk ratchet as found in a deck (one free disk on two driven ones, its supports),
 * and the predictions of the theory (include/slipdisk/theory.h) for it.
 *
 * theory_case_read finds the free disk and its two supports, and how the supports are driven in the
 * phases that measure; theory_case_solve evaluates the formulas that apply. Numbers that several of
 * the outputs (text, JSON, CSV) show have a row in theory_facts. Contact 1 is the left
 * one, seen with gravity pointing down, contact 2 the right one, whatever their order in the deck.
 */
#ifndef SLIPDISK_APP_THEORY_H
#define SLIPDISK_APP_THEORY_H

#include <stdio.h>

#include "io/deck/deck.h"
#include "measure/observable.h"
#include "slipdisk/model.h"
#include "slipdisk/theory.h"

typedef enum theory_kind {
  /* The supports do not move in phases that measure */
  THEORY_REST,
  /* Both supports turn at constant velocities, one of which may be 0 */
  THEORY_STEADY,
  /* Both supports oscillate with one frequency and waveform; one may be at rest */
  THEORY_PERIODIC,
  /* Random vibration of any coordinates of the supports */
  THEORY_RANDOM
} theory_kind;

typedef enum theory_relation {
  THEORY_OTHER_PHASE,
  THEORY_IN_PHASE,
  THEORY_OPPOSITE
} theory_relation;

typedef struct theory_case {
  /* Names of the upper disk and of the two supports */
  char upper[64], support[2][64];
  sd_three_disk disk;
  /* Angles alpha_1 and alpha_2 between gravity and the directions to the left and right contact,
   * rad, at the position where the upper disk just touches both supports */
  double alpha[2];
  double mass;
  double t_g; /* Time unit sqrt(2 R/g) of the upper disk, with its radius R and g = weight/mass */
  /* Distance between the position of the upper disk in the deck and the position where it just
   * touches both supports */
  double offset;
  double support_radius[2];
  double k_t[2];    /* Tangential stiffness k_t of the left and of the right contact */
  double stiffness; /* Smaller normal stiffness k_n of the two contacts */
  /* True if the deck names the right support first; then the configuration called S+- in the deck's
   * order is S-+ here */
  bool swapped;
  bool locked; /* True if the deck forbids the upper disk to rotate */
  double spin; /* Angular velocity of the upper disk at the start */

  theory_kind kind;
  double velocity[2]; /* Steady drive: angular velocities of the left and of the right support */
  /* Random drive: true if one random signal turns both supports, and nothing else moves them */
  bool shared;
  /* Periodic drive of both supports; its time t = 0 is when the motion of the left support begins,
   * or that of the right one if the left one is at rest */
  sd_drive drive;

  /* --- results of theory_case_solve; NAN: a number does not apply ----------------------------- */
  /* Equilibrium points of the four sliding configurations, indexed by SD_PP ... SD_MM */
  sd_tep tep[4];
  /* Torque on the upper disk in each sliding configuration, equations (15)-(18) of the paper,
   * indexed by SD_PP ... SD_MM */
  double torque[4];
  /* Mean torque just after tilting if all four configurations last equally long, equation (19) of
   * the paper */
  double slight;
  /* Mean torque just after tilting if only S++ and S-- occur, equation (31) of the paper,
   * corrected: with mu^2 where the paper has mu */
  double sync;
  /* Phase between equal supports at which the sense of rotation reverses; NAN: there is none */
  double reversal;
  /* Random drive: sign of the mean torque just after tilting */
  int sense;
  /* Steady drive: at the start, signs of the torques that the left and the right contact exert on
   * the upper disk; 0: the contact sticks */
  int signs[2];
  double start_torque; /* Steady drive: torque at the start; NAN: a contact sticks */
  /* Steady drive: final angular velocity of the upper disk; NAN: the disk cannot rotate, or any
   * value in a range is possible */
  double final_spin;

  /* All members from here on are for periodic drive; they are NAN if a formula does not apply. */
  theory_relation relation;
  /* True if the surfaces of both supports move with the same amplitude; only then do closed
   * formulas apply */
  bool even;
  double apart; /* Phase of support 2 (right) minus phase of support 1 (left), in (-pi, pi] */
  /* Amplitude Theta_b: the larger of Theta_i R_i/R for the two supports i, with their amplitudes
   * Theta_i and radii R_i */
  double amplitude;
  /* Largest |torque|/(I Theta_b w_b^2) of the configurations, with the moment of inertia I and the
   * angular frequency w_b */
  double ratio;
  /* Results of equations (25)-(29) of the paper; only for parabolic waves in phase */
  sd_sync parabola;
  /* Mean angular velocity to first order: equation (30) of the paper in phase, (35) in opposite
   * phase; multiplied by pi^2/8 for sines */
  double first_order;
  /* Mean angular velocity by a closed formula that holds at this amplitude; only for sines in
   * phase */
  double sine;
  double limit;        /* Mean angular velocity in the limit Theta_b -> infinity */
  bool solved;         /* True if a periodic state was found numerically */
  sd_sliding solution; /* Periodic state; mean and period are NAN if `solved` is false */
  /* Mean angular velocity times t_g, and divided by Theta_b w_b; fractions of the period in each
   * configuration and with sticking contacts; 1: contacts never stick, 0: they do. NAN: no periodic
   * state */
  double mean_scaled, mean_normalised, fraction[4], stuck, permanent;
} theory_case;

/* Names "++", "+-", "-+", "--" of the sliding configurations, indexed by SD_PP ... SD_MM */
extern const char *const theory_configurations[4];
/* Returns the name of the configuration with these signs of sliding; NULL: a contact sticks. */
const char *theory_configuration(const int sign[2]);

/* --- theory_case.c, theory_solve.c: the case and its solution --------------------------------- */
/* Finds the three disks and their drive in a model. SD_ERROR_USER: the deck is not such a case;
 * messages say what it has and what is expected. */
sd_status theory_case_read(const sd_model *m, theory_case *c, sd_messages *messages);
/* Reads the drive of the supports: the part of theory_case_read about motions. upper, support:
 * numbers of the disks. */
sd_status theory_drive_read(const sd_model *m, uint32_t upper, const uint32_t support[2],
                            theory_case *c, sd_messages *messages);
/* Evaluates all formulas that apply, and stores the results in c. After an error of
 * sd_sliding_solve (SD_ERROR_USER, SD_ERROR_NUMERIC) the other results are stored all the same. */
sd_status theory_case_solve(theory_case *c, sd_messages *messages);

/* --- theory_facts.c: the numbers, as JSON and as CSV ------------------------------------------ */
/* Numbers of a theory_case, in the order of CSV columns. `name` is "group.name" in JSON; the groups
 * steady, random and periodic hold the members of "drive". `meaning` is the label in text, `column`
 * the name in CSV. */
extern const observable_list theory_facts;
bool theory_json(FILE *out, const sd_model *m, const theory_case *c);
void theory_table_head(FILE *out, const deck_sweep *s);
void theory_table_row(FILE *out, const deck_sweep *s, size_t point, const theory_case *c);
/* Writes one period of the periodic state c->solution as CSV; c->solved must be true. */
void theory_wave(FILE *out, const theory_case *c);

/* --- theory.c: output as text ----------------------------------------------------------------- */
void theory_page(FILE *out, const sd_model *m, const theory_case *c);

#endif

/* theory.h: the 3-disk ratchet as found in a deck, and what the theory
 * (include/slipdisk/theory.h) gives for it.
 *
 * theory_case_read finds one free disk on two supports, and how the supports are driven in the
 * phases that measure; theory_case_solve evaluates the formulas that apply. Contact 1 is the left
 * one, seen with gravity pointing down, contact 2 the right one, whatever their order in the
 * deck. */
#ifndef SLIPDISK_APP_THEORY_H
#define SLIPDISK_APP_THEORY_H

#include <stdio.h>

#include "io/deck/deck.h"
#include "model/model.h"
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
  /* Angles alpha_1 and alpha_2 of the contacts, rad, if the upper disk just touches both
   * supports */
  double alpha[2];
  double mass;
  double t_g; /* sqrt(2 R/g), with g = weight/mass */
  /* Distance of the upper disk in the deck from where it just touches both supports */
  double offset;
  double support_radius[2];
  double k_t[2];    /* Tangential stiffness k_t of each contact */
  double stiffness; /* Smaller normal stiffness k_n of the two contacts */
  /* True if the deck names the right support first: its S+- is S-+ here */
  bool swapped;
  bool locked; /* True if the upper disk cannot turn */
  double spin; /* Angular velocity of the upper disk at the start */

  theory_kind kind;
  double velocity[2]; /* Steady drive: angular velocities of the supports */
  /* Random drive: true if one signal turns both supports, and nothing else moves them */
  bool shared;
  /* Periodic drive; t = 0 when the motion of the left support begins (of the right one if the
   * left one is at rest) */
  sd_drive drive;
} theory_case;

typedef struct theory_result {
  sd_tep tep[4];    /* Equilibrium points, indexed by SD_PP ... SD_MM */
  double torque[4]; /* Torques (15)-(18), indexed by SD_PP ... SD_MM */
  /* Mean torque just after tilting, all four configurations equally long (19) */
  double slight;
  /* Mean torque just after tilting, S++ and S-- only (31), corrected: mu^2 where the paper has
   * mu */
  double sync;
  /* Steady drive: signs of the torques at the contacts at the start; 0: the contact sticks */
  int signs[2];
  /* Steady drive: final angular velocity of the upper disk; NAN: it cannot turn, or any value of a
   * range is possible */
  double final_spin;

  /* Members for periodic drive; NAN if a formula does not apply. */
  theory_relation relation;
  /* True if the surfaces of both supports move with the same amplitude, so that closed forms
   * apply */
  bool even;
  double apart;     /* Phase of support 2 minus phase of support 1, in (-pi, pi] */
  double amplitude; /* Theta_b: the larger of Theta_i R_i/R */
  double ratio;     /* Largest |torque|/(I Theta_b w_b^2) */
  sd_sync parabola; /* Results of (25)-(29); parabolas in phase only */
  /* Mean angular velocity: (30) in phase, (35) in opposite phases; times pi^2/8 for sines */
  double first_order;
  /* Mean angular velocity: closed form at this amplitude; sines in phase only */
  double sine;
  double limit;        /* Mean angular velocity for Theta_b -> infinity */
  bool solved;         /* True if a periodic state was found */
  sd_sliding solution; /* Periodic state, if solved */
} theory_result;

/* Names "++", "+-", "-+", "--", indexed by SD_PP ... SD_MM */
extern const char *const theory_configurations[4];

/* --- theory_case.c, theory_solve.c: the case and its solution --------------------------------- */
/* Reads the case from a model. SD_ERROR_USER: the deck is something else; messages say what it
 * has and what is expected. */
sd_status theory_case_read(const sd_model *m, theory_case *c, sd_messages *messages);
/* Reads the drive: the part of theory_case_read about the motions of the disks with these
 * numbers. */
sd_status theory_drive_read(const sd_model *m, uint32_t upper, const uint32_t support[2],
                            theory_case *c, sd_messages *messages);
/* Evaluates all formulas that apply. Fills all of r that is known also after an error:
 * SD_ERROR_USER or SD_ERROR_NUMERIC of sd_sliding_solve. */
sd_status theory_case_solve(const theory_case *c, theory_result *r, sd_messages *messages);

/* --- theory.c: output as text and as JSON ----------------------------------------------------- */
void theory_page(FILE *out, const sd_model *m, const theory_case *c, const theory_result *r);
bool theory_json(FILE *out, const sd_model *m, const theory_case *c, const theory_result *r);

/* --- theory_solve.c: tables as CSV ------------------------------------------------------------ */
void theory_table_head(FILE *out, const deck_sweep *s);
void theory_table_row(FILE *out, const deck_sweep *s, size_t point, const theory_case *c,
                      const theory_result *r);
/* Writes one period of r->solution as CSV; r->solved must be true. */
void theory_wave(FILE *out, const theory_result *r);

#endif

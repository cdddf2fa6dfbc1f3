/* theory.h: the 3-disk ratchet as it is found in a deck, and what include/slipdisk/theory.h says of it.
 *
 * theory_case_read finds one free disk on two supports, and how the supports are driven in the phases that
 * measure; theory_case_solve evaluates the formulas that apply to it. Contact 1 is the left one, seen with
 * gravity pointing down, contact 2 the right one, whatever their order in the deck.
 */
#ifndef SLIPDISK_APP_THEORY_H
#define SLIPDISK_APP_THEORY_H

#include <stdio.h>

#include "io/deck/deck.h"
#include "model/model.h"
#include "slipdisk/theory.h"

typedef enum theory_kind {
  THEORY_REST,     /* nothing moves the supports while it is measured */
  THEORY_STEADY,   /* both turn at constant velocities, one of which may be 0 */
  THEORY_PERIODIC, /* both turn to and fro with one frequency and waveform; one may be at rest */
  THEORY_RANDOM    /* random vibration, of any coordinates */
} theory_kind;

typedef enum theory_relation {
  THEORY_OTHER_PHASE,
  THEORY_IN_PHASE,
  THEORY_OPPOSITE
} theory_relation;

typedef struct theory_case {
  char upper[64], support[2][64]; /* names */
  sd_three_disk disk;
  double alpha[2]; /* rad; of the three disks where they just touch */
  double mass;
  double t_g; /* sqrt(2 R/g), g = weight/mass */
  double
      offset; /* from where the deck puts the upper disk to where it just touches both supports */
  double support_radius[2];
  double k_t[2];    /* stiffness k_t of each contact */
  double stiffness; /* the smaller k_n */
  bool swapped;     /* the deck names the right support first: its S+- is S-+ here */
  bool locked;      /* the upper disk cannot turn */
  double spin;      /* of the upper disk at the start */

  theory_kind kind;
  double velocity[2]; /* steady: of the supports' angles */
  bool shared;        /* random: both supports turn by one signal, and do nothing else */
  sd_drive
      drive; /* periodic; t = 0 when the left support's motion is switched on (else the right one's) */
} theory_case;

typedef struct theory_result {
  sd_tep tep[4];    /* by SD_PP ... */
  double torque[4]; /* (15)-(18) */
  double slight;    /* (19) */
  double sync;      /* (31), corrected */
  int signs[2];     /* steady: of the torques at the start; 0: this contact sticks */
  double
      final_spin; /* steady: angular velocity at which a free disk ends; NAN: it can be any of a range */

  /* periodic; NAN where a formula does not apply */
  theory_relation relation;
  bool even;          /* both supports' surfaces move with the same amplitude: closed forms apply */
  double apart;       /* phase of support 2 - phase of support 1, in (-pi, pi] */
  double amplitude;   /* Theta_b: the larger of Theta_i R_i/R */
  double ratio;       /* largest |torque|/(I Theta_b w_b^2) */
  sd_sync parabola;   /* (25)-(29); in phase, parabola */
  double first_order; /* (30) in phase, (35) in opposite phases; times pi^2/8 for sines */
  double sine;        /* in phase, sine: closed form at this amplitude */
  double limit;       /* Theta_b -> infinity */
  bool solved;        /* there is a periodic state */
  sd_sliding solution; /* of which this is */
} theory_result;

extern const char *const theory_configurations[4]; /* "++" ... by SD_PP ... */

/* --- theory_case.c, theory_solve.c ------------------------------------------------------------ */
/* SD_ERROR_USER: the deck is something else; messages say what and what is expected. */
sd_status theory_case_read(const sd_model *m, theory_case *c, sd_messages *messages);
/* The part of it that concerns the motions of the disks with these numbers. */
sd_status theory_drive_read(const sd_model *m, uint32_t upper, const uint32_t support[2],
                            theory_case *c, sd_messages *messages);
/* Fills all of r that applies, also when it fails: SD_ERROR_USER, SD_ERROR_NUMERIC of sd_sliding_solve. */
sd_status theory_case_solve(const theory_case *c, theory_result *r, sd_messages *messages);

/* --- The page, for people and for programs ------------------------------------------------------- */
void theory_page(FILE *out, const sd_model *m, const theory_case *c, const theory_result *r);
bool theory_json(FILE *out, const sd_model *m, const theory_case *c, const theory_result *r);

/* --- theory_solve.c: tables as CSV ------------------------------------------------------------ */
void theory_table_head(FILE *out, const deck_sweep *s);
void theory_table_row(FILE *out, const deck_sweep *s, size_t point, const theory_case *c,
                      const theory_result *r);
/* One period of r->solution, which must be there. */
void theory_wave(FILE *out, const theory_result *r);

#endif

/* check.h: what `check` finds about a deck, and its output as text and JSON. */
#ifndef SLIPDISK_APP_CHECK_H
#define SLIPDISK_APP_CHECK_H

#include "app/app.h"
#include "model/advice.h"
#include "slipdisk/model.h"

/* Estimates for all points (runs) of a sweep. */
typedef struct check_sweep {
  /* Number of points, number of different sets of parameter values; 0 points: no sweep */
  size_t points, sets;
  size_t together; /* Number of points that can share SIMD lanes with others */
  size_t width;    /* Largest number of systems that run side by side in SIMD lanes */
  double steps;    /* Largest possible number of steps, summed over all points of the sweep */
  double seconds;  /* Wall time of the sweep with one worker process, s; NAN: not known */
  bool lanes;      /* True if `seconds` assumes that systems run side by side in SIMD lanes */
} check_sweep;

typedef struct check_found {
  const sd_model *model;
  first_overlap overlap;
  result_size size;
  bool probed;     /* True if a simulation of the deck was made, to count its contacts */
  size_t contacts; /* Number of contacts at the start, if probed is true */
  /* Number of steps on which the speed was measured; 0: it was not measured */
  int64_t tried;
  double speed; /* Measured number of steps per second of wall time */
  int threads;
  char path[40]; /* Instruction set of the kernels, such as "avx2" */
  check_sweep sweep;
} check_found;

/* --- check_impact.c --------------------------------------------------------------------------- */
/* Computes with the model's integrator which coefficients of restitution a linear law has at the
 * model's time step, for this effective mass. range: the least and the largest e of head-on impacts
 * that touch at different fractions of a step; NAN if an impact takes so many steps that they agree
 * with the law to 1e-3. */
void check_restitution_at_dt(const sd_model *m, const sd_contact_law *law, double mass,
                             double range[2]);

/* --- check_print.c ---------------------------------------------------------------------------- */
void check_print(const check_found *found);
/* Prints the findings as JSON. found->model NULL: the deck has mistakes. full: the full deck is
 * included. Returns `status`, or SD_ERROR_IO, after a message, if it cannot be printed. */
int check_print_json(const check_found *found, const char *deck, bool full, int status,
                     const sd_messages *messages);

#endif

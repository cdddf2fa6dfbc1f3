/* check.h: what `check` finds about a deck, for its page and for JSON. */
#ifndef SLIPDISK_APP_CHECK_H
#define SLIPDISK_APP_CHECK_H

#include "app/app.h"
#include "model/advice.h"
#include "model/model.h"

/* All points of a sweep. */
typedef struct check_sweep {
  size_t points, sets; /* 0 points: the deck has no sweep */
  size_t together;     /* points that can go in lanes */
  size_t width;        /* systems side by side */
  double steps;        /* of all points, at most */
  double seconds;      /* with one worker; NAN: not known */
  bool lanes;          /* the time is that in lanes */
} check_sweep;

typedef struct check_found {
  const sd_model *model;
  first_overlap overlap;
  result_size size;
  bool probed;     /* a simulation was made ... */
  size_t contacts; /* ... and has these at the start */
  int64_t tried;   /* steps on which the speed was measured; 0: it was not */
  double speed;    /* steps per second */
  int threads;
  char path[40]; /* instruction set */
  check_sweep sweep;
} check_found;

/* --- check_print.c --------------------------------------------------------------------- */
void check_print(const check_found *found);
/* model NULL: the deck has mistakes. full: with the full deck. Returns `status`; SD_ERROR_IO: it
 * cannot be printed, which was told. */
int check_print_json(const check_found *found, const char *deck, bool full, int status,
                     const sd_messages *messages);

#endif

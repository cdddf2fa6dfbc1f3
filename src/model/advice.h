/* advice.h: what a model may say and its author seldom means: warnings, and the error of a time step that is too long.
 *
 * A check is a function and a row of advice_checks in advice.c. */
#ifndef SLIPDISK_MODEL_ADVICE_H
#define SLIPDISK_MODEL_ADVICE_H

#include "base/comm.h"
#include "model/model.h"

/* Adds its warnings, the worst first; how bad that is: 0, there are none. Comparable among models, not among checks. */
typedef double advice_check(const sd_model *model, sd_messages *messages);
/* Of the fields; advice_fields.c. */
advice_check advice_fields;
/* Warns of motions; advice_bodies.c. */
advice_check advice_motions;
/* Warns of prescribed bodies that overlap; advice_bodies.c. */
advice_check advice_prescribed;
/* Warns of walls that meet; advice_bodies.c. */
advice_check advice_joints;
extern advice_check *const advice_checks[];
extern const size_t advice_count;

/* The text of the mistake, to be freed, when dt is beyond the limit of stability and the model does not ask for it; else
 * NULL. */
char *advice_unstable(const sd_model *model);

/* The first motion that begins with a jump, and what to do, to be freed; NULL: none does. */
char *advice_first_jump(const sd_model *model);

/* Why a run may have failed: dt near its limit, or else as asked, "is k_n too small?"; in text[size]. */
const char *advice_of_failure(const sd_model *model, const char *otherwise, char *text,
                              size_t size);

/* The deepest overlap at the start of two bodies of which one is free to move, over the radius of the smaller disk; without
 * contacts that the model begins with. depth 0: none. */
typedef struct first_overlap {
  uint32_t a, b; /* body numbers */
  double depth, relative;
  double force;  /* normal, elastic */
  double weight; /* of the lighter free one; 0: no gravity */
} first_overlap;
sd_status advice_overlap(const sd_model *model, first_overlap *worst);
/* Collective. The deepest of all ranks; of equal ones that of the first rank. */
void advice_share_overlap(const comm *c, first_overlap *worst);
/* The warning, where it is deep; what an advice_check returns. */
double advice_tell_overlap(const sd_model *model, const first_overlap *worst,
                           sd_messages *messages);

#endif

/* advice.h: warnings about set-ups that are valid but seldom intended, and the error text for a
 * time step beyond the stability limit.
 *
 * Each check is a function that is listed in the table advice_checks in advice.c.
 */
#ifndef SLIPDISK_MODEL_ADVICE_H
#define SLIPDISK_MODEL_ADVICE_H

#include "base/comm.h"
#include "slipdisk/model.h"

/* Checks a model: adds warnings to `messages`, the most severe first, and returns the severity;
 * 0: no warning. Severities of the same check can be compared between models, those of different
 * checks cannot. */
typedef double advice_check(const sd_model *model, sd_messages *messages);
/* Warns about force fields, and about disks that fall without end (advice_bodies.c). */
advice_check advice_fields;
/* Warns about prescribed motions that jump, move too far in a step or oscillate too fast for dt
 * (advice_bodies.c). */
advice_check advice_motions;
/* Warns about bodies with prescribed positions that overlap each other (advice_bodies.c). */
advice_check advice_prescribed;
/* Warns about walls that meet where both would push the same disk (advice_bodies.c). */
advice_check advice_joints;
/* Table of all checks that give warnings; advice_count is their number. */
extern advice_check *const advice_checks[];
extern const size_t advice_count;

/* Returns the error text if dt is beyond the stability limit and limits.unstable_step does not
 * allow that, else NULL. The caller frees it. */
char *advice_unstable(const sd_model *model);

/* Returns a warning about the first prescribed motion that begins with a jump, and how to avoid
 * it; NULL: no motion does. The caller frees it. */
char *advice_first_jump(const sd_model *model);

/* Writes a likely reason why a run has failed into text[size] and returns text. If dt is near
 * the stability limit, dt is the reason; if not, the text is `otherwise`, a hint of the caller
 * like "is k_n too small?", followed by the ratio of dt to the stability limit. */
const char *advice_of_failure(const sd_model *model, const char *otherwise, char *text,
                              size_t size);

/* The deepest overlap at the start between two bodies of which at least one is free, relative to
 * the radius of the smaller disk. Contacts that the model restores do not count. depth 0: no
 * overlap. */
typedef struct first_overlap {
  uint32_t a, b; /* body numbers */
  /* overlap as a length; overlap divided by the radius of the smaller disk */
  double depth, relative;
  double force;  /* elastic normal force at this overlap */
  double weight; /* weight of the lighter free disk; 0: no gravity */
} first_overlap;
/* Collective. Finds the deepest overlap at the start among the disks of all ranks. SD_ERROR_IO:
 * out of memory. */
sd_status advice_overlap(const sd_model *model, first_overlap *worst);
/* Collective. *worst is the deepest overlap on this rank; it is replaced by the deepest on any
 * rank, relative to the radius of the smaller disk. Of equal ones that of the lowest rank is
 * taken. */
void advice_share_overlap(const comm *c, first_overlap *worst);
/* Warns if the overlap exceeds 1 % of the radius of the smaller disk. Returns the severity of
 * the warning; 0: none. */
double advice_tell_overlap(const sd_model *model, const first_overlap *worst,
                           sd_messages *messages);

#endif

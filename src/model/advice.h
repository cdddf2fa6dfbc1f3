/* advice.h: warnings about set-ups that are valid but seldom intended, and the error of a time step
 * beyond the stability limit.
 *
 * A check is a function and a row of advice_checks in advice.c.
 */
#ifndef SLIPDISK_MODEL_ADVICE_H
#define SLIPDISK_MODEL_ADVICE_H

#include "base/comm.h"
#include "model/model.h"

/* Adds warnings to messages, the most severe first, and returns the severity, 0: no warning.
 * Values of one check are comparable between models; values of different checks are not. */
typedef double advice_check(const sd_model *model, sd_messages *messages);
/* Warns of fields; advice_bodies.c. */
advice_check advice_fields;
/* Warns of motions; advice_bodies.c. */
advice_check advice_motions;
/* Warns of prescribed bodies that overlap; advice_bodies.c. */
advice_check advice_prescribed;
/* Warns of walls that meet; advice_bodies.c. */
advice_check advice_joints;
/* All checks, and their number. */
extern advice_check *const advice_checks[];
extern const size_t advice_count;

/* Returns the error text if dt is beyond the stability limit and limits.unstable_step is false,
 * else NULL. The caller frees it. */
char *advice_unstable(const sd_model *model);

/* Returns a warning about the first motion that begins with a jump, with a remedy; NULL: no
 * motion does. The caller frees it. */
char *advice_first_jump(const sd_model *model);

/* Writes a likely reason for a failed run to text[size] and returns text: that dt is near its
 * stability limit, else the hint `otherwise` ("is k_n too small?") with the ratio of dt to this
 * limit. */
const char *advice_of_failure(const sd_model *model, const char *otherwise, char *text,
                              size_t size);

/* The deepest overlap at the start between two bodies of which at least one is free, relative to
 * the radius of the smaller disk. Contacts that the model restores do not count. depth 0: no
 * overlap. */
typedef struct first_overlap {
  uint32_t a, b;          /* body numbers */
  double depth, relative; /* overlap, length; and over the radius of the smaller disk */
  double force;           /* elastic normal force at this overlap */
  double weight;          /* weight of the lighter free disk; 0: no gravity */
} first_overlap;
/* Collective. Finds this overlap over all ranks. SD_ERROR_IO: out of memory. */
sd_status advice_overlap(const sd_model *model, first_overlap *worst);
/* Collective. Replaces *worst by the overlap that is largest relative to the radius on any rank;
 * of equal ones the one of the lowest rank. */
void advice_share_overlap(const comm *c, first_overlap *worst);
/* Warns if the overlap exceeds 1 % of the radius, and returns the severity as an advice_check
 * does. */
double advice_tell_overlap(const sd_model *model, const first_overlap *worst,
                           sd_messages *messages);

#endif

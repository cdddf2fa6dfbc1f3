/* comm_cuts_zoltan.h: Zoltan's recursive coordinate bisection, for comm_cuts.c only. Each function
 * zoltan_cuts_* does what comm_cuts_* does. */
#ifndef BASE_COMM_CUTS_ZOLTAN_H
#define BASE_COMM_CUTS_ZOLTAN_H

#include <stddef.h>

#include "slipdisk/status.h"

typedef struct zoltan_cuts zoltan_cuts;

zoltan_cuts *zoltan_cuts_new(void);
void zoltan_cuts_free(zoltan_cuts *cuts);
sd_status zoltan_cuts_make(zoltan_cuts *cuts, size_t n, const double *x, const double *y,
                           const float *weight);
int zoltan_cuts_owner(const zoltan_cuts *cuts, double x, double y);
int zoltan_cuts_near(const zoltan_cuts *cuts, const double low[2], const double high[2],
                     int *ranks);
/* Returns the rectangle of a rank; sides at infinity are +-HUGE_VAL. */
void zoltan_cuts_of(const zoltan_cuts *cuts, int rank, double low[2], double high[2]);

#endif

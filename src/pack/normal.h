/* normal.h: the standard normal distribution. */
#ifndef SLIPDISK_PACK_NORMAL_H
#define SLIPDISK_PACK_NORMAL_H

/* Probability of a value below x, and above x. */
double normal_below(double x);
double normal_above(double x);
/* The x with normal_below(x) = p; p in [0, 1]. */
double normal_at(double p);

#endif

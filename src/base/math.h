/* math.h: elementary functions whose bits are the same with every C library, compiler and
 * processor.
 *
 * Libraries round sine and its like differently, some choose by processor, and compilers of some
 * processors contract products and sums. Here only IEEE basic operations are used, in a fixed
 * order, with numbers of twice the digits. Results are rounded correctly but for about one argument
 * in 2^15; hypot errs by less than 0.6 units in the last place. fmin and fmax of C may return
 * either zero of 0 and -0.
 *
 * Functions that C defines exactly come from the C library: sqrt, fabs, floor, ceil, nearbyint,
 * fma, ... tests/docs/test_same_bits.py has the list.
 */
#ifndef SLIPDISK_BASE_MATH_H
#define SLIPDISK_BASE_MATH_H

double math_sin(double x);
double math_cos(double x);
/* Both at once. */
void math_sine_cosine(double x, double *sine, double *cosine);
double math_tan(double x);
double math_asin(double x);
double math_acos(double x);
double math_atan(double x);
double math_atan2(double y, double x);
double math_exp(double x);
double math_expm1(double x);
double math_log(double x);
double math_log1p(double x);
double math_log10(double x);
double math_pow(double x, double y);
double math_hypot(double x, double y);

/* The smaller and the larger of two numbers, b if they are equal; the other one if one is NAN. */
static inline double math_min(double a, double b) { return a < b || b != b ? a : b; }
static inline double math_max(double a, double b) { return a > b || b != b ? a : b; }

#endif

/* quadrature.h: integrals by the rule of Gauss and Legendre with 16 points. */
#ifndef SLIPDISK_BASE_QUADRATURE_H
#define SLIPDISK_BASE_QUADRATURE_H

enum { QUADRATURE_POINTS = 16 };

/* Point k of the rule on [from, to], in ascending order, and its weight. */
void quadrature_point(double from, double to, int k, double *at, double *weight);

/* Integral of a finite function, by bisection until halves agree to 1e-12 of the whole. */
double quadrature(double (*f)(double x, void *user), void *user, double from, double to);

#endif

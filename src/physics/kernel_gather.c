/* kernel_gather.c: sums over the contacts of each body, in order of the partners' permanent ids, so that the
 * bits depend neither on the threads nor on what else is a candidate; compiled once per instruction set.
 */
#include "physics/kernel_path.h"
#include "physics/kernels.h"

void KERNEL(kernel_gather)(engine *e, size_t begin, size_t end);
void KERNEL(kernel_losses)(engine *e, size_t begin, size_t end);

/* Torque of a straight wall about its pivot: -tau R_a, and the arm from the pivot to the disk's centre. */
static double lever_torque(const engine *e, size_t i) {
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const incidence *n = &e->work.incidence;
  double torque = 0.0;
  for (size_t at = n->start[i]; at < n->start[i + 1]; at++) {
    size_t k = n->entry[at] / 2;
    double rx = s->x[p->a[k]] - s->x[i], ry = s->y[p->a[k]] - s->y[i];
    torque += rx * p->fy[k] - ry * p->fx[k] - p->tau[k] * s->radius[p->a[k]];
  }
  return torque;
}

void KERNEL(kernel_gather)(engine *e, size_t begin, size_t end) {
  sd_state *s = e->state;
  const double *px = e->work.pairs.fx, *py = e->work.pairs.fy, *ptau = e->work.pairs.tau;
  const size_t *start = e->work.incidence.start;
  const uint32_t *entry = e->work.incidence.entry;
  for (size_t i = begin; i < end; i++) {
    double fx = 0.0, fy = 0.0, tau = 0.0;
    for (size_t at = start[i]; at < start[i + 1]; at++) {
      size_t k = entry[at] / 2;
      double sign = entry[at] & 1 ? 1.0 : -1.0;
      fx += sign * px[k];
      fy += sign * py[k];
      tau += ptau[k];
    }
    s->force_x[i] = fx;
    s->force_y[i] = fy;
    s->torque[i] = s->radius[i] != 0.0 ? tau * s->radius[i] : lever_torque(e, i);
  }
}

void KERNEL(kernel_losses)(engine *e, size_t begin, size_t end) {
  sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  const incidence *n = &e->work.incidence;
  const bool variant = !e->work.conservative;
  for (size_t i = begin; i < end; i++) {
    double viscous = 0.0, friction = 0.0, gain = 0.0;
    for (size_t at = n->start[i]; at < n->start[i + 1]; at++) {
      size_t k = n->entry[at] / 2;
      int32_t other = n->entry[at] & 1 ? p->a[k] : p->b[k];
      double share = (size_t)other < s->n_free ? 0.5 : 1.0;
      viscous += share * p->loss_viscous[k];
      friction += share * p->loss_friction[k];
      if (variant) gain += share * p->gain[k];
    }
    s->loss_viscous[i] += viscous;
    s->loss_friction[i] += friction;
    s->gain_variant[i] += gain;
  }
}

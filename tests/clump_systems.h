/* clump_systems.h: clumps in models that tests build body by body. */
#ifndef TESTS_CLUMP_SYSTEMS_H
#define TESTS_CLUMP_SYSTEMS_H

#include "model/clumps.h"
#include "system.h"

HELPER const sd_clump *clump_of(sd_simulation *s, size_t k) {
  return sd_model_clump(sd_simulation_model(s), k);
}

HELPER uint32_t add_clump(sd_model *m, size_t n, const uint32_t *disks, double vx, double vy,
                          double omega) {
  const sd_clump c = {.n_disks = n, .disks = disks, .velocity = {vx, vy, omega}};
  return sd_model_add_clump(m, &c);
}

/* Two disks at a distance of 2 d, with their centre at (x, y) and an angle to the x axis. */
HELPER void add_dimer(sd_model *m, double x, double y, double angle, double d, double radius,
                      double mass) {
  const double dx = d * cos(angle), dy = d * sin(angle);
  const uint32_t disks[] = {system_disk(m, x - dx, y - dy, radius, mass),
                            system_disk(m, x + dx, y + dy, radius, mass)};
  add_clump(m, 2, disks, 0, 0, 0);
}

#endif

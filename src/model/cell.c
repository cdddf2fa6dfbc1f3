/* cell.c: see cell.h. */
#include "model/cell.h"

#include <math.h>

#define FAIL(...) sd_fail(msg, SD_ERROR_USER, __VA_ARGS__)

/* Whatever has a place or a weight of its own would stand still in the flow. */
static void check_bodies(const sd_model *m, size_t phase, sd_messages *msg) {
  char name[96];
  if (!m->periodic[0] || !m->periodic[1])
    FAIL("phases[%zu].cell: expected a box that is periodic in x and y", phase);
  if (m->n_walls > 0)
    FAIL("phases[%zu].cell: %s does not deform with the box; expected no walls", phase,
         sd_model_body_name(m, (uint32_t)m->n_disks, name, sizeof name));
  if (m->n_clumps > 0) FAIL("phases[%zu].cell: rigid bodies do not deform; expected no clumps", phase);
  if (m->gravity[0] != 0.0 || m->gravity[1] != 0.0)
    FAIL("phases[%zu].cell: disks fall through a periodic box; expected no gravity", phase);
  for (uint32_t i = 0; i < m->n_disks; i++) {
    const sd_disk *d = &m->disks[i];
    const char *what = d->driven                                        ? "is prescribed"
                       : d->locked[SD_X] || d->locked[SD_Y]             ? "is locked in place"
                       : d->force[SD_X] != 0.0 || d->force[SD_Y] != 0.0 ? "has a force of its own"
                       : d->waiting                                     ? "waits"
                                                                        : NULL;
    if (!what) continue;
    FAIL("phases[%zu].cell: %s %s; expected disks that contacts alone move", phase,
         sd_model_body_name(m, i, name, sizeof name), what);
    break;
  }
  for (size_t q = 0; q < m->n_motions; q++)
    if (m->motions[q].coordinate != SD_THETA)
      FAIL("phases[%zu].cell: motion \"%s\" prescribes positions in a box that deforms", phase,
           m->motions[q].name ? m->motions[q].name : "?");
}

static void check_rates(const sd_model *m, size_t phase, sd_messages *msg) {
  static const char *const component[] = {"xx", "yy", "xy"};
  const sd_cell *c = &m->phases[phase].cell;
  double largest = 0.0;
  bool controlled = false;
  for (int k = 0; k < SD_CELL_COMPONENTS; k++) {
    controlled |= c->controlled[k];
    if (c->controlled[k]) largest = fmax(largest, fabs(c->stress[k]));
    if (!(fabs(c->rate[k]) * m->dt <= 1e-3))
      FAIL("phases[%zu].cell.rate_%s = %g: expected at most %g, a thousandth per time step", phase,
           component[k], c->rate[k], 1e-3 / m->dt);
    if (c->controlled[k] && c->rate[k] != 0.0)
      FAIL("phases[%zu].cell: rate_%s and stress_%s; expected one of them", phase, component[k],
           component[k]);
    if (!isfinite(c->stress[k]))
      FAIL("phases[%zu].cell.stress_%s = %g: expected a number", phase, component[k], c->stress[k]);
  }
  if (controlled && largest == 0.0)
    FAIL("phases[%zu].cell: all stresses are 0, and give no scale; expected one that is not", phase);
  if (!(c->response >= 0.0) || !(c->max_rate >= 0.0))
    FAIL("phases[%zu].cell: response = %g, max_rate = %g: expected numbers >= 0", phase, c->response,
         c->max_rate);
}

void cell_check(const sd_model *m, sd_messages *msg) {
  bool any = false;
  for (size_t k = 0; k < m->n_phases; k++) {
    const sd_phase *p = &m->phases[k];
    if (!p->cell.asked) continue;
    if (!any) check_bodies(m, k, msg);
    any = true;
    check_rates(m, k, msg);
    if (p->compress.asked || p->relax)
      FAIL("phases[%zu].cell: expected a phase without %s", k, p->relax ? "relax" : "compress");
  }
  if (any && m->measure_disks) FAIL("measure.disks: their means are not taken in a box that deforms");
}

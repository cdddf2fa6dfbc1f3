/* cell.c: checks of phases that deform the periodic box; see cell.h. */
#include "model/cell.h"
#include "model/laws.h"
#include "model/rows.h"

#include <math.h>

#define FAIL(...) sd_fail(msg, SD_ERROR_USER, __VA_ARGS__)

/* The box must be longer than twice the range of neighbour lists, which may be 1.2 times the
 * distance at which disks touch plus the longest range of attraction of any law. */
double cell_least_length(const sd_model *m, double *reach) {
  const double farthest = laws_range(m);
  double largest = 0.0;
  for (size_t row = 0; row < rows_count(m); row++)
    largest = fmax(largest, rows_disk(m, row)->radius);
  if (reach) *reach = farthest;
  return 4.0 * rows_largest(m, largest) * 1.2 + 2.0 * farthest;
}

/* Reports an error for the first disk that is prescribed, locked in place, waiting or subject to
 * a force of its own: it would not move with the flow. Messages begin with the name of the body,
 * by which the reader of the input deck finds the line. */
static void check_disks(const sd_model *m, size_t phase, sd_messages *msg) {
  char name[96];
  for (size_t row = 0; row < rows_count(m); row++) {
    const sd_disk *d = rows_disk(m, row);
    const char *what = d->driven                                        ? "is prescribed"
                       : d->locked[SD_X] || d->locked[SD_Y]             ? "is locked in place"
                       : d->force[SD_X] != 0.0 || d->force[SD_Y] != 0.0 ? "has a force of its own"
                       : d->waiting                                     ? "waits"
                                                                        : NULL;
    if (!what) continue;
    FAIL("%s: it %s in the box of phases[%zu].cell; expected disks that contacts alone move",
         sd_model_body_name(m, rows_number(m, row), name, sizeof name), what, phase);
    return;
  }
}

/* Reports walls, clumps, gravity and motions of positions, which a deforming box cannot have,
 * and a box that is not periodic in x and y. */
static void check_bodies(const sd_model *m, size_t phase, sd_messages *msg) {
  char name[96];
  if (!m->periodic[0] || !m->periodic[1])
    FAIL("phases[%zu].cell: the box is not periodic in %s; expected a box that is periodic in x "
         "and y",
         phase,
         m->periodic[0]   ? "y"
         : m->periodic[1] ? "x"
                          : "x and y");
  if (m->n_walls > 0)
    FAIL("%s: it does not deform with the box of phases[%zu].cell; expected no walls",
         sd_model_body_name(m, (uint32_t)m->n_disks, name, sizeof name), phase);
  if (m->n_clumps > 0)
    FAIL("%s: rigid bodies do not deform with the box of phases[%zu].cell; expected no clumps",
         sd_model_body_name(m, (uint32_t)sd_model_bodies(m), name, sizeof name), phase);
  if (m->gravity[0] != 0.0 || m->gravity[1] != 0.0)
    FAIL("gravity: disks fall through the periodic box of phases[%zu].cell; expected no gravity",
         phase);
  check_disks(m, phase, msg);
  for (size_t q = 0; q < m->n_motions; q++)
    if (m->motions[q].coordinate != SD_THETA)
      FAIL("%s: it prescribes positions in the box of phases[%zu].cell; expected motions of theta "
           "alone",
           model_motion_name(m, q, name, sizeof name), phase);
}

/* Reports errors in the rates and stresses of a phase that deforms the box. */
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
    FAIL("phases[%zu].cell: all stresses are 0, and give no scale; expected one that is not",
         phase);
  if (!(c->response >= 0.0) || !(c->max_rate >= 0.0))
    FAIL("phases[%zu].cell: response = %g, max_rate = %g: expected numbers >= 0", phase,
         c->response, c->max_rate);
}

/* Reports a phase that makes the box too short along coordinate c. Lengths are followed only
 * through phases of given rates and durations: after stress control or a phase that may end
 * early they are unknown. */
static void check_lengths(const sd_model *m, int c, sd_messages *msg) {
  static const char *const keys[] = {"rate_xx", "rate_yy"};
  double reach;
  const double least = cell_least_length(m, &reach);
  const int component = c == SD_X ? SD_CELL_XX : SD_CELL_YY;
  double length = m->upper[c] - m->lower[c];
  for (size_t k = 0; k < m->n_phases && m->periodic[c]; k++) {
    const sd_phase *p = &m->phases[k];
    const double rate = p->cell.asked ? p->cell.rate[component] : 0.0;
    const bool ends_early = p->settle.asked || (m->until.asked && k + 1 == m->n_phases);
    if (p->compress.asked || (p->cell.asked && p->cell.controlled[component])) return;
    if (rate != 0.0 && ends_early) return;
    length *= exp(rate * (double)p->steps * m->dt);
    if (length > least || rate == 0.0) continue;
    FAIL("phases[%zu].cell.%s = %g: the box is %.4g long in %c at the end of this phase; expected "
         "more than "
         "%.4g, 4.8 times the largest radius%s",
         k, keys[c], rate, length, "xy"[c], least,
         reach > 0.0 ? " and twice the gap over which disks attract each other" : "");
    return;
  }
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
  for (int c = 0; any && c < 2; c++) check_lengths(m, c, msg);
  if (any && m->measure_disks)
    FAIL("measure.disks: means of every disk are not taken in a box that deforms; expected false");
}

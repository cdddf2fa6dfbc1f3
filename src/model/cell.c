/* cell.c: checks of phases that deform the periodic box; see cell.h. */
#include "model/cell.h"
#include "model/laws.h"
#include "model/rows.h"

#include <math.h>

#include "base/math.h"

/* The box must be longer than twice the range of neighbour lists, which may be 1.2 times the
 * distance at which disks touch plus the longest range of attraction of any law. */
double cell_least_length(const sd_model *m, double *reach) {
  const double farthest = laws_range(m);
  double largest = 0.0;
  for (size_t row = 0; row < rows_count(m); row++)
    largest = math_max(largest, rows_disk(m, row)->radius);
  if (reach) *reach = farthest;
  return 4.0 * rows_largest(m, largest) * 1.2 + 2.0 * farthest;
}

/* Reports an error for the first disk that is prescribed, locked in place, waiting or subject to
 * a force of its own: it would not move with the flow. */
static void check_disks(const sd_model *m, size_t phase, sd_messages *msg) {
  for (size_t row = 0; row < rows_count(m); row++) {
    const sd_disk *d = rows_disk(m, row);
    const char *what = d->driven                                        ? "is prescribed"
                       : disk_holds(d)                                  ? "is held or released"
                       : d->locked[SD_X] || d->locked[SD_Y]             ? "is locked in place"
                       : d->force[SD_X] != 0.0 || d->force[SD_Y] != 0.0 ? "has a force of its own"
                       : d->waiting                                     ? "waits"
                                                                        : NULL;
    if (!what) continue;
    fail_about(msg, about_body(m, rows_number(m, row)),
               "it %s in the box of phases[%zu].cell; expected disks that contacts alone move",
               what, phase);
    return;
  }
}

/* Reports walls, clumps, gravity and motions of positions, which a deforming box cannot have,
 * and a box that is not periodic in x and y. */
static void check_bodies(const sd_model *m, size_t phase, sd_messages *msg) {
  if (!m->periodic[0] || !m->periodic[1])
    fail_about(msg, about_path("phases[%zu].cell", phase),
               "the box is not periodic in %s; expected a box that is periodic in x and y",
               m->periodic[0]   ? "y"
               : m->periodic[1] ? "x"
                                : "x and y");
  if (m->n_walls > 0)
    fail_about(msg, about_wall(m, 0),
               "it does not deform with the box of phases[%zu].cell; expected no walls", phase);
  if (m->n_clumps > 0)
    fail_about(msg, about_body(m, sd_model_bodies(m)),
               "rigid bodies do not deform with the box of phases[%zu].cell; expected no clumps",
               phase);
  if (m->gravity[0] != 0.0 || m->gravity[1] != 0.0)
    fail_about(msg, about_path("gravity"),
               "disks fall through the periodic box of phases[%zu].cell; expected no gravity",
               phase);
  check_disks(m, phase, msg);
  for (size_t q = 0; q < m->n_motions; q++)
    if (m->motions[q].coordinate != SD_THETA)
      fail_about(
          msg, about_motion(m, q),
          "it prescribes positions in the box of phases[%zu].cell; expected motions of theta alone",
          phase);
}

/* Reports errors in the rates and stresses of a phase that deforms the box. */
static void check_rates(const sd_model *m, size_t phase, sd_messages *msg) {
  static const char *const component[] = {"xx", "yy", "xy"};
  const sd_cell *c = &m->phases[phase].cell;
  double largest = 0.0;
  bool controlled = false;
  for (int k = 0; k < SD_CELL_COMPONENTS; k++) {
    controlled |= c->controlled[k];
    if (c->controlled[k]) largest = math_max(largest, fabs(c->stress[k]));
    if (!(fabs(c->rate[k]) * m->dt <= 1e-3))
      fail_about(msg,
                 about_value(about_path("phases[%zu].cell.rate_%s", phase, component[k]), "%g",
                             c->rate[k]),
                 "expected at most %g, a thousandth per time step", 1e-3 / m->dt);
    if (c->controlled[k] && c->rate[k] != 0.0)
      fail_about(msg, about_path("phases[%zu].cell", phase),
                 "rate_%s and stress_%s; expected one of them", component[k], component[k]);
    if (!isfinite(c->stress[k]))
      fail_about(msg,
                 about_value(about_path("phases[%zu].cell.stress_%s", phase, component[k]), "%g",
                             c->stress[k]),
                 "expected a number");
  }
  if (controlled && largest == 0.0)
    fail_about(msg, about_path("phases[%zu].cell", phase),
               "all stresses are 0, and give no scale; expected one that is not");
  if (!(c->response >= 0.0) || !(c->max_rate >= 0.0))
    fail_about(msg, about_path("phases[%zu].cell", phase),
               "response = %g, max_rate = %g: expected numbers >= 0", c->response, c->max_rate);
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
    length *= math_exp(rate * (double)p->steps * m->dt);
    if (length > least || rate == 0.0) continue;
    fail_about(msg, about_value(about_path("phases[%zu].cell.%s", k, keys[c]), "%g", rate),
               "the box is %.4g long in %c at the end of this phase; expected more than %.4g, 4.8 "
               "times the largest radius%s",
               length, "xy"[c], least,
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
      fail_about(msg, about_path("phases[%zu].cell", k), "expected a phase without %s",
                 p->relax ? "relax" : "compress");
  }
  for (int c = 0; any && c < 2; c++) check_lengths(m, c, msg);
  if (any && m->measure_disks)
    fail_about(msg, about_path("measure.disks"),
               "means of every disk are not taken in a box that deforms; expected false");
}

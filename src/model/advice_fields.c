/* advice_fields.c: warnings about set-ups with fields that are seldom intended. See advice.h. */
#include <math.h>
#include <stdlib.h>

#include "base/text.h"
#include "model/advice.h"
#include "model/field_kinds.h"
#include "model/laws.h"
#include "model/rows.h"

/* Limits beyond which a step is coarse: f dt/m of drag, and the angle in rad by which a rotating
 * frame turns. */
static const double COARSE_DRAG = 0.2, COARSE_TURN = 0.05;

/* Warns of field k, frees the text, and returns the severity `how`. */
static double warn_of_field(const sd_model *m, size_t k, sd_messages *messages, double how,
                            char *text) {
  const char *name = m->fields[k].name;
  if (name && *name)
    sd_warn(messages, "fields.%s: %s", name, text);
  else
    sd_warn(messages, "fields[%zu]: %s", k, text);
  free(text);
  return how;
}

static double check_drag(const sd_model *m, sd_messages *messages) {
  char name[96];
  uint32_t disk = 0;
  const double rate = body_forces_drag_rate(m, &disk), coarse = rate * m->dt / COARSE_DRAG;
  if (!(coarse > 1)) return 0;
  sd_warn(messages,
          "fields: drag stops %s within %.2g time steps (f dt/m or f_r dt/I = %.3g): how it stops "
          "is not "
          "resolved; take dt = %.2g "
          "or less",
          sd_model_body_name(m, disk, name, sizeof name), 1 / (rate * m->dt), rate * m->dt,
          COARSE_DRAG / rate / 2);
  return coarse;
}

/* True if a phase shears the periodic box, so that images move with the fluid. */
static bool shears(const sd_model *m) {
  bool any = false;
  for (size_t k = 0; k < m->n_phases; k++)
    any |= m->phases[k].cell.asked &&
           (m->phases[k].cell.rate[SD_CELL_XY] != 0 || m->phases[k].cell.controlled[SD_CELL_XY]);
  return any;
}

/* Warns of a force that depends on position along a periodic direction: it jumps when a disk
 * crosses the edge of the box. */
static double check_periodic(const sd_model *m, size_t k, sd_messages *messages) {
  const sd_body_force *f = &m->fields[k];
  const bool x = m->periodic[SD_X], y = m->periodic[SD_Y];
  const bool by_place = f->kind == SD_FIELD_CENTRAL || f->kind == SD_FIELD_ROTATION ||
                        (f->kind == SD_FIELD_DRAG && f->swirl != 0);
  const bool sheared = f->kind == SD_FIELD_DRAG && f->shear_rate != 0 && y && !shears(m);
  if (!(by_place && (x || y)) && !sheared) return 0;
  return warn_of_field(m, k, messages, 1,
                       format_text("the force depends on place along %s, where the box repeats: it "
                                   "jumps when a disk passes the edge",
                                   x && y && by_place ? "x and y"
                                   : x && by_place    ? "x"
                                                      : "y"));
}

/* Warns of damping and unsheared drag in a sheared box: they act on velocities in the
 * laboratory, not relative to the flow. */
static double check_sheared(const sd_model *m, size_t k, sd_messages *messages) {
  const sd_body_force *f = &m->fields[k];
  for (size_t p = 0; p < m->n_phases; p++) {
    const sd_cell *c = &m->phases[p].cell;
    const bool sheared = c->asked && (c->rate[SD_CELL_XY] != 0 || c->controlled[SD_CELL_XY]);
    if (!sheared || !body_force_is_on(m, k, (int64_t)p)) continue;
    if (f->kind == SD_FIELD_DAMPING)
      return warn_of_field(
          m, k, messages, 1,
          format_text("damping acts against velocities in the laboratory, while the box "
                      "shears: what moves with the flow is damped too"));
    if (f->kind == SD_FIELD_DRAG && f->shear_rate == 0)
      return warn_of_field(
          m, k, messages, 1,
          format_text("the fluid does not shear while the box does: it stops what moves with "
                      "the flow; give shear_rate, that of the box"));
  }
  return 0;
}

/* Warns of a rotating frame that turns far in one step, or that is combined with gravity. */
static double check_frame(const sd_model *m, size_t k, sd_messages *messages) {
  const sd_body_force *f = &m->fields[k];
  if (f->kind != SD_FIELD_ROTATION || f->omega == 0) return 0;
  const double turn = fabs(f->omega) * m->dt;
  double worst = 0;
  if (turn > COARSE_TURN)
    worst = warn_of_field(
        m, k, messages, turn / COARSE_TURN,
        format_text("the frame turns by %.3g rad in a time step; take dt = %.2g or less", turn,
                    COARSE_TURN / fabs(f->omega) / 2));
  if (m->gravity[SD_X] == 0 && m->gravity[SD_Y] == 0) return worst;
  warn_of_field(m, k, messages, 1,
                format_text("gravity turns with the frame: it has a fixed direction in it"));
  return fmax(worst, 1);
}

/* Warns of a field that is on in no phase. */
static double check_off(const sd_model *m, size_t k, sd_messages *messages) {
  for (int64_t p = 0; p < (int64_t)m->n_phases; p++)
    if (body_force_is_on(m, k, p)) return 0;
  return warn_of_field(m, k, messages, 1,
                       format_text("it is on in no phase: no list `fields` of a phase names it"));
}

/* --- disks that fall without end ------------------------------------------------------------ */

/* True if the field can keep disks from gaining speed without limit: drag, or a central force. */
static bool field_holds(const sd_body_force *f) {
  return (f->kind == SD_FIELD_DRAG && f->gamma > 0) ||
         (f->kind == SD_FIELD_CENTRAL && f->strength != 0);
}

/* True if a wall can keep disks from falling along the axis: it is not straight along the axis,
 * or its contacts have friction. */
static bool wall_holds(const sd_model *m, const sd_wall *w, int axis) {
  bool along = w->kind != SD_WALL_CIRCLE && w->kind != SD_WALL_ARC, rubs = false;
  const double *first = along ? w->points[0] : NULL;
  for (size_t k = 1; along && k < w->n_points; k++)
    along =
        fabs(w->points[k][!axis] - first[!axis]) <= 1e-9 * fabs(w->points[k][axis] - first[axis]);
  for (size_t b = 0; b < m->n_materials; b++) {
    const sd_contact_law *law = sd_model_law(m, w->material, (int)b);
    rubs = rubs || (law_is_given(law) && law->mu > 0 && (law->k_t > 0 || law->gamma_t > 0));
  }
  return !along || rubs;
}

/* True if a prescribed or locked body, a wall, a field or a motion can keep the disks from
 * falling along the axis. */
static bool is_held(const sd_model *m, int axis) {
  bool holds = m->n_free < m->n_disks;
  for (size_t i = 0; i < model_held(m) && !holds; i++) holds = m->disks[i].locked[axis];
  for (size_t k = 0; k < m->n_clumps && !holds; k++) holds = m->clumps[k].locked[axis];
  for (size_t w = 0; w < m->n_walls && !holds; w++) holds = wall_holds(m, &m->walls[w], axis);
  for (size_t k = 0; k < m->n_fields && !holds; k++) holds = field_holds(&m->fields[k]);
  for (size_t k = 0; k < m->n_motions && !holds; k++)
    holds = m->motions[k].coordinate == axis && m->motions[k].bodies[0] < m->n_disks;
  return holds;
}

/* Collective. Sum of the external forces along the axis on all free disks, over the sum of their
 * absolute values, so within [0, 1]. */
static double pull_of(const sd_model *m, int axis) {
  double sum = 0, parts = 0;
  for (size_t row = rows_first(m); row < rows_count(m); row++) {
    const sd_disk *d = rows_disk(m, row);
    if (d->driven) continue;
    sum += d->mass * m->gravity[axis] + d->force[axis];
    parts += fabs(d->mass * m->gravity[axis]) + fabs(d->force[axis]);
  }
  sum = rows_sum(m, sum);
  parts = rows_sum(m, parts);
  return parts > 0 ? fabs(sum) / parts : 0;
}

/* Warns of disks that fall without end along a periodic direction. */
static double check_falls(const sd_model *m, sd_messages *messages) {
  const double g = hypot(m->gravity[SD_X], m->gravity[SD_Y]);
  double found = 0;
  for (int axis = SD_X; axis <= SD_Y; axis++) {
    const bool rounding = fabs(m->gravity[axis]) < 1e-12 * g;
    if (!m->periodic[axis] || m->n_free == 0 || is_held(m, axis) || !(pull_of(m, axis) > 1e-9))
      continue;
    const bool forces = m->gravity[axis] == 0 || rounding;
    bool any = !forces;
    for (size_t i = 0; i < model_held(m) && !any; i++) any = m->disks[i].force[axis] != 0;
    if (!any) continue;
    sd_warn(messages,
            "%s: the box repeats along %c, and nothing there holds the disks: they fall for ever, "
            "faster and "
            "faster; expected a wall or a fixed disk in the way, a wall with friction, or drag",
            forces ? "force" : "gravity", axis == SD_X ? 'x' : 'y');
    found = 1;
  }
  return found;
}

double advice_fields(const sd_model *m, sd_messages *messages) {
  double worst = fmax(m->n_fields ? check_drag(m, messages) : 0, check_falls(m, messages));
  for (size_t k = 0; k < m->n_fields; k++) {
    worst = fmax(worst, check_periodic(m, k, messages));
    worst = fmax(worst, check_sheared(m, k, messages));
    worst = fmax(worst, check_frame(m, k, messages));
    worst = fmax(worst, check_off(m, k, messages));
  }
  return worst;
}

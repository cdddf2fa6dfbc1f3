/* field_kinds.c: deck keys, stability limits and checks of fields; see field_kinds.h. */
#include "model/field_kinds.h"
#include "model/rows.h"

#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"

#define SHAPE(kind, word, keys, meaning) {#word, kind, keys, meaning},
static const deck_shape kinds[] = {FIELD_KINDS(SHAPE) LAST_WORD};
#undef SHAPE

const char *field_kind_name(sd_field_kind kind) { return kinds[kind].name; }

static const deck_shape per_words[] = {WORD("disk", SD_FIELD_PER_DISK),
                                       WORD("radius", SD_FIELD_PER_RADIUS),
                                       WORD("mass", SD_FIELD_PER_MASS), LAST_WORD};

static const deck_key field_keys[] = {
    {"name", TEXT, "-", NULL, "name for phases", SETS(sd_body_force, name)},
    {"type", CHOICE, "required", kinds, "see below", SETS(sd_body_force, kind)},
    {"disk", BODIES, "(all)", NULL, "disks"},
    {"group", NAMES, "(all)", NULL, "groups of disks"},
    {"gamma", NUMBER(DECK_NOT_NEGATIVE, "force time/length"), "-", NULL,
     "drag: coefficient f; per radius: f/R; per mass: f/m, the rate at which velocities decay",
     SETS(sd_body_force, gamma)},
    {"gamma_rotation", NUMBER(DECK_NOT_NEGATIVE, "force length time"), "0.0", NULL,
     "drag: torque over angular velocity; per radius: this over R^3; per mass: this over the "
     "inertia",
     SETS(sd_body_force, gamma_rotation)},
    {"per", CHOICE, "\"disk\"", per_words,
     "drag, central: equal for all disks, or times radius or mass", SETS(sd_body_force, per)},
    {"centre", NUMBERS(DECK_ANY, "length"), "(0.0, 0.0)", NULL,
     "centre of force or of rotation; drag: where the fluid has the velocity `flow`",
     SETS(sd_body_force, centre)},
    {"flow", NUMBERS(DECK_ANY, "length/time"), "(0.0, 0.0)", NULL,
     "drag: velocity of the fluid at `centre`", SETS(sd_body_force, flow)},
    {"shear_rate", NUMBER(DECK_ANY, "1/time"), "0.0", NULL,
     "drag: du_x/dy of the fluid; it turns disks at -shear_rate/2",
     SETS(sd_body_force, shear_rate)},
    {"swirl", ANGLE("rad/time"), "0.0", NULL, "drag: the fluid turns about `centre`, disks with it",
     SETS(sd_body_force, swirl)},
    {"alpha", NUMBER(DECK_NOT_NEGATIVE, "-"), "-", NULL, "damping: fraction of the force, below 1",
     SETS(sd_body_force, alpha)},
    {"alpha_rotation", NUMBER(DECK_NOT_NEGATIVE, "-"), "(as alpha)", NULL,
     "damping: fraction of the torque", SETS(sd_body_force, alpha_rotation)},
    {"strength", NUMBER(DECK_ANY, "force/length^power"), "-", NULL,
     "central: force at distance 1, > 0 towards the centre; per mass: an acceleration",
     SETS(sd_body_force, strength)},
    {"power", INTEGER(DECK_ANY, "-"), "1", NULL,
     "central: power of the distance, -8 to 8: 1 a spring, -2 gravity of a point, -1 of a line",
     SETS(sd_body_force, power)},
    {"softening", NUMBER(DECK_NOT_NEGATIVE, "length"), "0.0", NULL,
     "central: s in strength r (r^2 + s^2)^((power - 1)/2)", SETS(sd_body_force, softening)},
    {"omega", ANGLE("rad/time"), "-", NULL,
     "rotation: angular velocity of the frame; gravity: of its direction",
     SETS(sd_body_force, omega)},
    {"g", NUMBER(DECK_NOT_NEGATIVE, "length/time^2"), "-", NULL, "gravity: strength",
     SETS(sd_body_force, g)},
    {"tilt", ANGLE("rad"), "0.0", NULL, "gravity: angle phi of its direction at the start",
     SETS(sd_body_force, tilt)},
};
TABLE(deck_fields, "fields", false,
      "A force on free disks that depends on position and velocity. Fields add up.", field_keys);

/* --- active fields and their strength --------------------------------------------------------- */

bool body_force_is_on(const sd_model *m, size_t k, int64_t phase) {
  const bool *on = phase < (int64_t)m->n_phases ? m->phases[phase].fields : NULL;
  return !on || on[k];
}

bool body_forces_dissipate(const sd_model *m, int64_t phase) {
  for (size_t k = 0; k < m->n_fields; k++) {
    const sd_body_force *f = &m->fields[k];
    if (f->n_disks || !body_force_is_on(m, k, phase)) continue;
    if ((f->kind == SD_FIELD_DRAG && f->gamma > 0) || (f->kind == SD_FIELD_DAMPING && f->alpha > 0))
      return true;
  }
  return false;
}

/* Rates at which fields act on one disk: drag f/m and rotational drag f_r/I, 1/time; spring2:
 * squared angular frequency of its motion in central fields that act as springs, 1/time^2. */
typedef struct field_rates {
  double drag, turn_drag, spring2;
} field_rates;

/* Adds the contribution of force field f to the rates *r of disk d; prescribed disks are
 * skipped. */
static void add_rates(const sd_body_force *f, const sd_disk *d, field_rates *r) {
  if (d->driven || !(d->mass > 0)) return;
  const double inertia = d->inertia > 0 ? d->inertia : 0.5 * d->mass * d->radius * d->radius;
  const field_weight w = field_weight_of(f, d->radius, d->mass, inertia);
  const bool still = d->locked[SD_X] && d->locked[SD_Y];
  if (f->kind == SD_FIELD_DRAG && !still) r->drag += f->gamma * w.force / d->mass;
  if (f->kind == SD_FIELD_DRAG && !d->locked[SD_THETA])
    r->turn_drag += f->gamma_rotation * w.torque / inertia;
  if (f->kind == SD_FIELD_CENTRAL && f->power == 1 && f->strength > 0 && !still)
    r->spring2 += f->strength * w.force / d->mass;
}

/* Returns the rates of drag and springs for each disk of this rank; the caller frees them. NULL:
 * no fields, or out of memory (shortage_note in memory.h). */
static field_rates *rates_of(const sd_model *m) {
  field_rates *rates;
  const size_t rows = rows_count(m);
  if (m->n_fields == 0) return NULL;
  if (!memory_row(&rates, rows, sizeof *rates)) {
    shortage_note();
    return NULL;
  }
  for (size_t k = 0; k < m->n_fields; k++) {
    const sd_body_force *f = &m->fields[k];
    for (size_t n = 0; n < (f->n_disks ? f->n_disks : rows); n++) {
      const size_t row = f->n_disks ? f->disks[n] : n;
      add_rates(f, rows_disk(m, row), &rates[row]);
    }
  }
  return rates;
}

double body_forces_drag_rate(const sd_model *m, uint32_t *disk) {
  field_rates *rates = rates_of(m);
  double worst = 0;
  uint32_t first = 0;
  for (size_t row = 0; rates && row < rows_count(m); row++) {
    const double rate = math_max(rates[row].drag, rates[row].turn_drag);
    if (!(rate > worst)) continue;
    worst = rate;
    first = rows_number(m, row);
  }
  free(rates);
  worst = rows_extreme(m, worst, &first);
  if (disk && worst > 0) *disk = first;
  return worst;
}

/* Stability limits of force fields. Drag is integrated implicitly: Verlet is stable at any rate,
 * Gear up to f dt/m = GEAR_DRAG, where an eigenvalue of its step passes -1. A spring of
 * frequency w is stable up to SPRING (w dt)^2 = 1, as in stability.c. */
static const double GEAR_DRAG = 90.0 / 49, SPRING[] = {[SD_GEAR5] = 47.0 / 30, [SD_VERLET] = 0.25};

void body_forces_limit(const sd_model *m, sd_step_limit *limit) {
  field_rates *rates = rates_of(m);
  for (size_t row = 0; rates && row < rows_count(m); row++) {
    const field_rates *r = &rates[row];
    const double rate = m->integrator == SD_GEAR5 ? math_max(r->drag, r->turn_drag) : 0;
    double dt = rate > 0 ? GEAR_DRAG / rate : HUGE_VAL;
    if (r->spring2 > 0) dt = math_min(dt, 1 / sqrt(SPRING[m->integrator] * r->spring2));
    if (dt < limit->dt)
      *limit = (sd_step_limit){.dt = dt, .disk = rows_number(m, row), .bound = SD_BOUND_FIELD};
  }
  free(rates);
}

/* --- checks ----------------------------------------------------------------------------------- */

/* Reports errors in the parameters of one force field. */
static void check_one(const sd_model *m, const sd_body_force *f, const char *name,
                      sd_messages *msg) {
  const double numbers[] = {
      f->centre[0],  f->centre[1], f->gamma, f->gamma_rotation, f->flow[0],  f->flow[1],
      f->shear_rate, f->swirl,     f->alpha, f->alpha_rotation, f->strength, f->softening,
      f->omega,      f->g,         f->tilt};
  for (size_t k = 0; k < COUNT(numbers); k++)
    if (!isfinite(numbers[k])) {
      fail_about(msg, about_path("%s", name), "expected finite numbers");
      return;
    }
  deck_key_check(&deck_fields, f, name, msg);
  if (f->power < -FIELD_MOST_POWER || f->power > FIELD_MOST_POWER)
    fail_about(msg, about_value(about_path("%s.power", name), "%lld", (long long)f->power),
               "expected %d to %d", -FIELD_MOST_POWER, FIELD_MOST_POWER);
  for (size_t k = 0; k < f->n_disks; k++)
    if (f->disks[k] >= m->n_disks)
      fail_about(msg, about_path("%s", name), "disk %u does not exist", f->disks[k]);
}

/* Reports damping fields that together remove all of the force on a disk. */
static void check_damping(const sd_model *m, sd_messages *msg) {
  double *sum, worst = 0;
  size_t at = 0;
  const size_t rows = rows_count(m);
  if (!memory_row(&sum, rows, 2 * sizeof *sum)) {
    sd_fail(msg, SD_ERROR_IO, "out of memory for the fields");
    return;
  }
  for (size_t k = 0; k < m->n_fields; k++) {
    const sd_body_force *f = &m->fields[k];
    for (size_t n = 0; f->kind == SD_FIELD_DAMPING && n < (f->n_disks ? f->n_disks : rows); n++) {
      double *of = sum + 2 * (f->n_disks ? f->disks[n] : n);
      of[0] += f->alpha;
      of[1] += f->alpha_rotation;
      if (math_max(of[0], of[1]) > worst) worst = math_max(of[0], of[1]), at = k;
    }
  }
  free(sum);
  if (worst >= 1)
    fail_about(msg, about_path("fields[%zu].alpha", at),
               "damping fields take %g of the force: expected less than 1", worst);
}

void body_forces_check(const sd_model *m, sd_messages *msg) {
  const size_t before = sd_messages_errors(msg);
  for (size_t k = 0; k < m->n_fields; k++) {
    char name[96];
    if (m->fields[k].name && *m->fields[k].name)
      snprintf(name, sizeof name, "fields.%s", m->fields[k].name);
    else
      snprintf(name, sizeof name, "fields[%zu]", k);
    check_one(m, &m->fields[k], name, msg);
  }
  if (m->n_fields && sd_messages_errors(msg) == before) check_damping(m, msg);
}

/* clumps.c: poses, force sums and energies of clumps (rigid bodies of several disks); see
 * clumps.h. */
#include "physics/system/clumps.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "base/memory.h"
#include "model/model.h"
#include "physics/system/bodies.h"
#include "slipdisk/simulation.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "base/vmath.h"

/* --- tables ----------------------------------------------------------------------------------- */

void clumps_fill_state(const sd_model *m, sd_state *s) {
  for (size_t k = 0; k < m->n_clumps; k++) {
    const sd_clump *c = &m->clumps[k];
    s->clump_x[k] = s->clump_base_x[k] = c->position[SD_X];
    s->clump_y[k] = s->clump_base_y[k] = c->position[SD_Y];
    if (m->disks[c->disks[0]].waiting) continue;
    s->clump_vx[k] = c->velocity[SD_X];
    s->clump_vy[k] = c->velocity[SD_Y];
    s->clump_omega[k] = c->velocity[SD_THETA];
  }
  for (size_t i = 0; i < s->n_free; i++) {
    const sd_disk *d = &m->disks[s->id[i]];
    if (d->clump == 0) continue;
    const sd_clump *c = &m->clumps[d->clump - 1];
    size_t n = (size_t)(c->disks - m->clump_disks);
    while (m->clump_disks[n] != s->id[i]) n++;
    /* image count such that the unwrapped position is the clump's centre plus the disk's offset */
    for (int q = 0; q < 2; q++) {
      if (!m->periodic[q]) continue;
      const double away = c->position[q] + m->clump_offsets[n][q] - d->position[q];
      (q ? s->image_y : s->image_x)[i] = (int32_t)lrint(away / (m->upper[q] - m->lower[q]));
    }
  }
}

/* Sets the pointers to the columns of the clumps' coordinates, most of which are in the state. own:
 * memory for inverse masses and constant forces. */
static void fill_columns(const sd_state *s, clumps *c, double *own) {
  double *inverse[SD_COORDINATES], *constant[SD_COORDINATES];
  for (int k = 0; k < SD_COORDINATES; k++) {
    inverse[k] = own + (size_t)k * c->count;
    constant[k] = own + (size_t)(SD_COORDINATES + k) * c->count;
  }
#define CLUMP_COLUMNS(k, name, v_, force_)                                                         \
  c->columns[k] = (columns){                                                                       \
      s->clump_##name,    s->v_,     s->clump_##name##2, s->clump_##name##3, s->clump_##name##4,   \
      s->clump_##name##5, s->force_, constant[k],        inverse[k]}
  CLUMP_COLUMNS(SD_X, x, clump_vx, clump_force_x);
  CLUMP_COLUMNS(SD_Y, y, clump_vy, clump_force_y);
  CLUMP_COLUMNS(SD_THETA, theta, clump_omega, clump_torque);
#undef CLUMP_COLUMNS
}

static void fill_members(engine *e) {
  const sd_model *m = e->model;
  const sd_state *s = e->state;
  clumps *c = &e->work.clumps;
  for (size_t i = 0; i < s->n_free; i++) {
    const int clump = m->disks[s->id[i]].clump;
    c->of[i] = clump - 1;
    c->clumped[i] = clump > 0;
    c->contact_mass[i] = clump > 0 ? m->clumps[clump - 1].mass : s->mass[i];
  }
  size_t at = 0;
  for (size_t k = 0; k < c->count; k++) {
    c->start[k] = at;
    for (size_t n = 0; n < m->clumps[k].n_disks; n++, at++) {
      const uint32_t disk = m->clumps[k].disks[n];
      const double *offset = m->clump_offsets[(m->clumps[k].disks - m->clump_disks) + (ptrdiff_t)n];
      c->member[at] = slot_of(&e->work.slots, disk);
      assert(c->member[at] < s->n_free);
      c->offset_x[at] = offset[SD_X];
      c->offset_y[at] = offset[SD_Y];
      c->offset_theta[at] = m->disks[disk].position[SD_THETA];
    }
  }
  c->start[c->count] = at;
}

/* Computes arm_x and arm_y, the vectors from the centre of clump k to its disks, from the present
 * angle of the clump. */
static void turn(const engine *e, size_t k);

sd_status clumps_new(engine *e) {
  const sd_state *s = e->state;
  clumps *c = &e->work.clumps;
  *c = (clumps){.count = s->n_clumps};
  if (c->count == 0) return SD_OK;
  size_t members = 0;
  for (size_t k = 0; k < c->count; k++) members += e->model->clumps[k].n_disks;
  const size_t numbers = (2 * SD_COORDINATES + 2) * c->count + 5 * members + 2 * s->n_free;
  double *own;
  if (!memory_rows(4, (memory_column[]){{&own, numbers, sizeof *own},
                                        {&c->start, c->count + 1, sizeof *c->start},
                                        {&c->member, members, sizeof *c->member},
                                        {&c->of, s->n_free, sizeof *c->of}})) {
    c->count = 0;
    return SD_ERROR_IO;
  }
  fill_columns(s, c, own);
  double *next = own + 2 * SD_COORDINATES * c->count;
  double **const column[] = {&c->offset_x, &c->offset_y, &c->offset_theta, &c->arm_x, &c->arm_y};
  for (size_t q = 0; q < sizeof column / sizeof *column; q++, next += members) *column[q] = next;
  c->contact_mass = next;
  c->clumped = next + s->n_free;
  c->alpha = c->clumped + s->n_free;
  c->alpha_rotation = c->alpha + c->count;
  fill_members(e);
  for (size_t k = 0; k < c->count; k++) turn(e, k);
  return SD_OK;
}

void clumps_free(engine *e) {
  clumps *c = &e->work.clumps;
  /* columns[0].inverse is the start of the memory that clumps_new allocated for all columns of
   * doubles. */
  if (c->count) free((double *)(uintptr_t)c->columns[0].inverse);
  free(c->start);
  free(c->member);
  free(c->of);
  *c = (clumps){0};
}

void clumps_fill_constants(engine *e) {
  const sd_model *m = e->model;
  const sd_state *s = e->state;
  const clumps *c = &e->work.clumps;
  for (size_t k = 0; k < c->count; k++) {
    const sd_clump *of = &m->clumps[k];
    const bool plays = clump_in_play(e, k);
    for (int q = 0; q < SD_COORDINATES; q++) {
      double *inverse = (double *)(uintptr_t)c->columns[q].inverse;
      double *constant = (double *)(uintptr_t)c->columns[q].constant;
      inverse[k] = !plays || of->locked[q] ? 0.0 : 1.0 / (q == SD_THETA ? of->inertia : of->mass);
      constant[k] = !plays ? 0.0 : of->force[q] + (q == SD_THETA ? 0.0 : of->mass * m->gravity[q]);
    }
  }
  bool pushed = false;
  for (size_t n = 0; n < (c->count ? c->start[c->count] : 0); n++) {
    const uint32_t i = c->member[n];
    pushed |= e->work.constant_x[i] != 0.0 || e->work.constant_y[i] != 0.0 ||
              e->work.constant_torque[i] != 0.0;
  }
  e->work.clumps.pushed = pushed;
  for (size_t n = 0; c->count && n < m->n_motions; n++)
    for (size_t b = 0; b < m->motions[n].n_bodies; b++) {
      const uint32_t slot = slot_of(&e->work.slots, m->motions[n].bodies[b]);
      if (slot >= s->n_bodies)
        ((double *)(uintptr_t)c->columns[m->motions[n].coordinate].inverse)[slot - s->n_bodies] =
            0.0;
    }
}

/* --- disks of a clump ------------------------------------------------------------------------- */

/* Computes sine and cosine of the angle turned + theta. turned is a multiple of 8 rad, that is of
 * 4/pi full turns. 4/pi is split into two parts, so that full turns are subtracted without loss of
 * digits, for up to 2^27 multiples. */
static void sine_cosine_of(double turned, double theta, double *sine, double *cosine) {
  const double high = 0x1.45f306p+0, low = 0x1.b9391054a7f0ap-25, per_turn = 0.15915494309189533577;
  const double n = turned * 0.125, whole = n * high;
  sine_cosine_w1((whole - nearbyint(whole)) + (n * low + theta * per_turn), sine, cosine);
}

static void turn(const engine *e, size_t k) {
  const clumps *c = &e->work.clumps;
  double sine, cosine;
  sine_cosine_of(e->state->clump_turn[k], e->state->clump_theta[k], &sine, &cosine);
  for (size_t n = c->start[k]; n < c->start[k + 1]; n++) {
    c->arm_x[n] = cosine * c->offset_x[n] - sine * c->offset_y[n];
    c->arm_y[n] = sine * c->offset_x[n] + cosine * c->offset_y[n];
  }
}

/* Sets poses and velocities of the disks of clump k from those of the clump. Disks of one clump may
 * have different image counts in a periodic box. */
void clump_place(engine *e, size_t k) {
  sd_state *s = e->state;
  const work *w = &e->work;
  const clumps *c = &w->clumps;
  turn(e, k);
  for (size_t n = c->start[k]; n < c->start[k + 1]; n++) {
    const uint32_t i = c->member[n];
    const double across = s->clump_image_x[k] - s->image_x[i],
                 up = s->clump_image_y[k] - s->image_y[i];
    s->x[i] = (s->clump_x[k] + c->arm_x[n]) + (across * w->length[0] + up * w->offset);
    s->y[i] = (s->clump_y[k] + c->arm_y[n]) + up * w->length[1];
    s->theta[i] = s->clump_theta[k] + (c->offset_theta[n] + (s->clump_turn[k] - s->turn[i]));
    s->vx[i] = s->clump_vx[k] - s->clump_omega[k] * c->arm_y[n];
    s->vy[i] = s->clump_vy[k] + s->clump_omega[k] * c->arm_x[n];
    s->omega[i] = s->clump_omega[k];
  }
}

double clump_second(const engine *e, size_t slot, int c) {
  const clumps *all = &e->work.clumps;
  const size_t k = (size_t)all->of[slot];
  size_t n = all->start[k];
  while (all->member[n] != slot) n++;
  const double turned = e->work.dt * e->state->clump_omega[k], towards = 0.5 * turned * turned;
  const double second = all->columns[SD_THETA].q2[k];
  return c == SD_X ? all->columns[SD_X].q2[k] - second * all->arm_y[n] - towards * all->arm_x[n]
                   : all->columns[SD_Y].q2[k] + second * all->arm_x[n] - towards * all->arm_y[n];
}

void clump_set_out(engine *e, size_t k, double x, double y, double vy) {
  sd_state *s = e->state;
  const work *w = &e->work;
  s->clump_x[k] = x;
  s->clump_y[k] = y;
  s->clump_vy[k] = vy;
  clump_place(e, k);
  for (size_t n = w->clumps.start[k]; n < w->clumps.start[k + 1]; n++) {
    const uint32_t i = w->clumps.member[n];
    if (w->periodic[0])
      s->image_x[i] += (int32_t)floor((s->x[i] - w->lower[0]) * w->inverse_length[0]);
    if (w->periodic[1])
      s->image_y[i] += (int32_t)floor((s->y[i] - w->lower[1]) * w->inverse_length[1]);
  }
  clump_place(e, k);
}

void clumps_place_all(engine *e) {
  for (size_t k = 0; k < e->work.clumps.count; k++) clump_place(e, k);
}

/* --- forces ----------------------------------------------------------------------------------- */

clump_load clumps_load_of(const engine *e, size_t k, const double *fx, const double *fy,
                          const double *torque) {
  const clumps *c = &e->work.clumps;
  clump_load sum = {{0.0, 0.0, 0.0}};
  for (size_t n = c->start[k]; n < c->start[k + 1]; n++) {
    const uint32_t i = c->member[n];
    sum.on[SD_X] += fx[i];
    sum.on[SD_Y] += fy[i];
    sum.on[SD_THETA] += torque[i] + (c->arm_x[n] * fy[i] - c->arm_y[n] * fx[i]);
  }
  return sum;
}

clump_load clump_constant(const engine *e, size_t k) {
  const work *w = &e->work;
  clump_load all = {{0.0, 0.0, 0.0}};
  if (w->clumps.pushed || e->fields || w->body_forces)
    all = clumps_load_of(e, k, w->columns[SD_X].constant, w->columns[SD_Y].constant,
                         w->columns[SD_THETA].constant);
  for (int q = 0; q < SD_COORDINATES; q++) all.on[q] += w->clumps.columns[q].constant[k];
  return all;
}

clump_load clump_total(const engine *e, size_t k) {
  clump_load all = clump_constant(e, k);
  for (int q = 0; q < SD_COORDINATES; q++)
    all.on[q] = e->work.clumps.columns[q].force[k] + all.on[q];
  return all;
}

void clump_sum(engine *e, size_t k) {
  const sd_state *s = e->state;
  const clump_load contacts = clumps_load_of(e, k, s->force_x, s->force_y, s->torque);
  for (int q = 0; q < SD_COORDINATES; q++) e->work.clumps.columns[q].force[k] = contacts.on[q];
}

/* Returns the power of the deck's force fields on clump k, summed over coordinates that are not
 * locked or prescribed. */
static double field_power(const engine *e, size_t k) {
  const sd_state *s = e->state;
  const clump_load load = clumps_load_of(e, k, s->field_x, s->field_y, s->field_torque);
  double sum = 0.0;
  for (int q = 0; q < SD_COORDINATES; q++) {
    const columns *c = &e->work.clumps.columns[q];
    sum += c->inverse[k] != 0.0 ? load.on[q] * c->v[k] : 0.0;
  }
  return sum;
}

double clump_field_booked(const engine *e, size_t k) {
  const sd_state *s = e->state;
  const clumps *c = &e->work.clumps;
  double sum = 0.0;
  for (size_t n = c->start[k]; e->work.body_forces && n < c->start[k + 1]; n++) {
    const uint32_t i = c->member[n];
    sum += s->field_x[i] * s->vx[i] + s->field_y[i] * s->vy[i] + s->field_torque[i] * s->omega[i];
  }
  return sum;
}

void clump_book_field(engine *e, size_t k, double booked, double dt) {
  if (!e->work.body_forces) return;
  const uint32_t first = e->work.clumps.member[e->work.clumps.start[k]];
  const double more = field_power(e, k) - booked;
  e->state->power_work[first] += more;
  e->state->field_work[first] += 0.5 * dt * more;
}

clump_load clump_damping(const engine *e, size_t k, double kappa, const clump_load *all) {
  const work *w = &e->work;
  clump_load damped = {{0.0, 0.0, 0.0}};
  for (int q = 0; w->body_forces && q < SD_COORDINATES; q++) {
    const columns *c = &w->clumps.columns[q];
    const double alpha = (q == SD_THETA ? w->clumps.alpha_rotation : w->clumps.alpha)[k];
    const double v = c->v[k] + kappa * (w->half_dt2 * (all->on[q] * c->inverse[k]) - c->q2[k]);
    if (c->inverse[k] != 0.0 && v != 0.0) damped.on[q] = -alpha * copysign(fabs(all->on[q]), v);
  }
  return damped;
}

void clump_book_damping(engine *e, size_t k, const clump_load *damped, double dt) {
  if (!e->work.body_forces) return;
  const uint32_t first = e->work.clumps.member[e->work.clumps.start[k]];
  double lost = 0.0;
  for (int q = 0; q < SD_COORDINATES; q++) lost -= damped->on[q] * e->work.clumps.columns[q].v[k];
  e->state->power_damping[first] += lost;
  e->state->loss_damping[first] += 0.5 * dt * lost;
}

void clump_accelerate(engine *e, size_t k) {
  const work *w = &e->work;
  clump_sum(e, k);
  const clump_load sum = clump_total(e, k), damped = clump_damping(e, k, 0.0, &sum);
  for (int q = 0; q < SD_COORDINATES; q++) {
    const columns *c = &w->clumps.columns[q];
    c->q2[k] = w->half_dt2 * ((sum.on[q] + damped.on[q]) * c->inverse[k]);
  }
  clump_book_field(e, k, clump_field_booked(e, k), 0.0);
  clump_book_damping(e, k, &damped, 0.0);
}

void clumps_accelerate(engine *e) {
  for (size_t k = 0; k < e->work.clumps.count; k++) clump_accelerate(e, k);
}

/* --- energy ----------------------------------------------------------------------------------- */

void clumps_add_energy(const engine *e, sd_energy *sum) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  const clumps *c = &w->clumps;
  for (size_t k = 0; k < c->count; k++) {
    const double at[] = {
        s->clump_x[k] + s->clump_image_x[k] * w->length[0] + s->clump_image_y[k] * w->offset,
        s->clump_y[k] + s->clump_image_y[k] * w->length[1], s->clump_theta[k] + s->clump_turn[k]};
    /* the potential of constant forces on single disks follows from the positions of these disks */
    double push[SD_COORDINATES] = {0.0, 0.0, 0.0}, levers = 0.0;
    for (size_t n = c->start[k]; n < c->start[k + 1]; n++) {
      const uint32_t i = c->member[n];
      push[SD_X] += w->constant_x[i];
      push[SD_Y] += w->constant_y[i];
      push[SD_THETA] += w->constant_torque[i];
      levers += w->constant_x[i] * c->arm_x[n] + w->constant_y[i] * c->arm_y[n];
    }
    for (int q = 0; q < SD_COORDINATES; q++) {
      const columns *of = &c->columns[q];
      if (of->inverse[k] == 0.0) continue;
      double *kinetic = q == SD_THETA ? &sum->kinetic_rotation : &sum->kinetic_translation;
      *kinetic += 0.5 * of->v[k] * of->v[k] / of->inverse[k];
      sum->external -= (of->constant[k] + push[q]) * at[q];
      if (q == SD_THETA) sum->external -= levers;
    }
  }
}

/* resultant.c: computes sums of forces and numbers of contacts at one time (see resultant.h). */
#include "measure/resultant.h"

#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/memory.h"
#include "measure/configuration.h"
#include "measure/observable.h"
#include "measure/stress.h"
#include "pack/compress.h"
#include "physics/step/outside.h"
#include "physics/system/bodies.h"

static const size_t NONE = SIZE_MAX;

/* Layout of resultants.sums: first WHOLE sums over all contacts and disks, with these indices; then
 * ROW sums (FORCE_X, ...) for each wall, each group and each chosen disk. */
enum { CONTACTS, SLIDING, OUTSIDE, VIRIAL, SQUARES, WHOLE };
enum { FORCE_X, FORCE_Y, TORQUE, NORMAL, TANGENTIAL, ROW_CONTACTS, ROW_SLIDING, ROW };

/* A state, or the part of it that one rank has. */
typedef struct part {
  const sd_model *model;
  const sd_state *state;
  const slot_table *slots;
  /* ranks that share the state; NULL: the state is complete */
  const comm *comm;
} part;

static exact_sum *walls_of(const resultants *r) { return r->sums + WHOLE; }
static exact_sum *groups_of(const resultants *r, const sd_model *m) {
  return walls_of(r) + ROW * m->n_walls;
}
static exact_sum *disks_of(const resultants *r, const sd_model *m) {
  return groups_of(r, m) + ROW * m->n_groups;
}

struct resultant_disk {
  uint32_t disk;
  size_t row;
};

static int by_disk(const void *one, const void *two) {
  const struct resultant_disk *p = one, *q = two;
  if (p->disk != q->disk) return p->disk < q->disk ? -1 : 1;
  return p->row < q->row ? -1 : p->row > q->row;
}

void resultants_new(resultants *r, const sd_model *m) {
  *r = (resultants){.n_sums = WHOLE + ROW * (m->n_walls + m->n_groups + m->n_contact_disks)};
  r->wall = memory_new(m->n_walls, sizeof *r->wall);
  r->group = memory_new(m->n_groups, sizeof *r->group);
  r->disk = memory_new(m->n_contact_disks, sizeof *r->disk);
  r->sums = memory_new(r->n_sums, sizeof *r->sums);
  r->chosen = memory_new(m->n_contact_disks, sizeof *r->chosen);
  for (size_t k = 0; k < m->n_contact_disks; k++)
    r->chosen[k] = (struct resultant_disk){m->contact_disks[k], k};
  qsort(r->chosen, m->n_contact_disks, sizeof *r->chosen, by_disk);
}

void resultants_free(resultants *r) {
  free(r->wall);
  free(r->group);
  free(r->disk);
  free(r->chosen);
  free(r->sums);
  *r = (resultants){0};
}

static void add_up(const part *p, exact_sum *sum, size_t n) { comm_total_exact(p->comm, sum, n); }

/* Returns true if this rank includes the body in this slot in its sums; each body is included by
 * exactly one rank. */
static bool counts(const part *p, size_t slot) {
  const sd_state *s = p->state;
  return slot < s->n_free || (comm_rank(p->comm) == 0 && slot >= s->n_free + s->n_ghosts);
}

/* --- sums over contacts ----------------------------------------------------------------------- */

/* A function that returns the index of the wall, group or chosen disk to which a body belongs;
 * NONE: it belongs to none. */
typedef size_t owner_of(const resultants *r, const part *p, uint32_t body);

static size_t wall_of(const resultants *r, const part *p, uint32_t body) {
  (void)r;
  return body >= p->model->n_disks ? body - p->model->n_disks : NONE;
}

static size_t group_of(const resultants *r, const part *p, uint32_t body) {
  (void)r;
  const int32_t group = p->state->group[slot_of(p->slots, body)];
  return group >= 0 ? (size_t)group : NONE;
}

static size_t chosen_of(const resultants *r, const part *p, uint32_t body) {
  size_t after = 0, end = p->model->n_contact_disks;
  while (after < end) {
    const size_t middle = after + (end - after) / 2;
    if (r->chosen[middle].disk <= body)
      after = middle + 1;
    else
      end = middle;
  }
  return after > 0 && r->chosen[after - 1].disk == body ? r->chosen[after - 1].row : NONE;
}

static void add_contacts(const resultants *r, const part *p, exact_sum *rows, owner_of *owner) {
  const sd_state *s = p->state;
  for (size_t c = 0; c < s->n_contacts; c++) {
    const size_t side[2] = {owner(r, p, s->contact_a[c]), owner(r, p, s->contact_b[c])};
    for (int x = 0; side[0] != side[1] && x < 2; x++) {
      if (side[x] == NONE) continue;
      exact_sum *row = rows + ROW * side[x];
      exact_sum_add(&row[NORMAL], s->contact_force[c]);
      exact_sum_add(&row[TANGENTIAL], configuration_tau(p->model, s, p->slots, c));
      exact_sum_add(&row[ROW_CONTACTS], 1.0);
      if (s->contact_slide[c] != 0) exact_sum_add(&row[ROW_SLIDING], 1.0);
    }
  }
}

/* Adds the force and torque on a body, which the engine has stored in the state, to the sums of
 * `row`. */
static void add_force(const part *p, exact_sum *row, uint32_t body) {
  const sd_state *s = p->state;
  const uint32_t slot = slot_of(p->slots, body);
  if (slot == SLOT_NONE || !counts(p, slot)) return;
  exact_sum_add(&row[FORCE_X], s->force_x[slot]);
  exact_sum_add(&row[FORCE_Y], s->force_y[slot]);
  exact_sum_add(&row[TORQUE], s->torque[slot]);
}

/* --- sums over all contacts and disks --------------------------------------------------------- */

/* Returns F_n r of contact c, with r the distance between the centres of the two disks, or between
 * the centre of the disk and the wall (compress.h). */
static double virial_of(const part *p, size_t c) {
  const sd_state *s = p->state;
  const uint32_t a = s->contact_a[c], b = s->contact_b[c];
  const double r = s->radius[slot_of(p->slots, a)] +
                   (b < p->model->n_disks ? s->radius[slot_of(p->slots, b)] : 0.0);
  return s->contact_force[c] * (r - s->contact_overlap[c]);
}

/* Adds the sums over all contacts and disks of this rank. A pair held by attraction alone (no
 * overlap) does not count as a contact. */
static void add_whole(const resultants *r, const part *p) {
  const sd_state *s = p->state;
  const bool compresses = series_compresses(p->model);
  int64_t contacts = 0, sliding = 0;
  for (size_t c = 0; c < s->n_contacts; c++) {
    const bool touches = s->contact_overlap[c] > 0.0;
    contacts += touches || !s->law_columns;
    sliding += touches && s->contact_slide[c] != 0;
    if (compresses) exact_sum_add(&r->sums[VIRIAL], virial_of(p, c));
  }
  for (size_t i = 0; compresses && i < s->n_free; i++)
    if (body_in_play(s, i)) exact_sum_add(&r->sums[SQUARES], s->radius[i] * s->radius[i]);
  for (size_t i = 0; compresses && s->n_clumps > 0 && i < s->n_free; i++)
    exact_sum_add(&r->sums[VIRIAL], compress_inner(p->model, s, i));
  exact_sum_add(&r->sums[CONTACTS], (double)contacts);
  exact_sum_add(&r->sums[SLIDING], (double)sliding);
  exact_sum_add(&r->sums[OUTSIDE], (double)outside_count(s));
}

/* --- groups ----------------------------------------------------------------------------------- */

/* Computes the unwrapped position at[] of the disk in this slot, from its image counts. */
static void absolute(const configuration *c, const sd_state *s, uint32_t slot, double at[2]) {
  at[0] = s->x[slot] + s->image_x[slot] * c->length[0] + s->image_y[slot] * c->offset;
  at[1] = s->y[slot] + s->image_y[slot] * c->length[1];
}

/* Returns the index in the state (slot) of a disk of the configuration. If several ranks share the
 * state, frames number disks by their slots. */
static uint32_t slot_in(const part *p, const configuration *c, uint32_t disk) {
  return p->comm ? c->number[disk] : slot_of(p->slots, c->number[disk]);
}

/* Indices of the sums for the centre of mass of a group: mass, mass times x, mass times y; their
 * number. */
enum { MASS, MASS_X, MASS_Y, CENTRE };

static void add_masses(exact_sum *sum, const part *p, const configuration *c) {
  double at[2];
  for (uint32_t i = 0; i < c->model->n_disks; i++) {
    const sd_disk *d = &c->model->disks[i];
    if (d->group < 0 || !configuration_counts(c, i)) continue;
    exact_sum *centre = sum + CENTRE * (size_t)d->group;
    absolute(c, p->state, slot_in(p, c, i), at);
    exact_sum_add(&centre[MASS], d->mass);
    exact_sum_add(&centre[MASS_X], d->mass * at[0]);
    exact_sum_add(&centre[MASS_Y], d->mass * at[1]);
  }
  add_up(p, sum, CENTRE * p->model->n_groups);
}

static void add_group_forces(exact_sum *rows, const double (*centre)[2], const part *p,
                             const configuration *c) {
  for (size_t k = 0; k < c->n_contacts; k++) {
    const config_contact *q = &c->contacts[k];
    const uint32_t body[2] = {q->a, q->b};
    int group[2];
    double at[2];
    for (int x = 0; x < 2; x++)
      group[x] = body[x] < c->model->n_disks ? c->model->disks[body[x]].group : -1;
    for (int x = 0; group[0] != group[1] && x < 2; x++) {
      if (group[x] < 0) continue;
      const double sign = x == 0 ? -1.0 : 1.0, fx = sign * q->fx, fy = sign * q->fy;
      const double *g = centre[group[x]];
      exact_sum *row = rows + ROW * (size_t)group[x];
      absolute(c, p->state, slot_in(p, c, body[x]), at);
      exact_sum_add(&row[FORCE_X], fx);
      exact_sum_add(&row[FORCE_Y], fy);
      const double turn = c->model->disks[body[x]].radius * q->tau - sign * q->couple;
      exact_sum_add(&row[TORQUE], (at[0] - g[0]) * fy - (at[1] - g[1]) * fx + turn);
    }
  }
}

static void group_forces(const resultants *r, const part *p, const configuration *c) {
  const size_t n = p->model->n_groups;
  exact_sum *sum = memory_new(CENTRE * n, sizeof *sum);
  double(*centre)[2] = memory_new(n, sizeof *centre);
  add_masses(sum, p, c);
  for (size_t k = 0; k < n; k++)
    for (int x = 0; x < 2; x++)
      centre[k][x] = exact_sum_value(&sum[CENTRE * k + MASS_X + (size_t)x]) /
                     exact_sum_value(&sum[CENTRE * k]);
  add_group_forces(groups_of(r, p->model), (const double(*)[2])centre, p, c);
  free(sum);
  free(centre);
}

/* --- region and stress ------------------------------------------------------------------------ */

static sd_status take_geometry(resultants *r, const part *p, const sd_model *constants,
                               const frame_data *f, sd_messages *messages) {
  configuration c;
  sd_status status = configuration_new(&c, constants, f, messages);
  if (status == SD_OK) {
    region g = configuration_region(&c, NULL);
    r->width = isfinite(g.upper[0]) ? g.upper[0] - g.lower[0] : NAN;
    r->height = isfinite(g.upper[1]) ? g.upper[1] - g.lower[1] : NAN;
    if (p->model->measure_stress) stress_tensors(r->stress, r->kinetic, &c, &g);
  }
  if (status == SD_OK && p->model->measure_groups) group_forces(r, p, &c);
  configuration_free(&c);
  return status;
}

static sd_status take_frame(resultants *r, const part *p, sd_messages *messages) {
  frame_data f;
  sd_model constants = {0};
  sd_status status =
      p->comm ? frame_data_of_part(&f, &constants, p->model, p->state, p->slots, p->comm, messages)
              : frame_data_of_state(&f, p->model, p->state, messages);
  if (status == SD_OK) status = take_geometry(r, p, p->comm ? &constants : p->model, &f, messages);
  frame_data_free(&f);
  free(constants.disks);
  if (p->comm && status != SD_OK) comm_fail(p->comm, "no memory");
  return status;
}

/* --- all resultants --------------------------------------------------------------------------- */

static void round_rows(resultant *out, const exact_sum *row, size_t n) {
  for (size_t k = 0; k < n; k++, row += ROW)
    out[k] = (resultant){.force_x = exact_sum_value(&row[FORCE_X]),
                         .force_y = exact_sum_value(&row[FORCE_Y]),
                         .torque = exact_sum_value(&row[TORQUE]),
                         .normal = exact_sum_value(&row[NORMAL]),
                         .tangential = exact_sum_value(&row[TANGENTIAL]),
                         .contacts = (int64_t)exact_sum_value(&row[ROW_CONTACTS]),
                         .sliding = (int64_t)exact_sum_value(&row[ROW_SLIDING])};
}

static void round_all(resultants *r, const sd_model *m, const sd_state *s) {
  const double area = compress_area(m, s);
  r->contacts = (int64_t)exact_sum_value(&r->sums[CONTACTS]);
  r->sliding = (int64_t)exact_sum_value(&r->sums[SLIDING]);
  r->outside = (int64_t)exact_sum_value(&r->sums[OUTSIDE]);
  r->pressure = exact_sum_value(&r->sums[VIRIAL]) / (2.0 * area);
  r->fraction = M_PI * exact_sum_value(&r->sums[SQUARES]) / area;
  if (m->measure_walls) round_rows(r->wall, walls_of(r), m->n_walls);
  if (m->measure_groups) round_rows(r->group, groups_of(r, m), m->n_groups);
  round_rows(r->disk, disks_of(r, m), m->n_contact_disks);
}

sd_status resultants_compute(resultants *r, const sd_model *m, const sd_state *s,
                             const slot_table *slots, const comm *c, sd_messages *messages) {
  const part p = {m, s, slots, c};
  sd_status status = SD_OK;
  memset(r->sums, 0, r->n_sums * sizeof *r->sums);
  add_whole(r, &p);
  if (m->measure_walls) add_contacts(r, &p, walls_of(r), wall_of);
  if (m->measure_groups) add_contacts(r, &p, groups_of(r, m), group_of);
  if (m->n_contact_disks) add_contacts(r, &p, disks_of(r, m), chosen_of);
  for (size_t k = 0; m->measure_walls && k < m->n_walls; k++)
    add_force(&p, walls_of(r) + ROW * k, (uint32_t)(m->n_disks + k));
  for (size_t k = 0; k < m->n_contact_disks; k++)
    add_force(&p, disks_of(r, m) + ROW * k, m->contact_disks[k]);
  if (m->measure_groups || m->measure_box || m->measure_stress)
    status = take_frame(r, &p, messages);
  add_up(&p, r->sums, r->n_sums);
  if (status == SD_OK) round_all(r, m, s);
  return status;
}

/* resultant.c: see resultant.h. */
#include "measure/resultant.h"

#include <stdlib.h>
#include <string.h>

#include "measure/configuration.h"
#include "measure/stress.h"

static const size_t NONE = SIZE_MAX;

sd_status resultants_new(resultants *r, const sd_model *m, sd_messages *messages) {
  *r = (resultants){0};
  r->wall = calloc(m->n_walls + 1, sizeof *r->wall);
  r->group = calloc(m->n_groups + 1, sizeof *r->group);
  r->disk = calloc(m->n_contact_disks + 1, sizeof *r->disk);
  r->chosen = calloc(m->n_disks + 1, sizeof *r->chosen);
  if (!r->wall || !r->group || !r->disk || !r->chosen)
    return sd_fail(messages, SD_ERROR_IO, "no memory for the series");
  for (size_t k = 0; k < m->n_contact_disks; k++) r->chosen[m->contact_disks[k]] = (uint32_t)k + 1;
  return SD_OK;
}

void resultants_free(resultants *r) {
  free(r->wall);
  free(r->group);
  free(r->disk);
  free(r->chosen);
  *r = (resultants){0};
}

/* --- sums over contacts -------------------------------------------------------------------------------- */

/* To which wall, group or chosen disk a body belongs. */
typedef size_t owner_of(const resultants *r, const sd_model *m, uint32_t body);

static size_t wall_of(const resultants *r, const sd_model *m, uint32_t body) {
  (void)r;
  return body >= m->n_disks ? body - m->n_disks : NONE;
}

static size_t group_of(const resultants *r, const sd_model *m, uint32_t body) {
  (void)r;
  return body < m->n_disks && m->disks[body].group >= 0 ? (size_t)m->disks[body].group : NONE;
}

static size_t chosen_of(const resultants *r, const sd_model *m, uint32_t body) {
  return body < m->n_disks && r->chosen[body] ? r->chosen[body] - 1 : NONE;
}

static void sum_contacts(const resultants *r, resultant *sum, owner_of *owner, const sd_model *m,
                         const frame_data *f) {
  for (size_t k = 0; k < f->n_contacts; k++) {
    const size_t side[2] = {owner(r, m, f->a[k]), owner(r, m, f->b[k])};
    for (int x = 0; side[0] != side[1] && x < 2; x++) {
      if (side[x] == NONE) continue;
      resultant *s = &sum[side[x]];
      s->normal += f->force[k];
      s->tangential += f->tau[k];
      s->contacts++;
      s->sliding += f->slide[k] != 0;
    }
  }
}

/* --- force and torque ---------------------------------------------------------------------------------- */

/* As the engine has them. */
static void copy_force(resultant *s, const sd_state *state, uint32_t slot) {
  s->force_x = state->force_x[slot];
  s->force_y = state->force_y[slot];
  s->torque = state->torque[slot];
}

typedef struct centre {
  double mass, x, y;
} centre;

/* Position with the images of a periodic box. */
static void absolute(const configuration *c, const sd_state *s, uint32_t slot, double at[2]) {
  at[0] = s->x[slot] + s->image_x[slot] * c->length[0];
  at[1] = s->y[slot] + s->image_y[slot] * c->length[1];
}

static sd_status group_forces(resultant *sum, const configuration *c, const sd_model *m, const sd_state *s,
                              const uint32_t *slots, sd_messages *messages) {
  centre *mean = calloc(m->n_groups + 1, sizeof *mean);
  if (!mean) return sd_fail(messages, SD_ERROR_IO, "no memory for the series");
  double at[2];
  for (size_t i = 0; i < c->model->n_disks; i++) {
    const sd_disk *d = &m->disks[c->number[i]];
    if (d->group < 0) continue;
    centre *g = &mean[d->group];
    absolute(c, s, slots[c->number[i]], at);
    g->mass += d->mass;
    g->x += d->mass * at[0];
    g->y += d->mass * at[1];
  }
  for (size_t k = 0; k < c->n_contacts; k++) {
    const config_contact *q = &c->contacts[k];
    const uint32_t body[2] = {q->a, q->b};
    int group[2];
    for (int x = 0; x < 2; x++)
      group[x] = body[x] < c->model->n_disks ? m->disks[c->number[body[x]]].group : -1;
    for (int x = 0; group[0] != group[1] && x < 2; x++) {
      if (group[x] < 0) continue;
      double sign = x == 0 ? -1.0 : 1.0, fx = sign * q->fx, fy = sign * q->fy;
      const centre *g = &mean[group[x]];
      resultant *r = &sum[group[x]];
      uint32_t number = c->number[body[x]];
      absolute(c, s, slots[number], at);
      r->force_x += fx;
      r->force_y += fy;
      r->torque +=
          (at[0] - g->x / g->mass) * fy - (at[1] - g->y / g->mass) * fx + m->disks[number].radius * q->tau;
    }
  }
  free(mean);
  return SD_OK;
}

/* --- region and stress --------------------------------------------------------------------------------- */

static sd_status take_geometry(resultants *r, const sd_model *m, const sd_state *s, const uint32_t *slots,
                               const frame_data *f, sd_messages *messages) {
  configuration c;
  sd_status status = configuration_new(&c, m, f, messages);
  if (status == SD_OK) {
    region g = configuration_region(&c, NULL);
    r->width = isfinite(g.upper[0]) ? g.upper[0] - g.lower[0] : NAN;
    r->height = isfinite(g.upper[1]) ? g.upper[1] - g.lower[1] : NAN;
    if (m->measure_stress) stress_tensors(r->stress, r->kinetic, &c, &g);
  }
  if (status == SD_OK && m->measure_groups) status = group_forces(r->group, &c, m, s, slots, messages);
  configuration_free(&c);
  return status;
}

sd_status resultants_take(resultants *r, const sd_model *m, const sd_state *s, const uint32_t *slots,
                          sd_messages *messages) {
  bool geometry = m->measure_groups || m->measure_box || m->measure_stress;
  if (!geometry && !m->measure_walls && m->n_contact_disks == 0) return SD_OK;
  memset(r->wall, 0, m->n_walls * sizeof *r->wall);
  memset(r->group, 0, m->n_groups * sizeof *r->group);
  memset(r->disk, 0, m->n_contact_disks * sizeof *r->disk);
  frame_data f;
  sd_status status = frame_data_of_state(&f, m, s, messages);
  if (status == SD_OK) {
    if (m->measure_walls) sum_contacts(r, r->wall, wall_of, m, &f);
    if (m->measure_groups) sum_contacts(r, r->group, group_of, m, &f);
    if (m->n_contact_disks) sum_contacts(r, r->disk, chosen_of, m, &f);
    for (size_t k = 0; k < m->n_walls; k++) copy_force(&r->wall[k], s, slots[m->n_disks + k]);
    for (size_t k = 0; k < m->n_contact_disks; k++) copy_force(&r->disk[k], s, slots[m->contact_disks[k]]);
  }
  if (status == SD_OK && geometry) status = take_geometry(r, m, s, slots, &f, messages);
  frame_data_free(&f);
  return status;
}

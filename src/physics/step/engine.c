/* engine.c: see engine.h. */
#include "physics/system/bodies.h"
#include "physics/step/engine.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "model/normal_laws.h"
#include "physics/step/contacts.h"
#include "physics/contact/energy.h"
#include "physics/system/kernels.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/neighbours/order.h"
#include "physics/contact/pairs.h"
#include "physics/step/speed.h"
#include "physics/step/sweep.h"
#include "physics/contact/walls.h"

/* --- state of step 0 --------------------------------------------------------------------------------- */

void engine_fill_disk(const sd_model *m, sd_state *s, uint32_t disk, uint32_t slot) {
  const sd_disk *d = &m->disks[disk];
  assert(slot < s->n_disks && (slot >= s->n_free) == d->driven);
  double turn = 8.0 * nearbyint(d->position[SD_THETA] / 8.0);
  s->id[slot] = disk;
  s->x[slot] = s->base_x[slot] = d->position[SD_X];
  s->y[slot] = s->base_y[slot] = d->position[SD_Y];
  s->base_theta[slot] = d->position[SD_THETA];
  s->turn[slot] = turn;
  s->theta[slot] = d->position[SD_THETA] - turn;
  assert(fabs(s->theta[slot]) <= 4.0);
  if (d->waiting && !d->driven) {
    s->activity[slot] = SD_WAITING;
  } else if (!d->driven) {
    s->vx[slot] = d->velocity[SD_X];
    s->vy[slot] = d->velocity[SD_Y];
    s->omega[slot] = d->velocity[SD_THETA];
  }
  s->radius[slot] = d->radius;
  s->mass[slot] = d->mass;
  s->inertia[slot] = d->inertia;
  s->material[slot] = d->material;
  s->group[slot] = d->group;
}

static void fill_contact(sd_state *s, const sd_contact_memory *c) {
  size_t k = s->n_contacts++;
  assert(k < s->contact_capacity && c->a < s->n_disks && c->b < s->n_bodies && c->a != c->b);
  s->contact_a[k] = c->a;
  s->contact_b[k] = c->b;
  s->contact_part[k] = c->part;
  s->contact_side[k] = c->side;
  s->contact_slide[k] = c->slide;
  sd_state_set_record(s, k, &c->record);
}

static sd_status fill_contacts(const sd_model *m, sd_state *s) {
  if (m->n_memories == 0) return SD_OK;
  if (sd_state_reserve_contacts(s, m->n_memories) != SD_OK) return SD_ERROR_IO;
  for (size_t k = 0; k < m->n_memories; k++) fill_contact(s, &m->memories[k]);
  return order_contacts(m, s);
}

sd_status engine_fill_state(const sd_model *m, sd_state *s) {
  uint32_t slot = 0;
  for (int driven = 0; driven < 2; driven++)
    for (uint32_t i = 0; i < m->n_disks; i++)
      if (m->disks[i].driven == (driven != 0)) engine_fill_disk(m, s, i, slot++);
  assert(slot == s->n_disks && m->n_free == s->n_free);
  for (uint32_t k = 0; k < m->n_walls; k++, slot++) {
    const sd_wall *wall = &m->walls[k];
    s->id[slot] = (uint32_t)m->n_disks + k;
    s->x[slot] = s->base_x[slot] = wall->pivot[0];
    s->y[slot] = s->base_y[slot] = wall->pivot[1];
    if (wall->kind == SD_WALL_CIRCLE) s->radius[slot] = wall->inside ? -wall->radius : wall->radius;
    s->material[slot] = wall->material;
    s->group[slot] = -1;
  }
  assert(slot == s->n_bodies);
  for (size_t k = 0; k < s->n_motions; k++) s->motion_start[k] = -1;
  if (s->n_free >= ORDER_LEAST && order_disks(m, s) != SD_OK) return SD_ERROR_IO;
  return fill_contacts(m, s);
}

/* --- work -------------------------------------------------------------------------------------------- */

static void fill_laws(const sd_model *m, work *w) {
  w->one_law = true;
  for (size_t k = 0; k < m->n_materials * m->n_materials; k++) {
    const sd_contact_law *l = &m->laws[k];
    w->laws[k] = (law_row){.k_n = l->k_n,
                           .k_t = l->k_t,
                           .gamma_n = l->gamma_n,
                           .cap = l->k_t > 0.0 ? l->mu / l->k_t : 0.0,
                           .normal = l->normal,
                           .tsuji = law_tsuji(l)};
    assert(l->normal < SD_NORMAL_LAWS && w->laws[k].cap >= 0.0);
    if (l->k_n > 0.0 && l->normal != SD_NORMAL_LINEAR) w->mixed_laws = true;
    if (l->k_n != m->laws->k_n || l->k_t != m->laws->k_t || l->gamma_n != m->laws->gamma_n ||
        l->mu != m->laws->mu || l->normal != m->laws->normal || l->restitution != m->laws->restitution)
      w->one_law = false;
  }
}

static void fill_columns(const sd_state *s, work *w) {
  w->columns[SD_X] = (columns){.q = s->x,
                               .v = s->vx,
                               .q2 = s->x2,
                               .q3 = s->x3,
                               .q4 = s->x4,
                               .q5 = s->x5,
                               .force = s->force_x,
                               .constant = w->constant_x,
                               .inverse = w->inverse_mass_x};
  w->columns[SD_Y] = (columns){.q = s->y,
                               .v = s->vy,
                               .q2 = s->y2,
                               .q3 = s->y3,
                               .q4 = s->y4,
                               .q5 = s->y5,
                               .force = s->force_y,
                               .constant = w->constant_y,
                               .inverse = w->inverse_mass_y};
  w->columns[SD_THETA] = (columns){.q = s->theta,
                                   .v = s->omega,
                                   .q2 = s->theta2,
                                   .q3 = s->theta3,
                                   .q4 = s->theta4,
                                   .q5 = s->theta5,
                                   .force = s->torque,
                                   .constant = w->constant_torque,
                                   .inverse = w->inverse_inertia};
}

static void fill_limit(const engine *e, work *w) {
  double least = HUGE_VAL;
  for (size_t i = 0; i < e->state->n_bodies; i++)
    if (e->state->radius[i] != 0.0) least = fmin(least, fabs(e->state->radius[i]));
  w->least_limit = e->model->max_overlap * least;
  assert(w->least_limit > 0.0);
}

static void fill_skin(const engine *e, work *w) {
  const sd_state *s = e->state;
  double mean = 0.0;
  for (size_t i = 0; i < s->n_disks; i++) mean += s->radius[i];
  mean /= (double)s->n_disks;
  assert(mean > 0.0);
  w->mean_radius = mean;
  w->skin = e->model->skin > 0.0 ? e->model->skin : 0.15 * mean; /* to begin with: neighbours_tune */
}

static sd_status columns_new(engine *e) {
  const sd_state *s = e->state;
  work *w = &e->work;
  const struct {
    double **at;
    size_t n;
  } column[] = {
      {&w->inverse_mass_x, s->n_free}, {&w->inverse_mass_y, s->n_free}, {&w->inverse_inertia, s->n_free},
      {&w->constant_x, s->n_free},     {&w->constant_y, s->n_free},     {&w->constant_torque, s->n_free},
      {&w->x0, s->n_bodies},           {&w->y0, s->n_bodies},           {&w->theta0, s->n_bodies},
      {&w->reach, s->n_bodies}};
  enum { COLUMNS = sizeof column / sizeof *column };
  arena_plan plan = {0};
  for (size_t k = 0; k < COLUMNS; k++) arena_column(&plan, column[k].n * sizeof(double));
  char *room = w->arena = arena_new(&plan);
  if (!room) return SD_ERROR_IO;
  plan = (arena_plan){0};
  for (size_t k = 0; k < COLUMNS; k++)
    *column[k].at = (double *)(void *)(room + arena_column(&plan, column[k].n * sizeof(double)));
  return SD_OK;
}

static sd_status allocate(engine *e, int threads) {
  const sd_model *m = e->model;
  const sd_state *s = e->state;
  work *w = &e->work;
  w->laws = calloc(m->n_materials * m->n_materials, sizeof *w->laws);
  w->slot = calloc(s->n_bodies, sizeof *w->slot);
  w->segments = calloc(m->n_segments + 1, sizeof *w->segments);
  w->watched = calloc(2 * m->n_slides + 1, sizeof *w->watched);
  w->threads = aligned_alloc(64, (size_t)threads * sizeof *w->threads);
  w->n_threads = threads;
  if (w->threads) memset(w->threads, 0, (size_t)threads * sizeof *w->threads);
  bool bad = !w->laws || !w->slot || !w->segments || !w->watched || !w->threads;
  return bad || columns_new(e) != SD_OK ? SD_ERROR_IO : SD_OK;
}

/* Pages stand near the thread that writes them first: each writes zeros to its part of what has just been mapped. Of the pairs
 * there are as many as disks in a packing have; where more are found, one thread makes room for all. */
enum { PAIRS_PER_DISK = 3 };
static sd_status touch_first(engine *e) {
  work *w = &e->work;
  const size_t n = e->state->n_free, candidates = PAIRS_PER_DISK * n;
  if (w->n_threads == 1 || n == 0) return SD_OK;
  if (pairs_reserve(&w->pairs, candidates) != SD_OK || pairs_reserve(&w->spare, candidates) != SD_OK)
    return SD_ERROR_IO;
#ifdef _OPENMP
  const int threads = w->n_threads;
#pragma omp parallel for num_threads(threads) schedule(static)
  for (int t = 0; t < threads; t++) {
    const size_t from = n * (size_t)t / (size_t)threads, to = n * ((size_t)t + 1) / (size_t)threads;
    const size_t first = candidates * (size_t)t / (size_t)threads / PAIR_BLOCK;
    const size_t end = candidates * ((size_t)t + 1) / (size_t)threads / PAIR_BLOCK;
    memset(w->pairs.block + first, 0, (end - first) * sizeof(pair_block));
    memset(w->spare.block + first, 0, (end - first) * sizeof(pair_block));
    double *column[] = {w->inverse_mass_x,
                        w->inverse_mass_y,
                        w->inverse_inertia,
                        w->constant_x,
                        w->constant_y,
                        w->constant_torque,
                        w->x0,
                        w->y0};
    for (size_t k = 0; k < sizeof column / sizeof *column; k++)
      memset(column[k] + from, 0, (to - from) * sizeof(double));
  }
#endif
  return SD_OK;
}

/* Places of rows are numbers of 32 bits; of sums there are a few for every body. */
enum { MOST_BODIES = 50000000 };

sd_status engine_build(engine *e, int threads, sd_messages *messages) {
  work *w = &e->work;
  assert(threads >= 1 && threads <= WORK_MAX_THREADS && !w->slot && e->model->dt > 0.0);
  if (e->state->n_bodies > MOST_BODIES)
    return sd_fail(messages, SD_ERROR_USER, "%zu disks and walls: expected at most %d", e->state->n_bodies,
                   MOST_BODIES);
  if (allocate(e, threads) != SD_OK || touch_first(e) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the system");
  w->dt = e->model->dt;
  w->per_dt = 1.0 / w->dt;
  w->half_dt2 = 0.5 * w->dt * w->dt;
  speed_begin(e);
  w->conservative = e->model->variant == SD_CONSERVATIVE;
  w->kernels = kernels_choose();
  fill_laws(e->model, w);
  fill_columns(e->state, w);
  box_update(e);
  fill_skin(e, w);
  fill_limit(e, w);
  for (uint32_t k = 0; k < e->state->n_bodies; k++) {
    assert(e->state->id[k] < e->state->n_bodies &&
           w->slot[e->state->id[k]] == 0); /* the first stands in slot 0 */
    w->slot[e->state->id[k]] = k;
  }
  bodies_fill_constants(e);
  sd_status status = motion_new(e, messages);
  if (status == SD_OK && motion_resume(e) != SD_OK)
    status = sd_fail(messages, SD_ERROR_IO, "out of memory for the motions");
  walls_pose(e);
  if (status == SD_OK) status = neighbours_build(e, messages);
  if (status == SD_OK) contacts_load(e);
  return status;
}

void engine_free(engine *e) {
  work *w = &e->work;
  motion_free(e);
  neighbours_free(e);
  for (int t = 0; w->threads && t < w->n_threads; t++) {
    free(w->threads[t].events.item);
    free(w->threads[t].returns.item);
  }
  free(w->threads);
  free(w->laws);
  free(w->slot);
  free(w->segments);
  free(w->watched);
  arena_free(w->arena);
  e->work = (work){0};
}

/* --- step 0 ------------------------------------------------------------------------------------------ */

/* After the first pass: contacts of the packing that are none here. They did not open, so nothing is booked.
 * loaded: contacts that were closed before the pass. */
static void drop_apart(engine *e, size_t loaded, sd_messages *messages) {
  work *w = &e->work;
  size_t kept = loaded, n = e->model->n_memories;
  for (size_t k = 0; k < w->threads[0].events.count; k++) {
    event *v = &w->threads[0].events.item[k];
    if (pairs_closed(&w->pairs, v->index)) continue;
    v->transferred = true;
    assert(v->was_closed && kept > 0);
    kept--;
  }
  if (kept < n)
    sd_warn(messages, "%zu of %zu contacts of the packing do not touch at the start: they are dropped",
            n - kept, n);
}

sd_status engine_start(engine *e, sd_messages *messages) {
  sd_state *s = e->state;
  work *w = &e->work;
  size_t loaded = 0;
  assert(s->step == 0);
  for (size_t k = 0; k < w->pairs.count; k++) loaded += pairs_closed(&w->pairs, k);
  sweep_forces(e);
  /* nothing was lost on the way here */
  for (size_t k = 0; k < w->pairs.count; k++)
    PAIR(&w->pairs, k, viscous) = PAIR(&w->pairs, k, friction) = PAIR(&w->pairs, k, nonconservative_work) =
        0.0;
  drop_apart(e, loaded, messages);
  sd_status status = contacts_events(e, messages);
  for (size_t i = 0; i < s->n_free; i++) {
    s->x2[i] = w->half_dt2 * ((s->force_x[i] + w->constant_x[i]) * w->inverse_mass_x[i]);
    s->y2[i] = w->half_dt2 * ((s->force_y[i] + w->constant_y[i]) * w->inverse_mass_y[i]);
    s->theta2[i] = w->half_dt2 * ((s->torque[i] + w->constant_torque[i]) * w->inverse_inertia[i]);
  }
  sd_energy now = energy_of(e);
  s->energy_start = energy_total(&now);
  speed_check(e, 0);
  return status;
}

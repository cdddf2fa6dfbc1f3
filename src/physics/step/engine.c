/* engine.c: creates, starts and frees the work of a system; implements engine.h. */
#include "physics/step/engine.h"
#include "physics/system/bodies.h"
#include "physics/system/clumps.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "model/laws.h"
#include "model/model.h"
#include "model/normal_laws.h"
#include "model/rows.h"
#include "physics/contact/energy.h"
#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/step/access.h"
#include "physics/step/cell.h"
#include "physics/step/contacts.h"
#include "physics/step/step.h"
#include "physics/step/window.h"
#include "physics/system/fields.h"
#include "physics/system/halo.h"
#include "physics/system/kernels.h"

/* --- state of step 0 -------------------------------------------------------------------------- */

/* Sets one number in a new column, in which all numbers are zero. Zeros are not written, so that
 * pages with zeros only take no memory. */
static void set(double *at, double value) {
  if (value != 0.0 || signbit(value)) *at = value;
}

void engine_fill_disk(sd_state *s, const sd_disk *d, uint32_t number, uint32_t slot) {
  assert(slot < s->n_disks && (slot >= s->n_free) == d->driven);
  double turn = 8.0 * nearbyint(d->position[SD_THETA] / 8.0);
  s->id[slot] = number;
  s->x[slot] = s->base_x[slot] = d->position[SD_X];
  s->y[slot] = s->base_y[slot] = d->position[SD_Y];
  set(&s->base_theta[slot], d->position[SD_THETA]);
  set(&s->turn[slot], turn);
  set(&s->theta[slot], d->position[SD_THETA] - turn);
  assert(fabs(s->theta[slot]) <= 4.0);
  if (d->waiting && !d->driven) {
    s->activity[slot] = SD_WAITING;
  } else if (!d->driven) {
    if (d->held) s->activity[slot] = SD_HELD;
    if (!(d->held && d->holds[SD_X])) set(&s->vx[slot], d->velocity[SD_X]);
    if (!(d->held && d->holds[SD_Y])) set(&s->vy[slot], d->velocity[SD_Y]);
    if (!(d->held && d->holds[SD_THETA])) set(&s->omega[slot], d->velocity[SD_THETA]);
  }
  s->radius[slot] = d->radius;
  s->mass[slot] = d->mass;
  s->inertia[slot] = d->inertia;
  s->material[slot] = d->material;
  s->group[slot] = d->group;
}

void engine_fill_contact(sd_state *s, const sd_contact_memory *c) {
  size_t k = s->n_contacts++;
  assert(k < s->contact_capacity && c->a != c->b);
  s->contact_a[k] = c->a;
  s->contact_b[k] = c->b;
  s->contact_part[k] = c->part;
  s->contact_side[k] = c->side;
  s->contact_slide[k] = c->slide + (c->force_carried ? SD_FORCE_CARRIED : 0);
  sd_state_set_record(s, k, &c->record);
}

void engine_fill_derivatives(sd_state *s, size_t slot, const double derivatives[SD_DERIVATIVES]) {
  double *const column[SD_DERIVATIVES] = {s->x3, s->x4,     s->x5,     s->y3,    s->y4,
                                          s->y5, s->theta3, s->theta4, s->theta5};
  for (size_t k = 0; k < SD_DERIVATIVES; k++) column[k][slot] = derivatives[k];
}

sd_status engine_fill_contacts(sd_state *s, size_t n, const sd_contact_memory *contacts) {
  if (sd_state_reserve_contacts(s, s->n_contacts + n) != SD_OK) return SD_ERROR_IO;
  for (size_t k = 0; k < n; k++) engine_fill_contact(s, &contacts[k]);
  return SD_OK;
}

void engine_fill_prescribed(const sd_model *m, sd_state *s) {
  uint32_t slot = (uint32_t)(s->n_free + s->n_ghosts);
  for (size_t k = 0; k < model_known(m); k++) {
    const uint32_t i = model_known_disk(m, k);
    if (m->disks[i].driven) engine_fill_disk(s, &m->disks[i], i, slot++);
  }
  assert(slot == s->n_disks);
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
  clumps_fill_state(m, s);
  for (size_t k = 0; k < s->n_motions; k++) s->motion_start[k] = -1;
}

sd_status engine_fill_state(const sd_model *m, sd_state *s) {
  uint32_t slot = 0;
  for (uint32_t i = 0; i < m->n_disks; i++)
    if (!m->disks[i].driven) engine_fill_disk(s, &m->disks[i], i, slot++);
  assert(slot == s->n_free && slot == m->n_free);
  engine_fill_prescribed(m, s);
  if (slot >= ORDER_LEAST && order_disks(m, s) != SD_OK) return SD_ERROR_IO;
  for (slot = 0; m->n_derivatives > 0 && slot < s->n_free; slot++)
    if (s->id[slot] < m->n_derivatives)
      engine_fill_derivatives(s, slot, m->derivatives[s->id[slot]]);
  const sd_status status = engine_fill_contacts(s, m->n_memories, m->memories);
  return status == SD_OK && s->n_contacts > 0 ? order_contacts(m, s) : status;
}

/* --- creation of the work --------------------------------------------------------------------- */

static law_row row_of(const sd_contact_law *l) {
#define LAW_VALUE(features, name, value) .name = value,
  return (law_row){.k_n = l->k_n,
                   .k_t = l->k_t,
                   .gamma_n = l->gamma_n,
                   .cap = law_ratio(l->mu, l->k_t),
                   .normal = l->normal,
                   .tsuji = law_tsuji(l),
                   LAW_CONSTANTS(LAW_VALUE)};
#undef LAW_VALUE
}

/* Compares two rows of the law table, all of whose members are doubles. */
static bool same_row(const law_row *a, const law_row *b) {
  double p[sizeof *a / sizeof(double)], q[sizeof *b / sizeof(double)];
  memcpy(p, a, sizeof p);
  memcpy(q, b, sizeof q);
  bool same = true;
  for (size_t k = 0; k < sizeof p / sizeof *p; k++) same = same && p[k] == q[k];
  return same;
}

static void fill_laws(const sd_model *m, work *w) {
  w->one_law = true;
  w->features = laws_features(m);
  w->margin = laws_range(m);
  for (size_t k = 0; k < m->n_materials * m->n_materials; k++) {
    w->laws[k] = row_of(&m->laws[k]);
    assert(m->laws[k].normal < SD_NORMAL_LAWS && w->laws[k].cap >= 0.0);
    if (!same_row(&w->laws[k], &w->laws[0])) w->one_law = false;
  }
  w->pairs.wants_more = w->spare.wants_more = (w->features & LAW_GENERAL) != 0;
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
    if (e->state->radius[i] != 0.0) least = math_min(least, fabs(e->state->radius[i]));
  w->max_overlap = e->model->max_overlap;
  w->least_limit = w->max_overlap * least;
  assert(w->least_limit > 0.0);
}

double engine_first_skin(const sd_model *m) {
  return m->skin > 0.0 ? m->skin : 0.15 * m->mean_radius;
}

static void fill_skin(const engine *e, work *w) {
  const sd_model *m = e->model;
  const double mean = m->mean_radius;
  assert(mean > 0.0);
  w->mean_radius = mean;
  int exponent; /* mean = m 2^exponent, m in [1/2, 1) */
  w->surface_unit = frexp(mean, &exponent) == 0.5 ? mean : ldexp(1.0, exponent);
  w->skin = e->halo && e->halo->skin > 0.0 ? e->halo->skin : engine_first_skin(m);
}

static sd_status columns_new(engine *e) {
  const sd_state *s = e->state;
  work *w = &e->work;
  const struct {
    double **at;
    size_t n;
  } column[] = {{&w->inverse_mass_x, s->n_free},
                {&w->inverse_mass_y, s->n_free},
                {&w->inverse_inertia, s->n_free},
                {&w->constant_x, s->n_free},
                {&w->constant_y, s->n_free},
                {&w->constant_torque, s->n_free},
                {&w->x0, s->n_bodies},
                {&w->y0, s->n_bodies},
                {&w->theta0, s->n_bodies},
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
  w->laws = memory_new(m->n_materials * m->n_materials, sizeof *w->laws);
  w->segments = memory_new(m->n_segments, sizeof *w->segments);
  w->pieces = memory_new(m->n_segments, sizeof *w->pieces);
  w->watched = memory_new(2 * m->n_slides, sizeof *w->watched);
  w->threads = memory_lines((size_t)threads * sizeof *w->threads);
  w->n_threads = threads;
  return slot_table_new(&w->slots, s, sd_model_bodies(m)) ? columns_new(e) : SD_ERROR_IO;
}

/* Number of columns of `work` with one number per free disk. */
enum { FREE_COLUMNS = 8 };
static void free_columns(const work *w, double *column[FREE_COLUMNS]) {
  double *all[FREE_COLUMNS] = {w->inverse_mass_x,
                               w->inverse_mass_y,
                               w->inverse_inertia,
                               w->constant_x,
                               w->constant_y,
                               w->constant_torque,
                               w->x0,
                               w->y0};
  memcpy(column, all, sizeof all);
}

/* Writes zeros to this thread's part of new columns, so that the operating system places each
 * memory page near the thread that will use it. */
static void touch_first(const team *t, void *with) {
  const engine *e = with;
  const work *w = &e->work;
  size_t from, to;
  team_share(t, e->state->n_free, &from, &to);
  double *column[FREE_COLUMNS];
  free_columns(w, column);
  for (size_t k = 0; k < FREE_COLUMNS; k++)
    memset(column[k] + from, 0, (to - from) * sizeof(double));
}

void engine_find_slots(engine *e) { slot_table_fill(&e->work.slots, e->state); }

/* Builds all members of `work` except the neighbour lists, the contacts and the constants of
 * bodies. */
static sd_status build_bodies(engine *e, int threads, sd_messages *messages) {
  work *w = &e->work;
  assert(threads >= 1 && threads <= WORK_MAX_THREADS && !w->slots.slot && e->model->dt > 0.0);
  if (allocate(e, threads) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the system");
  fill_laws(e->model, w);
  w->n_disks = (int32_t)e->state->n_disks;
  w->dt = e->model->dt;
  w->per_dt = 1.0 / w->dt;
  w->half_dt2 = 0.5 * w->dt * w->dt;
  speed_begin(e);
  w->conservative = e->model->variant == SD_CONSERVATIVE;
  w->kernels = kernels_choose();
  fill_columns(e->state, w);
  box_update(e);
  cell_attach(e);
  cell_pose(e, e->state->step);
  fill_skin(e, w);
  fill_limit(e, w);
  if (clumps_new(e) != SD_OK || body_forces_new(e) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the system");
  const sd_status status = motion_new(e, messages);
  if (status == SD_OK) motion_resume(e);
  return status;
}

/* Largest number of bodies in one process: offsets of rows are 32-bit integers, and each body has
 * several rows of force sums. */
enum { MOST_BODIES = 50000000 };

static sd_status build_lists(engine *e, sd_messages *messages) {
  if (e->state->n_bodies > MOST_BODIES)
    return sd_fail(messages, SD_ERROR_USER,
                   "%zu disks and walls: expected at most %d in one process; the ranks of an MPI "
                   "job can share "
                   "more",
                   e->state->n_bodies, MOST_BODIES);
  walls_pose(e);
  sd_status status = neighbours_build(e, messages);
  if (status == SD_OK) contacts_load(e);
  return status;
}

sd_status engine_build(engine *e, int threads, sd_messages *messages) {
  sd_status status = build_bodies(e, threads, messages);
  if (status != SD_OK) return status;
  pool_run(e->pool, touch_first, e);
  bodies_fill_constants(e);
  return build_lists(e, messages);
}

sd_status engine_renew(engine *e, sd_messages *messages) {
  return e->renew ? e->renew(e, messages) : neighbours_build(e, messages);
}

bool engine_renew_laws(engine *e) {
  work *w = &e->work;
  const double margin = w->margin;
  const unsigned features = w->features;
  fill_laws(e->model, w);
  return w->margin == margin && w->features == features;
}

sd_status engine_renew_motions(engine *e, sd_messages *messages) {
  motion_free(e);
  const sd_status status = motion_new(e, messages);
  if (status == SD_OK) motion_resume(e);
  return status;
}

bool engine_is_built(const engine *e) { return e->work.slots.slot; }

void engine_free(engine *e) {
  work *w = &e->work;
  motion_free(e);
  body_forces_free(e);
  neighbours_free(e);
  window_free(&w->window);
  for (int t = 0; w->threads && t < w->n_threads; t++) {
    free(w->threads[t].events.item);
    free(w->threads[t].returns.item);
    free(w->threads[t].crossings.item);
  }
  free(w->threads);
  free(w->laws);
  slot_table_free(&w->slots);
  free(w->segments);
  free(w->pieces);
  free(w->watched);
  clumps_free(e);
  arena_free(w->arena);
  e->work = (work){0};
}

/* --- step 0 ----------------------------------------------------------------------------------- */

/* Marks contacts of the input packing that turn out not to touch in the first evaluation: they are
 * dropped without counting their elastic energy as lost. Returns the number of these contacts that
 * this rank counts. */
static size_t drop_apart(engine *e) {
  work *w = &e->work;
  size_t dropped = 0;
  for (int t = 0; t < w->n_threads; t++)
    for (size_t k = 0; k < w->threads[t].events.count; k++) {
      event *v = &w->threads[t].events.item[k];
      if (pairs_closed(&w->pairs, v->index)) continue;
      v->unbooked = true;
      assert(v->was_closed);
      dropped += halo_counts(e, v->index);
    }
  return dropped;
}

static void warn_of_dropped(const sd_model *model, size_t kept, sd_messages *messages) {
  const size_t n = model->all_memories;
  if (kept < n)
    sd_warn(messages,
            "%zu of %zu contacts of the packing do not touch at the start: they are dropped",
            n - kept, n);
}

/* Evaluates step 0 for the bodies of this rank. *kept: number of contacts of the input packing that
 * are still closed. */
static sd_status start_part(engine *e, size_t *kept, sd_messages *messages) {
  sd_state *s = e->state;
  work *w = &e->work;
  assert(s->step == 0);
  *kept = contacts_count(e);
  motion_first_speeds(e);
  clumps_place_all(e);
  contacts_restore_before(e);
  chunks_forces(e, CHUNKS_EVALUATE);
  contacts_restore_after(e);
  if (e->model->forces_carried) chunks_forces(e, CHUNKS_SUM);
  if (cell_work(e, true) != SD_OK) return SD_ERROR_IO;
  /* evaluations at step 0 must not count as energy losses */
  for (size_t k = 0; k < w->pairs.count; k++) losses_forget(&w->pairs, k);
  *kept -= drop_apart(e);
  sd_status status = contacts_events(e, messages);
  for (size_t i = 0; s->law_columns && i < s->n_free; i++)
    s->loss_bridge[i] = s->broken_tension[i] = s->broken_shear[i] = s->broken_bending[i] = 0.0;
  body_forces_renew(e, 0, s->n_free);
  for (int c = 0; c < SD_COORDINATES; c++)
    for (size_t i = 0; i < s->n_free; i++) engine_accelerate(e, c, i, w->columns[c].force[i]);
  clumps_accelerate(e);
  speed_check(e, 0);
  return status;
}

sd_status engine_start(engine *e, sd_messages *messages) {
  size_t kept;
  sd_status status = comm_agree(e->comm, start_part(e, &kept, messages));
  if (e->halo && status == SD_OK) {
    step_agree(e, false); /* this also updates contacts with ghosts */
    status = comm_agree(e->comm, engine_status(e));
  }
  if (status != SD_OK) return status;
  warn_of_dropped(e->model, (size_t)comm_total(e->comm, (double)kept), messages);
  const sd_energy now = energy_of(e);
  e->state->energy_start = energy_total(&now);
  return SD_OK;
}

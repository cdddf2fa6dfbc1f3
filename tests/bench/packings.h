/* packings.h: the packings of bench_steps --scaling: disks of 0.8 to 1.2 mean radii on a flat floor, periodic along x,
 * settled under gravity, then shaken by the floor, which moves by A (1 - cos wt), and goes on moving.
 *
 * A packing of 1000 disks (or fewer) is made; larger ones are copies of it side by side, contacts and their memories
 * included. Contacts across the period become contacts of neighbouring copies. Law and sizes are those of cases.h, the
 * floor that of tools/peers.
 */
#ifndef BENCH_PACKINGS_H
#define BENCH_PACKINGS_H

#include <math.h>

#include "bench/cases.h"

enum { BASE_DISKS = 1000, BASE_ROWS = 25, FEW_ROWS = 10, LEAST_DISKS = 50 };
enum { PERIOD = 625, SETTLE_STEPS = 30000 }; /* 80 Hz at the time step of the packings */

/* What makes the number of contacts: friction, pressure, and how hard the floor shakes. Those with few contacts are
 * kept apart by collisions; that their candidates are no fewer lies in the skin of the lists. */
typedef struct packing_kind {
  const char *name;
  double mu, gamma_n;
  double gravity, shaking; /* largest acceleration of the floor; both over 9.81 */
  int64_t periods;         /* of shaking, before it is measured */
} packing_kind;

static const packing_kind packing_kinds[] = {
    {"gas", 0.1, 0.5, 0.1, 40.0, 160},    /* 0.5 contacts per disk */
    {"fluid", 0.5, 1.0, 0.1, 20.0, 160},  /* 0.8 */
    {"thrown", 0.5, 5.0, 1.0, 40.0, 160}, /* 1.2 */
    {"shaken", 0.5, 5.0, 1.0, 10.0, 160}, /* 1.5 */
    {"floor", 0.5, 5.0, 1.0, 0.3, 20},    /* 1.7: that of tools/peers */
    {"smooth", 0.0, 5.0, 1.0, 0.3, 20},   /* 2.0 */
    {"pressed", 0.0, 5.0, 10.0, 3.0, 20}, /* 2.2 */
};
enum { PACKING_KINDS = sizeof packing_kinds / sizeof *packing_kinds };

typedef struct packing {
  const packing_kind *kind;
  double width; /* of the period, from 0 */
  size_t n_disks, n_contacts;
  sd_disk *disks;
  sd_contact_memory *contacts; /* body n_disks is the floor */
} packing;

static void free_packing(packing *p) {
  free(p->disks);
  free(p->contacts);
  *p = (packing){0};
}

/* A (1 - cos wt): a sine that begins a quarter of a period early, and a constant. */
static void add_floor_motions(sd_model *m, const packing_kind *kind) {
  double omega = 2.0 * acos(-1.0) / (PERIOD * m->dt),
         amplitude = 9.81 * kind->shaking / (omega * omega);
  m->n_motions = 2;
  m->motions = room(2, sizeof *m->motions);
  sd_motion *wave = &m->motions[0], *raise = &m->motions[1];
  *wave = (sd_motion){.kind = SD_MOTION_HARMONIC,
                      .amplitude = amplitude,
                      .omega = omega,
                      .phase = -0.5 * acos(-1.0)};
  *raise = (sd_motion){.kind = SD_MOTION_TABLE, .amplitude = 1.0, .n_table = 3};
  raise->table_time = room(3, sizeof(double));
  raise->table_value = room(3, sizeof(double));
  for (int k = 0; k < 3; k++) {
    raise->table_time[k] = 1e6 * k;
    raise->table_value[k] = amplitude;
  }
  for (size_t k = 0; k < 2; k++) {
    m->motions[k].coordinate = SD_Y;
    m->motions[k].n_bodies = 1;
    m->motions[k].bodies = room(1, sizeof(uint32_t));
    m->motions[k].bodies[0] = (uint32_t)m->n_disks;
  }
}

static void add_floor(sd_model *m) {
  static const double line[2][2] = {{0.0, 0.0}, {1.0, 0.0}};
  m->n_walls = 1;
  m->walls = room(1, sizeof *m->walls);
  m->walls[0] = (sd_wall){.kind = SD_WALL_LINE, .n_points = 2, .points = room(2, sizeof line[0])};
  memcpy(m->walls[0].points, line, sizeof line);
}

/* One endless phase in which the floor moves, after `rest` steps in which it does not. */
static void add_phases(sd_model *m, int64_t rest) {
  m->n_phases = rest ? 2 : 1;
  m->phases = room(m->n_phases, sizeof *m->phases);
  for (size_t k = 0; k < m->n_phases; k++) {
    bool moves = k + 1 == m->n_phases;
    m->phases[k].steps = moves ? (int64_t)1e15 : rest;
    m->phases[k].active = room(m->n_motions, sizeof(bool));
    for (size_t q = 0; q < m->n_motions; q++) m->phases[k].active[q] = moves;
  }
}

/* Takes disks and memories of the packing over, which is left empty. */
static sd_model *packing_model(packing *p, sd_integrator integrator, int64_t rest) {
  sd_model *m = sd_model_new();
  sd_messages *messages = sd_messages_new();
  if (!m || !messages) give_up("out of memory", NULL);
  m->integrator = integrator;
  m->dt = 2e-5;
  m->gravity[SD_Y] = -9.81 * p->kind->gravity;
  m->upper[SD_X] = p->width;
  m->periodic[SD_X] = true;
  m->n_materials = 1;
  m->materials = room(1, sizeof *m->materials);
  m->laws = room(1, sizeof *m->laws);
  m->laws[0] =
      (sd_contact_law){.k_n = 1e4, .k_t = 5e3, .gamma_n = p->kind->gamma_n, .mu = p->kind->mu};
  m->n_disks = p->n_disks;
  m->disks = p->disks;
  m->n_memories = p->n_contacts;
  m->memories = p->contacts;
  p->disks = NULL;
  p->contacts = NULL;
  add_floor(m);
  add_floor_motions(m, p->kind);
  add_phases(m, rest);
  if (sd_model_finish(m, messages) != SD_OK) give_up(p->kind->name, messages);
  sd_messages_free(messages);
  return m;
}

/* Disks in rows that do not touch: what falls on the floor. */
static packing loose_packing(const packing_kind *kind, size_t count) {
  const double mean = 0.02, spacing = 2.45 * mean;
  size_t wide = count / (count >= BASE_DISKS ? BASE_ROWS : FEW_ROWS);
  packing p = {.kind = kind, .width = (double)wide * spacing, .n_disks = count};
  p.disks = room(count, sizeof *p.disks);
  uint32_t seed = 1;
  for (size_t k = 0; k < count; k++) {
    size_t row = k / wide;
    double radius = mean * (0.8 + 0.4 * next_uniform(&seed));
    double x = spacing * ((double)(k % wide) + 0.5 * (double)(row % 2)),
           y = spacing * (0.5 + 0.87 * (double)row);
    p.disks[k] = (sd_disk){
        .position = {x, y, 0.0}, .radius = radius, .mass = 3.57 * acos(-1.0) * radius * radius};
    p.disks[k].group = -1;
  }
  return p;
}

/* Disks and contacts as they are now; angles as the state has them, so that lambda* goes on as it is. */
static packing packing_of(const packing_kind *kind, double width, const sd_state *s) {
  packing p = {.kind = kind, .width = width, .n_disks = s->n_disks, .n_contacts = s->n_contacts};
  p.disks = room(p.n_disks, sizeof *p.disks);
  p.contacts = room(p.n_contacts + 1, sizeof *p.contacts);
  for (size_t i = 0; i < p.n_disks; i++)
    p.disks[s->id[i]] = (sd_disk){.position = {s->x[i], s->y[i], s->theta[i]},
                                  .velocity = {s->vx[i], s->vy[i], s->omega[i]},
                                  .radius = s->radius[i],
                                  .mass = s->mass[i],
                                  .group = -1};
  for (size_t k = 0; k < p.n_contacts; k++)
    p.contacts[k] = (sd_contact_memory){.a = s->contact_a[k],
                                        .b = s->contact_b[k],
                                        .part = s->contact_part[k],
                                        .slide = s->contact_slide[k],
                                        .side = s->contact_side[k],
                                        .record = sd_state_record(s, k)};
  return p;
}

/* Settled, shaken, at the beginning of a period of the floor. */
static packing settled_packing(const packing_kind *kind, size_t count) {
  packing p = loose_packing(kind, count);
  double width = p.width;
  sd_messages *messages = sd_messages_new();
  sd_model *model = packing_model(&p, SD_VERLET, SETTLE_STEPS);
  sd_simulation *simulation = NULL;
  const sd_state *state = NULL;
  if (sd_simulation_new(model, 1, &simulation, messages) == SD_OK &&
      sd_simulation_advance(simulation, SETTLE_STEPS + kind->periods * PERIOD, messages) == SD_OK)
    state = sd_simulation_state(simulation);
  if (!state) give_up(kind->name, messages);
  p = packing_of(kind, width, state);
  sd_simulation_free(simulation);
  sd_model_free(model);
  sd_messages_free(messages);
  return p;
}

/* Numbers that know nothing of places. */
static uint32_t *shuffled_numbers(size_t n) {
  uint32_t *number = room(n, sizeof *number), seed = 7;
  for (uint32_t k = 0; k < n; k++) {
    uint32_t at = (uint32_t)(next_uniform(&seed) * (k + 1.0));
    number[k] = number[at];
    number[at] = k;
  }
  return number;
}

/* The contact in copy k of n, in which disk i of the base has the number base_disks * k + i before numbers are mixed. */
static sd_contact_memory copied_contact(const packing *base, sd_contact_memory c, size_t k,
                                        size_t n) {
  size_t disks = base->n_disks, other = k;
  if (c.b < disks) {
    double apart = base->disks[c.b].position[SD_X] - base->disks[c.a].position[SD_X];
    long across = lround(
        apart / base->width); /* the partner's nearest image is in the copy beside this one */
    other = (size_t)((long)(k + n) - across) % n;
    c.b = (uint32_t)(disks * other + c.b);
  } else {
    c.b = (uint32_t)(disks * n);
    c.record.lambda_ref +=
        c.side * base->width * (double)k; /* lambda counts the floor's arc length, too */
  }
  c.a = (uint32_t)(disks * k + c.a);
  return c;
}

static packing repeated_packing(const packing *base, size_t copies, bool shuffled) {
  packing p = {base->kind,
               base->width * (double)copies,
               base->n_disks * copies,
               base->n_contacts * copies,
               NULL,
               NULL};
  uint32_t *number = shuffled ? shuffled_numbers(p.n_disks) : NULL;
  p.disks = room(p.n_disks, sizeof *p.disks);
  p.contacts = room(p.n_contacts + 1, sizeof *p.contacts);
  for (size_t k = 0; k < p.n_disks; k++) {
    sd_disk *to = &p.disks[number ? number[k] : k];
    *to = base->disks[k % base->n_disks];
    to->position[SD_X] += base->width * (double)(k / base->n_disks);
  }
  for (size_t k = 0; k < p.n_contacts; k++) {
    sd_contact_memory c =
        copied_contact(base, base->contacts[k % base->n_contacts], k / base->n_contacts, copies);
    if (number) c.a = number[c.a];
    if (number && c.b < p.n_disks) c.b = number[c.b];
    p.contacts[k] = c;
  }
  free(number);
  return p;
}

#endif

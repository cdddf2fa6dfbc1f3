/* resultant.c: computes sums of forces and numbers of contacts at one time (see resultant.h). */
#include "measure/resultant.h"

#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "measure/contact_graph.h"
#include "measure/observable.h"
#include "measure/stress.h"
#include "model/model.h"
#include "pack/compress.h"
#include "physics/step/outside.h"
#include "physics/system/bodies.h"

static const size_t NONE = SIZE_MAX;

/* Layout of resultants.sums: first WHOLE sums over all contacts and disks, with these indices
 * (those of the contact stress, xx ... yy, are TENSOR to TENSOR + 3); then ROW sums (FORCE_X,
 * ...) for each wall, each group and each chosen disk. */
enum { CONTACTS, SLIDING, BONDS, OUTSIDE, VIRIAL, SQUARES, TENSOR, WHOLE = TENSOR + 4 };
enum { FORCE_X, FORCE_Y, TORQUE, NORMAL, TANGENTIAL, ROW_CONTACTS, ROW_SLIDING, ROW };

/* A state, or the part of it that one rank has. */
typedef struct part {
  const sd_model *model;
  const sd_state *state;
  const slot_table *slots;
  /* ranks that share the state; NULL: the state is complete */
  const comm *comm;
  /* Box, region and walls at this time, without disks and contacts, and the region that is
   * measured; set if the model asks for groups, box or stress. */
  configuration space;
  region region;
  /* [n_free] vector from the centre of a clump to each of its disks, if there are clumps; NULL: the
   * model does not ask for stress */
  double (*arm)[2];
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
 * overlap) or a bond does not count as a contact. */
static void add_whole(const resultants *r, const part *p) {
  const sd_state *s = p->state;
  const bool compresses = series_compresses(p->model);
  int64_t contacts = 0, sliding = 0, bonds = 0;
  for (size_t c = 0; c < s->n_contacts; c++) {
    const bool touches = s->contact_overlap[c] > 0.0;
    contacts += touches || !s->law_columns;
    sliding += touches && s->contact_slide[c] != 0;
    bonds += s->law_columns && s->contact_bond[c] > 0.0;
    if (compresses) exact_sum_add(&r->sums[VIRIAL], virial_of(p, c));
  }
  for (size_t i = 0; compresses && i < s->n_free; i++)
    if (body_in_play(s, i)) exact_sum_add(&r->sums[SQUARES], s->radius[i] * s->radius[i]);
  for (size_t i = 0; compresses && s->n_clumps > 0 && i < s->n_free; i++)
    exact_sum_add(&r->sums[VIRIAL], compress_inner(p->model, s, i));
  exact_sum_add(&r->sums[CONTACTS], (double)contacts);
  exact_sum_add(&r->sums[SLIDING], (double)sliding);
  exact_sum_add(&r->sums[BONDS], (double)bonds);
  exact_sum_add(&r->sums[OUTSIDE], (double)outside_count(s));
}

/* --- geometry --------------------------------------------------------------------------------- */

/* Sets box, walls and region. Collective. */
static sd_status take_space(part *p, sd_messages *messages) {
  const sd_state *s = p->state;
  sd_model constants = *p->model;
  frame_data f;
  constants.n_disks = 0;
  sd_status status = frame_data_of_walls(&f, p->model, s, messages);
  for (size_t i = 0; status == SD_OK && i < s->n_disks; i++)
    if (i >= s->n_free || body_in_play(s, i))
      disk_extent_add(&f.extent, (double[]){s->x[i], s->y[i]}, s->radius[i], i < s->n_free);
  for (int k = 0; status == SD_OK && k < 4; k++) {
    f.extent.centre[k] = comm_largest(p->comm, f.extent.centre[k]);
    f.extent.edge[k] = comm_largest(p->comm, f.extent.edge[k]);
  }
  if (status == SD_OK) status = configuration_new(&p->space, &constants, &f, messages);
  if (status == SD_OK) p->region = configuration_region(&p->space, NULL);
  frame_data_free(&f);
  return status;
}

/* Returns the disk in this slot, with its position wrapped into the periodic box. */
static sd_disk disk_in(const part *p, size_t slot) {
  const sd_state *s = p->state;
  sd_disk d = {.position = {s->x[slot], s->y[slot]},
               .velocity = {s->vx[slot], s->vy[slot]},
               .radius = s->radius[slot],
               .mass = s->mass[slot],
               .material = s->material[slot],
               .driven = slot >= s->n_free + s->n_ghosts};
  configuration_wrap(&p->space, d.position);
  return d;
}

/* Computes the unwrapped position at[] of the disk in this slot, from its image counts. */
static void absolute(const part *p, size_t slot, double at[2]) {
  const sd_state *s = p->state;
  const configuration *c = &p->space;
  at[0] = s->x[slot] + s->image_x[slot] * c->length[0] + s->image_y[slot] * c->offset;
  at[1] = s->y[slot] + s->image_y[slot] * c->length[1];
}

/* --- groups ----------------------------------------------------------------------------------- */

/* Indices of the sums for the centre of mass of a group: mass, mass times x, mass times y; their
 * number. */
enum { MASS, MASS_X, MASS_Y, CENTRE };

/* Returns the centres of mass of all groups. */
static double (*group_centres(const part *p))[2] {
  const sd_state *s = p->state;
  const size_t n = p->model->n_groups;
  exact_sum *sum = memory_new(CENTRE * n, sizeof *sum);
  double(*centre)[2] = memory_new(n, sizeof *centre), at[2];
  for (size_t i = 0; i < s->n_disks; i++) {
    if (s->group[i] < 0 || !counts(p, i) || (i < s->n_free && !body_in_play(s, i))) continue;
    exact_sum *of = sum + CENTRE * (size_t)s->group[i];
    absolute(p, i, at);
    exact_sum_add(&of[MASS], s->mass[i]);
    exact_sum_add(&of[MASS_X], s->mass[i] * at[0]);
    exact_sum_add(&of[MASS_Y], s->mass[i] * at[1]);
  }
  add_up(p, sum, CENTRE * n);
  for (size_t k = 0; k < n; k++)
    for (int x = 0; x < 2; x++)
      centre[k][x] = exact_sum_value(&sum[CENTRE * k + MASS_X + (size_t)x]) /
                     exact_sum_value(&sum[CENTRE * k]);
  free(sum);
  return centre;
}

/* Adds the force and torque of a contact to the sums of the groups of its bodies. */
static void add_group_force(exact_sum *rows, const part *p, const config_contact *q,
                            const uint32_t slot[2], double (*centre)[2]) {
  const sd_state *s = p->state;
  double at[2];
  for (int x = 0; s->group[slot[0]] != s->group[slot[1]] && x < 2; x++) {
    const int32_t group = s->group[slot[x]];
    if (group < 0) continue;
    const double sign = x == 0 ? -1.0 : 1.0, fx = sign * q->fx, fy = sign * q->fy;
    const double *g = centre[group];
    exact_sum *row = rows + ROW * (size_t)group;
    absolute(p, slot[x], at);
    exact_sum_add(&row[FORCE_X], fx);
    exact_sum_add(&row[FORCE_Y], fy);
    const double turn = s->radius[slot[x]] * q->tau - sign * q->couple;
    exact_sum_add(&row[TORQUE], (at[0] - g[0]) * fy - (at[1] - g[1]) * fx + turn);
  }
}

/* --- stress ----------------------------------------------------------------------------------- */

/* Returns clump k as a rigid body, of mass 0 if it is not in play, and sets the arms of its disks.
 * disks, slots: [n_free] temporary. */
static config_clump clump_in(const part *p, size_t k, sd_disk *disks, uint32_t *slots) {
  const sd_state *s = p->state;
  const sd_clump *of = &p->model->clumps[k];
  const double *length = p->space.length;
  config_clump clump = {.disks = slots};
  for (size_t n = 0; n < of->n_disks; n++) {
    const uint32_t i = slot_of(p->slots, of->disks[n]);
    if (!body_in_play(s, i)) continue;
    slots[clump.n_disks++] = i;
    const uint32_t first = slots[0];
    disks[i] = disk_in(p, i);
    p->arm[i][0] = s->x[i] - s->x[first] + (s->image_x[i] - s->image_x[first]) * length[0];
    p->arm[i][1] = s->y[i] - s->y[first] + (s->image_y[i] - s->image_y[first]) * length[1];
  }
  if (clump.n_disks > 0) configuration_clump(&clump, disks, p->arm);
  return clump;
}

/* Returns the disk in this slot as a rigid body, of mass 0 if it is not in play or in a clump. */
static config_clump alone(const part *p, size_t slot) {
  const sd_state *s = p->state;
  const bool joined = s->n_clumps > 0 && p->model->disks[s->id[slot]].clump > 0;
  const sd_disk d = disk_in(p, slot);
  return joined || !body_in_play(s, slot) ? (config_clump){0} : configuration_alone(&d);
}

/* Computes the kinetic stress, and sets the arms of disks in clumps. Collective. */
static sd_status take_motion(resultants *r, part *p, sd_messages *messages) {
  const sd_state *s = p->state;
  const size_t n = s->n_clumps > 0 ? s->n_free : 0;
  config_clump *list;
  sd_disk *disks;
  uint32_t *slots;
  size_t inside = 0;
  const memory_column rows[] = {{&list, s->n_free + s->n_clumps, sizeof *list},
                                {&disks, n, sizeof *disks},
                                {&slots, n, sizeof *slots},
                                {&p->arm, n, sizeof *p->arm}};
  if (!memory_rows(sizeof rows / sizeof *rows, rows))
    return sd_fail(messages, SD_ERROR_IO, "no memory for %zu disks", s->n_free);
  for (size_t k = 0; k < s->n_free + s->n_clumps; k++) {
    config_clump *b = &list[inside];
    *b = k < s->n_free ? alone(p, k) : clump_in(p, k - s->n_free, disks, slots);
    inside += b->mass > 0.0 && region_holds(&p->region, b->position[0], b->position[1]);
  }
  stress_kinetic(r->kinetic, &p->space, region_area(&p->region), inside, list, p->comm);
  free(list);
  free(disks);
  free(slots);
  return SD_OK;
}

/* --- rattlers --------------------------------------------------------------------------------- */

/* Returns the node of a free disk in the graph of contacts: its number, or that of the first disk
 * of its clump. */
static uint32_t node_of_disk(const sd_model *m, uint32_t disk) {
  const size_t clump = (size_t)m->disks[disk].clump;
  return clump > 0 ? m->clumps[clump - 1].disks[0] : disk;
}

static uint32_t node_of(const part *p, uint32_t body) {
  const bool yields = slot_of(p->slots, body) < p->state->n_free + p->state->n_ghosts;
  return yields ? node_of_disk(p->model, body) : GRAPH_FIXED;
}

/* Gathers rows of all ranks on every rank; the caller frees them. Collective. */
static void *gather(const comm *c, const void *mine, size_t n, size_t size, size_t *all) {
  int *counts = memory_new((size_t)comm_size(c), sizeof *counts);
  comm_gather_counts(c, (int)n, counts);
  *all = 0;
  for (int q = 0; q < comm_size(c); q++) *all += (size_t)counts[q];
  void *rows = memory_new(*all, size);
  comm_gather(c, mine, rows, counts, size);
  free(counts);
  return rows;
}

/* Counts rattlers and the contacts of the other disks in the region. Collective. */
static sd_status take_rattlers(resultants *r, const part *p) {
  const sd_state *s = p->state;
  const size_t n_nodes = p->model->n_disks;
  size_t n_edges = 0, n_inside = 0;
  graph_edge *own = memory_new(s->n_contacts, sizeof *own);
  uint32_t *mine = memory_new(s->n_free, sizeof *mine);
  for (size_t k = 0; k < s->n_contacts; k++)
    if (s->contact_force[k] > 0.0)
      own[n_edges++] = (graph_edge){node_of(p, s->contact_a[k]), node_of(p, s->contact_b[k])};
  for (size_t i = 0; i < s->n_free; i++) {
    const sd_disk d = disk_in(p, i);
    if (body_in_play(s, i) && region_holds(&p->region, d.position[0], d.position[1]))
      mine[n_inside++] = s->id[i];
  }
  graph_edge *edges = gather(p->comm, own, n_edges, sizeof *own, &n_edges);
  uint32_t *inside = gather(p->comm, mine, n_inside, sizeof *mine, &n_inside);
  int32_t *left = memory_new(n_nodes, sizeof *left);
  bool *rattler = memory_new(n_nodes, sizeof *rattler);
  const sd_status status =
      graph_rattlers(n_nodes, n_edges, edges, laws_frictionless(p->model) ? 3 : 2, left, rattler);
  double bearing = 0.0;
  r->rattlers = 0;
  for (size_t k = 0; k < n_inside && status == SD_OK; k++) {
    const uint32_t node = node_of_disk(p->model, inside[k]);
    r->rattlers += rattler[node];
    if (!rattler[node] && node == inside[k]) bearing += left[node];
  }
  r->z_backbone = bearing / (double)((int64_t)n_inside - r->rattlers);
  free(own);
  free(mine);
  free(edges);
  free(inside);
  free(left);
  free(rattler);
  return status;
}

/* --- fragments -------------------------------------------------------------------------------- */

/* A free disk, as one rank sends it to all. */
typedef struct massive {
  uint32_t disk;
  double mass;
} massive;

/* Computes number and largest mass of the bodies of bonded disks. Collective. */
static void take_fragments(resultants *r, const part *p) {
  const sd_state *s = p->state;
  const size_t n_nodes = p->model->n_disks;
  size_t n_edges = 0, n_disks = 0;
  graph_edge *own = memory_new(s->n_contacts, sizeof *own);
  massive *mine = memory_new(s->n_free, sizeof *mine);
  for (size_t k = 0; s->law_columns && k < s->n_contacts; k++)
    if (s->contact_bond[k] > 0.0)
      own[n_edges++] = (graph_edge){node_of(p, s->contact_a[k]), node_of(p, s->contact_b[k])};
  for (size_t i = 0; i < s->n_free; i++)
    if (body_in_play(s, i)) mine[n_disks++] = (massive){s->id[i], s->mass[i]};
  graph_edge *edges = gather(p->comm, own, n_edges, sizeof *own, &n_edges);
  massive *disks = gather(p->comm, mine, n_disks, sizeof *mine, &n_disks);
  uint32_t *root = memory_new(n_nodes, sizeof *root);
  exact_sum *mass = memory_new(n_disks, sizeof *mass);
  uint32_t *place = memory_new(n_nodes, sizeof *place); /* 1 + index of the sum of this root */
  graph_clusters(n_nodes, n_edges, edges, root);
  r->fragments = 0;
  r->largest_fragment = 0.0;
  for (size_t k = 0; k < n_disks; k++) {
    const uint32_t of = root[node_of_disk(p->model, disks[k].disk)];
    if (place[of] == 0) place[of] = (uint32_t)++r->fragments;
    exact_sum_add(&mass[place[of] - 1], disks[k].mass);
  }
  for (int64_t k = 0; k < r->fragments; k++)
    r->largest_fragment = math_max(r->largest_fragment, exact_sum_value(&mass[k]));
  free(own);
  free(mine);
  free(edges);
  free(disks);
  free(root);
  free(mass);
  free(place);
}

/* --- forces of contacts ----------------------------------------------------------------------- */

/* Adds the forces of all contacts to the sums of the contact stress and of the groups. centre:
 * centres of the groups; NULL: no groups. */
static void add_forces(const resultants *r, const part *p, double (*centre)[2]) {
  const sd_state *s = p->state;
  for (size_t k = 0; k < s->n_contacts; k++) {
    const uint32_t slot[2] = {slot_of(p->slots, s->contact_a[k]),
                              slot_of(p->slots, s->contact_b[k])};
    const bool wall = slot[1] >= s->n_disks;
    const sd_disk a = disk_in(p, slot[0]), b = wall ? (sd_disk){0} : disk_in(p, slot[1]);
    config_contact q = {.b = wall ? s->contact_b[k] - (uint32_t)p->model->n_disks : 0,
                        .part = s->contact_part[k],
                        .overlap = s->contact_overlap[k],
                        .force = s->contact_force[k],
                        .tau = configuration_tau(p->model, s, p->slots, k),
                        .roll = s->law_columns ? s->contact_roll[k] : 0.0};
    configuration_complete(&p->space, &q, &a, wall ? NULL : &b);
    double arm[2][2] = {0};
    for (int e = 0; s->n_clumps > 0 && p->arm && e < 2; e++)
      if (slot[e] < s->n_free) memcpy(arm[e], p->arm[slot[e]], sizeof arm[e]);
    if (p->model->measure_stress)
      stress_add_contact(r->sums + TENSOR, &p->region, &q, a.position, arm);
    if (centre) add_group_force(groups_of(r, p->model), p, &q, slot, centre);
  }
}

static sd_status take_geometry(resultants *r, part *p, sd_messages *messages) {
  const sd_model *m = p->model;
  sd_status status = take_space(p, messages);
  if (status == SD_OK && m->measure_stress) status = take_motion(r, p, messages);
  if (status == SD_OK && (m->measure_stress || m->measure_groups)) {
    double(*centre)[2] = m->measure_groups ? group_centres(p) : NULL;
    add_forces(r, p, centre);
    free(centre);
  }
  if (status == SD_OK && m->measure_rattlers) status = take_rattlers(r, p);
  const region *g = &p->region;
  r->width = isfinite(g->upper[0]) ? g->upper[0] - g->lower[0] : NAN;
  r->height = isfinite(g->upper[1]) ? g->upper[1] - g->lower[1] : NAN;
  configuration_free(&p->space);
  free(p->arm);
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

static void round_all(resultants *r, const part *p) {
  const sd_model *m = p->model;
  const double area = compress_area(m, p->state);
  for (int k = 0; m->measure_stress && k < 4; k++)
    r->stress[k] = exact_sum_value(&r->sums[TENSOR + k]) / region_area(&p->region);
  r->contacts = (int64_t)exact_sum_value(&r->sums[CONTACTS]);
  r->sliding = (int64_t)exact_sum_value(&r->sums[SLIDING]);
  r->bonds = (int64_t)exact_sum_value(&r->sums[BONDS]);
  r->outside = (int64_t)exact_sum_value(&r->sums[OUTSIDE]);
  r->pressure = exact_sum_value(&r->sums[VIRIAL]) / (2.0 * area);
  r->fraction = M_PI * exact_sum_value(&r->sums[SQUARES]) / area;
  if (m->measure_walls) round_rows(r->wall, walls_of(r), m->n_walls);
  if (m->measure_groups) round_rows(r->group, groups_of(r, m), m->n_groups);
  round_rows(r->disk, disks_of(r, m), m->n_contact_disks);
}

sd_status resultants_compute(resultants *r, const sd_model *m, const sd_state *s,
                             const slot_table *slots, const comm *c, sd_messages *messages) {
  part p = {.model = m, .state = s, .slots = slots, .comm = c};
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
  if (m->measure_groups || m->measure_box || m->measure_stress || m->measure_rattlers)
    status = take_geometry(r, &p, messages);
  add_up(&p, r->sums, r->n_sums);
  if (status == SD_OK && m->measure_fragments) take_fragments(r, &p);
  if (status == SD_OK) round_all(r, &p);
  return status;
}

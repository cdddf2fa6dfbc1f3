/* stress.c: stress, coordination, rattlers and fabric of a configuration (see stress.h). */
#include "measure/stress.h"

#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "measure/contact_graph.h"
#include "model/model.h"

principal stress_principal(const double t[4]) {
  double half = 0.5 * (t[STRESS_XX] - t[STRESS_YY]), shear = 0.5 * (t[STRESS_XY] + t[STRESS_YX]);
  principal p = {0.5 * (t[STRESS_XX] + t[STRESS_YY]), math_hypot(half, shear), NAN};
  if (p.deviator > 1e-12 * fabs(p.mean)) p.angle = 0.5 * math_atan2(shear, half);
  return p;
}

static double ratio(double a, size_t n) { return n > 0 ? a / (double)n : NAN; }

/* --- disks ------------------------------------------------------------------------------------ */

static void add_contact(stress *s, const configuration *c, const config_contact *k) {
  const sd_model *m = c->model;
  bool bears = k->force > 0.0, disk = k->b < m->n_disks;
  uint32_t body[2] = {k->a, k->b};
  for (int e = 0; e < (disk ? 2 : 1); e++) {
    double sign = e ? 1.0 : -1.0; /* (fx, fy) is the force on b */
    /* vector from the centre of this body to the point of contact */
    double px = k->x - m->disks[k->a].position[0], py = k->y - m->disks[k->a].position[1];
    if (e) {
      double d[2] = {k->x - m->disks[k->b].position[0], k->y - m->disks[k->b].position[1]};
      configuration_nearest(c, d);
      px = d[0];
      py = d[1];
    }
    s->contacts[body[e]] += k->overlap > 0.0; /* a pair held by attraction alone is no contact */
    s->bearing[body[e]] += bears;
    s->resultant[body[e]][0] += sign * k->fx;
    s->resultant[body[e]][1] += sign * k->fy;
    if (c->n_clumps > 0 && body[e] < m->n_disks) { /* make it relative to the centre of the clump */
      px += c->arm[body[e]][0];
      py += c->arm[body[e]][1];
    }
    s->virial[body[e]] -= sign * (px * k->fx + py * k->fy);
  }
}

static void add_body_forces(stress *s, const sd_model *m) {
  for (size_t i = 0; i < m->n_disks; i++)
    for (int c = 0; c < 2; c++)
      s->resultant[i][c] += m->disks[i].mass * m->gravity[c] + m->disks[i].force[c];
}

/* --- rattlers --------------------------------------------------------------------------------- */

/* Temporary arrays of stress_new. */
typedef struct scratch {
  int32_t *left; /* number of contacts of each disk with bodies that are no rattlers */
  bool *inside;  /* true for disks with their centre in the region */
  graph_edge *edges;
  /* [n_bodies] rigid bodies with their centre in the region: disks in no clump, then clumps */
  config_clump *bodies;
  size_t n_bodies;
} scratch;

/* Returns the disk that represents a rigid body: the first disk of its clump, or the disk itself;
 * GRAPH_FIXED for a body that is prescribed. */
static uint32_t node_of(const configuration *c, uint32_t body) {
  if (!configuration_is_free(c, body)) return GRAPH_FIXED;
  return configuration_in_clump(c, body) ? c->clumps[c->clump_of[body]].disks[0] : body;
}

static sd_status find_rattlers(stress *s, const configuration *c, scratch *room) {
  const size_t n = c->model->n_disks;
  size_t n_edges = 0;
  for (size_t k = 0; k < c->n_contacts; k++) {
    const config_contact *q = &c->contacts[k];
    if (q->force > 0.0) room->edges[n_edges++] = (graph_edge){node_of(c, q->a), node_of(c, q->b)};
  }
  const sd_status status =
      graph_rattlers(n, n_edges, room->edges, c->frictionless ? 3 : 2, room->left, s->rattler);
  for (uint32_t i = 0; i < n && status == SD_OK; i++) {
    const uint32_t node = node_of(c, i);
    s->rattler[i] = node != GRAPH_FIXED && s->rattler[node];
  }
  return status;
}

/* --- sums over the region --------------------------------------------------------------------- */

/* Fills *b with rigid body k (disks first, then clumps); its force becomes the total force. Returns
 * false unless it is free and has its centre in the region. */
static bool body_moves(config_clump *b, const configuration *c, const region *g, const stress *s,
                       size_t k) {
  const sd_model *m = c->model;
  if (k < m->n_disks) {
    if (!configuration_is_free(c, (uint32_t)k) || configuration_in_clump(c, k)) return false;
    *b = configuration_alone(&m->disks[k]);
    memcpy(b->force, s->resultant[k], sizeof b->force);
  } else {
    *b = c->clumps[k - m->n_disks];
    if (b->n_disks == 0) return false;
    for (size_t n = 0; n < b->n_disks; n++)
      for (int q = 0; q < 2; q++) b->force[q] += s->resultant[b->disks[n]][q];
  }
  return region_holds(g, b->position[0], b->position[1]);
}

static void sum_bodies(stress *s, const configuration *c, const region *g, scratch *room) {
  double resultant = 0.0;
  for (size_t k = 0; k < c->model->n_disks + c->n_clumps; k++) {
    config_clump *b = &room->bodies[room->n_bodies];
    if (!body_moves(b, c, g, s, k)) continue;
    const double *v = b->velocity;
    room->n_bodies++;
    s->clumps += k >= c->model->n_disks;
    resultant += math_hypot(b->force[0], b->force[1]);
    s->energy_translation += 0.5 * b->mass * (v[0] * v[0] + v[1] * v[1]);
    s->energy_rotation += 0.5 * b->inertia * v[2] * v[2];
  }
  s->energy_translation = ratio(s->energy_translation, room->n_bodies);
  s->energy_rotation = ratio(s->energy_rotation, room->n_bodies);
  s->unbalanced =
      ratio(resultant, room->n_bodies); /* sum_contacts divides this by the mean force */
}

static void count_disks(stress *s, const configuration *c, const region *g, const bool *inside,
                        const int32_t *left) {
  const sd_model *m = c->model;
  double covered = 0.0, closed = 0.0, bearing = 0.0, backbone = 0.0;
  for (size_t i = 0; i < m->n_disks; i++) {
    const sd_disk *d = &m->disks[i];
    covered += region_disk(g, d->position[0], d->position[1], d->radius);
    if (d->driven) {
      s->fixed += inside[i];
      continue;
    }
    s->outside += !inside[i];
    if (!inside[i]) continue;
    s->free++;
    s->rattlers += s->rattler[i];
    closed += s->contacts[i];
    bearing += s->bearing[i];
    if (!s->rattler[i]) backbone += left[i];
  }
  s->fraction = covered / s->area;
  s->z = ratio(closed, s->free);
  s->z_bearing = ratio(bearing, s->free);
  s->z_backbone = ratio(backbone, s->free - s->rattlers);
}

/* Computes the velocity v of a body relative to the homogeneous flow of a box that deforms. */
static void beside_flow(const configuration *c, const config_clump *b, double v[2]) {
  const double *g = c->gradient, x = b->position[0] - c->model->lower[0],
               y = b->position[1] - c->model->lower[1];
  v[0] = b->velocity[0] - (g[SD_CELL_XX] * x + g[SD_CELL_XY] * y);
  v[1] = b->velocity[1] - g[SD_CELL_YY] * y;
}

void stress_kinetic(double out[4], const configuration *c, double area, size_t n,
                    const config_clump *bodies, const comm *ranks) {
  /* momentum: sums of m v_x, m v_y and m; sum: sums of m v_i v_j */
  exact_sum momentum[3] = {0}, sum[4] = {0};
  double v[2];
  for (size_t i = 0; i < n; i++) {
    const double mass = bodies[i].mass;
    beside_flow(c, &bodies[i], v);
    for (int k = 0; k < 2; k++) exact_sum_add(&momentum[k], mass * v[k]);
    exact_sum_add(&momentum[2], mass);
  }
  comm_total_exact(ranks, momentum, 3);
  const double all = exact_sum_value(&momentum[2]);
  const double mean[2] = {exact_sum_value(&momentum[0]) / all, exact_sum_value(&momentum[1]) / all};
  for (size_t i = 0; i < n; i++) {
    beside_flow(c, &bodies[i], v);
    for (int k = 0; k < 2; k++) v[k] -= mean[k];
    for (int k = 0; k < 4; k++) exact_sum_add(&sum[k], bodies[i].mass * v[k / 2] * v[k % 2]);
  }
  comm_total_exact(ranks, sum, 4);
  for (int k = 0; k < 4; k++) out[k] = exact_sum_value(&sum[k]) / area;
}

void stress_add_contact(exact_sum sum[4], const region *g, const config_contact *contact,
                        const double at[2], double arm[2][2]) {
  const double f[2] = {contact->fx, contact->fy};
  double from[2], l[2] = {contact->lx, contact->ly};
  for (int q = 0; q < 2; q++) {
    from[q] = at[q] - arm[0][q];
    l[q] = l[q] + arm[0][q] - arm[1][q];
  }
  const double part = region_line(g, from[0], from[1], l[0], l[1]);
  for (int e = 0; e < 4; e++) exact_sum_add(&sum[e], part * l[e / 2] * f[e % 2]);
}

/* Counts bonds, and bodies of disks that they join. SD_ERROR_IO: out of memory. */
static sd_status find_fragments(stress *s, const configuration *c, scratch *room) {
  const sd_model *m = c->model;
  uint32_t *root;
  double *mass;
  if (!memory_rows(2, (memory_column[]){{&root, m->n_disks, sizeof *root},
                                        {&mass, m->n_disks, sizeof *mass}}))
    return SD_ERROR_IO;
  for (size_t k = 0; k < c->n_contacts; k++) {
    const config_contact *q = &c->contacts[k];
    if (q->bond > 0.0) room->edges[s->n_bonds++] = (graph_edge){node_of(c, q->a), node_of(c, q->b)};
  }
  graph_clusters(m->n_disks, s->n_bonds, room->edges, root);
  for (uint32_t i = 0; i < m->n_disks; i++) {
    if (!configuration_is_free(c, i)) continue;
    double *of = &mass[root[node_of(c, i)]];
    s->fragments += *of == 0.0;
    *of += m->disks[i].mass;
    s->largest_fragment = math_max(s->largest_fragment, *of);
  }
  free(root);
  free(mass);
  return SD_OK;
}

static void contact_stress(stress *s, const configuration *c, const region *g) {
  const sd_model *m = c->model;
  exact_sum sum[4] = {0};
  for (size_t k = 0; k < c->n_contacts; k++) {
    const config_contact *q = &c->contacts[k];
    const uint32_t body[2] = {q->a, q->b};
    double arm[2][2] = {0};
    for (int e = 0; c->n_clumps > 0 && e < 2; e++)
      if (body[e] < m->n_disks) memcpy(arm[e], c->arm[body[e]], sizeof arm[e]);
    stress_add_contact(sum, g, q, m->disks[q->a].position, arm);
  }
  for (int e = 0; e < 4; e++) s->contact[e] = exact_sum_value(&sum[e]) / s->area;
}

static void sum_contacts(stress *s, const configuration *c, const region *g) {
  const sd_model *m = c->model;
  double overlap = 0.0, force = 0.0;
  bool tangential = true;
  for (size_t k = 0; k < c->n_contacts; k++) {
    const config_contact *q = &c->contacts[k];
    const double *centre = m->disks[q->a].position, n[2] = {q->nx, q->ny};
    tangential = tangential && isfinite(q->tau);
    if (!region_holds(g, centre[0] + 0.5 * q->lx, centre[1] + 0.5 * q->ly)) continue;
    if (!(q->overlap > 0.0)) continue;
    s->n_contacts++;
    s->n_wall += !configuration_is_free(c, q->b);
    s->n_sliding += q->slide != 0;
    overlap += q->overlap;
    if (q->overlap > s->overlap_max)
      s->overlap_max = q->overlap, s->overlap_a = q->a, s->overlap_b = q->b;
    if (!(q->force > 0.0)) continue;
    s->n_bearing++;
    force += q->force;
    for (int e = 0; e < 4; e++) s->fabric[e] += n[e / 2] * n[e % 2];
  }
  for (int e = 0; e < 4; e++) s->fabric[e] = ratio(s->fabric[e], s->n_bearing);
  principal p = stress_principal(s->fabric);
  s->anisotropy = 4.0 * p.deviator;
  s->fabric_angle = p.angle;
  s->contact_principal = stress_principal(s->contact);
  s->overlap_mean = ratio(overlap, s->n_contacts);
  s->mean_force = ratio(force, s->n_bearing);
  s->unbalanced = tangential ? s->unbalanced / s->mean_force : NAN;
}

sd_status stress_new(stress *s, const configuration *c, const region *g, sd_messages *messages) {
  const sd_model *m = c->model;
  size_t n = m->n_disks;
  *s = (stress){.area = region_area(g)};
  scratch room = {0};
  const memory_column rows[] = {{&s->contacts, n, sizeof *s->contacts},
                                {&s->bearing, n, sizeof *s->bearing},
                                {&s->rattler, n, sizeof *s->rattler},
                                {&s->resultant, n, sizeof *s->resultant},
                                {&s->virial, n, sizeof *s->virial},
                                {&room.left, n, sizeof *room.left},
                                {&room.inside, n, sizeof *room.inside},
                                {&room.edges, c->n_contacts, sizeof *room.edges},
                                {&room.bodies, n + c->n_clumps, sizeof *room.bodies}};
  if (!memory_rows(sizeof rows / sizeof *rows, rows))
    return sd_fail(messages, SD_ERROR_IO, "no memory for %zu disks", n);
  for (size_t k = 0; k < c->n_contacts; k++) add_contact(s, c, &c->contacts[k]);
  add_body_forces(s, m);
  for (size_t i = 0; i < n; i++)
    room.inside[i] = region_holds(g, m->disks[i].position[0], m->disks[i].position[1]);
  sd_status status = find_rattlers(s, c, &room);
  if (status == SD_OK) status = find_fragments(s, c, &room);
  count_disks(s, c, g, room.inside, room.left);
  sum_bodies(s, c, g, &room);
  stress_kinetic(s->kinetic, c, s->area, room.n_bodies, room.bodies, NULL);
  contact_stress(s, c, g);
  sum_contacts(s, c, g);
  free(room.left);
  free(room.inside);
  free(room.edges);
  free(room.bodies);
  return status == SD_OK ? SD_OK : sd_fail(messages, status, "no memory for %zu disks", n);
}

void stress_free(stress *s) {
  free(s->contacts);
  free(s->bearing);
  free(s->rattler);
  free(s->resultant);
  free(s->virial);
  *s = (stress){0};
}

/* configuration.c: builds the bodies and contacts of a configuration from a stored frame (see
 * configuration.h). */
#include "measure/configuration.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/team.h"
#include "model/cell.h"
#include "model/laws.h"
#include "model/walls.h"
#include "physics/system/bodies.h"
#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/contact/evaluate.h"

static const disk_extent NO_DISKS = {{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL},
                                     {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};

void disk_extent_add(disk_extent *e, const double at[2], double radius, bool free) {
  for (int k = 0; k < 4; k++) {
    const double way = k < 2 ? -at[k] : at[k - 2];
    if (free && way > e->centre[k]) e->centre[k] = way;
    if (way + radius > e->edge[k]) e->edge[k] = way + radius;
  }
}

int configuration_material(const sd_model *m, uint32_t body) {
  return body < m->n_disks ? m->disks[body].material : m->walls[body - m->n_disks].material;
}

bool configuration_is_free(const configuration *c, uint32_t body) {
  return body < c->model->n_disks && !c->model->disks[body].driven;
}

double configuration_radius(const configuration *c) {
  double sum = 0.0;
  for (size_t i = 0; i < c->model->n_disks; i++) sum += c->model->disks[i].radius;
  return c->model->n_disks ? sum / (double)c->model->n_disks : 0.0;
}

/* --- frame ------------------------------------------------------------------------------------ */

sd_status frame_data_new(frame_data *f, size_t n_disks, size_t n_walls, sd_messages *messages) {
  size_t n = n_disks + n_walls;
  *f = (frame_data){
      .scale = 1.0, .stretch = {1.0, 1.0}, .n_bodies = n, .n_disks = n_disks, .extent = NO_DISKS};
  const memory_column rows[] = {{&f->position, n, sizeof *f->position},
                                {&f->velocity, n, sizeof *f->velocity},
                                {&f->angle, n, sizeof *f->angle},
                                {&f->spin, n, sizeof *f->spin},
                                {&f->activity, n_disks, sizeof *f->activity},
                                {&f->image, n_disks, sizeof *f->image}};
  if (memory_rows(sizeof rows / sizeof *rows, rows)) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "no memory for a frame of %zu bodies", n);
}

sd_status frame_data_contacts(frame_data *f, size_t n, sd_messages *messages) {
  f->has_contacts = true;
  f->n_contacts = n;
  const memory_column rows[] = {{&f->a, n, sizeof *f->a},
                                {&f->b, n, sizeof *f->b},
                                {&f->part, n, sizeof *f->part},
                                {&f->overlap, n, sizeof *f->overlap},
                                {&f->force, n, sizeof *f->force},
                                {&f->tau, n, sizeof *f->tau},
                                {&f->roll, n, sizeof *f->roll},
                                {&f->slide, n, sizeof *f->slide},
                                {&f->bond, n, sizeof *f->bond},
                                {&f->bond_pull, n, sizeof *f->bond_pull},
                                {&f->bond_shear, n, sizeof *f->bond_shear}};
  if (memory_rows(sizeof rows / sizeof *rows, rows)) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "no memory for %zu contacts", n);
}

void frame_data_free(frame_data *f) {
  void *all[] = {f->position, f->velocity, f->angle, f->spin,      f->activity,  f->image,
                 f->a,        f->b,        f->part,  f->overlap,   f->force,     f->tau,
                 f->roll,     f->slide,    f->bond,  f->bond_pull, f->bond_shear};
  for (size_t k = 0; k < sizeof all / sizeof *all; k++) free(all[k]);
  *f = (frame_data){0};
}

/* Copies step, time and deformation of the periodic box from the state into the frame. */
static void fill_moment(frame_data *f, const sd_model *m, const sd_state *s) {
  f->step = s->step;
  f->time = (double)s->step * m->dt;
  f->scale = s->box_scale;
  for (int c = 0; s->n_cell && c < 2; c++) f->stretch[c] = s->cell[c];
  f->offset = cell_offset(m, s);
  cell_gradient_of(m, s, f->gradient);
}

static void fill_body(frame_data *f, size_t body, const sd_state *s, size_t slot) {
  f->position[body][0] = s->x[slot];
  f->position[body][1] = s->y[slot];
  f->velocity[body][0] = s->vx[slot];
  f->velocity[body][1] = s->vy[slot];
  f->spin[body] = s->omega[slot];
  f->angle[body] = s->turn[slot] + s->theta[slot];
  if (slot < s->n_free) f->activity[body] = s->activity[slot];
  if (body >= f->n_disks) return;
  f->image[body][0] = s->image_x[slot];
  f->image[body][1] = s->image_y[slot];
}

/* Fills row k of the frame's contact table from stored contact k of the state. */
static void fill_contact(frame_data *f, size_t k, const sd_model *m, const sd_state *s) {
  f->a[k] = s->contact_a[k];
  f->b[k] = s->contact_b[k];
  f->part[k] = s->contact_part[k];
  f->overlap[k] = s->contact_overlap[k];
  f->force[k] = s->contact_force[k];
  f->tau[k] = configuration_tau_of(m, s, k, configuration_material(m, f->a[k]),
                                   configuration_material(m, f->b[k]));
  f->roll[k] = s->law_columns ? s->contact_roll[k] : 0.0;
  f->slide[k] = s->contact_slide[k];
  if (!s->law_columns) return;
  f->bond[k] = s->contact_bond[k];
  f->bond_pull[k] = s->contact_bond_pull[k];
  f->bond_shear[k] = s->contact_bond_shear[k];
}

sd_status frame_data_of_state(frame_data *f, const sd_model *m, const sd_state *s,
                              sd_messages *messages) {
  sd_status status = frame_data_new(f, m->n_disks, m->n_walls, messages);
  if (status == SD_OK) status = frame_data_contacts(f, s->n_contacts, messages);
  if (status != SD_OK) return status;
  fill_moment(f, m, s);
  for (size_t k = 0; k < s->n_bodies; k++) fill_body(f, s->id[k], s, k);
  for (size_t k = 0; k < s->n_contacts; k++) fill_contact(f, k, m, s);
  return SD_OK;
}

sd_status frame_data_of_walls(frame_data *f, const sd_model *m, const sd_state *s,
                              sd_messages *messages) {
  const sd_status status = frame_data_new(f, 0, m->n_walls, messages);
  if (status != SD_OK) return status;
  fill_moment(f, m, s);
  for (size_t k = s->n_disks; k < s->n_bodies; k++) fill_body(f, s->id[k] - m->n_disks, s, k);
  return SD_OK;
}

/* --- bodies ----------------------------------------------------------------------------------- */

/* Sets the edges of the periodic box and of the region for this frame: all lengths of the run's
 * model are scaled about the lower corner. */
static void fill_space(sd_model *m, const sd_model *from, const frame_data *f) {
  m->container = from->container;
  m->variant = from->variant;
  for (int c = 0; c < 2; c++) {
    double corner = box_corner(from, c), scale = f->scale * f->stretch[c];
    m->gravity[c] = from->gravity[c];
    m->periodic[c] = from->periodic[c];
    m->lower[c] = from->lower[c];
    m->upper[c] =
        scale == 1.0 ? from->upper[c] : from->lower[c] + scale * (from->upper[c] - from->lower[c]);
    m->region_lower[c] = corner + scale * (from->region_lower[c] - corner);
    m->region_upper[c] = corner + scale * (from->region_upper[c] - corner);
  }
}

static void fill_laws(sd_model *m, const sd_model *from) {
  size_t n = from->n_materials;
  m->materials = memory_new(n, sizeof *m->materials);
  m->laws = memory_new(n * n, sizeof *m->laws);
  m->phases = memory_new(1, sizeof *m->phases); /* a model needs at least one phase */
  memcpy(m->laws, from->laws, n * n * sizeof *m->laws);
  m->n_materials = n;
  m->phases[0].steps = m->n_phases = 1;
}

/* Fills all members of the configuration's model that do not concern its bodies: time step, limits,
 * box, region, laws. */
static void fill_constants(configuration *c, const sd_model *from, const frame_data *f) {
  sd_model *m = c->model;
  m->dt = 1.0; /* any value will do, as no step is taken */
  m->limits.unstable_step = true;
  m->max_overlap = 1e300; /* accept any overlap */
  fill_space(m, from, f);
  c->offset = f->offset;
  memcpy(c->gradient, f->gradient, sizeof c->gradient);
  fill_laws(m, from);
  for (int k = 0; k < SD_CELL_COMPONENTS; k++)
    m->phases[0].cell.asked |= f->offset != 0.0 || f->gradient[k] != 0.0;
  for (int k = 0; k < 2; k++) c->length[k] = m->periodic[k] ? m->upper[k] - m->lower[k] : 0.0;
}

void configuration_wrap(const configuration *c, double at[2]) {
  const sd_model *m = c->model;
  for (int k = 1; k >= 0; k--) {
    if (!m->periodic[k]) continue;
    const double length = m->upper[k] - m->lower[k], n = floor((at[k] - m->lower[k]) / length);
    at[k] -= length * n;
    if (k == 1 && n != 0.0) at[0] -= c->offset * n;
    if (!(at[k] >= m->lower[k] && at[k] < m->upper[k])) at[k] = m->lower[k];
  }
}

static void fill_disks(configuration *c, const sd_model *from, const frame_data *f,
                       uint32_t *renumbered) {
  sd_model *m = c->model;
  for (uint32_t i = 0; i < from->n_disks; i++) {
    renumbered[i] = UINT32_MAX;
    int32_t activity = from->disks[i].driven ? SD_IN_PLAY : f->activity[i];
    c->n_waiting += activity == SD_WAITING;
    c->n_removed += activity == SD_REMOVED;
    if (!activity_is_present(activity)) continue;
    const sd_disk *d = &from->disks[i];
    double at[2] = {f->position[i][0], f->position[i][1]};
    configuration_wrap(c, at);
    disk_extent_add(&c->extent, at, d->radius, !d->driven);
    renumbered[i] = (uint32_t)m->n_disks;
    c->number[m->n_disks] = i;
    m->disks[m->n_disks++] =
        (sd_disk){.position = {at[0], at[1], f->angle[i]},
                  .velocity = {f->velocity[i][0], f->velocity[i][1], f->spin[i]},
                  .radius = d->radius,
                  .mass = d->mass,
                  .inertia = d->inertia,
                  .force = {d->force[0], d->force[1], d->force[2]},
                  .material = d->material,
                  .group = d->group,
                  .driven = d->driven};
  }
}

static void wall_point(const sd_wall *wall, const frame_data *f, size_t body, const double first[2],
                       double at[2]) {
  double cosine, sine;
  math_sine_cosine(f->angle[body], &sine, &cosine);
  double x = f->scale * (first[0] - wall->pivot[0]);
  double y = f->scale * (first[1] - wall->pivot[1]);
  at[0] = f->position[body][0] + cosine * x - sine * y;
  at[1] = f->position[body][1] + sine * x + cosine * y;
}

void configuration_wall_point(const sd_wall *wall, const frame_data *f, size_t body, size_t k,
                              double at[2]) {
  wall_point(wall, f, body, wall->points[k], at);
}

static void fill_wall(sd_wall *w, const sd_wall *from, const frame_data *f, size_t body) {
  *w = (sd_wall){.kind = from->kind,
                 .material = from->material,
                 .pivot = {f->position[body][0], f->position[body][1]},
                 .closed = from->closed,
                 .radius = from->radius,
                 .inside = from->inside,
                 .from = from->from + f->angle[body],
                 .to = from->to + f->angle[body]};
  if (from->kind == SD_WALL_CIRCLE) return;
  w->points = memory_new(from->n_points, sizeof *w->points);
  w->n_points = from->n_points;
  for (size_t k = 0; k < w->n_points; k++) configuration_wall_point(from, f, body, k, w->points[k]);
  wall_point(from, f, body, from->center, w->center);
}

/* Returns the position of a straight wall that is perpendicular to coordinate c (0: x, 1: y); NAN
 * for other walls. */
static double across(const sd_wall *w, int c) {
  if (w->kind != SD_WALL_LINE || w->n_points < 2) return NAN;
  double rise = w->points[1][c] - w->points[0][c], run = w->points[1][1 - c] - w->points[0][1 - c];
  return fabs(rise) <= 1e-9 * fabs(run) ? w->points[0][c] : NAN;
}

/* Returns the side of the line {coordinate c = at} on which all free disks lie: -1 below, +1 above,
 * 0: on both sides, or there are none. */
static int side_of_disks(const disk_extent *e, int c, double at) {
  return (e->centre[2 + c] > at) - (-e->centre[c] < at);
}

/* Moves edges of the region: an edge that was a straight wall at the start follows this wall, and a
 * straight wall inside the region becomes an edge if no disk is behind it, as for lids and servo
 * walls. */
static void follow_walls(configuration *config, const sd_model *from) {
  sd_model *m = config->model;
  for (size_t w = 0; w < m->n_walls; w++)
    for (int c = 0; c < 2; c++) {
      double before = across(&from->walls[w], c), now = across(&m->walls[w], c);
      double near = 1e-9 * (from->region_upper[c] - from->region_lower[c]);
      if (!isfinite(now)) continue;
      if (fabs(before - from->region_lower[c]) <= near) m->region_lower[c] = now;
      if (fabs(before - from->region_upper[c]) <= near) m->region_upper[c] = now;
    }
  for (size_t w = 0; w < m->n_walls; w++)
    for (int c = 0; c < 2; c++) {
      double now = across(&m->walls[w], c);
      if (!(now > m->region_lower[c] && now < m->region_upper[c])) continue;
      int side = side_of_disks(&config->extent, c, now);
      if (side > 0) m->region_lower[c] = now;
      if (side < 0) m->region_upper[c] = now;
    }
}

/* Returns the wall of the run's model with this name; NULL: there is none. */
static const sd_wall *wall_named(const configuration *c, const sd_model *from, const char *name) {
  for (size_t w = 0; w < from->n_walls; w++)
    if (from->walls[w].name && strcmp(from->walls[w].name, name) == 0) return &c->model->walls[w];
  return NULL;
}

/* Sets the outline of a container that is no rectangle, from the walls along it. */
static void follow_outline(configuration *c, const sd_model *from) {
  const container_kind *kind = container_kind_of(from->container);
  container_outline o = {0};
  for (const container_wall *row = kind->walls; !kind->rectangle && row->name; row++) {
    const sd_wall *wall = wall_named(c, from, row->name);
    size_t points = row->n > 0 ? (size_t)row->n : wall ? wall->n_points : 0;
    if (!wall || wall->n_points != points || points > CONTAINER_CORNERS) return;
    for (int i = 0; i < 2; i++) o.centre[i] = wall->pivot[i];
    o.radius = points > 0 ? 0.0 : wall->radius;
    for (size_t k = 0; k < points; k++) {
      size_t corner = row->n > 0 ? (size_t)row->corner[k] : k;
      o.n = corner + 1 > o.n ? corner + 1 : o.n;
      for (int i = 0; i < 2; i++) o.corner[corner][i] = wall->points[k][i];
    }
  }
  c->outline = o;
}

/* Allocates rows for all bodies of the frame; rows for disks not in play stay unused. */
static sd_status new_bodies(configuration *c, const frame_data *f, uint32_t **renumbered) {
  sd_model *m = c->model;
  const memory_column rows[] = {{renumbered, f->n_bodies, sizeof **renumbered},
                                {&m->disks, f->n_disks, sizeof *m->disks},
                                {&m->walls, f->n_bodies - f->n_disks, sizeof *m->walls},
                                {&c->number, f->n_disks, sizeof *c->number}};
  return memory_rows(sizeof rows / sizeof *rows, rows) ? SD_OK : SD_ERROR_IO;
}

static void fill_bodies(configuration *c, const sd_model *from, const frame_data *f,
                        uint32_t *renumbered) {
  sd_model *m = c->model;
  fill_disks(c, from, f, renumbered);
  for (uint32_t w = 0; w < from->n_walls; w++) {
    m->n_walls++;
    renumbered[from->n_disks + w] = (uint32_t)m->n_disks + w;
    fill_wall(&m->walls[w], &from->walls[w], f, from->n_disks + w);
  }
  follow_walls(c, from);
  follow_outline(c, from);
}

/* --- contacts --------------------------------------------------------------------------------- */

/* Returns the wall segment with index `part`, moved to its periodic image nearest to the point
 * `at`. */
static placed_segment place(const configuration *c, uint32_t part, const double at[2]) {
  const sd_model *m = c->model;
  const sd_segment *s = &m->segments[part];
  assert(m->walls && s->body >= m->n_disks);
  const double *pivot = m->walls[s->body - m->n_disks].pivot;
  placed_segment g = walls_place(s, pivot[0], pivot[1], 1.0, 0.0, 1.0);
  if (g.joined) {
    const sd_segment *next = &m->segments[s->next];
    g.end_x = pivot[0] + next->start[0];
    g.end_y = pivot[1] + next->start[1];
  }
  placed_segment image;
  return *walls_image(c->length, &g, at[0], at[1], &image);
}

/* Returns positions and radii of a contact between disk a and a disk b or, if it is NULL, a
 * wall, in the form that contact_reaction_at needs. *g receives the wall segment that the result
 * points to. */
static contact_place place_of(const configuration *c, const config_contact *k, const sd_disk *a,
                              const sd_disk *b, placed_segment *g) {
  const sd_model *m = c->model;
  const sd_wall *wall = b ? NULL : &m->walls[k->b - m->n_disks];
  assert(a && (b || wall));
  contact_place at = {.ra = a->radius, .conservative = m->variant == SD_CONSERVATIVE};
  if (wall && wall->kind != SD_WALL_CIRCLE) {
    *g = place(c, k->part, a->position);
    at.piece = g;
    at.nearest = walls_nearest(g, a->position[0], a->position[1]);
    at.dx = at.nearest.dx;
    at.dy = at.nearest.dy;
    at.arm_x = a->position[0] - (wall->pivot[0] + g->shift_x);
    at.arm_y = a->position[1] - (wall->pivot[1] + g->shift_y);
    return at;
  }
  const double *centre = wall ? wall->pivot : b->position;
  double d[2] = {centre[0] - a->position[0], centre[1] - a->position[1]};
  configuration_nearest(c, d);
  at.dx = d[0];
  at.dy = d[1];
  at.rb = !wall ? b->radius : wall->inside ? -wall->radius : wall->radius;
  return at;
}

void configuration_complete(const configuration *c, config_contact *k, const sd_disk *a,
                            const sd_disk *b) {
  const sd_model *m = c->model;
  placed_segment g;
  const contact_place at = place_of(c, k, a, b, &g);
  const contact_reaction r =
      contact_reaction_at(&at, k->force, isfinite(k->tau) ? k->tau : 0.0, k->roll);
  k->nx = r.nx;
  k->ny = r.ny;
  bool free = b && !b->driven;
  double to_point = a->radius - (free ? 0.5 : 1.0) * k->overlap;
  k->x = a->position[0] + to_point * k->nx;
  k->y = a->position[1] + to_point * k->ny;
  k->lx = free ? at.dx : to_point * k->nx;
  k->ly = free ? at.dy : to_point * k->ny;
  k->fx = r.fx;
  k->fy = r.fy;
  k->couple = r.couple;
  const sd_contact_law *law =
      sd_model_law(m, a->material, b ? b->material : m->walls[k->b - m->n_disks].material);
  k->mu = law->mu;
  k->push = math_max(k->force + k->bond_pull + law_pull(law, k->overlap) - law->critical_load, 0.0);
  k->k_t = law->gamma_t > 0.0 || law->tangential != SD_TANGENTIAL_SPRING ? 0.0 : law->k_t;
}

static sd_status new_contacts(configuration *c, size_t n, sd_messages *messages) {
  if (memory_row(&c->contacts, n, sizeof *c->contacts)) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "no memory for %zu contacts", n);
}

static sd_status take_contacts(configuration *c, const sd_model *from, const frame_data *f,
                               const uint32_t *renumbered, sd_messages *messages) {
  if (new_contacts(c, f->n_contacts, messages) != SD_OK) return SD_ERROR_IO;
  size_t bodies = sd_model_bodies(from);
  for (size_t k = 0; k < f->n_contacts; k++) {
    uint32_t a = f->a[k], b = f->b[k];
    bool good = a < from->n_disks && b < bodies && renumbered[a] != UINT32_MAX &&
                renumbered[b] != UINT32_MAX;
    bool straight =
        good && b >= from->n_disks && from->walls[b - from->n_disks].kind != SD_WALL_CIRCLE;
    if (!good || (straight && (f->part[k] >= c->model->n_segments ||
                               c->model->segments[f->part[k]].body != renumbered[b])))
      return sd_fail(messages, SD_ERROR_USER,
                     "contact %zu of step %lld is between bodies %u and %u, which are not there", k,
                     (long long)f->step, a, b);
    c->contacts[c->n_contacts++] = (config_contact){.a = renumbered[a],
                                                    .b = renumbered[b],
                                                    .part = f->part[k],
                                                    .overlap = f->overlap[k],
                                                    .force = f->force[k],
                                                    .tau = f->tau[k],
                                                    .roll = f->roll[k],
                                                    .bond = f->bond[k],
                                                    .bond_pull = f->bond_pull[k],
                                                    .bond_shear = f->bond_shear[k],
                                                    .slide = f->slide[k]};
  }
  return SD_OK;
}

/* Returns true if both bodies are disks of the same clump; such disks have no contact with each
 * other. */
static bool rigid(const configuration *c, uint32_t a, uint32_t b) {
  return b < c->model->n_disks && configuration_in_clump(c, a) && c->clump_of[a] == c->clump_of[b];
}

static sd_status copy_contacts(configuration *c, const sd_state *s, sd_messages *messages) {
  if (new_contacts(c, s->n_contacts, messages) != SD_OK) return SD_ERROR_IO;
  for (size_t k = 0; k < s->n_contacts; k++) {
    const uint32_t a = s->contact_a[k], b = s->contact_b[k];
    if (rigid(c, a, b)) continue;
    c->contacts[c->n_contacts++] = (config_contact){.a = a,
                                                    .b = b,
                                                    .part = s->contact_part[k],
                                                    .overlap = s->contact_overlap[k],
                                                    .force = s->contact_force[k],
                                                    .tau = c->frictionless ? 0.0 : NAN};
  }
  return SD_OK;
}

/* Sets the mass of each disk in a clump to the mass of the whole clump, from which the damping
 * follows if a coefficient of restitution is given. */
static void use_clump_masses(const configuration *c, sd_state *s) {
  for (size_t i = 0; c->n_clumps > 0 && i < s->n_free; i++)
    if (configuration_in_clump(c, s->id[i])) s->mass[i] = c->clumps[c->clump_of[s->id[i]]].mass;
}

/* Sets the shear offset and the velocity gradient of a deforming box in the state. The lengths of
 * the box come from the model. */
static void deform(const configuration *c, sd_state *s) {
  const double *g = c->gradient;
  s->cell_start[CELL_OFFSET] = c->offset / c->length[0];
  s->cell_speed[CELL_X] = g[SD_CELL_XX];
  s->cell_speed[CELL_Y] = g[SD_CELL_YY];
  s->cell_speed[CELL_OFFSET] =
      (g[SD_CELL_XY] * c->length[1] + g[SD_CELL_XX] * c->offset) / c->length[0];
}

/* Finds the contacts of a frame without a contact table: starts an engine at this frame, whose
 * neighbour search and force law give the contacts and normal forces. */
static sd_status find_contacts(configuration *c, const frame_data *f, size_t n_disks,
                               sd_messages *messages) {
  const sd_model *m = c->model;
  sd_state *s = sd_state_new(m);
  if (!s) return sd_fail(messages, SD_ERROR_IO, "no memory for the contacts");
  engine *e = memory_lines(sizeof *e);
  *e = (engine){.model = m, .state = s};
  engine_fill_state(m, s);
  use_clump_masses(c, s);
  if (s->n_cell) deform(c, s);
  for (size_t k = s->n_free; k < s->n_bodies; k++) {
    size_t body = s->id[k] < m->n_disks ? c->number[s->id[k]] : n_disks + (s->id[k] - m->n_disks);
    s->vx[k] = f->velocity[body][0];
    s->vy[k] = f->velocity[body][1];
    s->omega[k] = f->spin[body];
  }
  sd_status status = engine_build(e, 1, messages);
  if (status == SD_OK) status = engine_start(e, messages);
  if (status == SD_OK) status = contacts_store(e);
  if (status == SD_OK) status = copy_contacts(c, s, messages);
  engine_free(e);
  sd_state_free(s);
  free(e);
  return status;
}

/* --- whole configuration ---------------------------------------------------------------------- */

static void complete_together(const team *t, void *with) {
  const configuration *c = with;
  const sd_model *m = c->model;
  size_t begin, end;
  team_share(t, c->n_contacts, &begin, &end);
  for (size_t k = begin; k < end; k++) {
    config_contact *q = &c->contacts[k];
    configuration_complete(c, q, &m->disks[q->a], q->b < m->n_disks ? &m->disks[q->b] : NULL);
  }
}

sd_status configuration_new(configuration *c, const sd_model *constants, const frame_data *frame,
                            sd_messages *messages) {
  *c = (configuration){.step = frame->step,
                       .time = frame->time,
                       .n_deck = frame->n_disks,
                       .extent = frame->extent,
                       .recomputed = !frame->has_contacts};
  if (frame->n_disks != constants->n_disks || frame->n_bodies != sd_model_bodies(constants))
    return sd_fail(messages, SD_ERROR_USER,
                   "the frame has %zu disks and %zu walls, the run %zu and %zu", frame->n_disks,
                   frame->n_bodies - frame->n_disks, constants->n_disks, constants->n_walls);
  uint32_t *renumbered = NULL;
  sd_model *m = c->model = sd_model_new();
  sd_status status = new_bodies(c, frame, &renumbered);
  if (status == SD_OK) {
    fill_constants(c, constants, frame);
    fill_bodies(c, constants, frame, renumbered);
    status = configuration_clumps(c, constants, frame);
  }
  if (status != SD_OK) sd_fail(messages, status, "no memory for %zu bodies", frame->n_bodies);
  bool any = status == SD_OK && m->n_disks > 0;
  if (any) {
    c->frictionless = laws_frictionless(m);
    status = sd_model_finish(m, messages);
  } else if (status == SD_OK) {
    model_find_pieces(m);
  }
  if (any && status == SD_OK)
    status = frame->has_contacts ? take_contacts(c, constants, frame, renumbered, messages)
                                 : find_contacts(c, frame, constants->n_disks, messages);
  if (status == SD_OK) pool_run_once(c->n_contacts, complete_together, c);
  free(renumbered);
  return status;
}

void configuration_free(configuration *c) {
  sd_model_free(c->model);
  free(c->number);
  free(c->contacts);
  configuration_clumps_free(c);
  *c = (configuration){0};
}

/* --- region ----------------------------------------------------------------------------------- */

/* Returns true if walls run all around the inside of the container. */
static bool is_closed(const sd_model *m) {
  const container_wall *first = container_kind_of(m->container)->walls;
  return first->name && first->n == 0;
}

region configuration_region(const configuration *c, const double *wanted) {
  const sd_model *m = c->model;
  region g = {0};
  bool given = m->region_upper[0] > m->region_lower[0] && m->region_upper[1] > m->region_lower[1];
  for (int k = 0; k < 2; k++) {
    if (wanted) {
      g.lower[k] = wanted[2 * k];
      g.upper[k] = wanted[2 * k + 1];
    } else if (m->periodic[k]) {
      g.lower[k] = m->lower[k];
      g.upper[k] = m->upper[k];
    } else if (given) {
      g.lower[k] = m->region_lower[k];
      g.upper[k] = m->region_upper[k];
    } else {
      g.lower[k] = -c->extent.edge[k];
      g.upper[k] = c->extent.edge[2 + k];
    }
    double length = c->length[k];
    g.whole[k] = length > 0.0 && g.upper[k] - g.lower[k] >= length * (1.0 - 1e-12);
    /* a region that spans the direction is exactly one period long */
    if (g.whole[k]) g.upper[k] = g.lower[k] + length;
    g.image[k] = length > 0.0 && !g.whole[k] ? length : 0.0;
  }
  if (!wanted && given) region_use_outline(&g, &c->outline, is_closed(m));
  return g;
}

/* Returns true if a straight wall segment lies, to within `near`, on the line where coordinate c
 * equals `at`. */
static bool has_wall(const sd_model *m, int c, double at, double near) {
  for (size_t w = 0; w < m->n_walls; w++) {
    const sd_wall *wall = &m->walls[w];
    if (wall->kind == SD_WALL_ARC) continue;
    for (size_t k = 0; k + (wall->closed ? 0 : 1) < wall->n_points; k++) {
      const double *p = wall->points[k], *q = wall->points[k + 1 < wall->n_points ? k + 1 : 0];
      if (fabs(p[c] - at) <= near && fabs(q[c] - at) <= near) return true;
    }
  }
  return false;
}

unsigned configuration_open(const configuration *c) {
  const region g = configuration_region(c, NULL);
  unsigned open = 0;
  for (int k = 0; !is_closed(c->model) && k < 2; k++)
    for (int side = 0; !g.whole[k] && side < 2; side++)
      if (!has_wall(c->model, k, side ? g.upper[k] : g.lower[k], 1e-9 * (g.upper[k] - g.lower[k])))
        open |= 1u << (2 * k + side);
  /* A floor of disks closes the lower edge without a wall. */
  return container_kind_of(c->model->container)->disk_floor ? open & ~4u : open;
}

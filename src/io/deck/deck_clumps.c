/* deck_clumps.c: rigid bodies of several disks: entries of `clumps`, and grains of a packing.
 * See deck_clumps.h. */
#include "io/deck/deck_clumps.h"

#include <math.h>
#include <string.h>

#include "base/memory.h"

/* --- adding a clump to the model -------------------------------------------------------------- */

static sd_clump *push(deck *d) {
  sd_model *m = d->model;
  if ((m->n_clumps & (m->n_clumps - 1)) == 0)
    m->clumps = deck_grow(d, m->clumps, 2 * m->n_clumps + 1, sizeof *m->clumps);
  sd_clump *c = &m->clumps[m->n_clumps++];
  *c = (sd_clump){0};
  return c;
}

/* --- clumps by name --------------------------------------------------------------------------- */

static void check_disk(deck *d, const deck_group *g, uint32_t body) {
  const sd_disk *disk = &d->model->disks[body];
  const bool moves =
      disk->velocity[SD_X] != 0 || disk->velocity[SD_Y] != 0 || disk->velocity[SD_THETA] != 0;
  const bool held =
      disk->driven || disk->locked[SD_X] || disk->locked[SD_Y] || disk->locked[SD_THETA];
  const char *what = disk->clump > 0 ? "belongs to another clump already"
                     : held          ? "is fixed or locked; expected `locked` of the clump"
                     : moves         ? "has a velocity of its own; expected velocity of the clump"
                                     : NULL;
  if (what) deck_fail(d, g->node, "%s %s", deck_body_name(d, body), what);
}

static void read_clump(deck_group *g, uint32_t number) {
  deck *d = g->d;
  const size_t before = d->reported;
  const char *name = deck_text_of(g, "name");
  const deck_bodies bodies = deck_select(g, false);
  for (size_t b = 0; b < bodies.n; b++) check_disk(d, g, bodies.body[b]);
  sd_clump c = {.mass = deck_get(g, "mass") ? deck_number(g, "mass") : 0,
                .inertia = deck_get(g, "inertia") ? deck_number(g, "inertia") : 0};
  deck_pair(g, "velocity", c.velocity);
  c.velocity[SD_THETA] = deck_number(g, "omega");
  deck_pair(g, "force", c.force);
  c.force[SD_THETA] = deck_number(g, "torque");
  const unsigned locked = deck_coordinates(g, "locked");
  for (int q = 0; q < SD_COORDINATES; q++) {
    c.locked[q] = locked >> q & 1;
    if (c.locked[q] && fabs(c.velocity[q]) > 0)
      deck_fail_key(g, "locked", "a locked coordinate cannot have a velocity");
  }
  if (d->reported > before) return;
  sd_clump *own = push(d);
  *own = c;
  for (size_t b = 0; b < bodies.n; b++)
    d->model->disks[bodies.body[b]].clump = (int)d->model->n_clumps;
  own->name = memory_text(name);
  if (name && !deck_index_add(d, &d->clumps, deck_copy(d, name, strlen(name)), number))
    deck_fail_key(g, "name", "two clumps have this name");
}

/* Puts the clumps of the list `clumps` before the first `packed` ones, which packings made.
 * Packings come first because the list may use their disks. */
static void order_clumps(deck *d, size_t packed) {
  sd_model *m = d->model;
  const size_t listed = m->n_clumps - packed;
  if (packed == 0 || listed == 0) return;
  sd_clump *copy = deck_more(d, m->clumps, m->n_clumps, m->n_clumps, sizeof *copy);
  memcpy(m->clumps, copy + packed, listed * sizeof *copy);
  memcpy(m->clumps + listed, copy, packed * sizeof *copy);
  for (size_t i = 0; i < m->n_disks; i++) {
    int *clump = &m->disks[i].clump;
    if (*clump > 0) *clump += (size_t)*clump > packed ? -(int)packed : (int)listed;
  }
}

void deck_read_clumps(deck *d) {
  deck_group g;
  const size_t packed = d->model->n_clumps;
  for (size_t k = 0; deck_next(d, &deck_clumps, &k, &g);) read_clump(&g, (uint32_t)k - 1);
  order_clumps(d, packed);
}

/* --- grains of a packing ---------------------------------------------------------------------- */

/* Shifts the disks so that their centre of mass, for equal density, is the origin; sets reach
 * and area. */
static void centre(deck_grain *grain) {
  double weight = 0, x = 0, y = 0;
  for (size_t k = 0; k < grain->n; k++) {
    const double w = grain->radius[k] * grain->radius[k];
    weight += w;
    x += w * grain->at[k][0];
    y += w * grain->at[k][1];
  }
  for (size_t k = 0; k < grain->n; k++) {
    grain->at[k][0] -= x / weight;
    grain->at[k][1] -= y / weight;
    grain->reach = fmax(grain->reach, hypot(grain->at[k][0], grain->at[k][1]) + grain->radius[k]);
    grain->area += grain->radius[k] * grain->radius[k];
  }
}

static bool read_pair(deck *d, const deck_node *node, double pair[2]) {
  if (node->type == DECK_LIST && node->n == 2)
    return deck_value_number(d, node->child[0], false, &pair[0]) &&
           deck_value_number(d, node->child[1], false, &pair[1]);
  deck_fail(d, node, "expected two numbers (x, y)");
  return false;
}

bool deck_read_grain(deck_group *packing, deck_grain *grain) {
  deck *d = packing->d;
  deck_node *node = deck_get(packing, "clump");
  deck_group g;
  *grain = (deck_grain){.n = 1, .reach = 1, .area = 1};
  if (!node || !deck_enter(d, node, &deck_packing_clump, &g)) return false;
  const size_t before = d->reported;
  deck_node *at = deck_get(&g, "at"), *radii = deck_get(&g, "radii");
  const size_t n = deck_each_count(at), n_radii = deck_each_count(radii);
  if (n < 1) deck_fail_key(&g, "at", "missing: expected the centres of its disks ([x, y], ...)");
  if (radii && n_radii != 1 && n_radii != n)
    deck_fail(d, radii, "%zu radii for %zu disks; expected one for each, or one for all", n_radii,
              n);
  if (d->reported > before) return false;
  *grain = (deck_grain){.n = n,
                        .radius = deck_alloc(d, n, sizeof(double)),
                        .at = deck_alloc(d, n, sizeof *grain->at)};
  for (size_t k = 0; k < n; k++) {
    read_pair(d, deck_each(at, k), grain->at[k]);
    grain->radius[k] = 1;
    deck_node *radius = radii ? deck_each(radii, n_radii == 1 ? 0 : k) : NULL;
    if (radius && deck_value_number(d, radius, false, &grain->radius[k]) && !(grain->radius[k] > 0))
      deck_fail(d, radius, "expected a number > 0");
  }
  if (d->reported > before) return false;
  centre(grain);
  return true;
}

void deck_push_grain(deck *d, const deck_grain *grain, const sd_disk *like, double radius,
                     double angle, const char *group, deck_place place) {
  const sd_model *m = d->model;
  const double c = cos(angle), s = sin(angle);
  push(d);
  for (size_t k = 0; k < grain->n; k++) {
    sd_disk disk = *like;
    disk.radius = radius * grain->radius[k];
    disk.mass = like->mass * grain->radius[k] * grain->radius[k] / grain->area;
    disk.clump = (int)m->n_clumps;
    const double away[] = {radius * (c * grain->at[k][0] - s * grain->at[k][1]),
                           radius * (s * grain->at[k][0] + c * grain->at[k][1])};
    for (int q = 0; q < 2; q++) {
      const double length = m->upper[q] - m->lower[q];
      disk.position[q] += away[q];
      if (m->periodic[q])
        disk.position[q] -= length * floor((disk.position[q] - m->lower[q]) / length);
    }
    deck_push_disk(d, &disk, NULL, group, place);
  }
}

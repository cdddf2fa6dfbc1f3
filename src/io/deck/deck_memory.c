/* deck_memory.c: contacts of a packing, taken over from the result of another run. See deck_result.h.
 *
 * A wall of the deck is the file's when it is described in the same words: by its name where both have one, else
 * by its place among as many. It then stands where it was at the end of that run, and its contacts go on.
 */
#include <math.h>
#include <string.h>

#include "io/deck/deck_result.h"
#include "model/law_features.h"
#include "slipdisk/deck.h"

#define NOWHERE UINT32_MAX /* of a body number */

/* The walls of the deck, as read, and where files have put them. */
typedef struct our_walls {
  deck *d;
  size_t n;
  result_wall *walls;
  size_t *first_segment; /* of each wall */
  bool *placed;
} our_walls;

/* --- walls ---------------------------------------------------------------------------------------------- */

/* Which wall of the deck the file's wall k is; NOWHERE: none. */
static uint32_t same_wall(const our_walls *ours, const deck_result *r, size_t k) {
  const result_wall *theirs = &r->walls[k];
  for (uint32_t w = 0; w < ours->n; w++) {
    const result_wall *own = &ours->walls[w];
    bool named = *own->name && *theirs->name;
    bool meant = named ? strcmp(own->name, theirs->name) == 0 : w == k && r->n_walls == ours->n;
    if (meant && strcmp(own->text, theirs->text) == 0) return w;
  }
  return NOWHERE;
}

/* Only lines change their size with a compressed box, and they have none. */
static void move_wall(sd_wall *w, double x, double y, double angle, double scale) {
  double c = cos(angle), s = sin(angle);
  for (size_t k = 0; k < w->n_points; k++) {
    double px = scale * (w->points[k][0] - w->pivot[0]), py = scale * (w->points[k][1] - w->pivot[1]);
    w->points[k][0] = x + (c * px - s * py);
    w->points[k][1] = y + (s * px + c * py);
  }
  double cx = w->center[0] - w->pivot[0], cy = w->center[1] - w->pivot[1];
  w->center[0] = x + (c * cx - s * cy);
  w->center[1] = y + (s * cx + c * cy);
  w->from += angle;
  w->to += angle;
  w->pivot[0] = x;
  w->pivot[1] = y;
}

/* An edge of the region that is a straight wall goes where the file has put the wall: servo walls and compression measure
 * the container by its region. */
static void move_edges(sd_model *m, const sd_wall *w, double x, double y) {
  const double to[2] = {x, y};
  for (int c = 0; c < 2; c++) {
    double *edges[2] = {&m->region_lower[c], &m->region_upper[c]};
    double near = 1e-9 * (*edges[1] - *edges[0]);
    if (w->kind != SD_WALL_LINE || fabs(w->points[0][c] - w->points[1][c]) > near) continue;
    for (int k = 0; k < 2; k++)
      if (fabs(w->points[0][c] - *edges[k]) <= near) {
        *edges[k] += to[c] - w->pivot[c];
        break;
      }
  }
}

static void place_wall(our_walls *ours, const deck_columns *t, size_t k, uint32_t w) {
  const deck_result *r = t->result;
  size_t body = r->n_disks + k;
  sd_wall *wall = &ours->d->model->walls[w];
  result_wall *own = &ours->walls[w];
  double x = r->x[body], y = r->y[body];
  double angle = r->walls[k].angle + (r->turn[body] + r->theta[body]),
         scale = r->walls[k].scale * r->box_scale;
  bool moved = x != wall->pivot[0] || y != wall->pivot[1];
  if (ours->placed[w] && (moved || angle != own->angle)) {
    char name[96];
    sd_model_body_name(ours->d->model, (uint32_t)(ours->d->model->n_disks + w), name, sizeof name);
    deck_fail_key(ours->d, t->file->parent, "contacts",
                  "%s stands at (%g, %g) in this file and at (%g, %g) in one before, or is turned", name, x,
                  y, wall->pivot[0], wall->pivot[1]);
  }
  if (ours->placed[w]) return;
  if (moved && angle == 0) move_edges(ours->d->model, wall, x, y);
  if (moved || angle != 0 || scale != 1) move_wall(wall, x, y, angle, scale);
  own->angle = angle;
  own->scale = scale;
  ours->placed[w] = true;
}

static our_walls list_walls(deck *d) {
  our_walls ours = {.d = d, .n = d->model->n_walls, .walls = deck_result_walls(d)};
  ours.first_segment = deck_alloc(d, ours.n + 1, sizeof *ours.first_segment);
  ours.placed = deck_alloc(d, ours.n + 1, sizeof *ours.placed);
  for (size_t w = 0; w < ours.n; w++)
    ours.first_segment[w + 1] = ours.first_segment[w] + ours.walls[w].segments;
  return ours;
}

/* --- contacts ------------------------------------------------------------------------------------------- */

/* Where bodies and segments of a file are in the model. */
typedef struct mapping {
  const our_walls *ours;
  const deck_columns *t;
  uint32_t *body;
  size_t *first_segment; /* of each wall of the file */
} mapping;

static mapping map_bodies(our_walls *ours, const deck_columns *t) {
  deck *d = ours->d;
  const deck_result *r = t->result;
  mapping map = {ours, t, deck_alloc(d, r->n_bodies + 1, sizeof *map.body),
                 deck_alloc(d, r->n_walls + 1, sizeof *map.first_segment)};
  for (size_t k = 0; k < r->n_bodies; k++) map.body[k] = NOWHERE;
  for (size_t row = 0; row < t->n_rows; row++) map.body[t->disk[row]] = (uint32_t)(t->first + row);
  for (size_t k = 0; k < r->n_walls && r->n_disks + k < r->n_bodies; k++) {
    uint32_t w = same_wall(ours, r, k);
    map.first_segment[k + 1] = map.first_segment[k] + r->walls[k].segments;
    if (w == NOWHERE) continue;
    map.body[r->n_disks + k] = (uint32_t)d->model->n_disks + w;
    place_wall(ours, t, k, w);
  }
  return map;
}

/* The angle in the state that a disk has here begins at another multiple of a turn, and may be rounded. */
static double angle_shift(const deck_result *r, uint32_t disk) {
  double total = r->turn[disk] + r->theta[disk];
  return (total - 8.0 * nearbyint(total / 8.0)) - r->theta[disk];
}

/* False: the partner is no body of this deck. */
static bool take_contact(const mapping *map, size_t k, sd_contact_memory *c) {
  const deck_result *r = map->t->result;
  uint32_t a = r->a[k], b = r->b[k], part = r->part[k];
  if (map->body[a] == NOWHERE || map->body[b] == NOWHERE) return false;
  double record[SD_CONTACT_ALL], shift = r->radius[a] * angle_shift(r, a); /* of lambda* */
  double rolled = angle_shift(r, a) - (b < r->n_disks ? angle_shift(r, b) : -r->theta[b]);
  if (b < r->n_disks) {
    shift += r->radius[b] * angle_shift(r, b);
  } else {
    size_t theirs = b - r->n_disks, own = map->body[b] - map->ours->d->model->n_disks;
    if (r->walls[theirs].segments && part - map->first_segment[theirs] >= r->walls[theirs].segments)
      return false;
    if (r->walls[theirs].segments)
      part = (uint32_t)(part - map->first_segment[theirs] + map->ours->first_segment[own]);
    /* a round wall begins at angle 0 */
    if (!r->walls[theirs].segments) shift -= r->radius[b] * r->theta[b];
    /* and a surface at 0 */
    if (theirs < r->n_surfaces) shift += r->radius[b] > 0 ? -r->surface[theirs] : r->surface[theirs];
  }
  *c = (sd_contact_memory){
      .a = map->body[a], .b = map->body[b], .part = part, .slide = r->slide[k], .side = r->side[k]};
  for (size_t n = 0; n < SD_CONTACT_ALL; n++) record[n] = r->record[n][k];
  memcpy(&c->record, record, sizeof record);
  c->record.lambda_ref += shift;
  if (c->record.rho_ref != 0.0) c->record.rho_ref += law_arm(r->radius[a], r->radius[b]) * rolled;
  c->record.viscous = c->record.friction = c->record.nonconservative_work = c->record.rolling =
      0.0; /* these are of the other run */
  return true;
}

static void take_contacts(const mapping *map) {
  deck *d = map->ours->d;
  sd_model *m = d->model;
  const deck_result *r = map->t->result;
  size_t lost = 0, first_lost = 0;
  m->memories = deck_grow(d, m->memories, m->n_memories + r->n_contacts + 1, sizeof *m->memories);
  for (size_t k = 0; k < r->n_contacts; k++) {
    if (take_contact(map, k, &m->memories[m->n_memories]))
      m->n_memories++;
    else if (lost++ == 0)
      first_lost = r->b[k];
  }
  if (!lost) return;
  size_t wall = first_lost >= r->n_disks ? first_lost - r->n_disks : 0;
  bool known = first_lost >= r->n_disks && wall < r->n_walls;
  sd_warn(d->messages,
          "%s: %zu of %zu contacts are with walls that this deck does not have, or describes in another way "
          "(the first: wall %zu%s%s%s of the file); they are not taken over",
          r->path, lost, r->n_contacts, wall, known && *r->walls[wall].name ? " \"" : "",
          known ? r->walls[wall].name : "", known && *r->walls[wall].name ? "\"" : "");
}

void deck_read_memories(deck *d) {
  our_walls ours = list_walls(d);
  for (size_t k = 0; k < d->n_file_tables && !d->reported; k++) {
    const deck_columns *t = &d->file_tables[k];
    if (!t->contacts || !t->result) continue;
    mapping map = map_bodies(&ours, t);
    take_contacts(&map);
  }
  d->model->deck->bodies = deck_result_text(d, ours.walls);
}

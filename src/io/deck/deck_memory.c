/* deck_memory.c: takes over contacts from the result of another run. See deck_result.h.
 *
 * A wall of the deck corresponds to a wall of the file if both have the same description and the
 * same name. If one of the two has no name, they must have the same index, and deck and file the
 * same number of walls. The wall of the deck is then moved to its position at the end of the other
 * run, and its contacts continue. */
#include <math.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "io/deck/deck.h"
#include "io/deck/deck_rows.h"
#include "io/deck/deck_result.h"
#include "model/walls.h"
#include "model/model.h"
#include "model/laws.h"
#include "slipdisk/deck.h"

#define NOWHERE UINT32_MAX /* Value in place of a body number: the body is not in the model */

/* Walls of the model: their descriptions in the deck, and whether each was moved to its position in
 * a file. */
typedef struct our_walls {
  deck *d;
  size_t n;
  result_wall *walls;
  /* [n + 1]: number of the first segment of each wall, counted over all walls */
  size_t *first_segment;
  bool *placed;
} our_walls;

/* --- walls ------------------------------------------------------------------------------------ */

/* Returns the number of the model's wall that corresponds to wall k of the file; NOWHERE: none. */
static uint32_t same_wall(const our_walls *ours, const deck_result *r, size_t k) {
  const result_wall *theirs = &r->walls[k];
  for (uint32_t w = 0; w < ours->n; w++) {
    const result_wall *own = &ours->walls[w];
    bool named = *own->name && *theirs->name;
    bool meant = named ? strcmp(own->name, theirs->name) == 0 : w == k && r->n_walls == ours->n;
    if (meant && own->segments == theirs->segments && strcmp(own->text, theirs->text) == 0)
      return w;
  }
  return NOWHERE;
}

/* Moves a wall's pivot to (x, y), turns the wall by `angle` (rad) and scales it about the pivot.
 * Radii are not scaled, since compression of the box scales only infinite lines. */
static void move_wall(sd_wall *w, double x, double y, double angle, double scale) {
  double c, s;
  math_sine_cosine(angle, &s, &c);
  for (size_t k = 0; k < w->n_points; k++) {
    double px = scale * (w->points[k][0] - w->pivot[0]),
           py = scale * (w->points[k][1] - w->pivot[1]);
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

/* Moves an edge of the region together with the infinite line that coincides with it, since servo
 * walls and compression take the container's size from the region. x, y: new pivot of the wall. */
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
  size_t body = r->n_disks + k - r->first_body;
  sd_wall *wall = &ours->d->model->walls[w];
  result_wall *own = &ours->walls[w];
  double x = r->x[body], y = r->y[body];
  double angle = r->walls[k].angle + (r->turn[body] + r->theta[body]),
         scale = r->walls[k].scale * r->box_scale;
  bool moved = x != wall->pivot[0] || y != wall->pivot[1];
  if (ours->placed[w] && (moved || angle != own->angle)) {
    const char *name = deck_body_name(ours->d, (uint32_t)(ours->d->model->n_disks + w));
    deck_fail_child(
        ours->d, t->file->parent, "contacts",
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

/* --- contacts --------------------------------------------------------------------------------- */

/* Moves the walls of the model to their positions in the file. Fills `walls`, one element per wall
 * of the file, with the corresponding walls of the model, and returns it. */
static sd_tile_wall *map_walls(our_walls *ours, const deck_columns *t, sd_tile_wall *walls) {
  const deck_result *r = t->result;
  size_t first = 0;
  for (size_t k = 0; k < r->n_walls && r->n_disks + k < r->n_bodies; k++) {
    const size_t row = r->n_disks + k - r->first_body;
    const uint32_t w = same_wall(ours, r, k);
    sd_tile_wall *wall = &walls[k];
    *wall = (sd_tile_wall){.pieces = r->walls[k].segments,
                           .first = first,
                           .radius = r->radius[row],
                           .theta = r->theta[row]};
    if (k < r->n_surfaces) wall->surface = r->surface[k];
    first += r->walls[k].segments;
    if (w == NOWHERE) continue;
    wall->known = true;
    wall->wall = w;
    wall->own_first = ours->first_segment[w];
    const sd_wall *own = &ours->d->model->walls[w];
    wall->arc = own->kind == SD_WALL_ARC ? own->radius : 0.0;
    wall->ring = wall->arc > 0.0 && arc_is_ring(own);
    place_wall(ours, t, k, w);
  }
  return walls;
}

/* Returns the signed radius R_b of the partner at the contact: negative inside a round wall or an
 * arc, 0 for straight segments and ends of walls. */
static double radius_of(const sd_contact_memory *c, disk_angle_shift b, const sd_tile_wall *wall) {
  if (!wall) return b.radius;
  if (wall->pieces == 0) return wall->radius;
  return wall->ring || c->part - wall->first == 1 ? -c->side * wall->arc : 0.0;
}

void deck_carry_contact(sd_contact_memory *c, disk_angle_shift a, disk_angle_shift b,
                        const sd_tile_wall *wall, bool carried) {
  const double rb = radius_of(c, b, wall);
  /* Change of lambda_ref, the reference value of the tangential displacement */
  double shift = a.radius * a.shift;
  const double rolled = a.shift - (wall ? -wall->theta : b.shift);
  if (!wall) {
    shift += b.radius * b.shift;
  } else {
    if (wall->pieces)
      c->part = (uint32_t)(c->part - wall->first + wall->own_first);
    else
      /* The angle of a round wall starts at 0 in the new run, not at its value in the file */
      shift -= wall->radius * wall->theta;
    /* The displacement of a wall's surface along the wall starts at 0 in the new run */
    shift += wall->radius > 0 ? -wall->surface : wall->surface;
  }
  c->record.lambda_ref += shift;
  c->record.rho_ref += law_arm(a.radius, rb) * rolled;
  if (c->record.bond > 0.0) {
    c->record.bond_lambda += shift;
    c->record.bond_rho += law_arm(a.radius, rb) * rolled;
  }
  c->record.viscous = c->record.friction = c->record.nonconservative_work = c->record.rolling = 0.0;
  c->force_carried = carried;
  if (carried) return;
  /* The first force evaluation sets rho and roll, and tau and pull too unless the contact slides:
   * there they are kept, since they are the limit of its friction */
  c->record.rho = c->record.roll = 0.0;
  c->record.bond_pull = c->record.bond_shear = c->record.bond_bend = 0.0;
  if (c->slide == 0) c->record.tau = c->record.pull = 0.0;
}

/* Contacts of a file that are not taken over, since their partners are not in the model. */
typedef struct lost_contacts {
  size_t n;
  /* Body number, in the file, of the partner (mostly a wall) in the first of these contacts */
  uint32_t first;
} lost_contacts;

static void warn_of_lost(deck *d, const deck_result *r, const lost_contacts *lost) {
  if (!lost->n) return;
  const bool known = lost->first >= r->n_disks && lost->first - r->n_disks < r->n_walls;
  const size_t wall = lost->first >= r->n_disks ? lost->first - r->n_disks : 0;
  sd_warn(d->messages,
          "%s: %zu of %zu contacts are with walls that this deck does not have, or describes in "
          "another way "
          "(the first: wall %zu%s%s%s of the file); they are not taken over",
          r->path, lost->n, r->all_contacts, wall, known && *r->walls[wall].name ? " \"" : "",
          known ? r->walls[wall].name : "", known && *r->walls[wall].name ? "\"" : "");
}

/* Returns an array of disk numbers in the model, indexed by disk numbers in the file; NOWHERE: not
 * in the model. */
static uint32_t *map_disks(deck *d, const deck_columns *t) {
  const deck_result *r = t->result;
  uint32_t *body = deck_alloc(d, r->n_disks + 1, sizeof *body);
  for (size_t k = 0; k < r->n_disks; k++) body[k] = NOWHERE;
  for (size_t row = 0; row < t->n_rows; row++) body[t->disk[row]] = (uint32_t)(t->first + row);
  return body;
}

static disk_angle_shift turned_of(const deck_result *r, uint32_t disk) {
  return (disk_angle_shift){r->radius[disk], deck_result_shift(r, disk)};
}

/* Returns the number that material k of the file has in the model; -1: no disk has it. */
static int32_t own_material(const our_walls *ours, const deck_columns *t, size_t k) {
  const sd_model *m = ours->d->model;
  const deck_result *r = t->result;
  bool named = false;
  uint32_t found;
  for (size_t c = 0; c < t->n_columns; c++) named = named || t->column[c] == COLUMN_MATERIAL;
  if (!named && t->first >= model_held(m)) return m->tiles.material;
  if (!named) return t->n_rows > 0 ? m->disks[t->first].material : -1;
  const char *name = k < r->materials.n ? r->materials.name[k] : NULL;
  return name && deck_index_find(&ours->d->materials, name, &found) ? (int32_t)found : -1;
}

/* Returns true if laws, masses and velocities are those of the file, so that the contact forces in
 * the file are valid at step 0. They cannot be recomputed: they were evaluated at predicted
 * velocities, which the file does not contain. */
static bool forces_carried(const our_walls *ours, const deck_columns *t) {
  const sd_model *m = ours->d->model;
  const deck_result *r = t->result;
  const size_t n = r->n_materials, walls = r->n_bodies - r->n_disks, own = m->n_materials;
  unsigned kept = 0;
  for (size_t c = 0; c < t->n_columns; c++) kept |= 1u << t->column[c];
  const unsigned needed =
      1u << COLUMN_VX | 1u << COLUMN_VY | 1u << COLUMN_OMEGA | 1u << COLUMN_MASS;
  if (n == 0 || (kept & needed) != needed) return false;
  int32_t *mine = deck_alloc(ours->d, n, sizeof *mine);
  for (size_t k = 0; k < n; k++) mine[k] = own_material(ours, t, k);
  for (size_t i = 0; i < n; i++)
    for (size_t k = 0; k < n && mine[i] >= 0; k++)
      if (mine[k] >= 0 &&
          !law_is_same(&r->laws[i * n + k], &m->laws[(size_t)mine[i] * own + (size_t)mine[k]]))
        return false;
  for (size_t w = 0; w < walls; w++) {
    const uint32_t there = same_wall(ours, r, w);
    const int32_t theirs = r->wall_material[w];
    if (there == NOWHERE || m->walls[there].material < 0) continue;
    if (theirs < 0 || (size_t)theirs >= n) return false;
    for (size_t i = 0; i < n; i++)
      if (mine[i] >= 0 &&
          !law_is_same(&r->laws[i * n + (size_t)theirs],
                       &m->laws[(size_t)mine[i] * own + (size_t)m->walls[there].material]))
        return false;
  }
  return true;
}

/* Takes over the higher derivatives of the disks, except at locked coordinates. The file holds
 * dt^j/j! times the j-th derivative, j = 3 to 5, so each value is scaled by (new dt / old dt)^j. */
static void take_derivatives(deck *d, const deck_columns *t) {
  sd_model *m = d->model;
  const deck_result *r = t->result;
  const double ratio = m->dt / r->dt;
  if (!m->derivatives) {
    m->derivatives = deck_keep(d, m->n_disks, sizeof *m->derivatives);
    m->n_derivatives = m->n_disks;
  }
  for (size_t row = 0; row < t->n_rows; row++)
    for (size_t k = 0; k < SD_DERIVATIVES; k++)
      if (!m->disks[t->first + row].locked[k / 3])
        m->derivatives[t->first + row][k] =
            r->derivatives[k][t->disk[row]] * math_pow(ratio, (double)(3 + k % 3));
}

/* Takes over the contacts of a file. Returns true if the contact forces in the file are valid at
 * step 0. */
static bool take_contacts(our_walls *ours, const deck_columns *t) {
  deck *d = ours->d;
  sd_model *m = d->model;
  const deck_result *r = t->result;
  const uint32_t *body = map_disks(d, t);
  const size_t n_walls = r->n_bodies - r->n_disks;
  static const sd_tile_wall unknown;
  const sd_tile_wall *walls = map_walls(ours, t, deck_alloc(d, n_walls + 1, sizeof *walls));
  lost_contacts lost = {0};
  const bool carried = forces_carried(ours, t);
  m->forces_carried = m->forces_carried || carried;
  m->memories = deck_grow(d, m->memories, m->n_memories + r->n_contacts, sizeof *m->memories);
  for (size_t k = 0; k < r->n_contacts; k++) {
    sd_contact_memory c = deck_result_contact(r, k);
    const bool two = c.b < r->n_disks;
    const sd_tile_wall *wall = two ? NULL : &walls[c.b - r->n_disks];
    if (body[c.a] == NOWHERE || (two && body[c.b] == NOWHERE)) wall = &unknown;
    if (!deck_contact_is_kept(&c, wall)) {
      if (lost.n++ == 0) lost.first = c.b;
      continue;
    }
    deck_carry_contact(&c, turned_of(r, c.a), two ? turned_of(r, c.b) : (disk_angle_shift){0}, wall,
                       carried);
    c.a = body[c.a];
    c.b = two ? body[c.b] : (uint32_t)m->n_disks + wall->wall;
    m->memories[m->n_memories++] = c;
  }
  warn_of_lost(d, r, &lost);
  return carried;
}

/* Takes over the contacts of a file whose disks the ranks read in parts: reads its walls and its
 * number of contacts here, then lets each rank read some of the contacts. */
static void survey_contacts(our_walls *ours, deck_columns *t) {
  deck *d = ours->d;
  sd_tiles *tiles = &d->model->tiles;
  d->asked = (deck_rows_asked){.part = true, .contacts = true, .again = true};
  deck_result *r = t->result = deck_result_read(d, t->file, t->result->path, true);
  d->asked = (deck_rows_asked){0};
  if (!r) return;
  if (r->n_disks != tiles->count) {
    deck_fail(d, t->file, "has changed while it was read");
    return;
  }
  tiles->n_walls = r->n_bodies - r->n_disks;
  tiles->walls = memory_new(tiles->n_walls, sizeof *tiles->walls);
  map_walls(ours, t, tiles->walls);
  tiles->n_contacts = r->all_contacts;
  lost_contacts lost = {0};
  tiles->forces_carried = d->model->forces_carried = forces_carried(ours, t);
  if (!deck_parts_contacts(d, &lost.n, &lost.first))
    deck_fail(d, t->file, "the contacts in this file are damaged");
  warn_of_lost(d, r, &lost);
}

void deck_read_memories(deck *d) {
  our_walls ours = list_walls(d);
  sd_tiles *tiles = &d->model->tiles;
  for (size_t k = 0; k < d->n_file_tables && !d->reported; k++) {
    deck_columns *t = &d->file_tables[k];
    const bool large = tiles->of_file && tiles->entry == k;
    if (!t->contacts || !t->result) continue;
    if (large && tiles->away) {
      survey_contacts(&ours, t);
      continue;
    }
    const bool carried = take_contacts(&ours, t);
    /* Higher derivatives in a large file are ignored, since ranks that read it in parts do not get
     * them */
    if (carried && !large && t->result->derivatives[0]) take_derivatives(d, t);
    if (large) deck_parts_note_contacts(d, t->result);
  }
  d->model->deck->bodies = deck_result_text(d, ours.walls);
}

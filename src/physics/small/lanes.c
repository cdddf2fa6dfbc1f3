/* lanes.c: small systems in SIMD lanes: copies them between their states and the arrays of lanes.h,
 * and handles their rare events (contacts that begin or end, angles to be wrapped). */
#include "physics/small/lanes.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "model/model.h"
#include "model/motions.h"
#include "model/walls.h"
#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/neighbours/validity.h"
#include "physics/step/contacts.h"
#include "physics/step/engine.h"
#include "physics/system/kernels.h"

/* --- tables ----------------------------------------------------------------------------------- */

static size_t find_pair(const lanes *l, uint32_t one, uint32_t two) {
  for (size_t k = 0; k < l->n_pairs; k++)
    if ((l->a[k] == one && l->b[k] == two) || (l->a[k] == two && l->b[k] == one)) return k;
  assert(!"a pair of these systems"); /* suits_watch guarantees that the pair exists */
  return 0;
}

/* Lists all pairs of a free disk and another body, in the order of slots, as the neighbour list
 * does; then lists the pairs of each body, in the order of the partners' slots. */
static void list_pairs(lanes *l) {
  for (uint32_t i = 0; i < l->n_free; i++)
    for (uint32_t j = i + 1; j < l->n_bodies; j++) {
      assert(l->n_pairs < LANES_PAIRS);
      l->a[l->n_pairs] = i;
      l->b[l->n_pairs++] = j;
    }
  for (uint32_t i = 0; i < l->n_bodies; i++)
    for (uint32_t j = 0; j < l->n_bodies; j++) {
      if (j == i || (i >= l->n_free && j >= l->n_free)) continue;
      size_t k = find_pair(l, i, j);
      assert(l->touching[i] < LANES_PAIRS);
      l->entry[i][l->touching[i]++] = (uint8_t)(2 * k + (l->b[k] == i));
    }
}

static double *rows_at(const lanes *l, size_t row) { return l->memory + row * l->width; }

static void lay_rows(lanes *l) {
  for (size_t i = 0; i < LANES_FREE; i++) l->disk[i] = rows_at(l, ROWS_DISK + i * DISK_ROWS);
  for (size_t k = 0; k < LANES_PAIRS; k++) l->pair[k] = rows_at(l, ROWS_PAIR + k * PAIR_ROWS);
  for (size_t k = 0; k < LANES_PAIRS; k++)
    l->of_straight[k] = rows_at(l, ROWS_STRAIGHT + k * STRAIGHT_ROWS);
  _Static_assert((int)PAIR_CLOSED == (int)SD_CONTACT_ALL, "the record comes first");
  l->place = rows_at(l, ROWS_PLACE);
  l->radius = rows_at(l, ROWS_RADIUS);
  l->dt = rows_at(l, ROWS_DT);
  l->per_dt = rows_at(l, ROWS_PER_DT);
  l->work = rows_at(l, ROWS_WORK);
  l->least = rows_at(l, ROWS_LEAST);
}

lanes *lanes_new(bool alone, size_t count, engine *const *system) {
  const size_t width = alone ? 2 : system[0]->work.kernels->lane_width;
  assert(count >= 1 && count <= width && width <= LANES_MOST && (!alone || count == 1));
  for (size_t k = 0; k < count; k++)
    assert(system[k]->work.n_threads == 1 && lanes_suit(system[k]->model) &&
           lanes_alike(system[0]->model, system[k]->model));
  lanes *l = memory_new(1, sizeof *l);
  l->memory = memory_lines((size_t)ROWS_ALL * LANES_MOST * sizeof(double));
  l->width = width;
  l->count = count;
  for (size_t k = 0; k < LANES_MOST; k++) l->system[k] = system[k < count ? k : 0];
  const sd_model *m = system[0]->model;
  const sd_state *s = system[0]->state;
  l->gear = m->integrator == SD_GEAR5;
  l->conservative = m->variant == SD_CONSERVATIVE;
  for (size_t k = 0; k < count; k++) l->features |= system[k]->work.features;
  l->n_free = s->n_free;
  l->n_disks = s->n_disks;
  l->n_bodies = s->n_bodies;
  l->n_slides = s->n_slides;
  assert(l->n_free >= 1 && l->n_free <= LANES_FREE && l->n_bodies <= LANES_BODIES &&
         l->n_slides <= LANES_SLIDES);
  list_pairs(l);
  for (size_t k = 0; k < l->n_pairs; k++) {
    l->straight[k] = l->b[k] >= s->n_disks && wall_is_straight(&m->walls[l->b[k] - s->n_disks]);
    l->any_straight |= l->straight[k];
  }
  const slot_table *slots = &system[0]->work.slots;
  l->visits = m->measure_configurations;
  for (size_t k = 0; k < l->n_slides; k++)
    l->watching[k] = (uint8_t)slot_of(slots, m->slides[k].disk);
  for (size_t k = 0; k < l->n_slides; k++)
    for (size_t side = 0; side < 2; side++)
      l->watched[2 * k + side] = (uint8_t)find_pair(l, slot_of(slots, m->slides[k].disk),
                                                    slot_of(slots, m->slides[k].partner[side]));
  lay_rows(l);
  if (!alone) l->motion = pose_batch_new(width, count, system);
  return l;
}

void lanes_free(lanes *l) {
  if (!l) return;
  pose_batch_free(l->motion);
  free(l->memory);
  free(l);
}

/* --- poses ------------------------------------------------------------------------------------ */

/* Finds where the poses of prescribed bodies are read from: several systems use their common batch
 * of poses; a single system uses the values that its motions computed ahead or, for coordinates
 * that do not move, copies of the state's values. */
static void find_poses(lanes *l) {
  engine *e = l->system[0];
  const sd_state *s = e->state;
  memset(l->placed, 0, sizeof l->placed);
  size_t n;
  const prescribed *p = motion_prescribed(e, &n);
  for (size_t k = 0; k < n; k++) {
    assert(p[k].slot >= l->n_free && p[k].slot < l->n_bodies &&
           !l->placed[p[k].slot][p[k].coordinate]);
    l->placed[p[k].slot][p[k].coordinate] = true;
  }
  l->poses = l->motion ? pose_batch_poses(l->motion) : NULL;
  for (size_t i = l->n_free; i < l->n_bodies && !l->motion; i++) {
    const double now[POSES] = {s->x[i], s->y[i], s->theta[i], s->vx[i], s->vy[i], s->omega[i]};
    for (int c = 0; c < POSES; c++) {
      if (l->placed[i][c % SD_COORDINATES]) continue;
      l->pose[i][c] = l->still[i][c];
      for (size_t k = 0; k < MOTION_BATCH; k++) l->still[i][c][k] = now[c];
    }
  }
  for (size_t k = 0; !l->motion && k < n; k++) {
    l->pose[p[k].slot][p[k].coordinate] = p[k].value;
    l->pose[p[k].slot][POSE_VX + p[k].coordinate] = p[k].velocity;
  }
}

static double pose_now(const lanes *l, size_t slot, int which, size_t lane) {
  assert(l->at >= 0 && l->at < (l->motion ? POSE_STEPS : MOTION_BATCH));
  if (!l->motion) return l->pose[slot][which][l->at];
  return l->poses[(((slot - l->n_free) * POSES + (size_t)which) * POSE_STEPS + (size_t)l->at) *
                      l->width +
                  lane];
}

static double *cell(const lanes *l, double *rows, size_t row, size_t lane) {
  return rows + row * l->width + lane;
}

/* Copies the prescribed poses of the last completed step to the rows, since the next batch of poses
 * overwrites them. */
static void keep_poses(lanes *l) {
  double *p = l->place;
  for (size_t i = l->n_free; i < l->n_bodies; i++)
    for (int c = 0; c < SD_COORDINATES; c++) {
      if (!l->placed[i][c]) continue;
      for (size_t lane = 0; lane < l->width; lane++) {
        *cell(l, p, PLACE_LAST, lane) = pose_now(l, i, c, lane);
        *cell(l, p, PLACE_SPEED, lane) = pose_now(l, i, POSE_VX + c, lane);
      }
      p += PLACE_ROWS * l->width;
    }
}

int64_t lanes_ready(lanes *l) {
  engine *e = l->system[0];
  if (l->motion) {
    int64_t ready = pose_batch_ahead(l->motion);
    l->at = e->state->step - pose_batch_first(l->motion);
    assert(ready >= 0 && l->at >= 0 && l->at + ready < POSE_STEPS);
    return ready;
  }
  motion_ahead(e);
  size_t n;
  const prescribed *p = motion_prescribed(e, &n);
  for (size_t k = 0; k < n; k++)
    if (p[k].coordinate == SD_THETA && (p[k].low < -4.0 || p[k].high > 4.0)) return 0;
  l->at = motion_index(e) - 1;
  assert(l->at >= -1 && l->at < MOTION_BATCH - 1);
  return MOTION_BATCH - motion_index(e);
}

/* --- load and store --------------------------------------------------------------------------- */

static size_t index_in(const engine *e, const lanes *l, size_t k) {
  const pairs *p = &e->work.pairs;
  for (size_t n = 0; n < p->count; n++)
    if ((uint32_t)p->a[n] == l->a[k] && (uint32_t)p->b[n] == l->b[k]) return n;
  return SIZE_MAX;
}

static void load_memory(lanes *l, size_t lane) {
  const engine *e = l->system[lane];
  const sd_state *s = e->state;
  const pairs *p = &e->work.pairs;
  for (size_t k = 0; k < l->n_pairs; k++) {
    size_t n = index_in(e, l, k);
    const bool listed = n != SIZE_MAX;
    for (size_t r = 0; r < SD_CONTACT_COLUMNS; r++)
      *cell(l, l->pair[k], r, lane) = listed ? PAIR(p, n, record[r]) : 0.0;
    for (size_t r = 0; p->more && r < SD_CONTACT_EXTRA; r++)
      *cell(l, l->pair[k], SD_CONTACT_COLUMNS + r, lane) = listed ? MORE(p, n, record[r]) : 0.0;
    *cell(l, l->pair[k], PAIR_CLOSED, lane) = listed && pairs_closed(p, n) ? 1.0 : 0.0;
    *cell(l, l->pair[k], PAIR_SLIP, lane) = listed ? -pairs_slide_sign(p, n) : 0.0;
    *cell(l, l->of_straight[k], STRAIGHT_SIDE, lane) = listed && l->straight[k] ? p->side[n] : 0.0;
  }
  for (size_t i = 0; i < l->n_free; i++) {
    *cell(l, l->disk[i], SD_THETA * DISK_COLUMNS, lane) = s->theta[i];
    *cell(l, rows_at(l, ROWS_FAST), i, lane) = s->radius[i] * s->radius[i] * e->work.speed_limit2;
  }
}

/* Loads the constants of pair k if its second body is a straight wall that does not turn. They are
 * computed with the same rounding as in segment_pass.h. */
static void load_straight(lanes *l, size_t k, size_t lane) {
  const engine *e = l->system[lane];
  const sd_state *s = e->state;
  const uint32_t a = l->a[k], b = l->b[k];
  const double angle = s->theta[b] + s->turn[b], radius = s->radius[a];
  const law_row *law =
      &e->work.laws[(size_t)s->material[a] * e->model->n_materials + (size_t)s->material[b]];
  const sd_segment *piece = e->model->segments;
  while (piece->body != s->id[b]) piece++;
  double sine, cosine;
  math_sine_cosine(angle, &sine, &cosine);
  const placed_segment g = walls_place(piece, 0.0, 0.0, cosine, sine, s->box_scale);
  double *p = l->pair[k];
  *cell(l, l->of_straight[k], STRAIGHT_START_X, lane) = g.x;
  *cell(l, l->of_straight[k], STRAIGHT_START_Y, lane) = g.y;
  *cell(l, l->of_straight[k], STRAIGHT_TX, lane) = g.tx;
  *cell(l, l->of_straight[k], STRAIGHT_TY, lane) = g.ty;
  *cell(l, l->of_straight[k], STRAIGHT_LENGTH, lane) = g.length;
  *cell(l, l->of_straight[k], STRAIGHT_BACK, lane) = g.backwards;
  *cell(l, p, PAIR_LIMIT, lane) = e->model->max_overlap * radius;
  *cell(l, p, PAIR_TSUJI, lane) = law->tsuji * sqrt(s->mass[a] * law->k_n);
}

static void load_constants(lanes *l, size_t lane) {
  const engine *e = l->system[lane];
  const sd_state *s = e->state;
  const work *w = &e->work;
  *cell(l, l->dt, 0, lane) = w->dt;
  *cell(l, l->per_dt, 0, lane) = w->per_dt;
  for (size_t i = 0; i < l->n_bodies; i++) *cell(l, l->radius, i, lane) = s->radius[i];
  for (size_t i = 0; i < l->n_free; i++)
    for (size_t c = 0; c < SD_COORDINATES; c++) {
      double gain = w->half_dt2 * w->columns[c].inverse[i];
      *cell(l, l->disk[i], DISK_GAIN + c, lane) = gain;
      *cell(l, l->disk[i], DISK_PUSH + c, lane) = w->columns[c].constant[i] * gain;
    }
  for (size_t k = 0; k < l->n_pairs; k++) {
    double ra = s->radius[l->a[k]], rb = s->radius[l->b[k]], least = fabs(rb) < ra ? fabs(rb) : ra;
    const law_row *law = &w->laws[(size_t)s->material[l->a[k]] * e->model->n_materials +
                                  (size_t)s->material[l->b[k]]];
    double *p = l->pair[k];
    *cell(l, p, PAIR_KN, lane) = law->k_n;
    *cell(l, p, PAIR_KT, lane) = law->k_t;
    *cell(l, p, PAIR_GAMMA, lane) = law->gamma_n;
    *cell(l, p, PAIR_CAP, lane) = law->cap;
    *cell(l, p, PAIR_NORMAL, lane) = law->normal;
    /* the same rounding as in pair_pass.h */
    double inverse = 1.0 / s->mass[l->a[k]] + (l->b[k] < l->n_free ? 1.0 / s->mass[l->b[k]] : 0.0);
    *cell(l, p, PAIR_TSUJI, lane) = law->tsuji * sqrt(law->k_n / inverse);
    for (size_t r = 0; r < LAW_MORE; r++) *cell(l, p, PAIR_LAW + r, lane) = (&law->pulls)[r];
    *cell(l, p, PAIR_LIMIT, lane) = e->model->max_overlap * least;
    *cell(l, p, PAIR_RA, lane) = ra;
    *cell(l, p, PAIR_RB, lane) = rb;
    *cell(l, p, PAIR_SUM, lane) = ra + rb;
    if (l->straight[k]) load_straight(l, k, lane);
  }
}

static double *visit_rows(const lanes *l, size_t w) {
  return rows_at(l, ROWS_VISIT + VISIT_ROWS * w);
}

static void load_visits(lanes *l, size_t lane) {
  const sd_state *s = l->system[lane]->state;
  for (size_t w = 0; w < s->n_visits; w++) {
    double *rows = visit_rows(l, w);
    for (size_t q = 0; q < VISIT_SUMS; q++)
      *cell(l, rows, q, lane) = s->visit_part[VISIT_SUMS * w + q];
    *cell(l, rows, VISIT_ROW_CLASS, lane) = s->visit_class[w];
    *cell(l, rows, VISIT_ROW_LEFT, lane) = visits_left(s, w, s->measured);
    for (size_t side = 0; side < 2; side++)
      *cell(l, rows, VISIT_ROW_REFERENCE + side, lane) = s->visit_reference[2 * w + side];
  }
}

static void store_visits(const lanes *l, size_t lane, size_t w) {
  sd_state *s = l->system[lane]->state;
  for (size_t q = 0; q < VISIT_SUMS; q++)
    s->visit_part[VISIT_SUMS * w + q] = *cell(l, visit_rows(l, w), q, lane);
}

static void load_lane(lanes *l, size_t lane) {
  const engine *e = l->system[lane];
  const sd_state *s = e->state;
  load_constants(l, lane);
  load_memory(l, lane);
  for (size_t i = 0; i < l->n_free; i++)
    for (size_t c = 0; c < SD_COORDINATES; c++) {
      const columns *q = &e->work.columns[c];
      const double column[DISK_COLUMNS] = {q->q[i],  q->v[i],  q->q2[i],
                                           q->q3[i], q->q4[i], q->q5[i]};
      for (size_t r = 0; r < DISK_COLUMNS; r++)
        *cell(l, l->disk[i], c * DISK_COLUMNS + r, lane) = column[r];
    }
  const double *at[] = {s->x, s->y, s->theta}, *force[] = {s->force_x, s->force_y, s->torque};
  const double *speed[] = {s->vx, s->vy, s->omega};
  double *p = l->place;
  for (size_t i = l->n_free; i < l->n_bodies; i++)
    for (size_t c = 0; c < SD_COORDINATES; c++) {
      if (!l->placed[i][c]) continue;
      *cell(l, p, PLACE_LAST, lane) = at[c][i];
      *cell(l, p, PLACE_SPEED, lane) = speed[c][i];
      *cell(l, p, PLACE_FORCE, lane) = force[c][i];
      p += PLACE_ROWS * l->width;
    }
  *cell(l, l->work, 0, lane) = s->work_driven;
  for (size_t k = 0; k < 2 * l->n_slides; k++) *cell(l, l->least, k, lane) = s->slide_force_min[k];
  load_visits(l, lane);
}

void lanes_load(lanes *l) {
  if (l->motion) pose_batch_load(l->motion);
  find_poses(l);
  l->dead = 0;
  l->stepped = false;
  memset(l->returns, 0, sizeof l->returns);
  l->fast = 0;
  memset(l->count_of, 0, sizeof l->count_of);
  for (size_t lane = 0; lane < l->width; lane++) load_lane(l, lane);
}

/* Stores the poses of one lane in the state of its system, and rebuilds the system's neighbour
 * lists if they are stale. */
static sd_status store_poses(const lanes *l, size_t lane) {
  engine *e = l->system[lane];
  sd_state *s = e->state;
  for (size_t i = 0; i < l->n_free; i++)
    for (size_t c = 0; c < SD_COORDINATES; c++) {
      const columns *q = &e->work.columns[c];
      double *column[DISK_COLUMNS] = {q->q + i,  q->v + i,  q->q2 + i,
                                      q->q3 + i, q->q4 + i, q->q5 + i};
      for (size_t r = 0; r < DISK_COLUMNS; r++)
        *column[r] = *cell(l, l->disk[i], c * DISK_COLUMNS + r, lane);
    }
  double *at[POSES] = {s->x, s->y, s->theta, s->vx, s->vy, s->omega}, *p = l->place;
  for (size_t i = l->n_free; i < l->n_bodies; i++)
    for (int c = 0; c < SD_COORDINATES; c++) {
      if (!l->placed[i][c]) continue;
      at[c][i] = *cell(l, p, PLACE_LAST, lane);
      at[POSE_VX + c][i] = *cell(l, p, PLACE_SPEED, lane);
      p += PLACE_ROWS * l->width;
    }
  if (l->any_straight && motion_moves(e) & MOVES_WALLS) walls_pose(e);
  for (uint32_t i = 0; i < l->n_bodies; i++)
    if (neighbours_moved(e, i)) {
      sd_status status = neighbours_check_finite(e, s->step, e->work.messages);
      return status == SD_OK ? neighbours_build(e, e->work.messages) : status;
    }
  return SD_OK;
}

static void store_memory(const lanes *l, size_t lane) {
  engine *e = l->system[lane];
  pairs *p = &e->work.pairs;
  pairs_clear_sums(e);
  for (size_t k = 0; k < l->n_pairs; k++) {
    size_t n = index_in(e, l, k);
    const double slip = *cell(l, l->pair[k], PAIR_SLIP, lane);
    const bool closed = *cell(l, l->pair[k], PAIR_CLOSED, lane) > 0.0;
    assert(n != SIZE_MAX || !closed);
    if (n == SIZE_MAX) continue; /* not in the neighbour list, so the bodies cannot touch */
    for (size_t r = 0; r < SD_CONTACT_COLUMNS; r++)
      PAIR(p, n, record[r]) = *cell(l, l->pair[k], r, lane);
    for (size_t r = 0; p->more && r < SD_CONTACT_EXTRA; r++)
      MORE(p, n, record[r]) = *cell(l, l->pair[k], SD_CONTACT_COLUMNS + r, lane);
    pairs_set_flags(p, n, closed, (slip < 0.0) - (slip > 0.0));
    const double push[] = {*cell(l, l->pair[k], PAIR_FX, lane),
                           *cell(l, l->pair[k], PAIR_FY, lane)};
    double tau = *cell(l, l->pair[k], PAIR_TAU, lane);
    double *on_a = e->work.sums.row + PAIR(p, n, sum_a),
           *on_b = e->work.sums.row + PAIR(p, n, sum_b);
    on_a[SUM_X] -= push[0], on_b[SUM_X] += push[0];
    on_a[SUM_Y] -= push[1], on_b[SUM_Y] += push[1];
    on_a[SUM_TORQUE] += tau;
    on_b[SUM_TORQUE] += l->straight[k] ? *cell(l, l->of_straight[k], STRAIGHT_TURN, lane) : tau;
    if (l->straight[k]) p->side[n] = *cell(l, l->of_straight[k], STRAIGHT_SIDE, lane);
    if (!(l->features & LAW_ROLLING)) continue;
    const double couple = *cell(l, l->pair[k], PAIR_COUPLE, lane);
    on_a[SUM_COUPLE] += couple;
    if (l->b[k] < l->n_disks)
      on_b[SUM_COUPLE] -= couple;
    else
      on_b[SUM_TORQUE] -= couple / e->state->radius[l->b[k]];
  }
}

static void store_counts(lanes *l, size_t lane) {
  sd_state *s = l->system[lane]->state;
  for (size_t k = 0; k < l->n_slides; k++)
    for (size_t c = 0; c < 16; c++) {
      s->slide_count[16 * k + c] += l->count_of[k][c][lane];
      l->count_of[k][c][lane] = 0;
    }
  for (size_t k = 0; k < 2 * l->n_slides; k++) s->slide_force_min[k] = *cell(l, l->least, k, lane);
  for (size_t w = 0; w < s->n_visits; w++) store_visits(l, lane, w);
  s->work_driven = *cell(l, l->work, 0, lane);
}

static sd_status store_lane(lanes *l, size_t lane) {
  engine *e = l->system[lane];
  sd_status status = store_poses(l, lane);
  if (status != SD_OK) return status;
  store_memory(l, lane);
  store_counts(l, lane);
  e->work.kernels->gather(e, 0, l->n_bodies);
  size_t n;
  for (prescribed *p = motion_prescribed(e, &n), *end = p + n; p < end; p++) p->last = *p->at;
  return SD_OK;
}

static bool is_dead(const lanes *l, size_t lane) { return l->dead >> lane & 1u; }

static void die(lanes *l, size_t lane, sd_status status) {
  assert(status != SD_OK && lane < l->count && !is_dead(l, lane));
  l->system[lane]->work.status = status;
  l->dead |= 1u << lane;
  l->dead_now = true;
}

void lanes_store(lanes *l) {
  if (!l->stepped) return;
  for (size_t lane = 0; lane < l->count; lane++) {
    if (is_dead(l, lane)) continue;
    sd_status status = store_lane(l, lane);
    if (status != SD_OK)
      die(l, lane, status);
    else if (validity_due(l->system[lane]->state->step))
      validity_check_step(l->system[lane]);
  }
  if (l->motion) pose_batch_store(l->motion);
}

void lanes_show_angles(const lanes *l) {
  for (size_t lane = 0; lane < l->count; lane++) {
    sd_state *s = l->system[lane]->state;
    if (is_dead(l, lane)) continue;
    for (size_t i = 0; i < l->n_free; i++)
      s->theta[i] = *cell(l, l->disk[i], SD_THETA * DISK_COLUMNS, lane);
    const double *p = l->place;
    for (size_t i = l->n_free; i < l->n_bodies; i++)
      for (int c = 0; c < SD_COORDINATES; c++) {
        if (!l->placed[i][c]) continue;
        if (c == SD_THETA) s->theta[i] = p[lane];
        p += PLACE_ROWS * l->width;
      }
  }
}

int64_t lanes_take(lanes *l, int64_t n, bool measure) {
  assert(n > 0);
  l->measure = measure;
  l->stepped = true;
  l->dead_now = false;
  for (size_t lane = 0; lane < l->count; lane++) l->from[lane] = l->system[lane]->state->step;
  l->system[0]->work.kernels->lanes(l, n);
  assert(l->done >= 1 && l->done <= n && (l->done == n || l->dead_now));
  keep_poses(l);
  for (size_t lane = 0; lane < l->count; lane++) {
    if (is_dead(l, lane)) continue;
    sd_state *s = l->system[lane]->state;
    s->step += l->done;
    if (measure) s->measured += l->done;
  }
  return l->done;
}

/* --- rare events ------------------------------------------------------------------------------ */

static void count_openings(const lanes *l, size_t lane) {
  sd_state *s = l->system[lane]->state;
  for (size_t k = 0; k < 2 * l->n_slides; k++) {
    int open = *cell(l, l->pair[l->watched[k]], PAIR_CLOSED, lane) == 0.0;
    if (open == s->slide_was_open[k]) continue;
    s->slide_openings[k] += open;
    s->slide_was_open[k] = open;
  }
}

static void list_events(const lanes *l, size_t lane) {
  engine *e = l->system[lane];
  thread_work *mine = &e->work.threads[0];
  for (size_t k = 0; k < l->n_pairs; k++) {
    if (!(l->rare[k] >> lane & 1u)) continue;
    size_t n = index_in(e, l, k);
    double *p = l->pair[k];
    if (n == SIZE_MAX) continue;
    event *v = event_add(&mine->events, (uint32_t)n);
    if (!v) return; /* no memory; event_add has set events.failed */
    v->was_closed = *cell(l, p, PAIR_WAS_CLOSED, lane) > 0.0;
    v->dropped = *cell(l, p, PAIR_DROPPED, lane);
  }
  for (size_t i = 0; i < l->n_free; i++)
    if (l->returns[i] >> lane & 1u) event_add(&mine->returns, (uint32_t)i);
  mine->fast = l->fast >> lane & 1u;
}

static void treat_lane(lanes *l, size_t lane) {
  engine *e = l->system[lane];
  sd_state *s = e->state;
  s->step = l->from[lane] + l->done;
  sd_status status = store_lane(l, lane);
  if (status == SD_OK) {
    list_events(l, lane);
    s->step--; /* error messages of contacts_events name the step after s->step */
    status = contacts_events(e, e->work.messages);
    s->step++;
  }
  if (status != SD_OK) {
    if (l->measure) s->measured += l->done - 1;
    die(l, lane, status);
    return;
  }
  s->step = l->from[lane];
  load_memory(l, lane);
  if (l->measure) count_openings(l, lane);
}

void lanes_events(lanes *l) {
  keep_poses(l);
  unsigned lanes_with = l->fast;
  for (size_t k = 0; k < l->n_pairs; k++) lanes_with |= l->rare[k];
  for (size_t i = 0; i < l->n_free; i++) lanes_with |= l->returns[i];
  for (size_t lane = 0; lane < l->count; lane++)
    if ((lanes_with >> lane & 1u) && !is_dead(l, lane)) treat_lane(l, lane);
  for (size_t lane = l->count; lane < l->width; lane++)
    if (lanes_with & 1u) load_memory(l, lane);
  memset(l->returns, 0, sizeof l->returns);
  l->fast = 0;
}

/* Updates only lanes below `count`: the lanes above repeat system 0, whose state must be updated
 * only once. */
void lanes_visits(lanes *l, size_t w, unsigned bits) {
  double *rows = visit_rows(l, w);
  for (; bits; bits &= bits - 1) {
    const size_t lane = (size_t)__builtin_ctz(bits);
    sd_state *s = l->system[lane]->state;
    const int64_t before = s->measured + l->done - 1;
    if (lane < l->count && !is_dead(l, lane))
      visits_next(s, w, (int)*cell(l, rows, VISIT_ROW_CLASS, lane), rows + lane, l->width, before);
    *cell(l, rows, VISIT_ROW_LEFT, lane) = visits_left(s, w, before);
  }
}

/* The functions below tell which systems can run in SIMD lanes, and which of these can share a
 * vector; see lanes.h. */

/* --- which systems suit lanes ----------------------------------------------------------------- */

static size_t count_pairs(const sd_model *m) {
  size_t bodies = m->n_disks + m->n_walls;
  return m->n_free * (bodies - m->n_free) + m->n_free * (m->n_free - 1) / 2;
}

/* Returns true if all walls are circles or straight, with all circles before all straight walls,
 * the order of contacts in the neighbour list. */
static bool suits_walls(const sd_model *m) {
  bool suits = true;
  for (size_t w = 0; w < m->n_walls; w++) {
    const sd_wall *wall = &m->walls[w];
    suits = suits && (wall_is_straight(wall) || wall->kind == SD_WALL_CIRCLE);
    if (w > 0) suits = suits && !(wall_is_straight(wall - 1) && wall->kind == SD_WALL_CIRCLE);
  }
  return suits;
}

/* Returns true if two walls meet at a joint. Such systems cannot run in lanes, since only
 * segment_pass.h handles joints. */
static bool walls_meet(const sd_model *m) {
  for (size_t k = 0; k < m->n_segments; k++)
    if (m->segments[k].meets[0] || m->segments[k].meets[1]) return true;
  return false;
}

static bool suits_motion(const sd_model *m, const sd_motion *motion) {
  if (motion_is_feedback(motion)) return false;
  for (size_t b = 0; b < motion->n_bodies; b++) {
    const uint32_t body = motion->bodies[b];
    if (body < m->n_disks
            ? !m->disks[body].driven
            : motion->coordinate == SD_THETA && wall_is_straight(&m->walls[body - m->n_disks]))
      return false;
  }
  return true;
}

/* Returns true if the watched disk is free, and neither of its two watched partners is the disk
 * itself. */
static bool suits_watch(const sd_model *m, const sd_slide_watch *w) {
  return !m->disks[w->disk].driven && w->partner[0] != w->disk && w->partner[1] != w->disk;
}

bool lanes_suit(const sd_model *m) {
  if (m->n_free < 1 || m->n_free > LANES_FREE || m->n_disks + m->n_walls > LANES_BODIES ||
      count_pairs(m) < 1 || count_pairs(m) > LANES_PAIRS || m->n_slides > LANES_SLIDES ||
      !suits_walls(m) || m->periodic[0] || m->periodic[1] || m->measure_disks || m->n_rains > 0 ||
      m->n_fields > 0 || m->n_clumps > 0 || model_moves_surfaces(m) || walls_meet(m) ||
      strides_are_long(m) || laws_features(m) & LAW_BOND ||
      (m->n_segments > 0 && laws_features(m) & LAW_GENERAL) ||
      (m->bounds.given && m->bounds.outside == SD_OUTSIDE_REMOVE))
    return false;
  bool suits = true;
  for (size_t k = 0; k < m->n_disks; k++) suits = suits && !disk_holds(&m->disks[k]);
  for (size_t k = 0; k < m->n_phases; k++)
    suits = suits && !m->phases[k].relax && !m->phases[k].compress.asked;
  for (size_t k = 0; k < m->n_motions; k++) suits = suits && suits_motion(m, &m->motions[k]);
  for (size_t k = 0; k < m->n_slides; k++) suits = suits && suits_watch(m, &m->slides[k]);
  return suits;
}

/* Compares n bytes; with n = 0 returns true, whatever the pointers are. */
static bool same_bytes(const void *a, const void *b, size_t n) {
  return n == 0 || memcmp(a, b, n) == 0;
}

static bool same_motion(const sd_motion *a, const sd_motion *b) {
  return a->kind == b->kind && a->coordinate == b->coordinate && a->n_bodies == b->n_bodies &&
         a->interval == b->interval &&
         same_bytes(a->bodies, b->bodies, a->n_bodies * sizeof *a->bodies);
}

static bool same_phase(const sd_phase *a, const sd_phase *b, size_t n_motions) {
  return a->steps == b->steps && a->measure == b->measure && a->series_every == b->series_every &&
         a->frames_every == b->frames_every && a->contacts_every == b->contacts_every &&
         a->settle.asked == b->settle.asked && a->settle.every == b->settle.every &&
         same_bytes(a->active, b->active, n_motions * sizeof *a->active);
}

bool lanes_alike(const sd_model *a, const sd_model *b) {
  if (a->n_disks != b->n_disks || a->n_walls != b->n_walls || a->n_motions != b->n_motions ||
      a->n_phases != b->n_phases || a->n_rotations != b->n_rotations ||
      a->n_slides != b->n_slides || a->measure_configurations != b->measure_configurations ||
      a->integrator != b->integrator || a->variant != b->variant || !lanes_suit(a) ||
      !lanes_suit(b))
    return false;
  const unsigned features = laws_features(a), other = laws_features(b);
  if (features != other && (features | other) & LAW_GENERAL) return false;
  bool same = same_bytes(a->rotations, b->rotations, a->n_rotations * sizeof *a->rotations) &&
              same_bytes(a->slides, b->slides, a->n_slides * sizeof *a->slides);
  for (size_t k = 0; k < a->n_disks; k++) same = same && a->disks[k].driven == b->disks[k].driven;
  for (size_t k = 0; k < a->n_walls; k++)
    same = same && wall_is_straight(&a->walls[k]) == wall_is_straight(&b->walls[k]);
  for (size_t k = 0; k < a->n_motions; k++)
    same = same && same_motion(&a->motions[k], &b->motions[k]);
  for (size_t k = 0; k < a->n_phases; k++)
    same = same && same_phase(&a->phases[k], &b->phases[k], a->n_motions);
  return same;
}

bool lanes_in_step(const engine *a, const engine *b) {
  const sd_state *s = a->state, *t = b->state;
  bool same = s->phase == t->phase;
  for (size_t k = 0; k < s->n_motions; k++)
    same = same && (s->motion_start[k] < 0
                        ? t->motion_start[k] < 0
                        : t->motion_start[k] >= 0 &&
                              s->step - s->motion_start[k] == t->step - t->motion_start[k]);
  return same;
}

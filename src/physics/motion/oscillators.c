/* oscillators.c: see oscillators.h. */
#include "physics/motion/oscillators.h"

#include <assert.h>
#include <string.h>

#include "base/memory.h"

oscillators *oscillators_new(size_t n) { return memory_lines(n * sizeof(oscillators)); }

void oscillators_set(oscillators *g, size_t lane, const random_step *step, uint64_t seed, uint32_t stream) {
  assert(lane < OSCILLATORS);
  g->uu[lane] = step->propagator[0][0];
  g->uv[lane] = step->propagator[0][1];
  g->vu[lane] = step->propagator[1][0];
  g->vv[lane] = step->propagator[1][1];
  g->noise_u[lane] = step->cholesky[0];
  g->noise_vu[lane] = step->cholesky[1];
  g->noise_vv[lane] = step->cholesky[2];
  g->seed[lane] = seed;
  g->stream[lane] = stream;
  g->start[lane] = -1;
}

void oscillators_load(oscillators *g, size_t lane, const sd_state *s, size_t k, int64_t interval) {
  assert(lane < OSCILLATORS && interval >= 1 && s->motion_start[k] >= 0 && s->motion_start[k] <= s->step);
  int64_t number = (s->step - s->motion_start[k]) / interval;
  size_t odd = (size_t)(number & 1);
  g->start[lane] = s->motion_start[k];
  g->base[lane] = number - (int64_t)odd;
  g->known[lane] = g->base[lane] + 1;
  g->u[odd][lane] = s->motion_u0[k];
  g->v[odd][lane] = s->motion_v0[k];
  if (odd) return;
  g->u[1][lane] = s->motion_u1[k];
  g->v[1][lane] = s->motion_v1[k];
}

void oscillators_store(const oscillators *g, size_t lane, sd_state *s, size_t k, int64_t interval) {
  size_t row = (size_t)((s->step - s->motion_start[k]) / interval - g->base[lane]);
  assert(row + 1 < OSCILLATOR_ROWS && (int64_t)row < g->known[lane] - g->base[lane]);
  s->motion_u0[k] = g->u[row][lane];
  s->motion_v0[k] = g->v[row][lane];
  s->motion_u1[k] = g->u[row + 1][lane];
  s->motion_v1[k] = g->v[row + 1][lane];
}

void oscillators_rest(oscillators *g, size_t lane) { g->start[lane] = -1; }

/* Rows of each lane, so many, to where the number base[lane] comes first. */
static void move_up(oscillators *g, const int64_t *base, size_t rows) {
  bool alike = true;
  for (size_t l = 0; l < g->count; l++)
    alike = alike && g->start[l] >= 0 && base[l] - g->base[l] == base[0] - g->base[0];
  size_t up = (size_t)(base[0] - g->base[0]);
  if (alike && up > 0) {
    memmove(g->u[0], g->u[up], rows * sizeof g->u[0]);
    memmove(g->v[0], g->v[up], rows * sizeof g->v[0]);
  }
  for (size_t l = 0; !alike && l < g->count; l++) {
    if (g->start[l] < 0 || base[l] == g->base[l]) continue;
    up = (size_t)(base[l] - g->base[l]);
    for (size_t r = 0; r < rows; r++) {
      g->u[r][l] = g->u[r + up][l];
      g->v[r][l] = g->v[r + up][l];
    }
  }
}

size_t oscillators_ahead(const motion_kernels *k, oscillators *g, const int64_t *first, int64_t n,
                         int64_t interval) {
  int64_t base[OSCILLATORS] = {0}, kept = INT64_MAX, needed = 0;
  int64_t local = -1, low = 0, high = 0;
  for (size_t l = 0; l < g->count; l++) {
    if (g->start[l] < 0) continue;
    if (first[l] - g->start[l] != local) { /* seldom after the first lane: divisions are slow */
      local = first[l] - g->start[l];
      low = (local - 1) / interval;
      high = (local + n - 1) / interval + 1;
    }
    base[l] = (low > g->base[l] ? low : g->base[l]) & ~(int64_t)1;
    /* the last row that all lanes know, of an odd number */
    if (g->known[l] - base[l] < kept) kept = g->known[l] - base[l];
    if (high - base[l] > needed) needed = high - base[l];
  }
  if (kept == INT64_MAX) return 0;
  assert(kept >= 0);
  size_t rows = (size_t)kept + 1, blocks = needed > kept ? (size_t)(needed - kept + 1) / 2 : 0;
  /* the kernel does four blocks in the time of three */
  size_t more = (blocks + 3) / 4 * 4;
  if (rows + 2 * more <= OSCILLATOR_ROWS) blocks = more;
  assert(rows + 2 * blocks <= OSCILLATOR_ROWS);
  move_up(g, base, rows);
  for (size_t l = 0; l < g->count; l++) {
    if (g->start[l] < 0) continue;
    assert(base[l] >= g->base[l] && base[l] % 2 == 0);
    g->base[l] = base[l];
    g->known[l] = base[l] + kept + 2 * (int64_t)blocks;
    g->block[l] = (uint64_t)(g->start[l] + (base[l] + (int64_t)rows) / 2);
  }
  if (blocks) k->oscillate(g, rows, blocks);
  return rows + 2 * blocks;
}

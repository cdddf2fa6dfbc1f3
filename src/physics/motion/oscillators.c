/* oscillators.c: exact discrete steps of randomly forced oscillators; see signals.h. */
#include "physics/motion/signals.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/quadrature.h"

oscillators *oscillators_new(size_t n) { return memory_lines(n * sizeof(oscillators)); }

void oscillators_set(oscillators *g, size_t lane, const random_step *step, uint64_t seed,
                     uint32_t stream) {
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
  assert(lane < OSCILLATORS && interval >= 1 && s->motion_start[k] >= 0 &&
         s->motion_start[k] <= s->step);
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

/* Shifts `rows` rows of each lane to the beginning of the arrays: row 0 becomes random step number
 * base[lane]. */
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
    /* The difference is mostly the same in all lanes; slow divisions are then made only once. */
    if (first[l] - g->start[l] != local) {
      local = first[l] - g->start[l];
      low = (local - 1) / interval;
      high = (local + n - 1) / interval + 1;
    }
    base[l] = (low > g->base[l] ? low : g->base[l]) & ~(int64_t)1;
    /* kept: last row that is known in all lanes; it holds a random step of odd number */
    if (g->known[l] - base[l] < kept) kept = g->known[l] - base[l];
    if (high - base[l] > needed) needed = high - base[l];
  }
  if (kept == INT64_MAX) return 0;
  assert(kept >= 0);
  size_t rows = (size_t)kept + 1, blocks = needed > kept ? (size_t)(needed - kept + 1) / 2 : 0;
  /* The number of Philox blocks is rounded up to a multiple of four, since the kernel computes four
   * in the time of three. */
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

/* --- propagator and noise of the random vibration --------------------------------------------- */

/* Computes the motion of the oscillator after a unit change of velocity at t = 0: displacement *g =
 * u(t), and its derivative *dg. */
static void kick(double omega, double c, double t, double *g, double *dg) {
  double w2 = omega * omega * (1.0 - c * c), w = sqrt(fabs(w2)), x = w * t, ratio, cosine;
  double decay = math_exp(-c * omega * t);
  /* power series of sin(x)/w or sinh(x)/w, which also holds for critical damping, w = 0 */
  if (x < 1e-4) {
    double sign = w2 > 0.0 ? -1.0 : 1.0;
    ratio = decay * t * (1.0 + sign * x * x / 6.0);
    cosine = decay * (1.0 + sign * x * x / 2.0);
  } else if (w2 > 0.0) {
    math_sine_cosine(x, &ratio, &cosine);
    ratio = decay * ratio / w;
    cosine *= decay;
  } else { /* over-damped: the exponentials contain the decay, so neither of them overflows */
    double slow = math_exp((w - c * omega) * t), fast = math_exp(-(w + c * omega) * t);
    ratio = 0.5 * (slow - fast) / w;
    cosine = 0.5 * (slow + fast);
  }
  *g = ratio;
  *dg = cosine - c * omega * ratio;
}

random_step random_step_new(double omega, double c, double rms, double h) {
  random_step step;
  double g, dg;
  kick(omega, c, h, &g, &dg);
  /* u(t) for u(0) = 1, u'(0) = 0 is dg + 2 c w g; velocities follow from u'' = -2 c w u' - w^2 u */
  step.propagator[0][0] = dg + 2.0 * c * omega * g;
  step.propagator[0][1] = g;
  step.propagator[1][0] = -omega * omega * g;
  step.propagator[1][1] = dg;

  /* The covariance 4 c w^3 rms^2 int_0^h (g, g')(g, g')^T dt is integrated in panels that are
   * shorter than every time scale of the oscillator. */
  double fastest = omega * (c + sqrt(fabs(1.0 - c * c)) + 1.0), uu = 0.0, vu = 0.0, vv = 0.0;
  double span = math_min(
      /* At the end of `span` g has decayed to e^-50. */
      h, 50.0 / (omega * (c > 1.0 ? c - sqrt(c * c - 1.0) : c)));
  int panels = 1 + (int)math_min(ceil(span * fastest / 2.0), 1e6);
  for (int k = 0; k < panels; k++)
    for (int p = 0; p < QUADRATURE_POINTS; p++) {
      double t, weight;
      quadrature_point(span * k / panels, span * (k + 1) / panels, p, &t, &weight);
      kick(omega, c, t, &g, &dg);
      uu += weight * g * g;
      vu += weight * g * dg;
      vv += weight * dg * dg;
    }
  double strength = 4.0 * c * omega * omega * omega * rms * rms;
  step.cholesky[0] = sqrt(strength * uu);
  step.cholesky[1] = uu > 0.0 ? sqrt(strength) * vu / sqrt(uu) : 0.0;
  step.cholesky[2] = uu > 0.0 ? sqrt(strength * math_max(vv - vu * vu / uu, 0.0)) : 0.0;
  return step;
}

/* kernel_random.c: counter-based normal numbers, and sines, over lanes; compiled once per instruction set.
 *
 * Philox4x32-10 (Salmon, Moraes, Dror & Shaw, SC'11), written over lanes because the six streams of the
 * 3-disk deck would else cost more than the mechanics; tests compare it with Random123's. One block gives
 * two uniform numbers of 52 bits, and Box-Muller two normal ones. The same number for every width.
 */
#include "physics/kernel_path.h"
#include "physics/kernels.h"

#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "base/vmath.h"

/* Words are the low halves of 64-bit lanes; what stands above them is not cleared on the way, because the
 * multiplication does not see it. */
LANE_INLINE void philox(LANE(bits) word[4], uint64_t key) {
  uint32_t k0 = (uint32_t)key, k1 = (uint32_t)(key >> 32);
  const LANE(bits) m0 = LANE(splat_bits)(0xD2511F53u), m1 = LANE(splat_bits)(0xCD9E8D57u);
  for (int round = 0; round < 10; round++) {
    LANE(bits) p0 = LANE(multiply32)(m0, word[0]), p1 = LANE(multiply32)(m1, word[2]);
    word[0] = (p1 >> 32) ^ word[1] ^ k0;
    word[1] = p1;
    word[2] = (p0 >> 32) ^ word[3] ^ k1;
    word[3] = p0;
    k0 += 0x9E3779B9u;
    k1 += 0xBB67AE85u;
  }
}

/* 64 bits -> uniform in (0, 1): 52 bits and half a unit. */
LANE_INLINE LANE(real) uniform(LANE(bits) high, LANE(bits) low) {
  LANE(bits) b = (high << 32) | (low & 0xffffffffu);
  return LANE(as_real)((b >> 12) | 0x3ff0000000000000u) - (1.0 - 0x1p-53);
}

void KERNEL(kernel_normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first, size_t n,
                            double *a, double *b);
void KERNEL(kernel_sine_cosine)(const double *t, size_t n, double *sine, double *cosine);
void KERNEL(kernel_oscillate)(oscillators *g, size_t n);

void KERNEL(kernel_normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first, size_t n,
                            double *a, double *b) {
  LANE(bits) lane = LANE(splat_bits)(0);
  for (int l = 0; l < LANE_WIDTH; l++) lane[l] = (uint64_t)l;
  for (size_t k = 0; k < n; k += LANE_WIDTH) {
    LANE(bits) index = LANE(splat_bits)((uint64_t)first + k) + lane;
    LANE(bits) word[4] = {index & 0xffffffffu, index >> 32, LANE(splat_bits)(stream), LANE(splat_bits)(purpose)};
    philox(word, seed);
    LANE(real) u = uniform(word[1], word[0]), v = uniform(word[3], word[2]), s, c;
    LANE(real) r = LANE(root)(-2.0 * LANE(logarithm)(u));
    LANE(sine_cosine)(v, &s, &c);
    LANE(store)(a + k, r * c);
    LANE(store)(b + k, r * s);
  }
}

LANE_INLINE LANE(real) column(double (*row)[OSCILLATOR_DRAWS], size_t k) {
  LANE(real) a;
  for (int l = 0; l < LANE_WIDTH; l++) a[l] = row[l][k];
  return a;
}

LANE_INLINE void set_column(double (*row)[OSCILLATOR_DRAWS], size_t k, LANE(real) a) {
  for (int l = 0; l < LANE_WIDTH; l++) row[l][k] = a[l];
}

void KERNEL(kernel_oscillate)(oscillators *g, size_t n) {
  for (size_t l = 0; l < g->count; l += LANE_WIDTH) {
    LANE(real) uu = LANE(load)(g->uu + l), uv = LANE(load)(g->uv + l), vu = LANE(load)(g->vu + l);
    LANE(real) vv = LANE(load)(g->vv + l), nu = LANE(load)(g->noise_u + l), nvu = LANE(load)(g->noise_vu + l);
    LANE(real) nvv = LANE(load)(g->noise_vv + l), u = column(g->u + l, 1), v = column(g->v + l, 1);
    for (size_t k = 0; k < n; k++) {
      LANE(real) a = column(g->normal1 + l, k), b = column(g->normal2 + l, k);
      LANE(real) next = uu * u + (uv * v + nu * a);
      v = vv * v + (vu * u + (nvu * a + nvv * b));
      u = next;
      set_column(g->u + l, k + 2, u);
      set_column(g->v + l, k + 2, v);
    }
  }
}

void KERNEL(kernel_sine_cosine)(const double *t, size_t n, double *sine, double *cosine) {
  for (size_t k = 0; k < n; k += LANE_WIDTH) {
    LANE(real) s, c;
    LANE(sine_cosine)(LANE(load)(t + k), &s, &c);
    LANE(store)(sine + k, s);
    LANE(store)(cosine + k, c);
  }
}

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

/* So many blocks at a time: their chains of dependent operations overlap. */
enum { BLOCKS = 8 / LANE_WIDTH > 2 ? 8 / LANE_WIDTH : 2 };

/* Words are the low halves of 64-bit lanes; what stands above them is not cleared on the way, because the
 * multiplication does not see it. */
LANE_INLINE void philox(LANE(bits) word[BLOCKS][4], uint64_t key) {
  uint32_t k0 = (uint32_t)key, k1 = (uint32_t)(key >> 32);
  const LANE(bits) m0 = LANE(splat_bits)(0xD2511F53u), m1 = LANE(splat_bits)(0xCD9E8D57u);
  for (int round = 0; round < 10; round++) {
    for (int n = 0; n < BLOCKS; n++) {
      LANE(bits) p0 = LANE(multiply32)(m0, word[n][0]), p1 = LANE(multiply32)(m1, word[n][2]);
      word[n][0] = (p1 >> 32) ^ word[n][1] ^ k0;
      word[n][1] = p1;
      word[n][2] = (p0 >> 32) ^ word[n][3] ^ k1;
      word[n][3] = p0;
    }
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
  for (size_t k = 0; k < n; k += BLOCKS * LANE_WIDTH) {
    LANE(bits) word[BLOCKS][4];
    for (size_t m = 0; m < BLOCKS; m++) {
      LANE(bits) index = LANE(splat_bits)((uint64_t)first + k + m * LANE_WIDTH) + lane;
      word[m][0] = index & 0xffffffffu;
      word[m][1] = index >> 32;
      word[m][2] = LANE(splat_bits)(stream);
      word[m][3] = LANE(splat_bits)(purpose);
    }
    philox(word, seed);
    LANE(real) r[BLOCKS], s[BLOCKS], c[BLOCKS];
    for (size_t m = 0; m < BLOCKS; m++)
      r[m] = LANE(root)(-2.0 * LANE(logarithm)(uniform(word[m][1], word[m][0])));
    for (size_t m = 0; m < BLOCKS; m++) LANE(sine_cosine)(uniform(word[m][3], word[m][2]), &s[m], &c[m]);
    for (size_t m = 0; m < BLOCKS; m++) {
      LANE(store)(a + k + m * LANE_WIDTH, r[m] * c[m]);
      LANE(store)(b + k + m * LANE_WIDTH, r[m] * s[m]);
    }
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

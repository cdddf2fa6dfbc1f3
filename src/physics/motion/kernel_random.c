/* kernel_random.c: normal numbers and randomly forced oscillators in vector lanes; compiled once
 * per instruction set.
 *
 * Philox is vectorised because otherwise the six streams of the 3-disk deck would cost more than
 * the mechanics; tests compare it with the implementation in Random123.
 */
#include "physics/motion/motion_kernels.h"
#include "physics/system/kernel_path.h"

#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "base/vmath.h"
#include "physics/motion/draws.h"

void KERNEL(kernel_normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first,
                            size_t n, double *a, double *b);
void KERNEL(kernel_sine_cosine)(const double *t, size_t n, double *sine, double *cosine);
void KERNEL(kernel_oscillate)(oscillators *g, size_t row, size_t blocks);
void KERNEL(kernel_spread)(const oscillators *g, size_t n, double (*u)[OSCILLATOR_ROWS],
                           double (*v)[OSCILLATOR_ROWS]);

LANE_INLINE LANE(bits) load_bits(const uint64_t *p) {
  LANE(bits) a;
  memcpy(&a, p, sizeof a);
  return a;
}

/* Copies those random numbers to `to` whose index lies in [first, first + n). from[l] has the index
 * `index` + 2 l. */
static void copy_draws(const double *from, uint64_t index, uint64_t first, size_t n, double *to) {
  for (uint64_t l = 0; l < LANE_WIDTH; l++)
    if (index + 2 * l >= first && index + 2 * l < first + n) to[index + 2 * l - first] = from[l];
}

/* Computes n pairs of normal numbers; each lane computes one of LANE_WIDTH consecutive Philox
 * blocks. */
void KERNEL(kernel_normals)(uint64_t seed, uint32_t stream, uint32_t purpose, int64_t first,
                            size_t n, double *a, double *b) {
  LANE(draw_keys) keys;
  LANE(draw_keys_from)(&keys, LANE(splat_bits)(seed));
  LANE(bits) lane = LANE(splat_bits)(0);
  for (int l = 0; l < LANE_WIDTH; l++) lane[l] = (uint64_t)l;
  for (uint64_t from = (uint64_t)first / 2; 2 * from < (uint64_t)first + n; from += LANE_WIDTH) {
    LANE(bits) block = LANE(splat_bits)(from) + lane, word[DRAW_BLOCKS][4];
    LANE(real) x[2 * DRAW_BLOCKS], y[2 * DRAW_BLOCKS];
    word[0][0] = block & 0xffffffffu;
    word[0][1] = block >> 32;
    word[0][2] = LANE(splat_bits)(stream);
    word[0][3] = LANE(splat_bits)(purpose);
    LANE(draw_normals)(word, 1, &keys, x, y);
    for (uint64_t half = 0; half < 2; half++) {
      double row[LANE_WIDTH];
      LANE(store)(row, x[half]);
      copy_draws(row, 2 * from + half, (uint64_t)first, n, a);
      LANE(store)(row, y[half]);
      copy_draws(row, 2 * from + half, (uint64_t)first, n, b);
    }
  }
}

/* State and constants of LANE_WIDTH oscillators, kept in registers from one random step to the
 * next. */
typedef struct swing {
  LANE(draw_keys) keys;
  /* block: next block number of the random stream; high: high word of the block number, constant in
   * one call */
  LANE(bits) block, high, stream;
  /* copies of the members of struct oscillators with the same names */
  LANE(real) u, v, uu, uv, vu, vv, noise_u, noise_vu, noise_vv;
  LANE(real) a[2 * DRAW_BLOCKS], b[2 * DRAW_BLOCKS]; /* normal numbers that are not used yet */
} swing;

/* Advances the oscillators by one random step with the normal numbers a[k] and b[k], and stores
 * displacement and velocity in row + k. */

LANE_INLINE void swing_on(swing *s, oscillators *g, size_t l, size_t row, int k) {
  LANE(real) a = s->a[k], b = s->b[k], next = s->uu * s->u + (s->uv * s->v + s->noise_u * a);
  s->v = s->vv * s->v + (s->vu * s->u + (s->noise_vu * a + s->noise_vv * b));
  s->u = next;
  LANE(store)(g->u[row + (size_t)k] + l, s->u);
  LANE(store)(g->v[row + (size_t)k] + l, s->v);
}

/* Computes the normal numbers of the next `blocks` Philox blocks. Between the rounds of Philox the
 * oscillators are advanced with the 2 * waiting pairs of normal numbers computed before, and stored
 * in rows from `row` on. The two are interleaved because the oscillators are a chain of dependent
 * operations, which leaves execution units idle. */
LANE_INLINE void draw_beside(swing *s, oscillators *g, size_t l, size_t row, int waiting,
                             int blocks) {
  LANE(bits) word[DRAW_BLOCKS][4];
  EACH_BLOCK {
    word[n][0] = s->block + (uint64_t)n;
    word[n][1] = s->high;
    word[n][2] = s->stream;
    word[n][3] = LANE(splat_bits)(RANDOM_STEP);
  }
  s->block = s->block + (uint64_t)blocks;
#pragma GCC unroll 10
  for (int round = 0; round < DRAW_ROUNDS; round++) {
    LANE(philox_round)(word, blocks, &s->keys, round);
    if (round < 2 * waiting) swing_on(s, g, l, row, round);
  }
  LANE(draw_pairs)(word, blocks, s->a, s->b);
}

/* Advances the oscillators with the 2 * waiting pairs of normal numbers that are not used yet. */
LANE_INLINE void swing_rest(swing *s, oscillators *g, size_t l, size_t row, int waiting) {
  for (int k = 0; k < 2 * waiting; k++) swing_on(s, g, l, row, k);
}

/* Advances one vector of oscillators by 2 * blocks random steps; each block of random words is
 * enough for two. */
static void oscillate(swing *s, oscillators *g, size_t l, size_t row, size_t blocks) {
  if (blocks >= DRAW_BLOCKS) {
    draw_beside(s, g, l, row, 0, DRAW_BLOCKS);
    for (blocks -= DRAW_BLOCKS; blocks >= DRAW_BLOCKS;
         blocks -= DRAW_BLOCKS, row += 2 * DRAW_BLOCKS)
      draw_beside(s, g, l, row, DRAW_BLOCKS, DRAW_BLOCKS);
    swing_rest(s, g, l, row, DRAW_BLOCKS);
    row += 2 * DRAW_BLOCKS;
  }
  for (; blocks >= 2; blocks -= 2, row += 4) {
    draw_beside(s, g, l, row, 0, 2);
    swing_rest(s, g, l, row, 2);
  }
  if (blocks == 0) return;
  draw_beside(s, g, l, row, 0, 1);
  swing_rest(s, g, l, row, 1);
}

void KERNEL(kernel_oscillate)(oscillators *g, size_t row, size_t blocks) {
  for (size_t l = 0; l < g->count; l += LANE_WIDTH) {
    swing s = {.block = load_bits(g->block + l),
               .stream = load_bits(g->stream + l),
               .u = LANE(load)(g->u[row - 1] + l),
               .v = LANE(load)(g->v[row - 1] + l),
               .uu = LANE(load)(g->uu + l),
               .uv = LANE(load)(g->uv + l),
               .vu = LANE(load)(g->vu + l),
               .vv = LANE(load)(g->vv + l),
               .noise_u = LANE(load)(g->noise_u + l),
               .noise_vu = LANE(load)(g->noise_vu + l),
               .noise_vv = LANE(load)(g->noise_vv + l)};
    LANE(draw_keys_from)(&s.keys, load_bits(g->seed + l));
    /* Compute one block at a time if the high word of the block number changes within the `blocks`
     * blocks. */
    size_t at_once = blocks;
    for (size_t k = l; k < l + LANE_WIDTH; k++)
      if (g->block[k] >> 32 != (g->block[k] + blocks - 1) >> 32) at_once = 1;
    for (size_t n = 0; n < blocks; n += at_once) {
      s.high = s.block >> 32;
      oscillate(&s, g, l, row + 2 * n, at_once);
    }
  }
}

/* Transposes a square matrix of LANE_WIDTH vectors; each round exchanges one bit of the row index
 * with one bit of the lane index. */
LANE_INLINE void transpose(LANE(real) a[LANE_WIDTH]) {
#if LANE_WIDTH == 8 && defined(__AVX512F__)
  LANE(real) b[8];
  for (int k = 0; k < 8; k += 2) {
    b[k] = (LANE(real))_mm512_unpacklo_pd((__m512d)a[k], (__m512d)a[k + 1]);
    b[k + 1] = (LANE(real))_mm512_unpackhi_pd((__m512d)a[k], (__m512d)a[k + 1]);
  }
  for (int k = 0; k < 8; k += 4)
    for (int j = 0; j < 2; j++) {
      a[k + j] = (LANE(real))_mm512_shuffle_f64x2((__m512d)b[k + j], (__m512d)b[k + j + 2], 0x88);
      a[k + j + 2] =
          (LANE(real))_mm512_shuffle_f64x2((__m512d)b[k + j], (__m512d)b[k + j + 2], 0xdd);
    }
  for (int j = 0; j < 4; j++) {
    b[j] = (LANE(real))_mm512_shuffle_f64x2((__m512d)a[j], (__m512d)a[j + 4], 0x88);
    b[j + 4] = (LANE(real))_mm512_shuffle_f64x2((__m512d)a[j], (__m512d)a[j + 4], 0xdd);
  }
  memcpy(a, b, sizeof b);
#elif LANE_WIDTH == 4 && defined(__AVX2__)
  LANE(real) b[4];
  for (int k = 0; k < 4; k += 2) {
    b[k] = (LANE(real))_mm256_unpacklo_pd((__m256d)a[k], (__m256d)a[k + 1]);
    b[k + 1] = (LANE(real))_mm256_unpackhi_pd((__m256d)a[k], (__m256d)a[k + 1]);
  }
  for (int j = 0; j < 2; j++) {
    a[j] = (LANE(real))_mm256_permute2f128_pd((__m256d)b[j], (__m256d)b[j + 2], 0x20);
    a[j + 2] = (LANE(real))_mm256_permute2f128_pd((__m256d)b[j], (__m256d)b[j + 2], 0x31);
  }
#else
  for (int k = 0; k < LANE_WIDTH; k++)
    for (int j = 0; j < k; j++) {
      double t = a[k][j];
      a[k][j] = a[j][k];
      a[j][k] = t;
    }
#endif
}

/* Transposes the first n rows of lanes l ... l + LANE_WIDTH - 1, and stores them as
 * to[lane][row]. */
LANE_INLINE void spread(const double (*rows)[OSCILLATORS], size_t n, size_t l,
                        double (*to)[OSCILLATOR_ROWS]) {
  for (size_t r = 0; r < n; r += LANE_WIDTH) {
    LANE(real) a[LANE_WIDTH];
    for (size_t k = 0; k < LANE_WIDTH; k++) a[k] = LANE(load)(rows[r + k] + l);
    transpose(a);
    for (size_t k = 0; k < LANE_WIDTH; k++) LANE(store)(to[l + k] + r, a[k]);
  }
}

void KERNEL(kernel_spread)(const oscillators *g, size_t n, double (*u)[OSCILLATOR_ROWS],
                           double (*v)[OSCILLATOR_ROWS]) {
  for (size_t l = 0; l < g->count; l += LANE_WIDTH) {
    spread(g->u, n, l, u);
    spread(g->v, n, l, v);
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

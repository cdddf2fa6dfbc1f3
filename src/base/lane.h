/* lane.h: LANE_WIDTH doubles that are worked on together; included once per width.
 *
 * The same text (law, random draws) is compiled for width 1 and for the machine's vectors. Every operation
 * here is an IEEE basic operation or a selection, so a lane's result does not depend on the width.
 * Names carry the width: LANE(real) is real_w1 or real_w8.
 */
#ifndef LANE_WIDTH
#error "define LANE_WIDTH before including base/lane.h"
#endif

#ifndef LANE_COMMON
#define LANE_COMMON
#include <math.h>
#include <stdint.h>
#include <string.h>
#if defined(__SSE2__)
#include <immintrin.h>
#endif
#define LANE_PASTE2(name, width) name##_w##width
#define LANE_PASTE(name, width) LANE_PASTE2(name, width)
#define LANE(name) LANE_PASTE(name, LANE_WIDTH)
#define LANE_INLINE static inline __attribute__((always_inline, unused))
#endif

#if LANE_WIDTH == 1

typedef double real_w1;
typedef int64_t mask_w1;
typedef uint64_t bits_w1;

LANE_INLINE real_w1 splat_w1(double a) { return a; }
LANE_INLINE bits_w1 splat_bits_w1(uint64_t a) { return a; }
LANE_INLINE real_w1 load_w1(const double *p) { return *p; }
LANE_INLINE void store_w1(double *p, real_w1 a) { *p = a; }
LANE_INLINE real_w1 gather_w1(const double *p, const int32_t *index) { return p[*index]; }
LANE_INLINE real_w1 select_w1(mask_w1 m, real_w1 a, real_w1 b) { return m ? a : b; }
LANE_INLINE mask_w1 not_w1(mask_w1 m) { return !m; }
LANE_INLINE real_w1 least_w1(real_w1 a, real_w1 b) { return a < b ? a : b; }
LANE_INLINE real_w1 most_w1(real_w1 a, real_w1 b) { return a > b ? a : b; }
LANE_INLINE int any_w1(mask_w1 m) { return m != 0; }
LANE_INLINE int lane_is_w1(mask_w1 m, int k) { return (void)k, m != 0; }
LANE_INLINE real_w1 root_w1(real_w1 a) { return sqrt(a); }
LANE_INLINE bits_w1 as_bits_w1(real_w1 a) {
  bits_w1 b;
  memcpy(&b, &a, sizeof b);
  return b;
}
LANE_INLINE real_w1 as_real_w1(bits_w1 a) {
  real_w1 b;
  memcpy(&b, &a, sizeof b);
  return b;
}
LANE_INLINE bits_w1 multiply32_w1(bits_w1 a, bits_w1 b) { return (a & 0xffffffffu) * (b & 0xffffffffu); }

#else

typedef double LANE(real) __attribute__((vector_size(8 * LANE_WIDTH)));
typedef int64_t LANE(mask) __attribute__((vector_size(8 * LANE_WIDTH)));
typedef uint64_t LANE(bits) __attribute__((vector_size(8 * LANE_WIDTH)));

LANE_INLINE LANE(real) LANE(splat)(double a) { return a - (LANE(real)){0}; }
LANE_INLINE LANE(bits) LANE(splat_bits)(uint64_t a) { return a + (LANE(bits)){0}; }
LANE_INLINE LANE(real) LANE(load)(const double *p) {
  LANE(real) a;
  memcpy(&a, p, sizeof a);
  return a;
}
LANE_INLINE void LANE(store)(double *p, LANE(real) a) { memcpy(p, &a, sizeof a); }
LANE_INLINE LANE(mask) LANE(not )(LANE(mask) m) { return ~m; }
LANE_INLINE int LANE(any)(LANE(mask) m) {
  int64_t any = m[0];
  for (int k = 1; k < LANE_WIDTH; k++) any |= m[k];
  return any != 0;
}
LANE_INLINE int LANE(lane_is)(LANE(mask) m, int k) { return m[k] != 0; }
LANE_INLINE LANE(bits) LANE(as_bits)(LANE(real) a) { return (LANE(bits))a; }
LANE_INLINE LANE(real) LANE(as_real)(LANE(bits) a) { return (LANE(real))a; }

#if LANE_WIDTH == 8 && defined(__AVX512F__)
LANE_INLINE real_w8 root_w8(real_w8 a) { return (real_w8)_mm512_sqrt_pd((__m512d)a); }
/* Eight loads: on processors that take a gather instruction apart these are faster, on others as fast. */
LANE_INLINE real_w8 gather_w8(const double *p, const int32_t *index) {
  return (real_w8){p[index[0]], p[index[1]], p[index[2]], p[index[3]],
                   p[index[4]], p[index[5]], p[index[6]], p[index[7]]};
}
LANE_INLINE bits_w8 multiply32_w8(bits_w8 a, bits_w8 b) {
  return (bits_w8)_mm512_mul_epu32((__m512i)a, (__m512i)b);
}
LANE_INLINE real_w8 select_w8(mask_w8 m, real_w8 a, real_w8 b) {
  return (real_w8)_mm512_mask_blend_pd(_mm512_movepi64_mask((__m512i)m), (__m512d)b, (__m512d)a);
}
LANE_INLINE real_w8 least_w8(real_w8 a, real_w8 b) { return (real_w8)_mm512_min_pd((__m512d)a, (__m512d)b); }
LANE_INLINE real_w8 most_w8(real_w8 a, real_w8 b) { return (real_w8)_mm512_max_pd((__m512d)a, (__m512d)b); }
#elif LANE_WIDTH == 4 && defined(__AVX2__)
LANE_INLINE real_w4 select_w4(mask_w4 m, real_w4 a, real_w4 b) {
  return (real_w4)_mm256_blendv_pd((__m256d)b, (__m256d)a, (__m256d)m);
}
LANE_INLINE real_w4 least_w4(real_w4 a, real_w4 b) { return (real_w4)_mm256_min_pd((__m256d)a, (__m256d)b); }
LANE_INLINE real_w4 most_w4(real_w4 a, real_w4 b) { return (real_w4)_mm256_max_pd((__m256d)a, (__m256d)b); }
LANE_INLINE real_w4 root_w4(real_w4 a) { return (real_w4)_mm256_sqrt_pd((__m256d)a); }
LANE_INLINE real_w4 gather_w4(const double *p, const int32_t *index) {
  return (real_w4){p[index[0]], p[index[1]], p[index[2]], p[index[3]]};
}
LANE_INLINE bits_w4 multiply32_w4(bits_w4 a, bits_w4 b) {
  return (bits_w4)_mm256_mul_epu32((__m256i)a, (__m256i)b);
}
#elif LANE_WIDTH == 2 && defined(__SSE2__)
LANE_INLINE real_w2 root_w2(real_w2 a) { return (real_w2)_mm_sqrt_pd((__m128d)a); }
LANE_INLINE real_w2 gather_w2(const double *p, const int32_t *index) {
  return (real_w2){p[index[0]], p[index[1]]};
}
LANE_INLINE real_w2 select_w2(mask_w2 m, real_w2 a, real_w2 b) {
#if defined(__SSE4_1__)
  return (real_w2)_mm_blendv_pd((__m128d)b, (__m128d)a, (__m128d)m);
#else
  return (real_w2)((m & (mask_w2)a) | (~m & (mask_w2)b));
#endif
}
LANE_INLINE real_w2 least_w2(real_w2 a, real_w2 b) { return (real_w2)_mm_min_pd((__m128d)a, (__m128d)b); }
LANE_INLINE real_w2 most_w2(real_w2 a, real_w2 b) { return (real_w2)_mm_max_pd((__m128d)a, (__m128d)b); }
LANE_INLINE bits_w2 multiply32_w2(bits_w2 a, bits_w2 b) {
  return (bits_w2)_mm_mul_epu32((__m128i)a, (__m128i)b);
}
#else /* any other machine: the compiler's own vectors */
LANE_INLINE LANE(real) LANE(select)(LANE(mask) m, LANE(real) a, LANE(real) b) {
  return (LANE(real))((m & (LANE(mask))a) | (~m & (LANE(mask))b));
}
LANE_INLINE LANE(real) LANE(least)(LANE(real) a, LANE(real) b) { return LANE(select)(a < b, a, b); }
LANE_INLINE LANE(real) LANE(most)(LANE(real) a, LANE(real) b) { return LANE(select)(a > b, a, b); }
LANE_INLINE LANE(real) LANE(root)(LANE(real) a) {
  for (int k = 0; k < LANE_WIDTH; k++) a[k] = sqrt(a[k]);
  return a;
}
LANE_INLINE LANE(real) LANE(gather)(const double *p, const int32_t *index) {
  LANE(real) a = {0};
  for (int k = 0; k < LANE_WIDTH; k++) a[k] = p[index[k]];
  return a;
}
LANE_INLINE LANE(bits) LANE(multiply32)(LANE(bits) a, LANE(bits) b) {
  return (a & 0xffffffffu) * (b & 0xffffffffu);
}
#endif
#endif

/* Nearest integer, ties to even, for |a| < 2^51. */
LANE_INLINE LANE(real) LANE(nearest)(LANE(real) a) { return (a + 0x1.8p52) - 0x1.8p52; }

/* lane.h: LANE_WIDTH doubles that are worked on together; included once per width.
 *
 * The same text (law, random draws) is compiled for width 1 and for the machine's vectors. Every operation
 * here is an IEEE basic operation or a selection, so a lane's result does not depend on the width.
 * Names carry the width: LANE(real) is real_w1 or real_w8. A mask says yes or no for each lane: masks are combined
 * with & and |, and what they are made of is the machine's affair.
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
LANE_INLINE mask_w1 greater_w1(real_w1 a, real_w1 b) { return a > b; }
LANE_INLINE mask_w1 within_w1(real_w1 a, real_w1 b) { return a <= b; }
LANE_INLINE mask_w1 equal_w1(real_w1 a, real_w1 b) { return a == b; }
LANE_INLINE mask_w1 all_lanes_w1(int yes) { return yes; }
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
typedef uint64_t LANE(bits) __attribute__((vector_size(8 * LANE_WIDTH)));

LANE_INLINE LANE(real) LANE(splat)(double a) { return a - (LANE(real)){0}; }
LANE_INLINE LANE(bits) LANE(splat_bits)(uint64_t a) { return a + (LANE(bits)){0}; }
LANE_INLINE LANE(real) LANE(load)(const double *p) {
  LANE(real) a;
  memcpy(&a, p, sizeof a);
  return a;
}
LANE_INLINE void LANE(store)(double *p, LANE(real) a) { memcpy(p, &a, sizeof a); }
LANE_INLINE LANE(bits) LANE(as_bits)(LANE(real) a) { return (LANE(bits))a; }
LANE_INLINE LANE(real) LANE(as_real)(LANE(bits) a) { return (LANE(real))a; }
LANE_INLINE LANE(real) LANE(gather)(const double *p, const int32_t *index) {
  /* single loads: on processors that take a gather instruction apart these are faster, on others as fast */
  LANE(real) a = {0};
  for (int k = 0; k < LANE_WIDTH; k++) a[k] = p[index[k]];
  return a;
}

#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__)

/* masks are bits in mask registers */
typedef __mmask8 LANE(mask);
LANE_INLINE LANE(mask) LANE(all_lanes)(int yes) { return (LANE(mask))(yes ? (1u << LANE_WIDTH) - 1u : 0u); }
LANE_INLINE LANE(mask) LANE(not )(LANE(mask) m) { return (LANE(mask))(m ^ ((1u << LANE_WIDTH) - 1u)); }
LANE_INLINE int LANE(any)(LANE(mask) m) { return m != 0; }
LANE_INLINE int LANE(lane_is)(LANE(mask) m, int k) { return m >> k & 1; }
#if LANE_WIDTH == 8
#define LANE_VECTOR __m512d
#define LANE_INTEGERS __m512i
#define LANE_OPERATION(name) _mm512_##name
#elif LANE_WIDTH == 4
#define LANE_VECTOR __m256d
#define LANE_INTEGERS __m256i
#define LANE_OPERATION(name) _mm256_##name
#else
#define LANE_VECTOR __m128d
#define LANE_INTEGERS __m128i
#define LANE_OPERATION(name) _mm_##name
#endif
LANE_INLINE LANE(mask) LANE(greater)(LANE(real) a, LANE(real) b) {
  return LANE_OPERATION(cmp_pd_mask)((LANE_VECTOR)a, (LANE_VECTOR)b, _CMP_GT_OQ);
}
LANE_INLINE LANE(mask) LANE(within)(LANE(real) a, LANE(real) b) {
  return LANE_OPERATION(cmp_pd_mask)((LANE_VECTOR)a, (LANE_VECTOR)b, _CMP_LE_OQ);
}
LANE_INLINE LANE(mask) LANE(equal)(LANE(real) a, LANE(real) b) {
  return LANE_OPERATION(cmp_pd_mask)((LANE_VECTOR)a, (LANE_VECTOR)b, _CMP_EQ_OQ);
}
LANE_INLINE LANE(real) LANE(select)(LANE(mask) m, LANE(real) a, LANE(real) b) {
  return (LANE(real))LANE_OPERATION(mask_blend_pd)(m, (LANE_VECTOR)b, (LANE_VECTOR)a);
}

#else

/* masks are vectors of integers, all bits of a lane set or none */
typedef int64_t LANE(mask) __attribute__((vector_size(8 * LANE_WIDTH)));
LANE_INLINE LANE(mask) LANE(all_lanes)(int yes) { return (LANE(mask)){0} - (int64_t)yes; }
LANE_INLINE LANE(mask) LANE(not )(LANE(mask) m) { return ~m; }
LANE_INLINE int LANE(lane_is)(LANE(mask) m, int k) { return m[k] != 0; }
LANE_INLINE LANE(mask) LANE(greater)(LANE(real) a, LANE(real) b) { return a > b; }
LANE_INLINE LANE(mask) LANE(within)(LANE(real) a, LANE(real) b) { return a <= b; }
LANE_INLINE LANE(mask) LANE(equal)(LANE(real) a, LANE(real) b) { return a == b; }
#if LANE_WIDTH == 4 && defined(__AVX2__)
#define LANE_VECTOR __m256d
#define LANE_INTEGERS __m256i
#define LANE_OPERATION(name) _mm256_##name
LANE_INLINE int any_w4(mask_w4 m) { return _mm256_movemask_pd((__m256d)m) != 0; }
LANE_INLINE real_w4 select_w4(mask_w4 m, real_w4 a, real_w4 b) {
  return (real_w4)_mm256_blendv_pd((__m256d)b, (__m256d)a, (__m256d)m);
}
#elif LANE_WIDTH == 2 && defined(__SSE2__)
#define LANE_VECTOR __m128d
#define LANE_INTEGERS __m128i
#define LANE_OPERATION(name) _mm_##name
LANE_INLINE int any_w2(mask_w2 m) { return _mm_movemask_pd((__m128d)m) != 0; }
LANE_INLINE real_w2 select_w2(mask_w2 m, real_w2 a, real_w2 b) {
#if defined(__SSE4_1__)
  return (real_w2)_mm_blendv_pd((__m128d)b, (__m128d)a, (__m128d)m);
#else
  return (real_w2)((m & (mask_w2)a) | (~m & (mask_w2)b));
#endif
}
#else
LANE_INLINE int LANE(any)(LANE(mask) m) {
  int64_t any = m[0];
  for (int k = 1; k < LANE_WIDTH; k++) any |= m[k];
  return any != 0;
}
LANE_INLINE LANE(real) LANE(select)(LANE(mask) m, LANE(real) a, LANE(real) b) {
  return (LANE(real))((m & (LANE(mask))a) | (~m & (LANE(mask))b));
}
#endif
#endif

#if defined(LANE_VECTOR)
LANE_INLINE LANE(real) LANE(least)(LANE(real) a, LANE(real) b) {
  return (LANE(real))LANE_OPERATION(min_pd)((LANE_VECTOR)a, (LANE_VECTOR)b);
}
LANE_INLINE LANE(real) LANE(most)(LANE(real) a, LANE(real) b) {
  return (LANE(real))LANE_OPERATION(max_pd)((LANE_VECTOR)a, (LANE_VECTOR)b);
}
LANE_INLINE LANE(real) LANE(root)(LANE(real) a) {
  return (LANE(real))LANE_OPERATION(sqrt_pd)((LANE_VECTOR)a);
}
LANE_INLINE LANE(bits) LANE(multiply32)(LANE(bits) a, LANE(bits) b) {
  return (LANE(bits))LANE_OPERATION(mul_epu32)((LANE_INTEGERS)a, (LANE_INTEGERS)b);
}
#undef LANE_VECTOR
#undef LANE_INTEGERS
#undef LANE_OPERATION
#else /* any other machine: the compiler's own vectors */
LANE_INLINE LANE(real) LANE(least)(LANE(real) a, LANE(real) b) {
  return LANE(select)(LANE(greater)(b, a), a, b);
}
LANE_INLINE LANE(real) LANE(most)(LANE(real) a, LANE(real) b) {
  return LANE(select)(LANE(greater)(a, b), a, b);
}
LANE_INLINE LANE(real) LANE(root)(LANE(real) a) {
  for (int k = 0; k < LANE_WIDTH; k++) a[k] = sqrt(a[k]);
  return a;
}
LANE_INLINE LANE(bits) LANE(multiply32)(LANE(bits) a, LANE(bits) b) {
  return (a & 0xffffffffu) * (b & 0xffffffffu);
}
#endif
#endif

/* a where the mask says so, else 0. */
LANE_INLINE LANE(real) LANE(keep)(LANE(mask) m, LANE(real) a) { return LANE(select)(m, a, LANE(splat)(0.0)); }

/* Nearest integer, ties to even, for |a| < 2^51. */
LANE_INLINE LANE(real) LANE(nearest)(LANE(real) a) { return (a + 0x1.8p52) - 0x1.8p52; }

/* lane.h: vectors of LANE_WIDTH doubles, one per lane; the file is included once per width.
 *
 * The same code (contact law, random numbers) is compiled for width 1 and for the machine's
 * vectors. Every operation here is an IEEE basic operation or a selection, so a lane's result does
 * not depend on the width. Names carry the width: LANE(real) is real_w1 or real_w8. A mask holds
 * true or false for each lane. Masks are combined with &, | and ^; their representation depends on
 * the machine. bits_of and mask_of convert to and from an integer whose bit k is lane k.
 */
#ifndef LANE_WIDTH
#error "define LANE_WIDTH before including base/lane.h"
#endif

#ifndef LANE_COMMON
#define LANE_COMMON
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(__wasm_simd128__)
#include <wasm_simd128.h>
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
LANE_INLINE real_w1 min_w1(real_w1 a, real_w1 b) { return a < b ? a : b; }
LANE_INLINE real_w1 max_w1(real_w1 a, real_w1 b) { return a > b ? a : b; }
LANE_INLINE int any_w1(mask_w1 m) { return m != 0; }
LANE_INLINE int lane_is_w1(mask_w1 m, int k) { return (void)k, m != 0; }
LANE_INLINE unsigned bits_of_w1(mask_w1 m) { return m != 0; }
LANE_INLINE mask_w1 mask_of_w1(unsigned bits) { return bits & 1u; }
LANE_INLINE real_w1 sqrt_w1(real_w1 a) { return sqrt(a); }
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
LANE_INLINE bits_w1 multiply32_w1(bits_w1 a, bits_w1 b) {
  return (a & 0xffffffffu) * (b & 0xffffffffu);
}

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
  /* Scalar loads are faster than the gather instruction on some processors (those that split it),
   * and as fast on others. */
  LANE(real) a = {0};
  for (int k = 0; k < LANE_WIDTH; k++) a[k] = p[index[k]];
  return a;
}

#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512DQ__)

/* a mask is a mask register with one bit per lane */
typedef __mmask8 LANE(mask);
LANE_INLINE LANE(mask) LANE(all_lanes)(int yes) {
  return (LANE(mask))(yes ? (1u << LANE_WIDTH) - 1u : 0u);
}
LANE_INLINE LANE(mask) LANE(not )(LANE(mask) m) {
  return (LANE(mask))(m ^ ((1u << LANE_WIDTH) - 1u));
}
LANE_INLINE int LANE(any)(LANE(mask) m) { return m != 0; }
LANE_INLINE int LANE(lane_is)(LANE(mask) m, int k) { return m >> k & 1; }
LANE_INLINE unsigned LANE(bits_of)(LANE(mask) m) { return m & ((1u << LANE_WIDTH) - 1u); }
LANE_INLINE LANE(mask) LANE(mask_of)(unsigned bits) {
  return (LANE(mask))(bits & ((1u << LANE_WIDTH) - 1u));
}
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

/* a mask is a vector of integers: in each lane all bits are set (true) or none (false) */
typedef int64_t LANE(mask) __attribute__((vector_size(8 * LANE_WIDTH)));
LANE_INLINE LANE(mask) LANE(all_lanes)(int yes) { return (LANE(mask)){0} - (int64_t)yes; }
LANE_INLINE LANE(mask) LANE(not )(LANE(mask) m) { return ~m; }
LANE_INLINE int LANE(lane_is)(LANE(mask) m, int k) { return m[k] != 0; }
LANE_INLINE LANE(mask) LANE(mask_of)(unsigned bits) {
  LANE(mask) m = {0};
  for (int k = 0; k < LANE_WIDTH; k++) m[k] = -(int64_t)(bits >> k & 1u);
  return m;
}
LANE_INLINE LANE(mask) LANE(greater)(LANE(real) a, LANE(real) b) { return a > b; }
LANE_INLINE LANE(mask) LANE(within)(LANE(real) a, LANE(real) b) { return a <= b; }
LANE_INLINE LANE(mask) LANE(equal)(LANE(real) a, LANE(real) b) { return a == b; }
#if LANE_WIDTH == 4 && defined(__AVX2__)
#define LANE_VECTOR __m256d
#define LANE_INTEGERS __m256i
#define LANE_OPERATION(name) _mm256_##name
LANE_INLINE unsigned bits_of_w4(mask_w4 m) { return (unsigned)_mm256_movemask_pd((__m256d)m); }
LANE_INLINE int any_w4(mask_w4 m) { return bits_of_w4(m) != 0; }
LANE_INLINE real_w4 select_w4(mask_w4 m, real_w4 a, real_w4 b) {
  return (real_w4)_mm256_blendv_pd((__m256d)b, (__m256d)a, (__m256d)m);
}
#elif LANE_WIDTH == 2 && defined(__SSE2__)
#define LANE_VECTOR __m128d
#define LANE_INTEGERS __m128i
#define LANE_OPERATION(name) _mm_##name
LANE_INLINE unsigned bits_of_w2(mask_w2 m) { return (unsigned)_mm_movemask_pd((__m128d)m); }
LANE_INLINE int any_w2(mask_w2 m) { return bits_of_w2(m) != 0; }
LANE_INLINE real_w2 select_w2(mask_w2 m, real_w2 a, real_w2 b) {
#if defined(__SSE4_1__)
  return (real_w2)_mm_blendv_pd((__m128d)b, (__m128d)a, (__m128d)m);
#else
  return (real_w2)((m & (mask_w2)a) | (~m & (mask_w2)b));
#endif
}
#elif LANE_WIDTH == 2 && defined(__wasm_simd128__)
LANE_INLINE unsigned bits_of_w2(mask_w2 m) { return (unsigned)wasm_i64x2_bitmask((v128_t)m); }
LANE_INLINE int any_w2(mask_w2 m) { return wasm_v128_any_true((v128_t)m); }
LANE_INLINE real_w2 select_w2(mask_w2 m, real_w2 a, real_w2 b) {
  return (real_w2)wasm_v128_bitselect((v128_t)a, (v128_t)b, (v128_t)m);
}
#else
LANE_INLINE unsigned LANE(bits_of)(LANE(mask) m) {
  unsigned bits = 0;
  for (int k = 0; k < LANE_WIDTH; k++) bits |= m[k] ? 1u << k : 0u;
  return bits;
}
LANE_INLINE int LANE(any)(LANE(mask) m) { return LANE(bits_of)(m) != 0; }
LANE_INLINE LANE(real) LANE(select)(LANE(mask) m, LANE(real) a, LANE(real) b) {
  return (LANE(real))((m & (LANE(mask))a) | (~m & (LANE(mask))b));
}
#endif
#endif

#if defined(LANE_VECTOR)
LANE_INLINE LANE(real) LANE(min)(LANE(real) a, LANE(real) b) {
  return (LANE(real))LANE_OPERATION(min_pd)((LANE_VECTOR)a, (LANE_VECTOR)b);
}
LANE_INLINE LANE(real) LANE(max)(LANE(real) a, LANE(real) b) {
  return (LANE(real))LANE_OPERATION(max_pd)((LANE_VECTOR)a, (LANE_VECTOR)b);
}
LANE_INLINE LANE(real) LANE(sqrt)(LANE(real) a) {
  return (LANE(real))LANE_OPERATION(sqrt_pd)((LANE_VECTOR)a);
}
LANE_INLINE LANE(bits) LANE(multiply32)(LANE(bits) a, LANE(bits) b) {
  return (LANE(bits))LANE_OPERATION(mul_epu32)((LANE_INTEGERS)a, (LANE_INTEGERS)b);
}
#undef LANE_VECTOR
#undef LANE_INTEGERS
#undef LANE_OPERATION
#else /* other machines: the compiler's generic vectors */
LANE_INLINE LANE(real) LANE(min)(LANE(real) a, LANE(real) b) {
  return LANE(select)(LANE(greater)(b, a), a, b);
}
LANE_INLINE LANE(real) LANE(max)(LANE(real) a, LANE(real) b) {
  return LANE(select)(LANE(greater)(a, b), a, b);
}
LANE_INLINE LANE(real) LANE(sqrt)(LANE(real) a) {
#if LANE_WIDTH == 2 && defined(__wasm_simd128__)
  return (LANE(real))wasm_f64x2_sqrt((v128_t)a);
#else
  for (int k = 0; k < LANE_WIDTH; k++) a[k] = sqrt(a[k]);
  return a;
#endif
}
LANE_INLINE LANE(bits) LANE(multiply32)(LANE(bits) a, LANE(bits) b) {
  return (a & 0xffffffffu) * (b & 0xffffffffu);
}
#endif
#endif

/* Returns a vector with the number in `a` where the mask is true, and 0 in the other lanes. */
LANE_INLINE LANE(real) LANE(mask_zero)(LANE(mask) m, LANE(real) a) {
  return LANE(select)(m, a, LANE(splat)(0.0));
}

/* Returns `a`, or 0 with its sign if it is subnormal, on machines whose arithmetic does not do that
 * by itself (subnormal.h). */
LANE_INLINE LANE(real) LANE(normal)(LANE(real) a) {
#if defined(__SSE2__) || defined(__aarch64__)
  return a;
#else
  const LANE(real) size = LANE(max)(a, -a);
  return LANE(select)(LANE(greater)(LANE(splat)(0x1p-1022), size), a * 0.0, a);
#endif
}

/* Returns the nearest integer, ties to even, for |a| < 2^51. */
LANE_INLINE LANE(real) LANE(nearest)(LANE(real) a) { return (a + 0x1.8p52) - 0x1.8p52; }

/* --- rows of two or four numbers, one row per lane -------------------------------------------- */

/* Functions that read or write a row of four numbers for each lane, within an array of doubles;
 * c[k] is the vector of all lanes' numbers in column k. Positions of rows (at, a, b, to, from,
 * stride) are counted in doubles.
 *   gather4:  reads for each lane the row at rows + at[lane]
 *   load4:    reads for each lane the row at rows + stride * lane; scatter4 writes these rows
 *   across4:  reads two rows for each lane, and returns b - a in columns 0 and 2, b + a in
 *             columns 1 and 3
 *   across2:  reads two rows of two numbers for each lane, and returns b - a in both columns
 *   add4:     adds each lane's row to the row at rows + to[lane]; in the row at rows + from[lane]
 *             it subtracts columns 0 and 2 and adds columns 1 and 3; one lane after the other, so
 *             lanes may use the same rows */
#if LANE_WIDTH >= 4 && (defined(__clang__) || __GNUC__ >= 12)
typedef double LANE(four) __attribute__((vector_size(32)));
typedef double LANE(two) __attribute__((vector_size(16)));
/* the same vectors when they are in memory, where they are aligned only like a double */
typedef double LANE(loose_four) __attribute__((vector_size(32), aligned(8), may_alias));
typedef double LANE(loose_two) __attribute__((vector_size(16), aligned(8), may_alias));
typedef int64_t LANE(four_bits) __attribute__((vector_size(32)));

/* Four rows of four numbers, a 4 x 4 matrix. */
typedef struct LANE(block) {
  LANE(four) r0, r1, r2, r3;
} LANE(block);

LANE_INLINE LANE(block) LANE(transpose)(LANE(block) m) {
  LANE(four) a = __builtin_shufflevector(m.r0, m.r1, 0, 4, 2, 6);
  LANE(four) b = __builtin_shufflevector(m.r0, m.r1, 1, 5, 3, 7);
  LANE(four) c = __builtin_shufflevector(m.r2, m.r3, 0, 4, 2, 6);
  LANE(four) d = __builtin_shufflevector(m.r2, m.r3, 1, 5, 3, 7);
  return (LANE(block)){
      __builtin_shufflevector(a, c, 0, 1, 4, 5), __builtin_shufflevector(b, d, 0, 1, 4, 5),
      __builtin_shufflevector(a, c, 2, 3, 6, 7), __builtin_shufflevector(b, d, 2, 3, 6, 7)};
}

LANE_INLINE LANE(four) LANE(load_four)(const double *p) { return *(const LANE(loose_four) *)p; }
LANE_INLINE void LANE(store_four)(double *p, LANE(four) a) { *(LANE(loose_four) *)p = a; }
LANE_INLINE LANE(two) LANE(load_two)(const double *p) { return *(const LANE(loose_two) *)p; }

/* Combines two rows of four numbers: returns b - a in columns 0 and 2, b + a in columns 1 and 3. */
LANE_INLINE LANE(four) LANE(across)(LANE(four) b, LANE(four) a) {
#if defined(__AVX__)
  return (LANE(four))_mm256_addsub_pd((__m256d)b, (__m256d)a);
#else
  const LANE(four) sign = {-0.0, 0.0, -0.0, 0.0};
  return b + (LANE(four))((LANE(four_bits))a ^ (LANE(four_bits))sign);
#endif
}

LANE_INLINE LANE(four) LANE(across_row)(const double *rows, int32_t a, int32_t b) {
  return LANE(across)(LANE(load_four)(rows + b), LANE(load_four)(rows + a));
}

LANE_INLINE LANE(block) LANE(across_block)(const double *rows, const int32_t *a, const int32_t *b) {
  return LANE(transpose)(
      (LANE(block)){LANE(across_row)(rows, a[0], b[0]), LANE(across_row)(rows, a[1], b[1]),
                    LANE(across_row)(rows, a[2], b[2]), LANE(across_row)(rows, a[3], b[3])});
}

LANE_INLINE LANE(block) LANE(gather_block)(const double *rows, const int32_t *at) {
  return LANE(transpose)((LANE(block)){LANE(load_four)(rows + at[0]), LANE(load_four)(rows + at[1]),
                                       LANE(load_four)(rows + at[2]),
                                       LANE(load_four)(rows + at[3])});
}

LANE_INLINE LANE(two) LANE(across_two)(const double *rows, int32_t a, int32_t b) {
  return LANE(load_two)(rows + b) - LANE(load_two)(rows + a);
}

/* Computes differences of rows of two numbers for four lanes: c[k] has, for each lane, column k of
 * the row at rows + b[lane] minus the row at rows + a[lane]. */
LANE_INLINE void LANE(across_half)(const double *rows, const int32_t *a, const int32_t *b,
                                   LANE(four) c[2]) {
  LANE(four)
  even = __builtin_shufflevector(LANE(across_two)(rows, a[0], b[0]),
                                 LANE(across_two)(rows, a[2], b[2]), 0, 1, 2, 3);
  LANE(four)
  odd = __builtin_shufflevector(LANE(across_two)(rows, a[1], b[1]),
                                LANE(across_two)(rows, a[3], b[3]), 0, 1, 2, 3);
  c[0] = __builtin_shufflevector(even, odd, 0, 4, 2, 6);
  c[1] = __builtin_shufflevector(even, odd, 1, 5, 3, 7);
}

LANE_INLINE void LANE(add_row)(double *rows, int32_t to, int32_t from, LANE(four) row) {
  LANE(store_four)(rows + to, LANE(load_four)(rows + to) + row);
  LANE(store_four)(rows + from, LANE(across)(LANE(load_four)(rows + from), row));
}

LANE_INLINE void LANE(add_block)(double *rows, const int32_t *to, const int32_t *from,
                                 LANE(block) m) {
  m = LANE(transpose)(m);
  LANE(add_row)(rows, to[0], from[0], m.r0);
  LANE(add_row)(rows, to[1], from[1], m.r1);
  LANE(add_row)(rows, to[2], from[2], m.r2);
  LANE(add_row)(rows, to[3], from[3], m.r3);
}

LANE_INLINE void LANE(scatter_block)(double *rows, size_t stride, LANE(block) m) {
  m = LANE(transpose)(m);
  LANE(store_four)(rows, m.r0);
  LANE(store_four)(rows + stride, m.r1);
  LANE(store_four)(rows + 2 * stride, m.r2);
  LANE(store_four)(rows + 3 * stride, m.r3);
}

LANE_INLINE LANE(block) LANE(load_block)(const double *rows, size_t stride) {
  return LANE(transpose)((LANE(block)){LANE(load_four)(rows), LANE(load_four)(rows + stride),
                                       LANE(load_four)(rows + 2 * stride),
                                       LANE(load_four)(rows + 3 * stride)});
}

#if LANE_WIDTH == 4
LANE_INLINE void LANE(load4)(const double *rows, size_t stride, LANE(real) c[4]) {
  LANE(block) m = LANE(load_block)(rows, stride);
  c[0] = m.r0, c[1] = m.r1, c[2] = m.r2, c[3] = m.r3;
}
LANE_INLINE void LANE(gather4)(const double *rows, const int32_t *at, LANE(real) c[4]) {
  LANE(block) m = LANE(gather_block)(rows, at);
  c[0] = m.r0, c[1] = m.r1, c[2] = m.r2, c[3] = m.r3;
}
LANE_INLINE void LANE(across4)(const double *rows, const int32_t *a, const int32_t *b,
                               LANE(real) c[4]) {
  LANE(block) m = LANE(across_block)(rows, a, b);
  c[0] = m.r0, c[1] = m.r1, c[2] = m.r2, c[3] = m.r3;
}
LANE_INLINE void LANE(across2)(const double *rows, const int32_t *a, const int32_t *b,
                               LANE(real) c[2]) {
  LANE(across_half)(rows, a, b, c);
}
LANE_INLINE void LANE(add4)(double *rows, const int32_t *to, const int32_t *from,
                            const LANE(real) c[4]) {
  LANE(add_block)(rows, to, from, (LANE(block)){c[0], c[1], c[2], c[3]});
}
LANE_INLINE void LANE(scatter4)(double *rows, size_t stride, const LANE(real) c[4]) {
  LANE(scatter_block)(rows, stride, (LANE(block)){c[0], c[1], c[2], c[3]});
}
#else
LANE_INLINE LANE(real) LANE(whole)(LANE(four) low, LANE(four) high) {
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}
LANE_INLINE LANE(four) LANE(low)(LANE(real) a) { return __builtin_shufflevector(a, a, 0, 1, 2, 3); }
LANE_INLINE LANE(four) LANE(high)(LANE(real) a) {
  return __builtin_shufflevector(a, a, 4, 5, 6, 7);
}
LANE_INLINE LANE(block) LANE(lows)(const LANE(real) c[4]) {
  return (LANE(block)){LANE(low)(c[0]), LANE(low)(c[1]), LANE(low)(c[2]), LANE(low)(c[3])};
}
LANE_INLINE LANE(block) LANE(highs)(const LANE(real) c[4]) {
  return (LANE(block)){LANE(high)(c[0]), LANE(high)(c[1]), LANE(high)(c[2]), LANE(high)(c[3])};
}
LANE_INLINE void LANE(gather4)(const double *rows, const int32_t *at, LANE(real) c[4]) {
  LANE(block) m = LANE(gather_block)(rows, at), n = LANE(gather_block)(rows, at + 4);
  c[0] = LANE(whole)(m.r0, n.r0);
  c[1] = LANE(whole)(m.r1, n.r1);
  c[2] = LANE(whole)(m.r2, n.r2);
  c[3] = LANE(whole)(m.r3, n.r3);
}
LANE_INLINE void LANE(load4)(const double *rows, size_t stride, LANE(real) c[4]) {
  LANE(block) m = LANE(load_block)(rows, stride), n = LANE(load_block)(rows + 4 * stride, stride);
  c[0] = LANE(whole)(m.r0, n.r0);
  c[1] = LANE(whole)(m.r1, n.r1);
  c[2] = LANE(whole)(m.r2, n.r2);
  c[3] = LANE(whole)(m.r3, n.r3);
}
LANE_INLINE void LANE(across4)(const double *rows, const int32_t *a, const int32_t *b,
                               LANE(real) c[4]) {
  LANE(block) m = LANE(across_block)(rows, a, b), n = LANE(across_block)(rows, a + 4, b + 4);
  c[0] = LANE(whole)(m.r0, n.r0);
  c[1] = LANE(whole)(m.r1, n.r1);
  c[2] = LANE(whole)(m.r2, n.r2);
  c[3] = LANE(whole)(m.r3, n.r3);
}
LANE_INLINE void LANE(across2)(const double *rows, const int32_t *a, const int32_t *b,
                               LANE(real) c[2]) {
  LANE(four) m[2], n[2];
  LANE(across_half)(rows, a, b, m);
  LANE(across_half)(rows, a + 4, b + 4, n);
  c[0] = LANE(whole)(m[0], n[0]);
  c[1] = LANE(whole)(m[1], n[1]);
}
LANE_INLINE void LANE(add4)(double *rows, const int32_t *to, const int32_t *from,
                            const LANE(real) c[4]) {
  LANE(add_block)(rows, to, from, LANE(lows)(c));
  LANE(add_block)(rows, to + 4, from + 4, LANE(highs)(c));
}
LANE_INLINE void LANE(scatter4)(double *rows, size_t stride, const LANE(real) c[4]) {
  LANE(scatter_block)(rows, stride, LANE(lows)(c));
  LANE(scatter_block)(rows + 4 * stride, stride, LANE(highs)(c));
}
#endif
#elif LANE_WIDTH == 2 && (defined(__clang__) || __GNUC__ >= 12)
typedef double LANE(loose) __attribute__((vector_size(16), aligned(8), may_alias));
LANE_INLINE LANE(real) LANE(load_two)(const double *p) { return *(const LANE(loose) *)p; }
LANE_INLINE void LANE(store_two)(double *p, LANE(real) a) { *(LANE(loose) *)p = a; }
LANE_INLINE LANE(real) LANE(firsts)(LANE(real) a, LANE(real) b) {
  return __builtin_shufflevector(a, b, 0, 2);
}
LANE_INLINE LANE(real) LANE(seconds)(LANE(real) a, LANE(real) b) {
  return __builtin_shufflevector(a, b, 1, 3);
}
LANE_INLINE void LANE(gather4)(const double *rows, const int32_t *at, LANE(real) c[4]) {
  for (int k = 0; k < 4; k += 2) {
    LANE(real) one = LANE(load_two)(rows + at[0] + k), two = LANE(load_two)(rows + at[1] + k);
    c[k] = LANE(firsts)(one, two);
    c[k + 1] = LANE(seconds)(one, two);
  }
}
LANE_INLINE void LANE(load4)(const double *rows, size_t stride, LANE(real) c[4]) {
  LANE(gather4)(rows, (const int32_t[]){0, (int32_t)stride}, c);
}
LANE_INLINE LANE(real) LANE(across)(LANE(real) b, LANE(real) a) {
  const LANE(real) sign = {-0.0, 0.0};
  return b + LANE(as_real)(LANE(as_bits)(a) ^ LANE(as_bits)(sign));
}
LANE_INLINE LANE(real) LANE(across_two)(const double *rows, int32_t a, int32_t b) {
  return LANE(across)(LANE(load_two)(rows + b), LANE(load_two)(rows + a));
}
LANE_INLINE void LANE(across4)(const double *rows, const int32_t *a, const int32_t *b,
                               LANE(real) c[4]) {
  for (int k = 0; k < 4; k += 2) {
    LANE(real)
    one = LANE(across_two)(rows + k, a[0], b[0]), two = LANE(across_two)(rows + k, a[1], b[1]);
    c[k] = LANE(firsts)(one, two);
    c[k + 1] = LANE(seconds)(one, two);
  }
}
LANE_INLINE void LANE(across2)(const double *rows, const int32_t *a, const int32_t *b,
                               LANE(real) c[2]) {
  LANE(real) one = LANE(load_two)(rows + b[0]) - LANE(load_two)(rows + a[0]);
  LANE(real) two = LANE(load_two)(rows + b[1]) - LANE(load_two)(rows + a[1]);
  c[0] = LANE(firsts)(one, two);
  c[1] = LANE(seconds)(one, two);
}
LANE_INLINE void LANE(add_row)(double *rows, int32_t to, int32_t from, LANE(real) a, LANE(real) b) {
  LANE(store_two)(rows + to, LANE(load_two)(rows + to) + a);
  LANE(store_two)(rows + to + 2, LANE(load_two)(rows + to + 2) + b);
  LANE(store_two)(rows + from, LANE(across)(LANE(load_two)(rows + from), a));
  LANE(store_two)(rows + from + 2, LANE(across)(LANE(load_two)(rows + from + 2), b));
}
LANE_INLINE void LANE(add4)(double *rows, const int32_t *to, const int32_t *from,
                            const LANE(real) c[4]) {
  LANE(add_row)(rows, to[0], from[0], LANE(firsts)(c[0], c[1]), LANE(firsts)(c[2], c[3]));
  LANE(add_row)(rows, to[1], from[1], LANE(seconds)(c[0], c[1]), LANE(seconds)(c[2], c[3]));
}
LANE_INLINE void LANE(scatter4)(double *rows, size_t stride, const LANE(real) c[4]) {
  LANE(store_two)(rows, LANE(firsts)(c[0], c[1]));
  LANE(store_two)(rows + 2, LANE(firsts)(c[2], c[3]));
  LANE(store_two)(rows + stride, LANE(seconds)(c[0], c[1]));
  LANE(store_two)(rows + stride + 2, LANE(seconds)(c[2], c[3]));
}
#else
LANE_INLINE void LANE(gather_rows)(const double *rows, const int32_t *at, int n, LANE(real) * c) {
  double column[4][LANE_WIDTH];
  for (int l = 0; l < LANE_WIDTH; l++)
    for (int k = 0; k < n; k++) column[k][l] = rows[at[l] + k];
  for (int k = 0; k < n; k++) c[k] = LANE(load)(column[k]);
}
LANE_INLINE void LANE(scatter4)(double *rows, size_t stride, const LANE(real) c[4]) {
  double column[4][LANE_WIDTH];
  for (int k = 0; k < 4; k++) LANE(store)(column[k], c[k]);
  for (int l = 0; l < LANE_WIDTH; l++)
    for (int k = 0; k < 4; k++) rows[stride * (size_t)l + (size_t)k] = column[k][l];
}
LANE_INLINE void LANE(gather4)(const double *rows, const int32_t *at, LANE(real) c[4]) {
  LANE(gather_rows)(rows, at, 4, c);
}
LANE_INLINE void LANE(across2)(const double *rows, const int32_t *a, const int32_t *b,
                               LANE(real) c[2]) {
  LANE(real) of_a[2], of_b[2];
  LANE(gather_rows)(rows, a, 2, of_a);
  LANE(gather_rows)(rows, b, 2, of_b);
  for (int k = 0; k < 2; k++) c[k] = of_b[k] - of_a[k];
}
LANE_INLINE void LANE(across4)(const double *rows, const int32_t *a, const int32_t *b,
                               LANE(real) c[4]) {
  LANE(real) of_a[4], of_b[4];
  LANE(gather4)(rows, a, of_a);
  LANE(gather4)(rows, b, of_b);
  for (int k = 0; k < 4; k++) c[k] = k % 2 ? of_b[k] + of_a[k] : of_b[k] - of_a[k];
}
LANE_INLINE void LANE(add4)(double *rows, const int32_t *to, const int32_t *from,
                            const LANE(real) c[4]) {
  double column[4][LANE_WIDTH];
  for (int k = 0; k < 4; k++) LANE(store)(column[k], c[k]);
  for (int l = 0; l < LANE_WIDTH; l++)
    for (int k = 0; k < 4; k++) {
      rows[to[l] + k] += column[k][l];
      rows[from[l] + k] += k % 2 ? column[k][l] : -column[k][l];
    }
}
LANE_INLINE void LANE(load4)(const double *rows, size_t stride, LANE(real) c[4]) {
  int32_t at[LANE_WIDTH];
  for (int l = 0; l < LANE_WIDTH; l++) at[l] = (int32_t)stride * l;
  LANE(gather_rows)(rows, at, 4, c);
}
#endif

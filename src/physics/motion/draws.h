/* draws.h: counter-based normal random numbers in vector lanes; included once per LANE_WIDTH after
 * base/lane.h.
 *
 * Philox4x32-10 (Salmon, Moraes, Dror & Shaw, SC'11) turns a counter of four words (block low,
 * block high, stream, purpose) into four words of 32 random bits under a key of two words, the
 * seed. Two of these words give two normal numbers (Box & Muller): the first word w the radius, by
 * u = (w + 1/2) 2^-32, the second one the direction. So a block holds two draws, each a pair of
 * normal numbers. Only basic operations in a fixed order are used, so the bits are the same for
 * every LANE_WIDTH.
 *
 * The polynomials are minimax approximations of the results: the radius is accurate to 4e-10, the
 * direction to 9e-10, less than the distance between neighbouring directions of 32 bits (1.5e-9).
 */
#ifndef DRAWS_COMMON
#define DRAWS_COMMON
/* DRAW_BLOCKS: largest number of Philox blocks computed at a time; several are computed together so
 * that their chains of dependent operations overlap. DRAW_ROUNDS: number of rounds of Philox. */
enum { DRAW_BLOCKS = 4, DRAW_ROUNDS = 10 };
#define EACH_BLOCK for (int n = 0; n < blocks; n++)
#define EACH_PAIR for (int k = 0; k < 2 * blocks; k++)
#endif

/* Keys of all rounds of Philox; they follow from the seed. */
typedef struct LANE(draw_keys) {
  LANE(bits) round[DRAW_ROUNDS][2];
} LANE(draw_keys);

LANE_INLINE void LANE(draw_keys_from)(LANE(draw_keys) * keys, LANE(bits) seed) {
  LANE(bits) k0 = seed & 0xffffffffu, k1 = seed >> 32;
  for (int n = 0; n < DRAW_ROUNDS; n++) {
    keys->round[n][0] = k0;
    keys->round[n][1] = k1;
    k0 = k0 + 0x9E3779B9u;
    k1 = k1 + 0xBB67AE85u;
  }
}

/* Performs round number `round` of Philox on all blocks. Each word is in the low half of a 64-bit
 * lane; the high halves are not cleared between rounds, because the multiplication ignores them. */
LANE_INLINE void LANE(philox_round)(LANE(bits) word[DRAW_BLOCKS][4], int blocks,
                                    const LANE(draw_keys) * keys, int round) {
  const LANE(bits) m0 = LANE(splat_bits)(0xD2511F53u), m1 = LANE(splat_bits)(0xCD9E8D57u);
  EACH_BLOCK {
    LANE(bits) p0 = LANE(multiply32)(m0, word[n][0]), p1 = LANE(multiply32)(m1, word[n][2]);
    word[n][0] = (p1 >> 32) ^ word[n][1] ^ keys->round[round][0];
    word[n][1] = p1;
    word[n][2] = (p0 >> 32) ^ word[n][3] ^ keys->round[round][1];
    word[n][3] = p0;
  }
}

/* Converts the bits of w that the mask `bits` selects to a number: they are set into the low bits
 * of the double with the bit pattern `above` (2^52 or 2^20, plus a small offset), and `less` is
 * subtracted from this double. */
LANE_INLINE LANE(real)
    LANE(draw_integer)(LANE(bits) w, uint64_t bits, uint64_t above, double less) {
  return LANE(as_real)((w & bits) | above) - less;
}

/* Returns a, with its sign changed if the top bit of `sign` is set. */
LANE_INLINE LANE(real) LANE(draw_signed)(LANE(real) a, LANE(bits) sign) {
  return LANE(as_real)(LANE(as_bits)(a) ^ (sign & 0x8000000000000000u));
}

/* Converts random words to normal numbers: block n gives the two pairs a[2 n], b[2 n] and a[2 n +
 * 1], b[2 n + 1]. Each stage is done for all pairs before the next one, so that their operations
 * overlap.
 *
 * Radius sqrt(-2 log u): u = 2^e m with m in [1, 2), log m = log(2)/2 + 2 artanh s, s = (m - sqrt
 * 2)/(m + sqrt 2); the last six bits of the exponent field are turned into the double e + 127.
 *
 * Direction: bits 31 and 0 of the second word are the signs of b and a. The other bits are the
 * angle y in the quarter turn, measured from its middle in units of pi/4 2^-30; sin, cos (pi/4 + y)
 * = (cos y +- sin y)/sqrt 2. */
LANE_INLINE void LANE(draw_pairs)(LANE(bits) word[DRAW_BLOCKS][4], int blocks,
                                  LANE(real) a[2 * DRAW_BLOCKS], LANE(real) b[2 * DRAW_BLOCKS]) {
  LANE(real) e[2 * DRAW_BLOCKS], s[2 * DRAW_BLOCKS], z[2 * DRAW_BLOCKS], r[2 * DRAW_BLOCKS];
  LANE(real)
  y[2 * DRAW_BLOCKS], y2[2 * DRAW_BLOCKS], sine[2 * DRAW_BLOCKS], cosine[2 * DRAW_BLOCKS];
  EACH_PAIR {
    LANE(bits) w = word[k / 2][k % 2 * 2];
    LANE(bits)
    u = LANE(as_bits)(LANE(draw_integer)(w, 0xffffffffu, 0x4130000000000000u, 0x1p20 - 0x1p-33));
    LANE(real) m = LANE(as_real)((u & 0x000fffffffffffffu) | 0x3ff0000000000000u);
    e[k] = LANE(as_real)(((u >> 6) & 0x000fc00000000000u) | 0x4050000000000000u);
    e[k] = e[k] * -1.3862943611198906 + 175.36623668166615;
    s[k] = (m - 1.4142135623730951) / (m + 1.4142135623730951);
  }
  EACH_PAIR {
    LANE(bits) w = word[k / 2][k % 2 * 2 + 1];
    y[k] = LANE(draw_integer)(w, 0x7ffffffeu, 0x4330000000000001u, 0x1p52 + 0x1p30);
    y2[k] = y[k] * y[k];
  }
  EACH_PAIR z[k] = s[k] * s[k];
  EACH_PAIR r[k] = z[k] * 0.6059718801708838 + 0.799107137885716;
  EACH_PAIR r[k] = r[k] * z[k] + 1.333342151036247;
  EACH_PAIR r[k] = r[k] * z[k] + 3.9999999749625847;
  EACH_PAIR r[k] = LANE(sqrt)(e[k] - s[k] * r[k]);
  EACH_PAIR sine[k] = y2[k] * -1.5417187701525703e-68 + 1.233566788418012e-48;
  EACH_PAIR cosine[k] = y2[k] * 1.4126596383949316e-78 + -1.5039091358906426e-58;
  EACH_PAIR sine[k] = sine[k] * y2[k] + -4.612145575284185e-29;
  EACH_PAIR cosine[k] = cosine[k] * y2[k] + 8.433993963622884e-39;
  EACH_PAIR sine[k] = (sine[k] * y2[k] + 5.172196399367735e-10) * y[k];
  EACH_PAIR cosine[k] = cosine[k] * y2[k] + -1.8916249171333352e-19;
  EACH_PAIR cosine[k] = cosine[k] * y2[k] + 0.707106781153031;
  EACH_PAIR {
    LANE(bits) w = word[k / 2][k % 2 * 2 + 1];
    a[k] = r[k] * LANE(draw_signed)(cosine[k] - sine[k], w << 63);
    b[k] = r[k] * LANE(draw_signed)(cosine[k] + sine[k], w << 32);
  }
}

/* Computes the normal numbers of `blocks` blocks: 2 * blocks pairs a, b. word: Philox counters of
 * the blocks; overwritten. */
LANE_INLINE void LANE(draw_normals)(LANE(bits) word[DRAW_BLOCKS][4], int blocks,
                                    const LANE(draw_keys) * keys, LANE(real) a[2 * DRAW_BLOCKS],
                                    LANE(real) b[2 * DRAW_BLOCKS]) {
#pragma GCC unroll 10
  for (int round = 0; round < DRAW_ROUNDS; round++) LANE(philox_round)(word, blocks, keys, round);
  LANE(draw_pairs)(word, blocks, a, b);
}

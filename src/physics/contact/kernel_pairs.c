/* kernel_pairs.c: one evaluation of all candidate pairs; compiled once per instruction set.
 *
 * Pairs of round bodies (disks and round walls) are evaluated in whole blocks, pairs with wall
 * segments in vectors or one by one.
 */
#include <stddef.h>

#include "physics/system/halo.h"
#include "physics/contact/walls.h"
#include "physics/contact/pairs.h"
#include "physics/contact/walls.h"
#include "physics/system/box.h"
#include "physics/system/bodies.h"
#include "physics/system/kernel_path.h"
#include "physics/system/kernels.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "physics/contact/contact_step.h"
#include "physics/contact/pair_pass.h"
#include "physics/contact/segment_pass.h"
#undef LANE_WIDTH
#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "physics/contact/contact_step.h"
#include "physics/contact/pair_pass.h"
#include "physics/contact/segment_pass.h"

void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end);

/* Number of vectors in a block of pairs. While the contact law of one block is evaluated, the
 * distances of the next block (with square root and division) are computed. The code does this
 * explicitly, since processors look only some hundred instructions ahead and would not overlap the
 * two by themselves. */
enum { BLOCK_VECTORS = PAIR_BLOCK / VECTOR_WIDTH };
#define AT(block, v) ((LANE(location)){(block), (v)*VECTOR_WIDTH})

/* Constants for prefetching the pairs that are AHEAD blocks later; hardware prefetchers do not
 * foresee them. Only some twenty cache lines can be in flight at a time, so each vector requests a
 * part of the lines. PAPER_LINES: number of cache lines of a block before its column `law`; LINES:
 * number of those before the last two columns of the record, which only the paper's variant uses.
 * FETCH is a macro, because compilers remove a function that does nothing but prefetch. */
enum {
  AHEAD = 9,
  PAPER_LINES = offsetof(pair_block, law) / 64,
  LINES = offsetof(pair_block, turned) / 64
};
#define FETCH(block, v)                                                                            \
  for (size_t line = lines * (v) / BLOCK_VECTORS; line < lines * ((v) + 1) / BLOCK_VECTORS;        \
       line++)                                                                                     \
  __builtin_prefetch((const char *)(block) + 64 * line, 0, 3)

/* Evaluates `blocks` blocks of pairs of round bodies, beginning with block *b. */
LANE_INLINE void round_pairs(engine *e, thread_work *mine, pair_block *b, size_t blocks,
                             const int kind) {
  const LANE(pass_constants) constants = LANE(pass_constants_of)(&e->work);
  const size_t lines = kind & PASS_PAPER ? PAPER_LINES : LINES;
  LANE(pair_distance) d[BLOCK_VECTORS];
  double *sum = e->work.sums.row;
  pair_flags *flags = e->work.pairs.flags + (b - e->work.pairs.block);
  for (size_t v = 0; v < BLOCK_VECTORS; v++) LANE(distance)(&e->work, AT(b, v), kind, &d[v]);
  for (size_t k = 0; k < blocks; k++, b++, flags++) {
    pair_block *next = k + 1 < blocks ? b + 1 : b;
#pragma GCC unroll 4
    for (size_t v = 0; v < BLOCK_VECTORS; v++) {
      LANE(contact_evaluate)(e, mine, AT(b, v), AT(next, v), flags, &d[v], &constants, sum, kind);
      FETCH(b + AHEAD, v);
    }
  }
}

/* Evaluates the pairs with wall segments in [begin, end). Vectors start at multiples of
 * VECTOR_WIDTH. Pairs before the first and after the last whole vector are evaluated one by one,
 * since other pairs in their vectors may belong to another thread. */
static __attribute__((noinline)) void segments(engine *e, thread_work *mine, size_t begin,
                                               size_t end) {
  size_t at = begin;
  while (at < end && at % VECTOR_WIDTH) evaluate_segments_w1(e, mine, at++);
  for (; at + VECTOR_WIDTH <= end; at += VECTOR_WIDTH) LANE(evaluate_segments)(e, mine, at);
  while (at < end) evaluate_segments_w1(e, mine, at++);
}

/* Compiles a copy of round_pairs for one kind of pass, so that unused features cost no time. */
#define COPY(kind)                                                                                 \
  case kind:                                                                                       \
    round_pairs(e, mine, w->pairs.block + begin / PAIR_BLOCK, (end - begin) / PAIR_BLOCK, kind);   \
    break
void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end) {
  const work *w = &e->work;
  if (begin >= end) return;
  if (pairs_is_segment(&w->pairs, begin)) {
    assert(end <= w->pairs.count);
    segments(e, mine, begin, end);
    return;
  }
  assert(begin % PAIR_BLOCK == 0 && end % PAIR_BLOCK == 0 && end <= w->pairs.first_segment);
  const int laws = w->features & LAW_GENERAL ? PASS_GENERAL
                   : w->features             ? PASS_MIXED
                   : w->one_law              ? 0
                                             : PASS_LAWS;
  switch ((w->conservative ? 0 : PASS_PAPER) | laws | (w->cell.on ? PASS_CELL : 0)) {
    COPY(0);
    COPY(PASS_PAPER);
    COPY(PASS_LAWS);
    COPY(PASS_PAPER | PASS_LAWS);
    COPY(PASS_MIXED);
    COPY(PASS_PAPER | PASS_MIXED);
    COPY(PASS_CELL);
    COPY(PASS_CELL | PASS_PAPER);
    COPY(PASS_CELL | PASS_LAWS);
    COPY(PASS_CELL | PASS_PAPER | PASS_LAWS);
    COPY(PASS_CELL | PASS_MIXED);
    COPY(PASS_CELL | PASS_PAPER | PASS_MIXED);
    COPY(PASS_GENERAL);
    COPY(PASS_PAPER | PASS_GENERAL);
    COPY(PASS_CELL | PASS_GENERAL);
    COPY(PASS_CELL | PASS_PAPER | PASS_GENERAL);
  }
}

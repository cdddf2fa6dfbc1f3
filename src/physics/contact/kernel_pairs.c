/* kernel_pairs.c: forces and commits of all candidate pairs; compiled once per instruction set.
 *
 * Round pairs (disks, round walls) go in whole blocks, pieces of straight walls in vectors or one by one.
 */
#include <stddef.h>

#include "physics/system/kernel_path.h"
#include "physics/system/kernels.h"
#include "physics/contact/walls.h"

#define LANE_WIDTH 1
#include "base/lane.h"
#include "physics/contact/law.h"
#include "physics/contact/pair_pass.h"
#include "physics/contact/piece_pass.h"
#undef LANE_WIDTH
#define LANE_WIDTH VECTOR_WIDTH
#include "base/lane.h"
#include "physics/contact/law.h"
#include "physics/contact/pair_pass.h"
#include "physics/contact/piece_pass.h"

void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end, int pass);

/* Round pairs go block by block. What is seen of a vector of the next one, its root and its division, is under way beside
 * the law of this one: processors look only some hundred instructions ahead, and these must not all wait for a root. */
enum { BLOCK_VECTORS = PAIR_BLOCK / VECTOR_WIDTH };
#define PLACE(block, v) ((LANE(place)){(block), (v)*VECTOR_WIDTH})

/* The columns of a later block are on their way meanwhile: processors do not foresee them, and have room for some twenty
 * lines at a time, so that each vector asks for some. (Not a function: one that only fetches is taken for one that does
 * nothing.) */
enum { LINES = offsetof(pair_block, acted) / 64, AHEAD = 9 };
#define FETCH(block, v)                                                                                      \
  for (size_t line = LINES * (v) / BLOCK_VECTORS; line < LINES * ((v) + 1) / BLOCK_VECTORS; line++)          \
  __builtin_prefetch((const char *)(block) + 64 * line, 0, 3)

LANE_INLINE void round_pairs(engine *e, thread_work *mine, pair_block *b, size_t blocks, const int kind) {
  const LANE(pass_constants) one = LANE(pass_constants_of)(&e->work);
  LANE(law_sight) seen[BLOCK_VECTORS];
  double *sum = e->work.sums.row;
  for (size_t v = 0; v < BLOCK_VECTORS; v++) LANE(see)(&e->work, PLACE(b, v), &seen[v]);
  for (size_t k = 0; k < blocks; k++, b++) {
    pair_block *next = k + 1 < blocks ? b + 1 : b;
#pragma GCC unroll 4
    for (size_t v = 0; v < BLOCK_VECTORS; v++) {
      LANE(meet)(e, mine, PLACE(b, v), PLACE(next, v), &seen[v], &one, sum, kind);
      FETCH(b + AHEAD, v);
    }
  }
}

/* Whole vectors, as they stand in their blocks: the others' lanes may be another thread's. */
static __attribute__((noinline)) void some_pieces(engine *e, thread_work *mine, size_t begin, size_t end,
                                                  int pass) {
  size_t at = begin;
  while (at < end && at % VECTOR_WIDTH) meet_pieces_w1(e, mine, at++, pass);
  for (; at + VECTOR_WIDTH <= end; at += VECTOR_WIDTH) LANE(meet_pieces)(e, mine, at, pass);
  while (at < end) meet_pieces_w1(e, mine, at++, pass);
}

LANE_INLINE void all_pairs(engine *e, thread_work *mine, size_t begin, size_t end, const int kind) {
  const pairs *p = &e->work.pairs;
  const size_t round_end = end < p->first_piece ? end : p->first_piece;
  if (begin < round_end)
    round_pairs(e, mine, p->block + begin / PAIR_BLOCK, (round_end - begin) / PAIR_BLOCK, kind);
  else if (begin < end)
    some_pieces(e, mine, begin, end, kind & (PASS_FORCE | PASS_COMMIT));
}

/* A copy for each kind of pass, so that what it does not do costs nothing. */
#define COPY(kind)                                                                                           \
  case kind:                                                                                                 \
    all_pairs(e, mine, begin, end, kind);                                                                    \
    break
#define COPIES(kind)                                                                                         \
  COPY(kind | PASS_FORCE);                                                                                   \
  COPY(kind | PASS_COMMIT);                                                                                  \
  COPY(kind | PASS_FORCE | PASS_COMMIT)
void KERNEL(kernel_pairs)(engine *e, thread_work *mine, size_t begin, size_t end, int pass) {
  const work *w = &e->work;
  switch (pass | (w->conservative ? 0 : PASS_VARIANT) | (w->one_law ? 0 : PASS_LAWS)) {
    COPIES(0);
    COPIES(PASS_VARIANT);
    COPIES(PASS_LAWS);
    COPIES(PASS_VARIANT | PASS_LAWS);
  }
}

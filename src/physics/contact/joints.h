/* joints.h: pieces of walls that meet: of which of them a disk touches the joint, and a contact that goes from one to the next. */
#ifndef PHYSICS_JOINTS_H
#define PHYSICS_JOINTS_H

#include "physics/contact/walls.h"

/* Of several pieces that meet in point q of pair k's piece, is it this one that the disk touches there? */
bool joints_own(const engine *e, size_t pair, const nearest_point *q);
/* The same for any point of piece g, that of pair k: joints are near its ends only. */
static inline bool joints_active(const engine *e, size_t pair, const placed_segment *g,
                                 const nearest_point *q) {
  if (!g->shared || !q->active) return q->active;
  const double on = q->arc - g->arc, near = 1e-6 * e->state->radius[e->work.pairs.a[pair]];
  const bool straight = q->flat && g->piece == SD_PIECE_STRAIGHT;
  if (straight ? on >= near && on <= g->length - near : !g->meets) return true;
  return joints_own(e, pair, q);
}
/* Pair k is about to open or begin, `closed` says which. If its disk goes from one piece to the next here, the contact goes along with all that
 * it remembers: nothing opens, and nothing begins. */
bool joints_hand_over(engine *e, size_t pair, bool closed);
/* R_b of a round wall and of an arc (negative inside), 0 of straight pieces and ends. k: a closed contact with a piece, or a
 * round pair. */
double joints_radius(const engine *e, size_t pair);

#endif

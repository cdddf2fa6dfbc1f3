/* kernels.h: table of the loops that are compiled once per instruction set and chosen at run time.
 *
 * All instruction sets give the same bits: no fused multiply-add, no reassociation.
 */
#ifndef PHYSICS_KERNELS_H
#define PHYSICS_KERNELS_H

#include "physics/system/work.h"

typedef struct motion_kernels motion_kernels; /* defined in physics/motion/motion_kernels.h */

typedef struct kernels {
  const char *name;
  /* Evaluates the pairs [begin, end) once: adds contact forces to the force sums of the bodies, and
   * updates the contact history. The range consists either of whole blocks of pairs of round
   * bodies, or of pairs with wall segments. */
  void (*pairs)(engine *e, thread_work *mine, size_t begin, size_t end);
  /* If chunks reuse rows of packed bodies (chunks.shares), each call of gather, pack, predict,
   * correct or fields for free disks must stay within one chunk. */
  /* Writes the contact forces on bodies [begin, end) from the force sums to force_x, force_y and
   * torque in the state. The torque on a straight wall is about its pivot. */
  void (*gather)(engine *e, size_t begin, size_t end);
  /* Packs bodies [begin, end): copies their poses to the rows that the pair loop reads, and clears
   * their force sums. */
  void (*pack)(engine *e, size_t begin, size_t end);
  /* True if a free disk in [begin, end) has moved too far since the neighbour list was built.
   * ahead: steps after which it is to be there, moving as it does now; 0: its present position. */
  bool (*stale)(const engine *e, size_t begin, size_t end, double ahead);
  /* Predictor and corrector for free disks [begin, end); the index is an sd_integrator. The
   * predictor also packs the disks; the corrector first gathers their contact forces. */
  void (*predict[2])(engine *e, size_t begin, size_t end);
  void (*correct[2])(engine *e, thread_work *mine, size_t begin, size_t end);
  /* Evaluates the deck's force fields (fields.h) on free disks [begin, end); their contact forces
   * must be in the state. */
  void (*fields)(engine *e, size_t begin, size_t end);
  /* `lanes` makes n steps of one or of lane_width small systems, one system per vector lane
   * (lanes.h). */
  size_t lane_width;
  void (*lanes)(lanes *l, int64_t n);
  const motion_kernels *motion;
} kernels;

/* Returns the kernels of the fastest instruction set that this machine supports, or of the one that
 * the environment variable SLIPDISK_PATH names (baseline, avx2 or avx512) if it can run here. */
const kernels *kernels_choose(void);
/* Returns the kernels of the instruction set with this name; NULL if they were not built or cannot
 * run here. */
const kernels *kernels_named(const char *name);

#endif

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
  /* Evaluates pairs [begin, end) once: adds the forces to the sums, and writes the history. A range
   * has whole blocks of round pairs, or wall segments, not both. */
  void (*pairs)(engine *e, thread_work *mine, size_t begin, size_t end);
  /* If chunks share rows of packed bodies (chunks.shares), a call of gather, pack, predict, correct
   * or fields for free disks must stay within one chunk. */
  /* Writes the force sums of bodies [begin, end) to force_x, force_y and torque in the state. The
   * torque on a straight wall is about its pivot. */
  void (*gather)(engine *e, size_t begin, size_t end);
  /* Packs the bodies [begin, end) from their poses, and clears their force sums. */
  void (*pack)(engine *e, size_t begin, size_t end);
  /* True if a free disk in [begin, end) has moved too far since the neighbour list was built.
   * ahead: true to test the position after the next step instead of the present one. */
  bool (*stale)(const engine *e, size_t begin, size_t end, bool ahead);
  /* Predictor and corrector of free disks [begin, end), indexed by sd_integrator. The predictor
   * packs the disks; the corrector gathers their force sums first. */
  void (*predict[2])(engine *e, size_t begin, size_t end);
  void (*correct[2])(engine *e, thread_work *mine, size_t begin, size_t end);
  /* Evaluates the model's force fields (fields.h) on free disks [begin, end); their contact forces
   * must be in the state. */
  void (*fields)(engine *e, size_t begin, size_t end);
  /* `lanes` makes n steps of small systems side by side (lanes.h), lane_width of them or one. */
  size_t lane_width;
  void (*lanes)(lanes *l, int64_t n);
  const motion_kernels *motion;
} kernels;

/* Returns the kernels of the fastest instruction set that this machine supports, or those named by
 * the environment variable SLIPDISK_PATH (baseline, avx2 or avx512) if they can run here. */
const kernels *kernels_choose(void);
/* Returns the kernels of an instruction set by name; NULL if they were not built or cannot run
 * here. */
const kernels *kernels_named(const char *name);

#endif

/* kernels.h: the loops that are compiled once per instruction set and chosen at run time.
 *
 * All paths give the same bits: no fused multiply-add, no reassociation.
 */
#ifndef PHYSICS_KERNELS_H
#define PHYSICS_KERNELS_H

#include "physics/system/work.h"

typedef struct motion_kernels motion_kernels; /* physics/motion */

typedef struct kernels {
  const char *name;
  /* Evaluates pairs [begin, end) once: forces are added to the sums, history is written. Round pairs go in whole blocks,
   * and not together with wall segments. */
  void (*pairs)(engine *e, thread_work *mine, size_t begin, size_t end);
  /* Here and below, but for stale: of free disks those of one chunk at a time, where chunks share rows. */
  /* Bodies [begin, end): the sums to force_x, force_y, torque. That of a straight wall is about its pivot. */
  void (*gather)(engine *e, size_t begin, size_t end);
  /* Packs the bodies [begin, end) from their poses; clears the forces on them. */
  void (*pack)(engine *e, size_t begin, size_t end);
  /* Has a free disk of [begin, end) moved too far since the lists were built; ahead: will it have, after a step? */
  bool (*stale)(const engine *e, size_t begin, size_t end, bool ahead);
  /* Free disks [begin, end), by sd_integrator; predict packs them, correct gathers first. */
  void (*predict[2])(engine *e, size_t begin, size_t end);
  void (*correct[2])(engine *e, thread_work *mine, size_t begin, size_t end);
  /* The model's fields (fields.h) on free disks [begin, end), whose forces of contacts are in the state. */
  void (*fields)(engine *e, size_t begin, size_t end);
  /* n steps of small systems side by side (lanes.h), lane_width of them or one. */
  size_t lane_width;
  void (*lanes)(lanes *l, int64_t n);
  const motion_kernels *motion;
} kernels;

/* The fastest path that this machine runs; SLIPDISK_PATH=baseline|avx2|avx512 asks for another. */
const kernels *kernels_choose(void);
/* A path by name, NULL when it was not built or does not run here. */
const kernels *kernels_named(const char *name);

#endif

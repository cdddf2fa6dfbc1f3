/* strides.h: how far motions move bodies in one step, known before the run. */
#ifndef SLIPDISK_MODEL_STRIDES_H
#define SLIPDISK_MODEL_STRIDES_H

#include "model/model.h"

/* Part of limits.displacement from which on a body jumps: it goes farther than its velocities take it. */
#define STRIDES_JUMP 0.1

/* The distance of a wall's farthest given point from its pivot; 0 of round ones, which turn into themselves, and of disks. */
double strides_arm(const sd_model *model, uint32_t body);

/* A body, how far it goes in a step over the radius of the smallest free disk, and the motion that takes it
 * farthest. */
typedef struct stride {
  uint32_t body;
  size_t motion;
  double length;
} stride;

/* The body that goes farthest while its motions run together. False: none moves, or no memory (shortage.h). */
bool strides_longest(const sd_model *model, stride *longest);
/* May a step take some prescribed body to the limit of displacement, or may it jump? Only then a run looks at them. */
bool strides_are_long(const sd_model *model);
/* The jump with which a motion begins, at the farthest point of the bodies it moves, over that radius; 0 of a surface and of
 * disks that turn. */
double strides_first_jump(const sd_model *model, size_t motion);

#endif

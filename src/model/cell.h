/* cell.h: the shape of the periodic box in a state.
 *
 * Images of a position are h n away, with h = ((Lx, offset), (0, Ly)) and whole numbers n. All are kept over the lengths that the
 * box has without deformation: those of the model times state->box_scale; the offset over that of x.
 */
#ifndef MODEL_CELL_H
#define MODEL_CELL_H

#include "model/state.h"

enum { CELL_X, CELL_Y, CELL_OFFSET, CELL_SHEAR, CELL_COLUMNS };

/* Does any phase deform the box? */
static inline bool cell_deforms(const sd_model *m) {
  for (size_t k = 0; k < m->n_phases; k++)
    if (m->phases[k].cell.asked) return true;
  return false;
}

/* A periodic box is longer than this: no pair of disks that may touch or attract each other has two images within reach. reach:
 * the gap over which disks attract each other, or NULL. */
double cell_least_length(const sd_model *m, double *reach);

/* Errors of phases that do. */
void cell_check(const sd_model *m, sd_messages *messages);

/* Length of region and box along c over that of the model. */
static inline double cell_scale(const sd_state *s, int c) {
  return s->n_cell ? s->box_scale * s->cell[c] : s->box_scale;
}

/* How far a row of cells is shifted against the one below. */
static inline double cell_offset(const sd_model *m, const sd_state *s) {
  return s->n_cell ? s->box_scale * s->cell[CELL_OFFSET] * (m->upper[0] - m->lower[0]) : 0.0;
}

/* Velocity gradient of the box: xx, yy, xy. */
static inline void cell_gradient_of(const sd_model *m, const sd_state *s,
                                    double g[SD_CELL_COMPONENTS]) {
  for (int k = 0; k < SD_CELL_COMPONENTS; k++) g[k] = 0.0;
  if (!s->n_cell) return;
  const double aspect = (m->upper[0] - m->lower[0]) / (m->upper[1] - m->lower[1]);
  g[SD_CELL_XX] = s->cell_speed[CELL_X] / s->cell[CELL_X];
  g[SD_CELL_YY] = s->cell_speed[CELL_Y] / s->cell[CELL_Y];
  g[SD_CELL_XY] = aspect * (s->cell_speed[CELL_OFFSET] - g[SD_CELL_XX] * s->cell[CELL_OFFSET]) /
                  s->cell[CELL_Y];
}

#endif

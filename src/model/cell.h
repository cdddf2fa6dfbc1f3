/* cell.h: the shape of a deforming periodic box in a state.
 *
 * The images of a position are displaced by h n with h = ((Lx, offset), (0, Ly)) and integers n.
 * The state stores Lx and Ly divided by the lengths of the box without deformation, which are the
 * model's times state->box_scale, and the offset divided by this length in x.
 */
#ifndef MODEL_CELL_H
#define MODEL_CELL_H

#include "model/model.h"
#include "model/state.h"

/* Indices of the numbers that describe the shape of a deforming box: length along x, length
 * along y, offset in x between a row of images and the row below it, shear strain. */
enum { CELL_X, CELL_Y, CELL_OFFSET, CELL_SHEAR, CELL_COLUMNS };

/* True if any phase of the run deforms the periodic box. */
static inline bool cell_deforms(const sd_model *m) {
  for (size_t k = 0; k < m->n_phases; k++)
    if (m->phases[k].cell.asked) return true;
  return false;
}

/* Collective. Returns the length that a periodic box must exceed so that no two disks that can
 * touch or attract each other have two images within range. *reach (may be NULL): the gap over
 * which disks attract each other. */
double cell_least_length(const sd_model *m, double *reach);

/* Reports errors of phases that deform the box. */
void cell_check(const sd_model *m, sd_messages *messages);

/* True if both phases deform the box, and in the same way. */
static inline bool cell_alike(const sd_phase *one, const sd_phase *next) {
  const sd_cell *a = &one->cell, *b = &next->cell;
  bool same = a->asked && b->asked && a->response == b->response && a->max_rate == b->max_rate &&
              a->boundary == b->boundary;
  for (int k = 0; k < SD_CELL_COMPONENTS; k++)
    same = same && a->controlled[k] == b->controlled[k] &&
           (a->controlled[k] ? a->stress[k] == b->stress[k] : a->rate[k] == b->rate[k]);
  return same;
}

/* Length of the region or periodic box along coordinate c, divided by its length in the model. */
static inline double cell_scale(const sd_state *s, int c) {
  return s->n_cell ? s->box_scale * s->cell[c] : s->box_scale;
}

/* Distance in x by which a row of periodic images is displaced against the row below it. */
static inline double cell_offset(const sd_model *m, const sd_state *s) {
  return s->n_cell ? s->box_scale * s->cell[CELL_OFFSET] * (m->upper[0] - m->lower[0]) : 0.0;
}

/* Computes the velocity gradient of a deforming box in g: components xx, yy, xy, 1/time. */
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

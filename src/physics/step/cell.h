/* cell.h: a periodic box that deforms (sd_cell in slipdisk/model.h): its shape as a function of the
 * step, the velocity changes of disks when its rates change, its stress control, and its work.
 *
 * Velocities are those of the laboratory frame: an image n cells away moves with h' n (h: matrix of
 * the box vectors), and a disk that is wrapped into the box changes its velocity by that. While the
 * rates are constant, h is linear in time, so that all images obey the same equations of motion:
 * the flow needs no thermostat. Rates change between steps, every CELL_EVERY steps. Unless
 * `boundary` is set, each disk then changes its velocity by (L_new - L_old) r, with L the velocity
 * gradient, which leaves the relative velocities of images unchanged (docs/physics.md).
 */
#ifndef PHYSICS_CELL_H
#define PHYSICS_CELL_H

#include "physics/system/work.h"

/* Number of steps between changes of the rates. */
enum { CELL_EVERY = 8 };

/* Gives the box, the lists and the state's box columns the shape of this step. */
void cell_pose(engine *e, int64_t step);
/* Sets the box variables of a new engine's work from the state. */
void cell_attach(engine *e);
/* Sets the deformation rates of the phase that has just begun. */
void cell_begin(engine *e);
/* Measures the stress and adjusts the rates; call it between steps, every CELL_EVERY steps of a
 * phase with a deforming box, when the forces in the state are new. Returns SD_ERROR_NUMERIC if the
 * box has become too narrow. */
sd_status cell_change(engine *e, sd_messages *messages);
/* Sums the contact forces across the box edges after a step, and books the work of the box. start:
 * only the forces, at step 0. Returns SD_ERROR_IO if memory runs out. */
sd_status cell_work(engine *e, bool start);
/* Completes the wrap of a free disk by (nx, ny) cells in a deforming box; the caller changes its
 * position. Changes its velocity, the sums of forces across the edges and its position in the
 * lists, and books the work. */
void cell_wrap(engine *e, uint32_t slot, double nx, double ny);

/* cell_renew sums the forces across the edges anew after disks were added or removed. cell_enter
 * stores the position from which the nonaffine displacement of the disk in this slot, which is new,
 * is measured. */
void cell_renew(engine *e);
void cell_enter(engine *e, uint32_t slot);

/* Returns true if each controlled stress is within `part` times the largest wanted stress of its
 * own wanted value; also if the phase has no deforming box. */
bool cell_near(const engine *e, double part);

/* Writes the present velocity gradient of the box: xx, yy, xy components, 1/time. */
void cell_gradient(const engine *e, double gradient[SD_CELL_COMPONENTS]);

#endif

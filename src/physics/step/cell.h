/* cell.h: a periodic box that deforms (sd_cell in slipdisk/model.h). This file has its shape at
 * each step, the velocity changes of disks when its rates change, the control of its stress, and
 * its work.
 *
 * Velocities are those of the laboratory frame: a periodic image n cells away moves with h' n (h:
 * matrix of the box vectors, h': its time derivative), and a disk that is wrapped into the box
 * changes its velocity by that. While the rates are constant, h is linear in time, so that all
 * images obey the same equations of motion: the flow needs no thermostat. Rates change between
 * steps, every CELL_EVERY steps. Unless `boundary` is set, each disk at r then changes its velocity
 * by (L_new - L_old) r, with L the velocity gradient, which leaves the relative velocities of
 * images unchanged (docs/physics.md).
 */
#ifndef PHYSICS_CELL_H
#define PHYSICS_CELL_H

#include "model/cell.h"
#include "physics/system/work.h"

/* Number of steps between two changes of the deformation rates. */
enum { CELL_EVERY = 8 };

/* Deforms the box to its shape at this step; updates the box variables in work and state, and the
 * limits for which the neighbour lists are valid. */
void cell_pose(engine *e, int64_t step);
/* Sets the box variables in the work of a new engine from its state. */
void cell_attach(engine *e);
/* Sets the deformation rates of the phase that has just begun. */
void cell_begin(engine *e);
/* Measures the stress and adjusts the deformation rates. To be called between steps, every
 * CELL_EVERY steps of a phase with a deforming box, when the forces in the state are up to date.
 * Returns SD_ERROR_NUMERIC if the box has become too narrow. */
sd_status cell_change(engine *e, sd_messages *messages);
/* Sums the contact forces across the box edges after a step, and adds the work of the box in this
 * step to the energy balance. start: true at step 0, to sum only the forces. Returns SD_ERROR_IO if
 * memory runs out. */
sd_status cell_work(engine *e, bool start);
/* Completes the wrap of a free disk by (nx, ny) cells in a deforming box, after the caller has
 * changed the disk's position. Changes the disk's velocity, the sums of forces across the edges and
 * the disk's position in the lists, and adds the change of energy to the work of the box. */
void cell_wrap(engine *e, uint32_t slot, double nx, double ny);

/* cell_renew sums the forces across the box edges anew, after disks were added or removed.
 * cell_enter is for a new disk in this slot: it stores the position from which the disk's nonaffine
 * displacement is measured. */
void cell_renew(engine *e);
void cell_enter(engine *e, uint32_t slot);

/* Returns true if each controlled stress differs from its wanted value by at most `part` times the
 * largest wanted stress, and also if the phase has no deforming box. */
bool cell_near(const engine *e, double part);

/* Writes the present velocity gradient of the box to gradient[]: components xx, yy, xy, unit:
 * 1/time. */
void cell_gradient(const engine *e, double gradient[SD_CELL_COMPONENTS]);

#endif

/* cell.h: a periodic box that deforms (sd_cell in slipdisk/model.h): its shape as a function of the step, the velocities that
 * disks take up when its rates change, the stress that they follow, and its work.
 *
 * Velocities are those of the laboratory: an image n cells away moves with h' n, and so does a disk that is taken back into the
 * box. While the rates stand, h is linear in time, so that all images obey the same equations of motion: the flow needs no
 * thermostat. Rates change between steps, by CELL_EVERY steps; unless `boundary` is set each disk then changes its velocity by
 * (L_new - L_old) r, which leaves relative velocities of images as they are (docs/physics.md).
 */
#ifndef PHYSICS_CELL_H
#define PHYSICS_CELL_H

#include "physics/system/work.h"

/* Steps between changes of the rates. */
enum { CELL_EVERY = 8 };

/* Box and lists at the shape of this step, into the state, too. */
void cell_pose(engine *e, int64_t step);
/* Work of a new engine. */
void cell_attach(engine *e);
/* A phase has begun: its rates. */
void cell_begin(engine *e);
/* Between steps, every CELL_EVERY of a phase with a cell, with the forces in the state. SD_ERROR_NUMERIC: the box has become
 * too narrow. */
sd_status cell_change(engine *e, sd_messages *messages);
/* After the forces of a step: its work; start: of step 0, the forces alone. SD_ERROR_IO: no memory. */
sd_status cell_work(engine *e, bool start);
/* A free disk goes back by (nx, ny) cells: its velocity, and what follows from it. Before it is there. */
void cell_wrap(engine *e, uint32_t slot, double nx, double ny);

/* After disks have come or gone: forces across the edges, and where the one in this slot, which is new, begins. */
void cell_renew(engine *e);
void cell_enter(engine *e, uint32_t slot);

/* Are the stresses that the phase asks for there, within this part of the largest of them? */
bool cell_near(const engine *e, double part);

/* Velocity gradient at present: xx, yy, xy. */
void cell_gradient(const engine *e, double gradient[SD_CELL_COMPONENTS]);

#endif

/* steer.h: changes that the calling program makes to bodies between two steps, and the evaluation
 * of the changed system. */
#ifndef PHYSICS_STEER_H
#define PHYSICS_STEER_H

#include "physics/system/work.h"

/* Sets a coordinate of a free disk (SD_X, SD_Y, SD_THETA) or its velocity. slot: slot of the disk.
 * Higher derivatives of this coordinate, which Gear's integrator uses, restart at 0. Contacts stay
 * as they are: call steer_end_contacts before positions change. */
void steer_place(engine *e, size_t slot, int coordinate, double value);
void steer_speed(engine *e, size_t slot, int coordinate, double value);
/* Sets the radius, mass and moment of inertia of a free disk; its higher derivatives restart at
 * 0. */
void steer_size(engine *e, size_t slot, double radius, double mass, double inertia);

/* Ends the contacts of all disks with moved[slot], moved: [n_free]. They begin anew, with relaxed
 * springs, if the disks still touch. Returns SD_ERROR_IO if memory runs out. */
sd_status steer_end_contacts(engine *e, const bool *moved);
/* Changes lambda_ref and rho_ref of the closed contacts of disks with changed[slot], changed:
 * [n_free], so that their displacements zeta and rho stay as they were before radii were changed.
 * */
void steer_keep_displacements(engine *e, const bool *changed);

/* Holds or releases the free disk with this number, between two steps. Held coordinates
 * (sd_disk.holds) lose their velocity. Call bodies_fill_constants and motion_resume afterwards.
 * SD_ERROR_IO: no memory. */
sd_status steer_hold(engine *e, uint32_t disk, bool hold);
/* Returns true if the present phase holds or releases disks. */
bool steer_is_due(const engine *e);
/* Holds and releases the disks that the present phase names, as it begins. SD_ERROR_IO: no
 * memory. */
sd_status steer_begin_phase(engine *e);

/* Evaluates forces and accelerations after bodies or constants were changed, and adds the change of
 * the energy budget's residual to the work, so that the residual stays as it was. holds: disks were
 * held or released; the change is then energy that they brought or took along (`start`). residual:
 * its value before the change. Collective; statuses as those of rescale (step.h). */
sd_status steer_finish(engine *e, double residual, bool holds, sd_messages *messages);

#endif

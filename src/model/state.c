/* state.c: the table of state columns, and the functions that loop over it: allocation, hash and
 * comparison of states. */
#include "model/state.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "model/cell.h"
#include "model/model.h"
#include "model/walls.h"
#include "slipdisk/deck.h"

#define COLUMN(name, type, extent, unit, meaning)                                                  \
  { #name, type, extent, offsetof(sd_state, name), unit, meaning }

const sd_field sd_fields[] = {
    COLUMN(step, SD_I64, SD_PER_RUN, "1", "steps completed since the start"),
    COLUMN(phase, SD_I64, SD_PER_RUN, "1", "index of the running phase"),
    COLUMN(phase_step, SD_I64, SD_PER_RUN, "1", "steps completed in this phase"),
    COLUMN(work_driven, SD_F64, SD_PER_RUN, "energy",
           "work done by prescribed bodies and coordinates"),
    COLUMN(energy_start, SD_F64, SD_PER_RUN, "energy",
           "kinetic, elastic and external energy at step 0"),
    COLUMN(measured, SD_I64, SD_PER_RUN, "1", "steps measured"),
    COLUMN(bin_steps, SD_I64, SD_PER_RUN, "1", "steps per bin of the angle record"),
    COLUMN(bins, SD_I64, SD_PER_RUN, "1", "full bins of the angle record"),
    COLUMN(box_scale, SD_F64, SD_PER_RUN, "1", "lengths of the region over those of the deck"),
    COLUMN(field_power, SD_F64, SD_PER_RUN, "power",
           "power of force fields at the end of the last step"),
    COLUMN(relaxed, SD_F64, SD_PER_RUN, "energy", "taken out by the relaxer"),
    COLUMN(relax_alpha, SD_F64, SD_PER_RUN, "1", "how far the relaxer steers velocities"),
    COLUMN(relax_steps, SD_I64, SD_PER_RUN, "1",
           "steps downhill since the relaxer stopped the disks"),
    COLUMN(released, SD_I64, SD_PER_RUN, "1", "disks that rain has let go"),
    COLUMN(outside, SD_I64, SD_PER_RUN, "1", "times that a disk left the bounds"),
    COLUMN(mean_samples, SD_I64, SD_PER_RUN, "1", "looks at the contacts for the means of disks"),
    COLUMN(mean_bin_steps, SD_I64, SD_PER_RUN, "1", "steps per bin of the disks' angle records"),
    COLUMN(mean_bins, SD_I64, SD_PER_RUN, "1", "full bins of the disks' angle records"),
    COLUMN(
        fast_step, SD_I64, SD_PER_RUN, "1",
        "first step after which a free disk was faster than limits.displacement allows, -1: none"),
    COLUMN(fast_disk, SD_I64, SD_PER_RUN, "1", "body number of that disk, -1: none"),
    COLUMN(fast_displacement, SD_F64, SD_PER_RUN, "1", "its displacement per step over its radius"),

    COLUMN(id, SD_U32, SD_PER_BODY, "1", "body number: disks as in the deck, then walls"),
    COLUMN(x, SD_F64, SD_PER_BODY, "length", "x of the centre or pivot, in the box"),
    COLUMN(y, SD_F64, SD_PER_BODY, "length", "y of the centre or pivot, in the box"),
    COLUMN(theta, SD_F64, SD_PER_BODY, "rad", "angle beyond turn, within [-4, 4]"),
    COLUMN(turn, SD_F64, SD_PER_BODY, "rad", "angle in multiples of 8 rad"),
    COLUMN(vx, SD_F64, SD_PER_BODY, "length/time", "velocity along x"),
    COLUMN(vy, SD_F64, SD_PER_BODY, "length/time", "velocity along y"),
    COLUMN(omega, SD_F64, SD_PER_BODY, "rad/time", "angular velocity, counter-clockwise positive"),
    COLUMN(image_x, SD_I32, SD_PER_BODY, "1", "periodic images crossed along x"),
    COLUMN(image_y, SD_I32, SD_PER_BODY, "1", "periodic images crossed along y"),
    COLUMN(radius, SD_F64, SD_PER_BODY, "length",
           "radius; negative for a drum, 0 for a straight wall"),
    COLUMN(mass, SD_F64, SD_PER_BODY, "mass", "mass; 0 for walls"),
    COLUMN(inertia, SD_F64, SD_PER_BODY, "mass length^2", "moment of inertia; 0 for walls"),
    COLUMN(material, SD_I32, SD_PER_BODY, "1", "index into the materials"),
    COLUMN(group, SD_I32, SD_PER_BODY, "1", "index into the groups, -1: none"),
    COLUMN(base_x, SD_F64, SD_PER_BODY, "length", "prescribed x without the running motions"),
    COLUMN(base_y, SD_F64, SD_PER_BODY, "length", "prescribed y without the running motions"),
    COLUMN(base_theta, SD_F64, SD_PER_BODY, "rad", "prescribed angle without the running motions"),
    COLUMN(force_x, SD_F64, SD_PER_BODY, "force", "x force of the contacts at the last step"),
    COLUMN(force_y, SD_F64, SD_PER_BODY, "force", "y force of the contacts at the last step"),
    COLUMN(torque, SD_F64, SD_PER_BODY, "force length", "torque of the contacts at the last step"),
    COLUMN(loss_viscous, SD_F64, SD_PER_BODY, "energy",
           "lost to viscosity in this body's contacts"),
    COLUMN(loss_friction, SD_F64, SD_PER_BODY, "energy", "lost to sliding in this body's contacts"),
    COLUMN(loss_opening, SD_F64, SD_PER_BODY, "energy",
           "left in this body's contacts when they opened"),
    COLUMN(nonconservative_work, SD_F64, SD_PER_BODY, "energy",
           "put in by the paper's tangential force"),
    COLUMN(past_viscous, SD_F64, SD_PER_BODY, "energy",
           "of loss_viscous: in contacts that have ended"),
    COLUMN(past_friction, SD_F64, SD_PER_BODY, "energy",
           "of loss_friction: in contacts that have ended"),
    COLUMN(past_nonconservative_work, SD_F64, SD_PER_BODY, "energy",
           "of nonconservative_work: in contacts that have ended"),

    COLUMN(surface, SD_F64, SD_PER_SURFACE, "length",
           "way of the wall's surface along it beyond surface_turn"),
    COLUMN(surface_turn, SD_F64, SD_PER_SURFACE, "length",
           "the rest of it, in multiples of a fixed length"),
    COLUMN(surface_speed, SD_F64, SD_PER_SURFACE, "length/time",
           "velocity of the wall's surface along it"),
    COLUMN(surface_force, SD_F64, SD_PER_SURFACE, "force",
           "of the contacts on the surface at the last step"),
    COLUMN(base_surface, SD_F64, SD_PER_SURFACE, "length",
           "prescribed way without the running motions"),

    COLUMN(activity, SD_I32, SD_PER_FREE, "1",
           "0 in play, 1 waiting, 2 removed, 3 outside the bounds, 4 held"),
    COLUMN(x2, SD_F64, SD_PER_FREE, "length", "dt^2/2 times the 2nd derivative of x"),
    COLUMN(y2, SD_F64, SD_PER_FREE, "length", "dt^2/2 times the 2nd derivative of y"),
    COLUMN(theta2, SD_F64, SD_PER_FREE, "rad", "dt^2/2 times the 2nd derivative of the angle"),
    COLUMN(x3, SD_F64, SD_PER_FREE, "length", "dt^3/6 times the 3rd derivative of x"),
    COLUMN(y3, SD_F64, SD_PER_FREE, "length", "dt^3/6 times the 3rd derivative of y"),
    COLUMN(theta3, SD_F64, SD_PER_FREE, "rad", "dt^3/6 times the 3rd derivative of the angle"),
    COLUMN(x4, SD_F64, SD_PER_FREE, "length", "dt^4/24 times the 4th derivative of x"),
    COLUMN(y4, SD_F64, SD_PER_FREE, "length", "dt^4/24 times the 4th derivative of y"),
    COLUMN(theta4, SD_F64, SD_PER_FREE, "rad", "dt^4/24 times the 4th derivative of the angle"),
    COLUMN(x5, SD_F64, SD_PER_FREE, "length", "dt^5/120 times the 5th derivative of x"),
    COLUMN(y5, SD_F64, SD_PER_FREE, "length", "dt^5/120 times the 5th derivative of y"),
    COLUMN(theta5, SD_F64, SD_PER_FREE, "rad", "dt^5/120 times the 5th derivative of the angle"),

    COLUMN(field_x, SD_F64, SD_PER_FIELDED, "force",
           "x force of the model's fields at the last step"),
    COLUMN(field_y, SD_F64, SD_PER_FIELDED, "force",
           "y force of the model's fields at the last step"),
    COLUMN(field_torque, SD_F64, SD_PER_FIELDED, "force length",
           "torque of the model's fields at the last step"),
    COLUMN(power_work, SD_F64, SD_PER_FIELDED, "power",
           "at which fields do work on the disk, at the last step"),
    COLUMN(power_drag, SD_F64, SD_PER_FIELDED, "power", "lost to drag, at the last step"),
    COLUMN(power_damping, SD_F64, SD_PER_FIELDED, "power",
           "lost to non-viscous damping, at the last step"),
    COLUMN(field_work, SD_F64, SD_PER_FIELDED, "energy", "work of the model's fields on the disk"),
    COLUMN(loss_drag, SD_F64, SD_PER_FIELDED, "energy", "lost to drag"),
    COLUMN(loss_damping, SD_F64, SD_PER_FIELDED, "energy", "lost to non-viscous damping"),

    COLUMN(contact_a, SD_U32, SD_PER_CONTACT, "1", "body number of the first disk"),
    COLUMN(contact_b, SD_U32, SD_PER_CONTACT, "1", "body number of the second disk or wall"),
    COLUMN(contact_part, SD_U32, SD_PER_CONTACT, "1", "straight piece of the wall"),
    COLUMN(contact_side, SD_F64, SD_PER_CONTACT, "1", "side of a straight wall, 0: round"),
    COLUMN(contact_slide, SD_I32, SD_PER_CONTACT, "1",
           "0 stuck, +1/-1 sliding with that sign of torque"),
#define RECORD_COLUMN(name, unit, meaning)                                                         \
  COLUMN(contact_##name, SD_F64, SD_PER_CONTACT, unit, meaning),
    SD_CONTACT_RECORD(RECORD_COLUMN)
#undef RECORD_COLUMN
#define MORE_COLUMN(name, unit, meaning, laws)                                                     \
  COLUMN(contact_##name, SD_F64, SD_PER_LAW_CONTACT, unit, meaning),
        SD_CONTACT_MORE(MORE_COLUMN)
#undef MORE_COLUMN
            COLUMN(past_rolling, SD_F64, SD_PER_LAW_FREE, "energy",
                   "lost to rolling in this disk's contacts that have ended"),
    COLUMN(loss_bridge, SD_F64, SD_PER_LAW_FREE, "energy", "lost when bridges of this disk formed"),
    COLUMN(broken_tension, SD_F64, SD_PER_LAW_FREE, "energy",
           "of this disk's bonds that broke by tension"),
    COLUMN(broken_shear, SD_F64, SD_PER_LAW_FREE, "energy", "of those that broke by shear"),
    COLUMN(broken_bending, SD_F64, SD_PER_LAW_FREE, "energy", "of those that broke by bending"),
    COLUMN(break_step, SD_I64, SD_PER_BREAK, "1", "step in which the bond broke"),
    COLUMN(break_a, SD_U32, SD_PER_BREAK, "1", "body number of the first disk"),
    COLUMN(break_b, SD_U32, SD_PER_BREAK, "1", "body number of the second disk or wall"),
    COLUMN(break_mode, SD_I32, SD_PER_BREAK, "1", "1 tension, 2 shear, 3 bending"),
    COLUMN(break_x, SD_F64, SD_PER_BREAK, "length", "x of the contact then"),
    COLUMN(break_y, SD_F64, SD_PER_BREAK, "length", "y of the contact then"),
    COLUMN(break_energy, SD_F64, SD_PER_BREAK, "energy", "elastic energy of the bond then"),

    COLUMN(motion_start, SD_I64, SD_PER_MOTION, "1",
           "step at which the motion was switched on, -1: off"),
    COLUMN(motion_u0, SD_F64, SD_PER_MOTION, "length or rad",
           "random motion: displacement at the last draw; load, servo: displacement"),
    COLUMN(motion_v0, SD_F64, SD_PER_MOTION, "1/time",
           "random motion: velocity at the last draw; load, servo: velocity"),
    COLUMN(motion_u1, SD_F64, SD_PER_MOTION, "length or rad",
           "random motion: displacement at the next draw; servo: smoothed force"),
    COLUMN(motion_v1, SD_F64, SD_PER_MOTION, "1/time", "random motion: velocity at the next draw"),

    COLUMN(cell, SD_F64, SD_PER_CELL, "1",
           "lengths in x, y, offset of rows of cells over the lengths before (x), shear strain"),
    COLUMN(cell_start, SD_F64, SD_PER_CELL, "1", "the same at step cell_from"),
    COLUMN(cell_from, SD_I64, SD_PER_CELL, "1", "step from which on cell grows at cell_speed"),
    COLUMN(cell_speed, SD_F64, SD_PER_CELL, "1/time", "change of cell per time"),
    COLUMN(cell_force, SD_F64, SD_PER_CELL, "force",
           "forces across the edges of the box: sum of force times cells between, xx, xy, yx, yy"),
    COLUMN(cell_mean, SD_F64, SD_PER_CELL, "1/time",
           "running means of rates that follow stresses: xx, yy, xy"),
    COLUMN(cell_u, SD_F64, SD_PER_CELL_DISK, "1",
           "place in the box along x, when displacements were added up"),
    COLUMN(cell_v, SD_F64, SD_PER_CELL_DISK, "1", "place in the box along y, likewise"),
    COLUMN(nonaffine_x, SD_F64, SD_PER_CELL_DISK, "length",
           "x displacement since the phase began, without that of the deforming box"),
    COLUMN(nonaffine_y, SD_F64, SD_PER_CELL_DISK, "length", "y displacement, likewise"),

    COLUMN(phase_steps, SD_I64, SD_PER_PHASE, "1", "steps that the phase took, 0: not over"),
    COLUMN(phase_reached, SD_I32, SD_PER_PHASE, "1",
           "1: ended with what settle and compress asked for"),
    COLUMN(phase_kinetic, SD_F64, SD_PER_PHASE, "energy",
           "kinetic energy per disk at the end of a settling"),
    COLUMN(phase_unbalanced, SD_F64, SD_PER_PHASE, "1",
           "unbalanced force at the end of a settling"),
    COLUMN(phase_target, SD_F64, SD_PER_PHASE, "force/length or 1",
           "pressure or packing fraction reached"),

    COLUMN(rotation_start, SD_F64, SD_PER_ROTATION, "rad", "angle when measuring began"),
    COLUMN(rotation_bin, SD_F64, SD_PER_ROTATION_BIN, "rad", "angle turned in each full bin"),
    COLUMN(rotation_last, SD_F64, SD_PER_ROTATION, "rad", "angle at the end of the last full bin"),
    COLUMN(rotation_stop, SD_F64, SD_PER_ROTATION, "rad", "angle when measuring last stopped"),
    COLUMN(slide_count, SD_I64, SD_PER_SLIDE_COUNT, "1",
           "steps in each configuration of two contacts"),
    COLUMN(slide_force_min, SD_F64, SD_PER_SLIDE_CONTACT, "force", "smallest normal force"),
    COLUMN(slide_openings, SD_I64, SD_PER_SLIDE_CONTACT, "1", "times the contact opened"),
    COLUMN(slide_was_open, SD_I32, SD_PER_SLIDE_CONTACT, "1", "contact was open at the last step"),

    COLUMN(visit_class, SD_I32, SD_PER_VISIT, "1",
           "sliding configuration of two contacts, -1: none yet"),
    COLUMN(visit_since, SD_I64, SD_PER_VISIT, "1", "measured steps when it began, -1: before"),
    COLUMN(visit_from, SD_I64, SD_PER_VISIT, "1", "measured steps from which on visit_part sums"),
    COLUMN(visit_reference, SD_F64, SD_PER_VISIT_CONTACT, "force",
           "normal force that sums leave out"),
    COLUMN(visit_part, SD_F64, SD_PER_VISIT_PART, "mixed",
           "sums of torque, forces, squares, since visit_from"),
    COLUMN(visit_sum, SD_F64, SD_PER_VISIT_SUM, "mixed",
           "the same in each configuration, until visit_from"),
    COLUMN(visit_count, SD_I64, SD_PER_VISIT_CLASS, "1",
           "visits to each configuration, begun and ended"),
    COLUMN(visit_steps, SD_I64, SD_PER_VISIT_CLASS, "1", "steps of these visits"),
    COLUMN(visit_steps2, SD_F64, SD_PER_VISIT_CLASS, "1", "sum of their squared steps"),
    COLUMN(visit_age_torque, SD_F64, SD_PER_VISIT_AGE, "force length",
           "sum of torques by age of the visit"),
    COLUMN(visit_age_steps, SD_I64, SD_PER_VISIT_AGE, "1", "steps by age of the visit"),

    COLUMN(mean_angle, SD_F64, SD_PER_MEAN, "rad", "angle when measuring began"),
    COLUMN(mean_last, SD_F64, SD_PER_MEAN, "rad", "angle at the end of the last full bin"),
    COLUMN(mean_stop, SD_F64, SD_PER_MEAN, "rad", "angle when measuring last stopped"),
    COLUMN(mean_bin, SD_F64, SD_PER_MEAN_BIN, "rad", "angle turned in each full bin"),
    COLUMN(mean_x0, SD_F64, SD_PER_MEAN, "length",
           "absolute x when measuring began; NAN: not in play"),
    COLUMN(mean_y0, SD_F64, SD_PER_MEAN, "length",
           "absolute y when measuring began; NAN: not in play"),
    COLUMN(sum_x, SD_F64, SD_PER_MEAN, "length", "sum of displacements along x"),
    COLUMN(sum_y, SD_F64, SD_PER_MEAN, "length", "sum of displacements along y"),
    COLUMN(sum_xx, SD_F64, SD_PER_MEAN, "length^2", "sum of squared displacements along x"),
    COLUMN(sum_yy, SD_F64, SD_PER_MEAN, "length^2", "sum of squared displacements along y"),
    COLUMN(sum_contacts, SD_F64, SD_PER_MEAN, "1", "sum of closed contacts"),
    COLUMN(sum_sliding, SD_F64, SD_PER_MEAN, "1", "sum of sliding contacts"),
    COLUMN(sum_force, SD_F64, SD_PER_MEAN, "force", "sum of normal forces"),
    COLUMN(sum_injected, SD_F64, SD_PER_MEAN, "power", "sum of the power of prescribed bodies"),
    COLUMN(sum_kinetic, SD_F64, SD_PER_MEAN, "energy", "sum of kinetic energies of translation"),
    COLUMN(sum_spin, SD_F64, SD_PER_MEAN, "energy", "sum of kinetic energies of rotation"),
    COLUMN(sum_viscous, SD_F64, SD_PER_MEAN, "energy",
           "lost to viscosity in measured phases; in one less what had been lost before"),
    COLUMN(sum_friction, SD_F64, SD_PER_MEAN, "energy", "lost to sliding, likewise"),
    COLUMN(sum_opening, SD_F64, SD_PER_MEAN, "energy", "left in contacts that opened, likewise"),
    COLUMN(sum_openings, SD_I64, SD_PER_MEAN, "1", "contacts that opened in measured steps"),

    COLUMN(clump_x, SD_F64, SD_PER_CLUMP, "length", "x of the centre of mass, in the box"),
    COLUMN(clump_y, SD_F64, SD_PER_CLUMP, "length", "y of the centre of mass, in the box"),
    COLUMN(clump_theta, SD_F64, SD_PER_CLUMP, "rad", "angle beyond clump_turn, within [-4, 4]"),
    COLUMN(clump_turn, SD_F64, SD_PER_CLUMP, "rad", "angle in multiples of 8 rad"),
    COLUMN(clump_vx, SD_F64, SD_PER_CLUMP, "length/time", "velocity of the centre along x"),
    COLUMN(clump_vy, SD_F64, SD_PER_CLUMP, "length/time", "velocity of the centre along y"),
    COLUMN(clump_omega, SD_F64, SD_PER_CLUMP, "rad/time", "angular velocity"),
    COLUMN(clump_image_x, SD_I32, SD_PER_CLUMP, "1", "periodic images crossed along x"),
    COLUMN(clump_image_y, SD_I32, SD_PER_CLUMP, "1", "periodic images crossed along y"),
    COLUMN(clump_base_x, SD_F64, SD_PER_CLUMP, "length",
           "prescribed x without the running motions"),
    COLUMN(clump_base_y, SD_F64, SD_PER_CLUMP, "length",
           "prescribed y without the running motions"),
    COLUMN(clump_base_theta, SD_F64, SD_PER_CLUMP, "rad",
           "prescribed theta without the running motions"),
    COLUMN(clump_force_x, SD_F64, SD_PER_CLUMP, "force",
           "x force of the contacts at the last step"),
    COLUMN(clump_force_y, SD_F64, SD_PER_CLUMP, "force",
           "y force of the contacts at the last step"),
    COLUMN(clump_torque, SD_F64, SD_PER_CLUMP, "force length",
           "torque of the contacts about the centre at the last step"),
    COLUMN(clump_x2, SD_F64, SD_PER_CLUMP, "length", "dt^2/2 times the 2nd derivative of x"),
    COLUMN(clump_y2, SD_F64, SD_PER_CLUMP, "length", "dt^2/2 times the 2nd derivative of y"),
    COLUMN(clump_theta2, SD_F64, SD_PER_CLUMP, "rad",
           "dt^2/2 times the 2nd derivative of the angle"),
    COLUMN(clump_x3, SD_F64, SD_PER_CLUMP, "length", "dt^3/6 times the 3rd derivative of x"),
    COLUMN(clump_y3, SD_F64, SD_PER_CLUMP, "length", "dt^3/6 times the 3rd derivative of y"),
    COLUMN(clump_theta3, SD_F64, SD_PER_CLUMP, "rad",
           "dt^3/6 times the 3rd derivative of the angle"),
    COLUMN(clump_x4, SD_F64, SD_PER_CLUMP, "length", "dt^4/24 times the 4th derivative of x"),
    COLUMN(clump_y4, SD_F64, SD_PER_CLUMP, "length", "dt^4/24 times the 4th derivative of y"),
    COLUMN(clump_theta4, SD_F64, SD_PER_CLUMP, "rad",
           "dt^4/24 times the 4th derivative of the angle"),
    COLUMN(clump_x5, SD_F64, SD_PER_CLUMP, "length", "dt^5/120 times the 5th derivative of x"),
    COLUMN(clump_y5, SD_F64, SD_PER_CLUMP, "length", "dt^5/120 times the 5th derivative of y"),
    COLUMN(clump_theta5, SD_F64, SD_PER_CLUMP, "rad",
           "dt^5/120 times the 5th derivative of the angle"),

    COLUMN(average_rows, SD_I64, SD_PER_AVERAGE, "1", "measured rows of the series in average_bin"),
    COLUMN(average_missing, SD_I64, SD_PER_AVERAGE, "1",
           "measured rows left out: a number was not finite"),
    COLUMN(average_last, SD_F64, SD_PER_AVERAGE_FORM, "mixed",
           "sum of the columns in rate() in the last row of the series"),
    COLUMN(average_bin, SD_F64, SD_PER_AVERAGE_BIN, "mixed",
           "sums over rows of numerator and denominator in each bin of rows"),
};

const size_t sd_field_count = sizeof sd_fields / sizeof *sd_fields;

size_t sd_type_size(sd_type type) {
  static const size_t size[] = {[SD_F64] = 8, [SD_I64] = 8, [SD_I32] = 4, [SD_U32] = 4};
  assert((size_t)type < sizeof size / sizeof *size);
  return size[type];
}

size_t sd_extent_size(const sd_state *s, sd_extent extent) {
  switch (extent) {
    case SD_PER_RUN: return 1;
    case SD_PER_BODY: return s->n_bodies;
    case SD_PER_FREE: return s->n_free;
    case SD_PER_FIELDED: return s->n_fielded;
    case SD_PER_SURFACE: return s->n_surfaces;
    case SD_PER_CONTACT: return s->n_contacts;
    case SD_PER_MOTION: return s->n_motions;
    case SD_PER_CELL: return s->n_cell;
    case SD_PER_CELL_DISK: return s->n_cell_disks;
    case SD_PER_PHASE: return s->n_phases;
    case SD_PER_ROTATION: return s->n_rotations;
    case SD_PER_ROTATION_BIN: return s->n_rotations * SD_BINS;
    case SD_PER_SLIDE: return s->n_slides;
    case SD_PER_SLIDE_COUNT: return s->n_slides * 16;
    case SD_PER_SLIDE_CONTACT: return s->n_slides * 2;
    case SD_PER_MEAN: return s->n_means;
    case SD_PER_MEAN_BIN: return s->n_means * SD_MEAN_BINS;
    case SD_PER_VISIT: return s->n_visits;
    case SD_PER_VISIT_CONTACT: return s->n_visits * 2;
    case SD_PER_VISIT_PART: return s->n_visits * VISIT_SUMS;
    case SD_PER_VISIT_CLASS: return s->n_visits * VISIT_CLASSES;
    case SD_PER_VISIT_SUM: return s->n_visits * VISIT_CLASSES * VISIT_SUMS;
    case SD_PER_VISIT_AGE: return s->n_visits * VISIT_CLASSES * VISIT_AGES;
    case SD_PER_CLUMP: return s->n_clumps;
    case SD_PER_LAW_CONTACT: return s->law_columns * s->n_contacts;
    case SD_PER_LAW_FREE: return s->law_columns * s->n_free;
    case SD_PER_BREAK: return s->n_breaks;
    case SD_PER_AVERAGE: return s->n_averages;
    case SD_PER_AVERAGE_FORM: return s->n_averages * 2;
    case SD_PER_AVERAGE_BIN: return s->n_averages * 2 * SD_BINS;
    case SD_EXTENTS: break;
  }
  assert(!"an extent");
  return 0;
}

void *sd_field_data(const sd_state *s, const sd_field *f) {
  char *at = (char *)(uintptr_t)s + f->offset;
  return f->extent == SD_PER_RUN ? (void *)at : *(void **)(void *)at;
}

/* Returns the address of the struct member that points to a column's data. */
static void **field_pointer(sd_state *s, const sd_field *f) {
  return (void **)(void *)((char *)s + f->offset);
}

/* Allocates a column of n zeroed elements, one per contact, padded to whole 64-byte vectors.
 * NULL: out of memory. */
static void *column_new(size_t n, sd_type type) {
  size_t bytes = (n * sd_type_size(type) + 127) / 64 * 64;
  void *p = memory_fits((double)bytes) ? aligned_alloc(64, bytes) : NULL;
  if (p) memset(p, 0, bytes);
  return p;
}

/* True if the column lies in the memory block s->columns, which all columns but those of
 * contacts and breaks share. */
static bool in_room(const sd_field *f) {
  return f->extent != SD_PER_RUN && f->extent != SD_PER_BREAK && !state_of_contacts(f->extent);
}

/* Allocates the memory block of all columns but those of contacts, and sets the pointers to
 * these columns. */
static sd_status columns_new(sd_state *s) {
  arena_plan plan = {0};
  for (size_t k = 0; k < sd_field_count; k++)
    if (in_room(&sd_fields[k]))
      arena_column(&plan, sd_extent_size(s, sd_fields[k].extent) * sd_type_size(sd_fields[k].type));
  char *room = s->columns = arena_new(&plan);
  if (!room) return SD_ERROR_IO;
  plan = (arena_plan){0};
  for (size_t k = 0; k < sd_field_count; k++)
    if (in_room(&sd_fields[k]))
      *field_pointer(s, &sd_fields[k]) =
          room + arena_column(&plan, sd_extent_size(s, sd_fields[k].extent) *
                                         sd_type_size(sd_fields[k].type));
  return SD_OK;
}

/* Arguments of a task for several threads that copies the columns to the new memory block of s. */
typedef struct spread_task {
  const sd_state *s;
  void **from; /* [sd_field_count] old address of each column */
} spread_task;

/* Copies the calling thread's range of rows of each column. */
static void copy_share(const team *t, void *with) {
  const spread_task *f = with;
  for (size_t k = 0; k < sd_field_count; k++) {
    if (!in_room(&sd_fields[k])) continue;
    const size_t size = sd_type_size(sd_fields[k].type);
    size_t begin, end;
    team_share(t, sd_extent_size(f->s, sd_fields[k].extent), &begin, &end);
    memcpy((char *)sd_field_data(f->s, &sd_fields[k]) + begin * size,
           (const char *)f->from[k] + begin * size, (end - begin) * size);
  }
}

void state_spread(sd_state *s, pool *c) {
  if (!c) return;
  void *room = s->columns, **from = memory_new(sd_field_count, sizeof *from);
  for (size_t k = 0; k < sd_field_count; k++) from[k] = sd_field_data(s, &sd_fields[k]);
  if (columns_new(s) == SD_OK) {
    pool_run(c, copy_share, &(spread_task){s, from});
    arena_free(room);
  } else {
    s->columns = room; /* the columns stay in the old memory block */
  }
  free(from);
}

sd_state *sd_state_new(const sd_model *m) { return state_new_part(m, m->n_free, 0); }

/* Sets the row counts of a state with n_free free disks and n_ghosts ghosts. */
static void set_extents(sd_state *s, const sd_model *m, size_t n_free, size_t n_ghosts) {
  s->n_free = n_free;
  s->n_ghosts = n_ghosts;
  s->n_disks = n_free + n_ghosts + (m->n_disks - m->n_free);
  s->n_bodies = s->n_disks + m->n_walls;
  s->n_surfaces = model_moves_surfaces(m) ? m->n_walls : 0;
  assert(s->n_free <= s->n_disks && s->n_disks <= s->n_bodies);
  s->n_cell = cell_deforms(m) ? CELL_COLUMNS : 0;
  s->n_cell_disks = s->n_cell ? n_free : 0;
  s->n_motions = m->n_motions;
  s->n_clumps = m->n_clumps;
  s->n_phases = m->n_phases;
  s->n_rotations = m->n_rotations;
  s->n_slides = m->n_slides;
  s->n_means = m->measure_disks ? n_free : 0;
  s->n_visits = m->measure_configurations ? m->n_slides : 0;
  s->n_fielded = m->n_fields ? n_free : 0;
  s->n_averages = m->n_averages;
  s->law_columns = (laws_features(m) & LAW_GENERAL) != 0;
}

sd_state state_sizes(const sd_model *m) {
  sd_state s = {0};
  set_extents(&s, m, m->n_free, 0);
  return s;
}

/* Returns the number of bytes in all columns of a state. */
static double bytes_of(const sd_state *s) {
  double bytes = 0;
  for (size_t k = 0; k < sd_field_count; k++)
    bytes += (double)(sd_extent_size(s, sd_fields[k].extent) * sd_type_size(sd_fields[k].type));
  return bytes;
}

double state_bytes(const sd_model *m, size_t contacts) {
  sd_state s = state_sizes(m);
  s.n_contacts = contacts;
  return bytes_of(&s);
}

size_t state_disk_bytes(bool free) {
  size_t bytes = sizeof(sd_disk);
  for (size_t k = 0; k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    if (f->extent == SD_PER_BODY || (free && f->extent == SD_PER_FREE))
      bytes += sd_type_size(f->type);
  }
  return bytes;
}

double state_least_bytes(const sd_model *m) {
  sd_state s = state_sizes(m);
  bool measured = false;
  for (size_t k = 0; k < m->n_phases; k++) measured |= m->phases[k].measure;
  /* without measured phases these columns are never written and take no memory */
  if (!measured) s.n_means = 0;
  return (double)(m->n_disks * sizeof(sd_disk)) + bytes_of(&s);
}

sd_status state_refuse(const sd_model *m, sd_messages *messages) {
  const double needed = state_least_bytes(m);
  if (memory_fits(needed)) return SD_OK;
  const char *path = m->deck ? m->deck->path : NULL;
  return sd_fail(
      messages, SD_ERROR_IO,
      "%s%sthe run needs at least %.3g GB of memory (%zu disks%s), and this process can have %.3g "
      "GB; expected "
      "fewer disks, another machine, or ranks of several machines (docs/cluster.md)",
      path ? path : "", path ? ": " : "", 1e-9 * needed, m->n_disks,
      m->measure_disks ? ", measure.disks = true" : "", 1e-9 * memory_limit(1));
}

sd_state *state_new_part(const sd_model *m, size_t n_free, size_t n_ghosts) {
  sd_state *s = memory_new(1, sizeof *s);
  set_extents(s, m, n_free, n_ghosts);
  s->bin_steps = s->mean_bin_steps = 1;
  s->box_scale = 1.0;
  s->fast_step = s->fast_disk = -1;
  if (columns_new(s) == SD_OK && sd_state_reserve_contacts(s, 8) == SD_OK) {
    if (s->n_cell)
      s->cell[CELL_X] = s->cell_start[CELL_X] = s->cell[CELL_Y] = s->cell_start[CELL_Y] = 1.0;
    return s;
  }
  sd_state_free(s);
  return NULL;
}

void sd_state_free(sd_state *s) {
  if (!s) return;
  for (size_t k = 0; k < sd_field_count; k++)
    if (sd_fields[k].extent != SD_PER_RUN && !in_room(&sd_fields[k]))
      free(*field_pointer(s, &sd_fields[k]));
  arena_free(s->columns);
  free(s);
}

/* Makes the columns that `grows` selects hold `capacity` rows, and keeps the first n rows. */
static sd_status grow_columns(sd_state *s, bool (*grows)(sd_extent extent), size_t n,
                              size_t capacity) {
  for (size_t k = 0; k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    if (!grows(f->extent)) continue;
    const bool kept = f->extent != SD_PER_LAW_CONTACT || s->law_columns;
    void *column = column_new(kept ? capacity : 0, f->type);
    if (!column) return SD_ERROR_IO;
    void **old = field_pointer(s, f);
    if (*old && kept) memcpy(column, *old, n * sd_type_size(f->type));
    free(*old);
    *old = column;
  }
  return SD_OK;
}

sd_status sd_state_reserve_contacts(sd_state *s, size_t n) {
  if (n <= s->contact_capacity) return SD_OK;
  assert(s->n_contacts <= s->contact_capacity);
  if (grow_columns(s, state_of_contacts, s->n_contacts, n + n / 4) != SD_OK) return SD_ERROR_IO;
  s->contact_capacity = n + n / 4;
  return SD_OK;
}

static bool of_breaks(sd_extent extent) { return extent == SD_PER_BREAK; }

sd_status state_reserve_breaks(sd_state *s, size_t n) {
  if (n <= s->break_capacity) return SD_OK;
  const size_t capacity = n + n / 4 + 8;
  if (grow_columns(s, of_breaks, s->n_breaks, capacity) != SD_OK) return SD_ERROR_IO;
  s->break_capacity = capacity;
  return SD_OK;
}

sd_status state_size_like(sd_state *s, const sd_state *other) {
  if (sd_state_reserve_contacts(s, other->n_contacts) != SD_OK ||
      state_reserve_breaks(s, other->n_breaks) != SD_OK)
    return SD_ERROR_IO;
  s->n_contacts = other->n_contacts;
  s->n_breaks = other->n_breaks;
  return SD_OK;
}

sd_contact_record sd_state_record(const sd_state *s, size_t c) {
  assert(c < s->n_contacts);
#define RECORD_READ(name, unit, meaning) .name = s->contact_##name[c],
  sd_contact_record record = {SD_CONTACT_RECORD(RECORD_READ)};
#undef RECORD_READ
#define MORE_READ(name, ...) record.name = s->contact_##name[c];
  if (s->law_columns) {
    SD_CONTACT_MORE(MORE_READ)
  }
#undef MORE_READ
  return record;
}

void sd_state_set_record(sd_state *s, size_t c, const sd_contact_record *record) {
  assert(c < s->n_contacts && s->n_contacts <= s->contact_capacity);
#define RECORD_WRITE(name, ...) s->contact_##name[c] = record->name;
  SD_CONTACT_RECORD(RECORD_WRITE)
  if (s->law_columns) {
    SD_CONTACT_MORE(RECORD_WRITE)
  }
#undef RECORD_WRITE
}

uint64_t state_hash_bytes(uint64_t hash, const void *data, size_t bytes) {
  const unsigned char *p = data;
  for (size_t b = 0; b < bytes; b++) hash = (hash ^ p[b]) * 1099511628211u;
  return hash;
}

uint64_t sd_state_hash(const sd_state *s) {
  uint64_t hash = STATE_HASH;
  for (size_t k = 0; k < sd_field_count; k++)
    hash =
        state_hash_bytes(hash, sd_field_data(s, &sd_fields[k]),
                         sd_extent_size(s, sd_fields[k].extent) * sd_type_size(sd_fields[k].type));
  return hash;
}

bool state_goes_on(const sd_model *m, const sd_state *s, phase_alike *alike) {
  return s->phase > 0 && alike(&m->phases[s->phase - 1], &m->phases[s->phase]);
}

int64_t state_steps_alike(const sd_model *m, const sd_state *s, phase_alike *alike) {
  int64_t n = s->phase_step;
  for (int64_t k = s->phase; k > 0 && alike(&m->phases[k - 1], &m->phases[k]); k--)
    n += s->phase_steps[k - 1];
  return n;
}

const sd_field *sd_state_difference(const sd_state *a, const sd_state *b) {
  for (size_t k = 0; k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    size_t n = sd_extent_size(a, f->extent);
    if (n != sd_extent_size(b, f->extent)) return f;
    if (n && memcmp(sd_field_data(a, f), sd_field_data(b, f), n * sd_type_size(f->type)) != 0)
      return f;
  }
  return NULL;
}

/* --- table of the slots of bodies, an array or a hash table ----------------------------------- */

void slot_table_free(slot_table *t) {
  free(t->slot);
  free(t->body);
  *t = (slot_table){0};
}

void slot_table_fill(slot_table *t, const sd_state *s) {
  for (uint32_t k = 0; t->body && k <= t->mask; k++) t->body[k] = SLOT_NONE;
  for (uint32_t i = 0; i < s->n_bodies; i++) {
    uint32_t k = t->body ? slot_table_home(t, s->id[i]) : s->id[i];
    assert(s->id[i] < t->n_bodies);
    while (t->body && t->body[k] != SLOT_NONE) {
      assert(t->body[k] != s->id[i]);
      k = (k + 1) & t->mask;
    }
    if (t->body) t->body[k] = s->id[i];
    t->slot[k] = i;
  }
  for (uint32_t c = 0; c < s->n_clumps; c++) t->slot[s->n_bodies + c] = (uint32_t)s->n_bodies + c;
}

bool slot_table_new(slot_table *t, const sd_state *s, size_t n_bodies) {
  size_t n = n_bodies + s->n_clumps, entries = 0;
  *t = (slot_table){.n_bodies = n_bodies};
  assert(s->n_bodies <= n_bodies && (s->n_bodies == n_bodies || s->n_clumps == 0));
  assert(s->n_bodies <= UINT32_MAX / 4);
  if (s->n_bodies < n_bodies) {
    t->shift = 31;
    for (n = 16; n < 2 * s->n_bodies; n *= 2) t->shift--;
    entries = n;
  }
  if (!memory_resize_row(&t->slot, n, sizeof *t->slot)) return false;
  if (entries > 0 && !memory_resize_row(&t->body, entries, sizeof *t->body)) {
    slot_table_free(t);
    return false;
  }
  t->mask = (uint32_t)(n - 1);
  slot_table_fill(t, s);
  return true;
}

/* --- sums of the visits to sliding configurations --------------------------------------------- */

double visits_left(const sd_state *s, size_t k, int64_t now) {
  int64_t since = s->visit_since[k];
  if (s->visit_class[k] == VISIT_NONE || since < 0) return HUGE_VAL;
  int b = visits_octave(s->visit_from[k] - since);
  return b < VISIT_AGES - 1 ? (double)(since + ((int64_t)VISIT_YOUNG << b) - now) : HUGE_VAL;
}

/* Ends the current part of the visit of pair k (see visits in state.h): adds its sums to those
 * of the visit's class, and begins a new part. */
static void end_part(sd_state *s, size_t k, const double *part, size_t stride, int64_t now) {
  size_t class = VISIT_CLASSES * k + (size_t)s->visit_class[k];
  double *sum = s->visit_sum + VISIT_SUMS * class;
  assert(s->visit_class[k] >= 0 && s->visit_class[k] < VISIT_CLASSES && now >= s->visit_from[k]);
  if (s->visit_since[k] >= 0) {
    size_t bin = VISIT_AGES * class + (size_t)visits_octave(s->visit_from[k] - s->visit_since[k]);
    s->visit_age_torque[bin] += part[VISIT_TORQUE * stride];
    s->visit_age_steps[bin] += now - s->visit_from[k];
  }
  for (size_t q = 0; q < VISIT_SUMS; q++) sum[q] += part[q * stride];
  s->visit_from[k] = now;
}

void visits_next(sd_state *s, size_t k, int class, const double *part, size_t stride, int64_t now) {
  const int was = s->visit_class[k];
  if (was != VISIT_NONE) end_part(s, k, part, stride, now);
  if (class == was) return;
  if (was != VISIT_NONE && s->visit_since[k] >= 0) {
    size_t ended = VISIT_CLASSES * k + (size_t)was;
    int64_t steps = now - s->visit_since[k];
    s->visit_count[ended]++;
    s->visit_steps[ended] += steps;
    s->visit_steps2[ended] += (double)steps * (double)steps;
  }
  s->visit_since[k] = was == VISIT_NONE ? -1 : now;
  s->visit_from[k] = now;
  s->visit_class[k] = class;
}

void visits_cut(sd_state *s, size_t k) {
  double *part = s->visit_part + VISIT_SUMS * k;
  if (s->measured > 0 && s->visit_class[k] != VISIT_NONE) end_part(s, k, part, 1, s->measured);
  memset(part, 0, VISIT_SUMS * sizeof *part);
  s->visit_class[k] = VISIT_NONE;
}

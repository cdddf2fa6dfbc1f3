/* series.c: tables of the quantities that a run records at regular intervals: energies, counts,
 * watched disks, bodies and contacts of frames. */
#include "base/math.h"
#include "measure/configuration.h"
#include "measure/observable.h"
#include "measure/stress.h"
#include "model/cell.h"
#include "model/laws.h"

/* --- energies --------------------------------------------------------------------------------- */

#define ENERGY(field, meaning, column)                                                             \
  {                                                                                                \
#field, "energy", meaning, OBSERVABLE_F64, 1, offsetof(sd_energy, field), NULL, column, NULL,  \
        NULL                                                                                       \
  }

static const observable energies[] = {
    ENERGY(kinetic_translation, "kinetic energy of the free coordinates, translation",
           "kinetic_translation"),
    ENERGY(kinetic_rotation, "kinetic energy of the free coordinates, rotation",
           "kinetic_rotation"),
    ENERGY(elastic_normal, "elastic energy of the normal springs", NULL),
    ENERGY(elastic_tangential, "elastic energy of the tangential springs", NULL),
    ENERGY(elastic_rolling, "elastic energy of the rolling springs", NULL),
    ENERGY(elastic_bond, "elastic energy of the bonds", NULL),
    ENERGY(cohesion, "energy of attraction between bodies, 0 where it ends", NULL),
    ENERGY(external, "potential energy of gravity and constant body forces", NULL),
    ENERGY(start, "sum of the energies above at step 0, and what disks brought or took along since",
           NULL),
    ENERGY(work,
           "work done by prescribed bodies and coordinates, by compression and deforming boxes, "
           "since step 0",
           "work"),
    ENERGY(
        nonconservative_work,
        "work of the paper's tangential force that does not derive from its energy, since step 0",
        NULL),
    ENERGY(viscous, "energy lost to viscosity since step 0", "viscous"),
    ENERGY(friction, "energy lost to sliding since step 0", "friction"),
    ENERGY(rolling, "energy lost to rolling friction since step 0", NULL),
    ENERGY(bridge, "energy lost when capillary bridges formed since step 0", NULL),
    ENERGY(opening, "energy left in contacts that opened since step 0", NULL),
    ENERGY(broken_tension, "elastic energy of bonds that broke by tension since step 0", NULL),
    ENERGY(broken_shear, "of those that broke by shear", NULL),
    ENERGY(broken_bending, "of those that broke by bending", NULL),
    ENERGY(drag, "energy lost to viscous drag of fields since step 0", NULL),
    ENERGY(damping, "energy lost to non-viscous damping since step 0", NULL),
    ENERGY(relaxed, "energy taken out by the relaxer since step 0", NULL),
    ENERGY(residual, "what the energy budget does not account for", NULL),
    ENERGY(scale, "larger of |work| + losses and kinetic energy, to compare the residual with",
           NULL),
};
const observable_list energy_observables = OBSERVABLES(
    "energy",
    "the energy budget: a series in /observables, at the end attributes of /summary/energy",
    energies);

/* --- other series ----------------------------------------------------------------------------- */

OBSERVABLE_GET(contacts, moment, (double)at->sums->contacts)
OBSERVABLE_GET(sliding_contacts, moment, (double)at->sums->sliding)
OBSERVABLE_GET(pressure, moment, at->sums->pressure)
OBSERVABLE_GET(packing_fraction, moment, at->sums->fraction)
OBSERVABLE_GET(outside, moment, (double)at->sums->outside)

static uint32_t watched(const moment *now, size_t k) {
  return slot_of(now->slots, now->model->rotations[k]);
}

static double watched_angle(const void *row, size_t k) {
  const moment *now = row;
  uint32_t slot = watched(now, k);
  return now->state->turn[slot] + now->state->theta[slot];
}

OBSERVABLE_GET(watched_spin, moment, at->state->omega[watched(at, k)])

OBSERVABLE_GET(width, moment, at->sums->width)
OBSERVABLE_GET(height, moment, at->sums->height)
OBSERVABLE_GET(rattlers, moment, (double)at->sums->rattlers)
OBSERVABLE_GET(z_backbone, moment, at->sums->z_backbone)
OBSERVABLE_GET(bonds, moment, (double)at->sums->bonds)
OBSERVABLE_GET(broken_bonds, moment, (double)at->state->n_breaks)
OBSERVABLE_GET(fragments, moment, (double)at->sums->fragments)
OBSERVABLE_GET(largest_fragment, moment, at->sums->largest_fragment)
OBSERVABLE_GET(stress_xx, moment, at->sums->stress[STRESS_XX])
OBSERVABLE_GET(stress_xy, moment, at->sums->stress[STRESS_XY])
OBSERVABLE_GET(stress_yx, moment, at->sums->stress[STRESS_YX])
OBSERVABLE_GET(stress_yy, moment, at->sums->stress[STRESS_YY])
OBSERVABLE_GET(kinetic_xx, moment, at->sums->kinetic[STRESS_XX])
OBSERVABLE_GET(kinetic_xy, moment, at->sums->kinetic[STRESS_XY])
OBSERVABLE_GET(kinetic_yy, moment, at->sums->kinetic[STRESS_YY])

/* Returns the logarithmic (Hencky) strain of the box along x or y. */
static double strain(const moment *at, int k) { return math_log(at->state->cell[k]); }
OBSERVABLE_GET(strain_xx, moment, strain(at, CELL_X))
OBSERVABLE_GET(strain_yy, moment, strain(at, CELL_Y))
OBSERVABLE_GET(strain_xy, moment, at->state->cell[CELL_SHEAR])
OBSERVABLE_GET(offset, moment, cell_offset(at->model, at->state))

/* Returns the standard deviation of x[] over the disks in play. Only differences between disks
 * matter, as the origin of a periodic box is arbitrary. */
static double deviation(const sd_state *s, const double *x) {
  double n = 0.0, mean = 0.0, sum = 0.0;
  for (size_t i = 0; i < s->n_cell_disks; i++) {
    if (!activity_is_present(s->activity[i])) continue;
    mean += x[i];
    n += 1.0;
  }
  mean /= n;
  for (size_t i = 0; i < s->n_cell_disks; i++)
    if (activity_is_present(s->activity[i])) sum += (x[i] - mean) * (x[i] - mean);
  return n > 0.0 ? sqrt(sum / n) : NAN;
}
OBSERVABLE_GET(nonaffine_x, moment, deviation(at->state, at->state->nonaffine_x))
OBSERVABLE_GET(nonaffine_y, moment, deviation(at->state, at->state->nonaffine_y))

static double cell_rate(const moment *at, int k) {
  double g[SD_CELL_COMPONENTS];
  cell_gradient_of(at->model, at->state, g);
  return g[k];
}
OBSERVABLE_GET(rate_xx, moment, cell_rate(at, SD_CELL_XX))
OBSERVABLE_GET(rate_yy, moment, cell_rate(at, SD_CELL_YY))
OBSERVABLE_GET(rate_xy, moment, cell_rate(at, SD_CELL_XY))

static bool asks_box(const sd_model *m) { return m->measure_box; }
static bool asks_stress(const sd_model *m) { return m->measure_stress; }
static bool asks_rattlers(const sd_model *m) { return m->measure_rattlers; }
static bool has_bonds(const sd_model *m) { return (laws_features(m) & LAW_BOND) != 0; }
static bool asks_fragments(const sd_model *m) { return m->measure_fragments; }
static bool asks_walls(const sd_model *m) { return m->measure_walls && m->n_walls > 0; }
static bool asks_groups(const sd_model *m) { return m->measure_groups && m->n_groups > 0; }
static bool asks_contacts(const sd_model *m) { return m->n_contact_disks > 0; }

const resultant *series_resultants(const observable *o, const moment *now) {
  switch (o->width) {
    case OBSERVABLE_WALLS: return now->sums->wall;
    case OBSERVABLE_GROUPS: return now->sums->group;
    case OBSERVABLE_CHOSEN: return now->sums->disk;
    default: return NULL;
  }
}

static bool has_bounds(const sd_model *m) { return m->bounds.given; }
static bool watches(const sd_model *m) { return m->n_rotations > 0; }

bool series_compresses(const sd_model *m) {
  if (cell_deforms(m)) return true;
  for (size_t k = 0; k < m->n_phases; k++)
    if (m->phases[k].compress.asked) return true;
  return false;
}

#define SERIES(name, unit, meaning, type, width, get, when)                                        \
  { name, unit, meaning, type, width, 0, get, NULL, NULL, when }

#define STRESS(name, meaning)                                                                      \
  SERIES(#name, "force/length", meaning, OBSERVABLE_F64, 1, name, asks_stress)
#define RESULTANT(name, unit, meaning, type, width, field, when)                                   \
  {                                                                                                \
    name, unit, meaning, OBSERVABLE_##type, width, offsetof(resultant, field), NULL, NULL, NULL,   \
        when                                                                                       \
  }
/* Table rows for the resultants of each wall, group or disk. one: text that names such a body;
 * about: text that names the reference point of its torque. */
#define RESULTANTS(prefix, one, about, width, when)                                                \
  RESULTANT(prefix "_force_x", "force", "x force of the contacts on each " one, F64, width,        \
            force_x, when),                                                                        \
      RESULTANT(prefix "_force_y", "force", "y force of the contacts on each " one, F64, width,    \
                force_y, when),                                                                    \
      RESULTANT(prefix "_torque", "force length", "their torque on it about " about, F64, width,   \
                torque, when),                                                                     \
      RESULTANT(prefix "_normal", "force", "sum of F_n of the contacts of each " one, F64, width,  \
                normal, when),                                                                     \
      RESULTANT(prefix "_tangential", "force",                                                     \
                "sum of their tau, positive where it turns disks counter-clockwise", F64, width,   \
                tangential, when),                                                                 \
      RESULTANT(prefix "_contacts", "1", "closed contacts of each " one, I64, width, contacts,     \
                when),                                                                             \
      RESULTANT(prefix "_sliding", "1", "of these, contacts that slide", I64, width, sliding,      \
                when)

static const observable others[] = {
    SERIES("contacts", "1", "closed contacts", OBSERVABLE_I64, 1, contacts, NULL),
    SERIES("sliding_contacts", "1", "closed contacts that slide", OBSERVABLE_I64, 1,
           sliding_contacts, NULL),
    SERIES("pressure", "force/length",
           "pressure of the contacts in the region (when a phase compresses or deforms)",
           OBSERVABLE_F64, 1, pressure, series_compresses),
    SERIES("packing_fraction", "1",
           "area of the free disks in play over that of the region (likewise)", OBSERVABLE_F64, 1,
           packing_fraction, series_compresses),
    SERIES("outside", "1", "disks beyond the bounds or taken out (with bounds)", OBSERVABLE_I64, 1,
           outside, has_bounds),
    SERIES("angle", "rad", "angle of each watched disk, not wrapped", OBSERVABLE_F64,
           OBSERVABLE_WATCHED, watched_angle, watches),
    SERIES("angular_velocity", "rad/time",
           "angular velocity of each watched disk, counter-clockwise positive", OBSERVABLE_F64,
           OBSERVABLE_WATCHED, watched_spin, watches),
    SERIES("width", "length", "width of the region (measure.box)", OBSERVABLE_F64, 1, width,
           asks_box),
    SERIES("height", "length", "its height", OBSERVABLE_F64, 1, height, asks_box),
    SERIES("strain_xx", "1",
           "logarithm of the length in x over that at the start (when a phase deforms the box)",
           OBSERVABLE_F64, 1, strain_xx, cell_deforms),
    SERIES("strain_yy", "1", "the same in y", OBSERVABLE_F64, 1, strain_yy, cell_deforms),
    SERIES("strain_xy", "1", "shear strain: time integral of rate_xy", OBSERVABLE_F64, 1, strain_xy,
           cell_deforms),
    SERIES("rate_xx", "1/time", "velocity gradient of the box", OBSERVABLE_F64, 1, rate_xx,
           cell_deforms),
    SERIES("rate_yy", "1/time", "the same along y", OBSERVABLE_F64, 1, rate_yy, cell_deforms),
    SERIES("rate_xy", "1/time", "shear rate: of vx along y", OBSERVABLE_F64, 1, rate_xy,
           cell_deforms),
    SERIES("offset", "length", "shift of a row of periodic images against the one below",
           OBSERVABLE_F64, 1, offset, cell_deforms),
    SERIES("nonaffine_x", "length",
           "root mean square of x displacements since the phase began, beside that of the box",
           OBSERVABLE_F64, 1, nonaffine_x, cell_deforms),
    SERIES("nonaffine_y", "length", "the same along y", OBSERVABLE_F64, 1, nonaffine_y,
           cell_deforms),
    SERIES("rattlers", "1", "free disks in the region with too few contacts (measure.rattlers)",
           OBSERVABLE_I64, 1, rattlers, asks_rattlers),
    SERIES("z_backbone", "1", "mean number of load-bearing contacts of the others", OBSERVABLE_F64,
           1, z_backbone, asks_rattlers),
    SERIES("bonds", "1", "bonds (with laws that have bonds)", OBSERVABLE_I64, 1, bonds, has_bonds),
    SERIES("broken_bonds", "1", "bonds that have broken since step 0 (likewise)", OBSERVABLE_I64, 1,
           broken_bonds, has_bonds),
    SERIES("fragments", "1", "bodies of bonded disks, single disks too (measure.fragments)",
           OBSERVABLE_I64, 1, fragments, asks_fragments),
    SERIES("largest_fragment", "mass", "mass of the heaviest of them", OBSERVABLE_F64, 1,
           largest_fragment, asks_fragments),
    STRESS(stress_xx,
           "stress of the contacts in the region, compression positive (measure.stress)"),
    STRESS(stress_xy, "stress of the contacts"),
    STRESS(stress_yx, "stress of the contacts"),
    STRESS(stress_yy, "stress of the contacts"),
    STRESS(kinetic_xx, "kinetic stress, relative to the mean velocity"),
    STRESS(kinetic_xy, "kinetic stress"),
    STRESS(kinetic_yy, "kinetic stress"),
    RESULTANTS("wall", "wall (measure.walls)", "its pivot", OBSERVABLE_WALLS, asks_walls),
    RESULTANTS("group", "group, with bodies outside it (measure.groups)", "its centre of mass",
               OBSERVABLE_GROUPS, asks_groups),
    RESULTANTS("disk", "disk of measure.contacts", "its centre", OBSERVABLE_CHOSEN, asks_contacts),
};
const observable_list series_observables =
    OBSERVABLES("observables", "series in /observables, beside the energies", others);

/* --- bodies of a frame ------------------------------------------------------------------------ */

OBSERVABLE_GET(position, moment_body, (k == 0 ? at->state->x : at->state->y)[at->slot])
OBSERVABLE_GET(image, moment_body, (k == 0 ? at->state->image_x : at->state->image_y)[at->slot])
OBSERVABLE_GET(velocity, moment_body, (k == 0 ? at->state->vx : at->state->vy)[at->slot])
OBSERVABLE_GET(angle, moment_body, at->state->turn[at->slot] + at->state->theta[at->slot])
OBSERVABLE_GET(spin, moment_body, at->state->omega[at->slot])
OBSERVABLE_GET(activity, moment_body,
               at->slot < at->state->n_free ? at->state->activity[at->slot] : SD_IN_PLAY)

/* Returns true if disks can wait for release or be taken out. */
static bool activity_changes(const sd_model *m) {
  return m->n_rains > 0 || m->bounds.given || model_holds(m);
}

static const observable bodies[] = {
    SERIES("position", "length", "centre of a disk, pivot of a wall", OBSERVABLE_F64, 2, position,
           NULL),
    SERIES("image", "1", "periodic images crossed: absolute = position + image * edges",
           OBSERVABLE_I32, 2, image, NULL),
    SERIES("velocity", "length/time", "velocity", OBSERVABLE_F64, 2, velocity, NULL),
    SERIES("angle", "rad", "angle, counter-clockwise positive, not wrapped", OBSERVABLE_F64, 1,
           angle, NULL),
    SERIES("angular_velocity", "rad/time", "spin, counter-clockwise positive", OBSERVABLE_F64, 1,
           spin, NULL),
    SERIES("activity", "1",
           "0 in play, 1 waiting, 2 removed, 3 outside the bounds (where disks can wait or leave)",
           OBSERVABLE_I32, 1, activity, activity_changes),
};
const observable_list frame_observables =
    OBSERVABLES("particles",
                "frames of all disks in /particles/disks and, but for activity, of walls in "
                "/particles/walls",
                bodies);

/* --- clumps of a frame ------------------------------------------------------------------------ */

OBSERVABLE_GET(clump_position, moment_clump,
               (k == 0 ? at->state->clump_x : at->state->clump_y)[at->clump])
OBSERVABLE_GET(clump_image, moment_clump,
               (k == 0 ? at->state->clump_image_x : at->state->clump_image_y)[at->clump])
OBSERVABLE_GET(clump_velocity, moment_clump,
               (k == 0 ? at->state->clump_vx : at->state->clump_vy)[at->clump])
OBSERVABLE_GET(clump_angle, moment_clump,
               at->state->clump_turn[at->clump] + at->state->clump_theta[at->clump])
OBSERVABLE_GET(clump_spin, moment_clump, at->state->clump_omega[at->clump])
OBSERVABLE_GET(clump_force, moment_clump,
               (k == 0 ? at->state->clump_force_x : at->state->clump_force_y)[at->clump])
OBSERVABLE_GET(clump_torque, moment_clump, at->state->clump_torque[at->clump])

static const observable clump_rows[] = {
    SERIES("position", "length", "centre of mass", OBSERVABLE_F64, 2, clump_position, NULL),
    SERIES("image", "1", "periodic images crossed by the centre", OBSERVABLE_I32, 2, clump_image,
           NULL),
    SERIES("velocity", "length/time", "velocity of the centre", OBSERVABLE_F64, 2, clump_velocity,
           NULL),
    SERIES("angle", "rad", "angle turned since the start", OBSERVABLE_F64, 1, clump_angle, NULL),
    SERIES("angular_velocity", "rad/time", "spin, counter-clockwise positive", OBSERVABLE_F64, 1,
           clump_spin, NULL),
    SERIES("force", "force", "of the contacts of its disks", OBSERVABLE_F64, 2, clump_force, NULL),
    SERIES("torque", "force length", "of the contacts of its disks, about the centre",
           OBSERVABLE_F64, 1, clump_torque, NULL),
};
const observable_list clump_observables =
    OBSERVABLES("clumps",
                "frames of all clumps in /particles/clumps; /particles/disks/clump: 1 + its number "
                "of each disk, 0: none",
                clump_rows);

/* --- contacts of a moment --------------------------------------------------------------------- */

OBSERVABLE_GET(contact_a, moment_contact, at->state->contact_a[at->contact])
OBSERVABLE_GET(contact_b, moment_contact, at->state->contact_b[at->contact])
OBSERVABLE_GET(contact_part, moment_contact, at->state->contact_part[at->contact])
OBSERVABLE_GET(contact_overlap, moment_contact, at->state->contact_overlap[at->contact])
OBSERVABLE_GET(contact_force, moment_contact, at->state->contact_force[at->contact])
OBSERVABLE_GET(contact_zeta, moment_contact, at->state->contact_zeta[at->contact])
OBSERVABLE_GET(contact_sliding, moment_contact, at->state->contact_slide[at->contact])

OBSERVABLE_GET(contact_tau, moment_contact,
               configuration_tau(at->model, at->state, at->slots, at->contact))

OBSERVABLE_GET(contact_bond, moment_contact, at->state->contact_bond[at->contact])
OBSERVABLE_GET(contact_bond_pull, moment_contact, at->state->contact_bond_pull[at->contact])
OBSERVABLE_GET(contact_bond_shear, moment_contact, at->state->contact_bond_shear[at->contact])
OBSERVABLE_GET(contact_bond_bend, moment_contact, at->state->contact_bond_bend[at->contact])

static const observable contact_rows[] = {
    SERIES("a", "1", "body number of the disk", OBSERVABLE_U32, 1, contact_a, NULL),
    SERIES("b", "1", "body number of the partner, disk or wall", OBSERVABLE_U32, 1, contact_b,
           NULL),
    SERIES("part", "1", "straight piece of the wall, 0 for round bodies", OBSERVABLE_U32, 1,
           contact_part, NULL),
    SERIES("overlap", "length", "delta", OBSERVABLE_F64, 1, contact_overlap, NULL),
    SERIES("force", "force", "normal force F_n, compression positive", OBSERVABLE_F64, 1,
           contact_force, NULL),
    SERIES("tau", "force", "tangential force tau (eq. tau): torque on a over its radius",
           OBSERVABLE_F64, 1, contact_tau, NULL),
    SERIES("zeta", "length", "tangential displacement, lambda - lambda*", OBSERVABLE_F64, 1,
           contact_zeta, NULL),
    SERIES("sliding", "1", "0 stuck, +1/-1 sliding with that sign of tau", OBSERVABLE_I32, 1,
           contact_sliding, NULL),
    SERIES("bond", "1", "0 no bond, else its strength over that of its law (laws with bonds)",
           OBSERVABLE_F64, 1, contact_bond, has_bonds),
    SERIES("bond_pull", "force", "tension in the bond", OBSERVABLE_F64, 1, contact_bond_pull,
           has_bonds),
    SERIES("bond_shear", "force", "shear force in the bond, as tau has the opposite of it",
           OBSERVABLE_F64, 1, contact_bond_shear, has_bonds),
    SERIES("bond_bend", "force", "moment in the bond over R_eff", OBSERVABLE_F64, 1,
           contact_bond_bend, has_bonds),
};
const observable_list contact_observables =
    OBSERVABLES("contacts", "rows of contact tables, in /contacts", contact_rows);

/* field_kinds.h: the kinds of fields. Deck keys, checks, the step and the documentation follow from
 * one row per kind.
 *
 * ROW(number, name in the deck, keys in the deck, meaning): name_field in
 * physics/step/field_pass.h computes the force. Keys as in deck_shape (keys.h); sd_body_force in
 * slipdisk/model.h defines the parameters.
 */
#ifndef MODEL_FIELD_KINDS_H
#define MODEL_FIELD_KINDS_H

#include "model/keys.h"
#include "slipdisk/model.h"

#define FIELD_KINDS(ROW)                                                                           \
  ROW(SD_FIELD_DRAG, drag, "gamma* gamma_rotation per centre flow shear_rate swirl",               \
      "viscous drag: gamma (u - v), u the velocity of the fluid where the disk is")                \
  ROW(SD_FIELD_DAMPING, damping, "alpha* alpha_rotation",                                          \
      "Cundall's non-viscous damping: alpha times the sum of all other forces on a coordinate, "   \
      "against its velocity")                                                                      \
  ROW(SD_FIELD_CENTRAL, central, "strength* power softening per centre",                           \
      "towards a point: strength times the distance to this power")                                \
  ROW(SD_FIELD_ROTATION, rotation, "omega* centre",                                                \
      "a frame that turns about a point: centrifugal and Coriolis force")                          \
  ROW(SD_FIELD_GRAVITY, gravity, "g* omega* tilt",                                                 \
      "gravity that turns: -m g (sin phi, cos phi), phi = tilt + omega t, t since the start of "   \
      "the run")

/* Largest absolute value of the exponent `power` of a central field. */
enum { FIELD_MOST_POWER = 8 };

extern const deck_table deck_fields;

/* Returns the name of a kind of force field as written in an input deck. */
const char *field_kind_name(sd_field_kind kind);

/* Collective. Reports errors in the force fields of a model; called by sd_model_finish. */
void body_forces_check(const sd_model *model, sd_messages *messages);
/* Factors by which the force and the torque of a field are multiplied for one disk: 1 and 1, R
 * and R^3, or m and I (sd_field_per). */
typedef struct field_weight {
  double force, torque;
} field_weight;
static inline field_weight field_weight_of(const sd_body_force *f, double radius, double mass,
                                           double inertia) {
  const bool frame = f->kind == SD_FIELD_ROTATION || f->kind == SD_FIELD_GRAVITY;
  switch (frame ? SD_FIELD_PER_MASS : f->per) {
    case SD_FIELD_PER_RADIUS: return (field_weight){radius, radius * radius * radius};
    case SD_FIELD_PER_MASS: return (field_weight){mass, inertia};
    case SD_FIELD_PER_DISK: break;
  }
  return (field_weight){1, 1};
}

/* Lowers the limit of the time step if drag or springs of fields on this rank's disks require
 * it. */
void body_forces_limit(const sd_model *model, sd_step_limit *limit);
/* Collective. Largest rate f/m or f_r/I of drag on a free disk, 1/time; 0: no drag. *disk (may
 * be NULL): number of that disk. */
double body_forces_drag_rate(const sd_model *model, uint32_t *disk);
/* True if a drag or damping field that acts on all disks is switched on in this phase of the
 * run. */
bool body_forces_dissipate(const sd_model *model, int64_t phase);
/* True if the force field is switched on in this phase of the run; always true after the last
 * phase. */
bool body_force_is_on(const sd_model *model, size_t field, int64_t phase);

#endif

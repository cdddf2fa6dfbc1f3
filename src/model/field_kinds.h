/* field_kinds.h: the kinds of fields: one row each, from which deck, checks, the step and documentation follow.
 *
 * ROW(number, name in the deck, keys in the deck, meaning): name_field in physics/step/field_pass.h is the force. Keys as in
 * deck_keys.h; meaning of the numbers: sd_body_force in slipdisk/model.h.
 */
#ifndef MODEL_FIELD_KINDS_H
#define MODEL_FIELD_KINDS_H

#include "model/keys.h"
#include "model/model.h"

#define FIELD_KINDS(ROW)                                                                           \
  ROW(SD_FIELD_DRAG, drag, "gamma* gamma_rotation per centre flow shear_rate swirl",               \
      "viscous drag: gamma (u - v), u the velocity of the fluid where the disk is")                \
  ROW(SD_FIELD_DAMPING, damping, "alpha* alpha_rotation",                                          \
      "Cundall's non-viscous damping: alpha times the sum of all other forces on a coordinate, "   \
      "against its velocity")                                                                      \
  ROW(SD_FIELD_CENTRAL, central, "strength* power softening per centre",                           \
      "towards a point: strength times the distance to this power")                                \
  ROW(SD_FIELD_ROTATION, rotation, "omega* centre",                                                \
      "a frame that turns about a point: centrifugal and Coriolis force")

enum { FIELD_MOST_POWER = 8 };

extern const deck_table deck_fields;

/* As in the deck. */
const char *field_kind_name(sd_field_kind kind);

/* Mistakes that sd_model_finish refuses. */
void body_forces_check(const sd_model *model, sd_messages *messages);
/* How strongly it acts on such a disk: forces, and torques. */
typedef struct field_weight {
  double force, torque;
} field_weight;
static inline field_weight field_weight_of(const sd_body_force *f, double radius, double mass,
                                           double inertia) {
  switch (f->kind == SD_FIELD_ROTATION ? SD_FIELD_PER_MASS : f->per) {
    case SD_FIELD_PER_RADIUS: return (field_weight){radius, radius * radius * radius};
    case SD_FIELD_PER_MASS: return (field_weight){mass, inertia};
    case SD_FIELD_PER_DISK: break;
  }
  return (field_weight){1, 1};
}

/* Shortens the limit of stability where drag or springs of fields do. */
void body_forces_limit(const sd_model *model, sd_step_limit *limit);
/* Largest f/m and f_r/I of drag on a free disk, and which it is (may be NULL). */
double body_forces_drag_rate(const sd_model *model, uint32_t *disk);
/* Does a field that is on in this phase take energy out? */
bool body_forces_lose(const sd_model *model, int64_t phase);
/* Is it on in this phase? After the last one: no matter. */
bool body_force_is_on(const sd_model *model, size_t field, int64_t phase);

#endif

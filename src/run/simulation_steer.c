/* simulation_steer.c: changes a running simulation between two steps: disks, gravity, contact laws
 * and motions; see slipdisk/simulation.h. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"
#include "model/laws.h"
#include "model/model.h"
#include "model/motions.h"
#include "model/normal_laws.h"
#include "model/state.h"
#include "physics/contact/energy.h"
#include "physics/motion/motion.h"
#include "physics/neighbours/neighbours.h"
#include "physics/small/lanes.h"
#include "physics/step/access.h"
#include "physics/step/engine.h"
#include "physics/step/steer.h"
#include "physics/system/bodies.h"
#include "physics/system/fields.h"
#include "run/loop.h"
#include "run/simulation_private.h"

/* --- quantities ------------------------------------------------------------------------------- */

/* A call of sd_simulation_set. */
typedef struct steering {
  sd_simulation *sim;
  engine *e;
  const struct quantity *row;
  size_t n;
  const uint32_t *index; /* [n] NULL: 0 ... n - 1 */
  const double *values;  /* [n * row->width] */
  sd_model *next;        /* changed copy of the model; NULL: the model stays */
  sd_contact_law *laws;  /* [n_materials^2] changed laws, and [n_motions] motions; else NULL */
  sd_motion *motions;
  bool *changed; /* [n_free] true for the slots of the disks that are changed */
  sd_messages *messages;
} steering;

/* Kinds of quantities. STEER_SIZE changes model and state, the others of disks only the state. */
typedef enum quantity_kind {
  STEER_PLACE,
  STEER_SPEED,
  STEER_SIZE,
  STEER_HELD,
  STEER_GRAVITY,
  STEER_LAW,
  STEER_MOTION
} quantity_kind;

/* A quantity that can be set. */
typedef struct quantity {
  const char *name;
  quantity_kind kind;
  /* first coordinate that is set (SD_X, ...); number of values per index */
  int first, width;
  size_t offset; /* offset of the member in sd_disk, sd_contact_law or sd_motion */
} quantity;

#define MEMBER(type, member) 0, 1, offsetof(type, member)
/* Beside these there is law.KEY for each key of a contact law whose value is a number. */
static const quantity quantities[] = {
    {"x", STEER_PLACE, SD_X, 1, 0},
    {"y", STEER_PLACE, SD_Y, 1, 0},
    {"position", STEER_PLACE, SD_X, 2, 0},
    {"angle", STEER_PLACE, SD_THETA, 1, 0},
    {"vx", STEER_SPEED, SD_X, 1, 0},
    {"vy", STEER_SPEED, SD_Y, 1, 0},
    {"velocity", STEER_SPEED, SD_X, 2, 0},
    {"omega", STEER_SPEED, SD_THETA, 1, 0},
    {"radius", STEER_SIZE, MEMBER(sd_disk, radius)},
    {"mass", STEER_SIZE, MEMBER(sd_disk, mass)},
    {"inertia", STEER_SIZE, MEMBER(sd_disk, inertia)},
    {"held", STEER_HELD, 0, 1, 0},
    {"gravity", STEER_GRAVITY, 0, 1, 0},
    {"motion.velocity", STEER_MOTION, MEMBER(sd_motion, velocity)},
    {"motion.amplitude", STEER_MOTION, MEMBER(sd_motion, amplitude)},
    {"motion.force", STEER_MOTION, MEMBER(sd_motion, force)},
    {"motion.pressure", STEER_MOTION, MEMBER(sd_motion, pressure)},
};
enum { QUANTITIES = sizeof quantities / sizeof *quantities };
#define LAW "law."

static uint32_t index_of(const steering *c, size_t k) {
  return c->index ? c->index[k] : (uint32_t)k;
}

static double value_of(const steering *c, size_t k, int part) {
  return c->values[k * (size_t)c->row->width + (size_t)part];
}

static double *member_of(void *members, const quantity *q) {
  return (double *)(void *)((char *)members + q->offset);
}

/* Finds law.KEY, or guesses the key that is meant by `key`; NULL: none is near. */
static const deck_key *law_key(const char *key, bool nearest) {
  guess near = guess_start(key);
  for (size_t k = 0; k < law_table.n; k++) {
    const deck_key *found = &law_table.key[k];
    if (found->target != DECK_SETS_NUMBER) continue;
    if (strcmp(found->name, key) == 0) return found;
    guess_add(&near, found->name);
  }
  return nearest && near.best ? deck_key_find(&law_table, near.best) : NULL;
}

/* Reports an unknown quantity, with the one that may be meant. */
static void quantity_unknown(const char *name, sd_messages *messages) {
  const char *dot = strchr(name, '.'), *key = dot ? dot + 1 : name, *part = NULL;
  guess near = guess_start(name);
  for (size_t k = 0; k < QUANTITIES; k++) {
    const char *at = strchr(quantities[k].name, '.');
    if (at && strcmp(at + 1, name) == 0) part = quantities[k].name;
    guess_add(&near, quantities[k].name);
  }
  if (!part) part = near.best;
  const deck_key *law = law_key(key, dot != NULL && !part);
  if (law)
    sd_fail(messages, SD_ERROR_USER, "%s: unknown quantity; did you mean \"" LAW "%s\"?", name,
            law->name);
  else if (part)
    sd_fail(messages, SD_ERROR_USER, "%s: unknown quantity; did you mean \"%s\"?", name, part);
  else
    sd_fail(messages, SD_ERROR_USER,
            "%s: unknown quantity; expected \"x\", \"vx\", \"gravity\", "
            "\"law.mu\" ... (sd_simulation_set)",
            name);
}

/* Finds the quantity with this name; false: there is none, which is reported. */
static bool quantity_find(const char *name, quantity *out, sd_messages *messages) {
  for (size_t k = 0; k < QUANTITIES; k++)
    if (strcmp(quantities[k].name, name) == 0) return *out = quantities[k], true;
  const deck_key *key =
      strncmp(name, LAW, sizeof LAW - 1) == 0 ? law_key(name + sizeof LAW - 1, false) : NULL;
  if (!key) return quantity_unknown(name, messages), false;
  *out = (quantity){name, STEER_LAW, 0, 1, key->offset};
  return true;
}

/* Refuses numbers that are not finite or too large. */
static sd_status check_values(const steering *c) {
  for (size_t k = 0; k < c->n; k++)
    for (int part = 0; part < c->row->width; part++)
      if (!(fabs(value_of(c, k, part)) <= LIMIT_NUMBER))
        return sd_fail(c->messages, SD_ERROR_USER, "%s = %g: expected a number of at most 1e100",
                       c->row->name, value_of(c, k, part));
  return SD_OK;
}

/* --- disks ------------------------------------------------------------------------------------ */

/* Returns why a coordinate of a disk cannot be set; NULL: it can. */
static const char *why_not(const steering *c, uint32_t disk, uint32_t slot) {
  const engine *e = c->e;
  if (slot >= e->state->n_free) return "it is fixed or driven; expected a free disk";
  if (e->model->disks[disk].clump > 0) return "it belongs to a clump";
  if (!body_in_play(e->state, slot)) return "it is not in play";
  const sd_disk *d = &e->model->disks[disk];
  const bool placed = c->row->kind == STEER_PLACE && e->state->activity[slot] == SD_HELD;
  for (int k = 0; c->row->kind != STEER_SIZE && k < c->row->width; k++) {
    const int at = c->row->first + k;
    if (engine_columns(e, at)->inverse[slot] == 0.0 && !(placed && d->holds[at] && !d->locked[at]))
      return "this coordinate is locked, held or prescribed by a motion";
  }
  return NULL;
}

/* Checks that the disks exist and may be set, and marks them in c->changed. */
static sd_status check_disks(steering *c) {
  const engine *e = c->e;
  char name[96];
  if (!memory_row(&c->changed, e->state->n_free, sizeof *c->changed))
    return sd_fail(c->messages, SD_ERROR_IO, "out of memory for the disks");
  for (size_t k = 0; k < c->n; k++) {
    const uint32_t disk = index_of(c, k);
    if (disk >= e->model->n_disks)
      return sd_fail(c->messages, SD_ERROR_USER, "%s of disk %u: expected one of the %zu disks",
                     c->row->name, disk, e->model->n_disks);
    const uint32_t slot = engine_slot(e, disk);
    const char *why = why_not(c, disk, slot);
    if (why)
      return sd_fail(c->messages, SD_ERROR_USER, "%s of %s cannot be set: %s", c->row->name,
                     sd_model_body_name(e->model, disk, name, sizeof name), why);
    c->changed[slot] = true;
  }
  return SD_OK;
}

/* Refuses positions outside the periodic box. */
static sd_status check_box(const steering *c) {
  const engine *e = c->e;
  char name[96];
  for (size_t k = 0; k < c->n; k++)
    for (int part = 0; part < c->row->width; part++) {
      const int at = c->row->first + part;
      if (at == SD_THETA || engine_length(e, at) == 0.0 ||
          !engine_beyond(e, at, value_of(c, k, part)))
        continue;
      return sd_fail(c->messages, SD_ERROR_USER,
                     "%s: %c = %g lies outside the periodic box, which is %g wide now",
                     sd_model_body_name(e->model, index_of(c, k), name, sizeof name),
                     at == SD_X ? 'x' : 'y', value_of(c, k, part), engine_length(e, at));
    }
  return SD_OK;
}

/* Refuses overlaps of the changed disks with their new positions or radii. */
static sd_status check_overlaps(const steering *c) {
  const engine *e = c->e;
  sd_model now;
  bool *fresh = NULL;
  sd_status status = simulation_present(e, c->next ? c->next : e->model, &now, c->messages);
  if (status != SD_OK) return status;
  if (!memory_row(&fresh, now.n_disks, sizeof *fresh))
    status = sd_fail(c->messages, SD_ERROR_IO, "out of memory for the overlaps");
  for (size_t k = 0; fresh && k < c->n; k++) {
    sd_disk *d = &now.disks[index_of(c, k)];
    fresh[index_of(c, k)] = true;
    for (int part = 0; c->row->kind == STEER_PLACE && part < c->row->width; part++)
      d->position[c->row->first + part] = value_of(c, k, part);
  }
  if (status == SD_OK) status = simulation_check_overlaps(e, &now, fresh, c->messages);
  free(fresh);
  free(now.disks);
  return status;
}

static sd_status check_place(steering *c) {
  if (c->e->model->measure_disks)
    return sd_fail(c->messages, SD_ERROR_USER,
                   "%s cannot be set while means of every disk are measured (measure.disks)",
                   c->row->name);
  const sd_status status = check_box(c);
  return status != SD_OK || c->row->first == SD_THETA ? status : check_overlaps(c);
}

/* Makes the copy of the model with the new radii, masses or moments of inertia. */
static sd_status check_size(steering *c) {
  char name[96];
  for (size_t k = 0; k < c->n; k++)
    if (!(value_of(c, k, 0) > 0.0))
      return sd_fail(c->messages, SD_ERROR_USER, "%s: %s = %g: expected a number > 0",
                     sd_model_body_name(c->e->model, index_of(c, k), name, sizeof name),
                     c->row->name, value_of(c, k, 0));
  c->next = simulation_model_copy(c->e->model, c->messages);
  if (!c->next) return SD_ERROR_IO;
  for (size_t k = 0; k < c->n; k++)
    *member_of(&c->next->disks[index_of(c, k)], c->row) = value_of(c, k, 0);
  const sd_status status = model_finish_again(c->next, c->messages);
  if (status != SD_OK || strcmp(c->row->name, "radius") != 0) return status;
  return check_overlaps(c);
}

static sd_status set_disks(steering *c) {
  engine *e = c->e;
  for (size_t k = 0; k < c->n; k++) {
    const uint32_t disk = index_of(c, k), slot = engine_slot(e, disk);
    const sd_disk *d = &e->model->disks[disk];
    if (c->row->kind == STEER_SIZE) steer_size(e, slot, d->radius, d->mass, d->inertia);
    for (int part = 0; c->row->kind != STEER_SIZE && part < c->row->width; part++)
      (c->row->kind == STEER_PLACE ? steer_place : steer_speed)(e, slot, c->row->first + part,
                                                                value_of(c, k, part));
    if (c->row->kind == STEER_PLACE && e->state->activity[slot] == SD_HELD &&
        motion_take_over(e, disk) != SD_OK)
      return sd_fail(c->messages, SD_ERROR_IO, "out of memory for the motions");
  }
  return SD_OK;
}

/* Replaces the model by the changed one, and builds lists and buffers anew. */
static sd_status rebuild(steering *c) {
  engine *e = c->e;
  const sd_model *model = c->next ? c->next : e->model;
  const bool small = engine_lanes(e) && lanes_suit(model);
  e->model = model;
  sd_status status = simulation_store_all(c->sim, c->messages);
  if (status == SD_OK) status = loop_rebuild(e, small, c->messages);
  if (c->next) {
    sd_model_free(c->sim->owned);
    c->sim->owned = c->next;
    c->next = NULL;
  }
  return status;
}

/* --- disks that are held and released --------------------------------------------------------- */

/* Checks the disks, and makes the copy of the model in which all of them can be held, unless they
 * can already. */
static sd_status check_held(steering *c) {
  const engine *e = c->e;
  const sd_model *m = e->model;
  char name[96];
  bool all = true;
  for (size_t k = 0; k < c->n; k++) {
    const uint32_t disk = index_of(c, k);
    if (disk >= m->n_disks)
      return sd_fail(c->messages, SD_ERROR_USER, "held of disk %u: expected one of the %zu disks",
                     disk, m->n_disks);
    const uint32_t slot = engine_slot(e, disk);
    const char *why =
        value_of(c, k, 0) != 0.0 && value_of(c, k, 0) != 1.0 ? "expected 1 (hold) or 0 (release)"
        : m->disks[disk].clump > 0                           ? "it belongs to a clump"
        : slot < e->state->n_free && !body_in_play(e->state, slot) ? "it is not in play"
                                                                   : NULL;
    if (why)
      return sd_fail(c->messages, SD_ERROR_USER, "held = %g of %s: %s", value_of(c, k, 0),
                     sd_model_body_name(m, disk, name, sizeof name), why);
    all = all && disk_holds(&m->disks[disk]);
  }
  if (all) return SD_OK;
  if (m->measure_disks)
    return sd_fail(c->messages, SD_ERROR_USER,
                   "held cannot be set while means of every disk are measured (measure.disks)");
  c->next = simulation_model_copy(m, c->messages);
  unsigned char *moved = c->next ? model_moved(m) : NULL;
  if (!moved) return sd_fail(c->messages, SD_ERROR_IO, "out of memory for the disks");
  for (size_t k = 0; k < c->n; k++)
    model_make_holdable(c->next, index_of(c, k), moved[index_of(c, k)]);
  free(moved);
  return model_finish_again(c->next, c->messages);
}

/* Number of elements that columns of this extent have per free disk; 0: they are not per free
 * disk. */
static size_t per_free(const sd_state *s, sd_extent extent) {
  const bool free_rows = extent == SD_PER_FREE || extent == SD_PER_FIELDED ||
                         extent == SD_PER_CELL_DISK || extent == SD_PER_LAW_FREE ||
                         extent == SD_PER_MEAN || extent == SD_PER_MEAN_BIN;
  return free_rows && s->n_free > 0 ? sd_extent_size(s, extent) / s->n_free : 0;
}

/* Copies the columns of `old` to the state of a model in which more disks are free. from:
 * [n_bodies] old slot of each new slot. Rows that a free disk has and a driven one lacks become 0.
 * */
static void copy_rows(sd_state *s, const sd_state *old, const uint32_t *from) {
  for (size_t k = 0; k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    const bool bodies = f->extent == SD_PER_BODY;
    const size_t per = bodies ? 1 : per_free(s, f->extent), size = sd_type_size(f->type);
    char *to = sd_field_data(s, f);
    const char *at = sd_field_data(old, f);
    const size_t bytes = sd_extent_size(old, f->extent) * size;
    if (per == 0 && bytes > 0) memcpy(to, at, bytes);
    for (size_t i = 0; per > 0 && i < (bodies ? s->n_bodies : s->n_free); i++)
      if (bodies || from[i] < old->n_free)
        memcpy(to + i * per * size, at + from[i] * per * size, per * size);
  }
}

/* Lists the old slots in the order of the new ones: free disks first, by number below ORDER_LEAST
 * of them. */
static void list_slots(const sd_model *m, const sd_state *old, uint32_t *from) {
  size_t n = 0;
  for (uint32_t i = 0; i < old->n_disks; i++)
    if (!m->disks[old->id[i]].driven) from[n++] = i;
  for (size_t i = 1; m->n_free < ORDER_LEAST && i < n; i++) /* both parts are sorted already */
    for (size_t j = i; j > 0 && old->id[from[j - 1]] > old->id[from[j]]; j--) {
      const uint32_t swap = from[j];
      from[j] = from[j - 1];
      from[j - 1] = swap;
    }
  for (uint32_t i = 0; i < old->n_bodies; i++)
    if (i >= old->n_disks || m->disks[old->id[i]].driven) from[n++] = i;
}

/* Makes the state for the model c->next, in which some driven disks are free ones that are held. */
static sd_status rearrange(steering *c, sd_state **out) {
  const sd_state *old = c->e->state;
  sd_state *s = *out = sd_state_new(c->next);
  uint32_t *from = NULL;
  sd_status status = SD_ERROR_IO;
  if (s && memory_row(&from, old->n_bodies, sizeof *from) && state_size_like(s, old) == SD_OK) {
    list_slots(c->next, old, from);
    copy_rows(s, old, from);
    for (size_t i = 0; i < s->n_free; i++)
      if (from[i] >= old->n_free) s->activity[i] = SD_HELD;
    status = s->n_free >= ORDER_LEAST ? order_disks(c->next, s) : order_contacts(c->next, s);
  }
  free(from);
  return status == SD_OK ? SD_OK : sd_fail(c->messages, SD_ERROR_IO, "out of memory for the state");
}

/* Replaces model and state by those in which all the disks can be held. */
static sd_status make_holdable(steering *c) {
  engine *e = c->e;
  sd_state *old = e->state, *state = NULL;
  const sd_model *before = e->model;
  if (c->next->n_free > old->n_free && rearrange(c, &state) != SD_OK) {
    sd_state_free(state);
    return SD_ERROR_IO;
  }
  if (state) e->state = state;
  e->model = c->next;
  sd_status status = SD_OK;
  if (state && fields_resize(e) != SD_OK)
    status = sd_fail(c->messages, SD_ERROR_IO, "out of memory for a force field");
  for (size_t i = 0; i < e->state->n_free; i++) { /* motions have moved these disks so far */
    const sd_disk *now = &e->model->disks[e->state->id[i]], *was = &before->disks[e->state->id[i]];
    if (disk_holds(now) && !disk_holds(was) && now->held) e->state->activity[i] = SD_HELD;
  }
  if (status == SD_OK) status = rebuild(c);
  if (state) sd_state_free(old);
  return status;
}

static sd_status set_held(steering *c) {
  motion_store(c->e); /* motion_resume goes on from what the state holds of random motions */
  sd_status status = c->next ? make_holdable(c) : SD_OK;
  for (size_t k = 0; k < c->n && status == SD_OK; k++)
    if (steer_hold(c->e, index_of(c, k), value_of(c, k, 0) != 0.0) != SD_OK)
      status = sd_fail(c->messages, SD_ERROR_IO, "out of memory for the motions");
  if (status != SD_OK) return status;
  motion_resume(c->e);
  bodies_fill_constants(c->e);
  return SD_OK;
}

/* --- constants of the model ------------------------------------------------------------------- */

static sd_status check_gravity(steering *c) {
  double gravity[2] = {c->e->model->gravity[0], c->e->model->gravity[1]};
  for (size_t k = 0; k < c->n; k++) {
    if (index_of(c, k) > SD_Y)
      return sd_fail(c->messages, SD_ERROR_USER,
                     "gravity of coordinate %u: expected 0 (x) or 1 (y)", index_of(c, k));
    gravity[index_of(c, k)] = value_of(c, k, 0);
  }
  for (size_t k = 0; k < c->e->model->n_phases; k++)
    if (c->e->model->phases[k].cell.asked && (gravity[0] != 0.0 || gravity[1] != 0.0))
      return sd_fail(
          c->messages, SD_ERROR_USER,
          "gravity: disks fall through the periodic box of phases[%zu].cell; expected no "
          "gravity",
          k);
  if (c->e->model->until.scaled && gravity[0] == 0.0 && gravity[1] == 0.0)
    return sd_fail(c->messages, SD_ERROR_USER,
                   "gravity = 0: until.observable t_g Omega does not exist without gravity");
  return SD_OK;
}

/* Returns the simulation's own model, of which constants can be set; c->next, if it had none
 * yet; NULL: out of memory. */
static sd_model *own_model(steering *c) {
  sd_simulation *sim = c->sim;
  if (sim->owned && !sim->owned->deck) return sim->owned;
  if (!c->next) c->next = simulation_model_copy(c->e->model, c->messages);
  return c->next;
}

static sd_status set_gravity(steering *c) {
  sd_model *m = own_model(c);
  for (size_t k = 0; m && k < c->n; k++) m->gravity[index_of(c, k)] = value_of(c, k, 0);
  return m ? SD_OK : SD_ERROR_IO;
}

/* Returns why this motion does not have the quantity; NULL: it has it. */
static const char *motion_lacks(const sd_motion *q, const quantity *row) {
  const bool servo = q->kind == SD_MOTION_SERVO, load = q->kind == SD_MOTION_LOAD;
  if (row->offset == offsetof(sd_motion, velocity))
    return q->kind == SD_MOTION_VELOCITY || servo ? NULL
                                                  : "a motion at constant velocity or a servo";
  if (row->offset == offsetof(sd_motion, force))
    return load || (servo && q->pressure == 0.0) ? NULL : "a load, or a servo that keeps a force";
  if (row->offset == offsetof(sd_motion, pressure))
    return servo && q->pressure != 0.0 ? NULL : "a servo that keeps a pressure";
  return q->kind == SD_MOTION_VELOCITY || servo || load ? "a wave, a random motion or a table"
                                                        : NULL;
}

static sd_status change_motion(steering *c, size_t k) {
  const uint32_t number = index_of(c, k);
  char name[96];
  const sd_model *m = c->e->model;
  if (number >= m->n_motions)
    return sd_fail(c->messages, SD_ERROR_USER, "%s of motion %u: expected one of the %zu motions",
                   c->row->name, number, m->n_motions);
  sd_motion *q = &c->motions[number];
  const char *expected = motion_lacks(q, c->row);
  if (expected)
    return sd_fail(c->messages, SD_ERROR_USER, "%s of %s: it has none; expected %s", c->row->name,
                   model_motion_name(m, number, name, sizeof name), expected);
  if (q->kind == SD_MOTION_RANDOM && !(q->amplitude > 0.0 && value_of(c, k, 0) > 0.0))
    return sd_fail(c->messages, SD_ERROR_USER, "%s of %s, a random motion: expected numbers > 0",
                   c->row->name, model_motion_name(m, number, name, sizeof name));
  *member_of(q, c->row) = value_of(c, k, 0);
  return SD_OK;
}

/* Sets a member of a law. The stiffnesses that follow from E_star and poisson change with these. */
static void set_law(sd_contact_law *law, const quantity *q, double value) {
  const sd_contact_law was = *law;
  *member_of(law, q) = value;
  if (law->E_star != was.E_star) law->k_n = 0.0;
  if (was.poisson > 0.0 && (law->E_star != was.E_star || law->poisson != was.poisson))
    law->k_t = 0.0;
  law_complete(law);
}

static sd_status change_law(steering *c, size_t k) {
  const size_t n = c->e->model->n_materials, at = index_of(c, k);
  if (at >= n * n || c->laws[at].k_n == 0.0)
    return sd_fail(
        c->messages, SD_ERROR_USER,
        "%s of law %zu: expected the number a n + b of two of the %zu materials that have "
        "a law",
        c->row->name, at, n);
  set_law(&c->laws[at], c->row, value_of(c, k, 0));
  c->laws[at % n * n + at / n] = c->laws[at];
  return SD_OK;
}

/* Exchanges laws and motions of the model with those in c. */
static void exchange(steering *c, sd_model *m) {
  sd_contact_law *laws = m->laws;
  sd_motion *moved = m->motions;
  m->laws = c->laws;
  m->motions = c->motions;
  c->laws = laws;
  c->motions = moved;
}

/* Sets c->laws and c->motions to the changed ones. */
static sd_status check_constants(steering *c) {
  const bool general = (laws_features(c->e->model) & LAW_GENERAL) != 0;
  sd_model *m = own_model(c);
  if (!m) return SD_ERROR_IO;
  const size_t n_laws = m->n_materials * m->n_materials;
  if (!memory_resize_row(&c->laws, n_laws, sizeof *c->laws) ||
      !memory_resize_row(&c->motions, m->n_motions, sizeof *c->motions))
    return sd_fail(c->messages, SD_ERROR_IO, "out of memory for the model");
  memcpy(c->laws, m->laws, n_laws * sizeof *c->laws);
  if (m->n_motions > 0) memcpy(c->motions, m->motions, m->n_motions * sizeof *c->motions);
  sd_status status = SD_OK;
  for (size_t k = 0; k < c->n && status == SD_OK; k++)
    status = c->row->kind == STEER_LAW ? change_law(c, k) : change_motion(c, k);
  if (status != SD_OK) return status;
  exchange(c, m);
  status = model_check_constants(m, c->laws, c->messages);
  if (status == SD_OK && ((laws_features(m) & LAW_GENERAL) != 0) != general)
    status =
        sd_fail(c->messages, SD_ERROR_USER,
                "%s: contacts need other columns of memory then; begin with a law that has them",
                c->row->name);
  exchange(c, m);
  return status;
}

/* Sets laws and motions. *built: false if lists depend on them. */
static sd_status set_constants(steering *c, bool *built) {
  engine *e = c->e;
  sd_model *m = own_model(c);
  if (!m) return SD_ERROR_IO;
  *built = !c->next && !engine_lanes(e);
  if (c->row->kind == STEER_MOTION) motion_rescale(e, c->motions);
  exchange(c, m);
  model_derive_period(m);
  if (!*built) return SD_OK;
  if (c->row->kind == STEER_MOTION) return engine_renew_motions(e, c->messages);
  /* a servo follows the shortest period of the laws */
  *built = engine_renew_laws(e) && m->shortest_period == 0.0;
  return SD_OK;
}

/* --- setting ---------------------------------------------------------------------------------- */

static sd_status check(steering *c) {
  const quantity_kind kind = c->row->kind;
  sd_status status = check_values(c);
  if (status == SD_OK && kind <= STEER_SIZE) status = check_disks(c);
  if (status != SD_OK) return status;
  switch (kind) {
    case STEER_PLACE: return check_place(c);
    case STEER_SPEED: return SD_OK;
    case STEER_SIZE: return check_size(c);
    case STEER_HELD: return check_held(c);
    case STEER_GRAVITY: return own_model(c) ? check_gravity(c) : SD_ERROR_IO;
    case STEER_LAW:
    case STEER_MOTION: return check_constants(c);
  }
  return SD_OK;
}

/* Changes the system after all checks. */
static sd_status change(steering *c) {
  engine *e = c->e;
  const quantity_kind kind = c->row->kind;
  double *at = NULL;
  bool built = kind != STEER_PLACE && kind != STEER_SIZE;
  sd_status status = SD_OK;
  if (kind == STEER_HELD) return set_held(c);
  if (kind == STEER_PLACE && c->row->first != SD_THETA) status = steer_end_contacts(e, c->changed);
  if (kind == STEER_GRAVITY) status = set_gravity(c);
  if (kind == STEER_MOTION) status = motion_values(e, &at);
  if (status == SD_OK && c->laws) status = set_constants(c, &built);
  if (status == SD_OK && kind == STEER_SIZE) e->model = c->next;
  if (status == SD_OK && kind <= STEER_SIZE) status = set_disks(c);
  /* the step for small systems leaves the lists of the general step stale */
  if (status == SD_OK && (!built || c->next || engine_lanes(e))) status = rebuild(c);
  if (status == SD_OK && kind == STEER_GRAVITY) bodies_fill_constants(e);
  if (status == SD_OK && kind == STEER_SIZE) steer_keep_displacements(e, c->changed);
  if (status == SD_OK && kind == STEER_PLACE && c->row->first == SD_THETA)
    steer_keep_displacements(e, c->changed);
  if (status == SD_OK && kind == STEER_MOTION) status = motion_continue(e, at);
  free(at);
  return status;
}

static sd_status set(steering *c) {
  engine *e = c->e;
  if (c->n == 0) return SD_OK;
  if (!c->values)
    return sd_fail(c->messages, SD_ERROR_USER, "%s: expected values, not NULL", c->row->name);
  if (loop_finished(e))
    return sd_fail(c->messages, SD_ERROR_USER,
                   "%s: the last phase is over; no step is left to make", c->row->name);
  sd_status status = check(c);
  if (status == SD_OK) {
    const double residual = energy_residual(e);
    engine_ready(e, c->messages);
    status = change(c);
    if (status == SD_OK)
      status = steer_finish(e, residual, c->row->kind == STEER_HELD, c->messages);
    if (status == SD_ERROR_IO) loop_release(e); /* half changed: lost */
  }
  sd_model_free(c->next);
  free(c->changed);
  free(c->laws);
  free(c->motions);
  return status;
}

sd_status sd_simulation_set(sd_simulation *sim, const char *name, size_t n, const uint32_t *index,
                            const double *values, sd_messages *messages) {
  bool outer;
  quantity row;
  if (!quantity_find(name, &row, messages) ||
      !simulation_enter(sim, NEED_CHANGE, "sd_simulation_set", &outer, messages))
    return SD_ERROR_USER;
  steering c = {.sim = sim,
                .e = &sim->engine,
                .row = &row,
                .n = n,
                .index = index,
                .values = values,
                .messages = messages};
  const sd_status status = set(&c);
  simulation_leave(sim, outer);
  return status;
}

/* --- reading ---------------------------------------------------------------------------------- */

/* Returns the value of a quantity of a disk; NAN: it has none. */
static double disk_value(const engine *e, const quantity *q, uint32_t disk) {
  const sd_state *s = e->state;
  if (disk >= e->model->n_disks) return NAN;
  const uint32_t slot = engine_slot(e, disk);
  if (q->kind == STEER_SIZE)
    return (q->offset == offsetof(sd_disk, radius) ? s->radius
            : q->offset == offsetof(sd_disk, mass) ? s->mass
                                                   : s->inertia)[slot];
  if (q->kind == STEER_HELD) return slot >= s->n_free || s->activity[slot] == SD_HELD;
  if (q->kind == STEER_PLACE)
    return q->first == SD_THETA ? s->turn[slot] + s->theta[slot]
                                : (q->first == SD_X ? s->x : s->y)[slot];
  return (q->first == SD_THETA ? s->omega : q->first == SD_X ? s->vx : s->vy)[slot];
}

static double value_now(const engine *e, const quantity *q, uint32_t index) {
  const sd_model *m = e->model;
  if (q->width > 1) return NAN;
  switch (q->kind) {
    case STEER_PLACE:
    case STEER_SPEED:
    case STEER_SIZE:
    case STEER_HELD: return disk_value(e, q, index);
    case STEER_GRAVITY: return index <= SD_Y ? m->gravity[index] : NAN;
    case STEER_LAW:
      return index < m->n_materials * m->n_materials ? *member_of(&m->laws[index], q) : NAN;
    case STEER_MOTION: return index < m->n_motions ? *member_of(&m->motions[index], q) : NAN;
  }
  return NAN;
}

double sd_simulation_get(const sd_simulation *sim, const char *name, uint32_t index) {
  quantity q;
  if (!quantity_find(name, &q, NULL) || !simulation_read_begin(sim)) return NAN;
  const double value = value_now(&sim->engine, &q, index);
  simulation_read_end(sim);
  return value;
}

/* Returns the number of the first of n names that is `name`; UINT32_MAX: none is. */
#define FIND_NAME(list, n, text)                                                                   \
  for (uint32_t k_ = 0; k_ < (n); k_++)                                                            \
    if ((list)[k_].name && strcmp((list)[k_].name, text) == 0) return k_

static uint32_t material_of(const sd_model *m, const char *name) {
  FIND_NAME(m->materials, m->n_materials, name);
  return UINT32_MAX;
}

static uint32_t motion_of(const sd_model *m, const char *name) {
  FIND_NAME(m->motions, m->n_motions, name);
  return UINT32_MAX;
}

static uint32_t index_by_name(const sd_model *m, const quantity *q, const char *name,
                              const char *other) {
  if (q->kind == STEER_GRAVITY) return UINT32_MAX;
  if (q->kind == STEER_MOTION) return motion_of(m, name);
  if (q->kind != STEER_LAW) {
    const uint32_t body = sd_model_find(m, name);
    return body < m->n_disks ? body : UINT32_MAX;
  }
  const uint32_t a = material_of(m, name), b = other ? material_of(m, other) : a;
  return a == UINT32_MAX || b == UINT32_MAX ? UINT32_MAX : a * (uint32_t)m->n_materials + b;
}

uint32_t sd_simulation_index(const sd_simulation *sim, const char *quantity_name, const char *name,
                             const char *other) {
  quantity q;
  if (!quantity_find(quantity_name, &q, NULL) || !simulation_read_begin(sim)) return UINT32_MAX;
  const uint32_t index = index_by_name(sim->engine.model, &q, name, other);
  simulation_read_end(sim);
  return index;
}

/* tiles.c: see tiles.h. */
#include "model/tiles.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "model/advice.h"
#include "model/bodies.h"
#include "model/cell.h"
#include "model/image.h"
#include "slipdisk/model.h"

sd_disk model_tile_disk(const sd_tiles *t, double radius, const double position[2]) {
  const double mass = t->mass == 0.0 ? t->density * 3.14159265358979323846 * radius * radius : t->mass;
  return (sd_disk){.position = {position[0], position[1], 0.0},
                   .radius = radius,
                   .mass = mass,
                   .inertia = 0.5 * mass * radius * radius,
                   .material = t->material,
                   .group = t->group};
}

/* So few that the order of the disks in a state, or what is watched, might depend on how many there are. */
enum { FEW = 1000 };

static bool moves_free_disks(const sd_model *m) {
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      const uint32_t body = m->motions[k].bodies[b];
      if (body < m->n_disks && !m->disks[body].driven) return true;
    }
  return false;
}

/* Something of the deck speaks of its disks. */
static bool names_disks(const sd_model *m) {
  bool named = moves_free_disks(m);
  for (size_t k = m->tiles.first; k < m->n_disks; k++) named = named || image_is_special(&m->disks[k]);
  for (size_t k = 0; k < m->n_contact_disks; k++) named = named || m->contact_disks[k] >= m->tiles.first;
  for (size_t k = 0; k < m->n_fields; k++)
    for (size_t i = 0; i < m->fields[k].n_disks; i++)
      named = named || m->fields[k].disks[i] >= m->tiles.first;
  return named;
}

/* Some phase is for one rank. */
static bool runs_alone(const sd_model *m) {
  bool alone = m->n_rains > 0 || m->n_rotations > 0 || m->n_slides > 0 || cell_deforms(m);
  for (size_t k = 0; k < m->n_phases; k++) alone = alone || m->phases[k].relax || m->phases[k].compress.asked;
  return alone;
}

/* Periods of springs, radii, numbers of bodies (the random stream of several). */
static bool asks_all(const sd_model *m) {
  bool asks = model_moves_surfaces(m);
  for (size_t k = 0; k < m->n_motions; k++)
    asks = asks || m->motions[k].kind == SD_MOTION_SERVO ||
           (m->motions[k].kind == SD_MOTION_RANDOM && m->motions[k].n_bodies > 1);
  return asks;
}

/* Does the model bear a disk of this radius? Lowers the limit of the time step to what that says. */
static bool bears(sd_model *m, double radius, sd_step_limit *limit) {
  sd_disk *d = &m->disks[m->tiles.first];
  const sd_disk kept = *d;
  *d = model_tile_disk(&m->tiles, radius, d->position);
  bool good = sd_model_finish(m, NULL) == SD_OK;
  char *unstable = good ? advice_unstable(m) : NULL;
  const sd_step_limit now = good ? sd_model_step_limit(m) : *limit;
  if (now.dt < limit->dt) *limit = now;
  good = good && !unstable;
  free(unstable);
  *d = kept;
  return good;
}

/* The model is the same afterwards. */
static bool bears_all(sd_model *m, sd_step_limit *limit) {
  *limit = sd_model_step_limit(m);
  const bool good = bears(m, m->tiles.least, limit) && bears(m, m->tiles.most, limit);
  return sd_model_finish(m, NULL) == SD_OK && good;
}

static bool reaches_out(const sd_model *m) {
  bool out = false;
  for (int c = 0; m->bounds.given && c < 2; c++)
    out = out || m->tiles.lower[c] < m->bounds.lower[c] || m->tiles.upper[c] > m->bounds.upper[c];
  return out;
}

/* Why all disks must be in the model; NULL: they need not. */
static const char *reason(const sd_model *m) {
  if (m->n_disks != model_held(m) || m->n_clumps > 0) return "other disks follow, or clumps";
  if (m->n_disks - m->tiles.first < FEW) return "tiles have fewer than 1000 disks";
  if (m->n_memories > 0) return "contacts come from a file";
  if (m->measure_disks) return "measure.disks = true";
  if (names_disks(m)) return "the deck speaks of single disks of it";
  if (runs_alone(m)) return "a phase is for one rank";
  if (asks_all(m)) return "a motion depends on all disks";
  return reaches_out(m) ? "it reaches beyond the bounds" : NULL;
}

static const char NO_MEMORY[] = "there is no memory for fewer";

const char *model_count_tiles(sd_model *m) {
  if (!m->tiles.away) return NULL;
  const char *why = reason(m);
  if (why) return why;
  sd_step_limit limit;
  if (!bears_all(m, &limit)) return "some size is near a limit";
  const size_t held = m->n_disks, more = m->tiles.first + m->tiles.count - held;
  sd_disk *all = calloc(held + more, sizeof *all);
  sd_messages *advised = sd_messages_new();
  if (!all || !advised) {
    free(all);
    sd_messages_free(advised);
    return NO_MEMORY;
  }
  sd_model_advise(m, advised);
  m->advised = advised;
  m->limit_told = limit.dt;
  m->bound_told = limit.bound;
  m->largest_radius = fmax(m->largest_radius, m->tiles.most);
  memcpy(all, m->disks, held * sizeof *all);
  free(m->disks);
  m->disks = all;
  m->n_disks += more;
  m->n_free += more;
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++)
      if (m->motions[k].bodies[b] >= held) m->motions[k].bodies[b] += (uint32_t)more;
  return model_find_pieces(m) == SD_OK ? NULL : NO_MEMORY;
}

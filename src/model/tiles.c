/* tiles.c: see tiles.h. */
#include "model/tiles.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "model/advice.h"
#include "model/bodies.h"
#include "model/image.h"
#include "slipdisk/model.h"

size_t model_tile_begin(const sd_tiles *t, size_t part) {
  const size_t each = t->count / t->n, more = t->count % t->n;
  return part * each + (part < more ? part : more);
}

sd_disk model_tile_disk(const sd_tiles *t, double radius, const double position[2]) {
  const double mass = t->mass == 0.0 ? t->density * 3.14159265358979323846 * radius * radius : t->mass;
  return (sd_disk){.position = {position[0], position[1], 0.0},
                   .radius = radius,
                   .mass = mass,
                   .inertia = 0.5 * mass * radius * radius,
                   .material = t->material,
                   .group = t->group,
                   .waiting = t->kind == SD_PACKING_RAIN};
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

/* Periods of springs, radii, numbers of bodies (the random stream of several). */
static bool asks_all(const sd_model *m) {
  bool asks = model_moves_surfaces(m);
  for (size_t k = 0; k < m->n_motions; k++)
    asks = asks || m->motions[k].kind == SD_MOTION_SERVO ||
           (m->motions[k].kind == SD_MOTION_RANDOM && m->motions[k].n_bodies > 1);
  return asks;
}

/* Disks that wait for rain need not lie within them. */
static bool reaches_out(const sd_model *m) {
  bool out = false;
  if (m->tiles.kind == SD_PACKING_RAIN) return false;
  for (int c = 0; m->bounds.given && c < 2; c++)
    out = out || m->tiles.lower[c] < m->bounds.lower[c] || m->tiles.upper[c] > m->bounds.upper[c];
  return out;
}

const char *model_needs_tiles(const sd_model *m) {
  if (m->n_disks != m->tiles.first + m->tiles.sample || m->n_clumps > 0)
    return "other disks follow, or clumps";
  if (m->tiles.sample < FEW) return "tiles have fewer than 1000 disks";
  if (m->n_memories > 0) return "contacts come from a file";
  if (names_disks(m)) return "the deck speaks of single disks of it";
  if (asks_all(m)) return "a motion depends on all disks";
  if (m->tiles.kind == SD_PACKING_RAIN && !(m->rains[m->n_rains - 1].batch < m->tiles.sample))
    return "tiles have fewer disks than a batch of rain";
  return reaches_out(m) ? "it reaches beyond the bounds" : NULL;
}

/* --- what the sample does not show ---------------------------------------------------------------------------- */

/* Do n disks in the place of the sample overlap each other, disks before them, or walls so deeply that it is to be told? */
static bool overlaps(sd_model *m, size_t n) {
  const size_t all = m->n_disks;
  m->n_disks = m->tiles.first + n;
  const bool found = advice_overlaps(m);
  m->n_disks = all;
  return found;
}

bool model_bears(sd_model *m, size_t n, const sd_disk *disks, sd_step_limit *limit) {
  sd_disk *sample = &m->disks[m->tiles.first], *kept = NULL;
  if (!memory_resize_row(&kept, n, sizeof *kept)) return false;
  assert(n <= m->tiles.sample);
  memcpy(kept, sample, n * sizeof *kept);
  memcpy(sample, disks, n * sizeof *kept);
  bool good = sd_model_finish(m, NULL) == SD_OK;
  char *unstable = good ? advice_unstable(m) : NULL;
  const sd_step_limit now = good ? sd_model_step_limit(m) : *limit;
  if (now.dt < limit->dt) *limit = now;
  good = good && !unstable && !(m->tiles.of_file && overlaps(m, n));
  free(unstable);
  memcpy(sample, kept, n * sizeof *kept);
  free(kept);
  return good;
}

/* --- counted -------------------------------------------------------------------------------------------------- */

bool model_count_tiles(sd_model *m, sd_step_limit limit) {
  const size_t n = m->n_disks, all = m->tiles.first + m->tiles.count;
  sd_disk *disks;
  if (!memory_row(&disks, all, sizeof *disks)) return false;
  m->advised = sd_messages_new();
  sd_model_advise(m, m->advised);
  m->limit_told = limit.dt;
  m->bound_told = limit.bound;
  m->largest_radius = fmax(m->largest_radius, m->tiles.most);
  if (m->tiles.least > 0) m->smallest_radius = fmin(m->smallest_radius, m->tiles.least);
  if (m->tiles.first > 0) memcpy(disks, m->disks, m->tiles.first * sizeof *disks);
  free(m->disks);
  m->disks = disks;
  m->n_disks = all;
  if (m->tiles.kind == SD_PACKING_RAIN) m->rains[m->n_rains - 1].count = m->tiles.count;
  m->n_free += all - n;
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++)
      if (m->motions[k].bodies[b] >= n) m->motions[k].bodies[b] += (uint32_t)(all - n);
  model_find_pieces(m);
  return true;
}

/* tiles.c: see tiles.h. */
#include "model/tiles.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "model/bodies.h"
#include "model/cell.h"
#include "model/image.h"
#include "slipdisk/model.h"

/* So few that the order of the disks in a state, or what is watched, might depend on how many there are. */
enum { FEW = 1000 };

static bool one_is_special(const sd_model *m) {
  for (size_t k = m->tiles.first; k < m->n_disks; k++)
    if (image_is_special(&m->disks[k])) return true;
  for (size_t k = 0; k < m->n_contact_disks; k++)
    if (m->contact_disks[k] >= m->tiles.first) return true;
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      const uint32_t body = m->motions[k].bodies[b];
      if (body < m->n_disks && !m->disks[body].driven) return true;
    }
  for (size_t k = 0; k < m->n_fields; k++)
    if (m->fields[k].n_disks > 0) return true;
  return false;
}

/* What motions, or the bounds that a deck gives, take from all disks. */
static bool asks_all(const sd_model *m) {
  bool asks = model_moves_surfaces(m);
  for (size_t k = 0; k < m->n_motions; k++) asks = asks || m->motions[k].kind == SD_MOTION_SERVO;
  for (int c = 0; m->bounds.given && c < 2; c++)
    asks = asks || m->tiles.lower[c] < m->bounds.lower[c] || m->tiles.upper[c] > m->bounds.upper[c];
  return asks;
}

/* Ranks share all its phases, and nothing but its forces is asked of each disk. */
static bool suits(const sd_model *m) {
  bool whole = m->n_clumps > 0 || m->n_rains > 0 || m->n_memories > 0 || m->n_rotations > 0 ||
               m->n_slides > 0 || m->measure_disks || cell_deforms(m) || asks_all(m);
  for (size_t k = 0; k < m->n_phases; k++)
    whole = whole || m->phases[k].relax || m->phases[k].compress.asked;
  return !whole && m->n_disks == model_held(m) && m->n_disks - m->tiles.first >= FEW && !one_is_special(m);
}

bool model_count_tiles(sd_model *m, sd_status *status) {
  *status = SD_OK;
  if (!m->tiles.away) return true;
  if (!suits(m)) return false;
  const size_t held = m->n_disks, more = m->tiles.first + m->tiles.count - held;
  const sd_step_limit limit = sd_model_step_limit(m);
  sd_disk *all = calloc(held + more, sizeof *all);
  sd_messages *advised = sd_messages_new();
  if (!all || !advised) {
    free(all);
    sd_messages_free(advised);
    *status = SD_ERROR_IO;
    return true;
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
  *status = model_find_pieces(m);
  return true;
}

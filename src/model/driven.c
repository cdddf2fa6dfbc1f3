/* driven.c: which disks are prescribed; see bodies.h. */
#include <assert.h>
#include <stdlib.h>

#include "base/memory.h"
#include "model/bodies.h"
#include "model/rows.h"

/* Contacts are evaluated where one of both is free. Without any free disk those that motions lead are counted as free, with
 * all coordinates held or led, so that they feel what they touch; where only walls move, all disks are. */
static void free_one(sd_model *m, size_t disk) {
  sd_disk *d = &m->disks[disk];
  if (!d->driven || !(d->mass > 0) || d->clump > 0) return;
  d->driven = false;
  for (int c = 0; c < SD_COORDINATES; c++) d->locked[c] = true;
  m->n_free++;
}

static void free_the_led(sd_model *m) {
  bool walls = false;
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      const uint32_t body = m->motions[k].bodies[b];
      const bool leads = m->motions[k].amplitude != 0 || m->motions[k].velocity != 0;
      if (body < m->n_disks && leads) free_one(m, body);
      walls = walls || (body >= m->n_disks && body < m->n_disks + m->n_walls);
    }
  for (size_t i = 0; walls && i < m->n_disks; i++) free_one(m, i);
}

unsigned char *model_moved(const sd_model *m) {
  unsigned char *moved;
  if (!memory_row(&moved, model_held(m), 1)) return NULL;
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      uint32_t body = m->motions[k].bodies[b];
      if (body < model_held(m)) moved[body] |= (unsigned char)(1u << m->motions[k].coordinate);
    }
  return moved;
}

sd_status model_find_driven(sd_model *m) {
  unsigned char *held = model_moved(m);
  if (!held) return SD_ERROR_IO;
  m->n_free = m->n_disks - model_held(m);
  for (size_t i = 0; i < model_held(m); i++) {
    for (int c = 0; c < 3; c++)
      if (m->disks[i].locked[c]) held[i] |= (unsigned char)(1u << c);
    if (held[i] == 7) m->disks[i].driven = true;
    m->n_free += !m->disks[i].driven;
  }
  free(held);
  if (m->n_free == 0) free_the_led(m);
  assert(m->n_free <= m->n_disks);
  return SD_OK;
}

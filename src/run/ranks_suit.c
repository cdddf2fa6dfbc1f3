/* ranks_suit.c: see ranks_suit.h. */
#include "run/ranks_suit.h"

#include <stdio.h>

#include "physics/small/lanes.h"

/* The first motion that does; n_motions: none. */
static size_t moves_free_disk(const sd_model *m) {
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      const uint32_t body = m->motions[k].bodies[b];
      if (body < m->n_disks && !m->disks[body].driven) return k;
    }
  return m->n_motions;
}

static void refuse(sd_messages *messages, const char *key, const char *what) {
  sd_fail(messages, SD_ERROR_USER, "%s: %s, which ranks do not share; run it without mpirun, with --threads",
          key, what);
}

sd_status ranks_suit(const sd_model *m, sd_messages *messages) {
  const size_t before = sd_messages_errors(messages);
  const size_t motion = moves_free_disk(m);
  char name[100];
  if (lanes_suit(m))
    return sd_fail(
        messages, SD_ERROR_USER,
        "disks: %zu free disk%s, so few are for one process; run it without mpirun, or the points of a "
        "sweep under it",
        m->n_free, m->n_free == 1 ? "" : "s");
  if (m->n_clumps > 0) refuse(messages, "clumps", "rigid bodies of several disks");
  for (size_t k = 0; k < m->n_phases; k++)
    if (m->phases[k].cell.asked) {
      snprintf(name, sizeof name, "phases[%zu].cell", k);
      refuse(messages, name, "a box that deforms");
    }
  if (m->n_rotations > 0) refuse(messages, "measure.rotation", "means of single disks (() watches none)");
  if (m->n_slides > 0) refuse(messages, "measure.sliding", "contacts of single disks that are watched");
  if (motion < m->n_motions)
    sd_fail(messages, SD_ERROR_USER,
            "%s: it moves a free disk, which ranks do not share; fix the disk, or run it without mpirun",
            model_motion_name(m, motion, name, sizeof name));
  return sd_messages_errors(messages) > before ? SD_ERROR_USER : SD_OK;
}

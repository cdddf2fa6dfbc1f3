/* export_frame.c: frames, boxes around frames, and particle types, used by all export formats; see
 * export.h. */
#include "app/export/export.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"

sd_status export_frame(const export_job *job, size_t k, frame_data *frame) {
  return frames_read(job->f, job->range.first + k * job->range.step, frame, job->messages);
}

size_t export_count(const export_job *job, const frame_data *frame) {
  size_t n = 0;
  for (size_t i = 0; i < job->m->n_disks; i++) n += export_has(job, frame, i);
  return n;
}

static void include(export_space *s, const double at[2], double radius) {
  for (int c = 0; c < 2; c++) {
    s->lower[c] = fmin(s->lower[c], at[c] - radius);
    s->upper[c] = fmax(s->upper[c], at[c] + radius);
  }
}

export_space export_space_of(const export_job *job, const frame_data *f) {
  const sd_model *m = job->m;
  export_space s = {
      {HUGE_VAL, HUGE_VAL, -0.5 * job->depth}, {-HUGE_VAL, -HUGE_VAL, 0.5 * job->depth}, f->offset};
  for (size_t i = 0; i < m->n_disks; i++)
    if (export_has(job, f, i)) include(&s, f->position[i], m->disks[i].radius);
  for (size_t w = 0; w < m->n_walls; w++) {
    const sd_wall *wall = &m->walls[w];
    if (wall->kind == SD_WALL_CIRCLE) include(&s, f->position[m->n_disks + w], wall->radius);
    for (size_t k = 0; wall->kind != SD_WALL_CIRCLE && k < wall->n_points; k++) {
      double at[2];
      configuration_wall_point(wall, f, m->n_disks + w, k, at);
      include(&s, at, 0.0);
    }
  }
  for (int c = 0; c < 2; c++) {
    if (m->periodic[c]) {
      s.lower[c] = m->lower[c];
      s.upper[c] = m->lower[c] + f->scale * f->stretch[c] * (m->upper[c] - m->lower[c]);
    }
    /* The interval is empty if there is no body and the box is open */
    if (!(s.lower[c] < s.upper[c])) s.lower[c] = 0.0, s.upper[c] = 1.0;
  }
  return s;
}

/* --- types ------------------------------------------------------------------------------------ */

const char *export_material(const export_job *job, int material) {
  const char *name = job->m->materials[material].name;
  return name ? name : "";
}

const char *export_group(const export_job *job, int group) {
  return group >= 0 && (size_t)group < job->m->n_groups && job->m->groups[group]
             ? job->m->groups[group]
             : "";
}

char *export_type_text(const export_job *job, size_t type) {
  const export_type *t = &job->types[type];
  const char *material = export_material(job, t->material), *group = export_group(job, t->group);
  return format_text("%s%s%s%s%s", *material ? "material " : "", *material ? material : "disks",
                     *group ? ", group " : "", group, t->driven ? ", fixed or driven" : "");
}

sd_status export_find_types(export_job *job) {
  const sd_model *m = job->m;
  if (!memory_row(&job->type_of, m->n_disks, sizeof *job->type_of))
    return sd_fail(job->messages, SD_ERROR_IO, "no memory to export");
  for (size_t i = 0; i < m->n_disks; i++) {
    const sd_disk *d = &m->disks[i];
    size_t k = 0;
    job->depth = fmax(job->depth, 2.0 * d->radius);
    while (k < job->n_types &&
           (job->types[k].material != d->material || job->types[k].group != d->group ||
            job->types[k].driven != d->driven))
      k++;
    job->type_of[i] = (uint32_t)k;
    if (k < job->n_types) continue;
    job->types = memory_grow(job->types, k + 1, sizeof *job->types);
    job->types[job->n_types++] = (export_type){d->material, d->group, d->driven};
  }
  if (!(job->depth > 0.0)) job->depth = 1.0;
  return SD_OK;
}

/* export.h: writes stored frames in the formats of other programs, with one frame in memory at a
 * time. See docs/export.md. */
#ifndef SLIPDISK_APP_EXPORT_H
#define SLIPDISK_APP_EXPORT_H

#include "app/options.h"
#include "io/results/frames.h"
#include "model/model.h"

/* Particle type: all disks of one material and one group (negative: no group) that are all
 * prescribed or all free. Exported files number the types from 1, in the order of the first disk of
 * each type. */
typedef struct export_type {
  int material, group;
  bool driven;
} export_type;

typedef struct export_job {
  const char *source; /* Name of the exported result, as on the command line */
  const char *out;    /* Path of the output, a file or a folder */
  const frames *f;
  const sd_model *m; /* Model, for data that do not change during the run: disks, walls, box */
  option_range range;
  double depth;      /* Extent of the box along z: the largest diameter of a disk */
  uint32_t *type_of; /* [n_disks] index into `types` for each disk */
  size_t n_types;
  export_type *types;
  sd_messages *messages;
} export_job;

/* Writes all selected frames. The output has a temporary name until it is complete. */
typedef sd_status export_writer(const export_job *job);
export_writer export_h5md, export_dump, export_data, export_xyz, export_vtk, export_csv;

/* Reads selected frame k, 0 <= k < range.n. Call frame_data_free also after an error. */
sd_status export_frame(const export_job *job, size_t k, frame_data *frame);
/* True if the disk is in the frame: neither waiting for its release nor removed. */
static inline bool export_has(const export_job *job, const frame_data *frame, size_t disk) {
  return job->m->disks[disk].driven || activity_is_present(frame->activity[disk]);
}
size_t export_count(const export_job *job, const frame_data *frame);

/* Box around a frame. Along periodic directions: edges of the periodic box. Along open directions:
 * the smallest interval with all disks, circular walls and end points of walls. Along z: -depth/2
 * to depth/2. */
typedef struct export_space {
  double lower[3], upper[3];
  /* Shift of the upper edge relative to the lower edge, along x, if the box is sheared; 0:
   * rectangular */
  double offset;
} export_space;
export_space export_space_of(const export_job *job, const frame_data *frame);

/* Fills types, type_of and depth of the job; the caller frees both arrays. SD_ERROR_IO: out of
 * memory. */
sd_status export_find_types(export_job *job);
/* Returns a description of a particle type, such as "material grain, group lid, fixed or driven";
 * the caller frees it. */
char *export_type_text(const export_job *job, size_t type);
/* export_material returns the name of a material in the deck, export_group that of a group; "" if
 * it has no name. */
const char *export_material(const export_job *job, int material);
const char *export_group(const export_job *job, int group);

#endif

/* export.h: stored frames in the formats of other programs, one frame in memory at a time. docs/export.md. */
#ifndef SLIPDISK_APP_EXPORT_H
#define SLIPDISK_APP_EXPORT_H

#include "app/options.h"
#include "io/results/frames.h"

/* Disks of one material, in one group or none, prescribed or not: a particle type, numbered from 1 on as they come. */
typedef struct export_type {
  int material, group;
  bool driven;
} export_type;

typedef struct export_job {
  const char *source; /* as it was named */
  const char *out;    /* a file, or a folder */
  const frames *f;
  const sd_model *m; /* constants */
  option_range range;
  double depth;      /* along z: the largest diameter */
  uint32_t *type_of; /* [n_disks] from 0 on */
  size_t n_types;
  export_type *types;
  sd_messages *messages;
} export_job;

/* Writes all chosen frames. The file or folder gets its name when all is written. */
typedef sd_status export_writer(const export_job *job);
export_writer export_h5md, export_dump, export_data, export_xyz, export_vtk, export_csv;

/* Number k of the chosen frames; frame_data_free also when it fails. */
sd_status export_frame(const export_job *job, size_t k, frame_data *frame);
/* Is the disk there: neither waiting nor removed? */
static inline bool export_has(const export_job *job, const frame_data *frame, size_t disk) {
  return job->m->disks[disk].driven || configuration_in_play(frame->activity[disk]);
}
size_t export_count(const export_job *job, const frame_data *frame);

/* The periodic box of a frame; along open directions what holds region, disks and walls with ends. */
typedef struct export_space {
  double lower[3], upper[3];
  double offset; /* of the upper edge along x, where the box deforms */
} export_space;
export_space export_space_of(const export_job *job, const frame_data *frame);

/* Numbers the types of all disks, and finds the depth; SD_ERROR_IO: no memory. */
sd_status export_find_types(export_job *job);
/* "grain, group lid, fixed"; to be freed. */
char *export_type_text(const export_job *job, size_t type);
/* Words of the deck, "" when there is none. */
const char *export_material(const export_job *job, int material);
const char *export_group(const export_job *job, int group);

#endif

/* frames.h: stored frames of a run, one at a time: from a finished result, from the parts of an unfinished one, and the
 * last state, which every result and checkpoint has, with its contacts. Of a file only the rows of the wanted frame
 * are read, and of the lists of steps and times what it takes to find it.
 */
#ifndef SLIPDISK_IO_FRAMES_H
#define SLIPDISK_IO_FRAMES_H

#include "io/results/constants.h"
#include "io/store/h5.h"
#include "measure/configuration.h"

typedef struct frame_entry {
  size_t source, row; /* in frames.sources */
  int64_t step;
  double time;
} frame_entry;

typedef struct frame_source {
  char *path;
  size_t first, n; /* its frames */
  bool checked;    /* its checksums were looked at */
} frame_source;

typedef struct frames {
  char *path;          /* of the result or checkpoint */
  h5_file *base;       /* has the state and the constants */
  sd_model *constants; /* of the run */
  size_t n_sources;
  frame_source *sources; /* files that hold frames, in the order of time */
  size_t n;              /* frames in all */
  int64_t state_step;
  double state_time;
} frames;

/* base: a result or a checkpoint; sources: files with frames, in order, base among them if it has
 * some; read_deck: see constants_read. frames_close also when it fails. SD_ERROR_USER: not a file of a
 * run. */
sd_status frames_open(frames *f, const char *base, size_t n_sources, const char *const *sources,
                      constants_deck_reader *read_deck, sd_messages *messages);
void frames_close(frames *f);
/* Is this a part of an unfinished run: frames and contacts, no state? Does not fail. */
bool frames_is_part(const char *path);

/* One frame with its contact table if one was stored at the same step. k = frames.n: the state.
 * frame_data_free also when it fails. */
sd_status frames_read(const frames *f, size_t k, frame_data *out, sd_messages *messages);
/* Where and when frame k < frames.n is. */
sd_status frames_entry(const frames *f, size_t k, frame_entry *out, sd_messages *messages);
/* The frame that is nearest in time (the state included); ties go to the earlier. */
sd_status frames_nearest(const frames *f, double time, size_t *nearest, sd_messages *messages);

#endif

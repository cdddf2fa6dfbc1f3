/* frames.h: reads the frames (stored configurations of all bodies) of a run, one at a time: from a
 * finished result, or from the part files of an unfinished one. The last state, which every result
 * and checkpoint holds with its contacts, counts as one more frame. Only the rows of the wanted
 * frame are read, and only as much of the lists of steps and times as is needed to find it. */
#ifndef SLIPDISK_IO_FRAMES_H
#define SLIPDISK_IO_FRAMES_H

#include "io/results/constants.h"
#include "io/store/h5.h"
#include "measure/configuration.h"

/* Location in the files, step and time of a stored frame. */
typedef struct frame_entry {
  size_t source, row; /* source: index into frames.sources; row: row of the frame in that file */
  int64_t step;
  double time;
} frame_entry;

/* One file that holds frames. */
typedef struct frame_source {
  char *path;
  size_t first, n; /* number in the run of the file's first frame; number of frames in the file */
  bool checked;    /* true if the checksum of the file has been verified */
} frame_source;

typedef struct frames {
  char *path;          /* path of the result or checkpoint */
  h5_file *base;       /* open file that holds the final state and the constants */
  sd_model *constants; /* model with the constants of the run */
  size_t n_sources;
  frame_source *sources; /* files that hold frames, in order of time */
  size_t n;              /* number of frames in all these files */
  /* step and time of the final state; -1 and NAN if the file does not give them */
  int64_t state_step;
  double state_time;
} frames;

/* Opens the frames of a run. base: path of a result or checkpoint. sources: paths of the files with
 * frames, in order of time, including `base` if it has frames. read_deck: function that reads a
 * deck, see constants_read. Call frames_close also after a failure. SD_ERROR_USER: `base` is not a
 * file of a run. */
sd_status frames_open(frames *f, const char *base, size_t n_sources, const char *const *sources,
                      constants_deck_reader *read_deck, sd_messages *messages);
void frames_close(frames *f);
/* Returns true if the file is a result part of an unfinished run: it holds frames and contacts but
 * no state. Returns false also if it cannot be read. */
bool frames_is_part(const char *path);

/* Reads frame k, with its contacts if contacts were stored at the same step. k = frames.n: reads
 * the final state. Call frame_data_free also after a failure. */
sd_status frames_read(const frames *f, size_t k, frame_data *out, sd_messages *messages);
/* Finds file, row, step and time of frame k; k < frames.n. */
sd_status frames_entry(const frames *f, size_t k, frame_entry *out, sd_messages *messages);
/* Finds the number of the frame that is nearest in time; the final state has the number frames.n.
 * If two frames are equally near, the earlier one is taken. */
sd_status frames_nearest(const frames *f, double time, size_t *nearest, sd_messages *messages);

#endif

/* frames.h: reads the stored frames of a run, one at a time: from a finished result, or from the
 * parts of an unfinished one. The last state, which every result and checkpoint holds with its
 * contacts, counts as one more frame. Only the rows of the wanted frame are read, and only as much
 * of the lists of steps and times as is needed to find it. */
#ifndef SLIPDISK_IO_FRAMES_H
#define SLIPDISK_IO_FRAMES_H

#include "io/results/constants.h"
#include "io/store/h5.h"
#include "measure/configuration.h"

/* Location, step and time of a stored frame. */
typedef struct frame_entry {
  size_t source, row; /* source: index into frames.sources; row: row of the frame in that file */
  int64_t step;
  double time;
} frame_entry;

/* File that holds frames. */
typedef struct frame_source {
  char *path;
  size_t first, n; /* index of its first frame in the run, and number of its frames */
  bool checked;    /* true once its checksum has been verified */
} frame_source;

typedef struct frames {
  char *path;          /* path of the result or checkpoint */
  h5_file *base;       /* open file that holds the state and the constants */
  sd_model *constants; /* model with the constants of the run */
  size_t n_sources;
  frame_source *sources; /* files with frames, in order of time */
  size_t n;              /* number of frames of all sources */
  /* step and time of the state; -1 and NAN if the file does not give them */
  int64_t state_step;
  double state_time;
} frames;

/* Opens the frames of a run. base: a result or a checkpoint. sources: files with frames, in order
 * of time, including base if it has frames. read_deck: see constants_read. Call frames_close also
 * after a failure. SD_ERROR_USER: `base` is not a file of a run. */
sd_status frames_open(frames *f, const char *base, size_t n_sources, const char *const *sources,
                      constants_deck_reader *read_deck, sd_messages *messages);
void frames_close(frames *f);
/* Returns true if the file is a part of an unfinished run: it holds frames and contacts but no
 * state. Returns false if it cannot be read. */
bool frames_is_part(const char *path);

/* Reads frame k, with its contacts if a contact table was stored at the same step. k = frames.n:
 * the state. Call frame_data_free also after a failure. */
sd_status frames_read(const frames *f, size_t k, frame_data *out, sd_messages *messages);
/* Finds the file, row, step and time of frame k < frames.n. */
sd_status frames_entry(const frames *f, size_t k, frame_entry *out, sd_messages *messages);
/* Finds the frame nearest in time; the state counts as frame frames.n. A tie goes to the earlier
 * frame. */
sd_status frames_nearest(const frames *f, double time, size_t *nearest, sd_messages *messages);

#endif

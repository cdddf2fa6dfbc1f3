/* stored.h: finds and opens the files of a run by the name that the user gives: a finished
 * result, the folder of an unfinished run, a part or a checkpoint in it. */
#ifndef SLIPDISK_RUN_STORED_H
#define SLIPDISK_RUN_STORED_H

#include "io/results/frames.h"

/* --- files that a name stands for ------------------------------------------------------------- */
typedef struct place {
  char *result; /* Path of the finished result file, which need not exist */
  char *folder; /* Path of the folder of the unfinished run's files, RESULT.parts */
  /* Path of the checkpoint or part file, if the name stood for one; NULL: it did not */
  char *checkpoint;
} place;

/* SD_ERROR_USER: the file is a deck, where a result is expected. Else SD_OK. */
sd_status place_refuse_deck(const char *name, sd_messages *messages);
/* Fills p from `name`: path of a result file, of its folder of parts (RESULT.parts), or of a
 * checkpoint in that folder. SD_ERROR_USER: there is no such run, or `name` is a deck. Call
 * place_free also after an error. */
sd_status place_find(place *p, const char *name, sd_messages *messages);
void place_free(place *p);
/* Checks that the file at the path of the result is a finished result that can be read. */
sd_status place_check_finished(const place *p, sd_messages *messages);
/* Opens p->checkpoint if the user named one, else the newest undamaged checkpoint of the run.
 * *path: receives its path, which the caller frees. Needs no lock on the folder. */
sd_status place_open_checkpoint(const place *p, h5_file **out, char **path, sd_messages *messages);

/* Warns of each part file that is missing among the first `parts` of an unfinished run. */
void stored_tell_missing(const place *p, int64_t parts, sd_messages *messages);

/* --- frames of a result or of an unfinished run ---------------------------------------------- */
/* Opens the frames of a run. name: as for place_find, or a single part file (some of the
 * frames). *alone: true if `name` is a part file; then only the frames of this file are opened.
 * Call frames_close also after an error. */
sd_status stored_open(frames *f, const char *name, bool *alone, sd_messages *messages);
/* Counts the frames into *count. The state at the end of the run counts as one more frame if it is
 * newer than the newest frame and alone is false. */
sd_status stored_count(const frames *f, bool alone, size_t *count, sd_messages *messages);

#endif

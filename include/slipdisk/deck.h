/* deck.h: functions that read a deck, an input file in libconfig syntax, into a model. docs/deck.md
 * describes its keys. */
#ifndef SLIPDISK_DECK_H
#define SLIPDISK_DECK_H

#include "slipdisk/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Everything that an input deck contains besides the physics. All texts end with a zero byte. */
typedef struct sd_deck {
  char *path; /* path of the deck file, as given by the caller */
  char *text; /* text of the deck file, unchanged */
  /* settings of the caller that replaced keys of the deck, one "path=value" per line */
  char *overrides;
  char *full; /* the deck with its overrides and all default values, in canonical form */
  /* names and walls of bodies as written in the deck, for later decks that start from its result */
  char *bodies;
  double checkpoint_seconds; /* wall time between checkpoints, seconds, > 0 */
  /* Number of parameter sets in the group `sweep` of the deck; 0: none. The model ignores them. */
  size_t sweep_points;
} sd_deck;

/* Returns the input deck from which a model was read; the model owns it. If the model was built
 * by a program, the texts of the deck are "" and its numbers the defaults. */
SD_API const sd_deck *sd_model_deck(const sd_model *model);

/* Reads the deck at `path` ("-": the standard input), checks it and makes a finished model, which
 * the caller frees with sd_model_free. overrides: n_overrides settings "path=value", as after the
 * option -D. A deck without steps, time and phases has no end: it is for programs that step it.
 * Every mistake is one message "file:line: key = value: what was expected (did you mean
 * ...)". Returns SD_ERROR_USER if there is any mistake, SD_ERROR_IO if the file exists but cannot
 * be read; *out is then NULL. */
SD_API sd_status sd_deck_load(const char *path, size_t n_overrides, const char *const *overrides,
                              sd_model **out, sd_messages *messages);

/* Like sd_deck_load, with the text of the deck in memory. Messages name `path`, and files that the
 * deck refers to are sought relative to it. */
SD_API sd_status sd_deck_load_text(const char *text, const char *path, size_t n_overrides,
                                   const char *const *overrides, sd_model **out,
                                   sd_messages *messages);

/* Names the program slipdisk, which then reads HDF5 files without a checksum (those of other
 * programs and of old versions) before this process does, since the HDF5 library crashes with some
 * damaged ones: such a file is then an error, SD_ERROR_IO. It is started by posix_spawn and gets at
 * most ten minutes, and a second per 8 MiB. NULL, the default: no process is started, and the
 * library reads such files at once. Call it before other functions, from one thread. */
SD_API void sd_set_program(const char *path);

#ifdef __cplusplus
}
#endif

#endif

/* deck.h: reading a deck (libconfig) into a model. docs/deck.md is the reference of its keys. */
#ifndef SLIPDISK_DECK_H
#define SLIPDISK_DECK_H

#include "slipdisk/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Contents of a deck besides physics. */
typedef struct sd_deck {
  char *path;      /* as given */
  char *text;      /* as read */
  char *overrides; /* one "path=value" per line */
  char *full;      /* the deck with all defaults, canonical form */
  char *bodies;    /* names and walls as the deck has them, for decks that begin with the result */
  double checkpoint_seconds; /* wall time between checkpoints, > 0 */
  size_t sweep_points;       /* that its group `sweep` asks for; the model is the deck itself */
} sd_deck;

/* The deck of a model; of one that was built by hand an empty one with defaults: texts are "". */
SD_API const sd_deck *sd_model_deck(const sd_model *model);

/* Reads, checks and finishes the deck at path (-: the standard input); overrides are "path=value" strings as after -D.
 * Every mistake is one message "file:line: key = value: what was expected (did you mean ...)".
 * Returns SD_ERROR_USER when there is any (and *out NULL), SD_ERROR_IO when the file is there and cannot be read. */
SD_API sd_status sd_deck_load(const char *path, size_t n_overrides, const char *const *overrides,
                              sd_model **out, sd_messages *messages);

/* The same from text in memory; path is used in messages and to find the files that the deck names. */
SD_API sd_status sd_deck_load_text(const char *text, const char *path, size_t n_overrides,
                                   const char *const *overrides, sd_model **out,
                                   sd_messages *messages);

#ifdef __cplusplus
}
#endif

#endif

/* deck.h: reading a deck (libconfig) into a model. docs/deck.md is the reference of its keys. */
#ifndef SLIPDISK_DECK_H
#define SLIPDISK_DECK_H

#include "slipdisk/model.h"

/* Reads, checks and finishes the deck at path; overrides are "path=value" strings as after -D.
 * Every mistake is one message "file:line: key = value: what was expected (did you mean ...)".
 * Returns SD_ERROR_USER when there is any (and *out NULL), SD_ERROR_IO when the file is there and cannot be read. */
SD_API sd_status sd_deck_load(const char *path, size_t n_overrides, const char *const *overrides,
                              sd_model **out, sd_messages *messages);

/* The same from text in memory; path is used in messages and to find the files that the deck names. */
SD_API sd_status sd_deck_load_text(const char *text, const char *path, size_t n_overrides,
                                   const char *const *overrides, sd_model **out, sd_messages *messages);

#endif

/* constants.h: stores the constants that measurements need besides the stored frames: sizes,
 * masses, walls, contact laws, box, region. Every finished result holds them (/particles and
 * /parameters/model), so that no other file is needed. */
#ifndef SLIPDISK_IO_CONSTANTS_H
#define SLIPDISK_IO_CONSTANTS_H

#include "io/store/h5.h"
#include "slipdisk/model.h"
#include "model/state.h"

/* Source of the final state: a state in memory, or the last checkpoint file if `state` is NULL. */
typedef struct constants_source {
  const sd_state *state;
  const h5_file *checkpoint;
} constants_source;

/* Writes the constants of the model to a result. from: source of the constants of those disks that
 * the model of this rank does not hold (model/rows.h). SD_ERROR_IO: a column of `from` is missing,
 * or memory ran out. */
sd_status constants_write(h5_file *file, const sd_model *model, const constants_source *from,
                          sd_messages *messages);
/* Type of a function that reads a deck, with the arguments of sd_deck_load_text. Callers pass it
 * because this folder may not include the deck reader. */
typedef sd_status constants_deck_reader(const char *text, const char *path, size_t n_overrides,
                                        const char *const *overrides, sd_model **out,
                                        sd_messages *messages);
/* Rebuilds a model, with one material per row of the table of contact laws; sd_model_finish has not
 * been called for it. It is built from a result, or, if /parameters/model is missing (in a
 * checkpoint or an old result), from the deck that is stored in the file. The caller frees *out.
 * SD_ERROR_USER: the deck cannot be read again, for example because files that it names are
 * gone. */
sd_status constants_read(const h5_file *file, const char *path, constants_deck_reader *read_deck,
                         sd_model **out, sd_messages *messages);

/* Reads only the contact laws, the integrator and dt (0: not known) of a result into a model, which
 * the caller frees. Returns NULL if they are missing or damaged. */
sd_model *constants_laws_model(const h5_file *file);

#endif

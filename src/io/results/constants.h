/* constants.h: stores the constants that measurements need besides the frames: sizes, masses,
 * walls, contact laws, box, region. Every finished result holds them (/particles and
 * /parameters/model), so that no other file is needed. */
#ifndef SLIPDISK_IO_CONSTANTS_H
#define SLIPDISK_IO_CONSTANTS_H

#include "io/store/h5.h"
#include "model/model.h"
#include "model/state.h"

/* Source of the final state: a state in memory, or the last checkpoint if `state` is NULL. */
typedef struct constants_source {
  const sd_state *state;
  const h5_file *checkpoint;
} constants_source;

/* Writes the constants of the model. from: source of the constants of disks whose rows are not in
 * the model (model/rows.h). SD_ERROR_IO: a column of `from` is missing, or no memory. */
sd_status constants_write(h5_file *file, const sd_model *model, const constants_source *from,
                          sd_messages *messages);
/* Function that reads a deck; same arguments as sd_deck_load_text. It is passed in because this
 * folder may not include the deck reader. */
typedef sd_status constants_deck_reader(const char *text, const char *path, size_t n_overrides,
                                        const char *const *overrides, sd_model **out,
                                        sd_messages *messages);
/* Rebuilds a model, which is not finished (sd_model_finish), with one material per row of the table
 * of laws. It is built from a result, or, if /parameters/model is missing (a checkpoint, an old
 * result), from the deck that is stored in the file. The caller frees *out. SD_ERROR_USER: the deck
 * cannot be read again, for example because files that it names are gone. */
sd_status constants_read(const h5_file *file, const char *path, constants_deck_reader *read_deck,
                         sd_model **out, sd_messages *messages);

/* Reads only the contact laws, the integrator and dt (0: not known) of a result. Returns NULL if
 * they are missing or damaged. The caller frees the model. */
sd_model *constants_laws_model(const h5_file *file);

#endif

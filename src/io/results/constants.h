/* constants.h: what a frame does not say and measuring needs: sizes, masses, walls, contact laws, box, region. It
 * stands in every finished result (/particles and /parameters/model), so that nothing outside the file is needed. */
#ifndef SLIPDISK_IO_CONSTANTS_H
#define SLIPDISK_IO_CONSTANTS_H

#include "io/store/h5.h"
#include "model/model.h"
#include "model/state.h"

/* Where the state at the end is: in memory, or in the last checkpoint. */
typedef struct constants_source {
  const sd_state *state;
  const h5_file *checkpoint;
} constants_source;

/* from: read for disks whose rows are not in the model (model/rows.h). SD_ERROR_IO: not there, no
 * memory. */
sd_status constants_write(h5_file *file, const sd_model *model, const constants_source *from,
                          sd_messages *messages);
/* Reads a deck, as sd_deck_load_text does: this room lies below the reader of decks. */
typedef sd_status constants_deck_reader(const char *text, const char *path, size_t n_overrides,
                                        const char *const *overrides, sd_model **out,
                                        sd_messages *messages);
/* A model, not finished, with one material per row of the laws: from a result, or, where
 * /parameters/model is not there (a checkpoint, an old result), from the deck that is stored in the
 * file. SD_ERROR_USER: the deck cannot be read again, for example since it names files that are
 * gone. */
sd_status constants_read(const h5_file *file, const char *path, constants_deck_reader *read_deck,
                         sd_model **out, sd_messages *messages);

/* Reads only the contact laws, the integrator and dt (0: not known) of a result. Returns NULL if they
 * are missing or damaged. The caller frees the model. */
sd_model *constants_laws_model(const h5_file *file);

#endif

/* simulation_store.c: clones, and simulations that are saved and loaded. See slipdisk/simulation.h.
 *
 * A saved simulation has the groups of a checkpoint, /state, /parameters and /summary, and /model/image: the model's bytes
 * (model/image.h). Checkpoints of runs have none; there the model comes from the deck in /parameters.
 */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/results/checkpoint.h"
#include "model/image.h"
#include "model/state.h"
#include "physics/contact/energy.h"
#include "physics/step/access.h"
#include "run/ranks_first.h"
#include "run/simulation_private.h"
#include "slipdisk/deck.h"

static const char IMAGE[] = "/model/image";

/* --- saving -------------------------------------------------------------------------------------------- */

static void put_image(h5_file *file, const sd_model *model) {
  size_t size = 0;
  void *bytes = image_of_model(model, &size);
  const size_t n = (size + 3) / 4;
  if (h5_have(file, bytes, IMAGE)) {
    h5_put(file, IMAGE, SD_U32, 1, &n, bytes, true);
    h5_attr_i64(file, IMAGE, "bytes", (int64_t)size);
    h5_attr_text(file, IMAGE, "description", "the model, for this version of the library");
  }
  free(bytes);
}

static sd_status put_summary(h5_file *file, sd_simulation *sim, const sd_state *state,
                             sd_messages *messages) {
  const sd_model *model = sim->engine.model;
  const sd_energy energy = energy_of(&sim->engine);
  summary found = {0};
  provenance origin = {0};
  provenance_new(&origin, model);
  provenance_refresh(&origin, 1, engine_threads(&sim->engine), engine_kernels(&sim->engine)->name);
  summary_collect(&found, model, state, NULL, &energy, NAN);
  const sd_status status =
      summary_disks_collect(&found.packing, model, state, engine_threads(&sim->engine), messages);
  if (status == SD_OK) {
    provenance_write(&origin, file);
    summary_write(&found, file);
  }
  summary_free(&found);
  provenance_free(&origin);
  return status;
}

/* All that is to be saved; NULL: reported. */
static h5_file *file_of(sd_simulation *sim, sd_messages *messages) {
  h5_file *file = NULL;
  const sd_state *state = simulation_state(sim);
  if (!state) {
    sd_fail(messages, SD_ERROR_IO, "out of memory for the contacts");
    return NULL;
  }
  if (h5_new(&file, messages) != SD_OK) return NULL;
  if (put_summary(file, sim, state, messages) != SD_OK) {
    h5_close(file, NULL);
    return NULL;
  }
  put_image(file, sim->engine.model);
  checkpoint_put_state(file, state);
  return file;
}

sd_status sd_simulation_save(sd_simulation *sim, const char *path, sd_messages *messages) {
  bool outer;
  if (!simulation_enter(sim, NEED_STATE, "sd_simulation_save", &outer, messages))
    return SD_ERROR_USER;
  h5_file *file = file_of(sim, messages);
  const sd_status status = file ? h5_save(file, -1, path, NULL, messages) : SD_ERROR_IO;
  simulation_leave(sim, outer);
  return status;
}

sd_status sd_simulation_save_memory(sd_simulation *sim, void **data, size_t *size,
                                    sd_messages *messages) {
  bool outer;
  *data = NULL;
  if (!simulation_enter(sim, NEED_STATE, "sd_simulation_save_memory", &outer, messages))
    return SD_ERROR_USER;
  h5_file *file = file_of(sim, messages);
  const sd_status status = file ? h5_save_memory(file, data, size, messages) : SD_ERROR_IO;
  simulation_leave(sim, outer);
  return status;
}

/* --- loading ------------------------------------------------------------------------------------------- */

sd_status simulation_model_of(const comm *c, const provenance *origin, sd_model **out,
                              sd_messages *messages) {
  if (comm_rank(c) > 0) return ranks_load(c, NULL, "", 0, NULL, out, messages);
  char *path = provenance_deck(origin->deck_path, origin->directory),
       *lines = memory_text(origin->deck_overrides);
  size_t n = 0;
  const char **overrides = text_lines(lines, &n);
  const sd_status status =
      c ? ranks_load(c, origin->deck_text, path, n, overrides, out, messages)
        : sd_deck_load_text(origin->deck_text, path, n, overrides, out, messages);
  free(overrides);
  free(lines);
  free(path);
  return status;
}

static sd_status get_image(const h5_file *file, sd_model **out, sd_messages *messages) {
  const int64_t size = h5_get_attr_i64(file, IMAGE, "bytes", -1);
  sd_status status = SD_OK;
  size_t dims[H5_MAX_RANK] = {0};
  int rank = 0;
  if (h5_shape(file, IMAGE, &rank, dims, messages) != SD_OK) return SD_ERROR_IO;
  if (rank != 1 || size < 0 || ((size_t)size + 3) / 4 != dims[0])
    return sd_fail(messages, SD_ERROR_IO, "the saved model is damaged");
  void *bytes = h5_column(file, IMAGE, SD_U32, dims[0], &status, messages);
  if (bytes) status = image_read(bytes, (size_t)size, out, messages);
  free(bytes);
  return status;
}

static sd_status get_deck(const h5_file *file, sd_model **out, sd_messages *messages) {
  provenance origin;
  provenance_read(&origin, file);
  sd_status status = simulation_model_of(NULL, &origin, out, messages);
  if (status == SD_OK && origin.inputs != 0 && origin.inputs != provenance_inputs(*out))
    status = sd_fail(messages, SD_ERROR_USER,
                     "the files that the deck reads have changed since the run began");
  provenance_free(&origin);
  return status;
}

/* Takes the file over. */
static sd_status load(h5_file *file, const char *name, int threads, sd_simulation **out,
                      sd_messages *messages) {
  sd_model *model = NULL;
  sd_state *state = NULL;
  sd_status status = checkpoint_check_format(file, name, messages);
  if (status == SD_OK && !h5_exists(file, "/state"))
    status = sd_fail(messages, SD_ERROR_USER,
                     "%s holds no state from which a simulation could go on", name);
  if (status == SD_OK)
    status = h5_exists(file, IMAGE) ? get_image(file, &model, messages)
                                    : get_deck(file, &model, messages);
  if (status == SD_OK) status = checkpoint_get_state(file, model, &state, messages);
  h5_close(file, NULL);
  if (status == SD_OK) status = sd_simulation_resume(model, state, threads, out, messages);
  if (status == SD_OK)
    (*out)->owned = model;
  else
    sd_model_free(model);
  return status;
}

sd_status sd_simulation_load(const char *path, int threads, sd_simulation **out,
                             sd_messages *messages) {
  h5_file *file = NULL;
  *out = NULL;
  sd_status status = h5_open_whole(path, &file, messages);
  return status == SD_OK ? load(file, path, threads, out, messages) : status;
}

sd_status sd_simulation_load_memory(const void *data, size_t size, int threads, sd_simulation **out,
                                    sd_messages *messages) {
  h5_file *file = NULL;
  *out = NULL;
  sd_status status = h5_open_memory(data, size, &file, messages);
  return status == SD_OK ? load(file, "the saved simulation", threads, out, messages) : status;
}

/* --- clones -------------------------------------------------------------------------------------------- */

static sd_state *state_clone(const sd_model *model, const sd_state *state) {
  sd_state *copy = sd_state_new(model);
  if (!copy || sd_state_reserve_contacts(copy, state->n_contacts) != SD_OK) {
    sd_state_free(copy);
    return NULL;
  }
  copy->n_contacts = state->n_contacts;
  for (size_t k = 0; k < sd_field_count; k++) {
    const size_t n = sd_extent_size(state, sd_fields[k].extent) * sd_type_size(sd_fields[k].type);
    if (n) memcpy(sd_field_data(copy, &sd_fields[k]), sd_field_data(state, &sd_fields[k]), n);
  }
  assert(!sd_state_difference(state, copy));
  return copy;
}

static sd_status clone(sd_simulation *sim, sd_simulation **out, sd_messages *messages) {
  const sd_state *state = simulation_state(sim);
  sd_model *model = state ? sd_model_clone(sim->engine.model) : NULL;
  sd_state *copy = model ? state_clone(model, state) : NULL;
  if (!copy) {
    sd_model_free(model);
    return sd_fail(messages, SD_ERROR_IO, "out of memory for the clone");
  }
  sd_status status = sd_simulation_resume(model, copy, engine_threads(&sim->engine), out, messages);
  if (status == SD_OK)
    (*out)->owned = model;
  else
    sd_model_free(model);
  return status;
}

sd_status sd_simulation_clone(sd_simulation *sim, sd_simulation **out, sd_messages *messages) {
  bool outer;
  *out = NULL;
  if (!simulation_enter(sim, NEED_STATE, "sd_simulation_clone", &outer, messages))
    return SD_ERROR_USER;
  const sd_status status = clone(sim, out, messages);
  simulation_leave(sim, outer);
  return status;
}

/* session_begin.c: how a session begins: what is there already, and from where to go on. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/file.h"
#include "run/deck_diff.h"
#include "run/session_private.h"

/* run_id of a finished result, to be freed; NULL when there is no readable one. */
static char *finished_id(const char *result) {
  h5_file *file;
  if (!file_exists(result) || h5_open(result, &file, NULL) != SD_OK) return NULL;
  char *id = h5_get_attr_text(file, "/parameters", "run_id");
  h5_close(file, NULL);
  return id;
}

static sd_status refuse_finished(const session *s, sd_messages *messages) {
  return sd_fail(messages, SD_ERROR_USER, "%s is finished already; --force runs it again and replaces it",
                 s->result);
}

/* The deck of the checkpoint must be this one, and so must the files that it names. */
static sd_status check_deck(const session *s, const provenance *origin, const sd_state *state,
                            sd_messages *messages) {
  const char *full = s->model->deck_full ? s->model->deck_full : "";
  if (!deck_same(origin->deck_full, full)) {
    sd_fail(messages, SD_ERROR_USER,
            "%s is an unfinished run of another deck (started %s); --force starts over, -o writes elsewhere",
            s->result, origin->started);
    deck_diff(origin->deck_full, full, messages);
    return SD_ERROR_USER;
  }
  for (size_t slot = 0; state && slot < state->n_bodies; slot++) {
    uint32_t body = state->id[slot];
    if (body >= s->model->n_disks) continue;
    const sd_disk *disk = &s->model->disks[body];
    if (disk->radius == state->radius[slot] && disk->mass == state->mass[slot]) continue;
    return sd_fail(messages, SD_ERROR_USER,
                   "disk %u is not the one that %s was started with: a file that the deck names has changed",
                   body, s->result);
  }
  if (state && origin->inputs != 0 && origin->inputs != provenance_inputs(s->model))
    return sd_fail(
        messages, SD_ERROR_USER,
        "a file that the deck names, of disks or of a motion's table, is not the one that %s was started "
        "with; --force starts over, -o writes elsewhere",
        s->result);
  return SD_OK;
}

/* Tries one checkpoint. SD_ERROR_IO: damaged; SD_ERROR_USER: it belongs to something else. */
static sd_status try_checkpoint(session *s, int64_t step, sd_state **state, sd_messages *messages) {
  char *path = folder_checkpoint(s->parts_folder.path, step);
  h5_file *file = NULL;
  provenance origin = {0};
  sd_status status = path ? h5_open_sealed(path, &file, messages)
                          : sd_fail(messages, SD_ERROR_IO, "no memory to read the checkpoint");
  if (status == SD_OK) status = provenance_read(&origin, file, messages);
  if (status == SD_OK) status = check_deck(s, &origin, NULL, messages);
  if (status == SD_OK) status = checkpoint_get_state(file, s->model, state, messages);
  if (status == SD_OK) status = check_deck(s, &origin, *state, messages);
  if (status == SD_OK) {
    s->parts = checkpoint_get_parts(file);
    s->origin = origin;
    if (s->parts < 0) status = sd_fail(messages, SD_ERROR_IO, "%s does not say how many parts it has", path);
  }
  if (status != SD_OK) {
    if (*state) sd_state_free(*state);
    *state = NULL;
    provenance_free(&origin);
    s->origin = (provenance){0};
  }
  h5_close(file, NULL);
  free(path);
  return status;
}

/* The newest checkpoint that is good; *state stays NULL when there is none. A damaged one is a warning as
 * long as another can stand in for it. */
static sd_status find_checkpoint(session *s, sd_state **state, size_t *n, sd_messages *messages) {
  int64_t *steps;
  sd_status status = folder_checkpoints(s->parts_folder.path, &steps, n, messages);
  for (size_t k = 0; status == SD_OK && !*state && k < *n; k++) {
    sd_messages *why = sd_messages_new();
    sd_status found = try_checkpoint(s, steps[k], state, why);
    for (size_t m = 0; m < sd_messages_count(why); m++) {
      if (found == SD_ERROR_IO)
        sd_warn(messages, "%s", sd_messages_text(why, m));
      else
        sd_fail(messages, found, "%s", sd_messages_text(why, m));
    }
    sd_messages_free(why);
    if (found == SD_ERROR_IO) {
      folder_set_aside(&s->parts_folder, steps[k]);
      sd_warn(messages, "the checkpoint of step %" PRId64 " cannot be used, the one before it is taken",
              steps[k]);
    } else {
      status = found;
    }
  }
  free(steps);
  return status;
}

/* A folder beside a result of the same run, or without a checkpoint, is what a kill during the removal left. */
static bool is_leftover(const session *s, const char *finished, const sd_state *state) {
  if (!finished || s->options.force) return false;
  return !state || strcmp(finished, s->origin.run_id) == 0;
}

static sd_status begin_fresh(session *s, sd_messages *messages) {
  sd_status status = folder_empty(&s->parts_folder, messages);
  if (status == SD_OK) status = provenance_new(&s->origin, s->model, messages);
  if (status == SD_OK) status = sd_simulation_new(s->model, s->options.threads, &s->simulation, messages);
  if (status == SD_OK)
    status = session_sample(s, session_due(s->model, sd_simulation_stage(s->simulation)), messages);
  s->origin.sessions = 1;
  /* at once: so that a full disk or a missing permission shows now, and the deck is safe */
  if (status == SD_OK) status = session_checkpoint(s, messages);
  return status;
}

static sd_status begin_again(session *s, sd_state *state, sd_messages *messages) {
  s->began = s->step = s->saved_step = s->told_step = state->step;
  s->origin.sessions++;
  sd_status status = folder_clean(&s->parts_folder, s->parts, messages);
  if (status != SD_OK) {
    sd_state_free(state);
    return status;
  }
  return sd_simulation_resume(s->model, state, s->options.threads, &s->simulation, messages);
}

/* Nothing can be continued: may the run start from the beginning? */
static sd_status check_fresh(session *s, size_t checkpoints, sd_messages *messages) {
  s->fresh = true;
  if (checkpoints > 0)
    sd_warn(messages, "no checkpoint of %s can be used: the run starts over", s->result);
  else if (!s->options.force && file_exists(s->result))
    /* not a result of this program: it is not ours to replace */
    return sd_fail(messages, SD_ERROR_USER, "%s is there and is no result of slipdisk; --force replaces it",
                   s->result);
  return SD_OK;
}

/* Refuses what can be refused without touching anything, then takes the lock. */
static sd_status prepare(session *s, sd_messages *messages) {
  char *parts = file_path("%s.parts", s->result);
  sd_status status = SD_OK;
  if (!parts)
    status = sd_fail(messages, SD_ERROR_IO, "no memory to start");
  else if (file_is_folder(s->result))
    status = sd_fail(messages, SD_ERROR_USER, "%s is a folder, a result is a file", s->result);
  else if (file_is_special(s->result))
    status = sd_fail(messages, SD_ERROR_USER, "%s is a device or a pipe, a result is a file", s->result);
  else if (!s->options.force && file_exists(s->result) && !file_exists(parts))
    status = refuse_finished(s, messages);
  if (status == SD_OK) status = folder_open(parts, &s->parts_folder, messages);
  if (status == SD_OK) status = record_new(&s->rows, s->model, messages);
  free(parts);
  return status;
}

static sd_status begin(session *s, sd_messages *messages) {
  char *finished = NULL;
  sd_state *state = NULL;
  size_t checkpoints = 0;
  sd_status status = prepare(s, messages);
  if (status == SD_OK && !s->options.force) {
    finished = finished_id(s->result);
    status = find_checkpoint(s, &state, &checkpoints, messages);
  }
  if (status == SD_OK && is_leftover(s, finished, state)) {
    s->was_finished = true;
    sd_state_free(state);
    status = folder_remove(&s->parts_folder, messages);
  } else if (status == SD_OK && state) {
    status = begin_again(s, state, messages);
  } else if (status == SD_OK) {
    status = check_fresh(s, checkpoints, messages);
    if (status == SD_OK) status = begin_fresh(s, messages);
  }
  free(finished);
  return status;
}

sd_status session_open(const sd_model *model, const session_options *options, session **out,
                       sd_messages *messages) {
  *out = NULL;
  session *s = calloc(1, sizeof *s);
  if (!s || !(s->result = file_path("%s", options->result))) {
    free(s);
    return sd_fail(messages, SD_ERROR_IO, "no memory to start");
  }
  s->model = model;
  s->options = *options;
  s->options.result = s->result;
  s->parts_folder.lock = -1;
  s->steps = sd_model_steps(model);
  s->saved_step = s->told_phase = -1;
  s->saved_at = s->wall_mark = session_clock();
  sd_status status = begin(s, messages);
  /* a run that never began leaves no folder */
  if (status != SD_OK && s->fresh && s->saved_step < 0 && s->parts_folder.lock >= 0)
    folder_remove(&s->parts_folder, NULL);
  if (status == SD_OK)
    *out = s;
  else
    session_close(s);
  return status;
}

void session_close(session *s) {
  if (!s) return;
  sd_simulation_free(s->simulation);
  record_free(&s->rows);
  provenance_free(&s->origin);
  summary_free(&s->found);
  folder_close(&s->parts_folder);
  free(s->result);
  free(s);
}

int64_t session_began(const session *s) { return s->began; }
bool session_was_finished(const session *s) { return s->was_finished; }
const summary *session_summary(const session *s) { return s->has_found ? &s->found : NULL; }
const provenance *session_provenance(const session *s) { return &s->origin; }

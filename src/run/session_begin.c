/* session_begin.c: opens a session (a run with its files): finds out which files exist, and at
 * which step to begin. */
#include <assert.h>
#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/team.h"
#include "base/comm.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/deck/deck.h"
#include "io/results/merge.h"
#include "io/store/file.h"
#include "model/rows.h"
#include "run/steps.h"
#include "run/session_private.h"
#include "run/simulation_private.h"
#include "slipdisk/deck.h"

/* Returns true if `identity`, as session_identity returns it, is that of a result (a run_id), and
 * not that of another file. */
static bool is_result(const char *identity) {
  return strlen(identity) == 32 && strspn(identity, "0123456789abcdef") == 32;
}

/* Differences between two decks: the first MOST_TOLD as text, and the number of all. */
enum { MOST_TOLD = 20 };
typedef struct deck_differences {
  size_t n;
  char *text[MOST_TOLD];
} deck_differences;

static void keep_difference(void *user, const char *path, const char *there, const char *here) {
  deck_differences *d = user;
  if (d->n < MOST_TOLD) d->text[d->n] = deck_difference_text(path, there, here);
  d->n++;
}

/* Checks that the deck stored in a checkpoint or result is the deck of this session. what: "an
 * unfinished run". */
static sd_status check_deck(const session *s, const provenance *origin, const char *what,
                            sd_messages *messages) {
  const char *there = origin->deck_full, *here = sd_model_deck(s->model)->full;
  if (strcmp(there, here) == 0) return SD_OK;
  deck_differences found = {0};
  const bool comparable = deck_compare(there, here, false, keep_difference, &found);
  const sd_status status = comparable && found.n == 0 ? SD_OK : SD_ERROR_USER;
  if (status != SD_OK)
    sd_fail(messages, status,
            "%s is %s of another deck (started %s); --force starts over, -o writes elsewhere",
            s->result, what, origin->started);
  for (size_t k = 0; k < found.n && k < MOST_TOLD; k++) {
    sd_fail(messages, status, "%s", found.text[k]);
    free(found.text[k]);
  }
  if (found.n > MOST_TOLD) sd_fail(messages, status, "... and %zu more keys", found.n - MOST_TOLD);
  return status;
}

/* Checks that the files which the deck names are those of the run that is stored. */
static sd_status check_files(const session *s, const provenance *origin, sd_messages *messages) {
  if (origin->inputs == 0 || origin->inputs == provenance_inputs(s->model)) return SD_OK;
  return sd_fail(messages, SD_ERROR_USER,
                 "a file that the deck names, of disks or of a motion's table, is not the one that "
                 "%s was started with; --force starts over, -o writes elsewhere",
                 s->result);
}

/* Checks that the finished result is that of this session's deck. */
static sd_status check_finished(const session *s, sd_messages *messages) {
  h5_file *file = NULL;
  provenance origin;
  sd_status status = h5_open(s->result, &file, messages);
  if (status != SD_OK) return status;
  provenance_read(&origin, file);
  status = check_deck(s, &origin, "the result", messages);
  if (status == SD_OK) status = check_files(s, &origin, messages);
  provenance_free(&origin);
  h5_close(file, NULL);
  return status;
}

/* Refuses to run because a file exists at the path of the result, which only --force replaces. */
static sd_status refuse_existing(const session *s, const char *there, sd_messages *messages) {
  const bool result = is_result(there);
  const sd_status status = result ? check_finished(s, messages) : SD_OK;
  if (status != SD_OK) return status;
  return sd_fail(messages, SD_ERROR_USER,
                 result
                     ? "%s is finished already; --force runs it again and replaces it"
                     : "%s is there, and is damaged or no result of slipdisk; --force replaces it",
                 s->result);
}

/* Data of some disks of a checkpoint: number, radius and mass of each. */
typedef struct some_disks {
  uint32_t *id;
  double *radius, *mass;
} some_disks;

/* Checks that the disks in slots first ... first + n - 1 of the checkpoint have the radii and
 * masses of the model. */
static sd_status check_disks(const session *s, const h5_file *file, size_t first, size_t n,
                             some_disks *d, sd_messages *messages) {
  sd_status status = h5_get_values(file, "/state/id", SD_U32, first, n, 1, d->id, messages);
  if (status == SD_OK)
    status = h5_get_values(file, "/state/radius", SD_F64, first, n, 1, d->radius, messages);
  if (status == SD_OK)
    status = h5_get_values(file, "/state/mass", SD_F64, first, n, 1, d->mass, messages);
  for (size_t k = 0; status == SD_OK && k < n; k++) {
    if (d->id[k] >= s->model->n_disks || !model_knows(s->model, d->id[k])) continue;
    const sd_disk *disk = &s->model->disks[d->id[k]];
    if (disk->radius == d->radius[k] && disk->mass == d->mass[k]) continue;
    status = sd_fail(
        messages, SD_ERROR_USER,
        "disk %u is not the one that %s was started with: a file that the deck names has changed",
        d->id[k], s->result);
  }
  return status;
}

/* Checks that the files which the deck names are the same as when the run began: by comparing the
 * disks, and by a checksum. */
static sd_status check_inputs(const session *s, const h5_file *file, sd_messages *messages) {
  enum { AT_ONCE = 1 << 18 };
  const size_t bodies = sd_model_bodies(s->model), most = bodies < AT_ONCE ? bodies : AT_ONCE;
  some_disks d = {memory_new(most, sizeof *d.id), memory_new(most, sizeof *d.radius),
                  memory_new(most, sizeof *d.mass)};
  sd_status status = SD_OK;
  for (size_t at = 0; status == SD_OK && at < bodies; at += most)
    status = check_disks(s, file, at, bodies - at < most ? bodies - at : most, &d, messages);
  free(d.id);
  free(d.radius);
  free(d.mass);
  return status == SD_OK ? check_files(s, &s->origin, messages) : status;
}

/* Checks deck, state and part files of a checkpoint in an open file, and stores the number of part
 * files in the session. state: receives the state if the run is in one process. */
static sd_status read_checkpoint(session *s, const h5_file *file, const char *path,
                                 sd_state **state, sd_messages *messages) {
  sd_status status = check_deck(s, &s->origin, "an unfinished run", messages);
  if (status == SD_OK)
    status = s->options.comm ? checkpoint_check_state(file, s->model, messages)
                             : checkpoint_get_state(file, s->model, state, messages);
  if (status == SD_OK) status = check_inputs(s, file, messages);
  if (status != SD_OK) return status;
  s->parts = checkpoint_get_parts(file);
  s->last_part = checkpoint_get_last_part(file);
  free(s->replaces);
  s->replaces = checkpoint_get_replaces(file);
  if (s->parts < 0 || !s->replaces)
    return sd_fail(messages, SD_ERROR_IO, "%s does not say how many parts it has", path);
  return merge_check_parts(&s->parts_folder, &s->rows, s->origin.run_id, s->parts, s->last_part,
                           messages);
}

/* Tries to continue from one checkpoint. SD_ERROR_IO: the checkpoint or one of its part files is
 * damaged. SD_ERROR_USER: the checkpoint belongs to another deck or has another format. finished:
 * identity of the file at the path of the result. If that file is the result of this same run, the
 * run had finished and was killed while it removed the folder; then was_finished is set. */
static sd_status try_checkpoint(session *s, int64_t step, const char *finished, sd_state **state,
                                sd_messages *messages) {
  char *path = folder_checkpoint(s->parts_folder.path, step);
  h5_file *file = NULL;
  sd_status status = h5_open_sealed(s->parts_folder.at, path, &file, NULL, messages);
  if (status == SD_OK) status = checkpoint_check_format(file, path, messages);
  if (status == SD_OK) provenance_read(&s->origin, file);
  s->was_finished = status == SD_OK && strcmp(finished, s->origin.run_id) == 0;
  if (status == SD_OK && !s->was_finished) status = read_checkpoint(s, file, path, state, messages);
  if (status == SD_OK && shortage_seen())
    status = sd_fail(messages, SD_ERROR_IO, "there was no memory for all that %s says", path);
  if (status != SD_OK) {
    if (*state) sd_state_free(*state);
    *state = NULL;
    provenance_free(&s->origin);
  }
  if (status == SD_OK && !s->was_finished) s->saved_step = step;
  h5_close(file, NULL);
  free(path);
  return status;
}

/* Like try_checkpoint. If that fails although everything in the folder can be read, tries once
 * more. unread: set to true if something cannot be read, so that nothing is known to be damaged. */
static sd_status try_twice(session *s, int64_t step, const char *finished, sd_state **state,
                           bool *unread, sd_messages *messages) {
  sd_messages *first = sd_messages_new();
  sd_status status = try_checkpoint(s, step, finished, state, first);
  if (status == SD_ERROR_IO && !shortage_seen()) {
    *unread = folder_read_through(s->parts_folder.path, messages) != SD_OK;
    if (!*unread) status = try_checkpoint(s, step, finished, state, messages);
  } else {
    messages_append(messages, status, first);
  }
  sd_messages_free(first);
  return status;
}

/* Renames the n newest checkpoints, which cannot be used, and warns of that. why: the errors found
 * in them. */
static void step_back(session *s, const int64_t *steps, size_t n, const sd_messages *why,
                      sd_messages *messages) {
  messages_append(messages, SD_OK, why);
  for (size_t k = 0; k < n; k++) folder_set_aside(&s->parts_folder, steps[k]);
  sd_warn(messages,
          "the checkpoint of step %" PRId64 " cannot be used, that of step %" PRId64 " is taken",
          steps[0], steps[n]);
}

/* Finds the newest undamaged checkpoint with undamaged part files. saved_step stays -1 if there is
 * none, or if the run is finished. A damaged checkpoint is only a warning if an older one can be
 * used. If memory runs out, no checkpoint is taken for damaged. */
static sd_status find_checkpoint(session *s, const char *finished, sd_state **state,
                                 sd_messages *messages) {
  int64_t *steps;
  size_t n, k = 0;
  sd_status status = folder_checkpoints(s->parts_folder.path, &steps, &n, messages);
  sd_messages *why = sd_messages_new();
  bool unread = false;
  if (status == SD_OK && n > 0) {
    while (k < n &&
           (status = try_twice(s, steps[k], finished, state, &unread, why)) == SD_ERROR_IO &&
           !unread && !shortage_seen())
      k++;
    if (status == SD_OK && k > 0 && !s->was_finished) {
      step_back(s, steps, k, why, messages);
    } else if (status != SD_OK) {
      messages_append(messages, status, why);
      if (status == SD_ERROR_IO && unread)
        sd_fail(messages, status, "%s cannot go on now; what is saved is left as it is", s->result);
      else if (status == SD_ERROR_IO && shortage_seen())
        sd_fail(messages, status, "no memory to go on with %s; what is saved is left as it is",
                s->result);
      else if (status == SD_ERROR_IO)
        sd_fail(messages, status,
                "%s cannot go on: no checkpoint can be used together with its parts. What is in %s "
                "is left as "
                "it is; --force starts over",
                s->result, s->parts_folder.path);
    }
  }
  sd_messages_free(why);
  free(steps);
  return status;
}

/* Warns if ranks have so few disks that fewer ranks would be faster: two ranks with 1000 disks each
 * are as fast as one process (docs/performance.md). */
static void warn_of_ranks(const session *s, sd_messages *messages) {
  enum { WORTH = 1000 };
  const size_t n = (size_t)comm_size(s->options.comm), disks = s->model->n_free;
  if (!s->options.comm) return;
  if (disks < WORTH * n)
    sd_warn(messages,
            "%zu ranks share %zu free disks: with fewer than %d each they wait for each other "
            "longer than they "
            "work; fewer ranks are faster",
            n, disks, WORTH);
}

/* Prepares a run from the start: empties the folder of the run. there: identity of the file that
 * the result may replace at the end; "": none. */
static sd_status prepare_fresh(session *s, const char *there, sd_messages *messages) {
  s->fresh = true;
  s->replaces = memory_text(there);
  sd_status status = folder_empty(&s->parts_folder, messages);
  if (status == SD_OK) provenance_new(&s->origin, s->model);
  s->origin.sessions = 1;
  return status;
}

/* Collective: begins a run at step 0, samples rows and writes the first checkpoint. */
static sd_status begin_fresh(session *s, sd_messages *messages) {
  sd_status status = simulation_new(s->model, s->options.threads, SIMULATION_SUITABLE,
                                    s->options.comm, s->options.stop, &s->simulation, messages);
  if (status != SD_OK) return status;
  if (session_leads(s)) warn_of_ranks(s, messages);
  /* Check for a stop now: the first checkpoint of a large system takes long, and a stop before it
   * loses no work. */
  if (comm_max(s->options.comm, session_is_stopped(s))) return SD_INTERRUPTED;
  status = session_sample(s, session_due(s->model, sd_simulation_stage(s->simulation)), messages);
  /* Write the first checkpoint at once: it shows now whether the disk is full or a permission is
   * missing, and it stores the deck. */
  return status == SD_OK ? session_checkpoint(s, messages) : status;
}

/* Prepares a run that continues from a checkpoint. */
static sd_status prepare_again(session *s, sd_messages *messages) {
  s->origin.sessions++;
  /* Check now, and not after all steps, whether the result may be written. */
  sd_status status = session_may_publish(s, SD_ERROR_USER, messages);
  return status == SD_OK ? folder_clean(&s->parts_folder, s->parts, messages) : status;
}

/* Reads the rows of a checkpoint that this rank is to have. */
static sd_status read_some(session *s, sd_state **state, uint32_t **order, sd_messages *messages) {
  const comm *c = s->options.comm;
  char *parts = format_text("%s.parts", s->result), *path = folder_checkpoint(parts, s->saved_step);
  sd_messages *mine = sd_messages_new();
  const sd_status status =
      comm_agree(c, checkpoint_get_some(path, s->model, (size_t)comm_rank(c), (size_t)comm_size(c),
                                        state, order, mine));
  ranks_report(c, status, mine, session_leads(s) ? messages : NULL);
  sd_messages_free(mine);
  free(path);
  free(parts);
  if (status == SD_OK) return SD_OK;
  sd_state_free(*state);
  free(*order);
  return status;
}

/* Collective: continues a run from a checkpoint. state: the state, if the run is in one process. */
static sd_status begin_again(session *s, sd_state *state, sd_messages *messages) {
  uint32_t *order = NULL;
  sd_status status = s->options.comm ? read_some(s, &state, &order, messages) : SD_OK;
  if (status == SD_OK)
    status = simulation_resume(s->model, state, order, s->options.threads, SIMULATION_SUITABLE,
                               s->options.comm, s->options.stop, &s->simulation, messages);
  if (status == SD_OK)
    s->began = s->step = s->saved_step = s->told_step = sd_simulation_step(s->simulation);
  if (status == SD_OK && session_leads(s)) warn_of_ranks(s, messages);
  return status;
}

/* Refuses a run that must be refused before it changes any file, then locks its folder. there:
 * receives the identity of the file at the path of the result. */
static sd_status prepare(session *s, char **there, sd_messages *messages) {
  sd_status status = session_identity(s, there, messages);
  if (status != SD_OK) return status;
  assert(*there);
  char *parts = format_text("%s.parts", s->result);
  if (file_is_folder(s->result))
    status = sd_fail(messages, SD_ERROR_USER, "%s is a folder, a result is a file", s->result);
  else if (file_is_link(s->result))
    status =
        sd_fail(messages, SD_ERROR_USER, "%s is a symbolic link, a result is a file", s->result);
  else if (file_is_special(s->result))
    status =
        sd_fail(messages, SD_ERROR_USER, "%s is a device or a pipe, a result is a file", s->result);
  else if (!s->options.force && **there && !file_exists(parts))
    status = refuse_existing(s, *there, messages);
  if (status == SD_OK) status = folder_open(parts, false, &s->parts_folder, messages);
  /* the part files get the access rights of the result */
  if (status == SD_OK) file_keep_mode(s->parts_folder.at, -1, s->result);
  record_new(&s->rows, s->model, RECORD_WHOLE);
  record_new(&s->shared, s->model, RECORD_HEAD);
  free(parts);
  return status;
}

/* Way in which a run begins. FINISHED: no work is left; AGAIN: continue from a checkpoint; FRESH:
 * run from the start. */
typedef enum beginning { FINISHED, AGAIN, FRESH } beginning;

/* Finds out how to begin, and does all work with files for it; called on rank 0 only. how: receives
 * the way to begin. */
static sd_status find_beginning(session *s, beginning *how, sd_state **state,
                                sd_messages *messages) {
  char *there = NULL;
  sd_status status = prepare(s, &there, messages);
  if (status == SD_OK && !s->options.force) {
    assert(there);
    status = find_checkpoint(s, there, state, messages);
    /* Without a checkpoint no run was begun: if there is a result, its run is finished. */
    s->was_finished = s->was_finished || (status == SD_OK && s->saved_step < 0 && is_result(there));
  }
  *how = s->was_finished ? FINISHED : s->saved_step >= 0 ? AGAIN : FRESH;
  if (status == SD_OK && *how == FINISHED) status = check_finished(s, messages);
  if (status == SD_OK && *how == FINISHED) status = folder_remove(&s->parts_folder, messages);
  if (status == SD_OK && *how == AGAIN) status = prepare_again(s, messages);
  if (status == SD_OK && *how == FRESH)
    status = !s->options.force && *there ? refuse_existing(s, there, messages)
                                         : prepare_fresh(s, there, messages);
  free(there);
  return status;
}

/* Collective: rank 0 finds out how to begin, then all ranks begin. */
static sd_status begin(session *s, sd_messages *messages) {
  sd_state *state = NULL;
  beginning found = FINISHED;
  sd_status status = session_leads(s) ? find_beginning(s, &found, &state, messages) : SD_OK;
  int64_t how[2] = {found, s->saved_step};
  status = comm_wait(s->options.comm, status);
  comm_broadcast(s->options.comm, how, sizeof how);
  if (status != SD_OK) {
    if (state) sd_state_free(state);
    return status;
  }
  s->was_finished = how[0] == FINISHED;
  s->saved_step = how[1];
  if (how[0] == AGAIN) return begin_again(s, state, messages);
  return how[0] == FRESH ? begin_fresh(s, messages) : SD_OK;
}

sd_status session_open(const sd_model *model, const session_options *options, session **out,
                       sd_messages *messages) {
  *out = NULL;
  session *s = memory_new(1, sizeof *s);
  s->result = memory_text(options->result);
  s->model = model;
  s->options = *options;
  s->options.result = s->result;
  s->parts_folder = (folder){.at = -1, .lock = -1};
  s->steps = sd_model_steps(model);
  s->saved_step = s->told_phase = -1;
  s->saved_at = s->wall_mark = clock_seconds();
  sd_status status = begin(s, messages);
  /* Remove the folder of the run if it failed before its first checkpoint. */
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
  record_free(&s->shared);
  provenance_free(&s->origin);
  summary_free(&s->found);
  folder_close(&s->parts_folder);
  free(s->replaces);
  free(s->result);
  free(s);
}

int64_t session_began(const session *s) { return s->began; }
int64_t session_saved(const session *s) { return s->saved_step; }
bool session_was_finished(const session *s) { return s->was_finished; }
const summary *session_summary(const session *s) { return s->has_found ? &s->found : NULL; }
const provenance *session_provenance(const session *s) { return &s->origin; }
const struct ranks *session_ranks(const session *s) {
  return s->simulation ? s->simulation->ranks : NULL;
}

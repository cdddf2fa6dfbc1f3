/* sweep_points.c: runs points of a sweep, one or several side by side; see sweep.h. */
#include <stdlib.h>

#include "base/memory.h"
#include "run/session_group.h"
#include "run/sweep.h"

typedef struct jobs jobs;

/* A point while it is run. */
typedef struct runner {
  jobs *all;
  size_t k; /* as given */
  sd_model *model;
  char *result;
} runner;

struct jobs {
  const sweep *s;
  const size_t *points;
  const sweep_options *options;
  runner *runners;         /* [n] */
  session_member *members; /* [n] */
};

static void tell_progress(void *user, const session_progress *p) {
  const runner *r = user;
  const sweep_options *options = r->all->options;
  if (options->progress) options->progress(options->user, r->k, p);
}

/* A finished result stays, unless it is none of this deck's: that is a mistake. */
static sd_status leave_finished(const sweep *s, size_t point, sweep_status *status, sd_messages *messages) {
  sweep_result r;
  sd_status looked = SD_OK;
  sweep_look(s, point, &r);
  *status = r.status;
  if (r.status == SWEEP_OTHER || r.status == SWEEP_DAMAGED)
    looked = sd_fail(messages, SD_ERROR_USER,
                     "%s/points/%s.h5 %s (%s); --force runs the point again, -o writes elsewhere", s->folder,
                     s->deck.points[point].name,
                     r.status == SWEEP_OTHER ? "is the result of another deck" : "cannot be read", r.message);
  sweep_result_free(&r);
  return looked;
}

/* One attempt; *out stays NULL when there is nothing to run. *again: another process was perhaps faster. */
static sd_status try_to_open(runner *r, session **out, int threads, sweep_status *status, bool *again,
                             sd_messages *messages) {
  const sweep *s = r->all->s;
  const sweep_options *options = r->all->options;
  size_t point = r->all->points[r->k];
  *again = false;
  *out = NULL;
  *status = sweep_peek(s, point);
  if (*status == SWEEP_DONE && !options->force) return leave_finished(s, point, status, messages);
  if (*status == SWEEP_RUNNING) return SD_OK;
  *status = SWEEP_WAITING;
  if (options->stop && *options->stop) return SD_INTERRUPTED;
  *status = SWEEP_FAILED;
  if (!r->model) {
    sd_status loaded = sweep_load(s, point, &r->model, &r->result, messages);
    if (loaded != SD_OK) return loaded;
  }
  session_options how = {.result = r->result,
                         .threads = threads,
                         .force = options->force,
                         .stop = options->stop,
                         .progress = tell_progress,
                         .user = r};
  sd_status opened = session_open(r->model, &how, out, messages);
  *again = opened == SD_ERROR_USER;
  if (opened == SD_INTERRUPTED) *status = SWEEP_WAITING;
  return opened;
}

static sd_status open_point(runner *r, session **out, int threads, sweep_status *status,
                            sd_messages *messages) {
  enum { ATTEMPTS = 3 };
  for (int k = 1;; k++) {
    bool again;
    sd_status opened = try_to_open(r, out, threads, status, &again, messages);
    if (!again || k == ATTEMPTS) return opened;
    sd_messages_clear(messages);
  }
}

/* The session has been closed, or there was none. */
static void conclude(runner *r, sd_status ran, sweep_status status, sd_messages *messages) {
  const jobs *all = r->all;
  size_t point = all->points[r->k];
  if (status == SWEEP_DONE || status == SWEEP_STOPPED) sweep_note(all->s, point, NULL);
  if (status == SWEEP_FAILED) sweep_note_messages(all->s, point, messages);
  sweep_end end = {point, ran, status, messages};
  all->options->left(all->options->user, r->k, &end);
  sd_model_free(r->model);
  free(r->result);
  sd_messages_free(messages);
}

static void left(void *user, size_t member) {
  const jobs *all = user;
  session_member *m = &all->members[member];
  session_close(m->session);
  conclude(&all->runners[member], m->status,
           m->status == SD_OK            ? SWEEP_DONE
           : m->status == SD_INTERRUPTED ? SWEEP_STOPPED
                                         : SWEEP_FAILED,
           m->messages);
}

void sweep_run(const sweep *s, size_t n, const size_t *points, const sweep_options *options) {
  jobs all = {.s = s,
              .points = points,
              .options = options,
              .runners = memory_new(n, sizeof *all.runners),
              .members = memory_new(n, sizeof *all.members)};
  size_t running = 0;
  for (size_t k = 0; k < n; k++) {
    sd_messages *messages = sd_messages_new();
    runner *r = &all.runners[running];
    *r = (runner){.all = &all, .k = k};
    session *opened = NULL;
    sweep_status status = SWEEP_FAILED;
    sd_status ran = open_point(r, &opened, n > 1 ? 1 : options->threads, &status, messages);
    if (opened)
      all.members[running++] = (session_member){.session = opened, .messages = messages};
    else
      conclude(r, ran, status, messages);
  }
  session_group_run(running, all.members, left, &all);
  free(all.runners);
  free(all.members);
}

/* sweep_schedule.c: which points of a sweep are run next, and what became of those that were; see sweep_scheduler.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/sweep/sweep_scheduler.h"
#include "base/clock.h"
#include "base/text.h"

/* Between tables while points are run: at least so long, and a multiple of what the last ones took. */
static const double TABLE_SECONDS = 15, TABLE_SHARE = 20;
/* How long the last tables wait for another process that is writing them. */
static const double PATIENCE = 600, PATIENCE_STOPPED = 10;

void sweep_worsen(scheduler *w, int status) {
  if (w->worst < status) w->worst = status;
}

/* --- results ----------------------------------------------------------------------------------------------- */

/* Those in between are left to another process that is writing them. */
void sweep_make_tables(scheduler *w, bool last) {
  double start = clock_seconds();
  if (sweep_is_part(w->c)) return; /* others make the rest */
  if (!last && start - w->tabled < fmax(TABLE_SECONDS, TABLE_SHARE * w->table_cost)) return;
  sd_messages *messages = sd_messages_new();
  sd_status status = sweep_write_tables(w->s,
                                        !last      ? 0
                                        : app_stop ? PATIENCE_STOPPED
                                                   : PATIENCE,
                                        true, messages);
  if (last || status == SD_ERROR_IO) {
    sweep_clear_line(w);
    sd_messages_print(messages, stderr);
    sweep_worsen(w, status);
  }
  w->no_table = status != SD_OK;
  sd_messages_free(messages);
  w->tabled = clock_seconds();
  w->table_cost = w->tabled - start;
}

/* Counts what was seen of a point. */
void sweep_remember(scheduler *w, size_t point, const sweep_result *r) {
  w->seen[point] = (unsigned char)(1 + r->status);
  w->doubts[point] = (unsigned char)r->doubts;
  w->done += r->status == SWEEP_DONE;
  w->failed += r->status == SWEEP_FAILED;
  w->other += r->status == SWEEP_OTHER;
  w->damaged += r->status == SWEEP_DAMAGED;
}

void sweep_account(scheduler *w, size_t point, sd_status status, const char *text, const cell *ran,
                   double seconds) {
  sweep_result r;
  sweep_look(w->s, point, &r);
  if ((r.status == SWEEP_WAITING || r.status == SWEEP_STOPPED) && status != SD_INTERRUPTED) {
    /* not even the reason could be kept */
    r.status = SWEEP_FAILED;
    free(r.message);
    static const char prefix[] = "error: ";
    if (strncmp(text, prefix, sizeof prefix - 1) == 0) text += sizeof prefix - 1;
    r.message = format_text("%.*s", (int)strcspn(text, "\n"), text);
  }
  double spared = fmax(ran->began, 0);
  w->tried[point] = r.status == SWEEP_RUNNING ? SKIPPED : TRIED;
  sweep_remember(w, point, &r);
  if (r.status == SWEEP_FAILED) sweep_worsen(w, SD_ERROR_NUMERIC);
  if (r.status > SWEEP_FAILED) sweep_worsen(w, SD_ERROR_USER);
  if (status == SD_ERROR_IO) sweep_worsen(w, SD_ERROR_IO);
  if (r.status == SWEEP_RUNNING)
    w->steps_total -= (double)w->steps[point];
  else
    w->steps_done += (1 - spared) * (double)w->steps[point];
  w->steps_total -= spared * (double)w->steps[point];
  if (r.message) sweep_show(w, point, &r, text, seconds);
  sweep_result_free(&r);
  sweep_make_tables(w, false);
}

/* Another process runs this point, or has finished it since the list was made. */
static bool is_taken(scheduler *w, size_t point) {
  sweep_status status = sweep_peek(w->s, point);
  bool finished = status == SWEEP_DONE && !w->c->force;
  if (!finished && status != SWEEP_RUNNING) return false;
  w->tried[point] = finished ? TRIED : SKIPPED;
  w->done += finished;
  w->steps_total -= (double)w->steps[point];
  return true;
}

/* A line each, "error: " or "warning: " before it, as many as there is room for. */
static void write_messages(const sd_messages *messages, char *text, size_t size) {
  *text = 0;
  FILE *out = fmemopen(text, size - 1, "w");
  if (!out) return;
  sd_messages_print(messages, out);
  fclose(out);
  text[size - 1] = 0;
}

/* --- who runs what ----------------------------------------------------------------------------------------- */

/* Those of a group that are still to be run. */
size_t sweep_sift(scheduler *w, sweep_group one, size_t *points) {
  size_t n = 0;
  for (size_t k = 0; k < one.n; k++) {
    size_t point = w->groups.order[one.first + k];
    if (!is_taken(w, point)) points[n++] = point;
  }
  return n;
}

size_t sweep_next(scheduler *w, size_t *points) {
  sweep_groups *g = &w->groups;
  while (g->next < g->n) {
    sweep_group one = g->list[g->next++];
    /* another process has begun with it: it will take the rest, too, unless there is nothing else to do */
    bool begun = false;
    for (size_t k = 0; one.n > 1 && !one.late && k < one.n; k++)
      begun = begun || sweep_peek(w->s, g->order[one.first + k]) == SWEEP_RUNNING;
    if (begun) {
      sweep_groups_put_off(g, one);
      continue;
    }
    size_t n = sweep_sift(w, one, points);
    if (n > 0) return n;
  }
  return 0;
}

void sweep_tell(cell *mine, const session_progress *p) {
  mine->fraction = p->expected > 0 ? (double)p->step / (double)p->expected : 0;
  if (mine->began < 0) mine->began = mine->fraction;
}

void sweep_tell_left(cell *mine, const sweep_end *end) {
  write_messages(end->messages, mine->text, sizeof mine->text);
  atomic_store(&mine->left, 1 + (int)end->ran);
}

void sweep_assign(worker *one, size_t n) {
  one->n = n;
  one->started = clock_seconds();
  for (size_t i = 0; i < n; i++) {
    one->told[i] = false;
    one->cells[i].fraction = 0;
    one->cells[i].began = -1;
    one->cells[i].text[0] = 0;
    atomic_store(&one->cells[i].left, 0);
  }
}

/* sweep_display.c: progress lines on the terminal while a sweep runs, and the state of a sweep as
 * JSON. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "app/json.h"
#include "app/sweep/sweep.h"
#include "base/team.h"

const char *sweep_finding(const sweep_result *r, char *text, size_t size) {
  *text = 0;
  if (r->has_found && r->found.n_averages > 0) {
    const sd_average *a = &r->found.averages[0];
    if (isfinite(a->mean))
      snprintf(text, size, "%s = %.4g +- %.2g%s", r->found.average_names[0], a->mean, a->error,
               a->converged ? "" : " *");
    return text;
  }
  if (!r->has_found || r->found.n_rotations == 0) return text;
  const sd_rotation *first = &r->found.rotations[0];
  if (isfinite(first->omega))
    snprintf(text, size, "%s: Omega = %.4g +- %.2g%s", r->found.rotation_names[0], first->omega,
             first->error, first->converged ? "" : " *");
  return text;
}

void sweep_show_strangers(FILE *out, const sweep *s) {
  sweep_contents there;
  sweep_list(s, &there);
  char *text = sweep_strangers_text(s, &there);
  if (text) fprintf(out, "%s\n", text);
  free(text);
  sweep_contents_free(&there);
}

void sweep_count_doubts(unsigned doubts, size_t count[DOUBT_KINDS]) {
  for (size_t k = 0; k < DOUBT_KINDS; k++) count[k] += doubts >> k & 1u;
}

void sweep_show_doubts(FILE *out, const size_t count[DOUBT_KINDS]) {
  for (size_t k = 0; k < DOUBT_KINDS; k++)
    if (count[k] > 0)
      fprintf(out, "%zu point%s %s\n", count[k], count[k] == 1 ? "" : "s", doubt_kinds[k].whose);
}

void sweep_clear_line(scheduler *w) {
  if (w->line_open) fputs("\r\033[K", stderr);
  w->line_open = false;
}

static const char *short_duration(double seconds, char *text, size_t size) {
  if (seconds >= 60) return report_duration(seconds, text, size);
  snprintf(text, size, "%.1f s", seconds);
  return text;
}

void sweep_show(scheduler *w, size_t point, const sweep_result *r, const char *text,
                double seconds) {
  char finding[200], duration[40];
  bool bad = r->status >= SWEEP_FAILED || r->doubts;
  if (w->c->quiet && !bad) return;
  sweep_clear_line(w);
  fprintf(stderr,
          "[%zu/%zu] point %zu, %s: ", w->done + w->failed + w->other + w->damaged + w->unreadable,
          w->end - w->first, point, w->s->deck.points[point].name);
  if (r->status == SWEEP_DONE) {
    sweep_finding(r, finding, sizeof finding);
    w->stars = w->stars || strchr(finding, '*');
    fprintf(stderr, "%s%s%s  (%s)\n", *finding ? finding : "done", *r->message ? "; " : "",
            r->message, short_duration(seconds, duration, sizeof duration));
    report_lines(stderr, "    ", text);
  } else if (r->status >= SWEEP_FAILED) {
    fprintf(stderr, "%s: %s%s\n", sweep_status_names[r->status], r->message,
            r->status == SWEEP_DAMAGED || r->status == SWEEP_OTHER
                ? "; --force runs the point again"
                : "");
  } else {
    fprintf(stderr, "%s\n", sweep_status_names[r->status]);
  }
}

/* Writes the progress of a worker, such as "  #17 45 %" for point 17 or "  8 points 45 %", and
 * returns the length of the text. Adds the steps that the worker has done in this call to *done,
 * and the steps that were done by earlier calls to *spared. */
static int show_worker(const scheduler *w, const worker *one, char *text, size_t size, double *done,
                       double *spared) {
  size_t running = 0, last = 0;
  double parts = 0;
  for (size_t i = 0; one->pid != 0 && i < one->n; i++) {
    if (one->told[i]) continue;
    double steps = (double)w->steps[one->points[i]], part = one->cells[i].fraction,
           since = fmax(one->cells[i].began, 0);
    *done += (part - since) * steps;
    *spared += since * steps;
    parts += part;
    last = one->points[i];
    running++;
  }
  if (running == 0 || size < 60) return 0;
  if (running == 1) return snprintf(text, size, "  #%zu %.0f %%", last, 100 * parts);
  return snprintf(text, size, "  %zu points %.0f %%", running, 100 * parts / (double)running);
}

void sweep_draw(scheduler *w) {
  double now = clock_seconds(), done = w->steps_done, spared = 0, left = NAN;
  if (!w->terminal || w->c->quiet || now - w->drawn < 0.5) return;
  w->drawn = now;
  char text[400], duration[40];
  int n = snprintf(text, sizeof text, "%zu of %zu done", w->done, w->end - w->first);
  if (w->failed) n += snprintf(text + n, sizeof text - (size_t)n, ", %zu failed", w->failed);
  for (size_t k = 0; k < w->n_workers; k++)
    n += show_worker(w, &w->workers[k], text + n, sizeof text - (size_t)n, &done, &spared);
  if (done > 0) left = (w->steps_total - spared - done) / done * (now - w->began);
  snprintf(text + n, sizeof text - (size_t)n, "  ETA %s",
           report_duration(left, duration, sizeof duration));
  report_status_line(stderr, text);
  w->line_open = true;
}

void sweep_show_start(const scheduler *w) {
  size_t groups = 0, together = 0, most = 0, alone = 0;
  for (size_t k = 0; k < w->groups.n; k++) {
    size_t n = w->groups.list[k].n;
    groups += n > 1;
    together += n > 1 ? n : 0;
    alone += n == 1;
    if (n > most) most = n;
  }
  fprintf(stderr, "%s: %zu points, %zu done", w->s->folder, w->end - w->first, w->done);
  if (groups == 1)
    fprintf(stderr, "; %zu side by side in lanes", together);
  else if (groups > 1)
    fprintf(stderr, "; %zu in lanes: %zu groups of up to %zu side by side", together, groups, most);
  if (groups > 0 && alone > 0) fprintf(stderr, ", %zu one by one", alone);
  fputc('\n', stderr);
}

void sweep_show_held(scheduler *w, size_t n, const size_t *held) {
  enum { MOST = 8 };
  if (w->c->quiet) return;
  sweep_clear_line(w);
  fprintf(stderr, "waiting for %zu point%s that other processes run:", n, n == 1 ? "" : "s");
  for (size_t k = 0; k < n && k < MOST; k++) fprintf(stderr, " #%zu", held[k]);
  fprintf(stderr, "%s\n", n > MOST ? " ..." : "");
}

void sweep_show_end(scheduler *w) {
  sweep_clear_line(w);
  if (w->c->quiet) {
    sweep_show_doubts(stderr, w->doubted);
    return;
  }
  if (w->stars) fprintf(stderr, "*: the error bar is not reliable yet\n");
  fprintf(stderr, "%zu of %zu points done", w->done, w->end - w->first);
  if (w->failed) fprintf(stderr, ", %zu failed", w->failed);
  if (w->other) fprintf(stderr, ", %zu with a result that is not this deck's", w->other);
  if (w->damaged) fprintf(stderr, ", %zu with a damaged result", w->damaged);
  if (w->unreadable) fprintf(stderr, ", %zu that cannot be read", w->unreadable);
  if (w->elsewhere) fprintf(stderr, ", %zu run by another process", w->elsewhere);
  if (sweep_is_part(w->c))
    fprintf(stderr, "; --table makes the table\n");
  else if (w->no_table)
    fprintf(stderr, "; the table could not be written\n");
  else
    fprintf(stderr, "; table: %s/table.csv\n", w->s->folder);
  sweep_show_doubts(stderr, w->doubted);
  sweep_show_strangers(stderr, w->s);
  if (w->worst == SD_ERROR_IO) return;
  if (w->left || (w->elsewhere && app_stop))
    fprintf(stderr, "stopped, everything is saved: give the command again to continue\n");
  else if (w->elsewhere)
    fprintf(stderr, "left to other processes: %zu point%s; the same command runs what they leave\n",
            w->elsewhere, w->elsewhere == 1 ? "" : "s");
}

/* --- progress of a sweep as JSON -------------------------------------------------------------- */

/* Returns the fraction of the point's steps that are done; JSON null if it is not known. */
static json_t *progress_json(const sweep_result *r) {
  if (r->status == SWEEP_DONE) return json_real(1);
  if (!r->has_found || r->status == SWEEP_OTHER || r->found.steps <= 0) return json_null();
  return json_real((double)r->found.step / (double)r->found.steps);
}

static json_t *doubts_json(const sweep_result *r) {
  json_t *list = json_array();
  for (size_t k = 0; k < DOUBT_KINDS; k++)
    if (r->doubts >> k & 1u) json_array_append_new(list, json_string(doubt_kinds[k].name));
  return list;
}

static json_t *point_json(const sweep *s, size_t k, const sweep_result *r) {
  return json_pack("{s:I, s:o, s:s, s:o, s:o, s:o, s:o, s:o}", "point", (json_int_t)k, "name",
                   json_text(s->deck.points[k].name), "status", sweep_status_names[r->status],
                   "progress", progress_json(r), "message", json_text(r->message ? r->message : ""),
                   "doubts", doubts_json(r), "rotation",
                   r->has_found ? json_rotations(&r->found) : json_array(), "averages",
                   r->has_found ? json_averages(&r->found) : json_array());
}

/* Returns an array of texts: the differences between this deck and the decks with which results
 * were made. */
static json_t *others_json(const sweep_tally *t) {
  json_t *list = json_array();
  for (size_t k = 0; k < t->n; k++) {
    char *line = sweep_tally_text(t, k);
    json_array_append_new(list, json_text(line));
    free(line);
  }
  return list;
}

static json_t *strangers_json(const sweep *s) {
  sweep_contents there;
  sweep_list(s, &there);
  char *text = sweep_strangers_text(s, &there);
  json_t *value = text ? json_text(text) : json_null();
  free(text);
  sweep_contents_free(&there);
  return value;
}

sd_status sweep_print_json(const sweep *s) {
  size_t count[SWEEP_STATUSES] = {0};
  sweep_tally others = {0};
  json_t *points = json_array(), *counts = json_object();
  for (size_t k = 0; k < s->deck.n_points; k++) {
    sweep_result r;
    sweep_look(s, k, &r);
    count[r.status]++;
    json_array_append_new(points, point_json(s, k, &r));
    sweep_tally_add(&others, &r);
    sweep_result_free(&r);
  }
  for (size_t k = 0; k < SWEEP_STATUSES; k++)
    json_object_set_new(counts, sweep_status_names[k], json_integer((json_int_t)count[k]));
  json_t *root = json_pack("{s:o, s:o, s:o, s:o, s:o}", "folder", json_text(s->folder), "count",
                           counts, "other_decks", others_json(&others), "strangers",
                           strangers_json(s), "points", points);
  const sd_status status = json_print(root);
  json_decref(root);
  sweep_tally_free(&others);
  return status;
}

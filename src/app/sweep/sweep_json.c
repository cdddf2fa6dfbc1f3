/* sweep_json.c: how far a sweep is, for programs. */
#include <stdlib.h>

#include "app/json.h"
#include "app/sweep/sweep.h"

/* Part of the steps that are done; null: nothing is known. */
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
  return json_pack("{s:I, s:o, s:s, s:o, s:o, s:o, s:o}", "point", (json_int_t)k, "name",
                   json_text(s->deck.points[k].name), "status", sweep_status_names[r->status], "progress",
                   progress_json(r), "message", json_text(r->message ? r->message : ""), "doubts",
                   doubts_json(r), "rotation", r->has_found ? json_rotations(&r->found) : json_array());
}

/* In what decks of results differ, a text each. */
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
  json_t *root =
      json_pack("{s:o, s:o, s:o, s:o, s:o}", "folder", json_text(s->folder), "count", counts, "other_decks",
                others_json(&others), "strangers", strangers_json(s), "points", points);
  const sd_status status = json_print(root);
  json_decref(root);
  sweep_tally_free(&others);
  return status;
}

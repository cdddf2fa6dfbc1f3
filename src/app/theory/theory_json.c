/* theory_json.c: what the theory says of a deck, for programs. Names and units: docs/theory.md. */
#include <math.h>

#include "slipdisk/deck.h"
#include "app/json.h"
#include "app/theory/theory.h"
#include "base/memory.h"
#include "base/text.h"

static const char *const relations[] = {
    [THEORY_OTHER_PHASE] = "other", [THEORY_IN_PHASE] = "in phase", [THEORY_OPPOSITE] = "opposite"};

static json_t *pair(const double value[2]) { return json_numbers(2, value); }

static json_t *by_configuration(const double value[4]) {
  json_t *object = json_object();
  for (int k = 0; k < 4; k++) json_object_set_new(object, theory_configurations[k], json_number(value[k]));
  return object;
}

static json_t *geometry_json(const theory_case *c) {
  return json_pack("{s:s, s:[s, s], s:b, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:b}", "upper",
                   c->upper, "supports", c->support[0], c->support[1], "swapped", (int)c->swapped, "tilt",
                   json_number(c->disk.tilt), "half_aperture", json_number(c->disk.half_aperture), "alpha",
                   pair(c->alpha), "mu", json_number(c->disk.mu), "weight", json_number(c->disk.weight),
                   "radius", json_number(c->disk.radius), "support_radius", pair(c->support_radius),
                   "inertia", json_number(c->disk.inertia), "t_g", json_number(c->t_g), "offset",
                   json_number(c->offset), "locked", (int)c->locked);
}

static json_t *tep_json(const theory_result *r) {
  json_t *list = json_array();
  for (int k = 0; k < 4; k++) {
    const sd_tep *t = &r->tep[k];
    json_array_append_new(list, json_pack("{s:s, s:o, s:o, s:o, s:b, s:b}", "configuration",
                                          theory_configurations[k], "normal", pair(t->normal), "torque",
                                          json_number(t->torque), "closed", json_number(r->torque[k]),
                                          "compressive", (int)t->compressive, "stable", (int)t->stable));
  }
  return list;
}

static json_t *steady_json(const theory_case *c, const theory_result *r) {
  const int *s = r->signs, k = 2 * (s[0] < 0) + (s[1] < 0);
  return json_pack("{s:s, s:o, s:[i, i], s:o, s:o}", "kind", "steady", "velocity", pair(c->velocity), "signs",
                   s[0], s[1], "torque", json_number(s[0] && s[1] ? r->torque[k] : NAN), "final",
                   json_number(r->final_spin));
}

static json_t *random_json(const theory_case *c, const theory_result *r) {
  const double torque = c->shared ? r->sync : r->slight;
  return json_pack("{s:s, s:b, s:i}", "kind", "random", "shared", (int)c->shared, "sign",
                   (torque > 0) - (torque < 0));
}

static json_t *periodic_json(const theory_case *c, const theory_result *r) {
  const sd_drive *d = &c->drive;
  return json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:b, s:o, s:s, s:o}", "kind", "periodic", "waveform",
                   d->waveform == SD_SINE ? "sine" : "parabola", "amplitudes", pair(d->amplitude), "phases",
                   pair(d->phase), "omega", json_number(d->omega), "amplitude", json_number(r->amplitude),
                   "even", (int)r->even, "phase", json_number(r->apart), "relation", relations[r->relation],
                   "ratio", json_number(r->ratio));
}

static json_t *drive_json(const theory_case *c, const theory_result *r) {
  switch (c->kind) {
    case THEORY_STEADY: return steady_json(c, r);
    case THEORY_PERIODIC: return periodic_json(c, r);
    case THEORY_RANDOM: return random_json(c, r);
    case THEORY_REST: break;
  }
  return json_pack("{s:s}", "kind", "rest");
}

static json_t *formulas_json(const theory_case *c, const theory_result *r) {
  const sd_sync *p = &r->parabola;
  json_t *sync = isnan(p->mean)
                     ? json_null()
                     : json_pack("{s:o, s:o, s:o, s:o, s:o, s:b}", "t1", json_number(p->t1), "t2",
                                 json_number(p->t2), "++", json_number(p->pp), "--", json_number(p->mm),
                                 "mean", json_number(p->mean), "permanent", (int)p->permanent);
  double turn = tan(c->disk.half_aperture) > c->disk.mu ? sd_reversal_phase(&c->disk) : NAN;
  return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o}", "sync", sync, "first_order", json_number(r->first_order),
                   "sine", json_number(r->sine), "limit", json_number(r->limit), "reversal_phase",
                   json_number(turn), "slight_tilt",
                   json_pack("{s:o, s:o}", "all", json_number(r->slight), "sync", json_number(r->sync)));
}

static json_t *solution_json(const theory_case *c, const theory_result *r) {
  if (!r->solved) return json_null();
  const sd_sliding *s = &r->solution;
  json_t *pieces = json_array();
  for (size_t k = 0; k < s->n_pieces; k++) {
    const sd_sliding_piece *p = &s->pieces[k];
    json_array_append_new(pieces, json_pack("{s:o, s:o, s:o, s:[i, i]}", "start", json_number(p->start),
                                            "omega", json_number(p->omega), "acceleration",
                                            json_number(p->acceleration), "signs", p->sign[0], p->sign[1]));
  }
  return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:b, s:o}", "mean", json_number(s->mean), "mean_scaled",
                   json_number(s->mean * c->t_g), "mean_normalised",
                   json_number(s->mean / (r->amplitude * c->drive.omega)), "period", json_number(s->period),
                   "durations", by_configuration(s->duration), "stuck", json_number(s->stuck), "permanent",
                   (int)s->permanent, "pieces", pieces);
}

bool theory_json(FILE *out, const sd_model *m, const theory_case *c, const theory_result *r) {
  char *deck = text_clean(memory_text(sd_model_deck(m)->path));
  json_t *root = json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o}", "deck", deck, "title",
                           m->title ? m->title : "", "geometry", geometry_json(c), "tep", tep_json(r),
                           "drive", drive_json(c, r), "formulas", formulas_json(c, r), "solution",
                           c->kind == THEORY_PERIODIC ? solution_json(c, r) : json_null());
  bool done = root && json_dumpf(root, out, JSON_INDENT(2)) == 0;
  if (done) fputc('\n', out);
  json_decref(root);
  free(deck);
  return done;
}

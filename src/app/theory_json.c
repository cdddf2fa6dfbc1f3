/* theory_json.c: what the theory says of a deck, for programs. Names and units: docs/theory.md. */
#include <jansson.h>
#include <math.h>

#include "slipdisk/deck.h"
#include "app/theory.h"
#include "base/text.h"
#include "io/store/file.h"

static const char *const kinds[] = {[THEORY_REST] = "rest",
                                    [THEORY_STEADY] = "steady",
                                    [THEORY_PERIODIC] = "periodic",
                                    [THEORY_RANDOM] = "random"};
static const char *const relations[] = {
    [THEORY_OTHER_PHASE] = "other", [THEORY_IN_PHASE] = "in phase", [THEORY_OPPOSITE] = "opposite"};

/* JSON has no NaN: what does not apply is null. */
static json_t *real(double value) { return isfinite(value) ? json_real(value) : json_null(); }

static json_t *pair(const double value[2]) { return json_pack("[o, o]", real(value[0]), real(value[1])); }

static json_t *by_configuration(const double value[4]) {
  json_t *object = json_object();
  for (int k = 0; k < 4; k++) json_object_set_new(object, theory_configurations[k], real(value[k]));
  return object;
}

static json_t *geometry_json(const theory_case *c) {
  return json_pack("{s:s, s:[s, s], s:b, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:b}", "upper",
                   c->upper, "supports", c->support[0], c->support[1], "swapped", (int)c->swapped, "tilt",
                   real(c->disk.tilt), "half_aperture", real(c->disk.half_aperture), "alpha", pair(c->alpha),
                   "mu", real(c->disk.mu), "weight", real(c->disk.weight), "radius", real(c->disk.radius),
                   "support_radius", pair(c->support_radius), "inertia", real(c->disk.inertia), "t_g",
                   real(c->t_g), "offset", real(c->offset), "locked", (int)c->locked);
}

static json_t *tep_json(const theory_result *r) {
  json_t *list = json_array();
  for (int k = 0; k < 4; k++) {
    const sd_tep *t = &r->tep[k];
    json_array_append_new(list, json_pack("{s:s, s:o, s:o, s:o, s:b, s:b}", "configuration",
                                          theory_configurations[k], "normal", pair(t->normal), "torque",
                                          real(t->torque), "closed", real(r->torque[k]), "compressive",
                                          (int)t->compressive, "stable", (int)t->stable));
  }
  return list;
}

static json_t *drive_json(const theory_case *c, const theory_result *r) {
  json_t *drive = json_pack("{s:s}", "kind", kinds[c->kind]);
  if (c->kind == THEORY_STEADY) {
    json_object_set_new(drive, "velocity", pair(c->velocity));
    json_object_set_new(drive, "signs", json_pack("[i, i]", r->signs[0], r->signs[1]));
    int k = 2 * (r->signs[0] < 0) + (r->signs[1] < 0);
    bool slides = r->signs[0] && r->signs[1];
    json_object_set_new(drive, "torque", real(slides ? r->torque[k] : NAN));
    json_object_set_new(drive, "final", real(r->final_spin));
  } else if (c->kind == THEORY_RANDOM) {
    double torque = c->shared ? r->sync : r->slight;
    json_object_set_new(drive, "shared", json_boolean(c->shared));
    json_object_set_new(drive, "sign", json_integer((torque > 0) - (torque < 0)));
  } else if (c->kind == THEORY_PERIODIC) {
    const sd_drive *d = &c->drive;
    json_object_set_new(drive, "waveform", json_string(d->waveform == SD_SINE ? "sine" : "parabola"));
    json_object_set_new(drive, "amplitudes", pair(d->amplitude));
    json_object_set_new(drive, "phases", pair(d->phase));
    json_object_set_new(drive, "omega", real(d->omega));
    json_object_set_new(drive, "amplitude", real(r->amplitude));
    json_object_set_new(drive, "even", json_boolean(r->even));
    json_object_set_new(drive, "phase", real(r->apart));
    json_object_set_new(drive, "relation", json_string(relations[r->relation]));
    json_object_set_new(drive, "ratio", real(r->ratio));
  }
  return drive;
}

static json_t *formulas_json(const theory_case *c, const theory_result *r) {
  const sd_sync *p = &r->parabola;
  json_t *sync = isnan(p->mean) ? json_null()
                                : json_pack("{s:o, s:o, s:o, s:o, s:o, s:b}", "t1", real(p->t1), "t2",
                                            real(p->t2), "++", real(p->pp), "--", real(p->mm), "mean",
                                            real(p->mean), "permanent", (int)p->permanent);
  double turn = tan(c->disk.half_aperture) > c->disk.mu ? sd_reversal_phase(&c->disk) : NAN;
  return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o}", "sync", sync, "first_order", real(r->first_order),
                   "sine", real(r->sine), "limit", real(r->limit), "reversal_phase", real(turn),
                   "slight_tilt", json_pack("{s:o, s:o}", "all", real(r->slight), "sync", real(r->sync)));
}

static json_t *solution_json(const theory_case *c, const theory_result *r) {
  if (!r->solved) return json_null();
  const sd_sliding *s = &r->solution;
  json_t *pieces = json_array();
  for (size_t k = 0; k < s->n_pieces; k++) {
    const sd_sliding_piece *p = &s->pieces[k];
    json_array_append_new(pieces, json_pack("{s:o, s:o, s:o, s:[i, i]}", "start", real(p->start), "omega",
                                            real(p->omega), "acceleration", real(p->acceleration), "signs",
                                            p->sign[0], p->sign[1]));
  }
  return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:b, s:o}", "mean", real(s->mean), "mean_scaled",
                   real(s->mean * c->t_g), "mean_normalised", real(s->mean / (r->amplitude * c->drive.omega)),
                   "period", real(s->period), "durations", by_configuration(s->duration), "stuck",
                   real(s->stuck), "permanent", (int)s->permanent, "pieces", pieces);
}

bool theory_json(FILE *out, const sd_model *m, const theory_case *c, const theory_result *r) {
  char *deck = text_clean(format_text("%s", sd_model_deck(m)->path));
  json_t *root = json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o}", "deck", deck ? deck : "", "title",
                           m->title ? m->title : "", "geometry", geometry_json(c), "tep", tep_json(r),
                           "drive", drive_json(c, r), "formulas", formulas_json(c, r), "solution",
                           c->kind == THEORY_PERIODIC ? solution_json(c, r) : json_null());
  bool done = root && json_dumpf(root, out, JSON_INDENT(2)) == 0;
  if (done) fputc('\n', out);
  json_decref(root);
  free(deck);
  return done;
}

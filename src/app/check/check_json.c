/* check_json.c: what `check` has found, as JSON. */
#include <math.h>

#include "app/check/check.h"
#include "app/json.h"
#include "model/overlaps.h"
#include "slipdisk/deck.h"

static json_t *body_json(const sd_model *m, uint32_t body) {
  char name[96];
  return json_string(sd_model_body_name(m, body, name, sizeof name));
}

static json_t *groups_json(const sd_model *m) {
  json_t *object = json_object();
  for (size_t k = 0; k < m->n_groups; k++) {
    json_int_t n = 0;
    for (size_t i = 0; i < m->n_disks; i++) n += m->disks[i].group == (int)k;
    json_object_set_new(object, m->groups[k], json_integer(n));
  }
  return object;
}

static json_t *positive(double x) { return x > 0 ? json_number(x) : json_null(); }

static json_t *cell_json(const sd_cell *c) {
  if (!c->asked) return json_null();
  json_t *object = json_object(), *rate = json_object(), *stress = json_object();
  for (int k = 0; k < SD_CELL_COMPONENTS; k++)
    json_object_set_new(c->controlled[k] ? stress : rate, check_components[k],
                        json_number(c->controlled[k] ? c->stress[k] : c->rate[k]));
  json_object_set_new(object, "rate", rate);
  json_object_set_new(object, "stress", stress);
  return object;
}

static json_t *phases_json(const sd_model *m) {
  json_t *list = json_array();
  for (size_t k = 0; k < m->n_phases; k++) {
    const sd_phase *p = &m->phases[k];
    const sd_compress *c = &p->compress;
    json_int_t on = 0;
    for (size_t j = 0; j < m->n_motions; j++) on += p->active[j];
    json_t *phase =
        json_pack("{s:s, s:I, s:o, s:I, s:b, s:b, s:b}", "name", p->name ? p->name : "", "steps",
                  (json_int_t)p->steps, "time", json_number((double)p->steps * m->dt), "motions", on,
                  "measured", (int)p->measure, "relax", (int)p->relax, "settle", (int)p->settle.asked);
    json_t *compress =
        !c->asked ? json_null()
                  : json_pack("{s:o, s:o, s:o}", "pressure", positive(c->pressure), "fraction",
                              positive(c->fraction), "time", json_number(sd_model_compress_time(m, k)));
    json_object_set_new(phase, "compress", compress);
    json_object_set_new(phase, "cell", cell_json(&p->cell));
    json_array_append_new(list, phase);
  }
  return list;
}

static json_t *rains_json(const sd_model *m) {
  json_t *list = json_array();
  for (size_t k = 0; k < m->n_rains; k++) {
    const sd_rain *r = &m->rains[k];
    json_array_append_new(list, json_pack("{s:I, s:I, s:o}", "disks", (json_int_t)r->count, "batch",
                                          (json_int_t)r->batch, "interval",
                                          json_number((double)r->interval * m->dt)));
  }
  return list;
}

static json_t *limits_json(const sd_limits *l) {
  return json_pack("{s:o, s:o, s:o, s:b}", "residual", json_number(l->residual), "open", json_number(l->open),
                   "displacement", json_number(l->displacement), "unstable_step", (int)l->unstable_step);
}

static json_t *time_step_json(const sd_model *m) {
  uint32_t disk = 0;
  double period = sd_model_shortest_period(m, &disk);
  const sd_step_limit limit = sd_model_step_limit(m);
  bool any = isfinite(period), bound = isfinite(limit.dt);
  return json_pack("{s:o, s:s, s:o, s:o, s:o, s:o, s:o}", "dt", json_number(m->dt), "integrator",
                   m->integrator == SD_GEAR5 ? "gear5" : "verlet", "period", json_number(period), "period_of",
                   any ? body_json(m, disk) : json_null(), "limit", json_number(limit.dt), "limit_of",
                   bound ? body_json(m, limit.disk) : json_null(), "limit_by",
                   bound ? json_string(check_bounds[limit.bound]) : json_null());
}

static json_t *overlap_json(const sd_model *m, const first_overlap *o) {
  if (!(o->depth > 0)) return json_null();
  return json_pack("{s:[o, o], s:o, s:o, s:o, s:o}", "bodies", body_json(m, o->a), body_json(m, o->b),
                   "depth", json_number(o->depth), "relative", json_number(o->relative), "force",
                   json_number(o->force), "weight", positive(o->weight));
}

static json_t *watched_json(const sd_model *m) {
  json_t *list = json_array();
  for (size_t k = 0; k < 2 * m->n_slides; k++) {
    const sd_slide_watch *w = &m->slides[k / 2];
    uint32_t partner = w->partner[k % 2];
    json_array_append_new(list,
                          json_pack("{s:[o, o], s:o}", "bodies", body_json(m, w->disk), body_json(m, partner),
                                    "gap", json_number(overlaps_first_gap(m, w->disk, partner))));
  }
  return list;
}

typedef struct restitution_list {
  const sd_model *m;
  json_t *list;
} restitution_list;

static void add_restitution(void *user, int a, int b, double e, double mass, const char *bodies) {
  const restitution_list *r = user;
  json_array_append_new(r->list, json_pack("{s:[s, s], s:o, s:s, s:o}", "materials", r->m->materials[a].name,
                                           r->m->materials[b].name, "e", json_number(e), "bodies", bodies,
                                           "effective_mass", positive(mass)));
}

static json_t *restitution_json(const sd_model *m) {
  restitution_list r = {m, json_array()};
  check_restitutions(m, add_restitution, &r);
  return r.list;
}

static json_t *size_json(const result_size *s) {
  return json_pack("{s:I, s:I, s:I, s:o, s:o, s:b}", "series", (json_int_t)s->series, "frames",
                   (json_int_t)s->frames, "contacts", (json_int_t)s->contacts, "bytes", json_number(s->bytes),
                   "memory", json_number(s->memory), "at_most", (int)s->at_most);
}

static json_t *speed_json(const check_found *f) {
  if (f->tried == 0) return json_null();
  return json_pack("{s:o, s:i, s:s, s:I, s:o}", "steps_per_second", json_number(f->speed), "threads",
                   f->threads, "path", f->path, "tried", (json_int_t)f->tried, "run_seconds",
                   json_number(check_run_seconds(f)));
}

static json_t *sweep_json(const check_sweep *s) {
  if (s->points == 0) return json_null();
  return json_pack("{s:I, s:I, s:o, s:I, s:o}", "points", (json_int_t)s->points, "sets", (json_int_t)s->sets,
                   "steps", json_number(s->steps), "in_lanes", (json_int_t)s->together, "seconds",
                   json_number(s->seconds));
}

static void add_model(json_t *root, const check_found *f) {
  const sd_model *m = f->model;
  const struct {
    const char *name;
    json_t *value;
  } rest[] = {
      {"title", json_string(m->title ? m->title : "")},
      {"disks", json_integer((json_int_t)m->n_disks)},
      {"free", json_integer((json_int_t)m->n_free)},
      {"clumps", json_integer((json_int_t)m->n_clumps)},
      {"walls", json_integer((json_int_t)m->n_walls)},
      {"groups", groups_json(m)},
      {"bounds", json_boolean(m->bounds.given)},
      {"steps", json_integer((json_int_t)sd_model_steps(m))},
      {"least_steps", m->until.asked ? json_integer((json_int_t)m->until.least) : json_null()},
      {"phases", phases_json(m)},
      {"rains", rains_json(m)},
      {"limits", limits_json(&m->limits)},
      {"time_step", time_step_json(m)},
      {"overlap", overlap_json(m, &f->overlap)},
      {"watched", watched_json(m)},
      {"restitution", restitution_json(m)},
      {"result", size_json(&f->size)},
      {"contacts", f->probed ? json_integer((json_int_t)f->contacts) : json_null()},
      {"speed", speed_json(f)},
      {"sweep", sweep_json(&f->sweep)},
  };
  for (size_t k = 0; k < sizeof rest / sizeof *rest; k++)
    json_object_set_new(root, rest[k].name, rest[k].value);
}

int check_print_json(const check_found *f, const char *deck, bool full, int status,
                     const sd_messages *messages) {
  json_t *root = json_pack("{s:o, s:i, s:o}", "deck", json_text(deck), "status", status, "messages",
                           json_messages(messages));
  if (f->model) add_model(root, f);
  if (f->model && full) json_object_set_new(root, "full", json_text(sd_model_deck(f->model)->full));
  const sd_status printed = json_print(root);
  json_decref(root);
  return printed == SD_OK ? status : (int)printed;
}

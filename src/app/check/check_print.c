/* check_print.c: prints the findings of the subcommand `check`, as text and as JSON; see
 * check.h. */
#include <gsl/gsl_sort.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "app/check/check.h"
#include "app/json.h"
#include "base/memory.h"
#include "model/field_kinds.h"
#include "model/normal_laws.h"
#include "model/overlaps.h"
#include "slipdisk/deck.h"
#include "slipdisk/theory.h"

/* Names of the quantities that bound the time step, indexed by sd_step_limit.bound, and names of
 * the components of the deformation of a box. */
static const char *const bound_names[] = {"normal spring", "tangential spring", "viscosity",
                                          "fields"};
static const char *const components[] = {"xx", "yy", "xy"};

/* --- restitution ------------------------------------------------------------------------------ */

/* Returns the median mass of the free disks of a material; 0: no free disk is of this material. */
static double typical_mass(const sd_model *m, int material) {
  double *mass = NULL, middle = 0;
  size_t n = 0;
  const bool room = memory_resize_row(&mass, m->n_disks, sizeof *mass);
  if (!room) shortage_note();
  for (size_t i = 0; room && i < m->n_disks; i++)
    if (m->disks[i].material == material && !m->disks[i].driven) mass[n++] = m->disks[i].mass;
  if (n) {
    gsl_sort(mass, 1, n);
    middle = mass[n / 2];
  }
  free(mass);
  return middle;
}

/* True if a wall or a disk with prescribed motion is of this material. */
static bool has_still(const sd_model *m, int material) {
  for (size_t w = 0; w < m->n_walls; w++)
    if (m->walls[w].material == material) return true;
  for (size_t i = 0; i < m->n_disks; i++)
    if (m->disks[i].material == material && m->disks[i].driven) return true;
  return false;
}

static size_t count_free(const sd_model *m, int material) {
  size_t n = 0;
  for (size_t i = 0; i < m->n_disks; i++)
    n += m->disks[i].material == material && !m->disks[i].driven;
  return n;
}

static double restitution_at(const sd_contact_law *law, double mass) {
  const double gamma = law->gamma_n + law_tsuji(law) * sqrt(law->k_n * mass);
  const double b = 0.5 * gamma / sqrt(law->k_n * mass); /* Damping ratio, 1: critical */
  if (law->damping_pulls) return b < 1.0 ? exp(-M_PI * b / sqrt((1.0 - b) * (1.0 + b))) : 0.0;
  return sd_restitution(law->k_n, gamma, mass).restitution;
}

/* Returns the coefficient of restitution of a nonlinear (Hertz) law, which holds for all masses, as
 * given in the deck; NAN if the law has gamma_n, since restitution then depends on the speed. */
static double given_restitution(const sd_contact_law *law) {
  if (law->gamma_n > 0.0) return NAN;
  return law->restitution > 0.0 ? law->restitution : 1.0;
}

/* Restitution of materials a and b, whose bodies can touch. */
typedef struct bounce {
  int a, b;
  double e;        /* Coefficient of restitution; NAN if it depends on the speed */
  double at_dt[2]; /* Its range at the model's time step (check_restitution_at_dt) */
  double mass;     /* Effective mass of these bodies; 0: e holds for any mass */
  const char *bodies;
} bounce;

typedef void restitution_visitor(void *user, const bounce *found);

/* Visits bodies of materials a and b with a linear law. */
static void visit_linear(const sd_model *m, int a, int b, double mass, const char *bodies,
                         restitution_visitor *visit, void *user) {
  const sd_contact_law *law = sd_model_law(m, a, b);
  bounce found = {a, b, restitution_at(law, mass), {NAN, NAN}, mass, bodies};
  check_restitution_at_dt(m, law, mass, found.at_dt);
  visit(user, &found);
}

static void visit_restitutions(const sd_model *m, restitution_visitor *visit, void *user) {
  const char *still = "a free disk on a fixed body";
  for (int a = 0; a < (int)m->n_materials; a++)
    for (int b = a; b < (int)m->n_materials; b++) {
      const sd_contact_law *law = sd_model_law(m, a, b);
      double ma = typical_mass(m, a), mb = typical_mass(m, b);
      if (law->k_n <= 0) continue;
      if (law->normal != SD_NORMAL_LINEAR) {
        visit(user, &(bounce){a, b, given_restitution(law), {NAN, NAN}, 0, "any"});
        continue;
      }
      size_t enough = a == b ? 2 : 1;
      if (count_free(m, a) >= enough && count_free(m, b) >= enough)
        visit_linear(m, a, b, ma * mb / (ma + mb), "two free disks", visit, user);
      if (ma > 0 && has_still(m, b)) visit_linear(m, a, b, ma, still, visit, user);
      if (a != b && mb > 0 && has_still(m, a)) visit_linear(m, b, a, mb, still, visit, user);
    }
}

/* Returns the number of disks in a group. */
static size_t group_size(const sd_model *m, size_t group) {
  size_t n = 0;
  for (size_t i = 0; i < m->n_disks; i++) n += m->disks[i].group == (int)group;
  return n;
}

/* Returns the wall time of the whole run, s, for the deck without its sweep. */
static double run_seconds(const check_found *f) {
  return (double)sd_model_steps(f->model) / f->speed;
}

/* --- text output: comments of a deck ---------------------------------------------------------- */

static void print_duration(double s) {
  if (s < 120)
    printf("%.3g s", s);
  else if (s < 7200)
    printf("%.3g min", s / 60);
  else if (s < 48 * 3600)
    printf("%.3g h", s / 3600);
  else
    printf("%.3g days", s / 86400);
}

static void print_counts(const sd_model *m) {
  printf("# disks       %zu: %zu free, %zu fixed or moved\n", m->n_disks, m->n_free,
         m->n_disks - m->n_free);
  if (m->n_clumps) {
    size_t n = 0;
    for (size_t i = 0; i < m->n_disks; i++) n += m->disks[i].clump > 0;
    printf("# clumps      %zu, of %zu disks\n", m->n_clumps, n);
  }
  if (m->n_walls) printf("# walls       %zu\n", m->n_walls);
  for (size_t k = 0; k < m->n_groups; k++)
    printf("# group       \"%s\": %zu disks\n", m->groups[k], group_size(m, k));
}

/* Prints the deformation of the periodic box: for each component its rate, or the stress that is to
 * be reached. */
static void print_cell(const sd_cell *c) {
  const char *comma = ", cell";
  for (int k = 0; k < SD_CELL_COMPONENTS; k++) {
    if (!c->asked || (!c->controlled[k] && c->rate[k] == 0.0)) continue;
    printf("%s %s %s %g", comma, components[k], c->controlled[k] ? "to stress" : "at rate",
           c->controlled[k] ? c->stress[k] : c->rate[k]);
    comma = ",";
  }
}

/* Prints whether a phase relaxes or compresses the system, and the goals that may end the phase
 * early. */
static void print_phase_aims(const sd_model *m, size_t k) {
  const sd_phase *p = &m->phases[k];
  const sd_compress *c = &p->compress;
  double time = sd_model_compress_time(m, k);
  if (p->relax) printf(", relaxed");
  if (c->asked && c->pressure > 0) printf(", compressed to pressure %g", c->pressure);
  if (c->asked && c->fraction > 0) printf(", compressed to packing fraction %g", c->fraction);
  print_cell(&p->cell);
  if (time > 0) printf(" (after about time %.3g)", time);
  if (c->asked && !p->settle.asked) printf(" and held there");
  if (p->settle.asked) printf(", until at rest");
}

static void print_rains(const sd_model *m) {
  for (size_t k = 0; k < m->n_rains; k++) {
    const sd_rain *r = &m->rains[k];
    size_t batches = (r->count + r->batch - 1) / r->batch;
    printf("# rain        %zu disks in %zu batches of %zu, one every %g: the last at time %g\n",
           r->count, batches, r->batch, (double)r->interval * m->dt,
           (double)(batches - 1) * (double)r->interval * m->dt);
  }
}

/* Prints a note if disks can fall out of the system without a message: there is gravity, but no
 * bounds, no walls and no periodic direction. */
static void print_bounds(const sd_model *m) {
  bool falls = m->n_free > 0 && (m->gravity[0] != 0 || m->gravity[1] != 0);
  if (!m->bounds.given && m->n_walls == 0 && falls && !m->periodic[0] && !m->periodic[1])
    printf(
        "# bounds      none: a disk that falls off is not told of; with `bounds = { };` it is\n");
}

static void print_limits(const sd_model *m) {
  const sd_limits *l = &m->limits;
  printf("# limits      in doubt beyond:");
  if (l->residual > 0) printf(" residual %g", l->residual);
  if (l->open > 0) printf(" open %g", l->open);
  if (l->displacement > 0) printf(" displacement %g", l->displacement);
  printf("%s\n", l->residual > 0 || l->open > 0 || l->displacement > 0 ? "" : " nothing");
}

static void print_fields(const sd_model *m) {
  for (size_t k = 0; k < m->n_fields; k++) {
    const sd_body_force *f = &m->fields[k];
    printf("# field       %s%s%s on ", f->name ? f->name : "", f->name ? ": " : "",
           field_kind_name(f->kind));
    if (f->n_disks)
      printf("%zu disks\n", f->n_disks);
    else
      printf("all free disks\n");
  }
}

static void print_phases(const sd_model *m) {
  for (size_t k = 0; k < m->n_phases; k++) {
    const sd_phase *p = &m->phases[k];
    size_t on = 0, acting = 0;
    for (size_t j = 0; j < m->n_motions; j++) on += p->active[j];
    for (size_t j = 0; j < m->n_fields; j++) acting += body_force_is_on(m, j, (int64_t)k);
    printf("# phase       %s%s%s%lld steps, time %g", p->name ? p->name : "", p->name ? ": " : "",
           p->settle.asked ? "at most " : "", (long long)p->steps, (double)p->steps * m->dt);
    if (m->n_motions) printf(", %zu of %zu prescribed signals on", on, m->n_motions);
    if (m->n_fields) printf(", %zu of %zu fields on", acting, m->n_fields);
    print_phase_aims(m, k);
    printf("%s\n", p->measure ? ", measured" : "");
  }
  print_rains(m);
  const sd_until *u = &m->until;
  if (u->asked)
    printf("#             at most; it ends after %lld steps, time %g, or later, with the goal of "
           "`until`\n",
           (long long)u->least, (double)u->least * m->dt);
}

static void print_time_step(const sd_model *m) {
  uint32_t disk = 0;
  double period = sd_model_shortest_period(m, &disk);
  char name[96];
  if (!isfinite(period)) {
    printf("# time step   %g; no disk is free to move in a contact\n", m->dt);
    return;
  }
  printf("# time step   %g; shortest contact period %.4g (%s): %.4g steps\n", m->dt, period,
         sd_model_body_name(m, disk, name, sizeof name), period / m->dt);
  const sd_step_limit limit = sd_model_step_limit(m);
  printf("#             stable up to %.3g (%s of %s, %s): %.3g of it\n", limit.dt,
         bound_names[limit.bound], sd_model_body_name(m, limit.disk, name, sizeof name),
         m->integrator == SD_GEAR5 ? "gear5" : "verlet", m->dt / limit.dt);
}

static void print_positions(const check_found *f) {
  const sd_model *m = f->model;
  const first_overlap *o = &f->overlap;
  char one[96], two[96];
  if (o->depth > 0) {
    printf("# overlap     at most %.3g of the radius: %s and %s, force %.3g", o->relative,
           sd_model_body_name(m, o->a, one, sizeof one),
           sd_model_body_name(m, o->b, two, sizeof two), o->force);
    if (o->weight > 0) printf(", %.3g times the weight", o->force / o->weight);
    printf("\n");
  }
  for (size_t k = 0; k < m->n_slides; k++)
    for (int c = 0; c < 2; c++) {
      const sd_slide_watch *w = &m->slides[k];
      double gap = overlaps_first_gap(m, w->disk, w->partner[c]) / m->disks[w->disk].radius;
      if (gap <= 1e-6 || m->disks[w->disk].waiting) continue;
      printf("# watched     %s and %s begin %.3g radii apart\n",
             sd_model_body_name(m, w->disk, one, sizeof one),
             sd_model_body_name(m, w->partner[c], two, sizeof two), gap);
    }
}

static void print_restitution(void *user, const bounce *found) {
  const sd_model *m = user;
  const double e = found->e;
  printf("# restitution \"%s\" on \"%s\": ", m->materials[found->a].name,
         m->materials[found->b].name);
  if (isnan(e))
    printf("depends on the speed");
  else if (found->mass > 0)
    printf("e = %.4f (%s, effective mass %.4g)", e, found->bodies, found->mass);
  else
    printf("e = %g at any speed", e);
  const double *at_dt = found->at_dt, least = fmax(1e-3 * e, 5e-5);
  if (e - at_dt[0] > least || at_dt[1] - e > least)
    printf(", %.4f to %.4f at this dt", at_dt[0], at_dt[1]);
  printf("\n");
}

static void print_size(const check_found *f) {
  const result_size *s = &f->size;
  char bytes[40];
  printf("# result      %s%" PRId64 " rows of the series, %" PRId64 " frames, %" PRId64
         " contact tables: about %s",
         s->at_most ? "at most " : "", s->series, s->frames, s->contacts,
         size_text(s->bytes, bytes, sizeof bytes));
  if (s->contacts > 2) printf(" when there are %zu contacts", s->most_contacts);
  printf(", and as much again while it is put together\n");
  printf("# memory      about %s in one process", size_text(s->memory, bytes, sizeof bytes));
  if (s->most_contacts > 0) printf(" when there are %zu contacts", s->most_contacts);
  if (s->unsaved > 0.1 * s->memory)
    printf(", up to %s of it rows that are not saved yet",
           size_text(s->unsaved, bytes, sizeof bytes));
  printf("\n");
}

static void print_speed(const check_found *f) {
  if (f->probed) printf("# contacts    %zu at the start\n", f->contacts);
  if (f->tried == 0) return;
  printf("# speed       about %.3g steps per second (%d thread%s, %s), measured on the first %lld "
         "steps\n",
         f->speed, f->threads, f->threads == 1 ? "" : "s", f->path, (long long)f->tried);
  printf("# run time    about ");
  print_duration(run_seconds(f));
  printf(" for %s%lld steps\n", f->model->until.asked ? "at most " : "",
         (long long)sd_model_steps(f->model));
}

static void print_sweep(const check_found *f) {
  const check_sweep *s = &f->sweep;
  if (s->points == 0) return;
  printf("# sweep       %zu point%s", s->points, s->points == 1 ? "" : "s");
  if (s->sets < s->points) printf(", %zu set%s of values", s->sets, s->sets == 1 ? "" : "s");
  printf("; `slipdisk sweep` runs them, this is the deck as it stands\n");
  printf("#             %s%.4g steps in all", f->model->until.asked ? "at most " : "", s->steps);
  if (isfinite(s->seconds)) {
    printf(", about ");
    print_duration(s->seconds);
    printf(" with one worker, %s", s->lanes ? "in lanes" : "one after the other");
    if (s->points > 1) printf("; -j N shares them among N");
  }
  printf("\n");
  if (s->together > 1 && s->width > 1)
    printf("#             %zu of them can go in lanes, up to %zu side by side\n", s->together,
           s->width);
}

void check_print(const check_found *f) {
  print_counts(f->model);
  print_bounds(f->model);
  print_fields(f->model);
  print_phases(f->model);
  print_limits(f->model);
  print_time_step(f->model);
  print_positions(f);
  visit_restitutions(f->model, print_restitution, (void *)f->model);
  if (f->size.bytes > 0) print_size(f);
  print_speed(f);
  print_sweep(f);
}

/* --- JSON output ------------------------------------------------------------------------------ */

static json_t *body_json(const sd_model *m, uint32_t body) {
  char name[96];
  return json_string(sd_model_body_name(m, body, name, sizeof name));
}

static json_t *groups_json(const sd_model *m) {
  json_t *object = json_object();
  for (size_t k = 0; k < m->n_groups; k++)
    json_object_set_new(object, m->groups[k], json_integer((json_int_t)group_size(m, k)));
  return object;
}

static json_t *positive(double x) { return x > 0 ? json_number(x) : json_null(); }

static json_t *cell_json(const sd_cell *c) {
  if (!c->asked) return json_null();
  json_t *object = json_object(), *rate = json_object(), *stress = json_object();
  for (int k = 0; k < SD_CELL_COMPONENTS; k++)
    json_object_set_new(c->controlled[k] ? stress : rate, components[k],
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
    json_t *phase = json_pack(
        "{s:s, s:I, s:o, s:I, s:b, s:b, s:b}", "name", p->name ? p->name : "", "steps",
        (json_int_t)p->steps, "time", json_number((double)p->steps * m->dt), "motions", on,
        "measured", (int)p->measure, "relax", (int)p->relax, "settle", (int)p->settle.asked);
    json_t *compress = !c->asked ? json_null()
                                 : json_pack("{s:o, s:o, s:o}", "pressure", positive(c->pressure),
                                             "fraction", positive(c->fraction), "time",
                                             json_number(sd_model_compress_time(m, k)));
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
  return json_pack("{s:o, s:o, s:o, s:b}", "residual", json_number(l->residual), "open",
                   json_number(l->open), "displacement", json_number(l->displacement),
                   "unstable_step", (int)l->unstable_step);
}

static json_t *time_step_json(const sd_model *m) {
  uint32_t disk = 0;
  double period = sd_model_shortest_period(m, &disk);
  const sd_step_limit limit = sd_model_step_limit(m);
  bool any = isfinite(period), bound = isfinite(limit.dt);
  return json_pack("{s:o, s:s, s:o, s:o, s:o, s:o, s:o}", "dt", json_number(m->dt), "integrator",
                   m->integrator == SD_GEAR5 ? "gear5" : "verlet", "period", json_number(period),
                   "period_of", any ? body_json(m, disk) : json_null(), "limit",
                   json_number(limit.dt), "limit_of",
                   bound ? body_json(m, limit.disk) : json_null(), "limit_by",
                   bound ? json_string(bound_names[limit.bound]) : json_null());
}

static json_t *overlap_json(const sd_model *m, const first_overlap *o) {
  if (!(o->depth > 0)) return json_null();
  return json_pack("{s:[o, o], s:o, s:o, s:o, s:o}", "bodies", body_json(m, o->a),
                   body_json(m, o->b), "depth", json_number(o->depth), "relative",
                   json_number(o->relative), "force", json_number(o->force), "weight",
                   positive(o->weight));
}

static json_t *watched_json(const sd_model *m) {
  json_t *list = json_array();
  for (size_t k = 0; k < 2 * m->n_slides; k++) {
    const sd_slide_watch *w = &m->slides[k / 2];
    uint32_t partner = w->partner[k % 2];
    json_array_append_new(list, json_pack("{s:[o, o], s:o}", "bodies", body_json(m, w->disk),
                                          body_json(m, partner), "gap",
                                          json_number(overlaps_first_gap(m, w->disk, partner))));
  }
  return list;
}

typedef struct restitution_list {
  const sd_model *m;
  json_t *list;
} restitution_list;

static void add_restitution(void *user, const bounce *found) {
  const restitution_list *r = user;
  const sd_material *of = r->m->materials;
  json_array_append_new(
      r->list, json_pack("{s:[s, s], s:o, s:[o, o], s:s, s:o}", "materials", of[found->a].name,
                         of[found->b].name, "e", json_number(found->e), "e_at_dt",
                         json_number(found->at_dt[0]), json_number(found->at_dt[1]), "bodies",
                         found->bodies, "effective_mass", positive(found->mass)));
}

static json_t *restitution_json(const sd_model *m) {
  restitution_list r = {m, json_array()};
  visit_restitutions(m, add_restitution, &r);
  return r.list;
}

static json_t *size_json(const result_size *s) {
  return json_pack("{s:I, s:I, s:I, s:o, s:o, s:b}", "series", (json_int_t)s->series, "frames",
                   (json_int_t)s->frames, "contacts", (json_int_t)s->contacts, "bytes",
                   json_number(s->bytes), "memory", json_number(s->memory), "at_most",
                   (int)s->at_most);
}

static json_t *speed_json(const check_found *f) {
  if (f->tried == 0) return json_null();
  return json_pack("{s:o, s:i, s:s, s:I, s:o}", "steps_per_second", json_number(f->speed),
                   "threads", f->threads, "path", f->path, "tried", (json_int_t)f->tried,
                   "run_seconds", json_number(run_seconds(f)));
}

static json_t *sweep_json(const check_sweep *s) {
  if (s->points == 0) return json_null();
  return json_pack("{s:I, s:I, s:o, s:I, s:o}", "points", (json_int_t)s->points, "sets",
                   (json_int_t)s->sets, "steps", json_number(s->steps), "in_lanes",
                   (json_int_t)s->together, "seconds", json_number(s->seconds));
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

/* check_page.c: what `check` has found, as comments of a deck. */
#include <inttypes.h>
#include <math.h>

#include "app/check/check.h"
#include "model/field_kinds.h"
#include "model/overlaps.h"

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
  printf("# disks       %zu: %zu free, %zu fixed or moved\n", m->n_disks, m->n_free, m->n_disks - m->n_free);
  if (m->n_clumps) {
    size_t n = 0;
    for (size_t i = 0; i < m->n_disks; i++) n += m->disks[i].clump > 0;
    printf("# clumps      %zu, of %zu disks\n", m->n_clumps, n);
  }
  if (m->n_walls) printf("# walls       %zu\n", m->n_walls);
  for (size_t k = 0; k < m->n_groups; k++) {
    size_t n = 0;
    for (size_t i = 0; i < m->n_disks; i++) n += m->disks[i].group == (int)k;
    printf("# group       \"%s\": %zu disks\n", m->groups[k], n);
  }
}

/* Deformation of the periodic box: "xx" at a rate, or to a stress. */
static void print_cell(const sd_cell *c) {
  const char *comma = ", cell";
  for (int k = 0; k < SD_CELL_COMPONENTS; k++) {
    if (!c->asked || (!c->controlled[k] && c->rate[k] == 0.0)) continue;
    printf("%s %s %s %g", comma, check_components[k], c->controlled[k] ? "to stress" : "at rate",
           c->controlled[k] ? c->stress[k] : c->rate[k]);
    comma = ",";
  }
}

/* Goals that may end the phase before its length, and its relaxation or compression. */
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
    printf("# rain        %zu disks in %zu batches of %zu, one every %g: the last at time %g\n", r->count,
           batches, r->batch, (double)r->interval * m->dt,
           (double)(batches - 1) * (double)r->interval * m->dt);
  }
}

/* With walls there are limits anyway, or no way out. */
static void print_bounds(const sd_model *m) {
  bool falls = m->n_free > 0 && (m->gravity[0] != 0 || m->gravity[1] != 0);
  if (!m->bounds.given && m->n_walls == 0 && falls && !m->periodic[0] && !m->periodic[1])
    printf("# bounds      none: a disk that falls off is not told of; with `bounds = { };` it is\n");
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
    printf("# field       %s%s%s on ", f->name ? f->name : "", f->name ? ": " : "", field_kind_name(f->kind));
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
    printf("#             at most; it ends after %lld steps, time %g, or later, with the goal of `until`\n",
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
  printf("#             stable up to %.3g (%s of %s, %s): %.3g of it\n", limit.dt, check_bounds[limit.bound],
         sd_model_body_name(m, limit.disk, name, sizeof name), m->integrator == SD_GEAR5 ? "gear5" : "verlet",
         m->dt / limit.dt);
}

static void print_positions(const check_found *f) {
  const sd_model *m = f->model;
  const first_overlap *o = &f->overlap;
  char one[96], two[96];
  if (o->depth > 0) {
    printf("# overlap     at most %.3g of the radius: %s and %s, force %.3g", o->relative,
           sd_model_body_name(m, o->a, one, sizeof one), sd_model_body_name(m, o->b, two, sizeof two),
           o->force);
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

static void print_restitution(void *user, int a, int b, double e, double mass, const char *bodies) {
  const sd_model *m = user;
  printf("# restitution \"%s\" on \"%s\": ", m->materials[a].name, m->materials[b].name);
  if (isnan(e))
    printf("depends on the speed\n");
  else if (mass > 0)
    printf("e = %.4f (%s, effective mass %.4g)\n", e, bodies, mass);
  else
    printf("e = %g at any speed\n", e);
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
    printf(", up to %s of it rows that are not saved yet", size_text(s->unsaved, bytes, sizeof bytes));
  printf("\n");
}

static void print_speed(const check_found *f) {
  if (f->probed) printf("# contacts    %zu at the start\n", f->contacts);
  if (f->tried == 0) return;
  printf("# speed       about %.3g steps per second (%d thread%s, %s), measured on the first %lld steps\n",
         f->speed, f->threads, f->threads == 1 ? "" : "s", f->path, (long long)f->tried);
  printf("# run time    about ");
  print_duration(check_run_seconds(f));
  printf(" for %s%lld steps\n", f->model->until.asked ? "at most " : "", (long long)sd_model_steps(f->model));
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
    printf("#             %zu of them can go in lanes, up to %zu side by side\n", s->together, s->width);
}

void check_print(const check_found *f) {
  print_counts(f->model);
  print_bounds(f->model);
  print_fields(f->model);
  print_phases(f->model);
  print_limits(f->model);
  print_time_step(f->model);
  print_positions(f);
  check_restitutions(f->model, print_restitution, (void *)f->model);
  if (f->size.bytes > 0) print_size(f);
  print_speed(f);
  print_sweep(f);
}

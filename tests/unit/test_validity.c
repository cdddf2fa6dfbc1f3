/* test_validity.c: the validity check (physics/neighbours/validity.h) finds what is wrong: one promise is broken at a time, in
 * a child, which the check must end. What is right passes. */
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "deck_runs.h"
#include "physics/contact/pairs.h"
#include "physics/neighbours/chunks.h"
#include "physics/neighbours/neighbours.h"
#include "physics/neighbours/validity.h"
#include "physics/step/step.h"

/* Disks fall on a segment and stay in contact with each other and with it; more: of their law. */
static sd_simulation *packing_with(const char *more, int threads) {
  text t = {0};
  text_add(&t,
           "dt = 1e-3; gravity = { g = 1; }; integrator = \"verlet\"; steps = 100000;\n"
           "materials = ( { name = \"m\"; k_n = 1e3; k_t = 8e2; gamma_n = 1; mu = 0.3; %s } );\n"
           "walls = ( { type = \"segment\"; points = ((-1, 0), (30, 0)); } );\n"
           "disk_rows = ( { columns = (\"x\", \"y\", \"radius\"); mass = 1; rows = (",
           more);
  add_lattice(&t, 600, 20, 0.6, 0.5, 1.0, 0.52, 3);
  text_add(&t, "); } );\n");
  sd_model *m = model_of_text(&t);
  sd_simulation *sim = begin_run(m, threads);
  advance(sim, 50);
  return sim;
}
static sd_simulation *packing(int threads) { return packing_with("", threads); }

static void end(sd_simulation *sim) {
  sd_model *m = (sd_model *)(uintptr_t)sd_simulation_model(sim);
  end_run(sim, m);
}

/* A closed contact of disks that sticks, an open pair of disks, a contact with the wall. */
static size_t stuck(const pairs *p) {
  for (size_t k = 0; k < p->n_round; k++)
    if (pairs_closed(p, k) && pairs_slide_sign(p, k) == 0) return k;
  fail_msg("no contact sticks");
  return 0;
}
static size_t open_one(const pairs *p) {
  for (size_t k = 0; k < p->n_round; k++)
    if (!pairs_closed(p, k)) return k;
  fail_msg("no pair is open");
  return 0;
}
static size_t on_wall(const pairs *p) {
  for (size_t k = p->first_segment; k < p->count; k++)
    if (pairs_closed(p, k)) return k;
  fail_msg("no contact with the wall");
  return 0;
}

/* pairs */
static void swapped_bodies(engine *e) {
  pairs *p = &e->work.pairs;
  const int32_t a = p->a[3];
  p->a[3] = p->b[3];
  p->b[3] = a;
}
static void other_order(engine *e) {
  pairs *p = &e->work.pairs;
  const int32_t b = p->b[0];
  assert_int_equal(p->a[0], p->a[1]);
  p->b[0] = p->b[1];
  p->b[1] = b;
}
static void slot_beyond(engine *e) { e->work.pairs.b[5] = (int32_t)e->state->n_bodies; }
static void padding_in_between(engine *e) {
  e->work.pairs.a[8] = e->work.pairs.b[8] = PAIR_PADDING;
}
static void segment_beyond(engine *e) { e->work.pairs.part[e->work.pairs.first_segment]++; }
static void other_law(engine *e) { PAIR(&e->work.pairs, 2, law)++; }
static void missing_pair(engine *e) { /* as if two near disks had not been found */
  pairs *p = &e->work.pairs;
  p->b[4] = (int32_t)e->state->n_free - 1;
}
/* chunks */
static void chunk_in_between(engine *e) { e->work.chunks.begin[1]++; }
static void chunk_too_long(engine *e) { e->work.chunks.size -= CHUNK_STEP; }
static void chunk_without_pairs(engine *e) { e->work.chunks.pair[1] += PAIR_BLOCK; }
static void share_too_long(engine *e) { e->work.chunks.share[1]++; }
static void not_late(engine *e) {
  for (size_t k = 0; k < e->work.chunks.count; k++) e->work.chunks.boundary_last[k] = false;
}
static void not_needed(engine *e) { e->work.chunks.need[0] = (uint32_t)e->work.chunks.count - 1; }
/* rows */
static void other_row(engine *e) { e->work.row[7]++; }
static void row_of_padding(engine *e) { e->work.row[e->state->n_bodies]--; }
static void other_sum(engine *e) { PAIR(&e->work.pairs, 1, sum_a) += SUM_ROW; }
static void not_listed(engine *e) { e->work.sums.n_listed--; }
static void other_entry(engine *e) { e->work.incidence.entry[9] += 2; }
static void other_slot(engine *e) { e->state->id[2] = e->state->id[3]; }

/* contacts */
static void closed_flag(engine *e) {
  pairs_set_flags(&e->work.pairs, open_one(&e->work.pairs), true, 0);
}
static void opened_flag(engine *e) {
  pairs_set_flags(&e->work.pairs, stuck(&e->work.pairs), false, 0);
}
static void slide_flag(engine *e) {
  pairs_set_flags(&e->work.pairs, stuck(&e->work.pairs), true, 1);
}
static void longer_direction(engine *e) { PAIR(&e->work.pairs, stuck(&e->work.pairs), ex) += 0.5; }
static void beyond_cap(engine *e) {
  const size_t k = stuck(&e->work.pairs);
  PAIR(&e->work.pairs, k, zeta) = PAIR(&e->work.pairs, k, force);
}
static void tau_beyond(engine *e) { MORE(&e->work.pairs, stuck(&e->work.pairs), tau) = 1e3; }
static void pulling_force(engine *e) { PAIR(&e->work.pairs, stuck(&e->work.pairs), force) = -1.0; }
static void deep_overlap(engine *e) { PAIR(&e->work.pairs, stuck(&e->work.pairs), overlap) = 0.5; }
static void no_side(engine *e) { e->work.pairs.side[on_wall(&e->work.pairs)] = 0.0; }
static void nonsense(engine *e) { PAIR(&e->work.pairs, stuck(&e->work.pairs), friction) = NAN; }
/* state */
static void angle_beyond(engine *e) { e->state->theta[11] = 4.5; }
static void no_turn(engine *e) { e->state->turn[11] = 3.0; }
static void no_loss(engine *e) { e->state->past_friction[11] = HUGE_VAL; }
static void activity_beyond(engine *e) { e->state->activity[11] = 7; }
static void step_before(engine *e) { e->state->phase_step = -1; }
static void other_force(engine *e) { e->state->force_y[e->state->n_bodies - 1] += 1.0; }
static void energy_below(engine *e) { e->state->mass[11] = -1e9; }

typedef struct fault {
  const char *name;
  void (*cause)(engine *);
  int threads;
} fault;

static const fault in_lists[] = {
    {"swapped_bodies", swapped_bodies, 1}, {"other_order", other_order, 1},
    {"slot_beyond", slot_beyond, 1},       {"padding_in_between", padding_in_between, 1},
    {"segment_beyond", segment_beyond, 1}, {"other_law", other_law, 1},
    {"missing_pair", missing_pair, 1},     {"chunk_in_between", chunk_in_between, 1},
    {"chunk_too_long", chunk_too_long, 1}, {"chunk_without_pairs", chunk_without_pairs, 1},
    {"share_too_long", share_too_long, 2}, {"not_late", not_late, 2},
    {"not_needed", not_needed, 2},         {"other_row", other_row, 1},
    {"row_of_padding", row_of_padding, 1}, {"other_sum", other_sum, 1},
    {"not_listed", not_listed, 1},         {"other_entry", other_entry, 1},
    {"other_slot", other_slot, 1},         {"closed_flag", closed_flag, 1},
    {"opened_flag", opened_flag, 1},
};
static const fault in_step[] = {
    {"closed_flag", closed_flag, 1},
    {"opened_flag", opened_flag, 1},
    {"slide_flag", slide_flag, 1},
    {"longer_direction", longer_direction, 1},
    {"beyond_cap", beyond_cap, 1},
    {"pulling_force", pulling_force, 1},
    {"deep_overlap", deep_overlap, 1},
    {"no_side", no_side, 1},
    {"nonsense", nonsense, 1},
    {"angle_beyond", angle_beyond, 1},
    {"no_turn", no_turn, 1},
    {"no_loss", no_loss, 1},
    {"activity_beyond", activity_beyond, 1},
    {"step_before", step_before, 1},
    {"other_force", other_force, 1},
    {"energy_below", energy_below, 1},
};

/* Does it abort? What it says on the way is expected, and no core is left. */
static bool aborts(const fault *f, engine *e, void (*look)(const engine *)) {
  fflush(NULL);
  pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) {
    const struct rlimit none = {0, 0};
    setrlimit(RLIMIT_CORE, &none);
    signal(SIGABRT, SIG_DFL);
    if (!freopen("/dev/null", "w", stderr)) _exit(1);
    if (f) f->cause(e);
    look(e);
    _exit(0);
  }
  int status = 0;
  assert_int_equal(waitpid(child, &status, 0), child);
  return WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT;
}

static void all_are_found(const fault *list, size_t n, void (*look)(const engine *)) {
  sd_simulation *sim[] = {packing(1), packing(2)};
  size_t missed = 0;
  for (int k = 0; k < 2; k++) assert_false(aborts(NULL, engine_of(sim[k]), look));
  for (const fault *f = list; f < list + n; f++) {
    engine *e = engine_of(sim[f->threads - 1]);
    if (e->work.n_threads < f->threads || aborts(f, e, look)) continue;
    print_error("%s is not found\n", f->name);
    missed++;
  }
  assert_int_equal(missed, 0);
  for (int k = 0; k < 2; k++) end(sim[k]);
}

static void faults_of_lists(void **unused) {
  all_are_found(in_lists, sizeof in_lists / sizeof *in_lists, validity_check_lists);
}

static void faults_of_steps(void **unused) {
  all_are_found(in_step, sizeof in_step / sizeof *in_step, validity_check_step);
}

/* Attraction and rolling friction have limits of their own; a run may have no free disk. */
static void other_runs_pass(void **unused) {
  sd_simulation *sim =
      packing_with("cohesion = \"constant\"; pull_off = 0.1; mu_r = 0.1; k_r = 10;", 1);
  assert_false(aborts(NULL, engine_of(sim), validity_check_lists));
  assert_false(aborts(NULL, engine_of(sim), validity_check_step));
  assert_true(aborts(&(fault){"tau_beyond", tau_beyond, 1}, engine_of(sim), validity_check_step));
  end(sim);
  sd_model *m = model_of("dt = 1e-3; integrator = \"verlet\"; steps = 10;\n"
                         "materials = ( { name = \"m\"; k_n = 1e3; k_t = 8e2; } );\n"
                         "disks = ( { x = 0; y = 0; radius = 1; mass = 1; fixed = true; } );");
  sim = begin_run(m, 1);
  advance(sim, 5);
  validity_check_lists(engine_of(sim));
  validity_check_step(engine_of(sim));
  end(sim);
}

/* Steps and new lists look by themselves. */
static void take_a_step(const engine *e) {
  const team alone = {.size = 1};
  step_begin((engine *)(uintptr_t)e, 1);
  step_once((engine *)(uintptr_t)e, &alone);
}
static void build_lists(const engine *e) { neighbours_build((engine *)(uintptr_t)e, NULL); }

static void dev_builds_look(void **unused) {
  if (!VALIDITY_CHECKED) {
    print_message("this build does not look by itself (SLIPDISK_CHECK)\n");
    skip();
  }
  const fault turned = {"longer_direction", longer_direction, 1}, loss = {"no_loss", no_loss, 1};
  sd_simulation *sim = packing(1);
  assert_false(aborts(NULL, engine_of(sim), take_a_step));
  assert_false(aborts(NULL, engine_of(sim), build_lists));
  assert_true(aborts(&loss, engine_of(sim), take_a_step));
  assert_true(aborts(&turned, engine_of(sim), build_lists));
  end(sim);
}

RUN_TESTS(TEST(faults_of_lists), TEST(faults_of_steps), TEST(other_runs_pass),
          TEST(dev_builds_look))

/* test_neighbours.c: candidate pairs against brute force, and the contacts' memory over rebuilds. */
#include "deck_runs.h"
#include "model/model.h"
#include "physics/contact/pairs.h"
#include "physics/neighbours/neighbours.h"
#include "physics/contact/walls.h"

/* A zigzag and a star of many segments across the box and beyond it, and pegs. */
static void add_long_walls(text *t, double w, double h) {
  enum { TEETH = 90, PEGS = 12 };
  text_add(t, ", { type = \"polyline\"; points = (");
  for (int k = 0; k < TEETH; k++)
    text_add(t, "%s(%.6g, %.6g)", k ? ", " : "", -0.5 + 1.3 * w * k / TEETH,
             2 + h * (0.3 + 0.02 * (k % 3)));
  text_add(t, "); }, { type = \"polyline\"; closed = true; points = (");
  for (int k = 0; k < TEETH; k++)
    text_add(t, "%s(%.6g, %.6g)", k ? ", " : "",
             (0.3 + 0.4 * (k % 2)) * w * cos(0.0698 * k) + 0.4 * w - 0.3,
             2 + h * (0.5 + (0.3 + 0.4 * (k % 2)) * sin(0.0698 * k)));
  text_add(t, "); }");
  for (int k = 0; k < PEGS; k++)
    text_add(t,
             ", { type = \"circle\"; center = (%.6g, %.6g); radius = %.6g; side = \"outside\"; }",
             w * k / PEGS - 0.3, 2 + 0.7 * h, 0.002 * (k + 1));
}

/* n disks at random in a w by h box, overlapping or not; some fixed, some on the edges of cells and of the box. A
 * deck would refuse them, so they are put there afterwards. */
static sd_model *scattered(int n, double w, double h, double spread, int periodic, bool walls,
                           uint64_t seed) {
  text t = {0};
  text_add(
      &t,
      "dt = 1e-4; skin = 0.01; materials = ( { name = \"m\"; k_n = 1; k_t = 1; gamma_n = 0.1; mu = "
      "0.5; } ); steps = 1000;\n"
      "disk_rows = ( { columns = (\"x\", \"y\", \"radius\", \"fixed\"); mass = 1; rows = (");
  for (int k = 0; k < n; k++)
    text_add(&t, "%s(%d, 9999, %.6g, %s)", k ? ", " : "", 4 * k,
             0.016 * pow(spread, next_uniform(&seed)), k % 5 == 4 ? "true" : "false");
  text_add(&t, "); } );\n");
  if (walls)
    text_add(
        &t,
        "walls = ( { type = \"line\"; points = ((0, 2.1), (1, 2.3)); }, { type = \"segment\"; "
        "points = ((0, 2.5), (0.3, 2.4)); },\n"
        "{ type = \"polyline\"; closed = true; points = ((0.1, 2.1), (0.5, 2.2), (0.4, 2.6), (0.2, "
        "2.3)); },\n"
        "{ type = \"circle\"; center = (0.2, 2.4); radius = 0.2; side = \"outside\"; },\n"
        "{ type = \"circle\"; center = (0.2, 2.4); radius = 0.45; side = \"outside\"; }");
  if (walls && spread > 10.0) add_long_walls(&t, w, h);
  if (walls) text_add(&t, " );\n");
  sd_model *m = model_of_text(&t);
  m->max_overlap = 1e9;
  m->periodic[0] = periodic & 1;
  m->periodic[1] = periodic >> 1;
  m->lower[0] = -0.3, m->upper[0] = w - 0.3;
  m->lower[1] = 2, m->upper[1] = 2 + h;
  for (int k = 0; k < n; k++) {
    double x = next_uniform(&seed), y = next_uniform(&seed);
    if (k % 7 == 3) x = floor(8 * x) / 8, y = floor(8 * y) / 8;
    m->disks[k].position[0] = w * x - 0.3;
    m->disks[k].position[1] = 2 + h * y;
  }
  return m;
}

static double shortest(double d, double length) {
  return length > 0.0 ? d - length * nearbyint(d / length) : d;
}

/* Distance from a point to a wall's piece as it stands at the start. */
static double to_piece(const sd_model *m, const sd_segment *g, double x, double y) {
  const sd_wall *wall = &m->walls[g->body - m->n_disks];
  double rx = x - wall->pivot[0] - g->start[0], ry = y - wall->pivot[1] - g->start[1];
  double u = rx * g->tangent[0] + ry * g->tangent[1];
  if (isfinite(g->length)) u = fmin(fmax(u, 0), g->length);
  return hypot(rx - u * g->tangent[0], ry - u * g->tangent[1]);
}

static bool listed(const engine *e, uint32_t a, uint32_t b, size_t part, bool round) {
  const pairs *p = &e->work.pairs;
  size_t from = round ? 0 : p->n_round, to = round ? p->n_round : p->count, found = 0;
  for (size_t k = from; k < to; k++)
    if (p->a[k] == (int32_t)a && p->b[k] == (int32_t)b && p->part[k] == (int32_t)part) found++;
  assert_true(found <= 1);
  return found == 1;
}

/* Every pair nearer than the skin is there once, no other is, and all are in order. */
static size_t check_lists(sd_simulation *sim) {
  engine *e = engine_of(sim);
  const sd_state *s = e->state;
  const sd_model *m = e->model;
  const work *w = &e->work;
  size_t expected = 0;
  for (uint32_t i = 0; i < s->n_free; i++) {
    for (uint32_t j = i + 1; j < s->n_disks; j++) {
      double d = hypot(shortest(s->x[j] - s->x[i], w->length[0]),
                       shortest(s->y[j] - s->y[i], w->length[1]));
      bool near = d < s->radius[i] + s->radius[j] + w->skin;
      assert_int_equal(listed(e, i, j, 0, true), near);
      expected += near;
    }
    for (uint32_t b = (uint32_t)s->n_disks; b < s->n_bodies; b++) {
      if (s->radius[b] == 0.0) continue;
      double d = hypot(shortest(s->x[b] - s->x[i], w->length[0]),
                       shortest(s->y[b] - s->y[i], w->length[1]));
      bool near = s->radius[b] > 0 ? d < s->radius[i] + s->radius[b] + w->skin
                                   : d + s->radius[i] + w->skin > -s->radius[b];
      assert_int_equal(listed(e, i, b, 0, true), near);
      expected += near;
    }
    for (size_t g = 0; g < m->n_segments; g++) {
      bool near = to_piece(m, &m->segments[g], s->x[i], s->y[i]) < s->radius[i] + w->skin;
      assert_int_equal(listed(e, i, slot_of(&w->slots, m->segments[g].body), g, false), near);
      expected += near;
    }
  }
  const pairs *p = &w->pairs;
  assert_int_equal(p->n_round + p->count - p->first_segment, expected);
  for (size_t k = p->n_round; k < p->first_segment; k++)
    assert_true(p->a[k] == -1 && p->b[k] == -1);
  /* each pair stands once with each of its bodies */
  size_t *seen = calloc(2 * p->count + 1, sizeof *seen);
  for (uint32_t b = 0; b < s->n_bodies; b++)
    for (size_t k = w->incidence.start[b]; k < w->incidence.start[b + 1]; k++) {
      uint32_t entry = w->incidence.entry[k];
      assert_true((entry & 1 ? w->pairs.b : w->pairs.a)[entry / 2] == (int32_t)b);
      seen[entry]++;
    }
  for (size_t k = 0; k < 2 * p->count; k++) assert_int_equal(seen[k], p->a[k / 2] >= 0);
  free(seen);
  return expected;
}

static void lists_equal_brute_force(void **unused) {
  const double shapes[][2] = {{0.9, 0.9}, {3, 0.3}, {0.3, 3}, {0.25, 0.25}, {9, 7}, {0.33, 0.5}};
  const int sizes[] = {1, 2, 40, 150};
  size_t total = 0;
  for (int c = 0; c < 4 * 6 * 4 * 2; c++) {
    const double *shape = shapes[c / 4 % 6];
    sd_model *model = scattered(sizes[c / 24 % 4], shape[0], shape[1], 1 + c % 3, c % 4, c >= 96,
                                100 + (uint64_t)c);
    sd_simulation *sim = begin_run(model, 1);
    total += check_lists(sim);
    end_run(sim, model);
  }
  print_message("  %zu pairs\n", total);
  assert_true(total > 10000);
}

/* Radii over two decades, and one disk 100 times as large as the others, free or prescribed: levels of few cells, disks
 * that are larger than rows of the others' cells, walls of many segments. */
static void lists_of_all_sizes_equal_brute_force(void **unused) {
  const double shapes[][2] = {{4, 4}, {9, 7}, {7.9, 30}, {30, 8}, {0.5, 0.6}};
  size_t total = 0;
  for (int c = 0; c < 5 * 4 * 2 * 3; c++) {
    const double *shape = shapes[c % 5];
    const int kind = c / 40; /* 0: two decades; 1: a large free disk; 2: a large prescribed one */
    sd_model *model =
        scattered(150, shape[0], shape[1], 100, c / 5 % 4, c / 20 % 2, 7000 + (uint64_t)c);
    for (size_t k = 0; kind > 0 && k < model->n_disks; k++) {
      const bool large = k == (kind == 1 ? 3 : 4);
      model->disks[k].radius = large ? 1.6 : 0.016 + 0.0001 * (double)(k % 50);
    }
    sd_simulation *sim = begin_run(model, 1);
    total += check_lists(sim);
    end_run(sim, model);
  }
  print_message("  %zu pairs\n", total);
  assert_true(total > 10000);
}

/* The record of every closed pair, its side and sliding, by its bodies. */
enum { REMEMBERED = SD_CONTACT_ALL + 2 };
static size_t remember(const engine *e, double (*memory)[REMEMBERED], uint32_t (*key)[3]) {
  const pairs *p = &e->work.pairs;
  size_t n = 0;
  for (size_t k = 0; k < p->count; k++) {
    if (!pairs_closed(p, k)) continue;
    double row[REMEMBERED] = {p->side[k], pairs_slide_sign(p, k)};
    const sd_contact_record record = pairs_record(p, k);
    memcpy(row + 2, &record, sizeof record);
    memcpy(memory[n], row, sizeof row);
    key[n][0] = e->state->id[p->a[k]];
    key[n][1] = e->state->id[p->b[k]];
    key[n++][2] = (uint32_t)p->part[k];
  }
  return n;
}

static void rebuilds_carry_the_memory(void **unused) {
  enum { MOST = 20000 };
  static double before[MOST][REMEMBERED], after[MOST][REMEMBERED];
  static uint32_t key_before[MOST][3], key_after[MOST][3];
  for (int c = 0; c < 8; c++) {
    sd_model *model = scattered(120, 0.6, 0.7, 2, c % 4, true, 900 + (uint64_t)c);
    sd_simulation *sim = begin_run(model, 1);
    for (int k = 0; k < 30; k++) {
      advance(sim, 7);
      size_t n = remember(engine_of(sim), before, key_before);
      assert_true(n > 20 && n < MOST);
      int64_t builds = engine_of(sim)->work.builds;
      if (k % 3 == 2)
        assert_int_equal(sd_simulation_rebuild(sim, NULL), SD_OK);
      else
        assert_int_equal(neighbours_build(engine_of(sim), NULL), SD_OK);
      assert_true(k % 3 == 2 || engine_of(sim)->work.builds == builds + 1);
      assert_int_equal(remember(engine_of(sim), after, key_after), n);
      assert_memory_equal(before, after, n * sizeof *before);
      assert_memory_equal(key_before, key_after, n * sizeof *key_before);
      if (k % 10 == 0) check_lists(sim);
    }
    end_run(sim, model);
  }
}

/* Between builds: nothing that is not listed ever comes nearer than touching. */
static void no_contact_is_missed_between_builds(void **unused) {
  for (int c = 0; c < 4; c++) {
    sd_model *model = scattered(60, 0.7, 0.8, 2, c, false, 40 + (uint64_t)c);
    for (uint32_t i = 0; i < 60; i++) {
      if (model->disks[i].driven) continue;
      model->disks[i].velocity[0] = 2.0 * cos(i);
      model->disks[i].velocity[1] = 2.0 * sin(i * i);
    }
    sd_simulation *sim = begin_run(model, 1);
    const engine *e = engine_of(sim);
    for (int k = 0; k < 400; k++) {
      advance(sim, 1);
      const sd_state *s = e->state;
      for (uint32_t i = 0; i < s->n_free; i++)
        for (uint32_t j = i + 1; j < s->n_disks; j++) {
          double d = hypot(shortest(s->x[j] - s->x[i], e->work.length[0]),
                           shortest(s->y[j] - s->y[i], e->work.length[1]));
          if (d < s->radius[i] + s->radius[j]) assert_true(listed(e, i, j, 0, true));
        }
    }
    assert_true(e->work.builds > 10);
    end_run(sim, model);
  }
}

/* A contact whose bodies jump apart, farther than the skin within one step, drops the same energy as if it had
 * still been a candidate. Prescribed disk, round wall and straight wall each leave a disk that is pressed on
 * them; two of them leave the same disk. */
static uint64_t jump(double skin, bool gear, int64_t *builds, double *dropped) {
  text t = {0};
  text_add(
      &t,
      "integrator = \"%s\"; dt = 1e-3; skin = %g;\n"
      "materials = ( { name = \"m\"; k_n = 1000; k_t = 700; gamma_n = 0.5; mu = 0.5; } );\n"
      "disks = ( { x = 0; y = 0; radius = 1; mass = 1; vx = 0.3; vy = 0.1; omega = 0.4; },\n"
      "{ name = \"a\"; x = 1.98; y = 0; radius = 1; mass = 1; fixed = true; },\n"
      "{ name = \"b\"; x = 0; y = 1.98; radius = 1; mass = 1; fixed = true; },\n"
      "{ x = 0; y = 10; radius = 1; mass = 1; vx = -0.2; }, { x = 10; y = 0; radius = 1; mass = 1; "
      "} );\n"
      "walls = ( { name = \"c\"; type = \"circle\"; side = \"outside\"; center = (0, 7.02); radius "
      "= 2; },\n"
      "{ name = \"d\"; type = \"segment\"; points = ((9, -0.99), (11, -0.98)); } );\n"
      "motions = ( { disk = (\"a\", \"b\"); coordinate = \"y\"; type = \"velocity\"; velocity = "
      "-30000; },\n"
      "{ wall = (\"c\", \"d\"); coordinate = \"y\"; type = \"velocity\"; velocity = -30000; } );\n"
      "phases = ( { steps = 5; motions = []; }, { steps = 5; } );\n",
      gear ? "gear5" : "verlet", skin);
  sd_model *model = model_of_text(&t);
  sd_simulation *sim = begin_run(model, 1);
  advance(sim, 5);
  assert_int_equal(sd_simulation_state(sim)->n_contacts, 4);
  advance(sim, 5);
  uint64_t hash = sd_state_hash(sd_simulation_state(sim));
  assert_int_equal(sd_simulation_state(sim)->n_contacts, 0);
  *builds = engine_of(sim)->work.builds;
  *dropped = sd_simulation_energy(sim).opening;
  end_run(sim, model);
  return hash;
}

static void what_a_jump_drops_does_not_depend_on_the_skin(void **unused) {
  for (int gear = 0; gear < 2; gear++) {
    int64_t often, once;
    double dropped, same;
    uint64_t small = jump(0.05, gear, &often, &dropped), large = jump(1e4, gear, &once, &same);
    assert_true(once == 1 && often > 1);
    assert_true(dropped != 0.0 && dropped == same);
    assert_true(small == large);
  }
}

RUN_TESTS(TEST(lists_equal_brute_force), TEST(lists_of_all_sizes_equal_brute_force),
          TEST(rebuilds_carry_the_memory), TEST(no_contact_is_missed_between_builds),
          TEST(what_a_jump_drops_does_not_depend_on_the_skin))

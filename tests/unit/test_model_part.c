/* test_model_part.c: what ranks that share a run keep of a model: all what all must know, each some
 * of the other disks. */
#include "unit.h"
#include "base/comm.h"
#include "io/deck/deck.h"
#include "model/model.h"
#include "model/rows.h"
#include "slipdisk/deck.h"

static const char *const deck =
    "dt = 1e-3; steps = 10; container = { type = \"box\"; width = 20; height = 20; };"
    "materials = ( { name = \"m\"; k_n = 100; k_t = 80; mu = 0.5; } );"
    "disks = ( { name = \"named\"; x = 0; y = 1; radius = 1; mass = 1; },"
    "{ x = 3; y = 1; radius = 0.8; mass = 1; force = (0, 0.3); },"
    "{ x = -3; y = 1; radius = 0.7; mass = 1; locked = (\"x\"); },"
    "{ x = 6; y = 1; radius = 2; mass = 1; fixed = true; } );"
    "packings = ( { type = \"square\"; y = (5, 20); radius = 0.5; mass = 1; count = 60; } );";
enum { SPECIAL = 4, DISKS = 64, RANKS = 3 };

static sd_model *whole(void) {
  sd_model *m;
  assert_int_equal(sd_deck_load_text(deck, "deck", 0, NULL, &m, NULL), SD_OK);
  assert_int_equal(m->n_disks, DISKS);
  return m;
}

/* Parts of all ranks, side by side. */
typedef struct parts {
  size_t few;
  sd_model *of[RANKS];
} parts;

static void part_of(const comm *c, void *with) {
  parts *p = with;
  sd_model **m = &p->of[comm_rank(c)];
  assert_int_equal(deck_load_for_ranks(c, deck, "deck", 0, NULL, NULL, m, NULL), SD_OK);
  assert_int_equal(model_part(*m, p->few), SD_OK);
  (*m)->comm = NULL;
}

static parts make_parts(size_t few) {
  parts p = {.few = few};
  comm_threads_run(RANKS, part_of, &p);
  return p;
}

static void end_parts(parts *p) {
  for (int q = 0; q < RANKS; q++) sd_model_free(p->of[q]);
}

static void all_know_special_disks(void **unused) {
  static const sd_disk none;
  sd_model *m = whole();
  parts p = make_parts(0);
  for (int q = 0; q < RANKS; q++) {
    const sd_model *rank = p.of[q];
    assert_true(rank->finished && rank->n_disks == m->n_disks && rank->n_free == m->n_free);
    assert_int_equal(model_known(rank), SPECIAL);
    for (uint32_t k = 0; k < SPECIAL; k++) {
      sd_disk there = m->disks[k], here = rank->disks[k];
      there.name = here.name = NULL;
      assert_memory_equal(&there, &here, sizeof here);
      assert_int_equal(model_known_disk(rank, k), k);
      assert_true(model_knows(rank, k) && model_knows(m, k));
    }
    assert_string_equal(rank->disks[0].name, "named");
    assert_int_equal(sd_model_find(rank, "named"), 0);
    for (uint32_t k = SPECIAL; k < DISKS; k++) {
      assert_memory_equal(&rank->disks[k], &none, sizeof none);
      assert_true(!model_knows(rank, k) && model_knows(m, k));
    }
  }
  end_parts(&p);
  sd_model_free(m);
}

static void each_free_disk_has_one_rank(void **unused) {
  sd_model *m = whole();
  for (size_t few = 0; few <= 1000; few += 1000) {
    parts p = make_parts(few);
    size_t seen[DISKS] = {0};
    for (int q = 0; q < RANKS; q++) {
      const sd_rows *mine = p.of[q]->mine;
      assert_true(few == 0 ? mine->n == (DISKS - 1) / RANKS : mine->n == (q == 0 ? DISKS - 1 : 0));
      for (size_t k = 0; k < mine->n; k++) {
        const uint32_t disk = mine->number[k];
        sd_disk there = m->disks[disk], here = mine->disk[k];
        there.name = here.name = NULL;
        assert_memory_equal(&there, &here, sizeof here);
        seen[disk]++;
      }
    }
    for (size_t k = 0; k < DISKS; k++) assert_int_equal(seen[k], !m->disks[k].driven);
    end_parts(&p);
  }
  sd_model_free(m);
}

static void numbers_of_all_disks_are_known(void **unused) {
  sd_model *m = whole();
  parts p = make_parts(0);
  double inverse = 0;
  for (size_t k = 0; k < DISKS; k++) inverse += 1 / m->disks[k].radius;
  assert_true(m->mean_radius == DISKS / inverse && m->largest_radius == 1);
  for (int q = 0; q < RANKS; q++) {
    const sd_model *rank = p.of[q];
    const sd_step_limit here = sd_model_step_limit(rank), there = sd_model_step_limit(m);
    assert_true(rank->mean_radius == m->mean_radius && rank->largest_radius == m->largest_radius);
    assert_true(here.dt == there.dt && here.disk == there.disk && here.bound == there.bound);
    assert_int_equal(rank->n_segments, m->n_segments);
    assert_memory_equal(rank->segments, m->segments, m->n_segments * sizeof *m->segments);
  }
  end_parts(&p);
  sd_model_free(m);
}

static void a_damaged_image_is_refused(void **unused) {
  sd_model *m = whole(), *copy;
  size_t size;
  unsigned char *bytes = model_serialize(m, &size);
  assert_non_null(bytes);
  for (size_t less = 1; less < size; less += 97)
    assert_int_not_equal(image_read(bytes, size - less, &copy, NULL), SD_OK);
  free(bytes);
  sd_model_free(m);
}

RUN_TESTS(TEST(all_know_special_disks), TEST(each_free_disk_has_one_rank),
          TEST(numbers_of_all_disks_are_known), TEST(a_damaged_image_is_refused))

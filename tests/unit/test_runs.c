/* test_runs.c: ascending runs read as one, against sorting; also runs that are empty, equal keys, one run, none. */
#include "unit.h"
#include "base/buckets.h"

enum { RUNS = 37, MOST = 60 };

typedef struct item {
  int64_t key;
  size_t run, at;
} item;

static uint64_t stream = 1;
static uint64_t draw(uint64_t n) {
  stream ^= stream << 13;
  stream ^= stream >> 7;
  stream ^= stream << 17;
  return stream % n;
}

static int by_key(const void *one, const void *two) {
  const item *p = one, *q = two;
  if (p->key != q->key) return p->key < q->key ? -1 : 1;
  if (p->run != q->run) return p->run < q->run ? -1 : 1;
  return p->at < q->at ? -1 : p->at > q->at;
}

/* Steps of keys below `step`: 1 makes all of a run equal. */
static void try(size_t n_runs, uint64_t step) {
  static int64_t key[RUNS][MOST];
  static item all[RUNS * MOST];
  size_t length[RUNS], at[RUNS] = {0}, n = 0;
  runs heads;
  runs_new(&heads, n_runs);
  for (size_t k = 0; k < n_runs; k++) {
    length[k] = draw(MOST + 1);
    int64_t last = (int64_t)draw(5) - 2;
    for (size_t i = 0; i < length[k]; i++) {
      key[k][i] = last += (int64_t)draw(step);
      all[n++] = (item){last, k, i};
    }
    if (length[k] > 0) runs_add(&heads, k, key[k][0]);
  }
  qsort(all, n, sizeof *all, by_key);
  for (size_t i = 0; i < n; i++) {
    assert_true(heads.n > 0);
    const size_t k = runs_least(&heads);
    assert_int_equal(k, all[i].run);
    assert_int_equal(at[k], all[i].at);
    if (++at[k] < length[k])
      runs_step(&heads, key[k][at[k]]);
    else
      runs_end(&heads);
  }
  assert_int_equal(heads.n, 0);
  runs_free(&heads);
}

static void as_sorted(void **unused) {
  for (int round = 0; round < 300; round++)
    try(draw(RUNS + 1), (uint64_t[]){1, 2, 3, 1000}[round % 4]);
}

RUN_TESTS(TEST(as_sorted))

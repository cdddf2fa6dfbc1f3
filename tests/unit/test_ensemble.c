/* test_ensemble.c: simulations that go side by side in lanes give the bits of each by itself, whatever their numbers,
 * how many there are, in which pieces they are advanced, and whoever fails, finishes or falls behind.
 */
#include "unit.h"
#include "run/ensemble.h"
#include "model/state.h"
#include "slipdisk/deck.h"

enum { MOST = 19 };

/* What differs from member to member: the k-th takes the k-th value of each key, beginning again. */
typedef struct variety {
  const char *deck;         /* its file, or its text */
  const char *common[8];    /* up to the first NULL */
  const char *key[4];       /* likewise */
  const char *value[4][12]; /* likewise */
} variety;

static sd_model *model_of(const variety *v, size_t k) {
  char path[512], text[4][256];
  const char *overrides[16];
  size_t n = 0;
  snprintf(path, sizeof path, "%s/inputs/%s", SLIPDISK_SOURCE_DIR, v->deck);
  while (v->common[n]) overrides[n] = v->common[n], n++;
  for (size_t i = 0; i < 4 && v->key[i]; i++) {
    size_t values = 0;
    while (values < 12 && v->value[i][values]) values++;
    snprintf(text[i], sizeof text[i], "%s=%s", v->key[i], v->value[i][k % values]);
    overrides[n++] = text[i];
  }
  sd_messages *m = sd_messages_new();
  sd_model *model = NULL;
  const sd_status status = strchr(v->deck, '=')
                               ? sd_deck_load_text(v->deck, "deck", n, overrides, &model, m)
                               : sd_deck_load(path, n, overrides, &model, m);
  if (status != SD_OK) sd_messages_print(m, stderr);
  sd_messages_free(m);
  assert_non_null(model);
  return model;
}

typedef struct crowd {
  size_t n;
  sd_model *model[MOST];
  sd_simulation *simulation[MOST];
  sd_messages *messages[MOST];
  sd_status status[MOST];
} crowd;

static crowd gather(const variety *v, size_t n) {
  crowd c = {.n = n};
  for (size_t k = 0; k < n; k++) {
    c.model[k] = model_of(v, k);
    c.messages[k] = sd_messages_new();
    assert_int_equal(sd_simulation_new(c.model[k], 1, &c.simulation[k], NULL), SD_OK);
  }
  return c;
}

static void dismiss(crowd *c) {
  for (size_t k = 0; k < c->n; k++) {
    sd_simulation_free(c->simulation[k]);
    sd_model_free(c->model[k]);
    sd_messages_free(c->messages[k]);
  }
}

/* Together in pieces against each by itself in one. Returns how many went in lanes in the first piece. */
static size_t same(const variety *v, size_t n, const int64_t *pieces) {
  crowd together = gather(v, n), alone = gather(v, n);
  size_t in_lanes = 0;
  ensemble *e;
  e = ensemble_new(n, together.simulation);
  int64_t sum = 0;
  for (size_t p = 0; pieces[p]; p++) {
    ensemble_advance(e, pieces[p], together.status, together.messages);
    if (p == 0) in_lanes = ensemble_in_lanes(e);
    sum += pieces[p];
  }
  for (size_t k = 0; k < n; k++) {
    alone.status[k] = sd_simulation_advance(alone.simulation[k], sum, alone.messages[k]);
    assert_int_equal(alone.status[k], together.status[k]);
    assert_int_equal(sd_messages_count(alone.messages[k]), sd_messages_count(together.messages[k]));
    for (size_t m = 0; m < sd_messages_count(alone.messages[k]); m++)
      assert_string_equal(sd_messages_text(alone.messages[k], m),
                          sd_messages_text(together.messages[k], m));
    const sd_field *f = sd_state_difference(sd_simulation_state(alone.simulation[k]),
                                            sd_simulation_state(together.simulation[k]));
    if (f) fail_msg("%s, member %zu of %zu: %s differs", v->deck, k, n, f->name);
  }
  ensemble_free(e);
  dismiss(&together);
  dismiss(&alone);
  return in_lanes;
}

static const int64_t one_piece[] = {3000, 0}, odd_pieces[] = {1, 2, 63, 64, 65, 700, 1, 1, 2103, 0};

#define NUMBERS                                                                                    \
  .key = {"gravity.tilt", "materials[0].mu", "materials[0].k_n", "seed"},                          \
  .value = {{"0", "0.1", "-0.2", "0.3"},                                                           \
            {"0.1", "0", "0.5"},                                                                   \
            {"1e3", "2e4"},                                                                        \
            {"1", "2", "3", "4", "5", "6", "7"}}

/* One overlaps too deeply, at once or later: it keeps its last state, and the others do not notice. */
static void one_fails(void **unused) {
  static const variety v = {
      .deck = "three_disk/random.cfg",
      .common = {"dt=2e-5", "phases[0].steps=1234", "measure.configurations=true"},
      .key = {"max_overlap", "motions[*].amplitude"},
      .value = {{"0.3", "0.3", "3e-4", "0.3", "6e-4"}, {"1e-3"}}};
  crowd c = gather(&v, 5);
  size_t wrong = 0;
  for (size_t k = 0; k < 5; k++)
    wrong += sd_simulation_advance(c.simulation[k], 3000, c.messages[k]) != SD_OK;
  assert_in_range(wrong, 1, 4);
  dismiss(&c);
  same(&v, 5, one_piece);
  same(&v, 5, odd_pieces);
}

/* Members that do not fit together, or fall behind, go on by themselves. */
static void not_alike(void **unused) {
  static const variety lengths = {.deck = "three_disk/sync.cfg",
                                  .key = {"phases[0].steps"},
                                  .value = {{"500", "500", "700", "500"}}};
  assert_int_equal(same(&lengths, 4, one_piece), ensemble_width() < 3 ? ensemble_width() : 3);
  static const variety kinds = {.deck = "three_disk/sync.cfg",
                                .common = {"phases[0].steps=500"},
                                .key = {"motions[*].type"},
                                .value = {{"\"harmonic\"", "\"parabolic\""}}};
  assert_int_equal(same(&kinds, 4, one_piece), 2);
  static const variety ends = {.deck = "three_disk/sync.cfg",
                               .common = {"phases[0].steps=500"},
                               .key = {"phases[1].steps"},
                               .value = {{"900", "2000", "1e6", "1e6", "1e6"}}};
  same(&ends, 5, odd_pieces);
}

/* Motions of one coordinate add up: one that is steady, and two waves. */
static void motions_add_up(void **unused) {
#define MOTION "{ disk = \"d\"; coordinate = \"theta\"; type = "
  static const variety v = {
      .deck = "dt = 1e-4; steps = 1500; gravity = { g = 10; };\n"
              "materials = ({ name = \"m\"; k_n = 1e4; k_t = 1e4; mu = 0.5; gamma_n = 1; });\n"
              "disks = ({ x = 0.1; y = 1.99; radius = 1; mass = 1; },\n"
              "         { name = \"d\"; x = 0; y = 0; radius = 1; mass = 1; fixed = true; });\n"
              "motions = (" MOTION "\"velocity\"; velocity = 3; },\n" MOTION
              "\"harmonic\"; amplitude = 0.1; omega = 50; },\n" MOTION
              "\"parabolic\"; amplitude = 0.1; omega = 70; });",
      .key = {"motions[0].velocity", "motions[1].omega"},
      .value = {{"3", "-2", "0.1"}, {"50", "30"}}};
  assert_int_equal(same(&v, 5, one_piece), ensemble_width() < 5 ? ensemble_width() : 5);
}

RUN_TESTS(TEST(one_fails), TEST(not_alike), TEST(motions_add_up))

/* deck_sizes.c: size distribution of the disks of a packing; see deck_values.h. */
#include "io/deck/deck_values.h"

#include <math.h>

/* A distribution of which less than this fraction lies between its limits is taken for a
 * mistake. */
static const double LEAST_KEPT = 1e-6;

static const double *read_numbers(deck_group *g, const char *key, size_t *n) {
  deck *d = g->d;
  deck_node *list = deck_get(g, key);
  const deck_range range = deck_key_find(g->table, key)->range;
  *n = deck_each_count(list);
  if (*n == 0) deck_fail_key(g, key, "expected a list of numbers %s", deck_range_text(range));
  double *x = deck_alloc(d, *n, sizeof *x);
  for (size_t k = 0; k < *n; k++) {
    deck_node *value = deck_each(list, k);
    if (deck_value_number(d, value, false, &x[k]) && !deck_in_range(range, x[k]))
      deck_fail(d, value, "expected a number %s", deck_range_text(range));
  }
  return x;
}

static void read_list(deck_group *g, sizes *s) {
  size_t n_weights;
  s->radii = read_numbers(g, "radii", &s->n);
  if (s->n == 0) return;
  if (!deck_get(g, "weights")) {
    deck_node *list = deck_default_list(g, "weights");
    for (size_t k = 0; k < s->n; k++)
      deck_node_new(g->d, list, NULL, DECK_FLOAT, list->place)->value.number = 1;
  }
  s->weights = read_numbers(g, "weights", &n_weights);
  if (n_weights != s->n) {
    deck_fail_key(g, "weights", "%zu weights for %zu radii; expected one for each", n_weights,
                  s->n);
    return;
  }
  s->lower = HUGE_VAL;
  for (size_t k = 0; k < s->n; k++)
    if (s->weights[k] > 0) {
      s->lower = fmin(s->lower, s->radii[k]);
      s->upper = fmax(s->upper, s->radii[k]);
    }
  if (!(s->upper > 0)) deck_fail_key(g, "weights", "all are 0");
}

/* Sets the default limits of gaussian and lognormal distributions: 3 standard deviations on each
 * side. */
static void cut_normal(deck_group *g, const sizes *s) {
  bool logarithm = s->kind == SD_SIZES_LOGNORMAL;
  double lower = logarithm ? s->radius * exp(-3 * s->deviation) : s->radius - 3 * s->deviation;
  double upper = logarithm ? s->radius * exp(3 * s->deviation) : s->radius + 3 * s->deviation;
  if (!deck_get(g, "lower") && !(lower > 0)) {
    deck_fail_key(g, "lower", "missing: 3 deviations below the mean is %g; expected a radius > 0",
                  lower);
    return;
  }
  deck_default_number(g, "lower", lower);
  deck_default_number(g, "upper", upper);
}

void deck_finish_sizes(deck_group *g, sizes *s) {
  deck *d = g->d;
  size_t before = d->reported;
  if (s->kind == SD_SIZES_MONO) {
    s->lower = s->upper = s->radius;
    return;
  }
  if (s->kind == SD_SIZES_LIST) {
    read_list(g, s);
    return;
  }
  if (s->kind == SD_SIZES_GAUSSIAN || s->kind == SD_SIZES_LOGNORMAL) cut_normal(g, s);
  if (d->reported > before) return;
  s->lower = deck_number(g, "lower");
  s->upper = deck_number(g, "upper");
  if (s->lower >= s->upper && deck_given(g, "upper"))
    deck_fail_key(g, "upper", "expected more than lower, %g", s->lower);
  else if (s->lower >= s->upper)
    deck_fail_key(g, "lower", "expected less than upper, %g", s->upper);
  if (d->reported == before && sizes_kept(s) < LEAST_KEPT)
    deck_fail_key(g, "lower", "only %g of the distribution lies between lower and upper",
                  sizes_kept(s));
}

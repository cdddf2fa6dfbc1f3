/* slow_until.c: the table of docs/studies/checks.md on runs that end by their own error bar. */
#include "model/model.h"
#include "sequential.h"

enum { SEEDS = 1000 };

/* One look too many or too early shows in chi2. */
static void ended_by_their_error_bars(void **unused) {
  const double ten = 19.0 / 21, one = 1.0 / 3; /* rho for tau = 10 and 1 */
  const struct {
    sequential c;
    double chi2, bias; /* at most */
  } cases[] = {
      {{ten, 2000, 100, 0}, 1.8, 0.2},
      {{ten, 2000, 500, 0}, 1.8, 0.2},
      {{ten, 2000, 1000, 0}, 1.7, 0.2},
      {{one, 200, 100, 0}, 2, 0.2},
      {{ten, 10000, 100, 0}, 1.7, 0.15},
      {{ten, 10000, 1000, 0}, 1.5, 0.15},
      {{one, 1000, 100, 0}, 1.65, 0.15},
      {{ten, 50000, 1000, 0}, 1.3, 0.15},
      /* the same goal as 0.5 %, 5 %, 15 % of the mean */
      {{ten, 10000, 1000, 9}, 1.5, 0.2},
      {{ten, 10000, 1000, 0.9}, 1.6, 0.35},
      {{ten, 10000, 1000, 0.3}, 1.8, 0.8},
  };
  print_message("|  tau | least | wanted | relative | length | early | error | within | chi2 | "
                "bias | fixed within | fixed chi2 |\n");
  for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
    sequential_found f = sequential_trial(&cases[k].c, SEEDS);
    print_sequential(&cases[k].c, &f);
    assert_true(f.reached > 1 - 1e-9);
    assert_true(f.chi2 > 0.85 && f.chi2 < cases[k].chi2);
    assert_true(fabs(f.bias) < cases[k].bias);
    assert_true(f.fixed_chi2 > 0.85 && f.fixed_chi2 < 1.4);
  }
}

RUN_TESTS(TEST(ended_by_their_error_bars))

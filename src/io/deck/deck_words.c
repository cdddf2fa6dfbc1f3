/* deck_words.c: words of other programs and of textbooks, and the keys that say the same. See deck_read.h. */
#include <string.h>
#include <strings.h>

#include "io/deck/deck_read.h"

/* A row counts for tables that have the first key; keys: as the hint has them, behind "did you mean". */
static const struct word {
  const char *word, *key, *hint;
} words[] = {
    {"friction", "mu", NULL},
    {"friction_coefficient", "mu", NULL},
    {"coefficient_of_friction", "mu", NULL},
    {"mu_s", "mu", NULL},
    {"xmu", "mu", NULL},
    {"mu_d", "mu_kinetic", NULL},
    {"rolling_friction", "mu_r", NULL},
    {"mu_rolling", "mu_r", NULL},
    {"e", "restitution", NULL},
    {"e_n", "restitution", NULL},
    {"en", "restitution", NULL},
    {"cor", "restitution", NULL},
    {"coefficient_of_restitution", "restitution", NULL},
    {"stiffness", "k_n", NULL},
    {"kn", "k_n", NULL},
    {"kt", "k_t", NULL},
    {"ks", "k_t", NULL},
    {"k_s", "k_t", NULL},
    {"viscosity", "gamma_n", NULL},
    {"damping", "gamma_n", "gamma_n or restitution"},
    {"young", "k_n", "k_n, of law = \"hertz\" 4/3 E_eff sqrt(R_eff)"},
    {"youngs_modulus", "k_n", "k_n, of law = \"hertz\" 4/3 E_eff sqrt(R_eff)"},
    {"young_modulus", "k_n", "k_n, of law = \"hertz\" 4/3 E_eff sqrt(R_eff)"},
    {"E", "k_n", "k_n, of law = \"hertz\" 4/3 E_eff sqrt(R_eff)"},
    {"poisson", "k_n", "k_t, of tangential = \"mindlin\" 3 (1 - nu)/(2 - nu) k_n"},
    {"poisson_ratio", "k_n", "k_t, of tangential = \"mindlin\" 3 (1 - nu)/(2 - nu) k_n"},
    {"adhesion", "cohesion", NULL},
    {"shear_rate", "rate_xy", NULL},
    {"strain_rate", "rate_xy", "rate_xx, rate_yy or rate_xy"},
    {"pressure", "stress_xx", "stress_xx and stress_yy"},
    {"p", "stress_xx", "stress_xx and stress_yy"},
    {"stress", "stress_xx", "stress_xx, stress_yy or stress_xy"},
    {"diameter", "radius", "radius, half of it"},
    {"r", "radius", NULL},
    {"position", "vx", "x and y"},
    {"pos", "vx", "x and y"},
    {"velocity", "vx", "vx and vy"},
    {"angle", "theta", NULL},
    {"timestep", "dt", NULL},
    {"time_step", "dt", NULL},
    {"duration", "time", NULL},
    {"t_end", "time", NULL},
};

const char *deck_other_word(deck *d, const deck_table *table, const char *word) {
  for (size_t k = 0; k < sizeof words / sizeof *words; k++) {
    const struct word *w = &words[k];
    /* "E" is not "e" */
    const bool same = word[1] ? strcasecmp(word, w->word) == 0 : strcmp(word, w->word) == 0;
    if (!same || !deck_key_find(table, w->key)) continue;
    return w->hint ? deck_format(d, "; did you mean %s?", w->hint)
                   : deck_format(d, "; did you mean \"%s\"?", w->key);
  }
  return NULL;
}

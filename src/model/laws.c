/* laws.c: deck keys and checks of contact laws, and flags of the parts that a law has; see
 * laws.h. */
#include "model/laws.h"

#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/text.h"
#include "model/law_cohesion.h"
#include "model/normal_laws.h"
#include "model/rows.h"

#define LAW_WORD(number, word, keys, meaning) {#word, number, keys, meaning},
static const deck_shape normal_words[] = {NORMAL_LAWS(LAW_WORD) LAST_WORD};
static const deck_shape cohesion_words[] = {COHESION_LAWS(LAW_WORD) LAST_WORD};
#undef LAW_WORD
static const deck_shape tangential_words[] = {WORD("spring", SD_TANGENTIAL_SPRING),
                                              WORD("mindlin", SD_TANGENTIAL_MINDLIN), LAST_WORD};

static const deck_key law_keys[] = {
    {"law", CHOICE, "\"linear\"", normal_words, "normal law, see below",
     SETS(sd_contact_law, normal)},
    {"k_n", NUMBER(DECK_POSITIVE, "force/length"), "-", NULL,
     "normal stiffness; hertz: force/length^(3/2); required unless E_star is given",
     SETS(sd_contact_law, k_n)},
    {"E_star", NUMBER(DECK_POSITIVE, "force/length^2"), "-", NULL,
     "hertz: effective modulus in place of k_n, which is then 4/3 E_star sqrt(R_eff) of each "
     "contact",
     SETS(sd_contact_law, E_star)},
    {"k_t", NUMBER(DECK_NOT_NEGATIVE, "force/length"), "0.0", NULL,
     "stiffness of the tangential spring; mindlin: force/length^(3/2)", SETS(sd_contact_law, k_t)},
    {"poisson", NUMBER(DECK_POSITIVE, "-"), "-", NULL,
     "mindlin with E_star: Poisson's ratio in place of k_t, which is then 3 (1 - nu)/(2 - nu) k_n",
     SETS(sd_contact_law, poisson)},
    {"gamma_n", NUMBER(DECK_NOT_NEGATIVE, "force time/length"), "0.0", NULL, "normal viscosity",
     SETS(sd_contact_law, gamma_n)},
    {"mu", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.0", NULL, "coefficient of friction (Amonton)",
     SETS(sd_contact_law, mu)},
    {"restitution", NUMBER(DECK_UP_TO_1, "-"), "-", NULL,
     "coefficient of restitution at any speed; its damping (1: none) is added to gamma_n",
     SETS(sd_contact_law, restitution)},
    {"limit_damping", BOOL, "true", NULL,
     "the normal force of an overlap never pulls; false: damping may pull until the overlap ends",
     SETS_OFF(sd_contact_law, damping_pulls)},
    {"mu_kinetic", NUMBER(DECK_POSITIVE, "-"), "-", NULL,
     "coefficient of friction of sliding contacts, at most mu; not given: mu",
     SETS(sd_contact_law, mu_kinetic)},
    {"tangential", CHOICE, "\"spring\"", tangential_words,
     "tangential stiffness: k_t, or k_t sqrt(delta) (mindlin)", SETS(sd_contact_law, tangential)},
    {"gamma_t", NUMBER(DECK_NOT_NEGATIVE, "force time/length"), "0.0", NULL,
     "tangential viscosity, within the limit of friction", SETS(sd_contact_law, gamma_t)},
    {"k_r", NUMBER(DECK_NOT_NEGATIVE, "force/length"), "0.0", NULL,
     "rolling stiffness, for the displacement R_eff (theta_a - theta_b)",
     SETS(sd_contact_law, k_r)},
    {"gamma_r", NUMBER(DECK_NOT_NEGATIVE, "force time/length"), "0.0", NULL,
     "rolling viscosity, within the limit of rolling friction", SETS(sd_contact_law, gamma_r)},
    {"drag_r", NUMBER(DECK_NOT_NEGATIVE, "force time/length"), "0.0", NULL,
     "rolling viscosity without limit, also without k_r", SETS(sd_contact_law, drag_r)},
    {"mu_r", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.0", NULL,
     "coefficient of rolling friction: the couple is at most mu_r R_eff F_n",
     SETS(sd_contact_law, mu_r)},
    {"cohesion", CHOICE, "\"none\"", cohesion_words, "attraction, see below",
     SETS(sd_contact_law, cohesion)},
    {"pull_off", NUMBER(DECK_POSITIVE, "force"), "-", NULL, "largest attraction",
     SETS(sd_contact_law, pull_off)},
    {"range", NUMBER(DECK_NOT_NEGATIVE, "length"), "-", NULL,
     "constant: gap at which the attraction ends; bridge: gap over which it falls to 1/e",
     SETS(sd_contact_law, range)},
    {"rupture", NUMBER(DECK_POSITIVE, "length"), "-", NULL, "bridge: gap at which it breaks",
     SETS(sd_contact_law, rupture)},
};
TABLE(law_table, "materials", false, "The law of a contact.", law_keys);

/* --- errors of laws --------------------------------------------------------------------------- */

char *law_mistake(const sd_contact_law *law, const char **key, double *value) {
  sd_contact_law derived = *law;
  derived.k_n = derived.k_t = 0;
  law_complete(&derived);
  const bool bridge = law->cohesion == SD_COHESION_BRIDGE;
  const struct {
    bool wrong;
    const char *key;
    double value;
    const char *text;
  } rules[] = {
      /* law_mistake appends the value of mu to the text of this row */
      {law->mu_kinetic > law->mu, "mu_kinetic", law->mu_kinetic, "expected at most mu"},
      {law->E_star > 0 && law->normal != SD_NORMAL_HERTZ, "E_star", law->E_star,
       "a modulus is for law = \"hertz\"; give that, or k_n in place of E_star"},
      {law->E_star > 0 && law->k_n != derived.k_n, "k_n", law->k_n,
       "with E_star the stiffness is 4/3 E_star sqrt(R_eff); leave out one of the two"},
      {law->poisson > 0.5, "poisson", law->poisson, "expected at most 0.5"},
      {law->poisson > 0 && !(law->E_star > 0), "poisson", law->poisson,
       "without E_star it has no stiffness to refer to; give E_star in place of k_n, or k_t in "
       "place of poisson"},
      {law->poisson > 0 && law->tangential != SD_TANGENTIAL_MINDLIN, "poisson", law->poisson,
       "Poisson's ratio is for tangential = \"mindlin\"; give that, or k_t in place of poisson"},
      {law->poisson > 0 && law->k_t != derived.k_t, "k_t", law->k_t,
       "with poisson it is 3 (1 - nu)/(2 - nu) k_n; leave out one of the two"},
      {law->gamma_t > 0 && !(law->k_t > 0 && law->mu > 0), "gamma_t", law->gamma_t,
       "without k_t and mu there is no tangential force; give both"},
      {law->gamma_r > 0 && !(law->k_r > 0), "gamma_r", law->gamma_r,
       "without k_r there is no rolling resistance"},
      {law->mu_r > 0 && !(law->k_r > 0), "mu_r", law->mu_r,
       "without k_r there is no rolling resistance; give k_r, usually of the size of k_t"},
      {law->cohesion != SD_COHESION_NONE && !(law->pull_off > 0), "pull_off", law->pull_off,
       "expected a force > 0"},
      {bridge && !(law->range > 0), "range", law->range, "expected a decay length > 0"},
      {bridge && !(law->rupture > 0), "rupture", law->rupture, "expected a gap > 0"},
  };
  for (size_t k = 0; k < sizeof rules / sizeof *rules; k++) {
    if (!rules[k].wrong || isnan(rules[k].value)) continue; /* NaN is reported by another check */
    *key = rules[k].key;
    *value = rules[k].value;
    return k == 0 ? format_text("%s = %g", rules[k].text, law->mu)
                  : format_text("%s", rules[k].text);
  }
  return NULL;
}

double law_pull(const sd_contact_law *law, double delta) {
  const double gap = math_max(-delta, 0.0);
  switch (law->cohesion) {
    case SD_COHESION_CONSTANT:
      return gap > 0.0 ? law->pull_off * math_max(1.0 - gap / law->range, 0.0) : law->pull_off;
    case SD_COHESION_BRIDGE: return law->pull_off * math_exp(-gap / law->range);
    case SD_COHESION_NONE: break;
  }
  return 0.0;
}

/* --- features --------------------------------------------------------------------------------- */

unsigned law_features(const sd_contact_law *law) {
  unsigned f = 0;
  if (!law_is_given(law)) return 0;
  if (law->normal != SD_NORMAL_LINEAR) f |= LAW_NORMAL;
  if (law->restitution > 0 && law->restitution < 1) f |= LAW_NORMAL;
  if (law->damping_pulls && (law->gamma_n > 0 || (f & LAW_NORMAL))) f |= LAW_PULLS;
  if (law->mu_kinetic > 0 && law->mu_kinetic < law->mu) f |= LAW_KINETIC;
  if (law->k_t > 0 && law->tangential == SD_TANGENTIAL_MINDLIN) f |= LAW_MINDLIN;
  if (law->gamma_t > 0) f |= LAW_DASHPOT;
  if (law->k_r > 0 || law->drag_r > 0) f |= LAW_ROLLING;
  if (law->cohesion != SD_COHESION_NONE) f |= LAW_COHESION;
  if (law->cohesion == SD_COHESION_BRIDGE) f |= LAW_BRIDGE;
  if (law->E_star > 0) f |= LAW_RADIUS;
  return f;
}

/* Returns the largest gap at which a contact law attracts; 0: no attraction. */
static double reach_of(const sd_contact_law *law) {
  return law->cohesion == SD_COHESION_BRIDGE     ? law->rupture
         : law->cohesion == SD_COHESION_CONSTANT ? law->range
                                                 : 0.0;
}

double laws_range(const sd_model *m) {
  double farthest = 0.0;
  for (size_t k = 0; m->laws && k < m->n_materials * m->n_materials; k++)
    farthest = math_max(farthest, reach_of(&m->laws[k]));
  return farthest;
}

unsigned laws_features(const sd_model *m) {
  unsigned f = 0;
  for (size_t k = 0; k < m->n_materials * m->n_materials; k++) f |= law_features(&m->laws[k]);
  return f;
}

bool laws_frictionless(const sd_model *m) {
  for (size_t k = 0; k < m->n_materials * m->n_materials; k++)
    if (m->laws[k].k_n > 0.0 && m->laws[k].mu > 0.0 && m->laws[k].k_t > 0.0) return false;
  return true;
}

bool law_is_same(const sd_contact_law *a, const sd_contact_law *b) {
  const deck_key *key;
  for (size_t k = 0; (key = deck_key_at(&law_table, k)); k++)
    if (deck_key_value(key, a) != deck_key_value(key, b)) return false;
  return true;
}

/* --- pairs of materials in use ---------------------------------------------------------------- */

/* Bodies with invalid material numbers are skipped here; sd_model_finish reports them. */
void laws_count_uses(const sd_model *m, law_use *use) {
  /* [2 * material]: number of disks, [2 * material + 1]: number of free disks */
  int64_t *counts = memory_new(2 * m->n_materials, sizeof *counts);
  for (size_t row = rows_first(m); row < rows_count(m); row++) {
    const sd_disk *d = rows_disk(m, row);
    if (d->material < 0) continue;
    counts[2 * d->material]++;
    counts[2 * d->material + 1] += !d->driven;
  }
  comm_add(m->comm, counts, 2 * m->n_materials);
  for (size_t k = 0; k < m->n_materials; k++) {
    use[k].count += (size_t)counts[2 * k];
    use[k].free_disk = use[k].free_disk || counts[2 * k + 1] > 0;
  }
  free(counts);
  for (size_t w = 0; w < m->n_walls; w++)
    if (m->walls[w].material >= 0) use[m->walls[w].material].count++;
}

/* True if bodies of the two materials exist that can touch, one of them a free disk. */
static bool can_touch(const law_use *use, size_t a, size_t b) {
  if (!use[a].count || !use[b].count || !(use[a].free_disk || use[b].free_disk)) return false;
  return a != b || use[a].count > 1;
}

bool laws_find_missing(const sd_model *m, const law_use *use, size_t *a, size_t *b) {
  for (; *a < m->n_materials; *b = ++*a)
    for (; *b < m->n_materials; ++*b)
      if (can_touch(use, *a, *b) && !law_is_given(sd_model_law(m, (int)*a, (int)*b))) return true;
  return false;
}

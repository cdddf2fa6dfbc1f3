/* laws.c: deck keys and checks of contact laws, and flags of the parts that a law has; see
 * laws.h. */
#include "model/laws.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/hash.h"
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
    {"critical_load", NUMBER(DECK_NOT_NEGATIVE, "force"), "0.0", NULL,
     "friction begins at this normal force: it is at most mu (F_n - critical_load)",
     SETS(sd_contact_law, critical_load)},
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
    {"bond_k_n", NUMBER(DECK_POSITIVE, "force/length"), "-", NULL,
     "bond: normal stiffness, also in tension; phases make bonds (key bond)",
     SETS(sd_contact_law, bond_k_n)},
    {"bond_k_t", NUMBER(DECK_NOT_NEGATIVE, "force/length"), "0.0", NULL, "bond: shear stiffness",
     SETS(sd_contact_law, bond_k_t)},
    {"bond_k_r", NUMBER(DECK_NOT_NEGATIVE, "force/length"), "0.0", NULL,
     "bond: bending stiffness, for the displacement R_eff (theta_a - theta_b)",
     SETS(sd_contact_law, bond_k_r)},
    {"bond_E", NUMBER(DECK_POSITIVE, "force/length"), "-", NULL,
     "bond: Young's modulus of a beam of length R_a + R_b, in place of the stiffnesses",
     SETS(sd_contact_law, bond_E)},
    {"bond_poisson", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.0", NULL,
     "bond: Poisson's ratio of the beam", SETS(sd_contact_law, bond_poisson)},
    {"bond_width", NUMBER(DECK_POSITIVE, "length"), "-", NULL,
     "bond: width of the beam; also for strengths that are stresses",
     SETS(sd_contact_law, bond_width)},
    {"bond_gamma_n", NUMBER(DECK_NOT_NEGATIVE, "force time/length"), "0.0", NULL,
     "bond: normal viscosity", SETS(sd_contact_law, bond_gamma_n)},
    {"bond_gamma_t", NUMBER(DECK_NOT_NEGATIVE, "force time/length"), "0.0", NULL,
     "bond: viscosity of shear", SETS(sd_contact_law, bond_gamma_t)},
    {"bond_gamma_r", NUMBER(DECK_NOT_NEGATIVE, "force time/length"), "0.0", NULL,
     "bond: viscosity of bending", SETS(sd_contact_law, bond_gamma_r)},
    {"bond_alone", BOOL, "false", NULL,
     "while a bond lasts, its contact has no friction and no rolling friction",
     SETS(sd_contact_law, bond_alone)},
    {"bond_gap", NUMBER(DECK_NOT_NEGATIVE, "length"), "0.0", NULL,
     "bond: largest gap of two surfaces that become bonded", SETS(sd_contact_law, bond_gap)},
    {"bond_tension", NUMBER(DECK_POSITIVE, "force/length"), "-", NULL,
     "bond: tensile strength of the beam, in tension and bending",
     SETS(sd_contact_law, bond_tension)},
    {"bond_cohesion", NUMBER(DECK_POSITIVE, "force/length"), "-", NULL,
     "bond: shear strength of the beam without compression", SETS(sd_contact_law, bond_cohesion)},
    {"bond_friction", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.0", NULL,
     "bond: shear strength per compressive stress, tan(phi)", SETS(sd_contact_law, bond_friction)},
    {"bond_max_tension", NUMBER(DECK_POSITIVE, "force"), "-", NULL,
     "bond: tensile strength as a force; the loads of tension, shear and bending add up",
     SETS(sd_contact_law, bond_max_tension)},
    {"bond_max_shear", NUMBER(DECK_POSITIVE, "force"), "-", NULL, "bond: shear strength as a force",
     SETS(sd_contact_law, bond_max_shear)},
    {"bond_max_bending", NUMBER(DECK_POSITIVE, "force length"), "-", NULL,
     "bond: bending strength as a moment", SETS(sd_contact_law, bond_max_bending)},
    {"bond_extension", NUMBER(DECK_POSITIVE, "length"), "-", NULL,
     "bond: it breaks when it is longer by this; required without a tensile strength",
     SETS(sd_contact_law, bond_extension)},
    {"bond_weibull", NUMBER(DECK_POSITIVE, "-"), "-", NULL,
     "bond: Weibull modulus of the strengths; not given: all are alike",
     SETS(sd_contact_law, bond_weibull)},
};
TABLE(law_table, "materials", false, "The law of a contact.", law_keys);

/* --- errors of laws --------------------------------------------------------------------------- */

/* Returns the first key of a bond that has a value, and its value; NULL: none. */
static const char *bond_key(const sd_contact_law *law, double *value) {
  const deck_key *key;
  for (size_t k = 0; (key = deck_key_at(&law_table, k)); k++) {
    *value = deck_key_value(key, law);
    if (strncmp(key->name, "bond_", 5) == 0 && *value != 0.0) return key->name;
  }
  return NULL;
}

/* Returns what is wrong with the bonds of a law, or NULL; key and value as in law_mistake. */
static const char *bond_mistake(const sd_contact_law *law, const char **key, double *value) {
  double given = 0.0;
  const char *any = bond_key(law, &given);
  const bool forces = law->bond_max_tension + law->bond_max_shear + law->bond_max_bending > 0,
             stresses = law->bond_tension + law->bond_cohesion > 0;
  const struct {
    bool wrong;
    const char *key;
    double value;
    const char *text;
  } rules[] = {
      {any && !(law->bond_k_n > 0 || law->bond_E > 0), any, given,
       "a bond needs a stiffness; give bond_k_n, or bond_E and bond_width"},
      {law->bond_E > 0 && law->bond_k_n + law->bond_k_t + law->bond_k_r > 0, "bond_E", law->bond_E,
       "bond_E takes the place of bond_k_n, bond_k_t and bond_k_r; leave out one of the two"},
      {law->bond_poisson > 0 && !(law->bond_E > 0), "bond_poisson", law->bond_poisson,
       "without bond_E it has no stiffness to refer to; give bond_E, or bond_k_t"},
      {law->bond_poisson > 0.5, "bond_poisson", law->bond_poisson, "expected at most 0.5"},
      {law->bond_E > 0 && !(law->bond_width > 0), "bond_E", law->bond_E,
       "a beam needs its width; give bond_width"},
      {stresses && !(law->bond_width > 0), law->bond_tension > 0 ? "bond_tension" : "bond_cohesion",
       law->bond_tension > 0 ? law->bond_tension : law->bond_cohesion,
       "a stress needs the width of the bond; give bond_width, or the strengths as forces "
       "(bond_max_tension, bond_max_shear, bond_max_bending)"},
      {stresses && forces, law->bond_tension > 0 ? "bond_tension" : "bond_cohesion",
       law->bond_tension > 0 ? law->bond_tension : law->bond_cohesion,
       "strengths are either stresses or forces; leave out these, or the keys bond_max_..."},
      {law->bond_friction > 0 && !(law->bond_cohesion > 0 || law->bond_max_shear > 0),
       "bond_friction", law->bond_friction,
       "it adds to a shear strength; give bond_cohesion or bond_max_shear"},
      {law->bond_weibull > 0 && !(stresses || forces), "bond_weibull", law->bond_weibull,
       "without a strength nothing is distributed; give bond_tension or bond_max_tension"},
      {any && !(law->bond_tension + law->bond_max_tension + law->bond_extension > 0), any, given,
       "a bond needs a tensile strength, or the extension at which it breaks, by which its "
       "neighbours are found; give bond_tension, bond_max_tension or bond_extension (a tenth of a "
       "radius, for a bond that is not to break)"},
      {any && law->cohesion == SD_COHESION_BRIDGE, any, given,
       "a pair of materials has bonds or capillary bridges, not both"},
      {any && law->cohesion == SD_COHESION_CONSTANT && !(law->range > 0), "range", law->range,
       "attraction beside a bond needs the gap at which it ends; expected a length > 0"},
  };
  for (size_t k = 0; k < sizeof rules / sizeof *rules; k++) {
    if (!rules[k].wrong || isnan(rules[k].value)) continue;
    *key = rules[k].key;
    *value = rules[k].value;
    return rules[k].text;
  }
  return NULL;
}

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
      {law->critical_load > 0 && !(law->k_t > 0 && law->mu > 0), "critical_load",
       law->critical_load, "without k_t and mu there is no friction at any load; give both"},
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
  const char *text = bond_mistake(law, key, value);
  return text ? format_text("%s", text) : NULL;
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
  if (law->critical_load > 0) f |= LAW_CRITICAL;
  if (law->k_t > 0 && law->tangential == SD_TANGENTIAL_MINDLIN) f |= LAW_MINDLIN;
  if (law->gamma_t > 0) f |= LAW_DASHPOT;
  if (law->k_r > 0 || law->drag_r > 0) f |= LAW_ROLLING;
  if (law->cohesion != SD_COHESION_NONE) f |= LAW_COHESION;
  if (law->cohesion == SD_COHESION_BRIDGE) f |= LAW_BRIDGE;
  if (law->E_star > 0) f |= LAW_RADIUS;
  if (law_bonds(law)) f |= LAW_BOND | LAW_ROLLING; /* a bond uses the rolling displacement */
  if (law->bond_E > 0) f |= LAW_BEAM;
  return f;
}

double bond_strength(const sd_contact_law *law, double u) {
  if (!(law->bond_weibull > 0.0)) return 1.0;
  return math_pow(-math_log(math_max(u, 0x1p-54)), 1.0 / law->bond_weibull);
}

double bond_draw(int64_t seed, uint32_t a, uint32_t b) {
  const uint64_t words[] = {(uint64_t)seed, a < b ? a : b, a < b ? b : a};
  uint64_t h = hash_words(HASH_WORDS, words, sizeof words);
  for (int k = 0; k < 2; k++) { /* mixes high bits into low ones, which FNV-1a does not */
    h ^= h >> 32;
    h *= UINT64_C(0xd6e8feb86659fd93);
  }
  return (double)((h ^ h >> 32) >> 11) * 0x1p-53;
}

sd_contact_law bond_law_at(const sd_contact_law *law, double ra, double rb, double arm) {
  sd_contact_law at = *law;
  if (!(law->bond_E > 0.0)) return at;
  const double length = ra + rb, w = law->bond_width;
  at.bond_k_n = law->bond_E * w / length;
  at.bond_k_t = at.bond_k_n / (2.0 * (1.0 + law->bond_poisson));
  at.bond_k_r = law->bond_E * w * w * w / (12.0 * length * arm * arm);
  at.bond_E = 0.0;
  return at;
}

/* Returns the largest gap of a bond of this law. longest: largest sum of two radii. */
static double bond_reach(const sd_contact_law *law, double longest) {
  if (!law_bonds(law)) return 0.0;
  const double stiffness = bond_law_at(law, longest, 0.0, 1.0).bond_k_n,
               force = law->bond_max_tension + law->bond_tension * law->bond_width;
  double longer = law->bond_extension > 0.0 ? law->bond_extension : HUGE_VAL;
  if (force > 0.0) longer = math_min(longer, bond_strength(law, 0.0) * force / stiffness);
  return law->bond_gap + longer;
}

/* Returns the largest gap at which two bodies exert a force on each other; 0: they must touch. */
static double reach_of(const sd_contact_law *law, double longest) {
  const double attracts = law->cohesion == SD_COHESION_BRIDGE     ? law->rupture
                          : law->cohesion == SD_COHESION_CONSTANT ? law->range
                                                                  : 0.0;
  return math_max(attracts, bond_reach(law, longest));
}

/* Returns the largest sum of the radii of a free disk and another one. */
static double longest_pair(const sd_model *m) {
  double largest = m->largest_radius;
  for (size_t k = 0; k < model_known(m); k++)
    largest = math_max(largest, m->disks[model_known_disk(m, k)].radius);
  return m->largest_radius + largest;
}

double laws_range(const sd_model *m) {
  double farthest = 0.0;
  const double longest = laws_features(m) & LAW_BEAM ? longest_pair(m) : 1.0;
  for (size_t k = 0; m->laws && k < m->n_materials * m->n_materials; k++)
    farthest = math_max(farthest, reach_of(&m->laws[k], longest));
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

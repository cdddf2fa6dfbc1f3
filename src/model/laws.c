/* laws.c: see laws.h. */
#include "model/laws.h"

#include "model/normal_laws.h"

#define LAW_WORD(number, word, keys, meaning) {#word, number, keys, meaning},
static const deck_shape normal_words[] = {NORMAL_LAWS(LAW_WORD) LAST_WORD};
#undef LAW_WORD

static const deck_key law_keys[] = {
    {"law", CHOICE, "\"linear\"", normal_words, "normal law, see below", SETS(sd_contact_law, normal)},
    {"k_n", NUMBER(DECK_POSITIVE, "force/length"), "required", NULL,
     "normal stiffness; hertz: k_n of F = k_n delta^(3/2), force/length^(3/2)", SETS(sd_contact_law, k_n)},
    {"k_t", NUMBER(DECK_NOT_NEGATIVE, "force/length"), "0.0", NULL, "stiffness of the tangential spring",
     SETS(sd_contact_law, k_t)},
    {"gamma_n", NUMBER(DECK_NOT_NEGATIVE, "force time/length"), "0.0", NULL, "normal viscosity",
     SETS(sd_contact_law, gamma_n)},
    {"mu", NUMBER(DECK_NOT_NEGATIVE, "-"), "0.0", NULL, "coefficient of friction (Amonton)",
     SETS(sd_contact_law, mu)},
    {"restitution", NUMBER(DECK_UP_TO_1, "-"), "-", NULL,
     "hertz: coefficient of restitution e at any speed (1: none of its damping), which is added to gamma_n",
     SETS(sd_contact_law, restitution)},
};
TABLE(law_table, "materials", false, "The law of a contact.", law_keys);

/* Materials that are none are left out; they are reported elsewhere. */
void laws_count_uses(const sd_model *m, law_use *use) {
  for (size_t i = 0; i < m->n_disks; i++) {
    if (m->disks[i].material < 0) continue;
    use[m->disks[i].material].count++;
    if (!m->disks[i].driven) use[m->disks[i].material].free_disk = true;
  }
  for (size_t w = 0; w < m->n_walls; w++)
    if (m->walls[w].material >= 0) use[m->walls[w].material].count++;
}

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

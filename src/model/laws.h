/* laws.h: contact laws of pairs of materials: the deck keys of a law, checks, and pairs without
 * a law. A parameter of a law is one row in laws.c and one member of sd_contact_law. */
#ifndef SLIPDISK_MODEL_LAWS_H
#define SLIPDISK_MODEL_LAWS_H

#include "model/keys.h"
#include "slipdisk/model.h"

extern const deck_table law_table;

/* True if the pair of materials has a law, even an invalid one. */
static inline bool law_is_given(const sd_contact_law *law) { return law->k_n != 0.0; }

/* Returns the text of the first error in a contact law, which the caller frees, and writes the
 * key that is wrong and its value. NULL: there is no error. */
char *law_mistake(const sd_contact_law *law, const char **key, double *value);

/* True if all members of two contact laws are equal. */
bool law_is_same(const sd_contact_law *a, const sd_contact_law *b);
/* True if both laws set the same limit to the time step (stability.c). */
bool law_is_as_stiff(const sd_contact_law *a, const sd_contact_law *b);

/* Returns the attractive force of a closed contact at overlap delta (< 0: gap), for
 * measurements. The formulas are in model/law_cohesion.h. */
double law_pull(const sd_contact_law *law, double delta);

/* Numbers of the bodies that are made of one material. */
typedef struct law_use {
  size_t count;   /* number of disks and walls */
  bool free_disk; /* true if at least one of them is a free disk */
} law_use;

/* Collective. Counts the bodies of each material; use: [n_materials], zeroed by the caller. */
void laws_count_uses(const sd_model *model, law_use *use);
/* Finds the next pair of materials *a <= *b, beginning with the given pair, for which no contact
 * law is given although bodies of them can touch, one of them a free disk. False: there are no
 * more. */
bool laws_find_missing(const sd_model *model, const law_use *use, size_t *a, size_t *b);

/* Returns the largest gap at which two bodies of the model exert a force on each other, by
 * attraction or a bond; 0: only where they touch. */
double laws_range(const sd_model *model);

#endif

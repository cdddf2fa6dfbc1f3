/* laws.h: contact laws of pairs of materials: the deck keys of a law, checks, and pairs without
 * a law. A parameter of a law is one row in laws.c and one member of sd_contact_law. */
#ifndef SLIPDISK_MODEL_LAWS_H
#define SLIPDISK_MODEL_LAWS_H

#include "model/keys.h"
#include "model/model.h"

extern const deck_table law_table;

/* True if the pair of materials has a law, even an invalid one. */
static inline bool law_is_given(const sd_contact_law *law) { return law->k_n != 0.0; }

/* Returns the text of the first error in a law, to be freed, and its key and value; NULL: no
 * error. */
char *law_mistake(const sd_contact_law *law, const char **key, double *value);

/* True if all members are equal. */
bool law_is_same(const sd_contact_law *a, const sd_contact_law *b);

/* Attraction of a closed contact at overlap delta, force, for measurements
 * (model/law_cohesion.h). */
double law_pull(const sd_contact_law *law, double delta);

/* Use of a material: number of bodies made of it. */
typedef struct law_use {
  size_t count;   /* number of disks and walls */
  bool free_disk; /* true if a free disk is among them */
} law_use;

/* Collective. Counts the bodies of each material; use: [n_materials], zeroed by the caller. */
void laws_count_uses(const sd_model *model, law_use *use);
/* Finds the next pair of materials, from (*a, *b) on, *a <= *b, that can touch and has no law;
 * one of them has a free disk. False: there are no more. */
bool laws_find_missing(const sd_model *model, const law_use *use, size_t *a, size_t *b);

/* Largest gap over which any law attracts; 0: no law does. */
double laws_reach(const sd_model *model);

#endif

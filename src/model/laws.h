/* laws.h: what describes the contact of two materials: the keys of a law, which laws there are, and which are
 * missing. A parameter of a law is one row in laws.c and one member of sd_contact_law. */
#ifndef SLIPDISK_MODEL_LAWS_H
#define SLIPDISK_MODEL_LAWS_H

#include "model/keys.h"
#include "model/law_features.h"
#include "model/model.h"

extern const deck_table law_table;

/* The pair of materials has a law, be it one with mistakes. */
static inline bool law_is_given(const sd_contact_law *law) { return law->k_n != 0.0; }

/* First mistake of a law: its key and value, and the text to be freed. NULL: there is none. */
char *law_mistake(const sd_contact_law *law, const char **key, double *value);

/* All members are equal. */
bool law_is_same(const sd_contact_law *a, const sd_contact_law *b);

/* Attraction of a closed contact (model/law_cohesion.h), for what is measured. */
double law_pull(const sd_contact_law *law, double delta);

/* Bodies made of a material. */
typedef struct law_use {
  size_t count; /* disks and walls */
  bool free_disk;
} law_use;

/* use: [n_materials], zeroed. */
void laws_count_uses(const sd_model *model, law_use *use);
/* From the pair a <= b on, the next two materials that can touch and have no law: at least one has a disk that is free
 * to move. False: no more. */
bool laws_find_missing(const sd_model *model, const law_use *use, size_t *a, size_t *b);

/* The gap over which disks of any two materials attract each other, at most. */
double laws_reach(const sd_model *model);

#endif

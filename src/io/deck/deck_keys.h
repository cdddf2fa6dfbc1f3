/* deck_keys.h: all groups that a deck may have, with their keys.
 *
 * Unknown keys, ranges, defaults, the echo and docs/deck.md follow the rows (model/keys.h); a
 * test compares docs/deck.md with them in both directions. Groups that set members of the model
 * are in model/keys.h; the groups here are those of bodies, motions and sweeps. */
#ifndef SLIPDISK_IO_DECK_KEYS_H
#define SLIPDISK_IO_DECK_KEYS_H

#include "model/keys.h"
#include "model/model.h"

extern const deck_table deck_materials, deck_pairs, deck_container, deck_disks, deck_disk_rows,
    deck_disk_files, deck_packings, deck_packing_clump, deck_clumps, deck_forces, deck_locks,
    deck_walls, deck_motions, deck_sweeps, deck_sweep_parameters;
extern const deck_table *const deck_tables[];
extern const size_t deck_table_count;

enum { DECK_MOTION_FIXED = SD_MOTION_KINDS };
extern const deck_shape deck_motion_kinds[];

const char *deck_kind_text(deck_kind kind);
/* Returns true if the word is in a list such as "points* pivot" or "mass/density". */
bool deck_listed(const char *list, const char *word);
/* Returns true if some group allows only one of these two keys. */
bool deck_keys_exclude(const char *a, const char *b);

/* Returns true if every key of this name, in any group, is a flag; with flag = false: if every
 * one is a number or a list of numbers. */
bool deck_names_kind(const char *name, bool flag);

#endif

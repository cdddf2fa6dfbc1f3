/* deck.h: what the rest of the program needs of decks besides slipdisk/deck.h: the points of a sweep, how two decks
 * differ, and the reference of the keys.
 *
 * A point is the deck with some keys set, exactly as -D would set them, and a seed of its own. Points are
 * told apart by what they set and not by their number: when values or replicas are added to a deck later,
 * the points that it had keep their names, their seeds and hence their results.
 */
#ifndef SLIPDISK_IO_DECK_H
#define SLIPDISK_IO_DECK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/comm.h"
#include "model/model.h"

typedef struct sweep_parameter {
  char *name; /* column of the table of results */
  char *path; /* what it sets; several are joined by a blank */
  bool text;  /* some of its values are no numbers */
} sweep_parameter;

/* Where a value stands in the sweep. */
typedef struct sweep_place {
  const char *file; /* one of the sweep's */
  int line;
} sweep_place;

typedef struct sweep_point {
  char *name; /* "tilt=0.04pi,eps=1e-4,r=2"; the result is NAME.h5 */
  size_t n_overrides;
  char **overrides;    /* "path=value", the seed among them; without those of the command line */
  sweep_place *places; /* [n_overrides] */
  double *values;      /* [n_parameters]; an angle in rad; NAN: a text, or not set by this point */
  char **texts;        /* [n_parameters], as in the deck; "": not set by this point */
  int64_t replica;     /* from 0 */
  int64_t seed;
  size_t set; /* points with the same set differ in the replica only; sets count from 0 */
} sweep_point;

typedef struct deck_sweep {
  char *deck_path, *deck_text;
  size_t n_overrides; /* of the command line */
  char **overrides;
  size_t n_parameters, n_points, n_sets;
  sweep_parameter *parameters;
  sweep_point *points;
  size_t n_collect; /* 0: everything */
  char **collect;
  size_t n_files; /* in which the sweep stands: the deck, and what it includes */
  char **files;
  bool
      reads_files; /* the deck names files of disks or of motions: its text does not say everything */
  bool written;    /* the deck has the group, with a grid */
} deck_sweep;

/* Reads the group `sweep` of the deck at path (checked in full by deck_sweep_model only). A deck without one
 * has one point, the deck itself. SD_ERROR_USER: mistakes, each with its line; deck_sweep_free also then. */
sd_status deck_sweep_load(const char *path, size_t n_overrides, const char *const *overrides,
                          deck_sweep *out, sd_messages *messages);
void deck_sweep_free(deck_sweep *s);
/* The model of one point; its messages are those of the deck's loader, with the places of the values in the sweep. */
sd_status deck_sweep_model(const deck_sweep *s, size_t point, sd_model **out,
                           sd_messages *messages);

/* Tells of each key that two decks say otherwise: its path as after -D, and what stands there; NULL: nothing.
 * any_title: the title is no difference. False: one of them is no deck, or no memory. */
typedef void deck_difference(void *user, const char *path, const char *there, const char *here);
bool deck_compare(const char *there, const char *here, bool any_title, deck_difference *tell,
                  void *user);

/* As sd_deck_load; and where the deck could be read, but bodies overlap too much or sd_model_finish finds a mistake, *out is
 * a model that is not finished, to be looked at. */
sd_status deck_look(const char *path, size_t n_overrides, const char *const *overrides,
                    sd_model **out, sd_messages *messages);

/* The text of the deck at path, - being the standard input, to be freed; NULL: reported, with the
 * reason in status. */
char *deck_file_text(const char *path, sd_messages *messages, sd_status *status);
/* The name of this deck in messages and results. */
const char *deck_source(const char *path);

/* Asks more of a finished model; its messages begin with their subject, as those of the model do
 * (deck_locate.c). */
typedef sd_status deck_suits(const sd_model *model, sd_messages *messages);
/* Collective. Loads the text of a deck like sd_deck_load_text, for a run that ranks share: each
 * reads it, and its last disks may be away (model/rows.h). (*out)->comm is c then. suits may be
 * NULL. All get the same status; messages are those of each rank. */
sd_status deck_load_for_ranks(const comm *c, const char *text, const char *path, size_t n_overrides,
                              const char *const *overrides, deck_suits *suits, sd_model **out,
                              sd_messages *messages);

/* A disk as its contacts know it: its angle in a state of this model, beyond that in the file. */
typedef struct deck_turned {
  double radius, shift;
} deck_turned;
/* Is a contact's partner a body of the model? wall: NULL for a disk. */
bool deck_contact_is_kept(const sd_contact_memory *contact, const sd_tile_wall *wall);
/* Turns a contact of the file into one of the model; body numbers stay those of the file. The
 * partner is disk b, or `wall`. carried: its force holds at step 0. */
void deck_carry_contact(sd_contact_memory *contact, deck_turned a, deck_turned b,
                        const sd_tile_wall *wall, bool carried);

/* All keys as Markdown, the way docs/deck.md shows them. */
void deck_keys_print(FILE *out);

#endif

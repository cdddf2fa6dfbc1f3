/* deck.h: functions of the deck reader for the rest of the program, besides slipdisk/deck.h: the
 * points of a sweep, the comparison of two decks, and the reference of the keys.
 *
 * A point is the deck with some keys set, exactly as -D would set them, and a seed of its own. A
 * point is identified by the values that it sets and not by its number: when values or replicas
 * are added to a deck later, the existing points keep their names, their seeds and hence their
 * results. */
#ifndef SLIPDISK_IO_DECK_H
#define SLIPDISK_IO_DECK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/comm.h"
#include "model/model.h"

typedef struct sweep_parameter {
  char *name; /* Column in the table of results */
  char *path; /* Paths of the keys that it sets, separated by blanks */
  bool text;  /* True if some of its values are not numbers */
} sweep_parameter;

/* Source location of a value of the sweep. */
typedef struct sweep_place {
  const char *file; /* File name, owned by deck_sweep.files */
  int line;
} sweep_place;

typedef struct sweep_point {
  char *name; /* Such as "tilt=0.04pi,eps=1e-4,r=2"; the result is NAME.h5 */
  size_t n_overrides;
  char **overrides;    /* "path=value", the seed among them; without those of the command line */
  sweep_place *places; /* [n_overrides]: source location of each override */
  double *values;      /* [n_parameters]; angles in rad; NAN: a text, or not set by this point */
  char **texts;        /* [n_parameters], as written in the deck; "": not set by this point */
  int64_t replica;     /* Number of the replica, from 0 */
  int64_t seed;
  size_t set; /* Points with the same set differ in the replica only; sets count from 0 */
} sweep_point;

typedef struct deck_sweep {
  char *deck_path, *deck_text;
  size_t n_overrides; /* Number of settings of the command line */
  char **overrides;
  size_t n_parameters, n_points, n_sets;
  sweep_parameter *parameters;
  sweep_point *points;
  size_t n_collect; /* Number of collected columns; 0: all columns */
  char **collect;
  size_t n_files; /* Number of files that hold the sweep: the deck, and included files */
  char **files;
  /* True if the deck names files of disks or motions, so that its text alone does not fix the
   * model */
  bool reads_files;
  bool written; /* True if the deck has a group `sweep` with a grid */
} deck_sweep;

/* Reads the group `sweep` of the deck at path (only deck_sweep_model checks the deck in full). A
 * deck without that group has one point, the deck itself. Returns SD_ERROR_USER after mistakes,
 * each reported with its line; call deck_sweep_free also then. */
sd_status deck_sweep_load(const char *path, size_t n_overrides, const char *const *overrides,
                          deck_sweep *out, sd_messages *messages);
void deck_sweep_free(deck_sweep *s);
/* Builds the model of one point; messages are those of the deck's loader, with the source
 * locations of the values in the sweep. */
sd_status deck_sweep_model(const deck_sweep *s, size_t point, sd_model **out,
                           sd_messages *messages);

/* Compares two decks and calls tell() for each key that differs: its path as after -D, and its
 * value in each deck (NULL: absent). any_title: a different title is no difference. Returns
 * false if one of the texts is not a deck, or without memory. */
typedef void deck_difference(void *user, const char *path, const char *there, const char *here);
bool deck_compare(const char *there, const char *here, bool any_title, deck_difference *tell,
                  void *user);

/* Loads a deck as sd_deck_load does. If the deck could be read but bodies overlap too much or
 * sd_model_finish finds a mistake, *out is the unfinished model, for inspection. */
sd_status deck_look(const char *path, size_t n_overrides, const char *const *overrides,
                    sd_model **out, sd_messages *messages);

/* Returns the text of the deck at path ("-": standard input), to be freed; NULL: reported, with
 * the reason in *status. */
char *deck_file_text(const char *path, sd_messages *messages, sd_status *status);
/* Returns the name of this deck in messages and results. */
const char *deck_source(const char *path);

/* Further check of a finished model; its messages begin with their subject, as those of the
 * model do (deck_locate.c). */
typedef sd_status deck_suits(const sd_model *model, sd_messages *messages);
/* Collective. Loads the text of a deck as sd_deck_load_text does, for a run on several ranks:
 * each rank reads it, and its last disks may be away (model/rows.h); then (*out)->comm is c.
 * suits may be NULL. All ranks get the same status; messages are those of each rank. */
sd_status deck_load_for_ranks(const comm *c, const char *text, const char *path, size_t n_overrides,
                              const char *const *overrides, deck_suits *suits, sd_model **out,
                              sd_messages *messages);

/* Radius of a disk of a contact, and the angle (rad) in the state of this model minus the angle
 * in the file. */
typedef struct deck_turned {
  double radius, shift;
} deck_turned;
/* Returns true if the partner of the contact is a body of the model. wall: NULL if it is a disk. */
bool deck_contact_is_kept(const sd_contact_memory *contact, const sd_tile_wall *wall);
/* Converts a contact of the file to the angles and wall segments of the model; body numbers stay
 * those of the file. The partner is disk b, or `wall` if not NULL. carried: the contact's force
 * holds at step 0. */
void deck_carry_contact(sd_contact_memory *contact, deck_turned a, deck_turned b,
                        const sd_tile_wall *wall, bool carried);

/* Prints all keys as Markdown, in the form of docs/deck.md. */
void deck_keys_print(FILE *out);

#endif

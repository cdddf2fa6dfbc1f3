/* deck.h: functions of the deck reader for the rest of the program, besides slipdisk/deck.h: the
 * points of a sweep, the comparison of two decks, and the reference of the keys.
 *
 * A point of a sweep is the deck with some keys set, exactly as -D would set them, and with a seed
 * of its own. A point is identified by the values that it sets and not by its number: when values
 * or replicas are added to a deck later, the existing points keep their names, their seeds and
 * hence their results. */
#ifndef SLIPDISK_IO_DECK_H
#define SLIPDISK_IO_DECK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/comm.h"
#include "model/start.h"
#include "slipdisk/model.h"

typedef struct sweep_parameter {
  char *name; /* Name of the parameter, and of its column in the table of results */
  char *path; /* Paths of the keys that the parameter sets, separated by blanks */
  bool text;  /* True if some values of the parameter are not numbers */
} sweep_parameter;

/* File and line of a value in the group `sweep`. */
typedef struct sweep_place {
  const char *file; /* File name, owned by deck_sweep.files */
  int line;
} sweep_place;

typedef struct sweep_point {
  /* Name of the point, such as "tilt=0.04pi,eps=1e-4,r=2"; its result file is NAME.h5 */
  char *name;
  size_t n_overrides;
  /* Settings "path=value" of the point, including its seed, but not those of the command line */
  char **overrides;
  sweep_place *places; /* [n_overrides]: source location of each setting */
  /* [n_parameters]: values of the parameters, angles in rad; NAN: a text, or not set by this
   * point */
  double *values;
  /* [n_parameters]: values as written in the deck; "": not set by this point */
  char **texts;
  int64_t replica; /* Number of the replica (repetition with another seed), from 0 */
  int64_t seed;
  /* Number of the parameter set, from 0; points with the same set differ only in the replica */
  size_t set;
} sweep_point;

typedef struct deck_sweep {
  char *deck_path, *deck_text;
  size_t n_overrides; /* Number of -D settings on the command line */
  char **overrides;
  size_t n_parameters, n_points, n_sets;
  sweep_parameter *parameters;
  sweep_point *points;
  size_t n_collect; /* Number of result columns that the key `collect` names; 0: all columns */
  char **collect;
  size_t n_files; /* Number of files in which the sweep is written: the deck, and included files */
  char **files;
  /* True if the deck names files of disks or motions, so that its text alone does not determine the
   * model */
  bool reads_files;
  bool written; /* True if the deck has a group `sweep` with a grid */
} deck_sweep;

/* Reads the group `sweep` of the deck at path (only deck_sweep_model checks the deck in full). A
 * deck without that group has one point, the deck itself. Returns SD_ERROR_USER after errors, each
 * reported with its line. The caller must call deck_sweep_free in any case. */
sd_status deck_sweep_load(const char *path, size_t n_overrides, const char *const *overrides,
                          deck_sweep *out, sd_messages *messages);
void deck_sweep_free(deck_sweep *s);
/* Builds the model of one point of the sweep. An error in a value of the point is reported with the
 * file and line of this value in the group `sweep`. */
sd_status deck_sweep_model(const deck_sweep *s, size_t point, sd_model **out,
                           sd_messages *messages);

/* Compares two decks and calls tell() for each key that differs, with the path of the key as
 * written after -D and its value in each deck (NULL: absent). any_title: titles may differ. Returns
 * false if one of the texts cannot be read as a deck, or memory runs out. */
typedef void deck_difference(void *user, const char *path, const char *there, const char *here);
bool deck_compare(const char *there, const char *here, bool any_title, deck_difference *tell,
                  void *user);
/* Returns a difference as text, such as "gravity.tilt: 0.1 there, 0.2 here"; the caller frees
 * it. */
char *deck_difference_text(const char *path, const char *there, const char *here);

/* Loads a deck as sd_deck_load does, for commands: the deck must say how long the run is. */
sd_status deck_load_run(const char *path, size_t n_overrides, const char *const *overrides,
                        sd_model **out, sd_messages *messages);

/* Loads a deck as deck_load_run does. If the deck itself has no errors but bodies overlap too much,
 * or a check in sd_model_finish fails, *out is the unfinished model, for inspection. */
sd_status deck_look(const char *path, size_t n_overrides, const char *const *overrides,
                    sd_model **out, sd_messages *messages);

/* Returns the text of the deck in the file `path` ("-": standard input); the caller frees it. After
 * an error, which is reported, returns NULL and sets *status. */
char *deck_file_text(const char *path, sd_messages *messages, sd_status *status);
/* Returns the name of a deck in messages and results: its path, or "stdin" for the path "-". */
const char *deck_source(const char *path);

/* Type of an additional check of a finished model. Each of its messages begins with the path or
 * body that it is about, so that deck_locate.c can add file and line. */
typedef sd_status deck_suits(const sd_model *model, sd_messages *messages);
/* Collective. Loads the text of a deck for a run on several ranks: each rank reads the whole text,
 * but its last disks may be distributed over the ranks (`away` in model/rows.h); then (*out)->comm
 * is c. suits: additional check, may be NULL. All ranks get the same status; each rank gets its own
 * messages. */
sd_status deck_load_for_ranks(const comm *c, const char *text, const char *path, size_t n_overrides,
                              const char *const *overrides, deck_suits *suits, sd_model **out,
                              sd_messages *messages);

/* One disk of a contact that is read from a file: its radius, and the difference (rad) between its
 * angle in the new model and its angle in the file. */
typedef struct disk_angle_shift {
  double radius, shift;
} disk_angle_shift;
typedef struct sd_tile_wall sd_tile_wall; /* defined in model/model.h */

/* Returns true if a contact read from a file can be kept: its partner is a disk (wall NULL), or a
 * wall, or segment of a wall, that the model has too. */
bool deck_contact_is_kept(const sd_contact_memory *contact, const sd_tile_wall *wall);
/* Converts a contact read from a file to the angles and wall segments of the model; its body
 * numbers stay those of the file. a, b: its disks; wall: the partner if it is a wall (b is then
 * unused), else NULL. carried: the contact force in the file is valid at step 0. */
void deck_carry_contact(sd_contact_memory *contact, disk_angle_shift a, disk_angle_shift b,
                        const sd_tile_wall *wall, bool carried);

/* Prints all keys as Markdown, in the form of docs/deck.md. */
void deck_keys_print(FILE *out);
/* Prints the paths of all keys, as they stand behind -D, one a line; elements of lists are [0]. */
void deck_paths_print(FILE *out);

#endif

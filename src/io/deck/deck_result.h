/* deck_result.h: reads results and checkpoints of a run as the initial state of another run:
 * bodies, contacts and periodic box. */
#ifndef SLIPDISK_IO_DECK_RESULT_H
#define SLIPDISK_IO_DECK_RESULT_H

#include "io/deck/deck_rows.h"

/* Default of the key `dataset` for results of this program; it stands for the last state in the
 * file. */
#define RESULT_DISKS "/particles/disks"

/* A wall as its deck describes it, with the angle (rad) about its pivot and the scale that it had,
 * relative to this description, when the run began (0 and 1 unless that run began from a packing of
 * another run). */
typedef struct result_wall {
  const char *name; /* Name of the wall; "": none */
  /* Kind, shape and position as numbers in a text; walls with equal texts are equal */
  const char *text;
  size_t segments;
  double angle, scale;
} result_wall;

typedef struct result_names {
  size_t n;
  const char **name;
} result_names;

/* Last state in a file. Columns of bodies are in order of body numbers: disks, then walls. If only
 * some rows are read (deck_rows_asked), columns hold only these disks, in the order in which the
 * file stores them (slots), or only the walls. */
typedef struct deck_result {
  const char *path;
  size_t n_disks, n_bodies, n_free;
  /* Number of contacts that were read, and number of contacts in the file */
  size_t n_contacts, all_contacts;
  size_t first_body; /* Body number of row 0 of the columns of bodies */
  /* Index in the file of the first disk that was read, and number of disks read; whole file: 0 and
   * n_disks */
  size_t first, n_rows;
  uint32_t *number; /* [n_rows]: number of each disk in the file */
  double box_scale;
  double *x, *y, *theta, *turn, *vx, *vy, *omega, *radius, *mass, *inertia;
  int32_t *material, *group;
  /* [n_rows]: true for driven disks; true for disks that are removed, or waiting for rain */
  bool *driven, *gone;
  uint32_t *a, *b, *part;
  double *side;
  double *surface; /* [n_surfaces]: displacement of each wall's surface along the wall */
  size_t n_surfaces;
  int32_t *slide;
  /* [SD_CONTACT_ALL]: columns of contacts (slipdisk/contact.h), each [n_contacts] */
  double *record[SD_CONTACT_ALL];
  /* Number of materials in the file, if it has their contact laws; 0: no laws in the file */
  size_t n_materials;
  /* [n_materials * n_materials]: law of materials i and k at index i * n_materials + k */
  sd_contact_law *laws;
  /* True if the contacts have rolling springs and, as far as laws are known, some law has rolling
   * resistance */
  bool rolls;
  int32_t *wall_material; /* [number of walls]: material of each wall of the file */
  /* Time step of the other run if it used Gear's integrator; 0: another integrator, or not known */
  double dt;
  /* [SD_DERIVATIVES]: derivatives of order 3 to 5 of x, y and theta, if both runs use Gear's
   * integrator; else NULL */
  double *derivatives[SD_DERIVATIVES];

  /* The members below are read from the text /parameters/deck_bodies; they are empty without it */
  result_names materials, groups, disk_names;
  size_t n_walls, wall_capacity;
  result_wall *walls;
  bool boxed, periodic[2];
  double lower[2], upper[2];
} deck_result;

/* Returns true if the file holds a state of this program, or is damaged but has the checksum that
 * results have at their end. Gives no messages. */
bool deck_result_has_state(const char *path);
/* Reads the last state in a file: the rows that d->asked selects, and the contacts if `contacts` is
 * true. The state is in the arena. Returns NULL after an error, which is reported at the node. */
deck_result *deck_result_read(deck *d, const deck_node *node, const char *path, bool contacts);
/* Returns text to append to the message that a result is missing: the command that makes it; "" if
 * there is no deck with the name of the result beside it. */
const char *deck_result_maker(deck *d, const char *path);
/* Fills the table with the disks of a result that are in play. Its columns are all properties of
 * disks that the result has and the group does not give itself. */
void deck_result_rows(deck_group *g, deck_node *file, const char *path, deck_columns *table);
/* Returns the edges of the periodic box at the last frame of a result, a checkpoint or another
 * H5MD file; false: reported. Directions that are not periodic in the file have equal edges. */
bool deck_result_box(deck *d, const deck_node *file, double lower[2], double upper[2]);

/* Returns the descriptions of the model's walls at their present positions; in the arena. */
result_wall *deck_result_walls(deck *d);
/* Returns the text /parameters/deck_bodies for the model with these walls; the caller frees it. */
char *deck_result_text(deck *d, const result_wall *walls);
/* Takes over the contacts of all files for which the deck asks for them, and moves walls to their
 * positions in these files. Call it after all disks and walls are there. In deck_memory.c. */
void deck_read_memories(deck *d);
/* Returns contact k of a result; the body numbers in it are those of the file. */
sd_contact_memory deck_result_contact(const deck_result *result, size_t k);
/* Returns the angle (rad) that must be added to theta in the file to get theta in the new state
 * of the disk in this row. The new theta is the total angle minus its nearest multiple of 8 rad,
 * so the two differ by a multiple of 8 and by rounding. */
double deck_result_shift(const deck_result *result, size_t row);

#endif

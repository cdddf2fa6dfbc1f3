/* deck_result.h: results and checkpoints of a run as the initial state of another: bodies,
 * contacts, box. */
#ifndef SLIPDISK_IO_DECK_RESULT_H
#define SLIPDISK_IO_DECK_RESULT_H

#include "io/deck/deck_rows.h"

/* Usual value of the key `dataset`; it stands for the last state of a result. */
#define RESULT_DISKS "/particles/disks"

/* A wall as its deck describes it, and how far the packing from which that run began had turned
 * it about its pivot (rad) and scaled it. */
typedef struct result_wall {
  const char *name; /* Name; "": none */
  const char *text; /* Kind, size and position in words */
  size_t segments;
  double angle, scale;
} result_wall;

typedef struct result_names {
  size_t n;
  const char **name;
} result_names;

/* Last state in a file. Columns of bodies are ordered by body number: disks, then walls. If rows
 * were asked for (deck_rows_asked), columns hold only the disks of these slots in slot order, or
 * only the walls. */
typedef struct deck_result {
  const char *path;
  size_t n_disks, n_bodies, n_free;
  size_t n_contacts, all_contacts; /* Contacts that were read, and contacts in the file */
  size_t first_body;               /* Number of the body in row 0 of the columns of bodies */
  /* Slots of the disks that were read; for a whole file 0 and n_disks */
  size_t first, n_rows;
  uint32_t *number; /* [n_rows]: numbers of the disks in the file */
  double box_scale;
  double *x, *y, *theta, *turn, *vx, *vy, *omega, *radius, *mass, *inertia;
  int32_t *material, *group;
  bool *driven, *gone; /* [n_rows]; gone: removed, or waiting for rain */
  uint32_t *a, *b, *part;
  double *side;
  double *surface; /* [n_surfaces]: displacement of each wall's surface along the wall */
  size_t n_surfaces;
  int32_t *slide;
  double *record[SD_CONTACT_ALL]; /* Columns of slipdisk/contact.h, [n_contacts] each */
  /* Number of materials with laws in the file; 0: laws not known */
  size_t n_materials;
  sd_contact_law *laws; /* [n_materials * n_materials] */
  /* True if the contacts have rolling springs and, where laws are known, some law resists
   * rolling */
  bool rolls;
  int32_t *wall_material; /* [walls]: material of each wall of the file */
  /* Time step if the run used Gear; 0: another integrator, or not known */
  double dt;
  double *derivatives[SD_DERIVATIVES]; /* Derivatives of the disks, with Gear; NULL: none */

  /* Content of the text /parameters/deck_bodies; empty for files without it */
  result_names materials, groups, disk_names;
  size_t n_walls, wall_capacity;
  result_wall *walls;
  bool boxed, periodic[2];
  double lower[2], upper[2];
} deck_result;

/* Returns true if the file holds a state, or is a sealed file that is damaged. Gives no
 * messages. */
bool deck_result_there(const char *path);
/* Reads the rows that d->asked selects. NULL: reported at the node. The result is in the arena. */
deck_result *deck_result_read(deck *d, const deck_node *node, const char *path, bool contacts);
/* Returns the end of the message that a result is missing: the command that makes it, "" when no
 * deck of that name is beside it. */
const char *deck_result_maker(deck *d, const char *path);
/* Fills the table with all disks in play and all known columns that the group does not give
 * itself. */
void deck_result_rows(deck_group *g, deck_node *file, const char *path, deck_columns *table);
/* Returns the edges of the periodic box at the last frame of a result, a checkpoint or another
 * H5MD file; false: reported. Directions that are not periodic in the file have equal edges. */
bool deck_result_box(deck *d, const deck_node *file, double lower[2], double upper[2]);

/* Returns the descriptions of the model's walls at their present positions, in the arena. */
result_wall *deck_result_walls(deck *d);
/* Returns the text /parameters/deck_bodies of the model, with these walls; from malloc. */
char *deck_result_text(deck *d, const result_wall *walls);
/* Takes over the contacts of all files whose contacts are wanted, and moves walls to their
 * positions in the files. Call after all disks and walls are there. In deck_memory.c. */
void deck_read_memories(deck *d);
/* Returns contact k with body numbers of the file. */
sd_contact_memory deck_result_contact(const deck_result *result, size_t k);
/* Returns the angle (rad) that must be added to theta in the file to get theta in the new state
 * of the disk in this row. The new theta is the total angle minus its nearest multiple of 8 rad,
 * so the two differ by a multiple of 8 and by rounding. */
double deck_result_shift(const deck_result *result, size_t row);

#endif

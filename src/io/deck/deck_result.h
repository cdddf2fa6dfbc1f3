/* deck_result.h: results and checkpoints of a run as the beginning of another: bodies, contacts, the box. */
#ifndef SLIPDISK_IO_DECK_RESULT_H
#define SLIPDISK_IO_DECK_RESULT_H

#include "io/deck/deck_rows.h"

/* The usual dataset: it stands for the last state. */
#define RESULT_DISKS "/particles/disks"

/* A wall as its deck describes it, and how that run's packing had turned it about its pivot and stretched it
 * when the run began. */
typedef struct result_wall {
  const char *name; /* "": none */
  const char *text; /* kind, size and place */
  size_t segments;
  double angle, scale;
} result_wall;

typedef struct result_names {
  size_t n;
  const char **name;
} result_names;

/* The last state in a file. Columns of bodies go by body number: disks, then walls. Where rows were asked for (deck_rows_asked) they
 * are the disks of these slots, as they come, or the walls alone. */
typedef struct deck_result {
  const char *path;
  size_t n_disks, n_bodies, n_free;
  size_t n_contacts, all_contacts; /* that were read, that are in the file */
  size_t first_body;               /* whose numbers are in row 0 of columns of bodies */
  size_t first, n_rows;            /* slots of the disks; all: 0, n_disks */
  uint32_t *number;                /* [n_rows]: their numbers there */
  double box_scale;
  double *x, *y, *theta, *turn, *vx, *vy, *omega, *radius, *mass, *inertia;
  int32_t *material, *group;
  bool *driven, *gone; /* of the rows; gone: removed, or waiting for rain */
  uint32_t *a, *b, *part;
  double *side;
  double *surface; /* way of each wall's surface */
  size_t n_surfaces;
  int32_t *slide;
  double *record[SD_CONTACT_ALL];      /* columns of slipdisk/contact.h */
  size_t n_materials;                  /* of the laws; 0: not known */
  sd_contact_law *laws;                /* [n_materials * n_materials] */
  bool rolls;                          /* some of the laws resist rolling */
  int32_t *wall_material;              /* of each of the walls of the file */
  double dt;                           /* with Gear; 0: another integrator, or not known */
  double *derivatives[SD_DERIVATIVES]; /* of disks, with Gear; NULL: none */

  /* what the text of deck_bodies says; nothing in files without it */
  result_names materials, groups, disk_names;
  size_t n_walls, wall_capacity;
  result_wall *walls;
  bool boxed, periodic[2];
  double lower[2], upper[2];
} deck_result;

/* Does the file hold a state? No messages. */
bool deck_result_there(const char *path);
/* The rows that d->asked says. NULL: reported at the node. */
deck_result *deck_result_read(deck *d, const deck_node *node, const char *path, bool contacts);
/* Behind a message that there is no file: the command that makes the result, "" when no deck beside it has its name. */
const char *deck_result_maker(deck *d, const char *path);
/* All disks in play, with all columns that are known and that the group does not give itself. */
void deck_result_rows(deck_group *g, deck_node *file, const char *path, deck_columns *table);
/* Edges of the periodic box of the last frame: of a result, a checkpoint or another H5MD file; false:
 * reported. Directions that are not periodic there have equal edges. */
bool deck_result_box(deck *d, const deck_node *file, double lower[2], double upper[2]);

/* The walls of the model as they stand. */
result_wall *deck_result_walls(deck *d);
/* The text for deck_bodies of the model; with these walls. */
char *deck_result_text(deck *d, const result_wall *walls);
/* deck_memory.c: contacts of the files that were asked for them, and the places of the walls that they know.
 * Call when all disks and walls are there. */
void deck_read_memories(deck *d);
/* A contact, with bodies as the file has them. */
sd_contact_memory deck_result_contact(const deck_result *result, size_t k);
/* The angle in the state that a disk, in this row of the result, has here begins at another multiple of a turn, and may be rounded. */
double deck_result_shift(const deck_result *result, size_t row);

#endif

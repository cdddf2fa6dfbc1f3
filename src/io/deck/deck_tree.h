/* deck_tree.h: internals of the deck reader: memory, nodes and messages of a deck while it is read.
 *
 * A deck goes through five stages:
 *   deck_scan   text -> text that libconfig cannot misread (numbers, comments, repeated keys,
 *               includes)
 *   deck_parse  libconfig's tree -> our own tree of nodes, each with its file and line
 *   deck_override  path=value of -D, or of a point of a sweep, applied to the tree
 *   deck_read   typed getters; they follow the key tables of deck_keys and fill defaults into
 *               the tree
 *   deck_echo   the completed tree, printed as a deck again
 * deck_expression evaluates arithmetic in texts and holds the named constants. deck_bodies,
 * deck_rows, deck_motion and deck_phases turn groups of the tree into parts of a model.
 *
 * All data that live only while a deck is read are allocated in one arena. When memory runs out,
 * deck_alloc, deck_keep and deck_grow jump back to deck_open.c, which frees the arena and the
 * model; so no caller tests for NULL. */
#ifndef SLIPDISK_IO_DECK_TREE_H
#define SLIPDISK_IO_DECK_TREE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "model/rows.h"

/* Source location of a value or body. Values set by -D have the file name "-D path=value" and
 * line 0. In files without lines, line -1 - k is row k, and PLACE_DISK - k is disk k of a
 * result. */
#define PLACE_DISK (-0x40000000)
typedef struct deck_place {
  const char *file;
  int line;
} deck_place;

/* A setting from outside the deck: by -D, or by a point of a sweep, whose values have a location
 * in the deck. */
typedef struct deck_setting {
  const char *text; /* Assignment as text, "path=value" */
  deck_place place; /* Location of the value in the sweep; file NULL: set by -D */
} deck_setting;

typedef enum deck_type {
  DECK_GROUP,
  DECK_LIST, /* Also libconfig's arrays: a deck does not distinguish [ ] from ( ) */
  DECK_BOOL,
  DECK_INT,
  DECK_FLOAT,
  DECK_STRING
} deck_type;

struct deck_table;
struct deck_container_values;
struct guess;
struct deck_constants;
struct deck_sweep;

typedef struct deck_node {
  const char *name; /* Key; NULL for elements of a list and for the root */
  deck_type type;
  bool defaulted; /* True if a getter filled in the default; false if the user wrote the value */
  deck_place place;
  struct deck_node *parent;
  union {
    bool flag;
    int64_t integer;
    double number;
    const char *text;
  } value;
  size_t n, capacity; /* Children in use and allocated, for groups and lists */
  struct deck_node **child;
  const struct deck_table *table; /* Keys that a group may have; set by deck_enter */
  /* Numerical value of a text that is arithmetic, printed behind the text in the echo; else NULL */
  const char *remark;
} deck_node;

typedef struct deck_name {
  const char *name;
  uint32_t number;
} deck_name;

/* Map from names to numbers: the names in order of insertion, and a hash table of them, both in
 * the arena. */
typedef struct deck_index {
  size_t n, capacity, n_slots; /* n_slots: a power of two */
  deck_name *name;
  size_t *slot; /* Hash slots: 1 + index of the name in `name`; 0: empty */
} deck_index;

/* Text buffer that grows in the arena. */
typedef struct deck_buffer {
  char *bytes;
  size_t n, capacity;
} deck_buffer;

typedef struct deck_chunk deck_chunk;

/* Selection of the rows that are read from a file of disks. */
typedef struct deck_rows_asked {
  bool part;     /* Only n rows, from row `first` on */
  bool head;     /* Only the columns: no disks are made */
  bool contacts; /* Contacts and walls of the file instead of its disks */
  bool again;    /* The file was opened and checked before, so the check is skipped */
  size_t first, n;
} deck_rows_asked;

typedef struct deck {
  const char *path; /* Path of the deck, as the caller gave it */
  sd_messages *messages;
  /* Messages of the model's checks, before deck_tell adds their source locations */
  sd_messages *found;
  /* Number of errors found in this deck so far, counted beyond the ones shown */
  size_t reported;
  deck_chunk *memory;
  jmp_buf out_of_memory;
  bool lacks_told; /* True if deck_need has already reported why out_of_memory is entered */
  void *library;   /* libconfig's tree (config_t) while it exists, else NULL; see deck_node.c */
  deck_node *root;
  const char *text; /* Text of the deck as read, with included files put in place */
  sd_model *model;  /* Model under construction; NULL when only the tree is wanted */

  /* Source location of each disk of the model */
  deck_place *disk_place;
  size_t disk_capacity;
  deck_index disks, materials, groups, walls, clumps, motions, fields;
  /* Disk numbers sorted by group: group k is [group_start[k], group_start[k + 1]) */
  uint32_t *grouped;
  size_t *group_start, n_grouped;
  /* Tables of disk_files, one per entry, kept until deck_echo_files */
  struct deck_columns *file_tables;
  size_t n_file_tables;
  deck_rows_asked asked; /* Rows to read from the file that is being read */
  const char *box_path;  /* H5MD file from which the box was read; NULL: none */
  int64_t box_step;      /* Step at which that box was read; -1: the box does not change */
  bool disks_missing;    /* True if some disks could not be read */
  const comm *comm;      /* Ranks that read this deck together; NULL: a single process */
  bool wrong;            /* True after deck_meet if any rank has found a mistake */
  /* Receives the reason from deck_leave; NULL: all disks must be on every rank */
  const char **whole;
  /* Reason of deck_leave, during the second reading; NULL: no second reading, or no ranks */
  const char *why;
  /* [n_away_groups]: true for groups with disks of which other ranks have the rows */
  bool *away_group;
  size_t n_away_groups;
  /* Location of the first disk whose row only one rank has: its entry of packings, or row 0 or
   * disk 0 of its file */
  deck_place away_place;
  /* True if the deck has no mistakes except, possibly, in the positions of bodies */
  bool readable;
  struct deck_container_values *container;
  struct deck_constants *constants; /* Named constants; NULL until one is asked for */

  /* Entry of the list `motions` from which each motion of the model was made */
  size_t *motion_entry;
  size_t motion_capacity;
} deck;

/* --- deck_open.c ------------------------------------------------------------------------------ */

/* Scans and parses the text, applies the settings and calls use() with the tree; then frees
 * everything that use() did not take over. Returns the status of use(), or SD_ERROR_USER if
 * there is no tree. When use() fails or memory runs out in it, d->model is freed too. */
typedef sd_status deck_use(deck *d, void *user);
sd_status deck_open(const char *text, const char *path, size_t n_settings,
                    const deck_setting *settings, deck_use *use, void *user, sd_messages *messages);

/* --- deck_node.c: memory, nodes, messages ----------------------------------------------------- */

void *deck_alloc(deck *d, size_t n, size_t size); /* Returns n zeroed elements, from the arena */
/* Returns an array in the arena with the n elements of `old` and space for one more; *capacity
 * is updated. */
void *deck_extend(deck *d, void *old, size_t n, size_t *capacity, size_t size);
/* Returns an array in the arena for `capacity` elements: the first n copied from `old`, the
 * others zero. */
void *deck_more(deck *d, const void *old, size_t n, size_t capacity, size_t size);
void deck_put(deck *d, deck_buffer *b, const char *text, size_t n);
/* Copies n bytes and adds a final zero; in the arena */
char *deck_copy(deck *d, const char *text, size_t n);
char *deck_format(deck *d, const char *format, ...) SD_PRINTF(2, 3);
char *deck_words(deck *d, const char *format, va_list args);
/* Takes ownership of p, which malloc returned: it is freed with the arena */
void deck_own(deck *d, void *p);
/* Returns the first n bytes of a text in the form for messages: long texts are cut and end in
 * "...". */
const char *deck_quote(deck *d, const char *text, size_t n);
/* Allocate rows of the model, which are freed with the model and not with the arena: deck_keep
 * returns n zeroed elements, deck_grow resizes `old` to n elements and leaves new ones unset.
 * Small things of the model come from memory_new and its like. */
void *deck_keep(deck *d, size_t n, size_t size);
void *deck_grow(deck *d, void *old, size_t n, size_t size);
void deck_memory_free(deck *d);

deck_node *deck_node_new(deck *d, deck_node *parent, const char *name, deck_type type,
                         deck_place place);
/* Returns NULL if there is no such key */
deck_node *deck_child(const deck_node *group, const char *name);
void deck_remove(deck_node *parent, const deck_node *child);
const char *deck_node_path(deck *d, const deck_node *node);
/* Short form of the value, for messages */
const char *deck_node_value(deck *d, const deck_node *node);
/* Name of a body for messages, such as "disk 3" */
const char *deck_body_name(deck *d, uint32_t body);
/* Returns the shortest decimal form that reads back as the same double, always with a point or
 * an exponent. */
const char *deck_number_text(double x, char text[32]);

/* Reports one error at a node: "file:line: path = value: ...". */
void deck_fail(deck *d, const deck_node *node, const char *format, ...) SD_PRINTF(3, 4);
/* Reports one error about a key of a group, which may be missing: "file:line: path: ...". */
void deck_fail_child(deck *d, const deck_node *group, const char *key, const char *format, ...)
    SD_PRINTF(4, 5);
/* Checks that n things of `bytes` bytes each fit into memory. If they cannot, reports it at the
 * key and jumps to out_of_memory. Collective when ranks read the deck together; at most 2e6
 * things are allowed there, since every rank would have all of them. */
void deck_need(deck *d, const deck_node *group, const char *key, double n, size_t bytes,
               const char *what);
/* Returns a lower bound of the bytes that one disk needs; a deck that needs more than the memory
 * cannot run in this process. With several ranks only the model's row counts, since ranks share
 * the state. */
size_t deck_disk_bytes(bool free);
void deck_fail_place(deck *d, deck_place place, const char *format, ...) SD_PRINTF(3, 4);
/* Returns a source location as messages begin with it: "file:line", "file: row 3" or "file: disk
 * 3". */
const char *deck_place_text(deck *d, deck_place place);
/* Returns the source location of a disk, also of one whose row is on another rank. */
deck_place deck_disk_place(const deck *d, uint32_t disk);
/* Gives up this reading for the reason `why`; deck_load_for_ranks then reads the deck again with
 * all disks on each rank. Every rank must call it. */
_Noreturn void deck_leave(deck *d, const char *why);
/* Collective. If any rank has found a mistake, every rank sets d->wrong, clears d->comm and
 * reads on alone. Call it before the next collective function wherever one rank may have found a
 * mistake that the others did not. */
void deck_meet(deck *d);
/* Reports an error if the text of the node is not printable UTF-8. */
void deck_check_text(deck *d, const deck_node *node);
/* Returns true if so many errors were reported (LIMIT_DECK_ERRORS) that further ones are only
 * counted; then callers need not search for hints. */
bool deck_told(const deck *d);
/* Reports the number of errors that were counted and not shown. */
void deck_report_rest(deck *d);

/* --- deck_node.c: numbers by name ------------------------------------------------------------- */

/* Finds the number of a name; returns false if the name is unknown. */
bool deck_index_find(const deck_index *x, const char *name, uint32_t *number);
/* Adds a name with its number. Returns false if the name has one already, which is kept. The
 * name is not copied. */
bool deck_index_add(deck *d, deck_index *x, const char *name, uint32_t number);
/* Finds the number of the name that the node holds. If there is none, returns false and reports
 * "no `what` is called that", with the nearest name or else the remark. */
bool deck_index_look_up(deck *d, const deck_index *x, const char *what, const deck_node *node,
                        const char *remark, uint32_t *number);
/* Returns "; there are "a" and "b"" when there are few names, else "". */
const char *deck_index_list(deck *d, const deck_index *x);
/* Returns "; did you mean "..."?", or "" without a good guess. */
const char *deck_hint(deck *d, const struct guess *g);
/* Offers all names of the index to the search for the nearest name. */
void deck_index_guess(const deck *d, const deck_index *x, struct guess *near);

/* --- deck_scan.c ------------------------------------------------------------------------------ */

typedef struct deck_text {
  char *raw;   /* Text as read, with included files put in place; NULL unless files are included */
  char *clean; /* Clean text, which libconfig parses */
  size_t n_lines;
  deck_place *line; /* [n_lines]: source location of line k+1 of clean */
  bool broken;      /* True if the text must not be parsed */
} deck_text;

/* Scans the text and reports what libconfig would pass over or misread. override: the text is
 * the value of a -D setting, and all messages carry `place` unchanged. */
deck_text deck_scan(deck *d, const char *text, deck_place place, bool override);
/* Returns the content of a text file of at most `most` bytes, in the arena; NULL if it cannot be
 * read (reported at `place`, with `what` as the file's role). */
char *deck_read_file(deck *d, const char *path, uint64_t most, deck_place place, const char *what);
/* Returns a path of the deck relative to the folder of `file`; absolute paths stay as they are. */
char *deck_resolve(deck *d, const char *file, const char *path);

/* --- deck_node.c: parsing --------------------------------------------------------------------- */

/* Parses a scanned text with libconfig and returns it as nodes; NULL if it is not a deck
 * (reported). */
deck_node *deck_parse(deck *d, const deck_text *text);
void deck_parse_free(deck *d);

/* --- deck_locate.c ---------------------------------------------------------------------------- */

/* Passes on the messages of sd_model_finish, each error with its source location in the deck. */
void deck_tell(deck *d, const sd_messages *found);

/* --- deck_override.c -------------------------------------------------------------------------- */

void deck_override(deck *d, const deck_setting *setting);

/* Result of the comparison of two paths, however they are written: they set different keys; the
 * same key of some group; or alternatives ("amplitude", "acceleration"), of which setting the
 * second would remove the first. A path may be followed by =value. */
typedef enum deck_meeting { DECK_APART, DECK_SAME_KEY, DECK_ALTERNATIVES } deck_meeting;
deck_meeting deck_paths_meet(const deck *d, const char *p, const char *q);

/* --- deck_echo.c ------------------------------------------------------------------------------ */

/* Returns the completed tree as the text of a deck; from malloc. */
char *deck_echo(deck *d);
/* Returns a value as a deck writes it, on one line; in the arena. */
const char *deck_value_text(deck *d, const deck_node *node);

/* --- deck_sweep.c ----------------------------------------------------------------------------- */

/* Reads the group `sweep` and returns the number of its points; 0: no sweep, or mistakes
 * (reported). */
size_t deck_sweep_count(deck *d);
/* Reads the group `sweep`, puts its points with their source locations into *out, and warns
 * about settings of -D and tilts that look mistaken. Returns false after mistakes (reported). */
bool deck_sweep_read(deck *d, struct deck_sweep *out, sd_messages *messages);

/* --- deck.c ----------------------------------------------------------------------------------- */
/* Builds the finished model of a deck with these settings. point: the settings are a point of
 * the deck's sweep, whose group `sweep` is then not checked again. */
sd_status deck_load(const char *text, const char *path, size_t n_settings,
                    const deck_setting *settings, bool point, sd_model **out,
                    sd_messages *messages);

/* --- model parts ------------------------------------------------------------------------------ */

void deck_read_materials(deck *d);
void deck_check_laws(deck *d); /* call after motions are read */
void deck_read_disks(deck *d);
void deck_read_box(deck *d);
/* Reads the region and the box of `container`; call before disks */
void deck_read_container(deck *d);
/* Adds the walls and the floor of `container`; call after disks and walls are read */
void deck_container_bodies(deck *d);
void deck_read_packings(deck *d); /* Call after all other disks and walls are there */
/* Appends a disk with copies of its name and group, which may be NULL (disk->name and
 * disk->group are not read). */
void deck_push_disk(deck *d, const sd_disk *disk, const char *name, const char *group,
                    deck_place place);
/* Returns the number of the group with this name, which is added if it is new; -1 for NULL. */
int deck_group_number(deck *d, const char *name);
/* Notes that disks of the group are away (model/rows.h); group -1: does nothing. */
void deck_note_away(deck *d, int group);
void deck_read_bounds(deck *d); /* Call after motions are read */
void deck_echo_files(deck *d);  /* Turns short disk files into rows of the echoed deck */
void deck_read_walls(deck *d);
void deck_read_clumps(deck *d); /* Call after all disks are there */
void deck_read_forces(deck *d);
void deck_read_locks(deck *d);
/* Drops the velocity and the derivatives that a result file gives to coordinate c of a disk,
 * because that coordinate is locked or moved by a motion. */
void deck_forget_velocity(deck *d, uint32_t disk, int c);
void deck_read_motions(deck *d);
void deck_read_fields(deck *d); /* Call before phases are read */
void deck_read_phases(deck *d);
void deck_check_motions(deck *d); /* Call after phases are read */
void deck_read_measure(deck *d);
void deck_read_until(deck *d); /* Call after phases and measure are read */
void deck_check_overlaps(deck *d);

struct deck_group;
/* Returns the number of the material that the group names, or of the only material; -1: none, or
 * a mistake (reported). */
int deck_material(struct deck_group *g);

/* Bodies that a group of the deck selects with its keys disk, group, wall and clump: sorted
 * numbers, each once, in the arena; mistakes are reported. shared: the key group is given. */
typedef struct deck_bodies {
  size_t n, capacity;
  uint32_t *body;
  bool shared;
  int group;  /* Number of the group, if exactly one group and nothing else was named; else -1 */
  bool given; /* True if any of the keys is there */
} deck_bodies;

deck_bodies deck_select(struct deck_group *g, bool walls);
/* Finds the body with the name or number in the node: a disk, or a wall if `walls` is true.
 * Returns false after a mistake (reported). */
bool deck_find_body(deck *d, const deck_node *node, bool walls, uint32_t *body);
/* Returns a bit mask of the coordinates that the key names: bit k is coordinate k. */
unsigned deck_coordinates(struct deck_group *g, const char *key);

#endif

/* deck_tree.h: internals of the deck reader: memory, nodes and messages of a deck (input file)
 * while it is read.
 *
 * A deck goes through five stages:
 *   deck_scan   text -> text that libconfig cannot misread (numbers, comments, repeated keys,
 *               includes)
 *   deck_parse  libconfig's tree -> our own tree of nodes, each with its file and line
 *   deck_override  path=value of -D, or of a point of a sweep, applied to the tree
 *   deck_read   functions that read values of keys; they follow the key tables of deck_keys and
 *               fill defaults into the tree
 *   deck_echo   the tree with all defaults, printed as a full deck
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

#include "base/buckets.h"
#include "model/rows.h"

/* Source location of a value or body. A -D setting has the file name "-D path=value" and line 0. In
 * a file without lines, line -1 - k means row k, and line PLACE_DISK - k means disk k of a
 * result. */
#define PLACE_DISK (-0x40000000)
typedef struct deck_place {
  const char *file;
  int line;
} deck_place;

/* A setting path=value from outside the deck's own keys: by -D, or by a point of a sweep, whose
 * values have a location in the deck. */
typedef struct deck_setting {
  const char *text; /* Assignment as text, "path=value" */
  deck_place place; /* Location of the value in the sweep; file NULL: set by -D */
} deck_setting;

typedef enum deck_type {
  DECK_GROUP,
  DECK_LIST, /* A list ( ), or an array [ ] of libconfig: a deck does not distinguish them */
  DECK_BOOL,
  DECK_INT,
  DECK_FLOAT,
  DECK_STRING
} deck_type;

struct deck_table;
struct container;
struct guess;
struct deck_constants;
struct deck_sweep;

typedef struct deck_node {
  const char *name; /* Key of the node; NULL for elements of a list and for the root */
  deck_type type;
  bool defaulted; /* True if a getter filled in the default; false if the user wrote the value */
  bool added;     /* True if a setting (deck_override) has added this key, which the deck lacks */
  deck_place place;
  struct deck_node *parent;
  union {
    bool flag;
    int64_t integer;
    double number;
    const char *text;
  } value;
  /* For groups and lists: number of children, and number for which memory is allocated */
  size_t n, capacity;
  struct deck_node **child;
  /* Table of the keys that a group may have; NULL before deck_enter */
  const struct deck_table *table;
  /* For a text that is arithmetic: its value, which deck_echo prints after the text; else NULL */
  const char *remark;
} deck_node;

typedef struct deck_name {
  const char *name;
  uint32_t number;
} deck_name;

/* Map from names to numbers: the names in order of insertion, and a hash table of them, both in
 * the arena. */
typedef struct deck_index {
  size_t n, capacity, n_slots; /* n_slots: size of the hash table, a power of two */
  deck_name *name;
  size_t *slot; /* Hash slots: 1 + index of the name in `name`; 0: empty */
} deck_index;

/* Text buffer that grows in the arena. */
typedef struct deck_buffer {
  char *bytes;
  size_t n, capacity;
} deck_buffer;

typedef struct deck_chunk deck_chunk;

/* Selection of what is read from a file of disks; with all members 0, everything. */
typedef struct deck_rows_asked {
  bool part;     /* True: read only n rows, beginning with row `first` */
  bool head;     /* True: read only the columns, and make no disks */
  bool contacts; /* True: read contacts and walls of the file instead of its disks */
  bool again;    /* True: skip the checks of the file, which was opened and checked before */
  size_t first, n;
} deck_rows_asked;

typedef struct deck {
  const char *path; /* Path of the deck, as the caller gave it */
  sd_messages *messages;
  /* Messages of the model's checks, before deck_report_model_messages adds their source
   * locations */
  sd_messages *found;
  /* Number of errors found in this deck so far, including those that are not shown */
  size_t reported;
  deck_chunk *memory;
  jmp_buf out_of_memory;
  bool lacks_told; /* True if deck_need has already reported that memory does not suffice */
  void *library;   /* libconfig's tree (config_t) while it exists, else NULL; see deck_node.c */
  deck_node *root;
  const char *text; /* Text of the deck as read, with included files put in place */
  bool endless;     /* True: a deck without steps, time and phases has no end, for stepping */
  sd_model *model;  /* Model under construction; NULL when only the tree is wanted */

  /* Source location of each disk in model->disks */
  deck_place *disk_place;
  size_t disk_capacity;
  deck_index disks, materials, groups, walls, clumps, motions, fields;
  buckets grouped; /* disks of each group */
  size_t n_grouped;
  /* [n_file_tables]: table of each entry of disk_files, kept until deck_echo_files */
  struct deck_columns *file_tables;
  size_t n_file_tables;
  deck_rows_asked asked; /* Selection of what to read from the current file of disks */
  const char *box_path;  /* H5MD file from which the box was read; NULL: none */
  int64_t box_step;      /* Step at which that box was read; -1: the box does not change */
  bool disks_missing;    /* True if some disks could not be read */
  /* Communicator of the ranks that read this deck together; NULL: a single process */
  const comm *comm;
  bool wrong; /* True after deck_agree_on_errors if any rank has found a mistake */
  /* Receives from deck_restart_with_all_disks why every rank must have all disks; NULL: every
   * rank has them in any case */
  const char **whole;
  /* During the second reading, which deck_restart_with_all_disks causes: its reason; else NULL */
  const char *why;
  /* [n_away_groups]: true for groups with disks that are stored on other ranks */
  bool *away_group;
  size_t n_away_groups;
  /* Location of the first disk that only one rank stores: its entry of packings, or row 0 or disk 0
   * of its file */
  deck_place away_place;
  /* True if the deck has no mistakes except, possibly, in the positions of bodies */
  bool readable;
  struct container *container;
  int container_material;
  struct deck_constants *constants; /* Named constants of the deck; NULL before the first use */

  /* [n_motions]: index in the deck's list `motions` of the entry from which each motion of the
   * model was made */
  size_t *motion_entry;
  size_t motion_capacity;
} deck;

/* --- deck_open.c ------------------------------------------------------------------------------ */

/* deck_open scans and parses the text, applies the settings and calls use() with the deck. It then
 * frees all that use() has not taken out of the deck. Returns the status of use(), or SD_ERROR_USER
 * if the text cannot be parsed. When use() fails, or memory runs out in it, d->model is freed
 * too. */
typedef sd_status deck_use(deck *d, void *user);
sd_status deck_open(const char *text, const char *path, size_t n_settings,
                    const deck_setting *settings, deck_use *use, void *user, sd_messages *messages);

/* --- deck_node.c: memory, nodes, messages ----------------------------------------------------- */

/* Returns n elements of `size` bytes, all 0, in the arena */
void *deck_alloc(deck *d, size_t n, size_t size);
/* Returns an array in the arena with the n elements of `old` and space for at least one more; if it
 * is a new array, *capacity is updated. */
void *deck_extend(deck *d, void *old, size_t n, size_t *capacity, size_t size);
/* Returns an array in the arena for `capacity` elements: the first n copied from `old`, the
 * others zero. */
void *deck_array_grow(deck *d, const void *old, size_t n, size_t capacity, size_t size);
void deck_put(deck *d, deck_buffer *b, const char *text, size_t n);
/* Returns a copy of n bytes, with a final zero byte, in the arena */
char *deck_copy(deck *d, const char *text, size_t n);
char *deck_format(deck *d, const char *format, ...) SD_PRINTF(2, 3);
char *deck_format_v(deck *d, const char *format, va_list args);
/* Takes ownership of p, which malloc returned: it is freed with the arena */
void deck_own(deck *d, void *p);
/* Returns the first n bytes of a text as messages show them: a long text is cut and ends in
 * "...". */
const char *deck_quote(deck *d, const char *text, size_t n);
/* These two functions allocate arrays of the model, which are freed with the model and not with the
 * arena: deck_keep returns n elements that are 0, deck_grow resizes `old` to n elements and leaves
 * new ones unset. Small objects of the model are allocated with memory_new instead. */
void *deck_keep(deck *d, size_t n, size_t size);
void *deck_grow(deck *d, void *old, size_t n, size_t size);
void deck_memory_free(deck *d);

deck_node *deck_node_new(deck *d, deck_node *parent, const char *name, deck_type type,
                         deck_place place);
/* Returns the child of a group that has this key; NULL: none */
deck_node *deck_child(const deck_node *group, const char *name);
void deck_remove(deck_node *parent, const deck_node *child);
const char *deck_node_path(deck *d, const deck_node *node);
/* Returns the name of a body for messages, such as "disk 3" */
const char *deck_body_name(deck *d, uint32_t body);
/* Returns the shortest decimal form that reads back as the same double, always with a point or
 * an exponent. */
const char *deck_number_text(double x, char text[32]);

/* Reports one error at a node: "file:line: path = value: ...". */
void deck_fail(deck *d, const deck_node *node, const char *format, ...) SD_PRINTF(3, 4);
/* Reports one error about a key of a group; the key may be missing: "file:line: path: ...". */
void deck_fail_child(deck *d, const deck_node *group, const char *key, const char *format, ...)
    SD_PRINTF(4, 5);
/* Checks that n things of `bytes` bytes each fit into memory (`what`: their name). If not, reports
 * it at the key and jumps to out_of_memory. Collective when ranks read the deck together; n must
 * then be at most 2e6, since every rank would have all things. */
void deck_need(deck *d, const deck_node *group, const char *key, double n, size_t bytes,
               const char *what);
/* Returns a lower bound on the memory that one disk needs, in bytes. On several ranks it is only
 * the size of the disk in the model, since the ranks divide the state among them. free: the disk is
 * moved by forces. */
size_t deck_disk_bytes(bool free);
void deck_fail_place(deck *d, deck_place place, const char *format, ...) SD_PRINTF(3, 4);
/* Reports one error at a place: "file:line: path = value: ..."; path and value may be NULL. */
void deck_report(deck *d, deck_place place, const char *path, const char *value, const char *format,
                 va_list args);
/* Returns a source location in the form with which messages begin: "file:line", "file: row 3" or
 * "file: disk 3". */
const char *deck_place_text(deck *d, deck_place place);
/* Returns the source location of a disk, even if another rank stores the disk. */
deck_place deck_disk_place(const deck *d, uint32_t disk);
/* Gives up this reading, which distributes disks over the ranks, for the reason `why`;
 * deck_load_for_ranks then reads the deck again with all disks on each rank. Every rank must call
 * it. */
_Noreturn void deck_restart_with_all_disks(deck *d, const char *why);
/* Collective. If any rank has found an error, every rank sets d->wrong, clears d->comm and reads on
 * without the others. It must be called before the next collective function wherever one rank may
 * have found an error that the others did not. */
void deck_agree_on_errors(deck *d);
/* Reports an error if the text of the node is not printable UTF-8. */
void deck_check_text(deck *d, const deck_node *node);
/* Returns true if so many errors were reported (LIMIT_DECK_ERRORS) that further ones are only
 * counted; callers then need not search for hints. */
bool deck_error_limit_reached(const deck *d);
/* Reports the number of errors that were counted and not shown. */
void deck_report_rest(deck *d);

/* --- deck_node.c: numbers by name ------------------------------------------------------------- */

/* Finds the number that was added with a name; returns false if the name is unknown. */
bool deck_index_find(const deck_index *x, const char *name, uint32_t *number);
/* Adds a name with a number. Returns false, without a change, if the name has a number already. The
 * name is not copied. */
bool deck_index_add(deck *d, deck_index *x, const char *name, uint32_t number);
/* Returns what a message adds about a name that is not in the index, nor in another one that would
 * do (`more`; NULL: none): what else has this name, or the most similar name, or the names of the
 * first index, if they are few, and `remark`. */
const char *deck_index_instead(deck *d, const deck_index *x, const deck_index *more,
                               const char *name, const char *remark);
/* Finds the number of the name that the node holds. If it is unknown, returns false and reports "no
 * `what` is called that", with deck_index_instead. */
bool deck_index_look_up(deck *d, const deck_index *x, const char *what, const deck_node *node,
                        const char *remark, uint32_t *number);
/* Returns "; there are "a" and "b"" with all names of the index if they are few, else "". */
const char *deck_index_list(deck *d, const deck_index *x);
/* Returns "; did you mean "..."?" with the best guess; "" without a good one. */
const char *deck_hint(deck *d, const struct guess *g);
/* Adds all names of the index to the search for the name that is most similar to a misspelt one. */
void deck_index_guess(const deck *d, const deck_index *x, struct guess *near);

/* --- deck_scan.c ------------------------------------------------------------------------------ */

typedef struct deck_text {
  char *raw;   /* Text as read, with included files put in place; NULL unless files are included */
  char *clean; /* Text made safe for libconfig, which parses it */
  size_t n_lines;
  deck_place *line; /* [n_lines]: source location of each line of `clean` */
  bool broken;      /* True if the text has errors that make parsing useless */
} deck_text;

/* Scans the text of a deck, reports what libconfig would pass over or misread, and returns a text
 * that is safe to parse. override: the text is the value of a -D setting, and all messages have the
 * location `place`. */
deck_text deck_scan(deck *d, const char *text, deck_place place, bool override);
/* Returns the content of a text file of at most `most` bytes, in the arena. Returns NULL if the
 * file cannot be read; the error is reported at `place`, with `what` as the file's role. */
char *deck_read_file(deck *d, const char *path, uint64_t most, deck_place place, const char *what);
/* Returns a path that is written in the file `file`, relative to the folder of that file; an
 * absolute path is returned unchanged, a path that may not be read (deck_is_outside) as "". */
char *deck_resolve(deck *d, const char *file, const char *path);

/* --- deck_confined.c -------------------------------------------------------------------------- */

/* Returns true if a deck may not read the file that `file` names by `path`: it lies, with all links
 * followed, outside of the folder in SLIPDISK_CONFINED. Without this variable all may be read. */
bool deck_is_outside(deck *d, const char *file, const char *path);
/* Reports every key of the deck that names a file outside. Returns false if there is one. */
bool deck_check_files(deck *d, const deck_node *node);
/* End of the message about a file outside. */
extern const char deck_outside[];

/* --- deck_node.c: parsing --------------------------------------------------------------------- */

/* Parses a scanned text with libconfig and returns the root of the tree of nodes; NULL after an
 * error, which is reported. */
deck_node *deck_parse(deck *d, const deck_text *text);
void deck_parse_free(deck *d);

/* --- deck_locate.c ---------------------------------------------------------------------------- */

/* Passes on the messages of sd_model_finish, each error with its source location in the deck. */
void deck_report_model_messages(deck *d, const sd_messages *found);

/* --- deck_override.c -------------------------------------------------------------------------- */

void deck_override(deck *d, const deck_setting *setting);

/* Result of comparing two paths, however they are written. APART: they set different keys.
 * SAME_KEY: they set the same key of some group. ALTERNATIVES: they set two keys of which only one
 * may be given (amplitude, acceleration), so that the second removes the first. A path may be
 * followed by =value. */
typedef enum deck_paths_relation {
  DECK_DIFFERENT_KEYS,
  DECK_SAME_KEY,
  DECK_ALTERNATIVES
} deck_paths_relation;
deck_paths_relation deck_paths_compare(const deck *d, const char *p, const char *q);

/* --- deck_echo.c ------------------------------------------------------------------------------ */

/* Returns the full deck: the tree, with all defaults, as the text of a deck; the caller frees
 * it. */
char *deck_echo(deck *d);
/* Returns a value on one line, in the syntax of a deck; in the arena. */
const char *deck_value_text(deck *d, const deck_node *node);

/* --- deck_sweep.c ----------------------------------------------------------------------------- */

/* Reads the group `sweep` and returns the number of its points (sets of parameter values); 0: no
 * sweep, or errors (reported). */
size_t deck_sweep_count(deck *d);
/* Reads the group `sweep` and stores its points, with their source locations, in *out. Warns about
 * -D settings and tilts that look mistaken. Returns false after errors, which are reported. */
bool deck_sweep_read(deck *d, struct deck_sweep *out, sd_messages *messages);

/* --- deck.c ----------------------------------------------------------------------------------- */
/* Builds the finished model of a deck with these settings. point: the settings are those of one
 * point of the deck's sweep, so the group `sweep` is not checked again. */
sd_status deck_load(const char *text, const char *path, size_t n_settings,
                    const deck_setting *settings, bool point, sd_model **out,
                    sd_messages *messages);

/* --- model parts ------------------------------------------------------------------------------ */

void deck_read_materials(deck *d);
void deck_check_laws(deck *d); /* Checks the contact laws; call after motions are read */
void deck_read_disks(deck *d);
void deck_read_box(deck *d);
/* Reads the region and the box of `container`; call before disks */
void deck_read_container(deck *d);
/* Adds the walls and the floor of `container`; call after disks and walls are read */
void deck_container_bodies(deck *d);
/* Makes the packings; call after all other disks and walls are there */
void deck_read_packings(deck *d);
/* Appends a disk with a copy of its name, which may be NULL (disk->name is not read). */
void deck_push_disk(deck *d, const sd_disk *disk, const char *name, deck_place place);
/* Returns the number of the group with this name, which is added if it is new; -1 for NULL. */
int deck_group_number(deck *d, const char *name);
/* Notes that disks of this group are stored on other ranks only (`away` in model/rows.h). Does
 * nothing for group -1. */
void deck_note_away(deck *d, int group);
void deck_read_bounds(deck *d); /* Reads the group `bounds`; call after motions are read */
void deck_echo_files(deck *d);  /* Turns short disk files into rows in the full deck */
void deck_read_walls(deck *d);
void deck_read_clumps(deck *d); /* Reads the list `clumps`; call after all disks are there */
void deck_read_forces(deck *d);
void deck_read_locks(deck *d);
/* Drops the velocity and the derivatives that a result file gives to coordinate c of a disk,
 * because that coordinate is locked or moved by a motion. */
void deck_forget_velocity(deck *d, uint32_t disk, int c);
void deck_read_motions(deck *d);
void deck_read_fields(deck *d); /* Reads the body forces in `fields`; call before phases are read */
/* Reads `hold` and `release` of the phases; call before driven disks are found */
void deck_read_holds(deck *d);
void deck_read_phases(deck *d);
/* Reports motions that exclude each other in a phase; call after phases are read */
void deck_check_motions(deck *d);
void deck_read_measure(deck *d);
/* Reads the group measure.averages; NULL: the deck has none. In deck_averages.c. */
void deck_read_averages(deck *d, const deck_node *group);
void deck_read_until(deck *d); /* Reads the group `until`; call after phases and measure are read */
void deck_check_overlaps(deck *d);

struct deck_group;
/* Returns the number of the material that the group names; if it names none, of the only material
 * of the deck. -1: no such material, or an error (reported). */
int deck_material(struct deck_group *g);

/* Bodies that a group of the deck selects with its keys disk, group, wall and clump: sorted body
 * numbers, each once, in the arena. Errors are reported. shared: the key `group` is given. */
typedef struct deck_bodies {
  size_t n, capacity;
  uint32_t *body;
  bool shared;
  /* Number of the group of disks, if exactly one group and no other body was named; else -1 */
  int group;
  bool given; /* True if any of the keys disk, group, wall and clump is given */
} deck_bodies;

deck_bodies deck_select(struct deck_group *g, bool walls);
/* Returns the disks that a key names, in its order: disks by name or number, groups by name. Errors
 * are reported. */
deck_bodies deck_disks_named(struct deck_group *g, const char *key);
/* Finds the body with the name or number in the node: a disk, or a wall if `walls` is true.
 * Returns false after a mistake (reported). */
bool deck_find_body(deck *d, const deck_node *node, bool walls, uint32_t *body);
/* Returns the coordinates that the key names as a bit mask: bits 0 to 3 are x, y, theta,
 * surface. */
unsigned deck_coordinates(struct deck_group *g, const char *key);

#endif

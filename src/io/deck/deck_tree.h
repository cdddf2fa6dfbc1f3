/* deck_tree.h: the inside of the deck reader: memory, nodes and messages of a deck that is being read.
 *
 * A deck goes through five stages:
 *   deck_scan   text -> text that libconfig cannot misread (numbers, comments, repeated keys, includes)
 *   deck_parse  libconfig's tree -> our own tree of nodes, each knowing its file and line
 *   deck_override  path=value of -D, or of a point of a sweep, applied to the tree
 *   deck_read   typed getters; they follow the key tables of deck_keys and fill defaults into the tree
 *   deck_echo   the completed tree, printed as a deck again
 * deck_expression has the arithmetic in texts, and the named constants.
 * deck_bodies, deck_rows, deck_motion and deck_phases turn groups of the tree into parts of a model.
 *
 * Everything that lives only while a deck is read stands in one arena. When memory runs out,
 * deck_alloc, deck_keep and deck_grow jump back to deck_open.c, which frees the arena and the model;
 * so no caller tests for NULL.
 */
#ifndef SLIPDISK_IO_DECK_TREE_H
#define SLIPDISK_IO_DECK_TREE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "model/rows.h"

/* Where something stands. What -D has set has the file "-D path=value" and line 0. In a file that has no lines -1 - k is its row k,
 * PLACE_DISK - k the disk k of a result. */
#define PLACE_DISK (-0x40000000)
typedef struct deck_place {
  const char *file;
  int line;
} deck_place;

/* A key that is set from outside: by -D, or by a point of a sweep, whose values have a place in the deck. */
typedef struct deck_setting {
  const char *text; /* "path=value" */
  deck_place place; /* file NULL: -D */
} deck_setting;

typedef enum deck_type {
  DECK_GROUP,
  DECK_LIST, /* libconfig's arrays too: decks make no difference between [ ] and ( ) */
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
  const char *name; /* NULL in a list and at the root */
  deck_type type;
  bool defaulted; /* put in by a getter, not written by the user */
  deck_place place;
  struct deck_node *parent;
  union {
    bool flag;
    int64_t integer;
    double number;
    const char *text;
  } value;
  size_t n, capacity; /* of a group or a list */
  struct deck_node **child;
  const struct deck_table *table; /* group: the keys it may have; set by deck_enter */
  const char *remark; /* text that is arithmetic: its value, printed behind it in the echo */
} deck_node;

typedef struct deck_name {
  const char *name;
  uint32_t number;
} deck_name;

/* Numbers by name: the names in order, and a hash table of them, in the arena. */
typedef struct deck_index {
  size_t n, capacity, n_slots; /* n_slots: a power of two */
  deck_name *name;
  size_t *slot; /* 1 + place of the name; 0: empty */
} deck_index;

/* A text that grows in the arena. */
typedef struct deck_buffer {
  char *bytes;
  size_t n, capacity;
} deck_buffer;

typedef struct deck_chunk deck_chunk;

/* Rows of a file of disks. */
typedef struct deck_rows_asked {
  bool part;     /* only n from `first` on */
  bool head;     /* its columns alone: no disks are made */
  bool contacts; /* of its contacts, with the walls, in place of disks */
  bool again;    /* the file was opened, and checked, before */
  size_t first, n;
} deck_rows_asked;

typedef struct deck {
  const char *path; /* of the deck, as given */
  sd_messages *messages;
  sd_messages *found; /* by the checks of the model, before they have a place */
  size_t reported;    /* errors of this deck so far */
  deck_chunk *memory;
  jmp_buf out_of_memory;
  bool lacks_told; /* the message for out_of_memory is there */
  void *library;   /* libconfig's tree while it is alive; see deck_parse.c */
  deck_node *root;
  const char *text; /* as read, included files put in place */
  sd_model *model;  /* NULL when only the tree is wanted */

  /* one entry per disk of the model */
  deck_place *disk_place;
  size_t disk_capacity;
  deck_index disks, materials, groups, walls, clumps, motions, fields;
  uint32_t *grouped; /* disks by group; those of group k are [group_start[k], group_start[k + 1]) */
  size_t *group_start, n_grouped;
  struct deck_columns *file_tables; /* one per entry of disk_files, until it is echoed */
  size_t n_file_tables;
  deck_rows_asked asked; /* of the file that is being read */
  const char *box_path;  /* the H5MD file whose box was read; NULL: none */
  int64_t box_step;      /* of which step; -1: it does not change */
  bool disks_missing;    /* some could not be read */
  const comm *comm;      /* of the ranks that read this deck together; NULL: one alone */
  bool wrong;            /* by what another rank has found */
  const char **whole;    /* deck_leave says here why no disks may be away; NULL: none may be, */
  const char *why;       /* and this is the reason, where some might have been; else NULL */
  bool *away_group;      /* of each group: disks of it are away */
  size_t n_away_groups;
  deck_place away_place; /* of disks that are away: of a file its first row, or disk */
  bool readable;         /* no mistake but where bodies stand */
  struct deck_container_values *container;
  struct deck_constants *constants; /* NULL until one is asked for */

  /* which entry of `motions` a motion of the model came from */
  size_t *motion_entry;
  size_t motion_capacity;
} deck;

/* --- deck_open.c ------------------------------------------------------------------------------ */

/* Scans and parses the text, applies the settings, and hands the tree to use; frees all but what use has kept.
 * When use fails, or memory runs out in it, d->model is freed too. */
typedef sd_status deck_use(deck *d, void *user);
sd_status deck_open(const char *text, const char *path, size_t n_settings,
                    const deck_setting *settings, deck_use *use, void *user, sd_messages *messages);

/* --- deck_node.c: memory, nodes, messages ----------------------------------------------------------- */

void *deck_alloc(deck *d, size_t n, size_t size); /* zeroed, from the arena */
/* An array in the arena that holds n, with space for one more. */
void *deck_extend(deck *d, void *old, size_t n, size_t *capacity, size_t size);
/* The same for so many. */
void *deck_more(deck *d, const void *old, size_t n, size_t capacity, size_t size);
void deck_put(deck *d, deck_buffer *b, const char *text, size_t n);
char *deck_copy(deck *d, const char *text, size_t n); /* n bytes and a final zero, from the arena */
char *deck_format(deck *d, const char *format, ...) SD_PRINTF(2, 3);
char *deck_words(deck *d, const char *format, va_list args);
void deck_own(deck *d, void *p); /* from malloc: freed with the arena */
/* The first n bytes of a text as messages show it: cut with "..." where it is long. */
const char *deck_quote(deck *d, const char *text, size_t n);
/* They give the model rows, zeroed ones, or room for n in place of `old`. What is small there comes
 * from memory_new and its like. */
void *deck_keep(deck *d, size_t n, size_t size);
void *deck_grow(deck *d, void *old, size_t n, size_t size);
void deck_memory_free(deck *d);

deck_node *deck_node_new(deck *d, deck_node *parent, const char *name, deck_type type,
                         deck_place place);
deck_node *deck_child(const deck_node *group, const char *name); /* NULL: not there */
void deck_remove(deck_node *parent, const deck_node *child);
const char *deck_node_path(deck *d, const deck_node *node);
const char *deck_node_value(deck *d, const deck_node *node); /* short form for messages */
const char *deck_body_name(deck *d, uint32_t body);          /* likewise: "disk 3" */
/* The shortest decimal form that reads back as the same double, always with a point or an exponent. */
const char *deck_number_text(double x, char text[32]);

/* One error: "file:line: path = value: ...". */
void deck_fail(deck *d, const deck_node *node, const char *format, ...) SD_PRINTF(3, 4);
/* One error about a key of a group, there or missing: "file:line: path: ...". */
void deck_fail_child(deck *d, const deck_node *group, const char *key, const char *format, ...)
    SD_PRINTF(4, 5);
/* Before n things are made that take so many bytes each: if they cannot fit it tells so at the
 * key, and goes to out_of_memory. */
void deck_need(deck *d, const deck_node *group, const char *key, double n, size_t bytes,
               const char *what);
/* Bytes of a disk of the deck, at least: beyond these there is no run in this process. Ranks
 * share the state. */
size_t deck_disk_bytes(bool free);
void deck_fail_place(deck *d, deck_place place, const char *format, ...) SD_PRINTF(3, 4);
/* "file:line", "file: row 3", "file: disk 3", as messages begin. */
const char *deck_place_text(deck *d, deck_place place);
/* The place of a disk, which may be away. */
deck_place deck_disk_place(const deck *d, uint32_t disk);
/* Leaves this deck, which is then read with all disks on each rank: why. Every rank comes here. */
_Noreturn void deck_leave(deck *d, const char *why);
/* Collective: once any rank has found a mistake all read on alone. Call where one rank may have
 * found what the others did not, before the next collective function. */
void deck_meet(deck *d);
/* Reports a text that is no printable UTF-8. */
void deck_check_text(deck *d, const deck_node *node);
/* So many errors were told that the next ones are only counted: no need to look for words. */
bool deck_told(const deck *d);
/* How many errors were counted and not shown. */
void deck_report_rest(deck *d);

/* --- deck_node.c: numbers by name ------------------------------------------------------------- */

/* The number that the name has; false: none. */
bool deck_index_find(const deck_index *x, const char *name, uint32_t *number);
/* Gives it a number; false: it has one, which stays. The name is not copied. */
bool deck_index_add(deck *d, deck_index *x, const char *name, uint32_t number);
/* The number of the name that the node holds; false: reported as "no `what` is called that", with the nearest name or
 * else the remark. */
bool deck_index_look_up(deck *d, const deck_index *x, const char *what, const deck_node *node,
                        const char *remark, uint32_t *number);
/* "; there are "a" and "b"", when there are few names. */
const char *deck_index_list(deck *d, const deck_index *x);
/* "; did you mean "..."?", or "". */
const char *deck_hint(deck *d, const struct guess *g);
/* The nearest of its names. */
void deck_index_guess(const deck *d, const deck_index *x, struct guess *near);

/* --- deck_scan.c -------------------------------------------------------------------------------------- */

typedef struct deck_text {
  char *raw;   /* as read, included files put in place; NULL unless there are any */
  char *clean; /* for libconfig */
  size_t n_lines;
  deck_place *line; /* [n_lines]: where line k+1 of clean comes from */
  bool broken;      /* not worth parsing */
} deck_text;

/* Goes through the text and reports what libconfig would pass over or misread. override: text is that of
 * a -D value, and messages carry place as it is. */
deck_text deck_scan(deck *d, const char *text, deck_place place, bool override);
/* The whole of a text file of at most so many bytes; NULL (and a message naming place) when it cannot be read. */
char *deck_read_file(deck *d, const char *path, uint64_t most, deck_place place, const char *what);
/* A path that the deck names, relative to the folder of file. */
char *deck_resolve(deck *d, const char *file, const char *path);

/* --- deck_parse.c ------------------------------------------------------------------------------------- */

/* libconfig's view of a scanned text, as nodes; NULL when it is not a deck (reported). */
deck_node *deck_parse(deck *d, const deck_text *text);
void deck_parse_free(deck *d);

/* --- deck_locate.c ------------------------------------------------------------------------------------ */

/* Tells what sd_model_finish has found, with the place in the deck where it stands. */
void deck_tell(deck *d, const sd_messages *found);

/* --- deck_override.c ---------------------------------------------------------------------------------- */

void deck_override(deck *d, const deck_setting *setting);

/* Do two paths set the same key of some group, however they are written, or alternatives of which the second would
 * take the first away ("amplitude", "acceleration")? A path may be followed by =value. */
typedef enum deck_meeting { DECK_APART, DECK_SAME_KEY, DECK_ALTERNATIVES } deck_meeting;
deck_meeting deck_paths_meet(const deck *d, const char *p, const char *q);

/* --- deck_echo.c -------------------------------------------------------------------------------------- */

/* The completed tree as a deck; from malloc. */
char *deck_echo(deck *d);
/* A value as a deck has it, on one line; in the arena. */
const char *deck_value_text(deck *d, const deck_node *node);

/* --- deck_sweep.c ------------------------------------------------------------------------------------- */

/* Reads the group `sweep`, and counts its points; 0: it has none, or mistakes (reported). */
size_t deck_sweep_count(deck *d);
/* The same, and warnings of what it sets; the points and where they stand are put into *out. False:
 * mistakes (reported). */
bool deck_sweep_read(deck *d, struct deck_sweep *out, sd_messages *messages);

/* --- deck.c ----------------------------------------------------------------------------------- */
/* The model of a deck with these settings. point: it is a point of the deck's sweep, which is known to be right. */
sd_status deck_load(const char *text, const char *path, size_t n_settings,
                    const deck_setting *settings, bool point, sd_model **out,
                    sd_messages *messages);

/* --- model parts --------------------------------------------------------------------------------------- */

void deck_read_materials(deck *d);
void deck_check_laws(deck *d); /* call when motions are read */
void deck_read_disks(deck *d);
void deck_read_box(deck *d);
void deck_read_container(deck *d);   /* its region and box; call before disks */
void deck_container_bodies(deck *d); /* its walls and floor; call when disks and walls are read */
void deck_read_packings(deck *d);    /* call when all other disks and walls are there */
/* Appends a disk with copies of its name and group, which may be NULL (disk->name and disk->group are not read). */
void deck_push_disk(deck *d, const sd_disk *disk, const char *name, const char *group,
                    deck_place place);
/* Number of a group of this name, which is there then; -1: NULL. */
int deck_group_number(deck *d, const char *name);
/* Notes that disks of the group are away (model/rows.h); -1: nothing. */
void deck_note_away(deck *d, int group);
void deck_read_bounds(deck *d); /* call when motions are read */
void deck_echo_files(deck *d);  /* short disk files turn into rows of the echoed deck */
void deck_read_walls(deck *d);
void deck_read_clumps(deck *d); /* call when all disks are there */
void deck_read_forces(deck *d);
void deck_read_locks(deck *d);
/* Coordinate c of a disk is locked or moved by a motion: drops the velocity and the derivatives
 * that a result gives it there. */
void deck_forget_velocity(deck *d, uint32_t disk, int c);
void deck_read_motions(deck *d);
void deck_read_fields(deck *d); /* deck_fields.c; call before phases are read */
void deck_read_phases(deck *d);
void deck_check_motions(deck *d); /* call when phases are read */
void deck_read_measure(deck *d);
void deck_read_until(deck *d); /* call when phases and measure are read */
void deck_check_overlaps(deck *d);

struct deck_group;
/* Number of the material that the group names, or of the only one; -1: none, or reported. */
int deck_material(struct deck_group *g);

/* Body numbers named by the keys disk, group and wall of a group of the deck; reports what it does not find.
 * shared: a group was named. The list stands in the arena. */
typedef struct deck_bodies {
  size_t n, capacity;
  uint32_t *body;
  bool shared;
  int group;  /* the group, when exactly one was named and nothing else; else -1 */
  bool given; /* any of the keys is there */
} deck_bodies;

deck_bodies deck_select(struct deck_group *g, bool walls);
/* The body that a name or number stands for: a disk, or a wall where walls are allowed. False: reported. */
bool deck_find_body(deck *d, const deck_node *node, bool walls, uint32_t *body);
/* Bit k: coordinate k is named by the key `coordinate` or the like. */
unsigned deck_coordinates(struct deck_group *g, const char *key);

#endif

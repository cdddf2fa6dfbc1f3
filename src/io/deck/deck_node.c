/* deck_node.c: the arena, the tree, source locations in messages, and the conversion of
 * libconfig's tree to nodes; the only file that uses libconfig. See deck_tree.h. */
#include <libconfig.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/deck/deck_read.h"
#include "io/deck/deck_tree.h"
#include "model/state.h"

enum { CHUNK = 64 * 1024 };

struct deck_chunk {
  deck_chunk *next;
  void *owned; /* Memory from malloc that deck_own added to the arena; NULL: none */
  size_t used, size;
  _Alignas(16) unsigned char bytes[];
};

void *deck_alloc(deck *d, size_t n, size_t size) {
  if (size && n > SIZE_MAX / 4 / size) longjmp(d->out_of_memory, 1);
  size_t need = (n * size + 15) & ~(size_t)15;
  if (!d->memory || d->memory->size - d->memory->used < need) {
    size_t capacity = need > CHUNK ? need : CHUNK;
    deck_chunk *chunk = memory_fits((double)capacity) ? malloc(sizeof *chunk + capacity) : NULL;
    if (!chunk) longjmp(d->out_of_memory, 1);
    *chunk = (deck_chunk){.next = d->memory, .size = capacity};
    d->memory = chunk;
  }
  void *start = d->memory->bytes + d->memory->used;
  d->memory->used += need;
  return memset(start, 0, need);
}

void *deck_array_grow(deck *d, const void *old, size_t n, size_t capacity, size_t size) {
  void *grown = deck_alloc(d, capacity, size);
  if (n) memcpy(grown, old, n * size);
  return grown;
}

void *deck_extend(deck *d, void *old, size_t n, size_t *capacity, size_t size) {
  if (n < *capacity) return old;
  *capacity = 2 * n + 16;
  return deck_array_grow(d, old, n, *capacity, size);
}

void deck_put(deck *d, deck_buffer *b, const char *text, size_t n) {
  if (b->n + n + 1 > b->capacity) {
    b->capacity = 2 * (b->n + n + 1) + 1024;
    b->bytes = deck_array_grow(d, b->bytes, b->n, b->capacity, 1);
  }
  memcpy(b->bytes + b->n, text, n);
  b->n += n;
  b->bytes[b->n] = 0;
}

char *deck_copy(deck *d, const char *text, size_t n) {
  char *copy = deck_alloc(d, n + 1, 1);
  memcpy(copy, text, n);
  return copy;
}

char *deck_format_v(deck *d, const char *format, va_list args) {
  char *text = format_text_v(format, args), *copy = deck_copy(d, text, strlen(text));
  free(text);
  return copy;
}

char *deck_format(deck *d, const char *format, ...) {
  va_list args;
  va_start(args, format);
  char *text = deck_format_v(d, format, args);
  va_end(args);
  return text;
}

void deck_own(deck *d, void *p) {
  deck_chunk *chunk = memory_new(1, sizeof *chunk);
  chunk->owned = p;
  /* Insert the chunk after the first one, which is still being filled */
  deck_chunk **at = d->memory ? &d->memory->next : &d->memory;
  chunk->next = *at;
  *at = chunk;
}

const char *deck_quote(deck *d, const char *text, size_t n) {
  size_t shown = text_quoted(text, n);
  char *copy = deck_alloc(d, shown + 4, 1);
  memcpy(copy, text, shown);
  if (shown < n) memcpy(copy + shown, "...", sizeof "...");
  return copy;
}

void *deck_keep(deck *d, size_t n, size_t size) {
  return memset(deck_grow(d, NULL, n, size), 0, n * size);
}

void *deck_grow(deck *d, void *old, size_t n, size_t size) {
  if (!memory_resize_row(&old, n, size)) longjmp(d->out_of_memory, 1);
  return old;
}

void deck_memory_free(deck *d) {
  while (d->memory) {
    deck_chunk *next = d->memory->next;
    free(d->memory->owned);
    free(d->memory);
    d->memory = next;
  }
}

/* --- the tree --------------------------------------------------------------------------------- */

deck_node *deck_node_new(deck *d, deck_node *parent, const char *name, deck_type type,
                         deck_place place) {
  deck_node *node = deck_alloc(d, 1, sizeof *node);
  *node = (deck_node){.name = name, .type = type, .place = place, .parent = parent};
  if (!parent) return node;
  parent->child = deck_extend(d, parent->child, parent->n, &parent->capacity, sizeof(deck_node *));
  parent->child[parent->n++] = node;
  return node;
}

deck_node *deck_child(const deck_node *group, const char *name) {
  if (!group || group->type != DECK_GROUP) return NULL;
  for (size_t k = 0; k < group->n; k++)
    if (strcmp(group->child[k]->name, name) == 0) return group->child[k];
  return NULL;
}

void deck_remove(deck_node *parent, const deck_node *child) {
  size_t kept = 0;
  for (size_t k = 0; k < parent->n; k++)
    if (parent->child[k] != child) parent->child[kept++] = parent->child[k];
  parent->n = kept;
}

const char *deck_node_path(deck *d, const deck_node *node) {
  if (!node || !node->parent) return "";
  /* The only phase of a deck without the list `phases`: its keys are at the top of the deck */
  if (node->type == DECK_GROUP && node->parent->type == DECK_LIST && node->parent->defaulted)
    return "";
  const char *above = deck_node_path(d, node->parent);
  if (node->name) return *above ? deck_format(d, "%s.%s", above, node->name) : node->name;
  size_t k = 0;
  while (k < node->parent->n && node->parent->child[k] != node) k++;
  return deck_format(d, "%s[%zu]", above, k);
}

const char *deck_number_text(double x, char text[32]) {
  for (int digits = 15; digits <= 17; digits++) {
    snprintf(text, 32, "%.*g", digits, x);
    if (strtod(text, NULL) == x) break;
  }
  if (isfinite(x) && !strpbrk(text, ".e")) strcat(text, ".0");
  return text;
}

const char *deck_body_name(deck *d, uint32_t body) {
  char name[96];
  return deck_format(d, "%s", sd_model_body_name(d->model, body, name, sizeof name));
}

static const char *node_value(deck *d, const deck_node *node) {
  char text[32];
  switch (node->type) {
    case DECK_BOOL: return node->value.flag ? "true" : "false";
    case DECK_INT: return deck_format(d, "%lld", (long long)node->value.integer);
    case DECK_FLOAT:
      snprintf(text, sizeof text, "%.10g", node->value.number);
      return deck_copy(d, text, strlen(text));
    case DECK_STRING:
      return deck_format(d, "\"%s\"", deck_quote(d, node->value.text, strlen(node->value.text)));
    case DECK_GROUP: return "{...}";
    case DECK_LIST: break;
  }
  bool within = node->parent && node->parent->type == DECK_LIST && node->parent->parent &&
                node->parent->parent->type == DECK_LIST;
  if (node->n > 4 || within) return deck_format(d, "(list of %zu)", node->n);
  char *list = deck_format(d, "(");
  for (size_t k = 0; k < node->n; k++)
    list = deck_format(d, "%s%s%s", list, k ? ", " : "", node_value(d, node->child[k]));
  return deck_format(d, "%s)", list);
}

/* --- messages --------------------------------------------------------------------------------- */

bool deck_error_limit_reached(const deck *d) { return d->reported >= LIMIT_DECK_ERRORS; }

/* If enough errors were shown already, counts one more without showing it and returns true. */
static bool counted(deck *d) {
  if (!deck_error_limit_reached(d)) return false;
  d->reported++;
  return true;
}

const char *deck_place_text(deck *d, deck_place place) {
  if (place.line > 0) return deck_format(d, "%s:%d", place.file, place.line);
  if (place.line == 0) return place.file ? place.file : d->path;
  const bool disk = place.line <= PLACE_DISK;
  return deck_format(d, "%s: %s %d", place.file, disk ? "disk" : "row",
                     disk ? PLACE_DISK - place.line : -(place.line + 1));
}

void deck_report(deck *d, deck_place place, const char *path, const char *value, const char *format,
                 va_list args) {
  if (counted(d)) return;
  d->reported++;
  const char *text = deck_format_v(d, format, args), *where = deck_place_text(d, place);
  fail_about(d->messages,
             (subject){.kind = path ? SUBJECT_PATH : SUBJECT_NONE,
                       .place = memory_text(where),
                       .name = memory_text(path),
                       .value = memory_text(value)},
             "%s", text);
}

/* Returns the value of a node for a message about it; NULL: a group, whose value is not shown. */
static const char *value_of(deck *d, const deck_node *node) {
  return node->type == DECK_GROUP ? NULL : node_value(d, node);
}

void deck_fail(deck *d, const deck_node *node, const char *format, ...) {
  if (counted(d)) return;
  va_list args;
  va_start(args, format);
  const char *path = deck_node_path(d, node);
  deck_report(d, node->place, *path ? path : NULL, value_of(d, node), format, args);
  va_end(args);
}

static void fail_child(deck *d, const deck_node *group, const char *key, const char *format,
                       va_list args) {
  if (counted(d)) return;
  const char *path = deck_node_path(d, group);
  const deck_node *node = deck_child(group, key);
  if (node && node->defaulted) node = NULL;
  deck_report(d, node ? node->place : group->place,
              *path ? deck_format(d, "%s.%s", path, key) : key, node ? value_of(d, node) : NULL,
              format, args);
}

void deck_fail_child(deck *d, const deck_node *group, const char *key, const char *format, ...) {
  va_list args;
  va_start(args, format);
  fail_child(d, group, key, format, args);
  va_end(args);
}

void deck_fail_key(const deck_group *g, const char *key, const char *format, ...) {
  va_list args;
  va_start(args, format);
  fail_child(g->d, g->node, key, format, args);
  va_end(args);
}

size_t deck_disk_bytes(bool free) {
  return comm_world() ? sizeof(sd_disk) : state_disk_bytes(free);
}

/* Largest number of disks that every rank may store in a run on several ranks. */
enum { MOST_OF_ALL_RANKS = 2000000 };

void deck_need(deck *d, const deck_node *group, const char *key, double n, size_t bytes,
               const char *what) {
  const double needed = n * (double)bytes;
  if (d->comm && n > MOST_OF_ALL_RANKS) {
    d->lacks_told = true;
    deck_fail_child(d, group, key, "every rank would have all %.10g %s%s%s; expected at most %d%s",
                    n, what, d->why ? ", since " : "", d->why ? d->why : "", MOST_OF_ALL_RANKS,
                    d->why ? ""
                           : ", a packing with `tiles`, or an HDF5 file, which ranks read in parts "
                             "(docs/cluster.md)");
    longjmp(d->out_of_memory, 1);
  }
  if (!comm_or(d->comm, !memory_fits(needed))) return;
  d->lacks_told = true;
  deck_fail_child(
      d, group, key,
      "%.10g %s need at least %.3g GB of memory, and this process can have %.3g GB; expected fewer",
      n, what, 1e-9 * needed, 1e-9 * memory_limit(1));
  longjmp(d->out_of_memory, 1);
}

deck_place deck_disk_place(const deck *d, uint32_t disk) {
  deck_place place = d->away_place;
  if (disk < model_held(d->model)) return d->disk_place[disk];
  if (place.line < 0) place.line -= (int)(disk - d->model->tiles.first);
  return place;
}

void deck_restart_with_all_disks(deck *d, const char *why) {
  *d->whole = why;
  longjmp(d->out_of_memory, 1);
}

void deck_agree_on_errors(deck *d) {
  if (!d->comm || comm_or(d->comm, d->reported > 0) == 0) return;
  d->wrong = true;
  d->comm = d->model->comm = NULL;
}

void deck_fail_place(deck *d, deck_place place, const char *format, ...) {
  va_list args;
  va_start(args, format);
  deck_report(d, place, NULL, NULL, format, args);
  va_end(args);
}

void deck_check_text(deck *d, const deck_node *node) {
  if (!text_printable(node->value.text))
    deck_fail(d, node, "expected a text in UTF-8 without control characters");
}

void deck_report_rest(deck *d) {
  if (d->reported > LIMIT_DECK_ERRORS)
    sd_fail(d->messages, SD_ERROR_USER, "%s: %zu more errors like these", d->path,
            d->reported - LIMIT_DECK_ERRORS);
}

/* --- numbers by name, found in a hash table so that the cost is linear in their number -------- */

/* Largest number of names that are compared with a misspelt name. */
enum { MOST_GUESSES = 10000 };

/* Returns a pointer to the hash slot of the name, or to the empty slot where it belongs. A slot
 * holds 1 + the index of its name; 0: empty. */
static size_t *index_slot(const deck_index *x, const char *name) {
  uint64_t h = UINT64_C(14695981039346656037);
  for (const char *p = name; *p; p++) h = (h ^ (unsigned char)*p) * UINT64_C(1099511628211);
  size_t k = (size_t)(h ^ h >> 32) & (x->n_slots - 1);
  while (x->slot[k] && strcmp(x->name[x->slot[k] - 1].name, name) != 0)
    k = (k + 1) & (x->n_slots - 1);
  return &x->slot[k];
}

bool deck_index_find(const deck_index *x, const char *name, uint32_t *number) {
  size_t at = x->n ? *index_slot(x, name) : 0;
  if (at) *number = x->name[at - 1].number;
  return at > 0;
}

bool deck_index_add(deck *d, deck_index *x, const char *name, uint32_t number) {
  if (2 * x->n >= x->n_slots) {
    x->n_slots = x->n_slots ? 2 * x->n_slots : 64;
    x->slot = deck_alloc(d, x->n_slots, sizeof *x->slot);
    for (size_t k = 0; k < x->n; k++) *index_slot(x, x->name[k].name) = k + 1;
  }
  size_t *at = index_slot(x, name);
  if (*at) return false;
  x->name = deck_extend(d, x->name, x->n, &x->capacity, sizeof *x->name);
  x->name[x->n++] = (deck_name){name, number};
  *at = x->n;
  return true;
}

void deck_index_guess(const deck *d, const deck_index *x, guess *near) {
  for (size_t k = 0; k < x->n && k < MOST_GUESSES && !deck_error_limit_reached(d); k++)
    guess_add(near, x->name[k].name);
}

const char *deck_index_list(deck *d, const deck_index *x) {
  enum { FEW = 8 };
  const char *text = "", *before = x->n == 1 ? "; there is " : "; there are ";
  for (size_t k = 0; k < x->n && x->n <= FEW && !deck_error_limit_reached(d); k++) {
    const char *name = x->name[k].name;
    text = deck_format(d, "%s%s\"%s\"", text, before, deck_quote(d, name, strlen(name)));
    before = k + 2 < x->n ? ", " : " and ";
  }
  return text;
}

const char *deck_hint(deck *d, const guess *g) {
  return g->best ? deck_format(d, "; did you mean \"%s\"?", g->best) : "";
}

const char *deck_index_instead(deck *d, const deck_index *x, const deck_index *more,
                               const char *name, const char *remark) {
  const struct {
    const deck_index *index;
    const char *what;
  } all[] = {{&d->disks, "disk"},   {&d->walls, "wall"},         {&d->groups, "group of disks"},
             {&d->clumps, "clump"}, {&d->materials, "material"}, {&d->motions, "motion"},
             {&d->fields, "field"}};
  uint32_t number;
  for (size_t k = 0; k < sizeof all / sizeof *all; k++)
    if (deck_index_find(all[k].index, name, &number))
      return deck_format(d, "; it is the name of a %s", all[k].what);
  guess near = guess_start(name);
  deck_index_guess(d, x, &near);
  if (more) deck_index_guess(d, more, &near);
  return near.best ? deck_hint(d, &near) : deck_format(d, "%s%s", deck_index_list(d, x), remark);
}

bool deck_index_look_up(deck *d, const deck_index *x, const char *what, const deck_node *node,
                        const char *remark, uint32_t *number) {
  const char *name = node->type == DECK_STRING ? node->value.text : "";
  if (deck_index_find(x, name, number)) return true;
  deck_fail(d, node, "no %s is called that%s", what, deck_index_instead(d, x, NULL, name, remark));
  return false;
}

/* --- parsing ---------------------------------------------------------------------------------- */

/* The functions below convert libconfig's tree to nodes. The text has passed deck_scan, so that
 * every number fits its type, and the file and line of every line of the text are known. */

static deck_place place_of(const deck_text *text, unsigned line) {
  if (text->n_lines == 0) return (deck_place){NULL, 0};
  if (line < 1) line = 1;
  if (line > text->n_lines) line = (unsigned)text->n_lines;
  return text->line[line - 1];
}

static const char *name_of(deck *d, const config_setting_t *setting) {
  const char *name = config_setting_name(setting);
  return name ? deck_copy(d, name, strlen(name)) : NULL;
}

static deck_type type_of(const config_setting_t *setting) {
  switch (config_setting_type(setting)) {
    case CONFIG_TYPE_GROUP: return DECK_GROUP;
    case CONFIG_TYPE_INT:
    case CONFIG_TYPE_INT64: return DECK_INT;
    case CONFIG_TYPE_FLOAT: return DECK_FLOAT;
    case CONFIG_TYPE_BOOL: return DECK_BOOL;
    case CONFIG_TYPE_STRING: return DECK_STRING;
    default: return DECK_LIST;
  }
}

/* Copies a setting of libconfig and its children to nodes. A missing text or name means that
 * libconfig ran out of memory. The depth of the recursion is limited, because deck_scan limits the
 * nesting of brackets. */
static void convert(deck *d, const deck_text *text, const config_setting_t *from, deck_node *to) {
  switch (to->type) {
    case DECK_BOOL: to->value.flag = config_setting_get_bool(from); return;
    case DECK_INT:
      to->value.integer = config_setting_type(from) == CONFIG_TYPE_INT
                              ? config_setting_get_int(from)
                              : config_setting_get_int64(from);
      return;
    case DECK_FLOAT: to->value.number = config_setting_get_float(from); return;
    case DECK_STRING: {
      const char *s = config_setting_get_string(from);
      if (!s) memory_lacks(0);
      to->value.text = deck_copy(d, s, strlen(s));
      deck_check_text(d, to);
      return;
    }
    case DECK_GROUP:
    case DECK_LIST: break;
  }
  int n = config_setting_length(from);
  for (int k = 0; k < n; k++) {
    const config_setting_t *child = config_setting_get_elem(from, (unsigned)k);
    const char *name = name_of(d, child);
    if (!name && to->type == DECK_GROUP) memory_lacks(0);
    /* Skip the second of two equal keys: deck_scan has renamed and reported it */
    if (name && strncmp(name, "*repeated-", 10) == 0) continue;
    deck_place place = place_of(text, config_setting_source_line(child));
    convert(d, text, child, deck_node_new(d, to, name, type_of(child), place));
  }
}

void deck_parse_free(deck *d) {
  if (!d->library) return;
  config_destroy(d->library);
  free(d->library);
  d->library = NULL;
}

deck_node *deck_parse(deck *d, const deck_text *text) {
  config_t *library = memory_new(1, sizeof *library);
  config_init(library);
  d->library = library;
  deck_node *root = NULL;
  if (config_read_string(library, text->clean)) {
    root = deck_node_new(d, NULL, NULL, DECK_GROUP, place_of(text, 1));
    convert(d, text, config_root_setting(library), root);
  } else {
    const char *what = config_error_text(library);
    deck_fail_place(d, place_of(text, (unsigned)config_error_line(library)),
                    "%s, here or on the line before (is a ; or a comma missing, or one too many?)",
                    what ? what : "syntax error");
  }
  deck_parse_free(d);
  return root;
}

/* deck_locate.c: adds file and line to the messages of the model's checks. See deck_tree.h.
 *
 * Each message of the model begins with what it is about: a path of the deck (phases[0].cell), or a
 * body or motion (clump "plate", disk 3). */
#include <stdlib.h>
#include <string.h>

#include "io/deck/deck_tree.h"

/* --- paths ------------------------------------------------------------------------------------ */

static size_t word_length(const char *p) {
  return strspn(p, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_");
}

/* Follows the path at the start of a message, such as "phases[0].cell: ...", through the tree.
 * Returns the deepest node of the path that exists; NULL if the text does not begin with a path. */
static const deck_node *follow(deck *d, const char *p) {
  const deck_node *node = d->root;
  for (size_t n; (n = word_length(p)) > 0; p += *p == '.') {
    const deck_node *child = deck_child(node, deck_copy(d, p, n));
    if (!child) break;
    node = child;
    p += n;
    if (*p != '[') continue;
    char *end;
    const unsigned long k = strtoul(p + 1, &end, 10);
    if (node->type != DECK_LIST || k >= node->n || *end != ']') break;
    node = node->child[k];
    p = end + 1;
  }
  return node == d->root ? NULL : node;
}

/* --- bodies and motions ----------------------------------------------------------------------- */

/* Returns entry k of a top-level list of the deck; NULL if there is no such entry. */
static const deck_node *entry(const deck *d, const char *list, size_t k) {
  const deck_node *node = deck_child(d->root, list);
  return node && node->type == DECK_LIST && k < node->n ? node->child[k] : NULL;
}

/* Returns the source location of clump k: its entry in `clumps`, or, for a clump that a packing
 * made, the location of its first disk. */
static deck_place place_of_clump(const deck *d, size_t k) {
  const sd_model *m = d->model;
  const deck_node *node = entry(d, "clumps", k);
  size_t i = 0;
  const size_t n = model_held(m);
  while (!node && i < n && (size_t)m->disks[i].clump != k + 1) i++;
  return node ? node->place : i < n ? d->disk_place[i] : d->root->place;
}

static deck_place place_of_wall(const deck *d, size_t k) {
  const deck_node *node = entry(d, "walls", k);
  if (!node) node = deck_child(d->root, "container");
  return node ? node->place : d->root->place;
}

/* Reads the body or motion at the start of a message, such as "disk 3: ..." or "disk "a": ...", if
 * it is of the given kind. *number: its number; *rest: the text after its number or name. Returns
 * false if the message begins otherwise. */
static bool number_of(deck *d, const char *text, const char *kind, const deck_index *names,
                      uint32_t *number, const char **rest) {
  const size_t n = strlen(kind);
  if (strncmp(text, kind, n) != 0 || text[n] != ' ') return false;
  const char *p = text + n + 1;
  if (*p == '"') {
    const char *end = strstr(p + 1, "\":");
    *rest = end ? end + 1 : NULL;
    return end && deck_index_find(names, deck_copy(d, p + 1, (size_t)(end - p - 1)), number);
  }
  char *end;
  *number = (uint32_t)strtoul(p, &end, 10);
  *rest = end;
  return end != p && *end == ':';
}

/* --- one message ------------------------------------------------------------------------------ */

/* If a container has made the box, changes a message about box.x or box.y into one about the
 * container's key width or height, and sets *place to that key. */
static const char *key_of_container(deck *d, const char *text, deck_place *place) {
  const bool x = strncmp(text, "box.x:", 6) == 0, y = strncmp(text, "box.y:", 6) == 0;
  const deck_node *container = deck_child(d->root, "container"), *box = deck_child(d->root, "box");
  if (!(x || y) || !container || deck_child(box, x ? "x" : "y")) return text;
  const deck_node *key = deck_child(container, x ? "width" : "height");
  *place = key ? key->place : container->place;
  return deck_format(d, "container.%s%s", x ? "width" : "height", text + 5);
}

/* Finds the source location of the body, motion or key that a message is about. Returns the
 * message, in which a motion is named by its path in the deck. */
static const char *locate(deck *d, const char *text, deck_place *place) {
  const sd_model *m = d->model;
  const char *rest;
  uint32_t k;
  *place = (deck_place){d->path, 0};
  if (number_of(d, text, "disk", &d->disks, &k, &rest) && k < m->n_disks) {
    *place = deck_disk_place(d, k);
  } else if (number_of(d, text, "wall", &d->walls, &k, &rest)) {
    *place = place_of_wall(d, k);
  } else if (number_of(d, text, "clump", &d->clumps, &k, &rest)) {
    *place = place_of_clump(d, k);
  } else if (number_of(d, text, "motion", &d->motions, &k, &rest)) {
    if (text[strlen("motion ")] != '"')
      k = k < m->n_motions ? (uint32_t)d->motion_entry[k] : UINT32_MAX;
    const deck_node *motion = entry(d, "motions", k);
    if (!motion) return text;
    *place = motion->place;
    return deck_format(d, "%s%s", deck_node_path(d, motion), rest);
  } else {
    const deck_node *node = follow(d, text);
    if (node) *place = node->place;
    return key_of_container(d, text, place);
  }
  return text;
}

void deck_report_model_messages(deck *d, const sd_messages *found) {
  size_t told = 0;
  for (size_t k = 0; k < sd_messages_count(found); k++) {
    const sd_status kind = sd_messages_kind(found, k);
    const char *text = sd_messages_text(found, k);
    deck_place place;
    told += kind != SD_OK;
    if (kind == SD_OK) {
      sd_warn(d->messages, "%s", text);
    } else if (kind != SD_ERROR_USER) {
      sd_fail(d->messages, kind, "%s", text);
    } else {
      text = locate(d, text, &place);
      sd_fail(d->messages, kind, "%s: %s", deck_place_text(d, place), text);
    }
  }
  if (sd_messages_errors(found) > told)
    sd_fail(d->messages, SD_ERROR_USER, "%s: %zu more errors like these", d->path,
            sd_messages_errors(found) - told);
}

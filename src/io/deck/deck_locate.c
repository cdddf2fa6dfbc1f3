/* deck_locate.c: adds file and line to the messages of the model's checks. See deck_tree.h. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "io/deck/deck_tree.h"

/* --- paths ------------------------------------------------------------------------------------ */

static size_t word_length(const char *p) {
  return strspn(p, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_");
}

/* Follows a path, such as "phases[0].cell", through the tree. Returns the deepest node of the path
 * that exists; NULL: none. */
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

/* --- bodies ----------------------------------------------------------------------------------- */

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

static deck_place place_of_body(const deck *d, size_t body) {
  const sd_model *m = d->model;
  const size_t bodies = sd_model_bodies(m);
  return body < m->n_disks ? deck_disk_place(d, (uint32_t)body)
         : body < bodies   ? place_of_wall(d, body - m->n_disks)
                           : place_of_clump(d, body - bodies);
}

/* --- one message ------------------------------------------------------------------------------ */

/* If a container has made the box, returns for the path box.x or box.y the path of the container's
 * key width or height, and sets *node to that key. */
static const char *key_of_container(const deck *d, const char *path, const deck_node **node) {
  const bool x = strcmp(path, "box.x") == 0, y = strcmp(path, "box.y") == 0;
  const deck_node *container = deck_child(d->root, "container"), *box = deck_child(d->root, "box");
  if (!(x || y) || !container || deck_child(box, x ? "x" : "y")) return path;
  const deck_node *key = deck_child(container, x ? "width" : "height");
  *node = key ? key : container;
  return x ? "container.width" : "container.height";
}

/* Returns the subject of a message of the model with its source location; a motion is named by its
 * path in the deck. */
static subject located(deck *d, const subject *about) {
  const char *name = about->name;
  deck_place place = {d->path, 0};
  const deck_node *node = NULL;
  if (about->kind == SUBJECT_BODY) {
    place = place_of_body(d, about->number);
  } else if (about->kind == SUBJECT_MOTION) {
    node = entry(d, "motions", d->motion_entry[about->number]);
    name = deck_node_path(d, node);
  } else if (about->kind == SUBJECT_PATH) {
    node = follow(d, name);
    name = key_of_container(d, name, &node);
  }
  const char *where = deck_place_text(d, node ? node->place : place);
  return (subject){about->kind, about->number, memory_text(where), memory_text(name),
                   memory_text(about->value)};
}

void deck_report_model_messages(deck *d, const sd_messages *found) {
  size_t told = 0;
  for (size_t k = 0; k < sd_messages_count(found); k++) {
    const message *one = messages_at(found, k);
    told += one->kind != SD_OK;
    if (one->kind == SD_ERROR_USER)
      fail_about(d->messages, located(d, &one->about), "%s", one->wrong);
    else
      sd_fail(d->messages, one->kind, "%s", one->text);
  }
  if (sd_messages_errors(found) > told)
    sd_fail(d->messages, SD_ERROR_USER, "%s: %zu more errors like these", d->path,
            sd_messages_errors(found) - told);
}

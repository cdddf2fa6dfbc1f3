/* deck_confined.c: keeps the files that a deck names within one folder; see deck_tree.h. */
#include <stdlib.h>
#include <string.h>

#include "io/deck/deck_tree.h"
#include "io/store/file.h"

const char deck_outside[] = "outside of the folder that --confined or SLIPDISK_CONFINED names";

static char *joined(deck *d, const char *file, const char *path) {
  const char *slash = file ? strrchr(file, '/') : NULL;
  if (!slash || path[0] == '/') return deck_copy(d, path, strlen(path));
  return deck_format(d, "%.*s/%s", (int)(slash - file), file, path);
}

bool deck_is_outside(deck *d, const char *file, const char *path) {
  const char *folder = getenv("SLIPDISK_CONFINED");
  return folder && *folder && *path && !file_is_within(joined(d, file, path), folder);
}

char *deck_resolve(deck *d, const char *file, const char *path) {
  return deck_is_outside(d, file, path) ? deck_copy(d, "", 0) : joined(d, file, path);
}

bool deck_check_files(deck *d, const deck_node *node) {
  bool good = true;
  for (size_t k = 0; (node->type == DECK_GROUP || node->type == DECK_LIST) && k < node->n; k++)
    good = deck_check_files(d, node->child[k]) && good;
  if (node->type != DECK_STRING || !node->name || strcmp(node->name, "file") != 0) return good;
  if (!deck_is_outside(d, d->path, node->value.text)) return good;
  deck_fail(d, node, "%s", deck_outside);
  return false;
}

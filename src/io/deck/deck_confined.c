/* deck_confined.c: keeps the files that a deck names within one folder; see deck_tree.h. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "io/deck/deck_tree.h"
#include "io/store/file.h"

const char deck_outside[] = "outside of the folder that --confined or SLIPDISK_CONFINED names";

/* Returns the folder in which the last component of a path lies, in place. */
static void strip_last(char *path) {
  char *slash = strrchr(path, '/');
  if (slash)
    slash[slash == path] = 0;
  else
    strcpy(path, ".");
}

/* Returns the real path of a file, or that of the deepest folder on the way to it that exists; NULL
 * if a link on the way leads nowhere. The caller frees it. */
static char *real_path(const char *path) {
  char *rest = memory_text(path), *real;
  while (!(real = realpath(rest, NULL)) && !file_is_link(rest) && strcmp(rest, ".") != 0 &&
         strcmp(rest, "/") != 0)
    strip_last(rest);
  free(rest);
  return real;
}

static char *joined(deck *d, const char *file, const char *path) {
  const char *slash = file ? strrchr(file, '/') : NULL;
  if (!slash || path[0] == '/') return deck_copy(d, path, strlen(path));
  return deck_format(d, "%.*s/%s", (int)(slash - file), file, path);
}

bool deck_is_outside(deck *d, const char *file, const char *path) {
  const char *folder = getenv("SLIPDISK_CONFINED");
  if (!folder || !*folder || !*path) return false;
  char *root = realpath(folder, NULL), *real = real_path(joined(d, file, path));
  const size_t n = root && root[1] ? strlen(root) : 0; /* The root of all has no name */
  const bool inside = root && real && strncmp(real, root, n) == 0 && (!real[n] || real[n] == '/');
  free(root);
  free(real);
  return !inside;
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

/* file_within.c: finds out in which folder a file lies, all links followed; see file.h. */
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "io/store/file.h"

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
  char *rest = memory_text(*path ? path : "."), *real;
  while (!(real = realpath(rest, NULL)) && !file_is_link(rest) && strcmp(rest, ".") != 0 &&
         strcmp(rest, "/") != 0)
    strip_last(rest);
  free(rest);
  return real;
}

bool file_is_within(const char *path, const char *folder) {
  char *root = realpath(folder, NULL), *real = real_path(path);
  const size_t n = root && root[1] ? strlen(root) : 0; /* The name of the root is "/" */
  const bool inside = root && real && strncmp(real, root, n) == 0 && (!real[n] || real[n] == '/');
  free(root);
  free(real);
  return inside;
}

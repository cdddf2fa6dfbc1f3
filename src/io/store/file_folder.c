/* file_folder.c: folders that are there whole or not at all; see file.h. */
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/text.h"
#include "io/store/file.h"

sd_status file_folder_open(const char *path, file_folder *f, sd_messages *messages) {
  *f = (file_folder){0};
  size_t length = strlen(path);
  while (length > 1 && path[length - 1] == '/') length--;
  f->path = format_text("%.*s", (int)length, path);
  /* an empty folder of this name gives way to the new one, which has its mode */
  struct stat facts;
  const bool there = stat(f->path, &facts) == 0 && S_ISDIR(facts.st_mode);
  const mode_t mode = there ? facts.st_mode & 0777 : 0777;
  if (file_exists(f->path) && (rmdir(f->path) != 0 || mkdir(f->path, mode) != 0))
    return sd_fail(messages, SD_ERROR_USER, "%s is there already: remove it, or name another",
                   f->path);
  sd_status status = SD_ERROR_IO;
  for (int attempt = 0;; attempt++) {
    f->draft = file_draft_name(f->path);
    if (mkdir(f->draft, mode) == 0) {
      if (there) (void)!chmod(f->draft, mode);
      return SD_OK;
    }
    bool taken = errno == EEXIST && attempt < 8;
    if (!taken) status = file_make_folder(f->draft, messages); /* says why it cannot be made */
    if (status == SD_OK) return SD_OK;
    free(f->draft);
    f->draft = NULL;
    if (!taken) return status;
  }
}

FILE *file_folder_new(const file_folder *f, const char *name, sd_messages *messages) {
  char *path = format_text("%s/%s", f->draft, name);
  int fd = file_open_at(AT_FDCWD, path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW);
  FILE *out = fd < 0 ? NULL : fdopen(fd, "w");
  if (!out) file_fail(messages, "write", path);
  if (fd >= 0 && !out) close(fd);
  free(path);
  return out;
}

sd_status file_folder_end(const file_folder *f, FILE *out, sd_status status,
                          sd_messages *messages) {
  if (!out) return status;
  bool bad = ferror(out) != 0;
  bad = fclose(out) != 0 || bad;
  return bad && status == SD_OK ? file_fail(messages, "write", f->path) : status;
}

/* Makes all files in it durable at once. */
static bool sync_all(const char *path) {
  int fd = file_open_at(AT_FDCWD, path, O_RDONLY | O_DIRECTORY);
  bool good = fd >= 0 && syncfs(fd) == 0;
  if (fd >= 0) close(fd);
  return good;
}

static void remove_draft(const file_folder *f) {
  DIR *directory = opendir(f->draft);
  for (struct dirent *entry; directory && (entry = readdir(directory));)
    if (entry->d_name[0] != '.') unlinkat(dirfd(directory), entry->d_name, 0);
  if (directory) closedir(directory);
  rmdir(f->draft);
}

sd_status file_folder_close(file_folder *f, sd_status status, sd_messages *messages) {
  if (f->draft) {
    if (status == SD_OK && (!sync_all(f->draft) || rename(f->draft, f->path) != 0))
      status = file_fail(messages, "write", f->path);
    if (status == SD_OK)
      status = file_sync_folder(-1, f->path, messages);
    else
      remove_draft(f);
  }
  free(f->path);
  free(f->draft);
  *f = (file_folder){0};
  return status;
}

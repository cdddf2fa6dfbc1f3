/* h5_file.c: one HDF5 file: its record, its opening and closing, and errors of the library. See h5.h. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"
#include "io/store/h5_private.h"

/* --- the library ------------------------------------------------------------------------------ */

/* The library prints nothing; but what it had no memory for looks as if it were not there. */
static herr_t look_for_shortage(unsigned n, const H5E_error2_t *error, void *user) {
  (void)n, (void)user;
  if (error->maj_num == H5E_RESOURCE) shortage_note();
  return 0;
}

static herr_t look_at_error(hid_t stack, void *user) {
  H5Ewalk2(stack, H5E_WALK_UPWARD, look_for_shortage, user);
  return 0;
}

void h5_quiet(void) {
  static bool asked;
  /* must come before the library starts: at exit it would write to files that have failed */
  if (!__atomic_exchange_n(&asked, true, __ATOMIC_RELAXED)) H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, look_at_error, NULL);
}

static herr_t first_reason(unsigned n, const H5E_error2_t *error, void *user) {
  const char **reason = user;
  (void)n;
  if (error->desc && !*reason) *reason = error->desc;
  return 0;
}

const char *h5_reason(char *text, size_t size) {
  const char *reason = NULL;
  /* upward: the innermost entry, the actual cause, comes first */
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, first_reason, &reason);
  snprintf(text, size, "%s", reason ? reason : "unknown reason");
  return text;
}

const char *h5_version(char *text, size_t size) {
  unsigned major = 0, minor = 0, release = 0;
  h5_quiet();
  H5get_libversion(&major, &minor, &release);
  snprintf(text, size, "%u.%u.%u", major, minor, release);
  return text;
}

bool h5_is_file(const char *path) {
  uint64_t size;
  const int fd = file_open_quiet(path, &size);
  char *again = fd < 0 ? NULL : file_again(fd, path);
  h5_quiet();
  const bool found = again && H5Fis_hdf5(again) > 0;
  free(again);
  if (fd >= 0) close(fd);
  return found;
}

/* --- record of a file ------------------------------------------------------------------------- */

static void free_journal(h5_file *file) {
  for (size_t k = 0; k < file->n_entries; k++) {
    free(file->journal[k].path);
    free(file->journal[k].attr);
  }
  free(file->journal);
}

void h5_shares_free(h5_shares *s) {
  if (!s) return;
  for (size_t k = 0; k < s->n_sets; k++) {
    free(s->set[k].path);
    free(s->set[k].own);
  }
  for (size_t g = 0; g < H5_SHARED_GROUPS; g++) {
    for (size_t k = 0; s->group[g].place && k < s->n; k++) free(s->group[g].place[k]);
    free(s->group[g].place);
    free(s->group[g].rows);
  }
  for (size_t k = 0; s->file && k < s->n; k++) h5_close(s->file[k], NULL);
  free(s->file);
  free(s->set);
  free(s);
}

h5_file *h5_allocate(const char *path) {
  h5_quiet();
  h5_file *file = memory_new(1, sizeof *file);
  file->path = memory_text(path);
  return file;
}

void h5_release(h5_file *file) {
  if (!file) return;
  free(file->path);
  free(file->trouble);
  for (size_t k = 0; k < file->n_sets; k++) {
    h5_rows_close(&file->sets[k].rows);
    free(file->sets[k].path);
  }
  free(file->sets);
  free(file->loans);
  h5_shares_free(file->shares);
  free_journal(file);
  free(file);
}

/* --- open and close --------------------------------------------------------------------------- */

sd_status h5_open_descriptor(int fd, const char *path, h5_file **out, sd_messages *messages) {
  *out = h5_allocate(path);
  char *again = file_again(fd, path), reason[200];
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);
#if H5_VERSION_GE(1, 10, 7)
  /* what is read here was renamed into place whole, and some file systems cannot lock */
  H5Pset_file_locking(access, false, true);
#endif
  (*out)->id = H5Fopen(again, H5F_ACC_RDONLY, access);
  h5_reason(reason, sizeof reason); /* any other call would clear it */
  H5Pclose(access);
  if ((*out)->id >= 0) {
    free(again);
    return SD_OK;
  }
  if (H5Fis_hdf5(again) == 0)
    sd_fail(messages, SD_ERROR_IO, "%s is not an HDF5 file", path);
  else
    sd_fail(messages, SD_ERROR_IO, "%s is not a readable HDF5 file: %s", path, reason);
  free(again);
  h5_release(*out);
  *out = NULL;
  return SD_ERROR_IO;
}

/* Remembers the first failure. */
void h5_require(h5_file *file, bool good, const char *path) {
  if (good || file->failed) return;
  char reason[200];
  file->failed = true;
  file->trouble = format_text("%s: %s", path, h5_reason(reason, sizeof reason));
}

void h5_flush_sets(h5_file *file) {
  for (size_t k = 0; k < file->n_sets && !file->failed; k++) {
    h5_rows *rows = &file->sets[k].rows;
    h5_require(file, h5_rows_flush(rows) && H5Dclose(rows->set) >= 0, file->sets[k].path);
  }
}

/* Flushes and closes; what went wrong while writing is reported. The file is still to be released. */
sd_status h5_end(h5_file *file, sd_messages *messages) {
  char reason[200];
  h5_flush_sets(file);
  /* After a failed write the library keeps buffers that it cannot get rid of, and closing may crash: such a
   * file is left open for the rest of the process. */
  if (!file->failed &&
      ((file->writing && H5Fflush(file->id, H5F_SCOPE_GLOBAL) < 0) || H5Fclose(file->id) < 0)) {
    file->failed = true;
    file->trouble = memory_text(h5_reason(reason, sizeof reason));
  }
  if (!file->failed) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "cannot write %s: %s", file->path, file->trouble);
}

sd_status h5_close(h5_file *file, sd_messages *messages) {
  if (!file) return SD_OK;
  sd_status status = h5_end(file, messages);
  h5_release(file);
  return status;
}

bool h5_failed(const h5_file *file) { return file->failed; }

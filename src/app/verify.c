/* verify.c: `slipdisk verify FILE...` checks whether files are unchanged, by the checksums stored
 * in them. */
#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "base/text.h"
#include "io/results/checkpoint.h"
#include "io/results/record.h"
#include "io/store/file.h"
#include "io/store/folder.h"

typedef struct verifier {
  bool quiet, seal, unsealed;
  size_t first; /* Index in argv of the first FILE */
  size_t files, damaged;
} verifier;

static const option_row rows[] = {
    {"quiet", 'q', OPTION_FLAG, offsetof(verifier, quiet), NULL, NULL, "errors only"},
    {"seal", 0, OPTION_FLAG, offsetof(verifier, seal), NULL, NULL,
     "make the checksum of a file anew that was changed on purpose"},
    {"unsealed", 0, OPTION_FLAG, offsetof(verifier, unsealed), NULL, NULL,
     "files without a checksum, of older versions, count as sound where they can be read"},
};
const command_line app_verify_line = {
    .name = "verify",
    .n = sizeof rows / sizeof *rows,
    .rows = rows,
    .operand = OPERAND_RESULTS,
    .offset = offsetof(verifier, first),
    .operands = "FILE...",
    .summary = "Compares all bytes of results, unfinished runs or sweeps with their checksums",
    .more = "Exit status 4 when one is damaged.\n",
    .examples = "slipdisk verify deck.h5 sweep.sweep     # is every byte as it was written?\n"};

/* Prints why a file is damaged, and counts it in v->damaged. */
static void tell_damaged(verifier *v, const char *path, const sd_messages *why) {
  v->damaged++;
  if (sd_messages_count(why) == 0) fprintf(stderr, "error: %s cannot be read\n", path);
  sd_messages_print(why, stderr);
}

static bool verify_file(verifier *v, const char *path) {
  sd_messages *why = sd_messages_new();
  bool sealed = false;
  uint64_t sum = 0;
  sd_status status = v->seal ? h5_reseal(path, why) : SD_OK;
  if (status == SD_OK) status = h5_verify(path, &sealed, &sum, why);
  if (status == SD_OK && !sealed && !v->unsealed)
    status = sd_fail(why, SD_ERROR_IO,
                     "%s has no checksum: it was written by an older version or by another "
                     "program, and whether it is "
                     "damaged cannot be told",
                     path);
  v->files++;
  if (status != SD_OK)
    tell_damaged(v, path, why);
  else if (!v->quiet && !sealed)
    printf("%s: can be read, %.3g MB, without a checksum\n", path, (double)file_size(path) / 1e6);
  else if (!v->quiet)
    printf("%s: sound, %.3g MB, sum %016" PRIx64 "\n", path, (double)file_size(path) / 1e6, sum);
  sd_messages_free(why);
  return status == SD_OK;
}

/* Checks the part files of a run that this checkpoint counts: all must be present and undamaged,
 * and each must have the checksum that the next one stores (record_link). */
static void verify_chain(verifier *v, const char *inside, const char *checkpoint) {
  sd_messages *why = sd_messages_new();
  h5_file *file = NULL, *part = NULL;
  sd_status status = h5_open_sealed(-1, checkpoint, &file, NULL, why);
  char *run_id = status == SD_OK ? h5_get_attr_text(file, "/parameters", "run_id") : NULL;
  int64_t n = run_id ? checkpoint_get_parts(file) : 0;
  uint64_t sum = 0, last = run_id ? checkpoint_get_last_part(file) : 0;
  for (int64_t k = 1; status == SD_OK && k <= n; k++) {
    char *path = folder_part(inside, k);
    record_link link = {.run_id = run_id, .number = k, .after = sum};
    status = record_open(-1, path, &link, &part, &sum, why);
    if (status == SD_OK) h5_close(part, NULL);
    free(path);
  }
  if (status == SD_OK && run_id && sum != last)
    status = sd_fail(why, SD_ERROR_IO, "%s names another last part than the one that is there",
                     checkpoint);
  if (status != SD_OK) tell_damaged(v, checkpoint, why);
  h5_close(file, NULL);
  free(run_id);
  sd_messages_free(why);
}

/* Verifies all files with a checksum in a folder: that of the part files of a run, or that of the
 * points of a sweep with the folders of part files inside it. */
static sd_status verify_folder(verifier *v, const char *inside, sd_messages *messages) {
  DIR *directory = opendir(inside);
  if (!directory)
    return sd_fail(messages, SD_ERROR_IO, "cannot read %s: %s", inside, strerror(errno));
  sd_status status = SD_OK;
  errno = 0;
  for (struct dirent *entry; status == SD_OK && (entry = readdir(directory)); errno = 0) {
    char *path = format_text("%s/%s", inside, entry->d_name);
    if (text_ends(path, ".h5.parts")) {
      status = verify_folder(v, path, messages);
    } else if (text_ends(path, ".h5") && strncmp(entry->d_name, "damaged-", 8) != 0) {
      bool good = verify_file(v, path);
      if (good && strncmp(entry->d_name, "checkpoint-", 11) == 0) verify_chain(v, inside, path);
    }
    free(path);
  }
  if (status == SD_OK && errno != 0)
    status = sd_fail(messages, SD_ERROR_IO, "cannot read %s: %s", inside, strerror(errno));
  closedir(directory);
  return status;
}

/* Verifies a file, a folder of part files (RESULT.parts), an unfinished run given by the name of
 * its result, or the folder of a sweep. */
static sd_status verify(verifier *v, const char *name, sd_messages *messages) {
  char *points = format_text("%s/points", name), *parts = format_text("%s.parts", name);
  sd_status status = SD_OK;
  if (file_is_folder(points))
    status = verify_folder(v, points, messages);
  else if (file_is_folder(name))
    status = verify_folder(v, name, messages);
  else if (file_exists(name))
    verify_file(v, name);
  else if (!file_is_folder(parts)) {
    char *hint = file_hint(name);
    status = sd_fail(messages, SD_ERROR_USER,
                     "there is neither a result %s nor an unfinished run %s%s", name, parts, hint);
    free(hint);
  }
  if (status == SD_OK && !file_is_folder(name) && file_is_folder(parts))
    status = verify_folder(v, parts, messages);
  free(points);
  free(parts);
  return status;
}

int app_verify(int argc, char **argv) {
  verifier v = {0};
  int mistake = options_parse(&app_verify_line, argc, argv, &v);
  if (mistake) return mistake;
  sd_messages *messages = sd_messages_new();
  int status = SD_OK;
  for (int k = (int)v.first; k < argc; k++) {
    sd_status one = verify(&v, argv[k], messages);
    if (status == SD_OK) status = one;
  }
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  if (v.files > 1 && !v.quiet) printf("%zu files, %zu damaged\n", v.files, v.damaged);
  return v.damaged > 0 ? SD_ERROR_IO : status;
}

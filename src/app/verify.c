/* verify.c: `slipdisk verify FILE...` checks whether files are unchanged, by the checksums stored
 * in them. */
#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "base/hash.h"
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

/* Prints that a file is sound, with the checksum of its bytes as `xxhsum -H3` prints it. */
static void tell_sound(const char *path, uint64_t sum) {
  printf("%s: sound, %.3g MB, XXH3 %016" PRIx64 "\n", path, (double)file_size(path) / 1e6, sum);
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
    tell_sound(path, sum);
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

/* Returns true if these bytes have the checksum of a list in table.h5: "XXH3_" and 16 digits, or
 * digits only, a hash_words of versions up to 0.6. */
static bool is_sum_of(const char *text, const void *bytes, size_t size) {
  static const char kind[] = "XXH3_";
  const bool words = strncmp(text, kind, strlen(kind)) != 0;
  return (words ? hash_words(HASH_WORDS, bytes, size) : file_sum(bytes, size)) ==
         strtoull(words ? text : text + strlen(kind), NULL, 16);
}

/* Checks a file of a sweep against a line of the list in its table.h5: it must be there and, if the
 * line gives a checksum, have it. */
static void verify_listed(verifier *v, const char *inside, char *line) {
  char *sum = strrchr(line, ' ');
  const bool sums = sum; /* names of points have no blank */
  if (sums) *sum++ = 0;
  char *path = format_text("%s/%s", inside, line);
  sd_messages *why = sd_messages_new();
  unsigned char *bytes = NULL;
  size_t size = 0;
  sd_status status = SD_OK;
  if (!file_exists(path))
    status = sd_fail(why, SD_ERROR_IO, "%s is missing: %s/table.h5 names it", path, inside);
  else if (sums)
    status = file_read(path, SIZE_MAX, &bytes, &size, why);
  if (status == SD_OK && sums && !is_sum_of(sum, bytes, size))
    status = sd_fail(why, SD_ERROR_IO,
                     "%s is not the table that %s/table.h5 belongs to; slipdisk sweep DECK --table "
                     "makes both anew",
                     path, inside);
  v->files += sums;
  if (status != SD_OK)
    tell_damaged(v, path, why);
  else if (sums && !v->quiet)
    tell_sound(path, file_sum(bytes, size));
  free(bytes);
  free(path);
  sd_messages_free(why);
}

/* Checks the tables of a sweep, and that all its finished points are there; not while a process
 * writes them. Older versions made tables without a list. */
static void verify_tables(verifier *v, const char *inside) {
  char *path = format_text("%s/table.h5", inside), *list = NULL;
  h5_file *file = NULL;
  const bool good = !folder_is_locked(inside) && file_exists(path) && verify_file(v, path);
  if (good && h5_open(path, &file, NULL) == SD_OK) list = h5_get_text(file, "/parameters/files");
  h5_close(file, NULL);
  for (char *line = list, *end; line && (end = strchr(line, '\n')); line = end + 1) {
    *end = 0;
    verify_listed(v, inside, line);
  }
  free(list);
  free(path);
}

/* Verifies all files with a checksum in a folder: that of the part files of a run, or that of the
 * points of a sweep with the folders of part files inside it. */
static sd_status verify_folder(verifier *v, const char *inside, sd_messages *messages) {
  DIR *directory = opendir(inside);
  if (!directory)
    return sd_fail(messages, SD_ERROR_IO, "cannot read %s: %s", inside, strerror(errno));
  sd_status status = SD_OK;
  size_t parts = 0, checkpoints = 0;
  errno = 0;
  for (struct dirent *entry; status == SD_OK && (entry = readdir(directory)); errno = 0) {
    parts += strncmp(entry->d_name, "part-", 5) == 0;
    checkpoints += strncmp(entry->d_name, "checkpoint-", 11) == 0;
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
  if (status == SD_OK && parts > 0 && checkpoints == 0) {
    v->damaged++;
    fprintf(stderr, "error: %s has parts but no checkpoint\n", inside);
  }
  return status;
}

/* Verifies a folder that the user has named; it is an error if nothing of slipdisk is in it. */
static sd_status verify_named(verifier *v, const char *inside, sd_messages *messages) {
  const size_t before = v->files + v->damaged;
  char *points = format_text("%s/points", inside), *means = format_text("%s/means.csv", inside);
  const bool has_points = file_is_folder(points), has_means = file_exists(means);
  sd_status status = SD_OK;
  if (has_points) status = verify_folder(v, points, messages);
  if (has_points || has_means)
    verify_tables(v, inside);
  else
    status = verify_folder(v, inside, messages);
  free(points);
  free(means);
  if (status != SD_OK || v->files + v->damaged > before) return status;
  return sd_fail(messages, SD_ERROR_USER,
                 "there is nothing to verify in %s: no result, no checkpoint, no table", inside);
}

/* Verifies a file, a folder of part files (RESULT.parts), an unfinished run given by the name of
 * its result, or the folder of a sweep. */
static sd_status verify(verifier *v, const char *name, sd_messages *messages) {
  sd_status status = place_refuse_deck(name, messages);
  if (status != SD_OK) return status;
  char *parts = format_text("%s.parts", name);
  if (file_is_folder(name))
    status = verify_named(v, name, messages);
  else if (file_exists(name))
    verify_file(v, name);
  else if (!file_is_folder(parts)) {
    char *hint = file_hint(name);
    status = sd_fail(messages, SD_ERROR_USER,
                     "there is neither a result %s nor an unfinished run %s%s", name, parts, hint);
    free(hint);
  }
  if (status == SD_OK && !file_is_folder(name) && file_is_folder(parts))
    status = verify_named(v, parts, messages);
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

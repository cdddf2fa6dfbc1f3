/* options.c: parses command lines and prints the help of commands; see options.h. */
#include "app/options.h"

#include <assert.h>
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"
#include "io/store/h5.h"

/* --- lines ------------------------------------------------------------------------------------ */

static char *shown_text(const char *format, va_list args) {
  char *text = format_text_v(format, args), *shown = text_escaped(text, LIMIT_LINE);
  free(text);
  return shown;
}

void app_line(FILE *out, const char *format, ...) {
  va_list args;
  va_start(args, format);
  char *shown = shown_text(format, args);
  va_end(args);
  fprintf(out, "%s\n", shown);
  free(shown);
}

int app_misuse(const char *command, const char *format, ...) {
  va_list args;
  va_start(args, format);
  char *shown = shown_text(format, args);
  va_end(args);
  fprintf(stderr, "error: slipdisk %s: %s; see slipdisk %s --help\n", command, shown, command);
  free(shown);
  return SD_ERROR_USER;
}

bool options_number(const char *text, long least, long most, long *out) {
  char *end;
  errno = 0;
  long value = strtol(text, &end, 10);
  if (errno != 0 || end == text || *end || value < least || value > most) return false;
  *out = value;
  return true;
}

bool options_reals(const char *text, size_t n, double *value) {
  for (size_t k = 0; k < n; k++) {
    char *end;
    value[k] = strtod(text, &end);
    if (end == text || !isfinite(value[k]) || *end != (k + 1 < n ? ',' : 0)) return false;
    text = end + 1;
  }
  return true;
}

/* Reads up to three integers separated by colons from `text` into `value`; a number left out leaves
 * its entry unchanged. given[k]: set to true if number k is there. Returns the number of colons;
 * -1: the text is not a range. */
static int read_slice(const char *text, long value[3], bool given[3]) {
  int colons = 0;
  for (;; text++) {
    char *end = (char *)text;
    errno = 0;
    long number = *text == ':' || !*text ? 0 : strtol(text, &end, 10);
    given[colons] = end > text;
    if (errno != 0 || (*end && *end != ':')) return -1;
    if (given[colons]) value[colons] = number;
    text = end;
    if (!*text) return colons > 0 || given[0] ? colons : -1;
    if (++colons == 3) return -1;
  }
}

static size_t magnitude(long value) { return value < 0 ? 0 - (size_t)value : (size_t)value; }

/* Converts an end of a slice to an index in [0, n]; negative ends count from the back. */
static size_t clip(long value, size_t n) {
  size_t size = magnitude(value) < n ? magnitude(value) : n;
  return value < 0 ? n - size : size;
}

sd_status options_range(const char *text, size_t count, const char *file, option_range *out,
                        sd_messages *messages) {
  long value[3] = {0, 0, 1};
  bool given[3] = {false};
  *out = (option_range){.first = 0, .step = 1, .n = count};
  int colons = text ? read_slice(text, value, given) : 2;
  if (colons < 0 || value[2] <= 0)
    return sd_fail(messages, SD_ERROR_USER,
                   "--frames %s: expected a frame (5, -1 the last) or FIRST:END:STEP, as slices in "
                   "Python (-1:, "
                   "::10, 0:100:10), with a step of at least 1",
                   text);
  if (count == SIZE_MAX) return SD_OK;
  if (count == 0) return sd_fail(messages, SD_ERROR_USER, "%s has no frames", file);
  if (colons == 0 && magnitude(value[0]) + (value[0] >= 0) > count)
    return sd_fail(messages, SD_ERROR_USER, "--frames %s: %s has frames 0 to %zu", text, file,
                   count - 1);
  size_t first = clip(value[0], count), end = given[1] ? clip(value[1], count) : count;
  if (colons == 0) end = first + 1;
  if (end <= first)
    return sd_fail(messages, SD_ERROR_USER, "--frames %s chooses none of the frames 0 to %zu of %s",
                   text, count - 1, file);
  size_t step = (size_t)value[2];
  *out = (option_range){.first = first, .step = step, .n = (end - first - 1) / step + 1};
  return SD_OK;
}

/* Refuses an option. given: argument that getopt_long read last; argv[optind] if a letter that is
 * not its last one is unknown, as n in -np. */
static int refuse_unknown(const command_line *line, const char *given) {
  char word[64];
  if (strcmp(given, "-np") == 0 || strcmp(given, "-n") == 0)
    return app_misuse(line->name,
                      "unknown option %s; mpirun takes the number of processes: "
                      "mpirun %s 4 slipdisk %s ...",
                      given, given, line->name);
  snprintf(word, sizeof word, "%.*s", (int)strcspn(given, "="), given);
  guess near = guess_start(word + strspn(word, "-"));
  for (size_t k = 0; k < line->n; k++) {
    if (strchr(given, '=') && strcmp(near.word, line->rows[k].name) == 0)
      return app_misuse(line->name, "%s takes no value", word);
    guess_add(&near, line->rows[k].name);
  }
  if (near.best)
    return app_misuse(line->name, "unknown option %s (did you mean --%s?)", given, near.best);
  return app_misuse(line->name, "unknown option %s", given);
}

/* Returns 0 if `value` is one of the words in row->value, which has the form "a|b|c"; else prints
 * the words and the nearest one and returns the exit status. */
static int check_choice(const command_line *line, const option_row *row, const char *shown,
                        const char *value) {
  char *words = memory_text(row->value), *rest = NULL;
  guess near = guess_start(value);
  bool good = false;
  for (char *w = strtok_r(words, "|", &rest); w && !good; w = strtok_r(NULL, "|", &rest)) {
    good = strcmp(w, value) == 0;
    guess_add(&near, w);
  }
  const char *more = row->limits && !near.best ? row->limits->wrong : "";
  int status = 0;
  if (!good)
    status = app_misuse(line->name, "%s %s: expected %s%s%s%s%s", shown, value, row->value,
                        near.best ? " (did you mean " : "", near.best ? near.best : "",
                        near.best ? "?)" : "", more);
  free(words);
  return status;
}

/* Returns what would be lost if the program wrote to this path: "deck", "result", or NULL. */
static const char *lost_with(const char *path) {
  const file_kind kind = h5_kind_of(path);
  if (kind == FILE_DECK) return file_exists(path) ? "deck" : NULL;
  return kind != FILE_H5MD && h5_is_file(path) ? "result" : NULL;
}

/* Stores the value of an option in `arguments`. Returns 0; if the value is wrong, prints why and
 * returns the exit status. */
static int take(const command_line *line, const option_row *row, const char *value,
                void *arguments) {
  void *field = (char *)arguments + row->offset;
  char shown[40];
  if (row->letter)
    snprintf(shown, sizeof shown, "-%c", row->letter);
  else
    snprintf(shown, sizeof shown, "--%s", row->name);
  const char *lost;
  bool good = true;
  switch (row->kind) {
    case OPTION_FLAG: *(bool *)field = true; break;
    case OPTION_CONFINED: break; /* options_parse sees to it */
    case OPTION_NUMBER:
      good = options_number(value, row->limits->least, row->limits->most, field);
      break;
    case OPTION_REAL: {
      option_real *real = field;
      good = real->given = options_reals(value, 1, &real->value);
      break;
    }
    case OPTION_TEXT: {
      const char **text = field;
      if (*text) return app_misuse(line->name, "%s is given twice, %s and %s", shown, *text, value);
      *text = value;
      break;
    }
    case OPTION_CHOICE: *(const char **)field = value; return check_choice(line, row, shown, value);
    case OPTION_PATH:
    case OPTION_RESULT:
    case OPTION_STREAM:
      *(const char **)field = value;
      if (row->kind != OPTION_STREAM && strcmp(value, "-") == 0)
        return app_misuse(line->name,
                          "%s -: the standard output does not take this; expected a name", shown);
      if (!*value)
        return app_misuse(line->name, "%s needs the name of a file or a folder, not an empty one",
                          shown);
      lost = lost_with(value);
      if (lost && (row->kind != OPTION_RESULT || strcmp(lost, "deck") == 0))
        return app_misuse(line->name,
                          "%s %s: that is a %s, which would be lost; expected another name", shown,
                          value, lost);
      break;
    case OPTION_LIST: {
      option_list *list = field;
      list->item[list->n++] = value;
      break;
    }
  }
  return good ? 0 : app_misuse(line->name, "%s %s%s", shown, value, row->limits->wrong);
}

const char *options_words(const option_row *row) {
  if (row->kind == OPTION_LIST && row->limits) return row->limits->wrong;
  return row->kind == OPTION_CHOICE ? row->value : NULL;
}

/* Refuses a second operand, which may be the value of an option whose name was left out. */
static int refuse_second(const command_line *line, const char *word) {
  static const char *const one[] = {"one deck", "one result", "", "one command"};
  const size_t n = strlen(word);
  for (size_t k = 0; k < line->n; k++)
    for (const char *w = options_words(&line->rows[k]); w;
         w = strchr(w, '|') ? strchr(w, '|') + 1 : NULL)
      if (n > 0 && strncmp(w, word, n) == 0 && (!w[n] || w[n] == '|'))
        return app_misuse(line->name, "%s is expected, \"%s\" is a second; did you mean --%s %s?",
                          one[line->operand], word, line->rows[k].name, word);
  return app_misuse(line->name, "%s is expected, \"%s\" is a second", one[line->operand], word);
}

static int take_operand(const command_line *line, int argc, char **argv, void *arguments) {
  static const char *const missing[] = {"no deck is given", "one result is expected",
                                        "no result is given", "no command is given"};
  void *field = (char *)arguments + line->offset;
  int n = argc - optind;
  if (n == 0 && line->optional) return 0;
  if (n == 0) return app_misuse(line->name, "%s", missing[line->operand]);
  if (n > 1 && line->operand != OPERAND_RESULTS) return refuse_second(line, argv[optind + 1]);
  for (int k = optind;
       k < argc && line->operand != OPERAND_DECK && line->operand != OPERAND_COMMAND; k++)
    if (strcmp(argv[k], "-") == 0)
      return app_misuse(
          line->name, "results are not read from the standard input; expected the name of a file");
  if (line->operand == OPERAND_RESULTS)
    *(size_t *)field = (size_t)optind;
  else
    *(const char **)field = argv[optind];
  return 0;
}

/* Sets the folder of the operands as that which decks may read, for this process and those that it
 * starts. */
static int confine(const command_line *line, int argc, char **argv) {
  char *all = NULL;
  int status = 0;
  for (int k = optind; k < argc && status == 0; k++) {
    const char *slash = strrchr(argv[k], '/');
    char *folder = slash ? format_text("%.*s/", (int)(slash - argv[k]), argv[k]) : memory_text("."),
         *real = realpath(folder, NULL);
    if (!real)
      status = app_misuse(line->name, "--confined: %s: %s", folder, strerror(errno));
    else if (all && strcmp(all, real) != 0)
      status = app_misuse(line->name, "--confined: expected files of one folder, not of %s and %s",
                          all, real);
    free(folder);
    free(all);
    all = real;
  }
  if (status == 0 && all && setenv("SLIPDISK_CONFINED", all, 1) != 0) memory_lacks(strlen(all));
  free(all);
  return status;
}

int options_parse(const command_line *line, int argc, char **argv, void *arguments) {
  enum { MOST = 32, FIRST = 256 };
  bool confined = false;
  struct option options[MOST] = {{0}};
  char letters[2 * MOST + 2] = ":";
  assert(line->n < MOST);
  for (size_t k = 0; k < line->n; k++) {
    const option_row *row = &line->rows[k];
    bool value = row->kind != OPTION_FLAG && row->kind != OPTION_CONFINED;
    options[k] =
        (struct option){row->name, value ? required_argument : no_argument, NULL, FIRST + (int)k};
    if (row->letter) snprintf(letters + strlen(letters), 3, "%c%s", row->letter, value ? ":" : "");
    if (row->kind != OPTION_LIST) continue;
    option_list *list = (void *)((char *)arguments + row->offset);
    list->item = memory_new((size_t)argc, sizeof *list->item);
  }
  opterr = 0;
  for (int c; (c = getopt_long(argc, argv, letters, options, NULL)) != -1;) {
    if (c == ':') return app_misuse(line->name, "%s needs a value", argv[optind - 1]);
    if (c == '?') {
      const char *last = argv[optind - 1];
      const bool within = optopt > 0 && optopt < FIRST && !(last[0] == '-' && strchr(last, optopt));
      return refuse_unknown(line, within ? argv[optind] : last);
    }
    size_t k = c >= FIRST ? (size_t)(c - FIRST) : 0;
    while (c < FIRST && line->rows[k].letter != (char)c) k++;
    int mistake = take(line, &line->rows[k], optarg, arguments);
    if (mistake) return mistake;
    confined |= line->rows[k].kind == OPTION_CONFINED;
  }
  const int mistake = take_operand(line, argc, argv, arguments);
  return mistake || !confined ? mistake : confine(line, argc, argv);
}

/* --- help ------------------------------------------------------------------------------------- */

enum { HELP_COLUMN = 25, HELP_WIDTH = 100 };

/* Prints the words of `text`, with line breaks at blanks; all lines begin at column `column`. at:
 * number of characters that the line has already. */
static void print_words(FILE *out, const char *text, size_t at, size_t column) {
  for (const char *next; *text; text = next) {
    size_t n = strcspn(text, " ");
    next = text + n + strspn(text + n, " ");
    if (at > column && at + 1 + n > HELP_WIDTH) {
      fputc('\n', out);
      at = 0;
    }
    fprintf(out, "%*s%.*s", at < column ? (int)(column - at) : 1, "", (int)n, text);
    at = (at < column ? column : at + 1) + n;
  }
  fputc('\n', out);
}

void options_entry(FILE *out, const char *head, const char *text, size_t column) {
  size_t at = strlen(head);
  fputs(head, out);
  if (at >= column) {
    fputc('\n', out);
    at = 0;
  }
  print_words(out, text, at, column);
}

static void print_option(FILE *out, const option_row *row) {
  char head[128];
  int n = row->letter ? snprintf(head, sizeof head, "  -%c, --%s", row->letter, row->name)
                      : snprintf(head, sizeof head, "      --%s", row->name);
  if (row->value) snprintf(head + n, sizeof head - (size_t)n, " %s", row->value);
  options_entry(out, head, row->help, HELP_COLUMN);
}

void options_help(FILE *out, const command_line *line) {
  static const option_row help = {.name = "help", .letter = 'h', .help = "this page"};
  fprintf(out, "usage: slipdisk %s [options] %s\n\n%s.\n", line->name, line->operands,
          line->summary);
  if (line->more) fprintf(out, "%s", line->more);
  fputc('\n', out);
  for (size_t k = 0; k < line->n; k++) print_option(out, &line->rows[k]);
  print_option(out, &help);
  if (line->examples) fputs("\nExamples:\n", out);
  for (const char *text = line->examples; text && *text;) {
    int n = (int)strcspn(text, "\n");
    fprintf(out, "  %.*s\n", n, text);
    text += n + (text[n] == '\n');
  }
}

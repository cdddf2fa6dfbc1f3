/* theory.c: slipdisk theory DECK: what the theory says of the three disks of a deck. See docs/theory.md. */
#include <assert.h>
#include <errno.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "app/app.h"
#include "app/theory/theory.h"
#include "base/memory.h"
#include "io/store/file.h"
#include "slipdisk/deck.h"

typedef struct arguments {
  const char *deck, *csv, *wave; /* NULL: not asked for */
  bool json;
  option_list overrides;
} arguments;

static const option_row rows[] = {
    {"define", 'D', OPTION_LIST, offsetof(arguments, overrides), NULL, "PATH=VALUE",
     "set a key of the deck, as in -D gravity.tilt=0.1; may be repeated"},
    {"json", 0, OPTION_FLAG, offsetof(arguments, json), NULL, NULL, "for programs"},
    {"wave", 0, OPTION_STREAM, offsetof(arguments, wave), NULL, "FILE",
     "the curves of one period as CSV; - is the standard output"},
    {"csv", 0, OPTION_STREAM, offsetof(arguments, csv), NULL, "FILE",
     "a row per set of the sweep; - is the standard output"},
};
const command_line app_theory_line = {
    .name = "theory",
    .n = sizeof rows / sizeof *rows,
    .rows = rows,
    .operand = OPERAND_DECK,
    .offset = offsetof(arguments, deck),
    .operands = "DECK",
    .summary = "Says what theory knows of a disk on two turning supports",
    .more = "Torques, periodic states, mean rotation. A DECK of - is the standard input.\n",
    .examples = "slipdisk theory deck.cfg\n"
                "slipdisk theory deck.cfg --wave wave.csv\n"};

static int parse(int argc, char **argv, arguments *a) {
  int mistake = options_parse(&app_theory_line, argc, argv, a);
  if (mistake) return mistake;
  int taken =
      a->json + (a->csv && strcmp(a->csv, "-") == 0) + (a->wave && strcmp(a->wave, "-") == 0);
  if (taken > 1)
    return app_misuse("theory", "the standard output can take one of --json, --csv - and --wave -");
  return 0;
}

/* --- tables in files ------------------------------------------------------------------------------------ */

/* A table is made in memory and then written as a whole. */
typedef struct table {
  FILE *out;
  char *text;
  size_t size;
} table;

static void table_open(table *t) {
  *t = (table){0};
  t->out = open_memstream(&t->text, &t->size);
  if (!t->out) memory_lacks(0);
}

/* Into what is no file of its own: a device, a pipe, the standard output (path NULL). */
static sd_status pour(const table *t, const char *path, sd_messages *messages) {
  FILE *out = path ? fopen(path, "w") : stdout;
  bool good = out && fwrite(t->text, 1, t->size, out) == t->size && fflush(out) == 0;
  int why = errno;
  if (path && out) fclose(out);
  if (good) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "cannot write to %s: %s",
                 path ? path : "the standard output", strerror(why));
}

/* Writes it to path, "-" being the standard output, unless something has failed already. */
static sd_status table_close(table *t, const char *path, sd_status status, sd_messages *messages) {
  if (!t->out) return status;
  if (fclose(t->out) != 0) memory_lacks(t->size);
  struct stat what;
  if (status == SD_OK && strcmp(path, "-") == 0)
    status = pour(t, NULL, messages);
  else if (status == SD_OK && stat(path, &what) == 0 && !S_ISREG(what.st_mode) &&
           !S_ISDIR(what.st_mode))
    status = pour(t, path, messages);
  else if (status == SD_OK)
    status = file_write_atomic(path, t->text, t->size, messages);
  free(t->text);
  return status;
}

/* A point without a periodic state has empty cells, and says why. */
static sd_status add_row(const deck_sweep *s, size_t point, FILE *out, sd_messages *messages) {
  theory_case c;
  theory_result r;
  sd_model *model = NULL;
  sd_status status = deck_sweep_model(s, point, &model, messages);
  if (status == SD_OK) status = theory_case_read(model, &c, messages);
  if (status == SD_OK) {
    sd_messages *own = sd_messages_new();
    theory_case_solve(&c, &r, own);
    for (size_t k = 0; k < sd_messages_count(own); k++)
      sd_warn(messages, "%s: point %s: %s", s->deck_path, s->points[point].name,
              sd_messages_text(own, k));
    sd_messages_free(own);
    theory_table_row(out, s, point, &c, &r);
  } else if (s->n_points > 1) {
    sd_warn(messages, "%s: that was point %s", s->deck_path, s->points[point].name);
  }
  sd_model_free(model);
  return status;
}

/* A row per set of the sweep, from its first point. */
static sd_status write_csv(const arguments *a, sd_messages *messages) {
  deck_sweep s = {0};
  table t = {0};
  sd_status status = deck_sweep_load(a->deck, a->overrides.n, a->overrides.item, &s, messages);
  if (status == SD_OK) {
    table_open(&t);
    theory_table_head(t.out, &s);
  }
  size_t sets = 0;
  for (size_t k = 0; status == SD_OK && k < s.n_points; k++) {
    if (s.points[k].set != sets)
      continue; /* sets are numbered in the order of their first points */
    status = add_row(&s, k, t.out, messages);
    sets++;
  }
  status = table_close(&t, a->csv, status, messages);
  deck_sweep_free(&s);
  return status;
}

static sd_status write_wave(const arguments *a, const theory_result *r, sd_messages *messages) {
  table t;
  if (!r->solved)
    return sd_fail(messages, SD_ERROR_USER,
                   "%s: theory: there is no periodic solution to be written; expected supports "
                   "that turn to and "
                   "fro",
                   a->deck);
  table_open(&t);
  theory_wave(t.out, r);
  return table_close(&t, a->wave, SD_OK, messages);
}

/* --- the command ------------------------------------------------------------------------------------------ */

/* The page, the same for programs, or the wave: of the deck as it stands. */
static sd_status tell(const arguments *a, sd_messages *messages) {
  theory_case c;
  theory_result r;
  sd_model *model = NULL;
  sd_status status = sd_deck_load(a->deck, a->overrides.n, a->overrides.item, &model, messages);
  if (status == SD_OK) status = theory_case_read(model, &c, messages);
  if (status == SD_OK) {
    status = theory_case_solve(&c, &r, messages);
    /* without a periodic state the rest is still good */
    if (a->json && !theory_json(stdout, model, &c, &r))
      status = sd_fail(messages, SD_ERROR_IO, "cannot write to the standard output");
    if (!a->json && !a->wave) theory_page(stdout, model, &c, &r);
    if (a->wave && status == SD_OK) status = write_wave(a, &r, messages);
  }
  sd_model_free(model);
  return status;
}

int app_theory(int argc, char **argv) {
  arguments a = {0};
  sd_messages *messages = sd_messages_new();
  int status = parse(argc, argv, &a);
  if (status == 0) {
    assert(a.deck);
    if (a.csv) status = (int)write_csv(&a, messages);
    if (status == 0 && (a.json || a.wave || !a.csv)) status = (int)tell(&a, messages);
    fflush(stdout);
    sd_messages_print(messages, stderr);
  }
  sd_messages_free(messages);
  free(a.overrides.item);
  return status;
}

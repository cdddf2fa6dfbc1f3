/* measure.c: `slipdisk measure FILE` measures packings in stored frames. See docs/measure.md. */
#include "app/measure/measure.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "app/app.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/results/checkpoint.h"
#include "io/results/frames.h"
#include "model/model.h"
#include "slipdisk/deck.h"

typedef struct arguments {
  /* Operand FILE, and texts of --csv, --output and --region; NULL: not given */
  const char *name, *csv, *output, *wanted;
  bool json, all;
  /* Value of the option --frame; negative values count from the end; NO_FRAME: not given */
  long frame;
  option_real time;
  double region[4]; /* Values x0, x1, y0, y1 of the option --region */
  long bins;
  option_list bodies;
} arguments;

enum { NO_FRAME = INT32_MAX };

static const option_row rows[] = {
    {"frame", 0, OPTION_NUMBER, offsetof(arguments, frame),
     &(option_limits){-INT32_MAX, INT32_MAX - 1,
                      ": expected the number of a frame, from 0, or from the end as -1"},
     "K", "this frame, from the end as -1; by default the last state"},
    {"time", 0, OPTION_REAL, offsetof(arguments, time),
     &(option_limits){0, 0, ": expected a number"}, "T", "the frame nearest to this time"},
    {"all", 0, OPTION_FLAG, offsetof(arguments, all), NULL, NULL, "all frames, a row each"},
    {"json", 0, OPTION_FLAG, offsetof(arguments, json), NULL, NULL,
     "for programs, to the screen or into FILE of -o"},
    {"output", 'o', OPTION_STREAM, offsetof(arguments, output), NULL, "FILE",
     "for programs, into this file and not to the screen; - is the standard output"},
    {"csv", 0, OPTION_PATH, offsetof(arguments, csv), NULL, "FOLDER",
     "tables of disks, contacts, g(r), forces and means of the run, into this folder"},
    {"bins", 0, OPTION_NUMBER, offsetof(arguments, bins),
     &(option_limits){1, 100000, ": expected a whole number from 1 to 100000"}, "N",
     "bins of g(r) and forces; by default 100"},
    {"region", 0, OPTION_TEXT, offsetof(arguments, wanted), NULL, "X0,X1,Y0,Y1",
     "the part of the plane that counts; by default that of the deck"},
    {"body", 0, OPTION_LIST, offsetof(arguments, bodies), NULL, "NAME",
     "in tables of disks and contacts only this disk or wall; by name or number, many times"},
    CONFINED_OPTION,
};
const command_line app_measure_line = {
    .name = "measure",
    .n = sizeof rows / sizeof *rows,
    .rows = rows,
    .operand = OPERAND_RESULT,
    .offset = offsetof(arguments, name),
    .operands = "FILE",
    .summary = "Measures a packing: contacts, packing fractions, stress, fabric, forces",
    .more = "Of the last state, or of stored frames.\n",
    .examples = "slipdisk measure deck.h5                # of the last state\n"
                "slipdisk measure deck.h5 --all --csv tables\n"};

static int parse(int argc, char **argv, arguments *a) {
  int mistake = options_parse(&app_measure_line, argc, argv, a);
  if (mistake) return mistake;
  double *g = a->region;
  if (a->wanted && !(options_reals(a->wanted, 4, g) && g[0] < g[1] && g[2] < g[3]))
    return app_misuse("measure", "--region %s: expected x0,x1,y0,y1 with x0 < x1 and y0 < y1",
                      a->wanted);
  if (a->bodies.n > 0 && !a->csv)
    return app_misuse("measure",
                      "--body chooses rows of the tables; expected --csv FOLDER with it");
  if ((a->frame != NO_FRAME) + a->time.given + a->all > 1)
    return app_misuse("measure", "one of --frame, --time and --all is expected");
  return 0;
}

/* --- choice of frames ------------------------------------------------------------------------- */

/* Selects the frames first ... last - 1 by the options. Frame number f->n stands for the state at
 * the end of the run. */
static sd_status choose(const arguments *a, const frames *f, bool alone, size_t *first,
                        size_t *last, sd_messages *messages) {
  const bool numbered = a->frame != NO_FRAME;
  const bool wanted = numbered || a->time.given || a->all;
  const int64_t frame = a->frame < 0 ? (int64_t)f->n + a->frame : a->frame;
  if (f->n == 0 && (alone || (wanted && !a->all)))
    return sd_fail(messages, SD_ERROR_USER, "%s: no frames are stored in it%s", a->name,
                   alone ? "" : "; without --frame and --time its last state is measured");
  if (numbered && (frame < 0 || (size_t)frame >= f->n))
    return sd_fail(messages, SD_ERROR_USER, "%s: frame %ld: there are 0 to %zu", a->name, a->frame,
                   f->n - 1);
  if (a->all) {
    *first = 0;
    return stored_count(f, alone, last, messages);
  }
  *first = numbered ? (size_t)frame : f->n - alone;
  sd_status status = a->time.given ? frames_nearest(f, a->time.value, first, messages) : SD_OK;
  if (alone && *first == f->n) *first = f->n - 1;
  *last = *first + 1;
  return status;
}

/* --- choice of bodies ------------------------------------------------------------------------- */

/* Sets wanted[] to true for all bodies with the name `word`. If there are none, reads `word` as the
 * number of a body (disks first, then walls). */
static sd_status choose_body(const char *word, const sd_model *m, bool *wanted,
                             sd_messages *messages) {
  guess near = guess_start(word);
  size_t n = sd_model_bodies(m);
  bool any = false;
  long number;
  for (size_t k = 0; k < n; k++) {
    const char *name = k < m->n_disks ? m->disks[k].name : m->walls[k - m->n_disks].name;
    bool same = name && strcmp(name, word) == 0;
    guess_add(&near, name);
    wanted[k] = wanted[k] || same;
    any = any || same;
  }
  if (any) return SD_OK;
  if (options_number(word, 0, (long)n - 1, &number)) {
    wanted[number] = true;
    return SD_OK;
  }
  return sd_fail(
      messages, SD_ERROR_USER,
      "--body %s: no disk or wall is called that%s%s%s; numbers are 0 to %zu, disks first", word,
      near.best ? " (did you mean " : "", near.best ? near.best : "", near.best ? "?)" : "", n - 1);
}

/* Allocates *wanted, true for the bodies of the options --body; *wanted = NULL: all bodies. The
 * caller frees it. */
static sd_status choose_bodies(const arguments *a, const sd_model *m, bool **wanted,
                               sd_messages *messages) {
  *wanted = NULL;
  if (a->bodies.n == 0) return SD_OK;
  if (!memory_row(wanted, sd_model_bodies(m), sizeof **wanted))
    return sd_fail(messages, SD_ERROR_IO, "no memory");
  sd_status status = SD_OK;
  for (size_t k = 0; k < a->bodies.n; k++)
    if (choose_body(a->bodies.item[k], m, *wanted, messages) != SD_OK) status = SD_ERROR_USER;
  return status;
}

/* --- output of frames ------------------------------------------------------------------------- */

typedef struct sinks {
  bool page, rows, recomputed;
  measure_list *list; /* Output file for JSON; NULL: no JSON output */
  measure_tables *tables;
} sinks;

static void tell(sinks *s, const measurement *m) {
  if (s->tables) measure_tables_add(s->tables, m);
  if (s->rows)
    measure_row(stdout, m);
  else if (s->page)
    measure_page(stdout, m);
  s->recomputed = s->recomputed || m->c.recomputed;
  if (s->list) measure_list_add(s->list, m);
}

static sd_status measure_frames(const arguments *a, const frames *f, size_t first, size_t last,
                                sinks *s, sd_messages *messages) {
  sd_status status = SD_OK;
  if (s->rows) measure_rows_head(stdout);
  for (size_t k = first; status == SD_OK && k < last; k++) {
    frame_data frame;
    measurement m = {.file = a->name, .frame = k < f->n ? (int64_t)k : -1};
    status = frames_read(f, k, &frame, messages);
    if (status == SD_OK)
      status = measurement_new(&m, f->constants, &frame, a->wanted ? a->region : NULL,
                               (size_t)a->bins, messages);
    if (status == SD_OK) tell(s, &m);
    measurement_free(&m);
    frame_data_free(&frame);
  }
  if (status == SD_OK && s->rows && s->recomputed)
    printf("* contacts were not stored: found again from positions and velocities\n");
  return status;
}

/* Writes time averages over the run to CSV files; they do not depend on the selected frames. */
static sd_status write_means(const arguments *a, const frames *f, const bool *wanted,
                             sd_messages *messages) {
  summary s;
  sd_status status = summary_read(&s, f->base, messages);
  if (status == SD_OK) status = summary_disks_read_all(&s.packing, f->base, messages);
  if (status == SD_OK)
    status = checkpoint_complete(f->base, f->path, f->constants, sd_deck_load_text, &s.packing,
                                 messages);
  if (status == SD_OK)
    status = measure_tables_means(a->csv, f->constants->n_disks, wanted, &s, messages);
  summary_free(&s);
  return status;
}

static sd_status measure(const arguments *a, sd_messages *messages) {
  frames f = {0};
  bool *wanted = NULL;
  bool alone;
  size_t first = 0, last = 0;
  sd_status status = stored_open(&f, a->name, &alone, messages);
  if (status == SD_OK) status = choose(a, &f, alone, &first, &last, messages);
  if (status == SD_OK) status = choose_bodies(a, f.constants, &wanted, messages);
  if (status != SD_OK) {
    free(wanted);
    frames_close(&f);
    return status;
  }
  measure_tables tables = {0};
  measure_list list = {0};
  bool quiet = a->json || a->output, file = a->output && strcmp(a->output, "-") != 0;
  sinks s = {.page = !quiet, .rows = !quiet && a->all, .list = quiet ? &list : NULL};
  if (quiet) status = measure_list_open(&list, a->name, f.n, file ? a->output : NULL, messages);
  if (status == SD_OK && a->csv) {
    s.tables = &tables;
    status = measure_tables_open(&tables, a->csv, wanted, messages);
  }
  if (status == SD_OK) status = measure_frames(a, &f, first, last, &s, messages);
  if (a->csv) status = measure_tables_close(&tables, status, messages);
  if (a->csv && status == SD_OK) status = write_means(a, &f, wanted, messages);
  if (quiet) status = measure_list_close(&list, status, messages);
  free(wanted);
  frames_close(&f);
  return status;
}

int app_measure(int argc, char **argv) {
  arguments a = {.frame = NO_FRAME, .bins = 100};
  int mistake = parse(argc, argv, &a);
  if (mistake) {
    free(a.bodies.item);
    return mistake;
  }
  sd_messages *messages = sd_messages_new();
  sd_status status = measure(&a, messages);
  fflush(stdout);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  free(a.bodies.item);
  return (int)status;
}

/* run.c: `slipdisk run DECK` and `slipdisk resume FILE`. */
#include <assert.h>
#include <stddef.h>
#include <stdlib.h>

#include "app/app.h"
#include "base/comm.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/deck/deck.h"
#include "io/results/checkpoint.h"
#include "io/store/file.h"
#include "run/ranks.h"
#include "run/simulation_private.h"
#include "slipdisk/deck.h"

typedef struct arguments {
  const char *deck, *output;
  option_list overrides;
  drive_options drive;
} arguments;

static const option_row rows[] = {
    {"output", 'o', OPTION_RESULT, offsetof(arguments, output), NULL, "FILE",
     "the result; by default NAME.h5 in the current folder for a deck NAME.cfg"},
    {"define", 'D', OPTION_LIST, offsetof(arguments, overrides), NULL, "PATH=VALUE",
     "set a key of the deck, as in -D gravity.tilt=0.1; may be repeated"},
    {"force", 0, OPTION_FLAG, offsetof(arguments, drive.force), NULL, NULL,
     "begin anew, and replace a result that is finished"},
    DRIVE_OPTIONS(arguments, drive),
};
const command_line app_run_line = {.name = "run",
                                   .n = sizeof rows / sizeof *rows,
                                   .rows = rows,
                                   .operand = OPERAND_DECK,
                                   .offset = offsetof(arguments, deck),
                                   .operands = "DECK",
                                   .summary = "Runs a deck",
                                   .more = "A run that was stopped or killed continues from its "
                                           "last checkpoint when the same command is given\n"
                                           "again. A DECK of - is the standard input.\n",
                                   .examples = "slipdisk run deck.cfg                   # makes "
                                               "deck.h5; given again after a stop it continues\n"
                                               "slipdisk run deck.cfg -D seed=2 -o two.h5\n"};

int app_run(int argc, char **argv) {
  app_catch_signals();
  arguments a = {0};
  sd_messages *messages = sd_messages_new();
  sd_model *model = NULL;
  char *output = NULL, *again = NULL;
  int status = options_parse(&app_run_line, argc, argv, &a);
  if (status == 0) status = drive_begin(&a.drive, messages);
  if (status == 0) {
    assert(a.deck);
    output = a.output ? memory_text(a.output) : app_default_name(a.deck, "h5");
    again = format_text("resume %s", output);
    status = comm_world()
                 ? ranks_load(comm_world(), NULL, a.deck, a.overrides.n, a.overrides.item, &model,
                              messages)
                 : deck_load_run(a.deck, a.overrides.n, a.overrides.item, &model, messages);
    status = drive_agree(status, messages);
    if (status == SD_OK && comm_rank(comm_world()) == 0 && sd_model_deck(model)->sweep_points > 0)
      sd_warn(messages,
              "%s has a sweep of %zu point%s, which `slipdisk sweep` runs; this is the deck as it "
              "stands",
              a.deck, sd_model_deck(model)->sweep_points,
              sd_model_deck(model)->sweep_points == 1 ? "" : "s");
  }
  if (status == 0) {
    a.drive.result = output;
    a.drive.again = again;
    status = drive_run(model, &a.drive, messages);
  }
  free(output);
  free(again);
  free(a.overrides.item);
  sd_model_free(model);
  sd_messages_free(messages);
  comm_end();
  return status;
}

/* --- slipdisk resume FILE: the deck comes from the checkpoint --------------------------------- */

typedef struct resume_arguments {
  const char *name;
  drive_options drive;
} resume_arguments;

static const option_row resume_rows[] = {DRIVE_OPTIONS(resume_arguments, drive)};
const command_line app_resume_line = {
    .name = "resume",
    .n = sizeof resume_rows / sizeof *resume_rows,
    .rows = resume_rows,
    .operand = OPERAND_RESULT,
    .offset = offsetof(resume_arguments, name),
    .operands = "FILE",
    .summary = "Continues a run from what it has stored",
    .more = "FILE is the name of the result, its folder FILE.parts, or a "
            "checkpoint in it. The deck is not needed.\n",
    .examples =
        "slipdisk resume deck.h5                 # without the deck, with all keys that it had\n"};

/* Finds the run called `name` and reads its deck from a checkpoint; called on rank 0 only. *found:
 * true if the run is unfinished, that is, its folder RESULT.parts exists. */
static sd_status find_origin(const char *name, place *p, provenance *origin, bool *found,
                             sd_messages *messages) {
  h5_file *file = NULL;
  char *checkpoint = NULL;
  sd_status status = place_find(p, name, messages);
  *found = status == SD_OK && file_is_folder(p->folder);
  if (status == SD_OK && !*found) return place_check_finished(p, messages);
  if (!*found) return status;
  status = place_open_checkpoint(p, &file, &checkpoint, messages);
  if (status == SD_OK) status = checkpoint_check_format(file, checkpoint, messages);
  if (status == SD_OK) provenance_read(origin, file);
  h5_close(file, NULL);
  free(checkpoint);
  return status;
}

static int resume(const char *name, drive_options *drive, sd_messages *messages) {
  const comm *c = comm_world();
  const bool leads = comm_rank(c) == 0;
  place p = {0};
  provenance origin = {0};
  sd_model *model = NULL;
  bool found = false;
  int status =
      drive_agree(leads ? find_origin(name, &p, &origin, &found, messages) : SD_OK, messages);
  comm_broadcast(c, &found, sizeof found);
  if (status == SD_OK && !found && !drive->quiet && leads)
    app_line(stderr, "%s is finished already", p.result);
  if (status == SD_OK && found)
    status = drive_agree(simulation_model_of(c, &origin, &model, messages), messages);
  if (status == SD_OK && found) {
    char *result = comm_text(c, p.result), *again = format_text("resume %s", result);
    drive->result = result;
    drive->again = again;
    status = drive_run(model, drive, messages);
    free(result);
    free(again);
  }
  sd_model_free(model);
  provenance_free(&origin);
  place_free(&p);
  return status;
}

int app_resume(int argc, char **argv) {
  app_catch_signals();
  resume_arguments a = {0};
  int status = options_parse(&app_resume_line, argc, argv, &a);
  if (status != 0) return status;
  sd_messages *messages = sd_messages_new();
  status = drive_begin(&a.drive, messages);
  if (status == SD_OK) status = resume(a.name, &a.drive, messages);
  comm_end();
  sd_messages_free(messages);
  return status;
}

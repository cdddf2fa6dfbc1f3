/* run.c: slipdisk run DECK. */
#include <assert.h>
#include <stddef.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/memory.h"
#include "base/text.h"
#include "app/app.h"
#include "run/ranks_first.h"
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
const command_line app_run_line = {
    .name = "run",
    .n = sizeof rows / sizeof *rows,
    .rows = rows,
    .operand = OPERAND_DECK,
    .offset = offsetof(arguments, deck),
    .operands = "DECK",
    .summary = "Runs a deck",
    .more =
        "A run that was stopped or killed continues from its last checkpoint when the same command is given\n"
        "again. A DECK of - is the standard input.\n",
    .examples =
        "slipdisk run deck.cfg                   # makes deck.h5; given again after a stop it continues\n"
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
                 ? ranks_load(comm_world(), NULL, a.deck, a.overrides.n, a.overrides.item, &model, messages)
                 : sd_deck_load(a.deck, a.overrides.n, a.overrides.item, &model, messages);
    status = drive_agree(status, messages);
    if (status == SD_OK && comm_rank(comm_world()) == 0 && sd_model_deck(model)->sweep_points > 0)
      sd_warn(messages,
              "%s has a sweep of %zu point%s, which `slipdisk sweep` runs; this is the deck as it stands",
              a.deck, sd_model_deck(model)->sweep_points, sd_model_deck(model)->sweep_points == 1 ? "" : "s");
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

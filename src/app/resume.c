/* resume.c: slipdisk resume FILE: the deck comes from the checkpoint. */
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/comm.h"
#include "base/text.h"
#include "app/app.h"
#include "io/results/checkpoint.h"
#include "io/store/file.h"
#include "run/ranks_suit.h"
#include "run/simulation_private.h"

typedef struct arguments {
  const char *name;
  drive_options drive;
} arguments;

static const option_row rows[] = {DRIVE_OPTIONS(arguments, drive)};
const command_line app_resume_line = {
    .name = "resume",
    .n = sizeof rows / sizeof *rows,
    .rows = rows,
    .operand = OPERAND_RESULT,
    .offset = offsetof(arguments, name),
    .optional = false,
    .operands = "FILE",
    .summary = "Continues a run from what it has stored",
    .more = "FILE is the name of the result, its folder FILE.parts, or a "
            "checkpoint in it. The deck is not needed.\n",
    .examples = "slipdisk resume deck.h5                 # without the deck, with all keys that it had\n"};

static int resume(const char *name, drive_options *drive, sd_messages *messages) {
  place p;
  h5_file *file = NULL;
  char *checkpoint = NULL, *again = NULL;
  provenance origin = {0};
  sd_model *model = NULL;
  sd_status status = place_find(&p, name, messages);
  if (status == SD_OK && !file_is_folder(p.folder)) {
    if (!drive->quiet && comm_rank(comm_world()) == 0) app_line(stderr, "%s is finished already", p.result);
    place_free(&p);
    return SD_OK;
  }
  const bool leads = comm_rank(comm_world()) == 0;
  if (status == SD_OK && leads) status = place_open_checkpoint(&p, &file, &checkpoint, messages);
  if (status == SD_OK && leads) status = checkpoint_check_format(file, checkpoint, messages);
  if (status == SD_OK && leads) provenance_read(&origin, file);
  h5_close(file, NULL);
  if (status == SD_OK && leads)
    status = simulation_model_of(&origin, comm_world() ? ranks_suit : NULL, &model, messages);
  status = drive_agree(status, messages);
  if (status == SD_OK) {
    again = format_text("resume %s", p.result);
    drive->result = p.result;
    drive->again = again;
    status = drive_run(model, drive, messages);
  }
  sd_model_free(model);
  provenance_free(&origin);
  place_free(&p);
  free(checkpoint);
  free(again);
  return status;
}

int app_resume(int argc, char **argv) {
  app_catch_signals();
  arguments a = {0};
  int status = options_parse(&app_resume_line, argc, argv, &a);
  if (status != 0) return status;
  sd_messages *messages = sd_messages_new();
  status = drive_begin(&a.drive, messages);
  if (status == SD_OK) status = resume(a.name, &a.drive, messages);
  comm_end();
  sd_messages_free(messages);
  return status;
}

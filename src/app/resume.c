/* resume.c: slipdisk resume FILE: the deck comes from the checkpoint. */
#include <stddef.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/text.h"
#include "app/app.h"
#include "io/results/checkpoint.h"
#include "io/store/file.h"
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
    .operands = "FILE",
    .summary = "Continues a run from what it has stored",
    .more = "FILE is the name of the result, its folder FILE.parts, or a "
            "checkpoint in it. The deck is not needed.\n",
    .examples = "slipdisk resume deck.h5                 # without the deck, with all keys that it had\n"};

/* Rank 0 alone looks for the deck of a run. *found: the run is not finished. */
static sd_status find_origin(const char *name, place *p, provenance *origin, bool *found,
                             sd_messages *messages) {
  h5_file *file = NULL;
  char *checkpoint = NULL;
  sd_status status = place_find(p, name, messages);
  *found = status == SD_OK && file_is_folder(p->folder);
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
  int status = drive_agree(leads ? find_origin(name, &p, &origin, &found, messages) : SD_OK, messages);
  comm_share(c, &found, sizeof found);
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

/* view.c: slipdisk view FILE|DECK: a page that shows a run. */
#include "app/view.h"

#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "io/store/file.h"

static const option_row rows[] = {
    {"output", 'o', OPTION_PATH, offsetof(view_options, output), 0, 0, NULL, "PAGE.html",
     "the page; by default NAME.html in the current folder"},
    {"open", 0, OPTION_FLAG, offsetof(view_options, open), 0, 0, NULL, NULL, "open it in the browser"},
    {"frames", 0, OPTION_TEXT, offsetof(view_options, frames), 0, 0, NULL, "RANGE",
     "frames, as slices in Python: 5, -1:, ::10; by default at most 500, evenly chosen"},
};
const command_line app_view_line = {.name = "view",
                                    .n = sizeof rows / sizeof *rows,
                                    .rows = rows,
                                    .operand = OPERAND_RESULT,
                                    .offset = offsetof(view_options, name),
                                    .optional = false,
                                    .operands = "FILE|DECK",
                                    .summary = "Makes a page that shows a run in a browser",
                                    .more = "The page needs nothing beside it, and no network.\n",
                                    .examples = "slipdisk view deck.h5            # makes deck.html\n"
                                                "slipdisk view deck.h5 --open     # and opens it\n"
                                                "slipdisk view deck.h5 --frames -1: -o last.html\n"};

int app_view(int argc, char **argv) {
  view_options o = {0};
  sd_messages *messages = app_messages();
  char *path = NULL;
  int status = options_parse(&app_view_line, argc, argv, &o);
  if (status == SD_OK) status = (int)view_file(&o, &path, messages);
  if (status == SD_OK) app_line(stdout, "page: %s (%.3g MB)", path, (double)file_size(path) / 1e6);
  fflush(stdout);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  free(o.overrides.item);
  free(path);
  return status;
}

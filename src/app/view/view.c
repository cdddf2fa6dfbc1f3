/* view.c: slipdisk view FILE|DECK: a page that shows a run. */
#include "app/view/view.h"

#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "base/text.h"
#include "io/store/file.h"
#include "io/store/h5.h"

static const option_row rows[] = {
    {"output", 'o', OPTION_PATH, offsetof(view_options, output), NULL, "PAGE.html",
     "the page; by default NAME.html in the current folder, of a deck NAME.start.html"},
    {"open", 0, OPTION_FLAG, offsetof(view_options, open), NULL, NULL, "open it in the browser"},
    {"frames", 0, OPTION_TEXT, offsetof(view_options, frames), NULL, "RANGE",
     "frames of a FILE, as slices in Python: 5, -1:, ::10; by default at most 501, evenly chosen"},
    {"define", 'D', OPTION_LIST, offsetof(view_options, overrides), NULL, "PATH=VALUE",
     "set a key of the DECK, as in -D gravity.tilt=0.1; may be repeated"},
    {"live", 0, OPTION_FLAG, offsetof(view_options, live), NULL, NULL,
     "run the DECK in memory, and show it as it goes, at the address that is printed"},
    {"threads", 0, OPTION_NUMBER, offsetof(view_options, threads),
     &(option_limits){1, 4096, " is not a number of threads"}, "N",
     "threads of the run; by default as many as the number of disks is worth"},
};
const command_line app_view_line = {
    .name = "view",
    .n = sizeof rows / sizeof *rows,
    .rows = rows,
    .operand = OPERAND_RESULT,
    .offset = offsetof(view_options, name),
    .operands = "FILE|DECK",
    .summary = "Makes a page that shows a run in a browser",
    .more = "Of a DECK it shows how it begins, with all bodies that overlap. "
            "The page needs nothing beside it, and\n"
            "no network.\n",
    .examples = "slipdisk view deck.h5   # makes deck.html\n"
                "slipdisk view deck.h5 --frames=-1: -o last.html   # the last frame\n"
                "slipdisk view deck.cfg   # how the deck begins: deck.start.html\n"
                "slipdisk view deck.h5 --open   # in the browser\n"
                "slipdisk view deck.cfg --live   # runs it, and shows it as it goes\n"};

/* A result, its folder or a checkpoint; anything else is read as a deck. */
static bool is_result(const char *name) {
  char *parts = format_text("%s.parts", name);
  const bool folder = file_is_folder(name) || file_is_folder(parts);
  free(parts);
  return folder || text_ends(name, ".h5") || h5_is_file(name);
}

static bool is_same(const char *a, const char *b) {
  struct stat one, two;
  return stat(a, &one) == 0 && stat(b, &two) == 0 && one.st_dev == two.st_dev && one.st_ino == two.st_ino;
}

sd_status view_open(const char *path, sd_messages *messages) {
  extern char **environ;
  char *const words[] = {"xdg-open", (char *)path, NULL};
  pid_t child;
  int trouble = posix_spawnp(&child, words[0], NULL, NULL, words, environ), how = 0;
  if (trouble == ENOENT) {
    sd_warn(messages, "--open: there is no xdg-open here (package xdg-utils); open %s in a browser", path);
    return SD_OK;
  }
  if (trouble != 0)
    return sd_fail(messages, SD_ERROR_IO, "--open: cannot start xdg-open: %s", strerror(trouble));
  while (waitpid(child, &how, 0) < 0 && errno == EINTR) continue;
  if (!WIFEXITED(how) || WEXITSTATUS(how) != 0)
    sd_warn(messages, "--open: xdg-open has found no browser; open %s in one", path);
  return SD_OK;
}

static sd_status view(const view_options *o, sd_messages *messages) {
  char *path = NULL;
  bool result = is_result(o->name), made = false;
  if (o->live && (result || o->output || o->frames))
    return (sd_status)app_misuse("view",
                                 result ? "--live runs a deck; %s is a result"
                                        : "--live of %s writes no page: no -o and no --frames",
                                 o->name);
  if (o->live) return view_live(o, messages);
  if (o->threads > 0) return (sd_status)app_misuse("view", "--threads: nothing is run without --live");
  if (result && o->overrides.n > 0)
    return (sd_status)app_misuse("view", "-D sets keys of a deck; %s is a result", o->name);
  if (!result && o->frames) return (sd_status)app_misuse("view", "--frames: %s is no result", o->name);
  if (o->output && is_same(o->name, o->output))
    return (sd_status)app_misuse("view", "-o %s would replace what is to be shown", o->output);
  sd_status status = result ? view_file(o, &path, &made, messages) : view_deck(o, &path, &made, messages);
  if (made) app_line(stdout, "page: %s (%.3g MB)", path, (double)file_size(path) / 1e6);
  if (made && o->open) {
    fflush(stdout);
    sd_status opened = view_open(path, messages);
    if (status == SD_OK) status = opened;
  }
  free(path);
  return status;
}

int app_view(int argc, char **argv) {
  view_options o = {0};
  sd_messages *messages = sd_messages_new();
  signal(SIGXFSZ, SIG_IGN); /* a limit of file sizes is an error of a write */
  int status = options_parse(&app_view_line, argc, argv, &o);
  if (status == SD_OK) status = (int)view(&o, messages);
  fflush(stdout);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  free(o.overrides.item);
  return status;
}

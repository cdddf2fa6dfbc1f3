/* view.c: `slipdisk view FILE|DECK` makes an HTML page that shows a run. */
#include "app/view/view.h"

#include <inttypes.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/team.h"
#include "base/text.h"
#include "io/deck/deck.h"
#include "io/store/file.h"
#include "io/store/h5.h"
#include "slipdisk/deck.h"

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
    CONFINED_OPTION,
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

/* True if `name` is a result, its folder of part files, or a checkpoint; anything else is read as a
 * deck. */
static bool is_result(const char *name) {
  char *parts = format_text("%s.parts", name);
  const bool folder = file_is_folder(name) || file_is_folder(parts);
  free(parts);
  const file_kind kind = h5_kind_of(name);
  return folder || kind == FILE_HDF5 || kind == FILE_H5MD;
}

static bool is_same(const char *a, const char *b) {
  struct stat one, two;
  return stat(a, &one) == 0 && stat(b, &two) == 0 && one.st_dev == two.st_dev &&
         one.st_ino == two.st_ino;
}

/* --- slipdisk view DECK --live: runs a deck in memory and shows it, without files ------------- */

/* Approximate wall time in s of the steps between two calls of live_look. */
static const double PIECE_SECONDS = 0.03;

/* Writes an HTML page that redirects to `address`. Only this user can read the page; an address on
 * the command line of the browser would be visible to all. Returns the path of the page, which the
 * caller removes and frees; NULL: the page could not be written. */
static char *make_page(const char *address, sd_messages *messages) {
  const char *folder = getenv("XDG_RUNTIME_DIR");
  char *path = format_text("%s/slipdisk-XXXXXX.html", folder && *folder ? folder : "/tmp");
  int fd = mkstemps(path, 5);
  bool good =
      fd >= 0 && dprintf(fd, "<meta http-equiv=\"refresh\" content=\"0;url=%s\">\n", address) > 0;
  if (fd >= 0) close(fd);
  if (good) return path;
  sd_warn(messages, "--open: cannot write %s; open the address in a browser", path);
  free(path);
  return NULL;
}

static void wait_for_end(void) {
  const struct timespec nap = {.tv_nsec = 100000000};
  while (!app_stop) nanosleep(&nap, NULL);
}

static sd_status run(sd_simulation *s, live *l, sd_messages *messages) {
  sd_status status = SD_OK;
  live_look(l, s);
  for (int64_t piece = 1; status == SD_OK && !app_stop && !sd_simulation_finished(s);) {
    double start = clock_seconds();
    status = sd_simulation_advance(s, piece, messages);
    double took = clock_seconds() - start;
    live_look(l, s);
    if (took > 2 * PIECE_SECONDS && piece > 1)
      piece /= 2;
    else if (took < PIECE_SECONDS / 2 && piece < INT64_MAX / 4)
      piece *= 2;
  }
  return status;
}

static sd_status show(const view_options *o, const sd_model *model, sd_simulation *s,
                      sd_messages *messages) {
  live *l;
  sd_status status = live_open(model, o->name, &l, messages);
  if (status != SD_OK) return status;
  fprintf(stderr, "live: %s\n", live_address(l));
  char *page = o->open ? make_page(live_address(l), messages) : NULL;
  if (page) status = view_open(page, messages);
  sd_messages_print(messages, stderr);
  sd_messages_clear(messages);
  if (status == SD_OK) status = run(s, l, messages);
  bool stopped = app_stop;
  if (!stopped) {
    sd_messages_print(messages, stderr);
    sd_messages_clear(messages);
    fprintf(stderr, "%s at step %" PRId64 "; the page stays until Ctrl-C\n",
            status == SD_OK ? "the run has come to its end" : "the run has failed",
            sd_simulation_step(s));
    wait_for_end();
  }
  if (page) unlink(page);
  free(page);
  live_close(l);
  return status == SD_OK && stopped ? SD_INTERRUPTED : status;
}

static sd_status view_live(const view_options *o, sd_messages *messages) {
  sd_model *model = NULL;
  sd_simulation *s = NULL;
  app_catch_signals();
  sd_status status = deck_load_run(o->name, o->overrides.n, o->overrides.item, &model, messages);
  if (status == SD_OK) {
    sd_model_advise(model, messages);
    status = sd_simulation_new(model, (int)o->threads, &s, messages);
  }
  app_begin_saving(); /* A signal only sets app_stop after this */
  if (status == SD_OK) status = show(o, model, s, messages);
  sd_simulation_free(s);
  sd_model_free(model);
  return status;
}

/* --- command ---------------------------------------------------------------------------------- */

static bool is_film(const char *path) { return text_ends(path, ".mp4") || text_ends(path, ".gif"); }

/* Returns true if the name is that of a picture or film. */
static bool is_picture(const char *path) {
  static const char *const endings[] = {".png", ".svg", ".pdf", ".jpg", ".jpeg"};
  bool found = is_film(path);
  for (size_t k = 0; k < sizeof endings / sizeof *endings; k++)
    found = found || text_ends(path, endings[k]);
  return found;
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
  if (o->threads > 0)
    return (sd_status)app_misuse("view", "--threads: nothing is run without --live");
  if (result && o->overrides.n > 0)
    return (sd_status)app_misuse("view", "-D sets keys of a deck; %s is a result", o->name);
  if (!result && o->frames)
    return (sd_status)app_misuse("view", "--frames: %s is no result", o->name);
  if (o->output && is_picture(o->output))
    return (sd_status)app_misuse(
        "view", "-o %s: a page is HTML; expected a name that ends in .html (pictures: slipdisk %s)",
        o->output, is_film(o->output) ? "film" : "plot");
  if (o->output && is_same(o->name, o->output))
    return (sd_status)app_misuse("view", "-o %s would replace what is to be shown", o->output);
  sd_status status =
      result ? view_file(o, &path, &made, messages) : view_deck(o, &path, &made, messages);
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
  signal(SIGXFSZ, SIG_IGN); /* write then fails where a file-size limit is exceeded */
  int status = options_parse(&app_view_line, argc, argv, &o);
  if (status == SD_OK) status = (int)view(&o, messages);
  fflush(stdout);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  free(o.overrides.item);
  return status;
}

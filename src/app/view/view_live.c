/* view_live.c: slipdisk view DECK --live: runs a deck in memory and shows it. Nothing is written. */
#include <inttypes.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#include "app/view/live.h"
#include "app/view/view.h"
#include "base/clock.h"
#include "base/text.h"
#include "slipdisk/deck.h"

/* Steps are taken in pieces of about this much time. */
static const double PIECE_SECONDS = 0.03;

/* A page that leads to the address, for the eyes of this user alone: others can read command lines. To be removed and freed;
 * NULL: there is none. */
static char *make_page(const char *address, sd_messages *messages) {
  const char *folder = getenv("XDG_RUNTIME_DIR");
  char *path = format_text("%s/slipdisk-XXXXXX.html", folder && *folder ? folder : "/tmp");
  int fd = mkstemps(path, 5);
  bool good = fd >= 0 && dprintf(fd, "<meta http-equiv=\"refresh\" content=\"0;url=%s\">\n", address) > 0;
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

static sd_status show(const view_options *o, const sd_model *model, sd_simulation *s, sd_messages *messages) {
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
            status == SD_OK ? "the run has come to its end" : "the run has failed", sd_simulation_step(s));
    wait_for_end();
  }
  if (page) unlink(page);
  free(page);
  live_close(l);
  return status == SD_OK && stopped ? SD_INTERRUPTED : status;
}

sd_status view_live(const view_options *o, sd_messages *messages) {
  sd_model *model = NULL;
  sd_simulation *s = NULL;
  app_catch_signals();
  sd_status status = sd_deck_load(o->name, o->overrides.n, o->overrides.item, &model, messages);
  if (status == SD_OK) {
    sd_model_advise(model, messages);
    status = sd_simulation_new(model, (int)o->threads, &s, messages);
  }
  app_begin_saving(); /* from here on a signal ends it in order */
  if (status == SD_OK) status = show(o, model, s, messages);
  sd_simulation_free(s);
  sd_model_free(model);
  return status;
}

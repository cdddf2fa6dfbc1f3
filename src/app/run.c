/* run.c: slipdisk run DECK. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "app/app.h"
#include "io/store/file.h"
#include "slipdisk/deck.h"

typedef struct arguments {
  const char *deck, *output;
  size_t n_overrides;
  const char **overrides;
  drive_options drive;
} arguments;

enum { FORCE = 256, QUIET, THREADS, LOG };

/* Returns 0, or the exit status of a mistake. */
static int parse(int argc, char **argv, arguments *a) {
  static const struct option options[] = {
      {"output", required_argument, NULL, 'o'},
      {"define", required_argument, NULL, 'D'},
      {"force", no_argument, NULL, FORCE},
      {"quiet", no_argument, NULL, QUIET},
      {"threads", required_argument, NULL, THREADS},
      {"log", required_argument, NULL, LOG},
      {NULL, 0, NULL, 0},
  };
  opterr = 0;
  int mistake = 0;
  for (int c; mistake == 0 && (c = getopt_long(argc, argv, ":o:D:", options, NULL)) != -1;) {
    long n;
    switch (c) {
      case 'o': mistake = app_path("run", "-o", optarg, &a->output); break;
      case 'D': a->overrides[a->n_overrides++] = optarg; break;
      case FORCE: a->drive.force = true; break;
      case QUIET: a->drive.quiet = true; break;
      case LOG: mistake = app_path("run", "--log", optarg, &a->drive.log); break;
      case THREADS:
        if (!app_number(optarg, 1, 4096, &n))
          return app_misuse("run", "--threads %s is not a number of threads", optarg);
        a->drive.threads = (int)n;
        break;
      case ':': return app_misuse("run", "%s needs a value", argv[optind - 1]);
      default: return app_unknown_option("run", options, argv[optind - 1]);
    }
  }
  if (mistake) return mistake;
  if (optind >= argc) return app_misuse("run", "no deck is given");
  if (optind + 1 < argc)
    return app_misuse("run", "one deck is expected, \"%s\" is a second", argv[optind + 1]);
  a->deck = argv[optind];
  return 0;
}

int app_run(int argc, char **argv) {
  app_catch_signals();
  arguments a = {.overrides = calloc((size_t)argc + 1, sizeof *a.overrides)};
  sd_messages *messages = app_messages();
  sd_model *model = NULL;
  char *output = NULL, *again = NULL;
  int status = a.overrides ? parse(argc, argv, &a) : app_no_memory();
  if (status == 0) {
    assert(a.deck);
    output = a.output ? format_text("%s", a.output) : app_default_name(a.deck, "h5");
    again = output ? format_text("resume %s", output) : NULL;
    status = sd_deck_load(a.deck, a.n_overrides, a.overrides, &model, messages);
    if (status != SD_OK) sd_messages_print(messages, stderr);
    if (status == SD_OK && sd_model_deck(model)->sweep_points > 0)
      sd_warn(messages,
              "%s has a sweep of %zu point%s, which `slipdisk sweep` runs; this is the deck as it stands",
              a.deck, sd_model_deck(model)->sweep_points, sd_model_deck(model)->sweep_points == 1 ? "" : "s");
  }
  if (status == 0 && !again) status = app_no_memory();
  if (status == 0) {
    a.drive.result = output;
    a.drive.again = again;
    status = drive_run(model, &a.drive, messages);
  }
  free(output);
  free(again);
  free(a.overrides);
  sd_model_free(model);
  sd_messages_free(messages);
  return status;
}

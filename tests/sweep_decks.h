/* sweep_decks.h: what the tests of a deck's sweep share: a deck with a sweep in a file of its own.
 */
#ifndef TESTS_SWEEP_DECKS_H
#define TESTS_SWEEP_DECKS_H

#include <unistd.h>

#include "unit.h"
#include "io/deck/deck.h"

/* Line 1 is dt, line 2 the sweep of a test, the rest stands behind it. */
#define HEAD "dt = 1e-3; steps = 10; seed = 5;\n"
#define TAIL                                                                                       \
  "gravity = { g = 10; };\n"                                                                       \
  "materials = ( { name = \"m\"; k_n = 10; } );\n"                                                 \
  "disks = ( { name = \"a\"; x = 0; y = 0; radius = 1; mass = 2; }, { name = \"b\"; x = 3; y = "   \
  "0; radius = "                                                                                   \
  "1; "                                                                                            \
  "mass = 2; } );\n"                                                                               \
  "motions = ( { name = \"p\"; disk = \"a\"; coordinate = \"x\"; type = \"harmonic\"; amplitude "  \
  "= 1; omega "                                                                                    \
  "= 1; },\n"                                                                                      \
  "  { name = \"q\"; disk = \"a\"; coordinate = \"y\"; type = \"harmonic\"; amplitude = 1; omega " \
  "= 1; } "                                                                                        \
  ");\n"

static char folder[] = "/tmp/slipdisk-sweep-XXXXXX";
static char path[64];
static sd_messages *messages;
static deck_sweep sweep_now;

HELPER sd_status load(const char *text, size_t n, const char *const *overrides) {
  FILE *out = fopen(path, "w");
  assert_non_null(out);
  fputs(text, out);
  fclose(out);
  sd_messages_clear(messages);
  deck_sweep_free(&sweep_now);
  sd_status status = deck_sweep_load(path, n, overrides, &sweep_now, messages);
  assert_true((status == SD_OK) == (sd_messages_errors(messages) == 0));
  return status;
}

HELPER int set_up(void **state) {
  if (!mkdtemp(folder)) return 1;
  snprintf(path, sizeof path, "%s/deck.cfg", folder);
  messages = sd_messages_new();
  return 0;
}

HELPER int tear_down(void **state) {
  deck_sweep_free(&sweep_now);
  sd_messages_free(messages);
  remove(path);
  return rmdir(folder);
}

#endif

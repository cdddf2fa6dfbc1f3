/* packings_decks.h: what the tests of containers and packings of decks share: decks with one of each, loading, refusals.
 */
#ifndef TESTS_PACKINGS_DECKS_H
#define TESTS_PACKINGS_DECKS_H

#include "unit.h"
#include "model/state.h"
#include "slipdisk/deck.h"

#define HEAD                                                                                       \
  "dt = 1e-3; steps = 10; gravity = { g = 10; }; materials = ( { name = \"m\"; k_n = 10; } );\n"
#define BOX "container = { type = \"box\"; width = 10; height = 8; };\n"
#define PERIODIC "container = { type = \"periodic\"; width = 10; height = 8; };\n"
#define DRUM "container = { type = \"drum\"; radius = 5; };\n"
#define MONO "radius = 0.25; density = 2;"
#define ONE "packings = ( { type = \"square\"; count = 1; " MONO " } );\n"

static sd_messages *messages;

HELPER sd_model *load(const char *text, const char *set, const char *set_too) {
  const char *overrides[2] = {set, set_too};
  sd_model *m = NULL;
  sd_messages_free(messages);
  messages = sd_messages_new();
  sd_status status = sd_deck_load_text(text, "test.cfg",
                                       set_too ? 2
                                       : set   ? 1
                                               : 0,
                                       overrides, &m, messages);
  assert_true((status == SD_OK) == (m != NULL));
  return m;
}

HELPER sd_model *good(const char *text) {
  sd_model *m = load(text, NULL, NULL);
  if (!m) sd_messages_print(messages, stderr);
  assert_non_null(m);
  return m;
}

/* The deck must fail with exactly these messages, one a line, each without "test.cfg:LINE: ". */
HELPER void refused(const char *text, const char *words) {
  char all[4096] = "";
  assert_null(load(text, NULL, NULL));
  for (size_t k = 0; k < sd_messages_count(messages); k++) {
    const char *found = sd_messages_text(messages, k);
    if (strncmp(found, "test.cfg:", 9) == 0) found = strchr(found, ' ') + 1;
    if (k) strcat(all, "\n");
    strncat(all, found, sizeof all - strlen(all) - 2);
  }
  assert_string_equal(all, words);
}

HELPER int tear_down(void **state) {
  sd_messages_free(messages);
  return 0;
}

#endif

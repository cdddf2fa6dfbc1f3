/* test_deck_reference.c: docs/deck.md against the program's tables, both ways; its examples; and the messages
 * about a deck with every kind of mistake against tests/decks/many.expected. */
#include <unistd.h>

#include "unit.h"
#include "io/deck/deck.h"
#include "io/deck/deck_read.h"
#include "model/state.h"
#include "slipdisk/deck.h"

static char *read_all(const char *path) {
  FILE *in = fopen(path, "rb");
  assert_non_null(in);
  char *text = calloc(1, 1 << 20);
  assert_non_null(text);
  assert_true(fread(text, 1, (1 << 20) - 1, in) > 0);
  fclose(in);
  return text;
}

/* Headings of tables and their rows, and nothing else. */
static char *table_lines(const char *text) {
  char *out = calloc(1, strlen(text) + 2), *end = out;
  assert_non_null(out);
  for (const char *line = text; *line;) {
    size_t n = strcspn(line, "\n");
    if (line[0] == '|' || (strncmp(line, "### ", 4) == 0 && !memchr(line, 'A', 5))) {
      memcpy(end, line, n);
      end += n;
      *end++ = '\n';
    }
    line += n + (line[n] == '\n');
  }
  return out;
}

static void test_tables(void **state) {
  char *doc = read_all(SLIPDISK_SOURCE_DIR "/docs/deck.md"), *code = NULL;
  size_t size;
  FILE *out = open_memstream(&code, &size);
  deck_keys_print(out);
  fclose(out);
  const char *part = strstr(doc, "\n## All keys\n");
  assert_non_null(part);
  char *a = table_lines(part), *b = table_lines(code), *p = a, *q = b;
  /* line by line, so that the first difference is what is shown */
  while (*p || *q) {
    char *p_end = strchrnul(p, '\n'), *q_end = strchrnul(q, '\n');
    char p_line[1024], q_line[1024];
    snprintf(p_line, sizeof p_line, "docs: %.*s", (int)(p_end - p), p);
    snprintf(q_line, sizeof q_line, "docs: %.*s", (int)(q_end - q), q);
    assert_string_equal(p_line, q_line);
    p = *p_end ? p_end + 1 : p_end;
    q = *q_end ? q_end + 1 : q_end;
  }
  free(a);
  free(b);
  free(doc);
  free(code);
}

/* Every default that the tables print must be a value that the key may have. */
static void test_defaults_in_range(void **state) {
  for (size_t t = 0; t < deck_table_count; t++)
    for (size_t k = 0; deck_key_at(deck_tables[t], k); k++) {
      const deck_key *key = deck_key_at(deck_tables[t], k);
      assert_ptr_equal(deck_key_find(deck_tables[t], key->name), key);
      char *end;
      double x = strtod(key->initial, &end);
      if (end != key->initial && !*end) assert_true(deck_in_range(key->range, x));
    }
}

/* The code blocks of the worked examples are decks that load. */
static void test_examples(void **state) {
  char folder[] = "/tmp/slipdisk-doc-XXXXXX", csv[64];
  assert_non_null(mkdtemp(folder));
  snprintf(csv, sizeof csv, "%s/grains.csv", folder);
  char *doc = read_all(SLIPDISK_SOURCE_DIR "/docs/deck.md"), *block[3],
       *p = strstr(doc, "## Worked examples\n");
  assert_non_null(p);
  for (int k = 0; k < 3; k++) {
    block[k] = strchr(strstr(p, "\n```") + 1, '\n') + 1;
    p = strstr(block[k], "\n```") + 1;
    *p++ = 0;
  }
  FILE *out = fopen(csv, "w");
  assert_non_null(out);
  fputs(block[2], out);
  fclose(out);
  for (int k = 0; k < 2; k++) {
    char path[64];
    snprintf(path, sizeof path, "%s/example.cfg", folder);
    sd_messages *messages = sd_messages_new();
    sd_model *m = NULL;
    sd_status status = sd_deck_load_text(block[k], path, 0, NULL, &m, messages);
    sd_messages_print(messages, stderr);
    assert_int_equal(status, SD_OK);
    sd_model_free(m);
    sd_messages_free(messages);
  }
  free(doc);
  remove(csv);
  rmdir(folder);
}

static void test_messages(void **state) {
  const char *folder = SLIPDISK_SOURCE_DIR "/tests/decks/";
  sd_messages *messages = sd_messages_new();
  sd_model *m;
  assert_int_equal(sd_deck_load(SLIPDISK_SOURCE_DIR "/tests/decks/many.cfg", 0, NULL, &m, messages),
                   SD_ERROR_USER);
  assert_null(m);
  char *expected = read_all(SLIPDISK_SOURCE_DIR "/tests/decks/many.expected"), *line = expected;
  for (size_t k = 0; k < sd_messages_count(messages); k++) {
    char text[1024], *at;
    snprintf(text, sizeof text, "%s", sd_messages_text(messages, k));
    while ((at = strstr(text, folder)))
      memmove(at, at + strlen(folder), strlen(at + strlen(folder)) + 1);
    char *end = strchrnul(line, '\n');
    bool last = !*end;
    *end = 0;
    assert_string_equal(text, line);
    line = last ? end : end + 1;
  }
  assert_string_equal(line, "");
  free(expected);
  sd_messages_free(messages);
}

static void note_difference(void *user, const char *path, const char *there, const char *here) {
  snprintf(user, 64, "%s: %s, %s", path, there ? there : "-", here ? here : "-");
}

/* A full deck of an older version lacks a key: no difference when the key has its default here. */
static void keys_of_newer_versions(void **unused) {
  static const struct {
    const char *there, *here, *differs;
  } list[] = {
      {"measure = { disks = true; };", "measure = { disks = true; configurations = false; };", ""},
      {"measure = { disks = true; };", "measure = { disks = true; configurations = true; };",
       "measure.configurations: -, true"},
      {"measure = { disks = true; configurations = false; };", "measure = { disks = true; };",
       "measure.configurations: false, -"},
      {"dt = 1.0; phases = ( { name = \"a\"; } );",
       "dt = 1.0; phases = ( { name = \"a\"; relax = false; } );", ""},
      {"dt = 1.0;", "dt = 1.0; seed = 5;", "seed: -, 5"},
  };
  for (size_t k = 0; k < sizeof list / sizeof *list; k++) {
    char found[64] = "";
    assert_true(deck_compare(list[k].there, list[k].here, false, note_difference, found));
    assert_string_equal(found, list[k].differs);
  }
}

RUN_TESTS(TEST(test_tables), TEST(test_defaults_in_range), TEST(test_examples), TEST(test_messages),
          TEST(keys_of_newer_versions))

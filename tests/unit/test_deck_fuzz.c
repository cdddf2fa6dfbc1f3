/* test_deck_fuzz.c: damaged decks are refused or read, without a crash, a hang or a leak. Most telling in the
 * dev build, where the sanitizers watch. */
#include <glob.h>

#include "unit.h"
#include "model/state.h"
#include "slipdisk/deck.h"

enum { DAMAGES = 60 };

/* libconfig 1.5 itself loses the string it was reading at a syntax error. */
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) { return "leak:libconfig\n"; }

/* xorshift: the same damages every time */
static uint64_t bits = 88172645463325252u;
static size_t below(size_t n) {
  bits ^= bits << 13;
  bits ^= bits >> 7;
  bits ^= bits << 17;
  return (size_t)(bits % n);
}

static void read_damaged(const char *text) {
  sd_messages *messages = sd_messages_new();
  sd_model *m = NULL;
  sd_status status = sd_deck_load_text(text, "damaged.cfg", 0, NULL, &m, messages);
  assert_true((status == SD_OK) == (m != NULL));
  assert_true((status == SD_OK) == (sd_messages_errors(messages) == 0));
  sd_model_free(m);
  sd_messages_free(messages);
}

static void damage(char *text, size_t n) {
  static const char *const pieces[] = {"{",
                                       "}",
                                       "(",
                                       ")",
                                       "[",
                                       "\"",
                                       "/*",
                                       "=",
                                       ";",
                                       ",",
                                       "@include \"x\"\n",
                                       "1e999",
                                       "-",
                                       "99999999999999999999",
                                       "true",
                                       "*",
                                       "name",
                                       "\\",
                                       "0x",
                                       "."};
  for (size_t k = 0, times = 1 + below(4); k < times && n > 1; k++) {
    size_t at = below(n), piece = below(sizeof pieces / sizeof *pieces),
           length = strlen(pieces[piece]);
    switch (below(5)) {
      case 0: text[n = at] = 0; break;                  /* cut */
      case 1: text[at] = (char)(1 + below(255)); break; /* another byte */
      case 2:
        memmove(text + at, text + at + 1, n - at);
        n--;
        break; /* a byte less */
      case 3:
        if (at + length < n) memcpy(text + at, pieces[piece], length);
        break;
      default: text[at] = text[below(n)]; break;
    }
  }
}

/* Packings keep three digits of their count: to fill them with thousands of disks time and again
 * took nine tenths of the time, and says nothing of the reader. test_deck_check fills them as
 * they ship. */
static size_t fewer_disks(char *text) {
  static const char key[] = "count = ";
  for (char *at = text; (at = strstr(at, key)) != NULL;) {
    at += strlen(key);
    size_t digits = strspn(at, "0123456789"), most = digits < 3 ? digits : 3;
    memmove(at + most, at + digits, strlen(at + digits) + 1);
  }
  return strlen(text);
}

static void damage_deck(const char *path) {
  FILE *in = fopen(path, "rb");
  assert_non_null(in);
  static char whole[1 << 16], text[1 << 16];
  size_t n = fread(whole, 1, sizeof whole - 1, in);
  fclose(in);
  whole[n] = 0;
  n = fewer_disks(whole);
  for (int k = 0; k < DAMAGES; k++) {
    memcpy(text, whole, n);
    text[n] = 0;
    damage(text, n);
    read_damaged(text);
  }
}

static void test_damaged(void **state) {
  glob_t found;
  assert_int_equal(glob(SLIPDISK_SOURCE_DIR "/inputs/*/*.cfg", 0, NULL, &found), 0);
  for (size_t k = 0; k < found.gl_pathc; k++) damage_deck(found.gl_pathv[k]);
  globfree(&found);
  damage_deck(SLIPDISK_SOURCE_DIR "/tests/decks/many.cfg");
}

static void test_deep(void **state) {
  static char text[200001];
  static const char opening[] = "({[";
  for (int c = 0; c < 3; c++) {
    memset(text, opening[c], 200000);
    read_damaged(text);
    memcpy(text, "a=", 2);
    read_damaged(text);
  }
}

RUN_TESTS(TEST(test_damaged), TEST(test_deep))

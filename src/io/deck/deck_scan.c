/* deck_scan.c: makes the text of a deck safe for libconfig. See deck_tree.h.
 *
 * libconfig 1.5 accepts the texts on the left without a message, or with a poor one. The scanner
 * does what stands behind ->:
 *   5000000000   cut to 32 bits            -> given the suffix L
 *   1e400        read as infinity          -> error
 *   10kg, 2 * R  read as several tokens    -> error that names units, or the quotes of arithmetic
 *   / * ...      unterminated comment      -> error at its first line
 *   "...         string over a line end    -> error: most likely a quote was forgotten
 *   [0, 10.5]    arrays of one type only   -> written as a list, whose elements may differ
 *   a = 1; a = 2 stops at the first        -> all reported, with the line of the first
 *   @include     lines counted per file    -> file inserted here, each line keeps its location
 *   a = word     "syntax error"            -> error that names the quotes
 *   (1, 2,)      "syntax error"            -> the last comma is dropped
 *   (1 2), a = ; "syntax error"            -> error that says what is missing
 * Line breaks are kept, so that line k of the clean text has a known location. */
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/text.h"
#include "io/deck/deck_expression.h"
#include "io/deck/deck_read.h"
#include "io/store/file.h"

typedef struct key {
  const char *name;
  size_t length;
  deck_place place;
} key;

/* One open bracket of the text; level 0 is the deck outside all brackets. */
typedef struct level {
  char open;
  deck_place place;
  bool value;       /* Groups: true after "key =", before the value */
  bool key;         /* Groups: true after a key, before its = */
  bool full;        /* Lists: true if an element was read since the last comma */
  size_t comma;     /* Lists: index of the last comma in the clean text */
  const char *name; /* Groups: name of the key being read */
  size_t length;
  size_t index; /* Lists: index of the element being read */
  key *keys;
  size_t n_keys, key_capacity;
  size_t n_seen; /* Groups: number of keys read, repeated ones included */
} level;

typedef struct scanner {
  deck *d;
  deck_buffer clean, raw;
  deck_place *line;
  size_t n_lines, line_capacity;
  level levels[LIMIT_DEPTH];
  int depth;
  int includes; /* Number of included files, one inside the other, around the current position */
  int included_files;
  size_t bytes; /* Length of the deck in bytes, with all files that it includes */
  int repeated;
  bool override, included, broken;
  /* True after a missing quote or bracket, since later errors about brackets would only follow from
   * it */
  bool torn;
  const char *p; /* Current position in the text */
  const char *start;
  deck_place here;
} scanner;

/* --- output ----------------------------------------------------------------------------------- */

static void emit(scanner *s, const char *text, size_t n) { deck_put(s->d, &s->clean, text, n); }
static void emit_text(scanner *s, const char *text) { emit(s, text, strlen(text)); }

static void begin_line(scanner *s) {
  s->line = deck_extend(s->d, s->line, s->n_lines, &s->line_capacity, sizeof *s->line);
  s->line[s->n_lines++] = s->here;
}

static void newline(scanner *s) {
  emit(s, "\n", 1);
  if (!s->override) s->here.line++;
  begin_line(s);
}

static level *top(scanner *s) { return &s->levels[s->depth]; }
static bool in_group(scanner *s) { return top(s)->open == 0 || top(s)->open == '{'; }

/* Returns the path of the value being read, followed by " = ", for messages; "" before the first
 * key. */
static const char *path(scanner *s) {
  if (s->override || deck_error_limit_reached(s->d)) return "";
  const char *text = "";
  for (int k = 0; k <= s->depth; k++) {
    const level *l = &s->levels[k];
    if (l->open == 0 || l->open == '{')
      text = deck_format(s->d, "%s%s%.*s", text, *text ? "." : "", (int)l->length,
                         l->name ? l->name : "");
    else
      text = deck_format(s->d, "%s[%zu]", text, l->index);
  }
  return *text ? deck_format(s->d, "%s = ", text) : text;
}

/* Reports a mistake in brackets, commas or keys. Only the first such mistake is shown, since
 * others follow from it. */
static void fail_form(scanner *s, const char *format, ...) SD_PRINTF(2, 3);
static void fail_form(scanner *s, const char *format, ...) {
  s->broken = true;
  if (s->torn) return;
  s->torn = true;
  va_list args;
  va_start(args, format);
  const char *words = deck_format_v(s->d, format, args);
  va_end(args);
  deck_fail_place(s->d, s->here, "%s", words);
}

/* Returns the path of the key that was read last. */
static const char *key_path(scanner *s) {
  const char *text = path(s);
  size_t n = strlen(text);
  return n > 3 ? deck_copy(s->d, text, n - 3) : "the value";
}

/* Returns an open bracket with its line, "( of line 4", for messages; only "(" in a -D setting,
 * which has no lines. */
static const char *bracket_of(scanner *s, const level *l) {
  return l->place.line > 0 ? deck_format(s->d, "%c of line %d", l->open, l->place.line)
                           : deck_format(s->d, "%c", l->open);
}

/* Notes that a value begins at s->p, and reports an error if no value is allowed there. */
static void begin_value(scanner *s) {
  level *l = top(s);
  const char *p = s->p;
  if (!in_group(s)) {
    if (l->full)
      fail_form(s, "a comma is missing before this element of a list, or a bracket is not closed");
    l->full = true;
  } else if (l->value) {
    l->value = false;
  } else if (l->key) {
    fail_form(s, "an = is missing behind %s", key_path(s));
  } else if (isdigit((unsigned char)*p) && p > s->start + 1 && p[-1] == ',' &&
             isdigit((unsigned char)p[-2])) {
    fail_form(s, "%s: decimals are written with a point, 0.5 and not 0,5", key_path(s));
  } else {
    fail_form(s, "a value without key = before it%s",
              *p == '"' ? "; keys have no quotes" : "; several values of a key belong in ( )");
  }
  l->key = false;
}

/* --- tokens ----------------------------------------------------------------------------------- */

static void skip_comment(scanner *s) {
  deck_place start = s->here;
  s->p += 2;
  while (*s->p && !(s->p[0] == '*' && s->p[1] == '/')) {
    if (*s->p == '\n') newline(s);
    s->p++;
  }
  if (*s->p) {
    s->p += 2;
    emit(s, " ", 1);
    return;
  }
  deck_fail_place(s->d, start, "the comment that begins here with /* is never closed with */");
  s->broken = true;
}

/* Scans a text in quotes. Inside it, \" does not end the text, and after \\ the next character has
 * its usual meaning. */
static void scan_string(scanner *s) {
  deck_place start = s->here;
  /* A text directly after another one is no new value: libconfig joins the two */
  if (!in_group(s) || s->clean.n == 0 || s->clean.bytes[s->clean.n - 1] != '"') begin_value(s);
  const char *from = s->p++;
  while (*s->p && *s->p != '"' && *s->p != '\n')
    s->p += *s->p == '\\' && s->p[1] && s->p[1] != '\n' ? 2 : 1;
  if (*s->p != '"') {
    /* Continue as if the text ended here; else a forgotten quote would exchange texts and code in
     * the rest of the deck */
    deck_fail_place(s->d, start, "%sthe text %s is not closed with \" on this line", path(s),
                    deck_quote(s->d, from, (size_t)(s->p - from)));
    s->broken = s->torn = true;
    return;
  }
  s->p++;
  emit(s, from, (size_t)(s->p - from));
}

static bool word_char(char c) {
  return isalnum((unsigned char)c) || c == '_' || c == '-' || c == '*';
}

static void emit_integer(scanner *s, const char *token, int base) {
  errno = 0;
  long long x = strtoll(token, NULL, base);
  if (errno == ERANGE) {
    deck_fail_place(s->d, s->here, "%s%s: integer beyond 64 bits; expected at most %lld", path(s),
                    deck_quote(s->d, token, strlen(token)), INT64_MAX + 0LL);
    x = 1;
  }
  bool wide = x > INT32_MAX || x < INT32_MIN;
  emit_text(s, deck_format(s->d, "%lld%s", x, wide ? "L" : ""));
}

static void emit_real(scanner *s, const char *token) {
  double x = strtod(token, NULL);
  bool nonzero = false;
  for (const char *p = token; *p && *p != 'e' && *p != 'E'; p++) nonzero |= *p >= '1' && *p <= '9';
  if (!isfinite(x)) {
    deck_fail_place(s->d, s->here, "%s%s: number too large; expected at most 1.79e308", path(s),
                    deck_quote(s->d, token, strlen(token)));
    token = "1.0";
  } else if (x == 0 && nonzero) {
    deck_fail_place(s->d, s->here, "%s%s: number too small, it would be read as 0", path(s),
                    deck_quote(s->d, token, strlen(token)));
    token = "1.0";
  }
  emit_text(s, token);
}

/* Returns the end of the value at s->p, which has no quotes. */
static const char *value_end(scanner *s) {
  const char *p = s->p;
  for (int open = 0; *p && !strchr(";\n\r#\"'{}=:[]@", *p); p++) {
    if ((p[0] == '/' && (p[1] == '/' || p[1] == '*')) || (*p == ',' && open == 0)) break;
    open += *p == '(';
    if (*p == ')' && open-- == 0) break;
  }
  /* The next key follows, without a ; before it: go back to the end of the value */
  if (in_group(s) && (*p == '=' || *p == ':')) {
    while (p > s->p && isspace((unsigned char)p[-1])) p--;
    while (p > s->p && word_char(p[-1])) p--;
  }
  while (p > s->p && isspace((unsigned char)p[-1])) p--;
  return p;
}

/* Handles a value without quotes that goes on after its first token of n bytes: reports that a
 * unit, arithmetic or a text needs other syntax, and skips the value. Returns false if the value
 * has only one token. */
static bool scan_unquoted(scanner *s, size_t n) {
  const char *end = value_end(s);
  if (end <= s->p + n) return false;
  const char *text = deck_copy(s->d, s->p, (size_t)(end - s->p)),
             *shown = deck_quote(s->d, text, strlen(text));
  double x;
  const char *wrong = deck_expression(s->d, text, DECK_NAMES_ANY, true, &x);
  bool is_text = wrong && isalpha((unsigned char)*text);
  if (is_text)
    deck_fail_place(s->d, s->here, "%s%s: a text needs quotes: \"%s\"", path(s), shown, shown);
  else if (wrong)
    deck_fail_place(s->d, s->here, "%s%s: %s", path(s), shown, wrong);
  else
    deck_fail_place(s->d, s->here, "%s%s: expected quotes around it: \"%s\"", path(s), shown,
                    shown);
  s->broken |= s->override || (wrong && !in_group(s));
  /* Write a value of the most likely type instead, so that no second error follows */
  emit_text(s, is_text ? "\"?\"" : "1");
  begin_value(s);
  s->p = end;
  return true;
}

/* Scans a number; returns false if there is none at the current position. */
static bool scan_number(scanner *s) {
  bool real, hex = s->p[0] == '0' && (s->p[1] == 'x' || s->p[1] == 'X') &&
                   isxdigit((unsigned char)s->p[2]);
  size_t n = deck_number_length(s->p, &real), all = n;
  if (hex)
    for (n = 3, real = false; isxdigit((unsigned char)s->p[n]);) all = ++n;
  if (!real && n > 0 && s->p[n] == 'L') all += s->p[n + 1] == 'L' ? 2 : 1;
  bool place = !in_group(s) || top(s)->value;
  if (place && strchr("+-.0123456789", *s->p) && scan_unquoted(s, all)) return true;
  if (n == 0) return false;
  begin_value(s);
  const char *token = deck_copy(s->d, s->p, n);
  if (real)
    emit_real(s, token);
  else
    emit_integer(s, token, hex ? 16 : 10);
  s->p += all;
  return true;
}

static void scan_key(scanner *s, const char *name, size_t n) {
  level *l = top(s);
  if (l->key) fail_form(s, "%s: expected key = value", key_path(s));
  l->key = true;
  if (n > LIMIT_QUOTE) {
    deck_fail_place(s->d, s->here, "%s: a key of %zu characters; expected at most %d",
                    deck_quote(s->d, name, n), n, LIMIT_QUOTE);
    s->broken = true;
    return;
  }
  l->name = name;
  l->length = n;
  if (l->n_seen++ >= LIMIT_KEYS) {
    if (l->n_seen == LIMIT_KEYS + 1)
      deck_fail_place(s->d, s->here, "%.*s: more than %d keys in one group", (int)n, name,
                      LIMIT_KEYS);
    s->broken = true;
    return;
  }
  for (size_t k = 0; k < l->n_keys; k++) {
    if (l->keys[k].length != n || memcmp(l->keys[k].name, name, n) != 0) continue;
    const char *full = path(s);
    int length = *full ? (int)strlen(full) - 3 : 0;
    deck_fail_place(s->d, s->here, "%.*s: key given twice; first on line %d%s%s", length, full,
                    l->keys[k].place.line, l->keys[k].place.file == s->here.file ? "" : " of ",
                    l->keys[k].place.file == s->here.file ? "" : l->keys[k].place.file);
    emit_text(s, deck_format(s->d, "*repeated-%d", s->repeated++));
    return;
  }
  l->keys = deck_extend(s->d, l->keys, l->n_keys, &l->key_capacity, sizeof *l->keys);
  l->keys[l->n_keys++] = (key){name, n, s->here};
  emit(s, name, n);
}

static bool is_word(const char *name, size_t n, const char *word) {
  if (strlen(word) != n) return false;
  for (size_t k = 0; k < n; k++)
    if (tolower((unsigned char)name[k]) != word[k]) return false;
  return true;
}

/* Returns the name of the key whose value is being read; the position may be inside nested
 * lists. */
static const char *key_name(scanner *s) {
  const level *l = top(s);
  while (l > s->levels && l->open != '{') l--;
  return l->name ? deck_copy(s->d, l->name, l->length) : "";
}

/* At a key or a ";", which cannot stand in a list: closes the lists that are open, and reports the
 * missing bracket. before: the word "key", or the mark, for the message. */
static void leave_lists(scanner *s, const char *before) {
  if (in_group(s)) return;
  while (!in_group(s) && s->levels[s->depth - 1].open != 0 && s->levels[s->depth - 1].open != '{')
    s->depth--;
  char open = top(s)->open;
  fail_form(s, "the %s is not closed before this %s; is a %c missing%s?", bracket_of(s, top(s)),
            before, open == '(' ? ')' : ']', *before == 'k' ? ", or a { before the key" : "");
  s->depth--;
}

static void scan_word(scanner *s) {
  const char *name = s->p, *next = name;
  while (word_char(*next)) next++;
  size_t n = (size_t)(next - name);
  while (*next == ' ' || *next == '\t') next++;
  if (*next == '=' && !s->override) leave_lists(s, "key");
  if (in_group(s) && !top(s)->value) {
    s->p += n;
    scan_key(s, name, n);
    return;
  }
  if (is_word(name, n, "true") || is_word(name, n, "false")) {
    begin_value(s);
    s->p += n;
    emit(s, name, n);
    return;
  }
  if (scan_unquoted(s, n)) return;
  begin_value(s);
  s->p += n;
  const char *word = deck_quote(s->d, name, n),
             *owner = deck_error_limit_reached(s->d) ? "" : key_name(s);
  s->broken |= s->override;
  /* Write a value of the right type instead, so that later errors are found too */
  if (deck_names_kind(owner, true)) {
    deck_fail_place(s->d, s->here, "%s%s: expected true or false", path(s), word);
    emit_text(s, "false");
  } else if (deck_names_kind(owner, false)) {
    deck_fail_place(s->d, s->here, "%s%s: expected a number, or quotes around a constant: \"%s\"",
                    path(s), word, word);
    emit_text(s, "1");
  } else {
    deck_fail_place(s->d, s->here, "%s%s: a text needs quotes: \"%s\"", path(s), word, word);
    emit_text(s, deck_format(s->d, "\"%.*s\"", (int)n, name));
  }
}

/* Reports a character that cannot stand here, such as those that word processors put in place of
 * quotes, minus or *. */
static void scan_other(scanner *s) {
  static const struct {
    const char *bytes, *write;
  } others[] = {{"\u201c", "\""}, {"\u201d", "\""}, {"\u201e", "\""},
                {"\u2018", "\""}, {"\u2019", "\""}, {"'", "\""},
                {"\u2212", "-"},  {"\u2013", "-"},  {"\u00d7", "*"}};
  size_t n = text_step(s->p);
  const char *write = NULL, *shown = deck_copy(s->d, s->p, n);
  for (size_t k = 0; k < sizeof others / sizeof *others && n > 0; k++)
    if (strcmp(shown, others[k].bytes) == 0) write = others[k].write;
  s->broken = true;
  if (n == 0)
    deck_fail_place(s->d, s->here, "unexpected byte 0x%02x outside quotes",
                    (unsigned)(unsigned char)*s->p);
  else if (strcmp(shown, "\u00a0") == 0)
    deck_fail_place(s->d, s->here, "unexpected no-break space outside quotes; write a blank");
  else
    deck_fail_place(s->d, s->here, "unexpected %s outside quotes%s%s", shown,
                    write ? "; write " : "", write ? write : "");
  s->p += n ? n : 1;
  if (!write || *write != '"') return;
  /* The character stands for a quote: skip a text that ends before a line break or one of ; , )
   * } */
  begin_value(s);
  s->p += strcspn(s->p, "\n;,)}");
}

/* --- brackets and includes -------------------------------------------------------------------- */

static void open_bracket(scanner *s) {
  if (s->depth == 0 || top(s)->open) begin_value(s);
  char c = *s->p++;
  if (s->depth + 1 >= LIMIT_DEPTH) {
    if (!s->broken)
      deck_fail_place(s->d, s->here, "more than %d brackets inside each other", LIMIT_DEPTH - 2);
    s->broken = true;
    return;
  }
  s->levels[++s->depth] = (level){.open = c, .place = s->here};
  emit(s, c == '{' ? "{" : "(", 1);
}

static bool closes(char c, char open) {
  return open && c == (open == '{' ? '}' : open == '(' ? ')' : ']');
}

static void close_bracket(scanner *s) {
  char c = *s->p++;
  const level *l = top(s);
  if (l->open == 0) {
    fail_form(s, "%c closes nothing", c);
  } else if (!closes(c, l->open)) {
    char wanted = l->open == '{' ? '}' : l->open == '(' ? ')' : ']';
    if (s->depth > 1 && closes(c, l[-1].open)) {
      fail_form(s,
                "%c closes the %s, but the %s is still open: is a %c missing, or is "
                "this %c one too many?",
                c, bracket_of(s, l - 1), bracket_of(s, l), wanted, c);
      s->depth--;
    } else {
      fail_form(s, "%c found where the %s should be closed with %c", c, bracket_of(s, l), wanted);
    }
  }
  if (top(s)->value) fail_form(s, "%s: a value is missing", key_path(s));
  if (!in_group(s) && top(s)->index > 0 && !top(s)->full && !s->torn)
    s->clean.bytes[top(s)->comma] = ' ';
  if (s->depth > 0) s->depth--;
  emit(s, c == '}' ? "}" : ")", 1);
}

/* Scans one of the characters = : ; or a comma. */
static void scan_mark(scanner *s) {
  char c = *s->p;
  if (c == ';') leave_lists(s, "\";\"");
  level *l = top(s);
  if (in_group(s) && strchr("=:", c)) {
    if (!l->key) fail_form(s, l->value ? "one %c too many" : "%c without a key before it", c);
    l->value = true;
    l->key = false;
  } else if (in_group(s)) {
    if (l->value) fail_form(s, "%s: a value is missing", key_path(s));
    if (l->key) fail_form(s, "%s: expected key = value", key_path(s));
    l->value = l->key = false;
  } else if (c == ',') {
    if (!l->full) fail_form(s, "an element is missing before this comma");
    l->full = false;
    l->index++;
    l->comma = s->clean.n;
  }
  size_t n = s->clean.n;
  while (n > 0 && isspace((unsigned char)s->clean.bytes[n - 1])) n--;
  bool again = c == ';' && n > 0 && s->clean.bytes[n - 1] == ';'; /* A second ; is dropped */
  emit(s, again ? " " : &c, 1);
  s->p++;
}

static void scan_all(scanner *s, const char *text, deck_place place);

/* Includes a file for @include "file", which must be alone on its line. */
static void include_file(scanner *s) {
  const char *p = s->p + 8, *line = s->p;
  while (line > s->start && (line[-1] == ' ' || line[-1] == '\t')) line--;
  bool alone = strncmp(s->p, "@include", 8) == 0 && (line == s->start || line[-1] == '\n');
  while (alone && (*p == ' ' || *p == '\t')) p++;
  const char *end = alone && *p == '"' ? strpbrk(p + 1, "\"\n") : NULL;
  if (s->override || !end || *end != '"') {
    deck_fail_place(s->d, s->here, "@: expected @include \"file\" alone on its line");
    s->p++;
    s->broken = true;
    return;
  }
  const char *name = deck_copy(s->d, p + 1, (size_t)(end - p - 1)), *after = end + 1;
  const char *file = deck_resolve(s->d, s->here.file, name), *start = s->start;
  deck_place here = s->here;
  char *text = NULL;
  const size_t most = (size_t)LIMIT_DECK * LIMIT_MIB;
  if (s->includes >= LIMIT_INCLUDE_DEPTH || s->included_files >= LIMIT_INCLUDES) {
    bool deep = s->includes >= LIMIT_INCLUDE_DEPTH;
    deck_fail_place(s->d, s->here, "@include \"%s\": more than %d files %s",
                    deck_quote(s->d, name, strlen(name)),
                    deep ? LIMIT_INCLUDE_DEPTH : LIMIT_INCLUDES,
                    deep ? "inside each other" : "are included");
    s->broken = true;
  } else if (deck_is_outside(s->d, s->here.file, name)) {
    deck_fail_place(s->d, s->here, "@include \"%s\": %s", deck_quote(s->d, name, strlen(name)),
                    deck_outside);
    s->broken = true;
  } else if (!(text = deck_read_file(s->d, file, most, s->here, "@include"))) {
    s->broken = true;
  } else if ((s->bytes += strlen(text)) > most) {
    deck_fail_place(s->d, s->here,
                    "@include \"%s\": the deck has more than %d MiB with all that it includes",
                    deck_quote(s->d, name, strlen(name)), LIMIT_DECK);
    s->broken = true;
    text = NULL;
  }
  s->included_files++;
  if (text) {
    /* Raw text: add the text before this line; then the content of the file replaces "@include
     * ..." */
    s->included = true;
    deck_put(s->d, &s->raw, start, (size_t)(line - start));
    s->includes++;
    deck_place inside = {file, 1};
    s->line[s->n_lines - 1] = inside;
    scan_all(s, text, inside);
    s->includes--;
    s->here = here;
    newline(s);
    s->here = here;
    s->line[s->n_lines - 1] = here;
    deck_put(s->d, &s->raw, "\n", 1);
    start = after;
  }
  s->start = start;
  s->p = after;
}

/* --- the loop --------------------------------------------------------------------------------- */

static void scan_token(scanner *s) {
  char c = *s->p;
  if (c == '\n') {
    newline(s);
    s->p++;
  } else if (isspace((unsigned char)c)) {
    emit(s, " ", 1);
    s->p++;
  } else if (c == '#' || (c == '/' && s->p[1] == '/')) {
    while (*s->p && *s->p != '\n') s->p++;
  } else if (c == '/' && s->p[1] == '*') {
    skip_comment(s);
  } else if (c == '"') {
    scan_string(s);
  } else if (c == '@') {
    include_file(s);
  } else if (strchr("{([", c)) {
    open_bracket(s);
  } else if (strchr("})]", c)) {
    close_bracket(s);
  } else if (strchr("=:;,", c)) {
    scan_mark(s);
  } else if (scan_number(s)) {
    return;
  } else if (isalpha((unsigned char)c) || c == '*') {
    scan_word(s);
  } else {
    scan_other(s);
  }
}

static void scan_all(scanner *s, const char *text, deck_place place) {
  s->p = s->start = text;
  s->here = place;
  if (strncmp(s->p, "\xef\xbb\xbf", 3) == 0) s->p += 3; /* Skips the byte order mark of UTF-8 */
  while (*s->p) scan_token(s);
  deck_put(s->d, &s->raw, s->start, strlen(s->start));
}

deck_text deck_scan(deck *d, const char *text, deck_place place, bool override) {
  scanner *s = deck_alloc(d, 1, sizeof *s);
  s->d = d;
  s->override = override;
  s->here = place;
  s->bytes = strlen(text);
  begin_line(s);
  emit(s, "", 0);
  scan_all(s, text, place);
  if (s->depth > 0) {
    s->here = top(s)->place;
    fail_form(s, "the %c%s is never closed", top(s)->open, override ? "" : " of this line");
  }
  return (deck_text){.raw = s->included ? s->raw.bytes : NULL,
                     .clean = s->clean.bytes,
                     .n_lines = s->n_lines,
                     .line = s->line,
                     .broken = s->broken};
}

/* --- files ------------------------------------------------------------------------------------ */

char *deck_read_file(deck *d, const char *path, uint64_t most, deck_place place, const char *what) {
  char *text, trouble[FILE_TROUBLE];
  if (file_text(path, most, &text, trouble) != SD_OK) {
    deck_fail_place(d, place, "%s \"%s\": %s", what, path, trouble);
    return NULL;
  }
  deck_own(d, text);
  return text;
}

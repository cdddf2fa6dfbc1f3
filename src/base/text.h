/* text.h: text from files and from the command line, made safe for a terminal and for JSON. */
#ifndef SLIPDISK_BASE_TEXT_H
#define SLIPDISK_BASE_TEXT_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "slipdisk/status.h"

/* Returns the number of bytes of the UTF-8 character at p; 0 for a control character or invalid
 * UTF-8. */
size_t text_step(const char *p);
/* Returns true if the text is valid UTF-8 without control characters; line feeds and tabs are
 * allowed. */
bool text_printable(const char *text);
/* Replaces every byte that text_printable does not allow by '?', in place. Returns the text. */
char *text_clean(char *text);
/* Returns how many of the first n bytes of a text a message quotes: at most LIMIT_QUOTE, and no
 * incomplete character. */
size_t text_quoted(const char *text, size_t n);
/* Returns a copy of the text, which the caller frees, with \xHH for control characters and invalid
 * bytes. A text longer than `most` bytes is cut and ends in "...". */
char *text_escaped(const char *text, size_t most);

/* Returns a text formatted as by printf; the caller frees it. */
char *format_text(const char *format, ...) SD_PRINTF(1, 2);
char *format_text_v(const char *format, va_list args);
/* Appends formatted text to `text`, which must be allocated and may move, and returns the result;
 * NULL if text is NULL. */
char *append_text(char *text, const char *format, ...) SD_PRINTF(2, 3);
/* Splits a text, in place, into its *n lines, without empty ones. Returns pointers into the text;
 * the caller frees the list. */
const char **text_lines(char *text, size_t *n);
/* Writes one cell of a CSV file (RFC 4180), in quotes if the text has a comma, a quote or a line
 * break. */
void text_cell(FILE *out, const char *text);
/* Returns true if the text ends with `ending` and is longer than it. */
bool text_ends(const char *text, const char *ending);

/* --- the best match of a mistyped word among candidates, by edit distance --------------------- */

/* State of a search for the word most similar to `word`. best: best candidate so far; NULL while no
 * candidate is similar enough. */
typedef struct guess {
  const char *word, *best;
  size_t distance;
} guess;

guess guess_start(const char *word);
void guess_add(guess *g, const char *candidate); /* NULL candidates are ignored */

#endif

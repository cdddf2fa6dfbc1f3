/* text.h: text from files and from the command line, made fit for a terminal and for JSON. */
#ifndef SLIPDISK_BASE_TEXT_H
#define SLIPDISK_BASE_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "slipdisk/status.h"

/* Bytes of the character at p; 0: a control character, or no UTF-8. */
size_t text_step(const char *p);
/* UTF-8 without control characters; line ends and tabs are none here. */
bool text_printable(const char *text);
/* Puts ? for every byte that is not so, in place. */
char *text_clean(char *text);
/* How many of the first n bytes are quoted in a message: at most LIMIT_QUOTE, whole characters. */
size_t text_quoted(const char *text, size_t n);
/* A copy with \xHH for such bytes, to be freed. A longer text than `most` bytes ends in "...". */
char *text_escaped(const char *text, size_t most);

/* Text made with printf, to be freed. */
char *format_text(const char *format, ...) SD_PRINTF(1, 2);
/* The same behind `text`, which is freed; NULL if that is NULL. */
char *append_text(char *text, const char *format, ...) SD_PRINTF(2, 3);
/* The lines of a text, which is cut up: they point into it. The list is to be freed. */
const char **text_lines(char *text, size_t *n);
/* A cell of CSV (RFC 4180): quoted where a comma, a quote or a line break makes it necessary. */
void text_cell(FILE *out, const char *text);
/* Does the text end so, and begin before? */
bool text_ends(const char *text, const char *ending);

/* --- the nearest of some words to one that was mistyped, by edit distance --------------------- */

/* best: NULL when no candidate is near enough to be meant. */
typedef struct guess {
  const char *word, *best;
  size_t distance;
} guess;

guess guess_start(const char *word);
void guess_add(guess *g, const char *candidate); /* NULL: none */

#endif

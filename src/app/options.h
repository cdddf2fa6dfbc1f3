/* options.h: command lines of the subcommands: a table of options for each, and one parser for
 * all. */
#ifndef SLIPDISK_APP_OPTIONS_H
#define SLIPDISK_APP_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "slipdisk/status.h"

/* Kind of an option: whether it takes a value and of which form, and the C type of the field that
 * receives the value. */
typedef enum option_kind {
  OPTION_FLAG,   /* No value; the field is a bool */
  OPTION_NUMBER, /* Integer between limits->least and limits->most; the field is a long */
  OPTION_REAL,   /* Finite number; the field is an option_real */
  OPTION_TEXT,   /* Any text, given at most once; the field is a const char * */
  /* One of the words in option_row.value, such as "csv|vtk"; the field is a const char * */
  OPTION_CHOICE,
  /* Path of a file or folder to be written, not that of an existing deck or result; the field is a
   * const char * */
  OPTION_PATH,
  /* Path of a result to be written, not that of an existing deck; the field is a const char * */
  OPTION_RESULT,
  /* Same as OPTION_PATH, or "-" for the standard output; the field is a const char * */
  OPTION_STREAM,
  OPTION_LIST,    /* Any text; the option may be given several times; the field is an option_list */
  OPTION_CONFINED /* No value and no field: see CONFINED_OPTION */
} option_kind;

typedef struct option_real {
  bool given;
  double value;
} option_real;

typedef struct option_list {
  size_t n;
  const char **item; /* [n] pointers into argv; the caller frees the array */
} option_list;

/* Limits of the number that an option takes; least and most apply to integers only. */
typedef struct option_limits {
  long least, most;
  /* End of the error message after "--name VALUE": what was expected */
  const char *wrong;
} option_limits;

typedef struct option_row {
  const char *name; /* Long name of the option, without "--" */
  /* Letter of the short form, such as 'l' for -l; messages then use this form; 0: no short form */
  char letter;
  option_kind kind;
  size_t offset; /* Offset of the option's field in the struct of the command's arguments */
  /* Limits of OPTION_NUMBER and OPTION_REAL; OPTION_CHOICE: only the end of the error message, or
   * NULL; OPTION_LIST: only its words "a|b|c", which the command checks, in `wrong`, or NULL; NULL
   * for other kinds */
  const option_limits *limits;
  /* Name of the option's value in the help, or the words of a choice; NULL: the option takes no
   * value */
  const char *value;
  const char *help;
} option_row;

/* Row of an option that keeps decks, and decks in results, from reading files of other folders than
 * that of the operand. */
#define CONFINED_OPTION                                                                            \
  {                                                                                                \
    "confined", 0, OPTION_CONFINED, 0, NULL, NULL,                                                 \
        "for decks and results of others: read no file that they name outside of their folder"     \
  }

/* Kind of operand that a command takes. A deck may be "-", the standard input. The field at
 * command_line.offset is a const char *; for OPERAND_RESULTS a size_t, the index in argv of the
 * first result. */
typedef enum operand_kind {
  OPERAND_DECK,
  OPERAND_RESULT,
  OPERAND_RESULTS,
  OPERAND_COMMAND
} operand_kind;

typedef struct command_line {
  const char *name; /* Name of the subcommand */
  size_t n;
  const option_row *rows;
  operand_kind operand;
  size_t offset;
  /* True: the parser accepts a missing operand, which the command handles */
  bool optional;
  const char *operands; /* Operands in the help, such as "DECK" */
  const char *summary;  /* Summary of the command, one line, for the list of commands */
  /* Further lines for the help of this command; NULL: none */
  const char *more;
  /* Example command lines, each with a comment: "slipdisk run deck.cfg   # ...\n"; NULL: none */
  const char *examples;
} command_line;

/* Parses a command line into the struct `arguments`. Returns 0; after a mistake of the user, prints
 * it and returns the exit status. */
int options_parse(const command_line *line, int argc, char **argv, void *arguments);
/* Returns the words "a|b|c" that an option takes; NULL: other values. */
const char *options_words(const option_row *row);
/* Reads an integer from `text` into *out. Returns false if it is no integer or outside [least,
 * most]. */
bool options_number(const char *text, long least, long most, long *out);
/* Reads n finite numbers, separated by commas, into value[n]. Returns false if `text` has another
 * form. */
bool options_reals(const char *text, size_t n, double *value);
/* Selection of n > 0 frames: first, first + step, ..., first + (n - 1) step. */
typedef struct option_range {
  size_t first, step, n;
} option_range;
/* Selects frames, out of `count`, by the text of the option --frames, which works as in Python: "5"
 * or "-1" is one frame, "0:100:10" a slice with a positive step, whose ends may lie beyond the
 * frames; NULL: all frames. count = SIZE_MAX: only checks the syntax, before a file is open. file:
 * name of the file for the message. SD_ERROR_USER: the text is no range, or selects no frame. */
sd_status options_range(const char *text, size_t count, const char *file, option_range *out,
                        sd_messages *messages);
/* Prints an entry of a list in the help: `head`, then from column `column` on the words of `text`,
 * with line breaks. */
void options_entry(FILE *out, const char *head, const char *text, size_t column);
/* Prints the help of a command as described by its table. */
void options_help(FILE *out, const command_line *line);
/* Prints one line as printf does; control characters (in names and titles) are shown as \xHH. */
void app_line(FILE *out, const char *format, ...) SD_PRINTF(2, 3);
/* Prints "error: slipdisk COMMAND: ...; see slipdisk COMMAND --help" and returns SD_ERROR_USER. */
int app_misuse(const char *command, const char *format, ...) SD_PRINTF(2, 3);

#endif

/* options.h: the command line of a subcommand: one table of options each, one parser for all. */
#ifndef SLIPDISK_APP_OPTIONS_H
#define SLIPDISK_APP_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "slipdisk/status.h"

/* Value of an option, and the type of the field that takes it. */
typedef enum option_kind {
  OPTION_FLAG,   /* nothing; bool */
  OPTION_NUMBER, /* a whole number from least to most; long */
  OPTION_REAL,   /* a finite number; option_real */
  OPTION_TEXT,   /* any text, once; const char * */
  OPTION_CHOICE, /* one of the words of `value`, as in "csv|vtk"; const char * */
  OPTION_PATH,   /* a file or a folder to be written, no deck and no result; const char * */
  OPTION_RESULT, /* a result to be written, no deck; const char * */
  OPTION_STREAM, /* the same, or - for the standard output */
  OPTION_LIST    /* any text, again and again; option_list */
} option_kind;

typedef struct option_real {
  bool given;
  double value;
} option_real;

typedef struct option_list {
  size_t n;
  const char **item; /* to be freed */
} option_list;

/* Limits of a number; least and most of a whole one. */
typedef struct option_limits {
  long least, most;
  const char *wrong; /* "--name VALUE" and this: what was expected */
} option_limits;

typedef struct option_row {
  const char *name; /* as in --name */
  char letter;      /* as in -l, which messages then use; 0: none */
  option_kind kind;
  size_t offset;               /* in the arguments of the command */
  const option_limits *limits; /* of a number */
  const char *value;           /* name of its value in the help; NULL: a flag */
  const char *help;
} option_row;

/* Operands of a command. A deck may be -, the standard input. The field behind offset is a const char *; of RESULTS a size_t, place in argv of the first. */
typedef enum operand_kind {
  OPERAND_DECK,
  OPERAND_RESULT,
  OPERAND_RESULTS,
  OPERAND_COMMAND
} operand_kind;

typedef struct command_line {
  const char *name; /* of the command */
  size_t n;
  const option_row *rows;
  operand_kind operand;
  size_t offset;
  bool optional;        /* the command tells itself when none is given */
  const char *operands; /* in the help: "DECK" */
  const char *summary;  /* a line of the list of commands */
  const char *more;     /* lines of its own help; NULL: none */
  const char
      *examples; /* command lines, each with its comment: "slipdisk run deck.cfg   # ...\n" */
} command_line;

/* Fills `arguments`; 0, or the exit status of a mistake, which has been told. */
int options_parse(const command_line *line, int argc, char **argv, void *arguments);
/* A whole number from text; false when it is none or out of range. */
bool options_number(const char *text, long least, long most, long *out);
/* n finite numbers with commas between. */
bool options_reals(const char *text, size_t n, double *value);
/* Frames first, first + step, ...: n of them, n > 0. */
typedef struct option_range {
  size_t first, step, n;
} option_range;
/* The frames among `count` that text (of --frames) chooses, as Python does: "5", "-1" one frame, "0:100:10" a slice, whose
 * ends may lie beyond; NULL: all. The step is positive. SD_ERROR_USER: not a range, or no frame is in it; `file` is for the
 * message. count = SIZE_MAX, before a file is open: tells only whether this can be a range. */
sd_status options_range(const char *text, size_t count, const char *file, option_range *out,
                        sd_messages *messages);
/* A head and, from this column on, words; for lists in helps. */
void options_entry(FILE *out, const char *head, const char *text, size_t column);
/* The help of a command, from its table. */
void options_help(FILE *out, const command_line *line);
/* One line, with control characters of names and titles shown as \xHH. */
void app_line(FILE *out, const char *format, ...) SD_PRINTF(2, 3);
/* Prints "error: slipdisk COMMAND: what; see slipdisk COMMAND --help" and returns the exit status of a user's mistake. */
int app_misuse(const char *command, const char *format, ...) SD_PRINTF(2, 3);

#endif

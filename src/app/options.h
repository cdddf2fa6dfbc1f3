/* options.h: command lines of the subcommands: a table of options for each, and one parser for
 * all. */
#ifndef SLIPDISK_APP_OPTIONS_H
#define SLIPDISK_APP_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "slipdisk/status.h"

/* Kind of an option: the value that it takes, and the C type of the field that receives it. */
typedef enum option_kind {
  OPTION_FLAG,   /* No value; bool */
  OPTION_NUMBER, /* Integer from `least` to `most`; long */
  OPTION_REAL,   /* Finite number; option_real */
  OPTION_TEXT,   /* Any text, given at most once; const char * */
  OPTION_CHOICE, /* One of the words of `value`, such as "csv|vtk"; const char * */
  OPTION_PATH,   /* File or folder to be written, not an existing deck or result; const char * */
  OPTION_RESULT, /* Result to be written, not an existing deck; const char * */
  OPTION_STREAM, /* Like OPTION_PATH, or - for the standard output; const char * */
  OPTION_LIST    /* Any text, may be given several times; option_list */
} option_kind;

typedef struct option_real {
  bool given;
  double value;
} option_real;

typedef struct option_list {
  size_t n;
  const char **item; /* [n] texts of argv; the caller frees the array */
} option_list;

/* Limits of a number; least and most apply to integers only. */
typedef struct option_limits {
  long least, most;
  /* Text of the error message behind "--name VALUE": what was expected */
  const char *wrong;
} option_limits;

typedef struct option_row {
  const char *name; /* Long name, as in --name */
  /* Short name, as in -l, which messages then use; 0: none */
  char letter;
  option_kind kind;
  size_t offset; /* Offset of the field in the arguments of the command */
  /* Limits of a number; NULL for other kinds */
  const option_limits *limits;
  /* Name of the value in the help, or the words of a choice; NULL: a flag */
  const char *value;
  const char *help;
} option_row;

/* Kind of operand of a command. A deck may be -, the standard input. The field behind
 * command_line.offset is a const char *, for OPERAND_RESULTS a size_t: the index in argv of the
 * first result. */
typedef enum operand_kind {
  OPERAND_DECK,
  OPERAND_RESULT,
  OPERAND_RESULTS,
  OPERAND_COMMAND
} operand_kind;

typedef struct command_line {
  const char *name; /* Name of the command */
  size_t n;
  const option_row *rows;
  operand_kind operand;
  size_t offset;
  /* True: the parser accepts a missing operand, which the command handles */
  bool optional;
  const char *operands; /* Operands in the help, such as "DECK" */
  const char *summary;  /* Summary for the list of commands, one line */
  /* Further lines of the help of this command; NULL: none */
  const char *more;
  /* Example command lines, each with a comment: "slipdisk run deck.cfg   # ...\n"; NULL: none */
  const char *examples;
} command_line;

/* Parses a command line into `arguments`. Returns 0, or the exit status of a mistake, which has
 * been printed. */
int options_parse(const command_line *line, int argc, char **argv, void *arguments);
/* Reads an integer from `text` into *out. Returns false if it is no integer or outside [least,
 * most]. */
bool options_number(const char *text, long least, long most, long *out);
/* Reads n finite numbers, separated by commas, into value[n]. Returns false if `text` is anything
 * else. */
bool options_reals(const char *text, size_t n, double *value);
/* Frames first, first + step, ...: n of them, n > 0. */
typedef struct option_range {
  size_t first, step, n;
} option_range;
/* Selects frames among `count` by the text of --frames, as Python does: "5" or "-1" one frame,
 * "0:100:10" a slice with a positive step, whose ends may lie outside; NULL: all. count =
 * SIZE_MAX, before a file is open: only checks the syntax. file: its name for the message.
 * SD_ERROR_USER: the text is no range, or selects no frame. */
sd_status options_range(const char *text, size_t count, const char *file, option_range *out,
                        sd_messages *messages);
/* Prints `head` and, from this column on, the words of `text`, wrapped; for lists in the help. */
void options_entry(FILE *out, const char *head, const char *text, size_t column);
/* Prints the help of a command from its table. */
void options_help(FILE *out, const command_line *line);
/* Prints one line, with control characters of names and titles shown as \xHH. */
void app_line(FILE *out, const char *format, ...) SD_PRINTF(2, 3);
/* Prints "error: slipdisk COMMAND: ...; see slipdisk COMMAND --help" and returns SD_ERROR_USER. */
int app_misuse(const char *command, const char *format, ...) SD_PRINTF(2, 3);

#endif

/* manual.h: pages of the manual (man 7) and completion for bash, written from the tables of the commands. */
#ifndef SLIPDISK_APP_MANUAL_H
#define SLIPDISK_APP_MANUAL_H

#include <stdio.h>

#include "app/options.h"

/* All exit statuses, a line each. */
void manual_statuses(FILE *out);
/* slipdisk(1): commands, exit statuses, environment, files. */
void manual_overview(FILE *out, size_t n, const command_line *const *lines);
/* slipdisk-COMMAND(1) */
void manual_command(FILE *out, const command_line *line);
/* Completes commands, options, values that are a closed set, decks, results and folders. */
void manual_bash(FILE *out, size_t n, const command_line *const *lines);

#endif

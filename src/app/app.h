/* app.h: the subcommands of the program and the functions that they share. Only this directory
 * prints and sets the exit status; the libraries below it return statuses and messages. */
#ifndef SLIPDISK_APP_APP_H
#define SLIPDISK_APP_APP_H

#include <signal.h>
#include <stdbool.h>
#include <stdio.h>

#include "app/options.h"
#include "io/results/frames.h"
#include "io/results/provenance.h"
#include "io/results/summary.h"
#include "slipdisk/model.h"
#include "run/stored.h"

/* Entry points of the subcommands. argv[0] is the name of the subcommand. Each returns the exit
 * status of the process. */
int app_run(int argc, char **argv);
int app_resume(int argc, char **argv);
int app_check(int argc, char **argv);
int app_info(int argc, char **argv);
int app_measure(int argc, char **argv);
int app_export(int argc, char **argv);
int app_verify(int argc, char **argv);
int app_theory(int argc, char **argv);
int app_sweep(int argc, char **argv);
int app_view(int argc, char **argv);
int app_plot(int argc, char **argv);
int app_film(int argc, char **argv);

/* Option tables of the subcommands, for parsing, help, manual pages and completion. */
extern const command_line app_run_line, app_resume_line, app_check_line, app_info_line,
    app_measure_line, app_export_line, app_verify_line, app_theory_line, app_sweep_line,
    app_view_line, app_plot_line, app_film_line;

/* --- drive.c: signals ------------------------------------------------------------------------- */
/* Number of the signal that asked the run to stop at a checkpoint; 0: none */
extern volatile sig_atomic_t app_stop;
/* Handles SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU, SIGALRM and SIGHUP (if it is not ignored):
 * until app_begin_saving is called, each ends the process at once with exit status
 * SD_INTERRUPTED. Ignores SIGXFSZ and SIGPIPE, which then are errors of write. */
void app_catch_signals(void);
/* Makes these signals set app_stop from now on, so that the program can save its state before it
 * ends. */
void app_begin_saving(void);
/* Prints one line to stderr: the run was stopped before its first step, and there was nothing new
 * to save. Signal handlers may call it. */
void app_tell_no_start(void);

/* --- drive.c: a run, from the model to the exit status ---------------------------------------- */
typedef struct drive_options {
  const char *result;
  /* Command line with which the user continues the run, without the program's name */
  const char *again;
  const char *log; /* File to which progress lines are appended; NULL: none */
  long threads;    /* Number of threads; 0: chosen from the size of the system */
  bool force, quiet, verbose;
  /* True: a browser shows the run while it goes on */
  bool live;
  /* Called with the messages when the run fails; NULL: no call */
  void (*failed)(void *user, const sd_messages *messages);
  void *user;
} drive_options;

/* Option rows that `run` and `resume` share. arguments: struct type of the command's arguments;
 * drive: name of its member of type drive_options. */
#define DRIVE_OPTIONS(arguments, drive)                                                            \
  {"quiet",                                                                                        \
   'q',                                                                                            \
   OPTION_FLAG,                                                                                    \
   offsetof(arguments, drive.quiet),                                                               \
   NULL,                                                                                           \
   NULL,                                                                                           \
   "errors and warnings only"},                                                                    \
      {"verbose",                                                                                  \
       'v',                                                                                        \
       OPTION_FLAG,                                                                                \
       offsetof(arguments, drive.verbose),                                                         \
       NULL,                                                                                       \
       NULL,                                                                                       \
       "also version, instruction set, threads and disks"},                                        \
      {"threads",                                                                                  \
       0,                                                                                          \
       OPTION_NUMBER,                                                                              \
       offsetof(arguments, drive.threads),                                                         \
       &(option_limits){1, 4096, " is not a number of threads"},                                   \
       "N",                                                                                        \
       "threads; by default as many as the number of disks is worth"},                             \
      {"live",                                                                                     \
       0,                                                                                          \
       OPTION_FLAG,                                                                                \
       offsetof(arguments, drive.live),                                                            \
       NULL,                                                                                       \
       NULL,                                                                                       \
       "show the run in a browser on this machine, at the address that is printed"},               \
      CONFINED_OPTION, {                                                                           \
    "log", 0, OPTION_PATH, offsetof(arguments, drive.log), NULL, "FILE",                           \
        "append progress and result to a file"                                                     \
  }

/* Both functions are collective. drive_begin starts MPI if the program was built with it, and
 * returns the status; the caller ends MPI with comm_end. drive_agree, called after all ranks have
 * loaded the model together (ranks_load), prints the errors of all ranks and returns the largest of
 * their statuses. */
int drive_begin(const drive_options *options, sd_messages *messages);
int drive_agree(int status, sd_messages *messages);
/* Collective. Runs the model and returns the exit status. messages: messages of the loader, which
 * are printed first. The caller keeps ownership of the model and the messages. */
int drive_run(const sd_model *model, const drive_options *options, sd_messages *messages);

/* Writes into text[size] up to which step the run of this process is saved: "; everything until
 * step 1000 is saved, continue with: slipdisk ...", or "" if no step is saved. Returns the length
 * of the text. Allocates nothing; any thread may call it. */
int drive_describe_saved(char *text, size_t size);

/* --- report.c: tables and lines of text ------------------------------------------------------- */
/* Prints the summary of a run as tables. */
void report_summary(FILE *out, const summary *found);
/* Prints each line of `text` with the prefix `before`. */
void report_lines(FILE *out, const char *before, const char *text);
/* Returns true if a stream is a terminal that can redraw its last line; TERM=dumb cannot. */
bool report_redraws(FILE *out);
/* Replaces the last line of such a terminal by `text`, cut to the width of the terminal. */
void report_status_line(FILE *out, const char *text);
/* Prints one line on the cost of a run: number of steps, wall time, ns per step, number of
 * threads. */
void report_cost(FILE *out, const summary *found, const provenance *origin);
/* Returns the words between the current and the last step in "step 5 of at most 9": "of at most" if
 * the run can end before its last step, because a phase settles or the goal of `until` is met; else
 * "of". */
const char *report_of(const summary *found);
/* Formats a duration as "1:02:03" or "2d 01:02:03" into text[size] and returns it; "?" if it is
 * negative, NAN or beyond 1e9 s. */
const char *report_duration(double seconds, char *text, size_t size);

/* --- size.c: size of a result and memory of a run --------------------------------------------- */
/* Estimated size of a result file, and memory that its run needs. */
typedef struct result_size {
  /* Number of rows of the time series, number of frames, number of contact tables */
  int64_t series, frames, contacts;
  /* Number of contacts assumed in the state and in each contact table */
  size_t most_contacts;
  /* True: the run may end early, and all numbers here are upper bounds */
  bool at_most;
  double bytes;
  /* Peak memory in bytes of a run in one process with most_contacts contacts; correct within 25
   * % */
  double memory;
  /* Share of `memory` for sampled rows that are not yet written to a file, at most, bytes */
  double unsaved;
} result_size;
void size_find(result_size *size, const sd_model *model);
/* Warns if the file system of `folder` has less free space than twice the result, or if the result
 * is larger than 50 GB. */
void size_warn(const result_size *size, const char *folder, sd_messages *messages);
/* Returns the memory of a run in bytes, without the program itself and without sampled rows that
 * are not yet written to a file. */
double size_memory(const sd_model *model);
/* Returns SD_ERROR_IO, with a message, if a run in one process needs more memory than it can get
 * even with the smallest possible number of contacts (state_refuse). Only warns if the estimate
 * size->memory is too large. */
sd_status size_refuse(const sd_model *model, const result_size *size, sd_messages *messages);
/* Formats bytes as "1.2 GB" into text[size] and returns it. */
const char *size_text(double bytes, char *text, size_t size);

/* --- names.c: names, and rows of a run -------------------------------------------------------- */
/* Returns the name of an output in the current folder, "NAME.ending", for a deck ".../NAME.cfg";
 * the caller frees it. */
char *app_default_name(const char *deck, const char *ending);
/* Opens file k of the files of a run that have rows, f->sources[k]; close it with
 * frames_source_close. *out is NULL if it cannot be opened. */
sd_status frames_source_open(const frames *f, size_t k, h5_file **out, sd_messages *messages);
void frames_source_close(const frames *f, h5_file *file);
/* Returns the number of the body (disks first, then walls) to which element k of a time series
 * belongs, as stored in the file, or as in the model if the file does not say. file: may be NULL.
 * UINT32_MAX: the element belongs to no body. */
uint32_t stored_body(const sd_model *m, const h5_file *file, const observable *o, size_t k);

/* --- manual.c: manual pages and completion for bash, made from the option tables -------------- */

/* Exit status of `sweep --no-wait` if other processes run the rest, beside those of sd_status */
enum { APP_ELSEWHERE = 6 };
/* Prints all exit statuses, one per line. */
void manual_statuses(FILE *out);
/* Prints the manual page slipdisk(1): commands, exit statuses, environment, files. */
void manual_overview(FILE *out, size_t n, const command_line *const *lines);
/* Prints the manual page slipdisk-COMMAND(1) of one subcommand. */
void manual_command(FILE *out, const command_line *line);
/* Prints a bash script that completes commands, options, values from closed sets, decks, results
 * and folders. */
void manual_bash(FILE *out, size_t n, const command_line *const *lines);

#endif

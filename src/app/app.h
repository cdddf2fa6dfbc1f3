/* app.h: the subcommands of the program, and what they share. This floor prints and decides the exit status;
 * nothing below it does. */
#ifndef SLIPDISK_APP_APP_H
#define SLIPDISK_APP_APP_H

#include <signal.h>
#include <stdbool.h>
#include <stdio.h>

#include "app/options.h"
#include "io/results/frames.h"
#include "io/results/provenance.h"
#include "io/results/summary.h"
#include "model/model.h"

/* Each takes the arguments from the name of the subcommand on, and returns the exit status. */
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

/* Their options, for the help. */
extern const command_line app_run_line, app_resume_line, app_check_line, app_info_line,
    app_measure_line, app_export_line, app_verify_line, app_theory_line, app_sweep_line,
    app_view_line, app_plot_line, app_film_line;

/* --- drive.c: signals ------------------------------------------------------------------------- */
extern volatile sig_atomic_t
    app_stop; /* number of the signal that asks to stop at a checkpoint; 0: none */
/* From here on these signals end the process at once, with SD_INTERRUPTED. */
void app_catch_signals(void);
/* From here on they set app_stop instead: there is something to save. */
void app_begin_saving(void);
/* One line; signal handlers may call it. */
void app_tell_no_start(void);

/* --- drive.c: a run, from a model to the exit status ------------------------------------------------ */
typedef struct drive_options {
  const char *result;
  const char *again; /* command line that continues the run, without the program's name */
  const char *log;   /* file for progress lines, or NULL */
  long threads;      /* 0: chosen from the size of the system */
  bool force, quiet, verbose;
  bool live;                                               /* shown in a browser while it runs */
  void (*failed)(void *user, const sd_messages *messages); /* may be NULL; told why a run failed */
  void *user;
} drive_options;

/* The options that run and resume share, as rows of a table. */
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
  {                                                                                                \
    "log", 0, OPTION_PATH, offsetof(arguments, drive.log), NULL, "FILE",                           \
        "append progress and result to a file"                                                     \
  }

/* Starts MPI where the program was built with it. All ranks call it, and load the model together
 * (ranks_load); then drive_agree prints what went wrong and returns the largest status of all
 * ranks. comm_end is the caller's. */
int drive_begin(const drive_options *options, sd_messages *messages);
int drive_agree(int status, sd_messages *messages);
/* messages: of the loader, printed first. Takes neither over. */
int drive_run(const sd_model *model, const drive_options *options, sd_messages *messages);

/* Writes into text[size] from which step the run of this process goes on, "; everything until
 * step 1000 is saved, continue with: slipdisk ..."; nothing if it has saved nothing. Returns the
 * length. Allocates nothing; any thread may call it. */
int drive_describe_saved(char *text, size_t size);

/* --- report.c --------------------------------------------------------------------------------------- */
/* Prints the summary as tables. */
void report_summary(FILE *out, const summary *found);
/* The lines of a text, each behind `before`. */
void report_lines(FILE *out, const char *before, const char *text);
/* The last line of a terminal, no longer than that is wide. */
void report_bottom(FILE *out, const char *text);
/* One line on the cost: steps, wall time, ns per step. */
void report_cost(FILE *out, const summary *found, const provenance *origin);
/* "of", or "of at most" when the run can end before: at rest, or with an error bar that is small enough. */
const char *report_of(const summary *found);
/* "1:02:03"; written into text[size]. */
const char *report_duration(double seconds, char *text, size_t size);

/* --- size.c ----------------------------------------------------------------------------------------- */
/* How large a result will be. */
typedef struct result_size {
  int64_t series, frames, contacts; /* rows of the series, frames, contact tables */
  size_t most_contacts;             /* assumed in each table */
  bool at_most;                     /* the run may end early */
  double bytes;
  double memory; /* bytes of a run in one process at its peak, with so many contacts; within 25 % */
  double unsaved; /* at most so much of it is rows that wait for a checkpoint */
} result_size;
void size_find(result_size *size, const sd_model *model);
/* Warns of more than the disk of this folder has room for, and of very large ones. */
void size_warn(const result_size *size, const char *folder, sd_messages *messages);
/* Bytes of it beside those of the program itself and of rows that wait. */
double size_memory(const sd_model *model);
/* SD_ERROR_IO, with a message: a run in one process needs more memory than it can have, whatever
 * contacts it will have (state_refuse). Warns where it does by the estimate. */
sd_status size_refuse(const sd_model *model, const result_size *size, sd_messages *messages);
/* "1.2 GB"; written into text[size]. */
const char *size_text(double bytes, char *text, size_t size);

/* --- place.c: from a name on the command line to what is on disk ------------------------------------- */
typedef struct place {
  char *result;     /* path of the finished file, whether it exists or not */
  char *folder;     /* result.parts */
  char *checkpoint; /* a checkpoint that was named itself, else NULL */
} place;

/* "NAME.ending" for a deck ".../NAME.cfg", in the current folder; to be freed. */
char *app_default_name(const char *deck, const char *ending);
/* name: a result, its folder of parts, or a checkpoint in it. place_free also when it fails. */
sd_status place_find(place *p, const char *name, sd_messages *messages);
void place_free(place *p);
/* Opens the newest checkpoint that is not damaged; no lock is needed. */
sd_status place_open_checkpoint(const place *p, h5_file **out, char **path, sd_messages *messages);

/* --- place.c: the frames of a result, or of an unfinished run --------------------------------- */
/* name as for place_find, or a part. alone: a part was named, whose frames are all there is. frames_close also when it
 * fails. */
sd_status stored_open(frames *f, const char *name, bool *alone, sd_messages *messages);
/* How many there are with the state, which is the last one where it is newer than the newest frame. */
sd_status stored_count(const frames *f, bool alone, size_t *count, sd_messages *messages);
/* File k of those that have its rows, to be released; NULL when it cannot be opened. */
sd_status stored_source(const frames *f, size_t k, h5_file **out, sd_messages *messages);
void stored_release(const frames *f, h5_file *file);
/* Number of the body that element k of a series is about, as the file (may be NULL) says it, else
 * as the model does; UINT32_MAX: none. */
uint32_t stored_body(const sd_model *m, const h5_file *file, const observable *o, size_t k);

/* Pages of the manual (man 7) and completion for bash, written from the tables of the commands. */

/* All exit statuses, a line each. */
void manual_statuses(FILE *out);
/* slipdisk(1): commands, exit statuses, environment, files. */
void manual_overview(FILE *out, size_t n, const command_line *const *lines);
/* slipdisk-COMMAND(1) */
void manual_command(FILE *out, const command_line *line);
/* Completes commands, options, values that are a closed set, decks, results and folders. */
void manual_bash(FILE *out, size_t n, const command_line *const *lines);

#endif

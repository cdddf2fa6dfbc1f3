/* main.c: which subcommand. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* vasprintf */
#endif
#include <errno.h>
#include <jansson.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "app/app.h"
#include "base/shortage.h"
#include "base/limits.h"
#include "base/text.h"
#include "base/guess.h"
#include "version.h"

static const char help[] =
    "slipdisk: frictional disks in two dimensions\n"
    "\n"
    "  slipdisk run DECK [-o FILE] [-D path=value]... [--force] [--quiet] [--threads N] [--log FILE]\n"
    "      Runs a deck. The result is FILE, by default NAME.h5 in the current folder for a deck NAME.cfg.\n"
    "      A run that was stopped or killed continues from its last checkpoint when the same command is\n"
    "      given again. A finished result is replaced only with --force.\n"
    "  slipdisk resume FILE [--quiet] [--threads N] [--log FILE]\n"
    "      Continues a run from what it has stored; FILE is the result's name, its folder FILE.parts, or a\n"
    "      checkpoint in it. The deck is not needed.\n"
    "  slipdisk check DECK [-D path=value]...\n"
    "      Reads a deck, reports every mistake, prints it with all defaults, and estimates the run time.\n"
    "  slipdisk sweep DECK [-j N] [-o FOLDER] [-D path=value]... [--force] [--quiet] [--threads N] [--mix] "
    "[--skip]\n"
    "      Runs all points of the deck's group `sweep`, N at a time, into FOLDER (by default NAME.sweep), "
    "and\n"
    "      writes a table of the results. Given again it continues; points that failed are tried again.\n"
    "      Under mpirun (in a build with MPI) the ranks share the points. Instead of running all:\n"
    "        --status  how far it is      --list  all points, with their numbers    --count  how many\n"
    "        --table   writes the table   --point K or --point K-L  runs these points only\n"
    "      Points in FOLDER that belong to another deck or sweep stop it; --mix leaves them there and goes "
    "on.\n"
    "      Mistakes of some points stop it; --skip runs the others.\n"
    "      Alike points of few disks run side by side in the lanes of vectors; --no-lanes runs each by\n"
    "      itself, to the same results.\n"
    "  slipdisk info FILE [--json] [--deck] [--deck-as-read]\n"
    "      What a run has found, finished or not. --json: for programs. --deck: the complete deck it was run "
    "with;\n"
    "      --deck-as-read: as it was written, without -D and the point of a sweep.\n"
    "  slipdisk measure FILE [--frame K | --time T | --all] [--json] [-o FILE] [--csv FOLDER] [--bins N]\n"
    "                        [--region x0,x1,y0,y1]\n"
    "      What a packing is like: contacts, packing fractions, stress, fabric, forces; of the last state or "
    "of\n"
    "      stored frames. -o: for programs, into FILE. --csv: tables of disks, contacts, g(r), forces.\n"
    "  slipdisk verify FILE... [--quiet] [--seal]\n"
    "      Compares all bytes of results, unfinished runs or sweeps with their checksums; exit status 4 when "
    "one\n"
    "      is damaged. --seal: makes the checksum of a file anew that was changed on purpose.\n"
    "  slipdisk theory DECK [-D path=value]... [--json] [--wave FILE] [--csv FILE]\n"
    "      What theory says of a disk on two turning supports: torques, periodic states, mean rotation.\n"
    "      --json: for programs. --wave: the curves of one period. --csv: a row per set of the sweep.\n"
    "      A FILE of - is the standard output.\n"
    "  slipdisk version\n"
    "  slipdisk help\n"
    "\n"
    "Exit status: 0 done, 2 mistake in deck or command, 3 numerical error, 4 input or output failed or no\n"
    "memory, 5 done, but the result is in doubt (energy budget, open contacts, disks too fast: see its\n"
    "warnings), 75 stopped by a signal after a checkpoint (INT, TERM, HUP, USR1, USR2, XCPU, ALRM): give "
    "the\n"
    "command again to continue.\n";

char *app_default_name(const char *deck, const char *ending) {
  const char *slash = strrchr(deck, '/'), *name = slash ? slash + 1 : deck, *dot = strrchr(name, '.');
  size_t length = dot && dot > name ? (size_t)(dot - name) : strlen(name);
  return format_text("%.*s.%s", (int)length, name, ending);
}

static char *shown_text(const char *format, va_list args) {
  char *text = NULL, *shown = vasprintf(&text, format, args) < 0 ? NULL : text_escaped(text, LIMIT_LINE);
  free(text);
  return shown;
}

void app_line(FILE *out, const char *format, ...) {
  va_list args;
  va_start(args, format);
  char *shown = shown_text(format, args);
  va_end(args);
  fprintf(out, "%s\n", shown ? shown : "no memory");
  free(shown);
}

int app_misuse(const char *command, const char *format, ...) {
  va_list args;
  va_start(args, format);
  char *shown = shown_text(format, args);
  va_end(args);
  fprintf(stderr, "slipdisk %s: %s; see slipdisk help\n", command, shown ? shown : "no memory");
  free(shown);
  return SD_ERROR_USER;
}

static int app_version(int argc, char **argv) {
  (void)argc, (void)argv;
  printf("slipdisk %s (%s), %s\n", SD_VERSION, SD_GIT_REVISION, SD_COMPILER);
  return 0;
}

static int app_help(int argc, char **argv) {
  (void)argc, (void)argv;
  fputs(help, stdout);
  return 0;
}

static const struct command {
  const char *name;
  int (*main)(int argc, char **argv);
  bool prints; /* what it has found is what it prints */
} commands[] = {
    {"run", app_run, false},         {"resume", app_resume, false},     {"check", app_check, true},
    {"info", app_info, true},        {"measure", app_measure, true},    {"verify", app_verify, true},
    {"theory", app_theory, true},    {"sweep", app_sweep, true},        {"help", app_help, false},
    {"version", app_version, false}, {"--version", app_version, false}, {"--help", app_help, false},
    {"-h", app_help, false},
};

/* check has a page of its own. */
static bool wants_help(int argc, char **argv) {
  for (int k = 2; k < argc && strcmp(argv[k], "--") != 0; k++)
    if (strcmp(argv[k], "--help") == 0 || strcmp(argv[k], "-h") == 0) return strcmp(argv[1], "check") != 0;
  return false;
}

static int run_command(int argc, char **argv) {
  if (argc < 2) {
    fputs(help, stderr);
    return SD_ERROR_USER;
  }
  for (size_t k = 0; k < sizeof commands / sizeof *commands; k++)
    if (strcmp(argv[1], commands[k].name) == 0) {
      int status = wants_help(argc, argv) ? app_help(argc, argv) : commands[k].main(argc - 1, argv + 1);
      /* results may have been printed into a full disk */
      if ((fflush(stdout) != 0 || ferror(stdout)) && status == 0) {
        fprintf(stderr, "error: cannot write to the standard output: %s\n", strerror(errno));
        status = SD_ERROR_IO;
      }
      if (status == 0 && commands[k].prints && shortage_seen()) {
        fprintf(stderr, "error: there was no memory for part of this: what was printed may be incomplete\n");
        status = SD_ERROR_IO;
      }
      return status;
    }
  guess near = guess_start(argv[1]);
  for (size_t k = 0; k < sizeof commands / sizeof *commands; k++) guess_add(&near, commands[k].name);
  char *shown = text_escaped(argv[1], LIMIT_QUOTE);
  fprintf(stderr, "slipdisk: there is no command \"%s\"; ", shown ? shown : "");
  free(shown);
  if (near.best) fprintf(stderr, "did you mean \"%s\"? ", near.best);
  fprintf(stderr, "See slipdisk help\n");
  return SD_ERROR_USER;
}

static bool leaving; /* by its own will */

int app_no_memory(void) {
  fputs("error: no memory\n", stderr);
  return SD_ERROR_IO;
}

sd_messages *app_messages(void) {
  sd_messages *messages = sd_messages_new();
  if (messages) return messages;
  leaving = true;
  exit(app_no_memory());
}

/* Libraries that have no memory call exit (HDF5, OpenMP, the reader of decks), some of them without a word. */
static void end_of_library(void) {
  static const char text[] = "error: a library has ended the process, as some do without memory; what was "
                             "saved before is not damaged\n";
  if (leaving) return;
  ssize_t told = write(STDERR_FILENO, text, sizeof text - 1);
  (void)told; /* there is no other way to tell it */
  _exit(SD_ERROR_IO);
}

static void *json_memory(size_t size) {
  void *memory = malloc(size);
  if (!memory) shortage_note();
  return memory;
}

int main(int argc, char **argv) {
  json_set_alloc_funcs(json_memory, free);
  if (atexit(end_of_library) != 0) return app_no_memory();
  int status = run_command(argc, argv);
  leaving = true;
  return status;
}

/* main.c: finds the subcommand and runs it. */
#include <errno.h>
#include <jansson.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "app/app.h"
#include "base/comm.h"
#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/store/h5.h"
#include "slipdisk/deck.h"
#include "version.h"

static int app_version(int argc, char **argv) {
  (void)argc, (void)argv;
  printf("slipdisk %s (%s), %s\n", SD_VERSION, SD_GIT_REVISION, SD_COMPILER);
  return 0;
}

static int app_help(int argc, char **argv);

typedef struct help_arguments {
  const char *command;
  bool man, bash;
} help_arguments;

static const option_row help_rows[] = {
    {"man", 0, OPTION_FLAG, offsetof(help_arguments, man), NULL, NULL,
     "as a page of the manual, for man -l -"},
    {"bash", 0, OPTION_FLAG, offsetof(help_arguments, bash), NULL, NULL,
     "completion for bash, to be read by its command source"},
};
static const command_line help_line = {
    .name = "help",
    .n = sizeof help_rows / sizeof *help_rows,
    .rows = help_rows,
    .operand = OPERAND_COMMAND,
    .offset = offsetof(help_arguments, command),
    .optional = true,
    .operands = "[COMMAND]",
    .summary = "Tells the options of a command; without one, all commands",
    .examples = "slipdisk help run                       # the same as slipdisk run --help\n"
                "slipdisk help --man run | man -l -\n"
                "source <(slipdisk help --bash)          # the tab key completes commands, "
                "options, decks, results\n",
};

static const struct command {
  const char *name;
  int (*main)(int argc, char **argv);
  const command_line *line; /* Option table of the subcommand; NULL: it has no options */
  /* True: the subcommand's result is the text that it prints, which may be incomplete if memory ran
   * out */
  bool prints;
} commands[] = {
    {"run", app_run, &app_run_line, false},
    {"resume", app_resume, &app_resume_line, false},
    {"check", app_check, &app_check_line, true},
    {"sweep", app_sweep, &app_sweep_line, true},
    {"info", app_info, &app_info_line, true},
    {"measure", app_measure, &app_measure_line, true},
    {"export", app_export, &app_export_line, false},
    {"view", app_view, &app_view_line, false},
    {"plot", app_plot, &app_plot_line, false},
    {"film", app_film, &app_film_line, false},
    {"verify", app_verify, &app_verify_line, true},
    {"theory", app_theory, &app_theory_line, true},
    {"help", app_help, &help_line, false},
    {"version", app_version, NULL, false},
    {"--version", app_version, NULL, false},
    {"-V", app_version, NULL, false},
    {"-v", app_version, NULL, false},
    {"--help", app_help, NULL, false},
    {"-h", app_help, NULL, false},
};
enum { N_COMMANDS = sizeof commands / sizeof *commands };

static const struct command *find_command(const char *name) {
  for (size_t k = 0; k < N_COMMANDS; k++)
    if (strcmp(name, commands[k].name) == 0) return &commands[k];
  return NULL;
}

static void print_commands(FILE *out) {
  int name = 0, operands = 0;
  for (size_t k = 0; k < N_COMMANDS; k++) {
    const command_line *line = commands[k].line;
    if (line && (int)strlen(line->name) > name) name = (int)strlen(line->name);
    if (line && (int)strlen(line->operands) > operands) operands = (int)strlen(line->operands);
  }
  fputs("slipdisk: frictional disks in two dimensions\n\n", out);
  for (size_t k = 0; k < N_COMMANDS; k++)
    if (commands[k].line)
      fprintf(out, "  slipdisk %-*s %-*s  %s\n", name, commands[k].name, operands,
              commands[k].line->operands, commands[k].line->summary);
  fputs("\n  slipdisk COMMAND --help     the options of a command\n"
        "  slipdisk version            also -V, --version\n\n",
        out);
  manual_statuses(out);
}

static int unknown_command(const char *name) {
  if (*name == '-') {
    app_line(stderr, "error: %s: options stand behind a command; see slipdisk help", name);
    return SD_ERROR_USER;
  }
  guess near = guess_start(name);
  for (size_t k = 0; k < N_COMMANDS; k++) guess_add(&near, commands[k].name);
  char *shown = text_escaped(name, LIMIT_QUOTE);
  fprintf(stderr, "error: there is no command \"%s\"; ", shown);
  free(shown);
  if (near.best) fprintf(stderr, "did you mean \"%s\"? ", near.best);
  fprintf(stderr, "See slipdisk help\n");
  return SD_ERROR_USER;
}

static void print_manual(const command_line *one, bool bash) {
  const command_line *lines[N_COMMANDS];
  size_t n = 0;
  for (size_t k = 0; k < N_COMMANDS; k++)
    if (commands[k].line) lines[n++] = commands[k].line;
  if (bash)
    manual_bash(stdout, n, lines);
  else if (one)
    manual_command(stdout, one);
  else
    manual_overview(stdout, n, lines);
}

static int app_help(int argc, char **argv) {
  help_arguments a = {0};
  int status = options_parse(&help_line, argc, argv, &a);
  if (status) return status;
  const struct command *one = a.command ? find_command(a.command) : NULL;
  if (a.command && !one) return unknown_command(a.command);
  if (a.man || a.bash)
    print_manual(one ? one->line : NULL, a.bash);
  else if (one && one->line)
    options_help(stdout, one->line);
  else
    print_commands(stdout);
  return 0;
}

static bool wants_help(int argc, char **argv) {
  for (int k = 2; k < argc && strcmp(argv[k], "--") != 0; k++)
    if (strcmp(argv[k], "--help") == 0 || strcmp(argv[k], "-h") == 0) return true;
  return false;
}

static int run_command(int argc, char **argv) {
  if (argc < 2) {
    print_commands(stderr);
    return SD_ERROR_USER;
  }
  /* started by this program itself, or by a program that uses the library */
  if (argc == 4 && strcmp(argv[1], H5_PROBE_COMMAND) == 0) h5_probe_serve(argv[2], argv[3]);
  const struct command *one = find_command(argv[1]);
  if (!one) return unknown_command(argv[1]);
  int status = 0;
  if (one->line && wants_help(argc, argv))
    options_help(stdout, one->line);
  else
    status = one->main(argc - 1, argv + 1);
  /* Printing may have failed, for example because the disk is full. */
  if ((fflush(stdout) != 0 || ferror(stdout)) && status == 0) {
    fprintf(stderr, "error: cannot write to the standard output: %s\n", strerror(errno));
    status = SD_ERROR_IO;
  }
  if (status == 0 && one->prints && shortage_seen()) {
    fprintf(stderr,
            "error: there was no memory for part of this: what was printed may be incomplete\n");
    status = SD_ERROR_IO;
  }
  return status;
}

static bool leaving; /* True as soon as main is about to return, which calls exit */

/* Ends the process when memory for small objects runs out; main sets it as sd_on_no_memory. A run
 * loses only the steps since its last checkpoint. Allocates nothing. */
static void end_without_memory(size_t bytes) {
  char text[LIMIT_LINE], rank[40] = "", amount[60] = "";
  if (comm_world()) snprintf(rank, sizeof rank, "rank %d: ", comm_rank(comm_world()));
  if (bytes > 0) snprintf(amount, sizeof amount, " (%zu bytes more)", bytes);
  int n = snprintf(text, sizeof text, "error: %sno memory%s", rank, amount);
  n += drive_describe_saved(text + n, sizeof text - (size_t)n - 1);
  text[n++] = '\n';
  ssize_t told = write(STDERR_FILENO, text, (size_t)n);
  (void)told; /* An error of this write cannot be reported. */
  comm_abort(comm_world(), SD_ERROR_IO);
  _exit(SD_ERROR_IO);
}

/* Called by exit. If main has not returned, a library (HDF5, libconfig) has called exit because it
 * ran out of memory, perhaps without a message. */
static void end_of_library(void) {
  static const char text[] =
      "error: a library has ended the process, as some do without memory; what was "
      "saved before is not damaged\n";
  if (leaving) return;
  ssize_t told = write(STDERR_FILENO, text, sizeof text - 1);
  (void)told; /* An error of this write cannot be reported. */
  _exit(SD_ERROR_IO);
}

static pid_t first_process; /* the one that main began in */

/* Ends the process after a fault or a call of abort, which libraries make when they do not get
 * memory. Signals that another process sends keep their effect, and all do in workers of sweeps:
 * their scheduler tells how they ended. */
static void end_of_fault(int number, siginfo_t *from, void *unused) {
  (void)unused;
  static const char text[] = "error: no memory, perhaps: a library has crashed, as some do then "
                             "(if there is memory, it is "
                             "a fault of slipdisk); what was saved before is not damaged\n";
  const bool ours = getpid() == first_process &&
                    (number == SIGABRT ? from->si_pid == first_process : from->si_code > 0);
  if (!ours) {
    raise(number); /* SA_RESETHAND has restored the default */
    return;
  }
  ssize_t told = write(STDERR_FILENO, text, sizeof text - 1);
  (void)told; /* An error of this write cannot be reported. */
  _exit(SD_ERROR_IO);
}

/* Leaves handlers alone that are there already: those of sanitizers. */
static void catch_faults(void) {
  struct sigaction act = {.sa_sigaction = end_of_fault,
                          .sa_flags = SA_SIGINFO | SA_RESETHAND | SA_ONSTACK},
                   was;
  static char room[1 << 16]; /* for a library whose recursion has no end */
  first_process = getpid();
  sigaltstack(&(stack_t){.ss_sp = room, .ss_size = sizeof room}, NULL);
  sigemptyset(&act.sa_mask);
  for (int k = 0; k < 2; k++) {
    const int number = k == 0 ? SIGSEGV : SIGABRT;
    if (sigaction(number, NULL, &was) == 0 && was.sa_handler == SIG_DFL)
      sigaction(number, &act, NULL);
  }
}

static void *json_memory(size_t size) { return memory_new(size, 1); }

/* Makes free return large blocks to the system. By default glibc raises its thresholds to the sizes
 * of freed blocks, and so keeps ever larger blocks for the process. */
static void return_memory(void) {
#ifdef M_MMAP_THRESHOLD
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  mallopt(M_TRIM_THRESHOLD, 1 << 22);
#endif
}

int main(int argc, char **argv) {
  return_memory();
  sd_on_no_memory(end_without_memory);
  catch_faults();
  sd_set_program("/proc/self/exe");
  json_set_alloc_funcs(json_memory, free);
  if (atexit(end_of_library) != 0) memory_lacks(0);
  int status = run_command(argc, argv);
  leaving = true;
  return status;
}

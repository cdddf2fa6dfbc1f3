/* plot.c: `slipdisk plot` and `slipdisk film` check their options and start the Python package,
 * which makes the pictures. See docs/plots.md. */
#include <errno.h>
#include <limits.h>
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/app.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"

#define QUANTITIES "omega|turned|spin|speed|vx|vy|moved|radius|contacts|pressure|fraction|group"
#define KINDS                                                                                      \
  "rotation|spin|configurations|energy|contact|paths|map|network|bonds|breaks|forces|gr|"          \
  "profile|means|compression|stress|shear|walls|flow|curve|list"
#define COLOR_HELP                                                                                 \
  "what colours disks; by default omega (means of every disk), else turned (angle between "        \
  "frames), else "                                                                                 \
  "spin"
#define REGION_HELP "the part of the plane that is shown; by default about the disks"

typedef struct arguments {
  const char *file, *output, *frames, *time, *color, *quantity, *x, *size, *region;
  option_list kinds;
  long frame, dpi;
  option_real fps;
  bool network, dark;
} arguments;

enum { NO_FRAME = INT_MIN };

static const option_row plot_rows[] = {
    {"output", 'o', OPTION_PATH, offsetof(arguments, output), NULL, "PICTURE",
     ".png, .svg or .pdf; by default the name of FILE with .png, in the current folder"},
    {"kind", 'k', OPTION_LIST, offsetof(arguments, kinds), &(option_limits){0, 0, KINDS}, "KIND",
     "what is drawn, many times for a page; list tells what this FILE has"},
    {"frame", 0, OPTION_NUMBER, offsetof(arguments, frame),
     &(option_limits){-1000000000, 1000000000,
                      ": expected the number of a frame, from 0, or from the end as -1"},
     "K", "frame of maps, networks, distributions; by default the last one"},
    {"time", 0, OPTION_TEXT, offsetof(arguments, time), NULL, "FROM:TO",
     "part of the time series that is drawn; either may be left out"},
    {"color", 0, OPTION_CHOICE, offsetof(arguments, color), NULL, QUANTITIES, COLOR_HELP},
    {"region", 0, OPTION_TEXT, offsetof(arguments, region), NULL, "X0,X1,Y0,Y1", REGION_HELP},
    {"quantity", 0, OPTION_TEXT, offsetof(arguments, quantity), NULL, "COLUMN",
     "kind curve: a column of the series, or of a sweep what it is drawn by; list names them"},
    {"x", 0, OPTION_TEXT, offsetof(arguments, x), NULL, "COLUMN",
     "kind curve: against what; by default time, or of a sweep the key with most values"},
    {"size", 0, OPTION_TEXT, offsetof(arguments, size), NULL, "WxH", "width and height in inches"},
    {"dpi", 0, OPTION_NUMBER, offsetof(arguments, dpi),
     &(option_limits){20, 2400, ": expected 20 to 2400 pixels per inch"}, "N",
     "pixels per inch of a PNG; by default 200, more for maps of many disks"},
    {"dark", 0, OPTION_FLAG, offsetof(arguments, dark), NULL, NULL, "light on dark"},
};
const command_line app_plot_line = {
    .name = "plot",
    .n = sizeof plot_rows / sizeof *plot_rows,
    .rows = plot_rows,
    .operand = OPERAND_RESULT,
    .offset = offsetof(arguments, file),
    .operands = "FILE|SWEEP",
    .summary = "Draws a result or a sweep: what fits it, or the kinds that are named",
    .more = "Rotation, sliding, energies, maps, force networks, bonds, distributions, profiles, "
            "compression, curves.\n"
            "Needs python3 with numpy, h5py and matplotlib.\n",
    .examples =
        "slipdisk plot deck.h5                              # deck.png: what fits this result\n"
        "slipdisk plot deck.h5 --kind list                  # what else there is\n"
        "slipdisk plot deck.h5 -k rotation -o rotation.pdf  # the mean rotation with its error "
        "band\n"
        "slipdisk plot deck.h5 --quantity list              # columns for --quantity and --x\n"};

static const option_row film_rows[] = {
    {"output", 'o', OPTION_PATH, offsetof(arguments, output), NULL, "FILM",
     ".mp4 or .gif; by default the name of FILE with .mp4, in the current folder"},
    {"frames", 0, OPTION_TEXT, offsetof(arguments, frames), NULL, "RANGE",
     "FIRST:END:STEP as slices in Python; by default all"},
    {"color", 0, OPTION_CHOICE, offsetof(arguments, color), NULL, QUANTITIES, COLOR_HELP},
    {"network", 0, OPTION_FLAG, offsetof(arguments, network), NULL, NULL,
     "contacts as lines as wide as their force"},
    {"fps", 0, OPTION_REAL, offsetof(arguments, fps),
     &(option_limits){0, 0, ": expected a number of frames per second > 0"}, "N",
     "frames per second; by default 5 to 30, for a film of ten seconds"},
    {"size", 0, OPTION_TEXT, offsetof(arguments, size), NULL, "WxH", "width and height in pixels"},
    {"region", 0, OPTION_TEXT, offsetof(arguments, region), NULL, "X0,X1,Y0,Y1", REGION_HELP},
    {"dark", 0, OPTION_FLAG, offsetof(arguments, dark), NULL, NULL, "light on dark"},
};
const command_line app_film_line = {
    .name = "film",
    .n = sizeof film_rows / sizeof *film_rows,
    .rows = film_rows,
    .operand = OPERAND_RESULT,
    .offset = offsetof(arguments, file),
    .operands = "FILE",
    .summary = "Makes a film of the stored frames, MP4 or GIF",
    .more = "Needs ffmpeg, and python3 with numpy, h5py and matplotlib.\n",
    .examples = "slipdisk film deck.h5                                # deck.mp4\n"
                "slipdisk film deck.h5 --frames ::2 -o deck.gif       # every other frame\n"
                "slipdisk film deck.h5 --color spin --network         # the spin, and forces at "
                "contacts\n"};

/* --- checks of the options -------------------------------------------------------------------- */

/* Reads two numbers with the character `between` between them. missing: true allows that one or
 * both are left out. Returns false if the text has another form. */
static bool two_numbers(const char *text, char between, bool missing, double value[2]) {
  for (int k = 0; k < 2; k++) {
    char *end;
    value[k] = strtod(text, &end);
    if ((end == text && !missing) || *end != (k == 0 ? between : 0)) return false;
    text = end + 1;
  }
  return true;
}

static int examine(const char *command, const arguments *a) {
  double v[4];
  if (a->time && !two_numbers(a->time, ':', true, v))
    return app_misuse(command, "--time %s: expected FROM:TO, as 2:3.5 or 2:", a->time);
  if (a->size && (!two_numbers(a->size, 'x', false, v) ||
                  !(v[0] >= 1 && v[1] >= 1 && v[0] < 2e4 && v[1] < 2e4)))
    return app_misuse(command, "--size %s: expected WIDTHxHEIGHT", a->size);
  if (a->region && (!options_reals(a->region, 4, v) || !(v[0] < v[1] && v[2] < v[3])))
    return app_misuse(command, "--region %s: expected X0,X1,Y0,Y1 with X0 < X1 and Y0 < Y1",
                      a->region);
  if (a->fps.given && !(a->fps.value > 0 && a->fps.value <= 1000))
    return app_misuse(command, "--fps %g: expected a number of frames per second > 0",
                      a->fps.value);
  return 0;
}

/* --- Python interpreter ----------------------------------------------------------------------- */

/* Returns the folder of the Python package in the checkout or installation of slipdisk to which
 * this executable belongs; the caller frees it. NULL: not found. */
static char *package_folder(const char *program) {
  static const char *const places[] = {"tools/python", SD_PYTHON_DIR};
  char up[PATH_MAX];
  snprintf(up, sizeof up, "%s", program);
  for (char *slash; (slash = strrchr(up, '/')) != NULL;) {
    *slash = 0;
    for (size_t k = 0; k < sizeof places / sizeof *places; k++) {
      char *folder =
          *places[k] == '/' ? memory_text(places[k]) : format_text("%s/%s", up, places[k]);
      char *module = format_text("%s/slipdisk/plot.py", folder);
      bool here = file_exists(module);
      free(module);
      if (here) return folder;
      free(folder);
    }
  }
  return NULL;
}

static const char *const modules[] = {"numpy", "h5py", "matplotlib", "slipdisk"};
enum { MODULES = sizeof modules / sizeof *modules, FOUND = 64 };

/* Python code that removes "", the current folder, from the module path, so that no file there is
 * imported instead of a module. */
#define SAFE_PATH "import sys\nsys.path[:] = [folder for folder in sys.path if folder]\n"

/* Returns a bit mask of the modules that this Python interpreter lacks: bit k stands for
 * modules[k]. Returns -1 if the interpreter does not run. */
static int modules_missing(const char *python) {
  static const char look[] = SAFE_PATH
      "import importlib.util as u\n"
      "names = 'numpy', 'h5py', 'matplotlib', 'slipdisk'\n"
      "sys.exit(64 + sum(1 << k for k, name in enumerate(names) if u.find_spec(name) is None))\n";
  fflush(NULL);
  pid_t child = fork();
  if (child == 0) {
    if (!freopen("/dev/null", "w", stderr)) _exit(126);
    execlp(python, python, "-c", look, (char *)NULL);
    _exit(127);
  }
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) < 0)
    if (errno != EINTR) return -1;
  if (child < 0 || !WIFEXITED(status) || WEXITSTATUS(status) < FOUND ||
      WEXITSTATUS(status) >= FOUND + (1 << MODULES))
    return -1;
  return WEXITSTATUS(status) - FOUND;
}

/* Returns the interpreter that SLIPDISK_PYTHON names, else the first one that has all modules;
 * NULL, after an error message, if it lacks some. */
static const char *find_python(const char *command) {
  const char *asked = getenv("SLIPDISK_PYTHON");
  const bool named = asked && *asked;
  const char *names[] = {named ? asked : "/usr/bin/python3", "python3"};
  char told[600] = "";
  for (size_t k = 0; k < (named ? 1 : sizeof names / sizeof *names); k++) {
    int missing = modules_missing(names[k]);
    if (missing == 0) return names[k];
    size_t n = strlen(told);
    snprintf(told + n, sizeof told - n, "%s%.100s %s", n ? "; " : "", names[k],
             missing < 0 ? "does not run" : "lacks");
    for (size_t j = 0; missing > 0 && j < MODULES; j++)
      if (missing >> j & 1)
        strncat(strncat(told, " ", sizeof told - strlen(told) - 1), modules[j],
                sizeof told - strlen(told) - 1);
  }
  app_line(stderr,
           "error: slipdisk %s needs python3 with numpy, h5py and matplotlib: %s (apt install "
           "python3-numpy python3-h5py python3-matplotlib, in an environment pip install "
           "matplotlib; or set SLIPDISK_PYTHON)",
           command, told);
  return NULL;
}

/* Sets the environment variables PYTHONPATH and SLIPDISK_PROGRAM, so that the Python interpreter
 * finds the package and this program. */
static void prepare_environment(void) {
  char program[PATH_MAX];
  ssize_t n = readlink("/proc/self/exe", program, sizeof program - 1);
  if (n < 0) return; /* Python may find the package and this program without these variables */
  program[n] = 0;
  char *folder = package_folder(program);
  if (!folder) return;
  const char *own = getenv("PYTHONPATH");
  char *path = own && *own ? format_text("%s:%s", folder, own) : memory_text(folder);
  if (setenv("PYTHONPATH", path, 1) != 0 || setenv("SLIPDISK_PROGRAM", program, 0) != 0)
    memory_lacks(strlen(path));
  free(folder);
  free(path);
}

/* Command line of the Python interpreter. */
typedef struct word_list {
  size_t n;
  char **word;
} word_list;

static void add_option(word_list *list, const char *name, const char *value) {
  if (value) list->word[list->n++] = format_text("--%s=%s", name, value);
}

static void add_number(word_list *list, const char *name, bool given, double value) {
  if (given) list->word[list->n++] = format_text("--%s=%.17g", name, value);
}

static void add_all(word_list *list, const arguments *a) {
  add_option(list, "output", a->output);
  for (size_t k = 0; k < a->kinds.n; k++) add_option(list, "kind", a->kinds.item[k]);
  add_option(list, "frames", a->frames);
  add_option(list, "time", a->time);
  add_option(list, "color", a->color);
  add_option(list, "region", a->region);
  add_option(list, "quantity", a->quantity);
  add_option(list, "x", a->x);
  add_option(list, "size", a->size);
  add_number(list, "frame", a->frame != NO_FRAME, (double)a->frame);
  add_number(list, "dpi", a->dpi > 0, (double)a->dpi);
  add_number(list, "fps", a->fps.given, a->fps.value);
  if (a->network) list->word[list->n++] = memory_text("--network");
  if (a->dark) list->word[list->n++] = memory_text("--dark");
}

/* --- the child process ------------------------------------------------------------------------ */

static volatile sig_atomic_t drawing; /* process id of the Python interpreter; 0: none */

/* Hands a signal on. Those of a terminal reach the child, too, and are left to it. */
static void hand_on(int number, siginfo_t *from, void *unused) {
  (void)unused;
  if (from->si_code <= 0 && drawing > 0) kill(drawing, number);
}

/* Returns the exit status of this process: that of Python if it is one of the program's, else
 * SD_ERROR_IO after a message. A signal that ended Python on request ends this process, too. */
static int status_of(const char *command, const char *python, int how) {
  if (WIFSIGNALED(how)) {
    const int number = WTERMSIG(how);
    if (number == SIGINT || number == SIGTERM || number == SIGHUP) {
      signal(number, SIG_DFL);
      raise(number);
    }
    app_line(stderr, "error: slipdisk %s: %s was ended by signal %d (%s); no memory, perhaps",
             command, python, number, strsignal(number));
    return SD_ERROR_IO;
  }
  const int status = WEXITSTATUS(how);
  if (status == SD_OK || (status >= SD_ERROR_USER && status <= SD_ERROR_IO) ||
      status == 128 + SIGINT)
    return status;
  app_line(stderr,
           "error: slipdisk %s: %s failed with status %d: it could not start, lacks a module or "
           "has no memory; its own words stand before",
           command, python, status);
  return SD_ERROR_IO;
}

/* Runs the command line, waits for it and returns the exit status of this process. */
static int run_python(const char *command, char **word) {
  static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
  struct sigaction act = {.sa_sigaction = hand_on, .sa_flags = SA_SIGINFO | SA_RESTART}, was;
  sigset_t few, before;
  sigemptyset(&few);
  for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++) sigaddset(&few, numbers[k]);
  sigprocmask(SIG_BLOCK, &few, &before);
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    sigprocmask(SIG_SETMASK, &before, NULL);
    execvp(word[0], word);
    app_line(stderr, "error: %s cannot be run: %s", word[0], strerror(errno));
    _exit(SD_ERROR_IO);
  }
  drawing = child;
  for (size_t k = 0; k < sizeof numbers / sizeof *numbers; k++)
    if (sigaction(numbers[k], NULL, &was) == 0 && was.sa_handler != SIG_IGN)
      sigaction(numbers[k], &act, NULL);
  sigprocmask(SIG_SETMASK, &before, NULL);
  int how = 0;
  while (child > 0 && waitpid(child, &how, 0) < 0)
    if (errno != EINTR) return SD_ERROR_IO;
  if (child > 0) return status_of(command, word[0], how);
  app_line(stderr, "error: %s cannot be run: %s", word[0], strerror(errno));
  return SD_ERROR_IO;
}

static int draw_with_python(const char *command, const arguments *a) {
  prepare_environment();
  const char *python = find_python(command);
  if (!python) return SD_ERROR_IO;
  enum { MOST = 24 };
  word_list list = {0, memory_new(MOST + a->kinds.n, sizeof *list.word)};
  list.word[list.n++] = memory_text(python);
  list.word[list.n++] = memory_text("-c");
  list.word[list.n++] = format_text(
      SAFE_PATH
      "import runpy\nrunpy.run_module('slipdisk.%s', run_name='__main__', alter_sys=True)",
      command);
  add_all(&list, a);
  list.word[list.n++] = memory_text("--");
  list.word[list.n++] = memory_text(a->file);
  const int status = run_python(command, list.word);
  for (size_t k = 0; k < list.n; k++) free(list.word[k]);
  free(list.word);
  return status;
}

/* Finds the run that `name` names; a folder may also be that of a sweep. */
static sd_status find_drawn(const char *name, sd_messages *messages) {
  if (file_is_folder(name)) return SD_OK;
  place p;
  sd_status status = place_find(&p, name, messages);
  place_free(&p);
  return status;
}

static int draw(const command_line *line, int argc, char **argv) {
  arguments a = {.frame = NO_FRAME};
  int status = options_parse(line, argc, argv, &a);
  if (status == 0) status = examine(line->name, &a);
  sd_messages *messages = sd_messages_new();
  option_range range;
  if (status == 0) status = (int)find_drawn(a.file, messages);
  if (status == 0 && a.frames)
    status = (int)options_range(a.frames, SIZE_MAX, a.file, &range, messages);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  if (status == 0) status = draw_with_python(line->name, &a);
  free(a.kinds.item);
  return status;
}

int app_plot(int argc, char **argv) { return draw(&app_plot_line, argc, argv); }

int app_film(int argc, char **argv) { return draw(&app_film_line, argc, argv); }

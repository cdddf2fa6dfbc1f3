/* bench_steps.c: cost of a step, one thread, in ns; what is timed stands in cases.h.
 *
 *   bench_steps [--quick] [--only NAME] [--repeats N] [--csv FILE] [--compare OTHER]
 *
 * One repeat of every case, then the next of every case, and so on, so that a slow spell of the machine falls
 * on all of them alike. Printed: median, least value and quartiles of the repeats.
 * --compare runs this program and OTHER, the same program of another build, case by case in turn (each as a
 * server that answers the name of a case with the ns per step of one repeat), and prints the ratio of medians.
 */
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "bench/cases.h"
#include "version.h"

enum { MAX_REPEATS = 1000 };

typedef struct options {
  const char *only, *csv, *compare;
  int repeats;
  double seconds; /* of a repeat */
  bool quick, serve, list;
} options;

typedef struct spread {
  double median, least, low, high; /* low, high: quartiles */
} spread;

static int by_value(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return x < y ? -1 : x > y;
}

static double quantile(const double *sorted, int n, double q) {
  double at = q * (n - 1);
  int k = (int)at;
  return k + 1 < n ? sorted[k] + (at - k) * (sorted[k + 1] - sorted[k]) : sorted[k];
}

static spread spread_of(const double *values, int n) {
  double sorted[MAX_REPEATS];
  memcpy(sorted, values, (size_t)n * sizeof *sorted);
  qsort(sorted, (size_t)n, sizeof *sorted, by_value);
  return (spread){quantile(sorted, n, 0.5), sorted[0], quantile(sorted, n, 0.25), quantile(sorted, n, 0.75)};
}

static void *room(size_t n, size_t size) {
  void *p = calloc(n, size);
  if (!p) give_up("out of memory", NULL);
  return p;
}

/* --- what was measured where ------------------------------------------------------------------------- */

static const char *processor(char *text, int size) {
  snprintf(text, (size_t)size, "unknown processor");
  FILE *f = fopen("/proc/cpuinfo", "r");
  char line[256], *colon;
  while (f && fgets(line, sizeof line, f))
    if (strncmp(line, "model name", 10) == 0 && (colon = strchr(line, ':'))) {
      colon[1 + strcspn(colon + 1, "\n")] = '\0';
      snprintf(text, (size_t)size, "%s", colon + 2);
      break;
    }
  if (f) fclose(f);
  return text;
}

static void print_head(FILE *out, const char *mark, const options *o) {
  char text[256];
  fprintf(out, "%sslipdisk %s (%s), %s, %s\n", mark, SD_VERSION, SD_GIT_REVISION, SD_COMPILER, SD_BUILD_TYPE);
  fprintf(out, "%s%s, 1 thread, %d repeats of about %g s of CPU time, in alternation\n", mark,
          processor(text, sizeof text), o->repeats, o->seconds);
}

static void write_csv(const options *o, const bench_case *cases, size_t n, double (*ns)[MAX_REPEATS]) {
  FILE *f = fopen(o->csv, "w");
  if (!f) {
    perror(o->csv);
    exit(EXIT_FAILURE);
  }
  print_head(f, "# ", o);
  fprintf(f, "system,integrator,path,free_disks,contacts,steps,repeats,median_ns,least_ns,quartile1_ns,"
             "quartile3_ns,median_ns_per_disk\n");
  for (size_t k = 0; k < n; k++) {
    const bench_case *c = &cases[k];
    spread s = spread_of(ns[k], o->repeats);
    fprintf(f, "%s,%s,%s,%zu,%zu,%lld,%d,%.3f,%.3f,%.3f,%.3f,%.4f\n", c->system->name, c->integrator, c->path,
            c->free_disks, c->contacts, (long long)c->steps, o->repeats, s.median, s.least, s.low, s.high,
            s.median / (double)c->free_disks);
  }
  if (fclose(f) != 0) {
    perror(o->csv);
    exit(EXIT_FAILURE);
  }
}

/* --- this build alone -------------------------------------------------------------------------------- */

static void measure(const options *o, bench_case *cases, size_t n) {
  double(*ns)[MAX_REPEATS] = room(n, sizeof *ns);
  print_head(stdout, "", o);
  for (size_t k = 0; k < n; k++) prepare(&cases[k], o->seconds);
  for (int r = 0; r < o->repeats; r++)
    for (size_t k = 0; k < n; k++) ns[k][r] = time_once(&cases[k]);
  printf("\n%-24s %5s %8s %10s %10s %21s %12s\n", "case", "disks", "contacts", "ns/step", "least",
         "quartiles", "ns/disk-step");
  for (size_t k = 0; k < n; k++) {
    const bench_case *c = &cases[k];
    spread s = spread_of(ns[k], o->repeats);
    printf("%-24s %5zu %8zu %10.1f %10.1f %10.1f %10.1f %12.1f\n", c->name, c->free_disks, c->contacts,
           s.median, s.least, s.low, s.high, s.median / (double)c->free_disks);
  }
  if (o->csv) write_csv(o, cases, n, ns);
  free(ns);
}

/* --- two builds -------------------------------------------------------------------------------------- */

typedef struct server {
  const char *program;
  pid_t pid;
  FILE *ask, *answer;
} server;

/* Answers each line, the name of a case, with the ns per step of one repeat; "-" when there is no such case. */
static void serve(const options *o, bench_case *cases, size_t n) {
  char line[128];
  while (fgets(line, sizeof line, stdin)) {
    line[strcspn(line, "\n")] = '\0';
    bench_case *c = NULL;
    for (size_t k = 0; k < n; k++)
      if (strcmp(cases[k].name, line) == 0) c = &cases[k];
    if (c) {
      prepare(c, o->seconds);
      printf("%.6f\n", time_once(c));
    } else {
      printf("-\n");
    }
    fflush(stdout);
  }
}

static server start_server(const char *program, const options *o) {
  int to[2], from[2];
  server s = {.program = program};
  /* no server may hold the ends of another's pipes, else it would not see them closed */
  if (pipe2(to, O_CLOEXEC) != 0 || pipe2(from, O_CLOEXEC) != 0 || (s.pid = fork()) < 0)
    give_up("no pipe or process", NULL);
  if (s.pid == 0) {
    dup2(to[0], STDIN_FILENO);
    dup2(from[1], STDOUT_FILENO);
    execl(program, program, "--serve", o->quick ? "--quick" : (char *)NULL, (char *)NULL);
    perror(program);
    _exit(EXIT_FAILURE);
  }
  close(to[0]);
  close(from[1]);
  s.ask = fdopen(to[1], "w");
  s.answer = fdopen(from[0], "r");
  if (!s.ask || !s.answer) give_up("no pipe", NULL);
  return s;
}

static bool ask_server(const server *s, const char *name, double *ns) {
  char line[128];
  fprintf(s->ask, "%s\n", name);
  fflush(s->ask);
  if (!fgets(line, sizeof line, s->answer)) give_up(s->program, NULL);
  return sscanf(line, "%lf", ns) == 1;
}

static void stop_server(server *s) {
  fclose(s->ask);
  fclose(s->answer);
  waitpid(s->pid, NULL, 0);
}

static FILE *open_ratios(const char *path) {
  FILE *f = path ? fopen(path, "w") : NULL;
  if (path && !f) give_up(path, NULL);
  if (f) fprintf(f, "case,this_median_ns,other_median_ns,ratio,ratio_quartile1,ratio_quartile3\n");
  return f;
}

static void print_ratio(FILE *csv, const char *name, int n, const double *mine, const double *theirs) {
  double ratio[MAX_REPEATS];
  for (int r = 0; r < n; r++) ratio[r] = mine[r] / theirs[r];
  spread a = spread_of(mine, n), b = spread_of(theirs, n), q = spread_of(ratio, n);
  printf("%-24s %10.1f %10.1f %10.3f %10.3f %10.3f\n", name, a.median, b.median, a.median / b.median, q.low,
         q.high);
  if (csv)
    fprintf(csv, "%s,%.3f,%.3f,%.4f,%.4f,%.4f\n", name, a.median, b.median, a.median / b.median, q.low,
            q.high);
}

/* The case is asked of both in turn; which goes first changes every time. */
static void compare(const options *o, const char *self, const bench_case *cases, size_t n) {
  double(*mine)[MAX_REPEATS] = room(n, sizeof *mine), (*theirs)[MAX_REPEATS] = room(n, sizeof *theirs);
  bool *both = room(n, sizeof *both);
  signal(SIGPIPE, SIG_IGN);
  server here = start_server(self, o), there = start_server(o->compare, o);
  print_head(stdout, "", o);
  printf("other: %s\n", o->compare);
  for (int r = -1; r < o->repeats; r++) /* the first prepares the cases and does not count */
    for (size_t k = 0; k < n; k++) {
      size_t at = r < 0 ? 0 : (size_t)r;
      if (r % 2 == 0) both[k] = ask_server(&here, cases[k].name, &mine[k][at]);
      both[k] = ask_server(&there, cases[k].name, &theirs[k][at]);
      if (r % 2 != 0) ask_server(&here, cases[k].name, &mine[k][at]);
    }
  FILE *csv = open_ratios(o->csv);
  printf("\n%-24s %10s %10s %10s %21s\n", "case", "this, ns", "other, ns", "ratio", "quartiles of ratios");
  for (size_t k = 0; k < n; k++)
    if (both[k])
      print_ratio(csv, cases[k].name, o->repeats, mine[k], theirs[k]);
    else
      printf("%-24s the other has no such case\n", cases[k].name);
  if (csv) fclose(csv);
  stop_server(&here);
  stop_server(&there);
  free(mine);
  free(theirs);
  free(both);
}

/* --- command line ------------------------------------------------------------------------------------ */

static _Noreturn void usage(int status) {
  fprintf(status ? stderr : stdout,
          "bench_steps: cost of a step in ns, one thread\n"
          "  --quick          short and rough\n"
          "  --only NAME      cases whose name holds NAME, such as random or /gear5/avx512\n"
          "  --repeats N      repeats of each case (15; with --quick 5)\n"
          "  --csv FILE       writes a table\n"
          "  --compare OTHER  runs OTHER, bench_steps of another build, in alternation and prints ratios "
          "this/other\n"
          "  --list           names of the cases\n");
  exit(status);
}

static options read_options(int argc, char **argv) {
  options o = {0};
  for (int k = 1; k < argc; k++) {
    const char *a = argv[k], *value = k + 1 < argc ? argv[k + 1] : NULL;
    if (strcmp(a, "--quick") == 0)
      o.quick = true;
    else if (strcmp(a, "--serve") == 0)
      o.serve = true;
    else if (strcmp(a, "--list") == 0)
      o.list = true;
    else if (strcmp(a, "--help") == 0)
      usage(EXIT_SUCCESS);
    else if (!value)
      usage(EXIT_FAILURE);
    else if (k++, strcmp(a, "--only") == 0)
      o.only = value;
    else if (strcmp(a, "--csv") == 0)
      o.csv = value;
    else if (strcmp(a, "--compare") == 0)
      o.compare = value;
    else if (strcmp(a, "--repeats") != 0 || (o.repeats = atoi(value)) < 1 || o.repeats > MAX_REPEATS)
      usage(EXIT_FAILURE);
  }
  if (o.repeats == 0) o.repeats = o.quick ? 5 : 15;
  o.seconds = o.quick ? 0.02 : 0.05;
  return o;
}

int main(int argc, char **argv) {
  options o = read_options(argc, argv);
  static bench_case cases[MAX_CASES];
  size_t n = list_cases(cases, o.only);
  if (n == 0) give_up("no such case (--list names them)", NULL);
  if (o.serve)
    serve(&o, cases, n);
  else if (o.compare)
    compare(&o, "/proc/self/exe", cases, n);
  else if (!o.list)
    measure(&o, cases, n);
  for (size_t k = 0; k < n; k++) {
    if (o.list) printf("%s\n", cases[k].name);
    free_case(&cases[k]);
  }
  free_settled();
  return EXIT_SUCCESS;
}

/* bench_steps.c: cost of a step of one system, one thread, in ns; what is timed stands in cases.h.
 *
 *   bench_steps [--quick] [--only NAME,...] [--repeats N] [--csv FILE] [--compare OTHER]
 *   bench_steps --scaling [--sizes N,...] [--threads N,...] [--packings NAME,...] [--shuffle] [...]
 *   bench_steps --ratios [--sizes N] [--only NAME,...] [--repeats N] [--csv FILE]
 *   bench_steps --markdown FILE.csv
 *
 * One repeat of every case, then the next of every case, and so on, so that a slow spell of the machine falls
 * on all of them alike. Printed: median, least value and quartiles of the repeats.
 * --compare runs this program and OTHER, the same program of another build, case by case in turn (each as a
 * server that answers the name of a case with the ns per step of one repeat), and prints the ratio of medians.
 * Cases that OTHER, an older build, does not have are left out.
 * --scaling: packings of many sizes instead, ns per disk-step; scaling.h. --ratios: disks of different sizes and walls of
 * many segments, ns per contact; ratios.h.
 */
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "model/model.h"
#include "bench/ratios.h"

typedef struct options {
  const char *only, *csv, *compare, *markdown;
  const char *sizes, *threads, *packings; /* --scaling */
  int repeats;
  double seconds; /* of a repeat */
  bool quick, serve, list, scaling, shuffle, ratios;
} options;

static void print_cases(const bench_case *cases, size_t n, double (*ns)[MAX_REPEATS], int repeats) {
  printf("\nns per step of one system: time / (steps x members)\n");
  printf("%-32s %7s %5s %8s %10s %10s %21s %12s\n", "case", "members", "disks", "contacts",
         "ns/step", "least", "quartiles", "ns/disk-step");
  for (size_t k = 0; k < n; k++) {
    const bench_case *c = &cases[k];
    spread s = spread_of(ns[k], repeats);
    printf("%-32s %7zu %5zu %8zu %10.2f %10.2f %10.2f %10.2f %12.2f\n", c->name, c->members,
           c->free_disks, c->contacts, s.median, s.least, s.low, s.high,
           s.median / (double)c->free_disks);
  }
}

static void measure(const options *o, bench_case *cases, size_t n) {
  double(*ns)[MAX_REPEATS] = room(n, sizeof *ns);
  FILE *csv = o->csv ? open_table(o->csv, "w") : NULL;
  print_head(stdout, "", o->repeats, o->seconds);
  fflush(stdout);
  for (size_t k = 0; k < n; k++) prepare(&cases[k], o->seconds);
  for (int r = 0; r < o->repeats; r++)
    for (size_t k = 0; k < n; k++) ns[k][r] = time_once(&cases[k]);
  print_cases(cases, n, ns, o->repeats);
  if (csv) {
    print_head(csv, "# ", o->repeats, o->seconds);
    write_csv(csv, cases, n, ns, o->repeats);
    close_table(csv, o->csv);
    printf("\ntable: %s\n", o->csv);
  }
  free(ns);
}

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

static void print_ratio(FILE *csv, const char *name, int n, const double *mine,
                        const double *theirs) {
  double ratio[MAX_REPEATS];
  for (int r = 0; r < n; r++) ratio[r] = mine[r] / theirs[r];
  spread a = spread_of(mine, n), b = spread_of(theirs, n), q = spread_of(ratio, n);
  printf("%-32s %10.2f %10.2f %10.3f %10.3f %10.3f\n", name, a.median, b.median,
         a.median / b.median, q.low, q.high);
  if (csv)
    fprintf(csv, "%s,%.3f,%.3f,%.4f,%.4f,%.4f\n", name, a.median, b.median, a.median / b.median,
            q.low, q.high);
}

/* The case is asked of both in turn; which goes first changes every time. False: the other does not have it. */
static bool ask_both(const server *here, const server *there, const char *name, int repeat,
                     double *mine, double *theirs) {
  bool first = repeat % 2 == 0;
  if (first) ask_server(here, name, mine);
  bool has = ask_server(there, name, theirs);
  if (!first && has) ask_server(here, name, mine);
  return has;
}

static void compare(const options *o, const char *self, const bench_case *cases, size_t n) {
  double(*mine)[MAX_REPEATS] = room(n, sizeof *mine),
  (*theirs)[MAX_REPEATS] = room(n, sizeof *theirs);
  bool *both = room(n, sizeof *both);
  FILE *csv = o->csv ? open_table(o->csv, "w") : NULL;
  signal(SIGPIPE, SIG_IGN);
  print_head(stdout, "", o->repeats, o->seconds);
  printf("other: %s\n", o->compare);
  fflush(stdout);
  server here = start_server(self, o), there = start_server(o->compare, o);
  for (size_t k = 0; k < n; k++) /* prepares the cases and does not count */
    both[k] = ask_both(&here, &there, cases[k].name, -1, mine[k], theirs[k]);
  for (int r = 0; r < o->repeats; r++)
    for (size_t k = 0; k < n; k++)
      if (both[k]) ask_both(&here, &there, cases[k].name, r, &mine[k][r], &theirs[k][r]);
  if (csv)
    fprintf(csv, "case,this_median_ns,other_median_ns,ratio,ratio_quartile1,ratio_quartile3\n");
  printf("\n%-32s %10s %10s %10s %21s\n", "case", "this, ns", "other, ns", "ratio",
         "quartiles of ratios");
  for (size_t k = 0; k < n; k++)
    if (both[k])
      print_ratio(csv, cases[k].name, o->repeats, mine[k], theirs[k]);
    else
      printf("%-32s the other has no such case\n", cases[k].name);
  if (csv) close_table(csv, o->csv);
  stop_server(&here);
  stop_server(&there);
  free(mine);
  free(theirs);
  free(both);
}

static _Noreturn void usage(int status) {
  fprintf(
      status ? stderr : stdout,
      "bench_steps: cost of a step of one system in ns, one thread\n"
      "  --quick          short and rough\n"
      "  --only NAME,...  cases whose name holds one of these, such as random/ or "
      "/gear5/avx512,lanes\n"
      "  --repeats N      repeats of each case (15; with --quick 5)\n"
      "  --csv FILE       writes a table\n"
      "  --compare OTHER  runs OTHER, bench_steps of another build, in alternation and prints "
      "ratios this/other\n"
      "  --markdown FILE  prints the table of --csv FILE as Markdown, and measures nothing\n"
      "  --list           names of the cases\n"
      "  --scaling        packings of many sizes, ns per disk-step; with --only, --repeats, "
      "--csv, --quick, and\n"
      "    --sizes N,...      disks (1e2,1e3,1e4,1e5,1e6)\n"
      "    --threads N,...    (1); more than one: the time that passes\n"
      "    --packings NAME,...  (floor): gas, fluid, thrown, shaken, floor, smooth, pressed, or "
      "all\n"
      "    --shuffle          also with disks whose numbers know nothing of their places\n"
      "  --ratios         disks of different sizes, walls of many segments, ns per contact; with "
      "--only, --repeats, --csv,\n"
      "                   --quick, and --sizes N, disks (1e4)\n");
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
    else if (strcmp(a, "--scaling") == 0)
      o.scaling = true;
    else if (strcmp(a, "--shuffle") == 0)
      o.shuffle = true;
    else if (strcmp(a, "--ratios") == 0)
      o.ratios = true;
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
    else if (strcmp(a, "--markdown") == 0)
      o.markdown = value;
    else if (strcmp(a, "--sizes") == 0)
      o.sizes = value;
    else if (strcmp(a, "--threads") == 0)
      o.threads = value;
    else if (strcmp(a, "--packings") == 0)
      o.packings = value;
    else if (strcmp(a, "--repeats") != 0 || (o.repeats = atoi(value)) < 1 ||
             o.repeats > MAX_REPEATS)
      usage(EXIT_FAILURE);
  }
  if (o.ratios &&
      (o.scaling || o.threads || o.packings || o.shuffle || o.serve || o.list || o.compare))
    usage(EXIT_FAILURE);
  if (!o.scaling && ((o.sizes && !o.ratios) || o.threads || o.packings || o.shuffle))
    usage(EXIT_FAILURE);
  if (o.scaling && (o.serve || o.list || o.compare)) usage(EXIT_FAILURE);
  if (o.repeats == 0) o.repeats = o.quick ? 5 : 15;
  o.seconds = o.quick ? 0.02 : 0.04;
  return o;
}

static void scale(const options *o) {
  measure_scaling(&(scaling_options){.sizes = o->sizes ? o->sizes : "1e2,1e3,1e4,1e5,1e6",
                                     .threads = o->threads ? o->threads : "1",
                                     .packings = o->packings ? o->packings : "floor",
                                     .only = o->only,
                                     .csv = o->csv,
                                     .shuffle = o->shuffle,
                                     .quick = o->quick,
                                     .repeats = o->repeats,
                                     .seconds = o->seconds});
}

static void compare_sizes(const options *o) {
  measure_ratios(&(scaling_options){.sizes = o->sizes ? o->sizes : "1e4",
                                    .only = o->only,
                                    .csv = o->csv,
                                    .repeats = o->repeats,
                                    .seconds = o->quick ? 0.1 : 0.4});
}

int main(int argc, char **argv) {
  options o = read_options(argc, argv);
  if (o.markdown && is_scaling_csv(o.markdown))
    print_scaling_markdown(o.markdown);
  else if (o.markdown)
    print_markdown(o.markdown);
  else if (o.scaling)
    scale(&o);
  else if (o.ratios)
    compare_sizes(&o);
  if (o.markdown || o.scaling || o.ratios) return EXIT_SUCCESS;
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

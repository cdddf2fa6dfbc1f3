/* table.h: statistics of repeats, the CSV table of bench_steps.c, and the same as Markdown for docs/performance.md. */
#ifndef BENCH_TABLE_H
#define BENCH_TABLE_H

#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics_double.h>

#include "bench/cases.h"
#include "version.h"

enum { MAX_REPEATS = 1000 };

typedef struct spread {
  double median, least, low, high; /* low, high: quartiles */
} spread;

static spread spread_of(const double *values, int count) {
  double sorted[MAX_REPEATS];
  size_t n = (size_t)count;
  memcpy(sorted, values, n * sizeof *sorted);
  gsl_sort(sorted, 1, n);
  return (spread){gsl_stats_median_from_sorted_data(sorted, 1, n), sorted[0],
                  gsl_stats_quantile_from_sorted_data(sorted, 1, n, 0.25),
                  gsl_stats_quantile_from_sorted_data(sorted, 1, n, 0.75)};
}

static FILE *open_table(const char *path, const char *mode) {
  FILE *f = fopen(path, mode);
  if (!f) {
    perror(path);
    exit(EXIT_FAILURE);
  }
  return f;
}

static void close_table(FILE *f, const char *path) {
  bool failed = ferror(f);
  if (fclose(f) != 0 || failed) {
    perror(path);
    exit(EXIT_FAILURE);
  }
}

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

/* What was measured where; before and how: words around the number of repeats and their length. */
static void print_where(FILE *out, const char *mark, const char *before, int repeats,
                        double seconds, const char *how) {
  char text[256];
  fprintf(out, "%sslipdisk %s (%s), %s, %s\n", mark, SD_VERSION, SD_GIT_REVISION, SD_COMPILER,
          SD_BUILD_TYPE);
  fprintf(out, "%s%s, %s%d repeats of about %g s%s\n", mark, processor(text, sizeof text), before,
          repeats, seconds, how);
}

static void print_head(FILE *out, const char *mark, int repeats, double seconds) {
  print_where(out, mark, "1 thread, ", repeats, seconds, " of CPU time, in alternation");
}

/* members: systems that are advanced together; vectors: 0 for one by itself. ns are per step of one system. */
#define TABLE_COLUMNS                                                                              \
  "case,system,integrator,path,members,vectors,free_disks,contacts,steps,repeats,median_ns,least_" \
  "ns,"                                                                                            \
  "quartile1_ns,quartile3_ns,median_ns_per_disk\n"

static void write_csv(FILE *f, const bench_case *cases, size_t n, double (*ns)[MAX_REPEATS],
                      int repeats) {
  fprintf(f, TABLE_COLUMNS);
  for (size_t k = 0; k < n; k++) {
    const bench_case *c = &cases[k];
    spread s = spread_of(ns[k], repeats);
    fprintf(f, "%s,%s,%s,%s,%zu,%zu,%zu,%zu,%lld,%d,%.3f,%.3f,%.3f,%.3f,%.4f\n", c->name,
            c->system->name, c->integrator, c->path, c->members, c->vectors, c->free_disks,
            c->contacts, (long long)c->steps, repeats, s.median, s.least, s.low, s.high,
            s.median / (double)c->free_disks);
  }
}

typedef struct table_row {
  char name[64], system[32], integrator[16], path[16];
  size_t members, vectors, free_disks;
  spread ns;
} table_row;

/* Rows of a CSV file; prints its comments. */
static size_t read_csv(const char *path, table_row *rows) {
  FILE *f = open_table(path, "r");
  char line[512];
  size_t n = 0;
  bool titled = false;
  while (fgets(line, sizeof line, f)) {
    table_row r = {0};
    if (line[0] == '#') {
      line[strcspn(line, "\n")] = '\0';
      printf("%s  \n", line + strspn(line, "# "));
    } else if (!titled) {
      titled = strcmp(line, TABLE_COLUMNS) == 0;
      if (!titled) give_up("not a table of bench_steps --csv", NULL);
    } else if (sscanf(line,
                      "%63[^,],%31[^,],%15[^,],%15[^,],%zu,%zu,%zu,%*u,%*u,%*u,%lf,%lf,%lf,%lf",
                      r.name, r.system, r.integrator, r.path, &r.members, &r.vectors, &r.free_disks,
                      &r.ns.median, &r.ns.least, &r.ns.low, &r.ns.high) != 11 ||
               n == MAX_CASES) {
      give_up("not a row of bench_steps --csv", NULL);
    } else {
      rows[n++] = r;
    }
  }
  close_table(f, path);
  if (n == 0) give_up("an empty table", NULL);
  return n;
}

static const char *const path_titles[PATHS] = {"AVX-512", "AVX2", "baseline"}; /* of paths[] */

static const table_row *find_row(const table_row *rows, size_t n, const table_row *like, size_t p,
                                 size_t vectors) {
  for (size_t k = 0; k < n; k++)
    if (strcmp(rows[k].system, like->system) == 0 &&
        strcmp(rows[k].integrator, like->integrator) == 0 && strcmp(rows[k].path, paths[p]) == 0 &&
        rows[k].vectors == vectors)
      return &rows[k];
  return NULL;
}

static void print_cell(const table_row *r, double share) {
  if (r)
    printf(" %.*f |", r->ns.median * share < 99.95 ? 1 : 0, r->ns.median * share);
  else
    printf(" - |");
}

static void print_title(bool lanes, const table_row *rows, size_t n) {
  printf("\n| system | integrator |");
  for (size_t p = 0; p < PATHS; p++) printf(" %s |", path_titles[p]);
  for (size_t p = 0; lanes && p < PATHS; p++) {
    size_t members = 0;
    for (size_t k = 0; k < n; k++)
      if (rows[k].vectors == 1 && strcmp(rows[k].path, paths[p]) == 0) members = rows[k].members;
    if (members)
      printf(" %s, %zu lanes |", path_titles[p], members);
    else
      printf(" %s, lanes |", path_titles[p]);
  }
  if (!lanes) printf(" per disk-step, %s |", path_titles[0]);
  printf("\n|---|---|---|---|---|%s\n", lanes ? "---|---|---|" : "---|");
}

/* One line per system and integrator: small systems with their lanes, or packings with the cost per free disk. */
static void print_lines(bool lanes, const table_row *rows, size_t n) {
  bool titled = false;
  for (size_t k = 0; k < n; k++) {
    const table_row *r = &rows[k];
    bool known = false;
    for (size_t j = 0; j < k; j++)
      known = known || (strcmp(rows[j].system, r->system) == 0 &&
                        strcmp(rows[j].integrator, r->integrator) == 0);
    if (known || lanes != (r->free_disks == 1)) continue;
    if (!titled) print_title(lanes, rows, n);
    titled = true;
    printf("| `%s` | %s |", r->system, r->integrator);
    for (size_t p = 0; p < PATHS; p++) print_cell(find_row(rows, n, r, p, 0), 1.0);
    for (size_t p = 0; lanes && p < PATHS; p++) print_cell(find_row(rows, n, r, p, 1), 1.0);
    if (!lanes) print_cell(find_row(rows, n, r, 0, 0), 1.0 / (double)r->free_disks);
    printf("\n");
  }
}

/* Tables and their spread, from a CSV file. */
static void print_markdown(const char *path) {
  static table_row rows[MAX_CASES];
  double wide[MAX_CASES] = {0}, most = 0.0;
  size_t n = read_csv(path, rows);
  const char *widest = rows[0].name;
  print_lines(true, rows, n);
  print_lines(false, rows, n);
  for (size_t k = 0; k < n; k++) {
    const spread *s = &rows[k].ns;
    wide[k] = (s->high - s->low) / s->median;
    if (wide[k] <= most) continue;
    most = wide[k];
    widest = rows[k].name;
  }
  gsl_sort(wide, 1, n);
  printf("\nMedians, ns per step of one system. The quartiles are %.1f %% of the median apart "
         "(median of all "
         "cases), "
         "%.1f %% at most\n(`%s`).\n",
         100.0 * gsl_stats_median_from_sorted_data(wide, 1, n), 100.0 * most, widest);
}

#endif

/* scaling_table.h: the table of bench_steps --scaling: on the screen, as CSV, and as Markdown for
 * docs/performance.md. */
#ifndef BENCH_SCALING_TABLE_H
#define BENCH_SCALING_TABLE_H

#include "bench/table.h"

enum { MAX_SCALING = 1024 };

/* One line. Times are ns per disk and step; of lists, per disk and list. */
typedef struct scaling_row {
  char name[96], packing[24], numbers[16], integrator[16], path[16];
  size_t disks;
  int threads, repeats;
  double candidates, contacts; /* per disk */
  int64_t steps;               /* of a repeat */
  spread ns;                   /* without making lists */
  double build_ns;
  int64_t all_steps, builds; /* of the whole run: lists made anew */
} scaling_row;

/* Lists per step; none seen: as if the next step were the first to make one. */
static double lists_per_step(const scaling_row *r) {
  return (double)(r->builds ? r->builds : 1) / (double)r->all_steps;
}
static double total_ns(const scaling_row *r) {
  return r->ns.median + lists_per_step(r) * r->build_ns;
}
static double share_of(const scaling_row *r) {
  return lists_per_step(r) * r->build_ns / total_ns(r);
}
static const char *below(const scaling_row *r) { return r->builds ? "" : "<"; }

static void print_scaling_head(FILE *out, const char *mark, int repeats, double seconds) {
  print_where(out, mark, "", repeats, seconds, ", in alternation; 1 thread: CPU time");
}

#define SCALING_COLUMNS                                                                            \
  "case,packing,disks,numbers,integrator,threads,path,candidates_per_disk,contacts_per_disk,"      \
  "steps,repeats,"                                                                                 \
  "median_ns,least_ns,quartile1_ns,quartile3_ns,build_ns,all_steps,builds,total_ns\n"

static void print_scaling_title(FILE *csv) {
  printf("\nns per disk-step without making lists; lists: ns per disk of one, their number in 1000 "
         "steps, and\n"
         "their share of the time\n");
  printf("%-36s %8s %10s %9s %9s %19s %8s %9s %8s\n", "case", "contacts", "candidates", "ns",
         "least", "quartiles", "list", "per 1000", "share");
  fflush(stdout);
  if (csv) fprintf(csv, SCALING_COLUMNS);
}

static void print_scaling_row(const scaling_row *r) {
  printf("%-36s %8.3f %10.3f %9.2f %9.2f %9.2f %9.2f %8.1f %1s%7.3f %1s%4.1f %%\n", r->name,
         r->contacts, r->candidates, r->ns.median, r->ns.least, r->ns.low, r->ns.high, r->build_ns,
         below(r), 1e3 * lists_per_step(r), below(r), 100.0 * share_of(r));
}

static void write_scaling_row(FILE *f, const scaling_row *r) {
  fprintf(f, "%s,%s,%zu,%s,%s,%d,%s,%.4f,%.4f,%lld,%d,%.4f,%.4f,%.4f,%.4f,%.3f,%lld,%lld,%.4f\n",
          r->name, r->packing, r->disks, r->numbers, r->integrator, r->threads, r->path,
          r->candidates, r->contacts, (long long)r->steps, r->repeats, r->ns.median, r->ns.least,
          r->ns.low, r->ns.high, r->build_ns, (long long)r->all_steps, (long long)r->builds,
          total_ns(r));
}

/* Is it a table of --scaling? */
static bool is_scaling_csv(const char *path) {
  FILE *f = open_table(path, "r");
  char line[512];
  bool is = false;
  while (fgets(line, sizeof line, f) && line[0] == '#') continue;
  is = strcmp(line, SCALING_COLUMNS) == 0;
  close_table(f, path);
  return is;
}

static size_t read_scaling_csv(const char *path, scaling_row *rows) {
  FILE *f = open_table(path, "r");
  char line[512];
  size_t n = 0;
  while (fgets(line, sizeof line, f)) {
    scaling_row r = {0};
    long long steps, all_steps, builds;
    if (line[0] == '#') {
      line[strcspn(line, "\n")] = '\0';
      printf("%s  \n", line + strspn(line, "# "));
      continue;
    }
    if (strcmp(line, SCALING_COLUMNS) == 0) continue;
    if (n == MAX_SCALING ||
        sscanf(line,
               "%95[^,],%23[^,],%zu,%15[^,],%15[^,],%d,%15[^,],%lf,%lf,%lld,%d,%lf,%lf,%lf,%lf,%lf,"
               "%lld,%lld",
               r.name, r.packing, &r.disks, r.numbers, r.integrator, &r.threads, r.path,
               &r.candidates, &r.contacts, &steps, &r.repeats, &r.ns.median, &r.ns.least, &r.ns.low,
               &r.ns.high, &r.build_ns, &all_steps, &builds) != 18)
      give_up("not a row of bench_steps --scaling --csv", NULL);
    r.steps = steps;
    r.all_steps = all_steps;
    r.builds = builds;
    rows[n++] = r;
  }
  close_table(f, path);
  if (n == 0) give_up("an empty table", NULL);
  return n;
}

static bool same_line(const scaling_row *a, const scaling_row *b) {
  return strcmp(a->packing, b->packing) == 0 && a->disks == b->disks &&
         strcmp(a->numbers, b->numbers) == 0;
}

static bool same_column(const scaling_row *a, const scaling_row *b) {
  return strcmp(a->integrator, b->integrator) == 0 && a->threads == b->threads &&
         strcmp(a->path, b->path) == 0;
}

/* The first row of each kind, in the order of the table. */
static size_t list_firsts(const scaling_row *rows, size_t n,
                          bool (*same)(const scaling_row *, const scaling_row *),
                          const scaling_row **first) {
  size_t found = 0;
  for (size_t k = 0; k < n; k++) {
    bool known = false;
    for (size_t j = 0; j < found; j++) known = known || same(first[j], &rows[k]);
    if (!known) first[found++] = &rows[k];
  }
  return found;
}

/* All, the median and quartiles of what is not lists, and lists. */
static void print_scaling_cell(const scaling_row *r) {
  if (r)
    printf(" %.1f = %.1f (%.1f-%.1f) + %s%.1f |", total_ns(r), r->ns.median, r->ns.low, r->ns.high,
           below(r), lists_per_step(r) * r->build_ns);
  else
    printf(" - |");
}

/* A line for each packing, size and order of numbers, a column for each integrator and number of threads. */
static void print_scaling_markdown(const char *path) {
  static scaling_row rows[MAX_SCALING];
  static const scaling_row *line[MAX_SCALING], *column[MAX_SCALING];
  size_t n = read_scaling_csv(path, rows), lines = list_firsts(rows, n, same_line, line),
         columns = list_firsts(rows, n, same_column, column);
  printf("\n| packing | disks | numbers | contacts | candidates |");
  for (size_t c = 0; c < columns; c++)
    printf(" %s, %s, %d thread%s |", column[c]->integrator, column[c]->path, column[c]->threads,
           column[c]->threads == 1 ? "" : "s");
  printf("\n|---|---:|---|---:|---:|");
  for (size_t c = 0; c < columns; c++) printf("---|");
  for (size_t l = 0; l < lines; l++) {
    printf("\n| `%s` | %zu | %s | %.2f | %.2f |", line[l]->packing, line[l]->disks,
           line[l]->numbers, line[l]->contacts, line[l]->candidates);
    for (size_t c = 0; c < columns; c++) {
      const scaling_row *cell = NULL;
      for (size_t k = 0; k < n; k++)
        if (same_line(&rows[k], line[l]) && same_column(&rows[k], column[c])) cell = &rows[k];
      print_scaling_cell(cell);
    }
  }
  printf("\n\nns per disk-step: all = median (quartiles) without making lists + lists. Contacts "
         "and candidates "
         "per disk.\n");
}

#endif

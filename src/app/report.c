/* report.c: prints the results of a run as text; see app.h. */
#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "app/app.h"

const char *report_duration(double seconds, char *text, size_t size) {
  if (!(seconds >= 0) || seconds > 1e9) {
    snprintf(text, size, "?");
    return text;
  }
  int64_t s = (int64_t)(seconds + 0.5);
  if (s < 24 * 3600)
    snprintf(text, size, "%" PRId64 ":%02d:%02d", s / 3600, (int)(s / 60 % 60), (int)(s % 60));
  else
    snprintf(text, size, "%" PRId64 "d %02d:%02d:%02d", s / 86400, (int)(s / 3600 % 24),
             (int)(s / 60 % 60), (int)(s % 60));
  return text;
}

void report_lines(FILE *out, const char *before, const char *text) {
  for (size_t n; *text; text += n + (text[n] == '\n')) {
    n = strcspn(text, "\n");
    fprintf(out, "%s%.*s\n", before, (int)n, text);
  }
}

bool report_redraws(FILE *out) {
  const char *kind = getenv("TERM");
  return isatty(fileno(out)) && kind && *kind && strcmp(kind, "dumb") != 0;
}

void report_status_line(FILE *out, const char *text) {
  struct winsize window;
  int width =
      ioctl(fileno(out), TIOCGWINSZ, &window) == 0 && window.ws_col > 0 ? window.ws_col - 1 : 100;
  fprintf(out, "\r\033[K%.*s", width, text);
  fflush(out);
}

/* Formats a value with its error, as "-0.0123 +- 0.0004"; "-" if the value is not finite, "+- ?" if
 * the error is not. */
static const char *with_error(double value, double error, char *text, size_t size) {
  if (!isfinite(value))
    snprintf(text, size, "-");
  else if (!isfinite(error))
    snprintf(text, size, "%.6g +- ?", value);
  else
    snprintf(text, size, "%.6g +- %.2g", value, error);
  return text;
}

/* Largest number of rows that the table of watched disks prints; the file has all of them. */
enum { MOST_ROWS = 24 };

static void report_rotations(FILE *out, const summary *found) {
  if (found->n_rotations == 0) return;
  fprintf(out, "\nmean rotation         %-26s %-26s %10s %10s\n", "Omega", "t_g Omega", "transient",
          "measured");
  size_t n = found->n_rotations < MOST_ROWS ? found->n_rotations : MOST_ROWS;
  bool doubtful = false;
  for (size_t k = 0; k < n; k++) {
    const sd_rotation *r = &found->rotations[k];
    char omega[64], scaled[64];
    fprintf(out, "  %-19.19s %-26s %-26s %10.4g %10.4g%s\n", found->rotation_names[k],
            with_error(r->omega, r->error, omega, sizeof omega),
            with_error(r->scaled, r->scaled_error, scaled, sizeof scaled), r->transient,
            r->measured, r->converged ? "" : " *");
    doubtful = doubtful || !r->converged;
  }
  if (n < found->n_rotations)
    fprintf(out, "  ... and %zu more, in /summary/rotation\n", found->n_rotations - n);
  if (doubtful) fprintf(out, "  * too short a record: the error is not reliable\n");
}

/* Formats a value and its error with the digits that the error allows, as "0.2900 +- 0.0046"; as
 * with_error without an error. */
static const char *rounded(double value, double error, char *text, size_t size) {
  const double digits = 1 - floor(log10(error));
  if (isfinite(value) && error > 0 && digits >= 0 && digits < 7)
    snprintf(text, size, "%.*f +- %.*f", (int)digits, value, (int)digits, error);
  else
    with_error(value, error, text, size);
  return text;
}

/* Returns why an average has no error bar, or none to be trusted; "": it has. */
static const char *lack_of(const sd_average *a) {
  return a->rows == 0          ? "no measured rows yet"
         : !isfinite(a->mean)  ? "no mean: IN DOUBT tells why"
         : !isfinite(a->error) ? "too few rows for an error bar"
         : !a->converged       ? "too short a record: the error is not reliable"
                               : "";
}

static void report_averages(FILE *out, const summary *found) {
  if (found->n_averages == 0) return;
  fprintf(out, "\naverage of the series  %-26s %-12s %10s %10s %10s\n", "mean", "unit",
          "correlation", "transient", "measured");
  for (size_t k = 0; k < found->n_averages; k++) {
    const sd_average *a = &found->averages[k];
    char *const *names = found->average_names + 3 * k, value[64];
    fprintf(out, "  %-19.19s  %-26s %-12s %11.4g %10.4g %10.4g\n", names[0],
            rounded(a->mean, a->error, value, sizeof value), names[2], a->correlation, a->transient,
            a->measured);
    fprintf(out, "    = %s%s%s\n", names[1], *lack_of(a) ? "; " : "", lack_of(a));
  }
}

/* Formats the value of a criterion at the end of a phase; "-" if the phase had no goal for it. */
static const char *if_asked(double value, double goal, char *text, size_t size) {
  if (goal > 0)
    snprintf(text, size, "%.4g", value);
  else
    snprintf(text, size, "-");
  return text;
}

/* Prints the table of phases, if some phase had a goal to be met (rest, or a stress). */
static void report_phases(FILE *out, const summary *found) {
  bool any = false;
  for (size_t k = 0; k < found->n_stages; k++) {
    const summary_phase *p = &found->stages[k];
    char kinetic[40], unbalanced[40], target[40];
    if (!p->asked || p->steps == 0) continue;
    if (!any)
      fprintf(out, "\nphase                  %12s %12s %12s %12s %12s\n", "steps", "at most",
              "kinetic", "unbalanced", "target");
    any = true;
    fprintf(out, "  %-20.20s %12" PRId64 " %12" PRId64 " %12s %12s %12s%s\n", found->stage_names[k],
            p->steps, p->most, if_asked(p->kinetic, p->kinetic_goal, kinetic, sizeof kinetic),
            if_asked(p->unbalanced, p->unbalanced_goal, unbalanced, sizeof unbalanced),
            if_asked(p->target, p->target_goal, target, sizeof target),
            p->reached ? "" : "  NOT reached");
  }
}

static void report_lost(FILE *out, const summary *found) {
  if (found->waiting > 0) fprintf(out, "\n%" PRId64 " disks wait to be released\n", found->waiting);
  if (found->left == 0) return;
  fprintf(out, "\n%" PRId64 " disk%s left the bounds", found->outside,
          found->outside == 1 ? "" : "s");
  if (found->outside > 0)
    fprintf(out, ": %s%s", found->lost, found->outside > SUMMARY_LOST ? ", ..." : "");
  if (found->left > found->outside)
    fprintf(out, " (%" PRId64 " times one left, some came back)", found->left);
  fputc('\n', out);
}

static void report_until(FILE *out, const summary *found) {
  if (!found->has_until) return;
  const sd_goal *g = &found->goal;
  fprintf(out, "\nuntil the error of %s is ", found->observable);
  if (isfinite(found->relative))
    fprintf(out, "%.4g of it, %.3g: ", found->relative, g->goal);
  else
    fprintf(out, "%.3g: ", g->goal);
  if (found->until_step >= 0) {
    fprintf(out, "reached at step %" PRId64 " with %.3g\n", found->until_step, g->error);
    return;
  }
  fprintf(out, "%s", found->phase == found->phases ? "NOT reached" : "not yet reached");
  if (isfinite(g->error))
    fprintf(out, ", it is %.3g%s", g->error, g->converged ? "" : " and not reliable");
  fputc('\n', out);
}

/* Prints means and standard deviations of torque and forces in each sliding configuration of
 * watched disk w (combination of the sliding directions at its two contacts). */
static void report_configurations(FILE *out, const summary *found, size_t w) {
  static const char *const names[] = {"S++", "S+-", "S-+", "S--", "stick", "open"};
  if (found->n_configurations < SD_CONFIGURATIONS * (w + 1)) return;
  fprintf(out, "    %-6s %11s %10s %11s %10s %11s %10s %10s %10s %10s\n", "in", "torque", "sd",
          "1st force", "sd", "2nd force", "sd", "visits", "duration", "sd");
  for (size_t c = 0; c < SD_CONFIGURATIONS; c++) {
    const sd_configuration *q = &found->configurations[SD_CONFIGURATIONS * w + c];
    if (q->steps == 0) continue;
    fprintf(out, "    %-6s %11.5g %10.3g %11.5g %10.3g %11.5g %10.3g %10" PRId64, names[c],
            q->torque, q->torque_sd, q->force[0], q->force_sd[0], q->force[1], q->force_sd[1],
            q->visits);
    if (q->visits)
      fprintf(out, " %10.4g %10.3g\n", q->dwell, q->dwell_sd);
    else
      fprintf(out, " %10s %10s\n", "-", "-");
  }
}

static void report_slides(FILE *out, const summary *found) {
  if (found->n_slides == 0) return;
  fprintf(out, "\nsliding configurations  %7s %7s %7s %7s %7s %7s\n", "S++", "S+-", "S-+", "S--",
          "stick", "open");
  size_t n = found->n_slides < MOST_ROWS ? found->n_slides : MOST_ROWS;
  for (size_t k = 0; k < n; k++) {
    const sd_slide *s = &found->slides[k];
    fprintf(out, "  %-21.21s %7.4f %7.4f %7.4f %7.4f %7.4f %7.4f\n", found->slide_names[3 * k],
            s->pp, s->pm, s->mp, s->mm, s->stick, s->open);
    for (size_t c = 0; c < 2; c++)
      fprintf(out, "    with %-16.16s smallest normal force %.6g, opened %" PRId64 " times\n",
              found->slide_names[3 * k + 1 + c], s->force_min[c], s->openings[c]);
    report_configurations(out, found, k);
  }
  if (n < found->n_slides)
    fprintf(out, "  ... and %zu more, in /summary/slide\n", found->n_slides - n);
}

/* Prints the free disks with the largest |mean angular velocity|; the result file has the means of
 * all disks. */
static void report_fastest(FILE *out, const summary_disks *p) {
  size_t n = p->n_fastest;
  if (n == 0) return;
  fprintf(out, "  fastest disks        %-26s %9s %9s %9s %9s\n", "Omega", "1st half", "2nd half",
          "contacts", "sliding");
  for (size_t k = 0; k < n; k++) {
    const sd_disk_mean *d = &p->fastest[k];
    char omega[64];
    fprintf(out, "    disk %-14" PRIu32 "  %-26s %9.3g %9.3g %9.3g %9.3g%s\n", d->disk,
            with_error(d->omega, d->error, omega, sizeof omega), d->first, d->second,
            d->coordination, d->sliding, d->converged ? "" : " *");
  }
}

/* Prints means over all disks. A quantity that has an error bar is printed with it on one line. */
static void report_disks(FILE *out, const summary *found) {
  const summary_disks *p = &found->packing;
  if (p->n == 0) return;
  if (p->later) {
    fprintf(out,
            "\nmeans of %zu free disks over time %.6g: the result will have them, and info --json "
            "computes "
            "them now\n",
            p->n, p->measured);
    return;
  }
  fprintf(out,
          "\nmeans of %.0f of %zu free disks over time %.6g, %" PRId64 " looks at the contacts\n",
          isnan(p->totals.disks) ? 0.0 : p->totals.disks, p->n, p->measured, p->looks);
  if (!(p->totals.disks > 0)) return;
  /* Skip observable 0, the number of disks, which is printed above */
  for (size_t k = 1; k < total_observables.n; k++) {
    const observable *o = &total_observables.rows[k],
                     *next = k + 1 < total_observables.n ? o + 1 : o;
    size_t length = strlen(o->name);
    bool paired =
        strncmp(next->name, o->name, length) == 0 && strcmp(next->name + length, "_error") == 0;
    double x = observable_value(o, &p->totals, 0);
    char value[64];
    if (paired || !isfinite(x))
      with_error(x, observable_value(next, &p->totals, 0), value, sizeof value);
    else
      snprintf(value, sizeof value, "%.6g", x);
    fprintf(out, "  %-20s %-26s %-9s %s\n", o->name, value, o->unit, o->meaning);
    k += paired;
  }
  report_fastest(out, p);
  if (p->bins < SUMMARY_FEWEST_BINS)
    fprintf(out, "  too short a record: there are no error bars\n");
  else if (p->totals.reliable < 1)
    fprintf(out, "  * too short a record for %.0f of the disks: the error is not reliable\n",
            p->totals.disks * (1 - p->totals.reliable));
}

static void report_energy(FILE *out, const sd_energy *e) {
  fprintf(out, "\nenergy budget\n");
  for (const observable *o = energy_observables.rows;
       o < energy_observables.rows + energy_observables.n; o++) {
    if (o->offset == offsetof(sd_energy, scale)) continue;
    fprintf(out, "  %-20s %16.9g", o->name, observable_value(o, e, 0));
    if (o->offset == offsetof(sd_energy, residual) && e->scale > 0)
      fprintf(out, "   (relative: %.2g)", e->residual / e->scale);
    fputc('\n', out);
  }
}

static void report_doubts(FILE *out, const summary *found) {
  if (summary_doubts(found) == 0) return;
  fprintf(out, "\nIN DOUBT\n");
  for (size_t k = 0; k < DOUBT_KINDS; k++)
    if (found->doubts[k].text) fprintf(out, "  %s\n", found->doubts[k].text);
}

void report_summary(FILE *out, const summary *found) {
  report_rotations(out, found);
  report_averages(out, found);
  report_phases(out, found);
  report_lost(out, found);
  report_until(out, found);
  report_slides(out, found);
  report_disks(out, found);
  report_energy(out, &found->energy);
  report_doubts(out, found);
}

const char *report_of(const summary *found) {
  bool early = found->has_until;
  for (size_t k = 0; k < found->n_stages; k++)
    early = early || found->stages[k].asked & SUMMARY_SETTLE;
  return early ? "of at most" : "of";
}

void report_cost(FILE *out, const summary *found, const provenance *origin) {
  char wall[40], cost[40] = "", ranks[40] = "";
  if (isfinite(found->step_nanoseconds)) /* The cost per step is NAN before the first step */
    snprintf(cost, sizeof cost, "%.4g ns per step, ", found->step_nanoseconds);
  if (origin->ranks > 1) snprintf(ranks, sizeof ranks, "%" PRId64 " ranks of ", origin->ranks);
  fprintf(out,
          "\n%" PRId64 " %s %" PRId64 " steps, time %.9g, wall time %s, %s%s%" PRId64
          " thread%s (%s)\n",
          found->step, report_of(found), found->steps, (double)found->step * found->dt,
          report_duration(origin->wall_seconds, wall, sizeof wall), cost, ranks, origin->threads,
          origin->threads == 1 ? "" : "s", origin->cpu_path);
}

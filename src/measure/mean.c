/* mean.c: means with error bars, of records and of what a state has gathered. */
#include <gsl/gsl_statistics_double.h>
#include <math.h>

#include "measure/blocking.h"
#include "slipdisk/measure.h"

sd_mean sd_mean_of(const double *x, size_t n, bool look) {
  sd_mean mean = {.mean = NAN, .error = NAN, .correlation = NAN};
  if (n == 0) return mean;
  transient start = look ? transient_of(x, n) : (transient){.inside = true};
  mean.discarded = start.length;
  mean.used = n - start.length;
  mean.mean = gsl_stats_mean(x + start.length, 1, mean.used);

  blocking error = blocking_error(x + start.length, mean.used);
  mean.error = error.error;
  mean.correlation = error.correlation;
  /* a relaxation without noise has no plateau, and needs none once little of it is left */
  mean.converged = start.inside && isfinite(error.error) && (error.plateau || start.quiet);
  return mean;
}

sd_rotation sd_rotation_of(const sd_model *model, const sd_state *state, size_t k) {
  uint32_t disk = model->rotations[k];
  double gravity = hypot(model->gravity[0], model->gravity[1]);
  double bin = (double)state->bin_steps * model->dt, scale = 1 / bin;
  double t_g = gravity > 0 ? sqrt(2 * model->disks[disk].radius / gravity) : NAN;
  size_t bins = state->bins > 0 ? (size_t)state->bins : 0;

  sd_mean mean = sd_mean_of(state->rotation_bin + k * SD_BINS, bins, true);
  return (sd_rotation){
      .disk = disk,
      .omega = mean.mean * scale,
      .error = mean.error * scale,
      .scaled = mean.mean * scale * t_g,
      .scaled_error = mean.error * scale * t_g,
      .transient = (double)mean.discarded * bin,
      .measured = (double)state->measured * model->dt,
      .turned = state->rotation_last[k] - state->rotation_start[k],
      .converged = mean.converged,
  };
}

sd_slide sd_slide_of(const sd_model *model, const sd_state *state, size_t k) {
  const sd_slide_watch *watch = &model->slides[k];
  const int64_t *count = state->slide_count + 16 * k;
  double total = (double)state->measured;
  sd_slide slide = {.disk = watch->disk};

  for (int first = 0; first < 4; first++)
    for (int second = 0; second < 4; second++) {
      /* before anything was measured every fraction is 0/0 */
      double part = (double)count[4 * first + second] / total;
      int own[2] = {first, second};
      for (int c = 0; c < 2; c++) {
        slide.contact_positive[c] += own[c] == SD_SLIDE_POSITIVE ? part : 0 * part;
        slide.contact_negative[c] += own[c] == SD_SLIDE_NEGATIVE ? part : 0 * part;
        slide.contact_stuck[c] += own[c] == SD_STUCK ? part : 0 * part;
        slide.contact_open[c] += own[c] == SD_OPEN ? part : 0 * part;
      }
      bool open = first == SD_OPEN || second == SD_OPEN;
      bool stick = !open && (first == SD_STUCK || second == SD_STUCK);
      slide.open += open ? part : 0 * part;
      slide.stick += stick ? part : 0 * part;
    }
  slide.pp = (double)count[4 * SD_SLIDE_POSITIVE + SD_SLIDE_POSITIVE] / total;
  slide.pm = (double)count[4 * SD_SLIDE_POSITIVE + SD_SLIDE_NEGATIVE] / total;
  slide.mp = (double)count[4 * SD_SLIDE_NEGATIVE + SD_SLIDE_POSITIVE] / total;
  slide.mm = (double)count[4 * SD_SLIDE_NEGATIVE + SD_SLIDE_NEGATIVE] / total;

  for (int c = 0; c < 2; c++) {
    slide.partner[c] = watch->partner[c];
    slide.force_min[c] = state->slide_force_min[2 * k + (size_t)c];
    slide.openings[c] = state->slide_openings[2 * k + (size_t)c];
  }
  return slide;
}

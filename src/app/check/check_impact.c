/* check_impact.c: restitution of a linear contact law at the time step of a model. */
#include <math.h>

#include "app/check/check.h"
#include "model/model.h"
#include "slipdisk/simulation.h"

enum {
  PHASES = 16,      /* Number of impacts, which touch at different fractions of a step */
  MOST_STEPS = 5000 /* Most steps of a run; with more, e is that of the law within 1e-3 */
};

/* Makes an impact of a disk of radius 1 on a fixed one, `gap` apart, at this speed, and returns the
 * speed after `steps` steps over that before; NAN if the simulation fails. */
static double impact(const sd_model *m, const sd_contact_law *law, double mass, double speed,
                     double gap, int64_t steps) {
  sd_model *two = sd_model_new();
  sd_simulation *sim = NULL;
  sd_column vy;
  double after = NAN;
  sd_model_set(two, "dt", m->dt);
  sd_model_set(two, "limits.unstable_step", 1);
  sd_model_set_text(two, "integrator", m->integrator == SD_GEAR5 ? "gear5" : "verlet");
  const int material = sd_model_add_material(two, "m", law);
  sd_model_add_disk(two, &(sd_disk){.material = material, .radius = 1, .mass = 1, .driven = true});
  sd_model_add_disk(two, &(sd_disk){.material = material,
                                    .position = {0, 2 + gap, 0},
                                    .velocity = {0, -speed, 0},
                                    .radius = 1,
                                    .mass = mass});
  if (sd_model_finish(two, NULL) == SD_OK && sd_simulation_new(two, 1, &sim, NULL) == SD_OK &&
      sd_simulation_advance(sim, steps, NULL) == SD_OK && sd_simulation_column(sim, "vy", &vy))
    after = ((const double *)vy.data)[sd_simulation_slot(sim, 1)] / speed;
  sd_simulation_free(sim);
  sd_model_free(two);
  return after;
}

void check_restitution_at_dt(const sd_model *m, const sd_contact_law *law, double mass,
                             double range[2]) {
  const double unit = sqrt(mass / law->k_n), steps = ceil(2 * M_PI * unit / m->dt) + 4;
  const sd_contact_law head_on = {.k_n = law->k_n,
                                  .gamma_n = law->gamma_n,
                                  .restitution = law->restitution,
                                  .damping_pulls = law->damping_pulls};
  /* The law is linear, so the speed does not matter; at this one the overlap is at most 1e-3 */
  const double speed = 1e-3 / unit;
  range[0] = range[1] = NAN;
  for (int k = 0; k < PHASES && steps <= MOST_STEPS; k++) {
    const double gap = (k + 0.5) / PHASES * speed * m->dt,
                 after = impact(m, &head_on, mass, speed, gap, (int64_t)steps),
                 e = isnan(after) ? NAN : fmax(after, 0);
    range[0] = k ? fmin(range[0], e) : e;
    range[1] = k ? fmax(range[1], e) : e;
  }
}

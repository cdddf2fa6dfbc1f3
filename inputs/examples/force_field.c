/* force_field.c: a force of one's own. Disks in a whirling fluid: a drag towards the local velocity of a vortex, with gravity
 * towards its middle, until they lie packed around it and turn with it. Work of the field closes the energy budget.
 *
 *   cc force_field.c $(pkg-config --cflags --libs slipdisk) -lm -o force_field && ./force_field
 */
#include <math.h>
#include <stdio.h>

#include <slipdisk/slipdisk.h>

typedef struct vortex {
  double spin, drag, weight; /* rad/time; mass/time per mass; acceleration */
} vortex;

/* Called once a step with all predicted coordinates; adds to forces and torques. */
static void whirl(const sd_force_columns *c, void *user) {
  const vortex *v = user;
  for (size_t i = 0; i < c->n_free; i++) {
    const double r = hypot(c->x[i], c->y[i]), pull = r > 0 ? v->weight / r : 0;
    c->force_x[i] += c->mass[i] * (v->drag * (-v->spin * c->y[i] - c->vx[i]) - pull * c->x[i]);
    c->force_y[i] += c->mass[i] * (v->drag * (v->spin * c->x[i] - c->vy[i]) - pull * c->y[i]);
    c->torque[i] += c->inertia[i] * v->drag * (v->spin - c->omega[i]);
  }
}

int main(void) {
  vortex v = {.spin = 0.2, .drag = 0.5, .weight = 1};
  sd_messages *messages = sd_messages_new();
  sd_model *m = sd_model_new();
  sd_simulation *sim = NULL;
  if (!messages || !m) return SD_ERROR_IO;
  sd_model_set(m, "dt", 2e-3);
  sd_model_set_text(m, "integrator", "verlet");
  sd_model_add_material(m, "grain", &(sd_contact_law){.k_n = 2e3, .k_t = 1e3, .gamma_n = 5, .mu = 0.3});
  for (int k = 0; k < 100; k++)
    sd_model_add_disk(m, &(sd_disk){.position = {1.5 * (k % 10) - 7, 1.5 * (k / 10) - 7},
                                    .radius = 0.4 + 0.002 * k,
                                    .mass = 1});
  sd_status status = sd_model_finish(m, messages);
  if (status == SD_OK) status = sd_simulation_new(m, 0, &sim, messages);
  if (status == SD_OK) status = sd_simulation_add_force_field(sim, whirl, &v, messages);
  for (int k = 1; status == SD_OK && k <= 5; k++) {
    status = sd_simulation_advance(sim, 10000, messages);
    const sd_energy e = sd_simulation_energy(sim);
    sd_column omega;
    if (status != SD_OK || !sd_simulation_column(sim, "omega", &omega)) break;
    double mean = 0;
    for (int i = 0; i < 100; i++) mean += ((const double *)omega.data)[i] / 100;
    printf("time %5.1f  mean spin %.3f  work of the field %9.3f  residual of the budget %8.1e\n",
           sd_simulation_time(sim), mean, e.work, e.residual / e.scale);
  }
  sd_messages_print(messages, stderr);
  sd_simulation_free(sim);
  sd_model_free(m);
  sd_messages_free(messages);
  return status;
}

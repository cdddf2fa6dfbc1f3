/* drag.c: disks sink in water. Stokes' drag as a force of one's own; drag.py is the same in Python. */
#include <stdio.h>

#include <slipdisk/slipdisk.h>

static void water(const sd_force_columns *c, void *user) {
  const double viscous = *(const double *)user; /* force on a disk over its speed */
  for (size_t i = 0; i < c->n_free; i++) {
    c->force_x[i] -= viscous * c->vx[i];
    c->force_y[i] -= viscous * c->vy[i];
  }
}

int main(void) {
  double viscous = 0.05;
  sd_messages *messages = sd_messages_new();
  sd_model *model = NULL;
  sd_simulation *sim = NULL;
  sd_status status = sd_deck_load("sink.cfg", 0, NULL, &model, messages);
  if (status == SD_OK) status = sd_simulation_new(model, 0, &sim, messages);
  if (status == SD_OK) status = sd_simulation_add_force_field(sim, water, &viscous, messages);
  if (status == SD_OK) status = sd_simulation_advance(sim, sd_model_steps(model), messages);
  if (status == SD_OK) {
    const sd_energy e = sd_simulation_energy(sim);
    printf("work of the water %.6f, residual %.1e of what was turned over\n", e.work, e.residual / e.scale);
  }
  sd_messages_print(messages, stderr);
  sd_simulation_free(sim);
  sd_model_free(model);
  sd_messages_free(messages);
  return status;
}

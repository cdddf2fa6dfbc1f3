/* packing.c: a packing from arrays, saved and gone on with. Disks of two sizes fall into a box; when they are at rest a heavy
 * one is dropped onto them, twice from the same start, at two speeds: a clone is the second try.
 *
 *   cc packing.c $(pkg-config --cflags --libs slipdisk) -lm -o packing && ./packing
 */
#include <stdio.h>
#include <stdlib.h>

#include <slipdisk/slipdisk.h>

enum { N = 400, WIDE = 20 };

static sd_model *box(void) {
  sd_model *m = sd_model_new();
  sd_disk *disks = calloc(N, sizeof *disks);
  if (!m || !disks) exit(SD_ERROR_IO);
  sd_model_set(m, "dt", 1e-3);
  sd_model_set_text(m, "integrator", "verlet");
  sd_model_set_gravity(m, 0, -1);
  sd_model_add_material(m, "grain", &(sd_contact_law){.k_n = 5e3, .k_t = 4e3, .gamma_n = 20, .mu = 0.5});
  double points[4][2] = {{0, 60}, {0, 0}, {WIDE + 2, 0}, {WIDE + 2, 60}};
  sd_model_add_wall(m, &(sd_wall){.name = "box", .kind = SD_WALL_POLYLINE, .n_points = 4, .points = points});
  for (int k = 0; k < N; k++)
    disks[k] = (sd_disk){.position = {1 + k % WIDE + 0.07 * (k / WIDE % 5), 0.6 + 1.05 * (k / WIDE)},
                         .radius = k % 3 ? 0.5 : 0.35,
                         .mass = k % 3 ? 1 : 0.5};
  sd_model_add_disks(m, N, disks);
  sd_model_add_phase(m, &(sd_phase){.name = "fall",
                                    .steps = 200000,
                                    .settle = {.asked = true, .kinetic = 1e-6, .unbalanced = 1e-2}});
  sd_model_add_phase(m, &(sd_phase){.name = "impact"}); /* without an end */
  free(disks);
  return m;
}

int main(void) {
  sd_messages *messages = sd_messages_new();
  sd_model *m = box();
  sd_simulation *sim[2] = {NULL, NULL};
  sd_status status = sd_model_finish(m, messages);
  if (status == SD_OK) status = sd_simulation_new(m, 0, &sim[0], messages);
  while (status == SD_OK && sd_simulation_stage(sim[0]).phase == 0)
    status = sd_simulation_advance(sim[0], 1000, messages);
  if (status == SD_OK) printf("at rest after %.0f\n", sd_simulation_time(sim[0]));
  if (status == SD_OK) status = sd_simulation_save(sim[0], "packing.h5", messages); /* for sd_simulation_load */
  if (status == SD_OK) status = sd_simulation_clone(sim[0], &sim[1], messages);
  for (int k = 0; k < 2 && status == SD_OK; k++) {
    uint32_t heavy;
    status = sd_simulation_add_disks(
        sim[k], 1,
        &(sd_disk){.position = {WIDE / 2 + 1, 30}, .velocity = {0, k ? -10 : -3}, .radius = 2, .mass = 40},
        &heavy, messages);
    if (status == SD_OK) status = sd_simulation_advance(sim[k], 20000, messages);
    sd_column y;
    if (status == SD_OK && sd_simulation_column(sim[k], "y", &y))
      printf("from a speed of %2d: it lies at a height of %.2f\n", k ? 10 : 3,
             ((const double *)y.data)[sd_simulation_slot(sim[k], heavy)]);
  }
  sd_messages_print(messages, stderr);
  for (int k = 0; k < 2; k++) sd_simulation_free(sim[k]);
  sd_model_free(m);
  sd_messages_free(messages);
  return status;
}

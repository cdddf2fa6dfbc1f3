/* drum.c: a deck is run, and an observer looks at it: the slope of the surface in a rotating drum, ten times while it flows.
 *
 *   cc drum.c $(pkg-config --cflags --libs slipdisk) -lm -o drum && ./drum DECK     (inputs/packing/drum.cfg)
 */
#include <math.h>
#include <stdio.h>

#include <slipdisk/slipdisk.h>

static const double PI = 3.14159265358979323846;

/* Where the grains' centre of mass lies, seen from the drum's axis: its angle from the vertical is that of the slope. */
static sd_status slope(sd_simulation *sim, void *user) {
  const sd_model *model = sd_simulation_model(sim);
  const sd_stage stage = sd_simulation_stage(sim);
  const uint32_t drum = sd_simulation_slot(sim, *(uint32_t *)user);
  sd_column x, y, mass;
  if (stage.phase < 1) return SD_OK; /* still being filled */
  if (!sd_simulation_column(sim, "x", &x) || !sd_simulation_column(sim, "y", &y) ||
      !sd_simulation_column(sim, "mass", &mass))
    return SD_ERROR_IO;
  const double *px = x.data, *py = y.data, *m = mass.data;
  double sum = 0, mx = 0, my = 0;
  for (size_t i = 0; i < sd_model_disks(model); i++) {
    sum += m[i];
    mx += m[i] * (px[i] - px[drum]);
    my += m[i] * (py[i] - py[drum]);
  }
  printf("time %6.1f  slope %5.1f deg\n", sd_simulation_time(sim), atan2(mx / sum, -my / sum) * 180 / PI);
  return stage.phase == 2 ? SD_INTERRUPTED : SD_OK;
}

int main(int argc, char **argv) {
  const char *deck = argc > 1 ? argv[1] : "inputs/packing/drum.cfg";
  const char *set[] = {"phases[1].time=100", "motions.turn.velocity=-0.03"}; /* as after -D */
  sd_messages *messages = sd_messages_new();
  sd_model *model = NULL;
  sd_simulation *sim = NULL;
  sd_status status = sd_deck_load(deck, 2, set, &model, messages);
  if (status == SD_OK) status = sd_simulation_new(model, 0, &sim, messages);
  if (status == SD_OK) {
    uint32_t drum = sd_model_find(model, "drum");
    status = sd_simulation_observe(sim, 10000, slope, &drum);
    if (status == SD_OK) status = sd_simulation_advance(sim, sd_model_steps(model), messages);
    if (status == SD_INTERRUPTED) status = SD_OK; /* the observer has seen enough */
  }
  sd_messages_print(messages, stderr);
  sd_simulation_free(sim);
  sd_model_free(model);
  sd_messages_free(messages);
  return status;
}

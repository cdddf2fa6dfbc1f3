/* ratchet.c: the paper's ratchet in one page. A disk rests on two others that turn to and fro in phase; tilted, it turns
 * steadily. Prints its mean angular velocity for tilts of both signs and none.
 *
 *   cc ratchet.c $(pkg-config --cflags --libs slipdisk) -o ratchet && ./ratchet
 */
#include <math.h>
#include <stdio.h>

#include <slipdisk/slipdisk.h>

static const double PI = 3.14159265358979323846;

/* R = m g = 1; angles of the supports: pi/6 on both sides of the vertical. */
static sd_model *ratchet(double tilt) {
  sd_model *m = sd_model_new();
  if (!m) return NULL;
  sd_model_set(m, "dt", 1e-6);
  sd_model_set_gravity(m, -10 * sin(tilt), -10 * cos(tilt));
  sd_model_add_material(m, "disk", &(sd_contact_law){.k_n = 1e3, .k_t = 1e6, .gamma_n = 10, .mu = 0.1});
  uint32_t upper = sd_model_add_disk(m, &(sd_disk){.name = "upper", .radius = 1, .mass = 0.1});
  uint32_t support[2];
  for (int k = 0; k < 2; k++)
    support[k] = sd_model_add_disk(
        m, &(sd_disk){.position = {k ? 1 : -1, -sqrt(3)}, .radius = 1, .mass = 0.1, .driven = true});
  sd_model_add_motion(m, &(sd_motion){.name = "turn",
                                      .kind = SD_MOTION_PARABOLIC,
                                      .coordinate = SD_THETA,
                                      .n_bodies = 2,
                                      .bodies = support,
                                      .amplitude = 0.04,
                                      .omega = 20 * PI});
  bool off = false;
  sd_model_add_phase(m, &(sd_phase){.name = "rest", .steps = 500000, .active = &off});
  sd_model_add_phase(m, &(sd_phase){.name = "measure", .steps = 5000000, .measure = true});
  sd_model_measure_rotation(m, 1, &upper);
  return m;
}

int main(void) {
  sd_messages *messages = sd_messages_new();
  for (int k = -1; k <= 1; k++) {
    const double tilt = 0.04 * PI * k;
    sd_simulation *sim = NULL;
    sd_model *m = ratchet(tilt);
    sd_status status = m ? sd_model_finish(m, messages) : SD_ERROR_IO;
    if (status == SD_OK) status = sd_simulation_new(m, 1, &sim, messages);
    if (status == SD_OK) status = sd_simulation_advance(sim, sd_model_steps(m), messages);
    if (status == SD_OK) {
      const sd_rotation turn = sd_rotation_of(m, sd_simulation_state(sim), 0);
      printf("tilt %7.4f  Omega %8.5f +- %.5f\n", tilt, turn.omega, turn.error);
    }
    sd_simulation_free(sim);
    sd_model_free(m);
    if (status == SD_OK) continue;
    sd_messages_print(messages, stderr); /* every mistake, with what was expected */
    return status;
  }
  sd_messages_free(messages);
  return 0;
}

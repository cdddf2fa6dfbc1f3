/* measure.c: measures a simulation at its present step, or frames of a result; see
 * slipdisk/measurement.h. */
#include <stdlib.h>

#include "base/memory.h"
#include "base/message.h"
#include "measure/measurement.h"
#include "run/simulation_private.h"
#include "run/stored.h"
#include "slipdisk/measurement.h"

/* Arguments of sd_simulation_measure, and its result. */
typedef struct measuring {
  sd_simulation *sim;
  const double *wanted;
  size_t bins;
  sd_measurement **out;
  sd_messages *messages;
  sd_status status;
} measuring;

static sd_status measure(sd_simulation *sim, const double *wanted, size_t bins,
                         sd_measurement **out, sd_messages *messages) {
  const sd_state *state = simulation_state(sim);
  if (!state) return sd_fail(messages, SD_ERROR_IO, "no memory for the state");
  const sd_model *model = sim->engine.model;
  frame_data frame = {0};
  sd_status status = frame_data_of_state(&frame, model, state, messages);
  if (status == SD_OK) status = measurement_tabulate(model, &frame, wanted, bins, out, messages);
  frame_data_free(&frame);
  return status;
}

static void measure_now(void *task) {
  measuring *t = task;
  t->status = measure(t->sim, t->wanted, t->bins, t->out, t->messages);
  if (t->status == SD_ERROR_IO && sd_messages_errors(t->messages) == 0) fail_memory(t->messages);
}

sd_status sd_simulation_measure(sd_simulation *sim, const double *wanted, size_t bins,
                                sd_measurement **out, sd_messages *messages) {
  bool outer;
  *out = NULL;
  if (!simulation_enter(sim, NEED_STATE, "sd_simulation_measure", &outer, messages))
    return SD_ERROR_USER;
  measuring t = {sim, wanted, bins, out, messages, SD_OK};
  if (!memory_try(measure_now, &t)) {
    *out = NULL;
    t.status = fail_memory(messages);
  }
  simulation_leave(sim, outer);
  return t.status;
}

struct sd_result {
  frames frames;
  bool alone; /* true: a part file, which has no last state */
};

sd_status sd_result_open(const char *path, sd_result **out, sd_messages *messages) {
  sd_result *r = *out = memory_new(1, sizeof *r);
  const sd_status status = stored_open(&r->frames, path, &r->alone, messages);
  if (status == SD_OK) return SD_OK;
  sd_result_close(r);
  *out = NULL;
  return status;
}

void sd_result_close(sd_result *r) {
  if (!r) return;
  frames_close(&r->frames);
  free(r);
}

size_t sd_result_frames(const sd_result *r) { return r->frames.n; }

sd_status sd_result_measure(const sd_result *r, int64_t frame, const double *wanted, size_t bins,
                            sd_measurement **out, sd_messages *messages) {
  const frames *f = &r->frames;
  *out = NULL;
  if (f->n == 0 && (frame >= 0 || r->alone))
    return sd_fail(messages, SD_ERROR_USER, "%s: no frames are stored in it", f->path);
  if (frame < -1 || frame >= (int64_t)f->n)
    return sd_fail(messages, SD_ERROR_USER,
                   "%s: frame %lld: there are 0 to %zu; -1 is the last state", f->path,
                   (long long)frame, f->n - 1);
  frame_data data;
  sd_status status = frames_read(f, frame >= 0 ? (size_t)frame : f->n - r->alone, &data, messages);
  if (status == SD_OK)
    status = measurement_tabulate(f->constants, &data, wanted, bins, out, messages);
  frame_data_free(&data);
  return status;
}

/* until.c: is an error bar small enough, and when is it looked at; see slipdisk/measure.h.
 *
 * An error bar is itself a random number, and a run that ends when it is small ends, on the average, when it is
 * too small. Every look adds to that, so there are few: one for each 5 % of length (docs/physics.md 9).
 */
#include <math.h>

#include "slipdisk/measure.h"

#include "model/state.h"

enum { LOOKS = 20 }; /* while the record becomes twice as long there are 14 */

sd_goal sd_goal_of(const sd_model *model, const sd_state *state) {
  const sd_until *u = &model->until;
  sd_rotation r = sd_rotation_of(model, state, u->rotation);
  sd_goal g = {.value = u->scaled ? r.scaled : r.omega,
               .error = u->scaled ? r.scaled_error : r.error,
               .measured = r.measured,
               .converged = r.converged};
  g.goal = u->relative > 0.0 ? u->relative * fabs(g.value) : u->error;
  g.reached = g.converged && g.error <= g.goal; /* false for NAN */
  return g;
}

int64_t sd_goal_look(const sd_model *model, int64_t step) {
  int64_t look = model->until.least, end = model->phases[model->n_phases - 1].steps;
  while (look <= step && look < end) {
    int64_t further = look / LOOKS + 1;
    look = further < end - look ? look + further : end;
  }
  return look;
}

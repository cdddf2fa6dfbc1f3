/* stresses.h: the stress of a state, for tests. */
#ifndef TESTS_STRESSES_H
#define TESTS_STRESSES_H

#include "deck_runs.h"
#include "measure/stress.h"

/* As the series and `measure` have it. */
HELPER void stress_of(sd_simulation *sim, double contact[4], double kinetic[4]) {
  const sd_model *m = sd_simulation_model(sim);
  frame_data f;
  configuration c;
  assert_int_equal(frame_data_of_state(&f, m, sd_simulation_state(sim), NULL), SD_OK);
  assert_int_equal(configuration_new(&c, m, &f, NULL), SD_OK);
  const region g = configuration_region(&c, NULL);
  stress s;
  assert_int_equal(stress_new(&s, &c, &g, NULL), SD_OK);
  memcpy(contact, s.contact, sizeof s.contact);
  memcpy(kinetic, s.kinetic, sizeof s.kinetic);
  stress_free(&s);
  configuration_free(&c);
  frame_data_free(&f);
}

#endif

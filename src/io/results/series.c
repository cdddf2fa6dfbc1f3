/* series.c: see series.h. */
#include "io/results/series.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "io/store/file.h"
#include "pack/compress.h"
#include "physics/step/outside.h"

#define ENERGY(name, meaning)                                                                                \
  { #name, offsetof(sd_energy, name), meaning }

const series_energy series_energies[] = {
    ENERGY(kinetic_translation, "kinetic energy of the free coordinates, translation"),
    ENERGY(kinetic_rotation, "kinetic energy of the free coordinates, rotation"),
    ENERGY(elastic_normal, "elastic energy of the normal springs"),
    ENERGY(elastic_skin, "elastic energy of the skins"),
    ENERGY(external, "potential energy of gravity and constant body forces"),
    ENERGY(start, "sum of the energies above at step 0, and what disks brought or took along since"),
    ENERGY(work, "work done by prescribed bodies and coordinates, and by compression, since step 0"),
    ENERGY(variant, "energy put in by the paper's tangential force since step 0"),
    ENERGY(viscous, "energy lost to viscosity since step 0"),
    ENERGY(friction, "energy lost to sliding since step 0"),
    ENERGY(opening, "energy left in contacts that opened since step 0"),
    ENERGY(relaxed, "energy taken out by the relaxer since step 0"),
    ENERGY(residual, "what the energy budget does not account for"),
    ENERGY(scale, "larger of |work| + losses and kinetic energy, to compare the residual with"),
};
const size_t series_energy_count = sizeof series_energies / sizeof *series_energies;

double series_energy_value(const sd_energy *energy, size_t k) {
  double value;
  memcpy(&value, (const char *)energy + series_energies[k].offset, sizeof value);
  return value;
}

/* Only of a region that changes: it needs an area. */
static bool compresses(const sd_model *m) {
  for (size_t k = 0; k < m->n_phases; k++)
    if (m->phases[k].compress.asked) return true;
  return false;
}

sd_status series_new(table *t, const sd_model *model, sd_messages *messages) {
  char *clock = format_text("/observables/%s", series_energies[0].name);
  char *step = format_text("%s/step", clock), *time = format_text("%s/time", clock);
  sd_status status =
      clock && step && time ? SD_OK : sd_fail(messages, SD_ERROR_IO, "no memory for the results");
  if (status == SD_OK) status = table_add(t, step, SD_I64, 0, NULL, "1", "steps since the start", messages);
  if (status == SD_OK) status = table_add(t, time, SD_F64, 0, NULL, "time", "step * dt", messages);
  free(clock);
  free(step);
  free(time);
  for (size_t k = 0; status == SD_OK && k < series_energy_count; k++) {
    char *path = format_text("/observables/%s/value", series_energies[k].name);
    status = path ? table_add(t, path, SD_F64, 0, NULL, "energy", series_energies[k].meaning, messages)
                  : sd_fail(messages, SD_ERROR_IO, "no memory for the results");
    free(path);
  }
  if (status == SD_OK)
    status = table_add(t, "/observables/contacts/value", SD_I64, 0, NULL, "1", "closed contacts", messages);
  if (status == SD_OK)
    status = table_add(t, "/observables/sliding_contacts/value", SD_I64, 0, NULL, "1",
                       "closed contacts that slide", messages);
  if (status == SD_OK && compresses(model))
    status = table_add(t, "/observables/pressure/value", SD_F64, 0, NULL, "force/length",
                       "pressure of the contacts in the region", messages);
  if (status == SD_OK && compresses(model))
    status = table_add(t, "/observables/packing_fraction/value", SD_F64, 0, NULL, "1",
                       "area of the free disks in play over that of the region", messages);
  if (status == SD_OK && model->bounds.given)
    status = table_add(t, "/observables/outside/value", SD_I64, 0, NULL, "1",
                       "disks beyond the bounds or taken out", messages);
  size_t watched = model->n_rotations;
  if (status == SD_OK && watched > 0)
    status = table_add(t, "/observables/angle/value", SD_F64, 1, &watched, "rad",
                       "angle of each watched disk, not wrapped", messages);
  if (status == SD_OK && watched > 0)
    status = table_add(t, "/observables/angular_velocity/value", SD_F64, 1, &watched, "rad/time",
                       "angular velocity of each watched disk, counter-clockwise positive", messages);
  return status;
}

static void put_f64(table *t, size_t *column, double value) {
  memcpy(table_cell(t, (*column)++), &value, sizeof value);
}

static void put_i64(table *t, size_t *column, int64_t value) {
  memcpy(table_cell(t, (*column)++), &value, sizeof value);
}

sd_status series_sample(table *t, const sd_model *model, const sd_state *state, const sd_energy *energy,
                        const uint32_t *slots, sd_messages *messages) {
  sd_status status = table_reserve(t, 1, messages);
  if (status != SD_OK) return status;
  size_t column = 0;
  put_i64(t, &column, state->step);
  put_f64(t, &column, (double)state->step * model->dt);
  for (size_t k = 0; k < series_energy_count; k++) put_f64(t, &column, series_energy_value(energy, k));

  int64_t sliding = 0;
  for (size_t k = 0; k < state->n_contacts; k++) sliding += state->contact_slide[k] != 0;
  put_i64(t, &column, (int64_t)state->n_contacts);
  put_i64(t, &column, sliding);
  if (compresses(model)) {
    put_f64(t, &column, compress_stored_pressure(model, state));
    put_f64(t, &column, compress_fraction(model, state));
  }

  if (model->bounds.given) put_i64(t, &column, outside_count(state));
  if (model->n_rotations > 0) {
    double *angle = table_cell(t, column), *velocity = table_cell(t, column + 1);
    for (size_t k = 0; k < model->n_rotations; k++) {
      uint32_t slot = slots[model->rotations[k]];
      angle[k] = state->turn[slot] + state->theta[slot];
      velocity[k] = state->omega[slot];
    }
  }
  table_commit(t, 1);
  return SD_OK;
}

/* series.h: the time series: energies, number of contacts, and the angles of the watched disks. */
#ifndef SLIPDISK_IO_SERIES_H
#define SLIPDISK_IO_SERIES_H

#include "io/store/table.h"
#include "slipdisk/simulation.h"

sd_status series_new(table *t, const sd_model *model, sd_messages *messages);
/* One row. slots[body] is the body's slot in the state. */
sd_status series_sample(table *t, const sd_model *model, const sd_state *state, const sd_energy *energy,
                        const uint32_t *slots, sd_messages *messages);

/* Name, meaning and place of each energy, in the order in which they are stored; also used by the summary. */
typedef struct series_energy {
  const char *name;
  size_t offset; /* in sd_energy */
  const char *meaning;
} series_energy;
extern const series_energy series_energies[];
extern const size_t series_energy_count;
double series_energy_value(const sd_energy *energy, size_t k);

#endif

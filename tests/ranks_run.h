/* ranks_run.h: a run over ranks that are threads of this process, and its state at the end as one
 * process has it.
 */
#ifndef TESTS_RANKS_RUN_H
#define TESTS_RANKS_RUN_H

#include "base/comm.h"
#include "deck_runs.h"
#include "physics/neighbours/neighbours.h"
#include "physics/system/halo.h"
#include "run/ranks.h"

typedef struct run {
  const char *deck;
  int64_t steps; /* at a time */
  int threads;   /* of a rank */
  sd_state *end; /* as rank 0 has it */
  sd_model *model;
  sd_energy energy;
  sd_status status;
  sd_messages *messages;
} run;

/* Rows of a column, or of those behind the free disks, from one state to another. */
HELPER void put(const sd_field *f, size_t row, const sd_state *from, size_t at, sd_state *to,
                size_t place, size_t n) {
  const size_t size = row * sd_type_size(f->type);
  if (n > 0)
    memcpy((char *)sd_field_data(to, f) + place * size, (char *)sd_field_data(from, f) + at * size,
           n * size);
}

/* One rank's disks and contacts; of the rest what rank 0 has. */
HELPER void put_part(const engine *e, sd_state *whole) {
  const sd_state *s = e->state;
  const size_t known = s->n_free + s->n_ghosts, contacts = whole->n_contacts;
  assert_int_equal(sd_state_reserve_contacts(whole, contacts + s->n_contacts), SD_OK);
  whole->n_contacts += s->n_contacts;
  if (comm_rank(e->comm) == 0) {
    assert_int_equal(state_reserve_breaks(whole, s->n_breaks), SD_OK);
    whole->n_breaks = s->n_breaks;
  }
  for (size_t k = 0; k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    const bool of_free = state_of_free(f->extent), of_contacts = state_of_contacts(f->extent);
    const size_t row = f->extent == SD_PER_MEAN_BIN ? SD_MEAN_BINS : 1;
    if (sd_extent_size(whole, f->extent) == 0) continue;
    for (size_t i = 0; (of_free || f->extent == SD_PER_BODY) && i < s->n_free; i++)
      put(f, row, s, i, whole, e->halo ? e->halo->order[i] : i, 1);
    if (of_contacts) put(f, 1, s, 0, whole, contacts, s->n_contacts);
    if (comm_rank(e->comm) > 0 || of_free || of_contacts) continue;
    const bool bodies = f->extent == SD_PER_BODY;
    put(f, 1, s, bodies ? known : 0, whole, bodies ? whole->n_free : 0,
        bodies ? s->n_bodies - known : sd_extent_size(s, f->extent));
  }
}

/* On every rank; the first has the messages and the whole state. */
HELPER void rank(const comm *c, void *with) {
  run *r = with;
  const bool first = comm_rank(c) == 0;
  sd_model *mine = NULL;
  sd_simulation *sim = NULL;
  sd_messages *messages = first ? r->messages : sd_messages_new();
  sd_status status = c ? ranks_load(c, r->deck, "deck", 0, NULL, &mine, NULL) : SD_OK;
  if (status == SD_OK)
    status = simulation_new(mine ? mine : r->model, r->threads, SIMULATION_GENERAL, c, NULL, &sim,
                            messages);
  while (status == SD_OK && !sd_simulation_finished(sim))
    status = sd_simulation_advance(sim, r->steps, messages);
  const sd_energy energy = sim ? sd_simulation_energy(sim) : (sd_energy){0};
  const sd_status there = sim ? simulation_store(sim, false, messages) : SD_ERROR_IO;
  if (first) {
    r->status = status;
    r->energy = energy;
    r->end = there == SD_OK ? sd_state_new(r->model) : NULL;
  }
  for (int q = 0; q < comm_size(c); q++) {
    if (q == comm_rank(c) && there == SD_OK) put_part(simulation_engine(sim), r->end);
    comm_or(c, 0); /* one after the other */
  }
  if (first) {
    if (r->end) assert_int_equal(order_contacts(r->model, r->end), SD_OK);
  } else {
    sd_messages_free(messages);
  }
  sd_simulation_free(sim);
  sd_model_free(mine);
}

HELPER void go(run *r, int size) {
  r->model = model_of(r->deck);
  r->messages = sd_messages_new();
  comm_threads_run(size, rank, r);
}

HELPER void end(run *r) {
  sd_state_free(r->end);
  sd_model_free(r->model);
  sd_messages_free(r->messages);
}

#endif

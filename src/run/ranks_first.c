/* ranks_first.c: see ranks_first.h. */
#include "run/ranks_first.h"

#include <assert.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/memory.h"
#include "io/deck/deck.h"
#include "model/tiles.h"
#include "pack/tiles.h"
#include "physics/neighbours/order.h"
#include "physics/step/engine.h"
#include "run/ranks_contacts.h"
#include "run/ranks_order.h"
#include "run/route.h"

/* --- disks --------------------------------------------------------------------------------------------------- */

/* A part, and which disks of the model they are. */
typedef struct made_part {
  size_t n;
  sd_disk *disks;
  uint32_t *number;
  int64_t inputs; /* of a file: of all parts so far */
} made_part;

static size_t count_part(const sd_tiles *t, size_t part) {
  return model_tile_begin(t, part + 1) - model_tile_begin(t, part);
}

/* Room for the largest. False: no memory. */
static bool begin_part(const sd_model *m, made_part *p) {
  const size_t most = count_part(&m->tiles, 0);
  return memory_rows(
      2, (memory_column[]){{&p->disks, most, sizeof *p->disks}, {&p->number, most, sizeof *p->number}});
}

static void end_part(made_part *p) {
  free(p->disks);
  free(p->number);
}

static sd_status make_part(const sd_model *m, size_t part, made_part *p, sd_messages *messages) {
  const sd_tiles *t = &m->tiles;
  const size_t first = model_tile_begin(t, part);
  size_t placed = p->n = count_part(t, part);
  int64_t inputs = 0;
  const sd_status status = t->of_file ? deck_make_part(m, part, p->disks, p->number, &inputs, messages)
                                      : tiles_make(m, part, p->disks, &placed);
  p->inputs = (int64_t)((uint64_t)p->inputs + (uint64_t)inputs);
  if (status != SD_OK)
    return t->of_file ? status : sd_fail(messages, status, "no memory for the disks of a tile");
  if (placed < p->n)
    return sd_fail(messages, SD_ERROR_USER, "packings[%zu].count: " TILES_FULL, t->entry, part, t->n, placed,
                   p->n);
  for (size_t k = 0; k < p->n; k++)
    p->number[k] = (uint32_t)(t->first + (t->of_file ? p->number[k] : first + k));
  return SD_OK;
}

static bool is_mine(const comm *c, size_t part) {
  return part % (size_t)comm_size(c) == (size_t)comm_rank(c);
}

/* Rank 0 has the disks of the deck that are not made in parts. */
static size_t count_mine(const comm *c, const sd_model *m) {
  const size_t held = model_held(m);
  size_t n = 0;
  for (size_t i = 0; comm_rank(c) == 0 && i < held; i++) n += !m->disks[i].driven;
  for (size_t k = 0; m->tiles.away && k < m->tiles.n; k++)
    if (is_mine(c, k)) n += count_part(&m->tiles, k);
  return n;
}

/* Free disks; inputs: of what this rank has read. */
static sd_status fill_parts(const comm *c, const sd_model *m, sd_state *s, size_t slot, int64_t *inputs,
                            sd_messages *messages) {
  made_part p = {0};
  if (!begin_part(m, &p)) comm_fail(c, "no memory for its tiles");
  sd_status status = SD_OK;
  for (size_t k = 0; k < m->tiles.n && status == SD_OK; k++) {
    if (!is_mine(c, k)) continue;
    status = make_part(m, k, &p, messages);
    for (size_t i = 0; i < p.n && status == SD_OK; i++)
      engine_fill_disk(s, &p.disks[i], p.number[i], (uint32_t)slot++);
  }
  *inputs = p.inputs;
  end_part(&p);
  assert(status != SD_OK || slot == s->n_free);
  return status;
}

static sd_status fill_tiles(const comm *c, const sd_model *m, sd_state *s, size_t slot,
                            sd_messages *messages) {
  int64_t inputs[1];
  const sd_status status = fill_parts(c, m, s, slot, inputs, messages);
  if (!comm_all_well(c, status)) return status;
  comm_add(c, inputs, 1);
  if (m->tiles.of_file && inputs[0] != m->tiles.inputs)
    return sd_fail(messages, SD_ERROR_IO, "disk_files[%zu].file has changed while it was read",
                   m->tiles.entry);
  return SD_OK;
}

/* Few disks stand in the order of the deck, on rank 0. */
static sd_status find_order(const comm *c, const sd_model *m, sd_state *s, uint32_t *order) {
  if (m->n_free >= ORDER_LEAST) return ranks_order(c, m, s, order);
  for (size_t i = 0; i < s->n_free; i++) order[i] = (uint32_t)i;
  return SD_OK;
}

static sd_status give_up(const comm *c, const char *why) {
  comm_fail(c, why);
  return SD_ERROR_IO;
}

sd_status ranks_first_new(const comm *c, const sd_model *m, sd_state **state, uint32_t **order,
                          sd_messages *messages) {
  const bool leads = comm_rank(c) == 0;
  sd_state *s = *state = state_new_part(m, count_mine(c, m), 0);
  *order = route_room(c, s ? s->n_free : 0, sizeof **order);
  if (!s) return give_up(c, "no memory for its disks");
  const size_t n = leads ? engine_fill_free(m, s) : 0;
  engine_fill_prescribed(m, s);
  sd_status status = m->tiles.away ? fill_tiles(c, m, s, n, messages) : SD_OK;
  /* together, or not at all: the others would wait */
  if (!comm_all_well(c, status)) return status;
  status = find_order(c, m, s, *order);
  if (leads && status == SD_OK && engine_fill_memories(m, s) != SD_OK)
    return give_up(c, "no memory for the contacts");
  if (!comm_all_well(c, status)) return status;
  return m->tiles.away && m->tiles.n_contacts > 0 ? ranks_contacts_read(c, m, s, messages) : SD_OK;
}

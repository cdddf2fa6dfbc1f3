/* ranks_tiles.c: see ranks_tiles.h. */
#include "run/ranks_tiles.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/comm_data.h"
#include "model/tiles.h"
#include "pack/tiles.h"
#include "physics/step/engine.h"
#include "run/ranks_move.h"
#include "run/ranks_order.h"

/* --- disks --------------------------------------------------------------------------------------------------- */

/* Rank 0 has the first tile, from the deck. */
static bool is_mine(size_t tile) { return tile > 0 && tile % (size_t)comm_size() == (size_t)comm_rank(); }

static size_t count_mine(const sd_model *m) {
  const size_t held = model_held(m);
  size_t n = 0;
  for (size_t i = 0; comm_rank() == 0 && i < held; i++) n += !m->disks[i].driven;
  for (size_t k = 0; k < m->tiles.n; k++)
    if (is_mine(k)) n += tiles_begin(&m->tiles, k + 1) - tiles_begin(&m->tiles, k);
  return n;
}

/* The disks of one tile, from this slot on. */
static sd_status fill_tile(const sd_model *m, size_t tile, sd_state *s, size_t slot, sd_messages *messages) {
  const size_t first = tiles_begin(&m->tiles, tile), n = tiles_begin(&m->tiles, tile + 1) - first;
  double *radius = malloc((n + 1) * sizeof *radius), (*position)[2] = malloc((n + 1) * sizeof *position);
  size_t placed = 0;
  sd_status status = radius && position ? tiles_make(m, tile, radius, position, &placed) : SD_ERROR_IO;
  if (status != SD_OK) comm_fail("no memory for its tiles");
  for (size_t k = 0; radius && position && placed == n && k < n; k++) {
    const sd_disk disk = model_tile_disk(&m->tiles, radius[k], position[k]);
    engine_fill_disk(s, &disk, (uint32_t)(m->tiles.first + first + k), (uint32_t)(slot + k));
  }
  free(radius);
  free(position);
  if (placed == n) return SD_OK;
  return sd_fail(messages, SD_ERROR_USER, "packings[%zu].count: " TILES_FULL, m->tiles.packing, tile,
                 m->tiles.n, placed, n);
}

static sd_status fill_disks(const sd_model *m, sd_state *s, sd_messages *messages) {
  const size_t held = model_held(m);
  size_t slot = 0;
  sd_status status = SD_OK;
  for (uint32_t i = 0; comm_rank() == 0 && i < held; i++)
    if (!m->disks[i].driven) engine_fill_disk(s, &m->disks[i], i, (uint32_t)slot++);
  for (size_t k = 0; k < m->tiles.n && status == SD_OK; k++) {
    if (!is_mine(k)) continue;
    status = fill_tile(m, k, s, slot, messages);
    slot += tiles_begin(&m->tiles, k + 1) - tiles_begin(&m->tiles, k);
  }
  assert(status != SD_OK || slot == s->n_free);
  return status;
}

/* --- together -------------------------------------------------------------------------------------------------- */

static sd_status order_made(engine *made) {
  halo *h = made->halo = calloc(1, sizeof *h);
  if (!h || !(h->order = malloc((made->state->n_free + 1) * sizeof *h->order))) return SD_ERROR_IO;
  h->n_own = made->state->n_free;
  return ranks_order(made->model, made->state, h->order);
}

sd_status ranks_tiles_new(const sd_model *m, const engine *whole, engine *made, sd_messages *messages) {
  *made = (engine){.model = m, .state = state_new_part(m, count_mine(m), 0)};
  if (!made->state || move_take_common(whole, true, made->state) != SD_OK) {
    comm_fail("no memory for its tiles");
    return SD_ERROR_IO;
  }
  const sd_status status = fill_disks(m, made->state, messages);
  /* together, or not at all: the others would wait */
  if (comm_or(status != SD_OK)) return status;
  if (order_made(made) == SD_OK) return SD_OK;
  comm_fail("no memory for its tiles");
  return SD_ERROR_IO;
}

void ranks_tiles_free(engine *made) {
  halo_free(made->halo);
  sd_state_free(made->state);
  *made = (engine){0};
}

sd_status ranks_tiles_bring(engine *whole, sd_messages *messages) {
  /* a model is const to all but the one that left its tiles away */
  if (tiles_bring((sd_model *)(uintptr_t)whole->model) != SD_OK)
    return sd_fail(messages, SD_ERROR_IO, "no memory for the disks of all tiles on one rank");
  return engine_build_again(whole, messages);
}

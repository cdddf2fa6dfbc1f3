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
#include "physics/neighbours/order.h"
#include "physics/step/engine.h"
#include "run/ranks_columns.h"
#include "run/route.h"

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
    const sd_disk disk = tiles_disk(&m->tiles, radius[k], position[k]);
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

/* Prescribed bodies, motions, and what is of the run. */
static sd_status share_common(const engine *whole, sd_state *s) {
  const size_t bytes = common_bytes(s);
  char *buffer = malloc(bytes + 1);
  if (!buffer) return SD_ERROR_IO;
  if (whole) common_copy(whole->state, buffer, false);
  comm_share(buffer, bytes);
  common_copy(s, buffer, true);
  free(buffer);
  return SD_OK;
}

/* --- their order ---------------------------------------------------------------------------------------------- */

/* Strips, some together where there are very many: buckets that ascend in the order, the last of disks that are not in play. */
typedef struct buckets {
  uint64_t strips, width; /* of one size; strips in a bucket */
  size_t n, *begin;       /* [n + 1]: disks of all ranks before them */
} buckets;

enum { STRIPS = 1 << 16 };

static size_t bucket_of(const buckets *b, const order_place *p) {
  if (p->strip == UINT64_MAX) return b->n - 1;
  return (size_t)(p->level * b->strips + p->strip / b->width);
}

static sd_status count_buckets(const order_place *list, size_t n, buckets *b) {
  double strip = 0.0, level = 0.0;
  for (size_t k = 0; k < n; k++) {
    if (list[k].strip == UINT64_MAX) continue;
    strip = fmax(strip, (double)list[k].strip);
    level = fmax(level, (double)list[k].level);
  }
  const uint64_t most = (uint64_t)comm_largest(strip) + 1;
  b->width = (most + STRIPS - 1) / STRIPS;
  b->strips = (most + b->width - 1) / b->width;
  b->n = (size_t)((uint64_t)comm_largest(level) + 1) * (size_t)b->strips + 1;
  b->begin = calloc(b->n + 1, sizeof *b->begin);
  int64_t *counts = calloc(b->n, sizeof *counts);
  if (!b->begin || !counts) {
    free(counts);
    return SD_ERROR_IO;
  }
  for (size_t k = 0; k < n; k++) counts[bucket_of(b, &list[k])]++;
  comm_add(counts, b->n);
  for (size_t k = 0; k < b->n; k++) b->begin[k + 1] = b->begin[k] + (size_t)counts[k];
  free(counts);
  return SD_OK;
}

/* The rank that numbers a bucket: they ascend with the order, so that each numbers a run of it. */
static int keeper_of(const buckets *b, size_t bucket) {
  const size_t all = b->begin[b->n], ranks = (size_t)comm_size();
  return (int)(b->begin[bucket] * ranks / all);
}

static size_t first_kept(const buckets *b) {
  size_t k = 0;
  while (k < b->n && (b->begin[k + 1] == b->begin[k] || keeper_of(b, k) < comm_rank())) k++;
  return b->begin[k];
}

/* Numbers from `first` on, by the order of the places. */
static void number_places(order_place *came, size_t n, size_t first, uint32_t *number) {
  for (size_t k = 0; k < n; k++) came[k].slot = (uint32_t)k;
  if (n > 1) qsort(came, n, sizeof *came, order_by_place);
  for (size_t k = 0; k < n; k++) number[came[k].slot] = (uint32_t)(first + k);
}

/* Numbers of places go back to the ranks that these came from. */
static sd_status send_back(const route *r, const uint32_t *number, uint32_t *order) {
  int *rank = malloc((r->n_receive + 1) * sizeof *rank);
  route back = {0};
  sd_status status = rank ? SD_OK : SD_ERROR_IO;
  size_t k = 0;
  for (int q = 0; rank && q < comm_size(); q++)
    for (int c = 0; c < r->from[q]; c++) rank[k++] = q;
  if (status == SD_OK) status = route_new(&back, r->n_receive, NULL, rank);
  if (status != SD_OK) comm_fail("no memory");
  if (status == SD_OK) {
    route_count(&back);
    assert(back.n_receive == r->n_send);
    status = route_columns(&back, &(route_column){number, order, sizeof *order}, 1, NULL);
  }
  route_free(&back);
  free(rank);
  return status;
}

/* Slots in the whole of the places of this rank, which ascend. */
static sd_status find_order(const order_place *list, size_t n, uint32_t *order) {
  buckets b = {0};
  route r = {0};
  int *rank = malloc((n + 1) * sizeof *rank);
  sd_status status = rank ? count_buckets(list, n, &b) : SD_ERROR_IO;
  for (size_t k = 0; status == SD_OK && k < n; k++) rank[k] = keeper_of(&b, bucket_of(&b, &list[k]));
  if (status == SD_OK) status = route_new(&r, n, NULL, rank);
  if (status != SD_OK) comm_fail("no memory");
  if (status == SD_OK) route_count(&r);
  order_place *came = malloc((r.n_receive + 1) * sizeof *came);
  uint32_t *number = malloc((r.n_receive + 1) * sizeof *number);
  if (!came || !number) {
    comm_fail("no memory");
    status = SD_ERROR_IO;
  }
  if (status == SD_OK) status = route_columns(&r, &(route_column){list, came, sizeof *came}, 1, NULL);
  if (status == SD_OK) {
    number_places(came, r.n_receive, first_kept(&b), number);
    status = send_back(&r, number, order);
  }
  for (size_t k = 1; k < n && status == SD_OK; k++) assert(order[k - 1] < order[k]);
  route_free(&r);
  free(b.begin);
  free(rank);
  free(came);
  free(number);
  return status;
}

/* --- together -------------------------------------------------------------------------------------------------- */

static sd_status order_made(engine *made) {
  const size_t n = made->state->n_free;
  halo *h = made->halo = calloc(1, sizeof *h);
  order_place *list = malloc((n + 1) * sizeof *list);
  sd_status status = h && list && (h->order = malloc((n + 1) * sizeof *h->order)) ? SD_OK : SD_ERROR_IO;
  if (status == SD_OK) h->n_own = n;
  if (status == SD_OK) status = order_part(made->model, made->state, comm_largest, list);
  if (status == SD_OK) status = find_order(list, n, h->order);
  free(list);
  return status;
}

sd_status ranks_tiles_new(const sd_model *m, const engine *whole, engine *made, sd_messages *messages) {
  *made = (engine){.model = m, .state = state_new_part(m, count_mine(m), 0)};
  if (!made->state || share_common(whole, made->state) != SD_OK) {
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

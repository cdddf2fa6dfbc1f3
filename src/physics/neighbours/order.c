/* order.c: sorts disks and contacts in memory; implements order_... of neighbours.h. */
#include "physics/neighbours/neighbours.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/comm.h"
#include "base/math.h"
#include "base/memory.h"
#include "model/model.h"
#include "model/state.h"
#include "physics/neighbours/grid.h"

/* --- order of the disks ----------------------------------------------------------------------- */

int order_by_place(const void *one, const void *two) {
  const order_place *p = one, *q = two;
  if ((p->strip == UINT64_MAX) != (q->strip == UINT64_MAX)) return p->strip < q->strip ? -1 : 1;
  if (p->level != q->level) return p->level < q->level ? -1 : 1;
  if (p->strip != q->strip) return p->strip < q->strip ? -1 : 1;
  if (p->strip != UINT64_MAX && p->along != q->along) return p->along < q->along ? -1 : 1;
  return p->id < q->id ? -1 : p->id > q->id;
}

typedef struct range {
  double low, high;
} range;

static bool in_play(const sd_state *s, size_t i) {
  const int32_t a = s->activity[i];
  return a == SD_IN_PLAY || a == SD_OUTSIDE || a == SD_HELD;
}

static range range_of(const sd_state *s, const double *at, const comm *c) {
  range x = {HUGE_VAL, -HUGE_VAL};
  for (size_t i = 0; i < s->n_free; i++) {
    if (!in_play(s, i)) continue;
    x.low = math_min(x.low, at[i]);
    x.high = math_max(x.high, at[i]);
  }
  x = (range){-comm_largest(c, -x.low), comm_largest(c, x.high)};
  return x;
}

/* Returns the number of the strip that contains coordinate `at`. x: range of the coordinates of all
 * disks; width: of a strip. If `folded` (for a periodic side), strips are numbered first, last,
 * second, last but one, ... so that neighbours across the edge have close numbers. */
static uint64_t strip_of(double at, range x, double width, bool folded) {
  /* limits the number of strips if a disk is lost far away */
  width = math_max(width, (x.high - x.low) * 1e-9);
  double count = floor((x.high - x.low) / width) + 1.0, k = floor((at - x.low) / width);
  k = math_min(math_max(k, 0.0), count - 1.0);
  assert(count >= 1.0 && k >= 0.0);
  if (!folded) return (uint64_t)k;
  return (uint64_t)(k < 0.5 * count ? 2.0 * k : 2.0 * (count - 1.0 - k) + 1.0);
}

/* Largest ratio of radii on one level of size. The disks of a level are sorted in strips as wide as
 * the diameter of its largest disk; levels of small disks come first. So the partners of a disk are
 * near it in memory, except larger partners, which are few and come last. */
static const double LEVEL_FACTOR = 4.0;

static void fill_places(const sd_model *m, const sd_state *s, const comm *c, order_place *list) {
  const range x = range_of(s, s->x, c), y = range_of(s, s->y, c);
  const bool along_x = x.high - x.low >= y.high - y.low;
  double top[GRID_LEVELS];
  const size_t levels = grid_levels_of(s->radius, s->n_free, LEVEL_FACTOR, c, top);
  for (uint32_t i = 0; i < s->n_free; i++) {
    list[i] = (order_place){.strip = UINT64_MAX, .id = s->id[i], .slot = i};
    if (!in_play(s, i)) continue;
    uint32_t level = 0;
    while (level + 1 < levels && s->radius[i] <= top[level + 1]) level++;
    list[i].level = (uint32_t)levels - level;
    list[i].strip = along_x ? strip_of(s->x[i], x, 2.0 * top[level], m->periodic[SD_X])
                            : strip_of(s->y[i], y, 2.0 * top[level], m->periodic[SD_Y]);
    list[i].along = along_x ? s->y[i] : s->x[i];
  }
}

/* --- columns of the state --------------------------------------------------------------------- */

/* Reorders the rows of a column: the new row k is the old row from[k]. */
static void permute(char *column, size_t row, size_t n, const uint32_t *from, char *scratch) {
  /* skip columns of zeros, of which a new state has many: their pages take no memory until they are
   * written */
  if (n == 0 || (column[0] == 0 && memcmp(column, column + 1, n * row - 1) == 0)) return;
  for (size_t k = 0; k < n; k++) memcpy(scratch + k * row, column + from[k] * row, row);
  memcpy(column, scratch, n * row);
}

static size_t rows_of(const sd_state *s, sd_extent extent, bool contacts) {
  if (contacts) return state_of_contacts(extent) ? sd_extent_size(s, extent) : 0;
  if (extent == SD_PER_LAW_FREE) return sd_extent_size(s, extent);
  if (extent == SD_PER_MEAN || extent == SD_PER_MEAN_BIN) return s->n_means;
  if (extent == SD_PER_FIELDED) return s->n_fielded;
  if (extent == SD_PER_CELL_DISK) return s->n_cell_disks;
  return extent == SD_PER_BODY || extent == SD_PER_FREE ? s->n_free : 0;
}

static void permute_all(sd_state *s, bool contacts, const uint32_t *from, void *scratch) {
  for (size_t k = 0; k < sd_field_count; k++) {
    const sd_field *f = &sd_fields[k];
    size_t row = sd_type_size(f->type) * (f->extent == SD_PER_MEAN_BIN ? SD_MEAN_BINS : 1);
    permute(sd_field_data(s, f), row, rows_of(s, f->extent, contacts), from, scratch);
  }
}

/* --- order of the contacts -------------------------------------------------------------------- */

typedef struct contact_place {
  /* list that the pair belongs to; 0: round bodies, 1: with ghosts, 2: with wall segments */
  int list;
  uint32_t a, b, part, from;
} contact_place;

static int by_slots(const void *one, const void *two) {
  const contact_place *p = one, *q = two;
  if (p->list != q->list) return p->list - q->list;
  if (p->a != q->a) return p->a < q->a ? -1 : 1;
  if (p->b != q->b) return p->b < q->b ? -1 : 1;
  return p->part < q->part ? -1 : p->part > q->part;
}

/* Swaps the bodies of contact k if needed, so that a is the disk in the lower slot. Seen from the
 * other disk, the direction and the rolling variables of the contact have the opposite sign. */
static void turn_contact(const sd_model *m, sd_state *s, size_t k, const slot_table *slots) {
  uint32_t a = s->contact_a[k], b = s->contact_b[k];
  assert(a < m->n_disks && b < sd_model_bodies(m) && a != b);
  if (b >= m->n_disks || slot_of(slots, a) < slot_of(slots, b)) return;
  s->contact_a[k] = b;
  s->contact_b[k] = a;
  s->contact_ex[k] = -s->contact_ex[k];
  s->contact_ey[k] = -s->contact_ey[k];
  if (!s->law_columns) return;
  s->contact_rho_ref[k] = -s->contact_rho_ref[k];
  s->contact_rho[k] = -s->contact_rho[k];
  s->contact_roll[k] = -s->contact_roll[k];
  s->contact_bond_rho[k] = -s->contact_bond_rho[k];
  s->contact_bond_bend[k] = -s->contact_bond_bend[k];
}

/* Lists the contacts for sorting, and returns their number. A contact from an input packing may be
 * with a disk that this rank does not have, not even as a ghost; such contacts are left out, and
 * their indices are written to the end of from[]. */
static size_t list_contacts(const sd_model *m, sd_state *s, const slot_table *slots,
                            contact_place *list, uint32_t *from) {
  size_t n = 0, last = s->n_contacts;
  for (uint32_t k = 0; k < s->n_contacts; k++) {
    if (slot_of(slots, s->contact_a[k]) == SLOT_NONE ||
        slot_of(slots, s->contact_b[k]) == SLOT_NONE) {
      from[--last] = k;
      continue;
    }
    turn_contact(m, s, k, slots);
    const uint32_t body = s->contact_b[k], a = slot_of(slots, s->contact_a[k]),
                   b = slot_of(slots, body);
    const bool piece = body >= m->n_disks && m->walls[body - m->n_disks].kind != SD_WALL_CIRCLE,
               ghost = b >= s->n_free && b < s->n_free + s->n_ghosts;
    assert(a < b);
    list[n++] = (contact_place){piece ? 2 : ghost, a, b, s->contact_part[k], k};
  }
  assert(n == last);
  return n;
}

sd_status order_contacts(const sd_model *m, sd_state *s) {
  size_t n = s->n_contacts;
  contact_place *list;
  slot_table slots;
  uint32_t *from;
  double *scratch;
  if (!slot_table_new(&slots, s, sd_model_bodies(m))) return SD_ERROR_IO;
  if (!memory_rows(3, (memory_column[]){{&list, n, sizeof *list},
                                        {&from, n, sizeof *from},
                                        {&scratch, n, sizeof *scratch}})) {
    slot_table_free(&slots);
    return SD_ERROR_IO;
  }
  n = list_contacts(m, s, &slots, list, from);
  if (n > 1) qsort(list, n, sizeof *list, by_slots);
  for (size_t k = 0; k < n; k++) from[k] = list[k].from;
  permute_all(s, true, from, scratch);
  s->n_contacts = n;
  free(list);
  free(from);
  slot_table_free(&slots);
  free(scratch);
  return SD_OK;
}

sd_status order_part(const sd_model *m, sd_state *s, const comm *c, order_place *list) {
  size_t row = s->n_means ? SD_MEAN_BINS * sizeof(double) : sizeof(double);
  uint32_t *from;
  void *scratch;
  if (!memory_rows(2,
                   (memory_column[]){{&from, s->n_free, sizeof *from}, {&scratch, s->n_free, row}}))
    return SD_ERROR_IO;
  fill_places(m, s, c, list);
  if (s->n_free > 1) qsort(list, s->n_free, sizeof *list, order_by_place);
  for (size_t k = 0; k < s->n_free; k++) from[k] = list[k].slot;
  for (size_t k = 1; k < s->n_free; k++) assert(order_by_place(&list[k - 1], &list[k]) < 0);
  permute_all(s, false, from, scratch);
  free(from);
  free(scratch);
  return SD_OK;
}

sd_status order_disks(const sd_model *m, sd_state *s) {
  order_place *list;
  if (!memory_row(&list, s->n_free, sizeof *list)) return SD_ERROR_IO;
  const sd_status status = order_part(m, s, NULL, list);
  free(list);
  return status == SD_OK ? order_contacts(m, s) : status;
}

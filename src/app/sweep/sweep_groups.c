/* sweep_groups.c: which points of a sweep are run side by side.
 *
 * A group takes about as long as its longest point, however few it has. So points of one kind go together, those of
 * equal length next to each other, in groups as large as the machine likes; when that leaves workers idle the
 * largest groups are halved until each has one.
 */
#include <stdlib.h>

#include "app/sweep/sweep_scheduler.h"
#include "base/memory.h"

typedef struct entry {
  size_t kind; /* point with which its kind begins; its own: alone */
  int64_t steps;
  size_t point;
} entry;

/* Kinds as they appear, the longest first, in the order of the deck. */
static int compare(const void *a, const void *b) {
  const entry *p = a, *q = b;
  if (p->kind != q->kind) return p->kind < q->kind ? -1 : 1;
  if (p->steps != q->steps) return p->steps > q->steps ? -1 : 1;
  return p->point < q->point ? -1 : p->point > q->point;
}

static void sort(entry *entries, const scheduler *w, const size_t *points, size_t n, size_t *begins) {
  for (size_t k = 0; k < n; k++) {
    size_t point = points[k];
    int kind = w->kinds[point];
    bool alone = kind == SWEEP_ALONE || w->tried[point] == CRASHED;
    if (!alone && begins[kind] == SIZE_MAX) begins[kind] = point;
    entries[k] = (entry){alone ? point : begins[kind], w->steps[point], point};
  }
  qsort(entries, n, sizeof *entries, compare);
}

static void halve(sweep_groups *g, size_t k) {
  for (size_t j = g->n; j > k + 1; j--) g->list[j] = g->list[j - 1];
  sweep_group *one = &g->list[k];
  size_t half = (one->n + 1) / 2;
  g->list[k + 1] = (sweep_group){.first = one->first + half, .n = one->n - half};
  one->n = half;
  g->n++;
}

static size_t largest(const sweep_groups *g) {
  size_t best = 0;
  for (size_t k = 1; k < g->n; k++)
    if (g->list[k].n > g->list[best].n) best = k;
  return best;
}

void sweep_groups_make(sweep_groups *g, const scheduler *w, const size_t *points, size_t n, size_t workers) {
  size_t n_kinds = w->s->deck.n_sets;
  entry *entries = memory_new(n, sizeof *entries);
  size_t *begins = memory_new(n_kinds, sizeof *begins);
  *g = (sweep_groups){.order = memory_new(n, sizeof *g->order),
                      .list = memory_new(n + 1, sizeof *g->list),
                      .capacity = n + 1};
  for (size_t k = 0; k < n_kinds; k++) begins[k] = SIZE_MAX;
  sort(entries, w, points, n, begins);
  for (size_t k = 0; k < n; k++) {
    g->order[k] = entries[k].point;
    bool same = k > 0 && entries[k].kind == entries[k - 1].kind;
    if (!same || g->list[g->n - 1].n >= w->width) g->list[g->n++] = (sweep_group){.first = k};
    g->list[g->n - 1].n++;
  }
  for (size_t k; g->n > 0 && g->n < workers && (k = largest(g), g->list[k].n > 1);) halve(g, k);
  free(entries);
  free(begins);
}

void sweep_groups_put_off(sweep_groups *g, sweep_group one) {
  if (g->n == g->capacity) {
    g->capacity *= 2;
    g->list = memory_grow(g->list, g->capacity, sizeof *g->list);
  }
  one.late = true;
  g->list[g->n++] = one;
}

void sweep_groups_free(sweep_groups *g) {
  free(g->order);
  free(g->list);
  *g = (sweep_groups){0};
}

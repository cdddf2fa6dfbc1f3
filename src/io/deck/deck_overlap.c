/* deck_overlap.c: reports disks that overlap too much at the start, lie outside the box or
 * penetrate a wall. See deck_tree.h. */
#include <math.h>

#include "io/deck/deck_tree.h"
#include "model/overlaps.h"

/* Number of mistakes of one kind that are shown; further ones are counted, since one wrong
 * number can move all disks. */
enum { MOST_ALIKE = 8 };

typedef struct teller {
  deck *d;
  size_t found;
} teller;

static void tell_rest(deck *d, size_t found, const char *what) {
  if (found > MOST_ALIKE)
    deck_fail_place(d, (deck_place){d->path, 0}, "%zu more %s", found - MOST_ALIKE, what);
}

/* Reports a pair of disks that overlap too much. Returns true once enough were shown; then only
 * one pair of each disk is counted. */
static bool tell_disks(void *user, const overlap *o) {
  teller *t = user;
  const sd_model *m = t->d->model;
  bool still = m->disks[o->a].driven && m->disks[o->b].driven;
  double smaller = m->disks[o->a].radius;
  if (!o->coincident && (still || o->depth <= m->max_overlap * smaller)) return false;
  if (t->found++ >= MOST_ALIKE) return true;
  uint32_t later = o->a > o->b ? o->a : o->b, earlier = o->a > o->b ? o->b : o->a;
  const char *one = deck_body_name(t->d, later), *two = deck_body_name(t->d, earlier);
  if (o->coincident)
    deck_fail_place(t->d, t->d->disk_place[later], "%s and %s have the same centre", one, two);
  else
    deck_fail_place(t->d, t->d->disk_place[later],
                    "%s and %s overlap by %g, more than max_overlap = %g of the smaller radius %g",
                    one, two, o->depth, m->max_overlap, smaller);
  return false;
}

static bool tell_wall(void *user, const overlap *o) {
  teller *t = user;
  const sd_model *m = t->d->model;
  double radius = rows_disk(m, o->row)->radius;
  if (!(o->depth > m->max_overlap * radius) || t->found++ >= MOST_ALIKE) return false;
  deck_fail_place(t->d, deck_disk_place(t->d, o->a),
                  "%s sits %g deep in %s, more than max_overlap = %g of its radius %g",
                  deck_body_name(t->d, o->a), o->depth, deck_body_name(t->d, o->b), m->max_overlap,
                  radius);
  return false;
}

static void check_inside(deck *d) {
  const sd_model *m = d->model;
  size_t found = 0;
  for (size_t row = 0; row < rows_count(m); row++)
    for (int c = 0; c < 2; c++) {
      double x = rows_disk(m, row)->position[c];
      if (!m->periodic[c] || isnan(x) || !(m->upper[c] > m->lower[c]) ||
          (x >= m->lower[c] && x < m->upper[c]))
        continue;
      if (found++ >= MOST_ALIKE) continue;
      const uint32_t i = rows_number(m, row);
      deck_fail_place(d, deck_disk_place(d, i),
                      "%s: %c = %g lies outside the periodic box from %g to %g",
                      deck_body_name(d, i), c == SD_X ? 'x' : 'y', x, m->lower[c], m->upper[c]);
    }
  tell_rest(d, found, "coordinates lie outside the periodic box");
}

void deck_check_overlaps(deck *d) {
  teller disks = {.d = d}, walls = {.d = d};
  if (!(d->model->max_overlap > 0)) return;
  check_inside(d);
  sd_status status = overlaps_of_disks(d->model, tell_disks, &disks);
  tell_rest(d, disks.found, "disks overlap others too much");
  if (status == SD_OK) overlaps_with_walls(d->model, tell_wall, &walls);
  if (status != SD_OK) longjmp(d->out_of_memory, 1);
  tell_rest(d, walls.found, "disks sit too deep in a wall");
}

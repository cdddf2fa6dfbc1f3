/* ranks_contacts.c: see ranks_contacts.h. */
#include "run/ranks_contacts.h"

#include <stdlib.h>

#include "base/comm.h"
#include "io/deck/deck.h"
#include "model/tiles.h"
#include "physics/step/engine.h"
#include "run/directory.h"
#include "run/route.h"

/* Contacts that a rank reads at a time. */
enum { AT_ONCE = 1 << 16 };

/* Fills a directory of the file's disks, by their numbers there. */
static sd_status tell_turned(const comm *c, const sd_model *m, directory *d, sd_messages *messages) {
  const sd_tiles *t = &m->tiles;
  const size_t most = model_tile_begin(t, 1), ranks = (size_t)comm_size(c);
  uint32_t *number = route_room(c, most, sizeof *number);
  deck_turned *turned = route_room(c, most, sizeof *turned);
  sd_status status = SD_OK;
  for (size_t k = 0; k < t->n && !comm_or(c, status != SD_OK); k += ranks) {
    const size_t part = k + (size_t)comm_rank(c);
    const size_t n = part < t->n ? model_tile_begin(t, part + 1) - model_tile_begin(t, part) : 0;
    if (n > 0) status = deck_make_turned(m, part, number, turned, messages);
    directory_put(d, status == SD_OK ? n : 0, number, turned);
  }
  free(number);
  free(turned);
  return status;
}

static const sd_tile_wall *wall_of(const sd_tiles *t, const sd_contact_memory *c) {
  return c->b < t->count ? NULL : &t->walls[c->b - t->count];
}

/* Into the state, as the model has them. */
static void fill_contacts(const sd_model *m, const directory *d, const sd_contact_memory *list, size_t n,
                          sd_state *s) {
  const sd_tiles *t = &m->tiles;
  uint32_t *number = route_room(d->comm, 2 * n, sizeof *number); /* of first disks, then of second ones */
  deck_turned *turned = route_room(d->comm, 2 * n, sizeof *turned);
  for (size_t k = 0; k < n; k++) {
    number[k] = list[k].a;
    number[n + k] = wall_of(t, &list[k]) ? list[k].a : list[k].b;
  }
  directory_get(d, 2 * n, number, turned);
  if (sd_state_reserve_contacts(s, s->n_contacts + n) != SD_OK) comm_fail(d->comm, "no memory for contacts");
  for (size_t k = 0; k < n; k++) {
    sd_contact_memory c = list[k];
    const sd_tile_wall *wall = wall_of(t, &c);
    deck_carry_contact(&c, turned[k], turned[n + k], wall, t->forces_carried);
    c.a += (uint32_t)t->first;
    c.b = wall ? (uint32_t)m->n_disks + wall->wall : c.b + (uint32_t)t->first;
    engine_fill_contact(s, &c);
  }
  free(number);
  free(turned);
}

/* Reads contacts, and leaves out those with walls that the model does not have. list: room for n.
 * */
static sd_status read_some(const sd_model *m, size_t first, size_t n, sd_contact_memory *list, size_t *n_kept,
                           int64_t *inputs, sd_messages *messages) {
  int64_t sum = 0;
  *n_kept = 0;
  sd_status status = SD_OK;
  if (n > 0) status = deck_make_contacts(m, first, n, list, &sum, messages);
  *inputs = (int64_t)((uint64_t)*inputs + (uint64_t)sum);
  for (size_t k = 0; status == SD_OK && k < n; k++)
    if (deck_contact_is_kept(&list[k], wall_of(&m->tiles, &list[k]))) list[(*n_kept)++] = list[k];
  return status;
}

static sd_status read_all(const comm *c, const sd_model *m, const directory *d, sd_state *s,
                          sd_messages *messages) {
  const sd_tiles *t = &m->tiles;
  const size_t all = (size_t)comm_size(c) * AT_ONCE;
  int64_t inputs[1] = {0};
  sd_contact_memory *list = route_room(c, AT_ONCE, sizeof *list);
  sd_status status = SD_OK;
  for (size_t at = 0; at < t->n_contacts && !comm_or(c, status != SD_OK); at += all) {
    const size_t first = at + (size_t)comm_rank(c) * AT_ONCE,
                 left = first < t->n_contacts ? t->n_contacts - first : 0;
    size_t n;
    status = read_some(m, first, left < AT_ONCE ? left : AT_ONCE, list, &n, inputs, messages);
    fill_contacts(m, d, list, n, s);
  }
  free(list);
  if (comm_or(c, status != SD_OK)) return status;
  comm_add(c, inputs, 1);
  if (inputs[0] == t->contact_inputs) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "disk_files[%zu].file has changed while it was read", t->entry);
}

sd_status ranks_contacts_read(const comm *c, const sd_model *m, sd_state *s, sd_messages *messages) {
  directory d;
  directory_new(&d, c, m->tiles.count, sizeof(deck_turned));
  sd_status status = tell_turned(c, m, &d, messages);
  if (!comm_or(c, status != SD_OK)) status = read_all(c, m, &d, s, messages);
  directory_free(&d);
  return status;
}

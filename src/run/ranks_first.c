/* ranks_first.c: reads a deck on several ranks and makes the state of each rank at step 0; see
 * ranks.h. */
#include "run/ranks.h"

#include <assert.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/deck/deck.h"
#include "io/results/provenance.h"
#include "model/model.h"
#include "model/rows.h"
#include "physics/neighbours/neighbours.h"
#include "physics/small/lanes.h"
#include "physics/step/engine.h"
#include "run/steps.h"
#include "run/ranks_move.h"
#include "run/route.h"

/* --- Deck ------------------------------------------------------------------------------------- */

/* Collective: reads the deck given on rank 0 on all ranks; each rank keeps only some of the
 * disks. */
static sd_status load(const comm *c, const char *text, const char *path, size_t n_overrides,
                      const char *const *overrides, sd_model **out, sd_messages *messages) {
  char *lines = memory_text(""), *all = comm_text(c, text), *name = comm_text(c, path);
  for (size_t k = 0; k < n_overrides; k++) lines = append_text(lines, "%s\n", overrides[k]);
  char *shared = comm_text(c, lines);
  size_t n;
  const char **list = text_lines(shared, &n);
  const sd_status status = deck_load_for_ranks(c, all, name, n, list, ranks_suit, out, messages);
  if (status == SD_OK) {
    (*out)->inputs = provenance_inputs(*out);
    if (model_part(*out, ORDER_LEAST) != SD_OK) comm_fail(c, "no memory for its disks");
    (*out)->comm = NULL;
  }
  free(list);
  free(shared);
  free(lines);
  free(name);
  free(all);
  return status;
}

sd_status ranks_load(const comm *c, const char *text, const char *path, size_t n_overrides,
                     const char *const *overrides, sd_model **out, sd_messages *messages) {
  const bool leads = comm_rank(c) == 0;
  sd_messages *own = sd_messages_new();
  sd_status status = SD_OK;
  char *read = leads && !text ? deck_file_text(path, own, &status) : NULL;
  *out = NULL;
  status = comm_agree(c, status);
  if (status == SD_OK)
    status = load(c, read ? read : text, text ? path : deck_source(path), n_overrides, overrides,
                  out, own);
  ranks_report(c, status, own, leads ? messages : NULL);
  sd_messages_free(own);
  free(read);
  return status;
}

/* --- Contacts of a file of which each rank has read some rows --------------------------------- */

/* Returns the wall of a contact that was read from a file; NULL: it is a contact of two disks. */
static const sd_tile_wall *wall_of(const sd_tiles *t, const sd_contact_memory *c) {
  return c->b < t->count ? NULL : &t->walls[c->b - t->count];
}

/* Stores radius and angle of the disks that this rank has read from a file in a distributed table
 * (directory), by their numbers in the file. */
static void tell_turned(const comm *c, const sd_model *m, directory *d) {
  const sd_rows *own = m->mine;
  uint32_t *number = route_allocate(c, own->n, sizeof *number);
  disk_angle_shift *turned = route_allocate(c, own->n, sizeof *turned);
  size_t n = 0;
  for (size_t k = 0; k < own->n; k++) {
    if (own->number[k] < m->tiles.first) continue;
    number[n] = own->number[k] - (uint32_t)m->tiles.first;
    turned[n++] = (disk_angle_shift){own->disk[k].radius, own->shift[k]};
  }
  directory_put(d, n, number, turned);
  free(number);
  free(turned);
}

/* Converts the contacts that this rank has read from a file into contacts of the model, and adds
 * them to the state. */
static void fill_contacts(const sd_model *m, const directory *d, sd_state *s) {
  const sd_tiles *t = &m->tiles;
  const sd_contact_memory *list = m->mine->contacts;
  const size_t n = m->mine->n_contacts;
  /* [2 n] numbers of the first disks of the n contacts, then of the second disks */
  uint32_t *number = route_allocate(d->comm, 2 * n, sizeof *number);
  disk_angle_shift *turned = route_allocate(d->comm, 2 * n, sizeof *turned);
  for (size_t k = 0; k < n; k++) {
    number[k] = list[k].a;
    number[n + k] = wall_of(t, &list[k]) ? list[k].a : list[k].b;
  }
  directory_get(d, 2 * n, number, turned);
  if (sd_state_reserve_contacts(s, s->n_contacts + n) != SD_OK)
    comm_fail(d->comm, "no memory for contacts");
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

static void take_contacts(const comm *c, const sd_model *m, sd_state *s) {
  directory d;
  directory_new(&d, c, m->tiles.count, sizeof(disk_angle_shift));
  tell_turned(c, m, &d);
  fill_contacts(m, &d, s);
  directory_free(&d);
}

/* --- State ------------------------------------------------------------------------------------ */

/* Sorts the disks of all ranks in space; order: receives the slots of this rank's disks. If there
 * are few, they stay in the order of the deck, and rank 0 has all of them. */
static sd_status find_order(const comm *c, const sd_model *m, sd_state *s, uint32_t *order) {
  if (m->n_free >= ORDER_LEAST) return ranks_order(c, m, s, order);
  for (size_t i = 0; i < s->n_free; i++) order[i] = (uint32_t)i;
  return SD_OK;
}

/* Ends the job on all ranks with the message `why`, and returns SD_ERROR_IO. */
static sd_status give_up(const comm *c, const char *why) {
  comm_fail(c, why);
  return SD_ERROR_IO;
}

sd_status ranks_first_new(const comm *c, const sd_model *m, sd_state **state, uint32_t **order) {
  const sd_rows *own = m->mine;
  assert(m->parted && own);
  sd_state *s = *state = state_new_part(m, own->n, 0);
  *order = route_allocate(c, own->n, sizeof **order);
  if (!s) return give_up(c, "no memory for its disks");
  for (size_t k = 0; k < own->n; k++)
    engine_fill_disk(s, &own->disk[k], own->number[k], (uint32_t)k);
  for (size_t k = 0; own->derivatives && k < own->n; k++)
    engine_fill_derivatives(s, k, own->derivatives[k]);
  engine_fill_prescribed(m, s);
  const sd_status status = find_order(c, m, s, *order);
  if (!comm_all_well(c, status)) return status;
  if (engine_fill_contacts(s, own->n_memories, own->memories) != SD_OK)
    return give_up(c, "no memory for contacts");
  if (m->tiles.away && m->tiles.n_contacts > 0) take_contacts(c, m, s);
  rows_free(m->mine);
  return SD_OK;
}

/* Returns the index of the first motion that moves a free disk; n_motions: there is none. */
static size_t moves_free_disk(const sd_model *m) {
  for (size_t k = 0; k < m->n_motions; k++)
    for (size_t b = 0; b < m->motions[k].n_bodies; b++) {
      const uint32_t body = m->motions[k].bodies[b];
      if (body < m->n_disks && !m->disks[body].driven) return k;
    }
  return m->n_motions;
}

static void refuse(sd_messages *messages, subject about, const char *what) {
  fail_about(messages, about, "%s, which ranks do not share; run it without mpirun, with --threads",
             what);
}

sd_status ranks_suit(const sd_model *m, sd_messages *messages) {
  const size_t before = sd_messages_errors(messages);
  const size_t motion = moves_free_disk(m);
  if (lanes_suit(m))
    return fail_about(messages, about_path("disks"),
                      "%zu free disk%s, so few are for one process; run it without mpirun, or the "
                      "points of a sweep under it",
                      m->n_free, m->n_free == 1 ? "" : "s");
  if (m->n_clumps > 0) refuse(messages, about_path("clumps"), "rigid bodies of several disks");
  for (size_t k = 0; k < m->n_phases; k++)
    if (m->phases[k].cell.asked)
      refuse(messages, about_path("phases[%zu].cell", k), "a box that deforms");
  if (m->n_rotations > 0)
    refuse(messages, about_path("measure.rotation"), "means of single disks (() watches none)");
  if (m->n_slides > 0)
    refuse(messages, about_path("measure.sliding"), "contacts of single disks that are watched");
  if (motion < m->n_motions)
    fail_about(
        messages, about_motion(m, motion),
        "it moves a free disk, which ranks do not share; fix the disk, or run it without mpirun");
  return sd_messages_errors(messages) > before ? SD_ERROR_USER : SD_OK;
}

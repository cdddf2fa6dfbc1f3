/* engine.c: the functions of slipdisk.wasm that slipdisk.mjs calls; slipdisk.d.mts documents what
 * they do.
 *
 * Numbers of steps are doubles, which hold them up to 2^53, since 64-bit integers are awkward in
 * JavaScript. Arrays go through memory that the caller gets from `play_memory`. Functions that can
 * fail return an sd_status and leave their messages in one list, which the next call clears.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/message.h"
#include "base/text.h"
#include "measure/configuration.h"
#include "model/state.h"
#include "slipdisk/deck.h"
#include "slipdisk/measure.h"
#include "slipdisk/simulation.h"

#define EXPORT(name) __attribute__((export_name(#name)))

/* Spring between a free disk and a point of the plane, as of a mouse. */
typedef struct grip {
  bool on;
  uint32_t disk;
  double x, y, stiffness, damping;
} grip;

/* A simulation of the page. */
typedef struct play {
  sd_model *model;
  sd_simulation *simulation;
  grip grip;
  bool pulled;    /* true: the force field of the grip was added */
  double *table;  /* result of the last play_contacts or play_walls */
  sd_column view; /* result of the last play_column */
} play;

static sd_messages *messages;

static sd_messages *clean(void) {
  if (!messages) messages = sd_messages_new();
  sd_messages_clear(messages);
  return messages;
}

/* --- memory and messages ---------------------------------------------------------------------- */

EXPORT(play_memory) void *play_memory(size_t bytes) { return malloc(bytes > 0 ? bytes : 1); }
EXPORT(play_forget) void play_forget(void *memory) { free(memory); }
EXPORT(play_version) const char *play_version(void) { return sd_version(); }
EXPORT(play_messages) size_t play_messages(void) { return sd_messages_count(messages); }
EXPORT(play_message) const char *play_message(size_t k) { return sd_messages_text(messages, k); }
/* 0: the message is a warning. */
EXPORT(play_message_kind) int play_message_kind(size_t k) {
  return (int)sd_messages_kind(messages, k);
}

/* --- beginning and end ------------------------------------------------------------------------ */

EXPORT(play_free) void play_free(play *p) {
  if (!p) return;
  sd_simulation_free(p->simulation);
  sd_model_free(p->model);
  free(p->table);
  free(p);
}

/* Makes a simulation of a deck. settings: n texts "key=value", one after the other, each with its
 * zero byte. Returns NULL after an error; warnings are messages, too. */
EXPORT(play_new) play *play_new(const char *deck, size_t n, const char *settings) {
  const char **overrides = memory_new(n, sizeof *overrides);
  for (size_t k = 0; k < n; k++, settings += strlen(settings) + 1) overrides[k] = settings;
  play *p = memory_new(1, sizeof *p);
  sd_status status = sd_deck_load_text(deck, "deck", n, overrides, &p->model, clean());
  free(overrides);
  if (status == SD_OK) sd_model_advise(p->model, messages);
  if (status == SD_OK) status = sd_simulation_new(p->model, 1, &p->simulation, messages);
  if (status == SD_OK) return p;
  play_free(p);
  return NULL;
}

/* --- stepping and steering -------------------------------------------------------------------- */

EXPORT(play_advance) int play_advance(play *p, double n) {
  return (int)sd_simulation_advance(p->simulation, (int64_t)n, clean());
}

/* index: [n] or NULL; values as for sd_simulation_set. */
EXPORT(play_set)
int play_set(play *p, const char *name, size_t n, const uint32_t *index, const double *values) {
  return (int)sd_simulation_set(p->simulation, name, n, index, values, clean());
}

EXPORT(play_get) double play_get(const play *p, const char *name, uint32_t index) {
  return sd_simulation_get(p->simulation, name, index);
}

/* other: name of the second material of a contact law, else "". */
EXPORT(play_index)
uint32_t play_index(const play *p, const char *quantity, const char *name, const char *other) {
  return sd_simulation_index(p->simulation, quantity, name, *other ? other : NULL);
}

/* Pulls the disk to the point; the disk is found by its number, since slots change. */
static void pull(const sd_force_columns *c, void *user) {
  const grip *g = user;
  for (size_t i = 0; g->on && i < c->n_free; i++) {
    if (c->id[i] != g->disk || c->activity[i] != SD_IN_PLAY) continue;
    c->force_x[i] += g->stiffness * (g->x - c->x[i]) - g->damping * c->vx[i];
    c->force_y[i] += g->stiffness * (g->y - c->y[i]) - g->damping * c->vy[i];
    return;
  }
}

EXPORT(play_grab)
int play_grab(play *p, uint32_t disk, double x, double y, double stiffness, double damping) {
  clean();
  const sd_state *s = sd_simulation_state(p->simulation);
  if (sd_simulation_slot(p->simulation, disk) >= s->n_free)
    return (int)sd_fail(messages, SD_ERROR_USER, "grab: %" PRIu32 " is no free disk", disk);
  if (!isfinite(x + y + stiffness + damping))
    return (int)sd_fail(messages, SD_ERROR_USER, "grab: point, stiffness and damping are to be finite");
  p->grip = (grip){true, disk, x, y, stiffness, damping};
  if (p->pulled) return SD_OK;
  const sd_status status = sd_simulation_add_force_field(p->simulation, pull, &p->grip, messages);
  p->pulled = status == SD_OK;
  return (int)status;
}

EXPORT(play_release) void play_release(play *p) { p->grip.on = false; }

/* rows: [n][8] x, y, radius, mass, vx, vy, omega, material. */
EXPORT(play_add) int play_add(play *p, size_t n, const double *rows, uint32_t *first) {
  sd_disk *disks = memory_new(n, sizeof *disks);
  for (size_t k = 0; k < n; k++, rows += 8)
    disks[k] = (sd_disk){.position = {rows[0], rows[1], 0},
                         .radius = rows[2],
                         .mass = rows[3],
                         .velocity = {rows[4], rows[5], rows[6]},
                         .material = (int)rows[7],
                         .group = -1};
  const sd_status status = sd_simulation_add_disks(p->simulation, n, disks, first, clean());
  free(disks);
  return (int)status;
}

EXPORT(play_remove) int play_remove(play *p, size_t n, const uint32_t *disks) {
  return (int)sd_simulation_remove_disks(p->simulation, n, disks, clean());
}

/* --- reading ---------------------------------------------------------------------------------- */

static const sd_model *model_of(const play *p) { return sd_simulation_model(p->simulation); }

/* Numbers of the simulation for play_number, in the order of slipdisk.mjs. */
enum { STEP, TIME, DT, FINISHED, PHASE, PHASE_STEP, BEFORE, DISKS, FREE, BODIES, MATERIALS };

EXPORT(play_number) double play_number(const play *p, int which) {
  const sd_stage stage = sd_simulation_stage(p->simulation);
  const sd_model *m = model_of(p);
  switch (which) {
    case STEP: return (double)stage.step;
    case TIME: return sd_simulation_time(p->simulation);
    case DT: return sd_model_dt(m);
    case FINISHED: return sd_simulation_finished(p->simulation);
    case PHASE: return (double)stage.phase;
    case PHASE_STEP: return (double)stage.phase_step;
    case BEFORE: return (double)stage.before;
    case DISKS: return (double)sd_model_disks(m);
    case FREE: return (double)m->n_free;
    case BODIES: return (double)sd_model_bodies(m);
    case MATERIALS: return (double)m->n_materials;
    default: return NAN;
  }
}

EXPORT(play_deck) const char *play_deck(const play *p) { return sd_model_deck(p->model)->full; }

/* Finds a column, which play_column_data, play_column_type and play_column_size then describe;
 * false: there is none. */
EXPORT(play_column) bool play_column(play *p, const char *name) {
  return sd_simulation_column(p->simulation, name, &p->view);
}
EXPORT(play_column_data) const void *play_column_data(const play *p) { return p->view.data; }
EXPORT(play_column_type) int play_column_type(const play *p) { return (int)p->view.type; }
EXPORT(play_column_size) size_t play_column_size(const play *p) { return p->view.n; }

EXPORT(play_slot) uint32_t play_slot(const play *p, uint32_t body) {
  return sd_simulation_slot(p->simulation, body);
}

EXPORT(play_find) uint32_t play_find(const play *p, const char *name) {
  return sd_model_find(model_of(p), name);
}

EXPORT(play_name) const char *play_name(const play *p, uint32_t body) {
  static char text[96];
  return sd_model_body_name(model_of(p), body, text, sizeof text);
}

EXPORT(play_hash) const char *play_hash(play *p) {
  static char text[20];
  const sd_state *state = sd_simulation_state(p->simulation);
  snprintf(text, sizeof text, "%016" PRIx64, state ? sd_state_hash(state) : 0);
  return text;
}

/* Writes the members of sd_energy, all of them doubles, and returns their number. */
EXPORT(play_energy) size_t play_energy(play *p, double *numbers) {
  const sd_energy energy = sd_simulation_energy(p->simulation);
  memcpy(numbers, &energy, sizeof energy);
  return sizeof energy / sizeof *numbers;
}

/* numbers: [6] mean, error, correlation, used, discarded, converged. */
EXPORT(play_mean) void play_mean(const double *samples, size_t n, int transient, double *numbers) {
  const sd_mean m = sd_mean_of(samples, n, transient != 0);
  const double found[] = {
      m.mean, m.error, m.correlation, (double)m.used, (double)m.discarded, (double)m.converged};
  memcpy(numbers, found, sizeof found);
}

/* numbers: [9] disk, omega, error, scaled, scaled_error, transient, measured, turned, converged.
 * Returns 0 if the deck does not watch so many disks. */
EXPORT(play_rotation) int play_rotation(play *p, size_t k, double *numbers) {
  const sd_state *state = sd_simulation_state(p->simulation);
  const sd_rotation r = sd_rotation_of(model_of(p), state, k);
  const double found[] = {(double)r.disk, r.omega,    r.error,  r.scaled,           r.scaled_error,
                          r.transient,    r.measured, r.turned, (double)r.converged};
  memcpy(numbers, found, sizeof found);
  return r.disk != UINT32_MAX;
}

/* --- contacts and walls in the plane ---------------------------------------------------------- */

/* Number of columns of play_contacts. */
enum { CONTACT_COLUMNS = 10 };

static void put_contact(double *row, const configuration *c, size_t n_disks,
                        const config_contact *k) {
  const size_t here = c->model->n_disks;
  const double b = k->b < here ? (double)c->number[k->b] : (double)(k->b - here + n_disks);
  const double found[CONTACT_COLUMNS] = {(double)c->number[k->a],
                                         b,
                                         k->x,
                                         k->y,
                                         k->nx,
                                         k->ny,
                                         k->force,
                                         k->fy * k->nx - k->fx * k->ny,
                                         k->overlap,
                                         (double)(k->slide != 0)};
  memcpy(row, found, sizeof found);
}

static size_t wall_numbers(const sd_wall *w) { return 7 + 2 * w->n_points; }

static double *put_wall(double *row, const sd_wall *w) {
  const double *center = w->kind == SD_WALL_ARC ? w->center : w->pivot;
  const double head[] = {(double)w->kind, (double)w->closed, (double)w->inside,  w->radius,
                         center[0],       center[1],         (double)w->n_points};
  memcpy(row, head, sizeof head);
  row += sizeof head / sizeof *head;
  for (size_t k = 0; k < w->n_points; k++, row += 2) memcpy(row, w->points[k], 2 * sizeof *row);
  return row;
}

/* Fills p->table with contacts (walls false) or walls of the present moment; *n: their number. */
static sd_status tabulate(play *p, bool walls, size_t *n) {
  const sd_model *model = model_of(p);
  const sd_state *state = sd_simulation_state(p->simulation);
  frame_data frame = {0};
  configuration c = {0};
  if (!state) return sd_fail(messages, SD_ERROR_IO, "out of memory for the contacts");
  sd_status status = frame_data_of_state(&frame, model, state, messages);
  if (status == SD_OK) status = configuration_new(&c, model, &frame, messages);
  if (status == SD_OK) {
    size_t size = 0;
    *n = walls ? c.model->n_walls : c.n_contacts;
    for (size_t k = 0; walls && k < *n; k++) size += wall_numbers(&c.model->walls[k]);
    p->table = memory_grow(p->table, walls ? size : *n * CONTACT_COLUMNS, sizeof *p->table);
    double *row = p->table;
    for (size_t k = 0; k < *n; k++)
      if (walls)
        row = put_wall(row, &c.model->walls[k]);
      else
        put_contact(row + k * CONTACT_COLUMNS, &c, sd_model_disks(model), &c.contacts[k]);
  }
  configuration_free(&c);
  frame_data_free(&frame);
  return status;
}

/* Returns a table of contacts, rows of a, b, x, y, nx, ny, normal and tangential force, overlap,
 * sliding; *n: number of rows. NULL after an error. */
EXPORT(play_contacts) const double *play_contacts(play *p, size_t *n) {
  clean();
  return tabulate(p, false, n) == SD_OK ? p->table : NULL;
}

/* Returns the walls, one after the other: kind, closed, inside, radius, centre x and y, number of
 * points, points; *n: number of walls. NULL after an error. */
EXPORT(play_walls) const double *play_walls(play *p, size_t *n) {
  clean();
  return tabulate(p, true, n) == SD_OK ? p->table : NULL;
}

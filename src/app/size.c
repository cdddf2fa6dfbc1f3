/* size.c: estimates the size of a result from the deck alone: rows of each table, columns of the
 * state, overhead of HDF5, and the effect of compression. */
#include <inttypes.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>

#include "app/app.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/results/record.h"
#include "model/model.h"
#include "model/state.h"
#include "run/session.h"
#include "slipdisk/deck.h"

/* Overhead of HDF5 in bytes, about 640 for each dataset with its header and attributes. FILE_BYTES:
 * for datasets that every file has; WALLS_BYTES: for those about walls. */
static const double FILE_BYTES = 160e3, WALLS_BYTES = 40e3;
/* Bytes per body for data that do not change during the run: mass, radius, group and the like. */
static const double BODY_BYTES = 40;
/* Compressed size divided by plain size: of coordinates in frames, of contact forces. The trailing
 * bytes of the numbers are noise. Integers in frames compress to almost nothing. */
static const double NOISE_LEFT = 0.88, FORCE_LEFT = 0.85;
/* Number of contacts per free disk that is assumed for a packing; a contact of two disks counts
 * once. */
enum { CONTACTS_PER_DISK = 2 };

typedef struct rows {
  int64_t series, frames, contacts;
} rows;

/* Returns the number of contacts that is assumed: CONTACTS_PER_DISK times the number of free disks,
 * but at most the number of pairs with a free disk. */
static size_t most_contacts(const sd_model *m) {
  double free = (double)m->n_free,
         pairs = free * ((double)sd_model_bodies(m) - free) + free * (free - 1) / 2;
  size_t usual = CONTACTS_PER_DISK * m->n_free;
  return pairs < (double)usual ? (size_t)pairs : usual;
}

/* Returns the number of rows of a table that is sampled at a fixed interval of steps (session_due):
 * rows inside each phase; one at the border of two phases if the new phase samples rows or the old
 * one ends with a row; and one at the first and at the last step. every_offset: offset of the
 * interval in sd_phase. */
static int64_t rows_of(const sd_model *m, size_t every_offset) {
  int64_t n = 2;
  bool ends = false; /* True if the previous phase has a row at its end */
  for (size_t k = 0; k < m->n_phases; k++) {
    const sd_phase *p = &m->phases[k];
    int64_t every;
    memcpy(&every, (const char *)p + every_offset, sizeof every);
    if (k > 0) n += every > 0 || ends;
    if (every > 0) n += (p->steps - 1) / every;
    ends = every > 0 && p->steps % every == 0;
  }
  return n;
}

static rows count_rows(const sd_model *m) {
  return (rows){rows_of(m, offsetof(sd_phase, series_every)),
                rows_of(m, offsetof(sd_phase, frames_every)),
                rows_of(m, offsetof(sd_phase, contacts_every))};
}

/* Returns the stored bytes of one row of a table. If the table is compressed, reals count with the
 * factor `left`, and integers count as 0. */
static double row_bytes(const table *t, double left) {
  double bytes = 0;
  for (size_t k = 0; k < t->n_columns; k++) {
    const table_column *c = &t->columns[k];
    double plain = (double)(c->width * sd_type_size(c->type));
    bytes += !t->compress ? plain : c->type == SD_F64 ? left * plain : 0;
  }
  return bytes;
}

/* Returns the bytes of the state with `contacts` contacts, and of the means of every disk, which
 * are computed from it. */
static double stored_bytes(const sd_model *m, size_t contacts) {
  const size_t means = m->measure_disks ? m->n_free : 0;
  return state_bytes(m, contacts) + (double)(means * disk_observables.n * sizeof(double));
}

static double result_bytes(const sd_model *m, const record *r, const rows *n) {
  size_t contacts = most_contacts(m);
  const char *const texts[] = {sd_model_deck(m)->text, sd_model_deck(m)->full,
                               sd_model_deck(m)->bodies};
  double bytes =
      FILE_BYTES + (m->n_walls ? WALLS_BYTES : 0) + BODY_BYTES * (double)sd_model_bodies(m);
  for (size_t k = 0; k < sizeof texts / sizeof *texts; k++)
    bytes += texts[k] ? (double)strlen(texts[k]) : 0;
  bytes += stored_bytes(m, contacts) + (double)n->series * row_bytes(&r->series, 1);
  bytes +=
      (double)n->frames * (row_bytes(&r->disks, NOISE_LEFT) + row_bytes(&r->clumps, NOISE_LEFT));
  /* Walls are not counted in frames: they move regularly or not at all, which compresses well. */
  bytes += (double)n->contacts * (row_bytes(&r->contact_index, 1) +
                                  (double)contacts * row_bytes(&r->contact_rows, FORCE_LEFT));
  return bytes;
}

/* Constants of the memory estimate in bytes, measured with gases and packings of 1e4 to 1e6 disks.
 * PROGRAM_BYTES: libraries and buffers. WORK_BYTES: per disk, for lists, forces, one frame and one
 * contact table. ROWS_TWICE: per byte of sampled rows that are not yet written; more than 1,
 * because these rows are in memory twice while their file is being written. */
static const double PROGRAM_BYTES = 25e6, WORK_BYTES = 600, ROWS_TWICE = 1.85;

double size_memory(const sd_model *m) {
  return stored_bytes(m, most_contacts(m)) + (WORK_BYTES + sizeof(sd_disk)) * (double)m->n_disks;
}

/* Returns the memory in bytes of the rows that are kept until the next part file or checkpoint is
 * written. The first and the last frame and contact table, which every run has, are not counted. */
static double unsaved_bytes(const sd_model *m, const record *r, const rows *n) {
  const double tables = (double)most_contacts(m) * row_bytes(&r->contact_rows, 1);
  const double disk_rows = row_bytes(&r->disks, 1) + row_bytes(&r->clumps, 1);
  const double all = (double)n->series * row_bytes(&r->series, 1) +
                     (double)(n->frames - 2) * disk_rows + (double)(n->contacts - 2) * tables;
  return ROWS_TWICE * fmin(all, SESSION_ROWS_BYTES);
}

const char *size_text(double bytes, char *text, size_t size) {
  if (bytes < 999.5e3)
    snprintf(text, size, "%.3g kB", bytes / 1e3);
  else if (bytes < 999.5e6)
    snprintf(text, size, "%.3g MB", bytes / 1e6);
  else
    snprintf(text, size, "%.4g GB", bytes / 1e9);
  return text;
}

void size_find(result_size *size, const sd_model *m) {
  record r;
  const rows n = count_rows(m);
  record_new(&r, m, RECORD_WHOLE);
  *size = (result_size){.most_contacts = most_contacts(m),
                        .at_most = m->until.asked,
                        .series = n.series,
                        .frames = n.frames,
                        .contacts = n.contacts,
                        .bytes = result_bytes(m, &r, &n),
                        .unsaved = unsaved_bytes(m, &r, &n)};
  for (size_t k = 0; k < m->n_phases; k++) size->at_most |= m->phases[k].settle.asked;
  size->memory = PROGRAM_BYTES + size_memory(m) + size->unsaved;
  record_free(&r);
}

sd_status size_refuse(const sd_model *m, const result_size *size, sd_messages *messages) {
  const double limit = memory_limit(1);
  char need[40], there[40];
  if (state_refuse(m, messages) != SD_OK) return SD_ERROR_IO;
  if (size->memory > limit)
    sd_warn(messages,
            "the run needs about %s of memory, and this process can have %s: it may be killed "
            "before it ends",
            size_text(size->memory, need, sizeof need), size_text(limit, there, sizeof there));
  return SD_OK;
}

/* Size of a result in bytes above which it is probably larger than intended. */
static const double LARGE = 50e9;

void size_warn(const result_size *size, const char *folder, sd_messages *messages) {
  struct statvfs disk;
  char bytes[40], room[40],
      *amount = format_text("%" PRId64 " rows of the series, %" PRId64 " frames, %" PRId64
                            " contact tables",
                            size->series, size->frames, size->contacts);
  double free_bytes =
      statvfs(folder, &disk) == 0 ? (double)disk.f_bavail * (double)disk.f_frsize : HUGE_VAL;
  const char *most = size->at_most ? "up to " : "";
  size_text(size->bytes, bytes, sizeof bytes);
  if (2 * size->bytes > free_bytes)
    sd_warn(messages,
            "the result will have %sabout %s (%s), and needs twice that while it is put together; "
            "the disk has "
            "room for %s",
            most, bytes, amount, size_text(free_bytes, room, sizeof room));
  else if (size->bytes > LARGE)
    sd_warn(messages, "the result will have %sabout %s (%s); are so few steps between them meant?",
            most, bytes, amount);
  free(amount);
}

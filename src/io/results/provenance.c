/* provenance.c: fills, writes and reads the origin of a result; see provenance.h. */
#include "io/results/provenance.h"
#include "slipdisk/deck.h"

#include <fcntl.h>
#include <gsl/gsl_version.h>
#include <pwd.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/hash.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/store/file.h"
#include "io/store/members.h"
#include "model/rows.h"
#include "version.h"

#define TEXT(name)                                                                                 \
  { #name, offsetof(provenance, name) }

const provenance_text provenance_texts[] = {
    TEXT(title),    TEXT(run_id),   TEXT(deck_path), TEXT(directory), TEXT(version),
    TEXT(revision), TEXT(compiler), TEXT(hdf5),      TEXT(gsl),       TEXT(libconfig),
    TEXT(cpu_path), TEXT(author),   TEXT(host),      TEXT(started),   TEXT(ended),
};
const size_t provenance_text_count = sizeof provenance_texts / sizeof *provenance_texts;

static const observable numbers[] = {
    OBSERVABLE_FIELD("threads", "1", "threads (of each MPI rank)", I64, provenance, threads, NULL,
                     NULL),
    OBSERVABLE_FIELD("ranks", "1", "MPI ranks; 0: by a program older than 0.5", I64, provenance,
                     ranks, NULL, NULL),
    OBSERVABLE_FIELD("sessions", "1", "times the run was started or continued", I64, provenance,
                     sessions, NULL, NULL),
    OBSERVABLE_FIELD("wall_seconds", "s", "wall time of all sessions", F64, provenance,
                     wall_seconds, NULL, NULL),
    OBSERVABLE_FIELD("step_seconds", "s", "wall time spent on steps", F64, provenance, step_seconds,
                     NULL, NULL),
};
const observable_list provenance_observables =
    OBSERVABLES("parameters", "attributes of /parameters, beside texts, seed and inputs", numbers);

/* Texts of the deck are stored as datasets, since they may be longer than an attribute can be (64
 * KiB). */
static const provenance_text decks[] = {TEXT(deck_text), TEXT(deck_overrides), TEXT(deck_full),
                                        TEXT(deck_bodies)};
enum { DECKS = sizeof decks / sizeof *decks };

/* Returns the address of the member (a text, char *) of *p at this offset. */
static char **place(const provenance *p, size_t offset) {
  return (char **)(void *)((char *)(uintptr_t)p + offset);
}

const char *provenance_get(const provenance *p, size_t k) {
  const char *text = *place(p, provenance_texts[k].offset);
  return text ? text : "";
}

/* Frees *at and sets it to a copy of the text; NULL counts as "". */
static void set(char **at, const char *text) {
  char *copy = memory_text(text ? text : "");
  free(*at);
  *at = copy;
}

/* Writes the present time, in UTC and ISO 8601 format, into `text`. */
static void now(char *text, size_t size) {
  time_t t = time(NULL);
  struct tm utc;
  gmtime_r(&t, &utc);
  strftime(text, size, "%Y-%m-%dT%H:%M:%SZ", &utc);
}

/* Makes a run identifier of 128 random bits, or of clock and process number if /dev/urandom cannot
 * be read. */
static void make_run_id(char text[33]) {
  uint64_t bits[2] = {0, 0};
  int fd = open("/dev/urandom", O_RDONLY | O_CLOEXEC);
  ssize_t got = fd < 0 ? 0 : read(fd, bits, sizeof bits);
  if (fd >= 0) close(fd);
  if (got != (ssize_t)sizeof bits) {
    struct timespec t;
    clock_gettime(CLOCK_REALTIME, &t);
    bits[0] = (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
    bits[1] = (uint64_t)getpid();
  }
  snprintf(text, 33, "%016llx%016llx", (unsigned long long)bits[0], (unsigned long long)bits[1]);
}

/* Finds the name of the author: environment variable SLIPDISK_AUTHOR, else full name or login name
 * of the account. "unknown" for root and system accounts, which do not belong to a person. */
static void author_of(char *text, size_t size) {
  enum { FIRST_PERSON = 1000 };
  struct passwd entry, *found = NULL;
  char buffer[2048];
  const char *given = getenv("SLIPDISK_AUTHOR");
  snprintf(text, size, "%s", given && *given ? given : "unknown");
  text_clean(text)[strcspn(text, "\n\t")] = 0;
  if ((given && *given) || getuid() < FIRST_PERSON) return;
  if (getpwuid_r(getuid(), &entry, buffer, sizeof buffer, &found) != 0 || !found) return;
  int length = found->pw_gecos ? (int)strcspn(found->pw_gecos, ",") : 0;
  if (length > 0)
    snprintf(text, size, "%.*s", length, found->pw_gecos);
  else if (found->pw_name && *found->pw_name)
    snprintf(text, size, "%s", found->pw_name);
}

/* Returns the checksum `sum` continued over the contacts taken from a packing file, and over the
 * walls, whose positions then come from that file. */
static uint64_t sum_packing(uint64_t sum, const sd_model *model) {
  /* contacts of a large packing file have a checksum of their own */
  const bool large = model->tiles.n_contacts > 0;
  if (large)
    sum = hash_words(sum, &model->tiles.contact_inputs, sizeof model->tiles.contact_inputs);
  for (size_t k = 0; !large && k < model->n_memories; k++) {
    const sd_contact_memory *c = &model->memories[k];
    const uint32_t body[] = {c->a, c->b, c->part, (uint32_t)c->slide};
    sum = hash_words(hash_words(sum, body, sizeof body), &c->side, sizeof c->side);
    sum = hash_words(sum, &c->record, sizeof c->record);
  }
  for (size_t k = 0; (large || model->n_memories) && k < model->n_walls; k++) {
    const sd_wall *w = &model->walls[k];
    sum = hash_words(hash_words(sum, w->pivot, sizeof w->pivot), &w->radius, sizeof w->radius);
    if (w->n_points) sum = hash_words(sum, w->points, w->n_points * sizeof *w->points);
  }
  return sum;
}

int64_t provenance_inputs(const sd_model *model) {
  uint64_t sum = HASH_WORDS;
  if (model->parted) return model->inputs;
  /* Disks of a packing generated in tiles (rectangles of the region) follow from the deck's text,
   * and a large packing file has a checksum of its own, so the disks of tiles are skipped below. */
  const sd_tiles *t = &model->tiles;
  if (t->inputs != 0) sum = hash_words(sum, &t->inputs, sizeof t->inputs);
  for (size_t k = 0; k < model_held(model); k++) {
    if (k >= t->first && k < t->first + t->count) continue;
    const sd_disk *d = &model->disks[k];
    const double real[] = {d->radius, d->mass, d->inertia, d->force[0], d->force[1], d->force[2]};
    const int32_t whole[] = {d->material,  d->group,     d->locked[0],
                             d->locked[1], d->locked[2], d->driven};
    sum = hash_words(hash_words(sum, real, sizeof real), whole, sizeof whole);
  }
  for (size_t k = 0; k < model->n_motions; k++) {
    const sd_motion *m = &model->motions[k];
    if (!m->n_table) continue;
    sum = hash_words(sum, m->table_time, m->n_table * sizeof *m->table_time);
    sum = hash_words(sum, m->table_value, m->n_table * sizeof *m->table_value);
  }
  return (sum = sum_packing(sum, model)) ? (int64_t)sum : 1;
}

void provenance_new(provenance *p, const sd_model *model) {
  *p = (provenance){.seed = (int64_t)model->seed, .inputs = provenance_inputs(model)};
  char id[33], time[32], author[256], directory[4096];
  make_run_id(id);
  now(time, sizeof time);
  author_of(author, sizeof author);
  if (!getcwd(directory, sizeof directory)) directory[0] = 0;
  const struct {
    char **at;
    const char *text;
  } texts[] = {{&p->run_id, id},
               {&p->started, time},
               {&p->author, author},
               {&p->directory, directory},
               {&p->title, model->title},
               {&p->deck_path, sd_model_deck(model)->path},
               {&p->deck_text, sd_model_deck(model)->text},
               {&p->deck_overrides, sd_model_deck(model)->overrides},
               {&p->deck_full, sd_model_deck(model)->full},
               {&p->deck_bodies, sd_model_deck(model)->bodies}};
  for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) set(texts[k].at, texts[k].text);
}

void provenance_refresh(provenance *p, int ranks, int threads, const char *cpu_path) {
  char host[256] = "unknown", time[32], hdf5[32];
  gethostname(host, sizeof host - 1);
  now(time, sizeof time);
  p->threads = threads;
  p->ranks = ranks;
  const struct {
    char **at;
    const char *text;
  } texts[] = {{&p->host, host},
               {&p->ended, time},
               {&p->version, SD_VERSION},
               {&p->revision, SD_GIT_REVISION},
               {&p->compiler, SD_COMPILER},
               {&p->hdf5, h5_version(hdf5, sizeof hdf5)},
               {&p->gsl, GSL_VERSION},
               {&p->libconfig, SD_LIBCONFIG_VERSION},
               {&p->cpu_path, cpu_path}};
  for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) set(texts[k].at, texts[k].text);
}

char *provenance_deck(const char *deck, const char *directory) {
  char *there = directory && *directory ? format_text("%s/%s", directory, deck) : NULL;
  if (there && *deck && *deck != '/' && !file_exists(deck) && file_exists(there)) return there;
  free(there);
  return memory_text(deck);
}

void provenance_free(provenance *p) {
  for (size_t k = 0; k < provenance_text_count; k++) free(*place(p, provenance_texts[k].offset));
  for (size_t k = 0; k < DECKS; k++) free(*place(p, decks[k].offset));
  *p = (provenance){0};
}

void provenance_write(const provenance *p, h5_file *file) {
  static const int64_t h5md[2] = {1, 1};
  h5_group(file, "/h5md/author");
  h5_group(file, "/h5md/creator");
  h5_attr(file, "/h5md", "version", SD_I64, 2, h5md);
  h5_attr_text(file, "/h5md/author", "name", p->author);
  h5_attr_text(file, "/h5md/creator", "name", "slipdisk");
  h5_attr_text(file, "/h5md/creator", "version", p->version);

  h5_group(file, "/parameters");
  for (size_t k = 0; k < provenance_text_count; k++)
    h5_attr_text(file, "/parameters", provenance_texts[k].name, provenance_get(p, k));
  for (size_t k = 0; k < DECKS; k++) {
    char *path = format_text("/parameters/%s", decks[k].name);
    h5_put_text(file, path, *place(p, decks[k].offset));
    free(path);
  }
  h5_attr_i64(file, "/parameters", "seed", p->seed);
  h5_attr_i64(file, "/parameters", "inputs", p->inputs);
  members_write_attrs(file, "/parameters", &provenance_observables, p);
}

void provenance_read(provenance *p, const h5_file *file) {
  *p = (provenance){0};
  for (size_t k = 0; k < provenance_text_count; k++) {
    char *text = h5_get_attr_text(file, "/parameters", provenance_texts[k].name);
    set(place(p, provenance_texts[k].offset), text);
    free(text);
  }
  for (size_t k = 0; k < DECKS; k++) {
    char *path = format_text("/parameters/%s", decks[k].name);
    char *text = h5_get_text(file, path);
    set(place(p, decks[k].offset), text);
    free(text);
    free(path);
  }
  p->seed = h5_get_attr_i64(file, "/parameters", "seed", 0);
  p->inputs = h5_get_attr_i64(file, "/parameters", "inputs", 0);
  members_read_attrs(file, "/parameters", &provenance_observables, p);
}

/* model.c: functions that build a model and read it. Errors of the building functions are kept
 * until sd_model_finish reports them. See slipdisk/model.h. */
#include "model/model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/math.h"
#include "base/memory.h"
#include "base/text.h"
#include "model/walls.h"
#include "model/field_kinds.h"
#include "model/keys.h"
#include "model/motions.h"
#include "model/normal_laws.h"
#include "model/rows.h"
#include "slipdisk/deck.h"

sd_model *sd_model_new(void) {
  sd_model *m = memory_new(1, sizeof *m);
  deck_key_defaults(&deck_top, m);
  deck_key_defaults(&deck_measure, m);
  deck_key_defaults(&deck_limits, &m->limits);
  return m;
}

const sd_deck *sd_model_deck(const sd_model *m) {
  static char none[] = "";
  static const sd_deck by_hand = {none, none, none, none, none, 60.0, 0};
  return m->deck ? m->deck : &by_hand;
}

size_t sd_model_disks(const sd_model *m) { return m->n_disks; }
size_t sd_model_walls(const sd_model *m) { return m->n_walls; }
double sd_model_dt(const sd_model *m) { return m->dt; }

uint32_t sd_model_find(const sd_model *m, const char *name) {
  for (size_t k = 0; k < model_known(m); k++) {
    const uint32_t disk = model_known_disk(m, k);
    if (m->disks[disk].name && strcmp(m->disks[disk].name, name) == 0) return disk;
  }
  for (size_t k = 0; k < m->n_walls; k++)
    if (m->walls[k].name && strcmp(m->walls[k].name, name) == 0) return (uint32_t)(m->n_disks + k);
  for (size_t k = 0; k < m->n_clumps; k++)
    if (m->clumps[k].name && strcmp(m->clumps[k].name, name) == 0)
      return (uint32_t)(sd_model_bodies(m) + k);
  return UINT32_MAX;
}

const sd_disk *sd_model_disk(const sd_model *m, uint32_t number) {
  return number < m->n_disks ? &m->disks[number] : NULL;
}

size_t sd_model_bodies(const sd_model *m) { return m->n_disks + m->n_walls; }

const sd_contact_law *sd_model_law(const sd_model *m, int a, int b) {
  if (a < 0 || b < 0 || (size_t)a >= m->n_materials || (size_t)b >= m->n_materials) return NULL;
  return &m->laws[(size_t)a * m->n_materials + (size_t)b];
}

const char *sd_model_body_name(const sd_model *m, uint32_t body, char *text, size_t size) {
  const size_t bodies = sd_model_bodies(m);
  const bool disk = body < m->n_disks, wall = !disk && body < bodies,
             exists = body < model_movables(m);
  const char *kind = disk ? "disk" : wall ? "wall" : "clump";
  const size_t number = disk ? body : wall ? body - m->n_disks : body - bodies;
  const char *name = disk     ? (m->parted || number < model_held(m) ? m->disks[number].name : NULL)
                     : wall   ? m->walls[number].name
                     : exists ? m->clumps[number].name
                              : NULL;
  if (!exists)
    snprintf(text, size, "body %u, which does not exist", body);
  else if (name)
    snprintf(text, size, "%s \"%s\"", kind, name);
  else
    snprintf(text, size, "%s %zu", kind, number);
  return text;
}

const char *model_motion_name(const sd_model *m, size_t number, char *text, size_t size) {
  const char *name = m->motions[number].name;
  if (name)
    snprintf(text, size, "motion \"%s\"", name);
  else
    snprintf(text, size, "motion %zu", number);
  return text;
}

subject about_body(const sd_model *m, size_t body) {
  char text[96];
  sd_model_body_name(m, (uint32_t)body, text, sizeof text);
  return (subject){.kind = SUBJECT_BODY, .number = body, .name = memory_text(text)};
}

subject about_wall(const sd_model *m, size_t wall) { return about_body(m, m->n_disks + wall); }

subject about_motion(const sd_model *m, size_t motion) {
  char text[96];
  model_motion_name(m, motion, text, sizeof text);
  return (subject){.kind = SUBJECT_MOTION, .number = motion, .name = memory_text(text)};
}

int64_t sd_model_steps(const sd_model *m) {
  int64_t steps = 0;
  for (size_t k = 0; k < m->n_phases; k++) steps += m->phases[k].steps;
  return steps;
}

/* Number of steps of a phase without an end. */
static const int64_t ENDLESS = INT64_MAX / 4;
/* Placeholder for the number of a random stream: the motion gets a stream of its own when the
 * model is finished. */
static const uint32_t OWN_STREAM = UINT32_MAX;

/* Returns the list of errors made in calls that build the model; creates it if there is none. */
static sd_messages *mistakes(sd_model *m) {
  if (!m->mistakes) m->mistakes = sd_messages_new();
  return m->mistakes;
}

/* Resizes a short list of the model to n elements and returns its new address; if there is no
 * memory the process ends. */
static void *grow(sd_model *m, void *list, size_t n, size_t size) {
  m->finished = false;
  return memory_grow(list, n, size);
}

/* Resizes the array whose address is at `list` to n rows. False: out of memory; this is noted in
 * the model as an error. what: name of the array in the message. */
static bool grow_rows(sd_model *m, void *list, size_t n, size_t size, const char *what) {
  m->finished = false;
  const bool enough = memory_resize_row(list, n, size);
  if (!enough) sd_fail(mistakes(m), SD_ERROR_IO, "out of memory for %s", what);
  return enough;
}

/* Stores the address of a copy of n elements in *copy, NULL if there are none. False: `from` is
 * NULL although n > 0, or out of memory; both are noted in the model as errors. */
static bool copy_of(sd_model *m, const void *from, size_t n, size_t size, void *copy,
                    const char *what) {
  void *to = NULL;
  if (!from && n)
    sd_fail(mistakes(m), SD_ERROR_USER, "%s: expected %zu elements, not NULL", what, n);
  if (from && n && grow_rows(m, &to, n, size, what)) memcpy(to, from, n * size);
  memcpy(copy, &to, sizeof to);
  return to || !n;
}

/* --- keys ------------------------------------------------------------------------------------- */

/* Returns the table row of the deck key with the name `path` and, in *members, the struct whose
 * member it sets. NULL: no such key; this is noted in the model as an error. */
static const deck_key *key_of(sd_model *m, const char *path, void **members) {
  m->finished = false;
  const struct {
    const char *group;
    const deck_table *table;
    void *members;
  } tables[] = {{"", &deck_top, m},
                {"limits.", &deck_limits, &m->limits},
                {"measure.", &deck_measure, m},
                {"bounds.", &deck_bounds, &m->bounds}};
  guess near = guess_start(path);
  char names[64][48];
  size_t n = 0;
  for (size_t t = 0; t < COUNT(tables); t++) {
    const deck_key *key;
    for (size_t k = 0; (key = deck_key_at(tables[t].table, k)); k++) {
      if (key->target == DECK_SETS_NOTHING || key->target == DECK_SETS_PAIR || n == COUNT(names))
        continue;
      snprintf(names[n], sizeof names[n], "%s%s", tables[t].group, key->name);
      if (strcmp(names[n], path) == 0) {
        *members = tables[t].members;
        return key;
      }
      guess_add(&near, names[n++]);
    }
  }
  sd_fail(mistakes(m), SD_ERROR_USER, "%s: no key that a model has%s%s%s", path,
          near.best ? " (did you mean " : "", near.best ? near.best : "", near.best ? "?)" : "");
  return NULL;
}

void sd_model_set(sd_model *m, const char *path, double value) {
  void *members;
  const deck_key *key = key_of(m, path, &members);
  if (!key) return;
  if (key->target == DECK_SETS_TEXT || key->target == DECK_SETS_ENUM)
    sd_fail(mistakes(m), SD_ERROR_USER, "%s = %g: expected a text", path, value);
  else if (!deck_key_store(key, members, key->target == DECK_SETS_OFF ? value == 0.0 : value))
    sd_fail(mistakes(m), SD_ERROR_USER, "%s = %.17g: expected a whole number", path, value);
}

void sd_model_set_text(sd_model *m, const char *path, const char *value) {
  void *members;
  const deck_key *key = key_of(m, path, &members);
  if (!key) return;
  void *at = (char *)members + key->offset;
  if (key->target == DECK_SETS_TEXT) {
    free(*(char **)at);
    *(char **)at = memory_text(value);
    return;
  }
  if (key->target != DECK_SETS_ENUM) {
    sd_fail(mistakes(m), SD_ERROR_USER, "%s = \"%s\": expected a number", path, value);
    return;
  }
  for (const deck_shape *word = key->words; word->name; word++)
    if (strcmp(word->name, value) == 0) {
      *(int *)at = word->kind;
      return;
    }
  char words[256] = "";
  for (const deck_shape *word = key->words; word->name; word++)
    snprintf(words + strlen(words), sizeof words - strlen(words), "%s\"%s\"", *words ? ", " : "",
             word->name);
  sd_fail(mistakes(m), SD_ERROR_USER, "%s = \"%s\": expected one of %s", path, value, words);
}

void sd_model_set_gravity(sd_model *m, double x, double y) {
  m->finished = false;
  if (!(fabs(x) <= LIMIT_NUMBER) || !(fabs(y) <= LIMIT_NUMBER))
    sd_fail(mistakes(m), SD_ERROR_USER, "gravity (%g, %g): expected finite numbers, at most 1e100",
            x, y);
  m->gravity[SD_X] = x;
  m->gravity[SD_Y] = y;
}

/* True if both edges are finite and lower < upper; if not, an error is noted in the model. */
static bool has_extent(sd_model *m, const char *what, double lower, double upper) {
  if (upper > lower && fabs(upper) <= LIMIT_NUMBER && fabs(lower) <= LIMIT_NUMBER) return true;
  sd_fail(mistakes(m), SD_ERROR_USER,
          "%s from %g to %g: expected finite edges, the lower one first", what, lower, upper);
  return false;
}

void sd_model_set_periodic(sd_model *m, int c, double lower, double upper) {
  if (c != SD_X && c != SD_Y) {
    sd_fail(mistakes(m), SD_ERROR_USER, "periodic coordinate %d: expected SD_X or SD_Y", c);
    return;
  }
  m->finished = false;
  if (!has_extent(m, "periodic box", lower, upper)) return;
  m->periodic[c] = true;
  m->lower[c] = m->region_lower[c] = lower;
  m->upper[c] = m->region_upper[c] = upper;
}

void sd_model_set_region(sd_model *m, const double lower[2], const double upper[2]) {
  m->finished = false;
  for (int c = 0; c < 2; c++)
    if (has_extent(m, "region", lower[c], upper[c]) && !m->periodic[c]) {
      m->region_lower[c] = lower[c];
      m->region_upper[c] = upper[c];
    }
}

void sd_model_set_bounds(sd_model *m, const double lower[2], const double upper[2]) {
  m->finished = false;
  m->bounds.given = true;
  for (int c = 0; c < 2; c++) {
    m->bounds.lower[c] = lower[c];
    m->bounds.upper[c] = upper[c];
  }
}

/* --- materials -------------------------------------------------------------------------------- */

int sd_model_add_material(sd_model *m, const char *name, const sd_contact_law *law) {
  const size_t n = m->n_materials;
  m->materials = grow(m, m->materials, n + 1, sizeof *m->materials);
  sd_contact_law *laws = memory_new((n + 1) * (n + 1), sizeof *laws);
  for (size_t a = 0; a < n; a++) memcpy(laws + a * (n + 1), m->laws + a * n, n * sizeof *laws);
  free(m->laws);
  m->laws = laws;
  m->materials[n] = (sd_material){.name = memory_text(name)};
  m->n_materials++;
  if (law) sd_model_set_law(m, (int)n, (int)n, law);
  return (int)n;
}

void sd_model_set_law(sd_model *m, int a, int b, const sd_contact_law *law) {
  const int n = (int)m->n_materials;
  m->finished = false;
  if (a < 0 || b < 0 || a >= n || b >= n) {
    sd_fail(mistakes(m), SD_ERROR_USER,
            "law of materials %d and %d: expected two of the %d that there are", a, b, n);
    return;
  }
  if (!law) {
    sd_fail(mistakes(m), SD_ERROR_USER, "law of materials %d and %d: expected a law, not NULL", a,
            b);
    return;
  }
  sd_contact_law own = *law;
  law_complete(&own);
  if (!(own.k_n > 0.0))
    sd_fail(mistakes(m), SD_ERROR_USER,
            "law of materials %d and %d: k_n = %g: expected a number > 0", a, b, own.k_n);
  if ((unsigned)law->normal >= SD_NORMAL_LAWS) {
    sd_fail(mistakes(m), SD_ERROR_USER,
            "law of materials %d and %d: normal = %d: expected a normal law", a, b,
            (int)law->normal);
    return;
  }
  m->laws[a * n + b] = m->laws[b * n + a] = own;
}

/* --- bodies ----------------------------------------------------------------------------------- */

/* Copies a disk and its name; group and clump are set to none. */
static void put_disk(sd_disk *to, const sd_disk *from) {
  const char *name = memory_text(from->name);
  *to = *from;
  to->name = name;
  to->group = -1;
  to->clump = 0;
}

uint32_t sd_model_add_disks(sd_model *m, size_t n, const sd_disk *disks) {
  const size_t first = m->n_disks;
  if (n == 0) return (uint32_t)first;
  if (!disks || n > LIMIT_DISKS - first) {
    sd_fail(mistakes(m), SD_ERROR_USER, "%zu disks%s: expected at most %d", n,
            disks ? "" : ", NULL", LIMIT_DISKS);
    return (uint32_t)first;
  }
  if (!grow_rows(m, &m->disks, first + n, sizeof *m->disks, "disks")) return (uint32_t)first;
  for (size_t k = 0; k < n; k++) put_disk(&m->disks[first + k], &disks[k]);
  m->n_disks += n;
  return (uint32_t)first;
}

uint32_t sd_model_add_disk(sd_model *m, const sd_disk *disk) {
  return sd_model_add_disks(m, 1, disk);
}

void sd_model_set_disk(sd_model *m, uint32_t number, const sd_disk *disk) {
  if (number >= m->n_disks) {
    sd_fail(mistakes(m), SD_ERROR_USER, "disk %u: expected one of the %zu that there are", number,
            m->n_disks);
    return;
  }
  m->finished = false;
  sd_disk *at = &m->disks[number], old = *at;
  put_disk(at, disk);
  at->group = old.group;
  at->clump = old.clump;
  free((char *)old.name);
}

int sd_model_add_group(sd_model *m, const char *name, size_t n, const uint32_t *disks) {
  const size_t group = m->n_groups;
  m->groups = grow(m, m->groups, group + 1, sizeof *m->groups);
  m->groups[m->n_groups++] = memory_text(name);
  for (size_t k = 0; k < n; k++)
    if (disks[k] < m->n_disks)
      m->disks[disks[k]].group = (int)group;
    else
      sd_fail(mistakes(m), SD_ERROR_USER, "group \"%s\": disk %u does not exist", name ? name : "?",
              disks[k]);
  return (int)group;
}

uint32_t sd_model_add_wall(sd_model *m, const sd_wall *wall) {
  const uint32_t number = SD_WALL(m->n_walls);
  m->walls = grow(m, m->walls, m->n_walls + 1, sizeof *m->walls);
  sd_wall *to = &m->walls[m->n_walls++];
  *to = *wall;
  to->name = memory_text(wall->name);
  if (!copy_of(m, wall->points, wall->n_points, sizeof *wall->points, &to->points, "a wall"))
    to->n_points = 0;
  if (wall->kind != SD_WALL_ARC) return number;
  to->points = grow(m, to->points, ARC_POINTS, sizeof *to->points);
  arc_trace(to);
  return number;
}

uint32_t sd_model_add_clump(sd_model *m, const sd_clump *clump) {
  const uint32_t number = SD_CLUMP(m->n_clumps);
  if (!grow_rows(m, &m->clumps, m->n_clumps + 1, sizeof *m->clumps, "clumps")) return number;
  sd_clump *to = &m->clumps[m->n_clumps++];
  *to = *clump;
  to->disks = NULL;
  to->name = memory_text(clump->name);
  const char *name = clump->name ? clump->name : "?";
  for (size_t k = 0; k < clump->n_disks; k++)
    if (clump->disks[k] >= m->n_disks)
      sd_fail(mistakes(m), SD_ERROR_USER, "clump \"%s\": disk %u does not exist", name,
              clump->disks[k]);
    else if (m->disks[clump->disks[k]].clump)
      sd_fail(mistakes(m), SD_ERROR_USER, "clump \"%s\": disk %u belongs to a clump already", name,
              clump->disks[k]);
    else
      m->disks[clump->disks[k]].clump = (int)m->n_clumps;
  return number;
}

/* --- motions and phases ----------------------------------------------------------------------- */

/* Grows a phase's list of on/off flags (of motions or fields) to n flags, and sets the flags
 * from index `from` on. */
static void activate(sd_model *m, bool **list, size_t from, size_t n, bool on) {
  *list = grow(m, *list, n, sizeof **list);
  for (size_t k = from; k < n; k++) (*list)[k] = on;
}

int sd_model_add_motion(sd_model *m, const sd_motion *motion) {
  const int number = (int)m->n_motions;
  if ((unsigned)motion->kind >= SD_MOTION_KINDS || (unsigned)motion->coordinate >= SD_MOVED) {
    sd_fail(mistakes(m), SD_ERROR_USER,
            "motion \"%s\": kind %d, coordinate %d: expected SD_MOTION_..., SD_X ...",
            motion->name ? motion->name : "?", (int)motion->kind, motion->coordinate);
    return number;
  }
  m->motions = grow(m, m->motions, m->n_motions + 1, sizeof *m->motions);
  sd_motion *to = &m->motions[m->n_motions++];
  *to = *motion;
  to->name = memory_text(motion->name);
  if (!copy_of(m, motion->bodies, motion->n_bodies, sizeof *motion->bodies, &to->bodies,
               "a motion"))
    to->n_bodies = 0;
  if (!copy_of(m, motion->table_time, motion->n_table, sizeof(double), &to->table_time,
               "a motion") ||
      !copy_of(m, motion->table_value, motion->n_table, sizeof(double), &to->table_value,
               "a motion"))
    to->n_table = 0;
  if (motion->kind == SD_MOTION_RANDOM && motion->stream == 0) to->stream = OWN_STREAM;
  /* the new motion is off in earlier phases that have a list of their motions */
  for (size_t k = 0; k < m->n_phases; k++)
    if (m->phases[k].active)
      activate(m, &m->phases[k].active, m->n_motions - 1, m->n_motions, false);
  return number;
}

int sd_model_add_field(sd_model *m, const sd_body_force *field) {
  const int number = (int)m->n_fields;
  if ((unsigned)field->kind >= SD_FIELD_KINDS || (unsigned)field->per > SD_FIELD_PER_MASS) {
    sd_fail(mistakes(m), SD_ERROR_USER, "field \"%s\": kind %d, per %d: expected SD_FIELD_...",
            field->name ? field->name : "?", (int)field->kind, (int)field->per);
    return number;
  }
  m->fields = grow(m, m->fields, m->n_fields + 1, sizeof *m->fields);
  sd_body_force *to = &m->fields[m->n_fields++];
  *to = *field;
  to->name = memory_text(field->name);
  if (!copy_of(m, field->disks, field->n_disks, sizeof *field->disks, &to->disks, "a field"))
    to->n_disks = 0;
  for (size_t k = 0; k < m->n_phases; k++)
    if (m->phases[k].fields) activate(m, &m->phases[k].fields, m->n_fields - 1, m->n_fields, false);
  return number;
}

int sd_model_add_phase(sd_model *m, const sd_phase *phase) {
  const int number = (int)m->n_phases;
  m->phases = grow(m, m->phases, m->n_phases + 1, sizeof *m->phases);
  sd_phase *to = &m->phases[m->n_phases++];
  *to = *phase;
  to->name = memory_text(phase->name);
  to->active = m->n_motions > 0 ? memory_copy(phase->active, m->n_motions * sizeof(bool)) : NULL;
  to->fields = m->n_fields > 0 ? memory_copy(phase->fields, m->n_fields * sizeof(bool)) : NULL;
  if (!copy_of(m, phase->hold, phase->n_hold, sizeof *phase->hold, &to->hold, "a phase"))
    to->n_hold = 0;
  if (!copy_of(m, phase->release, phase->n_release, sizeof *phase->release, &to->release,
               "a phase"))
    to->n_release = 0;
  const sd_bonding *bond = &phase->bond;
  if (!copy_of(m, bond->between, bond->n_between, sizeof *bond->between, &to->bond.between,
               "bond.between"))
    to->bond.n_between = 0;
  if (!copy_of(m, bond->pairs, bond->n_pairs, sizeof *bond->pairs, &to->bond.pairs, "bond.pairs"))
    to->bond.n_pairs = 0;
  if (to->steps == 0) to->steps = ENDLESS;
  if (to->settle.asked && to->settle.every == 0) to->settle.every = 1000;
  if (to->compress.asked && to->compress.tolerance == 0.0) to->compress.tolerance = 1e-3;
  return number;
}

void sd_model_measure_rotation(sd_model *m, size_t n, const uint32_t *disks) {
  m->rotations = grow(m, m->rotations, m->n_rotations + n, sizeof *m->rotations);
  memcpy(m->rotations + m->n_rotations, disks, n * sizeof *disks);
  m->n_rotations += n;
}

void sd_model_measure_sliding(sd_model *m, const sd_slide_watch *watch) {
  m->slides = grow(m, m->slides, m->n_slides + 1, sizeof *m->slides);
  m->slides[m->n_slides++] = *watch;
}

void sd_model_set_until(sd_model *m, const sd_until *until) {
  m->finished = false;
  m->until = *until;
  m->until.asked = true;
}

/* --- finishing -------------------------------------------------------------------------------- */

/* Converts SD_WALL(w) and SD_CLUMP(k) to body numbers; other numbers are returned unchanged, for
 * the checks to report. */
static uint32_t body_number(const sd_model *m, uint32_t body) {
  const uint32_t wall = body & ~SD_WALL(0), clump = body & ~SD_CLUMP(0);
  if (!(body & SD_WALL(0)) && body & SD_CLUMP(0))
    return clump < m->n_clumps ? (uint32_t)(sd_model_bodies(m) + clump) : body;
  if (!(body & SD_WALL(0))) return body;
  return wall < m->n_walls ? (uint32_t)m->n_disks + wall : body;
}

/* Sets the random stream of motion k to the number that a deck would give it, which follows from
 * the body that the motion moves, the coordinate, and the number of earlier random motions of
 * the same body and coordinate. */
static void give_stream(sd_model *m, size_t k) {
  sd_motion *q = &m->motions[k];
  if (q->kind != SD_MOTION_RANDOM || q->stream != OWN_STREAM || q->n_bodies == 0) return;
  const bool one = q->n_bodies == 1, disk = q->bodies[0] < m->n_disks;
  const int thing = !one ? STREAM_LIST : disk ? STREAM_DISK : STREAM_WALL;
  const uint32_t index = one && !disk ? q->bodies[0] - (uint32_t)m->n_disks : q->bodies[0];
  unsigned ordinal = 0;
  for (size_t i = 0; i < k; i++)
    ordinal += m->motions[i].kind == SD_MOTION_RANDOM &&
               m->motions[i].stream == stream_number(thing, index, ordinal, q->coordinate);
  if (index >= STREAM_INDICES || ordinal >= STREAM_ORDINALS)
    sd_fail(mistakes(m), SD_ERROR_USER,
            "motion \"%s\": expected at most %d random motions of one coordinate",
            q->name ? q->name : "?", STREAM_ORDINALS);
  else
    q->stream = stream_number(thing, index, ordinal, q->coordinate);
}

int model_by_number(const void *one, const void *two) {
  const uint32_t p = *(const uint32_t *)one, q = *(const uint32_t *)two;
  return p < q ? -1 : p > q;
}

int model_by_pair(const void *one, const void *two) {
  const uint32_t *p = one, *q = two;
  if (p[0] != q[0]) return p[0] < q[0] ? -1 : 1;
  return p[1] < q[1] ? -1 : p[1] > q[1];
}

/* Converts the bodies of a phase's bonds to numbers, sorts them, and leaves out repeated pairs. */
static void complete_bonds(const sd_model *m, sd_bonding *b) {
  uint32_t *between = (uint32_t *)(uintptr_t)b->between;
  uint32_t(*pairs)[2] = (uint32_t(*)[2])(uintptr_t)b->pairs;
  size_t kept = 0;
  for (size_t n = 0; n < b->n_between; n++) between[n] = body_number(m, between[n]);
  if (b->n_between > 1) qsort(between, b->n_between, sizeof *between, model_by_number);
  for (size_t n = 0; n < b->n_pairs; n++) {
    const uint32_t one = body_number(m, pairs[n][0]), two = body_number(m, pairs[n][1]);
    pairs[n][0] = one < two ? one : two;
    pairs[n][1] = one < two ? two : one;
  }
  if (b->n_pairs > 1) qsort(pairs, b->n_pairs, sizeof *pairs, model_by_pair);
  for (size_t n = 0; n < b->n_pairs; n++)
    if (kept == 0 || model_by_pair(pairs[kept - 1], pairs[n]) != 0)
      memmove(pairs[kept++], pairs[n], sizeof *pairs);
  b->n_pairs = kept;
}

void model_complete(sd_model *m) {
  const sd_phase endless = {.name = "run",
                            .measure = m->n_rotations || m->n_slides || m->measure_disks};
  if (m->n_phases == 0) sd_model_add_phase(m, &endless);
  for (size_t k = 0; k < m->n_phases; k++)
    if (!m->phases[k].active) activate(m, &m->phases[k].active, 0, m->n_motions, true);
  for (size_t k = 0; k < m->n_motions; k++) {
    sd_motion *q = &m->motions[k];
    for (size_t b = 0; b < q->n_bodies; b++) q->bodies[b] = body_number(m, q->bodies[b]);
    for (int side = 0; side < 2; side++) q->beside[side] = body_number(m, q->beside[side]);
    give_stream(m, k);
  }
  for (size_t k = 0; k < m->n_phases; k++) complete_bonds(m, &m->phases[k].bond);
  for (size_t k = 0; k < m->n_slides; k++)
    for (int side = 0; side < 2; side++)
      m->slides[k].partner[side] = body_number(m, m->slides[k].partner[side]);
}

sd_status model_tell_mistakes(sd_model *m, sd_messages *messages) {
  const sd_status status = sd_messages_status(m->mistakes);
  messages_append(messages, status, m->mistakes);
  return status;
}

void model_copy_mistakes(sd_model *to, const sd_model *from) {
  if (from->mistakes)
    messages_append(mistakes(to), sd_messages_status(from->mistakes), from->mistakes);
}

/* --- circular arcs: segments, points and distances -------------------------------------------- */

bool arc_is_ring(const sd_wall *w) { return w->to - w->from >= ARC_RING - 1e-9; }

/* Unit vector at an angle; exact at multiples of a quarter turn, where most arcs end and cos and
 * sin would be rounded. */
static void direction(double angle, double d[2]) {
  math_sine_cosine(angle, &d[1], &d[0]);
  for (int c = 0; c < 2; c++)
    if (fabs(d[c]) < 1e-15) {
      d[c] = 0.0;
      d[1 - c] = d[1 - c] > 0.0 ? 1.0 : -1.0;
    }
}

void arc_trace(sd_wall *w) {
  w->n_points = ARC_POINTS;
  for (size_t k = 0; k < ARC_POINTS; k++) {
    double d[2];
    direction(w->from + (w->to - w->from) * (double)k / (ARC_POINTS - 1), d);
    for (int c = 0; c < 2; c++) w->points[k][c] = w->center[c] + w->radius * d[c];
  }
}

/* The three segments of an arc are its first end, its curve and its last end; those of a full
 * circle are three curves, joined to one another. Arc length is measured from the middle of the
 * arc. */
void arc_segments(const sd_wall *w, uint32_t body, sd_segment piece[3], int64_t number) {
  const bool ring = arc_is_ring(w);
  const double opening = ring ? 2.0 * M_PI : w->to - w->from, part = ring ? opening / 3.0 : opening;
  for (int k = 0; k < 3; k++) {
    const double from = w->from + (ring ? k * part : 0.0);
    sd_segment *s = &piece[k];
    *s = (sd_segment){.body = body,
                      .piece = ring || k == 1 ? SD_PIECE_CURVE
                               : k == 0       ? SD_PIECE_FIRST_END
                                              : SD_PIECE_LAST_END,
                      .start = {w->center[0] - w->pivot[0], w->center[1] - w->pivot[1]},
                      .radius = w->radius,
                      .length = ring || k == 1 ? w->radius * part : 0.0,
                      .arc = w->radius * part *
                             (ring     ? k - 1.5
                              : k == 2 ? 0.5
                                       : -0.5),
                      .wide = part > M_PI,
                      .next = k < 2  ? number + k + 1
                              : ring ? number
                                     : -1};
    direction(from, s->first);
    direction(from + part, s->last);
    direction(from + 0.5 * part, s->middle);
  }
  /* neighbouring curves use the same rounded direction of their joint, so that no point lies in
   * both or in neither */
  for (int k = 0; ring && k < 3; k++)
    for (int c = 0; c < 2; c++) piece[k].last[c] = piece[(k + 1) % 3].first[c];
}

double arc_distance(const sd_wall *w, const double at[2]) {
  const double x = at[0] - w->center[0], y = at[1] - w->center[1];
  const double middle = 0.5 * (w->from + w->to), half = 0.5 * (w->to - w->from);
  if (fabs(remainder(math_atan2(y, x) - middle, 2.0 * M_PI)) <= half)
    return fabs(math_hypot(x, y) - w->radius);
  double end[2], nearest = HUGE_VAL;
  for (int k = 0; k < 2; k++) {
    direction(k ? w->to : w->from, end);
    nearest = math_min(nearest, math_hypot(x - w->radius * end[0], y - w->radius * end[1]));
  }
  return nearest;
}

/* image.c: serializes, restores, copies and frees a model; see model.h.
 *
 * Two tables name everything that a model owns: its lists, and the data to which elements of a list
 * point. The serialized model is the struct, then each list, followed by the data of its elements.
 * Pointers, and bytes between members, which may have any value, are stored as zeros.
 */
#include "model/model.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "model/rows.h"
#include "slipdisk/deck.h"

/* Lists of a model: offsets of the pointer and of the number of elements, and bytes of one element.
 * Laws have one element for each pair of materials. */
#define LIST(list, number)                                                                         \
  { offsetof(sd_model, list), offsetof(sd_model, number), sizeof *((sd_model *)NULL)->list }
static const struct list {
  size_t pointer, number, size;
} lists[] = {LIST(materials, n_materials),
             LIST(laws, n_materials),
             LIST(groups, n_groups),
             LIST(disks, n_disks),
             LIST(walls, n_walls),
             LIST(clumps, n_clumps),
             LIST(motions, n_motions),
             LIST(fields, n_fields),
             LIST(phases, n_phases),
             LIST(rains, n_rains),
             LIST(memories, n_memories),
             LIST(derivatives, n_derivatives),
             LIST(tiles.walls, tiles.n_walls),
             LIST(rotations, n_rotations),
             LIST(slides, n_slides),
             LIST(contact_disks, n_contact_disks),
             LIST(averages, n_averages)};
enum { LISTS = sizeof lists / sizeof *lists };

/* Pointers in the elements of a list, with the offset of the number of elements to which each
 * points, and their size. */
#define TEXT(list, pointer)                                                                        \
  { OWNED_TEXT, offsetof(sd_model, list), pointer, 0, 1 }
#define NAME(list, type) TEXT(list, offsetof(type, name))
#define ARRAY(list, type, member, number)                                                          \
  {                                                                                                \
    OWNED_ARRAY, offsetof(sd_model, list), offsetof(type, member), offsetof(type, number),         \
        sizeof *((type *)NULL)->member                                                             \
  }
#define SWITCHES(member, number)                                                                   \
  {                                                                                                \
    OWNED_SWITCHES, offsetof(sd_model, phases), offsetof(sd_phase, member),                        \
        offsetof(sd_model, number), sizeof(bool)                                                   \
  }
static const struct owned {
  enum {
    OWNED_TEXT,
    OWNED_ARRAY,
    OWNED_SWITCHES, /* on/off flags of a phase, one per motion or field; NULL: all are on */
    BORROWED        /* part of another array; model_finish_again sets the pointer */
  } kind;
  size_t list, pointer, number, size;
} owned[] = {NAME(materials, sd_material),
             TEXT(groups, 0),
             NAME(disks, sd_disk),
             NAME(walls, sd_wall),
             ARRAY(walls, sd_wall, points, n_points),
             NAME(clumps, sd_clump),
             {BORROWED, offsetof(sd_model, clumps), offsetof(sd_clump, disks), 0, 0},
             NAME(motions, sd_motion),
             ARRAY(motions, sd_motion, bodies, n_bodies),
             ARRAY(motions, sd_motion, table_time, n_table),
             ARRAY(motions, sd_motion, table_value, n_table),
             NAME(fields, sd_body_force),
             ARRAY(fields, sd_body_force, disks, n_disks),
             NAME(phases, sd_phase),
             SWITCHES(active, n_motions),
             SWITCHES(fields, n_fields),
             ARRAY(phases, sd_phase, hold, n_hold),
             ARRAY(phases, sd_phase, release, n_release),
             ARRAY(phases, sd_phase, bond.between, bond.n_between),
             ARRAY(phases, sd_phase, bond.pairs, bond.n_pairs),
             NAME(averages, sd_average_watch),
             TEXT(averages, offsetof(sd_average_watch, text))};
enum { OWNED = sizeof owned / sizeof *owned };

/* Bytes without a meaning in the elements of a list, or in the model itself: those between two
 * members, or behind the last one. test_model_image compares them with the compiler's. */
#define GAP(list, type, last, next)                                                                \
  {                                                                                                \
    offsetof(sd_model, list), offsetof(type, last) + sizeof((type *)NULL)->last,                   \
        offsetof(type, next), 1                                                                    \
  }
#define END(list, type, last)                                                                      \
  { offsetof(sd_model, list), offsetof(type, last) + sizeof((type *)NULL)->last, sizeof(type), 1 }
#define TERMS(k)                                                                                   \
  {                                                                                                \
    offsetof(sd_model, averages), offsetof(sd_average_watch, of[k].term[0].rate) + sizeof(bool),   \
        offsetof(sd_average_watch, of[k].term[0].factor), SD_AVERAGE_TERMS                         \
  }
#define IN_MODEL(last, next)                                                                       \
  {                                                                                                \
    SIZE_MAX, offsetof(sd_model, last) + sizeof((sd_model *)NULL)->last, offsetof(sd_model, next), \
        1                                                                                          \
  }
static const struct gap {
  size_t list;       /* offset of the pointer to the list; SIZE_MAX: the model itself */
  size_t start, end; /* within an element */
  size_t times;      /* number of such gaps, each a term of an average after the one before */
} gaps[] = {GAP(laws, sd_contact_law, normal, restitution),
            GAP(laws, sd_contact_law, bond_alone, mu_kinetic),
            GAP(laws, sd_contact_law, tangential, gamma_t),
            GAP(laws, sd_contact_law, cohesion, pull_off),
            GAP(disks, sd_disk, waiting, clump),
            GAP(walls, sd_wall, closed, radius),
            GAP(walls, sd_wall, inside, center),
            GAP(clumps, sd_clump, locked, position),
            GAP(motions, sd_motion, stream, n_table),
            END(motions, sd_motion, periodic),
            GAP(fields, sd_body_force, kind, n_disks),
            GAP(fields, sd_body_force, per, centre),
            GAP(phases, sd_phase, measure, series_every),
            GAP(phases, sd_phase, settle.asked, settle.kinetic),
            GAP(phases, sd_phase, relax, compress),
            GAP(phases, sd_phase, compress.asked, compress.pressure),
            GAP(phases, sd_phase, cell.asked, cell.rate),
            GAP(phases, sd_phase, cell.controlled, cell.stress),
            GAP(phases, sd_phase, cell.boundary, n_hold),
            GAP(phases, sd_phase, bond.later, bond.n_between),
            GAP(tiles.walls, sd_tile_wall, known, wall),
            END(tiles.walls, sd_tile_wall, ring),
            TERMS(0),
            TERMS(1),
            IN_MODEL(limits.unstable_step, gravity),
            IN_MODEL(periodic, container),
            IN_MODEL(bounds.given, bounds.lower),
            IN_MODEL(bounds.outside, n_materials),
            IN_MODEL(tiles.of_file, tiles.entry),
            IN_MODEL(tiles.forces_carried, tiles.walls),
            IN_MODEL(tiles.material, n_rains),
            IN_MODEL(forces_carried, n_derivatives),
            IN_MODEL(until.asked, until.least),
            IN_MODEL(until.scaled, until.error),
            IN_MODEL(measure_configurations, measure_every),
            IN_MODEL(parted, n_known),
            IN_MODEL(finished, n_segments)};
enum { GAPS = sizeof gaps / sizeof *gaps };

/* Returns the number, or the pointer, at an offset of a struct. */
static size_t number_at(const void *from, size_t offset) {
  return *(const size_t *)((const char *)from + offset);
}
static char *pointer_at(const void *from, size_t offset) {
  char *pointer;
  memcpy(&pointer, (const char *)from + offset, sizeof pointer);
  return pointer;
}

/* State of a pass over a model that writes it to bytes or reads it back. */
typedef struct image {
  unsigned char *bytes; /* the serialized model: grows when writing, is not changed when reading */
  size_t n, capacity;   /* number of bytes written or read so far; size of `bytes` */
  /* true: writing, false: reading; error: invalid bytes; error: out of memory */
  bool writes, damaged, starved;
  const char *source; /* address of the data written last; their offset in `bytes` */
  size_t offset;
} image;

/* Version of slipdisk and sizes of its structs, stored at the beginning; a program that reads
 * the bytes must have the same. */
static const uint32_t layout[] = {
    SD_VERSION_NUMBER,   sizeof(sd_model),        sizeof(sd_contact_law),
    sizeof(sd_disk),     sizeof(sd_wall),         sizeof(sd_motion),
    sizeof(sd_phase),    sizeof(sd_rain),         sizeof(sd_contact_memory),
    sizeof(sd_material), sizeof(sd_slide_watch),  sizeof(sd_body_force),
    sizeof(sd_clump),    sizeof(sd_average_watch)};

static bool failed(const image *im) { return im->damaged || im->starved; }

/* Copies `size` bytes from `data` to the serialized model when writing, and back when reading. */
static void transfer(image *im, void *data, size_t size) {
  if (failed(im) || size == 0) return;
  if (im->writes && size > im->capacity - im->n) {
    const size_t capacity = 2 * im->capacity + size;
    im->starved = !memory_resize_row(&im->bytes, capacity, 1);
    if (im->starved) return;
    im->capacity = capacity;
  }
  im->damaged = size > im->capacity - im->n;
  if (im->damaged) return;
  if (im->writes) {
    memcpy(im->bytes + im->n, data, size);
    im->source = data;
    im->offset = im->n;
  } else {
    memcpy(data, im->bytes + im->n, size);
  }
  im->n += size;
}

/* Sets bytes to zero, given their address. When writing, only their copy in the serialized model is
 * changed; they must belong to the data written last. */
static void blank(image *im, void *place, size_t size) {
  if (im->writes && !failed(im))
    memset(im->bytes + im->offset + ((const char *)place - im->source), 0, size);
  else if (!im->writes)
    memset(place, 0, size);
}

static void forget(image *im, void *pointer) { blank(im, pointer, sizeof(void *)); }

/* Blanks the gaps of an element of a list, or of the model. */
static void blank_gaps(image *im, size_t list, char *element) {
  for (const struct gap *g = gaps; g < gaps + GAPS; g++)
    for (size_t k = 0; g->list == list && k < g->times; k++)
      blank(im, element + g->start + k * sizeof(sd_average_term), g->end - g->start);
}

/* Allocates n zeroed elements of `size` bytes and stores their address at `place`. Out of
 * memory: sets im->starved. */
static void make_room(image *im, void *place, size_t n, size_t size) {
  im->starved = !memory_row(place, n, size);
}

/* Writes or reads the array of n elements whose address is at `place`; allocates it when
 * reading. */
static void array(image *im, void *place, size_t n, size_t size) {
  void *data = NULL;
  if (!im->writes && !failed(im)) {
    memcpy(place, &data, sizeof data);
    im->damaged = n > (im->capacity - im->n) / size;
    if (!im->damaged) make_room(im, place, n, size);
  }
  if (!failed(im)) memcpy(&data, place, sizeof data);
  transfer(im, data, n * size);
}

/* Writes or reads the string whose address is at `place`. For an array of structs with such
 * pointers, call `forget` for all of them first: it needs the array to be the data written last,
 * and this function writes other data. */
static void text(image *im, void *place) {
  const char *data = NULL;
  if (im->writes) memcpy(&data, place, sizeof data);
  uint64_t size = data ? strlen(data) + 1 : 0;
  transfer(im, &size, sizeof size);
  if (size == 0 || failed(im)) return;
  array(im, place, size, 1);
  if (!im->writes && !failed(im)) {
    memcpy(&data, place, sizeof data);
    im->damaged = data[size - 1] != 0;
  }
}

/* Writes or reads the data to which element `at` of a list points. */
static void walk_element(image *im, sd_model *m, size_t list, char *at) {
  for (const struct owned *o = owned; o < owned + OWNED; o++) {
    char *place = at + o->pointer;
    uint8_t has = 1;
    if (o->list != list || o->kind == BORROWED) continue;
    if (o->kind == OWNED_SWITCHES) {
      has = pointer_at(place, 0) != NULL;
      transfer(im, &has, 1);
    }
    if (o->kind == OWNED_TEXT)
      text(im, place);
    else if (has)
      array(im, place, number_at(o->kind == OWNED_ARRAY ? at : (char *)m, o->number), o->size);
  }
}

static void walk_list(image *im, sd_model *m, const struct list *list) {
  char *place = (char *)m + list->pointer;
  size_t n = number_at(m, list->number);
  if (place == (char *)&m->laws) {
    im->damaged |= n > UINT32_MAX;
    n *= n;
  }
  array(im, place, n, list->size);
  if (failed(im)) return;
  char *first = pointer_at(place, 0);
  for (size_t k = 0; k < n; k++) {
    blank_gaps(im, list->pointer, first + k * list->size);
    for (const struct owned *o = owned; o < owned + OWNED; o++)
      if (o->list == list->pointer) forget(im, first + k * list->size + o->pointer);
  }
  for (size_t k = 0; k < n; k++) walk_element(im, m, list->pointer, first + k * list->size);
}

/* Writes or reads all that a model owns; the struct itself precedes it. */
static void walk(image *im, sd_model *m) {
  void *places[] = {&m->title,         &m->mistakes, &m->deck, &m->segments, &m->clump_disks,
                    &m->clump_offsets, &m->advised,  &m->mine, &m->known,    &m->comm};
  for (size_t k = 0; k < sizeof places / sizeof *places; k++) forget(im, places[k]);
  for (size_t k = 0; k < LISTS; k++) forget(im, (char *)m + lists[k].pointer);
  blank_gaps(im, SIZE_MAX, (char *)m);
  text(im, &m->title);
  for (size_t k = 0; k < LISTS; k++) walk_list(im, m, &lists[k]);
}

void *model_serialize(const sd_model *model, size_t *size) {
  image im = {.writes = true};
  /* a shallow copy, since `walk` takes a model that is not const; it only changes one that it
   * reads */
  sd_model whole = *model, *m = &whole;
  assert(!model->parted && !model->tiles.away);
  uint32_t head[sizeof layout / sizeof *layout];
  memcpy(head, layout, sizeof layout);
  transfer(&im, head, sizeof head);
  transfer(&im, m, sizeof *m);
  walk(&im, m);
  *size = im.n;
  transfer(&im, &(uint32_t){0}, sizeof(uint32_t));
  if (!failed(&im)) return im.bytes;
  free(im.bytes);
  return NULL;
}

/* True if all enum values and counts that are used as indices of tables, before sd_model_finish
 * checks them, are valid. */
static bool kinds_exist(const sd_model *m) {
  for (size_t k = 0; k < m->n_motions; k++)
    if ((unsigned)m->motions[k].kind >= SD_MOTION_KINDS ||
        (unsigned)m->motions[k].coordinate >= SD_MOVED)
      return false;
  for (size_t k = 0; k < m->n_materials * m->n_materials; k++)
    if ((unsigned)m->laws[k].normal >= SD_NORMAL_LAWS) return false;
  for (size_t k = 0; k < m->n_fields; k++)
    if ((unsigned)m->fields[k].kind >= SD_FIELD_KINDS ||
        (unsigned)m->fields[k].per > SD_FIELD_PER_MASS)
      return false;
  for (size_t k = 0; k < m->n_averages; k++)
    if (m->averages[k].of[0].n > SD_AVERAGE_TERMS || m->averages[k].of[1].n > SD_AVERAGE_TERMS)
      return false;
  return (unsigned)m->integrator <= SD_VERLET && (unsigned)m->variant <= SD_CONSERVATIVE;
}

sd_status image_read(const void *bytes, size_t size, sd_model **out, sd_messages *messages) {
  *out = NULL;
  if (size < sizeof layout || memcmp(bytes, layout, sizeof layout) != 0)
    return sd_fail(messages, SD_ERROR_USER,
                   "the model was saved by another version of slipdisk; this is version %s",
                   SD_VERSION);
  sd_model *m = memory_new(1, sizeof *m);
  image im = {.bytes = (unsigned char *)(uintptr_t)bytes, .n = sizeof layout, .capacity = size};
  transfer(&im, m, sizeof *m);
  /* true in damaged bytes only: distributed models are not serialized */
  m->parted = m->tiles.away = false;
  walk(&im, m);
  sd_status status = SD_OK;
  if (im.starved) status = sd_fail(messages, SD_ERROR_IO, "out of memory for the model");
  if (!im.starved && (failed(&im) || im.n != size || !kinds_exist(m)))
    status = sd_fail(messages, SD_ERROR_IO, "the saved model is damaged");
  if (status == SD_OK && m->finished) status = model_finish_again(m, messages);
  if (status == SD_OK)
    *out = m;
  else
    sd_model_free(m);
  return status;
}

sd_model *sd_model_clone(const sd_model *model) {
  size_t size;
  sd_model *copy = NULL;
  void *bytes = model_serialize(model, &size);
  if (bytes) image_read(bytes, size, &copy, NULL);
  free(bytes);
  if (copy) model_copy_mistakes(copy, model);
  return copy;
}

/* Lists are missing in a model of which only a part could be read. */
void sd_model_free(sd_model *m) {
  if (!m) return;
  const size_t known = m->parted ? m->n_known : model_held(m);
  for (const struct list *list = lists; list < lists + LISTS; list++) {
    const bool disks = list->pointer == offsetof(sd_model, disks);
    char *first = pointer_at(m, list->pointer);
    const size_t n = disks ? known : number_at(m, list->number);
    for (const struct owned *o = owned; first && o < owned + OWNED; o++)
      for (size_t k = 0; o->list == list->pointer && o->kind != BORROWED && k < n; k++)
        free(pointer_at(first + (disks ? model_known_disk(m, k) : k) * list->size, o->pointer));
    free(first);
  }
  rows_free(m->mine);
  sd_messages_free(m->mistakes);
  sd_messages_free(m->advised);
  if (m->deck) {
    char *const texts[] = {m->deck->path, m->deck->text, m->deck->overrides, m->deck->full,
                           m->deck->bodies};
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) free(texts[k]);
  }
  void *const rest[] = {m->title,       m->known,         m->mine, m->segments,
                        m->clump_disks, m->clump_offsets, m->deck, m};
  for (size_t k = 0; k < sizeof rest / sizeof *rest; k++) free(rest[k]);
}

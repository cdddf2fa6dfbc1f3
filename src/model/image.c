/* image.c: serializes and restores a model; see model.h.
 *
 * One walk over everything that a model owns, in a fixed order, serves writing and reading: the
 * struct, then each array, then what the elements of the array point to. Pointers are stored as
 * zeros.
 */
#include "model/model.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "slipdisk/model.h"

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

/* Sets a pointer to zero, given the address `place` of the pointer. When writing, only its copy
 * in the serialized model is changed; the pointer must belong to the data written last. */
static void forget(image *im, void *place) {
  if (im->writes && !failed(im))
    memset(im->bytes + im->offset + ((const char *)place - im->source), 0, sizeof(void *));
  else if (!im->writes)
    memset(place, 0, sizeof(void *));
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

#define FORGET_ALL(im, list, n, member)                                                            \
  for (size_t k_ = 0; k_ < (n); k_++) forget(im, &(list)[k_].member)

static void walk_disks(image *im, sd_model *m) {
  array(im, &m->disks, m->n_disks, sizeof *m->disks);
  if (failed(im)) return;
  FORGET_ALL(im, m->disks, m->n_disks, name);
  for (size_t k = 0; k < m->n_disks; k++) text(im, &m->disks[k].name);
}

static void walk_bodies(image *im, sd_model *m) {
  walk_disks(im, m);
  if (failed(im)) return;
  array(im, &m->walls, m->n_walls, sizeof *m->walls);
  if (failed(im)) return;
  FORGET_ALL(im, m->walls, m->n_walls, name);
  FORGET_ALL(im, m->walls, m->n_walls, points);
  for (size_t k = 0; k < m->n_walls; k++) {
    text(im, &m->walls[k].name);
    array(im, &m->walls[k].points, m->walls[k].n_points, sizeof *m->walls->points);
  }
  array(im, &m->clumps, m->n_clumps, sizeof *m->clumps);
  if (failed(im)) return;
  FORGET_ALL(im, m->clumps, m->n_clumps, name);
  /* the list of each clump's disks is rebuilt from the clump numbers stored in the disks */
  FORGET_ALL(im, m->clumps, m->n_clumps, disks);
  for (size_t k = 0; k < m->n_clumps; k++) text(im, &m->clumps[k].name);
}

static void walk_motions(image *im, sd_model *m) {
  array(im, &m->motions, m->n_motions, sizeof *m->motions);
  if (failed(im)) return;
  FORGET_ALL(im, m->motions, m->n_motions, name);
  FORGET_ALL(im, m->motions, m->n_motions, bodies);
  FORGET_ALL(im, m->motions, m->n_motions, table_time);
  FORGET_ALL(im, m->motions, m->n_motions, table_value);
  for (size_t k = 0; k < m->n_motions; k++) {
    sd_motion *q = &m->motions[k];
    text(im, &q->name);
    array(im, &q->bodies, q->n_bodies, sizeof *q->bodies);
    array(im, &q->table_time, q->n_table, sizeof(double));
    array(im, &q->table_value, q->n_table, sizeof(double));
  }
}

/* Writes or reads the on/off flags of a phase, one per motion or field; NULL: all are on. */
static void switches(image *im, bool **list, size_t n) {
  uint8_t has = *list != NULL;
  transfer(im, &has, 1);
  if (has) array(im, list, n, sizeof(bool));
}

static void walk_phases(image *im, sd_model *m) {
  array(im, &m->fields, m->n_fields, sizeof *m->fields);
  if (failed(im)) return;
  FORGET_ALL(im, m->fields, m->n_fields, name);
  FORGET_ALL(im, m->fields, m->n_fields, disks);
  for (size_t k = 0; k < m->n_fields; k++) {
    text(im, &m->fields[k].name);
    array(im, &m->fields[k].disks, m->fields[k].n_disks, sizeof(uint32_t));
  }
  array(im, &m->phases, m->n_phases, sizeof *m->phases);
  if (failed(im)) return;
  FORGET_ALL(im, m->phases, m->n_phases, name);
  FORGET_ALL(im, m->phases, m->n_phases, active);
  FORGET_ALL(im, m->phases, m->n_phases, fields);
  for (size_t k = 0; k < m->n_phases; k++) {
    text(im, &m->phases[k].name);
    switches(im, &m->phases[k].active, m->n_motions);
    switches(im, &m->phases[k].fields, m->n_fields);
  }
}

static void walk_averages(image *im, sd_model *m) {
  array(im, &m->averages, m->n_averages, sizeof *m->averages);
  if (failed(im)) return;
  FORGET_ALL(im, m->averages, m->n_averages, name);
  FORGET_ALL(im, m->averages, m->n_averages, text);
  for (size_t k = 0; k < m->n_averages; k++) {
    text(im, &m->averages[k].name);
    text(im, &m->averages[k].text);
  }
}

static void walk_materials(image *im, sd_model *m) {
  text(im, &m->title);
  array(im, &m->materials, m->n_materials, sizeof *m->materials);
  if (failed(im)) return;
  FORGET_ALL(im, m->materials, m->n_materials, name);
  for (size_t k = 0; k < m->n_materials; k++) text(im, &m->materials[k].name);
  im->damaged = m->n_materials > UINT32_MAX;
  array(im, &m->laws, m->n_materials * m->n_materials, sizeof *m->laws);
  array(im, &m->groups, m->n_groups, sizeof *m->groups);
  if (failed(im)) return;
  for (size_t k = 0; k < m->n_groups; k++) forget(im, &m->groups[k]);
  for (size_t k = 0; k < m->n_groups; k++) text(im, &m->groups[k]);
}

/* Writes or reads all arrays of a model; the struct itself precedes them. */
static void walk(image *im, sd_model *m) {
  void *places[] = {&m->title,         &m->materials,   &m->laws,        &m->groups,
                    &m->disks,         &m->walls,       &m->motions,     &m->fields,
                    &m->phases,        &m->rains,       &m->memories,    &m->rotations,
                    &m->slides,        &m->mistakes,    &m->deck,        &m->segments,
                    &m->contact_disks, &m->clumps,      &m->clump_disks, &m->clump_offsets,
                    &m->advised,       &m->tiles.walls, &m->derivatives, &m->mine,
                    &m->known,         &m->comm,        &m->averages};
  for (size_t k = 0; k < sizeof places / sizeof *places; k++) forget(im, places[k]);
  if (!failed(im)) walk_materials(im, m);
  if (!failed(im)) walk_bodies(im, m);
  if (!failed(im)) walk_motions(im, m);
  if (!failed(im)) walk_phases(im, m);
  array(im, &m->rains, m->n_rains, sizeof *m->rains);
  array(im, &m->memories, m->n_memories, sizeof *m->memories);
  array(im, &m->derivatives, m->n_derivatives, sizeof *m->derivatives);
  array(im, &m->tiles.walls, m->tiles.n_walls, sizeof *m->tiles.walls);
  array(im, &m->rotations, m->n_rotations, sizeof *m->rotations);
  array(im, &m->slides, m->n_slides, sizeof *m->slides);
  array(im, &m->contact_disks, m->n_contact_disks, sizeof *m->contact_disks);
  walk_averages(im, m);
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

/* Frees a model of which only a part could be read, after setting the counts of missing arrays
 * to 0. */
static void drop(sd_model *m) {
  if (!m->materials) m->n_materials = 0;
  if (!m->groups) m->n_groups = 0;
  if (!m->disks) m->n_disks = 0;
  if (!m->walls) m->n_walls = 0;
  if (!m->clumps) m->n_clumps = 0;
  if (!m->motions) m->n_motions = 0;
  if (!m->fields) m->n_fields = 0;
  if (!m->phases) m->n_phases = 0;
  if (!m->averages) m->n_averages = 0;
  sd_model_free(m);
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
    drop(m);
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

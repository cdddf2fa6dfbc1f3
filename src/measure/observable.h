/* observable.h: what is measured, each quantity once: its name, unit and meaning, and how it is got, from a field of a
 * structure or by a function.
 *
 * Lists of these rows are all that the rest knows: columns of the series and of frames, datasets and attributes of
 * /summary, `info --json`, the tables of sweeps, `measure`, and the tables that
 * tools/docs/names.py puts into the site's page docs/names.md. */
#ifndef MEASURE_OBSERVABLE_H
#define MEASURE_OBSERVABLE_H

#include <stdio.h>

#include "measure/resultant.h"
#include "slipdisk/measure.h"
#include "slipdisk/simulation.h"

typedef enum observable_type {
  OBSERVABLE_F64,
  OBSERVABLE_I64,
  OBSERVABLE_I32,
  OBSERVABLE_U32,
  OBSERVABLE_SIZE, /* size_t */
  OBSERVABLE_FLAG  /* bool */
} observable_type;

/* Element `k` of the quantity of a row: of the structure that the list is about. */
typedef double observable_getter(const void *row, size_t k);

typedef struct observable {
  const char *name, *unit, *meaning;
  observable_type type;
  size_t width;  /* elements: 2 for a vector or a pair of contacts; OBSERVABLE_WATCHED ... */
  size_t offset; /* of the field */
  observable_getter *get;              /* NULL: the field */
  const char *column;                  /* in tables of sweeps, behind the disk's name; NULL: none */
  const char *json;                    /* in `--json`; NULL: the name; "": not there */
  bool (*when)(const sd_model *model); /* NULL: always there */
} observable;
/* Width of a quantity that each watched disk, wall, group, or disk of measure.contacts has. */
#define OBSERVABLE_WATCHED SIZE_MAX
#define OBSERVABLE_WALLS (SIZE_MAX - 1)
#define OBSERVABLE_GROUPS (SIZE_MAX - 2)
#define OBSERVABLE_CHOSEN (SIZE_MAX - 3)
/* Elements of a row of this model. */
size_t observable_width(const observable *o, const sd_model *model);

typedef struct observable_list {
  const char *name,
      *title; /* of the list: a group of /summary or the like; what its rows are about */
  size_t n;
  const observable *rows;
} observable_list;

/* The list of a static array. */
#define OBSERVABLES(name, title, rows)                                                             \
  { name, title, sizeof(rows) / sizeof *(rows), rows }

/* A row: a field of a structure. */
#define OBSERVABLE_FIELD(name, unit, meaning, type, structure, field, column, json)                \
  {                                                                                                \
    name, unit, meaning, OBSERVABLE_##type, 1, offsetof(structure, field), NULL, column, json,     \
        NULL                                                                                       \
  }
/* A getter: element k of a row, called `at` in the expression. */
#define OBSERVABLE_GET(name, structure, expression)                                                \
  static double name(const void *row, size_t k) {                                                  \
    const structure *at = row;                                                                     \
    (void)k;                                                                                       \
    return expression;                                                                             \
  }

double observable_value(const observable *o, const void *row, size_t k);
/* The value goes into the field; nothing happens to a quantity that a function gives. */
void observable_set(const observable *o, void *row, size_t k, double value);
/* The row of this name; NULL: there is none. */
const observable *observable_find(const observable_list *list, const char *name);
/* As a table of markdown: name, unit, column in tables where any has one, meaning. */
void observable_print(FILE *out, const observable_list *list);
/* The type as which it is stored; element k of a dense array of a type. */
sd_type observable_stored(const observable *o);
double observable_element(sd_type type, const void *dense, size_t k);
void observable_store(const observable *o, void *dense, size_t k, double value);

/* --- lists -------------------------------------------------------------------------------------------- */
extern const observable_list rotation_observables;      /* of sd_rotation */
extern const observable_list slide_observables;         /* of sd_slide */
extern const observable_list configuration_observables; /* of sd_configuration */
extern const observable_list disk_observables;          /* of sd_disk_mean */
extern const observable_list total_observables;         /* of sd_disk_totals */
extern const observable_list energy_observables;        /* of sd_energy */

/* A moment of a run. */
typedef struct moment {
  const sd_model *model;
  const sd_state *state;
  const sd_energy *energy;
  const slot_table *slots;
  const resultants *sums;
} moment;
extern const observable_list series_observables; /* beside the energies */
/* The resultants of the moment that a row is about, one per element; NULL: it is about the moment. */
const resultant *series_resultants(const observable *o, const moment *now);
/* Does some phase change the lengths of the region? */
bool series_compresses(const sd_model *model);

/* A body at a moment; row of frames. */
typedef struct moment_body {
  const sd_state *state;
  uint32_t slot;
} moment_body;
extern const observable_list frame_observables; /* of moment_body */

/* A clump at a moment; row of frames. */
typedef struct moment_clump {
  const sd_state *state;
  size_t clump;
} moment_clump;
extern const observable_list clump_observables; /* of moment_clump */

/* A closed contact at a moment; row of contact tables. */
typedef struct moment_contact {
  const sd_model *model;
  const sd_state *state;
  const slot_table *slots;
  size_t contact;
} moment_contact;
extern const observable_list contact_observables; /* of moment_contact */

#endif

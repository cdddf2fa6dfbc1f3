/* observable.h: tables of measured quantities. A row gives the name, unit and meaning of a
 * quantity, and the structure member or the function that holds its value.
 *
 * All writers and lists loop over these tables: columns of the series and of frames, datasets and
 * attributes of /summary, `info --json`, the tables of sweeps, `measure`, and the tables that
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
  OBSERVABLE_SIZE, /* a member of type size_t */
  OBSERVABLE_FLAG  /* a member of type bool */
} observable_type;

/* A function that returns element k of a quantity. row: pointer to the structure that the table
 * describes. */
typedef double observable_getter(const void *row, size_t k);

typedef struct observable {
  const char *name, *unit, *meaning;
  observable_type type;
  /* number of elements: 2 for a vector or a pair of contacts; OBSERVABLE_WATCHED and the like
   * (below): the number depends on the model */
  size_t width;
  size_t offset;          /* byte offset of the member in the structure */
  observable_getter *get; /* function that returns the value; NULL: the member holds it */
  /* column name in tables of sweeps, appended to the name of the disk; NULL: no column */
  const char *column;
  const char *json; /* name in `--json` output; NULL: the same as `name`; "": omitted */
  /* returns true if a run of this model has the quantity; NULL: every run has it */
  bool (*when)(const sd_model *model);
} observable;
/* Values of observable.width for quantities with one element for each watched disk, each wall, each
 * group, or each disk of the deck's measure.contacts. */
#define OBSERVABLE_WATCHED SIZE_MAX
#define OBSERVABLE_WALLS (SIZE_MAX - 1)
#define OBSERVABLE_GROUPS (SIZE_MAX - 2)
#define OBSERVABLE_CHOSEN (SIZE_MAX - 3)
/* Returns the number of elements of the quantity for this model. */
size_t observable_width(const observable *o, const sd_model *model);

typedef struct observable_list {
  /* name: name of the table, such as a group of /summary; title: text that says what its rows
   * describe */
  const char *name, *title;
  size_t n;
  const observable *rows;
} observable_list;

/* Initialises a table from a static array of rows. */
#define OBSERVABLES(name, title, rows)                                                             \
  { name, title, sizeof(rows) / sizeof *(rows), rows }

/* Initialises a row for a quantity that is a member of a structure. */
#define OBSERVABLE_FIELD(name, unit, meaning, type, structure, field, column, json)                \
  {                                                                                                \
    name, unit, meaning, OBSERVABLE_##type, 1, offsetof(structure, field), NULL, column, json,     \
        NULL                                                                                       \
  }
/* Defines an observable_getter that returns the expression, which can use `at`, a pointer to the
 * structure, and k, the index of the element. */
#define OBSERVABLE_GET(name, structure, expression)                                                \
  static double name(const void *row, size_t k) {                                                  \
    const structure *at = row;                                                                     \
    (void)k;                                                                                       \
    return expression;                                                                             \
  }

double observable_value(const observable *o, const void *row, size_t k);
/* Stores value in element k of the member; does nothing if the quantity is computed by a
 * function. */
void observable_set(const observable *o, void *row, size_t k, double value);
/* Returns the row with this name; NULL: none. */
const observable *observable_find(const observable_list *list, const char *name);
/* Prints the table as markdown: name, unit, column in sweep tables if any row has one, meaning. */
void observable_print(FILE *out, const observable_list *list);
/* observable_stored returns the type in which the quantity is stored in files; observable_element
 * and observable_store read and write element k of a dense array. */
sd_type observable_stored(const observable *o);
double observable_element(sd_type type, const void *dense, size_t k);
void observable_store(const observable *o, void *dense, size_t k, double value);

/* --- tables ----------------------------------------------------------------------------------- */
extern const observable_list rotation_observables;      /* quantities of an sd_rotation */
extern const observable_list slide_observables;         /* quantities of an sd_slide */
extern const observable_list configuration_observables; /* quantities of an sd_configuration */
extern const observable_list disk_observables;          /* quantities of an sd_disk_mean */
extern const observable_list total_observables;         /* quantities of an sd_disk_totals */
extern const observable_list energy_observables;        /* quantities of an sd_energy */

/* State of a run at one time, with its energies and resultants. */
typedef struct moment {
  const sd_model *model;
  const sd_state *state;
  const sd_energy *energy;
  const slot_table *slots;
  const resultants *sums;
} moment;
/* Table of the quantities recorded as series, other than energies; each is computed from a
 * moment. */
extern const observable_list series_observables;
/* Returns the resultants from which a quantity of the series is read, one for each of its elements
 * (walls, groups or chosen disks); NULL: the quantity is read from the moment itself. */
const resultant *series_resultants(const observable *o, const moment *now);
/* Returns true if some phase of the run changes the lengths of the region. */
bool series_compresses(const sd_model *model);

/* One body at one time of a run; the quantities in frames are read from it. */
typedef struct moment_body {
  const sd_state *state;
  uint32_t slot;
} moment_body;
extern const observable_list frame_observables; /* quantities of a moment_body */

/* One clump at one time of a run; the quantities in clump frames are read from it. */
typedef struct moment_clump {
  const sd_state *state;
  size_t clump;
} moment_clump;
extern const observable_list clump_observables; /* quantities of a moment_clump */

/* One closed contact at one time of a run; the quantities in contact tables are read from it. */
typedef struct moment_contact {
  const sd_model *model;
  const sd_state *state;
  const slot_table *slots;
  size_t contact;
} moment_contact;
extern const observable_list contact_observables; /* quantities of a moment_contact */

#endif

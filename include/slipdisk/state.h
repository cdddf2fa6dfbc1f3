/* state.h: the state of a running system, an array ("column") per quantity: all that a checkpoint
 * holds.
 *
 * Rows of the columns are called slots: free disks have the first ones, then driven disks, then
 * walls. Column `id` gives the body number of each slot. Below 1000 free disks slots are in the
 * order of body numbers. From 1000 on they are sorted by position, and may change at the start of
 * each phase; sd_simulation_slot finds the slot of a body.
 *
 * The angle of a body is turn + theta, with theta in [-4, 4] and turn a multiple of 8 rad, so that
 * the tangential displacement stays exact to rounding of order R 1e-15 after any number of turns.
 * The position of a body is (x, y), within the periodic box, plus (image_x, image_y) times the
 * lengths of the box.
 */
#ifndef SLIPDISK_STATE_H
#define SLIPDISK_STATE_H

#include <stddef.h>
#include <stdint.h>

#include "slipdisk/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The state of a system at the end of a step; its members are reached through sd_fields. */
typedef struct sd_state sd_state;

/* Coordinates of a body, as indices of arrays, and their number. */
enum { SD_X = 0, SD_Y = 1, SD_THETA = 2, SD_COORDINATES = 3 };
/* SD_SURFACE: further quantity that a motion can move, the surface of a wall, which runs along
 * the wall like a conveyor belt while the wall itself stays in place. SD_MOVED: number of all
 * quantities that motions can move. */
enum { SD_SURFACE = 3, SD_MOVED = 4 };

/* Integrator of the free disks: Gear's predictor-corrector of fifth order, or velocity Verlet. */
typedef enum sd_integrator { SD_GEAR5, SD_VERLET } sd_integrator;

/* Type of the elements of a column: double, int64_t, int32_t, uint32_t. */
typedef enum sd_type { SD_F64, SD_I64, SD_I32, SD_U32 } sd_type;

/* Meaning and order of the elements of a column, which determine their number (sd_extent_size). */
typedef enum sd_extent {
  SD_PER_RUN,     /* a single number for the whole run */
  SD_PER_BODY,    /* one element per disk and wall, in the order of slots */
  SD_PER_FREE,    /* one element per free disk, in the order of slots */
  SD_PER_SURFACE, /* one element per wall if a motion moves the surface of any wall, else none */
  /* one element per closed contact, sorted by the lower slot of its bodies, then by partner */
  SD_PER_CONTACT,
  SD_PER_MOTION, /* one element per motion of the model */
  /* Four numbers if a phase deforms the box, else none: length of the box along x, length along
   * y, offset in x between rows of images, shear strain. */
  SD_PER_CELL,
  /* one element per free disk, in the order of slots, if a phase deforms the box, else none */
  SD_PER_CELL_DISK,
  SD_PER_PHASE,        /* one element per phase of the model */
  SD_PER_ROTATION,     /* one element per disk whose rotation is measured */
  SD_PER_ROTATION_BIN, /* SD_BINS elements per disk whose rotation is measured, disk by disk */
  SD_PER_SLIDE,        /* one element per watched pair of contacts */
  /* 16 elements per watched pair of contacts, index 4 * (state of contact 1) + (state of contact
   * 2) */
  SD_PER_SLIDE_COUNT,
  SD_PER_SLIDE_CONTACT, /* two elements per watched pair of contacts, one for each contact */
  /* One element per free disk, in the order of slots, if means of every disk are measured, else
   * none */
  SD_PER_MEAN,
  /* SD_MEAN_BINS elements per free disk, disk by disk, if means of every disk are measured, else
   * none */
  SD_PER_MEAN_BIN,
  /* one element per watched pair of contacts if configurations are measured, else none */
  SD_PER_VISIT,
  /* two elements per watched pair, one for each contact, if configurations are measured, else
   * none */
  SD_PER_VISIT_CONTACT,
  /* 6 sums per watched pair of contacts if configurations are measured, else none */
  SD_PER_VISIT_PART,
  /* SD_CONFIGURATIONS elements per watched pair of contacts if configurations are measured, else
   * none */
  SD_PER_VISIT_CLASS,
  /* SD_CONFIGURATIONS * 6 sums per watched pair of contacts if configurations are measured, else
   * none */
  SD_PER_VISIT_SUM,
  /* SD_CONFIGURATIONS * SD_AGES elements per watched pair of contacts if configurations are
   * measured, else none */
  SD_PER_VISIT_AGE,
  /* one element per free disk, in the order of slots, if the model has force fields, else none */
  SD_PER_FIELDED,
  SD_PER_CLUMP, /* one element per clump, a rigid body of several disks, by clump number */
  /* one element per closed contact if a law needs the columns SD_CONTACT_MORE, else none */
  SD_PER_LAW_CONTACT,
  /* One element per free disk, in the order of slots, if a law needs the columns
   * SD_CONTACT_MORE, else none */
  SD_PER_LAW_FREE,
  SD_PER_BREAK,        /* one element per bond that has broken, in the order of steps */
  SD_PER_AVERAGE,      /* one element per average of the series (key "measure.averages") */
  SD_PER_AVERAGE_FORM, /* two elements per average, for its numerator and its denominator */
  SD_PER_AVERAGE_BIN,  /* SD_BINS elements for each numerator and denominator of an average */
  SD_EXTENTS           /* number of values of this enum */
} sd_extent;

/* Number of bins in the angle record of a watched disk, and in the record of an average. When all
 * are full, neighbouring bins are merged in pairs and the duration of a bin doubles. */
enum { SD_BINS = 4096 };
/* Number of bins in the angle record of each free disk, if means of every disk are measured.
 * When all are full, neighbouring bins are merged in pairs. */
enum { SD_MEAN_BINS = 128 };

/* Values of the column `activity` of free disks. Waiting and removed disks stand still and touch
 * nothing. */
enum {
  SD_IN_PLAY = 0, /* takes part in the simulation */
  SD_WAITING = 1, /* not released yet by its rain, which adds disks in batches */
  SD_REMOVED = 2, /* removed from the simulation for good */
  SD_OUTSIDE = 3, /* takes part, but its centre is beyond the bounds of the model */
  SD_HELD = 4     /* takes part, but does not move, or only as motions move it */
};

/* States of a contact: sliding with positive or with negative torque on the watched disk, stuck,
 * open. */
enum { SD_SLIDE_POSITIVE = 0, SD_SLIDE_NEGATIVE = 1, SD_STUCK = 2, SD_OPEN = 3 };

/* SD_CONFIGURATIONS: number of joint states of two contacts: S++, S+-, S-+, S--, stick (at least
 * one stuck, none open), open (at least one open). SD_AGES: number of classes of the duration
 * since a configuration began, in steps: below 32, below 64 and so on; the last has no end. */
enum { SD_CONFIGURATIONS = 6, SD_AGES = 16 };

/* Description of one column of the state: a row of sd_fields. Allocation, checkpoints, comparison
 * and hash of states loop over these rows. */
typedef struct sd_field {
  const char *name; /* name of the column, and of its dataset in checkpoints */
  sd_type type;     /* type of the column's elements */
  sd_extent extent; /* meaning and order of the column's elements */
  size_t offset;    /* offset of the column's pointer in struct sd_state; for the library itself */
  /* Unit in terms of length, mass, time, force, energy, power and rad; "1": none */
  const char *unit;
  const char *meaning; /* description of the column in one line */
} sd_field;

/* Table of all columns of a state, sd_field_count rows. */
SD_API extern const sd_field sd_fields[];
/* Number of rows of sd_fields. */
SD_API extern const size_t sd_field_count;

/* Returns the number of bytes of one element of a type. */
SD_API size_t sd_type_size(sd_type type);
/* Returns the number of elements that columns of an extent have in this state. */
SD_API size_t sd_extent_size(const sd_state *state, sd_extent extent);
/* Returns the address of the first element of a column, which the state owns. */
SD_API void *sd_field_data(const sd_state *state, const sd_field *field);

/* Frees a state and its columns; NULL is allowed. */
SD_API void sd_state_free(sd_state *state);
/* Returns the FNV-1a hash over all columns in the order of sd_fields: equal states have equal
 * hashes. */
SD_API uint64_t sd_state_hash(const sd_state *state);
/* Returns the first column in which two states differ in any bit; NULL: they are equal. */
SD_API const sd_field *sd_state_difference(const sd_state *a, const sd_state *b);

#ifdef __cplusplus
}
#endif

#endif

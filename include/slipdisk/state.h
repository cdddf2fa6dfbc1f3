/* state.h: columns of a running system, as a checkpoint holds them.
 *
 * Bodies stand in slots: free disks first, then driven disks, then walls; column `id` has their body numbers. Below 1000 free
 * disks slots go by number; from there on by place, and change where a phase begins (sd_simulation_slot).
 *
 * Angle of a body: turn + theta, theta in [-4, 4], turn a multiple of 8 rad, so that the tangential
 * displacement stays exact to rounding of order R 1e-15 after any number of turns.
 * Position: the periodic image in the box plus image * box length.
 */
#ifndef SLIPDISK_STATE_H
#define SLIPDISK_STATE_H

#include <stddef.h>
#include <stdint.h>

#include "slipdisk/status.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct sd_state sd_state;

typedef enum sd_type { SD_F64, SD_I64, SD_I32, SD_U32 } sd_type;

/* How many elements a column has. */
typedef enum sd_extent {
  SD_PER_RUN,     /* 1 */
  SD_PER_BODY,    /* disks and walls, by slot */
  SD_PER_FREE,    /* free disks, by slot */
  SD_PER_SURFACE, /* walls in their order, where motions move the surface of any; else none */
  SD_PER_CONTACT, /* closed contacts, ordered by (lower slot, partner) */
  SD_PER_MOTION,
  SD_PER_CELL, /* lengths in x and y, offset, shear: all where a phase deforms the box, or none */
  SD_PER_CELL_DISK, /* free disks, by slot, there */
  SD_PER_PHASE,
  SD_PER_ROTATION,      /* watched disks */
  SD_PER_ROTATION_BIN,  /* watched disks * SD_BINS, row by row */
  SD_PER_SLIDE,         /* watched pairs of contacts */
  SD_PER_SLIDE_COUNT,   /* watched pairs * 16 */
  SD_PER_SLIDE_CONTACT, /* watched pairs * 2 */
  SD_PER_MEAN,          /* free disks whose means are taken: all or none */
  SD_PER_MEAN_BIN,      /* the same * SD_MEAN_BINS, row by row */
  SD_PER_VISIT,         /* watched pairs whose configurations are measured: all or none */
  SD_PER_VISIT_CONTACT, /* the same * 2 */
  SD_PER_VISIT_PART,    /* the same * 6 sums */
  SD_PER_VISIT_CLASS,   /* the same * SD_CONFIGURATIONS */
  SD_PER_VISIT_SUM,     /* the same * SD_CONFIGURATIONS * 6 sums */
  SD_PER_VISIT_AGE,     /* the same * SD_CONFIGURATIONS * SD_AGES */
  SD_PER_FIELDED,       /* free disks of a model with fields: all or none */
  SD_PER_CLUMP,         /* rigid bodies of several disks, by their numbers */
  SD_PER_LAW_CONTACT, /* closed contacts, where laws need these columns (SD_CONTACT_MORE): all or none */
  SD_PER_LAW_FREE, /* free disks, likewise */
  SD_EXTENTS
} sd_extent;

/* Bins of the angle record: when they are full, neighbours are merged and the bin length doubles. */
enum { SD_BINS = 4096 };
/* Of each disk of a packing, likewise. */
enum { SD_MEAN_BINS = 128 };

/* Column `activity`. Waiting and removed disks stand still and touch nothing. */
enum {
  SD_IN_PLAY = 0,
  SD_WAITING = 1,
  SD_REMOVED = 2,
  SD_OUTSIDE = 3 /* in play, beyond the bounds */
};

/* A contact: open, stuck, or sliding with positive or negative torque on the watched disk. */
enum { SD_SLIDE_POSITIVE = 0, SD_SLIDE_NEGATIVE = 1, SD_STUCK = 2, SD_OPEN = 3 };

/* Classes of two contacts: S++, S+-, S-+, S--, stick (one stuck, none open), open; and octaves of the age of a visit, in
 * steps: below 32, below 64 and so on. */
enum { SD_CONFIGURATIONS = 6, SD_AGES = 16 };

/* A column of the state. All stand in one table; allocation, checkpoint, comparison and hash follow it. */
typedef struct sd_field {
  const char *name;
  sd_type type;
  sd_extent extent;
  size_t offset;    /* of the library's own */
  const char *unit; /* in terms of length, mass, time */
  const char *meaning;
} sd_field;

SD_API extern const sd_field sd_fields[];
SD_API extern const size_t sd_field_count;

/* Bytes of an element. */
SD_API size_t sd_type_size(sd_type type);
/* Elements of the columns of an extent. */
SD_API size_t sd_extent_size(const sd_state *state, sd_extent extent);
/* First element of a column. */
SD_API void *sd_field_data(const sd_state *state, const sd_field *field);

SD_API void sd_state_free(sd_state *state);
/* FNV-1a over every column in table order: equal states have equal hashes. */
SD_API uint64_t sd_state_hash(const sd_state *state);
/* First column that differs in any bit, NULL when equal. */
SD_API const sd_field *sd_state_difference(const sd_state *a, const sd_state *b);

#ifdef __cplusplus
}
#endif

#endif

/* summary_disks.h: the part of a summary about every free disk of a packing: /summary/disks. */
#ifndef SLIPDISK_IO_SUMMARY_DISKS_H
#define SLIPDISK_IO_SUMMARY_DISKS_H

#include "io/store/h5.h"
#include "slipdisk/measure.h"

/* The fastest disks are kept apart, so that a report needs to read no more than these. */
enum { SUMMARY_FASTEST = 10 };

typedef struct summary_disks {
  size_t n;            /* disks; 0: the deck does not ask for their means */
  sd_disk_mean *disks; /* NULL: they have not been read, see summary_disks_read_all */
  bool later; /* the file has only the state from which they follow, see checkpoint_complete */
  size_t n_fastest;
  sd_disk_mean fastest[SUMMARY_FASTEST]; /* those with the largest |Omega|, which is not 0 */
  sd_disk_totals totals;
  int64_t looks, bins; /* at the contacts; of the angle records */
  double measured;     /* time */
} summary_disks;

/* A record of fewer bins has no error bars. */
enum { SUMMARY_FEWEST_BINS = 16 };

/* Checkpoints of so many disks or more, and over ranks, leave the means to those that read them:
 * they follow from the state, and take longer than writing it. */
enum { SUMMARY_LATER = 16384 };

/* Of how many disks and what length the means will be. */
void summary_disks_announce(summary_disks *s, const sd_model *model, const sd_state *state);
/* summary_disks_free also when it fails. */
sd_status summary_disks_collect(summary_disks *s, const sd_model *model, const sd_state *state,
                                int threads, sd_messages *messages);
/* The same in two steps: means of the first n slots of a state with some disks; and from those of
 * all, in the order of slots, with id, radius and contacts of the whole state. */
void summary_disks_means(sd_disk_mean *means, size_t n, const sd_model *model,
                         const sd_state *state, int threads);
sd_status summary_disks_take(summary_disks *s, const sd_model *model, const sd_state *state,
                             const sd_disk_mean *means, sd_messages *messages);
void summary_disks_free(summary_disks *s);
/* Writes nothing when there are no disks, and how many when no more is known. */
void summary_disks_write(const summary_disks *s, h5_file *file);
/* All but the means of each disk. */
sd_status summary_disks_read(summary_disks *s, const h5_file *file, sd_messages *messages);
/* These as well, unless they come later. */
sd_status summary_disks_read_all(summary_disks *s, const h5_file *file, sd_messages *messages);

#endif

/* members.h: arrays of structures as groups of datasets, one per member. */
#ifndef SLIPDISK_IO_MEMBERS_H
#define SLIPDISK_IO_MEMBERS_H

#include "io/store/h5.h"

/* A member of a structure, of which an array is stored as one dataset [n] or [n][width]. */
typedef struct member {
  const char *name;
  sd_type type;
  size_t offset, width;
  const char *unit, *meaning;
} member;

/* n structures from `first` on, `stride` bytes apart, into a group; with unit and description. */
void members_write(h5_file *file, const char *group, const member *members, size_t n_members, void *first,
                   size_t stride, size_t n);
/* SD_ERROR_IO: a dataset is missing or of another size. */
sd_status members_read(const h5_file *file, const char *group, const member *members, size_t n_members,
                       void *first, size_t stride, size_t n, sd_messages *messages);

#endif

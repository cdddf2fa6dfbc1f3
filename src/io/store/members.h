/* members.h: structures as groups of datasets or as attributes, after the rows of an observable_list. */
#ifndef SLIPDISK_IO_MEMBERS_H
#define SLIPDISK_IO_MEMBERS_H

#include "io/store/h5.h"
#include "measure/observable.h"

/* n structures from `first` on, `stride` bytes apart: a dataset [n] or [n][width] for each row, with unit and description,
 * in a group. */
void members_write(h5_file *file, const char *group, const observable_list *list, const void *first,
                   size_t stride, size_t n);
/* SD_ERROR_IO: the first dataset is missing, or one is of another size. Others that an older file does not have are NAN, or
 * 0 in whole numbers. */
sd_status members_read(const h5_file *file, const char *group, const observable_list *list,
                       void *first, size_t stride, size_t n, sd_messages *messages);
/* One structure as attributes of the object at path. Those that are missing are NAN or 0. */
void members_write_attrs(h5_file *file, const char *path, const observable_list *list,
                         const void *row);
void members_read_attrs(const h5_file *file, const char *path, const observable_list *list,
                        void *row);

/* Path of this dataset in a file, which may have it by the name of an older format; to be freed. */
char *members_path(const h5_file *file, const char *path);

/* A dataset in a group, with unit and description. data NULL: there was no memory for it. */
void members_put(h5_file *file, const char *group, const char *name, sd_type type, int rank,
                 const size_t *dims, const void *data, bool compress, const char *unit,
                 const char *meaning);
/* Lines of one text. Reading: missing ones become empty; each is to be freed. */
void members_write_lines(h5_file *file, const char *path, size_t n, char *const *lines);
void members_read_lines(const h5_file *file, const char *path, size_t n, char **lines);

#endif

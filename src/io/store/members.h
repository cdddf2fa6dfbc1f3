/* members.h: writes and reads structs as groups of datasets or as attributes, according to the rows
 * of an observable_list. */
#ifndef SLIPDISK_IO_MEMBERS_H
#define SLIPDISK_IO_MEMBERS_H

#include "io/store/h5.h"
#include "measure/observable.h"

/* Writes n structs, which begin at `first` and are `stride` bytes apart, into a group: for each
 * quantity in the list one dataset [n] or [n][width], with unit and description. */
void members_write(h5_file *file, const char *group, const observable_list *list, const void *first,
                   size_t stride, size_t n);
/* Reads n structs from the datasets of a group. Returns SD_ERROR_IO if the first dataset is
 * missing, or if one has another size. Members whose datasets an older file lacks become NAN, or 0
 * if they are integers. */
sd_status members_read(const h5_file *file, const char *group, const observable_list *list,
                       void *first, size_t stride, size_t n, sd_messages *messages);
/* members_write_attrs writes one struct as attributes of the object at path; members_read_attrs
 * reads it. On reading, members whose attributes are missing become NAN, or 0 if they are
 * integers. */
void members_write_attrs(h5_file *file, const char *path, const observable_list *list,
                         const void *row);
void members_read_attrs(const h5_file *file, const char *path, const observable_list *list,
                        void *row);

/* Returns the path that a dataset has in this file, which may be its name in an older format; to be
 * freed. */
char *members_path(const h5_file *file, const char *path);

/* Writes a dataset with unit and description into a group. If data is NULL, since there was no
 * memory, the failure is noted in the file. */
void members_put(h5_file *file, const char *group, const char *name, sd_type type, int rank,
                 const size_t *dims, const void *data, bool compress, const char *unit,
                 const char *meaning);
/* members_write_lines writes n texts as the lines of one text in a dataset; members_read_lines
 * reads them: missing lines become empty, and the caller frees each line. */
void members_write_lines(h5_file *file, const char *path, size_t n, char *const *lines);
void members_read_lines(const h5_file *file, const char *path, size_t n, char **lines);

#endif

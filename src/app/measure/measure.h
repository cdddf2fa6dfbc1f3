/* measure.h: what slipdisk measure has found of one frame, and the forms in which it is told. */
#ifndef SLIPDISK_APP_MEASURE_H
#define SLIPDISK_APP_MEASURE_H

#include <jansson.h>
#include <stdio.h>

#include "io/results/summary.h"
#include "io/store/file.h"
#include "measure/measurement.h"

/* --- measure_page.c ---------------------------------------------------------------------------------- */
void measure_page(FILE *out, const measurement *m);
/* A row per frame. */
void measure_rows_head(FILE *out);
void measure_row(FILE *out, const measurement *m);
json_t *measure_json(const measurement *m);

/* --- measure_page.c: all frames as JSON, one after the other ---------------------------------- */
typedef struct measure_list {
  FILE *out; /* of `file`, else the screen */
  char *name;
  file_stream file;
  size_t stored, n; /* frames in the file, and here */
} measure_list;

/* path (NULL: the screen): of the file, which gets its name when all is written.
 * measure_list_close also when it fails. */
sd_status measure_list_open(measure_list *l, const char *name, size_t stored, const char *path,
                            sd_messages *messages);
void measure_list_add(measure_list *l, const measurement *m);
sd_status measure_list_close(measure_list *l, sd_status status, sd_messages *messages);

/* --- measure_page.c: one file per table in a folder ------------------------------------------- */
#define MEASURE_CONTACT_COLUMNS                                                                    \
  "step,a,b,part,x,y,nx,ny,overlap,force,tau,mobilised,sliding,force_x,force_y,zeta"
/* Rows of these columns: contacts of a frame in which one of the bodies is wanted; NULL: all. */
void measure_contacts(FILE *out, const configuration *c, const bool *wanted);
enum {
  MEASURE_FRAMES,
  MEASURE_DISKS,
  MEASURE_CONTACTS,
  MEASURE_PAIRS,
  MEASURE_FORCES,
  MEASURE_TABLES
};
typedef struct measure_tables {
  file_stream file[MEASURE_TABLES];
  FILE *out[MEASURE_TABLES]; /* of these */
  const bool *wanted;        /* [bodies of the deck] rows of disks and contacts; NULL: all */
} measure_tables;

/* measure_tables_close also when it fails. Files get their names when all is written. */
sd_status measure_tables_open(measure_tables *t, const char *folder, const bool *wanted,
                              sd_messages *messages);
/* Means of the run, over time: rotation.csv of the watched disks, means.csv of every disk, where there are any. */
sd_status measure_tables_means(const char *folder, size_t n_disks, const bool *wanted,
                               const summary *s, sd_messages *messages);
void measure_tables_add(const measure_tables *t, const measurement *m);
sd_status measure_tables_close(measure_tables *t, sd_status status, sd_messages *messages);

#endif

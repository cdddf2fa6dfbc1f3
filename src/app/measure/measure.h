/* measure.h: output of `slipdisk measure` for each measured frame, as text, JSON and CSV. */
#ifndef SLIPDISK_APP_MEASURE_H
#define SLIPDISK_APP_MEASURE_H

#include <jansson.h>
#include <stdio.h>

#include "io/results/summary.h"
#include "io/store/file.h"
#include "measure/measurement.h"

/* --- measure_page.c: text, and JSON of one frame ---------------------------------------------- */
void measure_page(FILE *out, const measurement *m);
/* measure_rows_head prints the head of a table, measure_row one row for one frame. */
void measure_rows_head(FILE *out);
void measure_row(FILE *out, const measurement *m);
json_t *measure_json(const measurement *m);

/* --- measure_page.c: JSON of all frames ------------------------------------------------------- */
typedef struct measure_list {
  FILE *out; /* Output stream: that of `file`, or the standard output */
  char *name;
  file_stream file;
  size_t stored, n; /* Number of frames in the result, number of frames written so far */
} measure_list;

/* Opens the JSON output. name, stored: the measured result and its number of frames. path: the
 * output file, which has a temporary name until it is complete; NULL: the standard output. Call
 * measure_list_close also after an error. */
sd_status measure_list_open(measure_list *l, const char *name, size_t stored, const char *path,
                            sd_messages *messages);
void measure_list_add(measure_list *l, const measurement *m);
sd_status measure_list_close(measure_list *l, sd_status status, sd_messages *messages);

/* --- measure_page.c: CSV tables in a folder --------------------------------------------------- */
#define MEASURE_CONTACT_COLUMNS                                                                    \
  "step,a,b,part,x,y,nx,ny,overlap,force,tau,mobilised,sliding,force_x,force_y,zeta"
/* Writes a row of these columns for each contact of a frame. wanted: [number of bodies] true for
 * the bodies whose contacts are written; NULL: all contacts. */
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
  FILE *out[MEASURE_TABLES]; /* Output streams of the files in `file` */
  /* [number of bodies]: true for bodies that get rows in the tables of disks and contacts; NULL:
   * all bodies */
  const bool *wanted;
} measure_tables;

/* Opens the files of the tables; makes the folder if necessary. Files have temporary names until
 * they are complete. Call measure_tables_close also after an error. */
sd_status measure_tables_open(measure_tables *t, const char *folder, const bool *wanted,
                              sd_messages *messages);
/* Writes time averages over the run, if it has measured any: rotation.csv for the watched disks,
 * means.csv for every disk. */
sd_status measure_tables_means(const char *folder, size_t n_disks, const bool *wanted,
                               const summary *s, sd_messages *messages);
void measure_tables_add(const measure_tables *t, const measurement *m);
sd_status measure_tables_close(measure_tables *t, sd_status status, sd_messages *messages);

#endif

/* summary_doubts.h: reasons to doubt a result that came to its end: beyond a limit of the deck (sd_limits), or not finite.
 * Judged in one place, when the summary is collected, and stored with it: run, info and sweep tell the same. */
#ifndef SLIPDISK_IO_SUMMARY_DOUBTS_H
#define SLIPDISK_IO_SUMMARY_DOUBTS_H

#include "io/store/h5.h"
#include "model/model.h"
#include "model/state.h"

typedef enum doubt_kind {
  DOUBT_RESIDUAL,     /* the energy budget does not close */
  DOUBT_OPEN,         /* watched contacts were open nearly all the time */
  DOUBT_DISPLACEMENT, /* a disk or a prescribed body moved too far in one step */
  DOUBT_FINITE,       /* a number that should be there is none */
  DOUBT_UNSTABLE,     /* dt is beyond the limit of stability */
  DOUBT_KINDS
} doubt_kind;
/* Name, what value and limit are, and what is said of many points of a sweep: "3 points WHOSE". */
extern const struct doubt_row { const char *name, *meaning, *whose; } doubt_kinds[DOUBT_KINDS];

typedef struct summary_doubt {
  char *text; /* one line; NULL: no such doubt */
  double value, limit;
} summary_doubt;

typedef struct summary summary;
struct summary_sums; /* summary.h */
/* Compares the summary with these limits; model, state, sums: of the run, NULL where only the
 * summary is known. */
void summary_judge(summary *s, const sd_limits *limits, const sd_model *model,
                   const sd_state *state, const struct summary_sums *sums);
/* Members farthest and not_finite of summary_sums, from one state. */
double summary_farthest(const sd_state *state);
unsigned summary_not_finite(const sd_state *state);
/* How many; and their texts, joined by "; ", to be freed, never NULL. */
size_t summary_doubts(const summary *s);
char *summary_doubts_text(const summary *s);

void summary_doubts_free(summary *s);
void summary_doubts_write(const summary *s, h5_file *file);
/* Files of older versions have none: these are judged by the limits that held then. */
sd_status summary_doubts_read(summary *s, const h5_file *file, sd_messages *messages);

#endif

/* sweep_private.h: what the files of a sweep share. */
#ifndef SLIPDISK_RUN_SWEEP_PRIVATE_H
#define SLIPDISK_RUN_SWEEP_PRIVATE_H

#include "run/sweep.h"

/* FOLDER/points/NAME with this ending, to be freed. */
char *sweep_point_path(const sweep *s, size_t point, const char *ending);

/* True: two full decks say the same; any_title: but for the title, perhaps. Else the differences are added to those of r. */
bool sweep_compare(sweep_result *r, const char *there, const char *here, bool any_title);
/* Another difference than that of a key. */
void sweep_differ(sweep_result *r, const char *why);
/* The first of them, joined by "; ", to be freed. */
char *sweep_differences_text(const sweep_result *r);
void sweep_differences_free(sweep_result *r);

#endif

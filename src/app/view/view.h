/* view.h: the parts of the command view. */
#ifndef SLIPDISK_APP_VIEW_H
#define SLIPDISK_APP_VIEW_H

#include "app/app.h"

typedef struct view_options {
  const char *name, *output, *frames;
  option_list overrides;
  bool open, live;
  long threads;
} view_options;

/* view_file.c: what a run has left. *path: of the page, to be freed; made: it is there. */
sd_status view_file(const view_options *o, char **path, bool *made, sd_messages *messages);
/* view_deck.c: a run before it begins. A deck with mistakes is SD_ERROR_USER, and has a page if it can be shown. */
sd_status view_deck(const view_options *o, char **path, bool *made, sd_messages *messages);

#endif

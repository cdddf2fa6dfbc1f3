/* view_page.h: the viewer's page, with the numbers it shows written into it piece by piece. */
#ifndef SLIPDISK_APP_VIEW_PAGE_H
#define SLIPDISK_APP_VIEW_PAGE_H

#include "app/view/view_chunk.h"
#include "io/store/file.h"

/* src/app/viewer in one text, ending in 0; made by tools/cmake/embed.cmake. */
extern const unsigned char viewer_page[];

/* Writes the page without its numbers, but with what is told about the run. False: out has an
 * error. */
bool view_page_head(FILE *out, const json_t *meta);
bool view_page_tail(FILE *out);

typedef struct view_page {
  file_stream file;
  size_t bytes; /* of chunks */
} view_page;

/* Under a name of its own until it is complete. view_page_close also when it fails. */
sd_status view_page_open(view_page *p, const char *path, const json_t *meta, sd_messages *messages);
/* Adds the chunk and frees it, also when it fails. */
sd_status view_page_add(view_page *p, const char *name, view_chunk *c, sd_messages *messages);
/* As file_stream_close. */
sd_status view_page_close(view_page *p, sd_status status, sd_messages *messages);

/* Opens a page or an address in the browser, which is not waited for; says so when there is none. */
sd_status view_open(const char *page, sd_messages *messages);

#endif

/* live.h: a running simulation, shown in a browser on this machine.
 *
 * The thread that steps calls live_look between pieces of steps. It only reads, and only now and then: the time that it takes
 * is a small part of that in between. A thread of the server answers from what live_look has put down.
 *
 * The server listens on 127.0.0.1 alone, on a port that the system chooses. It answers only requests whose path begins
 * with a random token of 128 bits, and only to GET. */
#ifndef SLIPDISK_APP_LIVE_H
#define SLIPDISK_APP_LIVE_H

#include "slipdisk/simulation.h"

typedef struct live live;

/* source: name of the deck or the result. The model must outlive it. SD_ERROR_IO: no port, or no memory; SD_ERROR_USER: this build has
 * no server. */
sd_status live_open(const sd_model *model, const char *source, live **out, sd_messages *messages);
/* "http://127.0.0.1:PORT/TOKEN/" */
const char *live_address(const live *l);
/* When the run is over it puts down the last state. */
void live_look(live *l, sd_simulation *simulation);
/* A page that is open may still ask for the end; NULL is allowed. */
void live_close(live *l);

#endif

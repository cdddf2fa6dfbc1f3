/* live_private.h: what the two threads of live.h share. */
#ifndef SLIPDISK_APP_LIVE_PRIVATE_H
#define SLIPDISK_APP_LIVE_PRIVATE_H

#include <pthread.h>
#include <stdatomic.h>

#include "app/view/live.h"
#include "app/view/view_chunk.h"
#include "io/results/record.h"
#include "measure/configuration.h"

/* A copy of the state that is never changed. */
typedef struct live_frame {
  frame_data data;
  atomic_int users;
} live_frame;

typedef struct live_status {
  int64_t step, steps, phase;
  double time, rate;      /* steps per second, lately */
  bool finished, stopped; /* before its end */
} live_status;

enum { LIVE_TOKEN = 32 }; /* hexadecimal digits */

struct live {
  const sd_model *model;
  json_t *meta; /* not changed after live_open, like what is above */
  char token[LIVE_TOKEN + 1], address[96];
  struct live_server *server;
  struct stranger *oldest, *newest; /* connections that have not shown the key; of the server's thread */
  size_t strangers;

  atomic_bool wanted;   /* a newer frame */
  _Atomic double asked; /* when something was last asked for; clock_seconds */
  atomic_bool told_end; /* a page knows that the run is over */

  pthread_mutex_t lock; /* of what follows */
  live_frame *frame;    /* newest; NULL: none yet */
  record rows;          /* its series */
  live_status status;

  double next_frame, next_row, rate_at; /* of the stepping thread */
  int64_t rate_step;
};

/* live_server.c. Makes token and address. */
sd_status live_server_start(live *l, sd_messages *messages);
void live_server_stop(live *l);

/* live.c, for the server's thread. */
live_frame *live_frame_take(live *l, int64_t after); /* NULL: none is newer */
void live_frame_release(live_frame *f);
live_status live_status_now(live *l);
/* Rows from number *from on, or from 0 where these are gone, in a chunk; false: there are none. */
bool live_rows(live *l, int64_t *from, view_chunk *c);

#endif

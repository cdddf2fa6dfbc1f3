/* live.c: see live.h: what the stepping thread does. */
#include "app/view/live.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/view/live_private.h"
#include "app/view/view_data.h"
#include "app/view/view_series.h"
#include "base/clock.h"
#include "base/memory.h"
#include "run/simulation_private.h"

/* Between two copies: so long, or so many times what the last one took. */
static const double FRAME_SECONDS = 0.1, ROW_SECONDS = 0.2, ROW_SECONDS_ALONE = 1, COST = 300;
/* A page asks several times a second. */
static const double PRESENT_SECONDS = 3, LINGER_SECONDS = 2;
static const double RATE_SECONDS = 0.5;

void live_frame_release(live_frame *f) {
  if (!f || atomic_fetch_sub(&f->users, 1) > 1) return;
  frame_data_free(&f->data);
  free(f);
}

static bool is_present(live *l) { return clock_seconds() - atomic_load(&l->asked) < PRESENT_SECONDS; }

/* --- stepping thread -------------------------------------------------------------------------------- */

static void put_frame(live *l, const sd_state *state) {
  live_frame *f = memory_new(1, sizeof *f);
  atomic_init(&f->users, 1);
  if (frame_data_of_state(&f->data, l->model, state, NULL) != SD_OK) {
    live_frame_release(f);
    return;
  }
  view_turns(&f->data, l->model, NULL);
  live_frame *old = l->frame;
  l->frame = f;
  live_frame_release(old);
  atomic_store(&l->wanted, false);
}

/* Every second row goes when there are many. */
static void thin(table *t) {
  for (size_t c = 0; c < t->n_columns; c++) {
    size_t size = t->columns[c].width * sd_type_size(t->columns[c].type);
    unsigned char *data = t->columns[c].data;
    for (size_t k = 1; 2 * k < t->n_rows; k++) memcpy(data + k * size, data + 2 * k * size, size);
  }
  t->n_rows = (t->n_rows + 1) / 2;
}

static void put_row(live *l, sd_simulation *s, const sd_state *state) {
  table *t = &l->rows.series;
  int64_t last = -1;
  if (t->n_rows > 0) memcpy(&last, t->columns[0].data + (t->n_rows - 1) * sizeof last, sizeof last);
  if (last == state->step) return;
  const record_sums now = {.energy = sd_simulation_energy(s)};
  record_sample(&l->rows, RECORD_SERIES, state, simulation_slots(s), &now, NULL);
  if (t->n_rows >= 2 * VIEW_MOST_ROWS) thin(t);
}

static void put_status(live *l, sd_simulation *s, double now) {
  sd_stage stage = sd_simulation_stage(s);
  live_status *status = &l->status;
  status->step = stage.step;
  status->phase = stage.phase;
  status->time = sd_simulation_time(s);
  status->finished = sd_simulation_finished(s);
  if (now - l->rate_at < RATE_SECONDS) return;
  if (l->rate_at > 0) status->rate = (double)(stage.step - l->rate_step) / (now - l->rate_at);
  l->rate_at = now;
  l->rate_step = stage.step;
}

/* The stepping thread does not wait for the other one, except at the end. */
static bool lock(live *l, bool wait) {
  return wait ? pthread_mutex_lock(&l->lock) == 0 : pthread_mutex_trylock(&l->lock) == 0;
}

void live_look(live *l, sd_simulation *s) {
  double now = clock_seconds();
  bool end = sd_simulation_finished(s);
  bool frame = end || (atomic_load(&l->wanted) && now >= l->next_frame), row = end || now >= l->next_row;
  if (!lock(l, end)) return;
  put_status(l, s, now);
  const sd_state *state = frame || row ? sd_simulation_state(s) : NULL;
  double begun = clock_seconds();
  if (state && frame) put_frame(l, state);
  double between = clock_seconds();
  if (state && row) put_row(l, s, state);
  pthread_mutex_unlock(&l->lock);
  double done = clock_seconds();
  /* the contacts of the state are part of both */
  if (frame) l->next_frame = done + fmax(FRAME_SECONDS, COST * (between - now));
  if (row)
    l->next_row =
        done + fmax(is_present(l) ? ROW_SECONDS : ROW_SECONDS_ALONE, COST * (done - between + begun - now));
}

/* --- server's thread -------------------------------------------------------------------------------- */

live_frame *live_frame_take(live *l, int64_t after) {
  pthread_mutex_lock(&l->lock);
  live_frame *f = l->frame && l->frame->data.step > after ? l->frame : NULL;
  if (f) atomic_fetch_add(&f->users, 1);
  pthread_mutex_unlock(&l->lock);
  return f;
}

live_status live_status_now(live *l) {
  pthread_mutex_lock(&l->lock);
  live_status status = l->status;
  pthread_mutex_unlock(&l->lock);
  return status;
}

typedef struct teller {
  const table *t;
  size_t from;
  view_chunk *c;
} teller;

static void add_series(void *user, const observable *o, size_t column, size_t k, const char *name) {
  teller *p = user;
  (void)o;
  const table_column *c = &p->t->columns[column];
  const unsigned char *data = c->data + (p->from * c->width + k) * sd_type_size(c->type);
  view_chunk_add(p->c, name, VIEW_EXACT, c->type, data, p->t->n_rows - p->from, c->width);
}

bool live_rows(live *l, int64_t *from, view_chunk *c) {
  pthread_mutex_lock(&l->lock);
  teller p = {.t = &l->rows.series, .c = c};
  if (*from < 0 || (uint64_t)*from > p.t->n_rows) *from = 0;
  p.from = (size_t)*from;
  bool any = p.from < p.t->n_rows;
  if (any) {
    view_chunk_begin(c, false);
    const double *time = (const double *)(const void *)p.t->columns[1].data;
    view_chunk_add(c, "time", VIEW_EXACT, SD_F64, time + p.from, p.t->n_rows - p.from, 1);
    view_series_each(l->model, NULL, add_series, &p);
  }
  pthread_mutex_unlock(&l->lock);
  return any;
}

/* --- beginning and end ------------------------------------------------------------------------------ */

static void prepare(live *l, const char *source) {
  const sd_model *m = l->model;
  l->meta = view_meta(m, "live", m->title, source);
  view_series_each(m, l->meta, NULL, NULL);
  view_meta_phases(l->meta, m);
  json_object_set_new(l->meta, "frames", json_integer(0));
  l->status.steps = sd_model_steps(m);
  record_new(&l->rows, m, false);
}

sd_status live_open(const sd_model *model, const char *source, live **out, sd_messages *messages) {
  *out = NULL;
  live *l = memory_new(1, sizeof *l);
  l->model = model;
  pthread_mutex_init(&l->lock, NULL);
  atomic_init(&l->asked, -HUGE_VAL);
  prepare(l, source);
  const sd_status status = live_server_start(l, messages);
  if (status == SD_OK)
    *out = l;
  else
    live_close(l);
  return status;
}

const char *live_address(const live *l) { return l->address; }

void live_close(live *l) {
  if (!l) return;
  pthread_mutex_lock(&l->lock);
  l->status.stopped = !l->status.finished;
  pthread_mutex_unlock(&l->lock);
  double until = clock_seconds() + LINGER_SECONDS;
  while (l->server && is_present(l) && !atomic_load(&l->told_end) && clock_seconds() < until) {
    const struct timespec nap = {.tv_nsec = 20000000};
    nanosleep(&nap, NULL);
  }
  live_server_stop(l);
  live_frame_release(l->frame);
  record_free(&l->rows);
  pthread_mutex_destroy(&l->lock);
  json_decref(l->meta);
  free(l);
}

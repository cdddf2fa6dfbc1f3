/* live.c: a server that shows a running simulation in a browser; see view.h. The stepping thread
 * copies the state; the server's thread answers requests from these copies. */
#include "app/view/view.h"

#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef SD_HAVE_MICROHTTPD
#include <arpa/inet.h>
#include <errno.h>
#include <inttypes.h>
#include <microhttpd.h>
#include <signal.h>
#include <strings.h>
#include <sys/resource.h>
#include <unistd.h>
#endif

#include "base/team.h"
#include "base/memory.h"
#include "io/results/record.h"
#include "measure/configuration.h"
#include "model/model.h"
#include "run/simulation_private.h"

/* Copy of the state, which is not changed after it is made; users: number of references to it. */
typedef struct live_frame {
  frame_data data;
  atomic_int users;
} live_frame;

typedef struct live_status {
  int64_t step, steps, phase;
  double time, rate;      /* Model time; recent number of steps per second of wall time */
  bool finished, stopped; /* finished: the run is over; stopped: it ended before its last step */
} live_status;

enum { LIVE_TOKEN = 32 }; /* Number of hexadecimal digits of the token */

struct live {
  const sd_model *model;
  /* JSON with the data that every run has; like `model` not changed after live_open */
  json_t *meta;
  char token[LIVE_TOKEN + 1], address[96];
  struct live_server *server;
  /* List of connections that have not sent the token yet; used by the server's thread only */
  struct stranger *oldest, *newest;
  size_t strangers;

  atomic_bool wanted;   /* True: a page has asked for a newer frame */
  _Atomic double asked; /* Clock reading at the last request of a page, s */
  atomic_bool told_end; /* True: a page has received the news that the run is over */

  pthread_mutex_t lock; /* Lock for the members frame, rows and status */
  live_frame *frame;    /* Newest frame; NULL: none yet */
  record rows;          /* Rows of the time series since the start of the run */
  live_status status;

  /* Clock readings in s, used by the stepping thread only: time at which the next frame is due,
   * time at which the next row is due, time at which the rate was last computed */
  double next_frame, next_row, rate_at;
  int64_t rate_step;
};

/* Limits of the cost of copying. Shortest time between two frames (FRAME_SECONDS) and between two
 * rows (ROW_SECONDS; ROW_SECONDS_ALONE while no page is open), s. COST: shortest time between two
 * copies divided by the duration of the last one. */
static const double FRAME_SECONDS = 0.1, ROW_SECONDS = 0.2, ROW_SECONDS_ALONE = 1, COST = 300;
/* Times in s. PRESENT_SECONDS: a page counts as open for this long after its last request (it sends
 * several in a second). LINGER_SECONDS: longest wait at the end of the run for a page to fetch the
 * last state. */
static const double PRESENT_SECONDS = 3, LINGER_SECONDS = 2;
static const double RATE_SECONDS = 0.5;

static void live_frame_release(live_frame *f) {
  if (!f || atomic_fetch_sub(&f->users, 1) > 1) return;
  frame_data_free(&f->data);
  free(f);
}

static bool is_present(live *l) {
  return clock_seconds() - atomic_load(&l->asked) < PRESENT_SECONDS;
}

/* --- stepping thread -------------------------------------------------------------------------- */

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

/* Removes every second row of a table. */
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

/* Takes the lock l->lock. Without `wait` returns false if the server's thread holds it. The
 * stepping thread sets `wait` only at the end of the run. */
static bool lock(live *l, bool wait) {
  return wait ? pthread_mutex_lock(&l->lock) == 0 : pthread_mutex_trylock(&l->lock) == 0;
}

void live_look(live *l, sd_simulation *s) {
  double now = clock_seconds();
  bool end = sd_simulation_finished(s);
  bool frame = end || (atomic_load(&l->wanted) && now >= l->next_frame),
       row = end || now >= l->next_row;
  if (!lock(l, end)) return;
  put_status(l, s, now);
  const sd_state *state = frame || row ? sd_simulation_state(s) : NULL;
  double begun = clock_seconds();
  if (state && frame) put_frame(l, state);
  double between = clock_seconds();
  if (state && row) put_row(l, s, state);
  pthread_mutex_unlock(&l->lock);
  double done = clock_seconds();
  /* The time to get the state with its contacts counts for the next frame and for the next row. */
  if (frame) l->next_frame = done + fmax(FRAME_SECONDS, COST * (between - now));
  if (row)
    l->next_row = done + fmax(is_present(l) ? ROW_SECONDS : ROW_SECONDS_ALONE,
                              COST * (done - between + begun - now));
}

#ifdef SD_HAVE_MICROHTTPD

/* --- thread of the server --------------------------------------------------------------------- */

/* Returns the newest frame if its step is greater than `after`, else NULL. The caller gives it back
 * with live_frame_release. */
static live_frame *live_frame_take(live *l, int64_t after) {
  pthread_mutex_lock(&l->lock);
  live_frame *f = l->frame && l->frame->data.step > after ? l->frame : NULL;
  if (f) atomic_fetch_add(&f->users, 1);
  pthread_mutex_unlock(&l->lock);
  return f;
}

static live_status live_status_now(live *l) {
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

/* Makes a chunk of the rows from row number *from on. If there are fewer rows, because they were
 * thinned out, sets *from = 0 and begins there. Returns false if there are no rows. */
static bool live_rows(live *l, int64_t *from, view_chunk *c) {
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

typedef struct MHD_Connection connection;

/* HTTP answer; bytes = NULL: it consists of a status only. */
typedef struct answer {
  unsigned status;
  const char *type;
  unsigned char *bytes; /* Body of the answer; libmicrohttpd frees it */
  size_t size;
} answer;

static const char binary[] = "application/octet-stream", text[] = "application/json",
                  page[] = "text/html; charset=utf-8";

/* HTTP headers of all answers. They allow the page to send requests to this server only, and forbid
 * that other pages show it or learn its address. */
static const struct {
  const char *name, *value;
} headers[] = {
    {"Cache-Control", "no-store"},
    {"Referrer-Policy", "no-referrer"},
    {"X-Content-Type-Options", "nosniff"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Content-Security-Policy",
     "default-src 'none'; script-src 'unsafe-inline' blob:; worker-src blob:; "
     "style-src 'unsafe-inline'; img-src data: blob:; connect-src 'self'; "
     "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"},
};

/* --- requests --------------------------------------------------------------------------------- */

static int64_t argument(connection *c, const char *name, int64_t otherwise) {
  const char *value = MHD_lookup_connection_value(c, MHD_GET_ARGUMENT_KIND, name);
  char *end;
  if (!value) return otherwise;
  errno = 0;
  int64_t number = strtoll(value, &end, 10);
  return errno == 0 && end != value && !*end ? number : otherwise;
}

/* Makes an answer from a chunk of numbers, uncompressed, since it does not leave this machine. */
static answer of_chunk(view_chunk *c) {
  answer a = {.status = MHD_HTTP_OK, .type = binary};
  if (view_chunk_end(c, 0, &a.bytes, &a.size, NULL) != SD_OK)
    a.status = MHD_HTTP_INTERNAL_SERVER_ERROR;
  return a;
}

static answer of_json(json_t *object) {
  char *bytes = json_dumps(object, JSON_COMPACT | JSON_REAL_PRECISION(17));
  return (answer){MHD_HTTP_OK, text, (unsigned char *)bytes, strlen(bytes)};
}

static answer get_page(live *l, connection *c) {
  (void)c;
  char *bytes = NULL;
  size_t size = 0;
  FILE *out = open_memstream(&bytes, &size);
  if (!out) memory_lacks(0);
  const bool good = view_page_head(out, l->meta) && view_page_tail(out);
  if (fclose(out) != 0 || !good) memory_lacks(size);
  return (answer){MHD_HTTP_OK, page, (unsigned char *)bytes, size};
}

static answer get_meta(live *l, connection *c) {
  (void)c;
  return of_json(l->meta);
}

static answer get_static(live *l, connection *c) {
  (void)c;
  view_chunk chunk;
  view_static(&chunk, l->model, NULL, NULL, false);
  return of_chunk(&chunk);
}

static answer get_series(live *l, connection *c) {
  int64_t from = argument(c, "from", 0);
  view_chunk chunk;
  if (!live_rows(l, &from, &chunk)) return (answer){.status = MHD_HTTP_NO_CONTENT};
  json_object_set_new(chunk.head, "from", json_integer(from));
  return of_chunk(&chunk);
}

static answer get_frame(live *l, connection *c) {
  live_frame *f = live_frame_take(l, argument(c, "after", -1));
  atomic_store(&l->wanted, true);
  if (!f) return (answer){.status = MHD_HTTP_NO_CONTENT};
  view_chunk chunk;
  view_frame(&chunk, l->model, &f->data, false);
  live_frame_release(f);
  return of_chunk(&chunk);
}

static answer get_status(live *l, connection *c) {
  (void)c;
  live_status s = live_status_now(l);
  bool running = s.phase < (int64_t)l->model->n_phases;
  const char *phase = running ? l->model->phases[s.phase].name : NULL;
  json_t *object =
      json_pack("{s:I, s:I, s:f, s:f, s:s, s:b, s:b}", "step", (json_int_t)s.step, "steps",
                (json_int_t)s.steps, "time", s.time, "rate", s.rate, "phase", phase ? phase : "",
                "finished", (int)s.finished, "stopped", (int)s.stopped);
  if (s.finished || s.stopped) atomic_store(&l->told_end, true);
  answer a = of_json(object);
  json_decref(object);
  return a;
}

static const struct resource {
  const char *name;
  answer (*get)(live *l, connection *c);
} resources[] = {{"", get_page},         {"meta", get_meta},   {"static", get_static},
                 {"series", get_series}, {"frame", get_frame}, {"status", get_status}};

/* --- connections that have not shown the token ------------------------------------------------ */

/* Limits for connections. STRANGERS connections that have not sent the token may wait, for
 * SECONDS_WITHOUT seconds each; a further one replaces the oldest, so that they can never keep out
 * a client with the token. A connection that has sent the token may be idle for SECONDS_WITH
 * seconds. CONNECTIONS: largest number of all connections. */
enum { STRANGERS = 16, CONNECTIONS = 64, SECONDS_WITHOUT = 2, SECONDS_WITH = 10 };

typedef struct stranger {
  struct stranger *older, *newer;
  int socket;
  bool listed;
} stranger;

static void unlist(live *l, stranger *s) {
  if (!s->listed) return;
  *(s->older ? &s->older->newer : &l->oldest) = s->newer;
  *(s->newer ? &s->newer->older : &l->newest) = s->older;
  s->listed = false;
  l->strangers--;
}

static void list(live *l, stranger *s) {
  s->older = l->newest;
  *(l->newest ? &l->newest->newer : &l->oldest) = s;
  l->newest = s;
  s->listed = true;
  if (++l->strangers <= STRANGERS) return;
  /* After shutdown libmicrohttpd sees the end of the connection and closes it */
  shutdown(l->oldest->socket, SHUT_RDWR);
  unlist(l, l->oldest);
}

static void connection_notice(void *user, connection *c, void **context,
                              enum MHD_ConnectionNotificationCode what) {
  live *l = user;
  if (what == MHD_CONNECTION_NOTIFY_STARTED) {
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(c, MHD_CONNECTION_INFO_CONNECTION_FD);
    *context = NULL;
    if (!info) return;
    stranger *s = *context = memory_new(1, sizeof *s);
    s->socket = info->connect_fd;
    list(l, s);
  } else if (*context) {
    unlist(l, *context);
    free(*context);
    *context = NULL;
  }
}

static void key_was_shown(live *l, connection *c) {
  const union MHD_ConnectionInfo *info =
      MHD_get_connection_info(c, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
  stranger *s = info ? info->socket_context : NULL;
  if (!s || !s->listed) return;
  unlist(l, s);
  MHD_set_connection_option(c, MHD_CONNECTION_OPTION_TIMEOUT, (unsigned)SECONDS_WITH);
}

/* --- authorisation ---------------------------------------------------------------------------- */

/* Headers that say for whom a request is and where it ends, each allowed once. */
enum { HOST, LENGTH, CODING, SINGLE };
typedef struct single_headers {
  unsigned count[SINGLE];
  const char *host;
} single_headers;

static enum MHD_Result note_header(void *user, enum MHD_ValueKind kind, const char *key,
                                   const char *value) {
  static const char *const names[SINGLE] = {"Host", "Content-Length", "Transfer-Encoding"};
  single_headers *h = user;
  (void)kind;
  for (size_t k = 0; k < SINGLE; k++) {
    if (strcasecmp(key, names[k]) != 0) continue;
    h->count[k]++;
    if (k == HOST) h->host = value;
  }
  return MHD_YES;
}

/* Returns 0, or the status with which a request is refused for its headers. A host that is no name
 * of this machine itself can reach this server only by DNS rebinding, an attack. Any port is
 * allowed, since a tunnel may have another one. */
static unsigned refused(connection *c) {
  static const char *const own[] = {"127.0.0.1", "localhost"};
  single_headers h = {0};
  MHD_get_connection_values(c, MHD_HEADER_KIND, note_header, &h);
  if (h.count[HOST] != 1 || h.count[LENGTH] + h.count[CODING] > 1 || !h.host)
    return MHD_HTTP_BAD_REQUEST;
  const size_t name = strcspn(h.host, ":");
  const char *port = h.host + name + (h.host[name] == ':');
  if (h.host[0] != '[' && strspn(port, "0123456789") != strlen(port)) return MHD_HTTP_BAD_REQUEST;
  for (size_t k = 0; k < sizeof own / sizeof *own; k++)
    if (strlen(own[k]) == name && strncasecmp(h.host, own[k], name) == 0) return 0;
  return MHD_HTTP_FORBIDDEN;
}

/* Compares a word with the token, in a time that does not depend on which digit differs. */
static bool is_token(const live *l, const char *word) {
  unsigned char different = 0;
  for (size_t k = 0; k < LIVE_TOKEN; k++) {
    different |= (unsigned char)(word[k] ^ l->token[k]);
    if (!word[k]) return false;
  }
  return different == 0;
}

/* Finds the resource that a path "/TOKEN/NAME" names; NULL: the token or the name is wrong. */
static const struct resource *find(const live *l, const char *url) {
  if (url[0] != '/' || !is_token(l, url + 1) || url[1 + LIVE_TOKEN] != '/') return NULL;
  for (size_t k = 0; k < sizeof resources / sizeof *resources; k++)
    if (strcmp(url + LIVE_TOKEN + 2, resources[k].name) == 0) return &resources[k];
  return NULL;
}

static enum MHD_Result send_answer(connection *c, answer a) {
  struct MHD_Response *r = MHD_create_response_from_buffer(a.size, a.bytes, MHD_RESPMEM_MUST_FREE);
  if (!r) {
    free(a.bytes);
    return MHD_NO;
  }
  for (size_t k = 0; k < sizeof headers / sizeof *headers; k++)
    MHD_add_response_header(r, headers[k].name, headers[k].value);
  if (a.type) MHD_add_response_header(r, "Content-Type", a.type);
  enum MHD_Result result = MHD_queue_response(c, a.status, r);
  MHD_destroy_response(r);
  return result;
}

static enum MHD_Result serve(void *user, connection *c, const char *url, const char *method,
                             const char *version, const char *upload, size_t *upload_size,
                             void **state) {
  live *l = user;
  (void)version, (void)upload;
  /* Only the headers have arrived in the first call, and an answer ends the connection, as is right
   * where it is not clear where the request ends */
  if (!*state) {
    *state = l;
    const unsigned status = refused(c);
    return status ? send_answer(c, (answer){.status = status}) : MHD_YES;
  }
  if (*upload_size > 0) { /* Skip the body of a request */
    *upload_size = 0;
    return MHD_YES;
  }
  const struct resource *one = find(l, url);
  if (!one) return send_answer(c, (answer){.status = MHD_HTTP_NOT_FOUND});
  key_was_shown(l, c);
  if (strcmp(method, "GET") != 0)
    return send_answer(c, (answer){.status = MHD_HTTP_METHOD_NOT_ALLOWED});
  atomic_store(&l->asked, clock_seconds());
  return send_answer(c, one->get(l, c));
}

/* --- start and stop of the server ------------------------------------------------------------- */

static bool make_token(live *l) {
  unsigned char bytes[LIVE_TOKEN / 2];
  if (getentropy(bytes, sizeof bytes) != 0) return false;
  for (size_t k = 0; k < sizeof bytes; k++) snprintf(l->token + 2 * k, 3, "%02x", bytes[k]);
  return true;
}

/* Starts the server's thread with all signals blocked, so that the stepping thread gets them. */
static struct MHD_Daemon *start(live *l, const struct sockaddr_in *at) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  struct MHD_Daemon *d = MHD_start_daemon(
      MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_POLL, 0, NULL, NULL, serve, l, MHD_OPTION_SOCK_ADDR,
      at, MHD_OPTION_CONNECTION_LIMIT, (unsigned)CONNECTIONS, MHD_OPTION_NOTIFY_CONNECTION,
      connection_notice, l, MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)SECONDS_WITHOUT,
      MHD_OPTION_CONNECTION_MEMORY_LIMIT, (size_t)32768, MHD_OPTION_SIGPIPE_HANDLED_BY_APP, 1,
      MHD_OPTION_END);
  int trouble = errno;
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  errno = trouble;
  return d;
}

static sd_status live_server_start(live *l, sd_messages *messages) {
  struct sockaddr_in at = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
  if (!make_token(l))
    return sd_fail(messages, SD_ERROR_IO, "--live: no random numbers: %s", strerror(errno));
  struct MHD_Daemon *d = start(l, &at);
  const union MHD_DaemonInfo *port = d ? MHD_get_daemon_info(d, MHD_DAEMON_INFO_BIND_PORT) : NULL;
  if (!port || port->port == 0) {
    int trouble = errno;
    if (d) MHD_stop_daemon(d);
    return sd_fail(messages, SD_ERROR_IO, "--live: no port of 127.0.0.1 can be had: %s",
                   strerror(trouble));
  }
  l->server = (struct live_server *)d;
  snprintf(l->address, sizeof l->address, "http://127.0.0.1:%u/%s/", (unsigned)port->port,
           l->token);
  return SD_OK;
}

static void live_server_stop(live *l) {
  if (l->server) MHD_stop_daemon((struct MHD_Daemon *)l->server);
  l->server = NULL;
}

#else

static sd_status live_server_start(live *l, sd_messages *messages) {
  (void)l;
  return sd_fail(messages, SD_ERROR_USER,
                 "--live: this build has no server: libmicrohttpd was not there when it was made");
}

static void live_server_stop(live *l) { (void)l; }

#endif

/* --- beginning and end ------------------------------------------------------------------------ */

static void prepare(live *l, const char *source) {
  const sd_model *m = l->model;
  l->meta = view_meta(m, "live", m->title, source);
  view_series_each(m, l->meta, NULL, NULL);
  view_meta_phases(l->meta, m);
  json_object_set_new(l->meta, "frames", json_integer(0));
  l->status.steps = sd_model_steps(m);
  record_new(&l->rows, m, RECORD_WHOLE);
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

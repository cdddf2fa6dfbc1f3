/* live_server.c: see live.h: the thread that answers, by libmicrohttpd. */
#include <string.h>

#include "app/view/live_private.h"

#ifdef SD_HAVE_MICROHTTPD
#include <arpa/inet.h>
#include <errno.h>
#include <inttypes.h>
#include <microhttpd.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <unistd.h>

#include "app/view/view_data.h"
#include "app/view/view_page.h"
#include "base/clock.h"
#include "base/memory.h"

typedef struct MHD_Connection connection;

/* An answer; bytes NULL: nothing but the status. */
typedef struct answer {
  unsigned status;
  const char *type;
  unsigned char *bytes; /* to be freed */
  size_t size;
} answer;

static const char binary[] = "application/octet-stream", text[] = "application/json",
                  page[] = "text/html; charset=utf-8";

/* The page speaks with this server alone, and no other page may show it or learn its address. */
static const struct {
  const char *name, *value;
} headers[] = {
    {"Cache-Control", "no-store"},
    {"Referrer-Policy", "no-referrer"},
    {"X-Content-Type-Options", "nosniff"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Content-Security-Policy", "default-src 'none'; script-src 'unsafe-inline' blob:; worker-src blob:; "
                                "style-src 'unsafe-inline'; img-src data: blob:; connect-src 'self'; "
                                "frame-ancestors 'none'; base-uri 'none'; form-action 'none'"},
};

/* --- what is asked for ------------------------------------------------------------------------------ */

static int64_t argument(connection *c, const char *name, int64_t otherwise) {
  const char *value = MHD_lookup_connection_value(c, MHD_GET_ARGUMENT_KIND, name);
  char *end;
  if (!value) return otherwise;
  errno = 0;
  int64_t number = strtoll(value, &end, 10);
  return errno == 0 && end != value && !*end ? number : otherwise;
}

/* Nothing is packed: it goes to this machine. */
static answer of_chunk(view_chunk *c) {
  answer a = {.status = MHD_HTTP_OK, .type = binary};
  if (view_chunk_end(c, 0, &a.bytes, &a.size, NULL) != SD_OK) a.status = MHD_HTTP_INTERNAL_SERVER_ERROR;
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
  json_t *object = json_pack("{s:I, s:I, s:f, s:f, s:s, s:b, s:b}", "step", (json_int_t)s.step, "steps",
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

/* --- connections that have not shown the key ---------------------------------------------------------- */

/* So many may wait with half a request, for so many seconds. A further one takes the place of the oldest, so that they
 * never keep out who has the key. With it a connection may rest for longer. */
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
  shutdown(l->oldest->socket, SHUT_RDWR); /* the server sees its end, and closes it */
  unlist(l, l->oldest);
}

static void connection_notice(void *user, connection *c, void **context,
                              enum MHD_ConnectionNotificationCode what) {
  live *l = user;
  if (what == MHD_CONNECTION_NOTIFY_STARTED) {
    const union MHD_ConnectionInfo *info = MHD_get_connection_info(c, MHD_CONNECTION_INFO_CONNECTION_FD);
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
  const union MHD_ConnectionInfo *info = MHD_get_connection_info(c, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
  stranger *s = info ? info->socket_context : NULL;
  if (!s || !s->listed) return;
  unlist(l, s);
  MHD_set_connection_option(c, MHD_CONNECTION_OPTION_TIMEOUT, (unsigned)SECONDS_WITH);
}

/* --- who asks --------------------------------------------------------------------------------------- */

/* A name that is not this machine's own leads here only by a trick (DNS rebinding). Another port is that of a tunnel. */
static bool is_own_host(const char *host) {
  static const char *const own[] = {"127.0.0.1", "localhost"};
  for (size_t k = 0; host && k < 2; k++) {
    size_t n = strlen(own[k]);
    if (strncmp(host, own[k], n) == 0 && (host[n] == 0 || host[n] == ':')) return true;
  }
  return false;
}

/* Takes as long whatever is wrong. */
static bool is_token(const live *l, const char *word) {
  unsigned char different = 0;
  for (size_t k = 0; k < LIVE_TOKEN; k++) {
    different |= (unsigned char)(word[k] ^ l->token[k]);
    if (!word[k]) return false;
  }
  return different == 0;
}

/* "/TOKEN/NAME" */
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
                             const char *version, const char *upload, size_t *upload_size, void **state) {
  live *l = user;
  (void)version, (void)upload;
  if (!*state) { /* the head has come; an answer now would end the connection */
    *state = l;
    return MHD_YES;
  }
  if (*upload_size > 0) { /* a body is not read */
    *upload_size = 0;
    return MHD_YES;
  }
  if (!is_own_host(MHD_lookup_connection_value(c, MHD_HEADER_KIND, "Host")))
    return send_answer(c, (answer){.status = MHD_HTTP_FORBIDDEN});
  const struct resource *one = find(l, url);
  if (!one) return send_answer(c, (answer){.status = MHD_HTTP_NOT_FOUND});
  key_was_shown(l, c);
  if (strcmp(method, "GET") != 0) return send_answer(c, (answer){.status = MHD_HTTP_METHOD_NOT_ALLOWED});
  atomic_store(&l->asked, clock_seconds());
  return send_answer(c, one->get(l, c));
}

/* --- beginning and end ------------------------------------------------------------------------------ */

static bool make_token(live *l) {
  unsigned char bytes[LIVE_TOKEN / 2];
  if (getentropy(bytes, sizeof bytes) != 0) return false;
  for (size_t k = 0; k < sizeof bytes; k++) snprintf(l->token + 2 * k, 3, "%02x", bytes[k]);
  return true;
}

/* Signals are for the thread that steps. */
static struct MHD_Daemon *start(live *l, const struct sockaddr_in *at) {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  struct MHD_Daemon *d = MHD_start_daemon(
      MHD_USE_INTERNAL_POLLING_THREAD | MHD_USE_POLL, 0, NULL, NULL, serve, l, MHD_OPTION_SOCK_ADDR, at,
      MHD_OPTION_CONNECTION_LIMIT, (unsigned)CONNECTIONS, MHD_OPTION_NOTIFY_CONNECTION, connection_notice, l,
      MHD_OPTION_CONNECTION_TIMEOUT, (unsigned)SECONDS_WITHOUT, MHD_OPTION_CONNECTION_MEMORY_LIMIT,
      (size_t)32768, MHD_OPTION_SIGPIPE_HANDLED_BY_APP, 1, MHD_OPTION_END);
  int trouble = errno;
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  errno = trouble;
  return d;
}

sd_status live_server_start(live *l, sd_messages *messages) {
  struct sockaddr_in at = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
  if (!make_token(l)) return sd_fail(messages, SD_ERROR_IO, "--live: no random numbers: %s", strerror(errno));
  struct MHD_Daemon *d = start(l, &at);
  const union MHD_DaemonInfo *port = d ? MHD_get_daemon_info(d, MHD_DAEMON_INFO_BIND_PORT) : NULL;
  if (!port || port->port == 0) {
    int trouble = errno;
    if (d) MHD_stop_daemon(d);
    return sd_fail(messages, SD_ERROR_IO, "--live: no port of 127.0.0.1 can be had: %s", strerror(trouble));
  }
  l->server = (struct live_server *)d;
  snprintf(l->address, sizeof l->address, "http://127.0.0.1:%u/%s/", (unsigned)port->port, l->token);
  return SD_OK;
}

void live_server_stop(live *l) {
  if (l->server) MHD_stop_daemon((struct MHD_Daemon *)l->server);
  l->server = NULL;
}

#else

sd_status live_server_start(live *l, sd_messages *messages) {
  (void)l;
  return sd_fail(messages, SD_ERROR_USER,
                 "--live: this build has no server: libmicrohttpd was not there when it was made");
}

void live_server_stop(live *l) { (void)l; }

#endif

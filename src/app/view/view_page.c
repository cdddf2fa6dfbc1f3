/* view_page.c: writes pages, and packs and compresses chunks of numbers; see view.h. */
#include <assert.h>
#include <errno.h>
#include <math.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <zlib.h>

#include "app/view/view.h"
#include "base/memory.h"
#include "measure/observable.h"

static const char place_of_numbers[] = "<!-- slipdisk-data -->";
enum { LEVEL = 6 }; /* Compression level of zlib */

/* Writes JSON for a script element, with "<" as \u003c, since "<" in a string could end the
 * element. Outside strings JSON has no "<". */
static int write_json(const char *text, size_t n, void *user) {
  FILE *out = user;
  for (size_t k = 0; k < n; k++)
    if (text[k] == '<')
      fputs("\\u003c", out);
    else
      fputc(text[k], out);
  return ferror(out) ? -1 : 0;
}

static const char *split(void) {
  const char *at = strstr((const char *)viewer_page, place_of_numbers);
  assert(at);
  return at;
}

bool view_page_head(FILE *out, const json_t *meta) {
  const char *page = (const char *)viewer_page;
  fwrite(page, 1, (size_t)(split() - page), out);
  fputs("<script type=\"application/json\" id=\"slipdisk-meta\">", out);
  bool good =
      json_dump_callback(meta, write_json, out, JSON_COMPACT | JSON_REAL_PRECISION(17)) == 0;
  fputs("</script>\n", out);
  return good && !ferror(out);
}

bool view_page_tail(FILE *out) {
  fputs(split() + strlen(place_of_numbers), out);
  return !ferror(out);
}

static sd_status fail(const view_page *p, sd_messages *messages) {
  return sd_fail(messages, SD_ERROR_IO, "cannot write %s: %s", p->file.path,
                 file_error_text(errno));
}

sd_status view_page_open(view_page *p, const char *path, const json_t *meta,
                         sd_messages *messages) {
  *p = (view_page){0};
  sd_status status = file_stream_open(path, &p->file, messages);
  if (status == SD_OK && !view_page_head(p->file.out, meta)) status = fail(p, messages);
  return status;
}

static void write_base64(FILE *out, const unsigned char *bytes, size_t n) {
  static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  char text[4096];
  size_t have = 0;
  for (size_t k = 0; k < n; k += 3) {
    size_t left = n - k < 3 ? n - k : 3;
    unsigned bits = (unsigned)bytes[k] << 16 | (left > 1 ? (unsigned)bytes[k + 1] << 8 : 0u) |
                    (left > 2 ? (unsigned)bytes[k + 2] : 0u);
    for (size_t c = 0; c < 4; c++)
      text[have++] = c <= left ? letters[bits >> (18 - 6 * c) & 63] : '=';
    if (have < sizeof text) continue;
    fwrite(text, 1, have, out);
    have = 0;
  }
  fwrite(text, 1, have, out);
}

sd_status view_page_add(view_page *p, const char *name, view_chunk *c, sd_messages *messages) {
  unsigned char *stream;
  size_t size;
  FILE *out = p->file.out;
  fprintf(out, "<script type=\"text/plain\" class=\"slipdisk-chunk\" data-name=\"%s\"", name);
  const json_t *time = json_object_get(c->head, "time");
  if (time)
    fprintf(out, " data-time=\"%.17g\" data-step=\"%lld\"", json_number_value(time),
            (long long)json_integer_value(json_object_get(c->head, "step")));
  fputs(">", out);
  sd_status status = view_chunk_end(c, LEVEL, &stream, &size, messages);
  if (status != SD_OK) return status;
  write_base64(out, stream, size);
  fputs("</script>\n", out);
  free(stream);
  p->bytes += size;
  return ferror(out) ? fail(p, messages) : SD_OK;
}

sd_status view_page_close(view_page *p, sd_status status, sd_messages *messages) {
  if (status == SD_OK && !view_page_tail(p->file.out)) status = fail(p, messages);
  return file_stream_close(&p->file, status, messages);
}

sd_status view_open(const char *path, sd_messages *messages) {
  extern char **environ;
  char *const words[] = {"xdg-open", (char *)path, NULL};
  pid_t child;
  int trouble = posix_spawnp(&child, words[0], NULL, NULL, words, environ), how = 0;
  if (trouble == ENOENT) {
    sd_warn(messages, "--open: there is no xdg-open here (package xdg-utils); open %s in a browser",
            path);
    return SD_OK;
  }
  if (trouble != 0)
    return sd_fail(messages, SD_ERROR_IO, "--open: cannot start xdg-open: %s", strerror(trouble));
  while (waitpid(child, &how, 0) < 0 && errno == EINTR) continue;
  if (!WIFEXITED(how) || WEXITSTATUS(how) != 0)
    sd_warn(messages, "--open: xdg-open has found no browser; open %s in one", path);
  return SD_OK;
}

static const struct stored {
  const char *name;
  size_t size;
  double least, most; /* Range of an integer type; both 0 for floating-point types */
} stored_types[] = {{"u8", 1, 0, 255},
                    {"i8", 1, -128, 127},
                    {"u16", 2, 0, 65535},
                    {"i16", 2, -32768, 32767},
                    {"u32", 4, 0, 4294967295.0},
                    {"i32", 4, -2147483648.0, 2147483647.0},
                    {"f32", 4, 0, 0},
                    {"f64", 8, 0, 0}};
enum { U8, I8, U16, I16, U32, I32, F32, F64 };

void view_chunk_begin(view_chunk *c, bool shuffle) {
  *c = (view_chunk){.head = json_pack("{s:[]}", "columns"), .shuffle = shuffle};
}

/* Appends space for n bytes to the chunk, aligned to a multiple of 8, and returns it; NULL: out of
 * memory. */
static unsigned char *more(view_chunk *c, size_t n) {
  size_t at = (c->size + 7) / 8 * 8, size = at + n;
  if (c->failed) return NULL;
  if (size > c->room) {
    size_t room = size + size / 2 + 64;
    c->failed = !memory_resize_row(&c->bytes, room, 1);
    if (c->failed) return NULL;
    c->room = room;
  }
  memset(c->bytes + c->size, 0, at - c->size);
  c->size = size;
  return c->bytes + at;
}

/* Returns the index in stored_types[] of the type in which the values are stored: the smallest that
 * holds them all. */
static int choose(view_form form, sd_type type, const void *values, size_t n, size_t stride) {
  if (form == VIEW_EXACT) return F64;
  if (form != VIEW_WHOLE) return F32;
  double least = 0, most = 0;
  for (size_t k = 0; k < n; k++) {
    double v = observable_element(type, values, k * stride);
    least = v < least ? v : least;
    most = v > most ? v : most;
  }
  int t = U8;
  while (t < I32 && !(least >= stored_types[t].least && most <= stored_types[t].most)) t++;
  return t;
}

/* Stores element k of n, little endian. shuffle: byte b of all elements lies in one block, so that
 * byte b of element k is out[b n + k]. */
static void put(unsigned char *out, size_t n, size_t k, size_t size, bool shuffle, uint64_t bits) {
  for (size_t b = 0; b < size; b++)
    out[shuffle ? b * n + k : k * size + b] = (unsigned char)(bits >> (8 * b));
}

static uint64_t bits_of(int t, view_form form, double value) {
  uint64_t bits = 0;
  if (t == F64) {
    memcpy(&bits, &value, sizeof value);
  } else if (t == F32) {
    float small = (float)value;
    uint32_t half;
    memcpy(&half, &small, sizeof small);
    if (form == VIEW_SHORT && isfinite(small)) half = (half + 0x1000u) & ~0x1fffu;
    bits = half;
  } else {
    bits = (uint64_t)(int64_t)value;
  }
  return bits;
}

void view_chunk_add(view_chunk *c, const char *name, view_form form, sd_type type,
                    const void *values, size_t n, size_t stride) {
  int t = choose(form, type, values, n, stride);
  size_t size = stored_types[t].size;
  bool shuffle = c->shuffle && size > 1;
  unsigned char *out = more(c, n * size);
  if (!out) return;
  double grain = form == VIEW_REAL ? c->grain : 0;
  for (size_t k = 0; k < n; k++) {
    double value = observable_element(type, values, k * stride);
    if (grain > 0 && isfinite(value)) value = grain * nearbyint(value / grain);
    put(out, n, k, size, shuffle, bits_of(t, form, value));
  }
  json_t *column =
      json_pack("{s:s, s:s, s:I, s:I, s:i, s:i, s:b}", "name", name, "type", stored_types[t].name,
                "count", (json_int_t)n, "offset", (json_int_t)(out - c->bytes), "scale", 1, "zero",
                0, "shuffle", (int)shuffle);
  json_array_append_new(json_object_get(c->head, "columns"), column);
}

/* Compresses the head and the columns of a chunk. One call of zlib takes 4 GiB at most, hence the
 * loop. Returns false if out of memory. */
static bool deflate_all(const unsigned char *head, size_t n_head, const view_chunk *c, int level,
                        unsigned char **stream, size_t *size) {
  z_stream z = {0};
  if (deflateInit(&z, level) != Z_OK) return false;
  size_t room = 64 + n_head + c->size + (n_head + c->size) / 1000 + 16 * (c->size / 16384 + 1);
  *size = 0;
  bool good = memory_resize_row(stream, room, 1);
  const struct {
    const unsigned char *bytes;
    size_t n;
  } pieces[] = {{head, n_head}, {c->bytes, c->size}};
  for (size_t p = 0; p < 2; p++) {
    size_t done = 0;
    bool last = p == 1, over = false;
    while (good && !over) {
      size_t now = pieces[p].n - done < 1 << 30 ? pieces[p].n - done : 1 << 30;
      size_t left = room - *size < 1 << 30 ? room - *size : 1 << 30;
      z.next_in = (unsigned char *)(now ? pieces[p].bytes + done : head);
      z.avail_in = (uInt)now;
      z.next_out = *stream + *size;
      z.avail_out = (uInt)left;
      bool finish = last && done + now == pieces[p].n;
      int result = deflate(&z, finish ? Z_FINISH : Z_NO_FLUSH);
      done += now - z.avail_in;
      *size += left - z.avail_out;
      over = last ? result == Z_STREAM_END : done == pieces[p].n;
      good = result == Z_OK || result == Z_STREAM_END;
    }
  }
  deflateEnd(&z);
  return good;
}

void view_chunk_drop(view_chunk *c) {
  free(c->bytes);
  json_decref(c->head);
  *c = (view_chunk){0};
}

sd_status view_chunk_end(view_chunk *c, int level, unsigned char **stream, size_t *size,
                         sd_messages *messages) {
  *stream = NULL;
  const size_t flags = JSON_COMPACT | JSON_REAL_PRECISION(17);
  size_t length = json_dumpb(c->head, NULL, 0, flags), n = (4 + length + 7) / 8 * 8;
  unsigned char *head = memory_new(n, 1);
  put(head, 1, 0, 4, false, n - 4);
  memset(head + 4, ' ', n - 4);
  json_dumpb(c->head, (char *)head + 4, n - 4, flags);
  bool good = !c->failed && deflate_all(head, n, c, level, stream, size);
  free(head);
  view_chunk_drop(c);
  if (good) return SD_OK;
  free(*stream);
  *stream = NULL;
  return sd_fail(messages, SD_ERROR_IO, "no memory for the page's numbers");
}

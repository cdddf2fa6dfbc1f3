/* view_page.c: see view_page.h. */
#include "app/view/view_page.h"

#include <assert.h>
#include <errno.h>
#include <spawn.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

static const char place_of_numbers[] = "<!-- slipdisk-data -->";
enum { LEVEL = 6 }; /* of zlib */

/* Within a page "<" could end the script that it stands in; in JSON it is only found in texts. */
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
  return sd_fail(messages, SD_ERROR_IO, "cannot write %s: %s", p->file.path, file_trouble(errno));
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

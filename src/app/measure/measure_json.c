/* measure_json.c: the JSON of slipdisk measure, frame by frame: memory does not grow with their number. */
#include <stdlib.h>
#include <string.h>

#include "app/measure/measure.h"
#include "base/text.h"
#include "io/store/file.h"

sd_status measure_list_open(measure_list *l, const char *name, size_t stored, const char *path,
                            sd_messages *messages) {
  char *shown = text_clean(format_text("%s", name));
  json_t *text = json_string(shown);
  free(shown);
  *l = (measure_list){.out = stdout, .stored = stored, .name = json_dumps(text, JSON_ENCODE_ANY)};
  json_decref(text);
  if (!path) return SD_OK;
  /* else it is refused when all is done */
  if (file_is_special(path))
    return sd_fail(messages, SD_ERROR_IO, "cannot write %s: it is a device or a pipe", path);
  sd_status status = file_stream_open(path, &l->file, messages);
  l->out = l->file.out;
  return status;
}

/* Nothing is written before there is something to tell. */
static void put_head(const measure_list *l) {
  fprintf(l->out, "{\n  \"file\": %s,\n  \"stored\": %zu,\n  \"frames\": [", l->name, l->stored);
}

void measure_list_add(measure_list *l, const measurement *m) {
  json_t *frame = measure_json(m);
  char *text = json_dumps(frame, JSON_INDENT(2));
  json_decref(frame);
  if (l->n == 0) put_head(l);
  fputs(l->n++ > 0 ? "," : "", l->out);
  for (const char *at = text; *at;) {
    size_t length = strcspn(at, "\n");
    fprintf(l->out, "\n    %.*s", (int)length, at);
    at += length + (at[length] == '\n');
  }
  free(text);
}

sd_status measure_list_close(measure_list *l, sd_status status, sd_messages *messages) {
  if (status == SD_OK) {
    if (l->n == 0) put_head(l);
    fputs(l->n > 0 ? "\n  ]\n}\n" : "]\n}\n", l->out);
  }
  status = file_stream_close(&l->file, status, messages);
  free(l->name);
  *l = (measure_list){0};
  return status;
}

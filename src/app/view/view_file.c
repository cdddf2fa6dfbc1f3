/* view_file.c: writes the page that shows the frames of a result, of an unfinished run or of a
 * checkpoint. */
#include <inttypes.h>
#include <stdlib.h>

#include "app/view/view.h"
#include "base/memory.h"
#include "io/results/checkpoint.h"
#include "model/model.h"
#include "slipdisk/deck.h"

/* Largest number of frames on a page by default: 500 and the last one */
enum { MOST_FRAMES = 501 };
enum { FEW_FRAMES = 200 }; /* Number of frames that the hint to use fewer frames suggests */

typedef struct job {
  const view_options *options;
  frames f;
  size_t count; /* Number of frames, with the state at the end of the run as the last one */
  option_range wanted;
  double *first; /* Angles of all bodies in the first selected frame */
  summary found;
  json_t *meta;
} job;

/* Selects frames: those of the option --frames; without it all frames, or at most MOST_FRAMES
 * evenly spaced ones with the last frame among them. */
static sd_status choose(job *j, bool alone, sd_messages *messages) {
  const view_options *o = j->options;
  sd_status status = stored_count(&j->f, alone, &j->count, messages);
  if (status == SD_OK) status = options_range(o->frames, j->count, o->name, &j->wanted, messages);
  if (status != SD_OK || o->frames || j->count <= MOST_FRAMES) return status;
  size_t step = (j->count - 2) / (MOST_FRAMES - 1) + 1;
  size_t n = (j->count - 1) / step + 1;
  j->wanted = (option_range){.first = (j->count - 1) % step, .step = step, .n = n};
  return SD_OK;
}

/* Reads selected frame k. Call frame_data_free also after an error. */
static sd_status read_wanted(const job *j, size_t k, frame_data *frame, sd_messages *messages) {
  sd_status status = frames_read(&j->f, j->wanted.first + k * j->wanted.step, frame, messages);
  for (size_t c = 0; status == SD_OK && c < frame->n_contacts; c++)
    if (frame->a[c] >= frame->n_disks || frame->b[c] >= frame->n_bodies)
      status = sd_fail(messages, SD_ERROR_IO,
                       "%s is damaged: contacts of step %" PRId64 " name bodies that are not there",
                       j->options->name, frame->step);
  return status;
}

/* Stores the angles of the first selected frame, from which the turns of disks are counted. */
static sd_status note_first(job *j, sd_messages *messages) {
  frame_data frame;
  sd_status status = read_wanted(j, 0, &frame, messages);
  if (status == SD_OK) {
    j->first = frame.angle;
    frame.angle = NULL;
  }
  frame_data_free(&frame);
  return status;
}

static sd_status describe(job *j, sd_messages *messages) {
  provenance origin;
  provenance_read(&origin, j->f.base);
  sd_status status = summary_read(&j->found, j->f.base, messages);
  if (status == SD_OK) status = summary_disks_read_all(&j->found.packing, j->f.base, messages);
  if (status == SD_OK)
    status = checkpoint_complete(j->f.base, j->f.path, j->f.constants, sd_deck_load_text,
                                 &j->found.packing, messages);
  if (status == SD_OK) {
    j->meta = view_meta(j->f.constants, "result", origin.title, j->options->name);
    view_meta_summary(j->meta, &j->found);
    json_object_set_new(j->meta, "frames", json_integer((json_int_t)j->wanted.n));
    json_object_set_new(j->meta, "stored_frames", json_integer((json_int_t)j->count));
  }
  provenance_free(&origin);
  return status;
}

static sd_status write_frames(job *j, view_page *page, sd_messages *messages) {
  view_chunk c;
  sd_status status = SD_OK;
  for (size_t k = 0; status == SD_OK && k < j->wanted.n; k++) {
    frame_data frame;
    status = read_wanted(j, k, &frame, messages);
    if (app_stop) status = SD_INTERRUPTED;
    if (status == SD_OK) {
      view_turns(&frame, j->f.constants, j->first);
      view_frame(&c, j->f.constants, &frame, true);
      status = view_page_add(page, "frame", &c, messages);
    }
    frame_data_free(&frame);
  }
  return status;
}

static sd_status write_page(job *j, const char *path, sd_messages *messages) {
  view_chunk c, series;
  size_t rows;
  sd_status status = view_series_read(&series, &j->f, j->meta, &rows, messages);
  if (status != SD_OK) return status;
  view_page page;
  status = view_page_open(&page, path, j->meta, messages);
  if (status == SD_OK) {
    view_static(&c, j->f.constants, j->first, &j->found.packing, true);
    status = view_page_add(&page, "static", &c, messages);
  }
  if (rows > 0 && status == SD_OK)
    status = view_page_add(&page, "series", &series, messages);
  else if (rows > 0)
    view_chunk_drop(&series);
  if (status == SD_OK) status = write_frames(j, &page, messages);
  return view_page_close(&page, status, messages);
}

static void tell(const job *j) {
  size_t n = j->wanted.n;
  size_t disks = j->f.constants->n_disks, walls = j->f.constants->n_walls;
  printf("%zu disk%s, %zu wall%s, %zu frame%s", disks, disks == 1 ? "" : "s", walls,
         walls == 1 ? "" : "s", n, n == 1 ? "" : "s");
  if (n < j->count) printf(" of %zu", j->count);
  if (n > 1 && j->wanted.step > 1) printf(", one in %zu", j->wanted.step);
  if (!j->options->frames && n < j->count) printf(" (--frames : takes all)");
  putchar('\n');
  int64_t every = j->found.step / FEW_FRAMES;
  if (!j->options->frames && j->count <= 2 && every > 0)
    printf("for more frames give the deck's phases `frames`, the steps from one to the next: "
           "frames = %" PRId64 " makes %d\n",
           every, FEW_FRAMES);
}

sd_status view_file(const view_options *o, char **path, bool *made, sd_messages *messages) {
  job j = {.options = o};
  place p;
  bool alone;
  sd_status status = options_range(o->frames, SIZE_MAX, o->name, &j.wanted, messages);
  if (status != SD_OK) return status;
  status = place_find(&p, o->name, messages);
  if (status == SD_OK)
    *path = o->output ? memory_text(o->output) : app_default_name(p.result, "html");
  place_free(&p);
  if (status == SD_OK) status = stored_open(&j.f, o->name, &alone, messages);
  if (status == SD_OK) status = choose(&j, alone, messages);
  if (status == SD_OK) status = note_first(&j, messages);
  if (status == SD_OK) status = describe(&j, messages);
  app_catch_signals();
  /* A signal only sets app_stop after this, so that an incomplete page is removed */
  app_begin_saving();
  if (status == SD_OK) status = write_page(&j, *path, messages);
  if (status == SD_INTERRUPTED) fprintf(stderr, "stopped: no page is written\n");
  *made = status == SD_OK;
  if (*made) tell(&j);
  json_decref(j.meta);
  summary_free(&j.found);
  free(j.first);
  frames_close(&j.f);
  return status;
}

/* window_check.c: copies and compares what steps change; implements window_check.h. */
#include "physics/step/window_check.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "physics/motion/motion.h"

/* Memory that steps change: n rows of `size` bytes. */
typedef struct region {
  const char *name;
  const void *data;
  size_t n, size;
  bool per_body; /* row i belongs to the body in slot i */
} region;

typedef void region_use(void *with, const region *r);

/* Calls use() for all regions of the engine, always in the same order. */
static void each_region(engine *e, region_use *use, void *with) {
  const sd_state *s = e->state;
  const work *w = &e->work;
  const pairs *p = &w->pairs;
  const size_t blocks = p->count ? (p->count + PAIR_BLOCK - 1) / PAIR_BLOCK : 0;
  /* columns of bodies first, so that the body is named that differs */
  for (int bodies = 1; bodies >= 0; bodies--)
    for (size_t k = 0; k < sd_field_count; k++) {
      const sd_field *f = &sd_fields[k];
      const bool per_body = f->extent == SD_PER_BODY || state_of_free(f->extent);
      if (per_body == (bodies == 1))
        use(with, &(region){f->name, sd_field_data(s, f), sd_extent_size(s, f->extent),
                            sd_type_size(f->type), per_body});
    }
  const size_t flags = p->first_segment / PAIR_BLOCK + (p->count - p->first_segment);
  use(with, &(region){"contacts", p->block, blocks, sizeof *p->block, false});
  use(with, &(region){"contacts: flags", p->flags, flags, sizeof *p->flags, false});
  use(with, &(region){"contacts: further columns", p->more, p->more ? blocks : 0, sizeof *p->more,
                      false});
  use(with, &(region){"contacts: sides", p->side, p->count, sizeof *p->side, false});
  use(with, &(region){"x at the last list", w->x0, s->n_bodies, sizeof *w->x0, true});
  use(with, &(region){"y at the last list", w->y0, s->n_bodies, sizeof *w->y0, true});
  size_t n;
  const prescribed *q = motion_prescribed(e, &n);
  for (size_t k = 0; k < n; k++) {
    const double row[] = {*q[k].at,          *q[k].speed,       q[k].last,  q[k].moved,
                          q[k].force_before, q[k].speed_before, *q[k].force};
    use(with, &(region){"prescribed coordinate", row, 1, sizeof row, false});
  }
}

struct step_image {
  char *bytes;
  size_t size, at; /* at: bytes that were copied or compared so far */
  const engine *e;
  int64_t from;
  sd_messages *messages;
  sd_status status;
};

static void add_size(void *with, const region *r) { ((step_image *)with)->size += r->n * r->size; }

static void copy(void *with, const region *r) {
  step_image *image = with;
  if (r->n) memcpy(image->bytes + image->at, r->data, r->n * r->size);
  image->at += r->n * r->size;
}

static void compare(void *with, const region *r) {
  step_image *image = with;
  const char *was = image->bytes + image->at, *is = r->data;
  image->at += r->n * r->size;
  if (image->status != SD_OK || r->n == 0 || memcmp(was, is, r->n * r->size) == 0) return;
  size_t k = 0;
  while (memcmp(was + k * r->size, is + k * r->size, r->size) == 0) k++;
  const sd_state *s = image->e->state;
  const bool body = r->per_body && k < s->n_bodies;
  image->status = sd_fail(image->messages, SD_ERROR_NUMERIC,
                          "steps %lld to %lld: several steps at once and single steps differ in "
                          "\"%s\" of %s %zu, a bug "
                          "of slipdisk (SLIPDISK_WINDOWS=never takes single steps)",
                          (long long)image->from + 1, (long long)s->step, r->name,
                          body ? "body" : "row", body ? s->id[k] : k);
}

step_image *step_image_new(engine *e) {
  step_image *image = memory_new(1, sizeof *image);
  each_region(e, add_size, image);
  image->bytes = memory_new(image->size, 1);
  each_region(e, copy, image);
  return image;
}

void step_image_free(step_image *image) {
  if (image) free(image->bytes);
  free(image);
}

sd_status step_image_compare(const step_image *image, engine *e, int64_t from,
                             sd_messages *messages) {
  step_image one = *image;
  one.at = 0;
  one.e = e;
  one.from = from;
  one.messages = messages;
  one.status = SD_OK;
  each_region(e, compare, &one);
  return one.status;
}

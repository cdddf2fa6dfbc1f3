/* model_share.c: see model_share.h. */
#include "run/model_share.h"

#include <assert.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/memory.h"
#include "model/image.h"

/* A message has fewer than 2^31 bytes. */
static const size_t PIECE = (size_t)1 << 30;

static sd_status fail(const comm *c, sd_messages *messages) {
  comm_fail(c, "no memory");
  return sd_fail(messages, SD_ERROR_IO, "rank %d: out of memory for the model", comm_rank(c));
}

sd_status model_share(const comm *c, const sd_model *model, sd_model **out, sd_messages *messages) {
  const bool first = comm_rank(c) == 0;
  size_t size = 0;
  *out = NULL;
  if (comm_size(c) == 1) return SD_OK;
  assert(!first || model);
  char *bytes = first ? image_for_ranks(model, &size) : NULL;
  if (first && !bytes) return fail(c, messages);
  uint64_t length[1] = {size};
  comm_share(c, length, sizeof length);
  size = (size_t)length[0];
  if (!first && !memory_resize_row(&bytes, size, 1)) return fail(c, messages);
  for (size_t at = 0; at < size; at += PIECE)
    comm_share(c, bytes + at, size - at < PIECE ? size - at : PIECE);
  const sd_status status = first ? SD_OK : image_read_for_rank(bytes, size, out, messages);
  free(bytes);
  return status == SD_OK ? SD_OK : fail(c, messages);
}

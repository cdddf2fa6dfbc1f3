/* h5_open.c: checks files when they are opened, and joins them with their files of single ranks
 * (shares); see h5.h. */
#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/memory.h"
#include "base/buckets.h"
#include "base/text.h"
#include "io/store/file.h"
#include "io/store/h5_private.h"

/* Largest size in bytes of files of which all bytes are checked against the checksum whenever they
 * are opened; that takes a tenth of a second. */
static const uint64_t CHECKED_WHOLE = UINT64_C(64) << 20;

char *h5_share_path(const char *path, size_t k) {
  const size_t n = strlen(path), tail = text_ends(path, ".h5") ? 3 : 0;
  return format_text("%.*s-%zu.h5", (int)(n - tail), path, k);
}

void h5_put_shares(h5_file *file, size_t n, const int64_t *sums) {
  h5_put(file, "/shares", SD_I64, 1, &n, sums, false);
}

bool h5_has_shares(const h5_file *file) { return h5_exists(file, "/shares"); }

static sd_status no_memory(const h5_shares *s) {
  shortage_note();
  return sd_fail(s->messages, SD_ERROR_IO, "no memory to put %s together", s->head->path);
}

/* --- Opening of shares ------------------------------------------------------------------------ */

/* Replaces the open file by a copy in memory that can be written. */
static sd_status take_image(h5_file *file, sd_messages *messages) {
  const ssize_t n = H5Fget_file_image(file->id, NULL, 0);
  void *image = NULL;
  const bool room = n > 0 && memory_resize_row(&image, (size_t)n, 1);
  hid_t id = H5I_INVALID_HID;
  char name[40];
  h5_memory_name(name, sizeof name);
  if (room && H5Fget_file_image(file->id, image, (size_t)n) == n)
    id = h5_open_image(name, image, (size_t)n, H5F_ACC_RDWR);
  free(image);
  if (id < 0) return sd_fail(messages, SD_ERROR_IO, "no memory to put %s together", file->path);
  H5Fclose(file->id);
  file->id = id;
  file->memory = true;
  return SD_OK;
}

/* Opens share k (file of rank k), whose checksum must be `sum`. */
static sd_status open_share(h5_shares *s, int folder, size_t k, int64_t sum) {
  uint64_t found = 0;
  char *path = h5_share_path(s->head->path, k);
  sd_status status = h5_open_sealed(folder, path, &s->file[k], &found, s->messages);
  if (status == SD_OK && found != (uint64_t)sum)
    status =
        sd_fail(s->messages, SD_ERROR_IO, "%s is not the share that %s names", path, s->head->path);
  free(path);
  return status;
}

/* Allows the process to have n more files open: all shares (files of single ranks) stay open, so
 * that the bytes that were checked are those that are read. */
static void allow_files(size_t n) {
  enum { OTHERS = 64 };
  struct rlimit most;
  if (getrlimit(RLIMIT_NOFILE, &most) != 0 || most.rlim_cur >= n + OTHERS) return;
  most.rlim_cur = most.rlim_max < n + OTHERS ? most.rlim_max : n + OTHERS;
  setrlimit(RLIMIT_NOFILE, &most);
}

static sd_status open_shares(h5_shares *s, int folder) {
  size_t dims[H5_MAX_RANK];
  int rank;
  sd_status status = h5_shape(s->head, "/shares", &rank, dims, s->messages);
  int64_t *sums = h5_column(s->head, "/shares", SD_I64, dims[0], &status, s->messages);
  if (status != SD_OK) return status;
  allow_files(dims[0]);
  s->file = memory_new(dims[0], sizeof *s->file);
  for (; status == SD_OK && s->n < dims[0]; s->n++)
    status = open_share(s, folder, s->n, sums[s->n]);
  free(sums);
  return status;
}

/* --- Order of rows ---------------------------------------------------------------------------- */

/* Reads the keys by which the rows of share k (file of rank k) are ordered into g->place[k]; they
 * must ascend. */
static sd_status read_keys(h5_shares *s, h5_shared_group *g, const char *keys, size_t k) {
  size_t dims[H5_MAX_RANK];
  int rank;
  assert(g->rows && g->place);
  sd_status status = h5_shape(s->file[k], keys, &rank, dims, s->messages);
  const int64_t *key = g->place[k] =
      h5_column(s->file[k], keys, SD_I64, dims[0], &status, s->messages);
  if (status != SD_OK) return status;
  assert(key && s->file[k]);
  g->rows[k] = dims[0];
  g->total += dims[0];
  for (size_t i = 1; i < dims[0]; i++)
    if (key[i] < key[i - 1])
      return sd_fail(s->messages, SD_ERROR_IO, "%s is damaged: its keys do not ascend",
                     s->file[k]->path);
  return SD_OK;
}

/* Replaces the key of each row by the index that the row has when the rows of all shares are sorted
 * by key. */
static void merge_keys(const h5_shares *s, h5_shared_group *g) {
  runs heads;
  runs_new(&heads, s->n);
  size_t *at = memory_new(s->n, sizeof *at);
  assert(g->rows && g->place);
  for (size_t k = 0; k < s->n; k++)
    if (g->rows[k] > 0) runs_add(&heads, k, g->place[k][0]);
  for (int64_t place = 0; heads.n > 0; place++) {
    const size_t k = runs_least(&heads);
    g->place[k][at[k]++] = place;
    if (at[k] < g->rows[k])
      runs_step(&heads, g->place[k][at[k]]);
    else
      runs_end(&heads);
  }
  runs_free(&heads);
  free(at);
}

/* Reads the keys of the rows that all shares (files of single ranks) have in a group, and computes
 * the order of these rows. */
static sd_status order_group(h5_shares *s, h5_shared_group *g) {
  char *keys = format_text("%s/key", g->name);
  g->rows = memory_new(s->n, sizeof *g->rows);
  g->place = memory_new(s->n, sizeof *g->place);
  sd_status status = SD_OK;
  for (size_t k = 0; status == SD_OK && k < s->n; k++) status = read_keys(s, g, keys, k);
  if (status == SD_OK && s->n > 0) g->each = (size_t)h5_get_attr_i64(s->file[0], keys, "each", 0);
  free(keys);
  if (status == SD_OK) merge_keys(s, g);
  return status;
}

/* --- Datasets --------------------------------------------------------------------------------- */

/* Computes the shape of a dataset joined from shares (files of single ranks), and reads the rows
 * that the main file (head) has itself, which come last. rank, dims: on input the shape of the
 * dataset in one share, on output that of the joined dataset. */
static sd_status shape_set(h5_shares *s, h5_shared_set *set, int *rank, size_t *dims) {
  const h5_shared_group *g = set->group;
  size_t there[H5_MAX_RANK] = {0};
  int own;
  set->width = 1;
  for (int k = 1; k < *rank; k++) set->width *= dims[k];
  if (h5_exists(s->head, set->path) &&
      h5_shape(s->head, set->path, &own, there, s->messages) != SD_OK)
    return SD_ERROR_IO;
  set->tail = g->each ? 0 : there[0];
  if ((g->each && *rank == H5_MAX_RANK) || (g->each && g->total % g->each != 0))
    return sd_fail(s->messages, SD_ERROR_IO, "%s: the shares do not fit together", s->head->path);
  if (g->each) {
    memmove(dims + 2, dims + 1, (size_t)(*rank - 1) * sizeof *dims);
    dims[1] = g->each;
    ++*rank;
  }
  dims[0] = g->each ? g->total / g->each : g->total + set->tail;
  sd_status status = SD_OK;
  if (set->tail > 0)
    set->own =
        h5_column(s->head, set->path, set->type, set->tail * set->width, &status, s->messages);
  return status;
}

/* Makes a dataset without values in the main file (head), which stands for the dataset joined from
 * the shares (files of single ranks). It has the joined shape, and the unit and description of the
 * dataset in the main file or, if that has none, in the share. */
static void stand_for(h5_file *head, const h5_file *share, const char *from,
                      const h5_shared_set *set, int rank, const size_t *dims) {
  static const char *const names[] = {"unit", "description"};
  char *texts[sizeof names / sizeof *names];
  const bool there = h5_exists(head, set->path);
  for (size_t k = 0; k < sizeof names / sizeof *names; k++)
    texts[k] = h5_get_attr_text(there ? head : share, there ? set->path : from, names[k]);
  if (there && H5Ldelete(head->id, set->path, H5P_DEFAULT) < 0) h5_no_memory(head, set->path);
  h5_make(head, set->path, set->type, rank, dims, false);
  for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
    if (texts[k]) h5_attr_text(head, set->path, names[k], texts[k]);
    free(texts[k]);
  }
}

/* Called by h5_visit for a dataset of a share (file of one rank): adds it to the joined
 * datasets. */
static void take_set(void *user, const char *path, sd_type type, bool text, int rank,
                     const size_t *dims) {
  h5_shares *s = user;
  const size_t n = strlen(s->listed->name);
  size_t whole[H5_MAX_RANK + 1] = {0};
  if (s->status != SD_OK || text || rank < 1 || strncmp(path, s->listed->name, n) != 0 ||
      path[n] != '/' || strcmp(path + n, "/key") == 0)
    return;
  s->set = memory_grow(s->set, s->n_sets + 1, sizeof *s->set);
  h5_shared_set *set = &s->set[s->n_sets++];
  *set = (h5_shared_set){.path = memory_text(path + n), .group = s->listed, .type = type};
  memcpy(whole, dims, (size_t)rank * sizeof *whole);
  s->status = shape_set(s, set, &rank, whole);
  if (s->status == SD_OK) stand_for(s->head, s->listed_in, path, set, rank, whole);
}

/* Joins the datasets of a group of the shares (files of single ranks). The list of datasets is that
 * of the largest share, since a share without rows may have no datasets. */
static sd_status take_sets(h5_shares *s, const h5_shared_group *g) {
  size_t largest = 0;
  for (size_t k = 1; k < s->n; k++)
    if (g->rows[k] > g->rows[largest]) largest = k;
  if (s->n == 0) return SD_OK;
  s->listed = g;
  s->listed_in = s->file[largest];
  const sd_status status = h5_visit(s->listed_in, take_set, s, s->messages);
  return status == SD_OK ? s->status : status;
}

sd_status h5_join(h5_file *file, int folder, sd_messages *messages) {
  h5_shares *s = memory_new(1, sizeof *s);
  *s = (h5_shares){
      .head = file, .group = {{.name = "/disks"}, {.name = "/contacts"}}, .messages = messages};
  sd_status status = open_shares(s, folder);
  for (size_t g = 0; status == SD_OK && g < H5_SHARED_GROUPS; g++)
    status = order_group(s, &s->group[g]);
  if (status == SD_OK) status = take_image(file, messages);
  file->writing = status == SD_OK;
  for (size_t g = 0; status == SD_OK && g < H5_SHARED_GROUPS; g++)
    status = take_sets(s, &s->group[g]);
  if (status == SD_OK && file->failed) status = no_memory(s);
  file->writing = false;
  s->messages = NULL;
  if (status == SD_OK)
    file->shares = s;
  else
    h5_shares_free(s);
  return status;
}

/* --- Checks ----------------------------------------------------------------------------------- */

/* Reports a file that has lost the checksum at its end (seal), which its attribute "sealed"
 * promises. */
static sd_status check_sealed(const h5_file *file, const h5_mark *mark, sd_messages *messages) {
  if (mark->sealed || h5_get_attr_i64(file, "/", "sealed", 0) == 0) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO,
                 "%s is damaged, or was changed by another program: its checksum is missing",
                 file->path);
}

/* Ways to open a file: AGAIN without checks, QUICK as h5_open does, WHOLE with all bytes checked,
 * SEALED likewise and only if it has a checksum (seal), HEAD as SEALED but without its files of
 * single ranks (shares). */
typedef enum trust { AGAIN, QUICK, WHOLE, SEALED, HEAD } trust;

/* mark: receives the checksums, may be NULL. */
static sd_status open_checked(int folder, const char *path, trust how, h5_file **out, h5_mark *mark,
                              sd_messages *messages) {
  h5_mark own;
  if (!mark) mark = &own;
  *mark = (h5_mark){0};
  *out = NULL;
  int fd = file_open(folder, path, messages);
  if (fd < 0) return SD_ERROR_IO;
  sd_status status = h5_read_mark(fd, path, mark, messages);
  const bool whole =
      mark->broken || how >= SEALED ||
      (mark->sealed && (how == WHOLE || mark->size <= CHECKED_WHOLE || !h5_probes()));
  /* the library crashes with some damaged files: it opens only files that match a checksum, or that
   * another process could read */
  if (status == SD_OK && whole && how != AGAIN)
    status = h5_check_whole(fd, path, mark, messages);
  else if (status == SD_OK && how != AGAIN && (!mark->sealed || mark->has_small))
    status =
        h5_probe(fd, path, mark->sealed ? H5_PROBE_SMALL : H5_PROBE_QUICK, mark->small, messages);
  if (status == SD_OK) status = h5_open_descriptor(fd, path, out, messages);
  if (status == SD_OK && how != AGAIN) status = check_sealed(*out, mark, messages);
  if (status == SD_OK && how != HEAD && h5_has_shares(*out))
    status = h5_join(*out, folder, messages);
  if (status != SD_OK && *out) {
    h5_close(*out, NULL);
    *out = NULL;
  }
  close(fd);
  return status;
}

sd_status h5_open(const char *path, h5_file **out, sd_messages *messages) {
  return open_checked(-1, path, QUICK, out, NULL, messages);
}

sd_status h5_open_again(const char *path, h5_file **out, sd_messages *messages) {
  return open_checked(-1, path, AGAIN, out, NULL, messages);
}

sd_status h5_open_whole(const char *path, h5_file **out, sd_messages *messages) {
  return open_checked(-1, path, WHOLE, out, NULL, messages);
}

sd_status h5_open_head(const char *path, h5_file **out, sd_messages *messages) {
  return open_checked(-1, path, HEAD, out, NULL, messages);
}

sd_status h5_open_sealed(int folder, const char *path, h5_file **out, uint64_t *sum,
                         sd_messages *messages) {
  h5_mark mark;
  const sd_status status = open_checked(folder, path, SEALED, out, &mark, messages);
  if (sum) *sum = mark.sum;
  return status;
}

sd_status h5_verify(const char *path, bool *sealed, uint64_t *sum, sd_messages *messages) {
  h5_file *file = NULL;
  h5_mark mark;
  const sd_status status = open_checked(-1, path, WHOLE, &file, &mark, messages);
  *sealed = mark.sealed || mark.broken;
  *sum = mark.all;
  h5_close(file, NULL);
  return status;
}

sd_status h5_reseal(const char *path, sd_messages *messages) {
  h5_mark mark;
  h5_file *file = NULL;
  uint64_t small = 0;
  int fd = file_open_at(AT_FDCWD, path, O_RDWR | O_NOFOLLOW);
  if (fd < 0) return sd_fail(messages, SD_ERROR_IO, "cannot change %s: %s", path, strerror(errno));
  sd_status status = h5_read_mark(fd, path, &mark, messages);
  const uint64_t data = mark.size - (mark.has_small ? H5_SEAL_BYTES : 0);
  if (status == SD_OK) status = h5_probe(fd, path, H5_PROBE_WHOLE, 0, messages);
  if (status == SD_OK) status = h5_open_descriptor(fd, path, &file, messages);
  if (status == SD_OK) status = h5_small_sum(file, &small, messages);
  h5_close(file, NULL);
  if (status == SD_OK && mark.sealed && ftruncate(fd, (off_t)data) != 0)
    status = sd_fail(messages, SD_ERROR_IO, "cannot change %s: %s", path, strerror(errno));
  if (status == SD_OK) status = h5_put_seal(fd, path, small, messages);
  if (close(fd) != 0 && status == SD_OK)
    status = sd_fail(messages, SD_ERROR_IO, "cannot write %s: %s", path, strerror(errno));
  return status;
}

/* h5_shares.c: files that are put together from several; see h5.h. */
#include <stdlib.h>
#include <string.h>

#include "base/shortage.h"
#include "base/text.h"
#include "io/store/h5_private.h"

char *h5_share_path(const char *path, size_t k) {
  const size_t n = strlen(path), tail = text_ends(path, ".h5") ? 3 : 0;
  return format_text("%.*s-%zu.h5", (int)(n - tail), path, k);
}

void h5_put_shares(h5_file *file, size_t n, const int64_t *sums) {
  h5_put(file, "/shares", SD_I64, 1, &n, sums, false);
}

bool h5_has_shares(const h5_file *file) { return h5_exists(file, "/shares"); }

/* A row of share `from`. */
typedef struct shared_row {
  int64_t key;
  size_t from, at;
} shared_row;

typedef struct joining {
  h5_file *head, **shares;
  size_t n;
  const char *group;
  size_t *rows;    /* [n] of this group in each share */
  size_t **places; /* [n][rows] where they stand in the whole */
  size_t total, largest;
  size_t each; /* rows of the shares in a row of the whole; 0: they are its rows */
  sd_status status;
  sd_messages *messages;
} joining;

static sd_status no_memory(const joining *j) {
  shortage_note();
  return sd_fail(j->messages, SD_ERROR_IO, "no memory to put %s together", j->head->path);
}

static int by_key(const void *one, const void *two) {
  const shared_row *p = one, *q = two;
  if (p->key != q->key) return p->key < q->key ? -1 : 1;
  if (p->from != q->from) return p->from < q->from ? -1 : 1;
  return p->at < q->at ? -1 : p->at > q->at;
}

/* --- open ------------------------------------------------------------------------------------------------ */

/* A copy of the file in memory, that can be written. */
static sd_status take_image(h5_file *file, sd_messages *messages) {
  const ssize_t n = H5Fget_file_image(file->id, NULL, 0);
  void *image = n > 0 ? malloc((size_t)n) : NULL;
  hid_t id = H5I_INVALID_HID, access = H5Pcreate(H5P_FILE_ACCESS);
  char name[40];
  h5_memory_name(name, sizeof name);
  H5Pset_fapl_core(access, (size_t)1 << 20, false);
  if (image && H5Fget_file_image(file->id, image, (size_t)n) == n &&
      H5Pset_file_image(access, image, (size_t)n) >= 0)
    id = H5Fopen(name, H5F_ACC_RDWR, access);
  H5Pclose(access);
  free(image);
  if (id < 0) return sd_fail(messages, SD_ERROR_IO, "no memory to put %s together", file->path);
  H5Fclose(file->id);
  file->id = id;
  file->memory = true;
  return SD_OK;
}

static sd_status open_share(joining *j, int folder, size_t k, int64_t sum) {
  uint64_t found = 0;
  char *path = h5_share_path(j->head->path, k);
  if (!path) return no_memory(j);
  sd_status status = h5_open_sealed(folder, path, &j->shares[k], &found, j->messages);
  if (status == SD_OK && found != (uint64_t)sum)
    status = sd_fail(j->messages, SD_ERROR_IO, "%s is not the share that %s names", path, j->head->path);
  free(path);
  return status;
}

static sd_status open_shares(joining *j, int folder) {
  size_t dims[H5_MAX_RANK];
  int rank;
  sd_status status = h5_shape(j->head, "/shares", &rank, dims, j->messages);
  int64_t *sums = h5_column(j->head, "/shares", SD_I64, dims[0], &status, j->messages);
  if (status != SD_OK) return status;
  j->shares = calloc(dims[0] + 1, sizeof *j->shares);
  j->rows = calloc(dims[0] + 1, sizeof *j->rows);
  j->places = calloc(dims[0] + 1, sizeof *j->places);
  if (!j->shares || !j->rows || !j->places) status = no_memory(j);
  for (; status == SD_OK && j->n < dims[0]; j->n++) status = open_share(j, folder, j->n, sums[j->n]);
  free(sums);
  return status;
}

static void end(joining *j) {
  for (size_t k = 0; k < j->n; k++) {
    h5_close(j->shares[k], NULL);
    free(j->places[k]);
  }
  free(j->shares);
  free(j->rows);
  free(j->places);
}

/* --- order ----------------------------------------------------------------------------------------------- */

static sd_status count_rows(joining *j, const char *keys) {
  j->total = 0;
  for (size_t k = 0; k < j->n; k++) {
    size_t dims[H5_MAX_RANK];
    int rank;
    if (h5_shape(j->shares[k], keys, &rank, dims, j->messages) != SD_OK ||
        h5_check(j->shares[k], keys, dims[0], j->messages) != SD_OK)
      return SD_ERROR_IO;
    j->rows[k] = dims[0];
    j->total += dims[0];
    free(j->places[k]);
    if (!(j->places[k] = malloc((dims[0] + 1) * sizeof **j->places))) return no_memory(j);
  }
  return SD_OK;
}

static sd_status order_rows(joining *j) {
  char *keys = format_text("%s/key", j->group);
  sd_status status = keys ? count_rows(j, keys) : no_memory(j);
  if (status == SD_OK && j->n > 0) j->each = (size_t)h5_get_attr_i64(j->shares[0], keys, "each", 0);
  shared_row *list = status == SD_OK ? malloc((j->total + 1) * sizeof *list) : NULL;
  if (status == SD_OK && !list) status = no_memory(j);
  size_t filled = 0;
  for (size_t k = 0; list && k < j->n && status == SD_OK; k++) {
    int64_t *key = h5_column(j->shares[k], keys, SD_I64, j->rows[k], &status, j->messages);
    for (size_t i = 0; key && i < j->rows[k]; i++) list[filled++] = (shared_row){key[i], k, i};
    free(key);
  }
  if (status == SD_OK && list) {
    qsort(list, j->total, sizeof *list, by_key);
    for (size_t i = 0; i < j->total; i++) j->places[list[i].from][list[i].at] = i;
  }
  free(list);
  free(keys);
  return status;
}

/* --- columns --------------------------------------------------------------------------------------------- */

typedef struct column {
  const char *from, *path; /* in shares, in the head */
  sd_type type;
  int rank;
  size_t dims[H5_MAX_RANK + 1]; /* of the whole */
  size_t width, tail;           /* elements of a row; rows that the head has itself */
} column;

/* The rows of the shares, and behind them those of the head. */
static void *gather(joining *j, const column *c) {
  const size_t row = c->width * sd_type_size(c->type);
  char *data = malloc((j->total + c->tail) * row + 1);
  if (!data) j->status = no_memory(j);
  for (size_t k = 0; data && k < j->n && j->status == SD_OK; k++) {
    if (j->rows[k] == 0) continue;
    char *piece = h5_column(j->shares[k], c->from, c->type, j->rows[k] * c->width, &j->status, j->messages);
    for (size_t i = 0; piece && i < j->rows[k]; i++)
      memcpy(data + j->places[k][i] * row, piece + i * row, row);
    free(piece);
  }
  if (data && j->status == SD_OK && c->tail > 0)
    j->status = h5_get(j->head, c->path, c->type, c->tail * c->width, data + j->total * row, j->messages);
  if (j->status == SD_OK) return data;
  free(data);
  return NULL;
}

/* In its place in the head, with the attributes that it has there or in the share. */
static void replace(h5_file *head, const h5_file *share, const column *c, const void *data) {
  static const char *const names[] = {"unit", "description"};
  char *texts[sizeof names / sizeof *names];
  const bool there = h5_exists(head, c->path);
  for (size_t k = 0; k < sizeof names / sizeof *names; k++)
    texts[k] = h5_get_attr_text(there ? head : share, there ? c->path : c->from, names[k]);
  if (there && H5Ldelete(head->id, c->path, H5P_DEFAULT) < 0) head->failed = true;
  h5_put(head, c->path, c->type, c->rank, c->dims, data, false);
  for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
    if (texts[k]) h5_attr_text(head, c->path, names[k], texts[k]);
    free(texts[k]);
  }
}

/* Rows of `dims` as they are, or `each` of them in one row of the whole. */
static sd_status shape_column(joining *j, column *c, const size_t *dims) {
  size_t there[H5_MAX_RANK] = {0};
  int rank;
  c->width = 1;
  for (int k = 1; k < c->rank; k++) c->width *= dims[k];
  if (h5_exists(j->head, c->path) && h5_shape(j->head, c->path, &rank, there, j->messages) != SD_OK)
    return SD_ERROR_IO;
  c->tail = j->each ? 0 : there[0];
  const int more = j->each ? 1 : 0;
  if (c->rank + more > H5_MAX_RANK || (j->each && j->total % j->each != 0))
    return sd_fail(j->messages, SD_ERROR_IO, "%s: the shares do not fit together", j->head->path);
  for (int k = 1; k < c->rank; k++) c->dims[k + more] = dims[k];
  c->dims[more] = j->each;
  c->dims[0] = j->each ? j->total / j->each : j->total + c->tail;
  c->rank += more;
  return SD_OK;
}

/* h5_visitor of the largest share. */
static void join_column(void *user, const char *path, sd_type type, bool text, int rank, const size_t *dims) {
  joining *j = user;
  const size_t n = strlen(j->group);
  if (j->status != SD_OK || text || rank < 1 || strncmp(path, j->group, n) != 0 || path[n] != '/' ||
      strcmp(path + n, "/key") == 0)
    return;
  column c = {.from = path, .path = path + n, .type = type, .rank = rank};
  j->status = shape_column(j, &c, dims);
  void *data = j->status == SD_OK ? gather(j, &c) : NULL;
  if (j->status == SD_OK) replace(j->head, j->shares[j->largest], &c, data);
  free(data);
}

static sd_status join_group(joining *j, const char *group) {
  j->group = group;
  sd_status status = order_rows(j);
  j->largest = 0;
  for (size_t k = 1; status == SD_OK && k < j->n; k++)
    if (j->rows[k] > j->rows[j->largest]) j->largest = k;
  if (status != SD_OK || j->n == 0) return status;
  status = h5_visit(j->shares[j->largest], join_column, j, j->messages);
  return status == SD_OK ? j->status : status;
}

sd_status h5_join(h5_file *file, int folder, sd_messages *messages) {
  joining j = {.head = file, .messages = messages};
  sd_status status = open_shares(&j, folder);
  if (status == SD_OK) status = take_image(file, messages);
  file->writing = status == SD_OK;
  if (status == SD_OK) status = join_group(&j, "/disks");
  if (status == SD_OK) status = join_group(&j, "/contacts");
  if (status == SD_OK && file->failed) status = no_memory(&j);
  file->writing = false;
  end(&j);
  return status;
}

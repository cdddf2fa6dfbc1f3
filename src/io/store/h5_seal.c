/* h5_seal.c: checksums behind the HDF5 data of a file, where readers of HDF5 ignore them.
 *
 *   HDF5 data | "slipdata" size hash | "slipxxh3" size sum
 *
 * The seal, the last piece, covers everything before it: its sum is what `head -c -24 FILE | xxhsum
 * -H3` prints, the highest byte first. Up to version 0.6 it was a hash (hash_words), the lowest
 * byte first, with the mark "slipseal". A finished result also has the middle piece: a hash of its
 * attributes and small datasets alone, which can be checked at each opening however large the file
 * is.
 */
#include <endian.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/hash.h"
#include "base/memory.h"
#include "io/store/file.h"
#include "io/store/h5_private.h"

/* One piece behind the HDF5 data: a mark, and a checksum of all bytes before it, or only of the
 * attributes and small datasets. */
typedef struct piece {
  char mark[8];
  uint64_t size; /* number of bytes before this piece */
  uint64_t sum;
} piece;
static const char seal_mark[8] = {'s', 'l', 'i', 'p', 'x', 'x', 'h', '3'};
static const char words_mark[8] = {'s', 'l', 'i', 'p', 's', 'e', 'a', 'l'};
static const char small_mark[8] = {'s', 'l', 'i', 'p', 'd', 'a', 't', 'a'};

/* Largest size in bytes of a dataset or an attribute that counts as small */
enum { SMALL = 64 << 10 };

static piece make_piece(const char mark[8], uint64_t size, uint64_t sum) {
  piece p = {.size = size, .sum = sum};
  memcpy(p.mark, mark, sizeof p.mark);
  return p;
}

static piece make_seal(uint64_t size, uint64_t sum) {
  return make_piece(seal_mark, size, htobe64(sum));
}

/* Reads the last pieces of a file of `size` bytes. */
static h5_mark mark_of(const piece last[2], uint64_t size) {
  h5_mark mark = {.words = memcmp(last[1].mark, words_mark, sizeof words_mark) == 0};
  if (!mark.words && memcmp(last[1].mark, seal_mark, sizeof seal_mark) != 0) return mark;
  mark.size = last[1].size;
  mark.sum = mark.words ? last[1].sum : be64toh(last[1].sum);
  mark.sealed = mark.size == size - sizeof last[1];
  mark.broken = !mark.sealed;
  mark.has_small = memcmp(last[0].mark, small_mark, sizeof small_mark) == 0 &&
                   last[0].size == size - 2 * sizeof last[0];
  mark.small = last[0].sum;
  return mark;
}

sd_status h5_read_mark(int fd, const char *path, h5_mark *mark, sd_messages *messages) {
  *mark = (h5_mark){0};
  piece last[2];
  struct stat facts;
  size_t have = 0;
  if (fstat(fd, &facts) != 0 || facts.st_size < 0) return file_fail(messages, "read", path);
  uint64_t size = (uint64_t)facts.st_size;
  if (size < sizeof last) return SD_OK;
  if (!file_read_at(fd, size - sizeof last, last, sizeof last, &have))
    return file_fail(messages, "read the end of", path);
  if (have == sizeof last) *mark = mark_of(last, size);
  return SD_OK;
}

/* Checksums of the bytes of a file that have been read so far. */
typedef struct whole_sum {
  file_digest *digest;
  bool words;
  uint64_t hash; /* hash_words, if `words` */
} whole_sum;

static void add_bytes(void *with, const void *bytes, size_t n) {
  whole_sum *s = with;
  file_digest_add(s->digest, bytes, n);
  if (s->words) s->hash = hash_words(s->hash, bytes, n);
}

sd_status h5_check_whole(int fd, const char *path, h5_mark *mark, sd_messages *messages) {
  sd_status status = SD_OK;
  bool good = mark->sealed;
  if (mark->sealed) {
    whole_sum s = {.digest = file_digest_new(), .words = mark->words, .hash = HASH_WORDS};
    status = file_visit(fd, path, 0, mark->size, add_bytes, &s, messages);
    good = (s.words ? s.hash : file_digest_sum(s.digest)) == mark->sum;
    s.words = false;
    if (status == SD_OK)
      status =
          file_visit(fd, path, mark->size, mark->size + H5_SEAL_BYTES, add_bytes, &s, messages);
    mark->all = file_digest_sum(s.digest);
    file_digest_free(s.digest);
  }
  if (status == SD_OK && !good)
    status = sd_fail(messages, SD_ERROR_IO,
                     "%s is damaged, or was changed by another program: its checksum does not fit",
                     path);
  return status;
}

bool h5_seal_fits(const void *data, size_t size) {
  piece last[2];
  if (size < sizeof last) return false;
  memcpy(last, (const unsigned char *)data + size - sizeof last, sizeof last);
  const h5_mark mark = mark_of(last, size);
  return mark.sealed && mark.sum == (mark.words ? hash_words(HASH_WORDS, data, mark.size)
                                                : file_sum(data, mark.size));
}

/* Writes a piece (mark, size, checksum) at the end of a file that has `size` bytes; returns false
 * if that fails. */
static bool append(int fd, uint64_t size, const piece *p) {
  return lseek(fd, (off_t)size, SEEK_SET) == (off_t)size && file_write_all(fd, p, sizeof *p);
}

sd_status h5_put_seal(int fd, const char *path, uint64_t small, sd_messages *messages) {
  struct stat facts;
  bool good = fstat(fd, &facts) == 0;
  uint64_t size = good ? (uint64_t)facts.st_size : 0;
  piece first = make_piece(small_mark, size, small);
  good = good && append(fd, size, &first);
  size += sizeof first;
  whole_sum s = {.digest = file_digest_new()};
  const sd_status status = good ? file_visit(fd, path, 0, size, add_bytes, &s, messages) : SD_OK;
  piece second = make_seal(size, file_digest_sum(s.digest));
  file_digest_free(s.digest);
  if (status != SD_OK) return status;
  good = good && append(fd, size, &second);
  return good ? SD_OK
              : sd_fail(messages, SD_ERROR_IO, "cannot write %s: %s", path, strerror(errno));
}

void h5_make_seal(size_t size, uint64_t sum, unsigned char seal[H5_SEAL_BYTES]) {
  piece p = make_seal(size, sum);
  memcpy(seal, &p, sizeof p);
}

/* --- Small data ------------------------------------------------------------------------------- */

/* Hash of the attributes and small datasets read so far. */
typedef struct tally {
  uint64_t sum;
  bool failed; /* true if something could not be read */
} tally;

static void add(tally *t, const void *data, size_t n) { t->sum = hash_words(t->sum, data, n); }

/* Adds the bytes of a dataset or an attribute, as they are stored, to the checksum. Types whose
 * bytes are addresses, which no file of slipdisk has, are skipped, as are large data. */
static void add_data(tally *t, hid_t id, bool attribute, hid_t type, hid_t space) {
  hssize_t n = H5Sget_simple_extent_npoints(space);
  size_t size = H5Tget_size(type);
  H5T_class_t kind = H5Tget_class(type);
  bool plain = kind == H5T_INTEGER || kind == H5T_FLOAT ||
               (kind == H5T_STRING && H5Tis_variable_str(type) == 0);
  if (!plain || n <= 0 || (uint64_t)n > SMALL || (uint64_t)n * size > SMALL) return;
  unsigned char *data = memory_new((size_t)n, size);
  bool good = (attribute ? H5Aread(id, type, data)
                         : H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data)) >= 0;
  if (good) add(t, data, (size_t)n * size);
  t->failed = t->failed || !good;
  free(data);
}

/* Adds the shape of a dataset or an attribute to the checksum: rank, dimensions, and class and size
 * of the type. */
static void add_shape(tally *t, hid_t type, hid_t space) {
  hsize_t dims[H5S_MAX_RANK] = {0};
  int rank = H5Sget_simple_extent_dims(space, dims, NULL);
  const uint64_t facts[3] = {(uint64_t)rank, (uint64_t)H5Tget_class(type), H5Tget_size(type)};
  add(t, facts, sizeof facts);
  if (rank > 0) add(t, dims, (size_t)rank * sizeof *dims);
}

/* Called for every attribute of an object: adds its name, shape and value to the checksum. */
static herr_t add_attribute(hid_t object, const char *name, const H5A_info_t *info, void *user) {
  (void)info;
  tally *t = user;
  hid_t attr = H5Aopen(object, name, H5P_DEFAULT);
  if (attr < 0) {
    t->failed = true;
    return 0;
  }
  hid_t type = H5Aget_type(attr), space = H5Aget_space(attr);
  add(t, name, strlen(name));
  add_shape(t, type, space);
  add_data(t, attr, true, type, space);
  H5Sclose(space);
  H5Tclose(type);
  H5Aclose(attr);
  return 0;
}

/* Called for every link of a group: adds its name and the contents of its object to the
 * checksum. */
static herr_t add_link(hid_t group, const char *name, const H5L_info_t *info, void *user);

/* Adds attributes and contents of a group or a dataset to the checksum. */
static void add_object(tally *t, hid_t object) {
  void *held = memory_hold(); /* HDF5 must not be left from within its iterations */
  t->failed |= H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, NULL, add_attribute, t) < 0;
  if (H5Iget_type(object) == H5I_GROUP) {
    t->failed |= H5Literate(object, H5_INDEX_NAME, H5_ITER_INC, NULL, add_link, t) < 0;
  } else if (H5Iget_type(object) == H5I_DATASET) {
    hid_t type = H5Dget_type(object), space = H5Dget_space(object);
    add_shape(t, type, space);
    add_data(t, object, false, type, space);
    H5Sclose(space);
    H5Tclose(type);
  }
  memory_release(held);
}

static herr_t add_link(hid_t group, const char *name, const H5L_info_t *info, void *user) {
  tally *t = user;
  add(t, name, strlen(name));
  hid_t object = info->type == H5L_TYPE_HARD ? H5Oopen(group, name, H5P_DEFAULT) : H5I_INVALID_HID;
  if (object >= 0) {
    add_object(t, object);
    H5Oclose(object);
  } else {
    t->failed = true;
  }
  return 0;
}

sd_status h5_small_sum(const h5_file *file, uint64_t *sum, sd_messages *messages) {
  tally t = {.sum = HASH_WORDS};
  hid_t root = H5Oopen(file->id, "/", H5P_DEFAULT);
  if (root >= 0) {
    add_object(&t, root);
    H5Oclose(root);
  }
  *sum = t.sum;
  if (root >= 0 && !t.failed) return SD_OK;
  return sd_fail(messages, SD_ERROR_IO, "%s is damaged: its small data cannot be read", file->path);
}

/* h5_memory.c: files that are built, or read, in memory; see h5.h. */
#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/store/file.h"
#include "io/store/h5_private.h"

/* Bytes by which a file in memory grows. */
static const size_t GROWTH = (size_t)1 << 20;

/* The library takes two memory files of one name for the same file. */
static void memory_name(char *name, size_t size) {
  static unsigned count;
  snprintf(name, size, "memory-%u", __atomic_add_fetch(&count, 1u, __ATOMIC_RELAXED));
}

sd_status h5_new(h5_file **out, sd_messages *messages) {
  char name[40];
  memory_name(name, sizeof name);
  sd_status status = h5_allocate(name, out, messages);
  if (status != SD_OK) return status;
  (*out)->memory = (*out)->writing = true;
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_core(access, GROWTH, false);
  /* The default (earliest) format on purpose: h5_save takes the bytes of the open file, and later formats would say
   * in them that it is being written. */
  (*out)->id = H5Fcreate(name, H5F_ACC_TRUNC, H5P_DEFAULT, access);
  H5Pclose(access);
  if ((*out)->id >= 0) return SD_OK;
  h5_release(*out);
  *out = NULL;
  return sd_fail(messages, SD_ERROR_IO, "no memory for an HDF5 file");
}

/* The file's bytes: those that the library holds, no copy. They are there while the file is open. */
static const void *image_of(hid_t id, size_t *size) {
  void *handle = NULL;
  if (H5Fflush(id, H5F_SCOPE_GLOBAL) < 0) return NULL;
  ssize_t n = H5Fget_file_image(id, NULL, 0);
  if (n <= 0 || H5Fget_vfd_handle(id, H5P_DEFAULT, &handle) < 0 || !handle) return NULL;
  *size = (size_t)n;
  return *(void **)handle; /* of a file in memory: where the bytes are */
}

/* All of a file of h5_new and its seal, whose sum is returned. They are there while the file is open. */
static sd_status whole_image(h5_file *file, const char *path, file_piece pieces[2],
                             unsigned char seal[H5_SEAL_BYTES], uint64_t *sum, sd_messages *messages) {
  size_t size = 0;
  int64_t one = 1;
  h5_attr(file, "/", "sealed", SD_I64, 0, &one);
  h5_flush_sets(file);
  const void *image = file->failed ? NULL : image_of(file->id, &size);
  if (!image)
    return sd_fail(messages, SD_ERROR_IO, "cannot build %s: %s", path,
                   file->trouble ? file->trouble : "no memory");
  uint64_t found = h5_image_seal(image, size, seal);
  if (sum) *sum = found;
  pieces[0] = (file_piece){image, size};
  pieces[1] = (file_piece){seal, H5_SEAL_BYTES};
  return SD_OK;
}

sd_status h5_save(h5_file *file, int folder, const char *path, uint64_t *sum, sd_messages *messages) {
  file_piece pieces[2] = {{0}};
  unsigned char seal[H5_SEAL_BYTES];
  sd_status status = whole_image(file, path, pieces, seal, sum, messages);
  if (status == SD_OK) status = file_write_atomic(folder, path, 2, pieces, messages);
  H5Fclose(file->id);
  h5_release(file);
  return status;
}

sd_status h5_save_memory(h5_file *file, void **data, size_t *size, sd_messages *messages) {
  file_piece pieces[2] = {{0}};
  unsigned char seal[H5_SEAL_BYTES];
  *data = NULL;
  sd_status status = whole_image(file, "the file in memory", pieces, seal, NULL, messages);
  if (status == SD_OK) {
    *size = pieces[0].size + H5_SEAL_BYTES;
    unsigned char *copy = *data = malloc(*size);
    if (copy) {
      assert(pieces[0].bytes);
      memcpy(copy, pieces[0].bytes, pieces[0].size);
      memcpy(copy + pieces[0].size, seal, H5_SEAL_BYTES);
    } else {
      status = sd_fail(messages, SD_ERROR_IO, "no memory for a copy of %zu bytes", *size);
    }
  }
  H5Fclose(file->id);
  h5_release(file);
  return status;
}

sd_status h5_open_memory(const void *data, size_t size, h5_file **out, sd_messages *messages) {
  unsigned char seal[H5_SEAL_BYTES];
  const size_t image = size < H5_SEAL_BYTES ? 0 : size - H5_SEAL_BYTES;
  *out = NULL;
  if (image) h5_image_seal(data, image, seal);
  if (!image || memcmp(seal, (const unsigned char *)data + image, H5_SEAL_BYTES) != 0)
    return sd_fail(messages, SD_ERROR_IO, "the saved bytes are damaged: their checksum does not fit");
  char name[40];
  memory_name(name, sizeof name);
  sd_status status = h5_allocate(name, out, messages);
  if (status != SD_OK) return status;
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_core(access, GROWTH, false);
  H5Pset_file_image(access, (void *)(uintptr_t)data, image);
  (*out)->id = H5Fopen(name, H5F_ACC_RDONLY, access);
  H5Pclose(access);
  if ((*out)->id >= 0) return SD_OK;
  h5_release(*out);
  *out = NULL;
  return sd_fail(messages, SD_ERROR_IO, "the saved bytes are no HDF5 file, or there is no memory");
}

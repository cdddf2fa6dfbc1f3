/* scratch_file.h: one file in a folder of its own, for tests of files. Include after cmocka.h; define SCRATCH_NAME first. */
#ifndef TESTS_SCRATCH_FILE_H
#define TESTS_SCRATCH_FILE_H

#include <unistd.h>

#include "unit.h"
#include "slipdisk/status.h"

static char folder_name[] = "/tmp/slipdisk-" SCRATCH_NAME "-XXXXXX";
static char path[128];

static int make_folder(void **unused) {
  if (!mkdtemp(folder_name)) return -1;
  snprintf(path, sizeof path, "%s/file.h5", folder_name);
  return 0;
}

static int remove_folder(void **unused) {
  unlink(path);
  return rmdir(folder_name);
}

static void check(sd_status status, sd_messages *messages) {
  if (status != SD_OK) sd_messages_print(messages, stderr);
  assert_int_equal(status, SD_OK);
}

#endif

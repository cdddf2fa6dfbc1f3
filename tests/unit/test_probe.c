/* test_probe.c: HDF5 files without a checksum are read by the program first: in a process with threads, that ignores its
 * children or that has no program; damaged files, and programs that sleep or know nothing of it, end in a message. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <pthread.h>
#include <signal.h>
#include <sys/stat.h>

#include "io/store/h5_private.h"
#include "slipdisk/deck.h"

#define SCRATCH_NAME "probe"
#include "scratch_file.h"

/* Writes a file as other programs do, in the newest format: its links are in a heap, which `damaged` overwrites. */
static void make_foreign(bool damaged) {
  static const char mark[] = "FHDB";
  static char bytes[1 << 16];
  hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, access), space = H5Screate(H5S_SCALAR);
  for (int k = 0; k < 40; k++) {
    char name[40];
    snprintf(name, sizeof name, "a_dataset_with_a_name_%d", k);
    H5Dclose(
        H5Dcreate2(file, name, H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  }
  H5Sclose(space);
  H5Pclose(access);
  H5Fclose(file);
  FILE *out = fopen(path, "r+b");
  const size_t n = fread(bytes, 1, sizeof bytes, out);
  const char *at = memmem(bytes, n, mark, 4);
  assert_non_null(at);
  if (damaged) {
    fseek(out, at - bytes + 40, SEEK_SET);
    for (int k = 0; k < 64; k++) fputc(0xa5, out);
  }
  fclose(out);
}

/* Opens the file with this program; returns the message, "" if it is accepted. */
static const char *open_by(const char *program) {
  static char said[400];
  sd_messages *messages = sd_messages_new();
  h5_file *file = NULL;
  sd_set_program(program);
  const sd_status status = h5_open(path, &file, messages);
  snprintf(said, sizeof said, "%s", status == SD_OK ? "" : sd_messages_text(messages, 0));
  assert_int_equal(status, *said ? SD_ERROR_IO : SD_OK);
  h5_close(file, NULL);
  sd_messages_free(messages);
  sd_set_program(NULL);
  return said;
}

static void *read_stream(void *stream) {
  fgetc(stream);
  return NULL;
}

static void test_other_threads_may_hold_streams(void **unused) {
  int ends[2];
  pthread_t thread;
  assert_int_equal(pipe(ends), 0);
  FILE *stream = fdopen(ends[0], "r");
  pthread_create(&thread, NULL, read_stream, stream);
  while (ftrylockfile(stream) == 0) funlockfile(stream); /* until the thread waits in fgetc */
  make_foreign(false);
  assert_string_equal(open_by(SLIPDISK_PROGRAM), "");
  close(ends[1]);
  pthread_join(thread, NULL);
  fclose(stream);
}

static void test_a_host_may_ignore_its_children(void **unused) {
  make_foreign(true);
  assert_non_null(strstr(open_by(SLIPDISK_PROGRAM), "file.h5 is damaged: "));
  void (*before)(int) = signal(SIGCHLD, SIG_IGN);
  assert_non_null(strstr(open_by(SLIPDISK_PROGRAM), "file.h5 is damaged: "));
  make_foreign(false);
  assert_string_equal(open_by(SLIPDISK_PROGRAM), "");
  signal(SIGCHLD, before);
}

static void test_waiting_has_an_end(void **unused) {
  char program[160];
  snprintf(program, sizeof program, "%s/sleep", folder_name);
  FILE *out = fopen(program, "w");
  fputs("#!/bin/sh\nexec sleep 1000\n", out);
  fclose(out);
  chmod(program, 0700);
  make_foreign(false);
  h5_probe_patience(0.05);
  assert_non_null(strstr(open_by(program), "file.h5 could not be read within 0 s"));
  h5_probe_patience(600);
  unlink(program);
}

static void test_other_programs_are_named(void **unused) {
  make_foreign(false);
  assert_non_null(strstr(open_by("/bin/false"), "/bin/false, which reads such files first"));
  assert_non_null(strstr(open_by("/no/program"), "does not start: No such file"));
}

static void test_without_a_program_no_process_is_started(void **unused) {
  sd_messages *messages = sd_messages_new();
  h5_file *file = NULL;
  make_foreign(false);
  check(h5_open(path, &file, messages), messages);
  h5_close(file, NULL);
  sd_messages_free(messages);
}

RUN_TESTS_BETWEEN(make_folder, remove_folder, TEST(test_other_threads_may_hold_streams),
                  TEST(test_a_host_may_ignore_its_children), TEST(test_waiting_has_an_end),
                  TEST(test_other_programs_are_named),
                  TEST(test_without_a_program_no_process_is_started))

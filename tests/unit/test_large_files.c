/* test_large_files.c: what goes through chunks comes back, whatever the shape and the pieces; noise is stored
 * as it is, what repeats is compressed; a file is saved with one copy of it in memory and checked without any. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "io/store/file.h"
#include "io/store/h5.h"

#define SCRATCH_NAME "large"
#include "scratch_file.h"
#include "slipdisk/deck.h"

/* Doubles whose lower six bytes are noise, as those of positions are. */
static double *noise(size_t n) {
  double *x = malloc(n * sizeof *x);
  assert_non_null(x);
  uint64_t r = 88172645463325252u;
  for (size_t k = 0; k < n; k++) {
    r ^= r << 13;
    r ^= r >> 7;
    r ^= r << 17;
    x[k] = 100.0 * (double)(r >> 11) / 9007199254740992.0;
  }
  return x;
}

typedef struct shape {
  int rank;
  size_t dims[3];
} shape;

/* A table, a long row with components, frames of few disks, frames of many, one that ends within a chunk. */
static const shape shapes[] = {{1, {200001, 1, 1}},
                               {2, {3, 105433, 1}},
                               {3, {5, 40000, 2}},
                               {3, {1000, 60, 2}},
                               {2, {700, 333, 1}}};
enum { SHAPES = sizeof shapes / sizeof *shapes };

static size_t elements(const shape *s) { return s->dims[0] * s->dims[1] * s->dims[2]; }

/* Whole; in pieces, as a merge puts them; one by one, without the last. */
static void write_all(h5_file *file, const shape *s, const double *x, bool all) {
  size_t n = s->dims[0], row = elements(s) / n, piece = n / 7 + 1;
  h5_put(file, "/whole", SD_F64, s->rank, s->dims, x, true);
  h5_make(file, "/pieces", SD_F64, s->rank, s->dims, true);
  for (size_t k = 0; k < n; k += piece)
    h5_put_rows(file, "/pieces", SD_F64, k, n - k < piece ? n - k : piece, x + k * row);
  h5_make(file, "/single", SD_F64, s->rank, s->dims, true);
  for (size_t k = 0; k + !all < n; k++) h5_put_rows(file, "/single", SD_F64, k, 1, x + k * row);
}

static void test_rows(void **unused) {
  static const char *const names[] = {"/whole", "/pieces", "/single"};
  for (int k = 0; k < SHAPES; k++)
    for (int smooth = 0; smooth < 2; smooth++)
      for (int memory = 0; memory < 2; memory++) {
        sd_messages *messages = sd_messages_new();
        size_t n = elements(&shapes[k]);
        double *x = noise(n), *back = malloc(n * sizeof *back);
        for (size_t i = 0; smooth && i < n; i++) x[i] = (double)(i / 50);
        h5_file *file;
        file_draft draft;
        if (!memory) check(file_draft_new(-1, path, &draft, messages), messages);
        check(memory ? h5_new(&file, messages) : h5_create(&draft, 1 << 20, &file, messages),
              messages);
        write_all(file, &shapes[k], x, !memory);
        check(memory ? h5_save(file, -1, path, NULL, messages) : h5_finish(file, &draft, messages),
              messages);
        if (!memory) check(file_draft_publish(&draft, -1, path, FILE_REPLACE, messages), messages);

        check(memory ? h5_open_sealed(-1, path, &file, NULL, messages)
                     : h5_open(path, &file, messages),
              messages);
        for (int d = 0; d < 3; d++) {
          memset(back, 0, n * sizeof *back);
          check(h5_get(file, names[d], SD_F64, n, back, messages), messages);
          size_t given = d < 2 || !memory ? n : n - n / shapes[k].dims[0];
          assert_memory_equal(x, back, given * sizeof *back);
          for (size_t i = given; i < n; i++) assert_true(back[i] == 0.0);
        }
        h5_close(file, NULL);
        double ratio = (double)file_size(path) / (3.0 * (double)n * sizeof *x);
        if (smooth) /* is compressed */
          assert_true(ratio < 0.3);
        else /* is not, and little is lost at the ends of rows: not even a twentieth */
          assert_true(ratio > 0.85 && ratio < 1.05);
        free(x);
        free(back);
        sd_messages_free(messages);
      }
}

/* Frames of few disks that hardly move: each is like the one before, which deflate finds. */
static void test_slow_frames(void **unused) {
  sd_messages *messages = sd_messages_new();
  size_t dims[3] = {2000, 100, 2}, n = 400000;
  double *x = noise(n);
  for (size_t k = 200; k < n; k++) x[k] = x[k - 200] * (1.0 + 1e-13);
  h5_file *file;
  check(h5_new(&file, messages), messages);
  h5_put(file, "/x", SD_F64, 3, dims, x, true);
  check(h5_save(file, -1, path, NULL, messages), messages);
  assert_true((double)file_size(path) < 0.6 * (double)(n * sizeof *x));
  free(x);
  sd_messages_free(messages);
}

enum { LARGE = 16 << 20 }; /* doubles: 128 MiB */

/* Most memory of a process that does this, in MiB. */
static long peak(void (*work)(void)) {
  fflush(NULL);
  pid_t child = fork();
  assert_true(child >= 0);
  if (child == 0) {
    work();
    _exit(0);
  }
  int status;
  struct rusage used;
  assert_int_equal(wait4(child, &status, 0, &used), child);
  assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  return used.ru_maxrss / 1024;
}

static void nothing(void) {}

static void save_large(void) {
  h5_file *file;
  size_t n = LARGE;
  double *x = noise(n);
  if (h5_new(&file, NULL) != SD_OK) _exit(1);
  h5_put(file, "/x", SD_F64, 1, &n, x, false);
  if (h5_save(file, -1, path, NULL, NULL) != SD_OK) _exit(1);
  free(x);
}

static void open_large(void) {
  h5_file *file;
  if (h5_open_sealed(-1, path, &file, NULL, NULL) != SD_OK) _exit(1);
  h5_close(file, NULL);
}

static void test_memory(void **unused) {
  /* sanitizers take memory of their own */
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  skip();
#elif defined(__has_feature)
#if __has_feature(memory_sanitizer)
  skip();
#endif
#endif
  long base = peak(nothing), save = peak(save_large) - base, open = peak(open_large) - base;
  print_message("  %d MiB: saving takes %ld MiB with the data, checking %ld MiB\n", LARGE >> 17,
                save, open);
  assert_true(save < 2 * (LARGE >> 17) + 48);
  assert_true(open < 32);

  /* the check is one of every byte */
  FILE *file = fopen(path, "r+b");
  assert_non_null(file);
  for (long at = 0; at < (long)file_size(path); at += (100 << 20) + 12345) {
    fseek(file, at, SEEK_SET);
    int byte = fgetc(file);
    fseek(file, at, SEEK_SET);
    fputc(byte ^ 1, file);
    fflush(file);
    h5_file *opened = NULL;
    assert_int_equal(h5_open_sealed(-1, path, &opened, NULL, NULL), SD_ERROR_IO);
    fseek(file, at, SEEK_SET);
    fputc(byte, file);
    fflush(file);
  }
  fclose(file);
  h5_file *opened = NULL;
  assert_int_equal(h5_open_sealed(-1, path, &opened, NULL, NULL), SD_OK);
  h5_close(opened, NULL);
}

static void write_result(size_t n, bool whole, sd_status wanted) {
  sd_messages *messages = sd_messages_new();
  h5_file *file;
  file_draft draft;
  double *x = noise(n);
  check(file_draft_new(-1, path, &draft, messages), messages);
  check(h5_create(&draft, 1 << 20, &file, messages), messages);
  h5_make(file, "/bulk/x", SD_F64, 1, &n, true);
  h5_put_rows(file, "/bulk/x", SD_F64, 0, whole ? n : n - 1, x);
  h5_put_text(file, "/small/text", "needle in a dataset");
  h5_attr_text(file, "/small", "text", "needle in an attribute");
  assert_int_equal(h5_finish(file, &draft, messages), wanted);
  if (wanted == SD_OK)
    check(file_draft_publish(&draft, -1, path, FILE_REPLACE, messages), messages);
  file_draft_drop(&draft);
  free(x);
  sd_messages_free(messages);
}

/* Changes a byte in the middle of the text, or of the file. */
static void spoil(const char *text) {
  unsigned char *bytes;
  size_t size;
  assert_int_equal(file_read(path, SIZE_MAX, &bytes, &size, NULL), SD_OK);
  unsigned char *at = text ? memmem(bytes, size, text, strlen(text)) : bytes + size / 2;
  assert_non_null(at);
  at[2] ^= 1;
  assert_int_equal(file_write_atomic(path, bytes, size, NULL), SD_OK);
  free(bytes);
}

static void test_result_seals(void **unused) {
  static const char *const where[] = {"needle in a dataset", "needle in an attribute", "slipxxh3",
                                      NULL};
  static const char *const after[] = {"neddle in a dataset", "neddle in an attribute", "slhpxxh3",
                                      NULL};
  /* one is checked as a whole, of the other only the small data when it is opened */
  const size_t sizes[] = {100000, 9 << 20};
  for (int k = 0; k < 2; k++) {
    write_result(sizes[k], true, SD_OK);
    for (int w = 0; w < 4; w++) {
      bool quick = k == 0 || where[w], sealed;
      uint64_t sum;
      h5_file *file = NULL;
      spoil(where[w]);
      assert_int_equal(h5_open(path, &file, NULL), quick ? SD_ERROR_IO : SD_OK);
      if (!quick) { /* then reading finds it, by the checksum of the chunk */
        double *x = calloc(sizes[k], sizeof *x);
        assert_int_equal(h5_get(file, "/bulk/x", SD_F64, sizes[k], x, NULL), SD_ERROR_IO);
        free(x);
      }
      h5_close(file, NULL);
      assert_int_equal(h5_open_whole(path, &file, NULL), SD_ERROR_IO);
      assert_int_equal(h5_verify(path, &sealed, &sum, NULL), SD_ERROR_IO);
      spoil(after[w]);
      assert_int_equal(h5_verify(path, &sealed, &sum, NULL), SD_OK);
      assert_true(sealed);
    }
  }
}

/* Rows that were not put are found missing before anything else is done with the file. */
static void test_missing_rows(void **unused) { write_result(100000, false, SD_ERROR_IO); }

/* After a change on purpose. */
static void test_reseal(void **unused) {
  bool sealed;
  uint64_t sum;
  write_result(100000, true, SD_OK);
  spoil("needle in a dataset");
  assert_int_equal(h5_verify(path, &sealed, &sum, NULL), SD_ERROR_IO);
  assert_int_equal(h5_reseal(path, NULL), SD_OK);
  assert_int_equal(h5_verify(path, &sealed, &sum, NULL), SD_OK);
  assert_true(sealed);
}

/* A file at `path` with these rows, opened; its name is free again. */
static h5_file *part_of(const shape *s, size_t first, size_t n, const double *x) {
  const size_t dims[3] = {n, s->dims[1], s->dims[2]}, row = elements(s) / s->dims[0];
  h5_file *file;
  assert_int_equal(h5_new(&file, NULL), SD_OK);
  h5_put(file, "/x", SD_F64, s->rank, dims, x + first * row, true);
  assert_int_equal(h5_save(file, -1, path, NULL, NULL), SD_OK);
  assert_int_equal(h5_open_sealed(-1, path, &file, NULL, NULL), SD_OK);
  return file;
}

/* Changes a byte of a row that was copied into a file, which is still being written. */
static void spoil_draft(const file_draft *draft, const double *row) {
  unsigned char *bytes;
  size_t size;
  assert_int_equal(file_read(draft->path, SIZE_MAX, &bytes, &size, NULL), SD_OK);
  const unsigned char *at = memmem(bytes, size, row, 8 * sizeof *row);
  assert_non_null(at);
  const unsigned char other = at[5] ^ 4;
  assert_int_equal(pwrite(draft->fd, &other, 1, at + 5 - bytes), 1);
  free(bytes);
}

/* Rows longer than a chunk are copied as they are stored, packed or not, from several parts,
 * beside rows that are put as values; the finished file is compared with what was copied. */
static void test_copied_rows(void **unused) {
  for (int k = 1; k < 4; k++)
    for (int way = 0; way < 4; way++) { /* noise; smooth; the first row put as values; spoilt */
      const shape *s = &shapes[k];
      const size_t n = elements(s), row = n / s->dims[0], put = way == 2, split = 2,
                   all = s->dims[0];
      double *x = noise(n), *back = calloc(n, sizeof *back);
      for (size_t i = 0; way == 1 && i < n; i++) x[i] = (double)(i / 50);
      h5_file *one = part_of(s, put, split - put, x), *two = part_of(s, split, all - split, x),
              *file;
      file_draft draft;
      assert_int_equal(file_draft_new(-1, path, &draft, NULL), SD_OK);
      assert_int_equal(h5_create(&draft, 1 << 20, &file, NULL), SD_OK);
      h5_make(file, "/x", SD_F64, s->rank, s->dims, true);
      if (put) h5_put_rows(file, "/x", SD_F64, 0, 1, x);
      const bool stored = row * sizeof *x > 256 << 10;
      assert_int_equal(h5_copy_rows(one, file, "/x", SD_F64, put, split - put),
                       stored ? split - put : 0);
      if (!stored) h5_put_rows(file, "/x", SD_F64, put, split - put, x + put * row);
      assert_int_equal(h5_copy_rows(two, file, "/x", SD_F64, split, all - split),
                       stored ? all - split : 0);
      if (!stored) h5_put_rows(file, "/x", SD_F64, split, all - split, x + split * row);
      h5_close(one, NULL);
      h5_close(two, NULL);
      const bool spoilt = way == 3 && stored;
      if (spoilt) spoil_draft(&draft, x + (all - 1) * row);
      assert_int_equal(h5_finish(file, &draft, NULL), spoilt ? SD_ERROR_IO : SD_OK);
      if (!spoilt) {
        assert_int_equal(file_draft_publish(&draft, -1, path, FILE_REPLACE, NULL), SD_OK);
        assert_int_equal(h5_open(path, &file, NULL), SD_OK);
        assert_int_equal(h5_get(file, "/x", SD_F64, n, back, NULL), SD_OK);
        assert_memory_equal(x, back, n * sizeof *x);
        h5_close(file, NULL);
      } else {
        file_draft_drop(&draft);
      }
      free(x);
      free(back);
    }
}

int main(void) {
  sd_set_program(SLIPDISK_PROGRAM); /* which tries to read small data before they are read here */
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_rows),         cmocka_unit_test(test_slow_frames),
      cmocka_unit_test(test_result_seals), cmocka_unit_test(test_missing_rows),
      cmocka_unit_test(test_reseal),       cmocka_unit_test(test_memory),
      cmocka_unit_test(test_copied_rows),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}

/* Memory for small things: without it the handler is called once and the process ends. Rows: all
 * arrays or none. */
/* cmocka.h needs those above */
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "unit.h"
#include "unit.h"
#include "base/memory.h"
#include "slipdisk/status.h"

/* More bytes than any machine has: even the sanitizers' allocator gives none. */
static const size_t TOO_MANY = SIZE_MAX / 4;

static int *calls; /* shared with the children */

static void leave(size_t bytes) {
  ++*calls;
  usleep(100000); /* time for the other threads to come here, too */
  _exit(bytes == TOO_MANY ? SD_ERROR_IO : 1);
}

static void come_back(size_t bytes) { (void)bytes; }

/* Status by waitpid of a child that does it. */
static int end_of(void (*act)(void)) {
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
    act();
    _exit(0);
  }
  int ended = 0;
  assert_int_equal(waitpid(child, &ended, 0), child);
  return ended;
}

static void *lack(void *none) {
  (void)none;
  return memory_new(TOO_MANY, 1);
}

static void lack_in_threads(void) {
  pthread_t thread[3];
  sd_on_no_memory(leave);
  for (int k = 0; k < 3; k++) pthread_create(&thread[k], NULL, lack, NULL);
  for (int k = 0; k < 3; k++) pthread_join(thread[k], NULL);
}

static void lack_grown(void) {
  sd_on_no_memory(leave);
  memory_grow(memory_new(1, 8), TOO_MANY, 1);
}

static void lack_lines(void) {
  sd_on_no_memory(leave);
  memory_lines(TOO_MANY);
}

static void lack_product(void) { memory_grow(NULL, SIZE_MAX / 2, 4); }

static void lack_by_default(void) { memory_new(TOO_MANY, 1); }

static void lack_and_come_back(void) {
  sd_on_no_memory(come_back);
  memory_new(TOO_MANY, 1);
}

static void handler_is_called_once(void **state) {
  void (*const acts[])(void) = {lack_in_threads, lack_grown, lack_lines};
  for (size_t k = 0; k < sizeof acts / sizeof *acts; k++) {
    *calls = 0;
    const int ended = end_of(acts[k]);
    assert_true(WIFEXITED(ended));
    assert_int_equal(WEXITSTATUS(ended), SD_ERROR_IO);
    assert_int_equal(*calls, 1);
  }
}

static void without_handler_the_process_aborts(void **state) {
  void (*const acts[])(void) = {lack_by_default, lack_and_come_back, lack_product};
  for (size_t k = 0; k < sizeof acts / sizeof *acts; k++) {
    const int ended = end_of(acts[k]);
    assert_true(WIFSIGNALED(ended));
    assert_int_equal(WTERMSIG(ended), SIGABRT);
  }
}

static void small_things_are_there(void **state) {
  double *zero = memory_new(0, 8), *three = memory_new(3, sizeof *three);
  assert_non_null(zero);
  for (int k = 0; k < 3; k++) assert_true(three[k] == 0.0);
  three[2] = 5.0;
  three = memory_grow(three, 1000, sizeof *three);
  assert_true(three[2] == 5.0);
  char *line = memory_lines(100);
  assert_int_equal((uintptr_t)line % 64, 0);
  for (int k = 0; k < 100; k++) assert_int_equal(line[k], 0);
  char *text = memory_text("mu"), *none = memory_text(NULL);
  assert_string_equal(text, "mu");
  assert_null(none);
  free(zero), free(three), free(line), free(text);
}

static void rows_are_all_or_none(void **state) {
  double *x = NULL;
  int32_t *id = NULL;
  char *huge = NULL;
  assert_true(memory_rows(2, (memory_column[]){{&x, 100, sizeof *x}, {&id, 0, sizeof *id}}));
  assert_true(x && id && x[99] == 0.0);
  x[99] = 1.0;
  assert_true(memory_resize(2, (memory_column[]){{&x, 200, sizeof *x}, {&id, 200, sizeof *id}}));
  assert_true(x[99] == 1.0);
  id[199] = 3;
  assert_false(
      memory_resize(2, (memory_column[]){{&x, 300, sizeof *x}, {&id, TOO_MANY, sizeof *id}}));
  assert_true(x[99] == 1.0 && id[199] == 3);
  free(x), free(id);
  for (size_t at = 0; at < 3; at++) {
    memory_column columns[3] = {{&x, 10, sizeof *x}, {&huge, 10, 1}, {&id, 10, sizeof *id}};
    columns[at].n = TOO_MANY;
    x = (double *)&huge, id = NULL,
    huge = (char *)&x; /* what stands there before does not matter */
    assert_false(memory_rows(3, columns));
    assert_true(!x && !huge && !id);
  }
}

/* Each alone would be given: Linux finds out when they are written. */
static void rows_beyond_the_machine_are_refused(void **state) {
  const double limit = memory_limit(1);
  const size_t half = (size_t)(0.6 * limit);
  char *one = NULL, *two = NULL;
  assert_true(limit > 0 && limit < 1e16);
  assert_true(memory_limit(3) <= limit && memory_limit(3) >= limit / 4);
  assert_true(memory_fits(0.99 * limit));
  assert_false(memory_fits(1.01 * limit));
  assert_true(memory_fits(1000)); /* small ones are never compared */
  assert_false(memory_rows(2, (memory_column[]){{&one, half, 1}, {&two, half, 1}}));
  assert_true(!one && !two);
  assert_false(memory_resize(2, (memory_column[]){{&one, 2 * half, 1}, {&two, 2 * half, 1}}));
  assert_true(!one && !two);
}

int main(void) {
  calls = mmap(NULL, sizeof *calls, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(handler_is_called_once),
      cmocka_unit_test(without_handler_the_process_aborts),
      cmocka_unit_test(small_things_are_there),
      cmocka_unit_test(rows_are_all_or_none),
      cmocka_unit_test(rows_beyond_the_machine_are_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}

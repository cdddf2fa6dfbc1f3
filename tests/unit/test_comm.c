/* test_comm.c: every task is given once, a stop reaches all ranks in whatever order things happen, waits sleep.
 *
 *   test_comm           one rank
 *   test_comm N         the same tests on the N ranks that mpirun starts
 *   test_comm N abort   rank N-1 gives up while the others wait
 *   test_comm N die     rank N-1 is killed while the others wait
 *
 * Ranks of the test share a ledger, a file that all of them map. A rank that finds a mistake does not leave the
 * others waiting: all compare what they found, and fail together.
 */
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "unit.h"
#include "base/comm.h"
#include "base/comm_queue.h"

enum { TASKS = 3000, RANKS = 64 };

typedef struct ledger {
  atomic_int given[TASKS], done;
  atomic_int by[RANKS]; /* tasks that a rank was given */
} ledger;

static ledger *book;
static volatile sig_atomic_t stop;
static int expected_size = 1;

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static double cpu_time(void) {
  struct rusage used;
  getrusage(RUSAGE_SELF, &used);
  return (double)(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
         1e-6 * (double)(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

static void doze(double seconds) {
  struct timespec t = {.tv_nsec = (long)(seconds * 1e9)};
  nanosleep(&t, NULL);
}

/* All ranks fail when one of them does. */
static void agree(bool right, const char *what) {
  if (!right) print_error("rank %d: %s\n", comm_rank(comm_world()), what);
  assert_int_equal(comm_max(comm_world(), right ? 0 : 1), 0);
}

static void clear_book(void) {
  comm_max(comm_world(), 0);
  if (comm_rank(comm_world()) == 0) memset(book, 0, sizeof *book);
  stop = 0;
  comm_max(comm_world(), 0);
}

static void enter(int64_t task) {
  if (task < TASKS) book->given[task]++;
  book->by[comm_rank(comm_world())]++;
}

/* Each of the first n tasks was given at least `least` times and at most once, and no other one. */
static bool fair(int64_t n, int least) {
  for (int64_t k = 0; k < TASKS; k++) {
    int given = book->given[k];
    if (given > (k < n) || (k < n && given < least)) {
      print_error("task %d of %d was given %d times\n", (int)k, (int)n, given);
      return false;
    }
  }
  return true;
}

static void ranks_know_each_other(void **unused) {
  agree(comm_size(comm_world()) == expected_size,
        "the number of ranks is not that of the command line");
  agree(comm_rank(comm_world()) >= 0 && comm_rank(comm_world()) < comm_size(comm_world()),
        "no such rank");
  book->by[comm_rank(comm_world())]++;
  comm_max(comm_world(), 0);
  for (int k = 0; k < comm_size(comm_world()); k++)
    agree(book->by[k] == 1, "two ranks have one number");
}

static void the_largest_reaches_all(void **unused) {
  for (int k = 0; k < comm_size(comm_world()); k++)
    for (int sign = -1; sign <= 1; sign += 2) {
      int largest = comm_max(comm_world(), comm_rank(comm_world()) == k ? sign * 75 : -1000);
      agree(largest == sign * 75, "not the largest");
    }
}

/* Also what is longer than one message. */
static void the_first_ranks_data_reach_all(void **unused) {
  const size_t sizes[] = {0, 1, 1000, ((size_t)1 << 24) + 1};
  for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
    unsigned char *data = malloc(sizes[s] + 1);
    assert_non_null(data);
    for (size_t k = 0; k <= sizes[s]; k++)
      data[k] = (unsigned char)(comm_rank(comm_world()) == 0 ? k % 251 : 255);
    comm_broadcast(comm_world(), data, sizes[s]);
    bool right = data[sizes[s]] == (comm_rank(comm_world()) == 0 ? sizes[s] % 251 : 255);
    for (size_t k = 0; k < sizes[s]; k++) right = right && data[k] == k % 251;
    free(data);
    agree(right, "comm_broadcast: other data than those of rank 0");
  }
}

/* One queue after the other without a pause: a word that belongs to one must not reach the next. */
static void every_task_is_given_once(void **unused) {
  const int64_t sizes[] = {0, 1, 2, 3, 5, 64, TASKS};
  for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
    clear_book();
    int64_t before = -1;
    bool rising = true, stays = true;
    comm_queue queue;
    comm_queue_begin(&queue, sizes[s], &stop);
    for (int64_t task; (task = comm_next(&queue)) >= 0; before = task) {
      rising = rising && task > before;
      enter(task);
    }
    for (int k = 0; k < 3; k++) stays = stays && comm_next(&queue) == -1;
    comm_queue_end(&queue);
    agree(fair(sizes[s], 1), "a task is lost, or given twice");
    agree(rising && stays, "tasks out of order, or after the last");
    agree(!stop, "a stop that nobody asked for");
  }
}

static void many_queues_in_a_row(void **unused) {
  clear_book();
  enum { QUEUES = 50, EACH = 7 };
  for (int k = 0; k < QUEUES; k++) {
    comm_queue queue;
    comm_queue_begin(&queue, EACH, NULL);
    for (int64_t task; (task = comm_next(&queue)) >= 0;) enter(k * EACH + task);
    comm_queue_end(&queue);
  }
  agree(fair((int64_t)QUEUES * EACH, 1), "a task is lost, or given twice");
}

/* Rank 0 has a task that lasts until all others are done: they get theirs from its comm_serve. */
static void rank_0_serves_while_it_works(void **unused) {
  clear_book();
  enum { N = 40 };
  double limit = now() + 60;
  bool served = true;
  comm_queue queue;
  comm_queue_begin(&queue, N, &stop);
  for (int64_t task; (task = comm_next(&queue)) >= 0;) {
    enter(task);
    while (comm_rank(comm_world()) == 0 && comm_world() && book->done < N - 1 && served) {
      comm_serve(&queue);
      doze(0.002);
      served = now() < limit;
    }
    book->done++;
  }
  comm_queue_end(&queue);
  agree(served, "nobody else took the tasks");
  agree(fair(N, 1), "a task is lost, or given twice");
  if (comm_world()) agree(book->by[0] <= 1, "rank 0 took more than its task");
}

/* A rank that goes early, and tasks that take unequally long. */
static void ranks_may_go_early(void **unused) {
  for (int early = 0; early < comm_size(comm_world()); early++) {
    clear_book();
    enum { N = 60 };
    int mine = 0;
    comm_queue queue;
    comm_queue_begin(&queue, N, &stop);
    for (int64_t task;
         (comm_rank(comm_world()) != early || mine < 2) && (task = comm_next(&queue)) >= 0;
         mine++) {
      enter(task);
      doze(1e-4 * (double)((task * 7 + comm_rank(comm_world())) % 11));
      comm_serve(&queue);
    }
    comm_queue_end(&queue);
    bool alone = !comm_world();
    agree(fair(alone ? 2 : N, 1), "a task is lost, or given twice");
    agree(book->by[early] <= 2, "a rank that had gone was given a task");
  }
}

static void on_alarm(int number) {
  (void)number;
  stop = 1;
}

static void alarm_in(double seconds) {
  struct itimerval timer = {.it_value = {.tv_usec = (suseconds_t)(seconds * 1e6)}};
  setitimer(ITIMER_REAL, &timer, NULL);
}

/* A task without end, as a run that has hours to go: only a stop ends it. */
static bool endless(comm_queue *queue) {
  for (double limit = now() + 60; !stop; doze(0.001)) {
    comm_serve(queue);
    if (now() > limit) return false;
  }
  return true;
}

/* A signal comes to rank `from` (-1: to all) after `delay` seconds, wherever it is then. Of the n tasks those below
 * `quick` take a moment, the others have no end. */
static void stop_once(int from, double delay, int64_t n, int64_t quick) {
  clear_book();
  bool mine = from < 0 || from == comm_rank(comm_world()), ended = true;
  if (mine && delay > 0) alarm_in(delay);
  if (mine && delay == 0) stop = 1;
  comm_queue queue;
  comm_queue_begin(&queue, n, &stop);
  for (int64_t task; (task = comm_next(&queue)) >= 0;) {
    enter(task);
    if (task < quick)
      doze(1e-4);
    else
      ended = endless(&queue) && ended;
  }
  comm_queue_end(&queue);
  bool once = fair(n, 0), quiet = n == quick || comm_next(&queue) == -1;
  int wrong = !ended ? 4 : !once ? 3 : n > quick && !stop ? 2 : !quiet ? 1 : 0;
  static const char *const words[] = {"", "a task after the stop",
                                      "a rank has not heard of the stop", "a task was given twice",
                                      "no stop came"};
  agree(wrong == 0, words[wrong]);
}

/* The first, the last or every rank is told to stop: at once, while they ask, while they work, and while some are
 * idle since there are fewer tasks than ranks. */
static void a_stop_reaches_all(void **unused) {
  const double delays[] = {0, 1e-4, 0.003, 0.03};
  for (int from = -1; from < comm_size(comm_world());
       from += from == 0 && comm_size(comm_world()) > 2 ? comm_size(comm_world()) - 1 : 1)
    for (size_t k = 0; k < sizeof delays / sizeof *delays; k++) {
      stop_once(from, delays[k], TASKS, 100);
      stop_once(from, delays[k], TASKS, 0);
      stop_once(from, delays[k], 1, 0);
      if (comm_size(comm_world()) > 2) stop_once(from, delays[k], comm_size(comm_world()) - 1, 0);
    }
}

/* It comes about when the last task ends. */
static void a_stop_near_the_end(void **unused) {
  for (int from = -1; from < comm_size(comm_world()); from++)
    for (int k = 1; k <= 6; k++) {
      stop_once(from, 16e-4 * k, 30, 30);
      alarm_in(0);
    }
}

/* Rank 1 waits for an answer of rank 0, which does not serve, when the signal comes to either. */
static void a_stop_while_waiting_for_an_answer(void **unused) {
  for (int from = 0; from < 2 && from < comm_size(comm_world()); from++) {
    clear_book();
    comm_queue queue;
    comm_queue_begin(&queue, TASKS, &stop);
    if (comm_rank(comm_world()) == from) alarm_in(0.05);
    if (comm_rank(comm_world()) == 0)
      for (double end = now() + 0.15; now() < end;) doze(0.01);
    bool given = comm_rank(comm_world()) <= 1 && comm_next(&queue) >= 0;
    /* rank 0 may hear of rank 1 a moment later only */
    bool right = !given || (comm_rank(comm_world()) == 0 && from == 1 && endless(&queue));
    comm_queue_end(&queue);
    agree(right, "a task after the stop");
    agree(stop, "a rank has not heard of the stop");
  }
}

/* One rank works for a while, the others have nothing to do: they use next to no processor time. */
static void waits_sleep(void **unused) {
  const double lasts = 0.5, most = 0.1;
  for (int busy = 0; busy < comm_size(comm_world()); busy++) {
    clear_book();
    comm_queue queue;
    comm_queue_begin(&queue, 0, &stop);
    double began = cpu_time();
    for (double end = now() + lasts; comm_rank(comm_world()) == busy && now() < end; doze(0.05))
      comm_serve(&queue);
    comm_queue_end(&queue);
    for (double end = now() + lasts; comm_rank(comm_world()) == busy && now() < end;) doze(0.05);
    comm_max(comm_world(), 0);
    agree(cpu_time() - began < most, "a wait takes processor time");
  }
}

/* Environment of a launcher whose processes do not find each other. */
static void refused_when_launched_apart(void) {
#ifndef SD_HAVE_MPI
  setenv("OMPI_COMM_WORLD_SIZE", "4", 1);
  sd_messages *messages = sd_messages_new();
  if (comm_begin(messages) != SD_ERROR_USER || sd_messages_count(messages) != 1 ||
      !strstr(sd_messages_text(messages, 0), "OMPI_COMM_WORLD_SIZE = 4") ||
      comm_size(comm_world()) != 1) {
    fprintf(stderr, "comm_begin does not notice three other processes\n");
    exit(1);
  }
  sd_messages_free(messages);
  unsetenv("OMPI_COMM_WORLD_SIZE");
#endif
}

/* mpirun's number tells its ranks from those of another mpirun. */
static void open_book(void) {
  char path[4096];
  snprintf(path, sizeof path, "%s/test_comm-%d", SLIPDISK_BUILD_DIR,
           (int)(comm_world() ? getppid() : getpid()));
  int file = open(path, O_RDWR | O_CREAT, 0600);
  bool right = comm_size(comm_world()) <= RANKS && file >= 0 && ftruncate(file, sizeof *book) == 0;
  book = right ? mmap(NULL, sizeof *book, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0) : MAP_FAILED;
  if (book == MAP_FAILED) {
    perror(path);
    comm_abort(comm_world(), 1);
    exit(1);
  }
  close(file);
  comm_max(comm_world(), 0);
  unlink(path);
}

static void tell(const char *why) {
  fprintf(stderr, "rank %d: %s\n", comm_rank(comm_world()), why);
}

/* The others wait in comm_queue_end for a rank that never comes there. */
static void fail_alone(const char *how) {
  comm_queue queue;
  comm_queue_begin(&queue, 0, NULL);
  if (comm_rank(comm_world()) == comm_size(comm_world()) - 1) {
    doze(0.2);
    if (strcmp(how, "abort") == 0) comm_abort(comm_world(), SD_ERROR_IO);
    comm_on_fail(tell);
    if (strcmp(how, "fail") == 0) comm_fail(comm_world(), "no memory");
    if (strcmp(how, "die") == 0) raise(SIGKILL);
  }
  comm_queue_end(&queue);
}

int main(int argc, char **argv) {
  if (argc > 1) expected_size = (int)strtol(argv[1], NULL, 10);
  sd_messages *messages = sd_messages_new();
  if (expected_size == 1) refused_when_launched_apart();
  sd_status status = comm_begin(messages);
  sd_messages_print(messages, stderr);
  sd_messages_free(messages);
  if (status != SD_OK) return status;
  if (argc > 2) {
    fail_alone(argv[2]);
    return 1; /* never here */
  }
  open_book();
  struct sigaction action = {.sa_handler = on_alarm, .sa_flags = SA_RESTART};
  sigaction(SIGALRM, &action, NULL);
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(ranks_know_each_other),
      cmocka_unit_test(the_largest_reaches_all),
      cmocka_unit_test(the_first_ranks_data_reach_all),
      cmocka_unit_test(every_task_is_given_once),
      cmocka_unit_test(many_queues_in_a_row),
      cmocka_unit_test(rank_0_serves_while_it_works),
      cmocka_unit_test(ranks_may_go_early),
      cmocka_unit_test(a_stop_reaches_all),
      cmocka_unit_test(a_stop_near_the_end),
      cmocka_unit_test(a_stop_while_waiting_for_an_answer),
      cmocka_unit_test(waits_sleep),
  };
  int failed = cmocka_run_group_tests(tests, NULL, NULL);
  comm_end();
  return failed;
}

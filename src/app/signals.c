/* signals.c: what stops a run; see app.h. */
#include <signal.h>
#include <stddef.h>
#include <unistd.h>

#include "app/app.h"

volatile sig_atomic_t app_stop;
static volatile sig_atomic_t begun;

void app_tell_no_start(void) {
  static const char text[] = "stopped before the first step: there was nothing new to save\n";
  ssize_t told = write(STDERR_FILENO, text, sizeof text - 1);
  (void)told; /* there is no other way to tell it */
}

/* Until something has begun there is nothing to save, and whatever takes long can be left where it stands. */
static void ask_stop(int number) {
  if (begun) {
    app_stop = number;
    return;
  }
  app_tell_no_start();
  _exit(SD_INTERRUPTED);
}

void app_catch_signals(void) {
  struct sigaction action = {.sa_handler = ask_stop, .sa_flags = SA_RESTART};
  sigemptyset(&action.sa_mask);
  /* batch systems send XCPU, USR1, USR2 and TERM before they kill; an alarm set by the caller outlives exec */
  const int stops[] = {SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU, SIGALRM};
  for (size_t k = 0; k < sizeof stops / sizeof *stops; k++) sigaction(stops[k], &action, NULL);
  /* a closed terminal stops a run like Ctrl-C, but not under nohup */
  struct sigaction before;
  if (sigaction(SIGHUP, NULL, &before) == 0 && before.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, NULL);
  /* a file-size limit and a reader that went away are errors of a write, not the end of the process */
  struct sigaction ignore = {.sa_handler = SIG_IGN};
  sigemptyset(&ignore.sa_mask);
  sigaction(SIGXFSZ, &ignore, NULL);
  sigaction(SIGPIPE, &ignore, NULL);
}

void app_begin_saving(void) { begun = 1; }

/* signals.c: what stops a run; see app.h. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <signal.h>
#include <stddef.h>

#include "app/app.h"

volatile sig_atomic_t app_stop;

static void ask_stop(int number) { app_stop = number; }

void app_catch_signals(void) {
  struct sigaction action = {.sa_handler = ask_stop, .sa_flags = SA_RESTART};
  sigemptyset(&action.sa_mask);
  const int stops[] = {SIGINT, SIGTERM, SIGUSR1};
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

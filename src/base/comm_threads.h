/* comm_threads.h: ranks that are threads of one process, so that tests need no launcher. */
#ifndef BASE_COMM_THREADS_H
#define BASE_COMM_THREADS_H

#include "base/comm.h"

/* Runs task(c, with) on n ranks, each a thread, and returns when all have returned. A rank that
 * fails (comm_abort) ends the process with abort(). */
void comm_threads_run(int n, void (*task)(const comm *c, void *with), void *with);

#endif

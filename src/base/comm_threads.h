/* comm_threads.h: ranks that are threads of one process, so that tests need no launcher. */
#ifndef BASE_COMM_THREADS_H
#define BASE_COMM_THREADS_H

#include "base/comm.h"

/* Runs task(c, with) on n ranks, each a thread, and returns when all have returned. Without memory, or
 * after comm_abort, the process ends as memory_lacks says. */
void comm_threads_run(int n, void (*task)(const comm *c, void *with), void *with);

#endif

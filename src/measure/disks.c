/* disks.c: see disks.h. */
#include "measure/disks.h"

void disks_begin(engine *e) { (void)e; }
void disks_step(engine *e) { (void)e; }
void disks_end(engine *e) { (void)e; }

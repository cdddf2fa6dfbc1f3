/* shortage.c: see shortage.h. */
#include "base/shortage.h"

#include <stdatomic.h>

static atomic_bool seen;

void shortage_note(void) { atomic_store_explicit(&seen, true, memory_order_relaxed); }
bool shortage_seen(void) { return atomic_load_explicit(&seen, memory_order_relaxed); }

/* shortage.h: has an allocation failed where no caller could be told?
 *
 * Functions that return numbers or texts have no status: without memory they return NAN, NULL, or what stands for "not
 * there". Libraries do likewise. They note it here, and who reports or decides by what they returned asks.
 */
#ifndef SLIPDISK_BASE_SHORTAGE_H
#define SLIPDISK_BASE_SHORTAGE_H

#include <stdbool.h>

void shortage_note(void);
bool shortage_seen(void); /* since the process began */

#endif

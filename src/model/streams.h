/* streams.h: number of a random stream, fixed by what it drives. */
#ifndef MODEL_STREAMS_H
#define MODEL_STREAMS_H

#include <stdint.h>

/* index: of the disk, the wall, the group, or the first body of a list. */
enum { STREAM_DISK, STREAM_WALL, STREAM_GROUP, STREAM_LIST, STREAM_THINGS };
enum { STREAM_INDICES = 1 << 24, STREAM_ORDINALS = 16 };

/* ordinal: of the random motions on this coordinate of this thing, as they were given. */
static inline uint32_t stream_number(int thing, uint32_t index, unsigned ordinal, int coordinate) {
  return index << 8 | ordinal << 4 | (unsigned)coordinate << 2 | (unsigned)thing;
}

#endif

/* segments.h: the segments of walls that are not circles. */
#ifndef MODEL_SEGMENTS_H
#define MODEL_SEGMENTS_H

#include <stdbool.h>
#include <stdint.h>

/* Shape of a wall segment: straight line, circular arc, or one of the end points of an arc. */
typedef enum sd_piece {
  SD_PIECE_STRAIGHT,
  SD_PIECE_CURVE,
  SD_PIECE_FIRST_END,
  SD_PIECE_LAST_END
} sd_piece;

/* A segment of a wall in the wall's own frame (origin at the pivot, angle 0 at the start). */
typedef struct sd_segment {
  uint32_t body; /* body number of the wall */
  sd_piece piece;
  /* First end of the segment; for an infinite line any point of it; for an arc the centre of its
   * circle. */
  double start[2];
  double tangent[2]; /* straight segments: unit vector from the first end to the second */
  /* length of the segment; HUGE_VAL for an infinite line, which extends to both sides of `start` */
  double length;
  /* Tangent of the previous segment, or -tangent at a free end; it bounds the region in which
   * the first end of this segment is the nearest point. */
  double previous[2];
  bool end_cap; /* True if the second end of the segment is free and acts as a point contact. */
  /* Arc length along the wall from the start of the wall to the first end of this segment; on an
   * arc from the middle of the arc. */
  double arc;
  int64_t next; /* index of the next segment of the wall; -1: none */
  /* Arc: radius, and unit vectors from the centre to its two ends and to the point midway. */
  double radius;
  double first[2], last[2], middle[2];
  bool wide; /* true for an arc of more than 180 degrees */
  /* Number of the vertex at the first and at the second end, shared by all segments that meet
   * there; 0: none. `meets`: true if ends of other walls lie there. */
  uint32_t vertex[2];
  bool meets[2];
  /* Periodic box: image[c] is true if the segment has images along coordinate c; center:
   * midpoint of the segment relative to `start`; cells: number of box lengths to the start of
   * the next segment, if the wall continues in its own image. */
  bool image[2];
  double center[2];
  int cells[2];
} sd_segment;

#endif

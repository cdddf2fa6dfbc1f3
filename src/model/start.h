/* start.h: what a disk or a contact brings along from an earlier run. */
#ifndef MODEL_START_H
#define MODEL_START_H

#include <stdint.h>

#include "slipdisk/contact.h"

/* Higher derivatives per disk that Gear's integrator needs: the 3rd to 5th of x, of y and of
 * theta. */
enum { SD_DERIVATIVES = 9 };

/* History of a contact that is closed when the run starts (columns contact_* of state.h). */
typedef struct sd_contact_memory {
  /* Body numbers of the disk and its partner in this model; index of the segment if the partner
   * is a wall (0: round body). */
  uint32_t a, b, part;
  int16_t slide; /* 0: the contact sticks; +1, -1: it slides with that sign of the torque. */
  /* 1 if the contact law is that of the previous run, so that the stored force is still valid at
   * step 0. */
  int16_t force_carried;
  double side; /* +1, -1: side of a straight wall on which the disk is; 0: round body. */
  sd_contact_record record;
} sd_contact_memory;

#endif

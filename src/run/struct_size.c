/* struct_size.c: sizes of public structs, for programs in other languages. */
#include <string.h>

#include "slipdisk/slipdisk.h"

size_t sd_struct_size(const char *name) {
#define SIZE(type)                                                                                 \
  { #type, sizeof(type) }
  static const struct {
    const char *name;
    size_t size;
  } sizes[] = {SIZE(sd_field),      SIZE(sd_deck),  SIZE(sd_energy),      SIZE(sd_stage),
               SIZE(sd_goal),       SIZE(sd_slide), SIZE(sd_rotation),    SIZE(sd_configuration),
               SIZE(sd_disk_mean),  SIZE(sd_mean),  SIZE(sd_quantity),    SIZE(sd_measurement),
               SIZE(sd_disk),       SIZE(sd_clump), SIZE(sd_wall),        SIZE(sd_motion),
               SIZE(sd_body_force), SIZE(sd_phase), SIZE(sd_contact_law), SIZE(sd_force_columns)};
#undef SIZE
  for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
    if (strcmp(sizes[k].name, name) == 0) return sizes[k].size;
  return 0;
}

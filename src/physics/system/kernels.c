/* kernels.c: chooses the instruction set of the kernels. */
#include "physics/system/kernels.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

extern const kernels kernels_baseline;
#ifdef SD_HAVE_AVX2
extern const kernels kernels_avx2;
#endif
#ifdef SD_HAVE_AVX512
extern const kernels kernels_avx512;
#endif

const kernels *kernels_named(const char *name) {
#ifdef SD_HAVE_AVX512
  if (strcmp(name, "avx512") == 0 && __builtin_cpu_supports("avx512f") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    return &kernels_avx512;
#endif
#ifdef SD_HAVE_AVX2
  if (strcmp(name, "avx2") == 0 && __builtin_cpu_supports("avx2")) return &kernels_avx2;
#endif
  return strcmp(name, "baseline") == 0 ? &kernels_baseline : NULL;
}

const kernels *kernels_choose(void) {
  const char *asked = getenv("SLIPDISK_PATH");
  const kernels *k = asked ? kernels_named(asked) : NULL;
  if (!k) k = kernels_named("avx512");
  if (!k) k = kernels_named("avx2");
  k = k ? k : &kernels_baseline;
  assert(k->pairs && k->lanes && k->motion && k->lane_width >= 1 &&
         PAIR_BLOCK % k->lane_width == 0);
  return k;
}

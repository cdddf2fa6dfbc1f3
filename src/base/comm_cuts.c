/* comm_cuts.c: see comm_cuts.h. */
#include "base/comm_cuts.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/comm.h"
#include "base/memory.h"

#ifdef SD_HAVE_MPI
#include <zoltan.h>

#include "base/comm_mpi.h"

struct comm_cuts {
  struct Zoltan_Struct *zoltan;
  /* of comm_cuts_make, while it works */
  size_t n;
  const double *x, *y;
  const float *weight;
};

/* --- what Zoltan asks for -------------------------------------------------------------------------------- */

static int count_points(void *data, int *error) {
  *error = ZOLTAN_OK;
  return (int)((const comm_cuts *)data)->n;
}

/* Points are known by their place here; nothing is sent by Zoltan itself. */
static void list_points(void *data, int n_global, int n_local, ZOLTAN_ID_PTR global, ZOLTAN_ID_PTR local,
                        int n_weights, float *weight, int *error) {
  const comm_cuts *c = data;
  (void)n_global, (void)n_local;
  for (size_t k = 0; k < c->n; k++) {
    global[k] = local[k] = (ZOLTAN_ID_TYPE)k;
    if (n_weights > 0) weight[k] = c->weight[k];
  }
  *error = ZOLTAN_OK;
}

static int count_axes(void *data, int *error) {
  (void)data;
  *error = ZOLTAN_OK;
  return 2;
}

static void tell_points(void *data, int n_global, int n_local, int n, ZOLTAN_ID_PTR global,
                        ZOLTAN_ID_PTR local, int axes, double *at, int *error) {
  const comm_cuts *c = data;
  (void)n_global, (void)n_local, (void)global, (void)axes;
  for (int k = 0; k < n; k++) {
    at[2 * k] = c->x[local[k]];
    at[2 * k + 1] = c->y[local[k]];
  }
  *error = ZOLTAN_OK;
}

comm_cuts *comm_cuts_new(void) {
  static const char *const parameters[][2] = {
      {"DEBUG_LEVEL", "0"},    {"LB_METHOD", "RCB"},     {"KEEP_CUTS", "1"},       {"RETURN_LISTS", "NONE"},
      {"OBJ_WEIGHT_DIM", "1"}, {"NUM_GID_ENTRIES", "1"}, {"NUM_LID_ENTRIES", "1"}, {"IMBALANCE_TOL", "1.01"},
      {"CHECK_GEOM", "0"},     {"RCB_OUTPUT_LEVEL", "0"}};
  float version;
  comm_cuts *c = memory_new(1, sizeof *c);
  if (comm_size() == 1) return c;
  if (Zoltan_Initialize(0, NULL, &version) != ZOLTAN_OK || !(c->zoltan = Zoltan_Create(comm_ranks))) {
    free(c);
    return NULL;
  }
  for (size_t k = 0; k < sizeof parameters / sizeof *parameters; k++)
    Zoltan_Set_Param(c->zoltan, parameters[k][0], parameters[k][1]);
  Zoltan_Set_Num_Obj_Fn(c->zoltan, count_points, c);
  Zoltan_Set_Obj_List_Fn(c->zoltan, list_points, c);
  Zoltan_Set_Num_Geom_Fn(c->zoltan, count_axes, c);
  Zoltan_Set_Geom_Multi_Fn(c->zoltan, tell_points, c);
  return c;
}

void comm_cuts_free(comm_cuts *c) {
  if (c && c->zoltan) Zoltan_Destroy(&c->zoltan);
  free(c);
}

sd_status comm_cuts_make(comm_cuts *c, size_t n, const double *x, const double *y, const float *weight) {
  if (!c->zoltan) return SD_OK;
  int changes, n_global, n_local, n_import, n_export, *ranks[4];
  ZOLTAN_ID_PTR ids[4];
  c->n = n;
  c->x = x;
  c->y = y;
  c->weight = weight;
  const int done =
      Zoltan_LB_Partition(c->zoltan, &changes, &n_global, &n_local, &n_import, &ids[0], &ids[1], &ranks[0],
                          &ranks[1], &n_export, &ids[2], &ids[3], &ranks[2], &ranks[3]);
  return done == ZOLTAN_OK || done == ZOLTAN_WARN ? SD_OK : SD_ERROR_IO;
}

int comm_cuts_owner(const comm_cuts *c, double x, double y) {
  double at[3] = {x, y, 0.0};
  int rank = 0, part = 0;
  if (c->zoltan && Zoltan_LB_Point_PP_Assign(c->zoltan, at, &rank, &part) != ZOLTAN_OK) rank = 0;
  assert(rank >= 0 && rank < comm_size());
  return rank;
}

int comm_cuts_near(const comm_cuts *c, const double low[2], const double high[2], int *ranks) {
  int n = 0;
  if (c->zoltan)
    Zoltan_LB_Box_Assign(c->zoltan, low[0], low[1], -1.0, high[0], high[1], 1.0, ranks, &n);
  else
    ranks[n++] = 0;
  return n;
}

static double end_of(double at) {
  return at >= 0.5 * DBL_MAX ? HUGE_VAL : at <= -0.5 * DBL_MAX ? -HUGE_VAL : at;
}

void comm_cuts_mine(const comm_cuts *c, double low[2], double high[2]) {
  int axes;
  double z[2];
  low[0] = low[1] = -HUGE_VAL;
  high[0] = high[1] = HUGE_VAL;
  if (!c->zoltan) return;
  Zoltan_RCB_Box(c->zoltan, comm_rank(), &axes, &low[0], &low[1], &z[0], &high[0], &high[1], &z[1]);
  for (int k = 0; k < 2; k++) {
    low[k] = end_of(low[k]);
    high[k] = end_of(high[k]);
  }
}

#else

struct comm_cuts {
  int nothing;
};

comm_cuts *comm_cuts_new(void) { return memory_new(1, sizeof(comm_cuts)); }
void comm_cuts_free(comm_cuts *c) { free(c); }
sd_status comm_cuts_make(comm_cuts *c, size_t n, const double *x, const double *y, const float *weight) {
  (void)c, (void)n, (void)x, (void)y, (void)weight;
  return SD_OK;
}
int comm_cuts_owner(const comm_cuts *c, double x, double y) {
  (void)c, (void)x, (void)y;
  return 0;
}
int comm_cuts_near(const comm_cuts *c, const double low[2], const double high[2], int *ranks) {
  (void)c, (void)low, (void)high;
  ranks[0] = 0;
  return 1;
}
void comm_cuts_mine(const comm_cuts *c, double low[2], double high[2]) {
  (void)c;
  low[0] = low[1] = -HUGE_VAL;
  high[0] = high[1] = HUGE_VAL;
}

#endif

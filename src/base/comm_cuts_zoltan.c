/* comm_cuts_zoltan.c: divides the plane among the ranks of an MPI job with the library Zoltan; see
 * comm_cuts.h. Empty in builds without MPI. */
#ifdef SD_HAVE_MPI
#include "base/comm_cuts.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <zoltan.h>

#include "base/comm_mpi.h"
#include "base/memory.h"

struct zoltan_cuts {
  struct Zoltan_Struct *zoltan;
  /* arguments of zoltan_cuts_make, which callbacks from Zoltan read while it runs */
  size_t n;
  const double *x, *y;
  const float *weight;
};

/* --- callbacks through which Zoltan reads the points ------------------------------------------ */

static int count_points(void *data, int *error) {
  *error = ZOLTAN_OK;
  return (int)((const zoltan_cuts *)data)->n;
}

/* Callback with which Zoltan lists the points of this rank: an ID is an index into the arrays. The
 * same ID may occur on several ranks, since Zoltan moves no data between ranks here. */
static void list_points(void *data, int n_global, int n_local, ZOLTAN_ID_PTR global,
                        ZOLTAN_ID_PTR local, int n_weights, float *weight, int *error) {
  const zoltan_cuts *c = data;
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
  const zoltan_cuts *c = data;
  (void)n_global, (void)n_local, (void)global, (void)axes;
  for (int k = 0; k < n; k++) {
    at[2 * k] = c->x[local[k]];
    at[2 * k + 1] = c->y[local[k]];
  }
  *error = ZOLTAN_OK;
}

zoltan_cuts *zoltan_cuts_new(void) {
  static const char *const parameters[][2] = {{"DEBUG_LEVEL", "0"},     {"LB_METHOD", "RCB"},
                                              {"KEEP_CUTS", "1"},       {"RETURN_LISTS", "NONE"},
                                              {"OBJ_WEIGHT_DIM", "1"},  {"NUM_GID_ENTRIES", "1"},
                                              {"NUM_LID_ENTRIES", "1"}, {"IMBALANCE_TOL", "1.01"},
                                              {"CHECK_GEOM", "0"},      {"RCB_OUTPUT_LEVEL", "0"}};
  float version;
  zoltan_cuts *c = memory_new(1, sizeof *c);
  if (Zoltan_Initialize(0, NULL, &version) != ZOLTAN_OK ||
      !(c->zoltan = Zoltan_Create(comm_ranks))) {
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

void zoltan_cuts_free(zoltan_cuts *c) {
  Zoltan_Destroy(&c->zoltan);
  free(c);
}

sd_status zoltan_cuts_make(zoltan_cuts *c, size_t n, const double *x, const double *y,
                           const float *weight) {
  int changes, n_global, n_local, n_import, n_export, *ranks[4];
  ZOLTAN_ID_PTR ids[4];
  c->n = n;
  c->x = x;
  c->y = y;
  c->weight = weight;
  const int done =
      Zoltan_LB_Partition(c->zoltan, &changes, &n_global, &n_local, &n_import, &ids[0], &ids[1],
                          &ranks[0], &ranks[1], &n_export, &ids[2], &ids[3], &ranks[2], &ranks[3]);
  return done == ZOLTAN_OK || done == ZOLTAN_WARN ? SD_OK : SD_ERROR_IO;
}

int zoltan_cuts_owner(const zoltan_cuts *c, double x, double y) {
  double at[3] = {x, y, 0.0};
  int rank = 0, part = 0;
  if (Zoltan_LB_Point_PP_Assign(c->zoltan, at, &rank, &part) != ZOLTAN_OK) rank = 0;
  assert(rank >= 0 && rank < comm_size(comm_world()));
  return rank;
}

int zoltan_cuts_near(const zoltan_cuts *c, const double low[2], const double high[2], int *ranks) {
  int n = 0;
  Zoltan_LB_Box_Assign(c->zoltan, low[0], low[1], -1.0, high[0], high[1], 1.0, ranks, &n);
  return n;
}

static double end_of(double at) {
  return at >= 0.5 * DBL_MAX ? HUGE_VAL : at <= -0.5 * DBL_MAX ? -HUGE_VAL : at;
}

void zoltan_cuts_of(const zoltan_cuts *c, int rank, double low[2], double high[2]) {
  int axes;
  double z[2];
  Zoltan_RCB_Box(c->zoltan, rank, &axes, &low[0], &low[1], &z[0], &high[0], &high[1], &z[1]);
  for (int k = 0; k < 2; k++) {
    low[k] = end_of(low[k]);
    high[k] = end_of(high[k]);
  }
}
#else
typedef int comm_cuts_zoltan_none; /* ISO C requires at least one declaration in a file */
#endif

/* h5_md.c: reads groups of particles of H5MD files: chooses the step at which their elements are
 * read, reads their box, and finds rows without a particle.
 *
 * An element is a dataset that does not change, or a group with the datasets `value` [frame]...,
 * `step` and `time`. Each element may have steps of its own: a list, or a scalar, which is the
 * interval between steps and whose attribute `offset` is the first step.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/text.h"
#include "io/store/h5_private.h"

/* --- Steps ------------------------------------------------------------------------------------ */

static sd_status fail(const h5_file *file, const char *group, sd_messages *messages,
                      const char *name, const char *what) {
  return sd_fail(messages, SD_ERROR_USER, "%s: %s: %s %s", file->path, group, name, what);
}

/* Returns the time step number of a frame of an element. */
static int64_t step_of(const h5_element *e, size_t frame) {
  return e->step ? e->step[frame] : e->offset + (int64_t)frame * e->interval;
}

/* Reads the list of steps of an element's frames. The steps must ascend, which detects frames that
 * were never written, with step 0. */
static sd_status read_list(const h5_file *file, const char *group, const char *path, h5_element *e,
                           sd_messages *messages) {
  sd_status status = SD_OK;
  e->step = h5_column(file, path, SD_I64, e->frames, &status, messages);
  for (size_t k = 1; status == SD_OK && k < e->frames; k++)
    if (e->step[k] <= e->step[k - 1])
      status = fail(file, group, messages, e->name, "has steps that do not ascend");
  return status;
}

/* Reads the steps of an element with frames, if it has any. */
static sd_status read_steps(const h5_file *file, const char *group, h5_element *e,
                            sd_messages *messages) {
  size_t dims[H5_MAX_RANK];
  int rank;
  char *path = format_text("%s/%s/step", group, e->name);
  sd_status status = SD_OK;
  if (h5_is_link(file, path)) {
    status = fail(file, group, messages, e->name, "has steps behind a link, which is not followed");
  } else if (h5_exists(file, path)) {
    status = h5_shape(file, path, &rank, dims, messages);
    e->stepped = true;
    if (status == SD_OK && rank == 0) {
      status = h5_get(file, path, SD_I64, 1, &e->interval, messages);
      e->offset = h5_get_attr_i64(file, path, "offset", 0);
      if (status == SD_OK && (e->interval < 1 || e->interval > INT64_MAX / 2 / (int64_t)e->frames))
        status = fail(file, group, messages, e->name,
                      "has a distance of steps that is no positive number");
    } else if (status == SD_OK && (rank != 1 || dims[0] != e->frames)) {
      status = fail(file, group, messages, e->name, "has another number of steps than of frames");
    } else if (status == SD_OK) {
      status = read_list(file, group, path, e, messages);
    }
  }
  free(path);
  return status;
}

/* Finds out whether the values of an element are in frames, and reads the number and the steps of
 * these frames. */
static sd_status find_element(const h5_file *file, const char *group, h5_element *e,
                              sd_messages *messages) {
  size_t dims[H5_MAX_RANK];
  int rank;
  char *path = format_text("%s/%s/value", group, e->name);
  e->framed = h5_exists(file, path);
  sd_status status = e->framed ? h5_shape(file, path, &rank, dims, messages) : SD_OK;
  if (status == SD_OK && e->framed && (rank < 1 || dims[0] == 0))
    status = fail(file, group, messages, e->name, "has no frames");
  if (status == SD_OK && e->framed) e->frames = dims[0];
  free(path);
  return status == SD_OK && e->framed ? read_steps(file, group, e, messages) : status;
}

/* Selects the last frame of an element whose step is at most `step`; returns false if there is
 * none. */
static bool frame_until(h5_element *e, int64_t step) {
  size_t low = 0, high = e->frames;
  while (low < high) {
    const size_t middle = low + (high - low) / 2;
    if (step_of(e, middle) <= step)
      low = middle + 1;
    else
      high = middle;
  }
  e->frame = low > 0 ? low - 1 : 0;
  return low > 0;
}

/* Finds the last step, at most *step, that all elements with frames have, and selects their frames;
 * returns false if there is none. */
static bool common_step(h5_element *e, size_t n, int64_t *step) {
  bool agreed = false;
  while (!agreed) {
    agreed = true;
    for (size_t k = 0; k < n; k++) {
      if (!e[k].framed) continue;
      if (!frame_until(&e[k], *step)) return false;
      const int64_t found = step_of(&e[k], e[k].frame);
      agreed = agreed && found == *step;
      *step = found;
    }
  }
  return true;
}

/* Selects the last frame of each element, for elements without steps. Frames are then matched by
 * their number alone, so that all elements must have the same number of frames. */
static sd_status without_steps(const h5_file *file, const char *group, h5_element *e, size_t n,
                               sd_messages *messages) {
  const h5_element *first = NULL;
  for (size_t k = 0; k < n; k++) {
    if (!e[k].framed) continue;
    e[k].frame = e[k].frames - 1;
    if (first && (first->stepped != e[k].stepped || first->frames != e[k].frames))
      return sd_fail(
          messages, SD_ERROR_USER,
          "%s: %s: the steps of %s and %s are not all given: whether their values belong together "
          "cannot be told",
          file->path, group, first->name, e[k].name);
    if (!first) first = &e[k];
  }
  return SD_OK;
}

sd_status h5_moment(const h5_file *file, const char *group, h5_element *e, size_t n, int64_t *step,
                    sd_messages *messages) {
  sd_status status = SD_OK;
  const h5_element *latest = NULL, *earliest = NULL;
  bool stepped = true;
  *step = -1;
  for (size_t k = 0; k < n && status == SD_OK; k++) {
    status = find_element(file, group, &e[k], messages);
    if (status != SD_OK || !e[k].framed) continue;
    stepped = stepped && e[k].stepped;
    if (!stepped) continue;
    const int64_t last = step_of(&e[k], e[k].frames - 1);
    if (!latest || last > step_of(latest, latest->frames - 1)) latest = &e[k];
    if (!earliest || last < step_of(earliest, earliest->frames - 1)) earliest = &e[k];
  }
  if (status == SD_OK && !stepped) status = without_steps(file, group, e, n, messages);
  if (status == SD_OK && stepped && latest) {
    const int64_t end = step_of(latest, latest->frames - 1);
    *step = step_of(earliest, earliest->frames - 1);
    if (!common_step(e, n, step))
      status = sd_fail(
          messages, SD_ERROR_USER,
          "%s: %s: its elements have no step in common, %s ends at step %lld, %s at %lld; expected "
          "values of one moment",
          file->path, group, latest->name, (long long)end, earliest->name,
          (long long)step_of(earliest, earliest->frames - 1));
    else if (*step != end)
      sd_warn(messages,
              "%s: %s: step %lld is read, the last one that all have: %s goes on until step %lld, "
              "%s until %lld",
              file->path, group, (long long)*step, latest->name, (long long)end, earliest->name,
              (long long)step_of(earliest, earliest->frames - 1));
  }
  for (size_t k = 0; k < n; k++) {
    free(e[k].step);
    e[k].step = NULL;
  }
  return status;
}

/* --- Rows without a particle ------------------------------------------------------------------ */

/* Reads the fill value of a dataset, which elements have that were never written; returns false if
 * the file defines none. */
static bool fill_value(const h5_file *file, const char *path, double *fill) {
  hid_t set = h5_open_data(file, path, NULL);
  if (set < 0) return false;
  hid_t made = H5Dget_create_plist(set);
  H5D_fill_value_t kind = H5D_FILL_VALUE_UNDEFINED;
  const bool given = H5Pfill_value_defined(made, &kind) >= 0 &&
                     kind == H5D_FILL_VALUE_USER_DEFINED &&
                     H5Pget_fill_value(made, H5T_NATIVE_DOUBLE, fill) >= 0;
  H5Pclose(made);
  H5Oclose(set);
  return given;
}

bool h5_is_fill(const h5_file *file, const char *path, double *fill) {
  /* a fill value 0 cannot be told from zeros that were written */
  return fill_value(file, path, fill) && *fill != 0;
}

/* Returns true if slipdisk wrote the file, which then has rows also for waiting and removed
 * disks. */
static bool is_ours(const h5_file *file) {
  char *creator = h5_get_attr_text(file, "/h5md/creator", "name");
  const bool ours = creator && strncmp(creator, "slipdisk", 8) == 0;
  free(creator);
  return ours;
}

const char *h5_absence(const h5_file *file, const char *group) {
  static const char *const names[] = {"activity", "id"};
  for (size_t k = is_ours(file) ? 0 : 1; k < 2; k++) {
    char *path = format_text("%s/%s", group, names[k]);
    const bool there = h5_exists(file, path);
    free(path);
    if (there) return names[k];
  }
  return NULL;
}

sd_status h5_absent(const h5_file *file, const char *group, const h5_element *e,
                    const double *value, size_t n, bool *gone, sd_messages *messages) {
  char *path = format_text(e->framed ? "%s/%s/value" : "%s/%s", group, e->name);
  const bool id = strcmp(e->name, "id") == 0;
  double fill = 0;
  const bool given = id && fill_value(file, path, &fill);
  size_t zeros = 0;
  free(path);
  for (size_t k = 0; k < n; k++) {
    gone[k] = id ? value[k] < 0 || (given && value[k] == fill) : value[k] == 1 || value[k] == 2;
    zeros += id && !given && value[k] == 0;
  }
  return zeros < 2 ? SD_OK
                   : fail(file, group, messages, e->name,
                          "is 0 in several rows: whether particles stand in them cannot be told");
}

/* --- Box -------------------------------------------------------------------------------------- */

enum { MOST_GROUPS = 16 };
/* List of the groups of particles that contain certain datasets. */
typedef struct groups {
  const char *const *tails; /* a group counts if it contains a dataset of one of these two paths */
  char *name[MOST_GROUPS];  /* [n] paths "/particles/NAME" */
  size_t n;
  bool lost; /* true if there are more than MOST_GROUPS */
} groups;

/* Called by h5_visit for a dataset: adds its group of particles to the list if the dataset is one
 * of those sought. */
static void take_group(void *user, const char *path, sd_type type, bool text, int rank,
                       const size_t *dims) {
  static const char head[] = "/particles/";
  groups *g = user;
  (void)type, (void)text, (void)rank, (void)dims;
  const size_t first = sizeof head - 1,
               name = strncmp(path, head, first) == 0 ? strcspn(path + first, "/") : 0;
  if (name == 0) return;
  const char *tail = path + first + name;
  if (strcmp(tail, g->tails[0]) != 0 && strcmp(tail, g->tails[1]) != 0) return;
  for (size_t k = 0; k < g->n; k++)
    if (strlen(g->name[k]) == first + name && strncmp(g->name[k], path, first + name) == 0) return;
  if (g->n < MOST_GROUPS)
    g->name[g->n++] = format_text("%.*s", (int)(first + name), path);
  else
    g->lost = true;
}

static void free_groups(groups *g) {
  for (size_t k = 0; k < g->n; k++) free(g->name[k]);
}

char *h5_only_particles(const char *path) {
  static const char *const tails[] = {"/position", "/position/value"};
  groups g = {.tails = tails};
  h5_file *file;
  char *only = NULL;
  if (h5_open(path, &file, NULL) != SD_OK) return NULL;
  const bool listed = !h5_exists(file, "/state") && h5_visit(file, take_group, &g, NULL) == SD_OK;
  if (listed && g.n == 1 && !g.lost) only = memory_text(g.name[0]);
  free_groups(&g);
  h5_close(file, NULL);
  return only;
}

/* Reads the edges of the box at the step of the positions. The file has lengths, or a matrix with
 * one edge vector per row; `matrix` receives a matrix in both cases. */
static sd_status read_edges(const h5_file *file, const char *group, int *dimension,
                            double matrix[3][3], int64_t *step, sd_messages *messages) {
  h5_element e[2] = {{.name = "box/edges"}, {.name = "position"}};
  size_t dims[H5_MAX_RANK];
  int rank;
  double found[9];
  sd_status status = h5_moment(file, group, e, 2, step, messages);
  if (status != SD_OK) return status;
  if (!e[0].framed) *step = -1;
  char *path = format_text(e[0].framed ? "%s/box/edges/value" : "%s/box/edges", group);
  status = h5_shape(file, path, &rank, dims, messages);
  const size_t *inner = dims + e[0].framed, d = inner[0];
  const int inner_rank = rank - e[0].framed;
  const bool square = inner_rank == 2 && inner[1] == d;
  if (status == SD_OK && ((inner_rank != 1 && !square) || (d != 2 && d != 3)))
    status = fail(file, group, messages, "box/edges",
                  "has the shape of no box in two or three dimensions");
  const size_t n = square ? d * d : d;
  if (status == SD_OK)
    status = e[0].framed ? h5_get_values(file, path, SD_F64, e[0].frame, 1, n, found, messages)
                         : h5_get(file, path, SD_F64, n, found, messages);
  free(path);
  if (status != SD_OK) return status;
  memset(matrix, 0, 9 * sizeof(double));
  for (size_t i = 0; i < d; i++)
    for (size_t j = 0; j < d; j++)
      matrix[i][j] = square ? found[i * d + j] : i == j ? found[i] : 0.0;
  *dimension = (int)d;
  return SD_OK;
}

/* Checks that the edges of the box are along x and y, and that neighbouring rows of periodic images
 * are shifted against one another by whole widths at most. */
static sd_status check_edges(const h5_file *file, const char *group, double a[3][3],
                             sd_messages *messages) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      if (!isfinite(a[i][j]) || (i == j && a[i][j] < 0))
        return fail(file, group, messages, "box/edges", "are no lengths");
  const double least = 1e-9 * (a[0][0] + a[1][1]);
  if (fabs(a[0][1]) > least || fabs(a[0][2]) > least || fabs(a[1][2]) > least ||
      fabs(a[2][0]) > least || fabs(a[2][1]) > least)
    return fail(file, group, messages, "box/edges",
                "are not along x and y; expected a rectangular box");
  const double shift = a[0][0] > 0 ? remainder(a[1][0], a[0][0]) : a[1][0];
  if (fabs(shift) <= least) return SD_OK;
  return sd_fail(
      messages, SD_ERROR_USER,
      "%s: %s: the box of this file is sheared, its rows of images are shifted by %g of its width; "
      "expected one that is not, or was sheared by a whole width",
      file->path, group, shift / a[0][0]);
}

/* Reads the box of a group of particles: its edges, and the directions that are not periodic. */
static sd_status box_of_group(const h5_file *file, const char *group, h5_box *box,
                              sd_messages *messages) {
  double a[3][3] = {{0}}, lower[3] = {0, 0, 0};
  int d = 0;
  sd_status status = read_edges(file, group, &d, a, &box->step, messages);
  if (status == SD_OK) status = check_edges(file, group, a, messages);
  char *path = format_text("%s/box", group);
  char *words = status == SD_OK ? h5_words(file, path, "boundary") : NULL;
  if (status == SD_OK) h5_get_attr_f64s(file, path, "lower", (size_t)d, lower);
  const char *word = words ? words : "";
  for (int c = 0; c < 2 && status == SD_OK; c++) {
    const bool open = strncmp(word, "none\n", 5) == 0;
    const char *next = strchr(word, '\n');
    box->lower[c] = lower[c];
    box->upper[c] = open ? lower[c] : lower[c] + a[c][c];
    if (next && next[1]) word = next + 1; /* a single word stands for all directions */
  }
  free(words);
  free(path);
  return status;
}

static bool is_same_box(const h5_box *a, const h5_box *b) {
  bool same = true;
  for (int c = 0; c < 2; c++)
    same = same && a->lower[c] == b->lower[c] && a->upper[c] == b->upper[c];
  return same;
}

sd_status h5_particles_box(const h5_file *file, bool *found, h5_box *box, sd_messages *messages) {
  static const char *const tails[] = {"/box/edges", "/box/edges/value"};
  groups g = {.tails = tails};
  sd_status status = h5_visit(file, take_group, &g, messages);
  *found = g.n > 0;
  *box = (h5_box){.step = -1};
  if (status == SD_OK && g.lost)
    status = sd_fail(messages, SD_ERROR_USER, "%s: more than %d groups of particles have a box",
                     file->path, MOST_GROUPS);
  for (size_t k = 0; status == SD_OK && k < g.n; k++) {
    h5_box other = {.step = -1};
    status = box_of_group(file, g.name[k], &other, messages);
    if (k == 0) *box = other;
    if (status == SD_OK && !is_same_box(box, &other))
      status = sd_fail(messages, SD_ERROR_USER, "%s: %s and %s have different boxes", file->path,
                       g.name[0], g.name[k]);
  }
  free_groups(&g);
  return status;
}

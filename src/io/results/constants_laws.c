/* constants_laws.c: the laws of contacts in the constants of a result; see constants.h. */
#include "io/results/constants.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "base/limits.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/store/members.h"
#include "model/law_features.h"

#define MODEL "/parameters/model"

enum { LAW = 4 }; /* numbers in one */

/* --- write -------------------------------------------------------------------------------------------- */

static void put(h5_file *file, const char *name, size_t n, size_t width, const void *data,
                const char *unit, const char *meaning) {
  const size_t dims[3] = {n, n, width};
  members_put(file, MODEL, name, SD_F64, 3, dims, data, false, unit, meaning);
}

static void put_laws(h5_file *file, const sd_model *m) {
  size_t n = m->n_materials;
  double(*laws)[LAW] = memory_new(n * n, sizeof *laws);
  for (size_t k = 0; k < n * n; k++) {
    const sd_contact_law *law = &m->laws[k];
    const double value[LAW] = {law->k_n, law->k_t, law->gamma_n, law->mu};
    for (int c = 0; c < LAW; c++) laws[k][c] = value[c];
  }
  put(file, "laws", n, LAW, laws, "force/length, force/length, force time/length, 1",
      "k_n, k_t, gamma_n, mu of each pair of materials; k_n = 0: not given");
  free(laws);
}

/* Written unless all laws are linear with gamma_n. */
static void put_normal_laws(h5_file *file, const sd_model *m) {
  size_t n = m->n_materials;
  bool linear = true;
  for (size_t k = 0; k < n * n; k++)
    linear = linear && m->laws[k].normal == SD_NORMAL_LINEAR && m->laws[k].restitution == 0.0;
  if (linear) return;
  double(*laws)[2] = memory_new(n * n, sizeof *laws);
  for (size_t k = 0; k < n * n; k++) {
    laws[k][0] = m->laws[k].normal;
    laws[k][1] = m->laws[k].restitution;
  }
  put(file, "normal_laws", n, 2, laws, "1",
      "normal law (0 linear, 1 Hertz) and coefficient of restitution of each pair of materials");
  free(laws);
}

/* Members of laws beyond normal_laws, where any has: a row each. */
static const struct law_member {
  const char *name;
  size_t offset;
} law_members[] = {{"damping_pulls", offsetof(sd_contact_law, damping_pulls)},
                   {"tangential", offsetof(sd_contact_law, tangential)},
                   {"cohesion", offsetof(sd_contact_law, cohesion)},
                   {"mu_kinetic", offsetof(sd_contact_law, mu_kinetic)},
                   {"gamma_t", offsetof(sd_contact_law, gamma_t)},
                   {"k_r", offsetof(sd_contact_law, k_r)},
                   {"gamma_r", offsetof(sd_contact_law, gamma_r)},
                   {"mu_r", offsetof(sd_contact_law, mu_r)},
                   {"pull_off", offsetof(sd_contact_law, pull_off)},
                   {"range", offsetof(sd_contact_law, range)},
                   {"rupture", offsetof(sd_contact_law, rupture)}};
enum { LAW_MEMBERS = sizeof law_members / sizeof *law_members, LAW_WORDS = 3 };

/* The first members are words: to numbers and back. */
static double get_law_member(const sd_contact_law *law, size_t c) {
  const double words[LAW_WORDS] = {law->damping_pulls, law->tangential, law->cohesion};
  double x;
  if (c < LAW_WORDS) return words[c];
  memcpy(&x, (const char *)law + law_members[c].offset, sizeof x);
  return x;
}

static void put_general_laws(h5_file *file, const sd_model *m) {
  size_t n = m->n_materials;
  if (!(laws_features(m) & LAW_GENERAL)) return;
  double(*laws)[LAW_MEMBERS] = memory_new(n * n, sizeof *laws);
  for (size_t k = 0; k < n * n; k++)
    for (size_t c = 0; c < LAW_MEMBERS; c++) laws[k][c] = get_law_member(&m->laws[k], c);
  char *text = memory_text("");
  for (size_t c = 0; c < LAW_MEMBERS; c++)
    text = append_text(text, "%s%s", c ? ", " : "", law_members[c].name);
  put(file, "general_laws", n, LAW_MEMBERS, laws, "mixed", text);
  free(text);
  free(laws);
}

void constants_laws_write(h5_file *file, const sd_model *m) {
  put_laws(file, m);
  put_normal_laws(file, m);
  put_general_laws(file, m);
}

/* --- read --------------------------------------------------------------------------------------------- */

typedef struct reader {
  const h5_file *file;
  sd_status status;
  sd_messages *messages;
} reader;

static void read_normal_laws(reader *r, sd_model *m) {
  if (!h5_exists(r->file, MODEL "/normal_laws")) return;
  size_t n = m->n_materials;
  double *laws =
      h5_column(r->file, MODEL "/normal_laws", SD_F64, n * n * 2, &r->status, r->messages);
  for (size_t k = 0; laws && r->status == SD_OK && k < n * n; k++) {
    if (!(laws[2 * k] >= 0.0 && laws[2 * k] < SD_NORMAL_LAWS))
      r->status = sd_fail(r->messages, SD_ERROR_IO, "the laws of the contacts are damaged");
    else
      m->laws[k].normal = (sd_normal_law)laws[2 * k];
    m->laws[k].restitution = laws[2 * k + 1];
  }
  free(laws);
}

static void read_general_laws(reader *r, sd_model *m) {
  if (r->status != SD_OK || !h5_exists(r->file, MODEL "/general_laws")) return;
  size_t n = m->n_materials;
  double *laws = h5_column(r->file, MODEL "/general_laws", SD_F64, n * n * LAW_MEMBERS, &r->status,
                           r->messages);
  for (size_t k = 0; laws && r->status == SD_OK && k < n * n; k++) {
    const double *x = laws + LAW_MEMBERS * k;
    sd_contact_law *law = &m->laws[k];
    if (!(x[1] >= 0.0 && x[1] <= SD_TANGENTIAL_MINDLIN && x[2] >= 0.0 &&
          x[2] <= SD_COHESION_BRIDGE)) {
      r->status = sd_fail(r->messages, SD_ERROR_IO, "the laws of the contacts are damaged");
      break;
    }
    law->damping_pulls = x[0] != 0.0;
    law->tangential = (sd_tangential_law)x[1];
    law->cohesion = (sd_cohesion_law)x[2];
    for (size_t c = LAW_WORDS; c < LAW_MEMBERS; c++)
      memcpy((char *)law + law_members[c].offset, &x[c], sizeof *x);
  }
  free(laws);
}

static void read_laws(reader *r, sd_model *m) {
  int rank = 0;
  size_t dims[H5_MAX_RANK] = {0};
  r->status = h5_shape(r->file, MODEL "/laws", &rank, dims, r->messages);
  const size_t n = r->status == SD_OK && rank > 0 ? dims[0] : 0;
  if (n > LIMIT_MATERIALS)
    r->status = sd_fail(r->messages, SD_ERROR_IO, "%zu materials: the laws are damaged", n);
  if (r->status != SD_OK) return;
  double *laws = h5_column(r->file, MODEL "/laws", SD_F64, n * n * LAW, &r->status, r->messages);
  if (!laws) return;
  m->materials = memory_new(n, sizeof *m->materials);
  m->laws = memory_new(n * n, sizeof *m->laws);
  m->n_materials = n;
  for (size_t k = 0; k < n * n; k++)
    m->laws[k] = (sd_contact_law){.k_n = laws[LAW * k],
                                  .k_t = laws[LAW * k + 1],
                                  .gamma_n = laws[LAW * k + 2],
                                  .mu = laws[LAW * k + 3]};
  free(laws);
  read_normal_laws(r, m);
  read_general_laws(r, m);
}

sd_status constants_laws_read(const h5_file *file, sd_model *m, sd_messages *messages) {
  reader r = {.file = file, .messages = messages};
  read_laws(&r, m);
  return r.status;
}

sd_model *constants_laws_model(const h5_file *file) {
  sd_model *m = h5_exists(file, MODEL "/laws") ? sd_model_new() : NULL;
  if (!m || constants_laws_read(file, m, NULL) != SD_OK) {
    sd_model_free(m);
    return NULL;
  }
  m->integrator = (sd_integrator)h5_get_attr_i64(file, MODEL, "integrator", SD_VERLET);
  m->dt = h5_get_attr_f64(file, MODEL, "dt", 0.0);
  return m;
}

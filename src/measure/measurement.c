/* measurement.c: measures a frame and tabulates the results (see measurement.h). */
#include "measure/measurement.h"

#include <math.h>
#include <stdatomic.h>
#include <stddef.h>

#include "base/team.h"
#include "model/model.h"

/* Three independent parts of a measurement, computed by different threads. */
enum { STRESS, PAIRS, CELLS, PARTS };
typedef struct parts_task {
  measurement *m;
  region whole;
  size_t bins;
  sd_status status[PARTS];
  sd_messages *messages[PARTS];
  atomic_int next;
} parts_task;

static void parts_together(const team *t, void *with) {
  parts_task *f = with;
  measurement *m = f->m;
  (void)t;
  for (int k = f->next++; k < PARTS; k = f->next++) {
    sd_messages *own = f->messages[k] = sd_messages_new();
    f->status[k] = k == STRESS  ? stress_new(&m->s, &m->c, &m->region, own)
                   : k == PAIRS ? correlation_new(&m->pairs, &m->c, &m->region, f->bins, own)
                                : cells_new(&m->cells, &m->c, &f->whole, &m->region, own);
  }
}

sd_status measurement_new(measurement *m, const sd_model *constants, const frame_data *frame,
                          const double *wanted, size_t bins, sd_messages *messages) {
  sd_status status = configuration_new(&m->c, constants, frame, messages);
  if (status == SD_OK && m->c.model->n_disks == 0)
    status =
        sd_fail(messages, SD_ERROR_USER, "step %lld: no disk is in play", (long long)frame->step);
  if (status == SD_OK && wanted && m->c.offset != 0.0)
    status = sd_fail(
        messages, SD_ERROR_USER,
        "step %lld: a region of a sheared box is not measured; leave the region out, the whole box "
        "is",
        (long long)frame->step);
  if (status != SD_OK) return status;
  parts_task f = {.m = m, .whole = configuration_region(&m->c, NULL), .bins = bins};
  m->region = configuration_region(&m->c, wanted);
  m->region_given = wanted;
  m->bins = bins;
  m->open = wanted ? 0 : configuration_open(&m->c);
  m->width = m->region.upper[0] - m->region.lower[0];
  m->height = m->region.upper[1] - m->region.lower[1];
  enum { FEW = 1024 }; /* largest number of disks for which threads cost more than they save */
  pool *all = m->c.model->n_disks > FEW && pool_most() > 1 ? pool_new(2) : NULL;
  pool_run(all, parts_together, &f);
  pool_free(all);
  m->has_cells = f.status[CELLS] == SD_OK;
  if (!m->has_cells)
    m->cells.total = m->cells.inside = m->cells.mean = m->cells.deviation = m->cells.least =
        m->cells.most = NAN;
  for (int k = 0; k < PARTS; k++) {
    for (size_t l = 0; l < sd_messages_count(f.messages[k]); l++)
      if (k == CELLS)
        sd_warn(messages, "step %lld: %s", (long long)m->c.step,
                sd_messages_text(f.messages[k], l));
      else
        sd_fail(messages, f.status[k], "%s", sd_messages_text(f.messages[k], l));
    sd_messages_free(f.messages[k]);
    if (status == SD_OK && !(k == CELLS && f.status[k] == SD_ERROR_NUMERIC)) status = f.status[k];
  }
  return status;
}

void measurement_free(measurement *m) {
  configuration_free(&m->c);
  stress_free(&m->s);
  cells_free(&m->cells);
  correlation_free(&m->pairs);
}

double measurement_pressure(const measurement *m, size_t disk) {
  const uint32_t alone = (uint32_t)disk, *disks = &alone;
  double virial = 0.0, area = 0.0;
  size_t n = 1;
  if (configuration_in_clump(&m->c, disk)) {
    const config_clump *k = &m->c.clumps[m->c.clump_of[disk]];
    disks = k->disks;
    n = k->n_disks;
  }
  for (size_t k = 0; k < n; k++) {
    if (!m->has_cells || !m->cells.closed[disks[k]]) return NAN;
    virial += m->s.virial[disks[k]];
    area += m->cells.area[disks[k]];
  }
  return 0.5 * virial / area;
}

size_t measurement_width(const observable *o, size_t bins) {
  switch (o->width) {
    case MEASUREMENT_TENSOR: return 4;
    case MEASUREMENT_BINS: return bins;
    case MEASUREMENT_EDGES: return bins + 1;
    default: return o->width;
  }
}

/* --- values that are computed, or not always known -------------------------------------------- */

OBSERVABLE_GET(sliding, measurement,
               at->c.recomputed || at->c.frictionless ? NAN : (double)at->s.n_sliding)
/* Bonds are not known if contacts were recomputed. */
OBSERVABLE_GET(bonds, measurement, at->c.recomputed ? NAN : (double)at->s.n_bonds)
OBSERVABLE_GET(fragments, measurement, at->c.recomputed ? NAN : (double)at->s.fragments)
OBSERVABLE_GET(largest_fragment, measurement, at->c.recomputed ? NAN : at->s.largest_fragment)
OBSERVABLE_GET(overlap_max, measurement, at->s.n_contacts > 0 ? at->s.overlap_max : NAN)
/* Returns the fraction of the contacts with friction that slide; NAN if the contacts were not
 * stored but recomputed, as their tangential force is then unknown. */
OBSERVABLE_GET(at_limit, measurement,
               at->pairs.mobilised.n > 0 ? (double)at->pairs.n_limit / (double)at->pairs.mobilised.n
                                         : NAN)
OBSERVABLE_GET(region_x, measurement, k == 0 ? at->region.lower[0] : at->region.upper[0])
OBSERVABLE_GET(region_y, measurement, k == 0 ? at->region.lower[1] : at->region.upper[1])
OBSERVABLE_GET(region_radius, measurement,
               region_is_round(&at->region) ? at->region.outline.radius : NAN)
OBSERVABLE_GET(region_open, measurement, at->open >> k & 1)
OBSERVABLE_GET(cells_closed, measurement, at->has_cells ? (double)at->cells.n_closed : NAN)
OBSERVABLE_GET(cells_open, measurement, at->has_cells ? (double)at->cells.n_open : NAN)

/* Defines getters of the limits of the bins of a histogram and of its value in bin k; NAN: there
 * are no pairs of disks, or no contacts, to count. */
#define HISTOGRAM_GET(name, histogram, value)                                                      \
  OBSERVABLE_GET(name##_edges, measurement, at->histogram ? at->histogram->range[k] : NAN)         \
  OBSERVABLE_GET(name##_values, measurement, at->histogram ? value : NAN)
HISTOGRAM_GET(g, pairs.pairs, at->pairs.pairs->bin[k])
HISTOGRAM_GET(normal, pairs.normal.histogram, distribution_density(&at->pairs.normal, k))
HISTOGRAM_GET(tangential, pairs.tangential.histogram,
              distribution_density(&at->pairs.tangential, k))
HISTOGRAM_GET(mobilised, pairs.mobilised.histogram, distribution_density(&at->pairs.mobilised, k))

/* --- table ------------------------------------------------------------------------------------ */

#define REAL(name, field, unit, meaning, column, json)                                             \
  { name, unit, meaning, OBSERVABLE_F64, 1, offsetof(measurement, field), NULL, column, json, NULL }
#define COUNT(name, field, meaning, column, json)                                                  \
  { name, "1", meaning, OBSERVABLE_SIZE, 1, offsetof(measurement, field), NULL, column, json, NULL }
#define GOT(name, get, unit, meaning, column, json)                                                \
  { name, unit, meaning, OBSERVABLE_F64, 1, 0, get, column, json, NULL }
#define GOT_COUNT(name, get, meaning, column, json)                                                \
  { name, "1", meaning, OBSERVABLE_SIZE, 1, 0, get, column, json, NULL }
#define ARRAY(name, width, get, unit, meaning, json)                                               \
  { name, unit, meaning, OBSERVABLE_F64, width, 0, get, NULL, json, NULL }
#define TENSOR(name, field, unit, meaning, json)                                                   \
  {                                                                                                \
    name, unit, meaning, OBSERVABLE_F64, MEASUREMENT_TENSOR, offsetof(measurement, field), NULL,   \
        NULL, json, NULL                                                                           \
  }
/* Rows of a distribution, but for its mean. what: the values that are counted; ratio: what the
 * histogram is of, these values or their ratio to the mean. */
#define DISTRIBUTION(name, json, unit, what, ratio)                                                \
  COUNT(#name "_count", pairs.name.n, "number of " what, NULL, json ".count"),                     \
      REAL(#name "_deviation", pairs.name.deviation, "1", "standard deviation of " ratio, NULL,    \
           json ".deviation"),                                                                     \
      REAL(#name "_skewness", pairs.name.skewness, "1", "skewness of " ratio, NULL,                \
           json ".skewness"),                                                                      \
      REAL(#name "_kurtosis", pairs.name.kurtosis, "1", "excess kurtosis of " ratio, NULL,         \
           json ".kurtosis"),                                                                      \
      REAL(#name "_least", pairs.name.least, unit, "smallest of " what, NULL, json ".least"),      \
      REAL(#name "_most", pairs.name.most, unit, "largest of " what, NULL, json ".most"),          \
      COUNT(#name "_beyond", pairs.name.beyond, "number above the last bin", NULL,                 \
            json ".beyond"),                                                                       \
      ARRAY(#name "_edges", MEASUREMENT_EDGES, name##_edges, "1", "limits of the bins of " ratio,  \
            json ".edges"),                                                                        \
      ARRAY(#name "_density", MEASUREMENT_BINS, name##_values, "1",                                \
            "probability density of " ratio, json ".density")

static const observable rows[] = {
    OBSERVABLE_FIELD("step", "1", "steps since the start", I64, measurement, c.step, "step", NULL),
    REAL("time", c.time, "time", "step * dt", "time", NULL),
    COUNT("free", s.free, "free disks in the region", "disks", "disks.free"),
    COUNT("rattlers", s.rattlers, "of these, with too few load-bearing contacts", "rattlers",
          "disks.rattlers"),
    COUNT("clumps", s.clumps, "rigid bodies made of free disks, in the region", NULL,
          "disks.clumps"),
    COUNT("prescribed", s.fixed, "prescribed disks in the region", NULL, "disks.prescribed"),
    COUNT("elsewhere", s.outside, "free disks elsewhere", NULL, "disks.elsewhere"),
    COUNT("waiting", c.n_waiting, "disks to be released", NULL, "disks.waiting"),
    COUNT("removed", c.n_removed, "disks beyond the bounds", NULL, "disks.removed"),
    COUNT("closed", s.n_contacts, "closed contacts", "contacts", "contacts.closed"),
    COUNT("bearing", s.n_bearing, "of these, load-bearing", "bearing", "contacts.bearing"),
    COUNT("fixed", s.n_wall, "with walls or prescribed disks", NULL, "contacts.fixed"),
    GOT_COUNT("sliding", sliding, "of these, sliding", "sliding", "contacts.sliding"),
    OBSERVABLE_FIELD("recomputed", "1", "contacts were found again from positions and velocities",
                     FLAG, measurement, c.recomputed, NULL, "contacts.recomputed"),
    GOT_COUNT("bonds", bonds, "bonds of all disks", "bonds", "contacts.bonds"),
    GOT_COUNT("fragments", fragments, "bodies of bonded disks, single disks too", "fragments",
              "contacts.fragments"),
    GOT("largest_fragment", largest_fragment, "mass", "mass of the heaviest of them",
        "largest_fragment", "contacts.largest_fragment"),
    REAL("z", s.z, "1", "closed contacts per free disk", "z", "contacts.z"),
    REAL("z_bearing", s.z_bearing, "1", "load-bearing contacts per free disk", "z_bearing",
         "contacts.z_bearing"),
    REAL("z_backbone", s.z_backbone, "1", "the same without rattlers", "z_backbone",
         "contacts.z_backbone"),
    REAL("fraction", s.fraction, "1", "packing fraction of the region", "fraction", NULL),
    GOT_COUNT("cells_closed", cells_closed, "closed cells", NULL, "cells.closed"),
    GOT_COUNT("cells_open", cells_open, "open cells", NULL, "cells.open"),
    REAL("cells_total", cells.total, "length^2", "area of all cells", NULL, "cells.total"),
    REAL("inside", cells.inside, "1", "packing fraction of the closed cells", "fraction_inside",
         "cells.inside"),
    REAL("local_mean", cells.mean, "1", "local packing fraction, mean over closed cells",
         "local_mean", "cells.mean"),
    REAL("local_deviation", cells.deviation, "1", "its standard deviation", "local_deviation",
         "cells.deviation"),
    REAL("local_least", cells.least, "1", "its smallest value", NULL, "cells.least"),
    REAL("local_most", cells.most, "1", "its largest value", NULL, "cells.most"),
    REAL("width", width, "length", "width of the region", "width", "region.width"),
    REAL("height", height, "length", "height of the region", "height", "region.height"),
    REAL("area", s.area, "length^2", "area of the region", "area", "region.area"),
    REAL("stress_xx", s.contact[STRESS_XX], "force/length", "stress of the contacts", "stress_xx",
         ""),
    REAL("stress_xy", s.contact[STRESS_XY], "force/length", "stress of the contacts", "stress_xy",
         ""),
    REAL("stress_yx", s.contact[STRESS_YX], "force/length", "stress of the contacts", "stress_yx",
         ""),
    REAL("stress_yy", s.contact[STRESS_YY], "force/length", "stress of the contacts", "stress_yy",
         ""),
    REAL("kinetic_xx", s.kinetic[STRESS_XX], "force/length", "kinetic stress", "kinetic_xx", ""),
    REAL("kinetic_xy", s.kinetic[STRESS_XY], "force/length", "kinetic stress", "kinetic_xy", ""),
    REAL("kinetic_yy", s.kinetic[STRESS_YY], "force/length", "kinetic stress", "kinetic_yy", ""),
    REAL("pressure", s.contact_principal.mean, "force/length", "half the trace of the stress",
         "pressure", "stress.pressure"),
    REAL("deviator", s.contact_principal.deviator, "force/length",
         "half the difference of its principal values", "deviator", "stress.deviator"),
    REAL("angle", s.contact_principal.angle, "rad", "direction of the largest stress", "angle",
         "stress.angle"),
    REAL("anisotropy", s.anisotropy, "1", "of the directions of load-bearing contacts",
         "anisotropy", "contacts.anisotropy"),
    REAL("fabric_angle", s.fabric_angle, "rad", "direction of most load-bearing contacts",
         "fabric_angle", "contacts.fabric_angle"),
    REAL("mean_force", s.mean_force, "force", "mean normal force of load-bearing contacts",
         "mean_force", "contacts.mean_force"),
    REAL("overlap_mean", s.overlap_mean, "length", "mean overlap", "overlap_mean",
         "contacts.overlap_mean"),
    GOT("overlap_max", overlap_max, "length", "largest overlap", "overlap_max",
        "contacts.overlap_max"),
    REAL("energy_translation", s.energy_translation, "energy",
         "kinetic energy of translation per free disk or clump", "energy_translation",
         "stress.energy_translation"),
    REAL("energy_rotation", s.energy_rotation, "energy",
         "kinetic energy of rotation per free disk or clump", "energy_rotation",
         "stress.energy_rotation"),
    REAL("unbalanced", s.unbalanced, "1",
         "mean resultant force on a free disk or clump over mean_force", "unbalanced",
         "contacts.unbalanced"),
    REAL("mobilised_mean", pairs.mobilised.mean, "1", "mean of |tau|/(mu F_n)", "mobilised_mean",
         "mobilised_friction.mean"),
    GOT("limit", at_limit, "1", "fraction of the contacts with friction that slide", "limit",
        "contacts.at_limit"),
    COUNT("pairs_disks", pairs.n_disks, "disks of g(r)", NULL, "pairs.disks"),
    REAL("pairs_density", pairs.density, "1/length^2", "their number per area", NULL,
         "pairs.density"),
    REAL("peak_r", pairs.peak_r, "length", "where g(r) is highest", NULL, "pairs.peak_r"),
    REAL("peak", pairs.peak, "1", "its value there", NULL, "pairs.peak"),
    ARRAY("g_edges", MEASUREMENT_EDGES, g_edges, "length", "limits of the bins of g(r)",
          "pairs.edges"),
    ARRAY("g", MEASUREMENT_BINS, g_values, "1", "pair correlation g(r)", "pairs.g"),
    ARRAY("region_x", 2, region_x, "length", "left and right end of the region", "region.x"),
    ARRAY("region_y", 2, region_y, "length", "lower and upper end of the region", "region.y"),
    GOT("region_radius", region_radius, "length", "radius of a round region", NULL,
        "region.radius"),
    {"region_periodic", "1", "region spans the periodic box along x, along y", OBSERVABLE_FLAG, 2,
     offsetof(measurement, region.whole), NULL, NULL, "region.periodic", NULL},
    OBSERVABLE_FIELD("region_given", "1", "region was chosen by the caller", FLAG, measurement,
                     region_given, NULL, "region.given"),
    {"region_open", "1", "region is open at the left, right, bottom, top", OBSERVABLE_FLAG, 4, 0,
     region_open, NULL, "", NULL},
    TENSOR("stress", s.contact, "force/length", "stress of the contacts", "stress.contact"),
    TENSOR("kinetic", s.kinetic, "force/length", "kinetic stress", "stress.kinetic"),
    TENSOR("fabric", s.fabric, "1", "mean of n_i n_j over load-bearing contacts",
           "contacts.fabric"),
    REAL("normal_mean", pairs.normal.mean, "force", "mean of F_n", NULL, "normal_force.mean"),
    DISTRIBUTION(normal, "normal_force", "force", "F_n", "F_n/mean"),
    REAL("tangential_mean", pairs.tangential.mean, "force", "mean of |tau|", NULL,
         "tangential_force.mean"),
    DISTRIBUTION(tangential, "tangential_force", "force", "|tau|", "|tau|/mean"),
    DISTRIBUTION(mobilised, "mobilised_friction", "1", "|tau|/(mu F_n)", "|tau|/(mu F_n)"),
};
const observable_list measurement_observables =
    OBSERVABLES("measure", "numbers of a frame: columns of frames.csv, and in the JSON", rows);

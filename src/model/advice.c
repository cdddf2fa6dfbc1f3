/* advice.c: warnings about time step, contact laws, phases and initial positions, and the table
 * of all checks that give warnings; see advice.h. */
#include "model/advice.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "base/math.h"
#include "base/memory.h"
#include "base/message.h"
#include "base/text.h"
#include "model/field_kinds.h"
#include "model/laws.h"
#include "model/normal_laws.h"
#include "model/overlaps.h"
#include "model/rows.h"

/* --- time step -------------------------------------------------------------------------------- */

/* Limits of the warning about dt: smallest number of time steps per shortest contact period, and
 * smallest ratio of a viscous stability limit to dt; and the number of steps per period that is
 * advised (docs/deck.md, "How long a time step"). */
static const int FEWEST_STEPS = 20, ADVISED_STEPS = 40;
static const double FEWEST_VISCOUS = 2.5;

static const char *const integrators[] = {[SD_GEAR5] = "gear5", [SD_VERLET] = "verlet"};

static const char *bound_text(sd_bound bound) {
  static const char *const texts[] = {[SD_BOUND_NORMAL] = "normal spring",
                                      [SD_BOUND_TANGENTIAL] = "tangential spring",
                                      [SD_BOUND_VISCOSITY] = "viscosity gamma_n",
                                      [SD_BOUND_FIELD] = "drag and springs of fields"};
  return texts[bound];
}

/* Returns advice on dt, such as "take 8e-06 or less"; with Gear it also suggests Verlet if dt is
 * well below Verlet's limit. The caller frees it. */
static char *better_step(const sd_model *m, const sd_step_limit *limit) {
  double best =
      math_min(sd_model_shortest_period(m, NULL) / ADVISED_STEPS, limit->dt / FEWEST_VISCOUS);
  sd_model other = *m;
  other.integrator = SD_VERLET;
  double verlet = sd_model_step_limit(&other).dt;
  char *text = format_text("take %.2g or less", best);
  if (m->integrator == SD_GEAR5 && m->dt < verlet / FEWEST_VISCOUS)
    text = isfinite(verlet)
               ? append_text(text, ", or integrator = \"verlet\", whose limit is %.3g", verlet)
               : append_text(text, ", or integrator = \"verlet\", which has no limit here");
  return text;
}

char *advice_unstable(const sd_model *m) {
  const sd_step_limit limit = sd_model_step_limit(m);
  if (m->limits.unstable_step || !(m->dt > limit.dt)) return NULL;
  char name[96], *better = better_step(m, &limit);
  char *text = format_text(
      "beyond %.3g, from which on %s blows up (%s of %s%s); %s; limits.unstable_step = true "
      "allows it",
      limit.dt, integrators[m->integrator], bound_text(limit.bound),
      sd_model_body_name(m, limit.disk, name, sizeof name),
      limit.bound == SD_BOUND_FIELD ? "" : " between two others", better);
  free(better);
  return text;
}

/* Fraction of the stability limit from which on a failure is blamed on dt: a disk with many
 * contacts in a packing can be unstable at a third of the limit. */
static const double NEAR_LIMIT = 0.25;

const char *advice_of_failure(const sd_model *m, const char *otherwise, char *text, size_t size) {
  const sd_step_limit limit = sd_model_step_limit(m);
  if (m->dt > NEAR_LIMIT * limit.dt)
    snprintf(text, size,
             "dt = %g is too large: %.2g of the limit of stability (%s, %s), which many contacts "
             "lower to a "
             "third; take %.2g",
             m->dt, m->dt / limit.dt, integrators[m->integrator], bound_text(limit.bound),
             NEAR_LIMIT / 2 * limit.dt);
  else
    snprintf(text, size, "%s dt is %.2g of the limit of stability", otherwise, m->dt / limit.dt);
  return text;
}

/* Warns if the time step is too long. This is not an error, since a disk may never touch
 * anything, and the limit is that of a disk between two others. */
static double check_time_step(const sd_model *m, sd_messages *messages) {
  double period = sd_model_shortest_period(m, NULL);
  const sd_step_limit limit = sd_model_step_limit(m);
  bool unstable = m->dt > limit.dt, viscous = limit.bound == SD_BOUND_VISCOSITY;
  double longest = math_min(period / FEWEST_STEPS, viscous ? limit.dt / FEWEST_VISCOUS : HUGE_VAL);
  if (!(m->dt > math_min(longest, limit.dt))) return 0;
  char *better = better_step(m, &limit);
  if (unstable)
    sd_warn(messages,
            "dt = %g is beyond the limit of stability %.3g (%s, %s): results mean nothing%s; %s",
            m->dt, limit.dt, integrators[m->integrator], bound_text(limit.bound),
            limit.bound == SD_BOUND_TANGENTIAL ? " where contacts stick" : "", better);
  else if (m->dt > period / FEWEST_STEPS)
    sd_warn(messages, "dt = %g is more than 1/%d of the shortest contact period %.4g; %s", m->dt,
            FEWEST_STEPS, period, better);
  else
    sd_warn(
        messages,
        "dt = %g is more than 1/%g of the limit of stability %.3g (%s, %s), which a disk with many "
        "contacts lowers; %s",
        m->dt, FEWEST_VISCOUS, limit.dt, integrators[m->integrator], bound_text(limit.bound),
        better);
  free(better);
  return m->dt / math_min(longest, limit.dt);
}

/* --- contact laws ----------------------------------------------------------------------------- */

/* Returns the name of the contact law of materials a and b for messages, or their numbers if
 * they have no names. The caller frees it. */
static char *law_name(const sd_model *m, size_t a, size_t b) {
  const char *one = m->materials[a].name, *other = m->materials[b].name;
  if (!one || !other)
    return a == b ? format_text("materials[%zu]", a)
                  : format_text("material_pairs (%zu, %zu)", a, b);
  return a == b ? format_text("materials.%s", one)
                : format_text("material_pairs (\"%s\", \"%s\")", one, other);
}

/* True if materials a and b have a contact law and there are bodies of them that can touch. */
static bool is_used(const sd_model *m, const law_use *use, size_t a, size_t b) {
  bool enough = a == b ? use[a].count > 1 : use[a].count > 0 && use[b].count > 0;
  return enough && (use[a].free_disk || use[b].free_disk) &&
         law_is_given(sd_model_law(m, (int)a, (int)b));
}

typedef double law_visitor(const sd_model *m, size_t a, size_t b, sd_messages *messages);

/* Calls `visit` for each contact law in use and returns the largest value that it returned; 0:
 * no law is in use. */
static double each_law(const sd_model *m, law_visitor *visit, sd_messages *messages) {
  law_use *use = memory_new(m->n_materials, sizeof *use);
  double worst = 0;
  laws_count_uses(m, use);
  for (size_t a = 0; a < m->n_materials; a++)
    for (size_t b = a; b < m->n_materials; b++)
      if (is_used(m, use, a, b)) worst = math_max(worst, visit(m, a, b, messages));
  free(use);
  return worst;
}

static double mindlin_of(const sd_model *m, size_t a, size_t b, sd_messages *messages) {
  const sd_contact_law *law = sd_model_law(m, (int)a, (int)b);
  if (law->tangential != SD_TANGENTIAL_MINDLIN || law->k_t > 0) return 0;
  char *name = law_name(m, a, b);
  sd_warn(messages, "%s: tangential = \"mindlin\" without %s has no effect: give %s and mu", name,
          law->E_star > 0 ? "poisson" : "k_t",
          law->E_star > 0 ? "poisson" : "k_t (force/length^(3/2))");
  free(name);
  return 1;
}

static double friction_of(const sd_model *m, size_t a, size_t b, sd_messages *messages) {
  const sd_contact_law *law = sd_model_law(m, (int)a, (int)b);
  if ((law->mu > 0) == (law->k_t > 0)) return mindlin_of(m, a, b, messages);
  char *name = law_name(m, a, b);
  if (law->mu > 0)
    sd_warn(messages, "%s: mu = %g without k_t is no friction at all: give %s", name, law->mu,
            law->E_star > 0 ? "tangential = \"mindlin\" and poisson"
                            : "k_t, usually 0.3 to 1 times k_n");
  else
    sd_warn(messages,
            "%s: %s = %g without mu has no effect: the contact slides freely; give mu, or leave "
            "%s out",
            name, law->poisson > 0 ? "poisson" : "k_t", law->poisson > 0 ? law->poisson : law->k_t,
            law->poisson > 0 ? "poisson" : "k_t");
  free(name);
  return 1;
}

static double check_friction(const sd_model *m, sd_messages *messages) {
  return each_law(m, friction_of, messages);
}

static double loses_energy(const sd_model *m, size_t a, size_t b, sd_messages *messages) {
  (void)messages;
  const sd_contact_law *law = sd_model_law(m, (int)a, (int)b);
  return law->gamma_n > 0 || law_tsuji(law) > 0 || (law->mu > 0 && law->k_t > 0);
}

/* --- phases ----------------------------------------------------------------------------------- */

static char *phase_name(const sd_model *m, size_t k) {
  const char *name = m->phases[k].name;
  return name && *name ? format_text("phases.%s", name) : format_text("phases[%zu]", k);
}

/* Adds the warning `text` about phase k of the run and returns its severity, 1. */
static double warn_of_phase(const sd_model *m, size_t k, sd_messages *messages, const char *text) {
  char *name = phase_name(m, k);
  sd_warn(messages, "%s: %s", name, text);
  free(name);
  return 1;
}

static double check_relax(const sd_model *m, sd_messages *messages) {
  for (size_t k = 0; k < m->n_phases && m->integrator == SD_GEAR5; k++)
    if (m->phases[k].relax)
      return warn_of_phase(
          m, k, messages,
          "relax = true with integrator = \"gear5\": the relaxer stops disks, and Gear's "
          "higher derivatives do not know; take integrator = \"verlet\"");
  return 0;
}

/* Returns why a phase of the run cannot come to rest as its settle criteria demand; NULL: no
 * reason is known. */
static const char *out_of_reach(const sd_model *m, const sd_phase *p) {
  for (size_t j = 0; j < m->n_motions; j++) {
    int kind = (int)m->motions[j].kind;
    bool swings = kind == SD_MOTION_HARMONIC || kind == SD_MOTION_PARABOLIC ||
                  kind == SD_MOTION_RANDOM || kind == SD_MOTION_SQUARE ||
                  kind == SD_MOTION_TRIANGLE;
    if (p->active && p->active[j] && swings && m->motions[j].amplitude != 0)
      return "settle waits for rest, but a motion shakes all the time: switch it off with motions "
             "= ()";
  }
  if (!p->relax && each_law(m, loses_energy, NULL) == 0 && !body_forces_dissipate(m, p - m->phases))
    return "settle waits for rest, but nothing takes energy out (gamma_n, restitution, mu with "
           "k_t, drag, "
           "damping): "
           "relax = true brings the disks to rest";
  return NULL;
}

/* Collective. Smallest ratio settle.unbalanced that rounding of positions allows: the force
 * error eps/2 * |x| * k divided by the weight of the lightest disk; 0: no weight. */
static double rounding(const sd_model *m) {
  double g = math_hypot(m->gravity[0], m->gravity[1]), least = HUGE_VAL, farthest = 0, stiffest = 0;
  for (size_t row = 0; row < rows_count(m); row++) {
    const sd_disk *d = rows_disk(m, row);
    farthest = math_max(farthest, math_max(fabs(d->position[0]), fabs(d->position[1])));
    if (!d->driven) least = math_min(least, d->mass * g);
  }
  farthest = rows_largest(m, farthest);
  least = rows_least(m, least);
  for (size_t k = 0; k < m->n_materials * m->n_materials; k++)
    stiffest = math_max(stiffest, law_typical_stiffness(&m->laws[k], m->largest_radius));
  return least > 0 && isfinite(least) ? DBL_EPSILON / 2 * farthest * stiffest / least : 0;
}

static double check_settle(const sd_model *m, sd_messages *messages) {
  double worst = 0;
  for (size_t k = 0; k < m->n_phases; k++) {
    const sd_settle *s = &m->phases[k].settle;
    if (!s->asked) continue;
    const char *why = out_of_reach(m, &m->phases[k]);
    if (why) worst = math_max(worst, warn_of_phase(m, k, messages, why));
    double least = s->unbalanced > 0 ? rounding(m) : 0;
    if (!(s->unbalanced < least)) continue;
    char *text =
        format_text("settle.unbalanced = %g is below %.2g, the rounding of positions against the "
                    "overlap under a weight: take more",
                    s->unbalanced, least);
    worst = math_max(worst, warn_of_phase(m, k, messages, text));
    free(text);
  }
  return worst;
}

/* Collective. Packing fraction at the start: area of the free disks divided by the area of the
 * region; 0: there is no region. */
static double first_fraction(const sd_model *m) {
  double area =
             (m->region_upper[0] - m->region_lower[0]) * (m->region_upper[1] - m->region_lower[1]),
         sum = 0;
  for (size_t row = rows_first(m); row < rows_count(m); row++) {
    const sd_disk *d = rows_disk(m, row);
    if (!d->driven) sum += M_PI * d->radius * d->radius;
  }
  sum = rows_sum(m, sum);
  return area > 0 ? sum / area : 0;
}

double sd_model_compress_time(const sd_model *m, size_t phase) {
  if (phase >= m->n_phases) return NAN;
  double from = first_fraction(m);
  /* the target fraction is 0, which means unknown here, if that phase compresses to a pressure */
  for (size_t k = 0; k < phase; k++)
    if (m->phases[k].compress.asked) from = m->phases[k].compress.fraction;
  const sd_compress *c = &m->phases[phase].compress;
  return c->asked && c->fraction > 0 && from > 0 ? fabs(math_log(c->fraction / from)) / 2 / c->rate
                                                 : NAN;
}

/* A compression phase gets a warning if it is longer than HELD times the time that it takes to
 * reach its packing fraction or, with a target pressure, longer than LOG_SHRUNK/rate. */
static const double HELD = 5, LOG_SHRUNK = 5;

static double check_compress(const sd_model *m, sd_messages *messages) {
  double worst = 0;
  for (size_t k = 0; k < m->n_phases; k++) {
    const sd_phase *p = &m->phases[k];
    double time = (double)p->steps * m->dt, needed = sd_model_compress_time(m, k), ratio = 0;
    char *text = NULL;
    if (!p->compress.asked || p->settle.asked) continue;
    if (needed > 0) ratio = time / needed / HELD;
    if (isnan(needed)) ratio = time * p->compress.rate / LOG_SHRUNK;
    if (!(ratio > 1)) continue;
    if (isnan(needed))
      text = format_text(
          "compress holds its pressure to the end of the phase, long after it is reached: %.3g "
          "times 1/rate",
          time * p->compress.rate);
    else
      text = format_text("compress reaches its packing fraction after about %.3g of %.3g, and the "
                         "phase goes on to "
                         "its end",
                         needed, time);
    text = append_text(text, "; with settle = { unbalanced = 1e-3; } it ends there");
    warn_of_phase(m, k, messages, text);
    worst = math_max(worst, ratio);
    free(text);
  }
  return worst;
}

/* --- deforming boxes -------------------------------------------------------------------------- */

static bool attracts(const sd_model *m) {
  bool any = false;
  for (size_t k = 0; k < m->n_materials * m->n_materials; k++)
    any |= m->laws[k].cohesion != SD_COHESION_NONE;
  return any;
}

/* Returns a warning about settings of a deforming box (`cell`) that have no effect; NULL: all
 * have an effect. */
static const char *without_effect(const sd_cell *c) {
  bool controlled = false, rate = false;
  for (int k = 0; k < SD_CELL_COMPONENTS; k++) {
    controlled |= c->controlled[k];
    rate |= c->rate[k] != 0;
  }
  if (!controlled && c->response > 0)
    return "cell.response has no effect: no stress is controlled; give stress_xx, stress_yy or "
           "stress_xy";
  if (!controlled && c->max_rate > 0)
    return "cell.max_rate has no effect: no stress is controlled; give stress_xx, stress_yy or "
           "stress_xy";
  if (!controlled && !rate)
    return "cell has neither a rate nor a stress: the box stays as it is; give rate_xy or the like";
  return NULL;
}

static double check_cells(const sd_model *m, sd_messages *messages) {
  static const char *const keys[] = {[SD_CELL_XX] = "stress_xx", [SD_CELL_YY] = "stress_yy"};
  double worst = 0;
  for (size_t k = 0; k < m->n_phases; k++) {
    const sd_cell *c = &m->phases[k].cell;
    const char *idle = c->asked ? without_effect(c) : NULL;
    if (idle) worst = warn_of_phase(m, k, messages, idle);
    for (int q = SD_CELL_XX; c->asked && q <= SD_CELL_YY; q++) {
      if (!c->controlled[q] || !(c->stress[q] < 0) || attracts(m)) continue;
      char *text =
          format_text("cell.%s = %g: compression is positive here, and without cohesion nothing "
                      "holds disks together under tension",
                      keys[q], c->stress[q]);
      worst = warn_of_phase(m, k, messages, text);
      free(text);
    }
  }
  return worst;
}

/* --- positions -------------------------------------------------------------------------------- */

/* Overlap divided by the radius beyond which a warning is given, because the disks are thrown
 * apart. */
static const double DEEP_OVERLAP = 0.01;
/* Gap divided by the radius beyond which a warning is given, because a watched contact is
 * unlikely to close. */
static const double WIDE_GAP = 0.1;

/* State of the search for the deepest overlap of two bodies at the start. */
typedef struct search {
  const sd_model *m;
  uint64_t *pairs; /* [n_memories] pair_key of each contact that is restored from a file, sorted */
  first_overlap worst;
} search;

/* Returns a key for an unordered pair of bodies: the smaller body number in the upper 32 bits,
 * the larger one in the lower bits. */
static uint64_t pair_key(uint32_t a, uint32_t b) {
  return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

static int by_key(const void *one, const void *two) {
  const uint64_t *p = one, *q = two;
  return *p < *q ? -1 : *p > *q;
}

/* Lists the body pairs of all contacts that are restored from a file, sorted by pair_key.
 * SD_ERROR_IO: out of memory. */
static sd_status list_pairs(search *s) {
  const sd_model *m = s->m;
  if (!memory_resize_row(&s->pairs, m->n_memories, sizeof *s->pairs)) return SD_ERROR_IO;
  for (size_t k = 0; k < m->n_memories; k++)
    s->pairs[k] = pair_key(m->memories[k].a, m->memories[k].b);
  if (m->n_memories > 1) qsort(s->pairs, m->n_memories, sizeof *s->pairs, by_key);
  return SD_OK;
}

/* True if the contact of bodies a and b is restored from a file. */
static bool begins_with(const search *s, uint32_t a, uint32_t b) {
  const uint64_t key = pair_key(a, b);
  return bsearch(&key, s->pairs, s->m->n_memories, sizeof key, by_key);
}

/* True if the contact of bodies a and b may be restored from a file whose disks are distributed
 * over ranks: a is a disk of that file, b another of its disks or one of its walls. */
static bool begins_away(const sd_model *m, uint32_t a, uint32_t b) {
  const sd_tiles *t = &m->tiles;
  if (!t->away || t->n_contacts == 0 || a < t->first) return false;
  bool known = b >= t->first && b < m->n_disks;
  for (size_t k = 0; k < t->n_walls; k++)
    known = known || (t->walls[k].known && m->n_disks + t->walls[k].wall == b);
  return known;
}

static bool is_free(const sd_model *m, uint32_t body) {
  return body < m->n_disks && !m->disks[body].driven;
}
static bool waits(const sd_model *m, uint32_t body) {
  return body < m->n_disks && m->disks[body].waiting;
}

/* Returns the weight of the lighter free disk in an overlap. d: disk o->a. */
static double lighter_weight(const sd_model *m, const sd_disk *d, const overlap *o) {
  const double g = math_hypot(m->gravity[0], m->gravity[1]);
  double mass = d->driven ? HUGE_VAL : d->mass;
  if (is_free(m, o->b)) mass = math_min(mass, m->disks[o->b].mass);
  return mass * g;
}

/* Stores an overlap if it is the deepest so far, relative to the radius of its smaller disk a.
 * Overlaps of restored contacts, and of disks that still wait for their release, are skipped.
 * Returns false, so that the search goes on. */
static bool note_overlap(void *user, const overlap *o) {
  search *s = user;
  const sd_model *m = s->m;
  const sd_disk *d = rows_disk(m, o->row);
  double relative = o->depth / d->radius;
  if (relative <= s->worst.relative || d->waiting || waits(m, o->b)) return false;
  if (d->driven && !is_free(m, o->b)) return false;
  /* an overlap beyond max_overlap is an error even if the contact is restored from a file */
  const bool too_deep = m->max_overlap > 0 && relative > m->max_overlap;
  if ((begins_away(m, o->a, o->b) && !too_deep) || begins_with(s, o->a, o->b)) return false;
  s->worst = (first_overlap){.a = o->a,
                             .b = o->b,
                             .depth = o->depth,
                             .relative = relative,
                             .force = overlap_force(m, o),
                             .weight = lighter_weight(m, d, o)};
  return false;
}

void advice_share_overlap(const comm *c, first_overlap *worst) {
  const size_t n = (size_t)comm_size(c);
  first_overlap *all = memory_new(n, sizeof *all);
  comm_gather_one(c, worst, all, sizeof *worst);
  *worst = all[0];
  for (size_t k = 1; k < n; k++)
    if (all[k].relative > worst->relative) *worst = all[k];
  free(all);
}

sd_status advice_overlap(const sd_model *m, first_overlap *worst) {
  search s = {.m = m};
  sd_status status = list_pairs(&s);
  if (status == SD_OK) status = overlaps_of_disks(m, note_overlap, &s);
  if (status == SD_OK) overlaps_with_walls(m, note_overlap, &s);
  free(s.pairs);
  *worst = s.worst;
  advice_share_overlap(m->comm, worst);
  return comm_agree(m->comm, status);
}

double advice_tell_overlap(const sd_model *m, const first_overlap *worst, sd_messages *messages) {
  char one[96], two[96], *times = NULL;
  if (!(worst->relative > DEEP_OVERLAP)) return 0;
  if (worst->weight > 0)
    times = format_text(", %.3g times the weight", worst->force / worst->weight);
  sd_warn(messages,
          "%s and %s overlap by %.3g at the start, %.3g of the radius: a force of %.3g%s throws "
          "them apart; "
          "move them, or let the first phase relax = true",
          sd_model_body_name(m, worst->a, one, sizeof one),
          sd_model_body_name(m, worst->b, two, sizeof two), worst->depth, worst->relative,
          worst->force, times ? times : "");
  free(times);
  return worst->relative / DEEP_OVERLAP;
}

/* Warns about the deepest overlap, unless the first phase relaxes the packing (relax = true),
 * which removes overlaps slowly. */
static double check_overlap(const sd_model *m, sd_messages *messages) {
  first_overlap worst;
  if (m->n_phases > 0 && m->phases[0].relax) return 0;
  if (advice_overlap(m, &worst) != SD_OK) {
    shortage_note();
    return 0;
  }
  return advice_tell_overlap(m, &worst, messages);
}

static double check_watches(const sd_model *m, sd_messages *messages) {
  double worst = m->measure_configurations && m->n_slides == 0;
  char one[96], two[96];
  if (worst > 0)
    sd_warn(messages, "measure.configurations = true without measure.sliding has no effect: name "
                      "the disk and its "
                      "two partners there");
  for (size_t k = 0; k < m->n_slides; k++)
    for (int c = 0; c < 2; c++) {
      const sd_slide_watch *w = &m->slides[k];
      double gap = overlaps_first_gap(m, w->disk, w->partner[c]),
             ratio = gap / m->disks[w->disk].radius;
      if (!(ratio > WIDE_GAP) || waits(m, w->disk) || waits(m, w->partner[c])) continue;
      sd_warn(messages,
              "measure.sliding: %s and %s do not touch at the start: there are %.3g between them, "
              "%.3g radii; "
              "is the partner the one that is meant?",
              sd_model_body_name(m, w->disk, one, sizeof one),
              sd_model_body_name(m, w->partner[c], two, sizeof two), gap, ratio);
      worst = math_max(worst, ratio);
    }
  return worst;
}

/* --- table of checks -------------------------------------------------------------------------- */

advice_check *const advice_checks[] = {check_time_step, check_friction, check_relax,
                                       check_settle,    check_compress, check_overlap,
                                       check_watches,   check_cells,    advice_fields,
                                       advice_joints,   advice_motions, advice_prescribed};
const size_t advice_count = sizeof advice_checks / sizeof *advice_checks;

typedef struct advising {
  const sd_model *model;
  sd_messages *messages;
} advising;

static void advise(void *task) {
  const advising *t = task;
  messages_append(t->messages, SD_OK, t->model->advised);
  if (t->model->advised) return;
  for (size_t k = 0; k < advice_count; k++) advice_checks[k](t->model, t->messages);
}

void sd_model_advise(const sd_model *m, sd_messages *messages) {
  if (!memory_try(advise, &(advising){m, messages})) fail_memory(messages);
}

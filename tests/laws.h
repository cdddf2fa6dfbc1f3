/* laws.h: what the tests of contact laws share: decks of two bodies as text, and a reference of its own for the pair.
 *
 *   law l = {.k_n = 1e4, .restitution = 0.7};
 *   sd_simulation *s = laws_impact(&l, &hit);    two disks fly at each other, or one at a floor
 *   reference r = laws_reference(&l, &hit, t);   the same by GSL, with rates in place of displacements
 */
#ifndef TESTS_LAWS_H
#define TESTS_LAWS_H

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include "deck_runs.h"
#include "model/laws.h"
#include "system.h"

/* Members that are 0 are not written. With E_star and poisson, k_n and k_t are those of the pair. */
typedef sd_contact_law law;

HELPER void law_add(text *t, const char *name, const law *l) {
  const deck_key *key;
  text_add(t, "{ %s;", name);
  for (size_t k = 0; (key = deck_key_at(&law_table, k)); k++) {
    const double value = deck_key_value(key, l);
    const bool derived = (l->E_star > 0 && strcmp(key->name, "k_n") == 0) ||
                         (l->poisson > 0 && strcmp(key->name, "k_t") == 0);
    if (key->kind == DECK_KEY_BOOL)
      text_add(t, " %s = %s;", key->name,
               (value != 0) != (key->target == DECK_SETS_OFF) ? "true" : "false");
    else if (key->words)
      text_add(t, " %s = \"%s\";", key->name, key->words[(int)value].name);
    else if (value != 0 && !derived)
      text_add(t, " %s = %.17g;", key->name, value);
  }
  text_add(t, " }");
}

/* Frees the text. general: not the step of small systems. */
HELPER sd_simulation *laws_begin(text *t, bool general) {
  sd_model *m = model_of(t->s);
  sd_simulation *s = NULL;
  free(t->s);
  *t = (text){0};
  assert_int_equal(simulation_new(m, 1, general ? SIMULATION_GENERAL : SIMULATION_SUITABLE, NULL,
                                  NULL, &s, NULL),
                   SD_OK);
  return s;
}

enum { LAWS_MOST = 2 };

/* Disk 0 at the origin, disk 1, or the floor, at a gap from it in direction beta. */
typedef struct hit {
  bool floor;   /* y = -radius[0] - gap; beta does not count */
  bool fixed;   /* disk 1 is held */
  int round;    /* in place of disk 1 a round wall: 1: from outside, -1: from inside */
  bool general; /* takes the general step */
  double radius[2], mass[2];
  double beta, gap;
  double velocity[2][3];
  double gravity; /* downwards */
  sd_integrator integrator;
  double dt;
} hit;

HELPER double hit_mass(const hit *h) {
  return h->floor || h->fixed || h->round ? h->mass[0]
                                          : h->mass[0] * h->mass[1] / (h->mass[0] + h->mass[1]);
}

HELPER sd_simulation *laws_impact(const law *l, const hit *h) {
  text t = {0};
  const int side = h->round < 0 ? -1 : 1;
  double r = h->radius[0] + side * h->radius[1] + h->gap;
  const double at[2][2] = {{0, 0}, {r * cos(h->beta), r * sin(h->beta)}};
  text_add(&t,
           "dt = %.17g; integrator = \"%s\"; contact_variant = \"conservative\"; steps = 1e15;\n",
           h->dt, system_integrators[h->integrator]);
  text_add(&t, "gravity = { g = %.17g; }; materials = ( ", h->gravity);
  law_add(&t, "name = \"m\"", l);
  text_add(&t, " );\ndisks = (");
  for (int i = 0; i < (h->floor || h->round ? 1 : 2); i++) {
    text_add(&t, "%s{ x = %.17g; y = %.17g; radius = %.17g; mass = %.17g; ", i ? ", " : "",
             at[i][0], at[i][1], h->radius[i], h->mass[i]);
    if (i && h->fixed)
      text_add(&t, "fixed = true; }");
    else
      text_add(&t, "vx = %.17g; vy = %.17g; omega = %.17g; }", h->velocity[i][0], h->velocity[i][1],
               h->velocity[i][2]);
  }
  text_add(&t, " );\n");
  if (h->floor)
    text_add(&t, "walls = ( { type = \"line\"; points = ( (-1, %.17g), (1, %.17g) ); } );\n",
             -h->radius[0] - h->gap, -h->radius[0] - h->gap);
  if (h->round)
    text_add(&t,
             "walls = ( { type = \"circle\"; center = (%.17g, %.17g); radius = %.17g; side = "
             "\"%s\"; } );\n",
             at[1][0], at[1][1], h->radius[1], side > 0 ? "outside" : "inside");
  return laws_begin(&t, h->general);
}

/* b of a coefficient of restitution, of unit mass and stiffness: with the cutoff, or without it. */
HELPER double law_damping_ratio(double e, bool pulls) {
  if (pulls) return -log(e) / sqrt(M_PI * M_PI + log(e) * log(e));
  double low = 0, high = 1e3;
  for (int k = 0; k < 100; k++) {
    double b = 0.5 * (low + high);
    *(sd_restitution(1, 2 * b, 1).restitution > e ? &low : &high) = b;
  }
  return low;
}

/* x, y, theta, their rates, of both bodies; y = s zeta, s^2 the tangential stiffness; rolling displacement. */
enum { AT = 0, RATE = 6, SPRING = 12, ROLL = 13, NUMBERS = 14 };

typedef struct reference {
  const law *law;
  const hit *hit;
  double s[NUMBERS];
  bool bridged, slid; /* before the step */
  double stop, belt;  /* stiffness of a stop at x = 0 for x > 0; velocity of the floor */
  bool locked;        /* disk 0 does not turn */
  /* of the last look */
  double limit, stiffness, roll_limit, reach;
  double damping; /* law_damping_ratio, 0: none */
} reference;

/* Attraction at this overlap. */
HELPER double law_attraction(const law *l, double reach, bool bridged) {
  if (l->cohesion == SD_COHESION_NONE) return 0;
  if (l->cohesion == SD_COHESION_BRIDGE)
    return bridged && reach > -l->rupture ? l->pull_off * exp(fmin(reach, 0) / l->range) : 0;
  return reach > 0 ? l->pull_off : fmax(l->pull_off * (1 + reach / l->range), 0);
}

/* Without damping. */
HELPER double law_repulsion(const law *l, double delta) {
  return delta <= 0                     ? 0
         : l->normal == SD_NORMAL_HERTZ ? l->k_n * delta * sqrt(delta)
                                        : l->k_n * delta;
}

HELPER double clip(double x, double limit) { return fmax(fmin(x, limit), -limit); }

/* Spring and dashpot of a slider: the spring gives way at the limit, the dashpot has what it leaves. */
HELPER double limited(double spring, double dashpot, double limit) {
  return clip(clip(spring, limit) + dashpot, limit);
}

HELPER int reference_rates(double t, const double s[], double f[], void *user) {
  reference *q = user;
  const law *l = q->law;
  const hit *h = q->hit;
  (void)t;
  bool flat = h->floor;
  double ra = h->radius[0], rb = flat ? 0 : h->radius[1], sum = ra + rb;
  double dx = flat ? 0 : s[3] - s[0], dy = flat ? -ra - h->gap - s[1] : s[4] - s[1],
         r = hypot(dx, dy);
  double nx = dx / r, ny = dy / r, reach = sum - r, delta = fmax(reach, 0);
  double vx = s[RATE + 3] - s[RATE], vy = s[RATE + 4] - s[RATE + 1], u = vx * nx + vy * ny;
  double turn = flat ? 0 : (vy * nx - vx * ny) / r; /* of the normal */
  double surface = flat ? ra * s[RATE + 2] + s[RATE] - q->belt
                        : ra * s[RATE + 2] + rb * s[RATE + 5] - sum * turn;
  /* normal */
  double gamma = l->gamma_n, m = hit_mass(h);
  const double ratio = q->damping;
  gamma += l->normal == SD_NORMAL_HERTZ ? sqrt(5) * ratio * sqrt(m * l->k_n * sqrt(delta))
                                        : 2 * ratio * sqrt(m * l->k_n);
  double push = delta > 0 ? law_repulsion(l, delta) - gamma * u : 0;
  if (!l->damping_pulls) push = fmax(push, 0);
  double normal = push - law_attraction(l, reach, q->bridged), cap = fmax(push, 0);
  /* tangential */
  q->stiffness = sqrt(l->k_t * (l->tangential == SD_TANGENTIAL_MINDLIN ? sqrt(delta) : 1));
  q->limit =
      fmax(cap - l->critical_load, 0) * (q->slid && l->mu_kinetic > 0 ? l->mu_kinetic : l->mu);
  q->reach = reach;
  double tau = delta > 0 ? -limited(q->stiffness * s[SPRING], l->gamma_t * surface, q->limit) : 0,
         lever = flat ? 1 : sum / r;
  /* rolling */
  double reduced = flat ? ra : ra * rb / sum;
  double rolling = reduced * (s[RATE + 2] - s[RATE + 5]);
  q->roll_limit = cap * l->mu_r;
  double couple = delta > 0
                      ? -reduced * (limited(l->k_r * s[ROLL], l->gamma_r * rolling, q->roll_limit) +
                                    l->drag_r * rolling)
                      : 0;

  double force[6] = {
      -normal * nx - tau * lever * ny, -normal * ny + tau * lever * nx, tau * ra + couple,
      normal * nx + tau * lever * ny,  normal * ny - tau * lever * nx,  tau * rb - couple};
  force[0] -= q->stop * fmax(s[0], 0);
  for (int b = 0; b < 2; b++)
    for (int c = 0; c < 3; c++) {
      double inertia = h->mass[b] * (c == 2 ? 0.5 * h->radius[b] * h->radius[b] : 1);
      bool still = (b == 1 && flat) || (b == 0 && c == 2 && q->locked);
      f[3 * b + c] = s[RATE + 3 * b + c];
      f[RATE + 3 * b + c] = still ? 0 : force[3 * b + c] / inertia - (c == 1 ? h->gravity : 0);
    }
  f[SPRING] = delta > 0 ? q->stiffness * surface : 0;
  f[ROLL] = delta > 0 ? rolling : 0;
  return GSL_SUCCESS;
}

HELPER reference reference_new(const law *l, const hit *h) {
  reference q = {.law = l, .hit = h};
  if (l->restitution > 0 && l->restitution < 1)
    q.damping = law_damping_ratio(l->restitution, l->damping_pulls);
  double r = h->radius[0] + h->radius[1] + h->gap;
  q.s[3] = h->floor ? 0 : r * cos(h->beta);
  q.s[4] = h->floor ? 0 : r * sin(h->beta);
  for (int b = 0; b < (h->floor ? 1 : 2); b++)
    for (int c = 0; c < 3; c++) q.s[RATE + 3 * b + c] = h->velocity[b][c];
  return q;
}

/* Sliders give way between the steps: what their spring has beyond the limit, or open contacts remember, is taken away. */
HELPER void reference_commit(reference *q) {
  const law *l = q->law;
  double f[NUMBERS];
  reference_rates(0, q->s, f, q);
  if (q->reach > 0) q->bridged = true;
  if (q->reach <= -l->rupture) q->bridged = false;
  if (q->reach <= 0) q->s[SPRING] = q->s[ROLL] = 0, q->slid = false;
  if (q->reach <= 0) return;
  const double spring = q->stiffness * q->s[SPRING], roll = l->k_r * q->s[ROLL];
  q->slid = fabs(spring) > q->limit;
  if (q->slid) {
    reference_rates(0, q->s, f, q); /* the limit may be that of sliding now */
    q->s[SPRING] = q->stiffness > 0 ? clip(spring, q->limit) / q->stiffness : 0;
  }
  if (fabs(roll) > q->roll_limit) q->s[ROLL] = clip(roll, q->roll_limit) / l->k_r;
}

HELPER void reference_advance(reference *q, double dt, int64_t steps) {
  gsl_odeiv2_system system = {reference_rates, NULL, NUMBERS, q};
  gsl_odeiv2_step *step = gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk4, NUMBERS);
  double error[NUMBERS];
  assert_non_null(step);
  for (int64_t k = 0; k < steps; k++) {
    assert_int_equal(gsl_odeiv2_step_apply(step, 0, dt, q->s, error, NULL, NULL, &system),
                     GSL_SUCCESS);
    reference_commit(q);
  }
  gsl_odeiv2_step_free(step);
}

/* Velocities of both are those of the reference, to a fraction of the speed. */
HELPER void same_velocities(sd_simulation *s, const reference *q, double speed, double tolerance,
                            const char *what) {
  static const char *const names[] = {"vx", "vy", "R omega"};
  for (uint32_t b = 0; b < (q->hit->floor ? 1u : 2u); b++) {
    system_body at = system_at(s, b);
    double v[3] = {at.vx, at.vy, at.omega};
    for (int c = 0; c < 3; c++) {
      double length = c == 2 ? q->hit->radius[b] : 1;
      SYSTEM_NEAR(length * v[c], length * q->s[RATE + 3 * b + (uint32_t)c], tolerance * speed,
                  "%s: %s of disk %u", what, names[c], b);
    }
  }
}

/* |residual| over the scale of the budget. */
HELPER double laws_residual(sd_simulation *s) {
  sd_energy e = sd_simulation_energy(s);
  return fabs(e.residual) / e.scale;
}

#endif

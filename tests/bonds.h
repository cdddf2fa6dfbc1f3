/* bonds.h: what the tests of bonds share: decks of cemented disks as text, and displacements of a
 * bond that the test computes from positions and angles alone.
 *
 *   text t = {0};
 *   bonds_deck(&t, SD_VERLET, SD_CONSERVATIVE, dt, &law);        up to the list of disks
 *   text_add(&t, "disks = ( ... ); phases = ( { steps = 1e15; bond = {}; } );");
 *   sd_simulation *s = laws_begin(&t, false);
 *   tracked_bond k = bond_track(s, 0, 1);
 *   system_advance(s, 1);   bond_displacement u = bond_now(s, &k);   (at every step or so)
 */
#ifndef TESTS_BONDS_H
#define TESTS_BONDS_H

#include "laws.h"

HELPER void bonds_deck(text *t, sd_integrator i, sd_variant v, double dt, const law *l) {
  text_add(t, "dt = %.17g; integrator = \"%s\"; contact_variant = \"%s\";\nmaterials = ( ", dt,
           system_integrators[i], system_variants[v]);
  law_add(t, "name = \"m\"", l);
  text_add(t, " );\n");
}

/* One disk of a list of disks. more: further keys of the deck, or "". */
HELPER void bonds_disk(text *t, bool first, const double at[2], double radius, double mass,
                       const char *more) {
  text_add(t, "%s{ x = %.17g; y = %.17g; radius = %.17g; mass = %.17g; %s }", first ? "" : ",\n",
           at[0], at[1], radius, mass, more);
}

/* Changes of gap, tangential coordinate and rolling displacement since the bond was made. */
typedef struct bond_displacement {
  double n, t, r;
} bond_displacement;

typedef struct tracked_bond {
  uint32_t a, b;
  double radius[2], arm;
  long double phi;        /* direction of the normal, unwrapped */
  bond_displacement made; /* length, lambda and rho when the bond was made */
} tracked_bond;

HELPER bond_displacement bond_coordinates(sd_simulation *s, tracked_bond *k) {
  const system_body a = system_at(s, k->a), b = system_at(s, k->b);
  const double phi = atan2(b.y - a.y, b.x - a.x), sum = k->radius[0] + k->radius[1];
  k->phi = phi + 2 * M_PI * nearbyint((k->phi - phi) / (2 * M_PI));
  return (bond_displacement){
      hypot(b.x - a.x, b.y - a.y),
      (double)(k->radius[0] * a.theta + k->radius[1] * b.theta - sum * k->phi),
      (double)(k->arm * (a.theta - b.theta))};
}

HELPER tracked_bond bond_track(sd_simulation *s, uint32_t a, uint32_t b) {
  const sd_model *m = sd_simulation_model(s);
  tracked_bond k = {.a = a, .b = b, .radius = {m->disks[a].radius, m->disks[b].radius}};
  k.arm = k.radius[0] * k.radius[1] / (k.radius[0] + k.radius[1]);
  k.made = bond_coordinates(s, &k);
  return k;
}

HELPER bond_displacement bond_now(sd_simulation *s, tracked_bond *k) {
  const bond_displacement u = bond_coordinates(s, k);
  return (bond_displacement){u.n - k->made.n, u.t - k->made.t, u.r - k->made.r};
}

/* Number of bonds that last. */
HELPER size_t bonds_left(sd_simulation *s) {
  const sd_state *q = sd_simulation_state(s);
  size_t n = 0;
  for (size_t k = 0; k < q->n_contacts; k++) n += q->contact_bond[k] > 0;
  return n;
}

HELPER double bonds_broken_energy(const sd_energy *e) {
  return e->broken_tension + e->broken_shear + e->broken_bending;
}

#endif

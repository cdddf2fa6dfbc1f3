/* law_bond.h: bonds, which hold two surfaces together across a gap, too; contact_step.h includes it
 * once per LANE_WIDTH.
 *
 *   U     = k_n u_n^2/2 + k_t u_t^2/2 + k_r u_r^2/2
 *   u_n   = gap - gap_0, u_t = lambda - lambda_0, u_r = rho - rho_0, since the bond was made
 *   pull  = k_n u_n + gamma_n du_n/dt, and likewise shear and bend
 *   force on the contact: F_n - pull, tau - shear, roll - bend
 *
 * (the parallel bond of Potyondy and Cundall, Int. J. Rock Mech. Min. Sci. 41, 1329, with forces
 * that derive from U). A bond with the relative strength `bond` breaks in the step in which one of
 *
 *   tension + bending >= bond          stresses at the edge of a beam
 *   shear >= bond                      Mohr-Coulomb: |k_t u_t| over cohesion and compression
 *   tension + shear + bending >= bond  loads_add: the strengths are forces
 *   u_n >= bond_extension
 *
 * holds for the forces of its springs; each load is divided by its strength. The step's force on
 * the bodies is then without it. What its springs held, with the work that they do in this last
 * step, is the loss `broken`. */

/* Ways in which a bond breaks: the largest of its loads. */
#ifndef LAW_BOND_COMMON
#define LAW_BOND_COMMON
enum { BROKEN_NONE, BROKEN_TENSION, BROKEN_SHEAR, BROKEN_BENDING };
#endif

/* Energies of a bond in one step, and how it ends. */
typedef struct LANE(bond_output) {
  LANE(mask) breaks; /* bonds that break in this step */
  LANE(real) mode;   /* BROKEN_ number of those that break */
  LANE(real) broken; /* their energy; 0 of all others */
  LANE(real) viscous, work;
} LANE(bond_output);

/* A spring of a bond with its dashpot, in one step. */
typedef struct LANE(bond_spring) {
  LANE(real) stiffness, gamma;
  LANE(real) u, moved, rate; /* displacement now, its change in this step, its time derivative */
} LANE(bond_spring);

/* Returns the force of a spring and its dashpot while the bond lasts, else 0. force_before: that
 * before the step. Adds to out->viscous, and to out->broken where the bond breaks. */
LANE_INLINE LANE(real) LANE(bond_pulls)(const LANE(bond_spring) * s, LANE(real) force_before,
                                        LANE(mask) lasts, LANE(bond_output) * out) {
  const LANE(real) half = LANE(splat)(0.5), before = s->u - s->moved;
  const LANE(real) drag = LANE(mask_zero)(lasts, s->gamma * s->rate);
  out->viscous = out->viscous + half * ((force_before - s->stiffness * before) + drag) * s->moved;
  out->broken = out->broken + half * s->stiffness * before * s->u;
  return LANE(mask_zero)(lasts, s->stiffness * s->u + drag);
}

/* Sets out->breaks and out->mode. tension, shear, bend: forces of the springs; u: extension. */
LANE_INLINE void LANE(bond_loads)(const LANE(contact_constants) * k, LANE(real) arm, LANE(real) u,
                                  LANE(real) tension, LANE(real) shear, LANE(real) bend,
                                  LANE(mask) bonded, LANE(real) strength, LANE(bond_output) * out) {
  const LANE(real) zero = LANE(splat)(0.0), one = LANE(splat)(1.0);
  const LANE(mask) add = LANE(greater)(k->loads_add, zero);
  LANE(real) pulled = tension * k->per_tension;
  pulled = LANE(select)(add, LANE(max)(pulled, zero), pulled);
  const LANE(real) bent = LANE(max)(bend * arm, -(bend * arm)) * k->per_bending;
  const LANE(real) sheared =
      LANE(max)((LANE(max)(shear, -shear) + k->bond_friction * tension) * k->per_shear, zero);
  const LANE(real) load = pulled + bent + LANE(select)(add, sheared, zero);
  const LANE(mask) longer = LANE(not )(LANE(greater)(one, u * k->per_extension));
  out->breaks = bonded & (longer | LANE(not )(LANE(greater)(strength, LANE(max)(load, sheared))));
  LANE(real)
  mode = LANE(select)(LANE(greater)(bent, pulled), LANE(splat)(BROKEN_BENDING),
                      LANE(splat)(BROKEN_TENSION));
  mode = LANE(select)(LANE(greater)(sheared, LANE(max)(pulled, bent)), LANE(splat)(BROKEN_SHEAR),
                      mode);
  mode = LANE(select)(longer, LANE(splat)(BROKEN_TENSION), mode);
  out->mode = LANE(mask_zero)(out->breaks, mode);
}

/* Advances bonds by one step, before the rest of the contact: updates the bond_ members of *m, and
 * makes m->force, m->tau and m->roll those without the bond before the step. g: geometry with slide
 * and rho. exists: lanes in which the two surfaces still face each other; bonds elsewhere break.
 * Without LAW_BOND in `features` only *out is set, to zeros. */
LANE_INLINE void LANE(bond_step)(const LANE(pair_geometry) * g, const LANE(contact_constants) * k,
                                 LANE(mask) exists, const int paper, const unsigned features,
                                 LANE(contact_memory) * m, LANE(bond_output) * out) {
  const LANE(real) zero = LANE(splat)(0.0), half = LANE(splat)(0.5);
  out->viscous = out->broken = out->work = out->mode = zero;
  out->breaks = LANE(all_lanes)(0);
  if (!(features & LAW_BOND)) return;
  const LANE(mask) bonded = LANE(greater)(m->bond, zero);
  if (!LANE(any)(bonded)) return;
  const LANE(bond_spring) normal = {k->bond_k_n, k->bond_gamma_n, m->bond_overlap - g->reach,
                                    m->overlap - g->reach, g->approach},
                          tangent = {k->bond_k_t, k->bond_gamma_t, g->lambda - m->bond_lambda,
                                     (g->lambda - m->lambda_ref) - m->zeta, g->slide},
                          turn = {k->bond_k_r, k->bond_gamma_r, g->rho - m->bond_rho,
                                  (g->rho - m->rho_ref) - m->rho, g->rolls};
  LANE(bond_loads)
  (k, g->arm, normal.u, normal.stiffness * normal.u, tangent.stiffness * tangent.u,
   turn.stiffness * turn.u, bonded, m->bond, out);
  out->breaks = out->breaks | (bonded & LANE(not )(exists));
  out->mode = LANE(select)(bonded & LANE(not )(exists), LANE(splat)(BROKEN_SHEAR), out->mode);
  const LANE(mask) lasts = bonded & LANE(not )(out->breaks);
  const LANE(real) pull = LANE(bond_pulls)(&normal, m->bond_pull, lasts, out),
                   shear = LANE(bond_pulls)(&tangent, m->bond_shear, lasts, out),
                   bend = LANE(bond_pulls)(&turn, m->bond_bend, lasts, out);
  if (paper)
    out->work = LANE(mask_zero)(bonded, half * (m->bond_shear * m->overlap + shear * g->reach) *
                                            (m->turned - g->turned));
  out->viscous = LANE(mask_zero)(bonded, out->viscous);
  out->broken = LANE(mask_zero)(out->breaks, out->broken);
  m->force = LANE(select)(bonded, m->force + m->bond_pull, m->force);
  m->tau = LANE(select)(bonded, m->tau + m->bond_shear, m->tau);
  m->roll = LANE(select)(bonded, m->roll + m->bond_bend, m->roll);
  m->bond = LANE(mask_zero)(lasts, m->bond);
  m->bond_overlap = LANE(mask_zero)(lasts, m->bond_overlap);
  m->bond_lambda = LANE(mask_zero)(lasts, m->bond_lambda);
  m->bond_rho = LANE(mask_zero)(lasts, m->bond_rho);
  m->bond_pull = pull;
  m->bond_shear = shear;
  m->bond_bend = bend;
}

/* True for bonds that act in place of friction. m: record after bond_step. */
LANE_INLINE LANE(mask)
    LANE(bond_is_alone)(const LANE(contact_constants) * k, const LANE(contact_memory) * m) {
  const LANE(real) zero = LANE(splat)(0.0);
  return LANE(greater)(m->bond, zero) & LANE(greater)(k->bond_alone, zero);
}

/* Adds the forces of the bonds to those of the rest of the contact, after the step. */
LANE_INLINE void LANE(bond_add)(const LANE(pair_geometry) * g, const LANE(bond_output) * bond,
                                LANE(contact_memory) * m, LANE(contact_output) * out) {
  m->force = m->force - m->bond_pull;
  m->tau = m->tau - m->bond_shear;
  m->roll = m->roll - m->bond_bend;
  out->couple = m->roll * g->arm;
  out->viscous = out->viscous + bond->viscous;
  out->work = out->work + bond->work;
}

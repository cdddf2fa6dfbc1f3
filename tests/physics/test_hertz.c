/* The Hertz law: closed forms of single collisions, energy, general step against small systems. */
#include "system.h"

enum { SMALL, GENERAL };

/* Two disks collide head-on along x; in a periodic box the general step does it. */
static sd_simulation *collision(sd_contact_law law, sd_integrator integrator, double speed,
                                double dt, int way) {
  sd_model *m = system_new(integrator, SD_CONSERVATIVE, dt, law);
  system_disk(m, 0, 0, 1, 0.1);
  system_disk(m, 2 + 1e-3 * speed, 0, 1, 0.3);
  system_velocity(m, 0, speed, 0, 0);
  if (way == GENERAL) {
    m->periodic[SD_Y] = true;
    m->lower[SD_Y] = -10;
    m->upper[SD_Y] = 10;
  }
  return system_start(m);
}

static const double m_eff = 0.1 * 0.3 / 0.4;

/* Advances until the contact is over; returns steps with a contact. */
static int64_t collide(sd_simulation *s) {
  int64_t closed = 0;
  for (int64_t k = 0; k < 10000000; k++) {
    system_advance(s, 1);
    if (sd_simulation_state(s)->n_contacts)
      closed++;
    else if (closed)
      return closed;
  }
  fail_msg("the disks do not come apart");
  return 0;
}

static double relative_speed(sd_simulation *s) { return system_at(s, 1).vx - system_at(s, 0).vx; }

/* Duration (m_eff/k)^(2/5) v^(-1/5) 2.9432 (Landau and Lifshitz, Theory of Elasticity 9, with F = k delta^(3/2)): t =
 * 2 integral of d delta/sqrt(v^2 - (4/5)(k/m) delta^(5/2)) = 2 (5 m/(4 k))^(2/5) v^(-1/5) I, I = sqrt(pi) Gamma(7/5)/Gamma(9/10). */
static void elastic_collision(void **unused) {
  const double k = 1e4, integral = sqrt(M_PI) * tgamma(1.4) / tgamma(0.9);
  for (int integrator = 0; integrator < 2; integrator++)
    for (double speed = 0.01; speed < 2; speed *= 10) {
      const sd_contact_law law = {.k_n = k, .normal = SD_NORMAL_HERTZ};
      const double t = 2 * pow(1.25 * m_eff / k, 0.4) * pow(speed, -0.2) * integral, dt = t / 4000;
      sd_simulation *s = collision(law, (sd_integrator)integrator, speed, dt, SMALL);
      const int64_t steps = collide(s);
      SYSTEM_NEAR((double)steps * dt, t, 3 * dt, "duration at speed %g", speed);
      SYSTEM_NEAR(relative_speed(s), speed, 1e-6 * speed, "speed after an elastic collision");
      sd_energy e = sd_simulation_energy(s);
      SYSTEM_NEAR(e.residual, 0, 1e-6 * e.scale, "residual");
      system_end(s);
    }
}

/* e does not depend on the speed, and is that of the deck. */
static void restitution(void **unused) {
  const double k = 1e4;
  for (double e = 0.2; e < 0.95; e += 0.2)
    for (int integrator = 0; integrator < 2; integrator++)
      for (double speed = 0.01; speed < 2; speed *= 10) {
        const sd_contact_law law = {.k_n = k, .normal = SD_NORMAL_HERTZ, .restitution = e};
        const double t = 2.94 * pow(m_eff / k, 0.4) * pow(speed, -0.2);
        sd_simulation *s = collision(law, (sd_integrator)integrator, speed, t / 20000, SMALL);
        collide(s);
        SYSTEM_NEAR(relative_speed(s) / speed, e, 2e-3 * e, "%s: restitution at speed %g",
                    system_integrators[integrator], speed);
        sd_energy now = sd_simulation_energy(s);
        SYSTEM_NEAR(now.residual, 0, 1e-4 * now.scale, "residual at e = %g", e);
        system_end(s);
      }
}

/* Small systems and the general step: the same bits. */
static void two_ways(void **unused) {
  const sd_contact_law law = {.k_n = 1e4,
                              .k_t = 3e3,
                              .gamma_n = 0.1,
                              .mu = 0.3,
                              .normal = SD_NORMAL_HERTZ,
                              .restitution = 0.6};
  for (int integrator = 0; integrator < 2; integrator++) {
    sd_simulation *one = collision(law, (sd_integrator)integrator, 0.5, 1e-5, SMALL);
    sd_simulation *two = collision(law, (sd_integrator)integrator, 0.5, 1e-5, GENERAL);
    system_advance(one, 3000);
    system_advance(two, 3000);
    assert_true(sd_simulation_state(one)->n_contacts == 1);
    for (int k = 0; k < 3; k++) {
      system_advance(one, 1000);
      system_advance(two, 1000);
      for (uint32_t i = 0; i < 2; i++) {
        system_body a = system_at(one, i), b = system_at(two, i);
        assert_true(a.x == b.x && a.vx == b.vx && a.theta == b.theta);
      }
    }
    system_end(one);
    system_end(two);
  }
}

RUN_TESTS(TEST(elastic_collision), TEST(restitution), TEST(two_ways))

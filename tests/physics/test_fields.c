/* test_fields.c: drag, non-viscous damping, central forces and rotating frames against closed forms, and their energy budget. */
#include <complex.h>

#include "brief.h"
#include "deck_runs.h"
#include "model/field_kinds.h"
#include "system.h"

/* One disk of mass 2, radius 0.5, inertia 0.25 at z with velocity v; no walls. */
static sd_model *one_disk(sd_integrator integrator, double dt, double complex z, double complex v) {
  sd_model *m = system_new(integrator, SD_PAPER, dt, (sd_contact_law){.k_n = 1});
  system_disk(m, creal(z), cimag(z), 0.5, 2);
  system_velocity(m, 0, creal(v), cimag(v), 0);
  return m;
}

static double complex place_of(sd_simulation *s) {
  const system_body b = system_at(s, 0);
  return b.x + I * b.y;
}
static double complex velocity_of(sd_simulation *s) {
  const system_body b = system_at(s, 0);
  return b.vx + I * b.vy;
}

static void near(double complex value, double complex expected, double tolerance,
                 const char *what) {
  SYSTEM_NEAR(creal(value), creal(expected), tolerance, "%s, real part", what);
  SYSTEM_NEAR(cimag(value), cimag(expected), tolerance, "%s, imaginary part", what);
}

/* Residual of the budget over its scale. */
static void balanced(sd_simulation *s, double most, const char *what) {
  const sd_energy e = sd_simulation_energy(s);
  SYSTEM_NEAR(e.residual / e.scale, 0, most, "residual: %s", what);
}

static int64_t steps_in(double time, double dt) { return (int64_t)nearbyint(time / dt); }

#define BOTH(integrator)                                                                           \
  for (sd_integrator integrator = SD_GEAR5; integrator <= SD_VERLET;                               \
       integrator = (sd_integrator)(integrator + 1))

/* v e^(-f t/m), omega e^(-f_r t/I); what is lost is the kinetic energy. */
static void drag_decays(sd_field_per per, double rate, double turn_rate) {
  BOTH(integrator) {
    double error[2];
    for (int fine = 0; fine < 2; fine++) {
      const double dt = fine ? 5e-4 : 1e-3, t = 3;
      sd_model *m = one_disk(integrator, dt, 1, 3 - I);
      m->disks[0].velocity[SD_THETA] = 7;
      sd_model_add_field(
          m,
          &(sd_body_force){
              .kind = SD_FIELD_DRAG, .per = per, .gamma = 0.6, .gamma_rotation = 0.4, .power = 1});
      sd_simulation *s = system_start(m);
      system_advance(s, steps_in(t, dt));
      const double complex v = (3 - I) * exp(-rate * t),
                           z = 1 + (3 - I) * (1 - exp(-rate * t)) / rate;
      near(velocity_of(s), v, 1e-6, "velocity under drag");
      near(place_of(s), z, 1e-6, "place under drag");
      SYSTEM_NEAR(system_at(s, 0).omega, 7 * exp(-turn_rate * t), 1e-6,
                  "angular velocity under drag");
      error[fine] = cabs(place_of(s) - z);
      const sd_energy e = sd_simulation_energy(s);
      const double left = 0.5 * 2 * creal(v * conj(v)) + 0.5 * 0.25 * 49 * exp(-2 * turn_rate * t);
      SYSTEM_NEAR(e.drag, 0.5 * 2 * 10 + 0.5 * 0.25 * 49 - left, 1e-5, "loss of drag");
      SYSTEM_NEAR(e.work, 0, 1e-12, "work of a fluid at rest");
      balanced(s, 1e-6, "drag");
      system_end(s);
    }
    if (integrator == SD_VERLET) between(error[0] / error[1], 3.8, 4.2, "second order under drag");
  }
}

static void drag_slows_disks_down(void **unused) {
  drag_decays(SD_FIELD_PER_DISK, 0.6 / 2, 0.4 / 0.25);
  drag_decays(SD_FIELD_PER_RADIUS, 0.6 * 0.5 / 2, 0.4 * 0.125 / 0.25);
  drag_decays(SD_FIELD_PER_MASS, 0.6, 0.4);
}

/* m g/f, whatever dt is: implicit. With f dt/m = 5 a scheme that takes the predicted velocity blows up. */
static void a_sinking_disk_reaches_its_terminal_velocity(void **unused) {
  BOTH(integrator)
  for (int strong = 0; strong < 2; strong++) {
    if (strong && integrator == SD_GEAR5) continue;
    const double dt = 1e-2, f = strong ? 1000 : 4;
    sd_model *m = one_disk(integrator, dt, 0, 0);
    sd_model_set_gravity(m, 0, -10);
    sd_model_add_field(m, &(sd_body_force){.kind = SD_FIELD_DRAG, .gamma = f, .power = 1});
    sd_simulation *s = system_start(m);
    system_advance(s, 2000);
    near(velocity_of(s), -20 * I / f, 1e-9 * 20 / f, "terminal velocity");
    balanced(s, strong ? 1e-3 : 1e-5, "sinking");
    system_end(s);
  }
}

/* Started from rest at height y: v = u (1 - e^(-t/tau)), omega = -(shear rate)/2 (1 - e^(-t/tau_r)); f and f_r as above. */
static void shear_flow_carries_and_turns(void **unused) {
  BOTH(integrator) {
    const double dt = 1e-3, t = 5, u = 0.7 + 2 * (0.5 - 0.1), tau = 2 / 0.8, tau_r = 0.25 / 0.4;
    sd_model *m = one_disk(integrator, dt, 0.5 * I, 0);
    sd_model_add_field(m, &(sd_body_force){.kind = SD_FIELD_DRAG,
                                           .gamma = 0.8,
                                           .gamma_rotation = 0.4,
                                           .centre = {9, 0.1},
                                           .flow = {0.7, 0},
                                           .shear_rate = 2,
                                           .power = 1});
    sd_simulation *s = system_start(m);
    system_advance(s, steps_in(t, dt));
    near(place_of(s), u * (t - tau * (1 - exp(-t / tau))) + 0.5 * I, 1e-6, "place in a shear flow");
    SYSTEM_NEAR(system_at(s, 0).omega, -1 + exp(-t / tau_r), 1e-6, "spin in a shear flow");
    balanced(s, 1e-6, "shear flow");
    /* the fluid's work: integral of f u (u - v) and f_r w (w - omega) */
    const sd_energy e = sd_simulation_energy(s);
    SYSTEM_NEAR(e.work,
                0.8 * u * u * tau * (1 - exp(-t / tau)) + 0.4 * tau_r * (1 - exp(-t / tau_r)), 1e-5,
                "work of the fluid");
    system_end(s);
  }
}

/* m z'' = f (i w z - z'): z = e^(s t) with m s^2 + f s = i f w; the disk spirals out. */
static void a_vortex_throws_disks_out(void **unused) {
  BOTH(integrator) {
    const double dt = 1e-3, t = 4, f = 6, w = 1.5;
    const double complex root = (-f + csqrt(f * f + 4 * 2 * I * f * w)) / 4, centre = 2 - I;
    sd_model *m = one_disk(integrator, dt, centre + 1, root);
    sd_model_add_field(m, &(sd_body_force){.kind = SD_FIELD_DRAG,
                                           .gamma = f,
                                           .gamma_rotation = 1,
                                           .swirl = w,
                                           .centre = {creal(centre), cimag(centre)},
                                           .power = 1});
    sd_simulation *s = system_start(m);
    system_advance(s, steps_in(t, dt));
    near(place_of(s), centre + cexp(root * t), 1e-5, "place in a vortex");
    assert_true(cabs(place_of(s) - centre) > 3);
    SYSTEM_NEAR(system_at(s, 0).omega, w * (1 - exp(-4 * t)), 1e-5, "spin in a vortex");
    balanced(s, 1e-5, "vortex");
    system_end(s);
  }
}

static void a_spring_gives_ellipses(void **unused) {
  BOTH(integrator) {
    const double w = 2, dt = M_PI / 4000; /* 4000 steps a period */
    sd_model *m = one_disk(integrator, dt, 2 + I, 0.6 * I);
    sd_model_add_field(m, &(sd_body_force){.kind = SD_FIELD_CENTRAL,
                                           .strength = w * w,
                                           .per = SD_FIELD_PER_MASS,
                                           .power = 1,
                                           .centre = {1, 1}});
    sd_simulation *s = system_start(m);
    for (int quarter = 1; quarter <= 40; quarter++) {
      system_advance(s, 1000);
      const double phase = quarter * M_PI / 2;
      near(place_of(s), 1 + I + cos(phase) + 0.3 * I * sin(phase), 1e-4, "harmonic orbit");
    }
    balanced(s, 1e-6, "spring");
    system_end(s);
  }
}

/* Eccentricity 0.6: perihelion at 0.4 a; the period is 2 pi sqrt(m a^3/strength). */
static void point_gravity_gives_kepler_ellipses(void **unused) {
  BOTH(integrator) {
    const double a = 1.5, e = 0.6, strength = 3, mu = strength / 2,
                 period = 2 * M_PI * sqrt(a * a * a / mu);
    const double dt = period / 40000, speed = sqrt(mu / a * (1 + e) / (1 - e));
    sd_model *m = one_disk(integrator, dt, a * (1 - e), I * speed);
    sd_model_add_field(
        m, &(sd_body_force){.kind = SD_FIELD_CENTRAL, .strength = strength, .power = -2});
    sd_simulation *s = system_start(m);
    for (int half = 1; half <= 6; half++) {
      system_advance(s, 20000);
      near(place_of(s), half % 2 ? -a * (1 + e) : a * (1 - e), 1e-4, "Kepler ellipse");
      const double complex z = place_of(s), v = velocity_of(s);
      SYSTEM_NEAR(cimag(conj(z) * v), a * (1 - e) * speed, integrator == SD_GEAR5 ? 1e-7 : 1e-9,
                  "angular momentum");
      SYSTEM_NEAR(cabs(v) * cabs(v) / 2 - mu / cabs(z), -mu / (2 * a), 1e-6, "energy of the orbit");
    }
    balanced(s, 1e-6, "Kepler");
    system_end(s);
  }
}

static double potential(double strength, int power, double softening, double complex z) {
  const double s = hypot(cabs(z), softening);
  return power == -1 ? strength * log(s) : strength * pow(s, power + 1) / (power + 1);
}

/* The work is the loss of potential energy, for every power, softened or not, attracting or not. */
static void every_power_has_its_potential(void **unused) {
  BOTH(integrator)
  for (int power = -8; power <= 8; power++)
    for (int soft = 0; soft < 2; soft++) {
      const double strength = power % 3 ? 0.3 : -0.3, softening = soft ? 0.4 : 0, dt = 2e-4;
      sd_model *m = one_disk(integrator, dt, 1.3 + 0.4 * I, 0.1 * I - 0.5);
      sd_model_add_field(m, &(sd_body_force){.kind = SD_FIELD_CENTRAL,
                                             .strength = strength,
                                             .power = power,
                                             .softening = softening});
      sd_simulation *s = system_start(m);
      system_advance(s, 4000);
      const double u = potential(strength, power, softening, place_of(s)),
                   u0 = potential(strength, power, softening, 1.3 + 0.4 * I);
      assert_true(fabs(u - u0) > 1e-4);
      SYSTEM_NEAR(sd_simulation_energy(s).work, u0 - u, 1e-6 * (1 + fabs(u0 - u)), "work, power %d",
                  power);
      balanced(s, 1e-6, "central");
      system_end(s);
    }
}

/* Seen from the laboratory z_lab = e^(i omega t) z: a free disk goes straight. */
static void a_free_disk_is_straight_in_the_laboratory(void **unused) {
  BOTH(integrator) {
    const double dt = 2e-4, t = 3, omega = 1.3;
    const double complex centre = 0.5 - 0.2 * I, z0 = 1 + I, v0 = -0.8 + 0.3 * I;
    sd_model *m = one_disk(integrator, dt, z0, v0);
    sd_model_add_field(m, &(sd_body_force){.kind = SD_FIELD_ROTATION,
                                           .omega = omega,
                                           .centre = {creal(centre), cimag(centre)}});
    sd_simulation *s = system_start(m);
    system_advance(s, steps_in(t, dt));
    const double complex lab = (z0 - centre) + (v0 + I * omega * (z0 - centre)) * t;
    near(place_of(s), centre + cexp(-I * omega * t) * lab, 1e-6, "place in a rotating frame");
    /* work of the centrifugal force alone */
    const double r2 = cabs(lab) * cabs(lab), r02 = cabs(z0 - centre) * cabs(z0 - centre);
    SYSTEM_NEAR(sd_simulation_energy(s).work, omega * omega * (r2 - r02), 1e-5,
                "work of the frame");
    balanced(s, 1e-6, "rotating frame");
    system_end(s);
  }
}

/* Foucault: an oscillator that is isotropic in the laboratory. */
static void a_pendulum_turns_with_the_sky(void **unused) {
  BOTH(integrator) {
    const double dt = 5e-4, t = 20, omega = 0.1, w = 3;
    sd_model *m = one_disk(integrator, dt, 1, -I * omega); /* at rest in the laboratory */
    sd_model_add_field(m, &(sd_body_force){.kind = SD_FIELD_ROTATION, .omega = omega});
    sd_model_add_field(
        m, &(sd_body_force){
               .kind = SD_FIELD_CENTRAL, .strength = w * w, .per = SD_FIELD_PER_MASS, .power = 1});
    sd_simulation *s = system_start(m);
    system_advance(s, steps_in(t, dt));
    near(place_of(s), cexp(-I * omega * t) * cos(w * t), 1e-4, "Foucault's pendulum");
    balanced(s, 1e-6, "pendulum");
    system_end(s);
  }
}

/* Without the centrifugal force a disk circles at 2 omega; its speed stays to rounding. */
static void coriolis_does_no_work(void **unused) {
  const double dt = 1e-2, omega = 2;
  const int steps = BRIEF(1000000, 20000);
  sd_model *m = one_disk(SD_VERLET, dt, 1, 1);
  sd_model_add_field(m, &(sd_body_force){.kind = SD_FIELD_ROTATION, .omega = omega});
  sd_model_add_field(m, &(sd_body_force){.kind = SD_FIELD_CENTRAL,
                                         .strength = omega * omega,
                                         .per = SD_FIELD_PER_MASS,
                                         .power = 1});
  sd_simulation *s = system_start(m);
  system_advance(s, steps);
  SYSTEM_NEAR(cabs(velocity_of(s)), 1, 1e-11, "speed after %d steps under the Coriolis force",
              steps);
  system_end(s);
}

/* A bead on a rail that turns: x = x0 cosh(omega t); the rail's push does no work in its frame. */
static void a_bead_on_a_rail(void **unused) {
  BOTH(integrator) {
    const double dt = 1e-3, t = 2, omega = 1.1;
    sd_model *m = one_disk(integrator, dt, 0.3, 0);
    m->disks[0].locked[SD_Y] = true;
    sd_model_add_field(m, &(sd_body_force){.kind = SD_FIELD_ROTATION, .omega = omega});
    sd_simulation *s = system_start(m);
    system_advance(s, steps_in(t, dt));
    near(place_of(s), 0.3 * cosh(omega * t), 1e-6, "bead");
    balanced(s, 1e-6, "bead");
    system_end(s);
  }
}

/* Outwards the spring brakes with 1 + alpha, inwards it pulls with 1 - alpha: each half cycle takes
 * pi/(2 w) (1/sqrt(1 - alpha) + 1/sqrt(1 + alpha)) and leaves (1 - alpha)/(1 + alpha) of the energy. */
static void a_damped_oscillator_loses_a_fraction_per_half_cycle(void **unused) {
  BOTH(integrator)
  for (double alpha = 0.1; alpha < 0.8; alpha += 0.3) {
    const double w = 2, half = M_PI / (2 * w) * (1 / sqrt(1 - alpha) + 1 / sqrt(1 + alpha)),
                 dt = half / 20000;
    sd_model *m = one_disk(integrator, dt, 1, 0);
    sd_model_add_field(
        m, &(sd_body_force){
               .kind = SD_FIELD_CENTRAL, .strength = w * w, .per = SD_FIELD_PER_MASS, .power = 1});
    sd_model_add_field(m, &(sd_body_force){.kind = SD_FIELD_DAMPING, .alpha = alpha, .power = 1});
    sd_simulation *s = system_start(m);
    double amplitude = 1;
    for (int k = 1; k <= 6; k++) {
      system_advance(s, 20000);
      amplitude *= -sqrt((1 - alpha) / (1 + alpha));
      near(place_of(s), amplitude, 1e-4 * fabs(amplitude), "amplitude after half a cycle");
    }
    const sd_energy e = sd_simulation_energy(s);
    SYSTEM_NEAR(e.damping, 0.5 * 2 * w * w * (1 - amplitude * amplitude), 1e-4, "loss of damping");
    balanced(s, 1e-6, "damped oscillator");
    system_end(s);
  }
}

/* Thrown upwards it rises with g (1 + alpha) and falls with g (1 - alpha); a torque turns it with 1 - alpha_rotation. */
static void damping_takes_from_gravity_and_torques(void **unused) {
  BOTH(integrator) {
    const double alpha = 0.4, g = 10, v0 = 7, top = v0 * v0 / (2 * g * (1 + alpha)),
                 up = v0 / (g * (1 + alpha));
    const double dt = up / 10000, down = 3 * up;
    sd_model *m = one_disk(integrator, dt, 0, v0 * I);
    sd_model_set_gravity(m, 0, -g);
    m->disks[0].force[SD_THETA] = 3;
    sd_model_add_field(
        m, &(sd_body_force){
               .kind = SD_FIELD_DAMPING, .alpha = alpha, .alpha_rotation = 0.25, .power = 1});
    sd_simulation *s = system_start(m);
    system_advance(s, 10000);
    near(place_of(s), top * I, 1e-4 * top, "top of the flight");
    system_advance(s, 30000);
    const double fall = 0.5 * g * (1 - alpha) * down * down;
    near(place_of(s), (top - fall) * I, 1e-4 * fall,
         "fall"); /* of first order where the force jumps */
    SYSTEM_NEAR(system_at(s, 0).omega, 0.75 * 3 / 0.25 * (up + down), 1e-4, "spin");
    balanced(s, 1e-6, "flight");
    system_end(s);
  }
}

/* The rate of drag is gamma over the mass, or gamma_rotation over the moment of inertia, of the
 * disk that is slowed down most. */
static void rates_of_drag(void **unused) {
  uint32_t disk = 9;
  sd_model *m = one_disk(SD_VERLET, 1e-3, 0, 0);
  system_disk(m, 5, 0, 0.5, 4);
  sd_model_add_field(
      m, &(sd_body_force){.kind = SD_FIELD_DRAG, .gamma = 3, .gamma_rotation = 0.2, .power = 1});
  SYSTEM_NEAR(body_forces_drag_rate(m, &disk), 1.5, 1e-15, "drag");
  assert_int_equal(disk, 0);
  m->fields[0].gamma_rotation = 0.5;
  SYSTEM_NEAR(body_forces_drag_rate(m, &disk), 2, 1e-15, "drag of the rotation");
  sd_model_free(m);
}

RUN_TESTS(TEST(rates_of_drag), TEST(drag_slows_disks_down),
          TEST(a_sinking_disk_reaches_its_terminal_velocity), TEST(shear_flow_carries_and_turns),
          TEST(a_vortex_throws_disks_out), TEST(a_spring_gives_ellipses),
          TEST(point_gravity_gives_kepler_ellipses), TEST(every_power_has_its_potential),
          TEST(a_free_disk_is_straight_in_the_laboratory), TEST(a_pendulum_turns_with_the_sky),
          TEST(coriolis_does_no_work), TEST(a_bead_on_a_rail),
          TEST(a_damped_oscillator_loses_a_fraction_per_half_cycle),
          TEST(damping_takes_from_gravity_and_torques))

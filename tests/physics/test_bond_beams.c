/* test_bond_beams.c: many bonds against continua: rows of disks as beams of Timoshenko's theory, a
 * triangular lattice as an elastic sheet; where a chain and a cantilever break. */
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_linalg.h>

#include "bonds.h"
#include "stresses.h"

/* --- a cantilever ----------------------------------------------------------------------------- */

/* Disks 0 (held) to n in a row along x, which touch; beam of width w, mass mu per length. */
typedef struct row {
  int n;
  double spacing, E, w, nu, mu;
} row;

static double row_bending(const row *b) { return b->E * b->w * b->w * b->w / 12; }
static double row_shear(const row *b) { return b->E * b->w / (2 * (1 + b->nu)); }
static double disk_mass(const row *b) { return b->mu * b->spacing; }
static double disk_inertia(const row *b) { return disk_mass(b) * b->spacing * b->spacing / 8; }
/* Of the fastest wave that the row bears. */
static double row_step(const row *b) {
  return 0.2 / 4 * sqrt(b->mu * b->spacing * b->spacing / (b->E * b->w));
}

static law row_law(const row *b) {
  return (law){.k_n = 1e-9,
               .bond_gap = 1e-9,
               .bond_E = b->E,
               .bond_width = b->w,
               .bond_poisson = b->nu,
               .bond_extension = 0.1 * b->spacing};
}

/* velocity: of y and theta of disks 1 to n in turn, or NULL. more: of the last disk; rest: of
 * the deck. */
static sd_simulation *row_begin(const row *b, const law *l, double dt, const double *velocity,
                                const char *more, const char *rest) {
  text t = {0};
  bonds_deck(&t, SD_VERLET, SD_CONSERVATIVE, dt, l);
  text_add(&t, "disks = ( ");
  for (int k = 0; k <= b->n; k++) {
    char keys[200] = "fixed = true;";
    if (k && velocity)
      snprintf(keys, sizeof keys, "vy = %.17g; omega = %.17g;", velocity[2 * k - 2],
               velocity[2 * k - 1]);
    else if (k)
      snprintf(keys, sizeof keys, "%s", k == b->n ? more : "");
    bonds_disk(&t, k == 0, (double[]){k * b->spacing, 0}, 0.5 * b->spacing, disk_mass(b), keys);
  }
  text_add(&t, " );\nphases = ( { steps = 1e15; bond = {}; } );\n%s", rest);
  sd_simulation *s = laws_begin(&t, false);
  assert_int_equal(bonds_left(s), b->n);
  return s;
}

static row row_of(int n, double spacing) { return (row){n, spacing, 3, 0.3, 0.3, 1.7}; }

/* Deflection at the tip P L^3/(3 E I) (1 - 1/(4 n^2)) + P L/(G A), L = n spacing: the row is the
 * beam's trapezoidal rule,
 * moments act in the middle of bonds. Its angle is the beam's, P L^2/(2 E I). */
static void bent(void **unused) {
  for (int n = 4; n <= 16; n *= 2) {
    const row b = row_of(n, 1.0 / n);
    const law l = row_law(&b);
    const double P = 1e-6, L = 1, EI = row_bending(&b), GA = row_shear(&b),
                 timoshenko = P * L * L * L / (3 * EI) + P * L / GA,
                 expected = timoshenko - P * L * L * L / (12 * EI * n * n);
    char force[100];
    snprintf(force, sizeof force, "force = (0, %.17g);", P);
    sd_simulation *s = row_begin(&b, &l, row_step(&b), NULL, force,
                                 "fields = ( { type = \"damping\"; alpha = 0.5; } );\n");
    system_advance(s, 3000 * n * n);
    const system_body tip = system_at(s, (uint32_t)n);
    print_message("cantilever of %2d bonds: deflection over Timoshenko's %.8f, of the row %.8f; "
                  "angle over the beam's %.8f\n",
                  n, tip.y / timoshenko, tip.y / expected,
                  (double)tip.theta / (P * L * L / (2 * EI)));
    SYSTEM_NEAR(tip.y, expected, 1e-6 * expected, "deflection");
    SYSTEM_NEAR((double)tip.theta, P * L * L / (2 * EI), 1e-6 * P * L * L / (2 * EI), "angle");
    system_end(s);
  }
}

/* Square of the frequencies of the row in rising order, and its modes as y and theta of disks 1
 * to n. */
static void row_modes(const row *b, gsl_vector *square, gsl_matrix *modes) {
  const size_t size = 2 * (size_t)b->n;
  const double h = b->spacing, mass[2] = {disk_mass(b), disk_inertia(b)};
  gsl_matrix *k = gsl_matrix_calloc(size, size);
  for (int bond = 0; bond < b->n; bond++) {
    /* y and theta of both disks; extension of the springs of bending and of shear per unit of
     * them */
    const double change[2][4] = {{0, -1, 0, 1}, {1 / h, 0.5, -1 / h, 0.5}},
                 stiffness[2] = {row_bending(b) / h, row_shear(b) * h};
    for (int q = 0; q < 4; q++)
      for (int p = 0; p < 4; p++) {
        const int i = 2 * (bond - 1) + q, j = 2 * (bond - 1) + p;
        if (i < 0 || j < 0) continue; /* disk 0 is held */
        double sum = 0;
        for (int m = 0; m < 2; m++) sum += stiffness[m] * change[m][q] * change[m][p];
        *gsl_matrix_ptr(k, (size_t)i, (size_t)j) += sum / sqrt(mass[i % 2] * mass[j % 2]);
      }
  }
  gsl_eigen_symmv_workspace *space = gsl_eigen_symmv_alloc(size);
  gsl_eigen_symmv(k, square, modes, space);
  gsl_eigen_symmv_sort(square, modes, GSL_EIGEN_SORT_VAL_ASC);
  gsl_eigen_symmv_free(space);
  gsl_matrix_free(k);
}

/* Determinant that vanishes at the frequencies of the beam of length L, clamped and free: y' =
 * theta + Q/GA, theta' = M/EI,
 * M' = -Q - J w^2 theta, Q' = -mu w^2 y, with the rotary inertia J of the disks. */
static double beam_determinant(const row *b, double L, double w) {
  double a[16] = {0, L, 0, L / row_shear(b), 0, 0, L / row_bending(b), 0}, e[16];
  a[9] = -L * disk_inertia(b) / b->spacing * w * w;
  a[11] = -L;
  a[12] = -L * b->mu * w * w;
  gsl_matrix_view from = gsl_matrix_view_array(a, 4, 4), to = gsl_matrix_view_array(e, 4, 4);
  assert_int_equal(gsl_linalg_exponential_ss(&from.matrix, &to.matrix, GSL_PREC_DOUBLE),
                   GSL_SUCCESS);
  return e[10] * e[15] - e[11] * e[14];
}

static void beam_frequencies(const row *b, double L, int n, double w[]) {
  const double step = 0.01 * sqrt(row_bending(b) / b->mu) / (L * L);
  double low = step, before = beam_determinant(b, L, low);
  for (int k = 0; k < n; low += step) {
    const double after = beam_determinant(b, L, low + step);
    if ((before < 0) != (after < 0)) w[k++] = low + step * before / (before - after);
    before = after;
  }
}

/* Frequency of a row that swings in its mode, in units of the mode's. */
static double swing(const row *b, int mode, double w, const gsl_matrix *modes) {
  const size_t size = 2 * (size_t)b->n;
  const double root[2] = {sqrt(disk_mass(b)), sqrt(disk_inertia(b))}, dt = 0.2 * row_step(b);
  double velocity[128];
  assert_true(size <= 128);
  for (size_t k = 0; k < size; k++)
    velocity[k] = 1e-7 * w * gsl_matrix_get(modes, k, (size_t)mode) / root[k % 2];
  const law l = row_law(b);
  sd_simulation *s = row_begin(b, &l, dt, velocity, "", "");
  const int64_t stride = (int64_t)(2 * M_PI / w / dt / 200);
  double before = 0, last = 0;
  int crossings = 0;
  while (crossings < 6) {
    system_advance(s, stride);
    double now = 0;
    for (int k = 1; k <= b->n; k++) {
      const system_body at = system_at(s, (uint32_t)k);
      const double q[2] = {at.y, (double)at.theta};
      for (int c = 0; c < 2; c++)
        now += gsl_matrix_get(modes, (size_t)(2 * k - 2 + c), (size_t)mode) * root[c] * q[c];
    }
    if ((before < 0) != (now < 0) && before != 0) {
      last = dt * ((double)sd_simulation_step(s) - (double)stride * now / (now - before));
      crossings++;
    }
    before = now;
  }
  system_end(s);
  return M_PI * crossings / last / w;
}

/* The row is a beam that ends half a spacing beyond the last disk's centre: each disk is the mass
 * about it. Its frequencies
 * approach the beam's by 1/n^2; with the length n spacing, by 1/n. */
static void swings(void **unused) {
  double error[3][3], short_error[3][3];
  for (int q = 0; q < 3; q++) {
    const int n = 8 << q;
    const row b = row_of(n, 1 / (n + 0.5));
    double beam[3], shorter[3];
    gsl_vector *square = gsl_vector_alloc(2 * (size_t)n);
    gsl_matrix *modes = gsl_matrix_alloc(2 * (size_t)n, 2 * (size_t)n);
    row_modes(&b, square, modes);
    beam_frequencies(&b, 1, 3, beam);
    beam_frequencies(&b, n * b.spacing, 3, shorter);
    for (int k = 0; k < 3; k++) {
      const double w = sqrt(gsl_vector_get(square, (size_t)k));
      error[q][k] = w / beam[k] - 1;
      short_error[q][k] = w / shorter[k] - 1;
      const double run = n <= 16 ? swing(&b, k, w, modes) : 1;
      print_message("row of %2d bonds, mode %d: frequency over the beam's %.6f (%.4f for the "
                    "length of the bonds), run over row %.7f\n",
                    n, k + 1, w / beam[k], w / shorter[k], run);
      SYSTEM_NEAR(run, 1, 2e-6, "frequency of the run");
    }
    gsl_vector_free(square);
    gsl_matrix_free(modes);
  }
  for (int k = 0; k < 3; k++) {
    print_message("mode %d: errors fall by %.2f %.2f, of the length of the bonds by %.2f %.2f\n",
                  k + 1, error[0][k] / error[1][k], error[1][k] / error[2][k],
                  short_error[0][k] / short_error[1][k], short_error[1][k] / short_error[2][k]);
    SYSTEM_NEAR(error[2][k], 0, 1.2e-3, "frequency of mode %d", k + 1);
    for (int q = 0; q < 2; q++) {
      between(error[q][k] / error[q + 1][k], 3.7, 4.1, "order 1/n^2");
      between(short_error[q][k] / short_error[q + 1][k], 1.7, 2.1, "order 1/n");
    }
  }
}

/* --- a triangular lattice --------------------------------------------------------------------- */

/* W = sum over the three directions of (k_n e_nn^2 + k_t e_nt^2)/sqrt(3): the disks do not turn in
 * a uniform strain without
 * rotation, so that k_r does not count. The sheet is isotropic:
 *
 *   nu = (k_n - k_t)/(3 k_n + k_t),  E = 2 sqrt(3) k_n (k_n + k_t)/(3 k_n + k_t)
 */
enum { SIDE = 6 };

/* Stresses over a strain of the given size: ratio[0] xx, [1] yy. */
static void stress_per_strain(const law *l, bool swapped, const char *strain, double size, int i,
                              double ratio[2]) {
  const double dt = 1e-3, height = SIDE * sqrt(0.75);
  const int64_t steps = 100;
  text t = {0};
  bonds_deck(&t, (sd_integrator)i, SD_CONSERVATIVE, dt, l);
  text_add(&t,
           "measure = { rotation = (); }; box = { %s = (0, %d); %s = (0, %.17g); periodic = "
           "\"xy\"; };\n",
           swapped ? "y" : "x", SIDE, swapped ? "x" : "y", height);
  text_add(&t, "disk_rows = ( { columns = (\"%s\", \"%s\"); radius = 0.5; mass = 1; rows = (",
           swapped ? "y" : "x", swapped ? "x" : "y");
  for (int k = 0; k < SIDE * SIDE; k++)
    text_add(&t, "%s(%.17g, %.17g)", k ? ", " : "", k % SIDE + 0.5 * (k / SIDE % 2) + 0.2,
             (k / SIDE + 0.3) * sqrt(0.75));
  text_add(&t, ") } );\nphases = ( { steps = 1e6; bond = {}; cell = { %s = %.17g; }; } );\n",
           strain, size / (double)steps / dt);
  sd_simulation *s = laws_begin(&t, false);
  assert_int_equal(bonds_left(s), 3 * SIDE * SIDE);
  double found[4], kinetic[4];
  system_advance(s, steps);
  stress_of(s, found, kinetic);
  for (int c = 0; c < 2; c++) ratio[c] = -found[3 * c] / size;
  SYSTEM_NEAR(found[1], found[2], 1e-9 * size * l->bond_k_n, "symmetry of the stress");
  system_end(s);
}

static void sheet(void **unused) {
  double worst = 0;
  for (int n = 0; n < 12; n++) {
    const law l = {.k_n = 1e-9,
                   .bond_k_n = 700,
                   .bond_k_t = n / 4 == 0   ? 0
                               : n / 4 == 1 ? 200
                                            : 900,
                   .bond_k_r = n % 2 ? 300 : 0,
                   .bond_gap = 1e-6,
                   .bond_extension = 0.1};
    const double kn = l.bond_k_n, kt = l.bond_k_t, nu = (kn - kt) / (3 * kn + kt),
                 E = 2 * sqrt(3) * kn * (kn + kt) / (3 * kn + kt);
    double x[2], y[2];
    stress_per_strain(&l, n / 2 % 2, "rate_xx", 1e-7, n % 2, x);
    stress_per_strain(&l, n / 2 % 2, "rate_yy", 1e-7, n % 2, y);
    const double found_nu[2] = {x[1] / x[0], y[0] / y[1]},
                 found_E[2] = {x[0] - x[1] * y[0] / y[1], y[1] - x[1] * y[0] / x[0]};
    for (int c = 0; c < 2; c++)
      worst = fmax(worst, fmax(fabs(found_nu[c] - nu), fabs(found_E[c] / E - 1)));
    if (n % 4 == 1)
      print_message(
          "lattice of k_t/k_n %.2f: E/k_n %.6f %.6f, exact %.6f; Poisson %.6f %.6f, exact %.6f\n",
          kt / kn, found_E[0] / kn, found_E[1] / kn, E / kn, found_nu[0], found_nu[1], nu);
  }
  print_message("moduli of 12 lattices: off by %.1e\n", worst);
  SYSTEM_NEAR(worst, 0, 1e-6, "moduli");
}

/* --- a chain and a cantilever that break ------------------------------------------------------ */

/* Drives the last disk with a velocity until a bond breaks, and returns what its spring of
 * tension (or shear) pulls then. */
static double drive_until_break(const row *b, const law *l, const char *coordinate, double speed,
                                const char *gravity, int mode) {
  char rest[400];
  snprintf(rest, sizeof rest,
           "%s fields = ( { type = \"damping\"; alpha = 0.4; } );\nmotions = ( { disk = %d; "
           "coordinate = \"%s\"; type = \"velocity\"; velocity = %.17g; } );\n",
           gravity, b->n, coordinate, speed);
  sd_simulation *s = row_begin(b, l, row_step(b), NULL, "", rest);
  const sd_state *q = sd_simulation_state(s);
  tracked_bond last = bond_track(s, (uint32_t)b->n - 1, (uint32_t)b->n);
  bond_displacement u = {0};
  for (int64_t step = 0; q->n_breaks == 0 && step < 4000000; step++) {
    u = bond_now(s, &last);
    system_advance(s, 1);
  }
  assert_int_equal(q->n_breaks, 1);
  assert_true(q->break_a[0] == 0 && q->break_b[0] == 1);
  assert_int_equal(q->break_mode[0], mode);
  system_end(s);
  const double k_n = b->E * b->w / b->spacing;
  return *coordinate == 'x' ? k_n * u.n : fabs(k_n / (2 * (1 + b->nu)) * u.t);
}

static void breaks_at_the_clamp(void **unused) {
  const row b = row_of(8, 1.0 / 8);
  law l = row_law(&b);
  l.bond_extension = 0;
  l.bond_tension = 1e-3 * b.E;
  /* the weight of all disks but the last hangs on the first bond: gravity along x */
  const double weight = 0.2 * l.bond_tension * b.w;
  char gravity[100];
  snprintf(gravity, sizeof gravity, "gravity = { g = %.17g; tilt = -1.5707963267948966; };",
           weight / (7 * disk_mass(&b)));
  const double pull = drive_until_break(&b, &l, "x", 2e-6, gravity, 1) + weight,
               push = drive_until_break(&b, &l, "y", -1e-5, "", 3);
  const double lever = b.n * b.spacing - 0.5 * b.spacing, strength = l.bond_tension * b.w;
  print_message("chain breaks at %.6f of its strength; cantilever at %.6f of it\n", pull / strength,
                6 * push * lever / (b.w * strength));
  SYSTEM_NEAR(pull, strength, 1e-3 * strength, "load of the chain");
  SYSTEM_NEAR(6 * push * lever / b.w, strength, 2e-3 * strength, "load of the cantilever");
}

RUN_TESTS(TEST(bent), TEST(swings), TEST(sheet), TEST(breaks_at_the_clamp))

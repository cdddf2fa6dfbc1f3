/* test_bonds.c: bonds of two or a few disks against closed forms: stiffness and frequency of their
 * modes, loads at which they break, and their energy. */
#include "bonds.h"

/* --- modes ------------------------------------------------------------------------------------ */

/* Two disks, or a disk at a floor, with a bond across `gap`; < 0: over an overlap. */
typedef struct couple {
  bool floor;
  double radius[2], mass[2], gap;
} couple;

static double couple_mass(const couple *c) {
  return c->floor ? c->mass[0] : c->mass[0] * c->mass[1] / (c->mass[0] + c->mass[1]);
}

/* velocity: x, y, omega of both disks; the normal is x for disks, -y at the floor. */
static sd_simulation *bonded(const couple *c, const law *l, sd_integrator i, sd_variant v,
                             double dt, const double velocity[2][3]) {
  text t = {0};
  bonds_deck(&t, i, v, dt, l);
  text_add(&t, "disks = ( ");
  for (int k = 0; k < (c->floor ? 1 : 2); k++) {
    char more[200];
    snprintf(more, sizeof more, "vx = %.17g; vy = %.17g; omega = %.17g;", velocity[k][0],
             velocity[k][1], velocity[k][2]);
    bonds_disk(&t, k == 0, (double[]){k ? c->radius[0] + c->radius[1] + c->gap : 0, 0},
               c->radius[k], c->mass[k], more);
  }
  text_add(&t, " );\nphases = ( { steps = 1e15; bond = {}; } );\n");
  if (c->floor)
    text_add(&t, "walls = ( { type = \"line\"; points = ( (-1, %.17g), (1, %.17g) ); } );\n",
             -c->radius[0] - c->gap, -c->radius[0] - c->gap);
  sd_simulation *s = laws_begin(&t, false);
  assert_int_equal(bonds_left(s), 1);
  return s;
}

/* A law of springs, or the beam, for a couple; fills in k_n, k_t, k_r of its bond. */
static law couple_law(const couple *c, bool beam, double k[3]) {
  law l = {.k_n = 1e-9, .bond_gap = 0.2, .bond_extension = 0.1};
  const double rb = c->floor ? 0 : c->radius[1], length = c->radius[0] + rb,
               arm = c->floor ? c->radius[0] : c->radius[0] * rb / length;
  if (beam) {
    const double E = 700, w = 0.37, nu = 0.31;
    l.bond_E = E;
    l.bond_width = w;
    l.bond_poisson = nu;
    k[0] = E * w / length;
    k[1] = k[0] / (2 * (1 + nu));
    k[2] = E * w * w * w / 12 / length / (arm * arm);
  } else {
    l.bond_k_n = k[0] = 900;
    l.bond_k_t = k[1] = 400;
    l.bond_k_r = k[2] = 250;
  }
  return l;
}

static const couple couples[] = {{false, {0.5, 0.3}, {0.9, 0.4}, 0},
                                 {false, {0.5, 0.3}, {0.9, 0.4}, 0.1},
                                 {false, {0.5, 0.3}, {0.9, 0.4}, -0.02},
                                 {true, {0.5}, {0.9}, 0},
                                 {true, {0.5}, {0.9}, 0.1},
                                 {true, {0.5}, {0.9}, -0.02}};
enum { COUPLES = sizeof couples / sizeof *couples };

static double gap_of(sd_simulation *s, const couple *c) {
  if (c->floor) return system_at(s, 0).y;
  const system_body a = system_at(s, 0), b = system_at(s, 1);
  return hypot(b.x - a.x, b.y - a.y) - (c->radius[0] + c->radius[1] + c->gap);
}

/* mu u'' = -(k_n + bond_k_n) u + k_n overlap, while the surfaces touch; the contact's spring
 * only where there is an overlap. */
static void tension(void **unused) {
  double worst = 0, resid = 0;
  for (int n = 0; n < COUPLES; n++)
    for (int mode = 0; mode < 4; mode++) {
      const couple *c = &couples[n];
      double k[3];
      law l = couple_law(c, mode / 2, k);
      if (c->gap < 0) l.k_n = 120;
      const double speed = c->gap < 0 ? 0.002 : 0.1, m = couple_mass(c),
                   stiffness = k[0] + (c->gap < 0 ? l.k_n : 0), w = sqrt(stiffness / m),
                   dt = 0.003 / w, rest = c->gap < 0 ? -l.k_n * c->gap / stiffness : 0;
      const double v[2][3] = {{0, c->floor ? speed : 0, 0}, {speed, 0, 0}};
      sd_simulation *s = bonded(c, &l, (sd_integrator)(mode % 2), SD_CONSERVATIVE, dt, v);
      for (int step = 0; step < 100; step++) {
        system_advance(s, 211);
        const double at = w * dt * (double)sd_simulation_step(s),
                     u = rest * (1 - cos(at)) + speed / w * sin(at);
        worst = fmax(worst, fabs(gap_of(s, c) - u) / hypot(rest, speed / w));
      }
      const sd_energy e = sd_simulation_energy(s);
      resid = fmax(resid, fabs(e.residual) / e.start);
      assert_int_equal(bonds_left(s), 1);
      system_end(s);
    }
  print_message("tension, 10 periods: error %.1e of the amplitude, residual %.1e\n", worst, resid);
  SYSTEM_NEAR(worst, 0, 2e-4, "tension");
  SYSTEM_NEAR(resid, 0, 2e-6, "residual of tension");
}

/* Solves q'' = -A K q of lambda and rho, from q = 0 with the rates `rate`: q(t) by the modes of
 * the symmetric K^1/2 A K^1/2. */
static void shear_and_bend(const double A[3], const double k[2], const double rate[2], double t,
                           double q[2]) {
  const double a = k[0] * A[0], b = sqrt(k[0] * k[1]) * A[1], c = k[1] * A[2],
               angle = 0.5 * atan2(2 * b, a - c);
  const double mode[2][2] = {{cos(angle), sin(angle)}, {-sin(angle), cos(angle)}};
  q[0] = q[1] = 0;
  for (int j = 0; j < 2; j++) {
    const double *e = mode[j];
    const double w = sqrt(a * e[0] * e[0] + 2 * b * e[0] * e[1] + c * e[1] * e[1]);
    const double amount = (e[0] * sqrt(k[0]) * rate[0] + e[1] * sqrt(k[1]) * rate[1]) / w;
    for (int i = 0; i < 2; i++) q[i] += amount * sin(w * t) * e[i] / sqrt(k[i]);
  }
}

/* lambda'' = -(lever^p/mu + R_a^2/I_a + R_b^2/I_b) k_t lambda + ... for small motions, with lever =
 * (R_a + R_b)/r and p = 2, in the paper's variant 1. touches: 1: the springs of a sticking contact
 * act beside the bond, 2: they do not (bond_alone). */
static double shear_bend_error(const couple *c, int mode, int touches, double *residual) {
  double k[3];
  law l = couple_law(c, mode & 4, k);
  if (touches) {
    l.k_n = 1e-5; /* its push moves the disks by 1e-9 */
    l.k_t = l.k_r = 130;
    l.mu = l.mu_r = 1e12;
    l.bond_alone = touches == 2;
  }
  const sd_variant v = mode & 2 ? SD_PAPER : SD_CONSERVATIVE;
  const double ra = c->radius[0], rb = c->floor ? 0 : c->radius[1], sum = ra + rb,
               arm = c->floor ? ra : ra * rb / sum, lever = c->floor ? 1 : sum / (sum + c->gap);
  const double ia = 2 / (c->mass[0] * ra * ra), ib = c->floor ? 0 : 2 / (c->mass[1] * rb * rb);
  const double A[3] = {lever * (v == SD_PAPER ? 1 : lever) / couple_mass(c) + ra * ra * ia +
                           rb * rb * ib,
                       arm * (ra * ia - rb * ib), arm * arm * (ia + ib)};
  const double more = touches == 1 ? l.k_t : 0, stiffness[2] = {k[1] + more, k[2] + more};
  const double w = sqrt(A[0] * stiffness[0]), dt = 0.003 / w, tiny = 1e-6;
  const double rate[2][3] = {{0.3 * tiny * c->floor, -0.2 * tiny * !c->floor, 0.7 * tiny},
                             {0, 0.4 * tiny, -1.1 * tiny}};
  const double turn = c->floor ? -rate[0][0] : rate[1][1] - rate[0][1],
               spin = c->floor ? 0 : rate[1][2];
  const double start[2] = {ra * rate[0][2] + rb * spin - lever * turn, arm * (rate[0][2] - spin)};
  sd_simulation *s = bonded(c, &l, (sd_integrator)(mode & 1), v, dt, rate);
  const double scale = hypot(start[0], start[1]) / w;
  double worst = 0;
  for (int step = 0; step < 100; step++) {
    system_advance(s, 211);
    const system_body a = system_at(s, 0), b = c->floor ? (system_body){0} : system_at(s, 1);
    const double phi = c->floor ? -a.x / ra : atan2(b.y - a.y, b.x - a.x);
    const double lambda = ra * (double)a.theta + rb * (double)b.theta - sum * phi,
                 rho = arm * (double)(a.theta - b.theta);
    double q[2];
    shear_and_bend(A, stiffness, start, dt * (double)sd_simulation_step(s), q);
    worst = fmax(worst, hypot(lambda - q[0], rho - q[1]) / scale);
  }
  const sd_energy e = sd_simulation_energy(s);
  *residual = fmax(*residual, fabs(e.residual) / e.start);
  assert_int_equal(bonds_left(s), 1);
  system_end(s);
  return worst;
}

static void shear_and_bending(void **unused) {
  double worst = 0, resid = 0;
  for (int n = 0; n < COUPLES; n++)
    for (int mode = 0; mode < 8; mode++)
      for (int touches = 0; touches < (couples[n].gap < 0 ? 3 : 1); touches++) {
        const double error = shear_bend_error(&couples[n], mode, touches, &resid);
        worst = fmax(worst, error);
        if (!(error < 3e-4))
          print_error("couple %d, mode %d, touches %d: %g\n", n, mode, touches, error);
      }
  print_message("shear and bending, 10 periods: error %.1e, residual %.1e\n", worst, resid);
  SYSTEM_NEAR(worst, 0, 3e-4, "shear and bending");
  SYSTEM_NEAR(resid, 0, 2e-6, "residual of shear and bending");
}

/* A heavy disk moves away from a wall of any shape and turns. The beam is as long as the disk's
 * radius. */
static void beams_at_walls(void **unused) {
  static const struct {
    const char *wall;
    double other; /* radius of the wall, < 0: around the disk; 0: straight */
  } shapes[] = {{"type = \"line\"; points = ((-9, 0), (9, 0));", 0},
                {"type = \"circle\"; side = \"outside\"; center = (0, -1.5); radius = 1.5;", 1.5},
                {"type = \"arc\"; center = (0, -1.5); radius = 1.5; from = -2; to = 3;", 1.5},
                {"type = \"circle\"; side = \"inside\"; center = (0, 2); radius = 2;", -2},
                {"type = \"arc\"; center = (0, 2); radius = 2; from = -3; to = 0.5;", -2}};
  const double R = 0.4, gap = 0.03, E = 500, w = 0.2, nu = 0.25, vy = 0.05, spin = 0.3, time = 0.1;
  const law l = {.k_n = 1,
                 .bond_E = E,
                 .bond_width = w,
                 .bond_poisson = nu,
                 .bond_gap = 0.1,
                 .bond_extension = 0.1};
  for (int k = 0; k < 5; k++) {
    const double other = shapes[k].other, arm = other == 0 ? R : R * other / (R + other),
                 k_n = E * w / R;
    text t = {0};
    char more[100];
    bonds_deck(&t, SD_VERLET, SD_CONSERVATIVE, 1e-4, &l);
    snprintf(more, sizeof more, "vy = %.17g; omega = %.17g;", vy, spin);
    text_add(&t, "disks = ( ");
    bonds_disk(&t, true, (double[]){0, R + gap}, R, 1e9, more);
    text_add(&t, " );\nwalls = ( { %s } );\nphases = ( { steps = 1e15; bond = {}; } );\n",
             shapes[k].wall);
    sd_simulation *s = laws_begin(&t, false);
    assert_int_equal(bonds_left(s), 1);
    system_advance(s, 1000);
    const sd_state *q = sd_simulation_state(s);
    SYSTEM_NEAR(q->contact_bond_pull[0], k_n * vy * time, 1e-6 * k_n * vy * time,
                "tension at wall %d", k);
    SYSTEM_NEAR(q->contact_bond_shear[0], k_n / (2 * (1 + nu)) * R * spin * time,
                1e-6 * k_n * R * spin * time, "shear at wall %d", k);
    SYSTEM_NEAR(q->contact_bond_bend[0] * arm, E * w * w * w / 12 / R * spin * time,
                1e-6 * E * w * w * w * spin * time, "moment at wall %d", k);
    system_end(s);
  }
}

/* --- loads at which bonds break --------------------------------------------------------------- */

/* Disk 1 is driven past disk 0, which is held: all displacements are known. */
static sd_simulation *driven(const law *l, const double radius[2], double gap, int i, int v,
                             double dt, int64_t seed, const double rate[3]) {
  text t = {0};
  bonds_deck(&t, (sd_integrator)i, (sd_variant)v, dt, l);
  text_add(&t, "seed = %lld; disks = ( ", (long long)seed);
  bonds_disk(&t, true, (double[]){0, 0}, radius[0], 1, "locked = (\"x\", \"y\", \"theta\");");
  bonds_disk(&t, false, (double[]){radius[0] + radius[1] + gap, 0}, radius[1], 1, "fixed = true;");
  text_add(&t, " );\nmotions = ( ");
  for (int c = 0; c < 3; c++)
    text_add(&t, "%s{ disk = 1; coordinate = \"%s\"; type = \"velocity\"; velocity = %.17g; }",
             c ? ", " : "",
             c == 0   ? "x"
             : c == 1 ? "y"
                      : "theta",
             rate[c]);
  text_add(&t, " );\nphases = ( { steps = 1e15; bond = {}; } );\n");
  sd_simulation *s = laws_begin(&t, false);
  assert_int_equal(bonds_left(s), 1);
  return s;
}

/* Loads of tension, shear and bending over their strength, as the law says, and their sum that
 * counts. */
typedef struct loads {
  double pulled, sheared, bent, total;
} loads;

static loads loads_of(const law *l, const double k[3], double arm, const bond_displacement *u) {
  const bool add = l->bond_max_tension + l->bond_max_shear + l->bond_max_bending > 0;
  const double w = l->bond_width, F = k[0] * u->n, S = fabs(k[1] * u->t),
               M = fabs(k[2] * arm * u->r);
  loads q = {0};
  if (add) {
    if (l->bond_max_tension > 0) q.pulled = fmax(F, 0) / l->bond_max_tension;
    if (l->bond_max_shear > 0) q.sheared = fmax(S + l->bond_friction * F, 0) / l->bond_max_shear;
    if (l->bond_max_bending > 0) q.bent = M / l->bond_max_bending;
    q.total = q.pulled + q.sheared + q.bent;
  } else {
    if (l->bond_tension > 0)
      q.pulled = F / w / l->bond_tension, q.bent = 6 * M / (w * w) / l->bond_tension;
    if (l->bond_cohesion > 0)
      q.sheared = fmax(S / w + l->bond_friction * F / w, 0) / l->bond_cohesion;
    q.total = fmax(q.pulled + q.bent, q.sheared);
  }
  return q;
}

enum { PULL = 1, SHEAR, BEND };

/* The mode with the largest load. */
static int mode_of(const loads *q) {
  return q->sheared > fmax(q->pulled, q->bent) ? SHEAR : q->bent > q->pulled ? BEND : PULL;
}

static double sum_of_springs(const double k[3], const bond_displacement *u) {
  return 0.5 * (k[0] * u->n * u->n + k[1] * u->t * u->t + k[2] * u->r * u->r);
}

static double drawn(uint64_t *seed, double low, double high) {
  return low + (high - low) * next_uniform(seed);
}

/* A law whose strengths are of the order of 1e-3 of the sizes. */
static law strong_law(uint64_t *seed, int form) {
  law l = {.k_n = 50,
           .bond_k_n = drawn(seed, 500, 900),
           .bond_k_t = drawn(seed, 200, 500),
           .bond_k_r = drawn(seed, 200, 900),
           .bond_gap = 0.1,
           .bond_width = drawn(seed, 0.2, 0.5)};
  const double force = drawn(seed, 0.5, 2);
  if (form == 0) {
    l.bond_tension = force / l.bond_width;
    l.bond_cohesion = drawn(seed, 0.3, 2) * l.bond_tension;
  } else if (form == 1) {
    l.bond_max_tension = force;
    l.bond_max_shear = drawn(seed, 0.3, 2) * force;
    l.bond_max_bending = drawn(seed, 0.02, 0.2) * force;
  } else {
    l.bond_extension = drawn(seed, 5e-4, 4e-3);
    if (next_bits(seed) & 1) l.bond_max_shear = force;
  }
  if (form < 2) l.bond_friction = drawn(seed, 0, 0.8);
  if (form < 2 && next_bits(seed) & 1) l.bond_weibull = drawn(seed, 1.5, 5);
  return l;
}

/* Number of a run's first step in which its bond is overloaded; checks that it breaks there,
 * how, and with which energy. Returns how. */
static int breaks_when_overloaded(uint64_t *seed, int n, double *energy_error) {
  const law l = strong_law(seed, n % 3);
  const double radius[2] = {drawn(seed, 0.2, 0.6), drawn(seed, 0.2, 0.6)};
  const double gap = drawn(seed, -0.01, 0.05), dt = 1e-4;
  const double rate[3] = {drawn(seed, -0.02, 0.04), drawn(seed, -0.06, 0.06),
                          drawn(seed, -0.1, 0.1)};
  const double k[3] = {l.bond_k_n, l.bond_k_t, l.bond_k_r};
  sd_simulation *s = driven(&l, radius, gap, n % 2, n / 2 % 2, dt, n, rate);
  const sd_state *q = sd_simulation_state(s);
  tracked_bond bond = bond_track(s, 0, 1);
  const double strength = q->contact_bond[0];
  assert_true(l.bond_weibull > 0 ? strength != 1 : strength == 1);
  int mode = 0;
  for (int step = 1; step <= 20000 && !mode; step++) {
    system_advance(s, 1);
    const bond_displacement u = bond_now(s, &bond);
    const loads load = loads_of(&l, k, bond.arm, &u);
    const bool longer = l.bond_extension > 0 && u.n >= l.bond_extension,
               breaks = longer || load.total >= strength;
    assert_int_equal(q->n_breaks, breaks);
    assert_int_equal(bonds_left(s), !breaks);
    if (!breaks) continue;
    mode = longer ? PULL : mode_of(&load);
    const sd_energy e = sd_simulation_energy(s);
    const double held = sum_of_springs(k, &u),
                 losses[] = {e.broken_tension, e.broken_shear, e.broken_bending};
    assert_int_equal(q->break_step[0], step);
    assert_int_equal(q->break_mode[0], mode);
    assert_true(q->break_a[0] == 0 && q->break_b[0] == 1);
    *energy_error = fmax(*energy_error, fabs(q->break_energy[0] / held - 1) * step);
    SYSTEM_NEAR(losses[mode - 1], q->break_energy[0], 0, "loss of mode %d", mode);
    SYSTEM_NEAR(bonds_broken_energy(&e), q->break_energy[0], 0, "other losses");
    SYSTEM_NEAR(e.residual, 0, 1e-6 * held, "budget of a bond that breaks");
  }
  system_end(s);
  return mode;
}

static void overloads(void **unused) {
  uint64_t seed = 11;
  int count[4] = {0};
  double energy_error = 0;
  for (int n = 0; n < 120; n++) count[breaks_when_overloaded(&seed, n, &energy_error)]++;
  print_message("%d bonds break by tension, %d by shear, %d by bending, %d hold; what they held is "
                "off by %.2f steps' work\n",
                count[PULL], count[SHEAR], count[BEND], count[0], energy_error);
  assert_true(count[PULL] > 10 && count[SHEAR] > 10 && count[BEND] > 10 && count[0] < 30);
  SYSTEM_NEAR(energy_error, 0, 1.5, "energy that bonds held, times steps until they broke");
}

/* --- distributed strengths -------------------------------------------------------------------- */

enum { WIDE = 40, LATTICE = WIDE * WIDE, LATTICE_BONDS = 2 * WIDE * (WIDE - 1) };

/* Strength factors of the bonds of a square lattice, by their bodies: [lower number][0: right, 1:
 * above]. turned: the lattice
 * lies mirrored, and far away. */
static void lattice_strengths(double modulus, int64_t seed, int threads, bool turned,
                              double strength[LATTICE][2]) {
  const law l = {
      .k_n = 1, .bond_k_n = 1, .bond_gap = 0.02, .bond_max_tension = 1e-3, .bond_weibull = modulus};
  text t = {0};
  bonds_deck(&t, SD_VERLET, SD_CONSERVATIVE, 1e-3, &l);
  text_add(
      &t,
      "seed = %lld; disk_rows = ( { columns = (\"x\", \"y\"); radius = 0.495; mass = 1; rows = ( ",
      (long long)seed);
  for (int k = 0; k < LATTICE; k++)
    text_add(&t, "%s(%d, %d)", k ? ", " : "", turned ? 900 - k % WIDE : k % WIDE, k / WIDE);
  text_add(&t, " ); } );\nphases = ( { steps = 1e15; bond = {}; } );\n");
  sd_model *m = model_of_text(&t);
  sd_simulation *sim = begin_run(m, threads);
  const sd_state *s = sd_simulation_state(sim);
  assert_int_equal(bonds_left(sim), LATTICE_BONDS);
  for (size_t k = 0; k < s->n_contacts; k++) {
    const uint32_t a = s->contact_a[k], b = s->contact_b[k], low = a < b ? a : b;
    strength[low][a + b - 2 * low == 1 ? 0 : 1] = s->contact_bond[k];
  }
  end_run(sim, m);
}

static int by_size(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

/* Largest distance of the distribution of n numbers from P(s) = 1 - exp(-s^modulus), times
 * sqrt(n): 1.63 at a level of 1 %. */
static double kolmogorov(double *s, int n, double modulus) {
  double worst = 0;
  qsort(s, (size_t)n, sizeof *s, by_size);
  for (int k = 0; k < n; k++) {
    const double p = -expm1(-pow(s[k], modulus));
    worst = fmax(worst, fmax(fabs(p - (double)k / n), fabs(p - (k + 1.0) / n)));
  }
  return worst * sqrt(n);
}

/* Correlation of exp(-s^modulus), which is even between 0 and 1, of bonds that share a disk; its
 * error is 1/sqrt(n). */
static double neighbours(double strength[LATTICE][2], double modulus, int step, int one, int two) {
  double sum = 0;
  int n = 0;
  for (int k = 0; k + step < LATTICE; k++) {
    const double s = strength[k][one], q = strength[k + step][two];
    if (s == 0 || q == 0) continue;
    sum += 12 * (exp(-pow(s, modulus)) - 0.5) * (exp(-pow(q, modulus)) - 0.5);
    n++;
  }
  return sum / sqrt(n);
}

static void weibull(void **unused) {
  static double strength[LATTICE][2], other[LATTICE][2], sorted[LATTICE_BONDS];
  for (int64_t seed = 1; seed <= 3; seed++) {
    const double modulus = seed == 1 ? 1.5 : 4.0 * (double)seed;
    memset(strength, 0, sizeof strength);
    lattice_strengths(modulus, seed, 1, false, strength);
    int n = 0;
    for (int k = 0; k < 2 * LATTICE; k++)
      if (strength[k / 2][k % 2] > 0) sorted[n++] = strength[k / 2][k % 2];
    assert_int_equal(n, LATTICE_BONDS);
    const double distance = kolmogorov(sorted, n, modulus),
                 row = neighbours(strength, modulus, 1, 0, 0),
                 column = neighbours(strength, modulus, WIDE, 1, 1),
                 corner = neighbours(strength, modulus, 0, 0, 1);
    print_message("Weibull modulus %g: distance of the distribution %.2f, correlations %.2f %.2f "
                  "%.2f errors\n",
                  modulus, distance, row, column, corner);
    SYSTEM_NEAR(distance, 0, 1.63, "distribution of the strengths");
    SYSTEM_NEAR(fmax(fabs(row), fmax(fabs(column), fabs(corner))), 0, 3.5, "correlation");
    for (int way = 0; way < 2; way++) {
      memset(other, 0, sizeof other);
      lattice_strengths(modulus, seed, way ? 1 : 3, way, other);
      assert_memory_equal(strength, other, sizeof strength);
    }
  }
}

/* --- units ------------------------------------------------------------------------------------ */

/* Units of length, mass and time, powers of two: numbers in them differ in their exponents only. */
typedef struct units {
  double length, mass, time;
} units;

/* Number of these units in which a quantity of a deck is one: a text like "force time/length^2". */
static double unit_of(const char *words, const units *u) {
  double factor = 1, power = 1;
  for (const char *word = words; *word;) {
    const size_t n = strcspn(word, " /^");
    const double one = strncmp(word, "force", n) == 0    ? u->length * u->mass / (u->time * u->time)
                       : strncmp(word, "length", n) == 0 ? u->length
                       : strncmp(word, "time", n) == 0   ? u->time
                                                         : 1;
    word += n;
    int times = 1;
    if (*word == '^') times = (int)strtol(word + 1, (char **)&word, 10);
    factor *= pow(one, power * times);
    if (*word == '/') power = -1;
    word += *word != 0;
  }
  return factor;
}

/* The law in other units, by the units that the table of keys gives. */
static law law_in(const law *l, const units *u) {
  law other = *l;
  const deck_key *key;
  for (size_t k = 0; (key = deck_key_at(&law_table, k)); k++)
    if (key->target == DECK_SETS_NUMBER)
      *(double *)((char *)&other + key->offset) *= unit_of(key->unit, u);
  return other;
}

/* Two bonded disks fly apart and turn; with dashpots, up to a break. */
static sd_simulation *torn(const law *l, const units *u, int i) {
  const couple c = {false,
                    {0.5 * u->length, 0.3 * u->length},
                    {0.9 * u->mass, 0.4 * u->mass},
                    0.0625 * u->length};
  const double v = 0.1 * u->length / u->time;
  const double velocity[2][3] = {{-0.2 * v, 0.1 * v, 0.2 / u->time},
                                 {0.1 * v, -0.15 * v, -0.1 / u->time}};
  return bonded(&c, l, (sd_integrator)i, SD_CONSERVATIVE, 2e-4 * u->time, velocity);
}

/* The same bits but for the exponents: all keys of bonds have the units that the docs say. */
static void other_units(void **unused) {
  uint64_t seed = 3;
  const units one = {1, 1, 1}, other = {8, 0.25, 2};
  size_t breaks = 0;
  for (int n = 0; n < 24; n++) {
    law l = strong_law(&seed, n % 3);
    if (n % 4 == 3) {
      l.bond_E = 2 * l.bond_k_n, l.bond_poisson = 0.25;
      l.bond_k_n = l.bond_k_t = l.bond_k_r = 0;
    }
    l.bond_gamma_n = 0.3, l.bond_gamma_t = 0.2, l.bond_gamma_r = 0.1;
    const law scaled = law_in(&l, &other);
    sd_simulation *a = torn(&l, &one, n % 2), *b = torn(&scaled, &other, n % 2);
    system_advance(a, 2000);
    system_advance(b, 2000);
    const sd_state *p = sd_simulation_state(a), *q = sd_simulation_state(b);
    const double energy = other.mass * other.length * other.length / (other.time * other.time);
    assert_int_equal(p->n_breaks, q->n_breaks);
    breaks += p->n_breaks;
    for (size_t k = 0; k < p->n_breaks; k++) {
      assert_int_equal(p->break_step[k], q->break_step[k]);
      assert_int_equal(p->break_mode[k], q->break_mode[k]);
      SYSTEM_NEAR(q->break_energy[k], energy * p->break_energy[k], 0, "energy of a broken bond");
    }
    for (uint32_t k = 0; k < 2; k++) {
      const system_body x = system_at(a, k), y = system_at(b, k);
      SYSTEM_NEAR(y.x, other.length * x.x, 0, "place");
      SYSTEM_NEAR((double)y.theta, (double)x.theta, 0, "angle");
    }
    system_end(a);
    system_end(b);
  }
  print_message("24 pairs in other units: %zu bonds break in the same steps\n", breaks);
  assert_true(breaks > 8 && breaks < 24);
}

/* --- a lattice that is torn ------------------------------------------------------------------- */

/* A lattice that flies apart from its middle. */
static text tearing(int i, int v, double factor) {
  const law l = {.k_n = 500,
                 .k_t = 300,
                 .mu = 0.4,
                 .bond_k_n = 400,
                 .bond_k_t = 200,
                 .bond_k_r = 200,
                 .bond_gap = 0.02,
                 .bond_width = 0.3,
                 .bond_tension = 20,
                 .bond_cohesion = 20,
                 .bond_friction = 0.3,
                 .bond_weibull = 3};
  text t = {0};
  bonds_deck(&t, (sd_integrator)i, (sd_variant)v, 2e-4, &l);
  text_add(&t, "disk_rows = ( { columns = (\"x\", \"y\", \"vx\", \"vy\", \"omega\"); radius = "
               "0.495; mass = 1; rows = ( ");
  for (int k = 0; k < 144; k++) {
    const double x = k % 12 - 5.5, y = k / 12 - 5.5;
    text_add(&t, "%s(%g, %g, %.17g, %.17g, 0.3)", k ? ", " : "", x, y, factor * x - 0.3 * y,
             factor * y + 0.3 * x);
  }
  text_add(&t, " ); } );\nphases = ( { steps = 1e15; bond = { sinter = true; }; } );\n");
  return t;
}

/* Any number of threads, and a run that goes on from a copy of its state, give the same bits. */
static void same_breaks(void **unused) {
  for (int mode = 0; mode < 4; mode++) {
    text t = tearing(mode % 2, mode / 2, 0.12);
    sd_model *m = model_of_text(&t);
    sd_simulation *sim = begin_run(m, 1), *threads = begin_run(m, 3), *copied = begin_run(m, 1);
    for (int k = 0; k < 8; k++) {
      advance(sim, 500);
      advance(threads, 500);
      advance(copied, 500);
      copied = go_on_from_copy(copied, k % 2 ? 1 : 2);
    }
    const sd_state *s = sd_simulation_state(sim);
    print_message("lattice: %zu breaks, %zu bonds are left\n", s->n_breaks, bonds_left(sim));
    assert_true(s->n_breaks > 50 && bonds_left(sim) > 20);
    same_states(s, sd_simulation_state(threads), "threads");
    same_states(s, sd_simulation_state(copied), "a copy");
    sd_simulation_free(threads);
    sd_simulation_free(copied);
    end_run(sim, m);
  }
}

RUN_TESTS(TEST(tension), TEST(shear_and_bending), TEST(beams_at_walls), TEST(overloads),
          TEST(weibull), TEST(same_breaks), TEST(other_units))

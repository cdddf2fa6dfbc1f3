/* ratchet_deck.js: the deck of the ratchet, and the paper's theory of its rotation. */
"use strict";

const SUPPORT_ANGLE = Math.PI / 6; /* theta_h, between vertical and support */
const MASS = 0.1;                  /* of a disk: R = m g = 1, g = 10 */
const REST = 0.5;                  /* time before the drive begins */

/* Largest of 1, 2, 5 times a power of ten that is not above 1e-5 nor 1/20 of the fastest
 * contact period over 2 pi. */
function ratchetTimeStep({ k_n: normal, k_t: tangential }) {
  const stiffness = Math.max(2 * normal, 6 * tangential);
  const most = Math.min(1.0000001e-5, 0.1 / Math.sqrt(stiffness / MASS));
  return Number(niceLength(most).toPrecision(1));
}

const decimal = (value, digits = 6) => String(Number(value.toPrecision(digits)));

function ratchetMotions(s, dt) {
  const omega = `"${decimal(2 * s.frequency)} pi"`;
  if (s.drive === "random") {
    return `  { name = "shake"; disk = [ "left", "right" ]; coordinate = [ "x", "y", "theta" ];
    type = "random"; amplitude = ${decimal(s.random)}; omega = ${omega}; damping = 0.5;
    interval = ${Math.max(1, Math.round(1e-4 / dt))}; ramp = 0.2; }`;
  }
  const motion = (side, phase) =>
    `  { name = "${side}"; disk = "${side}"; coordinate = "theta"; type = "${s.wave}";
    amplitude = ${decimal(s.amplitude)}; omega = ${omega};${phase} }`;
  const phase = s.phase === 0 ? "" : ` phase = "${decimal(s.phase / 180)} pi";`;
  return `${motion("left", "")},\n${motion("right", phase)}`;
}

/* The deck of some settings, with the start of the measured phase in steps. */
function ratchetDeck(s) {
  const dt = ratchetTimeStep(s), viscosity = 2 * s.damping * Math.sqrt(s.k_n * MASS);
  const text = `# The paper's three disks: a disk rests on two wheels that vibrate. R = m g = 1.

title = "ratchet";
seed = ${s.seed};
dt = ${dt};
gravity = { g = 10; tilt = "${decimal(s.tilt)} pi"; };

materials = (
  { name = "disk"; k_n = ${decimal(s.k_n)}; k_t = ${decimal(s.k_t)}; \
gamma_n = ${decimal(viscosity)}; mu = ${decimal(s.mu)}; }
);

disks = (
  { name = "upper"; x = 0;  y = 0;          radius = 1; mass = ${MASS}; },
  { name = "left";  x = -1; y = "-sqrt(3)"; radius = 1; mass = ${MASS}; fixed = true; },
  { name = "right"; x = 1;  y = "-sqrt(3)"; radius = 1; mass = ${MASS}; fixed = true; }
);

motions = (
${ratchetMotions(s, dt)}
);

phases = (
  { name = "rest";    time = ${REST}; motions = (); },  # the upper disk sinks in
  { name = "measure"; time = ${decimal(s.length)}; }
);

measure = {
  rotation = [ "upper" ];
  sliding = ( { disk = "upper"; partners = [ "left", "right" ]; } );
};
`;
  return { text, dt, skip: Math.round(REST / dt) };
}

/* Torque of a configuration at its equilibrium over m g R. s1, s2: signs of the torques of the
 * left and the right contact. The load of a contact acts along its normal (nx, ny) plus
 * s mu (ny, -nx). */
function configurationTorque(mu, tilt, s1, s2) {
  const direction = (angle, s) => {
    const nx = Math.sin(angle), ny = Math.cos(angle);
    return [nx + s * mu * ny, ny - s * mu * nx];
  };
  const [ax, ay] = direction(SUPPORT_ANGLE, s1), [bx, by] = direction(-SUPPORT_ANGLE, s2);
  const gx = Math.sin(tilt), gy = Math.cos(tilt), det = ax * by - ay * bx;
  const n1 = (gx * by - gy * bx) / det, n2 = (ax * gy - ay * gx) / det;
  return mu * (s1 * n1 + s2 * n2);
}

/* Mean rotation by the paper's theory, or why there is none:
 * {value, label} or {reason}. Phases 0 and 180 degrees, sliding without end. */
function ratchetTheory(s) {
  if (s.drive === "random") {
    return { reason: "Random: the paper predicts the sense (clockwise for tilt > 0), no speed." };
  }
  const phase = Math.abs(s.phase), sine = s.wave === "harmonic";
  if (phase !== 0 && phase !== 180) {
    return { reason: "The paper's formulas are for the phases 0° and 180°." };
  }
  const { mu } = s, tilt = Math.PI * s.tilt, omega = 2 * Math.PI * s.frequency, h = SUPPORT_ANGLE;
  const inertia = 0.5 * MASS, velocity = s.amplitude * omega;
  const signs = [[1, 1], [-1, -1], [1, -1], [-1, 1]];
  const torques = signs.map(([p, q]) => configurationTorque(mu, tilt, p, q));
  const strength = Math.max(...torques.map(Math.abs)) / (inertia * velocity * omega);
  const limit = !sine ? 8 / Math.PI ** 2 : phase === 0 ? 0.54 : 1;
  if (strength > limit) return { reason: "No theory: with so weak a drive contacts stick." };
  const slope = mu * Math.tan(tilt);
  if (phase === 0) {
    return sine
      ? { value: velocity * Math.sin(0.5 * Math.PI * slope), label: "(30) for a sine" }
      : { value: (4 * velocity * slope) / Math.PI, label: "(30)" };
  }
  const first = (8 * mu * (mu * mu + 1) * tilt * Math.cos(h) ** 2) /
    ((mu * mu + 1) * Math.cos(2 * h) + mu * mu - 1);
  return {
    value: (first * velocity / Math.PI) * (sine ? Math.PI ** 2 / 8 : 1),
    label: sine ? "(35), corrected, for a sine" : "(35), corrected",
  };
}

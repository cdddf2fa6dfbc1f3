/* ratchet.js: the page of the three disks: settings, configurations, rotation against theory. */
"use strict";

const turning = (s) => s.drive === "turning", random = (s) => s.drive === "random";
const ROWS = [
  { key: "tilt", label: "Tilt", hint: "of gravity", min: -0.1, max: 0.1, step: 0.005, value: 0.04,
    text: (v) => `${formatNumber(v)} π` },
  { key: "drive", label: "Drive", hint: "random: in x, y and angle", value: "turning",
    options: [["turning", "wheels turn to and fro"], ["random", "random vibration"]] },
  { key: "wave", label: "Waveform", value: "parabolic", show: turning,
    options: [["parabolic", "parabolas, as in the theory"], ["harmonic", "sine"]] },
  { key: "phase", label: "Phase", hint: "of the right wheel; 0: in phase, 180: opposite", min: -180,
    max: 180, step: 5, value: 0, show: turning, text: (v) => `${formatNumber(v)}°` },
  { key: "amplitude", label: "Amplitude", hint: "of the angle, rad", min: 1e-3, max: 0.1, log: true,
    value: 0.04, show: turning, text: (v) => `${formatNumber(v, 2)} rad` },
  { key: "random", label: "Amplitude", hint: "root mean square", min: 1e-5, max: 3e-3, log: true,
    value: 1e-4, show: random },
  { key: "frequency", label: "Frequency", min: 1, max: 50, step: 1, value: 10,
    text: (v) => `${v} / time` },
  { key: "mu", label: "Friction μ", min: 0, max: 0.5, step: 0.01, value: 0.1 },
  { key: "k_n", label: "Stiffness kₙ", min: 300, max: 1e5, log: true, value: 1e3 },
  { key: "k_t", label: "kₜ", hint: "tangential stiffness", min: 1e3, max: 1e7, log: true,
    value: 1e6 },
  { key: "damping", label: "Damping", hint: "ratio of normal contacts", min: 0.01, max: 1,
    step: 0.01, value: 0.5 },
  { key: "seed", label: "Seed", min: 1, max: 100, step: 1, value: 1, show: random },
  { key: "length", label: "Duration", hint: "the run ends after it", value: 1000,
    options: [[100, "100"], [1000, "1000"], [1e4, "10⁴"]] },
];
const PRESETS = [
  ["In phase", { drive: "turning", phase: 0, tilt: 0.04 }],
  ["Opposite", { drive: "turning", phase: 180, tilt: 0.04 }],
  ["Random", { drive: "random", tilt: 0.04 }],
  ["Level", { tilt: 0 }],
  ["Sine", { drive: "turning", wave: "harmonic", phase: 0, tilt: 0.04 }],
  ["Weak drive", { drive: "turning", amplitude: 0.001, tilt: 0.04 }],
];
const CONFIGURATIONS = ["++", "+−", "−+", "−−", "sticks", "opens"];
const MOST_POINTS = 500; /* of a curve */
const GONE = -5; /* y of a disk that has fallen off */

/* Class of two contacts; states: 0 torque > 0, 1 torque < 0, 2 stuck, 3 open. */
function classOf(first, second) {
  const most = Math.max(first, second);
  return most < 2 ? 2 * first + second : most + 2;
}

/* Omega over windows of time, running mean, error, theory. */
class RotationPlot {
  constructor(place) {
    const lines = [
      { label: "theory", color: 1 }, { label: "over a window", color: 4 },
      { label: "mean", color: 0 }, { label: "mean + error", color: 0 },
      { label: "mean − error", color: 0 },
    ];
    this.plot = new Plot(place, lines, [[], [], [], [], [], []], () => {}, 150);
    const { series, scales } = this.plot.plot;
    for (const k of [4, 5]) series[k].stroke = () => "transparent";
    series[2].stroke = () => `${plotColor(4)}90`;
    this.plot.plot.addBand({ series: [4, 5], fill: () => `${plotColor(0)}40` });
    scales.y.range = () => this.range();
    this.clear(null);
  }

  /* Ends of the axis: zero, theory, the mean with its error without the transient at the start,
   * and the windows but for the outermost tenths. */
  range() {
    const data = this.plot.data, from = Math.floor(data[0].length / 5);
    const known = [0, this.theory ?? 0];
    for (const column of data.slice(3))
      known.push(...column.slice(from).filter((value) => value !== null));
    const windows = data[2].slice(from).sort((a, b) => a - b), n = windows.length;
    if (n) known.push(windows[Math.floor(n / 10)], windows[n - 1 - Math.floor(n / 10)]);
    const low = Math.min(...known), high = Math.max(...known), margin = 0.08 * (high - low) || 0.01;
    return [low - margin, high + margin];
  }

  clear(theory, origin = [0, 0]) {
    this.theory = theory;
    this.marks = [[...origin, NaN, NaN]]; /* time, angle, mean, error */
    this.every = 1;
    this.waiting = 0;
    this.next = 0;
    this.draw();
  }

  add(samples) {
    for (const sample of samples) {
      if (!(sample[0] > this.marks[0][0])) continue;
      this.newest = sample;
      if (++this.waiting < this.every) continue;
      this.waiting = 0;
      this.marks.push(sample);
      if (this.marks.length <= MOST_POINTS) continue;
      this.marks = this.marks.filter((_, k) => k % 2 === 0);
      this.every *= 2;
    }
    const now = performance.now();
    if (samples.length === 0 || now < this.next) return;
    this.next = now + 150;
    this.draw();
  }

  draw() {
    const { marks } = this, columns = [[], [], [], [], [], []];
    for (let k = 1; k < marks.length; k++) {
      const [time, angle, mean, error] = marks[k], before = marks[k - 1];
      const know = Number.isFinite(mean) && Number.isFinite(error);
      columns[0].push(time);
      columns[1].push(this.theory);
      columns[2].push((angle - before[1]) / (time - before[0]));
      columns[3].push(Number.isFinite(mean) ? mean : null);
      columns[4].push(know ? mean + error : null);
      columns[5].push(know ? mean - error : null);
    }
    this.plot.setData(columns);
  }
}

class RatchetPage {
  constructor() {
    this.rows = ROWS;
    this.speed = 3;
    this.theory = { reason: "" };
    this.buildConfigurations();
  }

  speedUnit() {
    return 1;
  }

  deck(s) {
    const { text, dt, skip } = ratchetDeck(s), angle = Math.PI * s.tilt;
    const periods = s.drive === "random" ? 10 : 1, every = Math.round(periods / s.frequency / dt);
    return {
      text,
      options: { skip, every, sampler: "rotation", sliding: true, pull: 4, reach: 3 },
      scene: {
        bounds: [-2.15, -2.9, 2.15, 1.15], gravity: [-10 * Math.sin(angle), -10 * Math.cos(angle)],
        forceScale: 1, fade: 0.35,
      },
    };
  }

  begin(facts, made, play) {
    this.plot ??= new RotationPlot(byId("plot"));
    this.theory = ratchetTheory(play.settings.values);
    this.plot.clear(this.theory.value ?? null, [REST, 0]);
    this.first = null;
    this.mean = null;
    const values = new Float32Array(facts.disks).fill(-3e38);
    play.stage.setQuantity("signed", () => {
      values[0] = this.mean && this.mean[3] > 0 ? this.mean[2] / (4 * this.mean[3]) : 0;
      return values;
    }, () => [-1.6, 1.6]);
    this.tell();
  }

  show(message, play) {
    this.plot.add(message.samples);
    const newest = message.samples[message.samples.length - 1];
    if (newest) this.mean = newest;
    if (message.columns.y[0] < GONE && play.session.running) {
      play.stop("The disk has fallen off its wheels.", ["Restart puts it back."]);
    }
    const texts = message.rest || play.pace("texts", 120);
    this.showConfigurations(message.sliding, texts);
    if (texts) this.tell();
  }

  /* --- configurations ------------------------------------------------------------------------- */

  buildConfigurations() {
    this.chips = CONFIGURATIONS.map((name, k) => {
      const chip = element("div", undefined, { class: "configuration" }), title = element("b");
      if (k < 4) title.append("S", element("sup", name));
      else title.textContent = name;
      chip.title = [
        "both contacts drive counter-clockwise", "left counter-clockwise, right clockwise",
        "left clockwise, right counter-clockwise", "both contacts drive clockwise",
        "at least one contact sticks", "at least one contact is open",
      ][k];
      chip.share = element("span", "–");
      chip.bar = element("i");
      chip.append(title, chip.share, chip.bar);
      byId("configurations").append(chip);
      return chip;
    });
  }

  showConfigurations({ now, count }, texts) {
    const here = classOf(...now);
    if (here !== this.here) {
      this.chips[this.here]?.classList.remove("now");
      this.chips[here].classList.add("now");
      this.here = here;
    }
    if (!texts) return;
    const steps = new Array(6).fill(0);
    count.forEach((n, k) => (steps[classOf(Math.floor(k / 4), k % 4)] += n));
    const all = steps.reduce((a, b) => a + b, 0);
    this.parts = steps.map((n) => (all ? n / all : NaN));
    this.chips.forEach((chip, k) => {
      chip.share.textContent = all ? `${(100 * this.parts[k]).toFixed(1)} %` : "–";
      chip.bar.style.width = all ? `${100 * this.parts[k]}%` : "0";
    });
  }

  /* --- rotation ------------------------------------------------------------------------------- */

  tell() {
    const { theory, mean } = this, known = mean && Number.isFinite(mean[3]) && mean[3] > 0;
    const line = (color, text) => {
      const item = element("span"), mark = element("i");
      mark.style.borderColor = plotColor(color);
      item.append(mark, text);
      return item;
    };
    const digits = known ? Math.min(Math.max(0, 1 - Math.floor(Math.log10(mean[3]))), 6) : 4;
    const size = (v) => v.toFixed(digits).replace("-", "−");
    const error = known ? ` ± ${size(mean[3])}` : "";
    const found = mean && Number.isFinite(mean[2]) ? size(mean[2]) + error : "…";
    const items = [line(4, "Ω over one window"), line(0, `mean Ω = ${found}`)];
    if (theory.value !== undefined)
      items.push(line(1, `theory ${theory.label}: ${size(theory.value)}`));
    else items.push(element("span", theory.reason, { class: "quiet" }));
    byId("chart-text").replaceChildren(...items);
  }

  redraw() {
    this.plot?.plot.redraw();
    if (this.plot) this.tell();
  }
}

startPage(() => {
  const page = new RatchetPage(), play = new Play(page);
  for (const [name, values] of PRESETS) {
    const button = element("button", name, { type: "button" });
    button.addEventListener("click", () => {
      play.session.running = true;
      play.settings.set(values);
    });
    byId("presets").append(button);
  }
  play.publish(() => ({
    mean: page.mean?.[2], error: page.mean?.[3], theory: page.theory,
    configuration: CONFIGURATIONS[page.here], parts: page.parts,
    points: page.plot?.marks.length ?? 0,
  }));
  play.restart();
});

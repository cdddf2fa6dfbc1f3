/* packing.js: the page of the packings: scenes, colours, a plot, pulling of disks. */
"use strict";

const within = (...scenes) => (s) => scenes.includes(s.scene);
const ROWS = [
  { key: "scene", label: "Scene", value: "box", show: () => false,
    options: Object.entries(SCENES).map(([key, { name }]) => [key, name]) },
  { key: "count", label: "Disks", min: 60, max: 500, step: 10, value: 120 },
  { key: "mu", label: "Friction μ", min: 0, max: 1, step: 0.05, value: 0.3 },
  { key: "drive", label: "Acceleration", hint: "of the floor, its largest", min: 0.1, max: 10,
    log: true, value: 2, show: within("box"), text: (v) => `${formatNumber(v, 2)} g` },
  { key: "frequency", label: "Frequency", min: 20, max: 200, step: 5, value: 80,
    show: within("box"), text: (v) => `${v} Hz` },
  { key: "turn", label: "Drum turns", hint: "angular velocity; mean diameter and g are 1",
    min: 0.005, max: 0.3, log: true, value: 0.05, show: within("drum"),
    text: (v) => `${formatNumber(v, 2)} rad/t` },
  { key: "fraction", label: "Area fraction", min: 0.6, max: 0.84, step: 0.01, value: 0.8,
    show: within("shear") },
  { key: "rate", label: "Shear rate", min: 0.01, max: 1, log: true, value: 0.1,
    show: within("shear"), text: (v) => `${formatNumber(v, 2)} / t` },
  { key: "seed", label: "Seed", min: 1, max: 100, step: 1, value: 1 },
];
const INTRO = {
  box: "Disks rain into a box, then its floor shakes. Though nothing prefers a sense, disks " +
    "keep mean rotations of their own, blue clockwise, orange counter-clockwise: each lies " +
    "on its neighbours as the ratchet's disk on its wheels. Pull a disk through the " +
    "packing, and the pattern changes.",
  drum: "A drum turns clockwise and carries the disks up; at the surface they flow down again. " +
    "Turn it faster, and the surface bends to an S; take less friction, and the slope " +
    "sinks.",
  heap: "A column of disks falls apart on a rough floor; a heap with its angle of repose stays. " +
    "Less friction, flatter heap. Try to build a tower by hand.",
  shear: "A periodic box is compressed, then sheared at constant area: images above move to the " +
    "right. The ratio μ of shear stress and pressure tells how hard the packing is to " +
    "shear: try shear rates, and area fractions up to 0.84.",
};
const SHOWN = ["rotation", "spin", "speed", "contacts", "force", "radius"];
const MOST_POINTS = 600; /* of the curve */

/* One quantity against time, and its mean over the last half. */
class RunPlot {
  constructor(place) {
    const lines = [{ label: "value", color: 0 }, { label: "mean", color: 1 }];
    this.plot = new Plot(place, lines, [[], [], []], () => {}, 130);
    this.clear();
  }

  clear() {
    this.times = [];
    this.values = [];
    this.every = 1;
    this.sum = this.parts = this.next = 0;
    this.mean = NaN;
    this.draw();
  }

  add(samples, from) {
    for (const [time, value] of samples) {
      if (time <= from || !Number.isFinite(value)) continue;
      this.sum += value;
      if (++this.parts < this.every) continue;
      this.times.push(time);
      this.values.push(this.sum / this.parts);
      this.sum = this.parts = 0;
      if (this.times.length > MOST_POINTS) this.thin();
    }
    const now = performance.now();
    if (now < this.next) return false;
    this.next = now + 200;
    this.draw();
    return true;
  }

  thin() {
    const half = (list, join) =>
      list.filter((_, k) => k % 2 === 1).map((value, k) => join(list[2 * k], value));
    this.times = half(this.times, (a, b) => b);
    this.values = half(this.values, (a, b) => (a + b) / 2);
    this.every *= 2;
  }

  draw() {
    const n = this.values.length, first = n >> 1, late = this.values.slice(first);
    this.mean = late.length > 4 ? late.reduce((a, b) => a + b, 0) / late.length : NaN;
    const means = this.values.map((_, k) => (k >= first && late.length > 4 ? this.mean : null));
    this.plot.setData([this.times, this.values, means]);
  }
}

class PackingPage {
  constructor() {
    this.rows = ROWS;
    this.speed = 1;
    this.keys = [["c", "next colouring"]];
    this.range = [-1, 1];
    const options = SHOWN.map((key) => QUANTITIES.find((q) => q.key === key));
    for (const q of options) byId("quantity").append(element("option", q.label, { value: q.key }));
    byId("quantity").addEventListener("change", (event) => this.choose(event.target.value));
  }

  speedUnit(s) {
    return SCENES[s.scene].unit;
  }

  deck(s) {
    return SCENES[s.scene].deck(s);
  }

  begin(facts, made, play) {
    const { scene } = play.settings.values;
    this.play = play;
    this.plot ??= new RunPlot(byId("plot"));
    this.plot.clear();
    this.made = made;
    byId("intro").textContent = INTRO[scene];
    play.stage.canvas.setAttribute("aria-label", `${facts.disks} disks`);
    for (const button of byId("presets").children)
      button.setAttribute("aria-pressed", String(button.dataset.scene === scene));
    if (scene !== this.scene) this.chosen = SCENES[scene].quantity;
    this.scene = scene;
    this.from = NaN;
    this.choose(this.chosen);
    this.tell();
  }

  actions() {
    return { c: () => this.choose(SHOWN[(SHOWN.indexOf(this.chosen) + 1) % SHOWN.length]) };
  }

  /* Colours by a quantity; their range follows slowly. */
  choose(key) {
    const quantity = QUANTITIES.find((q) => q.key === key), driven = this.play.facts.driven;
    const signed = quantity.kind === "signed";
    this.chosen = key;
    this.range = null;
    byId("quantity").value = key;
    paintGradient(byId("legend-gradient"), signed ? "diverging" : "sequential");
    const unit = quantity.unit ? ` (${quantity.unit})` : "";
    byId("legend-title").textContent = `${quantity.symbol}${unit}`;
    const colours = new Float32Array(driven.length);
    const values = (model, frame) => {
      const found = quantity.values(model, frame);
      for (let k = 0; k < colours.length; k++) colours[k] = driven[k] || !found ? -3e38 : found[k];
      return colours;
    };
    const range = (frame, found) => {
      const free = found.filter((v) => v > -1e38), now = rangeOf(quantity, [free]);
      const follow = (v, before) =>
        Math.abs(v) > Math.abs(before) ? v : before + 0.03 * (v - before);
      if (this.range === null || quantity.constant) this.range = now;
      else this.range = now.slice(0, 2).map((v, k) => follow(v, this.range[k]));
      return this.range;
    };
    this.play.stage.setQuantity(quantity.kind, values, range);
  }

  show(message) {
    if (this.from !== message.head.originTime && message.head.phase > 0) {
      this.from = message.head.originTime; /* the drive begins: earlier values are of the filling */
      this.plot.clear();
      this.range = null;
    }
    const from = message.head.phase > 0 ? this.from : -1;
    if (this.plot.add(message.samples, from)) this.tell();
  }

  tell() {
    const { mean } = this.plot;
    const half = Number.isFinite(mean) ? `, mean of the last half ${formatNumber(mean, 3)}` : "";
    byId("chart-text").textContent = this.made.plot + half;
    if (!this.range) return;
    const [low, high] = this.range;
    const texts = [low, (low + high) / 2, high].map((v) => element("span", formatNumber(v, 2)));
    byId("legend-numbers").replaceChildren(...texts);
  }

  redraw() {
    this.plot?.plot.redraw();
  }
}

startPage(() => {
  const page = new PackingPage(), play = new Play(page);
  for (const [scene, { name }] of Object.entries(SCENES)) {
    const button = element("button", name, { type: "button", "data-scene": scene });
    button.addEventListener("click", () => {
      play.session.running = true;
      play.settings.set({ scene, mu: SCENES[scene].mu });
    });
    byId("presets").append(button);
  }
  play.publish(() => ({
    quantity: page.chosen, range: page.range, mean: page.plot?.mean,
    points: page.plot?.times.length ?? 0,
    disks: play.facts?.disks,
  }));
  play.restart();
});

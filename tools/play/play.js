/* play.js: what both pages have: start of a run, time, keys, theme, copying. */
"use strict";

const byId = (id) => document.getElementById(id);
const PLAY = "M4 2.5v11L13 8z", PAUSE = "M4 3h3v10H4zM9 3h3v10H9z";
const SPEED_PARTS = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, Infinity];

/* page: {rows of settings, deck(values), speedUnit, speed, begin(facts, made), show(message)}.
 * deck() returns {text, options of the worker, scene for the stage}. */
class Play {
  constructor(page) {
    this.page = page;
    this.ready = this.over = this.wanted = false;
    this.message = null;
    this.session = new Session({
      started: (facts) => this.started(facts),
      frame: (message) => this.show(message),
      failed: (message) => this.fail(message),
    });
    this.stage = new Stage(this.session);
    this.settings = new Settings(byId("settings"), page.rows, () => this.restartSoon());
    this.fillSpeeds();
    this.bind();
    this.setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  }

  /* --- runs ----------------------------------------------------------------------------------- */

  /* A slider sends many values; one run per picture is enough. */
  restartSoon() {
    if (this.wanted) return;
    this.wanted = true;
    requestAnimationFrame(() => {
      this.wanted = false;
      this.restart();
    });
  }

  restart() {
    this.made = this.page.deck(this.settings.values);
    this.over = this.ready = false;
    if (this.again) this.session.running = true;
    this.again = false;
    byId("notice").hidden = true;
    this.fillSpeeds();
    this.session.start(this.made.text, this.made.options);
  }

  started(facts) {
    this.ready = true;
    this.facts = facts;
    byId("version").textContent = facts.version;
    this.stage.begin(facts, this.made.scene);
    this.page.begin(facts, this.made, this);
    this.refresh();
  }

  show(message) {
    this.message = message;
    this.over = message.over;
    if (message.rest && this.session.running && message.over) this.session.running = false;
    this.page.show(message, this);
    this.stage.show(message);
    this.clock(message);
    if (message.hash) byId("hash").textContent = `${message.hash} at step ${message.head.step}`;
    byId("pulled").hidden = !message.pulled;
    if (message.rest) this.refresh();
  }

  clock({ head, steps, passed, rest }) {
    if (rest || this.pace("clock", 80)) {
      byId("clock").textContent = `t = ${formatNumber(Number(head.time.toFixed(6)), 5)}`;
    }
    if (!(passed > 0)) return;
    this.meter ??= { steps: 0, passed: 0, at: 0 };
    this.meter.steps += steps;
    this.meter.passed += passed;
    if (performance.now() < this.meter.at) return;
    const rate = (1000 * this.meter.steps) / this.meter.passed;
    this.rate = rate;
    byId("steps-rate").textContent = rate >= 1 ? `${formatNumber(rate, 2)} steps/s` : "";
    byId("frame-rate").textContent = `${this.stage.frameRate ?? 0} frames/s`;
    this.meter = { steps: 0, passed: 0, at: performance.now() + 500 };
  }

  /* True once in some milliseconds: texts that change in every picture cannot be read. */
  pace(name, time) {
    const now = performance.now();
    this.paces ??= {};
    if (now < (this.paces[name] ?? 0)) return false;
    this.paces[name] = now + time;
    return true;
  }

  fail({ text, start }) {
    const lines = text.split("\n").slice(0, 6);
    const title = start ? "The deck is refused." : "The run has stopped.";
    this.stop(title, lines);
  }

  /* Stops with a notice; the next change of a setting runs again. */
  stop(title, lines) {
    this.again ||= this.session.running;
    this.session.setRunning(false);
    this.refresh();
    const texts = lines.map((line) => element("p", line));
    byId("notice").replaceChildren(element("strong", title), ...texts);
    byId("notice").hidden = false;
  }

  toggle() {
    if (this.over) this.restartRunning();
    else this.session.setRunning(!this.session.running);
    this.refresh();
  }

  restartRunning() {
    this.session.running = true;
    this.restart();
  }

  step(n) {
    this.session.step(n);
    this.refresh();
  }

  refresh() {
    const { running } = this.session;
    byId("play-shape").setAttribute("d", running ? PAUSE : PLAY);
    byId("play").setAttribute("aria-label", running ? "Pause" : "Run");
    for (const name of ["forces", "marks"])
      byId(`toggle-${name}`).setAttribute("aria-pressed", String(this.stage.layers[name]));
    byId("state").textContent = this.over ? "end of the deck" : running ? "runs" : "paused";
  }

  /* --- speed ---------------------------------------------------------------------------------- */

  fillSpeeds() {
    const unit = this.page.speedUnit(this.settings.values);
    if (unit === this.speedUnit) return;
    this.speedUnit = unit;
    const options = SPEED_PARTS.map((part, k) => {
      const speed = `${formatNumber(Number((part * unit).toPrecision(3)))} per s`;
      return element("option", part === Infinity ? "as fast as possible" : speed, { value: k });
    });
    byId("speed").replaceChildren(...options);
    this.setSpeed(SPEED_PARTS.indexOf(this.page.speed));
  }

  setSpeed(k) {
    const at = Math.min(Math.max(k, 0), SPEED_PARTS.length - 1);
    byId("speed").value = String(at);
    this.session.setSpeed(SPEED_PARTS[at] * this.speedUnit);
  }

  /* --- controls ------------------------------------------------------------------------------- */

  bind() {
    const click = (id, action) => byId(id).addEventListener("click", action);
    click("play", () => this.toggle());
    click("step", () => this.step(1));
    click("again", () => this.restartRunning());
    click("fit", () => this.stage.fit());
    click("zoom-in", () => this.stage.zoom(1.4));
    click("zoom-out", () => this.stage.zoom(1 / 1.4));
    const other = { light: "dark", dark: "light" };
    click("theme", () => this.setTheme(other[document.documentElement.dataset.theme]));
    click("help", () => byId("help-dialog").showModal());
    click("about", () => byId("about-dialog").showModal());
    click("copy-deck", () => this.copy(this.made.text, "deck"));
    click("copy-link", () => this.copy(this.link(), "link"));
    for (const name of ["forces", "marks"]) click(`toggle-${name}`, () => this.toggleLayer(name));
    byId("speed").addEventListener("change", (event) => this.setSpeed(Number(event.target.value)));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) =>
      this.setTheme(event.matches ? "dark" : "light"));
    addEventListener("keydown", (event) => this.key(event));
    for (const [keys, meaning] of [...KEYS, ...(this.page.keys ?? [])]) {
      const row = element("tr"), cell = element("td");
      for (const key of keys.split(" ")) cell.append(element("kbd", key), " ");
      row.append(cell, element("td", meaning));
      byId("help-keys").append(row);
    }
  }

  toggleLayer(name) {
    this.stage.toggle(name);
    this.refresh();
  }

  key(event) {
    const { target, key } = event;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (document.querySelector("dialog[open]")) return;
    if (target.matches?.("select")) return;
    if (target.matches?.("button, summary, a") && (key === " " || key === "Enter")) return;
    const speed = Number(byId("speed").value);
    const actions = {
      " ": () => this.toggle(), ".": () => this.step(1), ":": () => this.step(1000),
      r: () => this.restartRunning(),
      "[": () => this.setSpeed(speed - 1), "]": () => this.setSpeed(speed + 1),
      "+": () => this.stage.zoom(1.4), "=": () => this.stage.zoom(1.4),
      "-": () => this.stage.zoom(1 / 1.4),
      f: () => this.stage.fit(),
      n: () => this.toggleLayer("forces"), m: () => this.toggleLayer("marks"),
      d: () => byId("theme").click(), "?": () => byId("help").click(), ...this.page.actions?.(this),
    };
    if (!actions[key]) return;
    event.preventDefault();
    actions[key]();
  }

  setTheme(theme) {
    showTheme(theme, this.stage.renderer);
    this.page.redraw?.();
    this.stage.draw();
  }

  link() {
    const address = this.settings.address();
    return location.href.replace(/#.*$/, "") + (address ? `#${address}` : "");
  }

  /* Puts a text on the clipboard; where that is refused, shows it to be copied by hand. */
  async copy(text, what) {
    try {
      await navigator.clipboard.writeText(text);
      byId("copied").textContent = `${what} copied`;
    } catch {
      byId("copied").textContent = "";
      byId("text").value = text;
      byId("text-dialog").showModal();
      byId("text").select();
    }
    clearTimeout(this.forget);
    this.forget = setTimeout(() => (byId("copied").textContent = ""), 4000);
  }

  /* State of the page for tests and for the curious. */
  publish(more) {
    const state = () => ({
      ready: this.ready, running: this.session.running, over: this.over,
      rest: this.message?.rest ?? false, number: this.session.number,
      step: this.message?.head.step ?? -1,
      time: this.message?.head.time, phase: this.message?.head.phase, frames: this.stage.drawn,
      frameRate: this.stage.frameRate, paintCost: this.stage.cost, stepsRate: this.rate,
      capacity: this.message?.capacity, values: { ...this.settings.values }, deck: this.made?.text,
      link: this.link(), grabbed: this.stage.grabbed, pulled: this.message?.pulled ?? false,
      theme: document.documentElement.dataset.theme, layers: { ...this.stage.layers }, ...more?.(),
    });
    window.slipdisk = Object.freeze({
      get state() { return state(); },
      until: (step) => this.session.until(step),
      column: (name, k) => this.stage.frame?.at(name, k),
      screen: (k) => this.stage.screen(k),
      set: (values) => this.settings.set(values),
    });
  }
}

const KEYS = [
  ["space", "run or pause"], [". :", "one step, a thousand"], ["[ ]", "slower, faster"],
  ["r", "from the start"], ["+ −", "zoom"], ["f", "fit"], ["n", "contact forces"],
  ["m", "angle marks"], ["d", "light or dark"], ["?", "this list"],
];

/* Starts a page, or says why it cannot. */
function startPage(make) {
  addEventListener("DOMContentLoaded", () => {
    try {
      make();
    } catch (error) {
      const title = element("strong", "The page does not start.");
      byId("notice").replaceChildren(title, element("p", error.message));
      byId("notice").hidden = false;
      throw error;
    }
  });
}

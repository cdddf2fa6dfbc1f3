/* viewer.js: holds the state of the page and keeps picture, numbers and plots in step. */
"use strict";

const SAMPLES = 24;       /* frames at most from which ranges are found */
const OVERLAP_LIMIT = 1e-3; /* overlap over radius from which it is marked */

class Viewer {
  constructor(meta, fixed, store, series, renderer) {
    this.meta = meta;
    this.store = store;
    this.model = new Model(meta, fixed);
    this.renderer = renderer;
    this.scene = new Scene(this.model, renderer);
    this.camera = new Camera();
    this.frame = null;
    this.samples = [];
    this.selected = -1;
    this.following = false;
    this.theme = "light";
    this.layers = {
      forces: false, overlaps: meta.kind === "deck", marks: true, copies: true,
      thickness: 1, forceScale: 1, overlapLimit: OVERLAP_LIMIT, selected: -1, highlighted: [],
    };
    this.quantities = quantitiesOf(this.model);
    this.quantity = this.quantities[0];
    this.rangeMode = "all";
    this.range = [-1, 1];
    this.drawn = 0;
    this.player = new Player(store, (k, frame) => this.show(frame), () => this.controls?.refresh());
    const jump = (t) => {
      this.player.stop();
      this.player.go(store.nearest(t));
    };
    const place = (id) => document.getElementById(id);
    this.panel = new DiskPanel({
      empty: place("disk-empty"), filled: place("disk-filled"), name: place("disk-name"), numbers: place("disk-numbers"),
      contacts: place("disk-contacts"), series: place("disk-series"),
    }, this.model, store, (k) => this.select(k), jump);
    this.plots = new SeriesPlots(place("plots"), meta, series, jump);
    this.controls = new Controls(this);
  }

  /* --- time ------------------------------------------------------------------------------------ */

  show(frame) {
    const first = this.frame === null;
    this.frame = frame;
    if (first) this.fit();
    this.takeValues();
    this.contentChanged = true;
    if (this.following && this.selected >= 0) this.center(this.selected);
    this.panel.setTime(frame.head.time);
    this.panel.update(frame);
    this.plots.setTime(frame.head.time);
    this.draw();
  }

  /* --- colours --------------------------------------------------------------------------------- */

  /* The quantity of all disks, for the picture; grey where there is none. */
  takeValues() {
    const q = this.quantity, values = q.values(this.model, this.frame);
    this.missing = values === null;
    this.values = new Float32Array(this.model.disks);
    for (let k = 0; k < this.values.length; k++) {
      const value = values ? values[k] : NaN;
      this.values[k] = Number.isFinite(value) && !(q.kind === "names" && value < 0) ? value : -3e38;
    }
    this.contentChanged = true;
    if (this.rangeMode === "frame") this.setRange(rangeOf(q, [values]));
  }

  setQuantity(key) {
    const found = this.quantities.find((q) => q.key === key);
    if (!found) return;
    this.quantity = found;
    this.renderer.palette({ signed: "diverging", names: "categorical" }[found.kind] || "sequential");
    if (found.kind === "names") this.range = [0, 255];
    else if (this.rangeMode === "manual") this.rangeMode = "all";
    this.refreshRange();
    if (this.frame) this.takeValues();
    this.controls.refresh();
    this.draw();
  }

  setRange(range) {
    this.range = this.quantity.kind === "names" ? [0, 255] : range;
    this.clipped = range[2];
    this.controls?.refreshLegend();
  }

  setRangeMode(mode) {
    this.rangeMode = mode;
    this.refreshRange();
    if (this.frame) this.takeValues();
    this.controls.refresh();
    this.draw();
  }

  refreshRange() {
    if (this.rangeMode !== "all") return;
    const known = this.samples.length ? this.samples : this.frame ? [this.frame] : [];
    this.setRange(rangeOf(this.quantity, known.map((frame) => this.quantity.values(this.model, frame))));
    const forces = known.map((frame) => frame.get("contact_force")).filter(Boolean);
    const strong = rangeOf({ kind: "magnitude" }, forces)[1];
    if (forces.length && strong > 0) this.layers.forceScale = strong;
  }

  /* Looks at some frames all over the run, so that colours mean the same in all of them. */
  async sample() {
    const n = this.store.end - this.store.first;
    const most = Math.min(SAMPLES, n, Math.max(4, Math.floor(5e5 / Math.max(1, this.model.disks))));
    const found = [];
    for (let k = 0; k < most; k++) {
      found.push(await this.store.visit(this.store.first + Math.round((k * (n - 1)) / Math.max(1, most - 1))));
      await new Promise((resolve) => setTimeout(resolve));
    }
    this.samples = found;
    if (this.quantity.key === "spin" && found.every((frame) => frame.get("spin")?.every((v) => v === 0))) this.setQuantity("speed");
    this.refreshRange();
    this.takeValues();
    if (this.untouched) this.fit();
    this.contentChanged = true;
    this.controls.refresh();
    this.draw();
  }

  setTheme(theme) {
    this.theme = theme;
    showTheme(theme, this.renderer);
    this.contentChanged = true;
    this.plots.redraw();
    this.panel.redraw();
    this.draw();
  }

  setLayer(name, value) {
    this.layers[name] = value;
    this.contentChanged = true;
    this.controls.refresh();
    this.draw();
  }

  /* --- disks ----------------------------------------------------------------------------------- */

  select(k) {
    if (k < 0) this.following = false;
    this.selected = this.layers.selected = k;
    this.panel.choose(k);
    this.panel.update(this.frame);
    this.contentChanged = true;
    if (k >= 0) document.getElementById("disk").open = true;
    if (this.following) this.center(k);
    this.controls.refresh();
    this.draw();
  }

  pick(px, py) {
    if (!this.frame) return -1;
    const [x, y] = this.camera.toWorld(px, py);
    return this.scene.pick(this.frame, x, y, 4 / this.camera.zoom);
  }

  center(k) {
    this.camera.x = this.frame.at("x", k);
    this.camera.y = this.frame.at("y", k);
  }

  follow(on) {
    this.following = on && this.selected >= 0;
    if (this.following) this.center(this.selected);
    this.controls.refresh();
    this.draw();
  }

  /* Shows some disks, with some of their neighbours, in the frame that is wanted. */
  async goTo(disks) {
    await this.player.arriving;
    if (!this.frame || disks.length === 0) return;
    const box = [Infinity, Infinity, -Infinity, -Infinity], radius = this.model.column("radius");
    for (const k of disks) {
      const x = this.frame.at("x", k), y = this.frame.at("y", k), r = 4 * radius[k];
      box[0] = Math.min(box[0], x - r);
      box[1] = Math.min(box[1], y - r);
      box[2] = Math.max(box[2], x + r);
      box[3] = Math.max(box[3], y + r);
    }
    this.camera.fit(box);
    this.untouched = false;
    this.draw();
  }

  showMessage(disks) {
    this.layers.highlighted = disks;
    this.select(disks[0]);
    this.goTo(disks);
  }

  /* Without what is far away; asked once more, with it. */
  fitNext() {
    this.whole = this.untouched && !this.whole;
    this.fit();
  }

  fit() {
    if (!this.frame) return;
    this.following = false;
    const low = this.camera.height < 420;
    this.untouched = true;
    this.camera.fit(this.scene.view(this.samples.length ? this.samples : [this.frame], this.whole), low ? [16, 16, 52, 60] : [20, 20, 52, 64]);
    this.controls?.refresh();
    this.draw();
  }

  /* --- drawing --------------------------------------------------------------------------------- */

  resize(width, height, ratio) {
    const { camera } = this, fresh = camera.width === 1;
    Object.assign(camera, { width, height, ratio });
    this.renderer.canvas.width = Math.max(1, Math.round(width * ratio));
    this.renderer.canvas.height = Math.max(1, Math.round(height * ratio));
    if (fresh || this.untouched) this.fit();
    this.paint();
  }

  draw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => this.paint());
  }

  paint() {
    this.asked = false;
    const { frame, camera, renderer, scene, layers } = this, theme = THEMES[this.theme];
    if (frame) {
      scene.buildFixed(frame, camera, theme);
      if (this.contentChanged) {
        scene.buildDisks(frame, this.values, layers.copies);
        scene.buildContacts(frame, layers, theme);
      }
      this.contentChanged = false;
    }
    const unit = layers.thickness * Math.min(0.5 * this.model.meanRadius * camera.zoom, 14);
    const look = { ...theme, unit, range: this.range, marks: layers.marks, fade: layers.forces ? 0.5 : 0 };
    renderer.draw(camera, look);
    this.drawn++;
    this.controls.refreshScale();
  }
}

/* --- start --------------------------------------------------------------------------------------- */

function notice(title, ...lines) {
  const box = document.getElementById("notice");
  box.replaceChildren(element("strong", title), ...lines.map((line) => element("p", line)));
  box.hidden = false;
}

/* Numbers of the page's state for tests and for the curious; changes nothing. */
function publish(viewer) {
  const shot = () => ({
    ready: true, kind: viewer.meta.kind, frame: viewer.player.index, first: viewer.store.first, frames: viewer.store.end,
    time: viewer.frame?.head.time, playing: viewer.player.playing, rate: viewer.player.rate, drawnRate: viewer.player.drawnRate,
    selected: viewer.selected, following: viewer.following, quantity: viewer.quantity.key, range: [...viewer.range],
    rangeMode: viewer.rangeMode, theme: viewer.theme, zoom: viewer.camera.zoom, center: [viewer.camera.x, viewer.camera.y],
    layers: { ...viewer.layers }, drawn: viewer.drawn, cachedBytes: viewer.store.bytes instanceof Function ? viewer.store.bytes() : viewer.store.bytes,
    plots: viewer.plots.open.length, plotTime: viewer.plots.time, sampled: viewer.samples.length, rows: viewer.plots.rows,
  });
  const screen = (k) => viewer.camera.toScreen(viewer.frame.at("x", k), viewer.frame.at("y", k));
  const axes = () => [...viewer.plots.open, ...viewer.panel.plots].map(({ plot }) => [plot.scales.y.min, plot.scales.y.max]);
  window.slipdisk = Object.freeze({ get state() { return shot(); }, get axes() { return axes(); }, screen, column: (name, k) => viewer.frame.at(name, k) });
}

/* A deck: overlaps, or sizes and groups when there are none. */
function showStart(viewer) {
  const overlaps = viewer.scene.overlaps(viewer.frame, OVERLAP_LIMIT), has = (key) => viewer.quantities.some((q) => q.key === key);
  fillOverlaps(byId("overlap-list"), overlaps, viewer.model, (disks) => viewer.showMessage(disks));
  byId("overlaps").hidden = overlaps.length === 0;
  viewer.setQuantity(overlaps.length > 0 ? "overlap" : ["group", "material", "radius"].find(has));
}

async function startLive(viewer, store) {
  const controls = viewer.controls;
  viewer.newest = true;
  const fresh = async () => {
    if (viewer.frame === null) viewer.model.firstTime = store.time(store.first);
    byId("notice").hidden = true;
    if (viewer.newest) await viewer.player.go(store.end - 1);
    const n = store.frames.length;
    if (n === 1 || n % 20 === 0) {
      viewer.samples = [0, 0.25, 0.5, 0.75, 1].map((part) => store.frames[Math.floor(part * (n - 1))]);
      viewer.refreshRange();
      viewer.contentChanged = true;
    }
    controls.refresh();
  };
  await store.follow(fresh, (rows) => viewer.plots.append(rows), (state) => controls.setState(state));
}

async function start() {
  const text = document.getElementById("slipdisk-meta")?.textContent;
  if (!text) return notice("There are no data in this page.", "`slipdisk view FILE` makes pages with data.");
  const meta = JSON.parse(text), live = meta.kind === "live";
  if (!("DecompressionStream" in window)) return notice("This browser is too old for this page.", "It needs DecompressionStream: Chrome 80, Firefox 113, Safari 16.4 or newer.");
  let renderer;
  try {
    renderer = new Renderer(document.getElementById("canvas"));
  } catch (error) {
    return notice("The disks cannot be drawn.", error.message, "Another browser may, or this one with hardware acceleration switched on.");
  }
  if (live) setTimeout(() => {
    if (byId("notice").hidden && !(window.slipdisk?.state.frame >= 0)) notice("Waiting for the run.", "Its first frame has not come yet.");
  }, 500);
  const source = live ? null : new PageSource(document);
  const store = live ? new LiveStore() : new PageStore(source);
  const fixed = await (source ?? store).one("static");
  const series = live ? null : await source.one("series");
  const theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
  document.documentElement.dataset.theme = theme;
  const viewer = new Viewer(meta, fixed, store, series, renderer);
  viewer.setTheme(theme);
  viewer.setQuantity(viewer.quantity.key);
  viewer.controls.observe();
  if (live) startLive(viewer, store);
  if (!live && store.end === 0)
    notice("No frames are stored in this result.", "Give `frames` (steps between frames) in `output` or in a phase of the deck, and run it again:",
      "output = { frames = 1000; contacts = 1000; };", "Series of numbers, when there are any, are plotted beside this.");
  if (!live && store.end > 0) {
    viewer.model.firstTime = store.time(0);
    await viewer.player.go(0);
    if (meta.kind === "deck") showStart(viewer);
    await viewer.sample();
  }
  publish(viewer);
}

addEventListener("DOMContentLoaded", () => {
  start().catch((error) => {
    notice("This page cannot show its data.", String(error.message || error));
    throw error;
  });
});

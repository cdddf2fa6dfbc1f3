/* plots.js: time series as plots, with a line at the time that is shown. */
"use strict";

const PLOT_COLORS = {
  light: ["#0072b2", "#d55e00", "#009e73", "#b5588c", "#3d9bd1", "#b97f00", "#7a7a00", "#6f6f6f"],
  dark: ["#4aa3df", "#f08a4b", "#35c39a", "#e0a0c4", "#8fd0f5", "#f2bb4a", "#cfcf4a", "#aaaaaa"],
};
const PLOT_DASHES = [[], [6, 3], [2, 3]];

function cssColor(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

function plotColor(k) {
  const colors = PLOT_COLORS[document.documentElement.dataset.theme] || PLOT_COLORS.light;
  return colors[k % colors.length];
}

/* One plot: lines [{label, unit, title}], data [times, values...]; jump(t) when it is clicked. least: values and changes up to
 * this size are rounding. */
class Plot {
  constructor(parent, lines, data, jump, height = 150, least = 0) {
    this.parent = parent;
    this.data = data;
    this.colors = lines.map((line, k) => line.color ?? k);
    this.marker = document.createElement("div");
    this.marker.className = "plot-now";
    const grid = { stroke: () => cssColor("--grid"), width: 1 };
    const axis = { stroke: () => cssColor("--quiet"), grid, ticks: grid, font: "11px system-ui, sans-serif" };
    const options = {
      width: Math.max(parent.clientWidth, 120),
      height,
      legend: { live: true },
      cursor: { drag: { x: true, y: false }, points: { size: 6 } },
      scales: { x: { time: false }, y: { range: (u, low, high) => Plot.range(low, high, least) } },
      axes: [
        { ...axis, space: 70, size: 26, values: Plot.ticks },
        { ...axis, space: 28, size: Plot.axisWidth, values: Plot.ticks },
      ],
      series: [{ label: "t", value: (u, v) => formatNumber(v) }, ...lines.map((line, k) => Plot.line(line, k))],
      hooks: { draw: [() => this.place()], setSize: [() => this.place()] },
    };
    this.plot = new uPlot(options, data, parent);
    this.plot.ctx.canvas.setAttribute("role", "img");
    this.plot.ctx.canvas.setAttribute("aria-label", `${lines.map((line) => line.label).join(", ")} against time`);
    this.plot.over.append(this.marker);
    this.plot.over.addEventListener("click", (event) => {
      const box = this.plot.over.getBoundingClientRect();
      if (this.plot.select.width < 3) jump(this.plot.posToVal(event.clientX - box.left, "x"));
    });
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(parent);
    this.plot.over.addEventListener("mouseleave", () => this.time !== undefined && setTimeout(() => this.tell()));
  }

  /* Labels with the digits that tell them apart; a tick that is 0 but for rounding is "0". step: distance of ticks. */
  static ticks(u, values, axis, space, step) {
    const largest = Math.max(...values.map(Math.abs)), digits = Math.ceil(Math.log10(largest / step)) + 1;
    return values.map((v) => (v === null ? "" : formatNumber(Math.abs(v) < 1e-6 * step ? 0 : v, Math.min(Math.max(digits, 4), 15) || 4)));
  }

  /* Ends of the axis. A line that changes by rounding alone is flat, and lies in the middle. */
  static range(low, high, least) {
    if (low === null || low === undefined) return [0, 1];
    const size = Math.max(Math.abs(low), Math.abs(high)), middle = (low + high) / 2;
    if (high - low > Math.max(1e-9 * size, least)) return uPlot.rangeNum(low, high, 0.1, true);
    return size > least ? [middle - size / 2, middle + size / 2] : [-1, 1];
  }

  /* Room for ticks and the widest label; pixels. */
  static axisWidth(u, labels, k) {
    const { ctx } = u, { font, gap, ticks } = u.axes[k];
    ctx.save();
    ctx.font = font[0];
    const widest = Math.max(0, ...(labels || []).map((label) => ctx.measureText(label).width));
    ctx.restore();
    return Math.max(50, Math.ceil(ticks.size + gap + widest / uPlot.pxRatio) + 3);
  }

  static line(line, k) {
    return {
      label: line.label,
      stroke: () => plotColor(line.color ?? k),
      dash: PLOT_DASHES[Math.floor(k / 8) % PLOT_DASHES.length],
      width: 1.5,
      points: { show: false },
      value: (u, v) => formatNumber(v, 5),
    };
  }

  resize() {
    const width = this.parent.clientWidth;
    if (width > 0 && width !== this.plot.width) this.plot.setSize({ width, height: this.plot.height });
  }

  setData(data) {
    this.data = data;
    this.plot.setData(data);
  }

  /* Moves the line, and tells the values there. */
  setTime(t) {
    this.time = t;
    this.place();
  }

  tell() {
    const times = this.data[0];
    if (!this.plot || times.length === 0 || this.plot.over.matches(":hover")) return;
    this.plot.setLegend({ idx: nearestIndex(times, this.time) }, false);
  }

  place() {
    if (this.time === undefined || !this.plot) return;
    const left = this.plot.valToPos(this.time, "x");
    const inside = left >= -1 && left <= this.plot.over.clientWidth + 1;
    this.marker.style.display = inside ? "block" : "none";
    this.marker.style.transform = `translateX(${left}px)`;
    queueMicrotask(() => this.tell()); /* drawing ends with the cursor, which empties the legend */
  }

  /* After a change of theme. */
  redraw() {
    this.plot.root.querySelectorAll(".u-series:not(:first-child) .u-marker").forEach((marker, k) => {
      marker.style.borderColor = plotColor(this.colors[k]);
    });
    this.plot.redraw(false, true);
  }

  destroy() {
    this.observer.disconnect();
    this.plot.destroy();
    this.plot = null;
  }
}

/* Which series go into one plot: [{title, names}]; energies by their part in the budget, others by quantity. */
function plotGroups(meta) {
  const series = meta.series || [], budget = meta.budget || {}, groups = new Map();
  const put = (title, s) => groups.set(title, [...(groups.get(title) || []), s]);
  const stored = new Set(budget.stored), moved = new Set([...(budget.supplied || []), ...(budget.lost || [])]);
  for (const s of series) {
    const base = s.name.replace(/\[.*\]$/, "");
    if (s.section !== "energy") put(seriesTitle(s, base), s);
    else if (stored.has(s.name)) put("Energy stored", s);
    else if (moved.has(s.name)) put("Work and losses", s);
    else if (s.name === budget.residual) put("Residual of the energy budget", s);
  }
  return [...groups].map(([title, list]) => ({ title, series: list }));
}

const SERIES_FAMILIES = [
  [/^(sliding_)?contacts$/, "Contacts"], [/^stress_/, "Stress"], [/^kinetic_[xy]/, "Kinetic stress"],
  [/^(width|height)$/, "Size of the region"],
];

function seriesTitle(series, base) {
  const family = SERIES_FAMILIES.find(([pattern]) => pattern.test(base));
  if (family) return family[1];
  const words = base.replaceAll("_", " ");
  return words[0].toUpperCase() + words.slice(1);
}

function seriesLabel(series) {
  return series.section === "energy" && series.name === "start" ? "brought by disks" : series.name.replaceAll("_", " ");
}

/* The plots of the side panel. Closed ones are made when they are opened. */
class SeriesPlots {
  constructor(parent, meta, chunk, jump) {
    Object.assign(this, { parent, meta, jump });
    this.columns = new Map();
    this.open = [];
    for (const name of ["time", ...(meta.series || []).map((s) => s.name)])
      this.columns.set(name, chunk?.get(name) || new Float64Array(0));
    plotGroups(meta).forEach((group, k) => this.addGroup(group, k < 3));
  }

  get rows() {
    return this.columns.get("time").length;
  }

  addGroup(group, open) {
    const shown = group.series.filter((s) => this.meta.kind === "live" || this.valuesOf(s).some((v) => v !== 0));
    if (shown.length === 0) return;
    const unit = shown[0].unit && shown[0].unit !== "1" ? ` (${shown[0].unit})` : "";
    const details = document.createElement("details"), summary = document.createElement("summary");
    const place = document.createElement("div");
    details.className = "plot";
    summary.textContent = group.title + unit;
    summary.title = shown.map((s) => `${s.name}: ${s.description}`).join("\n");
    details.append(summary, place);
    details.addEventListener("toggle", () => {
      if (details.open) this.make(place, shown);
    });
    this.parent.append(details);
    details.open = open;
  }

  make(place, shown) {
    if (place.plot) return;
    const prefix = shown.length > 1 && shown.every((s) => s.name.includes("["));
    const lines = shown.map((s) => ({ label: prefix ? s.name.replace(/^.*\[(.*)\]$/, "$1") : seriesLabel(s) }));
    place.plot = new Plot(place, lines, this.dataOf(shown), this.jump, 150, shown[0].section === "energy" ? this.rounding() : 0);
    place.plot.shown = shown;
    this.open.push(place.plot);
    if (this.time !== undefined) place.plot.setTime(this.time);
  }

  /* Rounding of the energies, 1e-14 of the largest. */
  rounding() {
    let largest = 0;
    for (const s of this.meta.series.filter(({ section }) => section === "energy"))
      for (const v of this.columns.get(s.name)) if (Math.abs(v) > largest) largest = Math.abs(v);
    return 1e-14 * largest;
  }

  /* The energy at step 0 counts by its changes since then: disks that came or went. */
  valuesOf(s) {
    const values = this.columns.get(s.name);
    return s.section === "energy" && s.name === "start" ? values.map((v) => v - values[0]) : values;
  }

  dataOf(shown) {
    return [this.columns.get("time"), ...shown.map((s) => this.valuesOf(s))];
  }

  /* More rows of a running simulation. */
  append(chunk) {
    const kept = Math.min(chunk.head.from ?? this.rows, this.rows);
    for (const [name, all] of this.columns) {
      const old = all.subarray(0, kept);
      const more = chunk.get(name) || new Float64Array(chunk.get("time").length).fill(NaN);
      const values = new Float64Array(old.length + more.length);
      values.set(old);
      values.set(more, old.length);
      this.columns.set(name, values);
    }
    for (const plot of this.open) plot.setData(this.dataOf(plot.shown));
    this.setTime(this.time);
  }

  setTime(t) {
    this.time = t;
    for (const plot of this.open) plot.setTime(t);
  }

  redraw() {
    for (const plot of this.open) plot.redraw();
  }
}

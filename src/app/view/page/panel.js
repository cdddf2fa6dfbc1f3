/* panel.js: numbers of one disk, its contacts, its own series; messages; numbers of the run. */
"use strict";

function element(tag, text, attributes = {}) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

function tableRow(cells, tag = "td") {
  const row = element("tr");
  cells.forEach((cell, k) => {
    if (cell instanceof Node) {
      const place = element("td");
      place.append(cell);
      row.append(place);
    } else {
      row.append(element(k === 0 && tag === "td" ? "th" : tag, cell, k === 0 && tag === "td" ? { scope: "row" } : {}));
    }
  });
  return row;
}

const OWN_SERIES = [
  { name: "turned", label: "angle turned (rad)", rounding: () => 1e-9 },
  { name: "spin", label: "spin (rad/time)" },
  { name: "y", label: "y (length)", rounding: (radius) => 1e-6 * radius }, /* that of single precision */
];

class DiskPanel {
  /* select(k) picks another disk; jump(t) goes to a time. */
  constructor(places, model, store, select, jump) {
    Object.assign(this, { places, model, store, select, jump });
    this.disk = -1;
    this.plots = [];
    this.gathering = 0;
  }

  choose(k) {
    this.disk = k;
    this.places.empty.hidden = k >= 0;
    this.places.filled.hidden = k < 0;
    this.gathering++;
    for (const plot of this.plots) plot.destroy();
    this.plots = [];
    this.places.series.replaceChildren();
    if (k >= 0 && this.store.end - this.store.first > 1) this.gather(k, this.gathering);
  }

  /* Values of the frame that is shown. */
  update(frame) {
    const k = this.disk;
    if (k < 0 || !frame) return;
    const model = this.model, at = (name) => frame.at(name, k), fixed = (name) => model.column(name)?.[k];
    const angle = (fixed("angle") ?? 0) + (frame.has("turned") ? at("turned") : 0);
    const pair = (a, b) => `${formatNumber(a)}, ${formatNumber(b)}`;
    const rows = [
      ["number", String(k)],
      ["position x, y", pair(at("x"), at("y"))],
      ["velocity", pair(at("vx"), at("vy"))],
      ["angle", formatNumber(angle)],
      ["spin ω", formatNumber(at("spin"))],
      ["radius", formatNumber(fixed("radius"))],
      ["mass", formatNumber(fixed("mass"))],
    ];
    if (model.groupNames.length) rows.push(["group", model.groupNames[fixed("group")] ?? "none"]);
    if (model.materialNames.length) rows.push(["material", model.materialNames[fixed("material")] ?? "none"]);
    if (fixed("driven")) rows.push(["motion", "prescribed"]);
    if (frame.has("activity")) rows.push(["state", ["in play", "waiting", "removed", "outside", "held"][at("activity")]]);
    if (model.column("omega")) rows.push(["measured Ω", `${formatNumber(fixed("omega"))} ± ${formatNumber(fixed("omega_error"), 2)}`]);
    this.places.name.textContent = model.bodyName(k);
    this.places.numbers.replaceChildren(...rows.map((row) => tableRow(row)));
    this.showContacts(frame, k);
    for (const plot of this.plots) plot.setTime(frame.head.time);
  }

  showContacts(frame, disk) {
    const a = frame.get("contact_a"), b = frame.get("contact_b"), { contacts } = this.places;
    if (!a) {
      contacts.replaceChildren(element("p", "This frame has no table of contacts (key contacts of the phase in the deck).", { class: "quiet" }));
      return;
    }
    const table = element("table"), known = this.model.meta.kind !== "deck";
    const heads = known ? ["contact with", "Fₙ", "τ", "overlap", ""] : ["contact with", "overlap"];
    table.append(tableRow(heads, "th"));
    for (let k = 0; k < a.length; k++) {
      if (a[k] !== disk && b[k] !== disk) continue;
      const other = a[k] === disk ? b[k] : a[k];
      const name = other < this.model.disks ? element("button", this.model.bodyName(other), { class: "link", type: "button" }) : element("span", this.model.bodyName(other));
      if (other < this.model.disks) name.addEventListener("click", () => this.select(other));
      const number = (column) => formatNumber(frame.at(column, k), 4);
      const slides = frame.at("contact_sliding", k) !== 0;
      table.append(tableRow(known ? [name, number("contact_force"), number("contact_tau"), number("contact_overlap"), slides ? "slides" : "sticks"]
        : [name, number("contact_overlap")]));
    }
    if (table.rows.length === 1) contacts.replaceChildren(element("p", "No contacts.", { class: "quiet" }));
    else contacts.replaceChildren(table);
  }

  /* Reads the disk's values in all frames, a few at a time. */
  async gather(disk, ticket) {
    const { store } = this, n = store.end - store.first, stride = Math.max(1, Math.ceil(n / 1000));
    const times = [], values = OWN_SERIES.map(() => []);
    let shown = performance.now();
    for (let k = store.first; k < store.end; k += stride) {
      const frame = await store.visit(k);
      if (this.gathering !== ticket) return;
      times.push(frame.head.time);
      OWN_SERIES.forEach((s, c) => values[c].push(frame.at(s.name, disk)));
      if (performance.now() - shown < 250 && k + stride < store.end) continue;
      this.showSeries(times, values);
      await new Promise((resolve) => setTimeout(resolve));
      if (this.gathering !== ticket) return;
      shown = performance.now();
    }
  }

  showSeries(times, values) {
    OWN_SERIES.forEach((s, c) => {
      if (this.plots[c]) {
        this.plots[c].setData([times, values[c]]);
        return;
      }
      const place = element("div", undefined, { class: "own-plot" });
      this.places.series.append(place);
      this.plots[c] = new Plot(place, [{ label: s.label, color: c }], [times, values[c]], this.jump, 110,
        s.rounding?.(this.model.column("radius")?.[this.disk]));
    });
    for (const plot of this.plots) plot.setTime(this.time ?? times[0]);
  }

  setTime(t) {
    this.time = t;
  }

  redraw() {
    for (const plot of this.plots) plot.redraw();
  }
}

/* Mistakes and warnings of a deck; show(disks) zooms to those that one names. */
function fillMessages(list, messages, show) {
  for (const message of messages) {
    const item = element("li", undefined, { class: message.level });
    const named = message.disks?.length > 0;
    const text = element(named ? "button" : "span", message.text, named ? { type: "button", class: "link" } : {});
    if (named) text.addEventListener("click", () => show(message.disks));
    item.append(element("strong", message.level[0].toUpperCase() + message.level.slice(1)), " ", text);
    list.append(item);
  }
}

/* Overlaps at the start of a deck, the deepest ones. */
function fillOverlaps(list, overlaps, model, show) {
  for (const { a, b, overlap, part } of overlaps.slice(0, 100)) {
    const item = element("li"), names = `${model.bodyName(a)} and ${model.bodyName(b)}`;
    const text = element("button", names, { type: "button", class: "link" });
    text.addEventListener("click", () => show(b < model.disks ? [a, b] : [a]));
    item.append(text, ` overlap by ${formatNumber(overlap, 3)}, ${formatNumber(100 * part, 2)} % of the radius`);
    list.append(item);
  }
  if (overlaps.length > 100) list.append(element("li", `and ${overlaps.length - 100} more`, { class: "quiet" }));
}

/* Numbers of the run that fit a small table. */
function fillRun(table, meta) {
  const summary = meta.summary || {}, rows = [];
  rows.push(["disks", formatNumber(meta.disks)]);
  if (meta.walls?.length) rows.push(["walls", formatNumber(meta.walls.length)]);
  if (meta.stored_frames > meta.frames) rows.push(["frames", `${meta.frames} of ${meta.stored_frames}`]);
  else if (meta.frames) rows.push(["frames", formatNumber(meta.frames)]);
  if (summary.steps) rows.push(["steps", formatNumber(summary.steps, 9)]);
  if (summary.dt) rows.push(["dt", formatNumber(summary.dt)]);
  if (Number.isFinite(summary.residual)) rows.push(["residual of the energy", formatNumber(summary.residual, 2)]);
  for (const r of summary.rotation || []) rows.push([`Ω of ${r.name ?? "disk " + r.disk}`, `${formatNumber(r.omega, 5)} ± ${formatNumber(r.error, 2)}`]);
  for (const a of summary.averages || []) rows.push([a.name, `${formatNumber(a.mean, 5)} ± ${formatNumber(a.error, 2)}`]);
  for (const phase of meta.phases || []) rows.push([`phase ${phase.name || ""}`.trim(), `t = ${formatNumber(phase.from, 4)} … ${formatNumber(phase.to, 4)}`]);
  if (meta.version) rows.push(["slipdisk", meta.version]);
  table.replaceChildren(...rows.map((row) => tableRow(row)));
}

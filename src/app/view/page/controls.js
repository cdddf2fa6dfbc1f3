/* controls.js: buttons, keys, mouse, legend. */
"use strict";

const TOGGLES = { forces: "n", overlaps: "o", marks: "m", copies: "p" };
const KEYS = [
  ["space", "play or pause"], ["← →", "one frame back, on"], ["Page_Up Page_Down", "ten frames back, on"],
  ["Home End", "first, last frame"], [", .", "slower, faster"], ["l", "loop"], ["+ −", "zoom"], ["Shift_arrows", "move the picture"],
  ["f", "fit; once more: with what is far away"], ["c C", "next colouring, the one before"], ["n", "contact forces"], ["o", "overlaps"], ["m", "angle marks"],
  ["p", "copies across periodic edges"], ["s", "save the picture as a PNG file"], ["/", "find a disk"], ["z", "go to the chosen disk"], ["w", "follow it"],
  ["Esc", "choose none"], ["d", "light or dark"], ["?", "this help"],
];

const byId = (id) => document.getElementById(id);

class Controls {
  constructor(viewer) {
    this.viewer = viewer;
    this.canvas = byId("canvas");
    this.fillPage();
    this.bindTools();
    this.bindTime();
    this.bindPointer();
    addEventListener("keydown", (event) => this.key(event));
  }

  /* --- what the data say ------------------------------------------------------------------------ */

  fillPage() {
    const { meta, quantities, model } = this.viewer;
    byId("title").textContent = meta.title || "slipdisk";
    document.title = `${meta.title || meta.source || "run"} – slipdisk`;
    byId("source").textContent = meta.source || "";
    byId("source").title = meta.source || "";
    byId("about-version").textContent = meta.version || "";
    for (const q of quantities) byId("quantity").append(element("option", q.label, { value: q.key }));
    for (const rate of RATES) byId("rate").append(element("option", `${rate} / s`, { value: rate }));
    for (const name of (meta.disk_names || []).slice(0, 200)) if (name) byId("find-names").append(element("option", undefined, { value: name }));
    for (const [keys, meaning] of KEYS) {
      const row = element("tr"), cell = element("td");
      for (const key of keys.split(" ")) cell.append(element("kbd", key.replace("_", " ")), " ");
      row.append(cell, element("td", meaning));
      byId("help-keys").append(row);
    }
    byId("messages").hidden = !(meta.messages?.length > 0);
    fillMessages(byId("message-list"), meta.messages || [], (disks) => this.viewer.showMessage(disks));
    fillRun(byId("run-numbers"), meta);
    const periodic = meta.box?.periodic || [false, false];
    byId("toggle-copies").hidden = !periodic[0] && !periodic[1];
    this.fillGravity(meta.gravity || [0, 0]);
    this.canvas.setAttribute("aria-label", `Picture of ${model.disks} disks`);
    if (meta.kind === "live") {
      byId("newest").hidden = false;
      byId("state").hidden = false;
      byId("loop").hidden = true;
    }
    const single = meta.kind === "deck" || (meta.kind !== "live" && this.viewer.store.end < 2);
    for (const id of ["time", "play", "to-start", "back", "forward", "loop", "rate"]) byId(id).disabled = single;
  }

  fillGravity([gx, gy]) {
    const size = Math.hypot(gx, gy);
    byId("gravity").style.display = size > 0 ? "" : "none";
    byId("gravity-arrow").setAttribute("transform", `rotate(${(Math.atan2(-gx, -gy) * 180) / Math.PI})`);
    byId("gravity-text").textContent = "g";
    byId("gravity-text").setAttribute("x", 12 - (size ? (8 * gx) / size : 0));
    byId("gravity-text").setAttribute("y", 4);
    byId("gravity").setAttribute("title", `gravity ${formatNumber(gx, 4)}, ${formatNumber(gy, 4)}`);
  }

  setState(state) {
    byId("state").textContent = state.text;
    byId("state").className = state.level;
  }

  /* --- tools ------------------------------------------------------------------------------------ */

  bindTools() {
    const { viewer } = this, click = (id, action) => byId(id).addEventListener("click", action);
    byId("quantity").addEventListener("change", (event) => viewer.setQuantity(event.target.value));
    byId("range-mode").addEventListener("change", (event) => viewer.setRangeMode(event.target.value));
    for (const id of ["range-low", "range-high"]) byId(id).addEventListener("change", () => this.takeRange());
    for (const name of Object.keys(TOGGLES)) click(`toggle-${name}`, () => viewer.setLayer(name, !viewer.layers[name]));
    byId("thickness").addEventListener("input", (event) => viewer.setLayer("thickness", 10 ** Number(event.target.value)));
    click("zoom-in", () => this.zoom(1.4));
    click("zoom-out", () => this.zoom(1 / 1.4));
    click("fit", () => viewer.fitNext());
    click("save", () => savePicture(viewer));
    click("theme", () => viewer.setTheme(viewer.theme === "dark" ? "light" : "dark"));
    click("help", () => byId("help-dialog").showModal());
    click("about", () => byId("about-dialog").showModal());
    click("follow", () => viewer.follow(!viewer.following));
    click("zoom-disk", () => viewer.goTo([viewer.selected]));
    click("unselect", () => this.unselect());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", (event) => viewer.setTheme(event.matches ? "dark" : "light"));
    byId("find").addEventListener("submit", (event) => {
      event.preventDefault();
      this.find(byId("find-text"));
    });
    byId("find-text").addEventListener("input", () => (byId("find-message").textContent = ""));
  }

  find(input) {
    const { viewer } = this, disk = viewer.model.find(input.value);
    byId("find-message").textContent = disk < 0 ? `no disk ${input.value.trim().slice(0, 30)}` : "";
    byId("find-message").title = `numbers go from 0 to ${viewer.model.disks - 1}`;
    if (disk < 0) return;
    viewer.select(disk);
    viewer.goTo([disk]);
  }

  takeRange() {
    const range = [byId("range-low"), byId("range-high")].map((input) => Number(input.value.replace("−", "-")));
    if (range.every(Number.isFinite) && range[1] > range[0]) this.viewer.setRange(range);
    this.refreshLegend();
    this.viewer.draw();
  }

  unselect() {
    this.viewer.layers.highlighted = [];
    this.viewer.select(-1);
  }

  zoom(factor) {
    const { camera } = this.viewer;
    camera.zoomAt(camera.width / 2, camera.height / 2, factor);
    this.viewer.untouched = false;
    this.viewer.draw();
  }

  /* --- time ------------------------------------------------------------------------------------- */

  bindTime() {
    const { viewer } = this, { player, store } = viewer, click = (id, action) => byId(id).addEventListener("click", action);
    byId("time").addEventListener("input", (event) => {
      const wanted = Number(event.target.value);
      player.stop();
      this.seek(wanted);
    });
    byId("rate").addEventListener("change", (event) => player.setRate(Number(event.target.value)));
    click("play", () => this.play());
    click("to-start", () => this.seek(store.first));
    click("back", () => this.stepBy(-1));
    click("forward", () => this.stepBy(1));
    click("newest", () => this.seek(store.end - 1));
    click("loop", () => {
      player.loop = !player.loop;
      this.refresh();
    });
  }

  play() {
    this.viewer.newest = false;
    this.viewer.player.toggle();
  }

  seek(k) {
    this.viewer.newest = k >= this.viewer.store.end - 1;
    this.viewer.player.go(k);
    this.refresh();
  }

  stepBy(n) {
    this.viewer.newest = false;
    this.viewer.player.step(n);
  }

  changeRate(by) {
    const { player } = this.viewer, at = RATES.indexOf(player.rate) + by;
    if (RATES[at]) player.setRate(RATES[at]);
  }

  /* --- mouse, touch ----------------------------------------------------------------------------- */

  bindPointer() {
    const { canvas, viewer } = this, held = new Map();
    let moved = 0;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      held.set(event.pointerId, [event.offsetX, event.offsetY]);
      moved = held.size > 1 ? Infinity : 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = held.get(event.pointerId), now = [event.offsetX, event.offsetY];
      if (!before) return this.hover(...now);
      const other = [...held].find(([id]) => id !== event.pointerId)?.[1];
      if (other) {
        const away = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
        viewer.camera.zoomAt(...other, away(now) / Math.max(away(before), 1));
      } else {
        viewer.camera.pan(now[0] - before[0], before[1] - now[1]);
        if (moved > 4) viewer.following = viewer.untouched = false;
      }
      moved += Math.hypot(now[0] - before[0], now[1] - before[1]);
      held.set(event.pointerId, now);
      viewer.draw();
      return undefined;
    });
    const release = (event) => {
      if (!held.delete(event.pointerId) || event.type !== "pointerup" || moved > 4) return;
      viewer.layers.highlighted = [];
      viewer.select(viewer.pick(event.offsetX, event.offsetY));
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("pointerleave", () => (byId("hover").hidden = true));
    canvas.addEventListener("dblclick", () => viewer.fitNext());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const pixels = event.deltaY * (event.deltaMode === 1 ? 16 : 1);
      viewer.camera.zoomAt(event.offsetX, event.offsetY, Math.exp(-Math.max(-200, Math.min(200, pixels)) * 0.002));
      viewer.untouched = false;
      viewer.draw();
    }, { passive: false });
  }

  /* Name and value of the disk under the cursor. */
  hover(px, py) {
    const { viewer } = this, box = byId("hover"), disk = viewer.pick(px, py);
    box.hidden = disk < 0;
    if (disk < 0) return;
    const q = viewer.quantity, value = q.values(viewer.model, viewer.frame)?.[disk];
    const text = q.kind === "names" ? q.names(viewer.model)[value] ?? "none" : formatNumber(value, 4);
    box.textContent = `${viewer.model.bodyName(disk)} · ${q.symbol ?? q.label.toLowerCase()} ${text}`;
    box.style.left = `${Math.min(px + 14, viewer.camera.width - box.offsetWidth - 6)}px`;
    box.style.top = `${Math.max(py - 30, 4)}px`;
  }

  /* --- keys ------------------------------------------------------------------------------------- */

  key(event) {
    const { viewer } = this, target = event.target, { key } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || document.querySelector("dialog[open]")) return;
    if (target.matches?.('select, input:not([type="range"])')) return;
    if (target.matches?.("button, summary") && (key === " " || key === "Enter")) return;
    if (target.matches?.('input[type="range"]') && /^(Arrow|Page|Home|End)/.test(key)) return;
    const action = event.shiftKey && key.startsWith("Arrow") ? this.moves()[key] : this.keys()[key];
    if (!action) return;
    event.preventDefault();
    action();
    viewer.draw();
  }

  moves() {
    const { camera } = this.viewer, far = 60;
    return {
      ArrowLeft: () => camera.pan(far, 0), ArrowRight: () => camera.pan(-far, 0),
      ArrowUp: () => camera.pan(0, -far), ArrowDown: () => camera.pan(0, far),
    };
  }

  keys() {
    const { viewer } = this, { store } = viewer;
    const keys = {
      " ": () => this.play(), ArrowLeft: () => this.stepBy(-1), ArrowRight: () => this.stepBy(1),
      PageUp: () => this.stepBy(-10), PageDown: () => this.stepBy(10), Home: () => this.seek(store.first), End: () => this.seek(store.end - 1),
      ",": () => this.changeRate(-1), ".": () => this.changeRate(1), l: () => byId("loop").click(),
      "+": () => this.zoom(1.25), "=": () => this.zoom(1.25), "-": () => this.zoom(0.8), f: () => viewer.fitNext(),
      c: () => this.nextQuantity(1), C: () => this.nextQuantity(-1), w: () => viewer.follow(!viewer.following),
      s: () => savePicture(viewer), z: () => viewer.selected >= 0 && viewer.goTo([viewer.selected]), "/": () => byId("find-text").focus(),
      Escape: () => this.unselect(), d: () => byId("theme").click(), "?": () => byId("help-dialog").showModal(),
    };
    for (const [name, key] of Object.entries(TOGGLES)) keys[key] = () => viewer.setLayer(name, !viewer.layers[name]);
    return keys;
  }

  nextQuantity(by) {
    const { quantities, quantity } = this.viewer, n = quantities.length;
    this.viewer.setQuantity(quantities[(quantities.indexOf(quantity) + by + n) % n].key);
  }

  /* --- what is shown ---------------------------------------------------------------------------- */

  observe() {
    const measure = () => {
      const box = byId("view").getBoundingClientRect();
      this.viewer.resize(box.width, box.height, Math.min(devicePixelRatio || 1, 2));
    };
    new ResizeObserver(measure).observe(byId("view"));
    measure();
  }

  refresh() {
    const { viewer } = this, { player, store, layers } = viewer;
    const time = byId("time"), pressed = (id, on) => byId(id).setAttribute("aria-pressed", on ? "true" : "false");
    time.min = store.first;
    time.max = Math.max(store.end - 1, store.first);
    if (player.index >= 0) time.value = player.index;
    byId("play").setAttribute("aria-label", player.playing ? "Pause" : "Play");
    byId("play-shape").setAttribute("d", player.playing ? "M4 3h3v10H4zM9 3h3v10H9z" : "M4 2.5v11L13 8z");
    byId("rate").value = player.rate;
    byId("quantity").value = viewer.quantity.key;
    byId("range-mode").value = viewer.rangeMode;
    byId("range-mode").disabled = viewer.quantity.kind === "names";
    byId("range-hand").hidden = viewer.rangeMode !== "manual" || viewer.quantity.kind === "names";
    for (const name of Object.keys(TOGGLES)) pressed(`toggle-${name}`, layers[name]);
    byId("thickness").hidden = !layers.forces;
    pressed("loop", player.loop);
    pressed("newest", viewer.newest);
    pressed("follow", viewer.following);
    this.refreshClock(time);
    this.refreshLegend();
  }

  refreshClock(time) {
    const { player, store, frame, model, meta } = this.viewer;
    if (!frame) return;
    const phase = model.phaseAt(frame.head.time), t = `t = ${formatNumber(frame.head.time, 5)}`;
    const place = `${player.index - store.first + 1} / ${store.end - store.first}`;
    byId("clock").textContent = meta.kind === "deck" ? "the start, before any step" : `${t} · ${place}${phase?.name ? ` · ${phase.name}` : ""}`;
    time.setAttribute("aria-valuetext", `${t}, frame ${place}`);
    if (meta.kind === "result") this.refreshPhases(phase);
  }

  refreshPhases(now) {
    const { store, meta } = this.viewer, place = byId("phases"), span = store.end - 1 - store.first;
    const phases = (meta.phases || []).filter((p) => p.to > p.from);
    if (span < 1 || phases.length < 2) return;
    if (!place.firstChild) {
      for (const p of phases) {
        const bar = element("i"), from = store.nearest(p.from) / span, to = store.nearest(p.to) / span;
        bar.style.left = `${100 * from}%`;
        bar.style.width = `calc(${100 * (to - from)}% - 2px)`;
        place.append(bar);
      }
    }
    [...place.children].forEach((bar, k) => bar.classList.toggle("now", phases[k] === now));
  }

  refreshLegend() {
    const { viewer } = this, q = viewer.quantity, names = q.kind === "names", [low, high] = viewer.range;
    const unit = q.unit ? ` (${q.unit})` : "", missing = viewer.missing ? " – no table of contacts in this frame" : "";
    byId("legend-title").textContent = `${q.label}${q.symbol ? ` ${q.symbol}` : ""}${unit}${missing}`;
    byId("legend-title").title = q.hint || "";
    byId("legend-bar").hidden = names;
    byId("legend-names").hidden = !names;
    if (names) {
      const items = q.names(viewer.model).slice(0, 16).map((name, k) => {
        const item = element("li", name), patch = element("i");
        patch.style.background = categoryColor(k);
        item.prepend(patch);
        return item;
      });
      byId("legend-names").replaceChildren(...items);
    } else {
      paintGradient(byId("legend-gradient"), q.kind === "signed" ? "diverging" : "sequential");
      const beyond = viewer.clipped ? ["≤ ", "", "≥ "] : ["", "", ""];
      if (q.kind !== "signed") beyond[0] = "";
      byId("legend-numbers").replaceChildren(...[low, (low + high) / 2, high].map((v, k) => element("span", beyond[k] + formatNumber(v, 3))));
      if (document.activeElement !== byId("range-low")) byId("range-low").value = Number(low.toPrecision(4));
      if (document.activeElement !== byId("range-high")) byId("range-high").value = Number(high.toPrecision(4));
    }
    this.refreshForces();
  }

  refreshForces() {
    const { layers, frame, theme } = this.viewer, box = byId("legend-forces");
    box.hidden = !layers.forces;
    if (box.hidden) return;
    if (!frame?.has("contact_a")) {
      box.replaceChildren(element("span", "No table of contacts in this frame: give `contacts` in the deck.", { class: "wide" }));
      return;
    }
    const css = (rgb) => `rgb(${rgb.map((v) => Math.round(255 * v)).join(" ")})`;
    const line = (text, tone, dashed) => {
      const item = element("span", text), patch = element("i", undefined, { class: dashed ? "dashed" : "" });
      patch.style.borderTopColor = css(tone);
      item.prepend(patch);
      return item;
    };
    box.replaceChildren(line("sticks", THEMES[theme].force), line("slides", THEMES[theme].sliding, true),
      ...(frame.has("contact_bond") ? [line("bond", THEMES[theme].bond)] : []),
      element("span", `thickness: Fₙ, strong ones ${formatNumber(layers.forceScale, 3)}`, { class: "wide quiet" }));
  }

  /* A bar of a round length. */
  refreshScale() {
    const { camera } = this.viewer, length = niceLength(130 / camera.zoom);
    byId("scale-bar").style.width = `${length * camera.zoom}px`;
    byId("scale-text").textContent = formatNumber(length, 3);
  }
}

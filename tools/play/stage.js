/* stage.js: the picture of a running simulation, drawn by the viewer's scene; pulling of disks. */
"use strict";

const GRAB_REACH = 14; /* pixels beside a disk at which a finger still takes it */

class Stage {
  constructor(session) {
    this.session = session;
    this.canvas = byId("canvas");
    this.renderer = new Renderer(this.canvas);
    this.camera = new Camera();
    this.layers = {
      forces: true, overlaps: false, marks: true, copies: true, thickness: 1, forceScale: 1,
      overlapLimit: 1, selected: -1, highlighted: [],
    };
    this.model = this.scene = this.frame = null;
    this.bounds = [-1, -1, 1, 1];
    this.untouched = true;
    this.grabbed = -1;
    this.drawn = 0;
    this.times = [];
    this.renderer.palette("diverging");
    this.bindPointer();
    new ResizeObserver(() => this.resize()).observe(byId("view"));
    this.resize();
  }

  /* A new run. facts: of the worker; scene: {bounds, box, gravity, values, range, forceScale}. */
  begin(facts, options) {
    const { radius, driven } = facts, angle = new Float64Array(facts.disks);
    const columns = { radius, driven, angle };
    const box = options.box ?? { lower: [0, 0], edges: [0, 0], periodic: [false, false] };
    const meta = { disks: facts.disks, walls: [], box, kind: "play" };
    this.model = new Model(meta, { columns, get: (name) => columns[name] ?? null });
    this.model.columns = columns;
    this.scene = new Scene(this.model, this.renderer);
    this.options = options;
    this.layers.forceScale = options.forceScale ?? 0;
    this.frame = null;
    this.grabbed = -1;
    if (String(this.bounds) !== String(options.bounds)) this.untouched = true;
    this.bounds = options.bounds;
    this.setGravity(options.gravity);
    if (this.untouched) this.fit();
  }

  show(message) {
    this.frame = new LiveFrame(message);
    this.model.walls = message.walls;
    this.model.columns.angle = this.frame.get("origin").map((angle) => angle % (2 * Math.PI));
    this.model.firstTime = this.frame.head.originTime;
    this.draw();
  }

  setQuantity(kind, values, range) {
    this.renderer.palette(kind === "signed" ? "diverging" : "sequential");
    this.values = values;
    this.range = range;
    this.draw();
  }

  /* Turns the arrow of gravity; null: there is none. */
  setGravity(gravity) {
    byId("gravity").style.display = gravity ? "" : "none";
    if (!gravity) return;
    const [gx, gy] = gravity, size = Math.hypot(gx, gy);
    const turn = (Math.atan2(-gx, -gy) * 180) / Math.PI;
    byId("gravity-arrow").setAttribute("transform", `rotate(${turn})`);
    byId("gravity-text").textContent = "g";
    byId("gravity-text").setAttribute("x", 12 - (8 * gx) / size);
    byId("gravity-text").setAttribute("y", 4);
  }

  resize() {
    const view = byId("view"), ratio = window.devicePixelRatio || 1;
    const width = view.clientWidth, height = view.clientHeight;
    if (width < 1 || height < 1) return;
    Object.assign(this.camera, { width, height, ratio });
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    if (this.untouched) this.fit();
    this.paint();
  }

  fit() {
    this.untouched = true;
    this.camera.fit(this.bounds, [12, 8, 12, 8]);
    this.draw();
  }

  zoom(factor) {
    this.camera.zoomAt(this.camera.width / 2, this.camera.height / 2, factor);
    this.untouched = false;
    this.draw();
  }

  toggle(layer) {
    this.layers[layer] = !this.layers[layer];
    this.draw();
  }

  draw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.paint();
    });
  }

  paint() {
    const start = performance.now();
    this.build();
    this.cost = performance.now() - start; /* ms, of this thread */
  }

  build() {
    const { frame, camera, renderer, scene, layers, model } = this;
    const theme = THEMES[document.documentElement.dataset.theme] ?? THEMES.light;
    if (!frame) {
      renderer.gl.clearColor(...theme.background, 1);
      renderer.gl.clear(renderer.gl.COLOR_BUFFER_BIT);
      return;
    }
    const values = this.values(model, frame);
    if (!this.options.forceScale) this.scaleForces(frame);
    scene.buildFixed(frame, camera, theme);
    scene.buildDisks(frame, values, layers.copies);
    scene.buildContacts(frame, layers, theme);
    if (this.grabbed >= 0) this.buildSpring(frame, theme);
    const unit = layers.thickness * Math.min(0.5 * model.meanRadius * camera.zoom, 14);
    const fade = layers.forces ? this.options.fade ?? 0.45 : 0;
    const range = this.range(frame, values);
    renderer.draw(camera, { ...theme, unit, range, marks: layers.marks, fade });
    this.refreshScale();
    this.count();
    this.session.drawn();
  }

  /* Strong forces have the full width; their size is followed slowly. */
  scaleForces(frame) {
    const { layers } = this, force = frame.get("contact_force");
    if (force.length === 0 || (layers.forceScale > 0 && this.drawn % 8)) return;
    const strong = rangeOf({ kind: "magnitude" }, [force])[1];
    layers.forceScale += (layers.forceScale > 0 ? 0.2 : 1) * (strong - layers.forceScale);
  }

  refreshScale() {
    const { camera } = this;
    if (camera.zoom === this.scaled) return;
    this.scaled = camera.zoom;
    const length = niceLength(90 / camera.zoom);
    byId("scale-bar").style.width = `${length * camera.zoom}px`;
    byId("scale-text").textContent = formatNumber(length, 3);
  }

  /* The spring with which the pointer pulls. */
  buildSpring(frame, theme) {
    const k = this.grabbed, [px, py] = this.camera.toWorld(...this.pointer);
    const x = frame.at("x", k), y = frame.at("y", k), radius = this.model.column("radius")[k];
    this.renderer.under.add(x, y, px, py, 0, 2.5, 1, ...theme.overlap, 1);
    this.renderer.marks.ring(x, y, radius, 4, 3, 0, ...theme.overlap, 1);
  }

  /* Frames in the last second. */
  count() {
    const now = performance.now();
    this.drawn++;
    this.times.push(now);
    while (this.times[0] < now - 1000) this.times.shift();
    this.frameRate = this.times.length;
  }

  /* --- mouse, touch --------------------------------------------------------------------------- */

  /* Place of a disk on the canvas. */
  screen(k) {
    return this.camera.toScreen(this.frame.at("x", k), this.frame.at("y", k));
  }

  /* The free disk at a place of the canvas; -1: none. */
  pick(px, py) {
    if (!this.frame) return -1;
    const [x, y] = this.camera.toWorld(px, py);
    const k = this.scene.pick(this.frame, x, y, GRAB_REACH / this.camera.zoom);
    return k >= 0 && !this.model.column("driven")[k] ? k : -1;
  }

  bindPointer() {
    const { canvas, camera } = this, held = new Map();
    const place = (event) => [event.offsetX, event.offsetY];
    canvas.addEventListener("pointerdown", (event) => {
      try {
        canvas.setPointerCapture(event.pointerId);
      } catch { /* an event that a script has made */ }
      held.set(event.pointerId, place(event));
      if (held.size > 1) this.letGo();
      else this.take(place(event));
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = held.get(event.pointerId), now = place(event);
      if (!before) {
        canvas.style.cursor = this.pick(...now) >= 0 ? "pointer" : "";
        return;
      }
      const other = [...held].find(([id]) => id !== event.pointerId)?.[1];
      const away = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
      if (this.grabbed >= 0) {
        this.pull(now);
      } else {
        if (other) camera.zoomAt(...other, away(now) / Math.max(away(before), 1));
        else camera.pan(now[0] - before[0], before[1] - now[1]);
        this.untouched = false;
      }
      held.set(event.pointerId, now);
      this.draw();
    });
    for (const kind of ["pointerup", "pointercancel"])
      canvas.addEventListener(kind, (event) => {
        held.delete(event.pointerId);
        this.letGo();
      });
    canvas.addEventListener("dblclick", (event) => {
      if (this.pick(...place(event)) < 0) this.fit();
    });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const pixels = event.deltaY * (event.deltaMode === 1 ? 16 : 1);
      camera.zoomAt(...place(event), Math.exp(-Math.max(-200, Math.min(200, pixels)) * 0.002));
      this.untouched = false;
      this.draw();
    }, { passive: false });
  }

  take(at) {
    this.grabbed = this.pick(...at);
    if (this.grabbed >= 0) this.pull(at);
  }

  pull(at) {
    this.pointer = at;
    this.session.grab(this.grabbed, ...this.camera.toWorld(...at));
  }

  letGo() {
    if (this.grabbed >= 0) this.session.release();
    this.grabbed = -1;
    this.draw();
  }
}

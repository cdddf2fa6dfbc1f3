/* worker.mjs: runs the engine beside the page. It follows slipdisk.mjs in one text, so that `load`
 * is at hand. The page sends messages {kind, ...}; the worker sends frames, one at a time: the
 * next one when the page has drawn the last. */

const SLICE = 9;       /* ms of steps without a look at messages */
const MOST_BEHIND = 60; /* ms of the clock that a slow run makes up for */
const LEAST_RATE = 200; /* steps per second, before the first measurement */
const MOST_SAMPLES = 4000; /* kept while the page is hidden and takes no frames */

/* Values of a plot at one step, by the name that the page gives: arrays of numbers. */
const SAMPLERS = {
  /* Angle of the first disk, its mean rotation and the error of that. */
  rotation(run) {
    const turn = run.sim.rotation(0), angle = run.sim.angles()[run.sim.slot(0)];
    return [angle, turn?.omega ?? NaN, turn?.error ?? NaN];
  },
  /* Kinetic energy per free disk. */
  kinetic(run) {
    const energy = run.sim.energy();
    return [(energy.kinetic_translation + energy.kinetic_rotation) / run.sim.freeDisks];
  },
  /* Root mean square of the disks' mean rotations since the drive began. */
  turning(run) {
    const { sim, origin } = run, angles = sim.angles(), n = sim.freeDisks;
    const time = sim.time - run.originTime;
    let sum = 0;
    for (let slot = 0; slot < n; slot++) sum += (angles[slot] - origin[slot]) ** 2;
    return [time > 0 ? Math.sqrt(sum / n) / time : NaN];
  },
  /* Stress ratio of a sheared box: contacts, and velocities beside the mean flow. */
  friction(run) {
    const { sim, radius } = run, c = sim.contacts();
    let pressure = 0, shear = 0;
    for (let k = 0; k < c.n; k++) {
      const length = radius[c.a[k]] + radius[c.b[k]] - c.overlap[k];
      const fx = c.normal[k] * c.nx[k] - c.tangential[k] * c.ny[k];
      pressure += 0.5 * c.normal[k] * length;
      shear -= fx * c.ny[k] * length;
    }
    const v = peculiar(sim);
    return [(shear - v.xy) / (pressure + v.half)];
  },
};

/* Sums of m vx vy and of m v^2/2, of velocities beside a linear profile vx(y). */
function peculiar(sim) {
  const [y, vx, vy, m] = ["y", "vx", "vy", "mass"].map((name) => sim.view(name));
  const n = sim.freeDisks;
  let meanY = 0, meanX = 0, meanV = 0;
  for (let k = 0; k < n; k++) {
    meanY += y[k] / n;
    meanX += vx[k] / n;
    meanV += vy[k] / n;
  }
  let above = 0, square = 0;
  for (let k = 0; k < n; k++) {
    above += (y[k] - meanY) * (vx[k] - meanX);
    square += (y[k] - meanY) ** 2;
  }
  const rate = above / square, sum = { xy: 0, half: 0 };
  for (let k = 0; k < n; k++) {
    const ux = vx[k] - meanX - rate * (y[k] - meanY), uy = vy[k] - meanV;
    sum.xy += m[k] * ux * uy;
    sum.half += 0.5 * m[k] * (ux * ux + uy * uy);
  }
  return sum;
}

class Run {
  constructor(engine, message) {
    this.message = message;
    this.number = message.number;
    this.options = message.options;
    this.sim = engine.simulation(message.deck);
    this.engine = engine;
    const { sim } = this;
    this.slots = Uint32Array.from({ length: sim.disks }, (_, k) => sim.slot(k));
    this.radius = this.byDisk(sim.column("radius"));
    this.samples = [];
    this.pulled = false;
    this.setOrigin();
    if (this.options.skip) this.advance(this.options.skip);
  }

  /* Angles count from here. */
  setOrigin() {
    this.phase = this.sim.stage.phase;
    this.origin = this.sim.angles();
    this.originTime = this.sim.time;
  }

  byDisk(column) {
    return Float64Array.from(this.slots, (slot) => column[slot]);
  }

  get over() {
    return this.sim.finished;
  }

  /* Takes steps; stops where samples are due. */
  advance(n) {
    const { sim, options: { every, sampler } } = this;
    for (let left = n; left > 0 && !sim.finished;) {
      const part = every ? Math.min(left, every - (sim.step % every)) : left;
      sim.advance(part);
      left -= part;
      if (sim.stage.phase !== this.phase && !sim.finished) this.setOrigin();
      if (!every || sim.step % every !== 0) continue;
      this.samples.push([sim.time, ...SAMPLERS[sampler](this)]);
      if (this.samples.length > MOST_SAMPLES) this.samples = this.samples.filter((_, k) => k % 2);
    }
  }

  grab({ disk, x, y }) {
    const { sim, options } = this, slot = sim.slot(disk);
    const dx = x - sim.view("x")[slot], dy = y - sim.view("y")[slot];
    const away = Math.hypot(dx, dy), most = options.reach * this.radius[disk];
    const part = away > most ? most / away : 1, mass = sim.view("mass")[slot];
    const px = sim.view("x")[slot] + part * dx, py = sim.view("y")[slot] + part * dy;
    sim.grab(disk, px, py, options.pull, 2 * Math.sqrt(options.pull * mass));
    this.pulled = true;
  }

  /* All that is drawn, as columns in the order of disks. */
  frame() {
    const { sim } = this, contacts = sim.contacts(), angles = sim.angles(), walls = sim.walls();
    const turned = Float64Array.from(this.slots, (slot) => angles[slot] - this.origin[slot]);
    const activity = new Uint8Array(sim.disks), active = sim.view("activity");
    this.slots.forEach((slot, k) => (activity[k] = slot < active.length ? active[slot] : 0));
    const origin = Float64Array.from(this.slots, (slot) => this.origin[slot]);
    const columns = {
      origin, turned, activity,
      x: this.byDisk(sim.view("x")), y: this.byDisk(sim.view("y")),
      vx: this.byDisk(sim.view("vx")), vy: this.byDisk(sim.view("vy")),
      spin: this.byDisk(sim.view("omega")),
      contact_a: contacts.a, contact_b: contacts.b, contact_part: new Uint32Array(contacts.n),
      contact_force: contacts.normal, contact_overlap: contacts.overlap,
      contact_sliding: contacts.sliding,
      wall_x: Float64Array.from(walls, (w) => (w.points.length ? 0 : w.center[0])),
      wall_y: Float64Array.from(walls, (w) => (w.points.length ? 0 : w.center[1])),
      wall_angle: Float64Array.from(walls, (w) => (w.points.length ? 0 : angles[sim.slot(w.body)])),
    };
    const { time, step } = sim, { originTime } = this;
    const head = { time, step, phase: sim.stage.phase, originTime };
    if (this.options.width) this.addBox(head);
    return { head, columns, walls: walls.map(plain), sliding: this.sliding() };
  }

  /* The periodic box now; offset: how far images above are shifted. */
  addBox(head) {
    const width = this.options.width * this.sim.column("box_scale")[0];
    const offset = width * this.sim.column("cell")[2];
    Object.assign(head, { lower: [0, 0], edges: [width, width], offset });
  }

  /* Steps in each pair of states of the watched contacts, and the states now:
   * 0 slides with torque > 0, 1 with torque < 0, 2 sticks, 3 is open. */
  sliding() {
    if (!this.options.sliding) return null;
    const { sim } = this, now = [3, 3];
    const a = sim.view("contact_a"), b = sim.view("contact_b"), slide = sim.view("contact_slide");
    for (let k = 0; k < a.length; k++) {
      const support = Math.max(a[k], b[k]) - 1;
      now[support] = slide[k] > 0 ? 0 : slide[k] < 0 ? 1 : 2;
    }
    return { now, count: Array.from(sim.view("slide_count")) };
  }

  facts() {
    const { sim } = this;
    return {
      disks: sim.disks, dt: sim.dt, radius: this.radius, version: this.engine.version,
      driven: Uint8Array.from(this.slots, (slot) => (slot >= sim.freeDisks ? 1 : 0)),
    };
  }
}

/* A wall as the viewer's scene takes it: points in pairs. */
function plain(wall) {
  const { name, kind, closed, radius, inside } = wall, points = [];
  for (let k = 0; k + 1 < wall.points.length; k += 2)
    points.push([wall.points[k], wall.points[k + 1]]);
  return { name, kind, closed, radius, inside, points };
}

/* Steps as the clock wants them, and frames as the page takes them. */
class Driver {
  constructor(engine) {
    this.engine = engine;
    this.run = null;
    this.running = false;
    this.speed = 1;       /* time of the model per second */
    this.due = 0;         /* steps that the clock wants */
    this.rate = LEAST_RATE;
    this.taken = 0;       /* steps since the last frame */
    this.mayShow = true;
    this.fresh = false;   /* something to show */
    const channel = new MessageChannel();
    channel.port1.onmessage = () => this.tick();
    this.soon = () => channel.port2.postMessage(0);
    this.waiting = false;
  }

  wake() {
    if (this.waiting || !this.run) return;
    this.waiting = true;
    this.soon();
  }

  tick() {
    this.waiting = false;
    const { run } = this, now = performance.now(), passed = now - (this.clock ?? now);
    this.clock = now;
    if (!run) return;
    const active = this.running && !run.over;
    if (active) this.work(Math.min(passed, MOST_BEHIND));
    this.show();
    if (!this.running || run.over) return;
    this.waiting = true;
    if (this.due >= 1 || this.speed === Infinity) this.soon();
    else setTimeout(() => this.tick(), 3);
  }

  work(passed) {
    const { run } = this, slice = Math.max(1, Math.floor((this.rate * SLICE) / 1000));
    if (this.speed === Infinity) this.due = slice;
    else this.due += (this.speed * passed) / 1000 / run.sim.dt;
    this.due = Math.min(this.due, Math.max(1, (this.rate * MOST_BEHIND) / 1000));
    const n = Math.min(Math.floor(this.due), slice);
    if (n < 1) return;
    const start = performance.now();
    this.take(n);
    const spent = performance.now() - start;
    this.due -= n;
    if (spent > 0.5) this.rate += 0.3 * ((1000 * n) / spent - this.rate);
    else if (n === slice) this.rate *= 2;
  }

  take(n) {
    const { run } = this, before = run.sim.step;
    try {
      run.advance(n);
    } catch (error) {
      this.running = false;
      postMessage({ kind: "failed", number: run.number, text: error.message });
    }
    this.taken += run.sim.step - before;
    this.fresh = this.fresh || run.sim.step > before;
    if (run.over) this.running = false;
  }

  show() {
    const { run } = this;
    if (!this.mayShow || !this.fresh) return;
    this.mayShow = this.fresh = false;
    const now = performance.now();
    const frame = run.frame(), rest = !this.running;
    const message = {
      kind: "frame", number: run.number, ...frame, samples: run.samples, steps: this.taken,
      passed: now - (this.shown ?? now), over: run.over, pulled: run.pulled, rest,
      capacity: this.rate, hash: rest ? run.sim.hash() : null,
    };
    run.samples = [];
    this.taken = 0;
    this.shown = now;
    const buffers = new Set(Object.values(frame.columns).map((column) => column.buffer));
    postMessage(message, [...buffers]);
  }

  /* --- messages ------------------------------------------------------------------------------- */

  start(message) {
    this.run?.sim.free();
    this.run = null;
    try {
      this.run = new Run(this.engine, message);
    } catch (error) {
      postMessage({ kind: "failed", number: message.number, text: error.message, start: true });
      return;
    }
    this.due = this.taken = 0;
    this.mayShow = this.fresh = true;
    this.clock = this.shown = performance.now();
    postMessage({ kind: "started", number: message.number, ...this.run.facts() });
  }

  handle(message) {
    const { run } = this;
    if (message.kind === "start") this.start(message);
    else if (message.kind === "drawn") this.mayShow = true;
    else if (message.kind === "speed") this.speed = message.speed;
    else if (message.kind === "running") this.setRunning(message.running);
    else if (run && message.kind === "steps") this.stepTo(run.sim.step + message.n);
    else if (run && message.kind === "until") this.stepTo(message.step, true);
    else if (run && message.kind === "grab") run.grab(message);
    else if (run && message.kind === "release") run.sim.release();
    this.wake();
  }

  setRunning(running) {
    this.running = running;
    this.clock = performance.now();
    this.due = 0;
    this.fresh = true;
  }

  /* A step that is over is reached from the start. */
  stepTo(step, tell) {
    if (step < this.run.sim.step) this.start(this.run.message);
    this.running = false;
    this.take(step - this.run.sim.step);
    this.fresh = true;
    if (tell) postMessage({ kind: "reached", step: this.run.sim.step, hash: this.run.sim.hash() });
  }
}

/* The first message has the bytes of the engine; others wait until it is compiled. */
let driver = null;
const early = [];
onmessage = async ({ data }) => {
  if (driver) {
    driver.handle(data);
  } else if (data.kind === "load") {
    try {
      driver = new Driver(await load(data.wasm));
    } catch (error) {
      postMessage({ kind: "failed", text: `The engine does not start: ${error.message}` });
      return;
    }
    for (const message of early) driver.handle(message);
  } else {
    early.push(data);
  }
};

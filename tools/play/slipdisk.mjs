/* slipdisk.mjs: the engine of slipdisk as a module for browsers and Node; slipdisk.d.mts documents
 * it. It calls the functions of engine.c in slipdisk.wasm and imports nothing but the few system
 * calls below. */

export class SlipdiskError extends Error {
  constructor(messages, status) {
    super(messages.join("\n"));
    this.name = "SlipdiskError";
    this.messages = messages;
    this.status = status;
  }
}

/* --- decks written as objects ------------------------------------------------------------------- */

const quoted = (text) => `"${text.replace(/["\\]/g, "\\$&")}"`;

function valueText(value) {
  if (typeof value === "string") return quoted(value);
  if (Array.isArray(value)) return `(${value.map(valueText).join(", ")})`;
  if (typeof value === "object" && value !== null) return `{ ${membersText(value, " ")} }`;
  return String(value);
}

function membersText(group, between) {
  return Object.entries(group).map(([key, value]) => `${key} = ${valueText(value)};`).join(between);
}

export function deckText(deck) {
  return `${membersText(deck, "\n")}\n`;
}

/* --- the instance of WebAssembly ------------------------------------------------------------------ */

const encoder = new TextEncoder(), decoder = new TextDecoder();

/* The system calls of the C library: no files, no environment, a clock, and texts for the console. */
function systemCalls(memory) {
  const fails = () => 8; /* "bad file descriptor" */
  let registers = 0; /* upper half of a 64-bit result */
  const words = () => new DataView(memory().buffer);
  return {
    env: {
      emscripten_notify_memory_growth() {},
      getTempRet0: () => registers,
      setTempRet0(value) { registers = value; },
    },
    wasi_snapshot_preview1: {
      fd_close: fails,
      fd_read: fails,
      fd_seek: fails,
      fd_write(file, pieces, n, written) {
        let text = "", size = 0;
        for (let k = 0; k < n; k++) {
          const at = words().getUint32(pieces + 8 * k, true), length = words().getUint32(pieces + 8 * k + 4, true);
          text += decoder.decode(new Uint8Array(memory().buffer, at, length));
          size += length;
        }
        words().setUint32(written, size, true);
        if (text.trim()) console.error(text.trimEnd());
        return 0;
      },
      clock_time_get(clock, precision, at) {
        words().setBigUint64(at, BigInt(Math.round(performance.now() * 1e6)), true);
        return 0;
      },
      environ_get: () => 0,
      environ_sizes_get(number, size) {
        words().setUint32(number, 0, true);
        words().setUint32(size, 0, true);
        return 0;
      },
      proc_exit(status) { throw new Error(`the engine ended with status ${status}`); },
    },
  };
}

async function unpacked(bytes) {
  if (bytes[0] !== 0x1f || bytes[1] !== 0x8b) return bytes;
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/* Bytes of slipdisk.wasm: in the page, or beside this module. */
async function find() {
  const element = globalThis.document?.getElementById("slipdisk-wasm");
  if (element) return Uint8Array.from(atob(element.textContent.trim()), (c) => c.charCodeAt(0));
  const place = new URL("slipdisk.wasm", import.meta.url);
  if (place.protocol === "file:" && globalThis.process?.versions?.node) {
    const { readFile } = await import("node:fs/promises");
    return readFile(place);
  }
  const answer = await fetch(place);
  if (!answer.ok) throw new Error(`${place}: ${answer.status} ${answer.statusText}`);
  return new Uint8Array(await answer.arrayBuffer());
}

export async function load(wasm) {
  const bytes = await unpacked(wasm ? new Uint8Array(wasm) : await find());
  let instance = null;
  ({ instance } = await WebAssembly.instantiate(bytes, systemCalls(() => instance.exports.memory)));
  instance.exports._initialize();
  return new Engine(instance.exports);
}

/* --- the engine ----------------------------------------------------------------------------------- */

const ARRAYS = [Float64Array, BigInt64Array, Int32Array, Uint32Array]; /* in the order of sd_type */
const NONE = 0xffffffff;
const MEAN = ["mean", "error", "correlation", "used", "discarded", "converged"];
const ROTATION = ["disk", "omega", "error", "scaled", "scaledError", "transient", "measured", "turned", "converged"];
const ENERGY = ["kinetic_translation", "kinetic_rotation", "elastic_normal", "elastic_tangential", "elastic_rolling",
  "elastic_bond", "cohesion", "external", "start", "work", "nonconservative_work", "viscous", "friction", "rolling", "bridge",
  "opening", "broken_tension", "broken_shear", "broken_bending", "drag", "damping", "relaxed", "residual", "scale"];
const KINDS = ["line", "segment", "polyline", "circle", "arc"];

function record(names, numbers) {
  return Object.fromEntries(names.map((name, k) => [name, name === "converged" ? numbers[k] !== 0 : numbers[k]]));
}

class Engine {
  #c; /* functions of engine.c */

  constructor(c) {
    this.#c = c;
    this.version = this.text(c.play_version());
  }

  /* --- for Simulation, not for callers: memory of the engine --- */

  get functions() { return this.#c; }

  array(Type, at, n) { return new Type(this.#c.memory.buffer, at, n); }

  text(at) {
    const bytes = new Uint8Array(this.#c.memory.buffer);
    return decoder.decode(bytes.subarray(at, bytes.indexOf(0, at)));
  }

  /* Calls use(addresses) with copies of texts and arrays in the memory of the engine. */
  lend(values, use) {
    const at = values.map((value) => {
      const bytes = typeof value === "string" ? encoder.encode(`${value}\0`)
        : new Uint8Array(value.buffer, value.byteOffset, value.byteLength);
      const place = this.#c.play_memory(bytes.length);
      if (!place) throw new SlipdiskError(["out of memory"], 4);
      new Uint8Array(this.#c.memory.buffer, place, bytes.length).set(bytes);
      return place;
    });
    try {
      return use(...at);
    } finally {
      for (const place of at) this.#c.play_forget(place);
    }
  }

  /* Calls fill(address) with room for n numbers and returns the result and these numbers. */
  fetch(n, fill, Type = Float64Array) {
    return this.lend([new Type(n)], (at) => [fill(at), this.array(Type, at, n).slice()]);
  }

  messages(warnings) {
    const found = [];
    for (let k = 0; k < this.#c.play_messages(); k++)
      if ((this.#c.play_message_kind(k) === 0) === warnings) found.push(this.text(this.#c.play_message(k)));
    return found;
  }

  /* Throws the messages of a call that returned another status than 0. */
  check(status) {
    if (status !== 0) throw new SlipdiskError(this.messages(false), status);
  }

  /* --- for callers --- */

  simulation(deck, { set = [], files = {} } = {}) {
    const text = typeof deck === "string" ? deck : deckText(deck);
    const settings = Array.isArray(set) ? set : Object.entries(set).map(([key, value]) => `${key}=${value}`);
    for (const [name, content] of Object.entries(files))
      this.lend([name, content], (at, what) => this.#c.play_file(at, what));
    const made = this.lend([text, settings.map((one) => `${one}\0`).join("")],
      (at, first) => this.#c.play_new(at, settings.length, first));
    this.#c.play_no_files();
    if (!made) {
      const last = this.#c.play_messages() - 1;
      let status = 2;
      for (let k = last; k >= 0; k--) status = this.#c.play_message_kind(k) || status;
      this.check(status);
    }
    return new Simulation(this, made, this.messages(true));
  }

  mean(samples, transient = true) {
    const numbers = Float64Array.from(samples);
    const [, found] = this.fetch(MEAN.length, (to) =>
      this.lend([numbers], (at) => this.#c.play_mean(at, numbers.length, transient ? 1 : 0, to)));
    return record(MEAN, found);
  }
}

class Simulation {
  #engine;
  #c;
  #at; /* address of the simulation in C; 0: freed */

  constructor(engine, at, warnings) {
    this.#engine = engine;
    this.#c = engine.functions;
    this.#at = at;
    this.warnings = warnings;
  }

  get #p() {
    if (!this.#at) throw new SlipdiskError(["the simulation was freed"], 2);
    return this.#at;
  }

  #number(which) { return this.#c.play_number(this.#p, which); } /* the enum of engine.c */

  get step() { return this.#number(0); }
  get time() { return this.#number(1); }
  get dt() { return this.#number(2); }
  get finished() { return this.#number(3) !== 0; }
  get stage() {
    return { step: this.step, phase: this.#number(4), phaseStep: this.#number(5), before: this.#number(6) };
  }
  get disks() { return this.#number(7); }
  get freeDisks() { return this.#number(8); }
  get bodies() { return this.#number(9); }
  get deck() { return this.#engine.text(this.#c.play_deck(this.#p)); }

  advance(n) {
    if (!Number.isSafeInteger(n))
      throw new SlipdiskError([`advance(${n}): expected a whole number of steps`], 2);
    this.#engine.check(this.#c.play_advance(this.#p, n));
  }

  /* --- columns and names --- */

  view(name) {
    if (!this.#engine.lend([name], (text) => this.#c.play_column(this.#p, text)))
      throw new SlipdiskError([`${name}: there is no such column`], 2);
    const Type = ARRAYS[this.#c.play_column_type(this.#p)], n = this.#c.play_column_size(this.#p);
    const found = this.#engine.array(Type, n ? this.#c.play_column_data(this.#p) : 0, n);
    return found instanceof BigInt64Array ? Float64Array.from(found, Number) : found;
  }

  column(name) { return this.view(name).slice(); }

  angles() {
    const found = this.column("theta"), turns = this.view("turn");
    for (let k = 0; k < found.length; k++) found[k] = turns[k] + found[k];
    return found;
  }

  slot(body) {
    const found = this.#c.play_slot(this.#p, body) >>> 0;
    return found === NONE ? -1 : found;
  }

  find(name) {
    const found = this.#engine.lend([name], (at) => this.#c.play_find(this.#p, at) >>> 0);
    return found === NONE ? -1 : found;
  }

  name(body) { return this.#engine.text(this.#c.play_name(this.#p, body)); }

  /* --- steering --- */

  #index(quantity, index) {
    if (typeof index === "number") return index;
    const found = this.#engine.lend([quantity, index, ""], (...at) => this.#c.play_index(this.#p, ...at) >>> 0);
    if (found === NONE) throw new SlipdiskError([`${quantity} of ${index}: there is none`], 2);
    return found;
  }

  set(name, values, indices) {
    const list = typeof indices === "number" || typeof indices === "string" ? [indices] : indices;
    const width = name === "position" || name === "velocity" ? 2 : 1;
    const given = typeof values === "number" ? 1 : values.length / width;
    const n = list ? list.length : given;
    if (typeof values !== "number" && given !== n)
      throw new SlipdiskError([`${name}: ${values.length} values for ${n} indices`], 2);
    const index = Uint32Array.from({ length: n }, (_, k) => (list ? this.#index(name, list[k]) : k));
    const numbers = typeof values === "number" ? new Float64Array(n * width).fill(values) : Float64Array.from(values);
    this.#engine.check(this.#engine.lend([name, index, numbers],
      (text, at, from) => this.#c.play_set(this.#p, text, n, at, from)));
  }

  setLaw(name, value) {
    const n = this.#number(10) ** 2;
    this.set(`law.${name}`, value, Array.from({ length: n }, (_, k) => k));
  }

  get(name, index = 0) {
    const k = this.#index(name, index);
    return this.#engine.lend([name], (at) => this.#c.play_get(this.#p, at, k));
  }

  grab(disk, x, y, stiffness, damping = 0) {
    this.#engine.check(this.#c.play_grab(this.#p, disk, x, y, stiffness, damping));
  }

  release() { this.#c.play_release(this.#p); }

  addDisks(disks) {
    const rows = disks.flatMap(({ x, y, radius, mass, vx = 0, vy = 0, omega = 0, material = 0 }) =>
      [x, y, radius, mass, vx, vy, omega, material]);
    const [status, first] = this.#engine.fetch(1, (to) => this.#engine.lend([Float64Array.from(rows)],
      (at) => this.#c.play_add(this.#p, disks.length, at, to)), Uint32Array);
    this.#engine.check(status);
    return first[0];
  }

  removeDisks(disks) {
    const list = Uint32Array.from(disks);
    this.#engine.check(this.#engine.lend([list], (at) => this.#c.play_remove(this.#p, list.length, at)));
  }

  /* --- reading --- */

  /* Calls fill(p, address of a number), which makes a table, and returns the table and the number. */
  #table(fill, size) {
    const [at, [n]] = this.#engine.fetch(1, (to) => fill(this.#p, to), Uint32Array);
    if (!at) this.#engine.check(4);
    return [n, this.#engine.array(Float64Array, at, size(n))];
  }

  contacts() {
    const width = 10;
    const [n, rows] = this.#table(this.#c.play_contacts, (count) => count * width);
    const column = (k, Type = Float64Array) => Type.from({ length: n }, (_, row) => rows[row * width + k]);
    return { n, a: column(0, Uint32Array), b: column(1, Uint32Array), x: column(2), y: column(3), nx: column(4),
      ny: column(5), normal: column(6), tangential: column(7), overlap: column(8), sliding: column(9, Uint8Array) };
  }

  walls() {
    const whole = this.#c.memory.buffer.byteLength;
    let at = 0, [n, numbers] = this.#table(this.#c.play_walls, () => 0);
    numbers = new Float64Array(numbers.buffer, numbers.byteOffset, (whole - numbers.byteOffset) >> 3);
    return Array.from({ length: n }, (_, k) => {
      const [kind, closed, inside, radius, x, y, points] = numbers.subarray(at, at + 7);
      at += 7 + 2 * points;
      const body = this.disks + k;
      return { body, name: this.name(body), kind: KINDS[kind], points: numbers.slice(at - 2 * points, at),
        closed: closed !== 0, center: [x, y], radius, inside: inside !== 0 };
    });
  }

  energy() {
    const [n, numbers] = this.#engine.fetch(64, (to) => this.#c.play_energy(this.#p, to));
    if (n !== ENERGY.length) throw new Error("the module and slipdisk.wasm are of different versions");
    return record(ENERGY, numbers);
  }

  rotation(k = 0) {
    const [there, numbers] = this.#engine.fetch(ROTATION.length, (to) => this.#c.play_rotation(this.#p, k, to));
    return there ? record(ROTATION, numbers) : undefined;
  }

  hash() { return this.#engine.text(this.#c.play_hash(this.#p)); }

  free() {
    if (this.#at) this.#c.play_free(this.#at);
    this.#at = 0;
  }
}

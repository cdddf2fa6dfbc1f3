/* data.js: numbers of the page. A chunk is base64 of a zlib stream: length, JSON, then columns at multiples of 8. */
"use strict";

const COLUMN_TYPES = {
  f64: Float64Array, f32: Float32Array, i32: Int32Array, u32: Uint32Array,
  i16: Int16Array, u16: Uint16Array, i8: Int8Array, u8: Uint8Array,
};

function bytesOfBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let k = 0; k < bytes.length; k++) bytes[k] = letters.charCodeAt(k);
  return bytes;
}

async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/* The columns of a frame, of the static numbers, or of the series; decoded when they are asked for. */
class Chunk {
  constructor(bytes) {
    const length = new DataView(bytes.buffer, bytes.byteOffset).getUint32(0, true);
    this.head = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
    this.body = bytes.subarray(4 + length);
    this.size = bytes.length;
    this.columns = new Map(this.head.columns.map((c) => [c.name, c]));
    this.decoded = new Map();
  }

  static async from(bytes) {
    return new Chunk(await inflate(bytes));
  }

  has(name) {
    return this.columns.has(name);
  }

  /* A typed array of the values, or null when there is no such column. */
  get(name) {
    const column = this.columns.get(name);
    if (!column) return null;
    if (!this.decoded.has(name)) {
      const values = this.decode(column);
      this.decoded.set(name, values);
      this.size += values.byteLength;
    }
    return this.decoded.get(name);
  }

  decode(column) {
    const Type = COLUMN_TYPES[column.type];
    const width = Type.BYTES_PER_ELEMENT, n = column.count;
    const from = this.body.subarray(column.offset, column.offset + n * width);
    const bytes = new Uint8Array(n * width);
    if (column.shuffle && width > 1) {
      for (let b = 0; b < width; b++) for (let k = 0, at = b; k < n; k++, at += width) bytes[at] = from[b * n + k];
    } else {
      bytes.set(from);
    }
    const stored = new Type(bytes.buffer);
    if (column.scale === 1 && column.zero === 0) return stored;
    const values = new Float32Array(n);
    for (let k = 0; k < n; k++) values[k] = column.zero + column.scale * stored[k];
    return values;
  }

  /* One value, without decoding its column. */
  at(name, k) {
    const column = this.columns.get(name);
    if (!column || !(k < column.count)) return NaN;
    if (this.decoded.has(name)) return this.decoded.get(name)[k];
    const Type = COLUMN_TYPES[column.type];
    const width = Type.BYTES_PER_ELEMENT, n = column.count;
    const bytes = new Uint8Array(width);
    for (let b = 0; b < width; b++)
      bytes[b] = this.body[column.offset + (column.shuffle && width > 1 ? b * n + k : k * width + b)];
    return column.zero + column.scale * new Type(bytes.buffer)[0];
  }
}

/* Chunks that stand in the page itself. */
class PageSource {
  constructor(page) {
    this.page = page;
    this.nodes = [...page.querySelectorAll('script.slipdisk-chunk[data-name="frame"]')];
    this.times = this.nodes.map((node) => Number(node.dataset.time));
  }

  get count() {
    return this.nodes.length;
  }

  frame(k) {
    return Chunk.from(bytesOfBase64(this.nodes[k].textContent));
  }

  async one(name) {
    const node = this.page.querySelector(`script.slipdisk-chunk[data-name="${name}"]`);
    return node ? Chunk.from(bytesOfBase64(node.textContent)) : null;
  }
}

/* Frames of the page; the decoded ones that were used last are kept, up to a number of bytes. */
class PageStore {
  constructor(source, limit = 128e6) {
    this.source = source;
    this.limit = limit;
    this.first = 0;
    this.frames = new Map();
    this.loading = new Map();
  }

  get end() {
    return this.source.count;
  }

  time(k) {
    return this.source.times[k];
  }

  nearest(t) {
    return nearestIndex(this.source.times, t);
  }

  /* The frame when it is decoded, else null. */
  now(k) {
    const frame = this.frames.get(k);
    if (!frame) return null;
    this.frames.delete(k);
    this.frames.set(k, frame);
    return frame;
  }

  /* The frame, without keeping it. */
  visit(k) {
    const known = this.frames.get(k);
    return known ? Promise.resolve(known) : this.source.frame(k);
  }

  load(k) {
    const known = this.now(k);
    if (known) return Promise.resolve(known);
    if (!this.loading.has(k)) {
      const work = this.source.frame(k).then((frame) => {
        this.frames.set(k, frame);
        this.trim();
        return frame;
      }).finally(() => this.loading.delete(k));
      this.loading.set(k, work);
    }
    return this.loading.get(k);
  }

  bytes() {
    let sum = 0;
    for (const frame of this.frames.values()) sum += frame.size;
    return sum;
  }

  trim() {
    let sum = this.bytes();
    for (const [k, frame] of this.frames) {
      if (sum <= this.limit || this.frames.size <= 2) break;
      this.frames.delete(k);
      sum -= frame.size;
    }
  }

  /* Decodes what will be shown next. */
  prefetch(k, stride, count) {
    for (let ahead = 1; ahead <= count; ahead++) {
      const next = k + ahead * stride;
      if (next < 0 || next >= this.end) return;
      if (!this.frames.has(next)) this.load(next).catch(() => {});
    }
  }
}

/* Index of the time that is nearest to t; times ascend. */
function nearestIndex(times, t) {
  let low = 0, high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle;
  }
  return high > 0 && Math.abs(times[high] - t) < Math.abs(times[low] - t) ? high : Math.max(low, 0);
}

const SUPERSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹";

/* A number for people: significant digits, powers of ten as such, a true minus. */
function formatNumber(value, digits = 6) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (!Number.isFinite(value)) return value < 0 ? "−∞" : "∞";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (Number.isInteger(value) && size < 1e6) return String(value).replace("-", "−");
  if (size >= 1e-3 && size < 1e6) return String(Number(value.toPrecision(digits))).replace("-", "−");
  const [mantissa, power] = value.toExponential(digits - 1).split("e");
  const raised = power.replace("+", "").replace("-", "⁻").replace(/\d/g, (d) => SUPERSCRIPTS[d]);
  return `${Number(mantissa)}·10${raised}`.replace("-", "−");
}

/* gl.js: draws disks, lines and rings with WebGL2. Instances of one square; circles and edges are made in the fragment shader. */
"use strict";

const CAMERA_GLSL = `#version 300 es
precision highp float;
uniform vec2 centre, size;   /* world; canvas in pixels */
uniform float zoom;          /* pixels per unit of length */
vec4 place(vec2 pixels) { return vec4(2.0 * pixels / size, 0.0, 1.0); }
`;

const CORNER_GLSL = `
vec2 corner() { return vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0; }
`;

const DISK_VERTEX = `${CAMERA_GLSL}${CORNER_GLSL}
in float x, y, radius, angle, turned, value, activity, driven;
uniform vec2 shift, lower, upper;  /* a periodic copy, and the region in which copies are drawn */
out vec2 p;
out float pixels, tint, pinned;
out vec2 direction;
void main() {
  vec2 at = vec2(x, y) + shift;
  bool copy = shift != vec2(0.0);
  bool away = copy && (any(lessThan(at, lower - radius)) || any(greaterThan(at, upper + radius)));
  pixels = max(radius * zoom, 0.75);
  p = corner() * (pixels + 1.0);
  tint = value;
  pinned = driven;
  float turn = angle + turned;
  turn -= 6.283185307 * floor(turn / 6.283185307);
  direction = vec2(cos(turn), sin(turn));
  gl_Position = place((at - centre) * zoom + p);
  if (away || activity == 1.0 || activity == 2.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`;

const DISK_FRAGMENT = `#version 300 es
precision highp float;
in vec2 p, direction;
in float pixels, tint, pinned;
uniform sampler2D palette;
uniform vec2 range;
uniform vec3 background, outline, missing;
uniform float fade;   /* 0: full colours, 1: background */
uniform bool marks;
out vec4 color;
void main() {
  float away = length(p);
  float cover = clamp(pixels - away + 0.5, 0.0, 1.0);
  if (cover <= 0.0) discard;
  vec3 fill = missing;
  if (tint > -1e38) {
    float t = clamp((tint - range.x) / (range.y - range.x), 0.0, 1.0);
    fill = texture(palette, vec2((t * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  }
  fill = mix(fill, background, fade);
  float light = dot(fill, vec3(0.3, 0.59, 0.11));
  if (pixels > 2.0) {
    float width = clamp(pixels * 0.05, 0.6, 1.6);
    fill = mix(fill, outline, 0.8 * smoothstep(2.0, 6.0, pixels) * smoothstep(pixels - width - 1.0, pixels - width, away));
  }
  if (marks && pixels > 4.0) {
    float width = clamp(pixels * 0.055, 0.55, 2.2);
    float along = dot(p, direction), across = abs(p.x * direction.y - p.y * direction.x);
    float mark = clamp(width - across + 0.5, 0.0, 1.0) * step(0.0, along);
    float dot_radius = max(width, pinned > 0.5 ? pixels * 0.12 : 0.0);
    mark = max(mark, clamp(dot_radius - away + 0.5, 0.0, 1.0));
    fill = mix(fill, light > 0.5 ? vec3(0.08) : vec3(0.97), 0.85 * mark * (1.0 - 0.6 * fade));
  }
  color = vec4(fill, 1.0) * cover;
}`;

const LINE_VERTEX = `${CAMERA_GLSL}${CORNER_GLSL}
in vec4 ends;
in vec3 style;   /* width in units, least width in pixels, 1: dashed */
in vec4 paint;
uniform float unit;   /* pixels */
out vec4 tone;
out float across, half_width, along, dash;
void main() {
  vec2 a = (ends.xy - centre) * zoom, b = (ends.zw - centre) * zoom;
  float span = max(length(b - a), 1e-6);
  vec2 t = (b - a) / span, n = vec2(-t.y, t.x);
  half_width = 0.5 * max(style.x * unit, style.y);
  vec2 c = corner();
  across = c.y * (half_width + 1.0);
  along = c.x < 0.0 ? 0.0 : span;
  dash = style.z > 0.0 ? 7.0 + 3.0 * half_width : 0.0;
  tone = paint;
  gl_Position = place(mix(a, b, 0.5 * c.x + 0.5) + n * across);
}`;

const LINE_FRAGMENT = `#version 300 es
precision highp float;
in vec4 tone;
in float across, half_width, along, dash;
out vec4 color;
void main() {
  float cover = clamp(half_width - abs(across) + 0.5, 0.0, 1.0);
  if (dash > 0.0 && mod(along, dash) > 0.6 * dash) cover = 0.0;
  color = vec4(tone.rgb, 1.0) * tone.a * cover;
}`;

const RING_VERTEX = `${CAMERA_GLSL}${CORNER_GLSL}
in vec3 circle;
in vec3 style;   /* least radius in pixels, line in pixels, opacity of the inside */
in vec4 paint;
out vec2 p;
out vec4 tone;
out float pixels, line, inside;
void main() {
  pixels = max(circle.z * zoom, style.x);
  line = style.y;
  inside = style.z;
  tone = paint;
  p = corner() * (pixels + line + 1.0);
  gl_Position = place((circle.xy - centre) * zoom + p);
}`;

const RING_FRAGMENT = `#version 300 es
precision highp float;
in vec2 p;
in vec4 tone;
in float pixels, line, inside;
out vec4 color;
void main() {
  float away = length(p);
  float cover = clamp(0.5 * line - abs(away - pixels) + 0.5, 0.0, 1.0);
  cover = max(cover, inside * clamp(pixels - away + 0.5, 0.0, 1.0));
  if (cover <= 0.0) discard;
  color = vec4(tone.rgb, 1.0) * tone.a * cover;
}`;

/* Instances that are made anew for every picture: rows of floats, by the lengths of their attributes. */
class Batch {
  constructor(gl, program, attributes) {
    this.gl = gl;
    this.stride = attributes.reduce((sum, [, n]) => sum + n, 0);
    this.rows = new Float32Array(64 * this.stride);
    this.count = 0;
    this.buffer = gl.createBuffer();
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    let offset = 0;
    for (const [name, n] of attributes) {
      const at = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, n, gl.FLOAT, false, 4 * this.stride, 4 * offset);
      gl.vertexAttribDivisor(at, 1);
      offset += n;
    }
    gl.bindVertexArray(null);
  }

  clear() {
    this.count = 0;
    this.changed = true;
  }

  add(...values) {
    if ((this.count + 1) * this.stride > this.rows.length) {
      const more = new Float32Array(2 * this.rows.length);
      more.set(this.rows);
      this.rows = more;
    }
    const at = this.count++ * this.stride;
    for (let k = 0; k < values.length; k++) this.rows[at + k] = values[k];
  }

  upload() {
    const gl = this.gl;
    if (!this.changed) return;
    this.changed = false;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, this.rows.subarray(0, this.count * this.stride), gl.DYNAMIC_DRAW);
  }

  draw() {
    if (this.count === 0) return;
    this.gl.bindVertexArray(this.array);
    this.gl.drawArraysInstanced(this.gl.TRIANGLE_STRIP, 0, 4, this.count);
  }
}

const DISK_COLUMNS = ["x", "y", "radius", "angle", "turned", "value", "activity", "driven"];

class Renderer {
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: false, alpha: false, preserveDrawingBuffer: false });
    if (!gl) throw new Error("This browser does not offer WebGL2, with which the disks are drawn.");
    this.gl = gl;
    this.canvas = canvas;
    this.disks = this.program(DISK_VERTEX, DISK_FRAGMENT);
    this.lines = this.program(LINE_VERTEX, LINE_FRAGMENT);
    this.rings = this.program(RING_VERTEX, RING_FRAGMENT);
    this.buffers = {};
    this.diskArray = gl.createVertexArray();
    gl.bindVertexArray(this.diskArray);
    for (const name of DISK_COLUMNS) {
      const at = gl.getAttribLocation(this.disks.program, name);
      this.buffers[name] = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name]);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, 1, gl.FLOAT, false, 0, 0);
      gl.vertexAttribDivisor(at, 1);
    }
    gl.bindVertexArray(null);
    const lineRows = [["ends", 4], ["style", 3], ["paint", 4]];
    this.under = new Batch(gl, this.lines.program, lineRows);
    this.forces = new Batch(gl, this.lines.program, lineRows);
    this.circles = new Batch(gl, this.rings.program, [["circle", 3], ["style", 3], ["paint", 4]]);
    this.marks = new Batch(gl, this.rings.program, [["circle", 3], ["style", 3], ["paint", 4]]);
    this.texture = gl.createTexture();
    this.count = 0;
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  program(vertex, fragment) {
    const gl = this.gl, program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const at = {};
    for (let k = 0; k < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); k++) {
      const name = gl.getActiveUniform(program, k).name;
      at[name] = gl.getUniformLocation(program, name);
    }
    return { program, at };
  }

  /* A column of all disks: typed array of n numbers. */
  column(name, values) {
    const gl = this.gl;
    const floats = values instanceof Float32Array ? values : Float32Array.from(values);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[name]);
    gl.bufferData(gl.ARRAY_BUFFER, floats, gl.DYNAMIC_DRAW);
    this.count = floats.length;
  }

  palette(name) {
    const gl = this.gl, filter = name === "categorical" ? gl.NEAREST : gl.LINEAR;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, 256, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, paletteBytes(name));
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  }

  use(program, camera) {
    const gl = this.gl;
    gl.useProgram(program.program);
    gl.uniform2f(program.at.centre, camera.x, camera.y);
    gl.uniform2f(program.at.size, this.canvas.width, this.canvas.height);
    gl.uniform1f(program.at.zoom, camera.zoom * camera.ratio);
    return program.at;
  }

  /* look: range, fade, marks, colours, unit of thickness in pixels; copies: shifts of periodic copies with the region around them. */
  draw(camera, look, copies) {
    const gl = this.gl;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...look.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    for (const batch of [this.under, this.forces, this.circles, this.marks]) batch.upload();
    this.use(this.rings, camera);
    this.circles.draw();
    if (this.count > 0) this.drawDisks(camera, look, copies);
    const at = this.use(this.lines, camera);
    gl.uniform1f(at.unit, look.unit * camera.ratio);
    this.under.draw();
    this.forces.draw();
    this.use(this.rings, camera);
    this.marks.draw();
    gl.bindVertexArray(null);
  }

  drawDisks(camera, look, copies) {
    const gl = this.gl, at = this.use(this.disks, camera);
    gl.bindVertexArray(this.diskArray);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.uniform2f(at.range, ...look.range);
    gl.uniform3f(at.background, ...look.background);
    gl.uniform3f(at.outline, ...look.outline);
    gl.uniform3f(at.missing, ...look.missing);
    gl.uniform1i(at.marks, look.marks ? 1 : 0);
    for (const copy of copies) {
      gl.uniform2f(at.shift, ...copy.shift);
      gl.uniform2f(at.lower, ...copy.lower);
      gl.uniform2f(at.upper, ...copy.upper);
      gl.uniform1f(at.fade, copy.faded ? Math.max(look.fade, 0.65) : look.fade);
      gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.count);
    }
  }
}

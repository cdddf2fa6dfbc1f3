/* gl.js: draws disks, lines and rings with WebGL2, two triangles each; circles and edges are made in the fragment shader.
 * Their numbers are rows of a texture that the vertex shader reads: one draw of many vertices is fast without a graphics card, too,
 * many instances of one square are not. */
"use strict";

const ROW_WIDTH = 2048; /* texels in a row of such a texture */

const VERTEX_GLSL = `#version 300 es
precision highp float;
precision highp int;
uniform vec2 centre, size;   /* world; canvas in pixels */
uniform float zoom;          /* pixels per unit of length */
uniform highp sampler2D rows;
vec4 place(vec2 pixels) { return vec4(2.0 * pixels / size, 0.0, 1.0); }
vec4 texel(int k) { return texelFetch(rows, ivec2(k % ${ROW_WIDTH}, k / ${ROW_WIDTH}), 0); }
vec2 corner() {
  int k = gl_VertexID % 6;
  k = k < 3 ? k : 6 - k;
  return vec2(k & 1, k >> 1) * 2.0 - 1.0;
}
`;

/* x, y, angle, value; radius, prescribed, copy */
const DISK_VERTEX = `${VERTEX_GLSL}
out vec2 p;
out float pixels, tint, pinned, faded;
out vec2 direction;
void main() {
  int row = 2 * (gl_VertexID / 6);
  vec4 a = texel(row), b = texel(row + 1);
  pixels = max(b.x * zoom, 0.75);
  p = corner() * (pixels + 1.0);
  tint = a.w;
  pinned = b.y;
  faded = b.z;
  direction = vec2(cos(a.z), sin(a.z));
  gl_Position = place((a.xy - centre) * zoom + p);
}`;

const DISK_FRAGMENT = `#version 300 es
precision highp float;
in vec2 p, direction;
in float pixels, tint, pinned, faded;
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
  fill = mix(fill, background, max(fade, 0.65 * faded));
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

/* ends; width in units, least width in pixels, 1: dashed; colour */
const LINE_VERTEX = `${VERTEX_GLSL}
uniform float unit;   /* pixels */
out vec4 tone;
out float across, half_width, along, dash;
void main() {
  int row = 3 * (gl_VertexID / 6);
  vec4 ends = texel(row), style = texel(row + 1), paint = texel(row + 2);
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

/* x, y, radius, least radius in pixels; line in pixels, opacity of the inside; colour */
const RING_VERTEX = `${VERTEX_GLSL}
out vec2 p;
out vec4 tone;
out float pixels, line, inside;
void main() {
  int row = 3 * (gl_VertexID / 6);
  vec4 circle = texel(row), style = texel(row + 1), paint = texel(row + 2);
  pixels = max(circle.z * zoom, circle.w);
  line = style.x;
  inside = style.y;
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

/* Rows of numbers in a texture, some texels each. */
class Batch {
  constructor(gl, texels) {
    this.gl = gl;
    this.stride = 4 * texels;
    this.rows = new Float32Array(4 * ROW_WIDTH);
    this.count = 0;
    this.changed = true;
    this.texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
  }

  clear() {
    this.count = 0;
    this.changed = true;
  }

  /* Room for another row; where it begins. */
  next() {
    const at = this.count++ * this.stride;
    if (at + this.stride > this.rows.length) {
      const more = new Float32Array(2 * this.rows.length);
      more.set(this.rows);
      this.rows = more;
    }
    return at;
  }

  /* A circle: three texels. */
  ring(x, y, radius, least, line, inside, red, green, blue, alpha) {
    this.add(x, y, radius, least, line, inside, 0, red, green, blue, alpha);
  }

  /* A line: three texels. */
  add(a, b, c, d, e, f, g, red, green, blue, alpha) {
    const at = this.next(), { rows } = this;
    rows[at] = a;
    rows[at + 1] = b;
    rows[at + 2] = c;
    rows[at + 3] = d;
    rows[at + 4] = e;
    rows[at + 5] = f;
    rows[at + 6] = g;
    rows[at + 8] = red;
    rows[at + 9] = green;
    rows[at + 10] = blue;
    rows[at + 11] = alpha;
  }

  draw() {
    const { gl } = this;
    if (this.count === 0) return;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    if (this.changed) {
      const high = Math.ceil((this.count * this.stride) / (4 * ROW_WIDTH));
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, ROW_WIDTH, high, 0, gl.RGBA, gl.FLOAT, this.rows.subarray(0, 4 * ROW_WIDTH * high));
      this.changed = false;
    }
    gl.drawArrays(gl.TRIANGLES, 0, 6 * this.count);
  }
}

class Renderer {
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: false, alpha: false });
    if (!gl) throw new Error("This browser does not offer WebGL2, with which the disks are drawn.");
    this.gl = gl;
    this.canvas = canvas;
    this.diskProgram = this.program(DISK_VERTEX, DISK_FRAGMENT);
    this.lineProgram = this.program(LINE_VERTEX, LINE_FRAGMENT);
    this.ringProgram = this.program(RING_VERTEX, RING_FRAGMENT);
    this.disks = new Batch(gl, 2);
    this.under = new Batch(gl, 3);
    this.forces = new Batch(gl, 3);
    this.circles = new Batch(gl, 3);
    this.marks = new Batch(gl, 3);
    this.texture = gl.createTexture();
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

  palette(name) {
    this.shown = name;
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
    gl.uniform1i(program.at.rows, 0);
    return program.at;
  }

  /* look: range, fade, marks, colours, unit of thickness in pixels. */
  draw(camera, look) {
    const gl = this.gl;
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.clearColor(...look.background, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    this.use(this.ringProgram, camera);
    this.circles.draw();
    this.drawDisks(camera, look);
    const at = this.use(this.lineProgram, camera);
    gl.uniform1f(at.unit, look.unit * camera.ratio);
    this.under.draw();
    this.forces.draw();
    this.use(this.ringProgram, camera);
    this.marks.draw();
  }

  drawDisks(camera, look) {
    const gl = this.gl, at = this.use(this.diskProgram, camera);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.activeTexture(gl.TEXTURE0);
    gl.uniform1i(at.palette, 1);
    gl.uniform2f(at.range, look.range[0], look.range[1]);
    gl.uniform3f(at.background, ...look.background);
    gl.uniform3f(at.outline, ...look.outline);
    gl.uniform3f(at.missing, ...look.missing);
    gl.uniform1i(at.marks, look.marks ? 1 : 0);
    gl.uniform1f(at.fade, look.fade);
    this.disks.draw();
  }
}

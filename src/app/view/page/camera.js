/* camera.js: which part of the plane is seen. Pixels here are CSS pixels from the canvas' upper left corner. */
"use strict";

class Camera {
  constructor() {
    this.x = this.y = 0;
    this.zoom = 1; /* pixels per unit of length */
    this.width = this.height = 1;
    this.ratio = 1; /* device pixels per CSS pixel */
  }

  toScreen(x, y) {
    return [this.width / 2 + (x - this.x) * this.zoom, this.height / 2 - (y - this.y) * this.zoom];
  }

  toWorld(px, py) {
    return [this.x + (px - this.width / 2) / this.zoom, this.y - (py - this.height / 2) / this.zoom];
  }

  /* The point under the cursor stays there. */
  zoomAt(px, py, factor) {
    const [x, y] = this.toWorld(px, py);
    this.zoom = Math.min(Math.max(this.zoom * factor, 1e-9), 1e12);
    const [nx, ny] = this.toWorld(px, py);
    this.x += x - nx;
    this.y += y - ny;
  }

  pan(dx, dy) {
    this.x -= dx / this.zoom;
    this.y += dy / this.zoom;
  }

  /* Shows a rectangle [x0, y0, x1, y1] with a margin in pixels: [left, top, right, bottom]. */
  fit(bounds, margin = [24, 24, 24, 24]) {
    const [x0, y0, x1, y1] = bounds;
    const [left, top, right, bottom] = margin;
    const width = Math.max(this.width - left - right, 20), height = Math.max(this.height - top - bottom, 20);
    const span = Math.max((x1 - x0) / width, (y1 - y0) / height);
    this.zoom = span > 0 ? 1 / span : 1;
    this.x = (x0 + x1) / 2 + (right - left) / 2 / this.zoom;
    this.y = (y0 + y1) / 2 + (top - bottom) / 2 / this.zoom;
  }
}

/* 1, 2 or 5 times a power of ten, not above a length. */
function niceLength(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  for (const digit of [5, 2]) if (digit * power <= most) return digit * power;
  return power;
}

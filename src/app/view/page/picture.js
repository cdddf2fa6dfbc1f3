/* picture.js: the picture as a PNG file, with legend, time and scale in a strip below it. */
"use strict";

const STRIP = 64; /* height of the strip, CSS pixels */

/* Draws the strip in CSS pixels, with the texts of the page's own legend. */
function drawStrip(ctx, viewer, top, width) {
  const { meta, quantity, camera } = viewer, names = quantity.kind === "names", x = 14;
  const text = (words, left, line, tone = "--text", align = "left") => {
    ctx.fillStyle = cssColor(tone);
    ctx.textAlign = align;
    ctx.fillText(words, left, top + 18 * line + 20);
  };
  ctx.font = "13px system-ui, sans-serif";
  text(byId("legend-title").textContent, x, 0);
  let left = x;
  if (names) {
    for (const item of byId("legend-names").children) {
      ctx.fillStyle = item.firstChild.style.background;
      ctx.fillRect(left, top + 29, 10, 10);
      text(item.textContent, left + 15, 1);
      left += 29 + ctx.measureText(item.textContent).width;
    }
  } else {
    const bar = 210, hues = paletteAnchors(quantity.kind === "signed" ? "diverging" : "sequential");
    const gradient = ctx.createLinearGradient(x, 0, x + bar, 0);
    hues.forEach((hex, k) => gradient.addColorStop(k / (hues.length - 1), "#" + hex));
    ctx.fillStyle = gradient;
    ctx.fillRect(x, top + 27, bar, 10);
    [...byId("legend-numbers").children].forEach((item, k) =>
      text(item.textContent, x + (bar * k) / 2, 1.9, "--text", ["left", "center", "right"][k]));
    left += bar + 24;
  }
  if (viewer.layers.forces)
    [...byId("legend-forces").children].forEach((item, k) => {
      const line = item.querySelector("i");
      text(item.textContent, left + (line ? 26 : 0), 0.95 * k, "--quiet");
      if (!line) return;
      ctx.strokeStyle = line.style.borderTopColor;
      ctx.lineWidth = 3;
      ctx.setLineDash(line.className ? [6, 3] : []);
      ctx.beginPath();
      ctx.moveTo(left, top + 15.5 + 17 * k);
      ctx.lineTo(left + 20, top + 15.5 + 17 * k);
      ctx.stroke();
    });
  text(`${meta.title || meta.source || ""}   t = ${formatNumber(viewer.frame.head.time)}`, width - x, 0, "--text", "right");
  const length = niceLength(130 / camera.zoom), end = width - x;
  text(formatNumber(length, 3), end, 1.2, "--quiet", "right");
  ctx.fillRect(end - length * camera.zoom, top + 48, length * camera.zoom, 2);
}

/* Returns a canvas with the picture as it is shown, and the strip. */
function pictureOf(viewer) {
  const { camera, renderer } = viewer, made = document.createElement("canvas"), ctx = made.getContext("2d");
  made.width = renderer.canvas.width;
  made.height = renderer.canvas.height + Math.round(STRIP * camera.ratio);
  ctx.fillStyle = cssColor("--stage");
  ctx.fillRect(0, 0, made.width, made.height);
  viewer.paint(); /* WebGL keeps what it drew until the browser shows it */
  ctx.drawImage(renderer.canvas, 0, 0);
  ctx.scale(camera.ratio, camera.ratio);
  drawStrip(ctx, viewer, camera.height, camera.width);
  return made;
}

/* Saves the picture as NAME-FRAME.png, NAME that of the file that is shown. */
function savePicture(viewer) {
  if (!viewer.frame) return;
  const stem = (viewer.meta.source || "slipdisk").replace(/^.*\//, "").replace(/\.[^.]*$/, "");
  pictureOf(viewer).toBlob((blob) => {
    const link = element("a", undefined, { href: URL.createObjectURL(blob), download: `${stem}-${viewer.player.index}.png` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  }, "image/png");
}

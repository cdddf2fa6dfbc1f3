/* palette.js: colours that stay apart for colour-blind eyes. Anchors in sRGB, equally spaced. */
"use strict";

const PALETTES = {
  /* magnitudes: viridis */
  sequential: ("440154 48186a 472d7b 424086 3b528b 33638d 2c728e 26828e 21918c 1fa088 28ae80 3fbc73 5ec962 84d44b " +
    "addc30 d8e219 fde725").split(" "),
  /* signed quantities: blue, grey, orange */
  diverging: "0b3c7d 2a62ab 5a8fcb 95b9de c9d7e4 e6e4df ecd0b0 e4ad72 d18339 ab5a13 7a3705".split(" "),
  /* names: Okabe and Ito */
  categorical: "0072b2 e69f00 009e73 cc79a7 56b4e9 d55e00 b8a900 7f7f7f".split(" "),
};

/* Colours of the picture beside those of the disks, red, green, blue. */
const THEMES = {
  light: {
    background: [1, 1, 1], outline: [0.2, 0.23, 0.26], missing: [0.8, 0.81, 0.82], wall: [0.16, 0.18, 0.2],
    edge: [0.5, 0.54, 0.58], force: [0.13, 0.15, 0.18], sliding: [0.84, 0.3, 0.02], overlap: [0.78, 0.06, 0.36],
    accent: [0.06, 0.36, 0.75], halo: [1, 1, 1],
  },
  dark: {
    background: [0.071, 0.078, 0.086], outline: [0.02, 0.025, 0.03], missing: [0.33, 0.35, 0.37], wall: [0.78, 0.81, 0.84],
    edge: [0.5, 0.54, 0.58], force: [0.88, 0.9, 0.92], sliding: [1, 0.6, 0.15], overlap: [1, 0.36, 0.62],
    accent: [0.55, 0.8, 1], halo: [0.02, 0.03, 0.04],
  },
};

function rgbOfHex(hex) {
  return [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16));
}

/* RGBA of 256 colours; a categorical palette begins anew at its end. */
function paletteBytes(name) {
  const anchors = PALETTES[name].map(rgbOfHex);
  const bytes = new Uint8Array(256 * 4);
  for (let k = 0; k < 256; k++) {
    const at = name === "categorical" ? k % anchors.length : (k / 255) * (anchors.length - 1);
    const low = Math.min(Math.floor(at), anchors.length - 1), high = Math.min(low + 1, anchors.length - 1);
    for (let c = 0; c < 3; c++)
      bytes[4 * k + c] = Math.round(anchors[low][c] + (at - low) * (anchors[high][c] - anchors[low][c]));
    bytes[4 * k + 3] = 255;
  }
  return bytes;
}

function paletteGradient(name) {
  return `linear-gradient(to right, ${PALETTES[name].map((hex) => "#" + hex).join(", ")})`;
}

function categoryColor(k) {
  return "#" + PALETTES.categorical[k % PALETTES.categorical.length];
}

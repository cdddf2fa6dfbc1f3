/* palette.js: colours that stay apart for colour-blind eyes. Anchors in sRGB, equally spaced. */
"use strict";

/* Each theme has its own, whose ends stand out from its ground (contrast 3 or more, test_viewer.py). */
const PALETTES = {
  light: {
    /* magnitudes: viridis up to 0.55 */
    sequential: "440154 471164 482173 46307e 433e85 3e4c8a 38598c 32658e 2d708e 297b8e 24868e 20928c 1e9c89".split(" "),
    /* signed quantities: blue, grey, orange */
    diverging: "0b3c7d 2a62ab 5a8fcb 95b9de c9d7e4 e6e4df ecd0b0 e4ad72 d18339 ab5a13 7a3705".split(" "),
    /* names: Okabe and Ito */
    categorical: "0072b2 e69f00 009e73 cc79a7 56b4e9 d55e00 b8a900 7f7f7f".split(" "),
  },
  dark: {
    /* magnitudes: viridis from 0.4 on */
    sequential: "2a788e 25848e 21918c 1e9c89 22a884 2fb47c 44bf70 5ec962 7ad151 9bd93c bddf26 dfe318 fde725".split(" "),
    diverging: "a6d5ff 7fb9f2 5f9cd8 4f83b8 587694 6b7178 88735a a8783f d08a3c eda557 ffc88a".split(" "),
    categorical: "0072b2 e69f00 009e73 cc79a7 56b4e9 d55e00 b8a900 7f7f7f".split(" "),
  },
};

/* Colours of the picture beside those of the disks, red, green, blue. */
const THEMES = {
  light: {
    background: [1, 1, 1], outline: [0.2, 0.23, 0.26], missing: [0.8, 0.81, 0.82], wall: [0.16, 0.18, 0.2],
    edge: [0.5, 0.54, 0.58], force: [0.13, 0.15, 0.18], sliding: [0.84, 0.3, 0.02], overlap: [0.78, 0.06, 0.36],
    accent: [0.06, 0.36, 0.75], halo: [1, 1, 1], bond: [0.0, 0.62, 0.45],
  },
  dark: {
    background: [0.071, 0.078, 0.086], outline: [0.02, 0.025, 0.03], missing: [0.33, 0.35, 0.37], wall: [0.78, 0.81, 0.84],
    edge: [0.5, 0.54, 0.58], force: [0.88, 0.9, 0.92], sliding: [1, 0.6, 0.15], overlap: [1, 0.36, 0.62],
    accent: [0.55, 0.8, 1], halo: [0.02, 0.03, 0.04], bond: [0.2, 0.8, 0.6],
  },
};

function rgbOfHex(hex) {
  return [0, 2, 4].map((k) => parseInt(hex.slice(k, k + 2), 16));
}

/* Anchors of a palette in the theme that is shown. */
function paletteAnchors(name) {
  return (PALETTES[document.documentElement.dataset.theme] ?? PALETTES.light)[name];
}

/* RGBA of 256 colours; a categorical palette begins anew at its end. */
function paletteBytes(name) {
  const anchors = paletteAnchors(name).map(rgbOfHex);
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

/* Fills the bar of a legend. */
function paintGradient(bar, name) {
  bar.dataset.palette = name;
  bar.style.background = `linear-gradient(to right, ${paletteAnchors(name).map((hex) => "#" + hex).join(", ")})`;
}

function categoryColor(k) {
  const anchors = paletteAnchors("categorical");
  return "#" + anchors[k % anchors.length];
}

/* Sets the theme, with the palettes of the picture and of the legends. */
function showTheme(theme, renderer) {
  document.documentElement.dataset.theme = theme;
  if (renderer.shown) renderer.palette(renderer.shown);
  for (const bar of document.querySelectorAll("[data-palette]")) paintGradient(bar, bar.dataset.palette);
}

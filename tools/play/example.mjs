/* example.mjs: a disk lies on two supports that turn to and fro; its mean angular velocity with an error bar.
 *
 *   tools/play.sh && node tools/play/example.mjs
 *
 * The deck is an object here; its text would do as well. */
import { deckText, load } from "../../build/play/slipdisk.mjs";

const support = { radius: 1, mass: 1, y: 0, fixed: true };
const deck = {
  title: "a disk on two supports",
  dt: 4e-6,
  gravity: { g: 10, tilt: "0.04 pi" },
  materials: [{ name: "steel", k_n: 1000, k_t: 1e6, gamma_n: 10, mu: 0.1 }],
  disks: [
    { name: "disk", x: 0, y: Math.sqrt(3), radius: 1, mass: 0.1 },
    { name: "left", x: -1, ...support },
    { name: "right", x: 1, ...support },
  ],
  motions: [{ name: "turn", disk: ["left", "right"], coordinate: "theta", type: "parabolic", amplitude: 0.04,
    omega: "20 pi" }],
};

const engine = await load();
const simulation = engine.simulation(deck);
const disk = simulation.find("disk");
const every = 250, spin = [];
for (let k = 0; k < 8000; k++) {
  simulation.advance(every);
  spin.push(simulation.view("omega")[simulation.slot(disk)]);
}
const mean = engine.mean(spin);
console.log(`t = ${simulation.time.toFixed(1)}: mean angular velocity ${mean.mean.toFixed(4)} +- ${mean.error.toFixed(4)}`);

simulation.setLaw("mu", 0.05);
simulation.set("motion.amplitude", 0.02, "turn");
simulation.advance(250000);
for (let k = 0, c = simulation.contacts(); k < c.n; k++)
  console.log(`${simulation.name(c.a[k])} on ${simulation.name(c.b[k])}: normal force ${c.normal[k].toFixed(3)}, ` +
    `tangential ${c.tangential[k].toFixed(3)}, ${c.sliding[k] ? "slides" : "sticks"}`);
console.log(`state ${simulation.hash()} after ${simulation.step} steps`);
console.log(`the deck is one of the program, too: ${deckText(deck).split("\n")[0]}`);
simulation.free();

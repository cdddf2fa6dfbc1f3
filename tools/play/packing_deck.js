/* packing_deck.js: decks of the packings: shaken box, drum, heap, sheared periodic box. */
"use strict";

const number = (value) => String(Number(value.toPrecision(5)));
const MEAN_AREA = 0.7958; /* of disks with diameters from 0.8 to 1.2, mean 1 */
const GRAINS = 'density = 1.27; sizes = "uniform"; lower = 0.4; upper = 0.6; group = "grains";';

/* Disks in three sizes rain into a box whose floor then shakes: that of inputs/packing/shake.inc.
 * Its width grows as the root of their number. SI units. */
function boxDeck(s) {
  const width = 0.4 * Math.sqrt(s.count / 60), high = 1.3 * width;
  const text = `# ${s.count} disks rain into a box, whose floor then shakes. SI units.

title = "shaken box";
seed = ${s.seed};
integrator = "verlet";
dt = 4e-5;
gravity = { g = 9.81; };

materials = ( { name = "grain"; k_n = 1e4; k_t = 5e3; gamma_n = 0.5; mu = ${number(s.mu)}; } );
container = { type = "box"; width = ${number(width)}; height = ${number(high)}; };
packings = (
  { type = "rain"; count = ${s.count}; group = "grains"; density = 3.57;
    sizes = "list"; radii = (0.015, 0.02, 0.025); speed = 1; }
);
motions = (
  { name = "shake"; wall = "floor"; coordinate = "y"; type = "harmonic";
    acceleration = ${number(s.drive)}; frequency = ${number(s.frequency)}; ramp = 0.1; }
);
phases = (
  { name = "fill";  time = 20; motions = (); settle = { kinetic = 1e-5; unbalanced = 0.2; }; },
  { name = "shake"; time = 1000; }
);
`;
  return {
    text,
    options: { every: 500, sampler: "turning", pull: 40, reach: 8 },
    scene: {
      bounds: [-0.5 * width, -0.09 * width, 0.5 * width, 0.85 * width], gravity: [0, -9.81],
    },
    plot: "root mean square of Ω (noise alone would fall as 1/√t)",
  };
}

/* A turning drum, a third full: inputs/packing/drum.cfg. Unit: mean diameter, g = 1. */
function drumDeck(s) {
  const radius = Math.sqrt((s.count * MEAN_AREA) / 0.82 / 0.4 / Math.PI);
  const text = `# ${s.count} disks in a drum that turns. Mean diameter 1, mean disk weighs 1.

title = "drum";
seed = ${s.seed};
integrator = "verlet";
dt = 1e-3;
gravity = { g = 1; };

materials = (
  { name = "grain"; k_n = 2.5e3; k_t = 1.25e3; gamma_n = 10; mu = ${number(s.mu)}; },
  { name = "rough"; k_n = 2.5e3; }
);
material_pairs = (
  { materials = ("grain", "rough"); k_n = 2.5e3; k_t = 1.25e3; gamma_n = 10; mu = 0.9; }
);
container = { type = "drum"; radius = ${number(radius)}; material = "rough"; };
packings = (
  { type = "random"; count = ${s.count}; material = "grain";
    ${GRAINS} }
);
motions = (
  { name = "turn"; wall = "drum"; coordinate = "theta"; type = "velocity";
    velocity = ${number(-s.turn)}; ramp = 5; }
);
phases = (
  { name = "fill"; time = 60; motions = (); settle = { kinetic = 1e-3; unbalanced = 0.05; }; },
  { name = "flow"; time = 1e5; }
);
`;
  const reach = 1.09 * radius;
  return {
    text,
    options: { every: 500, sampler: "kinetic", pull: 12, reach: 8 },
    scene: { bounds: [-reach, -reach, reach, reach], gravity: [0, -1] },
    plot: "kinetic energy per disk",
  };
}

/* A column of disks falls apart on a rough floor. Unit: mean diameter, g = 1. */
function heapDeck(s) {
  const width = 1.1 * Math.sqrt(s.count), high = (s.count * MEAN_AREA) / 0.42 / width;
  const half = Math.ceil(1.7 * Math.sqrt(s.count)) + 2, floor = [];
  for (let x = -half; x <= half; x++) floor.push(`(${x * 0.8}, -0.5)`);
  const rows = [];
  while (floor.length) rows.push(`    ${floor.splice(0, 8).join(", ")}`);
  const text = `# A column of ${s.count} disks falls apart. Mean diameter and weight 1.

title = "heap";
seed = ${s.seed};
integrator = "verlet";
dt = 1e-3;
gravity = { g = 1; };

materials = ( { name = "grain"; k_n = 2.5e3; k_t = 1.25e3; gamma_n = 10; mu = ${number(s.mu)}; } );

# a rough floor, with flat ground below it for all that rolls off
disk_rows = (
  { columns = [ "x", "y" ]; radius = 0.5; density = 1.27; fixed = true; group = "floor"; rows = (
${rows.join(",\n")}
  ); }
);
walls = ( { name = "ground"; type = "line"; points = ( (-1, -2.5), (1, -2.5) ); } );
packings = (
  { type = "random"; count = ${s.count}; x = (${number(-width / 2)}, ${number(width / 2)}); \
y = (0.2, ${number(high + 0.2)});
    ${GRAINS} }
);
phases = ( { name = "fall"; time = 300; } );
`;
  const side = 0.8 * half + 1;
  return {
    text,
    options: { every: 250, sampler: "kinetic", pull: 12, reach: 8 },
    scene: { bounds: [-side, -5, side, Math.max(high, 0.6 * side)], gravity: [0, -1] },
    plot: "kinetic energy per disk",
  };
}

/* Simple shear at constant area, as inputs/shear/simple.cfg, but denser. Unit: mean diameter. */
function shearDeck(s) {
  const start = Math.sqrt((s.count * MEAN_AREA) / 0.55);
  const text = `# ${s.count} disks, compressed and then sheared. Mean diameter and mass 1.

title = "sheared box";
seed = ${s.seed};
integrator = "verlet";
dt = 1e-3;

materials = ( { name = "disk"; k_n = 1e4; k_t = 5e3; mu = ${number(s.mu)}; gamma_n = 30; } );
container = { type = "periodic"; width = ${number(start)}; height = ${number(start)}; };
packings = (
  { type = "random"; count = ${s.count};
    ${GRAINS} }
);
phases = (
  { name = "compress"; time = 40; compress = { fraction = ${s.fraction}; rate = 0.02; };
    settle = { unbalanced = 1; }; },
  { name = "shear"; time = 1e4; cell = { rate_xy = ${number(s.rate)}; }; }
);
`;
  const final = Math.sqrt((s.count * MEAN_AREA) / s.fraction);
  return {
    text,
    options: { every: 200, sampler: "friction", pull: 300, reach: 6, width: start },
    scene: {
      bounds: [-1.2, -1.2, final + 1.2, final + 1.2], gravity: null,
      box: { lower: [0, 0], edges: [start, start], periodic: [true, true] },
    },
    plot: "μ = shear stress / pressure",
  };
}

const SCENES = {
  box: { name: "Shaken box", deck: boxDeck, unit: 1, quantity: "rotation", mu: 0.3 },
  drum: { name: "Drum", deck: drumDeck, unit: 10, quantity: "spin", mu: 0.5 },
  heap: { name: "Heap", deck: heapDeck, unit: 3, quantity: "rotation", mu: 0.5 },
  shear: { name: "Sheared box", deck: shearDeck, unit: 10, quantity: "rotation", mu: 0.3 },
};

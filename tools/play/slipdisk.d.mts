/* slipdisk.d.mts: types of slipdisk.mjs, the engine of slipdisk compiled to WebAssembly. It runs in
 * browsers and in Node, on one thread, with the same bits as the native program.
 *
 *   const engine = await load();
 *   const simulation = engine.simulation(deckText);
 *   simulation.advance(1000);
 *   const x = simulation.column("x");
 *
 * A simulation is made of the text of a deck (docs/deck.md). Everything that fails throws a
 * SlipdiskError, whose message holds the lines that the program would print. Units are those of the
 * deck, angles are in radians. Bodies have numbers: disks from 0, in the order of the deck, then
 * walls. Rows of columns are called slots; `slot` and the column "id" translate. */

/** A call that failed. `message` has a line for each problem. */
export class SlipdiskError extends Error {
  /** Status of the program: 2 mistake of the user, 3 a value is not finite or an overlap is too
   * large, 4 no memory or no file. */
  status: number;
  /** Each error and warning on its own. */
  messages: string[];
}

/** Compiles the engine. wasm: bytes of slipdisk.wasm; by default they are taken from the page
 * (element with id "slipdisk-wasm", base64 text) or from the file beside the module. */
export function load(wasm?: ArrayBuffer | Uint8Array): Promise<Engine>;

/** A value of a deck, as an object of JavaScript. */
export type DeckValue = number | boolean | string | DeckValue[] | { [key: string]: DeckValue };
/** Writes a deck: keys become keys, arrays lists, objects groups. The text runs in the program,
 * too. */
export function deckText(deck: { [key: string]: DeckValue }): string;

export interface DeckOptions {
  /** Settings "key=value", as after the option -D of the program. */
  set?: string[] | { [key: string]: number | boolean | string };
  /** Texts of files that the deck names (@include, disk_files, tables), by their names in the
   * deck. */
  files?: { [name: string]: string };
}

export interface Engine {
  /** Version of the engine, such as "0.4.0". */
  readonly version: string;
  /** Reads a deck, text or object, and makes a simulation at step 0. A deck without steps, time
   * and phases has no end. Throws a SlipdiskError with a line per mistake:
   * "deck:LINE: KEY = VALUE: what was expected". */
  simulation(deck: string | { [key: string]: DeckValue }, options?: DeckOptions): Simulation;
  /** Mean of evenly spaced samples and its error bar, which accounts for their correlation.
   * transient: true (default) searches a transient at the start and leaves it out. */
  mean(samples: ArrayLike<number>, transient?: boolean): Mean;
}

/** Mean of a correlated record, see docs/physics.md 9. */
export interface Mean {
  mean: number;
  /** One standard error; NaN: the record is too short to tell. */
  error: number;
  /** Integrated correlation time, number of samples. */
  correlation: number;
  used: number;
  discarded: number;
  /** True if the error bar can be trusted. */
  converged: boolean;
}

/** Mean angular velocity of a disk that the deck watches (measure.rotation). */
export interface Rotation {
  /** Number of the disk. */
  disk: number;
  /** Mean angular velocity and its standard error, rad/time; NaN: not known yet. */
  omega: number;
  error: number;
  /** The same times sqrt(2 R/g). */
  scaled: number;
  scaledError: number;
  /** Time left out as transient, time measured, angle turned in it. */
  transient: number;
  measured: number;
  turned: number;
  converged: boolean;
}

/** Energies and losses since step 0; docs/physics.md 8. */
export interface Energy {
  kinetic_translation: number;
  kinetic_rotation: number;
  elastic_normal: number;
  elastic_tangential: number;
  elastic_rolling: number;
  elastic_bond: number;
  cohesion: number;
  external: number;
  start: number;
  work: number;
  nonconservative_work: number;
  viscous: number;
  friction: number;
  rolling: number;
  bridge: number;
  opening: number;
  broken_tension: number;
  broken_shear: number;
  broken_bending: number;
  drag: number;
  damping: number;
  relaxed: number;
  /** Error of the budget, ideally 0, and the energy to which it is compared. */
  residual: number;
  scale: number;
}

/** Closed contacts, one element of each array per contact. */
export interface Contacts {
  n: number;
  /** Numbers of the two bodies; b may be a wall. */
  a: Uint32Array;
  b: Uint32Array;
  /** Point of contact, in the middle of the overlap. */
  x: Float64Array;
  y: Float64Array;
  /** Unit vector from a to b. */
  nx: Float64Array;
  ny: Float64Array;
  /** Normal force that presses the bodies together. */
  normal: Float64Array;
  /** Tangential force on b along (-ny, nx). */
  tangential: Float64Array;
  overlap: Float64Array;
  /** 1 if the contact slides, 0 if it sticks. */
  sliding: Uint8Array;
}

/** A wall at its present place. */
export interface Wall {
  /** Number of the body. */
  body: number;
  name: string;
  kind: "line" | "segment" | "polyline" | "circle" | "arc";
  /** Vertices x0, y0, x1, y1 ...; empty for a circle. A line goes on beyond its two points. */
  points: Float64Array;
  closed: boolean;
  /** Circle and arc: centre and radius. */
  center: [number, number];
  radius: number;
  /** True for a circle with the disks inside it. */
  inside: boolean;
}

export interface Stage {
  step: number;
  /** Index of the running phase; it is the number of phases when the run has ended. */
  phase: number;
  /** Steps made in this phase. */
  phaseStep: number;
  /** Steps of the preceding phase. */
  before: number;
}

export interface Simulation {
  readonly step: number;
  readonly time: number;
  readonly dt: number;
  /** True after the last step of the last phase. */
  readonly finished: boolean;
  readonly stage: Stage;
  /** Number of disks, of free disks, and of bodies, walls included. */
  readonly disks: number;
  readonly freeDisks: number;
  readonly bodies: number;
  /** The deck with all default values, as the program would run it. */
  readonly deck: string;
  /** Warnings about settings that are allowed but seldom meant. */
  readonly warnings: string[];

  /** Takes n steps, fewer at the end of the run. Throws if a value is not finite or an overlap is
   * beyond its limit; the state is then the one in which that was found. */
  advance(n: number): void;

  /** A column of the state by its name in docs/results.md: "x", "y", "theta", "turn", "vx", "vy",
   * "omega", "radius", "contact_force" ... in the order of slots. The result is a copy. Whole
   * numbers of 64 bits come as doubles. */
  column(name: string): Float64Array | Int32Array | Uint32Array;
  /** The same without a copy, in the memory of the engine: to be read at once, not kept. */
  view(name: string): Float64Array | Int32Array | Uint32Array;
  /** Angles of all bodies by slot, turn + theta. */
  angles(): Float64Array;
  /** Slot of a body; walls: number of disks + number of the wall. */
  slot(body: number): number;
  /** Number of the disk, wall or clump of this name; -1: there is none. */
  find(name: string): number;
  /** Name of a body, or one like "disk 17". */
  name(body: number): string;

  /** Sets a quantity between two steps: "x", "velocity", "held", "gravity", "law.mu",
   * "motion.amplitude" ... (sd_simulation_set in simulation.h). values: one number for all
   * indices, or one per index, two for "position" and "velocity". indices: by default 0, 1, ... for as many values;
   * names of disks and motions are allowed, too. */
  set(name: string, values: number | ArrayLike<number>,
      indices?: number | string | ArrayLike<number | string>): void;
  /** Sets a constant of the contact law for every pair of materials: setLaw("mu", 0.3). */
  setLaw(name: string, value: number): void;
  /** Present value of a quantity of `set` with one number per index; NaN: there is none. */
  get(name: string, index?: number | string): number;

  /** Pulls a free disk to a point with a spring and a dashpot, from the next step on: force
   * stiffness (point - centre) - damping velocity. The work counts as `work` of the energies. */
  grab(disk: number, x: number, y: number, stiffness: number, damping?: number): void;
  /** Ends the pull. */
  release(): void;

  /** Adds free disks and returns the number of the first. Walls get larger numbers by that. The
   * default material is the first, the default inertia m R^2/2. */
  addDisks(disks: { x: number; y: number; radius: number; mass: number; vx?: number; vy?: number;
                    omega?: number; material?: number }[]): number;
  /** Takes free disks out; they keep their numbers and rows. */
  removeDisks(disks: ArrayLike<number>): void;

  contacts(): Contacts;
  walls(): Wall[];
  energy(): Energy;
  /** Mean angular velocity of the k-th disk that the deck watches; undefined: there is none. */
  rotation(k?: number): Rotation | undefined;
  /** Hash of the whole state, 16 hexadecimal digits: equal to the attribute `hash` of /state in
   * results of the program. */
  hash(): string;
  /** Gives the memory back; the simulation cannot be used any more. */
  free(): void;
}

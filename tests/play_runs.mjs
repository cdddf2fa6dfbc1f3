/* play_runs.mjs: runs of the engine in WebAssembly for tests/program/test_play.py, which calls `outcomes` in Node and in
 * Chromium. A job is {deck, set, files, steps} and may have `then`, a list of [method, ...arguments] of the simulation that
 * are called after its steps; `ask`, a list of such calls whose results are given back. */

/* Numbers that JSON lacks become texts, arrays of all kinds lists. */
function plain(value) {
  if (typeof value === "number") return Number.isFinite(value) ? value : String(value);
  if (ArrayBuffer.isView(value) || Array.isArray(value)) return Array.from(value, plain);
  if (typeof value === "object" && value !== null) return Object.fromEntries(Object.entries(value).map(([k, v]) => [k, plain(v)]));
  return value;
}

function member(simulation, [name, ...words]) {
  const found = simulation[name];
  return typeof found === "function" ? found.apply(simulation, words) : found;
}

function outcome(engine, job) {
  let simulation;
  try {
    simulation = engine.simulation(job.deck, job);
    const began = performance.now(), first = simulation.step;
    simulation.advance(job.steps ?? 0);
    const seconds = (performance.now() - began) / 1000, steps = simulation.step - first;
    for (const call of job.then ?? []) member(simulation, call);
    const asked = (job.ask ?? []).map((call) => plain(member(simulation, call)));
    return { hash: simulation.hash(), step: simulation.step, free: simulation.freeDisks, seconds, steps, asked,
      warnings: simulation.warnings };
  } catch (error) {
    return { name: error.name, error: error.message, status: error.status, messages: error.messages };
  } finally {
    simulation?.free();
  }
}

export function outcomes(engine, jobs) {
  return jobs.map((job) => outcome(engine, job));
}

if (globalThis.process?.versions?.node) {
  const { readFileSync } = await import("node:fs");
  const { load } = await import(process.argv[2]);
  console.log(JSON.stringify(outcomes(await load(), JSON.parse(readFileSync(0, "utf8")))));
}

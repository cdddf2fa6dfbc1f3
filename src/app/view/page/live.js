/* live.js: frames of a simulation that runs, asked for at the page's own address. The last ones are kept. */
"use strict";

const LIVE_BYTES = 256e6, LIVE_FRAMES = 2000, LIVE_PAUSE = 150;

class LiveStore {
  constructor() {
    this.first = 0;
    this.frames = [];
    this.step = -1;
    this.rows = 0;
    this.bytes = 0;
    this.state = { text: "connecting", level: "wait" };
  }

  get end() {
    return this.first + this.frames.length;
  }

  time(k) {
    return this.frames[k - this.first]?.head.time;
  }

  nearest(t) {
    return this.first + nearestIndex(this.frames.map((frame) => frame.head.time), t);
  }

  now(k) {
    return this.frames[k - this.first] || null;
  }

  load(k) {
    return Promise.resolve(this.now(k));
  }

  visit(k) {
    return Promise.resolve(this.now(Math.max(k, this.first)));
  }

  prefetch() {}

  async chunk(address) {
    const answer = await fetch(address, { cache: "no-store" });
    if (answer.status === 204) return null;
    if (!answer.ok) throw new Error(`${answer.status} ${answer.statusText}`);
    return Chunk.from(new Uint8Array(await answer.arrayBuffer()));
  }

  one(name) {
    return this.chunk(name);
  }

  async takeFrame() {
    const frame = await this.chunk(`frame?after=${this.step}`);
    if (!frame) return false;
    this.step = frame.head.step;
    this.frames.push(frame);
    this.bytes += 2 * frame.size;
    while (this.frames.length > 2 && (this.bytes > LIVE_BYTES || this.frames.length > LIVE_FRAMES)) {
      this.bytes -= 2 * this.frames.shift().size;
      this.first++;
    }
    return true;
  }

  async takeSeries() {
    const rows = await this.chunk(`series?from=${this.rows}`);
    if (rows) this.rows = (rows.head.from ?? this.rows) + rows.get("time").length;
    return rows;
  }

  /* Asks for ever: frame() after a new one, series(chunk) after new rows, tell(state) when the state changes. */
  async follow(frame, series, tell) {
    let silent = 0, asked = 0;
    for (;;) {
      try {
        const fresh = await this.takeFrame();
        if (fresh) frame();
        if (performance.now() - asked > 1000) {
          asked = performance.now();
          const rows = await this.takeSeries();
          if (rows) series(rows);
          const answer = await fetch("status", { cache: "no-store" });
          this.setState(this.describe(await answer.json()), tell);
        }
        silent = 0;
      } catch (error) {
        silent++;
        if (!this.finished) this.setState({ text: "no connection: the program has ended, or was stopped", level: "lost" }, tell);
      }
      await new Promise((resolve) => setTimeout(resolve, LIVE_PAUSE * Math.min(1 + silent * silent, 40)));
    }
  }

  describe(status) {
    this.finished = Boolean(status.finished || status.stopped);
    const done = status.steps > 0 ? `, ${Math.floor((100 * status.step) / status.steps)} %` : "";
    const phase = status.phase ? ` · ${status.phase}` : "";
    if (status.stopped && !status.finished) return { text: `stopped at step ${status.step}${done}`, level: "done" };
    if (status.finished) return { text: `the run has ended: ${status.step} steps`, level: "done" };
    return { text: `running${phase} · step ${status.step}${done}`, level: "run" };
  }

  setState(state, tell) {
    if (state.text === this.state.text) return;
    this.state = state;
    tell(state);
  }
}

/* session.js: the engine as the page sees it: a worker that runs decks and sends frames. */
"use strict";

/* Columns of one frame, as the viewer's scene reads them. */
class LiveFrame {
  constructor(message) {
    this.head = message.head;
    this.columns = message.columns;
  }

  has(name) {
    return this.columns[name] !== undefined;
  }

  get(name) {
    return this.columns[name] ?? null;
  }

  at(name, k) {
    return this.columns[name]?.[k] ?? NaN;
  }
}

class Session {
  /* told: {started, frame, failed}, called with messages of the worker. */
  constructor(told) {
    this.told = told;
    this.number = 0;
    this.running = true;
    this.reached = [];
    const text = byId("slipdisk-engine").textContent;
    const address = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
    this.worker = new Worker(address);
    this.worker.onmessage = ({ data }) => this.take(data);
    this.worker.onerror = (event) =>
      this.told.failed({ text: event.message || "The worker does not start." });
    const wasm = bytesOfBase64(byId("slipdisk-wasm").textContent);
    this.worker.postMessage({ kind: "load", wasm }, [wasm.buffer]);
  }

  take(message) {
    const { number = this.number } = message;
    if (number !== this.number) return; /* of an earlier run */
    if (message.kind === "reached") this.reached.shift()?.(message);
    else this.told[message.kind](message);
  }

  post(kind, values) {
    this.worker.postMessage({ kind, ...values });
  }

  start(deck, options) {
    this.number++;
    this.post("start", { deck, options, number: this.number });
    this.post("running", { running: this.running });
  }

  setRunning(running) {
    this.running = running;
    this.post("running", { running });
  }

  setSpeed(speed) {
    this.post("speed", { speed });
  }

  step(n) {
    this.running = false;
    this.post("steps", { n });
  }

  /* Goes to a step and stops there: a promise of {step, hash}. */
  until(step) {
    this.running = false;
    return new Promise((resolve) => {
      this.reached.push(resolve);
      this.post("until", { step });
    });
  }

  grab(disk, x, y) {
    this.post("grab", { disk, x, y });
  }

  release() {
    this.post("release", {});
  }

  drawn() {
    this.post("drawn", {});
  }
}

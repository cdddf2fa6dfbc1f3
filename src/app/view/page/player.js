/* player.js: which frame is shown, and when. */
"use strict";

const RATES = [1, 2, 5, 10, 25, 50, 100];

class Player {
  /* show(k, frame) draws; change() tells the controls. */
  constructor(store, show, change) {
    Object.assign(this, { store, show, change });
    this.index = -1;
    this.playing = false;
    this.loop = true;
    this.rate = 25;
    this.wanted = -1;
    this.shownAt = []; /* when the last frames were drawn, to measure the rate */
  }

  /* Shows frame k as soon as it is decoded; a later wish replaces an earlier one. */
  go(k) {
    this.arriving = this.arrive(k);
    return this.arriving;
  }

  async arrive(k) {
    const target = Math.min(Math.max(k, this.store.first), this.store.end - 1);
    if (this.store.end <= this.store.first) return;
    this.wanted = target;
    const frame = this.store.now(target) || (await this.store.load(target));
    if (this.wanted !== target || !frame) return;
    const stride = target < this.index ? -1 : 1;
    this.index = target;
    this.shownAt.push(performance.now());
    if (this.shownAt.length > 60) this.shownAt.shift();
    this.show(target, frame);
    this.store.prefetch(target, stride, this.playing ? 8 : 2);
    this.change();
  }

  step(n) {
    this.stop();
    return this.go((this.wanted >= 0 ? this.wanted : this.index) + n);
  }

  toggle() {
    if (this.playing) this.stop();
    else this.play();
  }

  play() {
    if (this.store.end - this.store.first < 2) return;
    this.playing = true;
    this.shownAt = [];
    this.start(this.index >= this.store.end - 1 ? this.store.first : this.index);
    this.change();
    requestAnimationFrame((now) => this.tick(now));
  }

  stop() {
    this.playing = false;
    this.change();
  }

  start(k) {
    this.from = k;
    this.since = performance.now();
    this.ahead = 0;
  }

  setRate(rate) {
    this.rate = rate;
    if (this.playing) this.start(this.index);
    this.change();
  }

  /* Frames follow the clock; those that cannot be decoded in time are left out. */
  async tick(now) {
    if (!this.playing) return;
    let target = this.from + Math.floor(((now - this.since) * this.rate) / 1000);
    if (target >= this.store.end) {
      if (this.loop) this.start((target = this.store.first));
      else {
        this.stop();
        target = this.store.end - 1;
      }
    }
    if (target !== this.index) await this.go(target);
    requestAnimationFrame((later) => this.tick(later));
  }

  /* Frames drawn per second, of late. */
  get drawnRate() {
    const n = this.shownAt.length;
    return n > 1 ? (1000 * (n - 1)) / (this.shownAt[n - 1] - this.shownAt[0]) : 0;
  }
}

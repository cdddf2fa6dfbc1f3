/* model.js: what stays the same in all frames: names, radii, walls. */
"use strict";

class Model {
  constructor(meta, fixed) {
    this.meta = meta;
    this.fixed = fixed;
    this.disks = meta.disks;
    this.walls = meta.walls || [];
    this.firstTime = 0;
    const radius = fixed.get("radius");
    let sum = 0;
    for (const r of radius) sum += r;
    this.meanRadius = radius.length ? sum / radius.length : 1;
    this.groupNames = this.names(meta.groups, "group", "group");
    this.materialNames = this.names(meta.materials, "material", "material");
  }

  /* Names by number, made up where the deck gives none. */
  names(given, column, word) {
    let count = given?.length ?? 0;
    for (const k of this.column(column) || []) if (k >= count) count = k + 1;
    return Array.from({ length: count }, (_, k) => given?.[k] ?? `${word} ${k}`);
  }

  column(name) {
    return this.fixed.get(name);
  }

  bodyName(body) {
    if (body >= this.disks) return this.walls[body - this.disks]?.name ?? `wall ${body - this.disks}`;
    return this.meta.disk_names?.[body] ?? `disk ${body}`;
  }

  /* Number of the disk with this number or name; -1: there is none. */
  find(text) {
    const word = text.trim().replace(/^disk\s+/i, "");
    const named = this.meta.disk_names ? this.meta.disk_names.indexOf(word) : -1;
    if (named >= 0) return named;
    return /^\d+$/.test(word) && Number(word) < this.disks ? Number(word) : -1;
  }

  phaseAt(time) {
    const phases = this.meta.phases || [];
    return phases.find((p) => time <= p.to * (1 + 1e-12)) || phases[phases.length - 1];
  }
}

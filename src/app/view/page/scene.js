/* scene.js: what a frame looks like: walls, box, contacts, marks; geometry of contacts. */
"use strict";

const TURN_TICKS = 12; /* marks on a round wall that show its turning */
const FAR_PART = 0.01; /* of the disks at either end of an axis, which may be far from the others */

/* Pose of wall w in a frame, and its points in the plane. */
function wallPose(model, frame, w) {
  const wall = model.walls[w], scale = frame.head.scale ?? 1;
  const x = frame.at("wall_x", w), y = frame.at("wall_y", w), angle = frame.at("wall_angle", w) || 0;
  const c = Math.cos(angle) * scale, s = Math.sin(angle) * scale;
  return { x, y, angle, points: wall.points.map(([px, py]) => [x + c * px - s * py, y + s * px + c * py]) };
}

/* Nearest point to (x, y) of the line through a and b; endless or between them. */
function nearestOnLine(a, b, x, y, endless) {
  const dx = b[0] - a[0], dy = b[1] - a[1], square = dx * dx + dy * dy;
  let t = square > 0 ? ((x - a[0]) * dx + (y - a[1]) * dy) / square : 0;
  if (!endless) t = Math.min(Math.max(t, 0), 1);
  return [a[0] + t * dx, a[1] + t * dy];
}

/* Where a disk at (x, y) touches a wall. */
function wallContact(wall, pose, part, x, y) {
  if (wall.kind === "circle") {
    const dx = x - pose.x, dy = y - pose.y, away = Math.hypot(dx, dy) || 1;
    return [pose.x + (dx / away) * wall.radius, pose.y + (dy / away) * wall.radius];
  }
  const n = pose.points.length, k = Math.min(part, n - 1);
  if (wall.kind === "arc") { /* its points lie close together; parts: first end, curve, last end, or thirds of a ring */
    const first = pose.points[0], last = pose.points[n - 1], away = ([px, py]) => Math.hypot(px - x, py - y);
    const ring = Math.hypot(last[0] - first[0], last[1] - first[1]) < 1e-6 * wall.radius;
    if (part !== 1 && !ring) return part ? last : first;
    const feet = pose.points.slice(1).map((b, i) => nearestOnLine(pose.points[i], b, x, y, false));
    return feet.reduce((a, b) => (away(b) < away(a) ? b : a));
  }
  return nearestOnLine(pose.points[k], pose.points[(k + 1) % n], x, y, wall.kind === "line");
}

class Scene {
  constructor(model, renderer) {
    this.model = model;
    this.renderer = renderer;
  }

  /* Lower corner and edges of the periodic box in a frame; offset: how far images above are shifted. */
  box(frame) {
    const box = this.model.meta.box || { lower: [0, 0], edges: [0, 0], periodic: [false, false] };
    const { lower = box.lower, edges = box.edges, offset = 0 } = frame?.head ?? {};
    return { lower, edges, offset, periodic: box.periodic };
  }

  /* Difference b - a, through periodic edges where that is nearer. */
  between(box, ax, ay, bx, by) {
    let dx = bx - ax, dy = by - ay;
    const rows = box.periodic[1] ? Math.round(dy / box.edges[1]) : 0;
    dx -= box.offset * rows;
    dy -= box.edges[1] * rows;
    if (box.periodic[0]) dx -= box.edges[0] * Math.round(dx / box.edges[0]);
    return [dx, dy];
  }

  poses(frame) {
    if (!frame.has("wall_x")) return [];
    return this.model.walls.map((_, w) => wallPose(this.model, frame, w));
  }

  /* The part to show: along an axis where few disks make it half as long again, without these. */
  view(frames, whole) {
    const all = this.bounds(frames, 0), most = whole ? all : this.bounds(frames, FAR_PART);
    const far = (k) => all[k + 2] - all[k] > 1.5 * (most[k + 2] - most[k]);
    return all.map((value, k) => (far(k % 2) ? most[k] : value));
  }

  /* Rectangle around all that is to be seen in some frames: disks in play, box, walls where they stand at first.
     A part of the disks at either end of an axis is left out. */
  bounds(frames, part) {
    const parts = frames.map((frame, k) => this.boundsOf(frame, k === 0, part));
    const extreme = (k) => (k < 2 ? Math.min : Math.max)(...parts.map((part) => part[k]));
    return [0, 1, 2, 3].map(extreme);
  }

  boundsOf(frame, withWalls, part) {
    const all = [Infinity, Infinity, -Infinity, -Infinity];
    const grow = (x, y, r) => {
      if (!Number.isFinite(x + y)) return;
      all[0] = Math.min(all[0], x - r);
      all[1] = Math.min(all[1], y - r);
      all[2] = Math.max(all[2], x + r);
      all[3] = Math.max(all[3], y + r);
    };
    const x = frame.get("x"), y = frame.get("y"), radius = this.model.column("radius"), activity = frame.get("activity");
    const seen = [...x.keys()].filter((k) => (!activity || activity[k] === 0 || activity[k] === 4) && Number.isFinite(x[k] + y[k]));
    const [x0, x1] = middle(seen.map((k) => x[k]), part), [y0, y1] = middle(seen.map((k) => y[k]), part);
    for (const k of seen) if (x[k] >= x0 && x[k] <= x1 && y[k] >= y0 && y[k] <= y1) grow(x[k], y[k], radius[k]);
    this.poses(frame).forEach((pose, w) => {
      const wall = this.model.walls[w];
      if (!withWalls) return;
      if (wall.kind === "circle") grow(pose.x, pose.y, wall.radius);
      else if (wall.kind === "line") growAcross(grow, all, pose.points);
      else for (const [px, py] of pose.points) grow(px, py, 0);
    });
    const box = this.box(frame), [lx, ly] = box.lower, [ex, ey] = box.edges;
    if (box.periodic[0]) [lx, lx + ex].forEach((px) => grow(px, (all[1] + all[3]) / 2, 0));
    if (box.periodic[1]) [ly, ly + ey].forEach((py) => grow((all[0] + all[2]) / 2, py, 0));
    if (all[0] > all[2]) return [-1, -1, 1, 1];
    return all;
  }

  /* Lines of walls and box, which may reach as far as is seen. */
  buildFixed(frame, camera, theme) {
    this.renderer.under.clear();
    this.renderer.circles.clear();
    this.buildBox(this.box(frame), camera, theme);
    this.poses(frame).forEach((pose, w) => this.buildWall(this.model.walls[w], pose, camera, theme));
  }

  /* Contacts and marks: the same for every camera. */
  buildContacts(frame, layers, theme) {
    this.renderer.forces.clear();
    this.renderer.marks.clear();
    const box = this.box(frame), poses = this.poses(frame);
    if (frame.has("contact_a")) {
      if (layers.forces) this.buildForces(frame, box, poses, layers, theme);
      if (layers.overlaps) this.buildOverlaps(frame, box, poses, layers, theme);
    }
    this.buildMarks(frame, layers, theme);
  }

  buildBox(box, camera, theme) {
    const [lx, ly] = box.lower, [ex, ey] = box.edges;
    const reach = this.reach(camera);
    const y0 = box.periodic[1] ? ly : reach[1], y1 = box.periodic[1] ? ly + ey : reach[3];
    const x0 = box.periodic[0] ? lx : reach[0], x1 = box.periodic[0] ? lx + ex : reach[2];
    const line = (ax, ay, bx, by) => this.renderer.under.add(ax, ay, bx, by, 0, 1.25, 1, ...theme.edge, 1);
    if (box.periodic[0]) [lx, lx + ex].forEach((x) => line(x, y0, x, y1));
    if (box.periodic[1]) [ly, ly + ey].forEach((y) => line(x0, y, x1, y));
  }

  /* Rectangle that is seen. */
  reach(camera) {
    const [x0, y1] = camera.toWorld(0, 0), [x1, y0] = camera.toWorld(camera.width, camera.height);
    return [x0, y0, x1, y1];
  }

  buildWall(wall, pose, camera, theme) {
    const line = (a, b, width) => this.renderer.under.add(...a, ...b, 0, width, 0, ...theme.wall, 1);
    if (wall.kind === "circle") {
      const { x, y } = pose, r = wall.radius, tick = wall.inside ? 1.035 : 0.9;
      this.renderer.circles.ring(x, y, r, 2, 2.5, wall.inside ? 0 : 0.25, ...theme.wall, 1);
      const n = wall.inside ? TURN_TICKS : 1;
      for (let k = 0; k < n; k++) {
        const a = pose.angle + (2 * Math.PI * k) / n, c = Math.cos(a) * r, s = Math.sin(a) * r;
        const far = k === 0 && wall.inside ? 1.07 : tick, near = wall.inside ? 1 : 0;
        line([x + c * near, y + s * near], [x + c * far, y + s * far], k === 0 ? 3 : 1.5);
      }
      return;
    }
    const n = pose.points.length;
    if (wall.kind === "line" && n > 1) {
      const [a, b] = pose.points, dx = b[0] - a[0], dy = b[1] - a[1], size = Math.hypot(dx, dy) || 1;
      const [cx, cy] = nearestOnLine(a, b, camera.x, camera.y, true);
      const long = (camera.width + camera.height) / camera.zoom;
      line([cx - (dx / size) * long, cy - (dy / size) * long], [cx + (dx / size) * long, cy + (dy / size) * long], 2.5);
      return;
    }
    for (let k = 0; k + 1 < n + (wall.closed ? 1 : 0); k++) line(pose.points[k], pose.points[(k + 1) % n], 2.5);
  }

  /* A line per contact: between centres, or from the centre to the wall; as thick as its normal force. Bonds have a bar behind it. */
  buildForces(frame, box, poses, layers, theme) {
    const a = frame.get("contact_a"), b = frame.get("contact_b"), part = frame.get("contact_part");
    const force = frame.get("contact_force"), sliding = frame.get("contact_sliding"), bond = frame.get("contact_bond");
    const x = frame.get("x"), y = frame.get("y"), n = this.model.disks;
    const { forces } = this.renderer;
    for (let k = 0; k < a.length; k++) {
      const ax = x[a[k]], ay = y[a[k]];
      let dx, dy;
      if (b[k] < n) {
        [dx, dy] = this.between(box, ax, ay, x[b[k]], y[b[k]]);
      } else {
        const [px, py] = wallContact(this.model.walls[b[k] - n], poses[b[k] - n], part[k], ax, ay);
        [dx, dy] = this.between(box, ax, ay, px, py);
      }
      const slides = sliding && sliding[k] !== 0, tone = slides ? theme.sliding : theme.force;
      if (bond && bond[k] > 0) forces.add(ax, ay, ax + dx, ay + dy, 0.8, 2, 0, ...theme.bond, 1);
      const width = Math.min(force[k] / layers.forceScale, 2.5);
      forces.add(ax, ay, ax + dx, ay + dy, width, slides ? 1.2 : 0.7, slides ? 1 : 0, ...tone, 1);
    }
  }

  /* A ring and a dot at every overlap that counts. */
  buildOverlaps(frame, box, poses, layers, theme) {
    const a = frame.get("contact_a"), b = frame.get("contact_b"), part = frame.get("contact_part");
    const overlap = frame.get("contact_overlap"), radius = this.model.column("radius");
    const x = frame.get("x"), y = frame.get("y"), n = this.model.disks;
    for (let k = 0; k < a.length; k++) {
      if (!(overlap[k] > layers.overlapLimit * radius[a[k]])) continue;
      const ax = x[a[k]], ay = y[a[k]];
      let px, py;
      if (b[k] < n) {
        const [dx, dy] = this.between(box, ax, ay, x[b[k]], y[b[k]]), away = Math.hypot(dx, dy) || 1;
        const deep = (radius[a[k]] - overlap[k] / 2) / away;
        [px, py] = [ax + dx * deep, ay + dy * deep];
      } else {
        [px, py] = wallContact(this.model.walls[b[k] - n], poses[b[k] - n], part[k], ax, ay);
      }
      this.renderer.marks.ring(px, py, overlap[k] / 2, 5, 2, 0.35, ...theme.overlap, 1);
    }
  }

  /* Rings around the selected disk and those that a message names. */
  buildMarks(frame, layers, theme) {
    const radius = this.model.column("radius");
    const ring = (k, tone, line) => this.renderer.marks.ring(frame.at("x", k), frame.at("y", k), radius[k], 4, line, 0, ...tone, 1);
    for (const k of layers.highlighted) ring(k, theme.overlap, 2.5);
    if (layers.selected >= 0) {
      ring(layers.selected, theme.halo, 5.5);
      ring(layers.selected, theme.accent, 3);
    }
  }

  /* Overlaps that count, the deepest first: [{a, b, overlap, part of the radius}]. */
  overlaps(frame, limit) {
    const a = frame.get("contact_a") || [], b = frame.get("contact_b"), overlap = frame.get("contact_overlap");
    const radius = this.model.column("radius"), found = [];
    for (let k = 0; k < a.length; k++) {
      const small = b[k] < this.model.disks ? Math.min(radius[a[k]], radius[b[k]]) : radius[a[k]];
      if (overlap[k] > limit * small) found.push({ a: a[k], b: b[k], overlap: overlap[k], part: overlap[k] / small });
    }
    return found.sort((p, q) => q.part - p.part);
  }

  /* Rows of the disks in play with their values; behind them copies across periodic edges, within a margin. */
  buildDisks(frame, values, copies) {
    const { disks } = this.renderer, { model } = this, x = frame.get("x"), y = frame.get("y"), turned = frame.get("turned");
    const activity = frame.get("activity"), radius = model.column("radius"), angle = model.column("angle"), driven = model.column("driven");
    const put = (k, px, py, copy) => {
      const at = disks.next(), { rows } = disks, turn = (angle ? angle[k] : 0) + (turned ? turned[k] : 0);
      rows[at] = px;
      rows[at + 1] = py;
      rows[at + 2] = turn - 2 * Math.PI * Math.round(turn / (2 * Math.PI));
      rows[at + 3] = values[k];
      rows[at + 4] = radius[k];
      rows[at + 5] = driven ? driven[k] : 0;
      rows[at + 6] = copy;
    };
    const hidden = (k) => activity && (activity[k] === 1 || activity[k] === 2);
    disks.clear();
    for (let k = 0; k < x.length; k++) if (!hidden(k)) put(k, x[k], y[k], 0);
    const box = this.box(frame), margin = 2 * model.meanRadius;
    if (!copies || !(box.periodic[0] || box.periodic[1])) return;
    for (let k = 0; k < x.length; k++) {
      if (hidden(k)) continue;
      for (const j of shifts(box, 1, y[k], radius[k] + margin)) {
        const across = x[k] + j * box.offset;
        for (const i of shifts(box, 0, across, radius[k] + margin))
          if (i !== 0 || j !== 0) put(k, across + i * box.edges[0], y[k] + j * box.edges[1], 1);
      }
    }
  }

  /* The disk under a point of the plane, or near it by some pixels; -1: none. */
  pick(frame, x, y, reach) {
    const px = frame.get("x"), py = frame.get("y"), radius = this.model.column("radius"), activity = frame.get("activity");
    let best = -1, least = reach;
    for (let k = px.length - 1; k >= 0; k--) {
      if (activity && (activity[k] === 1 || activity[k] === 2)) continue;
      const away = Math.hypot(px[k] - x, py[k] - y) - radius[k];
      if (away < least) [best, least] = [k, away];
    }
    return best;
  }
}

/* Multiples of an edge by which a copy of something at `at` comes near the box. */
function shifts(box, axis, at, reach) {
  if (!box.periodic[axis]) return [0];
  const low = box.lower[axis], edge = box.edges[axis], high = low + edge, home = Math.floor((at - low) / edge), list = [-home];
  if (at - home * edge + reach > high) list.push(-home - 1);
  if (at - home * edge - reach < low) list.push(-home + 1);
  return list;
}

/* Least and greatest value without a part of them at either end. */
function middle(values, part) {
  const sorted = Float64Array.from(values).sort(), left = Math.round(part * values.length);
  return [sorted[left], sorted[values.length - 1 - left]];
}

/* An endless line counts in the direction across it only. */
function growAcross(grow, all, [a, b]) {
  const x = Number.isFinite(all[0]) ? (all[0] + all[2]) / 2 : a[0], y = Number.isFinite(all[1]) ? (all[1] + all[3]) / 2 : a[1];
  grow(...nearestOnLine(a, b, x, y, true), 0);
}

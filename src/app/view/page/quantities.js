/* quantities.js: quantities that colour the disks. */
"use strict";

const NO_VALUE = NaN; /* drawn grey */

/* Per disk: something of every contact of a frame. */
function perDisk(model, frame, start, add) {
  const values = new Float32Array(model.disks).fill(start);
  const a = frame.get("contact_a"), b = frame.get("contact_b");
  for (let k = 0; k < a.length; k++) {
    values[a[k]] = add(values[a[k]], k, a[k]);
    if (b[k] < model.disks) values[b[k]] = add(values[b[k]], k, b[k]);
  }
  return values;
}

/* kind: signed (symmetric range), magnitude, count (from 0), names. values(model, frame) is a value per disk, or null. */
const QUANTITIES = [
  {
    key: "spin", label: "Spin", symbol: "ω", unit: "rad/time", kind: "signed",
    values: (model, frame) => frame.get("spin"),
  },
  {
    key: "rotation", label: "Mean rotation", symbol: "Ω", unit: "rad/time", kind: "signed",
    hint: "angle turned since the first frame, over the time since then",
    values(model, frame) {
      const time = frame.head.time - model.firstTime, turned = frame.get("turned");
      return time > 0 ? turned.map((angle) => angle / time) : new Float32Array(turned.length);
    },
  },
  {
    key: "omega", label: "Measured Ω", symbol: "Ω", unit: "rad/time", kind: "signed", constant: true,
    hint: "mean rotation of the measured time, from the file",
    values: (model) => model.column("omega"),
  },
  {
    key: "turned", label: "Angle turned", symbol: "Δθ", unit: "rad", kind: "signed",
    values: (model, frame) => frame.get("turned"),
  },
  {
    key: "speed", label: "Speed", symbol: "|v|", unit: "length/time", kind: "magnitude",
    values(model, frame) {
      const vx = frame.get("vx"), vy = frame.get("vy");
      return vx && vx.map((v, k) => Math.hypot(v, vy[k]));
    },
  },
  {
    key: "contacts", label: "Contacts", symbol: "z", unit: "", kind: "count", needs: "contacts",
    values: (model, frame) => (frame.has("contact_a") ? perDisk(model, frame, 0, (sum) => sum + 1) : null),
  },
  {
    key: "force", label: "Largest force", symbol: "Fₙ", unit: "force", kind: "magnitude", needs: "contacts",
    values(model, frame) {
      const force = frame.get("contact_force");
      return force && perDisk(model, frame, 0, (most, k) => Math.max(most, force[k]));
    },
  },
  {
    key: "overlap", label: "Overlap / radius", symbol: "δ/R", unit: "", kind: "magnitude", needs: "contacts",
    values(model, frame) {
      const overlap = frame.get("contact_overlap"), radius = model.column("radius");
      return overlap && perDisk(model, frame, 0, (most, k, disk) => Math.max(most, overlap[k] / radius[disk]));
    },
  },
  {
    key: "radius", label: "Radius", symbol: "R", unit: "length", kind: "magnitude", constant: true,
    values: (model) => model.column("radius"),
  },
  {
    key: "group", label: "Group", kind: "names", constant: true,
    names: (model) => model.groupNames,
    values: (model) => model.column("group"),
  },
  {
    key: "material", label: "Material", kind: "names", constant: true,
    names: (model) => model.materialNames,
    values: (model) => model.column("material"),
  },
  {
    key: "activity", label: "State", kind: "names",
    names: () => ["in play", "waiting", "removed", "outside", "held"],
    values: (model, frame) => frame.get("activity") || new Uint8Array(model.disks),
  },
];

/* The quantities that these data have. */
function quantitiesOf(model) {
  return QUANTITIES.filter((q) => {
    if (q.key === "omega") return model.column("omega") !== null;
    if (q.key === "group") return model.groupNames.length > 1;
    if (q.key === "material") return model.materialNames.length > 1;
    if (model.meta.kind === "deck") return !["rotation", "turned"].includes(q.key);
    return true;
  });
}

/* Range of values for the colour bar, and whether some are beyond it: two per cent are, since few fast disks would hide the rest. */
function rangeOf(quantity, lists) {
  if (quantity.kind === "names") return [0, 256];
  const all = [];
  for (const list of lists) {
    if (!list) continue;
    const stride = Math.max(1, Math.floor(list.length / 20000));
    for (let k = 0; k < list.length; k += stride) {
      const value = quantity.kind === "signed" ? Math.abs(list[k]) : list[k];
      if (Number.isFinite(value)) all.push(value);
    }
  }
  if (all.length === 0) return quantity.kind === "signed" ? [-1, 1] : [0, 1];
  const sorted = Float64Array.from(all).sort();
  const last = sorted[sorted.length - 1], least = sorted[0];
  const most = sorted[sorted.length - 1 - Math.floor(sorted.length * 0.02)] || last;
  if (quantity.kind === "signed") return most > 0 ? [-most, most, last > most] : [-1, 1];
  if (quantity.kind === "count") return [0, Math.max(1, last)];
  if (quantity.constant) return last > least ? [least, last] : [0.9 * least, 1.1 * last || 1];
  return most > 0 ? [0, most, last > most] : [0, 1];
}

/* settings.js: sliders and choices, their values, and the address that holds them. */
"use strict";

/* Rows of a list of {key, label, hint, value, show} with
 * options: [[value, text], ...], or min, max, step, or min, max, log (ratios are even). text: what
 * stands beside the slider. changed(values) follows every change. */
class Settings {
  constructor(place, rows, changed) {
    this.rows = rows;
    this.changed = changed;
    this.values = Object.fromEntries(rows.map((row) => [row.key, row.value]));
    for (const row of rows) place.append(this.build(row));
    this.read();
    this.refresh();
    addEventListener("hashchange", () => {
      if (location.hash.slice(1) === this.address()) return;
      this.read();
      this.refresh();
      this.changed(this.values);
    });
  }

  build(row) {
    const label = element("label", undefined, { class: "setting", title: row.hint ?? "" });
    const name = element("span", row.label);
    row.place = label;
    if (row.options) {
      row.input = element("select", undefined, { id: `set-${row.key}` });
      for (const [value, text] of row.options) row.input.append(element("option", text, { value }));
      const chosen = () => this.optionOf(row, row.input.value);
      row.input.addEventListener("change", () => this.take(row, chosen()));
      label.append(name, row.input);
      return label;
    }
    const { min, max, step } = row;
    const range = row.log ? { min: 0, max: 1000, step: 1 } : { min, max, step };
    row.input = element("input", undefined, { type: "range", id: `set-${row.key}`, ...range });
    row.output = element("output", "", { for: `set-${row.key}` });
    row.input.addEventListener("input", () => this.take(row, this.valueOf(row)));
    label.append(name, row.input, row.output);
    return label;
  }

  optionOf(row, text) {
    return row.options.find(([value]) => String(value) === text)?.[0] ?? row.value;
  }

  valueOf(row) {
    const at = Number(row.input.value);
    if (!row.log) return Number(at.toPrecision(6));
    return Number((row.min * (row.max / row.min) ** (at / 1000)).toPrecision(2));
  }

  take(row, value) {
    this.values[row.key] = value;
    this.apply();
  }

  /* Several values at once: those of a preset. */
  set(values) {
    Object.assign(this.values, values);
    this.apply();
  }

  apply() {
    this.refresh();
    try {
      history.replaceState(null, "", `#${this.address()}`);
    } catch { /* some browsers keep the address of a file */ }
    this.changed(this.values);
  }

  refresh() {
    for (const row of this.rows) {
      const value = this.values[row.key];
      row.place.hidden = row.show ? !row.show(this.values) : false;
      if (row.options) {
        row.input.value = String(value);
        continue;
      }
      const at = row.log ? (1000 * Math.log(value / row.min)) / Math.log(row.max / row.min) : value;
      if (this.valueOf(row) !== value) row.input.value = String(at);
      row.output.textContent = row.text ? row.text(value) : formatNumber(value, 4);
      row.input.setAttribute("aria-valuetext", row.output.textContent);
    }
  }

  /* The settings that differ from the first ones, as in key=value&key=value. */
  address() {
    const changed = this.rows.filter((row) => this.values[row.key] !== row.value);
    return changed.map((row) => `${row.key}=${encodeURIComponent(this.values[row.key])}`).join("&");
  }

  /* Takes the settings of the address; values beyond their range are left out. */
  read() {
    const given = new URLSearchParams(location.hash.slice(1));
    for (const row of this.rows) {
      const text = given.get(row.key);
      this.values[row.key] = row.value;
      if (text === null) continue;
      const number = Number(text);
      if (row.options) this.values[row.key] = this.optionOf(row, text);
      else if (text !== "" && number >= row.min && number <= row.max) this.values[row.key] = number;
    }
  }
}

#!/usr/bin/env python3
"""Runs what docs/validation.md and docs/studies/checks.md report about the 3-disk ratchet, and prints its tables.

    tools/validate.py [--program build/release/slipdisk] [--out build/validation] [TABLE ...]

Tables: random, step, seeds, turning, limit, tilt, steady, still, epo; all when none is named (about 15
minutes on one core). Each run is a deck of inputs/ with overrides; the command is kept beside its result as
NAME.txt. Runs that are finished are not repeated. Needs python3 with h5py and numpy.
"""
import argparse
import math
import os
import sys

import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
sys.path.insert(0, os.path.join(ROOT, "tools", "python"))
import slipdisk  # noqa: E402

PI = math.pi


class Runner:
    def __init__(self, program, out):
        self.program, self.out = program, out
        os.makedirs(out, exist_ok=True)

    def run(self, name, deck, **overrides):
        """Runs a deck unless its result is there; returns what `slipdisk info --json` says of it."""
        path = os.path.join(self.out, name + ".h5")
        command = [self.program, "run", os.path.join(ROOT, "inputs", deck), "-o", path, "--quiet"]
        for key, value in overrides.items():
            command += ["-D", f"{key}={value}"]
        note = os.path.join(self.out, name + ".txt")
        text = " ".join(f"'{word}'" if any(c in word for c in " [(*") else word for word in command)
        done = os.path.exists(path) and os.path.exists(note) and open(note).read().strip() == text
        if not done:
            try:  # what is in doubt is warned of
                slipdisk.run(command[2], path, overrides, force=True, program=self.program)
            except slipdisk.Error as error:
                sys.exit(f"{text}\n{error}")
            with open(note, "w") as file:
                file.write(text + "\n")
        return {**slipdisk.info(path, self.program), "path": path}


# --- theory: limits of strong drive, in units of Theta_b w_b --------------------------------------------------
def tep(tilt, s1, s2, mu=0.1, half=PI / 6):
    """(15) to (18) for m g = R = 1."""
    phi = math.atan(mu)
    if s1 == s2:
        return math.sin(s1 * phi) * math.cos(tilt - s1 * phi) / math.cos(half)
    return s1 * math.sin(phi) * math.sin(tilt) / math.sin(half + s1 * phi)


def theory(opposite, wave, tilt, mu=0.1):
    if not opposite:
        z = mu * math.tan(tilt)
        return 4 / PI * z if wave == "parabolic" else math.sin(PI / 2 * z)  # (30), and its form for a sine
    cross = abs(tep(tilt, 1, -1) + tep(tilt, -1, 1))
    x = cross / (2 * tep(tilt, 1 if tilt > 0 else -1, 1 if tilt > 0 else -1) * math.copysign(1, tilt) + cross)
    return -math.copysign(4 / PI * x if wave == "parabolic" else math.sin(PI / 2 * x), tilt)


def table(title, head, rows):
    print(f"\n### {title}\n")
    print("| " + " | ".join(head) + " |")
    print("|" + "---|" * len(head))
    for row in rows:
        print("| " + " | ".join(row) + " |", flush=True)


# --- random vibration -----------------------------------------------------------------------------------------
def vibrate(r, tilt, dt, time=500, seed=1, integrator="gear5"):
    return r.run(f"random_{tilt}_{dt}_{time}_{seed}_{integrator}", "three_disk/random.cfg", **{
        "gravity.tilt": f"{tilt} pi", "dt": dt, "seed": seed, "integrator": integrator,
        "phases.settle.steps": round(1 / dt), "phases.measure.steps": round(time / dt),
        "phases.measure.series": round(time / dt / 1000)})


def vibrated_row(d, *first):
    q, s, e = d["rotation"][0], d["sliding"][0], d["energy"]
    sliding = sum(s[k] for k in ("S++", "S+-", "S-+", "S--"))
    return [*first, f"{1e4 * q['omega']:.3f} ± {1e4 * q['error']:.3f}", f"{q['omega'] / q['error']:.1f}",
            f"{1e4 * q['scaled']:.3f}", f"{q['transient']:.1f}",
            " ".join(f"{s[k]:.3f}" for k in ("S++", "S+-", "S-+", "S--")), f"{sliding:.3f}",
            " ".join(f"{c['force_min']:.3f}" for c in s["contacts"]), str(sum(c["openings"] for c in s["contacts"])),
            f"{abs(e['residual'] / e['scale']):.0e}"]


VIBRATED = ["10^4 Omega", "in errors", "10^4 t_g Omega", "transient", "S++ S+- S-+ S--", "both slide",
            "least F_n left, right", "openings", "residual"]


def random(r):
    rows = [vibrated_row(vibrate(r, tilt, 1e-6), f"{tilt} pi") for tilt in (0.04, 0, -0.04)]
    table("Random vibration, eps_b = 1e-4, dt = 1e-6, 5e8 steps, seed 1", ["tilt"] + VIBRATED, rows)


def step(r):
    rows = [vibrated_row(vibrate(r, 0.04, dt, integrator=name), name, f"{dt:g}")
            for name in ("gear5", "verlet") for dt in (2e-5, 1e-5, 5e-6, 2e-6, 1e-6)]
    table("Random vibration, tilt 0.04 pi, time 500: time step", ["integrator", "dt"] + VIBRATED, rows)


def seeds(r):
    for tilt in (0.04, 0):
        runs = [vibrate(r, tilt, 1e-5, seed=seed) for seed in range(1, 9)]
        table(f"Random vibration, tilt {tilt} pi, dt = 1e-5, 5e7 steps: seeds", ["seed"] + VIBRATED,
              [vibrated_row(d, str(k + 1)) for k, d in enumerate(runs)])
        omega = np.array([d["rotation"][0]["omega"] for d in runs])
        error = np.array([d["rotation"][0]["error"] for d in runs])
        mean, scatter = omega.mean(), omega.std(ddof=1)
        print(f"\nmean {1e4 * mean:.3f} ± {1e4 * scatter / math.sqrt(len(runs)):.3f} (from the scatter); scatter "
              f"{1e4 * scatter:.3f}, mean error bar {1e4 * error.mean():.3f}; "
              f"sum of ((Omega - mean)/error)^2 = {(((omega - mean) / error) ** 2).sum():.1f} for 7 degrees")


# --- supports that turn to and fro ----------------------------------------------------------------------------
def turn(r, opposite, wave, amplitude, w, dt=1e-5, tilt=0.04, time=None, integrator="gear5", k_n=1e3):
    """Mean over the last period, from both sides of the theory's value; w in units of pi."""
    aim = theory(opposite, wave, tilt * PI)
    unit = amplitude * w * PI
    period = round(2 / w / dt)
    half = round((time or max(6, 15 * amplitude * w)) * w / 4)
    ends = []
    for k, start in enumerate((0.93, 1.07)):
        name = f"{'async' if opposite else 'sync'}_{wave}_{amplitude}_{w}_{dt}_{tilt}_{integrator}_{k_n:g}_{k}"
        d = r.run(name, "three_disk/async.cfg" if opposite else "three_disk/sync.cfg", **{
            "motions[*].amplitude": amplitude, "motions[*].omega": f"{w} pi", "motions[*].type": wave,
            "gravity.tilt": f"{tilt} pi", "dt": dt, "integrator": integrator,
            "materials[0].k_n": k_n, "materials[0].gamma_n": 10 * math.sqrt(k_n / 1e3),
            "disks[0].omega": start * aim * unit, "phases.rest.motions": "(0, 1)" if opposite else "(0)",
            "phases.rest.steps": period * half, "phases.measure.steps": period * half,
            "phases.measure.series": period})
        angle = slipdisk.Result(d["path"]).series["angle"][:, 0]
        ends.append((angle[-1] - angle[-2]) / (period * dt * unit))
    return {"aim": aim, "omega": sum(ends) / 2, "error": abs(ends[0] - ends[1]) / 2, "info": d,
            "periods": 2 * half}


def turned_row(t, *first):
    s, e = t["info"]["sliding"][0], t["info"]["energy"]
    return [*first, f"{t['omega']:.6f} ± {t['error']:.0e}", f"{t['aim']:.6f}",
            f"{100 * (t['omega'] / t['aim'] - 1):+.2f} %", " ".join(f"{s[k]:.4f}" for k in ("S++", "S+-", "S-+", "S--")),
            f"{s['stick']:.4f}", " ".join(f"{c['force_min']:.3f}" for c in s["contacts"]),
            f"{abs(e['residual'] / e['scale']):.0e}"]


TURNED = ["Omega/(Theta_b w_b)", "limit of theory", "off by", "S++ S+- S-+ S--", "stick", "least F_n left, right",
          "residual"]


def turning(r):
    for opposite, name in ((False, "in phase"), (True, "opposite")):
        rows = [turned_row(turn(r, opposite, wave, a, 20), wave, f"{a:g}") for wave in ("parabolic", "harmonic")
                for a in (0.1, 0.07, 0.04, 0.01, 0.007, 0.004, 0.001)]
        table(f"Supports {name}, w_b = 20 pi, tilt 0.04 pi, the paper's stiffness", ["wave", "Theta_b"] + TURNED, rows)
        rows = [turned_row(turn(r, opposite, "parabolic", 0.04, 20, dt, integrator=i), i, f"{dt:g}")
                for i in ("gear5", "verlet") for dt in (2e-5, 1e-5, 5e-6, 2e-6, 1e-6)]
        table(f"Supports {name}, Theta_b = 0.04: time step", ["integrator", "dt"] + TURNED, rows)


def limit(r):
    for opposite, name in ((False, "in phase"), (True, "opposite")):
        rows = [turned_row(turn(r, opposite, "parabolic", f / w, w), f"{f / w:g}", f"{w:g} pi", f"{f:g} pi")
                for f in (0.8, 3.2, 12.8) for w in (20, 10, 5, 2.5)]
        table(f"Supports {name}, parabola: slower and stronger", ["Theta_b", "w_b", "Theta_b w_b"] + TURNED, rows)
        rows = [turned_row(turn(r, opposite, wave, 0.04, 20, k_n=k), wave, f"{k:g}")
                for wave in ("parabolic", "harmonic") for k in (1e3, 4e3, 1e4, 1e5)]
        table(f"Supports {name}, Theta_b = 0.04, w_b = 20 pi: stiffer at the same damping ratio", ["wave", "k_n"] + TURNED,
              rows)


def tilt(r):
    for opposite, name in ((False, "in phase"), (True, "opposite")):
        rows = [turned_row(turn(r, opposite, "parabolic", 0.1, 20, tilt=a), f"{a} pi") for a in (-0.04, 0.02, 0.04, 0.06, 0.08)]
        table(f"Supports {name}, Theta_b = 0.1: tilt", ["tilt"] + TURNED, rows)


# --- torques, and what must not turn --------------------------------------------------------------------------
def steady(r):
    rows = []
    for tilt_ in (0.04, 0.08):
        for s1, s2 in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            d = r.run(f"steady_{tilt_}_{s1}_{s2}", "three_disk/steady.cfg", **{
                "gravity.tilt": f"{tilt_} pi", "motions.left.velocity": -s1, "motions.right.velocity": -s2})
            result = slipdisk.Result(d["path"])
            torque, force = result.state["torque"][0], result.contacts["force"][-2:]
            aim, e = tep(tilt_ * PI, s1, s2), d["energy"]
            rows.append([f"{tilt_} pi", f"S{'+-'[s1 < 0]}{'+-'[s2 < 0]}", f"{torque:.6f}", f"{aim:.6f}",
                         f"{100 * (torque / aim - 1):+.2f} %", " ".join(f"{x:.5f}" for x in force),
                         f"{abs(e['residual'] / e['scale']):.0e}"])
    table("Steady rotation of the supports", ["tilt", "", "torque", "(15)-(18)", "off by", "F_n left, right", "residual"], rows)


def still(r):
    rows = []
    cases = [("centre frozen, supports turn", "frozen", {"phases.settle.steps": 10**7, "disks[0].omega": 0.02}),
             ("the same, spun the other way", "frozen", {"phases.settle.steps": 10**7, "disks[0].omega": -0.02}),
             ("centre frozen, random", "frozen", {"motions.turn.type": "random", "motions.turn.amplitude": 1e-4,
                                                  "phases.measure.steps": 10**8}),
             ("weak, turning, Theta_b = 1e-8", "weak", {}),
             ("weak, random, eps_b = 1e-9", "random", {"motions[*].amplitude": 1e-9, "phases.measure.steps": 10**8})]
    for k, (name, deck, overrides) in enumerate(cases):
        d = r.run(f"still_{k}", f"three_disk/{deck}.cfg", **overrides)
        q, s, e = d["rotation"][0], d["sliding"][0], d["energy"]
        rows.append([name, f"{q['turned'] / q['measured']:.1e}", f"{q['omega']:.1e} ± {q['error']:.0e}", f"{s['stick']:.4f}",
                     " ".join(f"{c['force_min']:.3f}" for c in s["contacts"]), f"{e['residual']:.0e}",
                     f"{abs(e['residual'] / e['scale']):.0e}"])
    table("No rotation", ["run", "turned/time", "Omega", "stick", "least F_n left, right", "residual", "relative"], rows)


def epo(r):
    rows = []
    for wave in ("harmonic", "random"):
        for force in (0, 0.02, -0.02, 0.05):
            over = {"disks.block.force": f"({force}, 0)", "phases.measure.frames": 10**5}
            if wave == "random":
                over.update({"motions[0].type": "random", "motions[0].amplitude": 0.01, "phases.measure.steps": 5 * 10**7})
            else:
                over["phases.measure.steps"] = 2 * 10**7
            d = r.run(f"epo_{wave}_{force}", "epo/asymmetric.cfg", **over)
            x = slipdisk.Result(d["path"]).frames["position"][:, 0, 0]
            x = x[len(x) // 4:]  # the first quarter is transient
            v = np.diff(x) / 0.1
            blocks = v[:len(v) // 10 * 10].reshape(10, -1).mean(axis=1)
            aim = 0.2 * PI * math.sin(PI / 2 * force / 0.1)
            e = d["energy"]
            rows.append([wave, str(force), f"{v.mean():.6f} ± {blocks.std(ddof=1) / math.sqrt(10):.0e}",
                         f"{aim:.6f}" if wave == "harmonic" else "", f"{abs(e['residual'] / e['scale']):.0e}"])
    table("Elasto-plastic oscillator: drift velocity", ["drive", "f", "velocity", "permanent sliding", "residual"], rows)


TABLES = {f.__name__: f for f in (steady, still, epo, turning, limit, tilt, seeds, random, step)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=os.path.join(ROOT, "build", "release", "slipdisk"))
    parser.add_argument("--out", default=os.path.join(ROOT, "build", "validation"))
    parser.add_argument("tables", nargs="*", choices=[*TABLES, []], metavar="TABLE")
    args = parser.parse_args()
    runner = Runner(args.program, args.out)
    for name in args.tables or TABLES:
        TABLES[name](runner)


if __name__ == "__main__":
    main()

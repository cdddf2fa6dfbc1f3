"""slipdisk theory: values against formulas written down here once more, tables against each other, messages for decks
that are something else."""
import csv
import io
import json
import math
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(os.environ.get("SLIPDISK_SOURCE_DIR", pathlib.Path(__file__).resolve().parents[2]))
PROGRAM = os.environ.get("SLIPDISK_PROGRAM", str(ROOT / "build/release/slipdisk"))
THREE = ROOT / "inputs/three_disk"
MU, HALF, INERTIA, W_B = 0.1, math.pi / 6, 0.05, 20 * math.pi
TILT = 0.04 * math.pi
SIGNS = {"++": (1, 1), "+-": (1, -1), "-+": (-1, 1), "--": (-1, -1)}


def theory(deck, *words, status=0):
    done = subprocess.run([PROGRAM, "theory", str(deck), *map(str, words)], capture_output=True, text=True, timeout=600)
    assert done.returncode == status, f"status {done.returncode}: {done.stderr}"
    return done


def facts(deck, *words, status=0):
    return json.loads(theory(deck, "--json", *words, status=status).stdout)


def table(text):
    return list(csv.DictReader(io.StringIO(text)))


def balance(s1, s2, tilt=TILT, half=HALF, mu=MU, weight=1.0):
    """(13), (14) at rest with tau_i = s_i mu n_i: the normal forces."""
    a1, a2 = half - tilt, half + tilt
    matrix = [[math.sin(a1) + s1 * mu * math.cos(a1), -math.sin(a2) + s2 * mu * math.cos(a2)],
              [math.cos(a1) - s1 * mu * math.sin(a1), math.cos(a2) + s2 * mu * math.sin(a2)]]
    return np.linalg.solve(matrix, [0, weight])


def torques(tilt=TILT, half=HALF, mu=MU, weight=1.0, radius=1.0):
    """(15)-(18) as printed."""
    c, s, ch, sh, m = math.cos(tilt), math.sin(tilt), math.cos(half), math.sin(half), weight * radius * mu
    return {"++": m * (c + mu * s) / ((1 + mu * mu) * ch), "--": -m * (c - mu * s) / ((1 + mu * mu) * ch),
            "+-": m * s / (sh + mu * ch), "-+": -m * s / (sh - mu * ch)}


def support(waveform, amplitude, t, phase):
    """-theta'(t), (20) or (22)."""
    u = W_B * t + phase
    if waveform == "sine":
        return -amplitude * W_B * np.cos(u)
    v = np.abs((u + math.pi) % (2 * math.pi) - math.pi)
    return -4 / math.pi * amplitude * W_B * (1 - 2 * v / math.pi)


def stepped(waveform, amplitude, phase, periods=40, steps=4000):
    """Mean and fractions of I dOmega/dt = T(signs) after many small steps."""
    period = 2 * math.pi / W_B
    dt = period / steps
    t = (np.arange(steps) + 0.5) * dt
    w1 = support(waveform, amplitude, t, 0).tolist()
    w2 = support(waveform, amplitude, t, phase).tolist()
    kick = {s: torque / INERTIA * dt for s, torque in torques().items()}
    kick = [[kick["--"], kick["-+"]], [kick["+-"], kick["++"]]]
    omega = 0.0
    for _ in range(periods):
        total, count = 0.0, [[0, 0], [0, 0]]
        for a, b in zip(w1, w2):
            i, j = a > omega, b > omega
            change = kick[i][j]
            total += omega + change / 2
            omega += change
            count[i][j] += 1
    parts = {"++": count[1][1], "+-": count[1][0], "-+": count[0][1], "--": count[0][0]}
    return total / steps, {s: n / steps for s, n in parts.items()}


class Base(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="slipdisk-theory-"))

    def tearDown(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def near(self, value, expected, tolerance, what=""):
        self.assertLessEqual(abs(value - expected), tolerance, f"{what}: {value!r}, expected {expected!r}")


class Values(Base):
    def test_geometry_and_torques(self):
        for deck in ("sync", "random", "steady"):
            for tilt in (0, 0.02, 0.08):
                f = facts(THREE / f"{deck}.cfg", "-D", f"gravity.tilt={tilt} pi")
                g = f["geometry"]
                self.near(g["tilt"], tilt * math.pi, 1e-14)
                self.near(g["half_aperture"], HALF, 1e-14)
                self.near(g["alpha"][0], HALF - tilt * math.pi, 1e-14)
                self.near(g["t_g"], 1 / math.sqrt(5), 1e-14)
                self.near(g["inertia"], INERTIA, 1e-16)
                for t in f["tep"]:
                    s = t["configuration"]
                    n = balance(*SIGNS[s], tilt * math.pi)
                    self.near(t["normal"][0], n[0], 1e-13, s)
                    self.near(t["normal"][1], n[1], 1e-13, s)
                    expected = torques(tilt * math.pi)[s]
                    self.near(t["torque"], expected, 1e-14, s)
                    self.near(t["closed"], expected, 1e-14, s)
                    self.assertTrue(t["stable"] and t["compressive"])
                every = torques(tilt * math.pi)
                slight = f["formulas"]["slight_tilt"]
                self.near(slight["all"], sum(every.values()) / 4, 1e-15, "(19)")
                self.near(slight["sync"], (every["++"] + every["--"]) / 2, 1e-15, "(31)")

    def test_turned_system_other_radii_and_order(self):
        """The same three disks, turned as a whole: gravity stays, the supports move round. Radii differ."""
        radius, left, right, mass = 0.7, 0.5, 1.1, 0.3
        alpha = (0.3, 0.55)
        for turn in (0, 0.4, -1.0, math.pi - 0.01):
            down = (-math.sin(turn), -math.cos(turn))  # gravity.tilt = turn
            across = (-down[1], down[0])
            place = []
            for a, r, side in ((alpha[0], left, -1), (alpha[1], right, 1)):
                d = radius + r
                place.append([2 + d * (math.cos(a) * down[k] + side * math.sin(a) * across[k]) for k in (0, 1)])
            deck = self.folder / "turned.cfg"
            deck.write_text(f"""
              dt = 1e-6; steps = 10; gravity = {{ g = 9.81; tilt = {turn!r}; }};
              materials = ( {{ name = "m"; k_n = 1e3; k_t = 1e6; mu = 0.07; }} );
              disks = ( {{ name = "r"; x = {place[1][0]!r}; y = {place[1][1]!r}; radius = {right}; mass = 1; fixed = true; }},
                        {{ name = "u"; x = 2.001; y = 2.0; radius = {radius}; mass = {mass}; }},
                        {{ name = "l"; x = {place[0][0]!r}; y = {place[0][1]!r}; radius = {left}; mass = 1; fixed = true; }} );
              motions = ( {{ disk = ["l", "r"]; coordinate = "theta"; type = "harmonic"; amplitude = 0.1; omega = 50; }} );
              """)
            f = facts(deck, "-D", "max_overlap=0.9")
            g = f["geometry"]
            self.near(g["alpha"][0], alpha[0], 1e-12)
            self.near(g["alpha"][1], alpha[1], 1e-12)
            self.assertEqual(g["supports"], ['disk "l"', 'disk "r"'])
            self.assertTrue(g["swapped"])
            self.assertEqual(g["support_radius"], [left, right])
            self.near(g["offset"], 0.001, 1e-12)
            tilt, half = (alpha[1] - alpha[0]) / 2, (alpha[1] + alpha[0]) / 2
            expected = torques(tilt, half, 0.07, mass * 9.81, radius)
            for t in f["tep"]:
                self.near(t["torque"], expected[t["configuration"]], 1e-13)
            self.assertFalse(f["drive"]["even"])  # other radii: other speeds of the surfaces
            self.assertIsNone(f["formulas"]["first_order"])
            self.near(f["drive"]["amplitude"], 0.1 * right / radius, 1e-14)
            self.assertAlmostEqual(sum(f["solution"]["durations"].values()) + f["solution"]["stuck"], 2 * math.pi / 50)

    def test_in_phase(self):
        for amplitude in (0.0012, 0.04):
            f = facts(THREE / "sync.cfg", "-D", f"motions.turn.amplitude={amplitude}")
            t, p = torques(), f["formulas"]["sync"]
            scale, period = amplitude * W_B, 2 * math.pi / W_B
            self.assertEqual((f["drive"]["relation"], f["drive"]["waveform"]), ("in phase", "parabola"))
            # the print's mR^2 is 0.1
            common = math.pi * t["++"] / (4 * 0.1 * amplitude * (t["++"] - t["--"]) * W_B**3)
            self.near(p["t1"], common * (math.pi**2 * t["--"] - 4 * 0.1 * amplitude * W_B**2), 1e-13, "(25)")
            self.near(p["t2"], common * (math.pi**2 * t["--"] + 4 * 0.1 * amplitude * W_B**2), 1e-13, "(43)")
            self.near(p["++"], -t["--"] / (t["++"] - t["--"]) * period, 1e-14, "(26)")
            self.near(p["--"], t["++"] / (t["++"] - t["--"]) * period, 1e-14, "(27)")
            mean = 4 * MU * scale * math.tan(TILT) / math.pi
            self.near(p["mean"], mean, 1e-13, "(29)")
            self.near(f["formulas"]["first_order"], mean, 1e-13, "(30)")
            self.near(f["formulas"]["limit"], mean, 1e-12, "limit")
            s = f["solution"]
            self.near(s["mean"], mean, 1e-12, "exact")
            self.near(s["mean_normalised"], mean / scale, 1e-12)
            self.near(s["mean_scaled"], mean / math.sqrt(5), 1e-12)
            self.near(s["durations"]["++"], p["++"], 1e-13)
            self.near(f["drive"]["ratio"], t["++"] / (INERTIA * amplitude * W_B**2), 1e-12)
            f = facts(THREE / "sync.cfg", "-D", f"motions.turn.amplitude={amplitude}", "-D", "motions.turn.type=harmonic")
            h, cap = math.pi * t["++"] / (t["++"] - t["--"]), math.sin(math.pi / 2 * MU * math.tan(TILT))
            q = h * t["--"] / (INERTIA * amplitude * W_B**2 * math.sin(h))
            self.near(f["formulas"]["limit"], scale * cap, 1e-12, "limit of the sine")
            self.near(f["formulas"]["sine"], scale * cap * math.sqrt(1 - q * q), 1e-12, "sine")
            self.near(f["solution"]["mean"], scale * cap * math.sqrt(1 - q * q), 1e-12, "sine")

    def test_opposite(self):
        for waveform, kind, factor in (("parabola", "parabolic", 1), ("sine", "harmonic", math.pi**2 / 8)):
            f = facts(THREE / "async.cfg", "-D", f"motions[*].type={kind}")
            t, scale, c = torques(), 0.04 * W_B, math.cos(HALF)
            printed = 8 * MU * (MU**2 + 1) * 0.04 * TILT * c * c / ((MU**2 + 1) * math.cos(2 * HALF) + MU**2 - 1)
            self.near(f["formulas"]["first_order"], factor * printed * W_B / math.pi, 1e-12, "(35)")
            x = -(t["+-"] + t["-+"]) / (2 * t["++"] - t["+-"] - t["-+"])
            limit = -4 / math.pi * x if kind == "parabolic" else -math.sin(math.pi / 2 * x)
            self.near(f["formulas"]["limit"], limit * scale, 1e-12, "limit")
            self.assertEqual((f["drive"]["relation"], f["drive"]["waveform"]), ("opposite", waveform))
            self.near(f["formulas"]["reversal_phase"], 0.2425 * math.pi, 1e-12)

    def test_periodic_solution_is_where_small_steps_end(self):
        for amplitude, waveform, kind, phase in ((0.003, "sine", "harmonic", 1.0), (0.003, "parabola", "parabolic", math.pi)):
            mean, parts = stepped(waveform, amplitude, phase)
            f = facts(THREE / "async.cfg", "-D", f"motions[*].type={kind}", "-D", f"motions[*].amplitude={amplitude}",
                      "-D", f"motions.turn_right.phase={phase!r}")
            s = f["solution"]
            self.assertTrue(s["permanent"])
            self.near(s["mean"] / (amplitude * W_B), mean / (amplitude * W_B), 5e-4)
            for name, part in parts.items():
                self.near(s["durations"][name] / s["period"], part, 1.5e-3, name)

    def test_motions_that_begin_at_different_times(self):
        """Half a period later is half a period of phase; a negative amplitude too."""
        same = facts(THREE / "sync.cfg")["solution"]["mean"]
        deck = (THREE / "async.cfg").read_text()
        deck = deck.replace("motions = []; },", 'motions = []; },\n{ name = "wait"; steps = 5e4; motions = ["turn_left"]; },')
        (self.folder / "late.cfg").write_text(deck)
        f = facts(self.folder / "late.cfg")
        self.assertEqual(f["drive"]["relation"], "in phase")
        self.near(f["solution"]["mean"], same, 1e-9)
        f = facts(THREE / "async.cfg", "-D", "motions.turn_right.amplitude=-0.04")
        self.assertEqual(f["drive"]["relation"], "in phase")
        self.near(f["solution"]["mean"], same, 1e-9)

    def test_steady_and_random(self):
        for s, (s1, s2) in SIGNS.items():
            f = facts(THREE / "steady.cfg", "-D", f"motions.left.velocity={-s1}", "-D", f"motions.right.velocity={-s2}")
            self.assertEqual(f["drive"]["signs"], [s1, s2])
            self.near(f["drive"]["torque"], torques()[s], 1e-14)
        # a disk that can turn: S-+ slows it down to the lower one of the supports' velocities
        free = self.folder / "free.cfg"
        free.write_text((THREE / "steady.cfg").read_text().replace("locks =", "#"))
        f = facts(free, "-D", "motions.left.velocity=2")
        self.assertEqual((f["drive"]["signs"], f["drive"]["final"]), ([-1, 1], -2))
        for tilt, sign in ((0.04, -1), (-0.04, 1), (0, 0)):
            f = facts(THREE / "random.cfg", "-D", f"gravity.tilt={tilt} pi")
            self.assertEqual((f["drive"]["kind"], f["drive"]["sign"]), ("random", sign))
        f = facts(THREE / "random.cfg", "-D", "motions[0].coordinate=theta", "-D", "motions[0].independent=false")
        self.assertEqual((f["drive"]["shared"], f["drive"]["sign"]), (True, 1))
        f = facts(THREE / "sync.cfg", "-D", "motions.turn.amplitude=0")
        self.assertEqual(f["drive"]["kind"], "rest")

    def test_page(self):
        page = theory(THREE / "sync.cfg").stdout
        for words in ("0.11485818", "(15)", "compressive, stable", "(19)", "(31)", "in phase", "(25), (43)", "0.040425401",
                      "permanent sliding", "0.49368353", "0.2425 pi"):
            self.assertIn(words, page)
        page = theory(THREE / "async.cfg").stdout
        self.assertIn("opposite phases", page)
        self.assertIn("-0.04997938", page)
        self.assertIn("-0.04775628", page)
        self.assertIn("NOT permanent", theory(THREE / "weak.cfg").stdout)
        self.assertIn("is no good", theory(THREE / "weak.cfg").stdout)
        self.assertIn("negative (clockwise)", theory(THREE / "random.cfg").stdout)
        self.assertIn("configuration S++", theory(THREE / "steady.cfg").stdout)


class Tables(Base):
    def test_wave(self):
        cases = [("sync.cfg", []), ("async.cfg", []), ("async.cfg", ["-D", "motions[*].amplitude=0.001"]),
                 ("async.cfg", ["-D", "motions[*].type=harmonic", "-D", "motions.turn_right.phase=1.0"]),
                 ("sync.cfg", ["-D", "motions.turn.phase=0.7", "-D", "motions.turn.type=harmonic"])]
        for deck, words in cases:
            f = facts(THREE / deck, *words)
            path = self.folder / "wave.csv"
            self.assertEqual(theory(THREE / deck, *words, "--wave", path).stdout, "")
            rows = table(path.read_text())
            s, d = f["solution"], f["drive"]
            t, omega = (np.array([float(r[k]) for r in rows]) for k in ("t", "Omega"))
            corners = [p["start"] for p in s["pieces"][1:]]
            self.assertEqual(len(rows), 2001 + sum(abs(c / s["period"] * 2000 - round(c / s["period"] * 2000)) > 1e-6
                                                   for c in corners))
            self.assertTrue((np.diff(t) > 0).all())
            self.near(t[-1], s["period"], 1e-15)
            self.near(((omega[1:] + omega[:-1]) / 2 * np.diff(t)).sum() / s["period"], s["mean"],
                      1e-12 * d["amplitude"] * W_B, "mean of Omega")
            self.near(omega[0], omega[-1], 1e-12)
            for i in (0, 1):
                w = np.array([float(r[f"support{i + 1}"]) for r in rows])
                self.assertLess(abs(w - support(d["waveform"], d["amplitudes"][i], t, d["phases"][i])).max(), 1e-11)
                angle = np.array([float(r[f"theta{i + 1}"]) for r in rows])
                turned = np.concatenate(([0], np.cumsum((w[1:] + w[:-1]) / 2 * np.diff(t))))
                self.assertLess(abs(angle - angle[0] + turned).max(), 1e-5 * d["amplitudes"][i])
                # signs of sliding, away from the corners
                for row, v, o in zip(rows, w, omega):
                    if abs(v - o) > 1e-9:
                        self.assertEqual(row["configuration"][i], "+" if v > o else "-")
            spent = {k: 0.0 for k in SIGNS}
            for row, length in zip(rows, np.diff(t)):
                spent[row["configuration"]] += length
            for name, time in spent.items():
                self.near(time, s["durations"][name], 1e-12, name)

    def test_wave_with_sticking(self):
        words = ["-D", "motions[*].amplitude=4e-4", "-D", "motions.turn_right.phase=2"]
        f = facts(THREE / "async.cfg", *words)
        rows = table(theory(THREE / "async.cfg", *words, "--wave", "-").stdout)
        self.assertFalse(f["solution"]["permanent"])
        self.assertIn("stuck", {r["configuration"] for r in rows})
        t, omega = (np.array([float(r[k]) for r in rows]) for k in ("t", "Omega"))
        self.near(((omega[1:] + omega[:-1]) / 2 * np.diff(t)).sum() / t[-1], f["solution"]["mean"], 1e-9)

    def test_single_row(self):
        row, = table(theory(THREE / "async.cfg", "--csv", "-").stdout)
        f = facts(THREE / "async.cfg")
        s, t = f["solution"], torques()
        expected = {"tilt": TILT, "half_aperture": HALF, "mu": MU, "torque_pp": t["++"], "torque_pm": t["+-"],
                    "torque_mp": t["-+"], "torque_mm": t["--"], "slight_tilt": sum(t.values()) / 4,
                    "slight_tilt_sync": (t["++"] + t["--"]) / 2, "amplitude": 0.04, "omega": W_B, "phase": math.pi,
                    "mean": s["mean"], "mean_scaled": s["mean_scaled"], "mean_normalised": s["mean_normalised"],
                    "first_order": f["formulas"]["first_order"], "limit": f["formulas"]["limit"],
                    "pp": s["durations"]["++"] / s["period"], "pm": s["durations"]["+-"] / s["period"],
                    "mp": s["durations"]["-+"] / s["period"], "mm": s["durations"]["--"] / s["period"],
                    "stuck": 0, "permanent": 1}
        for name, signs in zip(("pp", "pm", "mp", "mm"), ((1, 1), (1, -1), (-1, 1), (-1, -1))):
            a, (s1, s2) = (HALF - TILT, HALF + TILT), signs
            balance = [[math.sin(a[0]) + s1 * MU * math.cos(a[0]), -math.sin(a[1]) + s2 * MU * math.cos(a[1])],
                       [math.cos(a[0]) - s1 * MU * math.sin(a[0]), math.cos(a[1]) + s2 * MU * math.sin(a[1])]]
            expected[f"normal_1_{name}"], expected[f"normal_2_{name}"] = np.linalg.solve(balance, [0, 1])
        self.assertEqual(set(row), {"set", "name"} | set(expected))
        self.assertEqual(row["set"], "0")
        for name, value in expected.items():
            self.near(float(row[name]), value, 1e-13 * (1 + abs(value)), name)

    def test_rows_of_a_sweep(self):
        deck = (THREE / "async.cfg").read_text() + """
          sweep = { replicas = 3; parameters = (
            { path = "motions[*].type"; name = "wave"; values = ("parabolic", "harmonic"); },
            { path = "motions[*].amplitude"; name = "theta_b"; values = (0.001, 0.04); },
            { path = "gravity.tilt"; values = (0, "0.04 pi"); } ); };"""
        (self.folder / "s.cfg").write_text(deck)
        path = self.folder / "s.csv"
        theory(self.folder / "s.cfg", "--csv", path)
        rows = table(path.read_text())
        self.assertEqual([r["set"] for r in rows], [str(k) for k in range(8)])
        self.assertEqual(len({r["name"] for r in rows}), 8)
        for r in rows:
            f = facts(self.folder / "s.cfg", "-D", f"motions[*].type={r['wave']}", "-D",
                      f"motions[*].amplitude={r['theta_b']}", "-D", f"gravity.tilt={r['tilt']}")
            self.near(float(r["theory_tilt"]), float(r["tilt"]), 1e-14)  # the sweep has this name already
            self.near(float(r["mean"]), f["solution"]["mean"], 1e-12)
            self.near(float(r["first_order"]), f["formulas"]["first_order"], 1e-12)
        self.assertIn("its sweep of 24 points", theory(self.folder / "s.cfg").stdout)

    def test_cells_that_do_not_apply_are_empty(self):
        row, = table(theory(THREE / "random.cfg", "--csv", "-").stdout)
        for name in ("amplitude", "omega", "phase", "mean", "first_order", "limit", "pp", "stuck", "permanent"):
            self.assertEqual(row[name], "", name)
        self.assertNotEqual(row["torque_pp"], "")
        row, = table(theory(THREE / "async.cfg", "--csv", "-", "-D", "motions.turn_right.phase=0.5").stdout)
        self.assertEqual(row["first_order"], "")
        # beyond tan(theta_h) = mu there is no S-+: no periodic state, and a warning
        done = theory(THREE / "async.cfg", "--csv", "-", "-D", "materials[0].mu=0.7")
        row, = table(done.stdout)
        self.assertEqual((row["mean"], row["permanent"]), ("", ""))
        self.assertIn("no stable equilibrium", done.stderr)


class Refusals(Base):
    def refused(self, deck, words, *expected):
        done = theory(deck, *words, status=2)
        self.assertEqual(done.stdout, "")
        for text in expected:
            self.assertIn(text, done.stderr)

    def test_other_decks(self):
        for deck, *expected in (
                ("packing/heap", "45 free disks", "expected one on two supports"), ("walls/drum", "80 free disks"),
                ("collisions/two_disks", "2 free disks"), ("collisions/disk_wall", '"ball" rests on 0', "two supports"),
                ("epo/symmetric", '"block" rests on 0'),
                ("three_disk/frozen", "centre locked", "no weight")):
            self.refused(ROOT / f"inputs/{deck}.cfg", [], f"{deck}.cfg: theory: ", *expected)

    def test_motions(self):
        a = THREE / "async.cfg"
        self.refused(a, ["-D", "motions.turn_right.type=harmonic"], 'motion "turn_right" (harmonic) moves theta of disk "right"',
                     'same type as of motion "turn_left" (parabolic)')
        self.refused(a, ["-D", "motions.turn_right.omega=60"], "omega = 62.8318530718", "not 60")
        self.refused(a, ["-D", "motions.turn_right.coordinate=x"], "moves x of", "only turn, or vibrate at random")
        self.refused(a, ["-D", "motions.turn_right.disk=left"], 'theta of disk "left"', "one motion of this angle")
        self.refused(a, ["-D", "disks.upper.locked=theta"], "theta is locked", "free to turn")
        self.refused(a, ["-D", "motions.turn_right.disk=upper", "-D", "disks.right.fixed=true"],
                     'moves theta of disk "upper"', "moved by its supports alone")

    def test_bodies(self):
        s = THREE / "sync.cfg"
        self.refused(s, ["-D", "gravity.g=0"], "no weight")
        self.refused(s, ["-D", "gravity.tilt=1 pi"], "does not stand above its supports")
        self.refused(s, ["-D", "disks.left.x=-4"], "falls through")
        self.refused(s, ["-D", "disks.upper.y=0.5"], "starts far")
        self.refused(s, ["-D", "disks.upper.torque=0.1"], "constant torque")
        self.refused(s, ["-D", "materials[0].k_t=0"], "k_t = 0")
        for key, value in (("law", "hertz"), ("tangential", "mindlin"), ("mu_kinetic", 0.05), ("critical_load", 1), ("gamma_t", 1)):
            self.refused(s, ["-D", f"materials[0].{key}={value}"], f"have `{key}`", "linear ones with friction mu alone")
        self.refused(s, ["-D", "materials[0].k_r=1", "-D", "materials[0].mu_r=0.1"], "have `mu_r`")
        deck = s.read_text() + 'fields = ( { type = "damping"; alpha = 0.1; } );'
        (self.folder / "field.cfg").write_text(deck)
        self.refused(self.folder / "field.cfg", [], "it has fields; expected none")
        deck = s.read_text().replace("motions = (", 'walls = ( { name = "side"; type = "line"; '
                                     'points = ( (1.001, 0), (1.001, 1) ); } );\nmotions = (', 1)
        (self.folder / "wall.cfg").write_text(deck)
        self.refused(self.folder / "wall.cfg", [], 'wall "side" touches the upper disk too')
        deck = s.read_text().replace('  { name = "disk"; k_n', '{ name = "slick"; k_n = 1e3; k_t = 1e6; mu = 0.2; },\n'
                                     '  { name = "disk"; k_n', 1)
        deck = deck.replace("mass = 0.1;", 'mass = 0.1; material = "disk";').replace(
            "disks = (", 'material_pairs = ( { materials = ["disk", "slick"]; k_n = 1e3; k_t = 1e6; mu = 0.2; } );\ndisks = (', 1)
        (self.folder / "mu.cfg").write_text(deck)
        facts(self.folder / "mu.cfg")
        self.refused(self.folder / "mu.cfg", ["-D", "disks.right.material=slick"], "mu = 0.1 and 0.2", "the same")

    def test_no_periodic_state(self):
        done = theory(THREE / "async.cfg", "-D", "materials[0].mu=0.7", status=2)
        self.assertIn("NOT STABLE", done.stdout)
        self.assertIn("no stable equilibrium", done.stderr)
        done = theory(THREE / "random.cfg", "--wave", "-", status=2)
        self.assertIn("no periodic solution", done.stderr)

    def test_command_line(self):
        self.assertIn("one deck", theory(THREE / "sync.cfg", THREE / "async.cfg", status=2).stderr)
        self.assertIn("did you mean --wave", theory(THREE / "sync.cfg", "--wav3=1", status=2).stderr)
        self.assertIn("standard output", theory(THREE / "sync.cfg", "--json", "--csv", "-", status=2).stderr)
        self.assertIn("nosuch", theory("nosuch.cfg", status=2).stderr)
        theory(THREE / "sync.cfg", "--csv", self.folder / "no/such/folder.csv", status=4)
        pipe = self.folder / "pipe"  # is written into, not replaced
        os.mkfifo(pipe)
        reader = subprocess.Popen(["cat", str(pipe)], stdout=subprocess.PIPE, text=True)
        try:
            theory(THREE / "sync.cfg", "--csv", pipe)
            self.assertTrue(pipe.is_fifo())
            self.assertEqual(reader.communicate(timeout=600)[0].count("\n"), 2)
        finally:
            reader.kill()
            reader.wait()
        with open("/dev/full", "w") as full:
            done = subprocess.run([PROGRAM, "theory", str(THREE / "sync.cfg")], stdout=full, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 4)


if __name__ == "__main__":
    unittest.main()

"""slipdisk plot: every kind of picture is made from real runs, in the three formats, and shows what is in the file."""
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np
from plot_common import ROOT, make, program, run


from matplotlib.image import imread  # noqa: E402

import slipdisk  # noqa: E402
from slipdisk import plot  # noqa: E402
from slipdisk import plot_style as style  # noqa: E402
from slipdisk.plot_source import DERIVED, QUANTITIES, usual_quantity  # noqa: E402
from slipdisk.plot_sweep import every_quantity  # noqa: E402

HERE = None
FALL = """dt = 2e-4; gravity = { g = 10; }; output = { series = 100; frames = 1000; };
materials = ( { name = "g"; k_n = 1e4; k_t = 5e3; gamma_n = 2; mu = 0.5; } );
walls = ( { name = "floor"; type = "segment"; points = ((-9, 0), (2, 0)); } );
"""
RAIN = """packings = ( { type = "rain"; count = 4; x = (0, 1.2); y = (1, 30); rows = 1; interval = 1; speed = %d; radius = 0.5; density = 1; } );
phases = ( { time = 5; } ); bounds = { x = (-9, 2.5); y = (-3, 99); outside = "%s"; };
"""
PAIR = """disks = ( { name = "a"; x = 0; y = 3; radius = 0.5; mass = 1; fixed = true; }, { name = "b"; x = -3; y = 2; radius = 0.5; mass = 1; } );
phases = ( { time = 0.3; }, { time = 0.3; %s = "a"; hold = "b"; }, { time = 0.3; release = "b"; } );
"""
# decks in which `start` of the energies changes, and whether drives do work in them
COMERS = {"rain": (RAIN % (0, "report"), False), "thrown": (RAIN % (3, "report"), False), "removed": (RAIN % (2, "remove"), False),
          "held": (PAIR % "release", False),
          "lifted": (PAIR % "release" + 'motions = ( { wall = "floor"; coordinate = "y"; type = "velocity"; velocity = 1; } );', True)}


def setUpModule():
    global HERE
    folder = tempfile.TemporaryDirectory()
    unittest.addModuleCleanup(folder.cleanup)
    HERE = pathlib.Path(folder.name)
    make(HERE)


def lines(ax, gid):
    return [line for line in ax.lines if line.get_gid() == gid]


def figure():
    return style.figure(5, 4)


class Kinds(unittest.TestCase):
    def test_every_kind_in_every_format(self):
        drawn = set()
        for file in sorted(HERE.glob("*.h5")):
            source = plot.Source(file)
            for name, kind in plot.KINDS.items():
                if kind.lacks(source) or name in drawn:
                    continue
                drawn.add(name)
                with self.subTest(file=file.name, kind=name):
                    picture = plot.page(source, [name])
                    axes = picture.get_axes()
                    self.assertTrue(axes)
                    for ax in axes:
                        self.assertTrue(ax.has_data() or ax.get_children(), "empty axes")
                    output = HERE / f"{file.stem}-{name}.png"
                    style.save(picture, output, 40)
                    pixels = imread(output)
                    self.assertGreater(len(np.unique(pixels.reshape(-1, pixels.shape[-1]), axis=0)), 10)
                    for ending, first in ((".svg", b"<?xml"), (".pdf", b"%PDF")):
                        style.save(picture, output.with_suffix(ending), 40)
                        self.assertTrue(output.with_suffix(ending).read_bytes().startswith(first))
        self.assertEqual(drawn, set(plot.KINDS))

    def test_what_fits(self):
        fits = {"three": "rotation", "shaken": "map", "pressed": "compression", "squeezed": "stress", "hopper": "flow", "two": "paths",
                "sheared": "shear", "biaxial": "stress", "cemented": "bonds"}
        for name, kind in fits.items():
            with self.subTest(name):
                source = plot.Source(HERE / f"{name}.h5")
                kinds = plot.default_kinds(source)
                self.assertEqual(kinds[0], kind)
                picture = plot.page(source)
                style.save(picture, HERE / "page.png", 30)
                self.assertGreaterEqual(len([ax for ax in picture.get_axes() if ax.has_data()]), len(kinds) - 1)


class Data(unittest.TestCase):
    """What is drawn is what the file says."""
    def test_rotation(self):
        result = slipdisk.Result(HERE / "three.h5")
        ax = plot.rotation(result, figure().subplots())
        row = result.rotation[0]
        line, = lines(ax, "omega 0")
        self.assertEqual(list(line.get_ydata()), [row["omega"]] * 2)
        self.assertEqual(line.get_xdata()[0], result.time - row["measured"] + row["transient"])
        band, = [c for c in ax.collections if c.get_gid() == "band 0"]
        y = band.get_paths()[0].vertices[:, 1]
        np.testing.assert_allclose([y.min(), y.max()], [row["omega"] - row["error"], row["omega"] + row["error"]], rtol=1e-12)
        windows, = [p for p in ax.patches if hasattr(p, "get_data")]
        values, edges, _ = windows.get_data()
        t, angle = result.series["time"], result.series["angle"][:, 0]
        turned = np.interp(edges, t, angle)
        np.testing.assert_allclose(np.sum(values * np.diff(edges)), turned[-1] - turned[0], rtol=1e-9)

    def test_configurations(self):
        result = slipdisk.Result(HERE / "three.h5")
        ax = plot.configurations(result, figure().subplots())
        row = result.slide[0]
        self.assertEqual([bar.get_height() for bar in ax.patches], [row[name] for name in ("pp", "pm", "mp", "mm", "stick", "open")])

    def test_spin_and_energy(self):
        result = slipdisk.Result(HERE / "three.h5")
        ax = plot.spin(result, figure().subplots())
        np.testing.assert_array_equal(ax.lines[0].get_ydata(), result.series["angular_velocity"][:, 0])
        ax = plot.energy_budget(result, figure().subplots(), time=(0.05, None))
        by_name = {line.get_label(): line for line in ax.lines}
        s = result.series
        keep = s["time"] >= 0.05
        np.testing.assert_array_equal(by_name["lost to friction"].get_ydata(), s["friction"][keep])
        np.testing.assert_array_equal(by_name["work of drives"].get_ydata(), (s["work"] + s["nonconservative_work"])[keep])

    def test_budget_closes_where_disks_come_and_go(self):
        for name, (text, works) in COMERS.items():
            with self.subTest(deck=name):
                (HERE / f"{name}.cfg").write_text(FALL + text)
                run("run", HERE / f"{name}.cfg", "-o", HERE / f"{name}.h5", "--quiet")
                s = slipdisk.Result(HERE / f"{name}.h5").series
                self.assertGreater(np.ptp(s["start"]), 1)
                by_name = {line.get_label(): line.get_ydata() for line in plot.energy_budget(HERE / f"{name}.h5", figure().subplots()).lines}
                lost = [values for key, values in by_name.items() if key.startswith("lost")]
                given = [values for key, values in by_name.items() if not key.startswith(("lost", "_"))]
                left = sum(s[key] for key in ("kinetic_translation", "kinetic_rotation", "elastic_normal", "elastic_tangential"))
                self.assertEqual("work of drives" in by_name, works)
                self.assertEqual(len(given), 1 + works)
                np.testing.assert_allclose(sum(given) - sum(lost), left - left[0], rtol=0, atol=0.02 * np.abs(given).max())

    def test_thinned_keeps_extremes(self):
        y = np.random.default_rng(1).normal(size=100_003)
        x = np.arange(len(y))
        a, b = style.thinned(x, y)
        self.assertLess(len(a), 8100)
        self.assertEqual((b.min(), b.max()), (y.min(), y.max()))
        np.testing.assert_array_equal(y[a], b)

    def test_map(self):
        """Each disk is where the frame has it, and the pixel beside its centre has the colour of its value."""
        source = plot.Source(HERE / "shaken.h5")
        picture = figure()
        with style.look():
            ax = plot.map(source, picture.subplots(), frame=1, color="spin")
        disks = next(c for c in ax.collections if c.get_array() is not None)
        place = source.frames[1]["position"]
        spin = source.frames[1]["angular_velocity"]
        np.testing.assert_array_equal(disks.get_offsets()[:len(place)], place)
        np.testing.assert_array_equal(disks.get_array()[:len(place)], spin)
        picture.canvas.draw()
        pixels = np.asarray(picture.canvas.buffer_rgba()) if hasattr(picture.canvas, "buffer_rgba") else None
        if pixels is None:
            from matplotlib.backends.backend_agg import FigureCanvasAgg
            canvas = FigureCanvasAgg(picture)
            canvas.draw()
            pixels = np.asarray(canvas.buffer_rgba())
        k = int(np.argmax(source.radius))
        angle = source.frames[1]["angle"][k] + np.pi  # away from the mark
        x, y = ax.transData.transform(place[k] + 0.5 * source.radius[k] * np.array([np.cos(angle), np.sin(angle)]))
        seen = pixels[pixels.shape[0] - 1 - int(y), int(x), :3] / 255
        np.testing.assert_allclose(seen, disks.cmap(disks.norm(spin[k]))[:3], atol=0.03)

    def test_region(self):
        region = (-0.1, 0.15, 0.02, 0.12)
        for draw in (plot.map, plot.network):
            ax = draw(HERE / "shaken.h5", figure().subplots(), region=region)
            self.assertEqual((*ax.get_xlim(), *ax.get_ylim()), region)
        self.assertIn("outside the picture", ax.get_title("left") + ax.get_title())

    def test_map_of_means(self):
        source = plot.Source(HERE / "shaken.h5")
        means = source.result.means
        self.assertEqual(usual_quantity(source), "omega")
        values = QUANTITIES["omega"].of(source, 0, 0)
        np.testing.assert_array_equal(values[means["id"]], means["omega"])
        ax = plot.means(source, figure().subplots())
        x = np.concatenate([c.get_segments() for c in ax.collections if hasattr(c, "get_segments")])[:, :, 0]
        self.assertTrue(np.isin(np.round(means["omega_first"], 12), np.round(x, 12)).all())

    def test_measured(self):
        """Network, g(r), P(f) and profiles are what `slipdisk measure` says."""
        source = plot.Source(HERE / "shaken.h5")
        k = source.n_frames - 1
        table = source.measured(k)
        ax = plot.forces(source, figure().subplots())
        low, density = table["forces"]["low"], table["forces"]["normal"]
        bars = ax.containers[0].lines[0]
        width = np.diff(low)[0] * 5
        self.assertAlmostEqual(float(np.sum(bars.get_ydata()) * width), float(np.nansum(density) * np.diff(low)[0]), 9)
        line = max(plot.gr(source, figure().subplots()).lines, key=lambda line: len(line.get_xdata()))
        diameter = 2 * source.radius[source.in_play(k) & ~source.driven].mean()
        step = float(np.diff(line.get_xdata())[0])
        self.assertTrue(0.035 < step < 0.08, step)  # so that the peak of contacts is seen
        pairs = source.pairs(k, 0.05 * diameter)
        m = round(step * diameter / (2 * pairs["r"][0]))
        n = len(pairs["r"]) // m * m
        np.testing.assert_allclose(np.sum(line.get_ydata() * line.get_xdata()) * diameter * m, np.sum((pairs["g"] * pairs["r"])[:n]), rtol=1e-9)
        ax = plot.network(source, figure().subplots())
        segments = max((c.get_segments() for c in ax.collections if hasattr(c, "get_segments")), key=len)
        contacts = table["contacts"]
        n = int((contacts["force"] > 0).sum())
        walls = int((contacts["b"][contacts["force"] > 0] >= len(source.radius)).sum())
        self.assertEqual(len(segments), 2 * n - walls)
        ax = plot.profile(source, figure().subplots(), of="contacts", bins=1)
        disks = table["disks"]
        self.assertAlmostEqual(float(ax.containers[0].lines[0].get_xdata()[0]), disks["contacts"][disks["prescribed"] == 0].mean(), 12)

    def test_compression(self):
        result = slipdisk.Result(HERE / "pressed.h5")
        ax = plot.compression(result, figure().subplots(), x="fraction", y="contacts")
        line, = lines(ax, "series")
        np.testing.assert_array_equal(line.get_xdata(), result.series["packing_fraction"])
        free = result.summary.disks
        np.testing.assert_array_equal(line.get_ydata(), 2 * result.series["contacts"] / free)

    def test_shear(self):
        """Ratio and stresses against the accumulated strain, of contacts and velocities; windows have the mean of their rows."""
        s = slipdisk.Result(HERE / "sheared.h5").series
        shear = -(s["stress_xy"] + s["stress_yx"]) / 2 - s["kinetic_xy"]
        p = (s["stress_xx"] + s["stress_yy"] + s["kinetic_xx"] + s["kinetic_yy"]) / 2
        self.assertAlmostEqual(s["strain_xy"][-1], 0.2 * 5 + 0.4 * 10, 6)
        self.assertGreater(shear.mean(), 0.2 * p.mean())
        ax = plot.shear(HERE / "sheared.h5", figure().subplots(), of="stress")
        for k, values in enumerate((shear, p)):
            line, = lines(ax, f"rows {k}")
            np.testing.assert_allclose(line.get_xydata(), np.column_stack([s["strain_xy"], values]), rtol=1e-12)
            means, = lines(ax, f"means {k}")
            cuts = np.linspace(0, len(p), 51).astype(int)
            np.testing.assert_allclose(means.get_ydata(), [values[a:b].mean() for a, b in zip(cuts, cuts[1:])], rtol=1e-9)
        ratio = plot.shear(HERE / "sheared.h5", figure().subplots())
        np.testing.assert_allclose(lines(ratio, "means 0")[0].get_ydata(), lines(ax, "means 0")[0].get_ydata() / lines(ax, "means 1")[0].get_ydata())
        held = p > 1e-3 * p.max()
        np.testing.assert_allclose(lines(ratio, "rows 0")[0].get_ydata(), (shear / p)[held])
        self.assertIn("fast", [text.get_text() for text in ratio.texts])
        with self.assertRaisesRegex(slipdisk.UserError, "needs a periodic box that is sheared"):
            plot.shear(HERE / "biaxial.h5", figure().subplots())

    def test_breaks(self):
        result = slipdisk.Result(HERE / "cemented.h5")
        modes, energy = result.rows("breaks/mode"), result.rows("breaks/energy")
        self.assertGreater(len(modes), 3)
        for of, sums in (("count", np.bincount(modes, minlength=4)), ("energy", np.bincount(modes, energy, minlength=4))):
            ax = plot.breaks(result, figure().subplots(), of=of)
            for mode in (1, 2, 3):
                drawn = [line.get_ydata() for line in lines(ax, f"mode {mode}")]
                self.assertEqual(len(drawn), int((modes == mode).any()))
                for values in drawn:
                    self.assertAlmostEqual(values[-1], sums[mode], delta=1e-12 * sums[mode])
                    self.assertTrue((np.diff(values) >= 0).all())
        with self.assertRaisesRegex(slipdisk.UserError, "needs bonds: bond = "):
            plot.page(HERE / "shaken.h5", ["breaks"])

    def test_bonds(self):
        result = slipdisk.Result(HERE / "cemented.h5")
        source = plot.Source(result)
        times, n = result.rows("breaks/time"), source.n_frames
        seen = 0
        for k in range(n):
            ax = plot.bonds(source, figure().subplots(), frame=k)
            table = result.contacts[int(np.flatnonzero(result.contacts.step == source.frames.step[k])[0])]
            bonded = table[table["bond"] > 0]
            bars = ax.collections[-1] if len(ax.collections) == 3 else None
            self.assertEqual(len(bars.get_array()), 2 * len(bonded))  # no wall is bonded: a half from each disk
            self.assertEqual(sorted(bars.get_array()), sorted([*bonded["bond_pull"], *bonded["bond_pull"]]))
            crosses, = (line for line in ax.lines if line.get_marker() == "x")
            self.assertEqual(len(crosses.get_xdata()), (times <= source.frame_times[k] * (1 + 1e-12)).sum())
            ax = plot.map(source, figure().subplots(), frame=k)
            crosses, = (line for line in ax.lines if line.get_marker() == "x")
            seen += len(crosses.get_xdata())
        self.assertEqual(seen, (times <= source.frame_times[-1] * (1 + 1e-12)).sum())
        self.assertGreater(seen, 3)

    def test_series(self):
        """Every column that --quantity list names is drawn, against time or another one."""
        for name in ("sheared", "three", "squeezed", "hopper"):
            source = plot.Source(HERE / f"{name}.h5")
            for column in source.columns:
                with self.subTest(name, column=column):
                    ax = plot.series(source, figure().subplots(), quantity=column)
                    parts = source.parts(column) if column in source.series else []
                    drawn = np.column_stack([lines(ax, f"column {k}")[0].get_ydata() for k in range(len(parts) or 1)])
                    self.assertEqual(len(drawn), len(source.series["time"]))
                    if column in source.series:
                        np.testing.assert_array_equal(drawn, source.series[column].reshape(len(drawn), -1))
        source = plot.Source(HERE / "squeezed.h5")
        wall = source.parts("wall_normal")[1]
        ax = plot.series(source, figure().subplots(), quantity=f"{wall}.wall_normal", x="width")
        np.testing.assert_array_equal(ax.lines[0].get_xydata(), np.column_stack([source.series["width"], source.series["wall_normal"][:, 1]]))
        flow = plot.Source(HERE / "hopper.h5")
        self.assertAlmostEqual(np.trapezoid(flow.column("outflow"), flow.series["time"]) if hasattr(np, "trapezoid") else
                               np.trapz(flow.column("outflow"), flow.series["time"]), np.ptp(flow.series["outside"]), delta=1.5)

    def test_units(self):
        ax = plot.rotation(HERE / "three.h5", figure().subplots())
        self.assertIn("(rad/time)", ax.get_ylabel())
        ax = plot.stress(HERE / "squeezed.h5", figure().subplots())
        self.assertIn("(force/length)", ax.get_ylabel())


class Unfinished(unittest.TestCase):
    def test_what_does_not_change_is_found_elsewhere(self):
        """An unfinished run has no constants in its files: they come from its state and its deck, and are the same."""
        for name in ("hopper", "pressed", "three", "squeezed"):
            with self.subTest(name):
                whole, part = (plot.Source(HERE / f"{name}.h5") for _ in range(2))
                part._whole = False
                np.testing.assert_array_equal(part.radius, whole.radius)
                np.testing.assert_array_equal(part.driven, whole.driven)
                self.assertEqual(len(part.shapes), len(whole.shapes))
                for a, b in zip(part.shapes, whole.shapes):
                    for one, other in zip(a, b):
                        np.testing.assert_array_equal(one, other)
                info = whole.result.attributes("particles/disks/box")
                np.testing.assert_array_equal(whole.box[0], info.lower)
                np.testing.assert_array_equal(whole.box[2], [word == "periodic" for word in info.boundary])
                np.testing.assert_allclose(whole.gravity, whole.result.rows("parameters/model/gravity"), rtol=1e-14, atol=1e-15)

    def test_page_of_an_unfinished_run(self):
        deck, overrides = "packing/drum.cfg", ["phases.fill.frames=1000", "checkpoint=0.2", "phases.fill.time=500"]
        with subprocess.Popen([program(), "run", ROOT / "inputs" / deck, "-o", HERE / "going.h5", "--quiet",
                               *(word for one in overrides for word in ("-D", one))], stderr=subprocess.DEVNULL) as process:
            for _ in range(600):
                time.sleep(0.1)
                if len(list(HERE.glob("going.h5.parts/part-*"))) > 3:
                    break
            process.terminate()
        self.assertEqual(process.returncode, 75)
        picture = plot.page(HERE / "going.h5")
        self.assertIn("(unfinished, t = ", picture.get_suptitle() if hasattr(picture, "get_suptitle") else picture._suptitle.get_text())
        self.assertGreater(len(picture.get_axes()), 5)
        style.save(picture, HERE / "going.png", 30)


class Sweeps(unittest.TestCase):
    def test_curve(self):
        sweep = slipdisk.Sweep(HERE / "tilted.sweep")
        picture = plot.page(sweep)
        ax, = picture.get_axes()
        means = sweep.means
        for k, amplitude in enumerate(np.unique(means["amplitude"])):
            rows = means[means["amplitude"] == amplitude]
            box, = [c for c in ax.containers if c.lines[0].get_gid() == f"curve {k}" or c.lines[0].get_label() == f"amplitude = {amplitude:.4g}"
                    or c.get_label() == f"amplitude = {amplitude:.4g}"]
            np.testing.assert_allclose(box.lines[0].get_xdata(), rows["tilt"] / np.pi, rtol=1e-12)
            np.testing.assert_array_equal(box.lines[0].get_ydata(), rows["upper.omega"])
            error = np.fmax(rows["upper.omega_error"], rows["upper.omega_scatter"])
            ends = np.array(box.lines[2][0].get_segments())[:, :, 1]
            np.testing.assert_allclose(np.ptp(ends, axis=1) / 2, error, rtol=1e-9, atol=1e-15)
        self.assertIn("tilt", ax.get_xlabel())

    def test_theory(self):
        sweep = slipdisk.Sweep(HERE / "tilted.sweep")
        rows = plot.theory(sweep)
        self.assertEqual(sorted(rows), sorted(sweep.means["set"].tolist()))
        done = subprocess.run([program(), "theory", str(HERE / "tilted.cfg"), "--csv", "-"], capture_output=True, text=True, check=True)
        head, *cells = [line.split(",") for line in done.stdout.replace('"', "").splitlines()]
        whole = {float(row[0]): float(row[-(len(head) - head.index("mean"))]) for row in cells}
        for k, row in rows.items():
            self.assertAlmostEqual(row["mean"], whole[k], 10)
        ax = plot.curve(sweep, figure().subplots())
        self.assertTrue(lines(ax, "theory 0"))

    def test_pale(self):
        """Points whose error bar is not reliable are pale, the others are not, and the legend says so."""
        for reliable in ((0, 2), (0, 1, 2), ()):
            sweep = slipdisk.Sweep(HERE / "tilted.sweep")
            sweep._means["upper.converged"] = np.where(np.isin(np.arange(len(sweep.means)) % 3, reliable), 1.0, 0.5)
            ax = plot.curve(sweep, figure().subplots())
            pale = lines(ax, "pale")
            c = plot.Curves(sweep)
            wanted = [c.values[rows[c.doubtful[rows]]].tolist() for _, rows in c.groups if c.doubtful[rows].any()]
            self.assertEqual([line.get_ydata().tolist() for line in pale], wanted)
            self.assertEqual(sum(map(len, wanted)), int((sweep.means["upper.converged"] < 1).sum()))
            for box, (_, rows) in zip(ax.containers, c.groups):
                if c.doubtful[rows].any():
                    self.assertEqual(box.lines[0].get_markevery(), np.flatnonzero(~c.doubtful[rows]).tolist())
            self.assertEqual("pale" in " ".join(text.get_text() for text in ax.get_legend().get_texts()), bool(wanted))
            style.save(ax.figure, HERE / "pale.png", 40)

    def test_angles_in_names(self):
        c = plot.Curves(slipdisk.Sweep(HERE / "tilted.sweep"))
        for value, name in ((0.0, "tilt = 0"), (np.pi, r"tilt = $\pi$"), (-np.pi, r"tilt = -$\pi$"), (0.5 * np.pi, r"tilt = 0.5$\pi$")):
            self.assertEqual(c._text((("tilt", value),)), name)

    def test_default_is_what_was_measured(self):
        """Of a sheared box the stress ratio over the measured time, with its error, though all disks are watched."""
        sweep = slipdisk.Sweep(HERE / "sheared.sweep")
        self.assertTrue(any(name.endswith(".omega") for name in sweep.means.dtype.names))
        c = plot.Curves(sweep)
        self.assertEqual((c.y, c.unit), ("stress_ratio", "1"))
        for row, one in enumerate(sweep.means["set"]):
            ratios = []
            for k in np.flatnonzero(sweep["set"] == one):
                s = sweep[int(k)].series
                keep = s["time"] > 2 + 1e-6
                shear, xx, yy = (s[name][keep] for name in ("stress_xy", "stress_xx", "stress_yy"))
                shear = -(shear + s["stress_yx"][keep]) / 2 - s["kinetic_xy"][keep]
                ratios.append(2 * shear.mean() / (xx + yy + s["kinetic_xx"][keep] + s["kinetic_yy"][keep]).mean())
            self.assertAlmostEqual(c.values[row], np.mean(ratios), delta=0.05 * np.mean(ratios))  # less a transient
            self.assertGreater(c.errors[row], 0)
            self.assertGreaterEqual(c.errors[row], np.std(ratios, ddof=1) / np.sqrt(2) * 0.2)
        self.assertEqual(plot.Curves(slipdisk.Sweep(HERE / "tilted.sweep")).y, "upper.omega")
        self.assertEqual(plot.page(sweep).get_axes()[0].get_ylabel(), "stress ratio")

    def test_every_quantity_of_a_sweep(self):
        sweep = slipdisk.Sweep(HERE / "sheared.sweep")
        for name, (_, _, where) in every_quantity(sweep).items():
            if name in ("z", "fraction") or "series" in where:  # of the last state each is a call of `slipdisk measure` per point
                with self.subTest(name):
                    self.assertTrue(np.isfinite(plot.Curves(sweep, quantity=name).values).all())

    def test_quantity(self):
        ax = plot.curve(HERE / "tilted.sweep", figure().subplots(), quantity="friction", x="amplitude")
        self.assertIn("friction", ax.get_ylabel())
        self.assertEqual(ax.get_xlabel(), "amplitude")


class Command(unittest.TestCase):
    def run_it(self, *words, status=0):
        done = subprocess.run([program(), *map(str, words)], cwd=HERE, capture_output=True, text=True, timeout=600)
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertNotIn("Traceback", done.stderr)
        return done.stdout, done.stderr

    def test_pictures(self):
        for name in ("three.h5", "tilted.sweep"):
            out, err = self.run_it("plot", name, "--dpi", 50)
            picture = HERE / (name.split(".")[0] + ".png")
            self.assertEqual((out.strip(), err), (picture.name, ""))
            self.assertTrue(picture.read_bytes().startswith(b"\x89PNG"))
        self.run_it("plot", "shaken.h5", "-k", "map", "-k", "gr", "-o", "two panels.pdf", "--color", "speed", "--frame", -1, "--dark",
                    "--size", "6x3", "--region=-0.2,0.2,0,0.3")
        self.assertTrue((HERE / "two panels.pdf").read_bytes().startswith(b"%PDF"))

    def test_list(self):
        out, _ = self.run_it("plot", "three.h5", "--kind", "list")
        for name in plot.KINDS:
            self.assertIn(f" {name} ", out)
        self.assertIn("* rotation", out)
        self.assertIn("- network        needs more than 10 free disks", out)

    def test_list_of_quantities(self):
        out, _ = self.run_it("plot", "sheared.h5", "--quantity", "list")
        for name in ("  contacts ", "  strain_xy ", "  stress_ratio ", "- omega "):
            self.assertIn(f"\n{name}", out)
        out, _ = self.run_it("plot", "sheared.sweep", "--quantity", "list")
        for name in ("friction ", "stress_ratio ", "z_backbone ", "rate\n"):
            self.assertIn(f"\n  {name}", out)
        self.run_it("plot", "sheared.h5", "--quantity", "stress_ratio", "--x", "strain_xy", "--time", "5:")

    def test_mistakes(self):
        for words, said in (
                (["three.h5", "-k", "mapp"], "did you mean 'map'"),
                (["three.h5", "-k", "stress"], "measure = { stress = true; }"),
                (["three.h5", "-o", "a.jpg"], "a.jpg: unknown ending .jpg; expected .png, .svg or .pdf"),
                (["three.h5", "--color", "blue"], "expected omega|turned|"),
                (["three.h5", "-k", "map", "--color", "omega"], "measure = { disks = true; }"),
                (["three.h5", "-k", "map", "--frame", "99"], "there is no frame 99"),
                (["three.h5", "--time", "now"], "--time now: expected FROM:TO"),
                (["three.h5", "--size", "7"], "--size 7: expected WIDTHxHEIGHT"),
                (["shaken.h5", "--region", "1,0,0,1"], "X0 < X1"),
                (["shaken.h5", "--region", "50,60,0,1"], "--region 50,60,0,1: no disk is there; shaken.h5 reaches from x = "),
                (["three.h5", "--time", "50:60"], "--time 50:60: fewer than two moments are there; the series of three.h5 runs from 0 to "),
                (["three.h5", "--time", "2:1"], "--time 2:1: expected FROM < TO"),
                (["tilted.sweep", "-k", "map"], "a sweep has kind curve only"),
                (["tilted.sweep", "--quantity", "upper.omgea"], "did you mean 'upper.omega'"),
                (["tilted.sweep", "--quantity", "contcts"], "did you mean 'contacts'"),
                (["tilted.sweep", "--x", "tillt"], "did you mean 'tilt'"),
                (["three.h5", "--quantity", "kinetic_rotatoin"], "did you mean 'kinetic_rotation'"),
                (["three.h5", "--quantity", "work", "--x", "frction"], "did you mean 'friction'"),
                (["squeezed.h5", "--quantity", "width", "--x", "wall_normal"], "--x wall_normal has a value for each of "),
                (["three.h5", "-k", "spin", "--quantity", "work"], "--quantity belongs to kind curve, and not to spin"),
                (["three.h5", "-k", "shear"], "kind shear needs a periodic box that is sheared"),
                (["three.h5", "--color", "spni"], '|group (did you mean spin?)')):
            with self.subTest(words):
                out, err = self.run_it("plot", *words, status=2)
                self.assertIn(said, err)
                self.assertEqual((out, len(err.splitlines())), ("", 1))
        self.assertIn("missing.h5", self.run_it("plot", "missing.h5", status=2)[1])
        self.assertIn("not a result", self.run_it("plot", "tilted.sweep/table.h5", status=4)[1])

    def test_no_half_file(self):
        before = sorted(HERE.iterdir())
        self.run_it("plot", "three.h5", "-o", "nowhere/a.png", status=4)
        self.assertEqual(sorted(HERE.iterdir()), before)

    def test_what_is_missing_is_named(self):
        done = subprocess.run([program(), "plot", "three.h5"], cwd=HERE, capture_output=True, text=True,
                              env={"SLIPDISK_PYTHON": "/nowhere/python3", "PATH": os.environ["PATH"]})
        if done.returncode == 0:  # another one has all
            self.assertTrue((HERE / "three.png").exists())
        else:
            self.assertIn("/nowhere/python3 does not run", done.stderr)
            self.assertIn("apt install", done.stderr)


    def start(self, command, then):
        """The command with a Python that has all modules, and then does this."""
        python = HERE / "python"
        python.write_text(f"#!/bin/sh\ncase $2 in *find_spec*) exit 64;; esac\n{then}\n")
        python.chmod(0o755)
        return subprocess.Popen([program(), command, "shaken.h5"], cwd=HERE, stderr=subprocess.PIPE, text=True,
                                env={**os.environ, "SLIPDISK_PYTHON": str(python)})

    def test_a_python_that_fails_ends_with_a_message(self):
        missing = f"exec {sys.executable} -c 'import no_such_module'"
        for then, status, said in (("exit 1", 4, "failed with status 1"), ("exit 120", 4, "failed with status 120"), (missing, 4, "no_such_module"),
                                   ("kill -9 $$", 4, "ended by signal 9"), ("kill -6 $$", 4, "ended by signal 6"),
                                   ("exit 0", 0, ""), ("exit 2", 2, ""), ("exit 3", 3, ""), ("exit 4", 4, ""), ("exit 130", 130, ""),
                                   ("kill -15 $$", -15, "")):
            for command in "plot", "film":
                with self.subTest(then, command=command):
                    process = self.start(command, then)
                    err = process.communicate(timeout=600)[1]
                    self.assertEqual(process.returncode, status, err)
                    self.assertIn(said, err)
                    self.assertEqual("error: slipdisk" in err, bool(said))

    def test_signals_reach_python(self):
        for number in signal.SIGTERM, signal.SIGINT, signal.SIGHUP:
            with self.subTest(number):
                with self.start("film", "trap 'echo told >&2; exit 3' TERM INT HUP; echo ready >&2; while :; do sleep 0.02; done") as process:
                    self.assertEqual(process.stderr.readline(), "ready\n")
                    process.send_signal(number)
                    self.assertEqual((process.stderr.read(), process.wait()), ("told\n", 3))


class Docs(unittest.TestCase):
    def test_kinds_and_quantities_are_documented(self):
        text = (ROOT / "docs/plots.md").read_text()
        for name in [*plot.KINDS, *QUANTITIES, *DERIVED]:
            self.assertIn(f"`{name}`", text)

    def test_quantities_are_those_of_the_program(self):
        out = subprocess.run([program(), "help", "plot"], capture_output=True, text=True, check=True).stdout
        self.assertIn("|".join(QUANTITIES), out)


if __name__ == "__main__":
    unittest.main()

"""mu(I) and phi(I) of disks in simple shear: runs inputs/shear/rheology.cfg, compares it with da Cruz et al.

Called by tools/studies/rheology.sh. Results go to build/rheology; what is finished is not run again. --keep DIR
writes DIR/data/shear/rheology.csv and rheology-series.csv, the figures DIR/figures/rheology*.png and the tables of
DIR/rheology.md anew."""
import argparse
import csv
import math
import os
import re
import subprocess
import sys

import numpy as np

from . import cases, series

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), *3 * [os.pardir]))
sys.path.insert(0, os.path.join(ROOT, "tools", "python"))
DECK = os.path.join(ROOT, "inputs", "shear", "rheology.cfg")
POINTS = (1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3)
QUICK = {"packings[0].count": 512, "container.width": 31.2, "container.height": 31.2, "constants.strain": 1}
BLOCKS, LINEAR, CURVE = 10, 0.1, 200    # blocks of an error bar; largest I of the straight lines; rows kept of a series
# da Cruz, Emam, Prochnow, Roux, Chevoir, Phys. Rev. E 72, 021309 (2005), disks with friction 0.4, polydispersity 20 %:
# mu* = mu_s + b I, phi = phi_max - c I. Value, and by how much ours may differ: a unit of the last digit of mu_s, half of
# one of phi_max, a tenth of the slopes.
PUBLISHED = {"mu_s": (0.25, 0.01), "b": (1.1, 0.11), "phi_max": (0.81, 0.005), "c": (0.3, 0.03)}
COLUMNS = ("I_set", "I", "mu", "mu_error", "phi", "phi_error", "pressure", "xx_over_yy", "kinetic_share", "contacts",
           "strain", "steps", "drift")


# --- from a series to numbers ---------------------------------------------------------------------------------------
def block_error(values, blocks=BLOCKS):
    """Standard error of the mean of a correlated series, from means of blocks of equal length."""
    usable = len(values) // blocks * blocks
    if usable < blocks:
        return math.nan
    means = np.asarray(values[:usable], float).reshape(blocks, -1).mean(axis=1)
    return float(means.std(ddof=1) / math.sqrt(blocks))


def evaluate(rate, series, area):
    """A row of numbers from the measured part of a run. series: {column: values}; area: of all disks."""
    shear = -(series["stress_xy"] + series["stress_yx"]) / 2 - series["kinetic_xy"]
    pressure = series["stress_yy"] + series["kinetic_yy"]
    side = series["stress_xx"] + series["kinetic_xx"]
    phi = area / (series["width"] * series["height"])
    p = pressure.mean()
    mu = shear / p
    half = len(mu) // 2
    return {"I_set": rate, "I": rate / math.sqrt(p), "mu": mu.mean(), "mu_error": block_error(mu), "phi": phi.mean(),
            "phi_error": block_error(phi), "pressure": p, "xx_over_yy": side.mean() / p,
            "kinetic_share": series["kinetic_yy"].mean() / p, "contacts": series["coordination"].mean(),
            "strain": rate * (series["time"][-1] - series["time"][0]), "steps": int(series["step"][-1]),
            "drift": mu[half:].mean() - mu[:half].mean()}


def read(path):
    """(rate, series of the measured part, area) of a result of the deck."""
    import slipdisk
    result = slipdisk.Result(path)
    series = {name: np.asarray(values) for name, values in result.series.items()}
    radius = result.rows("particles/disks/radius")
    # The last phase only: before it is the way to the steady state.
    begin = result.phases["steps"][:-1].sum()
    rate = float(result.deck.constants.I)
    series["coordination"] = 2 * series["contacts"] / len(radius)
    measured = {name: values[series["step"] > begin] for name, values in series.items()
                if getattr(values, "shape", (0,))[0] == len(series["step"])}
    return rate, measured, float(np.pi * (radius**2).sum())


def straight(x, y, error):
    """(intercept, slope, their errors, chi^2 per degree of freedom) of a weighted straight line."""
    x, y, error = (np.asarray(it, float) for it in (x, y, error))
    weight = 1 / error**2
    matrix = np.array([[weight.sum(), (weight * x).sum()], [(weight * x).sum(), (weight * x * x).sum()]])
    covariance = np.linalg.inv(matrix)
    a, b = covariance @ np.array([(weight * y).sum(), (weight * x * y).sum()])
    chi = float((weight * (y - a - b * x)**2).sum() / max(len(x) - 2, 1))
    return float(a), float(b), *(float(it) for it in np.sqrt(np.diag(covariance) * max(chi, 1))), chi


def fits(rows):
    """{name: (value, error)} of the straight lines, and chi^2 of both."""
    rows = [row for row in rows if row["I_set"] <= LINEAR * 1.001]
    if len(rows) < 3:
        return None
    x = [row["I"] for row in rows]
    mu = straight(x, [row["mu"] for row in rows], [row["mu_error"] for row in rows])
    phi = straight(x, [row["phi"] for row in rows], [row["phi_error"] for row in rows])
    return {"mu_s": (mu[0], mu[2]), "b": (mu[1], mu[3]), "phi_max": (phi[0], phi[2]), "c": (-phi[1], phi[3]),
            "chi": (mu[4], phi[4])}


def verdict(found):
    """[(name, ours, error, theirs, allowed, verdict)]: within what is allowed, or beyond it, by two errors of ours."""
    made = []
    for name, (theirs, allowed) in PUBLISHED.items():
        off, error = abs(found[name][0] - theirs), 2 * found[name][1]
        word = "agrees" if off + error <= allowed else "**differs**" if off - error > allowed else "undecided"
        made.append((name, *found[name], theirs, allowed, word))
    return made


# --- numbers that are kept --------------------------------------------------------------------------------------------
def write_csv(path, head, columns, rows):
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path + ".new", "w", newline="") as file:
        file.write("".join(f"# {line}\n" for line in head))
        out = csv.writer(file, lineterminator="\n")
        out.writerow(columns)
        out.writerows([[f"{row[name]:.8g}" if isinstance(row[name], float) else row[name] for name in columns]
                       for row in rows])
    os.replace(path + ".new", path)


def read_csv(path):
    with open(path, newline="") as file:
        return [{name: value if name in (*cases.TEXT, "series") else float(value) for name, value in row.items()}
                for row in csv.DictReader(line for line in file if not line.startswith("#"))]


def thinned(rate, series):
    """Rows of the kept series: means over stretches, so that CURVE remain."""
    size = max(1, len(series["time"]) // CURVE)
    usable = len(series["time"]) // size * size
    mean = {name: series[name][:usable].reshape(-1, size).mean(axis=1)
            for name in ("time", "stress_xy", "stress_yx", "kinetic_xy", "stress_yy", "kinetic_yy", "width", "height")}
    return [{"I_set": rate, "strain": float(rate * (t - series["time"][0])), "mu": float(shear / p),
             "pressure": float(p)}
            for t, shear, p in zip(mean["time"], -(mean["stress_xy"] + mean["stress_yx"]) / 2 - mean["kinetic_xy"],
                                   mean["stress_yy"] + mean["kinetic_yy"])]


# --- figures ----------------------------------------------------------------------------------------------------------
def draw(rows, curves, folder):
    from ratchet import style
    plt = style.plt
    found = fits(rows)
    x = np.array([row["I"] for row in rows])
    wide, fine = np.geomspace(x.min() / 1.3, 0.35, 200), np.linspace(0, 0.32, 65)
    picture, axes = plt.subplots(2, 2, figsize=(style.WIDTH, 4.9), layout="constrained")
    for k, (name, published, label) in enumerate((("mu", ("mu_s", "b"), r"$\mu^* = -\sigma_{xy}/\sigma_{yy}$"),
                                                 ("phi", ("phi_max", "c"), r"$\phi$"))):
        sign = 1 if name == "mu" else -1
        lines = [(PUBLISHED[published[0]][0], PUBLISHED[published[1]][0], "da Cruz et al.: ", style.COLOURS[1], "--")]
        if found:
            lines.append((found[published[0]][0], found[published[1]][0], rf"fit, $I \leq {LINEAR:g}$: ",
                          style.COLOURS[0], "-"))
        for axis, at in ((axes[k][0], wide), (axes[k][1], fine)):
            for zero, slope, text, colour, dash in lines:
                text += f"${zero:.3f} {'+' if sign > 0 else '-'} {slope:.2f}\\,I$"
                near = at <= LINEAR * 1.05      # what the lines are for; beyond it they are thin
                axis.plot(at[near], zero + sign * slope * at[near], dash, color=colour, lw=1.2, label=text)
                axis.plot(at[~near], zero + sign * slope * at[~near], dash, color=colour, lw=0.5)
            axis.errorbar(x, [row[name] for row in rows], [row[name + "_error"] for row in rows], fmt="o",
                          color=style.BLACK, ms=4,
                          lw=1, label="slipdisk")
            axis.set_ylabel(label)
            axis.set_xlabel("$I$")
        axes[k][0].set_xscale("log")
        axes[k][0].legend(fontsize=8)
    picture.savefig(os.path.join(folder, "rheology.png"))
    plt.close(picture)
    picture, axis = plt.subplots(figsize=(style.WIDTH, 3.2), layout="constrained")
    for k, rate in enumerate(sorted({row["I_set"] for row in curves})):
        own = [row for row in curves if row["I_set"] == rate]
        axis.plot([row["strain"] for row in own], [row["mu"] for row in own], lw=0.8, label=f"{rate:g}",
                  color=plt.get_cmap("viridis")(k / 10))
    axis.set_xlabel("strain since the measurement began")
    axis.set_ylabel(r"$\mu^*$")
    axis.set_xscale("log")
    axis.set_xlim(left=0.01)
    handles, labels = axis.get_legend_handles_labels()
    axis.legend(handles[::-1], labels[::-1], title="$I$", loc="center left", bbox_to_anchor=(1, 0.5), fontsize=8)
    picture.savefig(os.path.join(folder, "rheology-series.png"))
    plt.close(picture)


# --- page -------------------------------------------------------------------------------------------------------------
def table(columns, rows):
    return ["| " + " | ".join(columns) + " |", "|---" * len(columns) + "|",
            *("| " + " | ".join(row) + " |" for row in rows)]


def pm(value, error, sign=False):
    """A value with digits that its error allows; sign: a + before positive ones."""
    plus = "+" if sign else ""
    if not error or not math.isfinite(error):
        return f"{value:{plus}.4g}"
    digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:{plus}.{digits}f} ± {error:.{digits}f}"


def page(rows):
    out = table(["I", "mu*", "phi", "contacts per disk", "sigma_xx/sigma_yy", "kinetic share of sigma_yy", "strain",
                 "steps"],
                [[f"{row['I']:.4g}", pm(row["mu"], row["mu_error"]), pm(row["phi"], row["phi_error"]),
                  f"{row['contacts']:.2f}",
                  f"{row['xx_over_yy']:.3f}", f"{row['kinetic_share']:.2g}", f"{row['strain']:.3g}",
                  f"{row['steps']:.2g}"]
                 for row in rows])
    found = fits(rows)
    if not found:
        return out
    out += ["",
            f"Straight lines through the points up to I = {LINEAR:g} (chi^2 per degree of freedom "
            f"{found['chi'][0]:.1f} and {found['chi'][1]:.1f}; errors grow with it):", ""]
    return out + table(["", "slipdisk", "da Cruz et al.", "may differ by", "verdict"],
                       [[name, pm(ours, error), f"{theirs:g}", f"{allowed:g}", word]
                        for name, ours, error, theirs, allowed, word in verdict(found)])


def fill(path, lines, name="rheology"):
    with open(path) as file:
        text = file.read()
    mark = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)", re.S)
    if not mark.search(text):
        raise ValueError(f"{path}: no <!-- {name} --> ... <!-- end of {name} -->")
    with open(path + ".new", "w") as file:
        file.write(mark.sub(lambda it: it.group(1) + "\n".join(lines) + "\n" + it.group(2), text))
    os.replace(path + ".new", path)


# --- runs -------------------------------------------------------------------------------------------------------------
def run(args):
    if args.cases or args.series:
        todo = cases.runs(args.folder) if args.cases else series.runs(args.folder)
        for path, _ in todo:
            os.makedirs(os.path.dirname(path), exist_ok=True)
    else:
        keys = dict(QUICK) if args.quick else {}
        todo = [(os.path.join(args.folder, f"I{rate:g}.h5"), {"constants.I": rate, **keys}) for rate in args.points]
    for path, keys in todo:
        if os.path.exists(path) and not os.path.isdir(path + ".parts"):
            continue
        words = [args.program, "run", args.deck, "-o", path, "--quiet", "--threads", str(args.threads)]
        for key, value in keys.items():
            words += ["-D", f"{key}={value}"]
        print(os.path.basename(path), file=sys.stderr, flush=True)
        if subprocess.run(words, check=False).returncode not in (0, 5):
            sys.exit(f"failed: {' '.join(words)}")


def numbers(rate):
    return [float(word) for word in rate.split(",")]


def arguments():
    parser = argparse.ArgumentParser(prog="tools/studies/rheology.sh", description=__doc__.split("\n", 1)[0])
    parser.add_argument("--points", type=numbers, default=list(POINTS), metavar="I,I", help="inertial numbers")
    parser.add_argument("--quick", action="store_true", help="512 disks and a strain of 1")
    parser.add_argument("--cases", action="store_true", help="what mu(0.1) depends on: one thing changed at a time")
    parser.add_argument("--series", action="store_true", help="with the published stiffness and restitution; slow flow for long")
    parser.add_argument("--draw", action="store_true", help="run nothing")
    parser.add_argument("--threads", type=int, default=1, metavar="N")
    parser.add_argument("-o", dest="folder", default=os.path.join(ROOT, "build", "rheology"), metavar="DIR")
    parser.add_argument("--program", default=os.path.join(ROOT, "build", "release", "slipdisk"), metavar="FILE")
    parser.add_argument("--deck", default=DECK, metavar="FILE", help="another one with the same names")
    parser.add_argument("--keep", metavar="DIR", help="renew DIR/rheology.md, its numbers and figures (docs/studies)")
    return parser.parse_args()


def version(args):
    return subprocess.run([args.program, "version"], capture_output=True, text=True, check=False).stdout.splitlines()[:1]


def show_cases(args):
    """Table and figure of the cases, from results or kept numbers."""
    rows = cases.collect(args.folder, read, evaluate)
    kept = os.path.join("data", "shear", "rheology-cases.csv")
    if rows and args.keep:
        write_csv(os.path.join(args.keep, kept), ["Simple shear at I = 0.1 with one thing changed at a time: "
                                                  "tools/studies/rheology.sh --cases, inputs/shear/rheology.cfg", *version(args),
                                                  "a row per case; means over runs, errors from blocks of their strain"],
                  cases.COLUMNS, rows)
    rows = rows or read_csv(os.path.join(ROOT, "docs", "studies", kept))
    lines = cases.table(rows, pm)
    print("\n".join(lines))
    cases.draw(rows, os.path.join(args.keep, "figures") if args.keep else args.folder)
    if args.keep:
        fill(os.path.join(args.keep, "rheology.md"), lines, "cases")


SLOWEST = 1e-4


def slow_lines(rows, slow):
    """Lines of the page: I = 1e-4 after a strain of 5 against the deck's 0.3, and whether they agree."""
    first, late = next(row for row in rows if row["I_set"] == SLOWEST), slow[0]
    lines = table(["I = 1e-4", "mu*", "phi", "contacts per disk", "strain measured", "second half less the first"],
                  [[text, pm(row["mu"], row["mu_error"]), pm(row["phi"], row["phi_error"]), f"{row['contacts']:.2f}",
                    f"{row['strain']:.2g}", pm(row["drift"], 2 * row["mu_error"], sign=True)]
                   for text, row in (("the deck: 4096 disks, strain 0.3 before", first), ("400 disks, strain 5 before", late))])
    told = []
    for name, word in (("mu", "friction"), ("phi", "packing fraction")):
        off, error = late[name] - first[name], math.hypot(late[name + "_error"], first[name + "_error"])
        told.append(f"{word} {'agrees' if abs(off) < 2 * error else '**differs**' if abs(off) > 3 * error else 'is undecided'}"
                    f", {pm(off, error, sign=True)}")
    return [*lines, "", f"After the longer strain {'; '.join(told)} (agrees: within 2 errors; differs: beyond 3)."]


def show_series(args):
    """Tables of the further series, from results or kept numbers."""
    kept = os.path.join("data", "shear", "rheology-more.csv")
    rows = [{name: value if name == "series" else float(f"{value:.8g}") for name, value in row.items()}
            for row in series.collect(args.folder, read, evaluate)]
    if rows and args.keep:
        write_csv(os.path.join(args.keep, kept), ["Simple shear: tools/studies/rheology.sh --series, inputs/shear/rheology.cfg",
                                                  *version(args), *(f"{name}: {text}" for name, text in series.TEXT.items()
                                                                    if series.of(rows, name))],
                  ("series", *COLUMNS), rows)
    rows = rows or read_csv(os.path.join(ROOT, "docs", "studies", kept))
    parts = {series.REFERENCE: page(series.of(rows, series.REFERENCE))}
    if series.of(rows, series.SLOW):
        deck = read_csv(os.path.join(ROOT, "docs", "studies", "data", "shear", "rheology.csv"))
        parts[series.SLOW] = slow_lines(deck, series.of(rows, series.SLOW))
    for name, lines in parts.items():
        print("\n".join(lines))
        if args.keep:
            fill(os.path.join(args.keep, "rheology.md"), lines, name)


def main():
    args = arguments()
    os.makedirs(args.folder, exist_ok=True)
    if not args.draw:
        run(args)
    if args.cases or args.series:
        (show_cases if args.cases else show_series)(args)
        return
    paths = sorted(os.path.join(args.folder, name) for name in os.listdir(args.folder)
                   if re.fullmatch(r"I.*\.h5", name))
    kept = os.path.join(ROOT, "docs", "studies", "data", "shear")
    if paths:
        read_all = sorted((read(path) for path in paths), key=lambda it: it[0])
        # Rounded as they are kept, so that the page is the same from results and from kept numbers.
        rows = [{name: float(f"{value:.8g}") for name, value in evaluate(*it).items()} for it in read_all]
        curves = [row for rate, series, _ in read_all for row in thinned(rate, series)]
    else:
        rows, curves = (read_csv(os.path.join(kept, name)) for name in ("rheology.csv", "rheology-series.csv"))
    lines = page(rows)
    print("\n".join(lines))
    if args.keep:
        if paths:
            head = ["Simple shear of 4096 disks at constant pressure: tools/studies/rheology.sh, inputs/shear/rheology.cfg",
                    *version(args)]
            folder = os.path.join(args.keep, "data", "shear")
            write_csv(os.path.join(folder, "rheology.csv"), [*head, "a row per inertial number; errors from 10 blocks"],
                      COLUMNS, rows)
            write_csv(os.path.join(folder, "rheology-series.csv"), [*head, "series, means over stretches"],
                      ("I_set", "strain", "mu", "pressure"), curves)
        draw(rows, curves, os.path.join(args.keep, "figures"))
        fill(os.path.join(args.keep, "rheology.md"), lines)
    else:
        draw(rows, curves, args.folder)


if __name__ == "__main__":
    main()

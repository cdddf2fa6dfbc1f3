"""Ten thousand and a hundred thousand disks: cost, persistence, and a map."""
import numpy as np
from matplotlib.colors import SymLogNorm
from matplotlib.patches import Rectangle

from ratchet.page import Figure, Numbers, Section
from ratchet.style import BLACK, GREY, plt
from ratchet.verdict import SURE, decide, missing, number

from . import maps
from .low import neighbour_correlation
from .statistics import pearson, spearman

RUNS = {"deposit_1e4": "deposition", "shake_1e4": "shaken", "deposit_1e5": "deposition", "shake_1e5": "shaken"}
SHAKEN = ("shake_1e4", "shake_1e5")
WINDOW = 16.0  # mean diameters: side of the parts that are enlarged
FEWEST = 3.0   # contacts of a disk that is held by its neighbours


def sections(campaign):
    out = Section("large", "Ten thousand disks",
                  "<code>inputs/packing/deposit_1e4.cfg</code>, <code>shake_1e4.cfg</code>: a packing is deposited "
                  "once and saved; the shaken box, 100 mean diameters wide, begins with it, "
                  "its contacts included. The same "
                  "with 10<sup>5</sup> disks is made by <code>tools/studies/packings.sh --large</code> only. One packing: "
                  "numbers have no error from packings.", missing=campaign.missing(*RUNS))
    cost = campaign.numbers("large-cost", lambda: cost_rows(campaign), "large packings: what they cost")
    out.tables.append(Numbers("Cost", ["run", "disks", "steps", "time of the model (s)", "wall time (s)", "threads",
                                       "disk-steps per second", "residual / scale"],
                              [list(row.values()) for row in cost.rows]))
    for name in SHAKEN:
        runs = [run for run in campaign.runs(name) if run.has_means]
        table = campaign.numbers(f"map-{name}", lambda: disks_of(runs[0]) if runs else None,
                                 "place (m), radius (m), mean angular velocity (rad/s) with its error, in both "
                                 "halves of the time, and contacts", digits=DIGITS)
        more = campaign.numbers(f"large-{name}", lambda: about(runs[0]) if runs else None, "means of the packing")
        links = campaign.numbers(f"links-{name}", lambda: links_of(runs[0]) if runs else None,
                                 "contacts in the enlarged parts: part, ends (m), normal force (N)", digits=4)
        if table.rows:
            out.claims += claims(table, more.rows[0], name)
            out.figures.append(map_figure(table, links, name))
        elif name == SHAKEN[0]:
            out.claims.append(missing("Disks rotate persistently in large packings, too.", slug="large-persistence"))
    return [out]


# --- numbers ------------------------------------------------------------------------------------------------
DIGITS = {"x": 5, "y": 5, "radius": 4, "omega": 4, "error": 2, "first": 4, "second": 4, "contacts": 3}


def cost_rows(campaign):
    found = [{"run": what, "disks": run.n_free, "steps": run.steps, "time": run.steps * run.dt, "wall": run.wall,
              "threads": run.threads, "rate": run.n_free * run.steps / run.step_seconds, "residual": abs(run.residual)}
             for name, what in RUNS.items() for run in campaign.runs(name)]
    return {key: [row[key] for row in found] for key in found[0]} if found else None


def disks_of(run):
    return {"x": run.x_end, "y": run.y_end, "radius": run.radius, "omega": run.omega, "error": run.error,
            "first": run.first, "second": run.second, "contacts": run.contacts}


def about(run):
    return {"measured": run.measured, "wander": run.wander, "neighbours": neighbour_correlation(run)[0],
            "drive": run.parameters.get("drive", 2.0)}


def windows(x, y, radius):
    """Lower left corners and side of the parts that are enlarged: at the surface, in the middle, at the floor."""
    side = WINDOW * 2 * float(np.mean(radius))
    left = float(np.median(x)) - side / 2
    near = (x > left) & (x < left + side)
    top, bottom = float(np.max((y + radius)[near])), float(np.min(y - radius))
    return [("surface", left, top - side), ("middle", left, 0.5 * (top + bottom - side)), ("floor", left, bottom)], side


def links_of(run):
    parts, side = windows(run.x_end, run.y_end, run.radius)
    ends, force = run.contact_lines()
    middle, found = ends.mean(axis=1), []
    for k, (_, x, y) in enumerate(parts):
        inside = np.all((middle > [x, y]) & (middle < [x + side, y + side]), axis=1)
        found += [{"part": k, "x1": a[0], "y1": a[1], "x2": b[0], "y2": b[1], "force": f}
                  for (a, b), f in zip(ends[inside], force[inside])]
    return {key: [row[key] for row in found] for key in found[0]} if found else None


# --- claims -------------------------------------------------------------------------------------------------
def claims(table, more, name):
    size = len(table.rows)
    omega, error, contacts = (table.column(key) for key in ("omega", "error", "contacts"))
    first, second = table.column("first"), table.column("second")
    rms, sure = float(np.sqrt(np.mean(omega ** 2))), np.abs(omega) > SURE * error
    slug = "large" if name == SHAKEN[0] else "huge"
    held, loose = contacts >= FEWEST, contacts < FEWEST
    level = [float(np.sqrt(np.mean(omega[part] ** 2))) for part in (held, loose)]
    found = [decide(f"Disks rotate persistently among {size}, too.", pearson(first, second) > 0.5,
                    f"correlation of halves {pearson(first, second):.3f} (ranks: {spearman(first, second):.2f}) in "
                    f"{more['measured']:.0f} s; rms &Omega; {number(rms)}, median |&Omega;| "
                    f"{number(float(np.median(np.abs(omega))))}, mean {number(float(omega.mean()))} rad/s; neighbours' "
                    f"&lang;&Omega;<sub>i</sub>&Omega;<sub>j</sub>&rang;/&lang;&Omega;&sup2;&rang; "
                    f"{number(more['neighbours'])}; wander {number(more['wander'])} diameters",
                    slug=f"{slug}-persistence"),
             decide(f"Among {size} disks most rotate significantly, more than 3 of their errors from zero.",
                    bool(sure.mean() > 0.5), f"{100 * sure.mean():.1f} % of the disks in {more['measured']:.0f} s; "
                    f"{100 * sure[held].mean():.1f} % of those with {FEWEST:g} contacts and more, "
                    f"{100 * sure[loose].mean():.1f} % of the {int(loose.sum())} others", slug=f"{slug}-most"),
             decide(f"Among {size} disks those that turn fast are loose: most of &Omega;&sup2; is of disks with fewer "
                    f"than {FEWEST:g} contacts.", bool(np.sum(omega[loose] ** 2) > 0.5 * np.sum(omega ** 2)),
                    f"{100 * np.sum(omega[loose] ** 2) / np.sum(omega ** 2):.1f} % of &Omega;&sup2; is of the "
                    f"{100 * loose.mean():.1f} % loose disks: rms {number(level[1])} rad/s against {number(level[0])} "
                    "of the others", slug=f"{slug}-loose")]
    return found


# --- map ----------------------------------------------------------------------------------------------------
def map_figure(table, links, name):
    x, y, radius, omega, error = (table.column(key) for key in ("x", "y", "radius", "omega", "error"))
    parts, side = windows(x, y, radius)
    width, height = float(np.ptp(x)), float(np.ptp(y))
    norm = SymLogNorm(1e-4, linscale=0.35, vmin=-1, vmax=1, base=10)
    colours = plt.get_cmap(maps.DIVERGING)(norm(omega))
    colours[~(np.abs(omega) > SURE * error)] = plt.matplotlib.colors.to_rgba(PALE)
    picture = plt.figure(figsize=(7.2, 7.0 * min(height / width, 1.1) + 3.5), layout="constrained")
    above, below = picture.subfigures(2, 1, height_ratios=[7.0 * min(height / width, 1.1) + 0.8, 2.7])
    axes = above.subplots()
    maps.disks(axes, x, y, radius, colours, edge="none", width=0)
    maps.frame(axes, x, y, radius)
    axes.set_xlabel("$x$ (m)")
    axes.set_ylabel("$y$ (m)")
    for panel, (k, (title, left, bottom)) in zip(below.subplots(1, len(parts)), enumerate(parts)):
        axes.add_patch(Rectangle((left, bottom), side, side, fill=False, lw=1.2, ec=BLACK, zorder=5))
        axes.text(left + side, bottom + side / 2, f" {'abc'[k]}", va="center", fontsize=12, zorder=6,
                  bbox={"fc": "white", "ec": "none", "pad": 0.6, "alpha": 0.8})
        inside = (np.abs(x - left - side / 2) < side / 2 + radius) & (np.abs(y - bottom - side / 2) < side / 2 + radius)
        maps.disks(panel, x[inside], y[inside], radius[inside], colours[inside], edge=GREY, width=0.3)
        own = [row for row in links.rows if row["part"] == k]
        if own:
            maps.contacts(panel, np.array([[[row["x1"], row["y1"]], [row["x2"], row["y2"]]] for row in own]),
                          np.array([row["force"] for row in own]), 2.0)
        panel.set(xlim=(left, left + side), ylim=(bottom, bottom + side), xticks=[], yticks=[], aspect="equal")
        panel.set_title(f"({'abc'[k]}) {title}", fontsize=10.5)
    maps.colour_bar(above, axes, norm, r"$\Omega_i$ (rad/s)", shrink=0.9, extend="both", location="top", aspect=45)
    sure = 100 * float(np.mean(np.abs(omega) > SURE * error))
    return Figure("map-large" if name == SHAKEN[0] else "map-huge", picture,
                  f"{len(x)} disks coloured by mean angular velocity, red counter-clockwise, logarithmic beyond 10<sup>"
                  f"&minus;4</sup> rad/s. Grey: the {100 - sure:.0f} % within 3 errors of "
                  f"zero. Below: parts of {WINDOW:g} "
                  "mean diameters enlarged, with contacts at the end of the run, as wide as their normal forces.",
                  "Map of many disks coloured by mean angular velocity, with three parts enlarged")


PALE = "#E4E4E4"

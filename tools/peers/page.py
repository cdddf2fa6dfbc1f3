"""Results as Markdown: tables, and the parts of docs/performance.md that they fill."""
import os
import re

from . import bench, law_page, timing

ORDER = ("slipdisk", "slipdisk, baseline", "LAMMPS granular", "LAMMPS hooke", "LAMMPS hooke, native", "LAMMPS granular, newest",
         "LAMMPS hooke, newest", "LIGGGHTS")
BUSY = 0.3  # load before the start above which a machine was not quiet


def table(columns, rows):
    out = ["| " + " | ".join(columns) + " |", "|---" + "|---:" * (len(columns) - 1) + "|"]
    return out + ["| " + " | ".join(row) + " |" for row in rows]


def percent(value):
    return "-" if value == 0 else f"{100 * value:+.2g} %"


def power(count):
    """1000 as 1e3, 2500 as it is."""
    text = f"{count:.0e}".replace("e+0", "e")
    return text if float(text) == count else str(count)


def names_in(rows):
    return sorted(rows, key=lambda name: ORDER.index(name) if name in ORDER else len(ORDER))


def time_cells(values, reference):
    """Median with the quartiles' distance, and the ratio to the reference with its range."""
    own = timing.Times(values)
    middle, least, largest = timing.ratio(own, timing.Times(reference))
    return [f"{own.median:.3g} ({100 * own.spread:.0f} %)", f"{middle:.2f} ({least:.2f} to {largest:.2f})"]


def packings(sizes):
    """sizes: {disks: what bench.compare gives}"""
    out, rows = [], []
    for cores in ("1", "2"):
        out += times_of(in_order(sizes), cores)
    names = names_in({name for _, found in in_order(sizes) for name in found["physics"]} - {"slipdisk"})
    for name in names:
        every = [found["physics"][name] for _, found in in_order(sizes) if name in found["physics"]]
        rows.append([name, *(percent(max((it["off"][what] for it in every), key=abs)) for what in ("contacts", "overlap", "kinetic")),
                     f"{max(it['distance'] for it in every):.1e}", "yes" if all(it["agrees"] for it in every) else "**no**"])
    bounds = ", ".join(f"{what} {100 * bound:g} %" for what, bound in bench.TOLERANCES.items())
    return [*out, "Physics, the largest difference to slipdisk of means over "
            + ", ".join(f"{found['frames']} frames of {found['check_steps']} steps ({power(int(count))})"
                        for count, found in in_order(sizes))
            + f"; agreement within {bounds}:", "",
            *table(["program", "contacts per disk", "mean overlap", "kinetic energy", "distance at the end, mean radii", "agrees"],
                   rows), ""]


def times_of(sizes, cores):
    """Rows are programs, columns sizes."""
    sizes = [(count, found) for count, found in sizes if found["times"].get(cores)]
    if not sizes:
        return []
    columns, rows = ["program"], {}
    for count, found in sizes:
        times = found["times"][cores]
        columns += [power(int(count)), "ratio"]
        for name in names_in(times):
            rows.setdefault(name, {})[count] = time_cells(times[name], times["slipdisk"])
    title = ("Time, one core, ns per disk-step and ratio to slipdisk; in parentheses the quartiles' distance over the median, the "
             "least and largest ratio of neighbouring repeats; ") if cores == "1" else (
                 "The same, two cores (slipdisk: two threads; LAMMPS, LIGGGHTS: two ranks), ")
    repeats = ", ".join(f"{len(found['times'][cores]['slipdisk'])} repeats of {found['steps']} steps ({power(int(count))})"
                        for count, found in sizes)
    return [f"{title}{repeats}:", "",
            *table(columns, [[name, *(cell for count, _ in sizes for cell in rows[name].get(count, ["", ""]))]
                             for name in names_in(rows)]), ""]


def in_order(sizes):
    return sorted(sizes.items(), key=lambda item: int(item[0]))


def three(found):
    rows = [[name, *time_cells(values, found["times"]["slipdisk"]), str(len(values))]
            for name, values in found["times"].items()]
    out = [f"One disk on two supports that shake, {found['steps']} steps of {found['dt']:g}, one core, ns per step of one "
           "system:", "", *table(["program", "median", "ratio to slipdisk", "repeats"], rows), ""]
    rows = [[name, f"{it['x']:.9f}", f"{it['y']:.9f}", f"{it['omega']:.6g}", f"{it['off']:.1e}"]
            for name, it in found["physics"].items()]
    return out + [f"Physics: the upper disk after {found['check_steps']} steps; the last column is the largest difference "
                  "of its path to slipdisk's, over the path's own extent:", "",
                  *table(["program", "x", "y", "angular velocity", "path differs"], rows), ""]


def accuracy(found):
    rows = [[f"{row['loop']}, {row['program']}", *(f"{value:.2e}" for value in row["left"]), f"{row['expected']:.2e}"]
            for row in found["loops"]]
    cycles = [f"{cycle} times" if cycle > 1 else "once" for cycle in found["cycles"]]
    out = ["What is left of the tangential displacement when the bodies are back where they began, in radii:", "",
           *table(["loop, program", *cycles, "expected, once"], rows), ""]
    rows = [[row["program"], "yes" if row["same"] else "no", *(f"{value:.1e}" for value in row["off"])]
            for row in found["restarts"]]
    return out + [f"{found['disks']} disks, {found['before']} steps, a restart, and some steps more against a run without "
                  "a restart (slipdisk: interrupted once, anywhere); the largest difference of a position (in mean radii), "
                  "of a velocity and of an angular velocity (over the largest there is):", "",
                  *table(["program, steps after the restart", "the same bits", "position", "velocity",
                          "angular velocity"], rows), ""]


PARTS = {"packings": packings, "three": three, "accuracy": accuracy, "laws": law_page.render}


def part(name, results, brief=False):
    """Markdown of one comparison, with where and when it was made; brief: as docs/performance.md has it."""
    found = results[name]
    made = found["made"]
    lines = [f"{made['machine']}. " + ", ".join(f"{key} {value}" for key, value in made["versions"].items()) + "."]
    if made["load"] > BUSY and name in ("packings", "three"):
        lines += [f"**The machine was not quiet** (load {made['load']:.1f} before the start): times are not worth "
                  "much."]
    render = law_page.brief if brief and name == "laws" else PARTS[name]
    return [*lines, "", *render(found["data"])]


def fill(path, results, brief=True):
    """Puts the tables between the comments `<!-- NAME -->` and `<!-- end of NAME -->` of a page."""
    with open(path) as file:
        text = file.read()
    for name in PARTS:
        if name not in results:
            continue
        mark = re.compile(rf"(<!-- {name} -->\n).*?(<!-- end of {name} -->)", re.S)
        if not mark.search(text):
            raise ValueError(f"{path}: no <!-- {name} --> ... <!-- end of {name} -->")
        body = "\n".join(part(name, results, brief)).rstrip() + "\n"
        text = mark.sub(lambda found, body=body: found.group(1) + body + found.group(2), text)
    with open(path + ".new", "w") as file:
        file.write(text)
    os.replace(path + ".new", path)

# Draws crush.png: stress against strain, number of broken bonds, and the bonds at the peak and at the end. Prints the peak.
#   python3 crush.py compression.h5 [other results of compression.cfg ...]
import sys

import slipdisk
from slipdisk import plot
from slipdisk.plot_style import figure, look, save


def curve(result):
    """Strain, stress, and broken bonds while the plates press."""
    s, start = result.series, result.phases["steps"][:2].sum() * result.dt
    width = s["width"][s["time"] < start - 20].min()  # before the sides went away
    load = s["time"] >= start
    height = s["height"][load]
    lid = result.rows("observables/walls").split("\n").index("lid")
    return 1 - height / height[0], s["wall_normal"][load][:, lid] / width, s["broken_bonds"][load], s["time"][load]


with look():
    picture = figure(10, 4)
    axes, peak_axes, end_axes = picture.subplots(1, 3, width_ratios=[2, 1, 1])
    count = axes.twinx()
    for k, path in enumerate(sys.argv[1:]):
        result = slipdisk.Result(path)
        strain, stress, broken, time = curve(result)
        peak = stress.argmax()
        rise = slice(0, (stress > stress[peak] / 2).argmax())
        modulus = (stress[rise] * strain[rise]).sum() / (strain[rise] ** 2).sum()
        kinetic, elastic = (result.series[name][-len(time):][peak] for name in ("kinetic_translation", "elastic_bond"))
        print(f"{path}: peak {stress[peak]:.3f}  strain {strain[peak]:.5f}  modulus {modulus:.0f}  broken {broken[peak]} of {result.series['bonds'].max()}, "
              f"at the end {broken[-1]}  kinetic/elastic {kinetic / elastic:.1e}")
        axes.plot(1000 * strain, stress, lw=1, color=f"C{k}")
        count.plot(1000 * strain, broken, "--", lw=1, color=f"C{k}")
        if k == 0:
            plot.bonds(result, peak_axes, frame=int(abs(result.frames.time - time[peak]).argmin()))
            plot.bonds(result, end_axes, frame=-1)
    axes.set(xlabel="strain (1/1000)", ylabel="stress over the strength of the cement")
    count.set_ylabel("broken bonds (dashed)")
    save(picture, "crush.png", 100)

"""Where nothing may rotate: without friction, and in cages that are symmetric under reflection."""
import numpy as np

from ratchet.page import Figure, Section
from ratchet.style import COLOURS, GREY, figure
from ratchet.verdict import SURE, NO, OPEN, TRIVIAL, YES, Claim, chi_square, decide, missing, number

from . import maps
from .drive import bars, by_drive
from .statistics import mean_error


ROUNDING = 1e-9  # rad/s: less is not physics


def sections(campaign):
    out = Section("controls", "Controls: where nothing may rotate",
                  "Frictionless: the shaken boxes with &mu; = 0. Symmetric: <code>inputs/packing/cage.cfg</code>, 60 "
                  "equal disks "
                  "on a triangular lattice, periodic in x, on a flat floor shaken along the vertical: every cage is "
                  "its own "
                  "mirror image.", missing=campaign.missing("frictionless", "cage"))
    out.claims.append(frictionless([run for run in campaign.runs("frictionless") if run.has_means]))
    table = by_drive(campaign.runs("cage"))
    if not table:
        out.claims.append(missing("In a symmetric cage nothing rotates beyond noise.", slug="symmetric"))
        return [out]
    low = by_drive(campaign.runs("drive"))
    for drive, runs in table.items():
        reference = [run.rms for run in low.get(drive, [])]
        out.claims.append(symmetric(drive, runs, np.mean(reference) if reference else np.nan))
    out.figures.append(cage_figure(table, low))
    out.figures.append(cage_map(table[min(table, key=lambda drive: abs(drive - 0.5))][0]))
    return [out]


def frictionless(runs):
    text = "Without friction nothing rotates: &Omega; of every disk is exactly 0."
    if not runs:
        return missing(text, slug="frictionless")
    largest = max(float(np.abs(run.omega).max()) for run in runs)
    drives = sorted({run.parameters.get("drive", np.nan) for run in runs})
    return decide(text, largest == 0, f"{sum(len(run.omega) for run in runs)} disks in {len(runs)} packings at "
                  + ", ".join(f"{d:g}" for d in drives) + f" <i>g</i>: largest |&Omega;| = {number(largest)} rad/s",
                  kind=TRIVIAL, slug="frictionless")


def layers(run):
    """(mean Omega, mean error) of each layer of the lattice: its disks move nearly alike, so they are no independent
    numbers, and the error of the mean is taken for that of one disk."""
    order = np.argsort(run.y_end)
    cuts = np.nonzero(np.diff(run.y_end[order]) > run.radius.mean())[0] + 1
    return np.array([(run.omega[part].mean(), run.error[part].mean()) for part in np.split(order, cuts)]).T


def symmetric(drive, runs, reference):
    text = f"In symmetric cages no disk rotates beyond noise, at {drive:g} <i>g</i>."
    omega, error = (np.concatenate([getattr(run, name) for run in runs]) for name in ("omega", "error"))
    rms = float(np.sqrt(np.mean(omega ** 2)))
    told = f"{len(omega)} disks: rms &Omega; {number(rms)} rad/s"
    if np.isfinite(reference) and reference > 0:
        told += f", {number(rms / reference)} of that of the irregular packings at this drive"
    if rms < ROUNDING:
        return decide(text, True, told + ": rounding", slug=f"symmetric-{drive:g}g")
    mean, own = np.concatenate([layers(run) for run in runs], axis=1)
    chi2, chance = chi_square(mean / own, len(mean))
    beyond = int(np.sum(np.abs(omega) > SURE * error))
    told += (f", rms error {number(float(np.sqrt(np.mean(error ** 2))))}; {beyond} beyond 3 errors, largest "
             f"{np.abs(omega / error).max():.1f} errors; of the {len(mean)} layers &chi;&sup2; = {chi2:.1f} "
             f"(a chance of {100 * chance:.2g} %)")
    verdict = YES if chance > 0.01 and beyond <= 0.05 * len(omega) else NO if chance < 1e-4 else OPEN
    return Claim(text, verdict, told, slug=f"symmetric-{drive:g}g")


def cage_figure(table, low):
    picture, axes = figure(height=3.9)
    for k, (name, runs_at, sign) in enumerate((("irregular packings", low, "o"), ("symmetric cages", table, "s"))):
        if runs_at:
            value, error = np.array([mean_error([run.rms for run in runs]) for runs in runs_at.values()]).T
            axes.errorbar(list(runs_at), value, yerr=bars(value, error), fmt=sign + "-", lw=0.7, mfc="white",
                          color=COLOURS[k], label=name)
    noise = [float(np.sqrt(np.mean([run.noise ** 2 for run in runs]))) for runs in table.values()]
    axes.plot(list(table), noise, "x:", lw=0.7, color=COLOURS[1], label="their rms error bar")
    axes.axhline(ROUNDING, color=GREY, lw=0.8, ls="--", gid="guide")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("peak acceleration of the floor / $g$")
    axes.set_ylabel(r"rms $\Omega$ (rad/s)")
    axes.legend(loc="lower right")
    return Figure("cage", picture, "Typical mean angular velocity in symmetric cages and in irregular packings. Dashed: what "
                  "is below is rounding.", "Typical mean angular velocity against drive, symmetric and irregular packings")


def cage_map(run):
    picture, axes = figure(width=6.2, height=3.6)
    norm = maps.scale(run.omega, clip=max(float(np.abs(run.omega).max()), 1e-12))
    maps.rotation_map(axes, run, norm)
    maps.colour_bar(picture, axes, norm, r"$\Omega_i$ (rad/s)", shrink=0.85)
    return Figure("map-cage", picture, f"The symmetric packing at {run.parameters.get('drive', 0):g} g: colours are "
                                       f"noise (note the "
                  "scale).", "Map of the symmetric packing coloured by mean angular velocity")

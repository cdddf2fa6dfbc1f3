"""Where nothing may rotate: without friction, and in cages that are symmetric under reflection."""
import numpy as np

from report.page import Figure, Section
from report.style import COLOURS, GREY, figure
from report.verdict import SURE, NO, OPEN, YES, Claim, chi_square, decide, missing, number

from .drive import by_drive
from . import maps


def sections(campaign):
    out = Section("controls", "Controls: where nothing may rotate",
                  "Frictionless: the shaken boxes with &mu; = 0. Symmetric: <code>inputs/packing/cage.cfg</code>, 60 equal disks "
                  "on a triangular lattice, periodic in x, on a flat floor shaken along the vertical: every cage is its own "
                  "mirror image.", missing=campaign.missing("frictionless", "cage"))
    out.claims.append(frictionless([run for run in campaign.runs("frictionless") if run.has_means]))
    table = by_drive(campaign.runs("cage"))
    if not table:
        out.claims.append(missing("In a symmetric cage nothing rotates beyond noise."))
        return [out]
    low = by_drive(campaign.runs("drive"))
    for drive, runs in table.items():
        reference = [run.rms for run in low.get(drive, [])]
        out.claims.append(symmetric(drive, runs, np.mean(reference) if reference else np.nan))
    out.figures.append(cage_figure(table, low))
    out.figures.append(cage_map(list(table.values())[0][0]))
    return [out]


def frictionless(runs):
    text = "Without friction nothing rotates: &Omega; of every disk is exactly 0."
    if not runs:
        return missing(text)
    largest = max(float(np.abs(run.omega).max()) for run in runs)
    drives = sorted({run.parameters.get("drive", np.nan) for run in runs})
    return decide(text, largest == 0, f"{sum(len(run.omega) for run in runs)} disks in {len(runs)} packings at "
                  + ", ".join(f"{d:g}" for d in drives) + f" <i>g</i>: largest |&Omega;| = {number(largest)} rad/s")


def symmetric(drive, runs, reference):
    text = f"In symmetric cages no disk rotates beyond noise, at {drive:g} <i>g</i>."
    omega, error = (np.concatenate([getattr(run, name) for run in runs]) for name in ("omega", "error"))
    moving = error > 0
    rms = float(np.sqrt(np.mean(omega ** 2)))
    told = f"{len(omega)} disks: rms &Omega; {number(rms)} rad/s"
    if np.isfinite(reference) and reference > 0:
        told += f", {number(rms / reference)} of that of the irregular packings at this drive"
    if not moving.any():
        return decide(text, bool(rms == 0), told + "; no angle ever changed")
    z = omega[moving] / error[moving]
    chi2, chance = chi_square(z, len(z))
    beyond = int(np.sum(np.abs(z) > SURE))
    expected = 0.0027 * len(z)
    told += (f", rms error {number(float(np.sqrt(np.mean(error[moving] ** 2))))}; &chi;&sup2; = {chi2:.1f} for {len(z)} disks (a chance of "
             f"{100 * chance:.2g} %); {beyond} beyond 3 errors ({expected:.1f} expected by chance); largest "
             f"{np.abs(z).max():.1f} errors")
    verdict = YES if chance > 0.01 else NO if chance < 1e-4 else OPEN
    return Claim(text, verdict, told)


def cage_figure(table, low):
    picture, axes = figure(height=3.9)
    top = 6.0
    x = np.linspace(-top, top, 200)
    edges = np.linspace(-top, top, 25)
    for k, (drive, runs) in enumerate(table.items()):
        z = np.concatenate([run.omega / np.where(run.error > 0, run.error, np.inf) for run in runs])
        axes.hist(np.clip(z, -top, top), edges, density=True, histtype="step", lw=1.3, color=COLOURS[k],
                  label=f"symmetric, {drive:g} $g$")
    for drive in [d for d in table if d in low][:1]:
        z = np.concatenate([run.omega / np.where(run.error > 0, run.error, np.inf) for run in low[drive]])
        axes.hist(np.clip(z, -top, top), edges, density=True, histtype="stepfilled", alpha=0.25, color=COLOURS[-1],
                  label=f"irregular, {drive:g} $g$ (ends: beyond)")
    axes.plot(x, np.exp(-x * x / 2) / np.sqrt(2 * np.pi), color=GREY, lw=1, label="chance alone", gid="guide")
    axes.set_xlim(-top, top)
    axes.set_xlabel(r"$\Omega_i$ / its error")
    axes.set_ylabel("probability density")
    axes.legend(loc="upper left", fontsize=9)
    return Figure("cage", picture, "Mean angular velocities in units of their errors, in symmetric cages and, for comparison, in "
                  "the irregular packings.", "Distribution of mean angular velocities over their errors, symmetric cages")


def cage_map(run):
    picture, axes = figure(width=6.2, height=3.6)
    norm = maps.scale(run.omega, clip=max(float(np.abs(run.omega).max()), 1e-12))
    maps.rotation_map(axes, run, norm)
    maps.colour_bar(picture, axes, norm, r"$\Omega_i$ (rad/s)", shrink=0.85)
    return Figure("map-cage", picture, f"The symmetric packing at {run.parameters.get('drive', 0):g} g: colours are noise (note the "
                  "scale).", "Map of the symmetric packing coloured by mean angular velocity")

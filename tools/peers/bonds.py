"""A bonded sheet that is torn, in slipdisk and in LAMMPS (bond_style bpm/rotational, of the newest version):

    tools/compare_peers.sh --newest --sizes 1000       once: puts the newest LAMMPS into build/newest
    PYTHONPATH=tools SLIPDISK_LIBRARY=build/release/libslipdisk.so python3 -m peers.bonds            prints a table

A triangular lattice of equal disks, which touch, with holes at random. Its lowest row is held, the uppermost one is pulled away. Disks whose
bond is broken do not touch one another. Both programs make the same steps (velocity Verlet)."""
import os
import pathlib
import random
import tempfile

import numpy as np
import slipdisk

from . import programs

ROOT = pathlib.Path(__file__).resolve().parents[2]
WIDE, HIGH, HOLES = 12, 10, 0.08
K_N, K_T, BENDING = 1000.0, 400.0, 30.0          # LAMMPS: K_r, K_s, K_b
TENSION, SHEAR, MOMENT = 3.0, 3.0, 0.6           # strengths
GAMMA_N = GAMMA_T = 2.0
INERTIA = 0.4 * 0.25                             # of a sphere of mass 1, as LAMMPS has it
DT, STEPS, EVERY, SPEED = 2e-4, 16000, 50, 0.02
HEIGHT = (HIGH - 1) * np.sqrt(0.75)


def sheet(seed):
    """(x, y, row) of each disk"""
    r = random.Random(seed)
    return [(i + 0.5 * (j % 2), float(j * np.sqrt(0.75)), j) for j in range(HIGH) for i in range(WIDE)
            if j in (0, HIGH - 1) or r.random() >= HOLES]


def by_slipdisk(disks, scale):
    """(force on the upper row, number of bonds) in turn, and the pairs whose bond is left. scale: of strengths and speed."""
    arm = 0.25  # R_eff
    law = {"name": "m", "k_n": 1e-9, "bond_k_n": K_N, "bond_k_t": K_T, "bond_k_r": BENDING / arm**2, "bond_gap": 1e-6,
           "bond_gamma_n": GAMMA_N, "bond_gamma_t": GAMMA_T, "bond_max_tension": scale * TENSION, "bond_max_shear": scale * SHEAR,
           "bond_max_bending": scale * MOMENT}
    upper = [f"disk{k}" for k, disk in enumerate(disks) if disk[2] == HIGH - 1]
    deck = {"dt": DT, "integrator": "verlet", "contact_variant": "conservative", "materials": [law],
            "disks": [{"name": f"disk{k}", "x": x, "y": y, "radius": 0.5, "mass": 1.0,
                       **({"fixed": True} if row in (0, HIGH - 1) else {"inertia": INERTIA})} for k, (x, y, row) in enumerate(disks)],
            "motions": [{"disk": upper, "coordinate": "y", "type": "velocity", "velocity": scale * SPEED}],
            "phases": [{"steps": STEPS, "bond": {}}]}
    sim = slipdisk.Simulation(deck)
    pulled = np.array([disk[2] == HIGH - 1 for disk in disks])
    found = []
    for _ in range(STEPS // EVERY):
        sim.advance(EVERY)
        found.append((-sim.disks["force_y"][pulled].sum(), (sim.contacts["bond"] > 0).sum()))
    left = sim.contacts["bond"] > 0
    pairs = zip(sim.contacts["a"][left].tolist(), sim.contacts["b"][left].tolist())
    return np.array(found), {tuple(sorted(pair)) for pair in pairs}


def script(disks, scale):
    """The input of LAMMPS."""
    atoms = "\n".join(f"create_atoms 1 single {x!r} {y!r} 0" for x, y, _ in disks)
    return f"""units lj
boundary f f p
atom_style bpm/sphere
special_bonds lj 0 1 1 coul 0 1 1
newton on off
comm_modify vel yes cutoff 2.6
region box block -3 {WIDE + 3} -3 {HIGH + 3} -0.6 0.6
create_box 1 box bond/types 1 extra/bond/per/atom 6 extra/special/per/atom 60
{atoms}
set group all diameter 1
set group all density {6 / np.pi!r}
pair_style zero 1.5
pair_coeff * *
neighbor 0.4 bin
create_bonds many all all 1 0.9 1.1
bond_style bpm/rotational smooth no
special_bonds lj 0 1 1 coul 1 1 1
bond_coeff 1 {K_N} {K_T} {BENDING} {BENDING} {scale * TENSION} {scale * SHEAR} {scale * MOMENT} {scale * MOMENT} {GAMMA_N} {GAMMA_T} 0 0
region lower block INF INF INF 0.1 INF INF
region upper block INF INF {HEIGHT - 0.1!r} INF INF INF
group lower region lower
group upper region upper
group free subtract all lower upper
fix move free nve/bpm/sphere
fix pull upper move linear 0 {scale * SPEED!r} 0
fix hold lower move linear 0 0 0
timestep {DT!r}
compute number all nbond/atom
compute bonds all reduce sum c_number
compute force upper reduce sum fy
thermo_style custom step c_force c_bonds
thermo_modify norm no format float %.12g
thermo {EVERY}
run {STEPS}
compute left all property/local batom1 batom2
run 0 post no
write_dump all local left.txt c_left[1] c_left[2]
"""


def by_lammps(program, disks, scale):
    """As by_slipdisk. Bonds within the two rows count there alone: they are left out."""
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "in.sheet").write_text(script(disks, scale))
        out = programs.run_script(program, os.path.join(folder, "in.sheet"), [])
        left = np.loadtxt(pathlib.Path(folder) / "left.txt", skiprows=9, dtype=int) - 1
    rows = [line.split() for line in out.split("c_bonds")[1].splitlines()[1:]]
    rows = [row for row in rows if len(row) == 3 and row[0].isdigit()]
    held = 2 * (WIDE - 1)
    found = np.array([(-float(row[1]), float(row[2]) / 2 - held) for row in rows[1:]])
    prescribed = {k for k, disk in enumerate(disks) if disk[2] in (0, HIGH - 1)}
    return found, {tuple(sorted(pair)) for pair in left.tolist() if not set(pair) <= prescribed}


def main():
    program = programs.find("lammps_newest") or str(ROOT / "build" / "newest" / "lmp")
    print("| sheet | strain of the first break | broken of all | the same bonds | as many at | peak force, slipdisk, LAMMPS "
          "| off before the first break, at any time |")
    print("|---|---:|---:|---|---|---|---|")
    for seed, scale in [(k, 1.0) for k in range(1, 7)] + [(1, 0.5), (1, 0.25), (1, 0.125)]:
        disks = sheet(seed)
        own, pairs = by_slipdisk(disks, scale)
        other, others = by_lammps(program, disks, scale)
        first = int(np.argmax(own[:, 1] < own[0, 1]))
        peak, off = own[:, 0].max(), abs(other[:, 0] - own[:, 0]) / abs(own[:, 0]).max()
        together = int((own[:, 1] == other[:, 1]).sum())
        strain = (first + 1) * EVERY * DT * scale * SPEED / HEIGHT
        print(f"| {seed}, {scale:g} | {strain:.5f} | {own[0, 1] - own[-1, 1]:.0f} of {own[0, 1]:.0f} | {'yes' if pairs == others else 'no'} "
              f"| {together} of {len(own)} | {peak:.4f}, {other[:, 0].max():.4f} | {off[:first].max():.1e}, {off.max():.1e} |", flush=True)


if __name__ == "__main__":
    main()

"""What the tangential memory keeps: round closed loops, and over a restart.

Loops, of two disks that overlap and stick. "circle": one is led round a small circle beside the other and does not
turn. "turn": both turn about the centre of one of them like a rigid body. Back where they began nothing should be left
of the tangential displacement. slipdisk's is a function of coordinates, lambda (docs/physics.md, 3): nothing is. The
others add up velocities times dt. Even with infinitely small steps this leaves the integral of r dbeta over the circle,
since r changes on the way; and LAMMPS takes the turning of surfaces from radii, the moving of centres from their
distance r, so that its stretch changes by R_a + R_b - r times the angle of a rigid turn.

Restarts: a packing goes on from a restart file (slipdisk: is interrupted and continues) and is compared with one
that was not stopped."""
import math
import os
import signal
import subprocess
import time

import numpy as np
from slipdisk import sealed

from . import frames, inputs, packing, programs

LAW = inputs.Law(k_n=1e4, k_t=1e4, gamma_n=0, mu=1e4)   # so much friction that nothing slides
OVERLAP, CIRCLE = 0.01, 0.005   # of disks of radius 1 and mass 1; radius of the circle
APART = 2 - OVERLAP
LAP, DT = 1000, 1e-4            # steps once round, and the step
CYCLES = (1, 10, 100)
DISKS, BEFORE, EVERY = 1000, inputs.PERIOD, 25  # of the restart
LONG = 25_000_000               # disk-steps of slipdisk, so that there is time to interrupt it
W = 2 * math.pi / (LAP * DT)


def expected(loop, who):
    """What is left after once round, for exact integration."""
    if who == "slipdisk":
        return 0.0
    if loop == "turn":
        return 2 * math.pi * OVERLAP if who.startswith("LAMMPS") else 0.0
    angle = 2 * np.pi * (np.arange(4096) + 0.5) / 4096
    x, y = APART + CIRCLE * (np.cos(angle) - 1), CIRCLE * np.sin(angle)
    dx, dy = -CIRCLE * np.sin(angle), CIRCLE * np.cos(angle)
    return abs(float(((x * dy - y * dx) / np.hypot(x, y)).mean() * 2 * np.pi))  # r dbeta


# --- loops: inputs ----------------------------------------------------------------------------------------------
def loop_deck(loop):
    """A contact of two bodies that are prescribed altogether is not computed beside free ones: so the led disk may turn, but is too
    inert to. Motions add to where a disk is put: in "turn" the disk in the middle is put elsewhere, since two disks may
    not be put in the same place."""
    head = f'dt = {DT!r};\nintegrator = "verlet";\n' + inputs.material(LAW)
    head += "limits = { displacement = 0; };\n"  # the first step takes disks to where the loop begins
    tail = (f"steps = {LAP * CYCLES[-1]};\noutput = {{ series = 0; contacts = {LAP}; }};\n"
            "measure = { rotation = (); };\n")
    inert = "radius = 1; mass = 1; inertia = 1e30;"
    around = 'type = "harmonic"; omega = {w!r}; amplitude = {a!r}'
    if loop == "circle":
        led = around.format(w=W, a=CIRCLE)
        return (head + 'disks = (\n  { name = "a"; x = 0; y = 0; radius = 1; mass = 1; fixed = true; },\n'
                f'  {{ name = "b"; x = {APART - CIRCLE!r}; y = 0; {inert} }}\n);\nmotions = (\n'
                f'  {{ name = "x"; disk = "b"; coordinate = "x"; {led}; phase = "90 deg"; }},\n'
                f'  {{ name = "y"; disk = "b"; coordinate = "y"; {led}; }}\n);\n' + tail)
    led = around.format(w=W, a=APART)
    turning = f"{inert} omega = {W!r};"
    return (head + f'disks = (\n  {{ name = "a"; x = -10; y = 0; {turning} locked = "y"; }},\n'
            f'  {{ name = "b"; x = 0; y = 0; {turning} }}\n);\nmotions = (\n'
            '  { name = "beside"; disk = "a"; coordinate = "x"; type = "table"; '
            'times = (0, 1e5, 1e6); values = (10, 10, 10); },\n'
            f'  {{ name = "x"; disk = "b"; coordinate = "x"; {led}; phase = "90 deg"; }},\n'
            f'  {{ name = "y"; disk = "b"; coordinate = "y"; {led}; }}\n);\n' + tail)


def loop_script(style, loop, data, out):
    old = style == "liggghts"
    head = inputs.liggghts_style("f") if old else inputs.lammps_style("f")
    pair = inputs.liggghts_law(LAW)[0] if old else inputs.lammps_law(style, LAW, 1.0)[0]
    if loop == "circle":
        angle = f"({W * DT!r}*step)"
        move = (f"variable x equal {CIRCLE!r}*(cos{angle}-1)\nvariable y equal {CIRCLE!r}*sin{angle}\n"
                f"variable u equal {-CIRCLE * W!r}*sin{angle}\nvariable v equal {CIRCLE * W!r}*cos{angle}\n"
                "group led id 2\nfix lead led move variable v_x v_y NULL v_u v_v NULL\n")
    else:
        move = f"fix lead all move rotate 0 0 0 0 0 1 {LAP * DT!r}\n"
    return (head + f"read_data {data}\n" + inputs.lists(0.2, DT) + pair + move
            + f"dump forces all custom {LAP} {out} id fy\ndump_modify forces sort id format {'' if old else 'line '}"
            f'"%d %.17g"\nthermo 1000000000\nrun {LAP * CYCLES[-1]}\n')


def write_pair(path, spheres):
    density = 1 / (4 / 3 * math.pi if spheres else math.pi)
    with open(path, "w") as file:
        file.write("two disks\n\n2 atoms\n1 atom types\n\n-8 8 xlo xhi\n-8 8 ylo yhi\n-1 1 zlo zhi\n\nAtoms\n\n"
                   f"1 1 2.0 {density!r} 0 0 0\n2 1 2.0 {density!r} {APART!r} 0 0\n")


# --- loops: what is left ----------------------------------------------------------------------------------------
def left_in_slipdisk(result):
    """Stretch of the contact each time round."""
    with sealed.read(result) as file:
        contacts = file["contacts"]
        steps, counts, stretch = contacts["step"][:], contacts["count"][:], (contacts["zeta"] if "zeta" in contacts else contacts["stretch"])[:]
    if not (counts[1:] == 1).all():
        raise programs.Failed(f"{result}: the contact opened")
    return {int(step) // LAP: float(value) for step, value in zip(steps[1:], stretch[1 - len(steps):])
            if step % LAP == 0}


def left_in_dump(path):
    """There the other disk lies along x, so that its force along y is k_t times the stretch."""
    left = {}
    with open(path) as file:
        lines = file.read().split("ITEM: TIMESTEP\n")[1:]
    for block in lines:
        rows = block.splitlines()
        left[int(rows[0]) // LAP] = float(rows[-1].split()[1]) / LAW.k_t
    return left


def loops(setup, folder, core):
    found = []
    peers = [(f"LAMMPS {style}", style, setup.lammps) for style in ("granular", "hooke")] if setup.lammps else []
    peers += [("LIGGGHTS", "liggghts", setup.liggghts)] if setup.liggghts else []
    write_pair(os.path.join(folder, "lammps.data"), True)
    write_pair(os.path.join(folder, "liggghts.data"), False)
    for loop in ("circle", "turn"):
        setup.say(f"loop: {loop}")
        deck, result = os.path.join(folder, loop + ".cfg"), os.path.join(folder, loop + ".h5")
        with open(deck, "w") as file:
            file.write(loop_deck(loop))
        programs.slipdisk(setup.program, deck, result, core)
        left = {"slipdisk": left_in_slipdisk(result)}
        for name, style, program in peers:
            script = os.path.join(folder, f"{loop}-{style}.in")
            with open(script, "w") as file:
                data = "liggghts.data" if style == "liggghts" else "lammps.data"
                file.write(loop_script(style, loop, data, script + ".dump"))
            setup.note(name.split()[0], programs.run_script(program, script, core))
            left[name] = left_in_dump(script + ".dump")
        found += [{"loop": loop, "program": name, "left": [abs(it[cycle]) for cycle in CYCLES],
                   "expected": expected(loop, name)} for name, it in left.items()]
    return found


# --- restarts -----------------------------------------------------------------------------------------------------
def off(one, other, width):
    """(are the bits the same, largest differences of position, velocity and angular velocity)"""
    same = all(np.array_equal(getattr(one, name), getattr(other, name)) for name in ("x", "y", "vx", "vy", "omega"))
    dx = one.x - other.x
    dx -= width * np.round(dx / width)
    place = np.hypot(dx, one.y - other.y).max() / packing.MEAN
    speed = np.hypot(one.vx - other.vx, one.vy - other.vy).max() / np.hypot(one.vx, one.vy).max()
    spin = np.abs(one.omega - other.omega).max() / np.abs(one.omega).max()
    return same, [float(place), float(speed), float(spin)]


def interrupted(setup, deck, result, core, last):
    """Runs a deck of so many steps, stops it on the way, lets it go on; returns the step at which it was stopped."""
    words = programs.bound([setup.program, "run", deck, "-o", result, "--quiet", "--threads", "1"], core)
    for wait in (0.3, 0.15, 0.6, 0.1, 1.2, 0.05, 2.4):
        with subprocess.Popen([*words, "--force"], cwd=os.path.dirname(deck), stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL) as child:
            time.sleep(wait)
            child.send_signal(signal.SIGINT)
            status = child.wait()
        checkpoints = os.listdir(result + ".parts") if os.path.isdir(result + ".parts") else []
        steps = [int(name[11:-3]) for name in checkpoints if name.startswith("checkpoint-")]
        if status == 75 and steps and 0 < max(steps) < last:
            programs.call(words, os.path.dirname(deck))
            return max(steps)
        if status not in (0, 75, -signal.SIGINT):
            raise programs.Failed(f"{deck}: status {status}")
    raise programs.Failed(f"{deck}: it could not be stopped on the way")


def restarts(setup, folder, core, disks):
    setup.say(f"restarts of {disks} disks")
    pack = packing.make(setup.program, setup.folder, disks, core)
    pack.write_hdf5(os.path.join(folder, "start.h5"))
    deck, last = os.path.join(folder, "restart.cfg"), LONG // disks
    with open(deck, "w") as file:
        file.write(inputs.packing_deck("start.h5", pack.width, [("run", last, True)]))
    whole, parts = os.path.join(folder, "whole.h5"), os.path.join(folder, "parts.h5")
    programs.slipdisk(setup.program, deck, whole, core)
    stop = interrupted(setup, deck, parts, core, last)
    same, numbers = off(frames.of_slipdisk(whole)[-1], frames.of_slipdisk(parts)[-1], pack.width)
    found = [{"program": f"slipdisk, {last - stop} steps", "same": same, "off": numbers}]
    for style in ("granular", "hooke") if setup.lammps else ():
        found += of_peer(setup, folder, core, pack, "LAMMPS", style)
    return found + (of_peer(setup, folder, core, pack, "LIGGGHTS", "liggghts") if setup.liggghts else [])


def of_peer(setup, folder, core, pack, name, style):
    """Differences after EVERY steps, and after BEFORE."""
    program, old, data = getattr(setup, name.lower()), style == "liggghts", f"{name}-start.data"
    pack.write_data(os.path.join(folder, data), not old)
    mass, mean = pack.mass.mean(), packing.MEAN
    whole, after, file = f"{style}-whole.dump", f"{style}-after.dump", f"{style}.restart"
    if old:
        texts = (inputs.liggghts_packing(data, [2 * BEFORE], mean, (EVERY, whole), restart=(BEFORE, file)),
                 inputs.liggghts_continued(f"{file}.{BEFORE}", BEFORE, (EVERY, after), mean))
    else:
        texts = (inputs.lammps_packing(style, data, mass, [2 * BEFORE], mean, (EVERY, whole), restart=(BEFORE, file)),
                 inputs.lammps_continued(style, f"{file}.{BEFORE}", mass, BEFORE, (EVERY, after), mean))
    for word, text in zip(("whole", "after"), texts):
        script = os.path.join(folder, f"{style}-{word}.in")
        with open(script, "w") as out:
            out.write(text)
        setup.note(name, programs.run_script(program, script, core))
    first = {frame.step: frame for frame in frames.of_dump(os.path.join(folder, whole))}
    second = {frame.step: frame for frame in frames.of_dump(os.path.join(folder, after))}
    shown = name if old else f"{name} {style}"
    found = []
    for steps in (EVERY, BEFORE):
        same, numbers = off(first[BEFORE + steps], second[BEFORE + steps], pack.width)
        found.append({"program": f"{shown}, {steps} steps", "same": same, "off": numbers})
    return found


def compare(setup, disks=DISKS):
    folder, core = os.path.join(setup.folder, "accuracy"), programs.cores_here(1)
    os.makedirs(folder, exist_ok=True)
    return {"cycles": CYCLES, "loops": loops(setup, folder, core), "disks": disks, "before": BEFORE,
            "restarts": restarts(setup, folder, core, disks)}

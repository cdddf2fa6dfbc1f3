"""What each program is given: decks of slipdisk, input scripts of LAMMPS and LIGGGHTS. Here parameters are matched.

Law: F_n = max(k_n delta - gamma_n u_n, 0), tangential spring k_t without viscosity, friction mu (docs/physics.md, 2 and 3).

  LAMMPS "granular"  pair_style granular, `hooke` with `damping velocity`: viscosity gamma_n as it is; limit_damping
  LAMMPS "hooke"     pair_style gran/hooke/history: viscosity is m_eff times a number. It is chosen for disks of the
                     mean mass, twice as large among disks (m_eff = m/2) as at the floor (m_eff = m); limit_damping
  LIGGGHTS           model hooke/stiffness tangential history with absolute_damping: gamma_n as it is; limitForce

Floor: A (1 - cos w t). So it moves in LAMMPS (wiggle) and in slipdisk (a sine of phase -90 degrees and a constant, two
motions that add up). LIGGGHTS has no such motion for plane walls: there the floor rests and gravity is
g + A w^2 cos w t, the frame of the floor; frames.py goes back."""
import dataclasses
import math

G, DT = 9.81, 2e-5
DENSITY = 3.57                  # of disks: mass per area
FREQUENCY, PERIOD = 80, 625     # of the floor; steps in a period: 1 / (FREQUENCY DT)
ACCELERATION = 0.3              # peak, in units of g
W = 2 * math.pi * FREQUENCY
AMPLITUDE = ACCELERATION * G / W**2
SKIN = 0.1                      # of neighbour lists of LAMMPS and LIGGGHTS, in mean radii


@dataclasses.dataclass(frozen=True)
class Law:
    k_n: float
    k_t: float
    gamma_n: float
    mu: float


GRAIN = Law(k_n=1e4, k_t=5e3, gamma_n=5, mu=0.5)


# --- slipdisk -------------------------------------------------------------------------------------------------
def material(law, name="grain"):
    return (f'materials = ( {{ name = "{name}"; k_n = {law.k_n!r}; k_t = {law.k_t!r}; gamma_n = {law.gamma_n!r}; '
            f'mu = {law.mu!r}; }} );\n')


def packing_deck(disks, width, phases, frames=0, contacts=False, law=GRAIN):
    """phases: [(name, steps, does the floor move)]. contacts: the file is a result whose contacts go on."""
    of_file = ("contacts = true;" if contacts else f'dataset = "disks"; density = {DENSITY}; '
               'columns = ("x", "y", "vx", "vy", "omega", "radius");')
    def row(name, steps, moves):
        return f'{{ name = "{name}"; steps = {steps}; motions = ({floor if moves else ""}); }}'

    floor, always = '"shake", "raise"', ", ".join([repr(AMPLITUDE)] * 3)
    move = 'wall = "floor"; coordinate = "y"; type ='
    rows = ",\n  ".join(row(*phase) for phase in phases)
    return (f'dt = {DT!r};\nintegrator = "verlet";\ngravity = {{ g = {G!r}; }};\n'
            f'box = {{ x = (0.0, {width!r}); periodic = "x"; }};\n' + material(law) +
            'walls = ( { name = "floor"; type = "line"; points = ((0, 0), (1, 0)); } );\nmotions = (\n'
            f'  {{ name = "shake"; {move} "harmonic"; amplitude = {AMPLITUDE!r}; frequency = {FREQUENCY}; '
            'phase = "-90 deg"; },\n'
            f'  {{ name = "raise"; {move} "table"; times = (0, 1e5, 1e6); values = ({always}); }}\n);\n'
            f'disk_files = ( {{ file = "{disks}"; {of_file} }} );\n'
            f'phases = (\n  {rows}\n);\nmeasure = {{ rotation = (); }};\ncheckpoint = 1e6;\n'
            f'output = {{ series = 0; frames = {frames}; }};\n')


# --- LAMMPS ---------------------------------------------------------------------------------------------------
def lammps_law(style, law, mass):
    """(lines of the pair style, words of fix wall/gran); mass: mean, for the style that multiplies by it."""
    if style == "granular":
        model = (f"hooke {law.k_n!r} {law.gamma_n!r} damping velocity "
                 f"tangential linear_history {law.k_t!r} 0.0 {law.mu!r} limit_damping")
        return f"pair_style granular\npair_coeff * * {model}\n", f"granular {model}"
    pair = f"{law.k_n:.17g} {law.k_t:.17g} {2 * law.gamma_n / mass:.17g} 0.0 {law.mu:.17g} 0 limit_damping"
    # The same law at the floor; fix wall/gran hooke/history of LAMMPS 22 Jul 2025 gives other forces than that of 29 Sep 2021.
    wall = (f"granular hooke {law.k_n:.17g} {law.gamma_n / mass:.17g} damping mass_velocity "
            f"tangential linear_history {law.k_t:.17g} 0.0 {law.mu:.17g} limit_damping")
    return f"pair_style gran/hooke/history {pair}\npair_coeff * *\n", wall


def lammps_style(periodic="p"):
    return ("units si\natom_style sphere\natom_modify map array\ndimension 2\nnewton off\ncomm_modify vel yes\n"
            f"boundary {periodic} f p\n")


def lists(skin, dt=DT):
    """Neighbour lists are looked at every step and made anew when something has moved half the skin."""
    return f"neighbor {skin!r} bin\nneigh_modify delay 0 every 1 check yes\ntimestep {dt!r}\n"


def processors(ranks):
    """Side by side: the packing is wide."""
    return f"processors {ranks} 1 1\n" if ranks > 1 else ""


def lammps_packing(style, data, mass, steps, mean_radius, dumps=None, ranks=1, law=GRAIN, restart=None):
    """steps: lengths of the runs one after another; dumps: (steps between frames, file) of the last one.
    restart: (step, file) at which the run writes a restart on its way."""
    pair, wall = lammps_law(style, law, mass)
    return (processors(ranks) + lammps_style() + f"read_data {data}\n" + lists(SKIN * mean_radius) + pair
            + lammps_fixes(wall) + runs(steps, dumps, restart))


def lammps_fixes(wall):
    return (f"fix gravity all gravity {G!r} vector 0 -1 0\n"
            f"fix floor all wall/gran {wall} yplane 0.0 NULL wiggle y {AMPLITUDE!r} {1 / FREQUENCY!r}\n"
            "fix move all nve/sphere disc\nfix flat all enforce2d\n")


def lammps_continued(style, file, mass, steps, dumps, mean_radius, law=GRAIN):
    """Goes on from a restart. The floor's motion begins anew: it must have been written after whole periods."""
    pair, wall = lammps_law(style, law, mass)
    return (f"newton off\nread_restart {file}\ncomm_modify vel yes\n" + lists(SKIN * mean_radius) + pair
            + lammps_fixes(wall) + runs([steps], dumps))


def runs(steps, dumps=None, restart=None, old=False):
    """Runs one after another, with thermo output only where one begins and ends. dumps: (steps between frames, file) of
    the last one; restart: (step, file) at which it writes one. old: as LIGGGHTS wants the format of a dump."""
    text = "thermo_style custom step ke\nthermo 1000000000\n"
    for k, length in enumerate(steps):
        if k == len(steps) - 1:
            text += dump(*dumps, old) if dumps else ""
            text += "restart {} {}.*\n".format(*restart) if restart else ""
        text += f"run {length}\n"
    return text


def dump(every, file, old):
    return (f"dump frames all custom {every} {file} id x y vx vy omegaz\n"
            f'dump_modify frames sort id format {"" if old else "line "}"%d %.17g %.17g %.17g %.17g %.17g"\n')


# --- LIGGGHTS -------------------------------------------------------------------------------------------------
def liggghts_law(law):
    """(lines of properties and pair style, words of fix wall/gran)"""
    values = {"kn": law.k_n, "kt": law.k_t, "gamman_abs": law.gamma_n, "gammat_abs": 0.0,
              "coefficientFriction": law.mu}
    text = "".join(f"fix {name} all property/global {name} peratomtypepair 1 {value!r}\n"
                   for name, value in values.items())
    model = "model hooke/stiffness tangential history"
    options = "absolute_damping on tangential_damping off limitForce on"
    return (text + f"pair_style gran {model} {options}\npair_coeff * *\n",
            f"{model} primitive type 1 yplane 0.0 {options}")


def liggghts_style(periodic="p"):
    words = lammps_style(periodic).replace("comm_modify vel yes", "communicate single vel yes")
    return words.replace("atom_style sphere", "atom_style granular")


def liggghts_fixes(wall):
    return (f"variable g equal {G!r}+{AMPLITUDE * W * W!r}*cos({W * DT!r}*step)\n"
            f"fix gravity all gravity v_g vector 0 -1 0\nfix floor all wall/gran {wall}\n"
            "fix move all nve/sphere\nfix flat all enforce2d\n")


def liggghts_packing(data, steps, mean_radius, dumps=None, ranks=1, law=GRAIN, restart=None):
    pair, wall = liggghts_law(law)
    return (processors(ranks) + liggghts_style() + f"read_data {data}\n" + lists(SKIN * mean_radius) + pair
            + liggghts_fixes(wall) + runs(steps, dumps, restart, old=True))


def liggghts_continued(file, steps, dumps, mean_radius, law=GRAIN):
    pair, wall = liggghts_law(law)
    return (f"newton off\nread_restart {file}\ncommunicate single vel yes\n" + lists(SKIN * mean_radius) + pair
            + liggghts_fixes(wall) + runs([steps], dumps, old=True))

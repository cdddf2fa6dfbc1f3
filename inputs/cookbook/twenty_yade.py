"""The twenty tasks of docs/coming_from_python.md in YADE: yade -x -n twenty_yade.py"""
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection
from yade import O, pack, utils

# 1. Fill a box with 200 disks of two sizes
def grain(mu=0.3):
    return ViscElMat(kn=2e4, ks=1e4, cn=6, cs=0, frictionAngle=np.arctan(mu), density=1)

def add(place, radius, velocity=(0, 0, 0)):
    body = O.bodies[O.bodies.append(utils.sphere(place, radius))]
    body.state.mass = 3.57 * np.pi * radius**2
    body.state.inertia = (1, 1, body.state.mass * radius**2 / 2)
    body.state.blockedDOFs = "zXY"
    body.state.vel = velocity
    return body

def fill():
    O.reset()
    O.materials.append(grain())
    for k in range(200):
        x, y = 0.05 * np.array([k % 8 - 3.5, k // 8 + 0.5]) + np.random.uniform(-0.0015, 0.0015, 2)
        add((x, y, 0), (0.018, 0.022)[k % 2])
    for place, axis in (((-0.2, 0, 0), 0), ((0.2, 0, 0), 0), ((0, 0, 0), 1)):
        O.bodies.append(utils.wall(place, axis=axis))
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=0.002),
        InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
                        [Ip2_ViscElMat_ViscElMat_ViscElPhys()], [Law2_ScGeom_ViscElPhys_Basic()]),
        NewtonIntegrator(gravity=(0, -9.81, 0), damping=0, label="newton")]
    O.dt = 5e-5

fill()

# 2. Wait until they rest
O.run(20000, True)
while utils.kineticEnergy() > 1e-6:
    O.run(1000, True)
height = [b.state.pos[1] for b in O.bodies if isinstance(b.shape, Sphere)]
print(f"mean height {np.mean(height):.3f}")

# 3. Drop ten disks given by arrays
new = [add((x, 1, 0), 0.015, (0, -1, 0)).id for x in np.linspace(-0.17, 0.17, 10)]
O.run(20000, True)

# 4. Take them out
for k in new:
    O.bodies.erase(k)

# 5. Keep a state, go on, go back to it
O.saveTmp("heap")
O.run(10000, True)
O.loadTmp("heap")

# 6. Press with a lid of constant force
fill()
lid = O.bodies[O.bodies.append(utils.wall((0, 1.28, 0), axis=1))]
def push():
    force = O.forces.f(lid.id, sync=True)[1] - 20 - 0.2 * 9.81
    lid.state.vel = (0, lid.state.vel[1] + O.dt * force / 0.2, 0)
O.engines += [PyRunner(command="push()", iterPeriod=1)]
O.run(40000, True)
print(f"lid at {lid.state.pos[1]:.3f}")
O.saveTmp("lidded")

# 7. Press a periodic cell to a pressure
def press(mu):
    O.reset()
    O.materials.append(grain(mu))
    O.periodic = True
    O.cell.hSize = Matrix3(0.85, 0, 0, 0, 0.85, 0, 0, 0, 1)
    cloud = pack.SpherePack()
    cloud.makeCloud((0, 0, 0.5), (0.85, 0.85, 0.5), rMean=0.022, num=200, periodic=True, seed=1)
    for k, (place, _) in enumerate(cloud):
        add(place, (0.018, 0.022)[k % 2])
    O.engines = [
        ForceResetter(),
        InsertionSortCollider([Bo1_Sphere_Aabb()], verletDist=0.002),
        InteractionLoop([Ig2_Sphere_Sphere_ScGeom()], [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
                        [Law2_ScGeom_ViscElPhys_Basic()]),
        PeriTriaxController(goal=(-100, -100, 0), stressMask=3, maxStrainRate=(0.3, 0.3, 0),
                            dynCell=True, mass=1, label="cell"),
        NewtonIntegrator(damping=0)]
    O.dt = 5e-5
    O.run(100000, True)

press(0.3)
print(f"pressure {-utils.getStress().trace() / 2:.0f}")
O.saveTmp("pressed")

# 8. Squeeze it in y at constant pressure in x
cell.stressMask = 1
cell.goal = (-100, -1, 0)
cell.maxStrainRate = (0.3, 0.05, 0)
O.run(20000, True)
stress = utils.getStress()
print(f"stress ratio {stress[1, 1] / stress[0, 0]:.2f}")

# 9. Shear it at constant pressure in y
O.loadTmp("pressed")
cell.stressMask = 2
cell.goal = (O.cell.trsf[0, 0] - 1, -100, 0)
O.cell.velGrad = Matrix3(0, 0.5, 0, 0, 0, 0, 0, 0, 0)
O.run(80000, True)
stress = utils.getStress()
print(f"shear stress over pressure {-stress[0, 1] / stress[1, 1]:.2f}")

# 10. Contacts per disk
O.loadTmp("pressed")
print(f"contacts per disk {utils.avgNumInteractions():.2f}")

# 11. Stress tensor
print(-np.array(utils.getStress())[:2, :2].round())

# 12. Packing fraction of a part
O.loadTmp("heap")
grid = np.stack(np.meshgrid(np.linspace(-0.15, 0.15, 601), np.linspace(0.1, 0.5, 801)), -1)
spheres = [b for b in O.bodies if isinstance(b.shape, Sphere)]
place = [np.array(b.state.pos)[:2] for b in spheres]
inside = sum(np.hypot(*(grid - p).T) < b.shape.radius for p, b in zip(place, spheres)) > 0
print(f"packing fraction {inside.mean():.3f}")

# 13. Histogram of the normal forces
O.loadTmp("pressed")
force = np.array([i.phys.normalForce.norm() for i in O.interactions if i.isReal])
print(np.histogram(force / force.mean(), bins=[0, 0.5, 1, 1.5, 2, np.inf])[0] / len(force))

# 14. Energy lost by friction
# cannot be done with this law

# 15. Change the friction
O.loadTmp("heap")
O.materials[0].frictionAngle = np.arctan(0.1)
for contact in O.interactions:
    contact.phys.tangensOfFrictionAngle = 0.1
O.run(10000, True)

# 16. Turn gravity by 20 degrees
for angle in np.radians(range(1, 21)):
    newton.gravity = (9.81 * np.sin(angle), -9.81 * np.cos(angle), 0)
    O.run(1000, True)

# 17. Hold a disk, then release it
held = O.bodies[17].state
held.blockedDOFs = "xyzXYZ"
held.vel = held.angVel = (0, 0, 0)
O.run(2000, True)
held.blockedDOFs = "zXY"

# 18. Add a force of your own
def wind():
    for b in O.bodies:
        O.forces.addF(b.id, (-0.05 * b.state.pos[1], 0, 0))
O.engines = O.engines[:-1] + [PyRunner(command="wind()", iterPeriod=1)] + O.engines[-1:]
O.run(2000, True)

# 19. Draw disks and force chains
O.loadTmp("lidded")
disks = [b for b in O.bodies if isinstance(b.shape, Sphere)]
size = np.array([2 * b.shape.radius for b in disks])
touching = [i for i in O.interactions if i.isReal and max(i.id1, i.id2) < len(disks)]
place = np.array([b.state.pos for b in disks])[:, :2]
force = np.array([i.phys.normalForce.norm() for i in touching])
figure, axes = plt.subplots()
axes.add_collection(EllipseCollection(size, size, 0 * size, units="x", color="0.8",
                                      offsets=place, offset_transform=axes.transData))
axes.add_collection(LineCollection(place[[(i.id1, i.id2) for i in touching]],
                                   linewidths=force / force.mean()))
axes.set(xlim=(-0.2, 0.2), ylim=(0, 0.9), aspect="equal")
figure.savefig("heap_yade.png")

# 20. Sweep the friction
for mu in (0.1, 0.3, 0.5):
    press(mu)
    print(f"{mu} {utils.avgNumInteractions():.2f}")

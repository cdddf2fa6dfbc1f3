# YADE (yade -x -n pour_yade.py): 204 disks of two sizes fall into a box and come to rest; then the floor shakes. SI units.
import random
from math import atan, pi, sin

from yade import O, pack, utils

random.seed(1)
# Two materials make a contact as springs in series, k1 k2/(k1 + k2): twice the k_n, k_t, gamma_n of a contact.
O.materials.append(ViscElMat(kn=2e4, ks=1e4, cn=6, cs=0, frictionAngle=atan(0.3), density=1, label="grain"))
for k in range(204):
    radius = random.choice((0.018, 0.022))
    x = -0.275 + 0.05 * (k % 12) + random.uniform(-0.0015, 0.0015)
    y = 0.025 + 0.05 * (k // 12) + random.uniform(-0.0015, 0.0015)
    body = O.bodies[O.bodies.append(utils.sphere((x, y, 0), radius, material="grain"))]
    body.state.mass = 3.57 * pi * radius**2               # of a disk; so is the moment of inertia
    body.state.inertia = (1, 1, body.state.mass * radius**2 / 2)
    body.state.blockedDOFs = "zXY"
for place, axis in (((-0.3, 0, 0), 0), ((0.3, 0, 0), 0), ((0, 0, 0), 1)):
    floor = O.bodies[O.bodies.append(utils.wall(place, axis=axis, sense=0, material="grain"))]

O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=0.002),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
                    [Ip2_ViscElMat_ViscElMat_ViscElPhys()],
                    [Law2_ScGeom_ViscElPhys_Basic()]),
    NewtonIntegrator(gravity=(0, -9.81, 0), damping=0),   # the default damps every motion by 0.2
]
O.dt = 2e-5

def tell():
    disks = [b for b in O.bodies if isinstance(b.shape, Sphere)]
    touching = sum((1 if isinstance(O.bodies[i.id1].shape, Wall) or isinstance(O.bodies[i.id2].shape, Wall) else 2)
                   for i in O.interactions if i.isReal)
    energy = sum(b.state.mass * b.state.vel.squaredNorm() / 2 for b in disks)
    print(f"{O.iter:7} {O.time:4.1f} {energy:10.3g} {sum(b.state.pos[1] for b in disks) / 204:.5f} {touching / 204:.3f}")

for k in range(6):
    O.run(25000, True)
    tell()

# the floor moves as A sin w t, A = 2 g/w^2
w, start = 2 * pi * 40, O.time
def shake():
    t = O.time - start
    floor.state.vel = (0, 2 * 9.81 / w * min(1, t / 0.1) * sin(w * t + pi / 2), 0)

O.engines += [PyRunner(command="shake()", iterPeriod=1, dead=False)]
for k in range(2):
    O.run(25000, True)
    tell()

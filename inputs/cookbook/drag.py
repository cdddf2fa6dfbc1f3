"""Disks sink in water: Stokes' drag as a force of one's own."""
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import slipdisk

VISCOUS = 0.05                                                   # force on a disk over its speed, kg/s


def water(c):
    n = c.n_free
    c.force_x -= VISCOUS * c.vx[:n]
    c.force_y -= VISCOUS * c.vy[:n]


sim = slipdisk.Simulation("sink.cfg")
sim.add_force(water)
mass = sim.disks["mass"][0]
final, tau = mass * 9.81 / VISCOUS, mass / VISCOUS
time, speed = [0.0], [0.0]
for k in range(60):
    sim.advance(1000)
    time.append(sim.time)
    speed.append(-sim.disks["vy"].mean())
    if k == 15:
        print(f"at t = 0.8: mean speed {speed[-1]:.6f}, expected {final * (1 - np.exp(-sim.time / tau)):.6f}")
e = sim.energy
print(f"work of the water {e.work:.6f}, residual {abs(e.residual) / e.scale:.1e} of what was turned over")

t = np.linspace(0, 3, 300)
plt.figure(figsize=(6, 4), constrained_layout=True)
plt.plot(t, final * (1 - np.exp(-t / tau)), "k--", label="one disk, by hand")
plt.plot(time, speed, label="mean of 40 disks")
plt.xlabel("time, s")
plt.ylabel("speed downwards, m/s")
plt.legend()
plt.savefig("drag.png", dpi=120)

"""When does the ball leave the plate? Force of the contact, and acceleration of the plate, against time."""
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import slipdisk

r = slipdisk.Result("motion.h5")
s = r.series
t = s["time"] - 0.05                                             # the first phase only lets it sink in
force = s["wall_normal"][:, 0] / (r.disks["mass"][0] * 9.81)
plate = r.wall_frames
u, when = plate["position"][:, 0, 1], plate.time - 0.05
acceleration = np.gradient(np.gradient(u, when), when) / 9.81
free = t[(t > 0.05) & (force == 0)][0]
print(f"leaves at t = {free:.3f}, plate at {np.interp(free, when, acceleration):.2f} g")

figure, (upper, lower) = plt.subplots(2, 1, sharex=True, figsize=(7, 5), constrained_layout=True)
upper.plot(when, acceleration, lw=0.6)
upper.axhline(-1, color="grey", ls="--")
upper.set_ylabel("acceleration of the plate, g")
lower.plot(t, force, lw=0.6)
lower.axvline(free, color="grey", ls="--")
lower.set_ylim(0, 5)
lower.set_ylabel("contact force over weight")
lower.set_xlabel("time, s")
figure.savefig("lift.png", dpi=120)

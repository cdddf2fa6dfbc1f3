"""What the energy budget misses, against the time step; and where the energy of one run went."""
import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import slipdisk

PERIOD = 1.822e-3                                                # the shortest contact period, as `slipdisk check` says
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), constrained_layout=True)
points = slipdisk.Sweep("audit.sweep").done
for integrator in ("verlet", "gear5"):
    rows = points[points["integrator"] == integrator]
    missing = np.abs(rows["residual"])
    left.loglog(PERIOD / rows["dt"], missing, "o-", label=integrator)
    print(integrator, " ".join(f"{m:.1e}" for m in missing))
left.axhline(0.01, color="grey", ls="--")
left.axvline(20, color="grey", ls=":")
left.set_xlabel("steps in the shortest contact period")
left.set_ylabel("|residual| / scale")
left.legend()

s = slipdisk.Result("audit.h5").series
kept = s["kinetic_translation"] + s["kinetic_rotation"] + s["elastic_normal"] + s["elastic_tangential"] + s["external"]
put_in = s["start"] + s["work"] + s["nonconservative_work"]
layers = [kept, s["viscous"], s["friction"], s["opening"]]
right.stackplot(s["time"], *layers, labels=("kept: kinetic, elastic, height", "viscous", "friction", "opening"), alpha=0.7)
right.plot(s["time"], put_in, "k--", lw=1, label="start + work")
right.set_xlabel("time, s")
right.set_ylabel("energy, J")
right.legend(loc="lower right", fontsize=8)
figure.savefig("audit.png", dpi=120)
print(f"work {s['work'][-1]:.4f} viscous {s['viscous'][-1]:.4f} friction {s['friction'][-1]:.4f} "
      f"missing {np.abs(sum(layers) - put_in).max() / s['scale'][-1]:.1e}")

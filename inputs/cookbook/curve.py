"""Stress ratio and volume against axial strain, of the results of shear.cfg that are given."""
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import slipdisk

figure, (upper, lower) = plt.subplots(2, 1, sharex=True, figsize=(6, 6), constrained_layout=True)
for name in sys.argv[1:]:
    s = slipdisk.Result(name).series
    width, height = s["width"], s["height"]
    strain = np.log(height[0] / height)
    volume = np.log(width * height / (width[0] * height[0]))              # > 0: it dilates
    p = (s["stress_yy"] + s["stress_xx"]) / 2
    ratio = (s["stress_yy"] - s["stress_xx"]) / 2 / p                      # q/p, the sine of the mobilised friction angle
    rate = np.gradient(strain, s["time"])
    upper.plot(strain, ratio, lw=1, label=name[:-3])
    lower.plot(strain, volume, lw=1)
    late = strain > 0.6 * strain[-1]
    print(f"{name}: peak {ratio.max():.3f}  at the end {ratio[late].mean():.3f}  volume {volume[-1]:+.4f}  "
          f"I {np.median(rate / np.sqrt(p)):.1e}  side {s['stress_xx'].mean():.3f}")
upper.set_ylabel("q/p")
upper.legend()
lower.set_ylabel("ln(V/V$_0$)")
lower.set_xlabel("axial strain")
figure.savefig("shear.png", dpi=120)

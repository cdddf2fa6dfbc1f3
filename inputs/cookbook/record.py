"""An accelerometer's record becomes the table of displacements that the deck wants."""
import numpy as np

g, rate = 9.81, 4000                                             # of the logger: 4 kHz
t = np.arange(0, 1 + 0.5 / rate, 1 / rate)
acceleration = -1.6 * g * t * np.sin(2 * np.pi * 80 * t)         # here made up: 80 Hz, growing to 1.6 g. Read yours instead


def integral(y):
    return np.concatenate([[0], np.cumsum((y[1:] + y[:-1]) / 2) / rate])


velocity = integral(acceleration)
velocity -= np.polyval(np.polyfit(t, velocity, 1), t)            # an offset of the sensor would become a drift
displacement = integral(velocity)
displacement -= np.polyval(np.polyfit(t, displacement, 1), t)
fade = np.clip(np.minimum(t, t[-1] - t) / 0.05, 0, 1)            # begins and ends at rest
displacement *= fade**3 * (10 - 15 * fade + 6 * fade**2)
np.savetxt("record.csv", np.column_stack([t, displacement]), delimiter=",", fmt="%.9e", header="time,displacement", comments="")

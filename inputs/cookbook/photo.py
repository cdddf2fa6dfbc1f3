"""Grains as a photograph might give them: a table in metres, with errors of some pixels."""
import numpy as np

rng = np.random.default_rng(3)
scale = 0.4 / 1200                                   # metres per pixel: the box is 1200 pixels wide
column, row = np.meshgrid(np.arange(9), np.arange(11))
x = 66 + 129 * column + 10 * (row % 2) + rng.normal(0, 3, column.shape)
y = 64 + 126 * row + rng.normal(0, 3, row.shape)
diameter = rng.choice([106, 120, 132], column.shape)
table = np.column_stack([np.arange(x.size), scale * x.ravel() - 0.2, scale * y.ravel(), scale * diameter.ravel() / 2])
np.savetxt("grains.csv", table, delimiter=",", fmt=("%d", "%.5f", "%.5f", "%.5f"),
           header="grain,x_m,y_m,radius_m", comments="")

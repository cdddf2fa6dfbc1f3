"""How often error bars of averages hold their means: a table of a sweep of many seeds.

  slipdisk sweep tools/studies/averages/shear.cfg -o shear.sweep
  PYTHONPATH=tools/python python3 tools/studies/averages/coverage.py shear.sweep ...

Of each mean with an error bar, over the points of the sweep: their mean and scatter, the mean error bar over the scatter, the
fractions of points within one and two of their own error bars of that mean, and the same of the points that call their bar reliable.
The mean of n points is itself off by scatter/sqrt(n), for which distances are divided by sqrt(1 - 1/n)."""
import sys

import numpy as np

import slipdisk


def coverage(values, errors):
    """(mean, scatter, mean error bar over scatter, fraction within one bar, within two) of these points."""
    mean, scatter = values.mean(), values.std(ddof=1)
    z = np.abs(values - mean) / errors / np.sqrt(1 - 1 / len(values))
    return mean, scatter, errors.mean() / scatter, (z < 1).mean(), (z < 2).mean()


def main(folders):
    print("| sweep | mean of | points | mean | scatter | bar/scatter | within one | within two | reliable | of these: bar/scatter | within one "
          "| within two |\n|---" + "|---" * 11 + "|")
    for folder in folders:
        table = slipdisk.Sweep(folder).done
        for error in (name for name in table.dtype.names if name.endswith("_error")):
            name = error.removesuffix("_error")
            good = np.isfinite(table[error])
            sure = good & (table[name.rpartition(".")[0] + ".converged"] > 0)
            found = coverage(table[name][good], table[error][good])
            row = [folder.rstrip("/").rpartition("/")[2].removesuffix(".sweep"), name.removesuffix(".mean"), f"{good.sum()}",
                   f"{found[0]:.4g}", f"{found[1]:.2g}", *(f"{x:.3f}" for x in found[2:]), f"{sure.sum() / len(table):.2f}"]
            some = sure.sum() > 20
            row += [f"{x:.3f}" for x in coverage(table[name][sure], table[error][sure])[2:]] if some else ["-"] * 3
            print("| " + " | ".join(row) + " |")


if __name__ == "__main__":
    main(sys.argv[1:])

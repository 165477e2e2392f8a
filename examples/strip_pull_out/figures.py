"""Draws the founding paper's Figs. 8 and 9 from runs of strip.py, and prints their table.

python examples/strip_pull_out/figures.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib
import numpy as np
from strip import COUNTS, HORIZONTAL, KINDS, SIZE, exact_forces, mean_and_ripple, pull_out

START = 2.0 * SIZE  # of the mean: the strip is in motion
FINE = 1601  # travels that resolve the ripple of a strip of elements


def main(folder):
    """strip.png: forces over travel, exact faces above and facets below, as in the paper."""
    matplotlib.use("Agg")
    from matplotlib import pyplot

    folder.mkdir(parents=True, exist_ok=True)
    figure, axes = pyplot.subplots(2, 3, figsize=(13.0, 7.0), sharex=True, sharey="col", layout="constrained")
    for column, count in zip(axes.T, COUNTS):
        travel, out, _ = pull_out(count, "exact", "out")
        fine = np.linspace(0.0, travel[-1], FINE)
        exactly = exact_forces(fine, count)
        exact_ripple = mean_and_ripple(fine, exactly, START)[1]
        for axis in column:
            axis.plot(fine, exactly, color="0.75", lw=3, label="strip of elements, exactly")
            axis.axhline(HORIZONTAL * np.exp(0.05 * np.pi), color="0.4", lw=0.8, label="F_H exp(mu pi / 2)")
            axis.grid(alpha=0.3)
        column[0].plot(travel, out, "k:", label="F_H, pulled straight out")
        column[0].set_title(f"{count:g} elements on the quarter circle")
        column[1].set_xlabel("travel [mm]")
        for kind, words in KINDS.items():
            travel, force, results = pull_out(count, kind)
            column[0 if kind in ("exact", "nagata") else 1].plot(travel, force, label=f"F_V, {words}")
            mean, ripple = mean_and_ripple(travel, force, START)
            exact = mean_and_ripple(travel, np.interp(travel, fine, exactly), START)[0]
            print(
                f"{count:g} elements, {words}: F_V {mean:.1f} +- {ripple:.1f} N, exactly {exact:.1f} +- "
                f"{exact_ripple:.1f} ({100.0 * (mean / exact - 1.0):+.2f} %), {sum(results.history['iterations'])} "
                f"iterations; F_H {np.median(out):.2f} N",
                flush=True,
            )
    for axis in axes[:, 0]:
        axis.set_ylabel("force [N]")
        axis.legend(fontsize=8)
    figure.savefig(folder / "strip.png", dpi=120)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("out/strip_pull_out"))

"""A mass dropped on a rigid plane: the founding paper's Fig. 17, contact by penalty, and Fig. 18, by touch.

1 kg falls 0.1 m under g = 9.81 m/s^2 on a plane, without loss of energy. Each scheme steps it with the very kernels
that the explicit solver steps a sheet's nodes with; written here in kg, m, s.

    python examples/dropped_mass/dropped_mass.py [figures.png]
"""

import sys
from itertools import repeat

import numba
import numpy as np

from solver.explicit.central_differences import predict
from solver.explicit.contact import meet_few
from solver.explicit.laws import PENALTY, TOUCH

MASS, GRAVITY, HEIGHT = 1.0, 9.81, 0.1
STIFFNESS = 1e6  # N/m, of the penalty
CRITICAL = 2.0 * np.sqrt(MASS / STIFFNESS)  # longest stable step with it
PERIOD = 2.0 * np.sqrt(2.0 * HEIGHT / GRAVITY)  # of a bounce


def drop(law, dt, bounces=1, height=HEIGHT):
    """Drop the mass and let it bounce.

    law : PENALTY or TOUCH; dt : step [s], or an iterator of steps
    returns : times, heights; heights of the bounces' tops (bounces,), each on the parabola of the step beside it
    """
    lengths = repeat(dt) if isinstance(dt, float) else dt
    dt = next(lengths)
    parameter = STIFFNESS / MASS if law == PENALTY else 1.0
    u, v, u_new, v_new = (np.zeros((1, 3)) for _ in range(4))
    u[0, 2] = height
    v[0, 2] = 0.5 * dt * GRAVITY  # half a step before it is let go
    mass, half, external = np.array([MASS]), np.zeros(1), np.array([[0.0, 0.0, -MASS * GRAVITY]])
    nothing, fixed, free = np.zeros((1, 3)), np.zeros((1, 3), dtype=bool), np.ones((1, 3))
    gap, force, friction, status = np.zeros(1), np.zeros(1), np.zeros((1, 3)), np.zeros(1, dtype=np.int64)
    lost, rest = np.zeros(1), np.zeros((3, 3))
    normal, up, near = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]]), np.zeros(1, dtype=np.int64)
    times, heights, tops = [0.0], [height], []
    while len(tops) < bounces:
        before, dt = dt, next(lengths)
        dtm = 0.5 * (before + dt)
        predict(u, v, mass, external, nothing, fixed, nothing, 0.0, dt, dtm, 0.0, u_new, v_new)
        distance = (u if law == PENALTY else u_new)[:, 2].copy()
        meet_few(
            law, parameter, near, distance, up, near, half, mass, free, 0.0, None, rest, dt, dtm, v, u_new, v_new, gap,
            force, normal, friction, status, lost,
        )  # fmt: skip
        u, u_new, v, v_new = u_new, u, v_new, v
        times.append(times[-1] + dt)
        heights.append(float(u[0, 2]))
        a, b, c = heights[-3:] if len(heights) > 3 else (0.0, 0.0, 0.0)
        if b > a and b >= c and b > 0.0:
            tops.append(0.5 * (b + c) + GRAVITY * dt**2 / 8.0 + ((c - b) / dt) ** 2 / (2.0 * GRAVITY))
    return np.array(times), np.array(heights), np.array(tops)


def first_top(law, share, phases=200, seed=0):
    """Heights of the first bounce over the drop's, for random phases of the impact between two steps.

    share : of the critical step of the penalty
    """
    dt = share * CRITICAL
    fall = np.random.default_rng(seed).uniform(0.0, dt, phases)
    # A drop from a little higher hits a little later: v dt = g t dt.
    heights = 0.5 * GRAVITY * (0.5 * PERIOD + fall) ** 2
    return np.array([drop(law, dt, 1, h)[2][0] / h for h in heights])


def draw(path):
    """Both figures, and the energy error of a bounce against the step."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 3, figsize=(15, 4))
    for axis, law, title in ((axes[0], PENALTY, "penalty (Fig. 17)"), (axes[1], TOUCH, "touch (Fig. 18)")):
        times, heights, _ = drop(law, 0.4 * CRITICAL, 12)
        axis.plot(times, 1e3 * heights, lw=1)
        axis.axhline(1e3 * HEIGHT, color="grey", lw=0.5)
        axis.set(xlabel="time [s]", ylabel="height [mm]", title=f"{title}, step 0.4 of the critical one")
    shares = [0.05, 0.1, 0.2, 0.4, 0.6, 0.8]
    for law, name in ((PENALTY, "penalty"), (TOUCH, "touch")):
        spread = [np.abs(first_top(law, share, 100) - 1.0).max() for share in shares]
        axes[2].loglog(shares, np.maximum(spread, 1e-15), "o-", label=name)
    axes[2].set(xlabel="step over the critical one", ylabel="largest energy error of a bounce", title="energy")
    axes[2].legend()
    figure.tight_layout()
    figure.savefig(path, dpi=120)


if __name__ == "__main__":
    numba.set_num_threads(1)  # for one node more would only wait for each other
    for share in (0.05, 0.1, 0.2, 0.4, 0.6, 0.8):
        ratio = first_top(PENALTY, share)
        print(f"penalty, step {share:4.2f} of the critical one: first top {ratio.min():.4f} to {ratio.max():.4f}")
    for share in (0.1, 0.4, 0.8, 5.0):
        tops = drop(TOUCH, share * CRITICAL, 1000)[2]
        print(f"touch, step {share:4.2f}: height after 1000 bounces {tops[-1] / HEIGHT:.6f}")
    draw(sys.argv[1] if len(sys.argv) > 1 else "dropped_mass.png")

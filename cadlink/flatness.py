"""How far from flat a blank is delivered: a smooth bow, or a wavy edge, of stated height.

A perfectly flat blank pressed by perfectly flat tools has no reason to wrinkle to one side rather than the other, so it
does so late or not at all. Real sheets are flat within a tolerance (EN 10131), which decides where wrinkles begin; and
waves that are there from the start grow, rather than a number of them that the least of things decides.
"""

import numpy as np

WAVES = 8  # half waves along a side of the blank, at most


def bow(xy, flatness):
    """Height of the blank above the plane it lies on, (n,) mm, from 0 to at most `flatness`; below it where that is
    negative.

    xy : (n, 2) mm in the blank's plane

    A fixed mixture of all waves with up to eight half waves along each side of the bounding box, of equal curvature:
    the longer, the higher. No wave has a slope across the box's sides, so halves and quarters stay symmetric; the mesh
    does not matter.
    """
    low, high = xy.min(axis=0), xy.max(axis=0)
    every = np.linspace(0.0, 1.0, 8 * WAVES + 1)
    grid = _waves(*np.meshgrid(every, every))
    return flatness * (_waves(*((xy - low) / (high - low)).T) - grid.min()) / np.ptp(grid)


def edge_wave(xy, flatness, waves):
    """Height of a blank with a wavy edge above the plane it lies on, (n,) mm, from 0 to at most `flatness`; below it
    where that is negative.

    xy : (n, 2) mm in the blank's plane, from its middle; waves : whole ones round the edge

    flatness (1 + (r/R)^2 cos(waves theta)) / 2, with R the farthest distance from the middle and theta from the first
    axis: an even number of waves is symmetric about both axes.
    """
    square = np.sum(xy * xy, axis=1)
    return 0.5 * flatness * (1.0 + square / square.max() * np.cos(waves * np.arctan2(xy[:, 1], xy[:, 0])))


def _waves(x, y):
    """The mixture at places from 0 to 1 along the sides."""
    total = np.zeros_like(x)
    for k in range(WAVES + 1):
        for m in range(WAVES + 1):
            if k + m > 0:
                # Any fixed amounts that prefer no direction and do not repeat would do.
                amount = np.cos(1.0 + np.sqrt(2.0) * k + np.sqrt(3.0) * m) / (k * k + m * m)
                total += amount * np.cos(k * np.pi * x) * np.cos(m * np.pi * y)
    return total

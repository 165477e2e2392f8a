"""Smallest concave and convex radius of curvature of a skin."""

import numpy as np

from cadlink.leaf_measures import SAFETY
from cadlink.primitives import shape_on_form
from cadlink.records import PATCHES
from cadlink.skin import build_skin

DEGENERATE = 1e-6  # radii below this part of the size are a patch's collapsed side, not a shape


def smallest_radii(record, size):
    """(concave, convex) radius [mm], inf where there is none.

    record : "skin" of a part; size : its largest extent [mm]
    """
    return radii_of_skin(build_skin(record), size)


def radii_of_skin(skin, size):
    """The same of a skin that is built already."""
    sharpest = 1.0 / (DEGENERATE * size)
    least, most = 0.0, 0.0
    for face in skin.faces:
        if face["form"] == PATCHES:
            continue
        u, _, v0, v1 = face["box"]
        for v in np.linspace(v0, v1, 9):
            _, k1, k2, _ = shape_on_form(face, u, v)
            if max(abs(k1), abs(k2)) < sharpest:  # not the apex of a cone
                least, most = min(least, k2), max(most, k1)
    sense = skin.faces["sense"][skin.patches["face"][skin.leaves["patch"]]]
    bend = skin.leaves["bend"] / SAFETY
    bend = np.where(bend < sharpest, bend, 0.0)
    # bend[:, 0] hollows the side of S_s x S_t; that is the outside where sense > 0.
    hollow = np.where(sense > 0.0, bend[:, 0], bend[:, 1])
    bulge = np.where(sense > 0.0, bend[:, 1], bend[:, 0])
    least = min(least, -hollow.max(initial=0.0))
    most = max(most, bulge.max(initial=0.0))
    tiny = 1e-9
    return (
        -1.0 / least if least < -tiny else np.inf,
        1.0 / most if most > tiny else np.inf,
    )

"""Writes the die and the blank-holder of the strip as STEP, for 1.5, 3 and 6 elements on the die's quarter circle.

python examples/strip_pull_out/make_tools.py [FOLDER]

z up, mm      holder _________
              ================.        strip, its mid-plane at z = t / 2
              die ____________ `.      top at z = 0, its edge at x = 0
                               \\ |     quarter circle about (0, -r), then a wall at x = r
                                ||
"""

import re
import sys
from pathlib import Path

import cadquery as cq
from strip import COUNTS, THICKNESS, WIDTH, bend_radius

MARGIN = 5.0  # of the tools over the strip, sideways
LENGTH, DEPTH, HEIGHT = 80.0, 80.0, 20.0


def make_assembly(count):
    """DIE and BLANK_HOLDER in place."""
    radius, width = bend_radius(count) - 0.5 * THICKNESS, WIDTH + 2.0 * MARGIN
    corner = (-LENGTH, -MARGIN, -DEPTH)
    die = cq.Workplane("XY").box(LENGTH + radius, width, DEPTH, centered=False).translate(corner)
    die = die.edges(">X and >Z").fillet(radius)
    holder = cq.Workplane("XY").box(LENGTH, width, HEIGHT, centered=False).translate((-LENGTH, -MARGIN, THICKNESS))
    assembly = cq.Assembly(name="STRIP_PULL_OUT")
    assembly.add(die, name="DIE").add(holder, name="BLANK_HOLDER")
    return assembly


def write_step(count, folder):
    """Path of the file written; without a date, so that it is the same whenever the geometry is."""
    path = Path(folder) / f"strip_{count:g}.step"
    make_assembly(count).export(str(path), exportType="STEP", write_pcurves=False)
    text = re.sub(r"'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d'", "'1995-01-01T00:00:00'", path.read_text(), count=1)
    path.write_text(text)
    return path


if __name__ == "__main__":
    for elements in COUNTS:
        write_step(elements, sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent)

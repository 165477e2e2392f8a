"""Writes the tools and the blank of a suspension cup as a STEP assembly.

    python examples/coupelle/make_tools.py [FOLDER]

    z up, mm                  axis
    holder   ____________      |      ____________   bottom at z = t
    BLANK    =====================================   z = 0 ... t
    die      __________  \\     |     /  __________   top at z = 0
                       \\  \\_   |   _/  /
                        \\__ ---'--- __/              depth 17.5, raised seat in the middle

The founding paper shows a 'coupelle', the cup that bears a car's suspension spring, and gives no dimensions. These are
ours: one smooth profile for the middle of the formed sheet, from the raised seat on the axis over a valley and a
flaring wall to the flange. Punch and die are that profile moved by half the sheet and half the clearance to either
side, so that they match where they close. Their faces are B-splines turned about the axis.
"""

import re
import sys
from pathlib import Path

import cadquery as cq
import numpy as np
from scipy.interpolate import CubicSpline

THICKNESS = 0.8
CLEARANCE = 0.1  # between the closed tools, beyond the thickness
# Middle of the formed sheet: radius, height [mm]; a spline of continuous curvature passes through, level at both ends.
PROFILE = ((0.0, -14.5), (9.0, -15.3), (18.0, -17.5), (26.0, -13.8), (34.0, -4.9), (41.0, -0.8), (48.0, 0.0))
PUNCH_EDGE = 35.0  # radius at which the punch leaves the profile upwards
HOLDER_EDGE, HOLDER_ROUND = 48.0, 2.0  # inner edge of the blank-holder and its rounding
BLANK_RADIUS, TOOL_RADIUS = 75.0, 85.0
PUNCH_TOP, DIE_BOTTOM, HOLDER_HEIGHT = 35.0, -30.0, 20.0
STATIONS = 33  # points of the profile that the moved splines pass through


def profile():
    """Points (n, 2) r, z of the middle of the sheet and its normals (n, 2), which point up."""
    knots = np.array(PROFILE)
    chord = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(knots, axis=0).T))])
    level = (1, (1.0, 0.0))
    curve = CubicSpline(chord, knots, bc_type=(level, level))
    s = np.linspace(0.0, chord[-1], STATIONS)
    tangent = curve(s, 1) / np.linalg.norm(curve(s, 1), axis=1)[:, None]
    return curve(s), np.column_stack([-tangent[:, 1], tangent[:, 0]])


def moved(distance, up_to=np.inf):
    """Points (n, 2) of the profile moved along its normals, as far as a radius."""
    points, normals = profile()
    points = points + distance * normals
    return points[points[:, 0] <= up_to]


def turned(face, leaving, outline):
    """A solid of revolution about z: a spline through points (n, 2), level on the axis, closed by straight lines.

    leaving : direction of the spline's end, (r, z); outline : further corners
    """
    points = [(float(r), float(z)) for r, z in face]
    wire = cq.Workplane("XZ").moveTo(*points[0]).spline(points[1:], tangents=[(1, 0), leaving], includeCurrent=True)
    for corner in outline:
        wire = wire.lineTo(*corner)
    return wire.close().revolve(360, (0, 0, 0), (0, 1, 0))


def make_punch():
    """The punch, in place at the start of the stroke: its lowest point on the sheet."""
    face = moved(0.5 * (THICKNESS + CLEARANCE), PUNCH_EDGE)
    lift = THICKNESS - face[:, 1].min()
    edge = face[-1] - face[-2]
    face = face + [0.0, lift]
    top = THICKNESS + PUNCH_TOP
    return turned(face, tuple(edge), [(float(face[-1, 0]), top), (0.0, top)])


def make_die():
    """The die: its profile runs smoothly into the plane z = 0."""
    face = moved(-0.5 * (THICKNESS + CLEARANCE))
    # Where the middle of the sheet lies at z = 0 the die lies half a sheet and half the clearance below it.
    face = face + [0.0, -face[-1, 1]]
    return turned(face, (1, 0), [(TOOL_RADIUS, 0.0), (TOOL_RADIUS, DIE_BOTTOM), (0.0, DIE_BOTTOM)])


def make_holder():
    """The blank-holder on the sheet: a ring whose lower inner edge is rounded."""
    ring = cq.Workplane("XY", origin=(0, 0, THICKNESS)).circle(TOOL_RADIUS).circle(HOLDER_EDGE).extrude(HOLDER_HEIGHT)
    return ring.faces("<Z").edges(cq.selectors.RadiusNthSelector(0)).fillet(HOLDER_ROUND)


def make_assembly():
    """PUNCH, DIE, BLANK_HOLDER and BLANK, in place at the start of the stroke."""
    assembly = cq.Assembly(name="COUPELLE")
    assembly.add(make_punch(), name="PUNCH", color=cq.Color(0.80, 0.36, 0.25))
    assembly.add(make_die(), name="DIE", color=cq.Color(0.36, 0.45, 0.58))
    assembly.add(make_holder(), name="BLANK_HOLDER", color=cq.Color(0.58, 0.64, 0.52))
    assembly.add(
        cq.Workplane("XY").circle(BLANK_RADIUS).extrude(THICKNESS), name="BLANK", color=cq.Color(0.85, 0.85, 0.88)
    )
    return assembly


def write_step(folder):
    """Path of the file written; without a date, so that it is the same whenever the geometry is."""
    path = Path(folder) / "coupelle.step"
    make_assembly().export(str(path), exportType="STEP", write_pcurves=False)
    text = re.sub(r"'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d'", "'1995-01-01T00:00:00'", path.read_text(), count=1)
    path.write_text(text)
    return path


if __name__ == "__main__":
    write_step(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent)

"""Sheets stretched to large strains, with converged axisymmetric membranes to compare with: a hemispherical punch over
a clamped disc (geometry of Ghosh & Hecker, 1975, and Wang & Budiansky, J. Appl. Mech. 45 (1978) 73-82), and a bulge.

The references are finite-element solutions of an axisymmetric membrane (logarithmic strains, exact punch and die), made
for this project: punch with 240 elements and steps of 0.25 mm (with 120 and 0.125 mm the load differs by less than
0.1 %, strains by less than 0.0006), bulge with 200 (mesh error below 2e-4). Tool radii there are those of the
mid-surface.
"""

from dataclasses import dataclass

import numpy as np

import solver
from cadlink import Disc, SphereSurface, TorusSurface, mesh_blank

# Hemispherical punch

PUNCH, SHOULDER, CLAMP, THICKNESS = 50.8, 6.35, 59.18, 0.85  # mm
RADII = (5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0, 45.0, 50.0)  # mm, initial


@dataclass(frozen=True)
class Punch:
    """A coefficient of friction and its reference. force : {depth mm: kN}; thinning : {depth mm: thickness strain at
    RADII}"""

    mu: float
    force: dict
    thinning: dict


# fmt: off
PUNCHES = {
    "no friction": Punch(
        0.0,
        {5: 2.38, 10: 7.10, 15: 13.81, 20: 22.08, 25: 31.09, 30: 39.69},
        {
            10: (-0.0726, -0.0662, -0.0505, -0.0319, -0.0219, -0.0157, -0.0114, -0.0083, -0.0059, -0.0039),
            20: (-0.2154, -0.2080, -0.1927, -0.1666, -0.1267, -0.0877, -0.0630, -0.0459, -0.0334, -0.0237),
            30: (-0.4652, -0.4495, -0.4208, -0.3779, -0.3210, -0.2522, -0.1769, -0.1219, -0.0834, -0.0544),
        },
    ),
    "friction 0.17": Punch(
        0.17,
        {5: 2.39, 10: 7.17, 15: 14.06, 20: 22.77, 25: 32.62, 30: 42.66},
        {
            10: (-0.0658, -0.0641, -0.0512, -0.0324, -0.0223, -0.0160, -0.0116, -0.0085, -0.0060, -0.0039),
            20: (-0.1708, -0.1792, -0.1804, -0.1684, -0.1332, -0.0923, -0.0665, -0.0487, -0.0356, -0.0256),
            30: (-0.3108, -0.3364, -0.3561, -0.3617, -0.3413, -0.2844, -0.1982, -0.1365, -0.0943, -0.0629),
        },
    ),
    "friction 0.275": Punch(
        0.275,
        {5: 2.39, 10: 7.21, 15: 14.19, 20: 23.09, 25: 33.29, 30: 43.80},
        {
            10: (-0.0618, -0.0627, -0.0517, -0.0328, -0.0225, -0.0161, -0.0117, -0.0085, -0.0060, -0.0040),
            20: (-0.1467, -0.1616, -0.1717, -0.1696, -0.1381, -0.0951, -0.0684, -0.0501, -0.0367, -0.0265),
            30: (-0.2334, -0.2662, -0.3009, -0.3340, -0.3532, -0.3179, -0.2131, -0.1450, -0.1001, -0.0672),
        },
    ),
}
# fmt: on


def steel(stronger=1.0):
    """Steel of Wang and Budiansky, with stresses times a factor."""
    swift = solver.Swift(510.0 * stronger, 0.00535677, 0.210084)
    return solver.Material(206800.0 * stronger, 0.3, solver.VonMises(), swift, "WB steel")


def punch_scene(problem, size, element=None, travel=30.0, thinner=1.0):
    """A quarter of the disc between punch and die.

    problem : Punch; size : of the mesh [mm]; element : Membrane()
    thinner : times, and as many times as strong: the same membrane, which the tools do not meet half a thickness away.
        The reference's mid-surface keeps its distance from the tools as the sheet grows thin, a sheet does not
    """
    mesh = mesh_blank(Disc(CLAMP), size, arrangement="structured", symmetry=("x", "y"))
    thickness = THICKNESS / thinner
    blank = solver.Blank(mesh, thickness, steel(thinner), element or solver.Membrane(), fixed={"rim": "xyz"})
    oil, half = solver.Coulomb(problem.mu) if problem.mu else None, 0.5 * thickness
    ball = SphereSurface(PUNCH - half, (0.0, 0.0, PUNCH))
    ring = TorusSurface(CLAMP, SHOULDER - half, (0.0, 0.0, -SHOULDER))
    tools = [solver.Tool("PUNCH", ball, oil, travel=-travel), solver.Tool("DIE", ring, oil)]
    return solver.Scene(blank, [solver.Stage(tools)], name="hemispherical punch")


def punch_errors(problem, scene, results):
    """{depth mm: (relative error of the force, largest error of the thickness strain at RADII or None)} of the depths
    that frames were kept at."""
    found = {}
    for frame in results.frames[1:]:
        depth = round(frame.stroke, 6)
        if depth not in problem.force:
            continue
        force = abs(results.at("force_PUNCH", frame.stroke))
        off = None
        if depth in problem.thinning:
            strain = along_radius(scene.blank.mesh, thinning(frame))(RADII)
            off = float(np.abs(strain - problem.thinning[depth]).max())
        found[depth] = (force / (1e3 * problem.force[depth]) - 1.0, off)
    return found


# Bulge

BULGE, BULGE_THICKNESS = 50.0, 1.0  # mm, clamped radius
OSU = solver.Material(69004.0, 0.3, solver.VonMises(), solver.Swift(589.0, 1e-4, 0.216), "OSU")
DOME = {10: (4.396677, -0.064414), 15: (7.099860, -0.146655), 20: (9.230447, -0.264063), 25: (10.540914, -0.419960)}
"""{height of the dome [mm]: (pressure [MPa], thickness strain of its pole)}"""


def bulge_scene(size, element=None, pressure=10.6):
    """A quarter of the clamped disc under pressure from below. size : of the mesh [mm]; pressure : at the end [MPa]"""
    mesh = mesh_blank(Disc(BULGE), size, arrangement="structured", symmetry=("x", "y"))
    blank = solver.Blank(mesh, BULGE_THICKNESS, OSU, element or solver.Membrane(), fixed={"rim": "xyz"})
    return solver.Scene(blank, [solver.Stage(pressure=-pressure)], name="hydraulic bulge")


def bulge_errors(scene, results):
    """{height mm: (relative error of the pressure, error of the pole's thickness strain)}, of the heights reached."""
    full = abs(scene.stages[0].pressure)
    pole = np.argmin(np.linalg.norm(scene.blank.mesh.points, axis=1))
    height = np.array([frame.points[pole, 2] for frame in results.frames])
    pressure = full * np.array([frame.stroke for frame in results.frames])
    strain = [along_radius(scene.blank.mesh, thinning(frame))(0.0)[0] for frame in results.frames]
    return {
        h: (float(np.interp(h, height, pressure)) / p - 1.0, float(np.interp(h, height, strain)) - e)
        for h, (p, e) in DOME.items()
        if h <= height[-1]
    }


# Both


def thinning(frame):
    """Thickness strain of every triangle as the references have it (m,): less the total strains in the plane."""
    return -(frame.cell_fields["strain_major"] + frame.cell_fields["strain_minor"])


def along_radius(mesh, values):
    """Function of the initial radius [mm] that is the mean of the triangles' values (m,) there: moving parabolas over
    some 30 triangles, which see neither their scatter around the circle nor their two orientations."""
    centre = mesh.points[mesh.cells].mean(axis=1)
    radius = np.hypot(centre[:, 0], centre[:, 1])

    def mean(at):
        found = []
        for place in np.atleast_1d(at):
            away = radius - place
            width = max(np.sort(np.abs(away))[min(30, len(away) - 1)], 1e-9)
            weight = np.sqrt(np.maximum(1.0 - (away / width) ** 2, 0.0))
            terms = np.column_stack([np.ones_like(away), away, away**2])
            found.append(np.linalg.lstsq(terms * weight[:, None], values * weight, rcond=None)[0][0])
        return np.array(found)

    return mean

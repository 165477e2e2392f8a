"""Tools that carry loads: pressed by a force or a spring, with stops, guided or free to tilt (theory.md 8).

    a        axis;  press  its sign that leads to the sheet;  w  travel;  p = c + w a  pivot, c its place in the file
    theta    rotation vector, across a: the tool has turned by R = exp [theta], the shortest turn that does it
    r        a pin's place beside the pivot in the CAD file: forces act at p + R r, along a
    b        how far a pin is pushed back from first touch;  phi(b) = <load + k b> + k_s <b - stop>  its force
    f, K     force of a node on the tool's contact [N], K = - df/dx [N/mm]

Free coordinates z_j: the travel, and where it may tilt theta = sum z_j e_j / L about the axes e_j, L a length of the
blank's so that all are millimetres and what balances them newtons. A small change dz_j moves the tool's points by
v_j dz_j: v = a for the travel, v = omega_j x (x - p) with omega_j = J(theta) e_j / L for a turn, J the left Jacobian of
the rotation vector, J = 1 + B [theta] + C [theta]^2, B = (1 - cos t) / t^2, C = (t - sin t) / t^3.

    balance_j = sum_pins phi press a . v_j - sum_nodes f . v_j

Contact forces turn with the tool and the sheet together, so that moving the tool alone by dz_j changes a node's force
by omega_j x f + K v_j. That gives column, row and corner of the bordered tangent; the row is the column where K is
symmetric.
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from ..errors import SceneError
from ..scene import AXES
from .friction import Laws
from .search import Neighbourhood

SERIES = 1e-2  # rad: below, B and C and their slopes by their series


class Drive(NamedTuple):
    """What bears a tool, of the modelled share.

    load : N where it first touches; stiffness : N/mm of a spring; stop : mm it can be pushed back; solid : N/mm beyond
    pins : (l, 3) beside the pivot [mm]; axes : (j, 3) unit vectors it may tilt about; lever : L [mm]
    carrier : (ToolRun it rides on) or None
    """

    load: float
    stiffness: float
    stop: float
    solid: float
    pins: np.ndarray
    axes: np.ndarray
    lever: float
    carrier: "ToolRun | None"


class ToolRun(NamedTuple):
    """A tool in its stage. start : travel at its beginning [mm]; press : sign of its axis that leads to the sheet
    drive : what bears it, None for a tool of prescribed motion; kn, kt : (n,) stiffnesses [N/mm]
    laws : of friction where it is more than a number; pivot : (3,) of a tool that is or may be tilted, else None"""

    tool: object
    axis: np.ndarray
    start: float
    press: float
    drive: Drive | None
    kn: np.ndarray
    kt: np.ndarray
    neighbourhood: Neighbourhood
    laws: Laws | None = None
    pivot: np.ndarray | None = None


# What the scene says


def pivot_of(tool, sheet):
    """Where a tool's force acts (3,), the middle of its pins; by default the middle of the blank, on its planes of
    symmetry."""
    if tool.at is not None:
        return np.atleast_2d(np.asarray(tool.at, dtype=float)).mean(axis=0)
    middle = sheet.area @ sheet.points / sheet.area.sum()
    for axis in sheet.blank.symmetry_planes:
        c = AXES.index(axis)
        middle[c] = sheet.points[sheet.blank.nodes_of(f"symmetry_{axis}"), c].mean()
    return middle


def build_drive(tool, sheet, kn, carrier):
    """Drive of a tool borne by a force or a spring, None of others. kn : (n,) contact stiffness, whose sum a stop has;
    carrier : ToolRun it rides on, or None"""
    if not tool.gives_way:
        return None
    share = sheet.blank.share
    load, stiffness = (tool.force, 0.0) if tool.spring is None else (tool.spring.preload, tool.spring.stiffness)
    pivot = pivot_of(tool, sheet)
    pins = np.atleast_2d(np.asarray(pivot if tool.at is None else tool.at, dtype=float)) - pivot
    lever = float(np.sqrt(np.mean(np.sum((sheet.points - sheet.points.mean(axis=0)) ** 2, axis=1))))
    axes = tilt_axes(tool, sheet.blank) if tool.tilts else np.zeros((0, 3))
    for axis in sheet.blank.symmetry_planes if tool.tilts else ():
        c = AXES.index(axis)
        plane = sheet.points[sheet.blank.nodes_of(f"symmetry_{axis}"), c].mean()
        if abs(pivot[c] - plane) > 1e-6 * lever:
            raise SceneError(
                f"tool {tool.name!r} at: found {axis} = {pivot[c]:g} mm, expected a point of action on the plane of "
                f"symmetry {axis} = {plane:g} mm"
            )
    stop = np.inf if tool.stop is None else tool.stop
    return Drive(share * load, share * stiffness, stop, float(kn.sum()), pins, axes, lever, carrier)


def tilt_axes(tool, blank):
    """Unit vectors (j, 3) across a tool's axis that it may tilt about: across a plane of symmetry only that plane's
    normal leaves the part symmetric."""
    a = tool.unit_axis
    if not blank.symmetry_planes:
        first = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
        first /= np.linalg.norm(first)
        return np.stack([first, np.cross(a, first)])
    normals = np.eye(3)[[AXES.index(axis) for axis in blank.symmetry_planes]]
    if len(normals) > 1 or abs(normals[0] @ a) > 1e-9:
        raise SceneError(
            f"tool {tool.name!r} tilts: found symmetry planes {', '.join(blank.symmetry_planes)}, which keep it "
            "straight; expected a guided tool, or a mesh of the whole blank"
        )
    return normals


# Where a tool is


def turn(theta):
    """Rotation matrix (3, 3) of a rotation vector."""
    t = float(np.linalg.norm(theta))
    b, c = _coefficients(t)
    cross = skew(theta)
    # exp = 1 + sin t / t [theta] + (1 - cos t) / t^2 [theta]^2, and sin t / t = 1 - C t^2
    return np.eye(3) + (1.0 - c * t * t) * cross + b * cross @ cross


def skew(v):
    """Matrix of v x."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def _coefficients(t):
    """B and C."""
    if t < SERIES:
        return 0.5 - t * t / 24.0 + t**4 / 720.0, 1.0 / 6.0 - t * t / 120.0 + t**4 / 5040.0
    return (1.0 - cos(t)) / t**2, (t - sin(t)) / t**3


def _slopes(t):
    """dB/dt / t and dC/dt / t."""
    if t < SERIES:
        return -1.0 / 12.0 + t * t / 180.0, -1.0 / 60.0 + t * t / 1260.0
    return (t * sin(t) - 2.0 * (1.0 - cos(t))) / t**4, (3.0 * sin(t) - t * cos(t) - 2.0 * t) / t**5


def to_tool(run, contact, points):
    """Points (n, 3) in the frame the tool's CAD file has."""
    if run.pivot is None:
        return points - contact.travel * run.axis
    return (points - run.pivot - contact.travel * run.axis) @ turn(contact.tilt) + run.pivot


def to_space(run, contact, hit):
    """A Projection in the tool's frame with its directions in space: distance, curvature, face stay what they are."""
    if run.pivot is None:
        return hit
    matrix = turn(contact.tilt).T
    return Directed(hit.distance, hit.normal @ matrix, hit.curvature, hit.direction @ matrix, hit.face)


class Directed(NamedTuple):
    """What contact needs of a Projection."""

    distance: np.ndarray
    normal: np.ndarray
    curvature: np.ndarray
    direction: np.ndarray
    face: np.ndarray


def carried(run, before, after, points):
    """Where points (n, 3) of the tool at an increment's start are at its end, and how it has turned (3, 3)."""
    moved = after.travel - before.travel
    if run.pivot is None:
        return points + moved * run.axis, None
    matrix = turn(after.tilt) @ turn(before.tilt).T
    pivot = run.pivot + before.travel * run.axis
    return (points - pivot) @ matrix.T + pivot + moved * run.axis, matrix


# Free coordinates of the tools that carry loads


def coordinates(runs, state):
    """z of all tools (k,) [mm]: the travel of each, and its tilts."""
    found = []
    for run in runs:
        contact = state.tools[run.tool.name]
        found += [contact.travel, run.drive.axes @ contact.tilt * run.drive.lever]
    return np.concatenate(found) if found else np.zeros(0)


def move_tools(runs, state, z):
    """Put the tools where z (k,) says."""
    first = 0
    for run in runs:
        contact, axes = state.tools[run.tool.name], run.drive.axes
        contact.travel[0] = z[first]
        first += 1 + len(axes)
        if len(axes):
            contact.tilt[:] = z[first - len(axes) : first] @ axes / run.drive.lever


def spins(run, contact):
    """omega (j, 3) of the coordinates, 0 for the travel, and their slopes (j, j, 3) by the coordinates."""
    drive = run.drive
    j = 1 + len(drive.axes)
    omega, slope = np.zeros((j, 3)), np.zeros((j, j, 3))
    if j == 1:
        return omega, slope
    theta = contact.tilt
    t = float(np.linalg.norm(theta))
    (b, c), (db, dc) = _coefficients(t), _slopes(t)
    for i, e in enumerate(drive.axes, 1):
        once = np.cross(theta, e)
        twice = np.cross(theta, once)
        omega[i] = (e + b * once + c * twice) / drive.lever
        for k, u in enumerate(drive.axes, 1):
            along = theta @ u
            change = b * np.cross(u, e) + db * along * once + dc * along * twice
            change += c * (np.cross(u, once) + np.cross(theta, np.cross(u, e)))
            slope[i, k] = change / drive.lever**2
    return omega, slope


def lanes(run, contact, omega, x):
    """v (j, n, 3) at points x (n, 3)."""
    v = np.cross(omega[:, None, :], (x - run.pivot - contact.travel * run.axis)[None])
    v[0] = run.axis
    return v


def movement_of(run, state, dz):
    """How far a small change dz (j,) of a tool's coordinates carries its points where the nodes are, (n, 3) [mm]."""
    if run.pivot is None:
        return np.broadcast_to(dz[0] * run.axis, state.sheet.x.shape)
    contact = state.tools[run.tool.name]
    return np.einsum("j,jnc->nc", dz, lanes(run, contact, spins(run, contact)[0], state.sheet.x))


def way_back(run, state):
    """How far [mm] a tool's pivot is pushed back."""
    contact, other = state.tools[run.tool.name], run.drive.carrier
    if other is None:
        back = contact.rest[0] - contact.travel[0]
    else:
        # The carrier may have left since first touch: counted from the stage's start.
        back = run.start - contact.travel[0]
        back += (state.tools[other.tool.name].travel[0] - other.start) * float(other.axis @ run.axis)
    return float(run.press * back)


def pushed_back(run, state, pins):
    """b (l,) [mm] of the pins, at p + pins (l, 3) beside the pivot now."""
    return way_back(run, state) - run.press * ((pins - run.drive.pins) @ run.axis)


def pin_forces(drive, back):
    """phi and its slope of each pin, (l,) [N], [N/mm]."""
    n = len(back)
    borne = (drive.load + drive.stiffness * back) / n
    over = back - drive.stop
    force = np.maximum(borne, 0.0) + drive.solid / n * np.maximum(over, 0.0)
    slope = np.where(borne > 0.0, drive.stiffness, 0.0) / n + np.where(over > 0.0, drive.solid, 0.0) / n
    return force, slope


def _pins_now(run, contact):
    pins = run.drive.pins
    return pins if run.pivot is None else pins @ turn(contact.tilt).T


def force_borne(run, state):
    """Force [N] that bears a tool that does not tilt now, of the modelled share: its pins are pushed back alike."""
    drive, back = run.drive, way_back(run, state)
    return max(drive.load + drive.stiffness * back, 0.0) + drive.solid * max(back - drive.stop, 0.0)


def load_on(run, state, uplift=None):
    """What bears a tool, on each of its coordinates (j,) [N].

    uplift : (points (q, 3), forces (q,) [N]) that push it back from the sheet, or None
    """
    contact = state.tools[run.tool.name]
    if run.pivot is None:
        return np.array([run.press * (force_borne(run, state) - (uplift[1].sum() if uplift else 0.0))])
    omega, _ = spins(run, contact)
    pins = _pins_now(run, contact)
    force, _ = pin_forces(run.drive, pushed_back(run, state, pins))
    v = np.cross(omega[:, None, :], pins[None])
    v[0] = run.axis
    found = run.press * v @ run.axis @ force
    if uplift:
        found -= run.press * lanes(run, contact, omega, uplift[0]) @ run.axis @ uplift[1]
    return found


def balance(run, state, uplift=None):
    """What is out of balance at each coordinate of a tool (j,) [N]. uplift : see load_on"""
    contact = state.tools[run.tool.name]
    if run.pivot is None:
        return load_on(run, state, uplift) + contact.force @ run.axis
    v = lanes(run, contact, spins(run, contact)[0], state.sheet.x)
    return load_on(run, state, uplift) - np.einsum("nc,jnc->j", contact.push, v)


def borders(run, state, blocks, uplift=None):
    """column (n, 3, j), row (n, 3, j) and corner (j, j) of the tangent, -d residual / d unknowns.

    blocks : (n, 3, 3) K of the tool's contact
    """
    contact = state.tools[run.tool.name]
    if run.pivot is None:
        column, row = -blocks @ run.axis, -np.einsum("ncd,c->nd", blocks, run.axis)
        _, slope = pin_forces(run.drive, pushed_back(run, state, run.drive.pins))
        corner = run.axis @ blocks.sum(axis=0) @ run.axis + slope.sum()
        return column[:, :, None], row[:, :, None], np.array([[corner]])
    push = contact.push
    omega, change = spins(run, contact)
    v = lanes(run, contact, omega, state.sheet.x)
    arm = state.sheet.x - run.pivot - contact.travel * run.axis
    turned = np.cross(omega[:, None, :], push[None])  # omega_j x f
    column = -np.einsum("ncd,jnd->ncj", blocks, v) - np.moveaxis(turned, 0, 2)
    row = -np.einsum("ndc,jnd->ncj", blocks, v) - np.moveaxis(turned, 0, 2)
    corner = np.einsum("jnc,ncd,knd->jk", v, blocks, v) + np.einsum("jnc,knc->jk", v, turned)
    # Where the lanes themselves change: spins turn into each other, and a travel takes the pivot along.
    corner += np.einsum("jkc,c->jk", change, np.cross(arm, push).sum(axis=0))
    corner[:, 0] -= np.cross(omega, run.axis) @ push.sum(axis=0)
    pins = _pins_now(run, contact)
    force, slope = pin_forces(run.drive, pushed_back(run, state, pins))
    pin_lanes = np.cross(omega[:, None, :], pins[None])
    pin_lanes[0] = run.axis
    along = pin_lanes @ run.axis
    corner += np.einsum("jl,l,kl->jk", along, slope, along)
    bent = np.einsum("jkc,lc->jkl", change, np.cross(pins, run.axis))
    bent += np.einsum("jc,klc->jkl", np.cross(run.axis, omega), np.cross(omega[:, None, :], pins[None]))
    corner -= run.press * bent @ force
    if uplift:
        arm = uplift[0] - run.pivot - contact.travel * run.axis
        corner += run.press * np.einsum("jkc,c->jk", change, uplift[1] @ np.cross(arm, run.axis))
    return column, row, corner

"""A die and a punch from a STEP file, and from one in which they are turned and moved: the cup drawn with them is the
same."""

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cadlink import read_step
from solver import Stage, form
from tests.stability.cups import Cup
from tests.stability.test_equal import EQUAL, SHIFT, STEADY, TURN

CUP = Cup(quarter=False, travel=2.5, size=4.0)


def tools(path, turn, shift):
    """DIE and PUNCH of the cup, read from a STEP file in which they are turned (3, 3) and then moved (3,)."""
    rim = CUP.opening + CUP.die_radius
    block = cq.Workplane("XY").circle(2.0 * CUP.blank).extrude(-20.0)
    die = block.cut(cq.Workplane("XY").circle(CUP.opening).extrude(-20.0))
    die = die.faces(">Z").edges(cq.selectors.BoxSelector((-rim, -rim, -1.0), (rim, rim, 1.0))).fillet(CUP.die_radius)
    punch = cq.Workplane("XY").sphere(CUP.punch).translate((0.0, 0.0, CUP.thickness + CUP.punch))
    about = Rotation.from_matrix(turn).as_rotvec()
    angle = np.linalg.norm(about)
    axis = about / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
    place = cq.Location(cq.Vector(*shift), cq.Vector(*axis), np.degrees(angle))
    assembly = cq.Assembly(name="CUP", loc=place)
    assembly.add(die, name="DIE").add(punch, name="PUNCH")
    assembly.export(str(path), exportType="STEP")
    parts = read_step(path)
    return {name: parts[name].surface() for name in ("DIE", "PUNCH")}


def formed(cup, surfaces):
    """Nodes in the upright cup's place (n, 3), forces of the punch [N]."""
    scene = cup.scene()
    found = [replace(t, surface=surfaces.get(t.name, t.surface)) for t in scene.stages[0].tools]
    results = form(replace(scene, stages=[Stage(found)]), STEADY, frames=1)
    return (results.frames[-1].points - cup.shift) @ np.asarray(cup.turn), np.array(results.history["force_PUNCH"])


def test_a_rigid_motion_of_the_step_file(tmp_path):
    points, force = formed(CUP, tools(tmp_path / "upright.step", np.eye(3), np.zeros(3)))
    turned = replace(CUP, turn=TURN, shift=SHIFT)
    points_turned, force_turned = formed(turned, tools(tmp_path / "turned.step", TURN, SHIFT))
    assert points_turned == pytest.approx(points, abs=EQUAL)
    assert force_turned == pytest.approx(force, abs=EQUAL * np.abs(force).max())


def test_primitives_and_the_faces_of_a_file_are_the_same_tools(tmp_path):
    surfaces = tools(tmp_path / "upright.step", np.eye(3), np.zeros(3))
    points, force = formed(CUP, surfaces)
    same_points, same_force = formed(CUP, {})
    assert same_points == pytest.approx(points, abs=EQUAL)
    assert same_force == pytest.approx(force, abs=EQUAL * np.abs(force).max())

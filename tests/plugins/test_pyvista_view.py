"""Pictures of a run, off-screen."""

import numpy as np
import pytest
import pyvista

from plugins.pyvista_view import draw_run, load, round_scale, von_mises
from plugins.report import RunFolderError


def test_the_whole_sheet_is_shown_at_the_nearest_stroke(run_folder, cup):
    shot = load(run_folder / "result.pvd", "thinning", 11.0)
    assert shot.stroke == 10.0
    assert shot.sheet.n_cells == 4 * len(cup.scene.blank.mesh.cells)
    x_low, x_high, y_low, y_high = shot.sheet.bounds[:4]
    assert (x_low, y_low) == pytest.approx((-x_high, -y_high))
    assert set(shot.tools) == {"PUNCH", "DIE", "BLANK_HOLDER"}
    last = load(run_folder / "result.pvd", "thickness", None)
    assert last.stroke == 40.0
    assert last.label == "thickness [mm]"
    thickness = cup.frame(40.0).cell_fields["thickness"]
    shown = last.sheet["shown"]  # means over the triangles of a node
    assert thickness.min() - 1e-12 <= shown.min() < shown.max() <= thickness.max() + 1e-12


def test_picture(run_folder):
    draw_run(run_folder, run_folder / "cup.png", size=(600, 300))
    pixels = pyvista.read(run_folder / "cup.png").point_data.active_scalars
    assert len(pixels) == 600 * 300
    assert np.std(pixels[:, :3].astype(float), axis=0).min() > 10.0  # something is drawn


def test_a_field_or_run_that_does_not_exist(run_folder, tmp_path):
    with pytest.raises(RunFolderError, match=r"found no field 'thining', expected one of .*thinning"):
        draw_run(run_folder, tmp_path / "a.png", field="thining")
    with pytest.raises(RunFolderError, match=r"result.pvd: no such file"):
        draw_run(tmp_path / "none", tmp_path / "a.png")


def test_von_mises_of_simple_states():
    tension, shear = [100.0, 0, 0, 0, 0, 0], [0, 0, 0, 100.0, 0, 0]
    assert von_mises(np.array([tension, shear])) == pytest.approx([100.0, 100.0 * np.sqrt(3.0)])


@pytest.mark.parametrize(
    "values, limits, n_steps",
    [
        ([-15.2, 17.3], (-20.0, 20.0), 8),
        ([0.637, 0.969], (0.6, 1.0), 8),
        ([0.0, 10.0], (0.0, 10.0), 5),
        ([3.0, 3.0], (2.4, 3.6), 6),
    ],
)
def test_colours_end_on_round_numbers(values, limits, n_steps):
    scale = round_scale(np.array(values))
    assert scale.limits == pytest.approx(limits)
    assert scale.n_steps == n_steps

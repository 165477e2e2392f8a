"""Published sheets: every one can be computed with, says where it is from, and is what the reference collects."""

import numpy as np
import pytest

from solver import SceneError
from solver.materials.library import SHEETS, published_sheet
from solver.materials.yield_locus import uniaxial


@pytest.mark.parametrize("name", SHEETS)
def test_every_sheet_says_where_it_is_from(name):
    sheet, material = SHEETS[name], published_sheet(name)
    assert material.name == name
    assert len(sheet.source) > 20
    assert "P" in sheet.grade or "M" in sheet.grade
    assert 100.0 < material.initial_yield_stress < 600.0 or name == "osu-formability"


def test_ak_steel_starts_at_its_published_yield_stress():
    assert published_sheet("ak-steel").initial_yield_stress == pytest.approx(170.0)


def test_mild_steel_has_its_published_r_values():
    # benchmarks.md A, confirmed by the printed stress ratios R22 = 1.0402.
    stress, r = uniaxial(published_sheet("numisheet93-steel").locus, np.radians([0.0, 45.0, 90.0]))
    assert r == pytest.approx([1.79, 1.51, 2.27], rel=1e-12)
    assert stress[2] == pytest.approx(1.0402, abs=5e-5)


def test_an_unknown_sheet_is_refused_with_the_names_there_are():
    with pytest.raises(SceneError, match="'steel' does not exist; there are numisheet93-steel, "):
        published_sheet("steel")

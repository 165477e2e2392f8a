"""Values of a scene file: numbers, and text with a unit."""

import pytest
from pydantic import TypeAdapter, ValidationError

from plugins.quantities import Coefficient, Count, Direction, PositiveForce, PositiveLength, PositiveStress


def read(kind, value):
    return TypeAdapter(kind).validate_python(value)


def message(kind, value):
    with pytest.raises(ValidationError) as caught:
        read(kind, value)
    return caught.value.errors()[0]["msg"]


@pytest.mark.parametrize(
    "kind, value, expected",
    [
        (PositiveLength, 0.81, 0.81),
        (PositiveLength, 2, 2.0),
        (PositiveLength, "0.81 mm", 0.81),
        (PositiveLength, "0.81", 0.81),
        (PositiveLength, "2.5e-3m", 2.5),
        (PositiveLength, "1 inch", 25.4),
        (PositiveForce, "19.6 kN", 19600.0),
        (PositiveStress, "71 GPa", 71000.0),
        (PositiveStress, "577 N/mm^2", 577.0),
        (Coefficient, 0, 0.0),
        (Direction, [1, 0, 0], (1.0, 0.0, 0.0)),
        (Count, 3, 3),
    ],
)
def test_value_in_mm_newton_megapascal(kind, value, expected):
    assert read(kind, value) == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    "kind, value, found",
    [
        (PositiveLength, -0.81, "found -0.81, expected a length above 0 in mm"),
        (PositiveLength, "-0.81 mm", 'found "-0.81 mm", expected a length above 0 in mm'),
        (PositiveLength, "2.5 kN", 'found "2.5 kN", not a length, expected a length above 0 in mm'),
        (PositiveLength, "2.5 foo", "with an unknown unit"),
        (PositiveLength, "__import__('os')", "expected a length"),
        (PositiveLength, "1 mm)", "expected a length"),
        (PositiveLength, "", "expected a length"),
        (PositiveLength, True, "found true, expected a length"),
        (PositiveLength, float("nan"), "found nan, expected a length"),
        (PositiveLength, float("inf"), "found inf, expected a length"),
        (PositiveLength, [1.0], "expected a length"),
        (PositiveForce, "19.6 kg", "not a force"),
        (Coefficient, "0.1", 'found "0.1", expected a number of at least 0'),
        (Direction, [0, 0, 0], "three numbers that are not all 0"),
        (Direction, [1, 0], "three numbers"),
        (Count, 0, "a whole number of at least 1"),
        (Count, 1.5, "a whole number of at least 1"),
    ],
)
def test_wrong_value_says_what_was_found_and_expected(kind, value, found):
    assert found in message(kind, value)

"""Values of a scene file: plain numbers in mm, N, s, MPa, or text with a unit such as "19.6 kN".

Each name below is a type for a pydantic field. A wrong value raises one line: what was found, and expected.
"""

import re
from functools import cache
from math import isfinite
from typing import Annotated

from pydantic import BeforeValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

NUMBER_AND_UNIT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*?)?\s*")
EXAMPLES = {"mm": "2.5 mm", "N": "19.6 kN", "MPa": "70 GPa"}


def wrong(found, expected):
    """The error of one value; both in words."""
    return PydanticCustomError(
        "scene", "found {found}, expected {expected}", {"found": found, "expected": expected}
    )


def shown(value):
    """A value as a scene file would spell it, cut short where it is long."""
    if isinstance(value, str):
        text = f'"{value}"'
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, dict):
        text = "a table with the keys " + ", ".join(value) if value else "an empty table"
    else:
        text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


@cache
def _units():
    import pint

    return pint.UnitRegistry(cache_folder=None)


def converted(text, unit, kind, expected):
    """Number of `unit` in a text such as "0.81 mm"; a bare number counts in `unit` already."""
    match = NUMBER_AND_UNIT.fullmatch(text)
    if match is None:
        raise wrong(shown(text), expected)
    number, written = float(match[1]), match[2]
    if written is None:
        return number
    import pint

    try:
        return float(_units().Quantity(number, written).to(unit).magnitude)
    except pint.UndefinedUnitError:
        raise wrong(f"{shown(text)} with an unknown unit", expected) from None
    except pint.DimensionalityError:
        raise wrong(f"{shown(text)}, not {kind}", expected) from None
    except Exception:  # pint passes on whatever its parser stumbles over
        raise wrong(shown(text), expected) from None


def quantity(kind, unit=None, above=None, at_least=None, below=None):
    """Type of a number with a unit. kind : "a length"; the limits are in `unit`."""
    limits = [
        f"{words} {limit:g}"
        for words, limit in (("above", above), ("of at least", at_least), ("below", below))
        if limit is not None
    ]
    example = f', such as "{EXAMPLES[unit]}"' if unit in EXAMPLES else ""
    expected = (
        " ".join([kind, " and ".join(limits), f"in {unit}{example}" if unit else ""])
        .replace("  ", " ")
        .strip()
    )

    def check(value):
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            raise wrong(shown(value), expected)
        if isinstance(value, str) and unit is None:
            raise wrong(shown(value), expected)
        number = converted(value, unit, kind, expected) if isinstance(value, str) else float(value)
        inside = (
            isfinite(number)
            and (above is None or number > above)
            and (at_least is None or number >= at_least)
            and (below is None or number < below)
        )
        if not inside:
            raise wrong(shown(value), expected)
        return number

    schema = {"type": ["number", "string"] if unit else "number", "description": expected}
    return Annotated[float, BeforeValidator(check), WithJsonSchema(schema)]


def _check_vector(value):
    good = isinstance(value, (list, tuple)) and len(value) == 3
    good = good and all(
        isinstance(c, (int, float)) and not isinstance(c, bool) and isfinite(c) for c in value
    )
    if not good or not any(value):
        raise wrong(shown(value), "a direction, three numbers that are not all 0, such as [1, 0, 0]")
    return tuple(float(c) for c in value)


def _check_name(value):
    if not isinstance(value, str) or not value.strip():
        raise wrong(shown(value), "a text")
    return value


def _check_count(value):
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise wrong(shown(value), "a whole number of at least 1")
    return value


Length = quantity("a length", "mm")
PositiveLength = quantity("a length", "mm", above=0.0)
PositiveForce = quantity("a force", "N", above=0.0)
Stress = quantity("a stress", "MPa")
PositiveStress = quantity("a stress", "MPa", above=0.0)
Number = quantity("a number")
PositiveNumber = quantity("a number", above=0.0)
Coefficient = quantity("a number", at_least=0.0)
Direction = Annotated[tuple[float, float, float], BeforeValidator(_check_vector)]
Name = Annotated[str, BeforeValidator(_check_name)]
Count = Annotated[int, BeforeValidator(_check_count)]

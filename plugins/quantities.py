"""Values of a scene file: plain numbers in mm, N, s, MPa, or text with a unit such as "19.6 kN".

Each name below is a type for a pydantic field. A wrong value raises one line: what was found, and expected.
"""

import re
from dataclasses import dataclass
from functools import cache
from math import isfinite
from typing import Annotated

from pydantic import BeforeValidator
from pydantic_core import PydanticCustomError, core_schema

NUMBER_AND_UNIT = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S.*?)?\s*")
EXAMPLES = {
    "mm": "2.5 mm",
    "N": "19.6 kN",
    "MPa": "70 GPa",
    "tonne/mm^3": "7850 kg/m^3",
    "N/mm": "80 N/mm",
    "mm/s": "50 mm/s",
    "mm/s^2": "9.81 m/s^2",
    "MPa*s": "0.5 Pa*s",
}


def wrong(found, expected):
    """The error of one value; both in words."""
    return PydanticCustomError("scene", "found {found}, expected {expected}", {"found": found, "expected": expected})


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


@dataclass(frozen=True)
class Quantity:
    """A number with a unit, for Annotated[float, Quantity("a length", "mm")]; limits are in `unit`."""

    kind: str
    unit: str | None = None
    above: float | None = None
    at_least: float | None = None
    below: float | None = None

    @property
    def expected(self):
        """In words, for example: a length above 0 in mm, such as "2.5 mm"."""
        limits = (("above", self.above), ("of at least", self.at_least), ("below", self.below))
        words = [self.kind, " and ".join(f"{text} {limit:g}" for text, limit in limits if limit is not None)]
        if self.unit:
            words.append(f"in {self.unit}")
        example = f', such as "{EXAMPLES[self.unit]}"' if self.unit else ""
        return " ".join(word for word in words if word) + example

    def check(self, value):
        """The number in `unit`, of a number or a text with a unit."""
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            raise wrong(shown(value), self.expected)
        if isinstance(value, str):
            if self.unit is None:
                raise wrong(shown(value), self.expected)
            number = converted(value, self.unit, self.kind, self.expected)
        else:
            number = float(value)
        inside = (
            isfinite(number)
            and (self.above is None or number > self.above)
            and (self.at_least is None or number >= self.at_least)
            and (self.below is None or number < self.below)
        )
        if not inside:
            raise wrong(shown(value), self.expected)
        return number

    def __get_pydantic_core_schema__(self, source, handler):
        return core_schema.no_info_before_validator_function(self.check, handler(source))

    def __get_pydantic_json_schema__(self, schema, handler):
        return {"type": ["number", "string"] if self.unit else "number", "description": self.expected}


def _check_vector(value):
    good = isinstance(value, (list, tuple)) and len(value) == 3
    good = good and all(isinstance(c, (int, float)) and not isinstance(c, bool) and isfinite(c) for c in value)
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


Length = Annotated[float, Quantity("a length", "mm")]
PositiveLength = Annotated[float, Quantity("a length", "mm", above=0.0)]
Preload = Annotated[float, Quantity("a force", "N", at_least=0.0)]
LineForce = Annotated[float, Quantity("a force per length", "N/mm", at_least=0.0)]
PositiveLineForce = Annotated[float, Quantity("a force per length", "N/mm", above=0.0)]
Speed = Annotated[float, Quantity("a speed", "mm/s", above=0.0)]
Acceleration = Annotated[float, Quantity("an acceleration", "mm/s^2")]
Viscosity = Annotated[float, Quantity("a viscosity", "MPa*s", above=0.0)]
PositiveForce = Annotated[float, Quantity("a force", "N", above=0.0)]
Stress = Annotated[float, Quantity("a stress", "MPa")]
PositiveStress = Annotated[float, Quantity("a stress", "MPa", above=0.0)]
Density = Annotated[float, Quantity("a density", "tonne/mm^3", above=0.0)]
Number = Annotated[float, Quantity("a number")]
PositiveNumber = Annotated[float, Quantity("a number", above=0.0)]
Coefficient = Annotated[float, Quantity("a number", at_least=0.0)]
Direction = Annotated[tuple[float, float, float], BeforeValidator(_check_vector)]
Name = Annotated[str, BeforeValidator(_check_name)]
Count = Annotated[int, BeforeValidator(_check_count)]

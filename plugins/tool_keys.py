"""Keys of friction, springs and drawbeads."""

from typing import Annotated

from pydantic import BeforeValidator, Field

from .key_tables import Table, one_of
from .quantities import (
    Coefficient,
    Direction,
    Length,
    LineForce,
    Name,
    PositiveLength,
    PositiveLineForce,
    PositiveNumber,
    PositiveStress,
    Preload,
    Speed,
    Viscosity,
    shown,
    wrong,
)

Point = tuple[Length, Length, Length]


def face(value):
    """A face by number, name or colour."""
    if isinstance(value, bool) or not isinstance(value, (int, str)) or value == "":
        raise wrong(shown(value), 'the number, name or colour of a face, such as 12, "RADIUS" or "#ff0000"')
    return value


Face = Annotated[int | str, BeforeValidator(face)]


class CoulombKeys(Table):
    mu: Coefficient = Field(description="a coefficient of friction, such as 0.12")


class PressureKeys(Table):
    """mu (p / pressure)^(exponent - 1)"""

    mu: Coefficient = Field(description="the coefficient of friction at the reference pressure")
    pressure: PositiveStress = Field(description="the reference pressure in MPa, such as 10")
    exponent: PositiveNumber = Field(description="the exponent of the traction, such as 0.9; 1 is Coulomb's law")


class VelocityKeys(Table):
    """From mu at rest to fast, as exp(-v / velocity)."""

    mu: Coefficient = Field(description="the coefficient of friction at rest")
    fast: Coefficient = Field(description="the coefficient of friction at high speed")
    velocity: Speed = Field(description='the velocity at which it fades, such as "40 mm/s"')


class StribeckKeys(Table):
    """From boundary to hydrodynamic by L = viscosity v / (p roughness)."""

    boundary: Coefficient = Field(description="the coefficient of friction of boundary lubrication")
    hydrodynamic: Coefficient = Field(description="the coefficient of friction of hydrodynamic lubrication")
    L_boundary: PositiveNumber = Field(description="the lubrication number where boundary lubrication ends")
    L_hydrodynamic: PositiveNumber = Field(description="the lubrication number where the hydrodynamic regime begins")
    viscosity: Viscosity = Field(description='the viscosity of the lubricant in MPa s, such as "0.5 Pa*s"')
    roughness: PositiveLength = Field(description='the roughness Ra in mm, such as "1.2 um"')


class Friction(Table):
    """One friction law."""

    coulomb: CoulombKeys | None = None
    pressure: PressureKeys | None = None
    velocity: VelocityKeys | None = None
    stribeck: StribeckKeys | None = None

    def build(self):
        """The law as the solver takes it, None for no friction. Raises solver.SceneError."""
        import solver

        if self.coulomb:
            return solver.Coulomb(self.coulomb.mu) if self.coulomb.mu else None
        if self.pressure:
            return solver.CoulombPressure(**self.pressure.model_dump())
        if self.velocity:
            return solver.CoulombVelocity(**self.velocity.model_dump())
        assert self.stribeck is not None  # _friction saw to it
        return solver.Stribeck(**self.stribeck.model_dump())


LAWS = ("coulomb", "pressure", "velocity", "stribeck")


def _friction(value):
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        if not 0.0 <= value < float("inf"):
            raise wrong(shown(value), "a number of at least 0")
        return {"coulomb": {"mu": value}}
    if isinstance(value, Friction):
        return value
    if not isinstance(value, dict):
        raise wrong(shown(value), "a number of at least 0, or {pressure = {mu = 0.12, pressure = 10, exponent = 0.9}}")
    return one_of(value, LAWS, "a number of at least 0, or a friction law")


class _NumberToo:
    """In the JSON schema a plain coefficient stands beside the table."""

    def __get_pydantic_json_schema__(self, schema, handler):
        return {"anyOf": [{"type": "number", "minimum": 0}, handler(schema)]}


FrictionLaw = Annotated[Friction, BeforeValidator(_friction), _NumberToo()]


class FaceFriction(Table):
    """Friction on some faces of a tool."""

    faces: list[Face] = Field(description='a list of faces by number, name or colour, such as ["RADIUS"]')
    friction: FrictionLaw = Field(description="a coefficient of friction or a law")


class SpringKeys(Table):
    """A spring that presses a tool."""

    stiffness: PositiveLineForce = Field(description='its stiffness in N/mm, such as "300 N/mm"')
    preload: Preload = 0.0


def _places(value):
    """One point or several."""
    if isinstance(value, (list, tuple)) and value and not isinstance(value[0], (list, tuple)):
        return [value]
    return value


Places = Annotated[list[Point], BeforeValidator(_places)]


class BeadShape(Table):
    """A round bead in a groove; restraint and uplift follow from it, the sheet and the friction."""

    radius: PositiveLength = Field(description="the bead's radius in mm")
    shoulder: PositiveLength = Field(description="the radius of the groove's shoulders in mm")
    width: PositiveLength = Field(description="the width of the groove between its walls in mm")
    depth: PositiveLength = Field(description="how far the bead reaches below the plane it leaves, in mm")
    friction: Coefficient = Field(description="the coefficient of friction in the bead")


class Drawbead(Table):
    """A bead along edges of a part, or along a curve. holder : the tool its uplift pushes back"""

    part: Name | None = None
    edges: list[int] | None = None
    through: Places | None = None
    chord: PositiveLength = 0.05
    curve: list[Point] | None = None
    restraint: LineForce | None = None
    uplift: LineForce | None = None
    shape: BeadShape | None = None
    holder: Name | None = None
    axis: Direction = (0.0, 0.0, 1.0)


def bead_disagreements(place, bead, tools):
    """What is right key by key and wrong together, as (key, found and expected)."""
    ways = [key for key in ("edges", "through", "curve") if getattr(bead, key) is not None]
    if len(ways) != 1:
        yield place, f"found {' and '.join(ways) or 'no curve'}, expected one of edges, through, curve"
    elif (bead.part is None) != (bead.curve is not None):
        found = "found beside curve, expected it beside edges or through" if bead.part else "missing, expected the part"
        yield f"{place}.part", f"{found} whose edges the bead follows" if not bead.part else found
    if (bead.restraint is None) == (bead.shape is None):
        found = "found restraint and shape" if bead.shape else "missing"
        yield f"{place}.restraint", f'{found}, expected a force per length such as "80 N/mm", or shape in its place'
    elif bead.shape is not None and bead.uplift is not None:
        yield f"{place}.uplift", "found beside shape, expected it beside restraint: the shape tells its own"
    if bead.holder is not None and bead.holder not in tools:
        yield f"{place}.holder", f"unknown tool '{bead.holder}', expected one of {', '.join(tools) or 'none here'}"

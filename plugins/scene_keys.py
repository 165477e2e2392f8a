"""Every key a scene file may hold, table by table. Descriptions say what is expected where one is missing."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, create_model

from solver.explicit.method import Explicit, Kinematic, Penalty, Touch
from solver.implicit.method import Implicit

from .key_tables import Table, one_of
from .material_keys import FormingLimit, MaterialOrSheet
from .quantities import (
    Acceleration,
    Coefficient,
    Count,
    Direction,
    Length,
    Name,
    Number,
    PositiveForce,
    PositiveLength,
    Quantity,
    Speed,
    Stress,
    shown,
    wrong,
)
from .tool_keys import Drawbead, Face, FaceFriction, FrictionLaw, Places, SpringKeys

# Blank


class Outline(Table):
    """A flat blank that is not in the CAD file. z : mm, its mid-surface."""

    rectangle: tuple[PositiveLength, PositiveLength] | None = None
    disc: PositiveLength | None = None  # radius
    polygon: list[tuple[Length, Length]] | None = None
    center: tuple[Length, Length] = (0.0, 0.0)
    z: Length = 0.0


def _one_outline(value):
    shape = (
        {key: kept for key, kept in value.items() if key not in ("center", "z")} if isinstance(value, dict) else value
    )
    one_of(shape, ("rectangle", "disc", "polygon"), "a shape such as {rectangle = [150, 150]}")
    return value


def _axes(value):
    if not isinstance(value, str) or not value or set(value) - set("xyz"):
        raise wrong(shown(value), 'the axes held, some of the letters xyz, such as "xyz"')
    return value


def _layers(value):
    if isinstance(value, bool) or not isinstance(value, int) or not 2 <= value <= 51:
        raise wrong(shown(value), "a number of layers from 2 to 51, such as 7")
    return value


def _waves(value):
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise wrong(shown(value), "a whole number of waves round the blank's edge, such as 12")
    return value


Layers = Annotated[int, BeforeValidator(_layers)]


class Blank(Table):
    part: Name | None = None
    outline: Annotated[Outline, BeforeValidator(_one_outline)] | None = None
    size: PositiveLength = Field(description="the length of a triangle's side in mm, such as 2.5")
    arrangement: Literal["structured", "equilateral", "unstructured"] = "structured"
    symmetry: list[Literal["x", "y"]] = []
    thickness: PositiveLength | None = None
    flatness: Length = 0.0
    edge_waves: Annotated[int, BeforeValidator(_waves)] | None = None
    element: Literal["shell", "membrane"] = "shell"
    layers: Layers | None = None
    rolling: Direction = (1.0, 0.0, 0.0)
    fixed: dict[str, Annotated[str, BeforeValidator(_axes)]] = {}
    clamped: list[Name] = []
    draw_in: dict[str, Direction] = {}


# Tools and stages

Travel = Annotated[float, Quantity("a travel", "mm")]
DUTIES = ("travel", "to", "force", "gap", "spring")
BORNE = ("stop", "rides_on", "tilts", "at")  # what only a tool borne by a force or spring has


SURFACE_KEYS = ("part", "mesh", "surface", "chord", "crease", "faces", "offset", "flip")  # what a stage cannot change


class Tool(Table):
    """A tool, or what a stage changes of it.

    part : its name in the CAD file, by default the table's; mesh : a mesh file (STL, OBJ, ..) in its place
    surface : exact faces, or facets: Nagata patches, flat ones with averaged nodal normals, with their own
    chord : mm, largest distance of the facets from the faces they stand for
    crease : degrees; facets of a mesh file that meet at a larger angle keep the edge between them
    faces : only these faces of the part, by number, name or colour; offset : mm, clearance, out of the material;
    flip : the material is on the other side
    friction : a coefficient or a law, and others on some faces
    to, spring, stop, rides_on, tilts, at : see solver.Tool
    """

    part: Name | None = None
    mesh: Name | None = None
    surface: Literal["exact", "nagata", "nodal", "element"] | None = None
    chord: PositiveLength | None = None
    crease: Number | None = None
    faces: list[Face] | None = None
    offset: Length | None = None
    flip: bool | None = None
    friction: FrictionLaw | None = None
    friction_faces: list[FaceFriction] | None = None
    axis: Direction | None = None
    travel: Travel | None = None
    to: Length | None = None
    force: PositiveForce | None = None
    gap: PositiveLength | None = None
    spring: SpringKeys | None = None
    stop: PositiveLength | None = None
    rides_on: Name | None = None
    tilts: bool | None = None
    at: Places | None = None

    def given(self):
        """{key: value} of the keys that say something."""
        return {key: value for key in Tool.model_fields if (value := getattr(self, key)) is not None}

    def changed_by(self, stage):
        """This tool with what a stage says about it; a new duty takes the place of the old one."""
        new, old = stage.given(), self.given()
        if any(duty in new for duty in DUTIES):
            kept = () if any(new.get(duty) is not None for duty in ("force", "spring")) else BORNE
            old = {key: value for key, value in old.items() if key not in (*DUTIES, *kept)}
        return Tool.model_construct(**{**dict.fromkeys(Tool.model_fields), **old, **new})


def _movement(value):
    if not isinstance(value, (list, tuple)) or len(value) != 3:
        raise wrong(shown(value), 'three lengths in mm, "free" for a free axis, such as [1.5, 0, "free"]')
    return value


Force = Annotated[float, Quantity("a force", "N")]
LineLoad = Annotated[float, Quantity("a line load", "N/mm")]


def _length_or_free(value):
    return None if value == "free" else value


Movement = Annotated[tuple[Annotated[Length | None, BeforeValidator(_length_or_free)], ...], BeforeValidator(_movement)]


class Stage(Table):
    """One operation; without tools of its own, every tool takes part. tools = {} and nothing else is springback.

    drawbeads : names of those that take part, by default all in a stage with tools
    """

    name: Name | None = None
    tools: dict[str, Tool] | None = None
    pressure: Stress = 0.0
    forces: dict[str, tuple[Force, Force, Force]] = {}
    line_loads: dict[str, tuple[LineLoad, LineLoad, LineLoad]] = {}
    moments: dict[str, Number] = {}
    moved: dict[str, Movement] = {}
    speed: Speed | None = None
    gravity: tuple[Acceleration, Acceleration, Acceleration] | None = None
    pilots: list[Name] = []
    drawbeads: list[Name] | None = None


# How it is run, what comes out, what it is compared with


def _options(description):
    """Table with the options of a frozen dataclass of numbers, each with its default."""
    made = {}
    for item in fields(description):
        default = getattr(description, item.name)
        if is_dataclass(default):
            made[item.name] = (_options(default), _options(default)())
        else:
            kind = {float: Coefficient, int: Count}.get(type(default), type(default))
            made[item.name] = (kind, default)
    return create_model(type(description).__name__ + "Options", __base__=Table, **made)


ImplicitOptions = _options(Implicit())
CONTACTS = {"kinematic": Kinematic, "touch": Touch, "penalty": Penalty}
NUMBERS = [item.name for item in fields(Explicit) if isinstance(getattr(Explicit(), item.name), float)]


def _explicit_options():
    """Table with the numbers of an Explicit, and its contact by name."""
    made: dict = {name: (Coefficient, getattr(Explicit(), name)) for name in NUMBERS}
    made["contact"] = (Literal["kinematic", "touch", "penalty"], "kinematic")
    made["relax"] = (bool, Explicit().relax)
    return create_model("ExplicitOptions", __base__=Table, **made)


ExplicitOptions = _explicit_options()


def as_implicit(options):
    """solver.Implicit with the options of a scene file."""
    defaults = Implicit()
    values = {}
    for item in fields(defaults):
        value = getattr(options, item.name)
        default = getattr(defaults, item.name)
        values[item.name] = type(default)(**value.model_dump()) if is_dataclass(default) else value
    return Implicit(**values)


def as_explicit(options, implicit):
    """solver.Explicit with the options of a scene file; its implicit stages have theirs. Raises solver.SceneError."""
    numbers = {name: getattr(options, name) for name in NUMBERS}
    contact = CONTACTS[options.contact]()
    return Explicit(contact=contact, relax=options.relax, springback=as_implicit(implicit), **numbers)


class Output(Table):
    frames: Count = 40


class Measured(Table):
    """One measured value. quantity : a column of history.csv; scatter : its uncertainty, both ways."""

    quantity: Name = Field(description="a column of history.csv, such as draw_in_DX")
    stroke: Length = Field(description="the stroke in mm it was measured at")
    measured: Number = Field(description="the measured value in mm, N or 1")
    scatter: Coefficient | None = None


class Compare(Table):
    source: Name = Field(description="where the measured values come from")
    rows: list[Measured] = Field(description='rows such as {quantity = "draw_in_DX", stroke = 40, measured = 28.5}')


class SceneKeys(Table):
    """A whole scene file."""

    name: Name = "forming"
    cad: Name | None = None
    blank: Blank = Field(description="a table [blank] with part or outline, and size")
    material: MaterialOrSheet = Field(description="a table [material] with young, poisson, locus and hardening")
    forming_limit: FormingLimit | None = None
    tools: dict[str, Tool] = {}
    drawbeads: dict[str, Drawbead] = {}
    stages: list[Stage] = []
    method: Literal["implicit", "explicit"] = "implicit"
    explicit: ExplicitOptions = ExplicitOptions()  # pyright: ignore[reportInvalidTypeForm]
    implicit: ImplicitOptions = ImplicitOptions()  # pyright: ignore[reportInvalidTypeForm]
    output: Output = Output()
    compare: Compare | None = None


def history_columns(keys: SceneKeys) -> Mapping[str, str]:
    """Columns of history.csv this scene has that a measured value can be compared with, and their units."""
    columns = {f"draw_in_{name}": "mm" for name in keys.blank.draw_in}
    for tool in keys.tools:
        columns |= {f"force_{tool}": "N", f"travel_{tool}": "mm"}
    for bead in keys.drawbeads:
        columns |= {f"bead_{bead}": "N", f"uplift_{bead}": "N"}
    columns |= {"thickness_min": "mm", "thickness_max": "mm", "thinning_max": ""}
    return columns | {"fld_margin_min": ""} if keys.forming_limit else columns

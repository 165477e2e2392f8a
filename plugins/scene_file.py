"""Scene files: TOML in, a checked `solver.Scene` out.

Lengths are in mm, forces in N, stresses in MPa unless a value is text with a unit: "0.81 mm", "19.6 kN".
Paths are relative to the scene file. The keys are those of `scene_keys.py`.
"""

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import get_args

from pydantic import BaseModel, ValidationError

from .quantities import shown
from .scene_keys import BORNE, DUTIES, SURFACE_KEYS, SceneKeys, as_explicit, as_implicit, history_columns
from .tool_keys import bead_disagreements


class SceneFileError(ValueError):
    """A scene file cannot be used. A line per mistake: file, key, what was found, what was expected."""


def load_scene(path):
    """The scene a file describes, its STEP file read and its blank meshed. Returns solver.Scene.

    Raises SceneFileError with a line for each mistake.
    """
    return SceneFile.read(path).build()


@dataclass(frozen=True)
class SceneFile:
    """A scene file whose keys are checked; nothing of CAD is read yet.

    path : the file; keys : its values, in mm, N, MPa
    """

    path: Path
    keys: SceneKeys

    @classmethod
    def read(cls, path):
        """Raises SceneFileError with a line for each mistake."""
        path = Path(path)
        return cls(path, check(parse(path), path))

    @property
    def cad(self):
        """The CAD file, or None."""
        return self.path.parent / self.keys.cad if self.keys.cad else None

    @property
    def method(self):
        """solver.Implicit or solver.Explicit with the file's options. Raises SceneFileError."""
        from solver import SceneError

        if self.keys.method == "implicit":
            return as_implicit(self.keys.implicit)
        try:
            return as_explicit(self.keys.explicit, self.keys.implicit)
        except SceneError as error:
            raise SceneFileError(f"{self.path}: {error}") from error

    @property
    def columns(self):
        """{column of history.csv a measured value can be compared with: its unit}."""
        return history_columns(self.keys)

    def build(self):
        """Reads the STEP file, meshes the blank. Returns solver.Scene; raises SceneFileError."""
        from cadlink import CadError
        from solver import SceneError

        from .scene_build import BuildError, build

        try:
            return build(self.keys, self.cad, self.path.parent)
        except BuildError as error:
            raise SceneFileError(f"{self.path}: {error}") from error
        except (CadError, SceneError) as error:
            raise SceneFileError(f"{self.path}: {error}") from error


def parse(path):
    """The file's tables as a dict. Raises SceneFileError: no such file, no text, no TOML in which line."""
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise SceneFileError(f"{path}: no such file, expected a scene file (TOML)") from None
    except OSError as error:
        raise SceneFileError(f"{path}: {error.strerror}, expected a scene file (TOML)") from None
    except UnicodeDecodeError:
        raise SceneFileError(f"{path}: not a text file, expected a scene file (TOML)") from None
    except tomllib.TOMLDecodeError as error:
        text, _, place = str(error).removesuffix(")").partition(" (at ")
        raise SceneFileError(f"{path}: {place + ': ' if place else ''}{text}, expected TOML") from None


def check(data, path):
    """The values of a scene file. data : its tables. Raises SceneFileError with a line for each mistake."""
    try:
        keys = SceneKeys.model_validate(data)
    except ValidationError as error:
        mistakes = [explain(mistake) for mistake in without_echoes(error.errors(include_url=False))]
    else:
        mistakes = [f"{key}: {text}" for key, text in disagreements(keys)]
        if not mistakes:
            return keys
    raise SceneFileError("\n".join(f"{path}: {mistake}" for mistake in mistakes))


def without_echoes(mistakes):
    """A misspelt key that must be there counts once: as unknown, not as missing too."""
    meant = set()
    for mistake in mistakes:
        if mistake["type"] == "extra_forbidden":
            *table, name = mistake["loc"]
            near = get_close_matches(str(name), table_at(SceneKeys, table).model_fields, 1, 0.6)
            meant |= {(*table, key) for key in near}
    return [m for m in mistakes if not (m["type"] == "missing" and m["loc"] in meant)]


def explain(mistake):
    """One mistake of pydantic's as `key: what was found, what was expected`."""
    place = mistake["loc"]
    match mistake["type"]:
        case "extra_forbidden":
            known = table_at(SceneKeys, place[:-1]).model_fields
            text = f"unknown key; {instead(str(place[-1]), known)}"
        case "missing" if isinstance(place[-1], int):
            return f"{dotted(place[:-1])}: found {shown(mistake['input'])}, expected {place[-1] + 1} values or more"
        case "missing":
            field = table_at(SceneKeys, place[:-1]).model_fields[place[-1]]
            text = f"missing, expected {field.description}"
        case "scene":
            text = mistake["msg"]
        case "model_type" | "dict_type":
            text = f"found {shown(mistake['input'])}, expected a table"
        case "list_type" | "tuple_type":
            text = f"found {shown(mistake['input'])}, expected a list"
        case "literal_error":
            text = f"found {shown(mistake['input'])}, expected {mistake['ctx']['expected']}"
        case _:
            text = f"found {shown(mistake['input'])}, expected: {mistake['msg']}"
    return f"{dotted(place)}: {text}" if place else text


def dotted(place):
    """("stages", 0, "tools") as stages[0].tools."""
    text = ""
    for key in place:
        text += f"[{key}]" if isinstance(key, int) else f".{key}"
    return text.removeprefix(".")


def instead(name, known):
    """What to write in place of an unknown name: the nearest known one, or all of them."""
    known = list(known)
    near = get_close_matches(name, known, 1, 0.6) or [k for k in known if k.lower() == name.lower()]
    return f"did you mean '{near[0]}'?" if near else f"expected {', '.join(known) or 'none here'}"


def table_at(table, place):
    """The class of the table a path of keys leads to; names the user chose and list indices lead nowhere."""
    for key in place:
        field = table.model_fields.get(key) if isinstance(key, str) else None
        table = next(tables_in(field.annotation), table) if field else table
    return table


def tables_in(annotation) -> Iterator[type[BaseModel]]:
    """Table classes named in a type such as dict[str, Tool] | None."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from tables_in(part)


def disagreements(keys) -> Iterator[tuple[str, str]]:
    """What is right key by key and wrong together, as (key, found and expected)."""
    blank = keys.blank
    if (blank.part is None) == (blank.outline is None):
        found = "part and outline" if blank.part else "neither part nor outline"
        yield "blank", f"found {found}, expected one of them"
    elif blank.outline is not None and blank.thickness is None:
        yield "blank.thickness", "missing, expected a length in mm: an outline has none"
    if len(set(blank.symmetry)) < len(blank.symmetry):
        yield "blank.symmetry", f"found {shown(blank.symmetry)}, expected each axis once"
    follows = any(bead.part for bead in keys.drawbeads.values())
    if keys.cad is None and (blank.part or follows or any(tool.mesh is None for tool in keys.tools.values())):
        yield "cad", "missing, expected the STEP file with the parts, relative to the scene file"
    if not keys.tools and not any(s.pressure or s.forces or s.line_loads or s.moments or s.moved for s in keys.stages):
        yield "tools", "missing, expected a table such as [tools.PUNCH]: nothing forms the blank"

    for name, tool in keys.tools.items():
        yield from _duties(f"tools.{name}", tool)
        yield from _surface(f"tools.{name}", tool)
    for i, stage in enumerate(keys.stages):
        for name, tool in (stage.tools or {}).items():
            place = f"stages[{i}].tools.{name}"
            if name not in keys.tools:
                yield place, f"unknown tool; {instead(name, keys.tools)}"
            for key in SURFACE_KEYS:
                if getattr(tool, key) is not None:
                    yield f"{place}.{key}", "found in a stage, expected in [tools]: a tool keeps its surface"
            yield from _duties(place, tool)
        for name in stage.drawbeads or ():
            if name not in keys.drawbeads:
                yield f"stages[{i}].drawbeads", f"unknown drawbead '{name}'; {instead(name, keys.drawbeads)}"
    for name, tool in keys.tools.items():
        changes = [stage.tools[name] for stage in keys.stages if stage.tools and name in stage.tools]
        yield from _borne(f"tools.{name}", tool, changes)
    for name, bead in keys.drawbeads.items():
        yield from bead_disagreements(f"drawbeads.{name}", bead, keys.tools)

    table = keys.material.hardening.table
    if table and len(table.strain) != len(table.stress):
        found = f"{len(table.strain)} strains and {len(table.stress)} stresses"
        yield "material.hardening.table", f"found {found}, expected as many of each"

    columns = history_columns(keys)
    for i, row in enumerate(keys.compare.rows if keys.compare else ()):
        if row.quantity not in columns:
            yield (
                f"compare.rows[{i}].quantity",
                f"unknown column '{row.quantity}'; {instead(row.quantity, columns)}",
            )


def _surface(place, tool):
    if tool.mesh is not None:
        for key in ("part", "chord", "faces"):
            if getattr(tool, key) is not None:
                yield f"{place}.{key}", f"found beside mesh, expected one of them: a mesh file has no {key}"
        if tool.surface == "exact":
            yield f"{place}.surface", 'found "exact", expected "nagata", "nodal" or "element" for a mesh file'
        return
    if tool.crease is not None:
        yield f"{place}.crease", "found without mesh, expected it beside a mesh file: a part knows its own edges"
    faceted = tool.surface not in (None, "exact")
    if faceted and tool.chord is None:
        yield f"{place}.chord", "missing, expected a length in mm such as 0.1: how far facets may be from the faces"
    if tool.chord is not None and not faceted:
        yield f"{place}.chord", 'found without facets, expected surface = "nagata", "nodal" or "element" beside it'


def _borne(place, tool, changes):
    if not any(one.force is not None or one.spring is not None for one in (tool, *changes)):
        for key in BORNE:
            if getattr(tool, key) is not None:
                yield f"{place}.{key}", "found beside no force or spring, expected one of them"
    if tool.mesh is not None and tool.friction_faces:
        yield f"{place}.friction_faces", "found beside mesh, expected a part: a mesh file has no faces"


def _duties(place, tool):
    found = [duty for duty in DUTIES if getattr(tool, duty) is not None]
    if len(found) > 1:
        yield place, f"found {' and '.join(found)}, expected at most one of {', '.join(DUTIES)}"
    if tool.travel == 0.0:
        yield f"{place}.travel", "found 0, expected a length in mm other than 0"

"""From checked keys to a `solver.Scene`: reads the STEP file, meshes the blank, makes the tools."""

from contextlib import contextmanager
from functools import cached_property
from pathlib import Path

import solver
from cadlink import CadError


class BuildError(ValueError):
    """What a scene describes cannot be made. One line: key, what was found, what was expected."""


@contextmanager
def about(key):
    """Puts the key in front of what is wrong with its value."""
    try:
        yield
    except (CadError, solver.SceneError) as error:
        raise BuildError(f"{key}: {error}") from error


def build(keys, cad, folder="."):
    """The scene. Raises BuildError.

    keys : scene_keys.SceneKeys; cad : path of the STEP file or None; folder : where mesh files are looked for
    """
    parts = Parts(cad)
    blank = build_blank(keys, parts)
    surfaces = {}
    for name, tool in keys.tools.items():
        with about(f"tools.{name}"):
            surfaces[name] = build_surface(name, tool, parts, Path(folder))
    beads = {}
    for name, bead in keys.drawbeads.items():
        with about(f"drawbeads.{name}"):
            beads[name] = build_drawbead(name, bead, parts, blank)
    with about("stages"):
        return solver.Scene(blank, build_stages(keys, surfaces, beads, parts), name=keys.name)


def build_surface(name, tool, parts, folder):
    """What contact meets: exact faces, or facets of a part or of a mesh file."""
    offset, flip = tool.offset or 0.0, bool(tool.flip)
    if tool.mesh is None and tool.surface in (None, "exact"):
        return parts[tool.part or name].surface(tool.faces, offset=offset, flip=flip)
    from cadlink.shifted import shifted

    if tool.mesh is not None:
        from cadlink import FacetSurface

        surface = FacetSurface.read(folder / tool.mesh, tool.surface or "nodal", crease=tool.crease)
    else:
        surface = parts[tool.part or name].facets(tool.chord, normals=tool.surface, faces=tool.faces)
    return shifted(surface, offset, flip)


class Parts:
    """The parts of the CAD file, read when the first is asked for."""

    def __init__(self, path):
        self.path = path

    @cached_property
    def assembly(self):
        from cadlink import read_step

        with about("cad"):
            return read_step(self.path)

    def __getitem__(self, name):
        return self.assembly[name]


def build_blank(keys, parts):
    """The meshed sheet with its material."""
    from cadlink import mesh_blank

    described = keys.blank
    with about("blank.part" if described.part else "blank.outline"):
        mesh = mesh_blank(
            parts[described.part] if described.part else outline_of(described.outline),
            size=described.size,
            arrangement=described.arrangement,
            symmetry=tuple(described.symmetry),
            z=described.outline.z if described.outline else None,
            flatness=described.flatness,
            edge_waves=described.edge_waves,
        )
    thickness = described.thickness or mesh.thickness
    if thickness is None:
        raise BuildError(f"blank.thickness: missing, expected a length in mm: part {described.part!r} is no plate")
    with about("material"):
        material = keys.material.build()
    with about("forming_limit"):
        limit = keys.forming_limit.build(material, thickness) if keys.forming_limit else None
    if described.element == "membrane" and described.layers:
        raise BuildError(f"blank.layers: found {described.layers}, expected none: a membrane has no layers")
    with about("blank"):
        return solver.Blank(
            mesh,
            thickness=thickness,
            material=material,
            element=solver.Membrane() if described.element == "membrane" else solver.Shell(described.layers or 7),
            rolling=described.rolling,
            fixed=described.fixed,
            clamped=tuple(described.clamped),
            draw_in=described.draw_in,
            forming_limit=limit,
        )


def outline_of(shape):
    """The outline a scene describes in words."""
    from cadlink.outline import Disc, Polygon, Rectangle

    if shape.rectangle:
        return Rectangle(*shape.rectangle, center=shape.center)
    if shape.disc:
        return Disc(shape.disc, center=shape.center)
    x, y = shape.center
    return Polygon([(x + px, y + py) for px, py in shape.polygon])


def build_drawbead(name, bead, parts, blank):
    """solver.Drawbead along edges of a part or a curve; its forces as given, or of its shape."""
    curve = bead.curve
    if curve is None:
        curve = parts[bead.part].edge(bead.edges, through=bead.through, chord=bead.chord)
    restraint, uplift = bead.restraint, bead.uplift or 0.0
    if bead.shape is not None:
        shape = bead.shape.model_dump()
        mu = shape.pop("friction")
        restraint, uplift = solver.RoundBead(**shape).forces(blank.material, blank.thickness, mu)
    return solver.Drawbead(name, curve, restraint, uplift, bead.holder, bead.axis)


def build_stages(keys, surfaces, beads, parts):
    """Stages as described; one with every tool and drawbead where none is."""
    if not keys.stages:
        tools = [build_tool(name, tool, surfaces[name], parts) for name, tool in keys.tools.items()]
        return (solver.Stage(tools, drawbeads=tuple(beads.values())),)
    stages = []
    for number, stage in enumerate(keys.stages, start=1):
        changed = keys.tools
        if stage.tools is not None:
            changed = {name: keys.tools[name].changed_by(change) for name, change in stage.tools.items()}
        tools = [build_tool(name, tool, surfaces[name], parts) for name, tool in changed.items()]
        name = stage.name or f"stage {number}"
        loads = {"pressure": stage.pressure, "forces": stage.forces, "line_loads": stage.line_loads}
        loads |= {"moments": stage.moments, "moved": stage.moved}
        loads |= {"speed": stage.speed, "gravity": stage.gravity, "pilots": tuple(stage.pilots)}
        chosen = stage.drawbeads if stage.drawbeads is not None else beads if tools else ()
        stages.append(solver.Stage(tools, name=name, drawbeads=tuple(beads[bead] for bead in chosen), **loads))
    return tuple(stages)


def build_friction(name, tool, parts):
    """Friction of a tool, by face where some have their own."""
    friction = tool.friction.build() if tool.friction else None
    if not tool.friction_faces:
        return friction
    part, by_face = parts[tool.part or name], {}
    for some in tool.friction_faces:
        law = some.friction.build()
        by_face |= {int(face): law for face in part.pick(some.faces)}
    return solver.ByFace(friction, by_face)


def build_tool(name, tool, surface, parts):
    """solver.Tool of one stage."""
    at = tool.at[0] if tool.at and len(tool.at) == 1 else tool.at
    return solver.Tool(
        name,
        surface,
        friction=build_friction(name, tool, parts),
        axis=tool.axis or (0.0, 0.0, 1.0),
        travel=tool.travel,
        to=tool.to,
        force=tool.force,
        gap=tool.gap,
        spring=solver.Spring(**tool.spring.model_dump()) if tool.spring else None,
        stop=tool.stop,
        rides_on=tool.rides_on,
        tilts=bool(tool.tilts),
        at=at,
    )

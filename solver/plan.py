"""In words: what will run, what is skipped, and why."""

from dataclasses import dataclass

import numpy as np

from .contact.feet import feet_per_node, tight_radius
from .elements.formulation import Shell
from .errors import SceneError


@dataclass(frozen=True)
class Plan:
    """runs, skips : tuples of (what, why)"""

    runs: tuple
    skips: tuple

    def __str__(self):
        lines = ["Runs:"] + [f"  {what}: {why}" for what, why in self.runs]
        if self.skips:
            lines += ["Skipped:"] + [f"  {what}: {why}" for what, why in self.skips]
        return "\n".join(lines)


def plan(scene, method=None):
    """Plan of a scene, and of the method that runs it. Raises SceneError where the method cannot run it."""
    blank, material = scene.blank, scene.blank.material
    n_nodes, n_tris = len(blank.mesh.points), len(blank.mesh.cells)
    kind = "shell" if isinstance(blank.element, Shell) else "membrane"
    runs = [
        (
            "sheet",
            f"{n_tris} {kind} triangles, {n_nodes} nodes, about {blank.mesh_size:.3g} mm, t = {blank.thickness:g} mm",
        ),
        (
            "material",
            material.describe(),
        ),
    ]
    if method is not None:
        runs.insert(0, ("method", method.describe()))
    skips = []
    if isinstance(blank.element, Shell):
        runs.append(("bending", f"{blank.element.layers} layers through the thickness"))
        skips.append(("torsion stabilisation", "a shell has its own stiffness out of its plane"))
    else:
        runs.append(("torsion stabilisation", "a membrane has no stiffness out of its plane"))
        skips.append(("bending, layers", "a membrane carries none; springback and compression need a shell"))
    if not material.n_history:
        skips.append(("backstress", "isotropic hardening"))
    if blank.symmetry_planes:
        planes = ", ".join(blank.symmetry_planes)
        runs.append(
            (
                "symmetry",
                f"plane(s) normal to {planes}: 1/{round(1 / blank.share)} of the part; forces are those of the whole",
            )
        )
    else:
        skips.append(("symmetry planes", "the mesh has no symmetry_x, symmetry_y or symmetry_z group"))
    for stage in scene.stages:
        runs += [(f"stage {stage.name!r}, tool {tool.name}", _duty(tool)) for tool in stage.tools]
        if stage.pressure:
            runs.append((f"stage {stage.name!r}", f"pressure up to {stage.pressure:g} MPa, following the sheet"))
        runs += [(f"stage {stage.name!r}, group {g}", f"moved by {tuple(m)} mm") for g, m in stage.moved.items()]
        runs += [
            (f"stage {stage.name!r}, pilots", f"group {g} keeps its place across the tools' axis") for g in stage.pilots
        ]
        for bead in stage.drawbeads:
            lifted = f", uplift {bead.uplift:g} N/mm" + (f" on {bead.holder}" if bead.holder else "")
            what = f"{bead.length:.4g} mm, restraint {bead.restraint:g} N/mm{lifted if bead.uplift else ''}"
            runs.append((f"stage {stage.name!r}, drawbead {bead.name}", what))
        if stage.gravity is not None:
            runs.append((f"stage {stage.name!r}, gravity", f"{tuple(stage.gravity)} mm/s^2"))
        for group, force in stage.forces.items():
            runs.append((f"stage {stage.name!r}, group {group}", f"forces up to {tuple(force)} N"))
        for group, force in stage.line_loads.items():
            runs.append((f"stage {stage.name!r}, group {group}", f"line load up to {tuple(force)} N/mm"))
        for group, moment in stage.moments.items():
            runs.append((f"stage {stage.name!r}, group {group}", f"edge moment up to {moment:g} N per mm"))
        if stage.is_springback:
            runs.append((f"stage {stage.name!r}", "springback: what was in balance before is relieved"))
        if not stage.tools:
            skips.append((f"stage {stage.name!r}, contact", "no tools"))
        if not any(tool.gives_way for tool in stage.tools):
            skips.append((f"stage {stage.name!r}, tool force balance", "no tool is borne by a force or spring"))
        for tool in stage.tools:
            if tool.tilts and feet_per_node(tool.surface, blank.thickness) > 1:
                raise SceneError(
                    f"tool {tool.name!r} tilts: found a corner of radius {tool.surface.tightest():.3g} mm, expected "
                    f"above {tight_radius(blank.thickness):.3g} mm, or a guided tool"
                )
        if any(tool.friction is not None and tool.friction.needs_speed for tool in stage.tools) and stage.path > 0.0:
            lasts = f": it lasts {stage.seconds:.3g} s" if np.isfinite(stage.seconds) else ""
            runs.append((f"stage {stage.name!r}, speed", f"{stage.speed:g} mm/s{lasts}"))
        frictionless = [tool.name for tool in stage.tools if tool.mu == 0.0]
        if frictionless:
            skips.append((f"stage {stage.name!r}, friction", f"none given for {', '.join(frictionless)}"))
    for name, tool in scene.tools.items():
        if feet_per_node(tool.surface, blank.thickness) > 1:
            runs.append((f"contact with {name}", "up to three feet per node: it has corners below half the thickness"))
    if not any(feet_per_node(tool.surface, blank.thickness) > 1 for tool in scene.tools.values()):
        skips.append(("further feet of a node", "no tool has a corner below half the thickness"))
    skips.append(("projection of far nodes", "a node is projected only once it can have come near a tool"))
    return Plan(tuple(runs), tuple(skips))


def _duty(tool):
    axis = tuple(float(c) for c in tool.axis)
    friction = f", {tool.friction}" if tool.friction is not None and tool.mu != 0.0 else ""
    if tool.travel is not None:
        return f"travels {tool.travel:g} mm along {axis} from touching the blank{friction}"
    if tool.to is not None:
        return f"travels along {axis} until {tool.to:g} mm from its place in the CAD file{friction}"
    if tool.gives_way:
        if tool.spring is None:
            how = f"presses with {tool.force:g} N"
        else:
            how = f"pressed by a spring of {tool.spring.stiffness:g} N/mm, preload {tool.spring.preload:g} N"
        riding = f", riding on {tool.rides_on}" if tool.rides_on else ""
        stop = f", stop after {tool.stop:g} mm" if tool.stop is not None else ""
        return f"{how}, {'free to tilt' if tool.tilts else 'guided'} along {axis}{riding}{stop}{friction}"
    if tool.gap is not None:
        return f"held at a gap of {tool.gap:g} mm{friction}"
    return f"stands still{friction}"

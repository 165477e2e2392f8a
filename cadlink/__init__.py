"""CAD in, exact geometry out: named parts of a STEP file and closest points on their faces.

Importing this package loads nothing heavy: each public name brings its own module the first
time it is used.
"""

import os
from importlib import import_module

# Idle threads sleep: a spinning one would hold up whoever shares the machine.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

_HOME = {
    "read_step": "cadlink.step",
    "Assembly": "cadlink.step",
    "Part": "cadlink.step",
    "ToolSurface": "cadlink.surface",
    "Projection": "cadlink.projection",
    "FacetSurface": "cadlink.facets",
    "PlaneSurface": "cadlink.primitive_surfaces",
    "CylinderSurface": "cadlink.primitive_surfaces",
    "SphereSurface": "cadlink.primitive_surfaces",
    "ConeSurface": "cadlink.primitive_surfaces",
    "TorusSurface": "cadlink.primitive_surfaces",
    "Profile": "cadlink.profile",
    "section": "cadlink.profile",
    "mesh_blank": "cadlink.blank",
    "Mesh": "cadlink.blank",
    "Rectangle": "cadlink.outline",
    "Disc": "cadlink.outline",
    "Polygon": "cadlink.outline",
    "blank_outline": "cadlink.plate",
    "CadError": "cadlink.errors",
}

__all__ = [
    "Assembly",
    "CadError",
    "ConeSurface",
    "CylinderSurface",
    "Disc",
    "FacetSurface",
    "Mesh",
    "Part",
    "PlaneSurface",
    "Polygon",
    "Profile",
    "Projection",
    "Rectangle",
    "SphereSurface",
    "ToolSurface",
    "TorusSurface",
    "blank_outline",
    "mesh_blank",
    "read_step",
    "section",
]


def __getattr__(name):
    if name not in _HOME:
        raise AttributeError(f"module 'cadlink' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__():
    return sorted(__all__)

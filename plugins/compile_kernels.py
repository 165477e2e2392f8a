"""Compile the kernels a scene needs, so that its first run does not wait: `python -m plugins.compile_kernels SCENE`."""

import sys
from dataclasses import replace
from math import copysign

from .kernel_cache import choose_kernel_cache


def compile_kernels(path):
    """Take the first step of a scene, a hundredth of the thickness, and forget the result. path : scene file (TOML)"""
    from solver import form

    from .scene_file import SceneFile

    scene = SceneFile.read(path).build()
    stage, step = scene.stages[0], 0.01 * scene.blank.thickness
    tools = [replace(tool, travel=copysign(step, tool.travel)) if tool.travel else tool for tool in stage.tools]
    form(replace(scene, stages=[replace(stage, tools=tools)]), frames=1)


def compile_facets():
    """Closest points on facets, which no scene with exact tools asks for: one kernel, whatever the normals."""
    from cadlink import FacetSurface

    corners, cells = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    FacetSurface(corners, cells).project([[1.0, 1.0, 1.0]])


if __name__ == "__main__":
    choose_kernel_cache()
    compile_kernels(sys.argv[1])
    compile_facets()

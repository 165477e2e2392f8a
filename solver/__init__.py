"""Arrays in, formed sheet out. Start reading at `solver/form.py`."""

import os

# Idle threads sleep: a spinning one would hold up whoever shares the machine, and the run itself.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

from .errors import SceneError, StepFailed
from .form import form
from .implicit.method import Implicit, Increments, Newton
from .materials.hardening import HockettSherby, Ludwik, Sum, Swift, Table, Voce
from .materials.material import Material
from .materials.planar_hill import PlanarHill, VonMises
from .results import Frame, Progress, Results
from .scene import Blank, Coulomb, Membrane, Scene, Shell, Stage, Tool

__all__ = [
    "Blank", "Coulomb", "Frame", "HockettSherby", "Implicit", "Increments", "Ludwik", "Material", "Membrane", "Newton",
    "PlanarHill", "Progress", "Results", "Scene", "SceneError", "Shell", "Stage", "StepFailed", "Sum", "Swift", "Table",
    "Tool", "Voce", "VonMises", "form",
]  # fmt: skip

"""Arrays in, formed sheet out. Start reading at `solver/form.py`."""

import os

# Idle threads sleep: a spinning one would hold up whoever shares the machine, and the run itself.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

from .contact.bead_shape import RoundBead
from .contact.drawbead import Drawbead
from .contact.friction import ByFace, Coulomb, CoulombPressure, CoulombVelocity, Stribeck
from .errors import SceneError, StepFailed
from .explicit.method import Explicit, Kinematic, Penalty, Touch
from .form import form
from .implicit.method import Implicit, Increments, Newton
from .materials.chaboche import ArmstrongFrederick, Chaboche
from .materials.forming_limit import KeelerBrazier, LimitCurve, fld_margin
from .materials.hardening import HockettSherby, Ludwik, Sum, Swift, Table, Voce
from .materials.hill90 import Hill90
from .materials.law import Law
from .materials.library import published_sheet
from .materials.marciniak import marciniak_kuczynski
from .materials.material import Material
from .materials.modulus import DecayingModulus
from .materials.quadratic import Hill48, PlanarHill, VonMises
from .materials.rate import CowperSymonds, PowerLawRate
from .materials.two_surface import TwoSurface
from .materials.vegter import Vegter
from .materials.yld2000 import Yld2000
from .materials.yoshida_uemori import YoshidaUemori
from .results import Frame, Progress, Results
from .scene import Blank, Membrane, Scene, Shell, Spring, Stage, Tool

__all__ = [
    "ArmstrongFrederick", "Blank", "ByFace", "Chaboche", "Coulomb", "CoulombPressure", "CoulombVelocity",
    "CowperSymonds", "DecayingModulus", "Drawbead", "Explicit", "Frame", "Hill48", "Hill90", "HockettSherby",
    "Implicit", "Increments", "KeelerBrazier", "Kinematic", "Law", "LimitCurve", "Ludwik", "Material", "Membrane",
    "Newton", "Penalty", "PlanarHill", "PowerLawRate", "Progress", "Results", "RoundBead", "Scene", "SceneError",
    "Shell", "Spring", "Stage", "StepFailed", "Stribeck", "Sum", "Swift", "Table", "Tool", "Touch", "TwoSurface",
    "Vegter", "Voce", "VonMises", "Yld2000", "YoshidaUemori", "fld_margin", "form", "marciniak_kuczynski",
    "published_sheet",
]  # fmt: skip

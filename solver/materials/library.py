"""Published sheets, each with where its numbers come from and how far they can be trusted.

Grades: P read in a published source that is named; C derived by a formula from such numbers; M nn% recalled from the
literature and not verified, with our confidence. Do not rest a result on an M grade before checking the original.
"""

from collections.abc import Callable
from dataclasses import dataclass

from ..errors import SceneError
from .hardening import Swift
from .material import Material
from .quadratic import Hill48, VonMises
from .yld2000 import Yld2000
from .yoshida_uemori import YoshidaUemori


@dataclass(frozen=True)
class Sheet:
    """A published sheet.

    make : makes its Material, under this name
    thickness : mm, of the sheet tested; None where it is not told
    source : where it was published; grade : how its numbers were come by, value by value
    """

    make: Callable[[str], Material]
    thickness: float | None
    source: str
    grade: str


ALUMINIUM = 2.7e-9  # density, tonne/mm^3
SHEETS = {
    "numisheet93-steel": Sheet(
        lambda name: Material(206000.0, 0.3, Hill48(1.79, 1.51, 2.27), Swift(565.32, 0.007117, 0.2589), name),
        0.78,
        "NUMISHEET'93 mild steel: Taylor et al. 1993/1995 and the Abaqus Example Problems Manual, draw bending",
        "thickness, E, nu and r-values P (r confirmed by the printed ratios R22, R33, R12); Swift curve M 90%",
    ),
    "numisheet93-aluminium": Sheet(
        lambda name: Material(
            71000.0, 0.33, Hill48(0.71, 0.58, 0.70), Swift(576.79, 0.01658, 0.3593), name, density=ALUMINIUM
        ),
        0.81,
        "NUMISHEET'93 aluminium alloy: DEFORM-3D manual",
        "thickness P; E P/M (70 to 71 GPa); nu M (0.3 P is published too); Swift curve M 85%; r-values M 80%",
    ),
    "numisheet2002-ddq": Sheet(
        lambda name: Material(221370.0, 0.33, Hill48(2.160, 1.611, 2.665), Swift(547.76, 0.00876, 0.2692), name),
        1.0,
        "deep-drawing steel of the NUMISHEET 2002 cup: student report MECA-0464, Deep Drawing of a Cylindrical Cup",
        "E and nu P; Swift curve and r-values M 70%",
    ),
    "ak-steel": Sheet(
        lambda name: Material(206800.0, 0.3, VonMises(), Swift(510.0, (170.0 / 510.0) ** 4.76, 1.0 / 4.76), name),
        0.85,
        "AK steel of Wang and Budiansky 1978: Abaqus Example Problems Manual, hemispherical punch",
        "E, nu, 510 e^(1/4.76) and the yield stress 170 MPa P; e0 C, from the two of them",
    ),
    "osu-formability": Sheet(
        lambda name: Material(69004.0, 0.3, VonMises(), Swift(589.0, 1e-4, 0.216), name, density=ALUMINIUM),
        1.0,
        "OSU hemispherical punch benchmark: Lee, Wagoner and Nakamachi 1990",
        "M 75%",
    ),
    "aa2090-t3": Sheet(
        lambda name: Material(
            70000.0,
            0.33,
            Yld2000.fit(s0=1.0, s45=0.8114, s90=0.9102, sb=1.035, r0=0.2115, r45=1.5769, r90=0.6923, rb=0.67, a=8.0),
            Swift(646.0, 0.025, 0.227),
            name,
            density=ALUMINIUM,
        ),
        1.6,
        "AA2090-T3: yield stresses and r-values from github.com/stefanSCS/SHYqp (Poly6); Barlat et al., IJP 19 (2003)",
        "stress ratios and r-values P; thickness and Swift curve M 85%; E and nu M 60%, usual for aluminium alloys",
    ),
    "spcc-yoshida-uemori": Sheet(
        lambda name: Material(
            206000.0,
            0.3,
            VonMises(),
            YoshidaUemori(Y=124.0, B=168.0, C=500.0, R_sat=190.0, m=12.0, b=9.0, h=0.5),
            name,
        ),
        None,
        "SPCC mild steel: Yoshida and Uemori, IJP 18 (2002) 661-686, as in public implementations",
        "E and the law's parameters P (m = 12 to 12.5, b = 9 to 9.3 are in use); nu M 90%; locus von Mises",
    ),
    "590-yoshida-uemori": Sheet(
        lambda name: Material(
            206000.0,
            0.3,
            VonMises(),
            YoshidaUemori(Y=360.0, B=435.0, C=200.0, R_sat=255.0, m=26.0, b=66.0, h=0.2),
            name,
        ),
        None,
        "high-strength steel of 590 MPa: Yoshida and Uemori, IJP 18 (2002) 661-686",
        "the law's parameters M 75%; E and nu M 90%; locus von Mises",
    ),
}


def published_sheet(name):
    """Material of a published sheet. Raises SceneError with the names there are."""
    if name not in SHEETS:
        raise SceneError(f"published sheet {name!r} does not exist; there are {', '.join(SHEETS)}")
    return SHEETS[name].make(name)

"""Keys of the table [material]: elasticity, yield locus, hardening and rate, or the name of a published sheet."""

from typing import Annotated

from pydantic import BeforeValidator, Field

from .key_tables import OrText, Table, one_of
from .quantities import (
    Coefficient,
    Density,
    Name,
    Number,
    PositiveNumber,
    PositiveStress,
    Quantity,
    Stress,
    shown,
    wrong,
)

Poisson = Annotated[float, Quantity("a number", at_least=0.0, below=0.5)]
Exponent = Annotated[float, Quantity("a number", at_least=0.0, below=1.0)]
Anisotropy = Annotated[float, Quantity("an r-value", above=0.0)]


class RValues(Table):
    """Normal anisotropy: r, or the three r-values it is the mean of, (r0 + 2 r45 + r90)/4."""

    r: Anisotropy | None = None
    r0: Anisotropy | None = None
    r45: Anisotropy | None = None
    r90: Anisotropy | None = None

    @property
    def mean(self):
        if self.r is not None:
            return self.r
        assert self.r0 is not None and self.r45 is not None and self.r90 is not None  # _r_values saw to it
        return (self.r0 + 2.0 * self.r45 + self.r90) / 4.0


def _r_values(value):
    if isinstance(value, dict) and set(value) <= {"r", "r0", "r45", "r90"}:
        if set(value) not in ({"r"}, {"r0", "r45", "r90"}):
            raise wrong(shown(value), "r, or r0 and r45 and r90")
    return value


class Hill48Keys(Table):
    r0: Anisotropy = Field(description="r-value along the rolling direction")
    r45: Anisotropy = Field(description="r-value at 45 degrees to the rolling direction")
    r90: Anisotropy = Field(description="r-value across the rolling direction")


class Hill90Keys(Table):
    s0: PositiveNumber = Field(description="yield stress along the rolling direction over the curve's, such as 1.0")
    s45: PositiveNumber = Field(description="yield stress at 45 degrees over the curve's")
    s90: PositiveNumber = Field(description="yield stress across the rolling direction over the curve's")
    sb: PositiveNumber = Field(description="equibiaxial yield stress over the curve's")
    r45: Anisotropy = Field(description="r-value at 45 degrees")


class VegterKeys(Table):
    """Values at equally spaced directions from 0 to 90 degrees to the rolling direction."""

    uniaxial: list[PositiveNumber] = Field(description="yield stresses over the curve's, such as [1.0, 1.02, 0.98]")
    r: list[Anisotropy] = Field(description="r-values, such as [1.79, 1.51, 2.27]")
    plane_strain: list[PositiveNumber] = Field(description="major yield stresses in plane strain over the curve's")
    shear: list[PositiveNumber] = Field(description="yield stresses in shear over the curve's")
    biaxial: PositiveNumber = Field(description="equibiaxial yield stress over the curve's")
    rb: PositiveNumber = Field(description="ratio of strains de22/de11 in equibiaxial tension")
    plane_strain_ratio: PositiveNumber = 0.5


TESTS = ("s0", "s45", "s90", "sb", "r0", "r45", "r90", "rb")


class Yld2000Keys(Table):
    """Eight alphas, or the eight tests they are fitted to. a : exponent, 6 for steel, 8 for aluminium"""

    a: PositiveNumber = 8.0
    alphas: list[Number] | None = None
    s0: PositiveNumber | None = None
    s45: PositiveNumber | None = None
    s90: PositiveNumber | None = None
    sb: PositiveNumber | None = None
    r0: Anisotropy | None = None
    r45: Anisotropy | None = None
    r90: Anisotropy | None = None
    rb: PositiveNumber | None = None


def _alphas_or_tests(value):
    if isinstance(value, dict) and set(value) <= {"a", "alphas", *TESTS}:
        if set(value) - {"a"} not in ({"alphas"}, set(TESTS)):
            raise wrong(shown(value), f"alphas, or all of {', '.join(TESTS)}")
    return value


class Locus(Table):
    """One yield locus."""

    hill: Annotated[RValues, BeforeValidator(_r_values)] | None = None
    hill48: Hill48Keys | None = None
    hill90: Hill90Keys | None = None
    vegter: VegterKeys | None = None
    yld2000: Annotated[Yld2000Keys, BeforeValidator(_alphas_or_tests)] | None = None

    def build(self):
        """The locus as the solver takes it; Hill's r is the mean of the r-values. Raises solver.SceneError."""
        import solver

        if self.hill:
            return solver.VonMises() if self.hill.mean == 1.0 else solver.PlanarHill(self.hill.mean)
        if self.hill48:
            return solver.Hill48(**self.hill48.model_dump())
        if self.hill90:
            return solver.Hill90(**self.hill90.model_dump())
        if self.vegter:
            values = self.vegter.model_dump()
            return solver.Vegter(**{key: tuple(v) if isinstance(v, list) else v for key, v in values.items()})
        assert self.yld2000 is not None  # _locus saw to it
        if self.yld2000.alphas is not None:
            return solver.Yld2000(tuple(self.yld2000.alphas), self.yld2000.a)
        return solver.Yld2000.fit(**self.yld2000.model_dump(exclude={"alphas"}))


LOCI = ("hill", "hill48", "hill90", "vegter", "yld2000")


def _locus(value):
    if value == "von Mises":
        return {"hill": {"r": 1.0}}
    if not isinstance(value, dict):
        raise wrong(shown(value), '"von Mises" or {hill = {r = 0.64}}')
    return one_of(value, LOCI, '"von Mises" or a yield locus')


class SwiftKeys(Table):
    K: PositiveStress = Field(description="K in MPa of K (e0 + e)^n")
    e0: PositiveNumber = Field(description="e0 of K (e0 + e)^n")
    n: Annotated[float, Quantity("a number", at_least=0.0, below=1.0)] = Field(description="n of K (e0 + e)^n")


class LudwikKeys(Table):
    s0: PositiveStress = Field(description="s0 in MPa of s0 + K e^n")
    K: Stress = Field(description="K in MPa of s0 + K e^n")
    n: PositiveNumber = Field(description="n of s0 + K e^n")


class VoceKeys(Table):
    s0: PositiveStress = Field(description="s0 in MPa of s0 + Q (1 - exp(-b e))")
    Q: Stress = Field(description="Q in MPa of s0 + Q (1 - exp(-b e))")
    b: PositiveNumber = Field(description="b of s0 + Q (1 - exp(-b e))")


class HockettSherbyKeys(Table):
    s0: PositiveStress = Field(description="s0 in MPa of s_sat - (s_sat - s0) exp(-a e^p)")
    s_sat: PositiveStress = Field(description="s_sat in MPa of s_sat - (s_sat - s0) exp(-a e^p)")
    a: PositiveNumber = Field(description="a of s_sat - (s_sat - s0) exp(-a e^p)")
    p: PositiveNumber = Field(description="p of s_sat - (s_sat - s0) exp(-a e^p)")


class TableKeys(Table):
    strain: list[Coefficient] = Field(description="plastic strains that start at 0 and rise")
    stress: list[PositiveStress] = Field(description="a stress in MPa for each strain")


class Curve(Table):
    """One hardening curve; `weight` counts inside a sum."""

    swift: SwiftKeys | None = None
    ludwik: LudwikKeys | None = None
    voce: VoceKeys | None = None
    hockett_sherby: HockettSherbyKeys | None = None
    table: TableKeys | None = None

    def build(self):
        """The curve as the solver takes it."""
        import solver

        kind = {"swift": solver.Swift, "ludwik": solver.Ludwik, "voce": solver.Voce}
        kind |= {"hockett_sherby": solver.HockettSherby, "table": solver.Table}
        name, keys = next((name, getattr(self, name)) for name in kind if getattr(self, name))
        return kind[name](**keys.model_dump())


CURVES = ("swift", "ludwik", "voce", "hockett_sherby", "table")


def _one_curve(value):
    curve = {key: kept for key, kept in value.items() if key != "weight"} if isinstance(value, dict) else value
    one_of(curve, CURVES, "a hardening curve")
    return value


class ChabocheKeys(Table):
    """size in MPa, or a curve for mixed hardening; terms : [C in MPa, gamma] of each backstress"""

    size: PositiveStress | None = None
    curve: Annotated[Curve, BeforeValidator(_one_curve)] | None = None
    terms: list[tuple[Coefficient, Coefficient]] = Field(description="pairs such as [[10000, 25]]")


def _size_or_curve(value):
    if isinstance(value, dict) and set(value) <= {"size", "curve", "terms"} and ("size" in value) == ("curve" in value):
        raise wrong(shown(value), "size in MPa, or a curve, and terms")
    return value


class YoshidaUemoriKeys(Table):
    Y: PositiveStress = Field(description="radius of the yield surface in MPa")
    B: PositiveStress = Field(description="initial radius of the bounding surface in MPa")
    C: PositiveNumber = Field(description="rate at which the yield surface nears the bounding surface")
    R_sat: Stress = Field(description="growth of the bounding surface in MPa")
    m: Coefficient = Field(description="rate of that growth")
    b: Stress = Field(description="travel of the bounding surface in MPa")
    h: Coefficient = Field(description="share of growth of the stagnation surface, 0 up to 1")


class TwoSurfaceKeys(Table):
    curve: Annotated[Curve, BeforeValidator(_one_curve)] = Field(
        description="the tensile curve, such as {swift = {...}}"
    )
    yield_stress: PositiveStress = Field(description="radius of the inner surface in MPa")
    h0: PositiveStress = Field(description="modulus in MPa that the distance adds at the start of loading")
    power: Coefficient = Field(description="power of the distance")


class WeightedCurve(Curve):
    weight: PositiveNumber = Field(description="the curve's share, such as 0.5")


class Hardening(Curve):
    """A curve, a sum of curves, or a law that moves the yield surface."""

    sum: list[Annotated[WeightedCurve, BeforeValidator(_one_curve)]] | None = None
    chaboche: Annotated[ChabocheKeys, BeforeValidator(_size_or_curve)] | None = None
    yoshida_uemori: YoshidaUemoriKeys | None = None
    two_surface: TwoSurfaceKeys | None = None

    def build(self):
        import solver

        if self.sum:
            return solver.Sum(tuple((part.weight, part.build()) for part in self.sum))
        if self.chaboche:
            size = self.chaboche.curve.build() if self.chaboche.curve else self.chaboche.size
            return solver.Chaboche(size, tuple(self.chaboche.terms))
        if self.yoshida_uemori:
            return solver.YoshidaUemori(**self.yoshida_uemori.model_dump())
        if self.two_surface:
            law = self.two_surface
            return solver.TwoSurface(law.curve.build(), law.yield_stress, law.h0, law.power)
        return super().build()


HARDENINGS = (*CURVES, "sum", "chaboche", "yoshida_uemori", "two_surface")


def _one_hardening(value):
    return one_of(value, HARDENINGS, "a hardening curve")


class CowperSymondsKeys(Table):
    D: PositiveNumber = Field(description="D in 1/s of 1 + (rate/D)^(1/P)")
    P: PositiveNumber = Field(description="P of 1 + (rate/D)^(1/P)")


class PowerLawKeys(Table):
    reference: PositiveNumber = Field(description="rate in 1/s of (1 + rate/reference)^m")
    m: Coefficient = Field(description="m of (1 + rate/reference)^m")


class Rate(Table):
    """Strain-rate factor; counts where increments have a length in time."""

    cowper_symonds: CowperSymondsKeys | None = None
    power_law: PowerLawKeys | None = None

    def build(self):
        """The factor as the solver takes it."""
        import solver

        if self.cowper_symonds:
            return solver.CowperSymonds(**self.cowper_symonds.model_dump())
        assert self.power_law is not None  # _one_rate saw to it
        return solver.PowerLawRate(**self.power_law.model_dump())


class ModulusKeys(Table):
    E_a: PositiveStress = Field(description="Young's modulus in MPa after large plastic strain")
    xi: Coefficient = Field(description="xi of E - (E - E_a) (1 - exp(-xi ep))")


def _one_rate(value):
    return one_of(value, ("cowper_symonds", "power_law"), "a rate factor")


class Material(Table):
    """A sheet's numbers. In their place, the name of a published sheet: material = "numisheet93-steel"."""

    name: Name = "sheet"
    young: PositiveStress = Field(description='Young\'s modulus in MPa, such as "70 GPa"')
    poisson: Poisson = Field(description="Poisson's ratio, such as 0.3")
    locus: Annotated[Locus, BeforeValidator(_locus), OrText(lambda: ["von Mises"])] = Field(
        description='"von Mises" or {hill = {r = 0.64}}'
    )
    hardening: Annotated[Hardening, BeforeValidator(_one_hardening)] = Field(
        description="a curve such as {swift = {K = 577, e0 = 0.0166, n = 0.359}}"
    )
    rate: Annotated[Rate, BeforeValidator(_one_rate)] | None = None
    modulus: ModulusKeys | None = None
    density: Density = Field(7.85e-9, description="tonne/mm^3, by default that of steel; explicit runs only")

    def build(self):
        """solver.Material. Raises solver.SceneError."""
        import solver

        rate = self.rate.build() if self.rate else None
        modulus = solver.DecayingModulus(**self.modulus.model_dump()) if self.modulus else None
        return solver.Material(
            self.young,
            self.poisson,
            self.locus.build(),
            self.hardening.build(),
            name=self.name,
            rate=rate,
            density=self.density,
            modulus=modulus,
        )


class PublishedSheet(Material):
    """A sheet of the library, by name: nothing of it is in the file."""

    def build(self):
        from solver.materials.library import published_sheet

        return published_sheet(self.name)


class LimitTableKeys(Table):
    """Points of a forming limit curve, minor strains rising; logarithmic unless engineering."""

    minor: list[Number] = Field(description="minor strains that rise, such as [-0.2, 0, 0.2]")
    major: list[PositiveNumber] = Field(description="the major strain at which the sheet necks, for each minor one")
    engineering: bool = False


class KeelerBrazierKeys(Table):
    n: PositiveNumber = Field(description="the strain-hardening exponent, such as 0.2")


class MarciniakKeys(Table):
    f0: Annotated[float, Quantity("a ratio of thicknesses", above=0.5, below=1.0)] = 0.995


class FormingLimitKeys(Table):
    """The limit of strain: tabulated, by the rule of Keeler and Brazier, or computed from the material."""

    table: LimitTableKeys | None = None
    keeler_brazier: KeelerBrazierKeys | None = None
    marciniak: MarciniakKeys | None = None

    def build(self, material, thickness):
        """The curve as the solver takes it. Raises solver.SceneError. thickness : mm"""
        import solver

        if self.table:
            points = self.table.minor, self.table.major
            return solver.LimitCurve.from_engineering(*points) if self.table.engineering else solver.LimitCurve(*points)
        if self.keeler_brazier:
            return solver.KeelerBrazier(thickness, self.keeler_brazier.n)
        assert self.marciniak is not None  # _one_limit saw to it
        return solver.marciniak_kuczynski(material, self.marciniak.f0)


def _one_limit(value):
    return one_of(value, ("table", "keeler_brazier", "marciniak"), "a forming limit curve")


FormingLimit = Annotated[FormingLimitKeys, BeforeValidator(_one_limit)]


def _sheets():
    from solver.materials.library import SHEETS

    return SHEETS


def _table_or_sheet(value):
    if not isinstance(value, str):
        return value
    if value not in _sheets():
        raise wrong(shown(value), f"a table [material], or a published sheet: {', '.join(_sheets())}")
    return PublishedSheet.model_construct(name=value, hardening=Hardening())


MaterialOrSheet = Annotated[Material, BeforeValidator(_table_or_sheet), OrText(_sheets)]

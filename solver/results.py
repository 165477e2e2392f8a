"""What a run hands back: the history of every increment, frames of the sheet, energies."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

LARGEST_TORSION_SHARE = 0.02
LARGEST_KINETIC_SHARE = 0.05
LARGEST_SQUEEZE = 0.1  # of the least thickness
SET_OUT = 0.25  # of the stroke; before that a flat sheet has little energy to compare with


@dataclass(frozen=True)
class Frame:
    """The sheet and the tools at one stroke, ready to be written or drawn.

    stroke : mm, travel of the leading tool over all stages so far (fraction of the stage where none travels)
    points : (n, 3) current mid-surface nodes [mm]
    point_fields : displacement (n, 3) mm, contact_gap (n,) mm from the squeezed skin, contact_pressure (n,) MPa of the
        tool that presses most, friction_traction (n, 3) MPa of all tools, contact_tool (n,) index of the nearest or -1,
        squeeze (n,) mm by which tools on both sides press the sheet thinner, of which the elements know nothing
    cell_fields : thickness (m,) mm, thinning (m,) 1, strain_major (m,), strain_minor (m,) log strains,
        fld_margin (m,) of a blank with a forming limit: 1 unstrained, 0 on the curve, negative beyond it,
        plastic_strain (m,) equivalent, stress (m, 6) Cauchy xx yy zz xy yz xz MPa; of a shell the middle layer, and
        the outermost ones with _top and _bottom, and its curvature (m, 3) 1/mm, section_force (m, 3) N/mm and
        section_moment (m, 3) N in rolling axes
    tool_offsets : {tool name: (3,) mm displacement from its place in the CAD file}
    tool_turns : {name: (3, 3)} of tools that may tilt: a point X of the CAD file is at turn X + displacement
    """

    stage: str
    increment: int
    stroke: float
    points: np.ndarray
    point_fields: dict
    cell_fields: dict
    tool_offsets: dict
    tool_turns: dict = field(default_factory=dict)


class Progress(NamedTuple):
    """What `form` tells its `watch` after each increment."""

    stage: str
    increment: int
    fraction: float  # of the whole run, 0..1
    stroke: float  # mm
    iterations: int  # Newton iterations of this increment
    n_contacts: int  # nodes touching a tool
    n_cut_backs: int  # so far


@dataclass
class Results:
    """A finished (or stopped) run.

    history : {column: list}, one entry per increment: stage, increment, stroke, iterations, residual,
        n_contacts, force_<tool> [N, whole part, along the tool's axis, on the tool], travel_<tool> [mm],
        tilt_<tool> [degrees] of tools that may tilt, bead_<drawbead> and uplift_<drawbead> [N, whole part],
        reaction_<group>_<axis> [N, on the modelled nodes of a group that is moved], draw_in_<name> [mm],
        thickness_min, thickness_max [mm], thinning_max,
        squeeze_max (by how much tools on both sides press a node thinner, for good and elastically [mm]; the elements
        know nothing of it),
        fld_margin_min and fld_margin_x, _y, _z (where the blank has a forming limit: the smallest margin, and the
        middle of its triangle [mm]),
        torsion_share (work of the torsion stabilisation relative to the external work so far), kinetic_share (kinetic
        relative to internal energy). Of explicit stages increment counts records, iterations the steps since the last
        one, residual the drift of the energy balance, and force_<tool> is a mean over these steps
    frames : [Frame], the ones asked for
    energy : {external: work by tools, loads and supports; internal, friction, contact, torsion, kinetic, damping;
        imbalance} [mJ], of the whole part
    plan : Plan, what ran and what was skipped
    notes : what an explicit stage chose by itself: its time and step, mass added, mass of tools driven by a force
    lifted : names of the tools driven by a force, whose lift tells of wrinkles
    travelled : names of the stages in which a tool travels, whose stroke is one in mm
    searches : {asked, projected}: distances from nodes to tools that contact wanted to know, in the stages run
        to their end, and those of them not told by an earlier distance (contact/search.py)
    contact : {foot_error, sharp_nodes, several_feet}: how exact contact was in the frames (contact/budget.py)
    finished : False where the run stopped early
    """

    plan: object
    lifted: tuple = ()
    travelled: tuple = ()
    notes: list = field(default_factory=list)
    history: dict = field(default_factory=dict)
    frames: list = field(default_factory=list)
    energy: dict = field(default_factory=dict)
    seconds: dict = field(default_factory=dict)
    searches: dict = field(default_factory=lambda: {"asked": 0, "projected": 0})
    contact: dict = field(default_factory=dict)
    finished: bool = False

    def record(self, **columns):
        """Append one increment to the history."""
        for name, value in columns.items():
            self.history.setdefault(name, []).append(value)

    def count_searches(self, tools):
        """Add what the searches of a stage's tools have counted. tools : ToolRuns"""
        for tool in tools:
            self.searches["asked"] += tool.neighbourhood.n_asked
            self.searches["projected"] += tool.neighbourhood.n_projected

    def at(self, column, stroke):
        """History column interpolated at a stroke [mm]."""
        return float(np.interp(stroke, self.history["stroke"], self.history[column]))

    def in_equilibrium(self):
        """Which increments are equilibria, (n,) bool: all but dynamic ones, whose forces hold inertia too."""
        return np.array(self.history.get("dynamic", np.zeros(len(self.history.get("stroke", ()))))) == 0.0

    def largest_forces(self):
        """{max_force_<tool>: N} of all increments in equilibrium."""
        still = self.in_equilibrium()
        return {
            f"max_{name}": float(np.max(np.abs(np.array(values)[still]), initial=0.0))
            for name, values in self.history.items()
            if name.startswith("force_")
        }

    def pace(self):
        """{iterations_per_increment; increments_per_mm, where a tool has travelled; dynamic_increments}"""
        iterations = self.history.get("iterations", [])
        if not iterations:
            return {}
        found = {"iterations_per_increment": float(np.mean(iterations))}
        way = np.diff(self.history["stroke"], prepend=0.0)
        drawn = np.isin(self.history["stage"], self.travelled) & ((way > 0.0) | ~self.in_equilibrium())
        if way[drawn].any():
            found["increments_per_mm"] = float(drawn.sum() / way[drawn].sum())
        return found | {"dynamic_increments": int(np.sum(~self.in_equilibrium()))}

    def remarks(self):
        """What a reader has to know: what explicit stages chose, from which stroke a membrane wants to wrinkle or a
        tool rides on wrinkles, until which one the tools were too fast."""
        found = list(self.notes)
        if "torsion_share" not in self.history:
            return found
        margin = np.array(self.history.get("fld_margin_min", []))
        if (margin < 0.0).any():
            first = int(np.argmax(margin < 0.0))
            place = ", ".join(f"{self.history[f'fld_margin_{axis}'][first]:.1f}" for axis in "xyz")
            found.append(
                f"from {self.history['stroke'][first]:.3g} mm on, strains are beyond the forming limit, "
                f"first near ({place}) mm"
            )
        stroke = np.array(self.history["stroke"])
        share = np.array(self.history["torsion_share"])
        leaning = (share > LARGEST_TORSION_SHARE) & (stroke > 0.1 * stroke[-1])
        if leaning.any():
            found.append(
                f"from {stroke[leaning][0]:.3g} mm on, the torsion stabilisation has done more than "
                f"{100 * LARGEST_TORSION_SHARE:.0f} % of the work: the membrane wants to wrinkle; use a shell"
            )
        squeezed = np.array(self.history["squeeze_max"]) > LARGEST_SQUEEZE * np.array(self.history["thickness_min"])
        if squeezed.any():
            found.append(
                f"from {stroke[squeezed][0]:.3g} mm on, the tools leave the sheet less room than its thickness, "
                f"up to {max(self.history['squeeze_max']):.2g} mm less: do not trust forces and thickness there"
            )
        snapping = ~self.in_equilibrium()
        if snapping.any():
            lost = self.energy.get("damping", 0.0) / max(abs(self.energy.get("external", 0.0)), 1e-300)
            found.append(
                f"from {stroke[snapping][0]:.3g} mm on, the sheet snaps: {np.count_nonzero(snapping)} increments were "
                f"dynamic: inertia took {100 * lost:.2g} % of the work"
            )
        kinetic = np.array(self.history.get("kinetic_share", np.zeros(len(stroke))))
        moving = (kinetic > LARGEST_KINETIC_SHARE) & (stroke > SET_OUT * stroke[-1])
        if moving.any():
            found.append(
                f"until {stroke[moving][-1]:.3g} mm, kinetic energy is more than {100 * LARGEST_KINETIC_SHARE:.0f} % "
                "of the sheet's: forces there are those of a fast tool; give Explicit more waves"
            )
        thickest = np.array(self.history["thickness_max"])
        growth = thickest - np.array(self.history["thickness_min"]) / (1.0 - np.array(self.history["thinning_max"]))
        for name in self.lifted:
            travel = np.array(self.history[f"travel_{name}"])
            # Lifts count from where the tool has pressed a blank flat that was not.
            seated = max(int(np.sum(np.array(stroke) == 0.0)) - 1, 0)
            riding = np.abs(travel - travel[seated]) > 1.5 * growth + 0.02 * thickest
            riding[:seated] = False
            if riding.any():
                found.append(
                    f"from {stroke[riding][0]:.3g} mm on, {name} is lifted by wrinkles, not by the sheet's thickness"
                )
        return found

    def summary(self):
        """Figures a report opens with: {name: number or text}."""
        last = {name: values[-1] for name, values in self.history.items() if values}
        iterations = self.history.get("iterations", [])
        asked = self.searches["asked"]
        return {
            "finished": self.finished,
            **last,
            "increments": len(iterations),
            "iterations": int(np.sum(iterations)),
            **self.pace(),
            **({"nodes_skipped": 1.0 - self.searches["projected"] / asked} if asked else {}),
            **self.largest_forces(),
            **{f"contact_{k}": v for k, v in self.contact.items()},
            "remarks": self.remarks(),
            **{f"energy_{k}": v for k, v in self.energy.items()},
            **{f"seconds_{k}": v for k, v in self.seconds.items()},
        }

"""What is read off a state: one row of the history per increment, and frames of the whole sheet."""

import numpy as np

from .contact.budget import ContactBudget
from .contact.drawbead import BeadRun
from .contact.drive import pivot_of, turn
from .draw_in import RimGauge
from .materials.forming_limit import fld_margin
from .results import Frame
from .scene import AXES


class Recorder:
    """Reads states of one scene. Forces are those of the whole part, symmetric shares multiplied up."""

    def __init__(self, scene, sheet):
        self.scene, self.sheet = scene, sheet
        self.budget = ContactBudget()
        self.gauges = {name: RimGauge(sheet, direction, name) for name, direction in scene.blank.draw_in.items()}
        moved = {
            (g, axis)
            for stage in scene.stages
            for g, m in stage.movements.items()
            for axis in range(3)
            if m[axis] is not None
        }
        self.supports = sorted(moved)
        self.beads = {name: BeadRun(bead, sheet, 0.0) for name, bead in scene.drawbeads.items()}
        tilting = {tool.name: tool for stage in scene.stages for tool in stage.tools if tool.tilts}
        self.tilting = {name: pivot_of(tool, sheet) for name, tool in tilting.items()}
        self.before, self.stage = 0.0, scene.stages[0]

    def start(self, stage, begun, results):
        """A stage with its tools closed on the sheet goes on from a March; the stroke so far is in the history."""
        self.stage = stage
        done = results.history["stroke"][-1] if results.history else 0.0
        self.before = done - max(begun.fraction, 0.0) * stage.stroke

    def stroke(self, fraction):
        """Travel of the leading tool over all stages so far, at a fraction of this one [mm]."""
        return float(self.before + fraction * self.stage.stroke)

    def row(self, k, step, state, energy, results):
        """Append one increment of stage k to the history."""
        fraction, outcome = max(step.march.fraction, 0.0), step.outcome
        thickness = self.sheet.thickness(state.sheet.thickness_strain)
        touching = np.zeros(len(self.sheet.points), dtype=bool)
        columns = {}
        for name in self.scene.tools:
            contact = state.tools[name]
            axis = self.scene.tools[name].unit_axis
            columns[f"force_{name}"] = float(contact.force @ axis) / self.scene.blank.share
            columns[f"travel_{name}"] = float(contact.travel[0])
            if name in self.tilting:
                columns[f"tilt_{name}"] = float(np.degrees(np.linalg.norm(contact.tilt)))
            touching |= contact.touching
        for name, run in self.beads.items():
            restraint, uplift = run.held(state.beads[name])
            columns[f"bead_{name}"] = restraint / self.scene.blank.share
            columns[f"uplift_{name}"] = uplift / self.scene.blank.share
        for group, axis in self.supports:
            force = state.sheet.internal - state.sheet.external
            nodes = self.scene.blank.nodes_of(group)
            touch = sum(contact.push[nodes, axis] for contact in state.tools.values())
            columns[f"reaction_{group}_{AXES[axis]}"] = float(np.sum(force[nodes, axis] - touch))
        for name, gauge in self.gauges.items():
            columns[f"draw_in_{name}"] = gauge.read(state.sheet.x)
        if self.scene.blank.forming_limit:
            margin = self.limit_margin(*principal_strains(self.sheet.middle(state.sheet.strain)))
            worst = int(np.argmin(margin))
            columns["fld_margin_min"] = float(margin[worst])
            for axis, place in zip(AXES, state.sheet.x[self.sheet.triangles.cells[worst]].mean(axis=0)):
                columns[f"fld_margin_{axis}"] = float(place)
        results.record(
            stage=self.scene.stages[k].name,
            increment=len(results.history.get("increment", [])) + 1,
            stroke=self.stroke(fraction),
            iterations=outcome.iterations,
            residual=outcome.residuals[-1],
            n_contacts=int(touching.sum()),
            thickness_min=float(thickness.min()),
            thickness_max=float(thickness.max()),
            thinning_max=float(1.0 - thickness.min() / self.sheet.blank.thickness),
            squeeze_max=float(np.max(state.squeeze, initial=0.0)),
            torsion_share=energy.torsion_share(),
            dynamic=float(outcome.dynamic),
            kinetic_share=energy.kinetic_share(),
            **columns,
        )

    def frame(self, k, fraction, state, results):
        """Frame of stage k at a fraction of it."""
        points, cells = state.sheet.x, {}
        thickness = self.sheet.thickness(state.sheet.thickness_strain)
        major, minor = principal_strains(self.sheet.middle(state.sheet.strain))
        cells["thickness"] = thickness
        cells["thinning"] = 1.0 - thickness / self.sheet.blank.thickness
        cells["strain_major"], cells["strain_minor"] = major, minor
        if self.scene.blank.forming_limit:
            cells["fld_margin"] = self.limit_margin(major, minor)
        for suffix, layer in shown_layers(len(self.sheet.elements.weight)).items():
            cells["plastic_strain" + suffix] = state.sheet.equivalent.reshape(len(thickness), -1)[:, layer].copy()
            cells["stress" + suffix] = cauchy_stress(self.sheet.elements, state.sheet, layer)
        cells |= self.sheet.elements.section(state.sheet)
        return Frame(
            stage=self.scene.stages[k].name,
            increment=len(results.history.get("increment", [])),
            stroke=self.stroke(fraction),
            points=points.copy(),
            point_fields=self.contact_fields(k, state),
            cell_fields=cells,
            tool_offsets={name: self.place(name, state.tools[name])[0] for name in self.scene.tools},
            tool_turns={name: self.place(name, state.tools[name])[1] for name in self.tilting},
        )

    def place(self, name, contact):
        """Displacement (3,) and turn (3, 3) of a tool: its points X of the CAD file are at turn X + displacement."""
        matrix = turn(contact.tilt)
        shift = contact.travel[0] * self.scene.tools[name].unit_axis
        if name in self.tilting:
            shift = shift + self.tilting[name] - matrix @ self.tilting[name]
        return shift, matrix

    def limit_margin(self, major, minor):
        """How far every triangle is from the forming limit, (m,). Necking is one of the whole thickness: major and
        minor are the strains of the middle layer."""
        return fld_margin(self.scene.blank.forming_limit, major, minor)

    def contact_fields(self, k, state):
        """Displacement, and contact with the stage's tools: the largest pressure (a sheet between two bears one from
        both sides) and the sum of friction; gaps are projected afresh for every node."""
        x = state.sheet.x
        n = len(x)
        # Where tools on both sides squeeze it, the sheet's skin is there.
        half = 0.5 * (self.sheet.nodal_thickness(state.sheet) - (state.squeeze - state.sheet.flattened))
        area = current_areas(self.sheet.triangles.cells, x)
        gap, nearest = np.full(n, np.inf), np.full(n, -1)
        pressure, traction = np.zeros(n), np.zeros((n, 3))
        hits = []
        for tool in self.scene.stages[k].tools:
            contact = state.tools[tool.name]
            shift, matrix = self.place(tool.name, contact)
            place = (x - shift) @ matrix if tool.name in self.tilting else x - shift
            hit = tool.surface.project(place)
            hits.append((place, hit, contact))
            distance = hit.distance - half
            closer = distance < gap
            gap[closer] = distance[closer]
            nearest[closer] = list(self.scene.tools).index(tool.name)
            pressure = np.maximum(pressure, sum(foot.normal_force for foot in contact.feet) / area)
            traction += sum(foot.friction_force for foot in contact.feet) / area[:, None]
        self.budget.add(hits)
        return {
            "displacement": x - self.sheet.points,
            "contact_gap": gap if np.isfinite(gap).all() else np.zeros(n),
            "contact_tool": nearest,
            "contact_pressure": pressure,
            "friction_traction": traction,
            "squeeze": state.squeeze,
        }


def principal_strains(strain):
    """Major and minor logarithmic strain in the plane, (m,) each. strain : (m, 3) [11, 22, 2*12]"""
    mean, half = 0.5 * (strain[:, 0] + strain[:, 1]), 0.5 * (strain[:, 0] - strain[:, 1])
    radius = np.hypot(half, 0.5 * strain[:, 2])
    return mean + radius, mean - radius


def shown_layers(n_layers):
    """Layers that are written, {suffix of the field's name: layer}: the middle, and of a shell the outermost."""
    shown = {"": n_layers // 2}
    return shown if n_layers == 1 else shown | {"_top": n_layers - 1, "_bottom": 0}


def cauchy_stress(elements, sheet, layer):
    """Cauchy stress of a layer in space, (m, 6) xx yy zz xy yz xz [MPa]: a S a^T / J, J the ratio of volumes."""
    tangents = elements.layer_tangents(sheet, layer)
    m = len(tangents)
    s, metric = (values.reshape(m, -1, 3)[:, layer] for values in (sheet.second_stress, sheet.metric))
    tensor = np.empty((m, 2, 2))
    tensor[:, 0, 0], tensor[:, 1, 1], tensor[:, 0, 1], tensor[:, 1, 0] = s[:, 0], s[:, 1], s[:, 2], s[:, 2]
    determinant = metric[:, 0] * metric[:, 1] - metric[:, 2] ** 2
    volume_ratio = np.sqrt(determinant) * np.exp(sheet.thickness_strain.reshape(m, -1)[:, layer])
    full = np.einsum("mac,mab,mbd->mcd", tangents, tensor, tangents) / volume_ratio[:, None, None]
    return np.stack([full[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))], axis=1)


def current_areas(cells, x):
    """Tributary area of each node now, (n,) [mm^2]."""
    corner = x[cells]
    area = 0.5 * np.linalg.norm(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    nodal = np.zeros(len(x))
    np.add.at(nodal, cells.ravel(), np.repeat(area / 3.0, 3))
    return nodal

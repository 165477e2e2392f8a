"""Placements that OpenCASCADE would read wrongly: put right, or told. Runs in the reading process only.

A part or copy is placed by two coordinate systems, the first of which comes to lie on the second (ISO 10303-43,
item_defined_transformation and mapped_item), or by an operator (ISO 10303-42, cartesian_transformation_operator_3d).
With o, R and t, S their origins and rotations the first way moves

    x -> t + S Rᵀ (x - o)

where OpenCASCADE takes x -> Rᵀ (t + S x - o), the same only while one of the two systems is that of the space. The
placements (S Rᵀ o, I) and (t, S Rᵀ) in their stead give it the former. Of an operator OpenCASCADE ignores the scale,
turns a mirror image, and misreads one that leaves out directions.
"""

import numpy as np
from OCP.GeomToStep import GeomToStep_MakeAxis2Placement3d
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
from OCP.StepData import StepData_Factors
from OCP.StepGeom import StepGeom_Axis2Placement3d, StepGeom_CartesianTransformationOperator3d
from OCP.StepRepr import (
    StepRepr_ItemDefinedTransformation,
    StepRepr_MappedItem,
    StepRepr_RepresentationMap,
    StepRepr_ShapeRepresentationRelationshipWithTransformation,
)
from OCP.StepShape import StepShape_ShapeRepresentation
from OCP.StepToGeom import StepToGeom

from cadlink.curves import xyz

SAME = 1e-12  # two coordinate systems, relative to the distance from the origin
Z = np.array([0.0, 0.0, 1.0])  # the third direction of an operator that has none
MISREAD = "it moves one coordinate system onto another, neither that of the space, which OpenCASCADE would misread"


def wrong_placement(model, rewrite=True):
    """One line about a placement that OpenCASCADE would misread, or None.

    rewrite : put those right in the model that can be, instead of a line about them
    """
    for i in range(1, model.NbEntities() + 1):
        entity = model.Value(i)
        wrong = None
        if isinstance(entity, StepGeom_CartesianTransformationOperator3d):
            wrong = wrong_operator(entity)
        elif isinstance(entity, StepRepr_ShapeRepresentationRelationshipWithTransformation):
            wrong = wrong_relation(entity, rewrite)
        elif isinstance(entity, StepShape_ShapeRepresentation):
            for k in range(1, entity.NbItems() + 1):
                item = entity.ItemsValue(k)
                if wrong is None and isinstance(item, StepRepr_MappedItem):
                    wrong = wrong_copy(item, rewrite)
        if wrong:
            return wrong
    return None


def wrong_operator(operator):
    """What is wrong with a CARTESIAN_TRANSFORMATION_OPERATOR_3D, or None."""
    if operator.HasScale() and abs(operator.Scale() - 1.0) > SAME:
        return f"it scales a part by {operator.Scale():g}, which OpenCASCADE would ignore; export the part at its size"
    x, y, z = (ratios(axis) for axis in (operator.Axis1(), operator.Axis2(), operator.Axis3()))
    if x is None or y is None or (z is None and np.hypot(*np.cross(x, y)[:2]) > SAME):
        return "it places a part by an operator that leaves out directions, which OpenCASCADE would misread"
    if np.cross(x, y) @ (Z if z is None else z) < 0.0:
        return (
            "it places a part as its mirror image, which OpenCASCADE would turn instead; "
            "export the mirrored part as a solid of its own"
        )
    return None


def ratios(direction):
    return None if direction is None else np.array([direction.DirectionRatiosValue(k) for k in (1, 2, 3)])


def wrong_relation(relation, rewrite):
    """What is wrong with the place of a part in an assembly, or None."""
    moved = relation.TransformationOperator().Value()
    if not isinstance(moved, StepRepr_ItemDefinedTransformation):
        return None
    items = moved.TransformItem1(), moved.TransformItem2()
    if not all(isinstance(item, StepGeom_Axis2Placement3d) for item in items):
        return "it places a part by something else than two coordinate systems, which OpenCASCADE would ignore"
    if holds(relation.Rep2(), items[0]) and holds(relation.Rep1(), items[1]):
        items = items[::-1]  # as OpenCASCADE does
    new = same_move(*items)
    if new and not rewrite:
        return MISREAD
    if new:
        moved.SetTransformItem1(new[0])
        moved.SetTransformItem2(new[1])
    return None


def wrong_copy(item, rewrite):
    """What is wrong with a MAPPED_ITEM of a part, or None."""
    source, target = item.MappingSource(), item.MappingTarget()
    origin = source.MappingOrigin()
    if not isinstance(source.MappedRepresentation(), StepShape_ShapeRepresentation):
        return "it copies something else than a shape into a part (MAPPED_ITEM), which OpenCASCADE would leave out"
    if not isinstance(origin, StepGeom_Axis2Placement3d):
        return "it copies a shape from something else than a coordinate system, which OpenCASCADE would ignore"
    if isinstance(target, StepGeom_CartesianTransformationOperator3d):
        at, turn = place_of(origin)
        if np.abs(at).max() > 0.0 or not np.allclose(turn, np.eye(3), rtol=0.0, atol=SAME):
            return "it copies a shape by an operator from a place other than the origin, which OpenCASCADE would ignore"
    elif isinstance(target, StepGeom_Axis2Placement3d):
        new = same_move(origin, target)
        if new and not rewrite:
            return MISREAD
        if new:
            its_own = StepRepr_RepresentationMap()
            its_own.Init(new[0], source.MappedRepresentation())
            item.SetMappingSource(its_own)
            item.SetMappingTarget(new[1])
    else:
        return "it places a copy of a shape by something else than a coordinate system, which OpenCASCADE would ignore"
    return None


def holds(representation, item):
    return any(representation.ItemsValue(k) == item for k in range(1, representation.NbItems() + 1))


def place_of(placement):
    """Origin (3,) in the file's unit and axes as columns (3, 3) of an AXIS2_PLACEMENT_3D."""
    axes = StepToGeom.MakeAxis2Placement_s(placement, StepData_Factors()).Ax2()
    return xyz(axes.Location()), np.column_stack(
        [xyz(axes.XDirection()), xyz(axes.YDirection()), xyz(axes.Direction())]
    )


def same_move(first, second):
    """Two placements by which OpenCASCADE moves the first onto the second, or None where these do as they are."""
    (o, R), (t, S) = place_of(first), place_of(second)
    turn, size = S @ R.T, max(1.0, np.abs(o).max(), np.abs(t).max())
    right = t - turn @ o
    taken = R.T @ (t - o)
    if np.abs(R.T @ S - turn).max() <= SAME and np.abs(right - taken).max() <= SAME * size:
        return None
    return placement_of(turn @ o, np.eye(3)), placement_of(t, turn)


def placement_of(origin, axes):
    at = gp_Ax2(gp_Pnt(*origin), gp_Dir(*axes[:, 2]), gp_Dir(*axes[:, 0]))
    return GeomToStep_MakeAxis2Placement3d(at, StepData_Factors()).Value()

"""Forming limits by the groove model of Marciniak and Kuczynski (IJMS 9 (1967) 609-620), with any material.

A sheet A with a groove B, thinner by the factor f0 and with the normal N, is stretched along a straight path of strain.
The groove's deformation is compatible, F_B = F_A + c N^T, and it carries the same force, P_A N = f0 P_B N. Both sides
are points of the same material, so every locus and hardening law takes part; with a groove that stays
perpendicular to the major strain this is the model of the original paper. The sheet necks where the groove stretches
ten times as fast as the sheet. A groove may lie at several angles; the least limit counts.

Symbols: F (p, 2, 2) deformation gradients in rolling axes; S second and P = F S first Piola-Kirchhoff stress; p paths.
"""

import numpy as np

from ..errors import SceneError
from .forming_limit import LimitCurve

RATIO = 10.0  # groove to sheet strain rate at necking
RATIOS = (-0.5, -0.4, -0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)


def marciniak_kuczynski(material, f0=0.995, ratios=RATIOS, grooves=None, angle=0.0, step=2e-4, largest=2.0):
    """Forming limit curve of a material.

    f0 : thickness of the groove relative to the sheet's, below 1
    ratios : minor to major strain of each path
    grooves : angles between the groove's normal and the major strain [rad]; by default 0, and for negative ratios also
        angles up to that of zero extension
    angle : of the major strain to the rolling direction [rad]
    step : increment of the major strain; largest : where paths are given up
    returns : LimitCurve. Raises SceneError for values out of range.
    """
    if not 0.5 < f0 < 1.0:
        raise SceneError(f"Marciniak-Kuczynski f0: found {f0!r}, expected a ratio of thicknesses above 0.5, below 1")
    ratios = np.asarray(ratios, dtype=float)
    if ratios.ndim != 1 or not ((ratios > -1.0) & (ratios <= 1.0)).all():
        raise SceneError(f"Marciniak-Kuczynski ratios: found {tuple(ratios)}, expected numbers above -1, at most 1")
    paths = [(ratio, groove) for ratio in ratios for groove in (grooves_of(ratio) if grooves is None else grooves)]
    limits = limit_strains(material, f0, np.array(paths), angle, step, largest)
    major = np.array([limits[[path[0] == ratio for path in paths]].min() for ratio in ratios])
    if not np.isfinite(major).all():
        raise SceneError(f"Marciniak-Kuczynski: no necking up to a strain of {largest:g}; give larger imperfections")
    order = np.argsort(ratios * major)
    minor = (ratios * major)[order].tolist()
    return LimitCurve(tuple(minor), tuple(major[order].tolist()), f"Marciniak-Kuczynski, f0 = {f0:g}")


def grooves_of(ratio):
    """Angles of the groove worth trying [rad]: up to the direction of zero extension and a little beyond."""
    if ratio >= 0.0:
        return (0.0,)
    return tuple(np.linspace(0.0, min(np.arctan(np.sqrt(-ratio)) + np.radians(6.0), np.pi / 4), 9))


def limit_strains(material, f0, paths, angle=0.0, step=2e-4, largest=2.0):
    """Major strain of the sheet at necking, (p,); inf where it does not neck. paths : (p, 2) ratio, groove angle"""
    material.prepare()
    n = len(paths)
    ratio, groove = paths.T
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    normal = np.column_stack([np.cos(groove), np.sin(groove)]) @ turn.T
    sheet = [material.new_state(n) for _ in range(2)]
    inside = [material.new_state(n) for _ in range(2)]
    jump, rate = np.zeros((n, 2)), np.zeros((n, 2))  # c, and its change with the major strain
    stretch, limit, active = np.zeros(n), np.full(n, np.inf), np.ones(n, dtype=bool)
    for k in range(1, int(largest / step) + 1):
        major = k * step
        stretches = np.exp(np.stack([np.full(n, major), ratio * major], axis=1))
        f_a = np.einsum("ij,pj,kj->pik", turn, stretches, turn)
        force = first_stress(material, f_a, *sheet, tangent=False) @ normal[:, :, None]
        trial = jump + step * rate
        trial, good = balance(material, f_a, normal, force[:, :, 0], f0, trial, inside, active)
        f_b = f_a + trial[:, :, None] * normal[:, None, :]
        now = np.log(np.linalg.norm((f_b @ normal[:, :, None])[:, :, 0], axis=1))
        necked = active & (~good | (now - stretch > RATIO * step))
        limit[necked] = major
        active &= ~necked
        if not active.any():
            break
        rate[active] = (trial[active] - jump[active]) / step
        jump[active], stretch[active] = trial[active], now[active]
        sheet[0].copy_from(sheet[1])
        for name, array in inside[0].arrays().items():
            array[active] = inside[1].arrays()[name][active]
    return limit


def first_stress(material, f, old, new, tangent=True):
    """P (p, 2, 2) [MPa] of deformation gradients; fills new."""
    metric = np.einsum("pki,pkj->pij", f, f)
    columns = np.column_stack([metric[:, 0, 0], metric[:, 1, 1], metric[:, 0, 1]])
    material.update(columns, old, new, tangent=tangent)
    return f @ as_tensor(new.second_stress)


def as_tensor(s):
    """(p, 2, 2) of (p, 3) [11, 22, 12]."""
    return s[:, [0, 2, 2, 1]].reshape(-1, 2, 2)


def balance(material, f_a, normal, force, f0, jump, states, active):
    """Newton on P_A N = f0 P_B N for the jump c (p, 2). Returns it, and where it was found."""
    old, new = states
    jump = jump.copy()
    scale = np.linalg.norm(force, axis=1)
    error = np.full(len(jump), np.inf)
    for _ in range(12):
        f = f_a + jump[:, :, None] * normal[:, None, :]
        broken = active & ~(np.linalg.det(f) > 0.05)
        f[broken] = f_a[broken]
        p_n = (first_stress(material, f, old, new) @ normal[:, :, None])[:, :, 0]
        residual = force - f0 * p_n
        error = np.where(broken, np.inf, np.linalg.norm(residual, axis=1) / scale)
        if (error[active] < 1e-9).all():
            break
        # d(P N) = (N . S N) dc + F dS N, dE = sym(F^T dc N^T).
        s = as_tensor(new.second_stress)
        matrix = np.einsum("pi,pij,pj->p", normal, s, normal)[:, None, None] * np.eye(2)
        for j in range(2):
            v = f[:, j, :]  # F^T e_j
            strain = np.stack(
                [v[:, 0] * normal[:, 0], v[:, 1] * normal[:, 1], v[:, 0] * normal[:, 1] + v[:, 1] * normal[:, 0]],
                axis=1,
            )
            ds = as_tensor(np.einsum("pij,pj->pi", new.tangent, strain))
            matrix[:, :, j] += np.einsum("pij,pjk,pk->pi", f, ds, normal)
        matrix[~active] = np.eye(2)
        singular = ~(np.abs(np.linalg.det(matrix)) > 1e-12 * np.abs(matrix).max(axis=(1, 2)) ** 2)
        matrix[singular] = np.eye(2)
        change = np.linalg.solve(f0 * matrix, residual[:, :, None])[:, :, 0]
        size = np.linalg.norm(change, axis=1, keepdims=True)
        change *= np.minimum(1.0, 0.05 / np.maximum(size, 1e-300))
        jump[active & ~singular] += change[active & ~singular]
    return jump, error < 1e-6

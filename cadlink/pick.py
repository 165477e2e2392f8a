"""Faces of a part by what a person calls them: number, name in the CAD file, or colour."""

import re

import numpy as np

from cadlink.errors import CadError

HEX = re.compile(r"#[0-9a-fA-F]{6}")
SAME = 1.5 / 255.0  # colours this near in each of red, green and blue are one
LISTED = 8  # names or colours an error line lists


def pick_faces(part, faces):
    """Sorted indices (k,) of the faces meant.

    faces : None for all; a number, a name, a colour as "#rrggbb" or (r, g, b) in 0 .. 1; or a list of these. A name or
        colour stands for every face that has it.
    raises : CadError, one line, for a number, name or colour no face has
    """
    if faces is None:
        return np.arange(part.n_faces)
    if isinstance(faces, (str, int, np.integer)) or is_color(faces):
        faces = [faces]
    chosen = []
    for wanted in faces:
        if isinstance(wanted, (bool, np.bool_)):
            raise CadError(f"part {part.name!r}: face {wanted!r}, expected a number, a name or a colour")
        if isinstance(wanted, (int, np.integer)):
            if not 0 <= wanted < part.n_faces:
                raise CadError(f"part {part.name!r} has faces 0 to {part.n_faces - 1}, found {int(wanted)}")
            chosen.append([wanted])
        elif isinstance(wanted, str) and not HEX.fullmatch(wanted):
            chosen.append(of_name(part, wanted))
        elif isinstance(wanted, str) or is_color(wanted):
            chosen.append(of_color(part, wanted))
        else:
            raise CadError(f"part {part.name!r}: face {wanted!r}, expected a number, a name or a colour")
    if not chosen:
        raise CadError(f"part {part.name!r}: an empty list of faces, expected numbers, names or colours")
    return np.unique(np.concatenate(chosen)).astype(np.int64)


def is_color(value):
    """Whether a value is (r, g, b) in 0 .. 1, written with decimals."""
    return (
        isinstance(value, (tuple, list))
        and len(value) == 3
        and all(isinstance(c, (float, np.floating)) and 0.0 <= c <= 1.0 for c in value)
    )


def of_name(part, name):
    found = [i for i, called in enumerate(part.face_names) if called == name]
    if found:
        return found
    names = listed(dict.fromkeys(n for n in part.face_names if n))
    raise CadError(
        f"part {part.name!r}: no face {name!r}, expected {names or 'numbers or colours: its faces have no names'}"
    )


def of_color(part, color):
    wanted = rgb_of_hex(color) if isinstance(color, str) else color
    found = [
        i
        for i, have in enumerate(part.face_colors)
        if have is not None and max(abs(a - b) for a, b in zip(have, wanted, strict=True)) <= SAME
    ]
    if found:
        return found
    have = listed(dict.fromkeys(hex_of_rgb(c) for c in part.face_colors if c is not None))
    shown = color if isinstance(color, str) else hex_of_rgb(color)
    raise CadError(
        f"part {part.name!r}: no face of colour {shown}, expected {have or 'names: its faces have no colours'}"
    )


def listed(values):
    """The first few of some values, as "one of: a, b, .. (n in all)"."""
    values = [str(v) for v in values]
    if not values:
        return ""
    more = f", .. ({len(values)} in all)" if len(values) > LISTED else ""
    return "one of: " + ", ".join(values[:LISTED]) + more


def rgb_of_hex(text):
    return tuple(int(text[i : i + 2], 16) / 255.0 for i in (1, 3, 5))


def hex_of_rgb(color):
    return "#" + "".join(f"{round(255 * min(max(float(c), 0.0), 1.0)):02x}" for c in color)

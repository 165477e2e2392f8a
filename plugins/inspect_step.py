"""What a STEP file holds, part by part."""


def describe(path, thickness=None):
    """{"file", "unit", "parts": [{name, faces, kinds, size, low, high, color, radii, gaps, remarks}]}; lengths in mm.

    path : STEP file; thickness : mm of the sheet to be formed, or None. Raises cadlink.CadError where it cannot be
    read.
    """
    from cadlink import read_step

    assembly = read_step(path)
    parts = [describe_part(part, thickness) for part in assembly.values()]
    return {"file": str(path), "unit": assembly.unit, "parts": parts}


def describe_part(part, thickness=None):
    """One part as plain values; a radius is None where no face is curved that way."""
    gaps = part.gap_report(thickness)
    remarks = gaps.remarks()
    if part.sewn:
        left = f", {part.sewn.free_edges} edges stay free" if part.sewn.free_edges else ""
        remarks.insert(0, f"{part.sewn.faces} loose faces sewn within {part.sewn.tolerance:g} mm{left}")
    low, high = part.bounding_box
    return {
        "name": part.name,
        "solid": bool(part.solid),
        "faces": int(part.n_faces),
        "kinds": {kind: int(n) for kind, n in part.kinds.most_common()},
        "size": [float(length) for length in high - low],
        "low": [float(x) for x in low],
        "high": [float(x) for x in high],
        "smallest_concave_radius": radius(part.smallest_concave_radius),
        "smallest_convex_radius": radius(part.smallest_convex_radius),
        "color": hex_color(part.color),
        "edge_gap": max(gaps.edge, gaps.vertex),
        "smooth_edges": gaps.smooth_edges,
        "normal_jump": gaps.jump,
        "slivers": list(gaps.slivers),
        "remarks": remarks,
    }


def radius(value):
    """A finite radius [mm], or None."""
    return float(value) if value is not None and 0.0 < value < 1e9 else None


def hex_color(color):
    """#rrggbb of (r, g, b) between 0 and 1; None without a colour."""
    if color is None:
        return None
    return "#" + "".join(f"{round(255 * min(max(float(c), 0.0), 1.0)):02x}" for c in color[:3])


def parts_table(described):
    """A row per part, as a rich table."""
    from rich.markup import escape
    from rich.table import Table
    from rich.text import Text

    unit = described["unit"]
    shown_in = "" if unit == "mm" else ", shown in mm"
    table = Table(title=escape(f"{described['file']}: unit {unit}{shown_in}"), title_justify="left")
    table.add_column("part", overflow="fold")
    table.add_column("faces", justify="right")
    table.add_column("by kind")
    table.add_column(escape("size x, y, z [mm]"), justify="right", no_wrap=True)
    table.add_column(escape("smallest radius [mm]\nconcave"), justify="right")
    table.add_column("\nconvex", justify="right")
    table.add_column("colour")
    for part in described["parts"]:
        color = part["color"]
        table.add_row(
            escape(part["name"]),
            str(part["faces"]),
            ", ".join(f"{n} {kind}" for kind, n in part["kinds"].items()),
            " x ".join(f"{length:.6g}" for length in part["size"]),
            shown_radius(part["smallest_concave_radius"]),
            shown_radius(part["smallest_convex_radius"]),
            Text.assemble(("██ ", color), color) if color else "",
        )
    return table


def remarks_on(described):
    """Lines on how well faces meet: one for the file, one for each part that a user should look at."""
    parts = described["parts"]
    gap, jump = max(part["edge_gap"] for part in parts), max(part["normal_jump"] for part in parts)
    lines = [f"Faces meet within {gap:.1e} mm, smooth ones within {jump:.1e} degrees."]
    return lines + [f"{part['name']}: {'; '.join(part['remarks'])}" for part in parts if part["remarks"]]


def shown_radius(value):
    return "-" if value is None else f"{value:.4g}"

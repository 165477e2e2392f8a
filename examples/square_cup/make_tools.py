"""Writes the tools and the blank of the NUMISHEET'93 square cup as STEP assemblies.

    python examples/square_cup/make_tools.py [FOLDER]

    z up, mm        |     |
    holder   _______|     |_______     bottom at z = t
    BLANK    =====================     z = 0 ... t
    die      _______       _______     top at z = 0
                    \\     /            punch bottom at z = t, travels down by 40
                     |   |

Punch 70 x 70, profile radius 8, corner radius 10; die opening 74 x 74, profile radius 5, corner radius 12;
blank 150 x 150. Every face is a plane, a cylinder or a torus. square_cup.step has the aluminium's thickness,
0.81; square_cup_steel.step the mild steel's, 0.78.
"""

import re
import sys
from pathlib import Path

import cadquery as cq

PUNCH_WIDTH, PUNCH_CORNER, PUNCH_NOSE = 70.0, 10.0, 8.0
DIE_WIDTH, DIE_CORNER, DIE_SHOULDER = 74.0, 12.0, 5.0
HOLDER_EDGE = 2.0  # inner edge of the blank-holder; over the die shoulder, where it bears no load
BLANK_WIDTH = 150.0
TOOL_WIDTH = 180.0  # die and blank-holder, outside
PUNCH_HEIGHT, DIE_HEIGHT, HOLDER_HEIGHT = 70.0, 60.0, 20.0
THICKNESS = {"square_cup.step": 0.81, "square_cup_steel.step": 0.78}

COLOURS = "MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION"  # what STEP calls them
FULL = re.MULTILINE | re.DOTALL


def square_block(width, corner, bottom, height):
    """A square block about the z axis, its vertical edges rounded; corner 0 leaves them sharp."""
    block = cq.Workplane("XY", origin=(0, 0, bottom)).rect(width, width).extrude(height)
    return block.edges("|Z").fillet(corner) if corner else block


def make_punch(thickness):
    """The punch above the sheet; its nose is rounded all round."""
    return square_block(PUNCH_WIDTH, PUNCH_CORNER, thickness, PUNCH_HEIGHT).faces("<Z").edges().fillet(PUNCH_NOSE)


def make_die():
    """The die below z = 0; the upper edge of its opening is the shoulder."""
    opening = square_block(DIE_WIDTH, DIE_CORNER, -DIE_HEIGHT, DIE_HEIGHT)
    die = square_block(TOOL_WIDTH, 0.0, -DIE_HEIGHT, DIE_HEIGHT).cut(opening)
    return die.faces(">Z").edges(cq.selectors.BoxSelector((-50, -50, -1), (50, 50, 1))).fillet(DIE_SHOULDER)


def make_holder(thickness):
    """The blank-holder on the sheet: a ring with the die's opening, whose lower edge is rounded."""
    opening = square_block(DIE_WIDTH, DIE_CORNER, thickness, HOLDER_HEIGHT)
    ring = square_block(TOOL_WIDTH, 0.0, thickness, HOLDER_HEIGHT).cut(opening)
    inner = cq.selectors.BoxSelector((-50, -50, thickness - 1), (50, 50, thickness + 1))
    return ring.faces("<Z").edges(inner).fillet(HOLDER_EDGE)


def make_assembly(thickness):
    """PUNCH, DIE, BLANK_HOLDER and BLANK, in place at the start of the stroke."""
    assembly = cq.Assembly(name="SQUARE_CUP")
    assembly.add(make_punch(thickness), name="PUNCH", color=cq.Color(0.80, 0.36, 0.25))
    assembly.add(make_die(), name="DIE", color=cq.Color(0.36, 0.45, 0.58))
    assembly.add(make_holder(thickness), name="BLANK_HOLDER", color=cq.Color(0.58, 0.64, 0.52))
    blank = square_block(BLANK_WIDTH, 0.0, 0.0, thickness)
    assembly.add(blank, name="BLANK", color=cq.Color(0.85, 0.85, 0.88))
    return assembly


def write_step(assembly, path):
    """Writes a STEP file that is the same, byte for byte, whenever the geometry is."""
    assembly.export(str(path), exportType="STEP", write_pcurves=False)
    text = path.read_text()
    text = re.sub(r"'\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d'", "'1993-08-31T00:00:00'", text, count=1)
    path.write_text(sort_colours(exact_tori(text)))


def exact_tori(text):
    """Gives the nose's corners back as tori: radius 10 - 8 = 2 of the centre line, radius 8 of the tube.

    Open CASCADE writes a torus whose tube reaches over its axis as a B-spline turned about that axis, which
    is only near the torus; STEP's name for it is DEGENERATE_TOROIDAL_SURFACE, .T. for its outer part.
    """
    torus = f"{PUNCH_CORNER - PUNCH_NOSE:g}.,{PUNCH_NOSE:g}.,.T."
    for surface, curve, axis in re.findall(r"^#(\d+) = SURFACE_OF_REVOLUTION\('',#(\d+),#(\d+)\);", text, re.MULTILINE):
        points = re.search(rf"^#{curve} = B_SPLINE_CURVE_WITH_KNOTS\('',\d+,\((.*?)\)", text, FULL)[1]
        for number in (curve, *re.findall(r"#(\d+)", points)):
            text = re.sub(rf"^#{number} = .*?;\n", "", text, flags=FULL)
        text = re.sub(
            rf"^#{surface} = .*?;",
            f"#{surface} = DEGENERATE_TOROIDAL_SURFACE('',#{axis},{torus});",
            text,
            flags=FULL,
        )
        text = re.sub(
            rf"^#{axis} = AXIS1_PLACEMENT\((.*?)\);",
            rf"#{axis} = AXIS2_PLACEMENT_3D(\1,$);",
            text,
            flags=FULL,
        )
    return text


def sort_colours(text):
    """Puts the colours, which close the file in an order that varies by run, in that of their parts."""
    first = re.search(rf"^#(\d+) = {COLOURS}", text, FULL)
    end = text.index("ENDSEC;", first.start())
    groups = re.split(rf"^(?=#\d+ = {COLOURS})", text[first.start() : end], flags=FULL)[1:]
    groups.sort(key=lambda group: int(re.search(r"STYLED_ITEM\('color',\(#\d+\),#(\d+)", group)[1]))
    colours = "".join(groups)

    # number the records again, in their new order
    old = re.findall(r"^#(\d+) =", colours, FULL)
    new = {number: str(k) for k, number in enumerate(old, int(first[1]))}
    colours = re.sub(r"#(\d+)", lambda found: "#" + new.get(found[1], found[1]), colours)
    return text[: first.start()] + colours + text[end:]


def main(folder):
    """Writes both files into a folder."""
    for name, thickness in THICKNESS.items():
        write_step(make_assembly(thickness), folder / name)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)

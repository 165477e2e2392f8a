"""ParaView files: times, fields, tools, and what a stopped run leaves."""

import meshio
import numpy as np
import pytest
import pyvista

from plugins.vtk_files import PvdWriter, read_pvd


def written(path, cup, depths, **options):
    writer = PvdWriter(path, cup.scene, **options)
    for increment, depth in enumerate(depths):
        writer.write(cup.frame(depth, increment))
    return writer


def test_time_is_the_stroke_and_parts_are_named(cup, tmp_path):
    written(tmp_path / "cup.pvd", cup, (0.0, 1.25, 12.5)).close()
    reader = pyvista.PVDReader(tmp_path / "cup.pvd")
    assert reader.time_values == [0.0, 1.25, 12.5]
    names = {(entry.part, entry.name) for entry in read_pvd(tmp_path / "cup.pvd")}
    assert names == {(0, "sheet"), (1, "PUNCH"), (2, "DIE"), (3, "BLANK_HOLDER")}


def test_fields_come_back_bit_by_bit(cup, tmp_path):
    written(tmp_path / "cup.pvd", cup, (12.5,))
    frame = cup.frame(12.5)
    sheet = pyvista.read(tmp_path / "frames" / "cup_0000.vtu")
    assert np.array_equal(sheet.points, frame.points)
    assert np.array_equal(sheet.cells_dict[pyvista.CellType.TRIANGLE], cup.scene.blank.mesh.cells)
    for fields, data in ((frame.point_fields, sheet.point_data), (frame.cell_fields, sheet.cell_data)):
        assert set(data.keys()) == set(fields)
        for name, values in fields.items():
            assert np.array_equal(data[name], values), name
    assert sheet.field_data["stroke"][0] == 12.5
    assert list(sheet.field_data["symmetry"]) == ["x", "y"]


def test_data_sit_inline_where_other_readers_find_them(cup, tmp_path):
    written(tmp_path / "cup.pvd", cup, (12.5,))
    text = (tmp_path / "frames" / "cup_0000.vtu").read_text()
    assert 'format="binary"' in text
    assert "appended" not in text
    field_data = text[text.index("<FieldData>") : text.index("</FieldData>") + len("</FieldData>")]
    (tmp_path / "plain.vtu").write_text(text.replace(field_data, ""))  # meshio knows no texts
    sheet = meshio.read(tmp_path / "plain.vtu")
    assert np.array_equal(sheet.cell_data["thinning"][0], cup.frame(12.5).cell_fields["thinning"])


def test_a_tool_that_stands_still_is_written_once(cup, tmp_path):
    written(tmp_path / "cup.pvd", cup, (0.0, 10.0, 20.0))
    files = sorted(path.name for path in (tmp_path / "tools").iterdir())
    punch = [f"cup_PUNCH_{k:04d}.vtp" for k in range(3)]
    assert files == ["cup_BLANK_HOLDER_0000.vtp", "cup_DIE_0000.vtp", *punch]
    heights = [pyvista.read(tmp_path / "tools" / name).bounds[4] for name in punch]
    assert heights == pytest.approx([0.0, -10.0, -20.0])


def test_every_frame_leaves_a_complete_collection(cup, tmp_path):
    writer = written(tmp_path / "cup.pvd", cup, (0.0, 10.0))  # no close(): the run was killed
    assert len(read_pvd(tmp_path / "cup.pvd")) == 2 * 4
    assert all((tmp_path / entry.file).exists() for entry in writer.entries)
    assert not list(tmp_path.glob("*.part"))


def test_a_resumed_run_keeps_earlier_frames_and_replaces_later_ones(cup, tmp_path):
    path = tmp_path / "cup.pvd"
    written(path, cup, (0.0, 10.0, 20.0, 23.7))
    written(path, cup, (20.0, 30.0), resume=True).close()
    assert pyvista.PVDReader(path).time_values == [0.0, 10.0, 20.0, 30.0]
    assert all((tmp_path / entry.file).exists() for entry in read_pvd(path))


def test_a_new_run_removes_the_files_of_the_last(cup, tmp_path):
    path = tmp_path / "cup.pvd"
    written(path, cup, (0.0, 10.0, 20.0))
    (tmp_path / "frames" / "mine.txt").write_text("keep")
    written(path, cup, (0.0,))
    assert sorted(p.name for p in (tmp_path / "frames").iterdir()) == ["cup_0000.vtu", "mine.txt"]


def test_names_that_no_file_system_takes(cup, tmp_path):
    from plugins.vtk_files import _file_names

    assert _file_names(["A/B", "A B", "A_B"]) == {"A/B": "A_B", "A B": "A_B_", "A_B": "A_B__"}


def test_quadrilaterals_and_tools_without_a_part(cup, tmp_path):
    import dataclasses

    from plugins.vtk_files import write_sheet

    scene = cup.scene
    bare = [dataclasses.replace(t, surface=type(t.surface)(0.0, None)) for t in scene.stages[0].tools]
    scene = dataclasses.replace(scene, stages=[dataclasses.replace(scene.stages[0], tools=bare)])
    PvdWriter(tmp_path / "cup.pvd", scene).write(cup.frame(5.0))
    assert [entry.part for entry in read_pvd(tmp_path / "cup.pvd")] == [0]

    frame = dataclasses.replace(cup.frame(5.0), cell_fields={})
    write_sheet(tmp_path / "quad.vtu", frame, np.array([[0, 1, 14, 13]]))
    assert pyvista.read(tmp_path / "quad.vtu").celltypes.tolist() == [pyvista.CellType.QUAD]


def test_something_else_is_refused(tmp_path):
    (tmp_path / "a.pvd").write_text("<VTKFile><Collection><DataSet/></Collection></VTKFile>")
    with pytest.raises(ValueError, match=r"a.pvd: expected a .pvd collection"):
        read_pvd(tmp_path / "a.pvd")

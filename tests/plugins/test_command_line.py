"""The command `cadlink`: exit status, what goes to which stream, files of a run."""

import csv
import json
import signal
import subprocess
import sys
import time

import pytest

from plugins.command_line import main

HEAVY = ("OCP", "gmsh", "vtkmodules", "pyvista", "numba", "scipy", "matplotlib", "pydantic")
BULGE = """
name = "a cup"
[blank]
outline = {disc = 50}
size = 10
thickness = 0.8
draw_in = {DX = [1, 0, 0]}
[material]
young = 206000
poisson = 0.3
locus = "von Mises"
hardening = {swift = {K = 565, e0 = 0.007, n = 0.26}}
[[stages]]
pressure = 5
[output]
frames = 4
[compare]
source = "a laboratory"
rows = [{quantity = "draw_in_DX", stroke = 15, measured = 6.0}]
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(BULGE)
    return path


@pytest.fixture
def forming(cup, monkeypatch):
    """A solver that draws the cup by formula to 40 mm, or fails at `.fails_at`; keeps what it was asked."""
    import solver
    from plugins.scene_file import SceneFile
    from plugins.vtk_files import PvdWriter
    from solver.results import Progress, Results

    class Forming:
        fails_at = None
        error = None
        asked = None

        def __call__(self, scene, method=None, *, save=None, frames=40, watch=None, resume=False):
            self.asked = {"method": method, "save": save, "frames": frames, "resume": resume}
            results = Results(plan=scene.plan())
            writer = PvdWriter(save, scene, resume=resume)
            try:
                for k in range(1, frames + 1):
                    stroke = 40.0 * k / frames
                    if self.fails_at is not None and stroke > self.fails_at:
                        raise self.error or solver.StepFailed("increment 3: residual 1e-1 of 1e-6; use less")
                    writer.write(cup.frame(stroke, k))
                    results.record(stage="draw", increment=k, stroke=stroke, force_PUNCH=-1e3, draw_in_DX=stroke / 2)
                    watch(Progress("draw", k, stroke / 40.0, stroke, 4, 100, 0))
                results.finished = True
            except solver.StepFailed as failure:
                failure.results = results
                raise
            return results

    forming = Forming()
    monkeypatch.setattr(solver, "form", forming)
    monkeypatch.setattr(SceneFile, "build", lambda self: cup.scene)
    return forming


def test_help_is_quick_and_loads_nothing_heavy():
    code = "import sys; from plugins.command_line import main; "
    code += "print(main(['--help']), *sys.modules, file=sys.stderr)"
    start = time.perf_counter()
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    seconds = time.perf_counter() - start
    status, *modules = done.stderr.split()
    assert status == "0"
    assert not set(HEAVY) & set(modules)
    assert all(command in done.stdout for command in ("inspect", "check", "run", "show", "report"))
    assert seconds < 3.0  # 0.2 s where nothing else runs


@pytest.mark.parametrize("arguments", [["inspct", "a"], ["inspect"], ["run", "a.toml"], ["inspect", "a", "--jsn"]])
def test_wrong_usage_is_one_line_and_status_2(arguments, capsys):
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1 and err.startswith("cadlink: ")


def test_a_run_leaves_its_folder(scene, forming, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["run", str(scene), "-o", str(out)]) == 0
    names = {path.name for path in out.iterdir()}
    assert {"result.pvd", "frames", "tools", "history.csv", "summary.json", "run.log"} <= names
    assert forming.asked["frames"] == 4 and forming.asked["resume"] is False
    with open(out / "history.csv", newline="") as file:
        assert [float(row["stroke"]) for row in csv.DictReader(file)] == [10.0, 20.0, 30.0, 40.0]
    summary = json.loads((out / "summary.json").read_text())
    assert summary["finished"] is True
    assert summary["comparison"][0]["percent_off"] == pytest.approx(25.0)
    printed = capsys.readouterr()
    assert "+25.0 %" in printed.out and "a laboratory" in printed.out
    assert "40.00 of 40 mm, increment 4, 4 iterations, 100 contact nodes" in printed.err
    assert main(["report", str(out)]) == 0
    assert capsys.readouterr().out == printed.out
    assert main(["report", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == summary


def test_a_run_that_stops_early_says_how_to_go_on(scene, forming, tmp_path, capsys):
    forming.fails_at = 20.0
    out = tmp_path / "out"
    assert main(["run", str(scene), "-o", str(out)]) == 3
    err = capsys.readouterr().err
    assert "stopped at 20 mm of stroke: increment 3: residual 1e-1 of 1e-6; use less." in err
    assert f"cadlink run {scene} -o {out} --resume" in err
    summary = json.loads((out / "summary.json").read_text())
    assert (summary["finished"], summary["figures"]["stroke"]) == (False, 20.0)

    (out / "checkpoint.h5").touch()
    forming.fails_at = None
    assert main(["run", str(scene), "-o", str(out), "--resume"]) == 0
    assert forming.asked["resume"] is True


def test_resume_without_a_checkpoint(scene, forming, tmp_path, capsys):
    assert main(["run", str(scene), "-o", str(tmp_path / "out"), "--resume"]) == 2
    assert "checkpoint.h5: no such file, expected a run that stopped" in capsys.readouterr().err
    assert forming.asked is None


def test_ctrl_c_lets_the_increment_end(scene, forming, tmp_path, capsys, cup, monkeypatch):
    frame = cup.frame

    def interrupted(depth, increment):
        if depth == 20.0:
            signal.raise_signal(signal.SIGINT)
        return frame(depth, increment)

    monkeypatch.setattr(cup, "frame", interrupted)
    before = signal.getsignal(signal.SIGINT)
    assert main(["run", str(scene), "-o", str(tmp_path / "out")]) == 130
    assert signal.getsignal(signal.SIGINT) is before
    assert "stopped at 20 mm of stroke: stopped by the user." in capsys.readouterr().err


def test_an_unexpected_error_shows_no_traceback_but_keeps_it(scene, forming, tmp_path, capsys):
    forming.fails_at, forming.error = 10.0, ZeroDivisionError("division by zero")
    assert main(["run", str(scene), "-o", str(tmp_path / "out")]) == 1
    err = capsys.readouterr().err
    last = err.splitlines()[-1]
    assert "Traceback (most recent" not in err
    assert last.startswith("cadlink: unexpected ZeroDivisionError: division by zero. Traceback in ")
    kept = last.split(" in ")[1].split(";")[0]
    with open(kept) as file:
        assert "ZeroDivisionError" in file.read()
    assert "Traceback (most recent call last)" in (tmp_path / "out" / "run.log").read_text()
    with pytest.raises(ZeroDivisionError):
        main(["run", str(scene), "-o", str(tmp_path / "out"), "--debug"])


def test_show_and_plot(run_folder, capsys):
    assert main(["show", str(run_folder), "--png", str(run_folder / "a.png"), "--field", "thickness"]) == 0
    assert (run_folder / "a.png").exists()
    assert main(["report", str(run_folder), "--plot", str(run_folder / "b.png")]) == 0
    assert "not reached" in capsys.readouterr().out
    assert (run_folder / "b.png").exists()


@pytest.mark.parametrize(
    "arguments, said",
    [
        (["report", "nowhere"], "nowhere/summary.json: no such file, expected the folder of a run"),
        (["show", "nowhere", "--png", "a.png"], "nowhere/result.pvd: no such file"),
        (["run", "nowhere.toml", "-o", "out"], "nowhere.toml: no such file, expected a scene file"),
        (["check", "nowhere.toml"], "nowhere.toml: no such file, expected a scene file"),
    ],
)
def test_nothing_there_is_one_line_and_status_2(arguments, said, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    err = capsys.readouterr().err
    assert len(err.splitlines()) == 1 and said in err
    assert not list(tmp_path.iterdir())


def test_a_misspelt_key_is_one_line_and_status_2(scene, capsys, tmp_path):
    scene.write_text(BULGE.replace("thickness = 0.8", "thicknes = 0.8"))
    assert main(["run", str(scene), "-o", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == (f"cadlink: {scene}: blank.thicknes: unknown key; did you mean 'thickness'?\n")
    scene.write_text(BULGE.replace("thickness = 0.8", 'thickness = "-0.8 mm"'))
    assert main(["check", str(scene)]) == 2
    err = capsys.readouterr().err
    assert err.startswith(f'cadlink: {scene}: blank.thickness: found "-0.8 mm", expected a length above 0 in mm')
    assert len(err.splitlines()) == 1

"""The scripts and the notebook of docs/examples run as they are, in a folder of their own, and write what they say."""

import ast
import json
import runpy
import shutil
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    shutil.copytree(EXAMPLES, tmp_path / "examples")
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    mpl.use("Agg")
    plt.close("all")  # matplotlib counts what other tests have left open
    return tmp_path


@pytest.mark.long
@pytest.mark.filterwarnings("error")
def test_the_study_of_a_spur_pair(folder, capsys):
    names = runpy.run_path(str(folder / "examples" / "spur_pair_study.py"))
    assert {p.name for p in Path.cwd().iterdir()} == {"pair.png", "spectrum.png", "speeds.csv", "speeds.png"}
    spectrum, study = names["run"].spectrum("mesh.force", after=0.02), names["study"]
    mesh_frequency = 23 * 50.0
    assert abs(spectrum.frequency[2 + spectrum.amplitude[2:].argmax()] / mesh_frequency - 1) < 0.01
    assert len(study) == 69
    assert (study.values > 0).all()
    assert "w0 = -23*speed/41 rad/s" in capsys.readouterr().out


@pytest.mark.long
@pytest.mark.filterwarnings("error")
def test_the_variants_of_a_driveline(folder, capsys):
    names = runpy.run_path(str(folder / "examples" / "driveline_variants.py"))
    assert {p.name for p in Path.cwd().iterdir()} == {"cruise.png", "variants.csv", "cruise.fmu"}
    study, best = names["study"], names["best"]
    assert len(study) == 200
    assert study.values[best, 1] < 450.0
    assert (study.values[names["gentle"], 0] >= study.values[best, 0]).all()
    assert "cruise.fmu: passed" in capsys.readouterr().out


@pytest.mark.filterwarnings("error")
def test_the_notebook_of_the_course(folder):
    """Its cells one after the other; what stands last in a cell shows itself as a drawing or as HTML, or is a picture."""
    notebook = json.loads((EXAMPLES / "course.ipynb").read_text(encoding="utf-8"))
    names: dict[str, object] = {}
    shown: dict[str, object] = {}
    for cell in notebook["cells"]:
        assert not cell.get("outputs"), "kept without its outputs"
        body = ast.parse("".join(cell["source"])).body if cell["cell_type"] == "code" else []
        last = body.pop() if body and isinstance(body[-1], ast.Expr) else None
        exec(compile(ast.Module(body, []), "cell", "exec"), names)  # noqa: S102  our own notebook
        if last is not None:
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)  # noqa: S307
            shown[type(value).__name__] = value
    assert "<svg" in shown["Drivetrain"]._repr_svg_()
    assert all("<table" in shown[name]._repr_html_() for name in ("Equations", "Modes", "Study"))
    events = [event.component for event in names["rough"].events]
    assert not [event for event in names["run"].events if event.component == "mesh"]
    assert events.count("mesh") > 100

"""What a user types in a shell, and what comes back: text, files and exit status."""

from __future__ import annotations

import csv
import re
import shlex
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

import gearblocks
from gearblocks.cli.main import main
from gearblocks.cli.terminal import in_the_shell
from gearblocks.cli.typed import EXAMPLES
from gearblocks.simulation.trajectory import Trajectory

SCRIPT = '''"""A motor that swings against the ground through a shaft."""

import gearblocks as gb


def build() -> gb.Drivetrain:
    """One inertia, one shaft."""
    rig = gb.Drivetrain("swing")
    load = rig.add("load", gb.Torque(tau=3.0))
    motor = rig.add("motor", gb.Inertia(J=0.5))
    shaft = rig.add("shaft", gb.Shaft(k=200.0, c=0.1))
    wall = rig.add("wall", gb.Fixed())
    rig.chain(load, motor, shaft, wall)
    return rig


def stiff() -> gb.Drivetrain:
    """The same with a stiffer shaft."""
    return build().set({"shaft.k": 2000.0})


def needs(k: float) -> gb.Drivetrain:
    """Wants a number."""
    return build().set({"shaft.k": k})


def helper(x: float) -> float:
    return x


def swings() -> gb.Scene:
    """How far it swings."""
    return gb.Scene(
        build(), t_end=0.2, quantity=gb.peak("shaft.twist"), parameters={"shaft.k": 150.0}, initial={"motor.w": 2.0}
    )


def broken() -> gb.Drivetrain:
    return undefined_name
'''

COMMANDS = (
    "demo", "new", "copy", "list", "doc", "describe", "outputs", "parameters", "inputs", "run", "cost", "effects", "sweep",
    "equations", "draw", "export", "check", "hard",
)  # fmt: skip


@pytest.fixture
def script(tmp_path: Path) -> Path:
    folder = tmp_path / "Prüfstand mit Lücke"
    folder.mkdir()
    path = folder / "swing.py"
    path.write_text(SCRIPT, encoding="utf-8")
    return path


def said(capsys: pytest.CaptureFixture[str]) -> tuple[str, str]:
    streams = capsys.readouterr()
    assert "Traceback" not in streams.err
    return streams.out, streams.err


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    out, _ = said(capsys)
    assert all(f"\n  {command} " in out for command in COMMANDS)


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_every_command_answers_a_short_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*command.split(), "-h"]) == 0
    out, _ = said(capsys)
    assert out.startswith(f"Usage: gearblocks {command}".strip())


def test_the_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    out, _ = said(capsys)
    assert out == f"gearblocks {gearblocks.__version__}\n"


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys; from gearblocks.cli.main import main; main(['--help'])\n"
        "print([m for m in ('sympy', 'matplotlib', 'scipy', 'xarray', 'fmpy', 'jinja2', 'pandas') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.endswith("[]\n")


def test_shipped_models_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list"]) == 0
    out, _ = said(capsys)
    assert "spline_coupling  " in out


def test_python_runs_the_shell_as_a_module() -> None:
    command = [sys.executable, "-m", "gearblocks", "list"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert "spline_coupling  " in done.stdout and not done.stderr


def test_the_trains_of_a_script_are_listed(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", str(script)]) == 0
    out, _ = said(capsys)
    lines = out.splitlines()
    assert lines[0].endswith("One inertia, one shaft.") and ":build " in lines[0]
    assert ":stiff " in out and "helper" not in out and "needs" not in out
    assert ":stiff   train  The same" in out and ":swings  scene  How far it swings." in lines[-1]


def test_a_run_is_told_and_stored(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stored = script.with_name("lauf 1.csv")
    assert main(["run", str(script), "--t-end", "0.2", "--out", str(stored)]) == 0
    out, _ = said(capsys)
    assert "energy residual" in out and "shaft.twist" in out and str(stored) in out
    with stored.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert rows[0][0] == "t" and "shaft.twist" in rows[0]
    assert float(rows[-1][0]) == 0.2


def test_a_run_is_explained(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(script), "--t-end", "0.2", "--explain"]) == 0
    out, _ = said(capsys)
    assert "'swing' took" in out and "limited by" in out
    assert "  shaft " in out  # the element that moves the states, not their owner


@pytest.mark.parametrize("ending", [".nc", ".json"])
@pytest.mark.few(1)
def test_a_stored_run_can_be_loaded(script: Path, ending: str) -> None:
    stored = script.with_suffix(ending)
    assert main(["run", f"{script}:stiff", "--t-end", "0.1", "--out", str(stored), "--outputs", "shaft.*"]) == 0
    run = Trajectory.load(stored)
    assert run.t[-1] == 0.1 and "shaft.twist" in run and "motor.w" not in run


def test_a_parameter_is_set_and_an_effect_left_out(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stored = script.with_suffix(".json")
    changes = ["--set", "shaft.k=50", "--without", "shaft.damping"]
    assert main(["run", str(script), "--t-end", "0.3141592653589793", *changes, "--out", str(stored)]) == 0
    twist = Trajectory.load(stored)["shaft.twist"]
    # undamped from rest, half a period of sqrt(50 / 0.5) = 10 rad/s: twice the static twist; 1e-5 is ten times rtol
    assert twist[-1] == pytest.approx(-2 * 3.0 / 50.0, rel=1e-5)


def test_a_picture_is_made(script: Path) -> None:
    picture = script.with_name("bild.png")
    assert main(["run", str(script), "--t-end", "0.1", "--plot", str(picture)]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("form", "part"),
    [("text", "shaft"), ("latex", "\\"), ("html", "<math"), ("mathml", "<math"), ("c", "gb_get_model")],
)
def test_equations_are_printed(script: Path, form: str, part: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["equations", str(script), "--format", form]) == 0
    out, _ = said(capsys)
    assert part in out


def test_equations_and_checked_fmus_are_those_of_the_changed_train(
    script: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change = ["--set", "shaft.k=50", "--without", "shaft.damping"]
    assert main(["equations", str(script), *change]) == 0
    out, _ = said(capsys)
    assert "damping" not in out and re.search(r"k_shaft +stiffness +50 N m/rad|k_shaft .* 50 ", out)
    fmu = script.with_suffix(".fmu")
    assert main(["export", str(script), "-o", str(fmu), *change]) == 0
    with zipfile.ZipFile(fmu) as packed:
        described = packed.read("modelDescription.xml").decode()
    assert "shaft.c" not in described
    assert re.search(r'name="shaft.k".*?start="50(\.0)?"', described, re.S)
    assert main(["check", str(fmu)]) == 0
    out, _ = said(capsys)
    assert str(fmu) in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "no_such_model"], "no shipped model 'no_such_model'"),
        (["run", "spline_couplin"], "did you mean 'spline_coupling'"),
        (["run", "nowhere/rig.py"], "there is no file 'nowhere/rig.py'"),
        (["run", "{script}:biuld"], "has no function 'biuld'"),
        (["run", "{script}:needs"], "needs k"),
        (["run", "{script}:helper"], "needs x"),
        (["run", "{script}:broken"], "swing.py, line 39: NameError"),
        (["run", "{script}", "--set", "shaft.k"], "--set shaft.k: what is asked for is path=number"),
        (["run", "{script}", "--set", "shaft.k=stiff"], "path=number"),
        (["run", "{script}", "--set", "shaft.kk=3"], "shaft.kk"),
        (["run", "{script}", "--without", "mesh.*"], "mesh.*"),
        (["run", "{script}", "--t-end", "-1"], "t_end"),
        (["run", "{script}", "--method", "euler"], "euler"),
        (["run", "{script}", "--initial", "rest"], "rest"),
        (["run", "{script}", "--rtol", "nan"], "rtol"),
        (["run", "{script}", "--outputs", "mesh.*"], "mesh.*"),
        (["run", "{script}", "--out", "x.xls"], ".csv, .nc, .json"),
        (["run", "{script}", "--out", "nowhere/x.csv"], "there is no folder 'nowhere'"),
        (["run", "{script}", "--plot", "x.gif"], ".png, .svg, .pdf"),
        (["equations", "{script}", "--format", "word"], "word"),
        (["export", "{script}", "-o", "x.fmu", "--fmi", "4.0"], "4.0"),
        (["export", "{script}", "-o", "x.fmu", "--platform", "amiga"], "amiga"),
        (["check", "no.fmu"], "there is no file 'no.fmu'"),
        (["run"], "FILE"),
        (["simulate"], "simulate"),
    ],
)
def test_bad_input_is_one_clear_message(
    script: Path, arguments: list[str], words: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(script.parent)
    assert main([item.replace("{script}", script.name) for item in arguments]) == 2
    out, err = said(capsys)
    assert words in err and not out
    assert [path.name for path in script.parent.iterdir() if path.name != "__pycache__"] == [script.name]


def test_an_error_in_a_script_names_its_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "rig.py"
    path.write_text("def build(:\n", encoding="utf-8")
    assert main(["run", str(path)]) == 2
    _, err = said(capsys)
    assert "rig.py, line 1:" in err
    path.write_text("import gearblocks\n\n1 / 0\n", encoding="utf-8")
    assert main(["run", str(path)]) == 2
    _, err = said(capsys)
    assert "rig.py, line 3: ZeroDivisionError" in err


def test_a_bad_train_is_told_with_all_its_problems(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "rig.py"
    path.write_text(
        "import gearblocks as gb\n"
        "def build():\n"
        "    rig = gb.Drivetrain('x')\n"
        "    rig.add('m', gb.Inertia(J=-1.0))\n"
        "    return rig\n",
        encoding="utf-8",
    )
    assert main(["run", str(path)]) == 2
    _, err = said(capsys)
    assert "Inertia 'm'" in err and "-1.0" in err


def test_a_file_that_is_no_fmu_fails_its_check(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "x.fmu"
    path.write_bytes(b"this is no zip")
    assert main(["check", str(path)]) in (1, 2)
    said(capsys)


def test_a_run_can_start_in_the_static_equilibrium(script: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(script), "--t-end", "0.5", "--initial", "static", "--outputs", "shaft.twist"]) == 0
    out, _ = said(capsys)
    assert "shaft.twist  -0.015 rad" in out  # 3 N m on 200 N m/rad, and nothing moves
    assert main(["run", str(script), "--initial", "balanced"]) == 2
    _, err = said(capsys)
    assert "--initial balanced: must be one of rolling, static" in err


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (["describe"], r"shaft +Shaft +k = 150 N m/rad"),
        (["outputs", "shaft.*"], r"shaft.twist +rad +\w"),
        (["parameters"], r"shaft.k +150 +N m/rad +torsional stiffness"),
        (["inputs"], "no inputs"),
    ],
)
def test_what_a_train_has_is_listed(
    script: Path, command: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([command[0], str(script), *command[1:], "--set", "shaft.k=150"]) == 0
    out, err = said(capsys)
    assert re.search(words, out) and err == ""


def test_messages_name_in_the_shell_what_can_be_typed_there() -> None:
    told = {
        "rig.describe() lists all values": "`gearblocks describe FILE` lists all values",
        "make one study for each rig.set({'gear.ratio': ...})": "make one study for each --set gear.ratio=VALUE",
        "enters a ratio: give a plain number, and another one with rig.set(...)": "enters a ratio: give a plain number, and "
        "another one with --set PATH=VALUE",
        'or leave it out: rig.without("mesh.compliance")': 'or leave it out: --without "mesh.compliance"',
        "rig.outputs() and rig.inputs() list": "`gearblocks outputs FILE` and `gearblocks inputs FILE` list",
        "nothing of Python": "nothing of Python",
    }
    assert [in_the_shell(words) for words in told] == list(told.values())


def test_every_command_that_needs_something_says_so_with_a_call_that_is_right(
    capsys: pytest.CaptureFixture[str],
) -> None:
    needing = {c for c in COMMANDS if c not in ("demo", "list", "doc", "hard")}
    assert set(EXAMPLES) == needing
    for command in needing:
        assert main([command]) == 2
        _, err = said(capsys)
        assert err.startswith(f"gearblocks: {command}: ") and err.rstrip().endswith(
            f" is missing; for example: {EXAMPLES[command]}"
        )
        options = [x for x in shlex.split(EXAMPLES[command]) if x.startswith("-")]
        assert main([command, "-h"]) == 0
        out, _ = said(capsys)
        assert all(option in out for option in options)

"""`gearblocks sweep`: a grid in a shell."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

import gearblocks as gb
from gearblocks.cli.main import main

SCRIPT = '''
import gearblocks as gb


def build() -> gb.Drivetrain:
    """One inertia, one shaft, a torque that follows its own speed."""
    rig = gb.Drivetrain("swing")
    motor = rig.add("motor", gb.Inertia(J=0.5, w0=1.0))
    load = rig.add("load", gb.Torque(tau=gb.Parameter("gain", 0.0, "N m s/rad") * gb.sense("motor.w")))
    rig.chain(load, motor, rig.add("shaft", gb.Shaft(k=200.0, c=0.1)), rig.add("wall", gb.Fixed()))
    return rig
'''


@pytest.fixture
def script(tmp_path: Path) -> str:
    (tmp_path / "swing.py").write_text(SCRIPT, encoding="utf-8")
    return str(tmp_path / "swing.py")


def test_a_sweep_writes_a_table_everything_and_a_picture(
    script: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = [
        "--over",
        "shaft.k=100:200:3",
        "--over",
        "motor.J=0.5:1:2",
        "--of",
        "peak(motor.phi)",
        "--of",
        "last(motor.w)",
    ]
    assert main(["sweep", script, *arguments, "--t-end", "0.5", "--out", str(tmp_path / "out"), "--jobs", "2"]) == 0
    text = capsys.readouterr().out
    assert "3 x 2 points over shaft.k, motor.J" in text and "peak(motor.phi): " in text
    rows = [*csv.reader((tmp_path / "out" / "study.csv").read_text().splitlines())]
    assert rows[0] == ["shaft.k", "motor.J", "peak(motor.phi)", "last(motor.w)", "message"]
    stored = gb.Study.load(tmp_path / "out" / "study.nc")
    assert stored.shape == (3, 2) and [float(x) for x in rows[4][:4]] == [*stored.points[3], *stored.values[3]]
    scope: dict[str, gb.Drivetrain] = {}
    exec(SCRIPT, scope)  # noqa: S102  the script above
    run = gb.simulate(scope["build"](), t_end=0.5, parameters={"shaft.k": 150.0, "motor.J": 1.0})  # type: ignore[operator]
    assert stored.values[3].tolist() == [gb.peak("motor.phi").of(run), run["motor.w"][-1]]
    assert (tmp_path / "out" / "study.png").stat().st_size > 10_000


def test_the_ends_of_a_range_bring_their_unit(script: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = []
    for ends in ("100:200", "0.1 kN m:0.2 kN m"):
        assert main(["sweep", script, "--over", f"shaft.k={ends}:3", "--of", "peak(motor.phi)", "--t-end", "0.5"]) == 0
        found.append([line for line in capsys.readouterr().out.splitlines() if "peak(motor.phi)" in line])
    assert found[0] == found[1] != []


def test_an_output_stands_for_its_peak_trough_and_rms(script: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert (
        main(["sweep", script, "--over", "k=100:200:2", "--of", "motor.w", "--t-end", "0.1", "--set", "shaft.c=0.2"])
        == 0
    )
    text = capsys.readouterr().out
    assert all(f"{word}(motor.w)" in text for word in ("peak", "trough", "rms"))
    assert main(["sweep", script, "--over", "k=100:200:2", "--t-end", "0.1"]) == 0
    assert "rms(shaft.twist)" in capsys.readouterr().out


@pytest.mark.parametrize("ending", [".csv", ".nc", ".png"])
def test_one_file_is_written_where_one_is_named(script: str, tmp_path: Path, ending: str) -> None:
    place = tmp_path / f"study{ending}"
    assert main(["sweep", script, "--over", "k=100:200:2", "--t-end", "0.1", "--out", str(place)]) == 0
    assert place.is_file()


def test_failing_points_are_named_and_the_others_stand(script: str, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--of", "last(motor.w)", "--t-end", "1"]
    assert main(["sweep", script, "--over", "gain=0:1e4:2", *arguments]) == 0
    captured = capsys.readouterr()
    assert "1 point failed" in captured.out and "gearblocks: gain = 10000: " in captured.err
    assert main(["sweep", script, "--over", "gain=1e4:2e4:2", *arguments]) == 1


def test_a_store_goes_on_where_it_was(script: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("zarr")
    arguments = ["sweep", script, "--over", "k=100:200:4", "--t-end", "0.1", "--store", str(tmp_path / "out.zarr")]
    assert main(arguments) == main(arguments) == 0
    assert main([*arguments, "--rtol", "1e-8"]) == 2
    assert "holds another study (what differs: the method or tolerance)" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--over", "k=1:2"], "path=from:to:n"),
        (["--over", "k=1:2:x"], "path=from:to:n"),
        (["--over", "k=1:2:0"], "must be >= 1"),
        (["--over", "k=1mm:2m:3"], "both ends must be in one unit, not in mm and m"),
        (["--over", "shaft.k=1mm:2mm:3"], "but what belongs here is in N m/rad"),
        (["--over", "k=1:2:3", "--over", "k=1:2:3"], "given twice"),
        (["--over", "kk=1:2:3"], "there is no parameter, start value or input 'kk'"),
        (["--over", "k=1:2:3", "--of", "motor.ww"], "did you mean 'motor.w'"),
        (["--over", "k=1:2:3", "--of", "loud(motor.w)"], "is no quantity"),
        (["--over", "k=1:2:3", "--of", "peak(motor.w, after=2)"], "after = 2 s"),
        (["--over", "k=1:2:3", "--out", "x.txt"], "--out x.txt"),
        (["--over", "k=1:2:3", "--out", "no/such/folder"], "there is no folder"),
        (["--over", "k=1:2:3", "--jobs", "0"], "0 must be a whole number >= 1"),
    ],
)
def test_bad_input_is_one_clear_message(
    script: str, arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sweep", script, *arguments]) == 2
    assert words in capsys.readouterr().err

"""The same question at other loads and speeds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.scenes.neighbours import neighbours


def _rig(tau: Any, w: Any = None, **capacity: Any) -> gb.Drivetrain:
    rig = gb.Drivetrain("driven")
    disc = rig.add("disc", gb.Inertia(J=0.1, w0=2.0))
    rig.chain(disc, rig.add("shaft", gb.Shaft(k=50.0, c=0.1)), rig.add("end", gb.Inertia(J=0.1, w0=2.0)))
    if tau is not None:
        rig.connect(rig.add("drive", gb.Torque(tau=tau)).flange, disc.b)
    if w is not None:
        rig.chain(rig.add("turn", gb.Speed(w=w)), rig.add("belt", gb.Shaft(k=5.0, c=0.1)), rig["disc"])
    if capacity:
        rig.connect(rig.add("brake", gb.Brake(**capacity)).a, rig["end"].b)
    return rig


def _around(rig: gb.Drivetrain, **more: Any) -> dict[str, gb.Scene]:
    return dict(neighbours(gb.Scene(rig, t_end=0.2, quantity=gb.last("disc.w"), **more)))


def _last(scene: gb.Scene) -> float:
    run = gb.simulate(
        scene.drivetrain, t_end=scene.end, parameters=scene.parameters, inputs=scene.inputs, initial=scene.initial,
        rtol=1e-10, outputs=["disc.w", "end.w"],
    )  # fmt: skip
    return float(run["disc.w"][-1] + run["end.w"][-1])


TABLE = gb.Table([0.0, 0.2], [2.0, 4.0])
LOAD = gb.Input("tau", start=3.0, unit="N m")


@pytest.mark.parametrize(
    ("tau", "more"),
    [
        (3.0, {}),
        (2.0 + 2.0 * gb.time / 0.2, {}),
        (gb.Parameter("load", 3.0, "N m"), {}),
        (gb.Parameter("load", 1.0, "N m"), {"parameters": {"load": 3.0}}),
        (gb.Parameter("load", 1.0, "N m"), {"parameters": {"load": "3000 N mm"}}),
        (gb.Parameter("load", 1.0, "N m"), {"parameters": {"load": "3e0 N m"}}),
        (1.0, {"parameters": {"drive.tau": 3.0}}),
        (LOAD, {}),
        (LOAD, {"inputs": {"tau": 3.0}}),
        (LOAD, {"inputs": {"tau": TABLE}}),
        (LOAD, {"inputs": {"tau": ([0.0, 0.2], [2.0, 4.0])}}),
        (LOAD, {"inputs": {"tau": lambda t: 2.0 + 10.0 * t}}),
    ],
    ids=[
        "number",
        "law",
        "Parameter",
        "its value",
        "text",
        "text again",
        "path",
        "start",
        "input",
        "table",
        "series",
        "function",
    ],
)
def test_a_load_is_scaled_however_it_is_given(tau: Any, more: Any) -> None:
    around = _around(_rig(tau), initial={"disc.w": 0.0, "end.w": 0.0}, **more)
    # sum of the momenta over J: 3 N m x 0.2 s/0.1 kg m2 = 6 rad/s
    assert _last(around["load -10 %"]) == pytest.approx(5.4, rel=1e-6)
    assert _last(around["load +10 %"]) == pytest.approx(6.6, rel=1e-6)


MAP = gb.Table2([0.0, 100.0], [0.0, 1.0], [[0.0, 2.0], [0.0, 2.0]])


@pytest.mark.parametrize(
    ("source", "what", "expected"),
    [
        (gb.SpeedLoad(coeffs=(0.5, 0.0, 0.0), direction="backward"), "load", -0.5),
        (gb.SpeedLoad(coeffs=(gb.Parameter("dry", 0.5, "N m"), 0.0, 0.0), direction="backward"), "load", -0.5),
        (gb.SpeedLoad(coeffs=(0.0, gb.Parameter("oil", 0.25, "N m s/rad"), 0.0)), "load", -0.5),
        (gb.Engine(torque_map=MAP, throttle=1.0), "load", 2.0),
        (gb.EddyCurrentBrake(tau_nominal=0.5, w_nominal=2.0), "load", -0.5),
        (gb.Governor(target=10.0, gain=0.05), "speed", 0.4),
    ],
    ids=["load over speed", "its Parameter", "its slope", "engine", "eddy currents", "governor"],
)
def test_loads_over_speed_engines_and_governors_are_scaled(source: gb.Block, what: str, expected: float) -> None:
    rig = _rig(None)
    rig.connect(rig.add("source", source).flange, rig["disc"].b)
    start = {"disc.w": 2.0, "end.w": 2.0}
    around = _around(rig, initial=start)
    output = "source.command" if isinstance(source, gb.Governor) else "source.torque"
    for share in (0.9, 1.1):
        scene = around[f"{what} {100 * (share - 1):+.0f} %"]
        run = gb.simulate(scene.drivetrain, t_end=1e-9, initial=start, parameters=scene.parameters)
        rest = 0.05 * 2.0 if what == "speed" else 0.0  # the governed speed at the start is that of `start`
        assert run[output][0] + rest == pytest.approx(share * (expected + rest), rel=1e-6)


def test_what_is_no_load_stays() -> None:
    rig = _rig(3.0, capacity=gb.Input("pressure", start=0.5, unit="N m"))
    scene = _around(rig, inputs={"pressure": 0.7})["load -10 %"]
    assert scene.inputs["pressure"] == 0.7
    assert "load -10 %" not in _around(_rig(None))


@pytest.mark.parametrize(
    ("initial", "expected"),
    [(None, 2.0), ({"disc.w": 3.0, "end.w": 3.0}, 3.0), ({"disc.w": "30 rad/s", "end.w": 30.0}, 30.0)],
)
def test_start_speeds_are_scaled_however_they_are_given(initial: Any, expected: float) -> None:
    around = _around(_rig(None, w=0.0), initial=initial)
    for words, share in (("speed -10 %", 0.9), ("speed +10 %", 1.1)):
        scene = around[words]
        run = gb.simulate(scene.drivetrain, t_end=1e-6, initial=scene.initial)
        assert run["disc.w"][0] == pytest.approx(share * expected, rel=1e-9)


def test_prescribed_speeds_are_scaled() -> None:
    scene = _around(_rig(None, w=gb.Table([0.0, 1.0], [2.0, 3.0])))["speed +10 %"]
    run = gb.simulate(scene.drivetrain, t=np.array([0.0, 0.1]))
    assert run["belt.twist_rate"][0] == pytest.approx(0.0, abs=1e-9)


def test_a_train_without_load_and_speed_has_no_neighbours() -> None:
    rig = gb.Drivetrain("free")
    rig.chain(
        rig.add("disc", gb.Inertia(J=0.1, phi0=0.1)), rig.add("shaft", gb.Shaft(k=5.0)), rig.add("wall", gb.Fixed())
    )
    assert not _around(rig)


def test_start_speeds_alone_are_a_speed_to_vary() -> None:
    around = _around(_rig(None))
    assert set(around) == {"speed -10 %", "speed +10 %"}
    assert [rig["disc"].w0 for rig in (scene.drivetrain for scene in around.values())] == pytest.approx([1.8, 2.2])


def test_misspelt_and_unnamed_arguments_of_a_scene_are_told() -> None:
    rig = _rig(3.0)
    with pytest.raises(gb.ParameterError, match=r"Scene has no argument 'quantiy'.*did you mean 'quantity'"):
        gb.Scene(rig, t_end=0.2, quantiy=gb.last("disc.w"))  # type: ignore[call-arg]
    with pytest.raises(gb.ParameterError, match=r"Scene: 0\.2 is given without a name"):
        gb.Scene(rig, 0.2, quantity=gb.last("disc.w"))  # type: ignore[misc]

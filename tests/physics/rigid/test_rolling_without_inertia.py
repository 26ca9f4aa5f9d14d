"""Rolling starts of trains in which friction, locks and lossy gears stand beside shafts without inertia."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gearblocks as gb

W = gb.rpm(3000)
EFFICIENT = {"efficiency": (0.9, 0.85)}


def _shaft(c: float = 7.88) -> gb.Shaft:
    return gb.Shaft(k=5750.0, c=c)


ROWS: dict[str, tuple[float, Any]] = {
    "clutch, shaft": (1.0, lambda: [gb.Clutch(capacity=100.0), _shaft()]),
    "shaft, clutch": (1.0, lambda: [_shaft(), gb.Clutch(capacity=100.0)]),
    "shaft, clutch, lash": (1.0, lambda: [
        _shaft(), gb.Clutch(mu=0.3, force_max=9.0, engagement=1.0), gb.Lash(k=1e4, half_gap=0.01, c=1.0),
    ]),
    "clutch that fades": (1.0, lambda: [gb.Clutch(capacity=gb.Table([0, 1], [100.0, 0.0])), _shaft()]),
    "clutch, gear, shaft": (2.0, lambda: [gb.Clutch(capacity=100.0), gb.IdealGear(ratio=2), _shaft()]),
    "one-way clutch": (1.0, lambda: [_shaft(), gb.OneWayClutch(capacity=9.0)]),
    "freewheel": (1.0, lambda: [gb.Freewheel(), _shaft()]),
    "dog": (1.0, lambda: [gb.DogClutch(engaged=1.0), _shaft()]),
    "gearbox": (3.0, lambda: [gb.Gearbox(ratio=3, **EFFICIENT, k=1e4, c=1.0, half_gap=0.01)]),
    "lossy gear, shaft": (-2.0, lambda: [gb.LossyGear(ratio=-2, **EFFICIENT), _shaft()]),
    "shaft, lossy gear, shaft": (-2.0, lambda: [
        _shaft(), gb.LossyGear(ratio=-2, **EFFICIENT, bearing=(0.3, 0.3)), _shaft(1.0),
    ]),
}  # fmt: skip


def _train(row: str) -> gb.Drivetrain:
    rig = gb.Drivetrain(row)
    parts = [rig.add(f"part{i}", block) for i, block in enumerate(ROWS[row][1]())]
    rig.chain(rig.add("motor", gb.Inertia(J=0.24)), *parts, rig.add("load", gb.Inertia(J=0.16)))
    return rig


@pytest.mark.parametrize("row", ROWS)
def test_what_is_beyond_turns_along(row: str) -> None:
    """Unloaded, it turns on as it is, whichever end is named."""
    ratio, model = ROWS[row][0], gb.build(_train(row))
    lost = 0.3 * 0.05 / 0.24 if "lossy gear, shaft" in row and row.startswith("shaft") else 0.0  # its bearing brakes
    for method in ("auto", "rodas"):
        run = gb.simulate(model, t_end=0.05, initial=gb.rolling({"motor.w": W}), method=method)
        assert run["motor.w"][0] == pytest.approx(W, rel=1e-15)
        assert run["load.w"][0] == pytest.approx(W / ratio, rel=1e-15)
        assert np.abs(run["motor.w"] - W).max() <= lost + 1e-12 * W
        assert np.abs(run["load.w"] * ratio - W).max() <= 2 * lost + 1e-12 * W
    back = gb.simulate(model, t_end=1e-5, initial=gb.rolling({"load.w": 40.0}))
    assert back["motor.w"][0] == pytest.approx(40.0 * ratio, rel=1e-15)


def test_angles_turn_along_through_a_lossy_gear_between_shafts() -> None:
    run = gb.simulate(_train("shaft, lossy gear, shaft"), t_end=1e-5, initial=gb.rolling({"load.phi": 0.3}))
    assert run["motor.phi"][0] == pytest.approx(-0.6, rel=1e-14)
    assert run["part0.twist"][0] == pytest.approx(0.0, abs=1e-16) and abs(run["part2.twist"][0]) < 1e-16


@pytest.mark.parametrize(
    "open_one", [gb.Clutch(capacity=0.0), gb.DogClutch(engaged=0.0), gb.DogClutch(engaged=-gb.time)]
)
def test_what_is_not_engaged_takes_nothing_along(open_one: gb.Block) -> None:
    rig = gb.Drivetrain("open")
    rig.chain(
        rig.add("motor", gb.Inertia(J=0.24)), rig.add("coupling", open_one), rig.add("shaft", _shaft()),
        rig.add("load", gb.Inertia(J=0.16)),
    )  # fmt: skip
    assert gb.simulate(rig, t_end=1e-5, initial=gb.rolling({"motor.w": W}))["load.w"][0] == 0.0


@pytest.mark.parametrize(("clutch", "brake", "hub"), [(80.0, 500.0, 0.0), (500.0, 80.0, 300.0)])
def test_of_two_that_cannot_both_hold_the_stronger_one_holds(clutch: float, brake: float, hub: float) -> None:
    """A clutch to the shaft of a motor against a brake behind another shaft."""
    rig = gb.Drivetrain("between")
    part = rig.add("hub", gb.Inertia(J=1.0))
    rig.chain(
        rig.add("motor", gb.Inertia(J=1.0)),
        rig.add("shaft", _shaft()),
        rig.add("clutch", gb.Clutch(capacity=clutch)),
        part,
    )
    rig.chain(part, rig.add("behind", _shaft()), rig.add("brake", gb.Brake(capacity=brake)))
    assert gb.simulate(rig, t_end=1e-6, initial=gb.rolling({"motor.w": 300.0}))["hub.w"][0] == hub


def test_a_lock_that_would_have_to_close_by_an_impact_is_refused() -> None:
    model = gb.build(_train("freewheel"))
    run = gb.simulate(model, t_end=1e-6, initial=gb.rolling({"motor.w": 3.0, "load.w": 4.0}))
    assert run["load.w"][0] == 4.0
    with pytest.raises(
        gb.ParameterError, match=r"'part0' is locked, but .* 'motor.w', 'load.w' would make it slip at -2"
    ):
        gb.simulate(model, t_end=1e-6, initial=gb.rolling({"motor.w": 3.0, "load.w": 1.0}))


@pytest.mark.parametrize("speed", [None, 40.0])
def test_friction_without_inertia_holds_a_load_in_a_static_start(speed: float | None) -> None:
    """On the ground, and turning with a motor: the shaft carries the load."""
    rig = gb.Drivetrain("static")
    drive = gb.Fixed() if speed is None else gb.Speed(w=speed)
    rig.chain(
        rig.add("drive", drive), rig.add("clutch", gb.Clutch(capacity=100.0)), rig.add("shaft", _shaft()),
        rig.add("load", gb.Inertia(J=0.1, w0=speed)), rig.add("tau", gb.Torque(tau=-5.0)),
    )  # fmt: skip
    run = gb.simulate(rig, t_end=0.5, initial="static")
    assert np.abs(run["load.w"] - (speed or 0.0)).max() < 1e-9
    assert np.abs(run["shaft.torque"] - 5.0).max() < 1e-6


@pytest.mark.parametrize("last", [(), (gb.Inertia(J=0.0), gb.Shaft(k=3170.0, c=1.09))], ids=["one shaft", "two"])
def test_an_unloaded_freewheel_beside_a_shaft_fits_at_any_speed(last: tuple[gb.Block, ...]) -> None:
    """Neither the rounding of its force, which is 0, nor that of its slip says which way it is."""
    rig, draw = gb.Drivetrain("freewheel"), np.random.default_rng(1)
    parts = [rig.add(f"part{i}", block) for i, block in enumerate((gb.Freewheel(), _shaft(), *last))]
    rig.chain(rig.add("one", gb.Inertia(J=0.24)), *parts, rig.add("two", gb.Inertia(J=0.16)))
    model = gb.build(rig)
    for speed, c in zip(draw.uniform(1.0, 1000.0, 100), draw.uniform(0.01, 10.0, 100), strict=True):
        run = gb.simulate(model, t_end=0.05, parameters={"part1.c": c}, initial={"one.w": speed, "two.w": speed})
        assert max(np.abs(run[f"{body}.w"] - speed).max() for body in ("one", "two")) < 1e-13 * speed

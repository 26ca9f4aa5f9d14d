"""Friction and stops straight at a side of a lossy gear that has no inertia.

Independent: by hand, what leaves the gear is the torque of the clutch, integrated by scipy while it slides; and the same
trains with small inertias there, extrapolated to none.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

T = np.linspace(0.0, 2.0, 41)
LOSSES = {
    "efficiency": {"efficiency": (0.9, 0.8)},
    "jumping": {"efficiency": (0.9, 0.8), "bearing": (3.0, 1.0)},
    "table": {"loss_table": ((0.0, 0.95, 0.9, 0.4, 0.4), (10.0, 0.9, 0.85, 0.5, 0.5), (90.0, 0.8, 0.75, 1.0, 1.0))},
}
Layout = Callable[[gb.Drivetrain, gb.Block, gb.Block, dict[str, object]], list[gb.Flange]]


def _clutch_behind(rig: gb.Drivetrain, one: gb.Block, other: gb.Block, loss: dict[str, object]) -> list[gb.Flange]:
    gear = rig.add("gear", gb.LossyGear(ratio=2.5, **loss))
    rig.chain(one, gear, rig.add("clutch", gb.Clutch(capacity=6.0)), other)
    return [gear.b]


def _clutch_before(rig: gb.Drivetrain, one: gb.Block, other: gb.Block, loss: dict[str, object]) -> list[gb.Flange]:
    gear = rig.add("gear", gb.LossyGear(ratio=-2.0, **loss))
    rig.chain(one, rig.add("clutch", gb.Clutch(capacity=6.0, peak=1.2)), gear, other)
    return [gear.a]


def _between_two_gears(rig: gb.Drivetrain, one: gb.Block, other: gb.Block, loss: dict[str, object]) -> list[gb.Flange]:
    first, second = (
        rig.add("first", gb.LossyGear(ratio=2.5, **loss)),
        rig.add("second", gb.LossyGear(ratio=0.5, **loss)),
    )
    rig.chain(one, first, rig.add("clutch", gb.Clutch(capacity=9.0)), second, other)
    return [first.b, second.a]


def _gears_in_a_row(rig: gb.Drivetrain, one: gb.Block, other: gb.Block, loss: dict[str, object]) -> list[gb.Flange]:
    first, second = (
        rig.add("first", gb.LossyGear(ratio=2.5, **loss)),
        rig.add("second", gb.LossyGear(ratio=0.5, **loss)),
    )
    rig.chain(one, first, second, rig.add("clutch", gb.Clutch(capacity=6.0)), other)
    return [second.a, second.b]


def _brake_beside(rig: gb.Drivetrain, one: gb.Block, other: gb.Block, loss: dict[str, object]) -> list[gb.Flange]:
    gear = rig.add("gear", gb.LossyGear(ratio=2.5, **loss))
    rig.chain(one, gear, rig.add("clutch", gb.OneWayClutch(capacity=4.0)), other)
    rig.chain(gear, rig.add("brake", gb.Brake(capacity=7 * gb.sin(3 * gb.time))))
    return [gear.b]


def _stop_beside(rig: gb.Drivetrain, one: gb.Block, other: gb.Block, loss: dict[str, object]) -> list[gb.Flange]:
    gear = rig.add("gear", gb.LossyGear(ratio=2.5, **loss))
    rig.chain(one, gear, rig.add("stop", gb.HardStop(lower=-0.3, upper=0.3, restitution=0.0)))
    rig.chain(gear, rig.add("shaft", gb.Shaft(k=30.0, c=1.0)), other)
    return [gear.b]


LAYOUTS: dict[str, Layout] = {
    "clutch behind": _clutch_behind, "clutch before": _clutch_before, "between two gears": _between_two_gears,
    "gears in a row": _gears_in_a_row, "brake beside": _brake_beside, "stop beside": _stop_beside,
}  # fmt: skip


def _train(layout: Layout, loss: str, J: float = 0.0, sign: float = 1.0) -> gb.Drivetrain:
    rig = gb.Drivetrain(loss)
    one, other = rig.add("one", gb.Inertia(J=0.3, w0=sign * 10.0)), rig.add("other", gb.Inertia(J=0.5, w0=sign * 4.0))
    rig.connect(rig.add("drive", gb.Torque(tau=sign * 60 * gb.sin(7 * gb.time))).flange, one.a)
    rig.connect(rig.add("load", gb.Torque(tau=-0.5 * gb.sense("other.w"))).flange, other.a)
    for i, flange in enumerate(layout(rig, one, other, LOSSES[loss])):
        if J:
            rig.connect(flange, rig.add(f"small{i}", gb.Inertia(J=J)).a)
    return rig


@pytest.mark.parametrize("method", ["dp8", pytest.param("rodas", marks=pytest.mark.long)])
def test_what_leaves_a_gear_is_the_torque_of_the_clutch_that_slides(method: str) -> None:
    def rates(t: float, w: np.ndarray) -> list[float]:
        d, slips = np.sign(w[0]), np.sign(w[0] / 2.5 - w[1])
        m = d * 6.0 * slips / 2.5
        return [(60 * np.sin(7 * t) - d * (m / 0.9 if m >= 0 else m * 0.8)) / 0.3, (6.0 * slips - 0.5 * w[1]) / 0.5]

    run = gb.simulate(_train(_clutch_behind, "efficiency"), t=T, rtol=1e-10, method=method)
    begin, end = np.flatnonzero((T > 0.05) & (T < 0.7))[[0, -1]]
    start = [run[f"{n}.w"][begin] for n in ("one", "other")]
    found = solve_ivp(rates, T[[begin, end]], start, t_eval=T[begin : end + 1], rtol=1e-11, atol=1e-12)
    for name, w in zip(("one", "other"), found.y, strict=True):
        assert np.abs(run[f"{name}.w"][begin : end + 1] - w).max() < 1e-7 * np.abs(w).max()
    assert run.energy.residual < 1e-9


CASES = [
    (name, loss, sign) for name in LAYOUTS for loss in LOSSES for sign in (1.0, -1.0)
    if loss != "jumping" or name not in ("clutch before", "between two gears")
]  # fmt: skip


@pytest.mark.parametrize(("name", "loss", "sign"), CASES)
@pytest.mark.few(3)
def test_it_is_the_limit_of_small_inertias_there(name: str, loss: str, sign: float) -> None:
    layout = LAYOUTS[name]
    run = gb.simulate(_train(layout, loss, sign=sign), t=T, rtol=1e-9)
    assert run.energy.residual < 1e-8
    limit = [gb.simulate(_train(layout, loss, J, sign), t=T, rtol=1e-9) for J in (4e-5, 2e-5, 1e-5)]
    for body in ("one.w", "other.w"):
        first, second = (2 * b[body] - a[body] for a, b in itertools.pairwise(limit))
        assert np.abs(run[body] - (4 * second - first) / 3).max() < 1e-6 * np.abs(run[body]).max()


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.few(1)
def test_every_method_finds_the_same_motion(method: str) -> None:
    fine = gb.simulate(_train(_between_two_gears, "table"), t=T, rtol=1e-10)
    for rtol in (1e-4, 1e-7):
        run = gb.simulate(_train(_between_two_gears, "table"), t=T, rtol=rtol, method=method)
        assert np.abs(run["one.w"] - fine["one.w"]).max() < 100 * rtol * np.abs(fine["one.w"]).max()


@pytest.mark.parametrize(("losses", "rule"), [
    ({"efficiency": (0.9, 0.8), "bearing": (1.0, 3.0)}, "tau1 = tau2"), ({"efficiency": (0.6, -0.4)}, "eta2 > 0"),
    ({"efficiency": (0.9, 0.8), "bearing": (3.0, 1.0)}, "tau1 = tau2"),
])  # fmt: skip
def test_losses_at_a_that_its_torques_do_not_tell_are_refused(losses: dict[str, object], rule: str) -> None:
    rig = gb.Drivetrain("clutch before")
    one, other = rig.add("one", gb.Inertia(J=0.3)), rig.add("other", gb.Inertia(J=0.5))
    _clutch_before(rig, one, other, losses)
    with pytest.raises(gb.ModelError, match=f"'gear'.*{rule}.*put an Inertia there"):
        gb.build(rig)


def test_nothing_of_the_gauge_is_seen() -> None:
    program = gb.build(_train(_clutch_behind, "efficiency")).program
    names = [*program.output_numbers, *(p.path for p in program.parameters), *(s.name for s in program.starts)]
    assert not [name for name in names if "tied" in name or name.startswith("gear.w")]
    assert [row.component for row in program.bodies] == ["one", "other"]


def test_forces_without_inertia_have_no_start_angle() -> None:
    rig = gb.Drivetrain("shaft and clutch")
    one, other = rig.add("one", gb.Inertia(J=1.0, w0=10.0)), rig.add("other", gb.Inertia(J=2.0))
    rig.chain(one, rig.add("shaft", gb.Shaft(k=1e3, c=1.0)), rig.add("clutch", gb.Clutch(capacity=5.0)), other)
    assert not [p.path for p in gb.build(rig).program.parameters if "held" in p.path]

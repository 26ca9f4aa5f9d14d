"""Conditions whose sides differ by many orders as a step begins, or without bound: they are met where they change."""

from __future__ import annotations

import math

import pytest

import gearblocks as gb

t, phi, w = gb.time, gb.sense("disc.phi"), gb.sense("disc.w")


def _switched(seconds: float) -> float:
    """Speed at 3 s after 10 N m until then, from 3 rad/s."""
    return 3.0 + 10.0 * seconds


def _at_angle(angle: float) -> float:
    """The same until an angle."""
    return _switched((math.sqrt(9.0 + 20.0 * angle) - 3.0) / 10.0)


# condition, speed at 3 s in closed form
FAR = {
    "falls by 17 orders": (gb.exp(40 - 100 * t) > 5, _switched((40 - math.log(5)) / 100)),
    "rises by 17 orders": (1e-3 * gb.exp(100 * t - 40) < 5, _switched((40 + math.log(5e3)) / 100)),
    "over the angle": (gb.exp(40 - 3 * phi) > 5, _at_angle((40 - math.log(5)) / 3)),
    "a hill": (1e18 * gb.exp(-9 * phi**2) > 5, _at_angle(math.sqrt(math.log(2e17)) / 3)),
    "over the speed": (gb.exp(50 - 4 * w) > 5, (50 - math.log(5)) / 4),
}


def _end(law: object, w0: float, method: str, rtol: float) -> float:
    rig = gb.Drivetrain("far")
    rig.chain(rig.add("drive", gb.Torque(tau=law)), rig.add("disc", gb.Inertia(J=1.0, w0=w0)))
    return float(gb.simulate(rig, t_end=3.0, method=method, rtol=rtol)["disc.w"][-1])


@pytest.mark.parametrize("name", FAR)
def test_what_begins_many_orders_off_its_limit_is_met_there(name: str) -> None:
    condition, wanted = FAR[name]
    for method, rtol in (("auto", 1e-3), ("auto", 1e-6), ("dp8", 1e-9), ("rodas", 1e-6)):
        assert _end(gb.piecewise((10.0, condition), (0.0, True)), 3.0, method, rtol) == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("method", ["auto", "dp5", "rodas"])
def test_what_begins_without_bound_is_met(method: str) -> None:
    cut = math.exp(-10.0)  # the logarithm comes to -10 there
    logarithm = 20.0 - 10.0 * cut + 3.0 * math.log(3.0) - 3.0 - (-11.0 * cut)
    assert _end(gb.maximum(-10.0, gb.log(t)), 20.0, method, 1e-7) == pytest.approx(logarithm, rel=1e-6)
    root = 1.0 + 0.1 + 2.0 * (math.sqrt(3.0) - 0.1)
    assert _end(gb.minimum(10.0, 1 / gb.sqrt(t)), 1.0, method, 1e-7) == pytest.approx(root, rel=1e-6)


@pytest.mark.parametrize(
    "law",
    [
        gb.minimum(10.0, 100 / w),
        -gb.maximum(-10.0, -100 / w),
        gb.minimum(10.0, gb.maximum(1.0, 100 / w)),
        gb.piecewise((100 / w, 1 / w < 0.1), (10.0, True)),
        -gb.maximum(-10.0, -100 / abs(w)),
        gb.minimum(gb.maximum(100 / w, 1.0), 10.0, 50.0),
    ],
    ids=["smaller", "larger", "clamped", "condition", "size", "clamped the other way round"],
)
def test_a_limit_of_power_holds_from_rest_on(law: object) -> None:
    for method in ("auto", "dp5", "rodas"):
        assert _end(law, 0.0, method, 1e-8) == pytest.approx(math.sqrt(500.0), rel=1e-7)

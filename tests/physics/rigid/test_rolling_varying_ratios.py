"""Rolling starts beside ratios that vary with the angles: speeds and angles by the laws of the pairs, written out here."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import gearblocks as gb

E, JOINT = 0.5, 0.4


def _m(x: float) -> float:
    """w_b/w_a of two ellipses of eccentricity E that turn about foci."""
    return (1 - E**2) / (1 + E**2 - 2 * E * math.cos(x))


def _turned(x: float) -> float:
    return float(quad(_m, 0.0, x, epsabs=1e-13, epsrel=1e-13)[0])


def _joint(x: float) -> tuple[float, float]:
    """Angle of the driven shaft of Hooke's joint and its slope: tan b = tan a/cos(angle), b = a at multiples of pi."""
    turns = round(x / math.pi) * math.pi
    c = math.cos(JOINT)
    return turns + math.atan(math.tan(x - turns) / c), c / (c**2 * math.cos(x) ** 2 + math.sin(x) ** 2)


def test_the_slope_of_the_law_is_that_written_here() -> None:
    law = gb.RatioLaw.ellipse(e=E)
    for x in (0.0, 0.3, 2.0, 5.0):
        rig = gb.Drivetrain("pair")
        pair = rig.add("pair", gb.NonCircularGear(law=law, external=True))
        rig.chain(rig.add("one", gb.Inertia(J=1.0, phi0=x, w0=1.0)), pair, rig.add("two", gb.Inertia(J=1.0)))
        assert -gb.simulate(rig, t_end=1e-6)["two.w"][0] == pytest.approx(_m(x), rel=1e-9)


def _train(pair: gb.Block, flip: bool, *, rigid: bool = False) -> gb.Drivetrain:
    """one - shaft - two - pair - three - gear - four - shaft - five; flip: the pair the other way round."""
    rig = gb.Drivetrain("varying")
    one, two, three, four, five = (rig.add(n, gb.Inertia(J=J)) for n, J in zip(
        ("one", "two", "three", "four", "five"), (1.0, 0.3, 0.5, 0.2, 2.0), strict=True))  # fmt: skip
    part = rig.add("pair", pair)
    first, second = (part.b, part.a) if flip else (part.a, part.b)
    rig.chain(one, rig.add("front", gb.Shaft(k=1e3, rest=0.1)), two)
    rig.connect(two.b, first)
    rig.connect(second, three.a)
    rig.chain(three, rig.add("gear", gb.IdealGear(ratio=-2)), four, rig.add("rear", gb.Shaft(k=2e3, rigid=rigid)), five)
    return rig


PAIRS: dict[str, tuple[dict[str, Any], float]] = {
    "rigid ellipses": ({}, -1.0), "compliant ellipses": ({"k": 1e4, "c": 2.0}, -1.0),
    "with a gap": ({"k": 1e4, "backlash": gb.Backlash(half_gap=0.01)}, -1.0), "internal": ({"k": 1e4, "external": False}, 1.0),
    "joint": ({}, 1.0),
}  # fmt: skip


def _block(kind: str) -> gb.Block:
    if kind == "joint":
        return gb.UniversalJoint(angle=JOINT)
    return gb.NonCircularGear(**{"law": gb.RatioLaw.ellipse(e=E), "external": True} | PAIRS[kind][0])


@pytest.mark.parametrize("flip", [False, True])
@pytest.mark.parametrize("kind", PAIRS)
@pytest.mark.parametrize("named", ["one", "five"])
@pytest.mark.few(3)
def test_speeds_and_angles_follow_through_the_pair(kind: str, flip: bool, named: str) -> None:
    """Angles of both sides agree with the law, the speeds with its slope there, and nothing is twisted or winds up."""
    rig, sign = _train(_block(kind), flip), PAIRS[kind][1]
    start = gb.rolling({f"{named}.w": 7.0, f"{named}.phi": 1.3})
    run = gb.simulate(rig, t_end=1e-5, initial=start, rtol=1e-9)
    phi, w = ({n: float(run[f"{n}.{of}"][0]) for n in ("one", "two", "three", "four", "five")} for of in ("phi", "w"))
    assert (phi[named], w[named]) == pytest.approx((1.3, 7.0), rel=1e-14)
    assert phi["two"] - phi["one"] == pytest.approx(0.1, abs=1e-12) and w["two"] == pytest.approx(w["one"], rel=1e-12)
    assert (phi["three"], w["three"]) == pytest.approx((-2 * phi["four"], -2 * w["four"]), rel=1e-12)
    assert phi["five"] == pytest.approx(phi["four"], abs=1e-12) and w["five"] == pytest.approx(w["four"], rel=1e-12)
    a, b = ("three", "two") if flip else ("two", "three")
    turned, slope = _joint(phi[a]) if kind == "joint" else (_turned(phi[a]), _m(phi[a]))
    assert phi[b] == pytest.approx(sign * turned, abs=1e-9)
    assert w[b] == pytest.approx(sign * slope * w[a], rel=1e-9)
    for name in ("front", "rear"):
        assert abs(run[f"{name}.twist_rate"][0]) < 1e-12 * abs(w["one"])


def test_a_pair_that_is_driven_at_an_angle_begins_undeformed() -> None:
    """The angle of the driver is given; the other side is where the law has it, and a shaft behind it is not twisted."""
    rig = gb.Drivetrain("driven")
    pair = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=E), external=True, k=1e4))
    drive = gb.Angle(phi=0.8 + 3.0 * gb.time + 0.5 * gb.time**2)
    rig.chain(rig.add("drive", drive), pair, rig.add("two", gb.Inertia(J=0.5)), rig.add("shaft", gb.Shaft(k=1e3)),
              rig.add("three", gb.Inertia(J=0.5)))  # fmt: skip
    run = gb.simulate(rig, t_end=1.0 + 1e-5, t_start=1.0, initial="rolling")
    assert run["three.phi"][0] == pytest.approx(-_turned(4.3), abs=1e-9)
    assert run["three.w"][0] == pytest.approx(-4.0 * _m(4.3), rel=1e-9)


def test_two_pairs_in_a_row_and_one_beside_a_circle() -> None:
    """The inverse is looked for through two laws; a branch without them is as it would be alone."""
    rig = gb.Drivetrain("two pairs")
    law = gb.RatioLaw.ellipse(e=E)
    first, second = (rig.add(n, gb.NonCircularGear(law=law, external=True, k=1e4)) for n in ("first", "second"))
    body = {n: rig.add(n, gb.Inertia(J=0.5)) for n in ("one", "two", "three", "four")}
    rig.chain(body["one"], first, body["two"], second, body["three"])
    rig.chain(body["two"], rig.add("shaft", gb.Shaft(k=1e3)), body["four"])
    run = gb.simulate(rig, t_end=1e-5, initial=gb.rolling({"three.w": 2.0, "three.phi": 1.0}))
    two = brentq(lambda x: -_turned(x) - 1.0, -7.0, 7.0, xtol=1e-14)
    one = brentq(lambda x: -_turned(x) - two, -7.0, 7.0, xtol=1e-14)
    assert (run["two.phi"][0], run["one.phi"][0], run["four.phi"][0]) == pytest.approx((two, one, two), abs=1e-9)
    speeds = (-2.0 / _m(two), 2.0 / _m(two) / _m(one), -2.0 / _m(two))
    assert (run["two.w"][0], run["one.w"][0], run["four.w"][0]) == pytest.approx(speeds, rel=1e-9)


def test_a_shaft_on_a_turning_housing_is_taken_along() -> None:
    rig = gb.Drivetrain("housing")
    frame, arm, tip = (rig.add(n, gb.Inertia(J=J)) for n, J in (("frame", 2.0), ("arm", 0.5), ("tip", 0.1)))
    drive = rig.add("drive", gb.Speed(w=3.0))
    rig.connect(frame.b, drive.housing)
    rig.connect(drive.flange, arm.a)
    rig.chain(arm, rig.add("shaft", gb.Shaft(k=1e3)), tip)
    run = gb.simulate(rig, t_end=1e-5, initial=gb.rolling({"frame.w": 5.0}))
    assert (run["arm.w"][0], run["tip.w"][0]) == pytest.approx((8.0, 8.0), rel=1e-13)
    back = gb.simulate(rig, t_end=1e-5, initial=gb.rolling({"tip.w": 5.0}))
    assert back["frame.w"][0] == pytest.approx(2.0, rel=1e-13)


def test_it_turns_on_without_a_blow() -> None:
    """A start from rest of the pair wound up its shaft at once; rolling, its torque grows from 0 with the motion alone."""
    run = gb.simulate(
        _train(_block("joint"), flip=False), t_end=2e-3, initial=gb.rolling({"one.w": 7.0, "one.phi": 1.3})
    )
    blow = gb.simulate(_train(_block("joint"), flip=False), t_end=2e-3, initial={"one.w": 7.0})
    assert run["rear.torque"][0] == 0.0
    assert np.abs(run["front.torque"]).max() < 0.02 * np.abs(blow["front.torque"]).max()


def test_a_pair_beside_a_shaft_without_inertia_is_refused_by_name() -> None:
    rig = gb.Drivetrain("bare")
    pair = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=E), external=True, k=1e4, c=1.0))
    rig.chain(
        rig.add("one", gb.Inertia(J=1.0)),
        pair,
        rig.add("shaft", gb.Shaft(k=1e3, c=1.0)),
        rig.add("two", gb.Inertia(J=1.0)),
    )
    with pytest.raises(gb.ParameterError, match=r"'pair' is a pair whose ratio varies, beside a shaft without inertia"):
        gb.simulate(rig, t_end=1.0, initial=gb.rolling({"one.w": 5.0}))


def test_a_static_start_does_not_turn_a_pair_along() -> None:
    """Steady speeds through it are none: what they are at one angle is no equilibrium."""
    rig = gb.Drivetrain("steady")
    pair = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=E), external=True, k=1e4, c=1.0))
    rig.chain(rig.add("drive", gb.Speed(w=5.0)), pair, rig.add("two", gb.Inertia(J=1.0)))
    with pytest.raises(gb.ParameterError, match="a gear whose ratio varies has no steady rotation"):
        gb.simulate(rig, t_end=1.0, initial="static")


@pytest.mark.parametrize("varying", [False, True])
def test_a_clutch_in_a_row_with_a_shaft_does_not_stand_in_the_way(varying: bool) -> None:
    law = gb.RatioLaw.ellipse(e=0.0, order=1)  # a ratio of 1 that nothing knows to be one
    pair = gb.NonCircularGear(law=law, external=True) if varying else gb.IdealGear(ratio=-1)
    rig = gb.Drivetrain("clutch and shaft")
    one, two, three = (rig.add(n, gb.Inertia(J=J)) for n, J in (("one", 0.3), ("two", 0.2), ("three", 0.1)))
    clutch, shaft = rig.add("clutch", gb.Clutch(capacity=5.0)), rig.add("shaft", gb.Shaft(k=50.0, c=0.2))
    rig.chain(one, rig.add("pair", pair), two, clutch, shaft, three)
    run = gb.simulate(rig, t=[0.0, 0.5], initial=gb.rolling({"one.w": 8.0, "three.w": -8.0}))
    assert run["one.w"] == pytest.approx([8.0, 8.0], rel=1e-9) and run["three.w"] == pytest.approx(
        [-8.0, -8.0], rel=1e-9
    )
    assert run["shaft.a.tau"] == pytest.approx([0.0, 0.0], abs=1e-9)

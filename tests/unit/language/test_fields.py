"""Fields of blocks: every mistaken value is named with its rule."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

NAN, INF = float("nan"), float("inf")
MESH: dict[str, Any] = {"teeth": (23, 41), "external": True, "module": 3e-3, "pressure_angle": 0.35, "k": 1e8}
P = gb.Parameter("P", -1.0)


def _mesh(**changes: Any) -> gb.GearMesh:
    fields = {name: value for name, value in {**MESH, **changes}.items() if value is not Ellipsis}
    return gb.GearMesh(**fields)


def _added(block: gb.Block) -> Any:
    """Text is read when a block comes into a train."""
    return gb.Drivetrain("rig").add("part", block)


def _refused(make: Callable[[], Any], *words: str) -> None:
    with pytest.raises(gb.GearblocksError) as caught:
        gb.Drivetrain("rig").add("part", make())
    for word in words:
        assert word in str(caught.value), str(caught.value)


@pytest.mark.parametrize(
    "value",
    [
        NAN, INF, -1.0, "3", True, [1.0, 2.0], np.array([1.0, 2.0]), 1j, None, {}, b"x", object(), 10**400, gb.Inertia,
        gb.Input("u"), gb.Table([0, 1], [0, 1]), gb.time, gb.sense("a.w"), P, P * 1, P / 0, gb.Inertia(J=1.0),
    ],
)  # fmt: skip
def test_an_inertia_takes_one_number_that_is_finite_and_not_negative(value: Any) -> None:
    _refused(lambda: gb.Inertia(J=value), "Inertia 'part': J")


@pytest.mark.parametrize("value", [0, 1, 0.5, np.float32(0.5), np.int64(2), np.array(3.0), -P, sp.Rational(1, 2)])
def test_every_kind_of_plain_number_is_taken(value: Any) -> None:
    gb.Drivetrain("rig").add("part", gb.Inertia(J=value))


@pytest.mark.parametrize(
    "value",
    [
        NAN,
        "3",
        True,
        None,
        [1, 2],
        1j,
        {},
        lambda t: t,
        object(),
        gb.Fourier(cos=(1.0,)),
        gb.twist * 2,
        gb.time * 1 < 2,
    ],
)
def test_a_signal_takes_numbers_and_expressions(value: Any) -> None:
    _refused(lambda: gb.Torque(tau=value), "tau")


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: gb.Inertia(), ["Inertia needs J (moment of inertia, kg m2)"]),
        (lambda: gb.Inertia(1.0), ["Inertia: 1.0 is given without a name", "Inertia(J=...)"]),
        (lambda: gb.Backlash(5e-5), ["Backlash: 5e-05 is given without a name", "half_gap"]),
        (lambda: gb.Inertia(j=1.0), ["no field 'j'", "did you mean 'J'", "needs J"]),
        (lambda: gb.Inertia(J=-1.0, w0=NAN, phi0=INF), ["3 problems", "J = -1.0", "w0 = nan", "phi0 = inf"]),
        (lambda: gb.Shaft(k=1.0, c=1.0, damping_ratio=0.1), ["c and damping_ratio are both given"]),
        (lambda: gb.Shaft(k=-1.0), ["k = -1.0 N m/rad must be > 0", "allow_negative=True"]),
        (lambda: gb.Shaft(k=-1.0, allow_negative="yes"), ["allow_negative = 'yes' must be True or False"]),
        (lambda: gb.Shaft(k=1.0, J=1.0, segments=2.5), ["segments = 2.5 must be a whole number"]),
        (lambda: gb.Shaft(k=lambda x: x), ["k = <function", "is no number"]),
        (lambda: _mesh(teeth=...), ["GearMesh needs teeth"]),
        (lambda: _mesh(external=...), ["GearMesh needs external"]),
        (
            lambda: _mesh(external=1),
            ["external = 1 must be True (outside on both: they turn against each other) or False"],
        ),
        (lambda: _mesh(teeth=23), ["teeth = 23 must be a row of 2 numbers"]),
        (lambda: _mesh(teeth=(23,)), ["teeth = (23,) must be two whole numbers"]),
        (lambda: _mesh(teeth=(23.5, 41)), ["must be two whole numbers"]),
        (lambda: _mesh(teeth=(True, 41)), ["teeth[0] = True is no number"]),
        (lambda: _added(_mesh(teeth=("z", 41))), ["teeth[0] = 'z' is no number"]),
        (lambda: _mesh(teeth=(gb.Parameter("z", 23), 41)), ["teeth[0]", "enters a ratio", "rig.set"]),
        (lambda: _mesh(teeth=None), ["teeth = None", "a value must be given"]),
        (lambda: _mesh(module=...), ["the base radii are unknown"]),
        (lambda: _mesh(module=..., pressure_angle=..., r_base=0.03), ["r_base = 0.03 must be a row"]),
        (
            lambda: _mesh(module=..., pressure_angle=..., r_base=(0.03, 0.06)),
            ["r_base = (0.03, 0.06)", "teeth = (23, 41)"],
        ),
        (lambda: _mesh(pressure_angle=20), ["pressure_angle = 20", "must be < 1.5"]),
        (lambda: _mesh(backlash=5e-5), ["backlash = 5e-05 must be an effect object"]),
        (lambda: _mesh(backlash=gb.Backlash), ["backlash = ", "must be an effect object"]),
        (lambda: _mesh(backlash={"half_gap": 5e-5}), ["must be an effect object"]),
        (lambda: _mesh(backlash=gb.Fourier(cos=(0.2,))), ["backlash = Fourier", "must be gb.Backlash(...)"]),
        (lambda: _mesh(backlash=gb.Inertia(J=1.0)), ["must be an effect object"]),
        (
            lambda: _mesh(stiffness_variation=gb.Harmonic(cos=(1e-6,))),
            ["stiffness_variation = Harmonic", "gb.Fourier(...)"],
        ),
        (lambda: _mesh(transmission_error=gb.Fourier(cos=(0.2,))), ["transmission_error", "gb.Harmonic(...)"]),
        (lambda: _mesh(backlash=gb.Backlash(half_gap=NAN)), ["backlash.half_gap = nan m must be a finite number"]),
        (lambda: _mesh(stiffness_variation=gb.Fourier(cos=0.2)), ["stiffness_variation.cos = 0.2 must be a row"]),
        (lambda: _mesh(stiffness_variation=gb.Fourier(cos="abc")), ["stiffness_variation.cos = 'abc' must be a row"]),
        (
            lambda: _mesh(stiffness_variation=gb.Fourier(cos=(0.2,), driven_by="time")),
            ["driven_by = 'time' is no number"],
        ),
        (lambda: _mesh(stiffness_variation=gb.Fourier(cos=(0.2,), driven_by=None)), ["driven_by = None"]),
        (lambda: _mesh(k=None, backlash=gb.Backlash(half_gap=1e-5)), ["give k"]),
        (lambda: _mesh(kk=1.0), ["GearMesh has no field 'kk'"]),
        (lambda: gb.IdealGear(), ["give either ratio or teeth"]),
        (lambda: gb.IdealGear(ratio=0), ["ratio = 0"]),
        (lambda: _added(gb.IdealGear(ratio="2 m")), ["ratio = '2 m' is no number"]),
        (lambda: gb.IdealGear(ratio=gb.Parameter("i", 2.0)), ["enters a ratio"]),
        (lambda: gb.IdealGear(teeth=(1, 2)), ["external = None must be True (outside on both"]),
        (lambda: gb.SpeedLoad(coeffs=1.0), ["coeffs = 1.0 must be a row"]),
        (lambda: gb.SpeedLoad(coeffs=(1, 2)), ["must be three numbers"]),
        (lambda: gb.SplineCoupling(teeth="a", radius=1.0, k=1.0), ["teeth = 'a' is no number"]),
        (lambda: gb.SplineCoupling(teeth=3, radius=1.0), ["SplineCoupling needs k"]),
        (lambda: gb.Damper(c=None), ["c = None (torsional damping): a value must be given"]),
    ],
)
def test_a_mistaken_field_is_named_with_value_and_rule(make: Callable[[], Any], words: list[str]) -> None:
    _refused(make, *words)


@pytest.mark.parametrize(("text", "number"), [("3.5", 3.5), ("-2", -2.0), ("41/23", 41 / 23)])
def test_a_ratio_may_be_text(text: str, number: float) -> None:
    assert float(_added(gb.IdealGear(ratio=text)).ratio) == number

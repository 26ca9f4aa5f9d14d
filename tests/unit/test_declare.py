"""Fields of blocks and what user blocks yield: every mistake is named with its way out."""

import re
from collections.abc import Callable, Iterator
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
        (lambda: _mesh(external=1), ["external = 1 must be True or False"]),
        (lambda: _mesh(teeth=23), ["teeth = 23 must be a row of numbers"]),
        (lambda: _mesh(teeth=(23,)), ["teeth = (23,) must be two whole numbers"]),
        (lambda: _mesh(teeth=(23.5, 41)), ["must be two whole numbers"]),
        (lambda: _mesh(teeth=(True, 41)), ["teeth[0] = True is no number"]),
        (lambda: _mesh(teeth=("23", 41)), ["teeth[0] = '23' is no number"]),
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
        (lambda: gb.IdealGear(ratio="2"), ["ratio = '2' is no number"]),
        (lambda: gb.IdealGear(ratio=gb.Parameter("i", 2.0)), ["enters a ratio"]),
        (lambda: gb.IdealGear(teeth=(1, 2)), ["external = None must be True or False"]),
        (lambda: gb.SpeedLoad(coeffs=1.0), ["coeffs = 1.0 must be a row"]),
        (lambda: gb.SpeedLoad(coeffs=(1, 2)), ["must be three numbers"]),
        (lambda: gb.SplineCoupling(teeth="a", radius=1.0, k=1.0), ["teeth = 'a' is no number"]),
        (lambda: gb.SplineCoupling(teeth=3, radius=1.0), ["SplineCoupling needs k"]),
        (lambda: gb.Damper(c=None), ["c = None (torsional damping): a value must be given"]),
    ],
)
def test_a_mistaken_field_is_named_with_value_and_rule(make: Callable[[], Any], words: list[str]) -> None:
    _refused(make, *words)


def test_a_block_cannot_be_changed_and_says_what_to_do() -> None:
    block = gb.Inertia(J=1.0)
    with pytest.raises(AttributeError, match=re.escape("rig.set({'path.J': value})")):
        block.J = 2.0  # type: ignore[misc]


def _field_without_call() -> type:
    class Motor(gb.Block):
        shaft = gb.Flange

        def physics(self, s: Any) -> Iterator[Any]:
            yield gb.Acts(s.shaft, 1.0)

    return Motor  # fmt: skip


def _field_with_a_taken_name() -> type:
    class Motor(gb.Block):
        time = gb.param("start", "s")

        def physics(self, s: Any) -> Iterator[Any]:
            yield gb.Shows("x", s.time)

    return Motor  # fmt: skip


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (_field_without_call, "Motor.shaft: write gb.Flange"),
        (_field_with_a_taken_name, "cannot be named 'time'"),
        (lambda: gb.State("current", "A", NAN), "State 'current': start = nan"),
    ],
)
def test_a_class_that_declares_nonsense_is_refused_where_it_is_written(make: Callable[[], Any], words: str) -> None:
    with pytest.raises(gb.GearblocksError, match=words):
        make()


class _Motor(gb.Block):
    """A block whose physics is put in by each test."""

    f = gb.Flange("shaft")
    k = gb.param("constant", "N m", default=1.0)
    c = gb.param("optional", "N m", default=None)
    i = gb.State("current", "A")
    what: Any = gb.option("what physics does")

    def physics(self, s: Any) -> Any:
        return self.what(self, s)


def _simulated(what: Callable[[Any, Any], Any], k: float = 1.0) -> float:
    rig = gb.Drivetrain("user")
    rig.chain(rig.add("motor", _Motor(what=what, k=k)), rig.add("wheel", gb.Inertia(J=1.0)))
    return float(gb.simulate(rig, t_end=0.1)["wheel.w"][-1])


def _rate(s: Any) -> Any:
    return gb.Rate(s.i, 0)


@pytest.mark.parametrize(
    ("what", "words"),
    [
        (lambda self, s: None, "physics gives None; let it yield"),
        (lambda self, s: gb.Acts(s.f, 1.0), "let it yield contributions"),
        (lambda self, s: [3], "yields 3, which is no contribution"),
        (lambda self, s: [gb.Acts], "which is no contribution"),
        (lambda self, s: [gb.Acts(s.g, 1.0)], "asks s for 'g'; it has"),
        (lambda self, s: [gb.Acts(s.f, s.f.omega)], "asks a flange for 'omega'; it has phi, w"),
        (lambda self, s: [gb.Acts(s.f, 1 / 0)], "raises ZeroDivisionError"),
        (lambda self, s: [gb.Acts(s.f, 2 * s.c)], "an optional field that is not given is None"),
        (lambda self, s: [gb.Acts(s.f, "a")], "Acts: 'a' is no expression"),
        (lambda self, s: [gb.Acts(s.f, None)], "Acts: None is no expression"),
        (lambda self, s: [gb.Acts(s.f, NAN)], "not finite and real"),
        (lambda self, s: [gb.Acts(s.f, sp.I)], "not finite and real"),
        (lambda self, s: [gb.Acts("f", 1.0)], "'f' is no flange of s; there are s.f"),
        (lambda self, s: [gb.Acts(self.f, 1.0)], "write s.<flange>"),
        (lambda self, s: [gb.Acts(1.0, s.f)], "1.0 is no flange"),
        (lambda self, s: [gb.Acts(s.f, sp.Symbol("q"))], "the symbol 'q' in 'q' is not from s"),
        (lambda self, s: [gb.Acts(s.f, s.f.alpha)], "which only Shows can read"),
        (lambda self, s: [gb.Acts(s.f, s.f.w > 0)], "is a condition, not a value"),
        (lambda self, s: [gb.Acts(s.f, gb.time)], "use s.time"),
        (lambda self, s: [gb.Acts(s.f, sp.Function("g")(s.f.phi))], "which has no value here"),
        (lambda self, s: [gb.Acts(s.f, self.k)], "the number self.k stands in it: write s.k"),
        (lambda self, s: [gb.Acts(s.f, s.f.w * self.k)], "physics uses the number self.k: write s.k"),
        (lambda self, s: [gb.Acts(s.f, 1 if self.k > 2 else 2)], "physics uses the number self.k"),
        (lambda self, s: [gb.Force(s.f.phi, "a")], "Force: 'a' is no expression"),
        (lambda self, s: [gb.Force(1.0, 2.0)], "contains no angle"),
        (lambda self, s: [gb.Force(s.f.w, 2.0)], "must be of angles"),
        (lambda self, s: [gb.Potential(s.f.w**2)], "must be of angles"),
        (lambda self, s: [_rate(s), gb.Tie(s.f.phi**2)], "contains no flange linearly with a number as its factor"),
        (lambda self, s: [gb.Tie(s.f.w)], "must be of s.flange.phi, not of s.flange.w"),
        (lambda self, s: [gb.Body(s.f, -5)], "J = -5 kg m2 must be >= 0"),
        (lambda self, s: [gb.Body(s.f, s.f.phi)], "changes during a run"),
        (lambda self, s: [gb.Rate(s.k, 1.0)], "'k' is no state of the block; it has s.i"),
        (lambda self, s: [gb.Rate("i", 1.0)], "'i' is no state of the block; it has s.i"),
        (lambda self, s: [gb.Acts(s.f, s.i)], "the state 'i' has 0 rates"),
        (lambda self, s: [_rate(s), _rate(s)], "the state 'i' has 2 rates"),
        (lambda self, s: [gb.Shows("x", "y")], "Shows: 'y' is no expression"),
        (lambda self, s: [gb.Shows("a b", s.f.w)], "'a b' must be a word"),
        (lambda self, s: [gb.Shows("a", s.f.w), gb.Shows("a", s.f.phi)], "the output 'a' is shown twice"),
        (lambda self, s: [gb.Energy(stored="a")], "Energy: 'a' is no expression"),
        (lambda self, s: [gb.Switch("a", "b")], "Switch: 'b' is no expression"),
        (lambda self, s: [_rate(s), gb.Acts(s.f, sp.besselj(0, s.f.phi))], "besselj"),
    ],
)
def test_what_a_user_block_does_wrong_is_said_in_its_own_words(what: Callable[[Any, Any], Any], words: str) -> None:
    with pytest.raises(gb.ModelError) as caught:
        _simulated(what)
    assert words in str(caught.value)
    assert "Motor" in str(caught.value) or "function" in str(caught.value)


def test_a_sound_user_block_runs_with_the_number_of_each_instance() -> None:
    def physics(self: Any, s: Any) -> Iterator[Any]:
        yield gb.Acts(s.f, s.k if self.c is None else s.c)
        yield _rate(s)

    assert _simulated(physics) == pytest.approx(0.1, rel=1e-12)  # a constant torque: exact but for rounding
    assert _simulated(physics, k=3.0) == pytest.approx(0.3, rel=1e-12)


def _written(torque: str, **scope: Any) -> type:
    """A class as a notebook cell makes it, without a source file."""
    scope |= {"gb": gb}
    text = "class Cell(gb.Block):\n f = gb.Flange('f')\n def physics(self, s):\n"
    exec(text + f"  yield gb.Acts(s.f, {torque})\n", scope)  # noqa: S102  as a notebook does
    made = scope["Cell"]
    assert isinstance(made, type)
    return made


def _end_speed(kind: type) -> float:
    rig = gb.Drivetrain("cell")
    rig.chain(rig.add("motor", kind()), rig.add("wheel", gb.Inertia(J=1.0)))
    return float(gb.simulate(rig, t_end=1.0)["wheel.w"][-1])


def _constant(value: float) -> Callable[[], float]:
    return lambda: value


def test_a_class_written_again_with_other_code_helpers_or_constants_is_not_taken_from_the_cache() -> None:
    class Helper:
        pass

    def one() -> float:
        return 5.0

    def other() -> float:
        return 6.0

    cases = [
        ("1.0", {}, 1.0), ("2.0", {}, 2.0), ("K", {"K": 3.0}, 3.0), ("K", {"K": 4.0}, 4.0),
        ("K[0]", {"K": (3.5,)}, 3.5), ("K[0]", {"K": (4.5,)}, 4.5), ("h()", {"h": one}, 5.0), ("h()", {"h": other}, 6.0),
        ("h()", {"h": _constant(7.0)}, 7.0), ("h()", {"h": _constant(8.0)}, 8.0),
        ("float(K[0])", {"K": np.array([9.0, 1.0])}, 9.0), ("float(K[0])", {"K": np.array([10.0, 1.0])}, 10.0),
        ("H.k()", {"H": type("H", (Helper,), {"k": staticmethod(one)})}, 5.0),
        ("H.k()", {"H": type("H", (Helper,), {"k": staticmethod(other)})}, 6.0),
    ]  # fmt: skip
    for torque, scope, speed in cases:
        assert _end_speed(_written(torque, **scope)) == pytest.approx(speed, rel=1e-12)  # constant torque


def test_two_classes_of_one_name_in_a_train_are_refused() -> None:
    rig = gb.Drivetrain("cell")
    parts = [rig.add(f"m{i}", _written(f"{i}.0")()) for i in range(2)]
    rig.chain(*parts, rig.add("wheel", gb.Inertia(J=1.0)))
    with pytest.raises(gb.ModelError, match="two classes of blocks are named Cell"):
        gb.build(rig)

"""What blocks of users yield: every mistake is named with its way out."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
import sympy as sp

import gearblocks as gb

NAN, INF = float("nan"), float("inf")


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

"""Zero test: over the reals by points, over the modes by all their values."""

import itertools

import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.laws.derivation import derive
from gearblocks.laws.vanishing import vanishes

A, B, TIME = gb.Parameter("A", 3.0), gb.Parameter("B", 7.0), gb.time
SPEED, ANGLE, LOAD = gb.sense("body.w"), gb.sense("body.phi"), gb.sense("load.phi")


class Counter(gb.Block):
    """A torque that grows with the whole turns of a phase."""

    flange = gb.Flange("driven flange")
    size: float = gb.param("torque a turn", "N m")
    phase = gb.signal("phase")

    def physics(self, s):
        yield gb.Acts(s.flange, s.size * sp.floor(s.phase))


def _law(*terms):
    return derive(gb.Torque(tau=sum(terms)), frozenset({"housing"}))


def _signs(n):
    """A law with n modes of 0 and 1, and their symbols."""
    law = _law(*(sp.Heaviside(TIME - i, 1) * (i + 1) for i in range(n)))
    return law, [switch.symbol for switch in law.switches]


@pytest.mark.parametrize(
    "tau",
    [
        gb.piecewise((A, TIME > 0.5), (0, True)),
        gb.piecewise((100 * (TIME - 0.5), TIME > 0.5), (0, True)),
        gb.piecewise((5 * (80 - SPEED), SPEED < 80), (0, True)),
        gb.piecewise((0, TIME < 0.2), (A, TIME < 0.4), (0, True)),
        gb.piecewise((A, sp.And(TIME > 1, TIME < 2, SPEED > 3, ANGLE > 4, LOAD < 5)), (0, True)),
        gb.piecewise((0, sp.Or(TIME > 1, SPEED > 3, SPEED < -3, ANGLE > 4, LOAD > 5)), (A, True)),
        gb.piecewise((A, B > 100), (0, True)),
        gb.piecewise((A, sp.Max(A, B) > 50), (0, True)) * gb.piecewise((1, B < -4), (0, True)),
        sp.Max(0, TIME - 40),
        sp.Min(0, SPEED - 3) * sp.Max(0, SPEED - 4),
        sp.Abs(SPEED) - SPEED,
        sp.sign(SPEED) + 1,
        gb.Table([0, 5, 6], [0, 0, 2])(TIME),
    ],
)  # fmt: skip
def test_a_source_supplies_whatever_its_conditions_are_at_first(tau):
    assert derive(gb.Torque(tau=tau), frozenset({"housing"})).supplied is not None


@pytest.mark.parametrize(
    "tau",
    [
        gb.exp(-(((TIME - 17) / 0.01) ** 2)),
        1 + gb.tanh((TIME - 17) / 0.01),
        A * (1 - gb.tanh((SPEED + 17) / B)) - A * (1 - gb.tanh((SPEED + 18) / B)),
        1 / sp.cosh((sp.sympify(ANGLE) - 17) / 0.01) ** 2,
    ],
)
def test_what_floating_point_has_no_number_for_is_not_zero(tau):
    assert derive(gb.Torque(tau=tau), frozenset({"housing"})).supplied is not None


def test_identities_of_exponentials_of_one_argument_hold():
    law = _law(gb.exp(-30 * TIME))
    t = sp.Symbol("t", real=True)
    for zero in (
        sp.exp(-900 * t) * sp.exp(900 * t) - 1,
        sp.tanh(t * 1000 - 17) - sp.sinh(t * 1000 - 17) / sp.cosh(17 - t * 1000),
        sp.cosh(70 * t) - (sp.exp(70 * t) + sp.exp(-70 * t)) / 2,
    ):
        assert vanishes(zero, law)


@pytest.mark.parametrize("phase", [TIME / 30, A / 1000], ids=["time", "a parameter"])
def test_what_counts_whole_turns_supplies_though_it_starts_at_none(phase):
    assert derive(Counter(size=1.0, phase=phase), frozenset()).supplied is not None


def test_identities_of_modes_hold_for_the_values_that_they_take():
    law, (m, n, *_) = _signs(3)
    speed = law.pool.symbol("w", "flange", "w_flange")
    assert vanishes(m**2 - m, law)
    assert vanishes(speed * ((m + n) ** 2 - m - 2 * m * n - n), law)
    assert not vanishes(m**2 + m, law)
    assert not vanishes(speed * m * n, law)
    assert not vanishes((1 - m) * (1 - n) * speed, law)
    side = derive(gb.Lash(k=1.0, half_gap=1.0), frozenset()).switches[0].symbol
    lash = derive(gb.Lash(k=1.0, half_gap=1.0), frozenset())
    assert vanishes(side**3 - side, lash)
    assert not vanishes(side**2 - side, lash)


def test_one_combination_of_many_modes_is_found():
    law, modes = _signs(9)
    for values in itertools.islice(itertools.product((0, 1), repeat=9), 0, None, 37):
        indicator = sp.Mul(*(m if v else 1 - m for m, v in zip(modes, values, strict=True)))
        assert not vanishes(indicator, law)
        assert vanishes(indicator**2 - indicator, law)


def test_sums_over_many_modes_are_asked_in_each_of_them_and_not_in_all_together():
    law, modes = _signs(60)
    assert vanishes(sum(m**2 - m for m in modes), law)
    assert not vanishes(sum(m**2 - m for m in modes) + modes[30] * modes[31], law)
    assert not vanishes(sum(m**2 - m for m in modes) + modes[30] * modes[31] * (1 - modes[50]), law)


def test_what_is_too_long_to_find_out_counts_as_not_zero():
    law, modes = _signs(30)
    assert not vanishes(sp.Mul(*(m + 1 for m in modes)) - sp.Mul(*(1 + m**2 for m in modes)), law)
    assert vanishes(sp.Add(*modes) ** 2 - sp.Add(*(a * b for a in modes for b in modes)), law)

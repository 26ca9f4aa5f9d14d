"""Lossy gears beside shafts without inertia, and the Gearbox that is made so.

Independent: by hand, the torque u of the lash leaves the gear, so that (u + tau1)/eta1 or (u + tau2) eta2 enters, integrated
by scipy; and the same trains with small inertias there, extrapolated to none.
"""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

T = np.linspace(0.0, 2.0, 41)
LOSSES = {
    "efficiency": {"efficiency": (0.9, 0.8)},
    "bearing": {"efficiency": (0.9, 0.8), "bearing": (1.0, 1.0)},
    "table": {"loss_table": ((0.0, 0.95, 0.9, 0.2, 0.2), (10.0, 0.9, 0.85, 0.5, 0.5), (50.0, 0.8, 0.75, 1.0, 1.0))},
}


def _ends(rig: gb.Drivetrain) -> tuple[gb.Block, gb.Block]:
    one, other = rig.add("one", gb.Inertia(J=0.3, w0=10.0)), rig.add("other", gb.Inertia(J=0.5, w0=4.0))
    rig.connect(rig.add("drive", gb.Torque(tau=60 * gb.sin(7 * gb.time))).flange, one.a)
    rig.connect(rig.add("load", gb.Torque(tau=-0.5 * gb.sense("other.w"))).flange, other.a)
    return one, other


def _gearbox(**losses: object) -> gb.Drivetrain:
    rig = gb.Drivetrain("gearbox")
    one, other = _ends(rig)
    rig.chain(
        one,
        rig.add("box", gb.Gearbox(ratio=2.5, k=500.0, c=2.0, half_gap=0.02, contact_damping="always", **losses)),
        other,
    )
    return rig


def _by_hand(eta1: float, eta2: float, tau: float) -> np.ndarray:
    """Speeds of both ends while w_a stays away from 0: no more than that is asked for, so that nothing sticks."""

    def rates(t: float, y: np.ndarray) -> list[float]:
        w1, w2, z = y  # z = phi_2 - phi_1/i
        gap = max(abs(z) - 0.02, 0.0) * np.sign(z)
        pull = 500.0 * gap + 2.0 * (w2 - w1 / 2.5)
        d = np.sign(w1)
        m = -d * pull / 2.5 + tau
        enters = d * (m / eta1 if m >= 0 else m * eta2)
        return [(60 * np.sin(7 * t) - enters) / 0.3, (-pull - 0.5 * w2) / 0.5, w2 - w1 / 2.5]

    run = solve_ivp(rates, (0.0, 0.8), [10.0, 4.0, 0.0], t_eval=T[T <= 0.8], rtol=1e-11, atol=1e-12, max_step=1e-3)
    return np.array(run.y[:2])


@pytest.mark.parametrize("method", ["dp8", pytest.param("rodas", marks=pytest.mark.long)])
def test_a_gearbox_loses_what_leaves_through_its_lash_says(method: str) -> None:
    run = gb.simulate(_gearbox(**LOSSES["bearing"]), t=T[T <= 0.8], rtol=1e-9, method=method)
    assert run["one.w"].min() > 0.1
    found = np.array([run["one.w"], run["other.w"]])
    assert np.abs(found - _by_hand(0.9, 0.8, 1.0)).max() < 1e-7 * np.abs(found).max()
    assert run.energy.residual < 1e-9


def test_a_gearbox_reaches_both_sides_rest_and_its_gap() -> None:
    run = gb.simulate(_gearbox(**LOSSES["bearing"]), t=np.linspace(0, 2, 2001), rtol=1e-9)
    entering, leaving = run["box.gear.torque_a"], run["box.gear.torque"] / 2.5
    turns = run["box.gear.mode"] != 0
    lost = run["box.gear.loss_power"]
    assert (lost >= -1e-12).all()
    np.testing.assert_allclose(lost[turns], ((entering - leaving) * run["one.w"])[turns], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(run["box.gear.torque"], -run["box.lash.a.tau"], rtol=1e-9, atol=1e-9)


@pytest.mark.long
@pytest.mark.parametrize(
    "order", ["gear last", *(pytest.param(n, marks=pytest.mark.long) for n in ("gear first", "between shafts"))]
)
@pytest.mark.parametrize(
    "loss", ["efficiency", *(pytest.param(n, marks=pytest.mark.long) for n in ("bearing", "table"))]
)
def test_it_is_the_limit_of_vanishing_inertias(order: str, loss: str) -> None:
    def rig(J: float | None) -> gb.Drivetrain:
        rig = gb.Drivetrain(order)
        one, other = _ends(rig)
        gear = rig.add("gear", gb.LossyGear(ratio=2.5, **LOSSES[loss]))
        first, second = gb.Shaft(k=500.0, c=2.0), gb.Shaft(k=800.0, c=1.0)
        before = [rig.add("first", first)] if order != "gear first" else []
        behind = [rig.add("second", second)] if order != "gear last" else []
        rig.chain(one, *before, gear, *behind, other)
        for name, at in (*((("a", gear.a),) * len(before)), *((("b", gear.b),) * len(behind))) if J else ():
            rig.connect(at, rig.add(name, gb.Inertia(J=J)).a)
        return rig

    run = gb.simulate(rig(None), t=T, rtol=1e-9)
    assert run.energy.residual < 1e-8
    limit = [gb.simulate(rig(J), t=T, rtol=1e-8) for J in (4e-5, 2e-5, 1e-5)]
    for body in ("one.w", "other.w"):
        first, second = (2 * b[body] - a[body] for a, b in itertools.pairwise(limit))
        assert np.abs(run[body] - (4 * second - first) / 3).max() < 1e-6 * np.abs(run[body]).max()


@pytest.mark.long
def test_start_angles_pass_through_a_lossy_gear_to_the_shaft_behind_it() -> None:
    rig = gb.Drivetrain("wound up")
    one, other = rig.add("one", gb.Inertia(J=0.3, phi0=0.5)), rig.add("other", gb.Inertia(J=0.5))
    rig.chain(one, rig.add("box", gb.Gearbox(ratio=2.5, efficiency=(0.9, 0.8), k=500.0, c=2.0)), other)
    assert gb.simulate(rig, t_end=0.01)["box.lash.twist"][0] == -0.2


@pytest.mark.long
def test_a_gearbox_without_losses_or_without_compliance_is_what_is_left() -> None:
    rig = _gearbox(**LOSSES["bearing"])
    assert set(rig.effects()) == {"box.loss", "box.compliance", "box.backlash", "box.damping"}
    rigid, easy = rig.without("*.compliance"), rig.without("*.loss")
    assert set(rigid.effects()) == {"box.loss"}
    assert set(easy.effects()) == {"box.compliance", "box.backlash", "box.damping"}
    assert gb.simulate(rigid, t_end=0.1)["box.gear.loss_power"][-1] > 0
    assert gb.simulate(easy, t_end=0.1)["box.gear.loss_power"][-1] == 0


def test_fields_that_need_compliance_say_so() -> None:
    rig = gb.Drivetrain("gap without stiffness")
    with pytest.raises(gb.ModelError, match=r"half_gap = 0\.02 needs k"):
        rig.add("box", gb.Gearbox(ratio=2.0, half_gap=0.02))


@pytest.mark.parametrize(("losses", "rule"), [
    ({"efficiency": (0.9, 0.8), "bearing": (1.0, 3.0)}, "tau1 = tau2"), ({"efficiency": (0.6, -0.4)}, "eta2 > 0"),
])  # fmt: skip
def test_losses_that_the_torques_at_a_shaft_without_inertia_do_not_tell_are_refused(
    losses: dict[str, tuple[float, float]], rule: str
) -> None:
    rig = gb.Drivetrain("gear last")
    one, other = _ends(rig)
    gear, shaft = rig.add("gear", gb.LossyGear(ratio=2.5, **losses)), rig.add("shaft", gb.Shaft(k=500.0, c=2.0))
    rig.chain(one, shaft, gear, other)
    with pytest.raises(gb.ModelError, match=f"'gear'.*{rule}.*put an Inertia there"):
        gb.build(rig)


@pytest.mark.long
def test_a_start_angle_passed_through_a_lossy_gear_is_one_parameter() -> None:
    rig = gb.Drivetrain("one start")
    motor, box = (
        rig.add("motor", gb.Inertia(J=0.3, phi0=0.5)),
        rig.add("box", gb.Gearbox(ratio=2.0, efficiency=(0.9, 0.8))),
    )
    rig.chain(motor, box, rig.add("load", gb.Inertia(J=0.5)))
    assert [p.path for p in gb.build(rig).program.parameters].count("motor.phi0") == 1


def _before_a_pair(inertia: float) -> gb.Drivetrain:
    """A gear with losses whose far side is a shaft that a varying ratio moves."""
    rig = gb.Drivetrain("before a pair")
    one, two = rig.add("one", gb.Inertia(J=0.3)), rig.add("two", gb.Inertia(J=0.2))
    between = [rig.add("between", gb.Inertia(J=inertia))] if inertia else []
    gear = rig.add("gear", gb.LossyGear(ratio=1.5, **LOSSES["table"]))
    pair = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.25, order=1), external=True))
    rig.chain(rig.add("drive", gb.Torque(tau=1.0)), one, gear, *between, pair, two)
    return rig


@pytest.mark.parametrize("initial", [None, gb.rolling({"one.w": 8.0})], ids=["from rest", "rolling"])
def test_a_shaft_without_inertia_between_it_and_a_varying_ratio(initial):
    start = {"initial": initial} if initial else {}
    w, near, far = (
        gb.simulate(_before_a_pair(J), t=T, rtol=1e-10, method="dp8", **start)["one.w"] for J in (0.0, 1e-4, 2e-4)
    )
    assert w == pytest.approx(2 * near - far, abs=1e-6 * np.max(np.abs(w)))

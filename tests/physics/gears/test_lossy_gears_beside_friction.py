"""A lossy gear at rest beside a clutch over the same shafts, friction on its driven side, a load that rises or jumps.

Closed form: a clutch that pulls against the load puts more force on the tie, and what the gear loses grows with it. With
efficiencies (eta1, .), the ratio i > 1, the friction F on b and the clutch at the bound -C the load T on a is held up to

    T = F/(i eta1) + (1/(i eta1) - 1) C

Sliding it carries T = F/(i eta1) + (1 - 1/(i eta1)) C, less than that: both are possible between, and what can rest does.
"""

import numpy as np
import pytest

import gearblocks as gb

RATIO, ETA1, FRICTION, CAPACITY = 2.0, 0.4, 4.0, 2.29
MORE = 1 / (RATIO * ETA1)


def _train(
    tau: object, *, peak: float | None = None, bound: str = "load", aside: bool = False, pair: bool = False
) -> gb.Drivetrain:
    """Gear and clutch between a and b; what holds b; another clutch aside that has nothing to do with them; at a an
    elliptic pair and a freewheel."""
    rig = gb.Drivetrain("beside")
    a, b = rig.add("a", gb.Inertia(J=1.0, w0=0.0)), rig.add("b", gb.Inertia(J=0.5))
    gear = rig.add("gear", gb.LossyGear(ratio=RATIO, efficiency=(ETA1, 0.6)))
    clutch = rig.add("clutch", gb.Clutch(capacity=CAPACITY, **({} if peak is None else {"peak": peak})))
    rig.connect(a.a, gear.a, clutch.a)
    rig.connect(b.a, gear.b, clutch.b)
    rig.connect(rig.add("torque", gb.Torque(tau=tau)).flange, a.b)
    load, brake = gb.SpeedLoad(coeffs=(FRICTION, 0.0, 0.0)), gb.Brake(capacity=FRICTION)
    rig.chain(b, rig.add("hold", load if bound == "load" else brake))
    if aside:
        one, two = rig.add("one", gb.Inertia(J=1.0, w0=0.0)), rig.add("two", gb.Inertia(J=1.0, w0=0.0))
        rig.chain(rig.add("push", gb.Torque(tau=tau)), one, rig.add("grip", gb.Clutch(capacity=1.0)), two)
    if pair:
        ellipse = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.1, order=1), external=True))
        free, far = rig.add("free", gb.Freewheel()), rig.add("far", gb.Inertia(J=1.0))
        rig.connect(a.a, ellipse.a, free.a)
        rig.connect(far.a, ellipse.b)
        rig.connect(free.b, rig.add("ground", gb.Fixed()).flange)
    return rig


def _held(capacity: float) -> float:
    return FRICTION * MORE + (MORE - 1) * capacity


SLIDING = FRICTION * MORE - (MORE - 1) * CAPACITY
INERTIA = 1.0 + 0.5 / (RATIO**2 * ETA1)


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("peak", "bound"), [(None, "load"), (1.3, "load"), (1.3, "brake"), (None, "brake")])
@pytest.mark.few(1)
def test_it_breaks_away_where_no_split_holds_the_load_any_more(
    peak: float | None, bound: str, sign: float, method: str
) -> None:
    slope, end = 8.0, 1.0
    breaks = _held(CAPACITY * (peak or 1.0)) / slope
    swept = slope * (end**2 - breaks**2) / 2 - SLIDING * (end - breaks)
    for rtol in (1e-4, 1e-8):
        run = gb.simulate(_train(sign * slope * gb.time, peak=peak, bound=bound), t_end=end, method=method, rtol=rtol)
        gone = next(e for e in run.events if e.component == "gear")
        assert gone.t == pytest.approx(breaks, rel=1e-9), rtol
        assert sign * run["a.w"][-1] == pytest.approx(swept / INERTIA, rel=max(10 * rtol, 1e-8)), rtol
        assert run.energy.residual < 10 * rtol


@pytest.mark.long
@pytest.mark.parametrize("aside", [False, True])
@pytest.mark.parametrize("peak", [None, 1.3])
def test_a_load_that_jumps_to_what_can_be_held_is_held(peak: float | None, aside: bool) -> None:
    """Also where a clutch aside lets go at the same instant."""
    most = _held(CAPACITY * (peak or 1.0))
    tau = gb.Table([0.0, 0.2, 0.4, 0.6, 0.8], [0.99 * most, -0.99 * most, 0.3, 0.99 * most, 1.01 * most], kind="step")
    run = gb.simulate(_train(tau, peak=peak, aside=aside), t_end=1.0)
    assert abs(run["a.w"][run.t <= 0.8]).max() == 0.0
    assert run["a.w"][-1] == pytest.approx((1.01 * most - SLIDING) * 0.2 / INERTIA, rel=1e-5)


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
def test_gear_clutch_and_freewheel_behind_an_ellipse_hold_a_load_that_swings(method: str) -> None:
    """As far as the load goes it can be held, by less than what the clutch holds."""
    load = gb.Table([0.0, 0.44, 0.5], [0.0, -1.05 * SLIDING, 0.0])
    rig = _train(load, peak=1.3, pair=True)
    run = gb.simulate(rig, t_end=0.5, method=method)
    assert abs(run["a.w"]).max() == 0.0
    assert not [e for e in run.events if e.kind == "state"]


def _side_by_side(paths: str, held: float) -> gb.Drivetrain:
    """A load that rises on a, gears of ratio 6 side by side between a and b, and a brake on b."""
    rig = gb.Drivetrain("side by side")
    a, b = rig.add("a", gb.Inertia(J=1.0)), rig.add("b", gb.Inertia(J=2.0))
    rig.connect(rig.add("load", gb.Torque(tau=2.0 * gb.time)).flange, a.a)
    losses = {"efficiency": (0.9, 0.8), "bearing": (0.3, 0.3)}
    for i, path in enumerate(paths):
        if path == "i":
            gear = rig.add(f"gear{i}", gb.IdealGear(ratio=6.0))
            rig.connect(a.b, gear.a)
            rig.connect(gear.b, b.a)
            continue
        first = rig.add(f"gear{i}", gb.LossyGear(ratio=6.0 if path == "l" else 2.0, **losses))
        rig.connect(a.b, first.a)
        if path == "l":
            rig.connect(first.b, b.a)
            continue
        last = rig.add(f"last{i}", gb.LossyGear(ratio=3.0, **losses))
        rig.connect(first.b, rig.add(f"between{i}", gb.Inertia(J=0.1)).a, last.a)
        rig.connect(last.b, b.a)
    if held:
        rig.connect(rig.add("hold", gb.Brake(capacity=held)).a, b.b)
    return rig


@pytest.mark.parametrize("held", [0.0, 3.0])
@pytest.mark.parametrize(("paths", "most"), [("ll", 0.6 / 0.9), ("lll", 0.9 / 0.9), ("li", 0.3 / 0.9), ("ls", None)])
@pytest.mark.few(1)
def test_gears_side_by_side_press_on_each_other_no_more_than_the_load_asks(
    paths: str, most: float | None, held: float
) -> None:
    """Forces that circulate would hold any load by what the gears lose. Of lossy gears each takes an equal part of the load;
    an ideal gear (i) takes it all; of two in a row (s) there are bounds alone."""
    run = gb.simulate(_side_by_side(paths, held), t_end=4.0)
    gone = min((e.t for e in run.events if e.component == "gear0"), default=np.inf)
    if most is not None:
        assert 2.0 * gone == pytest.approx(most + held / (6.0 * (1.0 if "i" in paths else 0.9)), rel=1e-8)
    assert 0.3 / 0.9 + held / 6.0 < 2.0 * gone + 1e-9 < 3.0
    assert run["a.w"][-1] > 1.0
    assert run.energy.residual < 1e-5

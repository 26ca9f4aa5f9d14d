"""A load that rises from nothing while friction holds it behind a gear whose other shafts are free: until it breaks away all
that moves is the rounding of the forces.

Closed form: held up to the static peak, then the excess over the sliding torque on the inertia of the set as the carrier
sees it, whose sun and ring answer to the force of the tie alone.
"""

import pytest

import gearblocks as gb

FREE, OTHER, HELD, SLOPE, START, CAPACITY = 0.0318, 0.0371, 0.886, 40.2, 0.474, 8.53


def _train(ratio: float | None, hold: str, peak: float, late: float) -> gb.Drivetrain:
    """A planetary set (without a ratio: a differential) whose carrier is loaded and held."""
    rig = gb.Drivetrain("ramp")
    free, other, held = (
        rig.add(name, gb.Inertia(J=J, **{} if name == "held" else {"w0": 0.0}))
        for name, J in (("free", FREE), ("other", OTHER), ("held", HELD))
    )
    if ratio is None:
        pair = rig.add("pair", gb.Differential())
        rig.connect(free.a, pair.right)
        rig.connect(other.a, pair.left)
        rig.connect(held.a, pair.carrier)
    else:
        gear = rig.add("gear", gb.IdealPlanetary(ratio=ratio))
        rig.connect(free.a, gear.ring)
        rig.connect(other.a, gear.sun)
        rig.connect(held.a, gear.carrier)
    if hold == "brake":
        rig.chain(held, rig.add("hold", gb.Brake(capacity=CAPACITY, peak=peak)))
    else:
        rig.chain(held, rig.add("hold", gb.BearingFriction(coulomb=CAPACITY, peak=peak)))
    tau = gb.piecewise((SLOPE * (gb.time - late), gb.time > late), (0.0, True))
    rig.chain(rig.add("torque", gb.Torque(tau=tau)), held)
    return rig


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize(
    ("ratio", "hold", "peak", "late"),
    [
        (2.5, "brake", 1.3, START),
        (0.4, "bearing", 1.2, START),
        (None, "brake", 1.0, START),
        (None, "bearing", 1.1, 1.06),
    ],
)
@pytest.mark.few(1)
def test_it_breaks_away_when_and_as_fast_as_the_load_says(
    ratio: float | None, hold: str, peak: float, late: float, method: str
) -> None:
    end, breaks = late + 0.6, late + peak * CAPACITY / SLOPE
    r = 1.0 if ratio is None else ratio
    inertia = HELD + (1 + r) ** 2 / (r**2 / FREE + 1 / OTHER)
    swept = SLOPE * ((end - late) ** 2 - (breaks - late) ** 2) / 2 - CAPACITY * (end - breaks)
    for rtol in (1e-3, 1e-5, 1e-7):
        run = gb.simulate(_train(ratio, hold, peak, late), t_end=end, method=method, rtol=rtol)
        assert run.events[-1].t == pytest.approx(breaks, rel=1e-8), rtol
        assert run["held.w"][-1] == pytest.approx(swept / inertia, rel=10 * rtol), rtol
        assert run.energy.residual < 10 * rtol
        assert run.stats.steps < 2000, rtol


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize("late", [0.0, 1.06])
@pytest.mark.parametrize(
    ("tau1", "tau2", "eta2"), [(0.09, 0.009, 0.9), (0.7, 0.3, 0.5), (0.2, 0.2, 0.9), (0.02, 0.3, 0.8)]
)
@pytest.mark.few(1)
def test_a_lossy_gear_breaks_away_where_its_losses_jump(
    tau1: float, tau2: float, eta2: float, late: float, method: str
) -> None:
    """b is driven, nothing enters at a: it holds the larger loss, and turns against the smaller one if a drives worse."""
    rig, slope = gb.Drivetrain("jump"), 2.0
    first, second = rig.add("first", gb.Inertia(J=FREE)), rig.add("second", gb.Inertia(J=OTHER))
    gear = rig.add("gear", gb.LossyGear(ratio=1.0, efficiency=(0.9, eta2), bearing=(tau1, tau2)))
    rig.connect(first.a, gear.a)
    rig.connect(gear.b, second.a)
    ramp = gb.piecewise((slope * (gb.time - late), gb.time > late), (0.0, True))
    rig.chain(rig.add("torque", gb.Torque(tau=ramp)), second)
    holds = max(tau1, tau2)
    breaks, end = late + holds / slope, late + 1.5 * holds / slope
    swept = slope * ((end - late) ** 2 - (breaks - late) ** 2) / 2 - tau2 * (end - breaks)
    for rtol in (1e-3, 1e-6, 1e-9):
        run = gb.simulate(rig, t_end=end, method=method, rtol=rtol)
        assert run.events[-1].t == pytest.approx(breaks, rel=1e-8), rtol
        assert run["second.w"][-1] == pytest.approx(swept / (OTHER + FREE / eta2), rel=10 * rtol), rtol
        assert run.energy.residual < 10 * rtol
        assert run.stats.steps < 2000, rtol


@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.parametrize(
    ("loaded", "carried", "late"),
    [
        ((0.09, 0.009, 0.93), (0.026, 0.77), 0.0),  # until the losses of the loaded gear jump
        ((0.09, 0.009, 0.93), (0.01, 1.0), 1.06),
        ((0.09, 0.009, 0.93), (0.3, 0.77), 1.06),  # the other one holds more than that
        ((0.05, 0.05, 0.5), (0.026, 0.77), 0.0),
        ((0.02, 0.07, 0.8), (0.026, 0.9), 0.0),
    ],
)
@pytest.mark.few(1)
def test_two_lossy_gears_at_rest_hold_what_any_split_between_them_can(
    loaded: tuple[float, float, float], carried: tuple[float, float], late: float, method: str
) -> None:
    """b of one is driven, b of two is free: one holds tau1 alone, or passes on what two holds.

    The instant is told to 1e-8 of the slip accelerations, which is what singular problems with coupled bounds are lifted by.
    """
    (tau1, tau2, eta2), (held, eta1), slope = loaded, carried, 2.0
    rig = gb.Drivetrain("row")
    first, second, third = (rig.add(n, gb.Inertia(J=J)) for n, J in (("a", OTHER), ("b", FREE), ("c", HELD)))
    one = rig.add("one", gb.LossyGear(ratio=1.0, efficiency=(0.9, eta2), bearing=(tau1, tau2)))
    two = rig.add("two", gb.LossyGear(ratio=1.0, efficiency=(eta1, 0.5), bearing=(held, held)))
    rig.connect(first.a, one.b)
    rig.connect(second.a, one.a, two.a)
    rig.connect(third.a, two.b)
    ramp = gb.piecewise((slope * (gb.time - late), gb.time > late), (0.0, True))
    rig.chain(rig.add("torque", gb.Torque(tau=ramp)), first)
    slides = tau2 + held / (eta1 * eta2)
    breaks, end = late + max(tau1, slides) / slope, late + 1.5 * max(tau1, slides) / slope
    swept = slope * ((end - late) ** 2 - (breaks - late) ** 2) / 2 - slides * (end - breaks)
    for rtol in (1e-3, 1e-6, 1e-9):
        run = gb.simulate(rig, t_end=end, method=method, rtol=rtol)
        assert run.events[-1].t == pytest.approx(breaks, abs=1e-6), rtol
        assert run["a.w"][-1] == pytest.approx(swept / (OTHER + (FREE + HELD / eta1) / eta2), rel=10 * rtol), rtol
        assert run.energy.residual < 10 * rtol
        assert run.stats.steps < 2000, rtol

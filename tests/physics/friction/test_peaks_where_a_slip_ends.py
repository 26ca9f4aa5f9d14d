"""Static peaks where the slip of a neighbour ends: which of them gives way follows from the way of the forces.

The friction whose slip ends turns its force around, and takes those of its neighbours along; what comes to its peak first
breaks. What passes a slip of zero without sticking has its peak for no time. A peak is the limit of a friction that falls
over a narrow range of slip: such tables (`Brake(mu=...)`) tell the same without any rule.
"""

import pytest

import gearblocks as gb

METHODS = ["auto", "dp5", "dp8", "rodas"]
WIDTH = 1e-5  # rad/s


def _rubs(block, sliding, peak, width):
    if width is None:
        return block(capacity=sliding, peak=peak / sliding)
    return block(mu=gb.Table([0.0, width, 1000.0], [peak, sliding, sliding]), force_max=1.0, engagement=1.0)


def _between_brake_and_clutch(load, width=None):
    """Both turn at 0.3 rad/s, the clutch stuck; two brakes on the second one; a load that turns them around."""
    rig = gb.Drivetrain("two")
    a, b = rig.add("a", gb.Inertia(J=1.0, w0=0.3)), rig.add("b", gb.Inertia(J=0.5, w0=0.3))
    clutch = rig.add("clutch", _rubs(gb.Clutch, 1.86, 2.79, width))
    one, other = (
        rig.add("one", _rubs(gb.Brake, 1.2, 2.4, width)),
        rig.add("other", _rubs(gb.Brake, 0.285, 0.342, width)),
    )
    rig.chain(rig.add("load", gb.Torque(tau=load)), a, clutch, b)
    rig.connect(b.b, one.a, other.a)
    return rig


def _row(width=None):
    """a and b turn together through c; d comes up to them through e, whose slip ends."""
    rig = gb.Drivetrain("row")
    a, b = (rig.add(n, gb.Inertia(J=J, w0=5.5)) for n, J in (("a", 0.0643), ("b", 0.151)))
    d = rig.add("d", gb.Inertia(J=0.248, w0=5.467))
    c, e = rig.add("c", _rubs(gb.Clutch, 0.6622, 1.3244, width)), rig.add("e", _rubs(gb.Clutch, 1.01, 2.02, width))
    loads = [rig.add(n, gb.Torque(tau=tau)) for n, tau in (("left", -1.3), ("right", 1.547))]
    rig.chain(loads[0], a, c, b, e, d, loads[1])
    return rig


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.few(2)
def test_brakes_that_come_to_rest_hold_and_the_clutch_beside_them_breaks(method):
    """Until then w' = (-3.2 - 1.485)/1.5; on the way of the brakes to their 2.742 N m the clutch comes to 2.79 N m."""
    run = gb.simulate(_between_brake_and_clutch(-3.2), t_end=0.3, method=method)
    rests = 0.3 * 1.5 / (3.2 + 1.485)
    assert run["b.w"][-1] == 0.0
    assert run["a.w"][-1] == pytest.approx((-3.2 + 1.86) * (0.3 - rests), rel=1e-6)
    assert (run["clutch.mode"][-1], run["one.mode"][-1], run["other.mode"][-1]) == (1.0, 0.0, 0.0)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.few(2)
def test_brakes_that_come_to_their_peak_first_let_both_pass(method):
    run = gb.simulate(_between_brake_and_clutch(-2.9), t_end=0.3, method=method)
    rests = 0.3 * 1.5 / (2.9 + 1.485)
    assert run["a.w"][-1] == pytest.approx((-2.9 + 1.485) / 1.5 * (0.3 - rests), rel=1e-6)
    assert run["clutch.mode"][-1] == 0.0


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.few(2)
def test_a_clutch_whose_slip_ends_sticks_and_what_it_loads_breaks(method):
    """d gains (1.547 + 1.01)/0.248 on a and b, which lose 2.31/0.2153; then c slides and b and d go together."""
    run = gb.simulate(_row(), t_end=0.02, method=method)
    up, down = (1.547 + 1.01) / 0.248, (1.3 + 1.01) / (0.0643 + 0.151)
    meets = 0.033 / (up + down)
    at, rest = 5.467 + up * meets, 0.02 - meets
    assert run["a.w"][-1] == pytest.approx(at + (0.6622 - 1.3) / 0.0643 * rest, rel=1e-7)
    assert run["d.w"][-1] == pytest.approx(at + (1.547 - 0.6622) / (0.151 + 0.248) * rest, rel=1e-7)
    assert run["e.mode"][-1] == 0.0


def _passing(width=None):
    """A clutch whose slip turns around against 4 N m and more; the brake beside it holds what it passes on while it slides."""
    rig = gb.Drivetrain("passing")
    a, b = rig.add("a", gb.Inertia(J=0.65, w0=0.5)), rig.add("b", gb.Inertia(J=0.95))
    clutch, brake = (rig.add(n, _rubs(block, x, 2 * x, width)) for n, block, x in PASSING)
    rig.chain(rig.add("left", gb.Torque(tau=-5.0)), a, clutch, b)
    rig.connect(b.b, brake.a, rig.add("right", gb.Torque(tau=-0.9)).flange)
    return rig


PASSING = (("clutch", gb.Clutch, 1.6), ("brake", gb.Brake, 1.53))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.few(2)
def test_a_slip_that_passes_zero_has_its_peak_for_no_time(method):
    """a loses 6.6/0.65, then 3.4/0.65. The clutch carries 1.6 N m; its peak of 3.2 N m would turn the brake of 3.06 N m."""
    run = gb.simulate(_passing(), t_end=0.2, method=method)
    turns = 0.5 * 0.65 / 6.6
    assert run["a.w"][-1] == pytest.approx(-3.4 / 0.65 * (0.2 - turns), rel=1e-7)
    assert run["b.w"][-1] == 0.0


TRAINS = {
    "load 2.9": lambda width: _between_brake_and_clutch(-2.9, width),
    "load 3.2": lambda width: _between_brake_and_clutch(-3.2, width),
    "load 4": lambda width: _between_brake_and_clutch(-4.0, width),
    "row": _row,
    "passing": _passing,
}


@pytest.mark.long
@pytest.mark.parametrize("train", TRAINS)
def test_tables_that_fall_over_a_narrow_slip_tell_the_same(train):
    with_peaks, narrow = (gb.simulate(TRAINS[train](width), t_end=0.2, rtol=1e-8) for width in (None, WIDTH))
    for name in ("a.w", "b.w"):
        assert abs(with_peaks[name][-1] - narrow[name][-1]) < 1e-4

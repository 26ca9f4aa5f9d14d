"""What impacts do to the modes of the reference, each against a closed form."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from tests.random.description import GROUND, Part, Train  # noqa: E402
from tests.random.expressions import thing  # noqa: E402
from tests.random.families import draw  # noqa: E402
from tests.random.reference import reference_motion  # noqa: E402
from tests.random.reference.switches import NoEvidenceError  # noqa: E402

T = np.linspace(0.0, 1.0, 11)


def _train(*parts, t_end=1.0):
    return Train("closed form", 0, parts, t_end, None)


def _body(name, J=1.0, **fields):
    return Part(name, "Inertia", (("J", J), *fields.items()), (("a", name),))


def _hits(a, b, restitution, half_gap=0.1):
    damping = thing("HuntCrossley", restitution=restitution)
    fields = (("k", 1e3), ("half_gap", half_gap), ("contact_damping", damping), ("hits", True))
    return Part(f"{a}_{b}", "Lash", fields, (("a", a), ("b", b)))


@pytest.mark.parametrize("e", [1.0, 0.6, 0.1])
@pytest.mark.parametrize(("m", "M", "ahead", "V"), [(1.0, 1.0, 1e-3, 2.0), (0.3, 2.0, 0.5, 1.5), (4.0, 1.0, 0.2, 3.0)])
@pytest.mark.parametrize("block", ["Freewheel", "OneWayClutch"])
@pytest.mark.few(1)
def test_a_one_way_lock_that_is_ahead_is_caught_after_the_impact_that_throws_it_back(e, m, M, ahead, V, block):
    # momentum and restitution of the two bodies, then the lock takes what is left: no energy comes from either
    lock = Part("lock", block, (("capacity", 0.0),) if block == "OneWayClutch" else (), (("a", GROUND), ("b", "p")))
    bodies = _body("p", J=m, w0=ahead), _body("w", J=M, w0=-V)
    train = _train(*bodies, lock, _hits("p", "w", e))
    common = (m * ahead - M * V) / (m + M)
    thrown, rebound = common - M * e * (V + ahead) / (m + M), common + m * e * (V + ahead) / (m + M)
    assert thrown < 0.0
    while rebound < 0.0:  # what rests by now is hit once more
        rebound *= -e
    hit = 0.1 / (V + ahead)
    motion = reference_motion(train, np.array([0.0, 0.99 * hit, 1.01 * hit]))
    assert motion.speeds[:, 1] == pytest.approx([ahead, -V], abs=1e-12)
    assert motion.speeds[:, -1] == pytest.approx([0.0, rebound], abs=1e-11)
    assert M * rebound**2 <= m * ahead**2 + M * V**2


def _slider(k, up, end):
    """Angle and speed of a body that slides under its load, and from an impact on, by hand: what holds is k, or slips at F."""
    load, friction, gap = -3.0, 2.0, 0.05

    def until(event, y, t, holds):
        def rates(_, z):
            return z[1], load - z[2], k * z[1] if holds else 0.0, up

        def found(time, z):
            return event(time, z)

        found.terminal = True
        run = solve_ivp(rates, (t, end), y, method="DOP853", rtol=1e-12, atol=1e-15, events=[found])
        return run.t[-1], run.y[:, -1]

    def slips(_, z):
        return z[2] + friction

    t, y = until(slips, np.array([0.0, -1.0, 0.0, 0.0]), 0.0, True)
    t, y = until(lambda _, z: z[0] - z[3] + gap, np.array([y[0], y[1], -friction, y[3]]), t, False)
    t, y = until(slips, np.array([y[0], up, y[2] * (1 - 1e-15), 0.0]), t, True)
    return until(lambda _t, _z: 1.0, np.array([y[0], y[1], -friction, 0.0]), t, False)[1][:2]


@pytest.mark.parametrize("span", [0.2, 3.0, 20.0])
@pytest.mark.parametrize(("k", "up"), [(1e8, 1e-4), (4e8, 5e-5), (1e7, 1e-4)])
@pytest.mark.few(1)
def test_a_slider_that_an_impact_turns_round_for_an_instant_holds_for_that_instant(k, up, span):
    # it slips down, is thrown up by a body of its own mass that comes its way, and slips down again once it is where it was
    inner = thing("Hysteresis", friction=2.0, stiffness=k)
    shaft = Part("s", "Shaft", (("k", 1e-12), ("hysteresis", inner)), (("a", GROUND), ("b", "x")))
    load = Part("load", "Torque", (("tau", -3.0),), (("flange", "x"),))
    bodies = _body("x", w0=-1.0), _body("h", w0=up)
    train = _train(*bodies, shaft, load, _hits("h", "x", 1.0, 0.05), t_end=span)
    motion = reference_motion(train, np.array([0.0, 0.12, span]))
    expected = _slider(k, up, 0.12)
    assert motion.angles[0, 1] == pytest.approx(expected[0], abs=1e-9)
    assert motion.speeds[0, 1] == pytest.approx(expected[1], abs=1e-8)


@pytest.mark.parametrize(("depth", "w0"), [(0.05, 2.0), (0.02, 0.5), (0.1, -1.0)])
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.few(2)
def test_a_contact_in_which_a_run_begins_is_not_damped_until_it_has_ended(depth, w0, side):
    k, gap, e = 400.0, 0.1, 0.4
    fields = (("k", k), ("half_gap", gap), ("contact_damping", thing("HuntCrossley", restitution=e)))
    play = Part("l", "Lash", fields, (("a", GROUND), ("b", "j")))
    train = _train(_body("j", w0=side * w0, phi0=side * (gap + depth)), play)
    leaves = math.hypot(math.sqrt(k) * depth, w0)  # undamped
    out = (math.pi / 2 + math.atan(w0 / (math.sqrt(k) * depth))) / math.sqrt(k)
    over = out + 2 * gap / leaves  # at the other side, which throws it back with e times its speed
    motion = reference_motion(train, np.array([0.0, 0.5 * (out + over), over + 0.12 / e]))
    assert motion.speeds[0, 1] == pytest.approx(-side * leaves, rel=1e-9)
    assert side * motion.speeds[0, 2] == pytest.approx(e * leaves, rel=1e-8) or side * motion.angles[0, 2] > gap


@pytest.mark.parametrize("pull", [1e-10, 1e-5])
@pytest.mark.parametrize(
    ("m", "M", "wall", "e"), [(1.0, 3.0, 0.0, 1.0), (1.0, 100.0, 0.0, 0.8), (2.0, 1.0, 0.0, 1.0), (1.0, 5.0, 0.6, 1.0)]
)
@pytest.mark.few(2)
def test_a_body_that_is_pulled_off_its_wall_is_struck_apart_from_it(m, M, wall, e, pull):
    stop = Part("stop", "HardStop", (("upper", 0.0), ("restitution", wall)), (("a", "p"),))
    load = Part("load", "Torque", (("tau", -pull),), (("flange", "p"),))
    train = _train(_body("p", J=m), _body("w", J=M, w0=2.0), stop, load, _hits("p", "w", e, 1e-3))
    motion = reference_motion(train, np.array([0.0, 4e-4, 6e-4]))
    v, w = 0.0, 2.0
    while v > 1e-12 or w - v > 1e-12:  # the wall and the other body in turn
        common, apart = (m * v + M * w) / (m + M), e * (w - v) / (m + M)
        v, w = (-wall * v, w) if v > 1e-12 else (common + M * apart, common - m * apart)
    assert motion.speeds[:, 2] == pytest.approx([v, w], abs=1e-8)


@pytest.mark.parametrize("above", [3e-8, 1e-9, 4.5e-8])
@pytest.mark.parametrize("restitution", [0.5, 0.05])
@pytest.mark.few(3)
def test_a_stop_is_struck_though_the_body_is_pulled_away_from_it_before_the_first_look(above, restitution):
    speed, pull, gap = 1e-3, 10.0, 0.1
    body = _body("p", phi0=-gap + above, w0=-speed)
    train = _train(
        body, _hits("p", GROUND, restitution, gap), Part("pull", "Torque", (("tau", pull),), (("flange", "p"),))
    )
    at = (speed - math.sqrt(speed**2 - 2 * pull * above)) / pull
    rebound = restitution * (speed - pull * at)
    t = np.linspace(0.0, 0.05, 6)
    motion = reference_motion(train, t)
    assert len(motion.jumps) == 1 and motion.jumps[0] == pytest.approx(at, rel=1e-6)
    assert motion.speeds[0, 1:] == pytest.approx(rebound + pull * (t[1:] - at), rel=1e-9)


def _hammered(m, M, e, dry, load, v, gap):
    """When a body at a stop, that a load pulls off it against friction, rests with the one that has come its way, by hand:
    it leaves, is struck, is stopped, leaves again."""
    t, off, on = 0.0, (load - dry) / m, (load + dry) / m
    while v > 1e-11:
        meets = 2 * gap / (v + math.sqrt(v * v + 2 * off * gap))
        way, w = 0.5 * off * meets**2, -off * meets
        common = (m * w + M * v) / (m + M)
        w, v = common + M * e * (v - w) / (m + M), common - m * e * (v - w) / (m + M)
        back = 2 * way / (w + math.sqrt(w * w - 2 * on * way))
        t, gap = t + meets + back, way - v * back  # it is at its stop again, the other one that far off
    return t


@pytest.mark.parametrize(("m", "M", "e"), [(0.2, 0.868, 0.556), (0.5, 3.0, 0.3), (0.1, 0.4, 0.7)])
@pytest.mark.parametrize(("dry", "load"), [(1.15, 20.0), (3.0, 5.0), (0.5, 90.0)])
@pytest.mark.few(2)
def test_what_friction_does_not_hold_at_its_stop_is_struck_off_it(m, M, e, dry, load):
    gap, v, end = 1e-3, 2.0, 0.3
    parts = (
        _body("x", J=m),
        _body("h", J=M, w0=v),
        Part("stop", "HardStop", (("restitution", 0.0), ("upper", 0.0)), (("a", "x"), ("b", GROUND))),
        Part("drag", "SpeedLoad", (("coeffs", (dry, 0.0, 0.0)),), (("flange", "x"),)),
        Part("load", "Torque", (("tau", -load),), (("flange", "x"),)),
    )
    motion = reference_motion(_train(*parts, _hits("h", "x", e, gap), t_end=end), np.array([0.0, end]))
    rests = _hammered(m, M, e, dry, load, v, gap)
    assert motion.speeds[:, -1] == pytest.approx([-(load - dry) / (m + M) * (end - rests)] * 2, rel=1e-6)


@pytest.mark.parametrize("e", [0.8, 0.4])
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("blocks", [("Freewheel", "Freewheel"), ("OneWayClutch", "Freewheel"), ("OneWayClutch",) * 2])
@pytest.mark.few(1)
def test_what_two_locks_hold_both_ways_is_a_wall(e, side, blocks):
    locks = [
        Part(
            f"lock{i}", block, (("capacity", 0.0),) if block == "OneWayClutch" else (), (("a", ends[0]), ("b", ends[1]))
        )
        for i, (block, ends) in enumerate(zip(blocks, (("x", GROUND), (GROUND, "x")), strict=True))
    ]
    train = _train(_body("x", J=0.2), _body("h", w0=2.0 * side), *locks, _hits("h", "x", e), t_end=0.1)
    motion = reference_motion(train, np.array([0.0, 0.07]))
    assert motion.speeds[:, -1] == pytest.approx([0.0, -2.0 * e * side], abs=1e-9)


@pytest.mark.parametrize(
    ("J", "e", "starts"),
    [((1.5, 0.03, 0.1), (0.3, 0.2), (0.0, 0.0, -4.0)), ((1.0, 0.05, 2.0), (0.1, 0.4), (1.0, 0.0, -2.0))],
)
def test_a_body_that_bounces_between_two_comes_to_rest_on_both(J, e, starts):
    # no load: from the end of its bounces on all three turn as their momentum says, to the last digit
    bodies = [_body(name, J=m, w0=w) for name, m, w in zip("abc", J, starts, strict=True)]
    train = _train(*bodies, _hits("a", "b", e[0], 0.01), _hits("b", "c", e[1], 0.0004), t_end=0.5)
    motion = reference_motion(train, np.linspace(0.0, 0.5, 6))
    together = sum(m * w for m, w in zip(J, starts, strict=True)) / sum(J)
    assert motion.speeds[:, -1] == pytest.approx([together] * 3, abs=1e-8)


def test_strikes_that_follow_so_closely_that_a_lock_has_hardly_slipped_between_them_are_no_evidence():
    """A light body to and fro between a wall and a heavy one: each flight is a 60th of the one before, with a lock on it that
    slips a little in each and is caught by each. Within ten flights nobody can tell that it does."""
    train = draw("mixed", 20000008)
    assert np.abs(reference_motion(train, np.array([0.0, 0.01637])).speeds[:, -1]).max() > 16.0
    with pytest.raises(NoEvidenceError, match="a lock that hardly slips"):
        reference_motion(train, np.array([0.0, 0.0164]))


def test_a_strike_on_what_a_cascade_left_beside_a_stop_that_nothing_presses_is_no_evidence():
    """A torque holds the first body at a stop; the second hammers on it until both rest; then the third strikes the second."""
    train = draw("contact", 30000409)
    with pytest.raises(NoEvidenceError, match="a stop that is hardly open"):
        reference_motion(train, np.linspace(0.0, 0.1, 5))
    before = reference_motion(train, np.linspace(0.0, 0.096, 5))
    assert np.abs(before.speeds[:2, -1]).max() < 1e-8


def test_a_stop_that_would_be_left_again_before_another_closes_is_hit():
    # thrown against one stop, and pulled back so soon that its gap would be open again when the other body hits its own
    stops = [Part(f"stop_{n}", "HardStop", (("lower", 0.0), ("restitution", 0.5)), (("a", n),)) for n in "ab"]
    pull = Part("pull", "Torque", (("tau", 10.0),), (("flange", "a"),))
    # a third body, fast and far, lets the step be longer than all of that
    far = _body("c", phi0=1e3, w0=1e3)
    bodies = far, _body("a", phi0=1e-9, w0=-1e-3), _body("b", phi0=2.1e-4, w0=-1.0)
    motion = reference_motion(_train(*bodies, *stops, pull, t_end=10.0), np.array([0.0, 0.5, 10.0]))
    hit = (1e-3 - math.sqrt(1e-6 - 2e-8)) / 10.0
    fast = 1e-3 - 10.0 * hit
    assert motion.jumps == pytest.approx([hit, 2.1e-4], rel=1e-9)
    assert motion.speeds[1:, 1] == pytest.approx([0.5 * fast + 10.0 * (0.5 - hit), 0.5], rel=1e-9)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("rounding", [0.0, 1e-17, -1e-17])
def test_a_contact_that_touches_begins_as_it_is_struck(way, rounding):
    # w gives its speed to p, which leaves q half of it more than momentum alone does
    fields = (("k", 500.0), ("half_gap", 0.0), ("contact_damping", thing("HuntCrossley", restitution=0.5)))
    lash = Part("lash", "Lash", fields, (("a", "p"), ("b", "q")))
    bodies = _body("p", phi0=rounding), _body("q"), _body("w", w0=way)
    motion = reference_motion(
        _train(*bodies, lash, _hits("w", "p", 1.0, half_gap=0.5), t_end=0.8), np.linspace(0.0, 0.8, 801)
    )
    slips = way * (motion.speeds[1] - motion.speeds[0])
    assert slips[499] == pytest.approx(0.0, abs=1e-12)
    assert slips[500:].min() == pytest.approx(-1.0, abs=0.02)
    assert slips[500:].max() == pytest.approx(0.5, abs=1e-3)

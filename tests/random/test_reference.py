"""The laws that the reference was given later, each against a closed form."""

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
from tests.random.expressions import SLIP, TIME, call, either, sense, table, thing  # noqa: E402
from tests.random.reference import NoEvidenceError, reference_motion  # noqa: E402
from tests.random.reference.steps import Steps  # noqa: E402

T = np.linspace(0.0, 1.0, 11)


def _train(*parts, t_end=1.0, initial=None):
    return Train("closed form", 0, parts, t_end, initial)


def _body(name, J=1.0, **fields):
    return Part(name, "Inertia", (("J", J), *fields.items()), (("a", name),))


def _push(node, tau):
    return Part(f"push {node}", "Torque", (("tau", tau),), (("flange", node),))


@pytest.mark.parametrize("rate", [-1.0, -3.0, 2.0])
def test_steps_keep_what_an_exponential_says(rate):
    steps = Steps(lambda t, y: rate * y, 0.0, np.array([1.0]), 1.0, 0.1, lambda y: 1e-12 * np.abs(y) + 1e-15)
    while steps.t < 1.0:
        piece = steps.step()
        middle = 0.5 * (piece.t_old + piece.t)
        assert piece(middle)[0] == pytest.approx(math.exp(rate * middle), rel=1e-9)
        assert piece.middle()[0] == pytest.approx(math.exp(rate * middle), rel=1e-4)
    assert steps.y[0] == pytest.approx(math.exp(rate), rel=1e-11)


@pytest.mark.parametrize(("lag", "gain", "target"), [(0.1, 0.5, 4.0), (0.02, 0.2, -2.0), (0.5, 1.0, 1.0)])
@pytest.mark.few(1)
def test_a_torque_reads_the_command_of_its_own_instant(lag, gain, target):
    # w' = u, u' = (gain (target - w) - u)/lag, inside the limits
    fields = (("target", target), ("gain", gain), ("time_constant", lag), ("lower", -9.0), ("upper", 9.0))
    governor = Part("g", "Governor", fields, (("flange", "j"),))
    motion = reference_motion(_train(_body("j"), governor, _push("j", sense("g.command"))), T)
    A = np.array([[0.0, 1.0], [-gain / lag, -1 / lag]])
    size, modes = np.linalg.eig(A)
    rest = np.array([target, 0.0])
    exact = [(rest + (modes @ np.diag(np.exp(size * t)) @ np.linalg.solve(modes, -rest)).real)[0] for t in T]
    assert np.abs(motion.speeds[0] - exact).max() < 1e-9


@pytest.mark.parametrize("capacity", [0.5, 1.0, 1.7])
@pytest.mark.few(1)
def test_friction_on_a_prescribed_motion_carries_what_it_can(capacity):
    # the drive turns with 4 t: J w' = capacity while that is less than 4 J
    drive = Part("d", "Speed", (("w", 4.0 * TIME),), (("flange", "n"),))
    clutch = Part("c", "Clutch", (("capacity", capacity),), (("a", "n"), ("b", "j")))
    motion = reference_motion(_train(_body("j", J=0.3), drive, clutch), T)
    assert np.abs(motion.speeds[0] - min(capacity / 0.3, 4.0) * T).max() < 1e-10


@pytest.mark.long
@pytest.mark.parametrize(("amount", "w"), [(0.3, 2.0), (0.5, 5.0), (-0.2, 9.0)])
def test_a_rigid_pair_follows_a_phase_that_moves(amount, w):
    # phi_b = F(0) - F(phase) with the driving side held by a large inertia
    e = 0.3
    law = thing("RatioLaw.ellipse", e=e, order=1)
    pair = Part("p", "NonCircularGear", (("law", law), ("external", True), ("phase", amount * call("sin", w * TIME))),
                (("a", "a"), ("b", "b")))  # fmt: skip
    motion = reference_motion(_train(_body("a", J=1e9, w0=0.0), _body("b", J=1e-3), pair), T)
    K = (1 + e) / (1 - e)
    turned = -2 * np.arctan(K * np.tan(amount * np.sin(w * T) / 2))
    assert np.abs(motion.angles[1] - turned).max() < 1e-6


@pytest.mark.parametrize("side", ["a", "b"])
@pytest.mark.parametrize(("given", "phase"), [(0.4, 0.0), (-1.3, 0.7), (7.5, -0.2)])
@pytest.mark.parametrize("block", ["NonCircularGear", "UniversalJoint"])
@pytest.mark.few(1)
def test_a_nonlinear_tie_that_starts_off_zero_holds_there(block, given, phase, side):
    # tan(phi_b/2 + ..) = K tan(phi_a/2 + ..), the joint tan phi_b = tan phi_a/cos(angle); a or b turns steadily at 2 rad/s
    law = thing("RatioLaw.ellipse", e=0.3, order=1)
    K, n, fields = 1.3 / 0.7, 1, (("law", law), ("external", False), ("phase", phase))
    if block == "UniversalJoint":
        phase, K, n, fields = 0.0, 1 / math.cos(0.8), 2, (("angle", 0.8),)

    def F(x, K):
        s, c = np.sin(n * x / 2), np.cos(n * x / 2)
        return x + 2 / n * np.arctan2((K - 1) * s * c, c * c + K * s * s)

    steady = {"J": 1e9, "w0": 2.0, "phi0": given}
    a, b = (_body(name, **(steady if name == side else {"J": 1e-3})) for name in "ab")
    motion = reference_motion(_train(a, b, Part("p", block, fields, (("a", "a"), ("b", "b")))), T)
    turned = given + 2.0 * T
    other = F(turned + phase, K) - F(phase, K) if side == "a" else F(turned + F(phase, K), 1 / K) - phase
    assert np.abs(motion.angles[1 if side == "a" else 0] - other).max() < 1e-8


@pytest.mark.parametrize("given", [0.2, -0.5])
def test_angles_that_nobody_gives_are_not_guessed_beside_a_nonlinear_tie(given):
    # carrier given, left and right open: the tie at the right would have to be guessed
    split = Part("d", "Differential", (), (("carrier", "c"), ("left", "l"), ("right", "r")))
    joint = Part("p", "UniversalJoint", (("angle", 0.5),), (("a", "r"), ("b", "o")))
    bodies = [_body("c", phi0=given), *map(_body, "lro")]
    with pytest.raises(NoEvidenceError, match="nobody gives"):
        reference_motion(_train(*bodies, split, joint), T)


@pytest.mark.long
@pytest.mark.parametrize(("mu", "lead", "ratio"), [(0.2, 0.1, 10.0), (0.25, 0.15, 5.0), (0.3, 0.08, -8.0)])
def test_a_self_locking_worm_stays_and_is_driven_forward(mu, lead, ratio):
    worm = Part("w", "Worm", (("ratio", ratio), ("lead_angle", lead), ("friction", mu)), (("a", "a"), ("b", "b")))
    a, b = _body("a", J=0.5, w0=0.0), _body("b", J=0.4)
    held = reference_motion(_train(a, b, worm, _push("b", 7.0)), T)
    assert np.abs(held.speeds).max() < 1e-12
    c, t = math.cos(0.3490658503988659), math.tan(lead)
    eta = (c - mu * t) / (c + mu / t)
    alpha = 2.0 / (0.5 + 0.4 / (ratio * ratio * eta))
    driven = reference_motion(_train(a, b, worm, _push("a", 2.0)), T)
    assert np.abs(driven.speeds[0] - alpha * T).max() < 1e-10


@pytest.mark.parametrize(("load", "tau1", "tau2"), [(1.0, 0.2, 1.5), (0.6, 0.3, 0.8), (2.0, 1.0, 3.0)])
@pytest.mark.few(1)
def test_nothing_enters_a_gear_between_both_bearing_torques(load, tau1, tau2):
    # b is pushed on by `load` between both: a keeps its speed but for the tie, all of the load is lost in the bearing
    gear = Part("g", "LossyGear", (("ratio", 1.0), ("efficiency", (0.9, 0.8)), ("bearing", (tau1, tau2))),
                (("a", "a"), ("b", "b")))  # fmt: skip
    a, b = _body("a", J=1.0, w0=5.0), _body("b", J=1.0)
    motion = reference_motion(_train(a, b, gear, _push("b", load)), T)
    # tau_a = 0: a turns steadily, so b does, and what leaves at b is -load
    assert np.abs(motion.speeds - 5.0).max() < 1e-10


@pytest.mark.parametrize(
    ("push", "load", "w0", "bearing"),
    [(0.5, 2.0, 20.0, (2.5, 0.2)), (-0.3, -0.8, -9.0, (1.5, 0.0)), (2.0, 1.5, 0.0, (2.0, 0.3))],
)
@pytest.mark.few(1)
def test_a_drives_first_where_both_sides_of_a_gear_hold(push, load, w0, bearing):
    gear = Part("g", "LossyGear", (("ratio", 1.0), ("efficiency", (0.9, 0.8)), ("bearing", bearing)),
                (("a", "a"), ("b", "b")))  # fmt: skip
    bodies = _body("a", J=1.0, w0=w0), _body("b", J=0.5)
    motion = reference_motion(_train(*bodies, gear, _push("a", push), _push("b", load)), T)
    # what leaves, u = 0.5 alpha - load, lies between both bearing torques; 1.0 alpha = push - (u + tau1)/eta1
    alpha = (push + (load - math.copysign(bearing[0], push)) / 0.9) / (1.0 + 0.5 / 0.9)
    assert -bearing[0] <= math.copysign(1.0, push) * (0.5 * alpha - load) < -bearing[1]
    assert np.abs(motion.speeds - w0 - alpha * T).max() < 1e-10


def test_two_gears_that_a_cannot_both_drive_leave_a_start_open():
    # pushed on from the far end so much that not both are driven by a: the first one still may be, or none of them
    def gear(name, a, b, tau1):
        fields = (("ratio", 1.0), ("efficiency", (0.95, 0.95)), ("bearing", (tau1, 0.0)))
        return Part(name, "LossyGear", fields, (("a", a), ("b", b)))

    bodies = _body("a", J=1.0, w0=50.0), _body("b", J=1.0), _body("c", J=1.0)
    train = _train(*bodies, gear("g", "a", "b", 1.0), gear("h", "b", "c", 1.0), _push("c", 0.8))
    with pytest.raises(NoEvidenceError, match="several"):
        reference_motion(train, T)


@pytest.mark.parametrize("order", [("x", "y"), ("y", "x")])
@pytest.mark.parametrize(("first", "second"), [(1.0, 1.2), (0.5, 0.9), (2.0, 2.1)])
@pytest.mark.few(1)
def test_of_two_static_peaks_in_a_row_the_smaller_one_breaks(first, second, order):
    # drive - clutch - body - brake - ground: the load rises until the weaker one slips, which then passes on half of its peak
    peak = 2.0
    clutch = Part(order[0], "Clutch", (("capacity", first / peak), ("peak", peak)), (("a", "j"), ("b", "k")))
    brake = Part(order[1], "Brake", (("capacity", second / peak), ("peak", peak)), (("a", "k"), ("housing", GROUND)))
    motion = reference_motion(_train(_body("j", w0=0.0), _body("k", w0=0.0), clutch, brake, _push("j", 3.0 * TIME)), T)
    late = np.maximum(T - first / 3.0, 0.0)
    alpha_late = (first - first / peak) * late + 3.0 * late**2 / 2
    assert np.abs(motion.speeds[0] - alpha_late).max() < 1e-9
    assert np.abs(motion.speeds[1]).max() < 1e-12


def test_of_two_static_peaks_that_a_jump_of_the_load_passes_it_cannot_tell():
    # the smaller one (the brake) breaks first as the load rises quickly, but both that and the other one alone are motions
    clutch = Part("x", "Clutch", (("capacity", 7.14), ("peak", 1.2)), (("a", "j"), ("b", "k")))
    brake = Part("y", "Brake", (("capacity", 3.99), ("peak", 2.0)), (("a", "k"), ("housing", GROUND)))
    jump = either(14.3, TIME > 0.5, 0.0)
    train = _train(_body("j", 1.23, w0=0.0), _body("k", 1.2, w0=0.0), clutch, brake, _push("j", jump))
    with pytest.raises(NoEvidenceError, match="several static peaks"):
        reference_motion(train, T)


def test_nor_of_two_that_a_lock_passes_as_it_closes():
    # h comes up from behind and closes the freewheel, which then asks of both at once what was asked of neither
    clutch = Part("x", "Clutch", (("capacity", 7.14), ("peak", 1.02)), (("a", "j"), ("b", "k")))
    brake = Part("y", "Brake", (("capacity", 3.99), ("peak", 2.0)), (("a", "k"), ("housing", GROUND)))
    lock = Part("z", "Freewheel", (), (("a", "h"), ("b", "j")))
    bodies = (_body("h", w0=-1.0), _body("j", 1.23, w0=0.0), _body("k", 1.2, w0=0.0))
    with pytest.raises(NoEvidenceError, match="several static peaks"):
        reference_motion(_train(*bodies, clutch, brake, lock, _push("h", 14.3)), T)


@pytest.mark.parametrize(("tau", "holds"), [(4.45, 4.8), (4.2, 4.4), (4.9, 4.8)])
@pytest.mark.few(1)
def test_a_slip_that_ends_is_held_though_a_freewheel_lets_go_on_the_way(tau, holds):
    # b catches up with a, from which its bearing pushes it, and drives c; held to a it slows down, and c runs on
    a, b, c, slides, against, w0 = 1.0, 0.1, 0.06, 4.0, 5.0, 5.0
    bearing = Part(
        "bearing", "BearingFriction", (("coulomb", slides), ("peak", holds / slides)), (("a", "a"), ("housing", "b"))
    )
    wheel = Part("wheel", "Freewheel", (), (("a", "b"), ("b", "c")))
    bodies = (_body("a", a, w0=w0), _body("b", b, w0=0.0), _body("c", c, w0=0.0))
    motion = reference_motion(_train(*bodies, bearing, wheel, _push("a", -against), _push("b", tau), t_end=0.2), T / 5)
    meet = w0 / ((tau + slides) / (b + c) + (against + slides) / a)
    together, late = w0 - (against + slides) / a * meet, np.maximum(T / 5 - meet, 0.0)
    held = (tau - against) / (a + b)
    stays, passes = (held, held, 0.0), ((slides - against) / a, *[(tau - slides) / (b + c)] * 2)
    right = stays if abs(b * held - tau) <= holds else passes
    for speed, rate in zip(motion.speeds, right, strict=True):
        assert np.abs(speed - together - rate * late)[late > 0].max() < 1e-9


@pytest.mark.parametrize("w_t", [8.0, -3.0, 20.0])
def test_an_impeller_that_reverses_crosses_the_whole_table(w_t):
    x = (0.0, 0.5, 1.0)
    fields = (("capacity", table(x, (0.02, 0.015, 0.0))), ("ratio", table(x, (2.0, 1.4, 1.0))))
    fluid = Part("c", "TorqueConverter", fields, (("impeller", "i"), ("turbine", "t")))
    motion = reference_motion(_train(_body("i", w0=-2.0), _body("t", J=1e9, w0=w_t), fluid, _push("i", 5.0)), T)
    assert motion.speeds[0, -1] > 0 > motion.speeds[0, 0]
    assert np.isfinite(motion.speeds).all()


@pytest.mark.parametrize("play", [0.01, 0.1])
def test_a_static_start_inside_of_a_gap_is_looked_at_and_not_guessed(play):
    body = _body("j")
    gap = Part("l", "Lash", (("k", 100.0), ("half_gap", play)), (("a", GROUND), ("b", "j")))
    still = _train(body, gap, initial="static")
    with pytest.raises(NoEvidenceError, match="leaves open"):
        reference_motion(still, T)
    motion = reference_motion(still, T, given=np.array([[0.5 * play], [0.0]]))
    assert np.abs(motion.angles[0] - 0.5 * play).max() < 1e-12
    with pytest.raises(NoEvidenceError, match="not the run's"):
        reference_motion(still, T, given=np.array([[3.0 * play], [0.0]]))


@pytest.mark.parametrize("restitution", [0.3, 0.6, 0.75])
@pytest.mark.few(1)
def test_a_body_that_hammers_another_against_its_stop_comes_to_rest_with_it(restitution):
    hits = thing("HuntCrossley", restitution=restitution)
    fields = (("k", 1e3), ("half_gap", 0.1), ("contact_damping", hits), ("hits", True))
    play = Part("l", "Lash", fields, (("a", "j"), ("b", "k")))
    stop = Part("s", "HardStop", (("upper", 0.0), ("restitution", 0.0)), (("a", "k"),))
    bodies = _body("j", w0=0.0), _body("k", J=0.3, w0=0.0)
    motion = reference_motion(_train(*bodies, play, stop, _push("j", 20.0), t_end=2.0), 2.0 * T)
    assert np.abs(motion.speeds[:, -1]).max() < 1e-12
    assert np.abs(motion.angles[:, -1] - [0.1, 0.0]).max() < 1e-12


@pytest.mark.long
@pytest.mark.parametrize(("depth", "w", "fall"), [(1e-6, 22.0, 0.01), (5e-6, 22.0, 0.03), (1e-6, 40.0, 0.1)])
def test_teeth_that_only_a_wave_of_their_error_brings_together_are_seen(depth, w, fall):
    # x = r (phi_a - phi_b) - e cos(z phi_a): the first crest is beyond the gap by `depth`; a step goes over 30 rad of waves
    r, gap, k, z, J, e, begin = 0.02, 2e-3, 1e6, 17, 0.1, 2.7e-4, -0.15 if w < 30.0 else -0.3
    crest = (np.pi / z - begin) / w
    y0 = [begin, begin - (gap + depth - e) / r + fall * crest, w, w - fall]
    bodies = _body("a", J, phi0=y0[0], w0=y0[2]), _body("b", J, phi0=y0[1], w0=y0[3])
    wave = thing("Harmonic", cos=(e,), driven_by="angle")
    fields = (("teeth", (z, z)), ("external", False), ("r_base", (r, r)), ("k", k), ("transmission_error", wave))
    play = (*fields, ("backlash", thing("Backlash", half_gap=gap)))
    mesh = Part("m", "GearMesh", play, (("pinion", "a"), ("wheel", "b")))
    motion = reference_motion(_train(*bodies, mesh, t_end=4.0), np.array([0.0, 1.5 * crest, 4.0]))

    def rate(_t, y):
        x = r * (y[0] - y[1]) - e * np.cos(z * y[0])
        force = k * (max(x - gap, 0.0) + min(x + gap, 0.0))
        return [y[2], y[3], -force * (r + e * z * np.sin(z * y[0])) / J, force * r / J]

    true = solve_ivp(rate, (0.0, 1.5 * crest), y0, "DOP853", rtol=1e-11, atol=1e-12, max_step=1e-5).y[2:, -1]
    assert abs(true[1] - y0[3]) > 3e-5  # they have touched
    assert np.abs(motion.speeds[:, 1] - true).max() < 1e-8


@pytest.mark.parametrize(("rest", "rise"), [(0.2, 0.1), (0.3, -0.02), (0.1, 0.4)])
@pytest.mark.few(1)
def test_a_one_way_clutch_slips_by_its_law_and_then_stays(rest, rise):
    # w' = -F (rest + rise w) until w = 0
    w0, force = 5.0, 20.0
    fields = (("mu", rest + rise * SLIP), ("force_max", force), ("engagement", 1.0))
    clutch = Part("clutch", "OneWayClutch", fields, (("a", GROUND), ("b", "j")))
    motion = reference_motion(_train(_body("j", w0=w0), clutch), T)
    w = (w0 + rest / rise) * np.exp(-force * rise * T) - rest / rise
    stop = math.log(1 + w0 * rise / rest) / (force * rise)
    assert np.abs(motion.speeds[0] - np.where(stop > T, w, 0.0)).max() < 1e-8

"""The short form of the campaign, and what the campaign itself must not get wrong."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from random import Random

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from tests.random.description import GROUND, Part, Train, script  # noqa: E402
from tests.random.expressions import TIME, TWIST, Node, either, sense, thing  # noqa: E402  # noqa: E402
from tests.random.families import FAMILIES, draw  # noqa: E402
from tests.random.judge import DRAWS, HangError, Judge  # noqa: E402
from tests.random.reduce import from_plain, shrunk, to_plain  # noqa: E402
from tests.random.reference import NoEvidenceError, reference_motion  # noqa: E402
from tests.random.reference.dynamics import Dynamics  # noqa: E402
from tests.random.reference.elements import system_of  # noqa: E402
from tests.random.without import tied_pair  # noqa: E402


@pytest.mark.long  # .ci/run has it as a step of its own
def test_the_fixed_trains_of_every_family_are_right():
    command = [sys.executable, "-m", "tests.random", "--short", "--workers", "1"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    rows = [line.split("|")[1:-1] for line in done.stdout.splitlines() if line.startswith("| all")]
    numbers = [int(x) for x in rows[0][1:]]
    assert numbers[0] == numbers[1] == numbers[-1] >= 18  # all are right, by the reference


def test_a_seed_is_one_train_whatever_was_drawn_before():
    for family in FAMILIES:
        assert draw(family, 5) == draw(family, 5) != draw(family, 6)


def test_a_description_survives_the_way_to_a_worker():
    for family in FAMILIES:
        for seed in range(20):
            train = draw(family, seed)
            assert from_plain(to_plain(train)) == train
            compile(script(train), "script", "exec")


@pytest.mark.parametrize("family", ["contact", "mixed", "smooth"])
def test_without_is_held_against_a_rigid_part_only_where_no_play_stays(family):
    pairs = [(draw(family, seed), tied_pair(draw(family, seed), Random(seed))) for seed in range(60)]
    parts = [(train, next(p for p in train.parts if p.name == pair[0])) for train, pair in pairs if pair is not None]
    damping = {str(part.field("contact_damping")) for _, part in parts}
    assert parts and not any("HuntCrossley" in text for text in damping)
    assert family != "contact" or any(part.block in ("GearMesh", "Lash") for _, part in parts)


T = np.linspace(0.0, 1.0, 11)


def _train(*parts, t_end=1.0):
    return Train("closed form", 0, parts, t_end)


def test_the_reference_stops_a_braked_wheel_when_momentum_says():
    wheel = Part("j", "Inertia", (("J", 2.0), ("w0", 3.0)), (("a", "j"),))
    brake = Part("b", "Brake", (("capacity", 10.0),), (("a", "j"), ("housing", GROUND)))
    motion = reference_motion(_train(wheel, brake), T)  # 3 - 5 t until 0.6 s
    assert np.abs(motion.speeds[0] - np.maximum(3 - 5 * T, 0)).max() < 1e-12
    assert abs(motion.angles[0, -1] - 0.9) < 1e-12


@pytest.mark.parametrize("capacity", [0.289, 0.301, 0.1 + 0.2, 1 / 3, 0.71])
@pytest.mark.parametrize("J", [0.0257, 0.3])
@pytest.mark.few(3)
def test_the_reference_breaks_away_where_loads_cancel_but_for_rounding(J, capacity):
    wheel = Part("j", "Inertia", (("J", J),), (("a", "j"),))
    held = [
        Part(n, "Brake", (("capacity", c * capacity),), (("a", "j"), ("housing", GROUND)))
        for n, c in (("b", 0.3), ("c", 0.7))
    ]
    pull = Part("t", "Torque", (("tau", -1.09 * TIME),), (("flange", "j"),))
    motion = reference_motion(_train(wheel, *held, pull), T)
    late = np.maximum(T - capacity / 1.09, 0.0)
    assert np.abs(motion.speeds[0] + 1.09 / J * late**2 / 2).max() < 1e-9 / J


def test_the_reference_bounces_as_newton_says():
    body = Part("j", "Inertia", (("J", 1.0), ("w0", 2.0)), (("a", "j"),))
    stop = Part("s", "HardStop", (("upper", 1.0), ("restitution", 0.5)), (("a", "j"),))
    motion = reference_motion(_train(body, stop), T)  # hits at 0.5 s, goes back with 1 rad/s
    assert np.abs(motion.angles[0] - np.where(T < 0.5, 2 * T, 1.5 - T)).max() < 1e-12
    assert motion.jumps == pytest.approx([0.5], abs=1e-13)


def test_the_reference_loses_in_a_gear_what_its_efficiency_says():
    a = Part("a", "Inertia", (("J", 1.0), ("w0", 3.0)), (("a", "a"),))
    b = Part("b", "Inertia", (("J", 1.0),), (("a", "b"),))
    gear = Part("g", "LossyGear", (("ratio", 3.0), ("efficiency", (0.9, 0.8))), (("a", "a"), ("b", "b")))
    drive = Part("t", "Torque", (("tau", 2.0),), (("flange", "a"),))
    motion = reference_motion(_train(a, b, gear, drive), T)
    alpha = 2.0 / (1.0 + 1.0 / (9.0 * 0.9))  # a drives: 2 - tau = a, 3 0.9 tau = a/3
    assert np.abs(motion.speeds[0] - 3 - alpha * T).max() < 1e-11
    braked = replace(drive, fields=(("tau", -2.0),))
    motion = reference_motion(_train(a, b, gear, braked), T)
    alpha = -2.0 / (1.0 + 1.0 * 0.8 / 9.0)  # b drives: 3/0.8 tau = a/3
    assert np.abs(motion.speeds[0] - 3 - alpha * T).max() < 1e-11


@pytest.mark.parametrize("late", [0.4, 0.5, 0.7])
@pytest.mark.few(1)
def test_a_perturbed_reference_shows_errors_that_only_the_end_of_a_run_magnifies(late):
    # x'' + 20 x' + 100 x = 0, and from `late` on = 500 x: errors before it have died out, those after it grow
    body = Part("j", "Inertia", (("J", 1.0), ("phi0", 1.0)), (("a", "j"),))
    shaft = Part("s", "Shaft", (("k", 100.0), ("c", 20.0)), (("a", "j"), ("b", GROUND)))
    push = Part("t", "Torque", (("tau", either(500.0 * sense("j.phi"), late < TIME, 0.0)),), (("flange", "j"),))
    true = reference_motion(_train(body, shaft, push), T)
    other = reference_motion(_train(body, shaft, push), T, perturbation=1e-8)
    growth = np.exp((np.sqrt(500.0) - 10.0) * (1.0 - late - 0.1))  # of a change at most a tenth of the run after it
    assert np.abs(other.angles[0, -1] - true.angles[0, -1]) > 0.1 * 1e-8 * growth
    assert np.abs(other.angles[0, -1] - true.angles[0, -1]) < 10 * 1e-8 * growth * np.exp(2.4)


@pytest.mark.long
def test_errors_of_many_flights_add_up_in_a_perturbed_reference():
    # thrown up at w = 10 under 200 rad/s2 it flies for 0.1 s; a change of w in each of n flights moves the phase of the next
    body = Part("j", "Inertia", (("J", 1.0), ("w0", 1.0)), (("a", "j"),))
    stop = Part("s", "HardStop", (("lower", 0.0), ("restitution", 1.0)), (("a", "j"),))
    fall = Part("t", "Torque", (("tau", -100.0),), (("flange", "j"),))
    t = np.array([0.0, 0.985, 0.995, 1.0])
    train = _train(body, stop, fall)
    true = reference_motion(train, t)
    assert len(true.jumps) >= 49  # a flight takes 0.02 s
    off = {n: np.abs(reference_motion(train, t, 1e-8, draw=1, kicks=n).angles - true.angles).max() for n in (10, 50)}
    assert off[50] > 3 * off[10] > 3e-9


@pytest.mark.parametrize(("seen", "draws"), [(0, 1), (1, 2), (2, 3), (DRAWS, 4)])
def test_draws_go_on_as_long_as_a_run_would_be_wrong(seen, draws):
    judge, tried = Judge(None, draw("smooth", 1)), []
    judge.runs = {"run": (1e-6, None)}

    def magnification(i):
        tried.append(i)
        if i == 3:
            raise HangError
        return np.full(len(judge.t), 1e4 if i == seen else 1.0)

    growth = judge._growth({"run": np.full(len(judge.t), 1e-2)}, magnification)
    assert len(tried) == draws
    assert growth.max() == growth.min() == (1e4 + 1 if seen < 3 else 2.0)


@pytest.mark.parametrize(("restitution", "changed"), [(1.0, True), (0.4, True), (0.0, False)])
def test_without_a_reference_errors_of_many_flights_are_those_of_a_restitution(restitution, changed):
    # n flights with a restitution that is off by d are off by n d, as with n errors of one sign
    body = Part("j", "Inertia", (("J", 1.0), ("w0", 1.0)), (("a", "j"),))
    stop = Part("s", "HardStop", (("lower", 0.0), ("restitution", restitution)), (("a", "j"),))
    given = []

    class Runs:
        GearblocksError = ArithmeticError

        @staticmethod
        def simulate(_model, parameters, **_options):
            given.append(parameters)
            raise ArithmeticError

    judge = Judge(Runs, _train(body, stop))
    for i in range(DRAWS):
        assert np.isinf(judge._perturbed(None, None, "dp8", i)).all()
    assert all(("s.restitution" in p) == (changed and i >= DRAWS // 2) for i, p in enumerate(given))
    assert all(0 < 1 - p["s.restitution"] / restitution < 2e-8 for p in given if "s.restitution" in p)


@pytest.mark.parametrize("above", [1.02, 1.005, 1.2])
def test_the_reference_sees_a_damping_that_an_impact_clips_for_less_than_a_look(above):
    k, d, w, end = 100.0, 0.1, 2.0, 0.06  # phi = -u: a stop at u = d throws the body back into its contact at w
    c = above * k * d / w
    body = Part("j", "Inertia", (("J", 1.0), ("phi0", -1.001 * d), ("w0", w)), (("a", "j"),))
    damped = (("k", k), ("half_gap", 0.0), ("c", c), ("contact_damping", "clipped"))
    lash = Part("l", "Lash", damped, (("a", GROUND), ("b", "j")))
    stop = Part("s", "HardStop", (("upper", -d), ("restitution", 1.0)), (("a", "j"),))
    motion = reference_motion(_train(body, lash, stop, t_end=1.0), np.array([0.0, end, 1.0]))
    # clipped it pushes with 2 k u until c u' = k u, then with k u + c u'
    rate = np.sqrt(2 * k)
    u = lambda t: d * np.cos(rate * t) + w / rate * np.sin(rate * t)  # noqa: E731
    du = lambda t: w * np.cos(rate * t) - d * rate * np.sin(rate * t)  # noqa: E731
    until = brentq(lambda t: c * du(t) - k * u(t), 0.0, 0.05, xtol=1e-15)
    left = end - 0.001 * d / w - until
    late, speed = expm(left * np.array([[0.0, 1.0], [-k, -c]])) @ [u(until), du(until)]
    assert c * w > 1.001 * k * d and until < 0.02
    assert (motion.angles[0, 1], motion.speeds[0, 1]) == pytest.approx((-late, -speed), rel=1e-9)


@pytest.mark.parametrize("far", [1e155, 1e200, 1e300])
@pytest.mark.parametrize("hunt", [None, thing("HuntCrossley", restitution=0.5)])
def test_a_trial_state_of_the_reference_beyond_the_numbers_is_no_rate(far, hunt):
    body = Part("j", "Inertia", (("J", 1.0),), (("a", "j"),))
    more = () if hunt is None else (("contact_damping", hunt),)
    lash = Part("l", "Lash", (("k", 1e3), ("half_gap", 0.1), *more), (("a", "j"), ("b", GROUND)))
    dynamics = Dynamics(system_of(_train(body, lash)))
    assert np.isnan(dynamics(0.0, np.array([far, 0.0]))).all()
    assert dynamics(0.0, np.array([1.1, 0.0]))[1] == pytest.approx(-1e3)


def test_the_reference_says_where_it_has_no_law():
    body = Part("j", "Inertia", (("J", 1.0),), (("a", "j"),))
    with pytest.raises(NoEvidenceError, match="Windmill"):
        reference_motion(_train(body, Part("c", "Windmill", (), ())), T)


def test_the_reference_slows_a_pump_before_a_held_turbine():
    capacity = Node("table", ((0.0, 1.0), (0.01, 0.0), "linear", False, None))
    ratio = Node("table", ((0.0, 1.0), (2.0, 1.0), "linear", False, None))
    pump = Part("i", "Inertia", (("J", 1.0), ("w0", 10.0)), (("a", "i"),))
    wheel = Part("t", "Inertia", (("J", 1e9),), (("a", "t"),))  # as good as held: w' = -c w^2
    fluid = Part(
        "c", "TorqueConverter", (("capacity", capacity), ("ratio", ratio)), (("impeller", "i"), ("turbine", "t"))
    )
    motion = reference_motion(_train(pump, wheel, fluid), T)
    assert np.abs(motion.speeds[0] - 10.0 / (1 + 0.1 * T)).max() < 1e-7


@pytest.mark.long
def test_the_reference_carries_a_planetary_gear_to_its_ratio():
    law = Node("object", ("MeshLaw", (("k", 1e7), ("c", 3e3))))
    fields = {"z_sun": 24, "z_planet": 18, "z_ring": 60, "planets": 3, "module": 0.004, "pressure_angle": 0.35,
              "planet_inertia": 1e-3, "sun_mesh": law, "ring_mesh": law}  # fmt: skip
    gear = Part("g", "PlanetaryGear", tuple(fields.items()), (("sun", "s"), ("ring", GROUND), ("carrier", "c")))
    sun, carrier = (Part(n, "Inertia", (("J", J),), (("a", n),)) for n, J in (("s", 0.2), ("c", 0.7)))
    push = Part("p", "Torque", (("tau", 6.0),), (("flange", "s"),))
    motion = reference_motion(_train(sun, carrier, gear, push), T)
    i, planet = 1 + 60 / 24, (60 / 18 - 1) / (1 + 60 / 24)  # w_s/w_c, and the planets' speed over that of the sun
    alpha = 6.0 / (0.2 + 0.7 / i**2 + 3 * 1e-3 * planet**2)
    assert motion.speeds[0, -1] == pytest.approx(alpha, rel=1e-3)
    assert motion.speeds[1, -1] == pytest.approx(alpha / i, rel=1e-3)


def test_the_reference_starts_at_rest_where_springs_balance():
    body = Part("j", "Inertia", (("J", 2.0),), (("a", "j"),))
    spring = Part(
        "k", "Shaft", (("torque", 100.0 * TWIST + 50.0 * TWIST * TWIST * TWIST),), (("a", "j"), ("b", GROUND))
    )
    drive = Part("t", "Torque", (("tau", 150.0),), (("flange", "j"),))
    still = replace(_train(body, spring, drive), initial="static")
    motion = reference_motion(still, T)
    assert np.abs(motion.angles[0] - 1.0).max() < 1e-9  # 100 x + 50 x^3 = 150


def test_the_reducer_keeps_what_fails_and_little_else():
    train = draw("mixed", 3)

    def judge(candidate):
        wrong = any(p.block == "Clutch" for p in candidate.parts) and any(
            p.block == "LossyGear" for p in candidate.parts
        )
        return {"kind": "wrong" if wrong else "right", "message": ""}

    assert judge(train)["kind"] == "wrong"
    small, verdict = shrunk(train, judge(train), judge)
    assert verdict["kind"] == "wrong"
    assert len(small.parts) <= 6 < len(train.parts)  # two elements, the bodies at their ends

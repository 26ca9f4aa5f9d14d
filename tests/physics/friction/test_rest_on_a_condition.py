"""A law that jumps about an angle, and a friction that takes a part of each swing: at rest on the jump in a finite time."""

from math import cos, sin, sqrt
from random import Random

import numpy as np
import pytest

import gearblocks as gb

METHODS = ("dp5", "dp8", "rodas", "auto")


def _positioner(J, up, down, held, peak=1.0, target=1.0, inside=None, pull=0.0):
    """Torque `up` below an angle and -`down` beyond it, against a brake."""
    rig, phi = gb.Drivetrain("positioner"), gb.sense("body.phi")
    below = phi < target if inside is None else inside(phi)
    rig.chain(
        rig.add("drive", gb.Torque(tau=gb.piecewise((up, below), (-down, True)))), rig.add("body", gb.Inertia(J=J)),
        rig.add("brake", gb.Brake(capacity=held, peak=peak)), rig.add("pull", gb.Torque(tau=pull)),
    )  # fmt: skip
    return rig


def _rests_after(J, up, down, held, way):
    """From rest at a distance `way`: swings whose speeds at the limit shrink by one factor."""
    first = sqrt(2 * way * (up - held) / J)
    beyond, back = (down + held) / J, (down - held) / J
    below, on = (up + held) / J, (up - held) / J
    returned = first * sqrt(back / beyond)
    swing = first / beyond + returned / back + returned / below + returned * sqrt(on / below) / on
    factor = sqrt(back / beyond * on / below)
    return first / on + swing / (1 - factor)


@pytest.mark.parametrize("seed", [pytest.param(s, marks=pytest.mark.long if s else ()) for s in range(12)])
def test_swings_end_when_their_series_does(seed):
    draw = Random(seed)
    J, up, down = draw.uniform(0.2, 3.0), draw.uniform(1.0, 4.0), draw.uniform(1.0, 4.0)
    held = draw.uniform(0.15, 0.9) * min(up, down)
    method, rtol = METHODS[seed % 4], draw.choice((1e-4, 1e-6, 1e-9))
    ends = _rests_after(J, up, down, held, 1.0)
    model = gb.build(_positioner(J, up, down, held))
    assert gb.simulate(model, t=[ends + 5e-3], method=method, rtol=rtol).stats.events < 1000
    run = gb.simulate(model, t=[ends + 5e-3, ends + 100.0], method=method, rtol=rtol)
    assert np.abs(run["body.phi"] - 1.0).max() < rtol
    assert run["body.w"].tolist() == [0.0, 0.0]
    untold = 1e-4 * max(rtol, 1e-9)  # angle of the last swings that are left out; their time goes with the root of it
    assert run.events[-1].t == pytest.approx(ends, abs=100 * sqrt(untold * J / min(up - held, down - held)))
    assert np.abs(run["brake.torque"]).max() <= held * (1 + 1e-12)
    assert np.abs(run["drive.torque"] - run["brake.torque"]).max() < 1e-12
    assert run.energy.residual < 10 * rtol


@pytest.mark.parametrize("method", [pytest.param(m, marks=pytest.mark.long if m != "dp8" else ()) for m in METHODS])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_it_leaves_where_the_nearer_side_and_the_friction_together_hold_no_more(method, way):
    pull = gb.piecewise((0.0, gb.time < 10.0), (0.1 * way * (gb.time - 10.0), True))
    for peak, leaves in ((1.0, 23.0), (1.5, 24.5)):
        run = gb.simulate(_positioner(1.0, 1.0, 1.0, 0.3, peak, pull=pull), t=[20.0, 30.0], method=method, rtol=1e-7)
        gone = 30.0 - leaves
        speed = 0.3 * (peak - 1) * gone + 0.05 * gone**2  # pull - 1 - 0.3 from there on
        assert run["body.w"] == pytest.approx([0.0, way * speed], rel=1e-6)
        assert run["body.phi"][1] - 1.0 == pytest.approx(way * (0.15 * (peak - 1) * gone**2 + gone**3 / 60), rel=1e-6)
        assert run["brake.torque"] == pytest.approx([0.3 * peak * way, 0.3 * way], rel=1e-6)
        assert run["drive.torque"][0] == pytest.approx(way * (0.3 * peak - 1.0), rel=1e-6)


@pytest.mark.parametrize(
    ("capacity", "pull", "leaves", "rate", "held"),
    [
        pytest.param((0.3, 0.0), (0.5, 1.5), 20.5, 0.5, 0.0, id="brake off"),
        pytest.param((0.3, 0.1), (0.0, 1.5), 20.5, 0.4, 0.1, id="brake eased"),
        pytest.param((0.3, 0.3), (0.0, -2.0), 20.5, -0.7, -0.3, id="downward"),
        pytest.param((0.3, 2.1), (0.0, 1.5), 99.0, 0.0, 1.5, id="held"),
    ],
)
def test_loads_and_capacities_that_jump_at_an_instant(capacity, pull, leaves, rate, held):
    cap = gb.piecewise((capacity[0], gb.time < 20.0), (capacity[1], True))
    load = gb.piecewise((pull[0], gb.time < 20.5), (pull[1], True))
    run = gb.simulate(_positioner(1.0, 1.0, 1.0, cap, pull=load), t=[19.0, 20.25, 22.5])
    gone = max(22.5 - leaves, 0.0)
    assert run["body.w"] == pytest.approx([0.0, 0.0, rate * gone], abs=1e-9)
    assert run["body.phi"] - 1.0 == pytest.approx([0.0, 0.0, 0.5 * rate * gone**2], abs=1e-9)
    assert run["brake.torque"][-1] == pytest.approx(held, abs=1e-9)
    assert (np.abs(run["brake.torque"][:2]) <= np.array(capacity) + 1e-12).all()


@pytest.mark.long
@pytest.mark.parametrize("method", METHODS)
def test_conditions_that_are_not_linear_behind_a_gear_and_beside_a_spring(method):
    def rests(rtol):
        rig = gb.Drivetrain("geared positioner")
        phi = gb.sense("body.phi")
        drive = gb.Torque(tau=gb.piecewise((1.0, gb.sin(phi) < 0.8), (-1.5, True)))
        body, gear = rig.add("body", gb.Inertia(J=0.5)), rig.add("gear", gb.IdealGear(ratio=-2.0))
        arm, tip = rig.add("arm", gb.Inertia(J=0.3)), rig.add("tip", gb.Inertia(J=0.02))
        rig.chain(rig.add("drive", drive), body, gear, arm, rig.add("link", gb.Shaft(k=40.0, c=0.4)), tip)
        rig.connect(rig.add("bearing", gb.BearingFriction(coulomb=0.9, viscous=0.05)).a, arm.b)
        return gb.simulate(rig, t=np.linspace(0.0, 60.0, 61), method=method, rtol=rtol)

    run, finer = rests(1e-6), rests(1e-9)
    assert np.abs(run["body.phi"] - finer["body.phi"]).max() < 1e-5
    assert sin(run["body.phi"][-1]) == pytest.approx(0.8, abs=1e-9)
    assert run["body.w"][-1] == 0.0 and cos(run["body.phi"][-1]) > 0
    assert abs(run["link.twist"][-1]) < 1e-6
    assert run.stats.events < 2000 and run.energy.residual < 1e-5


def test_an_input_that_pulls_it_off_and_a_run_that_goes_on_from_rest():
    model = gb.build(_positioner(1.0, 1.0, 1.0, 0.3, pull=gb.Input("pull", 0.0)))
    rested = gb.simulate(model, t_end=25.0)
    assert rested["body.w"][-1] == 0.0
    held = gb.simulate(model, t_start=25.0, t_end=26.0, initial=rested, inputs={"pull": 1.2})
    assert held["body.w"][-1] == 0.0 and held["body.phi"][-1] == pytest.approx(1.0, abs=1e-9)
    gone = gb.simulate(model, t_start=25.0, t_end=26.0, initial=rested, inputs={"pull": -1.5})
    assert gone["body.w"][-1] == pytest.approx(-0.2, rel=1e-4)


@pytest.mark.long
@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-9])
def test_what_would_leave_the_limit_together_rests_there_with_its_momentum_gone(rtol):
    """A clutch between the body and another one: stuck, both would go on with what momentum they have. The swings of the
    body shrink by one factor and so do the speeds of the other one: a series whose sum tells when both rest."""
    rig = gb.Drivetrain("positioner with a load")
    drive = gb.Torque(tau=gb.piecewise((1.0, gb.sense("body.phi") < 1.0), (-1.0, True)))
    body, load = rig.add("body", gb.Inertia(J=1.0)), rig.add("load", gb.Inertia(J=3.0))
    rig.chain(rig.add("drive", drive), body, rig.add("clutch", gb.Clutch(capacity=0.3)), load)
    run = gb.simulate(rig, t=[*np.linspace(0, 12, 121), 1e6], rtol=rtol)
    flips = [e.t for e in run.events if e.component.startswith("drive")]
    one, two, three = flips[-6], flips[-4], flips[-2]
    ends = three - (three - two) ** 2 / (three - 2 * two + one)
    assert run.events[-1].component == "clutch"
    assert run.events[-1].t == pytest.approx(ends, abs=4 * sqrt(rtol))
    rests = run.t > ends + 0.01
    for name in ("body.w", "load.w", "drive.torque", "clutch.torque"):
        assert np.abs(run[name][rests]).max() < 1e-12
    assert np.abs(run["body.phi"][rests] - 1.0).max() < 10 * rtol
    assert run.energy.residual < 10 * rtol


@pytest.mark.parametrize(
    ("target", "coulomb", "viscous", "ends", "late"), [(1.0, 0.02, 0.5, 19.366, 0.01), (1e4, 0.1, 0.0, 28.3913, 0.06)]
)
def test_swings_that_rounding_keeps_up_are_at_rest(target, coulomb, viscous, ends, late):
    """Friction that takes little of each, or a limit that is far from 0: its rounding keeps up some swings
    after the end of the geometric series (28.3913 s in closed form)."""
    rig = gb.Drivetrain("positioner")
    drive = gb.Torque(tau=gb.piecewise((1.0, gb.sense("body.phi") < target), (-1.0, True)))
    body = rig.add("body", gb.Inertia(J=1.0, phi0=target - 1.0))
    rig.chain(rig.add("drive", drive), body, rig.add("bearing", gb.BearingFriction(coulomb=coulomb, viscous=viscous)))
    run = gb.simulate(rig, t=[60.0], rtol=1e-9)
    assert run["body.w"][-1] == 0.0 and run["body.phi"][-1] == pytest.approx(target, rel=1e-9)
    assert -0.01 < run.events[-1].t - ends < late
    assert run.stats.events < 3000


def _governed(drive):
    """A torque over the speed of a body, and a second one that jumps with the sign of the first."""
    rig = gb.Drivetrain("governed")
    second = gb.Torque(tau=gb.piecewise((0.3, gb.sense("drive.torque") > 0.0), (0.0, True)))
    rig.chain(rig.add("drive", gb.Torque(tau=drive)), rig.add("body", gb.Inertia(J=1.0)), rig.add("second", second))
    return rig


def test_swings_that_nothing_tells_and_that_come_to_no_rest_stop_by_name():
    w = gb.sense("body.w")
    rig = _governed(gb.piecewise((1.0, w < 1.0), (-1.0, True)))
    with pytest.raises(
        gb.SimulationError, match=r"'drive': 100\d\d swings of its switch 1 .*narrow.* no rest .* width"
    ):
        gb.simulate(rig, t_end=60.0, rtol=1e-9, method="dp5")
    steep = _governed(gb.maximum(-1.0, gb.minimum(1.0, 1e4 * (1.0 - w))))
    assert gb.simulate(steep, t_end=60.0)["body.w"][-1] == pytest.approx(1.0, abs=1e-3)


def test_a_law_that_drives_away_from_its_limit_holds_nothing():
    run = gb.simulate(_positioner(1.0, -1.0, -1.0, 0.3), t=[3.0], initial={"body.phi": 1.0 - 1e-12, "body.w": 1e-5})
    assert run["body.w"][-1] == pytest.approx(0.7 * 3.0, rel=1e-5)

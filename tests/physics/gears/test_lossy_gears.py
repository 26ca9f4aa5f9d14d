"""Gears whose losses depend on the force that they carry: closed forms of driving, coasting, holding and turning."""

import numpy as np
import pytest

import gearblocks as gb

EXACT = 1e-12  # closed forms that are polynomials of time: only rounding over some ten steps is left
METHODS = [
    {"method": "dp5"},
    {"method": "dp8"},
    {"method": "rodas"},
    {"method": "auto"},
    {"method": "rk4", "step": 0.01},
]
EVERY_METHOD = pytest.mark.parametrize("options", METHODS, ids=lambda options: options["method"])


def _chain(**parts):
    rig = gb.Drivetrain("train")
    rig.chain(*(rig.add(name, block) for name, block in parts.items()))
    return rig


def _modes(run, name):
    """(time, mode after) of one element."""
    return [(e.t, e.after) for e in run.events if e.component == name]


RATIO, ETA1, ETA2, J1, J2 = 2.0, 0.9, 0.8, 0.5, 3.0


def _lossy(tau, load=0.0, w0=0.0, ratio=RATIO, **losses):
    gear = gb.LossyGear(ratio=ratio, efficiency=(ETA1, ETA2), **losses)
    return _chain(
        drive=gb.Torque(tau=tau), one=gb.Inertia(J=J1), gear=gear, two=gb.Inertia(J=J2, w0=w0), load=gb.Torque(tau=load)
    )


@EVERY_METHOD
@pytest.mark.parametrize("ratio", [2.0, 0.5])  # either side may be the one that follows
@pytest.mark.parametrize(("tau", "eta"), [(10.0, ETA1), (-1.0, 1 / ETA2)])
@pytest.mark.few(1)
def test_a_lossy_gear_passes_on_what_its_efficiency_leaves(tau, eta, ratio, options):
    run = gb.simulate(_lossy(tau, w0=9.0, ratio=ratio), t_end=1.0, **options)
    assert run["two.alpha"][-1] == pytest.approx(ratio * eta * tau / (J2 + ratio**2 * eta * J1), rel=EXACT)
    assert run["two.w"][-1] == pytest.approx(9.0 + run["two.alpha"][-1], rel=EXACT)
    assert run.energy.residual < EXACT


@pytest.mark.long
@pytest.mark.parametrize("ratio", [2.0, pytest.param(0.5, marks=pytest.mark.long)])
def test_implicit_steps_through_a_lossy_gear_keep_their_order(ratio):
    """A spring behind the gear: its torque stays above that of the drive's swing, so that one side drives."""
    rig = _chain(
        drive=gb.Torque(tau=20.0), one=gb.Inertia(J=J1, w0=ratio * 9.0),
        gear=gb.LossyGear(ratio=ratio, efficiency=(ETA1, ETA2)), two=gb.Inertia(J=J2, w0=9.0), shaft=gb.Shaft(k=30.0, c=2.0),
        end=gb.Inertia(J=4.0, w0=9.0),
    )  # fmt: skip
    true = gb.simulate(rig, t=[1.0], method="dp8", rtol=1e-12)
    assert true["gear.torque"][0] > 0 and true.events == ()
    errors = []
    for step in (0.1, 0.05):
        run = gb.simulate(rig, t=[1.0], method="rodas", step=step)
        errors.append(max(abs(run[x][0] - true[x][0]) for x in ("one.w", "two.w", "end.w", "end.phi")))
    assert errors[0] < 1e-4 and errors[1] < errors[0] / 12  # of order four or five


@EVERY_METHOD
def test_a_lossy_gear_changes_its_losses_when_its_force_turns(options):
    run = gb.simulate(_lossy(4.0 - 2 * gb.time, w0=5.0), t_end=3.0, rtol=1e-9, **options)
    speed = [RATIO * eta / (J2 + RATIO**2 * eta * J1) for eta in (ETA1, 1 / ETA2)]
    assert run["two.w"][-1] == pytest.approx(5.0 + 4.0 * speed[0] - 1.0 * speed[1], rel=1e-8)
    assert run.energy.residual < 1e-8


@pytest.mark.parametrize(("rise", "limit"), [(1.0, (5.0 + 1.0) / ETA1), (-1.0, (5.0 - 1.0) * ETA2)])
@EVERY_METHOD
@pytest.mark.few(3)
def test_a_lossy_gear_at_rest_holds_between_what_both_directions_ask_for(rise, limit, options):
    rig = _lossy(4.5 + rise * gb.time, load=-10.0, bearing=(1.0, 1.0))
    run = gb.simulate(rig, t_end=4.0, rtol=1e-9, **options)
    ((t, after),) = _modes(run, "gear")
    assert (4.5 + rise * t, after) == (pytest.approx(limit, rel=1e-9), rise)
    assert (run["two.phi"][run.t <= t] == 0.0).all()
    eta = ETA1 if rise > 0 else 1 / ETA2
    speed = RATIO * eta / (J2 + RATIO**2 * eta * J1)
    assert run["two.w"][-1] == pytest.approx(speed * rise * (4.0 - t) ** 2 / 2, rel=1e-7)


@pytest.mark.long
@EVERY_METHOD
def test_a_brake_behind_a_lossy_gear_holds_what_the_gear_leaves(options):
    """Both at rest: the gear keeps as much as it can, the brake the rest; in motion the gear loses its share."""
    rig = gb.Drivetrain("held")
    one, two = rig.add("one", gb.Inertia(J=J1)), rig.add("two", gb.Inertia(J=J2))
    gear = rig.add("gear", gb.LossyGear(ratio=RATIO, efficiency=(ETA1, ETA2)))
    rig.chain(rig.add("drive", gb.Torque(tau=4.0 * gb.time)), one, gear, two, rig.add("clutch", gb.Clutch(capacity=9.0)),
              rig.add("three", gb.Inertia(J=1.0)))  # fmt: skip
    run = gb.simulate(rig, t_end=1.0, rtol=1e-9, **options)
    alpha = RATIO * ETA1 * 4.0 / (J2 + 1.0 + RATIO**2 * ETA1 * J1)
    assert run["three.w"][-1] == pytest.approx(alpha / 2, rel=1e-9)
    assert run["clutch.torque"][-1] == pytest.approx(alpha, rel=1e-9)
    assert np.array_equal(run["three.w"], run["two.w"])


@pytest.mark.long
def test_a_self_locking_worm_at_rest_is_not_driven_by_its_wheel():
    worm = gb.LossyGear(ratio=30.0, efficiency=(0.3, -0.2))
    rig = _chain(
        screw=gb.Inertia(J=1e-3), worm=worm, wheel=gb.Inertia(J=0.5), load=gb.Torque(tau=gb.Parameter("load", 1.0))
    )
    for load in (1.0, -1.0):
        run = gb.simulate(rig, t_end=1.0, parameters={"load": load})
        assert (run["wheel.phi"] == 0.0).all() and run.events == ()


def test_start_speeds_that_a_lossy_gear_does_not_allow_are_refused_by_name():
    rig = gb.Drivetrain("train")
    one, two = rig.add("one", gb.Inertia(J=1.0, w0=2.0)), rig.add("two", gb.Inertia(J=1.0, w0=3.0))
    rig.chain(one, rig.add("gear", gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.8))), two)
    with pytest.raises(gb.SimulationError, match="'gear': the start values contradict it"):
        gb.simulate(rig, t_end=1.0)
    run = gb.simulate(rig.set({"two.w0": 1.0}), t_end=0.01)
    assert (run["one.w"][0], run["two.w"][0]) == (2.0, 1.0)


@pytest.mark.long
@EVERY_METHOD
@pytest.mark.parametrize(
    ("tau", "load", "ratio", "w0", "bearing"),
    [
        (0.5, 4.0, 3.0, 20.0, (2.0, 0.2)),
        (0.2, 0.3, -0.5, 9.0, (1.5, 0.3)),
        (0.3, -1.5, 3.0, -20.0, (1.0, 0.0)),
        (2.5, 3.0, 2.0, 0.0, (2.0, 0.2)),
        (-2.5, -3.0, 2.0, 0.0, (2.0, 0.2)),
    ],
)
def test_a_drives_where_a_run_begins_between_both_bearing_torques(tau, load, ratio, w0, bearing, options):
    """Both sides hold all along, with u = J_b alpha/ratio - load/ratio below -tau2 and not below -tau1."""
    rig = _chain(
        drive=gb.Torque(tau=tau), one=gb.Inertia(J=1.0),
        gear=gb.LossyGear(ratio=ratio, efficiency=(ETA1, ETA2), bearing=bearing), two=gb.Inertia(J=0.5, w0=w0),
        load=gb.Torque(tau=load),
    )  # fmt: skip
    run = gb.simulate(rig, t_end=1.0, **options)
    sign = np.sign(ratio * w0) if w0 else np.sign(tau)
    alpha, other = (
        (tau + (load / ratio - sign * loss) / eta) / (ratio + 0.5 / (ratio * eta))
        for loss, eta in zip(bearing, (ETA1, 1 / ETA2), strict=True)
    )
    for rate in (alpha, other):
        assert -bearing[0] <= sign * (0.5 * rate - load) / ratio < -bearing[1]
    assert run["two.w"][-1] == pytest.approx(w0 + alpha, rel=EXACT)
    assert run.energy.residual < EXACT

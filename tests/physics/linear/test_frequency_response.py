"""Frequency response against formulas and long runs."""

import numpy as np
import pytest

import gearblocks as gb


def _mass(J=2.0, k=500.0, c=3.0):
    """One body on a spring and damper, driven by the input tau and a constant torque."""
    rig = gb.Drivetrain("one mass")
    drive, load = rig.add("drive", gb.Torque(tau=gb.Input("tau"))), rig.add("load", gb.Torque(tau=1.0))
    body = rig.add("body", gb.Inertia(J=J))
    rig.chain(drive, load, body, rig.add("shaft", gb.Shaft(k=k, c=c)), rig.add("ground", gb.Fixed()))
    return rig


# -- frequency response -----------------------------------------------------------------------------------------------


def test_one_mass_answers_as_the_formula_says():
    J, k, c = 2.0, 500.0, 3.0
    w = np.geomspace(0.1, 1e3, 50)
    true = 1 / (k - J * w**2 + 1j * c * w)
    for source in ("tau", "load.tau"):
        found = gb.frequency_response(_mass(J, k, c), source, ["body.phi", "shaft.torque", "body.alpha"], w)
        assert np.abs(found["body.phi"] / true - 1).max() < 1e-8  # at 1e3 rad/s J w^2 is 4000 k
        assert np.abs(found["shaft.torque"] / ((k + 1j * c * w) * true) - 1).max() < 1e-8
        assert np.abs(found["body.alpha"] / (-(w**2) * true) - 1).max() < 1e-8


def test_the_response_is_that_of_a_long_run():
    rig, w = _mass(), 12.0
    driven = rig.set({"load": gb.Torque(tau=0.5 * gb.cos(w * gb.time))})
    t = 60.0 + np.linspace(0, 2 * np.pi / w, 64, endpoint=False)  # exp(-0.75 60) of the start is left
    run = gb.simulate(driven, t=t, rtol=1e-10, outputs=["shaft.torque"])
    response = gb.frequency_response(rig, "load.tau", ["shaft.torque"], [w])["shaft.torque"][0]
    assert run["shaft.torque"] == pytest.approx((0.5 * response * np.exp(1j * w * t)).real, abs=1e-8 * abs(response))


def test_a_response_without_bound_is_refused():
    with pytest.raises(gb.ParameterError, match="no bound"):
        gb.frequency_response(_mass(c=None, k=8.0), "tau", ["body.w"], [2.0])
    with pytest.raises(gb.UnknownNameError):
        gb.frequency_response(_mass(), "tau", ["body.w"], [2.0])["shaft.torque"]


# -- prescribed motions, shafts without inertia ------------------------------------------------------------------------


@pytest.mark.long
def test_a_body_that_a_filtered_speed_shakes_answers_as_the_formula_says():
    J, k, c, cut = 0.5, 200.0, 1.5, 50.0
    rig = gb.Drivetrain("shaken")
    base = rig.add("base", gb.Speed(w=gb.Input("u", start=2.0), filter=cut))
    rig.chain(base, rig.add("shaft", gb.Shaft(k=k, c=c)), rig.add("body", gb.Inertia(J=J, w0=2.0)))
    w = np.logspace(0, 3, 7)
    s = 1j * w
    for at in (None, "static"):
        found = gb.frequency_response(rig, "u", "body.w", w, at=at)["body.w"]
        true = (k + c * s) / (J * s**2 + c * s + k) * cut / (s + cut)
        assert np.abs(found / true - 1).max() < 1e-9  # the input's column is a difference
        matrices = gb.linearize(rig, at, outputs=["shaft.twist"])
        assert matrices.states == ("shaft.coordinate", "base.filtered_speed", "body.w")
        true = [[0, -1, 1], [0, -cut, 0], [-k / J, c / J, -c / J]]
        assert np.abs(matrices.A - np.array(true)).max() < 1e-12 * k / J


@pytest.mark.long
def test_a_support_that_time_moves_carries_like_the_ground():
    J, k, c = 0.5, 200.0, 1.5
    w = np.logspace(0, 3, 7)
    for phi in (0.1 * gb.sin(30 * gb.time), 0.0):
        rig = gb.Drivetrain("rocked")
        load = rig.add("load", gb.Torque(tau=gb.Input("T")))
        base, body = rig.add("base", gb.Angle(phi=phi)), rig.add("body", gb.Inertia(J=J))
        rig.chain(base, rig.add("shaft", gb.Shaft(k=k, c=c)), body, load)
        found = gb.frequency_response(rig, "T", "body.phi", w)["body.phi"]
        assert np.abs(found * (k + 1j * c * w - J * w**2) - 1).max() < 1e-9
        assert gb.modes(rig, None).frequencies == pytest.approx([np.sqrt(k / J)], rel=1e-12)

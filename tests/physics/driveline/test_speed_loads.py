"""Loads that grow with speed: closed forms of spinning down."""

import numpy as np
import pytest

import gearblocks as gb


def _spinning(coeffs, w0, J=0.5):
    rig = gb.Drivetrain("spin down")
    body, load = rig.add("body", gb.Inertia(J=J, w0=w0)), rig.add("load", gb.SpeedLoad(coeffs=coeffs))
    rig.chain(body, load)
    return rig


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_constant_and_linear_load_spins_down_exponentially(way, distance):
    c0, c1, J, w0 = 0.4, 0.2, 0.5, 30.0
    t = np.linspace(0, 5, 51)  # it would come to rest at J/c1 ln(1 + c1 w0/c0) = 6.9 s
    run = gb.simulate(_spinning((c0, c1, 0.0), way * w0), t=t, rtol=1e-12)
    assert distance(run["body.w"], way * ((w0 + c0 / c1) * np.exp(-c1 * t / J) - c0 / c1)) < 1e-10
    lost = J / 2 * (w0**2 - run["body.w"][-1] ** 2)
    assert run.energy.dissipated["load"] == pytest.approx(lost, rel=1e-11)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_square_load_spins_down_hyperbolically(way, distance):
    c2, J, w0 = 0.01, 0.5, 40.0
    t = np.linspace(0, 20, 51)
    run = gb.simulate(_spinning((0.0, 0.0, c2), way * w0), t=t, rtol=1e-12)
    assert distance(run["body.w"], way * w0 / (1 + c2 * w0 * t / J)) < 1e-10


def test_a_load_opposes_whichever_way_the_shaft_turns():
    run = gb.simulate(_spinning((0.1, 0.1, 0.1), 3.0), t=[0.1], rtol=1e-8)
    back = gb.simulate(_spinning((0.1, 0.1, 0.1), -3.0), t=[0.1], rtol=1e-8)
    assert run["load.torque"][0] == -back["load.torque"][0] < 0
    assert run["load.loss_power"][0] == back["load.loss_power"][0] > 0

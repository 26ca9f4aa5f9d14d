"""Friction that breaks away while inner friction, and the sign of a load, turn their modes at the same instant.

A body on a shaft is pulled by a constant torque: J phi'' = torque - k phi - c phi', with d = c/(2 J), w^2 = k/J - d^2
    phi = torque/k (1 - exp(-d t)(cos(w t) + d/w sin(w t))).
What holds the other end lets go where k phi + c phi' reaches its capacity, once.
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import gearblocks as gb

J, K, C, TORQUE, CAPACITY = 1.25, 20.1, 0.502, 11.9, 8.64


def _rig(joint, load, hold):
    rig = gb.Drivetrain("lets go")
    held, pulled = rig.add("held", gb.Inertia(J=0.419)), rig.add("pulled", gb.Inertia(J=J))
    beside, behind = rig.add("beside", gb.Inertia(J=0.105)), rig.add("behind", gb.Inertia(J=0.13))
    joints = {"clutch": gb.Clutch(capacity=1.31), "synchronizer": gb.Synchronizer(engaged=1.0, capacity=1.31)}
    holds = {
        "stribeck": gb.BearingFriction(
            coulomb=3.25, viscous=0.325, stribeck=gb.Stribeck(rise=CAPACITY - 3.25, speed=1.0)
        ),
        "coulomb": gb.BearingFriction(coulomb=CAPACITY, viscous=0.325),
        "brake": gb.Brake(capacity=CAPACITY),
    }
    rig.chain(held, rig.add("joint", joints[joint]), beside)
    rig.chain(held, rig.add("shaft", gb.Shaft(k=K, c=C)), pulled, rig.add("pull", gb.Torque(tau=TORQUE)))
    inner = gb.Hysteresis(friction=27.8, stiffness=315.0)
    rig.chain(held, rig.add("inner", gb.Shaft(k=323.0, c=2.83, hysteresis=inner)), behind)
    rig.connect(held.b, rig.add("hold", holds[hold]).a)
    if load:
        rig.connect(held.b, rig.add("load", gb.SpeedLoad(coeffs=(0.0, 1.39, 0.0323))).flange)
    return rig


def _let_go():
    d = C / (2 * J)
    w = math.sqrt(K / J - d**2)

    def short_of(t):
        decay, s, c = math.exp(-d * t), math.sin(w * t), math.cos(w * t)
        phi = TORQUE / K * (1 - decay * (c + d / w * s))
        return K * phi + C * TORQUE / K * decay * (w + d**2 / w) * s - CAPACITY

    return brentq(short_of, 0.0, 1.5 / w, xtol=1e-15)


@pytest.mark.parametrize("hold", ["stribeck", "coulomb", "brake"])
@pytest.mark.parametrize("load", [True, False], ids=["load", "no load"])
@pytest.mark.parametrize("joint", ["clutch", "synchronizer"])
@pytest.mark.few(1)
def test_it_lets_go_once_however_accurate_the_run(joint, load, hold):
    model = gb.build(_rig(joint, load, hold))
    ends = []
    for method, rtols in (("rodas", (1e-6, 1e-7, 1e-8, 3e-9, 1e-9)), ("dp8", (1e-6, 1e-8)), ("dp5", (1e-6, 1e-8))):
        for rtol in rtols:
            run = gb.simulate(model, t=[0.0, 1.0], method=method, rtol=rtol)
            times = [e.t for e in run.events if e.component == "hold" and e.t > 0.0]
            assert 1 <= len(times) <= 3, (method, rtol)
            assert times == pytest.approx([_let_go()] * len(times), abs=10 * rtol), (method, rtol)
            ends.append(run["held.w"][-1])
    assert ends == pytest.approx([ends[4]] * len(ends), abs=2e-5 * np.abs(ends).max())

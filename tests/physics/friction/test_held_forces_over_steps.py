"""Forces of constraints that hold are told for several steps by one box of their arguments, and no break-away is lost.

    held body: brake of capacity c, load T + D cos(phi)^40 over the angle phi = w t + phi0 of another shaft

The load is beyond c about phi = k pi alone, for a short while: the brake lets go once for each of these, at the angle where
the load has come to c, however long the steps between them are. A condition over the angle of that shaft is watched beside it.
"""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

CAPACITY, BASE, SPEED, START = 10.0, 4.0, 3.0, 0.7


class Pulses(gb.Block):
    """A load on b over the angle of a, which feels nothing of it but a window of no weight."""

    a, b = gb.Flange("shaft that turns"), gb.Flange("body that is held")
    base: float = gb.param("load between the pulses", "N m")
    height: float = gb.param("height of a pulse", "N m")

    def physics(self, s):
        yield gb.Acts(s.b, s.base + s.height * sp.cos(s.a.phi) ** 40)
        yield gb.Acts(s.a, sp.Piecewise((sp.Float(1e-12), sp.cos(s.a.phi) > 0.2), (0, True)))


def held(height):
    rig = gb.Drivetrain("pulses")
    shaft = rig.add("shaft", gb.Inertia(J=1e3, w0=SPEED, phi0=START))
    body = rig.add("body", gb.Inertia(J=1.0))
    pulses = rig.add("pulses", Pulses(base=BASE, height=height))
    rig.connect(shaft.b, pulses.a)
    rig.connect(pulses.b, body.a)
    rig.connect(body.b, rig.add("brake", gb.Brake(capacity=CAPACITY)).a)
    return rig


@pytest.mark.parametrize("beyond", [1e-1, 1e-3, 1e-6])
@pytest.mark.parametrize(
    ("method", "step"), [("dp8", None), ("dp5", None), ("rodas", None), ("dp8", 0.02), ("rodas", 0.02)]
)
@pytest.mark.few(4)
def test_each_pulse_beyond_the_capacity_is_one_break_away(beyond, method, step):
    """step: so short that one box serves many between two pulses."""
    height = (CAPACITY - BASE) * (1 + beyond)
    turns = 12
    end = (turns * np.pi - START - 0.5 * np.pi) / SPEED
    run = gb.simulate(held(height), t=[0, end], method=method, rtol=1e-5, max_step=step, outputs=[])
    found = [e.t for e in run.events if e.component == "brake" and e.before == 0 and e.after != 0]
    early = np.arccos((1 + beyond) ** (-1 / 40))  # before the peak the load comes to the capacity
    expected = (np.arange(1, turns) * np.pi - early - START) / SPEED
    assert len(found) == turns - 1
    assert found == pytest.approx(expected, abs=1e-7)
    assert run.stats.steps < (60 if step is None else 100) * turns


def test_pulses_below_the_capacity_let_go_of_nothing():
    run = gb.simulate(held((CAPACITY - BASE) * (1 - 1e-6)), t=[0, 12], outputs=[])
    assert not [e for e in run.events if e.component == "brake"]

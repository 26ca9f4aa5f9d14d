"""Two stops whose limits leave a train no room to move in, both at one coordinate through an ideal gear: what comes in bounces
between them in no time, until it has nothing left, and is held from both sides."""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb


def between_two_limits(ratio: float, w0: float, restitutions: tuple[float, float], room: float = 0.0) -> gb.Drivetrain:
    """A body with a limit ahead, and behind a gear one on the other side."""
    rig = gb.Drivetrain("no room")
    rig.add("body", gb.Inertia(J=1.0, w0=w0))
    rig.add("gear", gb.IdealGear(ratio=ratio))
    rig.add("ahead", gb.HardStop(restitution=restitutions[0], upper=room, lower=-1.0))
    rig.add("behind", gb.HardStop(restitution=restitutions[1], lower=0.0))
    rig.add("drive", gb.Torque(tau=gb.sin(3.0 * gb.time)))
    rig.connect(rig["body"].a, rig["ahead"].a, rig["gear"].a)
    rig.connect(rig["gear"].b, rig["behind"].a)
    rig.connect(rig["body"].b, rig["drive"].flange)
    return rig


@pytest.mark.parametrize("ratio", [0.7, 1.0, 2.0, 3.3])
@pytest.mark.parametrize("restitutions", [(0.0, 0.0), (0.5, 0.5), (1.0, 0.5), (0.5, 1.0), (1.0, 0.0)])
@pytest.mark.parametrize("w0", [-0.5, 0.0, 0.5])
@pytest.mark.few(12)
def test_what_comes_in_ends_in_rest(ratio: float, restitutions: tuple[float, float], w0: float) -> None:
    """Steps of a body that two stops without room hold are nothing, whatever pushes it."""
    run = gb.simulate(between_two_limits(ratio, w0, restitutions), t=np.linspace(0.0, 1.0, 11))
    assert np.abs(run["body.phi"]).max() < 1e-12
    assert np.abs(run["body.w"][1:]).max() < 1e-12
    assert run.energy.residual < 1e-9


@pytest.mark.parametrize("restitutions", [(1.0, 0.999), (0.999, 1.0), (0.9999, 0.9999)])
def test_what_loses_next_to_nothing_ends_in_rest_too(restitutions: tuple[float, float]) -> None:
    run = gb.simulate(between_two_limits(2.0, 0.5, restitutions), t_end=1.0)
    assert np.abs(run["body.w"][1:]).max() < 1e-12 and run.energy.residual < 1e-9


def test_without_loss_it_has_no_end_and_says_so() -> None:
    what = "'(ahead|behind)': it strikes without loss .* give one of these contacts a restitution below 1, or some room"
    with pytest.raises(gb.SimulationError, match=what):
        gb.simulate(between_two_limits(2.0, 0.5, (1.0, 1.0)), t_end=1.0)
    run = gb.simulate(between_two_limits(2.0, 0.5, (1.0, 1.0), room=0.02), t_end=1.0)
    assert len(run.events) > 20

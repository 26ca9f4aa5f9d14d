"""A body that drags another one bounces on a stop: each impact opens their contact, in the end for nothing, and all rest."""

import numpy as np
import pytest

import gearblocks as gb


def _rig(play):
    """The second body is behind the first one, in a rigid contact that drags it; its own load holds it back."""
    rig = gb.Drivetrain("dragged")
    front = rig.add("front", gb.Inertia(J=gb.Parameter("J1", 0.2), w0=gb.Parameter("fast", 0.1)))
    back = rig.add("back", gb.Inertia(J=gb.Parameter("J2", 1.0), phi0=-play, w0=gb.Parameter("fast", 0.1)))
    stop = rig.add("stop", gb.HardStop(restitution=gb.Parameter("kept", 0.7), upper=0.0))
    hit = gb.HuntCrossley(restitution=gb.Parameter("kept2", 0.6))
    gap = rig.add("gap", gb.Lash(k=1e3, half_gap=play, contact_damping=hit))
    rig.chain(front, gap, back)
    rig.connect(stop.a, front.a, rig.add("drive", gb.Torque(tau=gb.Parameter("pull", 20.0))).flange)
    rig.connect(back.b, rig.add("drag", gb.Torque(tau=-1.0 * gb.Parameter("hold", 5.0))).flange)
    return rig.without("gap.compliance")


@pytest.mark.parametrize("play", [0.07, 1.4, 30.0])
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas", "auto"])
@pytest.mark.few(1)
def test_both_come_to_rest(play, method):
    """Energy is what the impacts lose; what presses both is 5 to 50 times as much in the one as in the other."""
    model, random = gb.build(_rig(play)), np.random.default_rng(11)
    for _ in range(25):
        values = {
            "J1": 10 ** random.uniform(-1.5, 0.5), "J2": 10 ** random.uniform(-1.5, 0.5), "fast": 10 ** random.uniform(-3, 0),
            "kept": random.uniform(0.2, 0.8), "kept2": random.uniform(0.2, 0.8), "pull": 10 ** random.uniform(1, 2),
            "hold": 10 ** random.uniform(-1, 0.9),
        }  # fmt: skip
        rtol = 10 ** random.uniform(-8, -4)
        mass, force = values["J1"] + values["J2"], min(values["hold"], values["pull"] - values["hold"])
        t_end = 1.0 + 400.0 * mass * values["fast"] / force  # flights are 2 v J / force long
        run = gb.simulate(model, t_end=t_end, parameters=values, method=method, rtol=rtol)
        assert (run["front.w"][-1], run["stop.contact"][-1]) == (0.0, 1.0), values
        assert abs(run["back.w"][-1]) < 1e-12, values
        assert run["back.phi"][-1] == pytest.approx(-play, abs=1e-12), values
        assert abs(run.energy.residual) < 10 * rtol, values

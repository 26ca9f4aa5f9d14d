"""Two clutches between the same bodies, of which one comes and goes, then a synchronizer and a planetary set.

While the other one holds, the train moves as one in which clutches and synchronizer are rigid shafts.
"""

import numpy as np
import pytest

import gearblocks as gb

METHODS = pytest.mark.parametrize("method", ["dp5", "dp8", "rodas", "auto"])
T = np.linspace(0.0, 1.5, 16)
BODIES = ("one", "two", "sun", "carrier", "ring")


def train(torque, coming, *, at="one", rigid=False):
    """Bodies one and two with the clutches, the sun behind the synchronizer; torque at one of the bodies."""
    rig = gb.Drivetrain("side by side")
    body = {name: rig.add(name, gb.Inertia(J=J)) for name, J in zip(BODIES, (1.0, 0.5, 0.25, 2.0, 0.75), strict=True)}
    clutches = [gb.Shaft(rigid=True)] if rigid else [gb.Clutch(capacity=30.0), gb.Clutch(capacity=coming)]
    for i, block in enumerate(clutches):
        clutch = rig.add(f"clutch{i}", block)
        rig.connect(body["one"].b, clutch.a)
        rig.connect(clutch.b, body["two"].a)
    sync = rig.add("sync", gb.Shaft(rigid=True) if rigid else gb.Synchronizer(engaged=1.0, capacity=20.0))
    rig.connect(body["two"].b, sync.a)
    rig.connect(sync.b, body["sun"].a)
    planetary = rig.add("set", gb.IdealPlanetary(ratio=2.5))
    for flange in ("sun", "carrier", "ring"):
        rig.connect(body[flange].b, getattr(planetary, flange))
    if torque is not None:
        rig.connect(rig.add("drive", gb.Torque(tau=torque)).flange, body[at].a)
    return rig


COMING = {
    "pulses": 2 * gb.sin(10 * gb.time),
    "sizes": abs(2 * gb.sin(7 * gb.time)),
    "lifted": 1 + 2 * gb.cos(9 * gb.time),
    "table": gb.Table([0.0, 0.3, 0.6, 1.0], [2.0, 0.0, 0.0, 5.0]),
}


@pytest.mark.long
@METHODS
@pytest.mark.parametrize(
    "name", ["pulses", *(pytest.param(x, marks=pytest.mark.long) for x in COMING if x != "pulses")]
)
def test_without_a_load_nothing_moves(name, method):
    run = gb.simulate(train(None, COMING[name]), t=T, method=method)
    assert all(np.all(run[f"{body}.w"] == 0.0) for body in BODIES)


@METHODS
@pytest.mark.parametrize("at", ["one", pytest.param("carrier", marks=pytest.mark.long)])
@pytest.mark.parametrize(
    "name", ["pulses", *(pytest.param(x, marks=pytest.mark.long) for x in COMING if x != "pulses")]
)
@pytest.mark.few(2)
def test_under_a_load_that_the_other_holds_they_are_rigid(name, at, method):
    torque = 3 * gb.sin(4 * gb.time)
    run = gb.simulate(train(torque, COMING[name], at=at), t=T, method=method, rtol=1e-8)
    rigid = gb.simulate(train(torque, None, at=at, rigid=True), t=T, rtol=1e-11)
    for body in BODIES:
        assert run[f"{body}.w"] == pytest.approx(rigid[f"{body}.w"], abs=1e-6), body
    assert np.all(run["clutch0.w_rel"] == 0.0) and run.energy.residual < 1e-7

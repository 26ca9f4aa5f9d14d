"""Blocks with a housing or a carrier: torques of all flanges are in equilibrium, and a housing that turns evenly takes the
whole motion along without changing it."""

import numpy as np
import pytest

import gearblocks as gb

T, W = gb.time, 40.0
TURNING = gb.Parameter("turning", 0.0)
CURVE = gb.Table([0, 0.5, 0.9, 1.0], [0.02, 0.018, 0.01, 0.0]), gb.Table([0, 0.9, 1.0], [2.0, 1, 1])
MAP = gb.Table2([-50.0, 0.0, 50.0, 100.0], [0.0, 1.0], [[1, 4], [0, 5], [-1, 6], [-3, 2]])
TEETH = {"teeth": (23, 41), "external": True, "module": 3e-3, "pressure_angle": 0.35, "k": 2e5, "c": 30.0}
FRICTION = gb.ToothFriction(mu=0.1, transition=0.1)

# block; its flanges beside the housing; the name of that; speeds of the bodies over the housing at the start
CASES = {
    "belt": (gb.BeltDrive(ratio=2.0, slip=gb.Creep(stiffness=100.0, low_speed=0.5, limit=4.0)), ("a", "b"), (4.0, 2.1)),
    "rigid belt": (gb.BeltDrive(ratio=2.0), ("a", "b"), (4.0, 2.0)),
    "converter": (gb.TorqueConverter(capacity=CURVE[0], ratio=CURVE[1]), ("impeller", "turbine"), (10.0, 2.0)),
    "gear": (gb.IdealGear(ratio=-2.5), ("a", "b"), (5.0, -2.0)),
    "lossy gear": (gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.8), bearing=(0.1, 0.2)), ("a", "b"), (4.0, 2.0)),
    "mesh": (gb.GearMesh(**TEETH, friction=FRICTION), ("pinion", "wheel"), (8.2, -4.6)),
    "ratio law": (
        gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.3), external=True, k=500 * (2 + gb.cos(gb.driver_angle)), c=2.0),
        ("a", "b"), (3.0, 0.0),
    ),
    "brake": (gb.Brake(capacity=2.0), ("a",), (1.5, 0.0)),
    "bearing": (gb.BearingFriction(coulomb=0.5, viscous=0.2), ("a",), (1.5, 0.0)),
    "eddy currents": (gb.EddyCurrentBrake(tau_nominal=3.0, w_nominal=2.0), ("flange",), (5.0, 0.0)),
    "engine": (gb.Engine(torque_map=MAP, throttle=0.6), ("flange",), (3.0, 0.0)),
    "motor": (gb.DCMotor(R=0.5, L=0.01, k=0.3, u=6.0), ("flange",), (3.0, 0.0)),
    "torque": (gb.Torque(tau=2.0), ("flange",), (3.0, 0.0)),
}  # fmt: skip


def _train(block, flanges):
    """Two bodies, the first one driven, and the block between them or on the first; a frame of prescribed speed."""
    rig = gb.Drivetrain("on a frame")
    one, two, frame = (rig.add(n, gb.Inertia(J=J)) for n, J in (("one", 0.4), ("two", 0.7), ("frame", 1.0)))
    el, drive = rig.add("el", block), rig.add("drive", gb.Torque(tau=2 + 3 * gb.sin(7 * T)))
    rig.connect(rig.add("speed", gb.Speed(w=TURNING)).flange, frame.a)
    rig.connect(drive.flange, one.a)
    rig.connect(getattr(el, "carrier" if "carrier" in type(block).flanges else "housing"), frame.b)
    for flange, body in zip(flanges, (one.b, two.a), strict=False):
        rig.connect(getattr(el, flange), body)
    return rig


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] * (name == "ratio law")) for name in CASES]
)
@pytest.mark.few(1)
def test_a_housing_that_turns_evenly_takes_the_motion_along(name):
    block, flanges, speeds = CASES[name]
    model, runs = gb.build(_train(block, flanges)), []
    follow = {"one"} if name in ("rigid belt", "gear") else {}
    for turning in (0.0, W):
        start = {f"{n}.w": w + turning for n, w in zip(("one", "two"), speeds, strict=True) if n not in follow}
        runs.append(
            gb.simulate(model, t=np.linspace(0, 1, 51), rtol=1e-10, initial=start, parameters={"turning": turning})
        )
    still, carried = runs
    for body in ("one", "two"):
        assert np.allclose(
            carried[f"{body}.w"] - W, still[f"{body}.w"], rtol=0, atol=2e-7
        )  # a hundred steps at 40 rad/s
    for run in runs:
        torques = [run[n] for n in run.names if n.startswith("el.") and n.count(".") == 2 and n.endswith(".tau")]
        assert len(torques) == len(flanges) + 1
        assert np.abs(sum(torques)).max() < 1e-9 * max(np.abs(x).max() for x in torques)
        assert np.abs(torques[0]).max() > 0.1

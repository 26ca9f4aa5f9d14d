"""Couplings, machines and vehicles: bad values are refused in words, good ones survive their file."""

from pathlib import Path

import pytest

import gearblocks as gb

NAN = float("nan")
MAP = gb.Table2([0, 100, 200, 400], [0, 1], [[0, 50], [-10, 150], [-15, 200], [-20, 120]])
CAPACITY = gb.Table([-1.0, 0.0, 0.8, 1.0, 1.2], [2.5e-3, 2.5e-3, 2.2e-3, 0.0, -1e-3])
RATIO = gb.Table([-1.0, 0.0, 0.85, 1.0], [2.4, 2.2, 1.0, 1.0])


def _chain(**blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("driveline")
    rig.chain(*(rig.add(part, block) for part, block in blocks.items()))
    return rig


def _converter(**changed: object) -> gb.Block:
    return gb.TorqueConverter(**{"capacity": CAPACITY, "ratio": RATIO, **changed})


def _car(**changed: object) -> gb.Block:
    return gb.Vehicle(**{"mass": 1000.0, "wheel_radius": 0.3, **changed})


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: _converter(capacity=3.0), "capacity = 3.0 must be a linear or cubic gb.Table over the speed ratio"),
        (lambda: _converter(ratio=gb.Table([0, 1], [2, 1], kind="step")), "ratio = Table(2 points, step"),
        (lambda: _converter(ratio=gb.Table([0, 1], [1, 1], periodic=True)), "not periodic"),
        (
            lambda: _converter(ratio=gb.Table([0, 0.7, 1], [2, 1.9, 1])),
            "more power than they take, most at a speed ratio at",
        ),
        (lambda: _converter(capacity=gb.Table([0, 1], [2e-3, 1e-3])), "above the last point"),
        (lambda: _converter(capacity=gb.Table([0, 1], [-2e-3, 0])), "below the first point"),
        (lambda: gb.BeltDrive(ratio=0), "ratio = 0 must not be 0"),
        (lambda: gb.BeltDrive(ratio=NAN), "ratio = nan must be a finite number"),
        (lambda: gb.BeltDrive(ratio=2, slip=0.01), "slip = 0.01 must be an effect object"),
        (lambda: gb.BeltDrive(ratio=2, slip=gb.Creep(stiffness=NAN, low_speed=1.0)), "slip.stiffness = nan N m"),
        (
            lambda: gb.BeltDrive(ratio=2, slip=gb.Creep(stiffness=1.0, low_speed=0.0)),
            "slip.low_speed = 0.0 rad/s must be > 0",
        ),
        (lambda: gb.UniversalJoint(angle=1.6), "angle = 1.6 rad must be < 1.5"),
        (lambda: gb.UniversalJoint(angle=NAN), "angle = nan rad must be a finite number"),
        (lambda: gb.EddyCurrentBrake(tau_nominal=-1.0, w_nominal=1.0), "tau_nominal = -1.0 N m must be >= 0"),
        (lambda: gb.EddyCurrentBrake(tau_nominal=1.0, w_nominal=0), "w_nominal = 0.0 rad/s must be > 0"),
        (
            lambda: gb.EddyCurrentBrake(tau_nominal=1.0, w_nominal=1.0, excitation=-1),
            "excitation = -1.0 must be >= 0: a brake",
        ),
        (
            lambda: gb.EddyCurrentBrake(tau_nominal=1.0, w_nominal=1.0, excitation=NAN),
            "excitation = nan must be a finite",
        ),
        (lambda: gb.DCMotor(R=1.0, L=0.0, k=0.1, u=1.0), "L = 0.0 H must be > 0"),
        (lambda: gb.DCMotor(R=1.0, L=1.0, k=NAN, u=1.0), "k = nan N m/A must be a finite number"),
        (lambda: gb.Engine(torque_map=100.0, throttle=1.0), "torque_map = 100.0 must be a gb.Table2"),
        (lambda: gb.Engine(torque_map=MAP, throttle=NAN), "throttle = nan must be a finite number"),
        (lambda: gb.Engine(torque_map=MAP), "Engine needs throttle"),
        (lambda: gb.Governor(target=1.0, gain=0.0), "gain = 0.0 s/rad must be > 0"),
        (lambda: gb.Governor(target=1.0, gain=1.0, lower=1.0), "lower = 1.0 must be < upper = 1.0"),
        (lambda: gb.Governor(target=NAN, gain=1.0), "target = nan rad/s must be a finite number"),
        (lambda: _car(mass=0), "mass = 0.0 kg must be > 0"),
        (lambda: _car(drag_area=-1.0), "drag_area = -1.0 m2 must be >= 0"),
        (lambda: _car(grade=NAN), "grade = nan rad must be a finite number"),
        (lambda: _car(grade=5), "grade = 5.0 rad must be < 1.5: it is an angle in rad"),
        (lambda: _car(rolling_speed=0.1), "rolling_speed needs rolling"),
        (
            lambda: _car(tyre=gb.TyreSlip(stiffness=1.0, grip=1.0, low_speed=1.0, shape=3)),
            "tyre.shape = 3.0 must be <= 2",
        ),
        (lambda: _car(tyre=0.1), "tyre = 0.1 must be an effect object"),
    ],
)
def test_bad_values_are_refused_in_words(make, words: str) -> None:
    with pytest.raises(gb.ModelError) as caught:
        gb.Drivetrain("rig").add("x", make())
    assert words in str(caught.value), str(caught.value)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "block",
    [
        _converter(), gb.BeltDrive(ratio=2.5, slip=gb.Creep(stiffness=500.0, low_speed=5.0, limit=40.0)),
        gb.BeltDrive(ratio=1.5), pytest.param(gb.UniversalJoint(angle=0.3, phase=0.1), marks=pytest.mark.long),
        gb.EddyCurrentBrake(tau_nominal=1.0, w_nominal=3.0, excitation=gb.Input("e", start=1.0)),
        gb.DCMotor(R=1.0, L=0.1, k=0.1, u=gb.Parameter("u", 12.0, "V")), gb.Engine(torque_map=MAP, throttle=gb.time / 10),
        gb.Governor(target=10.0, gain=1.0, integral_gain=0.1), _car(drag_area=0.6, tyre=gb.TyreSlip(
            stiffness=1e4, grip=0.9, low_speed=1.0), grade=gb.Table([0, 10], [0, 0.1])),
    ],
    ids=lambda block: type(block).__name__,
)  # fmt: skip
def test_a_block_survives_its_file(block: gb.Block, tmp_path: Path) -> None:
    rig = _chain(
        first=gb.Inertia(J=1.0, w0=3.0),
        block=block,
        **({"last": gb.Inertia(J=2.0)} if sum(not f.ground for f in block.flanges.values()) > 1 else {}),
    )
    rig.to_json(tmp_path / "rig.json")
    again = gb.Drivetrain.from_json(tmp_path / "rig.json")
    assert repr(again["block"].part) == repr(block)
    assert gb.build(again).program.key == gb.build(rig).program.key
    one, other = (gb.simulate(x, t=[0.3])["first.w"][0] for x in (rig, again))
    assert one == other

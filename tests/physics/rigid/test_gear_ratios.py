"""Rigid gears: exact ratios, reflected inertia, torques of ties, loops of ties."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

EXACT = 1e-13  # closed forms of a few terms: rounding


def _train(gear, J=(0.02, 0.5), tau=30.0, load=-40.0):
    rig = gb.Drivetrain("gear")
    motor, wheel = rig.add("motor", gb.Inertia(J=J[0])), rig.add("wheel", gb.Inertia(J=J[1]))
    pair = rig.add("gear", gear)
    drive, brake = rig.add("drive", gb.Torque(tau=tau)), rig.add("load", gb.Torque(tau=load))
    rig.chain(drive, motor, pair, wheel, brake)
    return rig


@pytest.mark.parametrize(
    ("gear", "i"),
    [
        (gb.IdealGear(ratio=3.5), 3.5),
        (gb.IdealGear(ratio=-0.1), -0.1),
        (gb.IdealGear(teeth=(23, 41), external=True), -41 / 23),
        (gb.IdealGear(teeth=(23, 41), external=False), 41 / 23),
    ],
    ids=["ratio", "negative", "external", "internal"],
)
@pytest.mark.few(1)
def test_inertia_is_reflected_by_the_square_of_the_ratio(gear, i):
    run = gb.simulate(_train(gear), t=[0.0, 0.5, 1.0], rtol=1e-10)
    alpha = (30.0 + -40.0 / i) / (0.02 + 0.5 / i**2)
    assert np.allclose(run["motor.alpha"], alpha, rtol=EXACT)
    assert np.allclose(run["wheel.alpha"], alpha / i, rtol=EXACT)
    assert np.allclose(run["motor.phi"], alpha * run.t**2 / 2, rtol=1e-12)
    assert np.allclose(run["motor.phi"], i * run["wheel.phi"], rtol=1e-15)  # one state, one multiplication
    # the tie's torque drives the wheel: J alpha - load
    assert np.allclose(run["gear.torque"], 0.5 * alpha / i + 40.0, rtol=EXACT)
    assert np.allclose(run["gear.b.tau"], run["gear.torque"], rtol=EXACT)
    assert np.allclose(run["gear.a.tau"], -run["gear.torque"] / i, rtol=EXACT)
    # power passes through without loss
    assert np.allclose(run["gear.a.power"] + run["gear.b.power"], 0, atol=1e-12 * np.abs(run["gear.b.power"]).max())


def test_a_compound_train_multiplies_its_ratios_exactly():
    rig = gb.Drivetrain("compound")
    parts = [rig.add("first", gb.Inertia(J=1.0))]
    teeth = ((17, 43), (19, 61), (23, 71), (13, 37))
    for n, pair in enumerate(teeth):
        parts.append(rig.add(f"gear{n}", gb.IdealGear(teeth=pair, external=True)))
        parts.append(rig.add(f"shaft{n}", gb.Inertia(J=1.0)))
    drive = rig.add("drive", gb.Torque(tau=1.0))
    rig.chain(drive, *parts)
    run = gb.simulate(rig, t=[1.0], rtol=1e-8)
    i = sp.prod([sp.Rational(-b, a) for a, b in teeth])
    assert run["first.w"][0] == pytest.approx(float(i) * run["shaft3.w"][0], rel=1e-15)
    ratios = [float(sp.prod([sp.Rational(-b, a) for a, b in teeth[:n]])) for n in range(5)]
    assert run["first.alpha"][0] == pytest.approx(1.0 / sum(1 / r**2 for r in ratios), rel=EXACT)


def _loop(last):
    rig = gb.Drivetrain("loop")
    a, b, c = (rig.add(n, gb.Inertia(J=1.0)) for n in "abc")
    first, second = rig.add("first", gb.IdealGear(ratio=2)), rig.add("second", gb.IdealGear(ratio=3))
    third = rig.add("third", gb.IdealGear(ratio=last))
    drive = rig.add("drive", gb.Torque(tau=1.0))
    rig.chain(drive, a, first, b, second, c)
    rig.connect(third.a, a.a)
    rig.connect(third.b, c.a)
    return rig


def test_ties_that_contradict_are_refused_naming_the_loop():
    with pytest.raises(gb.ModelError) as found:
        gb.build(_loop(6.001))
    for name in ("first", "second", "third", "6.001", "6"):
        assert name in str(found.value)


def test_redundant_ties_that_agree_are_accepted():
    run = gb.simulate(_loop(6), t=[1.0], rtol=1e-9)
    assert run["a.alpha"][0] == pytest.approx(1 / (1 + 1 / 4 + 1 / 36), rel=EXACT)


@pytest.mark.long
def test_two_ways_from_the_motor_to_one_wheel_agree_in_whole_teeth_only():
    def layshaft(z):
        rig = gb.Drivetrain("layshaft")
        motor, shaft, wheel = (rig.add(n, gb.Inertia(J=1.0)) for n in ("motor", "shaft", "wheel"))
        one, two = (
            rig.add("one", gb.IdealGear(teeth=(20, 30), external=True)),
            rig.add("two", gb.IdealGear(teeth=(25, 35), external=True)),
        )
        direct = rig.add("direct", gb.IdealGear(teeth=(10, z), external=False))
        rig.chain(motor, one, shaft, two, wheel)
        rig.connect(direct.a, motor.a)
        rig.connect(direct.b, wheel.a)
        return rig

    gb.build(layshaft(21))  # 30/20 35/25 = 21/10
    with pytest.raises(gb.ModelError, match="contradict"):
        gb.build(layshaft(20))


def test_ground_holds_a_gear_and_takes_its_torque():
    rig = gb.Drivetrain("held")
    body, ground = rig.add("body", gb.Inertia(J=1.0, w0=2.0)), rig.add("ground", gb.Fixed())
    spring, gear = rig.add("spring", gb.Shaft(k=100.0)), rig.add("gear", gb.IdealGear(ratio=4.0))
    rig.chain(body, spring, gear, ground)
    t = np.linspace(0, 1, 51)
    run = gb.simulate(rig, t=t, rtol=1e-12)
    assert np.allclose(run["body.phi"], 0.2 * np.sin(10 * t), atol=1e-10)
    # body and spring turn flange a of the gear by 100 phi; the ground holds ratio times as much on b
    assert np.allclose(run["gear.a.tau"], -100.0 * run["body.phi"], atol=1e-9)
    assert np.allclose(run["ground.torque"], 4 * -100.0 * run["body.phi"] * -1 * -1, atol=1e-8)


def test_start_values_pass_through_ties():
    rig = _train(gb.IdealGear(teeth=(10, 30), external=True), tau=0.0, load=0.0).set(
        {"wheel.w0": 5.0, "wheel.phi0": 0.25}
    )
    run = gb.simulate(rig, t=[0.0], rtol=1e-6)
    assert run["motor.w"][0] == pytest.approx(-15.0, rel=1e-15)
    assert run["motor.phi"][0] == pytest.approx(-0.75, rel=1e-15)
    other = gb.simulate(rig, t=[0.0], rtol=1e-6, initial={"motor.w": 9.0})
    assert other["wheel.w"][0] == pytest.approx(-3.0, rel=1e-15)


def test_start_values_that_contradict_through_ties_are_refused_naming_both():
    rig = _train(gb.IdealGear(ratio=2.25)).set({"motor.w0": 4.0, "wheel.w0": 3.0})
    with pytest.raises(gb.ModelError, match=r"(?s)motor.*wheel"):
        gb.build(rig)
    with pytest.raises(gb.ParameterError, match=r"(?s)motor.*wheel"):
        gb.simulate(_train(gb.IdealGear(ratio=2.25)), t=[0.0], initial={"motor.w": 4.0, "wheel.w": 3.0})


@pytest.mark.long
def test_contradicting_start_values_are_refused_after_agreeing_ones_were_built():
    rig = _train(gb.IdealGear(ratio=2.0)).set({"motor.w0": 4.0, "wheel.w0": 2.0})
    gb.build(rig)
    with pytest.raises(gb.ModelError, match=r"(?s)motor.*wheel"):
        gb.build(rig.set({"wheel.w0": 3.0}))


def test_torques_at_every_shaft_balance_and_so_does_power():
    rig = gb.Drivetrain("balance")
    motor, first = rig.add("motor", gb.Inertia(J=0.02)), rig.add("gear", gb.IdealGear(teeth=(20, 50), external=True))
    lay, shaft = rig.add("lay", gb.Inertia(J=0.01)), rig.add("shaft", gb.Shaft(k=2e4, c=3.0))
    pinion, wheel = rig.add("pinion", gb.Inertia(J=0.003)), rig.add("wheel", gb.Inertia(J=0.2))
    mesh = rig.add(
        "mesh", gb.GearMesh(teeth=(17, 59), r_base=(0.017, 0.059), external=False, k=1e8, damping_ratio=0.05)
    )
    drive, load = (
        rig.add("drive", gb.Torque(tau=20 + 5 * gb.sin(200 * gb.time))),
        rig.add("load", gb.SpeedLoad(coeffs=(0.0, 1.0, 0.1))),
    )
    rig.chain(drive, motor, first, lay, shaft, pinion, mesh, wheel, load)
    run = gb.simulate(rig, t=np.linspace(0, 0.1, 101), rtol=1e-9, initial={"motor.w": 50.0})
    shafts = (
        ("drive.flange", "motor.a"), ("motor.b", "gear.a"), ("gear.b", "lay.a"), ("lay.b", "shaft.a"),
        ("shaft.b", "pinion.a"), ("pinion.b", "mesh.pinion"), ("mesh.wheel", "wheel.a"), ("wheel.b", "load.flange"),
    )  # fmt: skip
    for node in shafts:
        torque = sum(run[f"{f}.tau"] for f in node)
        power = sum(run[f"{f}.power"] for f in node)
        largest = max(np.abs(run[f"{f}.tau"]).max() for f in node)
        assert np.abs(torque).max() <= 1e-11 * largest, node
        assert np.abs(power).max() <= 1e-11 * max(np.abs(run[f"{f}.power"]).max() for f in node), node
    for flange in (f for node in shafts for f in node):
        assert np.allclose(run[f"{flange}.power"], run[f"{flange}.tau"] * run[f"{flange}.w"], rtol=1e-12)
    # an inertia passes on what it does not need itself
    assert np.allclose(run["motor.a.tau"] + run["motor.b.tau"], -0.02 * run["motor.alpha"], rtol=1e-9, atol=1e-9)

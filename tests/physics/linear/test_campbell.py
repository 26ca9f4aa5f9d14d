"""Campbell diagrams: orders of the teeth, frequencies over speed, pictures."""

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


# -- speeds and orders ------------------------------------------------------------------------------------------------


def _geared_pair():
    rig = gb.Drivetrain("spur pair")
    motor, wheel = rig.add("motor", gb.Inertia(J=0.02)), rig.add("wheel", gb.Inertia(J=0.05))
    pinion = rig.add("pinion", gb.Inertia(J=2e-4))
    mesh = rig.add("mesh", gb.GearMesh(teeth=(23, 41), r_base=(0.023, 0.041), external=True, k=2e8, damping_ratio=0.05))
    rig.chain(motor, rig.add("shaft", gb.Shaft(k=2e4, c=3.0)), pinion, mesh, wheel)
    return rig


def test_orders_follow_from_the_teeth_and_cross_where_they_should():
    rig = _geared_pair()
    speeds = gb.rpm(np.linspace(10, 30000, 11))
    found = gb.campbell(rig, "motor.w", speeds)
    assert found.orders == pytest.approx({
        "shaft of motor, pinion": 1.0, "shaft of wheel": 23 / 41, "teeth of mesh": 23.0
    }, rel=1e-8)  # fmt: skip
    swinging = gb.modes(rig).frequencies[1:]
    assert found.frequencies == pytest.approx(np.tile(swinging, (11, 1)), rel=1e-6)
    mesh = [c for c in found.crossings if c.order == "teeth of mesh"]
    assert [c.speed for c in mesh] == pytest.approx(swinging / 23, rel=1e-6)
    assert [c.mode for c in mesh] == [1, 2]
    assert gb.campbell(rig, "motor.w", speeds[:2], reference="wheel").orders["teeth of mesh"] == pytest.approx(41.0)


def test_frequencies_that_depend_on_a_speed_are_followed():
    speed = gb.Parameter("speed", 1.0, "rad/s")
    rig = gb.Drivetrain("stiffened")
    body = rig.add("body", gb.Inertia(J=1.0))
    rig.chain(body, rig.add("shaft", gb.Shaft(k=100.0 + speed**2)), rig.add("ground", gb.Fixed()))
    speeds = np.linspace(1.0, 20.0, 39)
    found = gb.campbell(rig, "speed", speeds, orders={"unbalance": 2.0})
    assert found.frequencies[:, 0] == pytest.approx(np.sqrt(100 + speeds**2), rel=1e-8)
    (crossing,) = found.crossings
    assert crossing.speed == pytest.approx(10 / np.sqrt(3), rel=1e-3)  # straight lines between speeds 0.5 rad/s apart
    with pytest.raises(gb.ParameterError, match="no speed of 'speed' turns the train"):
        gb.campbell(rig, "speed", speeds)


def _driven(given, *, external=True, turned=False):
    """A gear pair of 23 and 41 teeth behind a shaft, its drive or its load end turned at a given speed."""
    rig = gb.Drivetrain("driven pair")
    drive, shaft = rig.add("drive", gb.Speed(w=given)), rig.add("shaft", gb.Shaft(k=2e4, c=3.0))
    pair = gb.GearMesh(teeth=(23, 41), r_base=(0.023, 0.041), external=external, k=2e8, damping_ratio=0.05)
    pinion, mesh, wheel = (
        rig.add("pinion", gb.Inertia(J=2e-4)),
        rig.add("mesh", pair),
        rig.add("wheel", gb.Inertia(J=0.05)),
    )
    body = rig.add("body", gb.Inertia(J=0.1))
    row = (pinion, mesh, wheel)
    if turned:
        rig.connect(drive.flange, shaft.a)
        rig.connect(shaft.b, wheel.a)
        rig.connect(wheel.b, mesh.wheel)
        rig.connect(mesh.pinion, pinion.a)
        rig.connect(pinion.b, rig.add("end", gb.Shaft(k=1e4, c=1.0)).a)
        rig.connect(rig["end"].b, body.a)
    else:
        rig.chain(drive, shaft, *row, rig.add("end", gb.Shaft(k=1e4, c=1.0)), body)
    return rig


@pytest.mark.parametrize("external", [True, False])
@pytest.mark.parametrize(("turned", "teeth"), [(False, 23.0), (True, 41.0)])
@pytest.mark.parametrize("per_turn", [1.0, 23.0])
def test_a_parameter_that_drives_has_the_orders_of_the_teeth(external, turned, teeth, per_turn):
    frequency = gb.Parameter("n", 100.0, "rpm")  # of the shaft, or of its teeth
    rig = _driven(frequency / per_turn, external=external, turned=turned)
    found = gb.campbell(rig, "n", ["100 rpm", "3000 rpm", "90000 rpm"])
    shares = {"pinion, body": 41 / 23, "wheel": 1.0} if turned else {"pinion": 1.0, "wheel, body": 23 / 41}
    wanted = {f"shaft of {name}": share / per_turn for name, share in shares.items()} | {
        "teeth of mesh": teeth / per_turn
    }
    assert found.orders == pytest.approx(wanted, rel=1e-8)
    assert [c.frequency / c.speed for c in found.crossings if c.order == "teeth of mesh"] == pytest.approx(
        [teeth / per_turn] * sum(c.order == "teeth of mesh" for c in found.crossings), rel=1e-8
    ) and any(c.order == "teeth of mesh" for c in found.crossings)


def test_a_speed_that_is_not_in_proportion_to_its_parameter_has_no_orders():
    n = gb.Parameter("n", 100.0, "rpm")
    for given in (n + 5.0, n**2, 30.0 + 0.0 * n):
        with pytest.raises(gb.ParameterError, match=r"orders: no speed of 'n' turns the train .* give orders="):
            gb.campbell(_driven(given), "n", ["100 rpm", "3000 rpm"])


# -- pictures ---------------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_every_tool_draws_a_picture(tmp_path):
    rig = _geared_pair()
    with_input = rig.set({})
    gb.modes(with_input).plot(tmp_path / "modes.png")
    gb.campbell(rig, "motor.w", gb.rpm(np.linspace(10, 3000, 5))).plot(tmp_path / "campbell.svg")
    gb.frequency_response(_mass(), "tau", "shaft.*", [1.0, 10.0, 100.0]).plot(tmp_path / "bode.pdf")
    assert sorted(p.suffix for p in tmp_path.iterdir()) == [".pdf", ".png", ".svg"]


@pytest.mark.parametrize(("held", "driven", "order"), [
    ("ring", "sun", 42 * 78 / (42 + 78)), ("sun", "ring", 42 * 78 / (42 + 78)), ("carrier", "sun", 42.0),
])  # fmt: skip
@pytest.mark.parametrize("nested", [False, True], ids=["whole", "nested"])
@pytest.mark.few(1)
def test_a_planetary_set_has_the_order_of_the_teeth_that_pass_its_carrier(held, driven, order, nested):
    rig, mesh = gb.Drivetrain("set"), gb.MeshLaw(k=3e8, c=500.0)
    gear = gb.PlanetaryGear(
        z_sun=42, z_planet=18, z_ring=78, module="2 mm", pressure_angle="20 deg", planet_inertia=1e-4, sun_mesh=mesh,
        ring_mesh=mesh,
    )  # fmt: skip
    flanges = ("sun", "ring", "carrier")
    if nested:
        inner = gb.Drivetrain("stage")
        whole = inner.add("gear", gear)
        for flange in flanges:
            inner.expose(flange, getattr(whole, flange))
        gear = inner
    stage = rig.add("stage", gear)
    for flange in flanges:
        end = rig.add("case", gb.Fixed()).flange if flange == held else rig.add(flange, gb.Inertia(J=0.01)).a
        rig.connect(getattr(stage, flange), end)
    found = gb.campbell(rig, f"{driven}.w", np.linspace(10.0, 2000.0, 5))
    (name,) = (x for x in found.orders if x.startswith("teeth"))
    assert name == ("teeth of stage.gear" if nested else "teeth of stage")
    assert found.orders[name] == pytest.approx(order, rel=1e-9)
    assert any(c.order == name for c in found.crossings)


def _loaded_by_its_speed(unit: str) -> gb.Drivetrain:
    """A load of 2 N m s/rad twists a shaft of 1e4 N m/rad up to 100 N m, stiffer beyond; its speed is a Parameter."""
    rig = gb.Drivetrain("loaded by its speed")
    one = {"rad/s": gb.rpm(1000.0), "rpm": 1000.0, "rev/s": 1000.0 / 60.0}[unit]
    table = gb.Table([-1.0, -0.01, 0.0, 0.01, 1.0], [-30000.0, -100.0, 0.0, 100.0, 30000.0])
    drive, shaft = (
        rig.add("drive", gb.Speed(w=gb.Parameter("n", one, unit))),
        rig.add("shaft", gb.Shaft(torque=table, c=1.0)),
    )
    load = rig.add("load", gb.Torque(tau=-2.0 * gb.sense("body.w")))
    rig.chain(drive, shaft, rig.add("body", gb.Inertia(J=1.0)), load)
    return rig


@pytest.mark.parametrize("unit", ["rad/s", "rpm", "rev/s"])
def test_speeds_of_a_parameter_are_in_radians_whatever_its_unit_is(unit):
    rig, wanted = _loaded_by_its_speed(unit), [100.0, np.sqrt(29900.0 / 0.99)]
    for speeds in ([gb.rpm(200.0), gb.rpm(2000.0)], ["200 rpm", "2000 rpm"]):
        diagram = gb.campbell(rig, "n", speeds, orders={"one": 1.0})
        assert diagram.speeds == pytest.approx([gb.rpm(200.0), gb.rpm(2000.0)])
        assert diagram.frequencies[:, 0] == pytest.approx(wanted, rel=1e-9)

"""Effects taken away one by one: what is left is the plainer element of the field, without a trace of what went."""

import numpy as np
import pytest

import gearblocks as gb

W = 50.0


def _coasting(**fields):
    rig = gb.Drivetrain("coasting")
    rotor = rig.add("rotor", gb.Inertia(J=0.05, w0=W))
    rig.chain(rotor, rig.add("bearing", gb.BearingFriction(**fields)))
    return rig


def _names(model):
    program = model.program
    states = [s.name for s in program.states]
    return states + [p.path for p in program.parameters] + [s.component for s in program.switches]


def test_a_bearing_without_its_coulomb_part_is_a_viscous_drag():
    full = _coasting(coulomb=0.2, viscous=1e-2, stribeck=gb.Stribeck(rise=0.1, speed=2.0), peak=1.5)
    drag = full.without("bearing.coulomb")
    assert drag.dropped == ("bearing.coulomb", "bearing.stribeck")
    model = gb.build(drag)
    assert model.program.switches == ()
    assert [n for n in _names(model) if n.startswith("bearing")] == ["bearing.viscous"]
    run = gb.simulate(model, t=[0.0, 3.0], rtol=1e-10)
    assert run["rotor.w"][1] == pytest.approx(W * np.exp(-1e-2 / 0.05 * 3.0), rel=1e-9)
    assert run.energy.dissipated["bearing"] == pytest.approx(0.05 / 2 * (W**2 - run["rotor.w"][1] ** 2), rel=1e-9)


def test_a_bearing_without_all_of_its_friction_leaves_no_trace():
    for fields in ({"coulomb": 0.2, "viscous": 1e-2}, {"torque": gb.Table([0.0, 100.0], [0.1, 0.3])}):
        bare = _coasting(**fields).without("bearing.*")
        model = gb.build(bare)
        assert not any("bearing" in name for name in _names(model))
        assert "bearing" not in model.program.source
        assert "bearing" not in str(bare.equations())
        assert gb.simulate(model, t=[0.0, 5.0])["rotor.w"][1] == W


@pytest.mark.long
def test_the_drag_of_a_fluid_slows_down_by_the_square_of_the_speed():
    c = 3e-3
    rig = _coasting(windage=gb.FluidDrag(c=c / 3), churning=gb.FluidDrag(c=2 * c / 3))
    run = gb.simulate(rig, t=[0.0, 2.0], rtol=1e-10)
    assert run["rotor.w"][1] == pytest.approx(W / (1 + c / 0.05 * W * 2.0), rel=1e-9)
    assert run["bearing.torque"][1] == pytest.approx(c * run["rotor.w"][1] ** 2, rel=1e-12)
    sticking = _coasting(coulomb=0.5, windage=gb.FluidDrag(c=c))
    stopped = gb.simulate(sticking, t_end=20.0, rtol=1e-9)
    # w' = -(T + c w^2)/J: at rest after J/sqrt(T c) atan(W sqrt(c/T))
    at_rest = 0.05 / np.sqrt(0.5 * c) * np.arctan(W * np.sqrt(c / 0.5))
    assert stopped.events[-1].t == pytest.approx(at_rest, rel=1e-7)
    assert sticking.without("bearing.windage").effects().keys() == {"bearing.coulomb"}


def test_a_bearing_keeps_its_coulomb_part_where_its_rise_near_rest_is_asked_for():
    rig = _coasting(coulomb=0.2, viscous=1e-2, stribeck=gb.Stribeck(rise=0.1, speed=2.0))
    assert set(rig.only("bearing.stribeck").effects()) == {"bearing.coulomb", "bearing.stribeck"}


@pytest.mark.long
def test_a_converter_without_slip_is_locked_up():
    rig = gb.Drivetrain("start on a converter")
    converter = gb.TorqueConverter(
        capacity=gb.Table([0.0, 0.9, 1.0], [2e-3, 1.5e-3, 0.0]), ratio=gb.Table([0.0, 0.9], [2.0, 1.0])
    )
    engine, axle = rig.add("engine", gb.Inertia(J=0.2, w0=100.0)), rig.add("axle", gb.Inertia(J=1.8, w0=0.0))
    rig.chain(rig.add("drive", gb.Torque(tau=60.0)), engine, rig.add("converter", converter), axle)
    locked = rig.without("converter.slip")
    assert locked.dropped == ("converter.slip", "axle.w0")
    start = gb.carried_start(rig, locked)
    run = gb.simulate(locked, t=[0.0, 1.0], initial=start)
    assert run["axle.w"] == pytest.approx([10.0, 40.0], rel=1e-12)  # 20 N m s on 2 kg m2, then 60 N m
    assert run["converter.torque"][1] == pytest.approx(1.8 * 30.0, rel=1e-12)
    assert len(gb.build(locked).program.switches) == 0 < len(gb.build(rig).program.switches)
    with pytest.raises(gb.ModelError, match="ratio = None"):
        rig.set({"converter": converter.changed(ratio=None)})


def test_a_worm_without_losses_is_an_ideal_gear():
    rig = gb.Drivetrain("lift")
    worm = gb.Worm(ratio=40, lead_angle="4 deg", friction=0.1)
    motor, lift = rig.add("motor", gb.Inertia(J=1e-3)), rig.add("lift", gb.Inertia(J=0.4))
    rig.chain(rig.add("drive", gb.Torque(tau=2.0)), motor, rig.add("worm", worm), lift)
    free = rig.without("worm.loss")
    run = gb.simulate(free, t=[0.0, 1.0])
    assert run["motor.w"][1] == pytest.approx(2.0 / (1e-3 + 0.4 / 1600), rel=1e-12)
    assert gb.build(free).program.switches == ()


@pytest.mark.long
def test_a_vehicle_loses_tyre_slip_drag_and_rolling_resistance_one_by_one():
    tyre = gb.TyreSlip(stiffness=1e5, grip=1.0, low_speed=0.5)
    car = gb.Vehicle(mass=1000.0, wheel_radius=0.3, drag_area=0.6, rolling=0.01, rolling_speed=0.1, tyre=tyre)
    rig = gb.Drivetrain("car")
    wheels = rig.add("wheels", gb.Inertia(J=2.0, w0=20.0))
    rig.chain(rig.add("drive", gb.Torque(tau=300.0)), wheels, rig.add("car", car))
    assert set(rig.effects()) == {"car.tyre", "car.drag", "car.rolling"}
    bare = rig.without("*")
    assert bare.effects() == {}
    run = gb.simulate(bare, t=[0.0, 1.0], initial=gb.carried_start(rig, bare, initial={"car.v": 5.0}))
    # the wheels at 20 rad/s and the car at 5 m/s become one: (2*20 + 1000*0.3*5)/(2 + 90) rad/s
    assert run["wheels.w"][0] == pytest.approx(1540 / 92, rel=1e-12)
    assert run["wheels.alpha"][1] == pytest.approx(300 / 92, rel=1e-12)


@pytest.mark.long
def test_a_shaft_without_segments_is_one_spring_between_two_halves_of_its_inertia():
    rig = gb.Drivetrain("long shaft")
    ends = [rig.add(n, gb.Inertia(J=0.1, phi0=p, w0=0.0)) for n, p in (("left", 0.01), ("right", 0.0))]
    rig.chain(ends[0], rig.add("shaft", gb.Shaft(k=1e3, c=0.0, segments=8, J=0.04)), ends[1])
    one = rig.without("shaft.segments")
    assert one.dropped == ("shaft.segments",)
    found = gb.modes(one).frequencies
    # the lumps of both ends turn with the discs: k/J_e with J_e of two times 0.12 kg m2
    assert found[-1] == pytest.approx(np.sqrt(1e3 * 2 / 0.12), rel=1e-9)
    rigid = rig.without("shaft.*")
    assert gb.simulate(rigid.set({"left.w0": None}), t=[0.0], initial={"left.w": 2.0})["left.w"][0] == 2.0
    energy = gb.simulate(rigid, t=[0.0, 1.0], initial={"left.w": 2.0}).energy
    assert energy.end == pytest.approx(0.24 / 2 * 4.0, rel=1e-12)  # all of J turns


def _small_pinion(small):
    rig = gb.Drivetrain("small pinion")
    mesh = gb.GearMesh(teeth=(20, 60), r_base=(0.02, 0.06), external=True, k=2e8, damping_ratio=0.02)
    motor, pinion = (
        rig.add("motor", gb.Inertia(J=0.1, w0=30.0)),
        rig.add("pinion", gb.Inertia(J=1e-4, w0=30.0, small=small)),
    )
    wheel, shaft = rig.add("wheel", gb.Inertia(J=0.2, w0=-10.0)), rig.add("shaft", gb.Shaft(k=500.0))
    rig.chain(rig.add("drive", gb.Torque(tau=5.0)), motor, shaft, pinion, rig.add("mesh", mesh), wheel)
    return rig


@pytest.mark.long
def test_the_inertia_of_a_small_part_is_lumped_into_its_neighbour_times_the_ratio_squared():
    rig = _small_pinion(small=True)
    assert "pinion.inertia" in rig.effects()
    lean = rig.without("pinion.inertia")
    # k r^2 = 8e4 N m/rad of the mesh about the pinion is above the 500 N m/rad of the shaft
    assert set(lean.dropped) >= {"pinion.inertia", "mesh.compliance", "mesh.damping"}
    assert "shaft.compliance" in lean.effects()
    found = gb.modes(lean).frequencies[-1]
    J = 0.2 / 9 + 1e-4
    assert found == pytest.approx(np.sqrt(500.0 * (1 / 0.1 + 1 / J)), rel=1e-9)
    start = gb.simulate(lean, t=[0.0], initial=gb.carried_start(rig, lean))
    assert start["wheel.w"][0] == pytest.approx(-10.0, rel=1e-12)


def test_only_never_strips_ordinary_inertias_and_leaves_a_small_one_what_it_needs():
    assert _small_pinion(small=False).only("mesh.compliance").dropped == (
        "shaft.compliance", "mesh.damping", "pinion.w0",
    )  # fmt: skip
    kept = _small_pinion(small=True).only("mesh.compliance")
    assert "mesh.compliance" in kept.effects()
    assert "pinion.inertia" not in kept.effects()  # on the rigid shaft it is the motor's


def test_a_small_part_that_nothing_compliant_holds_stays():
    rig = gb.Drivetrain("plate")
    plate = rig.add("plate", gb.Inertia(J=1e-3, small=True))
    rig.chain(rig.add("motor", gb.Inertia(J=1.0)), rig.add("clutch", gb.Clutch(capacity=5.0)), plate)
    assert rig.without("*").dropped == ()


class Ring(gb.Effect):
    """Drag of a seal ring."""

    torque: float = gb.param("drag of the ring", "N m s/rad", ge=0)


class Coupling(gb.Block):
    """A user's coupling: rubber between two hubs, a rigid sleeve without it."""

    a, b = gb.Flange("left hub"), gb.Flange("right hub")
    rubber: float | None = gb.param("stiffness of the rubber", "N m/rad", default=None, gt=0, belongs_to="rubber")
    seal: Ring | None = gb.effect("seal ring", default=None)

    def physics(self, s):
        twist = s.b.phi - s.a.phi
        if self.rubber is None:
            yield gb.Tie(twist)
        else:
            yield gb.Force(twist, s.rubber * twist)
            yield gb.Energy(stored=s.rubber * twist**2 / 2)
            yield gb.Shows("twist", twist, "rad")
        if self.seal is not None:
            yield gb.Acts(s.a, -s.seal.torque * s.a.w)
            yield gb.Energy(loss=s.seal.torque * s.a.w**2)


def test_a_users_block_has_the_same_rights():
    rig = gb.Drivetrain("own coupling")
    ends = [rig.add(n, gb.Inertia(J=J, w0=w)) for n, J, w in (("left", 1.0, 4.0), ("right", 3.0, 0.0))]
    rig.chain(ends[0], rig.add("coupling", Coupling(rubber=50.0, seal=Ring(torque=0.1))), ends[1])
    assert set(rig.effects()) == {"coupling.rubber", "coupling.seal"}
    rigid = rig.without("coupling.rubber")
    assert rigid.dropped == ("coupling.rubber", "right.w0")
    start = gb.simulate(rigid, t=[0.0], initial=gb.carried_start(rig, rigid))
    assert start["right.w"][0] == pytest.approx(1.0, rel=1e-14)
    assert "rubber" not in gb.build(rigid).program.source
    with pytest.raises(gb.UnknownNameError, match="twist"):
        gb.simulate(rigid, t_end=0.1, outputs="coupling.twist")

"""The heat of every element with losses is what it loses; Modelica's HeatLosses."""

import pytest

import gearblocks as gb

pytestmark = pytest.mark.filterwarnings("ignore:.*is left first")  # tables that are held on purpose

_MESH = {"teeth": (20, 33), "module": 0.1, "pressure_angle": 0.35, "external": True, "k": 300.0, "c": 1.0}
ELEMENTS = {
    "Shaft": gb.Shaft(k=200.0, c=0.5),
    "Shaft of segments": gb.Shaft(k=200.0, J=0.2, segments=3, c=0.05),
    "Shaft with inner friction": gb.Shaft(k=20.0, hysteresis=gb.Hysteresis(friction=0.2, stiffness=300.0)),
    "Damper": gb.Damper(c=0.5),
    "Lash": gb.Lash(k=300.0, half_gap=0.02, c=1.0),
    "Lash that hits": gb.Lash(k=1.0, half_gap=0.1, contact_damping=gb.HuntCrossley(restitution=0.5)).changed(k=None),
    "HardStop": gb.HardStop(lower=-0.1, upper=0.1, restitution=0.5),
    "GearMesh": gb.GearMesh(**_MESH, backlash=gb.Backlash(half_gap=0.005)),
    "GearMesh with friction": gb.GearMesh(**_MESH, friction=gb.ToothFriction(mu=0.05)),
    "SplineCoupling": gb.SplineCoupling(teeth=12, radius=1.5, k=300.0, c=2.0),
    "NonCircularGear": gb.NonCircularGear(law=gb.RatioLaw.ellipse(0.2), external=False, k=300.0, c=1.0),
    "Clutch": gb.Clutch(capacity=1.0),
    "Brake": gb.Brake(mu=gb.Table([0, 2], [0.5, 0.4]), force_max=2.0, engagement=1.0),
    "BearingFriction": gb.BearingFriction(coulomb=0.5, viscous=0.2, stribeck=gb.Stribeck(rise=0.1, speed=0.5)),
    "BearingFriction that drags": gb.BearingFriction(viscous=0.2, windage=gb.FluidDrag(c=0.1)),
    "OneWayClutch": gb.OneWayClutch(capacity=1.0),
    "DogClutch": gb.DogClutch(engaged=gb.time - 0.5),
    "Synchronizer": gb.Synchronizer(capacity=0.5, engaged=1.0),
    "LossyGear": gb.LossyGear(ratio=2, loss_table=((0.0, 0.9, 0.8, 0.1, 0.1), (10.0, 0.8, 0.7, 0.2, 0.2))),
    "Worm": gb.Worm(ratio=5, lead_angle=0.4, friction=0.05),
    "SpeedLoad": gb.SpeedLoad(coeffs=(0.1, 0.2, 0.3)),
    "EddyCurrentBrake": gb.EddyCurrentBrake(tau_nominal=3.0, w_nominal=20.0),
    "DCMotor": gb.DCMotor(R=0.5, L=1e-2, k=0.1, u=5.0),
    "TorqueConverter": gb.TorqueConverter(
        capacity=gb.Table([0, 0.9, 1], [0.2, 0.15, 0.0]), ratio=gb.Table([0, 0.9], [2.0, 1.0])
    ),
    "BeltDrive": gb.BeltDrive(ratio=1.2, slip=gb.Creep(stiffness=50.0, low_speed=0.5, limit=5.0)),
    "Vehicle": gb.Vehicle(mass=1.0, wheel_radius=1.0, drag_area=0.5, rolling=0.02),
    "Vehicle on tyres": gb.Vehicle(
        mass=1.0, wheel_radius=1.0, tyre=gb.TyreSlip(stiffness=10.0, grip=0.9, low_speed=0.5)
    ),
}


@pytest.mark.parametrize("name", [n if n == "Lash" else pytest.param(n, marks=pytest.mark.long) for n in ELEMENTS])
def test_the_heat_of_an_element_is_what_it_loses_and_leaves_its_motion_as_it_was(name):
    def around(block):
        rig = gb.Drivetrain("around")
        drive, one = rig.add("drive", gb.Torque(tau=3.0)), rig.add("one", gb.Inertia(J=1.0, w0=None))
        rig.chain(drive, one, rig.add("part", block))
        if len([f for f in type(block).flanges.values() if not f.ground or f.spare]) == 2:
            two = rig.add("two", gb.Inertia(J=2.0, w0=2.0 if name == "OneWayClutch" else None))
            rig.chain(rig["part"], two)
            rig.connect(two.b, rig.add("load", gb.Damper(c=0.5)).a)
            rig.connect(rig["load"].b, rig.add("wall", gb.Fixed()).flange)
        rig.add("mass", gb.ThermalMass(C=10.0))
        return rig

    plain = gb.simulate(around(ELEMENTS[name]), t_end=1.0, rtol=1e-9)
    run = gb.simulate(around(ELEMENTS[name].changed(heat=gb.HeatPort(T="mass"))), t_end=1.0, rtol=1e-9)
    lost = sum(heat for path, heat in run.energy.dissipated.items() if path.split(".")[0] == "part")
    assert lost > 1e-6
    assert sum(run.energy.heat.values()) == pytest.approx(lost, rel=1e-8)
    assert run["mass.T"][-1] - 293.15 == pytest.approx(lost / 10.0, rel=1e-7)
    assert run["one.w"][-1] == pytest.approx(plain["one.w"][-1], abs=1e-7)


@pytest.mark.long
def test_heat_losses_of_modelica_leave_through_the_convection():
    # Modelica.Mechanics.Rotational.Examples.HeatLosses, with an inertia between gear and clutch and a mass at the convection
    def port():
        return gb.HeatPort(T="node")

    rig, engagement = gb.Drivetrain("HeatLosses"), gb.sin(2 * gb.pi * 0.2 * gb.time)
    one, two, three, four, five, six = (rig.add(f"inertia{i}", gb.Inertia(J=2.0)) for i in range(1, 7))
    rig.chain(
        rig.add("torque", gb.Torque(tau=20 * gb.sin(2 * gb.pi * 5 * gb.time))), one,
        rig.add("springDamper", gb.Shaft(k=1e4, c=20.0, heat=port())), two,
        rig.add("elastoBacklash", gb.Lash(k=1e5, c=100.0, half_gap=0.0005, heat=port())), three,
        rig.add("spring3", gb.Shaft(k=1e4)), four,
        rig.add("lossyGear", gb.LossyGear(ratio=2, loss_table=((0, 0.8, 0.8, 1, 1), (1, 0.7, 0.7, 2, 2)), heat=port())),
        rig.add("between", gb.Inertia(J=0.05)),
        rig.add("clutch", gb.Clutch(mu=0.5, force_max=10.0, engagement=engagement, heat=port())), five,
        rig.add("oneWayClutch", gb.OneWayClutch(mu=0.5, force_max=1.0, engagement=engagement, heat=port())), six,
        rig.add("brake", gb.Brake(mu=0.5, force_max=2.0, engagement=engagement, heat=port())),
    )  # fmt: skip
    rig.chain(one, rig.add("damper", gb.Damper(c=10.0, heat=port())), rig.add("fixed", gb.Fixed()))
    friction = gb.BearingFriction(torque=gb.Table([0, 1], [0, 1]), heat=port())
    rig.connect(three.b, rig.add("bearingFriction", friction).a)
    rig.add("node", gb.ThermalMass(C=1.0, T0=298.15))
    rig.add("convection", gb.ThermalConductance(G=20.0, a="node", b=298.15))
    run = gb.simulate(rig, t_end=1.0, rtol=1e-8)
    assert len(run.energy.heat) == 8 and min(run.energy.heat.values()) > 1e-3
    assert run.energy.heat_residual < 1e-8 and run.energy.residual < 1e-7
    assert run.stats.steps < 1000


def _with_hot_gear(*behind: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain("hot gear")
    one, other = rig.add("one", gb.Inertia(J=0.3, w0=20.0)), rig.add("other", gb.Inertia(J=0.5))
    rig.add("oil", gb.ThermalMass(C=50.0, T0=300.0))
    gear = gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.8), bearing=(0.5, 0.5), heat=gb.HeatPort(T="oil"))
    drive = rig.add("drive", gb.Torque(tau=5 * gb.sin(3 * gb.time)))
    rig.chain(drive, one, rig.add("gear", gear), *(rig.add("shaft", x) for x in behind), other)
    return rig


@pytest.mark.parametrize("behind", [(), (gb.Shaft(k=500.0, c=2.0),)], ids=["rigid", "shaft"])
def test_a_lossy_gear_that_heats_a_mass_does_so_in_implicit_steps_too(behind):
    """Its heat follows from the force of the tie, and where that is an unknown from the balance of a shaft."""
    explicit, implicit = (
        gb.simulate(_with_hot_gear(*behind), t_end=2.0, rtol=1e-8, method=m) for m in ("dp8", "rodas")
    )
    assert implicit["oil.T"][-1] == pytest.approx(explicit["oil.T"][-1], rel=1e-9)
    assert implicit.energy.heat_residual < 1e-9

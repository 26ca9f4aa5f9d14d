"""Static starts on corners: at the entry of a pair of teeth, beside stops and gaps, on the joints of a table."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.geometry.involute import ToothPair

A, M, Z, J, W = np.deg2rad(20), 3e-3, (23, 41), (2e-4, 5e-3), 100.0
PAIR = ToothPair(*Z, M, A)
R = M * Z[0] * np.cos(A) / 2, M * Z[1] * np.cos(A) / 2


def _levers(mu, sense=1.0):
    """Lever arms of mesh force and friction on pinion and wheel where a pair has just come into contact; sense: sign of the
    mesh force."""
    r = list(R)
    for j in (0, 1):
        xi = -PAIR.path[0] + PAIR.base_pitch * j
        arms = PAIR.lever_arms[0] + xi, PAIR.lever_arms[1] - xi
        slip = arms[0] * W - arms[1] * W * Z[0] / Z[1]
        r = [x + sense * mu / 2 * np.sign(slip) * arm for x, arm in zip(r, arms, strict=True)]
    return r


def _start(rig):
    return gb.simulate(rig, t_end=1e-6, initial="static")


@pytest.mark.long
@pytest.mark.parametrize(
    ("backlash", "transition", "near"),
    [
        pytest.param(None, None, 1e-9, id="exact"),
        pytest.param(gb.Backlash(half_gap=5e-5), 1e-3, 1e-5, id="smooth", marks=pytest.mark.long),
    ],
)
def test_the_mesh_force_at_the_entry_of_a_pair_does_not_depend_on_rounding(backlash, transition, near):
    rig = gb.Drivetrain("pair")
    law = {"k": 1e8, "c": 2e3, "backlash": backlash, "friction": gb.ToothFriction(mu=0.1, transition=transition)}
    pinion, wheel = (
        rig.add("pinion", gb.Inertia(J=J[0], w0=W)),
        rig.add("wheel", gb.Inertia(J=J[1], w0=-W * Z[0] / Z[1])),
    )
    mesh = rig.add("mesh", gb.GearMesh(teeth=Z, module=M, pressure_angle=A, external=True, **law))
    rig.chain(rig.add("drive", gb.Torque(tau=20.0)), pinion, mesh, wheel)
    rig.connect(rig.add("load", gb.Torque(tau=0.0)).flange, wheel.b)
    model = gb.build(rig)
    for mu in (0.02, 0.1, 0.3):
        for load in (20.0, -20.0):
            lever = _levers(mu, np.sign(load))
            # r1 a1 + r2 a2 = 0: both sides turn on together
            pushed = R[0] * load / J[0] + R[1] * load * Z[1] / Z[0] / J[1]
            wanted = pushed / (R[0] * lever[0] / J[0] + R[1] * lever[1] / J[1])
            for k in np.geomspace(1e6, 1e10, 9):
                values = {"mesh.k": k, "mesh.friction.mu": mu, "drive.tau": load, "load.tau": load * Z[1] / Z[0]}
                run = gb.simulate(model, t_end=1e-6, initial="static", parameters=values)
                # a smooth law is slip / sqrt(slip^2 + 1e-6) of the exact one
                assert run["mesh.force"][0] == pytest.approx(wanted, rel=near)


@pytest.mark.long
@pytest.mark.parametrize(
    "shaft", [pytest.param(True, id="rigid"), pytest.param(False, id="compliant", marks=pytest.mark.long)]
)
def test_a_pair_behind_a_rigid_shaft_starts_at_the_entry_of_a_pair(shaft):
    rig = gb.Drivetrain("whine")
    pinion, wheel = (
        rig.add("pinion", gb.Inertia(J=J[0], w0=W)),
        rig.add("wheel", gb.Inertia(J=J[1], w0=-W * Z[0] / Z[1])),
    )
    mesh = rig.add(
        "mesh",
        gb.GearMesh(
            teeth=Z, module=M, pressure_angle=A, external=True, k=2e8, damping_ratio=0.05,
            stiffness_variation=gb.Fourier(cos=(0.2,)), backlash=gb.Backlash(half_gap=6e-5),
            transmission_error=gb.Harmonic(cos=(5e-6,)), friction=gb.ToothFriction(mu=0.06),
        ),
    )  # fmt: skip
    rig.chain(rig.add("engine", gb.Speed(w=W)), rig.add("shaft", gb.Shaft(k=1e12, c=1.0)), pinion, mesh, wheel)
    rig.connect(rig.add("load", gb.Torque(tau=150.0)).flange, wheel.b)
    run = _start(rig.without("shaft.compliance") if shaft else rig)
    if shaft:
        assert run["mesh.force"][0] == pytest.approx(150.0 / _levers(0.06)[1], rel=1e-9)
    else:  # the shaft gives way by 1e-10 rad: before or after the entry of the pair
        assert run["mesh.force"][0] == pytest.approx(150.0 / R[1], rel=0.06)


@pytest.mark.parametrize("load", [5.0, -5.0, 1e-9])
def test_a_load_goes_through_an_open_stop_to_its_end(load):
    rig = gb.Drivetrain("stops")
    first, second = rig.add("first", gb.Inertia(J=1.0)), rig.add("second", gb.Inertia(J=1.0))
    stop = rig.add("stop", gb.HardStop(lower=-0.02, upper=0.02, restitution=0.5))
    rig.chain(rig.add("load", gb.Torque(tau=load)), first, rig.add("shaft", gb.Shaft(k=100.0)), second, stop)
    rig.connect(stop.b, rig.add("ground", gb.Fixed()).flange)
    run = _start(rig)
    assert run["second.phi"][0] == pytest.approx(0.02 * np.sign(load), rel=1e-12)
    assert run["first.phi"][0] == pytest.approx(0.02 * np.sign(load) + load / 100.0, rel=1e-12)
    assert np.abs(run["first.alpha"]).max() <= 1e-12 * abs(load)


@pytest.mark.parametrize("load", [5.0, -5.0, 1e-9])
def test_a_stop_without_any_spring_carries_the_load(load):
    rig = gb.Drivetrain("stop")
    body, stop = (
        rig.add("body", gb.Inertia(J=1.0)),
        rig.add("stop", gb.HardStop(lower=-1.0, upper=1.0, restitution=0.5)),
    )
    rig.chain(rig.add("load", gb.Torque(tau=load)), body, stop, rig.add("ground", gb.Fixed()))
    run = _start(rig)
    assert run["body.phi"] == pytest.approx(np.sign(load), rel=1e-12)


@pytest.mark.long
def test_a_load_that_no_stop_takes_is_refused_by_name():
    rig = gb.Drivetrain("stop")
    body, stop = rig.add("body", gb.Inertia(J=1.0)), rig.add("stop", gb.HardStop(lower=-1.0, restitution=0.5))
    rig.chain(rig.add("load", gb.Torque(tau=-5.0)), body, stop, rig.add("ground", gb.Fixed()))
    with pytest.raises(gb.SimulationError, match=r"'stop': there is no static equilibrium: nothing carries the load"):
        _start(rig)


@pytest.mark.long
def test_a_small_load_crosses_two_gaps_in_a_row():
    rig = gb.Drivetrain("gaps")
    first, second = rig.add("first", gb.Inertia(J=1.0)), rig.add("second", gb.Inertia(J=1.0))
    gaps = [rig.add(name, gb.Lash(k=k, c=1.0, half_gap=0.1)) for name, k in (("near", 1e3), ("far", 1e4))]
    rig.chain(rig.add("load", gb.Torque(tau=1e-9)), first, gaps[0], second, gaps[1], rig.add("ground", gb.Fixed()))
    run = _start(rig)
    assert run["second.phi"][0] - 0.1 == pytest.approx(1e-13, rel=1e-3)
    assert run["first.phi"][0] - 0.2 == pytest.approx(1.1e-12, rel=1e-3)


@pytest.mark.parametrize(("load", "twist"), [(10.0, -1.0), (-10.0, 1.0), (20.0, -1.5), (0.0, 0.0)])
def test_a_load_on_a_joint_of_a_torque_over_the_twist(load, twist):
    law = gb.Table([-2, -1, 0, 1, 2], [-30, -10, 0, 10, 30])
    rig = gb.Drivetrain("joint")
    body, spring = rig.add("body", gb.Inertia(J=1.0)), rig.add("spring", gb.Shaft(torque=law(gb.twist)))
    rig.chain(rig.add("load", gb.Torque(tau=load)), body, spring, rig.add("ground", gb.Fixed()))
    run = _start(rig)
    assert run["spring.twist"][0] == pytest.approx(twist, rel=1e-12, abs=1e-15)


def _set_behind_a_soft_shaft(k: float, error: float, torque: float, half_gap: float) -> gb.Drivetrain:
    """Its sun hangs on a shaft whose twist turns the meshes through more than a cycle of their stiffness and error."""
    rig = gb.Drivetrain("soft")
    held, sun, carrier, ring = (
        rig.add(name, gb.Inertia(J=J)) for name, J in (("held", 0.2), ("sun", 0.09), ("carrier", 0.4), ("ring", 0.26))
    )
    mesh = gb.MeshLaw(
        k=7270.0, c=9.19, stiffness_variation=gb.Fourier(cos=(0.276,)), transmission_error=gb.Harmonic(cos=(error,)),
        backlash=gb.Backlash(half_gap=half_gap),
    )  # fmt: skip
    planets = gb.PlanetaryGear(
        z_sun=30, z_planet=15, z_ring=60, planets=3, module=0.01, pressure_angle=0.35, planet_inertia=0.1,
        sun_mesh=mesh, ring_mesh=gb.MeshLaw(k=11400.0, c=8.43),
    )  # fmt: skip
    gears = rig.add("set", planets)
    shaft, anchor = rig.add("shaft", gb.Shaft(k=k, c=0.0139)), rig.add("anchor", gb.Shaft(k=290.0))
    rig.connect(rig.add("ground", gb.Fixed()).flange, anchor.a)
    rig.connect(anchor.b, held.a, shaft.a, rig.add("near", gb.Torque(tau=2.7)).flange)
    rig.connect(shaft.b, sun.a, gears.sun)
    rig.connect(carrier.a, gears.carrier)
    rig.connect(ring.a, gears.ring, rig.add("far", gb.Torque(tau=-torque)).flange)
    return rig


@pytest.mark.long
@pytest.mark.parametrize(
    ("k", "error", "torque", "half_gap"),
    [
        (0.3, 1.7e-4, 0.4, 1e-4), (0.3, 1.7e-4, 4.0, 1e-4), (1.55, 1.7e-4, 1.42, 1e-4), (1.55, 1.7e-4, 1.42, 2.45e-4),
        (8.0, 1.7e-4, 1.42, 1e-4), (8.0, 1.7e-4, 4.0, 1e-3), (8.0, 6e-4, 0.4, 1e-3), (1.55, 6e-4, 1.42, 1e-4),
    ],
)  # fmt: skip
def test_full_steps_that_lead_back_to_the_same_contacts_are_followed_by_short_ones(k, error, torque, half_gap):
    """Sun and shafts stand still, the carrier follows the ring as the numbers of teeth say (Willis)."""
    rig = _set_behind_a_soft_shaft(k, error, torque, half_gap)
    run = gb.simulate(rig, t=[0.0], initial="static", outputs=["*.alpha"])
    held, sun, carrier, ring = (float(run[f"{name}.alpha"][0]) for name in ("held", "sun", "carrier", "ring"))
    assert ring < 0.0
    assert max(abs(held), abs(sun)) < 1e-9 * abs(ring)
    assert carrier == pytest.approx(ring * 60 / 90, rel=1e-9)

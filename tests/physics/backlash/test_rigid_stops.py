"""Rigid stops and gaps without compliance: bounces, rest, and what momentum and restitution say."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.train.handles import FlangeHandle

EXACT = 1e-12  # free flight is a polynomial of time; some ten impacts round


def _chain(**parts):
    rig = gb.Drivetrain("train")
    rig.chain(*(rig.add(name, block) for name, block in parts.items()))
    return rig


def test_a_bouncing_mass_comes_to_rest_when_the_sum_of_its_flights_ends():
    e, m = 0.5, 2.0
    rig = _chain(weight=gb.Force(f=-m), mass=gb.Mass(m=m, s0=1.0), stop=gb.HardStop(lower=0.0, restitution=e))
    run = gb.simulate(rig, t_end=10.0)
    v = np.sqrt(2.0)
    hits = v + 2 * v * np.concatenate([[0.0], np.cumsum(e ** np.arange(1, 12))])
    times = [x.t for x in run.events]
    assert times[:12] == pytest.approx(hits, rel=EXACT)
    assert times[-1] == pytest.approx(3 * v, rel=1e-9)
    assert run["mass.s"][-1] == pytest.approx(0.0, abs=1e-15)
    assert run["mass.v"][-1] == run["stop.gap"][-1] == 0.0
    assert (run["stop.contact"][-1], run["stop.torque"][-1]) == (-1.0, m)
    assert run["stop.impacts"][-1] == len(run.events)
    assert run.energy.dissipated["stop"] == pytest.approx(m, rel=EXACT)
    assert run.energy.residual < EXACT


@pytest.mark.long
def test_a_shaft_between_two_stops_on_the_ground_turns_within_them():
    rig = _chain(body=gb.Inertia(J=0.5, w0=3.0), stop=gb.HardStop(lower=-0.2, upper=0.4, restitution=1.0))
    run = gb.simulate(rig, t=np.linspace(0, 5, 501))
    way = (3.0 * run.t - 0.4) % 1.2  # there and back
    assert run["body.phi"] == pytest.approx(0.4 - np.minimum(way, 1.2 - way), abs=1e-12)
    assert run["stop.gap"] == pytest.approx(np.minimum(0.4 - run["body.phi"], run["body.phi"] + 0.2), abs=1e-15)
    assert run.energy.dissipated["stop"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_two_shafts_exchange_momentum_at_a_stop(e):
    J1, J2, w = 1.0, 3.0, 2.0
    rig = _chain(a=gb.Inertia(J=J1, w0=w), stop=gb.HardStop(lower=-0.1, restitution=e), b=gb.Inertia(J=J2))
    run = gb.simulate(rig, t=[0.04, 0.06])  # phi_b - phi_a falls to -0.1 at 0.05 s
    common = J1 * w / (J1 + J2)
    assert run["a.w"][1] == pytest.approx(common - e * J2 * w / (J1 + J2), abs=1e-14)
    assert run["b.w"][1] == pytest.approx(common * (1 + e), rel=EXACT)
    assert run["stop.impulse"][1] == pytest.approx((1 + e) * w * J1 * J2 / (J1 + J2), rel=EXACT)
    assert list(run["stop.impacts"]) == [0.0, 1.0]
    assert run.energy.dissipated["stop"] == pytest.approx(
        (1 - e**2) * w**2 / 2 * J1 * J2 / (J1 + J2), rel=EXACT, abs=1e-14
    )


def test_a_closed_stop_opens_when_it_would_pull():
    rig = _chain(
        drive=gb.Torque(tau=1.0 - gb.time), body=gb.Inertia(J=2.0), stop=gb.HardStop(upper=0.0, restitution=0.5)
    )
    run = gb.simulate(rig, t=[0.5, 1.0, 3.0])
    assert list(run["stop.contact"][[0, 2]]) == [1.0, 0.0]
    assert run["stop.torque"][0] == pytest.approx(-0.5, rel=EXACT)
    assert run["body.phi"] == pytest.approx([0.0, 0.0, -(2.0**3) / 12], rel=1e-9, abs=1e-12)


HIT = gb.HuntCrossley(restitution=0.6)


def _lash():
    lash = gb.Lash(k=1e8, half_gap=0.05, contact_damping=HIT)
    return _chain(a=gb.Inertia(J=1.0, phi0=0.0, w0=1.0), part=lash, b=gb.Inertia(J=2.0, phi0=0.01))


def _spline():
    spline = gb.SplineCoupling(teeth=3, radius=0.1, k=1e10, backlash=gb.Backlash(half_gap=0.005), contact_damping=HIT)
    return _chain(a=gb.Inertia(J=1.0, w0=1.0), part=spline, b=gb.Inertia(J=2.0))


def _mesh(carrier):
    rig = gb.Drivetrain("mesh")
    a, b = rig.add("a", gb.Inertia(J=1.0, w0=1.0)), rig.add("b", gb.Inertia(J=2.0))
    part = rig.add("part", gb.GearMesh(
        teeth=(20, 41), external=True, module=0.01, pressure_angle=0.35, k=1e12, backlash=gb.Backlash(half_gap=1e-3),
        contact_damping=HIT,
    ))  # fmt: skip
    rig.connect(a.b, part.pinion)
    rig.connect(b.a, part.wheel)
    if carrier:
        rig.connect(rig.add("c", gb.Inertia(J=3.0, w0=0.1)).a, part.carrier)
    return rig


@pytest.mark.long
@pytest.mark.parametrize(
    "rig",
    [
        pytest.param(_lash(), id="lash"),
        pytest.param(_spline(), id="spline", marks=pytest.mark.long),
        pytest.param(_mesh(False), id="mesh"),
        pytest.param(_mesh(True), id="carrier", marks=pytest.mark.long),
    ],
)
def test_a_gap_without_compliance_is_the_limit_of_a_hard_contact(rig):
    rigid = rig.without("part.compliance")
    assert rigid.dropped == ("part.compliance",)
    assert set(rigid.effects()) == {"part.backlash", "part.damping"}
    t = [0.01, 0.3, 1.0]
    hard, limit = gb.simulate(rig, t=t, rtol=1e-9), gb.simulate(rigid, t=t, rtol=1e-9)
    for name in ("a.w", "b.w", "part.contact"):
        assert hard[name] == pytest.approx(limit[name], abs=2e-4)  # contacts of some 1e-4 of the free flight
    assert limit.energy.residual < EXACT


def test_a_rigid_gap_that_is_taken_away_leaves_a_tie():
    rig = _lash().without("part.compliance").without("part.backlash")
    assert rig.effects() == {}
    assert rig.dropped == ("part.backlash", "part.damping", "b.phi0")
    run = gb.simulate(rig, t=[1.0])
    assert run["a.w"][0] == run["b.w"][0] == pytest.approx(1.0, rel=EXACT)


def test_a_pressed_rigid_mesh_carries_the_force_of_its_line_of_action():
    rig = _mesh(False).without("part.compliance")
    tau = rig.add("tau", gb.Torque(tau=50.0))
    rig.connect(tau.flange, rig.add("extra", gb.Inertia(J=1e-3)).a)
    rig.connect(FlangeHandle(rig, "extra", "b"), FlangeHandle(rig, "a", "a"))
    run = gb.simulate(rig, t=[5.0])
    radius = 0.01 * 20 * np.cos(0.35) / 2
    share = 2.0 * (20 / 41) ** 2 / (1.001 + 2.0 * (20 / 41) ** 2)  # of the torque that goes through to the wheel
    assert run["part.contact"][0] == 1.0
    assert run["part.force"][0] == pytest.approx(50.0 * share / radius, rel=1e-9)
    assert run["part.deflection"][0] == pytest.approx(1e-3, rel=1e-9)


def test_a_start_beyond_a_stop_is_refused_by_name() -> None:
    rig = gb.Drivetrain("train")
    rig.chain(rig.add("body", gb.Inertia(J=1.0)), rig.add("stop", gb.HardStop(lower=0.5, upper=1.0, restitution=0.5)))
    with pytest.raises(gb.SimulationError, match=r"'stop.*: the start values contradict it"):
        gb.simulate(rig, t_end=1.0)


@pytest.mark.long
def test_a_freewheel_passes_the_impact_of_a_stop_on_to_what_drives_it():
    rig = gb.Drivetrain("halt")
    one, two = rig.add("one", gb.Inertia(J=1.0, w0=2.0)), rig.add("two", gb.Inertia(J=3.0, w0=2.0))
    rig.chain(one, rig.add("wheel", gb.Freewheel()), two)
    rig.connect(rig.add("stop", gb.HardStop(upper=1.0, restitution=0.0)).a, two.b)
    run = gb.simulate(rig, t=[0.4, 0.6, 2.0])
    assert run["one.w"] == pytest.approx([2.0, 0.0, 0.0], abs=1e-14)
    assert run["two.w"] == pytest.approx([2.0, 0.0, 0.0], abs=1e-14)
    assert run["stop.impulse"][-1] == pytest.approx(8.0, rel=EXACT)
    assert sum(run.energy.dissipated.values()) == pytest.approx(8.0, rel=EXACT)


@pytest.mark.long
def test_a_body_at_its_stop_that_is_pulled_away_leaves_at_once():
    stop = gb.HardStop(lower=0.0, restitution=0.5)
    rig = _chain(drive=gb.Torque(tau=gb.Parameter("tau", 1.0)), body=gb.Inertia(J=2.0), stop=stop)
    assert gb.simulate(rig, t=[1.0])["body.phi"][0] == pytest.approx(0.25, rel=EXACT)
    assert gb.simulate(rig, t=[1.0], parameters={"tau": -1.0})["body.phi"][0] == 0.0

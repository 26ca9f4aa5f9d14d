"""Trains that lose nothing keep their energy to what the ledger promises, however many steps they take."""

import warnings

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb


def _noncircular():
    rig = gb.Drivetrain("turns")
    a, b = rig.add("a", gb.Inertia(J=0.108, w0=-18.6)), rig.add("b", gb.Inertia(J=0.0531))
    pair = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.503), external=False))
    rig.connect(a.a, pair.a)
    rig.connect(pair.b, b.a)
    return rig


def _joint():
    rig = gb.Drivetrain("joint")
    a, b = rig.add("a", gb.Inertia(J=0.1, w0=40.0)), rig.add("b", gb.Inertia(J=0.3))
    joint = rig.add("joint", gb.UniversalJoint(angle=0.9))
    rig.connect(a.a, joint.a)
    rig.connect(joint.b, b.a)
    return rig


def _on_a_shaft(body, shaft):
    rig = gb.Drivetrain("rings")
    rig.chain(rig.add("a", body), rig.add("shaft", shaft), rig.add("ground", gb.Fixed()))
    return rig


def _oscillator():
    return _on_a_shaft(gb.Inertia(J=0.5, w0=3.0), gb.Shaft(k=0.5 * 90.0**2))


def _stiffening():
    return _on_a_shaft(gb.Inertia(J=0.2, w0=30.0), gb.Shaft(torque=40.0 * gb.twist + 900.0 * gb.twist**3))


def _detent():
    rig = gb.Drivetrain("detent")
    body = rig.add("a", gb.Inertia(J=0.2, w0=9.0))
    rig.connect(body.a, rig.add("law", gb.Torque(tau=-5.0 * gb.sin(3 * gb.sense("a.phi")))).flange)
    return rig


TRAINS = {
    "noncircular": _noncircular,
    "joint": _joint,
    "oscillator": _oscillator,
    "stiffening": _stiffening,
    "detent": _detent,
}


def _energy(name, run):
    """Energy at the end over that at the start, in closed form."""
    w, phi = run["a.w"][-1], run["a.phi"][-1]
    if name in ("noncircular", "joint"):
        first, second = (0.108, 0.0531) if name == "noncircular" else (0.1, 0.3)
        start = first * run["a.w"][0] ** 2 + second * run["b.w"][0] ** 2
        return (first * w**2 + second * run["b.w"][-1] ** 2) / start
    if name == "oscillator":
        return (w**2 + 90.0**2 * phi**2) / 9.0
    if name == "stiffening":
        return (0.1 * w**2 + 20.0 * phi**2 + 225.0 * phi**4) / 90.0
    return (0.1 * w**2 - 5.0 / 3.0 * (float(sp.cos(3 * phi)) - 1)) / 8.1


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.long] * (n == "joint")) for n in TRAINS])
@pytest.mark.parametrize("method", ["dp5", "dp8", "rodas"])
@pytest.mark.few(1)
def test_what_loses_nothing_keeps_its_energy(name, method):
    model = gb.build(TRAINS[name]())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for rtol in (1e-6, 1e-8):
            run = gb.simulate(model, t_end=6.0, rtol=rtol, method=method)
            assert run.energy.residual <= 10 * rtol
            assert abs(_energy(name, run) - 1) <= 20 * rtol  # of a turnover that is at least the energy


def _two_joints():
    rig = gb.Drivetrain("joints")
    a, b, c = (rig.add(n, gb.Inertia(J=J)) for n, J in (("a", 0.1), ("b", 0.3), ("c", 0.05)))
    one, two = rig.add("one", gb.UniversalJoint(angle=0.9)), rig.add("two", gb.UniversalJoint(angle=0.7))
    rig.chain(a, one, b, two, c)
    return rig.set({"a.w0": 40.0}), (0.1, 0.3, 0.05)


BENT = {
    "ellipses": lambda: (_noncircular(), (0.108, 0.0531)),
    "joint": lambda: (_joint(), (0.1, 0.3)),
    "two joints": _two_joints,
}


@pytest.mark.parametrize("name", [pytest.param(n, marks=[pytest.mark.long] * (n == "two joints")) for n in BENT])
@pytest.mark.few(1)
def test_no_step_over_a_gain_that_bends_adds_more_than_its_tolerance(name):
    """One state of speed: an embedded estimate passes zero by chance; the kinetic energy tells the error."""
    rig, inertias = BENT[name]()
    model = gb.build(rig)
    for method in ("dp5", "dp8", "rodas"):
        for rtol in (1e-5, 1e-6, 1e-7, 1e-8):
            run = gb.simulate(model, t_end=2.0, rtol=rtol, method=method)
            energy = sum(J * run[f"{n}.w"] ** 2 for n, J in zip("abc", inertias, strict=False))
            assert np.abs(np.diff(energy)).max() <= 1.05 * rtol * energy[0]
            assert run.energy.residual <= 5 * rtol


@pytest.mark.long
@pytest.mark.parametrize("method", ["dp5", "dp8"])
def test_a_jump_that_nothing_announces_stops_no_step_over_a_gain_that_bends(method):
    """What it adds to the balance of a step is no error that shorter tries of the step remove."""
    rig = gb.Drivetrain("jumps")
    a, b = rig.add("a", gb.Inertia(J=0.1, w0=4.0)), rig.add("b", gb.Inertia(J=0.3))
    rig.chain(rig.add("drive", gb.Torque(tau=gb.Input("u"))), a, rig.add("joint", gb.UniversalJoint(angle=0.9)), b)
    model = gb.build(rig)
    run = gb.simulate(model, t_end=10.0, inputs={"u": lambda t: 1.0 if t % 0.5 < 0.25 else -1.0}, method=method)
    wave = gb.Table([0, 0.25, 0.5], [1, -1, 1], kind="step", periodic=True)
    smooth = gb.simulate(model, t_end=10.0, inputs={"u": wave}, method=method)
    assert run.stats.steps < 5 * smooth.stats.steps


@pytest.mark.long
def test_what_is_no_error_of_steps_makes_no_run_longer():
    """A callable that jumps unannounced costs energy that shorter steps do not bring back."""
    rig = gb.Drivetrain("jumps")
    body, shaft = rig.add("a", gb.Inertia(J=0.5)), rig.add("shaft", gb.Shaft(k=200.0, c=0.3))
    rig.connect(body.a, shaft.a, rig.add("drive", gb.Torque(tau=gb.Input("u"))).flange)
    rig.connect(shaft.b, rig.add("ground", gb.Fixed()).flange)
    model = gb.build(rig)
    run = gb.simulate(model, t_end=10.0, inputs={"u": lambda t: 1.0 if t % 0.5 < 0.25 else -1.0})
    smooth = gb.simulate(
        model, t_end=10.0, inputs={"u": gb.Table([0, 0.25, 0.5], [1, -1, 1], kind="step", periodic=True)}
    )
    assert run.stats.steps < 20 * smooth.stats.steps


def _work(phi, torque, level, ripple):
    """Of a torque that acts where cos(3 phi) > level, and of ripple * abs(sin(phi)), from 0 to phi."""
    half, period = np.arccos(level) / 3.0, 2.0 * np.pi / 3.0
    turns = np.floor((phi + half) / period)
    on = 2.0 * half * turns + min(phi + half - turns * period, 2.0 * half) - half
    halves = np.floor(phi / np.pi)
    return torque * on + ripple * (2.0 * halves + 1.0 - np.cos(phi - halves * np.pi))


@pytest.mark.long
@pytest.mark.parametrize("rtol", [1e-6, 1e-7, 1e-8])
@pytest.mark.parametrize(("J", "level"), [(0.03, 0.0521), (0.0641, 0.3), (0.15, 0.0521), (0.15, 0.3)])
def test_a_body_that_switches_drive_faster_and_faster_has_the_energy_that_its_angle_says(J, level, rtol):
    torque, ripple, phi = 3.9, 0.335, gb.sense("body.phi")
    rig = gb.Drivetrain("rig")
    body = rig.add("body", gb.Inertia(J=J))
    drive = gb.piecewise((torque, gb.cos(3 * phi) > level), (0.0, True)) + ripple * sp.Abs(gb.sin(phi))
    rig.connect(body.a, rig.add("drive", gb.Torque(tau=drive)).flange)
    run = gb.simulate(rig, t_end=3.0, method="dp5", rtol=rtol, outputs=["body.phi", "body.w"])
    work = _work(run["body.phi"][-1], torque, level, ripple)
    assert run.energy.residual <= 10.0 * rtol
    assert 0.5 * J * run["body.w"][-1] ** 2 == pytest.approx(work, rel=20.0 * rtol)


@pytest.mark.parametrize(("J", "torque", "pace", "end"), [(0.1, 4.0, 3, 3.0), (0.05, 2.0, 2, 4.0)])
@pytest.mark.few(1)
def test_a_torque_that_touches_zero_over_the_angle_drives_as_much_as_it_says(J, torque, pace, end):
    """The turnover grows all the time, and the corners' errors add up one way (14 and 11 tolerances)."""
    rig = gb.Drivetrain("rig")
    body = rig.add("body", gb.Inertia(J=J))
    drive = torque * sp.Abs(gb.sin(pace * gb.sense("body.phi"))) + 0.1
    rig.connect(body.a, rig.add("drive", gb.Torque(tau=drive)).flange)
    rtol = 1e-4
    run = gb.simulate(rig, t_end=end, method="dp5", rtol=rtol, outputs=["body.phi", "body.w"])
    phi = run["body.phi"][-1]
    halves, rest = divmod(pace * phi, np.pi)
    work = torque / pace * (2 * halves + 1 - np.cos(rest)) + 0.1 * phi
    assert run.energy.residual <= 5.0 * rtol
    assert 0.5 * J * run["body.w"][-1] ** 2 == pytest.approx(work, rel=10.0 * rtol)  # the turnover is twice the work


def _rattle():
    """A mesh that is driven over time, from its static equilibrium: it exchanges as much in every period."""
    rig = gb.Drivetrain("rattle")
    w, load = gb.Parameter("w", 4.2e4, "rad/s"), 2600.0
    twist, mesh_twist = load / 1e5, (20e-6 + load / (0.025 * 245e6)) / 0.025
    angles = (2 * twist + mesh_twist, twist + mesh_twist, twist, 0.0)
    bodies = [
        rig.add(f"disc{i}", gb.Inertia(J=J, phi0=phi0))
        for i, (J, phi0) in enumerate(zip((5e-3, 2e-4, 2e-4, 1e-2), angles, strict=True))
    ]
    left, right = (rig.add(name, gb.Shaft(k=1e5, damping_ratio=0.05)) for name in ("left", "right"))
    mesh = rig.add(
        "mesh",
        gb.SplineCoupling(
            teeth=20, radius=0.025, k=245e6, c=626.0, backlash=gb.Backlash(half_gap=20e-6), contact_damping="always",
            stiffness_variation=gb.Fourier(cos=(0.3,), driven_by=w),
        ),
    )  # fmt: skip
    drive = rig.add("drive", gb.Torque(tau=load * (1 + 0.1 * gb.cos(w * gb.time))))
    rig.chain(
        drive, bodies[0], left, bodies[1], mesh, bodies[2], right, bodies[3], rig.add("load", gb.Torque(tau=-load))
    )
    return rig


@pytest.mark.long
def test_what_exchanges_as_much_for_ever_is_not_stepped_more_strictly_for_a_later_end():
    model = gb.build(_rattle())
    for rtol in (1e-5, 1e-6):
        runs = [gb.simulate(model, t=[0.0, t_end], rtol=rtol, method="dp8") for t_end in (0.01, 0.1)]
        soon, late = (run.stats.steps + run.stats.rejected for run in runs)
        assert late < 1.05 * 10 * soon
        assert runs[1].energy.residual < 3 * rtol


@pytest.mark.parametrize("torque", [0.0, 3.0, 30 * gb.sin(3 * gb.time)], ids=["free", "driven", "back and forth"])
@pytest.mark.few(2)
def test_a_pair_of_ellipses_that_turns_for_long_keeps_its_energy(torque):
    """It departs in one part of each turn alone: what looks right in the others may not be trusted at once."""
    rig = gb.Drivetrain("ellipses")
    pair = rig.add("pair", gb.NonCircularGear(law=gb.RatioLaw.ellipse(e=0.521, order=2), external=True))
    rig.chain(rig.add("source", gb.Torque(tau=torque)), rig.add("a", gb.Inertia(J=0.0877, w0=20.0)), pair)
    rig.connect(pair.b, rig.add("b", gb.Inertia(J=1.92)).a)
    model = gb.build(rig)
    for method, rtol in (("rodas", 1e-4), ("rodas", 1e-6), ("dp8", 1e-8), ("dp5", 1e-4)):
        run = gb.simulate(model, t=[0.0, 20.0], method=method, rtol=rtol)
        assert run.energy.residual < 10 * rtol, (method, rtol)
        assert run.stats.steps < 4e5


@pytest.mark.parametrize("rtol", [1e-6, 3e-8, 1e-8])
def test_a_body_that_bounces_off_a_stop_misses_no_energy_at_each_bounce(rtol):
    # dp8: each flight of j1 is one step that an event cuts at the same place, and misses half a tolerance each time
    rig = gb.Drivetrain("pressed onto a stop")
    j1, j2 = rig.add("j1", gb.Inertia(J=0.023)), rig.add("j2", gb.Inertia(J=2.0, w0=0.0))
    teeth = {"teeth": 3, "radius": 0.02, "k": 273e3, "c": 80.4, "contact_damping": "always"}
    spline = rig.add("spline", gb.SplineCoupling(**teeth, backlash=gb.Backlash(gaps=(2.21e-4, 2.21e-4, 7.36e-5))))
    above = rig.add("above", gb.HardStop(restitution=1.0, upper=0.704))
    between = rig.add("between", gb.HardStop(restitution=0.0, lower=-0.0924))
    torque = rig.add("torque", gb.Torque(tau=30.8 * gb.sin(4.0 * gb.time) * gb.cos(1.48 * gb.time)))
    rig.connect(j1.a, spline.a, above.a, between.a)
    rig.connect(j2.a, spline.b, between.b, torque.flange)
    run = gb.simulate(rig, t=np.linspace(0.0, 1.0, 51), method="dp8", rtol=rtol)
    assert sum(e.component == "above.upper" for e in run.events) == 54
    assert run.energy.residual <= 6.0 * rtol

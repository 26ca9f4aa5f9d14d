"""Stiffness and transmission error that vary over time or over the angle."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

TIGHT = {"rtol": 1e-12}
NEAR = 1e-8  # hundreds of steps at rtol 1e-12; phases of tens of radians
Z, R, K, J = (20, 30), (0.02, 0.03), 1.0e6, (1e-3, 4e-3)
COS, SIN = (0.2, 0.05), (0.1, 0.0, 0.03)
T = np.linspace(0, 0.05, 201)


def _series(theta, cos=COS, sin=SIN):
    return sum(a * np.cos(j * theta) for j, a in enumerate(cos, 1)) + sum(
        b * np.sin(j * theta) for j, b in enumerate(sin, 1)
    )


def _slope(theta, cos=COS, sin=SIN):
    return sum(-j * a * np.sin(j * theta) for j, a in enumerate(cos, 1)) + sum(
        j * b * np.cos(j * theta) for j, b in enumerate(sin, 1)
    )


def _pair(carrier=False, **fields):
    """A free pair, external; started by speeds only."""
    rig = gb.Drivetrain("excited pair")
    pinion, wheel = rig.add("pinion", gb.Inertia(J=J[0])), rig.add("wheel", gb.Inertia(J=J[1]))
    mesh = rig.add("mesh", gb.GearMesh(teeth=Z, r_base=R, external=True, k=K, **fields))
    rig.chain(pinion, mesh, wheel)
    if carrier:
        rig.connect(rig.add("carrier", gb.Inertia(J=0.01)).a, mesh.carrier)
    return rig


START = {"pinion.w": 300.0, "wheel.w": -201.0}
Y0 = (0.0, 0.0, 300.0, -201.0)


def _rates(stiffness, error=lambda t, y: (0.0, 0.0), pinion_extra=lambda t, y, x, n: 0.0):
    def rates(t, y, _):
        e, _ = error(t, y)
        x = R[0] * y[0] + R[1] * y[1] - e
        n = stiffness(t, y) * x
        return (y[2], y[3], (-R[0] * n + pinion_extra(t, y, x, n)) / J[0], -R[1] * n / J[1])

    return rates


@pytest.mark.long
def test_a_stiffness_driven_by_time_follows_its_frequency_and_phase(reference, distance):
    w, phase = 2500.0, 0.7
    variation = gb.Fourier(cos=COS, sin=SIN, driven_by=w, phase=phase)
    run = gb.simulate(_pair(stiffness_variation=variation), t=T, initial=START, **TIGHT)
    k = lambda t, y: K * (1 + _series(w * t + phase))  # noqa: E731
    true = reference(_rates(k), Y0, T)
    assert distance(run["mesh.stiffness"], k(T, None)) < 1e-12  # rounding of w t = 125 rad
    assert distance(run["mesh.deflection"], R[0] * true[:, 0] + R[1] * true[:, 1]) < NEAR
    assert run.energy.residual < 1e-11  # 10 rtol: the parametric work is in the ledger
    assert abs(run.energy.supplied["mesh"]) > 1e-2 * run.energy.exchanged


@pytest.mark.long
def test_a_varying_frequency_is_integrated_never_multiplied_by_time(reference, distance):
    w0, rate = 1500.0, 4.0e4
    rig = _pair(stiffness_variation=gb.Fourier(cos=COS, driven_by=gb.Input("w", start=w0, unit="rad/s"), phase=0.3))
    run = gb.simulate(rig, t=T, initial=START, inputs={"w": gb.Table([0, 1], [w0, w0 + rate])}, **TIGHT)
    theta = w0 * T + rate * T**2 / 2 + 0.3
    assert distance(run["mesh.stiffness"], K * (1 + _series(theta, sin=()))) < 1e-10
    true = reference(_rates(lambda t, y: K * (1 + _series(w0 * t + rate * t**2 / 2 + 0.3, sin=()))), Y0, T)
    assert distance(run["mesh.deflection"], R[0] * true[:, 0] + R[1] * true[:, 1]) < NEAR
    assert run.energy.residual < 1e-11


@pytest.mark.long
def test_an_expression_of_time_as_frequency_is_integrated_too(distance):
    rig = _pair(stiffness_variation=gb.Fourier(cos=(0.2,), driven_by=1000 + 500 * sp.sin(100 * gb.time)))
    run = gb.simulate(rig, t=T, initial=START, **TIGHT)
    theta = 1000 * T + 5 * (1 - np.cos(100 * T))
    assert distance(run["mesh.stiffness"], K * (1 + 0.2 * np.cos(theta))) < 1e-10


def test_a_parameter_as_frequency_can_be_changed_without_a_new_model(distance):
    rig = _pair(stiffness_variation=gb.Fourier(cos=(0.2,), driven_by=gb.Parameter("mesh_frequency", 1000.0, "rad/s")))
    run = gb.simulate(rig, t=T, initial=START, parameters={"mesh_frequency": 1700.0}, rtol=1e-9)
    assert distance(run["mesh.stiffness"], K * (1 + 0.2 * np.cos(1700.0 * T))) < 1e-12


def test_a_stiffness_driven_by_the_angle_comes_from_a_potential(reference, distance):
    run = gb.simulate(_pair(stiffness_variation=gb.Fourier(cos=COS, sin=SIN, phase=0.4)), t=T, initial=START, **TIGHT)

    def pinion_extra(t, y, x, n):
        return -K * Z[0] * _slope(Z[0] * y[0] + 0.4) * x**2 / 2

    true = reference(_rates(lambda t, y: K * (1 + _series(Z[0] * y[0] + 0.4)), pinion_extra=pinion_extra), Y0, T)
    assert distance(run["mesh.deflection"], R[0] * true[:, 0] + R[1] * true[:, 1]) < NEAR
    energy = run["pinion.kinetic_energy"] + run["wheel.kinetic_energy"]
    energy += run["mesh.stiffness"] * run["mesh.deflection"] ** 2 / 2
    assert distance(energy, np.full(len(T), energy[0])) < 1e-11  # kept, to 10 rtol
    assert run.energy.residual < 1e-11
    assert "mesh" not in run.energy.supplied


@pytest.mark.long
@pytest.mark.parametrize("backlash", [None, gb.Backlash(half_gap=20e-6)], ids=["linear", "backlash"])
def test_a_free_pair_on_a_turning_carrier_keeps_energy_and_angular_momentum(backlash, distance):
    rig = _pair(
        carrier=True,
        stiffness_variation=gb.Fourier(cos=COS),
        transmission_error=gb.Harmonic(cos=(1e-5,)),
        backlash=backlash,
    )
    run = gb.simulate(rig, t=T, initial={**START, "carrier.w": 20.0}, **TIGHT)
    momentum = J[0] * run["pinion.w"] + J[1] * run["wheel.w"] + 0.01 * run["carrier.w"]
    assert distance(momentum, np.full(len(T), momentum[0])) < 1e-11
    energy = sum(run[f"{n}.kinetic_energy"] for n in ("pinion", "wheel", "carrier"))
    x = run["mesh.deflection"]
    g = x if backlash is None else np.sign(x) * np.maximum(np.abs(x) - 20e-6, 0)
    energy = energy + run["mesh.stiffness"] * g**2 / 2
    assert distance(energy, np.full(len(T), energy[0])) < 1e-10  # hundreds of corners, each at 100 eps
    assert run.energy.residual < 1e-11


def test_an_error_driven_by_the_angle_pushes_the_pinion_by_its_slope(reference, distance):
    amplitude = 2e-5
    run = gb.simulate(_pair(transmission_error=gb.Harmonic(sin=(amplitude,))), t=T, initial=START, **TIGHT)

    def error(t, y):
        return amplitude * np.sin(Z[0] * y[0]), Z[0] * amplitude * np.cos(Z[0] * y[0])

    true = reference(_rates(lambda t, y: K, error, lambda t, y, x, n: n * error(t, y)[1]), Y0, T)
    line = R[0] * true[:, 0] + R[1] * true[:, 1]
    assert distance(run["mesh.dynamic_transmission_error"], line) < NEAR
    assert distance(run["mesh.deflection"], line - amplitude * np.sin(Z[0] * true[:, 0])) < NEAR
    assert np.allclose(
        run["mesh.pinion.tau"],
        -run["mesh.force"] * (R[0] - Z[0] * amplitude * np.cos(Z[0] * run["pinion.phi"])),
        rtol=1e-9, atol=1e-9,  # the angle, 15 rad, enters the cosine with its rounding
    )  # fmt: skip
    assert "mesh" not in run.energy.supplied
    assert run.energy.residual < 1e-11


@pytest.mark.long
def test_an_error_driven_by_time_does_work_on_the_train(reference, distance):
    amplitude, w, c = 2e-5, 3000.0, 5.0
    rig = _pair(transmission_error=gb.Harmonic(cos=(amplitude,), driven_by=w, phase=0.2), c=c)
    run = gb.simulate(rig, t=T, initial=START, **TIGHT)

    def rates(t, y, _):
        theta = w * t + 0.2
        x = R[0] * y[0] + R[1] * y[1] - amplitude * np.cos(theta)
        v = R[0] * y[2] + R[1] * y[3] + amplitude * w * np.sin(theta)
        n = K * x + c * v
        return (y[2], y[3], -R[0] * n / J[0], -R[1] * n / J[1])

    true = reference(rates, Y0, T)
    assert distance(run["mesh.dynamic_transmission_error"], R[0] * true[:, 0] + R[1] * true[:, 1]) < NEAR
    assert abs(run.energy.supplied["mesh"]) > 0
    assert run.energy.residual < 1e-11


def test_a_square_stiffness_jumps_with_the_contact_ratio(reference, distance):
    w, ripple, ratio = 1500.0, 0.2, 1.6
    square = gb.Square(ripple=ripple, contact_ratio=ratio, driven_by=w)
    run = gb.simulate(_pair(stiffness_variation=square), t=T, initial=START, **TIGHT)
    cycle = np.mod(w * T, 2 * np.pi) / (2 * np.pi)
    share = ratio - 1
    clear = np.minimum.reduce([np.abs(cycle - edge) for edge in (0, share, 1)]) > 1e-9  # samples off the jumps
    upper = cycle < share
    true_k = K * (1 + np.where(upper, 2 * ripple * (1 - share), -2 * ripple * share))
    assert distance(run["mesh.stiffness"][clear], true_k[clear]) < 1e-14
    assert np.mean((share, -(1 - share))) != 0
    values = 2 * ripple * (1 - share), -2 * ripple * share
    assert share * values[0] + (1 - share) * values[1] == pytest.approx(0, abs=1e-16)  # mean 1
    assert values[0] - values[1] == pytest.approx(2 * ripple)

    def k(modes):
        return K * (1 + (values[0] if modes[0] > 0 else values[1]))

    def rates(t, y, modes):
        n = k(modes) * (R[0] * y[0] + R[1] * y[1])
        return (y[2], y[3], -R[0] * n / J[0], -R[1] * n / J[1])

    true = reference(rates, Y0, T, lambda t, y: (np.cos(w * t - np.pi * share) - np.cos(np.pi * share),), max_step=2e-4)
    assert distance(run["mesh.deflection"], R[0] * true[:, 0] + R[1] * true[:, 1]) < NEAR
    assert run.energy.residual < 1e-11
    jumps = [e.t for e in run.events if e.kind == "time"]
    cycles = int(w * T[-1] / (2 * np.pi))
    assert len(jumps) in (2 * cycles - 1, 2 * cycles, 2 * cycles + 1, 2 * cycles + 2)


def test_a_square_stiffness_over_the_angle_is_refused():
    with pytest.raises(gb.GearblocksError, match="jumps"):
        _pair(stiffness_variation=gb.Square(ripple=0.1, contact_ratio=1.5, driven_by="angle"))


def test_mesh_phase_is_the_position_inside_the_cycle_of_the_teeth(distance):
    run = gb.simulate(_pair(stiffness_variation=gb.Fourier(cos=(0.1,))), t=T, initial=START, rtol=1e-9)
    phase, cycles = run["mesh.mesh_phase"], Z[0] * run["pinion.phi"] / (2 * np.pi)
    assert np.all((phase >= 0) & (phase < 1))
    assert np.abs((cycles - phase + 0.5) % 1 - 0.5).max() < 1e-12  # 50 cycles, to rounding

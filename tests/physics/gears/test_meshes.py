"""Gear meshes against equations derived by hand, in full angles."""

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

TIGHT = {"rtol": 1e-12}
NEAR = 1e-8  # a few hundred steps at rtol 1e-12; the force is k = 2e8 times a deflection known to 1e-16 of an angle
R1, R2, K, C = 0.023, 0.041, 2.0e8, 2.0e3
J1, J2, JC = 2.0e-4, 5.0e-2, 3.0e-2


def _mesh(external, turning, **fields):
    """Pinion, wheel and (turning) carrier, each with its inertia and a torque."""
    rig = gb.Drivetrain("mesh")
    pinion, wheel = rig.add("pinion", gb.Inertia(J=J1)), rig.add("wheel", gb.Inertia(J=J2))
    fields = {"teeth": (23, 41), "r_base": (R1, R2), "k": K, **fields}
    mesh = rig.add("mesh", gb.GearMesh(external=external, **fields))
    drive = rig.add("drive", gb.Torque(tau=20 + 10 * sp.sin(9e3 * gb.time)))
    load = rig.add("load", gb.Torque(tau=(20 if external else -20) * R2 / R1))
    rig.connect(drive.flange, pinion.a, mesh.pinion)
    rig.connect(load.flange, wheel.a, mesh.wheel)
    if turning:
        carrier = rig.add("carrier", gb.Inertia(J=JC))
        rig.connect(carrier.a, mesh.carrier)
    return rig


def _by_hand(external, turning, force):
    """Rates of (phi_1, phi_2, phi_c, w_1, w_2, w_c); force(x, x', modes)."""
    sign = 1 if external else -1
    jc = JC if turning else np.inf

    def rates(t, y, modes):
        p, w = y[:3], y[3:]
        x = R1 * (p[0] - p[2]) + sign * R2 * (p[1] - p[2])
        v = R1 * (w[0] - w[2]) + sign * R2 * (w[1] - w[2])
        n = force(x, v, modes)
        out = (20 if external else -20) * R2 / R1
        torques = (20 + 10 * np.sin(9e3 * t) - R1 * n, out - sign * R2 * n, (R1 + sign * R2) * n)
        return [*w, torques[0] / J1, torques[1] / J2, torques[2] / jc]

    return rates, lambda y: R1 * (y[..., 0] - y[..., 2]) + sign * R2 * (y[..., 1] - y[..., 2])


T = np.linspace(0, 4e-3, 161)
PLACES = pytest.mark.parametrize(
    ("external", "turning"),
    [
        pytest.param(True, False, id="external-grounded", marks=pytest.mark.long),
        pytest.param(True, True, id="external-turning"),
        pytest.param(False, False, id="internal-grounded"),
        pytest.param(False, True, id="internal-turning", marks=pytest.mark.long),
    ],
)


@PLACES
@pytest.mark.few(1)
def test_a_linear_mesh_moves_as_derived_by_hand(external, turning, reference, distance):
    run = gb.simulate(_mesh(external, turning, c=C), t=T, initial={"pinion.w": 0.3}, **TIGHT)
    rates, deflection = _by_hand(external, turning, lambda x, v, _: K * x + C * v)
    true = reference(rates, [0, 0, 0, 0.3, 0, 0], T)
    assert distance(run["mesh.deflection"], deflection(true)) < NEAR
    assert distance(run["pinion.w"], true[:, 3]) < NEAR
    assert distance(run["wheel.w"], true[:, 4]) < NEAR
    if turning:
        assert distance(run["carrier.w"], true[:, 5]) < NEAR
    force = np.array([rates(t, y, ())[3] for t, y in zip(T, true, strict=True)])
    assert distance(run["mesh.force"], (20 + 10 * np.sin(9e3 * T) - J1 * force) / R1) < NEAR


@PLACES
@pytest.mark.few(1)
def test_a_mesh_with_backlash_moves_as_derived_by_hand(external, turning, reference, distance):
    b = 30e-6
    rig = _mesh(external, turning, backlash=gb.Backlash(half_gap=b))
    run = gb.simulate(rig, t=T, initial={"pinion.w": -40.0}, **TIGHT)

    def force(x, v, modes):
        return K * (x - b if modes[0] > 0 else x + b if modes[1] < 0 else 0.0)

    rates, deflection = _by_hand(external, turning, force)
    # deflections scaled to half gaps, so that the reference sees corners at the size of 1
    true = reference(
        rates, [0, 0, 0, -40.0, 0, 0], T, lambda t, y: ((deflection(y) - b) / b, (deflection(y) + b) / b), max_step=2e-5
    )
    assert set(np.unique(run["mesh.contact"])) == {-1.0, 0.0, 1.0}
    assert distance(run["mesh.deflection"], deflection(true)) < NEAR
    assert distance(run["pinion.w"], true[:, 3]) < NEAR
    assert run.energy.residual < 1e-11  # 10 rtol


@pytest.mark.long
def test_module_and_angles_give_the_base_radii():
    angle, helix, m = np.deg2rad(20), np.deg2rad(15), 3e-3
    transverse = np.arctan(np.tan(angle) / np.cos(helix))
    for fields, r1 in (
        ({}, m * 23 * np.cos(angle) / 2),
        ({"helix_angle": helix}, m * 23 * np.cos(transverse) / (2 * np.cos(helix))),
    ):
        geometry = {"r_base": None, "module": m, "pressure_angle": angle, **fields}
        run = gb.simulate(_mesh(True, False, **geometry), t=[0.0], initial={"pinion.phi": 1e-3}, rtol=1e-6)
        assert run["mesh.deflection"][0] == pytest.approx(r1 * 1e-3, rel=1e-14)


@pytest.mark.long
def test_a_vanishing_gap_gives_the_linear_mesh(distance):
    for choice in ("clipped", "clipped_force", "always"):
        gap = _mesh(True, False, backlash=gb.Backlash(half_gap=0.0), contact_damping=choice)
        run = gb.simulate(gap, t=T, **TIGHT)
        linear = gb.simulate(_mesh(True, False), t=T, **TIGHT)
        assert distance(run["mesh.deflection"], linear["mesh.deflection"]) < NEAR
    damped = gb.simulate(
        _mesh(True, False, c=C, backlash=gb.Backlash(half_gap=0.0), contact_damping="always"), t=T, **TIGHT
    )
    linear = gb.simulate(_mesh(True, False, c=C), t=T, **TIGHT)
    assert distance(damped["mesh.deflection"], linear["mesh.deflection"]) < NEAR


@pytest.mark.long
def test_the_answer_tends_to_the_linear_mesh_as_the_gap_shrinks(distance):
    linear = gb.simulate(_mesh(True, False, c=C), t=T, **TIGHT)["mesh.deflection"]
    model = gb.build(_mesh(True, False, c=C, backlash=gb.Backlash(half_gap=1e-6), contact_damping="always"))
    off = []
    for half_gap in (1e-8, 1e-9, 1e-10):
        run = gb.simulate(model, t=T, parameters={"mesh.backlash.half_gap": half_gap}, **TIGHT)
        off.append(distance(run["mesh.deflection"], linear))
    # the answer departs in proportion to the gap
    assert off[0] / off[1] == pytest.approx(10, rel=0.2)
    assert off[1] / off[2] == pytest.approx(10, rel=0.2)


def _on_ground(choice, b=0.1, k=400.0, c=3.0):
    """J = 1 against the ground: the deflection is the angle. Driven so that it hits both sides."""
    rig = gb.Drivetrain("one body")
    body = rig.add("body", gb.Inertia(J=1.0, w0=4.0))
    fields = {"k": k, "c": c, "contact_damping": choice}
    spline = rig.add("spline", gb.SplineCoupling(teeth=20, radius=1.0, backlash=gb.Backlash(half_gap=b), **fields))
    ground, drive = rig.add("ground", gb.Fixed()), rig.add("drive", gb.Torque(tau=12 * sp.sin(7 * gb.time)))
    rig.chain(drive, body, spline, ground)
    return rig


def _drag(choice, x, v, side, b=0.1, k=400.0, c=3.0):
    """The damping force by its words in the catalogue; side: contact from the frozen corners."""
    elastic = k * (x - side * b) if side else 0.0
    if choice == "always":
        return c * v
    if side == 0:
        return 0.0
    if choice == "clipped":
        return np.clip(c * v, -abs(elastic), abs(elastic))
    total = elastic + c * v
    return (max(total, 0.0) if side > 0 else min(total, 0.0)) - elastic


@pytest.mark.long
@pytest.mark.parametrize("choice", ["clipped", pytest.param("clipped_force", marks=pytest.mark.long), "always"])
def test_damping_in_the_gap_acts_as_its_name_says(choice, reference, distance):
    b, k, c = 0.1, 400.0, 3.0

    def side(modes):
        return 1 if modes[0] > 0 else -1 if modes[1] < 0 else 0

    def rates(t, y, modes):
        s = side(modes)
        elastic = k * (y[0] - s * b) if s else 0.0
        return y[1], 12 * np.sin(7 * t) - elastic - _drag(choice, y[0], y[1], s)

    def surfaces(t, y):
        g = k * max(abs(y[0]) - b, 0.0)
        return y[0] - b, y[0] + b, c * y[1] + g, g - c * y[1]

    t = np.linspace(0, 6, 241)
    run = gb.simulate(_on_ground(choice), t=t, **TIGHT)
    true = reference(rates, (0.0, 4.0), t, surfaces, max_step=0.005)
    # the reference passes the bend of a clipped force within a step: its own error is some 1e-9 there
    assert distance(run["body.phi"], true[:, 0]) < 1e-8
    assert distance(run["body.w"], true[:, 1]) < 1e-8
    assert run.energy.residual < 1e-11  # 10 rtol
    assert run.energy.dissipated["spline"] > 0
    hits = {(e.before, e.after) for e in run.events if {e.before, e.after} & {-1.0}}
    assert hits >= {(0.0, -1.0), (-1.0, 0.0)}
    force, x = run["spline.force"], run["spline.deflection"]
    if choice != "always":
        assert np.all(force * np.sign(x) >= -1e-9)  # teeth push, up to rounding of k x
        assert np.all(force[np.abs(x) < b] == 0)


@pytest.mark.long
def test_the_laws_of_damping_differ():
    t = np.linspace(0, 6, 241)
    ends = {
        c: gb.simulate(_on_ground(c), t=t, rtol=1e-9)["body.phi"][-1] for c in ("clipped", "clipped_force", "always")
    }
    assert (
        min(abs(a - b) for a, b in [(ends["clipped"], ends["always"]), (ends["clipped"], ends["clipped_force"])]) > 1e-3
    )


@pytest.mark.long
@pytest.mark.parametrize("external", [True, False], ids=["external", "internal"])
@pytest.mark.few(1)
def test_a_mesh_without_compliance_is_the_rigid_pair(external):
    rig = _mesh(external, False).without("mesh.compliance")
    run = gb.simulate(rig, t=[0.0, 1e-3], rtol=1e-9)
    i = -R2 / R1 if external else R2 / R1
    drive, load = 20 + 10 * np.sin(9e3 * run.t), (20 if external else -20) * R2 / R1
    alpha = (drive + load / i) / (J1 + J2 / i**2)
    assert np.allclose(run["pinion.alpha"], alpha, rtol=1e-13)
    assert np.allclose(run["wheel.alpha"], alpha / i, rtol=1e-13)
    assert np.allclose(run["mesh.force"], (drive - J1 * alpha) / R1, rtol=1e-12)


def test_the_torques_on_the_flanges_of_a_mesh_are_its_force_times_the_radii():
    run = gb.simulate(_mesh(True, True, c=C), t=T, rtol=1e-9)
    assert np.allclose(run["mesh.pinion.tau"], -R1 * run["mesh.force"], rtol=1e-13)
    assert np.allclose(run["mesh.wheel.tau"], -R2 * run["mesh.force"], rtol=1e-13)
    assert np.allclose(run["mesh.carrier.tau"], (R1 + R2) * run["mesh.force"], rtol=1e-13)


@pytest.mark.parametrize("zeta", [0.05, 0.17])
def test_the_damping_ratio_of_a_mesh_weighs_both_inertias_with_their_radii(zeta, distance):
    c = 2 * zeta * np.sqrt(K / (R1**2 / J1 + R2**2 / J2))
    ratio = gb.simulate(_mesh(True, False, damping_ratio=zeta), t=T, **TIGHT)
    explicit = gb.simulate(_mesh(True, False, c=c), t=T, **TIGHT)
    assert distance(ratio["mesh.force"], explicit["mesh.force"]) < NEAR

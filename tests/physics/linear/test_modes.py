"""Modes against closed forms: frequencies, damping, decays, free rotations."""

import numpy as np
import pytest
import scipy.linalg

import gearblocks as gb
from benchmarks.cases import P1
from benchmarks.problems import p1

NEAR = 1e-9  # central differences of laws that are linear between their corners


def _mass(J=2.0, k=500.0, c=3.0):
    """One body on a spring and damper, driven by the input tau and a constant torque."""
    rig = gb.Drivetrain("one mass")
    drive, load = rig.add("drive", gb.Torque(tau=gb.Input("tau"))), rig.add("load", gb.Torque(tau=1.0))
    body = rig.add("body", gb.Inertia(J=J))
    rig.chain(drive, load, body, rig.add("shaft", gb.Shaft(k=k, c=c)), rig.add("ground", gb.Fixed()))
    return rig


def _pair(J=(0.02, 0.05), k=2e4, c=3.0):
    rig = gb.Drivetrain("pair")
    a, b = (rig.add(n, gb.Inertia(J=j)) for n, j in zip("ab", J, strict=True))
    rig.chain(a, rig.add("shaft", gb.Shaft(k=k, c=c)), b)
    return rig


def _chain(n, J=0.1, k=1e4, c=None):
    """n equal bodies in a row of equal springs, the last one to the ground."""
    rig = gb.Drivetrain("chain")
    links = []
    for i in range(n):
        links += [rig.add(f"body{i}", gb.Inertia(J=J)), rig.add(f"spring{i}", gb.Shaft(k=k, c=c))]
    rig.chain(*links, rig.add("ground", gb.Fixed()))
    return rig


def _chain_frequencies(n, J=0.1, k=1e4):
    return 2 * np.sqrt(k / J) * np.sin((2 * np.arange(1, n + 1) - 1) * np.pi / (2 * (2 * n + 1)))


def test_two_discs_swing_at_the_known_frequency_and_damping():
    J, k, c = (0.02, 0.05), 2e4, 3.0
    found = gb.modes(_pair(J, k, c))
    compliance = 1 / J[0] + 1 / J[1]
    w = np.sqrt(k * compliance)
    assert found.free == 1
    assert found.frequencies[0] == found.damping[0] == 0.0
    assert found.bound < 1e-9 * w  # what rounding made of the zero
    assert found.frequencies[1] == pytest.approx(w, rel=NEAR)
    assert found.damping[1] == pytest.approx(c * compliance / (2 * w), rel=NEAR)
    assert found.shapes[0] == pytest.approx([1, 1], rel=1e-12)
    assert found.shapes[1] == pytest.approx([1, -J[0] / J[1]], rel=NEAR)
    assert found.kinetic[1] == pytest.approx([J[1] / sum(J), J[0] / sum(J)], rel=NEAR)
    assert found.strain == pytest.approx(np.array([[0.0], [1.0]]), abs=1e-12)


@pytest.mark.long
def test_gears_carry_inertia_over_by_the_square_of_their_ratio():
    rig = gb.Drivetrain("geared")
    a, b, c = (rig.add(n, gb.Inertia(J=j)) for n, j in zip("abc", (0.01, 0.02, 0.3), strict=True))
    rig.chain(a, rig.add("gear", gb.IdealGear(ratio=-3.0)), b, rig.add("shaft", gb.Shaft(k=1e4)), c)
    found = gb.modes(rig)
    left = 0.02 + 9 * 0.01
    assert found.frequencies[1] == pytest.approx(np.sqrt(1e4 * (1 / left + 1 / 0.3)), rel=NEAR)
    assert found.shapes[1][found.bodies.index("a")] == pytest.approx(1.0)
    assert found.shapes[1][found.bodies.index("b")] == pytest.approx(-1 / 3, rel=NEAR)


@pytest.mark.parametrize("n", [5, 60])
@pytest.mark.few(1)
def test_an_even_chain_has_the_frequencies_of_the_closed_form(n):
    found = gb.modes(_chain(n))
    assert found.frequencies == pytest.approx(_chain_frequencies(n), rel=1e-8)
    assert found.free == 0
    assert found.kinetic.sum(axis=1) == pytest.approx(np.ones(n), rel=1e-12)
    assert found.strain.sum(axis=1) == pytest.approx(np.ones(n), rel=1e-12)


@pytest.mark.long
def test_a_long_chain_gives_its_lowest_modes_without_a_full_matrix():
    n = 1500
    found = gb.modes(_chain(n, c=0.01), count=5)
    assert found.frequencies == pytest.approx(_chain_frequencies(n)[:5], rel=1e-7)
    assert found.damping == pytest.approx(0.01 / 1e4 * found.frequencies / 2, rel=1e-4)  # 1e-9, beside rounding 1e-13
    linear = gb.linearize(_chain(n, c=0.01), outputs=["body0.w"])
    assert linear.A.nnz < 10 * n


@pytest.mark.long
def test_the_modes_of_the_spline_problem_are_those_of_its_matrices():
    p = P1()
    K = np.zeros((4, 4))
    for i, k in enumerate((p.k_shaft, p.k_mesh * p.radius**2, p.k_shaft)):
        K[i : i + 2, i : i + 2] += k * np.array([[1, -1], [-1, 1]])
    squares, shapes = scipy.linalg.eigh(K, np.diag(p.J))
    found = gb.modes(p1().without("*.damping"))
    assert found.frequencies[1:] == pytest.approx(np.sqrt(squares[1:]), rel=1e-8)
    for i in (1, 2, 3):
        assert found.shapes[i] == pytest.approx(shapes[:, i] / shapes[np.argmax(np.abs(shapes[:, i])), i], abs=1e-6)
        parts = np.diff(shapes[:, i]) ** 2 * [p.k_shaft, p.k_mesh * p.radius**2, p.k_shaft]
        ours = dict(zip(found.elements, found.strain[i], strict=True))
        assert [ours[n] for n in ("left", "mesh", "right")] == pytest.approx(parts / parts.sum(), abs=1e-6)


def test_motions_that_do_not_swing_are_decays():
    rig = gb.Drivetrain("dragging")
    a = rig.add("a", gb.Inertia(J=2.0))
    rig.chain(a, rig.add("drag", gb.Damper(c=3.0)), rig.add("ground", gb.Fixed()))
    found = gb.modes(rig)
    assert len(found) == found.free == 0
    assert found.decays == pytest.approx([1.5], rel=NEAR)
    heavy = gb.modes(_mass(J=2.0, k=500.0, c=200.0))
    root = np.sqrt(100.0**2 - 500 * 2)
    assert heavy.decays == pytest.approx([(100 - root) / 2, (100 + root) / 2], rel=1e-7)  # a difference of near numbers


@pytest.mark.long
def test_a_damper_takes_one_free_rotation_only_however_the_free_ones_mix():
    # a differential with every shaft free, a damper (and a spring beside it) between two of the four bodies
    rig = gb.Drivetrain("free differential")
    split = rig.add("split", gb.Differential(ratio=3.7))
    case, left, right, end = (
        rig.add(n, gb.Inertia(J=j, w0=w))
        for n, j, w in (("case", 2.8, None), ("left", 2.4, 0.3), ("right", 0.8, -0.7), ("end", 2.9, 0.2))
    )
    rig.connect(split.carrier, case.a)
    rig.connect(split.left, left.a)
    rig.connect(split.right, right.a)
    mesh = rig.add(
        "mesh", gb.GearMesh(teeth=(30, 24), external=True, r_base=(0.05, 0.04), k=8e4)
    )  # its carrier is the left shaft
    rig.connect(mesh.pinion, right.b)
    rig.connect(mesh.wheel, end.a)
    rig.connect(mesh.carrier, left.b)
    drag = rig.add("drag", gb.Damper(c=1.3))
    rig.connect(drag.a, right.b)
    rig.connect(drag.b, end.b)
    # three degrees of freedom, one strained by the mesh; of the two others the damper hinders one
    modes = gb.modes(rig, at=None)
    assert modes.free == 1
    assert len(modes) == 2
    assert len(modes.decays) == 1


@pytest.mark.long
def test_a_mesh_strained_by_every_free_rotation_takes_one_of_them_however_stiff_it_is():
    rig = gb.Drivetrain("mesh on a differential")
    mesh = rig.add("mesh", gb.GearMesh(teeth=(54, 43), external=True, r_base=(0.054, 0.043), k=4.7e4, c=82.0))
    fork, planet = rig.add("fork", gb.Differential(ratio=3.7)), rig.add("planet", gb.IdealPlanetary(ratio=1.5))
    J = {"a": 0.79, "b": 1.94, "c": 0.72, "d": 2.81, "e": 2.37, "f": 2.85}
    a, b, c, d, e, f = (rig.add(name, gb.Inertia(J=J[name])) for name in J)
    damper = rig.add("damper", gb.Damper(c=1.54))
    rig.connect(a.a, mesh.pinion, damper.a, fork.right, planet.carrier)
    rig.connect(f.a, mesh.wheel, damper.b)
    rig.connect(e.a, mesh.carrier, fork.left)
    rig.connect(d.a, fork.carrier)
    rig.connect(b.a, planet.sun)
    rig.connect(c.a, planet.ring)
    # four degrees of freedom, two of them free: the mesh strains one, the damper hinders one more
    assert gb.modes(rig, at=None).free == 2


@pytest.mark.long
def test_a_free_train_whose_law_reads_its_angle_turns_freely_too():
    class Spring(gb.Block):
        a, b = gb.Flange("left end"), gb.Flange("right end")
        k: float = gb.param("stiffness", "N m/rad")

        def physics(self, s):
            yield gb.Potential(s.k * (s.b.phi - s.a.phi) ** 2 / 2)
            yield gb.Energy(stored=s.k * (s.b.phi - s.a.phi) ** 2 / 2)

    rig = gb.Drivetrain("by angles")
    a, b = (rig.add(n, gb.Inertia(J=j)) for n, j in zip("ab", (0.02, 0.05), strict=True))
    rig.chain(a, rig.add("spring", Spring(k=2e4)), b)
    found = gb.modes(rig)
    w = np.sqrt(2e4 * (1 / 0.02 + 1 / 0.05))
    assert found.free == 1
    assert found.bound < 1e-6 * w  # a double zero: the square root of rounding
    assert found.frequencies == pytest.approx([0.0, w], rel=NEAR)


def test_the_table_of_modes_names_what_moves_and_what_is_strained():
    lines = str(gb.modes(_pair())).splitlines()
    assert lines[0] == "pair: 2 modes, 1 of them free rotation"
    assert " ".join(lines[3].split()) == "1 188.315 1183.22 8.87 % a 1.00, b 0.40 shaft 100 %"


@pytest.mark.long
@pytest.mark.parametrize("at", [0.0, 0.4, 1.2])
def test_modes_at_a_position_of_a_universal_joint(at):
    """A body on a spring on either side of the joint, and torques in balance: with the ratio m = dphi_b/dphi_a,
    (J_a + J_b m^2) x'' + (k_a + k_b m^2 - tau dm/dphi_a) x = 0."""
    angle, tau, J, k = 0.8, 40.0, (2.0, 0.5), (500.0, 900.0)
    inner = 1 - np.sin(angle) ** 2 * np.cos(at) ** 2  # of tan phi_b = tan phi_a / cos(angle)
    m = np.cos(angle) / inner
    bend = -np.cos(angle) * np.sin(angle) ** 2 * np.sin(2 * at) / inner**2
    rig = gb.Drivetrain("joint")
    a, b = rig.add("a", gb.Inertia(J=J[0], phi0=at)), rig.add("b", gb.Inertia(J=J[1]))
    rig.chain(rig.add("back", gb.Torque(tau=-m * tau)), a, rig.add("joint", gb.UniversalJoint(angle=angle)), b)
    rig.connect(rig.add("load", gb.Torque(tau=tau)).flange, b.b)
    for name, body, stiffness, phi in (
        ("one", a, k[0], at),
        ("two", b, k[1], np.arctan2(np.sin(at) / np.cos(angle), np.cos(at))),
    ):
        rig.chain(body, rig.add(name, gb.Shaft(k=stiffness)), rig.add(f"{name}_ground", gb.Fixed(phi0=phi)))
    found = gb.modes(rig, at=None)
    true = np.sqrt((k[0] + k[1] * m**2 - tau * bend) / (J[0] + J[1] * m**2))
    assert found.frequencies == pytest.approx([true], rel=1e-12)  # from the derivatives of the laws: rounding alone
    assert found.damping == pytest.approx([0.0], abs=1e-12)


@pytest.mark.long
@pytest.mark.parametrize("c", [pytest.param(None, marks=pytest.mark.long), 1.5])
def test_a_node_without_inertia_between_two_shafts_puts_them_in_series(c):
    J, k = 0.5, 200.0
    rig = gb.Drivetrain("series")
    load, body = rig.add("load", gb.Torque(tau=gb.Input("T"))), rig.add("body", gb.Inertia(J=J))
    soft, hard = rig.add("soft", gb.Shaft(k=k)), rig.add("hard", gb.Shaft(k=3 * k, c=c))
    rig.chain(load, body, soft, hard, rig.add("ground", gb.Fixed()))
    w = np.logspace(0, 3, 7)
    series = 1 / (1 / k + 1 / (3 * k + (c or 0.0) * 1j * w))
    for at in (None, "static"):
        found = gb.frequency_response(rig, "T", ["body.phi", "soft.twist"], w, at=at)
        assert np.abs(found["body.phi"] * (series - J * w**2) - 1).max() < 1e-9
        assert np.abs(-found["soft.twist"] * k / series * (series - J * w**2) - 1).max() < 1e-9
    swing = gb.modes(rig)
    assert len(swing.decays) == (0 if c is None else 1)
    roots = np.roots([J * (c or 0.0), J * 4 * k, k * (c or 0.0), 3 * k**2])  # J s^2 (4 k + c s) + k (3 k + c s)
    assert np.abs(swing.eigenvalues[0] - roots).min() < 1e-9 * swing.frequencies[0]


@pytest.mark.long
def test_a_stiffness_over_the_angle_is_that_at_an_angle_which_the_table_names():
    J, k, radii = (1e-3, 5e-3), 2e8, (0.03, 0.03 * 41 / 23)
    wave = gb.Fourier(sin=(0.2,))
    mesh = gb.GearMesh(teeth=(23, 41), r_base=radii, external=True, k=k, stiffness_variation=wave)
    rig = gb.Drivetrain("pair")
    pinion, wheel = (rig.add(n, gb.Inertia(J=j)) for n, j in zip(("pinion", "wheel"), J, strict=True))
    rig.chain(pinion, rig.add("mesh", mesh), wheel)
    gains = sum(r**2 / j for r, j in zip(radii, J, strict=True))
    for angle in (0.0, 0.05):
        found = gb.modes(rig, at={"pinion.phi": angle, "wheel.phi": -angle * 23 / 41})  # without load: a free rotation
        assert found.free == 1 and found.tied == 0
        assert found.frequencies[1] == pytest.approx(np.sqrt(k * (1 + 0.2 * np.sin(23 * angle)) * gains), rel=1e-7)
        assert found.angles == pytest.approx({"pinion.phi": angle})
        assert f"laws over the angle, as of a mesh cycle, are those at pinion.phi = {angle:.6g} rad" in str(found)
    rig.connect(rig.add("drive", gb.Torque(tau=20.0)).flange, pinion.a)
    rig.connect(rig.add("load", gb.Torque(tau=20.0 * 41 / 23)).flange, wheel.b)
    loaded = gb.modes(rig)  # k'(phi) g^2/2 turns the pair
    assert loaded.free == 0 and loaded.tied == 1 and "; 1 rotation is not free" in str(loaded)
    still = gb.modes(rig, frozen_angles=True)
    angle = still.angles["pinion.phi"]
    assert still.free == 1 and still.tied == 0 and "not free" not in str(still)
    there, slope = k * (1 + 0.2 * np.sin(23 * angle)), k * 0.2 * 23 * np.cos(23 * angle)
    deflection = 20.0 / radii[0] / there  # the potential k x^2/2 turns the pinion by k' x^2/2, whose slope over x stays
    expected = np.sqrt(there * gains + slope * deflection * radii[0] / J[0])
    assert still.frequencies[1] == pytest.approx(expected, rel=1e-7)
    assert gb.modes(_pair()).angles == {}


def _free_planetary(k, wave, planets=3):
    teeth = {"z_sun": 42, "z_planet": 18, "z_ring": 78, "module": "2 mm", "pressure_angle": "20 deg"}
    law = gb.MeshLaw(k=k, damping_ratio=0.05, stiffness_variation=wave)
    gear = gb.PlanetaryGear(**teeth, planet_inertia="1 kg cm2", sun_mesh=law, ring_mesh=law, planets=planets)
    rig = gb.Drivetrain("planetary")
    sun, carrier = rig.add("motor", gb.Inertia(J=1e-3)), rig.add("load", gb.Inertia(J=1e-2))
    stage, case = rig.add("gear", gear), rig.add("case", gb.Fixed())
    drive, brake = rig.add("drive", gb.Torque(tau=50.0)), rig.add("brake", gb.Torque(tau=-50.0 * (1 + 78 / 42)))
    rig.connect(drive.flange, sun.a)
    rig.connect(sun.b, stage.sun)
    rig.connect(stage.ring, case.flange)
    rig.connect(stage.carrier, carrier.a, brake.flange)
    return rig


def test_with_frozen_angles_a_planetary_has_the_modes_of_one_whose_stiffness_is_constant():
    wave = gb.Fourier(cos=(0.15,))
    turning = gb.modes(_free_planetary(3e8, wave))
    assert turning.free == 0 and turning.tied == 1
    still = gb.modes(_free_planetary(3e8, wave), frozen_angles=True)
    assert still.free == 1 and still.tied == 0 and still.frozen
    # phases that stand, as at the start; the load winds the angles up by some microradians
    even = gb.modes(_free_planetary(3e8, wave.changed(driven_by=0.0)), frozen_angles=True)
    assert even.free == 1 and even.tied == 0 and even.angles == {}
    assert still.frequencies == pytest.approx(even.frequencies, rel=1e-5)
    assert still.damping[1:] == pytest.approx(even.damping[1:], rel=1e-4)


def test_with_frozen_angles_gravity_restores_nothing():
    rig = gb.Drivetrain("pendulum")
    rig.add("bob", gb.Inertia(J=0.5, phi0=0.2))
    rig.add("gravity", gb.Torque(tau=-3.0 * gb.sin(gb.sense("bob.phi"))))
    rig.connect(rig["gravity"].flange, rig["bob"].a)
    assert gb.modes(rig, at=None).frequencies == pytest.approx([np.sqrt(3.0 * np.cos(0.2) / 0.5)], rel=1e-7)
    still = gb.modes(rig, at=None, frozen_angles=True)
    assert still.free == 1 and still.frequencies == pytest.approx([0.0], abs=0)


def test_a_mode_is_asked_for_by_its_number():
    rig = gb.Drivetrain("two")
    rig.chain(rig.add("a", gb.Inertia(J=1.0)), rig.add("axle", gb.Shaft(k=8.0)), rig.add("b", gb.Inertia(J=1.0)))
    modes = gb.modes(rig)
    mode = modes[1]
    assert mode == modes[-1] and [x.number for x in modes] == [0, 1]
    assert mode.frequency == pytest.approx(4.0, rel=1e-12) and mode.hertz == modes.hertz[1]
    assert mode.strain == {"axle": 1.0} and mode.kinetic == pytest.approx({"a": 0.5, "b": 0.5})
    assert mode.shape["a"] == pytest.approx(-mode.shape["b"], rel=1e-12)
    with pytest.raises(IndexError, match=r"modes\[2\]: .* is numbered from 0 to 1"):
        modes[2]

"""Linear tools against closed forms: state matrices, modes, frequency response, Campbell diagrams."""

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


# -- state matrices ---------------------------------------------------------------------------------------------------


def test_one_mass_has_the_matrices_of_the_textbook():
    J, k, c = 2.0, 500.0, 3.0
    found = gb.linearize(_mass(J, k, c), outputs=["shaft.twist", "body.alpha"], inputs=["tau", "load.tau"])
    assert found.states == ("shaft.coordinate", "body.w")
    assert found.outputs == ("shaft.twist", "body.alpha")
    motion, force = [k / J, -c / J], [[0, 0], [1 / J, 1 / J]]
    for ours, true in (
        (found.A, [[0, -1], motion]),  # the coordinate is the twist phi_ground - phi_body
        (found.B, force),
        (found.C, [[1, 0], motion]),
        (found.D, force),
    ):
        assert np.abs(ours - np.array(true)).max() < NEAR * max(1.0, k / J)
    assert found.point["shaft.coordinate"] == pytest.approx(-1.0 / k, rel=1e-12)


def test_a_run_can_be_linearised_where_it_ends_and_contacts_keep_their_side():
    run = gb.simulate(p1(), t_end=0.01, outputs=["mesh.contact"])
    found = gb.linearize(p1(), run)
    assert found.t == 0.01
    assert found.modes == {"mesh": run["mesh.contact"][-1]}
    assert ("drive side" in str(found)) == (found.modes["mesh"] == 1.0)
    k = 245e6 * (1 + 0.3 * np.cos(P1().w * 0.01)) * abs(found.modes["mesh"])
    row, column = found.states.index("disc2.w"), found.states.index("mesh.coordinate")
    # the step of a difference is 6e-6 of 1e-3 rad: rounding of torques of 2600 N m leaves 1e-9 of k
    assert abs(found.A[row, column]) == pytest.approx(k * 0.025**2 / 2e-4, rel=1e-8, abs=1.0)


def test_at_start_values_excitations_stand_as_at_t_and_in_equilibrium_at_their_means():
    column = ("disc2.w", "mesh.coordinate")
    for at, factor in ((None, 1.3), ("static", 1.0), ("static_at_start", 1.3), ({"disc1.w": 0.0}, 1.3)):
        found = gb.linearize(p1(), at)
        entry = found.A[found.states.index(column[0]), found.states.index(column[1])]
        assert abs(entry) == pytest.approx(factor * 245e6 * 0.025**2 / 2e-4, rel=1e-8), at


def test_angles_are_states_only_where_an_output_asked_for_needs_them():
    whole = gb.linearize(_pair())
    assert whole.states == ("shaft.coordinate", "a.w", "b.w")
    assert "a.phi" not in whole.outputs
    found = gb.linearize(_pair(), outputs=["b.phi"])
    assert found.A.shape == (4, 4)
    assert found.states[3].endswith(".phi")
    assert found.A[3, found.states.index(f"{found.states[3][0]}.w")] == pytest.approx(1.0, rel=NEAR)


def test_names_that_nothing_carries_are_refused():
    with pytest.raises(gb.UnknownNameError, match="no input or tunable parameter 'tao'"):
        gb.linearize(_mass(), inputs=["tao"])
    with pytest.raises(gb.UnknownNameError, match="no output matches"):
        gb.linearize(_mass(), outputs=["shaft.twst"])
    with pytest.raises(gb.ParameterError, match="count = 0"):
        gb.modes(_pair(), count=0)


# -- modes ------------------------------------------------------------------------------------------------------------


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
def test_an_even_chain_has_the_frequencies_of_the_closed_form(n):
    found = gb.modes(_chain(n))
    assert found.frequencies == pytest.approx(_chain_frequencies(n), rel=1e-8)
    assert found.free == 0
    assert found.kinetic.sum(axis=1) == pytest.approx(np.ones(n), rel=1e-12)
    assert found.strain.sum(axis=1) == pytest.approx(np.ones(n), rel=1e-12)


def test_a_long_chain_gives_its_lowest_modes_without_a_full_matrix():
    n = 1500
    found = gb.modes(_chain(n, c=0.01), count=5)
    assert found.frequencies == pytest.approx(_chain_frequencies(n)[:5], rel=1e-7)
    assert found.damping == pytest.approx(0.01 / 1e4 * found.frequencies / 2, rel=1e-4)  # 1e-9, beside rounding 1e-13
    linear = gb.linearize(_chain(n, c=0.01), outputs=["body0.w"])
    assert linear.A.nnz < 10 * n


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


# -- frequency response -----------------------------------------------------------------------------------------------


def test_one_mass_answers_as_the_formula_says():
    J, k, c = 2.0, 500.0, 3.0
    w = np.geomspace(0.1, 1e3, 50)
    true = 1 / (k - J * w**2 + 1j * c * w)
    for source in ("tau", "load.tau"):
        found = gb.frequency_response(_mass(J, k, c), source, ["body.phi", "shaft.torque", "body.alpha"], w)
        assert np.abs(found["body.phi"] / true - 1).max() < 1e-8  # at 1e3 rad/s J w^2 is 4000 k
        assert np.abs(found["shaft.torque"] / ((k + 1j * c * w) * true) - 1).max() < 1e-8
        assert np.abs(found["body.alpha"] / (-(w**2) * true) - 1).max() < 1e-8


def test_the_response_is_that_of_a_long_run():
    rig, w = _mass(), 12.0
    driven = rig.set({"load": gb.Torque(tau=0.5 * gb.cos(w * gb.time))})
    t = 60.0 + np.linspace(0, 2 * np.pi / w, 64, endpoint=False)  # exp(-0.75 60) of the start is left
    run = gb.simulate(driven, t=t, rtol=1e-10, outputs=["shaft.torque"])
    response = gb.frequency_response(rig, "load.tau", ["shaft.torque"], [w])["shaft.torque"][0]
    assert run["shaft.torque"] == pytest.approx((0.5 * response * np.exp(1j * w * t)).real, abs=1e-8 * abs(response))


def test_a_response_without_bound_is_refused():
    with pytest.raises(gb.ParameterError, match="no bound"):
        gb.frequency_response(_mass(c=None, k=8.0), "tau", ["body.w"], [2.0])
    with pytest.raises(gb.UnknownNameError):
        gb.frequency_response(_mass(), "tau", ["body.w"], [2.0])["shaft.torque"]


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
    speeds = gb.rpm(np.linspace(10, 30000, 31))
    found = gb.campbell(rig, "motor.w", speeds)
    assert found.orders == pytest.approx({
        "shaft of motor, pinion": 1.0, "shaft of wheel": 23 / 41, "teeth of mesh": 23.0
    }, rel=1e-8)  # fmt: skip
    swinging = gb.modes(rig).frequencies[1:]
    assert found.frequencies == pytest.approx(np.tile(swinging, (31, 1)), rel=1e-6)
    mesh = [c for c in found.crossings if c.order == "teeth of mesh"]
    assert [c.speed for c in mesh] == pytest.approx(swinging / 23, rel=1e-6)
    assert [c.mode for c in mesh] == [1, 2]
    assert gb.campbell(rig, "motor.w", speeds, reference="wheel").orders["teeth of mesh"] == pytest.approx(41.0)


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
    with pytest.raises(gb.ParameterError, match="cannot turn freely"):
        gb.campbell(rig, "speed", speeds)


# -- pictures ---------------------------------------------------------------------------------------------------------


def test_every_tool_draws_a_picture(tmp_path):
    rig = _geared_pair()
    with_input = rig.set({})
    gb.modes(with_input).plot(tmp_path / "modes.png")
    gb.campbell(rig, "motor.w", gb.rpm(np.linspace(10, 3000, 5))).plot(tmp_path / "campbell.svg")
    gb.frequency_response(_mass(), "tau", "shaft.*", [1.0, 10.0, 100.0]).plot(tmp_path / "bode.pdf")
    assert sorted(p.suffix for p in tmp_path.iterdir()) == [".pdf", ".png", ".svg"]


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


# -- prescribed motions, shafts without inertia ------------------------------------------------------------------------


def test_a_body_that_a_filtered_speed_shakes_answers_as_the_formula_says():
    J, k, c, cut = 0.5, 200.0, 1.5, 50.0
    rig = gb.Drivetrain("shaken")
    base = rig.add("base", gb.Speed(w=gb.Input("u", start=2.0), filter=cut))
    rig.chain(base, rig.add("shaft", gb.Shaft(k=k, c=c)), rig.add("body", gb.Inertia(J=J, w0=2.0)))
    w = np.logspace(0, 3, 7)
    s = 1j * w
    for at in (None, "static"):
        found = gb.frequency_response(rig, "u", "body.w", w, at=at)["body.w"]
        true = (k + c * s) / (J * s**2 + c * s + k) * cut / (s + cut)
        assert np.abs(found / true - 1).max() < 1e-9  # the input's column is a difference
        matrices = gb.linearize(rig, at, outputs=["shaft.twist"])
        assert matrices.states == ("shaft.coordinate", "base.filtered_speed", "body.w")
        true = [[0, -1, 1], [0, -cut, 0], [-k / J, c / J, -c / J]]
        assert np.abs(matrices.A - np.array(true)).max() < 1e-12 * k / J


def test_a_support_that_time_moves_carries_like_the_ground():
    J, k, c = 0.5, 200.0, 1.5
    w = np.logspace(0, 3, 7)
    for phi in (0.1 * gb.sin(30 * gb.time), 0.0):
        rig = gb.Drivetrain("rocked")
        load = rig.add("load", gb.Torque(tau=gb.Input("T")))
        base, body = rig.add("base", gb.Angle(phi=phi)), rig.add("body", gb.Inertia(J=J))
        rig.chain(base, rig.add("shaft", gb.Shaft(k=k, c=c)), body, load)
        found = gb.frequency_response(rig, "T", "body.phi", w)["body.phi"]
        assert np.abs(found * (k + 1j * c * w - J * w**2) - 1).max() < 1e-9
        assert gb.modes(rig, None).frequencies == pytest.approx([np.sqrt(k / J)], rel=1e-12)


@pytest.mark.parametrize("c", [None, 1.5])
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

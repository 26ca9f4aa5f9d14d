"""State matrices against those of the textbook, and what of a run they keep."""

import numpy as np
import pytest

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


def test_what_reaches_no_free_end_is_zero_in_the_matrices():
    rig = gb.Drivetrain("one")
    rig.chain(
        rig.add("disc", gb.Inertia(J=1.0, w0=1.0)), rig.add("spring", gb.Shaft(k=4.0, c=0.1)),
        rig.add("ground", gb.Fixed()),
    )  # fmt: skip
    found = gb.linearize(rig, at=None)
    rows = dict(zip(found.outputs, found.C, strict=True))
    for name in (
        "disc.a.tau",
        "disc.a.power",
        "ground.flange.power",
    ):  # J w' less what the spring gives, twice the same
        assert not rows[name].any(), name
    assert rows["disc.b.tau"] == pytest.approx([-4.0, 0.1], rel=1e-9) and rows["spring.loss_power"][1] != 0

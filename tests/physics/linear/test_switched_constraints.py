"""Linear tools where friction sticks or slides and stops are closed: what is active acts as a rigid constraint."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.operating_point import operating_point
from gearblocks.solver.point import differenced_state_matrix, state_matrix
from gearblocks.train.handles import FlangeHandle

NEAR = 1e-9
"""Of matrices from the derivatives of laws: rounding of a few terms, seen through eigenvalues."""


def _chain(J, k, clutch):
    """Discs in a row on shafts, the last one to the ground; `clutch` between the second and the third one."""
    rig = gb.Drivetrain("row")
    discs = [rig.add(f"disc{i + 1}", gb.Inertia(J=x)) for i, x in enumerate(J)]
    shafts = [rig.add(f"shaft{i + 1}", gb.Shaft(k=x)) for i, x in enumerate(k)]
    rig.chain(rig.add("drive", gb.Torque(tau=gb.Input("tau"))), discs[0], shafts[0], discs[1])
    if clutch is None:
        rig.connect(discs[1].b, discs[2].a)
    else:
        rig.chain(discs[1], rig.add("clutch", clutch), discs[2])
    rig.chain(*(x for pair in zip(discs[2:], shafts[1:], strict=True) for x in pair), rig.add("wall", gb.Fixed()))
    return rig


@pytest.mark.long
def test_a_stuck_clutch_between_two_discs_on_a_spring_makes_one_disc_of_them():
    rig = gb.Drivetrain("pair")
    one, two = rig.add("one", gb.Inertia(J=2.0)), rig.add("two", gb.Inertia(J=3.0))
    rig.chain(one, rig.add("clutch", gb.Clutch(capacity=50.0)), two, rig.add("shaft", gb.Shaft(k=500.0, c=2.0)))
    rig.connect(rig.add("wall", gb.Fixed()).flange, FlangeHandle(rig, "shaft", "b"))
    found = gb.modes(rig)
    assert (found.free, len(found)) == (0, 1)
    assert found.frequencies[0] == pytest.approx(np.sqrt(500.0 / 5.0), rel=NEAR)
    assert found.damping[0] == pytest.approx(2.0 / (2 * np.sqrt(500.0 * 5.0)), rel=NEAR)
    assert np.abs(found.shapes[0]) == pytest.approx([1.0, 1.0], rel=NEAR)
    assert found.kinetic[0] == pytest.approx([0.4, 0.6], rel=NEAR)
    linear = gb.linearize(rig)
    assert len(linear.states) == 2
    assert linear.modes["clutch"] == 0.0
    assert "clutch: stuck" in str(linear)


J4, K3 = (0.7, 1.3, 2.1, 0.4), (900.0, 1500.0, 400.0)


def _by_hand(J, k):
    """Frequencies of three discs, the middle one with both inertias, on springs in a row to the ground."""
    M = np.diag([J[0], J[1] + J[2], J[3]])
    K = np.array([[k[0], -k[0], 0], [-k[0], k[0] + k[1], -k[1]], [0, -k[1], k[1] + k[2]]])
    return np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real))


@pytest.mark.long
def test_frequencies_with_a_stuck_clutch_are_those_of_the_rigid_train():
    stuck, rigid = (gb.modes(_chain(J4, K3, x)) for x in (gb.Clutch(capacity=50.0), None))
    assert stuck.frequencies == pytest.approx(_by_hand(J4, K3), rel=NEAR)
    assert stuck.frequencies == pytest.approx(rigid.frequencies, rel=NEAR)
    assert len(stuck.decays) == len(rigid.decays) == 0


def test_the_response_through_a_stuck_clutch_is_that_of_the_rigid_train():
    w = np.array([0.0, 3.0, 40.0])
    outputs = ["disc4.w", "shaft3.twist"]
    stuck, rigid = (
        gb.frequency_response(_chain(J4, K3, x), "tau", outputs, w) for x in (gb.Clutch(capacity=50.0), None)
    )
    assert np.abs(stuck.values - rigid.values).max() < NEAR * np.abs(rigid.values).max()
    assert abs(stuck["shaft3.twist"][0]) == pytest.approx(1 / K3[2], rel=NEAR)  # 1 N m goes all the way to the ground


@pytest.mark.long
def test_a_sliding_clutch_acts_by_the_slope_of_its_friction():
    rig = gb.Drivetrain("pair")
    one, two = rig.add("one", gb.Inertia(J=2.0, w0=10.0)), rig.add("two", gb.Inertia(J=3.0))
    mu = gb.Table([0.0, 20.0], [0.3, 0.5])
    rig.chain(one, rig.add("clutch", gb.Clutch(mu=mu, force_max=100.0, engagement=1.0)), two)
    slope = 100.0 * 0.2 / 20.0
    found = gb.linearize(rig, None)
    i, j = (found.states.index(name) for name in ("one.w", "two.w"))
    expected = slope * np.array([[-1 / 2, 1 / 2], [1 / 3, -1 / 3]])
    assert found.A[np.ix_([i, j], [i, j])] == pytest.approx(expected, rel=NEAR)
    assert found.modes["clutch"] == -1.0
    whole = gb.modes(rig, None)
    assert whole.free == 1  # what turns along feels no slip
    assert whole.decays == pytest.approx([slope * (1 / 2 + 1 / 3)], rel=NEAR)


@pytest.mark.long
@pytest.mark.parametrize(("speeds", "capacity", "free"), [((0, 0), 5.0, 1), ((4.0, 0), 5.0, 2), ((0, 0), 0.0, 2)])
def test_free_rotations_are_counted_as_what_holds_allows(speeds, capacity, free):
    rig = gb.Drivetrain("pair")
    one, two = (rig.add(n, gb.Inertia(J=1.0, w0=w)) for n, w in zip(("one", "two"), speeds, strict=True))
    rig.chain(one, rig.add("clutch", gb.Clutch(capacity=capacity)), two)
    assert gb.modes(rig, None).free == free
    rig.connect(one.a, rig.add("brake", gb.Brake(capacity=3.0)).a)
    assert gb.modes(rig, None).free == free - (speeds[0] == 0)


@pytest.mark.long
def test_a_stuck_clutch_beside_a_spring_leaves_the_spring_no_part():
    rig = gb.Drivetrain("pair")
    one, two = rig.add("one", gb.Inertia(J=2.0)), rig.add("two", gb.Inertia(J=3.0))
    rig.chain(one, rig.add("clutch", gb.Clutch(capacity=50.0)), two)
    rig.chain(one, rig.add("shaft", gb.Shaft(k=500.0)), two)
    found = gb.linearize(rig)
    assert found.A.shape == (1, 1)
    assert found.A[0, 0] == 0.0
    assert len(gb.modes(rig)) == gb.modes(rig).free == 1


def test_a_closed_stop_is_a_tie_and_an_open_one_is_nothing():
    def rig(load):
        rig = gb.Drivetrain("stop")
        one, two = rig.add("one", gb.Inertia(J=2.0)), rig.add("two", gb.Inertia(J=3.0))
        stop = rig.add("stop", gb.HardStop(lower=-0.1, upper=0.2, restitution=0.5))
        rig.chain(rig.add("load", gb.Torque(tau=load)), one, rig.add("shaft", gb.Shaft(k=500.0)), two)
        rig.connect(stop.a, two.b)
        rig.chain(two, rig.add("soft", gb.Shaft(k=20.0)), rig.add("wall", gb.Fixed()))
        return rig

    closed, opened = gb.modes(rig(10.0)), gb.modes(rig(1.0))
    assert closed.frequencies == pytest.approx([np.sqrt(500.0 / 2.0)], rel=NEAR)
    K = np.array([[500.0, -500.0], [-500.0, 520.0]])
    by_hand = np.sqrt(np.sort(np.linalg.eigvals(np.diag([1 / 2, 1 / 3]) @ K).real))
    assert opened.frequencies == pytest.approx(by_hand, rel=NEAR)
    assert gb.linearize(rig(10.0)).modes["stop.upper"] == 1.0
    assert gb.linearize(rig(1.0)).modes["stop.upper"] == 0.0


def _mixed():
    """A stuck clutch, a sliding brake and a gear in one train."""
    rig = gb.Drivetrain("mixed")
    one, two, three = (rig.add(n, gb.Inertia(J=J, w0=2.0)) for n, J in (("one", 0.7), ("two", 1.3), ("three", 2.1)))
    four = rig.add("four", gb.Inertia(J=0.4))
    mu = gb.Table([0.0, 10.0], [0.2, 0.3])
    rig.chain(one, rig.add("shaft", gb.Shaft(k=50.0, c=0.2)), two, rig.add("clutch", gb.Clutch(capacity=30.0)), three)
    rig.chain(three, rig.add("gear", gb.IdealGear(teeth=(10, 23), external=True)), four)
    rig.connect(rig.add("brake", gb.Brake(mu=mu, force_max=20.0, engagement=1.0)).a, four.b)
    return rig


@pytest.mark.long
def test_the_matrix_is_that_of_central_differences_where_something_holds():
    with operating_point(gb.build(_mixed()), None) as point:
        assert len(point.active_set()) == 1
        exact, differences = state_matrix(point).toarray(), differenced_state_matrix(point).toarray()
    # differences: rounding of torques of 10 N m over steps of 6e-6
    assert np.abs(exact - differences).max() < 1e-8 * np.abs(exact).max()


@pytest.mark.long
def test_what_holds_is_a_tie_where_gains_change_with_the_angle():
    """Two discs that a non-circular pair ties to a third one, braked or clutched to it."""
    rig = gb.Drivetrain("varying")
    one, two, three = (rig.add(n, gb.Inertia(J=J)) for n, J in (("one", 0.7), ("two", 1.3), ("three", 2.1)))
    law = gb.RatioLaw.ellipse(0.3)
    rig.chain(one, rig.add("pair", gb.NonCircularGear(law=law, external=True)), two)
    rig.chain(two, rig.add("clutch", gb.Clutch(capacity=30.0)), three, rig.add("shaft", gb.Shaft(k=40.0)))
    rig.connect(rig.add("wall", gb.Fixed()).flange, FlangeHandle(rig, "shaft", "b"))
    found = gb.modes(rig, {"one.phi": 0.4})
    m = law.m(0.4)
    assert found.frequencies == pytest.approx([np.sqrt(40.0 / (0.7 / m**2 + 1.3 + 2.1))], rel=1e-7)  # by differences


@pytest.mark.long
def test_a_campbell_diagram_sees_the_train_as_what_holds_leaves_it():
    stuck, rigid = (_turning(x) for x in (gb.Clutch(capacity=50.0), None))
    found, expected = (gb.campbell(rig, "one.w", [1.0, 20.0], orders={"first": 1.0}) for rig in (stuck, rigid))
    assert found.frequencies == pytest.approx(expected.frequencies, rel=NEAR)


def _turning(clutch):
    rig = gb.Drivetrain("turning")
    one, two, three = (rig.add(n, gb.Inertia(J=J)) for n, J in (("one", 0.7), ("two", 1.3), ("three", 2.1)))
    rig.chain(one, rig.add("shaft", gb.Shaft(k=50.0)), two)
    if clutch is None:
        rig.connect(two.b, three.a)
    else:
        rig.chain(two, rig.add("clutch", clutch), three)
    return rig


@pytest.mark.long
def test_a_lossy_gear_is_a_tie_for_small_motions():
    rig = gb.Drivetrain("lossy")
    one, two = rig.add("one", gb.Inertia(J=2.0, w0=3.0)), rig.add("two", gb.Inertia(J=3.0, w0=1.5))
    gear = rig.add("gear", gb.LossyGear(ratio=2.0, efficiency=(0.9, 0.8)))
    rig.chain(rig.add("drive", gb.Torque(tau=gb.Input("tau", 8.0))), one, gear, two)
    found = gb.linearize(rig, None, outputs=["two.w", "one.w"])
    assert len(found.states) == 1
    gained = found.C @ found.B  # acceleration per torque: 2 * 0.9 of it arrives at the second disc
    by_hand = 2.0 * 0.9 / (2.0**2 * 0.9 * 2.0 + 3.0)
    assert gained[:, 0] == pytest.approx([by_hand, 2.0 * by_hand], rel=1e-8)  # by differences

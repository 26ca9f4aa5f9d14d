"""Non-circular gears against numbers with 30 digits from elsewhere (tests/data/noncircular_*)."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb

DATA = Path(__file__).parents[1] / "data"
X = np.deg2rad(240)
NORM = gb.RatioLaw.segments(0.7 / X, 0.5, X)
BENCH = gb.RatioLaw.segments(0.0886621042624866, 0.814306523064773, X)
E = 0.4632
PLANET = gb.RatioLaw.ellipse(E)
PLANET_PAIR = PLANET.pair(2 * 0.098178 / (1 - E**2))


def _columns(name):
    with (DATA / name).open() as file:
        rows = list(csv.DictReader(file))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


def _json(name):
    return json.loads((DATA / name).read_text())


def test_the_law_norm_is_that_of_the_reference_to_1e_13():
    table = _columns("noncircular_ratio_NORM.csv")
    phi = table["phi1"]
    assert np.abs(NORM.m(phi) - table["m"]).max() < 1e-13
    assert np.abs(NORM.dm(phi) - table["dm"]).max() < 1e-13
    assert np.abs(NORM.dm(phi, 2) - table["d2m"]).max() < 1e-13 * np.abs(table["d2m"]).max()
    assert np.abs(NORM.F(phi) - table["F"]).max() < 1e-13


def test_the_pitch_curves_of_norm_are_those_of_the_reference():
    table = _columns("noncircular_ratio_NORM.csv")
    pair = NORM.pair(0.2)
    for gear, r in zip((1, 2), pair.radii(table["phi1"]), strict=True):
        assert np.abs(1e3 * r - table[f"r{gear}_mm"]).max() < 1e-11  # mm: 1e-13 of the distance
        for axis, value in zip("xy", pair.points(table["phi1"], gear), strict=True):
            assert np.abs(1e3 * value - table[f"{axis}{gear}"]).max() < 1e-11


def test_the_design_of_norm_is_that_of_the_reference():
    true = _json("noncircular_design.json")["NORM"]
    geometry = true["geom"]
    design = gb.design_ratio(0.7 / X, 0.5, X, E=0.2)
    span, (one, two) = design.law.m_range, design.pair.curvatures
    assert design.transition == pytest.approx(63.0, rel=1e-14)
    assert (span.smallest, span.largest) == pytest.approx((float(true["m_min"]), float(true["m_max"])), abs=1e-13)
    assert (span.smallest_at, span.largest_at) == pytest.approx(
        (float(true["at_min"]), float(true["at_max"])), abs=1e-12
    )
    assert 1e3 * design.pair.length == pytest.approx(geometry["len1"], rel=1e-13)
    # the reference took these extremes from a grid: an extreme is missed by less than 1e-5 of its size, its place by a step
    assert one.smallest == pytest.approx(1e3 * geometry["kappa1_min"], rel=1e-5)
    assert one.smallest_at == pytest.approx(geometry["kappa1_min_at"], abs=1e-4)
    assert two.smallest == pytest.approx(1e3 * geometry["kappa2_min"], rel=1e-5)
    assert 1e3 / one.largest == pytest.approx(geometry["rho1_min_convex"], rel=1e-5)
    assert 1e3 / two.largest == pytest.approx(geometry["rho2_min_convex"], rel=1e-5)
    assert not one.is_convex and not two.is_convex
    assert one.concave == pytest.approx(geometry["concave_frac_gear1"], abs=2e-4)  # one grid angle on either side
    assert two.concave == pytest.approx(geometry["concave_frac_gear2"], abs=2e-4)
    assert np.rad2deg(design.pressure_angle_increment) == pytest.approx(geometry["mu_max_deg"], abs=1e-5)
    assert 1e3 * design.module == pytest.approx(geometry["module_max_undercut_ha1.15"], rel=1e-5)


def test_the_printed_law_is_refused_with_its_smallest_ratio_and_the_feasible_segment():
    true = _json("noncircular_design.json")["LIT_m"]
    with pytest.raises(
        gb.RatioLawError, match=r"m = -4\.524.*must stay > 0.*largest feasible X is 103\.53 deg"
    ) as refusal:
        gb.design_ratio(0.7, 0.5, X, E=0.2)
    assert refusal.value.m_min == pytest.approx(float(true["m_min"]), rel=1e-13)
    assert refusal.value.at == pytest.approx(float(true["at_min"]), abs=1e-12)
    assert gb.RatioLaw.segments(0.7, 0.5, refusal.value.largest_X - 1e-9).m_range.smallest > 0


def test_the_bench_law_runs_between_0_8_and_1_2_and_is_convex():
    span = BENCH.m_range
    assert (span.smallest, span.largest) == pytest.approx((0.8, 1.2), abs=1e-14)
    assert all(c.is_convex for c in BENCH.pair(0.2).curvatures)


def test_three_branches_of_norm_turn_as_in_the_reference():
    """Pair 1 at th + psi_j, pair 2 a phase of 60 deg further; a differential takes m2 - m1 (a = 2, i1 = 2, i2 = 1)."""
    table = _columns("noncircular_kin_NORM_d60.csv")
    delta = np.pi / 3
    assert np.abs(NORM.m(table["theta"]) - table["m1_b0"]).max() < 1e-13
    assert np.abs(NORM.m(table["theta"] + delta) - table["m2_b0"]).max() < 1e-13
    branches = []
    for j in range(3):
        th = table["theta"] - 2 * np.pi * j / 3
        branches.append(NORM.m(th + delta) - NORM.m(th))
        assert np.abs(branches[j] - table[f"u{j}"]).max() < 1e-13
    selected = np.array(branches)[table["selected_branch"].astype(int), np.arange(len(table["theta"]))]
    assert np.abs(selected - table["u_sel"]).max() < 1e-13


@pytest.mark.parametrize("n", [2, 3])
def test_as_many_branches_turn_evenly_as_the_matching_says(n):
    """zeta = N (X - delta)/360 deg is the mean number of branches inside of their even window."""
    th = np.deg2rad(np.arange(0.05, 360, 0.1))  # joints lie between two of these
    for delta, zeta in _json("noncircular_matching.json")["zeta_X240"][str(n)].items():
        shift = np.deg2rad(float(delta))
        if shift == 0:
            continue  # the output stands still whatever the law
        even = np.abs(NORM.m(th + shift) - NORM.m(th) - 0.7 / X * shift) < 1e-12
        # a transition may cross the even value within 0.1 deg once or twice
        assert n * even.mean() == pytest.approx(zeta, abs=n * 2 / 3600), delta


def test_ellipses_turn_each_other_as_in_the_reference():
    table = _columns("noncircular_kinematics.csv")
    th = np.deg2rad(table["theta1_deg"])
    r1, r2 = PLANET_PAIR.radii(th)
    # the reference is printed with 12 digits
    assert np.abs(1e3 * r1 - table["r1_mm"]).max() < 1e-9 and np.abs(1e3 * r2 - table["r2_mm"]).max() < 1e-9
    assert np.abs(PLANET.m(th) - table["i21_w2_over_w1"]).max() < 1e-11
    assert np.abs(np.rad2deg(PLANET.F(th)) - table["theta2_deg"]).max() < 1e-9
    assert np.abs(1e3 / PLANET_PAIR.curvature_at(th, 1) - table["rho1_mm"]).max() < 1e-9


def _swing(beta, th):
    chi = PLANET.inverse(PLANET.F(th) + beta)
    start = PLANET.inverse(np.array([beta]))
    return th - (chi - start), 1 - PLANET.m(th) / PLANET.m(chi)


@pytest.mark.parametrize("beta", [30, 90, 180])
def test_two_rows_of_ellipses_swing_the_output_as_in_the_reference(beta):
    table = _columns("noncircular_kinematics.csv")
    angle, ratio = _swing(np.deg2rad(beta), np.deg2rad(table["theta1_deg"]))
    assert np.abs(np.rad2deg(angle) - table[f"thetaC_beta{beta}_deg"]).max() < 1e-9
    if beta == 180:
        assert np.abs(ratio - table["wC_over_wH_beta180"]).max() < 1e-10


@pytest.mark.parametrize("row", _json("noncircular_swing.json"), ids=lambda row: f"{row['beta_deg']} deg")
@pytest.mark.few(1)
def test_the_swing_is_that_of_the_closed_form(row):
    th = np.linspace(0, 2 * np.pi, 20001)
    angle, ratio = _swing(np.deg2rad(row["beta_deg"]), th)
    # between two grid angles an extreme rises by (pi/20000)^2/2 of its second derivative, which is < 200
    assert np.rad2deg(np.ptp(angle)) == pytest.approx(row["swing_pkpk_deg_closed_form"], abs=1e-5)
    assert (ratio.min(), ratio.max()) == pytest.approx((row["wC_wH_min"], row["wC_wH_max"]), abs=3e-6)


def test_equivalent_tooth_numbers_follow_from_the_curvature():
    table = _columns("noncircular_stiffness.csv")
    th = np.deg2rad(table["theta1_deg"])
    for gear in (1, 2):
        teeth = 2 / PLANET_PAIR.curvature_at(th, gear) / 4e-3
        assert np.abs(teeth - table[f"Ze{gear}"]).max() < 1e-9  # printed with 12 digits


def test_a_rack_makes_59_teeth_without_undercut():
    flanks = PLANET_PAIR.flanks(4e-3, 59, pressure_angle=np.deg2rad(20))
    assert len(flanks.x) == 118 and not flanks.undercut.any()
    assert 1e3 * PLANET_PAIR.length == pytest.approx(741.38314, abs=5e-6)
    assert 1e6 * flanks.defect == pytest.approx(-32.7, abs=0.05)
    assert 1e3 * flanks.smallest_radius == pytest.approx(21.89, abs=5e-3)


def test_an_equal_ellipse_at_250_mm_drifts():
    import sympy as sp

    phi = sp.Symbol("phi")
    r = 98.178 / (1 - E * sp.cos(phi))
    with pytest.raises(gb.RatioLawError, match=r"drifts by -0\.02539\d* deg a turn.*normalise=True"):
        gb.RatioLaw.from_function(r / (250 - r))
    law = gb.RatioLaw.from_function(r / (250 - r), normalise=True)
    assert law.scaled == pytest.approx(1.0000705448, abs=1e-10)
    assert law.F(2 * np.pi) == pytest.approx(2 * np.pi, abs=1e-14)


def _pair(law, **mesh):
    rig = gb.Drivetrain("pair")
    rig.chain(
        rig.add("drive", gb.Torque(tau=0.2)), rig.add("one", gb.Inertia(J=1e-4, w0=262.0)),
        rig.add("mesh", gb.NonCircularGear(law=law, external=False, **mesh)), rig.add("two", gb.Inertia(J=2e-4)),
        rig.add("load", gb.Torque(tau=-0.2)),
    )  # fmt: skip
    return rig


def test_a_rigid_pair_moves_as_in_the_reference():
    """(J1 + J2 m^2) phi1'' + J2 m m' phi1'^2 = T1 - m T2."""
    table = np.array(_json("noncircular_rigid.json")["t_table"], dtype=float)
    run = gb.simulate(_pair(BENCH), t=table[:, 0], rtol=1e-12)
    for i, name in enumerate(("one.phi", "one.w", "two.phi", "two.w"), 1):
        assert np.abs(run[name] - table[:, i]).max() < 1e-10 * np.abs(table[:, i]).max(), name
    assert run.energy.residual < 1e-10


def test_implicit_steps_move_a_rigid_pair_as_in_the_reference():
    table = np.array(_json("noncircular_rigid.json")["t_table"], dtype=float)
    model = gb.build(_pair(BENCH))
    runs = [gb.simulate(model, t=table[:, 0], method=m, rtol=r) for m, r in (("rodas", 1e-11), ("dp8", 1e-12))]
    for i, name in enumerate(("one.phi", "one.w", "two.phi", "two.w"), 1):
        size = np.abs(table[:, i]).max()
        assert np.abs(runs[0][name] - table[:, i]).max() < 1e-10 * size, name
        assert np.abs(runs[0][name] - runs[1][name]).max() < 1e-9 * size, name
    assert runs[0].energy.residual < 1e-10


def test_implicit_steps_of_a_rigid_pair_are_of_order_five():
    """A wrong term in the matrix would cost the order."""
    table = np.array(_json("noncircular_rigid.json")["t_table"], dtype=float)
    model = gb.build(_pair(gb.RatioLaw.ellipse(0.3)))
    true = gb.simulate(model, t=table[:, 0], method="dp8", rtol=1e-13)
    steps = [table[-1, 0] / n for n in (400, 800)]
    runs = [gb.simulate(model, t=table[:, 0], method="rodas", step=h) for h in steps]
    for name in ("one.phi", "one.w", "two.phi", "two.w"):
        errors = [np.abs(run[name] - true[name]).max() for run in runs]
        assert 4.7 < np.log2(errors[0] / errors[1]) < 5.3, name


def test_a_compliant_pair_moves_as_in_the_reference():
    true = _json("noncircular_compliant.json")
    table = np.array(true["table"], dtype=float)
    start = dict(zip(("one.phi", "one.w", "two.phi", "two.w"), true["y0"], strict=True))
    run = gb.simulate(_pair(BENCH, k=400.0, c=0.01), t=table[:, 0], rtol=1e-13, initial=start)
    for i, name in enumerate(("one.phi", "one.w", "two.phi", "two.w", "mesh.moment"), 1):
        # M = 400 q, q about 1e-4 of the angles: the digits of the angles
        assert np.abs(run[name] - table[:, i]).max() < 1e-9 * np.abs(table[:, i]).max(), name
    joints = [e.t for e in run.events]
    assert joints == pytest.approx([t for t in true["joint_times"] if t < 0.1], abs=1e-12)
    assert run.energy.residual < 1e-12

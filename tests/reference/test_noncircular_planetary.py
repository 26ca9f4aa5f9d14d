"""The shipped non-circular planetary train: the paper's equations with set M1, and the train in SI units, against numbers from
elsewhere (tests/data/noncircular_*)."""

import csv
import importlib.util
import json
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb

DATA = Path(__file__).parents[1] / "data"
STATE = ("x_cp", "v_cp", "x_sp", "v_sp")
SECTION = gb.stroboscopic("w")


def _shipped():
    path = Path(__file__).parents[2] / "models" / "noncircular_planetary.py"
    spec = importlib.util.spec_from_file_location("noncircular_planetary_model", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


train = _shipped()


def _json(name):
    return json.loads((DATA / f"noncircular_{name}.json").read_text(encoding="utf8"))


def _columns(name):
    with (DATA / f"noncircular_{name}.csv").open(encoding="utf8") as file:
        rows = list(csv.DictReader(file))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


# -- the paper's equations ---------------------------------------------------------------------------------------------


def test_the_printed_equations_are_those_of_the_paper_term_by_term():
    eq = train.build().equations()
    symbols = {path: symbol for symbol, path in eq.parameters.items()}
    w, xi, mu, ka = (symbols[name] for name in ("w", "xi", "mu", "ka"))
    states = {str(x): x for x in eq.states}
    t = next(x for x in eq.states[states["v_cp_p1"]].free_symbols if x.name == "t")
    rates = {str(x): e for x, e in eq.states.items()}
    defined = {str(x): e for x, e in eq.definitions.items()}
    assert rates["v_H"] == symbols["H.F"]
    for i in (1, 2):
        p = f"p{i}"
        cd, F, half = symbols[f"{p}.cd"], symbols[f"{p}.F"], symbols[f"{p}.backlash.half_gap"]
        wave = next(iter(defined[f"tau_{p}"].atoms(sp.Function)))
        assert sp.expand(defined[f"tau_{p}"] - (1 + mu * wave)) == 0
        assert sp.expand(defined[f"kappa_{p}"] - (1 + ka * sp.cos(w * t))) == 0
        tau, kappa = (next(x for x in eq.definitions if str(x) == f"{name}_{p}") for name in ("tau", "kappa"))
        loads = {}
        for mesh in ("sp", "cp"):
            x, v = states[f"x_{mesh}_{p}"], states[f"v_{mesh}_{p}"]
            f = next(y for y in eq.definitions if str(y) == f"f_{mesh}_{p}")
            coefficients = [symbols[f"{p}.backlash.coefficients[{j}]"] for j in range(5)]
            polynomial = sum(c * x ** (2 * j + 1) for j, c in enumerate(coefficients))
            assert sp.expand(eq.definitions[f].subs(half, 1) - polynomial) == 0
            assert rates[f"x_{mesh}_{p}"] == v
            loads[mesh] = tau * (cd * xi * v + kappa * f)
        E_sp, E_cp = (symbols[f"{p}.errors.{name}"] for name in ("E_sp", "E_cp"))
        shaken = w**2 * sp.sin(w * t)
        assert sp.expand(rates[f"v_sp_{p}"] - (E_sp * shaken - loads["sp"] - loads["cp"])) == 0
        assert sp.expand(rates[f"v_cp_{p}"] - (F + E_cp * shaken - loads["cp"])) == 0


def test_every_effect_of_the_paper_leaves_no_trace_when_it_is_taken_away():
    rig = train.figure_8()
    assert set(rig.effects()) == {f"p1.{name}" for name in ("friction", "variation", "errors", "backlash")}
    bare = rig.without("*")
    eq = bare.equations()
    assert {path.partition(".")[2] or path for path in eq.parameters.values()} == {"xi", "cd", "F"}
    run = gb.simulate(bare, t=np.linspace(0, 10, 11), rtol=1e-11)
    c, F = 2 * 0.20, train.FIGURE_8.F
    w = np.sqrt(1 - c**2 / 4)
    swing = np.exp(-c / 2 * run.t) * (np.cos(w * run.t) + c / 2 / w * np.sin(w * run.t))
    assert np.abs(run["p1.x_cp"] - (F + (1.05 - F) * swing)).max() < 1e-9


def test_the_trajectory_is_that_of_the_reference():
    true = _json("trajectory_A")["A_lambda_plus1"]
    run = gb.simulate(train.nondimensional(train.SET_A), t=np.array(true["t"], dtype=float), rtol=1e-13)
    table = np.array(true["y_taylor"])
    for planet in ("p1", "p2"):
        ours = np.stack([run[f"{planet}.{name}"] for name in STATE], axis=1)
        assert np.abs(ours - table).max() < 1e-10  # two methods of the reference agree to 1e-12
    refit = gb.Backlash(half_gap=1.0, law="polynomial", degree=9)
    other = gb.simulate(
        train.nondimensional(train.SET_A).set({"p1.backlash": refit}), t=np.array(true["t"], dtype=float), rtol=1e-12
    )
    apart = np.abs(np.stack([other[f"p1.{name}"] for name in STATE], axis=1) - table).max()
    assert apart == pytest.approx(8.6e-4, abs=0.05e-4)  # what the printed digits make, as the page says


def test_the_carrier_is_a_ramp_that_nothing_acts_back_on():
    run = gb.simulate(train.build(), t=[0.0, 3.0], parameters={"H.F": 0.2}, rtol=1e-10)
    assert run["H.x"][-1] == pytest.approx(0.9, abs=1e-12)


@pytest.mark.parametrize(("name", "path", "value"), [("M1_xi0.20", "xi", 0.20), ("M1_ka0.50", "ka", 0.50)])
def test_points_and_multipliers_of_the_orbits_are_those_of_the_reference(name, path, value):
    true = _json("orbits_M1")[name]
    rig = train.nondimensional(train.SWEEPS[path][0], planets=1)
    orbit = gb.periodic_orbit(rig, SECTION, parameters={path: value})
    ours = dict(zip(orbit.names, orbit.points[0], strict=True))
    assert [ours[f"p1.{name}"] for name in STATE] == pytest.approx(true["fixed_point"], abs=1e-8)
    multipliers = sorted(complex(*pair).real for pair in true["floquet"])
    assert sorted(orbit.multipliers.real) == pytest.approx(multipliers, abs=1e-8)
    assert np.abs(orbit.multipliers.imag).max() < 1e-8
    assert orbit.exponents[0] == pytest.approx(true["lle"], abs=1e-8)


def _label(path, value, **marks):
    return pytest.param(path, value, marks=[pytest.mark.long] if marks.get("long") else [], id=f"{path}-{value}")


RUNS = {
    ("xi", 0.05): "chaotic", ("xi", 0.20): "period 1", ("xi", 0.30): "period 1",
    ("mu", 0.01): "chaotic", ("mu", 0.12): "period 2", ("mu", 0.45): "period 1",
    ("ka", 0.50): "period 1", ("ka", 1.50): "period 4", ("ka", 1.90): "chaotic",
}  # fmt: skip


@pytest.mark.few(2)
@pytest.mark.parametrize(("path", "value"), [_label(p, v, long=RUNS[p, v] == "chaotic") for p, v in RUNS])
def test_the_nine_runs_of_set_m1_have_the_labels_of_the_page(path, value):
    found = train.regime(path, value)
    assert found.settled and found.label == RUNS[path, value], found.evidence


@pytest.mark.long
@pytest.mark.parametrize("path", ["xi", "mu", "ka"])
def test_the_diagrams_of_set_m1_have_the_classes_of_the_reference_and_no_torus(path):
    """One frequency excites a cascade in which areas contract: what is not periodic is chaotic. The reference calls three
    motions "regular" whose largest multipliers are 0.967 to 0.997, and which had not settled there."""
    with (DATA / "noncircular_bifurcation_M1.csv").open(encoding="utf8") as file:
        rows = [row for row in csv.DictReader(file) if row["sweep"] == path]
    assert len(rows) >= 25
    for row in rows:
        found = train.regime(path, float(row["value"]), lasting=3000)
        known = {"chaos": "chaotic", "periodic": f"period {row['period']}", "regular_nonperiodic": "period"}[
            row["class"]
        ]
        assert found.label == known or (known == "period" and found.label.startswith("period ")), (row, found.evidence)


@pytest.mark.long
@pytest.mark.parametrize("path", ["xi", "mu", "ka"])
def test_the_thresholds_lie_in_the_cells_of_the_reference(path):
    low, high = train.SWEEPS[path][1]
    one, other = train.threshold(path)
    assert low <= one < other <= high and other - one <= 0.002


def test_the_square_wave_switches_at_known_times():
    n = train.FIGURE_8
    run = gb.simulate(train.figure_8(), t_end=60.0, rtol=1e-9)
    times = [e.t for e in run.events if e.kind == "time"]
    known = (np.arange(1, 40) * np.pi - n.phase) / n.w
    known = known[(known > 0) & (known < 60.0)]
    assert times == pytest.approx(known, abs=1e-12)
    assert run.stats.rejected < run.stats.steps


@pytest.mark.parametrize("ka", [0.9, 1.9])
def test_leaving_the_polynomial_is_reported_and_an_escape_ends_the_run_with_its_cause(ka):
    rig = train.figure_10(ka)
    if ka < 1:
        run = gb.simulate(rig, t_end=60.0, initial={"p1.x_cp": 2.05})
    else:
        with pytest.raises(gb.SimulationError, match=r"'p1': the motion grows without bound at t = 14\.8") as stopped:
            gb.simulate(rig, t_end=60.0, initial={"p1.x_cp": 2.05})
        run = stopped.value.trajectory
    left = [e.component for e in run.events if "beyond the polynomial" in e.component]
    assert "p1.x_cp beyond the polynomial, drive side" in left
    assert np.isfinite(run["p1.x_sp"]).all() and np.isfinite(run["p1.x_cp"]).all()
    assert (np.abs(run["p1.x_cp"]).max() > 5) == (ka > 1)


@pytest.mark.long
def test_with_the_true_dead_zone_the_pattern_of_m1_is_lost():
    labels = [gb.classify(train.figure_8(xi, exact=True), SECTION).label for xi in (0.05, 0.20, 0.30)]
    assert labels != ["chaotic", "period 1", "period 1"]


# -- the train in SI units ---------------------------------------------------------------------------------------------


@cache
def _rigid():
    return gb.build(train.rigid())


def _kinematic(beta, **options):
    """A turn of the rigid train with the row phase beta [deg]."""
    n = replace(train.Train(), beta=np.deg2rad(beta))
    phase = {"p1_output.phase": -float(train.LAW.inverse(n.beta))}
    return gb.simulate(_rigid(), rtol=1e-11, parameters=phase, initial="rolling", watch=False, **options)


@pytest.mark.long
@pytest.mark.parametrize("beta", [30, 90, 180])
def test_the_train_made_rigid_swings_as_in_the_reference(beta):
    table = _columns("kinematics")
    run = _kinematic(beta, t=np.deg2rad(table["theta1_deg"]) / train.Train().w)
    assert np.abs(np.rad2deg(run["output.phi"]) - table[f"thetaC_beta{beta}_deg"]).max() < 1e-7
    planet = np.rad2deg(run["p1.phi"] - run["carrier.phi"])
    assert np.abs(planet - table["theta2_deg"]).max() < 1e-7
    if beta == 180:
        assert np.abs(run["output.w"] / run["carrier.w"] - table["wC_over_wH_beta180"]).max() < 1e-9


def test_the_swing_of_the_train_made_rigid_is_that_of_the_closed_form():
    for row in _json("swing"):
        run = _kinematic(row["beta_deg"], t_end=2 * np.pi / train.Train().w)
        swing = run.extremes("output.phi")
        assert np.rad2deg(swing.high - swing.low) == pytest.approx(row["swing_pkpk_deg_closed_form"], abs=1e-7)


def test_the_stiffness_is_that_of_the_reference():
    table = _columns("stiffness")
    th = np.deg2rad(table["theta1_deg"])
    for gear in (1, 2):
        teeth = train.PAIR.equivalent_teeth(th, gear, module=train.MODULE)
        assert teeth == pytest.approx(table[f"Ze{gear}"], rel=1e-9)
    k = train.PAIR.mesh_stiffness(th, module=train.MODULE, face_width=0.03)
    assert k / 1e6 == pytest.approx(table["k_N_per_um"], rel=1e-8)
    about = train.stiffness_about_planet(train.Train()).values(th)
    arm = train.PAIR.radii(th)[1] * np.cos(np.deg2rad(20))
    assert about / arm**2 == pytest.approx(k, rel=5e-6)  # the spline through 72 points


def test_the_fourier_series_of_the_stiffness_is_that_of_the_reference():
    true = _json("stiffness_fourier")["corrected_ISO_C2"]
    th = 2 * np.pi * np.arange(256) / 256
    k = train.PAIR.mesh_stiffness(th, module=train.MODULE, face_width=0.03) / 1e6
    assert k.mean() == pytest.approx(true["km"], abs=1e-10)
    for j, (a, b) in enumerate(zip(true["cos"], true["sin"], strict=True), 1):
        assert 2 * (k * np.cos(j * th)).mean() == pytest.approx(a, abs=1e-10)
        assert 2 * (k * np.sin(j * th)).mean() == pytest.approx(b, abs=1e-10)


@pytest.mark.long
def test_two_planets_between_the_same_suns_cannot_be_assembled():
    found = train.assembly(np.deg2rad(30), np.pi)
    assert not found.fits and np.rad2deg(found.least) == pytest.approx(43.5, abs=0.05)
    assert np.rad2deg(found.swing) == pytest.approx(67.90261453, abs=0.01)  # over a grid
    assert "cannot be assembled" in str(found) and "43.5 deg are left" in str(found)
    assert train.assembly(0.0, np.pi).fits  # without swing both rows are one
    assert train.assembly(np.deg2rad(30), 2 * np.pi).fits


@pytest.mark.long
def test_the_train_with_all_effects_follows_its_kinematics_within_gap_and_compliance():
    n = train.Train()
    t = np.linspace(0, 2 * np.pi / n.w, 181)
    run = gb.simulate(train.physical(1), t=t, rtol=1e-8)
    th = n.w * t
    start = train.LAW.inverse(train.LAW.F(0.0) + n.beta)
    rigid = th - (train.LAW.inverse(train.LAW.F(th) + n.beta) - start)
    arm = train.PAIR.distance / 2 * np.cos(n.pressure_angle)
    # both meshes give way by gap, error and at most a third of a mrad of compliance, at a ratio of at most K
    reach = train.LAW.m(0.0) * 2 * ((n.half_gap + n.error) / arm + 3e-4)
    assert np.abs(run["output.phi"] - rigid).max() < reach
    assert np.abs(run["output.phi"] - rigid).max() > n.half_gap / arm / 10
    assert {-1.0, 0.0, 1.0} == set(np.unique(run["p1_output.contact"]))  # it reverses through the gap
    assert run.energy.residual < 1e-6

"""Laws of backlash: polynomial, smooth, and a gap of every tooth."""

import json
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import gearblocks as gb
from gearblocks.geometry.backlash_fit import polynomial_fit
from gearblocks.geometry.spline_teeth import deflection_at

TIGHT = {"rtol": 1e-12}
B, K, C = 0.1, 400.0, 3.0
T = np.linspace(0, 6, 241)
PRINTED = (0.0473, -0.3320, 0.4704, -0.1548, 0.0163)


def _rig(gap, choice="always", c=C, teeth=3, amplitude=12.0, **fields):
    """J = 1 on a spline of radius 1 against the ground: the deflection is the angle."""
    rig = gb.Drivetrain("one body")
    body = rig.add("body", gb.Inertia(J=1.0, w0=4.0))
    spline = gb.SplineCoupling(teeth=teeth, radius=1.0, k=K, c=c, backlash=gap, contact_damping=choice, **fields)
    drive = rig.add("drive", gb.Torque(tau=amplitude * sp.sin(7 * gb.time)))
    rig.chain(drive, body, rig.add("spline", spline), rig.add("ground", gb.Fixed()))
    return rig


def _polynomial(x, coefficients):
    return B * sum(c * (x / B) ** (2 * j + 1) for j, c in enumerate(coefficients))


@pytest.mark.parametrize(
    ("gap", "coefficients"),
    [
        (gb.Backlash(half_gap=B, law="polynomial", degree=9), polynomial_fit(9)),
        (gb.Backlash(half_gap=B, law="polynomial", degree=5, interval=3.0), polynomial_fit(5, 3.0)),
        (gb.Backlash(half_gap=B, law="polynomial", coefficients=PRINTED), PRINTED),
    ],
    ids=["degree 9", "degree 5 on 3 half gaps", "printed"],
)
@pytest.mark.few(1)
def test_a_polynomial_gap_moves_as_derived_by_hand(gap, coefficients, reference, distance):
    rig = _rig(gap, amplitude=2.0)
    run = gb.simulate(rig, t=T, initial={"body.w": 0.5}, **TIGHT)

    def rates(t, y, _):
        return y[1], 2 * np.sin(7 * t) - K * _polynomial(y[0], coefficients) - C * y[1]

    true = reference(rates, (0.0, 0.5), T)
    assert distance(run["body.phi"], true[:, 0]) < 1e-9  # a smooth law: a thousand steps at 1e-12
    assert run.energy.residual < 1e-11  # 10 rtol
    assert set(run.energy.supplied) == {"drive"}


@pytest.mark.long
def test_leaving_the_interval_of_a_polynomial_is_an_event_on_the_side_where_it_happens():
    rig = _rig(gb.Backlash(half_gap=B, law="polynomial", degree=5), amplitude=0.0, c=None)
    run = gb.simulate(rig, t_end=0.1, **TIGHT)
    out = [e for e in run.events if "polynomial" in e.component]
    assert out, "4 m/s reach 2 half gaps"
    assert out[0].component == "spline.beyond the polynomial, drive side"
    assert (out[0].before, out[0].after) == (0.0, 1.0)
    there = gb.simulate(rig, t=[out[0].t], **TIGHT)
    assert there["spline.deflection"][0] == pytest.approx(2 * B, rel=1e-10)  # the tolerance over some steps


def test_a_motion_that_escapes_along_a_polynomial_ends_with_the_component_named():
    """Degree 5 turns downwards beyond its interval: the force pushes outwards and the motion ends in finite time."""
    with pytest.raises(gb.SimulationError) as caught:
        gb.simulate(
            _rig(gb.Backlash(half_gap=B, law="polynomial", degree=5), amplitude=0.0, c=None),
            t_end=50.0,
            initial={"body.w": 40.0},
        )
    assert "spline" in str(caught.value) or "body" in str(caught.value)
    assert caught.value.trajectory is not None
    assert np.isfinite(caught.value.trajectory["body.phi"]).all()
    assert any("beyond the polynomial" in e.component for e in caught.value.trajectory.events)


@pytest.mark.long
@pytest.mark.parametrize("choice", [pytest.param("always", marks=pytest.mark.long), "clipped"])
def test_a_smooth_gap_tends_to_the_exact_one_as_its_width_shrinks(choice, distance):
    exact = gb.simulate(_rig(gb.Backlash(half_gap=B), choice), t=T, **TIGHT)["body.phi"]
    model = gb.build(_rig(gb.Backlash(half_gap=B, law="smooth", width=1e-3), choice))
    off = []
    for width in (4e-4, 2e-4, 1e-4):
        run = gb.simulate(model, t=T, parameters={"spline.backlash.width": width}, **TIGHT)
        off.append(distance(run["body.phi"], exact))
    # the impulse that the rounding of a corner changes goes as w^2 ln(1/w)
    assert 3 < off[0] / off[1] < 4.2
    assert 3 < off[1] / off[2] < 4.2


def test_a_smooth_gap_has_the_force_and_the_energy_of_its_formula():
    w = 0.02
    run = gb.simulate(_rig(gb.Backlash(half_gap=B, law="smooth", width=w), c=None), t=T, **TIGHT)
    x = run["spline.deflection"]
    g = x + (np.sqrt((x - B) ** 2 + w**2) - np.sqrt((x + B) ** 2 + w**2)) / 2
    assert np.allclose(run["spline.force"], K * g, rtol=1e-10, atol=1e-12)
    assert np.abs(g - np.sign(x) * np.maximum(np.abs(x) - B, 0)).max() <= w / 2
    assert run.energy.residual < 1e-11  # 10 rtol: the potential is that of the force
    assert set(run.energy.supplied) == {"drive"}


def test_a_smooth_gap_with_clipped_damping_never_pulls_and_closes_its_ledger():
    model = gb.build(_rig(gb.Backlash(half_gap=B, law="smooth", width=0.02), "clipped"))
    # where damping cancels the spring the motion is simple while loss and stored energy still bend: short steps for them
    run = gb.simulate(model, t=T, max_step=2e-3, rtol=1e-9)
    assert np.all(run["spline.force"] * np.sign(run["spline.deflection"]) >= -1e-9)
    assert run.energy.residual < 1e-8  # 10 rtol
    assert set(run.energy.supplied) == {"drive"}


@pytest.mark.long
def test_equal_gaps_of_all_teeth_are_one_backlash(distance):
    for choice in ("always", "clipped", "clipped_force"):
        one = gb.simulate(_rig(gb.Backlash(half_gap=B), choice), t=T, **TIGHT)
        many = gb.simulate(_rig(gb.Backlash(gaps=(B, B, B)), choice), t=T, **TIGHT)
        assert distance(many["body.phi"], one["body.phi"]) < 1e-9
        assert distance(many["spline.force"], one["spline.force"]) < 1e-8
        assert set(np.unique(many["spline.engaged_teeth"])) == {0.0, 3.0}
        assert np.array_equal(many["spline.contact"], one["spline.contact"])


@pytest.mark.long
def test_teeth_with_their_own_gaps_move_as_derived_by_hand(reference, distance):
    drive, coast = (0.05, 0.1, 0.17), (0.02, 0.12, 0.08)
    run = gb.simulate(_rig(gb.Backlash(gaps=drive, coast_gaps=coast)), t=T, **TIGHT)
    corners = [*drive, *(-c for c in coast)]

    def rates(t, y, modes):
        ahead = sum(y[0] - b for b, m in zip(drive, modes[:3], strict=True) if m > 0)
        behind = sum(y[0] + b for b, m in zip(coast, modes[3:], strict=True) if m < 0)
        return y[1], 12 * np.sin(7 * t) - K / 3 * (ahead + behind) - C * y[1]

    true = reference(rates, (0.0, 4.0), T, lambda t, y: [y[0] - b for b in corners], max_step=0.005)
    x = true[:, 0]
    assert distance(run["body.phi"], x) < 1e-9
    clear = np.min([np.abs(x - b) for b in corners], axis=0) > 1e-7
    engaged = sum((x > b).astype(float) for b in drive) + sum((x < -b).astype(float) for b in coast)
    assert np.array_equal(run["spline.engaged_teeth"][clear], engaged[clear])
    assert run.energy.residual < 1e-11  # 10 rtol
    located = [e for e in run.events if e.component.startswith("spline")]
    assert len({e.component for e in located}) == 1, "one switch for all teeth"


@pytest.mark.long
def test_the_sample_of_the_reference_rests_where_its_closed_form_says():
    path = Path(__file__).parents[2] / "data" / "spline_engaged_teeth.json"
    case = json.loads(path.read_text())
    drive, coast = ([b * 1e-6 for b in case[f"gap_{side}_um"]] for side in ("drive", "coast"))
    rig = gb.Drivetrain("sample")
    body, ground = rig.add("body", gb.Inertia(J=1e-3)), rig.add("ground", gb.Fixed())
    spline = rig.add("spline", gb.SplineCoupling(
        teeth=20, radius=case["r2"], k=20 * case["kt"], damping_ratio=0.4, backlash=gb.Backlash(gaps=drive, coast_gaps=coast)
    ))  # fmt: skip
    rig.chain(rig.add("drive", gb.Torque(tau=gb.Parameter("torque", 1.0, "N m"))), body, spline, ground)
    model = gb.build(rig)
    for row in case["cycle"]["0.5"][:9]:
        run = gb.simulate(
            model, t=[0.05], parameters={"torque": row["T"]}, initial={"body.phi": 9e-5 / case["r2"]}, rtol=1e-10
        )
        assert run["spline.engaged_teeth"][0] == row["r"]
        assert run["spline.deflection"][0] == pytest.approx(row["s"], rel=1e-9)  # at rest to the tolerance
        assert run["spline.deflection"][0] == pytest.approx(
            deflection_at(row["T"] / case["r2"], drive, case["kt"]), rel=1e-9
        )


@pytest.mark.long
def test_equations_for_people_tell_every_law_of_backlash():
    for gap, words in (
        (gb.Backlash(half_gap=B, law="polynomial", coefficients=(0.1, 0.2)), "phi_body**3"),
        (gb.Backlash(half_gap=B, law="smooth", width=1e-3), "width_spline**2"),
        (gb.Backlash(gaps=(0.05, 0.1, 0.15)), "Max(0, phi_body*radius_spline - 0.15)"),
    ):
        equations = _rig(gap, choice="always").equations()
        assert words in str(equations.expanded), str(equations)
        assert len(str(equations)) < 5000


@pytest.mark.parametrize(
    ("gap", "choice", "words"),
    [
        (gb.Backlash(half_gap=B, law="cubic"), "always", "backlash.law = 'cubic' is not available"),
        (gb.Backlash(half_gap=B, law="polynomial"), "always", "needs either coefficients=(c1, c3, ...) or degree"),
        (gb.Backlash(half_gap=B, law="polynomial", degree=4), "always", "degree = 4 must be an odd whole number"),
        (gb.Backlash(half_gap=B, law="polynomial", degree=5, interval=1), "always", "interval = 1 half gaps must be"),
        (gb.Backlash(half_gap=0.0, law="polynomial", degree=5), "always", "half_gap = 0"),
        (gb.Backlash(half_gap=B, law="polynomial", degree=5), "clipped", "give contact_damping='always'"),
        (gb.Backlash(half_gap=B, law="smooth"), "always", "needs width"),
        (gb.Backlash(half_gap=B, law="smooth", width=B), "clipped_force", "give 'clipped' or 'always'"),
        (gb.Backlash(half_gap=B, law="smooth", width=0.0), "always", "width = 0.0 m must be > 0"),
        (gb.Backlash(half_gap=B, width=1e-3), "always", "backlash.width belongs to law='smooth'"),
        (gb.Backlash(), "always", "give either half_gap or gaps"),
        (gb.Backlash(half_gap=B, gaps=(B, B, B)), "always", "give either half_gap or gaps"),
        (gb.Backlash(gaps=(B, B)), "always", "has 2 gaps for 3 teeth"),
        (gb.Backlash(gaps=(B, B, -B)), "always", "must be a row of numbers >= 0"),
        (gb.Backlash(gaps=(B, B, B), coast_gaps=(B,)), "always", "3 gaps and 1 coast_gaps"),
        (gb.Backlash(half_gap=B, coast_gaps=(B, B, B)), "always", "coast_gaps needs gaps"),
        (gb.Backlash(gaps=(B, B, B), law="smooth", width=1e-3), "always", "needs half_gap"),
    ],
)  # fmt: skip
@pytest.mark.few(3)
def test_a_backlash_that_makes_no_law_is_refused_with_the_reason(gap, choice, words):
    with pytest.raises(gb.ModelError) as caught:
        _rig(gap, choice)
    assert words in str(caught.value), str(caught.value)


@pytest.mark.parametrize(
    "gap",
    [
        gb.Backlash(half_gap=B, law="polynomial", coefficients=PRINTED, interval=2.5),
        gb.Backlash(half_gap=B, law="polynomial", degree=7),
        gb.Backlash(half_gap=B, law="smooth", width=1e-3),
        gb.Backlash(gaps=(0.1, 0.2, 0.15), coast_gaps=(0.1, 0.3, 0.1)),
    ],
    ids=["coefficients", "degree", "smooth", "gaps"],
)
def test_a_law_of_backlash_survives_the_round_trip_through_a_file(gap, tmp_path):
    rig = _rig(gap)
    rig.to_json(tmp_path / "rig.json")
    assert gb.Drivetrain.from_json(tmp_path / "rig.json")["spline"] == rig["spline"]


@pytest.mark.parametrize("method", ["dp8", "dp5", "rodas"])
@pytest.mark.parametrize("c", [0.3, 0.7, 1.1, 1.5])
@pytest.mark.few(3)
def test_a_shaft_without_inertia_creeps_to_the_edge_of_its_gap_and_rests_there(method, c):
    """There both rates of the deflection are 0 to rounding: flips that rounding alone asks for end by themselves."""
    rig = gb.Drivetrain("rest")
    disc, drive = rig.add("disc", gb.Inertia(J=1.0, w0=2.0)), rig.add("drive", gb.Torque(tau=10 * gb.sin(7 * gb.time)))
    lash = rig.add("lash", gb.Lash(k=150.0, c=c, half_gap=0.02, contact_damping="always"))
    node = rig.add("node", gb.Inertia(J=0.0, phi0=0.1))
    rig.connect(drive.flange, disc.a)
    rig.connect(disc.b, lash.a)
    rig.connect(lash.b, node.a)
    run = gb.simulate(rig, t=np.linspace(0, 3, 61), rtol=1e-9, method=method)
    creep = 0.02 + 0.08 * np.exp(-150.0 / c * run.t)
    assert run["lash.twist"] == pytest.approx(creep, abs=1e-9)  # the tolerance


@pytest.mark.long
def test_a_shaft_without_inertia_between_gaps_starts_where_its_contacts_balance():
    """One contact opens as the shaft moves, which lets it on into a third: balance and sides are found together."""
    rig = gb.Drivetrain("three gaps")
    node, ground = rig.add("node", gb.Inertia(J=0.0)), rig.add("ground", gb.Fixed())
    pusher, opener = rig.add("pusher", gb.Inertia(J=1.0, phi0=0.1)), rig.add("opener", gb.Inertia(J=1.0, phi0=0.1))
    gaps = {"pushing": 0.02, "opening": 0.05, "stopping": 0.07}
    lashes = {n: rig.add(n, gb.Lash(k=100.0, c=1.0, half_gap=gap, contact_damping="always")) for n, gap in gaps.items()}
    rig.connect(node.a, *(lash.b for lash in lashes.values()))
    rig.connect(pusher.a, lashes["pushing"].a)
    rig.connect(opener.a, lashes["opening"].a)
    rig.connect(ground.flange, lashes["stopping"].a)
    run = gb.simulate(rig, t_end=0.01)
    # 100 (0.1 - 0.02 - phi) = 100 (phi - 0.07); a digit lost by each of the Newton steps from 0
    assert run["node.phi"][0] == pytest.approx(0.075, abs=1e-14)
    assert [run[f"{n}.contact"][0] for n in gaps] == [-1, 0, 1]
    assert run.energy.residual < 1e-9

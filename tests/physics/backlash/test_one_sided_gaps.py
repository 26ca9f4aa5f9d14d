"""Gaps with ends of their own, either of which may be absent, exponents of contact forces, and elements with a rest."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb


def _reference(f: Any, y0: list[float], t: np.ndarray[Any, Any], step: float) -> Any:
    found = solve_ivp(f, (0, t[-1]), y0, t_eval=t, rtol=1e-12, atol=1e-14, max_step=step, method="DOP853")
    return found.y


def _dropped(gap: gb.Lash) -> gb.Drivetrain:
    rig = gb.Drivetrain("dropped")
    mass = rig.add("mass", gb.Mass(m=2.0, s0=1.0, v0=-1.0))
    rig.chain(rig.add("ground", gb.Fixed()), rig.add("gap", gap), mass)
    rig.connect(mass.b, rig.add("weight", gb.Force(f=-19.62)).flange)
    return rig


LONG = pytest.mark.long


@pytest.mark.parametrize(
    ("method", "exponent"), [("rodas", 1.5), *(pytest.param("dp8", n, marks=LONG) for n in (1.0, 1.5, 3.0))]
)
def test_a_mass_bounces_on_an_elastic_gap(method: str, exponent: float) -> None:
    """Modelica's ElastoGap: f_c = k (s_rel0 - s_rel)^n, damping clipped to it."""
    k, c = 1e4, 20.0

    def f(_t: float, y: Any) -> list[float]:
        beyond = max(0.1 - y[0], 0.0)
        elastic = k * beyond**exponent
        return [y[1], (elastic + np.clip(-c * y[1], -elastic, elastic)) / 2.0 - 9.81]

    t = np.linspace(0, 0.6, 13)
    rig = _dropped(gb.Lash(k=k, c=c, lower="10 cm", exponent=exponent))
    run = gb.simulate(rig, t=t, method=method, rtol=1e-10)
    wanted = _reference(f, [1.0, -1.0], t, 1e-3)
    assert np.abs(run["mass.s"] - wanted[0]).max() < 1e-8  # the reference steps over corners
    assert run.energy.residual < 1e-8 and {e.component for e in run.events} > {"gap.lower"}
    assert set(np.unique(run["gap.contact"])) == {-1.0, 0.0}


@pytest.mark.long
def test_without_an_exponent_it_is_the_linear_contact_and_both_ends_are_the_gap_of_half_gap() -> None:
    t = np.linspace(0, 1.0, 51)
    one = gb.simulate(_dropped(gb.Lash(k=1e4, c=20.0, lower=0.1)), t=t, rtol=1e-10)
    same = gb.simulate(_dropped(gb.Lash(k=1e4, c=20.0, lower=0.1, exponent=1.0)), t=t, rtol=1e-10)
    assert one["mass.s"] == pytest.approx(same["mass.s"], abs=1e-9)

    def between(lash: gb.Lash) -> gb.Trajectory:
        rig = gb.Drivetrain("between")
        rig.chain(
            rig.add("left", gb.Inertia(J=1.0, w0=1.0)), rig.add("lash", lash), rig.add("right", gb.Inertia(J=2.0))
        )
        return gb.simulate(rig, t=t, rtol=1e-11)

    half = between(gb.Lash(k=1e3, c=1.0, half_gap=0.01))
    ends = between(gb.Lash(k=1e3, c=1.0, lower=-0.01, upper=0.01))
    shifted = between(gb.Lash(k=1e3, c=1.0, lower=-0.21, upper=-0.19, rest=0.2))
    for other in (ends, shifted):
        assert other["right.w"] == pytest.approx(half["right.w"], abs=1e-9)


@pytest.mark.long
def test_four_gaps_in_a_loop_are_met() -> None:
    """Modelica's PreLoad: a spool between two stops, preloaded by discs that its shoulders lift off their seats."""
    k, c, m, spool = 1e5, 100.0, 0.1, 0.5
    rig = gb.Drivetrain("preload")
    ground, valve = rig.add("ground", gb.Fixed()), rig.add("valve", gb.Mass(m=spool, s0=0.0))
    left, right = rig.add("left", gb.Mass(m=m, s0=-0.05)), rig.add("right", gb.Mass(m=m, s0=0.05))
    gaps = {
        "seat_left": (ground, left, {"lower": -0.05}), "lift_left": (left, valve, {"lower": 0.049}),
        "seat_right": (ground, right, {"upper": 0.05}), "lift_right": (valve, right, {"lower": 0.049}),
    }  # fmt: skip
    for name, (one, two, ends) in gaps.items():
        gap = rig.add(name, gb.Lash(k=k, c=c, **ends))
        rig.connect(one.flange if one is ground else one.b, gap.a)
        rig.connect(gap.b, two.a)
    preload = rig.add("preload", gb.Shaft(k=2e3, c=20.0, rest=0.2))
    rig.connect(left.b, preload.a)
    rig.connect(preload.b, right.a)
    rig.connect(valve.b, rig.add("push", gb.Force(f=300 * gb.sin(12 * gb.time))).flange)
    t = np.linspace(0, 0.4, 41)
    run = gb.simulate(rig, t=t, rtol=1e-10, method="dp8")

    def contact(x: float, v: float, lower: float | None = None, upper: float | None = None) -> float:
        g = x - lower if lower is not None and x < lower else x - upper if upper is not None and x > upper else 0.0
        elastic = k * g
        return elastic + float(np.clip(c * v, -abs(elastic), abs(elastic)))

    def f(time: float, y: Any) -> list[float]:
        (a, b, v), (wa, wb, wv) = y[:3], y[3:]
        spring = 2e3 * (b - a - 0.2) + 20.0 * (wb - wa)
        seat_a, seat_b = contact(a, wa, lower=-0.05), contact(b, wb, upper=0.05)
        lift_a, lift_b = contact(v - a, wv - wa, lower=0.049), contact(b - v, wb - wv, lower=0.049)
        forces = spring - seat_a + lift_a, -spring - seat_b - lift_b, 300 * np.sin(12 * time) - lift_a + lift_b
        return [wa, wb, wv, forces[0] / m, forces[1] / m, forces[2] / spool]

    wanted = _reference(f, [-0.05, 0.05, 0.0, 0.0, 0.0, 0.0], t, 2e-4)
    for name, positions in zip(("left", "right", "valve"), wanted, strict=False):
        assert np.abs(run[f"{name}.s"] - positions).max() < 1e-6 * 0.05, name


def _preload() -> gb.Drivetrain:
    """Modelica's PreLoad: lengths of masses and rods (half of each, or all) go into rest and lower."""
    k, d, wall, far = 1e6, 250.0, -0.0955, -0.0955 + 0.0305
    rig = gb.Drivetrain("PreLoad")
    left, right = rig.add("fixedLe", gb.Fixed(phi0=wall)), rig.add("housing", gb.Fixed(phi0=far))
    spool = rig.add("spool", gb.Mass(m=0.15, s0=0.01475, v0=0.0))
    plate_a = rig.add("springPlateA", gb.Mass(m=0.01, s0=-0.093, v0=0.0))
    plate_b = rig.add("springPlateB", gb.Mass(m=0.01, s0=-0.06925, v0=0.0))
    outer = gb.Lash(k=k, c=d, lower=0.0015 + 0.001)
    rig.chain(
        left, rig.add("outerContactA", outer), plate_a, rig.add("spring", gb.Shaft(k=2e4, rest=0.025 + 0.002)),
        plate_b, rig.add("outerContactB", outer), right,
    )  # fmt: skip
    lower_a, lower_b = 0.001 - 0.095 - 0.00575 - 0.008, 0.001 + 0.095 - 0.00575 - 0.008
    rig.chain(spool, rig.add("innerContactA", gb.Lash(k=k, c=d, lower=lower_a)), plate_a)
    rig.chain(plate_b, rig.add("innerContactB", gb.Lash(k=k, c=d, lower=lower_b)), spool)
    rig.chain(left, rig.add("friction", gb.Damper(c=2500.0)), spool)
    rig.connect(rig.add("force", gb.Force(f=150 * gb.sin(2 * np.pi * 0.01 * gb.time))).flange, spool.a)
    return rig


def _on_preload(y: Any, push: Any) -> Any:
    """Forces on plates and spool but for that of time; push(number, beyond, rate): of an ElastoGap that is too short by so
    much, and grows at that rate. Flanges lie where Modelica's do."""
    a, b, x, va, vb, v = y
    outer_a, outer_b = push(0, 0.0015 - ((a - 0.001) + 0.0955), va), push(1, 0.0015 - (-0.065 - (b + 0.001)), -vb)
    inner_a = push(2, 0.001 - ((a + 0.001 + 0.007) - (x - 0.095 - 0.00575)), va - v)
    inner_b = push(3, 0.001 - ((x - 0.095 + 0.00575) - (b - 0.001 - 0.007)), v - vb)
    spring = 2e4 * ((b - 0.001) - (a + 0.001) - 0.025)
    return np.array([outer_a + spring + inner_a, -outer_b - spring - inner_b, -2500 * v - inner_a + inner_b])


def test_the_plates_of_a_preloaded_spool_find_their_seats() -> None:
    def push(_number: int, beyond: float, rate: float) -> float:
        elastic = 1e6 * max(beyond, 0.0)
        return elastic - float(np.clip(250 * rate, -elastic, elastic))

    def f(time: float, y: Any) -> Any:
        force = np.array([0.0, 0.0, 150 * np.sin(0.02 * np.pi * time)])
        return np.concatenate([y[3:], (_on_preload(y, push) + force) / [0.01, 0.01, 0.15]])

    t = np.linspace(0, 0.005, 51)
    run = gb.simulate(_preload(), t=t, rtol=1e-10)
    wanted = _reference(f, [-0.093, -0.06925, 0.01475, 0.0, 0.0, 0.0], t, 1e-5)
    for name, positions in zip(("springPlateA", "springPlateB", "spool"), wanted, strict=False):
        assert np.abs(run[f"{name}.s"] - positions).max() < 1e-8 * np.ptp(positions), name


@pytest.mark.parametrize("method", ["auto", pytest.param("rodas", marks=LONG)])
def test_a_preloaded_spool_follows_its_spring(method: str) -> None:
    """Its 100 s: beyond the preload one plate rests on its seat and the other goes with the spool, in linear equations."""
    run, W = gb.simulate(_preload(), t=np.linspace(0, 100, 1001), rtol=1e-10, method=method), 0.02 * np.pi
    for touched, start in (((1, 2), 15.0), ((0, 3), 65.0)):

        def push(number: int, beyond: float, rate: float, touched: Any = touched) -> float:
            return 1e6 * beyond - 250 * rate if number in touched else 0.0

        constant = _on_preload(np.zeros(6), push)
        J = np.array([_on_preload(x, push) - constant for x in np.eye(6)]).T
        rest = np.linalg.solve(-J[:, :3], constant)
        wave = np.linalg.solve(-(W**2) * np.diag([0.01, 0.01, 0.15]) - J[:, :3] - 1j * W * J[:, 3:], [0, 0, 150])
        here = (run.t >= start) & (run.t <= start + 20)
        moved = rest[:, None] + (wave[:, None] * np.exp(1j * W * run.t[here])).imag
        for name, positions in zip(("springPlateA", "springPlateB", "spool"), moved, strict=True):
            assert np.abs(run[f"{name}.s"][here] - positions).max() < 1e-8 * np.ptp(moved[2]), name


@pytest.mark.long
def test_a_spring_rests_where_it_is_said() -> None:
    """x = rest + (x0 - rest) cos(w t) in closed form; the equilibrium lies at rest, energy is counted from there."""
    rig = gb.Drivetrain("free length")
    mass = rig.add("mass", gb.Mass(m=2.0, s0=0.5))
    rig.chain(rig.add("wall", gb.Fixed()), rig.add("spring", gb.Shaft(k=800.0, rest="30 cm")), mass)
    t = np.linspace(0, 1.0, 11)
    run = gb.simulate(rig, t=t, rtol=1e-12, method="dp8")
    assert run["mass.s"] == pytest.approx(0.3 + 0.2 * np.cos(20 * t), abs=1e-10)
    assert run["spring.torque"] == pytest.approx(-800 * 0.2 * np.cos(20 * t), abs=1e-7)
    assert run.energy.residual < 1e-10 and run["spring.twist"][0] == 0.5
    assert gb.simulate(rig, t=[0.0, 1.0], initial="static")["mass.s"] == pytest.approx([0.3, 0.3], abs=1e-12)
    assert gb.simulate(rig.set({"mass.s0": None}), t=[0.0, 1.0], initial="rolling")["mass.s"].tolist() == [0.3, 0.3]
    law = rig.set({"spring": gb.Shaft(torque=800.0 * gb.twist, rest=0.3)})
    assert gb.simulate(law, t=t, rtol=1e-12, method="dp8")["mass.s"] == pytest.approx(run["mass.s"], abs=1e-12)
    assert gb.simulate(rig, t=t, parameters={"spring.rest": 0.5})["mass.s"] == pytest.approx(
        np.full(11, 0.5), abs=1e-15
    )
    assert "rest = 30 cm" in rig.describe()


@pytest.mark.long
def test_a_gap_goes_and_its_end_stays_as_the_rest_of_the_spring() -> None:
    rig = _dropped(gb.Lash(k=1e4, lower=0.1))
    assert set(rig.effects()) == {"gap.compliance", "gap.backlash"}
    spring = rig.without("gap.backlash").set({"mass.v0": 0.0})
    assert "rest = 0.1 m" in spring.describe()
    assert gb.simulate(spring, t=[0.0, 1.0], initial="static")["mass.s"][0] == pytest.approx(
        0.1 - 19.62 / 1e4, rel=1e-9
    )
    both = gb.Lash(k=1e4, lower=gb.Parameter("low", 0.1), upper=0.3, rest=1.0).without_effect("backlash")
    assert gb.simulate(_dropped(both).set({"mass.v0": 0.0}), t=[0.0, 1.0], initial="static")["mass.s"][
        0
    ] == pytest.approx(1.2 - 1.962e-3, rel=1e-9)


def test_a_rigid_impact_has_one_end_too() -> None:
    gap = gb.Lash(k=1e4, lower=0.1, contact_damping=gb.HuntCrossley(restitution=0.5))
    rigid = gb.simulate(_dropped(gap).without("gap.compliance"), t_end=1.0, rtol=1e-9)
    v = np.sqrt(1 + 2 * 9.81 * 0.9)
    first = next(e for e in rigid.events if e.kind == "impact")
    assert first.t == pytest.approx((v - 1) / 9.81, rel=1e-9)
    low = rigid.between(first.t, 1.0)["mass.s"]
    assert low.min() > 0.1 - 1e-12 and rigid["gap.contact"].max() == 0.0


def test_contradictions_and_omissions_are_named(tmp_path: Path) -> None:
    for wrong, words in (
        ({"half_gap": 0.1, "lower": 0.0}, "half_gap and lower are both given"),
        ({"lower": 0.2, "upper": 0.1}, r"lower = 0.2 rad must be <= upper = 0.1 rad"),
        ({"half_gap": 0.1, "exponent": 0.5}, r"exponent = 0.5 must be >= 1"),
        ({"half_gap": 0.1, "exponent": 2.0, "damping_ratio": 0.1}, "damping_ratio needs a stiffness"),
    ):
        with pytest.raises(gb.ModelError, match=words):
            gb.Drivetrain("wrong").add("lash", gb.Lash(k=1.0, **wrong))  # type: ignore[arg-type]
    with pytest.raises(gb.ModelError, match=r"Lash needs half_gap \(half of the free play, rad\), or lower or upper"):
        gb.Lash(k=1.0)
    with pytest.raises(gb.ModelError, match="a rigid shaft has no rest"):
        gb.Drivetrain("wrong").add("shaft", gb.Shaft(rigid=True, rest=0.1))
    rig = _dropped(gb.Lash(k=1e4, c=20.0, lower=0.1, exponent=1.5))
    rig.to_json(tmp_path / "rig.json")
    assert gb.Drivetrain.from_json(tmp_path / "rig.json")["gap"] == rig["gap"]
    text = str(rig.equations())
    assert "F_gap = k_gap g_gap (|g_gap|)^(n_gap - 1) + d_gap" in text and "least deflection without force" in text

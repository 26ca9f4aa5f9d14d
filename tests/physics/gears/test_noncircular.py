"""Pairs of non-circular gears: torques, energy, phases, and that every form of a law moves a train alike."""

import numpy as np
import pytest

import gearblocks as gb

TURN = 2 * np.pi
X = np.deg2rad(240)
NORM = gb.RatioLaw.segments(0.7 / X, 0.5, X)
BENCH = gb.RatioLaw.segments(0.0886621042624866, 0.814306523064773, X)
ELLIPSE = gb.RatioLaw.ellipse(0.3)
E = 0.3
FITTED = gb.RatioLaw.from_function((1 - E**2) / (1 + E**2 - 2 * E * gb.cos(gb.driver_angle)))
WAVES = gb.RatioLaw.from_function(1 + 0.3 * gb.cos(gb.driver_angle) + 0.1 * gb.sin(2 * gb.driver_angle))
QUICK = (("segments", "internal"), ("fitted", "external"))
LAWS = pytest.mark.parametrize(
    "law",
    [
        pytest.param(NORM, id="segments"),
        pytest.param(ELLIPSE, id="ellipse", marks=pytest.mark.long),
        pytest.param(FITTED, id="fitted"),
        pytest.param(WAVES, id="waves", marks=pytest.mark.long),
    ],
)
SIDES = pytest.mark.parametrize("external", [False, True], ids=["internal", "external"])
LAWS_AND_SIDES = pytest.mark.parametrize(
    ("external", "law"),
    [
        pytest.param(external, law, id=f"{side}-{name}", marks=[pytest.mark.long] * ((name, side) not in QUICK))
        for side, external in (("internal", False), ("external", True))
        for name, law in (("segments", NORM), ("ellipse", ELLIPSE), ("fitted", FITTED), ("waves", WAVES))
    ],
)
T = np.linspace(0.0, 0.3, 301)


def _rig(law, *, external=False, carrier=None, load=-0.2, **mesh):
    rig = gb.Drivetrain("pair")
    sign = -1 if external else 1
    gear = gb.NonCircularGear(law=law, external=external, **({"k": 400.0} | mesh))
    one = rig.add("one", gb.Inertia(J=1e-4, w0=100.0))
    follows = mesh.get("k", 400.0) is None
    two = rig.add("two", gb.Inertia(J=2e-4, **({} if follows else {"w0": sign * float(law.m(0.0)) * 100.0})))
    pair = rig.add("mesh", gear)
    rig.connect(rig.add("drive", gb.Torque(tau=0.2)).flange, one.a)
    rig.connect(one.b, pair.a)
    rig.connect(pair.b, two.a)
    rig.connect(rig.add("load", gb.Torque(tau=sign * load)).flange, two.b)
    if carrier is not None:
        rig.connect(pair.carrier, rig.add("arm", carrier).a)
    return rig


@LAWS_AND_SIDES
@pytest.mark.few(1)
def test_generated_code_evaluates_the_law_as_numpy_does(law, external):
    run = gb.simulate(_rig(law, external=external), t=T, rtol=1e-8)
    theta = run["mesh.driver_angle"]
    assert np.ptp(theta) > 3 * TURN
    assert np.abs(run["mesh.ratio"] - law.m(theta)).max() < 1e-13
    sign = -1 if external else 1
    lead = law.F(theta) - sign * run["two.phi"]
    assert np.abs(run["mesh.deflection"] - lead).max() < 1e-13  # 30 rad are known to 4e-15


@LAWS_AND_SIDES
@pytest.mark.few(1)
def test_the_torques_of_a_pair_balance_about_the_axis_and_lose_no_power(law, external):
    run = gb.simulate(_rig(law, external=external, carrier=gb.Inertia(J=1e-3, w0=20.0)), t=T, rtol=1e-9)
    m, moment = run["mesh.ratio"], run["mesh.moment"]
    sign = -1 if external else 1
    size = np.abs(moment).max()
    assert size > 0.1
    assert np.abs(run["mesh.a.tau"] + m * moment).max() < 1e-12 * size
    assert np.abs(run["mesh.b.tau"] - sign * moment).max() < 1e-12 * size
    assert np.abs(run["mesh.carrier.tau"] - (m - sign) * moment).max() < 1e-12 * size
    assert run.energy.residual < 1e-8


@pytest.mark.long
@LAWS
@pytest.mark.few(1)
def test_a_free_pair_keeps_its_energy_though_its_stiffness_turns_with_the_driver(law):
    gear = {"k": 400 + 200 * gb.cos(3 * gb.driver_angle), "backlash": gb.Backlash(half_gap=2e-4)}
    rig = _rig(law, load=0.0, **gear).set({"drive.tau": 0.0, "two.w0": 0.9 * float(law.m(0.0)) * 100.0})
    run = gb.simulate(rig, t=T, rtol=1e-10)
    assert {-1.0, 0.0, 1.0} == set(run["mesh.contact"])
    energy = 0.5e-4 * run["one.w"] ** 2 + 1e-4 * run["two.w"] ** 2
    theta, q = run["mesh.driver_angle"], run["mesh.deflection"]
    beyond = np.maximum(np.abs(q) - 2e-4, 0)
    energy = energy + (400 + 200 * np.cos(3 * theta)) * beyond**2 / 2
    assert np.ptp(energy) < 1e-7 * energy[0]
    assert run.energy.residual < 1e-9


@pytest.mark.long
def test_a_stiffness_from_points_moves_the_pair_as_its_function_does():
    at = np.linspace(0, TURN, 401)
    points = gb.Table(at, 400 + 100 * np.cos(at).round(14), kind="cubic", periodic=True)
    runs = [gb.simulate(_rig(ELLIPSE, k=k), t=T, rtol=1e-9) for k in (points, 400 + 100 * gb.cos(gb.driver_angle))]
    # a spline through 400 points is a cosine to (pi/200)^4/384 = 2e-10
    assert np.abs(runs[0]["mesh.deflection"] - runs[1]["mesh.deflection"]).max() < 1e-7
    assert np.abs(runs[0]["two.w"] - runs[1]["two.w"]).max() < 1e-4


@pytest.mark.long
def test_a_fitted_law_moves_the_pair_as_the_closed_form_does():
    runs = [gb.simulate(_rig(law, c=0.01), t=T, rtol=1e-11) for law in (ELLIPSE, FITTED)]
    for name in ("one.w", "two.w", "mesh.moment"):
        assert np.abs(runs[0][name] - runs[1][name]).max() < 1e-7 * np.abs(runs[0][name]).max()


@pytest.mark.long
def test_circles_are_a_shaft_between_equal_turns():
    gear = gb.simulate(_rig(gb.RatioLaw.ellipse(0.0), c=0.01), t=T, rtol=1e-10)
    rig = gb.Drivetrain("shaft")
    rig.chain(
        rig.add("drive", gb.Torque(tau=0.2)), rig.add("one", gb.Inertia(J=1e-4, w0=100.0)),
        rig.add("shaft", gb.Shaft(k=400.0, c=0.01)), rig.add("two", gb.Inertia(J=2e-4, w0=100.0)),
        rig.add("load", gb.Torque(tau=-0.2)),
    )  # fmt: skip
    shaft = gb.simulate(rig, t=T, rtol=1e-10)
    assert np.abs(gear["mesh.torque"] - shaft["shaft.torque"]).max() < 1e-8
    assert np.abs(gear["two.w"] - shaft["two.w"]).max() < 1e-8


@pytest.mark.long
def test_a_vanishing_gap_gives_the_pair_without_one():
    bare = gb.simulate(_rig(NORM, c=0.01), t=T, rtol=1e-10)
    gap = gb.simulate(
        _rig(NORM, c=0.01, backlash=gb.Backlash(half_gap=1e-12), contact_damping="always"), t=T, rtol=1e-10
    )
    assert np.abs(bare["two.w"] - gap["two.w"]).max() < 1e-5  # k b is 4e-10 N m, over 0.3 s on 1e-4 kg m2


@pytest.mark.long
def test_joints_are_located_and_an_ellipse_has_none():
    run = gb.simulate(_rig(BENCH, c=0.01), t=T, rtol=1e-9)
    joints = np.array([e.t for e in run.events])
    assert len(joints) == pytest.approx(2 * run["one.phi"][-1] / TURN, abs=1)
    theta = gb.simulate(_rig(BENCH, c=0.01), t=joints, rtol=1e-9)["mesh.driver_angle"] % TURN
    # the angle at a joint is that of this run to the tolerance of 1e-9 of 30 rad
    assert np.minimum(np.abs(theta - X), np.minimum(theta, TURN - theta)).max() < 1e-6
    assert not gb.simulate(_rig(ELLIPSE, c=0.01), t=T, rtol=1e-9).events


@pytest.mark.parametrize("turn", [0.3, 5.0])
def test_a_phase_shifts_the_law_and_not_the_gears(turn):
    run = gb.simulate(_rig(NORM, c=0.01, phase=turn), t=T, rtol=1e-9)
    assert run["mesh.deflection"][0] == pytest.approx(0.0, abs=1e-15)
    assert run["mesh.driver_angle"][0] == pytest.approx(turn)
    lead = NORM.F(run["one.phi"] + turn) - NORM.F(turn) - run["two.phi"]
    assert np.abs(run["mesh.deflection"] - lead).max() < 1e-13


@pytest.mark.long
@pytest.mark.parametrize(
    "phase", [0.2 * gb.sin(40 * gb.time), gb.Table(np.linspace(0, 0.3, 31), 0.2 * np.sin(np.arange(31)), kind="cubic")],
    ids=["expression", "table"],
)  # fmt: skip
def test_a_moving_phase_does_work_that_is_counted(phase):
    t = np.linspace(0.0, 0.03, 3001)
    run = gb.simulate(_rig(NORM, c=0.01, phase=phase), t=t, rtol=1e-10)
    q = NORM.F(run["mesh.driver_angle"]) - NORM.F(run["mesh.driver_angle"][0]) - run["two.phi"]
    assert np.abs(run["mesh.deflection"] - q).max() < 1e-13
    rate = np.gradient(run["mesh.deflection"], t)
    # central differences over 10 us of a vibration at 2500 rad/s: (w h)^2/6 = 1e-4
    assert np.abs(run["mesh.deflection_rate"] - rate)[1:-1].max() < 1e-3 * np.abs(rate).max()
    assert run.energy.residual < 1e-9


@pytest.mark.long
@pytest.mark.parametrize("cut", [300.0, 900.0])
def test_the_rate_of_the_deflection_contains_that_of_a_filtered_phase(cut):
    t = np.linspace(0.0, 0.03, 3001)
    run = gb.simulate(
        _rig(NORM, c=0.01, phase=gb.piecewise((0, gb.time < 0.01), (0.3, True)), filter=cut), t=t, rtol=1e-10
    )
    rate = np.gradient(run["mesh.deflection"], t)
    # central differences over 10 us as above, but where the phase begins to move
    off = np.abs(run["mesh.deflection_rate"] - rate)[1:-1]
    assert off[np.abs(t[1:-1] - 0.01) > 2e-5].max() < 1e-3 * np.abs(rate).max()
    moment = 400.0 * run["mesh.deflection"] + 0.01 * run["mesh.deflection_rate"]
    assert np.allclose(run["mesh.moment"], moment, rtol=1e-12, atol=1e-12)
    assert run.energy.residual < 1e-9


@pytest.mark.long
def test_an_input_shifts_the_phase_of_a_compliant_pair():
    rig = _rig(ELLIPSE, c=0.01, phase=gb.Input("shift", start=0.4, unit="rad"))
    held = gb.simulate(rig, t=T, rtol=1e-10)
    same = gb.simulate(_rig(ELLIPSE, c=0.01, phase=0.4), t=T, rtol=1e-10)
    assert np.abs(held["two.w"] - same["two.w"]).max() < 1e-7
    moved = gb.simulate(rig, t=T, rtol=1e-10, inputs={"shift": gb.Table([0.0, 0.1], [0.4, 0.9], kind="step")})
    assert np.abs(moved["mesh.driver_angle"] - moved["one.phi"])[-1] == pytest.approx(0.9)


@pytest.mark.long
def test_an_error_of_the_teeth_is_taken_from_the_deflection():
    error = gb.Harmonic(cos=(1e-4,))
    run = gb.simulate(_rig(ELLIPSE, c=0.01, transmission_error=error), t=T, rtol=1e-10)
    theta = run["mesh.driver_angle"]
    q = ELLIPSE.F(theta) - run["two.phi"] - 1e-4 * np.cos(theta)
    assert np.abs(run["mesh.deflection"] - q).max() < 1e-13
    assert run.energy.residual < 1e-9


@pytest.mark.long
def test_a_damping_ratio_is_that_of_the_linear_pair():
    # circles, J 1e-4 and 2e-4: c = 2 zeta sqrt(k/(1/J1 + 1/J2))
    c = 2 * 0.05 * np.sqrt(400.0 / (1e4 + 5e3))
    given, ratio = (
        gb.simulate(_rig(gb.RatioLaw.ellipse(0.0), **damping), t=T, rtol=1e-10)
        for damping in ({"c": c}, {"damping_ratio": 0.05})
    )
    assert np.abs(given["mesh.moment"] - ratio["mesh.moment"]).max() < 1e-8


# -- rigid ------------------------------------------------------------------------------------------------------------


@LAWS_AND_SIDES
@pytest.mark.few(1)
def test_a_rigid_pair_turns_by_its_law_and_keeps_its_energy(law, external):
    run = gb.simulate(_rig(law, external=external, k=None), t=T, rtol=1e-10)
    sign = -1 if external else 1
    assert np.abs(sign * run["two.phi"] - law.F(run["one.phi"])).max() < 1e-14 * 30
    w, phi = run["one.w"], run["one.phi"]
    energy = (0.5e-4 + 1e-4 * law.m(phi) ** 2) * w**2 - 0.2 * phi + 0.2 * law.F(phi)
    assert np.ptp(energy) < 1e-8 * energy[0]
    assert run.energy.residual < 1e-8


@pytest.mark.long
@LAWS
@SIDES
def test_the_torques_of_a_rigid_pair_are_those_of_its_moment(law, external):
    run = gb.simulate(_rig(law, external=external, k=None, carrier=gb.Inertia(J=1e-3, w0=20.0)), t=T, rtol=1e-9)
    m, sign = run["mesh.ratio"], -1 if external else 1
    moment = sign * run["mesh.b.tau"]
    size = np.abs(moment).max()
    assert np.abs(run["mesh.a.tau"] + m * moment).max() < 1e-11 * size
    assert np.abs(run["mesh.carrier.tau"] - (m - sign) * moment).max() < 1e-11 * size
    assert run.energy.residual < 1e-8


@pytest.mark.long
@pytest.mark.parametrize(
    "law", [pytest.param(NORM, id="segments"), pytest.param(ELLIPSE, id="ellipse", marks=pytest.mark.long)]
)
def test_a_stiff_pair_comes_to_the_rigid_one(law):
    phase = 0.3 + 0.2 * gb.sin(20 * gb.time)
    rigid = gb.simulate(_rig(law, k=None, phase=phase), t=T, rtol=1e-10)
    distance = []
    for k in (1e4, 1e5):
        rig = _rig(law, k=k, c=2e-5 * k, phase=phase).set({"two.w0": float(rigid["two.w"][0])})
        stiff = gb.simulate(rig, t=T, rtol=1e-8)
        distance.append(np.abs(stiff["one.w"] - rigid["one.w"]).max())
    assert distance[1] < 0.3 * distance[0]  # a deflection M/k, a tenth of it with ten times the stiffness


@pytest.mark.long
def test_a_moving_phase_turns_the_driven_gear():
    """Driver and carrier at rest: gear 2 turns by F of the phase alone, which does the work."""
    rig = gb.Drivetrain("phase")
    gear = gb.NonCircularGear(law=NORM, external=False, phase=0.5 + 2.0 * gb.time + gb.sin(30 * gb.time))
    rig.chain(rig.add("hold", gb.Fixed()), rig.add("mesh", gear), rig.add("two", gb.Inertia(J=2e-4)))
    run = gb.simulate(rig, t=T, rtol=1e-10, max_step=1e-3)  # nothing has a state whose error would set the step
    theta = 0.5 + 2.0 * T + np.sin(30 * T)
    assert np.abs(run["two.phi"] - (NORM.F(theta) - NORM.F(0.5))).max() < 1e-13
    assert np.abs(run["two.w"] - NORM.m(theta) * (2.0 + 30 * np.cos(30 * T))).max() < 1e-11
    assert run.energy.residual < 1e-9


@pytest.mark.long
@pytest.mark.parametrize("compliance", [{"k": None}, {"k": 400.0, "c": 0.01}], ids=["rigid", "compliant"])
def test_a_filter_lets_an_input_move_the_phase(compliance):
    rig = _rig(ELLIPSE, phase=gb.Input("shift", start=0.4), filter=200.0, **compliance)
    step = gb.Table([0.0, 0.05], [0.4, 0.9], kind="step")
    run = gb.simulate(rig, t=T, rtol=1e-10, inputs={"shift": step})
    shift = run["mesh.driver_angle"] - run["one.phi"]
    late = np.maximum(T - 0.05, 0)
    assert np.abs(shift - (0.9 - 0.5 * (1 + 200 * late) * np.exp(-200 * late))).max() < 1e-8
    assert run["two.phi"][0] == pytest.approx(0.0, abs=1e-15)
    if compliance["k"] is None:
        lead = ELLIPSE.F(run["mesh.driver_angle"]) - ELLIPSE.F(0.4)
        assert np.abs(run["two.phi"] - lead).max() < 1e-12


@pytest.mark.long
def test_three_branches_of_non_circular_pairs_and_differentials_turn_evenly_in_their_windows():
    """Input speed 262 rad/s; each branch th_out' = 262 (m2 - m1): 0.175 of it inside of the window (law NORM, 60 deg)."""
    rig = gb.Drivetrain("branches")
    drive = rig.add("drive", gb.Speed(w=262.0))
    shafts = [drive.flange]
    for j in range(3):
        psi = (-TURN * j / 3) % TURN
        one = rig.add(f"one{j}", gb.NonCircularGear(law=NORM, external=False, phase=psi))
        two = rig.add(f"two{j}", gb.NonCircularGear(law=NORM, external=False, phase=psi + np.pi / 3))
        half = rig.add(f"half{j}", gb.IdealGear(ratio=2))
        diff = rig.add(f"diff{j}", gb.Differential())
        out = rig.add(f"out{j}", gb.Inertia(J=2e-6))
        shafts += [one.a, two.a]
        rig.connect(two.b, half.a)
        rig.connect(half.b, diff.carrier)
        rig.connect(one.b, diff.left)
        rig.connect(diff.right, out.a)
    rig.connect(*shafts)
    t = np.linspace(0.0, 0.05, 501)
    run = gb.simulate(rig, t=t, rtol=1e-10)
    even = np.zeros(len(t))
    for j in range(3):
        th = 262.0 * t - TURN * j / 3
        u = NORM.m(th + np.pi / 3) - NORM.m(th)
        assert np.abs(run[f"out{j}.w"] - 262.0 * u).max() < 262 * 1e-12
        even += np.abs(run[f"out{j}.w"] / 262.0 - 0.175) < 1e-12
    assert even.min() >= 1  # zeta = 1.5: always one branch at least


@pytest.mark.long
def test_friction_as_a_square_wave_raises_and_lowers_the_moment():
    wave = gb.piecewise((1.0, gb.sin(300 * gb.time) >= 0), (-1.0, True))
    friction = gb.ToothFriction(mu=0.1, direction="square_wave", wave=wave)
    run = gb.simulate(_rig(ELLIPSE, friction=friction), t=T[1:], rtol=1e-10)
    sign = np.where(np.sin(300 * T[1:]) >= 0, 1.0, -1.0)
    assert np.abs(run["mesh.moment"] - 400 * run["mesh.deflection"] * (1 + 0.1 * sign)).max() < 1e-12
    assert np.abs(run["mesh.b.tau"] - run["mesh.moment"]).max() < 1e-12
    assert run.energy.residual < 1e-8
    with pytest.raises(gb.ModelError, match="knows no teeth to slide on"):
        _rig(ELLIPSE, friction=gb.ToothFriction(mu=0.1))


@pytest.mark.long
@pytest.mark.parametrize("method", ["auto", "dp8", "rodas"])
def test_a_pair_that_dips_into_its_gap_for_less_than_a_step_goes_on(method):
    """Left at -q', the flank is met again after 2 q'/q'': far sooner than the steps that the free flight allows."""
    rig = _rig(ELLIPSE, external=True, k=1e4, c=1.0, backlash=gb.Backlash(half_gap=1e-3), load=0.0)
    rig = rig.set({"one.J": 0.1, "two.J": 0.05, "drive.tau": 1.0, "one.w0": 0.0, "two.w0": 0.0})
    run = gb.simulate(rig, t_end=1.0, rtol=1e-9, method=method)
    assert {-1.0, 0.0, 1.0} == set(run["mesh.contact"])
    assert run.energy.residual < 1e-8
    assert np.abs(run["mesh.deflection"]).max() < 3e-3

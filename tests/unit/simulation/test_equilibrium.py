"""Static starts: where a train settles under its loads, with excitations at their means or as they stand."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import CubicSpline

import gearblocks as gb
from benchmarks.cases import P1
from benchmarks.problems import p1

EXACT = 1e-12  # Newton's method ends at rounding; a few dozen operations follow
SHORT = {"t_end": 1e-9, "outputs": "*"}


def _at_rest(train, initial="static", **arguments):
    """The first row of a run from the equilibrium."""
    run = gb.simulate(train, initial=initial, **{**SHORT, **arguments})
    return {name: float(run[name][0]) for name in run.names}


def _held(element, tau, J=1.0):
    """A torque on a body, which an element holds against the ground."""
    rig = gb.Drivetrain("held")
    drive, body = rig.add("drive", gb.Torque(tau=tau)), rig.add("body", gb.Inertia(J=J))
    rig.chain(drive, body, rig.add("link", element), rig.add("ground", gb.Fixed()))
    return rig


def _without_angles(train):
    return train.set(dict.fromkeys(_angles(train)))


def _angles(train):
    return [f"{path}.phi0" for path, _, _, b in train._walk() if isinstance(b, gb.Inertia) and b.phi0 is not None]


def _model(name):
    spec = importlib.util.spec_from_file_location(
        f"{name}_of_static", Path(__file__).parents[3] / "models" / f"{name}.py"
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


# -- against starts computed by hand ----------------------------------------------------------------------------------


def test_the_spline_problem_starts_where_it_was_computed_by_hand():
    found, (left, mesh, right) = _at_rest(_without_angles(p1())), P1().start[:3]
    assert found["left.twist"] == pytest.approx(-left, rel=EXACT)
    assert found["mesh.deflection"] == pytest.approx(mesh * P1().radius, rel=EXACT)
    assert found["right.twist"] == pytest.approx(-right, rel=EXACT)


@pytest.mark.long
def test_the_stiff_chain_starts_where_it_was_computed_by_hand():
    model = _model("stiff_chain")
    problem = model.Numbers(n=200)
    found = _at_rest(_without_angles(model.chain(problem)))
    twists = np.array([-found[f"link{i}.twist"] for i in range(problem.n)])
    assert np.abs(twists / problem.twists - 1).max() < EXACT


def test_the_shipped_spline_coupling_starts_in_its_equilibrium():
    train = _model("spline_coupling").build()
    by_hand, found = _at_rest(train, None), _at_rest(_without_angles(train))
    for name in ("x1", "x2", "x3"):
        assert found[name] == pytest.approx(by_hand[name], rel=EXACT)
    assert found["v1"] == found["v2"] == found["v3"] == 0.0


# -- contact sides ----------------------------------------------------------------------------------------------------


def _two_gaps(load):
    """Torque, body, gap, body, wider gap, ground."""
    rig = gb.Drivetrain("two gaps")
    drive = rig.add("drive", gb.Torque(tau=load))
    a, b = rig.add("a", gb.Inertia(J=1e-3)), rig.add("b", gb.Inertia(J=2e-3))
    near = rig.add("near", gb.Lash(k=1e4, half_gap=1e-3, c=0.1))
    far = rig.add("far", gb.Lash(k=2e4, half_gap=3e-3))
    rig.chain(drive, a, near, b, far, rig.add("ground", gb.Fixed()))
    return rig


@pytest.mark.parametrize("load", [5.0, -5.0, 1e-9, -1e-4, 1e4])
def test_gaps_in_a_row_close_on_the_side_of_the_load(load):
    found, side = _at_rest(_two_gaps(load)), np.sign(load)
    assert found["near.twist"] == pytest.approx(-(load / 1e4 + side * 1e-3), rel=EXACT)
    assert found["far.twist"] == pytest.approx(-(load / 2e4 + side * 3e-3), rel=EXACT)
    assert found["near.contact"] == found["far.contact"] == -side


def test_a_gap_without_load_stays_where_it_is():
    start = _two_gaps(0.0).set({"a.phi0": 5e-4})
    found = _at_rest(start)
    assert found["near.twist"] == -5e-4
    assert found["near.contact"] == 0.0


@pytest.mark.long
def test_parallel_gaps_share_the_load_as_they_close_one_after_another():
    rig = gb.Drivetrain("parallel")
    drive, a = rig.add("drive", gb.Torque(tau=7.0)), rig.add("a", gb.Inertia(J=1e-3))
    b, ground = rig.add("b", gb.Inertia(J=1e-3)), rig.add("ground", gb.Fixed())
    rig.chain(drive, a)
    for i in (1, 2, 3, 9):
        lash = rig.add(f"lash{i}", gb.Lash(k=1e3 * i, half_gap=1e-3 * i))
        rig.chain(a, lash, b)
    rig.chain(b, rig.add("shaft", gb.Shaft(k=100.0)), ground)
    found = _at_rest(rig)
    # 1000 (x - 1) + 2000 (x - 2) + 3000 (x - 3) = 7 for x = 3.5e-3; the widest gap stays open
    assert [found[f"lash{i}.torque"] for i in (1, 2, 3, 9)] == pytest.approx([2.5, 3.0, 1.5, 0.0], rel=1e-11)
    assert found["shaft.torque"] == pytest.approx(7.0, rel=EXACT)


@pytest.mark.long
def test_four_planets_share_the_load_evenly():
    w = gb.Parameter("w", 6e4, "rad/s")
    rig = gb.Drivetrain("planetary")
    wave = gb.cos(w * gb.time)
    sun, carrier = rig.add("sun", gb.Inertia(J=2e-4)), rig.add("carrier", gb.Inertia(J=5e-3))
    ring = rig.add("ring", gb.Inertia(J=8e-3))
    rig.chain(rig.add("drive", gb.Torque(tau=300 * (1 + 0.1 * wave))), sun)
    rig.chain(rig.add("load", gb.Torque(tau=-300 * (1 + 7 / 3))), carrier)
    rig.chain(ring, rig.add("hold", gb.Shaft(k=5e6)), rig.add("ground", gb.Fixed()))
    for i in range(4):
        planet = rig.add(f"planet{i}", gb.Inertia(J=4e-5))
        for name, other, teeth, radii, k in (
            ("inner", sun, (30, 20), (0.03, 0.02), 2e8), ("outer", planet, (20, 70), (0.02, 0.07), 2.5e8),
        ):  # fmt: skip
            variation = gb.Fourier(cos=(0.25,), driven_by=w, phase=2 * np.pi * i / 4)
            gap = gb.Backlash(half_gap=20e-6)
            inner = name == "inner"
            mesh = rig.add(f"{name}{i}", gb.GearMesh(
                teeth=teeth, r_base=radii, external=inner, k=k, stiffness_variation=variation, backlash=gap
            ))  # fmt: skip
            rig.connect(mesh.pinion, other.a)
            rig.connect(mesh.wheel, planet.a if inner else ring.a)
            rig.connect(mesh.carrier, carrier.a)
    found = _at_rest(rig)
    for name, k in (("inner", 2e8), ("outer", 2.5e8)):
        deflections = [abs(found[f"{name}{i}.deflection"]) for i in range(4)]
        # at the mean stiffness; 1e-11: the loads differ by 1e-13 of the forces, which loops of meshes pass on
        assert deflections == pytest.approx([20e-6 + 300 / 0.03 / 4 / k] * 4, rel=1e-11)
    assert abs(found["hold.torque"]) == pytest.approx(300 * 7 / 3, rel=1e-11)


class OneWay(gb.Block):
    """A spring that can only be pushed."""

    a, b = gb.Flange("left end"), gb.Flange("right end")
    k: float = gb.param("stiffness", "N m/rad")

    def physics(self, s):
        import sympy as sp

        yield gb.Force(s.a.phi - s.b.phi, s.k * sp.Max(s.a.phi - s.b.phi, 0))


def test_a_load_that_nothing_carries_is_refused_by_name():
    assert _at_rest(_held(OneWay(k=1e3), 2.0))["body.phi"] == pytest.approx(2e-3, rel=EXACT)
    with pytest.raises(gb.SimulationError, match="'link': there is no static equilibrium: nothing carries the load"):
        _at_rest(_held(OneWay(k=1e3), -2.0))


# -- what turns -------------------------------------------------------------------------------------------------------


def _free(speeds=(None, None)):
    rig = gb.Drivetrain("free")
    a, b = (rig.add(n, gb.Inertia(J=J, w0=w)) for n, J, w in zip("ab", (1.0, 3.0), speeds, strict=True))
    rig.chain(rig.add("drive", gb.Torque(tau=8.0)), a, rig.add("shaft", gb.Shaft(k=1e3, c=1.0)), b)
    return rig


@pytest.mark.long
def test_a_free_train_under_unbalanced_torque_keeps_its_deflection_while_it_speeds_up():
    run = gb.simulate(_free(), t_end=1.0, initial="static", rtol=1e-10)
    assert np.abs(run["shaft.torque"] - 6.0).max() < 1e-9  # 3/4 of the torque goes through the shaft
    assert run["b.w"][-1] == pytest.approx(2.0, rel=1e-10)  # (8 N m)/(4 kg m2), from the first instant


@pytest.mark.long
def test_a_start_angle_of_one_gear_is_no_deflection_of_the_mesh():
    rig = gb.Drivetrain("turned")
    pinion, wheel = rig.add("pinion", gb.Inertia(J=0.02, phi0=0.3)), rig.add("wheel", gb.Inertia(J=0.05))
    error = gb.Harmonic(sin=(1e-6,))
    mesh = rig.add("mesh", gb.GearMesh(
        teeth=(23, 41), r_base=(0.023, 0.041), external=True, k=2e8, transmission_error=error,
        stiffness_variation=gb.Fourier(cos=(0.2,)), backlash=gb.Backlash(half_gap=1e-5),
    ))  # fmt: skip
    drive, load = rig.add("drive", gb.Torque(tau=20.0)), rig.add("load", gb.Torque(tau=20.0 * 41 / 23))
    rig.chain(drive, pinion, mesh, wheel, load)
    found = _at_rest(rig)
    assert found["pinion.phi"] == 0.3
    assert found["mesh.force"] == pytest.approx(20.0 / 0.023, rel=1e-3)  # what turns the errors takes its share
    assert found["pinion.alpha"] / found["wheel.alpha"] == pytest.approx(-41 / 23, rel=1e-6)  # all turns as one


def test_start_speeds_are_kept_when_all_turn_together_and_refused_when_not():
    found = _at_rest(_free((10.0, 10.0)))
    assert found["a.w"] == found["b.w"] == 10.0
    with pytest.raises(gb.ParameterError, match=r"'shaft' would wind up at -7 rad/s; 'b\.w' = 3 contradicts the 10"):
        _at_rest(_free((10.0, 3.0)))


def test_states_of_blocks_settle_too():
    class Motor(gb.Block):
        flange = gb.Flange("shaft")
        L: float = gb.param("inductance", "H")
        R: float = gb.param("resistance", "Ohm")
        K: float = gb.param("motor constant", "V s")
        voltage = gb.signal("voltage", "V")
        i = gb.State("current", "A")

        def physics(self, s):
            yield gb.Rate(s.i, (s.voltage - s.R * s.i - s.K * s.flange.w) / s.L)
            yield gb.Acts(s.flange, s.K * s.i)
            yield gb.Shows("i", s.i, "A")

    rig = gb.Drivetrain("motor")
    motor = rig.add("motor", Motor(L=0.1, R=2.0, K=0.5, voltage=12 + gb.sin(100 * gb.time)))
    rig.chain(motor, rig.add("body", gb.Inertia(J=1.0, w0=2.0)))
    assert _at_rest(rig)["motor.i"] == pytest.approx((12 - 0.5 * 2.0) / 2.0, rel=EXACT)


@pytest.mark.long
def test_what_is_softer_or_stiffer_than_a_line_settles_too():
    for torque, twist in (
        (1e6 * gb.twist**3, 0.02),
        (1e3 * gb.twist + 1e6 * gb.twist**3, 0.00756675886689259),  # the real root of 1e6 x^3 + 1e3 x = 8
        (gb.Table([-1, 0, 0.1, 1], [-50, 0, 2, 80]), 0.16),
    ):
        assert abs(_at_rest(_held(gb.Shaft(torque=torque), 8.0))["link.twist"]) == pytest.approx(twist, rel=EXACT)


# -- means ------------------------------------------------------------------------------------------------------------

SAW = gb.Table([0.0, 1.0, 3.0], [1.0, 4.0, 1.0], periodic=True)
WAVE = gb.Table([0.0, 1.0, 2.5, 3.0], [1.0, 4.0, 2.0, 1.0], kind="cubic", periodic=True)
STAIR = gb.Table([0.0, 1.0, 3.0], [1.0, 4.0, 9.0], kind="step", periodic=True)
_SPLINE = CubicSpline([0.0, 1.0, 2.5, 3.0], [1.0, 4.0, 2.0, 1.0], bc_type="periodic")
W = gb.Parameter("w", 30.0, "rad/s")
T = 0.02


@pytest.mark.parametrize(
    ("tau", "mean"),
    [
        (5 + 3 * gb.sin(30 * gb.time), 5.0),
        pytest.param(5 + 3 * gb.cos(W * gb.time + 0.3) ** 2, 6.5, marks=pytest.mark.long),
        pytest.param(5 + 3 * gb.cos(W * gb.time) ** 3, 5.0, marks=pytest.mark.long),
        (8 * gb.sin(W * gb.time) ** 4, 3.0),
        pytest.param(5 * (1 + 0.5 * gb.cos(W * gb.time)) ** 2, 5 * (1 + 0.25 / 2), marks=pytest.mark.long),
        # products of excitations: of the means of their factors
        (5 * (1 + 0.5 * gb.cos(W * gb.time)) * (2 + gb.cos(W * gb.time)), 10.0),
        (gb.piecewise((3.0, gb.sin(W * gb.time) > 0.5), (1.0, True)), 1 + 2 / 3),
        pytest.param(gb.piecewise((3.0, gb.sin(W * gb.time) > -2), (1.0, True)), 3.0, marks=pytest.mark.long),
        pytest.param(gb.piecewise((3.0, 1 - 2 * gb.cos(W * gb.time) > 0), (0.0, True)), 2.0, marks=pytest.mark.long),
        pytest.param(SAW, 2.5, marks=pytest.mark.long),
        (STAIR, (1 + 2 * 4) / 3),
        (WAVE, quad(_SPLINE, 0, 1)[0] / 3 + quad(_SPLINE, 1, 2.5)[0] / 3 + quad(_SPLINE, 2.5, 3)[0] / 3),
        # what never repeats stays as it stands at the start
        (2 + 100 * gb.time, 2 + 100 * T),
        (gb.Table([0.0, 1.0], [1.0, 4.0]), 1 + 3 * T),
        pytest.param(gb.piecewise((3.0, gb.time > 0.01), (1.0, True)), 3.0, marks=pytest.mark.long),
        (gb.Input("u", start=2.5), 2.5),
        (7 * gb.cos(0 * W * gb.time + 0.25), 7 * np.cos(0.25)),
    ],
)  # fmt: skip
@pytest.mark.few(1)
def test_every_excitation_has_its_mean(tau, mean):
    found = _at_rest(_held(gb.Shaft(k=1e3), tau), t_start=T, t_end=T + 1e-9)
    assert abs(found["link.twist"]) == pytest.approx(mean / 1e3, rel=EXACT)


@pytest.mark.long
def test_an_excitation_whose_frequency_is_zero_stays_as_it_stands():
    rig = _held(gb.Shaft(k=1e3), 5 + 3 * gb.cos(W * gb.time + 0.25))
    assert abs(_at_rest(rig, parameters={"w": 0.0})["link.twist"]) == pytest.approx(
        (5 + 3 * np.cos(0.25)) / 1e3, rel=EXACT
    )
    assert abs(_at_rest(rig)["link.twist"]) == pytest.approx(5e-3, rel=EXACT)


def test_static_at_start_takes_everything_as_it_stands():
    rig = _held(gb.Shaft(k=1e3), 5 + 3 * gb.sin(W * gb.time))
    run = gb.simulate(rig, t_start=T, t_end=T + 1e-9, initial="static_at_start")
    assert abs(run["link.twist"][0]) == pytest.approx((5 + 3 * np.sin(30 * T)) / 1e3, rel=EXACT)
    assert abs(run["body.alpha"][0]) < 1e-12 * 5.0


def test_a_run_from_the_equilibrium_of_constant_loads_does_not_move():
    run = gb.simulate(_two_gaps(5.0), t_end=0.1, initial="static")
    assert run.stats.events == 0
    assert np.ptp(run["near.twist"]) < 1e-12 * 1e-3  # rounding of the forces, at rest


@pytest.mark.long
def test_a_contact_that_is_active_at_the_start_is_in_its_mode():
    rig = gb.Drivetrain("in contact")
    a = rig.add("a", gb.Inertia(J=1.0, phi0=-0.3))
    rig.chain(a, rig.add("lash", gb.Lash(k=100.0, half_gap=0.1)), rig.add("ground", gb.Fixed()))
    run = gb.simulate(rig, t_end=1e-3)
    assert run["lash.contact"][0] == 1.0
    assert run["lash.torque"][0] == pytest.approx(-100 * 0.2, rel=1e-14)
    assert run["a.alpha"][0] == pytest.approx(20.0, rel=1e-14)
    assert run.stats.events == 0


def test_other_words_for_a_start_are_refused_with_the_near_one():
    with pytest.raises(gb.ParameterError, match="did you mean 'static'"):
        _at_rest(_free(), "statik")


# -- shafts without inertia, prescribed motion, ties of three shafts, sliders ---------------------------------------


@pytest.mark.long
@pytest.mark.parametrize("c", [pytest.param(None, marks=pytest.mark.long), 2.0])
def test_springs_in_a_row_without_inertia_between_carry_the_load_together(c):
    rig = gb.Drivetrain("in a row")
    drive, body = rig.add("drive", gb.Torque(tau=3.0)), rig.add("body", gb.Inertia(J=1.0))
    soft, stiff = rig.add("soft", gb.Shaft(k=1e3, c=c)), rig.add("stiff", gb.Shaft(k=4e3))
    rig.chain(drive, body, soft, stiff, rig.add("ground", gb.Fixed()))
    found = _at_rest(rig)
    assert found["soft.twist"] == pytest.approx(-3e-3, rel=EXACT)
    assert found["stiff.twist"] == pytest.approx(-7.5e-4, rel=EXACT)
    # J s^2 = -K(s) with 1/K = 1/(k1 + c s) + 1/k2
    roots = np.roots([c or 0.0, 5e3, 4e3 * (c or 0.0), 4e6])
    assert gb.modes(rig).frequencies == pytest.approx([np.abs(roots[roots.imag > 0]).item()], rel=1e-9)


@pytest.mark.long
def test_a_train_behind_a_prescribed_speed_turns_with_its_mean():
    rig = gb.Drivetrain("prescribed")
    rig.chain(
        rig.add("speed", gb.Speed(w=10 + gb.sin(30 * gb.time))), rig.add("a", gb.Inertia(J=1.0)),
        rig.add("shaft", gb.Shaft(k=1e3, c=1.0)), rig.add("b", gb.Inertia(J=1.0, w0=10.0)),
        rig.add("load", gb.Torque(tau=-4.0)),
    )  # fmt: skip
    assert _at_rest(rig)["shaft.twist"] == pytest.approx(-4e-3, rel=EXACT)
    assert gb.modes(rig).free == 0
    assert _at_rest(rig.set({"b.w0": None})) == _at_rest(rig)


@pytest.mark.long
def test_a_planetary_set_shares_the_load_in_the_ratio_of_its_arms():
    rig = gb.Drivetrain("set")
    sun, carrier, ring = (rig.add(n, gb.Inertia(J=J)) for n, J in (("sun", 0.01), ("carrier", 0.05), ("ring", 0.1)))
    planets = rig.add("planets", gb.IdealPlanetary(ratio=3.0))
    for body, flange in ((sun, planets.sun), (carrier, planets.carrier), (ring, planets.ring)):
        rig.connect(body.a, flange)
    ground = rig.add("ground", gb.Fixed())
    rig.chain(rig.add("drive", gb.Torque(tau=5.0)), sun)
    rig.chain(ring, rig.add("hold", gb.Shaft(k=1e5)), ground)
    rig.chain(carrier, rig.add("out", gb.Shaft(k=1e4)), ground)
    found = _at_rest(rig)
    assert abs(found["hold.torque"]) == pytest.approx(15.0, rel=EXACT)
    assert abs(found["out.torque"]) == pytest.approx(20.0, rel=EXACT)


@pytest.mark.long
def test_a_slider_settles_as_a_shaft_does():
    rig = gb.Drivetrain("slider")
    mass, spring = rig.add("mass", gb.Mass(m=2.0)), rig.add("spring", gb.Shaft(k=500.0))
    rig.connect(mass.a, spring.a)
    pinion, rack = rig.add("pinion", gb.Inertia(J=0.1)), rig.add("rack", gb.Rack(radius=0.5))
    rig.connect(spring.b, rack.slider)
    rig.connect(rack.flange, pinion.a)
    rig.chain(pinion, rig.add("shaft", gb.Shaft(k=100.0)), rig.add("ground", gb.Fixed()))
    rig.connect(rig.add("drive", gb.Torque(tau=6.0)).flange, pinion.a)
    found = _at_rest(rig)
    assert abs(found["shaft.twist"]) == pytest.approx(0.06, rel=EXACT)
    swinging = gb.modes(rig)
    M, K = np.diag([2.0, 0.1]), np.array([[500.0, -250.0], [-250.0, 125.0 + 100.0]])
    assert swinging.frequencies == pytest.approx(np.sqrt(np.sort(np.linalg.eigvals(np.linalg.solve(M, K)))), rel=1e-8)
    assert set(swinging.bodies) == {"mass", "pinion"}

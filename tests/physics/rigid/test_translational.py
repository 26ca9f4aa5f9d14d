"""Bodies that slide: the same laws in metres and newtons, tied to turning shafts by racks."""

from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.train.handles import FlangeHandle

NAN = float("nan")


def _chain(name: str, **blocks: gb.Block) -> gb.Drivetrain:
    rig = gb.Drivetrain(name)
    rig.chain(*(rig.add(part, block) for part, block in blocks.items()))
    return rig


def _wheel() -> gb.Drivetrain:
    return _chain(
        "rolling wheel", torque=gb.Torque(tau=gb.piecewise((0, gb.time < 0.1), (10, True))), inertia=gb.Inertia(J=1.0),
        rolling=gb.Rack(radius=1), mass=gb.Mass(m=1.0), drag=gb.SpeedLoad(coeffs=(0.0, 0.0, 10 / 25)),
    )  # fmt: skip


@pytest.mark.parametrize(("rtol", "near"), [(1e-9, 1e-8), (1e-6, 1e-5)])  # tens of steps, each within rtol
def test_a_wheel_that_rolls_against_a_square_drag_runs_up_as_tanh(rtol, near, distance):
    t = np.linspace(0, 5, 201)
    run = gb.simulate(_wheel(), t=t, rtol=rtol)
    rolling = np.maximum(t - 0.1, 0)
    assert distance(run["inertia.w"], 5 * np.tanh(rolling)) < near
    assert distance(run["inertia.phi"], 5 * np.log(np.cosh(rolling))) < near
    assert np.array_equal(run["mass.v"], run["inertia.w"])
    assert np.array_equal(run["mass.s"], run["inertia.phi"])
    assert run.energy.residual < 10 * rtol


def test_a_rack_gives_to_the_slider_what_it_takes_from_the_pinion() -> None:
    radius, m, J, tau = -0.25, 3.0, 0.4, 2.0
    rig = _chain(
        "rack", drive=gb.Torque(tau=tau), pinion=gb.Inertia(J=J), rack=gb.Rack(radius=radius), table=gb.Mass(m=m, v0=0.5),
        push=gb.Force(f=1.5),
    )  # fmt: skip
    run = gb.simulate(rig, t=np.linspace(0, 2, 11), rtol=1e-10)
    acceleration = (tau / radius + 1.5) / (m + J / radius**2)
    exact = {"rtol": 1e-12, "atol": 1e-12}  # a polynomial of time: rounding alone
    assert np.allclose(run["table.acceleration"], acceleration, **exact)
    assert np.allclose(run["table.v"], 0.5 + acceleration * run.t, **exact)
    assert np.allclose(run["pinion.w"], run["table.v"] / radius, **exact)
    assert np.allclose(run["rack.force"], m * acceleration - 1.5, **exact)
    assert np.allclose(run["rack.flange.tau"], -radius * run["rack.force"], **exact)
    assert np.allclose(run["rack.flange.power"] + run["rack.slider.power"], 0.0, **exact)
    assert np.allclose(run["rack.slider.f"], run["rack.force"], **exact)
    assert np.allclose(run["table.kinetic_energy"], m * run["table.v"] ** 2 / 2, **exact)


BLOCKS = {
    "spring": gb.Shaft(k=300.0, c=2.0), "lash": gb.Lash(k=800.0, half_gap=0.05, c=1.0), "damper": gb.Damper(c=4.0),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize(
    "between", ["spring", *(pytest.param(name, marks=pytest.mark.long) for name in ("lash", "damper"))]
)
def test_a_line_of_masses_moves_as_a_line_of_inertias_of_the_same_numbers(between: str) -> None:
    load = gb.SpeedLoad(coeffs=(0.0, 0.3, 0.2))
    line = _chain(
        "line", push=gb.Force(f=20.0 * gb.sin(9 * gb.time)), a=gb.Mass(m=2.0, s0=0.3), e=BLOCKS[between],
        b=gb.Mass(m=0.5, v0=1.0), load=load,
    )  # fmt: skip
    shaft = _chain(
        "shaft", push=gb.Torque(tau=20.0 * gb.sin(9 * gb.time)), a=gb.Inertia(J=2.0, phi0=0.3), e=BLOCKS[between],
        b=gb.Inertia(J=0.5, w0=1.0), load=load,
    )  # fmt: skip
    t = np.linspace(0, 3, 61)
    slides, turns = gb.simulate(line, t=t, rtol=1e-8), gb.simulate(shaft, t=t, rtol=1e-8)
    for own, other in (("a.s", "a.phi"), ("b.v", "b.w"), ("e.torque", "e.torque"), ("e.b.f", "e.b.tau")):
        assert np.array_equal(slides[own], turns[other])
    assert len(slides.events) == len(turns.events)
    assert slides.energy.residual < 1e-6


def test_units_and_names_follow_what_a_block_stands_on() -> None:
    model = gb.build(_chain("line", ground=gb.Fixed(), spring=gb.Shaft(k=5.0, c=0.1), a=gb.Mass(m=2.0)))
    units = {q.name: q.unit for q in model.program.outputs}
    expected = {
        "a.s": "m", "a.v": "m/s", "a.acceleration": "m/s2", "spring.twist": "m", "spring.torque": "N",
        "spring.b.s": "m", "spring.b.v": "m/s", "spring.b.f": "N", "spring.b.power": "W", "ground.torque": "N",
    }  # fmt: skip
    assert {name: units[name] for name in expected} == expected
    assert not any(name.endswith((".phi", ".w", ".tau")) for name in units)
    units = {p.path: p.unit for p in model.program.parameters}
    expected = {
        "spring.k": "N/m", "spring.c": "N s/m", "ground.phi0": "m", "a.m": "kg", "a.s0": "m", "a.v0": "m/s"
    }  # fmt: skip
    assert {name: units[name] for name in expected} == expected
    text = _chain("line", ground=gb.Fixed(), spring=gb.Shaft(k=5.0), a=gb.Mass(m=2.0)).describe()
    assert "k = 5 N/m" in text
    assert "k = 5 N m/rad" in _chain("shaft", spring=gb.Shaft(k=5.0), a=gb.Inertia(J=2.0)).describe()


def test_a_mass_on_a_spring_is_held_by_the_ground_at_its_place() -> None:
    rig = _chain(
        "hung", ground=gb.Fixed(phi0=0.2), spring=gb.Shaft(k=50.0, c=5.0), a=gb.Mass(m=2.0), weight=gb.Force(f=-19.6)
    )
    rest = gb.simulate(rig, t=[60.0], rtol=1e-10)  # decays as exp(-1.25 t)
    assert rest["a.s"][0] == pytest.approx(0.2 - 19.6 / 50, rel=1e-9)
    assert rest["ground.torque"][0] == pytest.approx(19.6, rel=1e-9)
    swing = gb.simulate(rig, t=[0.0, 0.1], initial={"a.s": 0.5, "a.v": -1.0})
    assert (swing["a.s"][0], swing["a.v"][0]) == (0.5, -1.0)


@pytest.mark.long
def test_a_slider_is_led_by_a_prescribed_position_or_speed(distance):
    t = np.linspace(0, 2, 41)
    weight, spring = gb.Mass(m=2.0), gb.Shaft(k=300.0)
    rig = _chain("led", lead=gb.Angle(phi=0.1 * gb.sin(7 * gb.time)), a=weight, spring=spring, ground=gb.Fixed())
    run = gb.simulate(rig, t=t, rtol=1e-9)
    assert distance(run["a.s"], 0.1 * np.sin(7 * t)) < 1e-13
    assert distance(run["lead.torque"], (300.0 - 2.0 * 49.0) * 0.1 * np.sin(7 * t)) < 1e-12
    assert run.units["lead.torque"] == "N"
    moved = gb.simulate(_chain("led", lead=gb.Speed(w=3.0 * gb.time), a=weight), t=t, rtol=1e-9)
    assert distance(moved["a.s"], 1.5 * t**2) < 1e-12
    assert distance(moved["lead.torque"], 6.0) < 1e-12


def test_equations_of_a_slider_are_in_its_letters() -> None:
    text = str(_chain("line", ground=gb.Fixed(), spring=gb.Shaft(k=5.0), a=gb.Mass(m=2.0)).equations())
    assert "m_a s_a'' = -F_spring" in text
    assert "F_spring = k_spring x_spring" in text


@pytest.mark.long
def test_masses_that_become_one_keep_the_first_position() -> None:
    rig = _chain("line", a=gb.Mass(m=2.0, s0=0.3), e=gb.Shaft(k=5.0), b=gb.Mass(m=1.0, s0=0.1)).without("e.compliance")
    assert rig.dropped == ("e.compliance", "b.s0")
    assert gb.simulate(rig, t=[0.0, 1.0])["b.s"][0] == 0.3


def test_force_stands_for_the_contribution_too() -> None:
    assert repr(gb.Force(1, 2)) == repr(gb.Force(deflection=1, force=2)) == "Force(deflection=1, force=2)"
    assert isinstance(gb.Force(f=1.0), gb.Block)


class Winch(gb.Block):
    """A rope that winds up: a user's block with a slider."""

    drum = gb.Flange("drum")
    rope = gb.Flange("rope", slider=True)
    r: float = gb.param("radius", "m", gt=0)
    k: float = gb.param("stiffness of the rope", "N/m", gt=0)

    def physics(self, s):
        stretch = s.rope.s - s.r * s.drum.phi
        yield gb.Force(stretch, s.k * stretch)
        yield gb.Energy(stored=s.k * stretch**2 / 2)
        yield gb.Shows("force", s.k * stretch, "N")


def test_a_block_of_a_user_joins_a_drum_to_a_slider(distance):
    rig = _chain("winch", drum=gb.Inertia(J=0.5, w0=2.0), winch=Winch(r=0.2, k=400.0), load=gb.Mass(m=4.0))
    t = np.linspace(0, 2, 41)
    run = gb.simulate(rig, t=t, rtol=1e-11)
    mobility = 1 / 4.0 + 0.2**2 / 0.5
    omega = np.sqrt(400.0 * mobility)
    stretch = -0.4 / omega * np.sin(omega * t)
    assert distance(run["winch.force"], 400.0 * stretch) < 1e-9
    assert run.energy.residual < 1e-10


# -- refusals ---------------------------------------------------------------------------------------------------------


def test_a_slider_on_a_turning_shaft_is_refused_by_name() -> None:
    words = r"flange 'b' of Mass 'car' slides, but flange 'a' of Inertia 'wheel'.*turns: put a Rack between them"
    with pytest.raises(gb.ModelError, match=words):
        _chain("wrong", car=gb.Mass(m=1.0), wheel=gb.Inertia(J=1.0)).train()
    with pytest.raises(gb.ModelError, match=r"through Damper 'd', Shaft 'e'"):
        _chain("wrong", car=gb.Mass(m=1.0), d=gb.Damper(c=1.0), e=gb.Shaft(k=1.0), wheel=gb.Inertia(J=1.0)).train()
    with pytest.raises(gb.ModelError, match=r"of Force 'push' slides, but .*'wheel'"):
        _chain("wrong", push=gb.Force(f=1.0), wheel=gb.Inertia(J=1.0)).train()
    inner = gb.Drivetrain("inner")
    inner.expose("end", inner.add("car", gb.Mass(m=1.0)).a)
    rig = gb.Drivetrain("outer")
    rig.chain(rig.add("inner", inner), rig.add("wheel", gb.Inertia(J=1.0)))
    with pytest.raises(gb.ModelError, match=r"'inner\.car' slides"):
        gb.build(rig)


def test_start_values_that_contradict_through_a_rack_are_refused() -> None:
    rig = _chain("rack", pinion=gb.Inertia(J=1.0, w0=2.0), rack=gb.Rack(radius=0.5), table=gb.Mass(m=1.0, v0=2.0))
    with pytest.raises(gb.ModelError, match=r"'pinion': w0 = 2.0 and 'table': v0 = 2.0 contradict"):
        gb.build(rig)
    held = _chain("held", ground=gb.Fixed(), table=gb.Mass(m=1.0, v0=2.0))
    with pytest.raises(gb.ModelError, match=r"'table': v0 = 2.0 m/s, but a Fixed holds this shaft; leave v0 out"):
        gb.build(held)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: gb.Mass(m=-1.0), "Mass 'x': m = -1.0 kg must be >= 0"),
        (lambda: gb.Mass(m=NAN), "m = nan kg must be a finite number"),
        (lambda: gb.Mass(m=1.0, v0=NAN), "v0 = nan m/s must be a finite number"),
        (lambda: gb.Mass(m=gb.Input("m")), "m is a parameter: it takes a number"),
        (lambda: gb.Rack(radius=0), "Rack 'x': radius = 0 m must not be 0"),
        (lambda: gb.Rack(radius=NAN), "radius = nan m must be a finite number"),
        (lambda: gb.Rack(radius=gb.Parameter("r", 1.0)), "enters a ratio: give a plain number"),
        (lambda: gb.Force(f=NAN), "f = nan N must be a finite number"),
        (lambda: gb.Force(), "Force needs f"),
        (lambda: gb.Force(3.0), "Force: 3.0 is given without a name"),
        (lambda: gb.Force(g=1.0), "Force has no field 'g'"),
    ],
)
@pytest.mark.few(3)
def test_bad_values_are_refused_in_words(make, words: str) -> None:
    with pytest.raises(gb.ModelError) as caught:
        gb.Drivetrain("rig").add("x", make())
    assert words in str(caught.value)


def test_a_slider_that_is_neither_is_refused() -> None:
    with pytest.raises(gb.ModelError, match="slider = 'yes' must be True, False or None"):
        gb.Flange("rope", slider="yes")  # type: ignore[arg-type]


@pytest.mark.long
def test_a_train_with_sliders_survives_its_file(tmp_path: Path) -> None:
    rig = _wheel()
    rig.connect(rig.add("push", gb.Force(f=gb.Input("f", unit="N"))).flange, FlangeHandle(rig, "mass", "a"))
    rig.to_json(tmp_path / "rig.json")
    again = gb.Drivetrain.from_json(tmp_path / "rig.json")
    assert gb.build(again).program.key == gb.build(rig).program.key

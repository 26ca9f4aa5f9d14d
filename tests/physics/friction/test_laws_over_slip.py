"""Laws of friction as expressions of the slip, tables that are extrapolated, and torques of speed that drive."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearblocks as gb

LONG = pytest.mark.long


def _coasting(part: gb.Block, w0: float = 20.0, J: float = 0.5) -> gb.Drivetrain:
    rig = gb.Drivetrain("coasting")
    rotor = rig.add("rotor", gb.Inertia(J=J, w0=w0))
    part = rig.add("part", part)
    rig.connect(rotor.b, part.a if "a" in type(part._part).flanges else part.flange)  # type: ignore[attr-defined]
    return rig


def _stops_at(law: Any, w0: float = 20.0, J: float = 0.5) -> tuple[float, float]:
    """When and after which angle a law stops the rotor, by the quadratures of J w' = -law(w)."""
    from scipy.integrate import quad

    t = quad(lambda w: J / law(w), 0, w0, epsabs=0, epsrel=1e-13)[0]
    return t, quad(lambda w: J * w / law(w), 0, w0, epsabs=0, epsrel=1e-13)[0]


LAWS = {
    "Modelica's exp(-f |w|)": (
        1.0 + 0.8 * gb.exp(-0.3 * gb.slip) + 0.02 * gb.slip, lambda w: 1.0 + 0.8 * np.exp(-0.3 * w) + 0.02 * w,
    ),
    "of Parameters, rational": (
        gb.Parameter("top", 2.0, "N m") / (1 + 0.1 * gb.slip) + 0.3, lambda w: 2.0 / (1 + 0.1 * w) + 0.3,
    ),
    "a power": (0.5 + 0.1 * gb.slip**1.5, lambda w: 0.5 + 0.1 * w**1.5),
}  # fmt: skip


@pytest.mark.parametrize("name", [next(iter(LAWS)), *(pytest.param(n, marks=LONG) for n in [*LAWS][1:])])
@pytest.mark.parametrize("method", ["dp8", pytest.param("rodas", marks=LONG), pytest.param("dp5", marks=LONG)])
def test_a_law_of_the_slip_stops_a_rotor_where_quadratures_say(name: str, method: str) -> None:
    law, value = LAWS[name]
    stop, turned = _stops_at(value)
    for part in (
        gb.BearingFriction(torque=law),
        gb.Brake(capacity=law),
        gb.Brake(mu=law, force_max=2.0, engagement=0.5),
    ):
        run = gb.simulate(_coasting(part), t=[0.0, 1.5 * stop], method=method, rtol=1e-11)
        stuck = next(e for e in run.events if e.component == "part" and e.after == 0)
        assert stuck.t == pytest.approx(stop, rel=1e-9)
        assert run["rotor.phi"][-1] == pytest.approx(turned, rel=1e-9) and run["rotor.w"][-1] == 0.0
        assert run.energy.residual < 1e-9


@pytest.mark.long
def test_the_peak_stands_above_the_law_at_rest() -> None:
    """Static peak and Stribeck in one: breaks away at peak times the law at slip 0, either way."""
    law = 1.0 + 0.8 * gb.exp(-0.3 * gb.slip)
    rig = _coasting(gb.BearingFriction(torque=law, peak=1.5), w0=0.0)
    rig.connect(rig["rotor"].a, rig.add("push", gb.Torque(tau=-1.0 * gb.time)).flange)
    run = gb.simulate(rig, t_end=3.0, rtol=1e-9)
    assert next(e.t for e in run.events if e.component == "part") == pytest.approx(1.5 * 1.8, abs=1e-9)
    both = gb.BearingFriction(coulomb=1.0, viscous=0.1, stribeck=gb.Stribeck(rise=0.8, speed=3.0), peak=1.5)
    same = gb.BearingFriction(torque=1.0 + 0.1 * gb.slip + 0.8 * gb.exp(-((gb.slip / 3.0) ** 2)), peak=1.5)
    runs = [gb.simulate(_coasting(part), t=np.linspace(0, 8, 9), rtol=1e-10) for part in (both, same)]
    assert runs[0]["rotor.w"] == pytest.approx(runs[1]["rotor.w"], abs=1e-8)


def test_an_expression_of_a_clutch_meets_hand_written_equations() -> None:
    """A clutch between two bodies whose capacity fades with the slip and rises with time."""
    rig = gb.Drivetrain("clutch")
    capacity = 8.0 * gb.time / (1 + gb.slip / 40.0)
    one, two = rig.add("one", gb.Inertia(J=0.2, w0=100.0)), rig.add("two", gb.Inertia(J=1.0))
    rig.chain(one, rig.add("clutch", gb.Clutch(capacity=capacity)), two)
    t = np.linspace(0, 1.5, 16)
    run = gb.simulate(rig, t=t, rtol=1e-11, method="dp8")

    def f(time: float, w: Any) -> list[float]:
        force = 8.0 * time / (1 + (w[0] - w[1]) / 40.0)
        return [-force / 0.2, force]

    wanted = solve_ivp(f, (0, 1.5), [100.0, 0.0], t_eval=t, rtol=1e-13, atol=1e-13, method="DOP853").y
    sliding = wanted[0] > wanted[1]
    assert sliding.sum() > 9
    assert np.abs(run["one.w"] - wanted[0])[sliding].max() < 1e-8


def test_laws_that_drive_or_have_no_value_are_named(tmp_path: Path) -> None:
    for law, words in (
        (
            1.0 - 0.1 * gb.slip,
            r"torque = '1.0 \+ -0.1\*slip' is -0\.\d+ at slip 1\d\.\d*, and must be >= 0|must be >= 0",
        ),
        (1.0 / gb.slip, "has no value at slip 0, where it sticks"),
        (3.0, "must be a gb.Table over abs.w. or an expression of gb.slip; a constant torque is coulomb"),
    ):
        with pytest.raises(gb.ModelError, match=words):
            _coasting(gb.BearingFriction(torque=law))
    with pytest.raises(gb.ModelError, match=r"contains gb\.slip, which only a law of friction knows"):
        gb.Drivetrain("wrong").add("drive", gb.Torque(tau=gb.slip))
    rig = _coasting(gb.BearingFriction(torque=LAWS["a power"][0]))
    rig.to_json(tmp_path / "rig.json")
    assert repr(gb.Drivetrain.from_json(tmp_path / "rig.json")["part"]) == repr(rig["part"])
    assert "^1.5" in str(rig.equations()) and set(rig.effects()) == {"part.friction"}


@pytest.mark.long
def test_a_table_goes_on_as_its_last_line_does() -> None:
    """Modelica's LastTwoPoints: [0, 0.5; 1, 1] at 10 rad/s is 5.5, not 1."""
    on, held = (gb.Table([0.0, 1.0], [0.5, 1.0], extrapolate=way) for way in ("linear", "hold"))
    steep = gb.Table([0.1, 1.0, 2.0], [0.3, 1.0, 4.0], extrapolate="linear")
    assert steep.values([0.0, -1.0]) == pytest.approx([0.3 - 0.07 / 0.9, 0.3 - 0.77 / 0.9], rel=1e-14)
    assert on.values([-2.0, 0.5, 10.0]) == pytest.approx([-0.5, 0.75, 5.5], rel=1e-13) and held.values(10.0) == 1.0
    stop, turned = _stops_at(lambda w: 0.5 + 0.5 * w)
    run = gb.simulate(_coasting(gb.BearingFriction(torque=on)), t=[0.0, 2 * stop], rtol=1e-11, method="dp8")
    assert run["rotor.phi"][-1] == pytest.approx(turned, rel=1e-9)
    straight = gb.BearingFriction(coulomb=0.5, viscous=0.5)
    assert gb.simulate(_coasting(straight), t=[0.0, 2 * stop])["rotor.phi"][-1] == pytest.approx(turned, rel=1e-5)
    rig = gb.Drivetrain("time")
    ramp = gb.Table([0.0, 0.1], [0.0, 1.0], extrapolate="linear")
    rig.chain(rig.add("drive", gb.Torque(tau=ramp)), rig.add("disc", gb.Inertia(J=1.0)))
    assert gb.simulate(rig, t=[0.0, 2.0], rtol=1e-10)["disc.w"][-1] == pytest.approx(20.0, rel=1e-9)
    driven = gb.Drivetrain("input")
    driven.chain(driven.add("drive", gb.Torque(tau=gb.Input("tau"))), driven.add("disc", gb.Inertia(J=1.0)))
    assert gb.simulate(driven, t=[0.0, 2.0], inputs={"tau": ramp}, rtol=1e-10)["disc.w"][-1] == pytest.approx(
        20.0, rel=1e-9
    )


def test_what_cannot_go_on_is_named(tmp_path: Path) -> None:
    for more, words in (
        ({"extrapolate": "on"}, "extrapolate = 'on' must be 'hold' or 'linear'"),
        ({"extrapolate": "linear", "kind": "cubic"}, "kind = 'cubic' has no lines to go on with"),
        ({"extrapolate": "linear", "periodic": True}, "a periodic table has no lines to go on with"),
    ):
        with pytest.raises(gb.ParameterError, match=words):
            gb.Table([0.0, 1.0, 2.0], [1.0, 2.0, 1.0], **more)  # type: ignore[arg-type]
    falling = gb.Table([0.0, 1.0], [1.0, 0.5], extrapolate="linear")
    with pytest.raises(gb.ModelError, match="falls at its end and would come below 0"):
        _coasting(gb.BearingFriction(torque=falling))
    rig = _coasting(gb.BearingFriction(torque=gb.Table([0.0, 1.0], [0.5, 1.0], extrapolate="linear")))
    rig.to_json(tmp_path / "rig.json")
    assert gb.Drivetrain.from_json(tmp_path / "rig.json")["part"] == rig["part"]
    assert "2 points from 0 to 1, linear, extrapolated" in " ".join(str(rig.equations()).split())


@pytest.mark.parametrize("direction", ["along", "forward", "backward"])
@pytest.mark.few(1)
def test_torques_of_speed_that_drive_or_keep_their_sign(direction: str) -> None:
    """Against hand-written equations, from either sense of rotation, and with the reaction on a turning housing."""

    def torque(w: float) -> float:
        size = 0.3 + 0.02 * abs(w) + 1e-3 * w**2
        return size * {"along": 1.0 if w >= 0 else -1.0, "forward": 1.0, "backward": -1.0}[direction]

    rig = gb.Drivetrain("fan")
    load = rig.add("load", gb.SpeedLoad(coeffs=(0.3, 0.02, 1e-3), direction=direction))
    rig.connect(rig.add("rotor", gb.Inertia(J=0.5, w0=-4.0)).a, load.flange)
    rig.connect(rig.add("frame", gb.Inertia(J=2.0, w0=1.0)).a, load.housing)
    t = np.linspace(0, 5, 11)
    run = gb.simulate(rig, t=t, rtol=1e-11, method="dp8")

    def f(_t: float, w: Any) -> list[float]:
        tau = torque(w[0] - w[1])
        return [tau / 0.5, -tau / 2.0]

    wanted = solve_ivp(f, (0, 5), [-4.0, 1.0], t_eval=t, rtol=1e-12, atol=1e-12, max_step=0.01, method="DOP853").y
    assert np.abs(run["rotor.w"] - wanted[0]).max() < 1e-7 and np.abs(run["frame.w"] - wanted[1]).max() < 1e-7
    assert run.energy.residual < 1e-9
    with pytest.raises(gb.ModelError, match="direction = 'up' must be"):
        gb.Drivetrain("wrong").add("load", gb.SpeedLoad(coeffs=(0, 0, 0), direction="up"))


@pytest.mark.long
def test_a_load_against_a_turning_housing_opposes_the_difference() -> None:
    rig = gb.Drivetrain("wind")
    load = rig.add("load", gb.SpeedLoad(coeffs=(0.0, 0.5, 0.0)))
    rig.connect(rig.add("rotor", gb.Inertia(J=0.5, w0=10.0)).a, load.flange)
    rig.connect(rig.add("wind", gb.Speed(w=4.0)).flange, load.housing)
    t = np.linspace(0, 3, 7)
    assert gb.simulate(rig, t=t, rtol=1e-11)["rotor.w"] == pytest.approx(4 + 6 * np.exp(-t), rel=1e-9)
    stuck = gb.SpeedLoad(coeffs=(1.0, 0.0, 0.0))
    held = rig.set({"load": stuck, "rotor.w0": 4.0})
    assert (gb.simulate(held, t=t)["rotor.w"] == 4.0).all()


@pytest.mark.long
def test_an_eddy_current_brake_slows_a_sledge() -> None:
    """m v' = -2 F v v_n/(v^2 + v_n^2): v^2/2 + v_n^2 ln v falls at the rate 2 F v_n/m."""
    rig = gb.Drivetrain("sledge")
    brake = gb.EddyCurrentBrake(tau_nominal=30.0, w_nominal=2.0)
    rig.chain(rig.add("sledge", gb.Mass(m=5.0, v0=6.0)), rig.add("brake", brake))
    t = np.linspace(0, 1.5, 7)
    v = gb.simulate(rig, t=t, rtol=1e-11)["sledge.v"]
    assert v**2 / 2 + 4 * np.log(v) == pytest.approx(18 + 4 * np.log(6.0) - 2 * 30 * 2 / 5 * t, rel=1e-9)
    assert "w_nominal = 2 m/s" in rig.describe() and "tau_nominal = 30 N" in rig.describe()


def test_a_rack_rolls_against_a_housing_and_a_frame_that_move() -> None:
    """s - s_frame = r (phi - phi_housing); momentum of what carries both is kept, by the reactions on them."""
    rig = gb.Drivetrain("steering")
    rack = rig.add("rack", gb.Rack(radius=0.1))
    bodies = {"pinion": gb.Inertia(J=0.02, w0=30.0), "housing": gb.Inertia(J=0.3, w0=2.0)}
    sliders = {"rod": gb.Mass(m=4.0), "frame": gb.Mass(m=9.0, v0=0.5)}
    for name, flange in (("pinion", rack.flange), ("housing", rack.housing)):
        rig.connect(rig.add(name, bodies[name]).a, flange)
    for name, flange in (("rod", rack.slider), ("frame", rack.frame)):
        rig.connect(rig.add(name, sliders[name]).a, flange)
    rig.connect(rig["pinion"].b, rig.add("hand", gb.Torque(tau=1.5)).flange)
    run = gb.simulate(rig, t=[0.0, 2.0], rtol=1e-10)
    speeds = {name: run[f"{name}.{'v' if name in sliders else 'w'}"] for name in (*bodies, *sliders)}
    assert speeds["rod"] - speeds["frame"] == pytest.approx(0.1 * (speeds["pinion"] - speeds["housing"]), rel=1e-12)
    assert speeds["rod"][0] == pytest.approx(0.5 + 0.1 * 28.0, rel=1e-12)
    moved = {name: v[1] - v[0] for name, v in speeds.items()}
    assert 4 * moved["rod"] + 9 * moved["frame"] == pytest.approx(0.0, abs=1e-11)  # action and reaction of the tie
    assert 0.02 * moved["pinion"] + 0.3 * moved["housing"] == pytest.approx(3.0, rel=1e-11)
    assert 0.02 * moved["pinion"] - 3.0 == pytest.approx(-0.1 * 4 * moved["rod"], rel=1e-9)

"""Rolling starts: the train turns as one piece, so that nothing is twisted, nor at a rate."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fmu_export
import gearblocks as gb
from gearblocks.analysis.scenes.bench import Effort, bench_of

SPEED = gb.rpm(3000)
BODIES = ("motor", "pinion", "wheel", "hub", "input", "output", "sun", "carrier")


def _eight(**motor: Any) -> gb.Drivetrain:
    """Shafts, a mesh with a gap, a clutch that locks, a lossy gear, a lash and a planetary set whose ring is braked."""
    rig = gb.Drivetrain("eight bodies")
    body = {
        name: rig.add(name, gb.Inertia(J=J))
        for name, J in zip(BODIES[1:], (2e-4, 0.05, 0.01, 3e-3, 0.02, 1e-3, 0.2), strict=True)
    }
    mesh = gb.GearMesh(
        teeth=(23, 41), module=3e-3, pressure_angle=0.35, external=True, k=2e8, damping_ratio=0.05,
        backlash=gb.Backlash(half_gap=3e-5),
    )  # fmt: skip
    planet, brake = rig.add("planet", gb.IdealPlanetary(ratio=3.0)), rig.add("brake", gb.Brake(capacity=500.0))
    rig.chain(
        rig.add("motor", gb.Inertia(J=0.02, **motor)), rig.add("front", gb.Shaft(k=2e4, c=1.0)), body["pinion"],
        rig.add("mesh", mesh), body["wheel"], rig.add("clutch", gb.Clutch(capacity=100.0)), body["hub"],
        rig.add("middle", gb.Shaft(k=1e4)), body["input"], rig.add("lossy", gb.LossyGear(ratio=-2.5, efficiency=(0.97, 0.96))),
        body["output"], rig.add("lash", gb.Lash(k=3e4, half_gap=1e-3, c=1.0)), body["sun"],
    )  # fmt: skip
    rig.connect(body["sun"].b, planet.sun)
    rig.connect(planet.ring, rig.add("ring", gb.Inertia(J=0.01)).a, brake.a)
    rig.connect(planet.carrier, body["carrier"].a)
    return rig


RATIOS = np.array([1.0, 1.0, *[-23 / 41] * 3, *[23 / 41 / 2.5] * 2, 23 / 41 / 2.5 / 4])


@pytest.mark.parametrize("method", ["auto", "dp5", "dp8", "rodas", pytest.param("rk4", marks=pytest.mark.long)])
def test_a_compliant_train_that_starts_rolling_has_no_transient(method: str) -> None:
    """Unloaded, it turns on as it is; speeds follow from the tooth counts and ratios."""
    how: dict[str, Any] = {"method": method, "step": 2e-6} if method == "rk4" else {"method": method}
    run = gb.simulate(_eight(), t_end=0.02, initial=gb.rolling({"motor.w": "3000 rpm"}), **how)
    for name, ratio in zip(BODIES, RATIOS, strict=True):
        w = run[f"{name}.w"]
        assert w[0] == pytest.approx(SPEED * ratio, rel=1e-14), name
        assert np.abs(w - w[0]).max() <= 1e-12 * abs(w[0]), name  # the task asks for 1e-9
    assert not len(run.events) and (run["clutch.mode"] == 0).all() and (run["brake.mode"] == 0).all()


@pytest.mark.long
def test_speeds_that_bodies_give_let_the_others_turn_along() -> None:
    run = gb.simulate(_eight(w0=SPEED), t_end=1e-3, initial="rolling")
    assert [run[f"{name}.w"][0] for name in BODIES] == pytest.approx(SPEED * RATIOS, rel=1e-14)
    other = gb.simulate(_eight(w0=1.0), t_end=1e-3, initial=gb.rolling({"carrier.w": SPEED * RATIOS[-1]}))
    assert other["motor.w"][0] == pytest.approx(
        SPEED, rel=1e-14
    )  # what is named takes the place of what the body gives


def test_a_plain_dict_keeps_its_meaning() -> None:
    run = gb.simulate(_eight(), t_end=1e-6, initial={"motor.w": SPEED})
    assert (run["pinion.w"][0], run["wheel.w"][0]) == (0.0, 0.0)


@pytest.mark.long
def test_angles_turn_along_too() -> None:
    run = gb.simulate(_eight(), t_end=1e-4, initial=gb.rolling({"wheel.phi": 0.3}))
    assert run["pinion.phi"][0] == run["motor.phi"][0] == pytest.approx(-0.3 * 41 / 23, rel=1e-14)
    assert run["front.twist"][0] == 0.0 and abs(run["mesh.deflection"][0]) < 1e-17
    own = gb.simulate(_eight(phi0=0.5), t_end=1e-4, initial="rolling")
    assert own["wheel.phi"][0] == pytest.approx(-0.5 * 23 / 41, rel=1e-14)


@pytest.mark.long
def test_contradictions_are_refused_by_name() -> None:
    rig = gb.build(_eight())
    with pytest.raises(
        gb.ParameterError, match=r"'wheel.w' = -100 contradicts the -168.29\d* that follows from 'motor.w'"
    ):
        gb.simulate(rig, t_end=1.0, initial=gb.rolling({"motor.w": 300, "wheel.w": -100}))
    with pytest.raises(gb.ParameterError, match=r"'sun.phi' = 1 contradicts the 0.4 that follows from 'output.phi'"):
        gb.simulate(rig, t_end=1.0, initial=gb.rolling({"output.phi": 0.4, "sun.phi": 1.0}))
    with pytest.raises(gb.UnknownNameError, match=r"no initial value 'wheel.speed'"):
        gb.simulate(rig, t_end=1.0, initial=gb.rolling({"wheel.speed": 1}))
    both = _eight(w0=300.0).set({"wheel.w0": -100.0})
    with pytest.raises(
        gb.ParameterError, match=r"'motor.w' = 300 contradicts the 178.26087 that follows from 'wheel.w'"
    ):
        gb.simulate(both, t_end=1.0, initial="rolling")
    with pytest.raises(gb.ParameterError, match="give start values by name"):
        gb.rolling(300)  # type: ignore[arg-type]
    with pytest.raises(gb.ParameterError, match=r"'rolling' or gb.rolling\(...\) - did you mean 'rolling'"):
        gb.simulate(rig, t_end=1.0, initial="roling")


def test_friction_holds_where_the_given_speeds_let_it_the_strongest_first() -> None:
    rig = gb.build(_eight())
    slipping = gb.simulate(rig, t_end=1e-5, initial=gb.rolling({"motor.w": 300.0, "hub.w": 0.0}))
    assert (
        slipping["hub.w"][0] == 0.0 and slipping["clutch.mode"][0] == 1
    )  # the hub runs ahead of a wheel that turns backwards
    turning = gb.simulate(rig, t_end=1e-5, initial=gb.rolling({"sun.w": 40.0, "carrier.w": 16.0}))
    assert turning["ring.w"][0] == pytest.approx(8.0, rel=1e-14) and turning["brake.mode"][0] == 1
    still = _eight().set({"clutch.capacity": 600.0, "brake.capacity": 500.0})
    held = gb.simulate(still.set({"brake": gb.Brake(capacity=0.0)}), t_end=1e-5, initial=gb.rolling({"motor.w": 300.0}))
    sun = 300.0 * RATIOS[6]  # by impacts on the sun alone: ring and carrier share by their inertias
    J_r, J_c, i = 0.01, 0.2, 3.0
    ring = (
        -sun * J_c * i / (J_r * (1 + i) ** 2 + J_c * i**2)
    )  # carrier (sun + i ring)/(1 + i), impulses in the ratio i : 1 + i
    assert held["ring.w"][0] == pytest.approx(ring, rel=1e-9)
    assert held["carrier.w"][0] == pytest.approx((sun + i * ring) / (1 + i), rel=1e-9)


@pytest.mark.long
def test_of_two_that_cannot_both_hold_the_stronger_one_holds() -> None:
    """A clutch to a turning motor against a brake to the ground: what a run would find, too."""
    for clutch, brake, hub in ((80.0, 500.0, 0.0), (500.0, 80.0, 300.0)):
        rig = gb.Drivetrain("between")
        part = rig.add("hub", gb.Inertia(J=1.0, w0=7.0))  # which yields
        rig.chain(rig.add("motor", gb.Inertia(J=1.0)), rig.add("clutch", gb.Clutch(capacity=clutch)), part)
        rig.connect(part.b, rig.add("brake", gb.Brake(capacity=brake)).a)
        assert gb.simulate(rig, t_end=1e-5, initial=gb.rolling({"motor.w": 300.0}))["hub.w"][0] == hub


def test_a_lock_that_would_have_to_close_by_an_impact_is_refused() -> None:
    rig = gb.Drivetrain("freewheel")
    rig.chain(rig.add("one", gb.Inertia(J=1.0)), rig.add("free", gb.Freewheel()), rig.add("two", gb.Inertia(J=1.0)))
    model = gb.build(rig)
    assert gb.simulate(model, t_end=0.1, initial=gb.rolling({"one.w": 3.0}))["two.w"][0] == 3.0
    assert gb.simulate(model, t_end=0.1, initial=gb.rolling({"one.w": 3.0, "two.w": 4.0}))["two.w"][0] == 4.0
    with pytest.raises(gb.ParameterError, match=r"'free' is locked, but .* 'one.w', 'two.w' would make it slip at -2"):
        gb.simulate(model, t_end=0.1, initial=gb.rolling({"one.w": 3.0, "two.w": 1.0}))


@pytest.mark.long
def test_a_prescribed_speed_takes_the_train_along() -> None:
    rig = gb.Drivetrain("driven")
    rig.chain(
        rig.add("drive", gb.Speed(w=40.0 + 5.0 * gb.time)), rig.add("shaft", gb.Shaft(k=1e4)),
        rig.add("gear", gb.IdealGear(ratio=-4)), rig.add("hub", gb.Inertia(J=0.1)),
        rig.add("lossy", gb.LossyGear(ratio=2, efficiency=(0.9, 0.9))), rig.add("load", gb.Inertia(J=0.1)),
    )  # fmt: skip
    run = gb.simulate(rig, t_end=1.0, t_start=0.4, initial="rolling")
    assert (run["hub.w"][0], run["load.w"][0]) == pytest.approx((-42.0 / 4, -42.0 / 8), rel=1e-14)
    with pytest.raises(
        gb.ParameterError, match=r"'hub.w' = 1 contradicts the -10 that follows from what moves or holds it"
    ):
        gb.simulate(rig, t_end=1.0, initial=gb.rolling({"hub.w": 1.0}))


def test_what_the_ground_holds_by_a_spring_cannot_roll() -> None:
    rig = gb.Drivetrain("pendulum")
    rig.chain(
        rig.add("ground", gb.Fixed(phi0=0.2)), rig.add("wire", gb.Shaft(k=1.0)), rig.add("disc", gb.Inertia(J=1.0))
    )
    run = gb.simulate(rig, t_end=1.0, initial="rolling")
    assert (run["disc.phi"] == 0.2).all()
    with pytest.raises(
        gb.ParameterError, match=r"'disc.w' = 5 contradicts the 0 that follows from what moves or holds it"
    ):
        gb.simulate(rig, t_end=1.0, initial=gb.rolling({"disc.w": 5.0}))


@pytest.mark.long
def test_parameters_sweeps_and_scenes_start_rolling() -> None:
    rig = _eight(w0=gb.Parameter("speed", SPEED, "rad/s"))
    run = gb.simulate(rig, t_end=1e-4, initial="rolling", parameters={"speed": 100.0})
    assert run["carrier.w"][0] == pytest.approx(100.0 * RATIOS[-1], rel=1e-14)
    last = gb.last("carrier.w")
    found = gb.sweep(rig, {"speed": [100.0, 200.0]}, quantity=last, t_end=1e-4, initial="rolling")
    assert found.values.ravel() == pytest.approx([100.0 * RATIOS[-1], 200.0 * RATIOS[-1]], rel=1e-12)
    by_name = gb.sweep(_eight(), {"motor.w": [100.0, 200.0]}, quantity=last, t_end=1e-4, initial="rolling")
    assert by_name.values.ravel() == pytest.approx(found.values.ravel(), rel=1e-12)
    plain = gb.sweep(
        _eight(), {"clutch.capacity": [50.0, 60.0]}, quantity=last, t_end=1e-4, initial=gb.rolling({"motor.w": 100.0})
    )
    assert plain.values.ravel() == pytest.approx([100.0 * RATIOS[-1]] * 2, rel=1e-12)


@pytest.mark.long
def test_a_scene_and_its_fmu_start_rolling(tmp_path: Path) -> None:
    start = gb.rolling({"motor.w": "3000 rpm"})
    assert pickle.loads(pickle.dumps(start)) == start and repr(start) == "rolling({'motor.w': '3000 rpm'})"
    scene = gb.Scene(_eight(), t_end=2e-3, quantity=gb.last("carrier.w"), initial=start)
    bench = bench_of(scene)
    assert bench.outcome(Effort()).values == pytest.approx([SPEED * RATIOS[-1]], rel=1e-9)
    lean = _eight().without("front.*")
    carried = gb.simulate(lean, t_end=1e-4, initial=gb.carried_start(_eight(), lean, initial=start))
    assert carried["carrier.w"][0] == pytest.approx(SPEED * RATIOS[-1], rel=1e-12)
    fmu_export.export(_eight(), tmp_path / "rig.fmu", initial=start, t_end=1e-3)
    assert fmu_export.check(tmp_path / "rig.fmu").ok
    fmu_export.export(scene, tmp_path / "scene.fmu", t_end=1e-3)
    report = fmu_export.check(tmp_path / "scene.fmu")
    assert report.ok


def test_linear_tools_take_a_rolling_point() -> None:
    point = gb.linearize(_eight(), at=gb.rolling({"motor.w": 100.0})).point
    assert point["carrier.w"] == pytest.approx(100.0 * RATIOS[-1], rel=1e-12)


def test_starts_that_nothing_gives_are_listed() -> None:
    assert "start" not in _eight().describe()
    told = _eight(w0=SPEED).describe().splitlines()[-2:]
    assert told[0] == (
        "start speeds that nothing gives, 0 unless ties say otherwise: pinion, wheel, hub, input, output, carrier, ring"
    )
    # both discs by themselves: torque v sqrt(k J1 J2/(J1 + J2))
    blow = SPEED * np.sqrt(2e4 * 0.02 * 2e-4 / 0.0202)
    assert told[1].startswith(f"a blow of {blow:.3g} N m on 'front' at the start")


@pytest.mark.long
def test_the_first_body_of_a_free_train_begins_at_the_angle_zero() -> None:
    """Where no angle is given: the others are turned by the rests of the shafts between."""
    rig = gb.Drivetrain("free")
    one, two, three = (rig.add(name, gb.Inertia(J=J)) for name, J in (("one", 0.2), ("two", 0.9), ("three", 2.7)))
    rig.chain(two, rig.add("right", gb.Shaft(k=30.0, rest=0.2)), three)
    rig.chain(one, rig.add("left", gb.Shaft(k=60.0, rest=0.05)), two)
    run = gb.simulate(rig, t_end=1e-6, initial=gb.rolling({"two.w": 3.0}))
    assert [run[f"{n}.phi"][0] for n in ("one", "two", "three")] == pytest.approx([0.0, 0.05, 0.25], abs=1e-15)


def _behind_a_lossy_gear(**angles: float) -> gb.Drivetrain:
    rig = gb.Drivetrain("behind")
    ends = [rig.add(n, gb.Inertia(J=0.1, phi0=angles.get(n))) for n in ("one", "two", "left", "right")]
    one, two, left, right = ends
    rig.chain(one, rig.add("gear", gb.LossyGear(ratio=1.5, efficiency=(0.9, 0.7))), two)
    rig.chain(left, rig.add("first", gb.Shaft(k=50.0, rest=-0.06)), one)
    rig.chain(two, rig.add("second", gb.Shaft(k=2.0, rest=0.03)), right)
    return rig


@pytest.mark.long
@pytest.mark.parametrize("named", ["left", "one", "two", "right"])
@pytest.mark.parametrize("own", ["one", "two"])
def test_angles_beside_a_lossy_gear_yield_to_one_that_is_named_beyond_it(own: str, named: str) -> None:
    """One side of the gear gives its angle, the other one follows it: both follow what is named, and no shaft is twisted."""
    run = gb.simulate(_behind_a_lossy_gear(**{own: 0.2}), t_end=1e-6, initial=gb.rolling({f"{named}.phi": 0.5}))
    assert run[f"{named}.phi"][0] == pytest.approx(0.5, abs=1e-15)
    assert run["one.phi"][0] == pytest.approx(1.5 * run["two.phi"][0], rel=1e-14)
    assert [run["first.twist"][0], run["second.twist"][0]] == pytest.approx([-0.06, 0.03], abs=1e-15)


def test_two_named_angles_of_sides_that_follow_each_other_contradict() -> None:
    with pytest.raises(
        gb.GearblocksError, match=r"'two.phi' = 0.5 contradicts the 0.133333333 that follows from 'one.phi'"
    ):
        gb.simulate(_behind_a_lossy_gear(one=0.3), t_end=1e-6, initial=gb.rolling({"one.phi": 0.2, "two.phi": 0.5}))

"""Angles that laws read: whole turns are counted apart, so that a mesh phase keeps its digits for ever."""

from typing import Any

import numpy as np
import pytest
import sympy as sp
from mpmath import mp, mpf
from numpy.typing import NDArray

import gearblocks as gb

mp.dps = 40
TURN = 2 * mp.pi
RPM_1E6 = 1e6 * np.pi / 30
CUBIC = gb.Table(np.linspace(0, 1, 7), (0.0, 0.2, 0.1, -0.1, -0.2, 0.05, 0.0), kind="cubic", periodic=True)
Array = NDArray[np.float64]


def _pair(
    teeth: tuple[int, int] = (23, 41), k: float = 1e6, carrier: bool = False, spring: Any = None, **fields: Any
) -> gb.Drivetrain:
    """A pair whose mesh is stiffer and softer with the angle of its teeth."""
    rig = gb.Drivetrain("pair")
    fields = {"stiffness_variation": gb.Fourier(cos=(0.2,), sin=(0.0, 0.1)), **fields}
    radii = (1e-3 * teeth[0], 1e-3 * teeth[1])
    mesh = rig.add("mesh", gb.GearMesh(teeth=teeth, r_base=radii, external=True, k=k, **fields))
    pinion = rig.add("pinion", gb.Inertia(J=1e-3))
    rig.chain(pinion, mesh, rig.add("wheel", gb.Inertia(J=4e-3)))
    if carrier:
        rig.connect(rig.add("carrier", gb.Inertia(J=0.01)).a, mesh.carrier)
    if spring is not None:
        rig.connect(rig.add("spring", gb.Torque(tau=spring)).flange, pinion.a)
    return rig


def _off(phase: Array, cycles: list[Any]) -> float:
    """Largest distance of phases from exact cycles, around the circle."""
    half = mpf(1) / 2
    return max(float(abs((mpf(float(p)) - c + half) % 1 - half)) for p, c in zip(phase, cycles, strict=True))


@pytest.mark.parametrize("teeth", [(23, 41), (100, 150), (17, 17)])
@pytest.mark.parametrize("turns", [10**7, -(10**7), 10**9])
@pytest.mark.few(1)
def test_a_mesh_phase_is_right_at_a_start_angle_of_many_turns(teeth: tuple[int, int], turns: int) -> None:
    phi = 2 * np.pi * turns + 0.1
    run = gb.simulate(_pair(teeth), t=[0.0], initial={"pinion.phi": phi, "wheel.phi": -phi * teeth[0] / teeth[1]})
    assert _off(run["mesh.mesh_phase"], [teeth[0] * mpf(phi) / TURN]) < 1e-13  # z cycles of a turn, a few roundings
    assert run["pinion.phi"][0] == pytest.approx(phi, rel=3e-16)


@pytest.mark.long
def test_a_mesh_phase_is_right_after_ten_million_turns_of_a_run() -> None:
    w = 52359.8
    t = np.linspace(0.0, 2 * np.pi * 1e7 / w, 101)
    rig = _pair(k=10.0, damping_ratio=0.05)
    run = gb.simulate(rig, t=t, initial={"pinion.w": w, "wheel.w": -w * 23 / 41})
    assert run["pinion.w"][-1] == pytest.approx(w, rel=1e-15)
    assert run["pinion.phi"][-1] > 6.2e7
    assert _off(run["mesh.mesh_phase"], [23 * mpf(w) * mpf(float(x)) / TURN for x in t]) < 1e-9


@pytest.mark.long
def test_a_hundred_teeth_keep_their_phase_for_ten_thousand_seconds_at_a_million_rpm() -> None:
    t = np.linspace(0.0, 1e4, 1001)
    rig = _pair((100, 150), k=10.0, damping_ratio=0.05)
    run = gb.simulate(rig, t=t, initial={"pinion.w": RPM_1E6, "wheel.w": -RPM_1E6 * 2 / 3})
    exact = [100 * mpf(RPM_1E6) * mpf(float(x)) / TURN for x in t]
    assert _off(run["mesh.mesh_phase"], exact) < 1e-9  # asked for: 1e-3 rad = 1.6e-4


def _starts(phi: float, teeth: tuple[int, int], turns: int, w: float) -> tuple[dict[str, float], dict[str, float]]:
    """Start values many turns away, and the same ones with these turns taken off in 40 digits."""
    ratio = mpf(teeth[0]) / teeth[1]
    far = {"pinion.phi": float(phi + TURN * turns), "wheel.phi": float(-(phi + TURN * turns) * ratio + mpf("0.002"))}
    near = {
        "pinion.phi": float(mpf(far["pinion.phi"]) - TURN * turns),
        "wheel.phi": float(mpf(far["wheel.phi"]) + TURN * turns * ratio),
    }
    speeds = {"pinion.w": w, "wheel.w": -w * teeth[0] / teeth[1]}
    return far | speeds, near | speeds


PAIRS = [
    {},
    {"transmission_error": gb.Harmonic(cos=(1e-5,))},
    {"stiffness_variation": gb.Profile(table=CUBIC), "backlash": gb.Backlash(half_gap=2e-5), "damping_ratio": 0.02},
]


@pytest.mark.long
@pytest.mark.parametrize("fields", PAIRS)
@pytest.mark.parametrize("turns", [10**7, -(10**7)])
def test_the_motion_after_ten_million_turns_is_that_at_the_first(fields: dict[str, Any], turns: int) -> None:
    far, near = _starts(0.3, (23, 41), turns, 70.0)
    model, t = gb.build(_pair(**fields)), np.linspace(0, 0.3, 301)
    runs = [gb.simulate(model, t=t, initial=start, rtol=1e-10) for start in (far, near)]
    for name in ("mesh.force", "mesh.stiffness", "pinion.w"):
        scale = np.abs(runs[1][name]).max()
        assert np.abs(runs[0][name] - runs[1][name]).max() < 1e-8 * scale  # rtol over 0.3 s; without the count 1e-7
    assert len(runs[0].events) == len(runs[1].events)
    assert _off(runs[0]["mesh.mesh_phase"], [mpf(float(p)) for p in runs[1]["mesh.mesh_phase"]]) < 1e-9


@pytest.mark.long
def test_a_table_over_the_angle_meets_each_joint_once_while_turns_are_taken_off() -> None:
    rig = _pair(stiffness_variation=gb.Profile(table=CUBIC), damping_ratio=0.05)
    w, end = 400.0, 0.5  # 32 turns
    run = gb.simulate(rig, t_end=end, initial={"pinion.w": w, "wheel.w": -w * 23 / 41}, rtol=1e-9)
    joints = [e for e in run.events if e.component.startswith("mesh")]
    assert len(joints) in (int(6 * 23 * w * end / (2 * np.pi)) + d for d in (0, 1))
    assert {abs(e.after - e.before) for e in joints} == {1.0}
    assert run.energy.residual < 1e-10


@pytest.mark.long
def test_angles_run_on_and_samples_lie_between_steps_where_turns_are_taken_off() -> None:
    w = 90.0
    model = gb.build(_pair(k=1e4, damping_ratio=0.05))
    start = {"pinion.w": w, "wheel.w": -w * 23 / 41}
    steps = gb.simulate(model, t_end=2.0, initial=start)
    t = np.linspace(0, 2.0, 40001)  # many samples in each step, those that end with a wrap too
    run = gb.simulate(model, t=t, initial=start)
    for found in (steps, run):
        assert np.abs(found["pinion.phi"] - w * found.t).max() < 1e-13 * w * 2
        assert np.abs(found["wheel.phi"] + w * 23 / 41 * found.t).max() < 1e-13 * w * 2
        assert _off(found["mesh.mesh_phase"], [23 * mpf(w) * mpf(float(x)) / TURN for x in found.t]) < 1e-12
    y = run.final_state
    assert y is not None
    assert max(abs(y.y[: model.program.n])) < 100  # speeds; the angle itself stays below
    assert w * 2.0 > 100


@pytest.mark.long
def test_turning_axes_are_counted_with_what_they_carry() -> None:
    model, t, turns = gb.build(_pair(carrier=True)), np.linspace(0, 0.2, 101), 64 * 10**5
    far, near = _starts(0.3, (23, 41), turns, 70.0)
    far["carrier.phi"] = near["carrier.phi"] = 0.0
    runs = [gb.simulate(model, t=t, initial=start | {"carrier.w": 11.0}, rtol=1e-10) for start in (far, near)]
    scale = np.abs(runs[1]["mesh.force"]).max()
    assert np.abs(runs[0]["mesh.force"] - runs[1]["mesh.force"]).max() < 1e-8 * scale
    assert _off(runs[0]["mesh.mesh_phase"], [mpf(float(p)) for p in runs[1]["mesh.mesh_phase"]]) < 1e-9
    for run in runs:
        phase = 23 * (run["pinion.phi"] - run["carrier.phi"]) / (2 * np.pi)
        assert np.abs((run["mesh.mesh_phase"] - phase + 0.5) % 1 - 0.5).max() < 3e-7  # 3e7 rad in a double


class Detent(gb.Block):
    """A torque over the angle of a shaft, by a factor and a power."""

    a = gb.Flange("shaft")
    factor: float = gb.exact("waves per turn")
    power: int = gb.option("power of the angle", default=1)

    def physics(self, s: Any) -> Any:
        """-sin(factor phi^power)."""
        yield gb.Acts(s.a, -sp.sin(s.factor * s.a.phi**self.power))
        yield gb.Shows("mixed", s.a.phi + sp.sin(s.factor * s.a.phi), "rad")


def _detent(**fields: Any) -> gb.Drivetrain:
    rig = gb.Drivetrain("detent")
    rig.chain(rig.add("body", gb.Inertia(J=1.0)), rig.add("detent", Detent(**fields)))
    return rig


@pytest.mark.long
@pytest.mark.parametrize(("fields", "counted"), [
    ({"factor": 3}, 1), ({"factor": 0.25}, 1), ({"factor": 0.1}, 0), ({"factor": 3, "power": 2}, 0),
])  # fmt: skip
def test_only_what_no_law_can_tell_is_taken_off(fields: dict[str, Any], counted: int, reference: Any) -> None:
    model = gb.build(_detent(**fields))
    assert (".n_wrapped = 1" in model.program.source) == bool(counted)
    t = np.linspace(0, 5, 201)
    run = gb.simulate(model, t=t, initial={"body.w": 9.0}, rtol=1e-11)
    factor, power = fields["factor"], fields.get("power", 1)
    true = reference(lambda _t, y, _m: (y[1], -np.sin(factor * y[0] ** power)), (0.0, 9.0), t)
    assert np.abs(run["body.phi"] - true[:, 0]).max() < 1e-7  # power 2: waves of 90 rad/s^2 per s
    assert np.abs(run["detent.mixed"] - (true[:, 0] + np.sin(factor * true[:, 0]))).max() < 1e-6


class Wobble(gb.Block):
    """b follows a at a ratio, a little ahead and behind in each turn of a."""

    a, b = gb.Flange("driving side"), gb.Flange("driven side")
    ratio: float = gb.exact("phi_b/phi_a")

    def physics(self, s: Any) -> Any:
        """The tie."""
        yield gb.Tie(s.b.phi - s.ratio * s.a.phi - 0.1 * sp.sin(s.a.phi))


@pytest.mark.long
def test_turns_go_through_a_pair_that_is_not_round(reference: Any) -> None:
    rig = gb.Drivetrain("non-circular pair")
    wobble = rig.add("wobble", Wobble(ratio=0.75))
    rig.chain(rig.add("body", gb.Inertia(J=1.0)), wobble, rig.add("detent", Detent(factor=2)))
    source = gb.build(rig).program.source
    assert ".n_wrapped = 1" in source
    assert ".turns = 2.0" in source  # 2 times 3/4 of a turn
    t = np.linspace(0, 5, 201)
    run = gb.simulate(rig, t=t, initial={"body.w": 9.0}, rtol=1e-11)

    def rates(_t: float, y: Array, _m: Array) -> tuple[float, float]:
        slope = 0.75 + 0.1 * np.cos(y[0])
        return y[1], -slope * np.sin(2 * (0.75 * y[0] + 0.1 * np.sin(y[0])))

    true = reference(rates, (0.0, 9.0), t)[:, 0]
    assert np.abs(run["body.phi"] - true).max() < 1e-8
    follows = 0.75 * true + 0.1 * np.sin(true)
    assert np.abs(run["detent.a.phi"] - follows).max() < 1e-8


@pytest.mark.long
def test_a_sensed_angle_is_left_to_grow_where_a_signal_reads_it_straight() -> None:
    rig = _pair(spring=-1e-3 * gb.sense("pinion.phi"))
    assert ".n_wrapped" not in gb.build(rig).program.source
    rig = _pair(spring=-1e-3 * gb.sense("mesh.mesh_phase"))
    assert ".n_wrapped = 1" in gb.build(rig).program.source


@pytest.mark.long
def test_a_run_goes_on_from_another_with_its_turns() -> None:
    model, w = gb.build(_pair(k=1e4, damping_ratio=0.05)), 90.0
    first = gb.simulate(model, t_end=1.0, initial={"pinion.w": w, "wheel.w": -w * 23 / 41})
    run = gb.simulate(model, t_end=2.0, initial=first)
    assert run["pinion.phi"][0] == pytest.approx(w * 1.0, rel=1e-15)
    assert _off(run["mesh.mesh_phase"], [23 * mpf(w) * mpf(float(x)) / TURN for x in run.t]) < 1e-12


def test_an_implicit_method_counts_turns_as_an_explicit_one_does() -> None:
    rig = _pair()
    ends = {}
    for method in ("dp8", "rodas", "auto"):
        spin = {"pinion.w": 5000.0, "wheel.w": -5000.0 * 23 / 41, "pinion.phi": 1e-3}
        run = gb.simulate(rig, t_end=0.02, rtol=1e-11, method=method, initial=spin)
        assert run["pinion.phi"][-1] > 90.0
        ends[method] = run["pinion.phi"][-1], run["mesh.mesh_phase"][-1], run["mesh.force"][-1]
        assert run.energy.residual < 1e-9
    for method in ("rodas", "auto"):
        assert ends[method] == pytest.approx(ends["dp8"], rel=1e-8), method  # the swing of the mesh is undamped

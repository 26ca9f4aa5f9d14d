"""Dynamic factor, spectrum line and period: one number each, of a run and in sweeps."""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.analysis.quantities import parsed
from gearblocks.cli import scripts

TORQUE, RADIUS, TURN = 2600.0, 0.025, 0.2
SETTLED = 400 * TURN  # 0.925^400 of the start is left, nothing
ALL = (
    gb.dynamic_factor("spline", after=SETTLED), gb.dynamic_factor("spline", "print", after=SETTLED, before=SETTLED + TURN),
    gb.dynamic_factor("spline", "print", "mean", samples=64, after=SETTLED),
    gb.line("spline.force", 5.0, after=SETTLED - 5 * TURN), gb.period("speed", after=SETTLED - 60 * TURN),
    gb.period(gb.stroboscopic("speed"), of=["spline.deflection", "x?"], longest=8, after=SETTLED - 60 * TURN),
    gb.std("spline.force", after=SETTLED),
)  # fmt: skip


@pytest.fixture(scope="module")
def model() -> gb.Model:
    return gb.build(scripts.make("spline_coupling"))


@pytest.fixture(scope="module")
def run(model: gb.Model) -> gb.Trajectory:
    return gb.simulate(model, t_end=SETTLED + 2 * TURN, rtol=1e-10, outputs=["spline.force"])


@pytest.fixture(scope="module")
def turn(model: gb.Model) -> gb.Trajectory:
    """One turn, finely."""
    return gb.simulate(model, t=SETTLED + TURN * np.arange(20001) / 20000, rtol=1e-10)


@pytest.mark.parametrize("quantity", ALL, ids=str)
def test_what_a_name_writes_can_be_read_again(quantity: gb.Quantity) -> None:
    assert parsed(quantity.name) == quantity


def test_the_dynamic_factor_is_the_peak_force_over_that_of_the_static_equilibrium(
    run: gb.Trajectory, turn: gb.Trajectory
) -> None:
    # as tests/reference/test_spline.py makes them from samples: N/F and (F + k x)/F with F = T/r
    static = TORQUE / RADIUS
    contact = (turn["spline.force"] / static).max()
    printed = ((static + turn["spline.stiffness"] * turn["spline.deflection"]) / static).max()
    found = [q.of(run) for q in ALL[:2]]
    assert found == pytest.approx([contact, printed], rel=1e-6)  # a sample is (2 pi/20000)^2/8 off the top at most
    assert found[0] >= contact * (1 - 1e-9) and found[1] >= printed * (1 - 1e-9)


@pytest.mark.long
def test_a_mesh_on_the_coast_side_has_the_same_factor() -> None:
    def factor(torque: float) -> float:
        rig = gb.Drivetrain("pair")
        mesh = gb.GearMesh(
            teeth=(20, 40), module=2e-3, pressure_angle=0.35, external=True, k=1e8, damping_ratio=0.1,
            backlash=gb.Backlash(half_gap=1e-5),
        )  # fmt: skip
        rig.chain(
            rig.add("drive", gb.Torque(tau=torque * (1 + 0.5 * gb.cos(300 * gb.time)))),
            rig.add("a", gb.Inertia(J=1e-3)), rig.add("mesh", mesh), rig.add("b", gb.Inertia(J=1e-2)),
            rig.add("load", gb.Torque(tau=2 * torque)),
        )  # fmt: skip
        return float(gb.dynamic_factor("mesh").of(gb.simulate(rig, t_end=0.05, rtol=1e-9, initial="static")))

    assert factor(-30.0) == pytest.approx(factor(30.0), rel=1e-6)  # accuracy of the runs
    assert factor(30.0) > 1.2


def test_what_has_no_dynamic_factor_is_refused(run: gb.Trajectory, tmp_path) -> None:
    with pytest.raises(gb.UnknownNameError, match="'shaft_in' is no part with an output 'force'"):
        gb.dynamic_factor("shaft_in").of(run)
    with pytest.raises(gb.ParameterError, match="must be one of contact, print"):
        gb.dynamic_factor("spline", "peak").of(run)
    with pytest.raises(gb.ParameterError, match="must be one of peak, trough, mean"):
        gb.dynamic_factor("spline", which="rms").of(run)
    with pytest.raises(gb.ParameterError, match="samples = 1 must be"):
        gb.dynamic_factor("spline", samples=1).of(run)
    run.save(tmp_path / "run.nc")
    with pytest.raises(gb.ParameterError, match="a stored run does not know"):
        gb.dynamic_factor("spline").of(gb.Trajectory.load(tmp_path / "run.nc"))
    rig = scripts.make("spline_coupling").set({"spline.backlash.half_gap": 1e-3})
    idle = gb.simulate(rig, t_end=1.0, parameters={"torque": 0.0})
    with pytest.raises(gb.ParameterError, match="carries no force in the static equilibrium"):
        gb.dynamic_factor("spline").of(idle)


@pytest.mark.long
def test_a_line_is_that_of_the_spectrum(run: gb.Trajectory) -> None:
    window = {"after": SETTLED - 8 * TURN, "before": SETTLED + 2 * TURN}
    spectrum = run.spectrum("spline.force", **window)
    for number in (10, 20, 30):  # harmonics of the turn; lines lie 1/(10 turns) apart
        frequency = spectrum.frequency[number]
        assert frequency == pytest.approx(number / 10 / TURN)
        found = gb.line("spline.force", float(frequency), **window).of(run)
        # the spectrum has other samples: what differs are corners of the force, 1e-6 of its mean
        assert found == pytest.approx(spectrum.amplitude[number], abs=1e-6 * TORQUE / RADIUS)


def test_a_line_is_the_amplitude_of_a_known_vibration() -> None:
    rig = gb.Drivetrain("two parts")
    w = 300 + 2.0 * gb.sin(500 * gb.time) + 0.5 * gb.cos(1700 * gb.time)
    rig.chain(rig.add("drive", gb.Speed(w=w)), rig.add("disc", gb.Inertia(J=1.0)))
    run = gb.simulate(rig, t_end=1.0, max_step=2e-4)  # a prescribed speed asks for no step of its own
    for rate, amplitude in ((500.0, 2.0), (1700.0, 0.5)):
        # lines of Hann's window fall with the cube of the distance, 160 at least; the mean of 300 is left out
        assert gb.line("disc.w", rate / (2 * np.pi)).of(run) == pytest.approx(amplitude, abs=2 * 160.0**-3)
    with pytest.raises(gb.ParameterError, match="must be > 0"):
        gb.line("disc.w", 0.0)
    with pytest.raises(gb.ParameterError, match="takes 4"):
        gb.line("disc.w", 3.0).of(run)


@pytest.mark.long
def test_period_labels_are_those_of_the_regimes(model: gb.Model) -> None:
    speeds = gb.rpm(np.array([300.0, 348.0, 360.0, 1080.0]))
    study = gb.sweep(
        model, {"speed": speeds}, quantity=[gb.period(), gb.period(of="x1"), gb.dynamic_factor("spline")],
        section=gb.stroboscopic("speed"), transient=400, keep=60, rtol=1e-10,
    )  # fmt: skip
    assert study["period()"].tolist() == study["period(of=x1)"].tolist() == [1.0, 2.0, 5.0, 0.0]
    assert np.all(np.diff(study["dynamic_factor(spline)"]) > 0)


def test_a_period_that_cannot_be_judged_is_refused(run: gb.Trajectory) -> None:
    with pytest.raises(gb.ParameterError, match="needs a section"):
        gb.period().of(run)
    with pytest.raises(gb.ParameterError, match="more than twice longest = 16"):
        gb.period("speed", after=SETTLED - 10 * TURN).of(run)
    with pytest.raises(gb.UnknownNameError, match="no output matches y1"):
        gb.period("speed", of="y1").of(run)


def test_a_standard_deviation_does_not_cancel_against_a_large_mean() -> None:
    rig = gb.Drivetrain("far away")
    rig.chain(
        rig.add("drive", gb.Speed(w=1e6 + 1e-3 * gb.sin(200 * np.pi * gb.time))), rig.add("disc", gb.Inertia(J=1.0))
    )
    run = gb.simulate(rig, t_end=1.0, max_step=2e-4)
    # doubles near 1e6 are 1e-10 apart, a ten-millionth of the amplitude; rms^2 - mean^2 would be off by 100 %
    assert gb.std("disc.w").of(run) == pytest.approx(1e-3 / np.sqrt(2), rel=1e-5)


@pytest.mark.long
def test_a_standard_deviation_is_that_of_the_mean_and_the_mean_square(run: gb.Trajectory) -> None:
    std, rms, mean = (q("spline.force", after=SETTLED).of(run) for q in (gb.std, gb.rms, gb.mean))
    assert std**2 == pytest.approx(rms**2 - mean**2, rel=1e-12)

"""Runs between their samples: extrema, integrals, spectra and parts of the solution, not of the samples."""

import numpy as np
import pytest

import gearblocks as gb
from gearblocks.simulation import plotting


def _pendulum(**how):
    """A disc on a spring: phi = cos(2 t) a, energy without loss; torque of the spring -8 cos(2 t)."""
    rig = gb.Drivetrain("swing")
    disc, spring = rig.add("disc", gb.Inertia(J=1.0, phi0=2.0)), rig.add("spring", gb.Shaft(k=4.0))
    rig.chain(rig.add("wall", gb.Fixed()), spring, disc)
    return gb.simulate(rig, rtol=1e-9, **how)


@pytest.mark.parametrize("how", [{"t_end": 3.0}, {"t": [0.0, 1.0, 2.0, 3.0]}], ids=str)
def test_extremes_are_those_of_the_solution_whatever_was_sampled(how):
    run = _pendulum(**how)
    found = run.extremes("disc.phi", after=0.5)
    assert found.low == pytest.approx(-2.0, rel=1e-7)
    assert found.low_at == pytest.approx(np.pi / 2, abs=1e-4)
    assert found.high == pytest.approx(2.0 * np.cos(6.0), rel=1e-7)  # at the end, on the way up
    assert found.high_at == pytest.approx(3.0)
    assert (found.low, found.high) == (
        gb.trough("disc.phi", after=0.5).of(run),
        gb.peak("disc.phi", after=0.5).of(run),
    )


def test_integrals_are_those_of_the_quantities():
    run = _pendulum(t=[0.0, 1.1, np.pi])
    assert run.rms("disc.phi") == gb.rms("disc.phi").of(run) == pytest.approx(np.sqrt(2.0), rel=1e-7)
    assert run.mean("disc.phi") == gb.mean("disc.phi").of(run) == pytest.approx(0.0, abs=1e-7)


def test_a_spectrum_shows_a_wave_at_its_frequency_and_height():
    run = _pendulum(t_end=40 * np.pi)
    found = run.spectrum("disc.phi")
    top = int(np.argmax(found.amplitude))
    assert found.frequency[top] == pytest.approx(1 / np.pi, rel=1e-9)
    assert found.amplitude[top] == pytest.approx(2.0, rel=1e-6)
    assert found.amplitude[0] < 1e-6
    assert np.sum(found.amplitude > 1e-3) == 3  # the line and its two neighbours under the window of Hann


def test_a_part_of_a_run_is_found_between_its_samples_and_keeps_its_events():
    rig = gb.Drivetrain("bounce")
    ball, wall = rig.add("ball", gb.Mass(m=1.0, s0=1.0)), rig.add("wall", gb.HardStop(lower=0.0, restitution=0.5))
    rig.chain(rig.add("weight", gb.Force(f=-9.81)), ball, wall)
    run = gb.simulate(rig, t=[0.0, 1.0], rtol=1e-9)
    fall = np.sqrt(2 / 9.81)
    part = run.between(0.2, 0.6, samples=401)
    assert part.t[[0, -1]].tolist() == [0.2, 0.6]
    t = part.t
    after = t - fall
    expected = np.where(t < fall, 1 - 9.81 * t**2 / 2, 0.5 * 9.81 * fall * after - 9.81 * after**2 / 2)
    assert np.abs(part["ball.s"] - expected).max() < 1e-7
    assert [event.t for event in part.events] == pytest.approx([fall], rel=1e-9)
    assert run.extremes("ball.v").low == pytest.approx(-9.81 * fall, rel=1e-6)


def test_a_stored_run_is_read_on_splines(tmp_path):
    run = _pendulum(t=np.linspace(0, 3, 61))
    run.save(tmp_path / "run.nc")
    stored = gb.Trajectory.load(tmp_path / "run.nc")
    assert stored.extremes("disc.phi", after=0.5).low == pytest.approx(-2.0, rel=1e-6)
    assert stored.between(0.4, 0.5, samples=5)["disc.phi"] == pytest.approx(2 * np.cos(2 * np.linspace(0.4, 0.5, 5)))


def test_wrong_windows_and_names_are_refused_by_name():
    run = _pendulum(t_end=1.0)
    with pytest.raises(gb.UnknownNameError, match=r"no output 'disc\.phy'.*did you mean 'disc\.phi'"):
        run.extremes("disc.phy")
    for call in (lambda: run.between(0.5, 0.5), lambda: run.rms("disc.phi", after=2.0), lambda: run.between(0.2, 3.0)):
        with pytest.raises(gb.ParameterError, match="is no part of a run from 0 s to 1 s"):
            call()
    with pytest.raises(gb.ParameterError, match="samples = 1 must be"):
        run.between(0.0, 1.0, samples=1)


@pytest.mark.long
def test_a_spectrum_is_drawn_up_to_its_last_line_without_its_mean(tmp_path):
    run = _pendulum(t_end=40 * np.pi)
    found = run.spectrum("disc.kinetic_energy")  # 4 (1 - cos(4 t)): a mean, and one line at 2/pi Hz
    assert (found.name, found.unit, found.title) == ("disc.kinetic_energy", "J", "swing")
    frequency, amplitude = found
    assert amplitude[frequency.searchsorted(2 / np.pi - 1e-9)] == pytest.approx(4.0, rel=1e-3)
    assert "mean 4 J, largest 4 J at 0.63662 Hz" in repr(found)
    figure = found.plot(tmp_path / "lines.png")
    (axis,) = figure.axes
    lines = np.array([segment[1] for segment in axis.collections[0].get_segments()])
    assert axis.get_xlabel() == "frequency in mHz"
    assert lines[:, 1].max() == pytest.approx(4.0, rel=1e-3)
    assert lines[lines[:, 1].argmax(), 0] == pytest.approx(2000 / np.pi, rel=1e-9)
    assert lines[:, 0].max() < 1.1 * 2000 / np.pi
    assert (tmp_path / "lines.png").stat().st_size > 1000


def test_runs_are_compared_on_their_solutions():
    one, other = _pendulum(t_end=3.0), _pendulum(t_end=2.0, parameters={"spring.k": 4.0 * 1.0002})
    assert "and 1 more" not in str(gb.compare(one, other, "disc.*"))
    whole = gb.compare(one, other)
    assert len(str(whole).splitlines()) == min(len(whole), 21)
    found = gb.compare(one, other, "disc.*")
    assert {row.name for row in found} >= {"disc.phi", "disc.w"}
    # d/dk of 2 cos(w t): 2 sin(w t) t dw, dw = w 1e-4
    t = np.linspace(0, 2, 4001)
    assert found["disc.phi"].largest == pytest.approx(np.max(np.abs(2 * np.sin(2 * t) * t * 2e-4)), rel=1e-3)
    assert "of its size" in str(found)
    same = gb.compare(one, _pendulum(t=[0.0, 1.5, 3.0]))
    assert max(row.share for row in same) < 1e-7
    with pytest.raises(gb.UnknownNameError, match="no output in common"):
        gb.compare(one, gb.simulate(_other(), t_end=1.0))


def _other():
    rig = gb.Drivetrain("other")
    rig.add("body", gb.Inertia(J=1.0))
    return rig


# -- pictures ---------------------------------------------------------------------------------------------------------


def test_curves_follow_the_solution_and_equal_ones_share_a_legend_entry(tmp_path):
    run = _pendulum(t=[0.0, 1.0, 2.0, 3.0])
    figure = run.plot("disc.phi", path=tmp_path / "phi.png")
    (line,) = figure.axes[0].get_lines()
    t, phi = line.get_data()
    assert len(t) > 20
    assert np.abs(phi - 2 * np.cos(2 * t)).max() < 1e-7
    t, y = np.linspace(0, 1, 5), np.arange(5.0)
    twice = [("a.x", "m", y), ("b.x", "m", y), ("c.x", "m", 2 * y)]
    axis = plotting.over_time(t, twice, path=tmp_path / "two.png").axes[0]
    assert [text.get_text() for text in axis.get_legend().get_texts()] == ["a.x = b.x", "c.x"]


def test_modes_are_steps_and_events_ticks(tmp_path):
    rig = gb.Drivetrain("launch")
    one, two = rig.add("one", gb.Inertia(J=1.0, w0=2.0)), rig.add("two", gb.Inertia(J=1.0))
    rig.chain(one, rig.add("clutch", gb.Clutch(capacity=1.0)), two)
    figure = gb.simulate(rig, t_end=2.0).plot("clutch.mode", path=tmp_path / "mode.png")
    mode, ticks = figure.axes[0].get_lines()
    assert mode.get_drawstyle() == "steps-post"
    assert ticks.get_marker() == "|"
    assert ticks.get_xdata() == pytest.approx([1.0], rel=1e-6)

"""Lines of steady motions: amplitudes and phases that are known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import gearblocks as gb

Oscillator = Callable[..., gb.Drivetrain]
SECTION = gb.stroboscopic("drive")


def test_lines_of_a_linear_train_are_those_of_its_transfer_function(oscillator: Oscillator, tmp_path: Path) -> None:
    rig = oscillator(
        lambda drive, x, v: 0.7 + gb.cos(drive * gb.time) + 0.2 * gb.sin(1.5 * drive * gb.time), k=3.0, c=0.2
    )
    found = gb.spectrum(rig, section=SECTION, of="disc.phi", parameters={"drive": 2.0}, samples=64)
    assert found.periods == 2 and found.miss < 1e-8
    expected = np.zeros(len(found.order), dtype=complex)
    expected[0] = 0.7 / 3.0
    for order, force in ((1.0, 1.0), (1.5, -0.2j)):
        w = 2.0 * order
        expected[int(2 * order)] = force / (3.0 - w**2 + 0.2j * w)
    assert found.amplitude == pytest.approx(np.abs(expected), abs=1e-8)
    # phases are told from t = 0
    for i in (2, 3):
        assert np.exp(1j * found.phase[i]) == pytest.approx(expected[i] / abs(expected[i]), abs=1e-7)
    assert found.frequency[3] == pytest.approx(3.0 / (2 * np.pi)) and found.order[3] == 1.5
    data = found.to_xarray()
    assert data["amplitude"].attrs["units"] == "rad" and "order 1" in repr(found)
    found.plot(tmp_path / "lines.png")
    assert (tmp_path / "lines.png").stat().st_size > 5000


@pytest.mark.long
def test_lines_are_those_of_the_run_under_a_window(oscillator: Oscillator) -> None:
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) - x**3, k=1.0, c=0.3)
    found = gb.spectrum(rig, section=SECTION, of="disc.phi")
    run = gb.simulate(rig, t_end=2 * np.pi * 332, rtol=1e-9)
    window = run.spectrum("disc.phi", after=2 * np.pi * 300, before=2 * np.pi * 332)
    for order in (1, 3, 5):
        assert found.amplitude[order] == pytest.approx(window.amplitude[32 * order], rel=1e-6)


def test_what_has_no_lines_is_refused_by_name(oscillator: Oscillator) -> None:
    rig = oscillator(lambda drive, x, v: gb.cos(drive * gb.time) + gb.cos(np.sqrt(2) * gb.time), k=3.0, c=0.2)
    with pytest.raises(gb.ParameterError, match=r"does not repeat has run\.spectrum\('disc.phi'\)"):
        gb.spectrum(rig, section=SECTION, of="disc.phi")
    with pytest.raises(gb.ParameterError, match="samples = 100 a power of two"):
        gb.spectrum(rig, section=SECTION, of="disc.phi", samples=100)
    with pytest.raises(gb.UnknownNameError, match=r"disc\.fi"):
        gb.spectrum(rig, section=SECTION, of="disc.fi")

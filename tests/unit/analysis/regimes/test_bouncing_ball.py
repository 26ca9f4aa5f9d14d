"""A ball on a table that shakes (gravity 1, table A sin t): an impact a period, doubled, against closed forms (Holmes 1982)."""

from __future__ import annotations

import numpy as np
import pytest

import gearblocks as gb

SECTION = gb.stroboscopic("drive")
E = 0.5
BEGINS = np.pi * (1 - E) / (1 + E)
DOUBLES = float(np.hypot(BEGINS, 2 * (1 + E**2) / (1 + E) ** 2))
"""Amplitudes: the table makes up for what an impact loses where its speed is BEGINS, once a period. From impact to impact the
map has the determinant e^2 and the trace 1 + e^2 - (1 + e)^2 sqrt(A^2 - BEGINS^2), which is -1 - e^2 at DOUBLES."""


def _ball(amplitude: float | gb.Parameter) -> gb.Drivetrain:
    rig, drive = gb.Drivetrain("ball"), gb.Parameter("drive", 1.0, "rad/s")
    table = rig.add("table", gb.Angle(phi=amplitude * gb.sin(drive * gb.time)))
    disc = rig.add("disc", gb.Inertia(J=1.0, phi0=0.5, w0=3.0))
    rig.chain(rig.add("weight", gb.Torque(tau=-1.0)), disc)
    rig.chain(table, rig.add("stop", gb.HardStop(lower=0.0, upper=1e3, restitution=E)), disc)
    return rig


@pytest.mark.few(1)
@pytest.mark.parametrize(("amplitude", "period"), [(1.3, 1), (1.45, 1), (1.6, 2)])
def test_its_label_is_that_of_the_closed_form(amplitude: float, period: int) -> None:
    assert (amplitude > DOUBLES) is (period == 2)
    found = gb.classify(_ball(amplitude), SECTION)
    assert found.label == f"period {period}" and found.orbit is not None, found.evidence
    two = found.orbit.multipliers[:2]  # what the stop records is nothing
    assert np.prod(two).real == pytest.approx(E ** (2 * period), rel=1e-7)
    if period == 1:
        trace = 1 + E**2 - (1 + E) ** 2 * np.sqrt(amplitude**2 - BEGINS**2)
        assert two.sum().real == pytest.approx(trace, abs=1e-8)


def test_its_doubling_lies_where_the_closed_form_has_it() -> None:
    branch = gb.continue_orbit(
        _ball(gb.Parameter("amplitude", 1.3)), "amplitude", (1.3, 1.6), section=SECTION, of="disc.phi"
    )
    (mark,) = branch.marked("period doubling")
    assert mark.bracket[0] - 1e-7 <= DOUBLES <= mark.bracket[1] + 1e-7
    assert branch.stable[: mark.number].all() and not branch.stable[mark.number + 1 :].any()

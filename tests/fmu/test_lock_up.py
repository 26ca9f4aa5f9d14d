"""A clutch that locks inside an FMU: the grid of communication points, and states saved before the event."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import fmu_export
import gearblocks as gb
from fmu_export.checks.instance import Instance, Unpacked

LOCK, SPEED, HEAT = 4 / 3, 100 / 3, 1e4 / 3
NAMES = ("one.w", "two.w", "one.phi", "two.phi", "clutch.w_rel", "clutch.mode")


@pytest.fixture(scope="module")
def launch() -> gb.Drivetrain:
    """J = 1 at 100 rad/s and J = 2 at rest behind a clutch of 50 N m: they lock at 4/3 s, and 1e4/3 J are lost."""
    rig = gb.Drivetrain("launch")
    one, two = rig.add("one", gb.Inertia(J=1.0, w0=100.0)), rig.add("two", gb.Inertia(J=2.0, w0=0.0))
    rig.chain(one, rig.add("clutch", gb.Clutch(capacity=50.0)), two)
    return rig


@pytest.fixture(scope="module")
def unpacked(
    launch: gb.Drivetrain, unpacker: Callable[[Path, Path], Unpacked], tmp_path_factory: pytest.TempPathFactory
) -> Unpacked:
    folder = tmp_path_factory.mktemp("launch")
    return unpacker(fmu_export.export(launch, folder / "launch.fmu", t_end=5.0), folder / "unpacked")


def _stepped(unpacked: Unpacked, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Outputs at the communication points, one row each."""
    references = {v.name: v.valueReference for v in unpacked.description.modelVariables}
    rows, before = [], 0.0
    with Instance(unpacked) as instance:
        instance.start()
        for t in times:
            instance.step(before, t - before)
            rows.append(instance.get([references[name] for name in NAMES]))
            before = t
    return np.array(rows)


@pytest.mark.long
def test_communication_steps_across_a_lock_up_lose_nothing(launch: gb.Drivetrain, unpacked: Unpacked) -> None:
    times = np.arange(1, 501) * 1e-2
    rows, run = _stepped(unpacked, times), gb.simulate(launch, t=times)
    for i, name in enumerate(NAMES):
        np.testing.assert_allclose(rows[:, i], run[name], rtol=1e-12, atol=1e-12, err_msg=name)  # samples differ in t
    w = rows[-1, :2]
    assert w == pytest.approx([SPEED, SPEED], rel=1e-12)
    assert 5000.0 - (w[0] ** 2 + 2 * w[1] ** 2) / 2 == pytest.approx(HEAT, rel=1e-6)
    locked = times > LOCK
    assert not rows[locked, 4].any() and not rows[locked, 5].any()  # slip and mode are 0 to the last bit


@pytest.mark.long
def test_the_grid_of_communication_points_changes_nothing(unpacked: Unpacked) -> None:
    grids = [np.arange(1, round(2.0 / h) + 1) * h for h in (1e-1, 1e-2, 1e-3)]
    grids.append(np.union1d(grids[0], [LOCK]))
    found = [_stepped(unpacked, times) for times in grids]
    for times, rows in zip(grids[1:], found[1:], strict=True):
        at = [int(np.argmin(np.abs(times - t))) for t in grids[0]]
        scale = np.abs(found[0]).max(axis=0)
        assert (np.abs(rows[at] - found[0]) <= 1e-5 * scale).all()  # ten times the tolerance


@pytest.mark.long
def test_a_state_saved_before_the_lock_up_gives_the_same_bits_again(unpacked: Unpacked) -> None:
    references = [v.valueReference for v in unpacked.description.modelVariables if v.causality == "output"]
    with Instance(unpacked) as instance:
        instance.start()
        instance.step(0.0, 1.3)
        state = instance.fmu.getFMUstate()
        passes = []
        for _ in range(2):
            instance.fmu.setFMUstate(state)
            rows = []
            for t, h in ((1.3, 0.01), (1.31, 0.09), (1.4, 0.6)):
                instance.step(t, h)
                rows.append(instance.get(references))
            passes.append(rows)
        instance.fmu.freeFMUstate(state)
    assert passes[0] == passes[1]

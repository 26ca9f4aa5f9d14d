"""Trains with clutches, brakes and stops, packed: locks close and break inside the file as they do in process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest

import fmu_export
import gearblocks as gb
from fmu_export.checks.instance import Instance, Unpacked

pytestmark = pytest.mark.filterwarnings("ignore:.*is left first")  # tables that are held on purpose

LOCK_UP = 4.0 / 3.0  # s: 100 rad/s of slip go at 50 N m (1/1 + 1/2) per s


def _lock_up() -> gb.Drivetrain:
    """Two discs, J = 1 and 2, at 100 and 0 rad/s; a clutch of 50 N m between them."""
    rig = gb.Drivetrain("lock-up")
    one, two = rig.add("one", gb.Inertia(J=1.0, w0=100.0)), rig.add("two", gb.Inertia(J=2.0))
    rig.chain(one, rig.add("clutch", gb.Clutch(capacity=50.0)), two)
    return rig


def _busy() -> gb.Drivetrain:
    """A clutch that a sine engages and lets go, a brake with a peak, and a stop."""
    rig = gb.Drivetrain("busy")
    one, two, three = (rig.add(n, gb.Inertia(J=J)) for n, J in (("one", 0.3), ("two", 0.5), ("three", 0.2)))
    drive = rig.add("drive", gb.Torque(tau=6.0 + 9.0 * gb.sin(5.0 * gb.time) + gb.Input("extra")))
    clutch = gb.Clutch(mu=gb.Table([0.0, 20.0], [0.4, 0.3]), force_max=20.0, engagement=gb.sin(3.0 * gb.time), peak=1.1)
    rig.chain(drive, one, rig.add("clutch", clutch), two, rig.add("shaft", gb.Shaft(k=300.0, c=0.4)), three)
    rig.connect(rig.add("brake", gb.Brake(capacity=2.0, peak=1.5)).a, two.a)
    rig.connect(rig.add("stop", gb.HardStop(lower=-0.5, upper=0.8, restitution=0.0)).a, three.a)
    return rig


def _references(path: Path, *names: str) -> list[int]:
    known = {v.name: v.valueReference for v in fmpy.read_model_description(str(path)).modelVariables}
    outputs = [v.name for v in fmpy.read_model_description(str(path)).modelVariables if v.causality == "output"]
    return [known[n] for n in (names or outputs)]


@pytest.mark.long
@pytest.mark.parametrize("make", [pytest.param(_lock_up, marks=pytest.mark.long), _busy])
def test_a_train_with_friction_passes_every_check(make: Callable[[], gb.Drivetrain], tmp_path: Path) -> None:
    report = fmu_export.check(fmu_export.export(make(), tmp_path / "rig.fmu", t_end=2.0))
    assert all(item.ok for item in report.items), str(report)
    assert max(difference for _, difference in report.differences) == 0.0


@pytest.mark.parametrize(
    ("make", "step"),
    [
        pytest.param(
            make, step, marks=[pytest.mark.long] * ((make, step) not in ((_busy, 1e-1), (_lock_up, LOCK_UP / 4)))
        )
        for make in (_lock_up, _busy)
        for step in (1e-1, 1e-2, 1e-3, LOCK_UP / 4)
    ],
)
@pytest.mark.few(1)
def test_the_file_has_the_bits_of_the_run_at_every_communication_step(
    make: Callable[[], gb.Drivetrain], step: float, tmp_path: Path
) -> None:
    """The last one ends a step where the clutch of the first train sticks."""
    rig = make()
    path = fmu_export.export(rig, tmp_path / "rig.fmu")
    result = fmpy.simulate_fmu(str(path), stop_time=2.0, output_interval=step)
    run = gb.simulate(rig, t=result["time"])
    assert run.stats.events > 0
    for name in result.dtype.names[1:]:
        np.testing.assert_array_equal(result[name], run[name], err_msg=name)


@pytest.mark.long
def test_heat_of_a_lock_up_does_not_depend_on_the_communication_step(tmp_path: Path) -> None:
    path = fmu_export.export(_lock_up(), tmp_path / "rig.fmu")
    heat = 1e4 / 3  # 1/2 J1 J2/(J1 + J2) 100^2
    result = fmpy.simulate_fmu(str(path), stop_time=2.0, output_interval=1e-2)
    w1, w2 = result["one.w"][-1], result["two.w"][-1]
    assert 0.5 * 1.0 * 100.0**2 - 0.5 * w1**2 - w2**2 == pytest.approx(heat, rel=1e-12)
    assert np.trapezoid(result["clutch.loss_power"], result["time"]) == pytest.approx(
        heat, rel=1e-4
    )  # of a sampled ramp
    run = gb.simulate(_lock_up(), t=np.linspace(0.0, 2.0, 201))
    assert run.energy.dissipated["clutch"] == pytest.approx(heat, rel=1e-9)


@pytest.mark.long
@pytest.mark.parametrize(("make", "at"), [(_lock_up, 1.32), pytest.param(_busy, 0.31, marks=pytest.mark.long)])
def test_a_state_that_is_saved_before_a_lock_up_gives_the_same_bits_again(
    make: Callable[[], gb.Drivetrain], at: float, tmp_path: Path, unpacker: Callable[[Path, Path], Unpacked]
) -> None:
    path = fmu_export.export(make(), tmp_path / "rig.fmu")
    references, modes = _references(path), _references(path, "clutch.mode")
    with (
        Instance(unpacker(path, tmp_path / "unpacked")) as instance,
        Instance(unpacker(path, tmp_path / "other")) as other,
    ):
        instance.start()
        t, h = 0.0, 0.01
        while t < at:
            instance.step(t, h)
            t += h
        before, saved, begin = instance.get(modes), instance.fmu.getFMUstate(), t
        first = []
        for _ in range(120):
            instance.step(t, h)
            t += h
            first.append((*instance.get(references), *instance.get(modes)))
        assert {row[-1] for row in first} - set(before)  # the clutch changes its mode in between
        data = instance.fmu.serializeFMUstate(saved)
        copy = other.fmu.deSerializeFMUstate(data)
        other.fmu.setFMUstate(copy)
        instance.fmu.setFMUstate(saved)
        for one in (instance, other):
            t = begin
            for row in first:
                one.step(t, h)
                t += h
                assert (*one.get(references), *one.get(modes)) == row
        other.fmu.freeFMUstate(copy)
        instance.fmu.freeFMUstate(saved)


@pytest.mark.long
def test_an_input_that_overloads_a_stuck_clutch_breaks_it_inside_the_file(
    tmp_path: Path, unpacker: Callable[[Path, Path], Unpacked]
) -> None:
    rig = gb.Drivetrain("overload")
    one, two = rig.add("one", gb.Inertia(J=1.0)), rig.add("two", gb.Inertia(J=2.0))
    drive = rig.add("drive", gb.Torque(tau=gb.Input("tau")))
    rig.chain(drive, one, rig.add("clutch", gb.Clutch(capacity=4.0)), two)
    path = fmu_export.export(rig, tmp_path / "rig.fmu")
    (tau,), (mode, slip) = _references(path, "tau"), _references(path, "clutch.mode", "clutch.w_rel")
    with Instance(unpacker(path, tmp_path / "unpacked")) as instance:
        instance.start()
        instance.set([tau], [5.9])  # 2/3 of it goes through the clutch
        instance.step(0.0, 0.5)
        assert instance.get([mode, slip]) == [0.0, 0.0]
        instance.set([tau], [6.6])
        instance.step(0.5, 0.5)
        assert instance.get([mode])[0] == -1.0
        assert instance.get([slip])[0] == pytest.approx(-0.5 * ((6.6 - 4.0) / 1.0 - 4.0 / 2.0), rel=1e-12)

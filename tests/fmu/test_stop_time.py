"""Without a stop time as with one, and steps of any length: bounded work, and the bits of many small ones."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi2 import fmi2LastSuccessfulTime

import fmu_export
import gearblocks as gb
from fmu_export.checks.instance import OK, Instance, Unpacked
from gearblocks.solver.library import Model

sys.path.insert(0, str(Path(__file__).parents[2] / "models"))
import automatic_gearbox
import dual_clutch
import modelica_examples
import noncircular_cvt
import planetary_backlash
import spline_coupling
import stiff_chain

DISCARD = 2
Unpacker = Callable[[Path, Path], Unpacked]


def refs_of(unpacked: Unpacked, *names: str) -> list[int]:
    found = {v.name: v.valueReference for v in unpacked.description.modelVariables}
    return [found[name] for name in names]


# -- motions that are polynomials in time, driven step by step -------------------------------------------------------


def _pushed() -> gb.Drivetrain:
    rig = gb.Drivetrain("pushed")
    rig.chain(
        rig.add("drive", gb.Torque(tau=gb.Input("tau", start=1.0, unit="N m"))), rig.add("body", gb.Inertia(J=0.5))
    )
    return rig


def _geared() -> gb.Drivetrain:
    rig = gb.Drivetrain("geared")
    rig.chain(
        rig.add("drive", gb.Torque(tau=gb.Input("tau", start=1.0, unit="N m"))),
        rig.add("fast", gb.Inertia(J=0.1)),
        rig.add("gear", gb.IdealGear(ratio=4)),
        rig.add("body", gb.Inertia(J=6.4)),
    )
    return rig


def _sprung() -> gb.Drivetrain:
    """Two equal bodies pushed alike: the shaft between them never twists."""
    rig = gb.Drivetrain("sprung")
    one, two = (rig.add(name, gb.Inertia(J=0.5)) for name in ("body", "other"))
    rig.chain(one, rig.add("shaft", gb.Shaft(k=100.0)), two)
    for i, end in enumerate((one.a, two.b)):
        rig.connect(rig.add(f"drive{i}", gb.Torque(tau=gb.Input("tau", start=1.0, unit="N m"))).flange, end)
    return rig


GAIN = {"pushed": 2.0, "geared": 0.5, "sprung": 2.0}
"""rad/s2 of the body per N m: 1/J; 4/(6.4 + 16 0.1)."""


@pytest.mark.long
@pytest.mark.parametrize("make", [_pushed, _geared, pytest.param(_sprung, marks=pytest.mark.long)])
@pytest.mark.parametrize("stop", [pytest.param(None, marks=pytest.mark.long), 10.0])
def test_inputs_written_at_every_step_let_no_step_run_away(
    make: Callable[[], gb.Drivetrain], stop: float | None, tmp_path: Path, unpacker: Unpacker
) -> None:
    """w and phi are sums of constants and ramps. Steps that grew from cut step to cut step had reached 1e142 s after 233."""
    rig = make()
    unpacked = unpacker(fmu_export.export(rig, tmp_path / "m.fmu", outputs=["body.*"]), tmp_path / "m")
    tau, phi, w = refs_of(unpacked, "tau", "body.phi", "body.w")
    h, speed, angle = 1e-3, 0.0, 0.0
    with Instance(unpacked) as instance:
        instance.start(stop=stop)
        for i in range(1000):
            torque = 1.0 + 0.5 * np.sin(i)
            instance.set([tau], [torque])
            assert instance.status_of(lambda t=i * h: instance.step(t, h)) == OK
            angle += h * speed + 0.5 * h * h * GAIN[rig.name] * torque
            speed += h * GAIN[rig.name] * torque
        got = instance.get([phi, w])
    np.testing.assert_allclose(got, [angle, speed], rtol=1e-10)  # rounding alone: the solver is exact on such motions


@pytest.mark.long
def test_parameters_tuned_at_every_step_let_no_step_run_away(tmp_path: Path, unpacker: Unpacker) -> None:
    unpacked = unpacker(fmu_export.export(_pushed(), tmp_path / "m.fmu"), tmp_path / "m")
    inertia, w = refs_of(unpacked, "body.J", "body.w")
    h, speed = 1e-3, 0.0
    with Instance(unpacked) as instance:
        instance.start()
        for i in range(1000):
            value = 0.5 + 0.1 * np.cos(i)
            instance.set([inertia], [value])
            instance.step(i * h, h)
            speed += h / value
        assert instance.get([w])[0] == pytest.approx(speed, rel=1e-10)


# -- eight models ----------------------------------------------------------------------------------------------------


EIGHT = {
    "inertia": (_pushed, 1.0, ("body.phi", "body.w")),
    "coupled clutches": (modelica_examples.coupled_clutches, 1.5, ("J1.w", "J2.w", "J3.w", "J4.w")),
    "spline": (spline_coupling.build, 0.2, ("x1", "x2", "x3", "input.w", "output.w")),
    "cvt": (noncircular_cvt.build, 0.5, ("shaft_1.twist", "output.w", "output.phi")),
    "gearbox": (automatic_gearbox.build, 20.0, ("crank.w", "turbine.w", "half_shafts.twist")),
    "planetary": (planetary_backlash.build, 0.02, ("sun.w", "ring.w", "carrier.w", "planet0.w")),
    "chain of 100": (stiff_chain.build, 0.1, ("disc0.phi", "disc0.w", "disc50.w", "disc99.phi")),
    "dual clutch": (dual_clutch.build, 3.0, ("crank.w", "output.w", "half_shafts.twist")),
}


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[] if n in ("inertia", "coupled clutches") else pytest.mark.long) for n in EIGHT]
)
@pytest.mark.few(1)
def test_a_stop_time_changes_nothing_but_the_last_digits(name: str, tmp_path: Path, unpacker: Unpacker) -> None:
    """Within 10 rtol of the peak, for many communication steps and for one; and a fine run says that both are right."""
    make, end, names = EIGHT[name]
    model = gb.build(make())
    unpacked = unpacker(fmu_export.export(model, tmp_path / "m.fmu", patience=None), tmp_path / "m")
    refs = refs_of(unpacked, *names)

    def rows(stop: float | None, count: int) -> np.ndarray:
        times = np.linspace(0.0, end, count + 1)
        found = []
        with Instance(unpacked) as instance:
            instance.start(stop=stop)
            for begin, until in itertools.pairwise(times):
                instance.step(begin, until - begin)
                found.append(instance.get(refs))
        return np.array(found)

    many = rows(end, 200), rows(None, 200)
    peak = np.abs(many[0]).max(axis=0)
    assert (np.abs(many[0] - many[1]) <= 1e-5 * peak).all()
    assert (np.abs(rows(None, 1)[0] - many[0][-1]) <= 1e-5 * peak).all()
    fine = gb.simulate(model, t=np.linspace(0.0, end, 201)[1:], rtol=1e-9, outputs=list(names))
    assert (np.abs(many[0] - np.column_stack([fine[name] for name in names])) <= 1e-5 * peak).all()


# -- long steps ------------------------------------------------------------------------------------------------------


def _governed() -> gb.Drivetrain:
    """A brake that stops and lets go a swinging torque for ever."""
    rig = gb.Drivetrain("governed")
    body = rig.add("body", gb.Inertia(J=1.0))
    rig.chain(
        rig.add("drive", gb.Torque(tau=3.0 * gb.sin(5.0 * gb.time))), body, rig.add("brake", gb.Brake(capacity=2.0))
    )
    return rig


def test_a_step_of_any_length_is_bounded_work_and_goes_on_where_it_is_asked_again(
    model: Model, tmp_path: Path, unpacker: Unpacker
) -> None:
    """fmi2Discard, where the instance stands is told, and the way in pieces has the bits of the way at once."""
    hasty = unpacker(fmu_export.export(model, tmp_path / "a.fmu", patience=0.0), tmp_path / "a")
    patient = unpacker(fmu_export.export(model, tmp_path / "b.fmu", patience=None), tmp_path / "b")
    names, end = ("wheel.phi", "wheel.w", "spring.contact"), 0.5
    with Instance(patient) as instance:
        instance.start()
        instance.step(0.0, end)
        expected = instance.get(refs_of(patient, *names))
    for again in (True, False):  # from the beginning of the step, or from where it stands
        with Instance(hasty) as instance:
            instance.start()
            stands, answers = 0.0, []
            while not answers or answers[-1] == DISCARD:
                begin = 0.0 if again else stands
                answers.append(instance.status_of(lambda begin=begin, i=instance: i.step(begin, end - begin)))
                if answers[-1] == DISCARD:
                    reached = instance.fmu.getRealStatus(fmi2LastSuccessfulTime)
                    assert stands < reached < end
                    stands = reached
                    assert "goes on from there" in instance.log[-1][2]
            assert answers[-1] == OK
            assert len(answers) > 3
            assert instance.get(refs_of(hasty, *names)) == expected
            assert instance.refuses(lambda i=instance: i.step(0.0, 2 * end))  # what is done is not asked again


@pytest.mark.long
@pytest.mark.parametrize("h", [*(pytest.param(h, marks=pytest.mark.long) for h in (1e3, 1e12)), 1e300])
def test_steps_of_the_age_of_the_world_and_beyond_come_back(h: float, tmp_path: Path, unpacker: Unpacker) -> None:
    unpacked = unpacker(fmu_export.export(_governed(), tmp_path / "m.fmu", patience=0.0), tmp_path / "m")
    with Instance(unpacked) as instance:
        instance.start()
        assert instance.status_of(lambda: instance.step(0.0, h)) == DISCARD
        assert 0.0 < instance.fmu.getRealStatus(fmi2LastSuccessfulTime) < h
        assert np.isfinite(instance.get(refs_of(unpacked, "body.w"))).all()


def test_a_motion_that_leaves_the_numbers_ends_by_name(tmp_path: Path, unpacker: Unpacker) -> None:
    """phi = t^2: after 1e154 s it is no double, after 1e100 s its energy is beyond all bounds; shorter steps do not help."""
    unpacked = unpacker(fmu_export.export(_pushed(), tmp_path / "m.fmu"), tmp_path / "m")
    for far in (1e300, 1e140):
        with Instance(unpacked) as instance:
            instance.start()
            line = instance.refuses(lambda far=far: instance.step(0.0, far))
            assert "the motion grows without bound" in line and "'body." in line and "?" not in line
    with Instance(unpacked) as instance:
        instance.start()
        instance.step(0.0, 1e90)
        phi, w = instance.get(refs_of(unpacked, "body.phi", "body.w"))
        assert (phi, w) == (pytest.approx(1e180, rel=1e-6), pytest.approx(2e90, rel=1e-6))


def test_steps_that_do_not_bring_a_step_of_the_master_on_end_it_by_name(tmp_path: Path, unpacker: Unpacker) -> None:
    """It comes to rest within 1e-20 s: by an explicit method in more steps than there is time for."""
    rig = gb.Drivetrain("stiff")
    rig.chain(rig.add("brake", gb.Torque(tau=-1e20 * gb.sense("body.w"))), rig.add("body", gb.Inertia(J=1.0, w0=1.0)))
    unpacked = unpacker(fmu_export.export(rig, tmp_path / "m.fmu", method="dp5", patience=None), tmp_path / "m")
    with Instance(unpacked) as instance:
        instance.start()
        line = instance.refuses(lambda: instance.step(0.0, 1.0))
        assert "steps or tries in a row hardly bring the run on" in line and "'body." in line and "?" not in line


@pytest.mark.long
def test_a_trial_step_that_is_not_finite_is_a_step_too_long(tmp_path: Path, unpacker: Unpacker) -> None:
    """The torque (1 - t)^0.5 N m is no number beyond t = 1 s; the run goes as far as it goes."""
    rig = gb.Drivetrain("to the edge")
    rig.chain(rig.add("drive", gb.Torque(tau=(1.0 - gb.time) ** 0.5)), rig.add("body", gb.Inertia(J=0.5)))
    unpacked = unpacker(fmu_export.export(rig, tmp_path / "m.fmu"), tmp_path / "m")
    with Instance(unpacked) as instance:
        instance.start()
        assert instance.status_of(lambda: instance.step(0.0, 0.999999)) == OK
        assert instance.get(refs_of(unpacked, "body.w"))[0] == pytest.approx(
            4.0 / 3.0, rel=1e-5
        )  # 2 int (1 - t)^0.5 dt
        line = instance.refuses(lambda: instance.step(0.999999, 1e6))
        assert "t = 1 s" in line
        assert "body.w" in line or "drive" in line


@pytest.mark.long
def test_steps_that_are_lost_in_the_rounding_of_the_time_end_the_run_by_name(
    tmp_path: Path, unpacker: Unpacker
) -> None:
    """With an inertia of 1e-60 the first step that is right is 1e-31 s long; at t = 1 s that is no step at all."""
    rig = gb.Drivetrain("light")
    rig.chain(
        rig.add("ground", gb.Fixed()),
        rig.add("shaft", gb.Shaft(k=100.0)),
        rig.add("end", gb.Inertia(J=0.5, phi0=0.1, w0=1.0)),
        rig.add("drive", gb.Torque(tau=1.0)),
    )
    unpacked = unpacker(fmu_export.export(rig, tmp_path / "m.fmu", patience=0.0), tmp_path / "m")
    with Instance(unpacked) as instance:
        instance.start(t0=1.0)
        instance.set(refs_of(unpacked, "end.J"), [1e-60])
        line = instance.refuses(lambda: instance.step(1.0, 1e-3))
        assert "step size fell below rounding" in line
        assert "'end." in line or "'shaft." in line
